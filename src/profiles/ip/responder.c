/* SPDX-License-Identifier: MIT */
#include "profiles/ip/responder.h"

#include <string.h>

#include "wire/bytes.h"

enum { MAC = 6, IP = 4, ETHERNET = 14, SHORTEST = 60 };
enum { TYPE_IP = 0x0800, TYPE_ARP = 0x0806 };
enum { ARP = 28, ARP_REQUEST = 1, ARP_REPLY = 2 };
enum { HEADER_LEAST = 20, FRAGMENTED = 0x3FFF, ICMP = 1, UDP = 17 };
enum { ECHO_REPLY = 0, ECHO = 8, UDP_HEADER = 8, PORT_ECHO = 7 };

void ect_ip_mac(const ect_eoe_address_t *own, uint8_t mac[6])
{
    static const uint8_t local[2] = {0x02, 0x00};
    if ((own->known & ECT_EOE_HAS_MAC) != 0) {
        memcpy(mac, own->mac, MAC);
        return;
    }
    memcpy(mac, local, sizeof local);
    memcpy(mac + sizeof local, own->ip, IP);
}

static uint16_t sum(const uint8_t *data, unsigned int length)
{
    uint32_t total = 0;
    for (unsigned int i = 0; i + 1 < length; i += 2)
        total += ect_load_be16(data + i);
    total = (total & 0xFFFF) + (total >> 16);
    return (uint16_t)(total + (total >> 16));
}

static void swap(uint8_t *a, uint8_t *b, unsigned int length)
{
    for (unsigned int i = 0; i < length; i++) {
        uint8_t kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

static uint16_t arp_reply(const ect_eoe_address_t *own, const uint8_t *mac, uint16_t length, uint8_t *reply)
{
    static const uint8_t ipv4_over_ethernet[6] = {0, 1, 8, 0, MAC, IP};
    uint8_t *arp = reply + ETHERNET;
    uint8_t *sender = arp + 8;
    uint8_t *target = arp + 18;
    if (length < ETHERNET + ARP || memcmp(arp, ipv4_over_ethernet, sizeof ipv4_over_ethernet) != 0 ||
        ect_load_be16(arp + 6) != ARP_REQUEST || memcmp(target + MAC, own->ip, IP) != 0)
        return 0;
    ect_store_be16(arp + 6, ARP_REPLY);
    memcpy(target, sender, MAC + IP);
    memcpy(sender, mac, MAC);
    memcpy(sender + MAC, own->ip, IP);
    memset(arp + ARP, 0, SHORTEST - ETHERNET - ARP);
    return SHORTEST;
}

/* The echo's checksum with its type changed from 8 to 0 (RFC 1624). */
static bool echo_icmp(uint8_t *message, unsigned int length)
{
    if (length < 8 || message[0] != ECHO || message[1] != 0)
        return false;
    uint32_t checksum = ect_load_be16(message + 2) + (uint32_t)(ECHO << 8);
    message[0] = ECHO_REPLY;
    ect_store_be16(message + 2, (uint16_t)(checksum + (checksum >> 16)));
    return true;
}

/* An exchange of ports and addresses does not change the checksum. */
static bool echo_udp(uint8_t *message, unsigned int length)
{
    if (length < UDP_HEADER || ect_load_be16(message + 2) != PORT_ECHO || ect_load_be16(message) == PORT_ECHO)
        return false;
    swap(message, message + 2, 2);
    return true;
}

static uint16_t ip_reply(const ect_eoe_address_t *own, uint16_t length, uint8_t *reply)
{
    uint8_t *ip = reply + ETHERNET;
    if (length < ETHERNET + HEADER_LEAST || ip[0] >> 4 != 4)
        return 0;
    unsigned int header = (ip[0] & 0x0Fu) * 4;
    unsigned int total = ect_load_be16(ip + 2);
    if (header < HEADER_LEAST || total < header || total > (unsigned int)length - ETHERNET ||
        sum(ip, header) != 0xFFFF || (ect_load_be16(ip + 6) & FRAGMENTED) != 0 || memcmp(ip + 16, own->ip, IP) != 0)
        return 0;
    uint8_t *message = ip + header;
    if (!(ip[9] == ICMP && echo_icmp(message, total - header)) && !(ip[9] == UDP && echo_udp(message, total - header)))
        return 0;
    swap(ip + 12, ip + 16, IP);
    return length;
}

uint16_t ect_ip_reply(const ect_eoe_address_t *own, const uint8_t *frame, uint16_t length, uint8_t *reply)
{
    static const uint8_t all[MAC] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    uint8_t mac[MAC];
    if ((own->known & ECT_EOE_HAS_IP) == 0 || length < ETHERNET || length > ECT_EOE_FRAME)
        return 0;
    ect_ip_mac(own, mac);
    if (memcmp(frame, mac, MAC) != 0 && memcmp(frame, all, MAC) != 0)
        return 0;
    memcpy(reply, frame, length);
    memcpy(reply, frame + MAC, MAC);
    memcpy(reply + MAC, mac, MAC);
    switch (ect_load_be16(frame + 2 * MAC)) {
    case TYPE_ARP:
        return arp_reply(own, mac, length, reply);
    case TYPE_IP:
        return ip_reply(own, length, reply);
    default:
        return 0;
    }
}
