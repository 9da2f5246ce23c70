/* SPDX-License-Identifier: MIT */
/* Direct system calls that read the virtual clock, or wait, reach the replaced functions with all their arguments. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/raw.h"
#include "fakes.h"

static uint8_t written[64 * sizeof(ElfW(auxv_t))];

/* --- the C library
 * ---------------------------------------------------------------------------------------------------- */

static int fake_open(const char *path, int flags, ...)
{
    assert_string_equal(path, "/proc/self/auxv");
    return (int)CALLED(open, flags);
}

/* Two entries and the end, in so many bytes as planned. */
static ssize_t fake_read(int fd, void *data, size_t size)
{
    const ElfW(auxv_t) vector[] = {{.a_type = AT_SYSINFO_EHDR}, {.a_type = AT_PAGESZ}, {.a_type = AT_NULL}};
    assert_int_equal(size, 64 * sizeof *vector);
    memcpy(data, vector, sizeof vector);
    return CALLED(read, fd);
}

static int fake_close(int fd)
{
    return (int)CALLED(close, fd);
}

static ssize_t fake_write(int fd, const void *data, size_t size)
{
    memcpy(written, data, size);
    return CALLED(write, fd, (long)size);
}

FAKES(FAKE(open), FAKE(read), FAKE(close), FAKE(write))

int fake_memfd_create(const char *name, unsigned int flags)
{
    assert_string_equal(name, "auxv");
    return (int)CALLED(memfd_create, flags);
}

long fake_lseek(int fd, long offset, int whence)
{
    return CALLED(lseek, fd, offset, whence);
}

/* --- the functions that the room replaces: each argument is a register of its own, whatever its type
 * -------------------- */

FAKE_1(time)
FAKE_1(alarm)
FAKE_2(clock_gettime)
FAKE_2(gettimeofday)
FAKE_2(nanosleep)
FAKE_4(clock_nanosleep)
FAKE_3(poll)
FAKE_4(epoll_wait)
FAKE_2(timerfd_create)
FAKE_4(timerfd_settime)
FAKE_2(timerfd_gettime)
FAKE_3(setitimer)
FAKE_2(getitimer)
FAKE_4(wait4)
FAKE_4(waitid)
FAKE_5(select)

long fake_sched_yield(void)
{
    return CALLED(sched_yield);
}

long fake_pause(void)
{
    return CALLED(pause);
}

long fake_syscall(long number, long a, long b, long c, long d, long e, long f)
{
    assert_int_equal(number, SYS_futex);
    return CALLED(syscall, a, b, c, d, e, f);
}

/* The signals of a mask, as a word; -1: no mask. */
static long word_of(const sigset_t *mask)
{
    long word = -1;
    if (!mask)
        return word;
    memcpy(&word, mask, sizeof word);
    for (int number = 65; number < 128; number++)
        assert_int_equal(sigismember(mask, number) == 1, 0);
    return word;
}

long fake_ppoll(long a, long b, long c, const sigset_t *mask)
{
    return CALLED(ppoll, a, b, c, word_of(mask));
}

long fake_pselect(long a, long b, long c, long d, long e, const sigset_t *mask)
{
    return CALLED(pselect, a, b, c, d, e, word_of(mask));
}

long fake_epoll_pwait(long a, long b, long c, long d, const sigset_t *mask)
{
    return CALLED(epoll_pwait, a, b, c, d, word_of(mask));
}

long fake_epoll_pwait2(long a, long b, long c, long d, const sigset_t *mask)
{
    return CALLED(epoll_pwait2, a, b, c, d, word_of(mask));
}

long fake_sigsuspend(const sigset_t *mask)
{
    return CALLED(sigsuspend, word_of(mask));
}

long fake_sigtimedwait(const sigset_t *mask, long b, long c)
{
    return CALLED(sigtimedwait, word_of(mask), b, c);
}

/* --- the rest of the room
 * ----------------------------------------------------------------------------------------------- */

/* No thread may block the highest signal of this test. */
uint64_t ect_action_mask(uint64_t mask)
{
    return mask & ~0x100ull;
}

long ect_raw_pass(const ect_raw_call_t *call)
{
    return CALLED(pass, call->a[0], call->a[1], call->a[2], call->a[3], call->a[4], call->number == SYS_waitid);
}

bool ect_raw_find(const ect_raw_entry_t *table, size_t count, const ect_raw_call_t *call, long *result)
{
    for (size_t i = 0; i < count; i++) {
        if (table[i].number != call->number)
            continue;
        *result = table[i].make(call->a);
        return true;
    }
    return false;
}

void ect_raw_hide_vdso(ElfW(auxv_t) * vector)
{
    vector->a_type = AT_IGNORE;
    CALLED(hide);
}

/* --- tests
 * ---------------------------------------------------------------------------------------------------------------- */

enum { A = 11, B, C, D, E, F, MASK = 0x101 };

typedef struct row {
    long number;
    const char *name, *calls;
    size_t mask_at; /* argument that is a mask's address; NO_MASK */
} row_t;

enum { NO_MASK = 9 };

static const row_t rows[] = {
    {SYS_clock_gettime, "clock_gettime", "clock_gettime(11,12) ", NO_MASK},
    {SYS_gettimeofday, "gettimeofday", "gettimeofday(11,12) ", NO_MASK},
    {SYS_time, "time", "time(11) ", NO_MASK},
    {SYS_nanosleep, "nanosleep", "nanosleep(11,12) ", NO_MASK},
    {SYS_poll, "poll", "poll(11,12,13) ", NO_MASK},
    {SYS_ppoll, "ppoll", "ppoll(11,12,13,1) ", 3},
    {SYS_select, "select", "select(11,12,13,14,15) ", NO_MASK},
    {SYS_epoll_wait, "epoll_wait", "epoll_wait(11,12,13,14) ", NO_MASK},
    {SYS_epoll_pwait, "epoll_pwait", "epoll_pwait(11,12,13,14,1) ", 4},
    {SYS_epoll_pwait2, "epoll_pwait2", "epoll_pwait2(11,12,13,14,1) ", 4},
    {SYS_timerfd_create, "timerfd_create", "timerfd_create(11,12) ", NO_MASK},
    {SYS_timerfd_settime, "timerfd_settime", "timerfd_settime(11,12,13,14) ", NO_MASK},
    {SYS_timerfd_gettime, "timerfd_gettime", "timerfd_gettime(11,12) ", NO_MASK},
    {SYS_setitimer, "setitimer", "setitimer(11,12,13) ", NO_MASK},
    {SYS_getitimer, "getitimer", "getitimer(11,12) ", NO_MASK},
    {SYS_pause, "pause", "pause() ", NO_MASK},
    {SYS_rt_sigsuspend, "sigsuspend", "sigsuspend(1) ", 0},
    {SYS_rt_sigtimedwait, "sigtimedwait", "sigtimedwait(1,12,13) ", 0},
    {SYS_wait4, "wait4", "wait4(11,12,13,14) ", NO_MASK},
    {SYS_futex, "syscall", "syscall(11,12,13,14,15,16) ", NO_MASK},
};

static long result_of(long number, const long *a)
{
    ect_raw_call_t call = {.number = number};
    long result = 1234;
    memcpy(call.a, a, sizeof call.a);
    assert_true(ect_raw_on_clock(&call, &result));
    return result;
}

static void passes_every_argument(void **state)
{
    const uint64_t mask = MASK;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        long a[] = {A, B, C, D, E, F};
        if (rows[i].mask_at != NO_MASK)
            a[rows[i].mask_at] = (long)&mask;
        plan(rows[i].name, 42, 0);
        assert_int_equal(result_of(rows[i].number, a), 42);
        EXPECT_CALLS(rows[i].name, rows[i].calls);
        plan(rows[i].name, -1, EPIPE);
        assert_int_equal(result_of(rows[i].number, a), -EPIPE);
        forget_calls();
    }
}

static void passes_calls_without_a_mask(void **state)
{
    const long a[] = {A, B, C, 0, 0, 0};
    (void)state;
    (void)result_of(SYS_ppoll, a);
    (void)result_of(SYS_epoll_pwait, a);
    EXPECT_CALLS("no mask", "ppoll(11,12,13,-1) epoll_pwait(11,12,13,0,-1) ");
}

static void selects_with_each_mask(void **state)
{
    const uint64_t mask = MASK;
    const long pairs[][2] = {{(long)&mask, sizeof mask}, {0, sizeof mask}};
    long a[] = {A, B, C, D, E, 0};
    (void)state;
    (void)result_of(SYS_pselect6, a);
    EXPECT_CALLS("no pair", "pselect(11,12,13,14,15,-1) ");
    a[5] = (long)pairs[0];
    (void)result_of(SYS_pselect6, a);
    EXPECT_CALLS("a mask", "pselect(11,12,13,14,15,1) ");
    a[5] = (long)pairs[1];
    plan("pselect", -1, EBADF);
    assert_int_equal(result_of(SYS_pselect6, a), -EBADF);
    EXPECT_CALLS("no mask", "pselect(11,12,13,14,15,-1) ");
}

/* These functions return an error number, or have no errors. */
static void returns_results_of_other_kinds(void **state)
{
    const long a[] = {A, B, C, D, 0, F};
    const long usage[] = {A, B, C, D, E, F};
    (void)state;
    plan("clock_nanosleep", EINTR, 0);
    assert_int_equal(result_of(SYS_clock_nanosleep, a), -EINTR);
    plan("alarm", 7, 0);
    assert_int_equal(result_of(SYS_alarm, a), 7);
    plan("sched_yield", 0, 0);
    assert_int_equal(result_of(SYS_sched_yield, a), 0);
    EXPECT_CALLS("calls", "clock_nanosleep(11,12,13,14) alarm(11) sched_yield() ");
    plan("waitid", -1, ECHILD);
    assert_int_equal(result_of(SYS_waitid, a), -ECHILD);
    EXPECT_CALLS("waitid", "waitid(11,12,13,14) ");
    plan("pass", 9, 0);
    assert_int_equal(result_of(SYS_waitid, usage), 9);
    EXPECT_CALLS("with usage", "pass(11,12,13,14,15,1) ");
}

static void leaves_other_calls(void **state)
{
    const ect_raw_call_t call = {.number = SYS_getpid};
    const ect_raw_call_t file = {.number = SYS_openat, .a = {AT_FDCWD, (long)"/proc/self/auxw"}};
    const ect_raw_call_t another = {.number = SYS_readlinkat, .a = {AT_FDCWD, (long)"/proc/self/auxv"}};
    long result = 5;
    (void)state;
    assert_false(ect_raw_on_clock(&call, &result));
    assert_false(ect_raw_on_clock(&file, &result));
    assert_false(ect_raw_on_clock(&another, &result));
    assert_int_equal(result, 5);
    EXPECT_CALLS("none", "");
}

/* --- the auxiliary vector, as a file
 * -------------------------------------------------------------------------------------- */

enum { VECTOR = 3 * sizeof(ElfW(auxv_t)) };

static void opens_the_vector(void **state)
{
    char want[128];
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        const long a[] = {AT_FDCWD, (long)"/proc/self/auxv", i == 0 ? O_RDONLY : O_RDONLY | O_CLOEXEC, 0, 0, 0};
        memset(written, 0x55, sizeof written);
        plan("open", 0, 0); /* any number is a descriptor */
        plan("read", VECTOR, 0);
        plan("memfd_create", 0, 0);
        plan("write", VECTOR, 0);
        assert_int_equal(result_of(SYS_openat, a), 0);
        snprintf(want, sizeof want, "open(%d) read(0) close(0) memfd_create(%d) hide() write(0,%zu) lseek(0,0,%d) ",
                 O_RDONLY | O_CLOEXEC, i == 0 ? 0 : MFD_CLOEXEC, (size_t)VECTOR, SEEK_SET);
        EXPECT_CALLS("open", want);
        ElfW(auxv_t) first;
        memcpy(&first, written, sizeof first);
        assert_int_equal(first.a_type, AT_IGNORE);
        assert_int_equal(written[VECTOR], 0x55);
    }
}

static void fails_without_the_vector(void **state)
{
    const long a[] = {AT_FDCWD, (long)"/proc/self/auxv", O_RDONLY, 0, 0, 0};
    char want[96];
    (void)state;
    plan("open", -1, EMFILE);
    assert_int_equal(result_of(SYS_openat, a), -EMFILE);
    snprintf(want, sizeof want, "open(%d) ", O_RDONLY | O_CLOEXEC);
    EXPECT_CALLS("open", want);
    plan("open", 6, 0);
    plan("read", -1, EIO);
    assert_int_equal(result_of(SYS_openat, a), -EIO);
    snprintf(want, sizeof want, "open(%d) read(6) close(6) ", O_RDONLY | O_CLOEXEC);
    EXPECT_CALLS("read", want);
    plan("open", 6, 0);
    plan("read", VECTOR, 0);
    plan("memfd_create", -1, ENFILE);
    assert_int_equal(result_of(SYS_openat, a), -ENFILE);
    snprintf(want, sizeof want, "open(%d) read(6) close(6) memfd_create(0) ", O_RDONLY | O_CLOEXEC);
    EXPECT_CALLS("memfd_create", want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("A replaced function gets every argument and returns the kernel's result", passes_every_argument),
        TEST("A call without a mask has none", passes_calls_without_a_mask),
        TEST("pselect6 has a pair, a mask or neither", selects_with_each_mask),
        TEST("Results of other kinds are the kernel's, too", returns_results_of_other_kinds),
        TEST("Other calls do not concern the clock", leaves_other_calls),
        TEST("/proc/self/auxv has no vDSO", opens_the_vector),
        TEST("/proc/self/auxv may fail to open", fails_without_the_vector),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
