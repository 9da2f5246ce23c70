/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One controller of any kind for tests, in virtual time: frames from the bus, accesses from its microcontroller.
 */
#ifndef TESTS_SUPPORT_CHIP_H
#define TESTS_SUPPORT_CHIP_H

#include "esc/esc.h"
#include "support/wire.h"

enum { CHIP_MEMORY = 0x1000 + 60 * 1024, CHIP_SII = 64 };

typedef struct chip {
    ect_esc_personality_t personality; /* of the requested name; may be changed before chip_power_on */
    uint8_t memory[CHIP_MEMORY];
    uint8_t sii[CHIP_SII]; /* its check sum is disabled */
    ect_esc_config_t config;
    ect_esc_t esc;
    wire_t w; /* the last frame */
} chip_t;

/* Powered on at 5 s, with links at ports 0 and 1. */
chip_t *chip_new(const char *name);
void chip_power_on(chip_t *c);
/* Fixtures of a test: et1100. */
int chip_setup(void **state);
int chip_teardown(void **state);

/* Sends one datagram to position 0; the chip changes `data`. @return working counter */
unsigned int chip_send(chip_t *c, uint8_t command, uint16_t ado, void *data, uint16_t length);
/* Sends the frame that was built in c->w, with any number of datagrams. */
void chip_transmit(chip_t *c);
/* A number, little-endian. @return working counter */
unsigned int chip_write(chip_t *c, uint16_t ado, uint64_t value, uint16_t length);
uint64_t chip_read(chip_t *c, uint16_t ado, uint16_t length);
void chip_pdi_write(chip_t *c, uint16_t address, uint64_t value, uint16_t length);
uint64_t chip_pdi_read(chip_t *c, uint16_t address, uint16_t length);
/* Lets time pass, with a tick at each time that the chip requests. */
void chip_advance(chip_t *c, uint64_t ns);
/* Configures a SyncManager and enables it. */
void chip_set_sm(chip_t *c, unsigned int n, uint16_t start, uint16_t length, uint8_t control, uint8_t activate);

#endif
