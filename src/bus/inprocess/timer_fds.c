/* SPDX-License-Identifier: MIT */
/* Timer descriptors on the virtual clock: eventfds to which expiries are written. */
#define _GNU_SOURCE
#include <errno.h>
#include <poll.h>
#include <stddef.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/user.h"

typedef struct timer_fd {
    ect_eventfd_t event;
    ect_timer_t timer; /* also of an unused one in the list of the virtual clock, but stopped */
    clockid_t clock;
} timer_fd_t;

static int fail(int error)
{
    errno = error;
    return -1;
}

static void expire(ect_timer_t *timer)
{
    const timer_fd_t *its = (const timer_fd_t *)(const void *)((const char *)timer - offsetof(timer_fd_t, timer));
    eventfd_t one = 1;
    (void)!REAL(write)(its->event.fd, &one, sizeof one);
}

static bool is_readable(int fd)
{
    struct pollfd one = {.fd = fd, .events = POLLIN};
    return REAL(poll)(&one, 1, 0) > 0;
}

static void closed(ect_eventfd_t *its, int fd)
{
    (void)fd;
    ((timer_fd_t *)its)->timer.next_ns = UINT64_MAX;
    ect_eventfd_keep(its);
}

static bool inherited(ect_eventfd_t *its)
{
    return is_readable(its->fd);
}

static ect_eventfd_kind_t timer_fds = {.size = sizeof(timer_fd_t), .closed = closed, .inherited = inherited};

static timer_fd_t *timer_of(int fd)
{
    return ect_inside == 0 ? (timer_fd_t *)ect_eventfd_of(fd, &timer_fds) : NULL;
}

/* The clocks that wake a suspended machine: the virtual one is never suspended. @return -1: not a clock of timers */
static int clock_of(int clock)
{
    switch (clock) {
    case CLOCK_REALTIME:
    case CLOCK_MONOTONIC:
    case CLOCK_BOOTTIME:
        return clock;
    case CLOCK_REALTIME_ALARM:
        return CLOCK_REALTIME;
    case CLOCK_BOOTTIME_ALARM:
        return CLOCK_BOOTTIME;
    default:
        return -1;
    }
}

REPLACES int timerfd_create(int clock, int flags)
{
    if (ect_inside > 0)
        return REAL(timerfd_create)(clock, flags);
    if (clock_of(clock) < 0 || (flags & ~(TFD_CLOEXEC | TFD_NONBLOCK)) != 0)
        return fail(EINVAL);
    timer_fd_t *its = (timer_fd_t *)ect_eventfd_make(&timer_fds);
    if (!its)
        return -1;
    its->clock = clock_of(clock);
    if (!its->timer.expired) {
        its->timer = (ect_timer_t){.next_ns = UINT64_MAX, .expired = expire, .inherited = true};
        ect_virtual_add_timer(&its->timer);
    }
    its->timer.interval_ns = 0;
    return ect_eventfd_open(&its->event, ((flags & TFD_CLOEXEC) != 0 ? EFD_CLOEXEC : 0) |
                                             ((flags & TFD_NONBLOCK) != 0 ? EFD_NONBLOCK : 0));
}

REPLACES int timerfd_gettime(int fd, struct itimerspec *value)
{
    const timer_fd_t *its = timer_of(fd);
    if (!its)
        return REAL(timerfd_gettime)(fd, value);
    const struct itimerspec left = ect_timer_left(&its->timer);
    return ect_user_write(value, &left, sizeof left) ? 0 : fail(EFAULT);
}

REPLACES int timerfd_settime(int fd, int flags, const struct itimerspec *value, struct itimerspec *before)
{
    timer_fd_t *its = timer_of(fd);
    eventfd_t expiries;
    if (!its)
        return REAL(timerfd_settime)(fd, flags, value, before);
    struct itimerspec set;
    if (!ect_user_read(&set, value, sizeof set))
        return fail(EFAULT);
    if ((flags & ~(TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET)) != 0 || !ect_is_time(&set.it_value) ||
        !ect_is_time(&set.it_interval))
        return fail(EINVAL);
    const struct itimerspec left = ect_timer_left(&its->timer);
    if (is_readable(fd))
        (void)!REAL(read)(fd, &expiries, sizeof expiries);
    ect_timer_set(&its->timer, its->clock, (flags & TFD_TIMER_ABSTIME) != 0, &set);
    return !before || ect_user_write(before, &left, sizeof left) ? 0 : fail(EFAULT);
}
