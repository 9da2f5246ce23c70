/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The OMRON FZM1 vision sensor as an EtherCAT slave (Q179-E1-01): command area 20 bytes, response area 16, output
 * area 32.
 */
#ifndef ECT_DEVICES_FZM1_H
#define ECT_DEVICES_FZM1_H

#include "seams/plant.h"

extern const ect_device_t ect_fzm1;
extern const ect_plant_t ect_fzm1_plant;

#endif
