/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Connections: a signal of one twin sets a signal of another, with factor, offset, inversion and delay.
 *
 * A chain runs its connections in its poll, after the twins, in the order of the list; times are those of the polls, so
 * a run on a virtual clock is repeatable. A target is set when its value changes, and once at the start.
 *
 * Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_CONNECT_H
#define ECT_BUS_CHAIN_CONNECT_H

#include "bus/chain/signals.h"

ECT_C_BEGIN

/** Values under way in a connection with a delay; when there are more, the newest one replaces the one before it. */
enum { ECT_CONNECTION_VALUES = 1024 };

typedef struct ect_connection {
    size_t from, to; /**< positions in the chain */
    ect_signal_ref_t source, target;
    double factor, offset; /**< source x factor + offset, the nearest integer for one, within the target's range */
    bool invert;           /**< the target is 1 when that result is 0, else 0 */
    uint64_t delay_ns;
} ect_connection_t;

typedef struct ect_connections ect_connections_t;

/** @return whether source and target are numbers, and the target can be set */
bool ect_connection_fits(const ect_connection_t *connection);

/**
 * @return the position in the list of a connection that is part of a loop without any delay; `count`: there is none, or
 * no memory to search for one. Cost: grows with the square of the list, for each connection
 */
size_t ect_connections_loop(const ect_connection_t *list, size_t count);

/** @param list  copied; each fits, none is in a loop; the signals outlive the result. @return NULL: no memory */
ect_connections_t *ect_connections_new(const ect_connection_t *list, size_t count);

/** NULL is allowed. */
void ect_connections_free(ect_connections_t *connections);

/**
 * Passes on what has changed and what is due.
 * @param changed  called with the position of each twin that a signal was set of
 * @return whether any signal was set
 */
bool ect_connections_run(ect_connections_t *connections, uint64_t now_ns, void (*changed)(void *ctx, size_t position),
                         void *ctx);

/** @return the time at which the next delayed value is due, ECT_NEVER: none */
uint64_t ect_connections_next(const ect_connections_t *connections);

ECT_C_END

#endif
