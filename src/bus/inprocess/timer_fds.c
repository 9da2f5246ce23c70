/* SPDX-License-Identifier: MIT */
/* Timer descriptors on the virtual clock: eventfds to which expiries are written. */
#define _GNU_SOURCE
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"

enum { DESCRIPTORS = 65536 };

typedef struct timer_fd {
    ect_timer_t timer; /* first; its `next` links unused ones, too */
    int fd;            /* one of the descriptors */
    unsigned int descriptors;
    clockid_t clock;
} timer_fd_t;

/* Changed only by the thread with the turn. */
static timer_fd_t *by_descriptor[DESCRIPTORS];
static unsigned int numbers; /* of descriptors: those that have been timers are below */
static timer_fd_t *unused;   /* never freed: close(2) is allowed in a handler that has interrupted malloc() */
static pid_t owner;          /* the process with these descriptors: a child of vfork() has its own, but this memory */

static int fail(int error)
{
    errno = error;
    return -1;
}

static void take_turn(void)
{
    (void)ect_virtual_now();
}

static timer_fd_t *timer_of(int fd)
{
    return ect_inside == 0 && fd >= 0 && fd < DESCRIPTORS ? by_descriptor[fd] : NULL;
}

static void add(int fd, timer_fd_t *its)
{
    its->descriptors++;
    by_descriptor[fd] = its;
    numbers = (unsigned int)fd >= numbers ? (unsigned int)fd + 1 : numbers;
}

static void expire(ect_timer_t *timer)
{
    const timer_fd_t *its = (const timer_fd_t *)timer;
    eventfd_t one = 1;
    (void)!REAL(write)(its->fd, &one, sizeof one);
}

static bool is_readable(int fd)
{
    struct pollfd one = {.fd = fd, .events = POLLIN};
    return REAL(poll)(&one, 1, 0) > 0;
}

static int descriptor_of(const timer_fd_t *its)
{
    int fd = 0;
    while (by_descriptor[fd] != its)
        fd++;
    return fd;
}

static void keep_unused(timer_fd_t *its)
{
    its->timer.next = unused ? &unused->timer : NULL;
    unused = its;
}

static void remove_descriptor(unsigned int fd)
{
    timer_fd_t *its = by_descriptor[fd];
    by_descriptor[fd] = NULL;
    if (--its->descriptors > 0) {
        its->fd = descriptor_of(its);
        return;
    }
    ect_virtual_remove_timer(&its->timer);
    keep_unused(its);
}

/* Without the turn if no timer is in the range, as at the end of most files. */
void ect_time_closed(unsigned int from, unsigned int to)
{
    for (unsigned int fd = from; fd <= to && fd < numbers; fd++) {
        if (!by_descriptor[fd] || getpid() != owner)
            continue;
        take_turn();
        if (by_descriptor[fd])
            remove_descriptor(fd);
    }
}

void ect_time_copied(int fd, int copy)
{
    if (!timer_of(fd) || copy < 0 || copy >= DESCRIPTORS || getpid() != owner)
        return;
    take_turn();
    if (by_descriptor[fd])
        add(copy, by_descriptor[fd]);
}

static timer_fd_t *take_unused(void)
{
    timer_fd_t *its = unused;
    if (its)
        unused = (timer_fd_t *)its->timer.next;
    return its;
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

/* @return an eventfd with the flags of a timer; -1 (errno) */
static int open_event(int flags)
{
    int fd =
        eventfd(0, ((flags & TFD_CLOEXEC) != 0 ? EFD_CLOEXEC : 0) | ((flags & TFD_NONBLOCK) != 0 ? EFD_NONBLOCK : 0));
    if (fd < DESCRIPTORS)
        return fd;
    REAL(close)(fd);
    return fail(EMFILE);
}

REPLACES int timerfd_create(int clock, int flags)
{
    if (ect_inside > 0)
        return REAL(timerfd_create)(clock, flags);
    if (clock_of(clock) < 0 || (flags & ~(TFD_CLOEXEC | TFD_NONBLOCK)) != 0)
        return fail(EINVAL);
    take_turn();
    timer_fd_t *its = take_unused();
    if (!its)
        its = calloc(1, sizeof *its);
    int fd = its ? open_event(flags) : -1;
    if (!its)
        return -1;
    *its = (timer_fd_t){
        .timer = {.next_ns = UINT64_MAX, .expired = expire, .inherited = true}, .fd = fd, .clock = clock_of(clock)};
    if (fd < 0) {
        keep_unused(its);
        return -1;
    }
    ect_virtual_add_timer(&its->timer);
    add(fd, its);
    return fd;
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

/* A child of fork() has the timers of its parent, on its own clock. */
static void in_child(void)
{
    owner = getpid();
    for (unsigned int fd = 0; fd < numbers; fd++) {
        const timer_fd_t *its = by_descriptor[fd];
        if (its && its->fd == (int)fd)
            ect_eventfd_renew((int)fd, is_readable((int)fd));
    }
    for (unsigned int fd = 0; fd < numbers; fd++) {
        const timer_fd_t *its = by_descriptor[fd];
        if (its && its->fd != (int)fd)
            ect_eventfd_replace((int)fd, its->fd);
    }
}

__attribute__((constructor)) static void begin(void)
{
    owner = getpid();
    (void)pthread_atfork(NULL, NULL, in_child);
}
