/* SPDX-License-Identifier: MIT */
/*
 * The axis of the motion program with a PMCtendo in virtual time: prints the output of ectwin-motion.
 * usage: drive_record
 * The machine has a reference switch two turns away, and a mark for the probe at six turns.
 */
#include <stdio.h>

#include "axis.h"
#include "csv.h"
#include "support/drive.h"

#define TURN PMC_TURN

int main(void)
{
    static drive_t d;
    axis_t axis = {.cycle_s = 0.001, .way = 10.0 * TURN, .speed = 10.0 * TURN, .acceleration = 100.0 * TURN};
    drive_open(&d);
    signal_set(&d.w, "home_at", "2097152");
    signal_set(&d.w, "home_width", "524288");
    signal_set(&d.w, "probe_at", "6291456");
    signal_set(&d.w, "probe_width", "1000");
    assert_int_equal(drive_write(&d, 0x6098, 0, 20, 1), 0);
    drive_operational(&d, PMC_PDO_POSITION_FULL, PMC_PDO_ACTUAL_FULL);
    csv_head();
    for (unsigned int ms = 0; axis.phase < AXIS_DONE; ms++) {
        axis_cycle(&axis, d.in, d.out);
        csv_line(&axis, ms);
        drive_cycle(&d);
    }
    drive_close(&d);
    fprintf(stderr, "position %d, probe %d %s\n", axis.position, axis.probe, axis.failure ? axis.failure : "");
    return axis.phase == AXIS_DONE && axis.probed && axis.probe == 4 * TURN ? 0 : 1;
}
