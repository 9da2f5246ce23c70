/* SPDX-License-Identifier: MIT */
/* EXE, FLG and the eleven commands (Q179 §4-2, §4-3, §4-4). */
#include <string.h>

#include "bench.h"

enum { NG = -1, RESPONSE = 12 };

static void measure(void)
{
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
}

/* Commands in turn, from power-on with data1 = 1.5 and data8 = -2.0005 in unit 3, measured once. */
static void every_command(void **state)
{
    static const struct {
        uint32_t code;
        int32_t p1, p2, p3;
        int32_t result, data;
    } rows[] = {
        {FZM1_GET_SCENE, 0, 0, 0, 0, 0},
        {FZM1_GET_GROUP, 0, 0, 0, 0, 0},
        {FZM1_GET_UNIT_DATA, 3, 0, 0, 0, 1000},
        {FZM1_GET_UNIT_DATA, 0, 0, 0, 0, 1000},
        {FZM1_GET_UNIT_DATA, 3, 5, 0, 0, 1500},
        {FZM1_GET_UNIT_DATA, 3, 12, 0, 0, -2000},
        {FZM1_GET_UNIT_DATA, 3, 150, 0, 0, 0},
        {FZM1_GET_UNIT_DATA, 3, 1, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 3, 4, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 3, 13, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 3, 149, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 3, 151, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 3, -1, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 2, 5, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 2, 150, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, 4, 0, 0, NG, 0},
        {FZM1_GET_UNIT_DATA, -1, 0, 0, NG, 0},
        {FZM1_SET_UNIT_DATA, 3, 150, 1000, 0, 0},
        {FZM1_GET_UNIT_DATA, 3, 150, 0, 0, 1000},
        {FZM1_SET_UNIT_DATA, 3, 150, 0, 0, 0},
        {FZM1_GET_UNIT_DATA, 3, 150, 0, 0, 0},
        {FZM1_SET_UNIT_DATA, 3, 150, 1, NG, 0},
        {FZM1_SET_UNIT_DATA, 3, 150, 2000, NG, 0},
        {FZM1_SET_UNIT_DATA, 3, 150, -1000, NG, 0},
        {FZM1_SET_UNIT_DATA, 3, 0, 1000, NG, 0},
        {FZM1_SET_UNIT_DATA, 3, 5, 1000, NG, 0},
        {FZM1_SET_UNIT_DATA, 3, 12, 1000, NG, 0},
        {FZM1_SET_UNIT_DATA, 2, 150, 1000, NG, 0},
        {FZM1_SET_UNIT_DATA, 8, 150, 1000, NG, 0},
        {FZM1_SWITCH_SCENE, 127, 0, 0, 0, 0},
        {FZM1_GET_SCENE, 0, 0, 0, 0, 127},
        {FZM1_SWITCH_SCENE, 128, 0, 0, NG, 0},
        {FZM1_SWITCH_SCENE, -1, 0, 0, NG, 0},
        {FZM1_GET_SCENE, 0, 0, 0, 0, 127},
        {FZM1_GET_UNIT_DATA, 3, 0, 0, 0, 0},
        {FZM1_SWITCH_GROUP, 31, 0, 0, 0, 0},
        {FZM1_GET_GROUP, 0, 0, 0, 0, 31},
        {FZM1_GET_SCENE, 0, 0, 0, 0, 0},
        {FZM1_SWITCH_GROUP, 32, 0, 0, NG, 0},
        {FZM1_SWITCH_GROUP, -1, 0, 0, NG, 0},
        {FZM1_GET_GROUP, 0, 0, 0, 0, 31},
        {FZM1_SAVE, 0, 0, 0, 0, 0},
        {FZM1_CLEAR, 0, 0, 0, 0, 0},
        {FZM1_END_CONTINUOUS, 0, 0, 0, 0, 0},
        {0x00101010, 0, 0, 0, NG, 0}, /* FZ3: measure once */
        {0x00402000, 0, 0, 0, NG, 0}, /* FZ3: date */
        {0x10200010, 0, 0, 0, NG, 0}, /* words swapped */
        {0x00000000, 0, 0, 0, NG, 0},
        {0xFFFFFFFF, 0, 0, 0, NG, 0},
    };
    (void)state;
    signal_set(&s.w, "data1", "1.5");
    signal_set(&s.w, "data8", "-2.0005");
    measure();
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int32_t data = 77;
        uint32_t result = sensor_command(&s, rows[i].code, rows[i].p1, rows[i].p2, rows[i].p3, &data);
        if (result != (uint32_t)rows[i].result || data != rows[i].data)
            fail_msg("row %zu, %08X(%d, %d, %d): expected %d with %d, got %d with %d", i, rows[i].code, rows[i].p1,
                     rows[i].p2, rows[i].p3, rows[i].result, rows[i].data, (int)result, data);
        sensor_expect(&s, "no error", FZM1_ERR, 0);
    }
}

/* The words at +2 and +3 of Q179, in the bytes of the command area. */
static void codes_on_the_wire(void **state)
{
    static const struct {
        uint16_t low, high;
        uint32_t code;
    } rows[] = {{0x1020, 0x0010, FZM1_START_CONTINUOUS},
                {0x1030, 0x0010, FZM1_END_CONTINUOUS},
                {0x2010, 0x0010, FZM1_CLEAR},
                {0x3010, 0x0010, FZM1_SAVE},
                {0xF010, 0x0010, FZM1_RESTART},
                {0x1000, 0x0020, FZM1_GET_SCENE},
                {0x2000, 0x0020, FZM1_GET_GROUP},
                {0x1000, 0x0030, FZM1_SWITCH_SCENE},
                {0x2000, 0x0030, FZM1_SWITCH_GROUP},
                {0x1000, 0x0040, FZM1_GET_UNIT_DATA},
                {0x1000, 0x0050, FZM1_SET_UNIT_DATA}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(rows[i].code, (uint32_t)rows[i].high << 16 | rows[i].low);
    s.out[4] = 0x00;
    s.out[5] = 0x20;
    s.out[6] = 0x30;
    s.out[7] = 0x00;
    s.out[8] = 5;
    sensor_set(&s, FZM1_EXE, true);
    (void)sensor_until(&s, FZM1_FLG, FZM1_FLG);
    static const uint8_t response[RESPONSE] = {0x00, 0x20, 0x30, 0x00, 0, 0, 0, 0, 0, 0, 0, 0}; /* OM-C2 */
    assert_memory_equal(s.in + 4, response, RESPONSE);
}

static void handshake(void **state)
{
    (void)state;
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    sensor_exchange(&s);
    sensor_wait(&s, 50 * MS);
    sensor_expect(&s, "code without EXE", FZM1_FLG, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_expect(&s, "EXE on", FZM1_FLG | FZM1_BUSY | FZM1_READY, FZM1_READY);
    assert_int_equal(ect_load_le32(s.in + 4), 0);
    assert_int_equal(sensor_until(&s, FZM1_FLG, FZM1_FLG), 1 * MS);
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_GET_SCENE); /* stored with FLG, not after it */
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 9, 0, 0);
    sensor_exchange(&s);
    sensor_wait(&s, 100000 * MS);
    sensor_expect(&s, "FLG stays as long as EXE", FZM1_FLG | FZM1_ERR, FZM1_FLG);
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_GET_SCENE);
    sensor_set(&s, FZM1_EXE, false);
    sensor_expect(&s, "EXE off", FZM1_FLG, 0);
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_GET_SCENE); /* the response stays */
}

/* Parameters have their values at the edge. */
static void parameters_at_the_edge(void **state)
{
    int32_t scene = -1;
    (void)state;
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 5, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 6, 0, 0);
    sensor_exchange(&s);
    (void)sensor_until(&s, FZM1_FLG, FZM1_FLG);
    sensor_set(&s, FZM1_EXE, false);
    assert_int_equal(sensor_command(&s, FZM1_GET_SCENE, 0, 0, 0, &scene), 0);
    assert_int_equal(scene, 5);
}

static void exe_falls_early(void **state)
{
    int32_t scene = -1;
    (void)state;
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 7, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 10 * MS);
    sensor_set(&s, FZM1_EXE, false);
    sensor_set(&s, FZM1_EXE, true); /* while it runs: ignored until it falls */
    sensor_set(&s, FZM1_EXE, false);
    for (int i = 0; i < 200; i++) {
        sensor_wait(&s, 1 * MS);
        sensor_expect(&s, "EXE is off, so is FLG", FZM1_FLG, 0);
    }
    assert_int_equal(sensor_command(&s, FZM1_GET_SCENE, 0, 0, 0, &scene), 0);
    assert_int_equal(scene, 7);
}

static void second_exe(void **state)
{
    (void)state;
    signal_set(&s.w, "command_time", "10000");
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 5 * MS);
    sensor_set(&s, FZM1_EXE, false);
    sensor_prepare(&s, FZM1_GET_GROUP, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    for (int i = 0; i < 100; i++) {
        sensor_wait(&s, 1 * MS);
        sensor_expect(&s, "no FLG for the first, which has ended, nor for the second, which is not accepted", FZM1_FLG,
                      0);
    }
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_GET_SCENE);
    sensor_set(&s, FZM1_EXE, false);
    assert_int_equal(sensor_command(&s, FZM1_GET_GROUP, 0, 0, 0, NULL), 0);
}

static void busy_ignores(void **state)
{
    (void)state;
    sensor_step(&s);
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 500 * MS);
    sensor_expect(&s, "EXE rose while BUSY: ignored until it falls", FZM1_FLG | FZM1_BUSY, 0);
    sensor_set(&s, FZM1_EXE, false);
    assert_int_equal(sensor_command(&s, FZM1_GET_SCENE, 0, 0, 0, NULL), 0);
}

static void expect_text(const char *signal, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&s.w, signal, text);
    if (!strstr(text, want))
        fail_msg("%s: expected '%s', got '%s'", signal, want, text);
}

/* While an image is measured, continuously measured, or another command is executed. */
static void taken_at_any_time(void **state)
{
    (void)state;
    sensor_step(&s);
    assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
    sensor_expect(&s, "still measured", FZM1_BUSY, FZM1_BUSY);
    assert_int_equal(sensor_command(&s, FZM1_END_CONTINUOUS, 0, 0, 0, NULL), 0);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    assert_int_equal(signal_number(&s.w, "measurements"), 1);
    assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
    assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
    assert_int_equal(sensor_command(&s, FZM1_END_CONTINUOUS, 0, 0, 0, NULL), 0);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    assert_int_equal(signal_number(&s.w, "exes_ignored"), 0);
}

/* After a switch of the scene: its response first, then that of Clear, whose FLG follows. */
static void one_behind_the_other(void **state)
{
    (void)state;
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 3, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_set(&s, FZM1_EXE, false);
    sensor_prepare(&s, FZM1_CLEAR, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 100 * MS);
    sensor_expect(&s, "switched, no FLG for it", FZM1_FLG | FZM1_BUSY, 0);
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_SWITCH_SCENE);
    assert_int_equal(signal_number(&s.w, "scene"), 3);
    assert_int_equal(sensor_until(&s, FZM1_FLG, FZM1_FLG), 1 * MS);
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_CLEAR);
    sensor_set(&s, FZM1_EXE, false);
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 4, 0, 0);
    for (int i = 0; i < 3; i++) { /* the third has to stay outside */
        sensor_set(&s, FZM1_EXE, true);
        sensor_set(&s, FZM1_EXE, false);
        sensor_prepare(&s, FZM1_END_CONTINUOUS, 0, 0, 0);
    }
    expect_text("exe_ignored_cause", "two commands");
    for (int i = 0; i < 110; i++) {
        sensor_wait(&s, 1 * MS);
        sensor_expect(&s, "EXE is off, so is FLG", FZM1_FLG, 0);
    }
    assert_int_equal(ect_load_le32(s.in + 4), FZM1_END_CONTINUOUS);
}

static void restart_at_once(void **state)
{
    (void)state;
    signal_set(&s.w, "switch_time", "60000000");
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 3, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_set(&s, FZM1_EXE, false);
    sensor_prepare(&s, FZM1_CLEAR, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_set(&s, FZM1_EXE, false);
    sensor_prepare(&s, FZM1_RESTART, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 1 * MS);
    sensor_expect(&s, "restarting", 0xFFFFFFFF, 0);
    sensor_set(&s, FZM1_EXE, false);
    sensor_prepare(&s, FZM1_CLEAR, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    expect_text("exe_ignored_cause", "restarts");
    sensor_wait(&s, 19 * MS);
    sensor_expect(&s, "restarting", 0xFFFFFFFF, 0);
}

/* Each EXE that begins no command, and each -1, is counted with its cause. */
static void causes_of_ignored_commands(void **state)
{
    static const struct {
        uint32_t code;
        int32_t p1, p2, p3;
        const char *why;
    } rows[] = {{0x00402000, 0, 0, 0, "no such command code"},
                {FZM1_SWITCH_SCENE, 128, 0, 0, "no such scene"},
                {FZM1_SWITCH_GROUP, 32, 0, 0, "no such scene group"},
                {FZM1_GET_UNIT_DATA, 4, 0, 0, "no such unit"},
                {FZM1_GET_UNIT_DATA, 3, 13, 0, "no data of this number"},
                {FZM1_GET_UNIT_DATA, 2, 5, 0, "not Fieldbus Data Output"},
                {FZM1_SET_UNIT_DATA, 2, 150, 1000, "not Fieldbus Data Output"},
                {FZM1_SET_UNIT_DATA, 3, 5, 1000, "only the output format"},
                {FZM1_SET_UNIT_DATA, 3, 150, 1, "0 or 1000"},
                {FZM1_START_CONTINUOUS, 0, 0, 0, "RUN window"}};
    static const char *const busy[] = {"a measurement runs", "a continuous measurement runs", "another command"};
    (void)state;
    signal_set(&s.w, "run", "0");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(sensor_command(&s, rows[i].code, rows[i].p1, rows[i].p2, rows[i].p3, NULL), (uint32_t)NG);
        assert_int_equal(signal_number(&s.w, "commands_refused"), i + 1);
        expect_text("command_refused_cause", rows[i].why);
    }
    signal_set(&s.w, "run", "1");
    for (unsigned int i = 0; i < 3; i++) {
        if (i == 0)
            sensor_step(&s);
        else if (i == 1)
            assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
        sensor_prepare(&s, i < 2 ? FZM1_GET_SCENE : FZM1_GET_GROUP, 0, 0, 0);
        for (unsigned int n = 0; n <= i / 2; n++) {
            sensor_set(&s, FZM1_EXE, true);
            sensor_set(&s, FZM1_EXE, false);
        }
        assert_int_equal(signal_number(&s.w, "exes_ignored"), i + 1);
        expect_text("exe_ignored_cause", busy[i]);
        if (i == 1)
            assert_int_equal(sensor_command(&s, FZM1_END_CONTINUOUS, 0, 0, 0, NULL), 0);
        (void)sensor_until(&s, FZM1_BUSY, 0);
    }
    assert_int_equal(signal_number(&s.w, "commands_refused"), 10);
}

static void busy_while_switching(void **state)
{
    static const uint32_t codes[] = {FZM1_SWITCH_SCENE, FZM1_SWITCH_GROUP};
    enum { MASK = FZM1_BUSY | FZM1_READY | FZM1_FLG };
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        sensor_prepare(&s, codes[i], 3, 0, 0);
        sensor_set(&s, FZM1_EXE, true);
        sensor_expect(&s, "switching", MASK, FZM1_BUSY);
        sensor_set(&s, FZM1_STEP, true);
        sensor_set(&s, FZM1_STEP, false);
        assert_int_equal(sensor_until(&s, FZM1_FLG, FZM1_FLG), 100 * MS);
        sensor_expect(&s, "switched", MASK, FZM1_READY | FZM1_FLG);
        sensor_set(&s, FZM1_EXE, false);
    }
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 128, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_expect(&s, "an unknown scene is no switch", MASK, FZM1_READY);
    assert_int_equal(signal_number(&s.w, "measurements"), 0);
}

static void exe_timeout(void **state)
{
    (void)state;
    signal_set(&s.w, "exe_timeout", "100");
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    (void)sensor_until(&s, FZM1_FLG, FZM1_FLG);
    assert_int_equal(sensor_until(&s, FZM1_FLG, 0), 10000 * MS);
    sensor_expect(&s, "time-out", FZM1_ERR, FZM1_ERR);
    sensor_wait(&s, 1000 * MS);
    sensor_expect(&s, "EXE still on", FZM1_FLG, 0);
    sensor_set(&s, FZM1_EXE, false);
    assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
    sensor_expect(&s, "cleared", FZM1_ERR, 0);
}

/* No time at all between EXE and FLG; then both in one cycle. */
static void as_fast_as_it_gets(void **state)
{
    (void)state;
    signal_set(&s.w, "command_time", "0");
    for (int i = 0; i < 100; i++) {
        sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
        sensor_set(&s, FZM1_EXE, true);
        sensor_expect(&s, "at once", FZM1_FLG, FZM1_FLG);
        sensor_set(&s, FZM1_EXE, false);
        sensor_expect(&s, "at once", FZM1_FLG, 0);
        wire_advance(&s.w, MS / 4);
    }
}

static void unnamed_bits(void **state)
{
    (void)state;
    for (unsigned int bit = 0; bit < 32; bit++) {
        uint32_t mask = 1u << bit;
        if (mask == FZM1_EXE || mask == FZM1_STEP || mask == FZM1_DSA)
            continue;
        sensor_set(&s, mask, true);
        sensor_wait(&s, 10 * MS);
        sensor_expect(&s, "an unnamed bit", 0xFFFFFFFF, FZM1_READY | FZM1_RUN);
        sensor_set(&s, mask, false);
    }
}

static void leaving_op(void **state)
{
    (void)state;
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    (void)sensor_until(&s, FZM1_FLG, FZM1_FLG);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    sensor_expect(&s, "SAFEOP: no outputs, so EXE is off", FZM1_FLG, 0);
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 9, 0, 0);
    sensor_set(&s, FZM1_EXE, false);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 1000 * MS);
    sensor_expect(&s, "SAFEOP takes no outputs", FZM1_FLG | FZM1_READY | FZM1_RUN, FZM1_READY | FZM1_RUN);
    assert_int_equal(signal_number(&s.w, "scene"), 0);
}

static void scene_by_hand(void **state)
{
    int32_t scene = 0;
    char message[ECT_SIGNAL_MESSAGE] = "";
    (void)state;
    signal_set(&s.w, "scene", "12");
    signal_set(&s.w, "data1", "12"); /* the new scene's already */
    sensor_expect(&s, "switching manually", FZM1_BUSY | FZM1_READY, FZM1_BUSY);
    signal_set(&s.w, "scene_group", "3"); /* another one at once: BUSY starts again */
    signal_set(&s.w, "scene_group", "0");
    signal_set(&s.w, "scene", "12");
    signal_set(&s.w, "data1", "12");
    assert_int_equal(sensor_until(&s, FZM1_BUSY, 0), 100 * MS);
    sensor_expect(&s, "switched manually", FZM1_BUSY | FZM1_READY, FZM1_READY);
    assert_int_equal(sensor_command(&s, FZM1_GET_SCENE, 0, 0, 0, &scene), 0);
    assert_int_equal(scene, 12);
    signal_set(&s.w, "scene", "0");
    (void)sensor_until(&s, FZM1_BUSY, 0);
    measure();
    assert_int_equal(signal_number(&s.w, "result1"), 0);
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_SCENE, 12, 0, 0, NULL), 0);
    measure();
    assert_int_equal(signal_number(&s.w, "result1"), 12);
    sensor_step(&s);
    assert_false(signal_try_set(&s.w, "scene", "1", message));
    assert_non_null(strstr(message, "BUSY"));
}

/* An image that was taken and waits for its processing: READY is on, and so is BUSY. */
static void by_hand_with_an_image(void **state)
{
    static const char *const switches[] = {"scene", "scene_group"};
    (void)state;
    for (size_t i = 0; i < sizeof switches / sizeof switches[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        sensor_step(&s);
        sensor_wait(&s, 5 * MS);
        sensor_expect(&s, "the image is taken", FZM1_BUSY | FZM1_READY, FZM1_BUSY | FZM1_READY);
        assert_int_equal(signal_number(&s.w, "images"), 1);
        assert_false(signal_try_set(&s.w, switches[i], "1", message));
        assert_non_null(strstr(message, "BUSY"));
        (void)sensor_until(&s, FZM1_BUSY, 0);
        signal_set(&s.w, switches[i], "1");
        assert_int_equal(signal_number(&s.w, switches[i]), 1);
        (void)sensor_until(&s, FZM1_BUSY, 0);
    }
}

static void levels_as_signals(void **state)
{
    static const struct {
        uint32_t level;
        const char *signal;
    } rows[] = {{FZM1_EXE, "exe"}, {FZM1_STEP, "step"}, {FZM1_DSA, "dsa"}};
    const size_t many = sizeof rows / sizeof rows[0];
    (void)state;
    for (size_t i = 0; i < many; i++) {
        for (unsigned int change = 0; change < 2; change++) {
            bool on = change == 0;
            sensor_set(&s, rows[i].level, on);
            for (size_t n = 0; n < many; n++) {
                if (signal_number(&s.w, rows[n].signal) != (n == i && on))
                    fail_msg("%s from the master is %u: %s is %lld", rows[i].signal, on, rows[n].signal,
                             signal_number(&s.w, rows[n].signal));
            }
        }
    }
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-033 FZM-034 FZM-035 FZM-051 FZM-055 FZM-056 FZM-057 FZM-058 FZM-060 FZM-061 FZM-062 OM-C5 OM-C8 "
             "OM-C11: "
             "every command, its response, and its refusals with -1",
             every_command),
        TEST("FZM-050 FZM-051 OM-C2: command codes are two words, the lower at +2; the echo repeats them",
             codes_on_the_wire),
        TEST("FZM-040 FZM-043 FZM-070: FLG is set with the stored response and cleared with EXE", handshake),
        TEST("FZM-070: code and parameters have their values at the rising edge of EXE", parameters_at_the_edge),
        TEST("FZM-043: EXE that falls early: the command is executed, FLG is not set", exe_falls_early),
        TEST("FZM-043 FZM-070: a second EXE while a command is executed begins no second one", second_exe),
        TEST("FZM-044: EXE that rises while BUSY is ignored until it falls", busy_ignores),
        TEST("FZM-052 FZM-054 FZM-055: Clear and End continuous are accepted while BUSY", taken_at_any_time),
        TEST("FZM-043 FZM-054 FZM-055: Clear and End continuous after another command: one response after the other",
             one_behind_the_other),
        TEST("FZM-052: Restart does not wait for the command that is executed", restart_at_once),
        TEST("FZM-040 FZM-062: each EXE that begins nothing and each -1 is counted, with its cause",
             causes_of_ignored_commands),
        TEST("FZM-044 FZM-059: BUSY while scene or group are switched, and STEP is not accepted", busy_while_switching),
        TEST("FZM-043: with exe_timeout set, EXE that stays on 10 s after FLG is an error", exe_timeout),
        TEST("FZM-075: handshakes in every cycle of 250 us", as_fast_as_it_gets),
        TEST("FZM-036 FZM-037 FZM-038: unnamed bits are ignored, and read 0", unnamed_bits),
        TEST("FZM-003 FZM-004: outputs are used only in OP; the end of OP clears EXE", leaving_op),
        TEST(
            "FZM-044 FZM-057 FZM-058 FZM-059: a scene switched manually is the current one, with data of its own; BUSY "
            "while it is switched",
            scene_by_hand),
        TEST("FZM-044 FZM-057 FZM-058: no manual switch while an image waits for its processing",
             by_hand_with_an_image),
        TEST("FZM-040 FZM-041 FZM-042: exe, step and dsa each show their level from the master", levels_as_signals),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 commands", tests, NULL, NULL);
}
