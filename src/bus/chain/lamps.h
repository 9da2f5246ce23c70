/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EtherCAT lamps, the AL state and the AL status code of every slave as signals (ecat.NAME), in addition to the
 * device's.
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
    uint64_t seen;    /* state of the slave at the last update */
    uint8_t al_state; /* 1, 2, 3, 4, 8; 0: off the bus */
    uint16_t al_code;
    char text[4][ECT_LAMP_TEXT];
} ect_lamps_t;

/** The signals of an ect_lamps_t; the instance is the structure. */
extern const ect_plant_t ect_lamps_plant;

/**
 * Updates the lamps. Cost: a comparison without a change.
 * @param in_link, out_link  link at port 0 and at port 1
 * @param last_frame_ns  time of the last frame, 0 never; ECT_INDICATOR_TRAFFIC_NS later the lamps change
 */
void ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link, uint64_t last_frame_ns,
                      uint64_t now_ns);

ECT_C_END

#endif
