/* SPDX-License-Identifier: MIT */
#include "heater.h"

static const ect_signal_t signals[] = {
    ECT_SIGNAL(heater_t, sensed, "sensed", I16, WRITE, -500, 3000, "0.1 degC", "Temperature at the sensor"),
    ECT_SIGNAL(heater_t, broken, "broken", BOOL, WRITE, 0, 1, NULL, "The wire of the sensor is broken"),
    ECT_SIGNAL(heater_t, set_point, "set_point", I16, READ, INT16_MIN, INT16_MAX, "0.1 degC",
               "Temperature that the master sets"),
    ECT_SIGNAL(heater_t, power, "power", U8, READ, 0, 100, "%", "Heating power"),
};

static const ect_signal_group_t groups[] = {
    {.signals = signals, .signal_count = sizeof signals / sizeof signals[0]},
};

const ect_plant_t heater_plant = {.signal_groups = groups, .signal_group_count = 1};
