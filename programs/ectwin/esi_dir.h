/* SPDX-License-Identifier: MIT */
/** @file Devices of ESI files by their identity: `--esi-dir`. */
#ifndef ECTWIN_ESI_DIR_H
#define ECTWIN_ESI_DIR_H

#include <stdbool.h>
#include <stddef.h>

#include "seams/device.h"

/**
 * Names the device of each identity that a file has and that has no name yet: `esi:FILE#@PRODUCT/REVISION`.
 * @param identities  vendor, product and revision count
 * @param[in,out] names  `count`, NULL or for free()
 * @param[out] message  PRODUCT_MESSAGE bytes
 * @return false: the file cannot be read
 */
bool esi_dir_search_file(const char *path, const ect_identity_t *identities, char **names, size_t count, char *message);

/** The same in all ESI files of a folder, in the order of their names; others are left out. @return false: no folder */
bool esi_dir_search(const char *folder, const ect_identity_t *identities, char **names, size_t count, char *message);

#endif
