/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The catalogue: every product that can be put on a bus, by name. Adding a device is adding one line to catalogue.c.
 */
#ifndef ECT_BUS_CATALOGUE_H
#define ECT_BUS_CATALOGUE_H

#include <stddef.h>

#include "seams/plant.h"

/** The products in the order of `ectwin list`; constant. @param[out] count  how many */
const ect_product_t *ect_catalogue(size_t *count);

/** @return the product whose device has that name, or NULL */
const ect_product_t *ect_catalogue_find(const char *name);

#endif
