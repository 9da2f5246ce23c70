/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A fault: something that goes wrong on purpose, as a value with a text form. What is written reads back as the same.
 *
 *     drop 5%                              a frame in twenty is lost, half of them on the way back
 *     delay 3000us every 10                each tenth answer is late by 3 ms
 *     duplicate frame 100                  the hundredth frame from now on is answered twice
 *     reorder every 7                      an answer lets the next one go first
 *     truncate 20 frame 3                  a request loses its last 20 bytes
 *     corrupt 1%                           a request has a bit changed that the check sum does not show
 *     counter -1 every 2                   the working counter of the first datagram of an answer is one less
 *     drop wire 3 back                     lost on the wire at the input of slave 3, on the way to the master
 *     damage 10% wire 3                    there, on the way from the master: those behind count a bad check sum
 *     delay 3000us every 10 wire 2         late there: so all faults of frames may be on a wire (bus/faults/wires.h)
 *     hang slave 2, resume slave 2         its microcontroller stands still, and goes on
 *     reset slave 2                        it begins anew
 *     identity slave 2                     it is replaced by one with the next product code
 *     lose-event slave 2                   the next request to its AL control raises no event
 *     eeprom busy slave 2, eeprom ok …     its EEPROM is never done; nack: never answers; flip 5: bit 5 of words read
 *     clock 5000ns slave 2                 its clock jumps; -5000ns: back
 *     off                                  ends all faults of frames
 *
 * No clock and no chance in here: chance is in bus/faults/scenario.h.
 */
#ifndef ECT_BUS_CHAIN_FAULT_H
#define ECT_BUS_CHAIN_FAULT_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for a fault as text, and for a message about one, terminators included. */
enum { ECT_FAULT_TEXT = 96, ECT_FAULT_MESSAGE = 256 };

typedef enum ect_fault_kind {
    ECT_FAULT_DROP,
    ECT_FAULT_DAMAGE,
    ECT_FAULT_DELAY,
    ECT_FAULT_DUPLICATE,
    ECT_FAULT_REORDER,
    ECT_FAULT_TRUNCATE,
    ECT_FAULT_CORRUPT,
    ECT_FAULT_COUNTER,
    ECT_FAULT_OFF,
    ECT_FAULT_HANG, /**< from here on: of a slave, done at once */
    ECT_FAULT_RESUME,
    ECT_FAULT_RESET,
    ECT_FAULT_IDENTITY,
    ECT_FAULT_LOSE_EVENT,
    ECT_FAULT_EEPROM_BUSY,
    ECT_FAULT_EEPROM_NACK,
    ECT_FAULT_EEPROM_FLIP,
    ECT_FAULT_EEPROM_OK,
    ECT_FAULT_CLOCK,
    ECT_FAULT_KINDS,
} ect_fault_kind_t;

/** Which frames it concerns. */
typedef enum ect_fault_when {
    ECT_FAULT_ALWAYS,
    ECT_FAULT_SHARE, /**< so many of a hundred, by lot */
    ECT_FAULT_EVERY, /**< each so-manieth */
    ECT_FAULT_ONCE,  /**< that one, counted from when the fault was set, from 1; then it has gone */
} ect_fault_when_t;

typedef struct ect_fault {
    ect_fault_kind_t kind;
    ect_fault_when_t when;
    uint32_t number; /**< of `when` */
    int32_t amount;  /**< µs of DELAY, bytes of TRUNCATE, of COUNTER, bit of EEPROM_FLIP, ns of CLOCK */
    uint16_t slave;  /**< from 1; of those of frames the slave at whose input the wire is; 0: none is named */
    bool back;       /**< on a wire: on the way to the master */
} ect_fault_t;

/**
 * Reads a fault.
 * @param[out] message  on failure what is wrong, one line for the user; ECT_FAULT_MESSAGE bytes
 * @return whether it is one; then *fault is set
 */
bool ect_fault_parse(const char *text, ect_fault_t *fault, char *message);

/** Writes it as text. @param[out] text  ECT_FAULT_TEXT bytes */
void ect_fault_print(const ect_fault_t *fault, char *text);

/** Whether it concerns frames (and lasts), not a slave (and is done). */
static inline bool ect_fault_is_of_frames(const ect_fault_t *fault)
{
    return fault->kind < ECT_FAULT_OFF;
}

ECT_C_END

#endif
