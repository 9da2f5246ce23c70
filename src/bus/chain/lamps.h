/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a passer-by sees on every slave: its EtherCAT lamps and, for those who cannot read them, AL state and code. As
 * signals `ecat.*` of each twin, beside those of its device.
 */
#ifndef ECT_BUS_CHAIN_LAMPS_H
#define ECT_BUS_CHAIN_LAMPS_H

#include <stdbool.h>
#include <stdint.h>

#include "seams/plant.h"
#include "slave/slave.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_LAMP_TEXT = 16 };

typedef struct ect_lamps {
    uint64_t seen;    /* what they depend on, as it was at the last look */
    uint8_t al_state; /* 1, 2, 3, 4, 8; 0: off the bus */
    uint16_t al_code;
    char text[4][ECT_LAMP_TEXT];
} ect_lamps_t;

/** The signals of an ect_lamps_t, which is the instance. */
extern const ect_plant_t ect_lamps_plant;

/**
 * Brings the lamps up to date.
 * @param in_link, out_link  whether something is connected before and behind this slave
 * @param last_frame_ns  when a frame last came by, 0 never; without another one they change
 *                       ECT_INDICATOR_TRAFFIC_NS later
 */
void ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link, uint64_t last_frame_ns,
                      uint64_t now_ns);

ECT_C_END

#endif
