/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The event loop: one port, one chain, one thread. A frame is answered first; the devices run when the answer has left.
 */
#ifndef ECT_BUS_RUNNER_H
#define ECT_BUS_RUNNER_H

#include <stdbool.h>

#include "bus/chain.h"
#include "bus/control.h"
#include "bus/faults.h"
#include "bus/packet.h"

typedef struct ect_runner {
    ect_packet_t *port;
    ect_chain_t *chain;
    ect_control_t *control; /**< NULL: none */
    ect_faults_t *faults;   /**< NULL: none */
    int signal_fd;          /**< a signalfd */
    /** A signal has come, from the terminal or from a process. Not NULL. @return true: go on; false: stop. */
    bool (*on_signal)(void *ctx, int signal_number, bool from_terminal);
    void *ctx;
} ect_runner_t;

/** Monotonic time, nanoseconds. */
uint64_t ect_runner_now(void);

/**
 * Runs until `on_signal` stops it.
 * Cost: one wait and two system calls (receive, send) a frame; nothing while the bus is quiet but the devices' timers.
 * @return 0 · -1 the interface went away (errno)
 */
int ect_runner_run(const ect_runner_t *runner);

#endif
