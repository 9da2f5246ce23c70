/* SPDX-License-Identifier: MIT */
/* Measurement by STEP and continuously, READY, BUSY, OR, and the measured values (Q179 §4-2, §4-4). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/sensor.h"

enum { MASK = FZM1_READY | FZM1_BUSY };

static sensor_t s;

static int setup(void **state)
{
    (void)state;
    sensor_open(&s);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    sensor_close(&s);
    return 0;
}

static long long measurements(void)
{
    return signal_number(&s.w, "measurements");
}

static void power_on(void **state)
{
    (void)state;
    sensor_expect(&s, "after power-on", 0xFFFFFFFF, FZM1_READY | FZM1_RUN);
}

static void one_step(void **state)
{
    (void)state;
    sensor_set(&s, FZM1_STEP, true);
    sensor_expect(&s, "STEP on", MASK, FZM1_BUSY);
    assert_int_equal(sensor_until(&s, FZM1_READY, FZM1_READY), 5 * MS);
    sensor_expect(&s, "image taken", MASK, MASK);
    sensor_set(&s, FZM1_STEP, false);
    assert_int_equal(sensor_until(&s, FZM1_BUSY, 0), 20 * MS);
    assert_int_equal(measurements(), 1);
    sensor_expect(&s, "measured", MASK, FZM1_READY);
}

static void edge_not_level(void **state)
{
    (void)state;
    sensor_set(&s, FZM1_STEP, true);
    sensor_wait(&s, 1000 * MS);
    assert_int_equal(measurements(), 1);
    for (int i = 0; i < 10; i++) {
        sensor_exchange(&s);
        sensor_wait(&s, 100 * MS);
    }
    assert_int_equal(measurements(), 1);
    sensor_set(&s, FZM1_STEP, false);
    sensor_wait(&s, 100 * MS);
    assert_int_equal(measurements(), 1);
    sensor_set(&s, FZM1_STEP, true);
    sensor_wait(&s, 100 * MS);
    assert_int_equal(measurements(), 2);
}

static void not_ready(void **state)
{
    (void)state;
    sensor_step(&s);
    sensor_wait(&s, 2 * MS);
    sensor_set(&s, FZM1_STEP, true); /* during image input: not accepted, and not later either */
    sensor_wait(&s, 100 * MS);
    assert_int_equal(measurements(), 1);
    sensor_expect(&s, "no error from it", FZM1_ERR | MASK, FZM1_READY);
}

static void level_at_start(void **state)
{
    (void)state;
    sensor_step(&s);
    sensor_wait(&s, 100 * MS);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    ect_store_le32(s.out, FZM1_STEP | FZM1_EXE);
    sensor_exchange(&s);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    sensor_exchange(&s);
    sensor_exchange(&s);
    sensor_wait(&s, 100 * MS);
    assert_int_equal(measurements(), 1);
    sensor_expect(&s, "levels at the start of OP start nothing", MASK | FZM1_FLG, FZM1_READY);
    static const char *const causes[] = {"step_ignored_cause", "exe_ignored_cause"};
    for (unsigned int i = 0; i < 2; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        signal_get(&s.w, causes[i], text);
        assert_non_null(strstr(text, "when OP began"));
    }
}

static void step_here(void)
{
    sensor_set(&s, FZM1_STEP, true);
    sensor_set(&s, FZM1_STEP, false);
}

static void while_image(void)
{
    step_here();
}

static void while_full(void)
{
    signal_set(&s.w, "camera", "2");
    step_here();
    sensor_wait(&s, 5 * MS);
}

static void while_switching(void)
{
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 1, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
}

static void while_continuous(void)
{
    assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
}

static void without_window(void)
{
    signal_set(&s.w, "run", "0");
}

static void while_restarting(void)
{
    signal_set(&s.w, "restart", "1");
}

/* Each reason why a STEP measures nothing, with its count and in words. */
static void causes_of_ignored_steps(void **state)
{
    static const struct {
        void (*prepare)(void);
        const char *why;
    } rows[] = {{while_image, "an image is being taken in"},     {while_full, "as many images wait"},
                {while_switching, "a scene is being switched"},  {while_continuous, "a continuous measurement"},
                {without_window, "the RUN window is not shown"}, {while_restarting, "restarts"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        teardown(state);
        setup(state);
        rows[i].prepare();
        assert_int_equal(signal_number(&s.w, "steps_ignored"), 0);
        step_here();
        assert_int_equal(signal_number(&s.w, "steps_ignored"), 1);
        signal_get(&s.w, "step_ignored_cause", text);
        if (!strstr(text, rows[i].why))
            fail_msg("expected '%s', got '%s'", rows[i].why, text);
    }
}

/* Steps as fast as READY allows; the number of waiting images when READY stays off. */
static void queue(void **state)
{
    static const struct {
        const char *camera;
        unsigned int room;
    } rows[] = {{"0", 16}, {"1", 4}, {"2", 1}};
    (void)state;
    signal_set(&s.w, "processing", "10000000");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        long long before = measurements();
        signal_set(&s.w, "camera", rows[i].camera);
        for (unsigned int n = 0; n < rows[i].room; n++) {
            sensor_step(&s);
            sensor_wait(&s, 5 * MS);
            bool full = n + 1 == rows[i].room;
            sensor_expect(&s, full ? "no room for another image" : "room for another image", MASK,
                          full ? FZM1_BUSY : MASK);
        }
        assert_int_equal(signal_number(&s.w, "images"), rows[i].room);
        sensor_set(&s, FZM1_STEP, true);
        sensor_set(&s, FZM1_STEP, false);
        signal_set(&s.w, "processing", "1000");
        (void)sensor_until(&s, MASK, FZM1_READY);
        assert_int_equal(measurements() - before, rows[i].room);
        signal_set(&s.w, "processing", "10000000");
    }
}

static void busy_until_all_are_done(void **state)
{
    (void)state;
    sensor_step(&s);
    sensor_wait(&s, 5 * MS);
    sensor_step(&s);
    sensor_wait(&s, 5 * MS);
    sensor_expect(&s, "two images", MASK, MASK);
    assert_int_equal(sensor_until(&s, FZM1_BUSY, 0), 35 * MS); /* 5 + 20 + 20 since the first STEP, 10 have passed */
    assert_int_equal(measurements(), 2);
}

static void order(void **state)
{
    (void)state;
    char value[16];
    for (int n = 1; n <= 5; n++) {
        snprintf(value, sizeof value, "%d", n);
        signal_set(&s.w, "data1", value);
        sensor_step(&s);
        sensor_wait(&s, 5 * MS);
    }
    for (int n = 1; n <= 5; n++) {
        while (measurements() < n)
            sensor_wait(&s, MS);
        assert_int_equal(signal_number(&s.w, "result1"), n); /* the content of the image at its input */
    }
}

static void continuous(void **state)
{
    (void)state;
    assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
    for (int n = 1; n <= 10; n++) {
        sensor_wait(&s, 25 * MS);
        sensor_expect(&s, "continuous", MASK, FZM1_BUSY);
        assert_int_equal(measurements(), n);
    }
    sensor_set(&s, FZM1_STEP, true);
    sensor_set(&s, FZM1_STEP, false);
    assert_int_equal(sensor_command(&s, FZM1_END_CONTINUOUS, 0, 0, 0, NULL), 0);
    (void)sensor_until(&s, MASK, FZM1_READY);
    assert_int_equal(measurements(), 11); /* the active one is finished */
    sensor_wait(&s, 500 * MS);
    assert_int_equal(measurements(), 11);
    assert_int_equal(sensor_command(&s, FZM1_END_CONTINUOUS, 0, 0, 0, NULL), 0);
}

/* A STEP between EXE and the start of the continuous measurement. */
static void continuous_after_step(void **state)
{
    (void)state;
    signal_set(&s.w, "image_input", "100");
    signal_set(&s.w, "command_time", "10000");
    sensor_prepare(&s, FZM1_START_CONTINUOUS, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_step(&s);
    signal_set(&s.w, "image_input", "30000");
    (void)sensor_until(&s, FZM1_FLG, FZM1_FLG);
    sensor_wait(&s, 40 * MS); /* the first is measured at 20 ms, while the second image is taken until 40 */
    assert_int_equal(measurements(), 1);
    sensor_wait(&s, 10 * MS + MS);
    assert_int_equal(measurements(), 2);
}

/* A second without polls: all images were measured meanwhile, and each result still gets a GATE that a master can read.
 */
static void late_polls(void **state)
{
    (void)state;
    for (int n = 0; n < 10; n++) {
        sensor_step(&s);
        sensor_wait(&s, 5 * MS);
    }
    s.w.now_ns += 1000 * MS;
    wire_poll(&s.w);
    assert_int_equal(measurements(), 10);
    long long shown = signal_number(&s.w, "outputs");
    (void)sensor_until(&s, FZM1_GATE, 0);
    for (; shown < 10; shown++) {
        (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
        assert_int_equal(signal_number(&s.w, "outputs"), shown + 1);
        s.w.now_ns += 37 * MS; /* late again */
        wire_poll(&s.w);
        sensor_expect(&s, "one change a poll", FZM1_GATE, 0);
    }
    assert_int_equal(signal_number(&s.w, "pending"), 0);
}

/* Hours without a poll cause bounded work: after some thousand events a continuous measurement has waited. */
static void very_late_poll(void **state)
{
    (void)state;
    signal_set(&s.w, "image_input", "100");
    signal_set(&s.w, "processing", "100");
    assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
    s.w.now_ns += 24ull * 3600 * 1000 * MS;
    wire_poll(&s.w);
    long long before = measurements();
    assert_in_range(before, 1000, 4096);
    sensor_wait(&s, 1000 * MS);
    assert_in_range(measurements() - before, 4999, 5001);
    assert_in_range(signal_number(&s.w, "outputs"), 100, 110);
}

/* The limit of events is reached at the input or the processing of an image: the rest is postponed. */
static void put_off(void **state)
{
    enum { IMAGE = 1, PROCESSING = 2 };
    unsigned int seen = 0;
    for (unsigned int n = 0; n < 4; n++) {
        teardown(state);
        setup(state);
        signal_set(&s.w, "image_input", "100");
        signal_set(&s.w, "processing", "100");
        assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
        sensor_wait(&s, n * MS / 10);
        s.w.now_ns += 10000 * MS;
        wire_poll(&s.w);
        assert_in_range(measurements(), 1000, 4096);
        assert_int_equal(signal_number(&s.w, "exposures"), measurements() + 1);
        seen |= sensor_instance(&s)->image_due_ns != ECT_NEVER ? PROCESSING : IMAGE; /* the other one is next */
    }
    assert_int_equal(seen, IMAGE | PROCESSING);
}

static void overall_judgement(void **state)
{
    static const struct {
        const char *signal, *value;
        uint32_t or_signal;
    } rows[] = {{"judgement1", "-1", FZM1_OR}, {"judgement1", "1", 0},        {"judgement", "-1", FZM1_OR},
                {"judgement", "0", 0},         {"judgement3", "-1", FZM1_OR}, {"judgement", "1", 0},
                {"judgement", "0", FZM1_OR},   {"judgement3", "1", 0},        {"judgement5", "-1", 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t before = sensor_read(&s) & FZM1_OR;
        signal_set(&s.w, rows[i].signal, rows[i].value);
        sensor_expect(&s, "not measured yet", FZM1_OR, before);
        sensor_step(&s);
        (void)sensor_until(&s, FZM1_BUSY, 0);
        sensor_expect(&s, rows[i].signal, FZM1_OR, rows[i].or_signal);
    }
}

/* Unit data 0 of each unit, and OR, when all are overridden manually or by a row of the table. */
static void judgement_of_all(void **state)
{
    static const char *const ways[][2] = {{"judgement", "-1"}, {"judgement", "1"}, {"row", "-1"}, {"row", "1"}};
    (void)state;
    signal_set(&s.w, "judgement1", "-1");
    for (unsigned int way = 0; way < 4; way++) {
        bool by_row = ways[way][0][0] == 'r';
        signal_set(&s.w, "row_clear", "1");
        signal_set(&s.w, "judgement", by_row ? "0" : ways[way][1]);
        signal_set(&s.w, "row_judgement", ways[way][1]);
        signal_set(&s.w, "row_add", "1");
        signal_set(&s.w, "source1", by_row ? "4" : "0");
        sensor_step(&s);
        (void)sensor_until(&s, FZM1_BUSY, 0);
        int32_t want = ways[way][1][0] == '-' ? -1000 : 1000;
        sensor_expect(&s, ways[way][0], FZM1_OR, want < 0 ? FZM1_OR : 0);
        for (int unit = 0; unit < 4; unit++) {
            int32_t got = 0;
            assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, unit, 0, 0, &got), 0);
            if (got != want)
                fail_msg("%s=%s: unit %d is judged %d", ways[way][0], ways[way][1], unit, got);
        }
    }
    signal_set(&s.w, "judgement", "0"); /* as the units find: each its own */
    signal_set(&s.w, "source1", "0");
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    for (int unit = 0; unit < 4; unit++) {
        int32_t got = 0;
        assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, unit, 0, 0, &got), 0);
        assert_int_equal(got, unit == 1 ? -1000 : 1000);
    }
}

static void run_window(void **state)
{
    (void)state;
    signal_set(&s.w, "run", "0");
    sensor_expect(&s, "another window", FZM1_RUN | MASK, 0);
    sensor_set(&s, FZM1_STEP, true);
    sensor_set(&s, FZM1_STEP, false);
    assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0xFFFFFFFF);
    signal_set(&s.w, "run", "1");
    sensor_expect(&s, "RUN window", FZM1_RUN | MASK, FZM1_RUN | FZM1_READY);
    assert_int_equal(measurements(), 0);
}

static void trigger(void **state)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    (void)state;
    signal_set(&s.w, "trigger", "1");
    sensor_expect(&s, "trigger", MASK, FZM1_BUSY);
    assert_false(signal_try_set(&s.w, "trigger", "1", message));
    assert_non_null(strstr(message, "READY"));
    (void)sensor_until(&s, FZM1_BUSY, 0);
    assert_int_equal(measurements(), 1);
}

static double measure(const char *result)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    signal_get(&s.w, result, text);
    return strtod(text, NULL);
}

static void generators(void **state)
{
    (void)state;
    signal_set(&s.w, "data1", "10");
    signal_set(&s.w, "amplitude1", "4");
    signal_set(&s.w, "period1", "8");
    signal_set(&s.w, "source1", "1");
    sensor_instance(&s)->plant.shots = 0;
    for (int n = 0; n < 20; n++)
        assert_true(fabs(measure("result1") - (10 + 4.0 * (n % 8) / 8)) < 1e-6);
    signal_set(&s.w, "source1", "2");
    for (int n = 20; n < 40; n++)
        assert_true(fabs(measure("result1") - (10 + 4 * sin(2 * 3.14159265358979 * n / 8))) < 1e-6);
    double first[10];
    signal_set(&s.w, "source1", "3");
    signal_set(&s.w, "seed", "4711");
    double least = 100, largest = -100;
    for (int n = 0; n < 10; n++) {
        first[n] = measure("result1");
        least = first[n] < least ? first[n] : least;
        largest = first[n] > largest ? first[n] : largest;
    }
    assert_true(least >= 6 && largest <= 14 && largest - least > 1);
    signal_set(&s.w, "seed", "4711");
    for (int n = 0; n < 10; n++)
        assert_true(measure("result1") == first[n]);
}

static void table(void **state)
{
    (void)state;
    char message[ECT_SIGNAL_MESSAGE] = "";
    for (int n = 0; n < 3; n++) {
        signal_set(&s.w, "row2", n == 0 ? "1.5" : n == 1 ? "2.5" : "3.5");
        signal_set(&s.w, "row_judgement", n == 1 ? "-1" : "0");
        signal_set(&s.w, "row_add", "1");
    }
    signal_set(&s.w, "source2", "4");
    for (int n = 0; n < 7; n++) {
        assert_true(fabs(measure("result2") - (1.5 + n % 3)) < 1e-9);
        sensor_expect(&s, "judgement of the row", FZM1_OR, n % 3 == 1 ? FZM1_OR : 0);
    }
    for (int n = 3; n < 256; n++)
        signal_set(&s.w, "row_add", "1");
    assert_false(signal_try_set(&s.w, "row_add", "1", message));
    signal_set(&s.w, "row_clear", "1");
    assert_int_equal(signal_number(&s.w, "rows"), 0);
    assert_true(measure("result2") == 0);
}

/* Rows of a scene are measured in it alone, in a loop of their own; the others share the rows without a scene, or have
 * their own values. */
static void tables_of_scenes(void **state)
{
    static const struct {
        const char *scene, *data, *judgement;
    } rows[] = {{"3", "31", "0"}, {"5", "51", "1"}, {"3", "32", "-1"},
                {"-1", "1", "0"}, {"3", "33", "0"}, {"-1", "2", "0"}};
    static const struct {
        const char *scene; /* NULL: it stays */
        double result;
        bool ng;
    } measures[] = {{"3", 31, false}, {NULL, 32, true}, {"5", 51, false}, {NULL, 51, false}, {"0", 1, false},
                    {"3", 33, false}, {"7", 2, false},  {"0", 1, false},  {"3", 31, false},  {NULL, 32, true}};
    (void)state;
    signal_set(&s.w, "switch_time", "0");
    signal_set(&s.w, "source1", "4");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        signal_set(&s.w, "row_scene", rows[i].scene);
        signal_set(&s.w, "row1", rows[i].data);
        signal_set(&s.w, "row_judgement", rows[i].judgement);
        signal_set(&s.w, "row_add", "1");
    }
    for (size_t i = 0; i < sizeof measures / sizeof measures[0]; i++) {
        if (measures[i].scene)
            signal_set(&s.w, "scene", measures[i].scene);
        wire_poll(&s.w);
        double result = measure("result1");
        if (fabs(result - measures[i].result) > 1e-9)
            fail_msg("measurement %zu: expected %g, got %g", i, measures[i].result, result);
        sensor_expect(&s, "judgement of the row", FZM1_OR, measures[i].ng ? FZM1_OR : 0);
    }
    signal_set(&s.w, "row_clear", "1");
    signal_set(&s.w, "row_scene", "3");
    signal_set(&s.w, "row_add", "1");
    signal_set(&s.w, "data1", "4.5");
    assert_true(fabs(measure("result1") - 2) < 1e-9); /* a row as the last one, the first of its scene */
    signal_set(&s.w, "scene", "9");
    signal_set(&s.w, "data1", "9.5");
    wire_poll(&s.w);
    assert_true(fabs(measure("result1") - 9.5) < 1e-9);
}

/* Values of expressions with D1 to D8 = 10, 20, ..., units 0 to 2 OK, unit 3 NG; NULL: invalid. */
static void expressions(void **state)
{
    static const struct {
        const char *text, *value;
    } rows[] = {{"D1", "10"},
                {"D8", "80"},
                {"JG", "-1"},
                {"JG0", "1"},
                {"JG3", "-1"},
                {"JG7", "0"},
                {"1.5", "1.5"},
                {" D1 + D2 * D3 ", "610"},
                {"(D1+D2)*D3", "900"},
                {"D3-D2-D1", "0"},
                {"D8/D4/D2", "0.1"},
                {"-D1", "-10"},
                {"--D1", "10"},
                {"D1*-JG", "10"},
                {"D1/(D2-20)", "0"},
                {"((((((D1))))))", "10"},
                {"(((((((D1)))))))", "10"},
                {"999999999999*D1", "999999999.9999"},
                {"-999999999999*D1", "-999999999.9999"},
                {"0.0001*D1", "0.001"},
                {"D0", NULL},
                {"D9", NULL},
                {"D", NULL},
                {"JG8", NULL},
                {"J", NULL},
                {"D1 D2", NULL},
                {"D1+", NULL},
                {"*D1", NULL},
                {"(D1", NULL},
                {"D1)", NULL},
                {".5", NULL},
                {"d1", NULL},
                {"1e3", NULL},
                {"((((((((D1))))))))", NULL},
                {"---------D1", NULL}};
    (void)state;
    for (unsigned int n = 1; n <= 8; n++) {
        char name[16], value[16];
        snprintf(name, sizeof name, "data%u", n);
        snprintf(value, sizeof value, "%u", 10 * n);
        signal_set(&s.w, name, value);
    }
    signal_set(&s.w, "judgement3", "-1");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "", text[ECT_SIGNAL_TEXT_ROOM];
        bool taken = signal_try_set(&s.w, "expression2", rows[i].text, message);
        if (taken != (rows[i].value != NULL) || (!taken && !strstr(message, "no expression")))
            fail_msg("'%s': expected %s, was %s (%s)", rows[i].text, rows[i].value ? "a value" : "a refusal",
                     taken ? "taken" : "refused", message);
        if (!taken)
            continue;
        sensor_step(&s);
        (void)sensor_until(&s, FZM1_BUSY, 0);
        signal_get(&s.w, "result2", text);
        if (strcmp(text, rows[i].value) != 0)
            fail_msg("'%s': expected %s, got %s", rows[i].text, rows[i].value, text);
    }
    signal_set(&s.w, "expression2", "");
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    assert_int_equal(signal_number(&s.w, "result2"), 20);
}

/* Output area and unit data of an expression that is a judgement: a thousandfold of 1 or -1. */
static void judgement_as_data(void **state)
{
    int32_t data = 0;
    (void)state;
    signal_set(&s.w, "expression8", "JG");
    for (unsigned int ng = 0; ng < 2; ng++) {
        signal_set(&s.w, "judgement", ng ? "-1" : "1");
        sensor_step(&s);
        (void)sensor_until(&s, FZM1_GATE, FZM1_GATE);
        assert_int_equal(sensor_data(&s, 8), ng ? -1000 : 1000);
        assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, 3, 12, 0, &data), 0);
        assert_int_equal(data, ng ? -1000 : 1000);
        (void)sensor_until(&s, FZM1_GATE, 0);
    }
}

/* The values themselves stay within +-999999999.9999, in single precision too. */
static void clamped(void **state)
{
    float single;
    (void)state;
    signal_set(&s.w, "data1", "999999999");
    signal_set(&s.w, "source1", "1");
    signal_set(&s.w, "amplitude1", "999999999");
    signal_set(&s.w, "period1", "2");
    signal_set(&s.w, "output_format", "1");
    for (unsigned int n = 0; n < 2; n++) {
        sensor_step(&s);
        (void)sensor_until(&s, FZM1_BUSY, 0);
    }
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&s.w, "result1", text);
    assert_string_equal(text, "999999999.9999");
    sensor_wait(&s, 100 * MS);
    int32_t bits = sensor_data(&s, 1);
    memcpy(&single, &bits, sizeof single);
    assert_true(single == 1e9f);
}

/* Time of READY off, and then of BUSY on, for one STEP; microseconds. */
static void take_times(uint64_t times[2])
{
    sensor_step(&s);
    times[0] = sensor_until(&s, FZM1_READY, FZM1_READY) / 1000;
    times[1] = sensor_until(&s, FZM1_BUSY, 0) / 1000;
}

static void random_times(void **state)
{
    enum { SHOTS = 2000 };
    static uint64_t times[SHOTS][2];
    (void)state;
    signal_set(&s.w, "image_input", "5000");
    signal_set(&s.w, "processing", "20000");
    signal_set(&s.w, "image_input_spread", "500");
    signal_set(&s.w, "processing_spread", "4000");
    take_times(times[0]);
    assert_true(times[0][0] == 5000 && times[0][1] == 20000); /* as set, while time_source is 0 */
    signal_set(&s.w, "time_source", "3");
    static const double want[2][2] = {{5000, 500}, {20000, 4000}};
    for (unsigned int round = 0; round < 2; round++) {
        signal_set(&s.w, "seed", "4711");
        for (unsigned int n = 0; n < SHOTS; n++) {
            uint64_t now[2];
            take_times(now);
            if (round == 1 && memcmp(now, times[n], sizeof now) != 0)
                fail_msg("the same seed, and shot %u takes other times", n);
            memcpy(times[n], now, sizeof now);
        }
    }
    for (unsigned int which = 0; which < 2; which++) {
        double sum = 0, squares = 0, shots = SHOTS;
        for (unsigned int n = 0; n < SHOTS; n++)
            sum += (double)times[n][which];
        double mean = sum / shots;
        for (unsigned int n = 0; n < SHOTS; n++)
            squares += ((double)times[n][which] - mean) * ((double)times[n][which] - mean);
        double deviation = sqrt(squares / shots);
        if (fabs(mean - want[which][0]) > want[which][1] / 10 || fabs(deviation / want[which][1] - 1) > 0.1)
            fail_msg("expected %.0f +- %.0f us, got %.0f +- %.0f", want[which][0], want[which][1], mean, deviation);
    }
    signal_set(&s.w, "image_input", "100");
    signal_set(&s.w, "image_input_spread", "60000000");
    for (unsigned int n = 0; n < 20; n++) { /* within the range of the signals all the same */
        uint64_t now[2];
        take_times(now);
        assert_in_range(now[0], 100, 60000000);
    }
}

static void times_from_the_table(void **state)
{
    static const char *const rows[][2] = {{"1000", "2000"}, {"0", "7000"}, {"3000", "0"}};
    static const uint64_t want[][2] = {{1000, 2000}, {5000, 7000}, {3000, 20000}};
    uint64_t now[2];
    (void)state;
    for (unsigned int n = 0; n < 3; n++) {
        signal_set(&s.w, "row_image_input", rows[n][0]);
        signal_set(&s.w, "row_processing", rows[n][1]);
        signal_set(&s.w, "row_add", "1");
    }
    signal_set(&s.w, "time_source", "4");
    for (unsigned int n = 0; n < 6; n++) {
        take_times(now);
        assert_true(now[0] == want[n % 3][0] && now[1] == want[n % 3][1]);
    }
    signal_set(&s.w, "row_clear", "1");
    take_times(now);
    assert_true(now[0] == 5000 && now[1] == 20000);
}

static void clear(void **state)
{
    int32_t data = 7;
    (void)state;
    signal_set(&s.w, "data1", "5");
    signal_set(&s.w, "judgement", "-1");
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    (void)sensor_until(&s, FZM1_GATE, 0);
    assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, 3, 0, 0, &data), 0);
    assert_int_equal(data, -1000);
    assert_int_equal(sensor_command(&s, FZM1_CLEAR, 0, 0, 0, NULL), 0);
    assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, 3, 0, 0, &data), 0);
    assert_int_equal(data, 0);
    assert_int_equal(sensor_command(&s, FZM1_GET_UNIT_DATA, 3, 5, 0, &data), 0);
    assert_int_equal(data, 0);
    sensor_expect(&s, "OR and the output area stay", FZM1_OR, FZM1_OR);
    assert_int_equal(sensor_data(&s, 1), 5000);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-046 FZM-048 FZM-049: ready and in the RUN window after power-on", power_on),
        TEST(
            "FZM-041 FZM-044 FZM-046 FZM-064 FZM-065 FZM-066 FZM-068 OM-C3: STEP: BUSY on and READY off at once, READY "
            "after 5 ms image input, BUSY off 20 ms later",
            one_step),
        TEST("FZM-063: the rising edge of STEP measures, not its level", edge_not_level),
        TEST("FZM-046: STEP while READY is off is not accepted, then or later", not_ready),
        TEST("FZM-004 FZM-063: levels with which OP begins are no edges", level_at_start),
        TEST("FZM-041 FZM-046: each STEP that measures nothing is counted, with its cause", causes_of_ignored_steps),
        TEST("FZM-067: 16, 4 or 1 images may wait, by camera; READY shows it", queue),
        TEST("FZM-066: BUSY falls when all pending measurements are done", busy_until_all_are_done),
        TEST("FZM-067: pending images are measured in their order, with their own content", order),
        TEST("FZM-053 FZM-054 FZM-050 OM-C7: continuous measurement from Start to End", continuous),
        TEST("FZM-053: a continuous measurement that finds a waiting image", continuous_after_step),
        TEST("FZM-066 FZM-073: a late poll loses no measurement, and no GATE", late_polls),
        TEST("FZM-053: a day without a poll causes bounded work", very_late_poll),
        TEST("FZM-053: after ten seconds without a poll each image of a continuous measurement is still measured once",
             put_off),
        TEST("FZM-047: OR follows the overall judgement of each measurement", overall_judgement),
        TEST("FZM-033 FZM-047: `judgement`, set manually or in the table, applies to all units; 0: each its own",
             judgement_of_all),
        TEST("FZM-049: without the RUN window nothing is measured", run_window),
        TEST("FZM-069: a trigger at the sensor starts a measurement like STEP", trigger),
        TEST("FZM-030: ramp, sine and random values", generators),
        TEST("FZM-030: values from a table, row by row", table),
        TEST("FZM-030 FZM-035: rows of the table for a scene are measured in that scene, in their own loop",
             tables_of_scenes),
        TEST("FZM-030: output expressions", expressions),
        TEST("FZM-030 FZM-032 FZM-034: an expression that is the judgement outputs 1000 or -1000", judgement_as_data),
        TEST("FZM-034 OM-C6: data stay within +-999999999.9999", clamped),
        TEST("FZM-066 FZM-068: image input and processing that vary, the same for the same seed", random_times),
        TEST("FZM-066 FZM-068: image input and processing from the table", times_from_the_table),
        TEST("FZM-055: Clear makes unit data unmeasured; OR and output area are kept", clear),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 measurement", tests, NULL, NULL);
}
