/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writes ESI files from device descriptions: what an engineering tool imports (ETG.2000, its schema 1.14 and later).
 *
 * The same descriptions in the same order give the same bytes. A file has only elements that follow from the
 * description; docs/ESI.md has the table of elements, and the reason for the form of blocks of bytes. Attributes that
 * the standard calls obsolete, or advises against, are not written.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_WRITE_H
#define ECT_ESI_WRITE_H

#include <stdbool.h>
#include <stddef.h>

#include "esi/arena.h"
#include "esi/twin.h"
#include "seams/plant.h"
#include "wire/linkage.h"

/** A device of a file. */
typedef struct ect_esi_part {
    const ect_device_t *device;     /**< one that ect_device_check() has no objection to */
    const ect_identity_t *identity; /**< NULL: the description's */
    const ect_plant_t *plant;       /**< names of bits and values; NULL: none */
    /**
     * The twin that `device` is of, or NULL. Elements of its file that a description has no place for are copied:
     * children of the mailbox protocols (`InitCmd`), `OpMode/Sm`, `Info/VendorSpecific` (`AlternativeSmMapping`), and,
     * unless modules were chosen for it, `Slots` and `Modules`, in which case the device is written without modules.
     */
    const ect_esi_twin_t *twin;
} ect_esi_part_t;

ECT_C_BEGIN

/**
 * Writes a file with devices of one vendor.
 * @param parts, count   at least one; the vendor is that of the first
 * @param[out] length    bytes of the file, without the zero behind them
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), as long as the arena; NULL: the devices have different vendors, two have the same product
 *         code and revision, which no tool could distinguish, or there is no memory left
 */
const char *ect_esi_write(ect_arena_t *arena, const ect_esi_part_t *parts, size_t count, size_t *length, char *text,
                          size_t room);

ECT_C_END

#endif
