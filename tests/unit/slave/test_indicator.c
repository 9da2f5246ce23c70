/* SPDX-License-Identifier: MIT */
/* RUN, ERR and Link/Activity over the states and errors of a real slave, and the times of the patterns. */
#include "slave/indicator.h"

#include <string.h>

#include "support/testdev.h"
#include "support/wire.h"

static void run_by_state(void **state)
{
    static const struct {
        uint8_t al;
        const char *pattern;
    } rows[] = {
        {ECT_STATE_INIT, "off"},
        {ECT_STATE_PREOP, "blinking"},
        {ECT_STATE_SAFEOP, "single flash"},
        {ECT_STATE_OP, "on"},
    };
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_go(&w, 0, rows[i].al);
        assert_string_equal(ect_pattern_name(ect_indicator_run(ect_chain_slave(w.chain, 0))), rows[i].pattern);
        assert_string_equal(ect_pattern_name(ect_indicator_err(ect_chain_slave(w.chain, 0), false)), "off");
    }
    wire_close(&w);
    const ect_slave_t boot = {.state = ECT_STATE_BOOT};
    assert_string_equal(ect_pattern_name(ect_indicator_run(&boot)), "flickering");
}

static const char *err(wire_t *w)
{
    return ect_pattern_name(ect_indicator_err(ect_chain_slave(w->chain, 0), false));
}

static void err_by_cause(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_al(&w, 0, ECT_STATE_OP, NULL); /* refused */
    assert_string_equal(err(&w), "blinking");
    wire_go(&w, 0, ECT_STATE_OP);
    assert_string_equal(err(&w), "off");
    wire_advance(&w, 200 * MS); /* the watchdog */
    assert_string_equal(err(&w), "double flash");
    assert_string_equal(ect_pattern_name(ect_indicator_err(ect_chain_slave(w.chain, 0), true)), "on");
    wire_go(&w, 0, ECT_STATE_OP);
    const ect_host_t *host = testdev_of(&w, 0)->host;
    host->drop(host->ctx, ECT_STATE_SAFEOP, 0x8001);
    ect_chain_wake(w.chain, 0);
    wire_poll(&w);
    assert_int_equal(ect_chain_slave(w.chain, 0)->code, 0x8001);
    assert_string_equal(err(&w), "single flash");
    wire_close(&w);
}

/* On and off times in milliseconds, from the start of a period. */
static void pattern_times(void **state)
{
    static const struct {
        ect_pattern_t pattern;
        unsigned int times[5]; /* on, off, on, off ...; 0 ends the period */
    } rows[] = {
        {ECT_PATTERN_FLICKERING, {50, 50}},
        {ECT_PATTERN_BLINKING, {200, 200}},
        {ECT_PATTERN_SINGLE_FLASH, {200, 1000}},
        {ECT_PATTERN_DOUBLE_FLASH, {200, 200, 200, 1000}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint64_t ms = 0;
        for (unsigned int period = 0; period < 3; period++) {
            for (unsigned int phase = 0; rows[i].times[phase] != 0; phase++) {
                for (unsigned int n = 0; n < rows[i].times[phase]; n++, ms++) {
                    if (ect_pattern_lit(rows[i].pattern, ms * MS) != (phase % 2 == 0))
                        fail_msg("%s at %u ms", ect_pattern_name(rows[i].pattern), (unsigned int)ms);
                }
            }
        }
    }
    assert_true(ect_pattern_lit(ECT_PATTERN_ON, 123 * MS));
    assert_false(ect_pattern_lit(ECT_PATTERN_OFF, 123 * MS));
}

static void link_activity(void **state)
{
    (void)state;
    assert_int_equal(ect_indicator_link(false, 0, 1000 * MS), ECT_PATTERN_OFF);
    assert_int_equal(ect_indicator_link(false, 999 * MS, 1000 * MS), ECT_PATTERN_OFF);
    assert_int_equal(ect_indicator_link(true, 0, 1000 * MS), ECT_PATTERN_ON);
    assert_int_equal(ect_indicator_link(true, 901 * MS, 1000 * MS), ECT_PATTERN_FLICKERING);
    assert_int_equal(ect_indicator_link(true, 0, 1 * MS), ECT_PATTERN_ON); /* just switched on: no traffic so far */
    assert_int_equal(ect_indicator_link(true, 900 * MS, 1000 * MS), ECT_PATTERN_ON);
}

/* The indicators of a chain of two, as signals. */
static void lamps_of_a_chain(void **state)
{
    static const ect_device_t *const devices[] = {&testdev, &testdev};
    (void)state;
    wire_t w;
    wire_open(&w, devices, 2);
    const char *const first[] = {"flickering", "flickering"}, *const last[] = {"flickering", "off"};
    const char *const idle[] = {"on", "on"}, *const idle_last[] = {"on", "off"};
    wire_poll(&w);
    for (unsigned int round = 0; round < 2; round++) {
        for (size_t i = 0; i < 2; i++) {
            const char *const *want = i == 0 ? (round == 0 ? first : idle) : (round == 0 ? last : idle_last);
            for (unsigned int side = 0; side < 2; side++) {
                ect_signal_ref_t ref;
                char text[ECT_SIGNAL_TEXT_ROOM];
                assert_true(ect_chain_signal(w.chain, i, side == 0 ? "ecat.link_in" : "ecat.link_out", &ref));
                ect_signal_read(&ref, text);
                assert_string_equal(text, want[side]);
            }
        }
        wire_advance(&w, 100 * MS); /* without a frame */
    }
    wire_close(&w);
}

/* --- pins --------------------------------------------------------------------------------------------------------- */

typedef struct pins {
    bool run, err;
    unsigned int set;
} pins_t;

static void run_pin(void *ctx, bool lit)
{
    pins_t *p = ctx;
    p->run = lit;
    p->set++;
}

static void err_pin(void *ctx, bool lit)
{
    pins_t *p = ctx;
    p->err = lit;
    p->set++;
}

/* For five seconds of each pair of patterns: called only at its own times, it keeps the pins right at every moment. */
static void pins_follow(void **state)
{
    static const uint8_t states[] = {ECT_STATE_INIT, ECT_STATE_PREOP, ECT_STATE_BOOT, ECT_STATE_SAFEOP, ECT_STATE_OP};
    static const uint8_t causes[] = {ECT_CAUSE_NONE, ECT_CAUSE_REQUEST, ECT_CAUSE_LOCAL, ECT_CAUSE_WATCHDOG};
    (void)state;
    for (size_t n = 0; n < sizeof states * sizeof causes; n++) {
        const ect_slave_t slave = {.state = states[n / sizeof causes], .cause = causes[n % sizeof causes]};
        pins_t pins = {0};
        const ect_leds_t leds = {.ctx = &pins, .run = run_pin, .err = err_pin};
        uint64_t next_ns = 0;
        for (uint64_t now_ns = 0; now_ns < 5000 * MS; now_ns += 10 * MS) {
            if (now_ns >= next_ns)
                next_ns = ect_indicator_drive(&slave, &leds, false, now_ns);
            assert_int_equal(pins.run, ect_pattern_lit(ect_indicator_run(&slave), now_ns));
            assert_int_equal(pins.err, ect_pattern_lit(ect_indicator_err(&slave, false), now_ns));
        }
        assert_true(pins.set <= 2 * 101);
    }
}

static void pins_that_are_not_there(void **state)
{
    const ect_slave_t slave = {.state = ECT_STATE_PREOP, .cause = ECT_CAUSE_REQUEST};
    pins_t pins = {0};
    const ect_leds_t none = {.ctx = &pins};
    const ect_leds_t only_err = {.ctx = &pins, .err = err_pin};
    (void)state;
    assert_true(ect_indicator_drive(&slave, &none, false, 0) == ECT_NEVER);
    assert_true(ect_indicator_drive(&slave, &only_err, true, 0) == ECT_NEVER); /* steady */
    assert_true(pins.err && !pins.run && pins.set == 1);
}

int main(int argc, char **argv)
{
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    const struct CMUnitTest tests[] = {
        {"CF-093 FZM-022 ECL-016: the lamps of a chain, as signals", lamps_of_a_chain, NULL, NULL, NULL},
        {"CF-093 FZM-020 ECL-014: RUN shows the state", run_by_state, NULL, NULL, NULL},
        {"CF-093 FZM-021 ECL-015: ERR shows the cause", err_by_cause, NULL, NULL, NULL},
        {"CF-093 FZM-023: the patterns keep the times of ETG.1300", pattern_times, NULL, NULL, NULL},
        {"CF-093 FZM-022 ECL-016: Link/Activity shows link and traffic", link_activity, NULL, NULL, NULL},
        {"CF-093: a board's pins follow, driven only at the requested times", pins_follow, NULL, NULL, NULL},
        {"CF-093: a board without one of the lamps", pins_that_are_not_there, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("indicators", tests, NULL, NULL);
}
