/* SPDX-License-Identifier: MIT */
/* The bus on the real clock: between frames a thread of the library runs the devices and serves the control socket. */
#define _GNU_SOURCE
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/bus.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"
#include "bus/library.h"

enum { NS_PER_S = 1000000000, REST_NS = 50000 };

const bool ect_time_is_virtual = false;

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static int wake_fd = -1;
static uint64_t sleeps_until_ns = ECTWIN_NEVER; /* end of the library thread's sleep */

void ect_time_lock(void)
{
    ect_action_hold();
    REAL(pthread_mutex_lock)(&mutex);
}

void ect_time_unlock(void)
{
    REAL(pthread_mutex_unlock)(&mutex);
    ect_action_release();
}

uint64_t ect_time_now(void)
{
    struct timespec time;
    REAL(clock_gettime)(CLOCK_MONOTONIC, &time);
    return (uint64_t)time.tv_sec * NS_PER_S + (uint64_t)time.tv_nsec;
}

void ect_time_charge(uint64_t cost_ns)
{
    (void)cost_ns; /* the real clock includes the cost */
}

bool ect_time_before_read(const char *call, int fd, int flags)
{
    (void)call;
    (void)fd;
    (void)flags;
    return true;
}

static int wait_until(struct pollfd *fds, nfds_t count, uint64_t until_ns)
{
    uint64_t now_ns = ect_time_now();
    uint64_t left_ns = until_ns > now_ns ? until_ns - now_ns : 0;
    const struct timespec limit = {.tv_sec = (time_t)(left_ns / NS_PER_S), .tv_nsec = (long)(left_ns % NS_PER_S)};
    return REAL(ppoll)(fds, count, until_ns != ECTWIN_NEVER ? &limit : NULL, NULL);
}

/* recv(2): a timeout ends a receive after each handler. */
static bool ends_wait(ect_handled_t handlers, uint64_t until_ns)
{
    return handlers.count > 0 && (until_ns != ECTWIN_NEVER || !handlers.restarts);
}

bool ect_time_wait(int fd, bool (*ready)(const void *arg), const void *arg, uint64_t until_ns)
{
    struct pollfd one = {.fd = fd, .events = POLLIN};
    int error = 0;
    ect_action_watch();
    while (error == 0 && !ready(arg)) {
        ect_time_unlock();
        int result = wait_until(&one, 1, until_ns);
        if (result == 0 || (result < 0 && errno != EINTR))
            error = EAGAIN;
        else if (result < 0 && ends_wait(ect_action_handled(), until_ns))
            error = EINTR;
        ect_time_lock();
    }
    if (error != 0)
        errno = error;
    return ready(arg);
}

void ect_time_bus_next(uint64_t next_ns)
{
    if (next_ns >= sleeps_until_ns)
        return;
    int before = ect_enter();
    eventfd_write(wake_fd, 1);
    ect_leave(before);
}

static void *run(void *unused)
{
    eventfd_t value;
    bool more = false;
    (void)unused;
    ect_inside++;
    ect_time_lock();
    while (ect_bus_running()) {
        uint64_t now_ns = ect_time_now();
        uint64_t next_ns = ect_bus_run(now_ns);
        if (ect_bus_control_fd() >= 0)
            more = ect_bus_serve(now_ns);
        sleeps_until_ns = more ? now_ns + REST_NS : next_ns;
        struct pollfd fds[] = {{.fd = wake_fd, .events = POLLIN},
                               {.fd = more ? -1 : ect_bus_control_fd(), .events = POLLIN}};
        ect_time_unlock();
        (void)wait_until(fds, 2, sleeps_until_ns);
        if (fds[0].revents != 0)
            (void)eventfd_read(wake_fd, &value);
        ect_time_lock();
    }
    ect_time_unlock();
    return NULL;
}

/* Without a thread the devices run only with frames. The thread is created detached, because a sanitizer with a list of
 * threads does not know it, and would report pthread_detach() as an error. */
void ect_time_bus_started(void)
{
    pthread_t thread;
    pthread_attr_t detached;
    sigset_t all, before;
    wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    pthread_attr_init(&detached);
    pthread_attr_setdetachstate(&detached, PTHREAD_CREATE_DETACHED);
    (void)REAL(pthread_create)(&thread, &detached, run, NULL);
    pthread_attr_destroy(&detached);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/* A child has only the thread that called fork(): a lock of another thread would remain locked in the child. */
__attribute__((constructor)) static void begin(void)
{
    (void)pthread_atfork(ect_time_lock, ect_time_unlock, ect_time_unlock);
}

__attribute__((destructor)) static void end(void)
{
    ect_time_lock();
    ect_bus_end();
    ect_time_unlock();
}
