/* SPDX-License-Identifier: MIT */
/*
 * ESI files written by this project: reading them returns their content. tests/check/esi.py checks their order
 * and their references.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <libxml/parser.h>
#include <libxml/xmlerror.h>
#include <libxml/xmlmemory.h>

#include "bus/chain/catalogue.h"
#include "esi/twin.h"
#include "esi/values.h"
#include "esi/write.h"
#include "sii/sii.h"
#include "support/wire.h"

#include "from_text.h"

static const char *write_one(ect_arena_t *arena, const ect_device_t *device, const ect_identity_t *identity)
{
    char text[200];
    size_t length;
    const char *file =
        ect_esi_write(arena, &(ect_esi_part_t){.device = device, .identity = identity}, 1, &length, text, sizeof text);
    if (file == NULL)
        fail_msg("%s: %s", device->name, text);
    assert_int_equal(strlen(file), length);
    return file;
}

static ect_esi_twin_t *read_back(const char *file)
{
    char path[] = "/tmp/ectwin-esi-XXXXXX";
    char text[400];
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, file, strlen(file)), (long)strlen(file));
    close(fd);
    ect_esi_twin_t *twin = ect_esi_twin_make(path, "", NULL, 0, text, sizeof text);
    unlink(path);
    if (twin == NULL)
        fail_msg("the written file is refused: %s", text);
    return twin;
}

/* The first line in which two files differ. */
static void expect_same_text(const char *device, const char *expected, const char *got)
{
    for (unsigned int line = 1; *expected != '\0' || *got != '\0'; line++) {
        size_t a = strcspn(expected, "\n");
        size_t b = strcspn(got, "\n");
        if (a != b || memcmp(expected, got, a) != 0)
            fail_msg("%s, line %u: expected %.*s, got %.*s", device, line, (int)a, expected, (int)b, got);
        expected += a + (expected[a] != '\0');
        got += b + (got[b] != '\0');
    }
}

static void expect_same_sii(const ect_device_t *device, const ect_device_t *again, const ect_identity_t *identity)
{
    uint8_t *one = malloc(device->sii_size), *other = malloc(device->sii_size);
    assert_non_null(one);
    assert_non_null(other);
    if (again->sii_size != device->sii_size)
        fail_msg("%s: expected an SII of %u bytes, got %u", device->name, device->sii_size, again->sii_size);
    assert_int_equal(ect_sii_write(device, identity, 0, one, device->sii_size), device->sii_size);
    assert_int_equal(ect_sii_write(again, identity, 0, other, device->sii_size), device->sii_size);
    for (unsigned int i = 0; i < device->sii_size; i++) {
        if (one[i] != other[i])
            fail_msg("%s: SII byte 0x%X: expected %02X, got %02X", device->name, i, one[i], other[i]);
    }
    free(one);
    free(other);
}

static void expect_same_layout(const ect_device_t *device, const ect_device_t *again)
{
    assert_int_equal(again->sm_count, device->sm_count);
    for (unsigned int i = 0; i < device->sm_count; i++) {
        if (ect_device_sm_bytes(again, i) != ect_device_sm_bytes(device, i))
            fail_msg("%s: SyncManager %u: expected %u bytes, got %u", device->name, i, ect_device_sm_bytes(device, i),
                     ect_device_sm_bytes(again, i));
        assert_int_equal(again->sm[i].start, device->sm[i].start);
        assert_int_equal(again->sm[i].control, device->sm[i].control);
        assert_int_equal(again->sm[i].type, device->sm[i].type);
    }
    assert_int_equal(again->fmmu_count, device->fmmu_count);
    assert_memory_equal(again->fmmu, device->fmmu, sizeof device->fmmu);
    assert_memory_equal(&again->timeouts.preop_ms, &device->timeouts.preop_ms, 4 * sizeof(uint16_t));
}

static void expect_same_entry(const ect_device_t *device, const ect_object_t *object, const ect_entry_t *a,
                              const ect_entry_t *b)
{
    ect_od_t od = ect_device_od(device, NULL);
    uint16_t bits = ect_od_bits(&od, a);
    if (b == NULL || b->data_type != a->data_type || b->bit_length != bits ||
        ((a->access ^ b->access) & ECT_ACCESS_WIRE) != 0 || strcmp(a->name, b->name) != 0)
        fail_msg("%s %04X:%u: expected type %X, %u bits, access %03X, \"%s\", got %X, %u, %03X, \"%s\"", device->name,
                 object->index, a->subindex, a->data_type, bits, a->access & ECT_ACCESS_WIRE, a->name,
                 b != NULL ? b->data_type : 0u, b != NULL ? b->bit_length : 0u,
                 b != NULL ? b->access & ECT_ACCESS_WIRE : 0u, b != NULL ? b->name : "no entry");
}

static void expect_same_dictionary(const ect_device_t *device, const ect_device_t *again)
{
    ect_od_t od = ect_device_od(again, NULL);
    if (again->object_count != device->object_count)
        fail_msg("%s: expected %u objects, got %u", device->name, device->object_count, again->object_count);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        const ect_object_t *other = ect_od_find(&od, object->index);
        if (other == NULL || strcmp(other->name, object->name) != 0 || other->max_subindex != object->max_subindex)
            fail_msg("%s: object %04X \"%s\" up to :%u is missing after the reading", device->name, object->index,
                     object->name, object->max_subindex);
        for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e))
            expect_same_entry(device, object, e, ect_od_entry(other, (uint8_t)e->subindex));
    }
}

/* Each type is defined once, however many entries have it. */
static void expect_types_once(const char *device, const char *file)
{
    static const char begin[] = "<DataType>\n";
    for (const char *at = strstr(file, begin); at != NULL; at = strstr(at + 1, begin)) {
        const char *name = strstr(at, "<Name>");
        for (const char *next = strstr(at + 1, begin); next != NULL; next = strstr(next + 1, begin)) {
            const char *other = strstr(next, "<Name>");
            const size_t length = (size_t)(strstr(name, "</Name>") + strlen("</Name>") - name);
            if (strncmp(name, other, length) == 0)
                fail_msg("%s: %.*s is defined twice", device, (int)length, name);
        }
    }
}

static void round_trip(const ect_device_t *device, bool dictionary)
{
    ect_arena_t arena = {0};
    const ect_identity_t identity = {0xE57, device->identity.product_code, device->identity.revision, 77};
    const char *file = write_one(&arena, device, &identity);
    expect_types_once(device->name, file);
    ect_esi_twin_t *twin = read_back(file);
    const ect_device_t *again = ect_esi_twin_product(twin)->device;
    assert_int_equal(again->identity.vendor_id, identity.vendor_id);
    assert_int_equal(again->identity.product_code, identity.product_code);
    assert_int_equal(again->identity.revision, identity.revision);
    expect_same_layout(device, again);
    if (dictionary)
        expect_same_dictionary(device, again);
    expect_same_sii(device, again, &identity);
    expect_same_text(device->name, file, write_one(&arena, again, &identity));
    ect_esi_twin_free(twin);
    ect_arena_free(&arena);
}

static void catalogue(void **state)
{
    const ect_product_t *product;
    (void)state;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++)
        round_trip(product->device, true);
}

static void foreign(void **state)
{
    static const struct {
        const char *file, *selector;
    } table[] = {
        {"digital.xml", "DI4"}, {"digital.xml", "DO16"}, {"digital.xml", "COUPLER"},
        {"analog.xml", "AI2"},  {"analog.xml", "DRIVE"}, {"modular.xml", "RACK"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char path[300], text[400];
        (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, table[i].file);
        ect_esi_twin_t *twin = ect_esi_twin_make(path, table[i].selector, NULL, 0, text, sizeof text);
        if (twin == NULL)
            fail_msg("%s", text);
        const ect_device_t *device = ect_esi_twin_product(twin)->device;
        round_trip(device, (device->mailbox_protocols & ECT_MAILBOX_COE) != 0);
        ect_esi_twin_free(twin);
    }
}

static void overrides(void **state)
{
    static const char *const wanted[] = {"<Id>#x11223344</Id>",
                                         "ProductCode=\"#x55667788\"",
                                         "RevisionNo=\"#x00010002\"",
                                         "SerialNo=\"#x00000009\"",
                                         "<DefaultData>44332211</DefaultData>",
                                         "<DefaultData>88776655</DefaultData>",
                                         "<DefaultData>02000100</DefaultData>",
                                         "<DefaultData>09000000</DefaultData>"};
    static const ect_identity_t identity = {0x11223344, 0x55667788, 0x00010002, 9};
    ect_arena_t arena = {0};
    (void)state;
    const char *file = write_one(&arena, ect_catalogue_find("fzm1")->device, &identity);
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
        if (strstr(file, wanted[i]) == NULL)
            fail_msg("the file does not have %s", wanted[i]);
    }
    ect_arena_free(&arena);
}

/* A file that no tool could read right is not written. */
static void refusals(void **state)
{
    static const ect_identity_t one = {1, 2, 3, 0}, other_vendor = {9, 2, 4, 0}, other_revision = {1, 2, 4, 0};
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    const struct {
        const ect_identity_t *second;
        const char *why;
    } table[] = {
        {&one, "FZM1 and FZM1 both have product code 0x00000002 and revision 0x00000003: no tool can distinguish them"},
        {&other_vendor, "FZM1 and FZM1 have different vendors: a file has one"},
        {&other_revision, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const ect_esi_part_t parts[] = {{.device = device, .identity = &one},
                                        {.device = device, .identity = table[i].second}};
        ect_arena_t arena = {0};
        char text[200] = "";
        size_t length;
        const char *file = ect_esi_write(&arena, parts, 2, &length, text, sizeof text);
        assert_true((file != NULL) == (table[i].why == NULL));
        if (table[i].why != NULL)
            assert_string_equal(text, table[i].why);
        ect_arena_free(&arena);
    }
}

static void expect_in(const char *file, const char *wanted)
{
    if (strstr(file, wanted) == NULL)
        fail_msg("the file does not have %s", wanted);
}

/* Names of the plant: EnumInfo for values, a comment for bits; entries keep their types. */
static void names_of_bits_and_values(void **state)
{
    const ect_product_t *product = ect_catalogue_find("fzm1");
    ect_esi_part_t part = {.device = product->device, .plant = product->plant};
    ect_arena_t arena = {0};
    char text[200];
    size_t length;
    (void)state;
    const char *file = ect_esi_write(&arena, &part, 1, &length, text, sizeof text);
    expect_in(file, "<Name>DT2400EN01</Name>");
    expect_in(file, "<Text>Handshaking</Text>");
    expect_in(file, "<Type>DT2100EN02</Type>");
    expect_in(file, "<Enum>4294967295</Enum>");
    expect_in(file, "bit 2 READY: ");
    assert_null(strstr(file, "<Name>DT2200EN02</Name>")); /* the codes of 2100h:2 once more */
    ect_esi_twin_t *twin = read_back(file);
    const ect_device_t *again = ect_esi_twin_product(twin)->device;
    expect_same_sii(product->device, again, &product->device->identity);
    const ect_od_t od = ect_device_od(again, NULL);
    const ect_entry_t *entry = ect_od_entry(ect_od_find(&od, 0x2400), 1);
    assert_int_equal(entry->data_type, ECT_TYPE_UNSIGNED8);
    assert_int_equal(ect_od_detail(&od, 0x2400, 1)->maximum, 1);
    ect_esi_twin_free(twin);
    ect_arena_free(&arena);
}

/* The cycle of the bus, whatever it is, reaches 60C2h of a drive before SAFEOP. */
static void init_commands(void **state)
{
    static const char *const want[] = {"<InitCmd>",
                                       "<Transition>PS</Transition>",
                                       "<Index>#x60C2</Index>",
                                       "<SubIndex>1</SubIndex>",
                                       "<Data AdaptAutomatically=\"true\">01</Data>",
                                       "<SubIndex>2</SubIndex>",
                                       "<Data AdaptAutomatically=\"true\">FD</Data>"};
    ect_arena_t arena = {0};
    (void)state;
    const char *drive = write_one(&arena, ect_catalogue_find("pmctendo-dd5")->device, NULL);
    for (size_t i = 0; i < sizeof want / sizeof want[0]; i++)
        expect_in(drive, want[i]);
    ect_arena_free(&arena);
}

/* SYNC0 that follows the bus, and a unit for each value that ETG.1004 can name. */
static void what_tools_look_for(void **state)
{
    ect_arena_t arena = {0};
    (void)state;
    expect_in(write_one(&arena, ect_catalogue_find("fzm1")->device, NULL),
              "<CycleTimeSync0 Factor=\"1\">0</CycleTimeSync0>");
    const char *sensor = write_one(&arena, ect_catalogue_find("optoncdt2300")->device, NULL);
    expect_in(sensor, "<Unit>#xF7010000</Unit>");
    expect_in(sensor, "<Unit>#xFD010000</Unit>");
    const char *drive = write_one(&arena, ect_catalogue_find("pmctendo-dd5")->device, NULL);
    expect_in(drive, "<Unit>#x00B50000</Unit>"); /* counts, a second, a second squared */
    expect_in(drive, "<Unit>#x00B50300</Unit>");
    expect_in(drive, "<Unit>#x00B55700</Unit>");
    ect_arena_free(&arena);
}

/* Device type, identity and types of the SyncManagers are mandatory (ETG.1000.6 5.6.7), other objects optional. */
static void categories_of_objects(void **state)
{
    static const char *const mandatory[] = {"1000", "1018", "1C00"};
    ect_arena_t arena = {0};
    unsigned int found = 0;
    (void)state;
    const char *file = write_one(&arena, ect_catalogue_find("fzm1")->device, NULL);
    const char *object = strstr(strstr(file, "<Objects>"), "<Object>");
    while (object != NULL) {
        const char *next = strstr(object + 1, "<Object>");
        const char *index = strstr(object, "<Index>#x") + strlen("<Index>#x");
        const char *category = strstr(object, "<Category>") + strlen("<Category>");
        bool must = false;
        for (size_t i = 0; i < sizeof mandatory / sizeof mandatory[0]; i++)
            must = must || strncmp(index, mandatory[i], 4) == 0;
        if (*category != (must ? 'm' : 'o'))
            fail_msg("%.4s: category %c", index, *category);
        found += must;
        object = next;
    }
    assert_int_equal(found, 3);
    ect_arena_free(&arena);
}

/* Modules are copied unchanged from their file. */
static void copied_modules(void **state)
{
    static const char file[] =
        ESI_HEAD "<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>DEV</Type>"
                 "<Name>A device</Name>" ESI_MAILBOX_SMS ESI_PROCESS_SMS
                 "<Mailbox><CoE/></Mailbox><Slots><Slot><Name>S</Name><ModuleIdent>1</ModuleIdent>"
                 "</Slot></Slots></Device></Devices><Modules><Module "
                 "xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:nil='true' a='&lt;b&gt;' b=''>"
                 "<!-- left out --><Type ModuleIdent='1'>M</Type><Name><![CDATA[A & B]]></Name></Module></Modules>"
                 "</Descriptions></EtherCATInfo>";
    ect_arena_t arena = {0};
    char text[200];
    size_t length;
    (void)state;
    made_t m = make_text("modules", file);
    const ect_esi_part_t part = {.device = device_of(&m), .twin = m.twin};
    const char *written = ect_esi_write(&arena, &part, 1, &length, text, sizeof text);
    assert_non_null(written);
    expect_in(written, "<Module xsi:nil=\"true\" a=\"&lt;b&gt;\" b=\"\">");
    assert_null(strstr(written, "left out"));
    expect_in(written, "<Type ModuleIdent=\"1\">M</Type>");
    expect_in(written, "<Name><![CDATA[A & B]]></Name>");
    ect_arena_free(&arena);
    free_made(&m);
}

/* The written file of a device with one object, 4100h. */
#define WITH_OBJECT(type, content)                                                                                     \
    ESI_DEVICE("<Profile><ProfileNo>5001</ProfileNo><Dictionary><DataTypes><DataType><Name>UINT</Name>"                \
               "<BitSize>16</BitSize></DataType><DataType><Name>STRING(3)</Name><BitSize>24</BitSize></DataType>"      \
               "</DataTypes><Objects><Object><Index>#x4100</Index><Name>Object</Name><Type>" type content              \
               "</Object></Objects></Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                            \
               "<Mailbox><CoE SdoInfo='1'/></Mailbox>" ESI_EEPROM)
#define WITH_PROPERTIES(properties)                                                                                    \
    WITH_OBJECT("UINT</Type><BitSize>16</BitSize><Flags><Access>rw</Access></Flags>",                                  \
                "<Properties>" properties "</Properties>")
#define WITH_TEXT(bytes)                                                                                               \
    WITH_OBJECT("STRING(3)</Type><BitSize>24</BitSize><Info><DefaultData>" bytes "</DefaultData></Info>",              \
                "<Flags><Access>ro</Access></Flags>")
#define PROPERTY(name, value) "<Property><Name>" name "</Name><Value>" value "</Value></Property>"

/* SDO information that differs from use is written; a text with blanks at its ends is written as bytes. */
static void what_an_object_needs(void **state)
{
    static const struct {
        const char *what, *file, *wanted, *absent;
    } rows[] = {
        {"read only", WITH_PROPERTIES(PROPERTY("SdoInfoAccess", "#x0007")), "<Value>#x0007</Value>", "SdoInfoBits"},
        {"8 bits", WITH_PROPERTIES(PROPERTY("SdoInfoBits", "#x0008")), "<Value>#x0008</Value>", "SdoInfoAccess"},
        {"both the same", WITH_PROPERTIES(PROPERTY("SdoInfoAccess", "#x003F") PROPERTY("SdoInfoBits", "#x0010")),
         "<Index>#x4100</Index>", "<Properties>"},
        {"a text", WITH_TEXT("414243"), "<DefaultString>ABC</DefaultString>", "<DefaultData>414243"},
        {"a blank in front", WITH_TEXT("204243"), "<DefaultData>204243</DefaultData>", "<DefaultString> BC"},
        {"a blank behind", WITH_TEXT("414220"), "<DefaultData>414220</DefaultData>", "<DefaultString>AB"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_arena_t arena = {0};
        char text[200];
        size_t length;
        made_t m = make_text(rows[i].what, rows[i].file);
        const ect_esi_part_t part = {.device = device_of(&m), .twin = m.twin};
        const char *file = ect_esi_write(&arena, &part, 1, &length, text, sizeof text);
        assert_non_null(file);
        if (strstr(file, rows[i].wanted) == NULL || strstr(file, rows[i].absent) != NULL)
            fail_msg("%s: expected %s and no %s", rows[i].what, rows[i].wanted, rows[i].absent);
        ect_arena_free(&arena);
        free_made(&m);
    }
}

/* A single value without a name of its own has that of its object. */
static void unnamed_values(void **state)
{
    enum { OBJECTS = 400 };
    static ect_object_t objects[OBJECTS];
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    ect_device_t other = *device;
    unsigned int changed = 0;
    (void)state;
    assert_in_range(device->object_count, 1, OBJECTS);
    memcpy(objects, device->objects, device->object_count * sizeof *objects);
    other.objects = objects;
    for (unsigned int i = 0; i < device->object_count; i++) {
        ect_arena_t arena = {0};
        if (objects[i].object_code != ECT_OBJECT_VAR || strcmp(objects[i].entries->name, objects[i].name) != 0)
            continue;
        ect_entry_t unnamed = *objects[i].entries;
        unnamed.name = NULL;
        objects[i].entries = &unnamed;
        expect_same_text(device->name, write_one(&arena, device, NULL), write_one(&arena, &other, NULL));
        objects[i] = device->objects[i];
        changed++;
        ect_arena_free(&arena);
    }
    assert_true(changed > 0);
}

/* --- a lack of memory ----------------------------------------------------------------------------------------------
 */

static unsigned int allocations; /* that succeed */

static bool is_left(void)
{
    if (allocations == 0)
        return false;
    allocations--;
    return true;
}

static void *limited_malloc(size_t size)
{
    return is_left() ? malloc(size) : NULL;
}

static void *limited_realloc(void *memory, size_t size)
{
    return is_left() ? realloc(memory, size) : NULL;
}

static char *limited_strdup(const char *text)
{
    return is_left() ? strdup(text) : NULL;
}

static void silent(void *ctx, const char *format, ...)
{
    (void)ctx;
    (void)format;
}

/* Whichever allocation of the XML writer is the last one: no part of a file is left. */
static void no_memory(void **state)
{
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    const ect_esi_part_t part = {.device = device};
    (void)state;
    xmlInitParser();
    xmlSetGenericErrorFunc(NULL, silent);
    for (unsigned int left = 0; left < 12; left++) {
        ect_arena_t arena = {0};
        char text[200] = "";
        size_t length;
        allocations = left;
        assert_int_equal(xmlMemSetup(free, limited_malloc, limited_realloc, limited_strdup), 0);
        const char *file = ect_esi_write(&arena, &part, 1, &length, text, sizeof text);
        assert_int_equal(xmlMemSetup(free, malloc, realloc, strdup), 0);
        assert_null(file);
        assert_string_equal(text, "the file could not be written: no memory left");
        ect_arena_free(&arena);
    }
    xmlSetGenericErrorFunc(NULL, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-057 CF-060 CF-061 CF-062 CF-077 the ESI of each device, read back: the same sizes, dictionary, SII, file",
         catalogue, NULL, NULL, NULL},
        {"the ESI of a device that came from an ESI: the same", foreign, NULL, NULL, NULL},
        {"CF-057 identity overrides reach vendor, type and 1018h", overrides, NULL, NULL, NULL},
        {"names of bits and values become types with EnumInfo and comments", names_of_bits_and_values, NULL, NULL,
         NULL},
        {"modules are copied whole: attributes with their prefixes, texts", copied_modules, NULL, NULL, NULL},
        {"CF-077 mandatory objects have category m, others o", categories_of_objects, NULL, NULL, NULL},
        {"DRV-100 InitCmd for 60C2h of a drive adapts to the cycle of the bus", init_commands, NULL, NULL, NULL},
        {"DRV-100 FZM-075 OPT-012 SYNC0 follows the bus cycle; values of sensor and drive have units",
         what_tools_look_for, NULL, NULL, NULL},
        {"SDO information that differs from use becomes properties; texts that XML would change become bytes",
         what_an_object_needs, NULL, NULL, NULL},
        {"an unnamed value has the name of its object", unnamed_values, NULL, NULL, NULL},
        {"without memory for XML there is no file", no_memory, NULL, NULL, NULL},
        {"CF-063 devices that a file cannot have together are refused", refusals, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
