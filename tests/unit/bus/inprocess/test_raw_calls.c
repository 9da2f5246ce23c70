/* SPDX-License-Identifier: MIT */
/* Direct system calls reach the replaced functions with all their arguments, unless the kernel refuses an address. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/syscall.h>

#include "bus/inprocess/raw.h"
#include "fakes.h"

static ect_raw_route_t *route;
static int argument_count; /* of the constructor */
static long unreadable;    /* an address */
static size_t checked;     /* bytes of the newest check */
static bool on_clock;
static ect_raw_call_t made; /* the newest call */

/* --- the functions that the room replaces ---------------------------------------------------------------------------
 */

FAKE_3(socket)
FAKE_3(bind)
FAKE_5(setsockopt)
FAKE_5(getsockopt)
FAKE_3(getsockname)
FAKE_3(ioctl)
FAKE_6(sendto)
FAKE_3(sendmsg)
FAKE_4(sendmmsg)
FAKE_3(write)
FAKE_3(writev)
FAKE_6(recvfrom)
FAKE_3(recvmsg)
FAKE_5(recvmmsg)
FAKE_3(read)
FAKE_3(readv)
FAKE_3(accept)
FAKE_4(accept4)
FAKE_1(close)
FAKE_1(dup)
FAKE_2(dup2)
FAKE_3(dup3)
FAKE_3(fcntl)
FAKE_3(open)
FAKE_4(openat)
FAKE_4(fstatat)
FAKE_4(readlinkat)

/* --- the rest of the room
 * --------------------------------------------------------------------------------------------- */

/* Called before main(). */
void ect_raw_begin(ect_raw_route_t *its, int argc, char **argv)
{
    route = its;
    argument_count = argv && argv[0] && !argv[argc] ? argc : -1;
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

bool ect_raw_on_clock(const ect_raw_call_t *call, long *result)
{
    if (on_clock)
        *result = CALLED(on_clock, call->a[0]);
    return on_clock;
}

/* access() is the check of a path. */
long ect_raw_pass(const ect_raw_call_t *call)
{
    if (call->number == SYS_access) {
        assert_int_equal(call->a[1], F_OK);
        return call->a[0] == unreadable ? -EFAULT : -ENOENT;
    }
    made = *call;
    return CALLED(pass, call->number == made.number);
}

bool ect_raw_can_read(long address, size_t length)
{
    if (address == unreadable)
        checked = length;
    return address != unreadable;
}

static int begin(void **state)
{
    unreadable = -1;
    checked = 0;
    on_clock = false;
    return begin_fakes(state);
}

/* --- tests
 * ------------------------------------------------------------------------------------------------------------ */

enum { A = 11, B, C, D, E, F };

static void passes_every_argument(void **state)
{
    static const struct {
        long number;
        const char *name, *calls;
    } rows[] = {
        {SYS_socket, "socket", "socket(11,12,13) "},
        {SYS_bind, "bind", "bind(11,12,13) "},
        {SYS_setsockopt, "setsockopt", "setsockopt(11,12,13,14,15) "},
        {SYS_getsockopt, "getsockopt", "getsockopt(11,12,13,14,15) "},
        {SYS_getsockname, "getsockname", "getsockname(11,12,13) "},
        {SYS_ioctl, "ioctl", "ioctl(11,12,13) "},
        {SYS_sendto, "sendto", "sendto(11,12,13,14,15,16) "},
        {SYS_sendmsg, "sendmsg", "sendmsg(11,12,13) "},
        {SYS_sendmmsg, "sendmmsg", "sendmmsg(11,12,13,14) "},
        {SYS_write, "write", "write(11,12,13) "},
        {SYS_writev, "writev", "writev(11,12,13) "},
        {SYS_recvfrom, "recvfrom", "recvfrom(11,12,13,14,15,16) "},
        {SYS_recvmsg, "recvmsg", "recvmsg(11,12,13) "},
        {SYS_recvmmsg, "recvmmsg", "recvmmsg(11,12,13,14,15) "},
        {SYS_read, "read", "read(11,12,13) "},
        {SYS_readv, "readv", "readv(11,12,13) "},
        {SYS_accept, "accept", "accept(11,12,13) "},
        {SYS_accept4, "accept4", "accept4(11,12,13,14) "},
        {SYS_close, "close", "close(11) "},
        {SYS_dup, "dup", "dup(11) "},
        {SYS_dup2, "dup2", "dup2(11,12) "},
        {SYS_dup3, "dup3", "dup3(11,12,13) "},
        {SYS_fcntl, "fcntl", "fcntl(11,12,13) "},
        {SYS_open, "open", "open(11,12,13) "},
        {SYS_openat, "openat", "openat(11,12,13,14) "},
        {SYS_newfstatat, "fstatat", "fstatat(11,12,13,14) "},
        {SYS_readlinkat, "readlinkat", "readlinkat(11,12,13,14) "},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const ect_raw_call_t call = {.number = rows[i].number, .a = {A, B, C, D, E, F}};
        plan(rows[i].name, 42, 0);
        assert_int_equal(route(&call), 42);
        EXPECT_CALLS(rows[i].name, rows[i].calls);
        plan(rows[i].name, -1, EPIPE);
        assert_int_equal(route(&call), -EPIPE);
        EXPECT_CALLS(rows[i].name, rows[i].calls);
    }
}

static void passes_other_calls_to_the_kernel(void **state)
{
    const ect_raw_call_t call = {.number = SYS_getpid, .a = {A, B, C, D, E, F}};
    (void)state;
    plan("pass", 77, 0);
    assert_int_equal(route(&call), 77);
    assert_int_equal(made.number, SYS_getpid);
    assert_int_equal(made.a[5], F);
    on_clock = true;
    plan("on_clock", 78, 0);
    assert_int_equal(route(&call), 78);
    EXPECT_CALLS("calls", "pass(1) on_clock(11) ");
}

/* The kernel refuses such a call itself. */
static void leaves_bad_addresses_to_the_kernel(void **state)
{
    enum { BAD = 99, MASK = 8, TIME = 16, TIMES = 32 };
    static const struct {
        const char *name;
        long number;
        size_t at, size; /* 0: of a path */
        bool required;
    } rows[] = {
        {"open", SYS_open, 0, 0, true},
        {"openat", SYS_openat, 1, 0, true},
        {"newfstatat", SYS_newfstatat, 1, 0, true},
        {"readlinkat", SYS_readlinkat, 1, 0, true},
        {"ppoll, mask", SYS_ppoll, 3, MASK, false},
        {"ppoll, time", SYS_ppoll, 2, TIME, false},
        {"epoll_pwait", SYS_epoll_pwait, 4, MASK, false},
        {"epoll_pwait2, mask", SYS_epoll_pwait2, 4, MASK, false},
        {"epoll_pwait2, time", SYS_epoll_pwait2, 3, TIME, false},
        {"rt_sigsuspend", SYS_rt_sigsuspend, 0, MASK, false},
        {"rt_sigtimedwait, mask", SYS_rt_sigtimedwait, 0, MASK, false},
        {"rt_sigtimedwait, time", SYS_rt_sigtimedwait, 2, TIME, false},
        {"nanosleep", SYS_nanosleep, 0, TIME, true},
        {"clock_nanosleep", SYS_clock_nanosleep, 2, TIME, true},
        {"timerfd_settime", SYS_timerfd_settime, 2, TIMES, true},
        {"select, time", SYS_select, 4, TIME, false},
        {"select, 1", SYS_select, 1, 1, false},
        {"select, 2", SYS_select, 2, 1, false},
        {"select, 3", SYS_select, 3, 1, false},
        {"pselect6, time", SYS_pselect6, 4, TIME, false},
        {"pselect6, 1", SYS_pselect6, 1, 1, false},
        {"pselect6, 2", SYS_pselect6, 2, 1, false},
        {"pselect6, 3", SYS_pselect6, 3, 1, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (unsigned int kind = 0; kind < 3; kind++) { /* good, bad, 0 */
            ect_raw_call_t call = {.number = rows[i].number, .a = {A, B, C, D, E, 0}};
            call.a[rows[i].at] = kind == 0 ? A : kind == 1 ? BAD : 0;
            unreadable = kind == 2 ? 0 : BAD;
            checked = 0;
            on_clock = true; /* else the call is made */
            (void)route(&call);
            bool is_bad = kind == 1 || (kind == 2 && rows[i].required);
            if (strcmp(fakes.log, is_bad ? "pass(1) " : "on_clock(11) ") != 0 && (is_bad || !strstr(fakes.log, "on_")))
                fail_msg("%s: address %ld: %s", rows[i].name, call.a[rows[i].at], fakes.log);
            if (is_bad)
                assert_int_equal(checked, rows[i].size);
            if (is_bad)
                assert_int_equal(made.number, rows[i].number);
            forget_calls();
        }
    }
}

/* The sixth argument of pselect6 points to the address of a mask. */
static void checks_the_mask_of_pselect(void **state)
{
    enum { BAD = 99 };
    static const long pairs[][2] = {{0, 8}, {A, 8}, {BAD, 8}};
    (void)state;
    on_clock = true;
    for (size_t i = 0; i < 3; i++) {
        const ect_raw_call_t call = {.number = SYS_pselect6, .a = {1, 0, 0, 0, 0, (long)pairs[i]}};
        unreadable = i == 0 ? 0 : BAD;
        (void)route(&call);
        EXPECT_CALLS("a pair", i == 2 ? "pass(1) " : "on_clock(1) ");
    }
    assert_int_equal(checked, 8);
    const ect_raw_call_t bad = {.number = SYS_pselect6, .a = {1, 0, 0, 0, 0, (long)pairs[1]}};
    unreadable = (long)pairs[1];
    (void)route(&bad);
    EXPECT_CALLS("a bad pair", "pass(1) ");
    assert_int_equal(checked, 16);
    const ect_raw_call_t none = {.number = SYS_pselect6, .a = {1}};
    unreadable = 0;
    (void)route(&none);
    EXPECT_CALLS("none", "on_clock(1) ");
    const ect_raw_call_t another = {.number = SYS_sendto, .a = {1, 2, 3, 4, 5, (long)pairs[2]}};
    unreadable = BAD;
    (void)route(&another);
    EXPECT_CALLS("another call", "on_clock(1) ");
}

static void begins_with_the_program(void **state)
{
    (void)state;
    assert_int_equal(argument_count, 1);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"The route is set before main(), from the arguments of the program", begins_with_the_program, begin, NULL,
         NULL},
        {"A replaced function gets every argument and returns the kernel's result", passes_every_argument, begin, NULL,
         NULL},
        {"Other calls go to the kernel", passes_other_calls_to_the_kernel, begin, NULL, NULL},
        {"A call with a bad address goes to the kernel", leaves_bad_addresses_to_the_kernel, begin, NULL, NULL},
        {"The mask of pselect6 is checked, too", checks_the_mask_of_pselect, begin, NULL, NULL},
    };
    argument_count -= argc - 1; /* a filter of test titles is an argument */
    (void)argv;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
