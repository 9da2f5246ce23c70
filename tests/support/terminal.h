/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A simple digital terminal made for tests: no mailbox, and SyncManagers in roles of its own.
 *
 *   SM0  8 digital outputs, one bit each (1600h)
 *   SM1  8 digital inputs, one bit each (1A00h): the outputs as they were received
 *   SM2  number of receptions of outputs, 16 bits (1A01h)
 */
#ifndef TESTS_SUPPORT_TERMINAL_H
#define TESTS_SUPPORT_TERMINAL_H

#include "seams/standard.h"

typedef struct terminal {
    ect_standard_t standard;
    uint8_t out[8];
    uint8_t in[8];
    uint16_t count;
    bool safe;
} terminal_t;

extern const ect_device_t terminal;

#endif
