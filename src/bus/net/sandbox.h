/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The filter of system calls: sandbox.c with libseccomp, sandbox_none.c without.
 */
#ifndef ECT_BUS_NET_SANDBOX_H
#define ECT_BUS_NET_SANDBOX_H

#include <stdbool.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Permanently limits every thread of the process to the system calls of a running twin; all others fail with ENOSYS.
 * @param children  true: also those that signal and await other processes
 * @param files     true: also those that open files for writing and rename them
 * @param client    true: also those that find local stream sockets and connect to them
 * @return 0, also when ectwin was built without the filter · -1: the kernel refuses the filter (errno)
 */
int ect_sandbox_enter(bool children, bool files, bool client);

ECT_C_END

#endif
