/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Command-line options for the hardware of twins: chips, oscillators, cables, junctions, times of the microcontroller.
 */
#ifndef ECTWIN_WIRING_ARGS_H
#define ECTWIN_WIRING_ARGS_H

#include <argp.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"

/** "[N:]VALUE" of such an option. */
typedef struct wiring_setting {
    int key;          /**< of the option */
    const char *text; /**< the value; before ::wiring_args_apply with the prefix "N:" */
    size_t twin;      /**< from 1; 0: all */
} wiring_setting_t;

typedef struct wiring_args {
    wiring_setting_t *settings;
    size_t count;
    const ect_names_t *names; /**< of the twins, NULL: none */
    ect_device_t **fitted;    /**< descriptions of twins on a board, for --like; in use as long as the twins */
    size_t fitted_count;
} wiring_args_t;

/** Argp parser for the options of hardware; its input is a wiring_args_t. */
extern const struct argp wiring_argp;

/**
 * Applies the options to the twins. An impossible value ends the program with a line that gives the reason.
 * @param seed  of the random generators for drifts, delays and jitter
 */
void wiring_args_apply(wiring_args_t *args, const struct argp_state *parser, ect_twin_config_t *twins, size_t count,
                       uint32_t seed);

void wiring_args_free(wiring_args_t *args);

#endif
