/* SPDX-License-Identifier: MIT */
/* The bounds that a reader keeps to, counted at the wire: tries, mails that are skipped, steps of a progress. */
#define _GNU_SOURCE
#include "reader/reader.h"

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

#include "support/liar.h"
#include "support/testdev.h"
#include "wire/bytes.h"
#include "wire/registers.h"
#include "wire/sii.h"

enum { INDEX = 0x2345, SUBINDEX = 6, EMERGENCY = 1, RESPONSE = 3, INFO = 8, EEPROM_TRIES = 10, SKIPS = 64 };
enum { UPLOAD = 0x40, INIT = 1, PREOP = 2, GUARD = 4096 };
enum { MAIL_OUT = 0x1000, MAIL_SIZE = 128, SM1_STATUS = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS };

static ect_reader_t reader;

/* --- frames ------------------------------------------------------------------------------------------------------- */

static bool loses_all_from_number(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)d;
    (void)ado;
    (void)data;
    (void)length;
    (void)wkc;
    return l->frames < l->number;
}

static void frames_are_tried_as_often_as_configured(void **state)
{
    static const struct {
        unsigned int tries, frames;
    } rows[] = {{0, 3}, {1, 1}, {2, 2}, {7, 7}};
    static const liar_kind_t kind = {"lost", .datagram = loses_all_from_number};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_reader_config_t config = {.tries = rows[i].tries};
        uint8_t bytes[2];
        liar_t l;
        liar_open(&l, &testdev, &kind);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_LOST);
        assert_string_equal(reader.text, "no frame returns: is a slave connected?");
        assert_int_equal(l.frames, rows[i].frames);
        l.number = UINT64_MAX;
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        l.number = 0;
        l.frames = 0;
        assert_int_equal(ect_reader_registers(&reader, 0x0110, bytes, 2), ECT_READER_LOST);
        assert_string_equal(reader.text, "no frame returns (0x0110)");
        assert_int_equal(l.frames, rows[i].frames);
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* Each frame: broadcast, from 02-00-00-00-00-01, its index one more than that of the previous frame. */
static bool watches_headers(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    static const uint8_t header[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0, 0, 0, 1, 0x88, 0xA4};
    (void)ado;
    (void)data;
    (void)wkc;
    assert_memory_equal(d - 16, header, sizeof header);
    assert_int_equal(ect_load_le16(d - 2), 0x1000 + 10 + length + 2);
    assert_int_equal(d[1], (uint8_t)++l->number);
    return true;
}

static void frames_are_numbered(void **state)
{
    static const liar_kind_t kind = {"watched", .datagram = watches_headers};
    static uint8_t image[ECT_READER_SII];
    size_t size;
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(ect_reader_sii(&reader, image, 0, &size), ECT_READER_OK);
    assert_true(l.number > 256);
    ect_reader_close(&reader);
    liar_close(&l);
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------- */

/* Counts reads until the EEPROM acknowledges one, in the high half of the number; the low half: how many it does not.
 */
static bool acknowledges_late(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    const uint64_t silent = l->number & 0xFFFF;
    (void)wkc;
    if (ado != ECT_REG_SII_CONTROL)
        return true;
    if (length == 6 && (d[0] == 2 || d[0] == 5) && ect_load_le16(data) == 0x0100)
        l->number += 0x10000;
    if ((d[0] == 1 || d[0] == 4) && l->number >> 16 > 0 && l->number >> 16 <= silent)
        data[1] |= 0x20;
    return true;
}

static void a_read_of_the_eeprom_is_tried_ten_times(void **state)
{
    static const liar_kind_t kind = {"late", .datagram = acknowledges_late};
    (void)state;
    for (unsigned int silent = EEPROM_TRIES - 1; silent <= EEPROM_TRIES; silent++) {
        liar_t l;
        liar_open(&l, &testdev, &kind);
        l.number = silent;
        const uint64_t begin_ns = l.w.now_ns;
        const ect_reader_result_t result = ect_reader_open(&reader, &l.link, NULL);
        assert_int_equal(result, silent < EEPROM_TRIES ? ECT_READER_OK : ECT_READER_WRONG);
        assert_true(l.w.now_ns - begin_ns > silent * MS); /* an EEPROM that is writing needs milliseconds */
        if (silent == EEPROM_TRIES) {
            assert_string_equal(reader.text, "the EEPROM does not acknowledge a read of word 0x0000");
            assert_int_equal(l.number >> 16, EEPROM_TRIES);
        }
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* Sets an EEPROM of 128 KiB, the rest of which is a category from the header to `end`, without an end mark. */
static void set_category(ect_esc_t *esc, uint8_t sii[1024], size_t end)
{
    memcpy(sii, esc->config.sii, ECT_READER_HEADER);
    ect_store_le16(sii + 0x7C, ECT_READER_SII / 128 - 1);
    ect_store_le16(sii + ECT_READER_HEADER, 30);
    ect_store_le16(sii + ECT_READER_HEADER + 2, (uint16_t)((end - ECT_READER_HEADER - 4) / 2));
    esc->config.sii = sii;
    esc->config.sii_size = 1024;
}

/* The image ends at a page without access. */
static void categories_up_to_the_end_of_an_eeprom_are_read(void **state)
{
    static const size_t ends[] = {ECT_READER_SII - 4, ECT_READER_SII - 2, ECT_READER_SII};
    uint8_t *image = mmap(NULL, ECT_READER_SII + GUARD, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    (void)state;
    assert_true(image != MAP_FAILED);
    assert_int_equal(mprotect(image + ECT_READER_SII, GUARD, PROT_NONE), 0);
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        uint8_t sii[1024] = {0};
        size_t size = 0;
        liar_t l;
        liar_open(&l, &testdev, NULL);
        set_category(ect_chain_esc(l.w.chain, 0), sii, ends[i]);
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        assert_int_equal(ect_reader_sii_content(&reader, image, &size), ECT_READER_OK);
        assert_int_equal(size, ECT_READER_SII);
        ect_reader_close(&reader);
        liar_close(&l);
    }
    assert_int_equal(munmap(image, ECT_READER_SII + GUARD), 0);
}

/* --- polls -------------------------------------------------------------------------------------------------------- */

/* A wait of the reader: its polls are one command at one address, and a write to `begin` starts it. */
typedef struct wait {
    const char *title;
    uint8_t command;
    uint16_t address; /* 0: the mailbox to the slave */
    uint16_t begin;   /* 0: the first poll */
    uint8_t at, mask, value;
    ect_reader_config_t config;
    size_t polls; /* until the timeout */
} wait_t;

enum { POLLS = 20 };

static const wait_t *waited;
static uint64_t polled_ns[POLLS];
static size_t polls;

/* Keeps the times of the first polls, and changes a byte of its reply so that the wait goes on. */
static bool keeps_waiting(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    const uint16_t address = waited->address != 0 ? waited->address : l->out_start;
    (void)length;
    if (d[0] == APWR && ado == waited->begin)
        polls = 0;
    if (d[0] != waited->command || ado != address)
        return true;
    if (polls < POLLS)
        polled_ns[polls] = l->w.now_ns;
    polls++;
    if (d[0] == APWR)
        ect_store_le16(wkc, 0);
    else
        data[waited->at] = (uint8_t)((data[waited->at] & ~waited->mask) | waited->value);
    return true;
}

static liar_mail_t swallows(liar_t *l, const uint8_t *r)
{
    (void)l;
    (void)r;
    return LIAR_SWALLOWS;
}

/* The rows end at a poll exactly at the timeout, which is the last; a mailbox that is full is not polled then. */
static void the_pause_between_polls_grows_until_the_timeout(void **state)
{
    static const wait_t rows[] = {
        {"EEPROM busy", APRD, ECT_REG_SII_CONTROL, 0, 1, 0x80, 0x80, {.tries = 1}, 1006},
        {"state not reached", APRD, ECT_REG_AL_STATUS, ECT_REG_AL_CONTROL, 0, 0x1F, INIT, {.state_ms = 9}, 24},
        {"mailbox full", APWR, 0, 0, 0, 0, 0, {.tries = 1, .reply_ms = 9}, 23},
        {"no reply", APRD, SM1_STATUS, MAIL_OUT, 0, 0, 0, {.tries = 1, .reply_ms = 10}, 25},
    };
    static const liar_kind_t kind = {"waited for", .request = swallows, .datagram = keeps_waiting};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t value[4];
        size_t size = sizeof value;
        liar_t l;
        waited = &rows[i];
        polls = 0;
        liar_open(&l, &testdev, &kind);
        if (ect_reader_open(&reader, &l.link, &waited->config) == ECT_READER_OK)
            (void)ect_reader_upload(&reader, INDEX, SUBINDEX, false, value, &size);
        if (reader.result != ECT_READER_SILENT || polls != waited->polls)
            fail_msg("%s: expected %zu polls, got result %d after %zu", waited->title, waited->polls, reader.result,
                     polls);
        for (size_t n = 1; n < POLLS; n++) {
            const uint64_t expected_ns = FRAME_NS + (n <= 8 ? 20000 : n <= 16 ? 200000 : MS);
            if (polled_ns[n] - polled_ns[n - 1] != expected_ns)
                fail_msg("%s, poll %zu: expected after %llu ns, got %llu", waited->title, n,
                         (unsigned long long)expected_ns, (unsigned long long)(polled_ns[n] - polled_ns[n - 1]));
        }
        l.kind = NULL;
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* A slave without a chip on a clock that never moves: each frame returns processed, with zeros but for the EEPROM. */
typedef struct still {
    uint8_t command; /* a datagram that keeps the reader waiting */
    uint16_t address;
    uint8_t at, value; /* a byte of its data; at a write: its working counter is 0 */
    uint8_t status;    /* AL status */
    uint16_t word;     /* of the EEPROM */
    size_t length;
    uint64_t now_ns;
    unsigned int polls;
    uint8_t frame[ECT_READER_FRAME];
} still_t;

static void still_send(void *ctx, const uint8_t *frame, size_t length)
{
    still_t *s = ctx;
    uint8_t *d = s->frame + 16, *data = d + 10;
    const uint16_t ado = ect_load_le16(frame + 20), bytes = ect_load_le16(frame + 22) & 0x7FF;
    memcpy(s->frame, frame, length);
    s->length = length;
    ect_store_le16(data + bytes, 1);
    if (d[0] == APWR && ado == ECT_REG_SII_CONTROL && bytes == 6)
        s->word = ect_load_le16(data + 2);
    if (d[0] == APRD && ado == ECT_REG_SII_DATA && s->word == ECT_SII_AT_MAILBOX_OUT / 2)
        ect_store_le32(data, MAIL_OUT | MAIL_SIZE << 16);
    if (d[0] == APRD && ado == ECT_REG_SII_DATA && s->word == ECT_SII_AT_MAILBOX_IN / 2)
        ect_store_le32(data, (MAIL_OUT + MAIL_SIZE) | MAIL_SIZE << 16);
    if (d[0] == APRD && ado == ECT_REG_AL_STATUS)
        data[0] = s->status;
    if (d[0] == APRD && ado == ECT_REG_SM) {
        ect_store_le32(data, MAIL_OUT | MAIL_SIZE << 16);
        ect_store_le32(data + ECT_SM_SIZE, (MAIL_OUT + MAIL_SIZE) | MAIL_SIZE << 16);
        data[ECT_SM_CONTROL] = 0x26;
        data[ECT_SM_SIZE + ECT_SM_CONTROL] = 0x22;
        data[ECT_SM_ACTIVATE] = data[ECT_SM_SIZE + ECT_SM_ACTIVATE] = 1;
    }
    if (d[0] != s->command || ado != s->address)
        return;
    s->polls++;
    data[s->at] = s->value;
    ect_store_le16(data + bytes, d[0] == APRD);
}

static size_t still_receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    const still_t *s = ctx;
    (void)until_ns;
    assert_true(s->length <= room);
    memcpy(frame, s->frame, s->length);
    return s->length;
}

static uint64_t still_now(void *ctx)
{
    return ((const still_t *)ctx)->now_ns;
}

static void still_wait(void *ctx, uint64_t until_ns)
{
    (void)ctx;
    (void)until_ns;
}

static ect_reader_link_t link_of(still_t *s)
{
    return (ect_reader_link_t){
        .ctx = s, .send = still_send, .receive = still_receive, .now = still_now, .wait = still_wait};
}

static void a_wait_ends_without_a_clock(void **state)
{
    enum { MOST = 100000 };
    static const struct {
        const char *title;
        still_t slave;
        unsigned int polls; /* with those before the wait: of the state found, of old mails */
    } rows[] = {
        {"EEPROM busy", {.command = APRD, .address = ECT_REG_SII_CONTROL, .at = 1, .value = 0x80}, MOST},
        {"state not reached", {.command = APRD, .address = ECT_REG_AL_STATUS, .value = 0x0F}, 2 + MOST},
        {"mailbox full", {.command = APWR, .address = MAIL_OUT, .status = PREOP}, MOST},
        {"no reply", {.command = APRD, .address = SM1_STATUS, .status = PREOP}, 1 + MOST},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static const ect_reader_config_t config = {.tries = 1};
        still_t s = rows[i].slave;
        const ect_reader_link_t link = link_of(&s);
        uint8_t value[4];
        size_t size = sizeof value;
        if (ect_reader_open(&reader, &link, &config) == ECT_READER_OK)
            (void)ect_reader_upload(&reader, INDEX, SUBINDEX, false, value, &size);
        if (reader.result != ECT_READER_SILENT || s.polls != rows[i].polls)
            fail_msg("%s: expected %u polls, got result %d after %u", rows[i].title, rows[i].polls, reader.result,
                     s.polls);
        s.command = 0;
        ect_reader_close(&reader);
    }
}

static void the_limit_is_a_time_to_the_nanosecond(void **state)
{
    static const ect_reader_config_t config = {.limit_ms = 5};
    still_t s = {.now_ns = 7 * MS};
    const ect_reader_link_t link = link_of(&s);
    uint8_t byte;
    (void)state;
    assert_int_equal(ect_reader_open(&reader, &link, &config), ECT_READER_OK);
    s.now_ns = 12 * MS - 1;
    assert_int_equal(ect_reader_registers(&reader, ECT_REG_TYPE, &byte, 1), ECT_READER_OK);
    s.now_ns = 12 * MS;
    assert_int_equal(ect_reader_registers(&reader, ECT_REG_TYPE, &byte, 1), ECT_READER_STOPPED);
    assert_string_equal(reader.text, "not finished within 5 ms");
    ect_reader_close(&reader);
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

static void set_emergency(liar_t *l)
{
    static const uint8_t emergency[8] = {0x00, 0x10};
    liar_set_coe_mail(l, EMERGENCY, emergency, sizeof emergency);
}

static void set_reply(liar_t *l)
{
    static const uint8_t reply[8] = {0x4F, INDEX & 0xFF, INDEX >> 8, SUBINDEX, 0x77};
    liar_set_coe_mail(l, RESPONSE, reply, sizeof reply);
}

/* liar_t::number: the emergencies that are left. */
static liar_mail_t emergencies_first(liar_t *l, const uint8_t *r)
{
    if ((r[5] & 0x0F) != 3 || r[8] != 0x40)
        return LIAR_SWALLOWS;
    l->number--;
    set_emergency(l);
    return LIAR_REPLIES;
}

static bool then_the_reply(liar_t *l)
{
    if (l->number == UINT64_MAX)
        return false;
    if (l->number-- > 0)
        set_emergency(l);
    else
        set_reply(l);
    return true;
}

static void a_request_skips_63_mails(void **state)
{
    static const liar_kind_t kind = {"emergencies", .request = emergencies_first, .next = then_the_reply};
    const ect_reader_config_t config = {.tries = 1};
    (void)state;
    for (unsigned int before = SKIPS - 1; before <= SKIPS; before++) {
        uint8_t value[8];
        size_t size = sizeof value;
        liar_t l;
        liar_open(&l, &testdev, &kind);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
        l.number = before;
        const ect_reader_result_t result = ect_reader_upload(&reader, INDEX, SUBINDEX, false, value, &size);
        assert_int_equal(result, before < SKIPS ? ECT_READER_OK : ECT_READER_WRONG);
        if (result == ECT_READER_OK)
            assert_true(size == 1 && value[0] == 0x77);
        l.kind = NULL;
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* A mailbox error of liar_t::number bytes. */
static liar_mail_t refuses_in_some_bytes(liar_t *l, const uint8_t *r)
{
    static const uint8_t error[6] = {1, 0, 0x34, 0x12, 0x78, 0x56};
    (void)r;
    liar_set_mail(l, 0, error, l->number);
    return LIAR_REPLIES;
}

static void a_mailbox_error_has_its_code_in_the_second_word(void **state)
{
    static const struct {
        unsigned int bytes;
        uint32_t code;
        const char *text;
    } rows[] = {{6, 0x1234, "the slave refuses the mail with mailbox error 0x1234"},
                {4, 0x1234, "the slave refuses the mail with mailbox error 0x1234"},
                {3, 0, "the slave refuses the mail with mailbox error 0x0000"},
                {0, 0, "the slave refuses the mail with mailbox error 0x0000"}};
    static const liar_kind_t kind = {"refuses", .request = refuses_in_some_bytes};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t value[4];
        size_t size = sizeof value;
        liar_t l;
        liar_open(&l, &testdev, &kind);
        l.number = rows[i].bytes;
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        assert_int_equal(ect_reader_upload(&reader, INDEX, SUBINDEX, false, value, &size), ECT_READER_REFUSED);
        assert_int_equal(reader.code, rows[i].code);
        assert_string_equal(reader.text, rows[i].text);
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* A segment request has no content behind its command but the object (ETG.1000.6 table 36 reserves the rest). */
static liar_mail_t watches_segments(liar_t *l, const uint8_t *r)
{
    static const uint8_t none[4];
    if ((r[5] & 0x0F) == 3 && r[7] >> 4 == 2 && (r[8] & 0xEF) == 0x60) {
        assert_memory_equal(r + 12, none, sizeof none);
        assert_int_equal(r[8] >> 4 & 1, l->number++ % 2);
    }
    return LIAR_PASSES;
}

static void segment_requests_alternate(void **state)
{
    static const liar_kind_t kind = {"watched", .request = watches_segments};
    static uint8_t value[4096];
    size_t most = 0;
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    for (unsigned int index = 0x1008; index < 0x2100; index += index == 0x100A ? 0xFF6 : 1) {
        size_t size = sizeof value;
        l.number = 0;
        if (ect_reader_upload(&reader, (uint16_t)index, 0, true, value, &size) == ECT_READER_OK)
            most = size > most ? size : most;
    }
    assert_true(most > 0);
    ect_reader_close(&reader);
    liar_close(&l);
}

/* A description that announces no details has none, whatever follows it: its name. */
static liar_mail_t describes_without_details(liar_t *l, const uint8_t *r)
{
    if ((r[5] & 0x0F) != 3 || r[7] >> 4 != INFO || r[8] != 5)
        return LIAR_PASSES;
    const uint8_t reply[] = {6,   0,   0,   0,   r[12], r[13], r[14], (uint8_t)l->number, 5, 0, 8, 0, 7, 0, 'a',
                             'b', 'c', 'd', 'e', 'f',   'g',   'h'};
    liar_set_coe_mail(l, INFO, reply, sizeof reply);
    return LIAR_REPLIES;
}

static void details_are_those_announced(void **state)
{
    static const struct {
        uint8_t announced;
        const char *unit, *preset, *minimum, *maximum, *name;
    } rows[] = {
        {0x00, "", "", "", "", "abcdefgh"}, {0x08, "ab", "", "", "", "cdefgh"}, {0x10, "", "a", "", "", "bcdefgh"},
        {0x20, "", "", "a", "", "bcdefgh"}, {0x40, "", "", "", "a", "bcdefgh"}, {0x78, "ab", "c", "d", "e", "fgh"},
        {0x28, "ab", "", "c", "", "defgh"}, {0x07, "", "", "", "", "abcdefgh"},
    };
    static const liar_kind_t kind = {"described", .request = describes_without_details};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_reader_entry_t entry;
        liar_t l;
        liar_open(&l, &testdev, &kind);
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        l.number = rows[i].announced;
        assert_int_equal(ect_reader_entry(&reader, INDEX, SUBINDEX, &entry), ECT_READER_OK);
        const struct {
            const char *want;
            ect_reader_bytes_t got;
        } parts[] = {{rows[i].unit, entry.unit},
                     {rows[i].preset, entry.preset},
                     {rows[i].minimum, entry.minimum},
                     {rows[i].maximum, entry.maximum},
                     {rows[i].name, entry.name}};
        for (size_t n = 0; n < sizeof parts / sizeof parts[0]; n++) {
            if (parts[n].got.length != strlen(parts[n].want) ||
                memcmp(parts[n].got.data ? (const char *)parts[n].got.data : "", parts[n].want, parts[n].got.length) !=
                    0)
                fail_msg("announced %02x, part %zu: expected '%s', got %zu bytes", rows[i].announced, n, parts[n].want,
                         parts[n].got.length);
        }
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* The first list ends early, behind an index that no object has. */
static liar_mail_t half_a_list_first(liar_t *l, const uint8_t *r)
{
    static const uint8_t half[] = {2 | 0x80, 0, 1, 0, 1, 0, 0x77, 0x77};
    if ((r[5] & 0x0F) != 3 || r[7] >> 4 != INFO || r[8] != 1 || l->number++ > 0)
        return LIAR_PASSES;
    liar_set_coe_mail(l, INFO, half, sizeof half);
    return LIAR_REPLIES;
}

static void a_list_that_is_repeated_begins_anew(void **state)
{
    static const liar_kind_t kind = {"half a list", .request = half_a_list_first};
    size_t counts[2];
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        liar_t l;
        liar_open(&l, &testdev, i == 0 ? NULL : &kind);
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        assert_int_equal(ect_reader_list(&reader, &counts[i]), ECT_READER_OK);
        assert_int_equal(l.number, i == 0 ? 0 : 2);
        ect_reader_close(&reader);
        liar_close(&l);
    }
    assert_int_equal(counts[1], counts[0]);
}

/* --- values ------------------------------------------------------------------------------------------------------- */

/* Objects of one byte, all readable; their uploads are noted. */
static const uint16_t around[] = {0x0FFF, 0x1000, 0x1001, 0x1007, 0x1008, 0x1009, 0x1017, 0x1018, 0x1019,
                                  0x15FF, 0x1600, 0x1BFF, 0x1C00, 0x1C0F, 0x1C10, 0x1C2F, 0x1C30};
static uint16_t uploaded[32];
static size_t uploads;

static liar_mail_t has_objects_of_one_byte(liar_t *l, const uint8_t *r)
{
    const uint8_t opcode = r[8];
    uint8_t list[6 + sizeof around] = {2, 0, 0, 0, 1, 0};
    const uint8_t object[] = {4, 0, 0, 0, r[12], r[13], 5, 0, 0, 7};
    const uint8_t entry[] = {6, 0, 0, 0, r[12], r[13], r[14], 0, 5, 0, 8, 0, 7, 0};
    const uint8_t value[8] = {0x4F, r[9], r[10], r[11], 0};
    for (size_t i = 0; i < sizeof around / sizeof around[0]; i++)
        ect_store_le16(list + 6 + 2 * i, around[i]);
    if (r[7] >> 4 != INFO) {
        assert_true(opcode == UPLOAD && uploads < sizeof uploaded / sizeof uploaded[0]);
        uploaded[uploads++] = ect_load_le16(r + 9);
        liar_set_coe_mail(l, RESPONSE, value, sizeof value);
    } else if (opcode == 1)
        liar_set_coe_mail(l, INFO, list, sizeof list);
    else if (opcode == 3)
        liar_set_coe_mail(l, INFO, object, sizeof object);
    else
        liar_set_coe_mail(l, INFO, entry, sizeof entry);
    return LIAR_REPLIES;
}

static void ignores_object(void *ctx, const ect_reader_object_t *object)
{
    (void)ctx;
    (void)object;
}

static void ignores_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    (void)ctx;
    (void)object;
    (void)entry;
}

static void values_of_identity_and_pdos_end_at_their_indices(void **state)
{
    static const uint16_t expected[] = {0x1000, 0x1008, 0x1018, 0x1600, 0x1BFF, 0x1C10, 0x1C2F};
    static const liar_kind_t kind = {"objects of one byte", .request = has_objects_of_one_byte};
    static const ect_reader_sink_t sink = {.object = ignores_object, .entry = ignores_entry};
    liar_t l;
    (void)state;
    uploads = 0;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), ECT_READER_OK);
    assert_int_equal(uploads, sizeof expected / sizeof expected[0]);
    assert_memory_equal(uploaded, expected, sizeof expected);
    ect_reader_close(&reader);
    liar_close(&l);
}

/* 1C12h with one element, the PDO 1A00h in liar_t::number bytes. */
static liar_mail_t assigns_in_some_bytes(liar_t *l, const uint8_t *r)
{
    const bool assignment = r[7] >> 4 == 2 && r[8] == UPLOAD && ect_load_le16(r + 9) == 0x1C12;
    if (!assignment) {
        if (r[7] >> 4 == 2 && uploads < sizeof uploaded / sizeof uploaded[0])
            uploaded[uploads++] = ect_load_le16(r + 9);
        return LIAR_PASSES;
    }
    const uint8_t bytes = r[11] == 0 ? 1 : (uint8_t)l->number;
    uint8_t value[8] = {(uint8_t)(0x43 | (4 - bytes) << 2), r[9], r[10], r[11]};
    ect_store_le32(value + 4, r[11] == 0 ? 1 : 0x1A00);
    liar_set_coe_mail(l, RESPONSE, value, sizeof value);
    return LIAR_REPLIES;
}

static void an_assigned_pdo_has_an_index_of_two_bytes(void **state)
{
    static const struct {
        unsigned int bytes;
        size_t uploads; /* of 1A00h: its count of three and its elements */
    } rows[] = {{1, 0}, {2, 4}, {3, 4}, {4, 4}};
    static const liar_kind_t kind = {"assigned", .request = assigns_in_some_bytes};
    static const ect_reader_sink_t sink = {.object = ignores_object, .entry = ignores_entry};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        liar_t l;
        uploads = 0;
        liar_open(&l, &testdev, &kind);
        l.number = rows[i].bytes;
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        assert_int_equal(ect_reader_assigned(&reader, 1u << 2, &sink), ECT_READER_OK);
        if (uploads != rows[i].uploads || (uploads > 0 && uploaded[0] != 0x1A00))
            fail_msg("%u bytes: expected %zu uploads of 1A00, got %zu, the first of %04X", rows[i].bytes,
                     rows[i].uploads, uploads, uploaded[0]);
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

static liar_mail_t notes_uploads(liar_t *l, const uint8_t *r)
{
    (void)l;
    if (r[7] >> 4 == 2 && uploads < sizeof uploaded / sizeof uploaded[0])
        uploaded[uploads++] = ect_load_le16(r + 9);
    return LIAR_PASSES;
}

static void each_sync_manager_has_its_assignment(void **state)
{
    static const liar_kind_t kind = {"noted", .request = notes_uploads};
    static const ect_reader_sink_t sink = {.object = ignores_object, .entry = ignores_entry};
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    for (unsigned int sm = 0; sm < 32; sm++) {
        uploads = 0;
        assert_int_equal(ect_reader_assigned(&reader, UINT32_C(1) << sm, &sink), ECT_READER_OK);
        assert_true(uploads > 0);
        assert_int_equal(uploaded[0], 0x1C10 + sm);
    }
    uploads = 0;
    assert_int_equal(ect_reader_assigned(&reader, 0, &sink), ECT_READER_OK);
    assert_int_equal(uploads, 0);
    ect_reader_close(&reader);
    liar_close(&l);
}

/* --- progress ----------------------------------------------------------------------------------------------------- */

typedef struct steps {
    unsigned int count, most; /* the step that is refused */
    unsigned int all, objects;
} steps_t;

static bool takes_step(void *ctx, const char *what, unsigned int done, unsigned int all)
{
    steps_t *steps = ctx;
    if (strcmp(what, "objects") != 0)
        return true;
    assert_int_equal(done, steps->count);
    steps->all = all;
    return steps->count++ < steps->most;
}

static void takes_object(void *ctx, const ect_reader_object_t *object)
{
    (void)object;
    ((steps_t *)ctx)->objects++;
}

static void progress_counts_objects(void **state)
{
    static const unsigned int limits[] = {UINT32_MAX, 0, 5};
    (void)state;
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        steps_t steps = {.most = limits[i]};
        const ect_reader_config_t config = {.progress = takes_step, .progress_ctx = &steps};
        const ect_reader_sink_t sink = {.object = takes_object, .entry = ignores_entry, .ctx = &steps};
        size_t count;
        liar_t l;
        liar_open(&l, &testdev, NULL);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        assert_int_equal(ect_reader_list(&reader, &count), ECT_READER_OK);
        const ect_reader_result_t result = ect_reader_dictionary(&reader, ECT_READER_ALL_VALUES, &sink);
        assert_int_equal(steps.all, count);
        if (limits[i] == UINT32_MAX) {
            assert_int_equal(result, ECT_READER_OK);
            assert_int_equal(steps.count, count);
            assert_int_equal(steps.objects, count);
        } else {
            assert_int_equal(result, ECT_READER_STOPPED);
            assert_string_equal(reader.text, "stopped by the user");
            assert_int_equal(steps.objects, limits[i]);
        }
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* The user stops the reader at one of its questions, and keeps to it. */
typedef struct user {
    const liar_t *l;
    unsigned int questions, stops_at;
    unsigned int frames; /* until the stop */
} user_t;

static bool is_stopped(void *ctx)
{
    user_t *u = ctx;
    const bool stops = u->questions++ >= u->stops_at;
    if (stops && u->questions == u->stops_at + 1)
        u->frames = u->l->frames;
    return stops;
}

static ect_reader_result_t read_value(const liar_t *l, user_t *user)
{
    const ect_reader_config_t config = {.stopped = is_stopped, .progress_ctx = user};
    uint8_t value[4];
    size_t size = sizeof value;
    if (ect_reader_open(&reader, &l->link, &config) == ECT_READER_OK)
        (void)ect_reader_upload(&reader, 0x1000, 0, false, value, &size);
    return reader.result;
}

static void no_frame_follows_a_stop(void **state)
{
    static const uint64_t lost_from[] = {UINT64_MAX, 1, 40}; /* frames; from a number on each is lost */
    static const liar_kind_t kind = {"lost", .datagram = loses_all_from_number};
    (void)state;
    for (size_t i = 0; i < sizeof lost_from / sizeof lost_from[0]; i++) {
        ect_reader_result_t result = ECT_READER_STOPPED;
        for (unsigned int stops_at = 0; result == ECT_READER_STOPPED; stops_at++) {
            liar_t l;
            user_t user = {.l = &l, .stops_at = stops_at};
            liar_open(&l, &testdev, &kind);
            l.number = lost_from[i];
            result = read_value(&l, &user);
            const unsigned int frames = l.frames;
            l.number = UINT64_MAX;
            ect_reader_close(&reader);
            if (user.questions > stops_at && (result != ECT_READER_STOPPED || frames != user.frames ||
                                              strcmp(reader.text, "stopped by the user") != 0))
                fail_msg("stopped at question %u: expected no frame after %u, got %u; result %d, '%s'", stops_at,
                         user.frames, frames, result, reader.text);
            assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), INIT);
            liar_close(&l);
        }
        assert_int_equal(result, i == 0 ? ECT_READER_OK : ECT_READER_LOST);
    }
}

static void the_user_stops_a_wait_for_a_state(void **state)
{
    user_t user = {.stops_at = 2000};
    static const liar_kind_t kind = {"waited for", .datagram = keeps_waiting};
    static const wait_t never = {
        "state not reached", APRD, ECT_REG_AL_STATUS, ECT_REG_AL_CONTROL, 0, 0x1F, INIT, {0}, 0};
    liar_t l;
    (void)state;
    waited = &never;
    polls = 0;
    liar_open(&l, &testdev, &kind);
    user.l = &l;
    assert_int_equal(read_value(&l, &user), ECT_READER_STOPPED);
    assert_string_equal(reader.text, "stopped by the user");
    assert_int_equal(l.frames, user.frames);
    l.kind = NULL;
    ect_reader_close(&reader);
    liar_close(&l);
}

/* The caller takes longer over the first entry than the reader may run. */
static void holds_up(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    liar_t *l = ctx;
    (void)object;
    (void)entry;
    l->number++;
    wire_advance(&l->w, 600000 * MS);
}

static void fails_with_gap(void *ctx, const ect_reader_gap_t *gap)
{
    (void)ctx;
    fail_msg("gap at %04X", gap->index);
}

static void a_limit_between_two_objects_is_no_gap(void **state)
{
    liar_t l;
    const ect_reader_sink_t sink = {.object = ignores_object, .entry = holds_up, .gap = fails_with_gap, .ctx = &l};
    (void)state;
    liar_open(&l, &testdev, NULL);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), ECT_READER_STOPPED);
    assert_string_equal(reader.text, "not finished within 600000 ms");
    assert_int_equal(l.number, 1); /* 1000h has one entry */
    ect_reader_close(&reader);
    liar_close(&l);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a frame that is lost is repeated as often as configured", frames_are_tried_as_often_as_configured, NULL, NULL,
         NULL},
        {"frames have their addresses, length and number", frames_are_numbered, NULL, NULL, NULL},
        {"an EEPROM without acknowledge is read ten times", a_read_of_the_eeprom_is_tried_ten_times, NULL, NULL, NULL},
        {"the categories of an EEPROM end with it, without an end mark too",
         categories_up_to_the_end_of_an_eeprom_are_read, NULL, NULL, NULL},
        {"a poll follows the one before after 20 us, from the ninth after 200 us, from the seventeenth after 1 ms, "
         "to the timeout",
         the_pause_between_polls_grows_until_the_timeout, NULL, NULL, NULL},
        {"a wait ends after 100000 polls on a clock that never moves", a_wait_ends_without_a_clock, NULL, NULL, NULL},
        {"the limit stops the reader at its nanosecond", the_limit_is_a_time_to_the_nanosecond, NULL, NULL, NULL},
        {"a request skips 63 mails that are no reply", a_request_skips_63_mails, NULL, NULL, NULL},
        {"a mailbox error has its code in the second word, or none", a_mailbox_error_has_its_code_in_the_second_word,
         NULL, NULL, NULL},
        {"segment requests alternate, and have no content", segment_requests_alternate, NULL, NULL, NULL},
        {"the details of an entry are those that its description announces", details_are_those_announced, NULL, NULL,
         NULL},
        {"a list that is repeated has no object of the first", a_list_that_is_repeated_begins_anew, NULL, NULL, NULL},
        {"the values of identity and PDOs are those of 1000h, 1008h, 1018h, 1600h to 1BFFh, 1C10h to 1C2Fh",
         values_of_identity_and_pdos_end_at_their_indices, NULL, NULL, NULL},
        {"an assigned PDO is read by an index of at least two bytes", an_assigned_pdo_has_an_index_of_two_bytes, NULL,
         NULL, NULL},
        {"SyncManager 0 to 31 have the assignments 1C10h to 1C2Fh", each_sync_manager_has_its_assignment, NULL, NULL,
         NULL},
        {"progress counts the objects, and stops where it is refused", progress_counts_objects, NULL, NULL, NULL},
        {"no frame follows a stop, until the slave returns to its state", no_frame_follows_a_stop, NULL, NULL, NULL},
        {"the user stops a wait for a state", the_user_stops_a_wait_for_a_state, NULL, NULL, NULL},
        {"a limit that passes between two objects is no gap of the next", a_limit_between_two_objects_is_no_gap, NULL,
         NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("bounds of a reader", tests, NULL, NULL);
}
