/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A connection to the control socket of a running twin (docs/CONTROL.md), and its replies made safe for a terminal.
 */
#ifndef ECTWIN_CONNECTION_H
#define ECTWIN_CONNECTION_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdio.h>

typedef struct connection connection_t;

/**
 * Connects to a named socket, or to the only running twin of this user. On failure prints cause and cure: other users'
 * twins if this user has none.
 * @param path  NULL: $ECTWIN_SOCKET, or a search. A socket found must be this user's own; a named one may also be
 * root's, and for root any user's
 * @param who   first word of messages
 * @return a connection to close with ::connection_close, or NULL
 */
connection_t *connection_open(const char *path, const char *who);

void connection_close(connection_t *connection);

/** The option that names the socket: a row of a command's options; its key is 's'. */
#define CONNECTION_OPTION                                                                                              \
    {                                                                                                                  \
        "socket",                                                                                                      \
        's',                                                                                                           \
        "PATH",                                                                                                        \
        0,                                                                                                             \
        "Control socket of the twin (default: $ECTWIN_SOCKET, or that of the only running twin)",                      \
        0}

/**
 * Sends a request, frees it, and passes each line of the reply to `print` (NULL: none) up to the last, the result.
 * @return EXIT_CLEAN · EXIT_USAGE: it was refused, or is longer than the protocol allows; the reason is printed ·
 *         EXIT_RUN: no reply, or standard output failed
 */
int connection_ask(connection_t *connection, cJSON *request, const char *who, void (*print)(const cJSON *line));

/**
 * After the reply to "watch": prints whole lines until the connection ends, or until nothing reads standard output.
 * @return EXIT_CLEAN: standard output is no longer read · EXIT_RUN: the connection has ended
 */
int connection_follow(connection_t *connection, const char *who);

/** Member of a line as text, "" if there is none. A number is written into `room`. */
const char *connection_text(const cJSON *line, const char *member, char room[32]);

/** Prints text from a twin; characters that could control a terminal are printed as \xNN. */
void print_text(FILE *stream, const char *text);

/** Prints a line of JSON from a twin as valid JSON. */
void print_json(const char *text);

#endif
