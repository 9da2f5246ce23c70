/* SPDX-License-Identifier: MIT */
/** @file The control sockets of this user's running twins. */
#ifndef ECTWIN_PANEL_FINDER_H
#define ECTWIN_PANEL_FINDER_H

#include "bus.h"

/** Takes the descriptor of a new connection to a bus, non-blocking, and sets `bus->socket`. */
typedef void (*finder_taker_t)(void *ctx, bus_t *bus, int fd, long process);

/**
 * Adds buses whose socket is new, removes those whose socket is gone, and connects to those without a connection. It
 * never waits: a twin that does not accept is tried again the next time. Folders and sockets of other users are left
 * out.
 */
void finder_search(buses_t *buses, finder_taker_t take, void *ctx);

/** Makes one more connection to a bus, as ::finder_search does. It never waits; without a connection nothing is taken.
 */
void finder_connect(bus_t *bus, finder_taker_t take, void *ctx);

#endif
