/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A minimal IPv4 host: ARP (RFC 826), echo of ICMP (RFC 792, "ping") and of UDP port 7 (RFC 862). For a device with EoE
 * (seams/eoe.h) and without a network stack.
 *
 *     static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
 *     {
 *         drive_t *d = instance;
 *         d->reply_length = ect_ip_reply(&d->eoe.address, frame, length, d->reply);
 *         return true;
 *     }
 */
#ifndef ECT_PROFILES_IP_RESPONDER_H
#define ECT_PROFILES_IP_RESPONDER_H

#include "seams/eoe.h"

ECT_C_BEGIN

/**
 * Builds the reply to a frame.
 *
 * Without ECT_EOE_HAS_IP in `own->known` no frame gets a reply; without ECT_EOE_HAS_MAC the MAC address is that of
 * ::ect_ip_mac. A fragment of an IP packet, a packet with a wrong header checksum or length, and a frame with a VLAN
 * tag get no reply. The checksum of a reply is correct if that of the request is correct.
 *
 * Context: any. Cost: one pass over the frame.
 *
 * @param frame   from the destination address on, without FCS, `length` bytes
 * @param reply   room for ECT_EOE_FRAME bytes; must not overlap `frame`
 * @return length of the reply; 0: none, and the content of `reply` is undefined
 */
uint16_t ect_ip_reply(const ect_eoe_address_t *own, const uint8_t *frame, uint16_t length, uint8_t *reply);

/** Writes the MAC address of a device: the known one, else a locally administered one derived from its IP address. */
void ect_ip_mac(const ect_eoe_address_t *own, uint8_t mac[6]);

ECT_C_END

#endif
