/* SPDX-License-Identifier: MIT */
/* Projects of the public EEPROM generator, esi.json: the device that one stands for, and the line that refuses one. */
#include "devfile_made.h"

#include <stdio.h>
#include <stdlib.h>

#define FORM(more)                                                                                                     \
    "{\n \"form\": {\"VendorName\": \"Works\", \"VendorID\": \"0xE57\", \"ProductCode\": \"0x00ab123\", "              \
    "\"ProfileNo\": \"5001\", \"RevisionNumber\": \"0x002\", \"TextDeviceType\": \"T-1\", \"TextDeviceName\": "        \
    "\"A thing\", \"TextGroupType\": \"G\", \"TextGroupName5\": \"Group\", \"Port0Physical\": \"Y\", "                 \
    "\"Port1Physical\": \"K\", \"Port2Physical\": \" \", \"HWversion\": \"0.1\", \"SWversion\": \"2.3\", "             \
    "\"MailboxSize\": \"256\", \"RxMailboxOffset\": \"0x1000\", \"TxMailboxOffset\": \"0x1200\", \"SM2Offset\": "      \
    "\"0x1400\", \"SM3Offset\": \"0x1A00\", \"EEPROMsize\": \"2048\", \"SPImode\": \"3\"" more "},\n"
#define PROJECT(od) FORM("") " \"od\": {" od "}\n}\n" /* the objects are on line 3 */

static made_t try_text(const char *json)
{
    return made_of("esi.json", json);
}

static made_t make(const char *json)
{
    return whole("the project", try_text(json));
}

static void the_form_is_identity_and_layout(void **state)
{
    static const uint8_t config[14] = {0x80, 0x06, 0x03, 0x44, 0x64};
    (void)state;
    made_t m = make(
        FORM(", \"ESC\": \"LAN9252\", \"CoeDetailsEnableSDOInfo\": true, "
             "\"CoeDetailsEnableSDOCompleteAccess\": \"on\", \"CoeDetailsEnablePDOAssign\": false") //
        "\"od\": {}, \"dc\": [{\"Name\": \"DC\", \"Description\": \"SYNC0\", \"AssignActivate\": \"#x300\", "
        "\"Sync0cycleTime\": \"0\", \"Sync0shiftTime\": \"50\"}, {\"Name\": \"DC2\", \"AssignActivate\": \"#x700\", "
        "\"Sync0cycleTime\": \"1000\", \"Sync1cycleTime\": \"2000\", \"Sync1shiftTime\": \"30\"}]}");
    const ect_device_t *d = device_of(&m);
    assert_int_equal(d->identity.vendor_id, 0xE57);
    assert_int_equal(d->identity.product_code, 0xAB123);
    assert_int_equal(d->identity.revision, 2);
    assert_int_equal(d->device_type, 5001);
    assert_string_equal(d->type_name, "T-1");
    assert_string_equal(d->vendor_name, "Works");
    assert_string_equal(d->group_type, "G");
    assert_string_equal(d->full_name, "A thing");
    assert_string_equal(d->group_name, "Group");
    assert_string_equal(d->physics, "YK");
    assert_int_equal(d->sii_size, 2048);
    assert_int_equal(d->sm_count, 4);
    assert_true(d->sm[0].start == 0x1000 && d->sm[0].length == 256 && d->sm[1].start == 0x1200);
    assert_true(d->sm[2].start == 0x1400 && d->sm[3].start == 0x1A00 && d->sm[3].control == 0x20);
    assert_int_equal(d->coe_details, ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS);
    assert_memory_equal(d->esc_config, config, sizeof config);
    assert_int_equal(d->dc_mode_count, 2);
    assert_string_equal(d->dc_modes[0].name, "DC");
    assert_string_equal(d->dc_modes[0].description, "SYNC0");
    assert_int_equal(d->dc_modes[0].cycle_sync0_ns, 0);
    assert_string_equal(d->dc_modes[1].name, "DC2");
    assert_int_equal(d->dc_modes[1].assign_activate, 0x700);
    assert_int_equal(d->dc_modes[1].cycle_sync0_ns, 1000);
    assert_int_equal(d->dc_modes[1].shift_sync0_ns, 0);
    assert_int_equal((int)m.model->dcs[1].cycle_sync1_ns, 2000);
    assert_int_equal(d->dc_modes[1].shift_sync1_ns, 30);
    assert_int_equal(d->dc_modes[0].assign_activate, 0x300);
    assert_int_equal(d->dc_modes[0].shift_sync0_ns, 50);
    assert_int_equal(object_of(&m, 0x1008)->entries[0].bit_length, 56);
    assert_int_equal(object_of(&m, 0x1009)->entries[0].bit_length, 24);
    assert_int_equal(object_of(&m, 0x100A)->entries[0].value, 0x332E32);
    drop(&m);
}

static void the_chip_determines_the_first_words_of_the_eeprom(void **state)
{
    static const struct {
        const char *form;
        uint8_t config[14];
    } rows[] = {
        {", \"ESC\": \"ET1100\"", {0x05, 0x06, 0x03, 0x44, 0x64}},
        {", \"ESC\": \"AX58100\"", {0x05, 0x06, 0x03, 0x44, 0x64, 0, 0, 0, 0, 0, 0x1A, 0}},
        {", \"ESC\": \"LAN9252\"", {0x80, 0x06, 0x03, 0x44, 0x64}},
        {", \"ESC\": \"LAN9253 Beckhoff\"", {0x05, 0x06, 0x03, 0x44, 0x64, 0, 0, 0, 0, 0, 0x40, 0xC0}},
        {", \"ESC\": \"LAN9253 Direct\"", {0x82, 0x06, 0x03, 0x44, 0x64, 0, 0, 0, 0, 0, 0x40, 0xC0}},
        {", \"ESC\": \"LAN9253 Indirect\"", {0x80, 0x06, 0x03, 0x44, 0x64, 0, 0, 0, 0, 0, 0x40, 0xC0}},
        {", \"ESC\": \"another\"", {0x05, 0x06, 0x03, 0x44, 0x64}},
        {"", {0x05, 0x06, 0x03, 0x44, 0x64}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[2000];
        (void)snprintf(json, sizeof json, FORM("%s") "\"od\": {}}", rows[i].form);
        made_t m = make(json);
        assert_memory_equal(device_of(&m)->esc_config, rows[i].config, sizeof rows[i].config);
        drop(&m);
    }
}

static void each_box_of_the_form_is_one_feature(void **state)
{
    static const struct {
        const char *form, *checked;
    } rows[] = {
        {"", ""},
        {", \"DetailsEnableUseFoE\": true", "foe "},
        {", \"DetailsEnableUseFoE\": false", ""},
        {", \"CoeDetailsEnableSDOInfo\": \"on\"", "info "},
        {", \"CoeDetailsEnableSDOInfo\": \"off\"", ""},
        {", \"CoeDetailsEnablePDOAssign\": true", "assign "},
        {", \"CoeDetailsEnablePDOConfiguration\": true", "config "},
        {", \"CoeDetailsEnableUploadAtStartup\": true", "upload "},
        {", \"CoeDetailsEnableSDOCompleteAccess\": true", "complete "},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[2000], checked[100];
        (void)snprintf(json, sizeof json, FORM("%s") "\"od\": {}}", rows[i].form);
        made_t m = try_text(json);
        const ect_esi_mailbox_t *b = &m.model->mailbox;
        assert_true(b->given && b->coe && b->data_link_layer);
        (void)snprintf(checked, sizeof checked, "%s%s%s%s%s%s", b->foe ? "foe " : "", b->sdo_info ? "info " : "",
                       b->pdo_assign ? "assign " : "", b->pdo_config ? "config " : "", b->pdo_upload ? "upload " : "",
                       b->complete_access ? "complete " : "");
        assert_string_equal(checked, rows[i].checked);
        drop(&m);
    }
}

#define STRING(keys) "\"sdo\": {\"2000\": {\"otype\": \"VAR\", \"dtype\": \"VISIBLE_STRING\", \"name\": \"S\"" keys "}}"

static void a_text_is_as_long_as_its_size_or_its_value(void **state)
{
    static const struct {
        const char *od;
        uint16_t bits, access;
    } rows[] = {
        {STRING(""), 8, ECT_ACCESS_RO},
        {STRING(", \"value\": \"\""), 8, ECT_ACCESS_RO},
        {STRING(", \"value\": \"abc\", \"access\": \"RO\""), 24, ECT_ACCESS_RO},
        {STRING(", \"value\": \"abc\", \"size\": 0, \"access\": \"RW\""), 24, ECT_ACCESS_RW},
        {STRING(", \"value\": \"abc\", \"size\": 7, \"access\": \"RWpre\""), 56, ECT_ACCESS_RW_PREOP},
        {STRING(", \"size\": 12, \"access\": \"WO\""), 96, ECT_ACCESS_WO},
        {STRING(", \"access\": \"W\""), 8, ECT_ACCESS_RO},
        {STRING(", \"access\": \"R\""), 8, ECT_ACCESS_RO},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[2000];
        (void)snprintf(json, sizeof json, PROJECT("%s"), rows[i].od);
        made_t m = make(json);
        assert_int_equal(object_of(&m, 0x2000)->entries[0].bit_length, rows[i].bits);
        assert_int_equal(object_of(&m, 0x2000)->entries[0].access, rows[i].access);
        drop(&m);
    }
}

static void the_lowest_index_and_the_fewest_and_most_items_are_taken(void **state)
{
    enum { ROOM = 20000 };
    char *json = malloc(ROOM);
    assert_non_null(json);
    (void)state;
    static const unsigned int counts[] = {2, 255, 256};
    for (size_t n = 0; n < sizeof counts / sizeof counts[0]; n++) {
        const unsigned int count = counts[n];
        char *at = json + sprintf(json, "%s",
                                  FORM("") "\"od\": {\"sdo\": {\"0FFF\": 5, \"1002\": {\"otype\": \"ARRAY\", "
                                           "\"dtype\": \"UNSIGNED8\", \"name\": \"Row\", \"items\": [{}");
        for (unsigned int i = 1; i < count; i++)
            at += sprintf(at, ", {\"name\": \"a\"}");
        (void)sprintf(at, "]}}}}");
        made_t m = try_text(json);
        if (count <= 255) {
            m = whole("items", m);
            assert_int_equal(entry_of(&m, 0x1002, 0)->value, count - 1);
            assert_non_null(entry_of(&m, 0x1002, (uint8_t)(count - 1)));
        } else {
            assert_null(m.twin);
            assert_non_null(strstr(m.why, "'items' takes 2 to 255 of them"));
        }
        drop(&m);
    }
    free(json);
}

static void fields_that_the_form_lacks_have_defaults(void **state)
{
    (void)state;
    made_t m = try_text("{\"form\": {\"TextDeviceType\": \"T\"}, \"od\": {}}");
    assert_non_null(m.model);
    assert_int_equal(m.model->vendor_id, 0);
    assert_int_equal(m.model->product_code, 0);
    assert_int_equal(m.model->revision, 0);
    assert_int_equal(m.model->profile, 0);
    assert_int_equal(m.model->eeprom_size, 0);
    assert_string_equal(m.model->type, "T");
    assert_string_equal(m.model->vendor_name, "");
    assert_string_equal(m.model->name, "");
    assert_string_equal(m.model->group_type, "");
    assert_string_equal(m.model->group_name, "");
    assert_string_equal(m.model->physics, "");
    assert_int_equal(m.model->config.bytes[2], 0);
    assert_int_equal(m.model->sm_count, 4);
    assert_int_equal((int)m.model->sms[0].size.value, 128);
    assert_int_equal(m.model->sms[3].start, 0);
    drop(&m);
}

static void each_object_of_process_data_is_a_pdo(void **state)
{
    (void)state;
    made_t m = make(PROJECT(
        "\"sdo\": {\"2000\": {\"otype\": \"ARRAY\", \"name\": \"Row\", \"dtype\": \"UNSIGNED16\", \"access\": "
        "\"RWpre\", "
        "\"items\": [{\"name\": \"Max SubIndex\"}, {\"name\": \"a\", \"value\": \"0x10\"}, {\"name\": \"b\"}]}, "
        "\"A\": {\"otype\": \"VAR\"}, \"60664\": 1, \"zzzz\": 2, \"2001\": {\"otype\": \"VAR\", \"dtype\": "
        "\"VISIBLE_STRING\", \"name\": \"S\", \"access\": \"RW\", \"size\": 5, \"value\": \"ab\", \"data\": "
        "\"&Obj.s\"}}, "
        "\"txpdo\": {\"60A0\": {\"otype\": \"VAR\", \"dtype\": \"REAL32\", \"name\": \"Late\", \"value\": \"0\"}, "
        "\"6000\": {\"otype\": \"VAR\", \"dtype\": \"BOOLEAN\", \"name\": \"Flag\", \"access\": \"RO\", "
        "\"pdo_mappings\": [\"txpdo\"]}}, "
        "\"rxpdo\": {\"7000\": {\"otype\": \"RECORD\", \"name\": \"Out\", \"items\": [{\"name\": \"Max SubIndex\"}, "
        "{\"name\": \"x\", \"dtype\": \"INTEGER32\"}, {\"name\": \"y\", \"dtype\": \"UNSIGNED8\", \"access\": "
        "\"WO\"}]}}"));
    assert_int_equal(m.model->pdo_count, 3);
    for (size_t i = 0; i < m.model->pdo_count; i++)
        assert_true(m.model->pdos[i].mandatory && m.model->pdos[i].fixed);
    assert_int_equal(ect_od_element(object_of(&m, 0x1A00), 0), 2);
    assert_int_equal(ect_od_element(object_of(&m, 0x1A00), 1), 0x60000001);
    assert_int_equal(ect_od_element(object_of(&m, 0x1A00), 2), 7);
    assert_int_equal(ect_od_element(object_of(&m, 0x1A01), 1), 0x60A00020);
    assert_int_equal(ect_od_element(object_of(&m, 0x1600), 2), 0x70000208);
    assert_int_equal(ect_od_element(object_of(&m, 0x1C13), 2), 0x1A01);
    assert_string_equal(object_of(&m, 0x1A00)->name, "Flag");
    assert_int_equal(object_of(&m, 0x2000)->entries[1].value, 0x10);
    assert_int_equal(object_of(&m, 0x2000)->entries[2].access, ECT_ACCESS_RW_PREOP);
    assert_int_equal(object_of(&m, 0x2001)->entries[0].bit_length, 40);
    assert_int_equal(object_of(&m, 0x7000)->entries[2].access, ECT_ACCESS_WO | ECT_ACCESS_RXPDO);
    assert_int_equal(ect_device_bytes(device_of(&m), ECT_SM_INPUTS), 5);
    assert_int_equal(ect_device_bytes(device_of(&m), ECT_SM_OUTPUTS), 5);
    drop(&m);
}

/* A BOOLEAN is a bit in an array, and the lowest bit of a byte elsewhere. */
static void a_boolean_fills_a_byte_of_process_data_except_in_an_array(void **state)
{
#define SHAPE(otype, items)                                                                                            \
    "\"txpdo\": {\"6000\": {\"otype\": \"" otype "\", \"dtype\": \"BOOLEAN\", \"name\": \"Flag\"" items "}}"
#define ITEM(name) "{\"name\": \"" name "\", \"dtype\": \"BOOLEAN\"}"
    static const struct {
        const char *od;
        uint32_t elements[5];
    } rows[] = {
        {SHAPE("VAR", ""), {2, 0x60000001, 7}},
        {SHAPE("ARRAY", ", \"items\": [{}, " ITEM("a") ", " ITEM("b") "]"), {2, 0x60000101, 0x60000201}},
        {SHAPE("RECORD", ", \"items\": [{}, " ITEM("a") ", " ITEM("b") "]"), {4, 0x60000101, 7, 0x60000201, 7}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[2000];
        (void)snprintf(json, sizeof json, PROJECT("%s"), rows[i].od);
        made_t m = try_text(json);
        assert_non_null(m.twin);
        for (unsigned int n = 0; n <= rows[i].elements[0]; n++)
            assert_int_equal(ect_od_element(object_of(&m, 0x1A00), n), rows[i].elements[n]);
        drop(&m);
    }
}

static void a_wrong_project_is_refused_with_its_line(void **state)
{
    static const struct {
        const char *json, *why;
    } rows[] = {
        {"{\"form\": 1, \"od\": {}}", "esi.json:1: 'form' and 'od' of a project are mappings: save the project again"},
        {"{\"form\": {}, \"od\": {}}", "esi.json:1: the form has no 'TextDeviceType': save the project again"},
        {"{\"form\": {\"VendorID\": \"x\"}, \"od\": {}}", "esi.json:1: 'VendorID' takes a number from 0 to 4294967295"},
        {"{\"form\": {}}", "esi.json:1: 'ectwin-device: 1' is missing"},
        {PROJECT("\"sdo\": 5"), "esi.json:3: sdo: 'key: value' lines are missing"},
        {PROJECT("\"sdo\": {\"2000\": 5}"), "esi.json:3: object 2000 is no object: save the project again"},
        {PROJECT("\"sdo\": {\"2000\": {\"name\": \"A\"}}"),
         "esi.json:3: object 2000: 'otype' takes VAR, ARRAY or RECORD"},
        {PROJECT("\"sdo\": {\"2000\": {\"otype\": \"VAR\"}}"), "esi.json:3: object 2000 has no 'name'"},
        {PROJECT("\"sdo\": {\"2000\": {\"otype\": \"VAR\", \"name\": \"A\"}}"), "esi.json:3: 'type' is missing: BOOL"},
        {PROJECT("\"sdo\": {\"2000\": {\"otype\": \"RECORD\", \"name\": \"A\", \"items\": [{}]}}"),
         "esi.json:3: 'items' takes 2 to 255 of them"},
        {PROJECT("\"sdo\": {\"2000\": {\"otype\": \"VAR\", \"name\": \"A\", \"dtype\": \"INTEGER8\", \"value\": 200}}"),
         "esi.json:3: 'default' takes a number from -128 to 127, not '200'"},
        {PROJECT("\"rxpdo\": {\"7000\": {\"otype\": \"VAR\", \"name\": \"A\", \"dtype\": \"INTEGER8\"}}, \"sdo\": "
                 "{\"7000\": {\"otype\": \"VAR\", \"name\": \"A\", \"dtype\": \"INTEGER8\"}}"),
         "esi.json:3: object 7000 occurs twice, first in line 3"},
        {PROJECT("\"txpdo\": {\"6000\": {\"otype\": \"VAR\", \"name\": \"A\", \"dtype\": \"INTEGER8\", \"access\": "
                 "\"WO\"}}"),
         "esi.json:3: 6000:0 is an input and cannot be read: change its"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = try_text(rows[i].json);
        if (m.twin != NULL || strncmp(m.why, rows[i].why, strlen(rows[i].why)) != 0)
            fail_msg("row %zu: expected \"%s\", got \"%s\"", i, rows[i].why, m.why);
        drop(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_form_is_identity_and_layout),
        cmocka_unit_test(the_chip_determines_the_first_words_of_the_eeprom),
        cmocka_unit_test(each_box_of_the_form_is_one_feature),
        cmocka_unit_test(a_text_is_as_long_as_its_size_or_its_value),
        cmocka_unit_test(the_lowest_index_and_the_fewest_and_most_items_are_taken),
        cmocka_unit_test(fields_that_the_form_lacks_have_defaults),
        cmocka_unit_test(each_object_of_process_data_is_a_pdo),
        cmocka_unit_test(a_boolean_fills_a_byte_of_process_data_except_in_an_array),
        cmocka_unit_test(a_wrong_project_is_refused_with_its_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
