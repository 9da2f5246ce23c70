/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A firmware that is renewed over FoE. The master writes a file in BOOT; it goes into the second slot and is checked
 * there. When the master leaves BOOT the board starts anew, and its loader (loader/main.c) puts the image into the
 * place that it runs from.
 *
 * A file, which tools/firmware-file.py makes, is a header of four words, little-endian, and the image behind it: magic
 * number, length of the image, its CRC-32, and the address that it is linked for, so that one for another board is
 * refused.
 *
 * A cut at any moment leaves a firmware that runs: a slot that is not whole is not taken, and an image that was put
 * into its place in part is put there again at the next start.
 */
#ifndef FIRMWARE_UPDATE_H
#define FIRMWARE_UPDATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/bytes.h"
#include "wire/crc.h"

#define UPDATE_MAGIC 0x57465445u /* "ETFW" */

enum { UPDATE_HEADER = 16 };

/** The two slots of a board, both read as memory. */
typedef struct update_slots {
    uint32_t run;          /**< address that the firmware runs from */
    const uint8_t *second; /**< where a file goes */
    uint32_t size;         /**< bytes of the second one */
    /** Makes the second one writable from end to end, and takes away what was in it. @return whether it did */
    bool (*erase)(void);
    /** Writes behind what was written. offset + length <= size. @return whether it did */
    bool (*write)(uint32_t offset, const void *data, uint32_t length);
} update_slots_t;

/** The board's. */
const update_slots_t *board_slots(void);

/** @return bytes of the image in the second slot, UPDATE_HEADER behind its start; 0: there is no whole one for this
 * board */
static inline uint32_t update_image(const update_slots_t *slots)
{
    const uint8_t *header = slots->second;
    uint32_t length = ect_load_le32(header + 4);
    if (ect_load_le32(header) != UPDATE_MAGIC || length > slots->size - UPDATE_HEADER ||
        ect_load_le32(header + 12) != slots->run)
        return 0;
    return ~ect_crc32(0xFFFFFFFF, header + UPDATE_HEADER, length) == ect_load_le32(header + 8) ? length : 0;
}

#endif
