/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals that the library takes: SIGSEGV and SIGBUS for addresses of the program (user.h), SIGSYS for the dispatch of
 * system calls (raw.h). The program's own action of such a signal is stored apart: `sigaction` and `signal` set and
 * return this action, and a signal that does not concern the library runs it.
 *
 * The handlers of all other signals run by a function of the library, which defers them while their thread has the lock
 * of the bus: a handler may call each function that signal-safety(7) lists. A handler that the program installs without
 * the C library, where its calls are not dispatched, is not deferred.
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

/**
 * Sets and returns the action of any signal, like sigaction(2): of a taken one the program's own, of another one with a
 * handler that is deferred.
 * @return 0; -1 (errno)
 */
int ect_action_set(int number, const struct sigaction *action, struct sigaction *before);

/**
 * Defers the program's handlers in this thread until ::ect_action_release. Calls may be nested. Handlers of faults and
 * of SIGABRT are not deferred.
 */
void ect_action_hold(void);
/** Runs the deferred handlers, unless the hold is nested. */
void ect_action_release(void);

/** Handlers of the program that have run in this thread. */
typedef struct ect_handled {
    unsigned int count;
    bool restarts; /**< each of them has SA_RESTART */
} ect_handled_t;

/** Begins to count the handlers of this thread. A handler's own use of these functions does not change the count. */
void ect_action_watch(void);
/** @return the handlers since ::ect_action_watch */
ect_handled_t ect_action_handled(void);

/** @return a signal mask of the kernel without the signals that no thread may block */
uint64_t ect_action_mask(uint64_t mask);

#endif
