/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A running bus, as its control socket describes it. No socket, no clock: the caller moves the bytes of `bus->link` and
 * calls ::bus_poll.
 */
#ifndef ECTWIN_PANEL_BUS_H
#define ECTWIN_PANEL_BUS_H

#include <stdint.h>

#include "bus/control/endpoint.h"
#include "link.h"
#include "table.h"
#include "trace.h"

enum { BUS_MOST = 32, BUS_TEXT = 4096, BUS_TROUBLE = 256, BUS_EVENTS = 64, BUS_EVENT = 512, BUS_LINES = 8 * 1024 + 16 };

/** A text that pages get when it has changed. */
typedef struct bus_text {
    uint32_t version; /**< 0: there is none yet */
    size_t length;
    char text[BUS_TEXT]; /**< JSON */
} bus_text_t;

typedef struct bus {
    unsigned int number; /**< from 1; the same as long as its socket exists */
    char path[ECT_ENDPOINT_PATH];
    void *socket;        /**< of the caller; NULL: not connected */
    long process;        /**< 0: not visible */
    uint32_t generation; /**< counts connections; signals of another one are others */
    bool watched;        /**< its signals have been requested */
    bool listed;         /**< `table` is complete */
    bus_text_t about, counters, answers, faults;
    bus_text_t next_faults;            /**< the reply that is being received */
    uint32_t events;                   /**< number of events received; event N is at N % BUS_EVENTS */
    char event[BUS_EVENTS][BUS_EVENT]; /**< JSON */
    double last_event;                 /**< its number in the twin */
    bool more_events;                  /**< the reply that is being received has some */
    size_t lines;         /**< bytes of the reply to a page that is being received, without its last line */
    char line[BUS_LINES]; /**< JSON, separated by commas */
    uint32_t troubles;
    char trouble[BUS_TROUBLE]; /**< the reason why its signals are not shown */
    link_t link;
    table_t table;
    trace_t trace; /**< every change of some signals */
} bus_t;

/** Replies to the requests of pages go here: one line of JSON. Lines before the last one are its member "lines". */
typedef void (*bus_replier_t)(void *ctx, const bus_t *bus, const link_request_t *request, const char *text);

/** All buses that run. */
typedef struct buses {
    size_t count;
    uint32_t changes;     /**< counts changes of the list */
    unsigned int numbers; /**< last number of a bus */
    bus_t *all[BUS_MOST];
    bus_replier_t reply;
    void *ctx;
} buses_t;

/** Begins a connection to the bus. */
void bus_connected(buses_t *buses, bus_t *bus, long process);

/** Forgets the state of the last connection, and refuses the requests of pages that have no reply. */
void bus_disconnected(buses_t *buses, bus_t *bus);

/** Sends the requests that are repeated, once a second. @param open  a page shows the bus */
void bus_poll(bus_t *bus, bool open);

/** Takes received bytes. @return false: close the connection */
bool bus_take(buses_t *buses, bus_t *bus, const char *bytes, size_t length);

/** @return the bus with a number, NULL: none */
bus_t *bus_find(const buses_t *buses, unsigned int number);

#endif
