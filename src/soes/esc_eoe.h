/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API: Ethernet frames by EoE. All functions: mainline, as the callbacks.
 *
 * There is one port, 0. An address is a number with the first octet highest: 192.168.0.1 is C0A80001h.
 */
#ifndef ECT_SOES_ESC_EOE_H
#define ECT_SOES_ESC_EOE_H

#include "soes/cc.h"

#include "wire/linkage.h"

ECT_C_BEGIN

/** A frame buffer of the application. */
typedef struct eoe_pbuf {
    void *pbuf;       /**< the application's; not used here */
    uint8_t *payload; /**< the bytes, from the destination address on, without FCS */
    size_t len;       /**< bytes */
} eoe_pbuf_t;

/** The callbacks of an application. Lives as long as the slave. A callback must not be NULL unless noted. */
typedef struct eoe_cfg {
    /** Gives a buffer of 1518 bytes for a frame that has come whole; `payload` NULL, or the callback: no room, and the
     * frame is dropped. */
    void (*get_buffer)(eoe_pbuf_t *ebuf);
    /** Takes back a buffer of fetch_send_buffer, as soon as its bytes are copied. May be NULL. */
    void (*free_buffer)(eoe_pbuf_t *ebuf);
    /** A master asks for the address: the application refreshes it by EOE_ecat_set_…; the result has no effect. May be
     * NULL. */
    int (*load_eth_settings)(void);
    /** A master has set the address, which EOE_ecat_get_… give. @return the result for the master (EOE_RESULT_…);
     * unless it is 0, the old address is kept. NULL: EOE_RESULT_NO_IP_SUPPORT */
    int (*store_ethernet_settings)(void);
    /** Takes a frame, `len` bytes, with its buffer. */
    void (*handle_recv_buffer)(uint8_t port, eoe_pbuf_t *ebuf);
    /** Gives the next frame to send: `payload`. Called when no frame is under way, at least once in each
     * ::ecat_slv_poll. @return its bytes; 0 or less: none */
    int (*fetch_send_buffer)(uint8_t port, eoe_pbuf_t *ebuf);
    /** A fragment was put into the mailbox. May be NULL. */
    void (*fragment_sent_event)(void);
} eoe_cfg_t;

/** Copies a part of the address. @return 0 · -1: not known, or another port than 0; nothing is written then */
int EOE_ecat_get_mac(uint8_t port, uint8_t mac[]);
int EOE_ecat_get_ip(uint8_t port, uint32_t *ip);
int EOE_ecat_get_subnet(uint8_t port, uint32_t *subnet);
int EOE_ecat_get_gateway(uint8_t port, uint32_t *default_gateway);
int EOE_ecat_get_dns_ip(uint8_t port, uint32_t *dns_ip);
/** @param[out] dns_name  32 bytes, padded with zeros */
int EOE_ecat_get_dns_name(uint8_t port, char *dns_name);

/** Sets a part of the address, which is known from then on; also before ecat_slv_init. @return 0 · -1: another port
 * than
 * 0 */
int EOE_ecat_set_mac(uint8_t port, uint8_t mac[]);
int EOE_ecat_set_ip(uint8_t port, uint32_t ip);
int EOE_ecat_set_subnet(uint8_t port, uint32_t subnet);
int EOE_ecat_set_gateway(uint8_t port, uint32_t default_gateway);
int EOE_ecat_set_dns_ip(uint8_t port, uint32_t dns_ip);
/** @param dns_name  up to 32 bytes, zero-terminated if shorter */
int EOE_ecat_set_dns_name(uint8_t port, char *dns_name);

/** Keeps the callbacks. Before ecat_slv_init. Without a call, frames are dropped and set IP is refused with
 * EOE_RESULT_NO_IP_SUPPORT. */
void EOE_config(eoe_cfg_t *cfg);
/** Drops frames of both directions that are under way. Before ecat_slv_init there are none. */
void EOE_init(void);
/** Nothing is left to do: ::ESC_state does it. For loops that are made of the pieces. */
void ESC_eoeprocess(void);
void ESC_eoeprocess_tx(void);

ECT_C_END

#endif
