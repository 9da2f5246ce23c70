/* SPDX-License-Identifier: MIT */
/* Ethernet frames of SOES's API over this stack's EoE (seams/eoe.h). */
#include "soes/esc_eoe.h"

#include <string.h>

#include "soes/internal.h"
#include "wire/bytes.h"

void ESC_eoeprocess(void)
{
}

void ESC_eoeprocess_tx(void)
{
}

#if USE_EOE
static eoe_cfg_t *host;
static ect_eoe_address_t early; /* set before ecat_slv_init, which clears the instance */

/* --- the address -------------------------------------------------------------------------------------------------- */

static bool is_started(void)
{
    return ect_soes.slave.config.instance != NULL;
}

static ect_eoe_address_t *address(void)
{
    return is_started() ? &ect_soes_instance.eoe.address : &early;
}

void ect_soes_network_init(void)
{
    *address() = early;
}

static int get(uint8_t port, uint8_t flag, void *to, const void *from, size_t size)
{
    if (port != 0 || (address()->known & flag) == 0)
        return -1;
    memcpy(to, from, size);
    return 0;
}

static int set(uint8_t port, uint8_t flag, void *to, const void *from, size_t size)
{
    if (port != 0)
        return -1;
    address()->known |= flag;
    memcpy(to, from, size);
    return 0;
}

static int get_number(uint8_t port, uint8_t flag, uint32_t *to, const uint8_t *from)
{
    uint8_t octets[4];
    if (get(port, flag, octets, from, sizeof octets) != 0)
        return -1;
    *to = (uint32_t)ect_load_be16(octets) << 16 | ect_load_be16(octets + 2);
    return 0;
}

static int set_number(uint8_t port, uint8_t flag, uint8_t *to, uint32_t value)
{
    uint8_t octets[4];
    ect_store_be16(octets, (uint16_t)(value >> 16));
    ect_store_be16(octets + 2, (uint16_t)value);
    return set(port, flag, to, octets, sizeof octets);
}

int EOE_ecat_get_mac(uint8_t port, uint8_t mac[])
{
    return get(port, ECT_EOE_HAS_MAC, mac, address()->mac, sizeof address()->mac);
}

int EOE_ecat_get_ip(uint8_t port, uint32_t *ip)
{
    return get_number(port, ECT_EOE_HAS_IP, ip, address()->ip);
}

int EOE_ecat_get_subnet(uint8_t port, uint32_t *subnet)
{
    return get_number(port, ECT_EOE_HAS_SUBNET, subnet, address()->subnet);
}

int EOE_ecat_get_gateway(uint8_t port, uint32_t *default_gateway)
{
    return get_number(port, ECT_EOE_HAS_GATEWAY, default_gateway, address()->gateway);
}

int EOE_ecat_get_dns_ip(uint8_t port, uint32_t *dns_ip)
{
    return get_number(port, ECT_EOE_HAS_DNS, dns_ip, address()->dns);
}

int EOE_ecat_get_dns_name(uint8_t port, char *dns_name)
{
    return get(port, ECT_EOE_HAS_NAME, dns_name, address()->name, sizeof address()->name);
}

int EOE_ecat_set_mac(uint8_t port, uint8_t mac[])
{
    return set(port, ECT_EOE_HAS_MAC, address()->mac, mac, sizeof address()->mac);
}

int EOE_ecat_set_ip(uint8_t port, uint32_t ip)
{
    return set_number(port, ECT_EOE_HAS_IP, address()->ip, ip);
}

int EOE_ecat_set_subnet(uint8_t port, uint32_t subnet)
{
    return set_number(port, ECT_EOE_HAS_SUBNET, address()->subnet, subnet);
}

int EOE_ecat_set_gateway(uint8_t port, uint32_t default_gateway)
{
    return set_number(port, ECT_EOE_HAS_GATEWAY, address()->gateway, default_gateway);
}

int EOE_ecat_set_dns_ip(uint8_t port, uint32_t dns_ip)
{
    return set_number(port, ECT_EOE_HAS_DNS, address()->dns, dns_ip);
}

int EOE_ecat_set_dns_name(uint8_t port, char *dns_name)
{
    char name[ECT_EOE_NAME] = {0};
    for (size_t i = 0; i < sizeof name && dns_name[i] != '\0'; i++)
        name[i] = dns_name[i];
    return set(port, ECT_EOE_HAS_NAME, address()->name, name, sizeof name);
}

/* The callback reads the new address by EOE_ecat_get_… */
static uint16_t store(const ect_eoe_t *eoe, void *instance, uint8_t port, const ect_eoe_address_t *wanted)
{
    const ect_eoe_address_t before = *address();
    (void)eoe;
    (void)instance;
    (void)port;
    if (!host || !host->store_ethernet_settings)
        return EOE_RESULT_NO_IP_SUPPORT;
    *address() = *wanted;
    uint16_t result = (uint16_t)host->store_ethernet_settings();
    if (result != EOE_RESULT_SUCCESS)
        *address() = before;
    return result;
}

static void load(const ect_eoe_t *eoe, void *instance, uint8_t port)
{
    (void)eoe;
    (void)instance;
    (void)port;
    if (host && host->load_eth_settings)
        (void)host->load_eth_settings();
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    eoe_pbuf_t buffer = {0};
    (void)eoe;
    (void)instance;
    if (host && host->get_buffer)
        host->get_buffer(&buffer);
    if (!buffer.payload)
        return false;
    memcpy(buffer.payload, frame, length);
    buffer.len = length;
    host->handle_recv_buffer(port, &buffer);
    return true;
}

static uint16_t fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    eoe_pbuf_t buffer = {0};
    (void)eoe;
    (void)instance;
    int length = host ? host->fetch_send_buffer(0, &buffer) : 0;
    if (length <= 0 || !buffer.payload)
        return 0;
    *port = 0;
    memcpy(frame, buffer.payload, length <= ECT_EOE_FRAME ? (size_t)length : ECT_EOE_FRAME);
    if (host->free_buffer)
        host->free_buffer(&buffer);
    return length <= ECT_EOE_FRAME ? (uint16_t)length : ECT_EOE_FRAME + 1; /* too long: counted as dropped */
}

static bool next(const ect_protocol_t *self, ect_slave_t *slave, bool send)
{
    bool sent = ect_eoe_next(self, slave, send);
    if (sent && send && host && host->fragment_sent_event)
        host->fragment_sent_event();
    return sent;
}

void EOE_config(eoe_cfg_t *cfg)
{
    host = cfg;
}

void EOE_init(void)
{
    if (is_started()) /* before ecat_slv_init no frame is under way */
        ect_eoe_reset(&ect_soes_network.protocol, &ect_soes.slave);
}

const ect_eoe_t ect_soes_network = {
    {.type = ECT_MAILBOX_TYPE_EOE,
     .states = ECT_IN_PREOP_AND_ABOVE,
     .request = ect_eoe_request,
     .next = next,
     .reset = ect_eoe_reset},
    .offset = offsetof(ect_soes_instance_t, eoe),
    .received = received,
    .fetch = fetch,
    .set = store,
    .load = load,
};
#endif
