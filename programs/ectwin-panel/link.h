/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bytes of a connection to a control socket (docs/CONTROL.md): lines in, requests out, and the order of replies.
 * No socket: the caller receives and sends.
 */
#ifndef ECTWIN_PANEL_LINK_H
#define ECTWIN_PANEL_LINK_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>

enum {
    LINK_LINE = 4096,  /**< room for a line; a longer one ends the connection */
    LINK_OUT = 16384,  /**< bytes of requests that wait to be sent */
    LINK_WAITING = 64, /**< requests without a reply */
};

typedef enum link_kind {
    LINK_CHANGE,
    LINK_ABOUT,
    LINK_LIST,
    LINK_WATCH,
    LINK_STATS,
    LINK_FAULTS,
    LINK_EVENTS,
    LINK_PAGE,
    LINK_RELEASE,
} link_kind_t;

/** The origin of a request; `page` and `id` are those of a page. */
typedef struct link_request {
    link_kind_t kind;
    unsigned long page;
    double id;
} link_request_t;

/** A zeroed link is a new one. */
typedef struct link {
    size_t received;
    char line[LINK_LINE];
    size_t unsent;
    char out[LINK_OUT];
    size_t first, count;
    link_request_t waiting[LINK_WAITING];
} link_t;

/**
 * Takes a line of a reply.
 * @param request  the request; its kind is LINK_CHANGE for a change of a watched signal
 * @param last     the line is the result
 */
typedef void (*link_taker_t)(void *ctx, const link_request_t *request, const char *text, const cJSON *line, bool last);

/** Appends a request, without its line feed. @return false: too much waits already */
bool link_ask(link_t *link, const char *text, const link_request_t *request);

/** Takes received bytes, and passes complete lines on. @return false: the other side is no twin; close the connection
 */
bool link_take(link_t *link, const char *bytes, size_t length, link_taker_t take, void *ctx);

/** Removes the first bytes of `out`, which have been sent. */
void link_sent(link_t *link, size_t length);

#endif
