/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Signals by name: finding, reading and setting what a plant's tables (seams/plant.h) describe.
 *
 * Context: the thread of the chain, between two polls.
 */
#ifndef ECT_BUS_SIGNALS_H
#define ECT_BUS_SIGNALS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "seams/plant.h"

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

/**
 * Calls `visit` for each signal whose name matches a shell pattern ("ru1.*", "*"), in the order of the tables.
 * @param plant  NULL: there are none
 * @return how many matched
 */
size_t ect_signals_visit(const ect_plant_t *plant, void *instance, const char *pattern,
                         void (*visit)(void *ctx, const ect_signal_ref_t *ref), void *ctx);

/** @return whether there is a signal of exactly that name; then *ref is set */
bool ect_signal_find(const ect_plant_t *plant, void *instance, const char *name, ect_signal_ref_t *ref);

/** The value as text: numbers decimal, bytes hexadecimal. @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes */
void ect_signal_read(const ect_signal_ref_t *ref, char *text);

/**
 * Sets a signal from text, if the user may, the value is in its range and the plant agrees.
 * @param[out] message  on failure why not, with the range; ECT_SIGNAL_MESSAGE bytes
 * @return whether it was done; if not, nothing has changed
 */
bool ect_signal_write(const ect_signal_ref_t *ref, const char *text, uint64_t now_ns, char *message);

/** Range of a signal's values as text, e.g. "-1000..1000 %". @param[out] text  ECT_SIGNAL_TEXT_ROOM bytes */
void ect_signal_range(const ect_signal_t *signal, char *text);

#endif
