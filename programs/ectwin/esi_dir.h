/* SPDX-License-Identifier: MIT */
/** @file Devices of ESI files by their identity: `--esi-dir`. */
#ifndef ECTWIN_ESI_DIR_H
#define ECTWIN_ESI_DIR_H

#include <stdbool.h>
#include <stddef.h>

#include "seams/device.h"

/**
 * Searches a file for devices with the given identities. Each device found gives its identity the name
 * `esi:FILE#@PRODUCT/REVISION`, unless the identity already has a name.
 * @param identities  vendor, product and revision are compared
 * @param[in,out] names  `count` names to be freed with free(); NULL: no name yet
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return false: the file cannot be read
 */
bool esi_dir_search_file(const char *path, const ect_identity_t *identities, char **names, size_t count, char *message);

/** Searches all ESI files of a folder, in the order of their names; other files are ignored. @return false: no folder
 */
bool esi_dir_search(const char *folder, const ect_identity_t *identities, char **names, size_t count, char *message);

#endif
