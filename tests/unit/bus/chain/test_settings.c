/* SPDX-License-Identifier: MIT */
/* Several signals of a twin are set, all or none (bus/chain/settings.h); refusals that depend on others are in
 * test_control.c, with a device that has them. */
#include "bus/chain/settings.h"

#include <stdio.h>
#include <string.h>

#include "support/testdev.h"
#include "support/wire.h"

enum { TWINS = 2 };

static const ect_signal_t signals[] = {
    ECT_SIGNAL(testdev_t, array[0], "low", U16, WRITE, 0, 1000, NULL, ""),
    ECT_SIGNAL(testdev_t, array[1], "high", U16, WRITE, 0, 1000, NULL, ""),
    ECT_SIGNAL(testdev_t, array[2], "temperature", U16, WRITE, 0, 1000, NULL, ""),
    ECT_SIGNAL(testdev_t, array[3], "own", U16, READ, 0, 1000, NULL, ""),
    ECT_SIGNAL(testdev_t, in_bits, "ab", U8, WRITE, 0, 255, NULL, ""),
};
static const ect_signal_group_t group = {.signal_count = sizeof signals / sizeof signals[0], .signals = signals};

/* `low` must stay below `high`. */
static const char *in_order(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                            uint64_t now_ns)
{
    const testdev_t *dev = instance;
    uint16_t to = *(const uint16_t *)value;
    (void)number;
    (void)now_ns;
    if (signal == &signals[0] && to >= dev->array[1])
        return "must be below high";
    if (signal == &signals[1] && to <= dev->array[0])
        return "must be above low";
    return NULL;
}

static const ect_plant_t plant = {.signal_groups = &group, .signal_group_count = 1, .signal_write = in_order};

static void open_count(wire_t *w, size_t count)
{
    const ect_twin_config_t twins[TWINS] = {ect_twin_default(&testdev, &plant), ect_twin_default(&testdev, &plant)};
    wire_open_twins(w, twins, count);
    for (size_t i = 0; i < count; i++) {
        testdev_of(w, i)->array[0] = 10;
        testdev_of(w, i)->array[1] = 20;
    }
}

/* The values of the second twin afterwards are low and high. */
static void all_or_none(void **state)
{
    static const struct {
        const char *title;
        ect_setting_t settings[4];
        size_t count;
        uint16_t low, high;
        const char *why; /* NULL: they are set */
    } rows[] = {
        {"none", {{0}}, 0, 10, 20, NULL},
        {"one", {{"low", "19"}}, 1, 19, 20, NULL},
        {"one that is refused", {{"low", "20"}}, 1, 10, 20, "low: must be below high"},
        {"in the order that works", {{"high", "200"}, {"low", "100"}}, 2, 100, 200, NULL},
        {"in the other order", {{"low", "100"}, {"high", "200"}}, 2, 100, 200, NULL},
        {"the same one twice: the last value applies", {{"low", "11"}, {"low", "12"}}, 2, 12, 20, NULL},
        {"each waits for the next one",
         {{"low", "300"}, {"high", "200"}, {"low", "100"}, {"high", "400"}},
         4,
         300,
         400,
         NULL},
        {"the first refusal is the reason",
         {{"high", "21"}, {"low", "900"}, {"high", "5"}},
         3,
         10,
         20,
         "low: must be below high"},
        {"one out of range: none is set",
         {{"low", "11"}, {"high", "1001"}},
         2,
         10,
         20,
         "high takes 0..1000, not '1001'"},
        {"one that can only be read",
         {{"low", "11"}, {"own", "1"}},
         2,
         10,
         20,
         "own is the twin's own: it can be read and watched, not set"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE];
        wire_t w;
        open_count(&w, TWINS);
        bool done = ect_settings_apply(w.chain, 1, rows[i].settings, rows[i].count, w.now_ns, message);
        const testdev_t *dev = testdev_of(&w, 1);
        if (done != (rows[i].why == NULL) || dev->array[0] != rows[i].low || dev->array[1] != rows[i].high)
            fail_msg("%s: expected %s with %u and %u, got %u and %u: %s", rows[i].title, rows[i].why, rows[i].low,
                     rows[i].high, dev->array[0], dev->array[1], message);
        if (rows[i].why)
            assert_string_equal(message, rows[i].why);
        assert_int_equal(testdev_of(&w, 0)->array[0], 10);
        wire_close(&w);
    }
}

static const ect_signal_t steps[] = {
    ECT_SIGNAL(testdev_t, array[0], "first", U16, WRITE, 0, 9, NULL, ""),
    ECT_SIGNAL(testdev_t, array[1], "second", U16, WRITE, 0, 9, NULL, ""),
    ECT_SIGNAL(testdev_t, array[2], "third", U16, WRITE, 0, 9, NULL, ""),
    ECT_SIGNAL(testdev_t, array[3], "fourth", U16, WRITE, 0, 9, NULL, ""),
};
static const ect_signal_group_t step_group = {.signal_count = 4, .signals = steps};

/* Each needs the next one first. */
static const char *needs_the_next(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                  uint64_t now_ns)
{
    const testdev_t *dev = instance;
    const size_t n = (size_t)(signal - steps);
    (void)number;
    (void)value;
    (void)now_ns;
    return n < 3 && dev->array[n + 1] == 0 ? "needs the next one" : NULL;
}

/* The four signals, as digits in the order of the settings. */
static void one_needs_another(void **state)
{
    static const ect_plant_t needs = {
        .signal_groups = &step_group, .signal_group_count = 1, .signal_write = needs_the_next};
    static const char *const orders[] = {"3210", "0123", "1023", "0213", "2013", "1203", "0132", "2103", "1302"};
    static const char *const names[] = {"first", "second", "third", "fourth"};
    (void)state;
    for (size_t i = 0; i < sizeof orders / sizeof orders[0]; i++) {
        const ect_twin_config_t twin = ect_twin_default(&testdev, &needs);
        ect_setting_t settings[4];
        char message[ECT_SIGNAL_MESSAGE];
        wire_t w;
        wire_open_twins(&w, &twin, 1);
        for (size_t n = 0; n < 4; n++)
            settings[n] = (ect_setting_t){names[orders[i][n] - '0'], "1"};
        if (!ect_settings_apply(w.chain, 0, settings, 4, w.now_ns, message))
            fail_msg("%s: %s", orders[i], message);
        for (size_t n = 0; n < 4; n++)
            assert_int_equal(testdev_of(&w, 0)->array[n], 1);
        wire_close(&w);
    }
}

static const ect_signal_t choices[] = {
    ECT_SIGNAL_CHOICE(testdev_t, array[0], "a", 0, 9, 1, ""),
    ECT_SIGNAL_CHOICE(testdev_t, array[1], "b", 0, 9, 2, ""),
    ECT_SIGNAL_CHOICE(testdev_t, array[2], "c", 0, 9, 2, ""),
    ECT_SIGNAL(testdev_t, array[3], "x", U16, WRITE, 0, 9, NULL, ""),
    ECT_SIGNAL(testdev_t, in_bits, "y", U8, WRITE, 0, 9, NULL, ""),
};
static const ect_signal_group_t choice_group = {.signal_count = sizeof choices / sizeof choices[0], .signals = choices};
static char written[16];

static const char *note_name(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                             uint64_t now_ns)
{
    (void)instance;
    (void)number;
    (void)value;
    (void)now_ns;
    strcat(written, signal->name);
    return NULL;
}

/* Signals with a turn replace values of others: turn 1, then turn 2, then the signals without a turn. */
static void turns(void **state)
{
    static const ect_plant_t chooses = {
        .signal_groups = &choice_group, .signal_group_count = 1, .signal_write = note_name};
    static const struct {
        const char *given, *written;
    } rows[] = {{"a", "a"},     {"xy", "xy"},       {"yx", "yx"},       {"ab", "ab"},       {"ba", "ab"},
                {"bc", "bc"},   {"cb", "cb"},       {"xa", "ax"},       {"xb", "bx"},       {"ax", "ax"},
                {"xba", "abx"}, {"yxcba", "acbyx"}, {"abcxy", "abcxy"}, {"cxayb", "acbxy"}, {"xayab", "aabxy"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_twin_config_t twin = ect_twin_default(&testdev, &chooses);
        const size_t count = strlen(rows[i].given);
        char names[5][2] = {{0}};
        ect_setting_t settings[5];
        char message[ECT_SIGNAL_MESSAGE];
        wire_t w;
        wire_open_twins(&w, &twin, 1);
        for (size_t n = 0; n < count; n++) {
            names[n][0] = rows[i].given[n];
            settings[n] = (ect_setting_t){names[n], "1"};
        }
        written[0] = 0;
        assert_true(ect_settings_apply(w.chain, 0, settings, count, w.now_ns, message));
        if (strcmp(written, rows[i].written) != 0)
            fail_msg("settings %s: expected the order %s, got %s", rows[i].given, rows[i].written, written);
        wire_close(&w);
    }
}

/* Values at places found before; a place without a value is left out. */
static void written_at_places(void **state)
{
    static const char *const names[] = {"low", "high", "temperature"};
    static const struct {
        const char *title;
        const char *values[3];
        uint16_t want[3];
        const char *why; /* NULL: they are set */
    } rows[] = {
        {"none", {NULL, NULL, NULL}, {10, 20, 0}, NULL},
        {"one", {NULL, "30", NULL}, {10, 30, 0}, NULL},
        {"the last one", {NULL, NULL, "7"}, {10, 20, 7}, NULL},
        {"all, in an order that waits", {"100", "200", "7"}, {100, 200, 7}, NULL},
        {"one is refused", {"100", NULL, "7"}, {10, 20, 0}, "low: must be below high"},
        {"one is out of range", {"11", NULL, "1001"}, {10, 20, 0}, "temperature takes 0..1000, not '1001'"},
        {"the first is out of range", {"1001", "30", NULL}, {10, 20, 0}, "low takes 0..1000, not '1001'"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_setting_place_t places[3];
        char message[ECT_SIGNAL_MESSAGE];
        wire_t w;
        open_count(&w, TWINS);
        const testdev_t *dev = testdev_of(&w, 1);
        for (size_t n = 0; n < 3; n++)
            assert_true(ect_settings_find(w.chain, 1, names[n], &places[n], message));
        const bool done = ect_settings_write(w.chain, places, rows[i].values, 3, w.now_ns, message);
        if (done != (rows[i].why == NULL) || memcmp(dev->array, rows[i].want, sizeof rows[i].want) != 0)
            fail_msg("%s: done %d, got %u, %u, %u: %s", rows[i].title, done, dev->array[0], dev->array[1],
                     dev->array[2], message);
        if (rows[i].why)
            assert_string_equal(message, rows[i].why);
        assert_int_equal(testdev_of(&w, 0)->array[0], 10);
        wire_close(&w);
    }
}

/* At most two characters differ, and fewer than the length of the wrong name. */
static void names_nearby(void **state)
{
    static const struct {
        const char *wrong, *meant; /* NULL: none is near */
    } rows[] = {
        {"hihg", "high"},
        {"hig", "high"},
        {"highhh", "high"},
        {"higherr", NULL},
        {"hi", NULL},
        {"h", NULL},
        {"lo", "low"},
        {"lowest", NULL},
        {"llow", "low"},
        {"xow", "low"},
        {"xyw", "low"},
        {"xyz", NULL},
        {"temperture", "temperature"},
        {"tempertre", "temperature"},
        {"tempetre", NULL},
        {"temperaturexy", "temperature"},
        {"temperaturexyz", NULL},
        {"tmeperature", "temperature"},
        {"Temperature", "temperature"},
        {"cd", NULL},
        {"b", NULL},
        {"ac", "ab"},
        {"c", NULL},
        {"ecat.plug_ot", "ecat.plug_out"},
        {"ecat.rn", "ecat.run"},
        {"", NULL},
    };
    (void)state;
    for (size_t count = 1; count <= TWINS; count++) {
        wire_t w;
        open_count(&w, count);
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            char message[ECT_SIGNAL_MESSAGE], want[ECT_SIGNAL_MESSAGE];
            const ect_setting_t setting = {rows[i].wrong, "1"};
            assert_false(ect_settings_apply(w.chain, count - 1, &setting, 1, w.now_ns, message));
            int used = snprintf(want, sizeof want, "slave %zu has no signal '%s'", count, rows[i].wrong);
            if (rows[i].meant)
                (void)snprintf(want + used, sizeof want - (size_t)used, "; did you mean '%s'?", rows[i].meant);
            else
                (void)snprintf(want + used, sizeof want - (size_t)used,
                               ": 'ectwin list-signals DEVICE' lists those of a device%s",
                               count > 1 ? "; -n chooses the slave" : "");
            assert_string_equal(message, want);
        }
        wire_close(&w);
    }
}

/* A name that is far too long is shown in part, without a suggestion. */
static void endless_name(void **state)
{
    char message[ECT_SIGNAL_MESSAGE], name[ECT_SIGNAL_NAME + 40];
    const ect_setting_t setting = {name, "1"};
    wire_t w;
    (void)state;
    open_count(&w, 1);
    for (size_t length = ECT_SIGNAL_NAME - 2; length < sizeof name; length++) {
        memset(name, 'n', length);
        name[length] = 0;
        assert_false(ect_settings_apply(w.chain, 0, &setting, 1, w.now_ns, message));
        assert_memory_equal(message, "slave 1 has no signal 'nnn", 26);
        assert_non_null(strstr(message, "n': 'ectwin list-signals DEVICE'"));
    }
    wire_close(&w);
}

/* A set that succeeds wakes the twin; one that is refused leaves it asleep. */
static void wakes(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    wire_t w;
    (void)state;
    open_count(&w, TWINS);
    w.now_ns += 1000 * MS;
    wire_poll(&w);
    unsigned int ticks[TWINS] = {testdev_of(&w, 0)->ticks, testdev_of(&w, 1)->ticks};
    assert_false(ect_settings_apply(w.chain, 1, &(ect_setting_t){"low", "20"}, 1, w.now_ns, message));
    (void)ect_chain_poll(w.chain, w.now_ns);
    assert_int_equal(testdev_of(&w, 1)->ticks, ticks[1]);
    assert_true(ect_settings_apply(w.chain, 1, &(ect_setting_t){"low", "15"}, 1, w.now_ns, message));
    (void)ect_chain_poll(w.chain, w.now_ns);
    assert_int_equal(testdev_of(&w, 0)->ticks, ticks[0]);
    assert_int_equal(testdev_of(&w, 1)->ticks, ticks[1] + 1);
    wire_close(&w);
}

/* --- the state beside the instance -------------------------------------------------------------------------------- */

enum { LEAVE = 1, RETURN = 2, RESTART = 3, REFUSE = 9 };

static const ect_signal_t acts[] = {ECT_SIGNAL(testdev_t, array[0], "act", U16, WRITE, 0, 9, NULL, "")};
static const ect_signal_group_t act_group = {.signal_count = 1, .signals = acts};

static const char *act(void *instance, const ect_signal_t *signal, uint16_t number, const void *value, uint64_t now_ns)
{
    const ect_host_t *host = ((const testdev_t *)instance)->host;
    const uint16_t what = *(const uint16_t *)value;
    (void)signal;
    (void)number;
    (void)now_ns;
    if (what == LEAVE || what == RETURN)
        host->off_bus(host->ctx, what == LEAVE);
    if (what == RESTART)
        host->restart(host->ctx);
    return what == REFUSE ? "refused" : NULL;
}

/* Each row in a fresh chain, and each twin in both places, since the places have a snapshot each. */
static void state_of_a_refusal(void **state)
{
    static const ect_plant_t actor = {.signal_groups = &act_group, .signal_group_count = 1, .signal_write = act};
    static const struct {
        const char *title;
        const char *before; /* set alone; NULL: nothing */
        ect_setting_t settings[2];
        bool done, off_bus, restart;
    } rows[] = {
        {"a twin that leaves the bus is back", NULL, {{"act", "1"}, {"act", "9"}}, false, false, false},
        {"a twin that returns is off again", "1", {{"act", "2"}, {"act", "9"}}, false, true, false},
        {"a twin off the bus remains so", "1", {{"act", "0"}, {"act", "9"}}, false, true, false},
        {"a twin does not restart", NULL, {{"act", "3"}, {"act", "9"}}, false, false, false},
        {"a restart from before remains", "3", {{"act", "0"}, {"act", "9"}}, false, false, true},
        {"settings that are taken have their effects", NULL, {{"act", "1"}, {"act", "3"}}, true, true, true},
    };
    (void)state;
    for (size_t i = 0; i < TWINS * sizeof rows / sizeof rows[0]; i++) {
        const ect_twin_config_t twins[TWINS] = {ect_twin_default(&testdev, &actor), ect_twin_default(&testdev, &actor)};
        const size_t position = i % TWINS, row = i / TWINS;
        char message[ECT_SIGNAL_MESSAGE];
        wire_t w;
        wire_open_twins(&w, twins, TWINS);
        const ect_setting_t before = {"act", rows[row].before};
        if (rows[row].before)
            assert_true(ect_settings_apply(w.chain, position, &before, 1, w.now_ns, message));
        assert_int_equal(ect_settings_apply(w.chain, position, rows[row].settings, 2, w.now_ns, message),
                         rows[row].done);
        const ect_slave_t *slave = ect_chain_slave(w.chain, position);
        if (slave->off_bus != rows[row].off_bus || slave->restart != rows[row].restart)
            fail_msg("%s: expected off the bus %d and restart %d, got %d and %d", rows[row].title, rows[row].off_bus,
                     rows[row].restart, slave->off_bus, slave->restart);
        wire_close(&w);
    }
}

typedef struct box {
    uint16_t level, other;
} box_t;

/* Signals beside those of the device, and of the wiring. */
static void values_beside_the_device_are_back(void **state)
{
    static const ect_signal_t levels[] = {ECT_SIGNAL(box_t, level, "level", U16, WRITE, 0, 1000, NULL, "")};
    static const ect_signal_group_t beside_group = {.signal_count = 1, .signals = levels, .prefix = "box"};
    static const ect_plant_t beside = {.signal_groups = &beside_group, .signal_group_count = 1};
    static const ect_setting_t settings[] = {{"box.level", "30"}, {"ecat.drift", "500"}, {"low", "20"}};
    (void)state;
    for (size_t count = 2; count <= 3; count++) {
        const bool taken = count == 2;
        ect_twin_config_t twin = ect_twin_default(&testdev, &plant);
        box_t box = {.level = 7, .other = 9};
        char message[ECT_SIGNAL_MESSAGE], drift[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_ref_t ref;
        wire_t w;
        twin.beside = (ect_beside_t){.plant = &beside, .instance = &box, .size = sizeof box};
        wire_open_twins(&w, &twin, 1);
        testdev_of(&w, 0)->array[1] = 20;
        assert_int_equal(ect_settings_apply(w.chain, 0, settings, count, w.now_ns, message), taken);
        assert_int_equal(box.level, taken ? 30 : 7);
        assert_int_equal(box.other, 9);
        assert_true(ect_chain_signal(w.chain, 0, "ecat.drift", &ref));
        ect_signal_read(&ref, drift);
        assert_string_equal(drift, taken ? "500" : "0");
        wire_close(&w);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"settings are made in any order, all or none, and refused with the first reason", all_or_none, NULL, NULL,
         NULL},
        {"settings that need others are made after those, whatever their order", one_needs_another, NULL, NULL, NULL},
        {"settings that replace values of others are made first, by their turn", turns, NULL, NULL, NULL},
        {"values are written at places, all or none", written_at_places, NULL, NULL, NULL},
        {"the refusal of an unknown signal names the nearest one, or the command that lists them", names_nearby, NULL,
         NULL, NULL},
        {"an unknown name longer than any signal's is refused in one line", endless_name, NULL, NULL, NULL},
        {"a refusal undoes what the settings before it have done to the twin on the bus", state_of_a_refusal, NULL,
         NULL, NULL},
        {"a refusal undoes what the settings before it have set beside the device", values_beside_the_device_are_back,
         NULL, NULL, NULL},
        {"settings wake their twin and no other, a refusal none", wakes, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("settings", tests, NULL, NULL);
}
