/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The rights of this process on the machine: most are dropped; real-time priority on request.
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
 * Drops, irrevocably, every right that running twins do not need: capabilities, including those that a program started
 * by this process could gain (no_new_privs), and, if ectwin was built with libseccomp, every system call except those
 * of the loop. Afterwards no file can be opened for writing (except with ECT_RIGHTS_FILES), no connection be made
 * (except with ECT_RIGHTS_CLIENT), no program be started.
 * @param keep          ORed ect_rights_t
 * @param[out] message  on failure one line for the user; ECT_RIGHTS_MESSAGE bytes
 * @return 0 · -1: a step has failed; the other steps are done
 */
int ect_rights_drop(unsigned int keep, char *message);

/**
 * Gives this process, but not its children, real-time priority (SCHED_FIFO), and locks its memory with 512 KB of stack.
 * Due after the last large allocation, and before a user namespace is entered, because the rights there do not apply.
 * @param priority      ECT_RIGHTS_LOWEST..ECT_RIGHTS_HIGHEST
 * @param[out] message  on failure one line for the user, cause and cure; ECT_RIGHTS_MESSAGE bytes
 * @return 0, or -1
 */
int ect_rights_realtime(int priority, char *message);

ECT_C_END

#endif
