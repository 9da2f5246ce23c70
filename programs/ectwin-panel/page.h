/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One open page: its messages, and the next message for it. A page has no queue of changes but marks of the last change
 * sent, so a slow page gets the newest values, and its memory does not grow. No socket, no clock.
 *
 * Messages are JSON. From the page: {"token":"…"} first; then {"open":BUS} and {"id":N,"bus":BUS,"request":{…}}, a
 * request of the control protocol; {"trace":[SIGNAL,…]}, all signals of which it wants every change. A request that
 * sets one signal may have "rest" beside it, {"id":N,"bus":BUS,"request":{"op":"set",…},"rest":0}: the page holds the
 * signal, until it sets the signal to this value, and ::page_release returns the request that does so in its place. To
 * the page: an "event" each: hello, buses, signals, values, changes, stats, faults, events, trouble, reply.
 */
#ifndef ECTWIN_PANEL_PAGE_H
#define ECTWIN_PANEL_PAGE_H

#include "bus.h"
#include "request.h"
#include "trace.h"

enum {
    PAGE_MESSAGE = 32768,       /**< room for a message to a page */
    PAGE_REPLIES = 16,          /**< requests of a page without a reply; one more ends the connection */
    PAGE_REPLY = 8 * 1024 + 64, /**< room for the reply to a request; a longer one is replaced by a short one */
    PAGE_HELD = 16,             /**< most signals that a page holds */
    PAGE_HELD_LINE = 256,       /**< room for a request that releases a signal */
};

typedef struct page {
    unsigned long number;
    bool known; /**< it has sent the token */
    bool view;  /**< it may change nothing */
    bool greeted;
    bool due;         /**< values may be sent */
    uint32_t buses;   /**< marks: the last change that it has been sent of each kind */
    unsigned int bus; /**< the bus that it shows, 0: none */
    uint32_t generation;
    size_t described; /**< signals that it has received */
    uint32_t counters, faults, troubles, events;
    uint32_t values;  /**< change up to which it has all values */
    uint32_t passing; /**< the same, when this pass has ended */
    size_t next;      /**< signal at which the pass continues */
    uint32_t changed[TABLE_SIGNALS];
    trace_set_t traced; /**< signals of which it wants every change */
    bool tracing;       /**< `traces` is valid */
    uint32_t traces;    /**< changes of the trace up to which it has been sent them */
    size_t holds;
    struct {
        unsigned int bus;
        char line[PAGE_HELD_LINE]; /**< the request that releases it */
    } held[PAGE_HELD];
    size_t waiting; /**< requests without a reply, with those below */
    size_t first, replies;
    struct {
        double id;
        char text[PAGE_REPLY];
    } reply[PAGE_REPLIES];
} page_t;

/** The effects of a message. */
typedef enum page_action {
    PAGE_CLOSE, /**< the page breaks the rules: close the connection */
    PAGE_DONE,
    PAGE_PASS_ON, /**< send `line` to `bus` */
    PAGE_LEAVE,   /**< the page shows another bus: release the signals that it holds */
} page_action_t;

typedef struct page_passed {
    unsigned int bus;
    double id;
    char line[REQUEST_LINE];
} page_passed_t;

/** Takes a message of the page. @param[out] passed  with PAGE_PASS_ON */
page_action_t page_take(page_t *page, const char *text, size_t length, const char *token, page_passed_t *passed);

/**
 * Takes one of the signals that the page holds. Call it until it returns false when the page has left the bus, or
 * cannot be reached any longer.
 * @param[out] passed  the request that returns the signal to its rest; its `id` is no request of the page
 * @return false: the page holds none
 */
bool page_release(page_t *page, page_passed_t *passed);

/** Adds the reply to a request, one line of JSON. */
void page_reply(page_t *page, double id, const char *text);

/** @return whether ::page_next has a message */
bool page_has_news(const page_t *page, const buses_t *buses);

/** Writes the next message. @param[out] message  PAGE_MESSAGE bytes @return its length, 0: none */
size_t page_next(page_t *page, const buses_t *buses, char *message);

#endif
