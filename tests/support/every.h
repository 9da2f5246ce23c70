/* SPDX-License-Identifier: MIT */
/** @file All devices: those made for tests, then the catalogue. */
#ifndef TESTS_SUPPORT_EVERY_H
#define TESTS_SUPPORT_EVERY_H

#include <stddef.h>

#include "seams/plant.h"

/* NULL at the end. */
const ect_device_t *every_device(size_t i);
/* The devices of the catalogue; NULL at the end. */
const ect_device_t *every_product(size_t i);
/* Its SyncManagers of the process data, or of the mailbox, one bit each; and the first of a type, ECT_SMS: none. */
unsigned int process_sms_of(const ect_device_t *device);
unsigned int mailbox_sms_of(const ect_device_t *device);
unsigned int first_sm_of(const ect_device_t *device, uint8_t type);
/* Whether a master may use SDO with it. */
bool has_coe(const ect_device_t *device);

/* The plant of a device: that of the catalogue, or none. */
const ect_plant_t *plant_of(const ect_device_t *device);

#endif
