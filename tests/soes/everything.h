/* SPDX-License-Identifier: MIT */
/** @file A SOES application with sparse records, process data out of them, octets and texts: its memory. */
#ifndef TESTS_SOES_EVERYTHING_H
#define TESTS_SOES_EVERYTHING_H

#include "ecat_slv.h"

typedef struct {
    uint8_t first;
    uint16_t fifth;
    uint32_t twelfth; /* counts calls of cb_get_inputs */
    uint8_t ninth;
    uint16_t third;
    uint32_t twentieth;
    uint8_t octets[8];
    char text[9];
    uint8_t measured[16];
    unsigned int outputs; /* calls of cb_set_outputs */
} everything_t;

extern everything_t everything;

#endif
