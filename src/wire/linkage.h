/* SPDX-License-Identifier: MIT */
/**
 * @file
 * ECT_C_BEGIN and ECT_C_END: C linkage for the declarations between them in a C++ program.
 */
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
