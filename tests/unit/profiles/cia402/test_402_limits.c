/* SPDX-License-Identifier: MIT */
/* Limits, stops and status bits of an axis, decision by decision: software limit switches, rotary axes, option codes.
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
enum { TARGET = ECT_402_STATUS_TARGET, ATTAINED = ECT_402_STATUS_ATTAINED, ERROR = ECT_402_STATUS_MODE_ERROR };

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
        .acceleration = 40000,
        .most_acceleration = 1000000,
        .deceleration = 40000,
        .most_deceleration = 1000000,
        .quick_deceleration = 80000,
        .home_acceleration = 20000,
        .level = {0, 0, 1, 1},
        .mode = ECT_402_PV,
        .live = true,
    };
    return 0;
}

static void expect(const char *what, double want, double got)
{
    if (fabs(want - got) > 1e-6)
        fail_msg("%s: expected %f, got %f", what, want, got);
}

/* --- speeds and rates --------------------------------------------------------------------------------------------- */

static void rates(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
        bool free;
        uint32_t limit, motor; /* 607Fh, 6080h */
        double speed;
    } rows[] = {
        {"607Fh", ECT_402_PV, false, 1000, 600, 1000},
        {"6080h", ECT_402_PV, false, 100000, 600, 10 * TURN},
        {"607Fh in csp", ECT_402_CSP, false, 1000, 600, 1000},
        {"csp is free", ECT_402_CSP, true, 1000, 600, 10 * TURN},
        {"csv is free", ECT_402_CSV, true, 1000, 600, 10 * TURN},
        {"cst is free", ECT_402_CST, true, 1000, 600, 10 * TURN},
        {"pp is not", ECT_402_PP, true, 1000, 600, 1000},
        {"tq is not", ECT_402_TQ, true, 1000, 600, 1000},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.mode = rows[i].mode;
        config.cyclic_is_free = rows[i].free;
        axis.speed_limit = rows[i].limit;
        axis.motor_speed = rows[i].motor;
        expect(rows[i].what, rows[i].speed, ect_402_speed_limit(&axis));
    }
    prepare(state);
    expect("6083h", 40000, ect_402_acceleration(&axis));
    expect("6084h", 40000, ect_402_deceleration(&axis));
    axis.most_acceleration = 30000;
    axis.most_deceleration = 20000;
    expect("60C5h", 30000, ect_402_acceleration(&axis));
    expect("60C6h", 20000, ect_402_deceleration(&axis));
}

/* --- positions ---------------------------------------------------------------------------------------------------- */

static void folds(void **state)
{
    static const struct {
        double user, folded;
    } rows[] = {{0, 0},     {1799, 1799},  {1800, -1800},  {-1800, -1800}, {-1801, 1799}, {3600, 0},
                {-3600, 0}, {5400, -1800}, {-5400, -1800}, {-5401, 1799},  {7300, 100},   {-7300, -100}};
    prepare(state);
    expect("no range", 5400, ect_402_folded(&axis, 5400));
    axis.range[0] = 5;
    axis.range[1] = 5;
    expect("a range without a width", 5400, ect_402_folded(&axis, 5400));
    axis.range[0] = -1800;
    axis.range[1] = 1799;
    for (size_t i = 0; i < COUNT(rows); i++)
        expect("folded", rows[i].folded, ect_402_folded(&axis, rows[i].user));
}

/* 607Bh is 0 to 3599, and position 0 at 50. */
static void rotary_ways(void **state)
{
    enum { LINEAR = 0x00, NEGATIVE = 0x40, POSITIVE = 0x80, SHORT = 0xC0 };
    static const struct {
        int8_t mode;
        uint16_t options;
        int32_t from, position, to;
    } rows[] = {
        {ECT_402_PP, LINEAR, 100, 300, 300},     {ECT_402_PP, NEGATIVE, 100, 300, -3300},
        {ECT_402_PP, POSITIVE, 100, 300, 300},   {ECT_402_PP, SHORT, 100, 300, 300},
        {ECT_402_PP, LINEAR, 300, 100, 100},     {ECT_402_PP, NEGATIVE, 300, 100, 100},
        {ECT_402_PP, POSITIVE, 300, 100, 3700},  {ECT_402_PP, SHORT, 300, 100, 100},
        {ECT_402_PP, LINEAR, 100, 3500, 3500},   {ECT_402_PP, SHORT, 100, 3500, -100},
        {ECT_402_PP, SHORT, 3500, 100, 3700},    {ECT_402_PP, SHORT, 0, 1800, 1800},
        {ECT_402_PP, SHORT, 1800, 0, 3600},      {ECT_402_PP, SHORT, 0, 1801, -1799},
        {ECT_402_PP, NEGATIVE, 100, 100, 100},   {ECT_402_PP, POSITIVE, 100, 100, 100},
        {ECT_402_PP, POSITIVE, 3700, 300, 3900}, {ECT_402_PP, NEGATIVE, -3500, 50, -3550},
        {ECT_402_PP, LINEAR, 100, 3900, 300},    {ECT_402_PP, LINEAR, 100, -3300, 300},
        {ECT_402_CSP, NEGATIVE, 100, 300, 300},  {ECT_402_CSP, LINEAR, 100, 3500, -100},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.zero = 50;
        axis.range[1] = 3599;
        axis.mode = rows[i].mode;
        axis.options = rows[i].options | 0x01;
        double to = ect_402_absolute(&axis, rows[i].from + 50.25, rows[i].position) - 50;
        if (fabs(to - rows[i].to) > 1e-6)
            fail_msg("mode %d, 60F2h %02X, from %d to %d: expected %d, got %f", rows[i].mode, rows[i].options,
                     rows[i].from, rows[i].position, rows[i].to, to);
    }
}

static void software_limits(void **state)
{
    static const struct {
        const char *what;
        bool homed;
        int32_t lower, upper, position, to;
        bool negative, positive;
    } rows[] = {
        {"within", true, -100, 100, 50, 50, false, false},
        {"at the upper limit", true, -100, 100, 100, 100, false, false},
        {"beyond the upper limit", true, -100, 100, 101, 100, false, true},
        {"at the lower limit", true, -100, 100, -100, -100, false, false},
        {"beyond the lower limit", true, -100, 100, -101, -100, true, false},
        {"without a reference", false, -100, 100, 150, 150, false, false},
        {"equal limits", true, 100, 100, 150, 150, false, false},
        {"crossed limits", true, 100, -100, 150, 150, false, false},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (unsigned int relative = 0; relative < 2; relative++) {
            prepare(state);
            axis.zero = 1000;
            axis.homed = rows[i].homed;
            axis.limit[0] = rows[i].lower;
            axis.limit[1] = rows[i].upper;
            double to = relative ? ect_402_relative(&axis, 1020, rows[i].position - 20)
                                 : ect_402_absolute(&axis, 1020, rows[i].position);
            expect(rows[i].what, 1000 + rows[i].to, to);
            if (axis.limit_negative != rows[i].negative || axis.limit_positive != rows[i].positive)
                fail_msg("%s: expected limits %d and %d, got %d and %d", rows[i].what, rows[i].negative,
                         rows[i].positive, axis.limit_negative, axis.limit_positive);
            assert_int_equal(ect_402_limit_acts(&axis), rows[i].negative || rows[i].positive);
        }
    }
}

/* Between software limits an axis with 607Bh is a line, too. */
static void limited_rotary(void **state)
{
    prepare(state);
    axis.homed = true;
    axis.limit[0] = 0;
    axis.limit[1] = 3600;
    axis.range[1] = 3599;
    expect("the long way", 3500, ect_402_absolute(&axis, 100, 3500));
}

/* --- speeds and torques towards a limit --------------------------------------------------------------------------- */

/* At v the way to a standstill is v^2 / 80000 + v / 500, and 10 counts before the limit are at it. */
static void speed_at_limit(void **state)
{
    static const struct {
        const char *what;
        double speed;
        int32_t left;
        bool holds;
    } rows[] = {
        {"standing, at the limit", 0, 10, true},
        {"standing, before the limit", 0, 11, false},
        {"slow, at the limit", 400, 12, true},
        {"slow, before the limit", 400, 13, false},
        {"fast, at the limit", 4000, 218, true},
        {"fast, before the limit", 4000, 219, false},
        {"moving off, at the limit", -400, 10, true},
        {"moving off, before the limit", -400, 11, false},
        {"behind the limit", 0, -5, true},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (int direction = -1; direction <= 1; direction += 2) {
            prepare(state);
            axis.homed = true;
            axis.zero = 70;
            axis.limit[0] = -900;
            axis.limit[1] = 1000;
            double start = direction > 0 ? 1000 - rows[i].left : -900 + rows[i].left;
            plant.position = start + 70;
            plant.speed = direction * rows[i].speed;
            if (ect_402_limit_holds_speed(&axis, direction * 5000) != rows[i].holds)
                fail_msg("DRV-236, %s, direction %d: expected that the limit %s", rows[i].what, direction,
                         rows[i].holds ? "acts" : "does not act");
            assert_int_equal(axis.limit_positive, rows[i].holds && direction > 0);
            assert_int_equal(axis.limit_negative, rows[i].holds && direction < 0);
            assert_int_equal(axis.guarded, rows[i].holds ? direction : 0);
            if (rows[i].holds) {
                double end = rows[i].left < 0 ? start : direction > 0 ? 1000 : -900;
                expect(rows[i].what, end + 70, axis.guard_target);
                assert_int_equal(axis.reference.loop, ECT_402_LOOP_POSITION);
            }
            assert_false(ect_402_limit_holds_speed(&axis, -direction * 5000)); /* back is free */
            assert_false(ect_402_limit_acts(&axis));
        }
    }
}

static void limits_off(void **state)
{
    prepare(state);
    axis.homed = true;
    axis.limit[1] = 1000;
    plant.position = 995;
    assert_true(ect_402_limit_holds_speed(&axis, 5000));
    assert_false(ect_402_limit_holds_speed(&axis, 0));
    assert_int_equal(axis.guarded, 0);
    assert_true(ect_402_limit_holds_speed(&axis, 5000));
    axis.homed = false;
    assert_false(ect_402_limit_holds_speed(&axis, 5000));
    assert_false(ect_402_limit_acts(&axis));
    axis.homed = true;
    assert_true(ect_402_limit_holds_speed(&axis, 5000));
    ect_402_limits_begin(&axis);
    assert_int_equal(axis.guarded, 0);
    assert_false(ect_402_limit_acts(&axis));
}

/* A ramp to the limit: at most the speed that the master sets, and a standstill there. */
static void ramp_to_limit(void **state)
{
    prepare(state);
    axis.homed = true;
    axis.limit[0] = -1000;
    axis.limit[1] = 1000;
    plant.position = 700;
    plant.speed = 5000;
    for (unsigned int n = 0; n < 4000; n++) {
        assert_true(ect_402_limit_holds_speed(&axis, 2000));
        assert_true(axis.reference.speed <= 5000);
        plant.position = axis.reference.position;
        plant.speed = axis.reference.speed;
    }
    expect("the limit", 1000, axis.reference.position);
    expect("a standstill", 0, axis.reference.speed);
}

static void torque_at_limit(void **state)
{
    static const struct {
        const char *what;
        int8_t guarded;
        double reference, sum, torque;
        bool holds;
    } rows[] = {
        {"less than the holding torque", 1, 0, 0.5, 0.4, false},
        {"more than the holding torque", 1, 0, 0.5, 0.6, true},
        {"as much as the holding torque", 1, 0, 0.5, 0.5, true},
        {"backwards, less than the holding torque", -1, 0, -0.5, -0.4, false},
        {"backwards, more than the holding torque", -1, 0, -0.5, -0.6, true},
        {"not yet at a standstill", 1, 100, 0.5, 0.4, true},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.homed = true;
        axis.limit[0] = -1000;
        axis.limit[1] = 1000;
        axis.guarded = rows[i].guarded;
        axis.guard_target = rows[i].guarded * 1000;
        plant.position = rows[i].guarded * 995;
        axis.reference.position = plant.position;
        axis.reference.speed = rows[i].reference;
        axis.sum = rows[i].sum;
        axis.limit_positive = axis.limit_negative = true;
        if (ect_402_limit_holds_torque(&axis, rows[i].torque) != rows[i].holds)
            fail_msg("DRV-236, %s: expected that the limit %s", rows[i].what, rows[i].holds ? "holds" : "releases");
        assert_int_equal(axis.guarded, rows[i].holds ? rows[i].guarded : 0);
        assert_int_equal(ect_402_limit_acts(&axis), rows[i].holds);
    }
}

/* The shaft's own direction counts, and 6085h: at 4000 counts/s 100 + 8 + 10 counts are left. */
static void shaft_at_limit(void **state)
{
    static const struct {
        double speed;
        int32_t position;
        int8_t guarded;
    } rows[] = {{4000, 882, 1}, {4000, 881, 0}, {-4000, -882, -1}, {-4000, -881, 0}, {0, 999, 0}, {-4000, 999, 0}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.homed = true;
        axis.limit[0] = -1000;
        axis.limit[1] = 1000;
        plant.position = rows[i].position;
        plant.speed = rows[i].speed;
        bool holds = ect_402_limit_holds_torque(&axis, 1);
        if (holds != (rows[i].guarded != 0) || axis.guarded != rows[i].guarded)
            fail_msg("%f counts/s at %d: expected direction %d, got %d", rows[i].speed, rows[i].position,
                     rows[i].guarded, axis.guarded);
    }
}

/* --- stops -------------------------------------------------------------------------------------------------------- */

static void options(void **state)
{
    static const struct {
        uint16_t index;
        int lowest, highest;
    } rows[] = {{0x605A, 0, 8}, {0x605B, 0, 1}, {0x605C, 0, 1}, {0x605D, 1, 4}, {0x605E, 0, 4}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (int option = -3; option <= 12; option++) {
            bool want = option >= rows[i].lowest && option <= rows[i].highest;
            if (ect_402_stop_known(rows[i].index, option) != want)
                fail_msg("%04X %d: expected that it is %s", rows[i].index, option, want ? "known" : "unknown");
        }
    }
}

/* 6084h is 40000, 6085h 80000, 609Ah 20000. Rate 0: as fast as the motor brakes. */
static void stops(void **state)
{
    static const struct {
        const char *what;
        ect_402_state_t state;
        ect_402_action_t action;
        int8_t mode;
        uint16_t control;
        int16_t quick, halt, fault;
        double rate;
    } rows[] = {
        {"605Ah 1", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 1, 0, 0, 40000},
        {"605Ah 2", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 2, 0, 0, 80000},
        {"605Ah 3", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 3, 0, 0, 0},
        {"605Ah 4", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 4, 0, 0, 0},
        {"605Ah 5", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 5, 0, 0, 40000},
        {"605Ah 6", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 6, 0, 0, 80000},
        {"605Ah 7", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_PV, 0, 7, 0, 0, 0},
        {"605Ah 1 in hm", ECT_402_QUICK_STOP, ECT_402_STOP, ECT_402_HM, 0, 1, 0, 0, 20000},
        {"605Eh 1", ECT_402_FAULT_REACTION, ECT_402_STOP, ECT_402_PV, 0, 3, 3, 1, 40000},
        {"605Eh 2", ECT_402_FAULT_REACTION, ECT_402_STOP, ECT_402_PV, 0, 3, 3, 2, 80000},
        {"605Dh 1", ECT_402_OPERATION_ENABLED, ECT_402_RAMP, ECT_402_PV, 0x10F, 3, 1, 3, 40000},
        {"605Dh 2", ECT_402_OPERATION_ENABLED, ECT_402_RAMP, ECT_402_PV, 0x10F, 3, 2, 3, 80000},
        {"605Bh, 605Ch", ECT_402_OPERATION_ENABLED, ECT_402_RAMP, ECT_402_PV, 0x07, 3, 2, 3, 40000},
        {"605Bh, 605Ch in hm", ECT_402_OPERATION_ENABLED, ECT_402_RAMP, ECT_402_HM, 0x07, 3, 2, 3, 20000},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.state = rows[i].state;
        axis.action = rows[i].action;
        axis.mode = rows[i].mode;
        axis.set.control = rows[i].control;
        axis.quick_option = rows[i].quick;
        axis.halt_option = rows[i].halt;
        axis.fault_option = rows[i].fault;
        double rate = ect_402_stop_deceleration(&axis);
        if (rows[i].rate > 0 ? rate != rows[i].rate : rate < 1e9)
            fail_msg("%s: expected %f counts/s2, got %f", rows[i].what, rows[i].rate, rate);
    }
    prepare(state);
    axis.homing.active = true;
    axis.action = ECT_402_RAMP;
    expect("609Ah in a reference run", 20000, ect_402_stop_deceleration(&axis));
}

/* 1.5 times the ramp and 200 ms: 350 ms from 8000 counts/s. */
static void deadlines(void **state)
{
    static const struct {
        double speed;
        int16_t option;
        uint64_t ms;
    } rows[] = {{8000, 2, 350}, {-8000, 2, 350}, {0, 2, 200}, {8000, 1, 500}, {8000, 3, 10000}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.time_ns = 77000000;
        axis.state = ECT_402_QUICK_STOP;
        axis.action = ECT_402_STOP;
        axis.quick_option = rows[i].option;
        plant.speed = rows[i].speed;
        ect_402_stop_begin(&axis);
        assert_int_equal(axis.stop_until_ns, 77000000 + rows[i].ms * 1000000);
        plant.speed = 5000;
        axis.time_ns = axis.stop_until_ns - 1;
        assert_true(ect_402_stop_in_time(&axis));
        axis.time_ns++;
        assert_false(ect_402_stop_in_time(&axis));
        plant.speed = 0;
        assert_true(ect_402_stop_in_time(&axis));
        plant.speed = 5000;
        axis.action = ECT_402_RAMP;
        assert_true(ect_402_stop_in_time(&axis));
    }
}

static void waits(void **state)
{
    static const struct {
        const char *what;
        ect_402_state_t state;
        uint16_t control;
        int16_t quick, shutdown, disable;
        bool waits;
    } rows[] = {
        {"605Ah 0", ECT_402_QUICK_STOP, 0x02, 0, 1, 1, false},
        {"605Ah 2", ECT_402_QUICK_STOP, 0x02, 2, 0, 0, true},
        {"605Bh 0", ECT_402_OPERATION_ENABLED, 0x06, 1, 0, 1, false},
        {"605Bh 1", ECT_402_OPERATION_ENABLED, 0x06, 0, 1, 0, true},
        {"605Ch 0", ECT_402_OPERATION_ENABLED, 0x07, 1, 1, 0, false},
        {"605Ch 1", ECT_402_OPERATION_ENABLED, 0x07, 0, 0, 1, true},
        {"a fault reaction", ECT_402_FAULT_REACTION, 0x06, 0, 0, 0, true},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.state = rows[i].state;
        axis.set.control = rows[i].control;
        axis.quick_option = rows[i].quick;
        axis.shutdown_option = rows[i].shutdown;
        axis.disable_option = rows[i].disable;
        if (ect_402_stop_waits(&axis) != rows[i].waits)
            fail_msg("%s: expected %s", rows[i].what, rows[i].waits ? "that it waits for a standstill" : "no wait");
    }
    for (int16_t option = 0; option <= 8; option++) {
        axis.quick_option = option;
        assert_int_equal(ect_402_stop_stays(&axis), option >= 5);
    }
}

/* --- bits of the status word -------------------------------------------------------------------------------------- */

static void follow(int8_t mode)
{
    axis.state = ECT_402_OPERATION_ENABLED;
    axis.action = ECT_402_FOLLOW;
    axis.mode = mode;
    axis.set.control = 0x0F;
}

static void targets(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
        double position, speed;
        bool reached;
    } rows[] = {
        {"csp, at the window", ECT_402_CSP, 1010, 0, true},
        {"csp, beyond the window", ECT_402_CSP, 1010.5, 0, false},
        {"csp, below the window", ECT_402_CSP, 989.5, 0, false},
        {"csv, at the window", ECT_402_CSV, 0, 2030, true},
        {"csv, beyond the window", ECT_402_CSV, 0, 2030.5, false},
        {"csv, below the window", ECT_402_CSV, 0, 1969.5, false},
        {"pv, at the window", ECT_402_PV, 0, 1970, true},
        {"pv, below the window", ECT_402_PV, 0, 1969.5, false},
        {"cst", ECT_402_CST, 0, 0, true},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        follow(rows[i].mode);
        axis.position_window = 10;
        axis.speed_window = 30;
        axis.set.position = 1000;
        axis.set.speed = 2000;
        plant.position = rows[i].position;
        plant.speed = rows[i].speed;
        if (ect_402_target_reached(&axis) != rows[i].reached)
            fail_msg("%s: expected a target that is%s reached", rows[i].what, rows[i].reached ? "" : " not");
        axis.homing.active = true;
        assert_false(ect_402_target_reached(&axis));
    }
    prepare(state);
    follow(ECT_402_PV);
    axis.speed_limit = 1500;
    axis.set.speed = 2000;
    plant.speed = 1500;
    assert_true(ect_402_target_reached(&axis)); /* DRV-246: the limited target counts */
}

static void torque_targets(void **state)
{
    static const struct {
        double reference;
        bool held, reached;
    } rows[] = {{1.5, false, true}, {1.5, true, false}, {1.501, false, false}, {-1.5, false, false}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        follow(ECT_402_TQ);
        axis.set.torque = 500;
        axis.reference = (ect_402_reference_t){.loop = ECT_402_LOOP_TORQUE, .torque = rows[i].reference};
        axis.held = rows[i].held;
        assert_int_equal(ect_402_target_reached(&axis), rows[i].reached);
    }
}

static void task_targets(void **state)
{
    prepare(state);
    follow(ECT_402_PP);
    axis.position_window = 10;
    axis.task_target = 500;
    plant.position = 505;
    assert_false(ect_402_target_reached(&axis));
    axis.task_reached = true;
    assert_true(ect_402_target_reached(&axis));
    plant.position = 511;
    assert_false(ect_402_target_reached(&axis));
    plant.position = 505;
    axis.next.valid = true;
    assert_false(ect_402_target_reached(&axis));
    axis.next.valid = false;
    axis.limit_positive = true;
    assert_false(ect_402_target_reached(&axis));
    prepare(state);
    follow(ECT_402_HM);
    axis.homing.found = 500;
    axis.homing.done = true;
    axis.position_window = 10;
    plant.position = 510;
    assert_true(ect_402_target_reached(&axis));
    plant.position = 511;
    assert_false(ect_402_target_reached(&axis));
    plant.position = 510;
    axis.homing.done = false;
    assert_false(ect_402_target_reached(&axis));
}

/* 6068h, 606Eh: the time in the window; four steps a millisecond. */
static void window_times(void **state)
{
    static const struct {
        int8_t mode;
        unsigned int steps;
    } rows[] = {{ECT_402_CSP, 8}, {ECT_402_CSV, 20}, {ECT_402_PV, 20}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        follow(rows[i].mode);
        axis.position_time = 2;
        axis.speed_time = 5;
        for (unsigned int n = 1; n <= 30; n++) {
            ect_402_status_step(&axis);
            if (ect_402_reached(&axis) != (n >= rows[i].steps))
                fail_msg("mode %d: expected bit 10 after %u steps, got %d after %u", rows[i].mode, rows[i].steps,
                         ect_402_reached(&axis), n);
        }
        plant.position = plant.speed = 1000;
        ect_402_status_step(&axis);
        assert_false(ect_402_reached(&axis));
        plant.position = plant.speed = 0;
        ect_402_status_step(&axis);
        assert_false(ect_402_reached(&axis)); /* the time begins again */
        axis.position_time = axis.speed_time = 0;
        assert_true(ect_402_reached(&axis));
    }
    prepare(state); /* braking: bit 10 is a standstill, without a time */
    follow(ECT_402_CSP);
    axis.action = ECT_402_RAMP;
    axis.position_time = 2;
    assert_true(ect_402_reached(&axis));
    plant.speed = 400;
    assert_false(ect_402_reached(&axis));
}

static void zero_times(void **state)
{
    static const struct {
        uint16_t ms;
        unsigned int steps;
    } rows[] = {{0, 1}, {1, 4}, {3, 12}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        axis.zero_window = 50;
        axis.zero_time = rows[i].ms;
        for (unsigned int phase = 0; phase < 3; phase++) {
            static const double speeds[] = {-50, 51, 50};
            plant.speed = speeds[phase];
            for (unsigned int n = 1; n <= 20; n++) {
                ect_402_status_step(&axis);
                bool slow = phase == 1 ? n < rows[i].steps : n >= rows[i].steps;
                if (axis.speed_is_zero != slow)
                    fail_msg("DRV-247, 6070h %u, speed %f: expected bit 12 at %d after %u steps", rows[i].ms,
                             plant.speed, slow, n);
            }
        }
    }
}

static void mode_bits(void **state)
{
    static const struct {
        int8_t mode;
        uint16_t quiet, limited, late, off;
    } rows[] = {
        {ECT_402_PP, ATTAINED, ATTAINED, ATTAINED | ERROR, ATTAINED | TARGET},
        {ECT_402_PV, ATTAINED | TARGET, ATTAINED | TARGET, ATTAINED | TARGET, ATTAINED | TARGET},
        {ECT_402_NO_MODE, TARGET, TARGET, TARGET, TARGET},
        {ECT_402_TQ, TARGET, TARGET, TARGET, TARGET},
        {ECT_402_IP, ATTAINED | TARGET, TARGET, ATTAINED | TARGET | ERROR, TARGET},
        {ECT_402_CSP, ATTAINED, 0, ATTAINED | ERROR, 0},
        {ECT_402_CSV, ATTAINED, 0, ATTAINED, 0},
        {ECT_402_CST, ATTAINED, 0, ATTAINED, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        follow(rows[i].mode);
        axis.task_taken = axis.speed_is_zero = true;
        uint16_t quiet = ect_402_mode_bits(&axis);
        axis.limit_negative = true;
        uint16_t limited = ect_402_mode_bits(&axis);
        axis.limit_negative = false;
        axis.error_steps = 1;
        uint16_t late = ect_402_mode_bits(&axis);
        axis.error_steps = 0;
        axis.action = ECT_402_RAMP;
        uint16_t off = ect_402_mode_bits(&axis);
        if (quiet != rows[i].quiet || limited != rows[i].limited || late != rows[i].late || off != rows[i].off)
            fail_msg("mode %d: expected bits %04X, limited %04X, late %04X, braking %04X, got %04X, %04X, %04X, %04X",
                     rows[i].mode, rows[i].quiet, rows[i].limited, rows[i].late, rows[i].off, quiet, limited, late,
                     off);
    }
}

/* Bits 10, 12 and 13 of a reference run. */
static void homing_bits(void **state)
{
    static const struct {
        const char *what;
        ect_402_homing_t homing;
        double speed;
        uint16_t bits;
    } rows[] = {
        {"DRV-265 running", {.active = true}, 500, 0},
        {"DRV-265 running, at a standstill", {.active = true}, 0, 0},
        {"DRV-266 not started", {0}, 0, TARGET},
        {"DRV-266 interrupted", {.error = true, .interrupted = true}, 0, TARGET},
        {"DRV-267 found", {.active = true, .returning = true, .leg = 1}, 500, ATTAINED},
        {"DRV-267 no leg", {.active = true, .returning = true}, 500, 0},
        {"DRV-267 on its last leg", {.active = true, .leg = 1}, 500, 0},
        {"DRV-268 done", {.done = true}, 0, TARGET | ATTAINED},
        {"DRV-269 error, moving", {.error = true}, 500, ERROR},
        {"DRV-270 error, standing", {.error = true}, 0, TARGET | ERROR},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare(state);
        follow(ECT_402_HM);
        axis.homing = rows[i].homing;
        plant.speed = rows[i].speed;
        uint16_t bits = ect_402_mode_bits(&axis);
        if (bits != rows[i].bits)
            fail_msg("%s: expected %04X, got %04X", rows[i].what, rows[i].bits, bits);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"DRV-220 DRV-261: limits of speeds and rates, by mode", rates, NULL, NULL, NULL},
        {"DRV-234: positions fold into 607Bh", folds, NULL, NULL, NULL},
        {"DRV-224: the way of a rotary axis by 60F2h", rotary_ways, NULL, NULL, NULL},
        {"DRV-221 DRV-235 DRV-237: set positions end at software limits", software_limits, NULL, NULL, NULL},
        {"Between software limits a rotary axis is a line", limited_rotary, NULL, NULL, NULL},
        {"DRV-236: a speed towards a limit ends there, and back is free", speed_at_limit, NULL, NULL, NULL},
        {"DRV-236: no speed, no reference, no limit", limits_off, NULL, NULL, NULL},
        {"DRV-236: the ramp to a limit", ramp_to_limit, NULL, NULL, NULL},
        {"DRV-236: a torque beyond the holding torque stays at the limit", torque_at_limit, NULL, NULL, NULL},
        {"DRV-236: the shaft brakes on 6085h towards a limit in tq and cst", shaft_at_limit, NULL, NULL, NULL},
        {"DRV-006 DRV-007 DRV-009 DRV-010: options 605Ah to 605Eh", options, NULL, NULL, NULL},
        {"DRV-205 DRV-206 DRV-273: the rate of each stop", stops, NULL, NULL, NULL},
        {"A stop has 1.5 times its ramp and 200 ms", deadlines, NULL, NULL, NULL},
        {"DRV-206: options that wait for a standstill, and that stay", waits, NULL, NULL, NULL},
        {"DRV-246: bit 10 within the windows of each mode", targets, NULL, NULL, NULL},
        {"DRV-250: bit 10 of tq at 6071h, unless it is held", torque_targets, NULL, NULL, NULL},
        {"DRV-218 DRV-268: bit 10 of pp and hm in the window of the target", task_targets, NULL, NULL, NULL},
        {"DRV-218 DRV-246: bit 10 after 6068h, 606Eh", window_times, NULL, NULL, NULL},
        {"DRV-247: bit 12 after 6070h, both ways", zero_times, NULL, NULL, NULL},
        {"DRV-207 DRV-258 DRV-259: bits 10, 12, 13 by mode", mode_bits, NULL, NULL, NULL},
        {"DRV-265 to DRV-270: bits 10, 12, 13 of reference runs", homing_bits, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("CiA 402 limits", tests, prepare, NULL);
}
