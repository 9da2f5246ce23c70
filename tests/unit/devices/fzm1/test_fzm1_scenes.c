/* SPDX-License-Identifier: MIT */
/* The values of a scene (Q179 §3-2, §3-3), and scenes that are prepared before a switch to them. */
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "bus/chain/settings.h"

static void expect_text(const char *signal, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&s.w, signal, text);
    if (strcmp(text, want) != 0)
        fail_msg("%s: expected '%s', got '%s'", signal, want, text);
}

static void set_all(const char *const (*values)[2], size_t count)
{
    for (size_t i = 0; i < count; i++)
        signal_set(&s.w, values[i][0], values[i][1]);
}
#define SET(values) set_all(values, sizeof(values) / sizeof((values)[0]))

static void command(uint32_t code, int32_t number)
{
    assert_int_equal(sensor_command(&s, code, number, 0, 0, NULL), 0);
}

static void save(void)
{
    command(FZM1_SAVE, 0);
}

static int32_t measured(unsigned int n)
{
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
    int32_t data = sensor_data(&s, n);
    (void)sensor_until(&s, FZM1_BUSY | FZM1_GATE, 0);
    return data;
}

/* Comments, format and expressions are set in one scene; another one has its own; back in the first group they exist.
 */
static void of_a_scene(void **state)
{
    static const char *const mine[][2] = {
        {"comment1", "width"}, {"expression1", "D2 + 1"}, {"output_format", "1"}, {"judgement0", "-1"}, {"data2", "5"},
        {"units", "6"},        {"output_unit", "5"}};
    static const char *const factory[][2] = {{"comment1", ""},    {"expression1", ""}, {"output_format", "0"},
                                             {"judgement0", "1"}, {"data2", "0"},      {"units", "4"},
                                             {"output_unit", "3"}};
    (void)state;
    SET(mine);
    command(FZM1_SWITCH_SCENE, 1);
    for (size_t i = 0; i < sizeof factory / sizeof factory[0]; i++)
        expect_text(factory[i][0], factory[i][1]);
    command(FZM1_SWITCH_SCENE, 0);
    for (size_t i = 0; i < sizeof mine / sizeof mine[0]; i++)
        expect_text(mine[i][0], mine[i][1]);
    signal_set(&s.w, "output_format", "0");
    assert_int_equal(measured(1), 6000);
}

/* 2500h also belongs to the current scene. */
static void comments_by_sdo(void **state)
{
    uint8_t data[64];
    size_t size = sizeof data;
    (void)state;
    assert_int_equal(wire_sdo_download(&s.w, 0, 0x2500, 2, false, "hole", 4), 0);
    command(FZM1_SWITCH_SCENE, 1);
    assert_int_equal(wire_sdo_upload(&s.w, 0, 0x2500, 2, false, data, &size), 0);
    assert_int_equal(size, 0);
    command(FZM1_SWITCH_SCENE, 0);
    size = sizeof data;
    assert_int_equal(wire_sdo_upload(&s.w, 0, 0x2500, 2, false, data, &size), 0);
    assert_int_equal(size, 4);
    assert_memory_equal(data, "hole", 4);
}

/* A scene of this group and one of another; then the master switches between them. */
static void prepared(void **state)
{
    static const char *const here[][2] = {{"edit.scene", "7"}, {"edit.data1", "7.5"}, {"edit.judgement1", "-1"}};
    static const char *const there[][2] = {
        {"edit.group", "3"}, {"edit.scene", "1"}, {"edit.data1", "31"}, {"edit.expression2", "2*D1"}};
    (void)state;
    SET(here);
    SET(there);
    expect_text("data1", "0");
    expect_text("edit.prepared", "2");
    for (unsigned int round = 0; round < 2; round++) {
        command(FZM1_SWITCH_SCENE, 7);
        assert_int_equal(measured(1), 7500);
        sensor_expect(&s, "judgement1", FZM1_OR, FZM1_OR);
        command(FZM1_SWITCH_GROUP, 3);
        assert_int_equal(measured(1), 0);
        command(FZM1_SWITCH_SCENE, 1);
        assert_int_equal(measured(2), 62000);
        command(FZM1_SWITCH_GROUP, 0);
    }
    signal_set(&s.w, "restart", "1"); /* prepared scenes are outside the controller */
    wire_advance(&s.w, 4000 * MS);
    wire_assign_stations(&s.w);
    sensor_operational(&s);
    command(FZM1_SWITCH_SCENE, 7);
    assert_int_equal(measured(1), 7500);
}

/* The results of the previous scene do not belong to the new one. */
static void unmeasured(void **state)
{
    static const uint32_t switches[] = {FZM1_SWITCH_SCENE, FZM1_SWITCH_GROUP};
    (void)state;
    for (size_t i = 0; i < sizeof switches / sizeof switches[0]; i++) {
        int32_t data = 0;
        (void)measured(1);
        assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, 0, 0, 0, &data), 0);
        assert_int_equal(data, 1000);
        command(switches[i], 2);
        assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, 0, 0, 0, &data), 0);
        assert_int_equal(data, 0);
    }
}

/* The current scene: changes through `edit` apply to the next measurement. */
static void current_scene(void **state)
{
    (void)state;
    signal_set(&s.w, "edit.scene", "0");
    signal_set(&s.w, "edit.data1", "4");
    expect_text("data1", "4");
    assert_int_equal(measured(1), 4000);
    signal_set(&s.w, "data1", "5");
    expect_text("edit.data1", "4"); /* as it was when it was opened, or changed here */
    signal_set(&s.w, "edit.scene", "0");
    expect_text("edit.data1", "5");
}

/* The current scene, others of its group, and those of another group: each has its own values when it is opened. */
static void opened(void **state)
{
    static const struct {
        const char *group, *scene, *data;
    } rows[] = {{"0", "3", "3"}, {"0", "0", "1"}, {"0", "7", "0"}, {"5", "0", "0"}, {"5", "3", "0"}, {"0", "3", "3"}};
    (void)state;
    command(FZM1_SWITCH_SCENE, 3);
    signal_set(&s.w, "data1", "3");
    command(FZM1_SWITCH_SCENE, 0);
    signal_set(&s.w, "data1", "1");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        signal_set(&s.w, "edit.group", rows[i].group);
        signal_set(&s.w, "edit.scene", rows[i].scene);
        expect_text("edit.data1", rows[i].data);
    }
    expect_text("edit.prepared", "0");
}

/* Saved scenes are shown, changed in one value, and saved with their group. */
static void saved_scenes(void **state)
{
    (void)state;
    command(FZM1_SWITCH_GROUP, 5);
    signal_set(&s.w, "data1", "1");
    signal_set(&s.w, "data2", "2");
    save();
    command(FZM1_SWITCH_GROUP, 0);
    signal_set(&s.w, "edit.group", "5");
    expect_text("edit.data1", "1");
    signal_set(&s.w, "edit.data1", "11");
    expect_text("edit.prepared", "1");
    save(); /* of group 0: the other one keeps what is prepared */
    expect_text("edit.prepared", "1");
    command(FZM1_SWITCH_GROUP, 5);
    expect_text("data1", "11");
    expect_text("data2", "2");
    save();
    expect_text("edit.prepared", "0");
    command(FZM1_SWITCH_GROUP, 0);
    command(FZM1_SWITCH_GROUP, 5);
    expect_text("data1", "11");
}

static void forgotten(void **state)
{
    (void)state;
    signal_set(&s.w, "edit.group", "5");
    signal_set(&s.w, "edit.data1", "11");
    signal_set(&s.w, "edit.clear", "1");
    expect_text("edit.prepared", "0");
    command(FZM1_SWITCH_GROUP, 5);
    expect_text("data1", "0");
}

/* As many as fit; then a reason, and existing ones can be changed. */
static void as_many_as_fit(void **state)
{
    char number[16], message[ECT_SIGNAL_MESSAGE] = "";
    (void)state;
    for (int n = 0; n < FZM1_PREPARED; n++) {
        snprintf(number, sizeof number, "%d", n / FZM1_SCENES + 1);
        signal_set(&s.w, "edit.group", number);
        snprintf(number, sizeof number, "%d", n % FZM1_SCENES);
        signal_set(&s.w, "edit.scene", number);
        signal_set(&s.w, "edit.data1", number);
    }
    signal_set(&s.w, "edit.data1", "1");
    signal_set(&s.w, "edit.group", "9");
    assert_false(signal_try_set(&s.w, "edit.data1", "1", message));
    assert_non_null(strstr(message, "edit.clear"));
    expect_text("edit.data1", "0");
}

/* Values of a scene must be consistent, wherever they are set. */
static void refused(void **state)
{
    static const char *const prefixes[] = {"", "edit."};
    static const struct {
        const char *name, *value, *why;
    } rows[] = {{"units", "3", "output_unit"},
                {"output_unit", "4", "units"},
                {"judgement0", "0", "1 (OK)"},
                {"expression4", "D1 +", "no expression"}};
    (void)state;
    for (unsigned int p = 0; p < 2; p++) {
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            char name[40], message[ECT_SIGNAL_MESSAGE] = "";
            snprintf(name, sizeof name, "%s%s", prefixes[p], rows[i].name);
            if (signal_try_set(&s.w, name, rows[i].value, message) || !strstr(message, rows[i].why))
                fail_msg("%s=%s: expected a refusal with '%s', got '%s'", name, rows[i].value, rows[i].why, message);
        }
    }
    expect_text("edit.prepared", "0");
}

static void memory_is_silent(void **state)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    (void)state;
    signal_set(&s.w, "data1", "1");
    save();
    memory.reads = 0;
    assert_false(signal_try_set(&s.w, "edit.group", "5", message));
    assert_non_null(strstr(message, "does not answer"));
    expect_text("edit.group", "0");
    memory.reads = UINT32_MAX;
    signal_set(&s.w, "edit.group", "5");
}

/* Values that are set together belong to the scene that is named among them, in any order. */
static void set_together(void **state)
{
    static const struct {
        ect_setting_t settings[4];
        size_t count;
        const char *group, *scene, *data;
    } rows[] = {
        {{{"data1", "1.5"}, {"scene", "3"}}, 2, "0", "3", "1.5"},
        {{{"data1", "2.5"}, {"scene", "0"}}, 2, "0", "0", "2.5"},
        {{{"data1", "3.5"}, {"scene", "3"}}, 2, "0", "3", "3.5"},
        {{{"scene", "0"}}, 1, "0", "0", "2.5"},
        {{{"scene", "3"}}, 1, "0", "3", "3.5"},
        {{{"data1", "4.5"}, {"scene", "5"}, {"scene_group", "2"}}, 3, "2", "5", "4.5"},
        {{{"edit.data1", "6.5"}, {"edit.scene", "7"}, {"edit.group", "2"}, {"data1", "4.75"}}, 4, "2", "5", "4.75"},
        {{{"scene", "7"}}, 1, "2", "7", "6.5"},
        {{{"scene", "5"}}, 1, "2", "5", "4.75"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        if (!ect_settings_apply(s.w.chain, 0, rows[i].settings, rows[i].count, s.w.now_ns, message))
            fail_msg("row %zu: %s", i, message);
        expect_text("scene_group", rows[i].group);
        expect_text("scene", rows[i].scene);
        expect_text("data1", rows[i].data);
    }
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-030 FZM-031 FZM-035: comments, expressions and format belong to the scene's Fieldbus Data Output",
             of_a_scene),
        TEST("FZM-030 FZM-035: values set together with a scene, in any order, belong to that scene", set_together),
        TEST("FZM-030: 2500h has the comments of the current scene", comments_by_sdo),
        TEST("FZM-030 FZM-058: any scene of any group can be prepared before a switch to it, and stays prepared",
             prepared),
        TEST("FZM-030 FZM-058: a switch of scene or group makes unit data unmeasured", unmeasured),
        TEST("FZM-030: the current scene is changed at once", current_scene),
        TEST("FZM-030 FZM-058: `edit` shows the values of the scene that it opens", opened),
        TEST("FZM-056 FZM-058: a saved scene is read, changed, and saved with its group", saved_scenes),
        TEST("FZM-058: prepared scenes are discarded manually", forgotten),
        TEST("FZM-058: as many scenes are prepared as fit", as_many_as_fit),
        TEST("FZM-030 FZM-033: invalid values of a scene are refused with the reason", refused),
        TEST("FZM-056 FZM-058: a memory that does not respond has no scene", memory_is_silent),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 scenes", tests, NULL, NULL);
}
