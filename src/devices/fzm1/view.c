/* SPDX-License-Identifier: MIT */
/* What the cameras see: our model of it, and how a scene is from the factory. */
#include <string.h>

#include "devices/fzm1/instance.h"

static const fzm1_scene_t default_scene = {
    .judgement = {1, 1, 1, 1, 1, 1, 1, 1}, .units = 4, .output_unit = 3, .format = FZM1_FIXED_POINT};

void fzm1_default_scenes(fzm1_scene_t *scenes)
{
    for (unsigned int i = 0; i < FZM1_SCENES; i++)
        scenes[i] = default_scene;
}

/* sin(2 pi x) for 0 <= x < 1, by its series around 0 (error below 1e-9): there is no libm on a bare board. */
static double sine(double x)
{
    double sign = x >= 0.5 ? -1.0 : 1.0;
    x -= x >= 0.5 ? 0.5 : 0.0;
    x = x > 0.25 ? 0.5 - x : x;
    double angle = 6.283185307179586 * x;
    double term = angle, sum = angle;
    for (unsigned int n = 1; n <= 7; n++) {
        term *= -angle * angle / (double)(2 * n * (2 * n + 1));
        sum += term;
    }
    return sign * sum;
}

/* -1 .. 1, the same ones for the same seed (xorshift). */
static double random_step(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return (double)*state / 2147483648.0 - 1.0;
}

static double value(fzm1_t *u, unsigned int n, const fzm1_row_t *row)
{
    fzm1_plant_t *p = &u->plant;
    double phase = (double)(p->shots % p->period[n]) / (double)p->period[n];
    switch (p->source[n]) {
    case FZM1_SOURCE_RAMP:
        return u->scene.data[n] + p->amplitude[n] * phase;
    case FZM1_SOURCE_SINE:
        return u->scene.data[n] + p->amplitude[n] * sine(phase);
    case FZM1_SOURCE_RANDOM:
        return u->scene.data[n] + p->amplitude[n] * random_step(&p->random);
    case FZM1_SOURCE_TABLE:
        return row ? row->data[n] : 0;
    default:
        return u->scene.data[n];
    }
}

static int16_t overall(const fzm1_t *u, const fzm1_row_t *row)
{
    if (u->plant.judgement != 0)
        return u->plant.judgement;
    if (row && row->judgement != 0)
        return row->judgement;
    for (unsigned int i = 0; i < u->scene.units; i++) {
        if (u->scene.judgement[i] < 0)
            return -1;
    }
    return 1;
}

static bool uses_table(const fzm1_plant_t *p)
{
    return p->rows > 0 && memchr(p->source, FZM1_SOURCE_TABLE, sizeof p->source) != NULL;
}

/* What an image shows is settled when it is taken, not when it is measured. */
void fzm1_take_image(fzm1_t *u, fzm1_result_t *image)
{
    const fzm1_row_t *row = uses_table(&u->plant) ? &u->plant.table[u->plant.shots % u->plant.rows] : NULL;
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        image->data[n] = value(u, n, row);
    memcpy(image->judgement, u->scene.judgement, sizeof image->judgement);
    image->overall = overall(u, row);
    image->judgement[u->scene.output_unit] = image->overall;
    u->plant.shots++;
}
