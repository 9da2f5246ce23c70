/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What this process may do on the machine: less once everything is open, and before others if so wished.
 *
 * Context: the only thread of a process, at its start.
 */
#ifndef ECT_BUS_NET_RIGHTS_H
#define ECT_BUS_NET_RIGHTS_H

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_RIGHTS_MESSAGE = 512, ECT_RIGHTS_LOWEST = 1, ECT_RIGHTS_HIGHEST = 99 };

/** What to keep, ORed. */
typedef enum ect_rights {
    ECT_RIGHTS_LINK = 1,     /**< CAP_NET_ADMIN: to take an interface down again */
    ECT_RIGHTS_CHILDREN = 2, /**< to find, signal and await other processes */
    ECT_RIGHTS_FILES = 4,    /**< to open files for writing, and to rename them */
} ect_rights_t;

/**
 * Gives up, for good, every right that running twins do not need: capabilities, also those that a program started from
 * here could get (no_new_privs), and, where ectwin was built with libseccomp, every system call but those of the loop.
 * After that no file can be opened for writing (but with ECT_RIGHTS_FILES), no connection made, no program started.
 * @param keep          ORed ect_rights_t
 * @param[out] message  on failure one line for the user; ECT_RIGHTS_MESSAGE bytes
 * @return 0 · -1 some of it was not possible; the rest has been done
 */
int ect_rights_drop(unsigned int keep, char *message);

/**
 * Lets this process, but none that it starts, run before all ordinary ones (SCHED_FIFO), and keeps the memory that it
 * has from being swapped out. Call it when all is allocated, and before a user namespace is entered: rights in there do
 * not count for this.
 * @param priority      ECT_RIGHTS_LOWEST..ECT_RIGHTS_HIGHEST
 * @param[out] message  on failure one line for the user: which right is missing and how to get it; ECT_RIGHTS_MESSAGE
 *                      bytes
 * @return 0, or -1
 */
int ect_rights_realtime(int priority, char *message);

ECT_C_END

#endif
