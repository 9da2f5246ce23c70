/* SPDX-License-Identifier: MIT */
/* poll, select and epoll on the virtual clock. Sockets of the bus are eventfds, so the real
 * functions, with timeout 0, report the ready descriptors. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/ports.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/signals.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"

static int fail(int error)
{
    errno = error;
    return -1;
}

/* A condition is evaluated in any thread: it stores the error number of its call. */
typedef struct polling {
    struct pollfd *fds;
    nfds_t count;
    int result;
    int error;
} polling_t;

/* @return whether all descriptors are sockets of the bus, as with most masters */
static bool are_ports(const struct pollfd *fds, nfds_t count)
{
    nfds_t i = 0;
    while (i < count && ect_port_of(fds[i].fd))
        i++;
    return i == count && count > 0;
}

static int poll_ports(struct pollfd *fds, nfds_t count)
{
    int ready = 0;
    for (nfds_t i = 0; i < count; i++) {
        short has = ect_port_has_frame(ect_port_of(fds[i].fd)) ? POLLIN | POLLRDNORM | POLLOUT | POLLWRNORM
                                                               : POLLOUT | POLLWRNORM;
        fds[i].revents = fds[i].events & has;
        ready += fds[i].revents != 0;
    }
    return ready;
}

static bool poll_now(void *arg)
{
    polling_t *p = arg;
    if (are_ports(p->fds, p->count)) {
        p->result = poll_ports(p->fds, p->count);
        return p->result != 0;
    }
    ect_ports_show();
    p->result = REAL(poll)(p->fds, p->count, 0);
    p->error = errno;
    return p->result != 0;
}

/* @return the result of a call whose wait may have been interrupted by a signal handler */
static int result_of(ect_wait_t wait, int ready, int error)
{
    if (wait == ECT_WAIT_INTERRUPTED)
        return fail(EINTR);
    return ready < 0 ? fail(error) : ready;
}

/* @return whether there is a pipe, probably to a child process */
static bool has_pipe(const struct pollfd *fds, nfds_t count)
{
    struct stat its;
    nfds_t i = 0;
    while (i < count && (fstat(fds[i].fd, &its) != 0 || !S_ISFIFO(its.st_mode)))
        i++;
    return i < count && ect_virtual_has_child();
}

static int poll_until(struct pollfd *fds, nfds_t count, const char *call, uint64_t until_ns)
{
    polling_t p = {.fds = fds, .count = count};
    ect_wait_t wait;
    if (!are_ports(fds, count) && !poll_now(&p) && has_pipe(fds, count))
        wait = ect_virtual_wait_for_process(poll_now, &p, call, until_ns);
    else
        wait = ect_virtual_wait_until(poll_now, &p, are_ports(fds, count) ? NULL : call, until_ns);
    return result_of(wait, p.result, p.error);
}

/* As the kernel, sets the events of every descriptor also if the wait was interrupted. */
static bool put_events(struct pollfd *to, const struct pollfd *from, nfds_t count)
{
    nfds_t i = 0;
    while (i < count && ect_user_write(ect_user_at(to, i * sizeof *to + offsetof(struct pollfd, revents)),
                                       &from[i].revents, sizeof from[i].revents))
        i++;
    return i == count;
}

/* Polls a list of the program. */
static int poll_list(struct pollfd *fds, nfds_t count, const char *call, uint64_t until_ns)
{
    enum { USUAL = 32, MOST = 1048576 };
    struct pollfd usual[USUAL];
    if (count > MOST)
        return fail(EINVAL);
    struct pollfd *copy = count <= USUAL ? usual : malloc(count * sizeof *copy);
    if (!copy)
        return fail(ENOMEM);
    bool good = ect_user_read(copy, fds, count * sizeof *copy);
    int result = good ? poll_until(copy, count, call, until_ns) : -1;
    int error = errno;
    good = good && put_events(fds, copy, count);
    if (copy != usual)
        free(copy);
    return !good ? fail(EFAULT) : result < 0 ? fail(error) : result;
}

/* Reads a time span of the program; NULL: no limit. @param[out] until_ns  the end of the span, which begins now
 * @return false (errno): a bad address, or not a time */
static bool read_deadline(const struct timespec *span, uint64_t *until_ns)
{
    struct timespec its;
    if (span && !ect_user_read(&its, span, sizeof its))
        return fail(EFAULT) == 0;
    if (span && !ect_is_time(&its))
        return fail(EINVAL) == 0;
    *until_ns = ect_deadline_in(span ? &its : NULL);
    return true;
}

REPLACES int poll(struct pollfd *fds, nfds_t count, int timeout_ms)
{
    if (ect_inside > 0)
        return REAL(poll)(fds, count, timeout_ms);
    ect_virtual_charge(ECT_COST_SOCKET_NS);
    return poll_list(fds, count, "poll()", ect_deadline_in_ms(timeout_ms));
}

int __poll_chk(struct pollfd *fds, nfds_t count, int timeout_ms, size_t room);
REPLACES int __poll_chk(struct pollfd *fds, nfds_t count, int timeout_ms, size_t room)
{
    return count <= room / sizeof *fds ? poll(fds, count, timeout_ms) : REAL(__poll_chk)(fds, count, timeout_ms, room);
}

REPLACES int ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    if (ect_inside > 0)
        return REAL(ppoll)(fds, count, timeout, mask);
    ect_virtual_charge(ECT_COST_SOCKET_NS);
    sigset_t before;
    uint64_t until_ns;
    if (!read_deadline(timeout, &until_ns))
        return -1;
    int result = ect_signals_mask(mask, &before);
    if (result == 0)
        result = poll_list(fds, count, "ppoll()", until_ns);
    ect_signals_unmask(mask, &before);
    return result;
}

int __ppoll_chk(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask, size_t room);
REPLACES int __ppoll_chk(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask,
                         size_t room)
{
    return count <= room / sizeof *fds ? ppoll(fds, count, timeout, mask)
                                       : REAL(__ppoll_chk)(fds, count, timeout, mask, room);
}

typedef struct selecting {
    int count;
    size_t size;     /* of the sets in bytes: those of a system call may be smaller than an fd_set */
    fd_set *sets[3]; /* of the program, and maybe larger: the kernel knows how much of them it uses */
    fd_set wanted[3];
    int result;
    int error;
} selecting_t;

static bool select_now(void *arg)
{
    selecting_t *s = arg;
    struct timeval none = {0};
    ect_ports_show();
    for (unsigned int i = 0; i < 3; i++) {
        if (s->sets[i] && !ect_user_write(s->sets[i], &s->wanted[i], s->size)) {
            s->result = -1;
            s->error = EFAULT;
            return true;
        }
    }
    s->result = REAL(select)(s->count, s->sets[0], s->sets[1], s->sets[2], &none);
    s->error = errno;
    return s->result != 0;
}

/* @return the bytes of a set of so many descriptors, which the kernel reads and writes as words */
static size_t size_of_set(int count)
{
    const size_t words = count > 0 ? ((size_t)count + NFDBITS - 1) / NFDBITS : 0;
    return words * sizeof(fd_mask) < sizeof(fd_set) ? words * sizeof(fd_mask) : sizeof(fd_set);
}

static int select_until(int count, fd_set *to_read, fd_set *to_write, fd_set *except, uint64_t until_ns)
{
    selecting_t s = {.count = count, .size = size_of_set(count), .sets = {to_read, to_write, except}};
    for (unsigned int i = 0; i < 3; i++) {
        if (s.sets[i] && !ect_user_read(&s.wanted[i], s.sets[i], s.size))
            return fail(EFAULT);
    }
    ect_virtual_charge(ECT_COST_SOCKET_NS);
    ect_wait_t wait = ect_virtual_wait_until(select_now, &s, "select()", until_ns);
    return result_of(wait, s.result, s.error);
}

REPLACES int select(int count, fd_set *restrict to_read, fd_set *restrict to_write, fd_set *restrict except,
                    struct timeval *restrict timeout)
{
    if (ect_inside > 0)
        return REAL(select)(count, to_read, to_write, except, timeout);
    struct timeval span;
    if (timeout && !ect_user_read(&span, timeout, sizeof span))
        return fail(EFAULT);
    if (timeout && (span.tv_sec < 0 || span.tv_usec < 0))
        return fail(EINVAL);
    uint64_t until_ns = timeout ? ect_deadline_in_ns(ect_ns_of_timeval(&span)) : UINT64_MAX;
    return select_until(count, to_read, to_write, except, until_ns);
}

REPLACES int pselect(int count, fd_set *restrict to_read, fd_set *restrict to_write, fd_set *restrict except,
                     const struct timespec *restrict timeout, const sigset_t *restrict mask)
{
    if (ect_inside > 0)
        return REAL(pselect)(count, to_read, to_write, except, timeout, mask);
    sigset_t before;
    uint64_t until_ns;
    if (!read_deadline(timeout, &until_ns))
        return -1;
    int result = ect_signals_mask(mask, &before);
    if (result == 0)
        result = select_until(count, to_read, to_write, except, until_ns);
    ect_signals_unmask(mask, &before);
    return result;
}

typedef struct epolling {
    int fd;
    struct epoll_event *events; /* of the program: the kernel alone writes them */
    int most;
    int result;
    int error;
} epolling_t;

static bool epoll_now(void *arg)
{
    epolling_t *e = arg;
    ect_ports_show();
    e->result = REAL(epoll_wait)(e->fd, e->events, e->most, 0);
    e->error = errno;
    return e->result != 0;
}

static int epoll_until(int fd, struct epoll_event *events, int most, uint64_t until_ns)
{
    epolling_t e = {.fd = fd, .events = events, .most = most};
    ect_virtual_charge(ECT_COST_SOCKET_NS);
    ect_wait_t wait = ect_virtual_wait_until(epoll_now, &e, "epoll_wait()", until_ns);
    return result_of(wait, e.result, e.error);
}

static int epoll_masked(int fd, struct epoll_event *events, int most, uint64_t until_ns, const sigset_t *mask)
{
    sigset_t before;
    int result = ect_signals_mask(mask, &before);
    if (result == 0)
        result = epoll_until(fd, events, most, until_ns);
    ect_signals_unmask(mask, &before);
    return result;
}

REPLACES int epoll_wait(int fd, struct epoll_event *events, int most, int timeout_ms)
{
    if (ect_inside > 0)
        return REAL(epoll_wait)(fd, events, most, timeout_ms);
    return epoll_until(fd, events, most, ect_deadline_in_ms(timeout_ms));
}

REPLACES int epoll_pwait(int fd, struct epoll_event *events, int most, int timeout_ms, const sigset_t *mask)
{
    if (ect_inside > 0)
        return REAL(epoll_pwait)(fd, events, most, timeout_ms, mask);
    return epoll_masked(fd, events, most, ect_deadline_in_ms(timeout_ms), mask);
}

int epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *timeout, const sigset_t *mask);
REPLACES int epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *timeout,
                          const sigset_t *mask)
{
    if (ect_inside > 0)
        return REAL(epoll_pwait2)(fd, events, most, timeout, mask);
    uint64_t until_ns;
    if (!read_deadline(timeout, &until_ns))
        return -1;
    return epoll_masked(fd, events, most, until_ns, mask);
}

static uint64_t receive_deadline(int fd)
{
    struct timeval timeout = {0};
    socklen_t length = sizeof timeout;
    if (REAL(getsockopt)(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, &length) != 0 ||
        (timeout.tv_sec == 0 && timeout.tv_usec == 0))
        return UINT64_MAX;
    return ect_deadline_in_ns(ect_ns_of_timeval(&timeout));
}

/* The descriptor may be a pipe, a socket or an eventfd of another thread or process. After a timeout of the virtual
 * clock the real call waits, too: the reply of another process takes real time. */
bool ect_time_before_read(const char *call, int fd, int flags)
{
    struct pollfd one = {.fd = fd, .events = POLLIN};
    if ((flags & MSG_DONTWAIT) != 0 || REAL(poll)(&one, 1, 0) != 0 || (REAL(fcntl)(fd, F_GETFL) & O_NONBLOCK) != 0)
        return true;
    const uint64_t until_ns = receive_deadline(fd);
    int result;
    do
        result = poll_until(&one, 1, call, until_ns);
    while (result < 0 && errno == EINTR && until_ns == UINT64_MAX && ect_virtual_restarts());
    return result >= 0 || errno != EINTR;
}
