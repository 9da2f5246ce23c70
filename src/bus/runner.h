/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The event loop: one chain with one or two ends, one thread. The reply to a frame leaves first; the devices run
 * afterwards.
 */
#ifndef ECT_BUS_RUNNER_H
#define ECT_BUS_RUNNER_H

#include <stdbool.h>

#include "bus/eoe/hosts.h"
#include "bus/exchange.h"
#include "bus/kernel/kernel.h"
#include "bus/modbus/modbus.h"
#include "bus/net/endless.h"
#include "bus/net/packet.h"
#include "bus/net/udp.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_runner {
    ect_packet_t *ports[ECT_ENDS]; /**< by ::ect_end_t; NULL: no interface */
    ect_udp_t *udp;          /**< EtherCAT in UDP, which also enters at ECT_END_IN, whose link is then up; NULL: none */
    ect_exchange_t exchange; /**< chain, control socket, faults, filter; the loop sets its callbacks */
    ect_modbus_server_t *modbus; /**< of the first twin; NULL: none */
    ect_hosts_t *hosts;          /**< networks behind twins with EoE; NULL: none */
    ect_kernel_t *kernel;        /**< replies in the kernel, permitted with a single port; NULL: none */
    /** Pause between two pieces of work for clients, so that clients never use an entire core, nanoseconds; 0: none. */
    uint32_t client_pause_ns;
    bool busy_poll; /**< polls continuously: lower latency, one core at 100 % */
    int signal_fd;  /**< a signalfd */
    int link_fd;    /**< of ::ect_packet_watch_links, for the cables at the ends; -1: cables count as plugged in */
    /** Called for a signal, from the terminal or a process. Not NULL. @return true: continue; false: stop. */
    bool (*on_signal)(void *ctx, int signal_number, bool from_terminal);
    /** Called once when frames circulate (bus/net/endless.h). Not NULL. */
    void (*on_circulating)(void *ctx, const char *iface);
    void *ctx;
    /* Private; start at zero. */
    ect_endless_t endless[ECT_ENDS];
    unsigned int frames_first;
    uint64_t waited_ns;    /* last check of clients and signals */
    bool frames_come;      /* a frame arrived at the last check */
    uint64_t pause_end_ns; /* end of the pause between clients */
    bool pausing;
    unsigned int client; /* kind of the client served last, for the rotation */
    bool linked[ECT_ENDS];
} ect_runner_t;

/** Recommended ect_runner_t::client_pause_ns: clients get less than half of a core. */
enum { ECT_RUNNER_REST_NS = 50000 };

/**
 * Runs until `on_signal` stops the loop, and at most two seconds longer for a save under way (::ect_chain_unfinished).
 * Frames come first: a client of the control socket, of Modbus or of EoE is served when no frame waits, or after eight
 * successive frames. Cost: two system calls (receive, send) for each frame while frames arrive, and a check of clients
 * and signals every half millisecond, or after the next frame; while the bus is quiet, only wake-ups for the devices'
 * deadlines.
 * @return 0 · -1: an interface is gone (errno)
 */
int ect_runner_run(ect_runner_t *runner);

ECT_C_END

#endif
