/* SPDX-License-Identifier: MIT */
/* EoE of a twin, which replies to ARP, ping and UDP echo at the address set by the master; AoE of a twin. */
#include "esi/internal.h"

#include "profiles/ip/echo.h"

const ect_protocol_t *ect_esi_network(ect_build_t *build, const ect_device_t *device)
{
    ECT_ASSERT(device->sm_count >= 2 && !build->network);
    if (!ect_eoe_fits(device))
        return NULL;
    ect_eoe_t *eoe = ect_arena_alloc(build->arena, sizeof *eoe);
    *eoe = (ect_eoe_t)ECT_IP_ECHO(0);
    build->network = eoe;
    return &eoe->protocol;
}

size_t ect_esi_network_place(const ect_build_t *build, size_t at)
{
    const size_t alignment = _Alignof(ect_ip_echo_t);
    if (!build->network)
        return at;
    build->network->offset = (at + alignment - 1) / alignment * alignment;
    return build->network->offset + sizeof(ect_ip_echo_t);
}

const ect_protocol_t *ect_esi_ads(ect_build_t *build, const ect_device_t *device)
{
    ECT_ASSERT(device->sm_count >= 2 && !build->ads);
    if (!ect_aoe_fits(device))
        return NULL;
    ect_aoe_t *ads = ect_arena_alloc(build->arena, sizeof *ads);
    *ads = (ect_aoe_t){.protocol = ECT_AOE_PROTOCOL, .offset = build->start};
    build->ads = ads;
    return &ads->protocol;
}

size_t ect_esi_ads_size(const ect_esi_device_t *model)
{
    return model->mailbox.aoe ? sizeof(ect_aoe_state_t) : 0;
}
