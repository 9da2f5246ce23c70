/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Faults (bus/chain/fault.h) on one wire of a chain: frames are lost, damaged, truncated, changed or kept. Slaves
 * behind the wire receive the changed frame.
 *
 * This file uses no clock; the random generator uses the caller's seed. Context: the thread of the runner. Cost: none
 * for a frame without such a fault while no frame is kept; one allocation for each kept frame.
 */
#ifndef ECT_BUS_FAULTS_WIRES_H
#define ECT_BUS_FAULTS_WIRES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/chain/fault.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** A frame that waits for the next one (reorder) continues after ECT_WIRES_BEHIND_NS at the latest. */
enum { ECT_WIRES_BEHIND_NS = 10000000 };

/** Limits: faults of a frame, and kept frames; further frames are lost. */
enum { ECT_WIRES_FAULTS = 8, ECT_WIRES_KEPT = 4096 };

/** A frame kept on a wire. Members are read-only for callers. */
typedef struct ect_kept {
    struct ect_kept *next;
    uint64_t due_ns;    /**< time at which the frame continues ... */
    uint64_t due_frame; /**< ... but not before this number of frames has arrived ... */
    uint64_t latest_ns; /**< ... or this time is reached */
    bool slow;          /**< later frames on the wire wait for it */
    ect_end_t end;      /**< end at which the frame has left the chain, once released */
    ect_crossing_t at;  /**< at.frame is the member below */
    uint8_t frame[];
} ect_kept_t;

/** The effect of the wires on a frame. */
typedef enum ect_wires_result { ECT_WIRES_PASSED, ECT_WIRES_LOST, ECT_WIRES_KEEP } ect_wires_result_t;

/** Zeroed: no faults. Private, except `result` and `cut`. */
typedef struct ect_wires {
    uint32_t *seed;
    uint64_t now_ns, frames;
    ect_fault_t faults[ECT_WIRES_FAULTS]; /* of this frame */
    size_t fault_count;
    ect_kept_t *kept; /* in the order of arrival */
    size_t kept_count;
    ect_wires_result_t result; /**< of the last frame */
    size_t cut;                /**< bytes removed from the end of the last frame */
} ect_wires_t;

/** Begins a frame without faults. @param seed  of the random generator; used until the frame has passed the chain */
void ect_wires_begin(ect_wires_t *wires, uint32_t *seed, uint64_t now_ns);

/** Adds a fault with a wire to the frame. Faults beyond ECT_WIRES_FAULTS are ignored. */
void ect_wires_add(ect_wires_t *wires, const ect_fault_t *fault);

/** Sets the guard of the chain, so that the faults act on the next pass of the frame. */
void ect_wires_end(ect_wires_t *wires, ect_chain_t *chain);

/**
 * Continues with a due frame, without faults, from the wire on which it was kept.
 * @return the frame, for the caller to free(), after it has left at `end` with at.length bytes; NULL: none is due
 */
ect_kept_t *ect_wires_release(ect_wires_t *wires, ect_chain_t *chain, uint64_t now_ns);

/** @return the time at which a frame is due; ECT_NEVER: none, or none by time alone */
uint64_t ect_wires_due(const ect_wires_t *wires);

/** Frees the frames that are kept. */
void ect_wires_clear(ect_wires_t *wires);

/** Inverts a random bit after the first datagram's header, or any bit of a frame that no controller would read. */
void ect_frame_corrupt(uint32_t *seed, uint8_t *frame, size_t length);

/** Adds to the working counter of the first datagram; no effect on a frame that no controller would read. */
void ect_frame_count(uint8_t *frame, size_t length, int32_t by);

ECT_C_END

#endif
