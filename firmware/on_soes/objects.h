/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The dictionary of a device for SOES's stack: `SDOobjects`, made at the start, because its entries are in the device's
 * instance.
 */
#ifndef FIRMWARE_ON_SOES_OBJECTS_H
#define FIRMWARE_ON_SOES_OBJECTS_H

#include <stdbool.h>

#include "seams/device.h"

/**
 * Fills SDOobjects. `instance` must stay valid until the end of the program. @return false: too many objects or entries
 */
bool objects_make(const ect_device_t *device, void *instance);

#endif
