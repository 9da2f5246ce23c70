/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Frames and time through a chain, without a wire: faults, deliberate defects, late replies, the runs of the devices,
 * counters. The event loop (bus/runner.h) and the library in a master's process (bus/inprocess) are its two users.
 *
 *     ect_exchange_start(&x);
 *     for (;;) {
 *         uint64_t next_ns = ect_exchange_run(&x, now_ns);
 *         ... wait for a frame, at most until next_ns ...
 *         ect_exchange_frame(&x, ECT_END_IN, frame, length, &time);
 *     }
 *     ect_exchange_end(&x);
 *
 * Context: one thread at a time. No call blocks, but ::ect_exchange_run for plants that stop a virtual clock
 * (::ect_control_let_wait). Times are those of `clock` and never go back.
 */
#ifndef ECT_BUS_EXCHANGE_H
#define ECT_BUS_EXCHANGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/chain/datagrams.h"
#include "bus/chain/stats.h"
#include "bus/control/control.h"
#include "bus/faults/late.h"
#include "bus/faults/scenario.h"
#include "bus/net/packet.h"
#include "bus/trace.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Bytes of the longest frame that faults concern: longer than any that a controller processes, tags included. */
enum { ECT_EXCHANGE_FRAME = ECT_ESC_MAX_FRAME + 48 };

/** Sees each frame between the wire and the chain and may change its bytes, never its length. */
typedef struct ect_filter {
    /** Before the chain sees a frame. Not NULL. */
    void (*before)(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);
    /** Before the reply to that frame leaves; not called when there is none. Not NULL. */
    void (*after)(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);
    void *ctx;
} ect_filter_t;

/** The caller sets the members down to `ctx` and zeroes the others; every pointer outlives the exchange. */
typedef struct ect_exchange {
    ect_chain_t *chain;
    ect_control_t *control;     /**< notes changes for its clients after each run of the devices; NULL: none */
    ect_scenario_t *scenario;   /**< faults that are set, and to come; NULL: none */
    const ect_filter_t *filter; /**< NULL: none */
    ect_trace_t *trace;         /**< writes the run down; NULL: none */
    /** Sends a frame out of the chain at an end. Not NULL. Must not call the exchange. */
    void (*send)(void *ctx, ect_end_t end, const uint8_t *frame, size_t length);
    /** The present time, nanoseconds; never goes back. Not NULL. */
    uint64_t (*clock)(void *ctx);
    void *ctx;         /**< argument of both */
    ect_stats_t stats; /**< may be read at any time */
    uint64_t run_ns;   /**< time of the last ::ect_exchange_run */
    /* Private. */
    ect_late_t late[ECT_ENDS];
    ect_late_t behind[ECT_ENDS]; /* replies that leave behind the next one */
    uint64_t deadline_ns;        /* next run that the devices want */
    uint64_t polled_ns;          /* latest time that the chain has seen */
    uint64_t touched_ns;         /* last frame or client since the devices have run; ECT_NEVER: none */
    uint64_t answered_ns;        /* a reply has left at this time, just now; 0: the clock has to be read */
    ect_datagrams_t datagrams;   /* of the replies, for clients of the control socket */
    bool linked[ECT_ENDS];       /* what ect_exchange_link has set */
} ect_exchange_t;

/** Shows counters, faults and the trace to the control socket, which the exchange has got after its start. */
void ect_exchange_show(ect_exchange_t *x);

/** Begins: counters keep their values, but for the time of the start. */
void ect_exchange_start(ect_exchange_t *x);

/**
 * Passes a frame that has arrived through faults, filter and chain, and sends its reply, or keeps it until
 * ::ect_exchange_run finds it due. The devices run with the next ::ect_exchange_run. `stats.frames` is the caller's.
 * @param in      end where the frame enters; the link there is set (::ect_chain_set_link)
 * @param frame   changed in place
 * @param length  at most ECT_EXCHANGE_FRAME
 * @param time    arrival, not before the last time that the exchange has seen
 */
void ect_exchange_frame(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, const ect_packet_time_t *time);

/**
 * Whether frames pass nothing but the chain: no trace, filter, fault or late reply. Then a program that knows the
 * chain's replies in advance may give them (bus/kernel).
 */
bool ect_exchange_is_plain(const ect_exchange_t *x);

/**
 * Passes a frame through the chain whose reply has left already, in the kernel. The devices run before it at each time
 * that they asked for, so they see the outputs of each frame; their inputs leave with the next ::ect_exchange_run
 * (::ect_chain_catch_up). Its time may lie before that of a frame that came later, since then no call was made, but
 * never before a call.
 * @param took_ns  time that the reply took, for `stats`
 */
void ect_exchange_replied(ect_exchange_t *x, uint8_t *frame, size_t length, uint64_t now_ns, uint32_t took_ns);

/** Shows the chain a frame that is too long for EtherCAT and for ::ect_exchange_frame: controllers count it, no reply
 * leaves. `frame` has at least the first ECT_EXCHANGE_FRAME of its `length` bytes. */
void ect_exchange_long_frame(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns);

/** Plugs a cable in at an end, or pulls it (::ect_chain_set_link). */
void ect_exchange_link(ect_exchange_t *x, ect_end_t end, bool link);

/** Notes that the caller changes the chain now, other than by a frame. @return the present time */
uint64_t ect_exchange_touch(ect_exchange_t *x);

/**
 * Sends the replies that are due, runs the devices at each time that they asked for (64 at most in a row) and takes
 * due steps of the scenario.
 * @return the time of the next call without a frame; ECT_NEVER: none is necessary
 */
uint64_t ect_exchange_run(ect_exchange_t *x);

/** Switches all twins off and on (::ect_chain_power_cycle); replies that were kept are dropped. */
void ect_exchange_power_cycle(ect_exchange_t *x);

/** Notes a request that changes the chain (bus/control/change.h), after ::ect_exchange_touch and before the change. */
void ect_exchange_request(ect_exchange_t *x, const char *request, size_t length);

/** Drops the replies that were kept. */
void ect_exchange_end(ect_exchange_t *x);

ECT_C_END

#endif
