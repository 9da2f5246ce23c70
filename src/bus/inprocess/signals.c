/* SPDX-License-Identifier: MIT */
/* Waits for signals on the virtual clock. */
#define _GNU_SOURCE
#include "bus/inprocess/signals.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/user.h"

static int fail(int error)
{
    errno = error;
    return -1;
}

/* @return whether a signal is pending that is not in the mask */
static bool is_due(const sigset_t *mask)
{
    sigset_t pending;
    bool due = false;
    sigpending(&pending);
    for (int number = 1; number <= SIGRTMAX; number++)
        due |= sigismember(&pending, number) == 1 && sigismember(mask, number) == 0;
    return due;
}

/* Copies a mask of the program, which is as long as that of the kernel: that of a direct system call is not longer. */
static bool read_mask(sigset_t *to, const sigset_t *from)
{
    sigemptyset(to);
    return ect_user_read(to, from, (size_t)(SIGRTMAX + 7) / 8);
}

int ect_signals_mask(const sigset_t *mask, sigset_t *before)
{
    sigset_t its;
    if (!mask)
        return 0;
    bool good = read_mask(&its, mask);
    bool due = good && is_due(&its);
    pthread_sigmask(SIG_SETMASK, good ? &its : NULL, before);
    if (!good)
        return fail(EFAULT);
    return due ? fail(EINTR) : 0;
}

void ect_signals_unmask(const sigset_t *mask, const sigset_t *before)
{
    int error = errno;
    if (mask)
        pthread_sigmask(SIG_SETMASK, before, NULL);
    errno = error;
}

static bool has_ended_child(void)
{
    siginfo_t info = {0};
    return REAL(waitid)(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
}

static bool handles_ends_of_children(void)
{
    struct sigaction action;
    sigset_t mask;
    sigaction(SIGCHLD, NULL, &action);
    pthread_sigmask(SIG_BLOCK, NULL, &mask);
    return action.sa_handler != SIG_DFL && action.sa_handler != SIG_IGN && sigismember(&mask, SIGCHLD) == 0;
}

/* The condition is separate, because the handler of SIGCHLD may run while the thread does not sleep. */
static bool child_has_ended(void *arg)
{
    const bool *before = arg;
    return !*before && has_ended_child();
}

static bool never(void *unused)
{
    (void)unused;
    return false;
}

/* @param ended  true: a child had ended before the call */
static int wait_for_handler(const char *call, bool ended)
{
    (void)ect_virtual_wait_until(handles_ends_of_children() ? child_has_ended : never, &ended, call, UINT64_MAX);
    return fail(EINTR);
}

REPLACES int pause(void)
{
    return ect_inside > 0 ? REAL(pause)() : wait_for_handler("pause()", has_ended_child());
}

REPLACES int sigsuspend(const sigset_t *mask)
{
    if (ect_inside > 0)
        return REAL(sigsuspend)(mask);
    sigset_t its, before;
    if (!read_mask(&its, mask))
        return fail(EFAULT);
    bool ended = has_ended_child(); /* before setting the mask: a later end ends the wait */
    if (ect_signals_mask(&its, &before) == 0)
        (void)wait_for_handler("sigsuspend()", ended);
    ect_signals_unmask(&its, &before);
    return -1;
}

typedef struct accepted {
    sigset_t set;
    siginfo_t info;
    int number;
} accepted_t;

static bool accept_now(void *arg)
{
    static const struct timespec none = {0};
    accepted_t *its = arg;
    its->number = REAL(sigtimedwait)(&its->set, &its->info, &none);
    return its->number > 0;
}

/* @return the number of the signal; -1 (errno) */
static int accept_until(const sigset_t *set, siginfo_t *info, const char *call, uint64_t until_ns)
{
    accepted_t its;
    if (!read_mask(&its.set, set))
        return fail(EFAULT);
    if (!accept_now(&its)) {
        ect_wait_t result = ect_virtual_wait_until(accept_now, &its, call, until_ns);
        if (result != ECT_WAIT_WOKEN)
            return fail(result == ECT_WAIT_TIMED_OUT ? EAGAIN : EINTR);
    }
    return !info || ect_user_write(info, &its.info, sizeof its.info) ? its.number : fail(EFAULT);
}

REPLACES int sigtimedwait(const sigset_t *restrict set, siginfo_t *restrict info,
                          const struct timespec *restrict timeout)
{
    if (ect_inside > 0)
        return REAL(sigtimedwait)(set, info, timeout);
    struct timespec span;
    if (timeout && !ect_user_read(&span, timeout, sizeof span))
        return fail(EFAULT);
    if (timeout && !ect_is_time(&span))
        return fail(EINVAL);
    return accept_until(set, info, "sigtimedwait()", ect_deadline_in(timeout ? &span : NULL));
}

REPLACES int sigwaitinfo(const sigset_t *restrict set, siginfo_t *restrict info)
{
    if (ect_inside > 0)
        return REAL(sigwaitinfo)(set, info);
    return accept_until(set, info, "sigwaitinfo()", UINT64_MAX);
}

REPLACES int sigwait(const sigset_t *restrict set, int *restrict number)
{
    if (ect_inside > 0)
        return REAL(sigwait)(set, number);
    int accepted;
    do
        accepted = accept_until(set, NULL, "sigwait()", UINT64_MAX);
    while (accepted < 0 && errno == EINTR);
    if (accepted > 0 && !ect_user_write(number, &accepted, sizeof accepted))
        return EFAULT;
    return accepted > 0 ? 0 : errno;
}
