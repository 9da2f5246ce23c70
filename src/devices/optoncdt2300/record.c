/* SPDX-License-Identifier: MIT */
/* One measurement: the peaks of the laser, and the values computed from them. */
#include "devices/optoncdt2300/instance.h"

enum { COUNTER = 0xFFFFFF, EXPOSURE = 0x1FFFF, NIBBLE = 0xF, ERROR_BITS = 4 };

static bool is_value(int32_t distance)
{
    return distance < OPTO_ERRORS;
}

void opto_reset_statistic(opto_t *u)
{
    u->statistic = false;
}

static void count_in(opto_t *u, int32_t distance)
{
    if (!is_value(distance))
        return;
    u->minimum = u->statistic && u->minimum < distance ? u->minimum : distance;
    u->maximum = u->statistic && u->maximum > distance ? u->maximum : distance;
    u->statistic = true;
}

/* @return the reasons of missing distances, four bits for each surface: the last digit of the error */
static int32_t state_of(const int32_t distance[OPTO_SURFACES])
{
    int32_t state = 0;
    for (unsigned int n = 0; n < OPTO_SURFACES; n++) {
        int32_t error = is_value(distance[n]) ? 0 : distance[n] & NIBBLE;
        state |= error << (ERROR_BITS * n);
    }
    return state;
}

/* In steps of 12.5 ns (§8.2.2); the exposure ends with the period. */
static int32_t exposure(const opto_t *u, uint64_t period_ns)
{
    uint64_t ns = (uint64_t)(u->plant.exposure * 1000);
    uint64_t steps = (ns < period_ns ? ns : period_ns) * 2 / 25;
    return (int32_t)(steps < EXPOSURE ? steps : EXPOSURE);
}

static int32_t quarters(double celsius)
{
    return (int32_t)(celsius * 4 + (celsius < 0 ? -0.5 : 0.5));
}

void opto_take_record(opto_t *u, uint64_t at_ns, uint64_t period_ns)
{
    int32_t distance[OPTO_SURFACES], intensity[OPTO_SURFACES];
    for (unsigned int n = 0; n < OPTO_SURFACES; n++) {
        opto_peak_t peak = opto_find_peak(u, n, at_ns);
        distance[n] = peak.distance;
        intensity[n] = peak.intensity;
    }
    count_in(u, distance[0]);
    bool both = is_value(distance[0]) && is_value(distance[1]);
    u->record = (opto_record_t){{
        [OPTO_EXPOSURE] = exposure(u, period_ns),
        [OPTO_COUNTER] = (int32_t)(u->taken & COUNTER),
        [OPTO_TIMESTAMP] = (int32_t)(uint32_t)((at_ns - u->start_ns) / 1000),
        [OPTO_TEMPERATURE] = quarters(u->plant.temperature),
        [OPTO_INTENSITY_1] = intensity[0],
        [OPTO_DISTANCE_1] = distance[0],
        [OPTO_INTENSITY_2] = intensity[1],
        [OPTO_DISTANCE_2] = distance[1],
        [OPTO_STATE] = state_of(distance),
        [OPTO_DIFFERENCE] = both ? distance[1] - distance[0] : OPTO_NOT_CALCULATED,
        [OPTO_MINIMUM] = u->statistic ? u->minimum : OPTO_NOT_CALCULATED,
        [OPTO_MAXIMUM] = u->statistic ? u->maximum : OPTO_NOT_CALCULATED,
        [OPTO_PEAK_TO_PEAK] = u->statistic ? u->maximum - u->minimum : OPTO_NOT_CALCULATED,
    }};
}
