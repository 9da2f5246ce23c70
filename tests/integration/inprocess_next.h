/* SPDX-License-Identifier: MIT */
/** @file
 * The next definition of waitpid() behind that of ectwin: a function that the dynamic linker chooses when it finds it.
 */
#ifndef INPROCESS_NEXT_H
#define INPROCESS_NEXT_H

#include <signal.h>

/** The dynamic linker searches now: a SIGCHLD has been sent, and system calls without the C library been made. */
extern volatile sig_atomic_t next_is_searched;
/** Number of searches. */
extern volatile sig_atomic_t next_searches;
/** Searches in which a system call has changed the clock that is read. */
extern volatile sig_atomic_t next_clocks;

#endif
