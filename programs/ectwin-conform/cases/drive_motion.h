/* SPDX-License-Identifier: MIT */
/** @file Cases of CiA 402 drives that give torque to the motor (--move). */
#ifndef ECTWIN_CONFORM_DRIVE_MOTION_H
#define ECTWIN_CONFORM_DRIVE_MOTION_H

#include "steps/case.h"

/** CF-D05: transitions 2 to 10, at a standstill. */
void cf_drive_transitions(cf_t *c);
/** CF-D06: 605Ah; transitions 11, 12 and 16. */
void cf_drive_quick_stop(cf_t *c);
/** CF-D07: 605Bh and 605Ch; transitions 8 and 5 in motion. */
void cf_drive_stops(cf_t *c);
/** CF-D08: 605Dh. */
void cf_drive_halt(cf_t *c);
/** CF-D09: 6007h and 605Eh; transitions 13 to 15. */
void cf_drive_fault(cf_t *c);
/** CF-D10 to CF-D13: modes of operation. */
void cf_drive_position(cf_t *c);
void cf_drive_velocity(cf_t *c);
void cf_drive_homing(cf_t *c);
void cf_drive_cyclic(cf_t *c);
/** CF-D14 to CF-D17: ip, csv, tq, cst. */
void cf_drive_interpolated(cf_t *c);
void cf_drive_cyclic_speed(cf_t *c);
void cf_drive_torque(cf_t *c);
void cf_drive_cyclic_torque(cf_t *c);

#endif
