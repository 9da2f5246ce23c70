/* SPDX-License-Identifier: MIT */
/**
 * @file
 * LEDs of a board: the pins of its RUN and ERR lamps. What they show is ::ect_indicator_drive's work
 * (slave/indicator.h); Link/Activity is lit by the ESC or its PHYs.
 */
#ifndef ECT_SEAMS_LEDS_H
#define ECT_SEAMS_LEDS_H

#include <stdbool.h>

/** Two functions, either of which may be NULL: there is no such lamp, or the chip lights it by itself. */
typedef struct ect_leds {
    void *ctx; /**< handed to each function; owned by the board */
    void (*run)(void *ctx, bool lit);
    void (*err)(void *ctx, bool lit);
} ect_leds_t;

#endif
