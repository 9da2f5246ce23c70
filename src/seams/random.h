/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Random numbers that repeat for the same seed (xorshift32). For models, not for secrets.
 */
#ifndef ECT_SEAMS_RANDOM_H
#define ECT_SEAMS_RANDOM_H

#include <stdint.h>

/** @return the next number, 1 to 2^32 - 1. @param[in,out] state  the seed, later the previous number; 0 counts as 1 */
static inline uint32_t ect_random_next(uint32_t *state)
{
    uint32_t x = *state != 0 ? *state : 1;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    *state = x;
    return x;
}

/** @return the next number of a uniform distribution from -1 to 1. @param[in,out] state  as for ::ect_random_next */
static inline double ect_random_even(uint32_t *state)
{
    return (double)ect_random_next(state) / 2147483648.0 - 1.0;
}

/**
 * @return the next number of a normal distribution with mean 0 and standard deviation 1: the sum of twelve uniform
 * numbers, which is within -6 and 6 and needs no libm. @param[in,out] state as for ::ect_random_next
 */
static inline double ect_random_normal(uint32_t *state)
{
    double sum = 0;
    for (unsigned int i = 0; i < 12; i++)
        sum += ect_random_even(state);
    return sum / 2;
}

#endif
