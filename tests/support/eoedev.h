/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The test device (testdev.h) with Ethernet over EtherCAT: the address 192.0.2.7, which it tells, keeps and answers ARP
 * requests for; no filter. A protocol of a product, on top of seams/mailbox.h alone.
 */
#ifndef TESTS_SUPPORT_EOEDEV_H
#define TESTS_SUPPORT_EOEDEV_H

#include "support/testdev.h"

enum { EOEDEV_FRAME = 1514 };

typedef struct eoedev {
    testdev_t base;
    uint8_t in[EOEDEV_FRAME]; /* a frame that is coming in fragments */
    uint16_t in_length;
    uint8_t fragment, number; /* that come next */
    bool coming;
    uint8_t out[EOEDEV_FRAME]; /* a frame that goes out in fragments */
    uint16_t out_length, out_sent;
    uint8_t out_number;
} eoedev_t;

/** @param careless  puts together whatever comes, lost fragments or not */
const ect_device_t *eoedev(bool careless);

#endif
