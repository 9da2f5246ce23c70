/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What stands around the chip of every slave, as signals `ecat.*` beside those of its lamps: its plugs (pull one, and
 * the wire is cut there), its latch inputs, its oscillator.
 */
#ifndef ECT_BUS_CHAIN_WIRING_H
#define ECT_BUS_CHAIN_WIRING_H

#include <stdint.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Of one slave. Plugs: 1 plugged in, 0 pulled; a wire has two, one at either end. */
typedef struct ect_wiring {
    uint8_t plug[4];  /**< by port: 0 the input, towards the master; 1 the output; 2 and 3 of a junction */
    uint8_t latch[2]; /**< level of the inputs LATCH0 and LATCH1 */
    int32_t drift_ppb;
} ect_wiring_t;

/** A plant with nothing but the signals of an ect_wiring_t, which is its instance. */
extern const ect_plant_t ect_wiring_plant;

ECT_C_END

#endif
