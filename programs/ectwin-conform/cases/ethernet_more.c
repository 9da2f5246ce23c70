/* SPDX-License-Identifier: MIT */
/*
 * CF-E01 to CF-E05, CF-E07, CF-E08, CF-E12: Ethernet over EtherCAT in detail. A slave shows by a reply to ARP that a
 * frame has arrived whole; one without an address gets one of the documentation's net for the case.
 */
#include <string.h>

#include "cases/beyond.h"
#include "cases/ethernet.h"

enum { HEADER = CF_EOE_HEADER, FLAGS = CF_EOE_FLAGS, UNIT = CF_EOE_UNIT };
enum { PARAMETERS = CF_EOE_PARAMETERS, ROOM = CF_EOE_ROOM, QUIET_MS = 200, BESIDE_MOST = 3 };

/* --- address ------------------------------------------------------------------------------------------------------ */

void cf_eoe_parameters(cf_t *c)
{
    uint8_t data[PARAMETERS];
    cf_eoe_host_t before = {.length = 0};
    cf_eoe_begin(c, &before);
    cf_eoe_require_address(c, &before, 77);
    cf_eoe_expect_address(c, "the address after set IP", 77);
    cf_step(c, "set IP in the full layout, without the last flag");
    cf_expect(c, "result", CF_EOE_DONE, cf_eoe_set_ip(c, data, cf_eoe_parameters_of(data, 78, true), false));
    cf_eoe_expect_address(c, "the address in the full layout", 78);
}

void cf_eoe_short_parameters(cf_t *c)
{
    uint8_t data[PARAMETERS];
    cf_eoe_host_t before = {.length = 0};
    cf_eoe_begin(c, &before);
    cf_eoe_require_address(c, &before, 77);
    const uint16_t whole = cf_eoe_parameters_of(data, 99, false);
    for (uint16_t length = 1; length < whole; length++) {
        cf_step(c, "set IP with three fields in %u bytes", length);
        uint16_t result = cf_eoe_set_ip(c, data, length, true);
        cf_expect_that(c, result != CF_EOE_DONE, "result of set IP in %u bytes of %u: expected an error, got 0x0000",
                       length, whole);
    }
    cf_step(c, "none of these settings is accepted");
    cf_eoe_expect_address(c, "the address afterwards", 77);
}

/* --- frames with a reply ------------------------------------------------------------------------------------------ */

/* @return whether a length is tested: near whole units and full mailboxes, or, with --long, all */
static bool is_chosen(const cf_t *c, uint16_t length)
{
    const uint16_t beside = (uint16_t)((length + 1) % UNIT), full = (uint16_t)(c->mailbox.in_size - 6 - HEADER);
    return c->whole || beside <= 2 || length == CF_EOE_LEAST || length == CF_EOE_MOST || (length + 1) % full <= 2;
}

void cf_eoe_lengths(cf_t *c)
{
    uint8_t frame[ROOM] = {0};
    cf_eoe_host_t h;
    cf_eoe_begin_frames(c, &h);
    const uint16_t most = cf_eoe_most(c), longest = CF_EOE_MOST;
    unsigned int count = 0;
    cf_step(c, "a ping");
    cf_eoe_ping(frame, &h, CF_EOE_LEAST);
    cf_eoe_send_frame(c, &h, frame, CF_EOE_LEAST, most, 1, -1);
    const bool pings = cf_eoe_await_echo(c, frame, CF_EOE_LEAST, CF_MAIL_MS);
    for (uint16_t length = CF_EOE_LEAST; length <= longest; length++) {
        if (!is_chosen(c, length))
            continue;
        cf_step(c, "%s in a frame of %u bytes", pings ? "a ping" : "an ARP request", length);
        if (pings)
            cf_eoe_ping(frame, &h, length);
        else
            cf_eoe_arp(frame, &h);
        cf_eoe_send_frame(c, &h, frame, length, most, (uint8_t)(++count & 0x0F), -1);
        if (pings)
            cf_expect_that(c, cf_eoe_await_echo(c, frame, length, CF_MAIL_MS),
                           "a frame of %u bytes: expected its echo, got none", length);
        while (!pings && h.replies == 0)
            cf_eoe_take(c, &h, CF_MAIL_MS);
        h.replies = 0;
    }
    cf_note(c, "%u lengths, %s", count, pings ? "there and back" : "to the slave, which does not reply to ping");
}

/* --- wrong fragments ---------------------------------------------------------------------------------------------- */

/* A fragment. `word`: fragment number | units << 6 | frame number << 12. */
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
    {"a fragment number is missing", 0, {{0, 2, 1, 0, 0, 32}, {2, 1, 1, 1, 32, 28}}},
    {"the second fragment has another frame number", 0, {{0, 2, 2, 0, 0, 32}, {1, 1, 3, 1, 32, 28}}},
    {"a gap: the offset of the second fragment is too high", 0, {{0, 3, 3, 0, 0, 32}, {1, 2, 3, 1, 32, 28}}},
    {"an overlap: the offset of the second fragment is 0", 0, {{0, 2, 4, 0, 0, 32}, {1, 0, 4, 1, 32, 28}}},
    {"the size 0 is announced", 0, {{0, 0, 5, 0, 0, 32}, {1, 1, 5, 1, 32, 28}}},
    {"the fragments exceed the announced size", 0, {{0, 1, 6, 0, 0, 32}, {1, 1, 6, 1, 32, 28}}},
    {"a fragment before the last has 20 bytes", 0, {{0, 3, 7, 0, 0, 32}, {1, 1, 7, 0, 32, 20}, {2, 1, 7, 1, 52, 28}}},
    {"a second fragment without a first one one", 0, {{1, 1, 8, 1, 32, 28}}},
    {"a frame is started twice", 1, {{0, 2, 9, 0, 0, 32}, {0, 2, 10, 0, 0, 32}, {1, 1, 10, 1, 32, 28}}},
    {"the announced size is one unit too large", 1, {{0, 3, 11, 0, 0, 32}, {1, 1, 11, 1, 32, 28}}},
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
    cf_eoe_begin_frames(c, &h);
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

/* --- with other mails --------------------------------------------------------------------------------------------- */

/* Reads mails up to the SDO response. @return number of mails */
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
    cf_eoe_begin_frames(c, &h);
    unsigned int most = 0;
    cf_step(c, "%d times an SDO between two fragments, then one after a frame whose reply was not read", (int)ROUNDS);
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

/* Sends a mail with a given counter: fragment `number` of a frame of two units. */
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

/* @return the counter of the next mail */
static uint8_t next_counter(cf_t *c)
{
    return c->mail_counter = (uint8_t)(c->mail_counter % 7 + 1);
}

static void stamps(cf_t *c, cf_eoe_host_t *h, const uint8_t *frame)
{
    uint8_t end[CF_EOE_LEAST - UNIT + STAMP] = {0};
    memcpy(end, frame + UNIT, CF_EOE_LEAST - UNIT);
    cf_step(c, "a frame followed by a time stamp of four bytes");
    send_fragment_mail(c, next_counter(c), 0, 0, frame, UNIT);
    send_fragment_mail(c, next_counter(c), LAST | STAMPED, 1, end, sizeof end);
    cf_eoe_expect_replies(c, h, "replies to a frame with a time stamp", 1);
    cf_step(c, "a frame with a request for the time of sending");
    send_fragment_mail(c, next_counter(c), STAMP_WANTED, 0, frame, UNIT);
    send_fragment_mail(c, next_counter(c), LAST | STAMP_WANTED, 1, end, CF_EOE_LEAST - UNIT);
    cf_eoe_expect_replies(c, h, "replies to a frame with a request for the time of sending", 1);
}

void cf_eoe_repeats(cf_t *c)
{
    uint8_t frame[ROOM] = {0};
    cf_eoe_host_t h;
    cf_eoe_begin_frames(c, &h);
    cf_eoe_arp(frame, &h);
    stamps(c, &h, frame);
    cf_step(c, "each fragment twice, with equal counters");
    for (uint8_t number = 0; number < 2; number++) {
        const uint16_t from = (uint16_t)(number * UNIT), size = number == 0 ? UNIT : CF_EOE_LEAST - UNIT;
        const uint8_t counter = next_counter(c);
        for (unsigned int time = 0; time < 2; time++)
            send_fragment_mail(c, counter, number == 0 ? 0 : LAST, number, frame + from, size);
    }
    cf_eoe_expect_replies(c, &h, "replies to a frame whose mails were sent twice", 1);
    if (CF_EOE_LEAST + HEADER + MAIL_HEADER <= c->mailbox.out_size) {
        const uint8_t counter = next_counter(c);
        cf_step(c, "a frame in one fragment, twice, with equal counters");
        for (unsigned int time = 0; time < 2; time++)
            send_fragment_mail(c, counter, LAST, 0, frame, CF_EOE_LEAST);
        cf_eoe_expect_replies(c, &h, "replies to a frame whose only mail was sent twice", 1);
    }
    cf_step(c, "a frame of mails with the counter 0");
    send_fragment_mail(c, 0, 0, 0, frame, UNIT);
    send_fragment_mail(c, 0, LAST, 1, frame + UNIT, CF_EOE_LEAST - UNIT);
    cf_eoe_expect_replies(c, &h, "replies to a frame of mails with the counter 0", 1);
}

static void restart(cf_t *c)
{
    cf_go(c, CF_INIT);
    cf_go(c, CF_PREOP);
}

/* Sends a mail of EoE in BOOT, where only FoE is allowed. */
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
    cf_eoe_begin_frames(c, &h);
    cf_eoe_arp(frame, &h);
    cf_step(c, "INIT and PREOP between two fragments");
    cf_eoe_send_fragment(c, frame, CF_EOE_LEAST, 0, UNIT, 1, 0);
    restart(c);
    cf_eoe_send_fragment(c, frame, CF_EOE_LEAST, UNIT, CF_EOE_LEAST - UNIT, 1, 1);
    cf_eoe_expect_replies(c, &h, "replies to a frame interrupted by a restart", 0);
    cf_eoe_expect_good_frame(c, &h, frame);
    cf_step(c, "a long ping, then INIT and PREOP between two fragments of its echo");
    cf_eoe_ping(ping, &h, CF_EOE_MOST);
    cf_eoe_send_frame(c, &h, ping, CF_EOE_MOST, cf_eoe_most(c), 2, -1);
    if (!cf_receive_mail(c, &mail, CF_MAIL_MS))
        cf_note(c, "the slave does not reply to ping: incomplete frames of the slave cannot be judged");
    restart(c);
    cf_eoe_expect_replies(c, &h, "replies after the restart", 0);
    cf_eoe_expect_good_frame(c, &h, frame);
    boot_refuses(c);
}

/* --- invalid requests --------------------------------------------------------------------------------------------- */

void cf_eoe_unsupported(cf_t *c)
{
    static const uint8_t replies[] = {CF_EOE_TIMESTAMP, CF_EOE_WAS_SET, CF_EOE_FILTER_WAS_SET, CF_EOE_IP,
                                      CF_EOE_FILTER};
    cf_mail_t mail;
    cf_eoe_host_t before = {.length = 0};
    cf_eoe_begin(c, &before);
    for (uint8_t type = 0x0A; type <= 0x0F; type++) {
        cf_step(c, "a mail of the reserved type %u", type);
        cf_eoe_send(c, type, 0, "", 0, true);
        uint16_t result = cf_eoe_reply(c, type, &mail);
        cf_expect(c, "result of a reserved type", CF_EOE_UNSUPPORTED, result);
    }
    cf_step(c, "get IP of port 15");
    cf_eoe_send(c, 0xF0 | CF_EOE_GET_IP, 0, "", 0, true);
    cf_expect_that(c, cf_eoe_reply(c, CF_EOE_IP, &mail) != CF_EOE_DONE || mail.length <= HEADER + FLAGS,
                   "get IP for port 15: expected an error, got result 0x0000 and %u bytes", mail.length);
    for (size_t i = 0; i < sizeof replies; i++) {
        cf_step(c, "a mail of type %u, a reply without a request", replies[i]);
        cf_eoe_send(c, replies[i], 0, "", 0, true);
        cf_expect_no_mail(c, QUIET_MS);
    }
    cf_step(c, "a mail without a whole header");
    cf_send_mail(c, CF_MBX_EOE, "\x06\x01", 2);
    cf_receive(c, CF_MBX_ERROR, &mail);
    cf_step(c, "the next service works");
    cf_eoe_get_ip(c, &before);
}
