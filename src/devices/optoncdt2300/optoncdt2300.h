/* SPDX-License-Identifier: MIT */
/**
 * @file
 * MICRO-EPSILON optoNCDT 2300 laser distance sensor. docs/devices/optoncdt2300.md says what of it stands in the manual
 * that we have one page of (A 7.2.5, A 7.2.6), what in pages of it that are public, and what is our assumption.
 *
 * The plant is played by signals: up to two surfaces that move, what the light finds of them, noise, laser,
 * temperature.
 */
#ifndef ECT_DEVICES_OPTONCDT2300_H
#define ECT_DEVICES_OPTONCDT2300_H

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Description `optoncdt2300`; constant. */
extern const ect_device_t ect_optoncdt2300;

/** What the sensor looks at, and its operator. */
extern const ect_plant_t ect_optoncdt2300_plant;

ECT_C_END

#endif
