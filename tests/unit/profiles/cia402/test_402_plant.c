/* SPDX-License-Identifier: MIT */
/*
 * The plant of an axis, one step of 250 us at a time: torque, load, friction, brake; edges of marks, limit switches and
 * the index pulse. The shaft gains 25 counts/s a step from each Nm, and a turn has 2000 pi counts.
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
enum { P = ECT_402_PROBE, H = ECT_402_HOME, UP = ECT_402_POSITIVE, DOWN = ECT_402_NEGATIVE, I = ECT_402_INDEX };
enum { MOST = 5 };

static const ect_402_config_t config = {.turn = TURN, .rated_torque = 3, .peak_torque = 9, .inertia = 0.01};
static ect_402_plant_t plant;
static ect_402_axis_t axis;

static int prepare(void **state)
{
    (void)state;
    plant = (ect_402_plant_t){.input = {0, 0, 1, 1}, .index_at = 3000};
    axis = (ect_402_axis_t){.config = &config, .plant = &plant, .level = {0, 0, 1, 1}, .time_ns = 1000000};
    return 0;
}

static bool near(double a, double b)
{
    return fabs(a - b) < 1e-6;
}

/* --- torque and speed --------------------------------------------------------------------------------------------- */

static void speeds(void **state)
{
    enum { ON = true, OFF = false };
    static const struct {
        const char *what;
        double torque, load, load_inertia, friction, brake, speed, after;
        bool powered;
    } rows[] = {
        {"torque", 2, 0, 0, 0, 0, 0, 50, ON},
        {"torque backwards on a shaft that turns", -2, 0, 0, 0, 0, 80, 30, ON},
        {"torque less the load", 2, 1.5, 0, 0, 0, 0, 12.5, ON},
        {"a load of the motor's inertia", 2, 0, 100, 0, 0, 0, 25, ON},
        {"friction", 2, 0, 0, 0.5, 0, 0, 37.5, ON},
        {"friction backwards", -2, 0, 0, 0.5, 0, 0, -37.5, ON},
        {"friction slows", 0, 0, 0, 0.5, 0, 20, 7.5, ON},
        {"friction slows backwards", 0, 0, 0, 0.5, 0, -20, -7.5, ON},
        {"friction stops", 0, 0, 0, 0.5, 0, 12, 0, ON},
        {"friction stops backwards", 0, 0, 0, 0.5, 0, -12, 0, ON},
        {"friction holds against a load", 0, 0.4, 0, 0.5, 0, 0, 0, ON},
        {"the load wins against friction", 0, 0.6, 0, 0.5, 0, 0, -2.5, ON},
        {"no power, no torque", 2, 0, 0, 0, 0, 0, 0, OFF},
        {"no power, the load falls", 2, 1, 0, 0, 0, 0, -25, OFF},
        {"the brake is open with power", 2, 0, 0, 0, 9, 0, 50, ON},
        {"the brake is closed without power", 0, 2, 0, 0, 9, 0, 0, OFF},
        {"a weak brake and friction", 0, 2, 0, 0.25, 1.25, 0, -12.5, OFF},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        plant.load = rows[i].load;
        plant.load_inertia = rows[i].load_inertia;
        plant.friction = rows[i].friction;
        plant.brake = rows[i].brake;
        plant.speed = rows[i].speed;
        plant.position = 100;
        axis.torque_now = rows[i].torque;
        ect_402_motor_step(&axis, rows[i].powered);
        if (!near(plant.speed, rows[i].after))
            fail_msg("%s: expected %f counts/s, got %f", rows[i].what, rows[i].after, plant.speed);
        if (!near(plant.position, 100 + (rows[i].speed + rows[i].after) / 2 / 4000))
            fail_msg("%s: expected the way of the mean speed, got position %f", rows[i].what, plant.position);
    }
}

static void brakes(void **state)
{
    static const struct {
        const char *what;
        bool live, powered;
        uint32_t outputs, mask;
        uint64_t closes_ns;
        bool closed;
    } rows[] = {
        {"60FEh closes it", true, true, 1, 1, 0, true},
        {"60FEh with other bits", true, true, 0x10001, 0x10003, 0, true},
        {"60FEh without its mask", true, true, 1, 0, 0, false},
        {"60FEh opens it", true, true, 0, 1, 0, false},
        {"60FEh, another bit", true, true, 2, 2, 0, false},
        {"60FEh does not count", false, true, 1, 1, 0, false},
        {"before its delay", false, false, 0, 0, 1000001, false},
        {"at the end of its delay", false, false, 0, 0, 1000000, true},
        {"with power", false, true, 0, 0, 999999, false},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        plant.load = 1;
        plant.brake = 2;
        axis.live = rows[i].live;
        axis.physical[0] = rows[i].outputs;
        axis.physical[1] = rows[i].mask;
        axis.brake_ns = rows[i].closes_ns;
        ect_402_motor_step(&axis, rows[i].powered);
        if (!near(plant.speed, rows[i].closed ? 0 : -25))
            fail_msg("%s: expected a brake that is %s, got %f counts/s", rows[i].what,
                     rows[i].closed ? "closed" : "open", plant.speed);
    }
}

static void jams(void **state)
{
    prepare(state);
    plant.jam = 1;
    plant.speed = 40;
    axis.torque_now = 2;
    ect_402_motor_step(&axis, true);
    assert_true(near(plant.speed, 0));
}

static void at_rest(void **state)
{
    static const struct {
        const char *what;
        double speed, load, friction, brake;
        uint8_t jam;
        bool rests;
    } rows[] = {
        {"nothing turns it", 0, 0, 0, 0, 0, true},
        {"as much friction as load", 0, 1, 1, 0, 0, true},
        {"as much friction as load upwards", 0, -1, 1, 0, 0, true},
        {"more load than friction", 0, 1.001, 1, 0, 0, false},
        {"more load upwards than friction", 0, -1.001, 1, 0, 0, false},
        {"friction and brake", 0, 3, 1, 2, 0, true},
        {"more than friction and brake", 0, 3.001, 1, 2, 0, false},
        {"stuck", 0, 9, 0, 0, 1, true},
        {"turning", 0.001, 0, 1, 0, 0, false},
        {"turning backwards", -0.001, 0, 1, 0, 0, false},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        plant.speed = rows[i].speed;
        plant.load = rows[i].load;
        plant.friction = rows[i].friction;
        plant.brake = rows[i].brake;
        plant.jam = rows[i].jam;
        if (ect_402_motor_rests(&axis) != rows[i].rests)
            fail_msg("%s: expected that the shaft %s", rows[i].what, rows[i].rests ? "rests" : "moves");
    }
}

/* --- numbers ------------------------------------------------------------------------------------------------------ */

static void whole_counts(void **state)
{
    static const struct {
        double counts;
        int32_t wrapped, saturated;
    } rows[] = {
        {0.49, 0, 0},
        {0.5, 1, 1},
        {-0.5, 0, 0},
        {-0.51, -1, -1},
        {-1, -1, -1},
        {-7.25, -7, -7},
        {2147483646.25, 2147483646, 2147483646},
        {2147483646.75, INT32_MAX, INT32_MAX},
        {2147483648, INT32_MIN, INT32_MAX},
        {4294967301, 5, INT32_MAX},
        {-2147483647.75, INT32_MIN, INT32_MIN},
        {-2147483649, INT32_MAX, INT32_MIN},
        {-4294967301, -5, INT32_MIN},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        int32_t wrapped = ect_402_counts(rows[i].counts);
        int32_t saturated = ect_402_saturated(rows[i].counts);
        if (wrapped != rows[i].wrapped || saturated != rows[i].saturated)
            fail_msg("%f: expected %d and within 32 bits %d, got %d and %d", rows[i].counts, rows[i].wrapped,
                     rows[i].saturated, wrapped, saturated);
    }
}

/* The master's position 0 is at 100.25. */
static void positions(void **state)
{
    static const struct {
        double from, way, beyond;
        int32_t position;
        double nearest;
    } rows[] = {
        {110.5, 5, 115.25, 20, 120.25},
        {110.875, 5, 116.25, 11, 111.25},
        {90.25, -5, 85.25, -12, 88.25},
        {2147483747.25, 1, 2147483748.25, INT32_MIN, 2147483748.25},
        {-2147483547.75, -1, -2147483548.75, INT32_MAX, -2147483548.75},
    };
    prepare(state);
    axis.zero = 100.25;
    for (size_t i = 0; i < COUNT(rows); i++) {
        double beyond = ect_402_beyond(&axis, rows[i].from, rows[i].way);
        double nearest = ect_402_nearest(&axis, rows[i].from, rows[i].position);
        if (!near(beyond, rows[i].beyond) || !near(nearest, rows[i].nearest))
            fail_msg("from %f: expected %f and %f, got %f and %f", rows[i].from, rows[i].beyond, rows[i].nearest,
                     beyond, nearest);
    }
}

/* --- switches ----------------------------------------------------------------------------------------------------- */

/* A probe mark on 100 to 110, a home mark on -50 to -45, limit switches at 1000 and -1000. */
static void furnish(void)
{
    plant.mark[P] = (ect_402_mark_t){100, 10};
    plant.mark[H] = (ect_402_mark_t){-50, 5};
    plant.stop_positive = (ect_402_switch_t){1, 1000};
    plant.stop_negative = (ect_402_switch_t){1, -1000};
}

static void levels(void **state)
{
    static const struct {
        double position;
        uint8_t level[ECT_402_INPUTS]; /* probe, home, positive, negative */
    } rows[] = {
        {0, {0, 0, 1, 1}},      {99.99, {0, 0, 1, 1}},  {100, {1, 0, 1, 1}},  {109.99, {1, 0, 1, 1}},
        {110, {0, 0, 1, 1}},    {-50.01, {0, 0, 1, 1}}, {-50, {0, 1, 1, 1}},  {-45, {0, 0, 1, 1}},
        {999.99, {0, 0, 1, 1}}, {1000, {0, 0, 0, 1}},   {1500, {0, 0, 0, 1}}, {-999.99, {0, 0, 1, 1}},
        {-1000, {0, 0, 1, 0}},  {-1500, {0, 0, 1, 0}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        furnish();
        plant.position = rows[i].position;
        ect_402_read_levels(&axis);
        unsigned int edges = 0;
        for (unsigned int n = 0; n < ECT_402_INPUTS; n++) {
            if (axis.level[n] != rows[i].level[n])
                fail_msg("DRV-311, at %f: expected input %u at %u", rows[i].position, n, rows[i].level[n]);
            edges += rows[i].level[n] != (n >= ECT_402_POSITIVE);
        }
        assert_int_equal(axis.edges, edges); /* those that changed */
        ect_402_motor_levels(&axis);
        if (edges > 0) {
            assert_true(near(axis.edge[0].position, rows[i].position));
            assert_int_equal(axis.edges, edges); /* none is added: no level has changed since */
        }
    }
}

static void by_hand(void **state)
{
    for (unsigned int n = 0; n < ECT_402_INPUTS; n++) {
        prepare(state);
        plant.input[n] = !plant.input[n];
        ect_402_read_levels(&axis);
        assert_int_equal(axis.edges, 1);
        assert_int_equal(axis.edge[0].line, n);
        assert_int_equal(axis.edge[0].rising, plant.input[n]);
        assert_int_equal(axis.level[n], plant.input[n]);
    }
}

typedef struct passage {
    const char *what;
    double from, to;
    unsigned int count;
    ect_402_edge_t edges[MOST];
} passage_t;

static void expect_edges(const passage_t *row)
{
    plant.position = row->from;
    plant.speed = (row->to - row->from) * 4000;
    ect_402_motor_step(&axis, false);
    if (axis.edges != row->count)
        fail_msg("%s: expected %u edges, got %u", row->what, row->count, axis.edges);
    for (unsigned int n = 0; n < row->count; n++) {
        const ect_402_edge_t *want = &row->edges[n];
        const ect_402_edge_t *got = &axis.edge[n];
        if (got->line != want->line || got->rising != want->rising || !near(got->position, want->position))
            fail_msg("%s: expected edge %u of line %u to %d at %f, got line %u to %d at %f", row->what, n, want->line,
                     want->rising, want->position, got->line, got->rising, got->position);
    }
}

static void passages(void **state)
{
    static const passage_t rows[] = {
        {"between the marks", 0, 50, 0, {{0}}},
        {"a mark upwards", 90, 120, 2, {{P, true, 100}, {P, false, 110}}},
        {"a mark downwards", 120, 90, 2, {{P, true, 110}, {P, false, 100}}},
        {"up to the mark", 90, 100, 1, {{P, true, 100}}},
        {"just before the mark", 90, 99.5, 0, {{0}}},
        {"from its begin", 100, 105, 0, {{0}}},
        {"within the mark", 102, 108, 0, {{0}}},
        {"up to its end", 105, 110, 1, {{P, false, 110}}},
        {"from its end down", 110, 105, 1, {{P, true, 110}}},
        {"out downwards", 105, 99, 1, {{P, false, 100}}},
        {"the home mark", -60, -40, 2, {{H, true, -50}, {H, false, -45}}},
        {"both marks", 120, -60, 4, {{P, true, 110}, {P, false, 100}, {H, true, -45}, {H, false, -50}}},
        {"onto the positive switch", 990, 1010, 1, {{UP, false, 1000}}},
        {"off the positive switch", 1010, 990, 1, {{UP, true, 1000}}},
        {"onto the negative switch", -990, -1010, 1, {{DOWN, false, -1000}}},
        {"off the negative switch", -1010, -990, 1, {{DOWN, true, -1000}}},
        {"the index pulse upwards", 2990, 3010, 1, {{I, true, 3000}}},
        {"the index pulse downwards", 3010, 2990, 1, {{I, true, 3000}}},
        {"between index pulses", 3010, 9200, 0, {{0}}},
        {"a turn later", 9200, 9300, 1, {{I, true, 3000 + TURN}}},
        {"a turn before", -3200, -3300, 1, {{I, true, 3000 - TURN}}},
        {"two turns before", -9500, -9600, 1, {{I, true, 3000 - 2 * TURN}}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        furnish();
        expect_edges(&rows[i]);
    }
}

static void no_edges(void **state)
{
    static const passage_t mark = {"a mark", 90, 120, 0, {{0}}};
    static const passage_t up = {"the positive switch", 990, 1010, 0, {{0}}};
    static const passage_t down = {"the negative switch", -990, -1010, 0, {{0}}};
    prepare(state);
    furnish();
    plant.input[P] = 1; /* on already */
    expect_edges(&mark);
    assert_int_equal(axis.level[P], 1);
    prepare(state);
    furnish();
    plant.mark[P].width = 0;
    expect_edges(&mark);
    prepare(state); /* no switches */
    expect_edges(&up);
    expect_edges(&down);
    furnish();
    plant.input[UP] = plant.input[DOWN] = 0; /* hit already */
    expect_edges(&up);
    assert_int_equal(axis.level[UP], 0);
    expect_edges(&down);
    assert_int_equal(axis.level[DOWN], 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"The speed after a step, by torque, load, inertia, friction and brake", speeds, NULL, NULL, NULL},
        {"DRV-312 DRV-152: the brake by 60FEh, and without power after its delay", brakes, NULL, NULL, NULL},
        {"A shaft that is stuck has no speed", jams, NULL, NULL, NULL},
        {"A shaft rests while friction and brake hold the load", at_rest, NULL, NULL, NULL},
        {"DRV-230 DRV-232: counts are rounded, and wrap where positions do", whole_counts, NULL, NULL, NULL},
        {"DRV-233: positions of 32 bits count from the nearest one", positions, NULL, NULL, NULL},
        {"DRV-311: levels of marks and limit switches, by position", levels, NULL, NULL, NULL},
        {"An input that is set manually has its edge here", by_hand, NULL, NULL, NULL},
        {"DRV-308 DRV-293: edges lie at their marks and pulses, both ways", passages, NULL, NULL, NULL},
        {"DRV-309: inputs that are on, and marks that are absent, have no edges", no_edges, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("CiA 402 plant", tests, prepare, NULL);
}
