/* SPDX-License-Identifier: MIT */
/*
 * The controllers of an axis and its ramps, one step of 250 us at a time. A Nm accelerates the motor by 100 000
 * counts/s2: the speed controller gives 1 Nm for 200 counts/s, and a turn has 2000 pi counts.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/cia402/axis.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define TURN         6283.185307179586
#define POSITION     ECT_402_LOOP_POSITION
#define SPEED        ECT_402_LOOP_SPEED
#define TORQUE       ECT_402_LOOP_TORQUE
enum { LATE = ECT_402_LATE, OVERSPEED = ECT_402_OVERSPEED };

static ect_402_config_t config;
static ect_402_plant_t plant;
static ect_402_axis_t axis;

static int prepare(void **state)
{
    (void)state;
    config = (ect_402_config_t){.turn = TURN, .rated_torque = 3, .peak_torque = 9, .inertia = 0.01};
    plant = (ect_402_plant_t){.input = {0, 0, 1, 1}};
    axis = (ect_402_axis_t){
        .config = &config,
        .plant = &plant,
        .speed_limit = 400000,
        .motor_speed = 6000,
        .quick_deceleration = 40000,
        .max_torque = 4000,
        .max_current = 4000,
        .torque_limit = {4000, 4000},
        .level = {0, 0, 1, 1},
        .mode = ECT_402_PV,
    };
    return 0;
}

static bool near(double a, double b)
{
    return fabs(a - b) < 1e-9 * (1 + fabs(b));
}

static void expect(const char *what, double want, double got)
{
    if (!near(want, got))
        fail_msg("%s: expected %.10f, got %.10f", what, want, got);
}

/* --- controllers -------------------------------------------------------------------------------------------------- */

/* The integral part grows by an eightieth of the proportional one a step. */
static void one_step(void **state)
{
    static const struct {
        const char *what;
        ect_402_reference_t reference;
        double position, speed, sum;
        int16_t ahead;
        double torque, sum_after;
        bool held;
    } rows[] = {
        {"speed", {SPEED, 0, 100, 0}, 0, 0, 0, 0, 0.5, 0.00625, false},
        {"speed with an integral part", {SPEED, 0, 100, 0}, 0, 60, 1, 0, 1.2, 1.0025, false},
        {"speed backwards", {SPEED, 0, -100, 0}, 0, 60, 0, 0, -0.8, -0.01, false},
        {"position", {POSITION, 10, 5, 0}, 8, 0, 0, 0, 0.525, 0.0065625, false},
        {"position backwards", {POSITION, 8, -5, 0}, 10, 0, 0, 0, -0.525, -0.0065625, false},
        {"position with a torque ahead", {POSITION, 10, 0, 0}, 10, 0, 0, 100, 0.3, 0, false},
        {"position with a torque ahead backwards", {POSITION, 10, 0, 0}, 10, 0, 0, -1500, -4.5, 0, false},
        {"speed without a torque ahead", {SPEED, 10, 0, 0}, 10, 0, 0, 100, 0, 0, false},
        {"speed, more than the motor has", {SPEED, 0, 10000, 0}, 0, 0, 0.25, 0, 9, 0.25, true},
        {"speed backwards, more than the motor has", {SPEED, 0, -10000, 0}, 0, 0, 0.25, 0, -9, 0.25, true},
        {"speed beyond its limit", {SPEED, 0, 400800, 0}, 0, 399800, 0, 0, 1, 0.0125, true},
        {"speed backwards beyond its limit", {SPEED, 0, -400800, 0}, 0, -399800, 0, 0, -1, -0.0125, true},
        {"torque", {TORQUE, 0, 0, 1.5}, 0, 0, 0.25, 0, 1.5, 0.25, false},
        {"torque, more than the motor has", {TORQUE, 0, 0, 10}, 0, 0, 0.25, 0, 9, 0.25, true},
        {"torque at the speed limit", {TORQUE, 0, 0, 1}, 0, 400000, 0.25, 0, 0.25, 0.25, true},
        {"torque below the speed limit", {TORQUE, 0, 0, 1}, 0, 399999, 0.25, 0, 1, 0.25, false},
        {"torque above the speed limit", {TORQUE, 0, 0, 1}, 0, 400200, 0, 0, -1, -0.0125, true},
        {"torque that brakes", {TORQUE, 0, 0, -1}, 0, 400200, 0, 0, -1, 0, false},
        {"torque backwards above the speed limit", {TORQUE, 0, 0, -1}, 0, -400200, 0, 0, 1, 0.0125, true},
        {"torque that brakes backwards", {TORQUE, 0, 0, 1}, 0, -400200, 0, 0, 1, 0, false},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.reference = rows[i].reference;
        plant.position = rows[i].position;
        plant.speed = rows[i].speed;
        axis.sum = rows[i].sum;
        axis.set.ahead = rows[i].ahead;
        ect_402_control(&axis);
        expect(rows[i].what, rows[i].torque, axis.torque_now);
        expect(rows[i].what, rows[i].sum_after, axis.sum);
        if (axis.held != rows[i].held)
            fail_msg("%s: expected bit 11 at %d", rows[i].what, rows[i].held);
        assert_int_equal(axis.troubles, 0);
    }
}

/* Speeds of less than a count a second exceed a limit of 0 in both directions. */
static void slow_torque(void **state)
{
    static const struct {
        double speed, torque, want;
        bool held;
    } rows[] = {{0.5, 1, -0.0025, true}, {-0.5, -1, 0.0025, true}, {0.5, -1, -1, false}, {-0.5, 1, 1, false}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.speed_limit = 0;
        axis.reference = (ect_402_reference_t){.loop = TORQUE, .torque = rows[i].torque};
        plant.speed = rows[i].speed;
        ect_402_control(&axis);
        if (!near(rows[i].want, axis.torque_now) || axis.held != rows[i].held)
            fail_msg("%.0f Nm at %.1f counts/s: expected %.4f, bit 11 at %d; got %.4f, %d", rows[i].torque,
                     rows[i].speed, rows[i].want, rows[i].held, axis.torque_now, axis.held);
    }
}

static void torque_limits(void **state)
{
    static const struct {
        const char *what;
        uint16_t max_torque, max_current, positive, negative;
        double forwards, backwards;
    } rows[] = {
        {"6072h", 500, 4000, 4000, 4000, 1.5, -1.5},
        {"6073h", 4000, 200, 4000, 4000, 0.6, -0.6},
        {"60E0h", 4000, 4000, 500, 4000, 1.5, -9},
        {"60E1h", 4000, 4000, 4000, 100, 9, -0.3},
        {"6072h and 60E0h", 300, 4000, 500, 100, 0.9, -0.3},
        {"the motor", 3001, 4000, 4000, 4000, 9, -9},
        {"just below the motor", 2999, 4000, 4000, 4000, 8.997, -8.997},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.max_torque = rows[i].max_torque;
        axis.max_current = rows[i].max_current;
        axis.torque_limit[0] = rows[i].positive;
        axis.torque_limit[1] = rows[i].negative;
        axis.reference = (ect_402_reference_t){.loop = TORQUE, .torque = 100};
        ect_402_control(&axis);
        expect(rows[i].what, rows[i].forwards, axis.torque_now);
        axis.reference = (ect_402_reference_t){.loop = SPEED, .speed = -100000};
        ect_402_control(&axis);
        expect(rows[i].what, rows[i].backwards, axis.torque_now);
    }
}

/* 6085h takes 10 counts/s a step. The torque of each step shows the speed that the controller follows. */
static void at_a_switch(void **state)
{
    static const struct {
        const char *what;
        int32_t direction;
        double speed, reference;
        double commands[4];
    } rows[] = {
        {"fast", 1, 25, 100, {15, 5, 0, 0}},
        {"fast backwards", -1, -25, -100, {-15, -5, 0, 0}},
        {"slower than its ramp", 1, 100, 50, {50, 50, 50, 50}},
        {"at a standstill", 1, 0, 100, {0, 0, 0, 0}},
        {"turning back", 1, -25, 100, {0, 0, 0, 0}},
        {"driving back", 1, 25, -100, {-100, -100, -100, -100}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.level[rows[i].direction > 0 ? ECT_402_POSITIVE : ECT_402_NEGATIVE] = 0;
        for (unsigned int n = 0; n < COUNT(rows[i].commands); n++) {
            plant.speed = n == 0 ? rows[i].speed : 0;
            axis.sum = 0;
            axis.reference = (ect_402_reference_t){.loop = SPEED, .speed = rows[i].reference};
            ect_402_control(&axis);
            expect(rows[i].what, (rows[i].commands[n] - plant.speed) / 200, axis.torque_now);
        }
        assert_int_equal(axis.at_switch, rows[i].reference * rows[i].direction > 0);
    }
}

static void switch_and_torque(void **state)
{
    static const struct {
        const char *what;
        bool positive, negative, homing;
        double torque, speed, given;
    } rows[] = {
        {"torque into the positive switch", false, true, false, 1, 10, -0.05},
        {"torque off the positive switch", false, true, false, -1, 10, -1},
        {"torque into the negative switch", true, false, false, -1, -10, 0.05},
        {"torque off the negative switch", true, false, false, 1, -10, 1},
        {"no switch is hit", true, true, false, -1, -10, -1},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.level[ECT_402_POSITIVE] = rows[i].positive;
        axis.level[ECT_402_NEGATIVE] = rows[i].negative;
        plant.speed = rows[i].speed;
        axis.reference = (ect_402_reference_t){.loop = TORQUE, .torque = rows[i].torque};
        ect_402_control(&axis);
        expect(rows[i].what, rows[i].given, axis.torque_now);
    }
    prepare(state);
    axis.level[ECT_402_POSITIVE] = 0;
    axis.homing.active = true;
    axis.reference = (ect_402_reference_t){.loop = SPEED, .speed = 100};
    ect_402_control(&axis);
    expect("a reference run brakes by itself", 0.5, axis.torque_now);
}

/* --- supervision -------------------------------------------------------------------------------------------------- */

/* @return the step with an error, 0: no error in a hundred steps */
static unsigned int step_of_trouble(uint8_t trouble)
{
    for (unsigned int n = 1; n <= 100; n++) {
        ect_402_control(&axis);
        assert_int_equal(axis.troubles & ~trouble, 0);
        if (axis.troubles != 0)
            return n;
    }
    return 0;
}

static void following_errors(void **state)
{
    static const struct {
        const char *what;
        ect_402_loop_t loop;
        double error;
        uint32_t window;
        uint16_t ms;
        bool positive;
        unsigned int step;
    } rows[] = {
        {"within 6065h", POSITION, 100, 100, 3, true, 0},
        {"beyond 6065h", POSITION, 100.5, 100, 3, true, 13},
        {"beyond 6065h backwards", POSITION, -100.5, 100, 3, true, 13},
        {"6066h is 0", POSITION, 101, 100, 0, true, 1},
        {"6066h is 10 ms", POSITION, 101, 100, 10, true, 41},
        {"6065h is off", POSITION, 101, 0, 0, true, 0},
        {"the smallest 6065h", POSITION, 2, 1, 0, true, 1},
        {"speed", SPEED, 101, 100, 0, true, 0},
        {"torque", TORQUE, 101, 100, 0, true, 0},
        {"at the limit switch", POSITION, 101, 100, 0, false, 0},
        {"back from the limit switch", POSITION, -101, 100, 0, false, 1},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.error_window = rows[i].window;
        axis.error_time = rows[i].ms;
        axis.level[ECT_402_POSITIVE] = rows[i].positive;
        axis.reference = (ect_402_reference_t){.loop = rows[i].loop, .position = 500};
        plant.position = 500 - rows[i].error;
        unsigned int step = step_of_trouble(LATE);
        if (step != rows[i].step)
            fail_msg("DRV-241, %s: expected the fault at step %u, got %u", rows[i].what, rows[i].step, step);
    }
}

static void error_with_a_break(void **state)
{
    prepare(state);
    axis.error_window = 100;
    axis.error_time = 3;
    axis.reference = (ect_402_reference_t){.loop = POSITION};
    for (unsigned int n = 0; n < 50; n++) {
        plant.position = n % 12 == 11 ? 100 : 101;
        ect_402_control(&axis);
    }
    assert_int_equal(axis.troubles, 0);
}

/* 6080h is 100 turns a second here; 607Fh is 64 turns a second. */
static void overspeed(void **state)
{
    static const struct {
        const char *what;
        double turns;
        bool at_once;
        unsigned int step;
    } rows[] = {
        {"within 20 %", 119.99, false, 0},        {"beyond 20 %", 120.01, false, 41},
        {"backwards", -120.01, false, 41},        {"within 20 % of 607Fh", 76.39, true, 0},
        {"beyond 20 % of 607Fh", 76.41, true, 1}, {"beyond 20 % of 607Fh alone", 76.41, false, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        config.overspeed_at_once = rows[i].at_once;
        axis.reference = (ect_402_reference_t){.loop = SPEED};
        plant.speed = rows[i].turns * TURN;
        unsigned int step = step_of_trouble(OVERSPEED);
        if (step != rows[i].step)
            fail_msg("DRV-240, %s: expected the fault at step %u, got %u", rows[i].what, rows[i].step, step);
    }
}

/* --- standing still ----------------------------------------------------------------------------------------------- */

static void standstill(void **state)
{
    static const struct {
        double reference, speed;
        bool stands;
    } rows[] = {{0, 0, true},       {0, 314.1, true}, {0, -314.1, true}, {0, 314.2, false},
                {0, -314.2, false}, {1, 0, false},    {-1, 0, false}};
    prepare(state);
    for (size_t i = 0; i < COUNT(rows); i++) {
        axis.reference.speed = rows[i].reference;
        plant.speed = rows[i].speed;
        if (ect_402_standing(&axis) != rows[i].stands)
            fail_msg("reference %f, speed %f: expected %s", rows[i].reference, rows[i].speed,
                     rows[i].stands ? "a standstill" : "a motion");
    }
}

static void expect_reference(const char *what, ect_402_loop_t loop, double position, double speed)
{
    if (axis.reference.loop != loop)
        fail_msg("%s: expected loop %d, got %d", what, (int)loop, (int)axis.reference.loop);
    expect(what, position, axis.reference.position);
    expect(what, speed, axis.reference.speed);
    expect(what, 0, axis.reference.torque);
}

static void begins(void **state)
{
    static const struct {
        double sum, speed, left;
    } rows[] = {{1, 100, 0}, {-1, -100, 0}, {1, -100, 1}, {-1, 100, -1}, {1, 0, 1}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.reference = (ect_402_reference_t){TORQUE, 7, 7, 7};
        plant.position = 50;
        plant.speed = rows[i].speed;
        axis.sum = rows[i].sum;
        ect_402_brake_begin(&axis);
        expect_reference("a ramp begins", SPEED, 0, rows[i].speed);
        expect("its integral part", rows[i].left, axis.sum);
        axis.segment_steps = 3;
        ect_402_hold_begin(&axis);
        expect_reference("a position is held", POSITION, 50, 0);
        assert_int_equal(axis.segment_steps, 0);
    }
    axis.torque_now = axis.sum = 1;
    axis.error_steps = axis.over_steps = 5;
    axis.held = true;
    ect_402_control_off(&axis);
    expect_reference("no torque", SPEED, 0, 0);
    expect("no torque", 0, axis.torque_now);
    expect("no torque, its integral part", 0, axis.sum);
    assert_int_equal(axis.error_steps, 0);
    assert_int_equal(axis.over_steps, 0);
    assert_false(axis.held);
}

/* 40 000 counts/s2 are 10 counts/s a step. */
static void braking(void **state)
{
    static const struct {
        const char *what;
        ect_402_reference_t before, after;
        double speed;
    } rows[] = {
        {"it holds already", {POSITION, 7, 0, 0}, {POSITION, 7, 0, 0}, 100},
        {"from a motion to a position", {POSITION, 7, 80, 0}, {SPEED, 0, 90, 0}, 100},
        {"from a torque", {TORQUE, 0, 0, 2}, {SPEED, 0, -90, 0}, -100},
        {"from a speed", {SPEED, 0, 50, 0}, {SPEED, 0, 40, 0}, 100},
        {"the shaft turns yet", {SPEED, 0, 5, 0}, {SPEED, 0, 0, 0}, 400},
        {"the shaft is at rest", {SPEED, 0, 5, 0}, {POSITION, 30, 0, 0}, 1},
        {"the shaft is at rest too early", {SPEED, 0, 15, 0}, {SPEED, 0, 5, 0}, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.reference = rows[i].before;
        plant.position = 30;
        plant.speed = rows[i].speed;
        ect_402_brake(&axis, 40000);
        expect_reference(rows[i].what, rows[i].after.loop, rows[i].after.position, rows[i].after.speed);
    }
}

/* --- ramps -------------------------------------------------------------------------------------------------------- */

static void numbers(void **state)
{
    static const struct {
        double from, to, most, towards;
    } rows[] = {{0, 10, 3, 3},      {8, 10, 3, 10}, {10, 0, 3, 7}, {2, 0, 3, 0},
                {-1, 1, 0.5, -0.5}, {1, -1, 3, -1}, {4, 4, 3, 4}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++)
        expect("towards", rows[i].towards, ect_402_towards(rows[i].from, rows[i].to, rows[i].most));
    expect("within", 5, ect_402_within(7, 5));
    expect("within", -5, ect_402_within(-7, 5));
    expect("within", -4, ect_402_within(-4, 5));
    expect("within", 4, ect_402_within(4, 5));
}

/* One step towards a target: rates of 10 and 20 counts/s a step, at most 100 counts/s. */
static void ramp_steps(void **state)
{
    static const struct {
        const char *what;
        double target, position, speed, position_after, speed_after;
        bool there;
    } rows[] = {
        {"from rest", 1000, 0, 0, 0.00125, 10, false},
        {"from rest backwards", -1000, 0, 0, -0.00125, -10, false},
        {"faster", 1000, 0, 50, 0.01375, 60, false},
        {"up to its speed", 1000, 0, 95, 0.024375, 100, false},
        {"at its speed", 1000, 0, 100, 0.025, 100, false},
        {"above its speed", 1000, 0, 150, 0.035, 130, false},
        {"away from its target", 1000, 0, -50, -0.01, -30, false},
        {"away from its target backwards", -1000, 0, 50, 0.01, 30, false},
        {"away from its target, slowly", 1000, 0, -5, -0.000625, 0, false},
        {"braking: the rate that ends there", 0.0625, 0, 100, 0.0225, 80, false},
        {"braking at 1.1 times the rate", 0.0625 / 1.1, 0, 100, 0.02225, 78, false},
        {"too fast: it passes its target", 0.01, 0, 100, 0.0225, 80, false},
        {"there", 0.001, 0, 0, 0.001, 0, true},
        {"there backwards", -0.001, 0, 0, -0.001, 0, true},
        {"at rest on its target", 5, 5, 0, 5, 0, true},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ect_402_reference_t r = {SPEED, rows[i].position, rows[i].speed, 0};
        bool there = ect_402_ramp(&r, rows[i].target, 100, 40000, 80000);
        expect(rows[i].what, rows[i].position_after, r.position);
        expect(rows[i].what, rows[i].speed_after, r.speed);
        if (there != rows[i].there || r.loop != POSITION)
            fail_msg("%s: expected a position loop that has%s arrived", rows[i].what, rows[i].there ? "" : " not");
    }
}

/* Whole motions: the speed stays below its limit, its changes below the rates, and the end is on the target. */
static void motions(void **state)
{
    static const struct {
        double target, speed, acceleration, deceleration;
    } rows[] = {{1000, 5000, 40000, 40000}, {1000, 5000, 40000, 10000},  {-1000, 700, 10000, 40000},
                {3, 5000, 40000, 40000},    {0.001, 5000, 40000, 40000}, {12345.678, 100000, 400000, 200000}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ect_402_reference_t r = {POSITION, 0, 0, 0};
        double size = fabs(rows[i].target);
        double before = 0;
        unsigned int steps = 0;
        bool there = false;
        for (; !there && steps < 100000; steps++) {
            there = ect_402_ramp(&r, rows[i].target, rows[i].speed, rows[i].acceleration, rows[i].deceleration);
            double up = fabs(r.speed) - fabs(before);
            assert_true(fabs(r.speed) <= rows[i].speed + 1e-9);
            assert_true(up <= rows[i].acceleration / 4000 + 1e-9);
            assert_true(-up <= 1.5 * fmax(rows[i].acceleration, rows[i].deceleration) / 4000 + 1e-9);
            assert_true(fabs(r.position) <= size + 1e-9);
            before = r.speed;
        }
        expect("its end", rows[i].target, r.position);
        double rate = 2 * rows[i].acceleration * rows[i].deceleration / (rows[i].acceleration + rows[i].deceleration);
        double top = fmin(rows[i].speed, sqrt(size * rate));
        double seconds = size / top + top / rate;
        if (fabs(steps / 4000.0 - seconds) > 0.001)
            fail_msg("to %f: expected %f s, got %f s", rows[i].target, seconds, steps / 4000.0);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A step of each controller, by reference and actual value", one_step, NULL, NULL, NULL},
        {"DRV-113: a torque at a speed limit of 0 brakes a shaft that turns its way, however slowly", slow_torque, NULL,
         NULL, NULL},
        {"DRV-239: 6072h, 6073h, 60E0h, 60E1h and the motor limit the torque", torque_limits, NULL, NULL, NULL},
        {"DRV-238: a limit switch stops a speed on 6085h", at_a_switch, NULL, NULL, NULL},
        {"DRV-238: a torque into a limit switch stops, and back is free", switch_and_torque, NULL, NULL, NULL},
        {"DRV-241: a following error beyond 6065h for longer than 6066h is a fault", following_errors, NULL, NULL,
         NULL},
        {"DRV-241: the time of 6066h has no break", error_with_a_break, NULL, NULL, NULL},
        {"DRV-240: 1.2 times 6080h for 10 ms is a fault", overspeed, NULL, NULL, NULL},
        {"A standstill is below 3 turns a minute", standstill, NULL, NULL, NULL},
        {"A ramp, a hold and an axis without torque begin from the actual value", begins, NULL, NULL, NULL},
        {"DRV-205 DRV-206: a ramp to a standstill ends in a hold", braking, NULL, NULL, NULL},
        {"Values approach others at a rate, and stay within limits", numbers, NULL, NULL, NULL},
        {"DRV-220: a step of a motion to a target, by speed and way", ramp_steps, NULL, NULL, NULL},
        {"DRV-220: motions keep their rates and end on their targets in time", motions, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("CiA 402 controllers", tests, prepare, NULL);
}
