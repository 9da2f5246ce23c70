/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The test device (testdev.h) with files: what a device may do with FoE, and switches for what it answers.
 *
 *   data      read and written, up to FILEDEV_ROOM bytes
 *   secret    the same, with the password 0x1234
 *   constant  read only
 *   checked   refused when its first byte is FFh: the check value is wrong
 * SM0 and SM1 as the test device; BOOT with the same mailboxes.
 */
#ifndef TESTS_SUPPORT_FILEDEV_H
#define TESTS_SUPPORT_FILEDEV_H

#include "seams/foe.h"
#include "support/testdev.h"

enum { FILEDEV_FILES = 4, FILEDEV_ROOM = 1000, FILEDEV_PASSWORD = 0x1234 };
enum { FILEDEV_DATA, FILEDEV_SECRET, FILEDEV_CONSTANT, FILEDEV_CHECKED };

typedef struct filedev {
    testdev_t base;
    ect_foe_transfer_t transfer;
    uint8_t content[FILEDEV_FILES][FILEDEV_ROOM];
    uint16_t length[FILEDEV_FILES];
    uint8_t draft[FILEDEV_ROOM]; /* what is being written */
    uint32_t draft_length;
    uint8_t open; /* which, while one is */

    uint8_t put_off[6]; /* the head of the request that a hesitant one has told BUSY */

    /* what FoE did */
    unsigned int opened, closed_whole, closed_broken, written, asked;

    /* what the device answers */
    unsigned int late;    /* the next call takes so many questions to `ready` */
    uint32_t ready_error; /* and ends with that */
    uint32_t read_error;  /* what reading ends with, 0: data */
} filedev_t;

/** The description, with files at home in these states. Of one at a time. */
const ect_device_t *filedev_in(uint16_t read_states, uint16_t write_states, uint32_t busy_ms);
/** Its entry, to be changed before the device is opened. */
ect_foe_t *filedev_entry(void);
/** At home everywhere, never BUSY. */
const ect_device_t *filedev(void);
/**
 * The same under the name "hesitant": each request but an acknowledge is told BUSY, forgotten, and served when it is
 * repeated.
 */
const ect_device_t *filedev_hesitant(void);

#endif
