/* SPDX-License-Identifier: MIT */
/* Shapes of vendors' files that once gave a wrong twin, each in a file of this project or in a few lines of one. */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

#include "bus/chain/signals.h"
#include "esi/write.h"
#include "from_text.h"
#include "sii/sii.h"
#include "support/wire.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };

static ect_esi_twin_t *make(const char *file, const char *selector)
{
    char path[300];
    char text[300] = "";
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, file);
    ect_esi_twin_t *twin = ect_esi_twin_make(path, selector, NULL, 0, text, sizeof text);
    if (twin == NULL)
        fail_msg("%s#%s: expected a twin, got: %s", file, selector, text);
    return twin;
}

static void power_on(wire_t *w, const ect_esi_twin_t *twin)
{
    const ect_product_t *product = ect_esi_twin_product(twin);
    ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    memset(w, 0, sizeof *w);
    wire_open_twins(w, &config, 1);
}

static void set(wire_t *w, const char *name, const char *value)
{
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE];
    if (!ect_chain_signal(w->chain, 0, name, &ref))
        fail_msg("there is no signal %s", name);
    if (!ect_signal_write(&ref, value, w->now_ns, message))
        fail_msg("%s=%s: %s", name, value, message);
    ect_chain_wake(w->chain, 0);
}

static const char *first_note(const ect_esi_twin_t *twin)
{
    size_t count;
    const char *const *lines = ect_esi_twin_notes(twin, &count);
    return count > 0 ? lines[0] : "none";
}

/* --- 18xxh ------------------------------------------------------------------------------------------------------- */

static void state_and_toggle(void **state)
{
    static const struct {
        const char *selector;
        uint8_t element;
        uint32_t mapping;
    } table[] = {
        {"COUNTER", 1, 0x60000101},
        {"COUNTER", 2, 5},
        {"COUNTER", 3, 0x18000701},
        {"COUNTER", 4, 0x18000901},
        {"COUNTER", 5, 0x60001110},
        {"CYCLE", 1, 0x18000901},
        {"CYCLE", 2, 7},
        {"CYCLE", 3, 32},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_twin_t *twin = make("state.xml", table[i].selector);
        ect_od_t od = ect_device_od(ect_esi_twin_product(twin)->device, NULL);
        uint32_t got = ect_od_element(ect_od_find(&od, 0x1A00), table[i].element);
        if (got != table[i].mapping)
            fail_msg("%s 1A00:%u: expected %08X, got %08X", table[i].selector, table[i].element,
                     (unsigned int)table[i].mapping, (unsigned int)got);
        ect_esi_twin_free(twin);
    }
}

static void toggle_on_the_wire(void **state)
{
    wire_t w;
    uint8_t before[3] = {0}, in[3] = {0};
    (void)state;
    ect_esi_twin_t *twin = make("state.xml", "COUNTER");
    assert_string_equal(first_note(twin), "none");
    power_on(&w, twin);
    wire_go(&w, 0, SAFEOP);
    set(&w, "cnt_inputs.value", "513");
    wire_poll(&w);
    (void)wire_read(&w, 0, 0x1180, in, sizeof in);
    assert_int_equal(wire_read(&w, 0, 0x1180, before, sizeof before), 1);
    wire_poll(&w);
    assert_int_equal(wire_read(&w, 0, 0x1180, in, sizeof in), 1);
    const uint8_t expected[3] = {(uint8_t)(before[0] ^ 0x80), 0x01, 0x02};
    assert_memory_equal(in, expected, sizeof in);
    wire_close(&w);
    ect_esi_twin_free(twin);
}

static void mapped_mapping(void **state)
{
    (void)state;
    ect_esi_twin_t *twin = make("state.xml", "CYCLE");
    assert_string_equal(first_note(twin), "line 62: PDO 1A00 maps 1A00:1, which is a mapping itself: it is a gap");
    ect_esi_twin_free(twin);
}

/* --- MinData, MaxData -------------------------------------------------------------------------------------------- */

#define VALUE(index, type, bits, info)                                                                                 \
    "<Object><Index>" index "</Index><Name>V</Name><Type>" type "</Type><BitSize>" bits "</BitSize><Info>" info        \
    "</Info><Flags><Access>rw</Access></Flags></Object>"
#define DICTIONARY(objects) "<Profile><Dictionary><Objects>" objects "</Objects></Dictionary></Profile>"
#define COE(body)           ESI_DEVICE(body ESI_MAILBOX_SMS "<Mailbox><CoE SdoInfo='1'/></Mailbox>" ESI_EEPROM)

static void limits_by_sign(void **state)
{
    static const struct {
        const char *what, *text;
        int64_t minimum, maximum;
    } table[] = {
        {"INT as bytes",
         COE(DICTIONARY(VALUE("#x2000", "INT", "16", "<MinData>00FF</MinData><MaxData>7F00</MaxData>"))), -256, 127},
        {"SINT as bytes", COE(DICTIONARY(VALUE("#x2000", "SINT", "8", "<MinData>80</MinData><MaxData>02</MaxData>"))),
         -128, 2},
        {"DINT as bytes",
         COE(DICTIONARY(VALUE("#x2000", "DINT", "32", "<MinData>FFFFFFFF</MinData><MaxData>05000000</MaxData>"))), -1,
         5},
        {"LINT as bytes",
         COE(DICTIONARY(
             VALUE("#x2000", "LINT", "64", "<MinData>FEFFFFFFFFFFFFFF</MinData><MaxData>0500000000000000</MaxData>"))),
         -2, 5},
        {"UINT as bytes",
         COE(DICTIONARY(VALUE("#x2000", "UINT", "16", "<MinData>0000</MinData><MaxData>00FF</MaxData>"))), 0, 0xFF00},
        {"USINT as bytes", COE(DICTIONARY(VALUE("#x2000", "USINT", "8", "<MinData>00</MinData><MaxData>FE</MaxData>"))),
         0, 0xFE},
        {"INT as numbers",
         COE(DICTIONARY(VALUE("#x2000", "INT", "16", "<MinValue>-3</MinValue><MaxValue>300</MaxValue>"))), -3, 300},
        {"INT, the maximum alone", COE(DICTIONARY(VALUE("#x2000", "INT", "16", "<MaxData>0A00</MaxData>"))), -32768,
         10},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        expect_note(table[i].what, &m, NULL);
        const ect_detail_t *detail = ect_od_detail(&od, 0x2000, 0);
        if (detail == NULL || detail->minimum != table[i].minimum || detail->maximum != table[i].maximum)
            fail_msg("%s: expected %lld to %lld, got %lld to %lld", table[i].what, (long long)table[i].minimum,
                     (long long)table[i].maximum, detail ? (long long)detail->minimum : 0,
                     detail ? (long long)detail->maximum : 0);
        free_made(&m);
    }
}

/* --- PDOs and entries of no length ------------------------------------------------------------------------------- */

#define OUT_PDO(entries) "<RxPdo Sm='2'><Index>#x1600</Index><Name>O</Name>" entries "</RxPdo>"
#define CHANGEABLE(body) ESI_DEVICE(body "<Mailbox><CoE SdoInfo='1' PdoAssign='1' PdoConfig='1'/></Mailbox>" ESI_EEPROM)

static void empty_pdos(void **state)
{
    static const struct {
        const char *what, *text, *note;
    } table[] = {
        {"no entry", CHANGEABLE(ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO("")),
         "line 2: PDO 1600 (O) has no entries: it carries no data"},
        {"a number of no bits",
         CHANGEABLE(ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO(
             "<Entry><Index>#x7000</Index><SubIndex>1</SubIndex><BitLen>0</BitLen></Entry>"
             "<Entry><Index>#x7000</Index><SubIndex>2</SubIndex><BitLen>8</BitLen><Name>N</Name></Entry>")),
         "line 2: PDO 1600 has an entry of no bits: it is left out"},
        {"a gap of no bits",
         CHANGEABLE(ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO(
             "<Entry><Index>0</Index><BitLen>0</BitLen></Entry>"
             "<Entry><Index>#x7000</Index><SubIndex>2</SubIndex><BitLen>8</BitLen><Name>N</Name></Entry>")),
         "line 2: PDO 1600 has an entry of no bits: it is left out"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* The service exists only for a device with writable objects; without it the twin is made none the less. */
static uint32_t write_number(wire_t *w, uint16_t index, uint8_t subindex, uint32_t value, size_t size)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    return wire_sdo_download(w, 0, index, subindex, false, bytes, size);
}

/* MaxSize is optional: the mapping of a master is longer than any of the file. */
static void mapping_without_max_size(void **state)
{
#define PART(sub, bits, type) IN_7000("<SubIndex>" sub "</SubIndex><BitLen>" bits "</BitLen>", type)
#define IN_7000(inner, type)  "<Entry><Index>#x7000</Index>" inner "<Name>O</Name><DataType>" type "</DataType></Entry>"
    wire_t w;
    (void)state;
    made_t m = make_text(
        "own mapping",
        CHANGEABLE(ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO(PART("1", "8", "USINT") PART(
            "2", "8",
            "USINT")) "<RxPdo><Index>#x1601</Index><Exclude>#x1600</Exclude><Name>P</Name>" PART("3", "32",
                                                                                                 "UDINT") "</RxPdo>"));
    power_on(&w, m.twin);
    wire_go(&w, 0, PREOP);
    assert_int_equal(write_number(&w, 0x1C12, 0, 0, 1), 0);
    assert_int_equal(write_number(&w, 0x1600, 0, 0, 1), 0);
    assert_int_equal(write_number(&w, 0x1600, 1, 0x70000320, 4), 0);
    assert_int_equal(write_number(&w, 0x1600, 2, 0x70000320, 4), 0);
    assert_int_equal(write_number(&w, 0x1600, 0, 2, 1), 0);
    assert_int_equal(write_number(&w, 0x1C12, 1, 0x1600, 2), 0);
    assert_int_equal(write_number(&w, 0x1C12, 0, 1, 1), 0);
    wire_close(&w);
    free_made(&m);
}

/* An infinite speed is the motor's own limit, one that is no number is none; neither is accepted by SDO. */
static void infinite_set_values(void **state)
{
#define WORD(index, bits, type)                                                                                        \
    "<Entry><Index>" index "</Index><SubIndex>0</SubIndex><BitLen>" bits "</BitLen><Name>V</Name><DataType>" type      \
    "</DataType></Entry>"
#define REAL_SPEED                                                                                                     \
    "<Profile><ProfileNo>402</ProfileNo><Dictionary><DataTypes><DataType><Name>REAL</Name><BitSize>32</BitSize>"       \
    "</DataType></DataTypes><Objects><Object><Index>#x60FF</Index><Name>V</Name><Type>REAL</Type><BitSize>32"          \
    "</BitSize><Flags><Access>rw</Access><PdoMapping>R</PdoMapping></Flags></Object></Objects></Dictionary></Profile>"
    static const struct {
        uint32_t bits;
        int sign;
    } rows[] = {{0x7F800000, 1}, {0xFF800000, -1}, {0x7FC00000, 0}, {0x7F7FFFFF, 1}, {0xFF800001, 0}};
    static const uint8_t commands[] = {0x06, 0x07, 0x0F};
    wire_t w;
    uint8_t out[6] = {0}, in[6];
    char why[300] = "";
    (void)state;
    made_t m =
        make_text("a speed in floating point",
                  CHANGEABLE(REAL_SPEED ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO(WORD("#x6040", "16", "UINT") WORD(
                      "#x60FF", "32", "REAL")) "<TxPdo Sm='3'><Index>#x1A00"
                                               "</Index><Name>I</Name>" WORD("#x6041", "16", "UINT")
                                                   WORD("#x606C", "32", "DINT") "</TxPdo>"));
    assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_CIA402, why, sizeof why));
    power_on(&w, m.twin);
    wire_go(&w, 0, PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(write_number(&w, 0x60FF, 0, rows[i].bits, 4), rows[i].bits == 0x7F7FFFFF ? 0 : 0x06090030);
    wire_go(&w, 0, OP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0] * 400; i++) {
        out[0] = commands[i < 2 ? i : 2];
        ect_store_le32(out + 2, i < 3 ? 0 : rows[i / 400].bits);
        (void)wire_write(&w, 0, device_of(&m)->sm[2].start, out, sizeof out);
        wire_advance(&w, 1000000);
        assert_int_equal(wire_read(&w, 0, device_of(&m)->sm[3].start, in, sizeof in), 1);
        const int32_t speed = (int32_t)ect_load_le32(in + 2), least = 1048576;
        const bool fits = rows[i / 400].sign == 0 ? abs(speed) < least : rows[i / 400].sign * (int64_t)speed > least;
        if (i % 400 == 399 && !fits)
            fail_msg("%08X in 60FFh: got the speed %d, status word %04X", (unsigned int)rows[i / 400].bits, (int)speed,
                     ect_load_le16(in));
    }
    wire_close(&w);
    free_made(&m);
}

/* Increments of a turn that the file lacks: of the size of its window of following errors. */
static void resolutions(void **state)
{
#define WINDOW(value, more)                                                                                            \
    CHANGEABLE("<Profile><ProfileNo>402</ProfileNo><Dictionary><DataTypes><DataType><Name>UDINT</Name><BitSize>32"     \
               "</BitSize></DataType></DataTypes><Objects><Object><Index>#x6065</Index><Name>W</Name><Type>UDINT"      \
               "</Type><BitSize>32</BitSize><Info><DefaultValue>" value "</DefaultValue></Info><Flags><Access>rw"      \
               "</Access></Flags></Object></Objects></Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO(  \
                   WORD("#x6040", "16", "UINT")                                                                        \
                       WORD("#x607A", "32", "DINT")) "<TxPdo Sm='3'><Index>#x1A00"                                     \
                                                     "</Index><Name>I</Name>" WORD("#x6041", "16", "UINT") more        \
               "</TxPdo>")
    static const struct {
        const char *text, *resolution;
    } rows[] = {{WINDOW("100", ""), "10000"},
                {WINDOW("10485", ""), "1048500"},
                {WINDOW("10486", ""), "0"},
                {WINDOW("0", ""), "0"},
                {WINDOW("100", "<Entry><Index>#x608F</Index><SubIndex>1</SubIndex><BitLen>32</BitLen><Name>E</Name>"
                               "<DataType>UDINT</DataType></Entry>"),
                 "0"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_t w;
        ect_signal_ref_t ref;
        char why[300] = "", text[ECT_SIGNAL_TEXT_ROOM];
        made_t m = make_text("a window of following errors", rows[i].text);
        assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_CIA402, why, sizeof why));
        power_on(&w, m.twin);
        assert_true(ect_chain_signal(w.chain, 0, "axis1.resolution", &ref));
        ect_signal_read(&ref, text);
        if (strcmp(text, rows[i].resolution) != 0)
            fail_msg("row %zu: expected a resolution of %s, got %s", i, rows[i].resolution, text);
        wire_close(&w);
        free_made(&m);
    }
}

/* A setting of 0 in the file is a choice; a missing one gets the default of the drive. */
static void settings_of_zero(void **state)
{
#define SETTING(index, info)                                                                                           \
    "<Object><Index>#x" index "</Index><Name>S</Name><Type>INT</Type><BitSize>16</BitSize>" info                       \
    "<Flags><Access>rw</Access></Flags></Object>"
#define SETTINGS(info)                                                                                                 \
    CHANGEABLE(                                                                                                        \
        "<Profile><ProfileNo>402</ProfileNo><Dictionary><DataTypes><DataType><Name>INT</Name><BitSize>16"              \
        "</BitSize></DataType></DataTypes><Objects>" SETTING("6007", info) SETTING("605A", info) SETTING("605C", info) \
            SETTING("605E", info) "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO(         \
                WORD("#x6040", "16", "UINT")                                                                           \
                    WORD("#x607A", "32",                                                                               \
                         "DINT")) "<TxPdo Sm='3'><Index>#x1A00</Index><Name>I</Name>" WORD("#x6041", "16",             \
                                                                                           "UINT") "</TxPdo>")
    static const uint16_t indices[] = {0x6007, 0x605A, 0x605C, 0x605E};
    static const struct {
        const char *text;
        int16_t values[4];
    } rows[] = {
        {SETTINGS(""), {1, 2, 1, 2}},
        {SETTINGS("<Info><DefaultData>0000</DefaultData></Info>"), {0, 0, 0, 0}},
        {SETTINGS("<Info><DefaultData>0600</DefaultData></Info>"), {6, 6, 6, 6}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_t w;
        char why[300] = "";
        made_t m = make_text("settings", rows[i].text);
        assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_CIA402, why, sizeof why));
        power_on(&w, m.twin);
        wire_go(&w, 0, ECT_STATE_PREOP);
        for (size_t k = 0; k < 4; k++) {
            uint8_t bytes[2] = {0};
            size_t size = sizeof bytes;
            assert_int_equal(wire_sdo_upload(&w, 0, indices[k], 0, false, bytes, &size), 0);
            if ((int16_t)ect_load_le16(bytes) != rows[i].values[k])
                fail_msg("row %zu: expected %d in %04X, got %d", i, rows[i].values[k], indices[k],
                         (int16_t)ect_load_le16(bytes));
        }
        wire_close(&w);
        free_made(&m);
    }
}

static void services(void **state)
{
    static const struct {
        const char *what, *text;
        bool service;
    } table[] = {
        {"nothing to assign", CHANGEABLE(ESI_MAILBOX_SMS), false},
        {"an assignment", CHANGEABLE(ESI_MAILBOX_SMS ESI_PROCESS_SMS), true},
        {"an assignment of SyncManager 0",
         ESI_DEVICE("<Sm StartAddress='#x1000' ControlByte='#x20'>Inputs</Sm><Mailbox><CoE PdoAssign='1'/></Mailbox>"),
         true},
        {"assignment and mapping fixed",
         ESI_DEVICE(ESI_MAILBOX_SMS ESI_PROCESS_SMS OUT_PDO("") "<Mailbox><CoE/></Mailbox>" ESI_EEPROM), false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        bool service = device_of(&m)->services != NULL;
        if (service != table[i].service)
            fail_msg("%s: expected %d, got %d", table[i].what, table[i].service, service);
        free_made(&m);
    }
}

/* --- names, notes, size ------------------------------------------------------------------------------------------ */

#define TYPES_1C00                                                                                                     \
    "<DataTypes><DataType><Name>DT1C00</Name><BitSize>32</BitSize>"                                                    \
    "<SubItem><SubIdx>0</SubIdx><Name>SubIndex 000</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs>"   \
    "</SubItem><SubItem><SubIdx>1</SubIdx><Name>First</Name><Type>USINT</Type><BitSize>8</BitSize>"                    \
    "<BitOffs>16</BitOffs></SubItem></DataType></DataTypes>"

static void name_of_1c00(void **state)
{
    static const struct {
        const char *what, *text, *name, *element;
    } table[] = {
        {"the file's",
         COE("<Profile><Dictionary>" TYPES_1C00 "<Objects><Object><Index>#x1C00</Index><Name>SM Communication Type"
             "</Name><Type>DT1C00</Type><BitSize>32</BitSize></Object></Objects></Dictionary></Profile>"),
         "SM Communication Type", "First"},
        {"none in the file", COE(""), "SyncManager type", "Type"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *object = ect_od_find(&od, 0x1C00);
        assert_non_null(object);
        if (strcmp(object->name, table[i].name) != 0 || strcmp(object->entries[1].name, table[i].element) != 0)
            fail_msg("%s: expected %s, %s, got %s, %s", table[i].what, table[i].name, table[i].element, object->name,
                     object->entries[1].name);
        free_made(&m);
    }
}

/* Values of sensors in floating point, which a master writes: only finite ones are accepted. */
static void infinite_values_of_sensors(void **state)
{
#define SENSOR(profile, objects)                                                                                       \
    ESI_DEVICE("<Profile><ProfileNo>" profile "</ProfileNo><Dictionary><DataTypes><DataType><Name>REAL</Name>"         \
               "<BitSize>32</BitSize></DataType><DataType><Name>USINT</Name><BitSize>8</BitSize></DataType><DataType>" \
               "<Name>DT</Name><BitSize>48</BitSize><SubItem><SubIdx>0</SubIdx><Name>N</Name><Type>USINT</Type>"       \
               "<BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem><SubItem><SubIdx>1</SubIdx><Name>V</Name><Type>REAL" \
               "</Type><BitSize>32</BitSize><BitOffs>16</BitOffs><Flags><Access>rw</Access></Flags></SubItem>"         \
               "</DataType></DataTypes><Objects>" objects "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS          \
               "<Mailbox><CoE/></Mailbox>")
#define REAL_OBJECT(index)                                                                                             \
    "<Object><Index>" index "</Index><Name>V</Name><Type>REAL</Type><BitSize>32</BitSize><Flags><Access>rw</Access>"   \
    "</Flags></Object>"
    static const struct {
        const char *text;
        ect_behaviour_t behaviour;
        uint16_t index;
        uint8_t subindex;
    } sensors[] = {
        {SENSOR("404", "<Object><Index>#x6130</Index><Name>V</Name><Type>DT</Type><BitSize>48</BitSize></Object>"),
         ECT_BEHAVIOUR_CIA404, 0x6130, 1},
        {SENSOR("406", REAL_OBJECT("#x6003") REAL_OBJECT("#x6004")), ECT_BEHAVIOUR_CIA406, 0x6003, 0},
    };
    static const struct {
        uint32_t bits;
        bool finite;
    } rows[] = {{0x7F800000, false}, {0xFF800000, false}, {0x7FC00000, false}, {0x3F800000, true}, {0, true}};
    (void)state;
    for (size_t k = 0; k < sizeof sensors / sizeof sensors[0]; k++) {
        char why[300] = "";
        wire_t w;
        made_t m = make_text("a sensor in floating point", sensors[k].text);
        if (!ect_esi_twin_behave(m.twin, sensors[k].behaviour, why, sizeof why))
            fail_msg("%s", why);
        power_on(&w, m.twin);
        wire_go(&w, 0, PREOP);
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            const uint32_t code = write_number(&w, sensors[k].index, sensors[k].subindex, rows[i].bits, 4);
            if (code != (rows[i].finite ? 0 : 0x06090030))
                fail_msg("%04X: %08X: got %08X", sensors[k].index, (unsigned int)rows[i].bits, (unsigned int)code);
        }
        wire_close(&w);
        free_made(&m);
    }
}

/* A file with a dictionary of `count` objects, each of a type of its own with `items` entries and a bad default. */
static char *file_of(size_t count, size_t items)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    (void)fputs(ESI_HEAD "<Device Physics='YY'><Type ProductCode='1' RevisionNo='2'>D</Type><Name>D</Name><Profile>"
                         "<Dictionary><DataTypes>",
                out);
    for (size_t i = 0; i < count; i++) {
        (void)fprintf(out, "<DataType><Name>DT%04zX</Name><BitSize>%zu</BitSize>", i, 16 + 8 * items);
        for (size_t k = 0; k <= items; k++)
            (void)fprintf(out,
                          "<SubItem><SubIdx>%zu</SubIdx><Name>N%zu</Name><Type>USINT</Type><BitSize>8</BitSize>"
                          "<BitOffs>%zu</BitOffs></SubItem>",
                          k, k, k == 0 ? 0 : 8 + 8 * k);
        (void)fputs("</DataType>", out);
    }
    (void)fputs("</DataTypes><Objects>", out);
    for (size_t i = 0; i < count; i++)
        (void)fprintf(out,
                      "<Object><Index>#x%04zX</Index><Name>O</Name><Type>DT%04zX</Type><BitSize>%zu</BitSize>"
                      "<Info><SubItem><Name>N0</Name><Info><DefaultData>%02zX</DefaultData></Info></SubItem>"
                      "<SubItem><Name>N1</Name><Info><MinValue>1</MinValue><MaxValue>5</MaxValue><DefaultValue>9"
                      "</DefaultValue></Info></SubItem></Info></Object>",
                      0x2000 + i, i, 16 + 8 * items, items);
    (void)fputs("</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS "<Mailbox><CoE/></Mailbox></Device>" ESI_TAIL, out);
    (void)fclose(out);
    return text;
}

static void notes_are_counted(void **state)
{
    static const struct {
        size_t objects;
        const char *note;
    } table[] = {
        {1, "object 2000:1: its default 9 is not within its limits 1 to 5: no limits"},
        {2, "object 2000:1: its default 9 is not within its limits 1 to 5: no limits (and 1 more like it)"},
        {300, "object 2000:1: its default 9 is not within its limits 1 to 5: no limits (and 299 more like it)"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = file_of(table[i].objects, 1);
        made_t m = make_text("notes", text);
        expect_note("notes", &m, table[i].note);
        free_made(&m);
        free(text);
    }
}

/* Each kind has its own count, whatever notes lie between two of a kind. */
static void kinds_of_notes_are_counted(void **state)
{
#define BAD(index)                                                                                                     \
    "<Object><Index>" index "</Index><Name>O</Name><Type>USINT</Type><BitSize>8</BitSize><Info><MinValue>1</MinValue>" \
    "<MaxValue>5</MaxValue><DefaultValue>9</DefaultValue></Info></Object>"
    static const char text[] =
        ESI_DEVICE("<Profile><Dictionary><DataTypes><DataType><Name>USINT</Name><BitSize>8</BitSize></DataType>"
                   "</DataTypes><Objects>" BAD("#x2000") BAD("#x2001") BAD("#x2000") BAD("#x2001") BAD("#x2002")
                       BAD("#x2002") "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS "<Mailbox><CoE/></Mailbox>");
    static const char *const wanted[] = {
        "line 2: object 2000 occurs twice: the first one is used (and 2 more like it)",
        "object 2000:0: its default 9 is not within its limits 1 to 5: no limits (and 2 more like it)",
    };
    size_t count;
    (void)state;
    made_t m = make_text("kinds", text);
    (void)ect_esi_twin_notes(m.twin, &count);
    assert_int_equal(count, 2);
    for (size_t i = 0; i < 2; i++) {
        if (note_of(&m, wanted[i]) == NULL)
            fail_msg("expected the note \"%s\"", wanted[i]);
    }
    free_made(&m);
}

/* A note has at most 399 characters. */
static void long_notes(void **state)
{
    static const size_t lengths[] = {300, 500};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        char name[600], text[3000];
        size_t count;
        memset(name, 'N', sizeof name);
        name[lengths[i]] = '\0';
        (void)snprintf(text, sizeof text,
                       ESI_DEVICE(ESI_MAILBOX_SMS ESI_PROCESS_SMS "<TxPdo Sm='2'><Index>#x1A00</Index><Name>%s</Name>"
                                                                  "</TxPdo><Mailbox><CoE/></Mailbox>"),
                       name);
        made_t m = make_text("a long name", text);
        const char *const *notes = ect_esi_twin_notes(m.twin, &count);
        const char *note = NULL;
        for (size_t k = 0; k < count; k++)
            note = strstr(notes[k], "NNNN") != NULL ? notes[k] : note;
        assert_non_null(note);
        if (lengths[i] == 300)
            assert_non_null(strstr(note, "N) has no entries: it carries no data"));
        else
            assert_int_equal(strlen(note), 399);
        free_made(&m);
    }
}

/* The size is a multiple of 128 bytes, and fits a number of 16 bits. */
static void sizes_of_EEPROMs(void **state)
{
    static const struct {
        unsigned int given;
        uint16_t size;
        const char *note;
    } rows[] = {
        {0, 1024, NULL}, /* not given */
        {2048, 2048, NULL},     {2049, 2176, NULL},
        {0xFF80, 0xFF80, NULL}, {0xFF81, 0xFF80, "its EEPROM has 65536 bytes; the twin's has 65408"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[1000];
        (void)snprintf(text, sizeof text, ESI_DEVICE("<Eeprom><ByteSize>%u</ByteSize></Eeprom>"), rows[i].given);
        made_t m = make_text("an EEPROM", text);
        assert_int_equal(device_of(&m)->sii_size, rows[i].size);
        expect_note("an EEPROM", &m, rows[i].note);
        free_made(&m);
    }
}

static double seconds_for(size_t objects)
{
    char *text = file_of(objects, 1);
    clock_t begin = clock();
    made_t m = make_text("many objects", text);
    double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    ect_od_t od = od_of(&m);
    assert_int_equal(od.count, objects + 4); /* 1000h, 1008h, 1018h, 1C00h */
    free_made(&m);
    free(text);
    return seconds;
}

/* Sixteen times the objects: linear time is 16 times as much, quadratic 256 times. */
static void time_in_objects(void **state)
{
    (void)state;
    double few = seconds_for(1000);
    double many = seconds_for(16000);
    if (many > 80 * few)
        fail_msg("expected at most 80 times %.4f s for 16 times the objects, got %.4f s", few, many);
}

static void too_many_entries(void **state)
{
    (void)state;
    char *text = file_of(2621, 24); /* ten entries of the stack in addition */
    made_t m = make_text("65535 entries", text);
    free_made(&m);
    free(text);
    text = file_of(300, 220);
    m = try_text(text);
    assert_null(m.twin);
    assert_string_equal(m.why, "t.xml:1: D: its dictionary has more than the 65535 entries that a twin can have");
    free_made(&m);
    free(text);
}

/* --- virtual SyncManagers ---------------------------------------------------------------------------------------- */

/* The image of a twin, to be freed. */
static uint8_t *image_of(const ect_esi_twin_t *twin)
{
    const ect_device_t *device = ect_esi_twin_product(twin)->device;
    uint8_t *image = malloc(device->sii_size);
    assert_non_null(image);
    assert_int_equal(ect_sii_write(device, NULL, 0, image, device->sii_size), device->sii_size);
    return image;
}

static void virtual_in_the_sii(void **state)
{
    static const struct {
        const char *selector;
        unsigned int sm;
        uint8_t bytes[8]; /* start, length, control, status, enable, type */
    } table[] = {
        {"STAMP", 0, {0x00, 0x10, 1, 0, 0x00, 0, 0x01, 4}}, {"STAMP", 1, {0xAE, 0x09, 2, 0, 0x00, 0, 0x05, 4}},
        {"STAMP", 2, {0x10, 0x09, 8, 0, 0x00, 0, 0x05, 4}}, {"START", 0, {0x00, 0x0F, 1, 0, 0x44, 0, 0x09, 3}},
        {"START", 1, {0x90, 0x09, 8, 0, 0x04, 0, 0x05, 3}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_twin_t *twin = make("virtual.xml", table[i].selector);
        uint8_t *image = image_of(twin);
        size_t length = 0;
        const uint8_t *sms =
            ect_sii_category(image, ect_esi_twin_product(twin)->device->sii_size, ECT_SII_SYNCM, &length);
        assert_true(sms != NULL && length >= 8 * (table[i].sm + 1u));
        const uint8_t *got = sms + 8 * (size_t)table[i].sm;
        for (unsigned int k = 0; k < 8; k++) {
            if (got[k] != table[i].bytes[k])
                fail_msg("%s SM%u byte %u: expected %02X, got %02X", table[i].selector, table[i].sm, k,
                         table[i].bytes[k], got[k]);
        }
        free(image);
        ect_esi_twin_free(twin);
    }
}

/* Index, entries and SyncManager of each PDO of the SII. */
static void virtual_pdos(void **state)
{
    static const struct {
        const char *selector;
        uint16_t pdo;
        uint8_t sm;
        uint16_t flags;
    } table[] = {
        {"STAMP", 0x1A00, 0, ECT_PDO_FIXED | ECT_PDO_MANDATORY},
        {"STAMP", 0x1A13, 1, ECT_PDO_FIXED | ECT_PDO_VIRTUAL},
        {"STAMP", 0x1A14, 2, ECT_PDO_FIXED | ECT_PDO_VIRTUAL},
        {"START", 0x1600, 0, ECT_PDO_FIXED | ECT_PDO_MANDATORY},
        {"START", 0x1613, 1, ECT_PDO_FIXED | ECT_PDO_MANDATORY | ECT_PDO_VIRTUAL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_twin_t *twin = make("virtual.xml", table[i].selector);
        const ect_device_t *device = ect_esi_twin_product(twin)->device;
        ect_od_t od = ect_device_od(device, NULL);
        const ect_object_t *pdo = ect_od_find(&od, table[i].pdo);
        assert_non_null(pdo);
        if (ect_sii_pdo_sm(device, table[i].pdo) != table[i].sm || ect_sii_pdo_flags(device, pdo) != table[i].flags)
            fail_msg("%s PDO %04X: expected SM%u flags %02X, got SM%u flags %02X", table[i].selector, table[i].pdo,
                     table[i].sm, table[i].flags, ect_sii_pdo_sm(device, table[i].pdo), ect_sii_pdo_flags(device, pdo));
        ect_esi_twin_free(twin);
    }
    ect_esi_twin_t *twin = make("virtual.xml", "STAMP");
    assert_string_equal(first_note(twin), "line 32: PDO 1A15 (Of no SyncManager) is left out: it maps registers of the "
                                          "controller, and no virtual SyncManager has it");
    ect_esi_twin_free(twin);
}

/* A signal of a register's entry would change nothing on the wire. */
static void no_virtual_signals(void **state)
{
    wire_t w;
    ect_signal_ref_t ref;
    (void)state;
    ect_esi_twin_t *twin = make("virtual.xml", "STAMP");
    power_on(&w, twin);
    assert_true(ect_chain_signal(w.chain, 0, "channels.input_2", &ref));
    assert_false(ect_chain_signal(w.chain, 0, "latch.status_1", &ref));
    assert_false(ect_chain_signal(w.chain, 0, "od.1d09_ae", &ref));
    wire_close(&w);
    ect_esi_twin_free(twin);
}

/* Through the FMMUs that a master sets for a virtual SyncManager it reads the clock and writes the start time. */
static void registers_by_fmmu(void **state)
{
    wire_t w;
    uint8_t time[8] = {0}, direct[8] = {0};
    (void)state;
    ect_esi_twin_t *twin = make("virtual.xml", "STAMP");
    power_on(&w, twin);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    wire_set_fmmu(&w, 0, 1, 0x10000, 8, 0, 7, 0x0910, 0, 1);
    wire_advance(&w, 1000000);
    assert_int_equal(wire_logical(&w, LRD, 0x10000, time, 8), 1);
    assert_int_equal(wire_read(&w, 0, 0x0910, direct, 8), 1);
    assert_true(ect_load_le64(time) > 0);
    assert_true(ect_load_le64(direct) - ect_load_le64(time) < 100000);
    wire_close(&w);
    ect_esi_twin_free(twin);

    twin = make("virtual.xml", "START");
    power_on(&w, twin);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    wire_set_fmmu(&w, 0, 1, 0x20000, 8, 0, 7, 0x0990, 0, 2);
    uint8_t start[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    assert_int_equal(wire_logical(&w, LWR, 0x20000, start, 8), 1);
    assert_int_equal(wire_read(&w, 0, 0x0990, direct, 8), 1);
    assert_memory_equal(direct, start, 8);
    wire_close(&w);
    ect_esi_twin_free(twin);
}

/* --- the category General ---------------------------------------------------------------------------------------- */

#define SHORT_MAIL ESI_MAILBOX_SMS

static void general(void **state)
{
    static const struct {
        const char *what, *text;
        unsigned int at; /* of the category General */
        uint8_t value;
    } table[] = {
        {"nothing", ESI_DEVICE(ESI_EEPROM), 11, 0x00},
        {"the mailbox's data link layer",
         ESI_DEVICE(SHORT_MAIL "<Mailbox DataLinkLayer='1'><CoE/></Mailbox>" ESI_EEPROM), 11, 0x04},
        {"none of it", ESI_DEVICE(SHORT_MAIL "<Mailbox><CoE/></Mailbox>" ESI_EEPROM), 11, 0x00},
        {"identification by AL status",
         ESI_DEVICE("<Info><IdentificationReg134>true</IdentificationReg134></Info>" ESI_EEPROM), 11, 0x08},
        {"identification in memory",
         ESI_DEVICE("<Info><IdentificationAdo>#x1234</IdentificationAdo></Info>" ESI_EEPROM), 11, 0x10},
        {"its address, low", ESI_DEVICE("<Info><IdentificationAdo>#x1234</IdentificationAdo></Info>" ESI_EEPROM), 18,
         0x34},
        {"its address, high", ESI_DEVICE("<Info><IdentificationAdo>#x1234</IdentificationAdo></Info>" ESI_EEPROM), 19,
         0x12},
        {"no LRW",
         ESI_HEAD "<Device Physics='Y'><Type ProductCode='1' RevisionNo='1' UseLrdLwr='1'>D</Type><Name>D</Name>"
                  "</Device>" ESI_TAIL,
         11, 0x02},
        {"channels of SoE", ESI_DEVICE(SHORT_MAIL "<Mailbox><SoE ChannelCount='2'/></Mailbox>" ESI_EEPROM), 8, 2},
        {"SoE alone", ESI_DEVICE(SHORT_MAIL "<Mailbox><SoE/></Mailbox>" ESI_EEPROM), 8, 0},
        {"FoE", ESI_DEVICE(SHORT_MAIL "<Mailbox><FoE/></Mailbox>" ESI_EEPROM), 6, 1},
        {"EoE", ESI_DEVICE(SHORT_MAIL "<Mailbox><EoE/></Mailbox>" ESI_EEPROM), 7, 1},
        {"ports Y and K",
         ESI_HEAD "<Device Physics='YK'><Type ProductCode='1' RevisionNo='1'>D</Type></Device>" ESI_TAIL, 16, 0x31},
        {"port H", ESI_HEAD "<Device Physics='YH'><Type ProductCode='1' RevisionNo='1'>D</Type></Device>" ESI_TAIL, 16,
         0x41},
        {"ports 2 and 3",
         ESI_HEAD "<Device Physics='Y HK'><Type ProductCode='1' RevisionNo='1'>D</Type></Device>" ESI_TAIL, 17, 0x34},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        uint8_t *image = image_of(m.twin);
        size_t length = 0;
        const uint8_t *category = ect_sii_category(image, device_of(&m)->sii_size, ECT_SII_GENERAL, &length);
        assert_int_equal(length, 32);
        if (category[table[i].at] != table[i].value)
            fail_msg("%s: byte %u: expected %02X, got %02X", table[i].what, table[i].at, table[i].value,
                     category[table[i].at]);
        free(image);
        free_made(&m);
    }
}

/* Bits 1 to 3 of Enable are those of the SII; OpOnly and Virtual are attributes for two of them. */
static void enable_bits(void **state)
{
    static const struct {
        const char *attributes;
        uint8_t byte;
    } table[] = {
        {"Enable='1'", 0x01},
        {"Enable='#x09'", 0x09},
        {"Enable='1' OpOnly='1'", 0x09},
        {"Enable='3'", 0x03},
        {"Enable='1' OpOnly='0'", 0x01},
        {"Enable='#x81'", 0x01},
        {"OpOnly='true'", 0x09},
        {"", 0x01},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[1200];
        (void)snprintf(text, sizeof text,
                       ESI_HEAD "<Device Physics='Y'><Type ProductCode='1' RevisionNo='1'>D</Type><Name>D</Name>"
                                "<Sm StartAddress='#x1000' ControlByte='#x20' %s>Inputs</Sm><TxPdo Sm='0'><Index>#x1A00"
                                "</Index><Name>I</Name><Entry><Index>#x6000</Index><SubIndex>1</SubIndex><BitLen>8"
                                "</BitLen><Name>N</Name></Entry></TxPdo></Device>" ESI_TAIL,
                       table[i].attributes);
        made_t m = make_text(table[i].attributes, text);
        uint8_t *image = image_of(m.twin);
        size_t length = 0;
        const uint8_t *sms = ect_sii_category(image, device_of(&m)->sii_size, ECT_SII_SYNCM, &length);
        assert_int_equal(length, 8);
        if (sms[6] != table[i].byte)
            fail_msg("%s: expected %02X, got %02X", table[i].attributes, table[i].byte, sms[6]);
        free(image);
        free_made(&m);
    }
}

/* --- an EEPROM of the file's size -------------------------------------------------------------------------------- */

/* Four PDOs, two of them assigned, with names, and a mode of the clocks. */
static char *sized(const char *eeprom, bool coe)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    (void)fputs(ESI_HEAD "<Device Physics='YY'><Type ProductCode='1' RevisionNo='2'>D</Type><Name>D</Name>", out);
    if (coe)
        (void)fputs(ESI_MAILBOX_SMS, out);
    (void)fputs("<Sm StartAddress='#x1400' ControlByte='#x20' Enable='1'>Inputs</Sm>", out);
    for (unsigned int i = 0; i < 4; i++) {
        (void)fprintf(out, "<TxPdo%s><Index>#x%04X</Index><Name>Input data of channel %u</Name>",
                      i > 1 ? ""
                      : coe ? " Sm='2'"
                            : " Sm='0'",
                      0x1A00 + i, i);
        for (unsigned int k = 1; k <= 4; k++)
            (void)fprintf(out,
                          "<Entry><Index>#x%04X</Index><SubIndex>%u</SubIndex><BitLen>8</BitLen><Name>A value %u"
                          "%u</Name></Entry>",
                          0x6000 + 16 * i, k, i, k);
        (void)fputs("</TxPdo>", out);
    }
    (void)fputs(coe ? "<Mailbox><CoE/></Mailbox>" : "", out);
    (void)fputs("<Dc><OpMode><Name>A name of a mode</Name><Desc>And what it is good for</Desc><AssignActivate>0"
                "</AssignActivate></OpMode></Dc>",
                out);
    (void)fputs(eeprom, out);
    (void)fputs("</Device>" ESI_TAIL, out);
    (void)fclose(out);
    return text;
}

#define EEPROM_OF(bytes) "<Eeprom><ByteSize>" bytes "</ByteSize><ConfigData>0504</ConfigData></Eeprom>"

/* An EEPROM without room for the categories of the file is doubled, up to 64 KB. */
static void enlarged_eeproms(void **state)
{
    static const struct {
        unsigned int given, category; /* bytes */
        uint16_t size;                /* 0: refused */
        const char *text;             /* the note, or the reason */
    } table[] = {
        {16384, 10000, 16384, NULL},
        {0, 30000, 32768, NULL},
        {0, 40000, 0,
         "d.xml:1: D: its SII does not fit an EEPROM of 32768 bytes, or needs more than the 255 texts that it can "
         "have"},
        {24576, 30000, 49152, "its SII does not fit 24576 bytes; the twin's EEPROM has 49152"},
        {32640, 40000, 65280, "its SII does not fit 32640 bytes; the twin's EEPROM has 65280"},
        {32768, 40000, 0,
         "d.xml:1: D: its SII does not fit an EEPROM of 32768 bytes, or needs more than the 255 texts that it can "
         "have"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = NULL, why[300] = "";
        size_t size;
        FILE *out = open_memstream(&text, &size);
        assert_non_null(out);
        (void)fputs(ESI_HEAD "<Device Physics='YY'><Type ProductCode='1' RevisionNo='2'>D</Type><Name>D</Name><Eeprom>",
                    out);
        if (table[i].given != 0)
            (void)fprintf(out, "<ByteSize>%u</ByteSize>", table[i].given);
        (void)fprintf(out,
                      "<ConfigData>0504</ConfigData><Category><CatNo>2048</CatNo><Data>%0*d</Data></Category></Eeprom>",
                      2 * (int)table[i].category, 0);
        (void)fputs("</Device>" ESI_TAIL, out);
        (void)fclose(out);
        made_t m = {.esi = ect_esi_parse("d.xml", text, size, why, sizeof why)};
        m.model = m.esi != NULL ? ect_esi_select(m.esi, "", why, sizeof why) : NULL;
        m.twin = m.model != NULL ? ect_esi_twin_of(m.esi, m.model, NULL, 0, why, sizeof why) : NULL;
        if ((m.twin != NULL) != (table[i].size != 0) || (m.twin != NULL && device_of(&m)->sii_size != table[i].size))
            fail_msg("row %zu: expected %u bytes, got %u (%s)", i, table[i].size,
                     m.twin != NULL ? device_of(&m)->sii_size : 0, why);
        if (m.twin != NULL)
            expect_note("an EEPROM", &m, table[i].text);
        else
            assert_string_equal(why, table[i].text);
        free_made(&m);
        free(text);
    }
}

static void eeprom_of_the_file(void **state)
{
    static const struct {
        const char *what, *eeprom;
        bool coe;
        uint16_t size;
        const char *note;
    } table[] = {
        {"room for all", EEPROM_OF("1024"), true, 1024, NULL},
        {"no names of entries", EEPROM_OF("640"), true, 640, "an EEPROM of 640 bytes has no room for the names of PDO"},
        {"no names of PDOs", EEPROM_OF("512"), true, 512,
         "an EEPROM of 512 bytes has no room for the names of PDOs and their entries"},
        {"no names of modes", EEPROM_OF("500"), true, 512,
         "an EEPROM of 512 bytes has no room for the names of PDOs and their entries"},
        {"no PDOs that are free", EEPROM_OF("384"), true, 384,
         "an EEPROM of 384 bytes has no room for the unassigned PDOs, and all names of PDOs"},
        {"no PDOs", EEPROM_OF("256"), true, 256, "an EEPROM of 256 bytes has no room for all PDOs, which"},
        {"not even that", EEPROM_OF("128"), true, 256, "an EEPROM of 256 bytes has no room for all PDOs, which"},
        {"without CoE the PDOs stay", EEPROM_OF("256"), false, 512,
         "an EEPROM of 512 bytes has no room for the names of PDOs and their entries"},
        {"no size in the file", "", true, 1024, NULL},
        {"a size of zero", EEPROM_OF("0"), true, 1024, NULL},
        {"more than the address of a word", EEPROM_OF("131072"), true, 0xFF80, "its EEPROM has 131072 bytes; the"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = sized(table[i].eeprom, table[i].coe);
        made_t m = make_text(table[i].what, text);
        size_t count;
        (void)ect_esi_twin_notes(m.twin, &count);
        uint8_t *image = image_of(m.twin); /* it fits */
        if (device_of(&m)->sii_size != table[i].size || (table[i].note == NULL && count > 0) ||
            (table[i].note != NULL && note_of(&m, table[i].note) == NULL))
            fail_msg("%s: expected %u bytes and \"%s\", got %u and \"%s\"", table[i].what, table[i].size,
                     table[i].note ? table[i].note : "no note", device_of(&m)->sii_size, first_note(m.twin));
        free(image);
        free_made(&m);
        free(text);
    }
}

/* The omitted parts. */
static void parts_left_out(void **state)
{
    static const struct {
        const char *eeprom;
        unsigned int strings, pdos;
        bool modes;
    } table[] = {{EEPROM_OF("1024"), 24, 4, true},
                 {EEPROM_OF("640"), 8, 4, true},
                 {EEPROM_OF("512"), 4, 4, true},
                 {EEPROM_OF("384"), 2, 2, false},
                 {EEPROM_OF("256"), 2, 0, false}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = sized(table[i].eeprom, true);
        made_t m = make_text("parts", text);
        uint8_t *image = image_of(m.twin);
        size_t size = device_of(&m)->sii_size, length = 0;
        const uint8_t *strings = ect_sii_category(image, size, ECT_SII_STRINGS, &length);
        const uint8_t *dc = ect_sii_category(image, size, ECT_SII_DC, &length);
        assert_true(strings != NULL && dc != NULL && length == 24);
        bool modes = dc[18] != 0;
        bool pdos = ect_sii_category(image, size, ECT_SII_TXPDO, &length) != NULL;
        size_t bytes = pdos ? length : 0;
        if (strings[0] != table[i].strings || bytes != table[i].pdos * (8u + 4 * 8) || modes != table[i].modes)
            fail_msg("%u bytes: expected %u strings, %u PDOs, modes %d, got %u, %zu bytes, %d", (unsigned int)size,
                     table[i].strings, table[i].pdos, table[i].modes, strings[0], bytes, modes);
        free(image);
        free_made(&m);
        free(text);
    }
}

/* --- what only the file has -------------------------------------------------------------------------------------- */

static void start_up_commands(void **state)
{
    static const uint8_t filter[2] = {7, 0}, key[4] = {1, 2, 3, 4};
    wire_t w;
    uint8_t got[8];
    size_t size = sizeof got;
    (void)state;
    ect_esi_twin_t *twin = make("extras.xml", "");
    power_on(&w, twin);
    wire_go(&w, 0, PREOP);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8000, 0, false, filter, 2), 0);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8001, 0, false, filter, 2), 0);
    assert_int_equal(wire_sdo_download(&w, 0, 0xF800, 2, false, key, 4), 0);
    assert_int_equal(wire_sdo_upload(&w, 0, 0xF800, 2, false, got, &size), 0);
    assert_int_equal(size, 4);
    assert_memory_equal(got, key, 4);
    wire_close(&w);
    ect_esi_twin_free(twin);
}

static void start_up_notes(void **state)
{
    static const char *const expected[] = {
        "line 63: category 30 of the EEPROM is left out: its number or length is taken",
        "line 56: a start-up command writes 8000:0, which is read-only in the file: the twin makes it writable",
        "line 58: a start-up command writes F800:2, which the dictionary lacks: it is added",
    };
    (void)state;
    ect_esi_twin_t *twin = make("extras.xml", "");
    size_t count;
    const char *const *lines = ect_esi_twin_notes(twin, &count);
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        const char *colon = strchr(expected[i], ':');
        bool there = false;
        for (size_t k = 0; k < count; k++)
            there = there || strstr(lines[k], colon) != NULL;
        if (!there)
            fail_msg("expected the note \"%s\" of %zu, the first \"%s\"", colon, count, lines[0]);
    }
    ect_esi_twin_free(twin);
}

static void categories_in_the_sii(void **state)
{
    static const struct {
        uint16_t number;
        size_t length;
        uint8_t bytes[6];
    } table[] = {{2048, 6, {1, 2, 3, 4, 5, 0}},
                 {2049, 6, {'H', 'e', 'l', 'l', 'o', 0}},
                 {2050, 2, {2, 1}},
                 {2051, 4, {0xFE, 0xFF, 0xFF, 0xFF}}};
    (void)state;
    ect_esi_twin_t *twin = make("extras.xml", "");
    uint8_t *image = image_of(twin);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        size_t length = 0;
        const uint8_t *data =
            ect_sii_category(image, ect_esi_twin_product(twin)->device->sii_size, table[i].number, &length);
        if (data == NULL || length != table[i].length || memcmp(data, table[i].bytes, length) != 0)
            fail_msg("category %u: expected %zu bytes %02X %02X.., got %zu bytes", table[i].number, table[i].length,
                     table[i].bytes[0], table[i].bytes[1], data != NULL ? length : 0);
    }
    free(image);
    ect_esi_twin_free(twin);
}

static void assignments(void **state)
{
    char text[300];
    (void)state;
    ect_esi_t *esi = ect_esi_open(ESI_FILES "/extras.xml", text, sizeof text);
    assert_non_null(esi);
    size_t count;
    assert_string_equal(ect_esi_heads(esi, &count)->extras,
                        "start-up commands: 3, alternative assignments: 2, EEPROM categories: 5");
    const ect_esi_device_t *m = ect_esi_select(esi, "", text, sizeof text);
    assert_non_null(m);
    assert_int_equal(m->alternative_count, 3);
    assert_string_equal(m->alternatives[0].name, "Standard");
    assert_true(m->alternatives[0].preset && !m->alternatives[1].preset);
    assert_string_equal(m->alternatives[2].name, "Compact & small");
    assert_int_equal(m->alternatives[1].pdo_count, 0);
    assert_int_equal(m->alternatives[2].sm, 3);
    assert_int_equal(m->alternatives[2].pdo_count, 2);
    assert_int_equal(m->alternatives[2].pdos[1], 0x1A02);
    assert_int_equal(m->mode_assignment_count, 1);
    assert_string_equal(m->mode_assignments[0].name, "DC");
    assert_int_equal(m->mode_assignments[0].pdos[0], 0x1A00);
    ect_esi_close(esi);
}

/* The file of a twin, as `ectwin esi` writes it. */
static const char *written(ect_arena_t *arena, const ect_esi_twin_t *twin)
{
    char why[300];
    size_t length;
    const ect_esi_part_t part = {.device = ect_esi_twin_product(twin)->device, .twin = twin};
    const char *text = ect_esi_write(arena, &part, 1, &length, why, sizeof why);
    if (text == NULL)
        fail_msg("expected a file, got: %s", why);
    return text;
}

static void extras_survive(void **state)
{
    static const struct {
        const char *file;
        const char *parts[12];
    } table[] = {
        {"extras.xml",
         {"<AlternativeSmMapping Default=\"1\">", "<Name><![CDATA[Compact & small]]></Name>", "<Pdo>#x1a02</Pdo>",
          "<InitCmd>", "<Data>01020304</Data>", "<InitCmd Chn=\"1\">", "<Pdo OSFac=\"2\">#x1a00</Pdo>",
          "<CatNo>2048</CatNo>", "<Data>0102030405</Data>", "<Data>48656C6C6F</Data>", "ChannelCount=\"2\""}},
        {"modular.xml",
         {"<Slots MaxSlotCount=\"4\" SlotPdoIncrement=\"1\"", "<ModuleIdent Default=\"1\">#x00000110</ModuleIdent>",
          "<ModuleClass>", "<Modules>", "<Type ModuleIdent=\"#x00000110\" ModuleClass=\"IO\">IN</Type>",
          "<Index DependOnSlot=\"1\">#x7000</Index>"}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_arena_t arena = {0};
        ect_esi_twin_t *twin = make(table[i].file, "");
        const char *text = written(&arena, twin);
        for (const char *const *part = table[i].parts; *part != NULL; part++) {
            if (strstr(text, *part) == NULL)
                fail_msg("%s: expected %s in the file, got %s", table[i].file, *part, text);
        }
        made_t again = make_text(table[i].file, text);
        const char *twice = written(&arena, again.twin);
        assert_string_equal(twice, text);
        assert_int_equal(device_of(&again)->object_count, ect_esi_twin_product(twin)->device->object_count);
        free_made(&again);
        ect_esi_twin_free(twin);
        ect_arena_free(&arena);
    }
}

/* With modules that a user chose the file describes the device without slots. */
static void chosen_modules_stay(void **state)
{
    static const ect_module_choice_t choice = {.slot = 1, .ident = 0x120};
    char why[300];
    ect_arena_t arena = {0};
    (void)state;
    ect_esi_twin_t *twin = ect_esi_twin_make(ESI_FILES "/modular.xml", "", &choice, 1, why, sizeof why);
    assert_non_null(twin);
    assert_null(ect_esi_twin_without_modules(twin));
    const char *text = written(&arena, twin);
    assert_null(strstr(text, "<Slots"));
    assert_non_null(strstr(text, "<Index>#x1601</Index>"));
    ect_esi_twin_free(twin);
    ect_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"a PDO maps 18xxh: an entry of a PDO parameter object is no mapping", state_and_toggle, NULL, NULL, NULL},
        {"MDP-034: the toggle bit of 1800h:9 changes with the inputs that a signal sets", toggle_on_the_wire, NULL,
         NULL, NULL},
        {"a PDO that maps a mapping object gets a gap, with a note", mapped_mapping, NULL, NULL, NULL},
        {"MinData and MaxData are read by the sign of the type", limits_by_sign, NULL, NULL, NULL},
        {"PDOs without entries, and entries without bits, are a note", empty_pdos, NULL, NULL, NULL},
        {"a mapping of a master has room in a SyncManager without MaxSize", mapping_without_max_size, NULL, NULL, NULL},
        {"a sensor accepts finite values only", infinite_values_of_sensors, NULL, NULL, NULL},
        {"a set value in floating point that is infinite or no number", infinite_set_values, NULL, NULL, NULL},
        {"settings of a drive that are 0 in the file, and missing ones", settings_of_zero, NULL, NULL, NULL},
        {"a turn without 608Fh has a hundred times 6065h of the file", resolutions, NULL, NULL, NULL},
        {"PDO configuration is a service only where something can be written", services, NULL, NULL, NULL},
        {"1C00h has the names of the file", name_of_1c00, NULL, NULL, NULL},
        {"a note of one kind appears once, with the number of those like it", notes_are_counted, NULL, NULL, NULL},
        {"an EEPROM has up to 65408 bytes, in steps of 128", sizes_of_EEPROMs, NULL, NULL, NULL},
        {"notes of several kinds have a count each", kinds_of_notes_are_counted, NULL, NULL, NULL},
        {"a note is cut at its length", long_notes, NULL, NULL, NULL},
        {"the time for a twin grows with its objects, not with their square", time_in_objects, NULL, NULL, NULL},
        {"a dictionary of more entries than a twin can have is refused", too_many_entries, NULL, NULL, NULL},
        {"a virtual SyncManager is in the SII with its registers, its length and its flag", virtual_in_the_sii, NULL,
         NULL, NULL},
        {"PDOs of virtual SyncManagers are in the SII, with their SyncManager", virtual_pdos, NULL, NULL, NULL},
        {"entries that stand for registers have no signals", no_virtual_signals, NULL, NULL, NULL},
        {"FMMUs of virtual SyncManagers read 0910h and write 0990h", registers_by_fmmu, NULL, NULL, NULL},
        {"the category General has the file's flags, identification, channels and ports", general, NULL, NULL, NULL},
        {"the category SyncM has bits 0 to 3 of Enable, with OpOnly", enable_bits, NULL, NULL, NULL},
        {"an EEPROM has the file's ByteSize, and omits parts in order", eeprom_of_the_file, NULL, NULL, NULL},
        {"CF-061 an EEPROM without room for the categories is doubled, up to 64 KB", enlarged_eeproms, NULL, NULL,
         NULL},
        {"an EEPROM too small has no names, then no free PDOs, then no PDOs", parts_left_out, NULL, NULL, NULL},
        {"The object of a start-up command exists and is writable", start_up_commands, NULL, NULL, NULL},
        {"a start-up command that the dictionary contradicts is a note", start_up_notes, NULL, NULL, NULL},
        {"categories of the file are in the EEPROM", categories_in_the_sii, NULL, NULL, NULL},
        {"alternative assignments and PDOs of clock modes are in the model", assignments, NULL, NULL, NULL},
        {"start-up commands, alternatives, categories, slots survive writing", extras_survive, NULL, NULL, NULL},
        {"a device with chosen modules is written with them", chosen_modules_stay, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
