/* SPDX-License-Identifier: MIT */
/* Waves of signals (src/bus/faults/waves.h), on a clock of the test. */
#include "bus/faults/waves.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bus/chain/catalogue.h"
#include "bus/faults/scenario.h"
#include "support/wire.h"

static void open_twin(wire_t *w, const char *device)
{
    const ect_product_t *entry = ect_catalogue_find(device);
    assert_non_null(entry);
    ect_twin_config_t twin = ect_twin_default(entry->device, entry->plant);
    wire_open_twins(w, &twin, 1);
}

static ect_wave_t wave_of(const char *name, ect_wave_shape_t shape, double low, double high, uint64_t period_ns)
{
    ect_wave_t wave = {.shape = shape, .low = low, .high = high, .period_ns = period_ns};
    snprintf(wave.name, sizeof wave.name, "%s", name);
    return wave;
}

static void shapes(void **state)
{
    static const struct {
        ect_wave_shape_t shape;
        double want[5]; /* above the lowest value: at 0, 1/4, 1/2, 3/4 of a period and at its end */
    } rows[] = {
        {ECT_WAVE_SINE, {5, 10, 5, 0, 5}}, {ECT_WAVE_RAMP, {0, 2.5, 5, 7.5, 0}}, {ECT_WAVE_SQUARE, {10, 10, 0, 0, 10}}};
    static const double lows[] = {0, -4, -30, 20};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (size_t n = 0; n < sizeof lows / sizeof lows[0]; n++) {
            ect_wave_t wave = wave_of("a", rows[i].shape, lows[n], lows[n] + 10, 400 * MS);
            wave.start_ns = 7 * MS;
            for (unsigned int k = 0; k < 5; k++)
                assert_true(fabs(ect_wave_value(&wave, 7 * MS + k * 100 * MS) - lows[n] - rows[i].want[k]) < 1e-6);
        }
        assert_int_equal(ect_wave_shape(ect_wave_shape_name(rows[i].shape)), rows[i].shape);
    }
    assert_int_equal(ect_wave_shape("off"), ECT_WAVE_SHAPES);
}

static void refused(void **state)
{
    static const struct {
        const char *name;
        double low, high;
        uint64_t period_ns;
        const char *want;
    } rows[] = {
        {"nothing", 0, 1, 1000 * MS, "slave 1 has no signal 'nothing' that is a number"},
        {"ecat.run", 0, 1, 1000 * MS, "slave 1 has no signal 'ecat.run' that is a number"},
        {"gate", 0, 1, 1000 * MS, "gate"},
        {"scene", 0, 1e6, 1000 * MS, "scene"},
        {"scene", -1, 5, 1000 * MS, "scene"},
        {"scene", 5, 1, 1000 * MS, "low <= high"},
        {"scene", 0, 1, 10 * MS - 1, "a period of 0.01 s or more"},
    };
    char message[ECT_SIGNAL_MESSAGE];
    ect_waves_t waves = {0};
    wire_t w;
    (void)state;
    open_twin(&w, "fzm1");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_wave_t wave = wave_of(rows[i].name, ECT_WAVE_SINE, rows[i].low, rows[i].high, rows[i].period_ns);
        assert_false(ect_waves_set(&waves, w.chain, &wave, 0, message));
        if (!strstr(message, rows[i].want))
            fail_msg("%s: %s", rows[i].name, message);
        assert_int_equal(waves.count, 0);
    }
    wire_close(&w);
}

/* Whole numbers for a whole signal, one value each millisecond, and only those that differ. */
static void in_time(void **state)
{
    char message[ECT_SIGNAL_MESSAGE], text[ECT_SIGNAL_TEXT_ROOM];
    ect_waves_t waves = {0};
    ect_signal_ref_t ref;
    wire_t w;
    (void)state;
    open_twin(&w, "fzm1");
    const uint64_t start_ns = w.now_ns;
    const ect_wave_t wave = wave_of("scene", ECT_WAVE_RAMP, 0, 10, 100 * MS);
    assert_true(ect_waves_set(&waves, w.chain, &wave, start_ns, message));
    assert_true(ect_chain_signal(w.chain, 0, "scene", &ref));
    unsigned int changes = 0;
    for (unsigned int ms = 0; ms < 95; ms++) {
        bool acted = false;
        assert_true(ect_waves_run(&waves, w.chain, start_ns + ms * MS, &acted, NULL, NULL) == start_ns + (ms + 1) * MS);
        changes += acted;
        ect_signal_read(&ref, text);
        char want[16];
        snprintf(want, sizeof want, "%.0f", ms / 10.0);
        assert_string_equal(text, want);
        acted = false;
        (void)ect_waves_run(&waves, w.chain, start_ns + ms * MS + 1, &acted, NULL, NULL);
        assert_false(acted); /* not due */
    }
    assert_int_equal(changes, 10);
    bool acted = false; /* a late call sets the value of its time, and the next one is due in time */
    assert_true(ect_waves_run(&waves, w.chain, start_ns + 155 * MS + 5, &acted, NULL, NULL) == start_ns + 156 * MS);
    ect_signal_read(&ref, text);
    assert_string_equal(text, "6");
    wire_close(&w);
}

typedef struct box {
    int16_t level;
} box_t;

/* Around zero a whole value has no sign: it is the same value, which is not set again. */
static void around_zero(void **state)
{
    static const ect_signal_t signals[] = {ECT_SIGNAL(box_t, level, "level", I16, WRITE, -10, 10, NULL, "")};
    static const ect_signal_group_t group = {.signal_count = 1, .signals = signals, .prefix = "box"};
    static const ect_plant_t plant = {.signal_groups = &group, .signal_group_count = 1};
    const ect_product_t *entry = ect_catalogue_find("fzm1");
    ect_twin_config_t twin = ect_twin_default(entry->device, entry->plant);
    char message[ECT_SIGNAL_MESSAGE];
    ect_waves_t waves = {0};
    box_t box = {0};
    wire_t w;
    (void)state;
    twin.beside = (ect_beside_t){.plant = &plant, .instance = &box, .size = sizeof box};
    wire_open_twins(&w, &twin, 1);
    const ect_wave_t wave = wave_of("box.level", ECT_WAVE_RAMP, -1, 1, 100 * MS);
    assert_true(ect_waves_set(&waves, w.chain, &wave, 0, message));
    unsigned int changes = 0;
    for (unsigned int ms = 0; ms < 100; ms++) {
        bool acted = false;
        (void)ect_waves_run(&waves, w.chain, ms * MS, &acted, NULL, NULL);
        changes += acted;
        assert_int_equal(box.level, ms < 25 ? -1 : ms <= 75 ? 0 : 1);
    }
    assert_int_equal(changes, 3);
    wire_close(&w);
}

static void ends(void **state)
{
    static const char *const names[] = {"data1", "data2", "data3", "data4", "data5", "data6", "data7", "scene"};
    char message[ECT_SIGNAL_MESSAGE];
    ect_waves_t waves = {0};
    wire_t w;
    (void)state;
    open_twin(&w, "fzm1");
    for (size_t i = 0; i < ECT_WAVES; i++) {
        const ect_wave_t wave = wave_of(names[i], ECT_WAVE_SINE, 0, 1, 1000 * MS);
        assert_true(ect_waves_set(&waves, w.chain, &wave, 0, message));
    }
    const ect_wave_t more = wave_of("data8", ECT_WAVE_SINE, 0, 1, 1000 * MS),
                     again = wave_of("data3", ECT_WAVE_RAMP, 0, 1, 1000 * MS);
    assert_false(ect_waves_set(&waves, w.chain, &more, 0, message));
    assert_string_equal(message, "8 waves run already: end one of them");
    assert_true(ect_waves_set(&waves, w.chain, &again, 0, message)); /* in place of the other */
    assert_int_equal(waves.count, ECT_WAVES);
    assert_false(ect_waves_end(&waves, 1, "data1"));
    assert_false(ect_waves_end(&waves, 0, "data8"));
    assert_true(ect_waves_end(&waves, 0, "data1"));
    assert_int_equal(waves.count, ECT_WAVES - 1);
    assert_false(ect_waves_end(&waves, 0, "data1"));
    assert_true(ect_waves_end(&waves, 0, NULL));
    assert_int_equal(waves.count, 0);
    assert_false(ect_waves_end(&waves, 0, NULL));
    wire_close(&w);
}

/* A name belongs to a twin: the second one has its own wave of the same signal. */
static void of_two_twins(void **state)
{
    const ect_product_t *entry = ect_catalogue_find("fzm1");
    const ect_twin_config_t twins[] = {ect_twin_default(entry->device, entry->plant),
                                       ect_twin_default(entry->device, entry->plant)};
    char message[ECT_SIGNAL_MESSAGE], text[ECT_SIGNAL_TEXT_ROOM];
    ect_waves_t waves = {0};
    bool acted = false;
    wire_t w;
    (void)state;
    wire_open_twins(&w, twins, 2);
    for (size_t position = 0; position < 2; position++) {
        ect_wave_t wave = wave_of("scene", ECT_WAVE_RAMP, 3.0 + (double)position, 3.0 + (double)position, 1000 * MS);
        wave.position = position;
        assert_true(ect_waves_set(&waves, w.chain, &wave, 0, message));
        assert_int_equal(waves.count, position + 1);
    }
    assert_true(ect_waves_run(&waves, w.chain, 0, &acted, NULL, NULL) == MS);
    for (size_t position = 0; position < 2; position++) {
        ect_signal_ref_t ref;
        assert_true(ect_chain_signal(w.chain, position, "scene", &ref));
        ect_signal_read(&ref, text);
        assert_string_equal(text, position == 0 ? "3" : "4");
    }
    ect_wave_t none = wave_of("nothing", ECT_WAVE_RAMP, 0, 1, 1000 * MS);
    none.position = 1;
    assert_false(ect_waves_set(&waves, w.chain, &none, 0, message));
    assert_string_equal(message,
                        "slave 2 has no signal 'nothing' that is a number: 'ectwin list-signals -n 2' lists them");
    assert_true(ect_waves_end(&waves, 0, "scene"));
    assert_int_equal(waves.count, 1);
    assert_int_equal(waves.all[0].position, 1);
    assert_false(ect_waves_end(&waves, 0, "scene"));
    wire_close(&w);
}

typedef struct scale {
    double real;
    float real32;
} scale_t;

/* A number with a fraction has nine digits. */
static void fractions(void **state)
{
    static const ect_signal_t signals[] = {ECT_SIGNAL(scale_t, real, "real", REAL, WRITE, -10, 10, NULL, ""),
                                           ECT_SIGNAL(scale_t, real32, "real32", REAL32, WRITE, -10, 10, NULL, "")};
    static const ect_signal_group_t group = {.signal_count = 2, .signals = signals, .prefix = "scale"};
    static const ect_plant_t plant = {.signal_groups = &group, .signal_group_count = 1};
    static const char *const names[] = {"scale.real", "scale.real32"};
    const ect_product_t *entry = ect_catalogue_find("fzm1");
    ect_twin_config_t twin = ect_twin_default(entry->device, entry->plant);
    char message[ECT_SIGNAL_MESSAGE];
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        ect_waves_t waves = {0};
        scale_t scale = {0};
        bool acted = false;
        wire_t w;
        twin.beside = (ect_beside_t){.plant = &plant, .instance = &scale, .size = sizeof scale};
        wire_open_twins(&w, &twin, 1);
        const ect_wave_t wave = wave_of(names[i], ECT_WAVE_RAMP, -1.5, 1.5, 12 * MS);
        assert_true(ect_waves_set(&waves, w.chain, &wave, 0, message));
        (void)ect_waves_run(&waves, w.chain, 0, &acted, NULL, NULL);
        assert_true(i == 0 ? fabs(scale.real + 1.5) < 1e-9 : fabsf(scale.real32 + 1.5f) < 1e-6f);
        (void)ect_waves_run(&waves, w.chain, MS, &acted, NULL, NULL);
        assert_true(i == 0 ? fabs(scale.real + 1.25) < 1e-9 : fabsf(scale.real32 + 1.25f) < 1e-6f);
        assert_string_equal(waves.all[0].last, "-1.25");
        wire_close(&w);
    }
}

static void note(void *ctx, const char *name, const char *why)
{
    snprintf(ctx, ECT_SIGNAL_MESSAGE, "%s: %s", name, why);
}

/* The signal of a wave may go with its module, and a plant may refuse a value. */
static void a_lost_signal(void **state)
{
    char message[ECT_SIGNAL_MESSAGE], said[ECT_SIGNAL_MESSAGE] = "";
    ect_waves_t waves = {0};
    bool acted = false;
    wire_t w;
    (void)state;
    open_twin(&w, "fzm1");
    const ect_wave_t first = wave_of("data1", ECT_WAVE_SINE, 0, 1, 1000 * MS),
                     second = wave_of("data2", ECT_WAVE_SINE, 0, 1, 1000 * MS);
    assert_true(ect_waves_set(&waves, w.chain, &first, 0, message));
    assert_true(ect_waves_set(&waves, w.chain, &second, 0, message));
    strcpy(waves.all[0].name, "gone");
    assert_true(ect_waves_run(&waves, w.chain, 0, &acted, note, said) == MS);
    assert_string_equal(said, "gone: the signal is gone");
    assert_int_equal(waves.count, 1);
    assert_string_equal(waves.all[0].name, "data2");
    assert_true(acted);
    strcpy(waves.all[0].name, "scene");
    waves.all[0].low = waves.all[0].high = 1e6; /* as after a change of its range */
    assert_true(ect_waves_run(&waves, w.chain, MS, &acted, NULL, NULL) == ECT_NEVER);
    assert_int_equal(waves.count, 0);
    wire_close(&w);
}

/* A scenario without faults runs its waves, and does not rest meanwhile. */
static void in_a_scenario(void **state)
{
    char message[ECT_SIGNAL_MESSAGE], text[ECT_SIGNAL_TEXT_ROOM];
    static ect_scenario_t s;
    ect_signal_ref_t ref;
    wire_t w;
    (void)state;
    open_twin(&w, "fzm1");
    assert_true(ect_scenario_rests(&s));
    const ect_wave_t wave = wave_of("scene", ECT_WAVE_SQUARE, 1, 4, 20 * MS);
    assert_true(ect_waves_set(&s.waves, w.chain, &wave, w.now_ns, message));
    assert_false(ect_scenario_rests(&s));
    assert_true(ect_scenario_tick(&s, w.chain, w.now_ns) == w.now_ns + MS);
    assert_true(s.acted);
    assert_true(ect_chain_signal(w.chain, 0, "scene", &ref));
    ect_signal_read(&ref, text);
    assert_string_equal(text, "4");
    (void)ect_scenario_tick(&s, w.chain, w.now_ns + 10 * MS);
    ect_signal_read(&ref, text);
    assert_string_equal(text, "1");
    assert_true(ect_waves_end(&s.waves, 0, NULL));
    assert_true(ect_scenario_tick(&s, w.chain, w.now_ns + 11 * MS) == ECT_NEVER);
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Sine, ramp and square over a period", shapes, NULL, NULL, NULL},
        {"A wave that the signal cannot follow is refused with the reason", refused, NULL, NULL, NULL},
        {"Values are set each millisecond, if they differ", in_time, NULL, NULL, NULL},
        {"A wave around zero sets 0 once", around_zero, NULL, NULL, NULL},
        {"At most eight waves; one for each signal, until it is ended", ends, NULL, NULL, NULL},
        {"Each twin has the waves of its own signals", of_two_twins, NULL, NULL, NULL},
        {"A signal with a fraction follows a wave with its fraction", fractions, NULL, NULL, NULL},
        {"A wave whose value is refused ends, and the others continue", a_lost_signal, NULL, NULL, NULL},
        {"A scenario runs its waves", in_a_scenario, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Waves", tests, NULL, NULL);
}
