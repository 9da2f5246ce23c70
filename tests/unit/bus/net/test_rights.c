/* SPDX-License-Identifier: MIT */
/* The rights of a process (bus/net/rights.h) with a kernel that is the test's: each step may fail. The real kernel is
 * in test_network.c and test_sandbox.c. */
#define _GNU_SOURCE
#include <linux/capability.h>
#include <sched.h>
#include <setjmp.h>
#include <stdint.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include "bus/net/rights.h"
#include "bus/net/sandbox.h"
#include "calls.h"

enum { STACK_EXPECTED = 500 * 1024 }; /* below the frame of a call after the lock */

static struct kernel {
    uint32_t permitted; /* the first 32 capabilities */
    uint64_t bounding;  /* those that are dropped */
    rlim_t locked;      /* the limit of locked memory */
    bool raises;        /* that limit may be raised */
} kernel;

/* --- calls -------------------------------------------------------------------------------------------------------- */

/* A sanitizer in the program calls some of them too, before the tests begin: other limits are the kernel's. */
int __wrap_prctl(int option, ...);
long __wrap_syscall(long number, ...);
int __wrap_ect_sandbox_enter(bool children, bool files, bool client);
int __wrap_sched_setscheduler(pid_t pid, int policy, const struct sched_param *parameters);
int __wrap_mlockall(int flags);
int __wrap_setrlimit(int resource, const struct rlimit *limit);
int __real_setrlimit(int resource, const struct rlimit *limit);
int __wrap_getrlimit(int resource, struct rlimit *limit);
int __real_getrlimit(int resource, struct rlimit *limit);

int __wrap_prctl(int option, ...)
{
    va_list arguments;
    va_start(arguments, option);
    const unsigned long first = option == PR_SET_NO_NEW_PRIVS ? (unsigned long)va_arg(arguments, int)
                                : option == PR_CAP_AMBIENT    ? (unsigned long)va_arg(arguments, int)
                                                              : va_arg(arguments, unsigned long);
    va_end(arguments);
    switch (option) {
    case PR_SET_NO_NEW_PRIVS:
        note("no_new_privs %lu\n", first);
        return fails("prctl") ? -1 : 0;
    case PR_CAPBSET_DROP:
        assert_true(first < 64);
        kernel.bounding |= UINT64_C(1) << first;
        return 0;
    default:
        assert_int_equal(option, PR_CAP_AMBIENT);
        assert_int_equal(first, PR_CAP_AMBIENT_CLEAR_ALL);
        note("no ambient ones\n");
        return 0;
    }
}

long __wrap_syscall(long number, ...)
{
    va_list arguments;
    va_start(arguments, number);
    const struct __user_cap_header_struct *header = va_arg(arguments, struct __user_cap_header_struct *);
    struct __user_cap_data_struct *data = va_arg(arguments, struct __user_cap_data_struct *);
    va_end(arguments);
    assert_int_equal(header->version, _LINUX_CAPABILITY_VERSION_3);
    assert_int_equal(header->pid, 0);
    if (number == SYS_capget) {
        data[0] = (struct __user_cap_data_struct){
            .effective = kernel.permitted, .permitted = kernel.permitted, .inheritable = kernel.permitted};
        data[1] = data[0];
        return fails("capget") ? -1 : 0;
    }
    assert_int_equal(number, SYS_capset);
    note("capabilities %x %x %x, %x %x %x\n", data[0].effective, data[0].permitted, data[0].inheritable,
         data[1].effective, data[1].permitted, data[1].inheritable);
    return fails("capset") ? -1 : 0;
}

int __wrap_ect_sandbox_enter(bool children, bool files, bool client)
{
    note("sandbox%s%s%s\n", children ? " children" : "", files ? " files" : "", client ? " client" : "");
    return fails("sandbox") ? -1 : 0;
}

int __wrap_sched_setscheduler(pid_t pid, int policy, const struct sched_param *parameters)
{
    assert_int_equal(pid, 0);
    assert_int_equal(policy, SCHED_FIFO | SCHED_RESET_ON_FORK);
    note("priority %d\n", parameters->sched_priority);
    return fails("scheduler") ? -1 : 0;
}

int __wrap_mlockall(int flags)
{
    /* Growth of the stack beyond the limit ends the process; mincore fails for pages that do not exist. */
    const uintptr_t below = ((uintptr_t)__builtin_frame_address(0) - STACK_EXPECTED) & ~(uintptr_t)4095;
    unsigned char resident = 0;
    assert_int_equal(mincore((void *)below, 4096, &resident), 0);
    assert_int_equal(resident & 1, 1);
    note("lock%s%s\n", (flags & MCL_CURRENT) != 0 ? " present" : "", (flags & MCL_FUTURE) != 0 ? " future" : "");
    return fails("mlockall") ? -1 : 0;
}

int __wrap_setrlimit(int resource, const struct rlimit *limit)
{
    if (resource != RLIMIT_MEMLOCK)
        return __real_setrlimit(resource, limit);
    assert_true(limit->rlim_cur == RLIM_INFINITY && limit->rlim_max == RLIM_INFINITY);
    if (kernel.raises)
        kernel.locked = limit->rlim_cur;
    return kernel.raises ? 0 : -1;
}

int __wrap_getrlimit(int resource, struct rlimit *limit)
{
    if (resource != RLIMIT_MEMLOCK)
        return __real_getrlimit(resource, limit);
    limit->rlim_cur = kernel.locked;
    return fails("getrlimit") ? -1 : 0;
}

/* --- tests -------------------------------------------------------------------------------------------------------- */

#define NONE  "capabilities 0 0 0, 0 0 0\n"
#define LINK  "capabilities 1000 1000 0, 0 0 0\n"
#define BEGIN "no_new_privs 1\nno ambient ones\n"
#define KEPT  "more rights than needed are kept: "

/* A step that fails is reported, and all others are done. */
static void giving_up(void **state)
{
    static const struct {
        const char *title;
        unsigned int keep;
        uint32_t permitted;
        failing_t failing;
        const char *message; /* NULL: done */
        const char *want;
    } rows[] = {
        {"all", 0, UINT32_MAX, {0}, NULL, BEGIN NONE "sandbox\n"},
        {"all but the link", ECT_RIGHTS_LINK, UINT32_MAX, {0}, NULL, BEGIN LINK "sandbox\n"},
        {"a link without the right to it", ECT_RIGHTS_LINK, 1u << CAP_NET_RAW, {0}, NULL, BEGIN NONE "sandbox\n"},
        {"children", ECT_RIGHTS_CHILDREN, 0, {0}, NULL, BEGIN NONE "sandbox children\n"},
        {"files", ECT_RIGHTS_FILES, 0, {0}, NULL, BEGIN NONE "sandbox files\n"},
        {"a client", ECT_RIGHTS_CLIENT, 0, {0}, NULL, BEGIN NONE "sandbox client\n"},
        {"no no_new_privs",
         0,
         1,
         {"prctl", FIRST, EINVAL},
         KEPT "no_new_privs failed (Invalid argument)",
         BEGIN NONE "sandbox\n"},
        {"capabilities unknown",
         0,
         1,
         {"capget", FIRST, EPERM},
         KEPT "giving up capabilities failed (Operation not permitted)",
         "no_new_privs 1\nsandbox\n"},
        {"capabilities kept",
         0,
         1,
         {"capset", FIRST, EPERM},
         KEPT "giving up capabilities failed (Operation not permitted)",
         BEGIN NONE "sandbox\n"},
        {"no filter",
         0,
         1,
         {"sandbox", FIRST, EINVAL},
         KEPT "the filter of system calls failed (Invalid argument)",
         BEGIN NONE "sandbox\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_RIGHTS_MESSAGE] = "";
        begin_calls(rows[i].failing);
        kernel = (struct kernel){.permitted = rows[i].permitted};
        int result = ect_rights_drop(rows[i].keep, message);
        EXPECT_LOG(rows[i].title, rows[i].want);
        if (result != (rows[i].message ? -1 : 0) || strcmp(message, rows[i].message ? rows[i].message : "") != 0)
            fail_msg("%s: expected '%s', got %d '%s'", rows[i].title, rows[i].message, result, message);
        if (strstr(rows[i].want, "ambient")) /* of children, too, each capability that there is */
            assert_true(kernel.bounding == (UINT64_C(2) << CAP_LAST_CAP) - 1);
    }
}

#define CURE                                                                                                           \
    ". Run it with sudo, or give the program its rights once and for all with 'sudo setcap "                           \
    "cap_net_raw,cap_net_admin,cap_sys_nice,cap_ipc_lock+ep $(realpath PATH/TO/ectwin)'"

/* Memory that comes later is locked only where that has no limit: at one, allocations would fail. */
static void realtime(void **state)
{
    static const struct {
        const char *title;
        struct kernel kernel;
        failing_t failing;
        const char *message; /* NULL: done */
        const char *want;
    } rows[] = {
        {"with the right to raise the limit", {.locked = 65536, .raises = true}, {0}, NULL, "lock present future\n"},
        {"without a limit", {.locked = RLIM_INFINITY}, {0}, NULL, "lock present future\n"},
        {"with a limit", {.locked = 65536}, {0}, NULL, "lock present\n"},
        {"with an unknown limit", {.locked = RLIM_INFINITY}, {"getrlimit", FIRST, EPERM}, NULL, "lock present\n"},
        {"without the right to the priority",
         {.locked = 0},
         {"scheduler", FIRST, EPERM},
         "--realtime 42 lacks a right: CAP_SYS_NICE, or a sufficient limit of real-time priority ('ulimit -r')" CURE,
         ""},
        {"with too low a limit",
         {.locked = 65536},
         {"mlockall", FIRST, ENOMEM},
         "--realtime 42 lacks a right: CAP_IPC_LOCK, or unlimited locked memory ('ulimit -l unlimited')" CURE,
         "lock present\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_RIGHTS_MESSAGE] = "", want[64];
        begin_calls(rows[i].failing);
        kernel = rows[i].kernel;
        int result = ect_rights_realtime(42, message);
        snprintf(want, sizeof want, "priority 42\n%s", rows[i].want);
        EXPECT_LOG(rows[i].title, want);
        if (result != (rows[i].message ? -1 : 0) || strcmp(message, rows[i].message ? rows[i].message : "") != 0)
            fail_msg("%s: expected '%s', got %d '%s'", rows[i].title, rows[i].message, result, message);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"each right is dropped except the right to keep; a step that fails is named and stops no other", giving_up,
         NULL, NULL, NULL},
        {"real-time priority locks memory as far as the limit allows; a missing right is named with its cure", realtime,
         NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("rights", tests, NULL, NULL);
}
