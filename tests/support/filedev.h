/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The test device (testdev.h) with files: all operations of FoE, and switches for the results.
 *
 *   data      read and written, up to FILEDEV_ROOM bytes
 *   secret    the same, with the password 0x1234
 *   constant  read only
 *   checked   refused when its first byte is FFh: the check value is wrong
 *
 * SM0 and SM1 as in the test device; BOOT with the same mailboxes.
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
    uint8_t draft[FILEDEV_ROOM]; /* content during a write */
    uint32_t draft_length;
    uint8_t open; /* the open file */

    uint8_t put_off[6]; /* start of the request that a hesitant device has replied BUSY to */

    /* calls by FoE */
    unsigned int opened, closed_whole, closed_broken, written, requests;

    /* results of the device */
    unsigned int late;    /* the next call needs that many calls of `ready` */
    uint32_t ready_error; /* and ends with this error */
    uint32_t read_error;  /* result of reading, 0: data */
} filedev_t;

/** The description, with access to files in these states. One at a time. */
const ect_device_t *filedev_in(uint16_t read_states, uint16_t write_states, uint32_t busy_ms);
/** Its entry, to be changed before the device is opened. */
ect_foe_t *filedev_entry(void);
/** Access in all states, never BUSY. */
const ect_device_t *filedev(void);
/**
 * The same under the name "hesitant": each request except an acknowledge gets BUSY, is forgotten, and is served when it
 * is repeated.
 */
const ect_device_t *filedev_hesitant(void);

#endif
