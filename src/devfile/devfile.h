/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Device files: a device as text, YAML, read as the model of a device that runs as a twin and becomes an ESI file, an
 * EEPROM image, a document and C source. docs/NEW-DEVICE.md has all keys.
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
 * Projects of the public EEPROM generator for SOES, `esi.json`, are read as well.
 *
 * A file is refused with one line `FILE:LINE: ERROR`, which has the cure. All content is checked: a file that is
 * accepted is a twin without a note, but for protocols that twins do not serve.
 *
 * Host only. Context: mainline. Cost: linear in the bytes of the file, but for `array`, and quadratic in the entries of
 * one object. Clauses: ETG.1000.6 (objects), ETG.1004 (units), ETG.1020 (types).
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
 * @return a file with one device, to be freed by ::ect_esi_close; NULL: no device file, or a wrong one
 */
ect_esi_t *ect_devfile_open(const char *path, char *text, size_t room);

/** The same from memory. @param path  prefix of messages */
ect_esi_t *ect_devfile_parse(const char *path, const void *data, size_t length, char *text, size_t room);

ECT_C_END

#endif
