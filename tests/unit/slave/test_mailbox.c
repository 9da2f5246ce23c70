/* SPDX-License-Identifier: MIT */
/* The mailbox observed on the wire: buffers, counters, repeats, invalid headers, lengths. */
#include <stdio.h>
#include <string.h>

#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

enum { SM0 = 0x1000, SM1 = 0x1080, SIZE = 128, HEADER = 6 };
enum {
    SM0_STATUS = ECT_REG_SM + ECT_SM_STATUS,
    SM1_STATUS = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS,
    SM1_ACTIVATE = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_ACTIVATE,
    SM1_PDI = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_PDI_CONTROL,
    FULL = ECT_SM_STATUS_FULL,
    REPEAT = ECT_SM_ACTIVATE_REPEAT,
};

/* --- helpers ----------------------------------------------------------------------------------------------------- */

static void open_preop(wire_t *w)
{
    wire_open_one(w, &testdev);
    wire_go(w, 0, ECT_STATE_PREOP);
}

static ect_slave_t *slave_of(wire_t *w)
{
    return (ect_slave_t *)(uintptr_t)ect_chain_slave(w->chain, 0);
}

static void header(uint8_t *mail, uint16_t length, uint8_t type, unsigned int counter)
{
    memset(mail, 0, SIZE);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (counter << 4));
}

static void sdo(uint8_t *mail, unsigned int counter, uint8_t command, uint16_t index, uint32_t value)
{
    header(mail, 10, 3, counter);
    mail[7] = 0x20;
    mail[8] = command;
    ect_store_le16(mail + 9, index);
    ect_store_le32(mail + 12, value);
}

static int send(wire_t *w, const uint8_t *mail)
{
    return wire_write(w, 0, SM0, mail, SIZE);
}

/* Writes `value` to 2000h. */
static int send_write(wire_t *w, unsigned int counter, uint32_t value)
{
    uint8_t mail[SIZE];
    sdo(mail, counter, 0x23, 0x2000, value);
    return send(w, mail);
}

static int send_upload(wire_t *w, unsigned int counter, uint16_t index)
{
    uint8_t mail[SIZE];
    sdo(mail, counter, 0x40, index, 0);
    return send(w, mail);
}

static bool full(wire_t *w, uint16_t status_register)
{
    return (wire_read8(w, 0, status_register) & FULL) != 0;
}

/* Reads the whole of SM1; false when it is empty. */
static bool fetch(wire_t *w, uint8_t mail[SIZE])
{
    memset(mail, 0xEE, SIZE);
    return wire_read(w, 0, SM1, mail, SIZE) == 1;
}

static void expect_fetch(wire_t *w, const char *where, uint8_t mail[SIZE])
{
    if (!fetch(w, mail))
        fail_msg("%s: nothing in SM1", where);
}

static void expect_empty(wire_t *w, const char *where)
{
    uint8_t mail[SIZE];
    if (fetch(w, mail))
        fail_msg("%s: an unexpected mail in SM1: type and counter 0x%02X, length %u", where, mail[5],
                 ect_load_le16(mail));
}

static void expect_same(const char *where, const uint8_t *got, const uint8_t *want)
{
    for (unsigned int i = 0; i < SIZE; i++) {
        if (got[i] != want[i])
            fail_msg("%s: byte %u of the mail is 0x%02X, expected 0x%02X", where, i, got[i], want[i]);
    }
}

static unsigned int counter_of(const uint8_t *mail)
{
    return (mail[5] >> 4) & 7u;
}

static void expect_error(const char *where, const uint8_t *mail, uint16_t detail)
{
    if (ect_load_le16(mail) != 4 || (mail[5] & 0x0F) != 0 || ect_load_le16(mail + 6) != 1 ||
        ect_load_le16(mail + 8) != detail)
        fail_msg("%s: expected error reply %u; got length %u, type %u, 0x%04X 0x%04X", where, detail,
                 ect_load_le16(mail), mail[5] & 0x0F, ect_load_le16(mail + 6), ect_load_le16(mail + 8));
    for (unsigned int i = 10; i < SIZE; i++)
        assert_int_equal(mail[i], 0);
}

static void emergency(wire_t *w, uint16_t code)
{
    static const uint8_t data[5] = {1, 2, 3, 4, 5};
    const ect_host_t *host = testdev_of(w, 0)->host;
    host->emergency(host->ctx, code, 0x01, data);
    (void)ect_slave_poll(slave_of(w), w->now_ns);
}

static void toggle(wire_t *w)
{
    wire_write8(w, 0, SM1_ACTIVATE, wire_read8(w, 0, SM1_ACTIVATE) ^ REPEAT);
}

static bool acknowledged(wire_t *w)
{
    return ((wire_read8(w, 0, SM1_ACTIVATE) ^ wire_read8(w, 0, SM1_PDI)) & REPEAT) == 0;
}

static void repeat(wire_t *w, const char *where)
{
    toggle(w);
    if (!acknowledged(w))
        fail_msg("%s: repeat not acknowledged", where);
}

/* --- the two buffers --------------------------------------------------------------------------------------------- */

static void out_full(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    w.manual_poll = true;
    assert_int_equal(send_write(&w, 1, 1), 1);
    assert_true(full(&w, SM0_STATUS));
    for (unsigned int n = 0; n < 3; n++)
        assert_int_equal(send_write(&w, 2, 2), 0);
    wire_poll(&w);
    assert_false(full(&w, SM0_STATUS));
    assert_int_equal(testdev_of(&w, 0)->u32, 1);
    expect_fetch(&w, "reply", mail);
    assert_int_equal(send_write(&w, 2, 2), 1);
    wire_poll(&w);
    assert_int_equal(testdev_of(&w, 0)->u32, 2);
    wire_close(&w);
}

static void out_last_byte(void **state)
{
    (void)state;
    static const uint16_t cuts[] = {1, 2, 6, 16, 100, 127};
    for (size_t i = 0; i < COUNT(cuts); i++) {
        wire_t w;
        uint8_t mail[SIZE];
        open_preop(&w);
        sdo(mail, 1, 0x23, 0x2000, 0xABCD);
        assert_int_equal(wire_write(&w, 0, SM0, mail, cuts[i]), 1);
        assert_false(full(&w, SM0_STATUS));
        assert_int_equal(testdev_of(&w, 0)->written, 0);
        assert_int_equal(wire_write(&w, 0, (uint16_t)(SM0 + cuts[i]), mail + cuts[i], (uint16_t)(SIZE - cuts[i])), 1);
        assert_int_equal(testdev_of(&w, 0)->u32, 0xABCD);
        expect_fetch(&w, "reply", mail);
        wire_close(&w);
    }
}

static void out_actual_length_and_last_byte(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    sdo(mail, 1, 0x23, 0x2000, 0x5555);
    wire_build(&w, FPWR, WIRE_STATION, SM0, mail, 16);
    wire_append(&w, FPWR, WIRE_STATION, SM0 + SIZE - 1, mail + SIZE - 1, 1);
    assert_true(wire_transmit(&w));
    assert_int_equal(wire_wkc(&w, 0), 1);
    assert_int_equal(wire_wkc(&w, 1), 1);
    assert_int_equal(testdev_of(&w, 0)->u32, 0x5555);
    wire_close(&w);
}

static void in_partly_read(void **state)
{
    (void)state;
    wire_t w;
    uint8_t whole[SIZE];
    uint8_t mail[SIZE];
    open_preop(&w);
    expect_empty(&w, "before any request");
    assert_int_equal(send_upload(&w, 1, 0x2000), 1);
    assert_true(full(&w, SM1_STATUS));
    assert_int_equal(wire_read(&w, 0, SM1 + 2, mail, 4), 0);
    assert_int_equal(wire_read(&w, 0, SM1, whole, 2), 1);
    assert_true(full(&w, SM1_STATUS));
    assert_int_equal(wire_read(&w, 0, SM1, whole, 16), 1);
    assert_true(full(&w, SM1_STATUS));
    assert_int_equal(ect_load_le32(whole + 12), 0x11223344);
    assert_int_equal(send_write(&w, 2, 7), 1);
    assert_true(full(&w, SM0_STATUS));
    assert_int_equal(wire_read(&w, 0, SM1 + SIZE - 1, mail, 1), 1);
    expect_fetch(&w, "reply to the second", mail);
    assert_int_equal(mail[8], 0x60);
    expect_empty(&w, "both read");
    wire_close(&w);
}

/* --- counters ---------------------------------------------------------------------------------------------------- */

static void own_counter(void **state)
{
    (void)state;
    static const unsigned int counters[] = {1, 2, 3, 4, 5, 6, 7, 1, 2, 0, 0, 0, 5, 3, 0, 7, 6, 5, 4, 3, 2, 1};
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    for (size_t i = 0; i < COUNT(counters); i++) {
        if (i % 4 == 3) { /* the error reply counts as well */
            header(mail, 4, 4, counters[i]);
            assert_int_equal(send(&w, mail), 1);
        } else {
            assert_int_equal(send_upload(&w, counters[i], 0x2000), 1);
        }
        expect_fetch(&w, "reply", mail);
        if (counter_of(mail) != i % 7 + 1)
            fail_msg("reply %zu has counter %u", i + 1, counter_of(mail));
        assert_int_equal(mail[5] & 0x80, 0);
        if (i % 5 == 4)
            wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
    }
    wire_close(&w);
}

static void not_carried_out_again(void **state)
{
    (void)state;
    for (unsigned int counter = 1; counter <= 7; counter++) {
        wire_t w;
        uint8_t first[SIZE];
        uint8_t again[SIZE];
        open_preop(&w);
        assert_int_equal(send_write(&w, counter, 1), 1);
        expect_fetch(&w, "first", first);
        for (unsigned int n = 0; n < 4; n++) {
            assert_int_equal(send_write(&w, counter, 2), 1);
            expect_fetch(&w, "repeated request", again);
            expect_same("repeated request", again, first);
        }
        assert_int_equal(testdev_of(&w, 0)->written, 1);
        assert_int_equal(testdev_of(&w, 0)->u32, 1);
        expect_empty(&w, "one reply each");
        assert_int_equal(send_write(&w, counter % 7 + 1, 3), 1);
        expect_fetch(&w, "next", again);
        assert_int_equal(testdev_of(&w, 0)->u32, 3);
        assert_int_equal(counter_of(again), 2);
        wire_close(&w);
    }
}

/* A master without a reply to its write sends the mail again, and then fetches the reply; a slave that is slow, or far
 * from its controller, finds both at once. One reply is enough: the master would accept a second one as the reply to
 * its next request. */
static void repeated_and_fetched_at_once(void **state)
{
    (void)state;
    for (unsigned int polls = 0; polls < 2; polls++) {
        wire_t w;
        uint8_t mail[SIZE];
        open_preop(&w);
        w.manual_poll = true;
        for (unsigned int counter = 1; counter <= 7; counter++) {
            assert_int_equal(send_write(&w, counter, counter), 1);
            wire_poll(&w);
            assert_int_equal(send_write(&w, counter, counter), 1);
            expect_fetch(&w, "reply", mail);
            for (unsigned int n = 0; n < 2 * polls; n++)
                toggle(&w); /* forth and back: the slave handles its SyncManagers before the mailbox */
            for (unsigned int n = 0; n < 3; n++)
                wire_poll(&w);
            expect_empty(&w, "one reply to a request that was sent twice");
            assert_int_equal(testdev_of(&w, 0)->written, counter);
        }
        wire_close(&w);
    }
}

static void counter_zero(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    for (unsigned int n = 1; n <= 5; n++) {
        assert_int_equal(send_write(&w, 0, n), 1);
        expect_fetch(&w, "reply", mail);
        assert_int_equal(mail[8], 0x60);
        assert_int_equal(testdev_of(&w, 0)->written, n);
        assert_int_equal(testdev_of(&w, 0)->u32, n);
    }
    wire_close(&w);
}

static void older_counter_is_new(void **state)
{
    (void)state;
    static const unsigned int counters[] = {1, 2, 1, 2, 7, 1, 7};
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    for (unsigned int n = 0; n < COUNT(counters); n++) {
        assert_int_equal(send_write(&w, counters[n], n), 1);
        expect_fetch(&w, "reply", mail);
        assert_int_equal(testdev_of(&w, 0)->written, n + 1);
    }
    wire_close(&w);
}

static void repeated_while_unread(void **state)
{
    (void)state;
    wire_t w;
    uint8_t first[SIZE];
    uint8_t again[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 3, 1), 1);
    assert_int_equal(send_write(&w, 3, 1), 1);
    assert_true(full(&w, SM0_STATUS));
    expect_fetch(&w, "reply", first);
    expect_empty(&w, "a second copy would count as the next reply");
    assert_false(full(&w, SM0_STATUS));
    assert_int_equal(testdev_of(&w, 0)->written, 1);
    assert_int_equal(send_write(&w, 4, 2), 1);
    expect_fetch(&w, "the next reply", again);
    expect_empty(&w, "nothing more");
    assert_int_equal(testdev_of(&w, 0)->written, 2);
    wire_close(&w);
}

static void repeated_error(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    uint8_t first[SIZE];
    open_preop(&w);
    header(mail, 4, 4, 2);
    assert_int_equal(send(&w, mail), 1);
    expect_fetch(&w, "error", first);
    expect_error("error", first, 2);
    assert_int_equal(send(&w, mail), 1);
    expect_fetch(&w, "error again", mail);
    expect_same("error again", mail, first);
    wire_close(&w);
}

static void repeated_without_reply(void **state)
{
    (void)state;
    wire_t w;
    uint8_t abort_mail[SIZE];
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 1, 1), 1);
    expect_fetch(&w, "reply", mail);
    sdo(abort_mail, 2, 0x80, 0x2000, 0x08000000);
    for (unsigned int n = 0; n < 3; n++) {
        assert_int_equal(send(&w, abort_mail), 1);
        assert_false(full(&w, SM0_STATUS));
        expect_empty(&w, "an abort has no reply");
    }
    assert_int_equal(send_write(&w, 3, 2), 1);
    expect_fetch(&w, "next", mail);
    assert_int_equal(counter_of(mail), 2);
    wire_close(&w);
}

static void repeated_after_emergency(void **state)
{
    (void)state;
    wire_t w;
    uint8_t first[SIZE];
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 1, 1), 1);
    expect_fetch(&w, "reply", first);
    emergency(&w, 0x8100);
    expect_fetch(&w, "emergency", mail);
    assert_int_equal(mail[7] >> 4, 1);
    assert_int_equal(counter_of(mail), 2);
    assert_int_equal(send_write(&w, 1, 1), 1);
    expect_fetch(&w, "repetition", mail);
    expect_same("repetition", mail, first);
    assert_int_equal(testdev_of(&w, 0)->written, 1);
    repeat(&w, "the repetition lost");
    expect_fetch(&w, "the repetition lost", mail);
    expect_same("the repetition lost", mail, first);
    wire_close(&w);
}

/* The requested reply is in SM1, although an emergency is newer: it is the last mail, and remains. */
static void repeat_of_a_repetition(void **state)
{
    (void)state;
    wire_t w;
    uint8_t first[SIZE];
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 1, 1), 1);
    expect_fetch(&w, "reply", first);
    emergency(&w, 0x8100);
    expect_fetch(&w, "emergency", mail);
    assert_int_equal(send_write(&w, 1, 1), 1);
    repeat(&w, "unread");
    expect_fetch(&w, "repetition", mail);
    expect_same("repetition", mail, first);
    expect_empty(&w, "the emergency was fetched already");
    wire_close(&w);
}

static void never_again_after_two_emergencies(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 1, 1), 1);
    expect_fetch(&w, "reply", mail);
    for (uint16_t n = 1; n <= 2; n++) {
        emergency(&w, (uint16_t)(0x8100 + n));
        expect_fetch(&w, "emergency", mail);
    }
    assert_int_equal(send_write(&w, 1, 2), 1);
    assert_int_equal(testdev_of(&w, 0)->written, 1);
    assert_false(full(&w, SM0_STATUS));
    expect_empty(&w, "the reply is lost, and nothing replaces it");
    assert_int_equal(send_write(&w, 2, 3), 1);
    assert_int_equal(testdev_of(&w, 0)->u32, 3);
    wire_close(&w);
}

static void stop_forgets(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 5, 1), 1);
    expect_fetch(&w, "reply", mail);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(send_write(&w, 5, 2), 1);
    expect_fetch(&w, "reply", mail);
    assert_int_equal(mail[8], 0x60);
    assert_int_equal(testdev_of(&w, 0)->written, 2);
    assert_int_equal(testdev_of(&w, 0)->u32, 2);
    assert_in_range(counter_of(mail), 1, 7);
    wire_close(&w);
}

static void stop_empties(void **state)
{
    (void)state;
    wire_t w;
    open_preop(&w);
    assert_int_equal(send_write(&w, 1, 1), 1);
    assert_int_equal(send_write(&w, 2, 2), 1);
    assert_true(full(&w, SM0_STATUS));
    assert_true(full(&w, SM1_STATUS));
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_INIT);
    assert_false(full(&w, SM0_STATUS));
    assert_false(full(&w, SM1_STATUS));
    assert_int_equal(send_write(&w, 3, 3), 0);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), ECT_STATE_PREOP);
    expect_empty(&w, "after INIT");
    assert_int_equal(testdev_of(&w, 0)->u32, 1);
    uint8_t mail[SIZE];
    repeat(&w, "nothing sent since");
    expect_empty(&w, "nothing sent since");
    assert_int_equal(send_write(&w, 3, 3), 1);
    expect_fetch(&w, "reply", mail);
    assert_int_equal(mail[8], 0x60);
    wire_close(&w);
}

/* --- a reply not read yet ---------------------------------------------------------------------------------------- */

static void held(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_write(&w, 1, 10), 1);
    assert_int_equal(send_upload(&w, 2, 0x2000), 1);
    assert_int_equal(send_write(&w, 3, 30), 0);
    wire_advance(&w, 1000 * MS);
    assert_true(full(&w, SM0_STATUS));
    expect_fetch(&w, "first", mail);
    assert_int_equal(mail[8], 0x60);
    assert_int_equal(counter_of(mail), 1);
    assert_false(full(&w, SM0_STATUS));
    assert_int_equal(send_write(&w, 3, 30), 1);
    assert_int_equal(testdev_of(&w, 0)->u32, 10);
    expect_fetch(&w, "second", mail);
    assert_int_equal(mail[8], 0x43);
    assert_int_equal(ect_load_le32(mail + 12), 10);
    assert_int_equal(counter_of(mail), 2);
    expect_fetch(&w, "third", mail);
    assert_int_equal(mail[8], 0x60);
    assert_int_equal(testdev_of(&w, 0)->u32, 30);
    expect_empty(&w, "nothing more");
    wire_close(&w);
}

static void held_behind_emergency(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    emergency(&w, 0x8100);
    emergency(&w, 0x8200);
    assert_int_equal(send_write(&w, 1, 10), 1);
    expect_fetch(&w, "first emergency", mail);
    assert_int_equal(ect_load_le16(mail + 8), 0x8100);
    expect_fetch(&w, "second emergency", mail);
    assert_int_equal(ect_load_le16(mail + 8), 0x8200);
    expect_fetch(&w, "reply", mail);
    assert_int_equal(mail[8], 0x60);
    assert_int_equal(counter_of(mail), 3);
    wire_close(&w);
}

/* --- repeat ------------------------------------------------------------------------------------------------------ */

static void repeat_nothing(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    for (unsigned int n = 0; n < 3; n++) {
        repeat(&w, "nothing sent");
        expect_empty(&w, "nothing sent");
    }
    assert_int_equal(send_write(&w, 1, 1), 1);
    expect_fetch(&w, "first reply", mail);
    assert_int_equal(counter_of(mail), 1);
    wire_close(&w);
}

/* Number of mails read before the lost one. */
static void repeat_lost(void **state)
{
    (void)state;
    for (unsigned int before = 0; before < 4; before++) {
        wire_t w;
        uint8_t mail[SIZE];
        uint8_t lost[SIZE];
        open_preop(&w);
        for (unsigned int n = 0; n < before; n++) {
            assert_int_equal(send_write(&w, n + 1, n), 1);
            expect_fetch(&w, "before", mail);
        }
        assert_int_equal(send_upload(&w, before + 1, 0x2000), 1);
        expect_fetch(&w, "reply", lost);
        for (unsigned int n = 0; n < 5; n++) {
            repeat(&w, "lost");
            expect_fetch(&w, "lost", mail);
            expect_same("repeated", mail, lost);
            expect_empty(&w, "once each");
        }
        assert_int_equal(send_write(&w, before + 2, 99), 1);
        expect_fetch(&w, "next", mail);
        assert_int_equal(mail[8], 0x60);
        wire_close(&w);
    }
}

/* The master requests a repeat twice before it reads: the mail is in SM1 already. */
static void repeat_twice(void **state)
{
    (void)state;
    for (unsigned int before = 0; before < 3; before++) {
        for (unsigned int times = 2; times <= 4; times++) {
            wire_t w;
            uint8_t mail[SIZE];
            uint8_t lost[SIZE];
            char where[64];
            (void)snprintf(where, sizeof where, "%u mails before, asked %u times", before, times);
            open_preop(&w);
            for (unsigned int n = 0; n < before; n++) {
                assert_int_equal(send_write(&w, n + 1, n), 1);
                expect_fetch(&w, "before", mail);
            }
            assert_int_equal(send_upload(&w, before + 1, 0x2000), 1);
            expect_fetch(&w, "reply", lost);
            for (unsigned int n = 0; n < times; n++)
                repeat(&w, where);
            expect_fetch(&w, where, mail);
            expect_same(where, mail, lost);
            expect_empty(&w, where);
            wire_close(&w);
        }
    }
}

static void repeat_unread_first(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    assert_int_equal(send_upload(&w, 1, 0x2000), 1);
    repeat(&w, "unread");
    repeat(&w, "unread");
    expect_fetch(&w, "unread", mail);
    assert_int_equal(ect_load_le32(mail + 12), 0x11223344);
    expect_empty(&w, "once");
    wire_close(&w);
}

/* The lost mail A, and B, which is in SM1 already: A, then B. */
static void newer_mail_is_full(wire_t *w, uint8_t a[SIZE], unsigned int before)
{
    uint8_t mail[SIZE];
    open_preop(w);
    for (unsigned int n = 0; n < before; n++) {
        assert_int_equal(send_write(w, n + 1, n), 1);
        expect_fetch(w, "before", mail);
    }
    assert_int_equal(send_upload(w, before + 1, 0x2000), 1);
    assert_int_equal(send_upload(w, before + 2, 0x2001), 1);
    expect_fetch(w, "A", a);
    assert_int_equal(counter_of(a), before + 1);
    assert_true(full(w, SM1_STATUS));
}

static void expect_b(wire_t *w, const char *where, const uint8_t a[SIZE])
{
    uint8_t b[SIZE];
    expect_fetch(w, where, b);
    if (counter_of(b) != counter_of(a) + 1 || ect_load_le16(b + 9) != 0x2001)
        fail_msg("%s: expected the newer mail, got counter %u, index 0x%04X", where, counter_of(b),
                 ect_load_le16(b + 9));
    expect_empty(w, where);
}

static void repeat_with_newer_mail(void **state)
{
    (void)state;
    for (unsigned int before = 0; before < 3; before++) {
        for (unsigned int times = 1; times <= 3; times++) {
            wire_t w;
            uint8_t a[SIZE];
            uint8_t mail[SIZE];
            newer_mail_is_full(&w, a, before);
            for (unsigned int n = 0; n < times; n++)
                repeat(&w, "newer stands");
            expect_fetch(&w, "A again", mail);
            expect_same("A again", mail, a);
            expect_b(&w, "then B", a);
            wire_close(&w);
        }
    }
}

static void repeat_lost_again(void **state)
{
    (void)state;
    wire_t w;
    uint8_t a[SIZE];
    uint8_t mail[SIZE];
    newer_mail_is_full(&w, a, 1);
    repeat(&w, "A lost");
    w.manual_poll = true;
    expect_fetch(&w, "A again", mail);
    toggle(&w);
    w.manual_poll = false;
    wire_poll(&w);
    assert_true(acknowledged(&w));
    expect_fetch(&w, "A the third time", mail);
    expect_same("A the third time", mail, a);
    repeat(&w, "A lost again, B stands");
    expect_fetch(&w, "A the fourth time", mail);
    expect_same("A the fourth time", mail, a);
    expect_b(&w, "then B", a);
    wire_close(&w);
}

static void repeat_then_newest_lost(void **state)
{
    (void)state;
    wire_t w;
    uint8_t a[SIZE];
    uint8_t b[SIZE];
    uint8_t mail[SIZE];
    newer_mail_is_full(&w, a, 0);
    repeat(&w, "A lost");
    expect_fetch(&w, "A again", mail);
    expect_fetch(&w, "B", b);
    assert_int_equal(counter_of(b), 2);
    repeat(&w, "B lost");
    expect_fetch(&w, "B again", mail);
    expect_same("B again", mail, b);
    expect_empty(&w, "nothing more");
    wire_close(&w);
}

static void repeat_and_request_at_once(void **state)
{
    (void)state;
    for (unsigned int before = 0; before < 2; before++) {
        wire_t w;
        uint8_t a[SIZE];
        uint8_t mail[SIZE];
        open_preop(&w);
        for (unsigned int n = 0; n < before; n++) {
            assert_int_equal(send_write(&w, n + 1, n), 1);
            expect_fetch(&w, "before", mail);
        }
        assert_int_equal(send_upload(&w, before + 1, 0x2000), 1);
        w.manual_poll = true;
        expect_fetch(&w, "A", a);
        assert_int_equal(send_upload(&w, before + 2, 0x2001), 1);
        toggle(&w);
        w.manual_poll = false;
        wire_poll(&w);
        assert_true(acknowledged(&w));
        expect_fetch(&w, "A again", mail);
        expect_same("A again", mail, a);
        expect_b(&w, "then B", a);
        wire_close(&w);
    }
}

static void repeat_emergency(void **state)
{
    (void)state;
    wire_t w;
    uint8_t a[SIZE];
    uint8_t mail[SIZE];
    open_preop(&w);
    emergency(&w, 0x8130);
    expect_fetch(&w, "emergency", a);
    repeat(&w, "emergency lost");
    expect_fetch(&w, "emergency again", mail);
    expect_same("emergency again", mail, a);
    wire_close(&w);
}

/* The toggle that the register holds when the mailbox starts is acknowledged unchanged. */
static void repeat_before_start(void **state)
{
    (void)state;
    for (unsigned int toggles = 0; toggles < 2; toggles++) {
        wire_t w;
        uint8_t mail[SIZE];
        wire_open_one(&w, &testdev);
        wire_configure_mailbox(&w, 0);
        for (unsigned int n = 0; n < toggles; n++)
            toggle(&w);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
        assert_true(acknowledged(&w));
        expect_empty(&w, "no stale repeat");
        assert_int_equal(send_upload(&w, 1, 0x2000), 1);
        expect_fetch(&w, "reply", mail);
        repeat(&w, "lost");
        expect_fetch(&w, "again", mail);
        assert_int_equal(ect_load_le32(mail + 12), 0x11223344);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_INIT);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
        assert_true(acknowledged(&w));
        expect_empty(&w, "after a restart of the mailbox");
        wire_close(&w);
    }
}

/* --- the acknowledge follows the mail ----------------------------------------------------------------------------- */

typedef struct watch {
    ect_pdi_t real;
    ect_pdi_t pdi;
    ect_esc_t *esc;
    bool armed;
    unsigned int acknowledges;
    unsigned int early;
    uint8_t wanted[SIZE]; /* expected in SM1 then */
} watch_t;

static int watch_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    watch_t *watch = ctx;
    return watch->real.read(watch->real.ctx, address, buffer, length);
}

static int watch_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    watch_t *watch = ctx;
    const uint8_t *memory = watch->esc->memory;
    uint8_t before = memory[SM1_PDI];
    int result = watch->real.write(watch->real.ctx, address, buffer, length);
    uint8_t changed = (before ^ memory[SM1_PDI]) & REPEAT;
    if (watch->armed && changed != 0 && ((memory[SM1_PDI] ^ memory[SM1_ACTIVATE]) & REPEAT) == 0) {
        watch->acknowledges++;
        if ((memory[SM1_STATUS] & FULL) == 0 || memcmp(memory + SM1, watch->wanted, SIZE) != 0)
            watch->early++;
    }
    return result;
}

static void watch_slave(wire_t *w, watch_t *watch)
{
    *watch = (watch_t){.real = *slave_of(w)->config.pdi, .esc = ect_chain_esc(w->chain, 0)};
    watch->pdi = (ect_pdi_t){.ctx = watch, .read = watch_read, .write = watch_write};
    slave_of(w)->config.pdi = &watch->pdi;
}

static void acknowledge_last(void **state)
{
    (void)state;
    for (unsigned int toggles = 0; toggles < 2; toggles++) {
        wire_t w;
        watch_t watch;
        uint8_t a[SIZE];
        uint8_t mail[SIZE];
        open_preop(&w);
        for (unsigned int n = 0; n < toggles; n++)
            repeat(&w, "nothing sent");
        assert_int_equal(send_write(&w, 1, 0), 1);
        expect_fetch(&w, "before", mail);
        watch_slave(&w, &watch);
        assert_int_equal(send_upload(&w, 2, 0x2000), 1);
        assert_int_equal(send_upload(&w, 3, 0x2001), 1);
        expect_fetch(&w, "A", a);
        memcpy(watch.wanted, a, SIZE);
        watch.armed = true;
        repeat(&w, "A lost, B stands");
        if (watch.acknowledges != 1 || watch.early != 0)
            fail_msg("B stands, ack was %u before: %u acknowledges, %u before A stood in SM1", toggles,
                     watch.acknowledges, watch.early);
        expect_fetch(&w, "A again", mail);
        expect_fetch(&w, "B", mail);
        memcpy(watch.wanted, mail, SIZE);
        repeat(&w, "B lost, SM1 empty");
        if (watch.acknowledges != 2 || watch.early != 0)
            fail_msg("SM1 empty: %u acknowledges, %u before B stood in SM1", watch.acknowledges, watch.early);
        wire_close(&w);
    }
}

/* --- headers ----------------------------------------------------------------------------------------------------- */

typedef struct bad_header {
    const char *what;
    uint16_t length;
    uint8_t channel;
    uint8_t type;
    uint16_t detail; /* 0: reply by CoE */
} bad_header_t;

static const bad_header_t bad_headers[] = {
    {"length 0", 0, 0, 3, 5},
    {"length 1", 1, 0, 3, 6},
    {"length 2, CoE header only", 2, 0, 3, 6},
    {"length 9, SDO too short", 9, 0, 3, 6},
    {"length 10", 10, 0, 3, 0},
    {"length of the mailbox", SIZE - HEADER, 0, 3, 0},
    {"one more", SIZE - HEADER + 1, 0, 3, 8},
    {"length of the whole SM", SIZE, 0, 3, 8},
    {"length 0x7FFF", 0x7FFF, 0, 3, 8},
    {"length 0xFFFF", 0xFFFF, 0, 3, 8},
    {"channel 1", 10, 0x01, 3, 3},
    {"channel 0x20", 10, 0x20, 3, 3},
    {"channel 0x3F", 10, 0x3F, 3, 3},
    {"priority 1", 10, 0x40, 3, 0},
    {"priority 3", 10, 0xC0, 3, 0},
    {"reserved bit 7", 10, 0, 0x83, 1},
    {"AoE", 10, 0, 1, 2},
    {"EoE", 10, 0, 2, 2},
    {"FoE", 10, 0, 4, 2},
    {"SoE", 10, 0, 5, 2},
    {"type 6", 10, 0, 6, 2},
    {"type 7", 10, 0, 7, 2},
    {"type 8", 10, 0, 8, 2},
    {"type 9", 10, 0, 9, 2},
    {"type 10", 10, 0, 10, 2},
    {"type 11", 10, 0, 11, 2},
    {"type 12", 10, 0, 12, 2},
    {"type 13", 10, 0, 13, 2},
    {"type 14", 10, 0, 14, 2},
    {"VoE", 10, 0, 15, 2},
};

static void headers_checked(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    unsigned int counter = 0;
    for (size_t i = 0; i < COUNT(bad_headers); i++) {
        const bad_header_t *row = &bad_headers[i];
        counter = counter % 7 + 1;
        sdo(mail, counter, 0x40, 0x2000, 0);
        ect_store_le16(mail, row->length);
        mail[4] = row->channel;
        mail[5] = (uint8_t)(row->type | (counter << 4));
        assert_int_equal(send(&w, mail), 1);
        expect_fetch(&w, row->what, mail);
        if (row->detail != 0) {
            expect_error(row->what, mail, row->detail);
        } else if ((mail[5] & 0x0F) != 3 || mail[8] != 0x43) {
            fail_msg("%s: expected an SDO reply, got type %u, command 0x%02X", row->what, mail[5] & 0x0F, mail[8]);
        }
        counter = counter % 7 + 1;
        assert_int_equal(send_upload(&w, counter, 0x2000), 1);
        expect_fetch(&w, "the next request", mail);
        if (mail[8] != 0x43 || ect_load_le32(mail + 12) != 0x11223344)
            fail_msg("after %s: no reply to the next request", row->what);
        expect_empty(&w, row->what);
    }
    wire_close(&w);
}

static void services_checked(void **state)
{
    (void)state;
    static const uint8_t unknown[] = {0, 1, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15};
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    for (size_t i = 0; i < COUNT(unknown); i++) {
        char where[32];
        (void)snprintf(where, sizeof where, "CoE service %u", unknown[i]);
        sdo(mail, 0, 0x40, 0x2000, 0);
        mail[7] = (uint8_t)(unknown[i] << 4);
        assert_int_equal(send(&w, mail), 1);
        expect_fetch(&w, where, mail);
        expect_error(where, mail, 4);
    }
    wire_close(&w);
}

static void coe_not_offered(void **state)
{
    (void)state;
    ect_device_t device = testdev;
    device.protocols = NULL;
    wire_t w;
    uint8_t mail[SIZE];
    wire_open_one(&w, &device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (uint8_t type = 1; type <= 5; type++) {
        header(mail, 10, type, 0);
        assert_int_equal(send(&w, mail), 1);
        expect_fetch(&w, "not served", mail);
        expect_error("not served", mail, 2);
    }
    wire_close(&w);
}

/* --- content ----------------------------------------------------------------------------------------------------- */

static void no_stale_bytes(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    memset(testdev_of(&w, 0)->octets, 0xA5, sizeof testdev_of(&w, 0)->octets);
    for (unsigned int n = 0; n < 6; n++) {
        assert_int_equal(send_upload(&w, 0, 0x2002), 1);
        expect_fetch(&w, "long", mail);
        assert_int_equal(ect_load_le16(mail), SIZE - HEADER);
        assert_int_equal(mail[SIZE - 1], 0xA5);
        if (n % 3 == 0)
            emergency(&w, 0x8100);
        else if (n % 3 == 1)
            assert_int_equal(send_upload(&w, 0, 0x2000), 1);
        else
            assert_int_equal(send_upload(&w, 0, 0x5000), 1);
        expect_fetch(&w, "short", mail);
        assert_int_equal(ect_load_le16(mail), 10);
        for (unsigned int i = 16; i < SIZE; i++) {
            if (mail[i] != 0)
                fail_msg("short mail %u: byte %u is 0x%02X", n, i, mail[i]);
        }
    }
    wire_close(&w);
}

static void reply_header(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_preop(&w);
    sdo(mail, 1, 0x40, 0x2000, 0);
    mail[2] = 0x34;
    mail[3] = 0x12;
    assert_int_equal(send(&w, mail), 1);
    expect_fetch(&w, "reply", mail);
    uint16_t address = ect_load_le16(mail + 2);
    if (address != 0 && address != WIRE_STATION)
        fail_msg("address of the reply is 0x%04X", address);
    assert_int_equal(mail[4], 0);
    assert_int_equal(mail[5], 0x13);
    wire_close(&w);
}

/* --- lengths ----------------------------------------------------------------------------------------------------- */

/* One request, one reply, with an SM1 of `size` bytes. */
static uint16_t exchange(wire_t *w, uint8_t command, uint8_t *mail, uint16_t size)
{
    uint8_t out[SIZE];
    sdo(out, 0, command, (command & 0xE0) == 0x60 ? 0 : 0x2002, 0);
    assert_int_equal(send(w, out), 1);
    assert_true(full(w, SM1_STATUS));
    assert_int_equal(wire_read(w, 0, SM1, mail, size), 1);
    assert_false(full(w, SM1_STATUS));
    uint16_t length = ect_load_le16(mail);
    if (length + HEADER > size)
        fail_msg("SM1 of %u bytes: mail of length %u", size, length);
    return length;
}

static void upload_1000(wire_t *w, uint16_t size)
{
    uint8_t mail[256];
    uint8_t got[1000];
    uint16_t length = exchange(w, 0x40, mail, size);
    if (length != size - HEADER || mail[8] != 0x41 || ect_load_le32(mail + 12) != 1000)
        fail_msg("SM1 of %u bytes: length %u, command 0x%02X, size %u", size, length, mail[8],
                 ect_load_le32(mail + 12));
    size_t at = length - 10u;
    memcpy(got, mail + 16, at);
    uint8_t command = 0x60;
    while (at < sizeof got) {
        length = exchange(w, command, mail, size);
        size_t piece = length == 10 ? 7u - ((mail[8] >> 1) & 7u) : length - 3u;
        assert_true(at + piece <= sizeof got);
        memcpy(got + at, mail + 9, piece);
        at += piece;
        if ((mail[8] & 0x10) != (command & 0x10) || (mail[8] & 1) != (at == sizeof got))
            fail_msg("SM1 of %u bytes: segment command 0x%02X at %zu", size, mail[8], at);
        command ^= 0x10;
    }
    assert_memory_equal(got, testdev_of(w, 0)->octets, sizeof got);
}

static void lengths_in_use(void **state)
{
    (void)state;
    static const uint16_t sizes[] = {34, 35, 64, 127, 128, 129, 200, 255, 256};
    for (size_t i = 0; i < COUNT(sizes); i++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        wire_configure_mailbox(&w, 0);
        wire_set_sm(&w, 0, 1, SM1, sizes[i], 0x22);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), ECT_STATE_PREOP);
        for (unsigned int n = 0; n < 1000; n++)
            testdev_of(&w, 0)->octets[n] = (uint8_t)(n * 7 + 1);
        upload_1000(&w, sizes[i]);
        upload_1000(&w, sizes[i]);
        wire_close(&w);
    }
}

/* SM0 may vary on this device too. */
static void request_lengths(void **state)
{
    (void)state;
    static const struct {
        uint16_t size, length, detail;
    } rows[] = {{34, 28, 0},   {34, 29, 8},   {34, 122, 8},  {128, 122, 0},
                {128, 123, 8}, {256, 250, 0}, {256, 251, 8}, {256, 123, 0}};
    ect_device_t device = testdev;
    device.sm[0].minimum = 34;
    device.sm[0].maximum = 256;
    device.sm[1].start = 0x1100;
    for (size_t i = 0; i < COUNT(rows); i++) {
        wire_t w;
        uint8_t mail[256] = {0};
        uint8_t request[SIZE];
        wire_open_one(&w, &device);
        wire_configure_mailbox(&w, 0);
        wire_set_sm(&w, 0, 0, SM0, rows[i].size, 0x26);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), ECT_STATE_PREOP);
        sdo(request, 0, 0x40, 0x2000, 0);
        memcpy(mail, request, SIZE);
        ect_store_le16(mail, rows[i].length);
        assert_int_equal(wire_write(&w, 0, SM0, mail, rows[i].size), 1);
        assert_int_equal(wire_read(&w, 0, 0x1100, mail, SIZE), 1);
        if (rows[i].detail != 0)
            expect_error("too long", mail, rows[i].detail);
        else
            assert_int_equal(mail[8], 0x43);
        wire_close(&w);
    }
}

/* A list in many fragments: each can be lost, and a request in between gets its reply between two of them. */
static void fragments(void **state)
{
    (void)state;
    enum { SMALL = 34 };
    wire_t w;
    uint8_t mail[SIZE];
    uint8_t lost[SIZE];
    unsigned int objects = 0;
    wire_open_one(&w, &testdev);
    wire_configure_mailbox(&w, 0);
    wire_set_sm(&w, 0, 1, SM1, SMALL, 0x22);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
    header(mail, 8, 3, 1);
    mail[7] = 0x80;
    mail[8] = 1;  /* get OD list */
    mail[12] = 1; /* all objects */
    assert_int_equal(send(&w, mail), 1);
    assert_int_equal(send_write(&w, 2, 77), 1);
    for (unsigned int n = 1;; n++) {
        assert_int_equal(wire_read(&w, 0, SM1, lost, SMALL), 1);
        repeat(&w, "fragment lost");
        assert_int_equal(wire_read(&w, 0, SM1, mail, SMALL), 1);
        assert_memory_equal(mail, lost, SMALL);
        assert_int_equal(counter_of(mail), (n - 1) % 7 + 1);
        assert_int_equal(testdev_of(&w, 0)->written, 1);
        if (n == 2) {
            assert_int_equal(mail[8], 0x60);
            continue;
        }
        assert_int_equal(mail[7], 0x80);
        objects += (ect_load_le16(mail) - (n == 1 ? 8u : 6u)) / 2u;
        if (ect_load_le16(mail + 10) == 0)
            break;
    }
    assert_int_equal(objects, testdev.object_count);
    assert_int_equal(testdev_of(&w, 0)->u32, 77);
    wire_close(&w);
}

/* --- SyncManagers disabled and enabled ---------------------------------------------------------------------------- */

/* A mailbox SM is disabled and enabled while the slave does not poll, with and without a mail in SM1. The slave drops
 * to INIT, or the mailbox continues to work. */
static void reenabled(void **state)
{
    (void)state;
    for (unsigned int sm = 0; sm < 2; sm++) {
        for (unsigned int unread = 0; unread < 2; unread++) {
            wire_t w;
            uint8_t mail[SIZE];
            open_preop(&w);
            if (unread != 0)
                assert_int_equal(send_write(&w, 1, 1), 1);
            w.manual_poll = true;
            wire_set_sm(&w, 0, sm, sm == 0 ? SM0 : SM1, SIZE, sm == 0 ? 0x26 : 0x22);
            w.manual_poll = false;
            wire_poll(&w);
            uint8_t status = wire_read8(&w, 0, ECT_REG_AL_STATUS);
            if (status == (ECT_STATE_INIT | ECT_AL_ERROR)) {
                assert_int_equal(wire_read16(&w, 0, ECT_REG_AL_STATUS_CODE), 0x0016);
                wire_close(&w);
                continue;
            }
            assert_int_equal(status, ECT_STATE_PREOP);
            (void)fetch(&w, mail);
            assert_int_equal(send_write(&w, 2, 2), 1);
            if (!fetch(&w, mail) || testdev_of(&w, 0)->u32 != 2)
                fail_msg("SM%u off and on, %s unread: no reply to the next request", sm, unread ? "a mail" : "none");
            wire_close(&w);
        }
    }
}

/* PREOP refused by the device, then permitted: the emergencies of the device are still sent. */
static void refused_start(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    wire_open_one(&w, &testdev);
    wire_configure_mailbox(&w, 0);
    testdev_of(&w, 0)->state_change_answer = 0x8001;
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP);
    emergency(&w, 0x8100);
    expect_empty(&w, "in INIT");
    testdev_of(&w, 0)->state_change_answer = 0;
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP | ECT_AL_ACKNOWLEDGE);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), ECT_STATE_PREOP);
    expect_fetch(&w, "emergency of INIT", mail);
    assert_int_equal(ect_load_le16(mail + 8), 0x8100);
    wire_close(&w);
}

/* --- a bad line -------------------------------------------------------------------------------------------------- */

static uint32_t draw(uint32_t *x, uint32_t below)
{
    *x = *x * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)(*x >> 8) * below) >> 24);
}

typedef struct line {
    wire_t w;
    uint32_t x;
    uint32_t value;        /* of the last request */
    bool waiting;          /* for its reply */
    uint8_t last[2][SIZE]; /* the last two mails, to sort out repetitions */
    uint16_t emergencies_sent, emergencies_seen;
} line_t;

static void line_mail(line_t *l, const uint8_t *mail)
{
    if (memcmp(mail, l->last[0], SIZE) == 0 || memcmp(mail, l->last[1], SIZE) == 0)
        return;
    memcpy(l->last[0], l->last[1], SIZE);
    memcpy(l->last[1], mail, SIZE);
    if (mail[7] >> 4 == 1) {
        l->emergencies_seen++;
        assert_int_equal(ect_load_le16(mail + 8), l->emergencies_seen);
        return;
    }
    if (!l->waiting || mail[8] != 0x43 || ect_load_le32(mail + 12) != l->value)
        fail_msg("reply 0x%02X with value %u, expected value %u", mail[8], ect_load_le32(mail + 12), l->value);
    l->waiting = false;
}

/* The reply reports the written value: the test reads the value from the device's memory. */
static void line_request(line_t *l, bool duplicates)
{
    if (!l->waiting) {
        testdev_of(&l->w, 0)->u32 = l->value + 1;
        if (send_upload(&l->w, l->value % 7 + 1, 0x2000) == 1) {
            l->value++;
            l->waiting = true;
        }
    } else if (duplicates) {
        (void)send_upload(&l->w, (l->value + 6) % 7 + 1, 0x2000);
    }
}

static void line_lost(line_t *l)
{
    uint8_t mail[SIZE];
    if (!fetch(&l->w, mail))
        return;
    if (draw(&l->x, 2))
        wire_poll(&l->w);
    toggle(&l->w);
    if (draw(&l->x, 3) == 0 && draw(&l->x, 2)) {
        wire_poll(&l->w);
        toggle(&l->w);
    }
    for (unsigned int n = 0; n < 10 && !acknowledged(&l->w); n++)
        wire_poll(&l->w);
    assert_true(acknowledged(&l->w));
}

static void bad_line(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 60; seed++) {
        line_t l = {.x = seed * 2654435761u};
        bool duplicates = seed % 2 == 0; /* repeated requests and emergencies not together: only two mails are kept */
        open_preop(&l.w);
        l.w.manual_poll = true;
        for (unsigned int step = 0; step < 1500; step++) {
            uint8_t mail[SIZE];
            uint32_t kind = draw(&l.x, 10);
            if (kind < 2) {
                line_request(&l, duplicates);
            } else if (kind < 5) {
                wire_poll(&l.w);
            } else if (kind < 8) {
                if (fetch(&l.w, mail))
                    line_mail(&l, mail);
            } else if (kind == 8) {
                line_lost(&l);
            } else if (!duplicates && l.emergencies_sent - l.emergencies_seen < 4 && draw(&l.x, 4) == 0) {
                emergency(&l.w, ++l.emergencies_sent);
            }
        }
        l.w.manual_poll = false;
        for (unsigned int n = 0; n < 20; n++) {
            uint8_t mail[SIZE];
            wire_poll(&l.w);
            if (fetch(&l.w, mail))
                line_mail(&l, mail);
        }
        if (l.waiting || l.emergencies_seen != l.emergencies_sent || l.value < 50)
            fail_msg("seed %u: request %u %s, %u of %u emergencies came", seed, l.value,
                     l.waiting ? "without reply" : "answered", l.emergencies_seen, l.emergencies_sent);
        wire_close(&l.w);
    }
}

#define T(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    const struct CMUnitTest tests[] = {
        T("CF-016: a request goes into an empty SM0 only; while it is full a write has WKC 0", out_full),
        T("CF-016: SM0 is full, and the request executed, only with its last byte", out_last_byte),
        T("CF-016 CF-018: the actual length and the last byte in two datagrams of a frame are a request",
          out_actual_length_and_last_byte),
        T("CF-017: SM1 is read from its first byte, only when full, and is empty only after its last byte",
          in_partly_read),
        T("CF-024: replies count 1..7 in the slave's own sequence, whatever the master's counter", own_counter),
        T("CF-024: a request with the counter of the last one is not executed again, its reply is repeated",
          not_carried_out_again),
        T("CF-024: a request sent twice before its reply is fetched has one reply, though both are found at once",
          repeated_and_fetched_at_once),
        T("CF-024: counter 0 is never a repetition", counter_zero),
        T("CF-024: a counter older than the last is a new request", older_counter_is_new),
        T("CF-024 CF-025: a repetition while the reply is unread is dropped: that reply serves both",
          repeated_while_unread),
        T("CF-024: the error reply to a request is repeated too", repeated_error),
        T("CF-024: a repetition of a request without a reply has none", repeated_without_reply),
        T("CF-024: an emergency in between does not change the reply to a repetition", repeated_after_emergency),
        T("CF-024: a repeat while the repetition of a reply is in SM1 changes nothing", repeat_of_a_repetition),
        T("CF-024: two emergencies in between: the repetition is still not executed again",
          never_again_after_two_emergencies),
        T("CF-024: the last counter is discarded when the mailbox stops", stop_forgets),
        T("CF-025: INIT empties both mailboxes; nothing old is sent or executed after it", stop_empties),
        T("CF-025: a request is held while the previous reply is unread, and gets its reply in order", held),
        T("CF-025: a request is held behind emergencies", held_behind_emergency),
        T("CF-023: a repeat request before any mail is acknowledged, and no mail follows", repeat_nothing),
        T("CF-023: a lost mail is repeated unchanged, at each request", repeat_lost),
        T("CF-023: requested twice before it is read, the lost mail is sent once, and no older one", repeat_twice),
        T("CF-023: a repeat request while the first mail is unread does not change it", repeat_unread_first),
        T("CF-023: with a newer mail in SM1, the lost one is sent first, then the newer one", repeat_with_newer_mail),
        T("CF-023: the lost mail is lost again before and after the newer one is repeated", repeat_lost_again),
        T("CF-023: after the older mail, the newer one can be lost and repeated too", repeat_then_newest_lost),
        T("CF-023: repeat and a new request at once: the lost mail, then the reply", repeat_and_request_at_once),
        T("CF-023: a lost emergency is repeated", repeat_emergency),
        T("CF-023: a toggle that is set when the mailbox starts is no repeat", repeat_before_start),
        T("CF-023: the repeat is acknowledged only once the mail is in SM1, in both directions of the toggle",
          acknowledge_last),
        T("CF-026 CF-086: each bad header has an error reply with its detail, and the next request works",
          headers_checked),
        T("CF-026: unsupported CoE services get an error with detail 4", services_checked),
        T("CF-086: an unsupported protocol gets an error with detail 2, CoE too", coe_not_offered),
        T("CF-017: no bytes of an older mail remain behind a shorter one", no_stale_bytes),
        T("CF-023 CF-025: each fragment of a list can be repeated, and a request gets its reply between two of them",
          fragments),
        T("CF-024: address, channel and type of a reply", reply_header),
        T("CF-027: a long upload adapts to every length of SM1 from minimum to maximum", lengths_in_use),
        T("CF-027: requests are checked against the length of SM0 that the master has set", request_lengths),
        T("CF-021 CF-022: a mailbox SM off and on before the slave polls: 0x0016, or the mailbox continues", reenabled),
        T("CF-033: a refused start of the mailbox loses no mail", refused_start),
        T("CF-023 CF-024 CF-025: over a bad line every request gets one reply, in order, and no mail is lost",
          bad_line),
    };
    return cmocka_run_group_tests_name("Mailbox", tests, NULL, NULL);
}
