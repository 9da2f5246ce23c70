/* SPDX-License-Identifier: MIT */
/* CF-085: Ethernet over EtherCAT, as far as it does not depend on the slave's application. */
#include <string.h>

#include "cases/beyond.h"
#include "cases/ethernet.h"

enum { NO_IP = 0x0201, NO_DHCP = 0x0202, NO_FILTER = 0x0401 };
enum { HEADER = CF_EOE_HEADER, UNIT = CF_EOE_UNIT, FLAGS = CF_EOE_FLAGS, MAC = CF_EOE_MAC, ADDRESS = CF_EOE_ADDRESS };
enum { MAIL_HEADER = 6, LAST = 0x0100, QUIET_MS = 200, OVERSIZE_UNITS = 0x3F };
enum {
    FRAME_MOST = CF_EOE_MOST,
    FRAME_LEAST = CF_EOE_LEAST,
    ARP = 42,
    ETHERTYPE_ARP = 0x0806,
    ETHERTYPE_TEST = 0x88B5
};

void cf_eoe_send(cf_t *c, uint8_t type, uint16_t word, const void *data, uint16_t length, bool last)
{
    uint8_t mail[CF_MAX_MAIL];
    ect_store_le16(mail, (uint16_t)(type | (last ? LAST : 0)));
    ect_store_le16(mail + 2, word);
    memcpy(mail + HEADER, data, length);
    cf_send_mail(c, CF_MBX_EOE, mail, (uint16_t)(HEADER + length));
}

static uint8_t type_of(cf_t *c, const cf_mail_t *mail)
{
    cf_expect_that(c, mail->length >= HEADER, "an EoE mail: expected at least 4 bytes, got %u", mail->length);
    return mail->data[0] & 0x0F;
}

/* Reads the reply of a service; skips frames of the slave. @return the result of the service */
uint16_t cf_eoe_reply(cf_t *c, uint8_t type, cf_mail_t *mail)
{
    do
        cf_receive(c, CF_MBX_EOE, mail);
    while (type_of(c, mail) == CF_EOE_FRAGMENT || type_of(c, mail) == CF_EOE_TIMESTAMP);
    cf_expect(c, "EoE type of the reply", type, type_of(c, mail));
    return ect_load_le16(mail->data + 2);
}

static void expect_result(cf_t *c, const char *what, uint16_t result, uint16_t allowed)
{
    cf_expect_that(c, result == CF_EOE_DONE || result == CF_EOE_UNSUPPORTED || result == allowed || result == NO_DHCP,
                   "%s: expected result 0x0000, 0x0002, 0x0202 or 0x%04X, got 0x%04X", what, allowed, result);
}

/* --- services ----------------------------------------------------------------------------------------------------- */

static void take_host(const cf_mail_t *mail, cf_eoe_host_t *h)
{
    const uint32_t flags = mail->length >= HEADER + FLAGS ? ect_load_le32(mail->data + HEADER) : 0;
    const uint16_t ip_at = FLAGS + ((flags & CF_EOE_HAS_MAC) != 0 ? MAC : 0);
    h->length = (uint16_t)(mail->length - HEADER);
    memcpy(h->data, mail->data + HEADER, h->length);
    if ((flags & CF_EOE_HAS_MAC) != 0 && h->length >= FLAGS + MAC)
        memcpy(h->mac, h->data + FLAGS, MAC);
    if ((flags & CF_EOE_HAS_IP) == 0 || h->length < ip_at + ADDRESS)
        return;
    for (unsigned int i = 0; i < ADDRESS; i++)
        h->ip[i] = h->data[ip_at + (ADDRESS - 1u) - i]; /* the service has the octets in reverse order */
    h->has_ip = ect_load_le32(h->ip) != 0;
}

void cf_eoe_get_ip(cf_t *c, cf_eoe_host_t *h)
{
    cf_mail_t mail;
    cf_step(c, "get IP");
    cf_eoe_send(c, CF_EOE_GET_IP, 0, "", 0, true);
    uint16_t result = cf_eoe_reply(c, CF_EOE_IP, &mail);
    expect_result(c, "get IP", result, NO_IP);
    if (result == CF_EOE_DONE)
        take_host(&mail, h);
}

/* Sets the present parameters, so nothing changes. */
static void set_ip(cf_t *c, const cf_eoe_host_t *h)
{
    const uint8_t nothing[FLAGS] = {0};
    cf_mail_t mail;
    cf_step(c, "set IP to the present parameters");
    cf_eoe_send(c, CF_EOE_SET_IP, 0, h->length > 0 ? h->data : nothing, h->length > 0 ? h->length : FLAGS, true);
    expect_result(c, "set IP", cf_eoe_reply(c, CF_EOE_WAS_SET, &mail), NO_IP);
}

static void filter(cf_t *c)
{
    cf_mail_t mail;
    cf_step(c, "get filter");
    cf_eoe_send(c, CF_EOE_GET_FILTER, 0, "", 0, true);
    uint16_t result = cf_eoe_reply(c, CF_EOE_FILTER, &mail);
    expect_result(c, "get filter", result, NO_FILTER);
    if (result != CF_EOE_DONE)
        return;
    cf_step(c, "set filter to the present filter");
    cf_eoe_send(c, CF_EOE_SET_FILTER, 0, mail.data + HEADER, (uint16_t)(mail.length - HEADER), true);
    expect_result(c, "set filter", cf_eoe_reply(c, CF_EOE_FILTER_WAS_SET, &mail), NO_FILTER);
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

/* @return the largest size of a fragment except the last one: whole units that fit the mailbox */
uint16_t cf_eoe_most(const cf_t *c)
{
    return (uint16_t)((c->mailbox.out_size - MAIL_HEADER - HEADER) / UNIT * UNIT);
}

void cf_eoe_send_fragment(cf_t *c, const uint8_t *frame, uint16_t length, uint16_t from, uint16_t size, uint8_t number,
                          unsigned int fragment)
{
    const uint16_t units = (uint16_t)(fragment == 0 ? (length + UNIT - 1) / UNIT : from / UNIT);
    const uint16_t word = (uint16_t)(fragment | (unsigned int)units << 6 | (unsigned int)number << 12);
    cf_eoe_send(c, CF_EOE_FRAGMENT, word, frame + from, size, from + size == length);
}

static void broadcast(uint8_t *frame, uint16_t type)
{
    memset(frame, 0, FRAME_MOST);
    memset(frame, 0xFF, MAC);
    memcpy(frame + MAC, "\x02\0\0\0\0\x01", MAC);
    ect_store_be16(frame + 2 * MAC, type);
}

/* Writes an ARP request for the slave's address, from an address of the same subnet. */
void cf_eoe_arp(uint8_t *frame, const cf_eoe_host_t *h)
{
    static const uint8_t kind[] = {0, 1, 8, 0, 6, 4, 0, 1};
    broadcast(frame, ETHERTYPE_ARP);
    memcpy(frame + 14, kind, sizeof kind);
    memcpy(frame + 22, frame + MAC, MAC);
    memcpy(frame + 28, h->ip, ADDRESS);
    frame[31] ^= 0x55;
    memcpy(frame + 38, h->ip, ADDRESS);
}

/* Reads the next fragment; skips replies to time stamp requests. */
static bool next_fragment(cf_t *c, cf_mail_t *mail, uint32_t ms)
{
    bool came = cf_receive_mail(c, mail, ms);
    while (came && mail->type == CF_MBX_EOE && type_of(c, mail) == CF_EOE_TIMESTAMP)
        came = cf_receive_mail(c, mail, ms);
    return came;
}

/* Assembles the next frame of the slave and checks its fragments. @return bytes, 0: none within `ms` */
uint16_t cf_eoe_receive_frame(cf_t *c, uint8_t *frame, uint32_t ms)
{
    cf_mail_t mail;
    uint16_t length = 0;
    for (unsigned int fragment = 0; next_fragment(c, &mail, fragment == 0 ? ms : CF_MAIL_MS); fragment++) {
        cf_expect(c, "type of a mail with a frame of the slave", CF_MBX_EOE, mail.type);
        cf_expect(c, "EoE type of a frame of the slave", CF_EOE_FRAGMENT, type_of(c, &mail));
        const uint16_t word = ect_load_le16(mail.data + 2), size = (uint16_t)(mail.length - HEADER);
        const bool last = (mail.data[1] & 1) != 0;
        cf_expect_range(c, "number of the fragment", fragment, fragment, word & 0x3F);
        cf_expect_that(c, fragment == 0 || (word >> 6 & 0x3F) * UNIT == length,
                       "offset of the fragment: expected %u bytes, got %u", length, (word >> 6 & 0x3F) * UNIT);
        cf_expect_that(c, last || (size > 0 && size % UNIT == 0),
                       "a fragment before the last: expected a multiple of 32 bytes, got %u", size);
        cf_expect_that(c, length + size <= FRAME_MOST, "a frame: expected at most %d bytes, got %u", (int)FRAME_MOST,
                       (unsigned int)length + size);
        memcpy(frame + length, mail.data + HEADER, size);
        length = (uint16_t)(length + size);
        if (last)
            return length;
    }
    cf_expect_that(c, length == 0, "a frame of the slave: expected complete, got only %u bytes", length);
    return 0;
}

static bool is_arp_reply(const uint8_t *frame, uint16_t length, const cf_eoe_host_t *h)
{
    return length >= ARP && ect_load_be16(frame + 12) == ETHERTYPE_ARP && ect_load_be16(frame + 20) == 2 &&
           memcmp(frame + 28, h->ip, ADDRESS) == 0;
}

void cf_eoe_take(cf_t *c, cf_eoe_host_t *h, uint32_t ms)
{
    uint8_t frame[FRAME_MOST];
    uint16_t length = cf_eoe_receive_frame(c, frame, ms);
    if (!is_arp_reply(frame, length, h))
        return;
    h->replies++;
    memcpy(h->mac, frame + 22, MAC);
}

/* Sends a whole frame in fragments of `size` bytes, and reads the slave's frames in between: an unread one may block
 * it.
 * @param skip  fragment to leave out; -1: none */
void cf_eoe_send_frame(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame, uint16_t length, uint16_t size, uint8_t number,
                       int skip)
{
    int fragment = 0;
    for (uint16_t from = 0; from < length; from = (uint16_t)(from + size), fragment++) {
        const uint16_t left = (uint16_t)(length - from);
        while (cf_mail_waits(c))
            cf_eoe_take(c, h, CF_MAIL_MS);
        if (fragment != skip)
            cf_eoe_send_fragment(c, frame, length, from, left < size ? left : size, number, (unsigned int)fragment);
    }
}

/* Expects exactly `wanted` replies since the last call. */
void cf_eoe_expect_replies(cf_t *c, cf_eoe_host_t *h, const char *what, unsigned int wanted)
{
    uint64_t until = cf_now_ns() + CF_MAIL_MS * UINT64_C(1000000);
    while (h->replies < wanted && cf_now_ns() < until)
        cf_eoe_take(c, h, CF_MAIL_MS);
    until = cf_now_ns() + QUIET_MS * UINT64_C(1000000);
    while (cf_now_ns() < until)
        cf_eoe_take(c, h, QUIET_MS);
    cf_expect_range(c, what, wanted, wanted, h->replies);
    h->replies = 0;
}

static void frames(cf_t *c, cf_eoe_host_t *h)
{
    uint8_t frame[FRAME_MOST];
    const uint16_t most = cf_eoe_most(c);
    cf_step(c, "a broadcast of the size of the MTU, in fragments, with an unassigned EtherType");
    broadcast(frame, ETHERTYPE_TEST);
    cf_eoe_send_frame(c, h, frame, FRAME_MOST, most, 1, -1);
    cf_step(c, "the same frame without one fragment, then without the last one");
    cf_eoe_send_frame(c, h, frame, FRAME_MOST, most, 2, 1);
    cf_eoe_send_frame(c, h, frame, FRAME_MOST, most, 3, (FRAME_MOST - 1) / most);
    cf_step(c, "fragments of more than a frame");
    for (unsigned int fragment = 0; fragment <= FRAME_MOST / most + 1u && fragment < 0x3F; fragment++)
        cf_eoe_send(c, CF_EOE_FRAGMENT,
                    (uint16_t)(fragment | (fragment == 0 ? OVERSIZE_UNITS : fragment * most / UNIT) << 6 | 4 << 12),
                    frame, most, false);
    cf_step(c, "the next frame is processed");
    if (!h->has_ip)
        return;
    cf_eoe_arp(frame, h);
    cf_eoe_send_frame(c, h, frame, FRAME_LEAST, most, 5, -1);
    cf_eoe_expect_replies(c, h, "replies to one ARP request", 1);
    cf_step(c, "an ARP request without its first fragment, one without its last, and a complete one");
    cf_eoe_send_frame(c, h, frame, FRAME_LEAST, UNIT, 6, 0);
    cf_eoe_send_frame(c, h, frame, FRAME_LEAST, UNIT, 7, 1);
    cf_eoe_send_frame(c, h, frame, FRAME_LEAST, UNIT, 8, -1);
    cf_eoe_expect_replies(c, h, "replies to the complete request", 1);
}

void cf_ethernet(cf_t *c)
{
    cf_eoe_host_t host = {.length = 0}, later = {.length = 0};
    cf_go(c, CF_PREOP);
    cf_eoe_get_ip(c, &host);
    set_ip(c, &host);
    filter(c);
    if (cf_eoe_most(c) == 0)
        cf_skip(c, "the mailbox is too small for a fragment");
    frames(c, &host);
    cf_eoe_get_ip(c, &later);
    cf_expect_range(c, "bytes of the parameters afterwards", host.length, host.length, later.length);
    cf_expect_bytes(c, "its parameters afterwards", host.data, later.data, host.length);
    if (host.has_ip)
        cf_note(c, "the slave replies as %u.%u.%u.%u", host.ip[0], host.ip[1], host.ip[2], host.ip[3]);
    else
        cf_note(c, "the slave has no address: the arrival of frames cannot be judged");
}
