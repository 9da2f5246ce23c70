/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API: Ethernet frames by EoE. Context of functions and callbacks: mainline.
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
    void *pbuf;       /**< for the application; not used by the stack */
    uint8_t *payload; /**< the bytes, from the destination address on, without FCS */
    size_t len;       /**< bytes */
} eoe_pbuf_t;

/** The callbacks of an application; must outlive the slave. A callback must not be NULL unless noted. */
typedef struct eoe_cfg {
    /**
     * Returns a buffer of 1518 bytes for a complete frame. If `payload` or the callback is NULL, the frame is dropped.
     */
    void (*get_buffer)(eoe_pbuf_t *ebuf);
    /** Releases a buffer of fetch_send_buffer after its bytes are copied. May be NULL. */
    void (*free_buffer)(eoe_pbuf_t *ebuf);
    /**
     * Called when a master reads the address: the application updates it by EOE_ecat_set_…; the result has no effect.
     * May be NULL.
     */
    int (*load_eth_settings)(void);
    /**
     * Called when a master has set the address, which EOE_ecat_get_… return. @return the result for the master
     * (EOE_RESULT_…); unless 0, the previous address is kept. NULL: EOE_RESULT_NO_IP_SUPPORT
     */
    int (*store_ethernet_settings)(void);
    /** Gets a frame of `len` bytes, and its buffer. */
    void (*handle_recv_buffer)(uint8_t port, eoe_pbuf_t *ebuf);
    /**
     * Returns the next frame to send in `payload`. Called when no frame is under way, at least once in each
     * ::ecat_slv_poll. @return bytes of the frame; 0 or less: none
     */
    int (*fetch_send_buffer)(uint8_t port, eoe_pbuf_t *ebuf);
    /** Called when a fragment has been written to the mailbox. May be NULL. */
    void (*fragment_sent_event)(void);
} eoe_cfg_t;

/** Copies a part of the address. @return 0 · -1: not set, or a port other than 0; nothing is written */
int EOE_ecat_get_mac(uint8_t port, uint8_t mac[]);
int EOE_ecat_get_ip(uint8_t port, uint32_t *ip);
int EOE_ecat_get_subnet(uint8_t port, uint32_t *subnet);
int EOE_ecat_get_gateway(uint8_t port, uint32_t *default_gateway);
int EOE_ecat_get_dns_ip(uint8_t port, uint32_t *dns_ip);
/** @param[out] dns_name  32 bytes, padded with zeros */
int EOE_ecat_get_dns_name(uint8_t port, char *dns_name);

/** Sets a part of the address; also before ecat_slv_init. @return 0 · -1: a port other than 0 */
int EOE_ecat_set_mac(uint8_t port, uint8_t mac[]);
int EOE_ecat_set_ip(uint8_t port, uint32_t ip);
int EOE_ecat_set_subnet(uint8_t port, uint32_t subnet);
int EOE_ecat_set_gateway(uint8_t port, uint32_t default_gateway);
int EOE_ecat_set_dns_ip(uint8_t port, uint32_t dns_ip);
/** @param dns_name  up to 32 bytes, zero-terminated if shorter */
int EOE_ecat_set_dns_name(uint8_t port, char *dns_name);

/**
 * Stores the callbacks. Due before ecat_slv_init. Without a call, frames are dropped and set IP is refused with
 * EOE_RESULT_NO_IP_SUPPORT.
 */
void EOE_config(eoe_cfg_t *cfg);
/** Drops frames under way in both directions. No effect before ecat_slv_init. */
void EOE_init(void);
/** No effect, because ::ESC_state does this work. For loops that call the parts. */
void ESC_eoeprocess(void);
void ESC_eoeprocess_tx(void);

ECT_C_END

#endif
