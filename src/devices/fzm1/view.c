/* SPDX-License-Identifier: MIT */
/* What the cameras see, and how long they take: our model of it. */
#include <string.h>

#include "devices/fzm1/instance.h"
#include "seams/random.h"

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

/* -1 .. 1, the same ones for the same seed. */
static double random_step(uint32_t *state)
{
    return (double)ect_random_next(state) / 2147483648.0 - 1.0;
}

/* Normal, with mean 0 and standard deviation 1: the sum of twelve, which goes no further than 6 (and needs no libm). */
static double normal_step(uint32_t *state)
{
    double sum = 0;
    for (unsigned int i = 0; i < 12; i++)
        sum += random_step(state);
    return sum / 2;
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

/* The row of the table that belongs to the next image, or NULL. */
static const fzm1_row_t *next_row(const fzm1_plant_t *p)
{
    bool used = memchr(p->source, FZM1_SOURCE_TABLE, sizeof p->source) || p->time_source == FZM1_SOURCE_TABLE;
    return used && p->rows > 0 ? &p->table[p->shots % p->rows] : NULL;
}

/* `row`: what the table says, 0: nothing. */
static uint32_t time_us(fzm1_plant_t *p, uint32_t set, uint32_t spread, uint32_t row)
{
    if (p->time_source == FZM1_SOURCE_TABLE)
        return row != 0 ? row : set;
    if (p->time_source != FZM1_SOURCE_RANDOM)
        return set;
    double us = (double)set + (double)spread * normal_step(&p->time_random);
    if (us < (double)FZM1_SHORTEST_US)
        return FZM1_SHORTEST_US;
    return us > (double)FZM1_MINUTE_US ? FZM1_MINUTE_US : (uint32_t)us;
}

uint64_t fzm1_image_input_ns(fzm1_t *u)
{
    fzm1_plant_t *p = &u->plant;
    const fzm1_row_t *row = next_row(p);
    return time_us(p, p->image_input_us, p->image_input_spread_us, row ? row->image_input_us : 0) * 1000ull;
}

uint64_t fzm1_processing_ns(fzm1_t *u, const fzm1_result_t *image)
{
    fzm1_plant_t *p = &u->plant;
    return time_us(p, p->processing_us, p->processing_spread_us, image->row_processing_us) * 1000ull;
}

/* A judgement of all, by hand or by the table, is that of each unit. */
static void judge(const fzm1_t *u, const fzm1_row_t *row, fzm1_result_t *result)
{
    int16_t all = u->plant.judgement != 0 ? u->plant.judgement : row ? row->judgement : 0;
    result->overall = 1;
    for (unsigned int i = 0; i < u->scene.units; i++) {
        result->judgement[i] = all != 0 ? all : u->scene.judgement[i];
        result->overall = result->judgement[i] < 0 ? -1 : result->overall;
    }
}

/* Within the limits of the FZ family's values (OM-C6); what is no number is 0. */
static double limited(double value)
{
    if (value > FZM1_LARGEST)
        return FZM1_LARGEST;
    if (value < -FZM1_LARGEST)
        return -FZM1_LARGEST;
    return value == value ? value : 0;
}

static void output_data(const fzm1_scene_t *scene, const fzm1_result_t *measured, double *data)
{
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        double of = measured->data[n];
        if (scene->expression[n][0])
            (void)fzm1_expression(scene->expression[n], measured, &of);
        data[n] = limited(of);
    }
}

/* What an image shows is settled when it is taken, not when it is measured. */
void fzm1_take_image(fzm1_t *u, fzm1_result_t *image)
{
    fzm1_plant_t *p = &u->plant;
    const fzm1_row_t *row = next_row(p);
    fzm1_result_t measured = {0};
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        measured.data[n] = value(u, n, row);
    judge(u, row, &measured);
    *image = measured;
    output_data(&u->scene, &measured, image->data);
    image->row_processing_us = row ? row->processing_us : 0;
    p->shots++;
}
