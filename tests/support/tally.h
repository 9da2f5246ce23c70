/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A device made for tests whose images are consistent in themselves: all words of an image are equal. A master sends
 * 0, then 1, 2, 3, … The inputs repeat the newest outputs, until outputs are torn or one of the sequence is missing:
 * from then on all input words are TALLY_BROKEN.
 *
 *   SM0  TALLY_WORDS outputs, UNSIGNED32 (1600h)
 *   SM1  TALLY_WORDS inputs, UNSIGNED32 (1A00h)
 */
#ifndef TESTS_SUPPORT_TALLY_H
#define TESTS_SUPPORT_TALLY_H

#include "seams/standard.h"

enum { TALLY_WORDS = 32 };

#define TALLY_BROKEN 0xFFFFFFFFu

typedef struct tally {
    ect_standard_t standard;
    uint32_t out[TALLY_WORDS];
    uint32_t in[TALLY_WORDS];
} tally_t;

extern const ect_device_t tally;

#endif
