/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Flash as a device's storage (seams/storage.h): two areas that are erased as a whole and programmed a unit at a time,
 * each unit once. Three functions around the board's own driver; without them, memory that lasts until power-off.
 *
 * This port does what flash needs and the storage seam does not have: bytes are gathered into units; the header of a
 * record (seams/record.h), which is written last, has units of its own; what was gathered is programmed by `flush`.
 *
 * On a processor that cannot run from the flash that it erases, an erase stops everything, the exchange in the
 * interrupt too: then the driver, and what must go on meanwhile, have to run from RAM. 1010h blocks mainline for an
 * erase and the programming, 10 ms to 2 s depending on the flash.
 *
 * Context: mainline only. One ::ect_flash_t for a device, owned by the caller.
 */
#ifndef ECT_PORTS_FLASH_H
#define ECT_PORTS_FLASH_H

#include "seams/storage.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_FLASH_UNIT = 32 /* bytes, at most */ };

/** Two areas of a board's flash, or of its memory. */
typedef struct ect_flash {
    uint32_t area[2];   /**< address of each; a multiple of the unit. Without functions: offset in `memory` */
    uint32_t area_size; /**< bytes of each: a multiple of the unit, 64 or more */
    uint8_t unit;       /**< bytes that are programmed at once: 1, 2, 4, 8, 16, 32; 0: 1 */

    /** The board's driver, all three; 0 is success, negative that the flash did not do it. NULL: `memory` is used. */
    int (*read)(void *ctx, uint32_t address, void *buffer, uint32_t length);
    int (*erase)(void *ctx, uint32_t address, uint32_t length);                     /**< one of the areas */
    int (*program)(void *ctx, uint32_t address, const void *data, uint32_t length); /**< whole units, aligned */
    void *ctx;

    uint8_t *memory; /**< without functions: both areas lie in here */

    /* Gathered, and not programmed yet; private. */
    uint8_t gathered[ECT_FLASH_UNIT];
    uint32_t gathered_at;
    uint8_t gathered_bytes;
} ect_flash_t;

/**
 * The storage of a device.
 * @param flash  must outlive its use; nothing of it is touched before the device is
 * @return for ect_slave_config_t::storage. Its banks hold area_size bytes, less what a header's unit has to spare.
 */
ect_storage_t ect_flash_storage(ect_flash_t *flash);

ECT_C_END

#endif
