/* SPDX-License-Identifier: MIT */
#include "profiles/ip/echo.h"

#include <string.h>

#include "profiles/ip/responder.h"

static ect_ip_echo_t *network_of(const ect_eoe_t *eoe, void *instance)
{
    return (ect_ip_echo_t *)(void *)((uint8_t *)instance + eoe->offset);
}

bool ect_ip_echo_received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    ect_ip_echo_t *n = network_of(eoe, instance);
    (void)port;
    if (n->reply_length != 0)
        return false; /* the master sends faster than it fetches */
    n->reply_length = ect_ip_reply(&n->eoe.address, frame, length, n->reply);
    return true;
}

uint16_t ect_ip_echo_fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    ect_ip_echo_t *n = network_of(eoe, instance);
    uint16_t length = n->reply_length;
    *port = 0; /* any reply */
    memcpy(frame, n->reply, length);
    n->reply_length = 0;
    return length;
}

void ect_ip_echo_reset(const ect_eoe_t *eoe, void *instance)
{
    network_of(eoe, instance)->reply_length = 0;
}
