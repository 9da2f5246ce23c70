/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An injected fault, as a value with a text form. A printed fault is parsed to the same value. The order of the words
 * after the kind is free.
 *
 *     drop 5%                              one frame in twenty is lost, half of these on the way back
 *     delay 3000us every 10                each tenth reply is late by 3 ms
 *     duplicate frame 100                  the hundredth frame from now on gets two replies
 *     reorder every 7                      a reply leaves after the next one
 *     truncate 20 frame 3                  a request loses its last 20 bytes
 *     corrupt 1%                           one bit of a request is changed, undetected by the check sum
 *     counter -1 every 2                   the working counter of a reply's first datagram is reduced by one
 *     drop wire 3 back                     lost on the wire at the input of slave 3, on the way to the master
 *     damage 10% wire 3                    on the way from the master: slaves behind the wire count a bad check sum
 *     delay 3000us every 10 wire 2         late on a wire; every fault of frames can have a wire (bus/faults/wires.h)
 *     hang slave 2, resume slave 2         its microcontroller stops, and continues
 *     reset slave 2                        it restarts
 *     identity slave 2                     it is replaced by one with the next product code
 *     lose-event slave 2                   the next request to its AL control raises no event
 *     pdi-error slave 2                    an invalid access of its microcontroller counts in 0x030D
 *     eeprom busy slave 2, eeprom ok …     its EEPROM stays busy, or works again
 *     eeprom nack slave 2                  it does not reply
 *     eeprom flip 5 slave 2                bit 5 of the words read from it is inverted
 *     clock 5000ns slave 2                 its clock jumps; -5000ns: back
 *     to SAFEOP 0x001B slave 2             it leaves its state with this AL status code; init: to INIT
 *     emergency 0x5530 slave 2             it sends a CoE emergency
 *     al refuse 0x001D to SAFEOP slave 2   it refuses requests for this state; al never: it ignores these requests
 *     abort 0x1C12:1 0x06040043 slave 2    it aborts SDO transfers of this entry
 *     mail late 50ms 3rd of 0x1018 slave 2 its third mail about this object is late; lost, twice, toggle, ...
 *     pdo-size 2 slave 2                   it expects process data of two more bytes
 *     off                                  ends all lasting faults
 *
 * This file uses no clock; random numbers come from the caller's seed. Context: any.
 */
#ifndef ECT_BUS_CHAIN_FAULT_H
#define ECT_BUS_CHAIN_FAULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/names.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for a fault as text, and for a message about a fault, terminators included. */
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
    ECT_FAULT_HANG, /**< this and the following: of a slave, executed at once */
    ECT_FAULT_RESUME,
    ECT_FAULT_RESET,
    ECT_FAULT_IDENTITY,
    ECT_FAULT_LOSE_EVENT,
    ECT_FAULT_EEPROM_BUSY,
    ECT_FAULT_EEPROM_NACK,
    ECT_FAULT_EEPROM_FLIP,
    ECT_FAULT_EEPROM_OK,
    ECT_FAULT_CLOCK,
    ECT_FAULT_PDI_ERROR,
    ECT_FAULT_TO,
    ECT_FAULT_INIT,
    ECT_FAULT_EMERGENCY,
    ECT_FAULT_AL,
    ECT_FAULT_AL_REFUSE, /**< this and the following: of a slave, above the wire, lasting */
    ECT_FAULT_AL_NEVER,
    ECT_FAULT_ABORT,
    ECT_FAULT_MAIL_TOGGLE,
    ECT_FAULT_MAIL_COUNTER,
    ECT_FAULT_MAIL_TYPE,
    ECT_FAULT_MAIL_LENGTH,
    ECT_FAULT_MAIL_LATE,
    ECT_FAULT_MAIL_TWICE,
    ECT_FAULT_MAIL_LOST,
    ECT_FAULT_PDO_SIZE,
    ECT_FAULT_KINDS,
    ECT_FAULT_COUNT, /**< not a fault, and without a text: counts the SDO transfers that match it */
} ect_fault_kind_t;

/** The frames, mails or SDO transfers that a fault applies to. */
typedef enum ect_fault_when {
    ECT_FAULT_ALWAYS,
    ECT_FAULT_SHARE, /**< `number` percent, at random */
    ECT_FAULT_EVERY, /**< each whose count is a multiple of `number` */
    ECT_FAULT_ONCE,  /**< number `number`, counted from 1 when the fault is set; then the fault ends */
} ect_fault_when_t;

/** Direction of an SDO transfer. */
typedef enum ect_fault_transfer { ECT_FAULT_ANY_TRANSFER, ECT_FAULT_UPLOAD, ECT_FAULT_DOWNLOAD } ect_fault_transfer_t;

/** The SDO transfers, or the mails of transfers, that a fault applies to. */
typedef struct ect_fault_object {
    bool named;   /**< false: all mails */
    bool has_sub; /**< false: all entries of the object */
    uint8_t sub;
    uint16_t index;
    ect_fault_transfer_t transfer;
} ect_fault_object_t;

typedef struct ect_fault {
    ect_fault_kind_t kind;
    ect_fault_when_t when;
    uint32_t number; /**< of `when` */
    /** µs of DELAY, bytes of TRUNCATE and PDO_SIZE, of COUNTER, bit of EEPROM_FLIP, ns of CLOCK, ms of MAIL_LATE,
     * number of the request of a transfer of ABORT, error register of EMERGENCY */
    int32_t amount;
    uint16_t slave;            /**< from 1; for faults of frames the slave at whose port 0 the wire ends; 0: none */
    bool back;                 /**< on a wire: on the way to the master */
    uint8_t state;             /**< AL state of TO, AL and AL_...; 0: none */
    uint32_t code;             /**< abort code, AL status code, error code of EMERGENCY */
    uint8_t data[5];           /**< of EMERGENCY */
    ect_fault_object_t object; /**< of ABORT and MAIL_... */
    uint32_t seed;             /**< of SHARE, above the wire: of its random numbers */
    uint32_t tag;              /**< for ::ect_chain_fault_end; 0: none. Not part of the text */
} ect_fault_t;

/**
 * Reads a fault that may name twins: "hang slave gripper".
 * @param names  NULL: no twin has a name. Otherwise as ::ect_fault_parse
 */
bool ect_fault_parse_named(const char *text, const ect_names_t *names, ect_fault_t *fault, char *message);

/**
 * Reads a fault.
 * @param text  words between spaces, at most 95 characters
 * @param[out] fault  set on true, else undefined
 * @param[out] message  on failure the reason, one line for the user; ECT_FAULT_MESSAGE bytes
 * @return whether the text is a fault
 */
bool ect_fault_parse(const char *text, ect_fault_t *fault, char *message);

/**
 * Reads an object: "0x1018", "1018h", "0x1018:1". @return whether the text is an object; sets index, sub and `named` on
 * true
 */
bool ect_fault_read_object(const char *text, ect_fault_object_t *object);

/** Reads "1st", "2nd", "3rd", "4th" ... @return the number, from 1; 0: another text */
uint32_t ect_fault_ordinal(const char *text);

/** @return the AL state with a name (INIT, PREOP, BOOT, SAFEOP, OP); 0: none */
uint8_t ect_fault_state(const char *name);

/** @return the direction of a transfer, "upload" or "download"; ECT_FAULT_ANY_TRANSFER: another word */
ect_fault_transfer_t ect_fault_transfer(const char *word);

/**
 * @param count  number of the frame, mail or SDO transfer among those counted by the fault, from 1
 * @param[in,out] seed  of the random generator; SHARE takes a number each time, regardless of other faults
 * @return whether the fault applies
 */
bool ect_fault_applies(const ect_fault_t *fault, uint64_t count, uint32_t *seed);

/** @return the first word of the faults of a kind, from 0, repeated if kinds share the word; NULL: no further kind */
const char *ect_fault_word(size_t kind);

/** Writes a fault as text. @param[out] text  ECT_FAULT_TEXT bytes */
void ect_fault_print(const ect_fault_t *fault, char *text);

/** As ::ect_fault_print, with the name of the twin if it has one and the room suffices. @param names  NULL: none */
void ect_fault_print_named(const ect_fault_t *fault, const ect_names_t *names, char *text);

/** @return whether the fault applies to frames, and therefore lasts */
static inline bool ect_fault_is_of_frames(const ect_fault_t *fault)
{
    return fault->kind < ECT_FAULT_OFF;
}

/** @return whether the fault applies to a slave and lasts until it is ended; else it is executed at once */
static inline bool ect_fault_is_above_wire(const ect_fault_t *fault)
{
    return fault->kind >= ECT_FAULT_AL_REFUSE;
}

ECT_C_END

#endif
