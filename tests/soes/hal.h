/* SPDX-License-Identifier: MIT */
/** @file A hardware file of SOES for tests: a software ESC, some registers of which can be taken over. */
#ifndef TESTS_SOES_HAL_H
#define TESTS_SOES_HAL_H

#include "esc.h"
#include "esc/esc.h"

typedef struct {
    ect_esc_t *esc;
    const void *user_arg; /* as ESC_init was given it */
    unsigned int resets;
    unsigned int loading; /* reads of DL status until the EEPROM is loaded */
    /* An EEPROM that is emulated: 0x0502..0x050F are these. */
    bool emulated;
    uint8_t control[6], data[8];
    unsigned int acknowledged;
    /* The last access. */
    uint16_t address, length;
    bool written;
} hal_t;

extern hal_t hal;

#endif
