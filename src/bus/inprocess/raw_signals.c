/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/raw_signals.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>

#include "bus/inprocess/real.h"

static bool taken;
static struct sigaction own; /* the program's action */

int ect_raw_take_signal(void (*handler)(int number, siginfo_t *info, void *context))
{
    /* No mask and no SA_ONSTACK: the handler runs in the context of the call, and a nested handler of the program may
     * make system calls. */
    const struct sigaction action = {.sa_sigaction = handler, .sa_flags = SA_SIGINFO | SA_NODEFER | SA_RESTART};
    sigset_t only;
    if (REAL(sigaction)(SIGSYS, &action, &own) != 0)
        return -1;
    taken = true;
    sigemptyset(&only);
    sigaddset(&only, SIGSYS);
    return REAL(pthread_sigmask)(SIG_UNBLOCK, &only, NULL);
}

void ect_raw_leave_signal(void)
{
    (void)REAL(sigaction)(SIGSYS, &own, NULL);
    taken = false;
}

void ect_raw_own_signal(int number, siginfo_t *info, void *context)
{
    if ((own.sa_flags & SA_SIGINFO) != 0) {
        own.sa_sigaction(number, info, context);
    } else if (own.sa_handler == SIG_DFL) {
        const struct sigaction end = {.sa_handler = SIG_DFL};
        (void)REAL(sigaction)(number, &end, NULL);
        (void)raise(number);
    } else if (own.sa_handler != SIG_IGN) {
        own.sa_handler(number);
    }
}

void ect_raw_own_action(const struct sigaction *action, struct sigaction *before)
{
    const struct sigaction its = own;
    if (action)
        own = *action;
    if (before)
        *before = its;
}

uint64_t ect_raw_mask(uint64_t mask)
{
    return taken ? mask & ~(1ull << (SIGSYS - 1)) : mask;
}

REPLACES int sigaction(int number, const struct sigaction *restrict action, struct sigaction *restrict before)
{
    if (!taken)
        return REAL(sigaction)(number, action, before);
    if (number == SIGSYS) {
        ect_raw_own_action(action, before);
        return 0;
    }
    struct sigaction its;
    if (action) {
        its = *action;
        sigdelset(&its.sa_mask, SIGSYS);
    }
    return REAL(sigaction)(number, action ? &its : NULL, before);
}

REPLACES __sighandler_t signal(int number, __sighandler_t handler)
{
    if (!taken || number != SIGSYS)
        return REAL(signal)(number, handler);
    const struct sigaction action = {.sa_handler = handler, .sa_flags = SA_RESTART};
    struct sigaction before;
    ect_raw_own_action(&action, &before);
    return before.sa_handler;
}

static const sigset_t *without(int how, const sigset_t *set, sigset_t *its)
{
    if (!taken || !set || how == SIG_UNBLOCK)
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
