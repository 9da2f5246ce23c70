/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Topology: who is plugged in where, and the way of a frame through it. A line, or a tree with junctions.
 *
 * A controller takes frames from port 0 through its processing unit; its ports follow each other as 0, 3, 1, 2, and 0
 * again, closed ones left out (data sheet I §3). So a master finds the slaves of a junction behind port 3 first, then
 * those behind port 1, then those behind port 2.
 *
 * No clock, no socket: what is asked here is where a frame goes next. Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_TOPOLOGY_H
#define ECT_BUS_CHAIN_TOPOLOGY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_TOPOLOGY_PORTS = 4 };

/** Nobody: what is before the first slave, and behind a port without a wire. */
#define ECT_TOPOLOGY_NONE SIZE_MAX

/** Where a slave is plugged in. */
typedef struct ect_topology_node {
    size_t up;                       /**< slave that its input (port 0) leads to; of the first one ECT_TOPOLOGY_NONE */
    uint8_t up_port;                 /**< port of that slave, 1..3 */
    size_t down[ECT_TOPOLOGY_PORTS]; /**< slave at each port; [0] is not used */
} ect_topology_node_t;

/** A frame arrives at, or leaves from, a port of a slave. */
typedef struct ect_topology_place {
    size_t slave;
    unsigned int port;
} ect_topology_place_t;

/** Whether the chip of a slave has a port. */
typedef bool (*ect_topology_has_port_t)(const void *ctx, size_t slave, unsigned int port);

/**
 * Lays the wires.
 * @param[in,out] nodes  `count` of them, 1 or more: `up` and `up_port` are read where up_port is not 0; else the slave
 * is plugged in at port 1 of the one before it. The rest is written
 * @return count: all can be so; else the slave that cannot: it is plugged in at a slave that does not come before it,
 * at a port that there is not, or where another one is
 */
size_t ect_topology_lay(ect_topology_node_t *nodes, size_t count, ect_topology_has_port_t has_port, const void *ctx);

/** What is at the other end of a wire. */
typedef enum ect_topology_end {
    ECT_TOPOLOGY_SLAVE,  /**< a slave: `*to` says which, and at which port the frame arrives */
    ECT_TOPOLOGY_MASTER, /**< before the input of the first slave */
    ECT_TOPOLOGY_FAR,    /**< behind port 1 of the last one: nothing, or the master's second interface */
    ECT_TOPOLOGY_OPEN,   /**< no wire */
} ect_topology_end_t;

/** Where a frame arrives that leaves from a port. Cost: none to speak of. */
ect_topology_end_t ect_topology_across(const ect_topology_node_t *nodes, size_t count, ect_topology_place_t from,
                                       ect_topology_place_t *to);

ECT_C_END

#endif
