/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A frame on its way through a chain, controller by controller and wire by wire. Internal to bus/chain.
 *
 * This path is the reference: it handles every frame, every link state and guards. bus/chain/fast.h is the shortcut for
 * plain frames on a plain line. This file uses no clock and no heap. Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_PASSAGE_H
#define ECT_BUS_CHAIN_PASSAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "bus/chain/cabling.h"
#include "bus/chain/crossing.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_passage {
    ect_crossing_t c;
    uint64_t now_ns;
    ect_guard_t guard; /* NULL: none */
    void *guard_ctx;
} ect_passage_t;

/** Passes a frame that enters at an end of the chain. @return the end where the frame leaves; ECT_END_NONE: lost */
ect_end_t ect_passage_enter(ect_cabling_t *cabling, ect_end_t in, ect_passage_t *passage);

/** Passes a frame that arrives at a port with link. @return the end where the frame leaves; ECT_END_NONE: lost */
ect_end_t ect_passage_walk(ect_cabling_t *cabling, ect_topology_place_t at, ect_passage_t *passage);

/**
 * Finds the far end of a frame's wire.
 * @param[out] at  on true the port where the frame arrives
 * @param[out] out  on false the end of the chain where the frame leaves; ECT_END_NONE: the frame is lost
 * @return whether the frame arrives at a slave
 */
bool ect_passage_arrival(const ect_cabling_t *cabling, const ect_crossing_t *c, ect_topology_place_t *at,
                         ect_end_t *out);

ECT_C_END

#endif
