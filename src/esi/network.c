/* SPDX-License-Identifier: MIT */
/* EoE of a twin: a master sets its address, which then answers ARP, ping and UDP echo. */
#include "esi/internal.h"

#include <string.h>

#include "profiles/ip/responder.h"

typedef struct network {
    ect_eoe_state_t eoe;
    uint16_t reply_length; /* 0: none */
    uint8_t reply[ECT_EOE_FRAME];
} network_t;

static network_t *network_of(const ect_eoe_t *eoe, void *instance)
{
    return (network_t *)(void *)((uint8_t *)instance + eoe->offset);
}

static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    network_t *n = network_of(eoe, instance);
    (void)port;
    if (n->reply_length != 0)
        return false; /* the master sends faster than it fetches */
    n->reply_length = ect_ip_reply(&n->eoe.address, frame, length, n->reply);
    return true;
}

static uint16_t fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    network_t *n = network_of(eoe, instance);
    uint16_t length = n->reply_length;
    (void)port;
    memcpy(frame, n->reply, length);
    n->reply_length = 0;
    return length;
}

static void reset(const ect_eoe_t *eoe, void *instance)
{
    network_of(eoe, instance)->reply_length = 0;
}

const ect_protocol_t *ect_esi_network(ect_build_t *build, const ect_device_t *device)
{
    ECT_ASSERT(device->sm_count >= 2 && !build->network);
    if (!ect_eoe_fits(device))
        return NULL;
    ect_eoe_t *eoe = ect_arena_alloc(build->arena, sizeof *eoe);
    *eoe = (ect_eoe_t){ECT_EOE_PROTOCOL, .received = received, .fetch = fetch, .reset = reset};
    build->network = eoe;
    return &eoe->protocol;
}

size_t ect_esi_network_place(const ect_build_t *build, size_t at)
{
    const size_t alignment = _Alignof(network_t);
    if (!build->network)
        return at;
    build->network->offset = (at + alignment - 1) / alignment * alignment;
    return build->network->offset + sizeof(network_t);
}
