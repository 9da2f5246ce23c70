/* SPDX-License-Identifier: MIT */
/* The user's side by name: target and surroundings of the sensor, and its results. */
#include <string.h>

#include "devices/optoncdt2300/instance.h"
#include "devices/optoncdt2300/optoncdt2300.h"

#define R(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(opto_t, member, name, kind, READ, minimum, maximum, unit, meaning)
#define W(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(opto_t, member, name, kind, WRITE, minimum, maximum, unit, meaning)
#define S(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(opto_surface_t, member, name, kind, WRITE, minimum, maximum, unit, meaning)
#define VALUE(which, name, meaning)       R(record.value[OPTO_##which], name, I32, INT32_MIN, INT32_MAX, "nm", meaning)
#define COUNT(which, name, unit, meaning) R(record.value[OPTO_##which], name, U32, 0, UINT32_MAX, unit, meaning)

enum { FARTHEST = 2147, MINUTE_US = 60000000 };

static const ect_signal_t signals[] = {
    W(plant.laser, "laser", BOOL, 0, 1, NULL, "the laser is switched on, at its input"),
    W(plant.range, "range", REAL, 1, 500, "mm", "measuring range"),
    W(plant.exposure, "exposure", REAL, 0, 1310, "us", "exposure time; at most a period of the measuring rate"),
    W(plant.temperature, "temperature", REAL, -55, 127, "degC", "of the sensor"),
    W(plant.seed, "seed", U32, 1, INT32_MAX, NULL, "random seed of the noise; a write restarts the noise"),
    W(rate_hz, "rate", U32, 1500, 49140, "Hz", "measuring rate: 1500, 2500, 5000, 10000, 20000, 30000, 49140"),
    W(laser_power, "laser_power", U8, 0, 2, NULL, "0 full, 1 reduced: half the intensity, 2 off"),
    W(plant.default_user, "default_user", U8, 0, 1, NULL, "user level after power-on: 0 user, 1 expert"),
    W(user, "user", U8, 0, 1, NULL, "user level: 0 user, 1 expert"),
    W(error_number, "error_number", U16, 0, UINT16_MAX, NULL, "sensor error, as in 603Fh"),
    W(error_text, "error_text", TEXT, 0, OPTO_ERROR_TEXT, NULL, "its description"),
    W(statistic_reset, "statistic_reset", BOOL, 0, 1, NULL, "writing 1 resets minimum and maximum"),
    W(restart, "restart", BOOL, 0, 1, NULL, "writing 1 switches the sensor off and on again"),

    W(plant.row.distance[0], "row1", REAL, -FARTHEST, FARTHEST, "mm", "surface 1 in the next row of the table"),
    W(plant.row.distance[1], "row2", REAL, -FARTHEST, FARTHEST, "mm", "surface 2 in the next row"),
    W(plant.row.present, "row_present", BOOL, 0, 1, NULL, "0: no target in the next row"),
    W(plant.row_time_us, "row_time", U32, 1, MINUTE_US, "us", "time of each row in front of the sensor"),
    W(row_add, "row_add", BOOL, 0, 1, NULL, "writing 1 adds row1, row2, row_present to the table as a row"),
    W(row_clear, "row_clear", BOOL, 0, 1, NULL, "writing 1 empties the table"),
    R(plant.rows, "rows", U16, 0, OPTO_TABLE, NULL, "rows of the table; they pass in a loop"),

    VALUE(DISTANCE_1, "distance1", "distance 1 of the last record, or its error, from 2147483637 on"),
    VALUE(DISTANCE_2, "distance2", "distance 2, or its error"),
    R(why[0], "error1", TEXT, 0, OPTO_ERROR_TEXT, NULL, "reason of a missing distance 1"),
    R(why[1], "error2", TEXT, 0, OPTO_ERROR_TEXT, NULL, "reason of a missing distance 2"),
    VALUE(DIFFERENCE, "difference", "distance 2 less distance 1"),
    VALUE(MINIMUM, "minimum", "the smallest distance 1 so far"),
    VALUE(MAXIMUM, "maximum", "the largest one"),
    VALUE(PEAK_TO_PEAK, "peak_to_peak", "their difference"),
    COUNT(INTENSITY_1, "intensity1", NULL, "of surface 1, 0 to 1023"),
    COUNT(INTENSITY_2, "intensity2", NULL, "of surface 2"),
    COUNT(COUNTER, "counter", NULL, "number of the last record, modulo 2^24"),
    COUNT(TIMESTAMP, "timestamp", "us", "time of the last record, from power-on"),
    COUNT(STATE, "state", NULL, "last digit of the errors: bits 0 to 3 of distance 1, 4 to 7 of distance 2"),
    R(synchronised_level, "synchronised", BOOL, 0, 1, NULL, "records are taken at SYNC0"),
    R(assigned, "samples", U8, 0, OPTO_SAMPLES, NULL, "records in an exchange"),
};

static const ect_signal_t surface[] = {
    S(present, "present", BOOL, 0, 1, NULL, "the laser meets this surface"),
    S(distance, "distance", REAL, -FARTHEST, FARTHEST, "mm", "from the start of the measuring range"),
    S(source, "source", U8, 0, 3, NULL, "0 fixed, 1 plus ramp, 2 plus sine; 3 from the table; a write starts it"),
    S(amplitude, "amplitude", REAL, -FARTHEST, FARTHEST, "mm", "of ramp and sine"),
    S(period_us, "period", U32, 1, MINUTE_US, "us", "of ramp and sine"),
    S(noise, "noise", REAL, 0, 100, "mm", "standard deviation of each record"),
    S(intensity, "intensity", REAL, 0, 100, "%", "of the reflected light; 0: no peak"),
    S(fault, "fault", U8, 0, 8, NULL, "0 none, 6 peak too wide, 7 cannot be evaluated, 8 cannot be calculated"),
};

static const ect_signal_group_t groups[] = {
    {.signal_count = sizeof signals / sizeof signals[0], .signals = signals},
    {.prefix = "surface",
     .count = OPTO_SURFACES,
     .offset = offsetof(opto_t, plant.surface),
     .stride = sizeof(opto_surface_t),
     .signal_count = sizeof surface / sizeof surface[0],
     .signals = surface},
};

/* --- from the user ------------------------------------------------------------------------------------------------ */

#define IS(signal, member) ((signal)->offset == offsetof(opto_t, member))

static const char *add_row(opto_t *u)
{
    if (u->plant.rows == OPTO_TABLE)
        return "the table is full: empty it with row_clear";
    u->plant.table[u->plant.rows++] = u->plant.row;
    return "";
}

static const char *clear_rows(opto_t *u)
{
    u->plant.rows = 0;
    return "";
}

static const char *reset_statistic(opto_t *u)
{
    opto_reset_statistic(u);
    return "";
}

static const char *restart(opto_t *u)
{
    u->host->restart(u->host->ctx);
    return "";
}

/* Handles buttons: 1 presses, 0 has no effect. @return NULL: another signal */
static const char *press(opto_t *u, const ect_signal_t *signal, uint8_t value)
{
    static const struct {
        uint32_t offset;
        const char *(*action)(opto_t *u);
    } buttons[] = {{offsetof(opto_t, row_add), add_row},
                   {offsetof(opto_t, row_clear), clear_rows},
                   {offsetof(opto_t, statistic_reset), reset_statistic},
                   {offsetof(opto_t, restart), restart}};
    for (size_t i = 0; i < sizeof buttons / sizeof buttons[0]; i++) {
        if (signal->offset == buttons[i].offset)
            return value ? buttons[i].action(u) : "";
    }
    return NULL;
}

static const char *write_surface(const ect_signal_t *signal, const void *value)
{
    uint8_t fault = *(const uint8_t *)value;
    bool possible = signal->offset != offsetof(opto_surface_t, fault) || fault == 0 || fault >= 6;
    return possible ? NULL : "0, 6, 7 or 8";
}

static const char *write_number(const ect_signal_t *signal, const void *value)
{
    uint32_t number;
    if (!IS(signal, rate_hz))
        return NULL;
    memcpy(&number, value, sizeof number);
    return opto_is_rate(number) ? NULL : "not a measuring rate: 1500, 2500, 5000, 10000, 20000, 30000 or 49140";
}

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    opto_t *u = instance;
    opto_advance(u, now_ns);
    if (number > 0)
        return write_surface(signal, value);
    if (signal->type == ECT_SIGNAL_BOOL)
        return press(u, signal, *(const uint8_t *)value);
    return write_number(signal, value);
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    opto_t *u = instance;
    if (number > 0 && signal->offset == offsetof(opto_surface_t, source))
        u->plant.surface[number - 1].origin_ns = now_ns;
    if (number > 0)
        return;
    if (IS(signal, rate_hz))
        opto_new_rate(u, now_ns);
    if (IS(signal, plant.range))
        u->range = (float)u->plant.range;
    if (IS(signal, plant.seed))
        u->plant.random = u->plant.seed;
}

const ect_plant_t ect_optoncdt2300_plant = {
    .signal_groups = groups,
    .signal_group_count = sizeof groups / sizeof groups[0],
    .outside_offset = offsetof(opto_t, plant),
    .outside_size = sizeof(opto_plant_t),
    .signal_write = signal_write,
    .signal_written = signal_written,
    .fields = opto_fields,
};
