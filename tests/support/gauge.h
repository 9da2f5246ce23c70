/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A sensor without outputs made for tests: SM2 is unused, and 21B0h selects the values that it sends.
 *
 *   21B0h:1..4  rw in PREOP: whether value 1..4 is sent; 1 and 2 by default
 *   6000h:1..4  the values, INTEGER32
 *   1A00h       the mapping that follows from the selection, read only to a master
 */
#ifndef TESTS_SUPPORT_GAUGE_H
#define TESTS_SUPPORT_GAUGE_H

#include "seams/standard.h"

enum { GAUGE_VALUES = 4 };

typedef struct gauge {
    ect_standard_t standard;
    uint8_t chosen[GAUGE_VALUES];
    int32_t value[GAUGE_VALUES];
    uint8_t mapped_count;
    uint32_t mapped[GAUGE_VALUES];
} gauge_t;

extern const ect_device_t gauge;

#endif
