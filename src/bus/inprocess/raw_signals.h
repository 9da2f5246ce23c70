/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SIGSYS, which the dispatch of system calls needs: no thread may block it, for the kernel ends a process that does,
 * and the program's own action is kept aside.
 */
#ifndef ECT_BUS_INPROCESS_RAW_SIGNALS_H
#define ECT_BUS_INPROCESS_RAW_SIGNALS_H

#include <signal.h>
#include <stdint.h>

/** Takes SIGSYS with this handler. @return 0; -1: the kernel refuses */
int ect_raw_take_signal(void (*handler)(int number, siginfo_t *info, void *context));

/** Gives SIGSYS back. */
void ect_raw_leave_signal(void);

/** A SIGSYS that is no dispatch: the program's own action. */
void ect_raw_own_signal(int number, siginfo_t *info, void *context);

/** The program's own action of SIGSYS, as sigaction(2) sets and returns it. */
void ect_raw_own_action(const struct sigaction *action, struct sigaction *before);

/** A mask of the kernel without SIGSYS. */
uint64_t ect_raw_mask(uint64_t mask);

#endif
