/* SPDX-License-Identifier: MIT */
/* Waits for child processes: the virtual clock is stopped until the real call does not block. */
#define _GNU_SOURCE
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/threads.h"
#include "fakes.h"

OURS(waitpid);
OURS(wait4);
OURS(wait);
OURS(waitid);

static bool running;     /* the process has a bus */
static int looks_before; /* looks that find no child, before one finds a child */
static ect_wait_t end_of_wait;
static bool looks_at_end; /* the wait for a process ends with a look */

/* Fakes. A call of waitid() with WNOWAIT neither waits nor takes the child. */

static int fake_waitid(idtype_t kind, id_t id, siginfo_t *info, int options)
{
    long result = CALLED(waitid, kind, id, options);
    if (info && (options & WNOWAIT) != 0 && result == 0)
        info->si_pid = looks_before-- > 0 ? 0 : 77;
    return (int)result;
}

static pid_t fake_waitpid(pid_t pid, int *status, int options)
{
    return (pid_t)CALLED(waitpid, pid, (long)status, options);
}

static pid_t fake_wait4(pid_t pid, int *status, int options, struct rusage *usage)
{
    return (pid_t)CALLED(wait4, pid, (long)status, options, (long)usage);
}

static pid_t fake_wait(int *status)
{
    return (pid_t)CALLED(wait, (long)status);
}

FAKES(FAKE(waitid), FAKE(waitpid), FAKE(wait4), FAKE(wait))

pid_t fake_getpgrp(void);
pid_t fake_getpgrp(void)
{
    return 33;
}

bool ect_bus_running(void)
{
    return running;
}

uint64_t ect_virtual_now(void)
{
    return 1000;
}

ect_wait_t ect_virtual_wait_for_process(bool (*ready)(void *arg), void *arg, const char *call, uint64_t until_ns)
{
    char name[32];
    snprintf(name, sizeof name, "stop for %.*s", (int)strcspn(call, "("), call);
    fake_call(name, (const long[]){(long)until_ns}, 1);
    if (looks_at_end)
        CALLED(look, ready(arg));
    return end_of_wait;
}

static int begin(void **state)
{
    running = true;
    looks_before = 0;
    end_of_wait = ECT_WAIT_WOKEN;
    looks_at_end = true;
    return begin_fakes(state);
}

enum { LOOK = WEXITED | WNOHANG | WNOWAIT };

#define EXPECT(title, ...)                                                                                             \
    do {                                                                                                               \
        char want[256];                                                                                                \
        snprintf(want, sizeof want, __VA_ARGS__);                                                                      \
        EXPECT_CALLS(title, want);                                                                                     \
    } while (0)

static void waits_for_each_kind(void **state)
{
    static const struct {
        pid_t pid;
        idtype_t kind;
        id_t id;
    } rows[] = {{12, P_PID, 12}, {1, P_PID, 1}, {-1, P_ALL, 0}, {0, P_PGID, 33}, {-12, P_PGID, 12}, {-2, P_PGID, 2}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        plan("waitpid", 5, 0);
        assert_int_equal(ours_waitpid(rows[i].pid, NULL, 0), 5);
        EXPECT("waitpid", "waitid(%d,%u,%d) waitpid(%d,0,0) ", rows[i].kind, rows[i].id, LOOK, rows[i].pid);
    }
}

static void waits_as_the_options_say(void **state)
{
    static const struct {
        int options, looks;
    } rows[] = {{WUNTRACED, LOOK | WSTOPPED},
                {WCONTINUED, LOOK | WCONTINUED},
                {WNOHANG, LOOK},
                {WUNTRACED | WCONTINUED, LOOK | WSTOPPED | WCONTINUED}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        (void)ours_waitpid(12, NULL, rows[i].options);
        EXPECT("waitpid", "waitid(%d,12,%d) waitpid(12,0,%d) ", P_PID, rows[i].looks, rows[i].options);
    }
    (void)ours_waitid(P_PID, 12, NULL, WSTOPPED | WNOWAIT);
    EXPECT("waitid", "waitid(%d,12,%d) waitid(%d,12,%d) ", P_PID, WSTOPPED | WNOHANG | WNOWAIT, P_PID,
           WSTOPPED | WNOWAIT);
}

/* A call that does not wait lets one nanosecond pass, so that a loop of such calls ends. */
static void stops_time_meanwhile(void **state)
{
    siginfo_t info = {0};
    (void)state;
    looks_before = 1;
    plan("wait4", 5, 0);
    assert_int_equal(ours_wait4(12, NULL, 0, NULL), 5);
    EXPECT("wait4", "waitid(%d,12,%d) stop for wait4(-1) waitid(%d,12,%d) look(1) wait4(12,0,0,0) ", P_PID, LOOK, P_PID,
           LOOK);
    looks_before = 1;
    (void)ours_wait4(12, NULL, WNOHANG, NULL);
    EXPECT("at once", "waitid(%d,12,%d) stop for wait4(1001) waitid(%d,12,%d) look(1) wait4(12,0,%d,0) ", P_PID, LOOK,
           P_PID, LOOK, WNOHANG);
    looks_before = 1;
    plan("wait", 6, 0);
    assert_int_equal(ours_wait(NULL), 6);
    EXPECT("wait", "waitid(%d,0,%d) stop for wait(-1) waitid(%d,0,%d) look(1) wait(0) ", P_ALL, LOOK, P_ALL, LOOK);
    looks_before = 2;
    plan("waitid", 0, 0);
    plan("waitid", 0, 0);
    plan("waitid", -1, ECHILD);
    assert_int_equal(ours_waitid(P_ALL, 3, &info, WEXITED), -1);
    EXPECT("waitid", "waitid(%d,3,%d) stop for waitid(-1) waitid(%d,3,%d) look(0) waitid(%d,3,%d) ", P_ALL, LOOK, P_ALL,
           LOOK, P_ALL, WEXITED);
}

static void reports_errors_at_once(void **state)
{
    (void)state;
    looks_before = 1;
    plan("waitid", -1, ECHILD);
    plan("waitpid", -1, ECHILD);
    assert_int_equal(ours_waitpid(12, NULL, 0), -1);
    EXPECT("no such child", "waitid(%d,12,%d) waitpid(12,0,0) ", P_PID, LOOK);
}

/* A child that has ended beside the handler is worth more than the handler. */
static void ends_with_a_handler(void **state)
{
    static const struct {
        int looks;
        bool ended;
    } rows[] = {{2, false}, {1, true}};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        for (unsigned int call = 0; call < 4; call++) {
            siginfo_t info;
            looks_before = rows[i].looks;
            looks_at_end = false;
            end_of_wait = ECT_WAIT_INTERRUPTED;
            errno = 0;
            long result = call == 0   ? ours_waitpid(12, NULL, 0)
                          : call == 1 ? ours_wait4(12, NULL, 0, NULL)
                          : call == 2 ? ours_wait(NULL)
                                      : ours_waitid(P_PID, 12, &info, WEXITED);
            assert_int_equal(result, rows[i].ended ? 0 : -1);
            assert_int_equal(errno, rows[i].ended ? 0 : EINTR);
            forget_calls();
        }
    }
}

static void leaves_others_alone(void **state)
{
    (void)state;
    running = false;
    looks_before = 1;
    (void)ours_waitpid(12, NULL, 0);
    EXPECT_CALLS("without a bus", "waitpid(12,0,0) ");
    running = true;
    ect_inside = 1;
    (void)ours_waitpid(12, NULL, 0);
    EXPECT_CALLS("of the library", "waitpid(12,0,0) ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A process id names a process, all, or a group", waits_for_each_kind, begin, NULL, NULL},
        {"The options select ends, stops and continuations", waits_as_the_options_say, begin, NULL, NULL},
        {"Time is stopped until a child has changed", stops_time_meanwhile, begin, NULL, NULL},
        {"A wait for no child fails at once", reports_errors_at_once, begin, NULL, NULL},
        {"A handler of a signal ends a wait with EINTR", ends_with_a_handler, begin, NULL, NULL},
        {"A process without a bus, and the library itself, wait as usual", leaves_others_alone, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
