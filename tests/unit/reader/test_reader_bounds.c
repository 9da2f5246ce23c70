/* SPDX-License-Identifier: MIT */
/* The bounds that a reader keeps to, counted at the wire: tries, mails that are skipped, steps of a progress. */
#define _GNU_SOURCE
#include "reader/reader.h"

#include <stdio.h>
#include <string.h>

#include "support/liar.h"
#include "support/testdev.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { INDEX = 0x2345, SUBINDEX = 6, EMERGENCY = 1, RESPONSE = 3, INFO = 8, EEPROM_TRIES = 10, SKIPS = 64 };

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
        const ect_reader_result_t result = ect_reader_open(&reader, &l.link, NULL);
        assert_int_equal(result, silent < EEPROM_TRIES ? ECT_READER_OK : ECT_READER_WRONG);
        if (silent == EEPROM_TRIES) {
            assert_string_equal(reader.text, "the EEPROM does not acknowledge a read of word 0x0000");
            assert_int_equal(l.number >> 16, EEPROM_TRIES);
        }
        ect_reader_close(&reader);
        liar_close(&l);
    }
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

static void takes_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    (void)ctx;
    (void)object;
    (void)entry;
}

static void progress_counts_objects(void **state)
{
    static const unsigned int limits[] = {UINT32_MAX, 0, 5};
    (void)state;
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        steps_t steps = {.most = limits[i]};
        const ect_reader_config_t config = {.progress = takes_step, .progress_ctx = &steps};
        const ect_reader_sink_t sink = {.object = takes_object, .entry = takes_entry, .ctx = &steps};
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

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a frame that is lost is repeated as often as configured", frames_are_tried_as_often_as_configured, NULL, NULL,
         NULL},
        {"frames have their addresses, length and number", frames_are_numbered, NULL, NULL, NULL},
        {"an EEPROM without acknowledge is read ten times", a_read_of_the_eeprom_is_tried_ten_times, NULL, NULL, NULL},
        {"a request skips 63 mails that are no reply", a_request_skips_63_mails, NULL, NULL, NULL},
        {"segment requests alternate, and have no content", segment_requests_alternate, NULL, NULL, NULL},
        {"the details of an entry are those that its description announces", details_are_those_announced, NULL, NULL,
         NULL},
        {"a list that is repeated has no object of the first", a_list_that_is_repeated_begins_anew, NULL, NULL, NULL},
        {"progress counts the objects, and stops where it is refused", progress_counts_objects, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("bounds of a reader", tests, NULL, NULL);
}
