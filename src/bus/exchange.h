/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Frames and time through a chain, without a wire: faults, deliberate defects, late replies, the runs of the devices,
 * counters. The event loop (bus/runner.h) and the library in a master's process (bus/inprocess) are its two users.
 *
 *     ect_exchange_start(&x);
 *     for (;;) {
 *         uint64_t next_ns = ect_exchange_run(&x);
 *         ... wait for a frame, at most until next_ns ...
 *         ect_exchange_frame(&x, ECT_END_IN, frame, length, &time);
 *     }
 *     ect_exchange_end(&x);
 *
 * Context: one thread at a time. No call blocks, except ::ect_exchange_run for plants that stop a virtual clock
 * (::ect_control_let_wait). Times are those of `clock` and never decrease.
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

/**
 * Bytes of the longest frame that faults apply to: longer than any frame that a controller processes, tags included.
 */
enum { ECT_EXCHANGE_FRAME = ECT_ESC_MAX_FRAME + 48 };

/** Receives each frame between the wire and the chain, and may change its bytes, not its length. */
typedef struct ect_filter {
    /** Called before a frame enters the chain. Not NULL. */
    void (*before)(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);
    /** Called before the reply leaves; not called without a reply. Not NULL. */
    void (*after)(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);
    void *ctx;
} ect_filter_t;

/** The caller sets the members down to `ctx` and zeroes the others; every pointer outlives the exchange. */
typedef struct ect_exchange {
    ect_chain_t *chain;
    ect_control_t *control;     /**< records changes for its clients after each run of the devices; NULL: none */
    ect_scenario_t *scenario;   /**< present and future faults; NULL: none */
    const ect_filter_t *filter; /**< NULL: none */
    ect_trace_t *trace;         /**< records the run; NULL: none */
    /** Sends a frame out of the chain at an end. Not NULL. Must not call the exchange. */
    void (*send)(void *ctx, ect_end_t end, const uint8_t *frame, size_t length);
    /** Returns the present time, nanoseconds; never decreases. Not NULL. */
    uint64_t (*clock)(void *ctx);
    void *ctx;         /**< argument of both */
    ect_stats_t stats; /**< may be read at any time */
    uint64_t run_ns;   /**< time of the last ::ect_exchange_run */
    /* Private. */
    ect_late_t late[ECT_ENDS];
    ect_late_t behind[ECT_ENDS]; /* replies that leave after the next one */
    uint64_t deadline_ns;        /* next deadline of the devices */
    uint64_t polled_ns;          /* latest time passed to the chain */
    uint64_t touched_ns;         /* last frame or client since the last run of the devices; ECT_NEVER: none */
    uint64_t answered_ns;        /* time of a reply that has just left; 0: the clock must be read */
    ect_datagrams_t datagrams;   /* of the replies, for clients of the control socket */
    bool linked[ECT_ENDS];       /* as set by ect_exchange_link */
} ect_exchange_t;

/** Passes counters, faults and the trace to a control socket that the exchange has received after its start. */
void ect_exchange_show(ect_exchange_t *x);

/** Starts the exchange: counters keep their values, except the time of the start. */
void ect_exchange_start(ect_exchange_t *x);

/**
 * Passes a frame that has arrived through faults, filter and chain, and sends its reply, or keeps it until
 * ::ect_exchange_run finds it due. The devices run with the next ::ect_exchange_run. `stats.frames` is the caller's.
 * @param in      end where the frame enters; the link there is set (::ect_chain_set_link)
 * @param frame   changed in place
 * @param length  at most ECT_EXCHANGE_FRAME
 * @param time    arrival, not before the time of the previous call
 */
void ect_exchange_frame(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, const ect_packet_time_t *time);

/**
 * @return whether frames pass only the chain: no trace, filter, fault or late reply. A program that has the chain's
 * replies in advance may then send them (bus/kernel).
 */
bool ect_exchange_is_plain(const ect_exchange_t *x);

/**
 * Passes a frame through the chain whose reply has already been sent by the kernel. The devices run before at each of
 * their deadlines, and when one that takes part in the frame has yet to run since an earlier frame
 * (::ect_chain_awaits_poll), so they receive the outputs of each frame; their inputs leave with the next
 * ::ect_exchange_run (::ect_chain_catch_up). A time before the last one that the chain has received counts as that one.
 * @param took_ns  time that the reply took, for `stats`
 */
void ect_exchange_replied(ect_exchange_t *x, uint8_t *frame, size_t length, uint64_t now_ns, uint32_t took_ns);

/**
 * Passes a frame that is too long for EtherCAT and for ::ect_exchange_frame: controllers count the frame; there is no
 * reply. `frame` has at least the first ECT_EXCHANGE_FRAME of its `length` bytes.
 */
void ect_exchange_long_frame(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns);

/** Plugs a cable in at an end, or pulls it (::ect_chain_set_link). */
void ect_exchange_link(ect_exchange_t *x, ect_end_t end, bool link);

/** Announces a change of the chain by the caller, other than by a frame. @return the present time */
uint64_t ect_exchange_touch(ect_exchange_t *x);

/**
 * Sends due replies, runs the devices at each of their deadlines (at most 64 successive ones), and executes due steps
 * of the scenario.
 * @return the time of the next call without a frame; ECT_NEVER: not necessary
 */
uint64_t ect_exchange_run(ect_exchange_t *x);

/** Switches all twins off and on (::ect_chain_power_cycle); kept replies are dropped. */
void ect_exchange_power_cycle(ect_exchange_t *x);

/**
 * Records a request that changes the chain (bus/control/change.h); due after ::ect_exchange_touch and before the
 * change.
 */
void ect_exchange_request(ect_exchange_t *x, const char *request, size_t length);

/** Ends the exchange and drops kept replies. */
void ect_exchange_end(ect_exchange_t *x);

ECT_C_END

#endif
