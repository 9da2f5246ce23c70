/* SPDX-License-Identifier: MIT */
/** @file A SOES application for tests: its objects and what happens to it. */
#ifndef TESTS_SOES_APP_H
#define TESTS_SOES_APP_H

#include "ecat_slv.h"

typedef struct {
    uint8_t count_1601;
    uint32_t mapped_1601[3];
    uint8_t count_1c12;
    uint16_t assigned_1c12[2];
    uint8_t buttons[2];
    uint16_t position;
    uint8_t lamps[2];
    uint16_t speed;
    uint32_t gain;
    int16_t offset;
    char label[200];
    uint8_t bits[2];
} app_t;

extern app_t app;
extern unsigned int app_outputs, app_inputs; /* calls of cb_set_outputs, cb_get_inputs */

#ifdef APP_RAW
extern uint8_t rxpdo[];
extern uint8_t txpdo[];
#endif

#endif
