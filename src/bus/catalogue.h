/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The catalogue: every device that can be put on a bus, by name. Adding a device is adding one line to catalogue.c.
 */
#ifndef ECT_BUS_CATALOGUE_H
#define ECT_BUS_CATALOGUE_H

#include <stddef.h>

#include "seams/device.h"

/** The devices in the order of `ectwin list`; constant. @param[out] count  how many */
const ect_device_t *const *ect_catalogue(size_t *count);

/** @return the device of that name, or NULL */
const ect_device_t *ect_catalogue_find(const char *name);

#endif
