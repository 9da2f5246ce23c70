/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The Pilz PMCtendo DD5 (PMCprotego D) servo amplifier as an EtherCAT slave (manual 1002906-EN-02): a mailbox of 16
 * bytes, one fixed PDO for each direction, chosen by the master, and a motor.
 */
#ifndef ECT_DEVICES_PMCTENDO_H
#define ECT_DEVICES_PMCTENDO_H

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

extern const ect_device_t ect_pmctendo_dd5;
extern const ect_plant_t ect_pmctendo_dd5_plant;

ECT_C_END

#endif
