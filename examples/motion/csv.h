/* SPDX-License-Identifier: MIT */
/** @file The output of the motion program, for a spreadsheet or examples/motion/plot.py. */
#ifndef EXAMPLES_MOTION_CSV_H
#define EXAMPLES_MOTION_CSV_H

#include <stdio.h>

#include "axis.h"

static inline void csv_head(void)
{
    printf("ms,phase,status,set,position,following_error,torque\n");
}

static inline void csv_line(const axis_t *a, double ms)
{
    printf("%.3f,%s,0x%04X,%d,%d,%d,%d\n", ms, axis_phase_name(a->phase), a->status, a->set, a->position,
           a->following_error, a->torque);
}

#endif
