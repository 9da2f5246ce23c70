/* SPDX-License-Identifier: MIT */
/* Values by name: user level, laser power, errors in place of a distance and in the sensor state (manual p. 98). */
#include "devices/optoncdt2300/instance.h"

static const ect_value_name_t users[] = {{OPTO_USER, "User"}, {OPTO_EXPERT, "Expert"}, {0, NULL}};
static const ect_value_name_t powers[] = {
    {OPTO_FULL_POWER, "Full"}, {OPTO_REDUCED_POWER, "Reduced"}, {OPTO_NO_POWER, "Off"}, {0, NULL}};

/* The last digit of an error is the code in the sensor state. */
#define ERRORS(in)                                                                                                     \
    {in(OPTO_LASER_OFF), "Laser off"}, {in(OPTO_TOO_WIDE), "Peak too wide"},                                           \
        {in(OPTO_NOT_EVALUATED), "Cannot be evaluated"}, {in(OPTO_NOT_CALCULATED), "Cannot be calculated"},            \
        {in(OPTO_BEHIND_RANGE), "Peak behind the measuring range"},                                                    \
        {in(OPTO_BEFORE_RANGE), "Peak before the measuring range"}, {in(OPTO_NO_PEAK), "No peak"},                     \
    {                                                                                                                  \
        0, NULL                                                                                                        \
    }
#define WHOLE(error) (error)
#define DIGIT(error) ((error) & 0xF)
static const ect_value_name_t errors[] = {ERRORS(WHOLE)};
static const ect_value_name_t states[] = {{0, "Distance"}, ERRORS(DIGIT)};

#define DISTANCE(sub, shown_by)                                                                                        \
    {.index = 0x6065, .subindex = (sub), .open = true, .values = errors, .signal = (shown_by)}
#define STATE(low, which)                                                                                              \
    {.index = 0x6065, .subindex = 0x0C, .bit = (low), .width = 4, .name = (which), .values = states}

const ect_field_t opto_fields[] = {
    ECT_FIELD_VALUES(0x2001, 1, users, "user"),
    ECT_FIELD_VALUES(0x2001, 4, users, "default_user"),
    ECT_FIELD_VALUES(0x2131, 1, powers, NULL),
    DISTANCE(0x05, "distance1"),
    DISTANCE(0x07, "distance2"),
    STATE(0, "Distance 1"),
    STATE(4, "Distance 2"),
    DISTANCE(0x0D, "difference"),
    DISTANCE(0x0E, "minimum"),
    DISTANCE(0x0F, "maximum"),
    DISTANCE(0x10, "peak_to_peak"),
    {0},
};
