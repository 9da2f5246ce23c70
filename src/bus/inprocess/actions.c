/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/actions.h"

#include <errno.h>
#include <pthread.h>
#include <stddef.h>
#include <string.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include "bus/inprocess/real.h"

typedef struct taken {
    int number;
    ect_action_t *handler; /* NULL: not taken */
    ect_manner_t manner;
    struct sigaction own; /* the program's action */
} taken_t;

/* Found early: a handler may have interrupted dlsym(). */
static __typeof__(&sigaction) set_action;
static __typeof__(&syscall) make_call;

static taken_t signals[] = {{.number = SIGSEGV}, {.number = SIGBUS}, {.number = SIGSYS}};

static void find_functions(void)
{
    set_action = REAL(sigaction);
    make_call = REAL(syscall);
}

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
    find_functions();
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

static void exchange(int number, const struct sigaction *action, struct sigaction *before)
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

/* --- deferred handlers ---------------------------------------------------------------------------------------------
 */

enum { KERNEL_MASK = 8 }; /* length of a signal mask of the kernel, which has no more in a signal frame */
enum { SIGNALS = 65 };

/* The parts of the program's action that differ from the kernel's. */
typedef struct kept {
    ect_action_t *handler;
    int flags; /* SA_SIGINFO, SA_RESETHAND */
} kept_t;

#define KEPT_FLAGS (SA_SIGINFO | (int)SA_RESETHAND)

static kept_t kept[SIGNALS];
static __thread volatile int holds __attribute__((tls_model("initial-exec")));
static __thread volatile sig_atomic_t deferred __attribute__((tls_model("initial-exec")));
static __thread uint64_t mask_before __attribute__((tls_model("initial-exec"))); /* the deferred signal */
static __thread ect_handled_t handled __attribute__((tls_model("initial-exec")));

/* Signals that a thread causes by an instruction or by abort(), and those of the C library: never deferred. */
static uint64_t urgent(void)
{
    static const int numbers[] = {SIGSEGV, SIGBUS, SIGSYS, SIGILL, SIGFPE, SIGTRAP, SIGABRT, 32, 33};
    uint64_t mask = 0;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        mask |= 1ull << (numbers[i] - 1);
    return mask;
}

void ect_action_hold(void)
{
    holds++;
}

void ect_action_release(void)
{
    if (--holds > 0 || !deferred)
        return;
    deferred = false;
    (void)make_call(SYS_rt_sigprocmask, SIG_SETMASK, &mask_before, NULL, KERNEL_MASK, 0, 0);
}

void ect_action_watch(void)
{
    handled = (ect_handled_t){.restarts = true};
}

ect_handled_t ect_action_handled(void)
{
    return handled;
}

/* Leaves the signal pending: the interrupted context gets a mask that blocks all. If the kernel has begun several
 * handlers at once, the last of these contexts to end is that of the thread, with the right mask. */
static void defer(int number, siginfo_t *info, ucontext_t *at)
{
    const int error = errno;
    const uint64_t all = ~urgent();
    memcpy(&mask_before, &at->uc_sigmask, sizeof mask_before);
    memcpy(&at->uc_sigmask, &all, sizeof all);
    deferred = true;
    (void)make_call(SYS_rt_tgsigqueueinfo, getpid(), gettid(), number, info, 0, 0);
    errno = error;
}

/* Not instrumented: the handler may run on any stack. */
__attribute__((no_sanitize("address"))) static void on_signal(int number, siginfo_t *info, void *context)
{
    const struct sigaction none = {.sa_handler = SIG_DFL};
    const ect_handled_t before = handled;
    struct sigaction action;
    if (holds > 0 && (urgent() & 1ull << (number - 1)) == 0) {
        defer(number, info, context);
        return;
    }
    const kept_t its = kept[number];
    bool restarts = set_action(number, NULL, &action) == 0 && (action.sa_flags & SA_RESTART) != 0;
    if ((its.flags & (int)SA_RESETHAND) != 0)
        (void)set_action(number, &none, NULL);
    its.handler(number, info, context);
    handled = (ect_handled_t){.count = before.count + 1, .restarts = before.restarts && restarts};
}

static bool has_handler(const struct sigaction *action)
{
    return action->sa_handler != SIG_DFL && action->sa_handler != SIG_IGN && action->sa_sigaction != on_signal;
}

/* Replaces the handler that the program has just set. SA_RESETHAND is left to on_signal(), because a deferred signal is
 * handled twice. */
static void wrap(int number)
{
    struct sigaction its;
    find_functions();
    if (set_action(number, NULL, &its) != 0 || !has_handler(&its))
        return;
    kept[number] = (kept_t){.handler = its.sa_sigaction, .flags = its.sa_flags & KEPT_FLAGS};
    its.sa_sigaction = on_signal;
    its.sa_flags = (its.sa_flags & ~KEPT_FLAGS) | SA_SIGINFO;
    (void)set_action(number, &its, NULL);
}

int ect_action_set(int number, const struct sigaction *action, struct sigaction *before)
{
    if (ect_action_is_taken(number)) {
        exchange(number, action, before);
        return 0;
    }
    struct sigaction its, was;
    if (action) {
        its = *action;
        if (must_arrive(SIGSYS))
            sigdelset(&its.sa_mask, SIGSYS);
    }
    if (REAL(sigaction)(number, action ? &its : NULL, &was) != 0)
        return -1;
    if (was.sa_sigaction == on_signal) {
        was.sa_sigaction = kept[number].handler;
        was.sa_flags = (was.sa_flags & ~KEPT_FLAGS) | kept[number].flags;
    }
    if (action && ect_inside == 0)
        wrap(number);
    if (before)
        *before = was;
    return 0;
}

/* --- the functions of the C library --------------------------------------------------------------------------------
 */

REPLACES int sigaction(int number, const struct sigaction *restrict action, struct sigaction *restrict before)
{
    return ect_action_set(number, action, before);
}

/* @return the previous handler, as signal(2) does */
static __sighandler_t set_handler(int number, struct sigaction action)
{
    struct sigaction before;
    if (action.sa_handler == SIG_ERR) {
        errno = EINVAL;
        return SIG_ERR;
    }
    exchange(number, &action, &before);
    return before.sa_handler;
}

/* @param set  the real function, which knows siginterrupt(3) */
static __sighandler_t set_by(int number, __sighandler_t handler, __typeof__(&signal) set)
{
    ect_action_t *own = number > 0 && number < SIGNALS ? kept[number].handler : NULL;
    __sighandler_t before = set(number, handler);
    if (before == SIG_ERR || ect_inside > 0)
        return before;
    wrap(number);
    return before == (__sighandler_t)(void (*)(void))on_signal ? (__sighandler_t)(void (*)(void))own : before;
}

REPLACES __sighandler_t signal(int number, __sighandler_t handler)
{
    if (!ect_action_is_taken(number))
        return set_by(number, handler, REAL(signal));
    struct sigaction action = {.sa_handler = handler, .sa_flags = SA_RESTART};
    sigaddset(&action.sa_mask, number);
    return set_handler(number, action);
}

/* signal() of programs without extensions of the C library (-std=c11). */
REPLACES __sighandler_t __sysv_signal(int number, __sighandler_t handler)
{
    if (!ect_action_is_taken(number))
        return set_by(number, handler, REAL(__sysv_signal));
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
