/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A fault that is injected, as a value with a text form. A printed fault reads back as the same value. The words after
 * the kind come in any order.
 *
 *     drop 5%                              a frame in twenty is lost, half of these on the way back
 *     delay 3000us every 10                each tenth reply is late by 3 ms
 *     duplicate frame 100                  the hundredth frame from now on gets two replies
 *     reorder every 7                      a reply leaves after the next one
 *     truncate 20 frame 3                  a request loses its last 20 bytes
 *     corrupt 1%                           a request has a bit changed that the check sum does not show
 *     counter -1 every 2                   the working counter of a reply's first datagram is one less
 *     drop wire 3 back                     lost on the wire at the input of slave 3, on the way to the master
 *     damage 10% wire 3                    on the way from the master: slaves behind count a bad check sum
 *     delay 3000us every 10 wire 2         late on a wire, as every fault of frames (bus/faults/wires.h)
 *     hang slave 2, resume slave 2         its microcontroller stops, and continues
 *     reset slave 2                        it restarts
 *     identity slave 2                     it is replaced by one with the next product code
 *     lose-event slave 2                   the next request to its AL control raises no event
 *     eeprom busy slave 2, eeprom ok …     its EEPROM stays busy, or is whole again
 *     eeprom nack slave 2                  it does not reply
 *     eeprom flip 5 slave 2                bit 5 of the words read from it is inverted
 *     clock 5000ns slave 2                 its clock jumps; -5000ns: back
 *     off                                  ends all faults of frames
 *
 * No clock and no randomness in here (bus/faults/scenario.h has them).
 */
#ifndef ECT_BUS_CHAIN_FAULT_H
#define ECT_BUS_CHAIN_FAULT_H

#include <stdbool.h>
#include <stddef.h>
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
    ECT_FAULT_HANG, /**< this and the following: of a slave, done at once */
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

/** The frames that a fault concerns. */
typedef enum ect_fault_when {
    ECT_FAULT_ALWAYS,
    ECT_FAULT_SHARE, /**< `number` percent, at random */
    ECT_FAULT_EVERY, /**< each frame whose count is a multiple of `number` */
    ECT_FAULT_ONCE,  /**< frame `number`, counted from 1 when the fault is set; then the fault ends */
} ect_fault_when_t;

typedef struct ect_fault {
    ect_fault_kind_t kind;
    ect_fault_when_t when;
    uint32_t number; /**< of `when` */
    int32_t amount;  /**< µs of DELAY, bytes of TRUNCATE, of COUNTER, bit of EEPROM_FLIP, ns of CLOCK */
    uint16_t slave;  /**< from 1; of faults of frames the slave at whose port 0 the wire is; 0: none */
    bool back;       /**< on a wire: on the way to the master */
} ect_fault_t;

/**
 * Reads a fault.
 * @param text  words between spaces, at most 95 characters
 * @param[out] fault  set on true, else undefined
 * @param[out] message  on failure the reason, one line for the user; ECT_FAULT_MESSAGE bytes
 * @return whether the text is a fault
 */
bool ect_fault_parse(const char *text, ect_fault_t *fault, char *message);

/** First word of the faults of a kind, 0 and up, several times where kinds share it. @return NULL: there are no more */
const char *ect_fault_word(size_t kind);

/** Writes a fault as text. @param[out] text  ECT_FAULT_TEXT bytes */
void ect_fault_print(const ect_fault_t *fault, char *text);

/** @return true: the fault concerns frames, and lasts; false: it concerns a slave, and is done at once */
static inline bool ect_fault_is_of_frames(const ect_fault_t *fault)
{
    return fault->kind < ECT_FAULT_OFF;
}

ECT_C_END

#endif
