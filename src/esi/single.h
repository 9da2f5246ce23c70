/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A model of a device that no ESI file describes, made by its caller from another source: an EEPROM image, an ENI. The
 * result is an ::ect_esi_t as that of a file with one device, and serves wherever one does.
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

/** The device, for its maker to fill. @param[out] arena  the memory of all that it points to */
ect_esi_device_t *ect_esi_single_device(ect_esi_t *esi, ect_arena_t **arena);

/** Appends a zeroed PDO to a device whose PDOs are all from this function. */
ect_esi_pdo_t *ect_esi_append_pdo(ect_arena_t *arena, ect_esi_device_t *device);

/**
 * Ends the model. A SyncManager of process data without any PDO in its direction gets PDOs whose entries are bytes; a
 * device without a type gets its product code as one.
 * @param source  "EEPROM", for the names of such PDOs
 */
void ect_esi_single_end(ect_esi_t *esi, const char *source);

ECT_C_END

#endif
