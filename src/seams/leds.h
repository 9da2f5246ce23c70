/* SPDX-License-Identifier: MIT */
/**
 * @file
 * LEDs of a board: the pins of its RUN and ERR indicators. ::ect_indicator_drive (slave/indicator.h) sets them; the ESC
 * or its PHYs drive Link/Activity.
 */
#ifndef ECT_SEAMS_LEDS_H
#define ECT_SEAMS_LEDS_H

#include <stdbool.h>

/** The pins. Either function may be NULL: the board has no such LED, or the chip drives it. */
typedef struct ect_leds {
    void *ctx; /**< passed to each function; owned by the board */
    void (*run)(void *ctx, bool lit);
    void (*err)(void *ctx, bool lit);
} ect_leds_t;

#endif
