/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Two mailbox protocols of a product made for tests, over seams/mailbox.h alone: what a device's folder may hold.
 *
 *   VoE    echoes what it is sent, byte by byte in reverse; "again N" makes it send N mails more, one each time that
 * the mailbox is free. Refuses mails of one byte as too short. FoE    a firmware update as bare as can be: in BOOT
 * only, it counts the bytes that it is given and answers with the count.
 */
#ifndef TESTS_SUPPORT_VOE_H
#define TESTS_SUPPORT_VOE_H

#include "seams/mailbox.h"

/** State of both, and where it lies in the instance: the entry says it, so that any instance can have it anywhere. */
typedef struct voe {
    uint8_t again;     /**< mails that are still to come */
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
