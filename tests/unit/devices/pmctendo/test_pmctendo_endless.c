/* SPDX-License-Identifier: MIT */
/*
 * An axis without limit switches is endless: position values wrap at 2^32 counts, set values are differences of 32
 * bits. Several 2^32 counts in each mode, on the virtual clock.
 */
#include <math.h>
#include <stdlib.h>

#include "support/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define TURN         PMC_TURN
#define WRAP         4294967296.0 /* 2^32 counts, 4096 turns */
enum { FAST = 1000, FASTER = 1200 /* turns a second */ };

static drive_t d;

static void open_at(double machine)
{
    drive_open(&d);
    drive_instance(&d)->plant.machine.position = machine;
    assert_int_equal(drive_write(&d, 0x607F, 0, FASTER * (uint32_t)TURN, 4), 0);
    assert_int_equal(drive_write(&d, 0x6080, 0, FASTER * 60, 4), 0);
}

static void start(int8_t mode, uint16_t out)
{
    assert_int_equal(drive_write(&d, 0x6060, 0, (uint8_t)mode, 1), 0);
    drive_operational(&d, out, 0x1B25);
    drive_enable(&d);
}

static int32_t difference(int32_t from, int32_t to)
{
    return (int32_t)((uint32_t)to - (uint32_t)from);
}

static void expect_free(const char *when)
{
    const pmctendo_t *u = drive_instance(&d);
    if (u->fault != 0 || u->warnings != 0 || (drive_status(&d) & (ECT_402_STATUS_LIMIT | ECT_402_STATUS_WARNING)) != 0)
        fail_msg("%s, position %d, %.0f on the machine: F%02u, warnings %X, status %04X", when, drive_position(&d),
                 u->plant.machine.position, u->fault, u->warnings, drive_status(&d));
    assert_int_equal(ect_load_le32(d.in + d.from.inputs) & 3, 0); /* no limit switch */
}

/* Each cycle of a constant speed is the same distance, wherever the position wraps. */
static void turn_steadily(const char *when, double speed, unsigned int cycles)
{
    for (unsigned int n = 0; n < cycles; n++) {
        int32_t before = drive_position(&d);
        drive_cycle(&d);
        int32_t way = difference(before, drive_position(&d));
        if (fabs(way - speed / 1000) > TURN / 1000.0)
            fail_msg("%s, cycle %u: expected %.0f counts on from %d, got %d", when, n, speed / 1000, before, way);
        expect_free(when);
    }
}

static const struct {
    const char *what;
    int8_t mode;
    int32_t turns_s;
    double from; /* machine */
    unsigned int cycles;
} speeds[] = {
    {"cyclic speed up", PMC_MODE_SPEED, FAST, 0, 13000},
    {"cyclic speed down", PMC_MODE_SPEED, -FAST, 0, 13000},
    {"90 turns a second over 2^31", PMC_MODE_SPEED, 90, WRAP / 2 - 50.0 * TURN, 1000},
    {"speed with ramps up", PMC_MODE_SPEED_RAMP, FAST, 0, 13000},
    {"speed with ramps down", PMC_MODE_SPEED_RAMP, -FAST, 0, 13000},
    {"-95 turns a second over -2^31", PMC_MODE_SPEED_RAMP, -95, -WRAP / 2 + 50.0 * TURN, 1000},
};

static void one_speed(size_t i)
{
    open_at(speeds[i].from);
    assert_int_equal(drive_write(&d, 0x6083, 0, 4000u * TURN, 4), 0);
    start(speeds[i].mode, 0x1702);
    drive_set(&d, speeds[i].turns_s * TURN);
    drive_cycles(&d, 800);
    expect_free(speeds[i].what);
    turn_steadily(speeds[i].what, (double)speeds[i].turns_s * TURN, speeds[i].cycles);
    if (speeds[i].cycles > 10000)
        assert_true(fabs(drive_instance(&d)->plant.machine.position) > 3 * WRAP);
    drive_close(&d);
}

static void speed(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(speeds); i++)
        one_speed(i);
}

/* Set values of a master whose int32 wraps. */
static void follow(int32_t step)
{
    open_at(0);
    start(PMC_MODE_POSITION, 0x1701);
    int64_t master = 0;
    int32_t set = drive_position(&d), way = 0, most = 0;
    for (unsigned int n = 0; n < 14000; n++) {
        if (n < 400 || n >= 13600)
            way += n < 400 ? step / 400 : -step / 400; /* up, and down again */
        set = (int32_t)((uint32_t)set + (uint32_t)way);
        master += way;
        drive_set(&d, set);
        drive_cycle(&d);
        int32_t off = abs(difference(drive_position(&d), set));
        most = off > most ? off : most;
        expect_free("CSP");
    }
    assert_true(most < 2 * abs(step)); /* a cycle behind */
    drive_cycles(&d, 500);
    assert_in_range(labs((long)difference(drive_position(&d), set)), 0, 2);
    if (master < 0 ? master > -3 * (int64_t)WRAP : master < 3 * (int64_t)WRAP)
        fail_msg("expected more than three times 2^32 counts, got %lld", (long long)master);
    assert_true(fabs(drive_instance(&d)->plant.machine.position - (double)master) <= 2);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_TARGET, ECT_402_STATUS_TARGET);
    drive_close(&d);
}

static void position(void **state)
{
    (void)state;
    follow(FAST * (TURN / 1000));
    follow(-FAST * (TURN / 1000));
}

/* DRV-416: from 2147483600 to -2147483600 is one step of 96 counts. */
static void one_step(void **state)
{
    (void)state;
    open_at(2147483600.0);
    start(PMC_MODE_POSITION, 0x1701);
    drive_set(&d, 2147483600);
    drive_cycles(&d, 50);
    drive_set(&d, -2147483600);
    drive_cycles(&d, 500);
    expect_free("a step over 2^31");
    assert_in_range(labs((long)difference(drive_position(&d), -2147483600)), 0, 2);
    assert_true(fabs(drive_instance(&d)->plant.machine.position - 2147483696.0) <= 2);
    assert_int_equal((int32_t)drive_read(&d, 0x6062, 0), -2147483600);
    drive_close(&d);
}

static void task_to(int32_t target, uint16_t relative, double machine)
{
    assert_int_equal(drive_write(&d, 0x607A, 0, (uint32_t)target, 4), 0);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    drive_control(&d, 0x1F | relative);
    drive_cycle(&d);
    (void)drive_until(&d, PMC_STATUS_TASK, 0, 20000);
    drive_cycles(&d, 500);
    double at = drive_instance(&d)->plant.machine.position;
    if (fabs(at - machine) > 2)
        fail_msg("task to %d: expected %.0f on the machine, got %.0f", target, machine, at);
    expect_free("task");
}

/* An absolute task takes the shorter way, relative ones add up. */
static void tasks(void **state)
{
    (void)state;
    open_at(2147483647.0 - 3.0 * TURN);
    assert_int_equal(drive_write(&d, 0x6081, 0, FAST * (uint32_t)TURN, 4), 0);
    assert_int_equal(drive_write(&d, 0x6083, 0, 2000u * TURN, 4), 0);
    assert_int_equal(drive_write(&d, 0x6084, 0, 2000u * TURN, 4), 0);
    start(PMC_MODE_TASK, 0x1701);
    double at = -2147483648.0 + 2.0 * TURN + WRAP;
    task_to(INT32_MIN + 2 * TURN, 0, at);
    for (unsigned int n = 0; n < 7; n++) {
        at += 2000.0 * TURN;
        task_to(2000 * TURN, ECT_402_RELATIVE, at);
    }
    assert_true(at > 3 * WRAP);
    drive_close(&d);
}

/* Latch, index pulse and reference run have no limit either. */
static void latch_and_reference(void **state)
{
    (void)state;
    open_at(3 * WRAP + TURN / 4.0);
    assert_int_equal(drive_write(&d, 0x6098, 0, 34, 1), 0);
    assert_int_equal(drive_write(&d, 0x607C, 0, 1000, 4), 0);
    drive_operational(&d, 0x1720, 0x1B25);
    drive_enable(&d);
    drive_control(&d, 0x80F);
    (void)drive_until(&d, PMC_STATUS_REFERENCING, PMC_STATUS_REFERENCING, 2);
    (void)drive_until(&d, PMC_STATUS_REFERENCING, 0, 20000);
    drive_cycles(&d, 300);
    assert_true(fabs(drive_instance(&d)->plant.machine.position - (3 * WRAP + TURN)) <= 2);
    assert_in_range(drive_position(&d), 998, 1002);
    drive_latch(&d, 0x0510);
    drive_set(&d, drive_position(&d));
    drive_control(&d, 0x0F);
    for (int32_t i = 1; i <= 60; i++) {
        drive_set(&d, 1000 + i * (TURN / 50));
        drive_cycle(&d);
    }
    drive_cycles(&d, 100);
    assert_int_equal(drive_latch_status(&d) & 0x0F10, 0x0510);
    assert_int_equal(drive_latched(&d, 1), 1000 + TURN);
    drive_close(&d);
}

/* A switch at the very end of the range is a switch; none is a state of its own. */
static void no_switch_is_a_state(void **state)
{
    (void)state;
    open_at(2147483647.0 - 1000);
    assert_int_equal(signal_number(&d.w, "stop_positive_fitted"), 0);
    assert_int_equal(signal_number(&d.w, "stop_negative_fitted"), 0);
    signal_set(&d.w, "stop_positive", "1000");
    assert_int_equal(signal_number(&d.w, "stop_positive_fitted"), 1);
    signal_set(&d.w, "stop_positive", "2147483647");
    assert_int_equal(signal_number(&d.w, "stop_positive_fitted"), 0);
    signal_set(&d.w, "stop_negative", "-1000");
    assert_int_equal(signal_number(&d.w, "stop_negative_fitted"), 1);
    signal_set(&d.w, "stop_negative_fitted", "0");
    start(PMC_MODE_SPEED, 0x1702);
    drive_set(&d, TURN);
    drive_cycles(&d, 200);
    expect_free("no switch");
    assert_true(drive_instance(&d)->plant.machine.position > INT32_MAX);
    signal_set(&d.w, "stop_positive_fitted", "1");
    drive_cycles(&d, 200);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (PMC_N_PSTOP - 1));
    assert_int_equal(ect_load_le32(d.in + d.from.inputs) & 3, 2);
    assert_true(fabs(drive_instance(&d)->plant.machine.speed) < 10);
    drive_close(&d);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"DRV-232: CSV and PV turn over several 2^32 counts in both directions, without stop, limit bit or fault",
         speed, NULL, NULL, NULL},
        {"DRV-232 DRV-233: CSP follows set values that wrap, over several 2^32 counts in both directions, exactly",
         position, NULL, NULL, NULL},
        {"DRV-233 DRV-416: 2147483600 to -2147483600 is a step of 96 counts", one_step, NULL, NULL, NULL},
        {"DRV-232: motion tasks over 2^31, absolute and relative", tasks, NULL, NULL, NULL},
        {"DRV-232: reference run and latch beyond 2^32", latch_and_reference, NULL, NULL, NULL},
        {"DRV-238: no limit switch is a state of its own", no_switch_is_a_state, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo endless axis", tests, NULL, NULL);
}
