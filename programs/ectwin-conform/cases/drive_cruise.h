/* SPDX-License-Identifier: MIT */
/** @file A cruise of an axis at the speed of --move, and its end. */
#ifndef ECTWIN_CONFORM_DRIVE_CRUISE_H
#define ECTWIN_CONFORM_DRIVE_CRUISE_H

#include "cases/drive_steps.h"

/** The end of a motion, from the command to the standstill or to the wanted state. */
typedef struct cruise_end {
    uint32_t standstill_ms; /**< UINT32_MAX: no standstill within the time */
    uint32_t left_ms;       /**< Operation enabled, Quick stop active and Fault reaction active ended here */
    double left_speed;      /**< share of the speed of the cruise at `left_ms` */
} cruise_end_t;

/** Skips the case when the axis cannot be watched: no 6064h in the inputs. */
void cruise_need(drive_t *d);
/** ::cruise_need; skips the case when 6502h lacks the mode. @param name  of the mode, as in CiA 402 */
void cruise_need_mode(drive_t *d, int8_t mode, const char *name);
/**
 * Sets 6083h and 6084h to the acceleration of --move, and 6085h to twice of it. Objects that the axis lacks are left
 * out. The runner restores the values.
 */
void cruise_ramps(drive_t *d);
/** @return milliseconds from the speed of --move to 0, at its acceleration; at least 10 */
uint32_t cruise_ramp_ms(const drive_t *d);
/** @return position units a millisecond, from the last cycles */
double cruise_speed(const drive_t *d);
/** @return +1 or -1: the way back to the start */
int cruise_direction(drive_t *d);
/**
 * Takes the axis from Operation enabled, or from Switch on disabled, to a cruise in pv, else pp, else csp
 * (::cruise_mode). Skips the case when the axis has none of these modes.
 * @return the speed of the cruise, position units a millisecond, signed
 */
double cruise_begin(drive_t *d);
/** @return the mode of ::cruise_begin, 0: none. pp needs 6081h, which limits its speed */
int8_t cruise_mode(drive_t *d);
/** 6064h must be within a fiftieth of the distance of --move of `target`. A failure names `what`. */
void cruise_expect_at(drive_t *d, int64_t target, const char *what);
/**
 * Sets positions along a trapezoid of half the distance of --move, slower than --move when the way is short.
 * @param follows  6064h must follow, at most 50 ms behind, and end at the last position
 */
void cruise_trapezoid(drive_t *d, int direction, bool follows);
/** Cycles until the standstill of the axis, or for `ms`. Call after the command that ends the motion. */
cruise_end_t cruise_watch(drive_t *d, double speed, uint32_t ms);

#endif
