/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Products by name: of the catalogue, or of a file: `esi:FILE.xml#TYPE`, a device of an ESI file, `sii:FILE`, the
 * device of an EEPROM image, binary or Intel HEX, `eni:FILE.xml#N`, slave N of a network file, and `yaml:FILE`, a
 * device described as text.
 */
#ifndef ECTWIN_PRODUCTS_H
#define ECTWIN_PRODUCTS_H

#include <stdbool.h>

#include "eni/read.h"
#include "esi/twin.h"

/** Room for a message of one line. */
enum { PRODUCT_MESSAGE = 600 };

/**
 * Finds a product, or makes it from a file. Prints the features of the file that the twin does not support to standard
 * error.
 * @param modules, module_count  of a modular device from a file
 * @param behaviour  of a device from a file; other devices accept only ECT_BEHAVIOUR_BY_FILE
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return the product, valid until the program ends, or NULL
 */
const ect_product_t *product_find(const char *name, const ect_module_choice_t *modules, size_t module_count,
                                  ect_behaviour_t behaviour, char *message);

/** Ends the printing of unsupported features by ::product_find. */
void product_quiet(void);

/** @return the twin of a product from a file; NULL: the product is not from a file */
const ect_esi_twin_t *product_twin(const ect_product_t *product);

/** @return the twin of a device from a file; NULL: the device is not from a file */
const ect_esi_twin_t *product_twin_of_device(const ect_device_t *device);

/** @return the part after `esi:`, `sii:`, `eni:` or `yaml:` of a name; NULL: not the name of a file */
const char *product_file(const char *name);

/**
 * Opens a network file. @param[out] message  PRODUCT_MESSAGE bytes
 * @return the file, valid until the next call with another path; NULL: not readable
 */
const ect_eni_t *product_network(const char *path, char *message);

/**
 * Lists the devices of a file: type, product, revision, name.
 * @param name  a name of ::product_file; the part after a '#' is ignored
 * @return false: not readable; see `message`
 */
bool product_list_file(const char *name, char *message);

/** Reads "SLOT=IDENT", slots counting from 1. @return false: another text */
bool product_parse_module(const char *text, ect_module_choice_t *choice);

#endif
