/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Waves: signals set to a function of the time, one value each millisecond, until the wave is ended.
 *
 * This file uses no clock. Context: the thread of the runner. Cost: a comparison for each wave; when a value is due, a
 * search for the signal by its name, and a write if its text has changed.
 */
#ifndef ECT_BUS_FAULTS_WAVES_H
#define ECT_BUS_FAULTS_WAVES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_WAVES = 8, ECT_WAVE_STEP_NS = 1000000 };

/** Shapes of a period: sine from the middle upwards; ramp from low to high; square, high in the first half. */
typedef enum ect_wave_shape { ECT_WAVE_SINE, ECT_WAVE_RAMP, ECT_WAVE_SQUARE, ECT_WAVE_SHAPES } ect_wave_shape_t;

/** The caller of ::ect_waves_set sets the members down to `period_ns`; the other members are private. */
typedef struct ect_wave {
    size_t position;            /**< of the twin in the chain, from 0 */
    char name[ECT_SIGNAL_NAME]; /**< of a signal that is a number and can be set */
    ect_wave_shape_t shape;
    double low, high;   /**< values within the range of the signal; low <= high */
    uint64_t period_ns; /**< at least 10 ms */
    uint64_t start_ns, due_ns;
    char last[32];
} ect_wave_t;

/** Zeroed: none. */
typedef struct ect_waves {
    size_t count;
    ect_wave_t all[ECT_WAVES];
} ect_waves_t;

/** @return the name of a shape, "sine" */
const char *ect_wave_shape_name(ect_wave_shape_t shape);

/** @return the shape with a name; ECT_WAVE_SHAPES: none */
ect_wave_shape_t ect_wave_shape(const char *name);

/** @return the value at a time, not before the start. */
double ect_wave_value(const ect_wave_t *wave, uint64_t now_ns);

/**
 * Begins a wave, which replaces a wave of the same signal.
 * @param[out] message  on failure the reason, one line for the user; ECT_SIGNAL_MESSAGE bytes
 * @return false: no such signal, a value beyond its range, too short a period, or ECT_WAVES waves
 */
bool ect_waves_set(ect_waves_t *waves, const ect_chain_t *chain, const ect_wave_t *wave, uint64_t now_ns,
                   char *message);

/** Ends the wave of a signal; the last value remains. @param name  NULL: all waves. @return false: no such wave */
bool ect_waves_end(ect_waves_t *waves, size_t position, const char *name);

/**
 * Sets due values. A wave whose value is refused ends.
 * @param[out] acted  set to true when a signal was set; otherwise unchanged
 * @param refused     called with the name of a signal and the reason; NULL: not called
 * @return time of the next value; ECT_NEVER
 */
uint64_t ect_waves_run(ect_waves_t *waves, ect_chain_t *chain, uint64_t now_ns, bool *acted,
                       void (*refused)(void *ctx, const char *name, const char *why), void *ctx);

ECT_C_END

#endif
