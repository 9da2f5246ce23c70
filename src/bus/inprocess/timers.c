/* SPDX-License-Identifier: MIT */
/* POSIX timers, interval timers and alarm() on the virtual clock. Timers of processor time remain real. */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/user.h"

typedef struct posix_timer {
    ect_timer_t timer; /* first */
    struct posix_timer *next;
    clockid_t clock;
    ect_signal_t signal;
    pid_t to; /* 0: the process */
    int overruns;
    /* SIGEV_THREAD */
    void (*notify)(union sigval value);
    union sigval value;
    unsigned int expiries;
    bool deleted;
} posix_timer_t;

static posix_timer_t *posix_timers; /* changed only by the thread with the turn */

static void send_signal(ect_timer_t *timer)
{
    posix_timer_t *its = (posix_timer_t *)timer;
    its->overruns = ect_virtual_send(&its->signal, its->to) ? 0 : its->overruns + 1;
    its->signal.info.si_overrun = 0;
}

static void count(ect_timer_t *timer)
{
    posix_timer_t *its = (posix_timer_t *)timer;
    its->expiries++;
    ect_virtual_expired(its);
}

static void nothing(ect_timer_t *timer)
{
    (void)timer;
}

static void *notify(void *arg)
{
    posix_timer_t *its = arg;
    while (!its->deleted) {
        if (its->expiries == 0) {
            (void)ect_virtual_wait(its, UINT64_MAX);
            continue;
        }
        its->expiries--;
        its->notify(its->value);
    }
    free(its);
    return NULL;
}

/* Starts the thread for all expiries of a timer. */
static int start_thread(posix_timer_t *its)
{
    pthread_t thread;
    pthread_attr_t detached;
    pthread_attr_init(&detached);
    pthread_attr_setdetachstate(&detached, PTHREAD_CREATE_DETACHED);
    int error = pthread_create(&thread, &detached, notify, its); /* the replacement */
    pthread_attr_destroy(&detached);
    return error;
}

static bool set_up(posix_timer_t *its, struct sigevent *event)
{
    switch (event->sigev_notify) {
    case SIGEV_NONE:
        its->timer.expired = nothing;
        return true;
    case SIGEV_THREAD:
        its->timer.expired = count;
        its->notify = event->sigev_notify_function;
        its->value = event->sigev_value;
        return start_thread(its) == 0;
    default:
        its->timer.expired = send_signal;
        its->to = event->sigev_notify == SIGEV_THREAD_ID ? event->_sigev_un._tid : 0;
        its->signal.info.si_signo = event->sigev_signo;
        its->signal.info.si_code = SI_TIMER;
        its->signal.info.si_value = event->sigev_value;
        return true;
    }
}

static int fail(int error)
{
    errno = error;
    return -1;
}

REPLACES int timer_create(clockid_t clock, struct sigevent *restrict event, timer_t *restrict timer)
{
    bool of_processor = clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID || clock < 0;
    if (ect_inside > 0 || of_processor)
        return REAL(timer_create)(clock, event, timer);
    posix_timer_t *its = calloc(1, sizeof *its);
    struct sigevent how = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGALRM, .sigev_value.sival_ptr = its};
    const timer_t name = its;
    (void)ect_virtual_now(); /* takes the turn */
    if (its)
        *its = (posix_timer_t){.timer.next_ns = UINT64_MAX, .clock = clock};
    bool good = (!event || ect_user_read(&how, event, sizeof how)) && ect_user_write(timer, &name, sizeof name);
    if (!its || !good || !set_up(its, &how)) {
        free(its);
        return fail(good ? EAGAIN : EFAULT);
    }
    ect_virtual_add_timer(&its->timer);
    its->next = posix_timers;
    posix_timers = its;
    return 0;
}

static posix_timer_t **place_of(timer_t timer)
{
    posix_timer_t **at = &posix_timers;
    if (ect_inside == 0)
        (void)ect_virtual_now();
    while (*at && (timer_t)*at != timer)
        at = &(*at)->next;
    return at;
}

REPLACES int timer_delete(timer_t timer)
{
    posix_timer_t **at = place_of(timer);
    posix_timer_t *its = *at;
    if (!its)
        return REAL(timer_delete)(timer);
    *at = its->next;
    ect_virtual_remove_timer(&its->timer);
    ect_virtual_recall(&its->signal);
    its->deleted = true;
    if (its->notify)
        (void)ect_virtual_wake(its, 1); /* freed by its thread */
    else
        free(its);
    return 0;
}

REPLACES int timer_gettime(timer_t timer, struct itimerspec *value)
{
    const posix_timer_t *its = *place_of(timer);
    if (!its)
        return REAL(timer_gettime)(timer, value);
    const struct itimerspec left = ect_timer_left(&its->timer);
    return ect_user_write(value, &left, sizeof left) ? 0 : fail(EFAULT);
}

REPLACES int timer_settime(timer_t timer, int flags, const struct itimerspec *restrict value,
                           struct itimerspec *restrict before)
{
    posix_timer_t *its = *place_of(timer);
    if (!its)
        return REAL(timer_settime)(timer, flags, value, before);
    struct itimerspec set;
    if (!ect_user_read(&set, value, sizeof set))
        return fail(EFAULT);
    if (!ect_is_time(&set.it_value) || !ect_is_time(&set.it_interval))
        return fail(EINVAL);
    const struct itimerspec left = ect_timer_left(&its->timer);
    ect_timer_set(&its->timer, its->clock, (flags & TIMER_ABSTIME) != 0, &set);
    return !before || ect_user_write(before, &left, sizeof left) ? 0 : fail(EFAULT);
}

REPLACES int timer_getoverrun(timer_t timer)
{
    const posix_timer_t *its = *place_of(timer);
    return its ? its->overruns : REAL(timer_getoverrun)(timer);
}

/* --- the timer of setitimer and alarm ------------------------------------------------------------------------------
 */

static void send_alarm(ect_timer_t *timer);

static ect_timer_t alarm_timer = {.next_ns = UINT64_MAX, .expired = send_alarm};
static ect_signal_t alarm_signal = {.info = {.si_signo = SIGALRM, .si_code = SI_KERNEL}};

static void send_alarm(ect_timer_t *timer)
{
    (void)timer;
    (void)ect_virtual_send(&alarm_signal, 0);
}

/* A running timer never returns 0, which means a stopped timer. */
static struct timeval as_timeval(uint64_t time_ns)
{
    uint64_t time_us = time_ns / 1000 + (time_ns % 1000 > 0);
    return (struct timeval){.tv_sec = (time_t)(time_us / 1000000), .tv_usec = (suseconds_t)(time_us % 1000000)};
}

static struct itimerval alarm_left(void)
{
    struct itimerspec left = ect_timer_left(&alarm_timer);
    return (struct itimerval){.it_value = as_timeval(ect_ns_of(&left.it_value)),
                              .it_interval = as_timeval(ect_ns_of(&left.it_interval))};
}

REPLACES int getitimer(__itimer_which_t which, struct itimerval *value)
{
    if (ect_inside > 0 || which != ITIMER_REAL)
        return REAL(getitimer)(which, value);
    const struct itimerval left = alarm_left();
    return ect_user_write(value, &left, sizeof left) ? 0 : fail(EFAULT);
}

static bool is_timeval(const struct timeval *time)
{
    return time->tv_sec >= 0 && time->tv_usec >= 0 && time->tv_usec < 1000000;
}

REPLACES int setitimer(__itimer_which_t which, const struct itimerval *restrict value,
                       struct itimerval *restrict before)
{
    if (ect_inside > 0 || which != ITIMER_REAL)
        return REAL(setitimer)(which, value, before);
    struct itimerval set = {0};
    if (value && !ect_user_read(&set, value, sizeof set))
        return fail(EFAULT);
    if (!is_timeval(&set.it_value) || !is_timeval(&set.it_interval))
        return fail(EINVAL);
    const struct itimerval left = alarm_left();
    const struct itimerspec spec = {.it_value = ect_timespec_of(ect_ns_of_timeval(&set.it_value)),
                                    .it_interval = ect_timespec_of(ect_ns_of_timeval(&set.it_interval))};
    ect_virtual_remove_timer(&alarm_timer);
    ect_timer_set(&alarm_timer, CLOCK_MONOTONIC, false, &spec);
    ect_virtual_add_timer(&alarm_timer);
    return !before || ect_user_write(before, &left, sizeof left) ? 0 : fail(EFAULT);
}

REPLACES unsigned int alarm(unsigned int seconds)
{
    struct itimerval before;
    const struct itimerval value = {.it_value.tv_sec = (time_t)seconds};
    if (ect_inside > 0)
        return REAL(alarm)(seconds);
    (void)setitimer(ITIMER_REAL, &value, &before);
    return (unsigned int)(before.it_value.tv_sec + (before.it_value.tv_usec > 0));
}

/* The child of fork() has no timers. */
static void in_child(void)
{
    posix_timers = NULL;
    alarm_timer.next_ns = UINT64_MAX;
    alarm_signal.waits = false;
}

__attribute__((constructor)) static void watch_forks(void)
{
    (void)pthread_atfork(NULL, NULL, in_child);
}
