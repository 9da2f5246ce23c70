/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The dictionary of a device as SOES's stack wants it: `SDOobjects`, made at the start, for its entries lie in the
 * device's instance.
 */
#ifndef FIRMWARE_ON_SOES_OBJECTS_H
#define FIRMWARE_ON_SOES_OBJECTS_H

#include <stdbool.h>

#include "seams/device.h"

/** Fills SDOobjects. `instance` lives as long as the program. @return false: it has more objects or entries than fit */
bool objects_make(const ect_device_t *device, void *instance);

#endif
