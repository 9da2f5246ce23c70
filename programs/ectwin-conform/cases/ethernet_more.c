/* SPDX-License-Identifier: MIT */
/*
 * CF-E01 to CF-E12: Ethernet over EtherCAT in detail. A slave shows by a reply to ARP that a frame has arrived whole;
 * one without an address gets one of the documentation's net for the case.
 */
#include <string.h>

#include "cases/beyond.h"
#include "cases/ethernet.h"

enum { HEADER = CF_EOE_HEADER, FLAGS = CF_EOE_FLAGS, UNIT = CF_EOE_UNIT, ADDRESS = CF_EOE_ADDRESS };
enum { PARAMETERS = 62 - CF_EOE_HEADER, ROOM = 1600, QUIET_MS = 200 };
enum { ETHERNET = 14, IP_HEADER = 20, ICMP_HEADER = 8, ICMP = 1, ECHO = 8, TYPE_IP = 0x0800 };
enum { NET = CF_EOE_HAS_IP | CF_EOE_HAS_SUBNET | CF_EOE_HAS_GATEWAY, BESIDE_MOST = 3 };

/* --- address ------------------------------------------------------------------------------------------------------ */

/* 192.0.2.`host`/24 with the gateway 192.0.2.1, one field behind the other or in the full layout. @return bytes */
static uint16_t parameters(uint8_t *data, uint8_t host, bool full)
{
    const uint8_t packed[] = {host, 2, 0, 192, 0, 255, 255, 255, 1, 2, 0, 192};
    const unsigned int at = FLAGS + (full ? CF_EOE_MAC : 0u);
    memset(data, 0, PARAMETERS);
    data[0] = NET;
    memcpy(data + at, packed, sizeof packed);
    return full ? PARAMETERS : FLAGS + sizeof packed;
}

static uint16_t set_ip(cf_t *c, const uint8_t *data, uint16_t length, bool last)
{
    cf_mail_t mail;
    cf_eoe_send(c, CF_EOE_SET_IP, 0, data, length, last);
    return cf_eoe_answer(c, CF_EOE_WAS_SET, &mail);
}

static void put_back(cf_t *c, const uint8_t *data, size_t length)
{
    cf_step(c, "set IP to what it was");
    const uint16_t result = set_ip(c, data, (uint16_t)length, true);
    if (result != CF_EOE_DONE)
        cf_fail(c, "putting back the IP parameters: result 0x%04X", result);
}

/* After the case the slave gets the previous address, subnet and gateway, 0.0.0.0 for one that was not known. The MAC
 * stays out: alone it requests DHCP. */
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

/* In PREOP, with the parameters that the slave has. */
static void begin(cf_t *c, cf_eoe_host_t *before)
{
    cf_go(c, CF_PREOP);
    if (cf_eoe_most(c) == 0)
        cf_skip(c, "the mailbox has no room for a fragment");
    cf_eoe_get_ip(c, before);
}

static void expect_address(cf_t *c, const char *what, uint8_t host)
{
    uint8_t wanted[PARAMETERS];
    cf_eoe_host_t now = {.length = 0};
    const uint16_t length = parameters(wanted, host, false);
    cf_eoe_get_ip(c, &now);
    cf_expect_that(c, now.length >= length, "%s: expected at least %u bytes of parameters, got %u", what, length,
                   now.length);
    cf_expect_bits(c, "flags of the parameters", NET, NET, now.data[0]);
    const unsigned int at = FLAGS + ((now.data[0] & CF_EOE_HAS_MAC) != 0 ? CF_EOE_MAC : 0u);
    cf_expect_that(c, now.length >= at + length - FLAGS, "%s: expected %u bytes behind the MAC, got %u", what,
                   length - FLAGS, now.length - at);
    cf_expect_bytes(c, what, wanted + FLAGS, now.data + at, length - FLAGS);
}

/* The runner puts `before` back after the case. */
static void require_settings(cf_t *c, const cf_eoe_host_t *before, uint8_t host)
{
    uint8_t data[PARAMETERS];
    cf_step(c, "set IP 192.0.2.%u/24, gateway 192.0.2.1, one field behind the other", host);
    uint16_t result = set_ip(c, data, parameters(data, host, false), true);
    if (result != CF_EOE_DONE)
        cf_skip(c, "the slave takes no address: result 0x%04X", result);
    keep(c, before);
}

void cf_eoe_parameters(cf_t *c)
{
    uint8_t data[PARAMETERS];
    cf_eoe_host_t before = {.length = 0};
    begin(c, &before);
    require_settings(c, &before, 77);
    expect_address(c, "the address that was set", 77);
    cf_step(c, "the same in the full layout, without the last flag");
    cf_expect(c, "result", CF_EOE_DONE, set_ip(c, data, parameters(data, 78, true), false));
    expect_address(c, "the address in the full layout", 78);
}

void cf_eoe_short_parameters(cf_t *c)
{
    uint8_t data[PARAMETERS];
    cf_eoe_host_t before = {.length = 0};
    begin(c, &before);
    require_settings(c, &before, 77);
    const uint16_t whole = parameters(data, 99, false);
    for (uint16_t length = 1; length < whole; length++) {
        cf_step(c, "set IP with three fields in %u bytes", length);
        uint16_t result = set_ip(c, data, length, true);
        cf_expect_that(c, result != CF_EOE_DONE, "result of set IP in %u bytes of %u: expected an error, got 0x0000",
                       length, whole);
    }
    cf_step(c, "nothing of these was taken");
    expect_address(c, "the address afterwards", 77);
}

/* --- frames that get a reply -------------------------------------------------------------------------------------- */

/* Lets the slave reply to ARP; one without an address gets one for the case. */
static void begin_frames(cf_t *c, cf_eoe_host_t *h)
{
    uint8_t frame[ROOM] = {0};
    *h = (cf_eoe_host_t){.length = 0};
    begin(c, h);
    if (!h->has_ip) {
        static const uint8_t lent[ADDRESS] = {192, 0, 2, 77};
        require_settings(c, h, lent[3]);
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

/* A ping in a frame of `length` bytes. */
static void make_ping(uint8_t *frame, const cf_eoe_host_t *h, uint16_t length)
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

/* @return whether the echo has come, before the slave was quiet for `ms` */
static bool await_echo(cf_t *c, const uint8_t *frame, uint16_t length, uint32_t ms)
{
    uint8_t reply[ROOM];
    uint16_t got = cf_eoe_receive_frame(c, reply, ms);
    while (got > 0 && !is_echo(reply, got, frame, length))
        got = cf_eoe_receive_frame(c, reply, ms);
    return got > 0;
}

/* Around each unit and each full mailbox; with --long every length. */
static bool is_chosen(const cf_t *c, uint16_t length)
{
    const uint16_t beside = (uint16_t)((length + 1) % UNIT), full = (uint16_t)(c->mailbox.in_size - 6 - HEADER);
    return c->whole || beside <= 2 || length == CF_EOE_LEAST || length == CF_EOE_MOST || (length + 1) % full <= 2;
}

void cf_eoe_lengths(cf_t *c)
{
    uint8_t frame[ROOM] = {0};
    cf_eoe_host_t h;
    begin_frames(c, &h);
    const uint16_t most = cf_eoe_most(c), longest = CF_EOE_MOST;
    unsigned int count = 0;
    cf_step(c, "a ping");
    make_ping(frame, &h, CF_EOE_LEAST);
    cf_eoe_send_frame(c, &h, frame, CF_EOE_LEAST, most, 1, -1);
    const bool pings = await_echo(c, frame, CF_EOE_LEAST, CF_MAIL_MS);
    for (uint16_t length = CF_EOE_LEAST; length <= longest; length++) {
        if (!is_chosen(c, length))
            continue;
        cf_step(c, "%s in a frame of %u bytes", pings ? "a ping" : "an ARP request", length);
        if (pings)
            make_ping(frame, &h, length);
        else
            cf_eoe_arp(frame, &h);
        cf_eoe_send_frame(c, &h, frame, length, most, (uint8_t)(++count & 0x0F), -1);
        if (pings)
            cf_expect_that(c, await_echo(c, frame, length, CF_MAIL_MS),
                           "a frame of %u bytes: expected its echo, got none", length);
        while (!pings && h.replies == 0)
            cf_eoe_take(c, &h, CF_MAIL_MS);
        h.replies = 0;
    }
    cf_note(c, "%u lengths, %s", count, pings ? "there and back" : "to the slave: it does not reply to ping");
}

/* --- wrong fragments ---------------------------------------------------------------------------------------------- */

/* A fragment: `word` is number | units << 6 | frame number << 12. */
typedef struct piece {
    uint8_t number, units, frame, last;
    uint16_t from, size;
} piece_t;

typedef struct wrong {
    const char *what;
    unsigned int replies;
    piece_t pieces[3]; /* of an ARP request; size 0: no more */
} wrong_t;

static const wrong_t wrongs[] = {
    {"a fragment number is left out", 0, {{0, 2, 1, 0, 0, 32}, {2, 1, 1, 1, 32, 28}}},
    {"the second fragment has another frame number", 0, {{0, 2, 2, 0, 0, 32}, {1, 1, 3, 1, 32, 28}}},
    {"a gap: the second fragment has an offset too high", 0, {{0, 3, 3, 0, 0, 32}, {1, 2, 3, 1, 32, 28}}},
    {"an overlap: the second fragment has the offset 0", 0, {{0, 2, 4, 0, 0, 32}, {1, 0, 4, 1, 32, 28}}},
    {"the size 0 is announced", 0, {{0, 0, 5, 0, 0, 32}, {1, 1, 5, 1, 32, 28}}},
    {"more than announced comes", 0, {{0, 1, 6, 0, 0, 32}, {1, 1, 6, 1, 32, 28}}},
    {"a fragment before the last has 20 bytes", 0, {{0, 3, 7, 0, 0, 32}, {1, 1, 7, 0, 32, 20}, {2, 1, 7, 1, 52, 28}}},
    {"a second fragment without a first", 0, {{1, 1, 8, 1, 32, 28}}},
    {"a frame starts again", 1, {{0, 2, 9, 0, 0, 32}, {0, 2, 10, 0, 0, 32}, {1, 1, 10, 1, 32, 28}}},
    {"a unit too many is announced", 1, {{0, 3, 11, 0, 0, 32}, {1, 1, 11, 1, 32, 28}}},
};

static void send_wrong(cf_t *c, const wrong_t *wrong, const uint8_t *frame)
{
    for (size_t i = 0; i < sizeof wrong->pieces / sizeof wrong->pieces[0] && wrong->pieces[i].size > 0; i++) {
        const piece_t *p = &wrong->pieces[i];
        cf_eoe_send(c, CF_EOE_FRAGMENT, (uint16_t)(p->number | p->units << 6 | p->frame << 12), frame + p->from,
                    p->size, p->last != 0);
    }
}

void cf_eoe_wrong_fragments(cf_t *c)
{
    uint8_t frame[ROOM] = {0};
    cf_eoe_host_t h;
    begin_frames(c, &h);
    for (size_t i = 0; i < sizeof wrongs / sizeof wrongs[0]; i++) {
        cf_step(c, "%s; then a good frame", wrongs[i].what);
        cf_eoe_arp(frame, &h);
        send_wrong(c, &wrongs[i], frame);
        cf_eoe_expect_replies(c, &h, wrongs[i].what, wrongs[i].replies);
        cf_eoe_send_frame(c, &h, frame, CF_EOE_LEAST, UNIT, 15, -1);
        cf_eoe_expect_replies(c, &h, "replies to a good frame", 1);
    }
    cf_step(c, "a frame of 1540 bytes; then a good one");
    cf_eoe_send_frame(c, &h, frame, 1540, cf_eoe_most(c), 12, -1);
    cf_eoe_expect_replies(c, &h, "replies to a frame of 1540 bytes", 0);
    cf_eoe_send_frame(c, &h, frame, CF_EOE_LEAST, UNIT, 13, -1);
    cf_eoe_expect_replies(c, &h, "replies to a good frame", 1);
}

/* --- beside other mail -------------------------------------------------------------------------------------------- */

/* Reads mails until the SDO's reply has come. @return how many there were */
static unsigned int mails_until_sdo(cf_t *c, unsigned int *replies)
{
    cf_mail_t mail;
    unsigned int mails = 0;
    do {
        mails++;
        cf_expect_that(c, cf_receive_mail(c, &mail, CF_MAIL_MS), "the reply of an SDO: expected within %d ms, got none",
                       (int)CF_MAIL_MS);
        *replies += mail.type == CF_MBX_EOE && mail.length >= HEADER && (mail.data[0] & 0x0F) == CF_EOE_FRAGMENT &&
                    (mail.data[1] & 1) != 0;
    } while (mail.type != CF_MBX_COE);
    cf_expect_bytes(c, "index and sub-index of the SDO's reply", "\x18\x10\x01", mail.data + 3, 3);
    return mails;
}

void cf_eoe_beside_sdo(cf_t *c)
{
    enum { ROUNDS = 50, UPLOAD = 0x40 };
    uint8_t frame[ROOM] = {0}, reply[ROOM];
    cf_eoe_host_t h;
    begin_frames(c, &h);
    unsigned int most = 0;
    cf_step(c, "%d times an SDO between two fragments, then one behind a frame whose reply was not fetched",
            (int)ROUNDS);
    cf_eoe_arp(frame, &h);
    for (unsigned int round = 0; round < ROUNDS; round++) {
        unsigned int replies = 0;
        cf_eoe_send_fragment(c, frame, CF_EOE_LEAST, 0, UNIT, (uint8_t)(round & 0x0F), 0);
        (void)cf_upload_number(c, 0x1018, 1);
        cf_eoe_send_fragment(c, frame, CF_EOE_LEAST, UNIT, CF_EOE_LEAST - UNIT, (uint8_t)(round & 0x0F), 1);
        cf_send_sdo(c, UPLOAD, 0x1018, 1, 0);
        unsigned int mails = mails_until_sdo(c, &replies);
        most = mails > most ? mails : most;
        if (replies == 0)
            cf_expect_that(c, cf_eoe_receive_frame(c, reply, CF_MAIL_MS) > 0,
                           "round %u: expected a reply to the frame with an SDO between its fragments, got none",
                           round + 1);
    }
    cf_expect_that(c, most <= BESIDE_MOST, "mails until the reply of an SDO: expected at most %d, got %u",
                   (int)BESIDE_MOST, most);
    cf_note(c, "the reply of an SDO is one of the next %u mails", most);
}

/* --- time stamps, repeated mails, restarts ------------------------------------------------------------------------ */

enum { MAIL_HEADER = 6, LAST = 0x0100, STAMPED = 0x0200, STAMP_WANTED = 0x0400, STAMP = 4 };

/* A mail of the case's own counter: fragment `number` of a frame of two units. */
static void send_fragment_mail(cf_t *c, uint8_t counter, unsigned int flags, uint8_t number, const uint8_t *data,
                               uint16_t length)
{
    uint8_t mail[MAIL_HEADER + HEADER + ROOM] = {0};
    const unsigned int units = number == 0 ? 2u : 1u;
    ect_store_le16(mail, (uint16_t)(HEADER + length));
    mail[5] = (uint8_t)(CF_MBX_EOE | counter << 4);
    ect_store_le16(mail + MAIL_HEADER, (uint16_t)flags);
    ect_store_le16(mail + MAIL_HEADER + 2, (uint16_t)(number | units << 6 | 7u << 12));
    memcpy(mail + MAIL_HEADER + HEADER, data, length);
    cf_send_raw_mail(c, mail, (uint16_t)(MAIL_HEADER + HEADER + length));
}

/* The counter after that of the last mail. */
static uint8_t next_counter(cf_t *c)
{
    return c->mail_counter = (uint8_t)(c->mail_counter % 7 + 1);
}

static void stamps(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame)
{
    uint8_t end[CF_EOE_LEAST - UNIT + STAMP] = {0};
    memcpy(end, frame + UNIT, CF_EOE_LEAST - UNIT);
    cf_step(c, "a frame with a time stamp of four bytes behind it");
    send_fragment_mail(c, next_counter(c), 0, 0, frame, UNIT);
    send_fragment_mail(c, next_counter(c), LAST | STAMPED, 1, end, sizeof end);
    cf_eoe_expect_replies(c, h, "replies to a frame with a time stamp", 1);
    cf_step(c, "a frame whose time of sending is requested");
    send_fragment_mail(c, next_counter(c), STAMP_WANTED, 0, frame, UNIT);
    send_fragment_mail(c, next_counter(c), LAST | STAMP_WANTED, 1, end, CF_EOE_LEAST - UNIT);
    cf_eoe_expect_replies(c, h, "replies to a frame with a request for its time", 1);
}

void cf_eoe_repeats(cf_t *c)
{
    uint8_t frame[ROOM] = {0};
    cf_eoe_host_t h;
    begin_frames(c, &h);
    cf_eoe_arp(frame, &h);
    stamps(c, &h, frame);
    cf_step(c, "each fragment twice, with equal counters");
    for (uint8_t number = 0; number < 2; number++) {
        const uint16_t from = (uint16_t)(number * UNIT), size = number == 0 ? UNIT : CF_EOE_LEAST - UNIT;
        const uint8_t counter = next_counter(c);
        for (unsigned int time = 0; time < 2; time++)
            send_fragment_mail(c, counter, number == 0 ? 0 : LAST, number, frame + from, size);
    }
    cf_eoe_expect_replies(c, &h, "replies to a frame whose mails came twice", 1);
    if (CF_EOE_LEAST + HEADER + MAIL_HEADER <= c->mailbox.out_size) {
        const uint8_t counter = next_counter(c);
        cf_step(c, "a frame in one fragment, twice, with equal counters");
        for (unsigned int time = 0; time < 2; time++)
            send_fragment_mail(c, counter, LAST, 0, frame, CF_EOE_LEAST);
        cf_eoe_expect_replies(c, &h, "replies to a frame whose only mail came twice", 1);
    }
    cf_step(c, "a frame with the counter 0 throughout");
    send_fragment_mail(c, 0, 0, 0, frame, UNIT);
    send_fragment_mail(c, 0, LAST, 1, frame + UNIT, CF_EOE_LEAST - UNIT);
    cf_eoe_expect_replies(c, &h, "replies to a frame with the counter 0", 1);
}

static void restart(cf_t *c)
{
    cf_go(c, CF_INIT);
    cf_go(c, CF_PREOP);
}

static void expect_good_frame(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame)
{
    cf_step(c, "a good frame");
    cf_eoe_send_frame(c, h, frame, CF_EOE_LEAST, UNIT, 15, -1);
    cf_eoe_expect_replies(c, h, "replies to a good frame", 1);
}

/* A mail of EoE in BOOT, where only FoE is allowed. */
static void boot_refuses(cf_t *c)
{
    if ((c->facts.has & CF_BOOTSTRAP) == 0)
        return;
    cf_step(c, "get IP in BOOT");
    cf_go(c, CF_INIT);
    cf_go(c, CF_BOOT);
    cf_eoe_send(c, CF_EOE_GET_IP, 0, "", 0, true);
    cf_expect_mail_error(c, 2);
}

void cf_eoe_restart(cf_t *c)
{
    uint8_t frame[ROOM] = {0}, ping[ROOM];
    cf_mail_t mail;
    cf_eoe_host_t h;
    begin_frames(c, &h);
    cf_eoe_arp(frame, &h);
    cf_step(c, "INIT and PREOP between two fragments");
    cf_eoe_send_fragment(c, frame, CF_EOE_LEAST, 0, UNIT, 1, 0);
    restart(c);
    cf_eoe_send_fragment(c, frame, CF_EOE_LEAST, UNIT, CF_EOE_LEAST - UNIT, 1, 1);
    cf_eoe_expect_replies(c, &h, "replies to a frame with a restart in it", 0);
    expect_good_frame(c, &h, frame);
    cf_step(c, "a long ping, then INIT and PREOP between two fragments of its echo");
    make_ping(ping, &h, CF_EOE_MOST);
    cf_eoe_send_frame(c, &h, ping, CF_EOE_MOST, cf_eoe_most(c), 2, -1);
    if (!cf_receive_mail(c, &mail, CF_MAIL_MS))
        cf_note(c, "it does not reply to ping: its half frames cannot be judged");
    restart(c);
    cf_eoe_expect_replies(c, &h, "replies after the restart", 0);
    expect_good_frame(c, &h, frame);
    boot_refuses(c);
}

/* --- what no master sends ----------------------------------------------------------------------------------------- */

void cf_eoe_unsupported(cf_t *c)
{
    static const uint8_t replies[] = {CF_EOE_TIMESTAMP, CF_EOE_WAS_SET, CF_EOE_FILTER_WAS_SET, CF_EOE_IP,
                                      CF_EOE_FILTER};
    cf_mail_t mail;
    cf_eoe_host_t before = {.length = 0};
    begin(c, &before);
    for (uint8_t type = 0x0A; type <= 0x0F; type++) {
        cf_step(c, "a mail of the reserved type %u", type);
        cf_eoe_send(c, type, 0, "", 0, true);
        uint16_t result = cf_eoe_answer(c, type, &mail);
        cf_expect(c, "result of a reserved type", CF_EOE_UNSUPPORTED, result);
    }
    cf_step(c, "get IP of port 15");
    cf_eoe_send(c, 0xF0 | CF_EOE_GET_IP, 0, "", 0, true);
    cf_expect_that(c, cf_eoe_answer(c, CF_EOE_IP, &mail) != CF_EOE_DONE || mail.length <= HEADER + FLAGS,
                   "get IP of port 15: expected an error, got result 0x0000 and %u bytes", mail.length);
    for (size_t i = 0; i < sizeof replies; i++) {
        cf_step(c, "a mail of type %u, a reply to no request", replies[i]);
        cf_eoe_send(c, replies[i], 0, "", 0, true);
        cf_expect_no_mail(c, QUIET_MS);
    }
    cf_step(c, "a mail without a whole header");
    cf_send_mail(c, CF_MBX_EOE, "\x06\x01", 2);
    cf_receive(c, CF_MBX_ERROR, &mail);
    cf_step(c, "the next service is served");
    cf_eoe_get_ip(c, &before);
}
