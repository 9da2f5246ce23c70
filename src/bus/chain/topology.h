/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Topology: the wires between slaves, and the path of a frame over these wires. A line, or a tree with junctions.
 *
 * A controller passes frames from port 0 through its processing unit; the order of the ports is 0, 3, 1, 2, and 0
 * again, without closed ports (data sheet I §3). A master therefore finds the slaves of a junction in the order of the
 * ports 3, 1, 2.
 *
 * This file uses no clock and no sockets. Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_TOPOLOGY_H
#define ECT_BUS_CHAIN_TOPOLOGY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_TOPOLOGY_PORTS = 4 };

/** No slave: before the first one, and behind a port without a wire. */
#define ECT_TOPOLOGY_NONE SIZE_MAX

/** The wires of one slave. */
typedef struct ect_topology_node {
    size_t up;                       /**< slave at port 0; ECT_TOPOLOGY_NONE for the first */
    uint8_t up_port;                 /**< port of that slave, 1..3 */
    size_t down[ECT_TOPOLOGY_PORTS]; /**< slave at each port; [0] is not used */
} ect_topology_node_t;

/** A port of a slave, at which a frame arrives or leaves. */
typedef struct ect_topology_place {
    size_t slave;
    unsigned int port;
} ect_topology_place_t;

/** @return whether the chip of a slave has a port */
typedef bool (*ect_topology_has_port_t)(const void *ctx, size_t slave, unsigned int port);

/**
 * Connects slaves according to `up` and `up_port`; with up_port 0, to port 1 of the previous slave.
 * @param[in,out] nodes  `count` of them, 1 or more: `up` and `up_port` are read, the other members are written
 * @return count: done; else the slave that cannot be connected: `up` is not an earlier slave, the port does not exist,
 * or another slave is connected to the port
 */
size_t ect_topology_lay(ect_topology_node_t *nodes, size_t count, ect_topology_has_port_t has_port, const void *ctx);

/** The kinds of a wire's other end. */
typedef enum ect_topology_end {
    ECT_TOPOLOGY_SLAVE,  /**< a port of a slave, in `*to` */
    ECT_TOPOLOGY_MASTER, /**< the master, before port 0 of the first slave */
    ECT_TOPOLOGY_FAR,    /**< behind port 1 of the last slave: not connected, or the master's second interface */
    ECT_TOPOLOGY_OPEN,   /**< no wire */
} ect_topology_end_t;

/** Finds the other end of the wire at a port. @param[out] to  set with ECT_TOPOLOGY_SLAVE. Cost: constant. */
ect_topology_end_t ect_topology_across(const ect_topology_node_t *nodes, size_t count, ect_topology_place_t from,
                                       ect_topology_place_t *to);

ECT_C_END

#endif
