/* SPDX-License-Identifier: MIT */
/* Names of twins (bus/chain/names.h), and signals by them (ect_chain_resolve). */
#include "bus/chain/names.h"

#include <stdio.h>
#include <string.h>

#include "bus/chain/fault.h"
#include "bus/chain/settings.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { TWINS = 3, MANY = 65535 };

static const ect_signal_t signals[] = {
    ECT_SIGNAL(testdev_t, array[0], "low", U16, WRITE, 0, 1000, NULL, ""),
    ECT_SIGNAL(testdev_t, array[1], "high", U16, WRITE, 0, 1000, NULL, ""),
};
static const ect_signal_t grouped[] = {ECT_SIGNAL(testdev_t, array[2], "on", U16, WRITE, 0, 1000, NULL, "")};
static const ect_signal_group_t groups[] = {{.signal_count = 2, .signals = signals},
                                            {.signal_count = 1, .signals = grouped, .prefix = "unit"}};

/* `low` never becomes 99. */
static const char *refuse_99(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                             uint64_t now_ns)
{
    (void)instance;
    (void)number;
    (void)now_ns;
    return signal == &signals[0] && *(const uint16_t *)value == 99 ? "refused" : NULL;
}

static const ect_plant_t plant = {.signal_groups = groups, .signal_group_count = 2, .signal_write = refuse_99};

static void open_twins(wire_t *w)
{
    ect_twin_config_t twins[TWINS];
    for (size_t i = 0; i < TWINS; i++)
        twins[i] = ect_twin_default(&testdev, &plant);
    wire_open_twins(w, twins, TWINS);
}

static void a_text_begins_with_a_name(void **state)
{
    static const struct {
        const char *text;
        size_t length;
    } rows[] = {
        {"gripper", 7},
        {"gripper.data1", 7},
        {"a=b", 1},
        {"a_1-b:x", 5},
        {"z9", 2},
        {"", 0},
        {"2", 0},
        {"_a", 0},
        {"Gripper", 0},
        {"{", 0},
        {".a", 0},
        {"abcdefghijklmnopqrstuvwxyz01234", 31},
        {"abcdefghijklmnopqrstuvwxyz012345", 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        print_message("%s\n", rows[i].text);
        assert_int_equal(ect_name_begins(rows[i].text), rows[i].length);
    }
}

static void each_name_is_that_of_one_twin(void **state)
{
    ect_names_t *names = ect_names_new(TWINS);
    (void)state;
    assert_non_null(names);
    assert_true(ect_names_add(names, 0, "arm"));
    assert_true(ect_names_add(names, 2, "arm2"));
    assert_false(ect_names_add(names, 1, "arm"));
    assert_int_equal(ect_names_find(names, "arm.x", 3), 1);
    assert_int_equal(ect_names_find(names, "arm2", 4), 3);
    assert_int_equal(ect_names_find(names, "ar", 2), 0);
    assert_int_equal(ect_names_find(names, "", 0), 0);
    assert_int_equal(ect_names_find(NULL, "arm", 3), 0);
    assert_string_equal(ect_names_at(names, 2), "arm2");
    assert_null(ect_names_at(names, 1));
    assert_null(ect_names_at(names, TWINS));
    assert_null(ect_names_at(NULL, 0));
    ect_names_free(names);
}

static void every_twin_of_the_largest_bus_has_a_name(void **state)
{
    ect_names_t *names = ect_names_new(MANY);
    char name[ECT_NAME_ROOM];
    (void)state;
    assert_non_null(names);
    for (size_t i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "t%zu", i);
        assert_true(ect_names_add(names, i, name));
    }
    for (size_t i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "t%zu", i);
        assert_int_equal(ect_names_find(names, name, strlen(name)), i + 1);
    }
    ect_names_free(names);
}

/* "arm" is the second twin, "leg" the third. */
static ect_names_t *name_twins(wire_t *w)
{
    char message[ECT_SIGNAL_MESSAGE];
    ect_names_t *names = ect_names_new(TWINS);
    assert_non_null(names);
    assert_true(ect_names_add(names, 1, "arm") && ect_names_add(names, 2, "leg"));
    assert_true(ect_chain_set_names(w->chain, names, message));
    return names;
}

static void a_name_in_front_chooses_the_twin_of_a_signal(void **state)
{
    static const struct {
        const char *name;
        size_t twin; /* TWINS: there is no such signal */
        const char *own;
    } rows[] = {
        {"low", 0, NULL},           {"arm.low", 1, "arm"}, {"leg.unit.on", 2, "leg"}, {"unit.on", 0, NULL},
        {"arm.ecat.run", 1, "arm"}, {"arm.", TWINS, NULL}, {"arm", TWINS, NULL},      {"other.low", TWINS, NULL},
    };
    wire_t w;
    (void)state;
    open_twins(&w);
    ect_names_t *names = name_twins(&w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_signal_ref_t ref;
        size_t position = 0;
        const char *name = rows[i].name;
        print_message("%s\n", rows[i].name);
        assert_int_equal(ect_chain_signal(w.chain, 0, name, &ref), rows[i].twin < TWINS);
        if (rows[i].twin == TWINS)
            continue;
        assert_int_equal(ect_chain_resolve(w.chain, &position, &name), rows[i].own != NULL);
        assert_int_equal(position, rows[i].twin);
        assert_string_equal(name, ref.name);
        assert_true(rows[i].own ? strcmp(ref.twin, rows[i].own) == 0 : !ref.twin);
    }
    wire_close(&w);
    ect_names_free(names);
}

static void signals_of_several_twins_are_set_or_none(void **state)
{
    static const struct {
        const char *title, *refused;
        ect_setting_t settings[3];
        uint16_t low[TWINS];
    } rows[] = {
        {"all", NULL, {{"low", "1"}, {"arm.low", "2"}, {"leg.low", "3"}}, {1, 2, 3}},
        {"the last one is refused by its twin",
         "low: refused",
         {{"low", "4"}, {"arm.low", "5"}, {"leg.low", "99"}},
         {1, 2, 3}},
        {"the first one is out of range",
         "low takes 0..1000, not '1001'",
         {{"leg.low", "1001"}, {"low", "6"}, {"arm.low", "7"}},
         {1, 2, 3}},
        {"one is not there",
         "slave 2 has no signal 'law'; did you mean 'low'?",
         {{"low", "8"}, {"arm.law", "9"}, {"leg.low", "7"}},
         {1, 2, 3}},
        {"one is of no twin",
         "slave 1 has no signal 'crane.low', and no twin has the name 'crane': 'ectwin get -n 0 ecat.state' lists "
         "the names of running twins",
         {{"low", "8"}, {"crane.low", "9"}, {"leg.low", "7"}},
         {1, 2, 3}},
        {"one is of no twin, whose name is as long as that of a group",
         "slave 1 has no signal 'boom.lift', and no twin has the name 'boom': 'ectwin get -n 0 ecat.state' lists "
         "the names of running twins",
         {{"low", "8"}, {"boom.lift", "9"}, {"leg.low", "7"}},
         {1, 2, 3}},
        {"an element without a twin, as in options",
         "slave 1 has no signal 'crane:low', and no twin has the name 'crane': 'ectwin get -n 0 ecat.state' lists "
         "the names of running twins",
         {{"low", "8"}, {"crane:low", "9"}, {"leg.low", "7"}},
         {1, 2, 3}},
        {"an unknown name in a known group",
         "slave 1 has no signal 'unit.speed': 'ectwin list-signals DEVICE' lists those of a device; -n chooses the "
         "slave",
         {{"low", "8"}, {"unit.speed", "9"}, {"leg.low", "7"}},
         {1, 2, 3}},
        {"an unknown name in a named twin",
         "slave 2 has no signal 'on.speed': 'ectwin list-signals DEVICE' lists those of a device; -n chooses the slave",
         {{"low", "8"}, {"arm.on.speed", "9"}, {"leg.low", "7"}},
         {1, 2, 3}},
    };
    wire_t w;
    (void)state;
    open_twins(&w);
    ect_names_t *names = name_twins(&w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE];
        print_message("%s\n", rows[i].title);
        bool done = ect_settings_apply(w.chain, 0, rows[i].settings, 3, w.now_ns, message);
        assert_int_equal(done, rows[i].refused == NULL);
        if (!done)
            assert_string_equal(message, rows[i].refused);
        for (size_t n = 0; n < TWINS; n++)
            assert_int_equal(testdev_of(&w, n)->array[0], rows[i].low[n]);
    }
    wire_close(&w);
    ect_names_free(names);
}

static void a_name_that_hides_a_signal_is_refused(void **state)
{
    static const struct {
        const char *name, *why;
    } rows[] = {
        {"unit", "the name 'unit' of twin 2 hides the signal 'unit.on' of twin 1: choose another name"},
        {"ecat", "the name 'ecat' of twin 2 hides the signal 'ecat.run' of twin 1: choose another name"},
        {"scenario", "the name 'scenario' hides the signals of a scenario: choose another name"},
        {"scenarios", NULL},
        {"low", NULL}, /* low.low is no name of a signal */
    };
    wire_t w;
    (void)state;
    open_twins(&w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        ect_names_t *names = ect_names_new(TWINS);
        assert_non_null(names);
        assert_true(ect_names_add(names, 1, rows[i].name));
        assert_int_equal(ect_chain_set_names(w.chain, names, message), rows[i].why == NULL);
        assert_string_equal(message, rows[i].why ? rows[i].why : "");
        assert_ptr_equal(ect_chain_names(w.chain), rows[i].why ? NULL : names);
        assert_true(ect_chain_set_names(w.chain, NULL, message));
        ect_names_free(names);
    }
    wire_close(&w);
}

/* The signals of a twin with a crane: its device's, those beside it, or those of its present plant. */
static const ect_signal_t low[] = {
    {.name = "low", .type = ECT_SIGNAL_U16, .access = ECT_SIGNAL_WRITE, .maximum = 1000}};
static const ect_signal_group_t cranes[] = {{.signal_count = 1, .signals = low, .prefix = "crane"}};
static const ect_plant_t crane = {.signal_groups = cranes, .signal_group_count = 1};

static const ect_plant_t *present_one(const void *instance)
{
    return ((const testdev_t *)instance)->u32 == 1 ? &crane : &plant;
}

static void signals_of_each_twin_are_compared_with_names(void **state)
{
    enum { OWN, BESIDE, PRESENT, WAYS };
    static const ect_plant_t varied = {.present = present_one};
    (void)state;
    for (unsigned int n = 0; n < WAYS * TWINS; n++) {
        const size_t place = n / WAYS, other = (place + 1) % TWINS;
        char message[ECT_SIGNAL_MESSAGE] = "", want[ECT_SIGNAL_MESSAGE];
        ect_twin_config_t twins[TWINS];
        uint16_t beside = 0;
        wire_t w;
        for (size_t i = 0; i < TWINS; i++)
            twins[i] = ect_twin_default(&testdev, n % WAYS == PRESENT ? &varied : &plant);
        if (n % WAYS == OWN)
            twins[place].plant = &crane;
        if (n % WAYS == BESIDE)
            twins[place].beside = (ect_beside_t){.plant = &crane, .instance = &beside, .size = sizeof beside};
        wire_open_twins(&w, twins, TWINS);
        testdev_of(&w, place)->u32 = 1;
        ect_names_t *names = ect_names_new(TWINS);
        assert_non_null(names);
        assert_true(ect_names_add(names, other, "crane"));
        snprintf(want, sizeof want, "the name 'crane' of twin %zu hides the signal 'crane.low' of twin %zu: %s",
                 other + 1, place + 1, "choose another name");
        assert_false(ect_chain_set_names(w.chain, names, message));
        assert_string_equal(message, want);
        ect_names_free(names);
        wire_close(&w);
    }
}

static void a_fault_takes_a_name_for_a_number(void **state)
{
    static const struct {
        const char *text, *named, *plain;
    } rows[] = {
        {"hang slave arm", "hang slave arm", "hang slave 2"},
        {"hang slave 1", "hang slave 1", "hang slave 1"},
        {"drop 5% wire leg back", "drop 5% wire leg back", "drop 5% wire 3 back"},
    };
    ect_names_t *names = ect_names_new(TWINS);
    ect_fault_t fault;
    char message[ECT_FAULT_MESSAGE], text[ECT_FAULT_TEXT];
    (void)state;
    assert_non_null(names);
    assert_true(ect_names_add(names, 1, "arm") && ect_names_add(names, 2, "leg"));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        print_message("%s\n", rows[i].text);
        assert_true(ect_fault_parse_named(rows[i].text, names, &fault, message));
        ect_fault_print_named(&fault, names, text);
        assert_string_equal(text, rows[i].named);
        ect_fault_print(&fault, text);
        assert_string_equal(text, rows[i].plain);
    }
    assert_false(ect_fault_parse_named("hang slave other", names, &fault, message));
    assert_string_equal(message, "expected the number or the name of a twin, not 'other'");
    assert_false(ect_fault_parse("hang slave arm", &fault, message));
    ect_names_free(names);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_begins_with_a_name),
        cmocka_unit_test(each_name_is_that_of_one_twin),
        cmocka_unit_test(every_twin_of_the_largest_bus_has_a_name),
        cmocka_unit_test(a_name_in_front_chooses_the_twin_of_a_signal),
        cmocka_unit_test(signals_of_several_twins_are_set_or_none),
        cmocka_unit_test(a_name_that_hides_a_signal_is_refused),
        cmocka_unit_test(signals_of_each_twin_are_compared_with_names),
        cmocka_unit_test(a_fault_takes_a_name_for_a_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
