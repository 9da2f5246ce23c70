/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Command lines of ectwin, each in a child of the test: no start of a program, and the test is the twin that the
 * command connects to.
 */
#ifndef TESTS_COMMAND_LINES_H
#define TESTS_COMMAND_LINES_H

#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "ectwin.h"

enum { COMMAND_WORDS = 16, COMMAND_TEXT = 16384, COMMAND_REPLIES = 6 };

typedef struct command_line {
    const char *line; /* words, separated by blanks; ' quotes blanks */
    int status;
    const char *text; /* expected on standard error, then on standard output */
    /* The twin at c.sock: the reply to each request, then the end of the connection; NULL: no twin. */
    const char *replies[COMMAND_REPLIES];
    const char *requests; /* expected, one a line; NULL: any */
    const char *table;    /* content of t.csv; NULL: no such file */
} command_line_t;

static inline int command_split(char *line, char **words)
{
    int count = 0;
    for (char *at = line; *at;) {
        const char end = *at == '\'' ? '\'' : ' ';
        at += end == '\'';
        assert_true(count < COMMAND_WORDS - 1);
        words[count++] = at;
        at = strchr(at, end) ? strchr(at, end) : at + strlen(at);
        if (*at)
            *at++ = '\0';
        at += strspn(at, " ");
    }
    words[count] = NULL;
    return count;
}

/* Does not return. */
static inline void command_child(const char *line, int error, int output, const ect_product_t *products, size_t count)
{
    char copy[COMMAND_TEXT], *words[COMMAND_WORDS];
    snprintf(copy, sizeof copy, "ectwin %s", line);
    const int number = command_split(copy, words);
    (void)dup2(error, STDERR_FILENO);
    (void)dup2(output, STDOUT_FILENO);
    close(error);
    close(output);
    exit(ectwin_main(number, words, products, count));
}

static inline int command_listen(void)
{
    const struct sockaddr_un address = {.sun_family = AF_UNIX, .sun_path = "c.sock"};
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    (void)unlink("c.sock");
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 1), 0);
    return fd;
}

/* Appends the bytes that wait at a descriptor. @return false: its end */
static inline bool command_take(int fd, char *text, size_t *used)
{
    const ssize_t got = read(fd, text + *used, COMMAND_TEXT - 1 - *used);
    if (got > 0)
        *used += (size_t)got;
    text[*used] = '\0';
    return got > 0;
}

/* The twin of a row, while the command runs. */
typedef struct command_twin {
    const char *const *replies; /* those that follow */
    size_t left;
    int listener, client;
    size_t asked;
} command_twin_t;

static inline void command_close(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

/* Takes a connection, or replies to the requests of the present one. The last reply ends the twin. */
static inline void command_serve(command_twin_t *twin, char *requests)
{
    const size_t before = twin->asked;
    if (twin->client < 0) {
        twin->client = accept(twin->listener, NULL, NULL);
        return;
    }
    bool more = command_take(twin->client, requests, &twin->asked);
    for (const char *end = requests + before; more && (end = strchr(end, '\n')); end++) {
        const char *reply = *twin->replies++;
        (void)send(twin->client, reply, strlen(reply), MSG_NOSIGNAL);
        more = --twin->left > 0;
    }
    if (!more)
        command_close(&twin->client);
    if (twin->left == 0)
        command_close(&twin->listener);
}

/* Runs a line to its end. @return its exit status; 256 and more: the signal that has ended it */
static inline int command_line_run(const command_line_t *row, const ect_product_t *products, size_t count, char *text,
                                   char *requests)
{
    int errors[2], outputs[2], status;
    char output[COMMAND_TEXT] = "";
    size_t used = 0, put = 0;
    command_twin_t twin = {.replies = row->replies, .listener = -1, .client = -1};
    while (twin.left < COMMAND_REPLIES && row->replies[twin.left])
        twin.left++;
    if (twin.left > 0)
        twin.listener = command_listen();
    text[0] = requests[0] = '\0';
    assert_int_equal(pipe(errors), 0);
    assert_int_equal(pipe(outputs), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        close(errors[0]);
        close(outputs[0]);
        command_child(row->line, errors[1], outputs[1], products, count);
    }
    close(errors[1]);
    close(outputs[1]);
    while (errors[0] >= 0 || outputs[0] >= 0) {
        struct pollfd fds[] = {{.fd = errors[0], .events = POLLIN},
                               {.fd = outputs[0], .events = POLLIN},
                               {.fd = twin.client < 0 ? twin.listener : twin.client, .events = POLLIN}};
        assert_true(poll(fds, 3, -1) > 0);
        if (fds[2].revents != 0)
            command_serve(&twin, requests);
        else if (fds[0].revents != 0 && !command_take(errors[0], text, &used))
            command_close(&errors[0]);
        else if (fds[1].revents != 0 && !command_take(outputs[0], output, &put))
            command_close(&outputs[0]);
    }
    command_close(&twin.client);
    command_close(&twin.listener);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(used + put < COMMAND_TEXT);
    memcpy(text + used, output, put + 1);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status);
}

/* The test works in a folder of its own. */
static char command_folder[] = "/tmp/ectwin-command-XXXXXX";

static inline int commands_begin(void **state)
{
    (void)state;
    return mkdtemp(command_folder) && chdir(command_folder) == 0 ? 0 : -1;
}

/* The folder must be empty. */
static inline int commands_end(void **state)
{
    (void)state;
    (void)unlink("c.sock");
    return rmdir(command_folder);
}

/* Removes information about the usage, which argp adds to each message of wrong usage. */
static inline void command_cut_help(char *text)
{
    static const char end[] = "more information.\n";
    char *help = strstr(text, "Try `");
    char *rest = help ? strstr(help, end) : NULL;
    if (rest)
        memmove(help, rest + strlen(end), strlen(rest + strlen(end)) + 1);
}

static inline void command_write_table(const char *table)
{
    FILE *file = fopen("t.csv", "w");
    assert_non_null(file);
    fputs(table, file);
    fclose(file);
}

static inline void command_expect(const command_line_t *row, const ect_product_t *products, size_t count)
{
    static char text[COMMAND_TEXT], requests[COMMAND_TEXT];
    if (row->table)
        command_write_table(row->table);
    const int status = command_line_run(row, products, count, text, requests);
    command_cut_help(text);
    (void)unlink("t.csv");
    if (status != row->status || strcmp(text, row->text) != 0 ||
        (row->requests && strcmp(requests, row->requests) != 0))
        fail_msg("ectwin %s:\nexpected status %d\n%s\nand requests\n%s\ngot status %d\n%s\nand requests\n%s", row->line,
                 row->status, row->text, row->requests ? row->requests : "(any)\n", status, text, requests);
}

#define COMMANDS_EXPECT(rows)                                                                                          \
    for (size_t row_ = 0; row_ < sizeof(rows) / sizeof(rows)[0]; row_++)                                               \
    command_expect(&(rows)[row_], NULL, 0)

#endif
