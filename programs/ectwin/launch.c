/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "launch.h"

#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Appends `length` characters if they fit with a terminator. */
static void append(char *to, size_t *used, size_t room, const char *from, size_t length)
{
    if (*used + length < room) {
        memcpy(to + *used, from, length);
        *used += length;
        to[*used] = 0;
    }
}

/* `text` with {} and {2} replaced by the names of the master's interfaces. @return NULL: no memory */
static char *with_interfaces(const char *text, const char *const masters[ECT_ENDS])
{
    static const char *const marks[ECT_ENDS] = {"{}", "{2}"};
    size_t room = strlen(text) * 8 + 1; /* "{}", 2 characters, becomes at most 15 */
    size_t used = 0;
    char *result = calloc(1, room);
    while (result && *text) {
        size_t wire = 0;
        while (wire < ECT_ENDS && !(masters[wire] && strncmp(text, marks[wire], strlen(marks[wire])) == 0))
            wire++;
        bool found = wire < ECT_ENDS;
        const char *piece = found ? masters[wire] : text;
        append(result, &used, room, piece, found ? strlen(piece) : 1);
        text += found ? strlen(marks[wire]) : 1;
    }
    return result;
}

_Noreturn void launch(const char *who, char **command, const char *const masters[ECT_ENDS], const char *socket)
{
    signal(SIGPIPE, SIG_DFL);
    setenv("ECTWIN_IFACE", masters[0], 1);
    if (masters[1])
        setenv("ECTWIN_IFACE2", masters[1], 1);
    if (socket)
        setenv("ECTWIN_SOCKET", socket, 1);
    for (char **argument = command + 1; *argument; argument++) {
        char *replaced = with_interfaces(*argument, masters);
        *argument = replaced ? replaced : *argument;
    }
    execvp(command[0], command);
    int error = errno;
    fprintf(stderr, "%s: cannot run '%s': %s\n", who, command[0], strerror(error));
    _exit(error == ENOENT ? LAUNCH_NOT_FOUND : LAUNCH_NOT_EXECUTABLE);
}
