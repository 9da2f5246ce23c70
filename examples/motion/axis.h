/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One axis with a PMCtendo DD5, cycle by cycle: enable it, find the reference, move a trapezoid with the touch probe
 * armed, read the probe, switch off. This file contains no master: the caller passes the inputs, and sends the written
 * outputs.
 *
 * Preconditions: PDOs 1720h (12 bytes out) and 1B25h (32 bytes in), mode 8 in 6060h, a homing method in 6098h.
 */
#ifndef TOOLS_MOTION_AXIS_H
#define TOOLS_MOTION_AXIS_H

#include <stdbool.h>
#include <stdint.h>

enum { AXIS_OUT = 12, AXIS_IN = 32 };

typedef enum axis_phase {
    AXIS_ENABLING,
    AXIS_HOMING,
    AXIS_RELEASING, /* the reference bit is cleared */
    AXIS_MOVING,
    AXIS_SETTLING,
    AXIS_READING, /* the probe */
    AXIS_DISABLING,
    AXIS_DONE,
    AXIS_FAILED,
} axis_phase_t;

typedef struct axis {
    /* settings */
    double cycle_s;      /**< of axis_cycle */
    double way;          /**< counts, from the reference point on; either direction */
    double speed;        /**< counts per second, above 0 */
    double acceleration; /**< counts per second squared, above 0 */

    /* results */
    axis_phase_t phase;
    const char *failure; /**< in AXIS_FAILED: the cause */
    uint16_t status;     /**< last value read */
    int32_t set, position, following_error;
    int16_t torque; /**< per mille */
    bool probed;
    int32_t probe;

    /* internal */
    unsigned int cycles; /* cycles in this phase */
    double start;
} axis_t;

/** Runs one cycle: reads `in`, AXIS_IN bytes of the slave, and writes `out`, AXIS_OUT bytes to send. */
void axis_cycle(axis_t *axis, const uint8_t *in, uint8_t *out);

/**
 * @return the position of the trapezoid after `t` seconds, counts from its start; constant after axis_duration()
 * seconds.
 */
double axis_trapezoid(const axis_t *axis, double t);
double axis_duration(const axis_t *axis);

/** @return the name of a phase, for output. */
const char *axis_phase_name(axis_phase_t phase);

#endif
