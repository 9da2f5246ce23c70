/* SPDX-License-Identifier: MIT */
/** @file Every device that there is: those made for tests, then the catalogue. */
#ifndef TESTS_SUPPORT_EVERY_H
#define TESTS_SUPPORT_EVERY_H

#include <stddef.h>

#include "seams/plant.h"

/* NULL at the end. */
const ect_device_t *every_device(size_t i);
/* Those of the catalogue only; NULL at the end. */
const ect_device_t *every_product(size_t i);
/* Its SyncManagers of the process data, or of the mailbox, a bit each; and the first of a type, ECT_SMS: none. */
unsigned int process_sms_of(const ect_device_t *device);
unsigned int mailbox_sms_of(const ect_device_t *device);
unsigned int first_sm_of(const ect_device_t *device, uint8_t type);
/* Whether a master may ask it by SDO. */
bool has_coe(const ect_device_t *device);

/* What stands around a device: that of the catalogue, or nothing. */
const ect_plant_t *plant_of(const ect_device_t *device);

#endif
