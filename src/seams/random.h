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

#endif
