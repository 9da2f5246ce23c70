/* SPDX-License-Identifier: MIT */
/* The PMCtendo with a motor: modes of operation, ramps, limits, faults; on the virtual clock, so that the numbers are
 * the same every time. */
#include <stdlib.h>
#include <string.h>

#include "support/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define TURN         PMC_TURN

static drive_t d;

static int teardown(void **state)
{
    (void)state;
    drive_close(&d);
    return 0;
}

static int setup(void **state)
{
    (void)state;
    drive_open(&d);
    return 0;
}

static double speed(void)
{
    return drive_instance(&d)->plant.machine.speed;
}

static void expect_near(const char *what, double want, double off)
{
    double got = what[0] == 's' ? speed() : drive_position(&d);
    if (got < want - off || got > want + off)
        fail_msg("%s: expected %.0f +- %.0f, got %.0f", what, want, off, got);
}

static void start(uint16_t out)
{
    drive_operational(&d, out, 0x1B25);
    drive_enable(&d);
}

/* --- set values --------------------------------------------------------------------------------------------------- */

/* 1000 positions, 10000 counts apart: the shaft follows one cycle later, and ends at the last one. */
static void position(void **state)
{
    (void)state;
    start(0x1701);
    for (int32_t i = 1; i <= 1000; i++) {
        drive_set(&d, i * 10000);
        drive_cycle(&d);
        if (i == 500)
            expect_near("speed", 10000000, 1000); /* 10000 counts a ms */
    }
    drive_cycles(&d, 400);
    expect_near("position", 10000000, 2);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_TARGET, ECT_402_STATUS_TARGET);
    assert_int_equal(drive_read(&d, 0x6061, 0), PMC_MODE_POSITION);
}

static void cyclic_speed(void **state)
{
    (void)state;
    start(0x1702);
    drive_set(&d, -3 * TURN);
    drive_cycles(&d, 500);
    expect_near("speed", -3.0 * TURN, 100);
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&d.w, "speed", text); /* turns a minute */
    assert_true(strtod(text, NULL) > -180.1 && strtod(text, NULL) < -179.9);
    int32_t before = drive_position(&d);
    drive_cycles(&d, 1000);
    expect_near("position", before - 3.0 * TURN, 100);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_TARGET, ECT_402_STATUS_TARGET);
    assert_int_equal(drive_read(&d, 0x6061, 0), PMC_MODE_SPEED);
}

/* Two turns a second against 0.45 Nm; friction is 0.05 Nm. */
static void actual_values(void **state)
{
    static const struct {
        uint16_t index;
        int32_t value, off;
    } rows[] = {
        {0x606C, 2 * TURN, 200}, {0x6074, 167, 1}, {0x6077, 167, 1},
        {0x6078, 167, 1},        {0x60F4, 0, 0},   {0x60FD, 0xC0000, 0},
    };
    (void)state;
    start(0x1702);
    signal_set(&d.w, "load", "0.45");
    drive_set(&d, 2 * TURN);
    drive_cycles(&d, 500);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t value = drive_read(&d, rows[i].index, 0);
        int32_t got = rows[i].index == 0x6074 || rows[i].index == 0x6077 || rows[i].index == 0x6078 ? (int16_t)value
                                                                                                    : (int32_t)value;
        if (got < rows[i].value - rows[i].off || got > rows[i].value + rows[i].off)
            fail_msg("%04Xh: expected %d, got %d", rows[i].index, rows[i].value, got);
    }
    assert_int_equal(drive_read(&d, 0x6063, 0), drive_read(&d, 0x6064, 0));
    assert_int_equal(drive_read(&d, 0x6062, 0), drive_read(&d, 0x6064, 0));
    assert_int_equal(signal_number(&d.w, "position"), (int32_t)drive_read(&d, 0x6064, 0));
}

/* The ramps of 6083h and 6084h: 20 turns a second at 100 turns a second squared take 200 ms each way. */
static void speed_ramp(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x6060, 0, PMC_MODE_SPEED_RAMP, 1), 0);
    start(0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 101);
    expect_near("speed", 10.0 * TURN, TURN / 3.0);
    drive_cycles(&d, 300);
    expect_near("speed", 20.0 * TURN, 1000);
    drive_set(&d, 0);
    drive_cycles(&d, 101);
    expect_near("speed", 10.0 * TURN, TURN / 3.0);
    drive_cycles(&d, 200);
    expect_near("speed", 0, 10000);
}

/* A torque on an inertia: 1 Nm on 3 + 7 kg cm2 is 1000 rad/s2, 159.155 turns a second squared. */
static void torque(void **state)
{
    (void)state;
    signal_set(&d.w, "load_inertia", "7");
    signal_set(&d.w, "friction", "0");
    start(0x1704);
    drive_set(&d, 333); /* per mille of 3 Nm */
    drive_cycle(&d);
    double from = speed();
    drive_cycles(&d, 100);
    expect_near("speed", from + 0.999 * 15.9155 * TURN, 200);
    assert_int_equal((int16_t)drive_read(&d, 0x6077, 0), 333);
    drive_set(&d, 0);
    drive_cycle(&d);
    from = speed();
    drive_cycles(&d, 100);
    expect_near("speed", from, 0.5); /* nothing holds it */
}

/* Friction and load reduce the torque: 1 Nm minus 0.3 minus 0.2 is 0.5. */
static void load_and_friction(void **state)
{
    (void)state;
    signal_set(&d.w, "load_inertia", "7");
    signal_set(&d.w, "friction", "0.3");
    start(0x1704);
    signal_set(&d.w, "load", "0.2");
    drive_set(&d, 333);
    drive_cycle(&d);
    double from = speed();
    drive_cycles(&d, 100);
    expect_near("speed", from + (0.999 - 0.5) * 15.9155 * TURN, 300);
    signal_set(&d.w, "load", "0");
    drive_set(&d, 66); /* 0.198 Nm do not overcome it */
    drive_cycles(&d, 2000);
    expect_near("speed", 0, 0);
}

static void torque_limits(void **state)
{
    (void)state;
    signal_set(&d.w, "friction", "0");
    assert_int_equal(drive_write(&d, 0x6072, 0, 100, 2), 0); /* 0.3 Nm */
    start(0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 51);
    expect_near("speed", 0.050 * 0.3 / 3e-4 / 6.283185307 * TURN, TURN / 4.0); /* 1000 rad/s2 */
    assert_int_equal((int16_t)drive_read(&d, 0x6077, 0), 100);
}

static void speed_limit(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x607F, 0, 5 * TURN, 4), 0);
    start(0x1704);
    drive_set(&d, 100);
    drive_cycles(&d, 1000);
    expect_near("speed", 5.0 * TURN, TURN / 20.0);
    assert_int_equal(drive_instance(&d)->fault, 0);
}

/* --- motion task -------------------------------------------------------------------------------------------------- */

/* 10 turns at 10 turns a second, ramps of 100 turns a second squared: 0.1 s up, 0.9 s, 0.1 s down. */
static void task(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x6060, 0, PMC_MODE_TASK, 1), 0);
    assert_int_equal(drive_write(&d, 0x607A, 0, 10 * TURN, 4), 0);
    start(0x1701);
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    assert_int_equal(drive_status(&d) & (PMC_STATUS_TASK | ECT_402_STATUS_TARGET), PMC_STATUS_TASK);
    drive_cycles(&d, 499);
    expect_near("speed", 10.0 * TURN, 20000);
    expect_near("position", 4.5 * TURN, 8000);
    unsigned int ms = 500 + drive_until(&d, PMC_STATUS_TASK, 0, 1000);
    if (ms < 1099 || ms > 1101)
        fail_msg("a task of 1100 ms took %u", ms);
    (void)drive_until(&d, ECT_402_STATUS_TARGET, ECT_402_STATUS_TARGET, 300);
    drive_cycles(&d, 400);
    expect_near("position", 10.0 * TURN, 2);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    assert_int_equal(drive_write(&d, 0x607A, 0, (uint32_t)-TURN, 4), 0);
    drive_control(&d, 0x5F); /* relative */
    drive_cycle(&d);
    (void)drive_until(&d, PMC_STATUS_TASK, 0, 1000);
    drive_cycles(&d, 600);
    expect_near("position", 9.0 * TURN, 2);
}

/* A shorter distance than the ramps need, and a new target during a motion, behind the shaft. */
static void short_and_changed_tasks(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x6060, 0, PMC_MODE_TASK, 1), 0);
    static const int32_t ways[] = {1, 100, 5000, TURN / 4};
    start(0x1701);
    for (size_t i = 0; i < COUNT(ways); i++) {
        assert_int_equal(drive_write(&d, 0x607A, 0, (uint32_t)ways[i], 4), 0);
        drive_control(&d, 0x0F);
        drive_cycle(&d);
        drive_control(&d, 0x1F);
        drive_cycles(&d, 700);
        expect_near("position", ways[i], 2);
        assert_int_equal(drive_status(&d) & PMC_STATUS_TASK, 0);
    }
    assert_int_equal(drive_write(&d, 0x607A, 0, 10 * TURN, 4), 0);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 500);
    assert_int_equal(drive_write(&d, 0x607A, 0, (uint32_t)(-2 * TURN), 4), 0);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    drive_control(&d, 0x3F); /* at once */
    drive_cycles(&d, 2000);
    expect_near("position", -2.0 * TURN, 2);
}

/* --- stopping ----------------------------------------------------------------------------------------------------- */

/* From 20 turns per second: the ramp, its time (the speed, then a standstill), its end. */
static const struct {
    const char *what;
    int16_t option;
    uint16_t control;
    unsigned int from_ms, to_ms;
    ect_402_state_t end;
    bool powered;
} stops[] = {
    {"disable voltage: coasts", 2, 0x0D, 0, 1, ECT_402_SWITCH_ON_DISABLED, false},
    {"quick stop, 500 turns a second squared", 2, 0x0B, 40, 60, ECT_402_SWITCH_ON_DISABLED, false},
    {"quick stop, option 0: coasts", 0, 0x0B, 0, 1, ECT_402_SWITCH_ON_DISABLED, false},
    {"quick stop, option 1: 100 turns a second squared", 1, 0x0B, 200, 215, ECT_402_SWITCH_ON_DISABLED, false},
    {"quick stop, option 6: stays", 6, 0x0B, 0, 1, ECT_402_QUICK_STOP, true},
    {"shutdown: 100 turns a second squared", 2, 0x0E, 200, 215, ECT_402_READY, false},
    {"disable operation", 2, 0x07, 200, 215, ECT_402_SWITCHED_ON, true},
};

static void one_stop(size_t i)
{
    static const uint16_t masks[ECT_402_STATES] = {0x4F, 0x4F, 0x6F, 0x6F, 0x6F, 0x6F, 0x4F, 0x4F};
    static const uint16_t values[ECT_402_STATES] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};
    drive_open(&d);
    assert_int_equal(drive_write(&d, 0x605A, 0, (uint16_t)stops[i].option, 2), 0);
    start(0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 500);
    expect_near("speed", 20.0 * TURN, 1000);
    drive_control(&d, stops[i].control);
    unsigned int ms = drive_until(&d, masks[stops[i].end], values[stops[i].end], 2000);
    if (ms < stops[i].from_ms || ms > stops[i].to_ms)
        fail_msg("%s: expected %u to %u ms, got %u", stops[i].what, stops[i].from_ms, stops[i].to_ms, ms);
    assert_int_equal(signal_number(&d.w, "powered"), stops[i].powered);
    drive_cycles(&d, 300);
    drive_expect(&d, stops[i].end, stops[i].what);
    if (stops[i].powered)
        expect_near("speed", 0, 1000);
    drive_close(&d);
}

static void stopping(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(stops); i++)
        one_stop(i);
}

static void halt(void **state)
{
    (void)state;
    start(0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 500);
    drive_control(&d, 0x10F);
    drive_cycles(&d, 101);
    expect_near("speed", 10.0 * TURN, TURN / 3.0);
    drive_cycles(&d, 300);
    expect_near("speed", 0, 1000);
    drive_expect(&d, ECT_402_OPERATION_ENABLED, "halt");
    drive_control(&d, 0x0F);
    drive_cycles(&d, 500);
    expect_near("speed", 20.0 * TURN, 1000);
}

/* --- limits ------------------------------------------------------------------------------------------------------- */

/* At a turn a second the shaft stops right behind the switch; the motion back is allowed, further motion is not. */
static void limit_switch(void **state)
{
    (void)state;
    signal_set(&d.w, "stop_positive", "500000");
    start(0x1702);
    drive_set(&d, TURN);
    drive_cycles(&d, 1000);
    expect_near("position", 501500, 1500);
    expect_near("speed", 0, 10);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_LIMIT, ECT_402_STATUS_LIMIT);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (PMC_N_PSTOP - 1));
    assert_int_equal(drive_instance(&d)->fault, 0);
    assert_int_equal(ect_load_le32(d.in + d.from.inputs) & 3, 2); /* PSTOP */
    drive_set(&d, -TURN);
    drive_cycles(&d, 1000);
    assert_true(drive_position(&d) < 0);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_LIMIT, 0);
    signal_set(&d.w, "stop_positive", "2147483647");
    signal_set(&d.w, "stop_negative", "-600000");
    drive_cycles(&d, 1000);
    expect_near("speed", 0, 10);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (PMC_N_NSTOP - 1));
    signal_set(&d.w, "di4", "0"); /* a broken wire looks the same */
    signal_set(&d.w, "stop_negative", "-2147483648");
    drive_cycle(&d);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (PMC_N_NSTOP - 1));
}

static void software_limits(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x6060, 0, PMC_MODE_TASK, 1), 0);
    assert_int_equal(drive_write(&d, 0x607D, 1, (uint32_t)-TURN, 4), 0);
    assert_int_equal(drive_write(&d, 0x607D, 2, TURN, 4), 0);
    assert_int_equal(drive_write(&d, 0x607A, 0, 2 * TURN, 4), 0);
    start(0x1701);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 1000);
    expect_near("position", 2.0 * TURN, 2); /* no reference yet: they do not count */
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    drive_instance(&d)->axis.homed = true;
    assert_int_equal(drive_write(&d, 0x607A, 0, 3 * TURN, 4), 0);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 1000);
    expect_near("position", TURN, 2);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_LIMIT, ECT_402_STATUS_LIMIT);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (PMC_N_SOFT_POSITIVE - 1));
}

/* --- faults ------------------------------------------------------------------------------------------------------- */

static void expect_fault(unsigned int number)
{
    if (drive_instance(&d)->fault != number)
        fail_msg("expected F%02u, got F%02u", number, drive_instance(&d)->fault);
}

/* The shaft is held fast: the error grows beyond the window of 6065h. */
static void following_error(void **state)
{
    (void)state;
    signal_set(&d.w, "friction", "20");
    start(0x1701);
    int32_t x = 0;
    while (drive_instance(&d)->fault == 0 && x < 3 * TURN) {
        x += 10000;
        drive_set(&d, x);
        drive_cycle(&d);
    }
    expect_fault(PMC_F_FOLLOWING);
    if (x < TURN || x > TURN + 30000)
        fail_msg("F03 at an error of %d counts, expected one turn", x);
    drive_cycles(&d, 20);
    drive_expect(&d, ECT_402_FAULT, "F03");
    assert_int_equal(drive_position(&d), 0);
    drive_control(&d, 0x8F); /* an edge of bit 7 resets it; the whole enabling sequence is needed again */
    drive_cycles(&d, 2);
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "reset");
    expect_fault(0);
}

static const struct {
    const char *what, *signal, *value;
    unsigned int fault; /* 0: none, the drive is simply switched off */
    ect_402_state_t state;
} supplies[] = {{"STO", "sto", "1", PMC_F_STO, ECT_402_FAULT},
                {"the DC link", "power", "0", PMC_F_UNDERVOLTAGE, ECT_402_FAULT},
                {"the enable input", "enable", "0", 0, ECT_402_SWITCH_ON_DISABLED}};

static void one_supply(size_t i)
{
    drive_open(&d);
    start(0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 200);
    signal_set(&d.w, supplies[i].signal, supplies[i].value);
    drive_cycle(&d);
    expect_fault(supplies[i].fault);
    drive_expect(&d, supplies[i].state, supplies[i].what);
    assert_true(drive_instance(&d)->axis.torque_now == 0);
    drive_control(&d, 0x80); /* reset */
    drive_cycle(&d);
    drive_control(&d, 0x06);
    drive_cycles(&d, 3);
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, supplies[i].what); /* not without it */
    signal_set(&d.w, supplies[i].signal, supplies[i].value[0] == '1' ? "0" : "1");
    drive_cycles(&d, 3);
    drive_expect(&d, ECT_402_READY, supplies[i].what);
    drive_close(&d);
}

static void supply(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(supplies); i++)
        one_supply(i);
}

static void overspeed(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x607F, 0, TURN, 4), 0);
    assert_int_equal(drive_write(&d, 0x6072, 0, 0, 2), 0);
    start(0x1702);
    signal_set(&d.w, "load", "-1"); /* the load drives, and the drive has no torque against it */
    drive_cycles(&d, 50);
    expect_fault(PMC_F_OVERSPEED);
    drive_expect(&d, ECT_402_FAULT, "overspeed");
}

/* A quick stop without sufficient torque is aborted: F30, no torque. */
static void stop_in_vain(void **state)
{
    (void)state;
    signal_set(&d.w, "load_inertia", "100");
    start(0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 2000);
    assert_int_equal(drive_write(&d, 0x6072, 0, 1, 2), 0);
    drive_control(&d, 0x0B);
    drive_cycles(&d, 255); /* 40 ms, half as much again, and 200 ms */
    drive_expect(&d, ECT_402_QUICK_STOP, "F30");
    drive_cycles(&d, 10);
    expect_fault(PMC_F_STOP);
    drive_expect(&d, ECT_402_FAULT, "F30");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-019: position set values are followed exactly", position, setup, teardown, NULL},
        {"PLZ-019: a cyclic speed is followed", cyclic_speed, setup, teardown, NULL},
        {"PLZ-019: actual values of a motion", actual_values, setup, teardown, NULL},
        {"speed with ramps", speed_ramp, setup, teardown, NULL},
        {"a torque on an inertia gives its acceleration", torque, setup, teardown, NULL},
        {"friction and load reduce the torque", load_and_friction, setup, teardown, NULL},
        {"6072h limits the torque", torque_limits, setup, teardown, NULL},
        {"607Fh limits the speed, also in torque mode", speed_limit, setup, teardown, NULL},
        {"PLZ-024 DRV-502: a motion task: bit 15 while it is active, bit 10 at its target, in its time", task, setup,
         teardown, NULL},
        {"short distances, and targets that change", short_and_changed_tasks, setup, teardown, NULL},
        {"PLZ-023 PLZ-022: falling bits: the stop, its ramp, its time, its end", stopping, NULL, NULL, NULL},
        {"PLZ-022: halt stops with the ramp, and the motion continues", halt, setup, teardown, NULL},
        {"PLZ-024: bit 11, n10, n11: limit switches block one direction", limit_switch, setup, teardown, NULL},
        {"PLZ-024: bit 11, n07: software limit switches, once there is a reference", software_limits, setup, teardown,
         NULL},
        {"F03: the following error beyond its window; an edge of bit 7 resets it", following_error, setup, teardown,
         NULL},
        {"PLZ-021 PLZ-031: STO, DC link and enable input switch the torque off at once, and are needed again", supply,
         NULL, NULL, NULL},
        {"F08: turned too fast", overspeed, setup, teardown, NULL},
        {"F30: a quick stop that does not end in its time", stop_in_vain, setup, teardown, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo motion", tests, NULL, NULL);
}
