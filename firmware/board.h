/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The functions that the firmware requires from a board. A board is a folder with a file that defines these functions,
 * and any further files.
 *
 * Context: mainline. No function blocks, except for the bounded waits of a port.
 */
#ifndef FIRMWARE_BOARD_H
#define FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "seams/leds.h"
#include "seams/pdi.h"
#include "seams/storage.h"

/** Called first: sets up clocks, pins, and the bus to the ESC. Gets the arguments of main, if any. */
void board_init(int argc, char **argv);

/** @return nanoseconds since a time before the return of board_init; never decreases. */
uint64_t board_now_ns(void);

/**
 * @return the access to the ESC, valid until power-off. hal.c makes a hardware file of SOES from it. NULL: the board
 * has a hardware file (ESC_read, ESC_write, ESC_init, ESC_reset).
 */
const ect_pdi_t *board_pdi(void);

/**
 * Called once in each iteration of the main loop, after the slave: for the board's own work, its watchdog, a MAC in
 * place of an ESC.
 * @param until_ns  nothing is due before this time except events of the ESC: a board that these wake may sleep until
 * then
 */
void board_turn(uint64_t until_ns);

/** Resets the processor, and the ESC if it can. Does not return. */
_Noreturn void board_reset(void);

/**
 * Called at a fault of the processor, an interrupt without a handler, or a failed start of the firmware. The default
 * (weak) switches the ERR lamp on and loops. A board with outputs defines a function that sets them to safe levels, and
 * may then reset. Context: any, interrupts included; variables may be damaged. Does not return.
 */
_Noreturn void board_fault(void);

/** @return non-volatile memory, valid until power-off; NULL: none. */
const ect_storage_t *board_storage(void);

/** @return the setting of the address switches; 0: none. Called once, after board_init. */
uint16_t board_switches(void);

/** @return the serial number of the unit; 0: that of the description. Called once, after board_init. */
uint32_t board_serial(void);

/** @return the pins of the RUN and ERR lamps, valid until power-off. */
const ect_leds_t *board_leds(void);

#endif
