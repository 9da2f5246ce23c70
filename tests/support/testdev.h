/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A device made for tests: one object of every kind that the stack must serve, and switches for its results.
 *
 *   2000h  VAR  UNSIGNED32 rw            2001h  VAR  VISIBLE_STRING[20] rw       2002h  VAR OCTET_STRING[1000] rw
 *   2003h  VAR  UNSIGNED16 wo            2004h  VAR  UNSIGNED16 rw in PREOP only 2005h  VAR INTEGER16 -100..+200
 *   2006h  RECORD of BOOLEAN, BIT3, BIT5, UNSIGNED16, UNSIGNED8 ro, UNSIGNED32
 *   2007h  ARRAY of 4 UNSIGNED16 rw      2008h  RECORD with sub-indices 1, 3, 5  2009h  VAR UNSIGNED64 rw
 *   6000h  inputs (TxPDO)                7000h  outputs (RxPDO)
 * Process data: 1600h = 7000h:1 (BOOLEAN), gap of 7 bits, 7000h:2 (UNSIGNED16); 1A00h = 6000h:1 (UNSIGNED16),
 * 6000h:2 (BIT3), gap of 5 bits. SM0 1000h/128, SM1 1080h/128 (34..256), SM2 1200h/3, SM3 1300h/3, ET1100, watchdog on
 * SM2.
 */
#ifndef TESTS_SUPPORT_TESTDEV_H
#define TESTS_SUPPORT_TESTDEV_H

#include "seams/standard.h"

typedef struct testdev {
    ect_standard_t standard;
    uint32_t u32;
    char text[20];
    uint8_t octets[1000];
    uint16_t write_only;
    uint16_t preop_only;
    int16_t limited;
    uint8_t record_bool;
    uint8_t record_bit3;
    uint8_t record_bit5;
    uint16_t record_u16;
    uint8_t record_ro;
    uint32_t record_u32;
    uint16_t array[4];
    uint8_t sparse[3];
    uint64_t u64;
    uint16_t in_u16;
    uint8_t in_bits;
    uint8_t out_bool;
    uint16_t out_u16;

    /* calls by the stack */
    const ect_host_t *host;
    unsigned int inits, outputs_calls, safe_calls, inputs_calls, ticks, written;
    uint16_t written_index;
    uint8_t written_subindex;
    uint8_t from, to;

    /* results of the device */
    uint16_t state_change_answer;
    ect_reason_t write_answer;
    uint64_t tick_period_ns; /* 0: never */
} testdev_t;

extern const ect_device_t testdev;

enum { TESTDEV_PROTOCOLS = 8 };

/* The device with a protocol more. `list` gets its protocols and must exist as long as the device; `mailbox` is an
 * ECT_MAILBOX_... of the SII. */
ect_device_t testdev_with(const ect_protocol_t *protocol, const ect_protocol_t *list[TESTDEV_PROTOCOLS],
                          uint8_t mailbox, size_t instance_size);

struct wire;
/* The instance behind the twin at `position`. */
testdev_t *testdev_of(struct wire *w, size_t position);

#endif
