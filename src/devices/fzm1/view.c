/* SPDX-License-Identifier: MIT */
/* The model of the cameras: measured values, judgements, times. */
#include <string.h>

#include "devices/fzm1/instance.h"
#include "seams/random.h"
#include "seams/wave.h"

static double value(fzm1_t *u, unsigned int n, const fzm1_row_t *row)
{
    fzm1_plant_t *p = &u->plant;
    double phase = (double)(p->shots % p->period[n]) / (double)p->period[n];
    switch (p->source[n]) {
    case FZM1_SOURCE_RAMP:
        return u->scene.data[n] + p->amplitude[n] * phase;
    case FZM1_SOURCE_SINE:
        return u->scene.data[n] + p->amplitude[n] * ect_wave_sine(phase);
    case FZM1_SOURCE_RANDOM:
        return u->scene.data[n] + p->amplitude[n] * ect_random_even(&p->random);
    case FZM1_SOURCE_TABLE:
        return row ? row->data[n] : p->rows > 0 ? u->scene.data[n] : 0;
    default:
        return u->scene.data[n];
    }
}

static uint16_t count_rows(const fzm1_plant_t *p, int16_t scene)
{
    uint16_t count = 0;
    for (uint16_t i = 0; i < p->rows; i++)
        count = (uint16_t)(count + (p->table[i].scene == scene));
    return count;
}

/* @return the number of used rows of a scene */
static uint16_t *turn_of(fzm1_plant_t *p, int16_t scene)
{
    return &p->turns[scene < 0 ? FZM1_TURNS - 1 : (unsigned int)scene % FZM1_TURNS];
}

/* @return the row of the table for the next image: of the current scene, else of any scene; NULL: none */
static const fzm1_row_t *next_row(fzm1_t *u)
{
    fzm1_plant_t *p = &u->plant;
    if (!memchr(p->source, FZM1_SOURCE_TABLE, sizeof p->source) && p->time_source != FZM1_SOURCE_TABLE)
        return NULL;
    int16_t scene = u->scene_number;
    uint16_t count = count_rows(p, scene);
    if (count == 0) {
        scene = -1;
        count = count_rows(p, scene);
    }
    unsigned int left = *turn_of(p, scene);
    left = count > 0 ? left % count : 0;
    for (uint16_t i = 0; i < p->rows; i++) {
        if (p->table[i].scene == scene && left-- == 0)
            return &p->table[i];
    }
    return NULL;
}

/* Marks the row as used; the next image gets the next row. */
static void use_row(fzm1_plant_t *p, const fzm1_row_t *row)
{
    uint16_t *turn = turn_of(p, row->scene);
    *turn = (uint16_t)((*turn + 1) % count_rows(p, row->scene));
}

/* @param row  value of the table; 0: none */
static uint32_t time_us(fzm1_plant_t *p, uint32_t set, uint32_t spread, uint32_t row)
{
    if (p->time_source == FZM1_SOURCE_TABLE)
        return row != 0 ? row : set;
    if (p->time_source != FZM1_SOURCE_RANDOM)
        return set;
    double us = (double)set + (double)spread * ect_random_normal(&p->time_random);
    if (us < (double)FZM1_SHORTEST_US)
        return FZM1_SHORTEST_US;
    return us > (double)FZM1_MINUTE_US ? FZM1_MINUTE_US : (uint32_t)us;
}

uint64_t fzm1_image_input_ns(fzm1_t *u)
{
    fzm1_plant_t *p = &u->plant;
    const fzm1_row_t *row = next_row(u);
    return time_us(p, p->image_input_us, p->image_input_spread_us, row ? row->image_input_us : 0) * 1000ull;
}

uint64_t fzm1_processing_ns(fzm1_t *u, const fzm1_result_t *image)
{
    fzm1_plant_t *p = &u->plant;
    return time_us(p, p->processing_us, p->processing_spread_us, image->row_processing_us) * 1000ull;
}

/* Applies a judgement set manually or by the table to each unit. */
static void judge(const fzm1_t *u, const fzm1_row_t *row, fzm1_result_t *result)
{
    int16_t all = u->plant.judgement != 0 ? u->plant.judgement : row ? row->judgement : 0;
    result->overall = 1;
    for (unsigned int i = 0; i < u->scene.units; i++) {
        result->judgement[i] = all != 0 ? all : u->scene.judgement[i];
        result->overall = result->judgement[i] < 0 ? -1 : result->overall;
    }
}

/* Limits a value to the range of the FZ family (OM-C6); NaN is 0. */
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

/* Determines the content of an image at its input, not at its measurement. */
void fzm1_take_image(fzm1_t *u, fzm1_result_t *image)
{
    fzm1_plant_t *p = &u->plant;
    const fzm1_row_t *row = next_row(u);
    fzm1_result_t measured = {0};
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        measured.data[n] = value(u, n, row);
    judge(u, row, &measured);
    *image = measured;
    output_data(&u->scene, &measured, image->data);
    image->row_processing_us = row ? row->processing_us : 0;
    if (row)
        use_row(p, row);
    p->shots++;
}
