/* SPDX-License-Identifier: MIT */
/*
 * CF-E06, CF-E09, CF-E10, CF-E11: Ethernet over EtherCAT as masters use it: their ways to set an address, pings, a
 * pause of the master, random fragments, and the description of the slave.
 */
#include <string.h>

#include "cases/beyond.h"
#include "cases/ethernet.h"
#include "steps/esi.h"

enum { HEADER = CF_EOE_HEADER, UNIT = CF_EOE_UNIT, ADDRESS = CF_EOE_ADDRESS, ROOM = CF_EOE_ROOM };

/* --- addresses ---------------------------------------------------------------------------------------------------- */

/* @return whether the slave replies to ARP for this address */
static bool replies_as(cf_t *c, cf_eoe_host_t *h, const uint8_t ip[ADDRESS])
{
    enum { REPLY_MS = 500 };
    uint8_t frame[ROOM] = {0};
    memcpy(h->ip, ip, ADDRESS);
    h->replies = 0;
    cf_step(c, "ARP request for %u.%u.%u.%u", ip[0], ip[1], ip[2], ip[3]);
    cf_eoe_arp(frame, h);
    cf_eoe_send_frame(c, h, frame, CF_EOE_LEAST, cf_eoe_most(c), 0, -1);
    const uint64_t until = cf_now_ns() + REPLY_MS * UINT64_C(1000000);
    while (h->replies == 0 && cf_now_ns() < until)
        cf_eoe_take(c, h, REPLY_MS);
    return h->replies > 0;
}

/* Checks the order of the octets: the slave must reply to ARP for the address as printed. */
static bool expect_order(cf_t *c, cf_eoe_host_t *h, const char *master, const uint8_t ip[ADDRESS])
{
    const uint8_t reversed[ADDRESS] = {ip[3], ip[2], ip[1], ip[0]};
    if (replies_as(c, h, ip))
        return true;
    cf_expect_that(c, !replies_as(c, h, reversed),
                   "the address that %s set: expected a reply to ARP as %u.%u.%u.%u, got one as %u.%u.%u.%u", master,
                   ip[0], ip[1], ip[2], ip[3], ip[3], ip[2], ip[1], ip[0]);
    return false;
}

void cf_eoe_masters(cf_t *c)
{
    static const uint8_t by_soem[ADDRESS] = {192, 0, 2, 78}, by_igh[ADDRESS] = {192, 0, 2, 79};
    uint8_t got[ADDRESS] = {0}, data[CF_EOE_PARAMETERS];
    char what[200];
    cf_eoe_host_t h = {.length = 0};
    cf_eoe_begin(c, &h);
    cf_eoe_require_address(c, &h, 77);
    cf_step(c, "SOEM: configuration, PREOP, set IP, get IP");
    bool done = cf_soem_address(c, by_soem, got, what, sizeof what);
    cf_expect_that(c, done, "SOEM: %s", what);
    cf_expect_bytes(c, "the address set and read by SOEM", by_soem, got, ADDRESS);
    cf_go(c, CF_INIT); /* SOEM's mail counter is another */
    cf_go(c, CF_PREOP);
    bool replies = expect_order(c, &h, "SOEM", by_soem);
    cf_step(c, "set IP as IgH writes it: the full layout, without the last flag");
    uint16_t length = cf_eoe_parameters_of(data, by_igh[3], true);
    cf_expect(c, "result", CF_EOE_DONE, cf_eoe_set_ip(c, data, length, false));
    cf_eoe_expect_address(c, "the address in IgH's layout", by_igh[3]);
    replies = expect_order(c, &h, "IgH", by_igh) && replies;
    if (!replies)
        cf_note(c, "the slave does not reply to ARP: the order of the octets is compared with get IP only");
}

/* --- pings -------------------------------------------------------------------------------------------------------- */

static void expect_echo(cf_t *c, const uint8_t *frame, uint16_t length)
{
    cf_expect_that(c, cf_eoe_await_echo(c, frame, length, CF_MAIL_MS),
                   "a ping in a frame of %u bytes: expected its echo, got none", length);
}

/* Reads AL status, but no mails. */
static void fetch_nothing(cf_t *c)
{
    enum { PAUSES = 100, PAUSE_MS = 100 };
    cf_step(c, "the master reads no mail for %d s", PAUSES * PAUSE_MS / 1000);
    for (unsigned int i = 0; i < PAUSES; i++) {
        cf_sleep_ms(c, PAUSE_MS);
        cf_expect(c, "AL status meanwhile", CF_PREOP, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
    }
}

void cf_eoe_pings(cf_t *c)
{
    enum { SHORT = 56 + 42, MEGABYTE = 713, LONG_MS = 600000, FEW = 70 };
    uint8_t frame[ROOM] = {0};
    cf_eoe_host_t h;
    cf_eoe_begin_frames(c, &h);
    cf_step(c, "a ping of 56 bytes");
    cf_eoe_ping(frame, &h, SHORT);
    cf_eoe_send_frame(c, &h, frame, SHORT, cf_eoe_most(c), 1, -1);
    if (!cf_eoe_await_echo(c, frame, SHORT, CF_MAIL_MS))
        cf_skip(c, "the slave does not reply to ping");
    if (c->whole)
        cf_extend(c, LONG_MS);
    const unsigned int count = c->whole ? MEGABYTE : FEW;
    cf_step(c, "%u pings of 1472 bytes", count);
    cf_eoe_ping(frame, &h, CF_EOE_MOST);
    for (unsigned int i = 0; i < count; i++) {
        cf_eoe_send_frame(c, &h, frame, CF_EOE_MOST, cf_eoe_most(c), (uint8_t)(i & 0x0F), -1);
        expect_echo(c, frame, CF_EOE_MOST);
    }
    cf_step(c, "one more ping, whose echo is read late");
    cf_eoe_send_frame(c, &h, frame, CF_EOE_MOST, cf_eoe_most(c), 1, -1);
    fetch_nothing(c);
    expect_echo(c, frame, CF_EOE_MOST);
    cf_eoe_arp(frame, &h);
    cf_eoe_expect_good_frame(c, &h, frame);
    cf_note(c, "%u pings of 1472 bytes%s", count, c->whole ? "" : "; --long sends a megabyte");
}

/* --- random fragments --------------------------------------------------------------------------------------------- */

/* The fragment expected next by a receiver; two of three are this fragment, so that frames grow. */
typedef struct next {
    unsigned int number, units, frame;
} next_t;

/* Writes the start of a frame with an unassigned EtherType and an unused address, which a slave drops. */
static void start_of_frame(uint8_t *data)
{
    enum { TYPE_TEST = 0x88B5 };
    memcpy(data, "\x02\0\0\0\0\x02\x02\0\0\0\0\x01", 2 * CF_EOE_MAC);
    ect_store_be16(data + 2 * CF_EOE_MAC, TYPE_TEST);
}

static void send_random_fragment(cf_t *c, next_t *next)
{
    enum { PORT_BITS = 0xF0, FLAG_BITS = 0x0700 };
    uint8_t data[CF_MAX_MAIL];
    const bool expected = cf_random(c, 3) != 0;
    const unsigned int number = expected ? next->number : cf_random(c, 64);
    const unsigned int units = expected && number > 0 ? next->units : cf_random(c, 64);
    const unsigned int frame = expected ? next->frame : cf_random(c, 16);
    const uint16_t room = (uint16_t)(c->mailbox.out_size - 6 - HEADER);
    uint16_t length = expected ? (uint16_t)(UNIT * (1 + cf_random(c, room / UNIT))) : (uint16_t)cf_random(c, room + 1u);
    uint16_t flags = cf_random(c, 4) == 0 ? (uint16_t)(cf_random(c, 8) << 8) : 0;
    flags |= expected ? 0 : (uint16_t)(cf_random(c, 16) << 4);
    for (uint16_t i = 0; i < length; i++)
        data[i] = (uint8_t)cf_random(c, 256);
    if (number == 0 && length >= 2 * CF_EOE_MAC + 2)
        start_of_frame(data);
    uint8_t mail[CF_MAX_MAIL];
    ect_store_le16(mail, flags);
    ect_store_le16(mail + 2, (uint16_t)(number | units << 6 | frame << 12));
    memcpy(mail + HEADER, data, length);
    cf_send_mail(c, CF_MBX_EOE, mail, (uint16_t)(HEADER + length));
    next->units = (number == 0 ? 0 : units) + length / UNIT;
    next->number = (flags & 0x0100) != 0 ? 0 : (number + 1) % 64;
    next->frame = frame;
}

void cf_eoe_random(cf_t *c)
{
    enum { MILLION = 1000000, FEW = 2000, LONG_MS = 7200000 };
    uint8_t frame[ROOM] = {0};
    cf_mail_t mail;
    cf_eoe_host_t h, before = {.length = 0}, after = {.length = 0};
    next_t next = {0};
    cf_eoe_begin_frames(c, &h);
    cf_eoe_get_ip(c, &before);
    if (c->whole)
        cf_extend(c, LONG_MS);
    const unsigned int count = c->whole ? MILLION : FEW;
    cf_step(c, "%u random fragments", count);
    for (unsigned int i = 0; i < count; i++) {
        send_random_fragment(c, &next);
        while (cf_mail_waits(c))
            (void)cf_receive_mail(c, &mail, CF_MAIL_MS);
    }
    cf_eoe_get_ip(c, &after);
    cf_expect_range(c, "bytes of the IP parameters afterwards", before.length, before.length, after.length);
    cf_expect_bytes(c, "the IP parameters afterwards", before.data, after.data, before.length);
    cf_eoe_arp(frame, &h);
    cf_eoe_expect_good_frame(c, &h, frame);
    cf_note(c, "%u mails%s", count, c->whole ? "" : "; --long sends a million");
}

/* --- description -------------------------------------------------------------------------------------------------- */

void cf_eoe_described(cf_t *c)
{
    enum { GENERAL = 30, GENERAL_EOE = 7, MAILBOX_LEAST = 42 };
    size_t length;
    const uint8_t *general = cf_sii_category(c, GENERAL, &length);
    const ect_esi_device_t *model = cf_esi_model(c);
    const bool offered = (c->facts.protocols & CF_PROTO_EOE) != 0;
    if (general && length > GENERAL_EOE)
        cf_expect_that(c, ((general[GENERAL_EOE] & 1) != 0) == offered,
                       "EoE in byte 7 of the General category: expected %d as in SII word 0x1C, got %u", offered,
                       general[GENERAL_EOE]);
    cf_expect_that(c, !model || model->mailbox.eoe == offered,
                   "EoE in the ESI file: expected %d as in SII word 0x1C, got %d", offered,
                   model && model->mailbox.eoe);
    if (!offered) {
        cf_note(c, "not offered");
        return;
    }
    cf_expect_that(c, c->mailbox.out_size >= MAILBOX_LEAST && c->mailbox.in_size >= MAILBOX_LEAST,
                   "mailboxes with EoE: expected at least %d bytes, got %u and %u", (int)MAILBOX_LEAST,
                   c->mailbox.out_size, c->mailbox.in_size);
}
