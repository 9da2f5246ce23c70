/* SPDX-License-Identifier: MIT */
#include "bus/wiring.h"

#define PLUG(member, meaning)                                                                                          \
    {#member, meaning, NULL, ECT_SIGNAL_BOOL, ECT_SIGNAL_WRITE, offsetof(ect_wiring_t, member), 0, 1}

static const ect_signal_t signals[] = {
    PLUG(plug_in, "Plug of the input: 0 pulls it, the wire to the slave before is cut"),
    PLUG(plug_out, "Plug of the output: 0 pulls it, the wire to the next slave is cut"),
};

static const ect_signal_group_t groups[] = {
    {.prefix = "ecat", .signal_count = sizeof signals / sizeof signals[0], .signals = signals}};

const ect_plant_t ect_wiring_plant = {.signal_groups = groups, .signal_group_count = 1};
