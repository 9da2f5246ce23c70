/* SPDX-License-Identifier: MIT */
/* Clocks and sleeps of the C library on the virtual clock. */
#define _GNU_SOURCE
#include <errno.h>
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

static struct timespec as_timespec(uint64_t time_ns)
{
    return (struct timespec){.tv_sec = (time_t)(time_ns / ECT_NS_PER_S), .tv_nsec = (long)(time_ns % ECT_NS_PER_S)};
}

static uint64_t charged_now(const void *caller)
{
    if (ect_sanitizer_has(caller))
        return ect_virtual_pass(ECT_COST_CLOCK_NS);
    ect_virtual_charge(ECT_COST_CLOCK_NS);
    return ect_virtual_now();
}

/* Processor time stays real: it measures the program, not the bus. */
REPLACES int clock_gettime(clockid_t clock, struct timespec *time)
{
    if (ect_in_dlsym) {
        *time = as_timespec(ECT_VIRTUAL_START_NS);
        return 0;
    }
    if (ect_inside > 0)
        return REAL(clock_gettime)(clock, time);
    switch (clock) {
    case CLOCK_MONOTONIC:
    case CLOCK_MONOTONIC_RAW:
    case CLOCK_MONOTONIC_COARSE:
    case CLOCK_BOOTTIME:
        *time = as_timespec(charged_now(__builtin_return_address(0)));
        return 0;
    case CLOCK_REALTIME:
    case CLOCK_REALTIME_COARSE:
    case CLOCK_TAI:
        *time = as_timespec(charged_now(__builtin_return_address(0)) + ECT_DAY_OFFSET_NS);
        return 0;
    default:
        return REAL(clock_gettime)(clock, time);
    }
}

REPLACES int gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    if (ect_inside > 0)
        return REAL(gettimeofday)(time, zone);
    uint64_t now_ns = charged_now(__builtin_return_address(0)) + ECT_DAY_OFFSET_NS;
    *time = (struct timeval){.tv_sec = (time_t)(now_ns / ECT_NS_PER_S),
                             .tv_usec = (suseconds_t)(now_ns % ECT_NS_PER_S / 1000u)};
    return 0;
}

REPLACES time_t time(time_t *result)
{
    if (ect_inside > 0)
        return REAL(time)(result);
    time_t now = (time_t)((charged_now(__builtin_return_address(0)) + ECT_DAY_OFFSET_NS) / ECT_NS_PER_S);
    if (result)
        *result = now;
    return now;
}

static void sleep_until(uint64_t until_ns)
{
    (void)ect_virtual_wait(NULL, until_ns);
}

REPLACES int usleep(useconds_t microseconds)
{
    if (ect_inside > 0)
        return REAL(usleep)(microseconds);
    sleep_until(ect_virtual_now() + microseconds * 1000ull);
    return 0;
}

REPLACES unsigned int sleep(unsigned int seconds)
{
    if (ect_inside > 0)
        return REAL(sleep)(seconds);
    sleep_until(ect_virtual_now() + seconds * ECT_NS_PER_S);
    return 0;
}

static bool is_valid(const struct timespec *time)
{
    return time->tv_sec >= 0 && time->tv_nsec >= 0 && (uint64_t)time->tv_nsec < ECT_NS_PER_S;
}

REPLACES int nanosleep(const struct timespec *time, struct timespec *left)
{
    if (ect_inside > 0)
        return REAL(nanosleep)(time, left);
    if (!is_valid(time)) {
        errno = EINVAL;
        return -1;
    }
    sleep_until(ect_virtual_now() + ect_ns_of(time));
    return 0;
}

REPLACES int clock_nanosleep(clockid_t clock, int flags, const struct timespec *time, struct timespec *left)
{
    if (ect_inside > 0)
        return REAL(clock_nanosleep)(clock, flags, time, left);
    if (!is_valid(time))
        return EINVAL;
    sleep_until((flags & TIMER_ABSTIME) != 0 ? ect_deadline_on(clock, time) : ect_virtual_now() + ect_ns_of(time));
    return 0;
}

REPLACES int sched_yield(void)
{
    if (ect_inside > 0)
        return REAL(sched_yield)();
    ect_virtual_yield();
    return 0;
}
