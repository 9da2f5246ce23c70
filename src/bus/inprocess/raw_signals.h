/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SIGSYS for the dispatch of system calls. No thread may block SIGSYS, because the kernel would end the process; the
 * program's own action is stored separately.
 */
#ifndef ECT_BUS_INPROCESS_RAW_SIGNALS_H
#define ECT_BUS_INPROCESS_RAW_SIGNALS_H

#include <signal.h>
#include <stdint.h>

/** Installs the handler of the dispatch. @return 0; -1: the kernel refuses */
int ect_raw_take_signal(void (*handler)(int number, siginfo_t *info, void *context));

/** Restores the program's own action. */
void ect_raw_leave_signal(void);

/** Runs the program's own action for a SIGSYS with another cause than the dispatch. */
void ect_raw_own_signal(int number, siginfo_t *info, void *context);

/** Sets and returns the program's own action of SIGSYS, like sigaction(2). */
void ect_raw_own_action(const struct sigaction *action, struct sigaction *before);

/** @return a signal mask of the kernel without SIGSYS */
uint64_t ect_raw_mask(uint64_t mask);

#endif
