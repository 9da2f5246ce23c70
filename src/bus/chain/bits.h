/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Sets of small numbers, one bit each: number i is bit i % 64 of word i / 64.
 */
#ifndef ECT_BUS_CHAIN_BITS_H
#define ECT_BUS_CHAIN_BITS_H

#include <stddef.h>
#include <stdint.h>

#include "wire/assert.h"

enum { ECT_BITS_WORD = 64 };

/** Words of a set of the numbers below `count`. */
static inline size_t ect_bits_words(size_t count)
{
    return (count + ECT_BITS_WORD - 1) / ECT_BITS_WORD;
}

static inline void ect_bits_add(uint64_t *bits, size_t i)
{
    bits[i / ECT_BITS_WORD] |= 1ull << (i % ECT_BITS_WORD);
}

/** Removes the lowest number from a word. @param word  its index. @param[in,out] left  its value, not 0 */
static inline size_t ect_bits_take(size_t word, uint64_t *left)
{
    ECT_ASSERT(*left != 0);
    size_t i = word * ECT_BITS_WORD + (unsigned int)__builtin_ctzll(*left);
    *left &= *left - 1;
    return i;
}

#endif
