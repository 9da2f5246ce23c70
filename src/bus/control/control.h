/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The control socket of a running chain: clients read, set and watch signals. docs/CONTROL.md describes the protocol,
 * endpoint.h the path of the socket.
 *
 * Frames come first: ::ect_control_serve does one bounded piece of work and returns. It accepts one client, or lets one
 * client receive once, do one step (client.h) and send once; the next call serves the next client. A client that stops
 * reading blocks only its own replies. Remaining work is stored in the clients, never in a growing queue.
 *
 * Context: the thread of the runner.
 */
#ifndef ECT_BUS_CONTROL_CONTROL_H
#define ECT_BUS_CONTROL_CONTROL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/recent.h"
#include "bus/chain/chain.h"
#include "bus/chain/datagrams.h"
#include "bus/chain/stats.h"
#include "bus/control/about.h"
#include "bus/control/endpoint.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_CONTROL_CLIENTS = 16,
    ECT_CONTROL_EVERY = 4096, /**< most signals that all clients together watch at every change */
};

typedef struct ect_control ect_control_t;

/**
 * Opens the socket.
 * @param name          as for ::ect_endpoint_listen
 * @param[out] message  on failure one line for the user; ECT_ENDPOINT_MESSAGE bytes
 * @return the socket, to be closed with ::ect_control_close; NULL (errno as ::ect_endpoint_listen)
 */
ect_control_t *ect_control_open(const char *name, char *message);
void ect_control_close(ect_control_t *control);

/**
 * Sets the counters that the request `stats` reads, and the scenario in which `fault` sets faults.
 * @param stats, scenario  must outlive the control; NULL, the initial value: the request is refused
 */
void ect_control_show(ect_control_t *control, const ect_stats_t *stats, ect_scenario_t *scenario);

/**
 * Sets the datagrams that the request `counters` reads.
 * @param datagrams  must outlive the control; NULL, the initial value: the request is refused
 */
void ect_control_count(ect_control_t *control, ect_datagrams_t *datagrams);

/** @return the capture that clients begin and end, until ::ect_control_close; the caller adds frames while it is on */
ect_recent_t *ect_control_recent(ect_control_t *control);

/** Sets the contents of `about`. @param about  must outlive the control; NULL, the initial value: `about` is refused */
void ect_control_describe(ect_control_t *control, const ect_about_t *about);

/**
 * Records the events of a chain for the request `events` from now on. Without memory for it the request is refused.
 * @param chain  must outlive the control, which is its observer (::ect_chain_observe)
 */
void ect_control_follow(ect_control_t *control, ect_chain_t *chain);

/**
 * Sets a function that gets each request that changes the chain (bus/control/change.h), before its execution.
 * @param changes  `request` is the line without its end, `length` bytes; NULL: none
 */
void ect_control_observe(ect_control_t *control, void (*changes)(void *ctx, const char *request, size_t length),
                         void *ctx);

/** @return the path of the socket, valid until ::ect_control_close */
const char *ect_control_path(const ect_control_t *control);

/** @return a descriptor that is readable when ::ect_control_serve has work */
int ect_control_fd(const ect_control_t *control);

/** @return the time at which ::ect_control_serve has work without a readable descriptor: 0: now; ECT_NEVER: none */
uint64_t ect_control_due(const ect_control_t *control);

/** Does one bounded piece of work. Cost: at most four system calls and one step of a client (client.h). */
void ect_control_serve(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);

/** @return the time of the next request with a time ("at"); ECT_NEVER: none */
uint64_t ect_control_planned(const ect_control_t *control);

/**
 * Executes the requests that are due. Call it before the devices run. A refusal is reported to `refused` of the
 * scenario of ::ect_control_show.
 */
void ect_control_act(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);

/**
 * Records changes for clients that watch every change. Call it after each ::ect_chain_poll.
 * Cost: one comparison for each signal watched at every change, at most ECT_CONTROL_EVERY, and one for each twin with a
 * watched lamp.
 */
void ect_control_record(ect_control_t *control, const ect_chain_t *chain, uint64_t now_ns);

/* --- plants outside this process (outside.h) ---------------------------------------------------------------------- */

/** Sets a function that gets a line for the user when a plant is late or has ended, once each; NULL: none. */
void ect_control_report(ect_control_t *control, void (*report)(void *ctx, const char *text), void *ctx);

/** Allows plants to stop a virtual clock during their steps; ::ect_control_step then waits for these plants. */
void ect_control_let_wait(ect_control_t *control);

/** Waits until a plant with a name has been started, at most 20 s. @return false: not started in this time */
bool ect_control_await_plant(ect_control_t *control, ect_chain_t *chain, const char *name, uint64_t now_ns);

/** @return whether ::ect_control_step has work at a time. Cost: one comparison for each plant. */
bool ect_control_wants_step(const ect_control_t *control, uint64_t now_ns);

/** @return the time of the next step of a plant; ECT_NEVER: none. */
uint64_t ect_control_step_due(const ect_control_t *control);

/**
 * Begins the steps that are due: sends the present values to their plants. Call it after the devices have run.
 * Cost: one line and one system call for each plant; a plant that stops the clock is awaited, at most 10 s.
 * @return whether the clock was stopped for a plant, so that the devices must run again at the same time
 */
bool ect_control_step(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);

ECT_C_END

#endif
