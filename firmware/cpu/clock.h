/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The arithmetic of a clock over a processor's counters. Pure functions. Context: any.
 */
#ifndef FIRMWARE_CLOCK_H
#define FIRMWARE_CLOCK_H

#include <stdint.h>

/**
 * Converts cycles to nanoseconds, in fixed point of 32.32 bits: the rate is within 10^-9 of the clock's, at any
 * frequency.
 * @param hz  of the clock, 1 or more; a constant, so that the compiler removes the division
 */
static inline uint64_t clock_ns(uint64_t cycles, uint32_t hz)
{
    const uint32_t ns_per_s = 1000000000;
    uint64_t whole = ns_per_s / hz;
    uint64_t fraction = ((uint64_t)(ns_per_s % hz) << 32) / hz;
    uint64_t high = cycles >> 32, low = cycles & UINT32_MAX;
    return cycles * whole + high * fraction + (low * fraction >> 32);
}

/**
 * Computes the cycles between two reads of a counter of 24 bits that counts down, like SysTick. The counter wraps
 * undetected while flash is erased and the processor stops; a second counter of 32 bits gives the number of wraps, and
 * may itself stop while the processor sleeps.
 * @param before, now  of the first counter, 0..0xFFFFFF
 * @param counted      cycles counted by the second counter between the reads; 0: no second counter, and the first one
 * wraps at most once
 */
static inline uint32_t clock_elapsed(uint32_t before, uint32_t now, uint32_t counted)
{
    const uint32_t wrap = 1u << 24;
    uint32_t elapsed = (before - now) & (wrap - 1);
    uint32_t missed = counted > elapsed ? counted - elapsed + wrap / 2 : 0;
    return elapsed + (missed & ~(wrap - 1)); /* the nearest integer: the counters are not read at the same time */
}

#endif
