/* SPDX-License-Identifier: MIT */
/* Clocks and sleeps of the C library on the virtual clock. */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/sanitizer.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"

static int fail(int error)
{
    errno = error;
    return -1;
}

static uint64_t charged_now(const void *caller)
{
    if (ect_sanitizer_has(caller))
        return ect_virtual_pass(ECT_COST_CLOCK_NS);
    ect_virtual_charge(ECT_COST_CLOCK_NS);
    return ect_virtual_now();
}

static int put_time(struct timespec *time, uint64_t time_ns)
{
    const struct timespec its = ect_timespec_of(time_ns);
    return ect_user_write(time, &its, sizeof its) ? 0 : fail(EFAULT);
}

/* Not inlined, because the header excludes the address 0 of a time, and the compiler relies on this. */
static __attribute__((noinline)) bool put_if_wanted(void *to, const void *from, size_t length)
{
    return !to || ect_user_write(to, from, length);
}

/* Processor time remains real: it is a measure of the program, not of the bus. */
REPLACES int clock_gettime(clockid_t clock, struct timespec *time)
{
    if (ect_in_dlsym)
        return put_time(time, ECT_VIRTUAL_START_NS);
    if (ect_inside > 0)
        return REAL(clock_gettime)(clock, time);
    switch (clock) {
    case CLOCK_MONOTONIC:
    case CLOCK_MONOTONIC_RAW:
    case CLOCK_MONOTONIC_COARSE:
    case CLOCK_BOOTTIME:
        return put_time(time, charged_now(__builtin_return_address(0)));
    case CLOCK_REALTIME:
    case CLOCK_REALTIME_COARSE:
    case CLOCK_TAI:
        return put_time(time, charged_now(__builtin_return_address(0)) + ECT_DAY_OFFSET_NS);
    default:
        return REAL(clock_gettime)(clock, time);
    }
}

REPLACES int gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    if (ect_inside > 0)
        return REAL(gettimeofday)(time, zone);
    uint64_t now_ns = charged_now(__builtin_return_address(0)) + ECT_DAY_OFFSET_NS;
    const struct timeval its = {.tv_sec = (time_t)(now_ns / ECT_NS_PER_S),
                                .tv_usec = (suseconds_t)(now_ns % ECT_NS_PER_S / 1000u)};
    const struct timezone utc = {0};
    bool given = put_if_wanted(time, &its, sizeof its) && put_if_wanted(zone, &utc, sizeof utc);
    return given ? 0 : fail(EFAULT);
}

/* Other bases than TIME_UTC, of later C libraries, remain real. */
REPLACES int timespec_get(struct timespec *time, int base)
{
    if (ect_inside > 0 || base != TIME_UTC)
        return REAL(timespec_get)(time, base);
    return clock_gettime(CLOCK_REALTIME, time) == 0 ? base : 0;
}

REPLACES time_t time(time_t *result)
{
    if (ect_inside > 0)
        return REAL(time)(result);
    time_t now = (time_t)((charged_now(__builtin_return_address(0)) + ECT_DAY_OFFSET_NS) / ECT_NS_PER_S);
    return put_if_wanted(result, &now, sizeof now) ? now : (time_t)fail(EFAULT);
}

/* @return the remaining time if a signal handler has ended the sleep; 0: complete */
static uint64_t sleep_until(uint64_t until_ns)
{
    pthread_testcancel();
    ect_wait_t result = ect_virtual_wait(NULL, until_ns);
    pthread_testcancel();
    if (result != ECT_WAIT_INTERRUPTED)
        return 0;
    uint64_t now_ns = ect_virtual_now();
    return until_ns > now_ns ? until_ns - now_ns : 1;
}

REPLACES int usleep(useconds_t microseconds)
{
    if (ect_inside > 0)
        return REAL(usleep)(microseconds);
    if (sleep_until(ect_virtual_now() + microseconds * 1000ull) == 0)
        return 0;
    return fail(EINTR);
}

REPLACES unsigned int sleep(unsigned int seconds)
{
    if (ect_inside > 0)
        return REAL(sleep)(seconds);
    uint64_t left_ns = sleep_until(ect_virtual_now() + seconds * ECT_NS_PER_S);
    return (unsigned int)(left_ns / ECT_NS_PER_S);
}

REPLACES int nanosleep(const struct timespec *time, struct timespec *left)
{
    if (ect_inside > 0)
        return REAL(nanosleep)(time, left);
    struct timespec its;
    if (!ect_user_read(&its, time, sizeof its))
        return fail(EFAULT);
    if (!ect_is_time(&its))
        return fail(EINVAL);
    uint64_t left_ns = sleep_until(ect_deadline_in(&its));
    if (left_ns == 0 || (left && put_time(left, left_ns) != 0))
        return left_ns == 0 ? 0 : -1;
    return fail(EINTR);
}

REPLACES int clock_nanosleep(clockid_t clock, int flags, const struct timespec *time, struct timespec *left)
{
    if (ect_inside > 0)
        return REAL(clock_nanosleep)(clock, flags, time, left);
    struct timespec its;
    if (!ect_user_read(&its, time, sizeof its))
        return EFAULT;
    if (!ect_is_time(&its))
        return EINVAL;
    bool absolute = (flags & TIMER_ABSTIME) != 0;
    uint64_t left_ns = sleep_until(absolute ? ect_deadline_on(clock, &its) : ect_deadline_in(&its));
    if (left_ns > 0 && left && !absolute && put_time(left, left_ns) != 0)
        return EFAULT;
    return left_ns > 0 ? EINTR : 0;
}

REPLACES int sched_yield(void)
{
    if (ect_inside > 0)
        return REAL(sched_yield)();
    ect_virtual_yield();
    return 0;
}
