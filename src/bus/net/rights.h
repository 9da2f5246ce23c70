/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The rights of this process on the machine: it gives most of them up, and may take real-time priority.
 *
 * Context: the only thread of a process, before the loop starts.
 */
#ifndef ECT_BUS_NET_RIGHTS_H
#define ECT_BUS_NET_RIGHTS_H

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_RIGHTS_MESSAGE = 512, ECT_RIGHTS_LOWEST = 1, ECT_RIGHTS_HIGHEST = 99 };

/** Rights to keep, ORed. */
typedef enum ect_rights {
    ECT_RIGHTS_LINK = 1,     /**< CAP_NET_ADMIN, to take an interface down at the end */
    ECT_RIGHTS_CHILDREN = 2, /**< to signal and await other processes */
    ECT_RIGHTS_FILES = 4,    /**< to open files for writing, and to rename them */
    ECT_RIGHTS_CLIENT = 8,   /**< to find local stream sockets, and to connect to them */
} ect_rights_t;

/**
 * Gives up, for good, every right that running twins do not need: capabilities, also those that a program started from
 * here could get (no_new_privs), and, where ectwin was built with libseccomp, every system call but those of the loop.
 * No file can then be opened for writing (but with ECT_RIGHTS_FILES), no connection made (but with ECT_RIGHTS_CLIENT),
 * no program started.
 * @param keep          ORed ect_rights_t
 * @param[out] message  on failure one line for the user; ECT_RIGHTS_MESSAGE bytes
 * @return 0 · -1: a step was not possible; the others are done
 */
int ect_rights_drop(unsigned int keep, char *message);

/**
 * Gives this process, but no process that it starts, real-time priority (SCHED_FIFO) and locks its memory. To be called
 * after the last large allocation and before a user namespace is entered, whose rights do not count for this.
 * @param priority      ECT_RIGHTS_LOWEST..ECT_RIGHTS_HIGHEST
 * @param[out] message  on failure one line for the user, cause and cure; ECT_RIGHTS_MESSAGE bytes
 * @return 0, or -1
 */
int ect_rights_realtime(int priority, char *message);

ECT_C_END

#endif
