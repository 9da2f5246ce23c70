/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Two mailbox protocols of a product made for tests, with seams/mailbox.h only: an example for a device's folder.
 *
 *   VoE    echoes a mail in reverse byte order; "again N" makes it send N further mails, one each time that the mailbox
 *          is free. Refuses mails of one byte as too short.
 *   FoE    a minimal firmware update: in BOOT only, it counts the received bytes and replies with the count.
 */
#ifndef TESTS_SUPPORT_VOE_H
#define TESTS_SUPPORT_VOE_H

#include "seams/mailbox.h"

/** State of both. The entry contains its offset in the instance, so that any instance can contain it anywhere. */
typedef struct voe {
    uint8_t again;     /**< mails still to send */
    uint32_t received; /**< bytes in BOOT */
    unsigned int resets;
} voe_t;

typedef struct voe_protocol {
    ect_protocol_t protocol;
    unsigned long offset; /**< of the voe_t in the instance */
} voe_protocol_t;

uint16_t voe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);
bool voe_next(const ect_protocol_t *self, ect_slave_t *slave, bool send);
void voe_reset(const ect_protocol_t *self, ect_slave_t *slave);
uint16_t voe_boot_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);

#endif
