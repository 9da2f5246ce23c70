/* SPDX-License-Identifier: MIT */
/* Threads in /proc/self/task, whose files are the test's. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "bus/inprocess/tasks.h"
#include "fakes.h"

static const char *text; /* of the file; NULL: it cannot be opened */
static const char *path;
static bool fails; /* a read */

static int fake_open(const char *its, int flags, ...)
{
    assert_string_equal(its, path);
    assert_int_equal(flags, O_RDONLY | O_CLOEXEC);
    CALLED(open);
    return text ? 0 : -1; /* any number is a descriptor */
}

static ssize_t fake_read(int fd, void *data, size_t size)
{
    CALLED(read, fd);
    size_t length = strlen(text) < size ? strlen(text) : size;
    memcpy(data, text, length);
    return fails ? -1 : (ssize_t)length;
}

static int fake_close(int fd)
{
    CALLED(close, fd);
    return 0;
}

FAKES(FAKE(open), FAKE(read), FAKE(close))

static int begin(void **state)
{
    fails = false;
    text = NULL;
    return begin_fakes(state);
}

static void sleeps(void **state)
{
    static const struct {
        const char *text;
        bool sleeps;
    } rows[] = {{"7 (a) S 1 2", true},
                {"7 (a) R 1 2", false},
                {"7 (a) S) R 1", false},
                {"7 (b) R) S 1", true},
                {"7 (a)S S 1", false},
                {"7 without", false},
                {"", false},
                {NULL, false}};
    (void)state;
    path = "/proc/self/task/7/stat";
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        text = rows[i].text;
        if (ect_task_sleeps(7) != rows[i].sleeps)
            fail_msg("%s", text ? text : "no file");
        EXPECT_CALLS("file", text ? "open() read(0) close(0) " : "open() ");
    }
    text = "7 (a) S 1 2";
    fails = true;
    assert_false(ect_task_sleeps(7));
    forget_calls();
}

/* A line longer than the buffer is read in part. */
static void reads_a_part(void **state)
{
    static char longer[1000];
    (void)state;
    memset(longer, 'x', sizeof longer - 1);
    memcpy(longer + 250, ") S ", 4);
    path = "/proc/self/task/7/stat";
    text = longer;
    assert_true(ect_task_sleeps(7));
    memset(longer + 250, 'x', 4);
    memcpy(longer + 252, ") S ", 4);
    assert_true(ect_task_sleeps(7));
    memset(longer + 252, 'x', 4);
    memcpy(longer + 253, ") S ", 4);
    assert_false(ect_task_sleeps(7));
    forget_calls();
}

static void names_a_call(void **state)
{
    static const struct {
        long number;
        const char *name;
    } rows[] = {{SYS_wait4, "wait4()"},       {SYS_waitid, "waitid()"},   {SYS_read, "read()"},
                {SYS_write, "write()"},       {SYS_futex, "futex()"},     {SYS_connect, "connect()"},
                {SYS_recvfrom, "recvfrom()"}, {SYS_recvmsg, "recvmsg()"}, {SYS_sendto, "sendto()"},
                {SYS_sendmsg, "sendmsg()"},   {SYS_flock, "flock()"},     {SYS_fcntl, "fcntl()"},
                {4000, "system call 4000"},   {-1, "system call -1"}};
    char name[ECT_TASK_CALL], line[64];
    (void)state;
    path = "/proc/self/task/8/syscall";
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        snprintf(line, sizeof line, "%ld 0x1 0x2", rows[i].number);
        text = line;
        assert_string_equal(ect_task_call(8, name), rows[i].name);
    }
    text = "running";
    assert_string_equal(ect_task_call(8, name), "a system call");
    text = NULL;
    assert_string_equal(ect_task_call(8, name), "a system call");
    forget_calls();
}

static void blocks_signals(void **state)
{
    static const struct {
        const char *text;
        int number;
        bool blocks;
    } rows[] = {{"Name:\ta\nSigBlk:\t0000000000000001\nSigIgn:\t0000000000000002\n", 1, true},
                {"Name:\ta\nSigBlk:\t0000000000000001\nSigIgn:\t0000000000000002\n", 2, false},
                {"Name:\ta\nSigBlk:\t8000000000000000\n", 64, true},
                {"Name:\ta\nSigBlk:\t8000000000000000\n", 63, false},
                {"Name:\ta\nSigBlk:\t0000000000001000\n", 13, true},
                {"Name:\tSigBlk:\t1\n", 2, true},
                {NULL, 2, true}};
    (void)state;
    path = "/proc/self/task/9/status";
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        text = rows[i].text;
        if (ect_task_blocks(9, rows[i].number) != rows[i].blocks)
            fail_msg("%s", text ? text : "no file");
    }
    forget_calls();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A thread sleeps in state S, behind a name with any letters", sleeps, begin, NULL, NULL},
        {"The first 255 bytes of a file are read", reads_a_part, begin, NULL, NULL},
        {"The call of a thread has a name or a number", names_a_call, begin, NULL, NULL},
        {"A thread blocks the signals of its mask; one that has ended blocks all", blocks_signals, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
