/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The catalogue: every product that can be put on a bus, by name. A device of this tree needs one line in catalogue.c;
 * a program with further devices adds them when it starts (programs/ectwin/ectwin.h).
 */
#ifndef ECT_BUS_CHAIN_CATALOGUE_H
#define ECT_BUS_CHAIN_CATALOGUE_H

#include <stddef.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * The products by position: those of this tree in the order of `ectwin list`, then those added.
 * @return NULL: `index` is past the last
 */
const ect_product_t *ect_catalogue_at(size_t index);

/** Finds a product by the name of its device. @return the first product with that name; NULL: none */
const ect_product_t *ect_catalogue_find(const char *name);

/**
 * Adds the products of a program, and removes products added before.
 * @param more  `count` of them; must outlive every use of the catalogue
 * Context: while the program starts, before another thread uses the catalogue.
 */
void ect_catalogue_add(const ect_product_t *more, size_t count);

ECT_C_END

#endif
