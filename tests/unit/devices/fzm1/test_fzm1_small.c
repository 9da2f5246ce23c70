/* SPDX-License-Identifier: MIT */
/* The FZM1 of a board with little memory: it holds two scenes of the current group, the record has the others.
 */
#include <stdio.h>
#include <string.h>

#include "bench.h"

_Static_assert(FZM1_KEPT == 2, "built with ECT_SMALL");

enum { SAVED = 6 };

static void expect_data(const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&s.w, "data1", text);
    if (strcmp(text, want) != 0)
        fail_msg("data1: expected %s, got %s", want, text);
}

static void save(void)
{
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0);
}

static void switch_to(int32_t scene)
{
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_SCENE, scene, 0, 0, NULL), 0);
}

static void expect_scene(int32_t scene, const char *want)
{
    switch_to(scene);
    expect_data(want);
}

static void change(int32_t scene)
{
    char value[16];
    snprintf(value, sizeof value, "%d", (int)scene + 1);
    switch_to(scene);
    signal_set(&s.w, "data1", value);
}

/* Scenes 0 to 5 hold 1 to 6, two at a time. */
static void fill(void)
{
    for (int32_t scene = 0; scene < SAVED; scene++) {
        change(scene);
        if (scene % 2 == 1)
            save();
    }
}

static void from_storage(void **state)
{
    (void)state;
    fill();
    for (int round = 0; round < 2; round++) {
        for (int32_t n = 0; n < SAVED; n++) {
            char want[16];
            int32_t scene = n * 5 % SAVED; /* there and back */
            snprintf(want, sizeof want, "%d", (int)scene + 1);
            expect_scene(scene, want);
        }
        expect_scene(100, "0");
        power_cycle();
    }
}

static void unsaved(void **state)
{
    (void)state;
    fill();
    switch_to(4);
    signal_set(&s.w, "data1", "44");
    switch_to(5);
    signal_set(&s.w, "data1", "55");
    for (int32_t scene = 0; scene < 4; scene++) {
        char want[16];
        snprintf(want, sizeof want, "%d", (int)scene + 1);
        expect_scene(scene, want);
    }
    expect_scene(4, "44");
    expect_scene(5, "55");
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, 1, 0, 0, NULL), 0);
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, 0, 0, 0, NULL), 0);
    expect_scene(4, "5"); /* unsaved changes are lost with their group */
}

static void no_room(void **state)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    (void)state;
    for (int32_t scene = 0; scene < 3; scene++)
        change(scene);
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_SCENE, 3, 0, 0, NULL), 0xFFFFFFFF);
    signal_get(&s.w, "command_refused_cause", text);
    assert_non_null(strstr(text, "save them first"));
    expect_data("3"); /* it has its previous place, and so do the others */
    save();
    expect_scene(3, "0");
    expect_scene(0, "1");
    expect_scene(2, "3");
}

static void until_saved(void)
{
    while (signal_number(&s.w, "saving") != 0)
        wire_advance(&s.w, MS / 10);
}

/* Scene 0 is 1 in its place, and is to be 1 again; then another scene needs a place. */
static void expect_changed_back(void)
{
    signal_set(&s.w, "data1", "1");
    until_saved();
    switch_to(2);
    signal_set(&s.w, "data1", "77");
    switch_to(3);
    expect_scene(0, "1");
    expect_scene(2, "77");
}

static void begin_with_a_place(void)
{
    fill();
    power_cycle();
    switch_to(0);
}

static void changed_back_after_a_save(void **state)
{
    (void)state;
    begin_with_a_place();
    signal_set(&s.w, "data1", "22");
    save();
    expect_changed_back();
}

static void changed_back_during_a_save(void **state)
{
    (void)state;
    begin_with_a_place();
    signal_set(&s.w, "data1", "22");
    signal_set(&s.w, "save", "1");
    wire_advance(&s.w, MS / 2); /* scene 0 is written */
    assert_int_equal(signal_number(&s.w, "saving"), 1);
    expect_changed_back();
}

static void changed_back_after_preparing(void **state)
{
    (void)state;
    begin_with_a_place();
    signal_set(&s.w, "edit.scene", "0");
    signal_set(&s.w, "edit.data1", "22");
    expect_changed_back();
}

/* Scene 9 has factory settings and no place, and both places are used. */
static void back_to_the_factory(void **state)
{
    (void)state;
    change(0);
    change(1);
    switch_to(9);
    signal_set(&s.w, "data1", "99");
    save();
    signal_set(&s.w, "data1", "0");
    change(2);
    expect_scene(9, "0");
    expect_scene(0, "1");
}

/* 400 scenes of ten groups are saved. The reads of a step are bounded, for any number of scenes before a group's and
 * any of its own. */
static void reads_of_a_step(void **state)
{
    (void)state;
    for (int group = 0; group < 10; group++) {
        assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, group, 0, 0, NULL), 0);
        for (int32_t scene = 0; scene < 120; scene += 3) {
            change(scene);
            if (scene % 2 == 1)
                save();
        }
        save();
    }
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, 4, 0, 0, NULL), 0);
    signal_set(&s.w, "save", "1");
    uint32_t most = 0;
    while (signal_number(&s.w, "saving") != 0) {
        memory.reads = 1000000;
        wire_advance(&s.w, MS / 10);
        uint32_t reads = 1000000 - memory.reads;
        most = reads > most ? reads : most;
    }
    memory.reads = UINT32_MAX;
    if (most < 8 || most > 500)
        fail_msg("a step of a save reads %u times: expected 500 at most", most);
    expect_scene(117, "118");
}

static void silent_memory(void **state)
{
    (void)state;
    fill();
    expect_scene(1, "2");
    memory.reads = 0;
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_SCENE, 5, 0, 0, NULL), 0xFFFFFFFF);
    expect_data("2");
    memory.reads = UINT32_MAX;
    expect_scene(5, "6");
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-056 FZM-058: saved scenes exist, whichever scenes are in memory", from_storage),
        TEST("FZM-056 FZM-058: unsaved changes of scenes are kept until a switch to another group", unsaved),
        TEST("FZM-058: more changed scenes than places: the switch is refused with the reason, nothing is lost",
             no_room),
        TEST("FZM-056 FZM-058: a scene saved, then set to its previous values: the change is kept",
             changed_back_after_a_save),
        TEST("FZM-056 FZM-058: a scene set to its previous values during its save: the change is kept",
             changed_back_during_a_save),
        TEST("FZM-058: a scene prepared, then set to its previous values: the change is kept",
             changed_back_after_preparing),
        TEST("FZM-056 FZM-058: a scene without a place saved, then set to factory settings: the change is kept",
             back_to_the_factory),
        TEST("FZM-056: a save reads a bounded number of times per step", reads_of_a_step),
        TEST("FZM-058: no switch to a scene that the memory does not return", silent_memory),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 with little memory", tests, NULL, NULL);
}
