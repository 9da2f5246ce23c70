/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The twins of a chain and the wires between them. Internal to bus/chain.
 *
 * A wire has link when it is plugged in at both ends and both twins are switched on. This file uses no clock. Context:
 * the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_CABLING_H
#define ECT_BUS_CHAIN_CABLING_H

#include <stdbool.h>
#include <stddef.h>

#include "bus/chain/crossing.h"
#include "bus/chain/topology.h"
#include "bus/chain/twin.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_cabling {
    size_t count;
    ect_twin_t *twins;          /* `count` of them */
    ect_topology_node_t *nodes; /* wires at the ports of each twin */
    bool link[ECT_ENDS];        /* whether a cable is plugged in at this end of the chain */
    bool line;                  /* a line: each twin is at port 1 of the previous twin */
} ect_cabling_t;

/** Checks the wires of twins (::ect_chain_check_wires). @return count, or the position of the first invalid twin */
size_t ect_cabling_check(const ect_twin_config_t *twins, size_t count);

/**
 * Wires twins that are not yet powered on, and sets their links.
 * @param[in,out] cabling  `count` and `twins` are set
 * @return false: out of memory, or ::ect_cabling_check refuses the wires; ::ect_cabling_free frees the rest
 */
bool ect_cabling_lay(ect_cabling_t *cabling, const ect_twin_config_t *twins);

/** Frees the wires, not the twins. */
void ect_cabling_free(ect_cabling_t *cabling);

/** @return whether the link of a port of a twin has changed since the last update. Cost: four ports */
bool ect_cabling_changed(const ect_cabling_t *cabling, size_t i);

/** Sets the links of a twin in its ESC. @return whether a link has changed */
bool ect_cabling_update(ect_cabling_t *cabling, size_t i);

/**
 * @return the wire at a port, as in ect_crossing_t::wire: the slave at whose port 0 it ends, or the number of slaves.
 */
size_t ect_cabling_wire(const ect_cabling_t *cabling, ect_topology_place_t at);

/** @return the other end of the wire at a port (::ect_topology_across). */
static inline ect_topology_end_t ect_cabling_across(const ect_cabling_t *cabling, ect_topology_place_t from,
                                                    ect_topology_place_t *to)
{
    return ect_topology_across(cabling->nodes, cabling->count, from, to);
}

ECT_C_END

#endif
