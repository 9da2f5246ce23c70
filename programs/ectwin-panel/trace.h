/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Every change of the signals that pages plot, from a second connection to the twin. The other connection reports the
 * newest values, and misses a pulse between two of them. No socket, no clock.
 */
#ifndef ECTWIN_PANEL_TRACE_H
#define ECTWIN_PANEL_TRACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "link.h"
#include "table.h"

enum {
    TRACE_ROOM = 8192,   /**< changes that a page may be late */
    TRACE_SIGNALS = 128, /**< most signals of a connection */
};

/** Signals by their position in the table. */
typedef struct trace_set {
    size_t count;
    uint8_t bits[TABLE_SIGNALS / 8];
} trace_set_t;

typedef struct trace_change {
    uint16_t signal; /**< position in the table */
    double time_s;   /**< clock of the twin */
    double value;
} trace_change_t;

/** A zeroed set has no signal. */
typedef struct trace {
    void *socket; /**< of the caller; NULL: not connected */
    bool tried;   /**< of the caller: a connection has been tried in this second */
    link_t link;
    trace_set_t watched;
    uint32_t written; /**< number of changes; number N is in `ring[N % TRACE_ROOM]` */
    trace_change_t ring[TRACE_ROOM];
} trace_t;

bool trace_set_has(const trace_set_t *set, size_t signal);

/** Adds a signal. @param signal  below TABLE_SIGNALS */
void trace_set_add(trace_set_t *set, size_t signal);

/** Adds all signals of another set. */
void trace_set_unite(trace_set_t *set, const trace_set_t *other);

/** Begins a connection, or ends one: no signal is watched. */
void trace_restart(trace_t *trace);

/**
 * Requests the wanted signals that are not watched yet, as many as there is room for. A watch ends with its connection
 * only, so a signal that is no longer wanted remains.
 */
void trace_want(trace_t *trace, const table_t *table, const trace_set_t *wanted);

/** Takes received bytes. @return false: close the connection */
bool trace_take(trace_t *trace, table_t *table, const char *bytes, size_t length);

#endif
