/* SPDX-License-Identifier: MIT */
#include "bus/chain/delays.h"

#include <stdlib.h>

/* Delays of two PHYs, and of a metre of cable. */
enum { PHYS_NS = 400, METRE_NS = 5 };

/* A frame on its way through the chain, and the time since its entry. */
typedef struct walk {
    ect_topology_place_t at;
    uint32_t ns;
    uint8_t *seen; /* by twin: bit n port n, bit 4 the processing unit */
} walk_t;

enum { UNIT = 4 };

static uint32_t wire_ns(const ect_cabling_t *cabling, size_t wire)
{
    uint32_t metres = wire < cabling->count ? cabling->twins[wire].config.cable_m : 0;
    return PHYS_NS + METRE_NS * metres;
}

/* Sets the arrival at a place, unless the frame has been there before. */
static void note_time(uint8_t *seen, unsigned int bit, uint32_t *time_ns, uint32_t now_ns)
{
    if ((*seen & (1u << bit)) == 0)
        *time_ns = now_ns;
    *seen = (uint8_t)(*seen | (1u << bit));
}

/* Passes one controller. @return whether the frame leaves the controller, at walk->at */
static bool through_one(ect_cabling_t *cabling, walk_t *walk)
{
    ect_twin_t *twin = &cabling->twins[walk->at.slave];
    const ect_esc_personality_t *chip = twin->esc.config.personality;
    ect_esc_arrival_t arrival = twin->esc.arrival;
    uint8_t *seen = &walk->seen[walk->at.slave];
    unsigned int port = walk->at.port;
    bool unit_seen = (*seen & (1u << UNIT)) != 0;
    note_time(seen, port, &arrival.port_ns[port], walk->ns);
    unsigned int out = ect_esc_next_port(&twin->esc, port);
    bool circulates = out == 0 && ect_esc_circulates(&twin->esc);
    if (port != 0)
        walk->ns += chip->forwarding_ns;
    if (port == 0 || circulates) {
        note_time(seen, UNIT, &arrival.unit_ns, walk->ns);
        walk->ns += chip->processing_ns;
    }
    ect_esc_set_arrival(&twin->esc, &arrival);
    walk->at.port = circulates ? ect_esc_next_port(&twin->esc, 0) : out;
    return !(circulates && (unit_seen || walk->at.port == 0)) && twin->link[walk->at.port];
}

static void follow(ect_cabling_t *cabling, walk_t walk)
{
    ect_topology_place_t far;
    while ((walk.at.port == 0 || ect_esc_port_open(&cabling->twins[walk.at.slave].esc, walk.at.port)) &&
           through_one(cabling, &walk)) {
        walk.ns += wire_ns(cabling, ect_cabling_wire(cabling, walk.at));
        if (ect_cabling_across(cabling, walk.at, &far) != ECT_TOPOLOGY_SLAVE)
            return;
        walk.at = far;
    }
}

void ect_delays_update(ect_cabling_t *cabling)
{
    uint8_t *seen = calloc(cabling->count, 1);
    if (!seen)
        return;
    if (cabling->twins[0].link[0])
        follow(cabling, (walk_t){.at = {0, 0}, .seen = seen});
    if (cabling->link[ECT_END_OUT])
        follow(cabling, (walk_t){.at = {cabling->count - 1, 1}, .seen = seen});
    free(seen);
}
