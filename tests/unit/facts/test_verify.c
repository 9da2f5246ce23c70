/* SPDX-License-Identifier: MIT */
/* Findings of `ectwin verify`: none between sources of one device, and each of 59 changes by its name. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/catalogue.h"
#include "esi/twin.h"
#include "facts/facts.h"
#include "sii/sii.h"
#include "sii_file.h"
#include "wire/bytes.h"

/* --- ESI --------------------------------------------------------------------------------------------------------- */

static char *load(const char *file)
{
    char path[300];
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, file);
    FILE *stream = fopen(path, "rb");
    assert_non_null(stream);
    char *text = calloc(1, 100000);
    assert_non_null(text);
    assert_true(fread(text, 1, 99999, stream) > 0);
    (void)fclose(stream);
    return text;
}

/* The file with `change` in place of `text` at its first place behind `after`. */
static char *changed(const char *file, const char *after, const char *text, const char *change)
{
    char *original = load(file);
    char *from = strstr(original, after);
    char *at = from != NULL ? strstr(from, text) : NULL;
    if (at == NULL)
        fail_msg("%s: there is no \"%s\" behind \"%s\"", file, text, after);
    char *result = calloc(1, strlen(original) + strlen(change) + 1);
    assert_non_null(result);
    (void)sprintf(result, "%.*s%s%s", (int)(at - original), original, change, at + strlen(text));
    free(original);
    return result;
}

/* Facts of a file's device; they outlive the twin that they come from. */
static void facts_of_text(ect_facts_t *facts, const char *text, const char *selector)
{
    char message[300] = "";
    ect_esi_t *esi = ect_esi_parse("changed.xml", text, strlen(text), message, sizeof message);
    const ect_esi_device_t *model = esi != NULL ? ect_esi_select(esi, selector, message, sizeof message) : NULL;
    ect_esi_twin_t *twin = model != NULL ? ect_esi_twin_of(esi, model, NULL, 0, message, sizeof message) : NULL;
    if (twin == NULL)
        fail_msg("%s: expected a twin, got: %s", selector, message);
    ect_facts_of_esi(facts, ect_esi_twin_product(twin)->device, model);
    ect_esi_twin_free(twin);
    ect_esi_close(esi);
}

/* The lines that a comparison of two sources prints, to be freed. */
static char *lines_of(const ect_facts_t *expected, const ect_facts_t *found)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    ect_facts_t known = {.source = expected->source};
    assert_int_equal(ect_facts_compare(&known, expected, out), 0);
    size_t lines = ect_facts_compare(&known, found, out);
    (void)fclose(out);
    ect_facts_free(&known);
    size_t ends = 0;
    for (const char *c = text; *c != '\0'; c++)
        ends += *c == '\n';
    assert_int_equal(lines, ends);
    return text;
}

static void expect_line(const char *what, const char *lines, const char *line)
{
    char whole[300];
    (void)snprintf(whole, sizeof whole, "%s\n", line);
    if (*line == '\0' ? *lines != '\0' : strcmp(lines, whole) != 0)
        fail_msg("%s\n  expected: %s\n  got:      %s", what, line, lines);
}

static void esi_mutations(void **state)
{
    static const struct {
        const char *file, *selector, *after, *text, *change;
        const char *line; /* a single one */
    } table[] = {
        {"analog.xml", "AI2", "<Vendor", "00000E57", "00000E58",
         "identity vendor id: expected 0x00000E57 (old), found 0x00000E58"},
        {"analog.xml", "AI2", "<Vendor", "Example Works", "Example Work",
         "device vendor's name: expected \"Example Works\" (old), found \"Example Work\""},
        {"analog.xml", "AI2", "<Device ", "00003102", "00003103",
         "identity product code: expected 0x00003102 (old), found 0x00003103"},
        {"analog.xml", "AI2", "<Device ", "00010000", "00020000",
         "identity revision: expected 0x00010000 (old), found 0x00020000"},
        {"analog.xml", "AI2", "<Device ", "Physics=\"KK", "Physics=\"YK",
         "device ports: expected \"KK\" (old), found \"YK\""},
        {"analog.xml", "AI2", "<Device ", "2 inputs", "3 inputs",
         "device name: expected \"AI2 2 inputs and an output\" (old), found \"AI2 3 inputs and an output\""},
        {"analog.xml", "AI2", "<Groups", "Analog terminals", "Analogue",
         "device group's name: expected \"Analog terminals\" (old), found \"Analogue\""},
        {"analog.xml", "AI2", "<Device ", ">9000<", ">8000<",
         "timeout to SAFEOP or OP: expected 9000 ms (old), found 8000 ms"},
        {"analog.xml", "AI2", "<Objects", "89130000", "8A130000",
         "object 1000:00 default: expected 89 13 (old), found 8A 13"},
        {"analog.xml", "AI2", "<Objects", "AI Settings", "AO Settings",
         "object 8000 name: expected \"AI Settings\" (old), found \"AO Settings\""},
        {"analog.xml", "AI2", "\"PreOP_SafeOP\"", "\"PreOP_SafeOP\"", "\"PreOP\"",
         "object 8000:11 access: expected R.PREOP R.SAFEOP R.OP W.PREOP W.SAFEOP backup (old), found R.PREOP R.SAFEOP "
         "R.OP W.PREOP backup"},
        {"analog.xml", "AI2", "PreOP_SafeOP", "<Backup>1", "<Backup>0",
         "object 8000:11 access: expected R.PREOP R.SAFEOP R.OP W.PREOP W.SAFEOP backup (old), found R.PREOP R.SAFEOP "
         "R.OP W.PREOP W.SAFEOP"},
        {"analog.xml", "AI2", "<Objects", ">-1000<", ">-999<",
         "object 8000:11 limits: expected -1000 to 1000 (old), found -999 to 1000"},
        {"analog.xml", "AI2", "<Objects", ">-5<", ">-6<", "object 8000:11 default: expected FB FF (old), found FA FF"},
        {"analog.xml", "AI2", "<Objects", "F03F", "F04F",
         "object 8000:12 default: expected 00 00 00 00 00 00 F0 3F (old), found 00 00 00 00 00 00 F0 4F"},
        {"analog.xml", "AI2", "</Profile>", "MinSize=\"64\"", "MinSize=\"48\"",
         "SM0 smallest length: expected 64 (old), found 48"},
        {"analog.xml", "AI2", "\"#x1200\"", "#x1200", "#x1280", "SM2 start: expected 0x1200 (old), found 0x1280"},
        {"analog.xml", "AI2", "\"#x1200\"", "#x24", "#x64", "SM2 control byte: expected 0x24 (old), found 0x64"},
        {"analog.xml", "AI2", "#x22", "DefaultSize=\"6\"", "DefaultSize=\"8\"",
         "SM3 DefaultSize: expected 6 (old), found 8"},
        {"analog.xml", "AI2", "<RxPdo", "Mandatory=\"1\"", "Mandatory=\"0\"",
         "PDO 1600 mandatory: expected yes (old), found no"},
        {"analog.xml", "AI2", "<RxPdo", "<Name>AO<", "<Name>AQ<", "PDO 1600 name: expected \"AO\" (old), found \"AQ\""},
        {"analog.xml", "AI2", "<TxPdo", "Fixed=\"1\"", "Fixed=\"0\"", "PDO 1A00 fixed: expected yes (old), found no"},
        {"analog.xml", "AI2", "<TxPdo", "Overrange", "Overange",
         "PDO 1A00 entry 2 name: expected \"Overrange\" (old), found \"Overange\""},
        {"analog.xml", "AI2", "#x700<", "#x700<", "#x300<",
         "DC mode 1 AssignActivate: expected 0x0700 (old), found 0x0300"},
        {"analog.xml", "AI2", "#x700<", "100000", "200000",
         "DC mode 1 SYNC1: expected factor 1, shift 100000 ns (old), found factor 1, shift 200000 ns"},
        {"analog.xml", "AI2", "<OpMode", ">Synchron<", ">Synchronous<",
         "DC mode 0 name: expected \"Synchron\" (old), found \"Synchronous\""},
        {"analog.xml", "AI2", "<Mailbox>\n          <CoE", "CompleteAccess=\"1\"", "CompleteAccess=\"0\"",
         "mailbox CoE abilities: expected SDO SDO-information PDO-assign Complete-Access (old), found SDO "
         "SDO-information PDO-assign"},
        {"analog.xml", "AI2", "<FoE/>", "<FoE/>", "<EoE/>", "mailbox protocols: expected CoE FoE (old), found EoE CoE"},
        {"analog.xml", "AI2", "<Eeprom", "050E", "050C", "EEPROM word 0: expected 0x0E05 (old), found 0x0C05"},
        {"analog.xml", "AI2", "<Eeprom", "00108000", "00107000",
         "mailbox to the slave in BOOT: expected 128 bytes at 0x1000 (old), found 112 bytes at 0x1000"},
        {"analog.xml", "AI2", "<Eeprom", "2048", "4096", "EEPROM size: expected 2048 bytes (old), found 4096 bytes"},
        {"digital.xml", "@0x1004/0x20000", "#x00020000", "<Fmmu>Inputs", "<Fmmu>Outputs",
         "FMMU0: expected inputs (old), found outputs"},
        {"digital.xml", "@0x1004/0x20000", "#x1a01", "<BitLen>1</BitLen></Entry>\n        </TxPdo>",
         "<BitLen>2</BitLen></Entry>\n        </TxPdo>",
         "PDO 1A01 entry 2: expected 1 bits of padding (old), found 2 bits of padding"},
        {"digital.xml", "@0x1004/0x20000", "#x1a01", "<Entry><Index>0</Index><BitLen>1</BitLen></Entry>", "",
         "PDO 1A01 entry 2: expected 1 bits of padding (old), found nothing"},
        {"digital.xml", "@0x1004/0x20000", "<EBusCurrent", ">90<", ">95<",
         "device E-bus current: expected 90 mA (old), found 95 mA"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *before = load(table[i].file);
        char *after = changed(table[i].file, table[i].after, table[i].text, table[i].change);
        ect_facts_t expected = {.source = "old"};
        ect_facts_t found = {.source = "new"};
        facts_of_text(&expected, before, table[i].selector);
        facts_of_text(&found, after, strncmp(table[i].line, "identity", 8) == 0 ? "AI2" : table[i].selector);
        char *lines = lines_of(&expected, &found);
        char line[400];
        char title[300];
        (void)snprintf(line, sizeof line, "new: %s", table[i].line);
        (void)snprintf(title, sizeof title, "%s: %s for %s", table[i].selector, table[i].change, table[i].text);
        expect_line(title, lines, line);
        free(lines);
        ect_facts_free(&expected);
        ect_facts_free(&found);
        free(before);
        free(after);
    }
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------ */

enum { HEADER = 0 };

static void sii_mutations(void **state)
{
    static const struct {
        uint16_t category;
        size_t offset;
        uint8_t flip;
        const char *line;
    } table[] = {
        {HEADER, 0x00, 0x01, "EEPROM word 0: "},
        {HEADER, 0x02, 0x40, "EEPROM word 1: "},
        {HEADER, 0x0E, 0x01, "EEPROM checksum: expected right "},
        {HEADER, 0x10, 0x01, "identity vendor id: "},
        {HEADER, 0x14, 0x01, "identity product code: "},
        {HEADER, 0x18, 0x01, "identity revision: "},
        {HEADER, 0x30, 0x80, "mailbox to the slave: "},
        {HEADER, 0x36, 0x10, "mailbox from the slave: "},
        {HEADER, 0x38, 0x08, "mailbox protocols: "},
        {HEADER, 0x7C, 0x01, "EEPROM size: "},
        {ECT_SII_STRINGS, 2, 0x20, "device "},
        {ECT_SII_GENERAL, 5, 0x20, "mailbox CoE abilities: "},
        {ECT_SII_GENERAL, 12, 0x01, "device E-bus current: "},
        {ECT_SII_GENERAL, 16, 0x02, "device ports: "},
        {ECT_SII_FMMU, 0, 0x03, "FMMU0: "},
        {ECT_SII_SYNCM, 16, 0x80, "SM2 start: "},
        {ECT_SII_SYNCM, 18, 0x01, "SM2 length: "},
        {ECT_SII_SYNCM, 20, 0x40, "SM2 control byte: "},
        {ECT_SII_SYNCM, 22, 0x01, "SM2 enabled: "},
        {ECT_SII_SYNCM, 23, 0x07, "SM2: "},
        {ECT_SII_TXPDO, 3, 0x01, "PDO 1A00 SyncManager: "},
        {ECT_SII_TXPDO, 8, 0x01, "PDO 1A00 entry 1: "},
        {ECT_SII_TXPDO, 12, 0x02, "PDO 1A00 entry 1 data type: "},
        {ECT_SII_TXPDO, 13, 0x18, "PDO 1A00 entry 1: "},
    };
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        uint8_t *image = malloc(device->sii_size);
        assert_non_null(image);
        assert_true(ect_sii_write(device, NULL, 0, image, device->sii_size) > 0);
        size_t length = 0x80;
        uint8_t *at = image;
        if (table[i].category != HEADER)
            at = image + (ect_sii_category(image, device->sii_size, table[i].category, &length) - image);
        assert_true(table[i].offset < length);
        at[table[i].offset] ^= table[i].flip;
        if (table[i].category == HEADER && table[i].offset < 0x0E)
            image[0x0E] = ect_sii_checksum(image);
        ect_facts_t expected = {.source = "old"};
        ect_facts_t found = {.source = "new"};
        ect_facts_of_device(&expected, device);
        ect_facts_of_sii(&found, image, device->sii_size);
        char *lines = lines_of(&expected, &found);
        char line[300];
        (void)snprintf(line, sizeof line, "new: %s", table[i].line);
        if (strncmp(lines, line, strlen(line)) != 0)
            fail_msg("category %u, byte %zu\n  expected: %s...\n  got:      %s", table[i].category, table[i].offset,
                     line, lines);
        free(lines);
        ect_facts_free(&expected);
        ect_facts_free(&found);
        free(image);
    }
}

/* --- what belongs together --------------------------------------------------------------------------------------- */

static void silent(void **state)
{
    const ect_product_t *product;
    (void)state;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        const ect_device_t *device = product->device;
        uint8_t *image = malloc(device->sii_size);
        assert_non_null(image);
        assert_true(ect_sii_write(device, NULL, 0, image, device->sii_size) > 0);
        ect_facts_t expected = {.source = "description"};
        ect_facts_t found = {.source = "image"};
        ect_facts_of_device(&expected, device);
        ect_facts_of_sii(&found, image, device->sii_size);
        char *lines = lines_of(&expected, &found);
        expect_line(device->name, lines, "");
        free(lines);
        ect_facts_free(&expected);
        ect_facts_free(&found);
        free(image);
    }
}

/* A missing thing is one line, without lines for its parts. */
static void missing(void **state)
{
    (void)state;
    ect_facts_t expected = {.source = "old"};
    ect_facts_t found = {.source = "new"};
    (void)ect_facts_add(&expected, ECT_FACT_OBJECT, 0x2000, 0, "code %u", 9u);
    (void)ect_facts_add(&expected, ECT_FACT_ENTRY, 0x2000, 1, "%u bits", 8u);
    expected.complete[ECT_FACT_OBJECT] = expected.complete[ECT_FACT_ENTRY] = true;
    found.complete[ECT_FACT_OBJECT] = found.complete[ECT_FACT_ENTRY] = true;
    char *lines = lines_of(&expected, &found);
    expect_line("an object is missing", lines, "new: object 2000: expected code 9 (old), found nothing");
    free(lines);
    lines = lines_of(&found, &expected);
    expect_line("an object is more", lines, "old: object 2000: expected nothing (new), found code 9");
    free(lines);
    ect_facts_free(&expected);
    ect_facts_free(&found);
}

static const char *fact_of(const ect_facts_t *facts, ect_fact_kind_t kind, uint16_t index)
{
    for (size_t i = 0; i < facts->count; i++) {
        if (facts->list[i].kind == kind && facts->list[i].index == index)
            return facts->list[i].text;
    }
    return "no fact";
}

/* The twin of a file changes values: room in its EEPROM, names of standard objects, lengths of what it maps. */
static void as_in_the_file(void **state)
{
    static const struct {
        const char *what, *after, *text, *change;
        ect_fact_kind_t kind;
        uint16_t index;
        const char *fact;
    } table[] = {
        {"an EEPROM too small for the content of the twin", "AI2", "<ByteSize>2048<", "<ByteSize>256<",
         ECT_FACT_EEPROM_SIZE, 0, "256 bytes"},
        {"its size unchanged", "AI2", "<ByteSize>2048<", "<ByteSize>2048<", ECT_FACT_EEPROM_SIZE, 0, "2048 bytes"},
        {"no size at all", "AI2", "<ByteSize>2048</ByteSize>", "", ECT_FACT_EEPROM_SIZE, 0, "no fact"},
        {"process data without a length", "AI2", "<Sm DefaultSize=\"2\" ", "<Sm ", ECT_FACT_SM_LENGTH, 2, "no fact"},
        {"process data with a length", "AI2", "<Sm DefaultSize=\"2\" ", "<Sm DefaultSize=\"2\" ", ECT_FACT_SM_LENGTH, 2,
         "2 bytes"},
        {"another name of 1018h", "<Objects>", "<Object>",
         "<Object><Index>#x1018</Index><Name>Identity "
         "Object</Name><Type>UDINT</Type><BitSize>32</BitSize></Object><Object>",
         ECT_FACT_OBJECT_NAME, 0x1018, "\"Identity Object\""},
        {"no name of 1018h", "<Objects>", "<Object>", "<Object>", ECT_FACT_OBJECT_NAME, 0x1018, "no fact"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = changed("analog.xml", table[i].after, table[i].text, table[i].change);
        ect_facts_t facts = {.source = "file"};
        facts_of_text(&facts, text, "AI2");
        const char *fact = fact_of(&facts, table[i].kind, table[i].index);
        if (fact == NULL || strcmp(fact, table[i].fact) != 0)
            fail_msg("%s: expected %s, got %s", table[i].what, table[i].fact, fact != NULL ? fact : "something");
        ect_facts_free(&facts);
        free(text);
    }
}

/* The twin makes 1018h, and objects that a PDO maps; a slave may have none of them if the file has none. */
static void made(void **state)
{
    (void)state;
    char *text = load("analog.xml");
    ect_facts_t expected = {.source = "file"}, found = {.source = "slave"};
    facts_of_text(&expected, text, "AI2");
    assert_string_equal(fact_of(&expected, ECT_FACT_OBJECT, 0x8000), "code 9");
    assert_null(fact_of(&expected, ECT_FACT_OBJECT, 0x1018));
    assert_null(fact_of(&expected, ECT_FACT_OBJECT, 0x6000));
    found.complete[ECT_FACT_OBJECT] = true;
    char *lines = lines_of(&expected, &found);
    assert_non_null(strstr(lines, "slave: object 8000: expected code 9 (file), found nothing\n"));
    assert_null(strstr(lines, "something"));
    free(lines);
    free(text);
    ect_facts_free(&expected);
    ect_facts_free(&found);
}

/* Facts of some kinds are compared alone. */
static void parts(void **state)
{
    (void)state;
    ect_facts_t first = {.source = "old"}, part = {.source = "old"}, found = {.source = "new"};
    (void)ect_facts_add(&first, ECT_FACT_VENDOR, 0, 0, "1");
    (void)ect_facts_add(&first, ECT_FACT_SM, 0, 0, "outputs");
    (void)ect_facts_add(&found, ECT_FACT_VENDOR, 0, 0, "2");
    (void)ect_facts_add(&found, ECT_FACT_SM, 1, 0, "inputs");
    first.complete[ECT_FACT_SM] = found.complete[ECT_FACT_SM] = true;
    for (ect_fact_kind_t kind = ECT_FACT_VENDOR; kind <= ECT_FACT_TYPE; kind++)
        first.complete[kind] = true;
    ect_facts_take(&part, &first, ECT_FACT_VENDOR, ECT_FACT_REVISION);
    for (ect_fact_kind_t kind = ECT_FACT_VENDOR; kind <= ECT_FACT_TYPE; kind++)
        assert_int_equal(part.complete[kind], kind <= ECT_FACT_REVISION);
    char *lines = lines_of(&part, &found);
    expect_line("the identity alone", lines, "new: identity vendor id: expected 1 (old), found 2");
    free(lines);
    ect_facts_free(&part);
    part = (ect_facts_t){.source = "old"};
    ect_facts_take(&part, &first, ECT_FACT_SM, ECT_FACT_SM);
    FILE *nowhere = fopen("/dev/null", "w");
    assert_non_null(nowhere);
    assert_int_equal(ect_facts_compare(&part, &found, nowhere), 2); /* one is missing, one is more */
    (void)fclose(nowhere);
    ect_facts_free(&part);
    ect_facts_free(&first);
    ect_facts_free(&found);
}

/* Placeholders, and texts that each tool spells its own way, are no facts. */
static void texts(void **state)
{
    static const struct {
        const char *text;
        size_t length;
        const char *fact; /* NULL: none */
    } table[] = {
        {"Gain", 4, "\"Gain\""},
        {"Gain  ", 6, "\"Gain\""},
        {"Gainful", 4, "\"Gain\""},
        {"SubIndex 001", 12, NULL},
        {"SubIndex 0015", 12, NULL},
        {"SubIndex 0123456789", 19, NULL},
        {"SubIndex 1 a", 12, "\"SubIndex 1 a\""},
        {"SubIndex 1/", 11, "\"SubIndex 1/\""}, /* before 0 and behind 9 */
        {"SubIndex 1:", 11, "\"SubIndex 1:\""},
        {"SubIndex ", 9, "\"SubIndex\""},
        {"! ~", 3, "\"! ~\""},
        {"!\x1F~", 3, NULL},
        {"!\x7F~", 3, NULL},
        {"", 0, NULL},
        {"Verst\xC3\xA4rkung", 11, NULL},
        {"SubInde", 7, "\"SubInde\""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_facts_t facts = {.source = "texts"};
        char *exact = malloc(table[i].length > 0 ? table[i].length : 1); /* not terminated, as in an image */
        assert_non_null(exact);
        memcpy(exact, table[i].text, table[i].length);
        ect_facts_add_text(&facts, ECT_FACT_NAME, 0, 0, exact, table[i].length);
        const char *fact = facts.count > 0 ? facts.list[0].text : NULL;
        if ((fact == NULL) != (table[i].fact == NULL) || (fact != NULL && strcmp(fact, table[i].fact) != 0))
            fail_msg("\"%s\": expected %s, got %s", table[i].text, table[i].fact != NULL ? table[i].fact : "no fact",
                     fact != NULL ? fact : "no fact");
        ect_facts_free(&facts);
        free(exact);
    }
}

/* Any bytes are an image; images that are cut off have fewer facts. */
static void cut_images(void **state)
{
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    uint8_t *image = malloc(device->sii_size);
    (void)state;
    assert_non_null(image);
    assert_true(ect_sii_write(device, NULL, 0, image, device->sii_size) > 0);
    for (size_t size = 0; size < 1024; size++) {
        uint8_t *part = malloc(size + 1);
        assert_non_null(part);
        memcpy(part, image, size);
        ect_facts_t facts = {.source = "part"};
        ect_facts_of_sii(&facts, part, size);
        assert_true(facts.count > 0);
        ect_facts_free(&facts);
        free(part);
    }
    free(image);
}

static void intel_hex(void **state)
{
    static const struct {
        const char *text;
        long size;
        const char *message; /* behind the path */
    } table[] = {
        {":0400000001020304F2\n:00000001FF\n", 4, ""},
        {":02000200AABB97\r\n:00000001FF\r\n", 4, ""},
        {":020000040000FA\n:0100FF005AA6\n:00000001FF\n", 256, ""},
        {":0400000001020304F3\n", -1, ":1: a line of Intel HEX that has a wrong sum"},
        {":0400000001020304\n", -1, ":1: a line of Intel HEX that has another length than its first byte"},
        {":00000001FF\nnothing", 0, ""},
        {":020000040002F8\n", -1, ":1: a line of Intel HEX that is beyond the largest EEPROM"},
        {":01000007AA4E\n", -1, ":1: a line of Intel HEX that has an unknown type"},
        {"\x01\x02\x03", 3, ""},
    };
    char path[] = "/tmp/ectwin-hex-XXXXXX";
    int fd = mkstemp(path);
    uint8_t *image = malloc(SII_FILE_MOST);
    (void)state;
    assert_true(fd >= 0 && image != NULL);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char message[300] = "";
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        (void)fputs(table[i].text, file);
        (void)fclose(file);
        long size = sii_file_read(path, image, message, sizeof message);
        if (size != table[i].size || strcmp(*message != '\0' ? message + strlen(path) : "", table[i].message) != 0)
            fail_msg("case %zu: expected %ld \"%s\", got %ld \"%s\"", i, table[i].size, table[i].message, size,
                     message);
    }
    (void)remove(path);
    free(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"verify names each of 35 changes of an ESI file (CF-066)", esi_mutations, NULL, NULL, NULL},
        {"verify names each of 24 changes of an EEPROM image (CF-054)", sii_mutations, NULL, NULL, NULL},
        {"verify finds nothing between a description and its EEPROM image (CF-054)", silent, NULL, NULL, NULL},
        {"a missing thing is one line", missing, NULL, NULL, NULL},
        {"facts of some kinds are compared alone", parts, NULL, NULL, NULL},
        {"a value that the twin changes is compared as in the file", as_in_the_file, NULL, NULL, NULL},
        {"an object that the twin makes may be missing", made, NULL, NULL, NULL},
        {"placeholders and letters beyond ISO 646 are not compared", texts, NULL, NULL, NULL},
        {"an image that is cut off anywhere is read as far as it goes", cut_images, NULL, NULL, NULL},
        {"EEPROM images as bytes and as Intel HEX", intel_hex, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
