/* SPDX-License-Identifier: MIT */
#include "bus/chain/cabling.h"

#include <stdlib.h>

#include "wire/assert.h"

static bool chip_has_port(const void *ctx, size_t slave, unsigned int port)
{
    const ect_twin_config_t *twins = ctx;
    const ect_esc_personality_t *chip = ect_twin_chip(&twins[slave]);
    return chip && (chip->ports & (1u << port)) != 0;
}

/* To be freed by the caller; NULL: out of memory. */
static ect_topology_node_t *nodes_of(const ect_twin_config_t *twins, size_t count)
{
    ect_topology_node_t *nodes = calloc(count, sizeof *nodes);
    for (size_t i = 0; nodes && i < count; i++)
        nodes[i] = (ect_topology_node_t){.up = twins[i].up, .up_port = twins[i].up_port};
    return nodes;
}

size_t ect_cabling_check(const ect_twin_config_t *twins, size_t count)
{
    ect_topology_node_t *nodes = nodes_of(twins, count);
    size_t wrong = nodes ? ect_topology_lay(nodes, count, chip_has_port, twins) : count;
    free(nodes);
    return wrong;
}

/* Initially all plugs are plugged in, and nothing is connected behind the last slave. */
static void plug_all_in(ect_cabling_t *cabling)
{
    for (size_t i = 0; i < cabling->count; i++) {
        for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++) {
            ect_topology_place_t far;
            ect_topology_end_t end = ect_cabling_across(cabling, (ect_topology_place_t){i, port}, &far);
            cabling->twins[i].link[port] = end == ECT_TOPOLOGY_SLAVE || end == ECT_TOPOLOGY_MASTER;
        }
    }
}

bool ect_cabling_lay(ect_cabling_t *cabling, const ect_twin_config_t *twins)
{
    cabling->link[ECT_END_IN] = true;
    cabling->nodes = nodes_of(twins, cabling->count);
    if (!cabling->nodes || ect_topology_lay(cabling->nodes, cabling->count, chip_has_port, twins) != cabling->count)
        return false;
    cabling->line = true;
    for (size_t i = 1; i < cabling->count; i++)
        cabling->line &= cabling->nodes[i - 1].down[1] == i;
    plug_all_in(cabling);
    return true;
}

void ect_cabling_free(ect_cabling_t *cabling)
{
    free(cabling->nodes);
}

static bool plugged(const ect_cabling_t *cabling, ect_topology_place_t at)
{
    const ect_twin_t *twin = &cabling->twins[at.slave];
    return ect_twin_on_bus(twin) && twin->wiring.plug[at.port] != 0;
}

/* Whether the wire at a port is plugged in at both ends. */
static bool has_link(const ect_cabling_t *cabling, ect_topology_place_t at)
{
    ect_topology_place_t far;
    switch (ect_cabling_across(cabling, at, &far)) {
    case ECT_TOPOLOGY_SLAVE:
        return plugged(cabling, at) && plugged(cabling, far);
    case ECT_TOPOLOGY_MASTER:
        return plugged(cabling, at) && cabling->link[ECT_END_IN];
    case ECT_TOPOLOGY_FAR:
        return plugged(cabling, at) && cabling->link[ECT_END_OUT];
    default:
        return false;
    }
}

bool ect_cabling_changed(const ect_cabling_t *cabling, size_t i)
{
    bool changed = false;
    for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++)
        changed |= cabling->twins[i].link[port] != has_link(cabling, (ect_topology_place_t){i, port});
    return changed;
}

bool ect_cabling_update(ect_cabling_t *cabling, size_t i)
{
    ect_twin_t *twin = &cabling->twins[i];
    bool changed = false;
    for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++) {
        bool link = has_link(cabling, (ect_topology_place_t){i, port});
        if (twin->link[port] == link)
            continue;
        twin->link[port] = link;
        ect_esc_set_link(&twin->esc, port, link);
        changed = true;
    }
    return changed;
}

size_t ect_cabling_wire(const ect_cabling_t *cabling, ect_topology_place_t at)
{
    ECT_ASSERT(at.slave < cabling->count && at.port < ECT_TOPOLOGY_PORTS);
    if (at.port == 0)
        return at.slave;
    size_t down = cabling->nodes[at.slave].down[at.port];
    return down == ECT_TOPOLOGY_NONE ? cabling->count : down;
}
