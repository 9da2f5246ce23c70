/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The catalogue: every product that can be put on a bus, by name. Adding a device of this tree is adding one line to
 * catalogue.c; a program with devices of its own adds them when it starts (programs/ectwin/ectwin.h does so for a
 * command).
 */
#ifndef ECT_BUS_CHAIN_CATALOGUE_H
#define ECT_BUS_CHAIN_CATALOGUE_H

#include <stddef.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * The products by position: ours in the order of `ectwin list`, then those that were added.
 * @return the product, or NULL: `index` is past the last
 */
const ect_product_t *ect_catalogue_at(size_t index);

/** @return the product whose device has that name, the first one if several had; NULL: there is none */
const ect_product_t *ect_catalogue_find(const char *name);

/**
 * Adds the products of this program behind ours, in place of those that were added before.
 * @param more  `count` of them; kept, so they live as long as the catalogue is used
 * Context: while the program starts, before another thread uses the catalogue.
 */
void ect_catalogue_add(const ect_product_t *more, size_t count);

ECT_C_END

#endif
