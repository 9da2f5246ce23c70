/* SPDX-License-Identifier: MIT */
/* DSA, GATE and the output area, with and without handshaking (Q179 §3-2, §4-1, §4-4). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/sensor.h"

static sensor_t s;

static int setup(void **state)
{
    (void)state;
    sensor_open(&s);
    return 0;
}

static int setup_handshaking(void **state)
{
    setup(state);
    signal_set(&s.w, "output_control", "1");
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    sensor_close(&s);
    return 0;
}

/* A measurement of this value, at once. */
static void measure(int value)
{
    char text[16];
    snprintf(text, sizeof text, "%d", value);
    signal_set(&s.w, "data1", text);
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
}

static void expect_cause(const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&s.w, "error_cause", text);
    if (*want ? !strstr(text, want) : *text)
        fail_msg("error_cause: expected '%s', got '%s'", want, text);
    sensor_expect(&s, "ERR with a cause", FZM1_ERR, *want ? FZM1_ERR : 0);
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static void fixed_point(void **state)
{
    static const struct {
        double value;
        int32_t want;
    } rows[] = {{0, 0},
                {1, 1000},
                {-1, -1000},
                {12.345, 12345},
                {-12.345, -12345},
                {0.0019, 1},
                {-0.0019, -1},
                {0.0009, 0},
                {1.0006, 1000},
                {2147483.647, INT32_MAX},
                {2147483.646, 2147483646},
                {2147483.648, INT32_MAX},
                {-2147483.648, INT32_MIN},
                {-2147483.649, INT32_MIN},
                {999999999, INT32_MAX},
                {-999999999, INT32_MIN},
                {INFINITY, INT32_MAX},
                {-INFINITY, INT32_MIN},
                {NAN, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int32_t got = fzm1_fixed_point(rows[i].value);
        if (got != rows[i].want)
            fail_msg("%.9g: expected %d, got %d", rows[i].value, rows[i].want, got);
    }
}

static void all_eight(void **state)
{
    (void)state;
    char name[16], value[16];
    for (int n = 1; n <= 8; n++) {
        snprintf(name, sizeof name, "data%d", n);
        snprintf(value, sizeof value, "%d.25", n * 11);
        signal_set(&s.w, name, value);
    }
    for (unsigned int floating = 0; floating < 2; floating++) {
        signal_set(&s.w, "output_format", floating ? "1" : "0");
        sensor_step(&s);
        (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
        for (unsigned int n = 1; n <= 8; n++) {
            float single = (float)n * 11 + 0.25f;
            int32_t bits;
            memcpy(&bits, &single, sizeof bits);
            assert_int_equal(sensor_data(&s, n), floating ? bits : (int32_t)n * 11000 + 250);
        }
        (void)sensor_until(&s, FZM1_BUSY | FZM1_GATE, 0);
    }
}

static void format_by_command(void **state)
{
    (void)state;
    assert_int_equal(sensor_command(&s, FZM1_SET_UNIT_DATA, 3, 150, 1000, NULL), 0);
    measure(3);
    float single = 3;
    int32_t bits;
    memcpy(&bits, &single, sizeof bits);
    assert_int_equal(sensor_data(&s, 1), bits);
    assert_int_equal(sensor_command(&s, FZM1_SET_UNIT_DATA, 3, 150, 0, NULL), 0);
    assert_int_equal(sensor_data(&s, 1), bits); /* the area keeps its content */
}

/* --- without handshaking ------------------------------------------------------------------------------------------ */

static void one_pulse(void **state)
{
    (void)state;
    sensor_step(&s);
    assert_int_equal(sensor_until(&s, FZM1_GATE, FZM1_GATE), 25 * MS);
    sensor_expect(&s, "with the end of the measurement", FZM1_BUSY, 0);
    assert_int_equal(sensor_until(&s, FZM1_GATE, 0), 5 * MS);
    for (int i = 0; i < 100; i++) {
        sensor_wait(&s, 5 * MS);
        sensor_expect(&s, "one output a measurement", FZM1_GATE, 0);
    }
}

static void period(void **state)
{
    static const struct {
        const char *period, *time;
        uint64_t period_ns, time_ns;
    } rows[] = {{"100", "50", 10 * MS, 5 * MS},
                {"20", "10", 2 * MS, 1 * MS},
                {"50000", "10000", 5000 * MS, 1000 * MS},
                {"33", "32", 3300000, 3200000}};
    (void)state;
    signal_set(&s.w, "image_input", "100");
    signal_set(&s.w, "processing", "100");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        (void)sensor_wait(&s, 6000 * MS);
        signal_set(&s.w, "output_time", "10");
        signal_set(&s.w, "output_period", rows[i].period);
        signal_set(&s.w, "output_time", rows[i].time);
        for (int n = 1; n <= 4; n++) {
            char value[16];
            snprintf(value, sizeof value, "%d", n);
            signal_set(&s.w, "data1", value);
            sensor_step(&s);
            sensor_wait(&s, MS / 10);
        }
        for (int n = 1; n <= 4; n++) {
            uint64_t off = sensor_until(&s, FZM1_GATE, FZM1_GATE);
            if (n > 1)
                assert_int_equal(off, rows[i].period_ns - rows[i].time_ns);
            assert_int_equal(sensor_data(&s, 1), n * 1000);
            uint64_t on = sensor_until(&s, FZM1_GATE, 0);
            if (n > 1)
                assert_int_equal(on, rows[i].time_ns);
            assert_int_equal(sensor_data(&s, 1), n * 1000); /* until the next output */
        }
    }
}

static void repeated(void **state)
{
    (void)state;
    measure(7);
    (void)sensor_until(&s, FZM1_GATE, 0);
    signal_set(&s.w, "output_period", "50000");
    measure(7);
    signal_set(&s.w, "output_period", "100"); /* counts at once */
    assert_in_range(sensor_until(&s, FZM1_GATE, FZM1_GATE), 0, 10 * MS);
    (void)sensor_until(&s, FZM1_GATE, 0);
    signal_set(&s.w, "output_repeat", "1");
    long long before = signal_number(&s.w, "outputs");
    sensor_wait(&s, 1000 * MS);
    assert_in_range(signal_number(&s.w, "outputs") - before, 99, 101);
    assert_int_equal(sensor_data(&s, 1), 7000);
    assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
    (void)sensor_until(&s, FZM1_GATE, 0);
    before = signal_number(&s.w, "outputs");
    sensor_wait(&s, 1000 * MS);
    assert_int_equal(signal_number(&s.w, "outputs"), before);
}

static void period_by_sdo(void **state)
{
    static const uint8_t tenth[2] = {100, 0}; /* 10 ms */
    (void)state;
    signal_set(&s.w, "output_period", "50000");
    measure(6);
    (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
    (void)sensor_until(&s, FZM1_GATE, 0);
    measure(7);
    sensor_expect(&s, "the next output is due after seconds", FZM1_GATE, 0);
    const uint64_t from_ns = s.w.now_ns;
    assert_int_equal(wire_sdo_download(&s.w, 0, 0x2400, 2, false, tenth, sizeof tenth), 0);
    (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
    assert_in_range(s.w.now_ns - from_ns, 9 * MS, 12 * MS);
    assert_int_equal(sensor_data(&s, 1), 7000);
}

static void time_below_period(void **state)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    (void)state;
    assert_false(signal_try_set(&s.w, "output_time", "100", message));
    assert_non_null(strstr(message, "shorter than the period"));
    assert_false(signal_try_set(&s.w, "output_period", "50", message));
    signal_set(&s.w, "output_time", "99");
    signal_set(&s.w, "output_period", "101");
    static const struct {
        const char *name, *value;
    } rows[] = {{"output_period", "19"}, {"output_period", "50001"}, {"output_time", "9"},   {"output_time", "10001"},
                {"timeout", "4"},        {"timeout", "1201"},        {"output_control", "2"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_false(signal_try_set(&s.w, rows[i].name, rows[i].value, message));
}

/* Measurements are faster than outputs: the newest are lost, and nothing else is delayed. */
static void too_fast(void **state)
{
    (void)state;
    signal_set(&s.w, "image_input", "100");
    signal_set(&s.w, "processing", "100");
    signal_set(&s.w, "output_period", "1000");
    sensor_wait(&s, 100 * MS);
    for (int n = 1; n <= 60; n++) {
        sensor_expect(&s, "READY for each", FZM1_READY | FZM1_BUSY, FZM1_READY);
        measure(n);
    }
    assert_int_equal(signal_number(&s.w, "measurements"), 60);
    assert_int_equal(signal_number(&s.w, "lost"), 43); /* one is shown, 16 wait */
    expect_cause("results lost");
    for (int32_t n = 1; n <= 17; n++) {
        sensor_expect(&s, "until all have been output", FZM1_ERR, n < 17 ? FZM1_ERR : 0);
        assert_int_equal(sensor_data(&s, 1), n * 1000);
        (void)sensor_until(&s, FZM1_GATE, 0);
        if (n < 17)
            (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
    }
    expect_cause("");
    sensor_wait(&s, 1000 * MS);
    assert_int_equal(signal_number(&s.w, "outputs"), 17);
}

/* --- with handshaking --------------------------------------------------------------------------------------------- */

static void handshake(void **state)
{
    (void)state;
    measure(5);
    sensor_expect(&s, "waits for DSA", FZM1_GATE, 0);
    assert_int_equal(sensor_data(&s, 1), 0);
    sensor_set(&s, FZM1_DSA, true);
    sensor_expect(&s, "DSA on", FZM1_GATE, FZM1_GATE);
    assert_int_equal(sensor_data(&s, 1), 5000);
    sensor_wait(&s, 9000 * MS);
    sensor_expect(&s, "GATE stays as long as DSA", FZM1_GATE, FZM1_GATE);
    sensor_set(&s, FZM1_DSA, false);
    sensor_expect(&s, "DSA off", FZM1_GATE | FZM1_ERR, 0);
    assert_int_equal(sensor_data(&s, 1), 5000);
    sensor_set(&s, FZM1_DSA, true);
    sensor_wait(&s, 60000 * MS);
    sensor_expect(&s, "nothing new to output", FZM1_GATE | FZM1_ERR, 0);
}

static void dsa_first(void **state)
{
    (void)state;
    sensor_set(&s, FZM1_DSA, true);
    sensor_step(&s);
    assert_int_equal(sensor_until(&s, FZM1_GATE, FZM1_GATE), 25 * MS);
    sensor_set(&s, FZM1_DSA, false);
    sensor_expect(&s, "DSA off", FZM1_GATE, 0);
}

static void several_pending(void **state)
{
    (void)state;
    for (int n = 1; n <= 5; n++)
        measure(n);
    for (int n = 1; n <= 5; n++) {
        assert_int_equal(signal_number(&s.w, "pending"), 6 - n);
        sensor_set(&s, FZM1_DSA, true);
        sensor_expect(&s, "DSA on", FZM1_GATE, FZM1_GATE);
        assert_int_equal(sensor_data(&s, 1), n * 1000);
        sensor_exchange(&s);
        assert_int_equal(sensor_data(&s, 1), n * 1000); /* one DSA, one output */
        sensor_set(&s, FZM1_DSA, false);
        sensor_expect(&s, "DSA off", FZM1_GATE, 0);
    }
}

static void timeout(void **state)
{
    static const struct {
        const char *timeout;
        uint64_t ns;
    } rows[] = {{"5", 500 * MS}, {"100", 10000 * MS}, {"1200", 120000 * MS}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        signal_set(&s.w, "timeout", rows[i].timeout);
        long long discarded = signal_number(&s.w, "discarded");
        measure(1);
        sensor_wait(&s, rows[i].ns - 1);
        sensor_expect(&s, "just before the timeout", FZM1_ERR, 0);
        sensor_wait(&s, 1);
        sensor_expect(&s, "timeout", FZM1_ERR | FZM1_GATE, FZM1_ERR);
        expect_cause("no DSA");
        assert_int_equal(signal_number(&s.w, "discarded"), discarded + 1);
        assert_int_equal(signal_number(&s.w, "pending"), 0);
        measure(2);
        sensor_expect(&s, "still", FZM1_ERR, FZM1_ERR);
        sensor_set(&s, FZM1_DSA, true);
        sensor_expect(&s, "the next result is output", FZM1_GATE, FZM1_GATE);
        assert_int_equal(sensor_data(&s, 1), 2000);
        sensor_set(&s, FZM1_DSA, false);
        sensor_expect(&s, "normal again", FZM1_ERR | FZM1_GATE, 0);
    }
}

static void each_result_has_its_time(void **state)
{
    (void)state;
    measure(1);
    measure(2);
    sensor_wait(&s, 15000 * MS);
    assert_int_equal(signal_number(&s.w, "discarded"), 1);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(sensor_data(&s, 1), 2000);
}

static void dsa_does_not_fall(void **state)
{
    (void)state;
    measure(1);
    measure(2);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(sensor_until(&s, FZM1_GATE, 0), 10000 * MS);
    expect_cause("DSA stayed on");
    assert_int_equal(sensor_data(&s, 1), 1000);
    sensor_set(&s, FZM1_DSA, false);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(sensor_data(&s, 1), 2000);
}

static void error_is_cleared(void **state)
{
    static const char *const ways[] = {"clear", "2401h", "hand"};
    (void)state;
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        const uint8_t one = 1;
        measure(1);
        (void)sensor_until(&s, FZM1_ERR, FZM1_ERR);
        if (i == 0)
            assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
        else if (i == 1)
            assert_int_equal(wire_sdo_download(&s.w, 0, 0x2401, 0, false, &one, 1), 0);
        else
            signal_set(&s.w, "err", "0");
        wire_advance(&s.w, MS);
        sensor_expect(&s, ways[i], FZM1_ERR, 0);
    }
}

/* In OP by SDO, after a pause in which nothing happened: GATE is off before it rises again. */
static void control_by_sdo(void **state)
{
    const uint8_t none = 0, handshaking = 1;
    (void)state;
    measure(1);
    sensor_wait(&s, 5000 * MS);
    sensor_set(&s, FZM1_DSA, true);
    sensor_wait(&s, 5000 * MS);
    measure(2);
    assert_int_equal(wire_sdo_download(&s.w, 0, 0x2400, 1, false, &none, 1), 0);
    wire_poll(&s.w);
    sensor_expect(&s, "without handshaking", FZM1_GATE, 0);
    assert_int_equal(sensor_until(&s, FZM1_GATE, FZM1_GATE), 5 * MS);
    assert_int_equal(sensor_data(&s, 1), 2000);
    assert_int_equal(wire_sdo_download(&s.w, 0, 0x2400, 1, false, &handshaking, 1), 0);
    wire_poll(&s.w);
    sensor_expect(&s, "with handshaking", FZM1_GATE, 0);
}

static void control_changes(void **state)
{
    (void)state;
    measure(1);
    signal_set(&s.w, "output_control", "0");
    assert_int_equal(sensor_until(&s, FZM1_GATE, FZM1_GATE), 5 * MS); /* what waited is output without handshaking */
    assert_int_equal(sensor_data(&s, 1), 1000);
    measure(2);
    (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
    signal_set(&s.w, "output_control", "0"); /* as it is */
    sensor_expect(&s, "nothing has changed", FZM1_GATE, FZM1_GATE);
    signal_set(&s.w, "output_control", "1");
    sensor_expect(&s, "handshaking begins with GATE off", FZM1_GATE, 0);
}

/* DSA was on for one result when the control is set to its present value: DSA does not fetch the next result. */
static void control_stays(void **state)
{
    (void)state;
    measure(1);
    measure(2);
    sensor_set(&s, FZM1_DSA, true);
    signal_set(&s.w, "output_control", "1");
    sensor_expect(&s, "GATE stays", FZM1_GATE, FZM1_GATE);
    assert_int_equal(sensor_data(&s, 1), 1000);
    signal_set(&s.w, "output_control", "0");
    signal_set(&s.w, "output_control", "1");
    sensor_expect(&s, "DSA still belongs to the first result", FZM1_GATE, 0);
    assert_int_equal(sensor_data(&s, 1), 1000);
    sensor_set(&s, FZM1_DSA, false);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(sensor_data(&s, 1), 2000);
}

/* The handshake is selected during a pulse of 5 ms: the end of this pulse is not part of the handshake. */
static void pulse_from_before(void **state)
{
    (void)state;
    signal_set(&s.w, "image_input", "100");
    signal_set(&s.w, "processing", "100");
    signal_set(&s.w, "output_control", "0");
    measure(1);
    (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
    signal_set(&s.w, "output_control", "1");
    measure(2);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(sensor_data(&s, 1), 2000);
    for (unsigned int ms = 0; ms < 20; ms++) {
        sensor_expect(&s, "DSA is on", FZM1_GATE, FZM1_GATE);
        sensor_wait(&s, MS);
    }
}

/* A result waits when the handshake is selected, and no outputs follow. */
static void time_out_begins_with_handshake(void **state)
{
    (void)state;
    signal_set(&s.w, "output_period", "50000");
    signal_set(&s.w, "output_control", "0");
    measure(1);
    assert_int_equal(signal_number(&s.w, "pending"), 1);
    signal_set(&s.w, "output_control", "1");
    assert_int_equal(sensor_until(&s, FZM1_ERR, FZM1_ERR), 10000 * MS);
}

/* DSA goes on without handshaking: it has been on since before the first result of the handshake. */
static void dsa_from_before(void **state)
{
    (void)state;
    signal_set(&s.w, "output_control", "0");
    sensor_set(&s, FZM1_DSA, true);
    signal_set(&s.w, "output_control", "1");
    measure(1);
    sensor_expect(&s, "the level is no request", FZM1_GATE, 0);
    assert_int_equal(signal_number(&s.w, "pending"), 1);
    sensor_set(&s, FZM1_DSA, false);
    sensor_set(&s, FZM1_DSA, true);
    sensor_expect(&s, "the edge is", FZM1_GATE, FZM1_GATE);
    assert_int_equal(sensor_data(&s, 1), 1000);
}

static void format_of_the_measurement(void **state)
{
    (void)state;
    measure(2);
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_SCENE, 1, 0, 0, NULL), 0);
    signal_set(&s.w, "output_format", "1");
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(sensor_data(&s, 1), 2000); /* measured in scene 0, fixed point */
}

static void clear_takes_back(void **state)
{
    (void)state;
    measure(1);
    measure(2);
    assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
    assert_int_equal(signal_number(&s.w, "pending"), 0);
    assert_int_equal(signal_number(&s.w, "discarded"), 2);
    sensor_set(&s, FZM1_DSA, true);
    sensor_wait(&s, 20000 * MS);
    sensor_expect(&s, "no output, no error", FZM1_GATE | FZM1_ERR, 0);
    measure(3);
    assert_int_equal(sensor_data(&s, 1), 3000);
}

/* Several causes at a time: each is listed, and each ends on its own. */
static void causes_together(void **state)
{
    (void)state;
    signal_set(&s.w, "err", "1");
    for (int n = 1; n <= 17; n++)
        measure(n);
    expect_cause("results lost: 16 wait already; set manually");
    (void)sensor_wait(&s, 10000 * MS);
    expect_cause("no DSA; results lost: 16 wait already; set manually");
    for (int n = 2; n <= 16; n++) {
        sensor_set(&s, FZM1_DSA, true);
        assert_int_equal(sensor_data(&s, 1), n * 1000);
        sensor_set(&s, FZM1_DSA, false);
    }
    expect_cause("set manually");
    signal_set(&s.w, "err", "0");
    expect_cause("");
}

/* Outputs from before OP are no request, and no timeout runs without OP. */
static void dsa_level_at_start(void **state)
{
    (void)state;
    measure(1);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    sensor_wait(&s, 30000 * MS);
    sensor_expect(&s, "no time-out outside OP", FZM1_ERR | FZM1_GATE, 0);
    ect_store_le32(s.out, FZM1_DSA);
    sensor_exchange(&s);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    sensor_exchange(&s);
    sensor_wait(&s, 10000 * MS - 1);
    sensor_expect(&s, "the level is no request", FZM1_ERR | FZM1_GATE, 0);
    sensor_set(&s, FZM1_DSA, false);
    sensor_set(&s, FZM1_DSA, true);
    sensor_expect(&s, "the edge is", FZM1_ERR | FZM1_GATE, FZM1_GATE);
    assert_int_equal(sensor_data(&s, 1), 1000);
}

static void time_out_begins_with_op(void **state)
{
    (void)state;
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    signal_set(&s.w, "trigger", "1");
    sensor_wait(&s, 30000 * MS);
    sensor_exchange(&s);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    sensor_exchange(&s);
    assert_int_equal(sensor_until(&s, FZM1_ERR, FZM1_ERR), 10000 * MS);
}

/* OP ends while GATE is on: the master that has read GATE no longer exists. */
static void gate_ends_with_op(void **state)
{
    (void)state;
    measure(1);
    measure(2);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    sensor_expect(&s, "SAFEOP", FZM1_GATE, 0);
    sensor_wait(&s, 30000 * MS);
    sensor_expect(&s, "SAFEOP", FZM1_GATE | FZM1_ERR, 0);
    assert_int_equal(signal_number(&s.w, "pending"), 1);
}

/* A handshake clears only the error of a missing handshake: a manual error, or an error of a command, stays. */
static void errors_apart(void **state)
{
    (void)state;
    signal_set(&s.w, "err", "1");
    measure(1);
    sensor_set(&s, FZM1_DSA, true);
    sensor_set(&s, FZM1_DSA, false);
    sensor_expect(&s, "set manually", FZM1_ERR, FZM1_ERR);
    signal_set(&s.w, "err", "0");
    signal_set(&s.w, "exe_timeout", "10");
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    (void)sensor_until(&s, FZM1_ERR, FZM1_ERR);
    measure(2);
    sensor_set(&s, FZM1_DSA, true);
    sensor_set(&s, FZM1_DSA, false);
    sensor_expect(&s, "EXE is still on", FZM1_ERR, FZM1_ERR);
    sensor_set(&s, FZM1_EXE, false);
    sensor_expect(&s, "EXE is off, and no command has followed", FZM1_ERR, FZM1_ERR);
    assert_int_equal(sensor_command(&s, FZM1_GET_SCENE, 0, 0, 0, NULL), 0);
    sensor_expect(&s, "a command as it should be", FZM1_ERR, 0);
    measure(3);
    (void)sensor_until(&s, FZM1_ERR, FZM1_ERR);
    measure(4);
    sensor_set(&s, FZM1_DSA, true);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    sensor_expect(&s, "the end of OP is no handshake", FZM1_ERR | FZM1_GATE, FZM1_ERR);
}

static void sixteen_wait(void **state)
{
    (void)state;
    signal_set(&s.w, "timeout", "1200");
    for (int n = 1; n <= 20; n++) {
        measure(n);
        sensor_expect(&s, "BUSY and READY are independent of it", FZM1_BUSY | FZM1_READY | FZM1_ERR,
                      n <= 16 ? FZM1_READY : FZM1_READY | FZM1_ERR);
    }
    assert_int_equal(signal_number(&s.w, "measurements"), 20);
    assert_int_equal(signal_number(&s.w, "pending"), 16);
    assert_int_equal(signal_number(&s.w, "lost"), 4);
    for (int n = 1; n <= 16; n++) {
        sensor_expect(&s, "until all have been fetched", FZM1_ERR, FZM1_ERR);
        sensor_set(&s, FZM1_DSA, true);
        assert_int_equal(sensor_data(&s, 1), n * 1000);
        sensor_set(&s, FZM1_DSA, false);
    }
    expect_cause("");
}

/* Every command has its FLG while 16 results wait. */
static void commands_with_a_full_queue(void **state)
{
    static const uint32_t codes[] = {FZM1_GET_SCENE,      FZM1_GET_UNIT_DATA, FZM1_START_CONTINUOUS,
                                     FZM1_END_CONTINUOUS, FZM1_SWITCH_SCENE,  FZM1_SWITCH_GROUP,
                                     FZM1_CLEAR};
    (void)state;
    signal_set(&s.w, "timeout", "1200");
    for (int n = 1; n <= 17; n++)
        measure(n);
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++) {
        uint64_t before = s.w.now_ns;
        (void)sensor_until(&s, FZM1_BUSY, codes[i] == FZM1_END_CONTINUOUS ? FZM1_BUSY : 0);
        assert_int_equal(sensor_command(&s, codes[i], 0, 0, 0, NULL), 0);
        assert_in_range(s.w.now_ns - before, 0, 126 * MS);
    }
    assert_int_equal(signal_number(&s.w, "pending"), 0);
    expect_cause("");
}

#define TEST(title, function)        {title, function, setup, teardown, NULL}
#define HANDSHAKING(title, function) {title, function, setup_handshaking, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-031 FZM-032 OM-C6: fixed point is the integer part of a thousandfold, clamped at 32 bits",
             fixed_point),
        TEST("FZM-030 FZM-031 FZM-039: data 1 to 8, fixed point and single precision", all_eight),
        TEST("FZM-035: unit data 150 changes the format of the next output", format_by_command),
        TEST("FZM-026 FZM-028 FZM-069: None: one GATE of 5 ms a measurement", one_pulse),
        TEST("FZM-027 FZM-028 FZM-073: None: period and time to the microsecond, data stable while GATE is on", period),
        TEST("FZM-073: None with output_repeat: the last data every period", repeated),
        TEST("FZM-028 FZM-073: a new period by SDO counts from then on", period_by_sdo),
        TEST("FZM-027 FZM-028 FZM-029 OM-C13: ranges, and the output time stays below the period", time_below_period),
        TEST("FZM-048 FZM-066 FZM-069 FZM-073: None: measurements faster than the output: the newest are lost and "
             "counted, "
             "ERR shows it, BUSY is unaffected",
             too_fast),
        HANDSHAKING("FZM-042 FZM-045 FZM-071: data with DSA, GATE until DSA falls", handshake),
        HANDSHAKING("FZM-071: DSA may be on before there are data", dsa_first),
        HANDSHAKING("FZM-071: each DSA reads the next of several results", several_pending),
        HANDSHAKING("FZM-029 FZM-048 FZM-072: no DSA within the timeout: ERR, the result is dropped", timeout),
        HANDSHAKING("FZM-072: each waiting result has its own timeout", each_result_has_its_time),
        HANDSHAKING("FZM-072: DSA that does not fall is a timeout too", dsa_does_not_fall),
        HANDSHAKING("FZM-048: ERR is cleared by Clear, by 2401h and manually", error_is_cleared),
        HANDSHAKING("FZM-026 FZM-071: setting the output control to its present value changes nothing", control_stays),
        HANDSHAKING("FZM-026 FZM-071: DSA that rose before the selection of the handshake is no request",
                    dsa_from_before),
        HANDSHAKING("FZM-026 FZM-045: GATE of a handshake continues after the end of the pulse that it replaced",
                    pulse_from_before),
        HANDSHAKING("FZM-026 FZM-072: the timeout of DSA begins with the selection of the handshake",
                    time_out_begins_with_handshake),
        HANDSHAKING("FZM-031: a result is output in the format of its measurement", format_of_the_measurement),
        HANDSHAKING("FZM-055 FZM-072: Clear discards waiting results", clear_takes_back),
        HANDSHAKING("FZM-048: each error is ended by its own handshake", errors_apart),
        HANDSHAKING("FZM-026 FZM-045: the output control changes in OP, by SDO: GATE is off in between",
                    control_by_sdo),
        HANDSHAKING("FZM-026: the output control may change while a result waits", control_changes),
        HANDSHAKING("FZM-066 FZM-069 FZM-071: sixteen results wait, the newest beyond them are lost and counted",
                    sixteen_wait),
        HANDSHAKING("FZM-043 FZM-055 FZM-069: commands do not wait for the data output", commands_with_a_full_queue),
        HANDSHAKING("FZM-048: several errors at a time, each with its cause and its end", causes_together),
        HANDSHAKING("FZM-004 FZM-071: DSA that is on when OP begins is no request", dsa_level_at_start),
        HANDSHAKING("FZM-004 FZM-072: the timeout of DSA begins with OP", time_out_begins_with_op),
        HANDSHAKING("FZM-004 FZM-045: GATE ends with OP", gate_ends_with_op),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 data output", tests, NULL, NULL);
}
