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
#include "fakes.h"

/* Descriptors that are numbers only. */
enum { OTHER = 5, TIMER = 9, DESCRIPTORS = 65536 };

OURS(timerfd_create);
OURS(timerfd_gettime);
OURS(timerfd_settime);

static uint64_t now_ns;
static ect_timer_t *added;
static pid_t process = 50; /* that the program is */
static void (*in_child)(void);

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

FAKES(FAKE(poll), FAKE(write), FAKE(read), FAKE(close), FAKE(timerfd_create), FAKE(timerfd_gettime),
      FAKE(timerfd_settime))

int fake_eventfd(unsigned int value, int flags);
int fake_eventfd(unsigned int value, int flags)
{
    return (int)CALLED(eventfd, value, flags);
}

void *fake_calloc(size_t count, size_t size);
void *fake_calloc(size_t count, size_t size)
{
    return planned("calloc") != 0 ? NULL : calloc(count, size);
}

pid_t fake_getpid(void);
pid_t fake_getpid(void)
{
    return process;
}

int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void));
int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void))
{
    in_child = !prepare && !parent ? child : NULL;
    return 0;
}

uint64_t ect_virtual_now(void)
{
    return now_ns;
}

void ect_virtual_add_timer(ect_timer_t *timer)
{
    assert_true(timer->inherited);
    added = timer;
}

void ect_virtual_remove_timer(ect_timer_t *timer)
{
    CALLED(remove, timer == added);
}

void ect_eventfd_renew(int fd, bool readable)
{
    CALLED(renew, fd, readable);
}

void ect_eventfd_replace(int fd, int other)
{
    CALLED(replace, fd, other);
}

static int begin(void **state)
{
    now_ns = ECT_VIRTUAL_START_NS;
    ect_inside = 0;
    ect_time_closed(0, UINT_MAX);
    return begin_fakes(state);
}

static int new_timer(int fd, int clock)
{
    plan("eventfd", fd, 0);
    assert_int_equal(ours_timerfd_create(clock, 0), fd);
    forget_calls();
    return fd;
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
        assert_true(added->next_ns == UINT64_MAX);
        added->expired(added);
        EXPECT_CALLS("an expiry", "write(0,1) ");
        ect_time_closed(OTHER, OTHER);
        EXPECT_CALLS("another is closed", "");
        ect_time_closed(0, 0);
        EXPECT_CALLS("close", "remove(1) ");
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
        ect_time_closed(0, UINT_MAX);
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

/* The memory of closed timers is used first. */
static void has_no_memory(void **state)
{
    int count = 0;
    (void)state;
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    (void)new_timer(TIMER + 1, CLOCK_MONOTONIC);
    for (int fd = TIMER; fd >= 0; count++) {
        plan("eventfd", TIMER + 2 + count, 0);
        plan("calloc", 1, 0);
        fd = ours_timerfd_create(CLOCK_MONOTONIC, 0);
        forget_calls();
    }
    assert_in_range(count, 1, 100);
    ect_time_closed(TIMER, TIMER);
    ect_time_closed(TIMER + 1, TIMER + 1);
    forget_calls();
    for (int i = 0; i < 2; i++) {
        plan("calloc", 1, 0);
        plan("eventfd", TIMER + i, 0);
        assert_int_equal(ours_timerfd_create(CLOCK_MONOTONIC, 0), TIMER + i);
        forget_calls();
    }
    plan("calloc", 1, 0);
    assert_int_equal(ours_timerfd_create(CLOCK_MONOTONIC, 0), -1);
    EXPECT_CALLS("no memory", "");
}

/* Expiries are written to a descriptor that is still open. */
static void lives_as_long_as_a_copy(void **state)
{
    const struct itimerspec value = {.it_value = {2, 3}};
    (void)state;
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    ect_time_copied(TIMER, 0);
    ect_time_copied(0, DESCRIPTORS - 1);
    ect_time_copied(TIMER, -1);
    ect_time_copied(TIMER, DESCRIPTORS);
    ect_time_copied(OTHER, OTHER + 1);
    ect_time_copied(-1, OTHER + 1);
    ect_time_closed(TIMER, TIMER);
    added->expired(added);
    EXPECT_CALLS("the first copy", "write(0,1) ");
    assert_int_equal(ours_timerfd_settime(0, 0, &value, NULL), 0);
    assert_true(added->next_ns == ECT_VIRTUAL_START_NS + 2 * ECT_NS_PER_S + 3);
    forget_calls();
    ect_time_closed(0, DESCRIPTORS - 2);
    added->expired(added);
    EXPECT_CALLS("the last", "write(65535,1) ");
    ect_time_closed(DESCRIPTORS - 1, UINT_MAX);
    EXPECT_CALLS("none", "remove(1) ");
    (void)ours_timerfd_settime(OTHER + 1, 0, &value, NULL);
    forget_calls();
}

static void closes_a_range(void **state)
{
    static const struct {
        unsigned int from, to;
        const char *closed; /* of TIMER, TIMER + 1, TIMER + 2 */
    } rows[] = {{TIMER + 1, TIMER + 1, "remove(0) "},
                {TIMER + 1, UINT_MAX, "remove(0) remove(1) "},
                {0, TIMER, "remove(0) "},
                {0, TIMER - 1, ""},
                {TIMER + 3, UINT_MAX, ""},
                {0x80000000u, UINT_MAX, ""},
                {TIMER + 2, TIMER, ""}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (int n = 0; n < 3; n++)
            (void)new_timer(TIMER + n, CLOCK_MONOTONIC);
        ect_time_closed(rows[i].from, rows[i].to);
        EXPECT_CALLS("a range", rows[i].closed);
        ect_time_closed(0, UINT_MAX);
        forget_calls();
    }
}

/* Its memory is that of the program. */
static void ignores_a_child_of_vfork(void **state)
{
    (void)state;
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    process++;
    ect_time_copied(TIMER, OTHER);
    ect_time_closed(TIMER, TIMER);
    EXPECT_CALLS("closed by the child", "");
    process--;
    ect_time_closed(TIMER, TIMER);
    EXPECT_CALLS("closed by the parent", "remove(1) ");
}

static void gets_eventfds_in_a_child(void **state)
{
    (void)state;
    (void)new_timer(TIMER, CLOCK_MONOTONIC);
    (void)new_timer(TIMER + 2, CLOCK_MONOTONIC);
    ect_time_copied(TIMER, TIMER + 1);
    assert_non_null(in_child);
    process++;
    plan("poll", 1, 0);
    plan("poll", -1, 0);
    in_child();
    EXPECT_CALLS("two timers", "poll(9,0) renew(9,1) poll(11,0) renew(11,0) replace(10,9) ");
    ect_time_closed(TIMER + 2, TIMER + 2);
    EXPECT_CALLS("closed by the child", "remove(1) ");
}

static void runs_timers(void **state)
{
    const struct itimerspec value = {.it_value = {2, 3}, .it_interval = {4, 5}};
    const struct itimerspec of_day = {.it_value = {(time_t)(ECT_VIRTUAL_DAY_NS / ECT_NS_PER_S) + 8, 2}};
    struct itimerspec left = {0};
    (void)state;
    (void)new_timer(TIMER, CLOCK_REALTIME);
    ect_timer_t *first = added;
    (void)new_timer(TIMER + 1, CLOCK_MONOTONIC);
    assert_int_equal(ours_timerfd_settime(TIMER, 0, &value, NULL), 0);
    EXPECT_CALLS("no expiry is unread", "poll(9,0) ");
    assert_true(first->next_ns == ECT_VIRTUAL_START_NS + 2 * ECT_NS_PER_S + 3);
    assert_true(added->next_ns == UINT64_MAX);
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
    ect_time_closed(TIMER, TIMER);
    EXPECT_CALLS("close", "remove(0) ");
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
        assert_int_equal(added->next_ns == UINT64_MAX, rows[i].error != 0);
        ect_time_closed(TIMER, TIMER);
        forget_calls();
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A timer descriptor is an eventfd", creates_timers, begin, NULL, NULL},
        {"timerfd_create(2): other clocks and flags are refused with EINVAL", refuses_to_create, begin, NULL, NULL},
        {"A timer gets the memory of a closed one", has_no_memory, begin, NULL, NULL},
        {"A timer lives as long as a copy of its descriptor", lives_as_long_as_a_copy, begin, NULL, NULL},
        {"The timers of a range of descriptors are closed", closes_a_range, begin, NULL, NULL},
        {"A child of vfork() changes no timers", ignores_a_child_of_vfork, begin, NULL, NULL},
        {"Timers have eventfds of their own in a child of fork()", gets_eventfds_in_a_child, begin, NULL, NULL},
        {"A timer descriptor is set, read and closed", runs_timers, begin, NULL, NULL},
        {"timerfd_settime(2): flags and times that do not exist are refused with EINVAL", refuses_times, begin, NULL,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
