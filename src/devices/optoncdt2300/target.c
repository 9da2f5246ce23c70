/* SPDX-License-Identifier: MIT */
/* The model of the target in front of the sensor. */
#include <string.h>

#include "devices/optoncdt2300/instance.h"
#include "seams/random.h"
#include "seams/wave.h"

#define NM_IN_A_MM 1e6
#define FARTHEST   2147.0 /* mm: the limit of the value (§9.2) */
#define BRIGHTEST  1023.0

void opto_default_plant(opto_plant_t *p)
{
    *p = (opto_plant_t){.known = true,
                        .range = 20,
                        .exposure = 50,
                        .temperature = 25,
                        .laser = 1,
                        .seed = 1,
                        .random = 1,
                        .row_time_us = 1000,
                        .row = {.present = 1},
                        .password = "000"};
    for (unsigned int n = 0; n < OPTO_SURFACES; n++)
        p->surface[n] = (opto_surface_t){
            .present = n == 0, .distance = n == 0 ? 10 : 12, .amplitude = 1, .period_us = 1000000, .intensity = 50};
}

/* Phase of a ramp or a sine: 0 to 1. */
static double phase(const opto_surface_t *s, uint64_t at_ns)
{
    uint64_t period_ns = s->period_us * 1000ull;
    uint64_t since_ns = at_ns > s->origin_ns ? at_ns - s->origin_ns : 0;
    return (double)(since_ns % period_ns) / (double)period_ns;
}

/* @return the row of the table in front of the sensor; NULL: the table is empty */
static const opto_row_t *row_at(const opto_plant_t *p, const opto_surface_t *s, uint64_t at_ns)
{
    uint64_t since_ns = at_ns > s->origin_ns ? at_ns - s->origin_ns : 0;
    return p->rows > 0 ? &p->table[since_ns / (p->row_time_us * 1000ull) % p->rows] : NULL;
}

/* Computes the distance of a surface in mm. @return false: no surface */
static bool position(const opto_plant_t *p, unsigned int n, uint64_t at_ns, double *mm)
{
    const opto_surface_t *s = &p->surface[n];
    const opto_row_t *row = s->source == OPTO_SOURCE_TABLE ? row_at(p, s, at_ns) : NULL;
    *mm = s->distance;
    if (s->source == OPTO_SOURCE_RAMP)
        *mm += s->amplitude * phase(s, at_ns);
    if (s->source == OPTO_SOURCE_SINE)
        *mm += s->amplitude * ect_wave_sine(phase(s, at_ns));
    if (row)
        *mm = row->distance[n];
    return s->present && (!row || row->present);
}

static int32_t nanometres(double mm)
{
    double nm = mm * NM_IN_A_MM;
    return (int32_t)(nm < 0 ? nm - 0.5 : nm + 0.5);
}

/* @return a value, or the error in its place */
static int32_t evaluate(const opto_t *u, const opto_surface_t *s, double mm)
{
    if (s->fault != 0)
        return (int32_t)(0x7FFFFFF0 | s->fault);
    if (mm < 0)
        return OPTO_BEFORE_RANGE;
    if (mm > u->plant.range || mm > FARTHEST)
        return OPTO_BEHIND_RANGE;
    return nanometres(mm);
}

/* Draws noise also without a target, so that the values of a seed do not depend on hidden surfaces. */
opto_peak_t opto_find_peak(opto_t *u, unsigned int n, uint64_t at_ns)
{
    const opto_surface_t *s = &u->plant.surface[n];
    double mm;
    double noise = s->noise > 0 ? s->noise * ect_random_normal(&u->plant.random) : 0;
    bool lit = u->plant.laser && u->laser_power != OPTO_NO_POWER;
    double percent = u->laser_power == OPTO_REDUCED_POWER ? s->intensity / 2 : s->intensity;
    int32_t intensity = (int32_t)(percent * BRIGHTEST / 100 + 0.5);
    if (!lit)
        return (opto_peak_t){.distance = OPTO_LASER_OFF};
    if (!position(&u->plant, n, at_ns, &mm) || intensity == 0)
        return (opto_peak_t){.distance = OPTO_NO_PEAK};
    return (opto_peak_t){.distance = evaluate(u, s, mm + noise), .intensity = intensity};
}
