/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Device files: the description of a device as text, YAML. The resulting model is the source of a twin, an ESI file, an
 * EEPROM image, a document and C source. docs/NEW-DEVICE.md lists all keys.
 *
 * ```yaml
 * ectwin-device: 1                   # version of the format
 * vendor: {id: 0x00000E57, name: Example Works}
 * product: 0x00000101
 * revision: 1
 * type: GAUGE-1
 * objects:
 *   0x6000: {name: Distance, type: DINT, unit: um, min: 0, max: 50000}
 *   0x7000: {name: Laser, type: USINT, bits: {0: ON, 1: HOLD}}
 * inputs: [0x6000]
 * outputs: [0x7000]
 * ```
 *
 * Projects of the public EEPROM generator for SOES, `esi.json`, can be read too.
 *
 * An invalid file is refused with one line `FILE:LINE: ERROR`, which includes the cure. All content is checked: the
 * twin of an accepted file has no notes, except on unsupported protocols.
 *
 * Host only. Context: mainline. Cost: linear in the bytes of the file, except for `array`, and quadratic in the entries
 * of an object. Clauses: ETG.1000.6 (objects), ETG.1004 (units), ETG.1020 (types).
 */
#ifndef ECT_DEVFILE_DEVFILE_H
#define ECT_DEVFILE_DEVFILE_H

#include <stddef.h>

#include "esi/read.h"
#include "wire/linkage.h"

/** Limits. */
enum {
    ECT_DEVFILE_BYTES = 1 << 20,   /**< of a file */
    ECT_DEVFILE_ENTRIES = 65535,   /**< of all objects together */
    ECT_DEVFILE_PDO_ENTRIES = 254, /**< of a PDO */
};

ECT_C_BEGIN

/**
 * Reads a file.
 * @param path  a regular file of at most ::ECT_DEVFILE_BYTES
 * @param[out] text, room  the error, one line
 * @return a file with one device, to be freed by ::ect_esi_close; NULL: not a device file, or invalid
 */
ect_esi_t *ect_devfile_open(const char *path, char *text, size_t room);

/** Reads a file in memory, as ::ect_devfile_open. @param path  prefix of messages */
ect_esi_t *ect_devfile_parse(const char *path, const void *data, size_t length, char *text, size_t room);

ECT_C_END

#endif
