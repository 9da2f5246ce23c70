/* SPDX-License-Identifier: MIT */
/* Device files with slots and modules: the running twin, its ESI file, and the line that refuses a file. */
#define _GNU_SOURCE
#include "devfile_made.h"

#include <stdio.h>
#include <stdlib.h>

#include "bus/chain/chain.h"
#include "esi/modules.h"
#include "esi/write.h"
#include "support/wire.h"
#include "wire/bytes.h"

enum { PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP, TEXT = 500 };

#define DEVICE(lines)                                                                                                  \
    "ectwin-device: 1\nvendor: {id: 0xE57, name: Works}\nproduct: 0x101\nrevision: 7\ntype: G-1\n" lines /* 6 */
#define MODULES(lines) DEVICE("slots:\n  - {name: IO, count: 2}\nmodules:\n" lines)                      /* 9 */
#define SLOTS(lines)   DEVICE("modules:\n  0x110: {name: A}\n  0x120: {name: B}\nslots:\n" lines)        /* 10 */
#define OBJECT(index)  "objects: {" index ": {name: X, type: UINT}}"

/* A slot with a supply, and two that take inputs of 16 bits or an output of 32 bits. */
#define RACK                                                                                                           \
    DEVICE(                                                                                                            \
        "objects:\n  0xF100: {name: State, type: UINT}\n"                                                              \
        "inputs: [{pdo: 0x1AFF, name: Rack, entries: [0xF100]}]\n"                                                     \
        "slots:\n  - {name: Power, modules: [0x110], default: 0x110, min: 1}\n"                                        \
        "  - {count: 2, modules: [0x120, 0x130]}\n"                                                                    \
        "modules:\n"                                                                                                   \
        "  0x110: {name: Supply, type: PS}\n"                                                                          \
        "  0x120:\n    name: Inputs\n    profile: 0x00050191\n    " OBJECT(                                            \
            "0x6000") "\n    inputs: [0x6000]\n"                                                                       \
                      "  0x130:\n    name: Output\n    objects:\n      0x7000: {name: Y, type: UDINT}\n"               \
                      "      0x8000: {name: Filter, type: UINT, min: 1, max: 9, default: 5, access: rw}\n"             \
                      "    outputs:\n      - {entries: [0x7000]}\n"                                                    \
                      "      - {pdo: 0x1610, name: Other, entries: [0x7000], assigned: false, exclude: [0x1600]}\n")

static const ect_module_choice_t choices[] = {{.slot = 1, .ident = 0x130}, {.slot = 2, .ident = 0x120}};

/* --- the model ---------------------------------------------------------------------------------------------------- */

static void slots_and_modules_are_those_of_the_file(void **state)
{
    (void)state;
    made_t m = whole("rack", made_of("g.yaml", RACK));
    assert_int_equal(ect_esi_places(m.model), 3);
    assert_int_equal(m.model->profile, 5001);
    assert_true(m.model->download_idents);
    assert_int_equal(ect_esi_preset(m.model, 0), 0x110);
    assert_int_equal(ect_esi_preset(m.model, 1), 0);
    assert_true(ect_esi_place_takes(m.model, 1, 0x120) && ect_esi_place_takes(m.model, 2, 0x130));
    assert_false(ect_esi_place_takes(m.model, 0, 0x120) || ect_esi_place_takes(m.model, 1, 0x110));
    assert_string_equal(ect_esi_module(m.model, 0x110)->type, "PS");
    assert_string_equal(ect_esi_module(m.model, 0x120)->type, "Inputs");
    assert_int_equal(ect_esi_module(m.model, 0x120)->profile, 0x00050191);
    assert_string_equal(ect_esi_slot_at(m.model, 2, NULL)->name, "Slot 2");
    drop(&m);
}

static void the_standard_layout_has_room_for_the_longest_modules(void **state)
{
    (void)state;
    made_t m = whole("rack", made_of("g.yaml", RACK));
    assert_int_equal(m.model->sms[2].start, 0x1100);
    assert_int_equal(m.model->sms[3].start, 0x1180); /* behind 3 buffers of 16 bytes: both PDOs of 2 modules */
    drop(&m);
    m = whole("wide",
              made_of("g.yaml", MODULES("  1:\n    name: W\n    objects: {0x7000: {name: Y, type: ULINT, array: 9}}\n"
                                        "    outputs: [0x7000]\n")));
    assert_int_equal(m.model->sms[3].start, 0x1300); /* behind 3 buffers of 144 bytes */
    drop(&m);
}

static void keys_of_a_rack_have_defaults(void **state)
{
    static const struct {
        const char *lines;
        uint32_t profile, objects, pdos;
        bool download;
    } rows[] = {
        {"", 5001, 0x10, 1, true},
        {"profile: 0x00011389\n", 0x00011389, 0x10, 1, true},
        {"slot-increments: {objects: 0x100, pdos: 4}\n", 5001, 0x100, 4, true},
        {"download-idents: false\nslot-increments: {pdos: 0}\n", 5001, 0x10, 0, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char yaml[TEXT];
        (void)snprintf(yaml, sizeof yaml, "%s%s", MODULES("  1: {name: A}\n"), rows[i].lines);
        made_t m = whole(rows[i].lines, made_of("g.yaml", yaml));
        assert_int_equal(m.model->profile, rows[i].profile);
        assert_int_equal(m.model->slot_index_increment, rows[i].objects);
        assert_int_equal(m.model->slot_pdo_increment, rows[i].pdos);
        assert_int_equal(m.model->download_idents, rows[i].download);
        assert_int_equal(entry_of(&m, 0xF030, 1) != NULL, rows[i].download); /* MDP-017 */
        drop(&m);
    }
}

/* --- the running twin --------------------------------------------------------------------------------------------- */

typedef struct rig {
    made_t made;
    wire_t wire;
} rig_t;

static void open_rig(rig_t *r, const char *yaml)
{
    memset(r, 0, sizeof *r);
    r->made = whole("rack", made_of("g.yaml", yaml));
    const ect_product_t *product = ect_esi_twin_product(r->made.twin);
    const ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    wire_open_twins(&r->wire, &config, 1);
    wire_go(&r->wire, 0, PREOP);
}

static void close_rig(rig_t *r)
{
    wire_close(&r->wire);
    drop(&r->made);
}

static uint32_t read_number(rig_t *r, uint16_t index, uint8_t subindex)
{
    uint8_t bytes[8] = {0};
    size_t size = sizeof bytes;
    assert_int_equal(wire_sdo_upload(&r->wire, 0, index, subindex, false, bytes, &size), 0);
    return ect_load_le32(bytes);
}

static uint32_t write_number(rig_t *r, uint16_t index, uint8_t subindex, uint32_t value, uint32_t size)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    return wire_sdo_download(&r->wire, 0, index, subindex, false, bytes, size);
}

static void idents_that_a_master_downloads_move_objects_and_PDOs_with_their_slots(void **state)
{
    rig_t r;
    uint16_t code;
    (void)state;
    open_rig(&r, RACK);
    assert_int_equal(read_number(&r, 0xF000, 1), 0x10);
    assert_int_equal(read_number(&r, 0xF000, 2), 3);
    assert_int_equal(read_number(&r, 0xF050, 1), 0x110);
    assert_int_equal(write_number(&r, 0xF030, 1, 0x110, 4), 0);
    assert_int_equal(write_number(&r, 0xF030, 2, 0x130, 4), 0);
    assert_int_equal(write_number(&r, 0xF030, 3, 0x120, 4), 0);
    assert_int_equal(read_number(&r, 0x1C12, 1) & 0xFFFF, 0x1601);
    assert_int_equal(read_number(&r, 0x1601, 1), 0x70100020);
    assert_int_equal(read_number(&r, 0x1A02, 1), 0x60200010);
    assert_int_equal(read_number(&r, 0x8010, 0) & 0xFFFF, 5);
    assert_int_equal(write_number(&r, 0x8010, 0, 10, 2), 0x06090031);
    (void)read_number(&r, 0x1C12, 0);
    wire_configure_process_data(&r.wire, 0);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), PREOP | 0x10); /* MDP-007 */
    assert_int_equal(code, 0x0070);
    close_rig(&r);
}

static void MDP_005_an_ident_that_a_slot_does_not_take_is_refused(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK);
    assert_int_equal(write_number(&r, 0xF030, 2, 0x110, 4), 0x06090030);
    assert_int_equal(write_number(&r, 0xF030, 2, 0x999, 4), 0x06090030);
    assert_int_equal(read_number(&r, 0xF030, 2), 0);
    close_rig(&r);
}

static void a_device_with_modules_goes_to_OP(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, RACK);
    (void)read_number(&r, 0x1C12, 0);
    wire_configure_process_data(&r.wire, 0);
    wire_go(&r.wire, 0, SAFEOP);
    wire_go(&r.wire, 0, OP);
    close_rig(&r);
}

/* --- the ESI file ------------------------------------------------------------------------------------------------- */

static const char *esi_of(ect_arena_t *arena, const ect_esi_twin_t *twin, size_t *length)
{
    char why[TEXT] = "";
    const ect_product_t *product = ect_esi_twin_product(twin);
    const ect_esi_part_t part = {.device = product->device, .plant = product->plant, .twin = twin};
    const char *xml = ect_esi_write(arena, &part, 1, length, why, sizeof why);
    if (xml == NULL)
        fail_msg("%s", why);
    return xml;
}

/* The modules of the file are those of the device in any slots: both devices are the same with each set. */
static void the_ESI_file_has_the_same_slots_and_modules(void **state)
{
    char why[TEXT] = "";
    size_t length = 0, other = 0;
    ect_arena_t arena = {0};
    (void)state;
    made_t m = whole("rack", made_of("g.yaml", RACK));
    const char *xml = esi_of(&arena, m.twin, &length);
    made_t n = {.esi = ect_esi_parse("t.xml", xml, length, why, sizeof why)};
    assert_non_null(n.esi);
    n.model = ect_esi_select(n.esi, "", why, sizeof why);
    n.twin = n.model != NULL ? ect_esi_twin_of(n.esi, n.model, NULL, 0, why, sizeof why) : NULL;
    n = whole("its ESI", n);
    assert_string_equal(esi_of(&arena, n.twin, &other), xml);
    ect_esi_twin_t *of_yaml = ect_esi_twin_of(m.esi, m.model, choices, 2, why, sizeof why);
    ect_esi_twin_t *of_esi = ect_esi_twin_of(n.esi, n.model, choices, 2, why, sizeof why);
    assert_true(of_yaml != NULL && of_esi != NULL);
    assert_non_null(strstr(esi_of(&arena, of_yaml, &length), "#x8010"));
    assert_string_equal(esi_of(&arena, of_yaml, &length), esi_of(&arena, of_esi, &other));
    ect_esi_twin_free(of_yaml);
    ect_esi_twin_free(of_esi);
    ect_arena_free(&arena);
    drop(&n);
    drop(&m);
}

/* --- refusals ----------------------------------------------------------------------------------------------------- */

#define P(line, why) "g.yaml:" #line ": " why

static void a_wrong_rack_is_refused_with_its_line_and_a_cure(void **state)
{
    static const struct {
        const char *yaml, *why; /* the beginning of it */
    } rows[] = {
        {DEVICE("slots: [{count: 1}]\n"), P(6, "a device with modules takes both 'slots' and 'modules'")},
        {DEVICE("modules: {1: {name: A}}\n"), P(6, "a device with modules takes both 'slots' and 'modules'")},
        {DEVICE("download-idents: true\n"), P(6, "a device with modules takes both 'slots' and 'modules'")},
        {DEVICE("slot-increments: {pdos: 1}\n"), P(6, "a device with modules takes both 'slots' and 'modules'")},
        {DEVICE("mailbox: none\nslots: [{count: 1}]\nmodules: {1: {name: A}}\n"),
         P(7, "a device with slots needs a mailbox with coe: change 'mailbox'")},
        {DEVICE("objects: {0xF030: {name: L, type: UINT}}\nslots: [{count: 1}]\nmodules: {1: {name: A}}\n"),
         P(6, "object F030 is left out here: the key 'slots' makes it")},
        {MODULES("  a: {name: A}\n"), P(9, "'modules' takes a number from 1 to 4294967295, not 'a'")},
        {MODULES("  0: {name: A}\n"), P(9, "'modules' takes a number from 1 to 4294967295, not '0'")},
        {MODULES("  1: {name: A}\n  0x1: {name: A}\n"),
         P(10, "module 0x00000001 occurs twice, first in line 9: give one another ident")},
        {MODULES("  1: {name: A}\n  1: {name: B}\n"),
         P(10, "module 0x00000001 occurs twice, first in line 9: give one another ident")},
        {MODULES("  1: {name: A, name: B}\n"), P(9, "'name' occurs twice")},
        {MODULES("  1: {name: A}\nslot-increments: {pdos: 1, pdos: 1}\n"), P(10, "'pdos' occurs twice")},
        {SLOTS("  - {count: 1, count: 1}\n"), P(10, "'count' occurs twice")},
        {MODULES("  1: {type: A}\n"), P(9, "module 1 has no 'name'")},
        {MODULES("  1: {name: ''}\n"), P(9, "'name' is empty")},
        {MODULES("  1: {name: A, slot: 1}\n"),
         P(9, "'slot' is no key of a module: name, type, profile, objects, inpu")},
        {MODULES("  1: {name: A, profile: x}\n"), P(9, "'profile' takes a number from 0 to 4294967295, not 'x'")},
        {MODULES("  1: [A]\n"), P(9, "a module: 'key: value' lines are missing")},
        {DEVICE("modules: 5\nslots: [{count: 1}]\n"), P(6, "modules: 'key: value' lines are missing")},
        {MODULES("  1: {name: A, inputs: [0x6000]}\n"), P(9, "there is no 0x6000 among the 'objects': add it")},
        {MODULES("  1: {name: A, objects: {0x6000: {name: X, type: UINT, bits: {0: B}}}}\n"),
         P(9, "'bits' is for objects of the device: leave it out of a module")},
        {MODULES("  1: {name: A, objects: {0x6000: {name: X, type: UINT, values: {0: B, 1: C}}}}\n"),
         P(9, "'values' is for objects of the device: leave it out of a module")},
        {MODULES("  1: {name: A}\nslot-increments: {slots: 1}\n"),
         P(10, "'slots' is no key of 'slot-increments': obj")},
        {MODULES("  1: {name: A}\nslot-increments: {pdos: -1}\n"), P(10, "'pdos' takes a number from 0 to 65535")},
        {MODULES("  1: {name: A}\ndownload-idents: 1\n"), P(10, "'download-idents' takes true or false, not '1'")},
        {SLOTS("  5\n"), P(10, "'slots' takes a list of 1 to 254, '- {name: IO, count: 4}' each")},
        {SLOTS("  []\n"), P(10, "'slots' takes a list of 1 to 254")},
        {SLOTS("  - {colour: 1}\n"), P(10, "'colour' is no key of a slot: name, modules, count, min, default")},
        {SLOTS("  - {count: 0}\n"), P(10, "'count' takes a number from 1 to 254, not '0'")},
        {SLOTS("  - {count: 200}\n  - {count: 55}\n"), P(10, "the slots have 255 places: a device has at most 254")},
        {SLOTS("  - {modules: 0x110}\n"), P(10, "'modules' of a slot takes a list of idents, as [0x00000110")},
        {SLOTS("  - {modules: []}\n"), P(10, "'modules' of a slot takes a list of idents")},
        {SLOTS("  - {modules: [0x130]}\n"), P(10, "there is no module 0x00000130 among the 'modules': add it")},
        {SLOTS("  - {modules: [x]}\n"), P(10, "'modules' takes a number from 1 to 4294967295, not 'x'")},
        {SLOTS("  - {default: 0x130}\n"), P(10, "there is no module 0x00000130 among the 'modules'")},
        {SLOTS("  - {modules: [0x110], default: 0x120}\n"),
         P(10, "the slot does not accept its 'default' 0x00000120: add it to 'modules'")},
        {SLOTS("  - {min: 2}\n"), P(10, "'min' 2 is more than the 'count' 1 of the slot")},
        {SLOTS("  - {count: 2, min: 1}\n"),
         P(10, "a slot with 'min' needs the module of these places: 'default: 0x00000110'")}, /* MDP-015 */
        {SLOTS("  - {modules: [0x110]}\n"),
         P(8, "no slot accepts module 0x00000120: add it to the 'modules' of a slot")},
        {DEVICE(
             "objects: {0x6010: {name: D, type: UINT}}\nslots: [{count: 2}]\nmodules:\n  1:\n    name: A\n    " OBJECT(
                 "0x6000") "\n"),
         P(11, "6000 is 6010 in slot 2, as one of the device: choose another, or change 'slot-increments'")},
        {MODULES("  1:\n    name: A\n    objects:\n      0x6000: {name: X, type: UINT}\n      0x6010: {name: Y, type: "
                 "UINT}\n"),
         P(12, "6000 is 6010 in slot 2, as one of slot 1: choose another, or change 'slot-increments'")},
        {DEVICE("slots: [{modules: [1]}, {modules: [2]}]\nmodules:\n  1: {name: A, " OBJECT(
             "0x6010") "}\n  2: {name: B, " OBJECT("0x6000") "}\n"),
         P(9, "6000 is 6010 in slot 2, as one of slot 1: choose another, or change 'slot-increments'")},
        {MODULES("  1:\n    name: A\n    " OBJECT("0x6000") "\nslot-increments: {objects: 0}\n"),
         P(11, "6000 is 6000 in slot 2, as one of slot 1: choose another")},
        {MODULES("  1:\n    name: A\n    " OBJECT("0xFFF0") "\n"),
         P(11, "FFF0 is 10000 in slot 2, which no module may have: choose another, or change 'slot-increments'")},
        {MODULES("  1:\n    name: A\n    " OBJECT("0xF040") "\n"),
         P(11, "F040 is F040 in slot 1, which no module may")},
        {MODULES("  1:\n    name: A\n    " OBJECT("0x15F8") "\n"),
         P(11, "15F8 is 1608 in slot 2, which no module may")},
        {MODULES("  1: {name: A, inputs: [{entries: [gap 8]}, {entries: [gap 8]}]}\n"),
         P(9, "1A00 is 1A01 in slot 2, as one of slot 1: choose another, or change 'slot-increments'")},
        {MODULES("  1: {name: A, outputs: [{pdo: 0x17FF, entries: [gap 8]}]}\n"),
         P(9, "17FF is 1800 in slot 2, which no module may have")},
        {MODULES("  1: {name: A, outputs: [gap 8]}\nslot-increments: {pdos: 0x400}\n"),
         P(9, "1600 is 1A00 in slot 2, which no module may have")},
        {DEVICE("inputs: [gap 8]\nslots: [{count: 1}]\nmodules:\n  1: {name: A, inputs: [gap 8]}\n"),
         P(9, "1A00 is 1A00 in slot 1, as one of the device: choose another")},
        {MODULES("  1: {name: A, inputs: [gap 8]}\nsyncmanagers: [{type: mailbox-out, start: 0x1000, size: 64}, "
                 "{type: mailbox-in, start: 0x1080, size: 64}]\n"),
         P(9, "no SyncManager has the inputs: add one to 'syncmanagers'")},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = made_of("g.yaml", rows[i].yaml);
        if (m.esi != NULL || strncmp(m.why, rows[i].why, strlen(rows[i].why)) != 0)
            fail_msg("row %zu:\n%s\nexpected \"%s\", got \"%s\"", i, rows[i].yaml, rows[i].why, m.why);
        drop(&m);
    }
}

static void more_than_256_modules_are_refused(void **state)
{
    enum { MODULES = 257, LINE = 24 };
    (void)state;
    char *yaml = malloc(TEXT + LINE * MODULES);
    assert_non_null(yaml);
    char *at = yaml + sprintf(yaml, "%s", MODULES(""));
    for (unsigned int i = 1; i <= MODULES; i++)
        at += sprintf(at, "  %u: {name: A}\n", i);
    made_t m = made_of("g.yaml", yaml);
    assert_null(m.esi);
    assert_string_equal(m.why, "g.yaml:265: more than 256 modules");
    free(yaml);
    drop(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slots_and_modules_are_those_of_the_file),
        cmocka_unit_test(the_standard_layout_has_room_for_the_longest_modules),
        cmocka_unit_test(keys_of_a_rack_have_defaults),
        cmocka_unit_test(idents_that_a_master_downloads_move_objects_and_PDOs_with_their_slots),
        cmocka_unit_test(MDP_005_an_ident_that_a_slot_does_not_take_is_refused),
        cmocka_unit_test(a_device_with_modules_goes_to_OP),
        cmocka_unit_test(the_ESI_file_has_the_same_slots_and_modules),
        cmocka_unit_test(a_wrong_rack_is_refused_with_its_line_and_a_cure),
        cmocka_unit_test(more_than_256_modules_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
