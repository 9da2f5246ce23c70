/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The common effect of a chain on each frame while only frames access the chain, for code that computes replies in
 * advance (bus/kernel). The values are valid until the next call of the chain, and for any number of frames with cyclic
 * data.
 */
#ifndef ECT_BUS_CHAIN_STEADY_H
#define ECT_BUS_CHAIN_STEADY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The sum of all ESCs on the way of a frame, which enters and leaves at ECT_END_IN. */
typedef struct ect_chain_steady {
    size_t reach;             /**< ESCs reached by a frame, from position 0 on */
    unsigned int time_takers; /**< of these, ESCs that take a written system time */
    uint16_t events;          /**< ECAT events collected by datagrams */
    uint16_t al_status;       /**< bits of AL status (0x0130), ORed over all ESCs */
    bool al_status_new;       /**< an AL status is unread; reading it clears an event */
    bool marks_source;        /**< the source address gets its "locally administered" bit */
    uint64_t version;         /**< changes with station addresses, FMMUs and power of the ESCs */
} ect_chain_steady_t;

/**
 * Checks whether time, cables and faults leave the replies to frames unchanged.
 * @return false: no, or the chain is not a line whose frames take the fast path; `steady` is not set
 */
bool ect_chain_steady(ect_chain_t *chain, ect_chain_steady_t *steady);

/** Called for an ESC. @return whether to continue */
typedef bool (*ect_chain_visit_t)(void *ctx, size_t position, const ect_esc_t *esc);

/**
 * Visits the ESCs on the way that map a part of a range of logical addresses, in the order of the wire.
 * @param direction  ECT_PART_READ, ECT_PART_WRITE or both
 * @return whether each visit returned true
 */
bool ect_chain_visit_mapped(ect_chain_t *chain, uint32_t first, uint16_t length, unsigned int direction,
                            ect_chain_visit_t visit, void *ctx);

/**
 * Finds the ESC that an ARMW or FRMW reads, if exactly one ESC is read.
 * @param datagram     begins with its header
 * @param[out] takes   whether that ESC takes a written system time itself
 * @return NULL: no ESC, or several
 */
const ect_esc_t *ect_chain_time_source(ect_chain_t *chain, const uint8_t *datagram, bool *takes);

ECT_C_END

#endif
