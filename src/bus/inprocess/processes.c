/* SPDX-License-Identifier: MIT */
/* Waits for child processes on the virtual clock, which is stopped meanwhile, so that a run does not depend on the
 * child's speed. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdint.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/threads.h"

typedef struct awaited {
    idtype_t kind;
    id_t id;
    int options;
    siginfo_t info;
    int result;
    int error;
} awaited_t;

static bool look(void *arg)
{
    awaited_t *its = arg;
    its->info.si_pid = 0;
    its->result = REAL(waitid)(its->kind, its->id, &its->info, its->options | WNOHANG | WNOWAIT);
    its->error = errno;
    return its->result != 0 || its->info.si_pid != 0;
}

/* Waits until the real call would not block. @return 0; -1 (EINTR): a signal handler has run before */
static int wait_for(idtype_t kind, id_t id, int options, const char *call)
{
    awaited_t its = {.kind = kind, .id = id, .options = options & (WEXITED | WSTOPPED | WCONTINUED)};
    if (ect_inside > 0 || !ect_bus_running() || look(&its))
        return 0;
    uint64_t until_ns = (options & WNOHANG) != 0 ? ect_virtual_now() + 1 : UINT64_MAX;
    if (ect_virtual_wait_for_process(look, &its, call, until_ns) != ECT_WAIT_INTERRUPTED || look(&its))
        return 0;
    errno = EINTR;
    return -1;
}

static int wait_for_pid(pid_t pid, int options, const char *call)
{
    idtype_t kind = pid > 0 ? P_PID : pid == -1 ? P_ALL : P_PGID;
    id_t id = (id_t)(pid > 0 ? pid : pid == -1 ? 0 : pid == 0 ? getpgrp() : -pid);
    int what = WEXITED | ((options & WUNTRACED) != 0 ? WSTOPPED : 0) | (options & (WCONTINUED | WNOHANG));
    return wait_for(kind, id, what, call);
}

REPLACES pid_t waitpid(pid_t pid, int *status, int options)
{
    return wait_for_pid(pid, options, "waitpid()") == 0 ? REAL(waitpid)(pid, status, options) : -1;
}

REPLACES pid_t wait4(pid_t pid, int *status, int options, struct rusage *usage)
{
    return wait_for_pid(pid, options, "wait4()") == 0 ? REAL(wait4)(pid, status, options, usage) : -1;
}

REPLACES pid_t wait(int *status)
{
    return wait_for_pid(-1, 0, "wait()") == 0 ? REAL(wait)(status) : -1;
}

REPLACES int waitid(idtype_t kind, id_t id, siginfo_t *info, int options)
{
    return wait_for(kind, id, options, "waitid()") == 0 ? REAL(waitid)(kind, id, info, options) : -1;
}
