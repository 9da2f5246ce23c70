/* SPDX-License-Identifier: MIT */
/* Clocks and sleeps on the virtual clock. */
#define _GNU_SOURCE
#include <sched.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/sanitizer.h"
#include "bus/inprocess/time.h"
#include "fakes.h"

OURS(clock_gettime);
OURS(gettimeofday);
OURS(time);
OURS(timespec_get);
OURS(usleep);
OURS(sleep);
OURS(nanosleep);
OURS(clock_nanosleep);
OURS(sched_yield);

enum { START_S = ECT_VIRTUAL_START_NS / ECT_NS_PER_S };
#define DAY_S ((time_t)(ECT_VIRTUAL_DAY_NS / ECT_NS_PER_S))

static uint64_t now_ns;
static bool in_sanitizer;
static ect_wait_t end_of_wait;
static uint64_t interrupted_ns; /* when a handler runs */

static int fake_clock_gettime(clockid_t clock, struct timespec *time)
{
    *time = (struct timespec){.tv_sec = 1};
    return (int)CALLED(clock_gettime, clock);
}

static int fake_gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    return (int)CALLED(gettimeofday, (long)time, (long)zone);
}

static time_t fake_time(time_t *result)
{
    return CALLED(time, (long)result);
}

static int fake_timespec_get(struct timespec *time, int base)
{
    return (int)CALLED(timespec_get, (long)time, base);
}

static int fake_usleep(useconds_t microseconds)
{
    return (int)CALLED(usleep, microseconds);
}

static unsigned int fake_sleep(unsigned int seconds)
{
    return (unsigned int)CALLED(sleep, seconds);
}

static int fake_nanosleep(const struct timespec *time, struct timespec *left)
{
    return (int)CALLED(nanosleep, (long)time, (long)left);
}

static int fake_clock_nanosleep(clockid_t clock, int flags, const struct timespec *time, struct timespec *left)
{
    return (int)CALLED(clock_nanosleep, clock, flags, (long)time, (long)left);
}

static int fake_sched_yield(void)
{
    return (int)CALLED(sched_yield);
}

FAKES(FAKE(clock_gettime), FAKE(gettimeofday), FAKE(time), FAKE(timespec_get), FAKE(usleep), FAKE(sleep),
      FAKE(nanosleep), FAKE(clock_nanosleep), FAKE(sched_yield))

bool ect_sanitizer_has(const void *address)
{
    assert_non_null(address);
    return in_sanitizer;
}

uint64_t ect_virtual_now(void)
{
    return now_ns;
}

void ect_virtual_charge(uint64_t cost_ns)
{
    CALLED(charge, (long)cost_ns);
    now_ns += cost_ns;
}

uint64_t ect_virtual_pass(uint64_t cost_ns)
{
    CALLED(pass, (long)cost_ns);
    return now_ns + cost_ns;
}

void ect_virtual_yield(void)
{
    CALLED(yield);
}

ect_wait_t ect_virtual_wait(const void *key, uint64_t until_ns)
{
    assert_null(key);
    CALLED(wait, (long)(until_ns - ECT_VIRTUAL_START_NS));
    now_ns = end_of_wait == ECT_WAIT_INTERRUPTED ? interrupted_ns : until_ns;
    return end_of_wait;
}

static int begin(void **state)
{
    now_ns = ECT_VIRTUAL_START_NS;
    in_sanitizer = false;
    end_of_wait = ECT_WAIT_TIMED_OUT;
    return begin_fakes(state);
}

/* --- clocks ------------------------------------------------------------------------------------------------------- */

static void reads_each_clock(void **state)
{
    static const struct {
        clockid_t clock;
        bool of_day;
    } rows[] = {{CLOCK_MONOTONIC, false}, {CLOCK_MONOTONIC_RAW, false}, {CLOCK_MONOTONIC_COARSE, false},
                {CLOCK_BOOTTIME, false},  {CLOCK_REALTIME, true},       {CLOCK_REALTIME_COARSE, true},
                {CLOCK_TAI, true}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct timespec time = {0};
        now_ns = ECT_VIRTUAL_START_NS + 3 * ECT_NS_PER_S + 7;
        assert_int_equal(ours_clock_gettime(rows[i].clock, &time), 0);
        assert_int_equal(time.tv_sec, (rows[i].of_day ? DAY_S : START_S) + 3);
        assert_int_equal(time.tv_nsec, 57);
        EXPECT_CALLS("a clock", "charge(50) ");
    }
}

static void leaves_processor_time_real(void **state)
{
    struct timespec time = {0};
    (void)state;
    plan("clock_gettime", -1, EINVAL);
    assert_int_equal(ours_clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time), -1);
    EXPECT_CALLS("of the processor", "clock_gettime(2) ");
    ect_inside = 1;
    assert_int_equal(ours_clock_gettime(CLOCK_MONOTONIC, &time), 0);
    assert_int_equal(time.tv_sec, 1);
    EXPECT_CALLS("of the library", "clock_gettime(1) ");
    ect_in_dlsym = true;
    assert_int_equal(ours_clock_gettime(CLOCK_MONOTONIC, &time), 0);
    assert_int_equal(time.tv_sec, START_S);
    assert_int_equal(time.tv_nsec, 0);
    EXPECT_CALLS("in dlsym", "");
}

static void keeps_the_turn_of_a_sanitizer(void **state)
{
    struct timespec time;
    struct timeval day;
    (void)state;
    in_sanitizer = true;
    assert_int_equal(ours_clock_gettime(CLOCK_MONOTONIC, &time), 0);
    assert_int_equal(time.tv_nsec, 50);
    EXPECT_CALLS("a clock", "pass(50) ");
    assert_int_equal(ours_gettimeofday(&day, NULL), 0);
    assert_int_equal(ours_time(NULL), DAY_S);
    EXPECT_CALLS("the time of day", "pass(50) pass(50) ");
}

static void reads_the_time_of_day(void **state)
{
    struct timeval time;
    time_t seconds = 0;
    (void)state;
    now_ns += 5 * ECT_NS_PER_S + 7000;
    assert_int_equal(ours_gettimeofday(&time, NULL), 0);
    assert_int_equal(time.tv_sec, DAY_S + 5);
    assert_int_equal(time.tv_usec, 7);
    assert_int_equal(ours_time(&seconds), DAY_S + 5);
    assert_int_equal(seconds, DAY_S + 5);
    now_ns += ECT_NS_PER_S;
    assert_int_equal(ours_time(NULL), DAY_S + 6);
    EXPECT_CALLS("costs", "charge(50) charge(50) charge(50) ");
    ect_inside = 1;
    plan("gettimeofday", -1, EFAULT);
    plan("time", 9, 0);
    assert_int_equal(ours_gettimeofday(AT(8), AT(9)), -1);
    assert_int_equal(ours_time(AT(8)), 9);
    EXPECT_CALLS("of the library", "gettimeofday(8,9) time(8) ");
}

static void reads_the_time_of_c11(void **state)
{
    struct timespec time = {0};
    (void)state;
    now_ns += 5 * ECT_NS_PER_S + 7;
    assert_int_equal(ours_timespec_get(&time, TIME_UTC), TIME_UTC);
    assert_int_equal(time.tv_sec, DAY_S + 5);
    assert_int_equal(time.tv_nsec, 57);
    EXPECT_CALLS("costs", "charge(50) ");
    assert_int_equal(ours_timespec_get(AT(5), TIME_UTC), 0);
    EXPECT_CALLS("a bad address", "charge(50) ");
    plan("timespec_get", 2, 0);
    assert_int_equal(ours_timespec_get(&time, 2), 2);
    ect_inside = 1;
    (void)ours_timespec_get(AT(8), TIME_UTC);
    assert_non_null(strstr(fakes.log, ",2) timespec_get(8,1) "));
    forget_calls();
}

/* --- sleeps ------------------------------------------------------------------------------------------------------- */

static void sleeps(void **state)
{
    const struct timespec span = {.tv_sec = 2, .tv_nsec = 3};
    const struct timespec monotonic = {.tv_sec = START_S + 20, .tv_nsec = 4};
    const struct timespec of_day = {.tv_sec = DAY_S + 30, .tv_nsec = 5};
    (void)state;
    assert_int_equal(ours_usleep(7), 0);
    EXPECT_CALLS("usleep", "wait(7000) ");
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_sleep(3), 0);
    EXPECT_CALLS("sleep", "wait(3000000000) ");
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_nanosleep(&span, NULL), 0);
    EXPECT_CALLS("nanosleep", "wait(2000000003) ");
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, &span, NULL), 0);
    EXPECT_CALLS("a span", "wait(4000000006) ");
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &monotonic, NULL), 0);
    EXPECT_CALLS("until", "wait(20000000004) ");
    assert_int_equal(ours_clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &of_day, NULL), 0);
    EXPECT_CALLS("until a time of day", "wait(30000000005) ");
    assert_int_equal(ours_sched_yield(), 0);
    EXPECT_CALLS("yield", "yield() ");
}

static void refuses_what_is_no_time(void **state)
{
    static const struct timespec rows[] = {{-1, 0}, {0, -1}, {0, 1000000000}};
    const struct timespec longest = {0, 999999999};
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        errno = 0;
        assert_int_equal(ours_nanosleep(&rows[i], NULL), -1);
        assert_int_equal(errno, EINVAL);
        assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, &rows[i], NULL), EINVAL);
    }
    EXPECT_CALLS("none", "");
    assert_int_equal(ours_nanosleep(&longest, NULL), 0);
    EXPECT_CALLS("the longest", "wait(999999999) ");
}

/* `left`: of a second, when the handler runs. A handler that runs at the end leaves one nanosecond. */
static void ends_with_a_handler(void **state)
{
    const struct timespec span = {.tv_sec = 5};
    const struct timespec until = {.tv_sec = START_S + 5};
    struct timespec left = {9, 9};
    (void)state;
    end_of_wait = ECT_WAIT_INTERRUPTED;
    interrupted_ns = ECT_VIRTUAL_START_NS + 2 * ECT_NS_PER_S + 3;
    assert_int_equal(ours_usleep(5000000), -1);
    assert_int_equal(errno, EINTR);
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_sleep(5), 2);
    now_ns = ECT_VIRTUAL_START_NS;
    errno = 0;
    assert_int_equal(ours_nanosleep(&span, &left), -1);
    assert_int_equal(errno, EINTR);
    assert_int_equal(left.tv_sec, 2);
    assert_int_equal(left.tv_nsec, 999999997);
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_nanosleep(&span, NULL), -1);
    now_ns = ECT_VIRTUAL_START_NS;
    left = (struct timespec){9, 9};
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, &span, &left), EINTR);
    assert_int_equal(left.tv_sec, 2);
    left = (struct timespec){9, 9};
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, &left), EINTR);
    assert_int_equal(left.tv_sec, 9);
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, &span, NULL), EINTR);
    now_ns = ECT_VIRTUAL_START_NS;
    interrupted_ns = ECT_VIRTUAL_START_NS + 5 * ECT_NS_PER_S;
    assert_int_equal(ours_nanosleep(&span, &left), -1);
    assert_int_equal(left.tv_sec, 0);
    assert_int_equal(left.tv_nsec, 1);
    forget_calls();
}

static void leaves_a_complete_sleep_without_rest(void **state)
{
    const struct timespec span = {.tv_sec = 5};
    struct timespec left = {9, 9};
    (void)state;
    assert_int_equal(ours_nanosleep(&span, &left), 0);
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, &span, &left), 0);
    assert_int_equal(left.tv_sec, 9);
    forget_calls();
}

static void refuses_bad_addresses(void **state)
{
    const struct timespec span = {.tv_sec = 5};
    struct timeval day;
    int (*volatile of_day)(struct timeval *, void *) = ours_gettimeofday; /* the header excludes address 0 */
    (void)state;
    const struct {
        const char *title;
        long result;
    } rows[] = {{"clock_gettime", ours_clock_gettime(CLOCK_MONOTONIC, AT(5))},
                {"clock_gettime of the day", ours_clock_gettime(CLOCK_REALTIME, AT(5))},
                {"gettimeofday", ours_gettimeofday(AT(5), NULL)},
                {"its zone", ours_gettimeofday(&day, AT(5))},
                {"time", ours_time(AT(5))},
                {"nanosleep", ours_nanosleep(AT(5), NULL)}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].result != -1)
            fail_msg("%s: result %ld", rows[i].title, rows[i].result);
    }
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, AT(5), NULL), EFAULT);
    assert_int_equal(of_day(NULL, NULL), 0); /* neither is wanted */
    forget_calls();
    end_of_wait = ECT_WAIT_INTERRUPTED;
    interrupted_ns = ECT_VIRTUAL_START_NS + ECT_NS_PER_S;
    now_ns = ECT_VIRTUAL_START_NS;
    errno = 0;
    assert_int_equal(ours_nanosleep(&span, AT(5)), -1);
    assert_int_equal(errno, EFAULT);
    now_ns = ECT_VIRTUAL_START_NS;
    assert_int_equal(ours_clock_nanosleep(CLOCK_MONOTONIC, 0, &span, AT(5)), EFAULT);
    end_of_wait = ECT_WAIT_TIMED_OUT;
    assert_int_equal(ours_nanosleep(&span, AT(5)), 0); /* a complete sleep leaves nothing */
    forget_calls();
}

static void leaves_the_library_alone(void **state)
{
    (void)state;
    ect_inside = 1;
    plan("usleep", -1, EINTR);
    plan("sleep", 4, 0);
    plan("nanosleep", -1, EINTR);
    plan("clock_nanosleep", EINTR, 0);
    plan("sched_yield", -1, 0);
    assert_int_equal(ours_usleep(7), -1);
    assert_int_equal(ours_sleep(8), 4);
    assert_int_equal(ours_nanosleep(AT(8), AT(16)), -1);
    assert_int_equal(ours_clock_nanosleep(1, 2, AT(8), AT(16)), EINTR);
    assert_int_equal(ours_sched_yield(), -1);
    EXPECT_CALLS("real", "usleep(7) sleep(8) nanosleep(8,16) clock_nanosleep(1,2,8,16) sched_yield() ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"Every clock but those of the processor is virtual", reads_each_clock, begin, NULL, NULL},
        {"Clocks of the processor, of the library and in dlsym", leaves_processor_time_real, begin, NULL, NULL},
        {"A sanitizer that reads a clock keeps the turn", keeps_the_turn_of_a_sanitizer, begin, NULL, NULL},
        {"The time of day begins with 2026", reads_the_time_of_day, begin, NULL, NULL},
        {"timespec_get(3) reads the time of day; other bases are the C library's", reads_the_time_of_c11, begin, NULL,
         NULL},
        {"A sleep is a wait on the virtual clock", sleeps, begin, NULL, NULL},
        {"A time with too many nanoseconds, or a negative one, is refused", refuses_what_is_no_time, begin, NULL, NULL},
        {"A handler ends a sleep; the rest is that of a span", ends_with_a_handler, begin, NULL, NULL},
        {"A complete sleep leaves no rest", leaves_a_complete_sleep_without_rest, begin, NULL, NULL},
        TEST("A bad address is refused with EFAULT", refuses_bad_addresses),
        {"The library itself sleeps in real time", leaves_the_library_alone, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
