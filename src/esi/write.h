/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writer of ESI files, made from device descriptions for import into engineering tools (ETG.2000, schema 1.14 and
 * later).
 *
 * The same descriptions in the same order result in the same bytes. A file contains only elements that follow from the
 * description; docs/ESI.md has the table of elements, and the reason for the format of byte blocks. Attributes that are
 * obsolete or not recommended by the standard are not written.
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
    const ect_device_t *device;     /**< valid by ::ect_device_check */
    const ect_identity_t *identity; /**< NULL: the description's */
    const ect_plant_t *plant;       /**< names of bits and values; NULL: none */
    /**
     * The twin of `device`; NULL: none. Elements of its file without a member in a description are copied:
     * children of the mailbox protocols (`InitCmd`), `OpMode/Sm`, `Info/VendorSpecific` (`AlternativeSmMapping`), and,
     * unless modules were selected for it, `Slots` and `Modules`; the device is then written without modules.
     */
    const ect_esi_twin_t *twin;
} ect_esi_part_t;

ECT_C_BEGIN

/**
 * Writes a file with devices of one vendor.
 * @param parts, count   at least one; the vendor is that of the first
 * @param[out] length    bytes of the file, without the terminator
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), owned by the arena; NULL: different vendors, two devices with the same product code and
 *         revision, which tools cannot distinguish, or out of memory
 */
const char *ect_esi_write(ect_arena_t *arena, const ect_esi_part_t *parts, size_t count, size_t *length, char *text,
                          size_t room);

ECT_C_END

#endif
