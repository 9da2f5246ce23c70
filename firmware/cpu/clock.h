/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The arithmetic of a clock that is made of a processor's counters. Pure functions, for any context.
 */
#ifndef FIRMWARE_CLOCK_H
#define FIRMWARE_CLOCK_H

#include <stdint.h>

/**
 * Cycles as nanoseconds, in fixed point of 32.32 bits: the rate is within 10^-9 of the clock's, whatever its frequency.
 * @param hz  of the clock, 1 or more; a constant, so that no division is left
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
 * Cycles between two reads of a counter of 24 bits that counts down, as SysTick. It wraps unseen while flash is erased
 * and the processor stops; a second counter of 32 bits shows how often, and may itself stop while the processor sleeps.
 * @param before, now  of the first counter, 0..0xFFFFFF
 * @param counted      cycles that the second one has counted meanwhile; 0: there is none, and the first one wraps at
 * most once
 */
static inline uint32_t clock_elapsed(uint32_t before, uint32_t now, uint32_t counted)
{
    const uint32_t wrap = 1u << 24;
    uint32_t elapsed = (before - now) & (wrap - 1);
    uint32_t missed = counted > elapsed ? counted - elapsed + wrap / 2 : 0;
    return elapsed +
           (missed & ~(wrap - 1)); /* the two are not read at the same instant: the nearest whole number of wraps */
}

#endif
