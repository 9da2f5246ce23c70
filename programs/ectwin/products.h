/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Products by the name that a user gives: of the catalogue, or `esi:FILE.xml#TYPE`, any vendor's device from its ESI.
 */
#ifndef ECTWIN_PRODUCTS_H
#define ECTWIN_PRODUCTS_H

#include <stdbool.h>

#include "esi/twin.h"

/** Room for the line that says why not. */
enum { PRODUCT_MESSAGE = 600 };

/**
 * Finds a product, or makes it from a file: then what of the file it cannot be is told on standard error.
 * @param modules, module_count  of a modular device from a file
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return the product, valid until the program ends, or NULL
 */
const ect_product_t *product_find(const char *name, const ect_module_choice_t *modules, size_t module_count,
                                  char *message);

/** Features that a twin of a file does not support are not listed from here on. */
void product_quiet(void);

/** @return the twin that a product of an ESI file is; NULL: it is none of a file */
const ect_esi_twin_t *product_twin(const ect_product_t *product);

/** The same for a device. */
const ect_esi_twin_t *product_twin_of_device(const ect_device_t *device);

/** @return what follows `esi:` in a name, NULL when it is none of a file */
const char *product_file(const char *name);

/** Lists the devices of a file: type, product, revision, name. @return false: it cannot be read; `message` says why */
bool product_list_file(const char *path, char *message);

/** Reads "SLOT=IDENT", slots counting from 1. @return false: that is not what the text says */
bool product_parse_module(const char *text, ect_module_choice_t *choice);

#endif
