/* SPDX-License-Identifier: MIT */
/* POSIX timers, interval timers and alarm() on the virtual clock. */
#define _GNU_SOURCE
#include <pthread.h>
#include <signal.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/threads.h"
#include "fakes.h"

OURS(timer_create);
OURS(timer_delete);
OURS(timer_gettime);
OURS(timer_settime);
OURS(timer_getoverrun);
OURS(getitimer);
OURS(setitimer);
OURS(alarm);

static uint64_t now_ns;
static ect_timer_t *added;       /* the newest timer */
static const ect_signal_t *sent; /* the newest signal */
static pid_t sent_to;
static void (*in_child)(void);
static void *(*thread_start)(void *arg); /* of the newest thread */
static void *thread_arg;
static const void *woken; /* by the newest expiry */

/* --- fakes -------------------------------------------------------------------------------------------------------- */

static int fake_timer_create(clockid_t clock, struct sigevent *restrict event, timer_t *restrict timer)
{
    return (int)CALLED(timer_create, clock, (long)event, (long)timer);
}

static int fake_timer_delete(timer_t timer)
{
    return (int)CALLED(timer_delete, (long)timer);
}

static int fake_timer_gettime(timer_t timer, struct itimerspec *value)
{
    return (int)CALLED(timer_gettime, (long)timer, (long)value);
}

static int fake_timer_settime(timer_t timer, int flags, const struct itimerspec *restrict value,
                              struct itimerspec *restrict before)
{
    return (int)CALLED(timer_settime, (long)timer, flags, (long)value, (long)before);
}

static int fake_timer_getoverrun(timer_t timer)
{
    return (int)CALLED(timer_getoverrun, (long)timer);
}

static int fake_getitimer(__itimer_which_t which, struct itimerval *value)
{
    return (int)CALLED(getitimer, which, (long)value);
}

static int fake_setitimer(__itimer_which_t which, const struct itimerval *restrict value,
                          struct itimerval *restrict before)
{
    return (int)CALLED(setitimer, which, (long)value, (long)before);
}

static unsigned int fake_alarm(unsigned int seconds)
{
    return (unsigned int)CALLED(alarm, seconds);
}

FAKES(FAKE(timer_create), FAKE(timer_delete), FAKE(timer_gettime), FAKE(timer_settime), FAKE(timer_getoverrun),
      FAKE(getitimer), FAKE(setitimer), FAKE(alarm))

int fake_pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict attributes,
                        void *(*start)(void *arg), void *restrict arg);
int fake_pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict attributes,
                        void *(*start)(void *arg), void *restrict arg)
{
    int detached = -1;
    assert_int_equal(pthread_attr_getdetachstate(attributes, &detached), 0);
    memset(thread, 0, sizeof *thread);
    thread_start = start;
    thread_arg = arg;
    return (int)CALLED(pthread_create, detached == PTHREAD_CREATE_DETACHED);
}

/* Called before main(). */
int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void));
int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void))
{
    in_child = !prepare && !parent ? child : NULL;
    return 0;
}

void *fake_calloc(size_t count, size_t size);
void *fake_calloc(size_t count, size_t size)
{
    return planned("calloc") != 0 ? NULL : calloc(count, size);
}

uint64_t ect_virtual_now(void)
{
    return now_ns;
}

void ect_virtual_add_timer(ect_timer_t *timer)
{
    added = timer;
    CALLED(add);
}

void ect_virtual_remove_timer(ect_timer_t *timer)
{
    CALLED(remove, timer == added);
}

void ect_virtual_expired(const void *key)
{
    woken = key;
    CALLED(expired);
}

bool ect_virtual_send(ect_signal_t *signal, pid_t to)
{
    sent = signal;
    sent_to = to;
    return CALLED(send, signal->info.si_signo, to) == 0;
}

void ect_virtual_recall(const ect_signal_t *signal)
{
    CALLED(recall, signal == sent);
}

unsigned int ect_virtual_wake(const void *key, unsigned int most)
{
    return (unsigned int)CALLED(wake, key == (const void *)added, most);
}

/* The thread of a timer waits: the planned result is the number of expiries meanwhile, below 0: the timer is deleted.
 */
ect_wait_t ect_virtual_wait(const void *key, uint64_t until_ns)
{
    assert_ptr_equal(key, added);
    assert_true(until_ns == UINT64_MAX);
    long expiries = CALLED(wait);
    for (long i = 0; i < expiries; i++)
        added->expired(added);
    if (expiries < 0)
        assert_int_equal(ours_timer_delete((timer_t)added), 0);
    return ECT_WAIT_WOKEN;
}

static int begin(void **state)
{
    now_ns = ECT_VIRTUAL_START_NS;
    added = NULL;
    sent = NULL;
    return begin_fakes(state);
}

/* A timer that does nothing at its end, with no call logged. */
static timer_t new_timer(clockid_t clock)
{
    struct sigevent event = {.sigev_notify = SIGEV_NONE};
    timer_t timer = NULL;
    assert_int_equal(ours_timer_create(clock, &event, &timer), 0);
    assert_ptr_equal(timer, added);
    forget_calls();
    return timer;
}

static void delete(timer_t timer)
{
    assert_int_equal(ours_timer_delete(timer), 0);
    forget_calls();
}

/* --- timers ------------------------------------------------------------------------------------------------------- */

static void sends_its_signal(void **state)
{
    static const struct {
        int kind, number;
        pid_t to;
    } rows[] = {{SIGEV_SIGNAL, SIGUSR1, 0}, {SIGEV_THREAD_ID, SIGUSR2, 55}};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        struct sigevent event = {
            .sigev_notify = rows[i].kind, .sigev_signo = rows[i].number, .sigev_value.sival_int = 8};
        event._sigev_un._tid = 55;
        timer_t timer;
        assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, &event, &timer), 0);
        assert_true(added->next_ns == UINT64_MAX);
        EXPECT_CALLS("create", "add() ");
        added->expired(added);
        assert_int_equal(sent->info.si_signo, rows[i].number);
        assert_int_equal(sent->info.si_code, SI_TIMER);
        assert_int_equal(sent->info.si_value.sival_int, 8);
        assert_int_equal(sent->info.si_overrun, 0);
        assert_int_equal(sent_to, rows[i].to);
        forget_calls();
        assert_int_equal(ours_timer_delete(timer), 0);
        EXPECT_CALLS("delete", "remove(1) recall(1) ");
    }
}

/* An event of NULL is SIGALRM with the timer as its value. */
static void sends_alarm_by_default(void **state)
{
    timer_t timer;
    (void)state;
    assert_int_equal(ours_timer_create(CLOCK_REALTIME, NULL, &timer), 0);
    added->expired(added);
    assert_int_equal(sent->info.si_signo, SIGALRM);
    assert_ptr_equal(sent->info.si_value.sival_ptr, timer);
    delete (timer);
}

static void counts_overruns(void **state)
{
    timer_t timer;
    (void)state;
    assert_int_equal(ours_timer_create(CLOCK_REALTIME, NULL, &timer), 0);
    assert_int_equal(ours_timer_getoverrun(timer), 0);
    added->expired(added);
    assert_int_equal(ours_timer_getoverrun(timer), 0);
    plan("send", 1, 0);
    plan("send", 1, 0);
    added->expired(added);
    added->expired(added);
    assert_int_equal(ours_timer_getoverrun(timer), 2);
    added->expired(added);
    assert_int_equal(ours_timer_getoverrun(timer), 0);
    delete (timer);
}

static unsigned int notified;

static void on_notify(union sigval value)
{
    assert_int_equal(value.sival_int, 9);
    notified++;
}

static void calls_a_function(void **state)
{
    struct sigevent event = {
        .sigev_notify = SIGEV_THREAD, .sigev_notify_function = on_notify, .sigev_value.sival_int = 9};
    timer_t timer;
    (void)state;
    notified = 0;
    assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, &event, &timer), 0);
    EXPECT_CALLS("create", "pthread_create(1) add() ");
    plan("wait", 2, 0);
    plan("wait", 1, 0);
    plan("wait", -1, 0);
    assert_null(thread_start(thread_arg)); /* frees the timer */
    assert_int_equal(notified, 3);
    assert_ptr_equal(woken, timer);
    EXPECT_CALLS("the thread", "wait() expired() expired() wait() expired() wait() remove(1) recall(0) wake(1,1) ");
    plan("timer_delete", -1, EINVAL);
    assert_int_equal(ours_timer_delete(timer), -1);
    forget_calls();
}

static void refuses_without_resources(void **state)
{
    struct sigevent event = {.sigev_notify = SIGEV_THREAD, .sigev_notify_function = on_notify};
    timer_t timer;
    (void)state;
    plan("pthread_create", EAGAIN, 0);
    errno = 0;
    assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, &event, &timer), -1);
    assert_int_equal(errno, EAGAIN);
    EXPECT_CALLS("no thread", "pthread_create(1) ");
    plan("calloc", 1, 0);
    errno = 0;
    assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, NULL, &timer), -1);
    assert_int_equal(errno, EAGAIN);
    EXPECT_CALLS("no memory", "");
}

static void leaves_timers_of_processors_real(void **state)
{
    static const clockid_t clocks[] = {CLOCK_PROCESS_CPUTIME_ID, CLOCK_THREAD_CPUTIME_ID, -6};
    char want[64];
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        plan("timer_create", -1, EINVAL);
        assert_int_equal(ours_timer_create(clocks[i], AT(8), AT(16)), -1);
        snprintf(want, sizeof want, "timer_create(%d,8,16) ", clocks[i]);
        EXPECT_CALLS("a processor", want);
    }
    timer_t timer = new_timer(CLOCK_MONOTONIC);
    ect_inside = 1;
    plan("timer_create", 3, 0);
    assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, AT(8), AT(16)), 3);
    EXPECT_CALLS("of the library", "timer_create(1,8,16) ");
    ect_inside = 0;
    delete (timer);
    plan("timer_delete", 3, 0);
    plan("timer_gettime", 4, 0);
    plan("timer_settime", 5, 0);
    plan("timer_getoverrun", 6, 0);
    assert_int_equal(ours_timer_delete((timer_t)40), 3);
    assert_int_equal(ours_timer_gettime((timer_t)40, AT(8)), 4);
    assert_int_equal(ours_timer_settime((timer_t)40, 1, AT(8), AT(16)), 5);
    assert_int_equal(ours_timer_getoverrun((timer_t)40), 6);
    EXPECT_CALLS("another's", "timer_delete(40) timer_gettime(40,8) timer_settime(40,1,8,16) timer_getoverrun(40) ");
}

static void runs_and_stops(void **state)
{
    const struct itimerspec value = {.it_value = {2, 3}, .it_interval = {4, 5}};
    const struct itimerspec stop = {.it_interval = {4, 5}};
    struct itimerspec left = {.it_value = {9, 9}};
    (void)state;
    timer_t timer = new_timer(CLOCK_MONOTONIC);
    timer_t other = new_timer(CLOCK_MONOTONIC);
    assert_int_equal(ours_timer_settime(timer, 0, &value, &left), 0);
    assert_int_equal(left.it_value.tv_sec, 0);
    assert_int_equal(left.it_value.tv_nsec, 0);
    now_ns += ECT_NS_PER_S;
    assert_int_equal(ours_timer_gettime(timer, &left), 0);
    assert_int_equal(left.it_value.tv_sec, 1);
    assert_int_equal(left.it_value.tv_nsec, 3);
    assert_int_equal(left.it_interval.tv_sec, 4);
    assert_int_equal(left.it_interval.tv_nsec, 5);
    now_ns += ECT_NS_PER_S + 3; /* due: yet a running timer has time left */
    assert_int_equal(ours_timer_gettime(timer, &left), 0);
    assert_int_equal(left.it_value.tv_sec, 0);
    assert_int_equal(left.it_value.tv_nsec, 1);
    assert_int_equal(ours_timer_settime(timer, 0, &stop, &left), 0);
    assert_int_equal(left.it_value.tv_nsec, 1);
    assert_int_equal(ours_timer_gettime(timer, &left), 0);
    assert_int_equal(left.it_value.tv_nsec, 0);
    assert_int_equal(ours_timer_gettime(other, &left), 0);
    assert_int_equal(left.it_interval.tv_sec, 0);
    delete (timer);
    assert_int_equal(ours_timer_gettime(other, &left), 0);
    delete (other);
}

static void runs_until_a_time(void **state)
{
    const struct itimerspec monotonic = {.it_value = {ECT_VIRTUAL_START_NS / ECT_NS_PER_S + 7, 1}};
    const struct itimerspec of_day = {.it_value = {(time_t)(ECT_VIRTUAL_DAY_NS / ECT_NS_PER_S) + 8, 2}};
    (void)state;
    timer_t timer = new_timer(CLOCK_MONOTONIC);
    assert_int_equal(ours_timer_settime(timer, TIMER_ABSTIME, &monotonic, NULL), 0);
    assert_true(added->next_ns == ECT_VIRTUAL_START_NS + 7 * ECT_NS_PER_S + 1);
    delete (timer);
    timer = new_timer(CLOCK_REALTIME);
    assert_int_equal(ours_timer_settime(timer, TIMER_ABSTIME, &of_day, NULL), 0);
    assert_true(added->next_ns == ECT_VIRTUAL_START_NS + 8 * ECT_NS_PER_S + 2);
    added->expired(added);
    EXPECT_CALLS("SIGEV_NONE", "");
    delete (timer);
}

static void refuses_what_is_no_time(void **state)
{
    static const struct itimerspec rows[] = {{.it_value = {0, 1000000000}}, {.it_interval = {0, 1000000000}}};
    (void)state;
    timer_t timer = new_timer(CLOCK_MONOTONIC);
    for (size_t i = 0; i < 2; i++) {
        errno = 0;
        assert_int_equal(ours_timer_settime(timer, 0, &rows[i], NULL), -1);
        assert_int_equal(errno, EINVAL);
        assert_true(added->next_ns == UINT64_MAX);
    }
    delete (timer);
}

/* A bad new time changes nothing; the previous one is stored after the change, as in a kernel. */
static void refuses_bad_addresses(void **state)
{
    const struct itimerspec value = {.it_value = {2, 3}};
    timer_t name = NULL;
    (void)state;
    assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, AT(5), &name), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ours_timer_create(CLOCK_MONOTONIC, NULL, AT(5)), -1);
    assert_int_equal(errno, EFAULT);
    assert_null(name);
    EXPECT_CALLS("no timer", "");
    timer_t timer = new_timer(CLOCK_MONOTONIC);
    errno = 0;
    assert_int_equal(ours_timer_settime(timer, 0, AT(5), NULL), -1);
    assert_int_equal(errno, EFAULT);
    assert_true(added->next_ns == UINT64_MAX);
    errno = 0;
    assert_int_equal(ours_timer_settime(timer, 0, &value, AT(5)), -1);
    assert_int_equal(errno, EFAULT);
    assert_true(added->next_ns == ECT_VIRTUAL_START_NS + 2 * ECT_NS_PER_S + 3);
    errno = 0;
    assert_int_equal(ours_timer_gettime(timer, AT(5)), -1);
    assert_int_equal(errno, EFAULT);
    delete (timer);
    const struct itimerval alarm = {.it_value = {2, 3}}, none = {0};
    errno = 0;
    assert_int_equal(ours_setitimer(ITIMER_REAL, AT(5), NULL), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("no alarm", "");
    errno = 0;
    assert_int_equal(ours_setitimer(ITIMER_REAL, &alarm, AT(5)), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("an alarm", "remove(0) add() ");
    errno = 0;
    assert_int_equal(ours_getitimer(ITIMER_REAL, AT(5)), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ours_setitimer(ITIMER_REAL, &none, NULL), 0);
    forget_calls();
}

/* --- interval timers ---------------------------------------------------------------------------------------------- */

static void refuses_intervals(void **state)
{
    static const struct itimerval rows[] = {{.it_value = {-1, 0}},    {.it_value = {0, 1000000}},
                                            {.it_value = {1, -1}},    {{0, 1000000}, {1, 0}},
                                            {.it_interval = {-1, 0}}, {.it_interval = {0, -1}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        errno = 0;
        assert_int_equal(ours_setitimer(ITIMER_REAL, &rows[i], NULL), -1);
        assert_int_equal(errno, EINVAL);
        EXPECT_CALLS("no alarm", "");
    }
    static const struct itimerval longest = {{INT64_MAX, 999999}, {INT64_MAX, 999999}};
    struct itimerval left;
    assert_int_equal(ours_setitimer(ITIMER_REAL, &longest, NULL), 0);
    assert_int_equal(ours_getitimer(ITIMER_REAL, &left), 0);
    assert_true(left.it_value.tv_sec > 1000000000 && left.it_interval.tv_sec > 1000000000);
    forget_calls();
}

static void alarms(void **state)
{
    (void)state;
    assert_int_equal(ours_alarm(3), 0);
    EXPECT_CALLS("alarm", "remove(0) add() ");
    ect_timer_t *its = added;
    assert_true(its->next_ns == ECT_VIRTUAL_START_NS + 3 * ECT_NS_PER_S);
    assert_true(its->interval_ns == 0);
    its->expired(its);
    assert_int_equal(sent->info.si_signo, SIGALRM);
    assert_int_equal(sent->info.si_code, SI_KERNEL);
    EXPECT_CALLS("expiry", "send(14,0) ");
    assert_int_equal(ours_alarm(3), 3);
    now_ns += 1; /* a part of a second is a second */
    assert_int_equal(ours_alarm(2), 3);
    now_ns += ECT_NS_PER_S;
    assert_int_equal(ours_alarm(0), 1);
    assert_true(its->next_ns == UINT64_MAX);
    assert_int_equal(ours_alarm(0), 0);
    forget_calls();
}

static void repeats_alarms(void **state)
{
    const struct itimerval value = {.it_value = {1, 2}, .it_interval = {3, 4}};
    struct itimerval before = {.it_value = {9, 9}};
    (void)state;
    assert_int_equal(ours_setitimer(ITIMER_REAL, &value, &before), 0);
    assert_int_equal(before.it_value.tv_sec, 0);
    assert_int_equal(before.it_value.tv_usec, 0);
    assert_true(added->next_ns == ECT_VIRTUAL_START_NS + ECT_NS_PER_S + 2000);
    assert_true(added->interval_ns == 3 * ECT_NS_PER_S + 4000);
    now_ns += 1001;
    assert_int_equal(ours_getitimer(ITIMER_REAL, &before), 0);
    assert_int_equal(before.it_value.tv_sec, 1); /* 0.999 us are a microsecond */
    assert_int_equal(before.it_value.tv_usec, 1);
    assert_int_equal(before.it_interval.tv_sec, 3);
    assert_int_equal(before.it_interval.tv_usec, 4);
    now_ns += ECT_NS_PER_S + 999 - 1; /* 1 ns is left */
    assert_int_equal(ours_setitimer(ITIMER_REAL, NULL, &before), 0);
    assert_int_equal(before.it_value.tv_sec, 0);
    assert_int_equal(before.it_value.tv_usec, 1);
    assert_true(added->next_ns == UINT64_MAX);
    assert_true(added->interval_ns == 0);
    assert_int_equal(ours_setitimer(ITIMER_REAL, NULL, NULL), 0);
    forget_calls();
}

static void leaves_other_interval_timers_real(void **state)
{
    (void)state;
    for (ect_inside = 0; ect_inside < 2; ect_inside++) {
        const int which = ect_inside > 0 ? ITIMER_REAL : ITIMER_VIRTUAL;
        char want[64];
        plan("getitimer", 3, 0);
        plan("setitimer", 4, 0);
        assert_int_equal(ours_getitimer((__itimer_which_t)which, AT(8)), 3);
        assert_int_equal(ours_setitimer((__itimer_which_t)which, AT(8), AT(16)), 4);
        snprintf(want, sizeof want, "getitimer(%d,8) setitimer(%d,8,16) ", which, which);
        EXPECT_CALLS("real", want);
    }
    ect_inside = 1;
    plan("alarm", 5, 0);
    assert_int_equal(ours_alarm(6), 5);
    EXPECT_CALLS("alarm", "alarm(6) ");
}

static void has_no_timers_in_a_child(void **state)
{
    (void)state;
    ect_inside = 0;
    timer_t timer = new_timer(CLOCK_MONOTONIC);
    (void)ours_alarm(3);
    ect_timer_t *its = added;
    its->expired(its);
    ((ect_signal_t *)(uintptr_t)sent)->waits = true;
    assert_non_null(in_child);
    in_child();
    assert_false(sent->waits);
    assert_true(its->next_ns == UINT64_MAX);
    plan("timer_delete", -1, EINVAL);
    assert_int_equal(ours_timer_delete(timer), -1);
    free(timer);
    forget_calls();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A timer sends its signal to the process or to a thread", sends_its_signal, begin, NULL, NULL},
        {"Without an event the signal is SIGALRM", sends_alarm_by_default, begin, NULL, NULL},
        {"Expiries while the signal is pending are overruns", counts_overruns, begin, NULL, NULL},
        {"A thread calls the function of a timer once for each expiry", calls_a_function, begin, NULL, NULL},
        {"A bad address is refused with EFAULT", refuses_bad_addresses, begin, NULL, NULL},
        {"Without memory or a thread there is no timer", refuses_without_resources, begin, NULL, NULL},
        {"Timers of processors, and unknown ones, are real", leaves_timers_of_processors_real, begin, NULL, NULL},
        {"A timer runs for a span, and stops", runs_and_stops, begin, NULL, NULL},
        {"A timer runs until a time of its clock", runs_until_a_time, begin, NULL, NULL},
        {"A time with too many nanoseconds is refused", refuses_what_is_no_time, begin, NULL, NULL},
        {"alarm() returns the rest in whole seconds", alarms, begin, NULL, NULL},
        {"setitimer() and getitimer() round up to microseconds", repeats_alarms, begin, NULL, NULL},
        {"Interval timers of processors are real", leaves_other_interval_timers_real, begin, NULL, NULL},
        {"The child of a fork has no timers", has_no_timers_in_a_child, begin, NULL, NULL},
        {"setitimer(2): invalid times are refused; the longest is accepted", refuses_intervals, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
