/* SPDX-License-Identifier: MIT */
/* Threads on the real clock: the dispatch is turned on in each thread. */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

#include "bus/inprocess/raw.h"
#include "bus/inprocess/real.h"

typedef struct created {
    void *(*start)(void *arg);
    void *arg;
} created_t;

static void *run_created(void *arg)
{
    const created_t its = *(created_t *)arg;
    free(arg);
    ect_raw_thread();
    return its.start(its.arg);
}

REPLACES int pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict attributes,
                            void *(*start)(void *arg), void *restrict arg)
{
    if (ect_inside > 0 || !ect_raw_is_on())
        return REAL(pthread_create)(thread, attributes, start, arg);
    created_t *its = malloc(sizeof *its);
    if (!its)
        return EAGAIN;
    *its = (created_t){.start = start, .arg = arg};
    int error = REAL(pthread_create)(thread, attributes, run_created, its);
    if (error != 0)
        free(its);
    return error;
}

bool ect_raw_on_clock(const ect_raw_call_t *call, long *result)
{
    (void)call;
    (void)result;
    return false;
}
