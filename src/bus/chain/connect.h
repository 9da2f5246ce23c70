/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Connections: a signal of one twin sets a signal of another, with factor, offset, inversion and delay.
 *
 * A poll of the chain runs the connections after the twins, in the order of the list; times are those of the polls, so
 * a run on a virtual clock is repeatable. A target is set when its value changes, and once at the start.
 *
 * Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_CONNECT_H
#define ECT_BUS_CHAIN_CONNECT_H

#include "bus/chain/signals.h"

ECT_C_BEGIN

/** Limit of pending values in a connection with a delay; beyond it, the newest value replaces the previous one. */
enum { ECT_CONNECTION_VALUES = 1024 };

typedef struct ect_connection {
    size_t from, to; /**< positions in the chain */
    ect_signal_ref_t source, target;
    double factor, offset; /**< source x factor + offset, rounded for an integer, within the target's range */
    bool invert;           /**< the target is 1 if this result is 0, else 0 */
    uint64_t delay_ns;
} ect_connection_t;

typedef struct ect_connections ect_connections_t;

/** @return whether source and target are numbers, and the target can be set */
bool ect_connection_fits(const ect_connection_t *connection);

/**
 * @return the position in the list of a connection in a loop without any delay; `count`: none, or no memory for the
 * search. Cost: for each connection, the square of the length of the list
 */
size_t ect_connections_loop(const ect_connection_t *list, size_t count);

/**
 * @param list  copied; each connection fits, none is in a loop; the signals outlive the result. @return NULL: no memory
 */
ect_connections_t *ect_connections_new(const ect_connection_t *list, size_t count);

/** Frees the connections. NULL: no effect */
void ect_connections_free(ect_connections_t *connections);

/**
 * Transfers changed values and due values.
 * @param changed  called with the position of each twin in which a signal was set
 * @return whether any signal was set
 */
bool ect_connections_run(ect_connections_t *connections, uint64_t now_ns, void (*changed)(void *ctx, size_t position),
                         void *ctx);

/** @return the time at which the next delayed value is due, ECT_NEVER: none */
uint64_t ect_connections_next(const ect_connections_t *connections);

ECT_C_END

#endif
