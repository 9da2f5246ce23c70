/* SPDX-License-Identifier: MIT */
/*
 * Threads and locks of C11, timed locks, and time spans at their limits: on the virtual clock as the C library has them
 * on the real one.
 * usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_times {} real|virtual [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <linux/futex.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdio.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <threads.h>
#include <unistd.h>

#define S 1000000000u

static struct timespec in(clockid_t clock, uint64_t ns)
{
    struct timespec now;
    clock_gettime(clock, &now);
    uint64_t at_ns = (uint64_t)now.tv_sec * S + (uint64_t)now.tv_nsec + ns;
    return (struct timespec){.tv_sec = (time_t)(at_ns / S), .tv_nsec = (long)(at_ns % S)};
}

/* --- threads of C11 ------------------------------------------------------------------------------------------------
 */

static int add_one(void *arg)
{
    ++*(int *)arg;
    return -7;
}

static int leave(void *arg)
{
    ++*(int *)arg;
    thrd_exit(9);
}

static void threads_return_numbers(void **state)
{
    int count = 0, result = 0;
    thrd_t thread;
    (void)state;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(thrd_create(&thread, i == 1 ? leave : add_one, &count), thrd_success);
        assert_int_equal(thrd_join(thread, i == 2 ? NULL : &result), thrd_success);
        assert_int_equal(result, i == 0 ? -7 : 9);
        assert_int_equal(count, i + 1);
    }
}

/* A ball that two threads hold in turn. */
typedef struct court {
    mtx_t lock;
    cnd_t changed;
    unsigned int turns;
} court_t;

enum { TURNS = 200 };

static int play(void *arg)
{
    court_t *its = arg;
    mtx_lock(&its->lock);
    while (its->turns < TURNS) {
        while (its->turns % 2 == 0 && its->turns < TURNS)
            cnd_wait(&its->changed, &its->lock);
        its->turns++;
        cnd_signal(&its->changed);
    }
    mtx_unlock(&its->lock);
    return 0;
}

static void conditions_wake_threads(void **state)
{
    court_t its = {.turns = 0};
    thrd_t thread;
    (void)state;
    assert_int_equal(mtx_init(&its.lock, mtx_plain), thrd_success);
    assert_int_equal(cnd_init(&its.changed), thrd_success);
    assert_int_equal(thrd_create(&thread, play, &its), thrd_success);
    assert_int_equal(mtx_lock(&its.lock), thrd_success);
    while (its.turns < TURNS) {
        its.turns++;
        assert_int_equal(cnd_broadcast(&its.changed), thrd_success);
        while (its.turns % 2 == 1 && its.turns < TURNS)
            assert_int_equal(cnd_wait(&its.changed, &its.lock), thrd_success);
    }
    assert_int_equal(mtx_unlock(&its.lock), thrd_success);
    assert_int_equal(thrd_join(thread, NULL), thrd_success);
    cnd_destroy(&its.changed);
    mtx_destroy(&its.lock);
}

static int hold(void *arg)
{
    mtx_t *lock = arg;
    mtx_lock(lock);
    usleep(20000);
    return mtx_unlock(lock);
}

static void times_of_c11(void **state)
{
    struct timespec time, day;
    mtx_t lock;
    cnd_t never;
    thrd_t thread;
    int result = -1;
    (void)state;
    assert_int_equal(timespec_get(&time, TIME_UTC), TIME_UTC);
    clock_gettime(CLOCK_REALTIME, &day);
    assert_in_range((uint64_t)(day.tv_sec - time.tv_sec) * S + (uint64_t)day.tv_nsec - (uint64_t)time.tv_nsec, 0,
                    is_virtual ? 1000 : 10 * (uint64_t)S);
    assert_int_equal(timespec_get(&time, 0), 0);
    assert_int_equal(mtx_init(&lock, mtx_timed), thrd_success);
    assert_int_equal(cnd_init(&never), thrd_success);
    mtx_lock(&lock);
    time = in(CLOCK_REALTIME, 5 * MS);
    uint64_t since_ns = now_ns();
    assert_int_equal(cnd_timedwait(&never, &lock, &time), thrd_timedout);
    assert_took(since_ns, 5 * MS - 1000);
    mtx_unlock(&lock);
    assert_int_equal(thrd_create(&thread, hold, &lock), thrd_success);
    assert_int_equal(thrd_sleep(&(struct timespec){.tv_nsec = 10 * MS}, NULL), 0);
    if (is_virtual) {
        time = in(CLOCK_REALTIME, 5 * MS);
        since_ns = now_ns();
        assert_int_equal(mtx_timedlock(&lock, &time), thrd_timedout);
        assert_took(since_ns, 5 * MS - 1000);
    }
    time = in(CLOCK_REALTIME, 100 * (uint64_t)S);
    assert_int_equal(mtx_timedlock(&lock, &time), thrd_success);
    assert_int_equal(mtx_trylock(&lock), thrd_busy);
    assert_int_equal(mtx_unlock(&lock), thrd_success);
    assert_int_equal(thrd_join(thread, &result), thrd_success);
    assert_int_equal(result, thrd_success);
    thrd_yield();
    cnd_destroy(&never);
    mtx_destroy(&lock);
}

/* --- timed locks ---------------------------------------------------------------------------------------------------
 */

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_rwlock_t rwlock = PTHREAD_RWLOCK_INITIALIZER;
static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
static sem_t semaphore;

static int mutex_timed(const struct timespec *until)
{
    return pthread_mutex_timedlock(&mutex, until);
}

static int mutex_clock(const struct timespec *until)
{
    return pthread_mutex_clocklock(&mutex, CLOCK_REALTIME, until);
}

static int read_timed(const struct timespec *until)
{
    return pthread_rwlock_timedrdlock(&rwlock, until);
}

static int write_timed(const struct timespec *until)
{
    return pthread_rwlock_timedwrlock(&rwlock, until);
}

static int read_clock(const struct timespec *until)
{
    return pthread_rwlock_clockrdlock(&rwlock, CLOCK_REALTIME, until);
}

static int write_clock(const struct timespec *until)
{
    return pthread_rwlock_clockwrlock(&rwlock, CLOCK_REALTIME, until);
}

static int wait_timed(const struct timespec *until)
{
    return sem_timedwait(&semaphore, until) == 0 ? 0 : errno;
}

static int wait_clock(const struct timespec *until)
{
    return sem_clockwait(&semaphore, CLOCK_REALTIME, until) == 0 ? 0 : errno;
}

static int condition_timed(const struct timespec *until)
{
    return pthread_cond_timedwait(&condition, &mutex, until);
}

static int condition_clock(const struct timespec *until)
{
    return pthread_cond_clockwait(&condition, &mutex, CLOCK_REALTIME, until);
}

static void *lock_all(void *arg)
{
    sem_t *const *its = arg;
    pthread_mutex_lock(&mutex);
    pthread_rwlock_wrlock(&rwlock);
    sem_post(its[0]);
    while (sem_wait(its[1]) != 0)
        continue;
    pthread_mutex_unlock(&mutex);
    pthread_rwlock_unlock(&rwlock);
    return NULL;
}

typedef struct timed {
    const char *name;
    int (*wait)(const struct timespec *until);
} timed_t;

static const timed_t timed[] = {{"pthread_mutex_timedlock", mutex_timed},
                                {"pthread_mutex_clocklock", mutex_clock},
                                {"pthread_rwlock_timedrdlock", read_timed},
                                {"pthread_rwlock_timedwrlock", write_timed},
                                {"pthread_rwlock_clockrdlock", read_clock},
                                {"pthread_rwlock_clockwrlock", write_clock},
                                {"sem_timedwait", wait_timed},
                                {"sem_clockwait", wait_clock}};

static void each_of_the_locked(void (*check)(const timed_t *its))
{
    sem_t locked, ends;
    pthread_t thread;
    sem_init(&locked, 0, 0);
    sem_init(&ends, 0, 0);
    sem_init(&semaphore, 0, 0);
    assert_int_equal(pthread_create(&thread, NULL, lock_all, (sem_t *[]){&locked, &ends}), 0);
    while (sem_wait(&locked) != 0)
        continue;
    for (size_t i = 0; i < sizeof timed / sizeof *timed; i++)
        check(&timed[i]);
    sem_post(&ends);
    assert_int_equal(pthread_join(thread, NULL), 0);
}

static void times_out(const timed_t *its)
{
    const struct timespec until = in(CLOCK_REALTIME, 5 * MS);
    uint64_t since_ns = now_ns();
    int error = its->wait(&until);
    if (error != ETIMEDOUT)
        fail_msg("%s: %d, expected ETIMEDOUT", its->name, error);
    assert_took(since_ns, 5 * MS - 1000);
}

static void locks_time_out(void **state)
{
    (void)state;
    each_of_the_locked(times_out);
}

static const struct timespec invalid_times[] = {{.tv_sec = 1, .tv_nsec = -1}, {.tv_sec = 1, .tv_nsec = S}};

static void is_refused(const timed_t *its)
{
    for (size_t i = 0; i < 2; i++) {
        int error = its->wait(&invalid_times[i]);
        if (error != EINVAL)
            fail_msg("%s, %ld ns: %d, expected EINVAL", its->name, invalid_times[i].tv_nsec, error);
    }
}

static void refuses_invalid_points(void **state)
{
    (void)state;
    each_of_the_locked(is_refused);
    pthread_mutex_lock(&mutex);
    is_refused(&(timed_t){"pthread_cond_timedwait", condition_timed});
    is_refused(&(timed_t){"pthread_cond_clockwait", condition_clock});
    pthread_mutex_unlock(&mutex);
}

/* Only a mutex that is free does not read the time. */
static void free_locks_need_no_time(void **state)
{
    static const struct timespec past = {.tv_sec = -1};
    (void)state;
    for (size_t i = 0; i < sizeof timed / sizeof *timed; i++) {
        sem_init(&semaphore, 0, 1);
        for (size_t n = 0; n < 2; n++) {
            assert_int_equal(timed[i].wait(&invalid_times[n]), i < 2 ? 0 : EINVAL);
            assert_int_equal(i < 2 ? pthread_mutex_unlock(&mutex) : 0, 0);
        }
        assert_int_equal(timed[i].wait(&past), 0);
        if (i < 2)
            assert_int_equal(pthread_mutex_unlock(&mutex), 0);
        else if (i < 6)
            assert_int_equal(pthread_rwlock_unlock(&rwlock), 0);
    }
}

static void is_over(const timed_t *its)
{
    static const struct timespec past = {.tv_sec = -1};
    int error = its->wait(&past);
    if (error != ETIMEDOUT)
        fail_msg("%s: %d, expected ETIMEDOUT", its->name, error);
}

static void times_before_the_clock(void **state)
{
    (void)state;
    each_of_the_locked(is_over);
}

static void *unlock_later(void *arg)
{
    sem_t *const *its = arg;
    pthread_mutex_lock(&mutex);
    pthread_rwlock_wrlock(&rwlock);
    sem_post(its[0]);
    usleep(5000);
    pthread_mutex_unlock(&mutex);
    pthread_rwlock_unlock(&rwlock);
    sem_post(&semaphore);
    return NULL;
}

/* Each lock is locked for 5 ms; the time is the latest of the type. */
static void times_after_the_clock(void **state)
{
    static const struct timespec last = {.tv_sec = INT64_MAX, .tv_nsec = S - 1};
    (void)state;
    for (size_t i = 0; i < sizeof timed / sizeof *timed; i++) {
        sem_t locked;
        pthread_t thread;
        sem_init(&locked, 0, 0);
        sem_init(&semaphore, 0, 0);
        assert_int_equal(pthread_create(&thread, NULL, unlock_later, (sem_t *[]){&locked}), 0);
        while (sem_wait(&locked) != 0)
            continue;
        int error = timed[i].wait(&last);
        if (error != 0)
            fail_msg("%s: %d, expected 0", timed[i].name, error);
        if (i < 2)
            pthread_mutex_unlock(&mutex);
        else if (i < 6)
            pthread_rwlock_unlock(&rwlock);
        assert_int_equal(pthread_join(thread, NULL), 0);
    }
}

static void a_thread_locks_a_lock_twice(void **state)
{
    const struct timespec until = in(CLOCK_REALTIME, 0);
    (void)state;
    assert_int_equal(pthread_rwlock_wrlock(&rwlock), 0);
    assert_int_equal(pthread_rwlock_wrlock(&rwlock), EDEADLK);
    assert_int_equal(pthread_rwlock_rdlock(&rwlock), EDEADLK);
    for (size_t i = 2; i < 6; i++)
        assert_int_equal(timed[i].wait(&until), EDEADLK);
    assert_int_equal(pthread_rwlock_unlock(&rwlock), 0);
}

/* --- time spans ----------------------------------------------------------------------------------------------------
 */

static int sleep_for(const struct timespec *span)
{
    return nanosleep(span, NULL) == 0 ? 0 : errno;
}

static int sleep_on_clock(const struct timespec *span)
{
    return clock_nanosleep(CLOCK_MONOTONIC, 0, span, NULL);
}

static int sleep_until_point(const struct timespec *point)
{
    return clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, point, NULL);
}

static int poll_for(const struct timespec *span)
{
    return ppoll(NULL, 0, span, NULL) == 0 ? 0 : errno;
}

static int pselect_for(const struct timespec *span)
{
    return pselect(0, NULL, NULL, NULL, span, NULL) == 0 ? 0 : errno;
}

static int select_for(const struct timespec *span)
{
    struct timeval its = {.tv_sec = span->tv_sec, .tv_usec = span->tv_nsec / 1000};
    return select(0, NULL, NULL, NULL, &its) == 0 ? 0 : errno;
}

static int accept_signal(const struct timespec *span)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGUSR2);
    return sigtimedwait(&set, NULL, span) >= 0 ? 0 : errno;
}

static int wait_for_word(const struct timespec *span)
{
    static unsigned int word;
    return syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, 0, span, NULL, 0) == 0 ? 0 : errno;
}

static int receive_from(int fd, const struct timespec *span)
{
    const struct timeval its = {.tv_sec = span->tv_sec, .tv_usec = span->tv_nsec / 1000};
    uint8_t frame[FRAME];
    int error = setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &its, sizeof its) == 0 ? 0 : errno;
    if (error == 0)
        error = recv(fd, frame, sizeof frame, 0) >= 0 ? 0 : errno;
    close(fd);
    return error;
}

static int receive_for(const struct timespec *span)
{
    return receive_from(open_socket(0), span);
}

static int receive_local_for(const struct timespec *span)
{
    return receive_from(socket(AF_UNIX, SOCK_DGRAM, 0), span);
}

typedef struct spanned {
    timed_t call;
    int over;     /* error of a span of 0; -1: no limit */
    int negative; /* of -1 s; -1: on the virtual clock as no limit */
    int fraction; /* of invalid nanoseconds */
} spanned_t;

static const spanned_t spanned[] = {{{"nanosleep", sleep_for}, 0, EINVAL, EINVAL},
                                    {{"clock_nanosleep", sleep_on_clock}, 0, EINVAL, EINVAL},
                                    {{"clock_nanosleep, absolute", sleep_until_point}, 0, EINVAL, EINVAL},
                                    {{"ppoll", poll_for}, 0, EINVAL, EINVAL},
                                    {{"pselect", pselect_for}, 0, EINVAL, EINVAL},
                                    {{"select", select_for}, 0, EINVAL, 0},
                                    {{"sigtimedwait", accept_signal}, EAGAIN, EINVAL, EINVAL},
                                    {{"futex", wait_for_word}, ETIMEDOUT, EINVAL, EINVAL},
                                    {{"SO_RCVTIMEO", receive_for}, -1, EAGAIN, EDOM},
                                    {{"SO_RCVTIMEO of a local socket", receive_local_for}, -1, -1, EDOM}};

static void check_span(const spanned_t *its, struct timespec span, int expected)
{
    int error = its->call.wait(&span);
    if (error != expected)
        fail_msg("%s, %lld s %ld ns: %d, expected %d", its->call.name, (long long)span.tv_sec, span.tv_nsec, error,
                 expected);
}

static void refuses_invalid_spans(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof spanned / sizeof *spanned; i++) {
        if (spanned[i].over >= 0)
            check_span(&spanned[i], (struct timespec){0, 0}, spanned[i].over);
        if (spanned[i].negative >= 0)
            check_span(&spanned[i], (struct timespec){-1, 0}, spanned[i].negative);
        check_span(&spanned[i], (struct timespec){0, S}, spanned[i].fraction);
        if (spanned[i].fraction != 0)
            check_span(&spanned[i], (struct timespec){0, -1000}, spanned[i].fraction);
    }
}

static void on_alarm(int number)
{
    (void)number;
}

static void the_longest_span(void **state)
{
    const struct sigaction action = {.sa_handler = on_alarm};
    const struct itimerval alarm = {{.tv_usec = 5000}, {.tv_usec = 5000}}, none = {.it_value.tv_sec = 0};
    (void)state;
    assert_int_equal(sigaction(SIGALRM, &action, NULL), 0);
    assert_int_equal(setitimer(ITIMER_REAL, &alarm, NULL), 0);
    for (size_t i = 0; i < sizeof spanned / sizeof *spanned; i++)
        check_span(&spanned[i], (struct timespec){INT64_MAX, S - 1}, EINTR);
    assert_int_equal(setitimer(ITIMER_REAL, &none, NULL), 0);
}

/* A handler runs every 5 ms; without SA_RESTART it ends the read of a timer that is not set yet. */
static void reads_and_handlers(void **state)
{
    const struct itimerval alarm = {{.tv_usec = 5000}, {.tv_usec = 5000}}, none = {.it_value.tv_sec = 0};
    const struct itimerspec once = {.it_value.tv_nsec = 18 * MS};
    (void)state;
    for (int restarts = 0; restarts < 2; restarts++) {
        const struct sigaction action = {.sa_handler = on_alarm, .sa_flags = restarts == 1 ? SA_RESTART : 0};
        uint64_t expiries = 0;
        int fd = timerfd_create(CLOCK_MONOTONIC, 0);
        assert_int_equal(sigaction(SIGALRM, &action, NULL), 0);
        assert_int_equal(setitimer(ITIMER_REAL, &alarm, NULL), 0);
        if (restarts == 0) {
            assert_int_equal(read(fd, &expiries, sizeof expiries), -1);
            assert_int_equal(errno, EINTR);
            assert_int_equal(setitimer(ITIMER_REAL, &none, NULL), 0);
        }
        assert_int_equal(timerfd_settime(fd, 0, &once, NULL), 0);
        assert_int_equal(read(fd, &expiries, sizeof expiries), sizeof expiries);
        assert_int_equal(expiries, 1);
        assert_int_equal(setitimer(ITIMER_REAL, &none, NULL), 0);
        close(fd);
    }
}

static void the_longest_timers(void **state)
{
    const struct itimerspec rows[] = {{.it_value = {INT64_MAX, S - 1}}, {{INT64_MAX, S - 1}, {0, 1}}};
    struct itimerspec left;
    uint64_t expiries = 0;
    int fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
    (void)state;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(timerfd_settime(fd, 0, &rows[i], NULL), 0);
        usleep(2000);
        assert_int_equal(read(fd, &expiries, sizeof expiries), i == 0 ? -1 : (int)sizeof expiries);
        assert_int_equal(timerfd_gettime(fd, &left), 0);
        assert_true(left.it_value.tv_sec > 1000);
        assert_int_equal(read(fd, &expiries, sizeof expiries), -1);
    }
    close(fd);
}

static void refuses_invalid_intervals(void **state)
{
    static const struct itimerval rows[] = {{.it_value = {-1, 0}},
                                            {.it_value = {0, 1000000}},
                                            {.it_value = {1, -1}},
                                            {{0, 1000000}, {1, 0}},
                                            {.it_interval = {0, -1}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        assert_int_equal(setitimer(ITIMER_REAL, &rows[i], NULL), -1);
        assert_int_equal(errno, EINVAL);
    }
}

/* The clock is that of a bus. */
static int open_bus(void **state)
{
    static int fd;
    fd = open_socket(0);
    *state = &fd;
    return 0;
}

static int close_bus(void **state)
{
    return close(*(int *)*state);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"C11: thrd_join gets the number that the thread returns, or passes to thrd_exit", threads_return_numbers, NULL,
         NULL, NULL},
        {"C11: conditions wake threads in turn", conditions_wake_threads, NULL, NULL, NULL},
        {"C11: waits end at a time of timespec_get", times_of_c11, NULL, NULL, NULL},
        {"POSIX: each timed lock ends with ETIMEDOUT", locks_time_out, NULL, NULL, NULL},
        {"POSIX: a time with invalid nanoseconds is refused with EINVAL", refuses_invalid_points, NULL, NULL, NULL},
        {"POSIX: a free lock is locked at any time, and a free mutex at an invalid one", free_locks_need_no_time, NULL,
         NULL, NULL},
        {"POSIX: a time before the beginning of the clock ends with ETIMEDOUT", times_before_the_clock, NULL, NULL,
         NULL},
        {"POSIX: a lock with the latest time of the type is waited for", times_after_the_clock, NULL, NULL, NULL},
        {"POSIX: a read-write lock that the thread has locked to write is refused with EDEADLK",
         a_thread_locks_a_lock_twice, NULL, NULL, NULL},
        {"POSIX: an invalid time span is refused", refuses_invalid_spans, NULL, NULL, NULL},
        {"POSIX: only a signal ends the longest time span", the_longest_span, NULL, NULL, NULL},
        {"signal(7): a read ends with EINTR after a handler without SA_RESTART, and continues otherwise",
         reads_and_handlers, NULL, NULL, NULL},
        {"POSIX: a timer keeps the longest times and intervals", the_longest_timers, NULL, NULL, NULL},
        {"setitimer(2): an invalid time is refused with EINVAL", refuses_invalid_intervals, NULL, NULL, NULL},
    };
    return is_started(argc, argv) ? cmocka_run_group_tests(tests, open_bus, close_bus) : 1;
}
