/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Faults (bus/chain/fault.h) that happen on one wire of a chain: what is lost, damaged, cut or changed there, and
 * frames that are kept there for a while. Those behind the wire see what is left of a frame, when it comes.
 *
 * No clock in here; chance comes from the caller's seed. Context: the thread of the runner. Cost: nothing for a frame
 * that no such fault concerns, while none is kept; an allocation for each that is kept.
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

/** Faults that may concern a frame; frames that may be kept at a time: more are lost. */
enum { ECT_WIRES_FAULTS = 8, ECT_WIRES_KEPT = 4096 };

/** A frame that is kept on a wire. Members are read only for others. */
typedef struct ect_kept {
    struct ect_kept *next;
    uint64_t due_ns;    /**< when it goes on ... */
    uint64_t due_frame; /**< ... but not before so many frames have come */
    bool slow;          /**< those behind it on the wire wait for it */
    ect_end_t end;      /**< where it has left, once it has gone on */
    ect_crossing_t at;  /**< its `frame` is the one below */
    uint8_t frame[];
} ect_kept_t;

/** What the wires have done to the last frame. */
typedef enum ect_wires_result { ECT_WIRES_PASSED, ECT_WIRES_LOST, ECT_WIRES_KEEP } ect_wires_result_t;

/** All zero: nothing happens. Private, but for `result` and `cut`. */
typedef struct ect_wires {
    uint32_t *seed;
    uint64_t now_ns, frames;
    ect_fault_t faults[ECT_WIRES_FAULTS]; /* of this frame */
    size_t fault_count;
    ect_kept_t *kept; /* in the order in which they came */
    size_t kept_count;
    ect_wires_result_t result; /**< of the last frame */
    size_t cut;                /**< bytes that it has lost at its end */
} ect_wires_t;

/** A frame has come, and no fault concerns it yet. @param seed  of the lots, until the frame is through */
void ect_wires_begin(ect_wires_t *wires, uint32_t *seed, uint64_t now_ns);

/** A fault concerns it, one with a wire; more than ECT_WIRES_FAULTS do not. */
void ect_wires_add(ect_wires_t *wires, const ect_fault_t *fault);

/** What is to happen to it happens when it passes through the chain next. */
void ect_wires_end(ect_wires_t *wires, ect_chain_t *chain);

/**
 * Lets a frame that is due go on, undisturbed, from the wire on which it was kept.
 * @return it, the caller's to free(): `end` says where it has left, with at.length bytes; NULL: none is due
 */
ect_kept_t *ect_wires_release(ect_wires_t *wires, ect_chain_t *chain, uint64_t now_ns);

/** @return when one is due; ECT_NEVER: none, or none by the time alone */
uint64_t ect_wires_due(const ect_wires_t *wires);

/** Forgets those that are kept. */
void ect_wires_clear(ect_wires_t *wires);

/** Changes a bit of a frame, by lot: from the first datagram's data on, or any where no controller would read it. */
void ect_frame_corrupt(uint32_t *seed, uint8_t *frame, size_t length);

/** Adds to the working counter of the first datagram of a frame; not to one that no controller would read. */
void ect_frame_count(uint8_t *frame, size_t length, int32_t by);

ECT_C_END

#endif
