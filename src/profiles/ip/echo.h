/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The network of a device with EoE (seams/eoe.h) and without a network stack: replies to ARP, ping and UDP echo at the
 * address set by the master (profiles/ip/responder.h). Boards and twins of ESI files use the same functions.
 *
 *     typedef struct drive { ect_standard_t standard; ect_ip_echo_t network; } drive_t;
 *     static const ect_eoe_t network = ECT_IP_ECHO(offsetof(drive_t, network));
 *
 * The functions are those of ::ect_eoe, and get the entry and the device's instance as described there. One reply waits
 * at a time: a frame that arrives before the master has fetched the previous reply is counted as dropped.
 */
#ifndef ECT_PROFILES_IP_ECHO_H
#define ECT_PROFILES_IP_ECHO_H

#include "seams/eoe.h"

ECT_C_BEGIN

/** The network in the device's instance, zero at power-on. The entry's `offset` is that of this structure. */
typedef struct ect_ip_echo {
    ect_eoe_state_t eoe;   /**< the first member */
    uint16_t reply_length; /* private; 0: none */
    uint8_t reply[ECT_EOE_FRAME];
} ect_ip_echo_t;

/** Builds the reply to a frame. @return false: the previous reply still waits, and the frame is dropped */
bool ect_ip_echo_received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length);
/** Returns the reply. @return length of the reply; 0: none */
uint16_t ect_ip_echo_fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port);
/** Discards the reply at the start of the mailbox. */
void ect_ip_echo_reset(const ect_eoe_t *eoe, void *instance);

ECT_C_END

/** The entry of a device. @param at  offset of its ::ect_ip_echo_t in the instance */
#define ECT_IP_ECHO(at)                                                                                                \
    {ECT_EOE_PROTOCOL, .offset = (at), .received = ect_ip_echo_received, .fetch = ect_ip_echo_fetch,                   \
     .reset = ect_ip_echo_reset}

#endif
