/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A firmware update over FoE. In BOOT the master writes a file, which is stored and verified in the second slot. When
 * the master leaves BOOT, the board restarts, and its loader (loader/main.c) copies the image to the address that it
 * runs from.
 *
 * A file, which tools/firmware-file.py makes, is a header of eight words, little-endian, and the image:
 *
 * | byte | |
 * |--:|---|
 * | 0 | UPDATE_MAGIC |
 * | 4 | length of the image in bytes |
 * | 8 | CRC-32 of all bytes from 12 on |
 * | 12 | address that the image is linked for: a file for another board is refused |
 * | 16 | vendor ID, 1018:01 |
 * | 20 | product code, 1018:02: a file for another product is refused, before the slot is erased |
 * | 24 | version, a number of the vendor's choice; not compared, so that an older firmware may replace a newer one |
 * | 28 | 0 |
 *
 * After an interruption at any moment a firmware still runs: an incomplete slot is ignored, and a partly copied image
 * is copied again at the next start.
 */
#ifndef FIRMWARE_UPDATE_H
#define FIRMWARE_UPDATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/bytes.h"
#include "wire/crc.h"

#define UPDATE_MAGIC 0x32465445u /* "ETF2" */

enum { UPDATE_HEADER = 32, UPDATE_CHECKED_FROM = 12 };

/** The two slots of a board, both read as memory. */
typedef struct update_slots {
    uint32_t run;          /**< address that the firmware runs from */
    const uint8_t *second; /**< start of the second slot */
    uint32_t size;         /**< bytes of the second slot, more than UPDATE_HEADER */
    /** Erases the entire second slot. @return false: the memory has failed */
    bool (*erase)(void);
    /** Writes after the previous write. offset + length <= size. @return false: the memory has failed */
    bool (*write)(uint32_t offset, const void *data, uint32_t length);
} update_slots_t;

/** The board's slots. */
const update_slots_t *board_slots(void);

/**
 * @return whether a header, UPDATE_HEADER bytes, is that of a file for this board: magic number, address, a length that
 * fits.
 */
static inline bool update_header_good(const update_slots_t *slots, const uint8_t *header)
{
    return ect_load_le32(header) == UPDATE_MAGIC && ect_load_le32(header + 4) <= slots->size - UPDATE_HEADER &&
           ect_load_le32(header + 12) == slots->run;
}

/**
 * @return bytes of the image in the second slot, which begins UPDATE_HEADER bytes after its start; 0: no complete image
 * for this board
 */
static inline uint32_t update_image(const update_slots_t *slots)
{
    const uint8_t *header = slots->second;
    if (!update_header_good(slots, header))
        return 0;
    uint32_t length = ect_load_le32(header + 4);
    uint32_t crc = ~ect_crc32(0xFFFFFFFF, header + UPDATE_CHECKED_FROM, length + UPDATE_HEADER - UPDATE_CHECKED_FROM);
    return crc == ect_load_le32(header + 8) ? length : 0;
}

#endif
