/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/rights.h"

#include <errno.h>
#include <linux/capability.h>
#include <sched.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "bus/net/sandbox.h"

enum { STACK = 512 * 1024, STACK_STEP = 4096 };

static bool drop_capabilities(unsigned int keep)
{
    struct __user_cap_header_struct header = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3] = {{0}};
    if (syscall(SYS_capget, &header, data) < 0)
        return false;
    for (unsigned long capability = 0; capability <= CAP_LAST_CAP; capability++)
        (void)prctl(PR_CAPBSET_DROP, capability, 0, 0, 0); /* no effect, and no need, without CAP_SETPCAP */
    (void)prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
    uint32_t kept = (keep & ECT_RIGHTS_LINK) != 0 ? data[0].permitted & (1u << CAP_NET_ADMIN) : 0u;
    memset(data, 0, sizeof data);
    data[0].permitted = kept;
    data[0].effective = kept;
    return syscall(SYS_capset, &header, data) == 0;
}

int ect_rights_drop(unsigned int keep, char *message)
{
    const char *step = NULL;
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0)
        step = "no_new_privs";
    if (!drop_capabilities(keep))
        step = "giving up capabilities";
    if (ect_sandbox_enter((keep & ECT_RIGHTS_CHILDREN) != 0, (keep & ECT_RIGHTS_FILES) != 0,
                          (keep & ECT_RIGHTS_CLIENT) != 0) < 0)
        step = "the filter of system calls";
    if (!step)
        return 0;
    snprintf(message, ECT_RIGHTS_MESSAGE, "more rights than needed are kept: %s failed (%s)", step, strerror(errno));
    return -1;
}

/* The stack grows in locked memory: beyond the limit its growth ends the process. Pages for later calls are touched
 * here. */
static void __attribute__((noinline)) grow_stack(void)
{
    volatile char stack[STACK];
    for (size_t at = sizeof stack; at > 0; at -= STACK_STEP)
        stack[at - 1] = 0;
}

/* Locks the present memory, and later allocations only without a limit of locked memory: at the limit they would fail.
 */
static bool lock_memory(void)
{
    struct rlimit limit = {.rlim_cur = RLIM_INFINITY, .rlim_max = RLIM_INFINITY};
    (void)setrlimit(RLIMIT_MEMLOCK, &limit);
    grow_stack();
    bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
    return mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0;
}

int ect_rights_realtime(int priority, char *message)
{
    const struct sched_param parameters = {.sched_priority = priority};
    const char *missing = NULL;
    if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) < 0)
        missing = "CAP_SYS_NICE, or a sufficient limit of real-time priority ('ulimit -r')";
    else if (!lock_memory())
        missing = "CAP_IPC_LOCK, or unlimited locked memory ('ulimit -l unlimited')";
    if (!missing)
        return 0;
    snprintf(message, ECT_RIGHTS_MESSAGE,
             "--realtime %d lacks a right: %s. Run it with sudo, or give the program its rights once and for all with "
             "'sudo setcap cap_net_raw,cap_net_admin,cap_sys_nice,cap_ipc_lock+ep $(realpath PATH/TO/ectwin)'",
             priority, missing);
    return -1;
}
