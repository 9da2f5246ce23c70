/* SPDX-License-Identifier: MIT */
/* The dictionary of a slave, added to its EEPROM image: the twin has the present values of the slave. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/catalogue.h"
#include "esi/image.h"
#include "esi/twin.h"
#include "od/od.h"
#include "sii/sii.h"

enum { IMAGE = 0x8000, TEXT = 400 };

typedef struct made {
    ect_esi_t *esi;
    const ect_esi_device_t *model;
    ect_esi_twin_t *twin;
    const ect_device_t *device;
} made_t;

/* The image of the vision sensor, which has CoE. */
static ect_esi_t *open_image(void)
{
    static uint8_t image[IMAGE];
    char why[TEXT];
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    assert_int_equal(ect_sii_write(device, NULL, 0, image, sizeof image), device->sii_size);
    ect_esi_t *esi = ect_esi_of_image("image", image, device->sii_size, why, sizeof why);
    assert_non_null(esi);
    return esi;
}

static made_t finish(ect_esi_t *esi)
{
    char why[TEXT] = "";
    made_t m = {.esi = esi};
    ect_esi_found_end(esi);
    m.model = ect_esi_select(esi, "", why, sizeof why);
    m.twin = ect_esi_twin_of(esi, m.model, NULL, 0, why, sizeof why);
    if (m.twin == NULL)
        fail_msg("no twin: %s", why);
    m.device = ect_esi_twin_product(m.twin)->device;
    return m;
}

static void drop(made_t *m)
{
    ect_esi_twin_free(m->twin);
    ect_esi_close(m->esi);
}

static void object(ect_esi_t *esi, uint16_t index, uint8_t code, const char *name)
{
    const ect_esi_found_object_t found = {.index = index, .described = true, .code = code, .name = name};
    ect_esi_found_object(esi, &found);
}

static void entry(ect_esi_t *esi, uint8_t subindex, uint16_t type, uint16_t bits, uint16_t access, uint32_t value)
{
    char name[20];
    uint8_t bytes[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24)};
    (void)snprintf(name, sizeof name, "Entry %u", subindex);
    const ect_esi_found_entry_t found = {.subindex = subindex,
                                         .type = type,
                                         .bits = bits,
                                         .access = access,
                                         .name = name,
                                         .value = {.bytes = bytes, .length = (bits + 7u) / 8u}};
    ect_esi_found_entry(esi, &found);
}

static const ect_entry_t *find(const made_t *m, uint16_t index, uint8_t subindex)
{
    const ect_od_t od = ect_device_od(m->device, NULL);
    const ect_object_t *found = ect_od_find(&od, index);
    for (unsigned int i = 0; found != NULL && i <= found->last; i++) {
        if (found->entries[i].subindex == subindex)
            return &found->entries[i];
    }
    return NULL;
}

static void entries_keep_type_rights_and_value(void **state)
{
    static const struct {
        uint16_t type, bits, access;
        uint32_t value;
    } rows[] = {
        {ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 7},
        {ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 0x1234},
        {ECT_TYPE_INTEGER32, 32, ECT_ACCESS_RW, 0xFFFFFFFE},
        {ECT_TYPE_REAL32, 32, ECT_ACCESS_RO, 0x3FC00000},
        {ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RO, 1},
        {ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW_PREOP, 5},
        {ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_WO, 0},
        {ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_R_PREOP | ECT_ACCESS_R_OP, 5},
        {ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW | ECT_ACCESS_BACKUP | ECT_ACCESS_SETTING, 5},
        {ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, 5},
        {ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW | ECT_ACCESS_RXPDO, 5},
        {ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW | ECT_ACCESS_RXPDO | ECT_ACCESS_TXPDO, 5},
    };
    (void)state;
    ect_esi_t *esi = open_image();
    object(esi, 0x4100, ECT_OBJECT_RECORD, "Rows");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, sizeof rows / sizeof rows[0]);
    for (uint8_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        entry(esi, (uint8_t)(i + 1), rows[i].type, rows[i].bits, rows[i].access, rows[i].value);
    made_t m = finish(esi);
    for (uint8_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_entry_t *found = find(&m, 0x4100, (uint8_t)(i + 1));
        print_message("row %u\n", i);
        assert_non_null(found);
        assert_int_equal(found->data_type, rows[i].type);
        assert_int_equal(found->bit_length, rows[i].bits);
        assert_int_equal(found->access & ECT_ACCESS_WIRE, rows[i].access);
        assert_int_equal(found->value, rows[i].value);
    }
    drop(&m);
}

/* An array of an ESI file has one type and the same rights for all elements; the names of its elements stay. */
static void object_codes_stay(void **state)
{
    (void)state;
    ect_esi_t *esi = open_image();
    object(esi, 0x4100, ECT_OBJECT_VAR, "Single");
    entry(esi, 0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 9);
    object(esi, 0x4101, ECT_OBJECT_ARRAY, "Array");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 2);
    entry(esi, 1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 11);
    entry(esi, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 12);
    object(esi, 0x4102, ECT_OBJECT_ARRAY, "Array of two types");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 2);
    entry(esi, 1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 13);
    entry(esi, 2, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, 14);
    made_t m = finish(esi);
    const ect_od_t od = ect_device_od(m.device, NULL);
    assert_int_equal(ect_od_find(&od, 0x4100)->object_code, ECT_OBJECT_VAR);
    assert_int_equal(ect_od_find(&od, 0x4101)->object_code, ECT_OBJECT_ARRAY);
    assert_int_equal(ect_od_find(&od, 0x4102)->object_code, ECT_OBJECT_RECORD);
    assert_int_equal(find(&m, 0x4100, 0)->value, 9);
    assert_int_equal(find(&m, 0x4101, 2)->value, 12);
    assert_string_equal(find(&m, 0x4101, 2)->name, "Entry 2");
    assert_int_equal(find(&m, 0x4102, 2)->value, 14);
    drop(&m);
}

/* An array whose second element differs from the first in this is none that an ESI file can describe. */
static void elements_that_differ_make_a_record(void **state)
{
    static const struct {
        const char *title;
        uint8_t first, second; /* sub-indices */
        uint16_t type, bits, access;
    } rows[] = {
        {"data type", 1, 2, ECT_TYPE_INTEGER16, 16, ECT_ACCESS_RW},
        {"length", 1, 2, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW},
        {"read only", 1, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO},
        {"read in PREOP", 1, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_WO | ECT_ACCESS_R_PREOP},
        {"written in PREOP", 1, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW_PREOP},
        {"can be mapped", 1, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW | ECT_ACCESS_TXPDO},
        {"backup", 1, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW | ECT_ACCESS_BACKUP},
        {"setting", 1, 2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW | ECT_ACCESS_SETTING},
        {"a gap", 1, 3, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW},
        {"no first element", 2, 3, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        print_message("%s\n", rows[i].title);
        ect_esi_t *esi = open_image();
        object(esi, 0x4100, ECT_OBJECT_ARRAY, "Array");
        entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, rows[i].second);
        entry(esi, rows[i].first, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 1);
        entry(esi, rows[i].second, rows[i].type, rows[i].bits, rows[i].access, 2);
        made_t m = finish(esi);
        const ect_od_t od = ect_device_od(m.device, NULL);
        assert_int_equal(ect_od_find(&od, 0x4100)->object_code, ECT_OBJECT_RECORD);
        assert_int_equal(find(&m, 0x4100, rows[i].second)->access & ECT_ACCESS_WIRE, rows[i].access);
        drop(&m);
    }
}

/* Slaves give limits of any length, and units of two bytes, or of the four that an ESI file has. */
static void limits_and_units_stay(void **state)
{
    static const uint8_t minimum[] = {0xF6, 0xFF}, maximum[] = {0x0A, 0x00}, two[] = {0x01, 0xFD},
                         four[] = {0, 0, 0x01, 0xFD}, long_one[] = {0, 0, 0, 0, 0, 0, 0, 0, 1};
    const ect_esi_found_entry_t rows[] = {
        {.subindex = 1, .unit = {two, 2}, .minimum = {minimum, 2}, .maximum = {maximum, 2}},
        {.subindex = 2, .unit = {four, 4}},
        {.subindex = 3, .minimum = {long_one, sizeof long_one}, .maximum = {maximum, 0}},
    };
    (void)state;
    ect_esi_t *esi = open_image();
    object(esi, 0x4100, ECT_OBJECT_RECORD, "Record");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 3);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_found_entry_t row = rows[i];
        row.type = ECT_TYPE_INTEGER16;
        row.bits = 16;
        row.access = ECT_ACCESS_RW;
        row.name = "Entry";
        ect_esi_found_entry(esi, &row);
    }
    made_t m = finish(esi);
    assert_int_equal(m.device->detail_count, 2); /* the third has neither */
    assert_int_equal(m.device->details[0].unit, 0xFD01);
    assert_int_equal(m.device->details[0].minimum, -10);
    assert_int_equal(m.device->details[0].maximum, 10);
    assert_int_equal(m.device->details[1].unit, 0xFD01);
    drop(&m);
}

static void mapping(ect_esi_t *esi, uint16_t index, uint32_t first, uint32_t second)
{
    object(esi, index, ECT_OBJECT_RECORD, "Mapping");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW, second != 0 ? 2 : 1);
    entry(esi, 1, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, first);
    if (second != 0)
        entry(esi, 2, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, second);
}

static void assignment(ect_esi_t *esi, uint16_t index, uint16_t pdo)
{
    object(esi, index, ECT_OBJECT_ARRAY, "Assignment");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW, pdo != 0 ? 1 : 0);
    if (pdo != 0)
        entry(esi, 1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, pdo);
}

static const ect_esi_pdo_t *pdo_at(const made_t *m, uint16_t index)
{
    for (size_t i = 0; i < m->model->pdo_count; i++) {
        if (m->model->pdos[i].index == index)
            return &m->model->pdos[i];
    }
    return NULL;
}

/* The image announces neither PDO assignment nor PDO configuration, and its PDOs are fixed. */
static void CLN_015_a_mapping_and_an_assignment_keep_the_right_of_a_master_to_write_them(void **state)
{
    static const struct {
        const char *title;
        uint16_t found, of_mapping, of_assignment;
    } rows[] = {
        {"none", ECT_ACCESS_RO, ECT_ACCESS_RO, ECT_ACCESS_RO},
        {"in PREOP", ECT_ACCESS_RW_PREOP, ECT_ACCESS_RW_PREOP, ECT_ACCESS_RW_PREOP},
        {"in SAFEOP only", ECT_ACCESS_RO | ECT_ACCESS_W_SAFEOP, ECT_ACCESS_RO, ECT_ACCESS_RO},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi = open_image();
        for (uint16_t index = 0x1A05; index != 0; index = index == 0x1A05 ? 0x1600 : 0) {
            object(esi, index, ECT_OBJECT_RECORD, "Mapping");
            entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, rows[i].found, 1);
            entry(esi, 1, ECT_TYPE_UNSIGNED32, 32, rows[i].found, 0x21000220);
        }
        object(esi, 0x1C13, ECT_OBJECT_ARRAY, "Assignment");
        entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, rows[i].found, 1);
        entry(esi, 1, ECT_TYPE_UNSIGNED16, 16, rows[i].found, 0x1A05);
        made_t m = finish(esi);
        assert_int_equal(m.device->coe_details & (ECT_COE_PDO_ASSIGN | ECT_COE_PDO_CONFIG), 0);
        if (find(&m, 0x1A05, 1)->access != rows[i].of_mapping || find(&m, 0x1C13, 1)->access != rows[i].of_assignment ||
            find(&m, 0x1600, 1)->access != ECT_ACCESS_RO)
            fail_msg("%s: expected 0x%04X, 0x%04X and a fixed PDO, got 0x%04X, 0x%04X, 0x%04X", rows[i].title,
                     rows[i].of_mapping, rows[i].of_assignment, find(&m, 0x1A05, 1)->access,
                     find(&m, 0x1C13, 1)->access, find(&m, 0x1600, 1)->access);
        drop(&m);
    }
}

static void CLN_015_names_of_values_and_of_the_identity_stay(void **state)
{
    (void)state;
    ect_esi_t *esi = open_image();
    object(esi, 0x1018, ECT_OBJECT_RECORD, "Identity Object");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 4);
    object(esi, 0x4100, ECT_OBJECT_VAR, "Speed");
    entry(esi, 0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 9);
    object(esi, 0x4101, ECT_OBJECT_VAR, "Entry 0");
    entry(esi, 0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 9);
    made_t m = finish(esi);
    const ect_od_t od = ect_device_od(m.device, NULL);
    assert_string_equal(ect_od_find(&od, 0x1018)->name, "Identity Object");
    assert_string_equal(ect_od_find(&od, 0x4100)->name, "Speed");
    assert_string_equal(find(&m, 0x4100, 0)->name, "Entry 0");
    assert_string_equal(m.model->dictionary.objects[1].info.display, "Entry 0");
    assert_string_equal(find(&m, 0x4101, 0)->name, "Entry 0");
    assert_string_equal(m.model->dictionary.objects[2].info.display, "");
    drop(&m);
}

static void mappings_and_assignments_replace_those_of_the_image(void **state)
{
    (void)state;
    ect_esi_t *esi = open_image();
    mapping(esi, 0x1A05, 0x60000110, 0x60000208);
    assignment(esi, 0x1C13, 0x1A05);
    made_t m = finish(esi);
    assert_int_equal(ect_device_bytes(m.device, ECT_SM_INPUTS), 3);
    assert_int_equal(pdo_at(&m, 0x1A05)->sm, 3);
    for (size_t i = 0; i < m.model->pdo_count; i++) {
        const ect_esi_pdo_t *pdo = &m.model->pdos[i];
        assert_true(!pdo->tx || pdo->index == 0x1A05 || pdo->sm == -1); /* those of the image */
        assert_true(i == 0 || m.model->pdos[i - 1].tx <= pdo->tx);      /* outputs first */
    }
    drop(&m);
}

/* 1C10h to 1C2Fh are assignments. */
static void the_objects_of_assignments(void **state)
{
    static const struct {
        uint16_t index;
        int sm; /* -1: none */
    } rows[] = {{0x1C0F, -1}, {0x1C10, 0}, {0x1C13, 3}, {0x1C2F, 31}, {0x1C30, -1}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi = open_image();
        mapping(esi, 0x1A05, 0x60000110, 0x60000208);
        assignment(esi, rows[i].index, 0x1A05);
        char why[TEXT] = "";
        ect_esi_found_end(esi); /* a twin would have no assignment of a mailbox */
        made_t m = {.esi = esi, .model = ect_esi_select(esi, "", why, sizeof why)};
        if (pdo_at(&m, 0x1A05)->sm != rows[i].sm)
            fail_msg("%04X: expected SyncManager %d, got %d", rows[i].index, rows[i].sm, pdo_at(&m, 0x1A05)->sm);
        drop(&m);
    }
}

/* Mappings of both directions in turn, more than the image has room for. */
static void many_mappings_stay_in_order(void **state)
{
    enum { FIRST = 5, LAST = 25 };
    (void)state;
    ect_esi_t *esi = open_image();
    for (uint16_t n = FIRST; n <= LAST; n++) {
        mapping(esi, 0x1A00 + n, 0x60000010 + n, 0);
        mapping(esi, 0x1600 + n, 0x70000010 + n, 0);
    }
    made_t m = finish(esi);
    for (size_t i = 1; i < m.model->pdo_count; i++)
        assert_true(m.model->pdos[i - 1].index < m.model->pdos[i].index);
    for (uint16_t n = FIRST; n <= LAST; n++) {
        const ect_esi_pdo_t *outputs = pdo_at(&m, 0x1600 + n), *inputs = pdo_at(&m, 0x1A00 + n);
        if (outputs == NULL || outputs->tx || outputs->entry_count != 1 || outputs->entries[0].index != 0x7000 ||
            outputs->entries[0].bits != 0x10u + n || inputs == NULL || !inputs->tx || inputs->entry_count != 1 ||
            inputs->entries[0].index != 0x6000 || inputs->entries[0].bits != 0x10u + n)
            fail_msg("expected the mappings of PDOs %04X and %04X", 0x1600u + n, 0x1A00u + n);
    }
    drop(&m);
}

/* A PDO of the image keeps its name, its flags, and the names and types of the entries that it still maps. */
static void a_mapping_keeps_what_the_image_knows(void **state)
{
    (void)state;
    ect_esi_t *esi = open_image();
    mapping(esi, 0x1600, 0x21000220, 0x21000108); /* the second one with another length */
    mapping(esi, 0x1605, 0x41000110, 0x00000008);
    object(esi, 0x4100, ECT_OBJECT_RECORD, "Record");
    entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 1);
    entry(esi, 1, ECT_TYPE_INTEGER16, 16, ECT_ACCESS_RW | ECT_ACCESS_RXPDO, 0);
    object(esi, 0x4101, ECT_OBJECT_RECORD, "Object without entries");
    made_t m = finish(esi);
    const ect_esi_pdo_t *old = pdo_at(&m, 0x1600), *added = pdo_at(&m, 0x1605);
    assert_string_equal(old->name, "Command area mapping");
    assert_true(old->fixed && old->mandatory);
    assert_string_not_equal(old->entries[0].name, "");
    assert_string_equal(old->entries[0].type, "UDINT");
    assert_string_equal(old->entries[1].name, "");
    assert_string_equal(old->entries[1].type, "");
    assert_string_equal(added->name, "Mapping");
    assert_false(added->fixed || added->mandatory);
    assert_string_equal(added->entries[0].name, "Entry 1");
    assert_string_equal(added->entries[0].type, "INT");
    assert_int_equal(added->entries[1].index, 0);
    assert_ptr_equal(old + 1, added); /* before the PDOs of inputs */
    drop(&m);
}

/* The assignment of a SyncManager that was not read leaves it the PDOs of the image. */
static void without_an_assignment_the_image_counts(void **state)
{
    (void)state;
    ect_esi_t *esi = open_image();
    object(esi, 0x4100, ECT_OBJECT_VAR, "Single");
    entry(esi, 0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, 9);
    made_t m = finish(esi);
    const ect_device_t *original = ect_catalogue_find("fzm1")->device;
    assert_int_equal(ect_device_bytes(m.device, ECT_SM_INPUTS), ect_device_bytes(original, ECT_SM_INPUTS));
    assert_int_equal(ect_device_bytes(m.device, ECT_SM_OUTPUTS), ect_device_bytes(original, ECT_SM_OUTPUTS));
    drop(&m);
}

/* A slave without SDO information: values of mappings are known, types are not (CLN-010). */
static void an_object_without_description_has_only_its_pdos(void **state)
{
    static const uint8_t one[] = {1}, value[] = {0x08, 0x01, 0x00, 0x60}, pdo[] = {0x05, 0x1A};
    (void)state;
    ect_esi_t *esi = open_image();
    const ect_esi_found_object_t mapping = {.index = 0x1A05, .name = ""}, assigned = {.index = 0x1C13, .name = ""};
    const ect_esi_found_entry_t count = {.name = "", .value = {one, 1}};
    const ect_esi_found_entry_t mapped = {.subindex = 1, .name = "", .value = {value, 4}};
    const ect_esi_found_entry_t first = {.subindex = 1, .name = "", .value = {pdo, 2}};
    ect_esi_found_object(esi, &assigned);
    ect_esi_found_entry(esi, &count);
    ect_esi_found_entry(esi, &first);
    ect_esi_found_object(esi, &mapping);
    ect_esi_found_entry(esi, &count);
    ect_esi_found_entry(esi, &mapped);
    made_t m = finish(esi);
    assert_int_equal(m.model->dictionary.object_count, 0);
    assert_int_equal(ect_device_bytes(m.device, ECT_SM_INPUTS), 1);
    assert_string_equal(pdo_at(&m, 0x1A05)->entries[0].type, "");
    drop(&m);
}

/* Arrays and single values that are none: entries that an ESI file cannot describe so become those of a record. */
static void shapes_that_do_not_fit_their_code(void **state)
{
    static const struct {
        const char *title;
        uint8_t code, first, second; /* sub-indices; second 0: none */
        uint8_t expected;
    } rows[] = {
        {"a single value", ECT_OBJECT_VAR, 0, 0, ECT_OBJECT_VAR},
        {"a single value with an element", ECT_OBJECT_VAR, 0, 1, ECT_OBJECT_RECORD},
        {"an array without elements", ECT_OBJECT_ARRAY, 0, 0, ECT_OBJECT_RECORD},
        {"an array without entry 0", ECT_OBJECT_ARRAY, 1, 2, ECT_OBJECT_RECORD},
        {"a single value at sub-index 1", ECT_OBJECT_VAR, 1, 0, ECT_OBJECT_RECORD},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi = open_image();
        object(esi, 0x4100, rows[i].code, "Object");
        entry(esi, rows[i].first, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 1);
        if (rows[i].second != 0)
            entry(esi, rows[i].second, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 1);
        made_t m = finish(esi);
        const ect_od_t od = ect_device_od(m.device, NULL);
        const ect_object_t *found = ect_od_find(&od, 0x4100);
        if (found == NULL || found->object_code != rows[i].expected || find(&m, 0x4100, rows[i].first) == NULL)
            fail_msg("%s: expected object code %u with entry %u, got %u", rows[i].title, rows[i].expected,
                     rows[i].first, found != NULL ? found->object_code : 0u);
        drop(&m);
    }
}

/* SOES describes a text without a length: the value, if there is one, has it. */
static void texts_without_a_length(void **state)
{
    static const struct {
        uint16_t type, described;
        size_t length;
        uint16_t bits;
    } rows[] = {
        {ECT_TYPE_VISIBLE_STRING, 0, 3, 24},
        {ECT_TYPE_VISIBLE_STRING, 0, 1, 8},
        {ECT_TYPE_VISIBLE_STRING, 0, 0, 8},
        {ECT_TYPE_VISIBLE_STRING, 16, 2, 16},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_esi_found_entry_t text = {.type = rows[i].type,
                                            .bits = rows[i].described,
                                            .access = ECT_ACCESS_RO,
                                            .name = "",
                                            .value = {(const uint8_t *)"abc", rows[i].length}};
        ect_esi_t *esi = open_image();
        object(esi, 0x4100, ECT_OBJECT_VAR, "Text");
        ect_esi_found_entry(esi, &text);
        made_t m = finish(esi);
        const ect_entry_t *found = find(&m, 0x4100, 0);
        if (found == NULL || found->bit_length != rows[i].bits || strcmp(found->name, "Text") != 0)
            fail_msg("row %zu: expected \"Text\" of %u bits, got %u", i, rows[i].bits,
                     found != NULL ? found->bit_length : 0u);
        drop(&m);
    }
}

/* Elements that SDO information describes in different ways make a record, although an ESI file has no other rights. */
static void elements_described_in_different_ways_make_a_record(void **state)
{
    static const struct {
        uint16_t bits, access; /* of the second element */
        uint8_t expected;
    } rows[] = {
        {8, ECT_ACCESS_RO, ECT_OBJECT_ARRAY},
        {8, 0, ECT_OBJECT_RECORD},
        {0, ECT_ACCESS_RO, ECT_OBJECT_RECORD},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi = open_image();
        object(esi, 0x4100, ECT_OBJECT_ARRAY, "Array");
        entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 2);
        entry(esi, 1, ECT_TYPE_VISIBLE_STRING, 8, ECT_ACCESS_RO, 'a');
        entry(esi, 2, ECT_TYPE_VISIBLE_STRING, rows[i].bits, rows[i].access, 'b');
        made_t m = finish(esi);
        const ect_od_t od = ect_device_od(m.device, NULL);
        if (ect_od_find(&od, 0x4100)->object_code != rows[i].expected)
            fail_msg("row %zu: expected object code %u, got %u", i, rows[i].expected,
                     ect_od_find(&od, 0x4100)->object_code);
        drop(&m);
    }
}

/* An element of an array without a value has none of another. */
static void elements_without_a_value(void **state)
{
    static const uint8_t two[] = {2}, seven[] = {7, 0}, five[] = {5, 0}, nine[] = {9, 0};
    static const ect_esi_found_entry_t entries[] = {
        {.subindex = 0, .type = ECT_TYPE_UNSIGNED8, .bits = 8, .access = ECT_ACCESS_RO, .name = "N", .value = {two, 1}},
        {.subindex = 1,
         .type = ECT_TYPE_UNSIGNED16,
         .bits = 16,
         .access = ECT_ACCESS_RW,
         .name = "A",
         .value = {seven, 2},
         .minimum = {five, 2},
         .maximum = {nine, 2}},
        {.subindex = 2, .type = ECT_TYPE_UNSIGNED16, .bits = 16, .access = ECT_ACCESS_RW, .name = "B"},
    };
    (void)state;
    ect_esi_t *esi = open_image();
    object(esi, 0x4100, ECT_OBJECT_ARRAY, "Array");
    for (size_t i = 0; i < sizeof entries / sizeof entries[0]; i++)
        ect_esi_found_entry(esi, &entries[i]);
    made_t m = finish(esi);
    const ect_od_t od = ect_device_od(m.device, NULL);
    assert_int_equal(ect_od_find(&od, 0x4100)->object_code, ECT_OBJECT_ARRAY);
    assert_int_equal(find(&m, 0x4100, 1)->value, 7);
    assert_int_equal(find(&m, 0x4100, 2)->value, 0);
    assert_string_equal(find(&m, 0x4100, 2)->name, "B");
    assert_int_equal(ect_od_detail(&od, 0x4100, 1)->minimum, 5);
    assert_null(ect_od_detail(&od, 0x4100, 2));
    drop(&m);
}

/* Mappings and assignments whose number of entries is unknown leave those of the image. */
static void without_a_number_of_entries_the_image_counts(void **state)
{
    static const struct {
        const char *title;
        uint16_t index;
        uint8_t subindex; /* of the only entry, which has no value */
    } rows[] = {
        {"mapping without entry 0", 0x1600, 1},
        {"mapping without the value of entry 0", 0x1600, 0},
        {"assignment without entry 0", 0x1C12, 1},
        {"assignment without the value of entry 0", 0x1C12, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_esi_found_object_t found = {.index = rows[i].index, .name = ""};
        const ect_esi_found_entry_t unknown = {.subindex = rows[i].subindex, .name = ""};
        ect_esi_t *esi = open_image();
        ect_esi_found_object(esi, &found);
        ect_esi_found_entry(esi, &unknown);
        made_t m = finish(esi);
        const unsigned int expected = ect_device_bytes(ect_catalogue_find("fzm1")->device, ECT_SM_OUTPUTS);
        if (ect_device_bytes(m.device, ECT_SM_OUTPUTS) != expected)
            fail_msg("%s: expected %u bytes of outputs, got %u", rows[i].title, expected,
                     ect_device_bytes(m.device, ECT_SM_OUTPUTS));
        drop(&m);
    }
}

/* A mapped entry has the name and type of the image, or else of the dictionary if the lengths are equal. */
static void mapped_entries_are_described(void **state)
{
    static const struct {
        const char *title;
        uint32_t mapped;
        const char *name, *type;
    } rows[] = {
        {"as in the dictionary", 0x41000110, "Entry 1", "INT"},
        {"another length than in the dictionary", 0x41000108, "Entry 1", ""},
        {"no entry of the dictionary", 0x41000210, "", ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esi_t *esi = open_image();
        mapping(esi, 0x1600, rows[i].mapped, 0x21000220);
        object(esi, 0x4100, ECT_OBJECT_RECORD, "Record");
        entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 1);
        entry(esi, 1, ECT_TYPE_INTEGER16, 16, ECT_ACCESS_RW | ECT_ACCESS_RXPDO, 0);
        object(esi, 0x2100, ECT_OBJECT_RECORD, "Command");
        entry(esi, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, 2);
        entry(esi, 2, ECT_TYPE_INTEGER32, 32, ECT_ACCESS_RW | ECT_ACCESS_RXPDO, 0);
        made_t m = finish(esi);
        const ect_esi_entry_t *entries = pdo_at(&m, 0x1600)->entries;
        if (strcmp(entries[0].name, rows[i].name) != 0 || strcmp(entries[0].type, rows[i].type) != 0)
            fail_msg("%s: expected \"%s\" of type \"%s\", got \"%s\", \"%s\"", rows[i].title, rows[i].name,
                     rows[i].type, entries[0].name, entries[0].type);
        assert_string_not_equal(entries[1].name, "Entry 2"); /* the image has one */
        assert_string_equal(entries[1].type, "DINT");
        drop(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entries_keep_type_rights_and_value),
        cmocka_unit_test(object_codes_stay),
        cmocka_unit_test(elements_that_differ_make_a_record),
        cmocka_unit_test(limits_and_units_stay),
        cmocka_unit_test(a_mapping_keeps_what_the_image_knows),
        cmocka_unit_test(mappings_and_assignments_replace_those_of_the_image),
        cmocka_unit_test(the_objects_of_assignments),
        cmocka_unit_test(elements_without_a_value),
        cmocka_unit_test(many_mappings_stay_in_order),
        cmocka_unit_test(CLN_015_a_mapping_and_an_assignment_keep_the_right_of_a_master_to_write_them),
        cmocka_unit_test(CLN_015_names_of_values_and_of_the_identity_stay),
        cmocka_unit_test(without_an_assignment_the_image_counts),
        cmocka_unit_test(an_object_without_description_has_only_its_pdos),
        cmocka_unit_test(shapes_that_do_not_fit_their_code),
        cmocka_unit_test(texts_without_a_length),
        cmocka_unit_test(elements_described_in_different_ways_make_a_record),
        cmocka_unit_test(without_a_number_of_entries_the_image_counts),
        cmocka_unit_test(mapped_entries_are_described),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
