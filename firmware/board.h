/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the firmware needs of a board. A board is a folder with one file that defines these, and whatever else it takes.
 *
 * Context: all in mainline. Nothing blocks, but for the bounded waits of a port.
 */
#ifndef FIRMWARE_BOARD_H
#define FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "seams/leds.h"
#include "seams/pdi.h"
#include "seams/storage.h"

/** First of all: clocks, pins, the bus to the ESC. With main's arguments, where there are any. */
void board_init(int argc, char **argv);

/** Nanoseconds since some time before board_init returned. Never goes back. */
uint64_t board_now_ns(void);

/**
 * The way to the ESC, for ever. NULL: the board has a hardware file of SOES (ESC_read, ESC_write, ESC_init, ESC_reset),
 * and that is the way; otherwise hal.c makes one of this.
 */
const ect_pdi_t *board_pdi(void);

/**
 * Once a turn of the main loop, after the slave: the board's own work, its watchdog, a MAC in place of an ESC.
 * @param until_ns  nothing is due before that time but what the ESC brings: a board that notices that may sleep until
 * then
 */
void board_turn(uint64_t until_ns);

/** Resets the processor, and the ESC if it can. Does not return. */
_Noreturn void board_reset(void);

/**
 * The processor has met a fault, an interrupt without a handler, or a firmware that cannot start. The firmware's own
 * (weak): the ERR lamp is on, nothing else happens. A board with outputs defines one that makes them safe first, and
 * may reset then. Context: any, interrupts included; variables may be damaged. Does not return.
 */
_Noreturn void board_fault(void);

/** Non-volatile memory, for ever; NULL: none. */
const ect_storage_t *board_storage(void);

/** Setting of the address switches; 0: none. Asked once, after board_init. */
uint16_t board_switches(void);

/** Serial number of the unit; 0: the description's. Asked once, after board_init. */
uint32_t board_serial(void);

/** The pins of the RUN and ERR lamps, for ever. */
const ect_leds_t *board_leds(void);

#endif
