/* SPDX-License-Identifier: MIT */
/** @file Steps of Ethernet over EtherCAT (ETG.1000.6 §5.7): services, fragments, addresses, frames that get a reply. */
#ifndef ECTWIN_CONFORM_ETHERNET_H
#define ECTWIN_CONFORM_ETHERNET_H

#include "steps/case.h"

/** EoE types. */
enum {
    CF_EOE_FRAGMENT,
    CF_EOE_TIMESTAMP,
    CF_EOE_SET_IP,
    CF_EOE_WAS_SET,
    CF_EOE_SET_FILTER,
    CF_EOE_FILTER_WAS_SET,
    CF_EOE_GET_IP,
    CF_EOE_IP,
    CF_EOE_GET_FILTER,
    CF_EOE_FILTER,
};
enum { CF_EOE_DONE = 0, CF_EOE_UNSUPPORTED = 0x0002 };
enum { CF_EOE_HAS_MAC = 0x01, CF_EOE_HAS_IP = 0x02, CF_EOE_HAS_SUBNET = 0x04, CF_EOE_HAS_GATEWAY = 0x08 };
enum { CF_EOE_HEADER = 4, CF_EOE_FLAGS = 4, CF_EOE_UNIT = 32, CF_EOE_MAC = 6, CF_EOE_ADDRESS = 4 };
/** The shortest and the longest frame without a VLAN tag. */
enum { CF_EOE_LEAST = 60, CF_EOE_MOST = 1514 };
/** Bytes of all IP parameters with their flags; room for any frame of a case. */
enum { CF_EOE_PARAMETERS = 62 - CF_EOE_HEADER, CF_EOE_ROOM = 1600 };

/** The parameters of the slave. */
typedef struct cf_eoe_host {
    uint8_t data[CF_MAX_MAIL]; /**< flags and parameters, byte for byte */
    uint16_t length;
    bool has_ip;
    uint8_t mac[CF_EOE_MAC], ip[CF_EOE_ADDRESS]; /**< in the order of an Ethernet frame */
    unsigned int replies;                        /**< number of ARP replies since the last check */
} cf_eoe_host_t;

/** Sends a mail of EoE. @param type  frame type and port @param word  bytes 2 and 3 of the EoE header */
void cf_eoe_send(cf_t *c, uint8_t type, uint16_t word, const void *data, uint16_t length, bool last);
/** Reads the reply of a service; skips frames of the slave. @return the result of the service */
uint16_t cf_eoe_reply(cf_t *c, uint8_t type, cf_mail_t *mail);
/** Reads the parameters; without them `length` is 0. */
void cf_eoe_get_ip(cf_t *c, cf_eoe_host_t *h);

/** @return the largest size of a fragment except the last one: whole units that fit the mailbox; 0: none fits */
uint16_t cf_eoe_most(const cf_t *c);
/** Sends `size` bytes of a frame, from byte `from` on; the last ones with the last flag. */
void cf_eoe_send_fragment(cf_t *c, const uint8_t *frame, uint16_t length, uint16_t from, uint16_t size, uint8_t number,
                          unsigned int fragment);
/** Writes an ARP request for the slave's address, CF_EOE_MOST bytes with the padding. */
void cf_eoe_arp(uint8_t *frame, const cf_eoe_host_t *h);
/** Assembles the next frame of the slave and checks its fragments. @return bytes, 0: none within `ms` */
uint16_t cf_eoe_receive_frame(cf_t *c, uint8_t *frame, uint32_t ms);
/** Receives a frame of the slave; an ARP reply is counted. */
void cf_eoe_take(cf_t *c, cf_eoe_host_t *h, uint32_t ms);
/**
 * Sends a whole frame in fragments of `size` bytes, and reads the slave's frames in between: an unread one may block
 * it.
 * @param skip  fragment to leave out; -1: none
 */
void cf_eoe_send_frame(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame, uint16_t length, uint16_t size, uint8_t number,
                       int skip);
/** There must be exactly `wanted` ARP replies since the last call. */
void cf_eoe_expect_replies(cf_t *c, cf_eoe_host_t *h, const char *what, unsigned int wanted);

/* --- an address for the case: ethernet_steps.c -------------------------------------------------------------------- */

/**
 * Writes 192.0.2.`host`/24 with the gateway 192.0.2.1, one field behind the other or in the full layout.
 * @param[out] data  CF_EOE_PARAMETERS bytes
 * @return bytes
 */
uint16_t cf_eoe_parameters_of(uint8_t *data, uint8_t host, bool full);
/** Sends a set IP. @return its result */
uint16_t cf_eoe_set_ip(cf_t *c, const uint8_t *data, uint16_t length, bool last);
/** PREOP, with the parameters that the slave has. Skips the case when the mailbox has no room for a fragment. */
void cf_eoe_begin(cf_t *c, cf_eoe_host_t *before);
/** Sets 192.0.2.`host`/24; the runner restores the parameters of `before` after the case. Skips the case when the slave
 * refuses. */
void cf_eoe_require_address(cf_t *c, const cf_eoe_host_t *before, uint8_t host);
/** Get IP must return 192.0.2.`host`/24 with the gateway. */
void cf_eoe_expect_address(cf_t *c, const char *what, uint8_t host);

/** ::cf_eoe_begin; then the slave replies to ARP, if necessary with an address for the case. Otherwise skips the case.
 */
void cf_eoe_begin_frames(cf_t *c, cf_eoe_host_t *h);
/** Writes a ping in a frame of `length` bytes, 42 or more. */
void cf_eoe_ping(uint8_t *frame, const cf_eoe_host_t *h, uint16_t length);
/** @return whether the echo of the ping came before the slave was quiet for `ms` */
bool cf_eoe_await_echo(cf_t *c, const uint8_t *frame, uint16_t length, uint32_t ms);
/** Sends an ARP request in two fragments; there must be one reply. */
void cf_eoe_expect_good_frame(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame);

#endif
