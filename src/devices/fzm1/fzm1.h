/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The OMRON FZM1 vision sensor as an EtherCAT slave (Q179-E1-01): command area 20 bytes, response area 16, output
 * area 32.
 */
#ifndef ECT_DEVICES_FZM1_H
#define ECT_DEVICES_FZM1_H

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

extern const ect_device_t ect_fzm1;
extern const ect_plant_t ect_fzm1_plant;

ECT_C_END

#endif
