/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The surroundings of every slave's chip as signals (ecat.NAME): plugs (a pulled plug cuts the wire), latch inputs,
 * oscillator.
 */
#ifndef ECT_BUS_CHAIN_WIRING_H
#define ECT_BUS_CHAIN_WIRING_H

#include <stdint.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The surroundings of one slave. Plugs: 1 plugged in, 0 pulled; a wire has one at each end. */
typedef struct ect_wiring {
    uint8_t plug[4];   /**< by port: 0 input, towards the master; 1 output; 2, 3 junction */
    uint8_t latch[2];  /**< level of the inputs LATCH0 and LATCH1 */
    int32_t drift_ppb; /**< deviation of the oscillator; > 0: fast */
} ect_wiring_t;

/** The signals of an ect_wiring_t; the instance is the structure. */
extern const ect_plant_t ect_wiring_plant;

ECT_C_END

#endif
