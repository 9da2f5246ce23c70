/* SPDX-License-Identifier: MIT */
/* Turns and time of threads on the virtual clock. Threads are those of the C library, of which one runs at a time; the
 * real clock, its pauses, signals and the bus are the test's. */
#define _GNU_SOURCE
#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/bus.h"
#include "bus/inprocess/tasks.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "fakes.h"

#define NEVER UINT64_MAX
#define MS    1000000ull

enum { PID = 55, UNKNOWN = 999 };

static uint64_t since_ns; /* virtual time at the begin of a test */
static uint64_t real_ns;
static unsigned int naps, most_naps; /* `on_nap` is called with the last */
static uint64_t suspended_ns;        /* beside a nap, once */
static void (*on_nap)(void);
static int nap_result;
static bool runs_bus, has_child;
static int pending, blocked, ignored; /* signals; 0: none */
static bool others_block, restarts, sleeps;
static char reported[512];
static unsigned int reports;
static void (*in_child)(void);
static void *(*watcher)(void *arg);
static __thread pid_t thread_id;

/* --- handlers of the program
 * ------------------------------------------------------------------------------------------ */

static __thread ect_handled_t handlers;
static __thread int holds;
static bool handles_at_release; /* a deferred handler runs at the end of the next lock */

static void run_handler(void)
{
    handlers.count++;
    handlers.restarts &= restarts;
}

void ect_action_hold(void)
{
    assert_int_equal(holds++, 0);
}

void ect_action_release(void)
{
    assert_int_equal(--holds, 0);
    if (handles_at_release)
        run_handler();
    handles_at_release = false;
}

void ect_action_watch(void)
{
    handlers = (ect_handled_t){.restarts = true};
}

ect_handled_t ect_action_handled(void)
{
    return handlers;
}

/* --- fakes
 * ------------------------------------------------------------------------------------------------------------ */

static int fake_pthread_mutex_lock(pthread_mutex_t *mutex)
{
    return pthread_mutex_lock(mutex);
}

static int fake_pthread_mutex_unlock(pthread_mutex_t *mutex)
{
    return pthread_mutex_unlock(mutex);
}

static int fake_pthread_once(pthread_once_t *once, void (*run)(void))
{
    return pthread_once(once, run);
}

static uint64_t passed_ns;

static void *pass_at_start(void *unused)
{
    (void)unused;
    passed_ns = ect_virtual_pass(70);
    return NULL;
}

/* Creates the thread that watches the turn. Its creator waits until it has read the clock, as under LeakSanitizer. */
static int fake_pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict attributes,
                               void *(*start)(void *arg), void *restrict arg)
{
    pthread_t reads;
    int detached = -1;
    (void)thread;
    watcher = start;
    (void)pthread_attr_getdetachstate(attributes, &detached);
    (void)pthread_create(&reads, NULL, pass_at_start, NULL);
    (void)pthread_join(reads, NULL);
    return (int)CALLED(watch, detached == PTHREAD_CREATE_DETACHED, arg != NULL);
}

static long fake_syscall(long number, ...)
{
    long a[6];
    va_list arguments;
    va_start(arguments, number);
    for (size_t i = 0; i < 6; i++)
        a[i] = va_arg(arguments, long);
    va_end(arguments);
    if (number == SYS_futex)
        return syscall(number, a[0], a[1], a[2], a[3], a[4], a[5]);
    if (number != SYS_rt_tgsigqueueinfo)
        return CALLED(queue, a[0], a[1], number == SYS_rt_sigqueueinfo);
    if (a[1] == thread_id)
        run_handler();
    return CALLED(send_to, a[1], a[2], a[0] == PID);
}

static int fake_clock_gettime(clockid_t clock, struct timespec *time)
{
    *time = (struct timespec){.tv_sec = (time_t)(real_ns / 1000000000), .tv_nsec = (long)(real_ns % 1000000000)};
    return clock == CLOCK_MONOTONIC ? 0 : -1;
}

static int fake_nanosleep(const struct timespec *time, struct timespec *left)
{
    (void)left;
    real_ns += (uint64_t)time->tv_nsec + suspended_ns;
    suspended_ns = 0;
    CALLED(nap, time->tv_nsec / 1000000 + time->tv_sec * 1000);
    if (++naps == most_naps && on_nap)
        on_nap();
    if (nap_result != 0)
        run_handler();
    return nap_result;
}

static int fake_waitid(idtype_t kind, id_t id, siginfo_t *info, int options)
{
    (void)id;
    bool looks = kind == P_ALL && options == (WEXITED | WNOHANG | WNOWAIT);
    info->si_pid = looks ? 0 : 1;
    return has_child ? 0 : -1;
}

FAKES(FAKE(pthread_mutex_lock), FAKE(pthread_mutex_unlock), FAKE(pthread_once), FAKE(pthread_create), FAKE(syscall),
      FAKE(clock_gettime), FAKE(nanosleep), FAKE(waitid))

static void (*at_thread_end)(void *record);

int fake_pthread_key_create(pthread_key_t *key, void (*end)(void *record))
{
    *key = 0;
    at_thread_end = end;
    return 0;
}

int fake_pthread_setspecific(pthread_key_t key, const void *value)
{
    (void)key;
    return value ? 0 : -1;
}

int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void))
{
    in_child = !prepare && !parent ? child : NULL;
    return 0;
}

/* The mask of the calling thread, which watch() sets and restores. */
int fake_pthread_sigmask(int how, const sigset_t *set, sigset_t *before)
{
    if (set)
        CALLED(sigmask, how, sigismember(set, SIGTERM));
    if (before) {
        sigemptyset(before);
        if (blocked != 0)
            sigaddset(before, blocked);
    }
    return 0;
}

int fake_sigpending(sigset_t *set)
{
    sigemptyset(set);
    if (pending != 0)
        sigaddset(set, pending);
    return 0;
}

int fake_sigaction(int number, const struct sigaction *action, struct sigaction *before)
{
    *before = (struct sigaction){.sa_handler = number == ignored ? SIG_IGN : SIG_DFL};
    return action ? -1 : 0;
}

pid_t fake_getpid(void)
{
    return PID;
}

pid_t fake_gettid(void)
{
    return thread_id;
}

int fake_dprintf(int fd, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    reports += fd == STDERR_FILENO;
    int length = vsnprintf(reported, sizeof reported, format, arguments);
    va_end(arguments);
    return length;
}

bool ect_task_sleeps(pid_t id)
{
    return sleeps && id == PID;
}

const char *ect_task_call(pid_t id, char *name)
{
    snprintf(name, ECT_TASK_CALL, "call of %d", (int)id);
    return name;
}

bool ect_task_blocks(pid_t id, int number)
{
    return others_block || (id == PID && number == blocked);
}

bool ect_bus_running(void)
{
    return runs_bus;
}

/* The planned result is the span to the next run; 0: none. */
uint64_t ect_bus_run(uint64_t now_ns)
{
    long next_ns = CALLED(run, (long)(now_ns - since_ns));
    return next_ns != 0 ? since_ns + (uint64_t)next_ns : NEVER;
}

bool ect_bus_serve(uint64_t now_ns)
{
    return CALLED(serve, (long)(now_ns - since_ns)) != 0;
}

void ect_bus_end(void)
{
}

/* --- helpers
 * ---------------------------------------------------------------------------------------------------------- */

static int begin(void **state)
{
    thread_id = PID;
    runs_bus = false;
    (void)begin_fakes(state);
    ect_time_bus_next(NEVER);
    since_ns = ect_virtual_now();
    naps = most_naps = 0;
    suspended_ns = 0;
    on_nap = NULL;
    nap_result = 0;
    has_child = false;
    pending = blocked = ignored = 0;
    others_block = restarts = sleeps = handles_at_release = false;
    reports = 0;
    return begin_fakes(state);
}

static uint64_t passed(void)
{
    return ect_virtual_now() - since_ns;
}

static bool flag;

static void set_flag(void)
{
    flag = true;
}

static bool is_set(void *arg)
{
    return *(bool *)arg;
}

/* Runs in a child, because a process makes a report only once. @return whether it succeeds */
static bool in_fork(bool (*scenario)(void))
{
    int status = -1;
    pid_t child = fork();
    if (child == 0)
        _exit(scenario() ? 0 : 1);
    assert_int_equal(waitpid(child, &status, 0), child);
    return status == 0;
}

/* A thread of the master. */
typedef struct worker {
    void (*run)(struct worker *its);
    pid_t id;
    bool waits; /* for its turn at the start */
    int ended;
    void *record;
    pthread_t thread;
    ect_wait_t end_of_wait, second_wait;
} worker_t;

static void *run_worker(void *arg)
{
    worker_t *its = arg;
    thread_id = its->id;
    ect_virtual_thread_begin(its->record, its->waits);
    its->run(its);
    at_thread_end(its->record);
    return NULL;
}

static void start(worker_t *its)
{
    its->record = ect_virtual_thread_new(&its->ended);
    assert_non_null(its->record);
    assert_int_equal(pthread_create(&its->thread, NULL, run_worker, its), 0);
}

static void join(worker_t *its)
{
    while (!its->ended)
        assert_int_equal(ect_virtual_wait(&its->ended, NEVER), ECT_WAIT_WOKEN);
    assert_int_equal(pthread_join(its->thread, NULL), 0);
}

/* --- one thread
 * ------------------------------------------------------------------------------------------------------- */

static void passes_time(void **state)
{
    (void)state;
    assert_true(since_ns >= ECT_VIRTUAL_START_NS);
    assert_true(ect_time_is_virtual);
    ect_virtual_charge(50);
    assert_int_equal(passed(), 50);
    assert_true(ect_virtual_pass(30) == since_ns + 80);
    ect_virtual_yield();
    assert_int_equal(passed(), 130);
    ect_time_charge(20);
    assert_int_equal(passed(), 150);
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 1000), ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 1000);
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 10), ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 1000);
    ect_time_lock();
    assert_int_equal(ect_inside, 1);
    assert_true(ect_time_now() == since_ns + 1000);
    ect_time_unlock();
    assert_int_equal(ect_inside, 0);
    EXPECT_CALLS("no real time", "");
}

static void runs_the_bus(void **state)
{
    (void)state;
    runs_bus = true;
    ect_time_bus_next(since_ns + 100);
    plan("run", 300, 0);
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 1000), ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 1000);
    EXPECT_CALLS("when it is due", "run(100) run(300) ");
    ect_time_bus_next(since_ns + 1100);
    ect_virtual_charge(99);
    EXPECT_CALLS("not yet", "");
    plan("run", 1100, 0);
    plan("run", 1100, 0);
    ect_virtual_charge(1);
    assert_int_equal(passed(), 1100);
    EXPECT_CALLS("due again at once", "run(1100) run(1100) ");
    ect_virtual_charge(999);
    EXPECT_CALLS("a pause", "");
    ect_virtual_charge(1);
    EXPECT_CALLS("the next", "run(2100) ");
    runs_bus = false;
    ect_time_bus_next(since_ns + 2200);
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 2300), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("no bus", "");
}

static void on_timer(ect_timer_t *timer)
{
    CALLED(expired, (long)(ect_time_now() - since_ns), timer->interval_ns != 0);
}

static char key;

static void on_key(ect_timer_t *timer)
{
    (void)timer;
    ect_virtual_expired(&key);
}

static void runs_timers(void **state)
{
    ect_timer_t repeated = {.next_ns = since_ns + 100, .interval_ns = 100, .expired = on_timer};
    ect_timer_t once = {.next_ns = since_ns + 150, .expired = on_timer};
    ect_timer_t stopped = {.next_ns = NEVER, .expired = on_timer};
    (void)state;
    ect_virtual_add_timer(&repeated);
    ect_virtual_add_timer(&once);
    ect_virtual_add_timer(&stopped);
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 250), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("in time", "expired(100,1) expired(150,0) expired(200,1) ");
    assert_int_equal(passed(), 250);
    assert_true(once.next_ns == NEVER);
    ect_virtual_remove_timer(&once);
    ect_virtual_charge(50);
    EXPECT_CALLS("in a call", "expired(300,1) ");
    ect_virtual_remove_timer(&repeated);
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 1000), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("removed", "");
    ect_virtual_remove_timer(&stopped);
    ect_timer_t wakes = {.next_ns = since_ns + 1100, .expired = on_key};
    ect_virtual_add_timer(&wakes);
    assert_int_equal(ect_virtual_wait(&key, NEVER), ECT_WAIT_WOKEN);
    assert_int_equal(passed(), 1100);
    ect_virtual_remove_timer(&wakes);
    EXPECT_CALLS("none waits for the world", "");
}

static void waits_for_conditions(void **state)
{
    ect_timer_t ticks = {.next_ns = since_ns + 100, .interval_ns = 100, .expired = on_timer};
    bool condition = false;
    (void)state;
    assert_int_equal(ect_virtual_wait_until(is_set, &condition, NULL, since_ns + 50), ECT_WAIT_TIMED_OUT);
    condition = true;
    assert_int_equal(ect_virtual_wait_until(is_set, &condition, NULL, since_ns + 50), ECT_WAIT_WOKEN);
    assert_int_equal(ect_virtual_wait_until(is_set, &condition, NULL, NEVER), ECT_WAIT_WOKEN);
    assert_int_equal(passed(), 50);
    ect_virtual_add_timer(&ticks);
    condition = false;
    assert_int_equal(ect_virtual_wait_until(is_set, &condition, NULL, since_ns + 250), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("ticks", "expired(100,1) expired(200,1) ");
    ect_virtual_remove_timer(&ticks);
}

static bool is_ready(const void *arg)
{
    return *(const bool *)arg;
}

static void waits_with_the_lock(void **state)
{
    bool condition = true;
    (void)state;
    ect_time_lock();
    assert_true(ect_time_wait(3, is_ready, &condition, NEVER));
    condition = false;
    assert_false(ect_time_wait(3, is_ready, &condition, since_ns + 70));
    assert_int_equal(errno, EAGAIN);
    assert_int_equal(ect_inside, 1);
    ect_time_unlock();
    assert_int_equal(passed(), 70);
}

/* --- real time
 * -------------------------------------------------------------------------------------------------------- */

/* Without a deadline only another process can end a wait: time passes as in the real world. */
static void waits_for_the_world(void **state)
{
    (void)state;
    flag = false;
    most_naps = 3;
    on_nap = set_flag;
    assert_int_equal(ect_virtual_wait_until(is_set, &flag, "read()", NEVER), ECT_WAIT_WOKEN);
    assert_int_equal(passed(), 30 * MS);
    EXPECT_CALLS("naps", "nap(10) nap(10) nap(10) ");
}

static bool reports_a_wait_for_the_world(void)
{
    flag = false;
    runs_bus = true;
    most_naps = 99;
    on_nap = set_flag;
    bool good = ect_virtual_wait_until(is_set, &flag, "read()", NEVER) == ECT_WAIT_WOKEN && reports == 0;
    flag = false;
    naps = 0;
    most_naps = 300; /* three seconds: one line */
    good &= ect_virtual_wait_until(is_set, &flag, "read()", NEVER) == ECT_WAIT_WOKEN && reports == 1;
    return good && strstr(reported, "--virtual-time: read() has waited for a second") != NULL;
}

static bool reports_nothing_without_a_bus(void)
{
    flag = false;
    most_naps = 300;
    on_nap = set_flag;
    return ect_virtual_wait_until(is_set, &flag, "read()", NEVER) == ECT_WAIT_WOKEN && reports == 0;
}

/* Time is stopped for a second of real time at most. */
static bool stops_time_for_a_second(void)
{
    flag = false;
    runs_bus = true;
    ect_wait_t end = ect_virtual_wait_for_process(is_set, &flag, "waitpid()", since_ns + 5 * MS);
    return end == ECT_WAIT_TIMED_OUT && naps == 1000 && reports == 1 && passed() == 5 * MS &&
           strstr(reported, "waitpid() has waited") != NULL;
}

/* A process that was stopped itself has not waited. */
static bool counts_no_suspension(void)
{
    enum { MOST_MS = 20 };
    flag = false;
    runs_bus = true;
    suspended_ns = 5000 * MS;
    ect_wait_t end = ect_virtual_wait_for_process(is_set, &flag, "waitpid()", since_ns + 5 * MS);
    return end == ECT_WAIT_TIMED_OUT && naps == 1000 - MOST_MS + 1;
}

static bool begins_again_after_a_success(void)
{
    runs_bus = true;
    for (unsigned int i = 0; i < 3; i++) {
        flag = false;
        naps = 0;
        most_naps = 600;
        on_nap = set_flag;
        if (ect_virtual_wait_for_process(is_set, &flag, "waitpid()", NEVER) != ECT_WAIT_WOKEN)
            return false;
    }
    return reports == 0 && passed() == 0;
}

static void reports_long_waits(void **state)
{
    (void)state;
    assert_true(in_fork(reports_a_wait_for_the_world));
    assert_true(in_fork(reports_nothing_without_a_bus));
    assert_true(in_fork(stops_time_for_a_second));
    assert_true(in_fork(counts_no_suspension));
    assert_true(in_fork(begins_again_after_a_success));
}

static void stops_time_for_a_process(void **state)
{
    (void)state;
    flag = false;
    runs_bus = true;
    most_naps = 2;
    on_nap = set_flag;
    assert_int_equal(ect_virtual_wait_for_process(is_set, &flag, "waitpid()", since_ns + 5 * MS), ECT_WAIT_WOKEN);
    assert_int_equal(passed(), 0);
    assert_string_equal(strstr(fakes.log, "nap"), "nap(1) serve(0) nap(1) ");
    forget_calls();
    runs_bus = false; /* no bus: time goes on */
    flag = false;
    assert_int_equal(ect_virtual_wait_for_process(is_set, &flag, "waitpid()", since_ns + 5 * MS), ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 5 * MS);
    EXPECT_CALLS("no bus", "");
}

static void gives_children_time(void **state)
{
    (void)state;
    has_child = true;
    assert_true(ect_virtual_has_child());
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 25 * MS), ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 30 * MS);
    EXPECT_CALLS("naps", "nap(10) nap(10) nap(10) ");
    runs_bus = true;
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 35 * MS), ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 35 * MS);
    assert_null(strstr(fakes.log, "nap"));
    forget_calls();
    has_child = false;
    assert_false(ect_virtual_has_child());
}

static void ends_with_a_handler_of_a_real_signal(void **state)
{
    (void)state;
    flag = false;
    nap_result = -1;
    assert_int_equal(ect_virtual_wait_until(is_set, &flag, "read()", NEVER), ECT_WAIT_INTERRUPTED);
    assert_false(ect_virtual_restarts());
    restarts = true;
    assert_int_equal(ect_virtual_wait_until(is_set, &flag, "read()", NEVER), ECT_WAIT_INTERRUPTED);
    assert_true(ect_virtual_restarts());
    nap_result = 0;
    forget_calls();
}

static void defer_next(void)
{
    handles_at_release = true;
}

/* It arrives while its thread has the lock, and runs before the thread sleeps. */
static void ends_with_a_deferred_handler(void **state)
{
    (void)state;
    flag = false;
    restarts = true;
    most_naps = naps + 1;
    on_nap = defer_next;
    assert_int_equal(ect_virtual_wait_until(is_set, &flag, "read()", NEVER), ECT_WAIT_INTERRUPTED);
    assert_true(ect_virtual_restarts());
    EXPECT_CALLS("one nap", "nap(10) ");
}

static unsigned int served(void)
{
    unsigned int count = 0;
    for (const char *at = fakes.log; (at = strstr(at, "serve")); at++)
        count++;
    forget_calls();
    return count;
}

static void serves_clients(void **state)
{
    (void)state;
    runs_bus = true;
    flag = false;
    plan("serve", 1, 0);
    plan("run", 2 * MS, 0);
    assert_int_equal(ect_virtual_wait_until(is_set, &flag, "read()", since_ns + 1 * MS), ECT_WAIT_TIMED_OUT);
    assert_memory_equal(fakes.log, "serve(0) run(0) serve(0) ", 25);
    forget_calls();
    ect_time_bus_next(NEVER);
    for (unsigned int i = 0; i < 64 && served() == 0; i++)
        ect_virtual_charge(0);
    for (unsigned int i = 1; i < 64; i++)
        ect_virtual_charge(0);
    assert_int_equal(served(), 0);
    ect_virtual_charge(0);
    assert_int_equal(served(), 1);
}

/* --- several threads
 * -------------------------------------------------------------------------------------------------- */

static void steps(worker_t *its)
{
    for (unsigned int i = 0; i < 2; i++) {
        CALLED(step, its->id, (long)passed());
        its->end_of_wait = ect_virtual_wait(NULL, since_ns + (uint64_t)its->id * 100);
    }
}

/* Thread 2 waits for its turn at its first call. */
static void takes_turns(void **state)
{
    worker_t workers[] = {{.run = steps, .id = 1, .waits = true},
                          {.run = steps, .id = 2, .waits = false},
                          {.run = steps, .id = 3, .waits = true}};
    (void)state;
    workers[1].waits = true;
    for (size_t i = 0; i < 3; i++)
        start(&workers[i]);
    forget_calls();
    assert_int_equal(ect_virtual_wait(NULL, since_ns + 150), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("the first turns", "step(1,0) step(2,0) step(3,0) step(1,100) ");
    for (size_t i = 0; i < 3; i++)
        join(&workers[i]);
    EXPECT_CALLS("the next ones", "step(2,200) step(3,300) ");
    assert_int_equal(workers[0].end_of_wait, ECT_WAIT_TIMED_OUT);
    assert_int_equal(passed(), 300);
}

static void waits_for_key(worker_t *its)
{
    its->end_of_wait = ect_virtual_wait(&key, NEVER);
    CALLED(woken, its->id);
}

static void wakes_in_order(void **state)
{
    worker_t workers[] = {{.run = waits_for_key, .id = 1, .waits = true},
                          {.run = waits_for_key, .id = 2, .waits = true},
                          {.run = waits_for_key, .id = 3, .waits = true}};
    (void)state;
    for (size_t i = 0; i < 3; i++)
        start(&workers[i]);
    (void)ect_virtual_wait(NULL, since_ns + 10);
    forget_calls();
    assert_int_equal(ect_virtual_wake(&flag, 3), 0);
    assert_int_equal(ect_virtual_wake(&key, 0), 0);
    assert_int_equal(ect_virtual_wake(&key, 2), 2);
    EXPECT_CALLS("not yet", "");
    ect_virtual_yield();
    EXPECT_CALLS("two", "woken(1) woken(2) ");
    assert_int_equal(ect_virtual_wake(&key, 5), 1);
    ect_virtual_charge(0);
    EXPECT_CALLS("the third", "woken(3) ");
    assert_int_equal(ect_virtual_wake(&key, 5), 0);
    for (size_t i = 0; i < 3; i++) {
        join(&workers[i]);
        assert_int_equal(workers[i].end_of_wait, ECT_WAIT_WOKEN);
    }
}

static void waits_for_flag(worker_t *its)
{
    its->end_of_wait = ect_virtual_wait_until(is_set, &flag, NULL, NEVER);
    CALLED(woken, its->id);
}

/* A thread that only calls does not keep others from a condition that is true. */
static void looks_at_conditions_now_and_then(void **state)
{
    worker_t worker = {.run = waits_for_flag, .id = 1, .waits = true};
    (void)state;
    flag = false;
    start(&worker);
    (void)ect_virtual_wait(NULL, since_ns + 10);
    forget_calls();
    for (unsigned int i = 0; i < 32; i++)
        ect_virtual_charge(0);
    EXPECT_CALLS("not yet", "");
    flag = true;
    unsigned int calls = 0;
    while (fakes.used == 0 && calls++ < 100)
        ect_virtual_charge(0);
    assert_in_range(calls, 1, 16);
    EXPECT_CALLS("the condition", "woken(1) ");
    join(&worker);
    assert_int_equal(worker.end_of_wait, ECT_WAIT_WOKEN);
}

static void ends_unseen(worker_t *its)
{
    (void)its;
}

/* A thread that makes no call ends in its turn, too. */
static void ends_in_its_turn(void **state)
{
    worker_t worker = {.run = ends_unseen, .id = 1, .waits = false};
    (void)state;
    start(&worker);
    join(&worker);
    assert_int_equal(worker.ended, 1);
    assert_int_equal(passed(), 0);
    forget_calls();
}

static void has_1024_threads(void **state)
{
    enum { MOST = 1024 };
    static void *records[MOST];
    size_t count = 0;
    (void)state;
    while (count < MOST && (records[count] = ect_virtual_thread_new(NULL)))
        count++;
    assert_int_equal(count, MOST - 1); /* beside this one */
    for (size_t i = 0; i < count; i++)
        ect_virtual_thread_cancel(records[i]);
    void *again = ect_virtual_thread_new(NULL);
    assert_non_null(again);
    ect_virtual_thread_cancel(again);
    forget_calls();
}

/* --- signals of timers
 * ------------------------------------------------------------------------------------------------ */

static ect_signal_t signal_of_timer;
static pid_t signal_to;
static unsigned int sends;

static void send_signal(ect_timer_t *timer)
{
    (void)timer;
    for (unsigned int i = 0; i < sends; i++)
        CALLED(sent, ect_virtual_send(&signal_of_timer, signal_to));
}

/* @return the end of a wait of 200 ns, with a signal after 100 */
static ect_wait_t wait_with_signal(pid_t to, unsigned int times)
{
    ect_timer_t timer = {.next_ns = ect_virtual_now() + 100, .expired = send_signal};
    signal_of_timer = (ect_signal_t){.info = {.si_signo = SIGUSR1, .si_code = SI_TIMER}};
    signal_to = to;
    sends = times;
    ect_virtual_add_timer(&timer);
    ect_wait_t end = ect_virtual_wait(NULL, ect_virtual_now() + 200);
    ect_virtual_remove_timer(&timer);
    return end;
}

static void interrupts_a_wait(void **state)
{
    (void)state;
    assert_int_equal(wait_with_signal(0, 1), ECT_WAIT_INTERRUPTED);
    assert_int_equal(passed(), 100);
    assert_false(ect_virtual_restarts());
    EXPECT_CALLS("to the process", "sent(1) send_to(55,10,1) ");
    restarts = true;
    assert_int_equal(wait_with_signal(PID, 2), ECT_WAIT_INTERRUPTED);
    assert_true(ect_virtual_restarts());
    EXPECT_CALLS("the second is an overrun", "sent(1) sent(0) send_to(55,10,1) ");
    assert_false(signal_of_timer.waits);
}

static void leaves_signals_to_the_kernel(void **state)
{
    (void)state;
    blocked = SIGUSR1;
    assert_int_equal(wait_with_signal(0, 1), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("blocked", "queue(55,10,1) sent(1) ");
    assert_int_equal(wait_with_signal(PID, 1), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("blocked by its thread", "send_to(55,10,1) sent(1) ");
    blocked = 0;
    assert_int_equal(wait_with_signal(UNKNOWN, 1), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("an unknown thread", "send_to(999,10,1) sent(1) ");
    ignored = SIGUSR1;
    assert_int_equal(wait_with_signal(0, 1), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("ignored", "sent(1) ");
    pending = SIGUSR1;
    assert_int_equal(wait_with_signal(0, 1), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("pending", "sent(0) ");
}

static void waits_for_an_hour(worker_t *its)
{
    its->end_of_wait = ect_virtual_wait(NULL, since_ns + 1000);
}

/* Another thread gets a signal that the main thread blocks; a recalled signal ends its wait alone. */
static void reaches_another_thread(void **state)
{
    worker_t worker = {.run = waits_for_an_hour, .id = 7, .waits = true};
    (void)state;
    start(&worker);
    (void)ect_virtual_wait(NULL, since_ns + 10);
    forget_calls();
    blocked = SIGUSR1;
    assert_int_equal(wait_with_signal(0, 1), ECT_WAIT_TIMED_OUT);
    EXPECT_CALLS("sent", "sent(1) send_to(7,10,1) ");
    join(&worker);
    assert_int_equal(worker.end_of_wait, ECT_WAIT_INTERRUPTED);
    worker = (worker_t){.run = waits_for_an_hour, .id = 7, .waits = true};
    since_ns = ect_virtual_now();
    start(&worker);
    (void)ect_virtual_wait(NULL, since_ns + 10);
    ect_timer_t timer = {.next_ns = since_ns + 20, .expired = send_signal};
    sends = 1;
    signal_to = 7;
    ect_virtual_add_timer(&timer);
    (void)ect_virtual_pass(50);
    ect_virtual_recall(&signal_of_timer);
    EXPECT_CALLS("recalled", "sent(1) ");
    join(&worker);
    assert_int_equal(worker.end_of_wait, ECT_WAIT_INTERRUPTED);
    EXPECT_CALLS("recalled", "");
    ect_virtual_remove_timer(&timer);
}

static bool *condition_to_set;

static void set_condition(ect_timer_t *unused)
{
    (void)unused;
    *condition_to_set = true;
}

/* recv(2): with a timeout a receive ends after each handler. */
static void restarts_a_receive(void **state)
{
    static const struct {
        bool restarts, limited;
        int error;
        uint64_t span_ns;
    } rows[] = {{true, true, EINTR, 100}, {false, true, EINTR, 100}, {false, false, EINTR, 100}, {true, false, 0, 300}};
    bool condition;
    ect_timer_t timer = {.expired = send_signal}, sets = {.expired = set_condition};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        since_ns = ect_virtual_now();
        signal_of_timer = (ect_signal_t){.info = {.si_signo = SIGUSR1}};
        signal_to = 0;
        sends = 1;
        condition = false;
        condition_to_set = &condition;
        timer.next_ns = since_ns + 100;
        sets.next_ns = since_ns + 300;
        ect_virtual_add_timer(&timer);
        ect_virtual_add_timer(&sets);
        restarts = rows[i].restarts;
        errno = 0;
        ect_time_lock();
        bool ready = ect_time_wait(3, is_ready, &condition, rows[i].limited ? since_ns + 500 : NEVER);
        const int error = errno;
        ect_time_unlock();
        if (ready != (rows[i].error == 0) || (!ready && error != rows[i].error) || passed() != rows[i].span_ns)
            fail_msg("row %zu: ready %d, errno %d after %lu ns", i, ready, error, (unsigned long)passed());
        ect_virtual_remove_timer(&timer);
        ect_virtual_remove_timer(&sets);
        forget_calls();
    }
}

static void waits_until_cancelled(worker_t *its)
{
    int state;
    its->end_of_wait = ect_virtual_wait(NULL, since_ns + 1000);
    (void)pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &state);
    its->second_wait = ect_virtual_wait(NULL, since_ns + 2000);
}

/* A wait without cancellation goes on to its end. */
static void cancels_a_wait(void **state)
{
    worker_t worker = {.run = waits_until_cancelled, .id = 7, .waits = true};
    (void)state;
    start(&worker);
    (void)ect_virtual_wait(NULL, since_ns + 10);
    ect_virtual_cancel(worker.record);
    (void)ect_virtual_wait(NULL, since_ns + 20);
    assert_int_equal(worker.end_of_wait, ECT_WAIT_INTERRUPTED);
    ect_virtual_cancel(worker.record);
    (void)ect_virtual_wait(NULL, since_ns + 30);
    assert_false(worker.ended);
    join(&worker);
    assert_int_equal(passed(), 2000);
    assert_int_equal(worker.second_wait, ECT_WAIT_TIMED_OUT);
    forget_calls();
}

/* --- the thread that watches the turn, and fork
 * ------------------------------------------------------------------------- */

static void end_watcher(void)
{
    pthread_exit(NULL);
}

/* Runs the watcher for so many of its pauses while this thread keeps the turn. */
static void watch_for(unsigned int pauses)
{
    pthread_t thread;
    naps = 0;
    most_naps = pauses + 1;
    on_nap = end_watcher;
    forget_calls();
    (void)pthread_create(&thread, NULL, watcher, NULL);
    (void)pthread_join(thread, NULL);
}

static bool begins_to_watch(void)
{
    in_child();
    uint64_t now_ns = ect_virtual_now();
    forget_calls();
    ect_time_bus_started();
    bool once = strcmp(fakes.log, "sigmask(0,1) watch(1,0) sigmask(2,0) ") == 0 && passed_ns == now_ns;
    ect_time_bus_started();
    forget_calls();
    return once && watcher != NULL;
}

static bool takes_the_turn_away(void)
{
    if (!begins_to_watch())
        return false;
    ect_time_bus_next(NEVER);
    runs_bus = true;
    sleeps = true;
    (void)ect_virtual_now();
    watch_for(99);
    bool early = reports != 0;
    (void)ect_virtual_now(); /* a call keeps the turn */
    watch_for(99);
    early |= reports != 0 || passed() != 0;
    watch_for(110);
    bool taken = reports == 1 && strstr(reported, "call of 55 has waited") != NULL;
    uint64_t advanced = ect_time_now() - since_ns;
    /* The thread takes the turn back with its next call. */
    return !early && taken && advanced >= 50 * MS && passed() == advanced;
}

static bool leaves_the_turn_to_a_busy_thread(void)
{
    if (!begins_to_watch())
        return false;
    ect_time_bus_next(NEVER);
    runs_bus = true;
    (void)ect_virtual_now();
    watch_for(300);
    return reports == 0 && passed() == 0 && strstr(fakes.log, "serve") == NULL;
}

/* The child of a thread that keeps the turn may be a client. */
static bool serves_while_a_thread_waits(void)
{
    if (!begins_to_watch())
        return false;
    ect_time_bus_next(NEVER);
    runs_bus = true;
    sleeps = true;
    (void)ect_virtual_now();
    watch_for(1);
    watch_for(1);
    naps = 0;
    most_naps = 3;
    on_nap = end_watcher;
    plan("serve", 1, 0);
    plan("serve", 1, 0);
    pthread_t thread;
    (void)pthread_create(&thread, NULL, watcher, NULL);
    (void)pthread_join(thread, NULL);
    return served() == 3;
}

static void watches_the_turn(void **state)
{
    (void)state;
    assert_true(in_fork(begins_to_watch));
    assert_true(in_fork(takes_the_turn_away));
    assert_true(in_fork(leaves_the_turn_to_a_busy_thread));
    assert_true(in_fork(serves_while_a_thread_waits));
}

static bool has_one_thread_in_a_child(void)
{
    ect_timer_t timers[] = {{.next_ns = since_ns + 100, .expired = on_timer},
                            {.next_ns = since_ns + 110, .expired = on_timer, .inherited = true},
                            {.next_ns = since_ns + 120, .expired = on_timer},
                            {.next_ns = since_ns + 130, .expired = on_timer, .inherited = true}};
    for (size_t i = 0; i < 4; i++)
        ect_virtual_add_timer(&timers[i]);
    ect_time_bus_next(since_ns + 50);
    runs_bus = true;
    void *ghost = ect_virtual_thread_new(NULL); /* never gets a turn */
    in_child();
    forget_calls();
    thread_id = 77;
    bool good = ghost && ect_virtual_wait(NULL, since_ns + 200) == ECT_WAIT_TIMED_OUT && passed() == 200;
    return good && strcmp(fakes.log, "expired(110,0) expired(130,0) ") == 0;
}

static void forks(void **state)
{
    (void)state;
    assert_true(in_fork(has_one_thread_in_a_child));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"Time passes by calls and waits", passes_time, begin, NULL, NULL},
        {"The bus runs when it is due, with a pause when it is due again at once", runs_the_bus, begin, NULL, NULL},
        {"Timers expire in time, once or with an interval", runs_timers, begin, NULL, NULL},
        {"A condition ends a wait", waits_for_conditions, begin, NULL, NULL},
        {"A wait of a socket returns with the lock", waits_with_the_lock, begin, NULL, NULL},
        {"Without a deadline, time passes as in the real world", waits_for_the_world, begin, NULL, NULL},
        {"A wait of a second for another process is reported once", reports_long_waits, begin, NULL, NULL},
        {"Time is stopped while a thread waits for a process", stops_time_for_a_process, begin, NULL, NULL},
        {"A process without a bus gives its children time", gives_children_time, begin, NULL, NULL},
        {"A handler of a real signal ends a wait", ends_with_a_handler_of_a_real_signal, begin, NULL, NULL},
        {"A handler that was deferred ends a wait", ends_with_a_deferred_handler, begin, NULL, NULL},
        {"Clients are served in waits, and in every 64th call", serves_clients, begin, NULL, NULL},
        {"Threads take turns in the order in which they became ready", takes_turns, begin, NULL, NULL},
        {"Threads are woken in the order of their waits", wakes_in_order, begin, NULL, NULL},
        {"Conditions are checked in every 16th call", looks_at_conditions_now_and_then, begin, NULL, NULL},
        {"A thread without a call ends in its turn", ends_in_its_turn, begin, NULL, NULL},
        {"A process has up to 1024 threads", has_1024_threads, begin, NULL, NULL},
        {"A signal of a timer ends a wait", interrupts_a_wait, begin, NULL, NULL},
        {"Blocked, ignored and pending signals are the kernel's", leaves_signals_to_the_kernel, begin, NULL, NULL},
        {"A signal reaches a thread that does not block it", reaches_another_thread, begin, NULL, NULL},
        {"SA_RESTART repeats the wait of a socket without timeout", restarts_a_receive, begin, NULL, NULL},
        {"A cancellation ends a wait of a thread that can be cancelled", cancels_a_wait, begin, NULL, NULL},
        {"A thread that sleeps in the kernel for a second loses the turn", watches_the_turn, begin, NULL, NULL},
        {"The child of fork has one thread, and the timers that are inherited", forks, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
