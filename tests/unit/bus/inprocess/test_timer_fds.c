/* SPDX-License-Identifier: MIT */
/* Timer descriptors on the virtual clock. */
#define _GNU_SOURCE
#include <limits.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "fake_eventfds.h"
#include "fake_process.h"
#include "fakes.h"

/* Descriptors that are numbers only. */
enum { OTHER = 5, TIMER = 9, DESCRIPTORS = 65536 };

OURS(timerfd_create);
OURS(timerfd_gettime);
OURS(timerfd_settime);

static uint64_t now_ns;
enum { TIMERS = 64 };
static ect_timer_t *timers[TIMERS]; /* in the list of the virtual clock */
static size_t timer_count;

static int fake_poll(struct pollfd *fds, nfds_t count, int timeout_ms)
{
    assert_int_equal(count, 1);
    assert_int_equal(fds[0].events, POLLIN);
    return (int)CALLED(poll, fds[0].fd, timeout_ms);
}

static ssize_t fake_write(int fd, const void *data, size_t size)
{
    eventfd_t value;
    assert_int_equal(size, sizeof value);
    memcpy(&value, data, sizeof value);
    CALLED(write, fd, (long)value);
    return (ssize_t)size;
}

static ssize_t fake_read(int fd, void *data, size_t size)
{
    memset(data, 0, size);
    CALLED(read, fd, (long)size);
    return (ssize_t)size;
}

static int fake_close(int fd)
{
    return (int)CALLED(close, fd);
}

static int fake_fcntl(int fd, int command, ...)
{
    return (int)CALLED(fcntl, fd, command);
}

static int fake_dup3(int fd, int to, int flags)
{
    return (int)CALLED(dup3, fd, to, flags);
}

static int fake_timerfd_create(int clock, int flags)
{
    return (int)CALLED(timerfd_create, clock, flags);
}

static int fake_timerfd_gettime(int fd, struct itimerspec *value)
{
    return (int)CALLED(timerfd_gettime, fd, (long)value);
}

static int fake_timerfd_settime(int fd, int flags, const struct itimerspec *value, struct itimerspec *before)
{
    return (int)CALLED(timerfd_settime, fd, flags, (long)value, (long)before);
}

FAKES(FAKE(poll), FAKE(write), FAKE(read), FAKE(close), FAKE(fcntl), FAKE(dup3), FAKE(timerfd_create),
      FAKE(timerfd_gettime), FAKE(timerfd_settime))

uint64_t ect_virtual_now(void)
{
    return now_ns;
}

void ect_time_lock(void)
{
}

void ect_time_unlock(void)
{
}

void ect_virtual_add_timer(ect_timer_t *timer)
{
    assert_true(timer->inherited && timer->next_ns == UINT64_MAX);
    assert_true(timer_count < TIMERS);
    timers[timer_count++] = timer;
}

static int begin(void **state)
{
    now_ns = ECT_VIRTUAL_START_NS;
    ect_inside = 0;
    ect_eventfds_closed(0, UINT_MAX);
    return begin_fakes(state);
}

static int new_timer(int fd, int clock)
{
    plan("eventfd", fd, 0);
    assert_int_equal(ours_timerfd_create(clock, 0), fd);
    forget_calls();
    return fd;
}

/* @return the timer whose expiries are written to a descriptor */
static ect_timer_t *timer_at(int fd)
{
    char want[32];
    snprintf(want, sizeof want, "write(%d,1) ", fd);
    for (size_t i = 0; i < timer_count; i++) {
        forget_calls();
        timers[i]->expired(timers[i]);
        const bool found = strcmp(fakes.log, want) == 0;
        forget_calls();
        if (found)
            return timers[i];
    }
    fail_msg("no timer is written to %d", fd);
    return NULL;
}

static void creates_timers(void **state)
{
    static const struct {
        int flags, given;
    } rows[] = {{0, 0},
                {TFD_CLOEXEC, EFD_CLOEXEC},
                {TFD_NONBLOCK, EFD_NONBLOCK},
                {TFD_CLOEXEC | TFD_NONBLOCK, EFD_CLOEXEC | EFD_NONBLOCK}};
    char want[64];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        plan("eventfd", 0, 0); /* any number is a descriptor */
        assert_int_equal(ours_timerfd_create(CLOCK_MONOTONIC, rows[i].flags), 0);
        snprintf(want, sizeof want, "eventfd(0,%d) ", rows[i].given);
        EXPECT_CALLS("create", want);
        assert_true(timer_at(0)->next_ns == UINT64_MAX);
        ect_eventfds_closed(0, 0);
    }
    ect_inside = 1;
    plan("timerfd_create", 8, 0);
    assert_int_equal(ours_timerfd_create(CLOCK_PROCESS_CPUTIME_ID, 2), 8);
    EXPECT_CALLS("of the library", "timerfd_create(2,2) ");
}

static void refuses_to_create(void **state)
{
    static const struct {
        int clock, flags, error; /* 0: accepted */
    } rows[] = {{CLOCK_REALTIME, 0, 0},
                {CLOCK_BOOTTIME, 0, 0},
                {CLOCK_REALTIME_ALARM, 0, 0},
                {CLOCK_BOOTTIME_ALARM, 0, 0},
                {CLOCK_PROCESS_CPUTIME_ID, 0, EINVAL},
                {CLOCK_MONOTONIC_RAW, 0, EINVAL},
                {CLOCK_TAI, 0, EINVAL},
                {-1, 0, EINVAL},
                {CLOCK_MONOTONIC, 1, EINVAL},
                {CLOCK_MONOTONIC, TFD_CLOEXEC | 0x10, EINVAL}};
    char want[64];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        plan("eventfd", rows[i].error == 0 ? TIMER : 0, 0);
        errno = 0;
        int fd = ours_timerfd_create(rows[i].clock, rows[i].flags);
        if (fd != (rows[i].error == 0 ? TIMER : -1) || errno != rows[i].error)
            fail_msg("clock %d, flags %x: got %d, errno %d", rows[i].clock, (unsigned int)rows[i].flags, fd, errno);
        forget_calls();
        ect_eventfds_closed(0, UINT_MAX);
        forget_calls();
    }
    plan("eventfd", -1, EMFILE);
    assert_int_equal(ours_timerfd_create(CLOCK_MONOTONIC, 0), -1);
    EXPECT_CALLS("no descriptor is left", "eventfd(0,0) ");
    plan("eventfd", DESCRIPTORS, 0);
    assert_int_equal(ours_timerfd_create(CLOCK_MONOTONIC, 0), -1);
    assert_int_equal(errno, EMFILE);
    snprintf(want, sizeof want, "eventfd(0,0) close(%d) ", DESCRIPTORS);
    EXPECT_CALLS("too high", want);
    assert_int_equal(new_timer(DESCRIPTORS - 1, CLOCK_MONOTONIC), DESCRIPTORS - 1);
}

static void has_no_memory(void **state)
{
    int fd = TIMER;
    (void)state;
    do { /* in the memory of closed ones */
        plan("eventfd", fd++, 0);
        plan("calloc", 1, 0);
        errno = 0;
    } while (ours_timerfd_create(CLOCK_MONOTONIC, 0) >= 0);
    forget_calls();
    assert_true(fd < TIMER + TIMERS);
}

/* Expiries are written to a descriptor that is still open. */
static void lives_as_long_as_a_copy(void **state)
{
    const struct itimerspec value = {.it_value = {2, 3}};
    (void)state;
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    ect_timer_t *timer = timer_at(TIMER);
    ect_eventfd_copied(TIMER, 0);
    ect_eventfds_closed(TIMER, TIMER);
    assert_ptr_equal(timer_at(0), timer);
    assert_int_equal(ours_timerfd_settime(0, 0, &value, NULL), 0);
    assert_true(timer->next_ns == ECT_VIRTUAL_START_NS + 2 * ECT_NS_PER_S + 3);
    ect_eventfds_closed(0, 0);
    assert_true(timer->next_ns == UINT64_MAX);
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    assert_ptr_equal(timer_at(TIMER), timer);
    forget_calls();
}

static void gets_eventfds_in_a_child(void **state)
{
    (void)state;
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    (void)new_timer(TIMER + 2, CLOCK_MONOTONIC);
    plan("poll", 1, 0);
    plan("poll", -1, 0);
    plan("eventfd", -1, EMFILE);
    plan("eventfd", -1, EMFILE);
    in_child();
    EXPECT_CALLS("an expiry is unread in the first", "poll(9,0) eventfd(1,2048) poll(11,0) eventfd(0,2048) ");
}

static void runs_timers(void **state)
{
    const struct itimerspec value = {.it_value = {2, 3}, .it_interval = {4, 5}};
    const struct itimerspec of_day = {.it_value = {(time_t)(ECT_VIRTUAL_DAY_NS / ECT_NS_PER_S) + 8, 2}};
    struct itimerspec left = {0};
    (void)state;
    (void)new_timer(TIMER, CLOCK_REALTIME);
    ect_timer_t *first = timer_at(TIMER);
    (void)new_timer(TIMER + 1, CLOCK_MONOTONIC);
    assert_int_equal(ours_timerfd_settime(TIMER, 0, &value, NULL), 0);
    EXPECT_CALLS("no expiry is unread", "poll(9,0) ");
    assert_true(first->next_ns == ECT_VIRTUAL_START_NS + 2 * ECT_NS_PER_S + 3);
    assert_true(timer_at(TIMER + 1)->next_ns == UINT64_MAX);
    now_ns += ECT_NS_PER_S;
    assert_int_equal(ours_timerfd_gettime(TIMER, &left), 0);
    assert_int_equal(left.it_value.tv_sec, 1);
    assert_int_equal(left.it_interval.tv_sec, 4);
    plan("poll", 1, 0);
    left = (struct itimerspec){0};
    assert_int_equal(ours_timerfd_settime(TIMER, TFD_TIMER_ABSTIME, &of_day, &left), 0);
    EXPECT_CALLS("an expiry is unread", "poll(9,0) read(9,8) ");
    assert_int_equal(left.it_value.tv_sec, 1);
    assert_true(first->next_ns == ECT_VIRTUAL_START_NS + 8 * ECT_NS_PER_S + 2);
    ect_eventfds_closed(TIMER, TIMER);
    assert_true(first->next_ns == UINT64_MAX);
    plan("timerfd_gettime", -1, EINVAL);
    assert_int_equal(ours_timerfd_gettime(TIMER, AT(8)), -1);
    plan("timerfd_settime", -1, EINVAL);
    assert_int_equal(ours_timerfd_settime(TIMER, 1, AT(8), AT(9)), -1);
    EXPECT_CALLS("a closed one", "timerfd_gettime(9,8) timerfd_settime(9,1,8,9) ");
    ect_inside = 1;
    plan("timerfd_gettime", 6, 0);
    assert_int_equal(ours_timerfd_gettime(TIMER + 1, AT(8)), 6);
    plan("timerfd_settime", 7, 0);
    assert_int_equal(ours_timerfd_settime(TIMER + 1, 1, AT(8), AT(9)), 7);
    forget_calls();
}

static void refuses_times(void **state)
{
    static const struct {
        int flags, error;
        struct itimerspec value;
    } rows[] = {{0, 0, {{0, 999999999}, {0, 999999999}}},
                {TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, 0, {.it_value = {5, 0}}},
                {4, EINVAL, {.it_value = {5, 0}}},
                {0, EINVAL, {.it_value = {0, 1000000000}}},
                {0, EINVAL, {.it_value = {-1, 0}}},
                {0, EINVAL, {{0, 1000000000}, {5, 0}}},
                {0, EINVAL, {{-1, 0}, {5, 0}}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        (void)new_timer(TIMER, CLOCK_MONOTONIC);
        errno = 0;
        int result = ours_timerfd_settime(TIMER, rows[i].flags, &rows[i].value, NULL);
        if (result != (rows[i].error == 0 ? 0 : -1) || errno != rows[i].error)
            fail_msg("row %zu: got %d, errno %d", i, result, errno);
        assert_int_equal(timer_at(TIMER)->next_ns == UINT64_MAX, rows[i].error != 0);
        ect_eventfds_closed(TIMER, TIMER);
        forget_calls();
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A timer descriptor is an eventfd", creates_timers, begin, NULL, NULL},
        {"timerfd_create(2): unknown clocks and flags are refused with EINVAL", refuses_to_create, begin, NULL, NULL},
        {"Without memory no timer is created", has_no_memory, begin, NULL, NULL},
        {"A timer lives as long as a copy of its descriptor", lives_as_long_as_a_copy, begin, NULL, NULL},
        {"A timer with an unread expiry is readable in a child of fork()", gets_eventfds_in_a_child, begin, NULL, NULL},
        {"A timer descriptor is set, read and closed", runs_timers, begin, NULL, NULL},
        {"timerfd_settime(2): unknown flags and invalid times are refused with EINVAL", refuses_times, begin, NULL,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
