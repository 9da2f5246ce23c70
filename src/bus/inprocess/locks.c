/* SPDX-License-Identifier: MIT */
/*
 * Threads, mutexes, conditions, semaphores and futexes on the virtual clock. One thread runs at a time (threads.h), so
 * the real try functions manage the state of an object, and only waits are implemented here.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <linux/futex.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/raw.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/sanitizer.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"

/* --- threads -------------------------------------------------------------------------------------------------------
 */

typedef struct created {
    struct created *next;
    void *(*start)(void *arg);
    void *arg;
    void *record;
    pthread_t thread;
    int ended;
} created_t;

static created_t *created; /* not yet joined threads; changed only by the thread with the turn */

static void add_created(void *arg)
{
    created_t *its = arg;
    its->next = created;
    created = its;
}

static void *run_created(void *arg)
{
    created_t *its = arg;
    ect_raw_thread();
    ect_virtual_thread_begin(its->record, !ect_sanitizer_is_loaded());
    return its->start(its->arg); /* the end of the thread is the destructor of a key, also after pthread_exit() */
}

REPLACES int pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict attributes,
                            void *(*start)(void *arg), void *restrict arg)
{
    if (ect_inside > 0)
        return REAL(pthread_create)(thread, attributes, start, arg);
    created_t *its = calloc(1, sizeof *its);
    if (!its)
        return EAGAIN;
    (void)ect_virtual_now(); /* takes the turn, which guards `created` */
    *its = (created_t){.start = start, .arg = arg};
    its->record = ect_virtual_thread_new(&its->ended);
    int error = its->record ? REAL(pthread_create)(thread, attributes, run_created, its) : EAGAIN;
    if (error != 0) {
        if (its->record)
            ect_virtual_thread_cancel(its->record);
        free(its);
        return error;
    }
    its->thread = *thread;
    add_created(its);
    return 0;
}

/* @return the place of a thread in the list; that of NULL: none */
static created_t **place_of_thread(pthread_t thread)
{
    created_t **at = &created;
    while (*at && !pthread_equal((*at)->thread, thread))
        at = &(*at)->next;
    return at;
}

static created_t *take_created(pthread_t thread)
{
    created_t **at = place_of_thread(thread);
    created_t *its = *at;
    if (its)
        *at = its->next;
    return its;
}

REPLACES int pthread_cancel(pthread_t thread)
{
    if (ect_inside > 0)
        return REAL(pthread_cancel)(thread);
    (void)ect_virtual_now();
    int error = REAL(pthread_cancel)(thread);
    const created_t *its = *place_of_thread(thread);
    if (error == 0 && its && !its->ended)
        ect_virtual_cancel(its->record);
    return error;
}

/* The cancellation point of a join, whose thread another thread may then join. */
static void test_join(created_t *its)
{
    pthread_cleanup_push(add_created, its);
    pthread_testcancel();
    pthread_cleanup_pop(0);
}

REPLACES int pthread_join(pthread_t thread, void **result)
{
    if (ect_inside == 0)
        (void)ect_virtual_now();
    created_t *its = ect_inside > 0 ? NULL : take_created(thread);
    while (its && !its->ended) {
        (void)ect_virtual_wait(&its->ended, UINT64_MAX);
        test_join(its);
    }
    int error = REAL(pthread_join)(thread, result);
    free(its);
    return error;
}

int pthread_clockjoin_np(pthread_t thread, void **result, clockid_t clock, const struct timespec *until);
REPLACES int pthread_clockjoin_np(pthread_t thread, void **result, clockid_t clock, const struct timespec *until)
{
    if (ect_inside > 0)
        return REAL(pthread_clockjoin_np)(thread, result, clock, until);
    uint64_t until_ns = ect_deadline_on(clock, until);
    (void)ect_virtual_now();
    created_t *its = take_created(thread);
    while (its && !its->ended) {
        bool over = ect_virtual_wait(&its->ended, until_ns) == ECT_WAIT_TIMED_OUT;
        test_join(its);
        if (!over)
            continue;
        add_created(its);
        return ETIMEDOUT;
    }
    int error = REAL(pthread_join)(thread, result);
    free(its);
    return error;
}

REPLACES int pthread_timedjoin_np(pthread_t thread, void **result, const struct timespec *until)
{
    return pthread_clockjoin_np(thread, result, CLOCK_REALTIME, until);
}

/* --- mutexes -------------------------------------------------------------------------------------------------------
 */

static const struct timespec over = {.tv_sec = -1}; /* a time that has passed on each clock */

/* Repeats the try of a thread that has just got the turn, because an unlock before the turn has found no waiting
 * thread. The timed lock returns EDEADLK if this thread holds the mutex, which the try variant cannot report. */
static int lock_with_turn(pthread_mutex_t *mutex)
{
    (void)ect_virtual_now();
    return REAL(pthread_mutex_timedlock)(mutex, &over);
}

static int lock_until(pthread_mutex_t *mutex, uint64_t until_ns)
{
    int error = REAL(pthread_mutex_trylock)(mutex);
    if (error == EBUSY)
        error = lock_with_turn(mutex);
    while (error == EBUSY || error == ETIMEDOUT) {
        if (ect_virtual_wait(mutex, until_ns) == ECT_WAIT_TIMED_OUT)
            return ETIMEDOUT;
        error = REAL(pthread_mutex_trylock)(mutex);
    }
    return error;
}

/* The time of a free mutex is not read. */
static int lock_timed(pthread_mutex_t *mutex, clockid_t clock, const struct timespec *until)
{
    if (ect_is_point(until))
        return lock_until(mutex, ect_deadline_on(clock, until));
    int error = REAL(pthread_mutex_trylock)(mutex);
    return error == EBUSY ? EINVAL : error;
}

REPLACES int pthread_mutex_lock(pthread_mutex_t *mutex)
{
    if (ect_inside > 0)
        return REAL(pthread_mutex_lock)(mutex);
    return lock_until(mutex, UINT64_MAX);
}

REPLACES int pthread_mutex_timedlock(pthread_mutex_t *restrict mutex, const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_mutex_timedlock)(mutex, until);
    return lock_timed(mutex, CLOCK_REALTIME, until);
}

int pthread_mutex_clocklock(pthread_mutex_t *restrict mutex, clockid_t clock, const struct timespec *restrict until);
REPLACES int pthread_mutex_clocklock(pthread_mutex_t *restrict mutex, clockid_t clock,
                                     const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_mutex_clocklock)(mutex, clock, until);
    return lock_timed(mutex, clock, until);
}

/* Yields, because the holder of the lock may be waiting for its turn. */
REPLACES int pthread_spin_lock(pthread_spinlock_t *lock)
{
    if (ect_inside > 0)
        return REAL(pthread_spin_lock)(lock);
    int error;
    while ((error = REAL(pthread_spin_trylock)(lock)) == EBUSY)
        ect_virtual_yield();
    return error;
}

REPLACES int pthread_mutex_unlock(pthread_mutex_t *mutex)
{
    int error = REAL(pthread_mutex_unlock)(mutex);
    if (ect_inside == 0)
        (void)ect_virtual_wake(mutex, 1);
    return error;
}

static void relock(pthread_mutex_t *mutex)
{
    (void)lock_until(mutex, UINT64_MAX);
}

/* --- conditions ----------------------------------------------------------------------------------------------------
 */

static int wait_until(const pthread_cond_t *condition, pthread_mutex_t *mutex, uint64_t until_ns)
{
    pthread_testcancel();
    (void)ect_virtual_now(); /* takes the turn: no signal can be lost between unlock and wait */
    int error = REAL(pthread_mutex_unlock)(mutex);
    if (error != 0)
        return error;
    (void)ect_virtual_wake(mutex, 1);
    ect_wait_t result = ect_virtual_wait(condition, until_ns);
    relock(mutex);
    pthread_testcancel();                                /* a cleanup handler unlocks the mutex */
    return result == ECT_WAIT_TIMED_OUT ? ETIMEDOUT : 0; /* after a signal handler: a spurious wake-up */
}

REPLACES int pthread_cond_wait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex)
{
    if (ect_inside > 0)
        return REAL(pthread_cond_wait)(condition, mutex);
    return wait_until(condition, mutex, UINT64_MAX);
}

REPLACES int pthread_cond_timedwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex,
                                    const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_cond_timedwait)(condition, mutex, until);
    return ect_is_point(until) ? wait_until(condition, mutex, ect_deadline(until)) : EINVAL;
}

int pthread_cond_clockwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex, clockid_t clock,
                           const struct timespec *restrict until);
REPLACES int pthread_cond_clockwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex,
                                    clockid_t clock, const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_cond_clockwait)(condition, mutex, clock, until);
    return ect_is_point(until) ? wait_until(condition, mutex, ect_deadline_on(clock, until)) : EINVAL;
}

REPLACES int pthread_cond_signal(pthread_cond_t *condition)
{
    if (ect_inside > 0)
        return REAL(pthread_cond_signal)(condition);
    (void)ect_virtual_wake(condition, 1);
    return 0;
}

REPLACES int pthread_cond_broadcast(pthread_cond_t *condition)
{
    if (ect_inside > 0)
        return REAL(pthread_cond_broadcast)(condition);
    (void)ect_virtual_wake(condition, UINT_MAX);
    return 0;
}

/* --- read-write locks ----------------------------------------------------------------------------------------------
 */

/* As lock_until() locks a mutex. */
static int lock_to_read(pthread_rwlock_t *lock, uint64_t until_ns)
{
    int error = REAL(pthread_rwlock_tryrdlock)(lock);
    if (error == EBUSY) {
        (void)ect_virtual_now();
        error = REAL(pthread_rwlock_timedrdlock)(lock, &over);
    }
    while (error == EBUSY || error == ETIMEDOUT) {
        if (ect_virtual_wait(lock, until_ns) == ECT_WAIT_TIMED_OUT)
            return ETIMEDOUT;
        error = REAL(pthread_rwlock_tryrdlock)(lock);
    }
    return error;
}

static int lock_to_write(pthread_rwlock_t *lock, uint64_t until_ns)
{
    int error = REAL(pthread_rwlock_trywrlock)(lock);
    if (error == EBUSY) {
        (void)ect_virtual_now();
        error = REAL(pthread_rwlock_timedwrlock)(lock, &over);
    }
    while (error == EBUSY || error == ETIMEDOUT) {
        if (ect_virtual_wait(lock, until_ns) == ECT_WAIT_TIMED_OUT)
            return ETIMEDOUT;
        error = REAL(pthread_rwlock_trywrlock)(lock);
    }
    return error;
}

REPLACES int pthread_rwlock_rdlock(pthread_rwlock_t *lock)
{
    return ect_inside > 0 ? REAL(pthread_rwlock_rdlock)(lock) : lock_to_read(lock, UINT64_MAX);
}

REPLACES int pthread_rwlock_wrlock(pthread_rwlock_t *lock)
{
    return ect_inside > 0 ? REAL(pthread_rwlock_wrlock)(lock) : lock_to_write(lock, UINT64_MAX);
}

int pthread_rwlock_clockrdlock(pthread_rwlock_t *restrict lock, clockid_t clock, const struct timespec *restrict until);
REPLACES int pthread_rwlock_clockrdlock(pthread_rwlock_t *restrict lock, clockid_t clock,
                                        const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_rwlock_clockrdlock)(lock, clock, until);
    return ect_is_point(until) ? lock_to_read(lock, ect_deadline_on(clock, until)) : EINVAL;
}

int pthread_rwlock_clockwrlock(pthread_rwlock_t *restrict lock, clockid_t clock, const struct timespec *restrict until);
REPLACES int pthread_rwlock_clockwrlock(pthread_rwlock_t *restrict lock, clockid_t clock,
                                        const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_rwlock_clockwrlock)(lock, clock, until);
    return ect_is_point(until) ? lock_to_write(lock, ect_deadline_on(clock, until)) : EINVAL;
}

REPLACES int pthread_rwlock_timedrdlock(pthread_rwlock_t *restrict lock, const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_rwlock_timedrdlock)(lock, until);
    return pthread_rwlock_clockrdlock(lock, CLOCK_REALTIME, until);
}

REPLACES int pthread_rwlock_timedwrlock(pthread_rwlock_t *restrict lock, const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(pthread_rwlock_timedwrlock)(lock, until);
    return pthread_rwlock_clockwrlock(lock, CLOCK_REALTIME, until);
}

REPLACES int pthread_rwlock_unlock(pthread_rwlock_t *lock)
{
    int error = REAL(pthread_rwlock_unlock)(lock);
    if (ect_inside == 0)
        (void)ect_virtual_wake(lock, UINT_MAX);
    return error;
}

/* --- semaphores ----------------------------------------------------------------------------------------------------
 */

/* @return 0; -1 (errno) */
static int wait_semaphore(sem_t *semaphore, uint64_t until_ns)
{
    pthread_testcancel();
    if (REAL(sem_trywait)(semaphore) == 0)
        return 0;
    (void)ect_virtual_now(); /* as in lock_with_turn() */
    while (REAL(sem_trywait)(semaphore) != 0) {
        if (errno != EAGAIN)
            return -1;
        ect_wait_t result = ect_virtual_wait(semaphore, until_ns);
        pthread_testcancel();
        if (result == ECT_WAIT_WOKEN || (result == ECT_WAIT_INTERRUPTED && ect_virtual_restarts()))
            continue;
        errno = result == ECT_WAIT_TIMED_OUT ? ETIMEDOUT : EINTR;
        return -1;
    }
    return 0;
}

static int wait_timed(sem_t *semaphore, clockid_t clock, const struct timespec *until)
{
    if (ect_is_point(until))
        return wait_semaphore(semaphore, ect_deadline_on(clock, until));
    errno = EINVAL;
    return -1;
}

REPLACES int sem_wait(sem_t *semaphore)
{
    return ect_inside > 0 ? REAL(sem_wait)(semaphore) : wait_semaphore(semaphore, UINT64_MAX);
}

REPLACES int sem_timedwait(sem_t *restrict semaphore, const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(sem_timedwait)(semaphore, until);
    return wait_timed(semaphore, CLOCK_REALTIME, until);
}

int sem_clockwait(sem_t *restrict semaphore, clockid_t clock, const struct timespec *restrict until);
REPLACES int sem_clockwait(sem_t *restrict semaphore, clockid_t clock, const struct timespec *restrict until)
{
    if (ect_inside > 0)
        return REAL(sem_clockwait)(semaphore, clock, until);
    return wait_timed(semaphore, clock, until);
}

REPLACES int sem_post(sem_t *semaphore)
{
    int result = REAL(sem_post)(semaphore);
    if (ect_inside == 0)
        (void)ect_virtual_wake(semaphore, 1);
    return result;
}

/* --- barriers ------------------------------------------------------------------------------------------------------
 */

/* Data of a barrier, because its count cannot be read. */
typedef struct barrier {
    struct barrier *next;
    const pthread_barrier_t *at;
    unsigned int count;
    unsigned int waiting;
    unsigned int inside; /* threads in pthread_barrier_wait() */
    unsigned int round;
} barrier_t;

static barrier_t *barriers; /* changed only by the thread with the turn */

static barrier_t **place_of(const pthread_barrier_t *barrier)
{
    barrier_t **at = &barriers;
    while (*at && (*at)->at != barrier)
        at = &(*at)->next;
    return at;
}

static bool is_of_one_process(const pthread_barrierattr_t *attributes)
{
    int shared = PTHREAD_PROCESS_PRIVATE;
    return !attributes ||
           (pthread_barrierattr_getpshared(attributes, &shared) == 0 && shared == PTHREAD_PROCESS_PRIVATE);
}

REPLACES int pthread_barrier_init(pthread_barrier_t *restrict barrier, const pthread_barrierattr_t *restrict attributes,
                                  unsigned int count)
{
    int error = REAL(pthread_barrier_init)(barrier, attributes, count);
    if (error != 0 || ect_inside > 0 || !is_of_one_process(attributes))
        return error;
    barrier_t *its = calloc(1, sizeof *its);
    if (!its)
        return ENOMEM;
    (void)ect_virtual_now(); /* takes the turn */
    *its = (barrier_t){.next = barriers, .at = barrier, .count = count};
    barriers = its;
    return 0;
}

REPLACES int pthread_barrier_destroy(pthread_barrier_t *barrier)
{
    if (ect_inside == 0)
        (void)ect_virtual_now();
    barrier_t **at = place_of(barrier);
    barrier_t *its = ect_inside > 0 ? NULL : *at;
    while (its && its->inside > 0)
        ect_virtual_yield();
    if (its) {
        at = place_of(barrier);
        *at = its->next;
        free(its);
    }
    return REAL(pthread_barrier_destroy)(barrier);
}

REPLACES int pthread_barrier_wait(pthread_barrier_t *barrier)
{
    if (ect_inside == 0)
        (void)ect_virtual_now();
    barrier_t *its = ect_inside > 0 ? NULL : *place_of(barrier);
    if (!its)
        return REAL(pthread_barrier_wait)(barrier);
    if (++its->waiting == its->count) {
        its->waiting = 0;
        its->round++;
        (void)ect_virtual_wake(its, UINT_MAX);
        return PTHREAD_BARRIER_SERIAL_THREAD;
    }
    unsigned int round = its->round;
    its->inside++;
    while (its->round == round)
        (void)ect_virtual_wait(its, UINT64_MAX);
    its->inside--;
    return 0;
}

/* --- futexes: the locks of Rust's standard library
 * -------------------------------------------------------------------- */

static long fail(int error)
{
    errno = error;
    return -1;
}

static long wait_futex(const int *word, int operation, int expected, const struct timespec *timeout)
{
    bool absolute = (operation & FUTEX_CMD_MASK) == FUTEX_WAIT_BITSET;
    clockid_t clock = (operation & FUTEX_CLOCK_REALTIME) != 0 ? CLOCK_REALTIME : CLOCK_MONOTONIC;
    struct timespec time;
    if (timeout && !ect_user_read(&time, timeout, sizeof time))
        return fail(EFAULT);
    if (timeout && !ect_is_time(&time))
        return fail(EINVAL);
    const struct timespec *limit = timeout ? &time : NULL;
    uint64_t until_ns = absolute && limit ? ect_deadline_on(clock, limit) : ect_deadline_in(limit);
    (void)ect_virtual_now(); /* takes the turn: no wake-up can be lost between this comparison and the wait */
    int present;             /* may be half of a change */
    if (!ect_user_read(&present, word, sizeof present))
        return fail(EFAULT);
    if (__atomic_load_n(word, __ATOMIC_SEQ_CST) != expected)
        return fail(EAGAIN);
    ect_wait_t result = ect_virtual_wait(word, until_ns);
    if (result == ECT_WAIT_WOKEN)
        return 0;
    return fail(result == ECT_WAIT_TIMED_OUT ? ETIMEDOUT : EINTR);
}

REPLACES long syscall(long number, ...)
{
    long a[6];
    va_list arguments;
    va_start(arguments, number);
    for (unsigned int i = 0; i < 6; i++)
        a[i] = va_arg(arguments, long);
    va_end(arguments);
    int command = number == SYS_futex && ect_inside == 0 ? (int)a[1] & FUTEX_CMD_MASK : -1;
    const int *word = (const int *)a[0];
    if (command == FUTEX_WAIT || command == FUTEX_WAIT_BITSET)
        return wait_futex(word, (int)a[1], (int)a[2], (const struct timespec *)a[3]);
    if (command == FUTEX_WAKE || command == FUTEX_WAKE_BITSET)
        return (long)ect_virtual_wake(word, (unsigned int)a[2]);
    return REAL(syscall)(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
