/* SPDX-License-Identifier: MIT */
/* Signals that the library takes, and the program's own actions of these, of a kernel that is the test's. */
#define _GNU_SOURCE
#include <signal.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "fakes.h"

OURS(sigaction);
OURS(signal);
OURS(sysv_signal);
OURS(ssignal);
OURS(sigprocmask);
OURS(pthread_sigmask);
__sighandler_t ours___sysv_signal(int number, __sighandler_t handler);
__sighandler_t ours_bsd_signal(int number, __sighandler_t handler);

static struct sigaction kernel_actions[NSIG];
static sigset_t mask_given;

/* --- fakes ----------------------------------------------------------------------------------------------------------
 */

static int fake_sigaction(int number, const struct sigaction *action, struct sigaction *before)
{
    long result = CALLED(sigaction, number, action != NULL, before != NULL);
    if (result == 0 && before)
        *before = kernel_actions[number];
    if (result == 0 && action)
        kernel_actions[number] = *action;
    return (int)result;
}

static __sighandler_t fake_signal(int number, __sighandler_t handler)
{
    return (__sighandler_t)CALLED(signal, number, (long)handler);
}

static __sighandler_t fake___sysv_signal(int number, __sighandler_t handler)
{
    return (__sighandler_t)CALLED(sysv_signal, number, (long)handler);
}

static int give_mask(const char *name, int how, const sigset_t *set, sigset_t *before)
{
    if (set)
        mask_given = *set;
    return (int)fake_call(name, (const long[]){how, set != NULL, before != NULL}, 3);
}

static int fake_sigprocmask(int how, const sigset_t *set, sigset_t *before)
{
    return give_mask("sigprocmask", how, set, before);
}

static int fake_pthread_sigmask(int how, const sigset_t *set, sigset_t *before)
{
    return give_mask("pthread_sigmask", how, set, before);
}

static uint64_t mask_set; /* by a system call */

static long fake_syscall(long number, ...)
{
    long a[4];
    va_list arguments;
    va_start(arguments, number);
    for (size_t i = 0; i < 4; i++)
        a[i] = va_arg(arguments, long);
    va_end(arguments);
    if (number == SYS_rt_tgsigqueueinfo)
        return CALLED(queue, a[0], a[1], a[2], ((const siginfo_t *)a[3])->si_code);
    assert_int_equal(number, SYS_rt_sigprocmask);
    memcpy(&mask_set, (const void *)a[1], sizeof mask_set);
    return CALLED(set_mask, a[0], a[2], a[3]);
}

FAKES(FAKE(sigaction), FAKE(signal), FAKE(__sysv_signal), FAKE(sigprocmask), FAKE(pthread_sigmask), FAKE(syscall))

pid_t fake_getpid(void)
{
    return 50;
}

pid_t fake_gettid(void)
{
    return 51;
}

int fake_raise(int number)
{
    return (int)CALLED(raise, number);
}

/* --- tests ----------------------------------------------------------------------------------------------------------
 */

static void library_handler(int number, siginfo_t *info, void *context)
{
    (void)number;
    (void)info;
    (void)context;
}

static void own_handler(int number)
{
    CALLED(own, number);
}

static void own_information(int number, siginfo_t *info, void *context)
{
    CALLED(own_information, number, info->si_code, (long)context);
}

static void set_own(int number, __sighandler_t handler, int flags)
{
    kernel_actions[number] = (struct sigaction){.sa_handler = handler, .sa_flags = flags};
    sigaddset(&kernel_actions[number].sa_mask, SIGUSR1);
    sigaddset(&kernel_actions[number].sa_mask, SIGSYS);
}

static int begin(void **state)
{
    static const int numbers[] = {SIGSEGV, SIGBUS, SIGSYS};
    for (size_t i = 0; i < 3; i++) {
        if (ect_action_is_taken(numbers[i]))
            ect_action_leave(numbers[i]);
    }
    memset(kernel_actions, 0, sizeof kernel_actions);
    return begin_fakes(state);
}

static void takes_a_signal_as_the_program_would(void **state)
{
    const struct sigaction *now = &kernel_actions[SIGSEGV];
    (void)state;
    set_own(SIGSEGV, own_handler, SA_ONSTACK | SA_NODEFER | (int)SA_RESETHAND);
    assert_false(ect_action_is_taken(SIGSEGV));
    assert_int_equal(ect_action_take(SIGSEGV, library_handler, ECT_AS_PROGRAM), 0);
    EXPECT_CALLS("take", "sigaction(11,0,1) sigaction(11,1,0) ");
    assert_true(ect_action_is_taken(SIGSEGV));
    assert_ptr_equal((void *)now->sa_sigaction, (void *)library_handler);
    assert_int_equal(now->sa_flags, SA_ONSTACK | SA_NODEFER | SA_SIGINFO);
    assert_int_equal(sigismember(&now->sa_mask, SIGUSR1), 1);
    assert_int_equal(sigismember(&now->sa_mask, SIGSYS), 1);
    ect_action_leave(SIGSEGV);
    EXPECT_CALLS("leave", "sigaction(11,1,0) ");
    assert_ptr_equal((void *)now->sa_handler, (void *)own_handler);
    assert_int_equal(now->sa_flags, SA_ONSTACK | SA_NODEFER | (int)SA_RESETHAND);
    assert_false(ect_action_is_taken(SIGSEGV));
}

static void takes_a_signal_in_a_call(void **state)
{
    const struct sigaction *now = &kernel_actions[SIGSYS];
    (void)state;
    set_own(SIGSYS, own_handler, SA_ONSTACK);
    assert_int_equal(ect_action_take(SIGSYS, library_handler, ECT_IN_CALL), 0);
    EXPECT_CALLS("take", "sigaction(31,0,1) sigaction(31,1,0) pthread_sigmask(1,1,0) ");
    assert_int_equal(sigismember(&mask_given, SIGSYS), 1);
    assert_int_equal(sigismember(&mask_given, SIGUSR1), 0);
    assert_ptr_equal((void *)now->sa_sigaction, (void *)library_handler);
    assert_int_equal(now->sa_flags, SA_NODEFER | SA_RESTART | SA_SIGINFO);
    assert_int_equal(sigismember(&now->sa_mask, SIGUSR1), 0);
}

static void is_refused_by_the_kernel(void **state)
{
    (void)state;
    plan("sigaction", -1, EINVAL);
    assert_int_equal(ect_action_take(SIGBUS, library_handler, ECT_AS_PROGRAM), -1);
    EXPECT_CALLS("the first call", "sigaction(7,0,1) ");
    plan("sigaction", 0, 0);
    plan("sigaction", -1, EINVAL);
    assert_int_equal(ect_action_take(SIGBUS, library_handler, ECT_AS_PROGRAM), -1);
    EXPECT_CALLS("the second call", "sigaction(7,0,1) sigaction(7,1,0) ");
    assert_false(ect_action_is_taken(SIGBUS));
}

static void keeps_the_own_action(void **state)
{
    struct sigaction set = {.sa_sigaction = own_information, .sa_flags = SA_SIGINFO | SA_ONSTACK}, before;
    const struct sigaction *now = &kernel_actions[SIGSEGV];
    (void)state;
    set_own(SIGSEGV, own_handler, SA_RESTART);
    (void)ect_action_take(SIGSEGV, library_handler, ECT_AS_PROGRAM);
    (void)ect_action_take(SIGSYS, library_handler, ECT_IN_CALL);
    forget_calls();
    sigfillset(&set.sa_mask);
    assert_int_equal(ours_sigaction(SIGSEGV, &set, &before), 0);
    EXPECT_CALLS("an action", "sigaction(11,1,0) ");
    assert_ptr_equal((void *)before.sa_handler, (void *)own_handler);
    assert_int_equal(before.sa_flags, SA_RESTART);
    assert_ptr_equal((void *)now->sa_sigaction, (void *)library_handler);
    assert_int_equal(now->sa_flags, SA_SIGINFO | SA_ONSTACK);
    assert_int_equal(sigismember(&now->sa_mask, SIGUSR2), 1);
    assert_int_equal(sigismember(&now->sa_mask, SIGSYS), 0);
    assert_int_equal(ours_sigaction(SIGSEGV, NULL, &before), 0);
    assert_ptr_equal((void *)before.sa_sigaction, (void *)own_information);
    assert_int_equal(before.sa_flags, SA_SIGINFO | SA_ONSTACK);
    assert_int_equal(sigismember(&before.sa_mask, SIGSYS), 1);
    EXPECT_CALLS("a question", "");
    assert_int_equal(ours_sigaction(SIGSYS, &set, NULL), 0);
    assert_int_equal(ours_sigaction(SIGSYS, NULL, &before), 0);
    assert_ptr_equal((void *)before.sa_sigaction, (void *)own_information);
    EXPECT_CALLS("of a call", "");
}

/* The kernel has a handler of the library, and otherwise what the program has set. */
static void keeps_handlers_of_other_signals(void **state)
{
    static const struct {
        const char *title;
        __sighandler_t handler;
        int flags;
        bool kept;
        int kernel_flags;
    } rows[] = {{"default", SIG_DFL, SA_NOCLDSTOP, false, SA_NOCLDSTOP},
                {"a handler", own_handler, SA_RESTART, true, SA_RESTART | SA_SIGINFO},
                {"information", own_handler, SA_SIGINFO | SA_ONSTACK, true, SA_SIGINFO | SA_ONSTACK},
                {"ignored", SIG_IGN, 0, false, 0},
                {"once", own_handler, (int)SA_RESETHAND | SA_NODEFER, true, SA_NODEFER | SA_SIGINFO}};
    const struct sigaction *now = &kernel_actions[SIGUSR1];
    struct sigaction before;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct sigaction set = {.sa_handler = rows[i].handler, .sa_flags = rows[i].flags};
        sigaddset(&set.sa_mask, SIGUSR2);
        assert_int_equal(ours_sigaction(SIGUSR1, &set, NULL), 0);
        if ((now->sa_handler != rows[i].handler) != rows[i].kept || now->sa_flags != rows[i].kernel_flags ||
            sigismember(&now->sa_mask, SIGUSR2) != 1)
            fail_msg("%s: the kernel has flags 0x%X", rows[i].title, (unsigned int)now->sa_flags);
        assert_int_equal(ours_sigaction(SIGUSR1, NULL, &before), 0);
        if (before.sa_handler != rows[i].handler || before.sa_flags != rows[i].flags)
            fail_msg("%s: flags 0x%X are returned", rows[i].title, (unsigned int)before.sa_flags);
        assert_int_equal(ours_sigaction(SIGUSR1, &set, &before), 0);
        assert_ptr_equal((void *)before.sa_handler, (void *)rows[i].handler);
    }
    forget_calls();
    plan("sigaction", -1, EINVAL);
    assert_int_equal(ours_sigaction(SIGKILL, NULL, &before), -1);
    EXPECT_CALLS("refused", "sigaction(9,0,1) ");
    ect_inside = 1;
    const struct sigaction library = {.sa_handler = own_handler};
    assert_int_equal(ours_sigaction(SIGUSR2, &library, NULL), 0);
    assert_ptr_equal((void *)kernel_actions[SIGUSR2].sa_handler, (void *)own_handler);
}

static void blocks_no_call_in_handlers(void **state)
{
    struct sigaction set = {.sa_handler = own_handler};
    (void)state;
    sigfillset(&set.sa_mask);
    assert_int_equal(ours_sigaction(SIGUSR1, &set, NULL), 0);
    assert_int_equal(sigismember(&kernel_actions[SIGUSR1].sa_mask, SIGSYS), 1);
    (void)ect_action_take(SIGSYS, library_handler, ECT_IN_CALL);
    assert_int_equal(ours_sigaction(SIGUSR1, &set, NULL), 0);
    assert_int_equal(sigismember(&kernel_actions[SIGUSR1].sa_mask, SIGSYS), 0);
    assert_int_equal(sigismember(&kernel_actions[SIGUSR1].sa_mask, SIGUSR2), 1);
}

/* The real functions know siginterrupt(3). */
static void keeps_handlers_of_signal(void **state)
{
    (void)state;
    (void)ours_sigaction(SIGUSR1, &(struct sigaction){.sa_handler = own_handler}, NULL);
    __sighandler_t library = kernel_actions[SIGUSR1].sa_handler;
    set_own(SIGUSR1, own_handler, SA_RESTART); /* as the real function does */
    plan("signal", (long)library, 0);
    assert_ptr_equal((void *)ours_signal(SIGUSR1, own_handler), (void *)own_handler);
    assert_ptr_equal((void *)kernel_actions[SIGUSR1].sa_handler, (void *)library);
    assert_int_equal(kernel_actions[SIGUSR1].sa_flags, SA_RESTART | SA_SIGINFO);
    set_own(SIGUSR1, SIG_IGN, 0);
    plan("sysv_signal", (long)library, 0);
    assert_ptr_equal((void *)ours___sysv_signal(SIGUSR1, SIG_IGN), (void *)own_handler);
    assert_ptr_equal((void *)kernel_actions[SIGUSR1].sa_handler, (void *)SIG_IGN);
    plan("signal", (long)SIG_IGN, 0);
    assert_ptr_equal((void *)ours_signal(SIGUSR1, SIG_DFL), (void *)SIG_IGN);
    plan("signal", (long)SIG_ERR, EINVAL);
    assert_ptr_equal((void *)ours_signal(NSIG + 5, own_handler), (void *)SIG_ERR);
    set_own(SIGUSR2, own_handler, 0);
    ect_inside = 1;
    plan("signal", 5, 0);
    assert_int_equal((long)ours_signal(SIGUSR2, own_handler), 5);
    assert_ptr_equal((void *)kernel_actions[SIGUSR2].sa_handler, (void *)own_handler);
}

/* Sends a signal as the kernel does. @return the mask behind the handler */
static uint64_t handle(int number, int code, uint64_t mask)
{
    ucontext_t at = {0};
    siginfo_t info = {.si_signo = number, .si_code = code};
    memcpy(&at.uc_sigmask, &mask, sizeof mask);
    kernel_actions[number].sa_sigaction(number, &info, &at);
    memcpy(&mask, &at.uc_sigmask, sizeof mask);
    return mask;
}

#define BIT(number) (1ull << ((number) - 1))

static void defers_a_handler(void **state)
{
    const uint64_t urgent = BIT(SIGSEGV) | BIT(SIGBUS) | BIT(SIGSYS) | BIT(SIGILL) | BIT(SIGFPE) | BIT(SIGTRAP) |
                            BIT(SIGABRT) | BIT(32) | BIT(33);
    (void)state;
    (void)ours_sigaction(SIGUSR1, &(struct sigaction){.sa_handler = own_handler}, NULL);
    (void)ours_sigaction(SIGUSR2, &(struct sigaction){.sa_handler = own_handler}, NULL);
    (void)ours_sigaction(SIGFPE, &(struct sigaction){.sa_handler = own_handler}, NULL);
    forget_calls();
    assert_int_equal(handle(SIGUSR1, SI_USER, BIT(3)), BIT(3));
    EXPECT_CALLS("without a hold", "sigaction(10,0,1) own(10) ");
    ect_action_hold();
    ect_action_hold();
    EXPECT_CALLS("a hold, nested", "");
    ect_action_watch();
    errno = 7;
    plan("queue", 0, 8);
    assert_int_equal(handle(SIGUSR2, SI_TIMER, BIT(4)), ~urgent); /* its handler interrupts that of SIGUSR1 */
    assert_int_equal(errno, 7);
    assert_int_equal(handle(SIGUSR1, SI_USER, BIT(3)), ~urgent);
    EXPECT_CALLS("deferred", "queue(50,51,12,-2) queue(50,51,10,0) ");
    assert_int_equal(handle(SIGFPE, FPE_INTDIV, BIT(3)), BIT(3));
    EXPECT_CALLS("a fault", "sigaction(8,0,1) own(8) ");
    ect_action_release();
    EXPECT_CALLS("the inner hold", "");
    assert_int_equal(ect_action_handled().count, 1);
    ect_action_release();
    EXPECT_CALLS("the end", "set_mask(2,0,8) ");
    assert_int_equal(mask_set, BIT(3));
    ect_action_hold();
    ect_action_release();
    EXPECT_CALLS("no signal", "");
}

static void watch_in_handler(int number)
{
    ect_action_watch();
    assert_int_equal(ect_action_handled().count, 0);
    (void)number;
}

static void counts_handlers(void **state)
{
    static const struct {
        int flags[2];
        bool restarts;
    } rows[] = {{{0, 0}, false}, {{SA_RESTART, 0}, false}, {{0, SA_RESTART}, false}, {{SA_RESTART, SA_RESTART}, true}};
    (void)state;
    ect_action_watch();
    assert_int_equal(ect_action_handled().count, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_action_watch();
        for (unsigned int n = 0; n < 2; n++) {
            (void)ours_sigaction(
                SIGUSR1, &(struct sigaction){.sa_handler = watch_in_handler, .sa_flags = rows[i].flags[n]}, NULL);
            (void)handle(SIGUSR1, SI_USER, 0);
            assert_int_equal(ect_action_handled().count, n + 1);
        }
        assert_int_equal(ect_action_handled().restarts, rows[i].restarts);
    }
}

static void runs_a_handler_once(void **state)
{
    struct sigaction before;
    (void)state;
    (void)ours_sigaction(SIGUSR1, &(struct sigaction){.sa_handler = own_handler, .sa_flags = (int)SA_RESETHAND}, NULL);
    ect_action_hold();
    (void)handle(SIGUSR1, SI_USER, 0);
    (void)ours_sigaction(SIGUSR1, NULL, &before);
    assert_ptr_equal((void *)before.sa_handler, (void *)own_handler); /* it is only deferred */
    ect_action_release();
    forget_calls();
    (void)handle(SIGUSR1, SI_USER, 0);
    EXPECT_CALLS("the handler", "sigaction(10,0,1) sigaction(10,1,0) own(10) ");
    (void)ours_sigaction(SIGUSR1, NULL, &before);
    assert_ptr_equal((void *)before.sa_handler, (void *)SIG_DFL);
}

static void sets_handlers(void **state)
{
    static const struct {
        const char *title;
        __sighandler_t (*call)(int number, __sighandler_t handler);
        int flags;
        bool masks;
    } rows[] = {{"signal", ours_signal, SA_RESTART, true},
                {"ssignal", ours_ssignal, SA_RESTART, true},
                {"bsd_signal", ours_bsd_signal, SA_RESTART, true},
                {"__sysv_signal", ours___sysv_signal, (int)SA_RESETHAND | SA_NODEFER, false},
                {"sysv_signal", ours_sysv_signal, (int)SA_RESETHAND | SA_NODEFER, false}};
    struct sigaction now;
    (void)state;
    (void)ect_action_take(SIGSEGV, library_handler, ECT_AS_PROGRAM);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_ptr_equal((void *)rows[i].call(SIGSEGV, own_handler), (void *)SIG_DFL);
        (void)ours_sigaction(SIGSEGV, NULL, &now);
        if (now.sa_handler != own_handler || now.sa_flags != rows[i].flags ||
            sigismember(&now.sa_mask, SIGSEGV) != rows[i].masks)
            fail_msg("%s: flags 0x%X", rows[i].title, (unsigned int)now.sa_flags);
        errno = 0;
        assert_ptr_equal((void *)rows[i].call(SIGSEGV, SIG_ERR), (void *)SIG_ERR);
        assert_int_equal(errno, EINVAL);
        assert_ptr_equal((void *)rows[i].call(SIGSEGV, SIG_DFL), (void *)own_handler);
        forget_calls();
    }
}

/* A fault repeats itself with the default action, with its registers in the core file; other signals are raised. */
static void runs_the_own_action(void **state)
{
    static const struct {
        const char *title;
        int number, code;
        __sighandler_t handler;
        int flags;
        const char *calls;
    } rows[] = {
        {"a handler", SIGSEGV, SEGV_MAPERR, own_handler, 0, "own(11) "},
        {"a handler, sent", SIGSEGV, SI_USER, own_handler, 0, "own(11) "},
        {"information", SIGSEGV, SEGV_MAPERR, NULL, SA_SIGINFO, "own_information(11,1,77) "},
        {"a default fault", SIGSEGV, SEGV_MAPERR, SIG_DFL, 0, "sigaction(11,1,0) "},
        {"a default fault, information", SIGSEGV, SEGV_MAPERR, SIG_DFL, SA_ONSTACK, "sigaction(11,1,0) "},
        {"default, sent", SIGSEGV, SI_USER, SIG_DFL, 0, "sigaction(11,1,0) raise(11) "},
        {"an ignored fault", SIGBUS, BUS_ADRERR, SIG_IGN, 0, "sigaction(7,1,0) "},
        {"ignored, sent", SIGBUS, SI_USER, SIG_IGN, 0, ""},
        {"a default call", SIGSYS, 1, SIG_DFL, 0, "sigaction(31,1,0) raise(31) "},
        {"an ignored call", SIGSYS, 1, SIG_IGN, 0, "sigaction(31,1,0) raise(31) "},
        {"a handled call", SIGSYS, 1, own_handler, 0, "own(31) "},
        {"ignored, sent", SIGSYS, SI_TKILL, SIG_IGN, 0, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        siginfo_t info = {.si_code = rows[i].code};
        (void)begin(NULL);
        set_own(rows[i].number, rows[i].handler, rows[i].flags);
        if ((rows[i].flags & SA_SIGINFO) != 0)
            kernel_actions[rows[i].number].sa_sigaction = own_information;
        (void)ect_action_take(rows[i].number, library_handler, rows[i].number == SIGSYS ? ECT_IN_CALL : ECT_AS_PROGRAM);
        forget_calls();
        ect_action_run(rows[i].number, &info, AT(77));
        EXPECT_CALLS(rows[i].title, rows[i].calls);
        if (strncmp(rows[i].calls, "sigaction", 9) == 0)
            assert_ptr_equal((void *)kernel_actions[rows[i].number].sa_handler, (void *)SIG_DFL);
    }
}

static void resets_a_handler_that_runs_once(void **state)
{
    struct sigaction now;
    siginfo_t info = {.si_code = SI_USER};
    (void)state;
    set_own(SIGSEGV, own_handler, (int)SA_RESETHAND);
    (void)ect_action_take(SIGSEGV, library_handler, ECT_AS_PROGRAM);
    forget_calls();
    ect_action_run(SIGSEGV, &info, NULL);
    EXPECT_CALLS("the first signal", "own(11) ");
    (void)ours_sigaction(SIGSEGV, NULL, &now);
    assert_ptr_equal((void *)now.sa_handler, (void *)SIG_DFL);
    ect_action_run(SIGSEGV, &info, NULL);
    EXPECT_CALLS("the second signal", "sigaction(11,1,0) raise(11) ");
}

static void masks_without_the_signal_of_calls(void **state)
{
    static const struct {
        int how;
        bool taken, blocks;
    } rows[] = {
        {SIG_BLOCK, false, true}, {SIG_BLOCK, true, false}, {SIG_SETMASK, true, false}, {SIG_UNBLOCK, true, true}};
    sigset_t set;
    (void)state;
    sigfillset(&set);
    (void)ect_action_take(SIGSEGV, library_handler, ECT_AS_PROGRAM);
    assert_int_equal(ect_action_mask(UINT64_MAX), UINT64_MAX);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].taken && !ect_action_is_taken(SIGSYS))
            (void)ect_action_take(SIGSYS, library_handler, ECT_IN_CALL);
        plan("sigprocmask", 3, 0);
        assert_int_equal(ours_sigprocmask(rows[i].how, &set, NULL), 3);
        assert_int_equal(sigismember(&mask_given, SIGSYS), rows[i].blocks);
        assert_int_equal(sigismember(&mask_given, SIGSEGV), 1);
        memset(&mask_given, 0, sizeof mask_given);
        plan("pthread_sigmask", 4, 0);
        assert_int_equal(ours_pthread_sigmask(rows[i].how, &set, &(sigset_t){0}), 4);
        assert_int_equal(sigismember(&mask_given, SIGSYS), rows[i].blocks);
    }
    forget_calls();
    (void)ours_sigprocmask(SIG_BLOCK, NULL, &set);
    (void)ours_pthread_sigmask(SIG_BLOCK, NULL, &set);
    EXPECT_CALLS("questions", "sigprocmask(0,0,1) pthread_sigmask(0,0,1) ");
    assert_int_equal(ect_action_mask(UINT64_MAX), UINT64_MAX & ~(1ull << (SIGSYS - 1)));
}

#undef TEST
#define TEST(title, function) {title, function, begin, NULL, NULL}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("A taken signal has mask, stack and flags of the program's action", takes_a_signal_as_the_program_would),
        TEST("A signal of calls has neither, and is unblocked", takes_a_signal_in_a_call),
        TEST("A signal that the kernel refuses is not taken", is_refused_by_the_kernel),
        TEST("sigaction() sets and returns the program's own action", keeps_the_own_action),
        TEST("sigaction() returns the handlers of other signals, which run by the library",
             keeps_handlers_of_other_signals),
        TEST("The mask of a handler never blocks SIGSYS once it is taken", blocks_no_call_in_handlers),
        TEST("signal() and its variants return the handlers of other signals", keeps_handlers_of_signal),
        TEST("A handler is deferred while its thread is held; that of a fault is not", defers_a_handler),
        TEST("Handlers are counted, with SA_RESTART if each has it, beside those within a handler", counts_handlers),
        TEST("SA_RESETHAND resets a handler when it runs, not when it is deferred", runs_a_handler_once),
        TEST("signal() and its variants set the program's own handler", sets_handlers),
        TEST("The program's own action runs as from the kernel", runs_the_own_action),
        TEST("SA_RESETHAND resets the program's own action", resets_a_handler_that_runs_once),
        TEST("A mask of signals never blocks SIGSYS once it is taken", masks_without_the_signal_of_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
