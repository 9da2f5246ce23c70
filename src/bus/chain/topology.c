/* SPDX-License-Identifier: MIT */
#include "bus/chain/topology.h"
#include "wire/assert.h"

enum { OUTPUT = 1 };

size_t ect_topology_lay(ect_topology_node_t *nodes, size_t count, ect_topology_has_port_t has_port, const void *ctx)
{
    for (size_t i = 0; i < count; i++) {
        ect_topology_node_t *node = &nodes[i];
        for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++)
            node->down[port] = ECT_TOPOLOGY_NONE;
        if (i == 0) {
            node->up = ECT_TOPOLOGY_NONE;
            continue;
        }
        if (node->up_port == 0) {
            node->up = i - 1;
            node->up_port = OUTPUT;
        }
        if (node->up >= i || node->up_port >= ECT_TOPOLOGY_PORTS || !has_port(ctx, node->up, node->up_port) ||
            nodes[node->up].down[node->up_port] != ECT_TOPOLOGY_NONE)
            return i;
        nodes[node->up].down[node->up_port] = i;
    }
    return count;
}

ect_topology_end_t ect_topology_across(const ect_topology_node_t *nodes, size_t count, ect_topology_place_t from,
                                       ect_topology_place_t *to)
{
    ECT_ASSERT(from.slave < count && from.port < ECT_TOPOLOGY_PORTS);
    const ect_topology_node_t *node = &nodes[from.slave];
    if (from.port == 0) {
        *to = (ect_topology_place_t){.slave = node->up, .port = node->up_port};
        return from.slave == 0 ? ECT_TOPOLOGY_MASTER : ECT_TOPOLOGY_SLAVE;
    }
    *to = (ect_topology_place_t){.slave = node->down[from.port], .port = 0};
    if (to->slave != ECT_TOPOLOGY_NONE)
        return ECT_TOPOLOGY_SLAVE;
    return from.slave + 1 == count && from.port == OUTPUT ? ECT_TOPOLOGY_FAR : ECT_TOPOLOGY_OPEN;
}
