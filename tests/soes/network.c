/* SPDX-License-Identifier: MIT */
/*
 * A SOES application with a network address, in its own loop: all of esc_eoe.h, over the wire. Its frames are buffers
 * of a pool that change hands as in SOES: the stack gets one for a frame that comes, the application hands it back to
 * be sent with the reply in it, and gets it free again.
 */
#include "esc_eoe.h"

#include <string.h>

#include "ecat_slv.h"
#include "profiles/ip/responder.h"

enum { BUFFERS = 4, NONE = -1 };

static struct {
    uint8_t frames[BUFFERS][ECT_EOE_FRAME];
    bool used[BUFFERS];
    size_t lengths[BUFFERS]; /* of replies that wait, 0: none */
    unsigned int fragments;
    ect_eoe_address_t address;
} net;

static int number_of(const eoe_pbuf_t *buffer)
{
    return (int)((uint8_t(*)[ECT_EOE_FRAME])buffer->pbuf - net.frames);
}

static void get_buffer(eoe_pbuf_t *buffer)
{
    *buffer = (eoe_pbuf_t){.payload = NULL};
    for (unsigned int i = 0; i < BUFFERS && !buffer->payload; i++) {
        if (net.used[i])
            continue;
        net.used[i] = true;
        *buffer = (eoe_pbuf_t){.pbuf = net.frames[i], .payload = net.frames[i], .len = sizeof net.frames[i]};
    }
}

static void free_buffer(eoe_pbuf_t *buffer)
{
    net.used[number_of(buffer)] = false;
}

/* Numbers have the first octet highest. */
static void spread(uint8_t octets[4], uint32_t number)
{
    for (int i = 0; i < 4; i++)
        octets[i] = (uint8_t)(number >> (24 - 8 * i));
}

static int store(void)
{
    uint32_t ip = 0, number = 0;
    char name[ECT_EOE_NAME];
    if (EOE_ecat_get_ip(0, &ip) != 0 || EOE_ecat_get_mac(0, net.address.mac) != 0)
        return EOE_RESULT_NO_IP_SUPPORT;
    spread(net.address.ip, ip);
    net.address.known = ECT_EOE_HAS_IP | ECT_EOE_HAS_MAC;
    (void)EOE_ecat_get_subnet(0, &number);
    (void)EOE_ecat_get_gateway(0, &number);
    (void)EOE_ecat_get_dns_ip(0, &number);
    return EOE_ecat_get_dns_name(0, name) == 0 ? EOE_RESULT_SUCCESS : EOE_RESULT_UNSPECIFIED_ERROR;
}

/* A master that reads the address gets a name server too. */
static int load(void)
{
    return EOE_ecat_set_dns_ip(0, 0xC0000235);
}

static void received(uint8_t port, eoe_pbuf_t *buffer)
{
    uint8_t reply[ECT_EOE_FRAME];
    const uint16_t length = ect_ip_reply(&net.address, buffer->payload, (uint16_t)buffer->len, reply);
    (void)port;
    if (length == 0) {
        free_buffer(buffer);
        return;
    }
    memcpy(buffer->payload, reply, length);
    net.lengths[number_of(buffer)] = length;
}

static int fetch(uint8_t port, eoe_pbuf_t *buffer)
{
    (void)port;
    for (unsigned int i = 0; i < BUFFERS; i++) {
        const int length = (int)net.lengths[i];
        if (length == 0)
            continue;
        net.lengths[i] = 0;
        *buffer = (eoe_pbuf_t){.pbuf = net.frames[i], .payload = net.frames[i], .len = (size_t)length};
        return length;
    }
    return NONE;
}

static void fragment_sent(void)
{
    net.fragments++;
}

static void restart(uint8_t *as, uint8_t *an)
{
    if (*as == INIT_TO_PREOP && *an == ESCinit)
        EOE_init();
}

int main(void)
{
    static eoe_cfg_t callbacks = {get_buffer, free_buffer, load, store, received, fetch, fragment_sent};
    static esc_cfg_t config = {.user_arg = "/dev/esc", .watchdog_cnt = 2000, .pre_state_change_hook = restart};
    static uint8_t mac[6] = {2, 0, 0x5E, 0x10, 0x20, 0x30};
    static char name[] = "network";
    EOE_config(&callbacks);
    EOE_init();
    (void)EOE_ecat_set_mac(0, mac);
    (void)EOE_ecat_set_ip(0, 0);
    (void)EOE_ecat_set_subnet(0, 0xFFFFFF00);
    (void)EOE_ecat_set_gateway(0, 0);
    (void)EOE_ecat_set_dns_name(0, name);
    ecat_slv_init(&config);
    for (;;) {
        ecat_slv();
        ESC_eoeprocess();
        ESC_eoeprocess_tx();
    }
}
