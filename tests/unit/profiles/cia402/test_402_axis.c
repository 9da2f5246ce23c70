/* SPDX-License-Identifier: MIT */
/* An axis of the profile alone, without a product: the times and places of ideal motions in mode 1. Steps of 250 us. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/cia402/axis.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
enum { STEPS_A_MS = ECT_402_STEPS_PER_S / 1000, ENABLED = 0x0F, START = 0x1F };

static const ect_402_config_t config = {.turn = 10000, .rated_torque = 3, .peak_torque = 9, .inertia = 3e-4};
static ect_402_plant_t plant;
static ect_402_axis_t axis;
static uint32_t steps; /* since the first set-point */

static void control(uint16_t word)
{
    uint16_t rising = word & (uint16_t)~axis.set.control;
    axis.set.control = word;
    ect_402_settle(&axis, rising);
    ect_402_set_values(&axis, rising);
}

static void step(void)
{
    axis.time_ns += ECT_402_STEP_NS;
    ect_402_settle(&axis, 0);
    ect_402_step(&axis);
    assert_int_equal(axis.troubles, 0);
    steps++;
}

static void until_ms(uint32_t ms)
{
    while (steps < ms * STEPS_A_MS)
        step();
}

/* 50 000 counts/s, ramps of 100 000 counts/s2, enabled at 0. */
static int setup(void **state)
{
    (void)state;
    plant = (ect_402_plant_t){.brake = 9, .input = {0, 0, 1, 1}};
    axis = (ect_402_axis_t){
        .config = &config,
        .plant = &plant,
        .task_speed = 50000,
        .acceleration = 100000,
        .deceleration = 100000,
        .quick_deceleration = 500000,
        .most_acceleration = UINT32_MAX,
        .most_deceleration = UINT32_MAX,
        .speed_limit = 1000000,
        .motor_speed = 6000,
        .error_window = 10000,
        .position_window = 10,
        .max_torque = 3000,
        .max_current = 3000,
        .torque_limit = {3000, 3000},
        .quick_option = 2,
        .shutdown_option = 1,
        .disable_option = 1,
        .halt_option = 1,
        .fault_option = 2,
        .mode = ECT_402_PP,
        .live = true,
        .conditions = {.supplied = true, .resettable = true, .by_level = true},
    };
    ect_402_read_levels(&axis);
    control(0x06);
    control(ENABLED);
    assert_int_equal(axis.state, ECT_402_OPERATION_ENABLED);
    steps = 0;
    return 0;
}

static void set_point(uint16_t bits, int32_t target)
{
    axis.target = target;
    control(ENABLED);
    control((uint16_t)(START | bits));
}

static void expect_end(const char *what, double want_ms, double off_ms)
{
    while (ect_402_task_active(&axis) && steps < 20000 * STEPS_A_MS)
        step();
    double ms = (double)steps / (double)STEPS_A_MS;
    if (fabs(ms - want_ms) > off_ms)
        fail_msg("%s: expected its end after %.0f ms, got %.2f", what, want_ms, ms);
}

static void expect_near(const char *what, double want, double off, double got)
{
    if (fabs(got - want) > off)
        fail_msg("%s: expected %.0f +- %.0f, got %.1f", what, want, off, got);
}

static void trapezoids(void **state)
{
    static const struct {
        const char *what;
        int32_t target;
        uint32_t deceleration, limit;
        double ms;
    } rows[] = {{"DRV-401", 100000, 100000, 1000000, 2500},
                {"DRV-402", 10000, 100000, 1000000, 632.5},
                {"DRV-403", 100000, 50000, 1000000, 2750},
                {"DRV-405", 100000, 100000, 20000, 5200},
                {"DRV-401 backwards", -100000, 100000, 1000000, 2500}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        setup(state);
        axis.deceleration = rows[i].deceleration;
        axis.speed_limit = rows[i].limit;
        set_point(0, rows[i].target);
        expect_end(rows[i].what, rows[i].ms, 2);
        until_ms((uint32_t)rows[i].ms + 400);
        expect_near(rows[i].what, rows[i].target, 1, plant.position);
        assert_true(ect_402_reached(&axis));
    }
}

static void halted(void **state)
{
    (void)state;
    set_point(0, 100000);
    until_ms(1000);
    expect_near("at 1 s", 37500, 100, axis.reference.position);
    control(START | ECT_402_HALT);
    until_ms(1450);
    assert_false(ect_402_reached(&axis));
    until_ms(1600);
    expect_near("halted", 50000, 300, plant.position);
    assert_true(ect_402_reached(&axis));
    until_ms(3000);
    control(START);
    expect_end("DRV-406", 4500, 10);
    until_ms(5000);
    expect_near("at the same target", 100000, 1, plant.position);
}

static void quick_stop(void **state)
{
    (void)state;
    axis.quick_option = 6;
    set_point(0, 100000);
    until_ms(1000);
    control(0x0B);
    until_ms(1150);
    expect_near("DRV-407", 40000, 400, plant.position);
    assert_int_equal(axis.state, ECT_402_QUICK_STOP);
    assert_true(ect_402_reached(&axis));
    control(ENABLED);
    assert_int_equal(axis.state, ECT_402_OPERATION_ENABLED);
    until_ms(2000);
    expect_near("no set-point is left", 40000, 400, plant.position);
}

static void changed(void **state)
{
    (void)state;
    set_point(0, 100000);
    until_ms(1000);
    set_point(ECT_402_AT_ONCE, 0);
    until_ms(1500);
    expect_near("DRV-408, where it turns", 50000, 100, axis.reference.position);
    expect_end("DRV-408", 3000, 5);
    setup(state);
    set_point(0, 100000);
    until_ms(1000);
    set_point(0, 0);
    control(ENABLED);
    assert_int_equal(ect_402_mode_bits(&axis) & ECT_402_STATUS_ATTAINED, ECT_402_STATUS_ATTAINED);
    until_ms(2495);
    assert_int_equal(ect_402_mode_bits(&axis) & ECT_402_STATUS_ATTAINED, ECT_402_STATUS_ATTAINED);
    until_ms(2505);
    assert_int_equal(ect_402_mode_bits(&axis) & ECT_402_STATUS_ATTAINED, 0);
    expect_end("DRV-409", 5000, 5);
}

static void blended(void **state)
{
    for (unsigned int bit9 = 0; bit9 < 2; bit9++) {
        setup(state);
        set_point(0, 100000);
        axis.task_speed = 25000;
        set_point(bit9 ? ECT_402_THROUGH : 0, 200000);
        until_ms(2250);
        if (bit9)
            expect_near("DRV-410, the first target", 100000, 100, axis.reference.position);
        expect_end("DRV-410", bit9 ? 6250 : 6750, 5);
    }
}

/* The second target lies beyond the first one, or before it, on both sides of 0. */
static void through_on_both_sides(void **state)
{
    static const struct {
        const char *what;
        int32_t start, first, second;
        double ms;
    } rows[] = {{"up to 0", -300000, -200000, -100000, 6250},        {"down to 0", 300000, 200000, 100000, 6250},
                {"down from 0", 0, -100000, -200000, 6250},          {"through 0", -100000, 0, 100000, 6250},
                {"a turn below 0", -200000, -100000, -200000, 6750}, {"a turn above 0", 200000, 100000, 200000, 6750}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        setup(state);
        plant.position = axis.reference.position = rows[i].start;
        set_point(0, rows[i].first);
        axis.task_speed = 25000;
        set_point(ECT_402_THROUGH, rows[i].second);
        expect_end(rows[i].what, rows[i].ms, 5);
        expect_near(rows[i].what, rows[i].second, 1, axis.reference.position);
    }
}

static void relative(void **state)
{
    (void)state;
    for (unsigned int n = 1; n <= 3; n++) {
        set_point(ECT_402_RELATIVE, 1000);
        while (!ect_402_reached(&axis) && steps < 5000 * STEPS_A_MS)
            step();
    }
    until_ms(6000);
    expect_near("DRV-411", 3000, 1, plant.position);
}

/* DRV-404: the target is passed at 6082h; without another set-point the shaft stops behind it, 500 counts on. */
static void end_speed(void **state)
{
    (void)state;
    axis.end_speed = 10000;
    set_point(0, 100000);
    expect_end("DRV-404", 2410, 5);
    expect_near("DRV-404, speed at the target", 10000, 100, axis.reference.speed);
    until_ms(2600);
    expect_near("behind the target", 100500, 50, plant.position);
    axis.end_speed = 10000;
    steps = 0;
    set_point(0, 0);
    axis.end_speed = 0;
    set_point(0, -50000);
    expect_end("the next set-point goes on from 6082h", 2415 + 1000 + 400, 300);
    expect_near("and ends at its target", -50000, 1, axis.reference.position);
}

/* The demand goes on while a position is followed; after braking by speed it begins at the shaft. */
static void demands(void **state)
{
    static const struct {
        ect_402_loop_t loop;
        double demand, first;
    } rows[] = {{ECT_402_LOOP_POSITION, 300, 300}, {ECT_402_LOOP_SPEED, 300, 295}, {ECT_402_LOOP_TORQUE, 0, 295}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        setup(state);
        plant.position = 295;
        axis.reference = (ect_402_reference_t){.loop = rows[i].loop, .position = rows[i].demand};
        axis.options = 1; /* relative to the demand */
        set_point(ECT_402_RELATIVE, 1000);
        expect_near("DRV-222, the target", rows[i].first + 1000, 1e-9, axis.task_target);
        expect_near("the demand", rows[i].first, 1e-9, axis.reference.position);
    }
}

/* The second target is within the window of the first one: bit 10 is 0 until it is reached itself. */
static void queued(void **state)
{
    (void)state;
    set_point(0, 1000);
    set_point(0, 1005);
    assert_true(axis.next.valid);
    while (axis.next.valid && steps < 5000 * STEPS_A_MS)
        step();
    expect_near("DRV-210, the first target", 1000, 1, axis.reference.position);
    assert_true(axis.task);
    assert_false(axis.task_reached);
    assert_false(ect_402_reached(&axis));
    while (ect_402_task_active(&axis) && steps < 5000 * STEPS_A_MS)
        step();
    expect_near("the second target", 1005, 1e-9, axis.reference.position);
    assert_true(axis.task_reached);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"DRV-401 DRV-402 DRV-403 DRV-405: the time of a trapezoid, a triangle, two ramps, a limit", trapezoids, NULL,
         NULL, NULL},
        {"DRV-406: halt and on", halted, setup, NULL, NULL},
        {"DRV-407: quick stop on 6085h, 605Ah 6", quick_stop, setup, NULL, NULL},
        {"DRV-408 DRV-409: a new target at once, or after the first one", changed, setup, NULL, NULL},
        {"DRV-410: two set-points with and without a stop between them", blended, NULL, NULL, NULL},
        {"DRV-410: bit 9 passes a first target that lies before the second, on both sides of 0", through_on_both_sides,
         NULL, NULL, NULL},
        {"DRV-219 DRV-404: 6082h, the speed at the target", end_speed, setup, NULL, NULL},
        {"DRV-210 DRV-218: bit 10 between two targets", queued, setup, NULL, NULL},
        {"DRV-222: the first demand of a set-point", demands, setup, NULL, NULL},
        {"DRV-411: relative set-points add up", relative, setup, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("CiA 402 axis", tests, NULL, NULL);
}
