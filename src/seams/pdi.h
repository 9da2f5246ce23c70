/* SPDX-License-Identifier: MIT */
/**
 * @file
 * PDI: the access of the slave stack to an EtherCAT slave controller (ESC), real or virtual.
 *
 * A port is a table of two operations and a context. The software ESC, a LAN9252 on SPI, an ET1100 on a parallel bus
 * and an existing SOES hardware file (`ESC_read`/`ESC_write`) all fit this interface. The obligations of a port:
 *
 * - **Addresses** are ESC addresses: registers from 0x0000 to 0x0FFF, process RAM from 0x1000. Any start address and
 * any length from 1 to 65535 may occur; the port handles alignment and splits an access into the widths of the chip, in
 *   ascending address order. The stack accesses a SyncManager buffer in one call from its first to its last byte, or in
 *   calls of which the first contains the first byte and the last one the last byte. The port must therefore neither
 *   reorder nor drop bytes: the first byte opens the buffer, the last one closes it (ETG.1000.4 §6.7).
 * - **Byte order**: the buffer holds the bytes in the order of the ESC. No swapping.
 * - **Blocking**: a call returns only when the access is complete. Every wait inside is bounded; a port documents its
 *   bound (LAN9252 on 20 MHz SPI: about 10 us for a register, 4 us + 0.4 us a byte for a block). The stack never polls
 *   inside a call.
 * - **Errors**: 0 is success. Any negative value means that the access did not happen or cannot be trusted (bus error,
 *   timeout, chip in reset). The stack then abandons the step, keeps its state, counts the error and repeats the step
 * at its next poll; no step is half-applied. A port that cannot fail always returns 0.
 * - **Context**: mainline, and the interrupt in which ::ect_slave_cycle runs, never both at once for one instance: the
 *   stack keeps the exchange out of its accesses, so a port needs no lock against it. A port whose bus serves further
 *   chips locks against those. Calls are never nested.
 * - **Side effects** are those of the ESC for its PDI side: reading 0x0120 releases the AL control lock, reading the
 *   last byte of a SyncManager buffer empties a mailbox, and so on.
 */
#ifndef ECT_SEAMS_PDI_H
#define ECT_SEAMS_PDI_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/bytes.h"
#include "wire/registers.h"

/** The operations of a port, and their context. */
typedef struct ect_pdi {
    /** Passed to each operation; owned by the port, must outlive the stack that uses it. */
    void *ctx;

    /**
     * Reads `length` bytes of the ESC from `address` into `buffer` (the caller's, at least `length` bytes).
     * @return 0, or negative: the content of `buffer` is then undefined, and the ESC may or may not have executed the
     *         access
     */
    int (*read)(void *ctx, uint16_t address, void *buffer, uint16_t length);

    /**
     * Writes `length` bytes from `buffer` to the ESC at `address`. `buffer` is only read, and only during the call.
     * @return 0, or negative: the ESC may then hold any prefix of the data
     */
    int (*write)(void *ctx, uint16_t address, const void *buffer, uint16_t length);

    /**
     * Reads the AL event request word (0x0220..0x0223), in ports that get it without an access of its own: from the
     * status bytes that an ET1100 sends in front of each SPI transfer, or from the interrupt line. NULL: the stack
     * reads the register, one access a poll.
     *
     * With the interrupt line: while it is inactive there is no event, and the port stores 0; while it is active, the
     * port reads the register. No event is missed, because the stack keeps the AL event mask (0x0204) such that the
     * line is active exactly while the stack has work to do: AL control, SyncManager changes, the watchdog, process
     * data from SAFEOP on, a request, and a fetched mail only when another one waits for the mailbox. There are two
     * conditions. The port reads the present level of the pin, not a flag set by an edge, because a second event causes
     * no second edge. The caller polls once after ect_slave_init, because the first poll sets the mask. A line that
     * wakes the processor may be level triggered: it becomes inactive when the stack has done its work, in at most a
     * few polls.
     * @return 0 and *event set, or negative as for `read`
     */
    int (*al_event)(void *ctx, uint32_t *event);
} ect_pdi_t;

/**
 * ::ect_pdi_t::al_event for a port with the interrupt line: reads the register while the line is active, else 0.
 * @param active      present level of the line
 * @param read        the port's ::ect_pdi_t::read
 * @param ctx         the port's ::ect_pdi_t::ctx
 * @param[out] event  AL event request word
 * @return as ::ect_pdi_t::al_event
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
 * Size of the next part of an access, for a chip that transfers 1, 2, 4 … `widest` bytes at an address that is a
 * multiple of their number: the most bytes that fit. Never more than are left, because an access to the last byte of a
 * SyncManager buffer is an event, and an early one loses a mail.
 * @param address  of the part
 * @param left     bytes of the access from `address` on, 1 or more
 * @param widest   a power of two
 * @return 1 to `widest`, a power of two
 */
static inline unsigned int ect_pdi_part(uint32_t address, uint32_t left, unsigned int widest)
{
    unsigned int bytes = widest;
    while (address % bytes != 0 || bytes > left)
        bytes /= 2;
    return bytes;
}

#endif
