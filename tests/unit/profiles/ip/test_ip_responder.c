/* SPDX-License-Identifier: MIT */
/* The responder: ARP, ping and UDP echo for one address. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/ip/responder.h"
#include "wire/bytes.h"

enum { ETHERNET = 14, ARP_LENGTH = 42, IP = 14, MESSAGE = 34, PING = MESSAGE + 8 + 56 };
enum { ICMP = 1, TCP = 6, UDP = 17, NEVER_REPLIED = 0 };

static const ect_eoe_address_t own = {
    .known = ECT_EOE_HAS_MAC | ECT_EOE_HAS_IP, .mac = {2, 0, 0x5E, 0x10, 0x20, 0x30}, .ip = {192, 168, 10, 20}};
static const uint8_t peer_mac[6] = {0, 0x11, 0x22, 0x33, 0x44, 0x55}, peer_ip[4] = {192, 168, 10, 1};

/* RFC 1071: the sum over data with a right checksum is FFFFh. */
static uint16_t sum_of(const uint8_t *data, unsigned int length, uint32_t start)
{
    uint32_t total = start;
    for (unsigned int i = 0; i < length; i++)
        total += (uint32_t)data[i] << (i % 2 == 0 ? 8 : 0);
    while (total > 0xFFFF)
        total = (total & 0xFFFF) + (total >> 16);
    return (uint16_t)total;
}

static void put_checksum(uint8_t *at, const uint8_t *data, unsigned int length, uint32_t start)
{
    ect_store_be16(at, 0);
    ect_store_be16(at, (uint16_t)~sum_of(data, length, start));
}

static void put_ethernet(uint8_t *frame, const uint8_t *to, uint16_t type)
{
    memcpy(frame, to, 6);
    memcpy(frame + 6, peer_mac, 6);
    ect_store_be16(frame + 12, type);
}

static unsigned int arp(uint8_t *frame)
{
    static const uint8_t all[6] = {255, 255, 255, 255, 255, 255};
    static const uint8_t head[8] = {0, 1, 8, 0, 6, 4, 0, 1};
    memset(frame, 0, ARP_LENGTH);
    put_ethernet(frame, all, 0x0806);
    memcpy(frame + 14, head, sizeof head);
    memcpy(frame + 22, peer_mac, 6);
    memcpy(frame + 28, peer_ip, 4);
    memcpy(frame + 38, own.ip, 4);
    return ARP_LENGTH;
}

static void put_ip(uint8_t *frame, uint8_t protocol, unsigned int message)
{
    put_ethernet(frame, own.mac, 0x0800);
    memset(frame + IP, 0, 20);
    frame[IP] = 0x45;
    ect_store_be16(frame + IP + 2, (uint16_t)(20 + message));
    ect_store_be16(frame + IP + 6, 0x4000);
    frame[IP + 8] = 64;
    frame[IP + 9] = protocol;
    memcpy(frame + IP + 12, peer_ip, 4);
    memcpy(frame + IP + 16, own.ip, 4);
    put_checksum(frame + IP + 10, frame + IP, 20, 0);
}

static unsigned int ping(uint8_t *frame, unsigned int data)
{
    uint8_t *message = frame + MESSAGE;
    memset(message, 0, 8 + data);
    message[0] = 8;
    ect_store_be16(message + 4, 0x1234);
    for (unsigned int i = 0; i < data; i++)
        message[8 + i] = (uint8_t)(i * 3);
    put_checksum(message + 2, message, 8 + data, 0);
    put_ip(frame, ICMP, 8 + data);
    return MESSAGE + 8 + data;
}

static unsigned int udp(uint8_t *frame, uint16_t to)
{
    uint8_t *message = frame + MESSAGE;
    memset(message, 0, 8 + 20);
    ect_store_be16(message, 40000);
    ect_store_be16(message + 2, to);
    ect_store_be16(message + 4, 28);
    message[9] = 0xA5;
    put_checksum(message + 6, message, 28, (uint32_t)sum_of(peer_ip, 4, 0) + sum_of(own.ip, 4, 0) + UDP + 28u);
    put_ip(frame, UDP, 28);
    return MESSAGE + 28;
}

static void expect_addresses(const char *what, const uint8_t *reply)
{
    if (memcmp(reply, peer_mac, 6) != 0 || memcmp(reply + 6, own.mac, 6) != 0)
        fail_msg("%s: expected the addresses of Ethernet exchanged", what);
}

static void replies_to_arp(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    uint8_t reply[ECT_EOE_FRAME];
    unsigned int length = arp(frame);
    (void)state;
    assert_int_equal(ect_ip_reply(&own, frame, (uint16_t)length, reply), 60);
    expect_addresses("ARP", reply);
    assert_int_equal(ect_load_be16(reply + 20), 2);
    assert_memory_equal(reply + 22, own.mac, 6);
    assert_memory_equal(reply + 28, own.ip, 4);
    assert_memory_equal(reply + 32, peer_mac, 6);
    assert_memory_equal(reply + 38, peer_ip, 4);
}

static void replies_to_ping(void **state)
{
    static const unsigned int lengths[] = {0, 1, 56, 57, 1400, 1472};
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        uint8_t frame[ECT_EOE_FRAME];
        uint8_t reply[ECT_EOE_FRAME];
        unsigned int length = ping(frame, lengths[i]);
        if (ect_ip_reply(&own, frame, (uint16_t)length, reply) != length)
            fail_msg("ping of %u bytes: no reply", lengths[i]);
        expect_addresses("ping", reply);
        assert_int_equal(reply[MESSAGE], 0);
        assert_memory_equal(reply + IP + 12, own.ip, 4);
        assert_memory_equal(reply + IP + 16, peer_ip, 4);
        assert_int_equal(sum_of(reply + IP, 20, 0), 0xFFFF);
        assert_int_equal(sum_of(reply + MESSAGE, length - MESSAGE, 0), 0xFFFF);
        assert_memory_equal(reply + MESSAGE + 4, frame + MESSAGE + 4, length - MESSAGE - 4);
    }
}

/* Every checksum of a request, and so every carry, gives a right one in the reply. */
static void checksum_of_each_ping(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    uint8_t reply[ECT_EOE_FRAME];
    (void)state;
    for (unsigned int id = 0; id <= 0xFFFF; id++) {
        unsigned int length = ping(frame, 2);
        ect_store_be16(frame + MESSAGE + 4, (uint16_t)id);
        put_checksum(frame + MESSAGE + 2, frame + MESSAGE, 10, 0);
        if (ect_ip_reply(&own, frame, (uint16_t)length, reply) != length || sum_of(reply + MESSAGE, 10, 0) != 0xFFFF)
            fail_msg("identifier %04X: expected a reply with a right checksum", id);
    }
}

static void replies_to_udp(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    uint8_t reply[ECT_EOE_FRAME];
    unsigned int length = udp(frame, 7);
    (void)state;
    assert_int_equal(ect_ip_reply(&own, frame, (uint16_t)length, reply), length);
    assert_int_equal(ect_load_be16(reply + MESSAGE), 7);
    assert_int_equal(ect_load_be16(reply + MESSAGE + 2), 40000);
    assert_int_equal(sum_of(reply + MESSAGE, 28, (uint32_t)sum_of(peer_ip, 4, 0) + sum_of(own.ip, 4, 0) + UDP + 28u),
                     0xFFFF);
}

/* One 16-bit word of a good request is changed; the header checksum is made again unless that is the change. */
static void no_reply(void **state)
{
    static const struct {
        const char *what;
        char kind;
        uint16_t at, value;
        bool keeps_checksum;
    } rows[] = {
        {"another MAC address", 'p', 0, 0x0201, false},
        {"another type", 'p', 12, 0x86DD, false},
        {"a VLAN tag", 'p', 12, 0x8100, false},
        {"IP version 6", 'p', IP, 0x6500, false},
        {"a header of 16 bytes", 'p', IP, 0x4400, false},
        {"longer than the frame", 'p', IP + 2, 300, false},
        {"shorter than its header", 'p', IP + 2, 19, false},
        {"a first fragment", 'p', IP + 6, 0x2000, false},
        {"a later fragment", 'p', IP + 6, 0x0001, false},
        {"TCP", 'p', IP + 8, 0x4000 | TCP, false},
        {"a wrong header checksum", 'p', IP + 10, 0x1234, true},
        {"another address", 'p', IP + 18, 0x0A15, false},
        {"an echo reply", 'p', MESSAGE, 0x0000, false},
        {"an echo with code 1", 'p', MESSAGE, 0x0801, false},
        {"no room for an echo's header", 'p', IP + 2, 27, false},
        {"UDP to another port", 'u', MESSAGE + 2, 80, false},
        {"UDP from port 7, which would never end", 'u', MESSAGE, 7, false},
        {"no room for a UDP header", 'u', IP + 2, 27, false},
        {"ARP: a reply", 'a', 20, 2, true},
        {"ARP: another hardware", 'a', 14, 6, true},
        {"ARP: another protocol", 'a', 16, 0x86DD, true},
        {"ARP: hardware addresses of 8 bytes", 'a', 18, 0x0804, true},
        {"ARP: protocol addresses of 16 bytes", 'a', 18, 0x0610, true},
        {"ARP: another address", 'a', 40, 0x0A15, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[ECT_EOE_FRAME];
        uint8_t reply[ECT_EOE_FRAME];
        unsigned int length = rows[i].kind == 'a' ? arp(frame) : rows[i].kind == 'u' ? udp(frame, 7) : ping(frame, 56);
        ect_store_be16(frame + rows[i].at, rows[i].value);
        if (!rows[i].keeps_checksum)
            put_checksum(frame + IP + 10, frame + IP, 20, 0);
        unsigned int got = ect_ip_reply(&own, frame, (uint16_t)length, reply);
        if (got != 0)
            fail_msg("%s: expected no reply, got %u bytes", rows[i].what, got);
    }
}

static void every_length_is_safe(void **state)
{
    (void)state;
    for (unsigned int length = 0; length < PING; length++) {
        uint8_t frame[ECT_EOE_FRAME];
        uint8_t reply[ECT_EOE_FRAME];
        (void)ping(frame, 56);
        assert_int_equal(ect_ip_reply(&own, frame, (uint16_t)length, reply), 0);
        (void)arp(frame);
        memcpy(reply, frame, ARP_LENGTH); /* the end of another request, which is no part of this one */
        assert_int_equal(ect_ip_reply(&own, frame, (uint16_t)length, reply), length < ARP_LENGTH ? 0 : 60);
    }
}

static void address_unknown(void **state)
{
    ect_eoe_address_t address = own;
    uint8_t frame[ECT_EOE_FRAME];
    uint8_t reply[ECT_EOE_FRAME];
    uint8_t mac[6];
    static const uint8_t made[6] = {2, 0, 192, 168, 10, 20};
    uint16_t length = (uint16_t)arp(frame);
    (void)state;
    address.known = ECT_EOE_HAS_MAC;
    assert_int_equal(ect_ip_reply(&address, frame, length, reply), NEVER_REPLIED);
    address.known = ECT_EOE_HAS_IP;
    assert_int_equal(ect_ip_reply(&address, frame, length, reply), 60);
    ect_ip_mac(&address, mac);
    assert_memory_equal(mac, made, 6);
    assert_memory_equal(reply + 6, made, 6);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"RFC 826: ARP for the own address has a reply", replies_to_arp, NULL, NULL, NULL},
        {"RFC 792: pings of 0 to 1472 bytes have a reply", replies_to_ping, NULL, NULL, NULL},
        {"RFC 1624: the checksum of a reply is right for each request", checksum_of_each_ping, NULL, NULL, NULL},
        {"RFC 862: UDP to port 7 is returned", replies_to_udp, NULL, NULL, NULL},
        {"Other frames, and wrong ones, have none", no_reply, NULL, NULL, NULL},
        {"A frame that is cut off anywhere has none", every_length_is_safe, NULL, NULL, NULL},
        {"Without an IP address nothing is replied to; without a MAC one is made", address_unknown, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("IP responder", tests, NULL, NULL);
}
