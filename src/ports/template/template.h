/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The template of a port: a controller behind a window of two 32-bit registers. The template compiles, is tested, and
 * is meant to be copied: docs/PORTING.md explains it.
 *
 * The stack's requests are defined by ::ect_pdi_t: read or write any number of bytes at any address, in ascending
 * order, each byte once, with every wait bounded. A chip offers less: here, accesses of 1, 2 or 4 bytes at an address
 * that is a multiple of their number, one at a time, each with a wait for the chip. A port only maps these requests to
 * accesses of the chip: it interprets no register and no data, and keeps no copy.
 *
 * The window:
 *
 *     COMMAND   bits 15..0  address in the ESC        DATA   the bytes of the access, the lowest address in the
 *               bits 18..16 bytes: 1, 2, 4                   lowest eight bits
 *               bit  30     1 read, 0 write
 *               bit  31     write 1: begin; reads as 1 until the end of the access
 *
 * Three mistakes are frequent in ports; the code of the template shows the correct form of each.
 *
 * - **An access that is wider than requested.** A SyncManager acts on its first and its last byte: a read of four bytes
 *   in place of one empties a mailbox too early, or opens a buffer that stays open. The width is therefore the largest
 *   aligned one within the remaining length; no byte outside address .. address + length - 1 is accessed.
 * - **A wait without an end.** A chip that is in reset, or not soldered, never becomes ready. Each wait is bounded, and
 *   then the access fails; the stack keeps its state and repeats the access at its next poll, without a reset by the
 *   board's watchdog. An abandoned access may still be under way at the next one, so each access begins with a wait.
 * - **Byte order by cast.** DATA is composed and split by shifts, so the port is the same on processors of both byte
 *   orders. (A bus that swaps the bytes of DATA needs a change in this one place.)
 *
 * The bound: `patience` reads of COMMAND for an access of at most four bytes. With an access time of 500 ns for the
 * window and a patience of 20, a register of the ESC takes at most 11 us, a process image of 64 bytes 180 us; state
 * this above the table of your port, because it determines the shortest cycle of the slave.
 */
#ifndef ECT_PORTS_TEMPLATE_H
#define ECT_PORTS_TEMPLATE_H

#include <stdint.h>

#include "seams/pdi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The registers of the window: `reg` of the functions of ::ect_window_t. */
enum { ECT_WINDOW_COMMAND = 0, ECT_WINDOW_DATA = 1 };

/** Bits of COMMAND. */
#define ECT_WINDOW_BEGIN    0x80000000u /**< write 1: begin; reads as 1 until the end */
#define ECT_WINDOW_READ     0x40000000u
#define ECT_WINDOW_BYTES(n) ((uint32_t)(n) << 16)

/**
 * The board's access to the window: two functions around its bus, a pointer and a number. With a memory-mapped window
 * each function is one line; behind SPI, one transfer. Neither may block for longer than the bus access.
 */
typedef struct ect_window {
    void *ctx; /**< passed to each function; the board's */
    uint32_t (*load)(void *ctx, unsigned int reg);
    void (*store)(void *ctx, unsigned int reg, uint32_t value);
    uint16_t patience; /**< reads of COMMAND after which an access is abandoned; 1 or more */
} ect_window_t;

/**
 * Returns the PDI of the controller behind a window, without an interrupt line: the stack reads the register of AL
 * events.
 * @param window  the caller's, with its functions; must outlive the use of the result
 * @return the table for ect_slave_config_t::pdi. Its functions return -1 if the chip was not ready in time; an access
 * of several parts may then be executed in part, as the seam permits. Cost of an access: two or three window accesses
 * for each part (1, 2 or 4 bytes), and those of waits.
 */
ect_pdi_t ect_template_pdi(const ect_window_t *window);

ECT_C_END

#endif
