/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/actions.h"

#include <errno.h>
#include <pthread.h>
#include <stddef.h>

#include "bus/inprocess/real.h"

typedef struct taken {
    int number;
    ect_action_t *handler; /* NULL: not taken */
    ect_manner_t manner;
    struct sigaction own; /* the program's action */
} taken_t;

static __typeof__(&sigaction) set_action; /* found early: a handler may have interrupted dlsym() */

static taken_t signals[] = {{.number = SIGSEGV}, {.number = SIGBUS}, {.number = SIGSYS}};

/* @return the taken signal; NULL: not taken */
static taken_t *taken_of(int number)
{
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
        if (signals[i].number == number && signals[i].handler)
            return &signals[i];
    }
    return NULL;
}

bool ect_action_is_taken(int number)
{
    return taken_of(number) != NULL;
}

/* @return whether no thread may block the signal */
static bool must_arrive(int number)
{
    const taken_t *its = taken_of(number);
    return its && its->manner == ECT_IN_CALL;
}

/* SIGSYS has no mask and no SA_ONSTACK: the handler runs in the context of the call, and a nested handler of the
 * program may make system calls. SA_RESETHAND is left to ect_action_run(), because the library keeps its handler. */
static int install(const taken_t *its)
{
    struct sigaction action = {.sa_flags = SA_NODEFER | SA_RESTART};
    if (its->manner == ECT_AS_PROGRAM)
        action = its->own;
    if (must_arrive(SIGSYS))
        sigdelset(&action.sa_mask, SIGSYS);
    action.sa_sigaction = its->handler;
    action.sa_flags = (action.sa_flags & ~(int)SA_RESETHAND) | SA_SIGINFO;
    return set_action(its->number, &action, NULL);
}

static void unblock(int number)
{
    sigset_t only;
    sigemptyset(&only);
    sigaddset(&only, number);
    (void)REAL(pthread_sigmask)(SIG_UNBLOCK, &only, NULL);
}

int ect_action_take(int number, ect_action_t *handler, ect_manner_t manner)
{
    taken_t *its = signals;
    while (its->number != number)
        its++;
    set_action = REAL(sigaction);
    if (set_action(number, NULL, &its->own) != 0)
        return -1;
    its->manner = manner;
    its->handler = handler;
    if (install(its) != 0) {
        its->handler = NULL;
        return -1;
    }
    if (manner == ECT_IN_CALL)
        unblock(number);
    return 0;
}

void ect_action_leave(int number)
{
    taken_t *its = taken_of(number);
    (void)set_action(number, &its->own, NULL);
    its->handler = NULL;
}

/* Ends the process by the signal. A fault repeats itself after the handler, with the registers that a core file shall
 * have. */
static void end_process(int number, bool repeats)
{
    const struct sigaction end = {.sa_handler = SIG_DFL};
    (void)set_action(number, &end, NULL);
    if (!repeats)
        (void)raise(number);
}

void ect_action_run(int number, siginfo_t *info, void *context)
{
    taken_t *its = taken_of(number);
    const struct sigaction own = its->own;
    bool forced = info->si_code > 0; /* by an instruction or a call of the thread: cannot be ignored */
    if ((own.sa_flags & (int)SA_RESETHAND) != 0)
        its->own.sa_handler = SIG_DFL;
    if (own.sa_handler == SIG_DFL || (own.sa_handler == SIG_IGN && forced))
        end_process(number, forced && number != SIGSYS);
    else if (own.sa_handler != SIG_IGN && (own.sa_flags & SA_SIGINFO) != 0)
        own.sa_sigaction(number, info, context);
    else if (own.sa_handler != SIG_IGN)
        own.sa_handler(number);
}

void ect_action_exchange(int number, const struct sigaction *action, struct sigaction *before)
{
    taken_t *its = taken_of(number);
    const struct sigaction own = its->own;
    if (action) {
        its->own = *action;
        if (its->manner == ECT_AS_PROGRAM)
            (void)install(its);
    }
    if (before)
        *before = own;
}

uint64_t ect_action_mask(uint64_t mask)
{
    return must_arrive(SIGSYS) ? mask & ~(1ull << (SIGSYS - 1)) : mask;
}

/* --- the functions of the C library --------------------------------------------------------------------------------
 */

REPLACES int sigaction(int number, const struct sigaction *restrict action, struct sigaction *restrict before)
{
    if (ect_action_is_taken(number)) {
        ect_action_exchange(number, action, before);
        return 0;
    }
    struct sigaction its;
    if (!action || !must_arrive(SIGSYS))
        return REAL(sigaction)(number, action, before);
    its = *action;
    sigdelset(&its.sa_mask, SIGSYS);
    return REAL(sigaction)(number, &its, before);
}

/* @return the previous handler, as signal(2) does */
static __sighandler_t set_handler(int number, struct sigaction action)
{
    struct sigaction before;
    if (action.sa_handler == SIG_ERR) {
        errno = EINVAL;
        return SIG_ERR;
    }
    ect_action_exchange(number, &action, &before);
    return before.sa_handler;
}

REPLACES __sighandler_t signal(int number, __sighandler_t handler)
{
    if (!ect_action_is_taken(number))
        return REAL(signal)(number, handler);
    struct sigaction action = {.sa_handler = handler, .sa_flags = SA_RESTART};
    sigaddset(&action.sa_mask, number);
    return set_handler(number, action);
}

/* signal() of programs without extensions of the C library (-std=c11). */
REPLACES __sighandler_t __sysv_signal(int number, __sighandler_t handler)
{
    if (!ect_action_is_taken(number))
        return REAL(__sysv_signal)(number, handler);
    return set_handler(number, (struct sigaction){.sa_handler = handler, .sa_flags = (int)SA_RESETHAND | SA_NODEFER});
}

/* Other names of the same functions. */
REPLACES __sighandler_t sysv_signal(int number, __sighandler_t handler)
{
    return __sysv_signal(number, handler);
}

REPLACES __sighandler_t ssignal(int number, __sighandler_t handler)
{
    return signal(number, handler);
}

__sighandler_t bsd_signal(int number, __sighandler_t handler);
REPLACES __sighandler_t bsd_signal(int number, __sighandler_t handler)
{
    return signal(number, handler);
}

static const sigset_t *without(int how, const sigset_t *set, sigset_t *its)
{
    if (!must_arrive(SIGSYS) || !set || how == SIG_UNBLOCK)
        return set;
    *its = *set;
    sigdelset(its, SIGSYS);
    return its;
}

REPLACES int sigprocmask(int how, const sigset_t *restrict set, sigset_t *restrict before)
{
    sigset_t its;
    return REAL(sigprocmask)(how, without(how, set, &its), before);
}

REPLACES int pthread_sigmask(int how, const sigset_t *set, sigset_t *before)
{
    sigset_t its;
    return REAL(pthread_sigmask)(how, without(how, set, &its), before);
}
