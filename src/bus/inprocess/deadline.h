/* SPDX-License-Identifier: MIT */
/** @file
 * Times of the C library as times of the virtual clock. */
#ifndef ECT_BUS_INPROCESS_DEADLINE_H
#define ECT_BUS_INPROCESS_DEADLINE_H

#include <stdint.h>
#include <sys/time.h>
#include <time.h>

#include "bus/inprocess/threads.h"

#define ECT_NS_PER_S      1000000000ull
#define ECT_DAY_OFFSET_NS (ECT_VIRTUAL_DAY_NS - ECT_VIRTUAL_START_NS)

/** A time in nanoseconds; UINT64_MAX: more than 584 years; 0: before the beginning of the clock. */
static inline uint64_t ect_ns_of(const struct timespec *time)
{
    if (time->tv_sec < 0)
        return 0;
    uint64_t seconds = (uint64_t)time->tv_sec;
    return seconds < UINT64_MAX / ECT_NS_PER_S ? seconds * ECT_NS_PER_S + (uint64_t)time->tv_nsec : UINT64_MAX;
}

/** As ::ect_ns_of; the microseconds may be more than a second, as those of select(2). */
static inline uint64_t ect_ns_of_timeval(const struct timeval *time)
{
    const time_t whole = time->tv_usec / 1000000;
    const struct timespec its = {.tv_sec = time->tv_sec < INT64_MAX - whole ? time->tv_sec + whole : INT64_MAX,
                                 .tv_nsec = time->tv_usec % 1000000 * 1000};
    return ect_ns_of(&its);
}

/** @return whether a point in time is valid: the kernel and the C library refuse others with EINVAL */
static inline bool ect_is_point(const struct timespec *time)
{
    return time->tv_nsec >= 0 && (uint64_t)time->tv_nsec < ECT_NS_PER_S;
}

/** @return whether a time span is valid */
static inline bool ect_is_time(const struct timespec *time)
{
    return time->tv_sec >= 0 && ect_is_point(time);
}

static inline struct timespec ect_timespec_of(uint64_t time_ns)
{
    return (struct timespec){.tv_sec = (time_t)(time_ns / ECT_NS_PER_S), .tv_nsec = (long)(time_ns % ECT_NS_PER_S)};
}

/** An absolute time of a clock; UINT64_MAX: never. */
static inline uint64_t ect_deadline_on(clockid_t clock, const struct timespec *time)
{
    uint64_t at_ns = ect_ns_of(time);
    if (at_ns == UINT64_MAX || (clock != CLOCK_REALTIME && clock != CLOCK_TAI))
        return at_ns;
    return at_ns > ECT_DAY_OFFSET_NS ? at_ns - ECT_DAY_OFFSET_NS : 0;
}

/** An absolute time of an unknown clock: a time of day is later than 2026, a monotonic time is far smaller. */
static inline uint64_t ect_deadline(const struct timespec *time)
{
    return ect_deadline_on(ect_ns_of(time) > ECT_DAY_OFFSET_NS / 2 ? CLOCK_REALTIME : CLOCK_MONOTONIC, time);
}

/** The end of a span of nanoseconds that begins now; UINT64_MAX: never. */
static inline uint64_t ect_deadline_in_ns(uint64_t span_ns)
{
    uint64_t now_ns = ect_virtual_now();
    return span_ns < UINT64_MAX - now_ns ? now_ns + span_ns : UINT64_MAX;
}

/** The end of a time span that begins now; NULL: no limit. */
static inline uint64_t ect_deadline_in(const struct timespec *span)
{
    return span ? ect_deadline_in_ns(ect_ns_of(span)) : UINT64_MAX;
}

/** The end of a timeout in milliseconds that begins now; negative: no limit. */
static inline uint64_t ect_deadline_in_ms(int timeout_ms)
{
    return timeout_ms < 0 ? UINT64_MAX : ect_virtual_now() + (uint64_t)timeout_ms * 1000000u;
}

/** Sets a timer as timer_settime(2) does: an it_value of 0 stops the timer. */
static inline void ect_timer_set(ect_timer_t *timer, clockid_t clock, bool absolute, const struct itimerspec *value)
{
    uint64_t span_ns = ect_ns_of(&value->it_value);
    uint64_t next_ns = absolute ? ect_deadline_on(clock, &value->it_value) : ect_deadline_in_ns(span_ns);
    timer->interval_ns = ect_ns_of(&value->it_interval);
    timer->next_ns = span_ns == 0 ? UINT64_MAX : next_ns < UINT64_MAX ? next_ns : UINT64_MAX - 1;
}

/** The time left, and the interval, as timer_gettime(2) returns them. */
static inline struct itimerspec ect_timer_left(const ect_timer_t *timer)
{
    uint64_t now_ns = ect_virtual_now();
    uint64_t left_ns = timer->next_ns == UINT64_MAX ? 0 : timer->next_ns > now_ns ? timer->next_ns - now_ns : 1;
    return (struct itimerspec){.it_value = ect_timespec_of(left_ns),
                               .it_interval = ect_timespec_of(timer->interval_ns)};
}

#endif
