/* SPDX-License-Identifier: MIT */
/**
 * @file
 * MICRO-EPSILON optoNCDT 2300 laser distance sensor. docs/devices/optoncdt2300.md cites the manual's pages A 7.2.5 and
 * A 7.2.6, the public pages, and the assumptions of the twin.
 *
 * Signals play the plant: up to two moving surfaces, their reflection, noise, laser, temperature.
 */
#ifndef ECT_DEVICES_OPTONCDT2300_H
#define ECT_DEVICES_OPTONCDT2300_H

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Description `optoncdt2300`; constant. */
extern const ect_device_t ect_optoncdt2300;

/** The target of the sensor, and its operator. */
extern const ect_plant_t ect_optoncdt2300_plant;

ECT_C_END

#endif
