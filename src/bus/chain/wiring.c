/* SPDX-License-Identifier: MIT */
#include "bus/chain/wiring.h"

#include "esc/esc.h"

#define INPUT(name, member, kind, unit, minimum, maximum, meaning)                                                     \
    ECT_SIGNAL(ect_wiring_t, member, name, kind, WRITE, minimum, maximum, unit, meaning)
#define PLUG(name, port, meaning) INPUT(name, plug[port], BOOL, NULL, 0, 1, meaning)

static const ect_signal_t signals[] = {
    PLUG("plug_in", 0, "Plug of the input: 0 pulls it, the wire to the previous slave is cut"),
    PLUG("plug_out", 1, "Plug of the output: 0 pulls it, the wire to the next slave is cut"),
    PLUG("plug_2", 2, "Plug of port 2, at a junction"),
    PLUG("plug_3", 3, "Plug of port 3, at a junction"),
    INPUT("latch0", latch[0], BOOL, NULL, 0, 1, "Level of the input LATCH0 of the chip"),
    INPUT("latch1", latch[1], BOOL, NULL, 0, 1, "Level of the input LATCH1 of the chip"),
    INPUT("drift", drift_ppb, I32, "ppb", -ECT_ESC_MAX_DRIFT_PPB, ECT_ESC_MAX_DRIFT_PPB,
          "Deviation of the chip's oscillator, above 0: fast; 1000 ppb are 1 ppm"),
};

static const ect_signal_group_t groups[] = {
    {.prefix = "ecat", .signal_count = sizeof signals / sizeof signals[0], .signals = signals}};

const ect_plant_t ect_wiring_plant = {.signal_groups = groups, .signal_group_count = 1};
