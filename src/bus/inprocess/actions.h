/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals that the library takes: SIGSEGV and SIGBUS for addresses of the program (user.h), SIGSYS for the dispatch of
 * system calls (raw.h). The program's own action of such a signal is stored apart: `sigaction` and `signal` set and
 * return this action, and a signal that does not concern the library runs it.
 */
#ifndef ECT_BUS_INPROCESS_ACTIONS_H
#define ECT_BUS_INPROCESS_ACTIONS_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

/** Handles a signal in the library; calls ::ect_action_run for one that concerns the program. */
typedef void ect_action_t(int number, siginfo_t *info, void *context);

/** The manner in which the handler of a taken signal runs. */
typedef enum ect_manner {
    ECT_AS_PROGRAM, /**< with the mask, the stack and the flags of the program's action */
    ECT_IN_CALL     /**< in the context of a call: on its stack, without a mask; no thread may block the signal */
} ect_manner_t;

/** Installs a handler, and stores the program's action. @return 0; -1: the kernel refuses */
int ect_action_take(int number, ect_action_t *handler, ect_manner_t manner);

/** Restores the program's own action. */
void ect_action_leave(int number);

/** @return whether the library has taken a signal */
bool ect_action_is_taken(int number);

/** Runs the program's own action of a taken signal. Context: the handler. */
void ect_action_run(int number, siginfo_t *info, void *context);

/** Sets and returns the program's own action of a taken signal, like sigaction(2). @param action  NULL: unchanged */
void ect_action_exchange(int number, const struct sigaction *action, struct sigaction *before);

/** @return a signal mask of the kernel without the signals that no thread may block */
uint64_t ect_action_mask(uint64_t mask);

#endif
