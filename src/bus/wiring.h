/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The plugs of every slave, as signals `ecat.plug_*` beside those of its lamps: pull one, and the wire is cut there.
 */
#ifndef ECT_BUS_WIRING_H
#define ECT_BUS_WIRING_H

#include <stdint.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The plugs of one slave: 1 plugged in, 0 pulled. A wire has two, one at either end. */
typedef struct ect_wiring {
    uint8_t plug_in;  /**< port 0, towards the master */
    uint8_t plug_out; /**< port 1 */
} ect_wiring_t;

/** A plant with nothing but the signals of an ect_wiring_t, which is its instance. */
extern const ect_plant_t ect_wiring_plant;

ECT_C_END

#endif
