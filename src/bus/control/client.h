/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One connection to the control socket: what it asks, what it is answered, what it watches. For control.c alone.
 *
 * Everything here is done in steps of bounded work, since frames wait meanwhile: a step serves one request, or goes on
 * with an answer, or tells what has changed. It writes at most ECT_CLIENT_LINES lines.
 */
#ifndef ECT_BUS_CONTROL_CLIENT_H
#define ECT_BUS_CONTROL_CLIENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/chain/stats.h"
#include "bus/control/endpoint.h"
#include "bus/control/line.h"
#include "bus/control/watch.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_CLIENT_LINES = 8,      /**< that a step writes, and one more with its result */
    ECT_CLIENT_LOOKS = 32,     /**< signals whose name a step compares with a pattern */
    ECT_CLIENT_COMPARES = 512, /**< watched values that a step compares */
    ECT_CLIENT_SKIPS = 64,     /**< requests of a client that is gone that a step skips */
    ECT_CLIENT_ANSWER = 3 * ECT_CLIENT_LINES * ECT_LINE_ROOM,
};

/** A walk over signals that answers a request. */
typedef struct ect_visit {
    enum { ECT_VISIT_NONE, ECT_VISIT_GET, ECT_VISIT_LIST, ECT_VISIT_WATCH } op;
    size_t slave, last; /**< place in the chain, from 0, and where the walk ends */
    ect_chain_cursor_t cursor;
    size_t matched;
    bool literal; /**< the pattern is a name */
    bool all;     /**< of all slaves */
    char pattern[2 * ECT_SIGNAL_NAME];
} ect_visit_t;

typedef struct ect_client {
    int fd;          /**< -1: free */
    uint32_t events; /**< that its descriptor is waited for */
    bool readable;   /**< there is something to receive */
    bool ended;      /**< it sends nothing more */
    bool deaf;       /**< it reads nothing more: replies are dropped, only `set` and `fault` are carried out */
    bool blocked;    /**< its socket took only a part of what is unsent */
    bool closing;    /**< nothing more is received; it goes when it has read everything */
    size_t received;
    size_t line; /**< length of the first request that was received whole, 0: none */
    char request[ECT_ENDPOINT_REQUEST];
    size_t unsent;
    char *answer;             /**< ECT_CLIENT_ANSWER bytes */
    const ect_stats_t *stats; /**< NULL: none are shown */
    ect_scenario_t *scenario; /**< NULL: no fault can be set */
    ect_visit_t visit;
    ect_watch_t *watch; /**< NULL: nothing is watched */
    size_t every_room;  /**< signals that it may watch at every change */
} ect_client_t;

/** Whether there is room for what a step may write. */
bool ect_client_room(const ect_client_t *client);

/** Whether a step has something to do without receiving. */
bool ect_client_busy(const ect_client_t *client);

/** Looks for the end of the first request. To be called when something was received. */
void ect_client_received(ect_client_t *client);

/**
 * Does one step. Only with ect_client_room().
 * @param every_room  signals that this client may watch at every change
 */
void ect_client_step(ect_client_t *client, ect_chain_t *chain, size_t every_room, uint64_t now_ns);

/** Brings the lamps up to date that it watches. Cost: a comparison for each twin of which it watches one. */
void ect_client_show_lamps(const ect_client_t *client, const ect_chain_t *chain);

/**
 * The client has closed its connection. It no longer watches anything, no reply is written, and of the requests that it
 * has sent only `set` and `fault` are carried out.
 */
void ect_client_gone(ect_client_t *client);

/** Adds the line that ends an answer. @param message  why not; NULL: it was done */
void ect_client_result(ect_client_t *client, const char *message);

ECT_C_END

#endif
