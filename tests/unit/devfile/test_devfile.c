/* SPDX-License-Identifier: MIT */
/* Device files: the device that a file stands for, and the line that refuses one. */
#define _GNU_SOURCE
#include "devfile_made.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "esi/write.h"
#include "sii/sii.h"

enum { TEXT = 500 };

#define DEVICE(lines)                                                                                                  \
    "ectwin-device: 1\nvendor: {id: 0xE57, name: Works}\nproduct: 0x101\nrevision: 7\ntype: G-1\n" lines /* 6 */
#define OBJECTS(lines) DEVICE("objects:\n" lines)                                                        /* 7 */
#define ONE(keys)      OBJECTS("  0x2000: {name: A, " keys "}\n")

static made_t try_text(const char *yaml)
{
    return made_of("g.yaml", yaml);
}

static made_t make(const char *what, const char *yaml)
{
    return whole(what, try_text(yaml));
}

/* --- what is read ------------------------------------------------------------------------------------------------- */

static void the_identity_is_that_of_the_file(void **state)
{
    (void)state;
    made_t m = make("identity", DEVICE("name: A gauge\ngroup: Gauges\nprofile: 0x00020191\nphysics: YYK\n"));
    const ect_device_t *d = device_of(&m);
    assert_int_equal(d->identity.vendor_id, 0xE57);
    assert_int_equal(d->identity.product_code, 0x101);
    assert_int_equal(d->identity.revision, 7);
    assert_string_equal(d->type_name, "G-1");
    assert_string_equal(d->full_name, "A gauge");
    assert_string_equal(d->vendor_name, "Works");
    assert_string_equal(d->group_type, "Gauges");
    assert_string_equal(d->physics, "YYK");
    assert_int_equal(d->device_type, 0x00020191);
    drop(&m);
}

static void an_entry_has_type_rights_and_default(void **state)
{
    static const struct {
        const char *keys;
        uint16_t type, bits, access;
        uint32_t value;
    } rows[] = {
        {"type: BOOL", ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RO, 0},
        {"type: BOOLEAN, default: true", ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RO, 1},
        {"type: BIT3, default: 5", ECT_TYPE_BIT1 + 2, 3, ECT_ACCESS_RO, 5},
        {"type: USINT, access: rw, default: 0xFF", ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW, 0xFF},
        {"type: BYTE, access: wo", ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_WO, 0},
        {"type: SINT, default: -1", ECT_TYPE_INTEGER8, 8, ECT_ACCESS_RO, 0xFF},
        {"type: INT, default: -32768", ECT_TYPE_INTEGER16, 16, ECT_ACCESS_RO, 0x8000},
        {"type: UNSIGNED16, default: 65535", ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, 65535},
        {"type: UDINT, default: 4294967295", ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, UINT32_MAX},
        {"type: REAL, default: 1.5", ECT_TYPE_REAL32, 32, ECT_ACCESS_RO, 0x3FC00000},
        {"type: STRING(3), default: ab", ECT_TYPE_VISIBLE_STRING, 24, ECT_ACCESS_RO, 0x6261},
        {"type: STRING, default: abc", ECT_TYPE_VISIBLE_STRING, 24, ECT_ACCESS_RO, 0x636261},
        {"type: BYTES(4), default: 01 02 0aFF", ECT_TYPE_OCTET_STRING, 32, ECT_ACCESS_RO, 0xFF0A0201},
        {"type: UINT, access: rw, write-in: preop", ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW_PREOP, 0},
        {"type: UINT, access: wo, write-in: preop safeop", ECT_TYPE_UNSIGNED16, 16,
         ECT_ACCESS_W_PREOP | ECT_ACCESS_W_SAFEOP, 0},
        {"type: UINT, backup: true", ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW | ECT_ACCESS_BACKUP, 0},
        {"type: UINT, access: rw, setting: true, backup: false", ECT_TYPE_UNSIGNED16, 16,
         ECT_ACCESS_RW | ECT_ACCESS_SETTING, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char yaml[TEXT];
        (void)snprintf(yaml, sizeof yaml, "%s  0x2000: {name: A, %s}\n", OBJECTS(""), rows[i].keys);
        made_t m = make(rows[i].keys, yaml);
        const ect_entry_t *entry = entry_of(&m, 0x2000, 0);
        print_message("%s\n", rows[i].keys);
        assert_non_null(entry);
        assert_string_equal(entry->name, "A");
        assert_int_equal(entry->data_type, rows[i].type);
        assert_int_equal(entry->bit_length, rows[i].bits);
        assert_int_equal(entry->access, rows[i].access);
        assert_int_equal(entry->value, rows[i].value);
        drop(&m);
    }
}

static void long_defaults_are_kept_whole(void **state)
{
    (void)state;
    made_t m = make("long", OBJECTS("  0x2000: {name: A, type: ULINT, default: 18446744073709551615}\n"
                                    "  0x2001: {name: B, type: LREAL, default: -2.5e3}\n"
                                    "  0x2002: {name: C, type: LINT, default: -9223372036854775808}\n"));
    static const uint8_t ones[8] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    static const uint8_t real[8] = {0, 0, 0, 0, 0, 0x88, 0xA3, 0xC0}, least[8] = {0, 0, 0, 0, 0, 0, 0, 0x80};
    static const uint8_t *const expected[] = {ones, real, least};
    ect_od_t od = ect_device_od(device_of(&m), NULL);
    for (uint16_t i = 0; i < 3; i++) {
        const ect_detail_t *detail = ect_od_detail(&od, (uint16_t)(0x2000 + i), 0);
        assert_non_null(detail);
        assert_memory_equal(detail->initial, expected[i], 8);
    }
    drop(&m);
}

static void limits_and_units_are_details(void **state)
{
    static const struct {
        const char *keys;
        int64_t minimum, maximum;
        uint16_t unit;
        uint8_t per;
    } rows[] = {
        {"type: INT, min: -5, max: 5, unit: um", -5, 5, 0xFA01, 0},
        {"type: USINT, max: 9, unit: mm/s", 0, 9, 0xFD01, 0x03},
        {"type: SINT, min: -2", -2, 127, 0, 0},
        {"type: UDINT, min: 1, default: 1, unit: 0xFD010300", 1, UINT32_MAX, 0xFD01, 0x03},
        {"type: LINT, max: 7, unit: kHz", INT64_MIN, 7, 0x0320, 0},
        {"type: REAL, unit: degC", 0, 0, 0x002D, 0},
        {"type: USINT, values: {0: OFF, 1: ON, 7: BOTH}", 0, 7, 0, 0},
        {"type: SINT, values: {-1: BACK, 0: HALT, 1: FORTH}", -1, 1, 0, 0},
        {"type: USINT, max: 3, values: {0: OFF, 1: ON}", 0, 3, 0, 0},
        {"type: BIT2, default: 1, values: {1: A, 3: B}", 1, 3, 0, 0},
        {"type: BIT2, values: {0: A, 3: B}", 0, 3, 0, 0},
        {"type: SINT, values: {-128: A, 127: B}", -128, 127, 0, 0},
        {"type: USINT, values: {0: A, 255: B}", 0, 255, 0, 0},
        {"type: LINT, values: {-9223372036854775808: A, 0: B, 9223372036854775807: C}", INT64_MIN, INT64_MAX, 0, 0},
        {"type: SINT, min: -128, max: 127", -128, 127, 0, 0},
        {"type: SINT, default: -5, max: -5", -128, -5, 0, 0},
        {"type: USINT, default: 4, min: 4, max: 5", 4, 5, 0, 0},
        {"type: USINT, default: 5, min: 4, max: 5", 4, 5, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char yaml[TEXT];
        (void)snprintf(yaml, sizeof yaml, "%s  0x2000: {name: A, %s}\n", OBJECTS(""), rows[i].keys);
        made_t m = make(rows[i].keys, yaml);
        ect_od_t od = ect_device_od(device_of(&m), NULL);
        const ect_detail_t *detail = ect_od_detail(&od, 0x2000, 0);
        print_message("%s\n", rows[i].keys);
        assert_non_null(detail);
        assert_true(detail->minimum == rows[i].minimum && detail->maximum == rows[i].maximum);
        assert_int_equal(detail->unit, rows[i].unit);
        assert_int_equal(detail->per, rows[i].per);
        drop(&m);
    }
}

static void arrays_and_records_have_their_entries(void **state)
{
    (void)state;
    made_t m = make("shapes", OBJECTS("  0x2000: {name: Row, type: UINT, array: 3, default: [1, 2, 3], access: rw}\n"
                                      "  0x2001: {name: Same, type: USINT, array: 2, default: 9}\n"
                                      "  0x3000:\n    name: Axis\n    entries:\n"
                                      "      - {name: Speed, type: INT}\n"
                                      "      - {name: Force, type: DINT, subindex: 7, access: rw}\n"
                                      "      - {name: Way, type: USINT}\n"));
    ect_od_t od = ect_device_od(device_of(&m), NULL);
    assert_int_equal(ect_od_find(&od, 0x3000)->object_code, ECT_OBJECT_RECORD);
    assert_int_equal(entry_of(&m, 0x2000, 0)->value, 3);
    assert_int_equal(entry_of(&m, 0x2000, 3)->value, 3);
    assert_string_equal(entry_of(&m, 0x2000, 2)->name, "Row 2");
    assert_int_equal(entry_of(&m, 0x2001, 2)->value, 9);
    assert_int_equal(entry_of(&m, 0x3000, 0)->value, 8);
    assert_string_equal(entry_of(&m, 0x3000, 1)->name, "Speed");
    assert_int_equal(entry_of(&m, 0x3000, 7)->bit_length, 32);
    assert_string_equal(entry_of(&m, 0x3000, 8)->name, "Way");
    assert_null(entry_of(&m, 0x3000, 2));
    drop(&m);
}

#define MAPPED                                                                                                         \
    "  0x6000: {name: In, type: INT}\n  0x6001: {name: More, type: BIT4, array: 2}\n"                                  \
    "  0x7000:\n    name: Out\n    entries:\n      - {name: X, type: USINT}\n      - {name: Y, type: BOOL}\n"

static uint32_t element(const made_t *m, uint16_t index, unsigned int n)
{
    ect_od_t od = ect_device_od(device_of(m), NULL);
    return ect_od_element(ect_od_find(&od, index), n);
}

static void lists_of_entries_become_one_pdo(void **state)
{
    (void)state;
    made_t m = make("PDOs", OBJECTS(MAPPED "inputs: [0x6000, gap 8, '0x6001:2', gap 4]\noutputs: [0x7000, gap 7]\n"));
    static const uint32_t inputs[] = {4, 0x60000010, 0x00000008, 0x60010204, 0x00000004};
    static const uint32_t outputs[] = {3, 0x70000108, 0x70000201, 0x00000007};
    for (unsigned int n = 0; n < 5; n++)
        assert_int_equal(element(&m, 0x1A00, n), inputs[n]);
    for (unsigned int n = 0; n < 4; n++)
        assert_int_equal(element(&m, 0x1600, n), outputs[n]);
    assert_int_equal(element(&m, 0x1C12, 1), 0x1600);
    assert_int_equal(element(&m, 0x1C13, 1), 0x1A00);
    assert_int_equal(entry_of(&m, 0x6000, 0)->access, ECT_ACCESS_RO | ECT_ACCESS_TXPDO);
    assert_int_equal(entry_of(&m, 0x6001, 1)->access, ECT_ACCESS_RO);
    assert_int_equal(entry_of(&m, 0x7000, 2)->access, ECT_ACCESS_RW | ECT_ACCESS_RXPDO);
    assert_int_equal(ect_device_bytes(device_of(&m), ECT_SM_INPUTS), 4);
    assert_int_equal(ect_device_bytes(device_of(&m), ECT_SM_OUTPUTS), 2);
    drop(&m);
}

static void lists_of_pdos_may_leave_some_unassigned(void **state)
{
    (void)state;
    made_t m = make("several", OBJECTS(MAPPED "inputs:\n  - {name: Short, entries: [0x6000], exclude: [0x1A05]}\n"
                                              "  - {pdo: 0x1A05, entries: [0x6001], assigned: false, exclude: "
                                              "[0x1A00], mandatory: false}\n"));
    assert_int_equal(element(&m, 0x1C13, 0), 1);
    assert_int_equal(element(&m, 0x1A05, 2), 0x60010204);
    assert_int_equal(m.model->pdo_count, 2);
    assert_string_equal(m.model->pdos[0].name, "Short");
    assert_string_equal(m.model->pdos[1].name, "Inputs 1A05");
    assert_true((device_of(&m)->coe_details & ECT_COE_PDO_ASSIGN) != 0);
    drop(&m);
}

static void bits_and_values_are_fields_of_the_plant(void **state)
{
    (void)state;
    made_t m = make("fields", OBJECTS("  0x2000: {name: A, type: USINT, bits: {0: READY, 4-7: GEAR}}\n"
                                      "  0x2001: {name: B, type: INT, values: {0: OFF, 5: ON}}\n"
                                      "  0x2002:\n    name: C\n    entries:\n"
                                      "      - {name: D, type: UINT, bits: {15: LAST}}\n"
                                      "      - {name: E, type: SINT, values: {-1: BACK, 1: FORTH}, subindex: 9, "
                                      "default: 1}\n"));
    const ect_field_t *f = ect_esi_twin_product(m.twin)->plant->fields;
    assert_non_null(f);
    assert_true(f[0].index == 0x2000 && f[0].bit == 0 && f[0].width == 1);
    assert_string_equal(f[0].name, "READY");
    assert_true(f[1].index == 0x2000 && f[1].bit == 4 && f[1].width == 4);
    assert_true(f[2].index == 0x2001 && f[2].width == 0 && f[2].values[1].value == 5 && f[2].values[2].name == NULL);
    assert_true(f[3].index == 0x2002 && f[3].subindex == 1 && f[3].bit == 15 && f[3].width == 1);
    assert_string_equal(f[3].name, "LAST");
    assert_true(f[4].index == 0x2002 && f[4].subindex == 9 && f[4].values[0].value == -1 &&
                f[4].values[2].name == NULL);
    assert_string_equal(f[4].values[1].name, "FORTH");
    assert_int_equal(f[5].index, 0);
    ect_od_t od = ect_device_od(device_of(&m), NULL);
    assert_true(ect_od_detail(&od, 0x2002, 9)->minimum == -1 && ect_od_detail(&od, 0x2002, 9)->maximum == 1);
    drop(&m);
}

static void the_standard_layout_is_that_of_soes(void **state)
{
    static const struct {
        const char *yaml;
        unsigned int count;
        struct {
            uint8_t type;
            uint16_t start, length;
        } sm[4];
    } rows[] = {
        {OBJECTS(MAPPED "inputs: [0x6000]\noutputs: [0x7000, gap 7]\n"),
         4,
         {{ECT_SM_MAILBOX_OUT, 0x1000, 128},
          {ECT_SM_MAILBOX_IN, 0x1080, 128},
          {ECT_SM_OUTPUTS, 0x1100, 2},
          {ECT_SM_INPUTS, 0x1180, 2}}},
        {OBJECTS(MAPPED "inputs: [0x6000]\nmailbox: {size: 256}\nsyncmanagers: standard\n"),
         4,
         {{ECT_SM_MAILBOX_OUT, 0x1000, 256},
          {ECT_SM_MAILBOX_IN, 0x1100, 256},
          {ECT_SM_OUTPUTS, 0x1200, 0},
          {ECT_SM_INPUTS, 0x1200, 2}}},
        {OBJECTS(MAPPED "inputs: [0x6000]\nmailbox: none\n"), 1, {{ECT_SM_INPUTS, 0x1000, 2}}},
        {OBJECTS(MAPPED "inputs: [0x6000]\nsyncmanagers:\n  - {type: mailbox-out, start: 0x1800, size: 64}\n"
                        "  - {type: mailbox-in, start: 0x1C00, size: 72, control: 0x22}\n  - {type: unused, start: 0}\n"
                        "  - {type: inputs, start: 0x1200, control: 0x22}\n"),
         4,
         {{ECT_SM_MAILBOX_OUT, 0x1800, 64},
          {ECT_SM_MAILBOX_IN, 0x1C00, 72},
          {ECT_SM_UNUSED, 0, 0},
          {ECT_SM_INPUTS, 0x1200, 2}}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make("layout", rows[i].yaml);
        assert_int_equal(device_of(&m)->sm_count, rows[i].count);
        for (unsigned int n = 0; n < rows[i].count; n++) {
            assert_int_equal(device_of(&m)->sm[n].type, rows[i].sm[n].type);
            assert_int_equal(device_of(&m)->sm[n].start, rows[i].sm[n].start);
            assert_int_equal(ect_device_sm_bytes(device_of(&m), n), rows[i].sm[n].length);
        }
        drop(&m);
    }
}

/* With a mailbox all three roles; without one those of the process data. */
static void FMMUs_have_the_roles_of_the_process_data(void **state)
{
    static const struct {
        const char *lines;
        unsigned int count;
        uint8_t roles[3];
    } rows[] = {
        {"", 3, {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE}},
        {"inputs: [gap 8]\n", 3, {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE}},
        {"mailbox: none\n", 0, {0}},
        {"mailbox: none\ninputs: [gap 8]\n", 1, {ECT_FMMU_INPUTS}},
        {"mailbox: none\noutputs: [gap 8]\n", 1, {ECT_FMMU_OUTPUTS}},
        {"mailbox: none\noutputs: [gap 1, gap 7]\ninputs: [gap 8]\n", 2, {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char yaml[TEXT];
        (void)snprintf(yaml, sizeof yaml, "%s%s", DEVICE(""), rows[i].lines);
        made_t m = make(rows[i].lines, yaml);
        assert_int_equal(device_of(&m)->fmmu_count, rows[i].count);
        for (unsigned int n = 0; n < rows[i].count; n++)
            assert_int_equal(device_of(&m)->fmmu[n], rows[i].roles[n]);
        drop(&m);
    }
}

static void mailbox_clocks_and_eeprom_are_described(void **state)
{
    (void)state;
    made_t m = make("parts", DEVICE("mailbox: {protocols: [coe, eoe], size: 512, sdo-info: false, complete-access: "
                                    "false, pdo-assign: true, repeat: false}\n"
                                    "dc:\n  - free-run\n  - sync0\n  - sync01\n"
                                    "  - {name: Odd, description: d, activate: 0x730, cycle0: 250000, shift0: -5, "
                                    "factor0: 3, cycle1: 125000, shift1: 6, factor1: 2}\n"
                                    "eeprom: {size: 4096, config: 05 0E 03 44 0A 00}\n"));
    const ect_device_t *d = device_of(&m);
    assert_int_equal(d->mailbox_protocols, ECT_MAILBOX_COE | ECT_MAILBOX_EOE);
    assert_int_equal(d->coe_details, ECT_COE_SDO | ECT_COE_PDO_ASSIGN);
    assert_int_equal(d->dc_mode_count, 4);
    assert_int_equal(d->dc_modes[0].assign_activate, 0);
    assert_int_equal(d->dc_modes[1].assign_activate, 0x0300);
    assert_int_equal(d->dc_modes[2].assign_activate, 0x0700);
    static const char *const names[4][2] = {
        {"FreeRun", "FreeRun or SM synchron"}, {"DC", "DC, SYNC0"}, {"DC01", "DC, SYNC0 and SYNC1"}, {"Odd", "d"}};
    for (size_t i = 0; i < 4; i++) {
        assert_string_equal(d->dc_modes[i].name, names[i][0]);
        assert_string_equal(d->dc_modes[i].description, names[i][1]);
    }
    assert_int_equal(d->dc_modes[3].assign_activate, 0x0730);
    assert_int_equal(d->dc_modes[3].cycle_sync0_ns, 250000);
    assert_int_equal((int)m.model->dcs[3].cycle_sync1_ns, 125000);
    assert_int_equal(m.model->dcs[3].sync0_factor, 3);
    assert_int_equal(d->dc_modes[3].shift_sync0_ns, -5);
    assert_int_equal(d->dc_modes[3].shift_sync1_ns, 6);
    assert_int_equal(d->dc_modes[3].factor_sync1, 2);
    assert_int_equal(d->sii_size, 4096);
    assert_int_equal(d->esc_config[3], 0x44);
    drop(&m);
}

/* --- the way through an ESI file ---------------------------------------------------------------------------------- */

static void a_twin_of_the_esi_file_is_the_same_device(void **state)
{
    (void)state;
    char why[TEXT] = "";
    size_t length = 0;
    ect_arena_t arena = {0};
    made_t m = make("round", OBJECTS(MAPPED "  0x8000: {name: P, type: INT, min: -3, max: 9, unit: mm/s, default: -1}\n"
                                            "  0x8001: {name: Q, type: USINT, values: {0: OFF, 1: ON}, backup: true}\n"
                                            "  0x8002: {name: R, type: STRING(9), default: a<b, access: rw}\n"
                                            "inputs: [0x6000, '0x6001:1', gap 4]\noutputs: [0x7000, gap 7]\n"
                                            "dc: [free-run, sync0]\n"));
    const ect_esi_part_t part = {.device = device_of(&m), .plant = ect_esi_twin_product(m.twin)->plant};
    const char *xml = ect_esi_write(&arena, &part, 1, &length, why, sizeof why);
    assert_non_null(xml);
    made_t n = {.esi = ect_esi_parse("t.xml", xml, length, why, sizeof why)};
    assert_non_null(n.esi);
    n.model = ect_esi_select(n.esi, "", why, sizeof why);
    n.twin = ect_esi_twin_of(n.esi, n.model, NULL, 0, why, sizeof why);
    assert_non_null(n.twin);
    size_t notes = 0, again = 0;
    (void)ect_esi_twin_notes(n.twin, &notes);
    assert_int_equal(notes, 0);
    const ect_esi_part_t other = {.device = device_of(&n), .plant = part.plant};
    const char *second = ect_esi_write(&arena, &other, 1, &again, why, sizeof why);
    assert_non_null(second);
    assert_string_equal(second, xml);
    uint8_t *a = malloc(device_of(&m)->sii_size), *b = malloc(device_of(&n)->sii_size);
    assert_true(a != NULL && b != NULL && device_of(&m)->sii_size == device_of(&n)->sii_size);
    assert_true(ect_sii_write(device_of(&m), NULL, 0, a, device_of(&m)->sii_size) > 0);
    assert_true(ect_sii_write(device_of(&n), NULL, 0, b, device_of(&n)->sii_size) > 0);
    assert_memory_equal(a, b, device_of(&m)->sii_size);
    free(a);
    free(b);
    ect_arena_free(&arena);
    drop(&n);
    drop(&m);
}

/* --- refusals ----------------------------------------------------------------------------------------------------- */

#define P(line, why) "g.yaml:" #line ": " why
#define TWENTY       "ABCDEFGHIJKLMNOPQRST"
#define SIXTY        TWENTY TWENTY TWENTY

static void a_wrong_file_is_refused_with_its_line_and_a_cure(void **state)
{
    static const struct {
        const char *yaml, *why; /* the beginning of it */
    } rows[] = {
        {"", P(1, "'ectwin-device: 1' is missing: the version of the format of device files")},
        {"- a\n", P(1, "'ectwin-device: 1' is missing")},
        {"\nectwin-device: 2\n", P(2, "'ectwin-device: 1' is missing")},
        {"ectwin: 1\ntwins:\n- device: fzm1\n",
         P(1, "a bus file, not a device: run it alone, as in 'ectwin run -i IFACE g.yaml'")},
        {"ectwin-device: x\n", P(1, "'ectwin-device' takes a number from 0 to 4294967295, not 'x'")},
        {"ectwin-device: 1\nproduct: 1\n",
         P(1, "'vendor' is missing, as in 'vendor: {id: 0x00000E57, name: Example W")},
        {"ectwin-device: 1\nvendor: {id: 1, name: A}\ntype: G\n", P(1, "'product' is missing, as in 'product: 0x0000")},
        {"ectwin-device: 1\nvendor: {id: 1, name: A}\nproduct: 1\n", P(1, "'type' is missing, as in 'type: GAUGE-1'")},
        {"ectwin-device: 1\nvendor: {id: 1}\nproduct: 1\ntype: G\n", P(2, "'vendor' takes both: {id: 0x00000E57")},
        {"ectwin-device: 1\nvendor: {uid: 1}\nproduct: 1\ntype: G\n", P(2, "'uid' is no key of 'vendor': id, name")},
        {"ectwin-device: 1\nvendor: 5\nproduct: 1\ntype: G\n", P(2, "vendor: 'key: value' lines are missing")},
        {"ectwin-device: 1\nvendor: {id: 1, name: A}\nproduct: -1\ntype: G\n",
         P(3, "'product' takes a number from 0 ")},
        {"ectwin-device: 1\nvendor: {id: 1, name: A}\nproduct: 1\ntype: ''\n", P(4, "'type' is empty")},
        {DEVICE("colour: red\n"), P(6, "'colour' is no key of a device: ectwin-device, vendor, product")},
        {DEVICE("type: B\n"), P(6, "'type' occurs twice")},
        {"ectwin-device: 1\nvendor: {id: 1, name: A, id: 2}\nproduct: 1\ntype: G\n", P(2, "'id' occurs twice")},
        {ONE("type: INT, type: INT"), P(7, "'type' occurs twice")},
        {ONE("entries: [{name: X, type: INT, name: Y}]"), P(7, "'name' occurs twice")},
        {ONE("type: INT, bits: {0: A, 0: B}"), P(7, "'0' has a bit that has a name already")},
        {DEVICE("inputs: [{entries: [gap 8], entries: [gap 8]}]\n"), P(6, "'entries' occurs twice")},
        {DEVICE("mailbox: {size: 64, size: 64}\n"), P(6, "'size' occurs twice")},
        {DEVICE("syncmanagers: [{type: inputs, start: 1, type: inputs}]\n"), P(6, "'type' occurs twice")},
        {DEVICE("dc: [{name: A, cycle0: 1, cycle0: 1}]\n"), P(6, "'cycle0' occurs twice")},
        {DEVICE("eeprom: {size: 2048, size: 2048}\n"), P(6, "'size' occurs twice")},
        {DEVICE("physics: YX\n"), P(6, "'physics' takes one letter for each port, up to 4: Y for MII")},
        {DEVICE("name: &a b\n"), P(6, "an anchor of YAML: device files have none")},
        {DEVICE("name: [a\n"), P(7, "no YAML: did not find expected ',' or ']'")},
        {DEVICE("objects: [a]\n"), P(6, "objects: 'key: value' lines are missing")},
        {OBJECTS("  0x2000: {type: INT}\n"), P(7, "object 0x2000 has no 'name'")},
        {OBJECTS("  0x20000: {name: A, type: INT}\n"), P(7, "'0x20000' is no index of an object: 0x1000 to 0xFFFF")},
        {OBJECTS("  abc: {name: A, type: INT}\n"), P(7, "'abc' is no index of an object")},
        {OBJECTS("  0x1000: {name: A, type: INT}\n"),
         P(7, "object 1000 is left out here: the key 'profile' has the d")},
        {OBJECTS("  0x1001: {name: A, type: INT}\n"), P(7, "object 1001 is left out here: the twin itself keeps")},
        {OBJECTS("  0x0FFF: {name: A, type: INT}\n"), P(7, "'0x0FFF' is no index of an object")},
        {OBJECTS("  0x1600: {name: A, type: INT}\n"), P(7, "object 1600 is left out here: the keys 'inputs', 'outpu")},
        {OBJECTS("  0x17FF: {name: A, type: INT}\n"), P(7, "object 17FF is left out here: the keys 'inputs', 'outpu")},
        {OBJECTS("  0x1BFF: {name: A, type: INT}\n"), P(7, "object 1BFF is left out here: the keys 'inputs', 'outpu")},
        {OBJECTS("  0x1C00: {name: A, type: INT}\n"), P(7, "object 1C00 is left out here: the keys 'inputs', 'outpu")},
        {OBJECTS("  0x1C2F: {name: A, type: INT}\n"), P(7, "object 1C2F is left out here: the keys 'inputs', 'outpu")},
        {OBJECTS("  0x1018: {name: A, type: INT}\n"), P(7, "object 1018 is left out here: the keys 'vendor', 'produ")},
        {OBJECTS("  0x1A00: {name: A, type: INT}\n"), P(7, "object 1A00 is left out here: the keys 'inputs', 'outpu")},
        {OBJECTS("  0x2000: {name: A, type: INT}\n  0x2000: {name: B, type: INT}\n"),
         P(8, "object 2000 occurs twice, first in line 7: give one another index")},
        {ONE("default: 1"), P(7, "'type' is missing: BOOL, USINT, UINT")},
        {ONE("type: WHAT"), P(7, "'type: WHAT' is none: BOOL, BIT1 to BIT8, USINT")},
        {ONE("type: BIT9"), P(7, "'type: BIT9' is none")},
        {ONE("type: BIT3x"), P(7, "'type: BIT3x' is none")},
        {ONE("type: STRING(0)"), P(7, "'type: STRING(0)' is none")},
        {ONE("type: STRING(9999)"), P(7, "'type: STRING(9999)' is none")},
        {ONE("type: STRING(8192)"), P(7, "'type: STRING(8192)' is none")},
        {ONE("type: BYTES(8192)"), P(7, "'type: BYTES(8192)' is none")},
        {ONE("type: STRING(00001)"), P(7, "'type: STRING(00001)' is none")},
        {ONE("type: BYTES(1"), P(7, "'type: BYTES(1' is none")},
        {ONE("type: 'ARRAY [0..1] OF INT'"), P(7, "'type: ARRAY [0..1] OF INT' is none")},
        {ONE("type: STRING, default: ''"), P(7, "'type: STRING' takes its length from 'default'")},
        {ONE("type: STRING"), P(7, "'type: STRING' takes its length from 'default'; else write STRING(20)")},
        {ONE("type: INT, colour: 1"), P(7, "'colour' is no key of an object: name, type, access")},
        {ONE("type: INT, subindex: 1"), P(7, "'subindex' is no key of an object")},
        {ONE("type: INT, access: r"), P(7, "'access' takes ro, rw or wo, not 'r'")},
        {ONE("type: INT, backup: 1"), P(7, "'backup' takes true or false, not '1'")},
        {ONE("type: INT, write-in: op, access: rw"), P(7, "'write-in' takes preop, preop safeop, or")},
        {ONE("type: INT, write-in: preop"), P(7, "'write-in' is for 'access: rw' or 'access: wo'")},
        {ONE("type: INT, unit: furlong"), P(7, "'unit: furlong' is none: um, mm/s, degC")},
        {ONE("type: INT, unit: m/fortnight"), P(7, "'unit: m/fortnight' is none")},
        {ONE("type: USINT, default: 256"), P(7, "'default' takes a number from 0 to 255, not '256'")},
        {ONE("type: INT, default: [1, 2]"), P(7, "a list in 'default' is for an 'array'")},
        {ONE("type: UINT, default: 1.5"), P(7, "'default' takes a number from 0 to 65535, not '1.5'")},
        {ONE("type: REAL, default: 1e99"), P(7, "'default' takes a number as 12.5 or 1e-3, not '1e99'")},
        {ONE("type: LREAL, default: nan"), P(7, "'default' takes a number as 12.5")},
        {ONE("type: STRING(2), default: abc"), P(7, "'default' has 3 characters: write STRING(3)")},
        {ONE("type: STRING(9), default: \"\\u00B5\""), P(7, "'default' has a character outside ISO 646")},
        {ONE("type: BYTES(2), default: 010203"),
         P(7, "'default' takes at most 2 bytes as pairs of hexadecimal digits")},
        {ONE("type: BYTES(2), default: 1g"), P(7, "'default' takes at most 2 bytes")},
        {ONE("type: REAL, min: 1"), P(7, "'min' and 'max' are for integers: leave them out")},
        {ONE("type: USINT, min: -1"), P(7, "'min' takes a number from 0 to 255, not '-1'")},
        {ONE("type: USINT, min: 5, max: 5"), P(7, "'min' 5 is not less than 'max' 5")},
        {ONE("type: USINT, min: 5"),
         P(7, "the default 0 of 2000:0 is not within its limits 5 to 255: write 'default'")},
        {ONE("type: INT, bits: {16: A}"), P(7, "'16' is no bit of 16: 0 to 15, several as \"4-7\"")},
        {ONE("type: INT, bits: {00000001: A}"), P(7, "'00000001' is no bit of 16")},
        {ONE("type: INT, bits: {-1: A}"), P(7, "'-1' is no bit of 16")},
        {ONE("type: INT, bits: {4-3: A}"), P(7, "'4-3' is no bit of 16")},
        {ONE("type: INT, bits: {0-16: A}"), P(7, "'0-16' is no bit of 16")},
        {ONE("type: INT, bits: {0-4294967296: A}"), P(7, "'0-4294967296' is no bit of 16")},
        {ONE("type: INT, bits: {a: A}"), P(7, "'a' is no bit of 16")},
        {ONE("type: INT, bits: {3-b: A}"), P(7, "'3-b' is no bit of 16")},
        {ONE("type: INT, bits: {0-3: A, 3: B}"), P(7, "'3' has a bit that has a name already")},
        {ONE("type: INT, bits: {0: ''}"), P(7, "'0' takes a name of 1 to 60 characters")},
        {ONE("type: INT, bits: {0: \"A\\x1FB\"}"), P(7, "'0' takes a name of 1 to 60 characters")},
        {ONE("type: INT, bits: {0: \"AB\\x7F\"}"), P(7, "'0' takes a name of 1 to 60 characters")},
        {ONE("type: INT, bits: {0: " SIXTY "x}"), P(7, "'0' takes a name of 1 to 60 characters")},
        {ONE("type: INT, values: {0: A, 1: \"A\\tB\"}"), P(7, "'1' takes a name of 1 to 60 characters")},
        {ONE("type: REAL, bits: {0: A}"), P(7, "'bits' is for integers: leave it out")},
        {ONE("type: INT, values: {0: A}"), P(7, "'values' takes at least two: {0: OFF, 1: ON}")},
        {ONE("type: INT, values: {1: A, 0: B}"), P(7, "'values' must ascend, without duplicates: move 0")},
        {ONE("type: BIT2, values: {1: A, 4: B}"), P(7, "'values' has a value beyond the range of the entry")},
        {ONE("type: SINT, values: {0: A, 128: B}"),
         P(7, "'values' has a value beyond the range of the entry: choose an")},
        {ONE("type: SINT, values: {-129: A, 0: B}"), P(7, "'values' has a value beyond the range of the entry")},
        {ONE("type: USINT, values: {-1: A, 0: B}"), P(7, "'values' has a value beyond the range of the entry")},
        {ONE("type: USINT, values: {0: A, 256: B}"), P(7, "'values' has a value beyond the range of the entry")},
        {ONE("type: USINT, values: {0: A, 0: B}"), P(7, "'values' must ascend, without duplicates: move 0")},
        {ONE("type: USINT, default: 6, min: 4, max: 5"), P(7, "the default 6 of 2000:0 is not within its limits 4 to")},
        {ONE("type: SINT, default: -6, min: -5"), P(7, "the default -6 of 2000:0 is not within its limits -5 to 127")},
        {ONE("type: INT, values: {x: A, 4: B}"), P(7, "'values' takes a number from")},
        {ONE("type: INT, array: 0"), P(7, "'array' takes a number from 1 to 254, not '0'")},
        {ONE("type: INT, array: 2, default: [1]"),
         P(7, "'default' has 1 values, 'array' 2 elements: give each its own")},
        {ONE("type: INT, array: 2, bits: {0: A}"), P(7, "'bits' and 'values' are for single values: write 'entries'")},
        {ONE("entries: []"), P(7, "'entries' takes a list, '- {name: Speed, type: INT}' each")},
        {ONE("type: INT, entries: [{name: X, type: INT}]"), P(7, "'type' belongs to each of the 'entries'")},
        {ONE("entries: [{type: INT}]"), P(7, "'name' is missing")},
        {ONE("entries: [{name: X, type: INT, array: 2}]"), P(7, "'array' is no key of an entry: name, type")},
        {ONE("entries: [{name: X, type: INT, default: [1]}]"), P(7, "a list in 'default' is for an 'array'")},
        {ONE("entries: [{name: X, type: INT, subindex: 255}]"), P(7, "'subindex' takes a number from 1 to 254")},
        {ONE("entries: [{name: X, type: INT, subindex: 254}, {name: Y, type: INT}]"), P(7, "more than 254 entries")},
        {ONE("entries: [{name: X, type: INT, subindex: 2}, {name: Y, type: INT, subindex: 2}]"),
         P(7, "object 2000 has sub-index 2 twice: give one another 'subindex'")},
        {DEVICE("inputs: []\n"), P(6, "'inputs' takes a list: entries, as [0x6000], or PDOs")},
        {DEVICE("outputs: 5\n"), P(6, "'outputs' takes a list: entries")},
        {DEVICE("inputs: [0x6000]\n"), P(6, "there is no 0x6000 among the 'objects': add it, or correct the index")},
        {DEVICE("inputs: [speed]\n"), P(6, "'speed' is no entry of a PDO: 0x6000, all of an object; 0x6000:1")},
        {DEVICE("inputs: [gap 256]\n"), P(6, "'gap 256' is no entry of a PDO")},
        {DEVICE("inputs: [gap]\n"), P(6, "'gap' is no entry of a PDO")},
        {DEVICE("inputs: [0x0FFF]\n"), P(6, "'0x0FFF' is no entry of a PDO")},
        {DEVICE("inputs: [0x1000]\n"), P(6, "there is no 0x1000 among the 'objects'")},
        {DEVICE("inputs: [0xFFFF]\n"), P(6, "there is no 0xFFFF among the 'objects'")},
        {DEVICE("inputs: [0x10000]\n"), P(6, "'0x10000' is no entry of a PDO")},
        {DEVICE("inputs: ['0x6000:256']\n"), P(6, "'0x6000:256' is no entry of a PDO")},
        {DEVICE("inputs: ['0x6000:-1']\n"), P(6, "'0x6000:-1' is no entry of a PDO")},
        {DEVICE("inputs: ['0x00000000000000000000006000']\n"), P(6, "'0x00000000000000000000006000' is no entry of a")},
        {ONE("type: INT") "inputs: ['0x2000:1']\n", P(8, "there is no 0x2000:1 among the 'objects'")},
        {ONE("type: STRING(32)") "inputs: [0x2000]\n", P(8, "2000:0 has 256 bits; a PDO maps at most 255 of an entry")},
        {DEVICE("inputs: [gap 0]\n"), P(6, "'gap 0' is no entry of a PDO")},
        {DEVICE("inputs: [0x6000:x]\n"), P(6, "'0x6000:x' is no entry of a PDO")},
        {DEVICE("inputs: [{pdo: 0x1A00}]\n"), P(6, "a PDO without 'entries: [0x6000]'")},
        {DEVICE("inputs: [{entries: []}]\n"), P(6, "a PDO takes a list of entries, as [0x6000")},
        {DEVICE("inputs: [{sm: 3}]\n"), P(6, "'sm' is no key of a PDO: pdo, name, entries")},
        {DEVICE("inputs: [{pdo: 0x1600, entries: [gap 8]}]\n"), P(6, "'pdo' takes a number from 6656 to 7167")},
        {DEVICE("inputs: [{entries: [gap 8]}, {pdo: 0x1A00, entries: [gap 8]}]\n"), P(6, "PDO 1A00 occurs twice")},
        {DEVICE("inputs: [{entries: [gap 8], exclude: 5}]\n"), P(6, "'exclude' takes a list of at most 64 PDOs")},
        {DEVICE("inputs: [{entries: [gap 8], mandatory: 5}]\n"), P(6, "'mandatory' takes true or false, not '5'")},
        {ONE("type: STRING(40)") "inputs: [0x2000]\n", P(8, "2000:0 has 320 bits; a PDO maps at most 255 of an entry")},
        {ONE("type: INT, access: wo") "inputs: [0x2000]\n", P(8, "2000:0 is an input and cannot be read: change its")},
        {ONE("type: INT, array: 254") "inputs: [0x2000, gap 8]\n",
         P(8, "PDO 1A00 has more than 254 entries: split it")},
        {DEVICE("mailbox: full\n"), P(6, "'mailbox' other than 'none': 'key: value' lines are missing")},
        {DEVICE("mailbox: {size: 33}\n"), P(6, "'size' takes a number from 34 to 1486, not '33'")},
        {DEVICE("mailbox: {size: 1487}\n"), P(6, "'size' takes a number from 34 to 1486, not '1487'")},
        {DEVICE("mailbox: {size: 20}\n"), P(6, "'size' takes a number from 34 to 1486, not '20'")},
        {DEVICE("mailbox: {colour: 20}\n"), P(6, "'colour' is no key of 'mailbox': size, protocols")},
        {DEVICE("mailbox: {protocols: coe}\n"), P(6, "'protocols' takes a list, as [coe, foe]")},
        {DEVICE("mailbox: {protocols: [http]}\n"), P(6, "'protocols' takes coe, eoe, foe, aoe, soe, voe, not 'http'")},
        {DEVICE("syncmanagers: odd\n"), P(6, "'syncmanagers' takes standard, or a list")},
        {DEVICE("syncmanagers: [{start: 1}]\n"), P(6, "a SyncManager takes 'type' and 'start'")},
        {DEVICE("syncmanagers: [{type: x, start: 1}]\n"), P(6, "'type' takes mailbox-out, mailbox-in, outputs")},
        {DEVICE("syncmanagers: [{type: inputs, start: 1, size: 4}]\n"), P(6, "'size' is for mailboxes; process data")},
        {DEVICE("syncmanagers: [{type: mailbox-in, start: 1}]\n"), P(6, "a mailbox takes its 'size': 128")},
        {DEVICE("syncmanagers: [{type: mailbox-out, start: 1}]\n"), P(6, "a mailbox takes its 'size': 128")},
        {DEVICE("syncmanagers: [{type: outputs, start: 1, size: 4}]\n"), P(6, "'size' is for mailboxes; process data")},
        {DEVICE("syncmanagers: [{type: unused, start: 1, size: 4}]\n"), P(6, "'size' is for mailboxes; process data")},
        {DEVICE("syncmanagers: [{length: 1}]\n"), P(6, "'length' is no key of a SyncManager: type, start, size")},
        {DEVICE("syncmanagers: [{type: unused, start: 0x10000}]\n"), P(6, "'start' takes a number from 0 to 65535")},
        {DEVICE("inputs: [gap 8]\nsyncmanagers: []\n"), P(6, "no SyncManager has the inputs: add one")},
        {DEVICE("dc: sync0\n"), P(6, "'dc' takes a list of at most 16 clock modes, as [free-run, sync0]")},
        {DEVICE("dc: [sync2]\n"), P(6, "'dc' takes free-run, sync0, sync01, or {name: DC")},
        {DEVICE("dc: [{activate: 0x300}]\n"), P(6, "a clock mode without 'name'")},
        {DEVICE("dc: [{name: A, speed: 1}]\n"), P(6, "'speed' is no key of a clock mode: name, description")},
        {DEVICE("dc: [{name: A, cycle0: -1}]\n"), P(6, "'cycle0' takes a number from 0 to 2147483647, not '-1'")},
        {DEVICE("eeprom: {size: 1}\n"), P(6, "'size' takes a number from 128 to 32768, not '1'")},
        {DEVICE("eeprom: {size: 127}\n"), P(6, "'size' takes a number from 128 to 32768, not '127'")},
        {DEVICE("eeprom: {size: 32769}\n"), P(6, "'size' takes a number from 128 to 32768, not '32769'")},
        {DEVICE("eeprom: {config: 000102030405060708090A0B0C0D0E}\n"), P(6, "'config' takes at most 14 bytes")},
        {DEVICE("eeprom: {config: 00 0}\n"), P(6, "'config' takes at most 14 bytes")},
        {DEVICE("eeprom: [1]\n"), P(6, "eeprom: 'key: value' lines are missing")},
        {DEVICE("dc: [{name: A, cycle1: 2147483648}]\n"), P(6, "'cycle1' takes a number from 0 to 2147483647")},
        {DEVICE("dc: [{name: A, shift0: -2147483649}]\n"), P(6, "'shift0' takes a number from -2147483648 to")},
        {DEVICE("dc: [{name: A, shift1: 2147483648}]\n"),
         P(6, "'shift1' takes a number from -2147483648 to 2147483647")},
        {DEVICE("dc: [{name: A, factor0: 32768}]\n"), P(6, "'factor0' takes a number from -32768 to 32767")},
        {DEVICE("dc: [{name: A, factor1: -32769}]\n"), P(6, "'factor1' takes a number from -32768 to 32767")},
        {DEVICE("dc: [{name: A, activate: 65536}]\n"), P(6, "'activate' takes a number from 0 to 65535")},
        {DEVICE("eeprom: {config: 0}\n"), P(6, "'config' takes at most 14 bytes as pairs of hexadecimal digits")},
        {DEVICE("eeprom: {colour: 0}\n"), P(6, "'colour' is no key of 'eeprom': size, config")},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = try_text(rows[i].yaml);
        if (m.twin != NULL || strncmp(m.why, rows[i].why, strlen(rows[i].why)) != 0)
            fail_msg("row %zu:\n%s\nexpected \"%s\", got \"%s\"", i, rows[i].yaml, rows[i].why, m.why);
        drop(&m);
    }
}

static void values_at_the_end_of_their_range_are_taken(void **state)
{
#define GAP4  "gap 4, gap 4, gap 4, gap 4"
#define GAP16 GAP4 ", " GAP4 ", " GAP4 ", " GAP4
#define SYNC4 "sync0, sync0, sync0, sync0"
    static const struct {
        const char *yaml, *why; /* NULL: taken */
    } rows[] = {
        {OBJECTS("  0xFFFF: {name: A, type: INT}\n  0x1002: {name: B, type: INT}\n"), NULL},
        {OBJECTS("  0x1C30: {name: A, type: INT}\n"), NULL},
        {ONE("type: STRING(8191)"), NULL},
        {ONE("type: BYTES(8191)"), NULL},
        {ONE("type: INT, array: 254"), NULL},
        {ONE("type: INT, bits: {0000001: A, 2-15: B}"), NULL},
        {ONE("type: INT, bits: {0: ' ~', 15: " SIXTY "}"), NULL},
        {ONE("type: INT, array: 1"), NULL},
        {ONE("type: INT, array: 255"), P(7, "'array' takes a number from 1 to 254, not '255'")},
        {ONE("entries: [{name: X, type: INT, subindex: 254}]"), NULL},
        {ONE("type: STRING(31)") "inputs: [0x2000]\n", NULL},
        {ONE("type: INT") "inputs: ['0x2000:0']\n", NULL},
        {DEVICE("inputs: [gap 255, gap 1]\n"), NULL},
        {DEVICE("inputs: [" GAP16 "]\n"), NULL},
        {DEVICE("inputs: [{pdo: 0x1BFF, entries: [gap 8]}]\n"), NULL},
        {DEVICE("outputs: [{pdo: 0x17FF, entries: [gap 8]}]\n"), NULL},
        {DEVICE("outputs: [{pdo: 0x1800, entries: [gap 8]}]\n"), P(6, "'pdo' takes a number from 5632 to 6143")},
        {DEVICE("inputs: [{pdo: 0x1C00, entries: [gap 8]}]\n"), P(6, "'pdo' takes a number from 6656 to 7167")},
        {DEVICE("mailbox: {size: 34}\n"), NULL},
        {DEVICE("mailbox: {size: 1486}\n"), NULL},
        {DEVICE("mailbox: none\noutputs: [gap 8]\nsyncmanagers: [{type: outputs, start: 0x1000}]\n"), NULL},
        {DEVICE("eeprom: {size: 32768}\n"), NULL},
        {DEVICE("eeprom: {config: 05 06 03 44 64 00 00 00 00 00 00 00 00 00}\n"), NULL},
        {DEVICE("dc: [" SYNC4 ", " SYNC4 ", " SYNC4 ", " SYNC4 "]\n"), NULL},
        {DEVICE("dc: [" SYNC4 ", " SYNC4 ", " SYNC4 ", " SYNC4 ", sync0]\n"), P(6, "'dc' takes a list of at most 16")},
        {DEVICE("dc: [{name: A, cycle0: 2147483647, shift0: -2147483648, shift1: 2147483647, factor0: -32768, "
                "factor1: 32767, activate: 65535}]\n"),
         NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = try_text(rows[i].yaml);
        if ((m.twin != NULL) != (rows[i].why == NULL) ||
            (rows[i].why != NULL && strncmp(m.why, rows[i].why, strlen(rows[i].why)) != 0))
            fail_msg("row %zu:\n%s\nexpected \"%s\", got \"%s\"", i, rows[i].yaml, rows[i].why, m.why);
        drop(&m);
    }
}

/* Areas start at multiples of 128 bytes; process data have three buffers. */
static void areas_of_the_standard_layout_follow_each_other(void **state)
{
    static const struct {
        const char *yaml;
        unsigned int count;
        uint16_t starts[4];
    } rows[] = {
        {DEVICE("mailbox: {size: 127}\n"), 4, {0x1000, 0x1080, 0x1100, 0x1100}},
        {DEVICE("mailbox: {size: 128}\n"), 4, {0x1000, 0x1080, 0x1100, 0x1100}},
        {DEVICE("mailbox: {size: 129}\n"), 4, {0x1000, 0x1100, 0x1200, 0x1200}},
        {DEVICE("outputs: [gap 255, gap 81]\n"), 4, {0x1000, 0x1080, 0x1100, 0x1180}}, /* 42 bytes */
        {DEVICE("outputs: [gap 255, gap 82]\n"), 4, {0x1000, 0x1080, 0x1100, 0x1200}}, /* 43 bytes */
        {DEVICE("mailbox: none\noutputs: [gap 1]\n"), 1, {0x1000}},
        {DEVICE("mailbox: none\noutputs: [gap 1]\ninputs: [gap 1]\n"), 2, {0x1000, 0x1080}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = try_text(rows[i].yaml);
        assert_non_null(m.model);
        assert_int_equal(m.model->sm_count, rows[i].count);
        for (unsigned int n = 0; n < rows[i].count; n++) {
            if (m.model->sms[n].start != rows[i].starts[n])
                fail_msg("row %zu, SM%u: expected 0x%04X, got 0x%04X", i, n, rows[i].starts[n],
                         (unsigned int)m.model->sms[n].start);
        }
        drop(&m);
    }
}

/* 60 KB are three buffers of 20480 bytes: 642 times 255 bits, and 130 bits. */
static void the_standard_layout_ends_with_the_RAM(void **state)
{
    static const char refusal[] =
        P(1, "mailboxes and process data need more than the 60 KB of a controller: use fewer");
    enum { GAPS = 642, GAPS_OF_PDO = 214 };
    (void)state;
    for (unsigned int last = 130; last <= 131; last++) {
        char *yaml = malloc(GAPS * 10 + TEXT);
        assert_non_null(yaml);
        char *at = yaml + sprintf(yaml, DEVICE("mailbox: none\ninputs:\n  - {entries: [gap %u]}\n"), last);
        for (unsigned int n = 0; n < GAPS; n++)
            at += sprintf(at, "%sgap 255%s", n % GAPS_OF_PDO == 0 ? "  - {entries: [" : ", ",
                          n % GAPS_OF_PDO == GAPS_OF_PDO - 1 ? "]}\n" : "");
        made_t m = try_text(yaml);
        assert_int_equal(strcmp(m.why, refusal) == 0, last == 131);
        free(yaml);
        drop(&m);
    }
}

/* A list with `count` times an element. */
static char *repeated(const char *begin, const char *element, unsigned int count, const char *end)
{
    const size_t step = strlen(element);
    char *yaml = malloc(strlen(begin) + count * step + strlen(end) + 1);
    assert_non_null(yaml);
    strcpy(yaml, begin);
    char *at = yaml + strlen(yaml);
    for (unsigned int i = 0; i < count; i++, at += step)
        memcpy(at, element, step);
    strcpy(at, end);
    return yaml;
}

static void lists_that_are_too_long_are_refused(void **state)
{
    static const struct {
        const char *begin, *element;
        unsigned int count;
        const char *end, *why;
    } rows[] = {
        {DEVICE("inputs: ["), "{entries: [gap 8]}, ", 513, "]\n", P(6, "more than 512 PDOs")},
        {DEVICE("outputs: ["), "{entries: [gap 8]}, ", 513, "]\n", P(6, "more than 512 PDOs")},
        {DEVICE("syncmanagers: ["), "{type: unused, start: 0}, ", 17, "]\n", P(6, "more than 16 SyncManagers")},
        {DEVICE("outputs: ["), "gap 255, ", 255, "]\n", P(6, "PDO 1600 has more than 254 entries")},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char *yaml = repeated(rows[i].begin, rows[i].element, rows[i].count, rows[i].end);
        made_t m = try_text(yaml);
        if (m.twin != NULL || strncmp(m.why, rows[i].why, strlen(rows[i].why)) != 0)
            fail_msg("row %zu: expected \"%s\", got \"%s\"", i, rows[i].why, m.why);
        drop(&m);
        free(yaml);
        yaml = repeated(rows[i].begin, rows[i].element, rows[i].count - 1, rows[i].end);
        m = try_text(yaml);
        if (strncmp(m.why, rows[i].why, strlen(rows[i].why)) == 0)
            fail_msg("row %zu: one less is refused too: \"%s\"", i, m.why);
        drop(&m);
        free(yaml);
    }
}

/* The checks of every description find it; the line is that of the type. */
static void a_device_that_no_controller_can_be_is_refused(void **state)
{
    (void)state;
    made_t m = try_text(DEVICE("inputs: [gap 8]\nsyncmanagers: [{type: inputs, start: 0x0100}]\n"));
    assert_null(m.twin);
    assert_string_equal(m.why, "g.yaml:5: G-1: line 7: SyncManager 0 begins at 0x0100, where there are registers");
    drop(&m);
}

static void a_small_file_cannot_become_a_large_device(void **state)
{
    enum { OBJECTS_OF_254 = 300 };
    (void)state;
    char *yaml = malloc(60 * OBJECTS_OF_254);
    assert_non_null(yaml);
    char *at = yaml + sprintf(yaml, "%s", OBJECTS(""));
    for (unsigned int i = 0; i < OBJECTS_OF_254; i++)
        at += sprintf(at, "  0x%04X: {name: A, type: USINT, array: 254}\n", 0x2000 + i);
    made_t m = try_text(yaml);
    assert_null(m.esi);
    assert_string_equal(m.why, "g.yaml:265: more than 65535 entries of all objects");
    free(yaml);
    drop(&m);
}

static void a_file_that_cannot_be_read_is_a_line(void **state)
{
    (void)state;
    char why[TEXT] = "", path[] = "/tmp/ectwin-devfile-XXXXXX";
    assert_null(ect_devfile_open("/nowhere/g.yaml", why, sizeof why));
    assert_string_equal(why, "/nowhere/g.yaml: No such file or directory");
    assert_null(ect_devfile_open("/", why, sizeof why));
    assert_string_equal(why, "/: not a file of at most 1048576 bytes");
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    static const char yaml[] = DEVICE("");
    assert_int_equal(write(fd, yaml, sizeof yaml - 1), sizeof yaml - 1);
    close(fd);
    ect_esi_t *esi = ect_devfile_open(path, why, sizeof why);
    unlink(path);
    assert_non_null(esi);
    ect_esi_close(esi);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_identity_is_that_of_the_file),
        cmocka_unit_test(an_entry_has_type_rights_and_default),
        cmocka_unit_test(long_defaults_are_kept_whole),
        cmocka_unit_test(limits_and_units_are_details),
        cmocka_unit_test(arrays_and_records_have_their_entries),
        cmocka_unit_test(lists_of_entries_become_one_pdo),
        cmocka_unit_test(lists_of_pdos_may_leave_some_unassigned),
        cmocka_unit_test(bits_and_values_are_fields_of_the_plant),
        cmocka_unit_test(the_standard_layout_is_that_of_soes),
        cmocka_unit_test(FMMUs_have_the_roles_of_the_process_data),
        cmocka_unit_test(mailbox_clocks_and_eeprom_are_described),
        cmocka_unit_test(a_twin_of_the_esi_file_is_the_same_device),
        cmocka_unit_test(a_wrong_file_is_refused_with_its_line_and_a_cure),
        cmocka_unit_test(values_at_the_end_of_their_range_are_taken),
        cmocka_unit_test(areas_of_the_standard_layout_follow_each_other),
        cmocka_unit_test(the_standard_layout_ends_with_the_RAM),
        cmocka_unit_test(lists_that_are_too_long_are_refused),
        cmocka_unit_test(a_device_that_no_controller_can_be_is_refused),
        cmocka_unit_test(a_small_file_cannot_become_a_large_device),
        cmocka_unit_test(a_file_that_cannot_be_read_is_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
