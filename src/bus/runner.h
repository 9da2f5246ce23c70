/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The event loop: one chain, its one or two ends, one thread. A frame is answered first; the devices run when the
 * answer has left.
 */
#ifndef ECT_BUS_RUNNER_H
#define ECT_BUS_RUNNER_H

#include <stdbool.h>

#include "bus/exchange.h"
#include "bus/modbus/modbus.h"
#include "bus/net/endless.h"
#include "bus/net/packet.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_runner {
    ect_packet_t *ports[ECT_ENDS]; /**< by ::ect_end; NULL: nothing is plugged in there */
    ect_exchange_t exchange;       /**< chain, control socket, faults, filter; the loop sets its callbacks */
    ect_modbus_server_t *modbus;   /**< of the first twin; NULL: none */
    /** From one piece of work for a client to the next, so that clients never take the whole processor; 0: none. */
    uint32_t control_rest_ns;
    bool busy_poll; /**< looks for frames without a rest: a processor does nothing else */
    int signal_fd;  /**< a signalfd */
    int link_fd;    /**< of ::ect_packet_watch_links: cables at the ends come and go; -1: they are taken as in */
    /** A signal has come, from the terminal or from a process. Not NULL. @return true: go on; false: stop. */
    bool (*on_signal)(void *ctx, int signal_number, bool from_terminal);
    /** Something else at the other end of the wire answers as well. Not NULL; called once. */
    void (*on_circling)(void *ctx, const char *iface);
    void *ctx;
    /* The loop's own; start at zero. */
    ect_endless_t circles[ECT_ENDS];
    unsigned int frames_first;
    uint64_t looked_ns; /* when others than frames were looked at */
    bool frames_come;   /* and whether there was a frame then */
    uint64_t rested_ns; /* when a client may be served again */
    bool resting;
    bool modbus_next; /* of the clients of both kinds */
    bool linked[ECT_ENDS];
} ect_runner_t;

/** What ect_runner_t::control_rest_ns should be: with it clients get less than half of a processor. */
enum { ECT_RUNNER_REST_NS = 50000 };

/**
 * Runs until `on_signal` stops it, and at most two seconds longer for what a user has had saved (ect_chain_unfinished).
 * Frames first: a client, of the control socket or over Modbus, is served when none waits, or after eight in a row.
 * Cost: two system calls (receive, send) a frame while frames come, and a look at all others every half millisecond, or
 * after the next frame; nothing while the bus is quiet but the devices' timers.
 * @return 0 · -1 an interface went away (errno)
 */
int ect_runner_run(ect_runner_t *runner);

ECT_C_END

#endif
