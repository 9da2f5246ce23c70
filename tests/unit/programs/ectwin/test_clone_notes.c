/* SPDX-License-Identifier: MIT */
/* `ectwin clone`: the parts of a slave that are blanked (CLN-013), and the comment at the head of its file. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmocka.h>

#include "clone_blank.h"
#include "clone_note.h"
#include "devices/fzm1/fzm1.h"
#include "od/od.h"
#include "sii/sii.h"
#include "support/hex.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { HEADER = 128, IMAGE = 512, TEXT = 4096, SERIAL = 1, ALIAS = 2, NAMES = 4, TEXTS = 8 };

/* --- blanks ------------------------------------------------------------------------------------------------------- */

static void parts_are_separated_by_commas(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool valid;
        unsigned int parts;
    } rows[] = {
        {"none", true, 0},
        {"serial", true, SERIAL},
        {"alias", true, ALIAS},
        {"names", true, NAMES},
        {"texts", true, TEXTS},
        {"serial,texts", true, SERIAL | TEXTS},
        {"names,names", true, NAMES},
        {"texts,names,alias,serial", true, SERIAL | ALIAS | NAMES | TEXTS},
        {"", false, 0},
        {"serial,", false, 0},
        {",serial", false, 0},
        {"serial,,alias", false, 0},
        {"seria", false, 0},
        {"serials", false, 0},
        {"none,serial", false, 0},
        {"serial,none", false, 0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        unsigned int parts = 99;
        const bool valid = clone_blank_parse(rows[i].text, &parts);
        if (valid != rows[i].valid)
            print_error("'%s'\n", rows[i].text);
        assert_int_equal(valid, rows[i].valid);
        if (valid)
            assert_int_equal(parts, rows[i].parts);
    }
}

static void the_comment_lists_the_blanked_parts(void **state)
{
    (void)state;
    static const struct {
        unsigned int parts;
        const char *text;
    } rows[] = {{0, "nothing"},
                {SERIAL, "serial"},
                {TEXTS, "texts"},
                {SERIAL | NAMES, "serial, names"},
                {SERIAL | ALIAS | NAMES | TEXTS, "serial, alias, names, texts"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[40];
        assert_string_equal(clone_blank_text(rows[i].parts, text), rows[i].text);
    }
}

static void serial_number_and_alias_of_an_image_become_0(void **state)
{
    (void)state;
    static const struct {
        unsigned int parts;
        size_t size, first, end; /* bytes that become 0 */
    } rows[] = {{SERIAL, HEADER, 0x1C, 0x20},        {ALIAS, HEADER, 0x08, 0x0A}, {NAMES | TEXTS, HEADER, 0, 0},
                {SERIAL, HEADER - 1, 0, 0},          {ALIAS, HEADER - 1, 0, 0},   {0, HEADER, 0, 0},
                {SERIAL | NAMES, HEADER, 0x1C, 0x20}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[HEADER], want[HEADER];
        memset(image, 0xA5, sizeof image);
        memset(want, 0xA5, sizeof want);
        memset(want + rows[i].first, 0, rows[i].end - rows[i].first);
        clone_blank_image(rows[i].parts, image, rows[i].size);
        assert_memory_equal(image, want, sizeof want);
    }
}

/* Categories: type, number of words, content. STRINGS (000Ah) is a count and texts after their lengths; GENERAL (001Eh)
 * begins with the numbers of four texts. */
static void names_in_an_image_become_x(void **state)
{
    (void)state;
    static const struct {
        const char *before, *after;
    } rows[] = {
        {"0A00 0400 02 03616263 026465 1E00 0200 01020000 FFFF",
         "0A00 0400 02 03787878 027878 1E00 0200 01020000 FFFF"},
        {"0A00 0400 02 03616263 026465 1E00 0200 00000002 FFFF",
         "0A00 0400 02 03616263 027878 1E00 0200 00000002 FFFF"},
        {"0A00 0400 02 03616263 026465 1E00 0200 00010000 FFFF",
         "0A00 0400 02 03787878 026465 1E00 0200 00010000 FFFF"},
        /* texts that are not there: 0, behind the last, longer than the category */
        {"0A00 0400 02 03616263 026465 1E00 0200 00000000 FFFF", NULL},
        {"0A00 0400 02 03616263 026465 1E00 0200 03000000 FFFF", NULL},
        {"0A00 0400 02 03616263 026465 1E00 0200 FF000000 FFFF", NULL},
        {"0A00 0400 02 03616263 036465 1E00 0200 02000000 FFFF", NULL},
        {"0A00 0200 01 036162 1E00 0200 01000000 FFFF", NULL},
        {"0A00 0200 01 026162 1E00 0200 01000000 FFFF", "0A00 0200 01 027878 1E00 0200 01000000 FFFF"},
        /* the first category of a type, in any order */
        {"1E00 0200 01000000 2800 0100 AAAA 0A00 0200 01 026162 0A00 0200 01 026162 FFFF",
         "1E00 0200 01000000 2800 0100 AAAA 0A00 0200 01 027878 0A00 0200 01 026162 FFFF"},
        /* incomplete categories */
        {"0A00 0200 01 026162 1E00 0100 0100 FFFF", NULL},
        {"0A00 0200 01 026162 1E00 0300 01000000 0000 FFFF", "0A00 0200 01 027878 1E00 0300 01000000 0000 FFFF"},
        {"0A00 0200 01 026162 FFFF 0200 1E00 0200 01000000", NULL},
        {"1E00 0200 01000000 FFFF 0000 0A00 0200 01 026162", NULL},
        {"1E00 0200 01000000 0A00 0200 01 026162", "1E00 0200 01000000 0A00 0200 01 027878"},
        {"1E00 0200 03000000 0A00 0200 01 026162", NULL},
        {"1E00 0200 01000000 0A00 0300 01 026162", NULL},
        {"1E00 0200 01000000 0A00 0000", NULL},
        {"1E00 0200 01000000 0A00", NULL},
        {"", NULL},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t *want = calloc(1, IMAGE), content[IMAGE];
        const size_t size = HEADER + from_hex(rows[i].before, content);
        uint8_t *image = calloc(1, size); /* of exactly this size */
        assert_true(want && image);
        memcpy(image + HEADER, content, size - HEADER);
        memcpy(want, image, size);
        if (rows[i].after)
            assert_int_equal(from_hex(rows[i].after, want + HEADER), size - HEADER);
        clone_blank_image(SERIAL | ALIAS | TEXTS, image, size); /* these are 0 before */
        if (memcmp(image + HEADER, content, size - HEADER) != 0)
            fail_msg("row %zu: without names", i);
        clone_blank_image(NAMES, image, size);
        if (memcmp(image, want, size) != 0)
            print_error("row %zu: %s\n", i, rows[i].before);
        assert_memory_equal(image, want, size);
        free(image);
        free(want);
    }
}

static void values_are_blanked_by_index_type_and_access(void **state)
{
    (void)state;
    enum { KEPT = 0xA5, U32 = 0x0007, VISIBLE = 0x0009, OCTET = 0x000A, UNICODE = 0x000B, TIME_OF_DAY = 0x000C };
    static const struct {
        unsigned int parts;
        uint16_t index;
        uint8_t subindex;
        uint16_t type, access;
        uint8_t want;
    } rows[] = {
        {SERIAL, 0x1018, 4, U32, ECT_ACCESS_RO, 0},
        {SERIAL, 0x1018, 3, U32, ECT_ACCESS_RO, KEPT},
        {SERIAL, 0x1018, 5, U32, ECT_ACCESS_RO, KEPT},
        {SERIAL, 0x1017, 4, U32, ECT_ACCESS_RO, KEPT},
        {SERIAL, 0x1019, 4, U32, ECT_ACCESS_RO, KEPT},
        {NAMES | TEXTS, 0x1018, 4, U32, ECT_ACCESS_RO, KEPT},
        {NAMES, 0x1007, 0, VISIBLE, ECT_ACCESS_RO, KEPT},
        {NAMES, 0x1008, 0, VISIBLE, ECT_ACCESS_RO, 'x'},
        {NAMES, 0x100A, 0, VISIBLE, ECT_ACCESS_RO, 'x'},
        {NAMES, 0x100B, 0, VISIBLE, ECT_ACCESS_RO, KEPT},
        {SERIAL, 0x1008, 0, VISIBLE, ECT_ACCESS_RO, KEPT},
        {SERIAL | ALIAS | TEXTS, 0x1009, 0, VISIBLE, ECT_ACCESS_RO, KEPT},
        {TEXTS, 0x2000, 1, VISIBLE, ECT_ACCESS_WO, 0},
        {TEXTS, 0x2000, 1, OCTET, ECT_ACCESS_WO, 0},
        {TEXTS, 0x2000, 1, UNICODE, ECT_ACCESS_WO, 0},
        {TEXTS, 0x2000, 1, TIME_OF_DAY, ECT_ACCESS_WO, KEPT},
        {TEXTS, 0x2000, 1, 0x0008, ECT_ACCESS_WO, KEPT},
        {TEXTS, 0x2000, 1, VISIBLE, ECT_ACCESS_RO, KEPT},
        {TEXTS, 0x2000, 1, VISIBLE, 0x0008, 0},
        {TEXTS, 0x2000, 1, VISIBLE, 0x0020, 0},
        {TEXTS, 0x2000, 1, VISIBLE, 0x0040, KEPT},
        {SERIAL | ALIAS | NAMES, 0x2000, 1, VISIBLE, ECT_ACCESS_WO, KEPT},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t value[6], want[6];
        memset(value, KEPT, sizeof value);
        memset(want, rows[i].want, sizeof want);
        want[5] = KEPT; /* behind the value */
        clone_blank_value(rows[i].parts, rows[i].index, rows[i].subindex, rows[i].type, rows[i].access, value, 5);
        if (memcmp(value, want, sizeof want) != 0)
            print_error("row %zu\n", i);
        assert_memory_equal(value, want, sizeof want);
    }
}

/* --- the comment -------------------------------------------------------------------------------------------------- */

static void begin(clone_note_t *note)
{
    assert_true(clone_note_begin("test", note));
}

static const char *lines_of(const clone_note_t *note)
{
    assert_int_equal(fflush(note->lines.file), 0);
    return note->lines.text;
}

static void a_request_without_a_value_has_a_line_with_the_reason(void **state)
{
    (void)state;
    static const struct {
        ect_reader_gap_t gap;
        const char *line;
    } rows[] = {
        {{0x2000, 1, false, true, ECT_READER_ABORTED, 0x06020000}, "2000:01: no value: abort code 0x06020000\n"},
        {{0x2000, 1, false, true, ECT_READER_ABORTED, 0}, "2000:01: no value: refused without an abort code\n"},
        {{0x2000, 0xAB, false, false, ECT_READER_REFUSED, 5}, "2000:AB: no description: mailbox error 0x0005\n"},
        {{0x2000, 0, true, false, ECT_READER_REFUSED, 0}, "2000: no description: mailbox error 0x0000\n"},
        {{0x00AB, 0, true, true, ECT_READER_SILENT, 0}, "00AB: no description: no reply\n"},
        {{0x2000, 1, false, true, ECT_READER_WRONG, 1}, "2000:01: no value: a wrong reply\n"},
        {{0x2000, 1, false, true, ECT_READER_TOO_LONG, 0}, "2000:01: no value: too long\n"},
        {{0x2000, 1, false, true, ECT_READER_LOST, 0}, "2000:01: no value: no frame came back\n"},
        {{0x2000, 1, false, true, ECT_READER_STOPPED, 0}, "2000:01: no value: not read any more\n"},
        {{0x2000, 1, false, true, ECT_READER_DECLINED, 0}, "2000:01: no value: not read\n"},
        {{0x2000, 1, false, true, ECT_READER_OK, 0}, "2000:01: no value: not read\n"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        clone_note_t note;
        begin(&note);
        clone_note_gap(&note, &rows[i].gap);
        assert_string_equal(lines_of(&note), rows[i].line);
        clone_note_free(&note);
    }
}

static void an_entry_that_cannot_be_read_in_preop_has_a_line_with_its_access(void **state)
{
    (void)state;
    static const struct {
        bool described;
        uint16_t access;
        const char *line;
    } rows[] = {
        {true, 0x0001, ""},
        {true, 0x003F, ""},
        {false, 0x0038, ""},
        {true, 0x0038, "2000:0A: no value: access 0x0038, not readable\n"},
        {true, 0x0000, "2000:0A: no value: access 0x0000, not readable\n"},
        {true, 0x0002, "2000:0A: no value: access 0x0002, not readable in PREOP\n"},
        {true, 0x003C, "2000:0A: no value: access 0x003C, not readable in PREOP\n"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_reader_object_t object = {.index = 0x2000, .described = rows[i].described};
        const ect_reader_entry_t entry = {.subindex = 10, .access = rows[i].access};
        clone_note_t note;
        begin(&note);
        clone_note_object(&note, &object);
        clone_note_entry(&note, &object, &entry);
        const char *lines = lines_of(&note);
        assert_string_equal(lines ? lines : "", rows[i].line);
        clone_note_free(&note);
    }
}

/* The comment follows the first line. "--" ends a comment of XML, and XML has no control characters. */
static void the_comment_is_inserted_after_the_first_line(void **state)
{
    (void)state;
    static const struct {
        const char *head, *file, *want;
    } rows[] = {
        {"one\ntwo\n", "<?xml?>\n<a/>\n", "<?xml?>\n<!--\n  one\n  two\n  2000: no description: too long\n-->\n<a/>\n"},
        {"a--b---c-\n-d\n", "\n", "\n<!--\n  a- -b- - -c-\n  -d\n  2000: no description: too long\n-->\n"},
        {"\x1B\x7F \x1F~\xC3\n", "<a/>", "<!--\n  ?? ?~?\n  2000: no description: too long\n-->\n<a/>"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_reader_gap_t gap = {.index = 0x2000, .whole = true, .result = ECT_READER_TOO_LONG};
        clone_note_t note;
        size_t length = 0;
        begin(&note);
        clone_note_gap(&note, &gap);
        char *joined = clone_note_join("test", &note, rows[i].head, rows[i].file, strlen(rows[i].file), &length);
        assert_non_null(joined);
        assert_string_equal(joined, rows[i].want);
        assert_int_equal(length, strlen(rows[i].want));
        free(joined);
        clone_note_free(&note);
    }
}

static void the_time_is_that_of_source_date_epoch(void **state)
{
    (void)state;
    static const struct {
        const char *epoch, *want;
    } rows[] = {{"0", "1970-01-01 00:00:00 UTC"},
                {"1000000000", "2001-09-09 01:46:40 UTC"},
                {"253402300799", "9999-12-31 23:59:59 UTC"}};
    char text[32];
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setenv("SOURCE_DATE_EPOCH", rows[i].epoch, 1);
        clone_note_time(text);
        assert_string_equal(text, rows[i].want);
    }
    static const char *const others[] = {"253402300800", "-1", "x", ""}; /* the present time, which is later */
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        setenv("SOURCE_DATE_EPOCH", others[i], 1);
        clone_note_time(text);
        assert_true(strcmp(text, "2026") > 0 && strlen(text) == strlen(rows[0].want) && text[4] == '-');
    }
    unsetenv("SOURCE_DATE_EPOCH");
}

/* --- EEPROM and dictionary ---------------------------------------------------------------------------------------- */

typedef struct found {
    const char *objects; /* index:subindex=value in hexadecimal digits, separated by blanks */
    const char *sms;     /* registers of SyncManagers 0 and 1 */
    bool brought_up;
    const char *mail; /* left in SyncManager 1 */
    const char *lines;
} found_t;

static void take_objects(clone_note_t *note, const char *objects)
{
    unsigned int index, subindex, before = 0;
    char digits[64];
    int used = 0;
    for (; sscanf(objects, " %x:%x=%63s%n", &index, &subindex, digits, &used) == 3; objects += used) {
        uint8_t value[32];
        const ect_reader_object_t object = {.index = (uint16_t)index, .described = true};
        const ect_reader_entry_t entry = {.subindex = (uint8_t)subindex,
                                          .access = ECT_ACCESS_RO,
                                          .value = {.data = value, .length = from_hex(digits, value)}};
        if (index != before)
            clone_note_object(note, &object);
        clone_note_entry(note, &object, &entry);
        before = index;
    }
}

static void compare(const found_t *row, const uint8_t *image, size_t size)
{
    static ect_reader_t reader;
    char printed[TEXT], prefixed[TEXT] = "";
    const int memory = memfd_create("errors", MFD_CLOEXEC), before = dup(STDERR_FILENO);
    clone_note_t note;
    assert_true(memory >= 0 && before >= 0);
    memset(&reader, 0, sizeof reader);
    reader.brought_up = row->brought_up;
    assert_int_equal(from_hex(row->sms, reader.found_sms), sizeof reader.found_sms);
    reader.found_size = from_hex(row->mail, reader.found_mail);
    begin(&note);
    take_objects(&note, row->objects);
    assert_true(dup2(memory, STDERR_FILENO) >= 0);
    clone_note_compare(&note, image, size, &reader, "P: ");
    assert_true(dup2(before, STDERR_FILENO) >= 0);
    close(before);
    const ssize_t length = pread(memory, printed, sizeof printed - 1, 0);
    close(memory);
    assert_true(length >= 0);
    printed[length] = '\0';
    const char *lines = lines_of(&note);
    assert_string_equal(lines ? lines : "", row->lines);
    for (const char *line = row->lines; *line != '\0'; line = strchr(line, '\n') + 1) {
        if (strncmp(line, "SyncManager 1 had", 17) != 0) /* in the file only */
            sprintf(prefixed + strlen(prefixed), "P: %.*s\n", (int)strcspn(line, "\n"), line);
    }
    assert_string_equal(printed, prefixed);
    clone_note_free(&note);
}

#define OFF "0000000000000000 0000000000000000"

static void disagreements_of_eeprom_dictionary_and_syncmanagers_are_printed(void **state)
{
    (void)state;
    static const found_t rows[] = {
        {"", OFF, false, "", ""},
        {"1018:0=04 1018:1=11000000 1018:2=22000000 1018:3=33000000 1018:4=45000000", OFF, false, "", ""},
        {"1018:0=04 1018:1=12000000 1018:2=23000000 1018:3=34000000", OFF, false, "",
         "dictionary: identity vendor id: expected 0x00000011 (EEPROM), found 0x00000012\n"
         "dictionary: identity product code: expected 0x00000022 (EEPROM), found 0x00000023\n"
         "dictionary: identity revision: expected 0x00000033 (EEPROM), found 0x00000034\n"},
        {"1017:1=12000000 1019:1=12000000", OFF, false, "", ""},
        {"1018:1=120000000000000001", OFF, false, "",
         "dictionary: identity vendor id: expected 0x00000011 (EEPROM), found 0x00000012\n"},
        {"1600:0=01 1600:1=08017020", OFF, false, "",
         "dictionary: PDO 1600 entry 1: expected 2100:01, 32 bits (EEPROM), found 2070:01, 8 bits\n"
         "dictionary: PDO 1600 entry 2: expected 2100:02, 32 bits (EEPROM), found nothing\n"
         "dictionary: PDO 1600 entry 3: expected 2100:03, 32 bits (EEPROM), found nothing\n"
         "dictionary: PDO 1600 entry 4: expected 2100:04, 32 bits (EEPROM), found nothing\n"
         "dictionary: PDO 1600 entry 5: expected 2100:05, 32 bits (EEPROM), found nothing\n"},
        {"1A00:0=01 1A00:1=08016020", OFF, false, "",
         "dictionary: PDO 1A00 entry 1: expected 2200:01, 32 bits (EEPROM), found 2060:01, 8 bits\n"
         "dictionary: PDO 1A00 entry 2: expected 2200:02, 32 bits (EEPROM), found nothing\n"
         "dictionary: PDO 1A00 entry 3: expected 2200:03, 32 bits (EEPROM), found nothing\n"
         "dictionary: PDO 1A00 entry 4: expected 2200:04, 32 bits (EEPROM), found nothing\n"},
        {"1C12:0=01 1C12:1=0116 1C13:0=00", OFF, false, "", ""},
        {"1C0F:0=01 1C0F:1=0116 1C30:0=01 1C30:1=0116", OFF, false, "", ""},
        {"", "0010800026000100 8010800022000100", false, "", ""},
        {"", "0010810026000100 8110800022000100", false, "",
         "SyncManagers: mailbox to the slave: expected 128 bytes at 0x1000 (EEPROM), found 129 bytes at 0x1000\n"
         "SyncManagers: mailbox from the slave: expected 128 bytes at 0x1080 (EEPROM), found 128 bytes at 0x1081\n"},
        {"", "0010810026000100 8110800022000100", true, "", ""},
        {"", "0010810026000000 8110800022000100", false, "", ""},
        {"", "0010810026000100 8110800022000000", false, "", ""},
        {"", OFF, false, "0A0000000013", "SyncManager 1 had a mail of another master: 0A 00 00 00 00 13\n"},
        {"1018:1=12000000", "0010810026000100 8010800022000100", false, "FF",
         "SyncManager 1 had a mail of another master: FF\n"
         "dictionary: identity vendor id: expected 0x00000011 (EEPROM), found 0x00000012\n"
         "SyncManagers: mailbox to the slave: expected 128 bytes at 0x1000 (EEPROM), found 129 bytes at 0x1000\n"},
    };
    uint8_t image[0x1000];
    const ect_identity_t identity = {.vendor_id = 0x11, .product_code = 0x22, .revision = 0x33, .serial = 0x44};
    const int32_t size = ect_sii_write(&ect_fzm1, &identity, 0, image, sizeof image);
    assert_true(size > 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        compare(&rows[i], image, (size_t)size);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_are_separated_by_commas),
        cmocka_unit_test(the_comment_lists_the_blanked_parts),
        cmocka_unit_test(serial_number_and_alias_of_an_image_become_0),
        cmocka_unit_test(names_in_an_image_become_x),
        cmocka_unit_test(values_are_blanked_by_index_type_and_access),
        cmocka_unit_test(a_request_without_a_value_has_a_line_with_the_reason),
        cmocka_unit_test(an_entry_that_cannot_be_read_in_preop_has_a_line_with_its_access),
        cmocka_unit_test(the_comment_is_inserted_after_the_first_line),
        cmocka_unit_test(the_time_is_that_of_source_date_epoch),
        cmocka_unit_test(disagreements_of_eeprom_dictionary_and_syncmanagers_are_printed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
