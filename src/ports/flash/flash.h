/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Flash as a device's storage (seams/storage.h): two areas, each erased as a whole and programmed in units, each unit
 * once. The board's driver provides three functions; without them, the storage is memory that lasts until power-off.
 *
 * This port adapts the storage seam to flash: bytes are gathered into units; the header of a record (seams/record.h),
 * which is written last, has separate units; `flush` programs the gathered bytes.
 *
 * On a processor that cannot run from the flash during an erase, an erase stops all code, the exchange in the interrupt
 * included: the driver, and all code that must continue, must then run from RAM. 1010h blocks mainline during erase and
 * programming, 10 ms to 2 s depending on the flash.
 *
 * Context: mainline only. One ::ect_flash_t for each device, owned by the caller.
 */
#ifndef ECT_PORTS_FLASH_H
#define ECT_PORTS_FLASH_H

#include "seams/storage.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_FLASH_UNIT = 32 /* limit of ect_flash_t::unit */ };

/** Two areas of a board's flash, or of its memory. */
typedef struct ect_flash {
    uint32_t area[2];   /**< address of each; a multiple of the unit. Without functions: offset in `memory` */
    uint32_t area_size; /**< bytes of each: a multiple of the unit, 64 or more */
    uint8_t unit;       /**< bytes programmed at once: 1, 2, 4, 8, 16, 32; 0: 1 */

    /**
     * The board's driver, all three functions; results: 0 success, negative: the flash has failed. NULL: `memory` is
     * used.
     */
    int (*read)(void *ctx, uint32_t address, void *buffer, uint32_t length);
    int (*erase)(void *ctx, uint32_t address, uint32_t length);                     /**< one of the areas */
    int (*program)(void *ctx, uint32_t address, const void *data, uint32_t length); /**< whole units, aligned */
    void *ctx;

    uint8_t *memory; /**< without functions: contains both areas */

    /* Gathered bytes that are not yet programmed; private. */
    uint8_t gathered[ECT_FLASH_UNIT];
    uint32_t gathered_at;
    uint8_t gathered_bytes;
} ect_flash_t;

/**
 * The storage of a device.
 * @param flash  must outlive its use; not accessed before the first call of the result
 * @return for ect_slave_config_t::storage. A bank has area_size bytes, minus the unused rest of the header's units.
 */
ect_storage_t ect_flash_storage(ect_flash_t *flash);

ECT_C_END

#endif
