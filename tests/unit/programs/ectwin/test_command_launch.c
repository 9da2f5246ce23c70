/* SPDX-License-Identifier: MIT */
/* The start of CMD (programs/ectwin/launch.c): interfaces in its words and its environment, the reason when it does not
 * start. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "launch.h"

enum { WORDS = 6, TEXT = 512 };

#define LONGEST "abcdefghijklmno" /* a name of an interface has at most 15 characters */

/* @return the exit status, and the output of standard output and standard error */
static int run(const char *const words[WORDS], const char *const masters[ECT_ENDS], const char *socket, char *text)
{
    int ends[2], status;
    size_t used = 0;
    ssize_t got;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        char *copy[WORDS + 1] = {NULL};
        for (size_t i = 0; i < WORDS && words[i]; i++)
            copy[i] = strdup(words[i]);
        (void)dup2(ends[1], STDOUT_FILENO);
        (void)dup2(ends[1], STDERR_FILENO);
        close(ends[0]);
        close(ends[1]);
        unsetenv("ECTWIN_IFACE");
        unsetenv("ECTWIN_IFACE2");
        unsetenv("ECTWIN_SOCKET");
        signal(SIGPIPE, SIG_IGN);
        launch("who", copy, masters, socket);
    }
    close(ends[1]);
    while (used + 1 < TEXT && (got = read(ends[0], text + used, TEXT - 1 - used)) > 0)
        used += (size_t)got;
    text[used] = '\0';
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status);
}

static void words(void **state)
{
    static const struct {
        const char *words[WORDS], *masters[ECT_ENDS];
        int status;
        const char *text;
    } rows[] = {
        {{"echo", "{}", "a{}b{}", "{2}", "{"}, {"m0"}, 0, "m0 am0bm0 {2} {\n"},
        {{"echo", "{}", "{2}{}{2}", "}{", "{ }"}, {"m0", "m1"}, 0, "m0 m1m0m1 }{ { }\n"},
        {{"echo", "{}{}", "{}{}{2}"}, {LONGEST, LONGEST}, 0, LONGEST LONGEST " " LONGEST LONGEST LONGEST "\n"},
        {{"echo", "", "x"}, {"m0"}, 0, " x\n"},
        {{"echo"}, {"m0"}, 0, "\n"},
        {{"{}"},
         {"echo"},
         127,
         "who: cannot run '{}': No such file or directory\n"}, /* the program's name is as it is */
        {{"nosuch-command"}, {"m0"}, 127, "who: cannot run 'nosuch-command': No such file or directory\n"},
        {{"/dev/null"}, {"m0"}, 126, "who: cannot run '/dev/null': Permission denied\n"},
        {{"sh", "-c", "exit 9"}, {"m0"}, 9, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[TEXT];
        const int status = run(rows[i].words, rows[i].masters, NULL, text);
        if (status != rows[i].status || strcmp(text, rows[i].text) != 0)
            fail_msg("row %zu: expected %d, '%s', got %d, '%s'", i, rows[i].status, rows[i].text, status, text);
    }
}

static void environment(void **state)
{
    static const char *const print[WORDS] = {
        "sh", "-c", "echo \"${ECTWIN_IFACE-none} ${ECTWIN_IFACE2-none} ${ECTWIN_SOCKET-none}\""};
    static const struct {
        const char *masters[ECT_ENDS], *socket, *text;
    } rows[] = {
        {{"m0"}, NULL, "m0 none none\n"}, {{"m0", "m1"}, NULL, "m0 m1 none\n"}, {{"m0"}, "/run/s", "m0 none /run/s\n"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[TEXT];
        assert_int_equal(run(print, rows[i].masters, rows[i].socket, text), 0);
        assert_string_equal(text, rows[i].text);
    }
}

static void a_closed_pipe(void **state)
{
    static const char *const words[WORDS] = {"sh", "-c", "kill -PIPE $$; echo ignored"}, *const masters[ECT_ENDS] = {
                                                                                             "m0"};
    char text[TEXT];
    (void)state;
    assert_int_equal(run(words, masters, NULL, text), 256 + SIGPIPE);
    assert_string_equal(text, "");
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("{} and {2} in words of CMD are the interfaces; a CMD that does not start is 126 or 127", words),
        TEST("CMD has the interfaces and the socket in its environment", environment),
        TEST("SIGPIPE ends CMD", a_closed_pipe),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("The start of CMD", tests, NULL, NULL);
}
