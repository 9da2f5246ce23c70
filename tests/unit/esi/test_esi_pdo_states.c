/* SPDX-License-Identifier: MIT */
/* Parameters of PDOs, 1800h to 19FFh, in a running twin (src/esi/pdo_states.c): tests/esi/states.xml. */
#include "rack.h"

#include "bus/chain/settings.h"
#include "esc/route.h"

enum { OP = ECT_STATE_OP, INPUTS = 3, REVISION = 0x00030001, LOGICAL = 0x10000 };

static void open_states(rig_t *r, uint8_t state)
{
    memset(r, 0, sizeof *r);
    r->made.twin = ect_esi_twin_make(ESI_FILES "/states.xml", "STATES", NULL, 0, r->made.why, sizeof r->made.why);
    if (r->made.twin == NULL)
        fail_msg("%s", r->made.why);
    const ect_product_t *product = ect_esi_twin_product(r->made.twin);
    const ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    wire_open_twins(&r->wire, &config, 1);
    wire_go(&r->wire, 0, state);
    if (state >= SAFEOP)
        wire_set_fmmu(&r->wire, 0, 0, LOGICAL, INPUTS, 0, 7, 0x1180, 0, 1);
}

static void set(rig_t *r, const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE];
    const ect_setting_t setting = {.name = name, .value = value};
    if (!ect_settings_apply(r->wire.chain, 0, &setting, 1, r->wire.now_ns, message))
        fail_msg("%s=%s: %s", name, value, message);
    wire_poll(&r->wire);
}

/* The first byte of the inputs, as a master reads it in a cycle: bit 0 toggle, bit 1 state. */
static uint8_t cycle(rig_t *r)
{
    uint8_t image[INPUTS] = {0};
    assert_int_equal(wire_logical(&r->wire, ECT_LRD, LOGICAL, image, sizeof image), 1);
    wire_poll(&r->wire);
    return image[0];
}

static void toggles(void **state)
{
    static const uint8_t states[] = {SAFEOP, OP};
    (void)state;
    for (size_t i = 0; i < sizeof states; i++) {
        rig_t r;
        open_states(&r, states[i]);
        uint8_t before = cycle(&r);
        for (unsigned int n = 0; n < 6; n++) {
            const uint8_t now = cycle(&r);
            if (now != (before ^ 1))
                fail_msg("AL state %u, cycle %u: expected %02X, got %02X", states[i], n, before ^ 1, now);
            before = now;
        }
        close_rig(&r);
    }
}

static void once_in_a_cycle(void **state)
{
    rig_t r;
    (void)state;
    open_states(&r, OP);
    uint8_t before = cycle(&r);
    for (unsigned int renewals = 0; renewals < 5; renewals++) {
        for (unsigned int n = 0; n < renewals; n++) /* the device renews its inputs before the master reads them */
            set(&r, "long.value", n % 2 == 0 ? "1" : "2");
        const uint8_t now = cycle(&r);
        if (now != (before ^ 1))
            fail_msg("%u renewals: expected %02X, got %02X", renewals, before ^ 1, now);
        before = now;
    }
    close_rig(&r);
}

static void held(void **state)
{
    rig_t r;
    (void)state;
    open_states(&r, OP);
    (void)cycle(&r);
    set(&r, "toggle.hold", "1");
    (void)cycle(&r);
    const uint8_t before = cycle(&r);
    for (unsigned int n = 0; n < 4; n++)
        assert_int_equal(cycle(&r), before);
    set(&r, "toggle.hold", "0");
    (void)cycle(&r);
    const uint8_t after = cycle(&r);
    assert_int_equal(cycle(&r), after ^ 1);
    close_rig(&r);
}

static void faulty(void **state)
{
    rig_t r;
    (void)state;
    open_states(&r, OP);
    assert_int_equal(cycle(&r) & 2, 0);
    set(&r, "long.state", "1");
    (void)cycle(&r);
    assert_int_equal(cycle(&r) & 2, 2);
    assert_int_equal(read_number(&r, 0x1800, 7) & 0xFF, 1);
    close_rig(&r);
}

static void mapped(void **state)
{
    rig_t r;
    ect_signal_ref_t ref;
    (void)state;
    open_states(&r, PREOP);
    assert_int_equal(read_number(&r, 0x1A00, 1), 0x18000901);
    assert_int_equal(read_number(&r, 0x1A00, 2), 0x18000701);
    assert_true(ect_chain_signal(r.wire.chain, 0, "long.toggle", &ref));
    assert_int_equal(ref.signal->access, ECT_SIGNAL_READ); /* the device writes it */
    assert_true(ect_chain_signal(r.wire.chain, 0, "long.state", &ref));
    assert_int_equal(ref.signal->access, ECT_SIGNAL_WRITE);
    close_rig(&r);
}

static uint32_t write16(rig_t *r, uint16_t index, uint8_t subindex, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    return wire_sdo_download(&r->wire, 0, index, subindex, false, bytes, subindex == 0 ? 1 : 2);
}

/* --- beside the behaviour of a profile -----------------------------------------------------------------------------
 */

#define SUB(n, type, bits, offset, flags)                                                                              \
    "<SubItem><SubIdx>" n "</SubIdx><Name>N" n "</Name><Type>" type "</Type><BitSize>" bits                            \
    "</BitSize><BitOffs>" offset "</BitOffs><Flags>" flags "</Flags></SubItem>"
#define VALUE(index, type, bits)                                                                                       \
    "<Object><Index>#x" index "</Index><Name>V</Name><Type>" type "</Type><BitSize>" bits "</BitSize><Flags><Access>"  \
    "rw</Access><PdoMapping>RT</PdoMapping></Flags></Object>"
#define MAPPED(index, sub, bits, type)                                                                                 \
    "<Entry><Index>#x" index "</Index><SubIndex>" sub "</SubIndex><BitLen>" bits                                       \
    "</BitLen><Name>V</Name><DataType>" type "</DataType></Entry>"
/* Inputs: the toggle in bit 0, the value of the profile from byte 1 on. */
#define TOGGLING(profile, objects, entry, mailbox)                                                                     \
    ESI_DEVICE(                                                                                                        \
        "<Profile><ProfileNo>" profile "</ProfileNo><Dictionary><DataTypes><DataType><Name>UDINT</Name>"               \
        "<BitSize>32</BitSize></DataType><DataType><Name>UINT</Name><BitSize>16</BitSize></DataType><DataType>"        \
        "<Name>USINT</Name><BitSize>8</BitSize></DataType><DataType><Name>BOOL</Name><BitSize>1</BitSize>"             \
        "</DataType><DataType><Name>P</Name><BitSize>24</BitSize>" SUB("0", "USINT", "8", "0", "")                     \
            SUB("9", "BOOL", "1", "16",                                                                                \
                "<PdoMapping>T</PdoMapping>") "</DataType></DataTypes><Objects>"                                       \
                                              "<Object><Index>#x1800</Index><Name>TxPDO "                              \
                                              "parameter</Name><Type>P</Type><BitSize>24</BitSize></Object>" objects   \
                                              "</Objects></Dictionary></Profile><Fmmu>Outputs</Fmmu><Fmmu>Inputs</"    \
                                              "Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                                  \
                                              "<TxPdo Sm='3'><Index>#x1A00</Index><Name>P</Name>" MAPPED(              \
                                                  "1800", "9", "1",                                                    \
                                                  "BOOL") "<Entry><"                                                   \
                                                          "Index>0</Index><BitLen>7</BitLen></Entry>" entry            \
                                                          "</TxPdo><Mailbox>" mailbox "</Mailbox>" ESI_EEPROM)

static void beside_a_profile(void **state)
{
    static const struct {
        const char *what, *text, *note, *signal, *setting;
        uint32_t value; /* in the inputs behind the toggle, with the setting */
    } rows[] = {
        {"an encoder",
         TOGGLING("406", VALUE("6004", "UDINT", "32") VALUE("6001", "UDINT", "32"), MAPPED("6004", "0", "32", "UDINT"),
                  "<CoE/>"),
         "CiA 406: encoder 1", "encoder1.position", "0.5", 32768},
        {"a measuring input",
         TOGGLING("404", VALUE("6130", "UDINT", "32"), MAPPED("6130", "0", "32", "UDINT"), "<CoE/>"),
         "CiA 404: input 1", "measure1.value", "7", 7},
        {"a drive",
         TOGGLING("402", VALUE("6040", "UINT", "16") VALUE("6041", "UINT", "16"), MAPPED("6041", "0", "16", "UINT"),
                  "<CoE/>"),
         "CiA 402: axis 1", NULL, NULL, 0x40},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig_t r;
        char why[300] = "";
        uint8_t image[5] = {0};
        memset(&r, 0, sizeof r);
        r.made = make_text(rows[i].what, rows[i].text);
        assert_true(ect_esi_twin_behave(r.made.twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why));
        if (note_of(&r.made, rows[i].note) == NULL)
            fail_msg("%s: expected the note \"%s…\"", rows[i].what, rows[i].note);
        const ect_product_t *product = ect_esi_twin_product(r.made.twin);
        const ect_twin_config_t config = ect_twin_default(product->device, product->plant);
        const ect_sm_t *sm = &product->device->sm[3];
        const uint16_t size = ect_device_sm_bytes(product->device, 3);
        wire_open_twins(&r.wire, &config, 1);
        wire_go(&r.wire, 0, SAFEOP);
        if (rows[i].signal != NULL)
            set(&r, rows[i].signal, rows[i].setting);
        unsigned int before = 2;
        for (unsigned int n = 0; n < 5; n++) {
            assert_int_equal(wire_read(&r.wire, 0, sm->start, image, size), 1);
            wire_poll(&r.wire);
            if (before < 2 && image[0] != (before ^ 1))
                fail_msg("%s, cycle %u: expected %02X, got %02X", rows[i].what, n, before ^ 1, image[0]);
            before = image[0];
        }
        const uint32_t value = image[1] | (uint32_t)image[2] << 8 | (uint32_t)image[3] << 16;
        if ((value & (rows[i].signal != NULL ? 0xFFFFFFu : 0x4Fu)) != rows[i].value)
            fail_msg("%s: expected %u, got %u", rows[i].what, (unsigned int)rows[i].value, (unsigned int)value);
        close_rig(&r);
    }
}

static void parameters(void **state)
{
    rig_t r;
    uint8_t bytes[8] = {0};
    size_t size = sizeof bytes;
    (void)state;
    open_states(&r, PREOP);
    const uint8_t type = 1;
    assert_int_equal(wire_sdo_download(&r.wire, 0, 0x1800, 2, false, &type, 1), 0);
    assert_int_equal(read_number(&r, 0x1800, 2) & 0xFF, 1);
    assert_int_equal(write16(&r, 0x1C13, 0, 0), 0);
    assert_int_equal(write16(&r, 0x1C13, 1, 0x1800), 0x06040041);
    assert_int_equal(wire_sdo_upload(&r.wire, 0, 0x1800, 6, false, bytes, &size), 0);
    assert_int_equal(size, 4);
    assert_memory_equal(bytes, ((const uint8_t[4]){0x01, 0x1A, 0, 0}), 4);
    close_rig(&r);
}

static void excluded(void **state)
{
    static const struct {
        const char *what;
        uint16_t pdos[2];
        uint32_t abort_code;
    } rows[] = {
        {"Exclude of the file", {0x1A00, 0x1A01}, 0x06040047},
        {"Exclude of the file, in the other order", {0x1A01, 0x1A00}, 0x06040047},
        {"sub-index 6 of the dictionary", {0x1A01, 0x1A02}, 0x06040047},
        {"PDOs that exclude neither", {0x1A00, 0x1A02}, 0},
    };
    rig_t r;
    (void)state;
    open_states(&r, PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(write16(&r, 0x1C13, 0, 0), 0);
        assert_int_equal(write16(&r, 0x1C13, 1, rows[i].pdos[0]), 0);
        assert_int_equal(write16(&r, 0x1C13, 2, rows[i].pdos[1]), 0);
        const uint32_t code = write16(&r, 0x1C13, 0, 2);
        if (code != rows[i].abort_code || (read_number(&r, 0x1C13, 0) & 0xFF) != (code == 0 ? 2 : 0))
            fail_msg("%s: abort code %08X, count %u", rows[i].what, (unsigned int)code,
                     (unsigned int)read_number(&r, 0x1C13, 0));
    }
    close_rig(&r);
}

/* --- lists of excluded PDOs --------------------------------------------------------------------------------------- */

/* An object 1800h with sub-index 6 of the type, and PDOs. */
#define LISTING(type, bits, info, pdos)                                                                                \
    ESI_DEVICE(                                                                                                        \
        "<Profile><Dictionary><DataTypes><DataType><Name>USINT</Name><BitSize>8</BitSize></DataType><DataType><Name>L" \
        "</Name><BitSize>96</BitSize>" SUB("0", "USINT", "8", "0", "") SUB(                                            \
            "6", type, bits, "16",                                                                                     \
            "") "</DataType></DataTypes><Objects><Object><Index>#x1800</Index><Name>P</Name><Type>L</Type><BitSize>96" \
                "</BitSize><Info><SubItem><Name>N6</Name><Info>" info                                                  \
                "</Info></SubItem></Info></Object></Objects></Dictionary></Profile>" ESI_MAILBOX_SMS                   \
                    ESI_PROCESS_SMS pdos "<Mailbox><CoE/></Mailbox>" ESI_EEPROM)
#define LISTING_8(info, pdos) LISTING("ARRAY [0..7] OF BYTE", "64", info, pdos)
#define PDO_OF(index, attributes, excludes)                                                                            \
    "<TxPdo " attributes "><Index>#x" index "</Index>" excludes                                                        \
    "<Name>P</Name>" MAPPED("6000", "1", "8", "USINT") "</TxPdo>"
#define EXCLUDE(index) "<Exclude>#x" index "</Exclude>"
#define DEFAULT(bytes) "<DefaultData>" bytes "</DefaultData>"

static void expect_excluded(const char *what, const ect_device_t *device, const uint16_t expected[4])
{
    static const uint16_t none[4];
    const uint16_t *got = none;
    for (unsigned int i = 0; i < device->pdo_count; i++)
        got = device->pdos[i].index == 0x1A00 && device->pdos[i].excludes != NULL ? device->pdos[i].excludes : got;
    for (size_t k = 0; k == 0 || expected[k - 1] != 0; k++) {
        if (got[k] != expected[k])
            fail_msg("%s: expected %04X as element %zu of the excluded PDOs, got %04X", what, expected[k], k, got[k]);
    }
}

/* The list of the dictionary has the existing PDOs of the file's elements, as far as it has room; its own default
 * stays, and excludes PDOs too, except those that the file assigns together. */
static void excluded_lists(void **state)
{
#define FREE_PDOS PDO_OF("1A01", "", "") PDO_OF("1A02", "", "")
    static const struct {
        const char *what, *text;
        uint8_t bytes[8];
        uint16_t length, excluded[4];
    } rows[] = {
        {"two PDOs",
         LISTING_8("", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A01") EXCLUDE("1A02")) FREE_PDOS),
         {0x01, 0x1A, 0x02, 0x1A},
         8,
         {0x1A01, 0x1A02}},
        {"one twice",
         LISTING_8("", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A01") EXCLUDE("1A01") EXCLUDE("1A02")) FREE_PDOS),
         {0x01, 0x1A, 0x02, 0x1A},
         8,
         {0x1A01, 0x1A02}},
        {"itself, a missing one and another",
         LISTING_8("", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A00") EXCLUDE("1A09") EXCLUDE("1A02")) FREE_PDOS),
         {0x02, 0x1A},
         8,
         {0x1A02}},
        {"none", LISTING_8("", PDO_OF("1A00", "Sm='3'", "") FREE_PDOS), {0}, 8, {0}},
        {"a PDO that is left out",
         LISTING_8("", PDO_OF("1A00", "Sm='3'", EXCLUDE("1C00")) PDO_OF("1C00", "", "")),
         {0},
         8,
         {0}},
        {"room for one",
         LISTING("UINT", "16", "", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A01") EXCLUDE("1A02")) FREE_PDOS),
         {0x01, 0x1A},
         2,
         {0x1A01, 0x1A02}},
        {"room for one and a half",
         LISTING("ARRAY [0..2] OF BYTE", "24", "", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A01") EXCLUDE("1A02")) FREE_PDOS),
         {0x01, 0x1A, 0},
         3,
         {0x1A01, 0x1A02}},
        {"room for two",
         LISTING("UDINT", "32", "", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A01") EXCLUDE("1A02")) FREE_PDOS),
         {0x01, 0x1A, 0x02, 0x1A},
         4,
         {0x1A01, 0x1A02}},
        {"no room", LISTING("USINT", "8", "", PDO_OF("1A00", "Sm='3'", EXCLUDE("1A01")) FREE_PDOS), {0}, 1, {0x1A01}},
        {"a default of the file",
         LISTING_8(DEFAULT("011A"), PDO_OF("1A00", "Sm='3'", EXCLUDE("1A02")) FREE_PDOS),
         {0x01, 0x1A},
         8,
         {0x1A02, 0x1A01}},
        {"a default of three bytes",
         LISTING_8(DEFAULT("011A02"), PDO_OF("1A00", "Sm='3'", "") FREE_PDOS),
         {0x01, 0x1A, 0x02},
         8,
         {0x1A01}},
        {"a default with the PDO itself, and one twice",
         LISTING_8(DEFAULT("001A021A021A"), PDO_OF("1A00", "Sm='3'", "") FREE_PDOS),
         {0x00, 0x1A, 0x02, 0x1A, 0x02, 0x1A},
         8,
         {0x1A02}},
        {"a default with a PDO that is assigned, too",
         LISTING_8(DEFAULT("011A021A"),
                   PDO_OF("1A00", "Sm='3'", "") PDO_OF("1A01", "Sm='3'", "") PDO_OF("1A02", "", "")),
         {0x01, 0x1A, 0x02, 0x1A},
         8,
         {0x1A02}},
        {"a default with an assigned PDO beside a free one",
         LISTING_8(DEFAULT("011A021A"), PDO_OF("1A00", "", "") PDO_OF("1A01", "Sm='3'", "") PDO_OF("1A02", "", "")),
         {0x01, 0x1A, 0x02, 0x1A},
         8,
         {0x1A01, 0x1A02}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static uint64_t memory[8192];
        uint8_t bytes[8] = {0};
        made_t m = make_text(rows[i].what, rows[i].text);
        assert_true(device_of(&m)->instance_size <= sizeof memory);
        memset(memory, 0, sizeof memory);
        const ect_od_t od = ect_device_od(device_of(&m), memory);
        ect_od_set_defaults(&od);
        const ect_entry_t *entry = ect_od_entry(ect_od_find(&od, 0x1800), 6);
        assert_non_null(entry);
        assert_int_equal(ect_od_bytes(entry), rows[i].length);
        ect_od_read(&od, entry, 0, bytes, ect_od_bytes(entry));
        if (memcmp(bytes, rows[i].bytes, sizeof bytes) != 0)
            fail_msg("%s: expected %02X %02X %02X %02X, got %02X %02X %02X %02X", rows[i].what, rows[i].bytes[0],
                     rows[i].bytes[1], rows[i].bytes[2], rows[i].bytes[3], bytes[0], bytes[1], bytes[2], bytes[3]);
        expect_excluded(rows[i].what, device_of(&m), rows[i].excluded);
        free_made(&m);
    }
}

/* Sub-index 9 of 1800h to 19FFh is a toggle, if inputs may contain it. */
static void entries_that_toggle(void **state)
{
#define STATED(index, n, flags)                                                                                        \
    ESI_DEVICE("<Profile><Dictionary><DataTypes><DataType><Name>L</Name><BitSize>24</BitSize>" SUB("0", "USINT", "8",  \
                                                                                                   "0", "")            \
                   SUB(n, "BOOL", "1", "16", flags) "</DataType></DataTypes><Objects><Object><Index>"                  \
                                                    "#x" index "</Index><Name>P</Name><Type>L"                         \
                                                    "</Type><BitSize>24</BitSize></Object></Objects>"                  \
                                                    "</Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS          \
                                                    "<Mailbox><CoE/></Mailbox>" ESI_EEPROM)
#define IN_INPUTS "<PdoMapping>T</PdoMapping>"
    static const struct {
        const char *what, *text;
        bool toggles;
    } rows[] = {
        {"1800h:9", STATED("1800", "9", IN_INPUTS), true},
        {"19FFh:9", STATED("19FF", "9", IN_INPUTS), true},
        {"15FFh:9", STATED("15FF", "9", IN_INPUTS), false},
        {"1800h:8", STATED("1800", "8", IN_INPUTS), false},
        {"1800h:10", STATED("1800", "10", IN_INPUTS), false},
        {"2000h:9", STATED("2000", "9", IN_INPUTS), false},
        {"not in inputs", STATED("1800", "9", ""), false},
        {"in outputs", STATED("1800", "9", "<PdoMapping>R</PdoMapping>"), false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_product_t *product = ect_esi_twin_product(m.twin);
        bool signal = false;
        for (unsigned int g = 0; g < product->plant->signal_group_count; g++)
            signal |= strcmp(product->plant->signal_groups[g].prefix, "toggle") == 0;
        if (signal != rows[i].toggles || (product->device->inputs != NULL) != rows[i].toggles ||
            (product->device->inputs_read != NULL) != rows[i].toggles)
            fail_msg("%s: expected %s", rows[i].what, rows[i].toggles ? "a toggle" : "no toggle");
        free_made(&m);
    }
}

static void revision(void **state)
{
    rig_t r;
    (void)state;
    open_states(&r, PREOP);
    assert_int_equal(read_number(&r, 0xF081, 1), REVISION);
    close_rig(&r);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"MDP-032 MDP-034: the toggle changes in each cycle, in SAFEOP and OP", toggles, NULL, NULL, NULL},
        {"MDP-034: inputs that no master has read do not change the toggle again", once_in_a_cycle, NULL, NULL, NULL},
        {"MDP-034: a toggle that is held keeps its value", held, NULL, NULL, NULL},
        {"MDP-032 MDP-034: the state is 1 in a simulated fault, in the inputs and by SDO", faulty, NULL, NULL, NULL},
        {"MDP-034: the toggle of a twin with the behaviour of a profile changes in each cycle", beside_a_profile, NULL,
         NULL, NULL},
        {"MDP-033: toggle and state are entries of 1 bit, and signals", mapped, NULL, NULL, NULL},
        {"MDP-030 MDP-031: 1800h is no mapping; its sub-index 6 has the excluded PDOs of the file", parameters, NULL,
         NULL, NULL},
        {"MDP-031 MDP-035: PDOs that exclude each other are refused with the count", excluded, NULL, NULL, NULL},
        {"MDP-031: lists of excluded PDOs, of the file's elements and of the dictionary", excluded_lists, NULL, NULL,
         NULL},
        {"MDP-034: the entries that are toggles", entries_that_toggle, NULL, NULL, NULL},
        {"MDP-036: the download revision F081h:1 is the revision number", revision, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESI: parameters of PDOs", tests, NULL, NULL);
}
