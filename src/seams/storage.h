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
 * What was written is safe, that is, survives a power failure, when `flush` says so; before, any part of it may be on
 * the medium and any not. So the layer above flushes the data before it writes the header, and again before it tells
 * anybody. On a host the medium takes long to be sure (a disk's cache) and a thread waits for it; a loop that must not
 * be held up asks again later.
 *
 * Context: mainline only. `read`, `erase` and `write` may block for the medium's own time, never for its surety.
 */
#ifndef ECT_SEAMS_STORAGE_H
#define ECT_SEAMS_STORAGE_H

#include <stdbool.h>
#include <stdint.h>

enum { ECT_STORAGE_BUSY = 1 };

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
     * Writes `length` bytes to bank 0 or 1 at `offset`, which was erased and not written since. `read` gives them back
     * from now on.
     * @return 0, or negative; the bank's content is then undefined, the other bank's unchanged.
     */
    int (*write)(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length);

    /**
     * Begins, or goes on, to make safe what was written to bank 0 or 1 until now. NULL: a write is safe when it
     * returns.
     * @param wait  block until it is
     * @return 0 all of it is safe · ECT_STORAGE_BUSY not yet, ask again (never with `wait`) · negative: it will not be;
     *         the bank's content is then undefined, the other bank's unchanged.
     */
    int (*flush)(void *ctx, unsigned int bank, bool wait);
} ect_storage_t;

#endif
