/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One connection to the control socket: its requests, replies and watched signals. Internal to bus/control.
 *
 * All work is done in bounded steps, because frames wait meanwhile: a step serves one request, continues a reply, or
 * writes changes. A step writes at most ECT_CLIENT_LINES lines, and a line with the result.
 */
#ifndef ECT_BUS_CONTROL_CLIENT_H
#define ECT_BUS_CONTROL_CLIENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/recent.h"
#include "bus/chain/chain.h"
#include "bus/chain/datagrams.h"
#include "bus/chain/stats.h"
#include "bus/control/about.h"
#include "bus/control/endpoint.h"
#include "bus/control/events.h"
#include "bus/control/line.h"
#include "bus/control/outside.h"
#include "bus/control/plans.h"
#include "bus/control/watch.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_CLIENT_LINES = 8,      /**< most lines of a step, without the result */
    ECT_CLIENT_MATCHES = 32,   /**< most comparisons of names with a pattern in a step */
    ECT_CLIENT_COMPARES = 512, /**< most comparisons of watched values in a step */
    ECT_CLIENT_SKIPS = 64,     /**< most requests of a closed connection that a step skips */
    ECT_CLIENT_ANSWER = 3 * ECT_CLIENT_LINES * ECT_LINE_ROOM,
};

/** A request whose reply is a list of signals. */
typedef struct ect_visit {
    enum { ECT_VISIT_NONE, ECT_VISIT_GET, ECT_VISIT_LIST, ECT_VISIT_WATCH } op;
    size_t slave, last; /**< present and last position in the chain, from 0 */
    ect_chain_cursor_t cursor;
    size_t matched;
    bool literal; /**< the pattern is a plain name */
    bool all;     /**< the request is for all slaves */
    char pattern[2 * ECT_SIGNAL_NAME];
} ect_visit_t;

/** Gets each request that changes the chain, before its execution. */
typedef struct ect_observer {
    void (*changes)(void *ctx, const char *request, size_t length); /**< NULL: none */
    void *ctx;
} ect_observer_t;

typedef struct ect_client {
    int fd;          /**< -1: free */
    uint32_t events; /**< events requested from epoll */
    bool readable;   /**< bytes can be received */
    bool ended;      /**< the client has ended sending */
    bool deaf;       /**< the client has closed the connection: replies are dropped, only changes are executed */
    bool blocked;    /**< the socket has accepted only a part of the unsent bytes */
    bool closing;    /**< reception has ended; the connection is closed after the last reply */
    size_t received;
    size_t line; /**< length of the first complete request; 0: none */
    char request[ECT_ENDPOINT_REQUEST];
    size_t unsent;
    char *answer;               /**< ECT_CLIENT_ANSWER bytes */
    const ect_stats_t *stats;   /**< NULL: none */
    ect_scenario_t *scenario;   /**< NULL: none */
    const ect_about_t *about;   /**< NULL: none */
    ect_datagrams_t *datagrams; /**< NULL: none */
    ect_recent_t *recent;
    const ect_observer_t *observer;      /**< NULL: none */
    ect_plans_t *plans;                  /**< requests with a future time */
    const ect_events_t *events_of_chain; /**< NULL: none */
    ect_outsides_t *outsides;            /**< NULL: none */
    ect_visit_t visit;
    ect_watch_t *watch; /**< NULL: none */
    size_t every_room;  /**< most signals that the client may watch at every change */
} ect_client_t;

/** @return whether there is room for the lines of a step */
bool ect_client_room(const ect_client_t *client);

/** @return whether a step has work without receiving */
bool ect_client_busy(const ect_client_t *client);

/** Finds the end of the first request. Call it after each reception. */
void ect_client_received(ect_client_t *client);

/**
 * Does one step. Only with ect_client_room().
 * @param every_room  signals that this client may watch at every change
 */
void ect_client_step(ect_client_t *client, ect_chain_t *chain, size_t every_room, uint64_t now_ns);

/** Updates the lamps that the client watches. Cost: one comparison for each twin with a watched lamp. */
void ect_client_show_lamps(const ect_client_t *client, const ect_chain_t *chain);

/**
 * Handles a connection closed by the client: its watches end, no reply is written, and only received requests that
 * change the chain (::ect_change_is) are executed.
 */
void ect_client_end_of_input(ect_client_t *client);

/** Writes the lines of a step of the client's plant. Only with ect_client_room(). @param plant  that has begun the step
 */
void ect_client_send_step(ect_client_t *client, const ect_outside_t *plant, uint64_t now_ns);

/** Writes the last line of a reply. @param message  the reason of a refusal; NULL: done */
void ect_client_result(ect_client_t *client, const char *message);

ECT_C_END

#endif
