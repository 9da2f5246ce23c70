/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Storage: where a device keeps what must survive power-off (1010h, FZM1 "Save to unit").
 *
 * Two banks of equal size. What happens to one bank never touches the other, and may be cut off by a power failure
 * after any byte: the bank then holds a mixture. Nothing else is asked of the medium: two flash sectors, two halves of
 * an EEPROM and two files all qualify. The layer above writes a record's data to the older bank and its header last,
 * and reads the newest record whose check value is right, so a cut at any moment leaves the previous record.
 *
 * Context: mainline only. Calls may block for the medium's erase and write time.
 */
#ifndef ECT_SEAMS_STORAGE_H
#define ECT_SEAMS_STORAGE_H

#include <stdint.h>

typedef struct ect_storage {
    void *ctx;          /**< handed to each operation; owned by the port */
    uint32_t bank_size; /**< bytes in each of the two banks */

    /**
     * Reads `length` bytes of bank 0 or 1 from `offset`; offset + length <= bank_size.
     * @return 0, or negative when the medium does not answer; `buffer` is then undefined.
     */
    int (*read)(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length);

    /**
     * Makes bank 0 or 1 writable from end to end; its content is undefined afterwards.
     * @return 0, or negative; the bank's content is then undefined, the other bank's unchanged.
     */
    int (*erase)(void *ctx, unsigned int bank);

    /**
     * Writes `length` bytes to bank 0 or 1 at `offset`, which was erased and not written since. Done when it returns.
     * @return 0, or negative; the bank's content is then undefined, the other bank's unchanged.
     */
    int (*write)(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length);
} ect_storage_t;

#endif
