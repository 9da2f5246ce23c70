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

/** Which running twin a command talks to. All NULL: $ECTWIN_SOCKET, or the only one of this user. */
typedef struct connection_choice {
    const char *twin;  /**< its name, its process id, or the path of its socket, which has a '/' in it */
    const char *iface; /**< its interface */
} connection_choice_t;

/**
 * Connects to the twin that is chosen. On failure prints cause and cure: other users' twins if this user has none.
 * A socket found must be this user's own; one named by its path may also be root's, and for root any user's.
 * @param who   first word of messages
 * @return a connection to close with ::connection_close, or NULL
 */
connection_t *connection_open(const connection_choice_t *choice, const char *who);

/**
 * Connects to each running twin of this user, one after the other; dead sockets are removed.
 * @param found  takes the connection, to close it with ::connection_close. @return whether to go on
 * @return false: the folder is not to be trusted; the reason is printed
 */
bool connection_each(const char *who, bool (*found)(void *ctx, connection_t *connection, const char *path), void *ctx);

/** The reply to the request `about`, to free with cJSON_Delete; NULL: none, as of a twin of an older version. */
cJSON *connection_about(connection_t *connection);

/** Path of its socket, "" if it does not fit. */
void connection_path(const connection_t *connection, char *path, size_t room);

/** Process id of the twin, 0: in a PID namespace that this process does not see. */
pid_t connection_process(const connection_t *connection);

void connection_close(connection_t *connection);

/** The options that choose the twin, as a child of a command's parser; its input is a connection_choice_t. */
extern const struct argp connection_argp;

/** A command's `children`. */
extern const struct argp_child connection_children[];

/**
 * Sends a request, frees it, and passes each line of the reply to `print` (NULL: none) up to the last, the result.
 * @param who  first word of messages; NULL: none is printed
 * @return EXIT_CLEAN · EXIT_USAGE: it was refused, or is longer than the protocol allows; the reason is printed ·
 *         EXIT_RUN: no reply, or standard output failed
 */
int connection_request(connection_t *connection, cJSON *request, const char *who, void (*print)(const cJSON *line));

/**
 * Checks what -n takes: a number from `minimum` on, or the name of a twin. Any other text ends the program with a line.
 * @return the text
 */
const char *connection_slave(const struct argp_state *state, const char *text, unsigned int minimum);

/** Adds the member "slave" to a request. @param slave  a number or a name */
void connection_add_slave(cJSON *request, const char *slave);

enum { CONNECTION_NAME = 96 };

/** Name of the signal of a line with the name of its twin, "gripper.data1"; without one as it is. */
void connection_full_name(const cJSON *line, char name[CONNECTION_NAME]);

/** How the changes of watched signals are followed. */
typedef struct follow {
    bool quiet;                                /**< nothing is printed */
    bool (*met)(void *ctx, const cJSON *line); /**< ends it when true; NULL: never */
    void *ctx;
    int64_t timeout_ms; /**< from now on; negative: none */
} follow_t;

/** Statuses of ::connection_follow beside EXIT_RUN, which is that of a connection that has ended. */
enum { FOLLOW_MET = 0, FOLLOW_TIMEOUT = -1, FOLLOW_UNREAD = -2 };

/**
 * After the reply to "watch": reads lines, and prints them, until the connection ends, or nothing reads standard
 * output.
 * @return FOLLOW_MET · FOLLOW_TIMEOUT · FOLLOW_UNREAD: standard output is no longer read · EXIT_RUN, the reason printed
 */
int connection_follow(connection_t *connection, const char *who, const follow_t *follow);

/** Member of a line as text, "" if there is none. A number is written into `room`. */
const char *connection_text(const cJSON *line, const char *member, char room[32]);

/** Prints text from a twin; characters that could control a terminal are printed as \xNN. */
void print_text(FILE *stream, const char *text);

/** Prints a line of JSON from a twin as valid JSON. */
void print_json(const char *text);

/** The same of one that was read. */
void print_line(const cJSON *line);

#endif
