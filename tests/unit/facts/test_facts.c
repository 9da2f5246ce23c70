/* SPDX-License-Identifier: MIT */
/* Facts one by one: the line of each kind, the facts of each part of a dictionary, and the rules of comparing. */
#define _GNU_SOURCE
#include "facts/facts.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "seams/device.h"
#include "sii/sii.h"
#include "support/every.h"
#include "support/testdev.h"
#include "wire/bytes.h"

/* --- lines -------------------------------------------------------------------------------------------------------- */

static char *lines_of(const ect_facts_t *expected, const ect_facts_t *found, size_t *count)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    ect_facts_t known = {.source = expected->source};
    assert_non_null(out);
    assert_int_equal(ect_facts_compare(&known, expected, out), 0);
    *count = ect_facts_compare(&known, found, out);
    (void)fclose(out);
    ect_facts_free(&known);
    return text;
}

static void each_kind_has_its_place_in_words(void **state)
{
    static const struct {
        ect_fact_kind_t kind;
        const char *place; /* of index 1A2Bh, element 3 */
    } kinds[ECT_FACT_KINDS] = {
        {ECT_FACT_VENDOR, "identity vendor id"},
        {ECT_FACT_PRODUCT, "identity product code"},
        {ECT_FACT_REVISION, "identity revision"},
        {ECT_FACT_TYPE, "device type"},
        {ECT_FACT_NAME, "device name"},
        {ECT_FACT_VENDOR_NAME, "device vendor's name"},
        {ECT_FACT_GROUP, "device group"},
        {ECT_FACT_GROUP_NAME, "device group's name"},
        {ECT_FACT_PORTS, "device ports"},
        {ECT_FACT_EBUS, "device E-bus current"},
        {ECT_FACT_TIMEOUT, "timeout back to SAFEOP"},
        {ECT_FACT_EEPROM_SIZE, "EEPROM size"},
        {ECT_FACT_CONFIG, "EEPROM word 6699"},
        {ECT_FACT_CHECKSUM, "EEPROM checksum"},
        {ECT_FACT_PROTOCOLS, "mailbox protocols"},
        {ECT_FACT_COE, "mailbox CoE abilities"},
        {ECT_FACT_MAILBOX_OUT, "mailbox to the slave"},
        {ECT_FACT_MAILBOX_IN, "mailbox from the slave"},
        {ECT_FACT_BOOT_OUT, "mailbox to the slave in BOOT"},
        {ECT_FACT_BOOT_IN, "mailbox from the slave in BOOT"},
        {ECT_FACT_SM, "SM6699"},
        {ECT_FACT_SM_START, "SM6699 start"},
        {ECT_FACT_SM_LENGTH, "SM6699 length"},
        {ECT_FACT_SM_CONTROL, "SM6699 control byte"},
        {ECT_FACT_SM_ENABLED, "SM6699 enabled"},
        {ECT_FACT_SM_DEFAULT, "SM6699 DefaultSize"},
        {ECT_FACT_SM_MINIMUM, "SM6699 smallest length"},
        {ECT_FACT_SM_MAXIMUM, "SM6699 largest length"},
        {ECT_FACT_FMMU, "FMMU6699"},
        {ECT_FACT_PDO, "PDO 1A2B"},
        {ECT_FACT_PDO_SM, "PDO 1A2B SyncManager"},
        {ECT_FACT_PDO_NAME, "PDO 1A2B name"},
        {ECT_FACT_PDO_FIXED, "PDO 1A2B fixed"},
        {ECT_FACT_PDO_MANDATORY, "PDO 1A2B mandatory"},
        {ECT_FACT_PDO_EXCLUDES, "PDO 1A2B excludes"},
        {ECT_FACT_PDO_ENTRY, "PDO 1A2B entry 3"},
        {ECT_FACT_PDO_ENTRY_NAME, "PDO 1A2B entry 3 name"},
        {ECT_FACT_PDO_ENTRY_TYPE, "PDO 1A2B entry 3 data type"},
        {ECT_FACT_OBJECT, "object 1A2B"},
        {ECT_FACT_OBJECT_NAME, "object 1A2B name"},
        {ECT_FACT_ENTRY, "object 1A2B:03 length"},
        {ECT_FACT_ENTRY_TYPE, "object 1A2B:03 data type"},
        {ECT_FACT_ENTRY_ACCESS, "object 1A2B:03 access"},
        {ECT_FACT_ENTRY_NAME, "object 1A2B:03 name"},
        {ECT_FACT_ENTRY_DEFAULT, "object 1A2B:03 default"},
        {ECT_FACT_ENTRY_LIMITS, "object 1A2B:03 limits"},
        {ECT_FACT_ENTRY_UNIT, "object 1A2B:03 unit"},
        {ECT_FACT_DC, "DC mode 6699 name"},
        {ECT_FACT_DC_ACTIVATE, "DC mode 6699 AssignActivate"},
        {ECT_FACT_DC_SYNC0, "DC mode 6699 SYNC0"},
        {ECT_FACT_DC_SYNC1, "DC mode 6699 SYNC1"},
        {ECT_FACT_FILE, "Device/Somewhere"},
        {ECT_FACT_FILE_TEXT, "Device/Somewhere"},
        {ECT_FACT_WORDS, "EEPROM reserved words"},
        {ECT_FACT_CATEGORY, "EEPROM category 6699"},
        {ECT_FACT_GENERAL, "EEPROM General byte 6699"},
        {ECT_FACT_SM_BITS, "SM6699 in the EEPROM"},
        {ECT_FACT_PDO_BITS, "PDO 1A2B in the EEPROM"},
        {ECT_FACT_PDO_ENTRY_BITS, "PDO 1A2B entry 3 in the EEPROM"},
        {ECT_FACT_DC_TEXT, "DC mode 6699 in the EEPROM"},
    };
    (void)state;
    for (size_t i = 0; i < ECT_FACT_KINDS; i++) {
        ect_facts_t expected = {.source = "A"}, found = {.source = "B"};
        char line[200];
        size_t count;
        assert_int_equal(kinds[i].kind, i);
        ect_facts_add(&expected, kinds[i].kind, 0x1A2B, 3, "%d", 7)->path = "Device/Somewhere";
        ect_facts_add(&found, kinds[i].kind, 0x1A2B, 3, "%d", 8)->path = "Device/Somewhere";
        char *lines = lines_of(&expected, &found, &count);
        (void)snprintf(line, sizeof line, "B: %s: expected 7 (A), found 8\n", kinds[i].place);
        assert_string_equal(lines, line);
        assert_int_equal(count, 1);
        free(lines);
        ect_facts_free(&expected);
        ect_facts_free(&found);
    }
}

static void each_timeout_has_its_name(void **state)
{
    static const char *const names[] = {"to PREOP",       "to SAFEOP or OP", "back to INIT",
                                        "back to SAFEOP", "mailbox request", "mailbox response"};
    (void)state;
    for (unsigned int i = 0; i < sizeof names / sizeof names[0]; i++) {
        ect_facts_t expected = {.source = "A"}, found = {.source = "B"};
        char line[200];
        size_t count;
        (void)ect_facts_add(&expected, ECT_FACT_TIMEOUT, i, 0, "1 ms");
        (void)ect_facts_add(&found, ECT_FACT_TIMEOUT, i, 0, "2 ms");
        char *lines = lines_of(&expected, &found, &count);
        (void)snprintf(line, sizeof line, "B: timeout %s: expected 1 ms (A), found 2 ms\n", names[i]);
        assert_string_equal(lines, line);
        free(lines);
        ect_facts_free(&expected);
        ect_facts_free(&found);
    }
}

/* --- helpers ------------------------------------------------------------------------------------------------------ */

/* The only fact, or that with a number. */
static const char *text_of(const ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element)
{
    for (size_t i = 0; i < facts->count; i++) {
        const ect_fact_t *f = &facts->list[i];
        if (f->kind == kind && f->index == index && f->element == element)
            return f->text != NULL ? f->text : "?";
    }
    return "none";
}

static void helpers_write_facts_as_texts(void **state)
{
    static const uint8_t roles[] = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, 0xFF, ECT_FMMU_MAILBOX_STATE, 9, 0xFF, 0};
    static const uint8_t bytes[] = {1, 0xAB, 0, 0};
    uint8_t many[100];
    ect_facts_t f = {.source = "A"};
    (void)state;
    memset(many, 0x11, sizeof many);
    ect_facts_add_mapping(&f, 0x1600, 1, 0x7000, 0x11, 16);
    ect_facts_add_mapping(&f, 0x1600, 2, 0, 0, 7);
    assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1600, 1), "7000:11, 16 bits");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1600, 2), "7 bits of padding");
    ect_facts_add_access(&f, 0x2000, 1, 0);
    ect_facts_add_access(&f, 0x2000, 2, ECT_ACCESS_RW | ECT_ACCESS_RXPDO | ECT_ACCESS_BACKUP);
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_ACCESS, 0x2000, 1), "none");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_ACCESS, 0x2000, 2),
                        "R.PREOP R.SAFEOP R.OP W.PREOP W.SAFEOP W.OP RxPDO backup");
    ect_facts_add_default(&f, 0x2000, 1, bytes, sizeof bytes);
    ect_facts_add_default(&f, 0x2000, 2, bytes + 2, 2);
    ect_facts_add_default(&f, 0x2000, 3, bytes, 0);
    ect_facts_add_default(&f, 0x2000, 4, many, sizeof many);
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 1), "01 AB");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 2), "00");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 3), "none");
    assert_int_equal(strlen(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 4)), 64 * 3 - 1);
    ect_facts_add_fmmus(&f, roles, sizeof roles);
    assert_string_equal(text_of(&f, ECT_FACT_FMMU, 0, 0), "outputs");
    assert_string_equal(text_of(&f, ECT_FACT_FMMU, 1, 0), "inputs");
    assert_string_equal(text_of(&f, ECT_FACT_FMMU, 2, 0), "unused");
    assert_string_equal(text_of(&f, ECT_FACT_FMMU, 3, 0), "mailbox state");
    assert_string_equal(text_of(&f, ECT_FACT_FMMU, 4, 0), "role 9");
    assert_string_equal(text_of(&f, ECT_FACT_FMMU, 5, 0), "none"); /* unused ones at the end are not there */
    assert_true(f.complete[ECT_FACT_FMMU]);
    static const char *const sms[] = {"unused", "mailbox to the slave", "mailbox from the slave", "outputs", "inputs",
                                      "role 5"};
    for (unsigned int type = 0; type < sizeof sms / sizeof sms[0]; type++) {
        ect_facts_add_sm(&f, type + 2, type);
        assert_string_equal(text_of(&f, ECT_FACT_SM, type + 2, 0), sms[type]);
    }
    ect_facts_add_access(&f, 0x2000, 3, ECT_ACCESS_SETTING | 0x400);
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_ACCESS, 0x2000, 3), "setting bits 0x400");
    ect_facts_add_protocols(&f, ECT_MAILBOX_COE | ECT_MAILBOX_FOE | 0x140, 0x41);
    assert_string_equal(text_of(&f, ECT_FACT_PROTOCOLS, 0, 0), "CoE FoE bits 0x140");
    assert_string_equal(text_of(&f, ECT_FACT_COE, 0, 0), "SDO bits 0x40");
    ect_facts_add_mailbox(&f, ECT_FACT_MAILBOX_OUT, 0x1000, 128);
    ect_facts_add_mailbox(&f, ECT_FACT_MAILBOX_IN, 0, 0);
    ect_facts_add_mailbox(&f, ECT_FACT_BOOT_IN, 0x1000, 0);
    assert_string_equal(text_of(&f, ECT_FACT_MAILBOX_OUT, 0, 0), "128 bytes at 0x1000");
    assert_string_equal(text_of(&f, ECT_FACT_MAILBOX_IN, 0, 0), "none");
    assert_string_equal(text_of(&f, ECT_FACT_BOOT_IN, 0, 0), "0 bytes at 0x1000");
    ect_facts_free(&f);
}

/* The published values of FNV-1a. */
static void a_sum_is_that_of_FNV_1a(void **state)
{
    (void)state;
    assert_int_equal(ect_facts_sum("", 0), 0x811C9DC5);
    assert_int_equal(ect_facts_sum("a", 1), 0xE40C292C);
    assert_int_equal(ect_facts_sum("foobar", 6), 0xBF9CF968);
}

/* A category of 300 bytes, as another tool may write it: its first 256 are facts. */
static void each_byte_of_General_is_a_fact(void **state)
{
    static const struct {
        unsigned int at;
        const char *text;
    } rows[] = {
        {0, "no text"}, {1, "0x01"},  {2, "no text"}, {3, "no text"},  {4, "0x04"},   {5, "none"},  {6, "0x06"},
        {11, "0x0B"},   {12, "none"}, {13, "none"},   {14, "no text"}, {15, "0x0F"},  {16, "0x10"}, {31, "0x1F"},
        {32, "0x20"},   {46, "0x2E"}, {254, "0xFE"},  {255, "0xFF"},   {256, "none"},
    };
    uint8_t image[512] = {0};
    ect_facts_t f = {.source = "image"};
    (void)state;
    ect_store_le16(image + 0x80, ECT_SII_GENERAL);
    ect_store_le16(image + 0x82, 150);
    for (unsigned int n = 0; n < 300; n++)
        image[0x84 + n] = (uint8_t)n;
    image[0x84] = image[0x86] = image[0x87] = image[0x84 + 14] = 0; /* texts */
    ect_store_le16(image + 0x84 + 300, ECT_SII_END);
    ect_facts_of_sii(&f, image, sizeof image);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const char *text = text_of(&f, ECT_FACT_GENERAL, rows[i].at, 0);
        if (strcmp(text, rows[i].text) != 0)
            fail_msg("byte %u: expected %s, got %s", rows[i].at, rows[i].text, text);
    }
    ect_facts_free(&f);
}

/* A category that is too short for the ports is none. */
static void General_has_at_least_18_bytes(void **state)
{
    static const struct {
        uint16_t words;
        const char *current;
    } rows[] = {{0, "none"}, {8, "none"}, {9, "-2 mA"}, {10, "-2 mA"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[512] = {0};
        ect_facts_t f = {.source = "image"};
        ect_store_le16(image + 0x80, ECT_SII_GENERAL);
        ect_store_le16(image + 0x82, rows[i].words);
        ect_store_le16(image + 0x84 + 12, (uint16_t)-2);
        ect_store_le16(image + 0x84 + 2 * (size_t)rows[i].words, ECT_SII_END);
        ect_facts_of_sii(&f, image, sizeof image);
        const char *current = text_of(&f, ECT_FACT_EBUS, 0, 0);
        if (strcmp(current, rows[i].current) != 0)
            fail_msg("%u words: expected %s, got %s", rows[i].words, rows[i].current, current);
        ect_facts_free(&f);
    }
}

static void long_values_of_a_file_are_compared_by_their_sum(void **state)
{
    char a[200], b[200];
    ect_facts_t f = {.source = "A"}, g = {.source = "B"};
    size_t count;
    (void)state;
    memset(a, 'a', sizeof a);
    a[199] = '\0';
    memcpy(b, a, sizeof b);
    b[100] = 'b';
    ect_facts_add_leaf(&f, ECT_FACT_FILE, "Device/Long", a);
    ect_facts_add_leaf(&g, ECT_FACT_FILE, "Device/Long", b);
    ect_facts_add_leaf(&f, ECT_FACT_FILE, "Device/Short", "12");
    ect_facts_add_leaf(&g, ECT_FACT_FILE, "Device/Short", "12");
    char *lines = lines_of(&f, &g, &count);
    assert_int_equal(count, 1);
    assert_non_null(strstr(lines, "B: Device/Long: expected 199 characters, sum "));
    free(lines);
    ect_facts_free(&f);
    ect_facts_free(&g);
}

/* --- comparing ---------------------------------------------------------------------------------------------------- */

static void a_part_is_missed_only_where_its_whole_is_there(void **state)
{
    static const struct {
        ect_fact_kind_t whole, part;
        unsigned int element;
    } pairs[] = {{ECT_FACT_SM, ECT_FACT_SM_START, 0},
                 {ECT_FACT_PDO, ECT_FACT_PDO_ENTRY, 2},
                 {ECT_FACT_PDO_ENTRY, ECT_FACT_PDO_ENTRY_NAME, 2},
                 {ECT_FACT_OBJECT, ECT_FACT_ENTRY, 2},
                 {ECT_FACT_ENTRY, ECT_FACT_ENTRY_TYPE, 2},
                 {ECT_FACT_DC, ECT_FACT_DC_SYNC0, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        for (unsigned int there = 0; there < 2; there++) {
            ect_facts_t expected = {.source = "A"}, found = {.source = "B"};
            size_t count;
            (void)ect_facts_add(&expected, pairs[i].part, 5, pairs[i].element, "part");
            found.complete[pairs[i].part] = true;
            if (there)
                (void)ect_facts_add(&found, pairs[i].whole, 5,
                                    pairs[i].whole == ECT_FACT_PDO_ENTRY || pairs[i].whole == ECT_FACT_ENTRY ? 2 : 0,
                                    "whole");
            char *lines = lines_of(&expected, &found, &count);
            assert_int_equal(count, there);
            free(lines);
            ect_facts_free(&expected);
            ect_facts_free(&found);
        }
    }
}

static void facts_without_a_text_are_equal_to_any(void **state)
{
    ect_facts_t expected = {.source = "A"}, found = {.source = "B"};
    size_t count;
    (void)state;
    (void)ect_facts_add(&expected, ECT_FACT_DC, 0, 0, NULL);
    (void)ect_facts_add(&found, ECT_FACT_DC, 0, 0, "\"DC\"");
    char *lines = lines_of(&expected, &found, &count);
    assert_int_equal(count, 0);
    free(lines);
    ect_facts_free(&expected);
    ect_facts_free(&found);
}

static void a_made_fact_is_not_missed(void **state)
{
    for (unsigned int made = 0; made < 2; made++) {
        ect_facts_t expected = {.source = "A"}, found = {.source = "B"};
        size_t count;
        ect_facts_add(&expected, ECT_FACT_OBJECT, 0x2000, 0, "code 7")->made = made != 0;
        found.complete[ECT_FACT_OBJECT] = true;
        char *lines = lines_of(&expected, &found, &count);
        assert_int_equal(count, 1 - made);
        free(lines);
        ect_facts_free(&expected);
        ect_facts_free(&found);
    }
    (void)state;
}

/* The third source is compared with the facts of the first two, and each line names its source. */
static void later_sources_are_compared_with_all_before(void **state)
{
    ect_facts_t known = {.source = "A"}, second = {.source = "B"}, third = {.source = "C"};
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    (void)state;
    (void)ect_facts_add(&known, ECT_FACT_VENDOR, 0, 0, "1");
    (void)ect_facts_add(&second, ECT_FACT_PRODUCT, 0, 0, "2");
    (void)ect_facts_add(&third, ECT_FACT_VENDOR, 0, 0, "1");
    (void)ect_facts_add(&third, ECT_FACT_PRODUCT, 0, 0, "3");
    assert_int_equal(ect_facts_compare(&known, &second, out), 0);
    assert_int_equal(known.count, 2);
    assert_int_equal(ect_facts_compare(&known, &third, out), 1);
    assert_int_equal(known.count, 2);
    (void)fclose(out);
    assert_string_equal(text, "C: identity product code: expected 2 (B), found 3\n");
    free(text);
    ect_facts_free(&known);
    ect_facts_free(&second);
    ect_facts_free(&third);
}

static void texts_of_a_file_follow_only_without_other_differences(void **state)
{
    for (unsigned int other = 0; other < 2; other++) {
        ect_facts_t f = {.source = "A"}, g = {.source = "B"};
        size_t count;
        ect_facts_add_leaf(&f, ECT_FACT_FILE_TEXT, "Device/Name", "one");
        ect_facts_add_leaf(&g, ECT_FACT_FILE_TEXT, "Device/Name", "two");
        ect_facts_add_leaf(&g, ECT_FACT_FILE_TEXT, "Device/More", "three");
        f.complete[ECT_FACT_FILE_TEXT] = true;
        (void)ect_facts_add(&f, ECT_FACT_NAME, 0, 0, "one");
        (void)ect_facts_add(&g, ECT_FACT_NAME, 0, 0, other ? "two" : "one");
        char *lines = lines_of(&f, &g, &count);
        assert_int_equal(count, 1);
        assert_string_equal(lines, other ? "B: device name: expected one (A), found two\n"
                                         : "B: Device/Name: expected \"one\" (A), found \"two\"\n");
        free(lines);
        ect_facts_free(&f);
        ect_facts_free(&g);
    }
    (void)state;
}

/* --- dictionaries ------------------------------------------------------------------------------------------------- */

static void a_dictionary_has_facts_of_objects_and_of_pdos(void **state)
{
    static const char json[] =
        "{\"described\": true, \"objects\": ["
        "{\"index\": 4096, \"code\": 7, \"name\": \"Type\", \"entries\": [{\"subindex\": 0, \"type\": 7, \"bits\": 32,"
        " \"access\": 7, \"name\": \"Type\", \"value\": \"92010200\"}]},"
        "{\"index\": 4120, \"code\": 9, \"name\": \"Identity\", \"entries\": [{\"subindex\": 1, \"value\": "
        "\"570e0000\"},"
        "{\"subindex\": 2, \"value\": \"01000000\"}, {\"subindex\": 3, \"value\": \"02000000\"}]},"
        "{\"index\": 5632, \"name\": \"Out\", \"entries\": [{\"subindex\": 0, \"value\": \"02\"},"
        "{\"subindex\": 1, \"value\": \"10010070\"}, {\"subindex\": 2, \"value\": \"08000000\"}]},"
        "{\"index\": 5633, \"entries\": [{\"subindex\": 0, \"value\": \"00\"}]},"
        "{\"index\": 7186, \"entries\": [{\"subindex\": 0, \"value\": \"01\"}, {\"subindex\": 1, \"value\": "
        "\"0016\"}]},"
        "{\"index\": 8192, \"code\": 7, \"name\": \"Number\", \"entries\": [{\"subindex\": 0, \"type\": 3, \"bits\": "
        "16,"
        " \"access\": 63, \"default\": \"fbff\", \"minimum\": \"18fc\", \"maximum\": \"e803\", \"unit\": \"0b00\"}]}]}";
    ect_facts_t f = {.source = "slave"};
    (void)state;
    assert_true(ect_facts_of_dictionary(&f, json));
    assert_true(f.complete[ECT_FACT_OBJECT] && f.complete[ECT_FACT_ENTRY] && f.complete[ECT_FACT_PDO_ENTRY]);
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x1000, 0), "92 01 02");
    assert_string_equal(text_of(&f, ECT_FACT_VENDOR, 0, 0), "0x00000E57");
    assert_string_equal(text_of(&f, ECT_FACT_PRODUCT, 0, 0), "0x00000001");
    assert_string_equal(text_of(&f, ECT_FACT_REVISION, 0, 0), "0x00000002");
    assert_string_equal(text_of(&f, ECT_FACT_PDO, 0x1600, 0), "outputs");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_NAME, 0x1600, 0), "\"Out\"");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1600, 1), "7000:01, 16 bits");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1600, 2), "8 bits of padding");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1600, 0), "2");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1601, 0), "none"); /* no assignment names it */
    assert_string_equal(text_of(&f, ECT_FACT_OBJECT, 0x2000, 0), "code 7");
    assert_string_equal(text_of(&f, ECT_FACT_OBJECT_NAME, 0x2000, 0), "\"Number\"");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY, 0x2000, 0), "16 bits");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_TYPE, 0x2000, 0), "0x0003");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_ACCESS, 0x2000, 0), "R.PREOP R.SAFEOP R.OP W.PREOP W.SAFEOP W.OP");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_ACCESS, 0x1000, 0), "R.PREOP R.SAFEOP R.OP");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_NAME, 0x1000, 0), "\"Type\"");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 0), "FB FF");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_LIMITS, 0x2000, 0), "-1000 to 1000");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_UNIT, 0x2000, 0), "0x000B");
    assert_string_equal(text_of(&f, ECT_FACT_OBJECT_NAME, 0x1600, 0), "none"); /* a fact of the PDO */
    ect_facts_free(&f);
}

/* 1C10h to 1C2Fh are assignments of SyncManagers 0 to 31 (ETG.1000.6); 1C30h and following are not. */
static void each_assignment_names_its_sync_manager(void **state)
{
    static const struct {
        unsigned int index;
        const char *sm;
    } rows[] = {{0x1C0F, "none"}, {0x1C10, "0"}, {0x1C12, "2"}, {0x1C2F, "31"}, {0x1C30, "none"}, {0x1C32, "none"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[200];
        ect_facts_t f = {.source = "slave"};
        (void)snprintf(json, sizeof json,
                       "{\"objects\": [{\"index\": %u, \"entries\": [{\"subindex\": 0, \"value\": \"01\"},"
                       "{\"subindex\": 1, \"value\": \"0016\"}]}]}",
                       rows[i].index);
        assert_true(ect_facts_of_dictionary(&f, json));
        if (strcmp(text_of(&f, ECT_FACT_PDO_SM, 0x1600, 0), rows[i].sm) != 0)
            fail_msg("%04X: SyncManager %s", rows[i].index, text_of(&f, ECT_FACT_PDO_SM, 0x1600, 0));
        ect_facts_free(&f);
    }
}

/* A slave without assignments fixes the SyncManagers of its PDOs: they are unknown, not none. */
static void without_an_assignment_the_sync_managers_of_pdos_are_unknown(void **state)
{
    static const struct {
        unsigned int index;
        bool assigned;
    } rows[] = {{0x1601, false}, {0x1C11, false}, {0x1C12, true}, {0x1C13, true}, {0x1C14, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[300];
        ect_facts_t f = {.source = "slave"};
        (void)snprintf(json, sizeof json,
                       "{\"objects\": [{\"index\": 5632, \"entries\": [{\"subindex\": 0, \"value\": \"00\"}]},"
                       "{\"index\": %u, \"entries\": [{\"subindex\": 0, \"value\": \"00\"}]}]}",
                       rows[i].index);
        assert_true(ect_facts_of_dictionary(&f, json));
        size_t known = 0;
        for (size_t n = 0; n < f.count; n++)
            known += f.list[n].kind == ECT_FACT_PDO_SM;
        if (known != rows[i].assigned)
            fail_msg("%04X: expected %d, got %zu", rows[i].index, rows[i].assigned, known);
        ect_facts_free(&f);
    }
}

/* An array may have more elements than its sub-index 0 counts: they are not in use. */
static void elements_beyond_the_count_of_a_pdo_and_of_an_assignment_are_none(void **state)
{
    static const struct {
        const char *count, *mappings[2], *sms[2];
    } rows[] = {{"00", {"none", "none"}, {"none", "none"}},
                {"01", {"7000:01, 16 bits", "none"}, {"6", "none"}},
                {"02", {"7000:01, 16 bits", "7000:02, 8 bits"}, {"6", "6"}},
                {"ff", {"7000:01, 16 bits", "7000:02, 8 bits"}, {"6", "6"}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[600];
        ect_facts_t f = {.source = "slave"};
        (void)snprintf(json, sizeof json,
                       "{\"objects\": [{\"index\": 5632, \"entries\": [{\"subindex\": 0, \"value\": \"%s\"},"
                       "{\"subindex\": 1, \"value\": \"10010070\"}, {\"subindex\": 2, \"value\": \"08020070\"}]},"
                       "{\"index\": 7190, \"entries\": [{\"subindex\": 0, \"value\": \"%s\"},"
                       "{\"subindex\": 1, \"value\": \"0116\"}, {\"subindex\": 2, \"value\": \"0216\"}]}]}",
                       rows[i].count, rows[i].count);
        assert_true(ect_facts_of_dictionary(&f, json));
        for (unsigned int n = 0; n < 2; n++) {
            assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1600, n + 1), rows[i].mappings[n]);
            assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1601 + n, 0), rows[i].sms[n]);
        }
        ect_facts_free(&f);
    }
}

static void a_value_that_the_slave_did_not_give_is_no_fact(void **state)
{
    static const char json[] = "{\"objects\": [{\"index\": 4120, \"entries\": [{\"subindex\": 1}, {\"subindex\": 2, "
                               "\"value\": \"01000000\"}]}]}";
    ect_facts_t f = {.source = "slave"};
    (void)state;
    assert_true(ect_facts_of_dictionary(&f, json));
    assert_string_equal(text_of(&f, ECT_FACT_VENDOR, 0, 0), "none");
    assert_string_equal(text_of(&f, ECT_FACT_PRODUCT, 0, 0), "0x00000001");
    assert_string_equal(text_of(&f, ECT_FACT_REVISION, 0, 0), "none");
    ect_facts_free(&f);
}

/* Objects come in any order: an assignment may precede its PDO, and be the first object. */
static void an_assignment_may_precede_its_pdo(void **state)
{
    static const char json[] = "{\"objects\": [{\"index\": 7187, \"entries\": [{\"subindex\": 0, \"value\": \"01\"},"
                               "{\"subindex\": 1, \"value\": \"001a\"}]},"
                               "{\"index\": 6656, \"entries\": [{\"subindex\": 0, \"value\": \"00\"}]},"
                               "{\"index\": 6657, \"entries\": [{\"subindex\": 0, \"value\": \"00\"}]}]}";
    ect_facts_t f = {.source = "slave"};
    (void)state;
    assert_true(ect_facts_of_dictionary(&f, json));
    size_t assigned = 0;
    for (size_t i = 0; i < f.count; i++)
        assigned += f.list[i].kind == ECT_FACT_PDO_SM && f.list[i].index == 0x1A00;
    assert_int_equal(assigned, 1);
    assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1A00, 0), "3");
    assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1A01, 0), "none");
    ect_facts_free(&f);
}

/* Sub-index 255 is the last one. */
static void a_pdo_and_an_assignment_have_at_most_255_elements(void **state)
{
    static const struct {
        const char *count;
        bool has_255;
    } rows[] = {{"fe00", false}, {"ff00", true}, {"0001", true}, {"ffffffff", true}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static char json[40000];
        ect_facts_t f = {.source = "slave"};
        size_t used = 0;
        for (unsigned int object = 0; object < 2; object++) {
            used += (size_t)snprintf(
                json + used, sizeof json - used, "%s{\"index\": %u, \"entries\": [{\"subindex\": 0, \"value\": \"%s\"}",
                object == 0 ? "{\"objects\": [" : ", ", object == 0 ? 0x1A00 : 0x1C12, rows[i].count);
            for (unsigned int n = 1; n <= 256; n++)
                used += (size_t)snprintf(json + used, sizeof json - used, ", {\"subindex\": %u, \"value\": \"%02x16\"}",
                                         n, n & 0xFF);
            used += (size_t)snprintf(json + used, sizeof json - used, "]}");
        }
        (void)snprintf(json + used, sizeof json - used, "]}");
        assert_true(ect_facts_of_dictionary(&f, json));
        const char *const last = rows[i].has_255 ? "255 bits of padding" : "none";
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1A00, 254), "254 bits of padding");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1A00, 255), last);
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1A00, 256), "none");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x16FE, 0), "2");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x16FF, 0), rows[i].has_255 ? "2" : "none");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1600, 0), "none"); /* element 256 */
        ect_facts_free(&f);
    }
}

static void limits_of_a_dictionary_have_the_sign_of_their_type(void **state)
{
    static const struct {
        unsigned int type;
        const char *minimum, *maximum, *limits;
    } rows[] = {
        {ECT_TYPE_BOOLEAN, "00", "ff", "0 to 255"},
        {ECT_TYPE_INTEGER8, "80", "7f", "-128 to 127"},
        {ECT_TYPE_INTEGER16, "0080", "ff7f", "-32768 to 32767"},
        {ECT_TYPE_INTEGER32, "00000080", "ffffff7f", "-2147483648 to 2147483647"},
        {ECT_TYPE_UNSIGNED8, "00", "ff", "0 to 255"},
        {ECT_TYPE_UNSIGNED32, "01000000", "ffffffff", "1 to 4294967295"},
        {ECT_TYPE_INTEGER64, "feffffffffffffff", "0100000000000000", "-2 to 1"},
        {ECT_TYPE_INTEGER64 + 1, "fe", "ff", "254 to 255"},
        {ECT_TYPE_INTEGER64 - 1, "fe", "ff", "254 to 255"},
        {ECT_TYPE_INTEGER64, "0100000000000000ff", "0200000000000000ff", "1 to 2"}, /* a ninth byte has no place */
        {ECT_TYPE_UNSIGNED8, "00", "", "none"},
        {ECT_TYPE_UNSIGNED8, "", "ff", "none"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[300];
        ect_facts_t f = {.source = "slave"};
        (void)snprintf(json, sizeof json,
                       "{\"described\": true, \"objects\": [{\"index\": 8192, \"entries\": [{\"subindex\": 0,"
                       " \"type\": %u, \"minimum\": \"%s\", \"maximum\": \"%s\"}]}]}",
                       rows[i].type, rows[i].minimum, rows[i].maximum);
        assert_true(ect_facts_of_dictionary(&f, json));
        const char *limits = text_of(&f, ECT_FACT_ENTRY_LIMITS, 0x2000, 0);
        if (strcmp(limits, rows[i].limits) != 0)
            fail_msg("row %zu: expected %s, got %s", i, rows[i].limits, limits);
        ect_facts_free(&f);
    }
}

static void a_number_of_a_dictionary_has_32_bits(void **state)
{
    static const struct {
        const char *bits, *length;
    } rows[] = {{"1", "1 bits"},          {"4294967295", "4294967295 bits"},
                {"4294967296", "0 bits"}, {"-1", "0 bits"},
                {"1e99", "0 bits"},       {"\"8\"", "0 bits"},
                {"null", "0 bits"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[200];
        ect_facts_t f = {.source = "slave"};
        (void)snprintf(json, sizeof json,
                       "{\"described\": true, \"objects\": [{\"index\": 8192, \"entries\": [{\"bits\": %s}]}]}",
                       rows[i].bits);
        assert_true(ect_facts_of_dictionary(&f, json));
        const char *length = text_of(&f, ECT_FACT_ENTRY, 0x2000, 0);
        if (strcmp(length, rows[i].length) != 0)
            fail_msg("%s: expected %s, got %s", rows[i].bits, rows[i].length, length);
        ect_facts_free(&f);
    }
}

/* Texts that users and slaves may have written. */
static void any_dictionary_is_read_or_refused(void **state)
{
    static const struct {
        const char *json;
        bool read;
    } texts[] = {
        {"", false},
        {"nothing", false},
        {"{}", false},
        {"[]", false},
        {"{\"objects\": 5}", false},
        {"{\"objects\": []}", true},
        {"{\"objects\": [5, null, \"x\", []]}", true},
        {"{\"described\": true, \"objects\": [{\"index\": 70000, \"entries\": [{\"subindex\": 99999}]}]}", true},
        {"{\"described\": true, \"objects\": [{\"index\": -1, \"code\": -2, \"entries\": [{\"subindex\": -3}]}]}",
         true},
        {"{\"described\": true, \"objects\": [{\"index\": 1e99, \"name\": 5, \"entries\": {}}]}", true},
        {"{\"objects\": [{\"index\": 5632, \"entries\": [{\"subindex\": 0, \"value\": \"ff\"}]}]}", true},
        {"{\"objects\": [{\"index\": 5632, \"entries\": [{\"subindex\": 0, \"value\": \"f\"}]}]}", true},
        {"{\"objects\": [{\"index\": 5632, \"entries\": [{\"subindex\": 0, \"value\": \"zz\"}]}]}", true},
        {"{\"objects\": [{\"index\": 7186, \"entries\": [{\"subindex\": 0, \"value\": \"ffffffff\"}]}]}", true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        ect_facts_t f = {.source = "any"};
        if (ect_facts_of_dictionary(&f, texts[i].json) != texts[i].read)
            fail_msg("%s: expected %s", texts[i].json, texts[i].read ? "read" : "refused");
        ect_facts_free(&f);
    }
}

/* --- images and descriptions -------------------------------------------------------------------------------------- */

static void an_image_has_a_fact_of_each_field(void **state)
{
    static const struct {
        ect_fact_kind_t kind;
        unsigned int index, element;
        const char *text;
    } fields[] = {
        {ECT_FACT_VENDOR, 0, 0, "0x00000E57"},
        {ECT_FACT_PRODUCT, 0, 0, "0x00007E57"},
        {ECT_FACT_REVISION, 0, 0, "0x00010002"},
        {ECT_FACT_CHECKSUM, 0, 0, "right"},
        {ECT_FACT_CONFIG, 0, 0, "0x0008"},
        {ECT_FACT_CONFIG, 4, 0, "none"}, /* the station alias */
        {ECT_FACT_CONFIG, 7, 0, "none"}, /* the checksum has a fact of its own */
        {ECT_FACT_EEPROM_SIZE, 0, 0, "2048 bytes"},
        {ECT_FACT_MAILBOX_OUT, 0, 0, "128 bytes at 0x1000"},
        {ECT_FACT_MAILBOX_IN, 0, 0, "128 bytes at 0x1080"},
        {ECT_FACT_BOOT_OUT, 0, 0, "none"},
        {ECT_FACT_PROTOCOLS, 0, 0, "CoE"},
        {ECT_FACT_COE, 0, 0, "SDO SDO-information PDO-upload Complete-Access"},
        {ECT_FACT_TYPE, 0, 0, "\"ectwin test device\""},
        {ECT_FACT_NAME, 0, 0, "\"ectwin test device\""},
        {ECT_FACT_GROUP, 0, 0, "\"TEST\""},
        {ECT_FACT_GROUP_NAME, 0, 0, "\"Test devices\""},
        {ECT_FACT_PORTS, 0, 0, "\"YY\""},
        {ECT_FACT_EBUS, 0, 0, "0 mA"},
        {ECT_FACT_FMMU, 0, 0, "outputs"},
        {ECT_FACT_FMMU, 2, 0, "mailbox state"},
        {ECT_FACT_SM_START, 2, 0, "0x1200"},
        {ECT_FACT_SM_LENGTH, 2, 0, "3 bytes"},
        {ECT_FACT_SM_CONTROL, 2, 0, "0x64"},
        {ECT_FACT_SM_ENABLED, 2, 0, "yes"},
        {ECT_FACT_PDO, 0x1600, 0, "outputs"},
        {ECT_FACT_PDO, 0x1A00, 0, "inputs"},
        {ECT_FACT_PDO_SM, 0x1600, 0, "2"},
        {ECT_FACT_PDO_NAME, 0x1600, 0, "\"Outputs\""},
        {ECT_FACT_PDO_ENTRY, 0x1600, 1, "7000:01, 1 bits"},
        {ECT_FACT_PDO_ENTRY, 0x1600, 2, "7 bits of padding"},
        {ECT_FACT_PDO_ENTRY_NAME, 0x1600, 3, "\"Output word\""},
        {ECT_FACT_PDO_ENTRY_TYPE, 0x1600, 3, "0x06"},
        {ECT_FACT_GENERAL, 4, 0, "0x00"},
        {ECT_FACT_GENERAL, 5, 0, "none"}, /* bytes with facts of their own: CoE, E-bus current */
        {ECT_FACT_GENERAL, 12, 0, "none"},
        {ECT_FACT_GENERAL, 13, 0, "none"},
        {ECT_FACT_CATEGORY, ECT_SII_GENERAL, 0, "there"},
        {ECT_FACT_CATEGORY, ECT_SII_END, 0, "the end"},
        {ECT_FACT_CATEGORY, ECT_SII_DC, 0, "none"},
    };
    uint8_t image[2048];
    ect_facts_t f = {.source = "image"}, g = {.source = "description"};
    (void)state;
    assert_true(ect_sii_write(&testdev, NULL, 0, image, sizeof image) > 0);
    ect_facts_of_sii(&f, image, sizeof image);
    ect_facts_of_device(&g, &testdev);
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        const char *text = text_of(&f, fields[i].kind, fields[i].index, fields[i].element);
        if (strcmp(text, fields[i].text) != 0)
            fail_msg("field %zu of the image: expected %s, got %s", i, fields[i].text, text);
        if (fields[i].kind < ECT_FACT_FILE && /* the description has the same facts */
            strcmp(text_of(&g, fields[i].kind, fields[i].index, fields[i].element), text) != 0)
            fail_msg("field %zu of the description: expected %s", i, text);
    }
    ect_facts_free(&f);
    ect_facts_free(&g);
}

static bool has_kind(const ect_facts_t *facts, ect_fact_kind_t kind)
{
    for (size_t i = 0; i < facts->count; i++) {
        if (facts->list[i].kind == kind)
            return true;
    }
    return false;
}

static void expect_places(const char *device, const ect_facts_t *facts, const ect_facts_t *others)
{
    for (size_t i = 0; i < facts->count; i++) {
        const ect_fact_t *f = &facts->list[i];
        if (has_kind(others, f->kind) && strcmp(text_of(others, f->kind, f->index, f->element), "none") == 0 &&
            (f->text == NULL || strcmp(f->text, "none") != 0))
            fail_msg("%s: kind %d of %s at %04X:%u: none of %s", device, f->kind, facts->source, f->index, f->element,
                     others->source);
    }
}

/* Facts at different places are never compared. */
static void a_device_and_its_image_have_their_facts_at_the_same_places(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i) != NULL; i++) {
        const ect_device_t *device = every_device(i);
        uint8_t image[8192];
        ect_facts_t f = {.source = "image"}, g = {.source = "description"};
        assert_true(device->sii_size <= sizeof image);
        assert_true(ect_sii_write(device, NULL, 0, image, device->sii_size) > 0);
        ect_facts_of_sii(&f, image, device->sii_size);
        ect_facts_of_device(&g, device);
        expect_places(device->name, &f, &g);
        expect_places(device->name, &g, &f);
        ect_facts_free(&f);
        ect_facts_free(&g);
    }
}

/* The default of a constant is its value: a difference is one of the description, and reported there. */
static void a_constant_has_no_default(void **state)
{
    static const uint16_t number = 0x1234;
    static const struct {
        uint16_t access;
        const void *data;
        const char *text;
    } rows[] = {{ECT_ACCESS_RO, NULL, "05"}, /* zeros at the end count for nothing */
                {ECT_ACCESS_RO | ECT_ACCESS_SHARED, &number, "none"},
                {ECT_ACCESS_RO | ECT_ACCESS_DESCRIPTION, ECT_OFFSET(ect_device_t, ebus_ma), "none"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_entry_t entry = {.data_type = ECT_TYPE_UNSIGNED16,
                                   .bit_length = 16,
                                   .access = rows[i].access,
                                   .name = "Number",
                                   .value = 5,
                                   .data = (void *)(uintptr_t)rows[i].data};
        const ect_object_t object = {
            .index = 0x2000, .object_code = ECT_OBJECT_VAR, .name = "Number", .entries = &entry};
        ect_device_t device = testdev;
        ect_facts_t f = {.source = "description"};
        device.objects = &object;
        device.object_count = 1;
        ect_facts_of_device(&f, &device);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY, 0x2000, 0), "16 bits");
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 0), rows[i].text);
        ect_facts_free(&f);
    }
}

/* The PDOs of a slave with CoE may be in its dictionary alone: an image with PDOs of one direction is whole. */
static void an_image_with_coe_has_all_pdos_or_none(void **state)
{
    static const struct {
        const char *what;
        bool inputs, outputs, whole;
    } rows[] = {{"both", true, true, true},
                {"inputs alone", true, false, true},
                {"outputs alone", false, true, true},
                {"none", false, false, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[2048];
        size_t length;
        ect_facts_t f = {.source = "image"};
        assert_true(ect_sii_write(&testdev, NULL, 0, image, sizeof image) > 0);
        const ptrdiff_t inputs = ect_sii_category(image, sizeof image, ECT_SII_TXPDO, &length) - image;
        const ptrdiff_t outputs = ect_sii_category(image, sizeof image, ECT_SII_RXPDO, &length) - image;
        if (!rows[i].inputs)
            ect_store_le16(image + inputs - 4, 0x0801);
        if (!rows[i].outputs)
            ect_store_le16(image + outputs - 4, 0x0802);
        ect_facts_of_sii(&f, image, sizeof image);
        if (f.complete[ECT_FACT_PDO] != rows[i].whole || f.complete[ECT_FACT_PDO_ENTRY] != rows[i].whole)
            fail_msg("%s: the PDOs are %s", rows[i].what, rows[i].whole ? "not whole" : "whole");
        ect_facts_free(&f);
    }
}

static void an_image_shorter_than_its_header_is_one_fact(void **state)
{
    static const uint8_t image[ECT_SII_CATEGORIES];
    ect_facts_t f = {.source = "image"}, whole = {.source = "image"};
    (void)state;
    ect_facts_of_sii(&f, image, sizeof image - 1);
    assert_int_equal(f.count, 1);
    assert_string_equal(text_of(&f, ECT_FACT_EEPROM_SIZE, 0, 0), "127 bytes, less than its header");
    ect_facts_free(&f);
    ect_facts_of_sii(&whole, image, sizeof image);
    assert_string_equal(text_of(&whole, ECT_FACT_EEPROM_SIZE, 0, 0), "128 bytes");
    assert_string_equal(text_of(&whole, ECT_FACT_VENDOR, 0, 0), "0x00000000");
    ect_facts_free(&whole);
}

static void a_pdo_of_an_image_may_be_fixed_and_mandatory(void **state)
{
    static const struct {
        uint16_t flags;
        const char *fixed, *mandatory;
    } rows[] = {{0, "no", "no"},
                {ECT_PDO_FIXED, "yes", "no"},
                {ECT_PDO_MANDATORY, "no", "yes"},
                {ECT_PDO_FIXED | ECT_PDO_MANDATORY, "yes", "yes"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[ECT_SII_CATEGORIES + 16] = {0}, *pdo = image + ECT_SII_CATEGORIES + 4;
        ect_facts_t f = {.source = "image"};
        ect_store_le16(image + ECT_SII_CATEGORIES, ECT_SII_RXPDO);
        ect_store_le16(image + ECT_SII_CATEGORIES + 2, 4);
        ect_store_le16(image + ECT_SII_CATEGORIES + 12, ECT_SII_END);
        ect_store_le16(pdo, 0x1600);
        pdo[3] = 2;
        ect_store_le16(pdo + 6, rows[i].flags);
        ect_facts_of_sii(&f, image, sizeof image);
        assert_string_equal(text_of(&f, ECT_FACT_PDO, 0x1600, 0), "outputs");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_SM, 0x1600, 0), "2");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_FIXED, 0x1600, 0), rows[i].fixed);
        assert_string_equal(text_of(&f, ECT_FACT_PDO_MANDATORY, 0x1600, 0), rows[i].mandatory);
        assert_false(f.complete[ECT_FACT_SM]); /* the image has no word on SyncManagers */
        ect_facts_free(&f);
    }
}

static void an_entry_of_an_image_may_have_a_name_or_a_type_alone(void **state)
{
    static const struct {
        uint8_t name, type;
        const char *name_fact, *type_fact, *bits;
    } rows[] = {{0, 0, "none", "none", "no text, no type, 0x1234"},
                {1, 0, "\"DC\"", "none", "a text, no type, 0x1234"},
                {0, 5, "none", "0x05", "no text, a type, 0x1234"},
                {1, 6, "\"DC\"", "0x06", "a text, a type, 0x1234"},
                {2, 6, "string 2, which does not exist", "0x06", "a text, a type, 0x1234"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[ECT_SII_CATEGORIES + 40] = {0}, *at = image + ECT_SII_CATEGORIES;
        ect_facts_t f = {.source = "image"};
        ect_store_le16(at, ECT_SII_STRINGS);
        ect_store_le16(at + 2, 2);
        memcpy(at + 4, (const uint8_t[]){1, 2, 'D', 'C'}, 4);
        ect_store_le16(at + 8, ECT_SII_TXPDO);
        ect_store_le16(at + 10, 8);
        ect_store_le16(at + 12, 0x1A00);
        at[14] = 1; /* entry */
        ect_store_le16(at + 20, 0x6000);
        at[22] = 7;
        at[23] = rows[i].name;
        at[24] = rows[i].type;
        at[25] = 8;
        ect_store_le16(at + 26, 0x1234);
        ect_store_le16(at + 28, ECT_SII_END);
        ect_facts_of_sii(&f, image, sizeof image);
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1A00, 1), "6000:07, 8 bits");
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY_NAME, 0x1A00, 1), rows[i].name_fact);
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY_TYPE, 0x1A00, 1), rows[i].type_fact);
        assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY_BITS, 0x1A00, 1), rows[i].bits);
        ect_facts_free(&f);
    }
}

/* The length of a SyncManager of 0 bytes is the master's: the image has no word on whether it is enabled. */
static void a_sync_manager_of_an_image_with_a_length_is_enabled_or_not(void **state)
{
    static const struct {
        uint16_t length;
        uint8_t activate;
        const char *enabled;
    } rows[] = {{0, 1, "none"}, {1, 1, "yes"}, {1, 0, "no"}, {2, 0xFE, "no"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[ECT_SII_CATEGORIES + 16] = {0}, *sm = image + ECT_SII_CATEGORIES + 4;
        ect_facts_t f = {.source = "image"};
        ect_store_le16(image + ECT_SII_CATEGORIES, ECT_SII_SYNCM);
        ect_store_le16(image + ECT_SII_CATEGORIES + 2, 4);
        ect_store_le16(image + ECT_SII_CATEGORIES + 12, ECT_SII_END);
        ect_store_le16(sm + 2, rows[i].length);
        sm[6] = rows[i].activate;
        sm[7] = ECT_SM_OUTPUTS;
        ect_facts_of_sii(&f, image, sizeof image);
        assert_string_equal(text_of(&f, ECT_FACT_SM_ENABLED, 0, 0), rows[i].enabled);
        assert_true(f.complete[ECT_FACT_SM]);
        ect_facts_free(&f);
    }
}

/* Device type and name of a description are constants, and a slave replies with them; other constants have no default.
 */
static void a_description_has_defaults_of_identity(void **state)
{
    ect_facts_t f = {.source = "description"};
    (void)state;
    ect_facts_of_device(&f, &testdev);
    assert_string_not_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x1000, 0), "none");
    assert_string_not_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x1008, 0), "none");
    assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x1001, 0), "00");
    ect_facts_free(&f);
}

static void a_device_name_of_a_description_has_at_most_256_bytes(void **state)
{
    static const struct {
        uint16_t bytes;
        bool known;
    } rows[] = {{1, true}, {255, true}, {256, true}, {257, false}};
    char name[257];
    (void)state;
    memset(name, 'a', sizeof name);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_entry_t entry = {.data_type = ECT_TYPE_VISIBLE_STRING,
                                   .bit_length = (uint16_t)(8 * rows[i].bytes),
                                   .access = ECT_ACCESS_RO | ECT_ACCESS_SHARED,
                                   .name = "Device name",
                                   .data = name};
        const ect_object_t object = {
            .index = 0x1008, .object_code = ECT_OBJECT_VAR, .name = "Device name", .entries = &entry};
        ect_device_t device = testdev;
        ect_facts_t f = {.source = "description"};
        device.objects = &object;
        device.object_count = 1;
        ect_facts_of_device(&f, &device);
        if ((strcmp(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x1008, 0), "none") != 0) != rows[i].known)
            fail_msg("%u bytes: %s", rows[i].bytes, rows[i].known ? "no default" : "a default");
        ect_facts_free(&f);
    }
}

/* The name of the second clock is the string of number 1, the first has none: there is a clock all the same. */
static void a_clock_of_an_image_may_have_no_name(void **state)
{
    enum { STRINGS_WORDS = 2, CLOCKS_WORDS = 24, CLOCK = 24 };
    uint8_t image[ECT_SII_CATEGORIES + 4 + 2 * STRINGS_WORDS + 4 + 2 * CLOCKS_WORDS + 4] = {0};
    uint8_t *at = image + ECT_SII_CATEGORIES;
    ect_facts_t f = {.source = "image"};
    (void)state;
    ect_store_le16(at, ECT_SII_STRINGS);
    ect_store_le16(at + 2, STRINGS_WORDS);
    memcpy(at + 4, (const uint8_t[]){1, 2, 'D', 'C'}, 4);
    at += 4 + 2 * STRINGS_WORDS;
    ect_store_le16(at, ECT_SII_DC);
    ect_store_le16(at + 2, CLOCKS_WORDS);
    ect_store_le32(at + 4, 1000000);                    /* SYNC0 */
    ect_store_le32(at + 4 + CLOCK + 4, (uint32_t)-500); /* its shift */
    ect_store_le16(at + 4 + CLOCK + 14, 0x0700);
    at[4 + CLOCK + 18] = 1;
    ect_store_le16(at + 4 + 2 * CLOCKS_WORDS, ECT_SII_END);
    ect_facts_of_sii(&f, image, sizeof image);
    const ect_fact_t *clocks[3] = {NULL};
    size_t count = 0;
    for (size_t i = 0; i < f.count; i++) {
        if (f.list[i].kind == ECT_FACT_DC && count < 3)
            clocks[count++] = &f.list[i];
    }
    assert_int_equal(count, 2);
    assert_null(clocks[0]->text);
    assert_int_equal(clocks[0]->index, 0);
    assert_int_equal(clocks[0]->element, 0);
    assert_string_equal(clocks[1]->text, "\"DC\"");
    assert_int_equal(clocks[1]->index, 1);
    assert_string_equal(text_of(&f, ECT_FACT_DC_SYNC0, 0, 0), "1000000 ns, factor 0, shift 0 ns");
    assert_string_equal(text_of(&f, ECT_FACT_DC_SYNC0, 1, 0), "0 ns, factor 0, shift -500 ns");
    assert_string_equal(text_of(&f, ECT_FACT_DC_ACTIVATE, 1, 0), "0x0700");
    ect_facts_free(&f);
}

/* The last category announces more words than the image has: there is none. */
static void a_category_beyond_the_image_is_none(void **state)
{
    enum { SIZE = ECT_SII_CATEGORIES + 4 + 20, VENDOR = 0x0800 };
    (void)state;
    for (unsigned int words = 9; words <= 12; words++) {
        uint8_t image[2 * SIZE] = {0};
        ect_facts_t f = {.source = "image"};
        ect_store_le16(image + ECT_SII_CATEGORIES, VENDOR);
        ect_store_le16(image + ECT_SII_CATEGORIES + 2, (uint16_t)words);
        ect_facts_of_sii(&f, image, SIZE);
        assert_int_equal(strcmp(text_of(&f, ECT_FACT_CATEGORY, VENDOR, 0), "none") != 0, words <= 10);
        ect_facts_free(&f);
    }
}

/* Names in General are optional; ports of an unknown kind keep their place. */
static void a_description_has_the_texts_of_its_device(void **state)
{
    static const struct {
        const char *full_name, *physics, *name, *ports;
    } rows[] = {{NULL, NULL, "\"ectwin test device\"", "none"},
                {"Gauge", "", "\"Gauge\"", "none"},
                {"Gauge", "Y", "\"Gauge\"", "\"Y\""},
                {"Gauge", "YXKH", "\"Gauge\"", "\"Y KH\""},
                {"Gauge", "KKKKY", "\"Gauge\"", "\"KKKK\""}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = testdev;
        ect_facts_t f = {.source = "description"};
        device.full_name = rows[i].full_name;
        device.physics = rows[i].physics;
        ect_facts_of_device(&f, &device);
        assert_string_equal(text_of(&f, ECT_FACT_TYPE, 0, 0), "\"ectwin test device\"");
        assert_string_equal(text_of(&f, ECT_FACT_NAME, 0, 0), rows[i].name);
        assert_string_equal(text_of(&f, ECT_FACT_PORTS, 0, 0), rows[i].ports);
        ect_facts_free(&f);
    }
}

static void a_description_has_a_fact_of_each_part_of_an_entry(void **state)
{
    static const uint64_t initial = UINT64_C(0x0807060504030201);
    static const char text[] = "text";
    static const struct {
        ect_entry_t entry;
        ect_detail_t detail;
        const char *length, *type, *access, *name, *value, *limits, *unit;
    } rows[] = {
        {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "Speed", 0x0201, NULL},
         {.unit = 0x2D, .minimum = -1, .maximum = 5},
         "16 bits",
         "0x0006",
         "R.PREOP R.SAFEOP R.OP",
         "\"Speed\"",
         "01 02",
         "-1 to 5",
         "0x002D"},
        {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_WO | ECT_ACCESS_COMMAND, NULL, 3, NULL},
         {.minimum = 4, .maximum = 4},
         "8 bits",
         "0x0005",
         "W.PREOP W.SAFEOP W.OP",
         "none",
         "03",
         "none",
         "none"},
        {{0, ECT_TYPE_UNSIGNED64, 64, ECT_ACCESS_RO, "Long", 0x11, NULL},
         {.initial = &initial},
         "64 bits",
         "0x001B",
         "R.PREOP R.SAFEOP R.OP",
         "\"Long\"",
         "01 02 03 04 05 06 07 08",
         "none",
         "none"},
        {{0, ECT_TYPE_OCTET_STRING, 72, ECT_ACCESS_RO, "Nine", 0x11, NULL},
         {.unit = 1},
         "72 bits",
         "0x000A",
         "R.PREOP R.SAFEOP R.OP",
         "\"Nine\"",
         "none",
         "none",
         "0x0001"},
        {{0, ECT_TYPE_VISIBLE_STRING, 32, ECT_ACCESS_RO, "Text", 0, NULL},
         {.initial = text},
         "32 bits",
         "0x0009",
         "R.PREOP R.SAFEOP R.OP",
         "\"Text\"",
         "none",
         "none",
         "none"},
        {{0, ECT_TYPE_BIT1 + 2, 3, ECT_ACCESS_RO, "Bits", 5, NULL},
         {.unit = 0},
         "3 bits",
         "0x0032",
         "R.PREOP R.SAFEOP R.OP",
         "\"Bits\"",
         "05",
         "none",
         "none"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_object_t object = {
            .index = 0x2000, .object_code = ECT_OBJECT_VAR, .name = "Object", .entries = &rows[i].entry};
        ect_detail_t detail = rows[i].detail;
        ect_device_t device = testdev;
        ect_facts_t f = {.source = "description"};
        detail.index = 0x2000;
        device.objects = &object;
        device.object_count = 1;
        device.details = &detail;
        device.detail_count = 1;
        ect_facts_of_device(&f, &device);
        assert_string_equal(text_of(&f, ECT_FACT_OBJECT, 0x2000, 0), "code 7");
        assert_string_equal(text_of(&f, ECT_FACT_OBJECT_NAME, 0x2000, 0), "\"Object\"");
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY, 0x2000, 0), rows[i].length);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_TYPE, 0x2000, 0), rows[i].type);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_ACCESS, 0x2000, 0), rows[i].access);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_NAME, 0x2000, 0), rows[i].name);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_DEFAULT, 0x2000, 0), rows[i].value);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_LIMITS, 0x2000, 0), rows[i].limits);
        assert_string_equal(text_of(&f, ECT_FACT_ENTRY_UNIT, 0x2000, 0), rows[i].unit);
        ect_facts_free(&f);
    }
}

/* A device may use the first objects of a longer list; its dictionary is one of CoE. */
static void a_description_has_the_objects_that_it_counts(void **state)
{
    static const struct {
        uint16_t count;
        uint8_t protocols;
        const char *number, *pdo, *object_of_pdo;
    } rows[] = {{0, ECT_MAILBOX_COE, "none", "none", "none"},
                {1, ECT_MAILBOX_COE, "code 7", "none", "none"},
                {2, ECT_MAILBOX_COE, "code 7", "inputs", "code 9"},
                {2, ECT_MAILBOX_FOE, "none", "inputs", "none"}};
    static const ect_entry_t number = {.data_type = ECT_TYPE_UNSIGNED16, .bit_length = 16, .access = ECT_ACCESS_RO};
    static const ect_entry_t count = {.data_type = ECT_TYPE_UNSIGNED8, .bit_length = 8, .access = ECT_ACCESS_RO};
    static const ect_object_t objects[] = {
        {.index = 0x1009, .object_code = ECT_OBJECT_VAR, .entries = &number},
        {.index = 0x1A00, .object_code = ECT_OBJECT_RECORD, .entries = &count},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = testdev;
        ect_facts_t f = {.source = "description"};
        device.objects = objects;
        device.object_count = rows[i].count;
        device.mailbox_protocols = rows[i].protocols;
        ect_facts_of_device(&f, &device);
        assert_string_equal(text_of(&f, ECT_FACT_OBJECT, 0x1009, 0), rows[i].number);
        assert_string_equal(text_of(&f, ECT_FACT_PDO, 0x1A00, 0), rows[i].pdo);
        assert_string_equal(text_of(&f, ECT_FACT_OBJECT, 0x1A00, 0), rows[i].object_of_pdo);
        ect_facts_free(&f);
    }
}

static void a_pdo_of_a_description_has_at_most_255_elements(void **state)
{
    static const struct {
        uint32_t count;
        unsigned int facts;
    } rows[] = {{0, 0}, {1, 1}, {254, 254}, {255, 255}, {256, 255}, {UINT32_MAX, 255}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_entry_t entries[256];
        const ect_object_t pdo = {
            .index = 0x1A00, .object_code = ECT_OBJECT_RECORD, .max_subindex = 255, .last = 255, .entries = entries};
        ect_device_t device = testdev;
        ect_facts_t f = {.source = "description"};
        for (unsigned int n = 0; n < 256; n++)
            entries[n] = (ect_entry_t){.subindex = (uint16_t)n,
                                       .data_type = ECT_TYPE_UNSIGNED32,
                                       .bit_length = 32,
                                       .access = ECT_ACCESS_RO,
                                       .value = n == 0 ? rows[i].count : n};
        device.objects = &pdo;
        device.object_count = 1;
        ect_facts_of_device(&f, &device);
        unsigned int count = 0;
        for (size_t n = 0; n < f.count; n++)
            count += f.list[n].kind == ECT_FACT_PDO_ENTRY;
        assert_int_equal(count, rows[i].facts);
        if (count > 0) {
            char last[40];
            (void)snprintf(last, sizeof last, "%u bits of padding", count);
            assert_string_equal(text_of(&f, ECT_FACT_PDO_ENTRY, 0x1A00, count), last);
        }
        ect_facts_free(&f);
    }
}

/* Bytes after the last whole element have no facts of their own: the category counts them. */
static void a_category_counts_the_bytes_after_its_last_element(void **state)
{
    static const struct {
        uint16_t type, words;
        const char *text;
    } rows[] = {{ECT_SII_SYNCM, 0, "there"},
                {ECT_SII_SYNCM, 3, "there, with 6 bytes at its end"},
                {ECT_SII_SYNCM, 4, "there"},
                {ECT_SII_SYNCM, 5, "there, with 2 bytes at its end"},
                {ECT_SII_SYNCM, 12, "there"},
                {ECT_SII_SYNCM, 28, "there"},
                {ECT_SII_DC, 0, "there"},
                {ECT_SII_DC, 4, "there, with 8 bytes at its end"},
                {ECT_SII_DC, 11, "there, with 22 bytes at its end"},
                {ECT_SII_DC, 12, "there"},
                {ECT_SII_DC, 13, "there, with 2 bytes at its end"},
                {ECT_SII_DC, 24, "there"},
                {ECT_SII_STRINGS, 5, "there"},
                {ECT_SII_GENERAL, 5, "there"},
                {ECT_SII_FMMU, 5, "there"},
                {ECT_SII_TXPDO, 5, "there"},
                {ECT_SII_RXPDO, 5, "there"},
                {0x0800, 2, "4 bytes, sum 4B95F515"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[ECT_SII_CATEGORIES + 80] = {0};
        ect_facts_t f = {.source = "image"};
        ect_store_le16(image + ECT_SII_CATEGORIES, rows[i].type);
        ect_store_le16(image + ECT_SII_CATEGORIES + 2, rows[i].words);
        ect_store_le16(image + ECT_SII_CATEGORIES + 4 + 2 * (size_t)rows[i].words, ECT_SII_END);
        ect_facts_of_sii(&f, image, sizeof image);
        const char *text = text_of(&f, ECT_FACT_CATEGORY, rows[i].type, 0);
        if (strcmp(text, rows[i].text) != 0)
            fail_msg("category %u of %u words: expected %s, got %s", rows[i].type, rows[i].words, rows[i].text, text);
        assert_string_equal(text_of(&f, ECT_FACT_CATEGORY, ECT_SII_END, 0), "the end");
        ect_facts_free(&f);
    }
}

static void objects_with_facts_elsewhere_are_known(void **state)
{
    (void)state;
    for (unsigned int index = 0; index < 0x10000; index++) {
        const bool pdos = (index >= 0x1600 && index < 0x1C00) || (index >= 0x1C10 && index < 0x1C30);
        assert_int_equal(ect_facts_are_of_pdos(index), pdos);
        assert_int_equal(ect_facts_are_known_elsewhere(index), index == 0x1018 || index == 0x1C00);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_has_its_place_in_words),
        cmocka_unit_test(each_timeout_has_its_name),
        cmocka_unit_test(helpers_write_facts_as_texts),
        cmocka_unit_test(a_sum_is_that_of_FNV_1a),
        cmocka_unit_test(each_byte_of_General_is_a_fact),
        cmocka_unit_test(General_has_at_least_18_bytes),
        cmocka_unit_test(long_values_of_a_file_are_compared_by_their_sum),
        cmocka_unit_test(a_part_is_missed_only_where_its_whole_is_there),
        cmocka_unit_test(facts_without_a_text_are_equal_to_any),
        cmocka_unit_test(a_made_fact_is_not_missed),
        cmocka_unit_test(later_sources_are_compared_with_all_before),
        cmocka_unit_test(texts_of_a_file_follow_only_without_other_differences),
        cmocka_unit_test(a_dictionary_has_facts_of_objects_and_of_pdos),
        cmocka_unit_test(each_assignment_names_its_sync_manager),
        cmocka_unit_test(without_an_assignment_the_sync_managers_of_pdos_are_unknown),
        cmocka_unit_test(elements_beyond_the_count_of_a_pdo_and_of_an_assignment_are_none),
        cmocka_unit_test(a_value_that_the_slave_did_not_give_is_no_fact),
        cmocka_unit_test(an_assignment_may_precede_its_pdo),
        cmocka_unit_test(a_pdo_and_an_assignment_have_at_most_255_elements),
        cmocka_unit_test(limits_of_a_dictionary_have_the_sign_of_their_type),
        cmocka_unit_test(a_number_of_a_dictionary_has_32_bits),
        cmocka_unit_test(any_dictionary_is_read_or_refused),
        cmocka_unit_test(an_image_has_a_fact_of_each_field),
        cmocka_unit_test(a_device_and_its_image_have_their_facts_at_the_same_places),
        cmocka_unit_test(a_constant_has_no_default),
        cmocka_unit_test(an_image_with_coe_has_all_pdos_or_none),
        cmocka_unit_test(an_image_shorter_than_its_header_is_one_fact),
        cmocka_unit_test(a_pdo_of_an_image_may_be_fixed_and_mandatory),
        cmocka_unit_test(an_entry_of_an_image_may_have_a_name_or_a_type_alone),
        cmocka_unit_test(a_sync_manager_of_an_image_with_a_length_is_enabled_or_not),
        cmocka_unit_test(a_description_has_defaults_of_identity),
        cmocka_unit_test(a_device_name_of_a_description_has_at_most_256_bytes),
        cmocka_unit_test(a_clock_of_an_image_may_have_no_name),
        cmocka_unit_test(a_category_beyond_the_image_is_none),
        cmocka_unit_test(a_description_has_the_texts_of_its_device),
        cmocka_unit_test(a_description_has_a_fact_of_each_part_of_an_entry),
        cmocka_unit_test(a_description_has_the_objects_that_it_counts),
        cmocka_unit_test(a_pdo_of_a_description_has_at_most_255_elements),
        cmocka_unit_test(a_category_counts_the_bytes_after_its_last_element),
        cmocka_unit_test(objects_with_facts_elsewhere_are_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
