/* SPDX-License-Identifier: MIT */
/**
 * @file
 * PDI: how the slave stack reaches an EtherCAT slave controller (ESC), real or virtual.
 *
 * A port is one table of two operations and a context. The software ESC, a LAN9252 on SPI, an ET1100 on a parallel
 * bus and an existing SOES hardware file (`ESC_read`/`ESC_write`) all fit behind it. What a port must promise:
 *
 * - **Addresses** are ESC addresses: 0x0000..0x0FFF registers, from 0x1000 process RAM. Any start address and any
 *   length from 1 to 65535 may come; alignment and splitting into the widths of the chip is the port's work, in
 *   ascending address order. A SyncManager buffer is always accessed in one call from its first to its last byte, or
 *   beginning at its first byte and ending with a call for its last byte, so the port must neither reorder nor drop
 *   bytes: the first byte opens the buffer, the last one closes it (ETG.1000.4 §6.7).
 * - **Byte order**: bytes stand in the buffer as they stand in the ESC. No swapping.
 * - **Blocking**: a call returns only when the access is done. Every wait inside is bounded; a port states its bound
 *   (LAN9252 on 20 MHz SPI: about 10 us for a register, 4 us + 0.4 us a byte for a block). The stack never polls
 *   inside a call.
 * - **Errors**: 0 is success; any negative value means the access did not happen or cannot be trusted (bus error,
 *   time-out, chip in reset). The stack then abandons what it was doing, keeps its state, counts the error and tries
 *   again at its next poll: nothing is half-applied. A port that can't fail returns 0 always.
 * - **Context**: mainline, and the interrupt in which ::ect_slave_cycle runs, never both at once for one instance: the
 *   stack holds the exchange out of its accesses, so a port needs no lock against it. One whose bus serves other things
 *   than this ESC locks against those. No call is made from inside another.
 * - **Side effects** are those of the ESC for its PDI side: reading 0x0120 releases the AL control lock, reading a
 *   SyncManager's last byte empties a mailbox, and so on.
 */
#ifndef ECT_SEAMS_PDI_H
#define ECT_SEAMS_PDI_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/bytes.h"
#include "wire/registers.h"

typedef struct ect_pdi {
    /** Handed to each operation; owned by the port, must outlive the stack that uses it. */
    void *ctx;

    /**
     * Reads `length` bytes of the ESC from `address` into `buffer` (the caller's, at least `length` bytes).
     * @return 0, or negative: `buffer` is then undefined and the ESC may or may not have seen the access.
     */
    int (*read)(void *ctx, uint16_t address, void *buffer, uint16_t length);

    /**
     * Writes `length` bytes from `buffer` to the ESC at `address`. `buffer` is only read, and only during the call.
     * @return 0, or negative: the ESC may hold any prefix of the data.
     */
    int (*write)(void *ctx, uint16_t address, const void *buffer, uint16_t length);

    /**
     * The AL event request word (0x0220..0x0223), for ports that learn it without an access of its own: the status
     * bytes that an ET1100 sends in front of each SPI transfer, or the interrupt line. NULL: the stack reads the
     * register, one access a poll.
     *
     * With the line: while it is inactive there is no event, store 0; while it is active read the register. That misses
     * nothing, because the stack keeps the AL event mask (0x0204) so that the line is active exactly while there is
     * something that the stack has yet to do: AL control, SyncManager changes, the watchdog, process data from SAFEOP
     * on, a request, and the fetching of a mail only when another waits for it. Two conditions: look at the level of
     * the pin now, not at a flag that an edge has set, for a second event raises no second edge; and poll once after
     * ect_slave_init, which leaves the mask to the first poll. A line that wakes the processor may be level triggered:
     * it goes down when the poll has done its work, in at most a few polls.
     * @return 0 and *event set, or negative as above.
     */
    int (*al_event)(void *ctx, uint32_t *event);
} ect_pdi_t;

/**
 * ::ect_pdi_t::al_event of a port that has the line: the register while it is active, else 0.
 * @param active  the level of the line, now
 * @param read    the port's ::ect_pdi_t::read
 */
static inline int ect_pdi_line_event(bool active,
                                     int (*read)(void *ctx, uint16_t address, void *buffer, uint16_t length), void *ctx,
                                     uint32_t *event)
{
    uint8_t bytes[4] = {0};
    int result = active ? read(ctx, ECT_REG_AL_EVENT, bytes, sizeof bytes) : 0;
    *event = ect_load_le32(bytes);
    return result;
}

/**
 * What a port cuts an access into: the most bytes that go at once, where a chip takes 1, 2, 4 … `widest` of them at an
 * address that is a multiple of their number. Never more than are left: the last byte of a SyncManager's buffer is an
 * event, and touching it early loses a mail.
 * @param left    bytes of the access from `address` on, 1 or more
 * @param widest  a power of two
 */
static inline unsigned int ect_pdi_part(uint32_t address, uint32_t left, unsigned int widest)
{
    unsigned int bytes = widest;
    while (address % bytes != 0 || bytes > left)
        bytes /= 2;
    return bytes;
}

#endif
