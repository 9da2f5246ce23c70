/* SPDX-License-Identifier: MIT */
/** @file A master in front of an optoNCDT 2300 at position 0 of a ::wire_t, in virtual time. */
#ifndef TESTS_SUPPORT_RANGER_H
#define TESTS_SUPPORT_RANGER_H

#include "devices/optoncdt2300/instance.h"
#include "support/signals.h"
#include "support/wire.h"

enum { RANGER_INPUTS = 0x1400, RANGER_ROOM = OPTO_LONGEST };

typedef struct ranger {
    wire_t w;
    uint16_t bytes; /* of the process data, as configured last */
    uint8_t in[RANGER_ROOM];
} ranger_t;

/* In INIT, just switched on. */
void ranger_open(ranger_t *r);
void ranger_close(ranger_t *r);
opto_t *ranger_instance(ranger_t *r);

/* SDOs of numbers. @return 0 or the abort code */
uint32_t ranger_upload(ranger_t *r, uint16_t index, uint8_t subindex, uint32_t *value);
uint32_t ranger_download(ranger_t *r, uint16_t index, uint8_t subindex, uint32_t value, size_t size);
/* The same; each asserts success. */
uint32_t ranger_number(ranger_t *r, uint16_t index, uint8_t subindex);
void ranger_write(ranger_t *r, uint16_t index, uint8_t subindex, uint32_t value, size_t size);
uint32_t ranger_text(ranger_t *r, uint16_t index, uint8_t subindex, const char *text);

/* Enters PREOP and logs the expert in. */
void ranger_expert(ranger_t *r);
/* In PREOP: selects the measurements of the mask (bit 0: the first one of 1A00h), `samples` records in an exchange. */
void ranger_select(ranger_t *r, uint32_t measurements, unsigned int samples);
/* Enters SAFEOP or OP, with the length of SM3 that follows from the mapping. */
void ranger_go(ranger_t *r, uint8_t state);
/* In PREOP: SYNC0 starts in 10 ms. */
void ranger_sync0(ranger_t *r, uint32_t cycle_ns);

/* Lets time pass, then reads the inputs. */
void ranger_wait(ranger_t *r, uint64_t ns);
/* Value n, from 0, of the inputs read last. */
int32_t ranger_value(const ranger_t *r, unsigned int n);

#endif
