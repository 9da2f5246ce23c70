/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The Vision Remote EC-Link base unit (BU), TS-0007 rev 11: a device for each of four operational modes.
 *
 *   Map1      Input Only          66 /   0 bytes   (FMAP 1)
 *   Map3      Input + Commands    66 /  24 bytes   (FMAP 3)
 *   Map7      Standard            66 / 228 bytes   (FMAP 7)
 *   MultiArm  three remotes      142 / 228 bytes   (FMAP 15)
 */
#ifndef ECT_DEVICES_ECLINK_H
#define ECT_DEVICES_ECLINK_H

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

extern const ect_device_t ect_eclink_map1;
extern const ect_device_t ect_eclink_map3;
extern const ect_device_t ect_eclink_map7;
extern const ect_device_t ect_eclink_multiarm;

/** The operator's side of all four. */
extern const ect_plant_t ect_eclink_plant;

ECT_C_END

#endif
