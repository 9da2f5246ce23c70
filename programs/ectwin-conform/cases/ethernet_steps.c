/* SPDX-License-Identifier: MIT */
/* Steps of Ethernet over EtherCAT: a slave's address for a case, frames with a reply. */
#include <string.h>

#include "cases/ethernet.h"

enum { HEADER = CF_EOE_HEADER, FLAGS = CF_EOE_FLAGS, UNIT = CF_EOE_UNIT, ADDRESS = CF_EOE_ADDRESS };
enum { PARAMETERS = CF_EOE_PARAMETERS, ROOM = CF_EOE_ROOM, GOOD_NUMBER = 15 };
enum { ETHERNET = 14, IP_HEADER = 20, ICMP_HEADER = 8, ICMP = 1, ECHO = 8, TYPE_IP = 0x0800 };
enum { NET = CF_EOE_HAS_IP | CF_EOE_HAS_SUBNET | CF_EOE_HAS_GATEWAY };

/* --- address ------------------------------------------------------------------------------------------------------ */

uint16_t cf_eoe_parameters_of(uint8_t *data, uint8_t host, bool full)
{
    const uint8_t packed[] = {host, 2, 0, 192, 0, 255, 255, 255, 1, 2, 0, 192};
    const unsigned int at = FLAGS + (full ? CF_EOE_MAC : 0u);
    memset(data, 0, PARAMETERS);
    data[0] = NET;
    memcpy(data + at, packed, sizeof packed);
    return full ? PARAMETERS : FLAGS + sizeof packed;
}

uint16_t cf_eoe_set_ip(cf_t *c, const uint8_t *data, uint16_t length, bool last)
{
    cf_mail_t mail;
    cf_eoe_send(c, CF_EOE_SET_IP, 0, data, length, last);
    return cf_eoe_reply(c, CF_EOE_WAS_SET, &mail);
}

static void put_back(cf_t *c, const uint8_t *data, size_t length)
{
    cf_step(c, "set IP to the previous parameters");
    const uint16_t result = cf_eoe_set_ip(c, data, (uint16_t)length, true);
    if (result != CF_EOE_DONE)
        cf_fail(c, "restoring the IP parameters: result 0x%04X", result);
}

/* Restores address, subnet and gateway after the case, 0.0.0.0 for an unknown one; not the MAC address, which alone
 * requests DHCP. */
static void keep(cf_t *c, const cf_eoe_host_t *before)
{
    uint8_t data[FLAGS + 3 * ADDRESS] = {NET};
    const uint8_t known = before->length > FLAGS ? before->data[0] : 0;
    unsigned int from = FLAGS + ((known & CF_EOE_HAS_MAC) != 0 ? CF_EOE_MAC : 0u), to = FLAGS;
    for (uint8_t flag = CF_EOE_HAS_IP; flag <= CF_EOE_HAS_GATEWAY; flag = (uint8_t)(flag << 1), to += ADDRESS) {
        if ((known & flag) == 0 || from + ADDRESS > before->length)
            continue;
        memcpy(data + to, before->data + from, ADDRESS);
        from += ADDRESS;
    }
    cf_keep(c, put_back, data, sizeof data);
}

void cf_eoe_begin(cf_t *c, cf_eoe_host_t *before)
{
    cf_go(c, CF_PREOP);
    if (cf_eoe_most(c) == 0)
        cf_skip(c, "the mailbox is too small for a fragment");
    cf_eoe_get_ip(c, before);
}

void cf_eoe_expect_address(cf_t *c, const char *what, uint8_t host)
{
    uint8_t wanted[PARAMETERS];
    cf_eoe_host_t now = {.length = 0};
    const uint16_t length = cf_eoe_parameters_of(wanted, host, false);
    cf_eoe_get_ip(c, &now);
    cf_expect_that(c, now.length >= length, "%s: expected at least %u bytes of parameters, got %u", what, length,
                   now.length);
    cf_expect_bits(c, "flags of the parameters", NET, NET, now.data[0]);
    const unsigned int at = FLAGS + ((now.data[0] & CF_EOE_HAS_MAC) != 0 ? CF_EOE_MAC : 0u);
    cf_expect_that(c, now.length >= at + length - FLAGS, "%s: expected %u bytes after the MAC, got %u", what,
                   length - FLAGS, now.length - at);
    cf_expect_bytes(c, what, wanted + FLAGS, now.data + at, length - FLAGS);
}

void cf_eoe_require_address(cf_t *c, const cf_eoe_host_t *before, uint8_t host)
{
    uint8_t data[PARAMETERS];
    cf_step(c, "set IP 192.0.2.%u/24, gateway 192.0.2.1, packed", host);
    uint16_t result = cf_eoe_set_ip(c, data, cf_eoe_parameters_of(data, host, false), true);
    if (result != CF_EOE_DONE)
        cf_skip(c, "the slave accepts no address: result 0x%04X", result);
    keep(c, before);
}

/* --- frames with a reply ------------------------------------------------------------------------------------------ */

void cf_eoe_begin_frames(cf_t *c, cf_eoe_host_t *h)
{
    uint8_t frame[ROOM] = {0};
    *h = (cf_eoe_host_t){.length = 0};
    cf_eoe_begin(c, h);
    if (!h->has_ip) {
        static const uint8_t lent[ADDRESS] = {192, 0, 2, 77};
        cf_eoe_require_address(c, h, lent[3]);
        memcpy(h->ip, lent, ADDRESS);
        h->has_ip = true;
    }
    cf_step(c, "ARP request for %u.%u.%u.%u", h->ip[0], h->ip[1], h->ip[2], h->ip[3]);
    cf_eoe_arp(frame, h);
    cf_eoe_send_frame(c, h, frame, CF_EOE_LEAST, cf_eoe_most(c), 0, -1);
    const uint64_t until = cf_now_ns() + CF_MAIL_MS * UINT64_C(1000000);
    while (h->replies == 0 && cf_now_ns() < until)
        cf_eoe_take(c, h, CF_MAIL_MS);
    if (h->replies == 0)
        cf_skip(c, "the slave does not reply to ARP: the arrival of frames cannot be judged");
    h->replies = 0;
}

static uint16_t checksum(const uint8_t *data, unsigned int length)
{
    uint32_t sum = 0;
    for (unsigned int i = 0; i < length; i += 2)
        sum += i + 1 < length ? ect_load_be16(data + i) : (uint32_t)(data[i] << 8);
    sum = (sum & 0xFFFF) + (sum >> 16);
    return (uint16_t)~(sum + (sum >> 16));
}

void cf_eoe_ping(uint8_t *frame, const cf_eoe_host_t *h, uint16_t length)
{
    uint8_t *ip = frame + ETHERNET, *icmp = ip + IP_HEADER;
    memset(frame, 0, length);
    memcpy(frame, h->mac, CF_EOE_MAC);
    memcpy(frame + CF_EOE_MAC, "\x02\0\0\0\0\x01", CF_EOE_MAC);
    ect_store_be16(frame + 12, TYPE_IP);
    ip[0] = 0x45;
    ect_store_be16(ip + 2, (uint16_t)(length - ETHERNET));
    ip[8] = 64;
    ip[9] = ICMP;
    memcpy(ip + 12, h->ip, ADDRESS);
    ip[14 + 1] ^= 0x55;
    memcpy(ip + 16, h->ip, ADDRESS);
    ect_store_be16(ip + 10, checksum(ip, IP_HEADER));
    icmp[0] = ECHO;
    for (unsigned int i = ICMP_HEADER; i + ETHERNET + IP_HEADER < length; i++)
        icmp[i] = (uint8_t)(i * 7 + i / 256);
    ect_store_be16(icmp + 2, checksum(icmp, (unsigned int)(length - ETHERNET - IP_HEADER)));
}

static bool is_echo(const uint8_t *reply, uint16_t got, const uint8_t *frame, uint16_t length)
{
    enum { CONTENT = ETHERNET + IP_HEADER + 4 };
    return got >= length && ect_load_be16(reply + 12) == TYPE_IP && reply[ETHERNET + 9] == ICMP &&
           reply[ETHERNET + IP_HEADER] == 0 && memcmp(reply + CONTENT, frame + CONTENT, length - CONTENT) == 0;
}

bool cf_eoe_await_echo(cf_t *c, const uint8_t *frame, uint16_t length, uint32_t ms)
{
    uint8_t reply[ROOM];
    uint16_t got = cf_eoe_receive_frame(c, reply, ms);
    while (got > 0 && !is_echo(reply, got, frame, length))
        got = cf_eoe_receive_frame(c, reply, ms);
    return got > 0;
}

void cf_eoe_expect_good_frame(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame)
{
    cf_step(c, "a good frame");
    cf_eoe_send_frame(c, h, frame, CF_EOE_LEAST, UNIT, GOOD_NUMBER, -1);
    cf_eoe_expect_replies(c, h, "replies to a good frame", 1);
}
