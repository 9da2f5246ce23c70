/* SPDX-License-Identifier: MIT */
#include "heater.h"

#define SIGNAL(name, meaning, unit, kind, access, member, minimum, maximum)                                            \
    {name, meaning, unit, ECT_SIGNAL_##kind, ECT_SIGNAL_##access, offsetof(heater_t, member), minimum, maximum}

static const ect_signal_t signals[] = {
    SIGNAL("sensed", "Temperature at the sensor", "0.1 degC", I16, WRITE, sensed, -500, 3000),
    SIGNAL("broken", "The wire of the sensor is broken", NULL, BOOL, WRITE, broken, 0, 1),
    SIGNAL("set_point", "What the master wants", "0.1 degC", I16, READ, set_point, INT16_MIN, INT16_MAX),
    SIGNAL("power", "How hard it heats", "%", U8, READ, power, 0, 100),
};

static const ect_signal_group_t groups[] = {
    {.signals = signals, .signal_count = sizeof signals / sizeof signals[0]},
};

const ect_plant_t heater_plant = {.signal_groups = groups, .signal_group_count = 1};
