/* SPDX-License-Identifier: MIT */
/* Objects, PDOs, layouts and signals of a twin: a line of a file, and the result. */
#include "from_text.h"
#include "od/pdo.h"
#include "seams/services.h"
#include "seams/standard.h"

#define MAIL          ESI_MAILBOX_SMS
#define COE           "<Mailbox><CoE/></Mailbox>"
#define DICT(rest)    "<Profile><Dictionary>" rest "</Dictionary></Profile>"
#define OBJECTS(rest) "<Objects>" rest "</Objects>"
#define TYPES(rest)   "<DataTypes>" rest "</DataTypes>"
/* An object of one value. */
#define VALUE(type, bits, info, flags)                                                                                 \
    "<Object><Index>#x2000</Index><Name>V</Name><Type>" type "</Type><BitSize>" bits "</BitSize><Info>" info           \
    "</Info><Flags>" flags "</Flags></Object>"
#define ONE(type, bits, info, flags) ESI_DEVICE(DICT(OBJECTS(VALUE(type, bits, info, flags))) MAIL COE ESI_EEPROM)
#define ITEM(n, name, type, bits, rest)                                                                                \
    "<SubItem><SubIdx>" n "</SubIdx><Name>" name "</Name><Type>" type "</Type><BitSize>" bits "</BitSize>" rest        \
    "</SubItem>"
#define COUNT ITEM("0", "SubIndex 000", "USINT", "8", "")
/* A record of the type T. */
#define RECORD(items, info, flags)                                                                                     \
    ESI_DEVICE(DICT(TYPES("<DataType><Name>T</Name><BitSize>64</BitSize>" items "</DataType>") OBJECTS(                \
        "<Object><Index>#x2000</Index><Name>R</Name><Type>T</Type><BitSize>64</BitSize><Info>" info                    \
        "</Info><Flags>" flags "</Flags></Object>")) MAIL COE ESI_EEPROM)

/* --- rights ------------------------------------------------------------------------------------------------------- */

#define R3 (ECT_ACCESS_R_PREOP | ECT_ACCESS_R_SAFEOP | ECT_ACCESS_R_OP)
#define W3 (ECT_ACCESS_W_PREOP | ECT_ACCESS_W_SAFEOP | ECT_ACCESS_W_OP)

static void rights(void **state)
{
    static const struct {
        const char *flags, *text;
        uint16_t access;
    } table[] = {
        {"no flags", ONE("UINT", "16", "", ""), R3},
        {"ro", ONE("UINT", "16", "", "<Access>ro</Access>"), R3},
        {"rw", ONE("UINT", "16", "", "<Access>rw</Access>"), R3 | W3},
        {"wo", ONE("UINT", "16", "", "<Access>wo</Access>"), W3},
        {"write in PREOP", ONE("UINT", "16", "", "<Access WriteRestrictions='PreOP'>rw</Access>"),
         R3 | ECT_ACCESS_W_PREOP},
        {"write in SAFEOP", ONE("UINT", "16", "", "<Access WriteRestrictions='SafeOP'>rw</Access>"),
         R3 | ECT_ACCESS_W_SAFEOP},
        {"write in OP", ONE("UINT", "16", "", "<Access WriteRestrictions='OP'>rw</Access>"), R3 | ECT_ACCESS_W_OP},
        {"write in PREOP and SAFEOP", ONE("UINT", "16", "", "<Access WriteRestrictions='PreOP_SafeOP'>rw</Access>"),
         R3 | ECT_ACCESS_W_PREOP | ECT_ACCESS_W_SAFEOP},
        {"write in PREOP and OP", ONE("UINT", "16", "", "<Access WriteRestrictions='PreOP_OP'>rw</Access>"),
         R3 | ECT_ACCESS_W_PREOP | ECT_ACCESS_W_OP},
        {"write in SAFEOP and OP", ONE("UINT", "16", "", "<Access WriteRestrictions='SafeOP_OP'>rw</Access>"),
         R3 | ECT_ACCESS_W_SAFEOP | ECT_ACCESS_W_OP},
        {"letters of another size", ONE("UINT", "16", "", "<Access WriteRestrictions='preop'>rw</Access>"),
         R3 | ECT_ACCESS_W_PREOP},
        {"an unknown restriction", ONE("UINT", "16", "", "<Access WriteRestrictions='Boot'>rw</Access>"), R3 | W3},
        {"read in OP", ONE("UINT", "16", "", "<Access ReadRestrictions='OP'>ro</Access>"), ECT_ACCESS_R_OP},
        {"read in PREOP, write in SAFEOP",
         ONE("UINT", "16", "", "<Access ReadRestrictions='PreOP' WriteRestrictions='SafeOP'>rw</Access>"),
         ECT_ACCESS_R_PREOP | ECT_ACCESS_W_SAFEOP},
        {"mapped to inputs", ONE("UINT", "16", "", "<Access>ro</Access><PdoMapping>T</PdoMapping>"),
         R3 | ECT_ACCESS_TXPDO},
        {"mapped to outputs", ONE("UINT", "16", "", "<Access>ro</Access><PdoMapping>r</PdoMapping>"),
         R3 | ECT_ACCESS_RXPDO},
        {"mapped to both", ONE("UINT", "16", "", "<Access>ro</Access><PdoMapping>RT</PdoMapping>"),
         R3 | ECT_ACCESS_RXPDO | ECT_ACCESS_TXPDO},
        {"backup", ONE("UINT", "16", "", "<Access>ro</Access><Backup>1</Backup>"), R3 | ECT_ACCESS_BACKUP},
        {"backup of 3", ONE("UINT", "16", "", "<Access>ro</Access><Backup>3</Backup>"), R3 | ECT_ACCESS_BACKUP},
        {"no backup", ONE("UINT", "16", "", "<Access>ro</Access><Backup>0</Backup>"), R3},
        {"backup false", ONE("UINT", "16", "", "<Access>ro</Access><Backup>false</Backup>"), R3},
        {"setting", ONE("UINT", "16", "", "<Access>ro</Access><Setting>1</Setting>"), R3 | ECT_ACCESS_SETTING},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].flags, table[i].text);
        ect_od_t od = od_of(&m);
        uint16_t access = ect_od_find(&od, 0x2000)->entries[0].access & ECT_ACCESS_WIRE;
        if (access != table[i].access)
            fail_msg("%s: expected %03X, got %03X", table[i].flags, table[i].access, access);
        free_made(&m);
    }
}

/* A sub-item has its own flags, else those of its object. */
static void inherited_rights(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t access;
    } table[] = {
        {"its own",
         RECORD(COUNT ITEM("1", "A", "UINT", "16", "<Flags><Access>wo</Access></Flags>"), "", "<Access>rw</Access>"),
         W3},
        {"the object's", RECORD(COUNT ITEM("1", "A", "UINT", "16", ""), "", "<Access>rw</Access>"), R3 | W3},
        {"its own rights, the object's restriction",
         RECORD(COUNT ITEM("1", "A", "UINT", "16", "<Flags><Access>rw</Access></Flags>"), "",
                "<Access WriteRestrictions='PreOP'>rw</Access>"),
         R3 | ECT_ACCESS_W_PREOP},
        {"the object's mapping", RECORD(COUNT ITEM("1", "A", "UINT", "16", ""), "", "<PdoMapping>T</PdoMapping>"),
         R3 | ECT_ACCESS_TXPDO},
        {"the object's backup", RECORD(COUNT ITEM("1", "A", "UINT", "16", ""), "", "<Backup>1</Backup>"),
         R3 | ECT_ACCESS_BACKUP},
        {"the object's setting", RECORD(COUNT ITEM("1", "A", "UINT", "16", ""), "", "<Setting>1</Setting>"),
         R3 | ECT_ACCESS_SETTING},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_entry_t *entry = ect_od_entry(ect_od_find(&od, 0x2000), 1);
        assert_non_null(entry);
        if ((entry->access & ECT_ACCESS_WIRE) != table[i].access)
            fail_msg("%s: expected %03X, got %03X", table[i].what, table[i].access, entry->access & ECT_ACCESS_WIRE);
        free_made(&m);
    }
}

/* --- defaults ----------------------------------------------------------------------------------------------------- */

static void defaults(void **state)
{
    static const struct {
        const char *what, *text;
        size_t size;
        uint8_t bytes[12];
        const char *note;
    } table[] = {
        {"none", ONE("UINT", "16", "", ""), 2, {0}, NULL},
        {"bytes", ONE("UINT", "16", "<DefaultData>3412</DefaultData>", ""), 2, {0x34, 0x12}, NULL},
        {"the first byte not zero", ONE("UINT", "16", "<DefaultData>0500</DefaultData>", ""), 2, {5, 0}, NULL},
        {"fewer bytes", ONE("UINT", "16", "<DefaultData>05</DefaultData>", ""), 2, {5, 0}, NULL},
        {"more bytes", ONE("UINT", "16", "<DefaultData>05060708</DefaultData>", ""), 2, {5, 6}, NULL},
        {"blanks between bytes", ONE("UINT", "16", "<DefaultData>05 06</DefaultData>", ""), 2, {5, 6}, NULL},
        {"a number", ONE("UINT", "16", "<DefaultValue>513</DefaultValue>", ""), 2, {1, 2}, NULL},
        {"a hexadecimal number",
         ONE("UDINT", "32", "<DefaultValue>#x01020304</DefaultValue>", ""),
         4,
         {4, 3, 2, 1},
         NULL},
        {"a negative number", ONE("INT", "16", "<DefaultValue>-2</DefaultValue>", ""), 2, {0xFE, 0xFF}, NULL},
        {"not a number", ONE("UINT", "16", "<DefaultValue>1.5</DefaultValue>", ""), 2, {0}, NULL},
        {"a long number",
         ONE("ULINT", "64", "<DefaultValue>#x0102030405060708</DefaultValue>", ""),
         8,
         {8, 7, 6, 5, 4, 3, 2, 1},
         NULL},
        {"a real", ONE("REAL", "32", "<DefaultData>0000803F</DefaultData>", ""), 4, {0, 0, 0x80, 0x3F}, NULL},
        {"a text", ONE("STRING(5)", "40", "<DefaultString>ab</DefaultString>", ""), 5, {'a', 'b'}, NULL},
        {"a text that fills it", ONE("STRING(2)", "16", "<DefaultString>ab</DefaultString>", ""), 2, {'a', 'b'}, NULL},
        {"a text that is too long",
         ONE("STRING(2)", "16", "<DefaultString>abc</DefaultString>", ""),
         2,
         {'a', 'b'},
         NULL},
        {"bytes before a text",
         ONE("STRING(2)", "16",
             "<DefaultData>7879</DefaultData><DefaultString>ab"
             "</DefaultString>",
             ""),
         2,
         {'x', 'y'},
         NULL},
        {"a bit", ONE("BOOL", "1", "<DefaultData>01</DefaultData>", ""), 1, {1}, NULL},
        {"two bits of three",
         ONE("BIT2", "2", "<DefaultData>07</DefaultData>", ""),
         1,
         {3},
         "object 2000:0: its default 0x7 is truncated to 2 bits"},
        {"seven bits", ONE("BIT7", "7", "<DefaultData>7F</DefaultData>", ""), 1, {0x7F}, NULL},
        {"seven bits of eight",
         ONE("BIT7", "7", "<DefaultData>80</DefaultData>", ""),
         1,
         {0},
         "object 2000:0: its default 0x80 is truncated to 7 bits"},
        {"bytes of an array",
         ONE("ARRAY [0..5] OF BYTE", "48", "<DefaultData>010203040506</DefaultData>", ""),
         6,
         {1, 2, 3, 4, 5, 6},
         NULL},
        {"more bytes than an array has",
         ONE("ARRAY [0..5] OF BYTE", "48", "<DefaultData>0102030405060708</DefaultData>", ""),
         6,
         {1, 2, 3, 4, 5, 6},
         NULL},
        {"fewer bytes than an array has",
         ONE("ARRAY [0..5] OF BYTE", "48", "<DefaultData>0102030405</DefaultData>", ""),
         6,
         {1, 2, 3, 4, 5},
         NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        static uint64_t memory[64];
        made_t m = make_text(table[i].what, table[i].text);
        assert_true(device_of(&m)->instance_size <= sizeof memory);
        memset(memory, 0, sizeof memory);
        ect_od_t od = ect_device_od(device_of(&m), memory);
        ect_od_set_defaults(&od);
        uint8_t got[16] = {0};
        const ect_entry_t *entry = &ect_od_find(&od, 0x2000)->entries[0];
        ect_od_read(&od, entry, 0, got, ect_od_bytes(entry));
        if (ect_od_bytes(entry) != table[i].size || memcmp(got, table[i].bytes, table[i].size) != 0)
            fail_msg("%s: expected %zu bytes %02X %02X.., got %u bytes %02X %02X..", table[i].what, table[i].size,
                     table[i].bytes[0], table[i].bytes[1], ect_od_bytes(entry), got[0], got[1]);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

static void limits(void **state)
{
#define LIM(minimum, maximum, initial)                                                                                 \
    "<MinValue>" minimum "</MinValue><MaxValue>" maximum "</MaxValue><DefaultValue>" initial "</DefaultValue>"
    static const struct {
        const char *what, *text;
        bool limited;
        int64_t minimum, maximum;
        const char *note;
    } table[] = {
        {"both", ONE("INT", "16", LIM("-5", "9", "0"), ""), true, -5, 9, NULL},
        {"the default is the lowest", ONE("INT", "16", LIM("-5", "9", "-5"), ""), true, -5, 9, NULL},
        {"the default is the highest", ONE("INT", "16", LIM("-5", "9", "9"), ""), true, -5, 9, NULL},
        {"the whole range", ONE("SINT", "8", LIM("-128", "127", "0"), ""), true, -128, 127, NULL},
        {"the whole range without sign", ONE("USINT", "8", LIM("0", "255", "0"), ""), true, 0, 255, NULL},
        {"the whole of 64 bits", ONE("LINT", "64", "<MinValue>-9223372036854775808</MinValue>", ""), true, INT64_MIN,
         INT64_MAX, NULL},
        {"a minimum alone", ONE("USINT", "8", "<MinValue>0</MinValue>", ""), true, 0, 255, NULL},
        {"a maximum alone", ONE("USINT", "8", "<MaxValue>9</MaxValue>", ""), true, 0, 9, NULL},
        {"none", ONE("USINT", "8", "", ""), false, 0, 0, NULL},
        {"below the type", ONE("SINT", "8", LIM("-129", "9", "0"), ""), false, 0, 0,
         "object 2000:0: its limits -129 to 9 do not fit its type: left out"},
        {"above the type", ONE("USINT", "8", LIM("0", "256", "0"), ""), false, 0, 0,
         "object 2000:0: its limits 0 to 256 do not fit its type: left out"},
        {"the same twice", ONE("USINT", "8", LIM("3", "3", "3"), ""), false, 0, 0,
         "object 2000:0: its limits 3 to 3 do not fit its type: left out"},
        {"a default below", ONE("INT", "16", LIM("-5", "9", "-6"), ""), false, 0, 0,
         "object 2000:0: its default -6 is not within its limits -5 to 9: no limits"},
        {"a default above", ONE("INT", "16", LIM("-5", "9", "10"), ""), false, 0, 0,
         "object 2000:0: its default 10 is not within its limits -5 to 9: no limits"},
        {"a real has none", ONE("REAL", "32", LIM("0", "1", "0"), ""), false, 0, 0, NULL},
        {"a text has none", ONE("STRING(2)", "16", LIM("0", "1", "0"), ""), false, 0, 0, NULL},
        {"empty bytes", ONE("INT", "16", "<MinData></MinData>", ""), false, 0, 0, NULL},
        {"nine bytes", ONE("INT", "16", "<MinData>000000000000000000</MinData>", ""), false, 0, 0, NULL},
        {"not a number in MinValue", ONE("INT", "16", "<MinValue>low</MinValue>", ""), false, 0, 0, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_detail_t *d = ect_od_detail(&od, 0x2000, 0);
        bool limited = d != NULL && d->minimum != d->maximum;
        if (limited != table[i].limited ||
            (limited && (d->minimum != table[i].minimum || d->maximum != table[i].maximum)))
            fail_msg("%s: expected %lld to %lld, got %lld to %lld", table[i].what, (long long)table[i].minimum,
                     (long long)table[i].maximum, d ? (long long)d->minimum : 0, d ? (long long)d->maximum : 0);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

static void units(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t unit;
    } table[] = {
        {"metres", ONE("UINT", "16", "<Unit>#x00010000</Unit>", ""), 0x0001},
        {"with a prefix", ONE("UINT", "16", "<Unit>#xFD010000</Unit>", ""), 0xFD01},
        {"per second", ONE("UINT", "16", "<Unit>#xFD010300</Unit>", ""), 0xFD01},
        {"none", ONE("UINT", "16", "", ""), 0},
        {"no number", ONE("UINT", "16", "<Unit>mm</Unit>", ""), 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_detail_t *d = ect_od_detail(&od, 0x2000, 0);
        if ((d != NULL ? d->unit : 0) != table[i].unit)
            fail_msg("%s: expected %04X, got %04X", table[i].what, table[i].unit, d ? d->unit : 0);
        free_made(&m);
    }
}

/* --- records and arrays ------------------------------------------------------------------------------------------- */

#define ARRAY_OF(base, bits, first, count)                                                                             \
    ESI_DEVICE(DICT(TYPES(                                                                                             \
        "<DataType><Name>TARR</Name><BaseType>" base "</BaseType><BitSize>" bits "</BitSize><ArrayInfo>"               \
        "<LBound>" first "</LBound><Elements>" count "</Elements></ArrayInfo></DataType><DataType><Name>T</Name>"      \
        "<BitSize>80</BitSize>" COUNT "<SubItem><Name>Elements</Name><Type>TARR</Type><BitSize>" bits "</BitSize>"     \
        "</SubItem></DataType>") OBJECTS("<Object><Index>#x2000</Index><Name>R</Name><Type>T</Type><BitSize>80"        \
                                         "</BitSize></Object>")) MAIL COE ESI_EEPROM)

static void records(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t code;
        uint8_t max_subindex;
        uint32_t count; /* default of sub-index 0 */
        uint16_t bits;  /* of the last entry */
        const char *name, *note;
    } table[] = {
        {"a record", RECORD(COUNT ITEM("1", "A", "UINT", "16", ""), "", ""), ECT_OBJECT_RECORD, 1, 1, 16, "A", NULL},
        {"with a gap", RECORD(COUNT ITEM("7", "A", "UINT", "16", ""), "", ""), ECT_OBJECT_RECORD, 7, 7, 16, "A", NULL},
        {"sub-index 0 behind the others", RECORD(ITEM("1", "A", "UINT", "16", "") COUNT, "", ""), ECT_OBJECT_RECORD, 1,
         1, 16, "A", NULL},
        {"the file's number of entries",
         RECORD(COUNT ITEM("1", "A", "UINT", "16", "") ITEM("2", "B", "UINT", "16", ""),
                "<SubItem><Name>SubIndex 000</Name><Info><DefaultData>01</DefaultData></Info></SubItem>", ""),
         ECT_OBJECT_RECORD, 2, 1, 16, "B", NULL},
        {"a number beyond the entries",
         RECORD(COUNT ITEM("1", "A", "UINT", "16", ""),
                "<SubItem><Name>SubIndex 000</Name><Info><DefaultData>09</DefaultData></Info></SubItem>", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A", NULL},
        {"a number of entries without bytes",
         RECORD(COUNT ITEM("1", "A", "UINT", "16", ""),
                "<SubItem><Name>SubIndex 000</Name><Info><DefaultData></DefaultData></Info></SubItem>", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A", NULL},
        {"a number of entries of 8 bytes",
         RECORD(ITEM("0", "N", "ULINT", "64", "") ITEM("1", "A", "UINT", "16", "") ITEM("2", "B", "UINT", "16", ""),
                "<SubItem><Name>N</Name><Info><DefaultValue>1</DefaultValue></Info></SubItem>", ""),
         ECT_OBJECT_RECORD, 2, 1, 16, "B", "object 2000: sub-index 0 is no USINT in the file: the twin uses USINT"},
        {"a number of entries whose second byte counts",
         RECORD(ITEM("0", "N", "UINT", "16", "") ITEM("1", "A", "UINT", "16", ""),
                "<SubItem><Name>N</Name><Info><DefaultData>0001</DefaultData></Info></SubItem>", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A", "object 2000: sub-index 0 is no USINT in the file: the twin uses USINT"},
        {"without sub-index 0", RECORD(ITEM("1", "A", "UINT", "16", "") ITEM("2", "B", "UINT", "8", ""), "", ""),
         ECT_OBJECT_RECORD, 2, 2, 8, "B", NULL},
        {"sub-index 0 of 16 bits", RECORD(ITEM("0", "N", "UINT", "16", "") ITEM("1", "A", "UINT", "16", ""), "", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A", "object 2000: sub-index 0 is no USINT in the file: the twin uses USINT"},
        {"sub-items without a number",
         RECORD("<SubItem><Name>N</Name><Type>USINT</Type><BitSize>8</BitSize></SubItem><SubItem><Name>A</Name>"
                "<Type>UINT</Type><BitSize>16</BitSize></SubItem>",
                "", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A", NULL},
        {"a number twice", RECORD(COUNT ITEM("1", "A", "UINT", "16", "") ITEM("1", "B", "UINT", "16", ""), "", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A",
         "line 2: object 2000: sub-index 1 of type UINT is left out: it exists already"},
        {"the highest number twice",
         RECORD(COUNT ITEM("255", "A", "UINT", "16", "") ITEM("255", "B", "UINT", "16", ""), "", ""), ECT_OBJECT_RECORD,
         255, 255, 16, "A", "line 2: object 2000: sub-index 255 of type UINT is left out: it exists already"},
        {"a number behind the highest",
         RECORD(COUNT ITEM("255", "A", "UINT", "16", "") "<SubItem><Name>B</Name><Type>UINT</Type><BitSize>16</BitSize>"
                                                         "</SubItem>",
                "", ""),
         ECT_OBJECT_RECORD, 255, 255, 16, "A",
         "line 2: object 2000: sub-index 256 of type UINT is left out: 255 is the highest"},
        {"an unknown type", RECORD(COUNT ITEM("1", "A", "UINT", "16", "") ITEM("2", "B", "X", "0", ""), "", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "A",
         "line 2: object 2000: sub-index 2 of type X is left out: its length is not known"},
        {"a name to be shown", RECORD(COUNT ITEM("1", "A", "UINT", "16", "<DisplayName>Shown</DisplayName>"), "", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "Shown", NULL},
        {"the object's name to be shown",
         RECORD(COUNT ITEM("1", "A", "UINT", "16", "<DisplayName>Shown</DisplayName>"),
                "<SubItem><Name>A</Name><Info><DisplayName>Rather</DisplayName></Info></SubItem>", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "Rather", NULL},
        {"an array", ARRAY_OF("UINT", "64", "1", "4"), ECT_OBJECT_ARRAY, 4, 4, 16, "SubIndex 004", NULL},
        {"an array from 0 on begins at 1", ARRAY_OF("UINT", "64", "0", "4"), ECT_OBJECT_ARRAY, 4, 4, 16, "SubIndex 004",
         NULL},
        {"an array from 5 on", ARRAY_OF("USINT", "24", "5", "3"), ECT_OBJECT_ARRAY, 7, 7, 8, "SubIndex 007", NULL},
        {"an array up to 255", ARRAY_OF("USINT", "2400", "1", "300"), ECT_OBJECT_ARRAY, 255, 255, 8, "SubIndex 255",
         NULL},
        {"an array of one element", ARRAY_OF("VENDOR", "16", "1", "1"), ECT_OBJECT_ARRAY, 1, 1, 16, "SubIndex 001",
         NULL},
        {"an array of a type that the file only names", ARRAY_OF("VENDOR", "64", "1", "2"), ECT_OBJECT_ARRAY, 2, 2, 32,
         "SubIndex 002", NULL},
        {"an array of nothing", ARRAY_OF("USINT", "0", "1", "0"), ECT_OBJECT_ARRAY, 0, 0, 8, "SubIndex 000", NULL},
        {"umlauts", RECORD(COUNT ITEM("1", "Gr\u00F6\u00DFe \u00B5m \u20AC", "UINT", "16", ""), "", ""),
         ECT_OBJECT_RECORD, 1, 1, 16, "Groesse um ?", NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, 0x2000);
        assert_non_null(o);
        const ect_entry_t *last = &o->entries[o->last];
        if (o->object_code != table[i].code || o->max_subindex != table[i].max_subindex ||
            ect_od_element(o, 0) != table[i].count || last->bit_length != table[i].bits)
            fail_msg("%s: expected code %u, %u entries, count %u, %u bits, got %u, %u, %u, %u", table[i].what,
                     table[i].code, table[i].max_subindex, (unsigned int)table[i].count, table[i].bits, o->object_code,
                     o->max_subindex, (unsigned int)ect_od_element(o, 0), last->bit_length);
        if (strcmp(last->name, table[i].name) != 0)
            fail_msg("%s: expected the name %s, got %s", table[i].what, table[i].name, last->name);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* An object whose type has no length: a note has the reason, and the other objects exist. */
static void objects_without_entries(void **state)
{
#define OBJECT_OF(index, type, bits)                                                                                   \
    "<Object><Index>" index "</Index><Name>V</Name><Type>" type "</Type><BitSize>" bits "</BitSize></Object>"
    static const uint16_t there[] = {0x1000, 0x1008, 0x1018, 0x1C00, 0x2000, 0x2002};
    (void)state;
    made_t m = make_text("three objects",
                         ESI_DEVICE(DICT(OBJECTS(OBJECT_OF("#x2000", "UINT", "16") OBJECT_OF("#x2001", "X", "0")
                                                     OBJECT_OF("#x2002", "UDINT", "32"))) MAIL COE ESI_EEPROM));
    expect_note("three objects", &m, "line 2: object 2001: sub-index 0 of type X is left out: its length is not known");
    const ect_od_t od = od_of(&m);
    assert_int_equal(od.count, sizeof there / sizeof there[0]);
    for (size_t i = 0; i < od.count; i++)
        assert_int_equal(od.objects[i].index, there[i]);
    assert_int_equal(ect_od_find(&od, 0x2002)->entries[0].bit_length, 32);
    free_made(&m);
}

/* Names decide where they agree, else the place does. */
static void infos(void **state)
{
#define INFO(name, data) "<SubItem><Name>" name "</Name><Info><DefaultData>" data "</DefaultData></Info></SubItem>"
    static const struct {
        const char *what, *text;
        uint32_t first, second;
    } table[] = {
        {"in order",
         RECORD(COUNT ITEM("1", "A", "USINT", "8", "") ITEM("2", "B", "USINT", "8", ""),
                INFO("SubIndex 000", "02") INFO("A", "0A") INFO("B", "0B"), ""),
         0x0A, 0x0B},
        {"in another order",
         RECORD(COUNT ITEM("1", "A", "USINT", "8", "") ITEM("2", "B", "USINT", "8", ""),
                INFO("SubIndex 000", "02") INFO("B", "0B") INFO("A", "0A"), ""),
         0x0A, 0x0B},
        {"by place",
         RECORD(COUNT ITEM("1", "A", "USINT", "8", "") ITEM("2", "B", "USINT", "8", ""),
                INFO("SubIndex 000", "02") INFO("X", "0A") INFO("Y", "0B"), ""),
         0x0A, 0x0B},
        {"too few",
         RECORD(COUNT ITEM("1", "A", "USINT", "8", "") ITEM("2", "B", "USINT", "8", ""),
                INFO("SubIndex 000", "02") INFO("A", "0A"), ""),
         0x0A, 0},
        {"of the type",
         RECORD(COUNT ITEM("1", "A", "USINT", "8", "<DefaultData>07</DefaultData>")
                    ITEM("2", "B", "USINT", "8", "<DefaultData>08</DefaultData>"),
                INFO("SubIndex 000", "02") INFO("A", "0A"), ""),
         0x0A, 0x08},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, 0x2000);
        if (ect_od_element(o, 1) != table[i].first || ect_od_element(o, 2) != table[i].second)
            fail_msg("%s: expected %02X and %02X, got %02X and %02X", table[i].what, (unsigned int)table[i].first,
                     (unsigned int)table[i].second, (unsigned int)ect_od_element(o, 1),
                     (unsigned int)ect_od_element(o, 2));
        free_made(&m);
    }
}

/* --- PDOs --------------------------------------------------------------------------------------------------------- */

#define ENTRY(index, sub, bits, name, type)                                                                            \
    "<Entry><Index>" index "</Index><SubIndex>" sub "</SubIndex><BitLen>" bits "</BitLen><Name>" name                  \
    "</Name><DataType>" type "</DataType></Entry>"
#define GAP(bits)                 "<Entry><Index>0</Index><BitLen>" bits "</BitLen></Entry>"
#define TX(attributes, index, in) "<TxPdo " attributes "><Index>" index "</Index><Name>P</Name>" in "</TxPdo>"
#define RX(attributes, index, in) "<RxPdo " attributes "><Index>" index "</Index><Name>Q</Name>" in "</RxPdo>"
#define A8                        ENTRY("#x6000", "1", "8", "A", "USINT")
#define B8                        ENTRY("#x6000", "2", "8", "B", "USINT")
#define O8                        ENTRY("#x7000", "1", "8", "O", "USINT")
#define PLAIN(body)               ESI_DEVICE(MAIL ESI_PROCESS_SMS body COE ESI_EEPROM)
#define PLAIN_HEAD                                                                                                     \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>DEV</Type><Name>A "                      \
             "device</Name>" MAIL ESI_PROCESS_SMS "<TxPdo Sm='3'><Index>#x1A00</Index><Name>P</Name><Exclude>"
#define PLAIN_TAIL   "</Exclude>" A8 "</TxPdo>" TX("", "#x1A01", B8) COE ESI_EEPROM "</Device>" ESI_TAIL
#define ASSIGN(body) ESI_DEVICE(MAIL ESI_PROCESS_SMS body "<Mailbox><CoE PdoAssign='1'/></Mailbox>" ESI_EEPROM)

/* A file may exclude a PDO that it does not contain, another object, or the PDO itself: none of these is an exclusion.
 */
static void exclusions(void **state)
{
    static const struct {
        const char *what, *excluded;
        uint16_t expected; /* 0: none */
    } table[] = {
        {"another PDO", "#x1A01", 0x1A01}, {"a missing PDO", "#x1A02", 0}, {"itself", "#x1A00", 0},
        {"an object", "#x1018", 0},        {"an assignment", "#x1C13", 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[3000];
        (void)snprintf(text, sizeof text, "%s%s%s", PLAIN_HEAD, table[i].excluded, PLAIN_TAIL);
        made_t m = make_text(table[i].what, text);
        const ect_device_t *device = device_of(&m);
        uint16_t got = 0;
        for (unsigned int k = 0; k < device->pdo_count; k++) {
            const ect_pdo_t *pdo = &device->pdos[k];
            got = pdo->index == 0x1A00 && pdo->excludes != NULL ? pdo->excludes[0] : got;
        }
        if (got != table[i].expected)
            fail_msg("%s: expected %04X, got %04X", table[i].what, table[i].expected, got);
        free_made(&m);
    }
}

/* An entry that PDOs map in several ways has the type of the longest one, of the first one of these. */
static void types_of_mapped_entries(void **state)
{
#define TWICE(bits1, type1, bits2, type2)                                                                              \
    PLAIN(TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", bits1, "A", type1) ENTRY("#x6000", "1", bits2, "A", type2)))
    static const struct {
        const char *what, *text;
        uint16_t type, bits;
    } table[] = {
        {"8 bits, then 16", TWICE("8", "USINT", "16", "INT"), ECT_TYPE_INTEGER16, 16},
        {"16 bits, then 8", TWICE("16", "INT", "8", "USINT"), ECT_TYPE_INTEGER16, 16},
        {"two types of 16 bits", TWICE("16", "INT", "16", "UINT"), ECT_TYPE_INTEGER16, 16},
        {"two types of 32 bits", TWICE("32", "REAL", "32", "DINT"), ECT_TYPE_REAL32, 32},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_entry_t *e = ect_od_entry(ect_od_find(&od, 0x6000), 1);
        assert_non_null(e);
        if (e->data_type != table[i].type || e->bit_length != table[i].bits)
            fail_msg("%s: expected type %04X of %u bits, got %04X of %u", table[i].what, table[i].type, table[i].bits,
                     e->data_type, e->bit_length);
        free_made(&m);
    }
}

static void mappings(void **state)
{
    static const struct {
        const char *what, *text;
        uint32_t bits;        /* of SyncManager 3 */
        uint32_t elements[4]; /* of 1A00h */
        const char *note;
    } table[] = {
        {"two entries", PLAIN(TX("Sm='3'", "#x1A00", A8 B8)), 16, {0x60000108, 0x60000208}, NULL},
        {"a gap", PLAIN(TX("Sm='3'", "#x1A00", A8 GAP("8") B8)), 24, {0x60000108, 8, 0x60000208}, NULL},
        {"a long gap", PLAIN(TX("Sm='3'", "#x1A00", GAP("600"))), 600, {255, 255, 90}, NULL},
        {"a gap of 255", PLAIN(TX("Sm='3'", "#x1A00", GAP("255") A8)), 263, {255, 0x60000108}, NULL},
        {"a value without sub-index",
         PLAIN(TX("Sm='3'", "#x1A00", ENTRY("#x6041", "0", "16", "S", "UINT"))),
         16,
         {0x60410010},
         NULL},
        {"an entry twice", PLAIN(TX("Sm='3'", "#x1A00", A8 A8)), 16, {0x60000108, 0x60000108}, NULL},
        {"an entry at two lengths",
         PLAIN(TX("Sm='3'", "#x1A00", A8 ENTRY("#x6000", "1", "16", "A", "UINT"))),
         24,
         {0x60000108, 0x60000110},
         NULL},
        {"the number of entries behind an entry",
         PLAIN(TX("Sm='3'", "#x1A00", A8 ENTRY("#x6000", "0", "8", "N", "USINT"))),
         16,
         {0x60000108, 0x60000008},
         NULL},
        {"one bit of the number of entries",
         PLAIN(TX("Sm='3'", "#x1A00", A8 ENTRY("#x6000", "0", "1", "N", "BOOL"))),
         9,
         {0x60000108, 0x60000001},
         NULL},
        {"nine bits of the number of entries",
         PLAIN(TX("Sm='3'", "#x1A00", A8 ENTRY("#x6000", "0", "9", "N", "UINT"))),
         17,
         {0x60000108, 9},
         "line 2: PDO 1A00 maps 9 bits of 6000:0, which has 8: they are a gap"},
        {"not assigned", PLAIN(TX("", "#x1A00", A8)), 0, {0x60000108}, NULL},
        {"samples",
         PLAIN(TX("Sm='3' OSFac='4'", "#x1A00", A8)),
         8,
         {0x60000108},
         "line 2: PDO 1A00 has 4 samples in a cycle with the file's default; the twin has 1"},
        {"assigned to the outputs",
         PLAIN(TX("Sm='2'", "#x1A00", A8)),
         0,
         {0x60000108},
         "line 2: PDO 1A00 is assigned to SyncManager 2, which is not one for inputs"},
        {"assigned to none there is",
         PLAIN(TX("Sm='4'", "#x1A00", A8)),
         0,
         {0x60000108},
         "line 2: PDO 1A00 is assigned to SyncManager 4, which is not one for inputs"},
        {"there twice",
         PLAIN(TX("Sm='3'", "#x1A00", A8) TX("Sm='3'", "#x1A00", B8)),
         8,
         {0x60000108},
         "line 2: PDO 1A00 occurs twice: the first one is used"},
        {"with a PDO that it excludes",
         PLAIN(TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude>" A8) TX("Sm='3'", "#x1A01", B8)),
         8,
         {0x60000108},
         "line 2: PDO 1A01 is assigned beside 1A00, which it excludes: it is not"},
        {"with a PDO that excludes it",
         PLAIN(TX("Sm='3'", "#x1A00", A8) TX("Sm='3'", "#x1A01", "<Exclude>#x1A00</Exclude>" B8)),
         8,
         {0x60000108},
         "line 2: PDO 1A01 is assigned beside 1A00, which it excludes: it is not"},
        {"an index of none",
         PLAIN(TX("Sm='3'", "#x1A00", A8) TX("", "#x1C00", B8)),
         8,
         {0x60000108},
         "line 2: PDO 1C00 (P) is left out: its index is not that of a PDO of inputs"},
        {"virtual, of no SyncManager",
         PLAIN(TX("Sm='3'", "#x1A00", A8) TX("Virtual='1'", "#x1A01", B8)),
         8,
         {0x60000108},
         "line 2: PDO 1A01 (P) is left out: it maps registers of the controller, and no virtual "
         "SyncManager has it"},
        {"an entry of 256 bits",
         PLAIN(TX("Sm='3'", "#x1A00", A8) TX("", "#x1A01", ENTRY("#x6001", "1", "256", "L", "ARRAY [0..31] OF BYTE"))),
         8,
         {0x60000108},
         "line 2: PDO 1A01 (P) is left out: an entry can map at most 255 bits"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *pdo = ect_od_find(&od, 0x1A00);
        if (ect_od_sm_bits(&od, 3) != table[i].bits)
            fail_msg("%s: expected %u bits, got %u", table[i].what, (unsigned int)table[i].bits,
                     (unsigned int)ect_od_sm_bits(&od, 3));
        for (uint32_t n = 0; n < 4; n++) {
            if (ect_od_element(pdo, n + 1) != table[i].elements[n])
                fail_msg("%s: element %u: expected %08X, got %08X", table[i].what, (unsigned int)n + 1,
                         (unsigned int)table[i].elements[n], (unsigned int)ect_od_element(pdo, n + 1));
        }
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* An entry that a PDO maps and the dictionary has not; `dictionary` has 6000h with sub-index 0 and 1, of 8 bits. */
static void entries_that_pdos_add(void **state)
{
#define HELD(info)                                                                                                     \
    "<Profile><Dictionary><DataTypes><DataType><Name>T</Name><BitSize>24</BitSize>" COUNT ITEM(                        \
        "1", "A", "USINT", "8", "") "</DataType></DataTypes><Objects><Object><Index>#x6000</Index><Name>R</"           \
                                    "Name><Type>T</Type><BitSize>24</BitSize>"                                         \
                                    "<Info>" info "</Info></Object></Objects></Dictionary></Profile>"
#define ADDED(info, pdo) ESI_DEVICE(HELD(info) MAIL ESI_PROCESS_SMS pdo COE ESI_EEPROM)
    static const struct {
        const char *what, *text;
        uint8_t count, last;
        uint16_t bits; /* of the last entry */
    } table[] = {
        {"an entry that is there", ADDED("", TX("Sm='3'", "#x1A00", A8)), 1, 1, 8},
        {"an entry behind", ADDED("", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "5", "16", "V", "INT"))), 5, 5, 16},
        {"two entries behind, the last one first",
         ADDED("", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "5", "16", "V", "INT") B8)), 5, 5, 16},
        {"an existing entry, longer", ADDED("", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", "16", "A", "UINT"))), 1, 1,
         16},
        {"an existing entry, shorter", ADDED("", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", "4", "A", "BIT4"))), 1, 1,
         8},
        {"the number of entries", ADDED("", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "0", "8", "N", "USINT"))), 1, 1, 8},
        {"sub-index 255", ADDED("", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "255", "1", "V", "BOOL"))), 255, 255, 1},
        {"an entry behind a count of 0",
         ADDED("<SubItem><Name>SubIndex 000</Name><Info><DefaultData>00</DefaultData></Info></SubItem>",
               TX("Sm='3'", "#x1A00", ENTRY("#x6000", "3", "16", "V", "INT"))),
         3, 3, 16},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, 0x6000);
        const ect_entry_t *last = ect_od_last(o);
        if (ect_od_element(o, 0) != table[i].count || last->subindex != table[i].last ||
            last->bit_length != table[i].bits)
            fail_msg("%s: expected a count of %u, sub-index %u of %u bits, got %u, %u of %u", table[i].what,
                     table[i].count, table[i].last, table[i].bits, (unsigned int)ect_od_element(o, 0), last->subindex,
                     last->bit_length);
        expect_note(table[i].what, &m, NULL);
        free_made(&m);
    }
}

/* The type's sub-item supplies the values that the object's own info lacks. */
static void infos_of_types(void **state)
{
#define TYPED_INFO(type, object)                                                                                       \
    RECORD(COUNT ITEM("1", "A", "UINT", "16", type), "<SubItem><Name>A</Name><Info>" object "</Info></SubItem>", "")
    static const struct {
        const char *what, *text;
        uint16_t unit;
        uint8_t per;
        int64_t minimum, maximum;
        uint32_t value;
    } table[] = {
        {"a unit of the type", TYPED_INFO("<Unit>#xFD010300</Unit>", "<DefaultData>0500</DefaultData>"), 0xFD01, 3, 0,
         0, 5},
        {"a unit of the object", TYPED_INFO("<Unit>#xFD010300</Unit>", "<Unit>#x00020100</Unit>"), 2, 1, 0, 0, 0},
        {"a unit of both parts of 16 bits", TYPED_INFO("", "<Unit>#x12345600</Unit>"), 0x1234, 0x56, 0, 0, 0},
        {"a minimum of the type, a maximum of the object",
         TYPED_INFO("<MinValue>1</MinValue><DefaultData>0200</DefaultData>", "<MaxValue>9</MaxValue>"), 0, 0, 1, 9, 2},
        {"limits of both",
         TYPED_INFO("<MinValue>1</MinValue><MaxValue>5</MaxValue>",
                    "<MinValue>2</MinValue><MaxValue>6</MaxValue><DefaultData>0300</DefaultData>"),
         0, 0, 2, 6, 3},
        {"a default of both", TYPED_INFO("<DefaultData>0700</DefaultData>", "<DefaultData>0800</DefaultData>"), 0, 0, 0,
         0, 8},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        static const ect_detail_t none;
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_detail_t *found = ect_od_detail(&od, 0x2000, 1), *d = found != NULL ? found : &none;
        uint32_t value = ect_od_element(ect_od_find(&od, 0x2000), 1);
        if (d->unit != table[i].unit || d->per != table[i].per || d->minimum != table[i].minimum ||
            d->maximum != table[i].maximum || value != table[i].value)
            fail_msg("%s: expected %04X per %u, %lld to %lld, %u, got %04X per %u, %lld to %lld, %u", table[i].what,
                     table[i].unit, table[i].per, (long long)table[i].minimum, (long long)table[i].maximum,
                     (unsigned int)table[i].value, d->unit, d->per, (long long)d->minimum, (long long)d->maximum,
                     (unsigned int)value);
        free_made(&m);
    }
}

/* Devices that no ESC can be, or whose process data would differ from the file's. */
static void refusals(void **state)
{
#define SM(start, control, role) "<Sm StartAddress='" start "' ControlByte='" control "'>" role "</Sm>"
    static const struct {
        const char *what, *text, *why;
    } table[] = {
        {"an index of outputs for inputs", PLAIN(TX("Sm='3'", "#x1600", A8)),
         "line 2: PDO 1600 (P) is assigned to SyncManager 3, and its index is not that of a PDO of inputs"},
        {"an index of inputs for outputs", PLAIN(RX("Sm='2'", "#x1A00", O8)),
         "line 2: PDO 1A00 (Q) is assigned to SyncManager 2, and its index is not that of a PDO of outputs"},
        {"an index just below those of inputs", PLAIN(TX("Sm='3'", "#x19FF", A8)),
         "line 2: PDO 19FF (P) is assigned to SyncManager 3, and its index is not that of a PDO of inputs"},
        {"an index just above those of inputs", PLAIN(TX("Sm='3'", "#x1C00", A8)),
         "line 2: PDO 1C00 (P) is assigned to SyncManager 3, and its index is not that of a PDO of inputs"},
        {"an index just below those of outputs", PLAIN(RX("Sm='2'", "#x15FF", O8)),
         "line 2: PDO 15FF (Q) is assigned to SyncManager 2, and its index is not that of a PDO of outputs"},
        {"an index just above those of outputs", PLAIN(RX("Sm='2'", "#x1800", O8)),
         "line 2: PDO 1800 (Q) is assigned to SyncManager 2, and its index is not that of a PDO of outputs"},
        {"an entry of 256 bits at the first SyncManager",
         ESI_DEVICE(SM("#x1000", "0", "Inputs")
                        TX("Sm='0'", "#x1A00", ENTRY("#x6001", "1", "256", "L", "ARRAY [0..31] OF BYTE")) ESI_EEPROM),
         "is assigned to SyncManager 0, and an entry can map at most 255 bits"},
        {"an assigned entry of 256 bits",
         PLAIN(TX("Sm='3'", "#x1A00", ENTRY("#x6001", "1", "256", "L", "ARRAY [0..31] OF BYTE"))),
         "and an entry can map at most 255 bits"},
        {"nine SyncManagers",
         ESI_DEVICE(SM("#x1000", "0", "Inputs") SM("#x1100", "0", "Inputs") SM("#x1200", "0", "Inputs") SM(
             "#x1300", "0", "Inputs") SM("#x1400", "0", "Inputs") SM("#x1500", "0", "Inputs")
                        SM("#x1600", "0", "Inputs") SM("#x1700", "0", "Inputs") SM("#x1800", "0", "Inputs") ESI_EEPROM),
         "it has 9 SyncManagers; the chips here have at most 8"},
        {"among the registers", ESI_DEVICE(SM("#x0800", "0", "Inputs") TX("Sm='0'", "#x1A00", A8) ESI_EEPROM),
         "line 2: SyncManager 0 begins at 0x0800, where there are registers"},
        {"just before the outputs' registers",
         ESI_DEVICE(SM("#x0EFF", "0", "Inputs") TX("Sm='0'", "#x1A00", A8) ESI_EEPROM),
         "SyncManager 0 begins at 0x0EFF, where there are registers"},
        {"more than a frame takes", PLAIN(TX("Sm='3'", "#x1A00", GAP("11889"))),
         "SyncManager 3 has 1487 bytes by default; a frame takes 1486"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = try_text(table[i].text);
        if (m.twin != NULL || strstr(m.why, table[i].why) == NULL)
            fail_msg("%s: expected \"%s\", got \"%s\"", table[i].what, table[i].why, m.twin ? "a twin" : m.why);
        free_made(&m);
    }
}

static void assignments(void **state)
{
    static const struct {
        const char *what, *text;
        uint8_t capacity; /* of 1C13h */
        bool writable;
        const char *name;
    } table[] = {
        {"fixed", PLAIN(TX("Sm='3'", "#x1A00", A8) TX("", "#x1A01", B8)), 1, false, "SyncManager 3 PDO assignment"},
        {"to be chosen", ASSIGN(TX("Sm='3'", "#x1A00", A8) TX("", "#x1A01", B8)), 2, true,
         "SyncManager 3 PDO assignment"},
        {"one of two",
         ASSIGN(TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude>" A8)
                    TX("", "#x1A01", "<Exclude>#x1A00</Exclude>" B8)),
         1, true, "SyncManager 3 PDO assignment"},
        {"one of two, and another",
         ASSIGN(TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude>" A8) TX("", "#x1A01", "<Exclude>#x1A00</Exclude>" B8)
                    TX("", "#x1A02", B8)),
         2, true, "SyncManager 3 PDO assignment"},
        {"one of three",
         ASSIGN(TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude><Exclude>#x1A02</Exclude>" A8)
                    TX("", "#x1A01", "<Exclude>#x1A02</Exclude>" B8) TX("", "#x1A02", B8)),
         1, true, "SyncManager 3 PDO assignment"},
        {"the second, or the first and the third",
         ASSIGN(TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude>" A8) TX("", "#x1A01", B8)
                    TX("", "#x1A02", "<Exclude>#x1A01</Exclude>" B8)),
         2, true, "SyncManager 3 PDO assignment"},
        {"the first or the third, and the second",
         ASSIGN(TX("Sm='3'", "#x1A00", "<Exclude>#x1A02</Exclude>" A8) TX("", "#x1A01", B8) TX("", "#x1A02", B8)), 2,
         true, "SyncManager 3 PDO assignment"},
        {"a PDO of another SyncManager", ASSIGN(TX("Sm='3'", "#x1A00", A8) TX("Sm='2'", "#x1A01", B8)), 1, true,
         "SyncManager 3 PDO assignment"},
        {"a PDO of the other direction", ASSIGN(TX("Sm='3'", "#x1A00", A8) RX("", "#x1600", O8)), 1, true,
         "SyncManager 3 PDO assignment"},
        {"a PDO that is left out", ASSIGN(TX("Sm='3'", "#x1A00", A8) TX("", "#x1C00", B8)), 1, true,
         "SyncManager 3 PDO assignment"},
        {"none", ASSIGN(""), 0, true, "SyncManager 3 PDO assignment"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, 0x1C13);
        assert_non_null(o);
        bool writable = (o->entries[0].access & ECT_ACCESS_WO) != 0;
        if (o->max_subindex != table[i].capacity || writable != table[i].writable ||
            strcmp(o->name, table[i].name) != 0)
            fail_msg("%s: expected %u elements, writable %d, \"%s\", got %u, %d, \"%s\"", table[i].what,
                     table[i].capacity, table[i].writable, table[i].name, o->max_subindex, writable, o->name);
        free_made(&m);
    }
}

/* The longest data of a SyncManager: the longest assignment, the file's sizes, and the room before the next. */
static void rooms_of_sms(void **state)
{
#define INPUTS(attributes) "<Sm StartAddress='#x1400' ControlByte='#x20' " attributes ">Inputs</Sm>"
#define OUTPUTS            "<Sm StartAddress='#x1100' ControlByte='#x24'>Outputs</Sm>"
#define WRITABLE(index, type, bits)                                                                                    \
    "<Profile><Dictionary><DataTypes><DataType><Name>T</Name><BitSize>48</BitSize><SubItem><SubIdx>0</SubIdx>"         \
    "<Name>Number</Name><Type>USINT</Type><BitSize>8</BitSize><Flags><Access>rw</Access></Flags></SubItem><SubItem>"   \
    "<SubIdx>1</SubIdx><Name>First</Name><Type>" type "</Type><BitSize>" bits "</BitSize><Flags><Access>rw</Access>"   \
    "</Flags></SubItem></DataType></DataTypes><Objects><Object><Index>" index "</Index><Name>O</Name><Type>T</Type>"   \
    "<BitSize>48</BitSize></Object></Objects></Dictionary></Profile>"
#define BUILT(sms, pdos, coe) ESI_DEVICE(MAIL sms pdos "<Mailbox><CoE " coe "/></Mailbox>" ESI_EEPROM)
    static const struct {
        const char *what, *text;
        unsigned int sm, maximum;
    } table[] = {
        {"fixed", BUILT(OUTPUTS INPUTS(""), TX("Sm='3'", "#x1A00", A8), ""), 3, 1},
        {"all PDOs of that direction",
         BUILT(OUTPUTS INPUTS(""), TX("Sm='3'", "#x1A00", A8) TX("", "#x1A01", A8 B8), ""), 3, 3},
        {"the longer of two",
         BUILT(OUTPUTS INPUTS(""), TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude>" A8) TX("", "#x1A01", A8 B8), ""),
         3, 2},
        {"the longer of the first and the third, and the second",
         BUILT(OUTPUTS INPUTS(""),
               TX("Sm='3'", "#x1A00", "<Exclude>#x1A02</Exclude>" A8) TX("", "#x1A01", A8 B8)
                   TX("", "#x1A02", A8 B8 ENTRY("#x6000", "3", "8", "C", "USINT")),
               ""),
         3, 5},
        {"the longest of three",
         BUILT(OUTPUTS INPUTS(""),
               TX("Sm='3'", "#x1A00", "<Exclude>#x1A01</Exclude><Exclude>#x1A02</Exclude>" A8)
                   TX("", "#x1A01", "<Exclude>#x1A02</Exclude>" A8 B8) TX("", "#x1A02", A8),
               ""),
         3, 2},
        {"MaxSize of a fixed one", BUILT(OUTPUTS INPUTS("MaxSize='9'"), TX("Sm='3'", "#x1A00", A8), ""), 3, 1},
        {"MaxSize of one to be mapped",
         BUILT(OUTPUTS INPUTS("MaxSize='9'"), TX("Sm='3'", "#x1A00", A8), "PdoConfig='1'"), 3, 9},
        {"MaxSize of one whose 1C13h can be written, which the file does not announce",
         BUILT(OUTPUTS INPUTS("MaxSize='9'"), TX("Sm='3'", "#x1A00", A8) WRITABLE("#x1C13", "UINT", "16"), ""), 3, 9},
        {"MaxSize of one whose 1A00h can be written, which the file does not announce",
         BUILT(OUTPUTS INPUTS("MaxSize='9'"), TX("Sm='3'", "#x1A00", A8) WRITABLE("#x1A00", "UDINT", "32"), ""), 3, 9},
        {"one to be mapped, without MaxSize: three buffers up to the end of 8 KB",
         BUILT("<Sm StartAddress='#x2800' ControlByte='#x24' DefaultSize='7'>Outputs</Sm>", RX("Sm='2'", "#x1600", O8),
               "PdoConfig='1'"),
         2, 0x800 / 3},
        {"one to be mapped, behind 8 KB",
         BUILT("<Sm StartAddress='#x3000' ControlByte='#x24'>Outputs</Sm>" INPUTS(""), RX("Sm='2'", "#x1600", O8),
               "PdoConfig='1'"),
         2, 1},
        {"DefaultSize of one to be assigned",
         BUILT(OUTPUTS INPUTS("DefaultSize='7' MaxSize='2'"), TX("Sm='3'", "#x1A00", A8), "PdoAssign='1'"), 3, 7},
        {"the room before the next, in three buffers",
         BUILT(OUTPUTS INPUTS("MaxSize='9'"), RX("Sm='2'", "#x1600", O8), "PdoConfig='1'"), 2, 0x300 / 3},
        {"two bytes before the next, in three buffers",
         BUILT("<Sm StartAddress='#x13FA' ControlByte='#x24' MaxSize='9'>Outputs</Sm>" INPUTS(""),
               RX("Sm='2'", "#x1600", O8), "PdoConfig='1'"),
         2, 2},
        {"six bytes before the next, in one buffer",
         BUILT("<Sm StartAddress='#x13FA' ControlByte='#x26' MaxSize='9'>Outputs</Sm>" INPUTS(""),
               RX("Sm='2'", "#x1600", O8), "PdoConfig='1'"),
         2, 6},
        {"a frame's room", BUILT(OUTPUTS INPUTS("MaxSize='2000'"), TX("Sm='3'", "#x1A00", A8), "PdoConfig='1'"), 3,
         1486},
        {"a mailbox", BUILT(OUTPUTS INPUTS(""), "", ""), 0, 128},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        if (device_of(&m)->sm[table[i].sm].maximum != table[i].maximum)
            fail_msg("%s: expected at most %u, got %u", table[i].what, table[i].maximum,
                     device_of(&m)->sm[table[i].sm].maximum);
        free_made(&m);
    }
}

static void long_mailboxes(void **state)
{
#define MAILBOX(most)                                                                                                  \
    ESI_DEVICE(                                                                                                        \
        "<Sm DefaultSize='128' MaxSize='" most "' StartAddress='#x1000' ControlByte='#x26' Enable='1'>MBoxOut"         \
        "</Sm><Sm DefaultSize='128' StartAddress='#x1800' ControlByte='#x22' Enable='1'>MBoxIn</Sm>" COE ESI_EEPROM)
    static const struct {
        const char *what, *text, *note;
        unsigned int maximum;
    } table[] = {
        {"a frame less one", MAILBOX("1485"), NULL, 1485},
        {"a frame", MAILBOX("1486"), NULL, 1486},
        {"more than a frame", MAILBOX("1487"),
         "line 2: a mailbox of 1487 bytes does not fit a frame; the twin's has at most 1486", 1486},
        {"more than the gap to the next SyncManager", MAILBOX("3000"),
         "line 2: a mailbox of 2048 bytes does not fit a frame; the twin's has at most 1486", 1486},
        {"less than the default", MAILBOX("64"), NULL, 128},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        if (device_of(&m)->sm[0].maximum != table[i].maximum)
            fail_msg("%s: expected at most %u, got %u", table[i].what, table[i].maximum, device_of(&m)->sm[0].maximum);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* --- identity and the rest ---------------------------------------------------------------------------------------- */

static void names_of_devices(void **state)
{
#define CALLED(type)                                                                                                   \
    ESI_HEAD "<Device Physics='YY'><Type ProductCode='1' RevisionNo='1'>" type "</Type></Device>" ESI_TAIL
    static const struct {
        const char *text, *name, *type;
    } table[] = {
        {CALLED("EL1008"), "el1008", "EL1008"},
        {CALLED("EL1008-0010"), "el1008-0010", "EL1008-0010"},
        {CALLED("A  B"), "a-b", "A  B"},
        {CALLED("(X)"), "x", "(X)"},
        {CALLED("X_"), "x", "X_"},
        {CALLED("\u00DC1"), "1", "Ue1"},
        {CALLED("AZaz09"), "azaz09", "AZaz09"},
        {CALLED("1@2[3`4{5/6:7"), "1-2-3-4-5-6-7", "1@2[3`4{5/6:7"},
        {CALLED("+"), "esi", "+"},
        {CALLED("0123456789012345678901234567890123456789xx"), "0123456789012345678901234567890123456789",
         "0123456789012345678901234567890123456789"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].text, table[i].text);
        if (strcmp(device_of(&m)->name, table[i].name) != 0 || strcmp(device_of(&m)->type_name, table[i].type) != 0)
            fail_msg("%s: expected %s, %s, got %s, %s", table[i].text, table[i].name, table[i].type,
                     device_of(&m)->name, device_of(&m)->type_name);
        assert_string_equal(device_of(&m)->group_type, "unnamed");
        free_made(&m);
    }
}

static void ports_of_physics(void **state)
{
#define PHYSICS(letters)                                                                                               \
    ESI_HEAD "<Device Physics='" letters "'><Type ProductCode='1' RevisionNo='1'>D</Type></Device>" ESI_TAIL
    static const struct {
        const char *text, *ports;
        bool note;
    } table[] = {
        {PHYSICS("YY"), "YY", false},     {PHYSICS("K"), "K", false},   {PHYSICS("YKYK"), "YKYK", false},
        {PHYSICS("YYYYY"), "YYYY", true}, {PHYSICS("YXK"), "YK", true}, {PHYSICS(""), "YY", false},
        {PHYSICS("Y H"), "Y H", false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].text, table[i].text);
        bool note = note_of(&m, "its Physics") != NULL;
        if (strcmp(device_of(&m)->physics, table[i].ports) != 0 || note != table[i].note)
            fail_msg("%s: expected %s, note %d, got %s, %d", table[i].text, table[i].ports, table[i].note,
                     device_of(&m)->physics, note);
        free_made(&m);
    }
}

static void timeouts(void **state)
{
#define TIMEOUT(in) ESI_DEVICE("<Info><StateMachine><Timeout>" in "</Timeout></StateMachine></Info>" ESI_EEPROM)
    static const struct {
        const char *text;
        ect_timeouts_t expected;
    } table[] = {
        {ESI_DEVICE(ESI_EEPROM), {3000, 10000, 5000, 200, 0, 0}},
        {TIMEOUT("<PreopTimeout>1</PreopTimeout>"), {1, 10000, 5000, 200, 0, 0}},
        {TIMEOUT("<SafeopOpTimeout>2</SafeopOpTimeout>"), {3000, 2, 5000, 200, 0, 0}},
        {TIMEOUT("<BackToInitTimeout>3</BackToInitTimeout>"), {3000, 10000, 3, 200, 0, 0}},
        {TIMEOUT("<BackToSafeopTimeout>4</BackToSafeopTimeout>"), {3000, 10000, 5000, 4, 0, 0}},
        {TIMEOUT("<PreopTimeout>65535</PreopTimeout>"), {65535, 10000, 5000, 200, 0, 0}},
        {TIMEOUT("<PreopTimeout>65536</PreopTimeout>"), {65535, 10000, 5000, 200, 0, 0}},
        {TIMEOUT("<PreopTimeout>0</PreopTimeout>"), {3000, 10000, 5000, 200, 0, 0}},
        {ESI_DEVICE("<Info><Mailbox><Timeout><RequestTimeout>5</RequestTimeout><ResponseTimeout>6</ResponseTimeout>"
                    "</Timeout></Mailbox></Info>" ESI_EEPROM),
         {3000, 10000, 5000, 200, 5, 6}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text("timeouts", table[i].text);
        const ect_timeouts_t *t = &device_of(&m)->timeouts, *e = &table[i].expected;
        if (memcmp(t, e, sizeof *t) != 0)
            fail_msg("%zu: expected %u %u %u %u %u %u, got %u %u %u %u %u %u", i, e->preop_ms, e->safeop_op_ms,
                     e->back_to_init_ms, e->back_to_safeop_ms, e->mailbox_request_ms, e->mailbox_response_ms,
                     t->preop_ms, t->safeop_op_ms, t->back_to_init_ms, t->back_to_safeop_ms, t->mailbox_request_ms,
                     t->mailbox_response_ms);
        free_made(&m);
    }
}

static void protocols(void **state)
{
#define PROTOCOLS(in) ESI_DEVICE(MAIL "<Mailbox>" in "</Mailbox>" ESI_EEPROM)
    static const struct {
        const char *what, *text;
        uint8_t protocols, details, served;
        const char *note;
    } table[] = {
        {"none", ESI_DEVICE(ESI_EEPROM), 0, 0, 0, NULL},
        {"CoE", PROTOCOLS("<CoE/>"), ECT_MAILBOX_COE, ECT_COE_SDO, 2, NULL},
        {"information", PROTOCOLS("<CoE SdoInfo='1'/>"), ECT_MAILBOX_COE, ECT_COE_SDO | ECT_COE_SDO_INFO, 3, NULL},
        {"all of CoE", PROTOCOLS("<CoE SdoInfo='true' PdoAssign='1' PdoConfig='1' PdoUpload='1' CompleteAccess='1'/>"),
         ECT_MAILBOX_COE, 0x3F, 3, NULL},
        {"AoE, which is served", PROTOCOLS("<AoE/>"), ECT_MAILBOX_AOE, 0, 1, NULL},
        {"EoE, which is served", PROTOCOLS("<EoE/>"), ECT_MAILBOX_EOE, 0, 1, NULL},
        {"EoE and FoE", PROTOCOLS("<EoE/><FoE/>"), ECT_MAILBOX_EOE | ECT_MAILBOX_FOE, 0, 2,
         "FoE answered with \"unsupported protocol\""},
        {"SoE and VoE beside CoE", PROTOCOLS("<CoE/><SoE/><VoE/>"), ECT_MAILBOX_COE | ECT_MAILBOX_SOE | ECT_MAILBOX_VOE,
         ECT_COE_SDO, 4, "VoE answered with \"unsupported protocol\""},
        {"without SyncManagers", ESI_DEVICE("<Mailbox><CoE/></Mailbox>" ESI_EEPROM), 0, 0, 0,
         "it has mailbox protocols and no mailbox SyncManagers 0 and 1: the device has no mailbox"},
        {"SyncManagers without protocols", ESI_DEVICE(MAIL ESI_EEPROM), 0, 0, 0,
         "line 2: SyncManager 0 is for a mailbox, and the device has none: it is unused (and 1 more like it)"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_device_t *d = device_of(&m);
        unsigned int served = 0;
        while (d->protocols != NULL && d->protocols[served] != NULL)
            served++;
        if (d->mailbox_protocols != table[i].protocols || d->coe_details != table[i].details ||
            served != table[i].served)
            fail_msg("%s: expected %02X, %02X, %u served, got %02X, %02X, %u", table[i].what, table[i].protocols,
                     table[i].details, table[i].served, d->mailbox_protocols, d->coe_details, served);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* xs:hexBinary has digits of either case. */
static void hexadecimal_digits(void **state)
{
    static const uint8_t expected[] = {0x01, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF, 0xAB, 0xCD, 0xEF};
    (void)state;
    made_t m = make_text("digits", ESI_DEVICE(MAIL COE "<Eeprom><ByteSize>2048</ByteSize><ConfigData>"
                                                       "0123456789abcdefABCDEF</ConfigData></Eeprom>"));
    assert_memory_equal(device_of(&m)->esc_config, expected, sizeof expected);
    free_made(&m);
}

/* ProfileNo 402 promises a drive; without its two words there is none. */
static void profiles_without_a_drive(void **state)
{
#define PROFILE(number)                                                                                                \
    ESI_DEVICE("<Profile><ProfileNo>" number "</ProfileNo><Dictionary>" OBJECTS(                                       \
        VALUE("UINT", "16", "", "")) "</Dictionary></Profile>" MAIL COE ESI_EEPROM)
    static const struct {
        const char *what, *text;
        bool note;
    } table[] = {{"402", PROFILE("402"), true}, {"401", PROFILE("401"), false}, {"5001", PROFILE("5001"), false}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char why[200];
        made_t m = make_text(table[i].what, table[i].text);
        assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why));
        expect_note(table[i].what, &m,
                    table[i].note ? "ProfileNo is 402, but there is no 6040h and 6041h: it has no behaviour" : NULL);
        free_made(&m);
    }
}

/* Start and length of the mailbox to the slave, of that from the slave (ETG.2010, words 14h to 17h). */
static void boot_mailboxes(void **state)
{
#define BOOT(bytes) ESI_DEVICE(MAIL COE "<Eeprom><ByteSize>2048</ByteSize>" bytes "</Eeprom>")
    static const struct {
        const char *what, *text;
        uint16_t start, length;
    } table[] = {
        {"none", BOOT(""), 0, 0},
        {"8 bytes", BOOT("<BootStrap>3412850000148600</BootStrap>"), 0x1234, 0x85},
        {"a length of 256", BOOT("<BootStrap>0010000100140001</BootStrap>"), 0x1000, 0x100},
        {"a start without a length", BOOT("<BootStrap>0010000080108000</BootStrap>"), 0, 0},
        {"zeros", BOOT("<BootStrap>0000000000000000</BootStrap>"), 0, 0},
        {"7 bytes", BOOT("<BootStrap>00108000801080</BootStrap>"), 0, 0},
        {"9 bytes", BOOT("<BootStrap>001080008010800000</BootStrap>"), 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_boot_mailbox_t *out = &device_of(&m)->boot_out;
        if (out->start != table[i].start || out->length != table[i].length)
            fail_msg("%s: expected %u bytes at %04X, got %u at %04X", table[i].what, table[i].length, table[i].start,
                     out->length, out->start);
        free_made(&m);
    }
}

static void clocks_and_boot(void **state)
{
    static const char text[] = ESI_DEVICE(
        MAIL "<Mailbox><CoE/></Mailbox><Dc><OpMode><Name>DC</Name><Desc>D</Desc><AssignActivate>#x700</AssignActivate>"
             "<CycleTimeSync0 Factor='-2'>1000</CycleTimeSync0><ShiftTimeSync0>-5</ShiftTimeSync0>"
             "<CycleTimeSync1 Factor='3'>0</CycleTimeSync1><ShiftTimeSync1>7</ShiftTimeSync1></OpMode><OpMode/></Dc>"
             "<Eeprom><ByteSize>2048</ByteSize><ConfigData>0102030405060708090A0B0C0D0E</ConfigData>"
             "<BootStrap>0010800080108000</BootStrap></Eeprom>");
    (void)state;
    made_t m = make_text("clocks", text);
    const ect_device_t *d = device_of(&m);
    assert_int_equal(d->dc_mode_count, 2);
    assert_string_equal(d->dc_modes[0].name, "DC");
    assert_string_equal(d->dc_modes[0].description, "D");
    assert_int_equal(d->dc_modes[0].assign_activate, 0x700);
    assert_int_equal(d->dc_modes[0].cycle_sync0_ns, 1000);
    assert_int_equal(d->dc_modes[0].factor_sync0, -2);
    assert_int_equal(d->dc_modes[0].shift_sync0_ns, -5);
    assert_int_equal(d->dc_modes[0].factor_sync1, 3);
    assert_int_equal(d->dc_modes[0].shift_sync1_ns, 7);
    assert_string_equal(d->dc_modes[1].name, "unnamed");
    assert_int_equal(d->boot_out.start, 0x1000);
    assert_int_equal(d->boot_out.length, 0x80);
    assert_int_equal(d->boot_in.start, 0x1080);
    assert_int_equal(d->boot_in.length, 0x80);
    for (unsigned int i = 0; i < sizeof d->esc_config; i++)
        assert_int_equal(d->esc_config[i], i + 1);
    free_made(&m);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static const ect_signal_t *find_signal(const made_t *m, const char *prefix, const char *name)
{
    const ect_plant_t *plant = ect_esi_twin_product(m->twin)->plant;
    for (unsigned int i = 0; i < plant->signal_group_count; i++) {
        for (unsigned int k = 0; k < plant->signal_groups[i].signal_count; k++) {
            const ect_signal_t *s = &plant->signal_groups[i].signals[k];
            if (strcmp(plant->signal_groups[i].prefix, prefix) == 0 && strcmp(s->name, name) == 0)
                return s;
        }
    }
    return NULL;
}

static void signals(void **state)
{
#define SIGNAL(type, bits) PLAIN(TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", bits, "A", type)))
    static const struct {
        const char *what, *text;
        ect_signal_type_t type;
        int64_t minimum, maximum;
    } table[] = {
        {"BOOL", SIGNAL("BOOL", "1"), ECT_SIGNAL_BOOL, 0, 1},
        {"BIT3", SIGNAL("BIT3", "3"), ECT_SIGNAL_U8, 0, 7},
        {"SINT", SIGNAL("SINT", "8"), ECT_SIGNAL_I8, -128, 127},
        {"USINT", SIGNAL("USINT", "8"), ECT_SIGNAL_U8, 0, 255},
        {"INT", SIGNAL("INT", "16"), ECT_SIGNAL_I16, -32768, 32767},
        {"UINT", SIGNAL("UINT", "16"), ECT_SIGNAL_U16, 0, 65535},
        {"BITARR16", SIGNAL("BITARR16", "16"), ECT_SIGNAL_U16, 0, 65535},
        {"DINT", SIGNAL("DINT", "32"), ECT_SIGNAL_I32, INT32_MIN, INT32_MAX},
        {"UDINT", SIGNAL("UDINT", "32"), ECT_SIGNAL_U32, 0, UINT32_MAX},
        {"BITARR32", SIGNAL("BITARR32", "32"), ECT_SIGNAL_U32, 0, UINT32_MAX},
        {"LINT", SIGNAL("LINT", "64"), ECT_SIGNAL_I64, INT64_MIN, INT64_MAX},
        {"ULINT", SIGNAL("ULINT", "64"), ECT_SIGNAL_U64, 0, INT64_MAX},
        {"REAL", SIGNAL("REAL", "32"), ECT_SIGNAL_REAL32, INT64_MIN, INT64_MAX},
        {"LREAL", SIGNAL("LREAL", "64"), ECT_SIGNAL_REAL, INT64_MIN, INT64_MAX},
        {"STRING(5)", SIGNAL("STRING(5)", "40"), ECT_SIGNAL_TEXT, 0, 5},
        {"bytes", SIGNAL("ARRAY [0..2] OF BYTE", "24"), ECT_SIGNAL_BYTES, 0, 3},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_signal_t *s = find_signal(&m, "p", "a");
        if (s == NULL || s->type != table[i].type || s->minimum != table[i].minimum || s->maximum != table[i].maximum)
            fail_msg("%s: expected type %d, %lld to %lld, got %d, %lld to %lld", table[i].what, table[i].type,
                     (long long)table[i].minimum, (long long)table[i].maximum, s ? (int)s->type : -1,
                     s ? (long long)s->minimum : 0, s ? (long long)s->maximum : 0);
        assert_int_equal(s->access, ECT_SIGNAL_WRITE);
        assert_string_equal(s->meaning, "6000:01 A");
        free_made(&m);
    }
}

/* The unit of a signal is that of its entry, else that of an object of the profile, with decimal digits in some. */
static void units_of_signals(void **state)
{
#define MEASURED(profile, value, unit, digits)                                                                         \
    ESI_DEVICE("<Profile><ProfileNo>" profile "</ProfileNo><Dictionary>" OBJECTS(                                      \
        UNIT_OBJECT(value, "UINT", "16", "")                                                                           \
            UNIT_OBJECT(unit, "UDINT", "32", "<DefaultValue>#x00010300</DefaultValue>")                                \
                UNIT_OBJECT(digits, "USINT", "8",                                                                      \
                            "<DefaultValue>2</DefaultValue>")) "</Dictionary></Profile>" MAIL COE ESI_EEPROM)
#define UNIT_OBJECT(index, type, bits, info)                                                                           \
    "<Object><Index>#x" index "</Index><Name>N</Name><Type>" type "</Type><BitSize>" bits "</BitSize><Info>" info      \
    "</Info></Object>"
    static const struct {
        uint16_t profile, value, unit;
        const char *expected; /* NULL: none */
    } table[] = {
        {401, 0x6401, 0x6430, "m/s"},       {401, 0x6402, 0x6430, "m/s"},       {401, 0x6403, 0x6430, "m/s"},
        {401, 0x6404, 0x6430, NULL},        {401, 0x6400, 0x6430, NULL},        {404, 0x6401, 0x6430, NULL},
        {404, 0x6130, 0x6131, "m/s"},       {404, 0x6148, 0x6131, "m/s"},       {404, 0x6149, 0x6131, "m/s"},
        {404, 0x7130, 0x6131, "10^-2 m/s"}, {404, 0x7148, 0x6131, "10^-2 m/s"}, {404, 0x7149, 0x6131, "10^-2 m/s"},
        {404, 0x9130, 0x6131, "10^-2 m/s"}, {404, 0x9148, 0x6131, "10^-2 m/s"}, {404, 0x9149, 0x6131, "10^-2 m/s"},
        {401, 0x7130, 0x6131, NULL},        {404, 0x8130, 0x6131, NULL},        {404, 0x7130, 0x6430, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[4000], profile[8], value[8], unit[8], name[16];
        (void)snprintf(profile, sizeof profile, "%u", table[i].profile);
        (void)snprintf(value, sizeof value, "%04X", table[i].value);
        (void)snprintf(unit, sizeof unit, "%04X", table[i].unit);
        (void)snprintf(name, sizeof name, "%04x_00", table[i].value);
        (void)snprintf(text, sizeof text, MEASURED("%s", "%s", "%s", "6132"), profile, value, unit);
        made_t m = make_text(value, text);
        const ect_signal_t *s = find_signal(&m, "od", name);
        assert_non_null(s);
        if ((s->unit != NULL) != (table[i].expected != NULL) ||
            (s->unit != NULL && strcmp(s->unit, table[i].expected) != 0))
            fail_msg("%u, %04X: expected the unit %s, got %s", table[i].profile, table[i].value,
                     table[i].expected ? table[i].expected : "none", s->unit ? s->unit : "none");
        free_made(&m);
    }
}

static void units_of_entries(void **state)
{
    static const struct {
        const char *text, *unit;
    } table[] = {
        {ONE("UINT", "16", "<Unit>#xFD010300</Unit>", ""), "mm/s"},
        {ONE("UINT", "16", "<Unit>#x00030000</Unit>", ""), "s"},
        {ONE("UINT", "16", "<Unit>#x00FF0000</Unit>", ""), NULL},
        {ONE("UINT", "16", "", ""), NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text("a unit", table[i].text);
        const ect_signal_t *s = find_signal(&m, "od", "2000_00");
        assert_non_null(s);
        if ((s->unit != NULL) != (table[i].unit != NULL) || (s->unit != NULL && strcmp(s->unit, table[i].unit) != 0))
            fail_msg("row %zu: expected the unit %s, got %s", i, table[i].unit ? table[i].unit : "none",
                     s->unit ? s->unit : "none");
        free_made(&m);
    }
}

static void names_of_signals(void **state)
{
#define NAMED(pdo, entry)                                                                                              \
    PLAIN("<TxPdo Sm='3'><Index>#x1A00</Index><Name>" pdo                                                              \
          "</Name>" ENTRY("#x6000", "1", "8", entry, "USINT") "</TxPdo>")
    static const struct {
        const char *text, *prefix, *name;
    } table[] = {
        {NAMED("Inputs", "Value"), "inputs", "value"},
        {NAMED("AI Inputs Channel 1", "Status__Error 1"), "ai_inputs_channel_1", "status_error_1"},
        {NAMED("  ", "  "), "pdo_1a00", "n6000_01"},
        {NAMED("1st", "2nd"), "n1st", "n2nd"},
        {NAMED("9", "0"), "n9", "n0"},
        {NAMED("AZaz09", "z@Z[a`A{9/0:z"), "azaz09", "z_z_a_a_9_0_z"},
        {NAMED("(a)", "[b]"), "a", "b"},
        {NAMED("\u00C4", "\u00F6"), "pdo_1a00", "n6000_01"},
        {NAMED("a name that is longer than a part can be", "another one that is longer than that"),
         "a_name_that_is_longer_than_a", "another_one_that_is_longer_t"},
        {PLAIN(TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", "8", "A", "USINT") ENTRY("#x6000", "2", "8", "A", "USINT"))),
         "p", "a_2"},
        {PLAIN(TX("Sm='3'", "#x1A00",
                  A8 ENTRY("#x6000", "2", "8", "B", "USINT") ENTRY("#x6000", "3", "8", "B", "USINT")
                      ENTRY("#x6000", "4", "8", "B", "USINT"))),
         "p", "b_3"},
        {PLAIN(TX("Sm='3'", "#x1A00", A8) TX("Sm='3'", "#x1A01", B8)), "p_2", "b"},
        {PLAIN(TX("Sm='3'", "#x1A00", A8) TX("Sm='3'", "#x1A01", B8)
                   TX("Sm='3'", "#x1A02", ENTRY("#x6000", "3", "8", "C", "USINT"))),
         "p_3", "c"},
        {PLAIN(TX("", "#x1A01", B8) TX("Sm='3'", "#x1A00", A8)), "p", "a"},
        {ONE("UINT", "16", "", "<Access>rw</Access>"), "od", "2000_00"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].text, table[i].text);
        if (find_signal(&m, table[i].prefix, table[i].name) == NULL)
            fail_msg("%zu: expected %s.%s, got %s.%s", i, table[i].prefix, table[i].name,
                     ect_esi_twin_product(m.twin)->plant->signal_groups[0].prefix,
                     ect_esi_twin_product(m.twin)->plant->signal_groups[0].signals[0].name);
        free_made(&m);
    }
}

/* Process data are not also signals of the dictionary, nor are objects of the stack, counts and long texts. */
static void no_signals(void **state)
{
    static const struct {
        const char *what, *text, *name;
    } table[] = {
        {"an entry of a PDO", PLAIN(TX("Sm='3'", "#x1A00", A8)), "6000_01"},
        {"a number of entries", RECORD(COUNT ITEM("1", "A", "UINT", "16", ""), "", ""), "2000_00"},
        {"an object of the stack", PLAIN(""), "1000_00"},
        {"a text of 61 characters", ONE("STRING(61)", "488", "", ""), "2000_00"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        if (find_signal(&m, "od", table[i].name) != NULL)
            fail_msg("%s: expected no signal od.%s", table[i].what, table[i].name);
        free_made(&m);
    }
    made_t m = make_text("60", ONE("STRING(60)", "480", "", ""));
    assert_non_null(find_signal(&m, "od", "2000_00"));
    free_made(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"rights, restrictions, mapping, backup and setting of an object", rights, NULL, NULL, NULL},
        {"a sub-item has its own flags, else those of its object", inherited_rights, NULL, NULL, NULL},
        {"defaults as bytes, numbers and texts, cut to the length of the type", defaults, NULL, NULL, NULL},
        {"limits as far as type and default allow", limits, NULL, NULL, NULL},
        {"a unit is its prefix and its numerator", units, NULL, NULL, NULL},
        {"records and arrays: numbers, lengths, names", records, NULL, NULL, NULL},
        {"objects whose type has no length are omitted", objects_without_entries, NULL, NULL, NULL},
        {"exclusions are of other PDOs of the device", exclusions, NULL, NULL, NULL},
        {"infos of sub-items by name, else by place", infos, NULL, NULL, NULL},
        {"an entry has the type of the longest PDO entry that maps it, of the first one of these",
         types_of_mapped_entries, NULL, NULL, NULL},
        {"mappings: entries, gaps, exclusion, and omissions", mappings, NULL, NULL, NULL},
        {"entries that PDOs add to a record of the dictionary", entries_that_pdos_add, NULL, NULL, NULL},
        {"infos of a type where the object has none", infos_of_types, NULL, NULL, NULL},
        {"devices that no controller can be are refused", refusals, NULL, NULL, NULL},
        {"an assignment has room for all PDOs that do not exclude each other", assignments, NULL, NULL, NULL},
        {"the longest process data of a SyncManager", rooms_of_sms, NULL, NULL, NULL},
        {"a mailbox has at most the bytes of a frame", long_mailboxes, NULL, NULL, NULL},
        {"command names and type names", names_of_devices, NULL, NULL, NULL},
        {"One letter for each port gives the ports", ports_of_physics, NULL, NULL, NULL},
        {"timeouts: the file's, else the standard's", timeouts, NULL, NULL, NULL},
        {"protocols: served, refused, without a mailbox", protocols, NULL, NULL, NULL},
        {"clock modes, BOOT mailboxes and the first words of the EEPROM", clocks_and_boot, NULL, NULL, NULL},
        {"a profile of drives without a drive is noted", profiles_without_a_drive, NULL, NULL, NULL},
        {"CF-027 mailboxes of the BOOT state: 8 bytes with a length, or none", boot_mailboxes, NULL, NULL, NULL},
        {"bytes in hexadecimal digits of either case", hexadecimal_digits, NULL, NULL, NULL},
        {"types and ranges of signals", signals, NULL, NULL, NULL},
        {"a signal has the unit of its entry", units_of_entries, NULL, NULL, NULL},
        {"a signal of CiA 401 and CiA 404 has the unit of its object", units_of_signals, NULL, NULL, NULL},
        {"names of signals: plain, unique, within their length", names_of_signals, NULL, NULL, NULL},
        {"entries that have no signal of their own", no_signals, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
