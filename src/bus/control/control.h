/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The control socket of a running chain: signals are read, set and watched from outside. docs/CONTROL.md is its
 * protocol, endpoint.h says where it is.
 *
 * Frames come first. Whatever the clients ask for, ::ect_control_serve does one bounded piece of it and returns: it
 * accepts one client, or lets one receive once, do one step (client.h) and send once; the next call goes on with the
 * next client. What a client does not read stops what it asked for, and nothing else. What is left to do is kept in
 * the clients, never in a queue that grows.
 *
 * Context: the thread of the runner.
 */
#ifndef ECT_BUS_CONTROL_CONTROL_H
#define ECT_BUS_CONTROL_CONTROL_H

#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/chain/stats.h"
#include "bus/control/endpoint.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_CONTROL_CLIENTS = 16,
    ECT_CONTROL_EVERY = 4096, /**< signals that all clients together may watch at every change */
};

typedef struct ect_control ect_control_t;

/**
 * Opens the socket. @param[out] message  on failure one line for the user; ECT_ENDPOINT_MESSAGE bytes
 * @return the socket, to be closed with ::ect_control_close, or NULL
 */
ect_control_t *ect_control_open(char *message);
void ect_control_close(ect_control_t *control);

/**
 * What the request `stats` tells, and where `fault` sets faults.
 * @param stats, scenario  must outlive the control; NULL (as at first): there is nothing to tell, or no fault can be
 * set
 */
void ect_control_show(ect_control_t *control, const ect_stats_t *stats, ect_scenario_t *scenario);

/** Path of the socket, valid until it is closed. */
const char *ect_control_path(const ect_control_t *control);

/** A descriptor that is readable when ::ect_control_serve has something to do. */
int ect_control_fd(const ect_control_t *control);

/** When it has something to do although its descriptor is not readable: 0 now, ECT_NEVER. */
uint64_t ect_control_due(const ect_control_t *control);

/** Does one bounded piece of work. Cost: at most four system calls and one step of a client (client.h). */
void ect_control_serve(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);

/**
 * Notes what has changed, for those who want every change. After each poll.
 * Cost: a comparison for each signal that they watch, ECT_CONTROL_EVERY at most, and one for each twin with a lamp that
 * one of them watches.
 */
void ect_control_note(ect_control_t *control, const ect_chain_t *chain, uint64_t now_ns);

ECT_C_END

#endif
