/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The delays of the microcontroller of a twin.
 */
#ifndef ECT_BUS_CHAIN_SLOW_CONFIG_H
#define ECT_BUS_CHAIN_SLOW_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sii/fit.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** A random duration from `min_ns` to `max_ns`, inclusive. Both 0: none. */
typedef struct ect_slow_range {
    uint64_t min_ns, max_ns;
} ect_slow_range_t;

/** A board: its microcontroller and the bus to its ESC. */
typedef struct ect_board {
    const char *name;
    const char *summary;
    const ect_fit_t *controller;
    /** Returns the time of an access to the ESC on the bus: its bytes, and the driver. Pure. */
    uint64_t (*bus_ns)(uint16_t address, uint16_t length, bool write);
    /** Returns the instructions of port and slave stack for an access, those of the poll included. Pure. */
    uint32_t (*instructions)(uint16_t address, uint16_t length, bool write);
} ect_board_t;

/** @return a board by index or by name; NULL: none */
const ect_board_t *ect_board_at(size_t index);
const ect_board_t *ect_board(const char *name);

/**
 * @return the instructions of a device's own code in a poll with process data; 0: negligible, or not counted for this
 * name.
 */
uint32_t ect_board_cycle(const char *device);

/** @return the time of instructions on the processor of the boards, a Cortex-M4. */
uint64_t ect_board_ns(uint64_t instructions);

/** @return the time of an access to the ESC: bus and processor. */
uint64_t ect_board_access_ns(const ect_board_t *board, uint16_t address, uint16_t length, bool write);

/** The delays of one twin. Zeroed: none, the twin processes an event at the time of the event. */
typedef struct ect_slow_config {
    ect_slow_range_t al;      /**< from a request in AL control until the slave begins to process it */
    ect_slow_range_t mailbox; /**< from a mail in SM0 until the slave fetches it */
    ect_slow_range_t jitter;  /**< from an event until the slave begins to process it */
    uint32_t receive_ns;      /**< largest random delay of receive times of distributed clocks, for each frame */
    const ect_board_t *board; /**< board with the access times of the slave; NULL: accesses take no time */
    uint64_t cycle_ns;        /**< with a board: of the device's own code in a poll with process data */
    uint32_t seed;            /**< of the random generator */
} ect_slow_config_t;

/** @return whether any delay is set */
static inline bool ect_slow_needed(const ect_slow_config_t *c)
{
    return c->al.max_ns != 0 || c->mailbox.max_ns != 0 || c->jitter.max_ns != 0 || c->receive_ns != 0 || c->board;
}

ECT_C_END

#endif
