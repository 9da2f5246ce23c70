/* SPDX-License-Identifier: MIT */
/* Threads, mutexes and conditions of C11 on the virtual clock. In glibc these are the objects of POSIX under other
 * names, and their functions do not call those that locks.c replaces. */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdlib.h>
#include <threads.h>
#include <time.h>

#include "bus/inprocess/real.h"

/* @return the result of C11 for an error number of POSIX */
static int result_of(int error)
{
    switch (error) {
    case 0:
        return thrd_success;
    case EBUSY:
        return thrd_busy;
    case ENOMEM:
        return thrd_nomem;
    case ETIMEDOUT:
        return thrd_timedout;
    default:
        return thrd_error;
    }
}

typedef struct created {
    thrd_start_t start;
    void *arg;
} created_t;

static void *run_created(void *arg)
{
    const created_t its = *(created_t *)arg;
    free(arg);
    return (void *)(intptr_t)its.start(its.arg);
}

REPLACES int thrd_create(thrd_t *thread, thrd_start_t start, void *arg)
{
    if (ect_inside > 0)
        return REAL(thrd_create)(thread, start, arg);
    created_t *its = malloc(sizeof *its);
    if (!its)
        return thrd_nomem;
    *its = (created_t){.start = start, .arg = arg};
    int error = pthread_create(thread, NULL, run_created, its);
    if (error != 0)
        free(its);
    return result_of(error);
}

REPLACES int thrd_join(thrd_t thread, int *result)
{
    void *its = NULL;
    int error = pthread_join(thread, &its);
    if (result)
        *result = (int)(intptr_t)its;
    return result_of(error);
}

REPLACES int thrd_sleep(const struct timespec *span, struct timespec *left)
{
    int error = clock_nanosleep(CLOCK_REALTIME, 0, span, left);
    return error == 0 ? 0 : error == EINTR ? -1 : -2;
}

REPLACES void thrd_yield(void)
{
    (void)sched_yield();
}

REPLACES int mtx_lock(mtx_t *mutex)
{
    return result_of(pthread_mutex_lock((pthread_mutex_t *)mutex));
}

REPLACES int mtx_timedlock(mtx_t *restrict mutex, const struct timespec *restrict until)
{
    return result_of(pthread_mutex_timedlock((pthread_mutex_t *)mutex, until));
}

REPLACES int mtx_unlock(mtx_t *mutex)
{
    return result_of(pthread_mutex_unlock((pthread_mutex_t *)mutex));
}

REPLACES int cnd_wait(cnd_t *condition, mtx_t *mutex)
{
    return result_of(pthread_cond_wait((pthread_cond_t *)condition, (pthread_mutex_t *)mutex));
}

REPLACES int cnd_timedwait(cnd_t *restrict condition, mtx_t *restrict mutex, const struct timespec *restrict until)
{
    return result_of(pthread_cond_timedwait((pthread_cond_t *)condition, (pthread_mutex_t *)mutex, until));
}

REPLACES int cnd_signal(cnd_t *condition)
{
    return result_of(pthread_cond_signal((pthread_cond_t *)condition));
}

REPLACES int cnd_broadcast(cnd_t *condition)
{
    return result_of(pthread_cond_broadcast((pthread_cond_t *)condition));
}
