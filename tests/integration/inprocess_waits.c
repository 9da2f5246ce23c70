/* SPDX-License-Identifier: MIT */
/*
 * Clocks, timers, polls, locks and waits: on the virtual clock as the C library has them on the real one.
 * usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_waits {} real|virtual [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <fcntl.h>
#include <limits.h>
#include <linux/futex.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#define S 1000000000u

static struct timespec span(uint64_t ns)
{
    return (struct timespec){.tv_sec = (time_t)(ns / S), .tv_nsec = (long)(ns % S)};
}

/* A time of a clock, from now. */
static struct timespec after(clockid_t clock, uint64_t ns)
{
    struct timespec now;
    assert_int_equal(clock_gettime(clock, &now), 0);
    return span((uint64_t)now.tv_sec * S + (uint64_t)now.tv_nsec + ns);
}

static uint64_t ns_of(const struct timespec *time)
{
    return (uint64_t)time->tv_sec * S + (uint64_t)time->tv_nsec;
}

/* --- clocks and sleeps -------------------------------------------------------------------------------------------- */

/* All monotonic clocks pass alike, and all clocks of the day; that of the processor does not sleep. */
static void clocks(void **state)
{
    static const struct {
        clockid_t clock;
        bool sleeps;
    } rows[] = {{CLOCK_MONOTONIC, true},
                {CLOCK_MONOTONIC_RAW, true},
                {CLOCK_MONOTONIC_COARSE, true},
                {CLOCK_BOOTTIME, true},
                {CLOCK_REALTIME, true},
                {CLOCK_REALTIME_COARSE, true},
                {CLOCK_TAI, true},
                {CLOCK_PROCESS_CPUTIME_ID, false},
                {CLOCK_THREAD_CPUTIME_ID, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct timespec before, now;
        assert_int_equal(clock_gettime(rows[i].clock, &before), 0);
        assert_true(before.tv_nsec >= 0 && before.tv_nsec < (long)S);
        usleep(40000);
        assert_int_equal(clock_gettime(rows[i].clock, &now), 0);
        uint64_t passed_ns = ns_of(&now) - ns_of(&before);
        if ((passed_ns >= 30 * MS) != rows[i].sleeps)
            fail_msg("clock %d: %llu ns passed", (int)rows[i].clock, (unsigned long long)passed_ns);
        if (is_virtual && rows[i].sleeps)
            assert_in_range(passed_ns, 40 * MS, 40 * MS + 1000);
    }
    assert_int_equal(clock_gettime(77, &(struct timespec){0}), -1);
    assert_int_equal(errno, EINVAL);
}

/* Each function of the time of day, to its resolution. */
static void times_of_the_day(void **state)
{
    struct timespec coarse = after(CLOCK_REALTIME_COARSE, 0); /* time() has the kernel's last tick too */
    struct timespec real = after(CLOCK_REALTIME, 0), monotonic = after(CLOCK_MONOTONIC, 0);
    struct timeval day;
    time_t stored = 0;
    (void)state;
    assert_int_equal(gettimeofday(&day, NULL), 0);
    assert_in_range(day.tv_usec, 0, 999999);
    const time_t now = time(&stored);
    assert_int_equal(now, stored);
    assert_true(now >= coarse.tv_sec && day.tv_sec >= real.tv_sec);
    if (!is_virtual)
        return;
    assert_true(monotonic.tv_sec >= 1000); /* each run begins there, at the first moment of 2026 */
    assert_in_range(ns_of(&monotonic) - ns_of(&real) + UINT64_C(1767224600000000000), 0, 1000);
    assert_in_range((uint64_t)day.tv_sec * S + (uint64_t)day.tv_usec * 1000 + 1000 - ns_of(&real), 0, 2000);
    for (unsigned int i = 0; i < 10; i++) { /* the stated cost of a reading */
        uint64_t before_ns = now_ns();
        assert_int_equal(now_ns() - before_ns, 50);
    }
}

static void wrong_times(void **state)
{
    static const struct timespec wrong[] = {{-1, 0}, {0, -1}, {0, 1000000000}};
    const struct timespec most = {0, 999999999}, none = {0, 0};
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_int_equal(nanosleep(&wrong[i], NULL), -1);
        assert_int_equal(errno, EINVAL);
        assert_int_equal(clock_nanosleep(CLOCK_MONOTONIC, 0, &wrong[i], NULL), EINVAL);
    }
    uint64_t since_ns = now_ns();
    assert_int_equal(nanosleep(&none, NULL), 0);
    assert_int_equal(usleep(0), 0);
    assert_int_equal(sleep(0), 0);
    assert_int_equal(clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &most, NULL), 0); /* long over */
    assert_took(since_ns, 0);
    if (is_virtual) {
        assert_int_equal(nanosleep(&most, NULL), 0);
        assert_int_equal(clock_nanosleep(CLOCK_REALTIME, 0, &most, NULL), 0);
        assert_in_range(now_ns() - since_ns, 2 * (uint64_t)most.tv_nsec, 2 * (uint64_t)most.tv_nsec + MS);
        since_ns = now_ns();
        assert_int_equal(sleep(7), 0);
        assert_took(since_ns, 7 * (uint64_t)S);
    }
    struct timespec until = after(CLOCK_REALTIME, 3 * MS);
    since_ns = now_ns();
    assert_int_equal(clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &until, NULL), 0);
    if (is_virtual)
        assert_took(since_ns, 3 * MS - 100);
}

/* --- polls -------------------------------------------------------------------------------------------------------- */

/* Sockets alone, and with other descriptors: the requested events, and no others. */
static void results_of_poll(void **state)
{
    int fd = open_socket(0), event = eventfd(0, EFD_NONBLOCK);
    (void)state;
    for (unsigned int filled = 0; filled < 2; filled++) {
        for (unsigned int others = 0; others < 2; others++) {
            const short came = filled ? POLLIN : 0;
            struct pollfd fds[] = {{.fd = fd, .events = POLLIN | POLLOUT | POLLPRI},
                                   {.fd = fd, .events = POLLIN, .revents = 0x7F},
                                   {.fd = fd, .events = 0, .revents = 0x7F},
                                   {.fd = event, .events = POLLIN, .revents = 0x7F}};
            assert_int_equal(poll(fds, 3 + others, 0), filled ? 2 : 1);
            assert_int_equal(fds[0].revents, POLLOUT | came);
            assert_int_equal(fds[1].revents, filled ? POLLIN : 0);
            assert_int_equal(fds[2].revents, 0);
            assert_int_equal(fds[3].revents, others ? 0 : 0x7F);
            assert_int_equal(eventfd_write(event, 1), 0);
            assert_int_equal(poll(fds, 4, 1000), filled ? 3 : 2);
            assert_int_equal(fds[3].revents, POLLIN);
            eventfd_t value;
            assert_int_equal(eventfd_read(event, &value), 0);
        }
        send_one(fd, 1);
    }
    assert_int_equal(poll(NULL, 0, 0), 0);
    uint64_t since_ns = now_ns();
    assert_int_equal(poll(NULL, 0, 4), 0);
    assert_took(since_ns, 4 * MS);
    since_ns = now_ns();
    assert_int_equal(ppoll(NULL, 0, &(const struct timespec){.tv_nsec = 3 * MS}, NULL), 0);
    assert_took(since_ns, 3 * MS);
    close(fd);
    struct pollfd closed = {.fd = fd, .events = POLLIN};
    assert_int_equal(poll(&closed, 1, -1), 1);
    assert_int_equal(closed.revents, POLLNVAL);
    close(event);
}

/* The sets of a wait that ends by its time are empty; three sets at once. */
static void results_of_select(void **state)
{
    int fd = open_socket(0), pipe_fds[2];
    (void)state;
    assert_int_equal(pipe(pipe_fds), 0);
    const int count = (fd > pipe_fds[1] ? fd : pipe_fds[1]) + 1;
    for (unsigned int masked = 0; masked < 2; masked++) {
        for (unsigned int filled = 0; filled < 2; filled++) {
            struct timeval timeout = {.tv_usec = 3000};
            const struct timespec span_ns = {.tv_nsec = 3 * MS};
            fd_set in, out, except;
            FD_ZERO(&in);
            FD_ZERO(&out);
            FD_ZERO(&except);
            FD_SET(fd, &in);
            FD_SET(pipe_fds[0], &in);
            FD_SET(fd, &except);
            if (filled) {
                send_one(fd, 1);
                FD_SET(pipe_fds[1], &out);
            }
            uint64_t since_ns = now_ns();
            int ready = masked ? pselect(count, &in, &out, &except, &span_ns, NULL)
                               : select(count, &in, &out, &except, &timeout);
            assert_int_equal(ready, filled ? 2 : 0);
            assert_took(since_ns, filled ? 0 : 3 * MS);
            assert_int_equal(FD_ISSET(fd, &in) != 0, filled);
            assert_int_equal(FD_ISSET(pipe_fds[1], &out) != 0, filled);
            assert_false(FD_ISSET(fd, &except) || FD_ISSET(pipe_fds[0], &in));
            uint8_t frame[FRAME];
            if (filled)
                assert_reply(frame, recv(fd, frame, sizeof frame, 0), 1);
        }
    }
    uint64_t since_ns = now_ns();
    assert_int_equal(select(0, NULL, NULL, NULL, &(struct timeval){.tv_usec = 2000}), 0);
    assert_took(since_ns, 2 * MS);
    for (unsigned int i = 0; i < 2; i++)
        close(pipe_fds[i]);
    close(fd);
}

/* Each frame is an event of an edge, and all waiting frames are one level. */
static void results_of_epoll(void **state)
{
    struct epoll_event edge = {.events = EPOLLIN | EPOLLET, .data.u32 = 1}, level = {.events = EPOLLIN, .data.u32 = 2};
    const struct timespec wait_ns = {.tv_nsec = 3 * MS};
    struct epoll_event got[2];
    uint8_t frame[FRAME];
    int fd = open_socket(0), edges = epoll_create1(0), levels = epoll_create1(0);
    (void)state;
    assert_int_equal(epoll_ctl(edges, EPOLL_CTL_ADD, fd, &edge), 0);
    assert_int_equal(epoll_ctl(levels, EPOLL_CTL_ADD, fd, &level), 0);
    for (unsigned int i = 0; i < 3; i++) {
        send_one(fd, (uint8_t)i);
        assert_int_equal(epoll_wait(edges, got, 2, 0), 1);
        assert_int_equal(got[0].data.u32, 1);
        assert_int_equal(epoll_wait(edges, got, 2, 0), 0);
        assert_int_equal(epoll_pwait(levels, got, 2, -1, NULL), 1);
        assert_int_equal(got[0].data.u32, 2);
    }
    for (uint8_t i = 0; i < 3; i++) {
        assert_int_equal(epoll_wait(levels, got, 1, 0), 1);
        assert_reply(frame, recv(fd, frame, sizeof frame, 0), i);
    }
    uint64_t since_ns = now_ns();
    assert_int_equal(epoll_wait(levels, got, 2, 0), 0);
    assert_int_equal(epoll_pwait(levels, got, 2, 4, NULL), 0);
    assert_took(since_ns, 4 * MS);
    since_ns = now_ns();
    int result = (int)epoll_pwait2(levels, got, 2, &wait_ns, NULL);
    assert_true(result == 0 || errno == ENOSYS);
    if (result == 0)
        assert_took(since_ns, 3 * MS);
    assert_int_equal(epoll_wait(levels, got, 0, 0), -1);
    assert_int_equal(errno, EINVAL);
    close(edges);
    close(levels);
    close(fd);
}

static volatile sig_atomic_t handled;

static void on_signal(int number)
{
    handled = number;
}

/* A signal that the mask of the call lets through ends the wait at once; the mask is back afterwards. */
static void masks_of_waits(void **state)
{
    struct sigaction action = {.sa_handler = on_signal};
    const struct timespec long_time = {.tv_sec = 5};
    sigset_t blocked, open_mask, now;
    struct epoll_event event;
    int all = epoll_create1(0), fd = open_socket(0);
    struct pollfd one = {.fd = fd, .events = POLLIN};
    (void)state;
    assert_int_equal(sigaction(SIGUSR2, &action, NULL), 0);
    sigemptyset(&blocked);
    sigaddset(&blocked, SIGUSR2);
    pthread_sigmask(SIG_BLOCK, &blocked, &open_mask);
    for (unsigned int i = 0; i < 4; i++) {
        handled = 0;
        raise(SIGUSR2);
        assert_int_equal(handled, 0);
        uint64_t since_ns = now_ns();
        int result = i == 0   ? ppoll(&one, 1, &long_time, &open_mask)
                     : i == 1 ? pselect(0, NULL, NULL, NULL, &long_time, &open_mask)
                     : i == 2 ? epoll_pwait(all, &event, 1, 5000, &open_mask)
                              : sigsuspend(&open_mask);
        assert_int_equal(result, -1);
        assert_int_equal(errno, EINTR);
        assert_int_equal(handled, SIGUSR2);
        assert_took(since_ns, 0);
        pthread_sigmask(SIG_BLOCK, NULL, &now);
        assert_int_equal(sigismember(&now, SIGUSR2), 1);
    }
    uint64_t since_ns = now_ns(); /* nothing is pending: the whole time */
    assert_int_equal(ppoll(&one, 1, &(const struct timespec){.tv_nsec = 2 * MS}, &blocked), 0);
    assert_took(since_ns, 2 * MS);
    pthread_sigmask(SIG_SETMASK, &open_mask, NULL);
    close(all);
    close(fd);
}

/* A read of a descriptor that does not belong to a bus waits, unless it is non-blocking. */
static void reads_of_other_descriptors(void **state)
{
    const struct timeval timeout = {.tv_usec = 4000};
    int pair[2];
    char byte;
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, pair), 0);
    uint64_t since_ns = now_ns();
    assert_int_equal(recv(pair[0], &byte, 1, MSG_DONTWAIT), -1);
    assert_int_equal(errno, EAGAIN);
    assert_took(since_ns, 0);
    assert_int_equal(setsockopt(pair[0], SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout), 0);
    if (!is_virtual) {
        since_ns = now_ns();
        assert_int_equal(recv(pair[0], &byte, 1, 0), -1);
        assert_took(since_ns, 4 * MS);
    }
    assert_int_equal(fcntl(pair[0], F_SETFL, O_NONBLOCK), 0);
    since_ns = now_ns();
    assert_int_equal(recvfrom(pair[0], &byte, 1, 0, NULL, NULL), -1);
    assert_int_equal(read(pair[0], &byte, 1), -1);
    assert_took(since_ns, 0);
    assert_int_equal(send(pair[1], "x", 1, 0), 1);
    assert_int_equal(read(pair[0], &byte, 1), 1);
    for (unsigned int i = 0; i < 2; i++)
        close(pair[i]);
}

/* --- timers ------------------------------------------------------------------------------------------------------- */

static void timer_descriptors(void **state)
{
    const struct itimerspec once = {.it_value = span(5 * MS)}, every = {span(2 * MS), span(3 * MS)}, none = {0};
    struct itimerspec left;
    uint64_t expiries = 0;
    int fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    (void)state;
    assert_int_equal(fcntl(fd, F_GETFD), FD_CLOEXEC);
    assert_int_equal(read(fd, &expiries, sizeof expiries), -1);
    assert_int_equal(errno, EAGAIN);
    assert_int_equal(timerfd_gettime(fd, &left), 0);
    assert_int_equal(ns_of(&left.it_value) + ns_of(&left.it_interval), 0);
    assert_int_equal(timerfd_settime(fd, 0, &once, NULL), 0);
    assert_int_equal(timerfd_settime(fd, 0, &every, &left), 0);
    assert_in_range(ns_of(&left.it_value), is_virtual, 5 * MS);
    assert_int_equal(ns_of(&left.it_interval), 0);
    usleep(8000); /* at 3, 5 and 7 ms */
    assert_int_equal(read(fd, &expiries, sizeof expiries), sizeof expiries);
    assert_true(expiries >= 3);
    assert_int_equal(timerfd_gettime(fd, &left), 0);
    assert_int_equal(ns_of(&left.it_interval), 2 * MS);
    assert_in_range(ns_of(&left.it_value), 1, 2 * MS);
    if (is_virtual) {
        assert_int_equal(expiries, 3);
        assert_in_range(ns_of(&left.it_value), MS - 10000, MS);
    }
    usleep(4000);
    assert_int_equal(timerfd_settime(fd, 0, &none, NULL), 0); /* the expiries before are gone */
    assert_int_equal(read(fd, &expiries, sizeof expiries), -1);
    usleep(5000);
    assert_int_equal(read(fd, &expiries, sizeof expiries), -1);
    const struct itimerspec absolute = {.it_value = after(CLOCK_MONOTONIC, 4 * MS)};
    uint64_t since_ns = now_ns();
    assert_int_equal(timerfd_settime(fd, TFD_TIMER_ABSTIME, &absolute, NULL), 0);
    assert_int_equal(poll(&(struct pollfd){.fd = fd, .events = POLLIN}, 1, 1000), 1);
    if (is_virtual)
        assert_took(since_ns, 4 * MS - 1000);
    close(fd);
    fd = timerfd_create(CLOCK_REALTIME, 0);
    assert_int_equal(fcntl(fd, F_GETFD), 0);
    const struct itimerspec day = {.it_value = after(CLOCK_REALTIME, 3 * MS)};
    since_ns = now_ns();
    assert_int_equal(timerfd_settime(fd, TFD_TIMER_ABSTIME, &day, NULL), 0);
    assert_int_equal(read(fd, &expiries, sizeof expiries), sizeof expiries);
    assert_int_equal(expiries, 1);
    if (is_virtual)
        assert_took(since_ns, 3 * MS - 1000);
    close(fd);
    assert_int_equal(timerfd_gettime(STDERR_FILENO, &left), -1);
    assert_int_equal(timerfd_settime(STDERR_FILENO, 0, &once, NULL), -1);
}

/* Each timer expires at its own time; the end of one leaves the others. */
static void several_timer_descriptors(void **state)
{
    int fds[3];
    (void)state;
    for (unsigned int i = 0; i < 3; i++) {
        const struct itimerspec once = {.it_value = span((i + 1) * 4 * MS)};
        fds[i] = timerfd_create(CLOCK_MONOTONIC, 0);
        assert_int_equal(timerfd_settime(fds[i], 0, &once, NULL), 0);
    }
    close(fds[1]);
    for (unsigned int i = 0; i < 3; i += 2) {
        uint64_t expiries = 0, since_ns = now_ns();
        assert_int_equal(read(fds[i], &expiries, sizeof expiries), sizeof expiries);
        assert_int_equal(expiries, 1);
        if (is_virtual)
            assert_in_range(now_ns() - since_ns, (i == 0 ? 4 : 8) * MS - 20000, (i == 0 ? 4 : 8) * MS);
        close(fds[i]);
    }
}

/* A timer of 5 ms, and 3 copies of its descriptor. */
static void copies_of_a_timer_descriptor(void **state)
{
    enum { FREE_FROM = 100 };
    const struct itimerspec once = {.it_value = span(5 * MS)};
    (void)state;
    for (unsigned int kept = 0; kept < 4; kept++) {
        uint64_t expiries = 0;
        int fd = timerfd_create(CLOCK_MONOTONIC, 0);
        const int fds[] = {fd, dup(fd), fcntl(fd, F_DUPFD_CLOEXEC, FREE_FROM), dup2(fd, FREE_FROM + 50)};
        for (unsigned int i = 0; i < 4; i++) {
            if (i != kept)
                close(fds[i]);
        }
        assert_int_equal(timerfd_settime(fds[kept], 0, &once, NULL), 0);
        assert_int_equal(read(fds[kept], &expiries, sizeof expiries), sizeof expiries);
        assert_int_equal(expiries, 1);
        close(fds[kept]);
        assert_int_equal(timerfd_settime(fds[kept], 0, &once, NULL), -1);
        assert_int_equal(errno, EBADF);
    }
}

static void close_by_number(int fd, int way)
{
    int other = eventfd(0, EFD_NONBLOCK);
    if (way == 0)
        close(fd);
    else if (way == 1)
        assert_int_equal(close_range((unsigned int)fd, (unsigned int)fd, 0), 0);
    assert_int_equal(way == 3 ? dup3(other, fd, O_CLOEXEC) : dup2(other, fd), fd);
    close(other);
}

/* The next file with the number of a closed timer gets no expiry. */
static void the_end_of_a_timer_descriptor(void **state)
{
    const struct itimerspec once = {.it_value = span(2 * MS)};
    (void)state;
    for (int way = 0; way < 4; way++) {
        uint64_t expiries = 0;
        int fd = timerfd_create(CLOCK_MONOTONIC, 0);
        assert_int_equal(timerfd_settime(fd, 0, &once, NULL), 0);
        close_by_number(fd, way);
        usleep(5000);
        assert_int_equal(read(fd, &expiries, sizeof expiries), -1);
        assert_int_equal(errno, EAGAIN);
        assert_int_equal(timerfd_settime(fd, 0, &once, NULL), -1);
        assert_int_equal(errno, EINVAL);
        close(fd);
    }
}

static void calls_of_timer_descriptors_that_are_refused(void **state)
{
    static const struct itimerspec rows[] = {
        {.it_value = {-1, 0}}, {.it_value = {0, S}}, {.it_value = {1, -1}}, {{0, S}, {1, 0}}, {{-1, 0}, {1, 0}}};
    const struct itimerspec good = {.it_value = {1, 0}};
    int fd = timerfd_create(CLOCK_BOOTTIME, 0);
    (void)state;
    assert_true(fd >= 0);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        assert_int_equal(timerfd_settime(fd, 0, &rows[i], NULL), -1);
        assert_int_equal(errno, EINVAL);
    }
    assert_int_equal(timerfd_settime(fd, 0x100, &good, NULL), -1);
    assert_int_equal(errno, EINVAL);
    close(fd);
    assert_int_equal(timerfd_create(CLOCK_PROCESS_CPUTIME_ID, 0), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(timerfd_create(CLOCK_MONOTONIC, 0x100), -1);
    assert_int_equal(errno, EINVAL);
}

/* A child of vfork() closes its own descriptors, as subprocess of Python does. */
static void a_child_of_vfork_and_a_timer_descriptor(void **state)
{
    const struct itimerspec once = {.it_value = span(5 * MS)};
    uint64_t expiries = 0;
    int status = -1;
    (void)state;
    int fd = timerfd_create(CLOCK_MONOTONIC, 0);
    assert_int_equal(timerfd_settime(fd, 0, &once, NULL), 0);
    pid_t child = vfork();
    if (child == 0) {
        close(fd);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(read(fd, &expiries, sizeof expiries), sizeof expiries);
    assert_int_equal(expiries, 1);
    close(fd);
}

/* @return the exit status of a child: 0: each descriptor shows the expiry */
static int use_timers_in_child(const int *fds, const struct itimerspec *once)
{
    uint64_t expiries = 0;
    struct pollfd polled = {.fd = fds[0], .events = POLLIN};
    if (poll(&polled, 1, 10000) != 1)
        return 1;
    if (timerfd_settime(fds[1], 0, once, NULL) != 0)
        return 2;
    if (read(fds[2], &expiries, sizeof expiries) != sizeof expiries || expiries != 1)
        return 3;
    return 0;
}

/* A timer is set before the fork; another one, of two descriptors, in the child. */
static void a_child_of_fork_has_the_timer_descriptors(void **state)
{
    const struct itimerspec once = {.it_value = span(5 * MS)};
    uint64_t expiries = 0;
    int status = -1;
    (void)state;
    const int set = timerfd_create(CLOCK_MONOTONIC, 0), other = timerfd_create(CLOCK_MONOTONIC, 0);
    const int fds[] = {set, other, dup(other)};
    assert_int_equal(timerfd_settime(set, 0, &once, NULL), 0);
    pid_t child = fork();
    if (child == 0)
        _exit(use_timers_in_child(fds, &once));
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_int_equal(read(set, &expiries, sizeof expiries), sizeof expiries);
    assert_int_equal(expiries, 1);
    for (unsigned int i = 0; i < 3; i++)
        close(fds[i]);
}

static void timers_of_posix(void **state)
{
    struct sigevent none = {.sigev_notify = SIGEV_NONE};
    struct itimerspec left, value = {span(2 * MS), span(5 * MS)};
    timer_t timer, other;
    (void)state;
    assert_int_equal(timer_create(CLOCK_MONOTONIC, &none, &timer), 0);
    assert_int_equal(timer_create(CLOCK_REALTIME, &none, &other), 0);
    assert_int_equal(timer_gettime(timer, &left), 0);
    assert_int_equal(ns_of(&left.it_value), 0);
    assert_int_equal(timer_settime(timer, 0, &value, &left), 0);
    assert_int_equal(ns_of(&left.it_value), 0);
    usleep(1000);
    value.it_value = after(CLOCK_REALTIME, 50 * MS);
    assert_int_equal(timer_settime(other, TIMER_ABSTIME, &value, NULL), 0);
    assert_int_equal(timer_gettime(other, &left), 0);
    assert_in_range(ns_of(&left.it_value), 1, 50 * MS);
    if (is_virtual)
        assert_in_range(ns_of(&left.it_value), 50 * MS - 10000, 50 * MS);
    assert_int_equal(timer_gettime(timer, &left), 0);
    assert_int_equal(ns_of(&left.it_interval), 2 * MS);
    assert_in_range(ns_of(&left.it_value), 1, 4 * MS);
    assert_int_equal(timer_delete(timer), 0);
    value = (struct itimerspec){0};
    assert_int_equal(timer_settime(other, 0, &value, &left), 0);
    assert_in_range(ns_of(&left.it_value), 1, 50 * MS);
    assert_int_equal(timer_gettime(other, &left), 0);
    assert_true(!is_virtual || ns_of(&left.it_value) == 0); /* some kernels return the former time */
    assert_int_equal(timer_delete(other), 0);
    assert_int_equal(timer_create(CLOCK_PROCESS_CPUTIME_ID, &none, &timer), 0); /* stays the machine's */
    assert_int_equal(timer_delete(timer), 0);
}

/* A timer without a description sends SIGALRM, with itself as the value. */
static void a_timer_without_a_description(void **state)
{
    const struct itimerspec once = {.it_value = span(2 * MS)};
    sigset_t set, before;
    siginfo_t info;
    timer_t timer;
    (void)state;
    sigemptyset(&set);
    sigaddset(&set, SIGALRM);
    pthread_sigmask(SIG_BLOCK, &set, &before);
    assert_int_equal(timer_create(CLOCK_MONOTONIC, NULL, &timer), 0);
    assert_int_equal(timer_settime(timer, 0, &once, NULL), 0);
    uint64_t since_ns = now_ns();
    assert_int_equal(sigwaitinfo(&set, &info), SIGALRM);
    assert_int_equal(info.si_code, SI_TIMER);
    assert_took(since_ns, is_virtual ? 2 * MS - 1000 : 0);
    assert_int_equal(timer_delete(timer), 0);
    struct itimerval value = {.it_value = {.tv_usec = 900000}, .it_interval = {.tv_sec = 2}}, was;
    assert_int_equal(setitimer(ITIMER_REAL, &value, NULL), 0);
    value = (struct itimerval){.it_value.tv_usec = 2000};
    assert_int_equal(setitimer(ITIMER_REAL, &value, &was), 0);
    assert_int_equal(was.it_interval.tv_sec, 2);
    assert_in_range(was.it_value.tv_usec, is_virtual, 900000);
    assert_int_equal(sigwaitinfo(&set, &info), SIGALRM);
    assert_int_equal(getitimer(ITIMER_REAL, &was), 0);
    assert_int_equal(was.it_value.tv_sec + was.it_value.tv_usec + was.it_interval.tv_usec, 0);
    assert_int_equal(alarm(77), 0);
    assert_int_equal(alarm(0), 77);
    assert_int_equal(alarm(0), 0);
    value = (struct itimerval){.it_value.tv_sec = 9}; /* of processor time */
    assert_int_equal(setitimer(ITIMER_PROF, &value, NULL), 0);
    assert_int_equal(getitimer(ITIMER_PROF, &was), 0);
    assert_in_range(was.it_value.tv_sec, 8, 9);
    assert_int_equal(setitimer(ITIMER_PROF, &(struct itimerval){0}, NULL), 0);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/* --- locks -------------------------------------------------------------------------------------------------------- */

typedef struct held {
    pthread_mutex_t mutex;
    pthread_rwlock_t lock;
    pthread_cond_t condition;
    sem_t ready, release;
    unsigned int woken;
    int word;
} held_t;

static void *hold(void *arg)
{
    held_t *its = arg;
    pthread_mutex_lock(&its->mutex);
    pthread_rwlock_rdlock(&its->lock);
    sem_post(&its->ready);
    while (sem_wait(&its->release) != 0)
        ;
    pthread_rwlock_unlock(&its->lock);
    pthread_mutex_unlock(&its->mutex);
    return its;
}

/* Every wait with a deadline, on each clock: it ends there with its error. */
static void deadlines(void **state)
{
    static const clockid_t kinds[] = {CLOCK_REALTIME, CLOCK_MONOTONIC};
    held_t its = {
        .mutex = PTHREAD_MUTEX_INITIALIZER, .lock = PTHREAD_RWLOCK_INITIALIZER, .condition = PTHREAD_COND_INITIALIZER};
    pthread_mutex_t own = PTHREAD_MUTEX_INITIALIZER;
    pthread_t thread;
    void *result = NULL;
    (void)state;
    sem_init(&its.ready, 0, 0);
    sem_init(&its.release, 0, 0);
    assert_int_equal(pthread_create(&thread, NULL, hold, &its), 0);
    assert_int_equal(sem_wait(&its.ready), 0);
    for (unsigned int i = 0; i < 8; i++) {
        const clockid_t clock = kinds[i < 4 ? 0 : 1];
        struct timespec until = after(clock, 3 * MS);
        uint64_t since_ns = now_ns();
        assert_int_equal(pthread_mutex_lock(&own), 0);
        int error = i == 0   ? pthread_mutex_timedlock(&its.mutex, &until)
                    : i == 1 ? pthread_rwlock_timedwrlock(&its.lock, &until)
                    : i == 2 ? pthread_cond_timedwait(&its.condition, &own, &until)
                    : i == 3 ? (sem_timedwait(&its.ready, &until) == 0 ? 0 : errno)
                    : i == 4 ? pthread_mutex_clocklock(&its.mutex, clock, &until)
                    : i == 5 ? pthread_cond_clockwait(&its.condition, &own, clock, &until)
                    : i == 6 ? (sem_clockwait(&its.ready, clock, &until) == 0 ? 0 : errno)
                             : pthread_clockjoin_np(thread, &result, clock, &until);
        assert_int_equal(pthread_mutex_unlock(&own), 0);
        if (error != ETIMEDOUT)
            fail_msg("wait %u: %s", i, strerror(error));
        if (is_virtual)
            assert_in_range(now_ns() - since_ns, 3 * MS - 10000, 3 * MS + 10000);
    }
    assert_int_equal(pthread_rwlock_rdlock(&its.lock), 0); /* readers share it */
    assert_int_equal(pthread_rwlock_unlock(&its.lock), 0);
    sem_post(&its.release);
    struct timespec late = after(CLOCK_REALTIME, 5 * (uint64_t)S);
    assert_int_equal(pthread_mutex_timedlock(&its.mutex, &late), 0); /* free before its deadline */
    assert_int_equal(pthread_mutex_unlock(&its.mutex), 0);
    assert_int_equal(pthread_rwlock_wrlock(&its.lock), 0);
    assert_int_equal(pthread_rwlock_unlock(&its.lock), 0);
    assert_int_equal(pthread_timedjoin_np(thread, &result, &late), 0);
    assert_ptr_equal(result, &its);
}

/* Errors of the C library are unchanged. */
static void misuse_of_locks(void **state)
{
    pthread_mutexattr_t attributes;
    pthread_mutex_t checked;
    pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
    (void)state;
    pthread_mutexattr_init(&attributes);
    pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_ERRORCHECK);
    pthread_mutex_init(&checked, &attributes);
    assert_int_equal(pthread_mutex_unlock(&checked), EPERM);
    assert_int_equal(pthread_cond_wait(&condition, &checked), EPERM);
    assert_int_equal(pthread_mutex_lock(&checked), 0);
    assert_int_equal(pthread_mutex_lock(&checked), EDEADLK);
    assert_int_equal(pthread_mutex_unlock(&checked), 0);
    pthread_mutex_destroy(&checked);
    assert_int_equal(pthread_cond_signal(&condition), 0); /* no thread waits */
    assert_int_equal(pthread_cond_broadcast(&condition), 0);
    sem_t semaphore;
    sem_init(&semaphore, 0, 2);
    assert_int_equal(sem_wait(&semaphore), 0);
    assert_int_equal(sem_trywait(&semaphore), 0);
    assert_int_equal(sem_trywait(&semaphore), -1);
    sem_init(&semaphore, 0, INT_MAX);
    assert_int_equal(sem_post(&semaphore), -1);
    assert_int_equal(errno, EOVERFLOW);
}

static void *wait_for_condition(void *arg)
{
    held_t *its = arg;
    pthread_mutex_lock(&its->mutex);
    sem_post(&its->ready);
    while (its->word == 0)
        pthread_cond_wait(&its->condition, &its->mutex);
    its->word--;
    its->woken++;
    pthread_mutex_unlock(&its->mutex);
    return NULL;
}

/* signal wakes one thread, broadcast all. */
static void signals_of_conditions(void **state)
{
    enum { THREADS = 4 };
    held_t its = {.mutex = PTHREAD_MUTEX_INITIALIZER, .condition = PTHREAD_COND_INITIALIZER};
    pthread_t threads[THREADS];
    (void)state;
    sem_init(&its.ready, 0, 0);
    for (unsigned int i = 0; i < THREADS; i++) {
        assert_int_equal(pthread_create(&threads[i], NULL, wait_for_condition, &its), 0);
        assert_int_equal(sem_wait(&its.ready), 0);
    }
    pthread_mutex_lock(&its.mutex);
    its.word = 1;
    pthread_cond_signal(&its.condition);
    pthread_mutex_unlock(&its.mutex);
    do {
        usleep(20000);
        pthread_mutex_lock(&its.mutex);
        pthread_mutex_unlock(&its.mutex);
    } while (its.woken == 0);
    pthread_mutex_lock(&its.mutex);
    assert_int_equal(its.woken, 1);
    its.word = THREADS - 1;
    pthread_cond_broadcast(&its.condition);
    pthread_mutex_unlock(&its.mutex);
    for (unsigned int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    assert_int_equal(its.woken, THREADS);
}

static long futex(int *word, int operation, int value, const struct timespec *timeout)
{
    return syscall(SYS_futex, word, operation | FUTEX_PRIVATE_FLAG, value, timeout, NULL, FUTEX_BITSET_MATCH_ANY);
}

static void *wait_at_futex(void *arg)
{
    held_t *its = arg;
    sem_post(&its->ready);
    return futex(&its->word, FUTEX_WAIT, 0, NULL) == 0 ? its : NULL;
}

/* Locks of other languages wait by futex(). */
static void futexes(void **state)
{
    static const struct {
        int operation;
        clockid_t clock;
    } rows[] = {{FUTEX_WAIT, -1},
                {FUTEX_WAIT_BITSET, CLOCK_MONOTONIC},
                {FUTEX_WAIT_BITSET | FUTEX_CLOCK_REALTIME, CLOCK_REALTIME}};
    held_t its = {0};
    pthread_t threads[3];
    (void)state;
    sem_init(&its.ready, 0, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const struct timespec until = rows[i].clock < 0 ? span(3 * MS) : after(rows[i].clock, 3 * MS);
        uint64_t since_ns = now_ns();
        assert_int_equal(futex(&its.word, rows[i].operation, 1, &until), -1);
        assert_int_equal(errno, EAGAIN);
        assert_int_equal(futex(&its.word, rows[i].operation, 0, &until), -1);
        assert_int_equal(errno, ETIMEDOUT);
        if (is_virtual)
            assert_in_range(now_ns() - since_ns, 3 * MS - 10000, 3 * MS + 10000);
    }
    for (unsigned int i = 0; i < 3; i++) {
        assert_int_equal(pthread_create(&threads[i], NULL, wait_at_futex, &its), 0);
        assert_int_equal(sem_wait(&its.ready), 0);
    }
    usleep(20000);
    long woken = 0;
    while (woken < 1) /* on the real clock a thread may not wait yet */
        woken = futex(&its.word, FUTEX_WAKE, 1, NULL);
    assert_int_equal(woken, 1);
    if (is_virtual)
        assert_int_equal(futex(&its.word, FUTEX_WAKE_BITSET, 5, NULL), 2);
    while (!is_virtual && woken < 3)
        woken += futex(&its.word, FUTEX_WAKE_BITSET, 5, NULL);
    assert_int_equal(futex(&its.word, FUTEX_WAKE, 5, NULL), 0);
    for (unsigned int i = 0; i < 3; i++) {
        void *result = NULL;
        assert_int_equal(pthread_join(threads[i], &result), 0);
        assert_ptr_equal(result, &its);
    }
    assert_int_equal(syscall(SYS_getpid), getpid());
}

static void *end_at_once(void *arg)
{
    if (arg)
        pthread_exit(arg);
    return NULL;
}

/* Threads that end before they are joined, by return or pthread_exit, in any order; detached ones. */
static void ends_of_threads(void **state)
{
    enum { THREADS = 5 };
    static int values[THREADS];
    pthread_t threads[THREADS];
    pthread_attr_t detached;
    (void)state;
    for (unsigned int round = 0; round < 300; round++) { /* places of threads that have ended are used again */
        for (unsigned int i = 0; i < THREADS; i++)
            assert_int_equal(pthread_create(&threads[i], NULL, end_at_once, &values[i]), 0);
        for (unsigned int i = 0; i < THREADS; i++) {
            const unsigned int n = (i + round) % THREADS;
            void *result = NULL;
            assert_int_equal(pthread_join(threads[n], &result), 0);
            assert_ptr_equal(result, &values[n]);
        }
    }
    pthread_attr_init(&detached);
    pthread_attr_setdetachstate(&detached, PTHREAD_CREATE_DETACHED);
    assert_int_equal(pthread_create(&threads[0], &detached, end_at_once, NULL), 0);
    pthread_attr_destroy(&detached);
    usleep(1000);
    assert_int_equal(sched_yield(), 0);
}

static void *come(void *arg)
{
    pthread_barrier_t *barrier = arg;
    usleep(2000);
    return pthread_barrier_wait(barrier) == PTHREAD_BARRIER_SERIAL_THREAD ? arg : NULL;
}

/* A barrier of one, and two barriers side by side; it may be destroyed by the first that leaves it. */
static void barriers(void **state)
{
    pthread_barrier_t barriers_of[2], alone;
    pthread_t threads[2];
    (void)state;
    assert_int_equal(pthread_barrier_init(&alone, NULL, 0), EINVAL);
    assert_int_equal(pthread_barrier_init(&alone, NULL, 1), 0);
    assert_int_equal(pthread_barrier_wait(&alone), PTHREAD_BARRIER_SERIAL_THREAD);
    assert_int_equal(pthread_barrier_wait(&alone), PTHREAD_BARRIER_SERIAL_THREAD);
    for (unsigned int i = 0; i < 2; i++) {
        assert_int_equal(pthread_barrier_init(&barriers_of[i], NULL, 2), 0);
        assert_int_equal(pthread_create(&threads[i], NULL, come, &barriers_of[i]), 0);
    }
    for (unsigned int i = 2; i-- > 0;) {
        void *result = NULL;
        bool serial = pthread_barrier_wait(&barriers_of[i]) == PTHREAD_BARRIER_SERIAL_THREAD;
        assert_int_equal(pthread_barrier_destroy(&barriers_of[i]), 0);
        assert_int_equal(pthread_join(threads[i], &result), 0);
        assert_int_equal((result != NULL) + serial, 1);
    }
    assert_int_equal(pthread_barrier_destroy(&alone), 0);
}

/* --- processes ---------------------------------------------------------------------------------------------------- */

static void waits_for_processes(void **state)
{
    int status = -1, pipe_fds[2];
    siginfo_t info = {.si_pid = 77};
    char byte = 0;
    (void)state;
    assert_int_equal(pipe(pipe_fds), 0);
    assert_int_equal(waitpid(-1, &status, 0), -1);
    assert_int_equal(errno, ECHILD);
    pid_t child = fork();
    if (child == 0) {
        raise(SIGSTOP);
        _exit(read(pipe_fds[0], &byte, 1) == 1 ? 4 : 5); /* not before it was seen to go on */
    }
    assert_int_equal(waitpid(child, &status, WUNTRACED), child);
    assert_true(WIFSTOPPED(status) && WSTOPSIG(status) == SIGSTOP);
    if (!is_virtual) { /* the virtual clock gives a process a second to end */
        assert_int_equal(waitpid(child, &status, WNOHANG), 0);
        assert_int_equal(waitid(P_PID, (id_t)child, &info, WEXITED | WNOHANG), 0);
        assert_int_equal(info.si_pid, 0);
    }
    kill(child, SIGCONT);
    assert_int_equal(waitid(P_PID, (id_t)child, &info, WCONTINUED), 0);
    assert_int_equal(info.si_code, CLD_CONTINUED);
    assert_int_equal(write(pipe_fds[1], "x", 1), 1);
    assert_int_equal(waitid(P_ALL, 0, &info, WEXITED | WNOWAIT), 0);
    assert_int_equal(info.si_pid, child);
    assert_int_equal(waitpid(child, &status, WNOHANG), child);
    assert_int_equal(WEXITSTATUS(status), 4);
    assert_int_equal(wait(&status), -1);
    assert_int_equal(errno, ECHILD);
    for (unsigned int i = 0; i < 2; i++)
        close(pipe_fds[i]);
}

/* On the virtual clock a process that is about to end has ended: its speed does not show. */
static void processes_that_are_about_to_end(void **state)
{
    int fd = open_socket(0); /* the clock is that of a bus */
    (void)state;
    for (unsigned int i = 0; is_virtual && i < 20; i++) {
        int status = -1;
        const pid_t child = fork();
        if (child == 0)
            _exit(3);
        assert_int_equal(waitpid(child, &status, WNOHANG), child);
        assert_int_equal(WEXITSTATUS(status), 3);
    }
    close(fd);
}

/* A handler of a signal, which another process sends, ends each wait for a process. */
static void interrupted_waits_for_processes(void **state)
{
    struct sigaction action = {.sa_handler = on_signal};
    int status = -1, pipe_fds[2];
    siginfo_t info;
    (void)state;
    assert_int_equal(pipe(pipe_fds), 0);
    assert_int_equal(sigaction(SIGUSR2, &action, NULL), 0);
    const pid_t parent = getpid(), child = fork();
    if (child == 0) { /* until the parent closes the pipe */
        struct pollfd one = {.fd = pipe_fds[0], .events = POLLIN};
        close(pipe_fds[1]);
        while (poll(&one, 1, 1) == 0)
            kill(parent, SIGUSR2);
        _exit(0);
    }
    for (unsigned int i = 0; i < 4; i++) {
        pid_t ended = i == 0   ? wait(&status)
                      : i == 1 ? waitpid(child, &status, 0)
                      : i == 2 ? wait4(child, &status, 0, NULL)
                               : waitid(P_PID, (id_t)child, &info, WEXITED);
        const int error = errno;
        assert_int_equal(ended, -1);
        assert_int_equal(error, EINTR);
    }
    close(pipe_fds[1]);
    pid_t ended = -1;
    while (ended < 0)
        ended = waitpid(child, &status, 0);
    assert_int_equal(ended, child);
    assert_true(WIFEXITED(status));
    close(pipe_fds[0]);
    signal(SIGUSR2, SIG_DFL);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"All clocks pass alike, but that of the processor", clocks, NULL, NULL, NULL},
        {"The functions of the time of day agree to their resolution", times_of_the_day, NULL, NULL, NULL},
        {"Times that are none are refused, times that are over end at once", wrong_times, NULL, NULL, NULL},
        {"poll returns the requested events, of sockets alone and with others", results_of_poll, NULL, NULL, NULL},
        {"select and pselect return three sets", results_of_select, NULL, NULL, NULL},
        {"epoll: each frame an edge, all frames a level", results_of_epoll, NULL, NULL, NULL},
        {"A pending signal that the mask of a wait lets through ends it", masks_of_waits, NULL, NULL, NULL},
        {"Reads of other descriptors wait, unless they must not", reads_of_other_descriptors, NULL, NULL, NULL},
        {"A timer descriptor is set, read and stopped", timer_descriptors, NULL, NULL, NULL},
        {"Each of several timer descriptors expires at its own time", several_timer_descriptors, NULL, NULL, NULL},
        {"dup(2): each copy of a timer descriptor is the timer", copies_of_a_timer_descriptor, NULL, NULL, NULL},
        {"close(2), close_range(2), dup2(2): a file with the number of a closed timer gets no expiry",
         the_end_of_a_timer_descriptor, NULL, NULL, NULL},
        {"timerfd_create(2): unknown clocks and flags, and invalid times, are refused with EINVAL",
         calls_of_timer_descriptors_that_are_refused, NULL, NULL, NULL},
        {"vfork(2): a child that closes a timer descriptor leaves the timer of its parent",
         a_child_of_vfork_and_a_timer_descriptor, NULL, NULL, NULL},
        {"fork(2): a child has the timers of its parent", a_child_of_fork_has_the_timer_descriptors, NULL, NULL, NULL},
        {"A timer of POSIX shows the time left and its interval", timers_of_posix, NULL, NULL, NULL},
        {"timer_create without a description, setitimer and alarm send SIGALRM", a_timer_without_a_description, NULL,
         NULL, NULL},
        {"Every wait with a deadline ends there, on each clock", deadlines, NULL, NULL, NULL},
        {"Misuse of a lock gets the error of the C library", misuse_of_locks, NULL, NULL, NULL},
        {"signal wakes one thread, broadcast all", signals_of_conditions, NULL, NULL, NULL},
        {"futex waits, times out and wakes as many as asked", futexes, NULL, NULL, NULL},
        {"Threads end in any order, and their places are used again", ends_of_threads, NULL, NULL, NULL},
        {"Barriers side by side, and one that is destroyed at once", barriers, NULL, NULL, NULL},
        {"On the virtual clock a process has ended before a call that does not wait for it",
         processes_that_are_about_to_end, NULL, NULL, NULL},
        {"A handler of a signal ends each wait for a process", interrupted_waits_for_processes, NULL, NULL, NULL},
        {"waitpid and waitid report stopped, continued and ended processes", waits_for_processes, NULL, NULL, NULL},
    };
    if (!is_started(argc, argv))
        return 1;
    int fd = open_socket(0); /* starts the bus */
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    close(fd);
    return failed;
}
