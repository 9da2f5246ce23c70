/* SPDX-License-Identifier: MIT */
/** @file A motion controller for the PMCtendo DD5 at position 0 of a ::wire_t, in virtual time: cycles of 1 ms. */
#ifndef TESTS_SUPPORT_DRIVE_H
#define TESTS_SUPPORT_DRIVE_H

#include "devices/pmctendo/instance.h"
#include "support/signals.h"
#include "support/wire.h"

/* Offsets of values in a PDO; NOWHERE: not in this one. */
enum { DRIVE_NOWHERE = 0xFF };
typedef struct drive_out {
    uint16_t pdo;
    uint8_t bytes, control, set, latch_control, torque_ahead, outputs, max_torque;
} drive_out_t;
typedef struct drive_in {
    uint16_t pdo;
    uint8_t bytes, status, position, latch_status, latch1, latch2, torque, following_error, inputs;
} drive_in_t;

typedef struct drive {
    wire_t w;
    drive_out_t to;
    drive_in_t from;
    uint64_t cycle_ns;
    uint32_t dc_ns; /* SYNC0, 0: none */
    uint8_t out[14];
    uint8_t in[32];
} drive_t;

/* Into PREOP. */
void drive_open(drive_t *d);
void drive_open_with(drive_t *d, const ect_storage_t *storage);
void drive_close(drive_t *d);
/* From PREOP: chooses the PDOs, goes to SAFEOP, or to OP with outputs all 0. Process data are laid out as in the PDOs.
 */
void drive_safeop(drive_t *d, uint16_t out, uint16_t in);
void drive_operational(drive_t *d, uint16_t out, uint16_t in);
pmctendo_t *drive_instance(drive_t *d);

/* Outputs written, a cycle passes, inputs read. */
void drive_cycle(drive_t *d);
void drive_cycles(drive_t *d, unsigned int count);
/* Inputs read, no time passes. @return the status word */
uint16_t drive_status(drive_t *d);

void drive_control(drive_t *d, uint16_t control);
uint16_t drive_controlled(const drive_t *d);
/* The set value of the PDO: position, speed or torque. */
void drive_set(drive_t *d, int32_t value);
void drive_latch(drive_t *d, uint16_t control);
int32_t drive_position(const drive_t *d);
uint16_t drive_latch_status(const drive_t *d);
int32_t drive_latched(const drive_t *d, unsigned int n); /* 1, 2 */

/* Cycles until the status word has `want` in `mask`; fails after `limit_ms`. @return milliseconds */
unsigned int drive_until(drive_t *d, uint16_t mask, uint16_t want, unsigned int limit_ms);
/* The whole sequence to Operation Enabled, at a standstill; position set values begin at the shaft. */
void drive_enable(drive_t *d);
/* Asserts the state of the state machine, as the status word codes it. */
void drive_expect(drive_t *d, ect_402_state_t state, const char *when);

uint32_t drive_write(drive_t *d, uint16_t index, uint8_t subindex, uint32_t value, size_t size);
uint32_t drive_read(drive_t *d, uint16_t index, uint8_t subindex);

#endif
