/* SPDX-License-Identifier: MIT */
/** @file What stands between ECT_C_BEGIN and ECT_C_END has the linkage of C, for a program in C++ too. */
#ifndef ECT_WIRE_LINKAGE_H
#define ECT_WIRE_LINKAGE_H

#ifdef __cplusplus
#define ECT_C_BEGIN extern "C" {
#define ECT_C_END   }
#else
#define ECT_C_BEGIN
#define ECT_C_END
#endif

#endif
