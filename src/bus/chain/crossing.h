/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The ends of a chain, the wires between its slaves, and a guard that gets each frame on a wire.
 */
#ifndef ECT_BUS_CHAIN_CROSSING_H
#define ECT_BUS_CHAIN_CROSSING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** The two ends of a chain, where frames enter and leave. */
typedef enum ect_end {
    ECT_END_IN,   /**< port 0 of the first slave: the master */
    ECT_END_OUT,  /**< port 1 of the last slave: not connected, or the master's second interface (cable redundancy) */
    ECT_END_NONE, /**< neither: the frame is lost */
} ect_end_t;
enum { ECT_ENDS = ECT_END_NONE };

/** A frame on a wire. */
typedef struct ect_crossing {
    size_t wire; /**< position of the slave at whose port 0 the wire ends; the number of slaves: behind the last one */
    bool back;   /**< true: towards the master; false: away from the master */
    uint8_t *frame; /**< `length` bytes, from the destination address on, without the check sum */
    size_t length;  /**< a guard may reduce it */
    bool damaged;   /**< the check sum is wrong; a guard may set it */
    bool noticed;   /**< a controller has already counted the wrong check sum */
} ect_crossing_t;

/**
 * Gets a frame on each wire that the frame crosses, in order, and may change the frame.
 * @param crossing  valid during the call
 * @return true: the frame continues; false: it ends on this wire
 */
typedef bool (*ect_guard_t)(void *ctx, ect_crossing_t *crossing);

ECT_C_END

#endif
