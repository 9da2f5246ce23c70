/* SPDX-License-Identifier: MIT */
/* Syscall User Dispatch (Linux 5.11, x86-64): SIGSYS for each system call from outside the C library's text. */
#define _GNU_SOURCE
#include <errno.h>
#include <gnu/libc-version.h>
#include <link.h>
#include <linux/audit.h>
#include <linux/sched.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <ucontext.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/raw.h"
#include "bus/inprocess/raw_objects.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"

/* Constants missing from older headers. */
enum {
    DISPATCH = 59, /* PR_SET_SYSCALL_USER_DISPATCH */
    DISPATCH_ON = 1,
    GET_AUXV = 0x41555856, /* PR_GET_AUXV */
    BY_DISPATCH = 2,       /* SYS_USER_DISPATCH, a code of SIGSYS */
};
enum { ALLOW, BLOCK };    /* values of the selector */
enum { INSTRUCTION = 2 }; /* length of `syscall` */
enum { KERNEL_MASK = 8 }; /* length of a signal mask of the kernel */

/* The kernel's struct sigaction. */
typedef struct kernel_action {
    void (*handler)(int number, siginfo_t *info, void *context);
    unsigned long flags;
    void (*restorer)(void);
    uint64_t mask;
} kernel_action_t;

static volatile char selector = BLOCK;
static bool on;
static bool refused; /* the kernel or the C library does not support dispatch */
static ect_objects_t objects;
static ect_raw_route_t *route;
static ElfW(auxv_t) * vector;
static void (*restore)(void); /* `rt_sigreturn` in the C library's text */

bool ect_raw_is_on(void)
{
    return on;
}

long ect_raw_pass(const ect_raw_call_t *call)
{
    const long *a = call->a;
    long result = REAL(syscall)(call->number, a[0], a[1], a[2], a[3], a[4], a[5]);
    return ect_raw_result(result);
}

bool ect_raw_find(const ect_raw_entry_t *table, size_t count, const ect_raw_call_t *call, long *result)
{
    for (size_t i = 0; i < count; i++) {
        if (table[i].number == call->number) {
            *result = table[i].make(call->a);
            return true;
        }
    }
    return false;
}

void ect_raw_hide_vdso(ElfW(auxv_t) * entry)
{
    for (; ect_time_is_virtual && entry && entry->a_type != AT_NULL; entry++) {
        if (entry->a_type == AT_SYSINFO_EHDR)
            entry->a_type = AT_IGNORE;
    }
}

/* --- calls that concern the handler itself -------------------------------------------------------------------------
 */

/* Copies memory of the program by the kernel: these calls are also made where SIGSEGV is blocked, and by crash handlers
 * that try addresses. @return false: a bad address */
static bool copy_in(void *to, long from, size_t length)
{
    const struct iovec own = {.iov_base = to, .iov_len = length};
    const long its[] = {from, (long)length}; /* an iovec */
    const ect_raw_call_t copy = {.number = SYS_process_vm_readv, .a = {getpid(), (long)&own, 1, (long)its, 1, 0}};
    long copied = ect_raw_pass(&copy);
    bool refused_call = copied < 0 && copied != -EFAULT; /* by a sandbox */
    return refused_call ? ect_user_read(to, (const void *)from, length) : copied == (long)length;
}

/* Sets the mask in the context, which becomes the thread's mask when the handler returns. */
static long set_mask(const ect_raw_call_t *call, ucontext_t *at)
{
    ect_raw_call_t its = *call;
    uint64_t mask;
    if (call->a[1] && call->a[3] == KERNEL_MASK && copy_in(&mask, call->a[1], sizeof mask)) {
        mask = call->a[0] == SIG_UNBLOCK ? mask : ect_action_mask(mask);
        its.a[1] = (long)&mask;
    }
    long result = ect_raw_pass(&its);
    (void)REAL(syscall)(SYS_rt_sigprocmask, SIG_SETMASK, NULL, &at->uc_sigmask, KERNEL_MASK, 0, 0);
    return result;
}

static struct sigaction action_of(const kernel_action_t *from)
{
    struct sigaction to = {.sa_sigaction = from->handler, .sa_flags = (int)from->flags};
    memcpy(&to.sa_mask, &from->mask, sizeof from->mask);
    return to;
}

static long set_action(const ect_raw_call_t *call)
{
    kernel_action_t *before = (kernel_action_t *)call->a[2];
    kernel_action_t action;
    struct sigaction set, was;
    if (call->a[3] != KERNEL_MASK)
        return -EINVAL;
    if (call->a[1] && !copy_in(&action, call->a[1], sizeof action))
        return -EFAULT;
    if (call->a[1])
        set = action_of(&action);
    if (ect_action_set((int)call->a[0], call->a[1] ? &set : NULL, &was) != 0)
        return -errno;
    action = (kernel_action_t){.handler = was.sa_sigaction, .flags = (unsigned long)was.sa_flags};
    memcpy(&action.mask, &was.sa_mask, sizeof action.mask);
    return !before || ect_user_write(before, &action, sizeof action) ? 0 : -EFAULT;
}

/* rt_sigreturn by a restorer of the program: the signal frame is on the stack of the call. */
static _Noreturn void return_from_signal(const ucontext_t *at)
{
    __asm__ volatile("mov %0, %%rsp\n\tjmp *%1" : : "r"(at->uc_mcontext.gregs[REG_RSP]), "r"(restore) : "memory");
    __builtin_unreachable();
}

static long set_stack(const ect_raw_call_t *call, ucontext_t *at)
{
    long result = ect_raw_pass(call);
    (void)REAL(syscall)(SYS_sigaltstack, NULL, &at->uc_stack, 0, 0, 0, 0);
    return result;
}

static long control_process(const ect_raw_call_t *call)
{
    long result = ect_raw_pass(call);
    if (result > 0 && call->a[0] == GET_AUXV && (size_t)result <= (size_t)call->a[2])
        ect_raw_hide_vdso((ElfW(auxv_t) *)call->a[1]);
    return result;
}

/* Lets the program repeat the call without dispatch, because a child, or a thread without the C library's data, cannot
 * return from this handler. */
static long let_go(ucontext_t *at, bool of_system)
{
    static const char line[] =
        "ectwin: CMD makes threads without the C library; its direct system calls no longer reach the twins: run it "
        "without --in-process\n";
    if (!of_system)
        (void)!REAL(write)(STDERR_FILENO, line, sizeof line - 1);
    selector = ALLOW;
    at->uc_mcontext.gregs[REG_RIP] -= INSTRUCTION;
    return at->uc_mcontext.gregs[REG_RAX];
}

/* Executes fork() and clone(). @return the kernel's result; a child with a stack or memory of its own: see let_go() */
static long make_child(const ect_raw_call_t *call, ucontext_t *at, bool of_system)
{
    unsigned long flags = call->number == SYS_clone ? (unsigned long)call->a[0] : SIGCHLD;
    bool has_stack = call->number == SYS_clone && call->a[1] != 0;
    bool alone = (flags & CLONE_VM) == 0 || (flags & CLONE_VFORK) != 0;
    if (!has_stack && alone && (flags & ~(unsigned long)(CLONE_VM | CLONE_VFORK)) == SIGCHLD) {
        pid_t child = fork();
        return ect_raw_result(child);
    }
    return let_go(at, of_system);
}

static bool concerns_handler(long number)
{
    static const long numbers[] = {SYS_rt_sigprocmask, SYS_rt_sigaction, SYS_sigaltstack, SYS_prctl,     SYS_clone,
                                   SYS_clone3,         SYS_fork,         SYS_vfork,       SYS_arch_prctl};
    size_t i = 0;
    while (i < sizeof numbers / sizeof *numbers && numbers[i] != number)
        i++;
    return i < sizeof numbers / sizeof *numbers;
}

static long make_here(const ect_raw_call_t *call, ucontext_t *at, bool of_system)
{
    switch (call->number) {
    case SYS_rt_sigprocmask:
        return set_mask(call, at);
    case SYS_rt_sigaction:
        return set_action(call);
    case SYS_sigaltstack:
        return set_stack(call, at);
    case SYS_prctl:
        return control_process(call);
    case SYS_clone3:
        return -ENOSYS; /* as from an older kernel; the caller then uses clone() */
    case SYS_arch_prctl:
        return let_go(at, of_system); /* may change FS, the register of the C library's thread data */
    default:
        return make_child(call, at, of_system);
    }
}

/* --- the handler ---------------------------------------------------------------------------------------------------
 */

/* Not instrumented: AddressSanitizer may begin a function with mmap() (a frame for the detection of use after return,
 * default since GCC 13). This call is dispatched too, and would recurse endlessly. And rt_sigreturn leaves the function
 * by a jump: the guards around local variables of an instrumented function would stay. */
__attribute__((no_sanitize("address"))) static void on_call(int number, siginfo_t *info, void *context)
{
    ucontext_t *at = context;
    greg_t *registers = at->uc_mcontext.gregs;
    if (info->si_code != BY_DISPATCH) {
        ect_action_run(number, info, context);
        return;
    }
    int error = errno;
    bool of_system = ect_objects_pass(&objects, info->si_call_addr);
    const ect_raw_call_t call = {.number = registers[REG_RAX],
                                 .a = {registers[REG_RDI], registers[REG_RSI], registers[REG_RDX], registers[REG_R10],
                                       registers[REG_R8], registers[REG_R9]}};
    if (info->si_arch != AUDIT_ARCH_X86_64)
        registers[REG_RAX] = let_go(at, of_system);
    else if (call.number == SYS_rt_sigreturn)
        return_from_signal(at);
    else if (concerns_handler(call.number))
        registers[REG_RAX] = make_here(&call, at, of_system);
    else
        registers[REG_RAX] = of_system ? ect_raw_pass(&call) : route(&call);
    errno = error;
}

/* --- turning the dispatch on -------------------------------------------------------------------------------------- */

/* Before glibc 2.34 libpthread contains a part of the system calls. */
static bool library_is_known(void)
{
    long minor = strtol(strchr(gnu_get_libc_version(), '.') + 1, NULL, 10);
    return minor >= 34;
}

/* Uses the same function as the handler, so that the dynamic linker has resolved its symbols. */
static bool find_restorer(void)
{
    kernel_action_t action = {0};
    const ect_raw_call_t call = {.number = SYS_rt_sigaction, .a = {SIGSYS, 0, (long)&action, KERNEL_MASK}};
    if (ect_raw_pass(&call) != 0)
        return false;
    restore = action.restorer;
    return (uintptr_t)restore >= objects.c_library.begin && (uintptr_t)restore < objects.c_library.end;
}

static bool dispatch(void)
{
    return prctl(DISPATCH, DISPATCH_ON, objects.c_library.begin, objects.c_library.end - objects.c_library.begin,
                 &selector) == 0;
}

void ect_raw_thread(void)
{
    if (on)
        (void)dispatch();
}

static bool turn_on(void)
{
    if (!library_is_known() || objects.c_library.end == 0)
        return false;
    if (ect_action_take(SIGSYS, on_call, ECT_IN_CALL) != 0)
        return false;
    if (find_restorer() && dispatch())
        return true;
    ect_action_leave(SIGSYS);
    return false;
}

void ect_raw_scan(void)
{
    int error = errno;
    if (!on && !refused)
        ect_objects_search(&objects);
    if (objects.has_calls && !on && !refused) {
        on = turn_on();
        refused = !on;
        if (on)
            ect_raw_hide_vdso(vector);
    }
    errno = error;
}

void ect_raw_begin(ect_raw_route_t *its, int argc, char **argv)
{
    char **word = argv + argc + 1; /* the environment as written by the kernel */
    while (*word)
        word++;
    vector = (ElfW(auxv_t) *)(void *)(word + 1);
    route = its;
    (void)pthread_atfork(NULL, NULL, ect_raw_thread);
    ect_raw_scan();
}
