/* SPDX-License-Identifier: MIT */
/*
 * The bounds of descriptions: each value at a bound is accepted, and the next one refused. The rows of test_check.c
 * have a mistake each; these have a neighbour without one.
 */
#include <stdlib.h>
#include <string.h>

#include "check/check.h"
#include "support/confdev.h"
#include "support/copy.h"
#include "support/every.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { NAME_MOST = 40, TEXT_MOST = 255 };

static bool is_good(copy_t *c, char text[ECT_CHECK_TEXT])
{
    return ect_device_check(&c->device, text, ECT_CHECK_TEXT);
}

/* Frees the copy. */
static void expect_good(const char *what, unsigned int which, copy_t *c)
{
    char text[ECT_CHECK_TEXT];
    if (!is_good(c, text))
        fail_msg("%s %u: %s", what, which, text);
    copy_free(c);
}

static void expect_wrong(const char *what, unsigned int which, const char *part, copy_t *c)
{
    char text[ECT_CHECK_TEXT];
    if (is_good(c, text) || strstr(text, part) == NULL)
        fail_msg("%s %u: expected '...%s...', got '%s'", what, which, part, text);
    copy_free(c);
}

/* --- texts -------------------------------------------------------------------------------------------------------- */

/* The texts of a description with their longest lengths. */
static const struct text_member {
    const char *name;
    size_t offset, most;
    bool needed;
} members[] = {
    {"name", offsetof(ect_device_t, name), NAME_MOST, true},
    {"summary", offsetof(ect_device_t, summary), TEXT_MOST, true},
    {"vendor_name", offsetof(ect_device_t, vendor_name), TEXT_MOST, true},
    {"type_name", offsetof(ect_device_t, type_name), NAME_MOST, true},
    {"full_name", offsetof(ect_device_t, full_name), TEXT_MOST, false},
    {"group_type", offsetof(ect_device_t, group_type), TEXT_MOST, true},
    {"group_name", offsetof(ect_device_t, group_name), TEXT_MOST, true},
    {"hardware_version", offsetof(ect_device_t, hardware_version), NAME_MOST, false},
    {"software_version", offsetof(ect_device_t, software_version), NAME_MOST, false},
};
enum { MEMBERS = sizeof members / sizeof members[0] };

static copy_t *with_text(const struct text_member *m, const char *text)
{
    copy_t *c = copy_device(&testdev);
    memcpy((char *)&c->device + m->offset, &text, sizeof text);
    return c;
}

static void texts_have_one_to_their_most_characters(void **state)
{
    (void)state;
    for (unsigned int i = 0; i < MEMBERS; i++) {
        char text[TEXT_MOST + 2];
        memset(text, 'a', sizeof text);
        text[members[i].most + 1] = '\0';
        expect_wrong(members[i].name, 0, "is longer than", with_text(&members[i], text));
        text[members[i].most] = '\0';
        expect_good(members[i].name, 1, with_text(&members[i], text));
        text[1] = '\0';
        expect_good(members[i].name, 2, with_text(&members[i], text));
        text[0] = '\0';
        expect_wrong(members[i].name, 3, "is missing", with_text(&members[i], text));
    }
}

static void texts_have_visible_characters(void **state)
{
    (void)state;
    for (unsigned int i = 1; i < MEMBERS; i++) { /* the name has a rule of its own */
        for (unsigned int letter = 1; letter < 256; letter++) {
            const char text[] = {'a', (char)letter, '\0'};
            if (letter >= ' ' && letter <= '~')
                expect_good(members[i].name, letter, with_text(&members[i], text));
            else
                expect_wrong(members[i].name, letter, "which is not a visible one", with_text(&members[i], text));
        }
    }
}

static void names_have_lower_case_digits_and_hyphens(void **state)
{
    (void)state;
    for (unsigned int letter = ' '; letter <= '~'; letter++) {
        const char text[] = {'a', (char)letter, '\0'};
        const bool good = (letter >= 'a' && letter <= 'z') || (letter >= '0' && letter <= '9') || letter == '-';
        if (good)
            expect_good("name", letter, with_text(&members[0], text));
        else
            expect_wrong("name", letter, "contains a character other than lower case", with_text(&members[0], text));
    }
}

static void needed_texts_are_there_and_others_may_be_missing(void **state)
{
    (void)state;
    for (unsigned int i = 0; i < MEMBERS; i++) {
        if (members[i].needed)
            expect_wrong(members[i].name, 0, "is missing", with_text(&members[i], NULL));
        else
            expect_good(members[i].name, 0, with_text(&members[i], NULL));
    }
}

static void physics_has_up_to_four_known_letters(void **state)
{
    static const char *const good[] = {"", "Y", "K", "H", " ", "YK", "Y  K", "YKHY", "YYYY"};
    static const char *const bad[] = {"YYYYY", "y", "X", "Y-", "YKX", "1"};
    (void)state;
    for (unsigned int i = 0; i < sizeof good / sizeof good[0]; i++) {
        copy_t *c = copy_device(&testdev);
        c->device.physics = good[i];
        expect_good("physics", i, c);
    }
    for (unsigned int i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        copy_t *c = copy_device(&testdev);
        c->device.physics = bad[i];
        expect_wrong("physics", i, "physics: one letter for each port", c);
    }
}

/* --- types -------------------------------------------------------------------------------------------------------- */

/* Bits of a data type; 0: it is none, or of any length. */
static unsigned int bits_of(unsigned int type)
{
    static const struct {
        uint16_t type, bits;
    } types[] = {{ECT_TYPE_BOOLEAN, 1},     {ECT_TYPE_INTEGER8, 8},    {ECT_TYPE_INTEGER16, 16},
                 {ECT_TYPE_INTEGER32, 32},  {ECT_TYPE_INTEGER64, 64},  {ECT_TYPE_UNSIGNED8, 8},
                 {ECT_TYPE_UNSIGNED16, 16}, {ECT_TYPE_UNSIGNED32, 32}, {ECT_TYPE_UNSIGNED64, 64},
                 {ECT_TYPE_REAL32, 32},     {ECT_TYPE_REAL64, 64},     {ECT_TYPE_BITARR8, 8},
                 {ECT_TYPE_BITARR16, 16},   {ECT_TYPE_BITARR32, 32}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (types[i].type == type)
            return types[i].bits;
    }
    return type >= ECT_TYPE_BIT1 && type <= ECT_TYPE_BIT8 ? type - ECT_TYPE_BIT1 + 1 : 0;
}

static copy_t *of_type(unsigned int type, unsigned int bits)
{
    copy_t *c = copy_device(&testdev);
    ect_entry_t *e = copy_entry(c, 0x2009, 0); /* 64 bits in memory */
    e->data_type = (uint16_t)type;
    e->bit_length = (uint16_t)bits;
    e->value = 0;
    return c;
}

static void each_data_type_has_its_length(void **state)
{
    (void)state;
    for (unsigned int type = 1; type < 0x50; type++) {
        const unsigned int bits = bits_of(type);
        const bool any = type == ECT_TYPE_VISIBLE_STRING || type == ECT_TYPE_OCTET_STRING;
        for (unsigned int length = 1; length <= 64; length++) {
            copy_t *c = of_type(type, length);
            if (any ? length % 8 == 0 : length == bits)
                expect_good("type", type * 100 + length, c);
            else
                expect_wrong("type", type * 100 + length,
                             any         ? "bits are not whole bytes"
                             : bits == 0 ? "is none that an entry can have"
                                         : "bits, not",
                             c);
        }
    }
}

static void limits_end_with_the_type(void **state)
{
    static const struct {
        uint16_t type;
        int64_t lowest, highest;
    } ranges[] = {{ECT_TYPE_INTEGER8, INT8_MIN, INT8_MAX},
                  {ECT_TYPE_INTEGER16, INT16_MIN, INT16_MAX},
                  {ECT_TYPE_INTEGER32, INT32_MIN, INT32_MAX},
                  {ECT_TYPE_UNSIGNED8, 0, UINT8_MAX},
                  {ECT_TYPE_UNSIGNED16, 0, UINT16_MAX},
                  {ECT_TYPE_UNSIGNED32, 0, UINT32_MAX},
                  {ECT_TYPE_BOOLEAN, 0, 1},
                  {ECT_TYPE_BIT1 + 2, 0, 7},
                  {ECT_TYPE_INTEGER64, INT64_MIN, INT64_MAX},
                  {ECT_TYPE_UNSIGNED64, 0, INT64_MAX}};
    (void)state;
    for (unsigned int i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        for (unsigned int which = 0; which < 3; which++) {
            copy_t *c = of_type(ranges[i].type, bits_of(ranges[i].type));
            c->details[0].index = 0x2009;
            c->details[0].minimum = ranges[i].lowest;
            c->details[0].maximum = ranges[i].highest;
            const bool below = which == 1 && ranges[i].lowest > INT64_MIN;
            const bool above = which == 2 && ranges[i].highest < INT64_MAX;
            c->details[0].minimum -= below;
            c->details[0].maximum += above;
            if (below || above)
                expect_wrong("limits", 10 * i + which, "are beyond its type", c);
            else
                expect_good("limits", 10 * i + which, c);
        }
    }
}

static void defaults_lie_from_the_minimum_to_the_maximum(void **state)
{
    (void)state;
    for (int value = -102; value <= 202; value++) {
        copy_t *c = copy_device(&testdev);
        copy_entry(c, 0x2005, 0)->value = (uint32_t)value;
        if (value < -100)
            expect_wrong("default", 0, "is below its minimum -100", c);
        else if (value > 200)
            expect_wrong("default", 1, "is above its maximum 200", c);
        else
            expect_good("default", 2, c);
    }
}

static void an_entry_ends_with_the_instance(void **state)
{
    (void)state;
    for (unsigned int bytes = 1; bytes <= 8; bytes *= 2) {
        static const uint16_t types[] = {0, ECT_TYPE_UNSIGNED8, ECT_TYPE_UNSIGNED16, 0, ECT_TYPE_UNSIGNED32, 0, 0,
                                         0, ECT_TYPE_UNSIGNED64};
        copy_t *c = of_type(types[bytes], 8 * bytes);
        copy_entry(c, 0x2009, 0)->data = (void *)(uintptr_t)(sizeof(testdev_t) - bytes);
        expect_good("last byte", bytes, c);
        c = of_type(types[bytes], 8 * bytes);
        copy_entry(c, 0x2009, 0)->data = (void *)(uintptr_t)(sizeof(testdev_t) - bytes + 1);
        expect_wrong("behind the last byte", bytes, "beyond the instance", c);
        c = of_type(types[bytes], 8 * bytes);
        copy_entry(c, 0x2009, 0)->data = (void *)(uintptr_t)sizeof(ect_standard_t);
        expect_good("first byte", bytes, c);
        c = of_type(types[bytes], 8 * bytes);
        copy_entry(c, 0x2009, 0)->data = (void *)(uintptr_t)(sizeof(ect_standard_t) - 1);
        expect_wrong("before the first byte", bytes, "belongs to the stack", c);
    }
}

/* --- SyncManagers ------------------------------------------------------------------------------------------------- */

static copy_t *with_mailbox(uint16_t start, uint16_t length)
{
    copy_t *c = copy_device(&testdev);
    c->device.sm[0].start = start;
    c->device.sm[0].length = length;
    return c;
}

static void mailboxes_have_their_shortest_to_longest_length(void **state)
{
    (void)state;
    expect_wrong("mailbox", 33, "a mailbox has 34 to 1486 bytes", with_mailbox(0x1400, 33));
    expect_good("mailbox", 34, with_mailbox(0x1400, 34));
    expect_good("mailbox", 1486, with_mailbox(0x1400, 1486));
    expect_wrong("mailbox", 1487, "a mailbox has 34 to 1486 bytes", with_mailbox(0x1400, 1487));
}

static void memory_is_that_of_the_chip(void **state)
{
    (void)state;
    expect_wrong("start", 0, "are not in the memory", with_mailbox(0x0FFF, 64));
    expect_good("end", 1, with_mailbox(0x3000 - 64, 64)); /* ET1100: 8 KB from 1000h */
    expect_wrong("end", 2, "are not in the memory", with_mailbox(0x3000 - 63, 64));
}

/* SM1 lies at 1080h with up to 256 bytes, SM2 at 1200h with three buffers of 3. */
static void neighbours_may_touch_and_not_overlap(void **state)
{
    (void)state;
    expect_good("before SM1", 0, with_mailbox(0x1040, 64));
    expect_wrong("into SM1", 1, "it overlaps SM0", with_mailbox(0x1041, 64));
    expect_good("behind SM1", 2, with_mailbox(0x1180, 64));
    expect_wrong("end of SM1", 3, "it overlaps SM0", with_mailbox(0x117F, 64));
    expect_good("behind SM2", 4, with_mailbox(0x1209, 64));
    expect_wrong("end of SM2", 5, "it overlaps SM0", with_mailbox(0x1208, 64));
}

/* SM3 of a device without 1C00h, which would have its type. */
static void a_virtual_SyncManager_has_a_known_role(void **state)
{
    static const struct {
        uint8_t flags, role;
        const char *mistake; /* NULL: none */
    } rows[] = {
        {ECT_SM_FLAG_VIRTUAL, ECT_SM_UNUSED, NULL},
        {ECT_SM_FLAG_VIRTUAL, ECT_SM_OUTPUTS, NULL},
        {ECT_SM_FLAG_VIRTUAL | ECT_SM_FLAG_OP_ONLY, ECT_SM_INPUTS, NULL},
        {ECT_SM_FLAG_VIRTUAL, ECT_SM_INPUTS + 1, "SM3: there is no role 5"},
        {ECT_SM_FLAG_VIRTUAL, 255, "SM3: there is no role 255"},
        {ECT_SM_FLAG_OP_ONLY, 255, NULL}, /* not read */
    };
    (void)state;
    for (unsigned int i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        copy_t *c = copy_device(&terminal);
        assert_int_equal(c->device.sm_count, 3);
        c->device.sm_count = 4;
        c->device.sm[3] = (ect_sm_t){.start = 0x0990, .length = 8, .flags = rows[i].flags, .role = rows[i].role};
        if (rows[i].mistake != NULL)
            expect_wrong("virtual", i, rows[i].mistake, c);
        else
            expect_good("virtual", i, c);
    }
}

static void every_role_has_its_direction_and_mode(void **state)
{
    (void)state;
    for (unsigned int control = 0; control < 16; control++) {
        for (unsigned int sm = 0; sm < 4; sm++) {
            const bool writes = (control & 0x0C) == 0x04, reads = (control & 0x0C) == 0, out = sm == 0 || sm == 2;
            const unsigned int mode = control & 3;
            copy_t *c = copy_device(&testdev);
            c->device.sm[sm].control = (uint8_t)control;
            if (out ? !writes : !reads)
                expect_wrong("control", 100 * sm + control, "opposite direction", c);
            else if (sm < 2 ? mode != 2 : mode == 1 || mode == 3)
                expect_wrong("control", 100 * sm + control, "has the wrong mode", c);
            else
                expect_good("control", 100 * sm + control, c);
        }
    }
}

static void sync_managers_and_fmmus_are_as_many_as_the_chip_has(void **state)
{
    (void)state;
    for (unsigned int fmmus = 0; fmmus <= ECT_FMMUS; fmmus++) {
        copy_t *c = copy_device(&testdev);
        c->device.fmmu_count = (uint8_t)fmmus;
        for (unsigned int i = 0; i < fmmus; i++)
            c->device.fmmu[i] = ECT_FMMU_OUTPUTS;
        expect_good("FMMUs", fmmus, c);
    }
    for (unsigned int role = 0; role < 256; role++) {
        copy_t *c = copy_device(&testdev);
        c->device.fmmu[0] = (uint8_t)role;
        if (role <= ECT_FMMU_MAILBOX_STATE)
            expect_good("role", role, c);
        else
            expect_wrong("role", role, "there is no role", c);
    }
}

/* Each object as the one before it, and each pair in the other order. */
static void objects_ascend_from_the_first_to_the_last(void **state)
{
    (void)state;
    for (unsigned int i = 1; i < testdev.object_count; i++) {
        const uint16_t before = testdev.objects[i - 1].index, index = testdev.objects[i].index;
        copy_t *c = copy_device(&testdev);
        c->objects[i].index = before;
        expect_wrong("object twice", i, "objects are in ascending order, each once", c);
        c = copy_device(&testdev);
        c->objects[i - 1].index = index;
        c->objects[i].index = before;
        expect_wrong("object order", i, "objects are in ascending order, each once", c);
    }
}

/* --- offers ------------------------------------------------------------------------------------------------------- */

static void the_eeprom_has_a_whole_number_of_128_bytes(void **state)
{
    (void)state;
    for (uint16_t size = 1024; size <= 1024 + 256; size++) {
        copy_t *c = copy_device(&testdev);
        c->device.sii_size = size;
        if (size % 128 == 0)
            expect_good("sii_size", size, c);
        else
            expect_wrong("sii_size", size, "is not a multiple of 128", c);
    }
    for (uint16_t size = 0; size <= 256; size++) {
        copy_t *c = copy_device(&testdev);
        c->device.sii_size = size;
        expect_wrong("sii_size", size,
                     size > 0 && size % 128 == 0 ? "the SII does not fit into" : "is not a multiple of 128", c);
    }
}

static void init_commands_name_their_transitions(void **state)
{
    static const char *const good[] = {"IP", "PS", "SO", "SP", "OP", "OS", "IP PS", "PS SO OS"};
    static const char *const bad[] = {"", "I", "IPS", "IP ", "IP  PS", "PI", "ip", "IP,PS", "XX"};
    static const uint8_t data[] = {1};
    (void)state;
    for (unsigned int i = 0; i < sizeof good / sizeof good[0] + sizeof bad / sizeof bad[0]; i++) {
        const unsigned int goods = sizeof good / sizeof good[0];
        copy_t *c = copy_device(&testdev);
        const ect_init_command_t command = {
            .transitions = i < goods ? good[i] : bad[i - goods], .index = 0x2000, .data = data, .size = 1};
        c->device.init_commands = &command;
        c->device.init_command_count = 1;
        if (i < goods)
            expect_good("transitions", i, c);
        else
            expect_wrong("transitions", i, "names transitions other than", c);
    }
}

static void timeouts_are_needed_for_the_way_up_only(void **state)
{
    (void)state;
    copy_t *c = copy_device(&testdev);
    c->device.timeouts = (ect_timeouts_t){.preop_ms = 1, .safeop_op_ms = 1};
    expect_good("timeouts", 0, c);
    c = copy_device(&testdev);
    c->device.timeouts.preop_ms = 0;
    expect_wrong("timeouts", 1, "preop_ms and safeop_op_ms are needed", c);
    c = copy_device(&testdev);
    c->device.timeouts.safeop_op_ms = 0;
    expect_wrong("timeouts", 2, "preop_ms and safeop_op_ms are needed", c);
}

/* --- PDOs --------------------------------------------------------------------------------------------------------- */

static void mappings_have_up_to_the_bits_of_their_object(void **state)
{
    (void)state;
    for (unsigned int bits = 0; bits <= 20; bits++) {
        copy_t *c = copy_device(&testdev);
        copy_entry(c, 0x1600, 3)->value = 0x70000200u | bits;
        if (bits == 0)
            expect_wrong("bits", bits, "it maps nothing", c);
        else if (bits > 16)
            expect_wrong("bits", bits, "has 16 bits, not", c);
        else
            expect_good("bits", bits, c);
    }
}

static void process_data_fill_their_maximum_and_not_more(void **state)
{
    (void)state;
    for (unsigned int maximum = 1; maximum <= 5; maximum++) {
        copy_t *c = copy_device(&testdev);
        c->device.sm[2].maximum = (uint16_t)maximum; /* 1 + 7 + 16 bits */
        if (maximum < 3)
            expect_wrong("maximum", maximum, "come to 3 bytes, more than its maximum", c);
        else
            expect_good("maximum", maximum, c);
    }
}

static void properties_of_pdos_name_other_pdos(void **state)
{
    (void)state;
    for (unsigned int flags = 0; flags < 0x200; flags++) {
        const bool known = (flags & ~(unsigned int)(ECT_PDO_FIXED | ECT_PDO_MANDATORY | ECT_PDO_VIRTUAL)) == 0;
        copy_t *c = copy_device(&testdev);
        (void)copy_pdo(c, 0x1A00, (uint16_t)flags, 0);
        if (known)
            expect_good("flags", flags, c);
        else
            expect_wrong("flags", flags, "has the unknown property", c);
    }
    copy_t *c = copy_device(&testdev);
    (void)copy_pdo(c, 0x1A00, 0, 0x1600);
    expect_good("exclusion", 0, c);
    c = copy_device(&testdev);
    (void)copy_pdo(c, 0x1A00, 0, 0x1A00);
    expect_wrong("exclusion", 1, "which is no other PDO", c);
    c = copy_device(&testdev);
    (void)copy_pdo(c, 0x1A00, 0, 0x1A01);
    expect_wrong("exclusion", 2, "which is no other PDO", c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_have_one_to_their_most_characters),
        cmocka_unit_test(texts_have_visible_characters),
        cmocka_unit_test(names_have_lower_case_digits_and_hyphens),
        cmocka_unit_test(needed_texts_are_there_and_others_may_be_missing),
        cmocka_unit_test(physics_has_up_to_four_known_letters),
        cmocka_unit_test(each_data_type_has_its_length),
        cmocka_unit_test(limits_end_with_the_type),
        cmocka_unit_test(defaults_lie_from_the_minimum_to_the_maximum),
        cmocka_unit_test(an_entry_ends_with_the_instance),
        cmocka_unit_test(mailboxes_have_their_shortest_to_longest_length),
        cmocka_unit_test(memory_is_that_of_the_chip),
        cmocka_unit_test(neighbours_may_touch_and_not_overlap),
        cmocka_unit_test(a_virtual_SyncManager_has_a_known_role),
        cmocka_unit_test(every_role_has_its_direction_and_mode),
        cmocka_unit_test(sync_managers_and_fmmus_are_as_many_as_the_chip_has),
        cmocka_unit_test(objects_ascend_from_the_first_to_the_last),
        cmocka_unit_test(the_eeprom_has_a_whole_number_of_128_bytes),
        cmocka_unit_test(init_commands_name_their_transitions),
        cmocka_unit_test(timeouts_are_needed_for_the_way_up_only),
        cmocka_unit_test(mappings_have_up_to_the_bits_of_their_object),
        cmocka_unit_test(process_data_fill_their_maximum_and_not_more),
        cmocka_unit_test(properties_of_pdos_name_other_pdos),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
