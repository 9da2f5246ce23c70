/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The twins of a network file (ENI): a device for each slave, from its ESI file if available, else from the network
 * file itself.
 */
#ifndef ECTWIN_NETWORK_H
#define ECTWIN_NETWORK_H

#include <stdbool.h>
#include <stddef.h>

#include "bus/chain/chain.h"

/** The devices of a network, as names for ::product_find. */
typedef struct network_names {
    char **names;
    size_t count;
} network_names_t;

/** @return the path in `eni:FILE`, the name of a whole bus; NULL: another name, or FILE#N, the name of one slave */
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
 * Finds the device of each slave in the given ESI files, or among devices ("fzm1", "yaml:FILE"), as ::network_names
 * does in a folder, without printing lines.
 * @return false: one of the files cannot be read
 */
bool network_names_of_files(network_names_t *names, const char *path, const char *const files[], size_t count,
                            char *message);

void network_names_free(network_names_t *names);

/**
 * Sets serial number, alias and position in the tree of each twin to those of the network file.
 * @param first  index in `twins` of the first slave's twin; the twins of the other slaves follow
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return false: a slave has an impossible position
 */
bool network_apply(const char *path, ect_twin_config_t *twins, size_t first, char *message);

#endif
