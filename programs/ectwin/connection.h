/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A connection to the control socket of a running twin (docs/CONTROL.md), and its replies made safe for a terminal.
 */
#ifndef ECTWIN_CONNECTION_H
#define ECTWIN_CONNECTION_H

#include <argp.h>
#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/types.h>

typedef struct connection connection_t;

/** Selection of a running twin. All NULL: $ECTWIN_SOCKET, or the only twin of this user. */
typedef struct connection_choice {
    const char *twin;  /**< name, process id, or path of the socket, which contains a '/' */
    const char *iface; /**< interface of the twin */
} connection_choice_t;

/**
 * Connects to the selected twin. On failure prints cause and cure, with the twins of other users if this user has none.
 * A socket found by search must belong to this user; a socket named by its path may also belong to root, and for root
 * to any user.
 * @param who   first word of messages
 * @return a connection to close with ::connection_close, or NULL
 */
connection_t *connection_open(const connection_choice_t *choice, const char *who);

/**
 * Connects to each running twin of this user, one after the other; dead sockets are removed.
 * @param found  called for each connection, which it closes with ::connection_close; returns whether to continue
 * @return false: the folder is not trusted; the reason is printed
 */
bool connection_each(const char *who, bool (*found)(void *ctx, connection_t *connection, const char *path), void *ctx);

/** @return the reply to the request `about`, to be freed with cJSON_Delete; NULL: no reply; older versions give none */
cJSON *connection_about(connection_t *connection);

/** Writes the path of the socket, "" if it does not fit. */
void connection_path(const connection_t *connection, char *path, size_t room);

/** @return process id of the twin; 0: a process in a PID namespace that is invisible to this process */
pid_t connection_process(const connection_t *connection);

void connection_close(connection_t *connection);

/** The options that select the twin, as a child of a command's parser; its input is a connection_choice_t. */
extern const struct argp connection_argp;

/** A command's `children`. */
extern const struct argp_child connection_children[];

/**
 * Sends a request, frees it, and passes each line of the reply except the last, the result, to `print` (NULL: none).
 * @param who  first word of messages; NULL: no messages
 * @return EXIT_CLEAN · EXIT_USAGE: the request was refused, or exceeds the protocol's limit; the reason is printed ·
 *         EXIT_RUN: no reply, or standard output failed
 */
int connection_request(connection_t *connection, cJSON *request, const char *who, void (*print)(const cJSON *line));

/**
 * Checks the argument of -n: a number, at least `minimum`, or the name of a twin. Another text ends the program with a
 * line.
 * @return the text
 */
const char *connection_slave(const struct argp_state *state, const char *text, unsigned int minimum);

/** Adds the member "slave" to a request. @param slave  a number or a name */
void connection_add_slave(cJSON *request, const char *slave);

enum { CONNECTION_NAME = 96 };

/** Writes the signal's name of a line, with the name of its twin if there is one: "gripper.data1". */
void connection_full_name(const cJSON *line, char name[CONNECTION_NAME]);

/** Options of ::connection_follow. */
typedef struct follow {
    bool quiet;                                /**< prints nothing */
    bool (*met)(void *ctx, const cJSON *line); /**< returns true to end; NULL: never */
    void *ctx;
    int64_t timeout_ms; /**< from the call on; negative: none */
} follow_t;

/** Statuses of ::connection_follow, in addition to EXIT_RUN. */
enum { FOLLOW_MET = 0, FOLLOW_TIMEOUT = -1, FOLLOW_UNREAD = -2 };

/**
 * Reads and prints the lines after the reply to "watch", until the connection or the reader of standard output ends.
 * @return FOLLOW_MET · FOLLOW_TIMEOUT · FOLLOW_UNREAD: standard output is no longer read · EXIT_RUN: the connection has
 *         ended, the reason is printed
 */
int connection_follow(connection_t *connection, const char *who, const follow_t *follow);

/** @return a member of a line as text, "" if there is none; a number is written to `room` */
const char *connection_text(const cJSON *line, const char *member, char room[32]);

/** Prints text from a twin; characters that could control a terminal are printed as \xNN. */
void print_text(FILE *stream, const char *text);

/** Prints a line of JSON from a twin as valid JSON. */
void print_json(const char *text);

/** Prints a parsed line of JSON as ::print_json does. */
void print_line(const cJSON *line);

#endif
