/* SPDX-License-Identifier: MIT */
/**
 * @file The functions that main.c needs from the board, to be written for yours: a clock, the window of the ESC, a
 * sensor, an output.
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "ports/template/template.h"

extern const ect_window_t board_window;

/** @return nanoseconds since power-on; never decreases. */
uint64_t board_now_ns(void);

/** 0.1 °C */
int16_t board_temperature(void);

/** @param percent  0..100 */
void board_heat(uint8_t percent);

/** Serves the board's own watchdog; called in each iteration of the main loop. */
void board_alive(void);

/** Resets the processor. */
void board_reset(void);

#endif
