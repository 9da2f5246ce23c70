/* SPDX-License-Identifier: MIT */
/*
 * SDO uploads byte by byte (ETG.1000.6 clause 5.6.2): scripted replies of a slave, the reader's results, and the
 * requests that it sends.
 */
#define _GNU_SOURCE
#include "reader/reader.h"

#include <stdlib.h>
#include <string.h>

#include "support/liar.h"
#include "support/testdev.h"

enum { REQUEST = 2, RESPONSE = 3, REPLIES = 5, BYTES = 24, VALUE = 16 };

/* A CoE message of the slave, behind the CoE header. */
typedef struct reply {
    uint8_t service, length;
    uint8_t bytes[BYTES];
} reply_t;

#define TO_2345_06 0x45, 0x23, 0x06

static const struct script {
    const char *what;
    reply_t replies[REPLIES];
    ect_reader_result_t result;
    size_t size;
    uint8_t value[VALUE];
    const char *text;    /* of a failure */
    uint8_t requests[6]; /* commands of the requests, 0 at the end; an abort is the last */
    uint32_t abort;      /* its code */
} scripts[] = {
    /* expedited */
    {"one byte", {{RESPONSE, 8, {0x4F, TO_2345_06, 1, 2, 3, 4}}}, ECT_READER_OK, 1, {1}, "", {0x40}, 0},
    {"two bytes", {{RESPONSE, 8, {0x4B, TO_2345_06, 1, 2, 3, 4}}}, ECT_READER_OK, 2, {1, 2}, "", {0x40}, 0},
    {"three bytes", {{RESPONSE, 8, {0x47, TO_2345_06, 1, 2, 3, 4}}}, ECT_READER_OK, 3, {1, 2, 3}, "", {0x40}, 0},
    {"four bytes", {{RESPONSE, 8, {0x43, TO_2345_06, 1, 2, 3, 4}}}, ECT_READER_OK, 4, {1, 2, 3, 4}, "", {0x40}, 0},
    {"no size given", {{RESPONSE, 8, {0x4E, TO_2345_06, 1, 2, 3, 4}}}, ECT_READER_OK, 4, {1, 2, 3, 4}, "", {0x40}, 0},
    /* normal */
    {"five bytes",
     {{RESPONSE, 13, {0x41, TO_2345_06, 5, 0, 0, 0, 1, 2, 3, 4, 5}}},
     ECT_READER_OK,
     5,
     {1, 2, 3, 4, 5},
     "",
     {0x40},
     0},
    {"one byte, not expedited",
     {{RESPONSE, 9, {0x41, TO_2345_06, 1, 0, 0, 0, 7}}},
     ECT_READER_OK,
     1,
     {7},
     "",
     {0x40},
     0},
    {"no byte", {{RESPONSE, 8, {0x41, TO_2345_06, 0, 0, 0, 0}}}, ECT_READER_OK, 0, {0}, "", {0x40}, 0},
    {"bytes behind the value",
     {{RESPONSE, 12, {0x41, TO_2345_06, 2, 0, 0, 0, 1, 2, 3, 4}}},
     ECT_READER_OK,
     2,
     {1, 2},
     "",
     {0x40},
     0},
    {"as long as there is room",
     {{RESPONSE, 24, {0x41, TO_2345_06, 16, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}}},
     ECT_READER_OK,
     16,
     {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16},
     "",
     {0x40},
     0},
    {"one byte longer",
     {{RESPONSE, 8, {0x41, TO_2345_06, 17, 0, 0, 0}}},
     ECT_READER_TOO_LONG,
     17,
     {0},
     "2345:06: longer than the buffer",
     {0x40, 0x80},
     0x05040005},
    {"4 GiB",
     {{RESPONSE, 8, {0x41, TO_2345_06, 0xFF, 0xFF, 0xFF, 0xFF}}},
     ECT_READER_TOO_LONG,
     UINT32_MAX,
     {0},
     "2345:06: longer than the buffer",
     {0x40, 0x80},
     0x05040005},
    /* segmented */
    {"two segments, the last of them short",
     {{RESPONSE, 8, {0x41, TO_2345_06, 9, 0, 0, 0}},
      {RESPONSE, 8, {0x00, 1, 2, 3, 4, 5, 6, 7}},
      {RESPONSE, 8, {0x1B, 8, 9, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE}}},
     ECT_READER_OK,
     9,
     {1, 2, 3, 4, 5, 6, 7, 8, 9},
     "",
     {0x40, 0x60, 0x70},
     0},
    {"the first bytes together with the size",
     {{RESPONSE, 10, {0x41, TO_2345_06, 5, 0, 0, 0, 1, 2}}, {RESPONSE, 8, {0x09, 3, 4, 5, 0xEE, 0xEE, 0xEE, 0xEE}}},
     ECT_READER_OK,
     5,
     {1, 2, 3, 4, 5},
     "",
     {0x40, 0x60},
     0},
    {"a segment of seven bytes is whole",
     {{RESPONSE, 8, {0x41, TO_2345_06, 7, 0, 0, 0}}, {RESPONSE, 8, {0x01, 1, 2, 3, 4, 5, 6, 7}}},
     ECT_READER_OK,
     7,
     {1, 2, 3, 4, 5, 6, 7},
     "",
     {0x40, 0x60},
     0},
    {"a segment longer than seven bytes has no unused ones",
     {{RESPONSE, 8, {0x41, TO_2345_06, 8, 0, 0, 0}}, {RESPONSE, 9, {0x0F, 1, 2, 3, 4, 5, 6, 7, 8}}},
     ECT_READER_OK,
     8,
     {1, 2, 3, 4, 5, 6, 7, 8},
     "",
     {0x40, 0x60},
     0},
    {"a last segment that comes early",
     {{RESPONSE, 8, {0x41, TO_2345_06, 9, 0, 0, 0}}, {RESPONSE, 8, {0x01, 1, 2, 3, 4, 5, 6, 7}}},
     ECT_READER_OK,
     7,
     {1, 2, 3, 4, 5, 6, 7},
     "",
     {0x40, 0x60},
     0},
    {"three segments toggle twice",
     {{RESPONSE, 8, {0x41, TO_2345_06, 3, 0, 0, 0}},
      {RESPONSE, 8, {0x0C, 1, 0, 0, 0, 0, 0, 0}},
      {RESPONSE, 8, {0x1C, 2, 0, 0, 0, 0, 0, 0}},
      {RESPONSE, 8, {0x0D, 3, 0, 0, 0, 0, 0, 0}}},
     ECT_READER_OK,
     3,
     {1, 2, 3},
     "",
     {0x40, 0x60, 0x70, 0x60},
     0},
    {"a first segment with the toggle bit",
     {{RESPONSE, 8, {0x41, TO_2345_06, 7, 0, 0, 0}}, {RESPONSE, 8, {0x11, 1, 2, 3, 4, 5, 6, 7}}},
     ECT_READER_WRONG,
     0,
     {0},
     "2345:06: a segment with the wrong toggle bit",
     {0x40, 0x60, 0x80},
     0x05030000},
    {"a byte more than announced",
     {{RESPONSE, 8, {0x41, TO_2345_06, 6, 0, 0, 0}}, {RESPONSE, 8, {0x01, 1, 2, 3, 4, 5, 6, 7}}},
     ECT_READER_WRONG,
     0,
     {0},
     "2345:06: more bytes in the segments than announced",
     {0x40, 0x60, 0x80},
     0x08000000},
    {"all bytes, and no last segment",
     {{RESPONSE, 8, {0x41, TO_2345_06, 7, 0, 0, 0}}, {RESPONSE, 8, {0x00, 1, 2, 3, 4, 5, 6, 7}}},
     ECT_READER_WRONG,
     7,
     {1, 2, 3, 4, 5, 6, 7},
     "2345:06: endless segments",
     {0x40, 0x60, 0x80},
     0x08000000},
    {"a segment without bytes, and not the last",
     {{RESPONSE, 8, {0x41, TO_2345_06, 7, 0, 0, 0}}, {RESPONSE, 8, {0x0E, 0, 0, 0, 0, 0, 0, 0}}},
     ECT_READER_WRONG,
     0,
     {0},
     "2345:06: endless segments",
     {0x40, 0x60, 0x80},
     0x08000000},
    {"a last segment without bytes",
     {{RESPONSE, 8, {0x41, TO_2345_06, 7, 0, 0, 0}}, {RESPONSE, 8, {0x0F, 0, 0, 0, 0, 0, 0, 0}}},
     ECT_READER_OK,
     0,
     {0},
     "",
     {0x40, 0x60},
     0},
    /* aborts */
    {"an abort",
     {{REQUEST, 8, {0x80, TO_2345_06, 0x11, 0x00, 0x09, 0x06}}},
     ECT_READER_ABORTED,
     0,
     {0},
     "2345:06: the slave aborts with 0x06090011",
     {0x40},
     0},
    {"an abort as a response",
     {{RESPONSE, 8, {0x80, TO_2345_06, 0x00, 0x00, 0x02, 0x06}}},
     ECT_READER_ABORTED,
     0,
     {0},
     "2345:06: the slave aborts with 0x06020000",
     {0x40},
     0},
    {"an abort of a segment",
     {{RESPONSE, 8, {0x41, TO_2345_06, 7, 0, 0, 0}}, {REQUEST, 8, {0x80, TO_2345_06, 0, 0, 4, 5}}},
     ECT_READER_ABORTED,
     0,
     {0},
     "2345:06: the slave aborts with 0x05040000",
     {0x40, 0x60},
     0},
    {"an abort that is cut off",
     {{REQUEST, 7, {0x80, TO_2345_06, 0x11, 0x00, 0x09}}},
     ECT_READER_WRONG,
     0,
     {0},
     "no mail within 2000 ms is the reply to the request",
     {0x40},
     0},
    {"a reply that is cut off",
     {{RESPONSE, 7, {0x43, TO_2345_06, 1, 2, 3}}},
     ECT_READER_WRONG,
     0,
     {0},
     "no mail within 2000 ms is the reply to the request",
     {0x40},
     0},
    {"a reply of another index",
     {{RESPONSE, 8, {0x43, 0x46, 0x23, 0x06, 1, 2, 3, 4}}},
     ECT_READER_WRONG,
     0,
     {0},
     "no mail within 2000 ms is the reply to the request",
     {0x40},
     0},
    {"a request in the place of a response",
     {{REQUEST, 8, {0x43, TO_2345_06, 1, 2, 3, 4}}},
     ECT_READER_WRONG,
     0,
     {0},
     "no mail within 2000 ms is the reply to the request",
     {0x40},
     0},
};

static ect_reader_t reader;
static const struct script *script;
static unsigned int replied;
static uint8_t commands[8];
static uint32_t abort_code;

/* Each SDO request gets the next reply; an abort gets none. */
static liar_mail_t reply(liar_t *l, const uint8_t *mail)
{
    const uint8_t *sdo = mail + 8;
    assert_int_equal(mail[7] >> 4, REQUEST);
    if (replied < sizeof commands)
        commands[replied] = sdo[0];
    if (sdo[0] == 0x40 || sdo[0] == 0x80) {
        static const uint8_t object[] = {TO_2345_06};
        assert_memory_equal(sdo + 1, object, sizeof object);
    }
    if (sdo[0] == 0x80) {
        abort_code = ect_load_le32(sdo + 4);
        replied++;
        return LIAR_SWALLOWS;
    }
    const reply_t *next = &script->replies[replied < REPLIES ? replied : REPLIES - 1];
    replied++;
    liar_set_coe_mail(l, next->service, next->bytes, next->length);
    return LIAR_REPLIES;
}

static void expect(const struct script *s, ect_reader_result_t result, size_t size, const uint8_t *value)
{
    if (result != s->result || (result != ECT_READER_OK && strcmp(reader.text, s->text) != 0))
        fail_msg("%s: expected result %d \"%s\", got %d \"%s\"", s->what, s->result, s->text, result, reader.text);
    if (size != s->size)
        fail_msg("%s: expected %zu bytes, got %zu", s->what, s->size, size);
    if (size <= VALUE && memcmp(value, s->value, size) != 0)
        fail_msg("%s: expected %02X %02X.., got %02X %02X..", s->what, s->value[0], s->value[1], value[0], value[1]);
    for (size_t i = 0; i < sizeof s->requests; i++) {
        if (commands[i] != s->requests[i])
            fail_msg("%s: request %zu: expected %02X, got %02X", s->what, i, s->requests[i], commands[i]);
    }
    if (abort_code != s->abort)
        fail_msg("%s: expected an abort with %08X, got %08X", s->what, (unsigned int)s->abort,
                 (unsigned int)abort_code);
}

static void each_reply(void **state)
{
    static const liar_kind_t kind = {"scripted", .request = reply};
    static const ect_reader_config_t once = {.tries = 1};
    (void)state;
    for (size_t i = 0; i < sizeof scripts / sizeof scripts[0]; i++) {
        uint8_t value[VALUE + 1];
        size_t size = VALUE;
        liar_t l;
        script = &scripts[i];
        replied = 0;
        abort_code = 0;
        memset(commands, 0, sizeof commands);
        memset(value, 0xA5, sizeof value);
        liar_open(&l, &testdev, &kind);
        assert_int_equal(ect_reader_open(&reader, &l.link, &once), ECT_READER_OK);
        ect_reader_result_t result = ect_reader_upload(&reader, 0x2345, 6, false, value, &size);
        expect(script, result, size, value);
        assert_int_equal(value[VALUE], 0xA5);
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* --- lists of objects --------------------------------------------------------------------------------------------- */

enum { INFO = 8, FRAGMENTS = 4 };

/* Fragments of a list: opcode, reserved, two bytes of fragments that follow, then type of the list and indices. */
static const struct list {
    const char *what;
    reply_t fragments[FRAGMENTS];
    ect_reader_result_t result;
    size_t count;
    uint16_t indices[4];
} lists[] = {
    {"one fragment", {{INFO, 10, {0x02, 0, 0, 0, 1, 0, 0x00, 0x10, 0x18, 0x10}}}, ECT_READER_OK, 2, {0x1000, 0x1018}},
    {"no object", {{INFO, 6, {0x02, 0, 0, 0, 1, 0}}}, ECT_READER_OK, 0, {0}},
    {"an object twice", {{INFO, 10, {0x02, 0, 0, 0, 1, 0, 0x00, 0x10, 0x00, 0x10}}}, ECT_READER_OK, 1, {0x1000}},
    {"half an index at the end", {{INFO, 9, {0x02, 0, 0, 0, 1, 0, 0x00, 0x10, 0x18}}}, ECT_READER_OK, 1, {0x1000}},
    {"three fragments",
     {{INFO, 8, {0x82, 0, 2, 0, 1, 0, 0x00, 0x10}},
      {INFO, 8, {0x82, 0, 1, 0, 0x08, 0x10, 0x18, 0x10}},
      {INFO, 6, {0x02, 0, 0, 0, 0xFF, 0xFF}}},
     ECT_READER_OK,
     4,
     {0x1000, 0x1008, 0x1018, 0xFFFF}},
    {"a type alone in the first fragment",
     {{INFO, 6, {0x82, 0, 1, 0, 1, 0}}, {INFO, 6, {0x02, 0, 0, 0, 0x00, 0x10}}},
     ECT_READER_OK,
     1,
     {0x1000}},
    {"a fragment without indices before the last",
     {{INFO, 8, {0x82, 0, 2, 0, 1, 0, 0x00, 0x10}}, {INFO, 4, {0x82, 0, 1, 0}}},
     ECT_READER_WRONG,
     0,
     {0}},
    {"a list of another type", {{INFO, 8, {0x02, 0, 0, 0, 2, 0, 0x00, 0x10}}}, ECT_READER_WRONG, 0, {0}},
    {"an error", {{INFO, 8, {0x07, 0, 0, 0, 0x00, 0x00, 0x02, 0x06}}}, ECT_READER_ABORTED, 0, {0}},
    {"an error without its code", {{INFO, 7, {0x07, 0, 0, 0, 0x11, 0x22, 0x33}}}, ECT_READER_ABORTED, 0, {0}},
};

static const struct list *list;

static bool next_fragment(liar_t *l)
{
    if (replied >= FRAGMENTS || list->fragments[replied].length == 0)
        return false;
    const reply_t *fragment = &list->fragments[replied++];
    liar_set_coe_mail(l, fragment->service, fragment->bytes, fragment->length);
    return true;
}

static liar_mail_t first_fragment(liar_t *l, const uint8_t *mail)
{
    static const uint8_t request[] = {0x01, 0, 0, 0, 1, 0}; /* the list of all objects */
    assert_int_equal(mail[7] >> 4, INFO);
    assert_memory_equal(mail + 8, request, sizeof request);
    return next_fragment(l) ? LIAR_REPLIES : LIAR_SWALLOWS;
}

static void each_list(void **state)
{
    static const liar_kind_t kind = {"scripted", .request = first_fragment, .next = next_fragment};
    static const ect_reader_config_t once = {.tries = 1};
    (void)state;
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        size_t count = 99;
        liar_t l;
        list = &lists[i];
        replied = 0;
        liar_open(&l, &testdev, &kind);
        assert_int_equal(ect_reader_open(&reader, &l.link, &once), ECT_READER_OK);
        ect_reader_result_t result = ect_reader_list(&reader, &count);
        if (result != list->result || count != list->count)
            fail_msg("%s: expected result %d, %zu objects, got %d, %zu", list->what, list->result, list->count, result,
                     count);
        for (size_t k = 0; k < count; k++) {
            if ((reader.objects[list->indices[k] / 8] >> list->indices[k] % 8 & 1) == 0)
                fail_msg("%s: expected object %04X", list->what, list->indices[k]);
        }
        if (result == ECT_READER_ABORTED)
            assert_int_equal(reader.code, list->fragments[0].length == 8 ? 0x06020000 : 0);
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* The first and the last index there is. Neither is described, and both are requested. */
static unsigned int described;

static liar_mail_t ends_of_the_list(liar_t *l, const uint8_t *mail)
{
    static const uint8_t both[] = {0x02, 0, 0, 0, 1, 0, 0x00, 0x00, 0xFF, 0xFF};
    static const uint8_t none[] = {0x07, 0, 0, 0, 0x00, 0x00, 0x02, 0x06};
    const bool is_list = mail[8] == 0x01;
    if (!is_list)
        assert_int_equal(ect_load_le16(mail + 12), described++ == 0 ? 0x0000 : 0xFFFF);
    liar_set_coe_mail(l, INFO, is_list ? both : none, is_list ? sizeof both : sizeof none);
    return LIAR_REPLIES;
}

static void no_object(void *ctx, const ect_reader_object_t *object)
{
    (void)ctx;
    fail_msg("object %04X", object->index);
}

static void no_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    (void)ctx;
    (void)entry;
    fail_msg("entry of object %04X", object->index);
}

static void first_and_last_index(void **state)
{
    static const liar_kind_t kind = {"ends", .request = ends_of_the_list};
    static const ect_reader_sink_t sink = {.object = no_object, .entry = no_entry};
    liar_t l;
    (void)state;
    described = 0;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), ECT_READER_OK);
    assert_int_equal(described, 2);
    ect_reader_close(&reader);
    liar_close(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-069 CF-071 CF-072 replies to an upload: expedited, normal, segmented, aborted, and invalid ones",
         each_reply, NULL, NULL, NULL},
        {"CF-076 lists of objects in one fragment and in several, and invalid ones", each_list, NULL, NULL, NULL},
        {"CF-076 each index of a list is requested, 0000h and FFFFh too", first_and_last_index, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
