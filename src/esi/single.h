/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A model of a device without an ESI file: the caller fills it from another source, an EEPROM image or an ENI. The
 * result is an ::ect_esi_t with one device, like that of an ESI file.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_SINGLE_H
#define ECT_ESI_SINGLE_H

#include <stddef.h>

#include "esi/arena.h"
#include "esi/read.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Begins a model without content.
 * @param name  prefix of messages
 * @param[out] text, room  the error, one line
 * @return to be freed by ::ect_esi_close; NULL: no memory
 */
ect_esi_t *ect_esi_single_begin(const char *name, char *text, size_t room);

/** @return the device, to be filled by the caller @param[out] arena  for the memory of its parts */
ect_esi_device_t *ect_esi_single_device(ect_esi_t *esi, ect_arena_t **arena);

/** Appends a zeroed PDO to a device; all PDOs of the device must come from this function. */
ect_esi_pdo_t *ect_esi_append_pdo(ect_arena_t *arena, ect_esi_device_t *device);

/**
 * Completes the model. A SyncManager of process data without PDOs in its direction gets PDOs with one-byte entries; the
 * type of a device without a type is its product code.
 * @param source  such as "EEPROM", for the names of these PDOs
 */
void ect_esi_single_end(ect_esi_t *esi, const char *source);

ECT_C_END

#endif
