/* SPDX-License-Identifier: MIT */
/** @file Numbers at random that are the same ones for the same seed (xorshift32). For models, not for secrets. */
#ifndef ECT_SEAMS_RANDOM_H
#define ECT_SEAMS_RANDOM_H

#include <stdint.h>

/** The next number, 1 to 2^32 - 1. @param state  the seed, then the number before; 0 counts as 1 */
static inline uint32_t ect_random_next(uint32_t *state)
{
    uint32_t x = *state != 0 ? *state : 1;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    *state = x;
    return x;
}

/** The next one of an even distribution from -1 to 1. @param state  as above */
static inline double ect_random_even(uint32_t *state)
{
    return (double)ect_random_next(state) / 2147483648.0 - 1.0;
}

/**
 * The next one of a normal distribution, mean 0, standard deviation 1: the sum of twelve, which goes no further than -6
 * and 6, and needs no libm. @param state  as above
 */
static inline double ect_random_normal(uint32_t *state)
{
    double sum = 0;
    for (unsigned int i = 0; i < 12; i++)
        sum += ect_random_even(state);
    return sum / 2;
}

#endif
