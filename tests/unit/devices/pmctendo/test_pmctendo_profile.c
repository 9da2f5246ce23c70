/* SPDX-License-Identifier: MIT */
/* The PMCtendo by CiA 402-2, on points that the manual does not define: limits, set-points, halt, reference runs, the
 * brake of the plant; on the virtual clock. */
#include <math.h>
#include <stdlib.h>

#include "profile_bench.h"

static int setup(void **state)
{
    (void)state;
    drive_open(&d);
    return 0;
}

static void expect_position(const char *what, double want, double off)
{
    expect_near(what, want, off, drive_position(&d));
}

static unsigned int status(uint16_t mask)
{
    return drive_status(&d) & mask;
}

/* --- software limit switches -------------------------------------------------------------------------------------- */

static const struct {
    const char *what;
    int8_t mode;
    uint16_t pdo;
    int32_t out, back; /* set values towards the limit and away from it */
} limited[] = {
    {"PV", PMC_MODE_SPEED_RAMP, 0x1702, 5 * TURN, -TURN},
    {"PV, fast", PMC_MODE_SPEED_RAMP, 0x1702, 15 * TURN, -TURN},
    {"CSV", PMC_MODE_SPEED, 0x1702, 5 * TURN, -TURN},
    {"CST", PMC_MODE_TORQUE, 0x1704, 100, -100},
};

static void one_limited(size_t i, int sign)
{
    const char *what = limited[i].what;
    unsigned int n = sign > 0 ? PMC_N_SOFT_POSITIVE : PMC_N_SOFT_NEGATIVE;
    drive_open(&d);
    put(0x607D, 1, -2 * TURN, 4);
    put(0x607D, 2, 2 * TURN, 4);
    drive_instance(&d)->axis.homed = true;
    start(limited[i].mode, limited[i].pdo);
    drive_set(&d, sign * limited[i].out);
    double most = 0;
    for (unsigned int ms = 0; ms < 1500; ms++) {
        drive_cycle(&d);
        most = fmax(most, fabs((double)drive_position(&d)));
    }
    expect_position(what, sign * 2.0 * TURN, 2);
    if (most > 2.005 * TURN)
        fail_msg("%s: ran to %.4f turns with a limit of 2", what, most / TURN);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (n - 1));
    assert_int_equal(status(ECT_402_STATUS_LIMIT), ECT_402_STATUS_LIMIT);
    assert_int_equal(drive_instance(&d)->fault, 0);
    drive_set(&d, sign * limited[i].back);
    drive_cycles(&d, 60);
    assert_true(speed() * sign < -0.5 * TURN); /* back is free */
    assert_int_equal(status(ECT_402_STATUS_LIMIT), 0);
    assert_int_equal(drive_instance(&d)->warnings, 0);
    drive_close(&d);
}

static void limits_in_every_mode(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(limited); i++) {
        one_limited(i, 1);
        one_limited(i, -1);
    }
}

/* A hanging load is held at the limit at any set torque; a torque above the load lifts it back. */
static void load_at_a_limit(void **state)
{
    (void)state;
    put(0x607D, 1, -2 * TURN, 4);
    put(0x607D, 2, 2 * TURN, 4);
    drive_instance(&d)->axis.homed = true;
    start(PMC_MODE_TORQUE, 0x1704);
    signal_set(&d.w, "load", "1");
    drive_cycles(&d, 1500); /* no torque: it sinks */
    expect_position("load", -2.0 * TURN, 2);
    drive_set(&d, 200); /* 0.6 Nm */
    drive_cycles(&d, 500);
    expect_position("load", -2.0 * TURN, 2);
    drive_set(&d, 400); /* 1.2 Nm */
    drive_cycles(&d, 200);
    assert_true(drive_position(&d) > -1.9 * TURN);
}

/* The first write of a pair may cross the other limit, later writes may not. */
static void crossed_limits(void **state)
{
    (void)state;
    put(0x607D, 1, 1000, 4);
    assert_int_equal(drive_write(&d, 0x607D, 2, 500, 4), 0x06090036);
    assert_int_equal(drive_read(&d, 0x607D, 2), 0); /* the old value stays */
    put(0x607D, 2, 3000, 4);
    assert_int_equal(drive_write(&d, 0x607D, 1, 3001, 4), 0x06090036);
    assert_int_equal(drive_read(&d, 0x607D, 1), 1000);
    assert_int_equal(drive_write(&d, 0x607D, 2, (uint32_t)-1, 4), 0x06090036);
    assert_int_equal(drive_read(&d, 0x607D, 2), 3000);
    put(0x607D, 1, 3000, 4); /* equal: off */
}

/* --- 607Fh -------------------------------------------------------------------------------------------------------- */

/* 10 turns at 5 turns a second: 0.05 s up, 1.95 s, 0.05 s down, and no following error. */
static void task_above_the_speed_limit(void **state)
{
    (void)state;
    put(0x607F, 0, 5 * TURN, 4);
    put(0x6081, 0, 50u * TURN, 4);
    put(0x607A, 0, 10 * TURN, 4);
    start(PMC_MODE_TASK, 0x1701);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 1000);
    expect_near("speed", 5.0 * TURN, 20000, speed());
    unsigned int ms = 1000 + drive_until(&d, PMC_STATUS_TASK, 0, 2000);
    expect_near("task's time", 2050, 2, ms);
    (void)drive_until(&d, ECT_402_STATUS_TARGET, ECT_402_STATUS_TARGET, 300);
    assert_int_equal(drive_instance(&d)->fault, 0);
}

static void target_reached_at_the_speed_limit(void **state)
{
    (void)state;
    put(0x607F, 0, 5 * TURN, 4);
    start(PMC_MODE_SPEED_RAMP, 0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycle(&d);
    assert_int_equal(status(ECT_402_STATUS_TARGET), 0);
    (void)drive_until(&d, ECT_402_STATUS_TARGET, ECT_402_STATUS_TARGET, 200);
    drive_cycles(&d, 300);
    expect_near("speed", 5.0 * TURN, 1000, speed());
    assert_int_equal(status(ECT_402_STATUS_TARGET), ECT_402_STATUS_TARGET);
    drive_set(&d, 0);
    drive_cycles(&d, 49); /* 5 turns a second at 100 turns a second squared: from the limit, not from 20 */
    assert_true(speed() < 0.5 * TURN);
}

/* --- set-points --------------------------------------------------------------------------------------------------- */

static void set_point(uint16_t bits, int32_t target)
{
    put(0x607A, 0, target, 4);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    drive_control(&d, (uint16_t)(0x1F | bits));
    drive_cycle(&d);
}

/* Distances at 10 turns per second with ramps of 0.1 s: 20 turns take 2.1 s. */
static void start_tasks(void)
{
    start(PMC_MODE_TASK, 0x1701);
}

static void queue(void **state)
{
    (void)state;
    start_tasks();
    set_point(0, 10 * TURN); /* 1.1 s */
    drive_cycles(&d, 300);
    set_point(0, 4 * TURN);  /* waits, then 0.7 s */
    set_point(0, 30 * TURN); /* no place: ignored */
    drive_cycles(&d, 500);
    expect_near("first speed", 10.0 * TURN, 20000, speed());
    unsigned int ms = 300 + 4 + 500 + drive_until(&d, PMC_STATUS_TASK, 0, 3000);
    expect_near("time of both", 1800, 6, ms);
    drive_cycles(&d, 400);
    expect_position("the second one", 4.0 * TURN, 2);
}

static void at_once(void **state)
{
    (void)state;
    start_tasks();
    set_point(0, 10 * TURN);
    drive_cycles(&d, 398); /* at 3.5 turns */
    set_point(0, 20 * TURN);
    set_point(ECT_402_AT_ONCE, 0); /* back, and the waiting one is dropped */
    drive_cycles(&d, 100);
    expect_near("turning round", 0, 4.0 * TURN, speed());
    (void)drive_until(&d, PMC_STATUS_TASK, 0, 1000);
    drive_cycles(&d, 400);
    expect_position("the last one", 0, 2);
}

/* DRV-410: through the first target at its speed; with bit 9 off it stops there. */
static void through(void **state)
{
    (void)state;
    for (unsigned int bit9 = 0; bit9 < 2; bit9++) {
        drive_open(&d);
        start_tasks();
        set_point(0, 10 * TURN);
        put(0x6081, 0, 5 * TURN, 4);
        set_point(bit9 ? ECT_402_THROUGH : 0, 20 * TURN);
        double slowest = 1e9;
        while (drive_position(&d) < 10.05 * TURN) {
            drive_cycle(&d);
            if (drive_position(&d) > 9 * TURN)
                slowest = fmin(slowest, speed());
        }
        if (bit9 ? slowest < 4.5 * TURN : slowest > 2.0 * TURN)
            fail_msg("bit 9 %u: slowest at the first target %.2f turns/s", bit9, slowest / TURN);
        (void)drive_until(&d, PMC_STATUS_TASK, 0, 5000);
        drive_cycles(&d, 400);
        expect_position("the second target", 20.0 * TURN, 2);
        drive_close(&d);
    }
}

/* A write without an edge does not change the running task. */
static void no_edge(void **state)
{
    (void)state;
    start_tasks();
    set_point(0, 10 * TURN);
    drive_cycles(&d, 200);
    put(0x607A, 0, -5 * TURN, 4);
    put(0x6081, 0, TURN, 4);
    put(0x6084, 0, TURN, 4);
    unsigned int ms = 201 + drive_until(&d, PMC_STATUS_TASK, 0, 2000);
    expect_near("task's time", 1100, 4, ms);
    drive_cycles(&d, 400);
    expect_position("target", 10.0 * TURN, 2);
}

/* A relative target is added to the last target, whatever the position of the shaft. */
static void relative(void **state)
{
    (void)state;
    start_tasks();
    set_point(0, 10 * TURN);
    drive_cycles(&d, 300);
    set_point(ECT_402_RELATIVE | ECT_402_AT_ONCE, 2 * TURN);
    (void)drive_until(&d, PMC_STATUS_TASK, 0, 3000);
    drive_cycles(&d, 400);
    expect_position("12 turns", 12.0 * TURN, 2);
}

static void halt_keeps_the_task(void **state)
{
    (void)state;
    start_tasks();
    set_point(0, 10 * TURN);
    set_point(0, 12 * TURN);
    drive_cycles(&d, 300);
    drive_control(&d, 0x11F);
    drive_cycle(&d);
    assert_int_equal(status(ECT_402_STATUS_TARGET), 0); /* brakes */
    drive_cycles(&d, 300);
    expect_near("halted", 0, 1000, speed());
    int32_t halted_at = drive_position(&d);
    assert_in_range(halted_at, 2 * TURN, 5 * TURN);
    assert_int_equal(status(ECT_402_STATUS_TARGET | PMC_STATUS_TASK), ECT_402_STATUS_TARGET | PMC_STATUS_TASK);
    drive_control(&d, 0x1F); /* no new edge */
    (void)drive_until(&d, PMC_STATUS_TASK, 0, 3000);
    drive_cycles(&d, 400);
    expect_position("target", 12.0 * TURN, 2);
    set_point(ECT_402_HALT, 5 * TURN); /* taken while halted, executed afterwards */
    drive_cycles(&d, 200);
    expect_position("halted", 12.0 * TURN, 2);
    drive_control(&d, 0x1F);
    (void)drive_until(&d, PMC_STATUS_TASK, 0, 3000);
    drive_cycles(&d, 400);
    expect_position("target", 5.0 * TURN, 2);
}

/* Switched off and on again, no task is left. */
static void disabled_drops_the_task(void **state)
{
    (void)state;
    start_tasks();
    set_point(0, 10 * TURN);
    set_point(0, 12 * TURN);
    drive_cycles(&d, 300);
    drive_control(&d, 0x07);
    (void)drive_until(&d, 0x6F, 0x23, 300);
    int32_t halted_at = drive_position(&d);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 500);
    assert_int_equal(status(PMC_STATUS_TASK), 0);
    assert_in_range(abs(drive_position(&d) - halted_at), 0, 20000);
}

/* --- reference runs ----------------------------------------------------------------------------------------------- */

static void build_machine(double from)
{
    signal_set(&d.w, "home_at", "2097152");
    signal_set(&d.w, "home_width", "2097152"); /* 2 to 4 turns */
    signal_set(&d.w, "index_at", "262144");
    drive_instance(&d)->plant.machine.position = from;
}

/* The shaft starts in front of the switch, so that the first part is already done. */
static const struct {
    int8_t method;
    double from;
    double home;
} searches[] = {{20, -4.0 * TURN, 2.0 * TURN},
                {22, 10.0 * TURN, 4.0 * TURN},
                {4, -4.0 * TURN, 2.25 * TURN},
                {6, 10.0 * TURN, 3.25 * TURN}};

static void one_search(size_t i)
{
    drive_open(&d);
    build_machine(searches[i].from);
    put(0x6098, 0, searches[i].method, 1);
    start(PMC_MODE_HOMING, 0x1701);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 1000);
    double towards = searches[i].from < 0 ? 1 : -1;
    expect_near("speed of the search", towards * 2.0 * TURN, TURN / 50.0, speed());
    double at_edge = 0;
    while (status(PMC_STATUS_REFERENCING) != 0) {
        double before = drive_instance(&d)->plant.machine.position;
        drive_cycle(&d);
        double edge = searches[i].method > 14 ? searches[i].home : towards > 0 ? 2.0 * TURN : 4.0 * TURN;
        if ((before < edge) != (drive_instance(&d)->plant.machine.position < edge) &&
            !drive_instance(&d)->axis.homing.returning)
            at_edge = fabs(speed());
    }
    expect_near("speed at the edge that counts", TURN / 2.0, TURN / 50.0, at_edge);
    drive_cycles(&d, 300);
    expect_near("home", searches[i].home, 2, drive_instance(&d)->plant.machine.position);
    drive_close(&d);
}

static void searching_speed(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(searches); i++)
        one_search(i);
}

/* A mark shorter than the braking distance behind it. */
static void narrow_mark(void **state)
{
    (void)state;
    for (int8_t method = 20; method <= 22; method = (int8_t)(method + 2)) {
        drive_open(&d);
        signal_set(&d.w, "home_at", "2097152");
        signal_set(&d.w, "home_width", "1000");
        drive_instance(&d)->plant.machine.position = method == 20 ? 0 : 4.0 * TURN;
        put(0x6098, 0, method, 1);
        start(PMC_MODE_HOMING, 0x1701);
        drive_control(&d, 0x1F);
        drive_cycle(&d);
        (void)drive_until(&d, PMC_STATUS_REFERENCING, 0, 20000);
        drive_cycles(&d, 300);
        expect_near("home", method == 20 ? 2097152 : 2098152, 2, drive_instance(&d)->plant.machine.position);
        drive_close(&d);
    }
}

/* When bit 12 falls, the shaft is at the point, whatever its load and the width of 6067h. */
static void run_ends_at_the_point(void **state)
{
    static const struct {
        const char *load, *inertia, *friction;
        uint32_t window;
    } rows[] = {{"0", "0", "0.05", 1000}, {"1.5", "0", "0.05", 1000}, {"-1.5", "10", "0.05", 1000},
                {"0", "20", "1", 1000},   {"0", "0", "0", TURN},      {"1", "5", "0.5", TURN}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        drive_open(&d);
        build_machine(0);
        signal_set(&d.w, "load_inertia", rows[i].inertia);
        signal_set(&d.w, "friction", rows[i].friction);
        put(0x6067, 0, rows[i].window, 4);
        put(0x6098, 0, 19, 1);
        put(0x607C, 0, 777, 4);
        start(PMC_MODE_HOMING, 0x1701);
        signal_set(&d.w, "load", rows[i].load);
        drive_control(&d, 0x1F);
        drive_cycle(&d);
        (void)drive_until(&d, PMC_STATUS_REFERENCING, 0, 20000);
        expect_near("home", 2.0 * TURN, 2, drive_instance(&d)->plant.machine.position);
        expect_position("home", 777, 2);
        drive_close(&d);
    }
}

/* Halt stops a run with 609Ah, and the run continues afterwards; clearing the start bit ends it. */
static void halted_run(void **state)
{
    (void)state;
    build_machine(0);
    put(0x609A, 0, 10 * TURN, 4);
    put(0x6098, 0, 19, 1);
    start(PMC_MODE_HOMING, 0x1701);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 500);
    drive_control(&d, 0x11F);
    drive_cycles(&d, 101); /* 2 turns a second at 10 turns a second squared */
    expect_near("half way", 1.0 * TURN, TURN / 10.0, speed());
    drive_cycles(&d, 300);
    expect_near("halted", 0, 1000, speed());
    assert_int_equal(status(PMC_STATUS_REFERENCE_ERROR), 0);
    drive_control(&d, 0x1F);
    (void)drive_until(&d, PMC_STATUS_REFERENCING, 0, 20000);
    assert_int_equal(signal_number(&d.w, "homed"), 1);
    expect_near("home", 2.0 * TURN, 2, drive_instance(&d)->plant.machine.position);
}

/* --- the brake ---------------------------------------------------------------------------------------------------- */

/* A load of 1 Nm, lowered at a turn a second; STO. @return turns that it falls within `ms` */
static double fall(const char *brake, const char *delay, unsigned int ms)
{
    drive_open(&d);
    signal_set(&d.w, "brake", brake);
    signal_set(&d.w, "brake_delay", delay);
    start(PMC_MODE_SPEED, 0x1702);
    signal_set(&d.w, "load", "1");
    drive_set(&d, -TURN);
    drive_cycles(&d, 500);
    double from = drive_instance(&d)->plant.machine.position;
    signal_set(&d.w, "sto", "1");
    drive_cycles(&d, ms);
    double turns = (from - drive_instance(&d)->plant.machine.position) / TURN;
    return turns;
}

static void brake_holds_a_falling_load(void **state)
{
    (void)state;
    /* 0.95 Nm on 3 kg cm2: 504 turns a second squared; in 30 ms 0.26 turns, then 8 Nm against it. */
    double turns = fall("9", "30", 1000);
    expect_near("a brake of 9 Nm, in thousandths of a turn", 256 + 31, 30, turns * 1000);
    assert_true(speed() == 0);
    drive_close(&d);
    turns = fall("9", "100", 1000);
    assert_true(turns > 2.5 && turns < 3.5);
    assert_true(speed() == 0);
    drive_close(&d);
    turns = fall("0.5", "30", 1000); /* too weak: it slips */
    assert_true(turns > 50 && speed() < 0);
    drive_close(&d);
    turns = fall("0", "30", 1000); /* none */
    expect_near("no brake", 253, 5, turns);
    assert_true(speed() < -400.0 * TURN);
    drive_close(&d);
}

/* After a shutdown a hanging load does not sink; without a brake it falls. */
static void brake_closes_before_the_torque_ends(void **state)
{
    (void)state;
    for (unsigned int fitted = 0; fitted < 2; fitted++) {
        drive_open(&d);
        signal_set(&d.w, "brake", fitted ? "5" : "0");
        start(PMC_MODE_SPEED, 0x1702);
        signal_set(&d.w, "load", "1");
        drive_cycles(&d, 1000);
        double from = drive_instance(&d)->plant.machine.position;
        drive_control(&d, 0x06);
        drive_cycles(&d, 500);
        drive_expect(&d, ECT_402_READY, "shutdown");
        double sunk = from - drive_instance(&d)->plant.machine.position;
        if (fitted ? fabs(sunk) > 1 : sunk < 10.0 * TURN)
            fail_msg("brake %u: sunk by %.0f counts", fitted, sunk);
        drive_close(&d);
    }
}

/* A load beyond the torque of the brake turns the shaft as soon as it is set. */
static void brake_slips(void **state)
{
    (void)state;
    drive_operational(&d, 0x1702, 0x1B25);
    signal_set(&d.w, "load", "9");
    drive_cycles(&d, 100);
    assert_int_equal(drive_position(&d), 0);
    signal_set(&d.w, "load", "9.1");
    drive_cycles(&d, 100);
    assert_true(drive_position(&d) < -1000);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"DRV-236: 607Dh stops PV, CSV and CST at the limit: n06, n07, bit 11; the motion back is allowed",
         limits_in_every_mode, NULL, NULL, NULL},
        {"DRV-236: 607Dh holds a load in CST", load_at_a_limit, setup, teardown, NULL},
        {"DRV-096: 607Dh with min > max is refused with 06090036", crossed_limits, setup, teardown, NULL},
        {"DRV-220 DRV-405: 6081h above 607Fh moves at 607Fh, without a fault", task_above_the_speed_limit, setup,
         teardown, NULL},
        {"DRV-246: bit 10 in PV applies to the limited target", target_reached_at_the_speed_limit, setup, teardown,
         NULL},
        {"DRV-210 DRV-217 DRV-409: one set-point runs, one waits, a third one is ignored", queue, setup, teardown,
         NULL},
        {"DRV-211 DRV-408: bit 5 changes to the new set-point at once and drops the waiting one", at_once, setup,
         teardown, NULL},
        {"DRV-212 DRV-410: bit 9 passes the first target at its speed", through, NULL, NULL, NULL},
        {"DRV-215: set values without an edge of bit 4 change nothing", no_edge, setup, teardown, NULL},
        {"DRV-213 DRV-222: a relative target is added to the last one", relative, setup, teardown, NULL},
        {"DRV-214 DRV-205 DRV-406: halt keeps the set-points: executed or continued", halt_keeps_the_task, setup,
         teardown, NULL},
        {"DRV-130: disabling discards the set-points", disabled_drops_the_task, setup, teardown, NULL},
        {"DRV-274 DRV-275: methods 4, 6, 20, 22 search at 6099h:1 if the first part is already done", searching_speed,
         NULL, NULL, NULL},
        {"DRV-275: a mark shorter than the braking distance", narrow_mark, NULL, NULL, NULL},
        {"DRV-268 DRV-276: a run ends exactly at the point", run_ends_at_the_point, NULL, NULL, NULL},
        {"DRV-273: halt stops a run with 609Ah, and the run continues", halted_run, setup, teardown, NULL},
        {"DRV-152: a brake holds a hanging load at STO; without one it falls", brake_holds_a_falling_load, NULL, NULL,
         NULL},
        {"DRV-134 DRV-133: the brake closes before the torque is off", brake_closes_before_the_torque_ends, NULL, NULL,
         NULL},
        {"DRV-152: a load beyond the brake's torque slips", brake_slips, setup, teardown, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo against CiA 402-2", tests, NULL, NULL);
}
