/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The test device (testdev.h) with Ethernet over EtherCAT: it reports and stores the address 192.0.2.7 and replies to
 * ARP requests for it; no filter. A product's own protocol that uses seams/mailbox.h only.
 */
#ifndef TESTS_SUPPORT_EOEDEV_H
#define TESTS_SUPPORT_EOEDEV_H

#include "support/testdev.h"

enum { EOEDEV_FRAME = 1514 };

typedef struct eoedev {
    testdev_t base;
    uint8_t in[EOEDEV_FRAME]; /* an incoming frame, in fragments */
    uint16_t in_length;
    uint8_t fragment, number; /* that come next */
    bool coming;
    uint8_t out[EOEDEV_FRAME]; /* an outgoing frame, in fragments */
    uint16_t out_length, out_sent;
    uint8_t out_number;
} eoedev_t;

/** @param careless  assembles all fragments, even after a lost one */
const ect_device_t *eoedev(bool careless);

#endif
