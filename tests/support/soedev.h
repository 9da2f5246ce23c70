/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A device made for tests: three SoE drives, no CoE. Drives 0 and 1 have process data, drive 2 has none.
 *
 *   MDT 1600h, 1601h: control word 7000h:1, 7010h:1, then S-0-0024, default {36, 47}: 10 bytes each
 *   AT  1A00h, 1A01h: status word 6000h:1, 6010h:1, then S-0-0016, default {40, 51}: 10 bytes each
 * Mailboxes 1800h/128 and 1A00h/128 (24..128), SM2 1000h/20 (at most 64 bytes), SM3 1100h/20 (at most 64 bytes).
 * Outputs are copied to inputs: velocity 36 to 40, position 47 to 51. The IDNs: soedev.c.
 */
#ifndef TESTS_SUPPORT_SOEDEV_H
#define TESTS_SUPPORT_SOEDEV_H

#include "seams/soe.h"
#include "seams/standard.h"

enum {
    SOEDEV_DRIVES = 3,
    SOEDEV_MAILBOX = 128,
    SOEDEV_MAPPED = 13, /* elements of a mapping, with the word */
    SOEDEV_CHOICE = 24, /* capacity of S-0-0016 and S-0-0024, bytes */
    SOEDEV_LONG = 296,  /* capacity of S-0-0016 of drive 2 */
    SOEDEV_TEXT = 300,  /* length of P-0-0010 */
    SOEDEV_BUFFER = 512,
};

typedef struct soedev_drive {
    uint16_t cycle_us, telegram, mode, control, status;
    int32_t velocity_set, position_set, velocity, position;
    int16_t torque;
    uint16_t limit;    /* P-0-0001, 10..60000 */
    int8_t signed8;    /* P-0-0002, -10..10 */
    uint64_t number64; /* P-0-0003, 1..2^63 */
    uint32_t gain;     /* P-0-0004, float -1.5..2.5 */
    uint16_t locked;   /* P-0-0006, never in OP */
    ECT_SOE_LIST_MEMORY(SOEDEV_CHOICE) at, mdt;
    ECT_SOE_LIST_MEMORY(6) not_safeop;
    ECT_SOE_LIST_MEMORY(4) not_op;
    ECT_SOE_LIST_MEMORY(20) text; /* P-0-0005 */
    ECT_SOE_LIST_MEMORY(16) wide; /* P-0-0007, list of 32 bits */
    ect_soe_command_t reset, slow, check_safeop, check_op;
    uint8_t mdt_count, at_count;
    uint32_t mdt_map[SOEDEV_MAPPED - 1], at_map[SOEDEV_MAPPED - 1];
} soedev_drive_t;

typedef struct soedev {
    ect_standard_t standard;
    ect_soe_state_t soe;
    uint8_t buffer[SOEDEV_BUFFER];
    soedev_drive_t drive[2];
    ECT_SOE_LIST_MEMORY(SOEDEV_LONG) long_list; /* S-0-0016 of drive 2 */
    ect_soe_command_t plain;                    /* S-0-0099 of drive 2 */
    uint16_t mode;                              /* S-0-0032 of drive 2 */

    /* results of the device, and calls by the stack */
    uint16_t read_code, write_code, command_code;
    bool refuses_state; /* ::ect_soe_t::valid is false */
    bool ends_at_once;  /* commands end in the call that starts them */
    unsigned int reads, written, commands, cancels;
    uint16_t last_idn; /* of the last call */
    uint8_t last_drive;
    uint64_t last_ns;
} soedev_t;

/* SoE of the device; soedev_quiet has no functions and one drive, its drive 2. */
extern const ect_soe_t soedev_soe, soedev_quiet;
extern const ect_device_t soedev;

#endif
