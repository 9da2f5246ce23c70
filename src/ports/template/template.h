/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The template of a port: a controller that is reached through a window of two 32-bit registers. It compiles, it is
 * tested, and it is meant to be copied: docs/PORTING.md walks through it.
 *
 * The stack's requests are defined by ::ect_pdi_t: read or write any number of bytes at any address, in ascending
 * order, each byte once, with every wait bounded. A chip offers less: here, 1, 2 or 4 bytes at an
 * address that is a multiple of their number, one access at a time, each of which takes the chip a while. A port is
 * the way from the one to the other, and nothing else: it knows no register of the ESC, keeps no copy of anything, and
 * has no opinion on what the bytes mean.
 *
 * The window:
 *
 *     COMMAND   bits 15..0  address in the ESC        DATA   the bytes of the access, the lowest address in the
 *               bits 18..16 bytes: 1, 2, 4                   lowest eight bits
 *               bit  30     1 read, 0 write
 *               bit  31     write 1: begin; reads as 1 until the access is done
 *
 * Three things go wrong in ports again and again; the code below shows each done right.
 *
 * - **An access that is wider than requested.** A SyncManager acts on its first and its last byte: a read of
 *   four bytes where one was meant empties a mailbox too early, or opens a buffer that stays open. So the width is
 *   the largest that is aligned and not longer than what is left; no byte outside of address .. address + length - 1
 *   is touched.
 * - **A wait without an end.** A chip that is in reset, or not soldered, never gets ready. Each wait counts, gives up,
 *   and the access fails; the stack keeps its state and tries again at its next poll, and the watchdog of the board
 *   does not have to find out. An abandoned access may still be under way when the next one comes, so that one begins
 * by waiting too.
 * - **Byte order by cast.** DATA is put together and taken apart by shifts, so the port is the same on a processor of
 *   either byte order. (Were DATA mapped with the bus's byte order swapped, it would be mended in this one place.)
 *
 * The bound: `patience` reads of COMMAND for an access of at most four bytes. With an access time of 500 ns for the
 * window and a patience of 20, a register of the ESC takes at most 11 us, a process image of 64 bytes 180 us; write
 * that above the table of your port, for the shortest cycle of the slave follows from it.
 */
#ifndef ECT_PORTS_TEMPLATE_H
#define ECT_PORTS_TEMPLATE_H

#include <stdint.h>

#include "seams/pdi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The registers of the window, as `reg` of ::ect_window_t. */
enum { ECT_WINDOW_COMMAND = 0, ECT_WINDOW_DATA = 1 };

/** Bits of COMMAND. */
#define ECT_WINDOW_BEGIN    0x80000000u /**< write 1: begin; reads as 1 while it lasts */
#define ECT_WINDOW_READ     0x40000000u
#define ECT_WINDOW_BYTES(n) ((uint32_t)(n) << 16)

/**
 * How the board reaches the window: two functions around its own bus, a pointer and a number. On a board where the
 * window is mapped into memory each function is one line; behind SPI it is one transfer. Neither may block for longer
 * than the bus takes.
 */
typedef struct ect_window {
    void *ctx; /**< handed to each function; the board's */
    uint32_t (*load)(void *ctx, unsigned int reg);
    void (*store)(void *ctx, unsigned int reg, uint32_t value);
    uint16_t patience; /**< how often COMMAND is read before an access is given up; 1 or more */
} ect_window_t;

/**
 * The PDI of the controller behind a window, without a wire of its own for AL events: the stack reads the register.
 * @param window  the caller's, with its functions; must outlive the use of the result
 * @return the table to hand to ::ect_slave_init. Its functions return -1 when the chip did not get ready in time; an
 *         access of several parts may then have happened in part, as the seam allows.
 * Cost of an access: two or three window accesses for each part (1, 2 or 4 bytes), and those of waiting.
 */
ect_pdi_t ect_template_pdi(const ect_window_t *window);

ECT_C_END

#endif
