/* SPDX-License-Identifier: MIT */
#ifndef ECTWIN_BOARD_ARGUMENTS_H
#define ECTWIN_BOARD_ARGUMENTS_H

#include <stdbool.h>
#include <stdint.h>

#include "bus/chain/catalogue.h"

typedef struct arguments {
    const char *spi;
    uint32_t speed_hz;
    const char *interrupt, *reset, *run_led, *err_led; /* GPIO lines; NULL: not wired */
    bool interrupt_high;
    uint32_t poll_us;
    const char *store;  /* a folder; NULL: until the end */
    const char *eeprom; /* write the EEPROM's image here, and nothing else; NULL: no */
    uint16_t alias;
    uint32_t serial; /* 0: the description's */
    const ect_product_t *product;
} arguments_t;

/** The command line. A wrong one ends the process with one line on standard error, and status 1. */
arguments_t read_arguments(int argc, char **argv);

#endif
