/* SPDX-License-Identifier: MIT */
/*
 * A program that makes system calls itself keeps its signals, stacks, children and memory while the twins see its
 * calls. usage: ectwin with --in-process [--virtual-time] fzm1 -- inprocess_dispatch real|virtual [CASE]
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* CMocka needs the headers above. */
#include <cmocka.h>

#include "raw_call.h"

enum { KERNEL_MASK = 8, GET_AUXV = 0x41555856 };

static bool is_virtual;

static uint64_t raw_clock(void)
{
    struct timespec time = {0};
    (void)raw_call(SYS_clock_gettime, CLOCK_MONOTONIC, (long)&time, 0, 0, 0, 0);
    return (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec;
}

/* Whether calls are dispatched: a read of the virtual clock costs exactly 50 ns. */
static void assert_dispatched(void)
{
    uint64_t first = raw_clock();
    if (is_virtual)
        assert_int_equal(raw_clock() - first, 50);
    assert_int_equal(raw_call(SYS_getpid, 0, 0, 0, 0, 0, 0), getpid());
}

/* --- results -------------------------------------------------------------------------------------------------------
 */

static void results_are_those_of_the_kernel(void **state)
{
    (void)state;
    errno = ERANGE;
    assert_int_equal(raw_call(SYS_close, -1, 0, 0, 0, 0, 0), -EBADF);
    assert_int_equal(
        raw_call(SYS_clock_nanosleep, CLOCK_MONOTONIC, 0, (long)&(struct timespec){.tv_nsec = -1}, 0, 0, 0), -EINVAL);
    assert_int_equal(raw_call(100000, 0, 0, 0, 0, 0, 0), -ENOSYS);
    assert_int_equal(errno, ERANGE);
    long page = raw_call(SYS_mmap, 0, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(page > 0);
    *(volatile char *)page = 1;
    assert_int_equal(raw_call(SYS_munmap, page, 4096, 0, 0, 0, 0), 0);
    assert_dispatched();
}

static void a_path_at_a_bad_address_is_refused(void **state)
{
    static const struct {
        long number, a[4];
    } calls[] = {{SYS_open, {1, O_RDONLY}},
                 {SYS_openat, {AT_FDCWD, 1, O_RDONLY}},
                 {SYS_newfstatat, {AT_FDCWD, 1}},
                 {SYS_readlinkat, {AT_FDCWD, 1}}};
    char room[256];
    (void)state;
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        const long *a = calls[i].a;
        bool reads = i < 2;
        assert_int_equal(raw_call(calls[i].number, a[0], a[1], reads ? a[2] : (long)room, sizeof room, 0, 0), -EFAULT);
    }
    assert_dispatched();
}

static void a_mask_at_a_bad_address_is_refused(void **state)
{
    static const long bad_pair[] = {1, KERNEL_MASK};
    const struct {
        long number, a[6];
    } calls[] = {{SYS_rt_sigprocmask, {SIG_BLOCK, 1, 0, KERNEL_MASK}},
                 {SYS_rt_sigaction, {SIGUSR1, 1, 0, KERNEL_MASK}},
                 {SYS_ppoll, {0, 0, 0, 1, KERNEL_MASK}},
                 {SYS_pselect6, {0, 0, 0, 0, 0, 1}},
                 {SYS_pselect6, {0, 0, 0, 0, 0, (long)bad_pair}},
                 {SYS_rt_sigsuspend, {1, KERNEL_MASK}},
                 {SYS_rt_sigtimedwait, {1, 0, 0, KERNEL_MASK}},
                 {SYS_rt_sigaction, {SIGSYS, 1, 0, KERNEL_MASK}},
                 {SYS_rt_sigaction, {SIGSYS, 0, 1, KERNEL_MASK}}};
    (void)state;
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        const long *a = calls[i].a;
        assert_int_equal(raw_call(calls[i].number, a[0], a[1], a[2], a[3], a[4], a[5]), -EFAULT);
    }
    assert_dispatched();
}

static void a_time_or_a_set_at_a_bad_address_is_refused(void **state)
{
    static const uint64_t none;
    const struct {
        long number, a[6];
    } calls[] = {{SYS_nanosleep, {1}},
                 {SYS_nanosleep, {0}},
                 {SYS_clock_nanosleep, {CLOCK_MONOTONIC, 0, 1}},
                 {SYS_clock_nanosleep, {CLOCK_MONOTONIC, 0, 0}},
                 {SYS_ppoll, {0, 0, 1, 0, KERNEL_MASK}},
                 {SYS_select, {1, 1}},
                 {SYS_select, {1, 0, 1}},
                 {SYS_select, {1, 0, 0, 1}},
                 {SYS_select, {0, 0, 0, 0, 1}},
                 {SYS_pselect6, {1, 1}},
                 {SYS_pselect6, {1, 0, 1}},
                 {SYS_pselect6, {1, 0, 0, 1}},
                 {SYS_pselect6, {0, 0, 0, 0, 1}},
                 {SYS_rt_sigtimedwait, {(long)&none, 0, 1, KERNEL_MASK}}};
    (void)state;
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        const long *a = calls[i].a;
        assert_int_equal(raw_call(calls[i].number, a[0], a[1], a[2], a[3], a[4], a[5]), -EFAULT);
    }
    assert_dispatched();
}

/* A set as large as the kernel reads it for the number of descriptors, at the end of the memory. */
static void a_small_set_of_select_is_enough(void **state)
{
    enum { PAGE = 4096 };
    struct timeval timeout = {.tv_usec = 1000};
    int fds[2];
    (void)state;
    assert_int_equal(pipe(fds), 0);
    assert_true(fds[0] < 64);
    char *pages = mmap(NULL, 2 * PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(pages, MAP_FAILED);
    assert_int_equal(munmap(pages + PAGE, PAGE), 0);
    uint64_t *set = (uint64_t *)(void *)(pages + PAGE - sizeof *set);
    *set = 1ull << fds[0];
    assert_int_equal(raw_call(SYS_select, fds[0] + 1, (long)set, 0, 0, (long)&timeout, 0), 0);
    assert_true(*set == 0);
    assert_int_equal(write(fds[1], "x", 1), 1);
    *set = 1ull << fds[0];
    assert_int_equal(raw_call(SYS_select, fds[0] + 1, (long)set, 0, 0, 0, 0), 1);
    assert_true(*set == 1ull << fds[0]);
    munmap(pages, PAGE);
    close(fds[0]);
    close(fds[1]);
}

static void floating_point_survives(void **state)
{
    volatile double before = 1.0;
    (void)state;
    for (unsigned int i = 0; i < 100; i++) {
        before = before * 1.5 / 1.25;
        (void)raw_call(SYS_getppid, 0, 0, 0, 0, 0, 0);
    }
    double expected = 1.0;
    for (unsigned int i = 0; i < 100; i++)
        expected = expected * 1.5 / 1.25;
    assert_true(before == expected);
}

/* --- signals -------------------------------------------------------------------------------------------------------
 */

static volatile sig_atomic_t handled;

static void count(int number)
{
    handled += number;
}

static void own_action_of_sigsys_stays(void **state)
{
    const struct sigaction action = {.sa_handler = count};
    struct sigaction first, before; /* CMocka has an action */
    (void)state;
    handled = 0;
    assert_int_equal(sigaction(SIGSYS, &action, &first), 0);
    assert_int_equal(sigaction(SIGSYS, &action, &before), 0);
    assert_true(before.sa_handler == count);
    assert_dispatched();
    assert_int_equal(handled, 0);
    assert_int_equal(raise(SIGSYS), 0);
    assert_int_equal(handled, SIGSYS);
    assert_true(signal(SIGSYS, SIG_IGN) == count);
    assert_int_equal(raise(SIGSYS), 0);
    assert_int_equal(handled, SIGSYS);
    assert_int_equal(sigaction(SIGSYS, &first, NULL), 0);
    assert_dispatched();
}

/* The actions of the signals that the library has taken, by direct calls: no call replaces the library's handlers. */
static void own_actions_of_faults_stay(void **state)
{
    const struct {
        void (*handler)(int number);
        unsigned long flags;
        void (*restorer)(void);
        uint64_t mask;
    } action = {.handler = count}, none = {0};
    static const int numbers[] = {SIGSEGV, SIGBUS};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        long before[4] = {0}, number = numbers[i];
        handled = 0;
        assert_int_equal(raw_call(SYS_rt_sigaction, number, (long)&action, (long)before, KERNEL_MASK, 0, 0), 0);
        assert_int_equal(raw_call(SYS_access, 1, F_OK, 0, 0, 0, 0), -EFAULT);
        assert_int_equal(raw_call(SYS_openat, AT_FDCWD, 1, O_RDONLY, 0, 0, 0), -EFAULT);
        assert_int_equal(raw_call(SYS_rt_sigaction, number, (long)&none, (long)before, KERNEL_MASK, 0, 0), 0);
        assert_ptr_equal((void *)before[0], (void *)count);
        assert_int_equal(raw_call(SYS_rt_sigaction, number, (long)&action, 0, KERNEL_MASK, 0, 0), 0);
        assert_int_equal(handled, 0);
        assert_int_equal(raw_call(SYS_tgkill, getpid(), gettid(), number, 0, 0, 0), 0);
        assert_int_equal(handled, number);
    }
    assert_dispatched();
}

/* Crash handlers try addresses by such a call while the signal is blocked. */
static void an_address_is_tried_while_faults_are_blocked(void **state)
{
    sigset_t all, before;
    (void)state;
    sigfillset(&all);
    assert_int_equal(pthread_sigmask(SIG_BLOCK, &all, &before), 0);
    assert_int_equal(raw_call(SYS_rt_sigprocmask, ~0, 1, 0, KERNEL_MASK, 0, 0), -EFAULT);
    assert_int_equal(raw_call(SYS_rt_sigprocmask, ~0, (long)&all, 0, KERNEL_MASK, 0, 0), -EINVAL);
    assert_int_equal(pthread_sigmask(SIG_SETMASK, &before, NULL), 0);
    assert_dispatched();
}

static void sigsys_ends_a_program_without_an_action(void **state)
{
    int status = 0;
    (void)state;
    pid_t child = fork();
    if (child == 0) {
        (void)signal(SIGSYS, SIG_DFL);
        (void)raise(SIGSYS);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);
}

static void a_mask_of_every_signal_holds(void **state)
{
    sigset_t all, before, now;
    uint64_t every = UINT64_MAX, read_back = 0;
    (void)state;
    sigfillset(&all);
    assert_int_equal(pthread_sigmask(SIG_BLOCK, &all, &before), 0);
    assert_dispatched();
    assert_int_equal(pthread_sigmask(SIG_SETMASK, &before, NULL), 0);
    assert_int_equal(sigprocmask(SIG_SETMASK, &all, &before), 0);
    assert_dispatched();
    assert_int_equal(sigprocmask(SIG_SETMASK, &before, NULL), 0);
    assert_int_equal(raw_call(SYS_rt_sigprocmask, SIG_SETMASK, (long)&every, (long)&before, KERNEL_MASK, 0, 0), 0);
    assert_int_equal(raw_call(SYS_rt_sigprocmask, SIG_SETMASK, 0, (long)&read_back, KERNEL_MASK, 0, 0), 0);
    assert_true((read_back & 1u << (SIGUSR1 - 1)) != 0); /* the change outlives the call */
    assert_int_equal(pthread_sigmask(SIG_SETMASK, NULL, &now), 0);
    assert_int_equal(sigismember(&now, SIGUSR1), 1);
    assert_dispatched();
    assert_int_equal(raw_call(SYS_rt_sigprocmask, SIG_SETMASK, (long)&before, 0, KERNEL_MASK, 0, 0), 0);
    assert_int_equal(pthread_sigmask(SIG_SETMASK, NULL, &now), 0);
    assert_int_equal(sigismember(&now, SIGUSR1), 0);
}

static void call_in_handler(int number)
{
    if (raw_call(SYS_getpid, 0, 0, 0, 0, 0, 0) == getpid() && raw_clock() > 0)
        handled += number;
}

static void handlers_make_calls(void **state)
{
    struct sigaction action = {.sa_handler = call_in_handler};
    (void)state;
    handled = 0;
    sigfillset(&action.sa_mask);
    assert_int_equal(sigaction(SIGUSR1, &action, NULL), 0);
    assert_int_equal(raise(SIGUSR1), 0);
    assert_int_equal(raw_call(SYS_tgkill, getpid(), gettid(), SIGUSR1, 0, 0, 0), 0); /* within a call */
    assert_int_equal(handled, 2 * SIGUSR1);
    assert_dispatched();
}

__asm__(".text\nown_restorer:\n\tmov $15, %eax\n\tsyscall\n");
extern void own_restorer(void) __attribute__((visibility("hidden")));

static void handlers_have_a_restorer_of_their_own(void **state)
{
    const struct {
        void (*handler)(int number);
        unsigned long flags;
        void (*restorer)(void);
        uint64_t mask;
    } action = {call_in_handler, 0x04000000 /* SA_RESTORER */, own_restorer, UINT64_MAX};
    volatile uint64_t kept = 0x123456789ABCDEF;
    sigset_t now;
    (void)state;
    handled = 0;
    assert_int_equal(raw_call(SYS_rt_sigaction, SIGUSR2, (long)&action, 0, KERNEL_MASK, 0, 0), 0);
    for (unsigned int i = 0; i < 1000; i++)
        assert_int_equal(raw_call(SYS_tgkill, getpid(), gettid(), SIGUSR2, 0, 0, 0), 0);
    assert_int_equal(handled, 1000 * SIGUSR2);
    assert_true(kept == 0x123456789ABCDEF);
    assert_int_equal(pthread_sigmask(SIG_SETMASK, NULL, &now), 0);
    assert_int_equal(sigismember(&now, SIGUSR1), 0);
    assert_dispatched();
}

static void a_signal_stack_stays(void **state)
{
    enum { SIZE = 65536 };
    stack_t set = {.ss_sp = malloc(SIZE), .ss_size = SIZE}, now;
    (void)state;
    assert_int_equal(raw_call(SYS_sigaltstack, (long)&set, 0, 0, 0, 0, 0), 0);
    assert_int_equal(sigaltstack(NULL, &now), 0);
    assert_ptr_equal(now.ss_sp, set.ss_sp);
    assert_dispatched();
    set.ss_flags = SS_DISABLE;
    assert_int_equal(raw_call(SYS_sigaltstack, (long)&set, 0, 0, 0, 0, 0), 0);
    assert_int_equal(sigaltstack(NULL, &now), 0);
    assert_int_equal(now.ss_flags, SS_DISABLE);
    free(set.ss_sp);
}

/* --- threads and processes -----------------------------------------------------------------------------------------
 */

static void *use_clock(void *arg)
{
    assert_int_equal(raw_call(SYS_sched_yield, 0, 0, 0, 0, 0, 0), 0); /* with a sanitizer its turn comes here */
    assert_dispatched();
    return arg;
}

static void threads_are_dispatched(void **state)
{
    pthread_t thread;
    int mark;
    void *result = NULL;
    (void)state;
    assert_int_equal(pthread_create(&thread, NULL, use_clock, &mark), 0);
    assert_int_equal(pthread_join(thread, &result), 0);
    assert_ptr_equal(result, &mark);
}

/* The code of the vDSO passes an unknown flag on to the kernel, by a call outside the C library. */
static void *fill_at_random(void *arg)
{
    enum { NOT_KNOWN = 0x100 };
    char bytes[16];
    assert_int_equal(getrandom(bytes, sizeof bytes, 0), sizeof bytes);
    errno = 0;
    assert_int_equal(getrandom(bytes, sizeof bytes, NOT_KNOWN), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(raw_call(SYS_getpid, 0, 0, 0, 0, 0, 0), getpid());
    return arg;
}

static void threads_read_random_bytes(void **state)
{
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    (void)state;
    for (size_t i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, fill_at_random, NULL), 0);
    for (size_t i = 0; i < THREADS; i++)
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    (void)fill_at_random(NULL);
}

static void children_are_dispatched(void **state)
{
    static const struct {
        long number, flags;
    } kinds[] = {{SYS_fork, 0}, {SYS_vfork, 0}, {SYS_clone, SIGCHLD}, {SYS_clone, SIGCHLD | CLONE_VM | CLONE_VFORK}};
    (void)state;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        int status = -1;
        long child = raw_call(kinds[i].number, kinds[i].flags, 0, 0, 0, 0, 0);
        if (child == 0) {
            uint64_t first = raw_clock();
            (void)raw_call(SYS_exit_group, !is_virtual || raw_clock() - first == 50 ? 5 : 6, 0, 0, 0, 0, 0);
        }
        assert_true(child > 0);
        assert_int_equal(raw_call(SYS_wait4, child, (long)&status, 0, 0, 0, 0), child);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 5);
    }
    assert_int_equal(raw_call(SYS_clone3, 0, 0, 0, 0, 0, 0), -ENOSYS);
    assert_dispatched();
}

/* --- the clock -----------------------------------------------------------------------------------------------------
 */

static bool has_vdso(const ElfW(auxv_t) * vector, size_t count)
{
    for (size_t i = 0; i < count && vector[i].a_type != AT_NULL; i++) {
        if (vector[i].a_type == AT_SYSINFO_EHDR)
            return true;
    }
    return false;
}

static void the_vdso_is_hidden_on_the_virtual_clock(void **state)
{
    enum { MANY = 64 };
    ElfW(auxv_t) vector[MANY];
    (void)state;
    assert_int_equal(getauxval(AT_SYSINFO_EHDR) == 0, is_virtual);
    long length = raw_call(SYS_prctl, GET_AUXV, (long)vector, sizeof vector, 0, 0, 0);
    if (length > 0) /* Linux 6.4 */
        assert_int_equal(!has_vdso(vector, (size_t)length / sizeof *vector), is_virtual);
    long fd = raw_call(SYS_openat, AT_FDCWD, (long)"/proc/self/auxv", O_RDONLY | O_CLOEXEC, 0, 0, 0);
    assert_true(fd >= 0);
    length = raw_call(SYS_read, fd, (long)vector, sizeof vector, 0, 0, 0);
    assert_true(length > 0);
    assert_int_equal(!has_vdso(vector, (size_t)length / sizeof *vector), is_virtual);
    assert_int_equal(raw_call(SYS_close, fd, 0, 0, 0, 0, 0), 0);
}

/* --- a thread that is let go ---------------------------------------------------------------------------------------
 */

static int run_alone(void *arg)
{
    int *ended = arg;
    __atomic_store_n(ended, raw_call(SYS_getppid, 0, 0, 0, 0, 0, 0) > 0 ? 1 : 2, __ATOMIC_SEQ_CST);
    (void)raw_call(SYS_exit, 0, 0, 0, 0, 0, 0);
    return 0;
}

static void a_thread_of_the_programs_own_runs(void)
{
    enum { SIZE = 65536 };
    static char stack[SIZE] __attribute__((aligned(16)));
    static int ended;
    long *top = (long *)(void *)(stack + SIZE) - 2;
    long flags = CLONE_VM | CLONE_FS | CLONE_FILES | CLONE_SIGHAND | CLONE_THREAD | CLONE_SYSVSEM;
    long result;
    __asm__ volatile("syscall\n\ttest %%rax, %%rax\n\tjnz 1f\n\tmov %2, %%rdi\n\tcall *%3\n1:"
                     : "=a"(result)
                     : "0"(SYS_clone), "r"(&ended), "r"(run_alone), "D"(flags), "S"(top), "d"(0)
                     : "rcx", "r11", "memory");
    while (__atomic_load_n(&ended, __ATOMIC_SEQ_CST) == 0)
        (void)raw_call(SYS_sched_yield, 0, 0, 0, 0, 0, 0);
    exit(result > 0 && ended == 1 ? 0 : 1);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Results and errors are those of the kernel; errno stays", results_are_those_of_the_kernel, NULL, NULL, NULL},
        {"A path at a bad address is refused, and ends no program", a_path_at_a_bad_address_is_refused, NULL, NULL,
         NULL},
        {"A time or a set of descriptors at a bad address is refused, and ends no program",
         a_time_or_a_set_at_a_bad_address_is_refused, NULL, NULL, NULL},
        {"A set that ends behind the word of its last descriptor is enough for select", a_small_set_of_select_is_enough,
         NULL, NULL, NULL},
        {"A mask at a bad address is refused, and ends no program", a_mask_at_a_bad_address_is_refused, NULL, NULL,
         NULL},
        {"Floating point registers survive calls", floating_point_survives, NULL, NULL, NULL},
        {"The program's own action of SIGSYS stays", own_action_of_sigsys_stays, NULL, NULL, NULL},
        {"The program's own actions of SIGSEGV and SIGBUS stay", own_actions_of_faults_stay, NULL, NULL, NULL},
        {"A call tries an address while faults are blocked", an_address_is_tried_while_faults_are_blocked, NULL, NULL,
         NULL},
        {"SIGSYS ends a program without an action", sigsys_ends_a_program_without_an_action, NULL, NULL, NULL},
        {"A mask of every signal holds, and outlives the call", a_mask_of_every_signal_holds, NULL, NULL, NULL},
        {"Handlers make calls, also when they block every signal", handlers_make_calls, NULL, NULL, NULL},
        {"A handler returns by a restorer of the program's own", handlers_have_a_restorer_of_their_own, NULL, NULL,
         NULL},
        {"A signal stack that a call sets stays", a_signal_stack_stays, NULL, NULL, NULL},
        {"Threads are dispatched", threads_are_dispatched, NULL, NULL, NULL},
        {"Threads read random bytes, which the vDSO may leave to the kernel", threads_read_random_bytes, NULL, NULL,
         NULL},
        {"Children of fork, vfork and clone are dispatched", children_are_dispatched, NULL, NULL, NULL},
        {"The vDSO is hidden on the virtual clock, and there alone", the_vdso_is_hidden_on_the_virtual_clock, NULL,
         NULL, NULL},
    };
    if (argc < 2) {
        print_error("usage: inprocess_dispatch real|virtual [CASE]\n");
        return 1;
    }
    is_virtual = strcmp(argv[1], "virtual") == 0;
    if (argc > 2 && strcmp(argv[2], "alone") == 0)
        a_thread_of_the_programs_own_runs();
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
