/* SPDX-License-Identifier: MIT */
/* Devices of ESI files as twins: the same stack, chain and signals as for every other device. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/signals.h"
#include "esi/twin.h"
#include "support/wire.h"

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };

static ect_esi_twin_t *make(const char *file, const char *selector, const ect_module_choice_t *modules, size_t count)
{
    char path[300];
    char text[300] = "";
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, file);
    ect_esi_twin_t *twin = ect_esi_twin_make(path, selector, modules, count, text, sizeof text);
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

static void expect_signal(const wire_t *w, const char *name, const char *expected)
{
    ect_signal_ref_t ref;
    char text[ECT_SIGNAL_TEXT_ROOM];
    if (!ect_chain_signal(w->chain, 0, name, &ref))
        fail_msg("there is no signal %s", name);
    ect_signal_read(&ref, text);
    if (strcmp(text, expected) != 0)
        fail_msg("%s: expected %s, got %s", name, expected, text);
}

static void sizes(void **state)
{
    static const struct {
        const char *file, *selector;
        unsigned int sm, bits;
    } table[] = {
        {"digital.xml", "DI4", 0, 5},     {"digital.xml", "DO16", 0, 8}, {"digital.xml", "DO16", 1, 8},
        {"analog.xml", "AI2", 2, 16},     {"analog.xml", "AI2", 3, 48},  {"analog.xml", "DRIVE", 2, 48},
        {"analog.xml", "DRIVE", 3, 48},   {"modular.xml", "RACK", 2, 0}, {"modular.xml", "RACK", 3, 48},
        {"digital.xml", "COUPLER", 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_twin_t *twin = make(table[i].file, table[i].selector, NULL, 0);
        ect_od_t od = ect_device_od(ect_esi_twin_product(twin)->device, NULL);
        uint32_t bits = ect_od_sm_bits(&od, table[i].sm);
        if (bits != table[i].bits)
            fail_msg("%s SyncManager %u: expected %u bits, got %u", table[i].selector, table[i].sm, table[i].bits,
                     (unsigned int)bits);
        ect_esi_twin_free(twin);
    }
}

static void dictionary(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex, size;
        uint8_t bytes[8];
    } table[] = {
        {0x1000, 0, 4, {0x89, 0x13, 0, 0}},
        {0x1008, 0, 3, {'A', 'I', '2'}},
        {0x1018, 1, 4, {0x57, 0x0E, 0, 0}},
        {0x1018, 2, 4, {0x02, 0x31, 0, 0}},
        {0x1C00, 0, 1, {4}},
        {0x1C00, 4, 1, {4}},
        {0x1C12, 1, 2, {0x00, 0x16}},
        {0x1C13, 0, 1, {2}},
        {0x1C13, 1, 2, {0x00, 0x1A}},
        {0x1C13, 2, 2, {0x02, 0x1A}},
        {0x1A00, 0, 1, {5}},
        {0x1A00, 4, 4, {12, 0, 0, 0}},
        {0x1A00, 5, 4, {16, 17, 0x00, 0x60}},
        {0x8000, 0, 1, {18}},
        {0x8000, 1, 1, {1}},
        {0x8000, 2, 1, {2}},
        {0x8000, 17, 2, {0xFB, 0xFF}},
        {0x8000, 18, 8, {0, 0, 0, 0, 0, 0, 0xF0, 0x3F}},
        {0x8010, 0, 1, {4}},
        {0x8010, 3, 2, {3, 0}},
        {0x8010, 4, 2, {0xFF, 0xFF}},
        {0x6000, 0, 1, {17}},
    };
    wire_t w;
    (void)state;
    ect_esi_twin_t *twin = make("analog.xml", "AI2", NULL, 0);
    power_on(&w, twin);
    wire_go(&w, 0, PREOP);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        uint8_t got[64] = {0};
        size_t size = sizeof got;
        uint32_t code = wire_sdo_upload(&w, 0, table[i].index, table[i].subindex, false, got, &size);
        if (code != 0 || size != table[i].size || memcmp(got, table[i].bytes, size) != 0)
            fail_msg("%04X:%u: expected %u bytes %02X %02X.., got abort %08X, %zu bytes %02X %02X..", table[i].index,
                     table[i].subindex, table[i].size, table[i].bytes[0], table[i].bytes[1], (unsigned int)code, size,
                     got[0], got[1]);
    }
    wire_close(&w);
    ect_esi_twin_free(twin);
}

static void writing(void **state)
{
    static const struct {
        const char *what;
        uint16_t index;
        uint8_t subindex, size;
        uint8_t bytes[8];
        uint8_t al;
        uint32_t code;
    } table[] = {
        {"within the limits", 0x8000, 17, 2, {0xE8, 0x03}, PREOP, 0},
        {"above the maximum", 0x8000, 17, 2, {0xE9, 0x03}, PREOP, 0x06090031},
        {"below the minimum", 0x8000, 17, 2, {0x17, 0xFC}, PREOP, 0x06090032},
        {"no value of the enumeration", 0x8000, 2, 1, {3}, PREOP, 0x06090031},
        {"a value of the enumeration", 0x8000, 2, 1, {0}, PREOP, 0},
        {"read only", 0x1000, 0, 4, {0}, PREOP, 0x06010002},
        {"an array's element", 0x8010, 2, 2, {7, 7}, PREOP, 0},
        {"no such sub-index", 0x8010, 5, 2, {7, 7}, PREOP, 0x06090011},
        {"only in PREOP and SAFEOP", 0x8000, 17, 2, {1, 0}, SAFEOP, 0},
        {"not in OP", 0x8000, 17, 2, {1, 0}, OP, 0x08000022},
    };
    wire_t w;
    (void)state;
    ect_esi_twin_t *twin = make("analog.xml", "AI2", NULL, 0);
    power_on(&w, twin);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        wire_go(&w, 0, table[i].al);
        uint32_t code =
            wire_sdo_download(&w, 0, table[i].index, table[i].subindex, false, table[i].bytes, table[i].size);
        if (code != table[i].code)
            fail_msg("%04X:%u, %s: expected abort code %08X, got %08X", table[i].index, table[i].subindex,
                     table[i].what, (unsigned int)table[i].code, (unsigned int)code);
    }
    wire_close(&w);
    ect_esi_twin_free(twin);
}

/* 1A00h and 1A01h exclude each other: the smaller one instead. */
static void alternatives(void **state)
{
    static const uint8_t none = 0, two = 2, first[2] = {0x01, 0x1A};
    wire_t w;
    uint8_t in[4] = {0};
    (void)state;
    ect_esi_twin_t *twin = make("analog.xml", "AI2", NULL, 0);
    power_on(&w, twin);
    wire_go(&w, 0, PREOP);
    assert_int_equal(wire_sdo_download(&w, 0, 0x1C13, 0, false, &none, 1), 0);
    assert_int_equal(wire_sdo_download(&w, 0, 0x1C13, 1, false, first, 2), 0);
    assert_int_equal(wire_sdo_download(&w, 0, 0x1C13, 0, false, &two, 1), 0);
    wire_set_sm(&w, 0, 2, 0x1200, 2, 0x24);
    wire_set_sm(&w, 0, 3, 0x1300, 4, 0x20);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    set(&w, "ai_standard_channel_1.value", "-2");
    set(&w, "ai_compact_channel_2.value", "258");
    wire_poll(&w);
    assert_int_equal(wire_read(&w, 0, 0x1300, in, sizeof in), 1);
    assert_int_equal(wire_read(&w, 0, 0x1300, in, sizeof in), 1);
    static const uint8_t expected[4] = {0xFE, 0xFF, 0x02, 0x01};
    assert_memory_equal(in, expected, sizeof in);
    wire_close(&w);
    ect_esi_twin_free(twin);
}

static void process_data(void **state)
{
    wire_t w;
    uint8_t in[6] = {0}, out[2] = {0x34, 0x12};
    (void)state;
    ect_esi_twin_t *twin = make("analog.xml", "AI2", NULL, 0);
    power_on(&w, twin);
    wire_go(&w, 0, OP);
    set(&w, "ai_standard_channel_1.overrange", "1");
    set(&w, "ai_standard_channel_1.limit_1", "3");
    set(&w, "ai_standard_channel_1.value", "-32768");
    wire_poll(&w);
    assert_int_equal(wire_read(&w, 0, 0x1300, in, sizeof in), 1);
    assert_int_equal(wire_read(&w, 0, 0x1300, in, sizeof in), 1);
    static const uint8_t expected[6] = {0x0E, 0x00, 0x00, 0x80, 0x00, 0x00};
    assert_memory_equal(in, expected, sizeof in);
    assert_int_equal(wire_write(&w, 0, 0x1200, out, sizeof out), 1);
    expect_signal(&w, "ao.value", "4660");
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    expect_signal(&w, "ao.value", "0");
    wire_close(&w);
    ect_esi_twin_free(twin);
}

/* A terminal without a microcontroller: its chip answers AL control by itself, its outputs are registers. */
static void without_a_mailbox(void **state)
{
    wire_t w;
    uint8_t in = 0;
    (void)state;
    ect_esi_twin_t *twin = make("digital.xml", "DI4", NULL, 0);
    power_on(&w, twin);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    set(&w, "channel_1.input", "1");
    set(&w, "channel_3_2.input", "1"); /* two PDOs of the file are named Channel 3 */
    wire_poll(&w);
    (void)wire_read(&w, 0, 0x1000, &in, 1);
    assert_int_equal(wire_read(&w, 0, 0x1000, &in, 1), 1);
    assert_int_equal(in, 0x11);
    wire_close(&w);
    ect_esi_twin_free(twin);

    twin = make("digital.xml", "DO16", NULL, 0);
    power_on(&w, twin);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    assert_int_equal(wire_write8(&w, 0, 0x0F00, 0x5A), 1);
    assert_int_equal(wire_write8(&w, 0, 0x0F01, 0xC3), 1);
    assert_int_equal(wire_al(&w, 0, OP, NULL), OP);
    assert_int_equal(wire_write8(&w, 0, 0x0F00, 0x5A), 1);
    assert_int_equal(wire_write8(&w, 0, 0x0F01, 0xC3), 1);
    expect_signal(&w, "byte_1.output", "90");
    expect_signal(&w, "byte_2.output", "195");
    wire_close(&w);
    ect_esi_twin_free(twin);
}

static void modules(void **state)
{
    static const struct {
        const char *what;
        ect_module_choice_t choices[3];
        size_t count;
        unsigned int out_bits, in_bits;
        uint16_t object;
        const char *refusal;
    } table[] = {
        {"presets of the file", {{0, 0}}, 0, 0, 48, 0x6000, NULL},
        {"another one in the first slot", {{0, 0x120}}, 1, 32, 16, 0x8000, NULL},
        {"all four", {{1, 0x120}, {2, 0x120}, {3, 0x110}}, 3, 64, 80, 0x8020, NULL},
        {"a module that the file has not", {{1, 0x130}}, 1, 0, 0, 0, "slot 2 (Others) takes no module 0x00000130"},
        {"a slot that the device has not", {{4, 0x110}}, 1, 0, 0, 0, "there is no slot 5; the device has 4"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[300] = "a twin";
        ect_esi_twin_t *twin =
            ect_esi_twin_make(ESI_FILES "/modular.xml", "", table[i].choices, table[i].count, text, sizeof text);
        if ((twin == NULL) != (table[i].refusal != NULL) || (twin == NULL && strstr(text, table[i].refusal) == NULL))
            fail_msg("%s: expected %s, got %s", table[i].what, table[i].refusal ? table[i].refusal : "a twin", text);
        if (twin == NULL)
            continue;
        ect_od_t od = ect_device_od(ect_esi_twin_product(twin)->device, NULL);
        uint32_t out = ect_od_sm_bits(&od, 2), in = ect_od_sm_bits(&od, 3);
        if (out != table[i].out_bits || in != table[i].in_bits || ect_od_find(&od, table[i].object) == NULL)
            fail_msg("%s: expected %u and %u bits and object %04X, got %u and %u", table[i].what, table[i].out_bits,
                     table[i].in_bits, table[i].object, (unsigned int)out, (unsigned int)in);
        ect_esi_twin_free(twin);
    }
}

static void notes(void **state)
{
    size_t count;
    (void)state;
    ect_esi_twin_t *twin = make("analog.xml", "AI2", NULL, 0);
    const char *const *lines = ect_esi_twin_notes(twin, &count);
    if (count != 1 || strcmp(lines[0], "FoE answered with \"unsupported protocol\"") != 0)
        fail_msg("expected one note, about FoE; got %zu, the first: %s", count, count > 0 ? lines[0] : "none");
    ect_esi_twin_free(twin);
}

/* The flags that a master's tool needs: of the description, and thereby of the EEPROM. */
static void flags(void **state)
{
    static const struct {
        uint16_t index, flags, excludes;
    } table[] = {{0x1600, ECT_PDO_FIXED | ECT_PDO_MANDATORY, 0},
                 {0x1A00, ECT_PDO_FIXED, 0x1A01},
                 {0x1A01, ECT_PDO_FIXED, 0x1A00},
                 {0x1A02, ECT_PDO_FIXED, 0}};
    (void)state;
    ect_esi_twin_t *twin = make("analog.xml", "AI2", NULL, 0);
    const ect_device_t *device = ect_esi_twin_product(twin)->device;
    assert_int_equal(device->pdo_count, sizeof table / sizeof table[0]);
    for (size_t i = 0; i < device->pdo_count; i++) {
        const ect_pdo_t *pdo = &device->pdos[i];
        uint16_t excludes = pdo->excludes != NULL ? pdo->excludes[0] : 0;
        if (pdo->index != table[i].index || pdo->flags != table[i].flags || excludes != table[i].excludes)
            fail_msg("PDO %zu: expected %04X flags %02X excludes %04X, got %04X flags %02X excludes %04X", i,
                     table[i].index, table[i].flags, table[i].excludes, pdo->index, pdo->flags, excludes);
    }
    ect_esi_twin_free(twin);
}

/* Files contradict themselves: the twin runs, with a note. */
static void contradictions(void **state)
{
    static const char text[] =
        "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device>"
        "<Type ProductCode='1' RevisionNo='1'>D</Type><Profile><Dictionary><DataTypes>"
        "<DataType><Name>BIT2</Name><BitSize>2</BitSize></DataType>"
        "<DataType><Name>INT</Name><BitSize>16</BitSize></DataType></DataTypes><Objects>"
        "<Object><Index>#x2000</Index><Name>A</Name><Type>BIT2</Type><BitSize>2</BitSize><Info>"
        "<DefaultData>FF</DefaultData></Info></Object>"
        "<Object><Index>#x2001</Index><Name>B</Name><Type>INT</Type><BitSize>16</BitSize><Info>"
        "<MinValue>-5</MinValue><MaxValue>5</MaxValue><DefaultValue>-6</DefaultValue></Info></Object>"
        "<Object><Index>#x2002</Index><Name>C</Name><Type>INT</Type><BitSize>16</BitSize><Info>"
        "<MinValue>-6</MinValue><MaxValue>5</MaxValue><DefaultValue>-6</DefaultValue></Info></Object>"
        "</Objects></Dictionary></Profile>"
        "<Sm StartAddress='#x1000' DefaultSize='128' ControlByte='#x26'>MBoxOut</Sm>"
        "<Sm StartAddress='#x1080' DefaultSize='128' ControlByte='#x22'>MBoxIn</Sm><Mailbox><CoE/></Mailbox>"
        "</Device></Devices></Descriptions></EtherCATInfo>";
    static const char *const expected[] = {"object 2000:0: its default 0xFF is truncated to 2 bits",
                                           "object 2001:0: its default -6 is not within its limits -5 to 5: no limits"};
    char message[300] = "";
    size_t count;
    (void)state;
    ect_esi_t *esi = ect_esi_parse("contradictions.xml", text, strlen(text), message, sizeof message);
    const ect_esi_device_t *model = esi != NULL ? ect_esi_select(esi, "", message, sizeof message) : NULL;
    ect_esi_twin_t *twin = model != NULL ? ect_esi_twin_of(esi, model, NULL, 0, message, sizeof message) : NULL;
    if (twin == NULL)
        fail_msg("expected a twin, got: %s", message);
    const char *const *lines = ect_esi_twin_notes(twin, &count);
    for (size_t i = 0; i < 2; i++) {
        if (count != 2 || strcmp(lines[i], expected[i]) != 0)
            fail_msg("note %zu of 2: expected \"%s\", got \"%s\" of %zu", i + 1, expected[i],
                     i < count ? lines[i] : "none", count);
    }
    ect_od_t od = ect_device_od(ect_esi_twin_product(twin)->device, NULL);
    assert_null(ect_od_detail(&od, 0x2001, 0));
    assert_int_equal(ect_od_detail(&od, 0x2002, 0)->minimum, -6);
    assert_int_equal(ect_od_find(&od, 0x2000)->entries[0].value, 3);
    ect_esi_twin_free(twin);
    ect_esi_close(esi);
}

/* A device whose process data would differ from those of the file is refused, with the line. */
static void no_hole(void **state)
{
    static const char text[] = "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device>\n"
                               "<Type ProductCode='1' RevisionNo='1'>D</Type>\n"
                               "<Sm StartAddress='#x1000' DefaultSize='128' ControlByte='#x26'>MBoxOut</Sm>"
                               "<Sm StartAddress='#x1080' DefaultSize='128' ControlByte='#x22'>MBoxIn</Sm>"
                               "<Sm StartAddress='#x1100' DefaultSize='1' ControlByte='#x24'>Outputs</Sm>\n"
                               "<RxPdo Sm='2'><Index>#x1A00</Index><Name>O</Name><Entry><Index>#x7000</Index>"
                               "<SubIndex>1</SubIndex><BitLen>8</BitLen></Entry></RxPdo>\n"
                               "<Mailbox><CoE/></Mailbox></Device></Devices></Descriptions></EtherCATInfo>";
    char message[300] = "";
    (void)state;
    ect_esi_t *esi = ect_esi_parse("hole.xml", text, strlen(text), message, sizeof message);
    assert_non_null(esi);
    const ect_esi_device_t *model = ect_esi_select(esi, "", message, sizeof message);
    assert_non_null(model);
    assert_null(ect_esi_twin_of(esi, model, NULL, 0, message, sizeof message));
    ect_esi_close(esi);
    assert_string_equal(message, "hole.xml:1: D: line 4: PDO 1A00 (O) is assigned to SyncManager 2, and its index is "
                                 "not that of a PDO of outputs");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"each SyncManager has the bits of the PDOs that the file assigns to it", sizes, NULL, NULL, NULL},
        {"defaults, texts, arrays, enumerations of the file's dictionary; missing parts are generated", dictionary,
         NULL, NULL, NULL},
        {"limits, rights and restrictions to AL states are the file's", writing, NULL, NULL, NULL},
        {"PDOs that exclude each other are chosen by 1C13h", alternatives, NULL, NULL, NULL},
        {"signals set inputs and show outputs, which are cleared when OP is left", process_data, NULL, NULL, NULL},
        {"CF-045 terminals without a mailbox: AL status follows by itself, outputs in registers", without_a_mailbox,
         NULL, NULL, NULL},
        {"a module's PDOs and objects move with its slot", modules, NULL, NULL, NULL},
        {"each feature that the twin does not have is a note", notes, NULL, NULL, NULL},
        {"PDOs are fixed, mandatory and exclude each other as in the file", flags, NULL, NULL, NULL},
        {"a device whose assigned PDO cannot be is refused", no_hole, NULL, NULL, NULL},
        {"a default outside of its limits or its length is a note, and the twin runs", contradictions, NULL, NULL,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
