/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals by name: find, read and set the values that the tables of a plant (seams/plant.h) describe.
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
enum { ECT_SIGNAL_NAME = 64, ECT_SIGNAL_TEXT_ROOM = 2 * ECT_SIGNAL_LONGEST_BYTES + 1, ECT_SIGNAL_MESSAGE = 256 };

/** One signal of one instance. */
typedef struct ect_signal_ref {
    const ect_plant_t *plant;
    void *instance;
    const ect_signal_t *signal;
    uint16_t number; /**< of the structure in an array, from 1; 0 none */
    uint8_t *value;
    char name[ECT_SIGNAL_NAME];
    const char *twin; /**< name of the twin in its chain; NULL: none */
} ect_signal_ref_t;

/** Position in the list of a device's signals. Zeroed: before the first. */
typedef struct ect_signal_cursor {
    uint16_t group, number, index;
} ect_signal_cursor_t;

/**
 * Takes the next signal, in the order of the tables. Cost: one name is written, at any position.
 * @param plant  NULL: the list is empty
 * @param[in,out] cursor  advanced past the signal
 * @param[out] ref  set on true; valid as long as the instance
 * @return false: no further signal
 */
bool ect_signals_next(const ect_plant_t *plant, void *instance, ect_signal_cursor_t *cursor, ect_signal_ref_t *ref);

/**
 * Finds a signal by its exact name. Cost: comparisons with the names of one group.
 * @param[out] ref  set on true; valid as long as the instance
 * @return whether the signal exists
 */
bool ect_signal_find(const ect_plant_t *plant, void *instance, const char *name, ect_signal_ref_t *ref);

/** @return the bytes of a value in the instance. */
size_t ect_signal_size(const ect_signal_t *signal);

/** @return whether the value is a number in JSON, not a string (TEXT, BYTES, DESCRIBED) */
bool ect_signal_is_number(const ect_signal_t *signal);

/**
 * Writes a value of this signal as text: numbers decimal, bytes hexadecimal, invisible characters as '?'.
 * @param value      ect_signal_size() bytes as in an instance, of any alignment
 * @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes
 */
void ect_signal_text(const ect_signal_ref_t *ref, const void *value, char *text);

/** Writes the present value as text. @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes */
void ect_signal_read(const ect_signal_ref_t *ref, char *text);

/**
 * Sets a signal from text. A number is decimal, or hexadecimal after 0x; "010" is ten.
 * @param[out] message  on failure the reason, with the range; ECT_SIGNAL_MESSAGE bytes
 * @return false: the signal is read-only, the value is outside its range, or the plant refuses it; nothing has changed
 */
bool ect_signal_write(const ect_signal_ref_t *ref, const char *text, uint64_t now_ns, char *message);

/** Checks access and range, like ::ect_signal_write, without the plant. The signal is unchanged. */
bool ect_signal_check(const ect_signal_ref_t *ref, const char *text, char *message);

/**
 * Fits a number into a numeric signal: limited to the range, and rounded for an integer signal.
 * @param value  NaN results in the lowest value
 */
double ect_signal_fit(const ect_signal_t *signal, double value);

/** Writes the range of a signal's values as text, e.g. "-1000..1000 %". @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes */
void ect_signal_range(const ect_signal_t *signal, char *text);

ECT_C_END

#endif
