/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The filter of system calls. Two files implement it: sandbox.c with libseccomp, sandbox_none.c without.
 */
#ifndef ECT_BUS_NET_SANDBOX_H
#define ECT_BUS_NET_SANDBOX_H

#include <stdbool.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * From here on every thread of the process has only the system calls of a running twin; all others answer ENOSYS.
 * @param children  those to find, signal and await other processes as well
 * @param files     those to open files for writing, and to rename them, as well
 * @return 0, also when ectwin was built without the filter · -1 the kernel refuses it (errno)
 */
int ect_sandbox_enter(bool children, bool files);

ECT_C_END

#endif
