/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Storage: non-volatile memory of a device (1010h, FZM1 "Save to unit").
 *
 * There are two banks of equal size. An operation on one bank never changes the other one. A power failure may
 * interrupt an operation after any byte; the bank then holds a mixture. The medium has no further obligations: two
 * flash sectors, two halves of an EEPROM and two files all qualify. The layer above (record.h) writes the data of a
 * record to the older bank and the header last, and reads the newest record whose check value is right, so an
 * interruption at any moment preserves the previous record.
 *
 * Written data are safe, that is, they survive a power failure, when `flush` reports so; before that, the medium may
 * hold any part of them. The layer above therefore flushes the data before it writes the header, and again before it
 * reports success. On a host, a flush takes long (a disk's cache), so a thread waits for it; a loop that must not block
 * repeats the call later.
 *
 * Context: mainline only. `read`, `erase` and `write` may block for the medium's own time, never for a flush.
 */
#ifndef ECT_SEAMS_STORAGE_H
#define ECT_SEAMS_STORAGE_H

#include <stdbool.h>
#include <stdint.h>

/** Result of ::ect_storage_t::flush: not complete yet. */
enum { ECT_STORAGE_BUSY = 1 };

/** The operations of a medium, and their context. */
typedef struct ect_storage {
    void *ctx;          /**< passed to each operation; owned by the port */
    uint32_t bank_size; /**< bytes in each of the two banks */

    /**
     * Reads `length` bytes of bank 0 or 1 from `offset`; offset + length <= bank_size.
     * @return 0, or negative when the medium fails; the content of `buffer` is then undefined
     */
    int (*read)(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length);

    /**
     * Makes the whole of bank 0 or 1 writable; its content is undefined afterwards.
     * @return 0, or negative; the bank's content is then undefined, the other bank's unchanged
     */
    int (*erase)(void *ctx, unsigned int bank);

    /**
     * Writes `length` bytes to bank 0 or 1 at `offset`, where the bank was erased and not written since. From now on
     * `read` returns them.
     * @return 0, or negative; the bank's content is then undefined, the other bank's unchanged
     */
    int (*write)(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length);

    /**
     * Starts or continues to make all previous writes to bank 0 or 1 safe. NULL: a write is safe when it returns.
     * @param wait  block until the writes are safe
     * @return 0 all writes are safe · ECT_STORAGE_BUSY not yet, call again (never with `wait`) · negative: failed; the
     * bank's content is then undefined, the other bank's unchanged
     */
    int (*flush)(void *ctx, unsigned int bank, bool wait);
} ect_storage_t;

#endif
