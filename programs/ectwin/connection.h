/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A connection to the control socket of a running twin (docs/CONTROL.md), and what a twin says, made fit for a
 * terminal.
 */
#ifndef ECTWIN_CONNECTION_H
#define ECTWIN_CONNECTION_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdio.h>

typedef struct connection connection_t;

/**
 * Connects to the socket that is named, or to the only twin of this user that runs. On failure prints why, and what to
 * do: whose twins there are if none are this user's.
 * @param path  NULL: $ECTWIN_SOCKET, or look for it. What is looked for must be this user's own; what is named may be
 *              root's too, and for root anybody's
 * @param who   stands in front of what is printed
 * @return a connection to close with ::connection_close, or NULL
 */
connection_t *connection_open(const char *path, const char *who);

void connection_close(connection_t *connection);

/** The option that says which: a row of the options of a command; its key is 's'. */
#define CONNECTION_OPTION                                                                                              \
    {"socket", 's', "PATH", 0, "Control socket (default: $ECTWIN_SOCKET, or the only one running)", 0}

/**
 * Sends a request, frees it, and hands lines of the answer to `print` (NULL: to nobody) until the one that says how it
 * went.
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

/** Prints text from a twin; what could steer a terminal is printed as \xNN. */
void print_text(FILE *stream, const char *text);

/** Prints a line of JSON from a twin; it stays JSON. */
void print_json(const char *text);

#endif
