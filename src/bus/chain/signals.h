/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals by name: finding, reading and setting what a plant's tables (seams/plant.h) describe.
 *
 * Context: the thread of the chain, between two polls.
 */
#ifndef ECT_BUS_CHAIN_SIGNALS_H
#define ECT_BUS_CHAIN_SIGNALS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for a signal's name, for its value as text, and for a message, terminator included. */
enum { ECT_SIGNAL_NAME = 64, ECT_SIGNAL_TEXT_ROOM = 128, ECT_SIGNAL_MESSAGE = 256 };

/** One signal of one instance. */
typedef struct ect_signal_ref {
    const ect_plant_t *plant;
    void *instance;
    const ect_signal_t *signal;
    uint16_t number; /**< of the structure in an array, from 1; 0 none */
    uint8_t *value;
    char name[ECT_SIGNAL_NAME];
} ect_signal_ref_t;

/** How far a walk through the signals of a device has come. Zeroed: at its beginning. */
typedef struct ect_signal_cursor {
    uint16_t group, number, index;
} ect_signal_cursor_t;

/**
 * The next signal of a walk, in the order of the tables. Cost: that of writing its name, wherever the walk stands.
 * @param plant  NULL: there are none
 * @return whether there is one; then *ref is set and the cursor stands behind it
 */
bool ect_signals_next(const ect_plant_t *plant, void *instance, ect_signal_cursor_t *cursor, ect_signal_ref_t *ref);

/**
 * @return whether there is a signal of exactly that name; then *ref is set. Cost: comparing the names of its group.
 */
bool ect_signal_find(const ect_plant_t *plant, void *instance, const char *name, ect_signal_ref_t *ref);

/** Bytes that a value takes in the instance. */
size_t ect_signal_size(const ect_signal_t *signal);

/** Whether a value reads as a number, and not as a text in quotes (TEXT, BYTES, DESCRIBED). */
bool ect_signal_is_number(const ect_signal_t *signal);

/**
 * A value of this signal, its present one or another, as text: numbers decimal, bytes hexadecimal, what is not visible
 * in a text as '?'.
 * @param value      ect_signal_size() bytes as they stand in an instance, of any alignment
 * @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes
 */
void ect_signal_text(const ect_signal_ref_t *ref, const void *value, char *text);

/** The present value as text. @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes */
void ect_signal_read(const ect_signal_ref_t *ref, char *text);

/**
 * Sets a signal from text (a number is decimal, or hexadecimal behind 0x; "010" is ten), if the user may, the value is
 * in its range and the plant agrees.
 * @param[out] message  on failure why not, with the range; ECT_SIGNAL_MESSAGE bytes
 * @return whether it was done; if not, nothing has changed
 */
bool ect_signal_write(const ect_signal_ref_t *ref, const char *text, uint64_t now_ns, char *message);

/** The part of ::ect_signal_write that asks no device: may the user set it, is the value in its range. Sets nothing. */
bool ect_signal_check(const ect_signal_ref_t *ref, const char *text, char *message);

/** Range of a signal's values as text, e.g. "-1000..1000 %". @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes */
void ect_signal_range(const ect_signal_t *signal, char *text);

ECT_C_END

#endif
