/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals: the plant of a device, as named values that a person or a test sets and watches.
 *
 * A device lists its signals in groups. A group describes one structure inside the instance, or an array of equal
 * structures: group { "ru", 8 } with signal "joystick1" gives `ru1.joystick1` .. `ru8.joystick1`. A group with count 0
 * has no number (`bu.state`), one without a prefix no dot (`scene`). The control socket, the command line and the tests
 * use these names only, so a new signal is one new line in a device's table.
 *
 * The tables are constant and shared by all instances; the values are in the instance. Context: mainline, between two
 * polls of the stack.
 */
#ifndef ECT_SEAMS_SIGNALS_H
#define ECT_SEAMS_SIGNALS_H

#include <stddef.h>
#include <stdint.h>

/** Representation of the value in the instance. */
typedef enum ect_signal_type {
    ECT_SIGNAL_BOOL,      /**< uint8_t, 0 or 1 */
    ECT_SIGNAL_U8,        /**< uint8_t */
    ECT_SIGNAL_I16,       /**< int16_t */
    ECT_SIGNAL_U16,       /**< uint16_t */
    ECT_SIGNAL_I32,       /**< int32_t */
    ECT_SIGNAL_U32,       /**< uint32_t */
    ECT_SIGNAL_I8,        /**< int8_t */
    ECT_SIGNAL_I64,       /**< int64_t */
    ECT_SIGNAL_U64,       /**< uint64_t; up to INT64_MAX can be set */
    ECT_SIGNAL_REAL32,    /**< float */
    ECT_SIGNAL_REAL,      /**< double */
    ECT_SIGNAL_TEXT,      /**< char[maximum + 1], zero-terminated */
    ECT_SIGNAL_BYTES,     /**< uint8_t[maximum]; users read and write hexadecimal digits */
    ECT_SIGNAL_DESCRIBED, /**< uint16_t, read only; users read the text of ect_plant_t::signal_describe */
} ect_signal_type_t;

/** Access of a user. A signal with ECT_SIGNAL_WRITE is an input of the plant; the twin itself sets the others. */
typedef enum ect_signal_access { ECT_SIGNAL_READ, ECT_SIGNAL_WRITE } ect_signal_access_t;

/** The greatest lengths of a TEXT and a BYTES signal. */
enum { ECT_SIGNAL_LONGEST_TEXT = 127, ECT_SIGNAL_LONGEST_BYTES = 64 };

/** A signal of a group. */
typedef struct ect_signal {
    const char *name;    /**< lower case, digits, `_`; the part after the group's prefix and dot */
    const char *meaning; /**< one line for a reader of the device's manual */
    const char *unit;    /**< "%", "ms", ... or NULL */
    ect_signal_type_t type;
    ect_signal_access_t access;
    uint32_t offset; /**< of the value inside the group's structure */
    int64_t minimum; /**< inclusive; 0 for TEXT, BYTES and DESCRIBED */
    int64_t maximum; /**< inclusive; for TEXT, BYTES and DESCRIBED the greatest length */
    uint8_t turn;    /**< 0: any order. 1, 2: a write replaces values of other signals (the number of a scene): among
                        signals that are set or have changed together, 1 precedes 2, and 2 precedes 0 */
} ect_signal_t;

/**
 * A row of a device's table: a signal whose value is a member of the group's structure.
 * @param structure, member  type and member
 * @param name               of the signal
 * @param kind               BOOL, U8, ... : ect_signal_type_t
 * @param rights             READ or WRITE
 * @param minimum, maximum   inclusive range, or length
 * @param unit, meaning      as in ::ect_signal_t
 */
#define ECT_SIGNAL(structure, member, name, kind, rights, minimum, maximum, unit, meaning)                             \
    {name, meaning, unit, ECT_SIGNAL_##kind, ECT_SIGNAL_##rights, offsetof(structure, member), minimum, maximum, 0}

/**
 * A row for a signal of 8 bits that selects the values of other signals, and is written before these, by its turn, 1 or
 * 2.
 */
#define ECT_SIGNAL_CHOICE(structure, member, name, minimum, maximum, its_turn, meaning)                                \
    {name, meaning, NULL, ECT_SIGNAL_U8, ECT_SIGNAL_WRITE, offsetof(structure, member), minimum, maximum, its_turn}

/** Signals over one structure of the instance, or over an array of equal structures. */
typedef struct ect_signal_group {
    const char *prefix;          /**< "bu", "ru", or NULL for none */
    uint16_t count;              /**< 0: one structure without a number; n: structures 1..n */
    uint16_t signal_count;       /**< elements of `signals` */
    uint32_t offset;             /**< of the (first) structure inside the instance */
    uint32_t stride;             /**< bytes from one structure to the next */
    const ect_signal_t *signals; /**< constant, the device's */
} ect_signal_group_t;

#endif
