/* SPDX-License-Identifier: MIT */
/* Direct system calls reach the replaced functions with all their arguments, unless the kernel refuses an address. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/syscall.h>

#include "bus/inprocess/raw.h"
#include "fakes.h"

static ect_raw_route_t *route;
static int argument_count; /* of the constructor */
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
FAKE_3(close_range)
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
    made = *call;
    return CALLED(pass, call->number == made.number);
}

static int begin(void **state)
{
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
        {SYS_close_range, "close_range", "close_range(11,12,13) "},
        {SYS_dup, "dup", "dup(11) "},
        {SYS_dup2, "dup2", "dup2(11,12) "},
        {SYS_dup3, "dup3", "dup3(11,12,13) "},
        {SYS_fcntl, "fcntl", "fcntl(11,12,13) "},
        /* with a path, which must be a good address */
        {SYS_open, "open", "open(%ld,12,13) "},
        {SYS_openat, "openat", "openat(11,%ld,13,14) "},
        {SYS_newfstatat, "fstatat", "fstatat(11,%ld,13,14) "},
        {SYS_readlinkat, "readlinkat", "readlinkat(11,%ld,13,14) "},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        static const char path[] = "path";
        const char *at = strstr(rows[i].calls, "%ld");
        char want[96];
        ect_raw_call_t call = {.number = rows[i].number, .a = {A, B, C, D, E, F}};
        if (at)
            call.a[at[-1] == ','] = (long)path;
        snprintf(want, sizeof want, "%.*s", at ? (int)(at - rows[i].calls) : 95, rows[i].calls);
        if (at)
            snprintf(want + strlen(want), sizeof want - strlen(want), "%ld%s", (long)path, at + 3);
        plan(rows[i].name, 42, 0);
        assert_int_equal(route(&call), 42);
        EXPECT_CALLS(rows[i].name, want);
        plan(rows[i].name, -1, EPIPE);
        assert_int_equal(route(&call), -EPIPE);
        EXPECT_CALLS(rows[i].name, want);
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
static void leaves_bad_paths_to_the_kernel(void **state)
{
    static const struct {
        const char *name;
        long number;
        size_t at;
    } rows[] = {{"open", SYS_open, 0},
                {"openat", SYS_openat, 1},
                {"newfstatat", SYS_newfstatat, 1},
                {"readlinkat", SYS_readlinkat, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ect_raw_call_t call = {.number = rows[i].number, .a = {A, B, C, D, E, 0}};
        call.a[rows[i].at] = (long)"path";
        on_clock = true; /* else the call is made */
        (void)route(&call);
        assert_true(strncmp(fakes.log, "on_clock(", 9) == 0);
        forget_calls();
        call.a[rows[i].at] = A;
        (void)route(&call);
        EXPECT_CALLS(rows[i].name, "pass(1) ");
        assert_int_equal(made.number, rows[i].number);
    }
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
        {"A call with a bad path goes to the kernel", leaves_bad_paths_to_the_kernel, begin, NULL, NULL},
    };
    argument_count -= argc - 1; /* a filter of test titles is an argument */
    (void)argv;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
