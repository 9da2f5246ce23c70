/* SPDX-License-Identifier: MIT */
/* Latch control and status word of the PMCtendo (manual §4.9), on the virtual clock. */
#include <stdio.h>
#include <stdlib.h>

#include "support/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
enum { ACKNOWLEDGE = 0x0F00, VALID = 0x001F, INPUTS = 0xF000 };

static drive_t d;

static int setup(void **state)
{
    (void)state;
    drive_open(&d);
    drive_operational(&d, 0x1720, 0x1B25);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    drive_close(&d);
    return 0;
}

static void expect(const char *when, uint16_t mask, uint16_t want)
{
    drive_cycle(&d);
    if ((drive_latch_status(&d) & mask) != want)
        fail_msg("%s: expected latch status %04X of %04X, got %04X", when, want, mask, drive_latch_status(&d));
}

static void inputs(void **state)
{
    static const struct {
        const char *signal;
        uint16_t bit;
    } rows[] = {{"di1", 0x8000}, {"di2", 0x4000}, {"di3", 0x2000}, {"di4", 0x1000}};
    (void)state;
    for (unsigned int set = 0; set < 16; set++) {
        uint16_t want = 0;
        for (size_t i = 0; i < COUNT(rows); i++) {
            signal_set(&d.w, rows[i].signal, (set >> i & 1) != 0 ? "1" : "0");
            want |= (set >> i & 1) != 0 ? rows[i].bit : 0;
        }
        expect("inputs", INPUTS, want);
        uint32_t levels = ect_load_le32(d.in + d.from.inputs) >> 16;
        assert_int_equal(levels, set);
    }
}

/* Arms, moves over a mark on the machine in the direction that gives the edge, reads: the value is the mark's edge. */
static const struct {
    const char *what;
    uint16_t enable, read;
    const char *mark;
    bool upwards;
    int32_t value;
    unsigned int shown;
} latches[] = {
    {"latch 1 positive, upwards", 0x01, 0x0100, "probe", true, 400000, 1},
    {"latch 1 negative, upwards", 0x02, 0x0200, "probe", true, 450000, 1},
    {"latch 1 positive, downwards", 0x01, 0x0100, "probe", false, 450000, 1},
    {"latch 1 negative, downwards", 0x02, 0x0200, "probe", false, 400000, 1},
    {"latch 2 positive, upwards", 0x04, 0x0300, "home", true, 400000, 2},
    {"latch 2 negative, upwards", 0x08, 0x0400, "home", true, 450000, 2},
    {"latch 2 positive, downwards", 0x04, 0x0300, "home", false, 450000, 2},
    {"latch 2 negative, downwards", 0x08, 0x0400, "home", false, 400000, 2},
    {"latch C, upwards", 0x10, 0x0500, NULL, true, 420000, 1},
    {"latch C, downwards", 0x10, 0x0500, NULL, false, 420000, 1},
};

static void travel(int32_t from, int32_t to)
{
    int32_t step = to > from ? 20000 : -20000;
    for (int32_t x = from; x != to; x += step) {
        drive_set(&d, x);
        drive_cycle(&d);
    }
    drive_set(&d, to);
    drive_cycles(&d, 300);
}

static void one_latch(size_t i)
{
    bool up = latches[i].upwards;
    drive_open(&d);
    signal_set(&d.w, "index_at", "420000");
    if (latches[i].mark) {
        signal_set(&d.w, latches[i].mark[0] == 'p' ? "probe_at" : "home_at", "400000");
        signal_set(&d.w, latches[i].mark[0] == 'p' ? "probe_width" : "home_width", "50000");
    }
    drive_operational(&d, 0x1720, 0x1B25);
    drive_enable(&d);
    if (!up)
        travel(0, 800000);
    expect(latches[i].what, VALID | ACKNOWLEDGE, 0);
    drive_latch(&d, latches[i].enable);
    expect("armed", VALID | ACKNOWLEDGE, 0);
    travel(up ? 0 : 800000, up ? 800000 : 0);
    expect(latches[i].what, VALID | ACKNOWLEDGE, latches[i].enable);
    assert_int_equal(drive_latched(&d, latches[i].shown), 0); /* not before the read code */
    drive_latch(&d, latches[i].enable | latches[i].read);
    expect(latches[i].what, VALID | ACKNOWLEDGE, latches[i].enable | latches[i].read);
    if (drive_latched(&d, latches[i].shown) != latches[i].value)
        fail_msg("%s: expected %d, got %d", latches[i].what, latches[i].value, drive_latched(&d, latches[i].shown));
    travel(up ? 800000 : 0, up ? 0 : 800000); /* over it once more: the latched value stays */
    expect("kept", VALID | ACKNOWLEDGE, latches[i].enable | latches[i].read);
    assert_int_equal(drive_latched(&d, latches[i].shown), latches[i].value);
    drive_latch(&d, 0);
    expect("disarmed", VALID | ACKNOWLEDGE, 0);
    drive_close(&d);
}

static void every_latch(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(latches); i++)
        one_latch(i);
}

/* An input switched manually latches the present position, with the power stage off. */
static void by_hand(void **state)
{
    (void)state;
    drive_latch(&d, 0x0F);
    expect("armed", VALID, 0);
    signal_set(&d.w, "di1", "1");
    expect("DI1 on", VALID, 0x01);
    signal_set(&d.w, "di1", "0");
    expect("DI1 off", VALID, 0x03);
    signal_set(&d.w, "di2", "1");
    expect("DI2 on", VALID, 0x07);
    signal_set(&d.w, "di2", "0");
    expect("DI2 off", VALID, 0x0F);
}

/* A code without a latched value, or an unknown code, is not acknowledged. */
static void codes(void **state)
{
    (void)state;
    drive_latch(&d, 0x01);
    expect("armed", VALID, 0);
    signal_set(&d.w, "di1", "1");
    for (unsigned int code = 0; code < 16; code++) {
        drive_latch(&d, (uint16_t)(code << 8 | 0x01));
        expect("read", ACKNOWLEDGE, code == 1 ? 0x0100 : 0);
    }
}

/* By SDO, in PREOP, without a PDO that carries the words. */
static void by_mailbox(void **state)
{
    (void)state;
    assert_int_equal(wire_al(&d.w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
    assert_int_equal(drive_write(&d, 0x20A4, 0, 0x0001, 2), 0);
    signal_set(&d.w, "di1", "1");
    assert_int_equal(drive_read(&d, 0x20A5, 0) & VALID, 0x01);
    assert_int_equal(drive_write(&d, 0x20A4, 0, 0x0101, 2), 0);
    assert_int_equal(drive_read(&d, 0x20A5, 0), 0xB101);
}

/* The shaft passes the mark between two ticks; the latch is armed before, or after that and before the next tick. */
static void armed_between_ticks(void **state)
{
    enum { STEPS = 3, ARM = 0x0001 };
    (void)state;
    for (unsigned int late = 0; late < 2; late++) {
        char at[16];
        drive_open(&d);
        drive_operational(&d, 0x1702, 0x1B25);
        drive_enable(&d);
        drive_set(&d, 10 * PMC_TURN);
        drive_cycles(&d, 100);
        double way = drive_instance(&d)->plant.machine.speed / ECT_402_STEPS_PER_S * 1.5;
        snprintf(at, sizeof at, "%.0f", drive_instance(&d)->plant.machine.position + way);
        signal_set(&d.w, "probe_width", "1000000");
        signal_set(&d.w, "probe_at", at);
        if (!late)
            assert_int_equal(drive_write(&d, 0x20A4, 0, ARM, 2), 0);
        wire_advance(&d.w, STEPS * PMC_STEP_NS);
        if (late)
            assert_int_equal(drive_write(&d, 0x20A4, 0, ARM, 2), 0);
        expect(late ? "armed behind the mark" : "armed before the mark", VALID, late ? 0 : ARM);
        drive_close(&d);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-005: bits 12 to 15 are digital inputs 4, 3, 2, 1, independently", inputs, setup, teardown, NULL},
        {"PLZ-001 PLZ-002 PLZ-003 PLZ-004 PLZ-006: each latch is armed, latches its edge, is read and acknowledged "
         "with the position of the edge",
         every_latch, NULL, NULL, NULL},
        {"PLZ-001 PLZ-002 PLZ-004: edges of inputs that are switched manually", by_hand, setup, teardown, NULL},
        {"PLZ-006: a code without a value is not acknowledged", codes, setup, teardown, NULL},
        {"PLZ-004 PLZ-006: a latch that is armed by mailbox latches no earlier edge", armed_between_ticks, NULL, NULL,
         NULL},
        {"PLZ-004 PLZ-006: the latch words by mailbox", by_mailbox, setup, teardown, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo latches", tests, NULL, NULL);
}
