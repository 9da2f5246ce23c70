/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bus of a network file (ENI) as twins: a device for each slave, from its ESI file where one is at hand, else from
 * the network file itself.
 */
#ifndef ECTWIN_NETWORK_H
#define ECTWIN_NETWORK_H

#include <stdbool.h>
#include <stddef.h>

#include "bus/chain/chain.h"

/** The devices of a network, names for ::product_find. */
typedef struct network_names {
    char **names;
    size_t count;
} network_names_t;

/** @return the path behind `eni:` of a name that stands for a whole bus; NULL: another name, or one slave, FILE#N */
const char *network_path(const char *name);

/**
 * Finds the device of each slave, and prints a line for each to standard error.
 * @param esi_dir  folder with ESI files, searched by vendor, product and revision; NULL: none
 * @param quiet    no lines
 * @param[out] names    to be freed with ::network_names_free, also on failure
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return false: the network file or the folder cannot be read
 */
bool network_names(network_names_t *names, const char *path, const char *esi_dir, bool quiet, char *message);

/**
 * The same from ESI files, without lines.
 * @return false: one of the files cannot be read
 */
bool network_names_of_files(network_names_t *names, const char *path, const char *const files[], size_t count,
                            char *message);

void network_names_free(network_names_t *names);

/**
 * Gives twins what the network file has of them: serial number, alias, place in the tree.
 * @param first  position of the first of them in `twins`; those of all slaves are there
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return false: a slave has an impossible place
 */
bool network_apply(const char *path, ect_twin_config_t *twins, size_t first, char *message);

#endif
