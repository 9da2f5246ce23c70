/* SPDX-License-Identifier: MIT */
/* The handler of direct system calls, with signals and a kernel that are the test's. */
#define _GNU_SOURCE
#include <linux/audit.h>
#include <linux/sched.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <ucontext.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/raw.h"
#include "bus/inprocess/raw_objects.h"
#include "fakes.h"

/* Of bus/inprocess/time.h, where it is constant: this test runs on both clocks. */
extern bool ect_time_is_virtual;
bool ect_time_is_virtual = true;

enum { DISPATCH = 59, GET_AUXV = 0x41555856, BY_DISPATCH = 2, KERNEL_MASK = 8, UNREADABLE = 99, PID = 55 };

/* The kernel's struct sigaction. */
typedef struct action {
    void *handler;
    unsigned long flags;
    void *restorer;
    uint64_t mask;
} action_t;

/* The texts of objects that the test has loaded. */
enum { LIBRARY = 1000, LIBRARY_END = 2000, LINKER = 3000, LINKER_END = 4000 };

static ect_objects_t loaded;
static void (*handler)(int number, siginfo_t *info, void *context);
static void (*in_child)(void);
static volatile char *selector; /* of the dispatch */
static const char *version = "2.36";
static action_t kernel_action; /* of any signal */
static struct sigaction own;   /* the program's action of SIGSYS */
static uint64_t mask_given;    /* to the newest call with a mask */
static action_t action_given;  /* to the newest SYS_rt_sigaction */

/* --- fakes
 * ------------------------------------------------------------------------------------------------------------ */

/* Copies memory as process_vm_readv() does. @return its result */
static long read_memory(const long *a)
{
    struct iovec to, from;
    memcpy(&to, (const void *)a[1], sizeof to);
    memcpy(&from, (const void *)a[3], sizeof from);
    assert_int_equal(a[0], PID);
    assert_int_equal(a[2] + a[4], 2);
    assert_int_equal(a[5], 0);
    assert_int_equal(to.iov_len, from.iov_len);
    long result = CALLED(copy, (long)to.iov_len);
    if (result == 0 && (long)from.iov_base == UNREADABLE) {
        errno = EFAULT;
        return -1;
    }
    if (result == 0)
        memcpy(to.iov_base, from.iov_base, to.iov_len);
    return result == 0 ? (long)to.iov_len : result;
}

static long change_action(const long *a)
{
    assert_int_equal(a[3], KERNEL_MASK);
    if (a[1] != 0 && a[1] != UNREADABLE)
        memcpy(&action_given, (const void *)a[1], sizeof action_given);
    if (a[2] != 0 && a[2] != UNREADABLE)
        memcpy((void *)a[2], &kernel_action, sizeof kernel_action);
    return CALLED(rt_sigaction, a[0], a[1] == UNREADABLE ? UNREADABLE : a[1] != 0,
                  a[2] == UNREADABLE ? UNREADABLE : a[2] != 0);
}

static long change_mask(const long *a)
{
    uint64_t mask;
    if (a[1] != 0 && a[1] != UNREADABLE)
        memcpy(&mask_given, (const void *)a[1], sizeof mask_given);
    if (a[2] != 0) {
        mask = 0x77;
        memcpy((void *)a[2], &mask, sizeof mask);
    }
    return CALLED(rt_sigprocmask, a[0], a[1] == UNREADABLE ? UNREADABLE : a[1] != 0, a[2] != 0, a[3]);
}

static long fake_syscall(long number, ...)
{
    long a[6];
    va_list arguments;
    va_start(arguments, number);
    for (size_t i = 0; i < 6; i++)
        a[i] = va_arg(arguments, long);
    va_end(arguments);
    switch (number) {
    case SYS_process_vm_readv:
        return read_memory(a);
    case SYS_rt_sigaction:
        return change_action(a);
    case SYS_rt_sigprocmask:
        return change_mask(a);
    case SYS_sigaltstack:
        if (a[1] != 0)
            ((stack_t *)a[1])->ss_size = 4321;
        return CALLED(sigaltstack, a[0], a[1] != 0);
    default:
        return fake_call("syscall", (const long[]){number, a[0], a[1], a[2], a[3], a[4], a[5]}, 7);
    }
}

static ssize_t fake_write(int fd, const void *data, size_t size)
{
    static const char begin[] = "ectwin: CMD makes threads without the C library";
    assert_memory_equal(data, begin, sizeof begin - 1);
    assert_int_equal(((const char *)data)[size - 1], '\n');
    CALLED(write, fd);
    return (ssize_t)size;
}

FAKES(FAKE(syscall), FAKE(write))

int fake_prctl(int option, long how, long begin, long length, volatile char *its)
{
    selector = its;
    return (int)CALLED(prctl, option, how, begin, length, *its);
}

const char *fake_gnu_get_libc_version(void)
{
    return version;
}

int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void))
{
    in_child = !prepare && !parent ? child : NULL;
    return 0;
}

int fake_getpid(void)
{
    return PID;
}

int fake_fork(void)
{
    return (int)CALLED(fork);
}

void ect_objects_search(ect_objects_t *its)
{
    *its = loaded;
    CALLED(search);
    errno = ENOENT;
}

bool ect_objects_pass(const ect_objects_t *its, const void *address)
{
    (void)its;
    return (uintptr_t)address >= LINKER && (uintptr_t)address < LINKER_END;
}

int ect_action_take(int number, ect_action_t *its, ect_manner_t manner)
{
    assert_int_equal(number, SIGSYS);
    assert_int_equal(manner, ECT_IN_CALL);
    handler = its;
    return (int)CALLED(take);
}

void ect_action_leave(int number)
{
    assert_int_equal(number, SIGSYS);
    CALLED(leave);
}

void ect_action_run(int number, siginfo_t *info, void *context)
{
    CALLED(own_signal, number, info->si_code, context != NULL);
}

int ect_action_set(int number, const struct sigaction *action, struct sigaction *before)
{
    *before = own;
    if (action)
        own = *action;
    return (int)CALLED(set, number, action != NULL);
}

/* No thread may block the highest signal of this test. */
uint64_t ect_action_mask(uint64_t mask)
{
    return mask & ~0x100ull;
}

static long route(const ect_raw_call_t *call)
{
    const long *a = call->a;
    errno = EDOM;
    return fake_call("route", (const long[]){call->number, a[0], a[1], a[2], a[3], a[4], a[5]}, 7);
}

/* --- the process
 * ------------------------------------------------------------------------------------------------------ */

/* A process as the kernel starts it: arguments, environment, auxiliary vector. */
static struct process {
    char *words[5];
    ElfW(auxv_t) vector[3];
} process = {.words = {(char *)"program", NULL, (char *)"A=1", (char *)"B=2", NULL},
             .vector = {{.a_type = AT_SYSINFO_EHDR}, {.a_type = AT_PAGESZ}, {.a_type = AT_NULL}}};

/* Each test begins with a process without direct system calls, or, behind the first ones, with the dispatch on. */
static int begin_off(void **state)
{
    own = (struct sigaction){0};
    ect_time_is_virtual = true;
    loaded = (ect_objects_t){.c_library = {LIBRARY, LIBRARY_END}};
    kernel_action.restorer = (void *)LIBRARY;
    return begin_fakes(state);
}

static int begin(void **state)
{
    (void)begin_off(state);
    if (!ect_raw_is_on()) {
        loaded.has_calls = true;
        ect_raw_begin(route, 1, process.words);
    }
    return begin_fakes(state);
}

static void stays_off_without_calls(void **state)
{
    (void)state;
    errno = 0;
    ect_raw_begin(route, 1, process.words);
    assert_int_equal(errno, 0);
    assert_false(ect_raw_is_on());
    ect_raw_thread();
    assert_non_null(in_child);
    EXPECT_CALLS("no calls", "search() ");
    ect_raw_scan();
    EXPECT_CALLS("again", "search() ");
    assert_int_equal(process.vector[0].a_type, AT_SYSINFO_EHDR);
}

/* Runs in a child, for a refusal lasts as long as the process. @return whether the dispatch stays off with these calls
 */
static bool is_refused(const char *want)
{
    int status = -1;
    pid_t child = fork();
    if (child == 0) {
        loaded.has_calls = true;
        ect_raw_begin(route, 1, process.words);
        bool once = strcmp(fakes.log, want) == 0;
        ect_raw_scan();
        bool off = !ect_raw_is_on() && process.vector[0].a_type == AT_SYSINFO_EHDR;
        _exit(once && off && strcmp(fakes.log, want) == 0 ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    forget_calls();
    return status == 0;
}

static void is_refused_by_old_systems(void **state)
{
    (void)state;
    version = "2.33";
    assert_true(is_refused("search() "));
    version = "2.34";
    assert_false(is_refused("search() "));
    version = "2.36";
    loaded.c_library.end = 0;
    assert_true(is_refused("search() "));
    loaded.c_library.end = LIBRARY_END;
    plan("take", -1, EINVAL);
    assert_true(is_refused("search() take() "));
    plan("rt_sigaction", -1, EINVAL);
    assert_true(is_refused("search() take() rt_sigaction(31,0,1) leave() "));
    kernel_action.restorer = AT(LIBRARY - 1);
    assert_true(is_refused("search() take() rt_sigaction(31,0,1) leave() "));
    kernel_action.restorer = AT(LIBRARY_END);
    assert_true(is_refused("search() take() rt_sigaction(31,0,1) leave() "));
    kernel_action.restorer = AT(LIBRARY_END - 1);
    plan("prctl", -1, EINVAL);
    assert_true(is_refused("search() take() rt_sigaction(31,0,1) prctl(59,1,1000,1000,1) leave() "));
}

static void turns_on(void **state)
{
    (void)state;
    loaded.has_calls = true;
    ect_raw_begin(route, 1, process.words);
    assert_true(ect_raw_is_on());
    EXPECT_CALLS("on", "search() take() rt_sigaction(31,0,1) prctl(59,1,1000,1000,1) ");
    assert_int_equal(process.vector[0].a_type, AT_IGNORE);
    assert_int_equal(process.vector[1].a_type, AT_PAGESZ);
    ect_raw_scan();
    EXPECT_CALLS("once", "");
    ect_raw_thread();
    in_child();
    EXPECT_CALLS("each thread and child", "prctl(59,1,1000,1000,1) prctl(59,1,1000,1000,1) ");
}

static void hides_the_vdso_on_the_virtual_clock(void **state)
{
    ElfW(auxv_t) vector[] = {
        {.a_type = AT_PAGESZ}, {.a_type = AT_SYSINFO_EHDR}, {.a_type = AT_NULL}, {.a_type = AT_SYSINFO_EHDR}};
    (void)state;
    ect_raw_hide_vdso(NULL);
    ect_time_is_virtual = false;
    ect_raw_hide_vdso(vector);
    assert_int_equal(vector[1].a_type, AT_SYSINFO_EHDR);
    ect_time_is_virtual = true;
    ect_raw_hide_vdso(vector);
    assert_int_equal(vector[0].a_type, AT_PAGESZ);
    assert_int_equal(vector[1].a_type, AT_IGNORE);
    assert_int_equal(vector[3].a_type, AT_SYSINFO_EHDR);
}

/* --- calls
 * ------------------------------------------------------------------------------------------------------------ */

static ucontext_t context;

/* A direct system call at address 500, of the program. @return the value of RAX */
static long dispatch_from(uintptr_t address, long number, const long *a)
{
    siginfo_t info = {.si_code = BY_DISPATCH};
    greg_t *registers = context.uc_mcontext.gregs;
    info.si_call_addr = (void *)address;
    info.si_arch = AUDIT_ARCH_X86_64;
    memset(&context, 0, sizeof context);
    registers[REG_RIP] = (greg_t)address;
    registers[REG_RAX] = number;
    registers[REG_RDI] = a[0];
    registers[REG_RSI] = a[1];
    registers[REG_RDX] = a[2];
    registers[REG_R10] = a[3];
    registers[REG_R8] = a[4];
    registers[REG_R9] = a[5];
    errno = ENOTTY;
    handler(SIGSYS, &info, &context);
    assert_int_equal(errno, ENOTTY);
    return registers[REG_RAX];
}

static long dispatched(long number, long a, long b, long c, long d)
{
    const long all[] = {a, b, c, d, 15, 16};
    return dispatch_from(500, number, all);
}

static void routes_calls(void **state)
{
    static const long a[] = {11, 12, 13, 14, 15, 16};
    siginfo_t info = {.si_code = SI_TKILL};
    (void)state;
    plan("route", 42, 0);
    assert_int_equal(dispatch_from(500, SYS_getpid, a), 42);
    EXPECT_CALLS("of the program", "route(39,11,12,13,14,15,16) ");
    plan("syscall", -1, ESRCH);
    assert_int_equal(dispatch_from(LINKER, SYS_getpid, a), -ESRCH);
    EXPECT_CALLS("of the system", "syscall(39,11,12,13,14,15,16) ");
    handler(SIGSYS, &info, &context);
    EXPECT_CALLS("another SIGSYS", "own_signal(31,-6,1) ");
}

static void finds_functions(void **state)
{
    static const ect_raw_entry_t none[] = {{SYS_getpid, NULL}};
    const ect_raw_call_t call = {.number = SYS_getppid};
    long result = 5;
    (void)state;
    assert_false(ect_raw_find(none, 1, &call, &result));
    assert_int_equal(result, 5);
}

static void sets_masks_without_the_signal(void **state)
{
    static const int hows[] = {SIG_BLOCK, SIG_SETMASK, SIG_UNBLOCK};
    const uint64_t mask = 0x101;
    uint64_t after;
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        char want[96];
        plan("rt_sigprocmask", 0, 0);
        assert_int_equal(dispatched(SYS_rt_sigprocmask, hows[i], (long)&mask, 0, KERNEL_MASK), 0);
        snprintf(want, sizeof want, "copy(8) rt_sigprocmask(%d,1,0,8) rt_sigprocmask(%d,0,1,8) ", hows[i], SIG_SETMASK);
        EXPECT_CALLS("a mask", want);
        memcpy(&after, &context.uc_sigmask, sizeof after);
        assert_int_equal(after, 0x77); /* the mask after the handler */
    }
}

static void blocks_other_signals(void **state)
{
    const uint64_t mask = 0x101;
    static const struct {
        int how;
        long length;
        uint64_t given;
    } rows[] = {{SIG_BLOCK, KERNEL_MASK, 1}, {SIG_UNBLOCK, KERNEL_MASK, 0x101}, {SIG_BLOCK, 16, 0x101}};
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        const long a[] = {rows[i].how, (long)&mask, 0, rows[i].length, 0, 0};
        mask_given = 0;
        (void)dispatch_from(500, SYS_rt_sigprocmask, a);
        assert_int_equal(mask_given, rows[i].given);
        forget_calls();
    }
    plan("rt_sigprocmask", -1, EFAULT);
    assert_int_equal(dispatched(SYS_rt_sigprocmask, SIG_BLOCK, UNREADABLE, 0, KERNEL_MASK), -EFAULT);
    EXPECT_CALLS("a bad address", "copy(8) rt_sigprocmask(0,99,0,8) rt_sigprocmask(2,0,1,8) ");
    (void)dispatched(SYS_rt_sigprocmask, SIG_BLOCK, 0, 0, KERNEL_MASK);
    EXPECT_CALLS("a question", "rt_sigprocmask(0,0,0,8) rt_sigprocmask(2,0,1,8) ");
}

static void sets_actions(void **state)
{
    const action_t action = {.handler = (void *)1, .flags = SA_NODEFER, .mask = 0x101};
    action_t before = {.mask = 5};
    (void)state;
    own.sa_flags = SA_RESTART;
    own.sa_handler = SIG_IGN;
    sigaddset(&own.sa_mask, 3);
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSYS, (long)&action, (long)&before, KERNEL_MASK), 0);
    EXPECT_CALLS("an action", "copy(32) set(31,1) ");
    assert_int_equal(before.flags, SA_RESTART);
    assert_ptr_equal(before.handler, (void *)SIG_IGN);
    assert_int_equal(before.mask, 4);
    assert_int_equal(own.sa_flags, SA_NODEFER);
    assert_ptr_equal((void *)own.sa_handler, action.handler);
    assert_int_equal(sigismember(&own.sa_mask, 1) + sigismember(&own.sa_mask, 9), 2);
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSEGV, 0, (long)&before, KERNEL_MASK), 0);
    EXPECT_CALLS("a question", "set(11,0) ");
    assert_int_equal(before.flags, SA_NODEFER);
    assert_int_equal(before.mask, 0x101);
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSYS, (long)&action, 0, KERNEL_MASK), 0);
    EXPECT_CALLS("no answer", "copy(32) set(31,1) ");
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSYS, UNREADABLE, 0, KERNEL_MASK), -EFAULT);
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSYS, (long)&action, 0, KERNEL_MASK + 8), -EINVAL);
    EXPECT_CALLS("a bad address, a mask of another length", "copy(32) ");
    plan("copy", -1, EPERM);
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSYS, (long)&action, 0, KERNEL_MASK), 0);
    EXPECT_CALLS("a sandbox", "copy(32) set(31,1) ");
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGSYS, (long)&action, UNREADABLE, KERNEL_MASK), -EFAULT);
    EXPECT_CALLS("a bad answer", "copy(32) set(31,1) ");
    plan("set", -1, EINVAL);
    assert_int_equal(dispatched(SYS_rt_sigaction, SIGKILL, (long)&action, 0, KERNEL_MASK), -EINVAL);
    EXPECT_CALLS("a signal that cannot be handled", "copy(32) set(9,1) ");
}

/* A signal stack is part of the context that the handler returns to. */
static void sets_the_stack(void **state)
{
    (void)state;
    plan("sigaltstack", -1, EPERM);
    assert_int_equal(dispatched(SYS_sigaltstack, 8, 0, 0, 0), -EPERM);
    assert_int_equal(context.uc_stack.ss_size, 4321);
    EXPECT_CALLS("a stack", "sigaltstack(8,0) sigaltstack(0,1) ");
}

static void hides_the_vdso_from_prctl(void **state)
{
    static const struct {
        long option, result, length;
        bool hides;
    } rows[] = {{GET_AUXV, 32, 32, true},
                {GET_AUXV, 1, 32, true},
                {GET_AUXV, 33, 32, false},
                {GET_AUXV, 0, 32, false},
                {GET_AUXV + 1, 32, 32, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ElfW(auxv_t) vector[] = {{.a_type = AT_SYSINFO_EHDR}, {.a_type = AT_NULL}};
        plan("syscall", rows[i].result, 0);
        assert_int_equal(dispatched(SYS_prctl, rows[i].option, (long)vector, rows[i].length, 0), rows[i].result);
        assert_int_equal(vector[0].a_type, rows[i].hides ? AT_IGNORE : AT_SYSINFO_EHDR);
        forget_calls();
    }
}

/* --- threads and processes
 * -------------------------------------------------------------------------------------------- */

/* @return whether the call is made again without dispatch */
static bool lets_go(uintptr_t address, long number, long flags, long stack)
{
    const long a[] = {flags, stack, 0, 0, 0, 0};
    *selector = 1;
    long result = dispatch_from(address, number, a);
    if (*selector != 0)
        return false;
    assert_int_equal(result, number);
    assert_int_equal(context.uc_mcontext.gregs[REG_RIP], (greg_t)address - 2);
    return true;
}

static void makes_children(void **state)
{
    (void)state;
    static const struct {
        long number, flags, stack;
        bool forks;
    } rows[] = {{SYS_fork, 11, 12, true},
                {SYS_vfork, 11, 12, true},
                {SYS_clone, SIGCHLD, 0, true},
                {SYS_clone, CLONE_VM | CLONE_VFORK | SIGCHLD, 0, true},
                {SYS_clone, CLONE_VM | SIGCHLD, 0, false},
                {SYS_clone, CLONE_VFORK | SIGCHLD, 0, true},
                {SYS_clone, SIGCHLD, 1, false},
                {SYS_clone, 0, 0, false},
                {SYS_clone, CLONE_FS | SIGCHLD, 0, false}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].forks)
            plan("fork", 66, 0);
        assert_int_equal(lets_go(500, rows[i].number, rows[i].flags, rows[i].stack), !rows[i].forks);
        assert_int_equal(context.uc_mcontext.gregs[REG_RAX], rows[i].forks ? 66 : rows[i].number);
        EXPECT_CALLS("a child", rows[i].forks ? "fork() " : "write(2) ");
    }
    plan("fork", -1, EAGAIN);
    assert_int_equal(dispatched(SYS_fork, 0, 0, 0, 0), -EAGAIN);
    assert_int_equal(dispatched(SYS_clone3, 0, 0, 0, 0), -ENOSYS);
    forget_calls();
}

static void lets_go_of_others(void **state)
{
    siginfo_t info = {.si_code = BY_DISPATCH};
    (void)state;
    assert_true(lets_go(500, SYS_arch_prctl, 0, 0));
    EXPECT_CALLS("of the program", "write(2) ");
    assert_true(lets_go(LINKER, SYS_clone, 0, 1));
    EXPECT_CALLS("of the system", "");
    *selector = 1;
    info.si_arch = AUDIT_ARCH_X86_64 + 1; /* the calls of 32 bits have other numbers */
    info.si_call_addr = AT(500);
    context.uc_mcontext.gregs[REG_RAX] = SYS_getpid;
    handler(SIGSYS, &info, &context);
    assert_int_equal(*selector, 0);
    assert_int_equal(context.uc_mcontext.gregs[REG_RAX], SYS_getpid);
    EXPECT_CALLS("another architecture", "write(2) ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A process without direct system calls has no dispatch", stays_off_without_calls, begin_off, NULL, NULL},
        {"A kernel or a C library that is too old has no dispatch", is_refused_by_old_systems, begin_off, NULL, NULL},
        {"A direct system call turns the dispatch on, once for each thread", turns_on, begin_off, NULL, NULL},
        {"The vDSO is hidden on the virtual clock", hides_the_vdso_on_the_virtual_clock, begin, NULL, NULL},
        {"A call of the program goes its route, one of the system to the kernel", routes_calls, begin, NULL, NULL},
        {"A call without a function is none of the table", finds_functions, begin, NULL, NULL},
        {"A mask of signals is that of the thread after the handler", sets_masks_without_the_signal, begin, NULL, NULL},
        {"A mask of signals never blocks SIGSYS", blocks_other_signals, begin, NULL, NULL},
        {"Actions are set as by sigaction()", sets_actions, begin, NULL, NULL},
        {"The signal stack is that of the thread after the handler", sets_the_stack, begin, NULL, NULL},
        {"The auxiliary vector of prctl() has no vDSO", hides_the_vdso_from_prctl, begin, NULL, NULL},
        {"A child of fork() is made by the C library, others are let go", makes_children, begin, NULL, NULL},
        {"Calls that the library cannot make are let go", lets_go_of_others, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
