/* SPDX-License-Identifier: MIT */
/* ESI files in all found forms: the content that is read, and the lines of refusals. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <libxml/parser.h>
#include <libxml/xmlmemory.h>

#include "esi/number.h"
#include "esi/read.h"
#include "esi/single.h"
#include "esi/types.h"
#include "od/od.h"

static void numbers(void **state)
{
    static const struct {
        const char *text;
        bool good;
        int64_t value;
    } table[] = {
        {"0", true, 0},
        {"42", true, 42},
        {"-7", true, -7},
        {"+7", true, 7},
        {"010", true, 10},
        {"#x1A00", true, 0x1A00},
        {"#X1a00", true, 0x1A00},
        {"0x1a00", true, 0x1A00},
        {"#xFFFFFFFF", true, 0xFFFFFFFF},
        {"18446744073709551615", true, -1},
        {"", false, 0},
        {"#x", false, 0},
        {"#x0x6041", false, 0},
        {"12a", false, 0},
        {"0x12 34", false, 0},
        {"1e3", false, 0},
        {"#x11112222333344445", false, 0},
        {"99999999999999999999", false, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        int64_t value = 0;
        bool good = ect_esi_parse_number(table[i].text, &value);
        if (good != table[i].good || (good && value != table[i].value))
            fail_msg("\"%s\": expected %s %lld, got %s %lld", table[i].text, table[i].good ? "the number" : "none",
                     (long long)table[i].value, good ? "the number" : "none", (long long)value);
    }
}

#define HEAD "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices>\n"
#define TAIL "</Devices></Descriptions></EtherCATInfo>"
#define DEVICE(content)                                                                                                \
    HEAD "<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='1'>A</Type>\n" content "</Device>" TAIL

/* Files that a reader must refuse, when it opens them or when it reads a device in full. */
static void refusals(void **state)
{
    static const struct {
        const char *what, *text, *expected;
    } table[] = {
        {"nothing", "", "f.xml:1: no well-formed XML"},
        {"no XML", "hello", "f.xml:1: no well-formed XML"},
        {"cut off", HEAD "<Device>", "f.xml:2: no well-formed XML"},
        {"another root", "<Other/>", "f.xml:1: no ESI file: the root is Other"},
        {"no device", HEAD TAIL, "there is no device in it"},
        {"no type", HEAD "<Device/>" TAIL, "f.xml:2: Device has no Type"},
        {"no vendor",
         "<EtherCATInfo><Descriptions><Devices><Device><Type>A</Type></Device></Devices></Descriptions></EtherCATInfo>",
         "there is no Vendor with an Id"},
        {"a DTD", "<!DOCTYPE EtherCATInfo><EtherCATInfo/>", "f.xml: has a document type definition"},
        {"an entity bomb",
         "<!DOCTYPE a [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;\">]>"
         "<EtherCATInfo>&c;</EtherCATInfo>",
         "f.xml: has a document type definition"},
        {"an external entity",
         "<!DOCTYPE a [<!ENTITY a SYSTEM \"file:///etc/passwd\">]><EtherCATInfo>&a;</EtherCATInfo>",
         "f.xml: has a document type definition"},
        {"an undefined entity", DEVICE("<Name>&a;</Name>"), "no well-formed XML"},
        {"a product code that is no number", HEAD "<Device><Type ProductCode='x'>A</Type></Device>" TAIL,
         "f.xml:2: ProductCode is \"x\", not a number"},
        {"a PDO without an index", DEVICE("<RxPdo/>"), "f.xml:3: RxPdo has no Index"},
        {"an entry without a length", DEVICE("<TxPdo><Index>#x1A00</Index>\n<Entry><Index>1</Index></Entry></TxPdo>"),
         "f.xml:4: Entry has no BitLen"},
        {"an index of 17 bits", DEVICE("<RxPdo><Index>#x10000</Index></RxPdo>"),
         "f.xml:3: Index is 65536, not 0 to 65535"},
        {"a sub-index of 256",
         DEVICE("<RxPdo><Index>1</Index><Entry><Index>1</Index><SubIndex>256</SubIndex></Entry></RxPdo>"),
         "SubIndex is 256, not 0 to 255"},
        {"hexadecimal bytes with a letter too many", DEVICE("<Eeprom><Data>01G2</Data></Eeprom>"),
         "Data has the character 'G'"},
        {"half a byte", DEVICE("<Eeprom><ConfigData>012</ConfigData></Eeprom>"),
         "ConfigData has an odd number of hexadecimal digits (3)"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[300] = "nothing was refused";
        ect_esi_t *esi = ect_esi_parse("f.xml", table[i].text, strlen(table[i].text), text, sizeof text);
        if (esi != NULL && ect_esi_select(esi, "", text, sizeof text) != NULL)
            strcpy(text, "nothing was refused");
        if (strstr(text, table[i].expected) == NULL)
            fail_msg("%s: expected \"%s\", got \"%s\"", table[i].what, table[i].expected, text);
        ect_esi_close(esi);
    }
}

/* Nesting costs a parser stack: it must end. */
static void deep_nesting(void **state)
{
    enum { DEPTH = 100000 };
    char *text = malloc(3 * DEPTH + 1);
    char message[300];
    (void)state;
    assert_non_null(text);
    for (size_t i = 0; i < DEPTH; i++)
        memcpy(text + 3 * i, "<a>", 3);
    text[3 * DEPTH] = '\0';
    assert_null(ect_esi_parse("deep.xml", text, 3 * DEPTH, message, sizeof message));
    if (strstr(message, "no well-formed XML") == NULL)
        fail_msg("expected a refusal as XML, got \"%s\"", message);
    free(text);
}

static void files(void **state)
{
    static const struct {
        const char *path, *expected;
    } table[] = {
        {ESI_FILES "/none.xml", "No such file"},
        {ESI_FILES, "not a file of at most"},
        {"/dev/zero", "not a file of at most"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[300] = "";
        assert_null(ect_esi_open(table[i].path, text, sizeof text));
        if (strstr(text, table[i].expected) == NULL)
            fail_msg("%s: expected \"%s\", got \"%s\"", table[i].path, table[i].expected, text);
    }
}

/* --- calls that fail ---------------------------------------------------------------------------------------------- */

static bool malloc_fails;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);

void *__wrap_malloc(size_t size)
{
    if (malloc_fails) {
        errno = ENOMEM;
        return NULL;
    }
    return __real_malloc(size);
}

static bool calloc_fails;

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

void *__wrap_calloc(size_t count, size_t size)
{
    return calloc_fails ? NULL : __real_calloc(count, size);
}

static size_t read_piece; /* most bytes of a read; 0: all */
static bool read_fails;

ssize_t __real_read(int file, void *bytes, size_t size);
ssize_t __wrap_read(int file, void *bytes, size_t size);

ssize_t __wrap_read(int file, void *bytes, size_t size)
{
    if (read_fails) {
        errno = EIO;
        return -1;
    }
    return __real_read(file, bytes, read_piece > 0 && size > read_piece ? read_piece : size);
}

static void file_in_pieces(void **state)
{
    static const size_t pieces[] = {1000, 4096, 0};
    (void)state;
    for (size_t i = 0; i < sizeof pieces / sizeof pieces[0]; i++) {
        char text[300] = "";
        read_piece = pieces[i];
        ect_esi_t *esi = ect_esi_open(ESI_FILES "/analog.xml", text, sizeof text);
        read_piece = 0;
        if (esi == NULL || ect_esi_select(esi, "AI2", text, sizeof text) == NULL)
            fail_msg("pieces of %zu bytes: %s", pieces[i], text);
        ect_esi_close(esi);
    }
}

static void file_that_cannot_be_read(void **state)
{
    char text[600] = "", expected[600];
    (void)state;
    read_fails = true;
    ect_esi_t *esi = ect_esi_open(ESI_FILES "/analog.xml", text, sizeof text);
    read_fails = false;
    (void)snprintf(expected, sizeof expected, "%s: %s", ESI_FILES "/analog.xml", strerror(EIO));
    assert_null(esi);
    assert_string_equal(text, expected);
}

static void *no_malloc(size_t size)
{
    (void)size;
    return NULL;
}

static void file_without_memory(void **state)
{
    char text[600] = "", expected[600];
    (void)state;
    malloc_fails = true;
    ect_esi_t *esi = ect_esi_open(ESI_FILES "/analog.xml", text, sizeof text);
    malloc_fails = false;
    (void)snprintf(expected, sizeof expected, "%s: %s", ESI_FILES "/analog.xml", strerror(ENOMEM));
    assert_null(esi);
    assert_string_equal(text, expected);
}

/* A file in memory, and a device that no file describes. */
static void no_memory_for_a_device(void **state)
{
    static const char file[] = DEVICE("<Name>A</Name>");
    char texts[2][300] = {"", ""};
    (void)state;
    calloc_fails = true;
    ect_esi_t *read = ect_esi_parse("f.xml", file, strlen(file), texts[0], sizeof texts[0]);
    ect_esi_t *single = ect_esi_single_begin("f.xml", texts[1], sizeof texts[1]);
    calloc_fails = false;
    assert_null(read);
    assert_null(single);
    for (size_t i = 0; i < 2; i++)
        assert_string_equal(texts[i], "f.xml: no memory left");
}

/* Bytes in memory that no parser gets: too many, none, or no memory for the parser. */
static void unparsed_bytes(void **state)
{
    static const struct {
        const char *data;
        size_t length;
        bool no_memory;
        const char *expected;
    } table[] = {
        {"<a/>", (size_t)64 * 1024 * 1024 + 1, false, "f.xml: larger than 64 MiB"},
        {NULL, 0, false, "no well-formed XML"},
        {"<a/>", 4, true, "f.xml: no memory left"},
    };
    (void)state;
    xmlInitParser();
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[300] = "";
        if (table[i].no_memory)
            assert_int_equal(xmlMemSetup(free, no_malloc, realloc, strdup), 0);
        ect_esi_t *esi = ect_esi_parse("f.xml", table[i].data, table[i].length, text, sizeof text);
        assert_int_equal(xmlMemSetup(free, malloc, realloc, strdup), 0);
        assert_null(esi);
        if (strstr(text, table[i].expected) == NULL)
            fail_msg("expected \"%s\", got \"%s\"", table[i].expected, text);
    }
}

/* A sparse file costs no disk. */
static void large_file(void **state)
{
    char path[] = "/tmp/ectwin-esi-XXXXXX", text[300] = "";
    (void)state;
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(ftruncate(file, (off_t)64 * 1024 * 1024 + 1), 0);
    assert_int_equal(close(file), 0);
    ect_esi_t *esi = ect_esi_open(path, text, sizeof text);
    assert_int_equal(unlink(path), 0);
    assert_null(esi);
    assert_non_null(strstr(text, ": not a file of at most 64 MiB"));
}

/* Carriage returns, too, are blanks: a text is one line. */
static void blanks(void **state)
{
    char text[300] = "";
    static const char file[] = DEVICE("<Name>&#13;A&#13;&#10;\tB \n</Name>");
    (void)state;
    ect_esi_t *esi = ect_esi_parse("f.xml", file, strlen(file), text, sizeof text);
    assert_non_null(esi);
    const ect_esi_device_t *device = ect_esi_select(esi, "", text, sizeof text);
    assert_non_null(device);
    assert_string_equal(device->name, "A   B");
    ect_esi_close(esi);
}

/* A message never exceeds the room for it, also when the place of the mistake fills it. */
static void little_room(void **state)
{
    static const char file[] = HEAD "<Device/>" TAIL;
    char text[12] = "";
    (void)state;
    assert_null(ect_esi_parse("f.xml", file, strlen(file), text, 8));
    assert_string_equal(text, "f.xml:2");
}

static void selectors(void **state)
{
    static const struct {
        const char *selector, *type;
        uint32_t revision;
        const char *refusal;
    } table[] = {
        {"DI4", "DI4", 0x00020000, NULL},
        {"@0x1004", "DI4", 0x00020000, NULL},
        {"@4100", "DI4", 0x00020000, NULL},
        {"@#x1004/#x10000", "DI4", 0x00010000, NULL},
        {"@0x3001/1", "COUPLER", 1, NULL},
        {"", NULL, 0, "DI4 and DO16 both fit"},
        {"DI5", NULL, 0, "no device \"DI5\" in it"},
        {"@0x1004/3", NULL, 0, "no device"},
        {"@x", NULL, 0, "is not TYPE, @PRODUCT or @PRODUCT/REVISION"},
        {"@", NULL, 0, "is not TYPE"},
        {"@1/", NULL, 0, "is not TYPE"},
    };
    char text[300] = "";
    (void)state;
    ect_esi_t *esi = ect_esi_open(ESI_FILES "/digital.xml", text, sizeof text);
    assert_non_null(esi);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const ect_esi_device_t *device = ect_esi_select(esi, table[i].selector, text, sizeof text);
        if (table[i].refusal != NULL && (device != NULL || strstr(text, table[i].refusal) == NULL))
            fail_msg("\"%s\": expected a refusal with \"%s\", got %s", table[i].selector, table[i].refusal,
                     device != NULL ? device->type : text);
        if (table[i].refusal == NULL &&
            (device == NULL || strcmp(device->type, table[i].type) != 0 || device->revision != table[i].revision))
            fail_msg("\"%s\": expected %s revision %08X, got %s %08X", table[i].selector, table[i].type,
                     (unsigned int)table[i].revision, device != NULL ? device->type : text,
                     device != NULL ? (unsigned int)device->revision : 0u);
    }
    ect_esi_close(esi);
}

static void model(void **state)
{
    char text[300] = "";
    (void)state;
    ect_esi_t *esi = ect_esi_open(ESI_FILES "/analog.xml", text, sizeof text);
    assert_non_null(esi);
    const ect_esi_device_t *d = ect_esi_select(esi, "AI2", text, sizeof text);
    assert_non_null(d);
    assert_int_equal(d->vendor_id, 0x0E57);
    assert_string_equal(d->vendor_name, "Example Works");
    assert_string_equal(d->group_name, "Analog terminals");
    assert_int_equal(d->preop_ms, 2000);
    assert_int_equal(d->response_ms, 2000);
    assert_int_equal(d->sm_count, 4);
    assert_int_equal(d->sms[0].maximum, 256);
    assert_string_equal(d->fmmus[2], "MBoxState");
    assert_int_equal(d->pdo_count, 4);
    assert_false(d->pdos[0].tx);
    assert_int_equal(d->pdos[1].exclude[0].index, 0x1A01);
    assert_int_equal(d->pdos[2].sm, -1);
    assert_true(d->mailbox.coe && d->mailbox.foe && !d->mailbox.eoe);
    assert_true(d->mailbox.pdo_assign && !d->mailbox.pdo_config && d->mailbox.complete_access);
    assert_int_equal(d->mailbox.init_count, 1);
    assert_string_equal(d->mailbox.inits[0].transitions, "PS");
    assert_int_equal(d->dc_count, 2);
    assert_int_equal(d->dcs[1].assign_activate, 0x700);
    assert_int_equal(d->dcs[1].shift_sync1_ns, 100000);
    assert_int_equal(d->eeprom_size, 2048);
    assert_int_equal(d->bootstrap.length, 8);
    assert_int_equal(d->dictionary.object_count, 4);
    ect_esi_close(esi);
}

static void types(void **state)
{
    static const struct {
        const char *name;
        uint32_t bits;
        bool good;
        uint16_t code;
        uint32_t expected;
    } table[] = {
        {"BOOL", 0, true, ECT_TYPE_BOOLEAN, 1},
        {"BIT2", 0, true, ECT_TYPE_BIT1 + 1, 2},
        {"INT", 16, true, ECT_TYPE_INTEGER16, 16},
        {"REAL", 0, true, ECT_TYPE_REAL32, 32},
        {"STRING(20)", 0, true, ECT_TYPE_VISIBLE_STRING, 160},
        {"ARRAY [0..3] OF UINT", 0, true, ECT_TYPE_OCTET_STRING, 64},
        {"DT0800EN03", 0, true, ECT_TYPE_BIT1 + 2, 3},
        {"USINT", 4, true, ECT_TYPE_BIT1 + 3, 4},
        {"INT24", 24, true, ECT_TYPE_OCTET_STRING, 24},
        {"", 16, true, ECT_TYPE_UNSIGNED16, 16},
        {"DT8000", 0, false, 0, 0},
        {"UNKNOWN", 0, false, 0, 0},
    };
    char text[300] = "";
    (void)state;
    ect_esi_t *esi = ect_esi_open(ESI_FILES "/analog.xml", text, sizeof text);
    assert_non_null(esi);
    const ect_esi_device_t *d = ect_esi_select(esi, "AI2", text, sizeof text);
    assert_non_null(d);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_basic_t basic;
        bool good = ect_esi_resolve(&d->dictionary, table[i].name, table[i].bits, &basic);
        if (good != table[i].good || (good && (basic.code != table[i].code || basic.bits != table[i].expected)))
            fail_msg("%s with %u bits: expected %d, type %02X, %u bits, got %d, %02X, %u", table[i].name,
                     (unsigned int)table[i].bits, table[i].good, table[i].code, (unsigned int)table[i].expected, good,
                     basic.code, (unsigned int)basic.bits);
    }
    ect_esi_close(esi);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"numbers: decimal, #x and 0x; nothing else", numbers, NULL, NULL, NULL},
        {"bad XML, a contradiction, an attack: refused with file, line and error", refusals, NULL, NULL, NULL},
        {"100000 levels of elements are refused", deep_nesting, NULL, NULL, NULL},
        {"An unreadable file is refused", files, NULL, NULL, NULL},
        {"a file is read in pieces of any size", file_in_pieces, NULL, NULL, NULL},
        {"a file that cannot be read gives one line with the reason", file_that_cannot_be_read, NULL, NULL, NULL},
        {"a file for which there is no memory is refused with the reason", file_without_memory, NULL, NULL, NULL},
        {"a device for which there is no memory is refused with the reason", no_memory_for_a_device, NULL, NULL, NULL},
        {"bytes that no parser gets are refused", unparsed_bytes, NULL, NULL, NULL},
        {"a file of more than 64 MiB is refused", large_file, NULL, NULL, NULL},
        {"a text is one line without blanks at its ends", blanks, NULL, NULL, NULL},
        {"a message is cut at its room", little_room, NULL, NULL, NULL},
        {"a device is selected by type, product, revision; of several revisions the newest", selectors, NULL, NULL,
         NULL},
        {"all that a file has of a device is in its model", model, NULL, NULL, NULL},
        {"names of types: IEC 61131, enumerations, lengths that do not fit their name", types, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
