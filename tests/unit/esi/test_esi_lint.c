/* SPDX-License-Identifier: MIT */
/* CF-063: what of an ESI file is not as a file should be, found with its line. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "esi/lint.h"

/* A bitmap's header of that many points; what follows it does not matter. */
#define BITMAP(width, height)                                                                                          \
    "424D000000000000000036000000"                                                                                     \
    "28000000" width height "0100"

#define VENDOR "<Vendor>\n<Id>#x1</Id><Name>V</Name></Vendor>"
#define GROUP  "<Group><Type>G</Type><Name>Group</Name></Group>"
#define BODY                                                                                                           \
    "<Type ProductCode='#x1' RevisionNo='1'>A</Type><Name>Device A</Name><GroupType>G</GroupType>\n"                   \
    "<Fmmu>Inputs</Fmmu><Sm DefaultSize='1' StartAddress='#x1000' ControlByte='#x20' Enable='1'>Inputs</Sm>\n"         \
    "<TxPdo Sm='0'><Index>#x1A00</Index><Name>P</Name><Entry><Index>#x6000</Index><SubIndex>1</SubIndex>"              \
    "<BitLen>8</BitLen><Name>E</Name><DataType>USINT</DataType></Entry></TxPdo>\n"                                     \
    "<Eeprom><ByteSize>2048</ByteSize><ConfigData>050C</ConfigData></Eeprom>"
#define FILE_OF(vendor, group, device)                                                                                 \
    "<EtherCATInfo>\n" vendor "\n<Descriptions><Groups>" group "</Groups><Devices>\n" device                           \
    "\n</Devices></Descriptions></EtherCATInfo>"
#define DEVICE(body) "<Device Physics='YY'>" body "</Device>"
#define GOOD         FILE_OF(VENDOR, GROUP, DEVICE(BODY))

static const struct mistake {
    const char *what, *from, *to; /* `from` in GOOD becomes `to` */
    bool wrong;
    const char *line; /* NULL: nothing */
} mistakes[] = {
    {"the unchanged file", "", "", false, NULL},
    {"a picture of 16 x 14", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "0E000000") "</ImageData16x14>", false, NULL},
    {"a picture from top to bottom", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "F2FFFFFF") "</ImageData16x14>", false, NULL},
    {"a picture of the largest height", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "FFFFFF7F") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 2147483647"},
    {"a picture of the height -1", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "FFFFFFFF") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 1"},
    {"inputs before outputs", "<TxPdo",
     "<TxPdo><Index>#x1A01</Index><Name>Q</Name></TxPdo><RxPdo><Index>#x1600</Index>"
     "<Name>R</Name></RxPdo><TxPdo",
     false, NULL},

    {"no vendor's name", "<Name>V</Name>", "", true, "f.xml:2: Vendor has no Name"},
    {"an empty vendor's name", "<Name>V</Name>", "<Name/>", true, "f.xml:2: Vendor has no Name"},
    {"no device's name", "<Name>Device A</Name>", "", true, "f.xml:5: Device has no Name"},
    {"no ports", " Physics='YY'", "", true, "f.xml:5: Device has no Physics"},
    {"no group", "<GroupType>G</GroupType>", "", true, "f.xml:5: Device has no GroupType"},
    {"an empty group", "<GroupType>G</GroupType>", "<GroupType/>", true, "f.xml:5: Device has no GroupType"},
    {"a comment in the device", "<Eeprom>", "<!-- of the factory --><Eeprom>", false, NULL},
    {"a group of another file", "<GroupType>G<", "<GroupType>H<", false, "f.xml:5: GroupType H is no group"},
    {"a group without a name", "<Name>Group</Name>", "", false, "f.xml:5: GroupType G is no group with a name"},
    {"no EEPROM", "<Eeprom><ByteSize>2048</ByteSize><ConfigData>050C</ConfigData></Eeprom>", "", false,
     "f.xml:5: Device has no Eeprom"},
    {"an EEPROM without a size", "<ByteSize>2048</ByteSize>", "", true,
     "f.xml:8: Eeprom has neither Data nor ByteSize"},
    {"first words that are too many", "050C<", "050C00000000000000000000000000<", true,
     "f.xml:8: ConfigData has 15 bytes, more than the 14"},

    {"the SyncManager before the FMMU", "<Fmmu>Inputs</Fmmu>", "<Sm>Inputs</Sm><Fmmu>Inputs</Fmmu>", true,
     "f.xml:6: Fmmu behind Sm in Device"},
    {"an unknown element", "<Eeprom>", "<Eprom/><Eeprom>", true, "f.xml:8: Eprom in Device, where there is no"},
    {"modules before groups", "<Groups>", "<Modules/><Groups>", true, "f.xml:4: Groups behind Modules in Descriptions"},
    {"the size behind the first words", "<ByteSize>2048</ByteSize><ConfigData>050C</ConfigData>",
     "<ConfigData>050C</ConfigData><ByteSize>2048</ByteSize>", true, "f.xml:8: ByteSize behind ConfigData in Eeprom"},

    {"a product code of C", "ProductCode='#x1'", "ProductCode='0x1'", true,
     "f.xml:5: ProductCode 0x1: a hexadecimal number is written #x1"},
    {"an index of C", "<Index>#x1A00<", "<Index>0x1A00<", true, "f.xml:7: Index 0x1A00: a hexadecimal"},
    {"a vendor id of C", "<Id>#x1<", "<Id>0x1<", true, "f.xml:3: Id 0x1: a hexadecimal"},

    {"OneByteMode", "<Sm ", "<Sm OneByteMode='1' ", true, "f.xml:6: OneByteMode of Sm is obsolete"},
    {"TcCfgModeSafeOp", "<Type Prod", "<Type TcCfgModeSafeOp='1' Prod", true,
     "f.xml:5: TcCfgModeSafeOp of Type is obsolete"},
    {"OpOnly of an FMMU", "<Fmmu>", "<Fmmu OpOnly='1'>", true, "f.xml:6: OpOnly of Fmmu is obsolete"},
    {"OpOnly of a SyncManager", "<Sm ", "<Sm OpOnly='1' ", false, "f.xml:6: OpOnly of Sm: many masters"},
    {"a picture as a text", "</Eeprom>", "</Eeprom><Image16x14>A</Image16x14>", true,
     "f.xml:8: Image16x14 is obsolete"},

    {"a picture that is none", "</Eeprom>", "</Eeprom><ImageData16x14>00112233</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is not a bitmap"},
    {"a picture that is not hexadecimal", "</Eeprom>", "</Eeprom><ImageData16x14>QM</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is empty or not hexadecimal"},
    {"a picture of another size", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("20000000", "0E000000") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 32 x 14"},
    {"a group's picture that is none", "</Name></Group>", "</Name><ImageData16x14>00</ImageData16x14></Group>", true,
     "f.xml:4: ImageData16x14 of Group is not a bitmap"},

    {"first words that are just right", "050C<", "050C000000000000000000000000<", false, NULL},
    {"a picture of the height 00000080", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "00000080") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 2147483648"},
    {"a picture of the height 00000000", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "00000000") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 0"},
    {"a picture of the height 0D000000", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "0D000000") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 13"},
    {"a picture of the height F3FFFFFF", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "F3FFFFFF") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 13"},
    {"a picture of the height 0F000000", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("10000000", "0F000000") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 16 x 15"},
    {"a picture of the width 17", "</Eeprom>",
     "</Eeprom><ImageData16x14>" BITMAP("11000000", "0E000000") "</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is a bitmap of 17 x 14"},
    {"a picture whose header is cut off", "</Eeprom>",
     "</Eeprom><ImageData16x14>424D0000000000000000360000002800000010000000</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is not a bitmap"},
    {"a picture that begins with B alone", "</Eeprom>",
     "</Eeprom><ImageData16x14>420000000000000000003600000028000000100000000E000000</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is not a bitmap"},
    {"a picture that ends with M alone", "</Eeprom>",
     "</Eeprom><ImageData16x14>004D00000000000000003600000028000000100000000E000000</ImageData16x14>", true,
     "f.xml:8: ImageData16x14 of Device is not a bitmap"},
    {"an empty picture", "</Eeprom>", "</Eeprom><ImageData16x14/>", true, "f.xml:8: ImageData16x14 of Device is empty"},
    {"a vendor's picture that is none", "<Name>V</Name>", "<Name>V</Name><ImageData16x14>00</ImageData16x14>", true,
     "f.xml:3: ImageData16x14 of Vendor is not a bitmap"},
    {"an Eeprom with its whole image", "<ByteSize>2048</ByteSize><ConfigData>050C</ConfigData>", "<Data>0102</Data>",
     false, NULL},
    {"TcSmClass of Type", "<Type Prod", "<Type TcSmClass='1' Prod", true, "f.xml:5: TcSmClass of Type is obsolete"},
    {"DownloadModuleList of Type", "<Type Prod", "<Type DownloadModuleList='1' Prod", true,
     "f.xml:5: DownloadModuleList of Type is obsolete"},
    {"Watchdog of Sm", "<Sm ", "<Sm Watchdog='1' ", true, "f.xml:6: Watchdog of Sm is obsolete"},
    {"FixedAssignment of Sm", "<Sm ", "<Sm FixedAssignment='1' ", true, "f.xml:6: FixedAssignment of Sm is obsolete"},
    {"PdoOrder of TxPdo", "<TxPdo Sm", "<TxPdo PdoOrder='1' Sm", true, "f.xml:7: PdoOrder of TxPdo is obsolete"},
    {"UniqueName of Vendor", "<Vendor>", "<Vendor UniqueName='1'>", true, "f.xml:2: UniqueName of Vendor is obsolete"},
    {"PdoOrder of RxPdo", "<TxPdo Sm", "<RxPdo PdoOrder='1'><Index>#x1600</Index><Name>R</Name></RxPdo><TxPdo Sm", true,
     "f.xml:7: PdoOrder of RxPdo is obsolete"},
    {"ProductRevision of HideType", "<Name>Device A", "<HideType ProductRevision='1'/><Name>Device A", true,
     "f.xml:5: ProductRevision of HideType is obsolete"},
    {"Channel of Profile", "<Fmmu>", "<Profile Channel='0'/><Fmmu>", true, "f.xml:6: Channel of Profile is obsolete"},
    {"DS402Channels of CoE", "<Eeprom>", "<Mailbox><CoE DS402Channels='1'/></Mailbox><Eeprom>", true,
     "f.xml:8: DS402Channels of CoE is obsolete"},
    {"Fixed of InitCmd", "<Eeprom>",
     "<Mailbox><CoE><InitCmd Fixed='1'><Transition>PS</Transition></InitCmd></CoE></Mailbox><Eeprom>", true,
     "f.xml:8: Fixed of InitCmd is obsolete"},
    {"IdentifyModuleBy of Slots", "<Eeprom>", "<Slots IdentifyModuleBy='x'/><Eeprom>", true,
     "f.xml:8: IdentifyModuleBy of Slots is obsolete"},
    {"StationAliasSupported", "<GroupType>", "<Info><StationAliasSupported>1</StationAliasSupported></Info><GroupType>",
     true, "f.xml:5: StationAliasSupported is obsolete"},
    {"RevisionNo of C", "RevisionNo='1'", "RevisionNo='0x1'", true, "f.xml:5: RevisionNo 0"},
    {"StartAddress of C", "StartAddress='#x1000'", "StartAddress='0X1000'", true, "f.xml:6: StartAddress 0"},
    {"ControlByte of C", "ControlByte='#x20'", "ControlByte='0x20'", true, "f.xml:6: ControlByte 0"},
    {"DefaultSize of C", "DefaultSize='1'", "DefaultSize='0x1'", true, "f.xml:6: DefaultSize 0"},
    {"Enable of C", "Enable='1'", "Enable='0x1'", true, "f.xml:6: Enable 0"},
    {"MinSize of C", "<Sm ", "<Sm MinSize='0x1' ", true, "f.xml:6: MinSize 0"},
    {"MaxSize of C", "<Sm ", "<Sm MaxSize='0x1' ", true, "f.xml:6: MaxSize 0"},
    {"Sm of C", "TxPdo Sm='0'", "TxPdo Sm='0x0'", true, "f.xml:7: Sm 0"},
    {"SubIndex of C", "<SubIndex>1<", "<SubIndex>0x1<", true, "f.xml:7: SubIndex 0x"},
    {"ByteSize of C", "<ByteSize>2048<", "<ByteSize>0x800<", true, "f.xml:8: ByteSize 0x"},
    {"Exclude of C", "<Entry>", "<Exclude>0x1A01</Exclude><Entry>", true, "f.xml:7: Exclude 0x"},
    {"AssignActivate of C", "<Eeprom>",
     "<Dc><OpMode><Name>M</Name><AssignActivate>0x300</AssignActivate></OpMode></Dc><Eeprom>", true,
     "f.xml:8: AssignActivate 0x"},
    {"a number of C behind an empty element", "<Eeprom><ByteSize>2048<",
     "<Mailbox><FoE/></Mailbox><Eeprom><ByteSize>0x800<", true, "f.xml:8: ByteSize 0x800"},
    {"the vendor behind the descriptions", "</Descriptions>", "</Descriptions><InfoReference/>", true,
     "f.xml:9: InfoReference behind Descriptions in EtherCATInfo"},
    {"the vendor's name before its id", "<Id>#x1</Id><Name>V</Name>", "<Name>V</Name><Id>#x1</Id>", true,
     "f.xml:3: Id behind Name in Vendor"},
    {"the group's name before its type", "<Type>G</Type><Name>Group</Name>", "<Name>Group</Name><Type>G</Type>", true,
     "f.xml:4: Type behind Name in Group"},
    {"the name before the type", "<Type ProductCode='#x1' RevisionNo='1'>A</Type><Name>Device A</Name>",
     "<Name>Device A</Name><Type ProductCode='#x1' RevisionNo='1'>A</Type>", true,
     "f.xml:5: Type behind Name in Device"},
    {"FoE before CoE", "<Eeprom>", "<Mailbox><FoE/><CoE/></Mailbox><Eeprom>", true,
     "f.xml:8: CoE behind FoE in Mailbox"},
    {"an unknown protocol", "<Eeprom>", "<Mailbox><XoE/></Mailbox><Eeprom>", true,
     "f.xml:8: XoE in Mailbox, where there is no"},
    {"an unknown part of the EEPROM", "<ByteSize>", "<Bits>1</Bits><ByteSize>", true,
     "f.xml:8: Bits in Eeprom, where there is no"},
    {"the EEPROM before the clocks", "</Eeprom>", "</Eeprom><Dc/>", true, "f.xml:8: Dc behind Eeprom in Device"},
    {"an unknown element of the file", "<Vendor>", "<Vendors/><Vendor>", true,
     "f.xml:2: Vendors in EtherCATInfo, where there is no"},
};

typedef struct found {
    unsigned int wrong, words;
    char first[500];
} findings_t;

static void take(void *ctx, bool wrong, const char *line)
{
    findings_t *found = ctx;
    if (found->wrong + found->words == 0)
        (void)snprintf(found->first, sizeof found->first, "%s", line);
    found->wrong += wrong;
    found->words += !wrong;
}

static char *changed(const struct mistake *m)
{
    const char *at = strstr(GOOD, m->from);
    char *text = calloc(1, sizeof GOOD + strlen(m->to));
    assert_non_null(at);
    assert_non_null(text);
    (void)sprintf(text, "%.*s%s%s", (int)(at - GOOD), GOOD, m->to, at + strlen(m->from));
    return text;
}

static findings_t findings_of(const char *text, const char *selector)
{
    char why[300] = "";
    findings_t found = {.wrong = 0};
    ect_esi_t *esi = ect_esi_parse("f.xml", text, strlen(text), why, sizeof why);
    const ect_esi_device_t *device = esi != NULL ? ect_esi_select(esi, selector, why, sizeof why) : NULL;
    if (device == NULL)
        fail_msg("expected a device, got: %s", why);
    ect_esi_lint(esi, device, take, &found);
    ect_esi_close(esi);
    return found;
}

static void each_mistake(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        const struct mistake *m = &mistakes[i];
        char *text = changed(m);
        findings_t found = findings_of(text, "");
        bool as_expected = m->line == NULL ? found.wrong + found.words == 0
                                           : found.wrong == m->wrong && found.words == !m->wrong &&
                                                 strncmp(found.first, m->line, strlen(m->line)) == 0;
        if (!as_expected)
            fail_msg("%s: expected %s \"%s\", got %u wrong, %u words, first \"%s\"", m->what,
                     m->line == NULL ? "nothing"
                     : m->wrong      ? "wrong"
                                     : "a word",
                     m->line ? m->line : "", found.wrong, found.words, found.first);
        free(text);
    }
}

/* Only the selected device of a file counts. */
static void other_devices(void **state)
{
#define BAD "<Device><Sm OneByteMode='1'/><Type ProductCode='0x2' RevisionNo='1'>B</Type></Device>"
    static const struct {
        const char *what, *text;
    } files[] = {{"behind it", FILE_OF(VENDOR, GROUP, DEVICE(BODY) BAD)},
                 {"before it, on the same line", FILE_OF(VENDOR, GROUP, BAD DEVICE(BODY))}};
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        findings_t good = findings_of(files[i].text, "A"), bad = findings_of(files[i].text, "B");
        if (good.wrong + good.words != 0 || bad.wrong < 4)
            fail_msg("a bad device %s: expected nothing of A and at least 4 of B, got %u and %u, first \"%s\"",
                     files[i].what, good.wrong + good.words, bad.wrong, good.first);
    }
}

/* A line has room for 399 characters: a longer name of a file fills it, and no part of the finding follows. */
static void long_names(void **state)
{
    enum { LONGEST = 399 };
    static const struct {
        size_t length;
        const char *end; /* of the line */
    } rows[] = {{300, ":5: Device has no Physics"}, {380, ":5: Device has no P"}, {LONGEST, "n"}, {500, "n"}};
    static const char text[] = FILE_OF(VENDOR, GROUP, "<Device>" BODY "</Device>");
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char name[501] = "", why[300] = "";
        findings_t found = {.wrong = 0};
        memset(name, 'n', rows[i].length);
        ect_esi_t *esi = ect_esi_parse(name, text, strlen(text), why, sizeof why);
        assert_non_null(esi);
        const ect_esi_device_t *device = ect_esi_select(esi, "", why, sizeof why);
        assert_non_null(device);
        ect_esi_lint(esi, device, take, &found);
        const size_t length = strlen(found.first), end = strlen(rows[i].end);
        if (found.wrong != 1 || length > LONGEST || length < end ||
            strcmp(found.first + length - end, rows[i].end) != 0)
            fail_msg("a name of %zu: expected a line that ends with \"%s\", got %u, \"%s\"", rows[i].length,
                     rows[i].end, found.wrong, found.first);
        ect_esi_close(esi);
    }
}

/* A schema of our own, for the ETG's is not ours to carry. */
static const char *write_schema(const char *text)
{
    static char path[] = "/tmp/ectwin-lint-XXXXXX";
    (void)strcpy(path, "/tmp/ectwin-lint-XXXXXX");
    int file = mkstemp(path);
    assert_true(file >= 0);
    FILE *stream = fdopen(file, "w");
    assert_non_null(stream);
    (void)fputs(text, stream);
    (void)fclose(stream);
    return path;
}

#define SCHEMA(type)                                                                                                   \
    "<xs:schema xmlns:xs='http://www.w3.org/2001/XMLSchema'><xs:element name='EtherCATInfo' type='" type               \
    "'/></xs:schema>"

static FILE *errors_file;

/* Redirects stderr into a file. @return its duplicate */
static int begin_errors(void)
{
    const int before = dup(STDERR_FILENO);
    errors_file = tmpfile();
    assert_true(before >= 0 && errors_file != NULL);
    (void)fflush(stderr);
    assert_true(dup2(fileno(errors_file), STDERR_FILENO) >= 0);
    return before;
}

/* @return bytes written to stderr meanwhile */
static long end_errors(int before)
{
    (void)fflush(stderr);
    const long bytes = lseek(fileno(errors_file), 0, SEEK_END);
    assert_true(dup2(before, STDERR_FILENO) >= 0);
    (void)close(before);
    (void)fclose(errors_file);
    return bytes;
}

static void schemas(void **state)
{
    static const struct {
        const char *what, *schema;
        bool read;
        unsigned int wrong;
        const char *line;
    } table[] = {
        {"one that allows all", SCHEMA("xs:anyType"), true, 0, ""},
        {"an element that requires a number", SCHEMA("xs:int"), true, 2, "f.xml:1: Element 'EtherCATInfo'"},
        {"none", "hello", false, 0, ""},
        {"another file of XML", "<EtherCATInfo/>", false, 0, ""},
        {"a schema with a missing type", SCHEMA("none"), false, 0, ""},
    };
    char why[300] = "", expected[300];
    (void)state;
    ect_esi_t *esi = ect_esi_parse("f.xml", GOOD, strlen(GOOD), why, sizeof why);
    assert_non_null(esi);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        findings_t found = {.wrong = 0};
        const char *path = write_schema(table[i].schema);
        const int errors = begin_errors();
        ect_esi_schema_t *schema = ect_esi_schema_open(path, why, sizeof why);
        bool read = schema != NULL;
        if (end_errors(errors) != 0)
            fail_msg("%s: expected no text of libxml2 at stderr", table[i].what);
        (void)snprintf(expected, sizeof expected, "%s: the schema, or a file that it includes, cannot be read", path);
        assert_string_equal(read ? expected : why, expected);
        (void)remove(path);
        if (read)
            ect_esi_validate(esi, schema, take, &found);
        ect_esi_schema_close(schema);
        if (read != table[i].read || found.wrong != table[i].wrong ||
            strncmp(found.first, table[i].line, strlen(table[i].line)) != 0)
            fail_msg("%s: expected %d, %u wrong \"%s\", got %d, %u wrong \"%s\"", table[i].what, table[i].read,
                     table[i].wrong, table[i].line, read, found.wrong, found.first);
    }
    ect_esi_close(esi);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-063: each mistake of a file is reported, with its line and its weight", each_mistake, NULL, NULL, NULL},
        {"CF-063: mistakes in other devices of a file do not matter", other_devices, NULL, NULL, NULL},
        {"CF-063: a finding in a file with a long name is cut", long_names, NULL, NULL, NULL},
        {"CF-063: a file is validated against the schema that the user has", schemas, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
