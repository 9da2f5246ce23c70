/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "inprocess_next.h"

#include <stddef.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>

#include "raw_call.h"

volatile sig_atomic_t next_is_searched;
volatile sig_atomic_t next_searches;
volatile sig_atomic_t next_clocks;

static time_t seconds(void)
{
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_REALTIME, &now);
    return now.tv_sec;
}

static pid_t by_wait4(pid_t pid, int *status, int options)
{
    return wait4(pid, status, options, NULL);
}

__attribute__((used)) static __typeof__(&waitpid) choose(void)
{
    next_is_searched = 1;
    next_searches++;
    (void)raise(SIGCHLD);
    (void)raw_call(SYS_getpid, 0, 0, 0, 0, 0, 0);
    time_t before = seconds();
    (void)raw_call(SYS_timerfd_gettime, -1, 0, 0, 0, 0, 0); /* the first of its kind: it is searched too */
    next_clocks += seconds() != before;
    next_is_searched = 0;
    return by_wait4;
}

pid_t waitpid(pid_t pid, int *status, int options) __attribute__((ifunc("choose")));
