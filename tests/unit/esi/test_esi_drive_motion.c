/* SPDX-License-Identifier: MIT */
/* Set values, limits and their bits of a drive of an ESI file. A turn has 10 000 counts. */
#include "drive_of_file.h"

enum { FAST = 50000, BIT_TARGET = 0x0400, BIT_LIMIT = 0x0800, BIT_ATTAINED = 0x1000 };

static void expect_bits(const char *what, uint16_t mask, uint16_t want)
{
    if ((get(STATUS) & mask) != want)
        fail_msg("%s: expected %04X of %04X, status word is %04X", what, want, mask, (unsigned int)get(STATUS));
}

static void start(int32_t target, uint16_t bits)
{
    put(TARGET, target);
    put(CONTROL, ENABLE);
    cycles(1);
    put(CONTROL, START | bits);
    cycles(1);
}

/* --- mode changes ------------------------------------------------------------------------------------------------- */

/* From 50 000 counts/s: 6084h brakes in 500 ms and 12 500 counts, 609Ah in 100 ms and 2500. */
static void mode_changes(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
        double speed_after_50_ms, way; /* to the standstill; 0: it goes on */
    } rows[] = {
        {"DRV-204 to pp", PP, 45000, 12500},
        {"DRV-204 to hm", HM, 25000, 2500},
        {"DRV-204 to ip", IP, 45000, 12500},
        {"DRV-204 to csv", CSV, 50000, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(PV, 10000);
        enable(0);
        put(0x60FF, FAST);
        cycles(700);
        double from = signal_of("axis1.machine_position");
        put(MODE, rows[i].mode);
        cycles(50);
        expect_near(rows[i].what, rows[i].speed_after_50_ms, 1500, (double)get(0x606C));
        cycles(650);
        if (rows[i].way > 0)
            expect_near(rows[i].what, rows[i].way, 400, signal_of("axis1.machine_position") - from);
        assert_int_equal(state_of(get(STATUS)), ENABLED);
        close_drive(state);
    }
}

static void enabled_while_turning(void **state)
{
    (void)state;
    servo(PV, 10000);
    set("axis1.load_inertia", "9");
    set("axis1.friction", "0");
    put(0x60FF, FAST);
    enable(0);
    cycles(800);
    put(CONTROL, 0);
    cycles(100);
    enable(0);
    cycles(50);
    expect_near("on from its speed", FAST, 500, (double)get(0x606C));
    put(0x60FF, 0);
    cycles(800);
    double held = signal_of("axis1.machine_position");
    expect_near("zero speed", 0, 20, (double)get(0x606C));
    cycles(100);
    expect_near("holds", held, 20, signal_of("axis1.machine_position"));
}

/* --- profile position --------------------------------------------------------------------------------------------- */

static void set_points(void **state)
{
    static const struct {
        const char *what;
        uint16_t object;
        int64_t value;
        size_t size;
        double way; /* after 400 ms of a motion to 100 000 */
        uint16_t bit10;
    } rows[] = {
        {"DRV-210 as set", 0x6081, 50000, 4, 8000, 0},
        {"DRV-220 6081h 0: no motion", 0x6081, 0, 4, 0, 0},
        {"DRV-220 607Fh is less", 0x607F, 10000, 4, 3500, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(PP, 10000);
        assert_int_equal(write_sdo(rows[i].object, 0, rows[i].value, rows[i].size), 0);
        enable(0);
        start(100000, 0);
        cycles(400);
        expect_near(rows[i].what, rows[i].way, 1000, (double)get(ACTUAL));
        expect_bits(rows[i].what, BIT_TARGET, rows[i].bit10);
        close_drive(state);
    }
}

static void beyond_the_limit(void **state)
{
    (void)state;
    servo(HM, 10000);
    assert_int_equal(write_sdo(0x607D, 1, -20000, 4), 0);
    assert_int_equal(write_sdo(0x607D, 2, 20000, 4), 0);
    enable(0);
    assert_int_equal(home(37, 0), 5);
    put(CONTROL, ENABLE);
    put(MODE, PP);
    cycles(2);
    start(30000, 0);
    cycles(1500);
    expect_near("at the limit", 20000, 2, (double)get(ACTUAL));
    expect_bits("at the limit", BIT_LIMIT | BIT_TARGET, BIT_LIMIT);
    start(10000, 0);
    cycles(1500);
    expect_bits("back", BIT_LIMIT | BIT_TARGET, BIT_TARGET);
}

static void no_limits(void **state)
{
    static const struct {
        const char *what;
        int64_t lower, upper;
    } rows[] = {{"DRV-237 both 0", 0, 0}, {"DRV-237 equal", 5000, 5000}, {"DRV-237 outermost", INT32_MIN, INT32_MAX}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(HM, 10000);
        (void)write_sdo(0x607D, 2, rows[i].upper, 4);
        (void)write_sdo(0x607D, 1, rows[i].lower, 4);
        enable(0);
        assert_int_equal(home(37, 0), 5);
        put(CONTROL, ENABLE);
        put(MODE, PP);
        cycles(2);
        start(30000, 0);
        cycles(1800);
        expect_near(rows[i].what, 30000, 2, (double)get(ACTUAL));
        close_drive(state);
    }
}

/* --- polarity ----------------------------------------------------------------------------------------------------- */

static void turned(void **state)
{
    (void)state;
    servo(HM, 10000);
    assert_int_equal(write_sdo(0x607E, 0, 0xC0, 1), 0);
    assert_int_equal(write_sdo(0x607D, 1, -20000, 4), 0);
    assert_int_equal(write_sdo(0x607D, 2, 90000, 4), 0);
    enable(0);
    assert_int_equal(home(37, 5000), 5);
    assert_int_equal(get(ACTUAL), -5000);
    put(CONTROL, ENABLE);
    put(MODE, PP);
    cycles(2);
    start(-90000, 0);
    cycles(1800);
    expect_near("lower limit less 607Ch", -25000, 2, (double)get(ACTUAL));
    start(60000, 0);
    cycles(300);
    assert_true(get(0x606C) > 10000);
    cycles(3000);
    expect_near("upper limit is far", 60000, 2, (double)get(ACTUAL));
}

/* --- limits of torque and speed ----------------------------------------------------------------------------------- */

static void torque_held(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
        uint16_t object;
    } rows[] = {{"DRV-250 tq", TQ, 0x6072}, {"DRV-418 cst, 60E0h", CST, 0x60E0}, {"DRV-239 cst, 6072h", CST, 0x6072}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(rows[i].mode, 10000);
        set("axis1.jam", "1");
        enable(0);
        put(0x6071, 400);
        cycles(300);
        assert_int_equal(get(0x6077), 400);
        expect_bits(rows[i].what, BIT_LIMIT, 0);
        assert_int_equal(write_sdo(rows[i].object, 0, 300, 2), 0);
        cycles(20);
        assert_int_equal(get(0x6077), 300);
        expect_bits(rows[i].what, BIT_LIMIT | BIT_TARGET, BIT_LIMIT);
        put(0x6071, 200);
        cycles(300);
        expect_bits(rows[i].what, BIT_LIMIT, 0);
        close_drive(state);
    }
}

static void speed_held(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
        uint16_t object;
        int64_t limit;
        double speed;
    } rows[] = {{"DRV-240 csv at 6080h", CSV, 0x6080, 120, 20000},
                {"DRV-245 pv at 6080h", PV, 0x6080, 120, 20000},
                {"DRV-245 pv at 607Fh", PV, 0x607F, 20000, 20000},
                {"DRV-261 csv beyond 607Fh", CSV, 0x607F, 20000, FAST}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(rows[i].mode, 10000);
        assert_int_equal(write_sdo(rows[i].object, 0, rows[i].limit, 4), 0);
        enable(0);
        put(0x60FF, FAST);
        cycles(700);
        expect_near(rows[i].what, rows[i].speed, 300, (double)get(0x606C));
        expect_bits(rows[i].what, BIT_LIMIT, rows[i].speed < (double)FAST ? BIT_LIMIT : 0);
        assert_int_equal(state_of(get(STATUS)), ENABLED);
        close_drive(state);
    }
}

/* 607Fh that falls below the present speed is no overspeed; a load that turns the motor beyond 6080h is, after 10 ms.
 */
static void overspeed(void **state)
{
    (void)state;
    servo(PV, 10000);
    enable(0);
    put(0x60FF, FAST);
    cycles(700);
    assert_int_equal(write_sdo(0x607F, 0, 10000, 4), 0);
    cycles(20);
    assert_int_equal(get(0x603F), 0);
    assert_int_equal(write_sdo(0x6072, 0, 0, 2), 0);
    assert_int_equal(write_sdo(0x6080, 0, 120, 4), 0);
    set("axis1.load", "-1");
    cycles(60);
    assert_int_equal(get(0x603F), 0x8400);
    assert_int_equal(state_of(get(STATUS)), FAULT);
}

/* --- cyclic modes ------------------------------------------------------------------------------------------------- */

static void interpolates(void **state)
{
    (void)state;
    servo(CSP, 10000);
    (void)wire_al(&wire, 0, PREOP, NULL);
    assert_int_equal(write_sdo(0x60C2, 1, 1, 1), 0);
    operational();
    enable(0);
    for (int32_t n = 1; n <= 20; n++) {
        put(TARGET, n * 100);
        cycles(1);
        if (n > 1)
            assert_int_equal(read_sdo(0x6062, 0), n * 100);
        assert_int_equal(read_sdo(0x606B, 0), 100000);
    }
    wire_advance(&wire, MS); /* a cycle without a frame */
    assert_int_equal(read_sdo(0x6062, 0), 2000);
    assert_int_equal(read_sdo(0x606B, 0), 0);
    put(TARGET, 2200);
    cycles(1);
    assert_int_equal(read_sdo(0x6062, 0), 2200);
    assert_int_equal(read_sdo(0x606B, 0), 200000);
}

static void far_target(void **state)
{
    (void)state;
    servo(CSP, 10000);
    assert_int_equal(write_sdo(0x6080, 0, 300, 4), 0); /* 50 000 counts/s */
    put(TARGET, 100000);
    enable(0);
    cycles(400);
    expect_near("at the speed limit", FAST, 500, (double)get(0x606C));
    expect_bits("at the speed limit", BIT_LIMIT, BIT_LIMIT);
    close_drive(state);
    servo(CSP, 10000);
    assert_int_equal(write_sdo(0x6065, 0, 1000, 4), 0);
    put(TARGET, 100000);
    command(0, SHUTDOWN, READY);
    put(CONTROL, ENABLE);
    cycles(300);
    assert_int_equal(get(0x603F), 0x8611);
}

static void offsets(void **state)
{
    (void)state;
    servo(CSP, 10000);
    enable(0);
    assert_int_equal(write_sdo(0x60B0, 0, 500, 4), 0);
    assert_int_equal(write_sdo(0x60B1, 0, 3000, 4), 0);
    assert_int_equal(write_sdo(0x60B2, 0, 20, 2), 0);
    put(TARGET, 1000);
    cycles(500);
    expect_near("60B0h has an effect, the others do not", 1500, 1, (double)get(ACTUAL));
    put(MODE, CSV);
    put(0x60FF, 10000);
    cycles(300);
    expect_near("60B1h counts in csv", 13000, 200, (double)get(0x606C));
}

static void interpolated_position(void **state)
{
    (void)state;
    servo(IP, 10000);
    enable(0);
    assert_int_equal(write_sdo(0x60C1, 1, 3000, 4), 0);
    cycles(300);
    expect_near("without bit 4", 0, 1, (double)get(ACTUAL));
    expect_bits("without bit 4", BIT_ATTAINED, 0);
    put(CONTROL, START);
    cycles(300);
    expect_near("with bit 4", 3000, 2, (double)get(ACTUAL));
    expect_bits("with bit 4", BIT_ATTAINED | BIT_TARGET, BIT_ATTAINED | BIT_TARGET);
    put(CONTROL, ENABLE);
    cycles(2);
    assert_int_equal(write_sdo(0x60C1, 1, 9000, 4), 0);
    cycles(300);
    expect_near("held", 3000, 2, (double)get(ACTUAL));
}

/* --- homing ------------------------------------------------------------------------------------------------------- */

static void no_run_below_operation(void **state)
{
    (void)state;
    servo(HM, 10000);
    assert_int_equal(write_sdo(0x6098, 0, 37, 1), 0);
    assert_int_equal(write_sdo(0x607C, 0, 100, 4), 0);
    command(0, SHUTDOWN, READY);
    put(CONTROL, SHUTDOWN | 0x10);
    cycles(50);
    assert_int_equal(get(ACTUAL), 0);
    assert_true(signal_of("axis1.homed") == 0);
}

/* Times to the edge that counts: DRV-425 to 430. */
static void homing_times(void **state)
{
    static const struct {
        const char *what;
        int8_t method;
        int64_t start, speed[2];
        double found_ms, home;
    } rows[] = {
        {"DRV-425 33", 33, 3000, {1000, 1000}, 3050, 0},    {"DRV-426 34", 34, 3000, {1000, 1000}, 7050, 10000},
        {"DRV-428 17", 17, 0, {2000, 500}, 3225, -5000},    {"DRV-429 19", 19, 0, {2000, 500}, 4725, 8000},
        {"DRV-430 20", 20, 12000, {2000, 500}, 2725, 8000},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(HM, 10000);
        signals("axis1.index_at", -rows[i].start);
        signals("axis1.home_at", 8000 - rows[i].start);
        signals("axis1.home_width", rows[i].method == 19 || rows[i].method == 20 ? 100000 : 0);
        if (rows[i].method == 17)
            signals("axis1.stop_negative", -5000);
        assert_int_equal(write_sdo(0x6099, 1, rows[i].speed[0], 4), 0);
        assert_int_equal(write_sdo(0x6099, 2, rows[i].speed[1], 4), 0);
        assert_int_equal(write_sdo(0x609A, 0, 10000, 4), 0);
        assert_int_equal(write_sdo(0x6098, 0, rows[i].method, 1), 0);
        enable(0);
        put(CONTROL, START);
        double ms = 0;
        do {
            cycles(1);
        } while (++ms < 20000 && (get(STATUS) & BIT_ATTAINED) == 0);
        expect_near(rows[i].what, rows[i].found_ms, rows[i].found_ms / 50, ms);
        expect_bits("DRV-267 home is found, the shaft returns", BIT_ATTAINED | BIT_TARGET, BIT_ATTAINED);
        cycles(2000);
        expect_bits("DRV-268 done", BIT_ATTAINED | BIT_TARGET, BIT_ATTAINED | BIT_TARGET);
        expect_near(rows[i].what, rows[i].home - (double)rows[i].start, 2, signal_of("axis1.machine_position"));
        close_drive(state);
    }
}

/* 6085h is 500 000 counts/s2: 100 ms and 2500 counts from 50 000 counts/s. */
static void limit_switch(void **state)
{
    static const int8_t modes[] = {PV, CSV};
    for (size_t i = 0; i < COUNT(modes); i++) {
        servo(modes[i], 10000);
        signals("axis1.stop_positive", 100000);
        enable(0);
        put(0x60FF, FAST);
        cycles(3000);
        expect_near("beyond the switch", 102500, 300, (double)get(ACTUAL));
        expect_bits("beyond the switch", BIT_LIMIT, BIT_LIMIT);
        assert_int_equal(state_of(get(STATUS)), ENABLED);
        put(0x60FF, -FAST);
        cycles(1000);
        assert_true(get(ACTUAL) < 90000);
        expect_bits("back", BIT_LIMIT, 0);
        close_drive(state);
    }
}

static void crosswise(void **state)
{
    (void)state;
    servo(HM, 10000);
    signals("axis1.negative_free", 1);
    signals("axis1.stop_positive", 5000);
    assert_int_equal(write_sdo(0x6098, 0, 18, 1), 0);
    enable(0);
    signals("axis1.negative_free", 0);
    assert_int_equal(home(18, 0), 8); /* the other switch on the way back */
    cycles(300);
    expect_bits("error", 0x3400, 0x2400);
    assert_true(signal_of("axis1.homed") == 0);
}

/* --- inputs ------------------------------------------------------------------------------------------------------- */

static void digital_inputs(void **state)
{
    static const struct {
        const char *signal, *value;
        uint32_t bits;
    } rows[] = {{"axis1.negative_free", "0", 0x01},
                {"axis1.positive_free", "0", 0x02},
                {"axis1.home", "1", 0x20004},
                {"axis1.sto", "1", 0x08},
                {"axis1.probe", "1", 0x10000}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        assert_int_equal(read_sdo(0x60FD, 0), 0);
        set(rows[i].signal, rows[i].value);
        cycles(1);
        if (read_sdo(0x60FD, 0) != rows[i].bits)
            fail_msg("%s: expected %X, got %llX", rows[i].signal, (unsigned int)rows[i].bits,
                     (unsigned long long)read_sdo(0x60FD, 0));
        close_drive(state);
    }
}

static void probe_levels(void **state)
{
    (void)state;
    servo(CSP, 10000);
    set("axis1.probe", "1");
    assert_int_equal(write_sdo(0x60B8, 0, 0x0031, 2), 0); /* a level is no edge */
    cycles(5);
    assert_int_equal(read_sdo(0x60B9, 0), 0x0001);
    set("axis1.probe", "0");
    cycles(1);
    assert_int_equal(read_sdo(0x60B9, 0), 0x0005);
    set("axis1.probe", "1");
    set("axis1.probe", "0");
    set("axis1.probe", "1");
    cycles(1);
    assert_int_equal(read_sdo(0x60B9, 0), 0x0007);
    assert_int_equal(read_sdo(0x60D5, 0), 1);
    assert_int_equal(write_sdo(0x60B8, 0, 0x0021, 2), 0); /* bit 4 off and on arms again */
    assert_int_equal(write_sdo(0x60B8, 0, 0x0031, 2), 0);
    set("axis1.probe", "0");
    set("axis1.probe", "1");
    cycles(1);
    assert_int_equal(read_sdo(0x60D5, 0), 2);
    assert_int_equal(write_sdo(0x60B8, 0, 0x000C | 0x11, 2), 0); /* source 3: nothing */
    set("axis1.probe", "0");
    set("axis1.probe", "1");
    assert_int_equal(read_sdo(0x60D5, 0), 2);
    assert_int_equal(read_sdo(0x60B9, 0) & 0xC0, 0);
}

int main(void)
{
#define TEST(title, function) {title, function, NULL, close_drive, NULL}
    const struct CMUnitTest tests[] = {
        TEST("DRV-204 a new mode brakes a profiled motion, or takes it over", mode_changes),
        TEST("DRV-248 Operation enabled begins at the present speed; 0 holds", enabled_while_turning),
        TEST("DRV-210 DRV-220 speeds of set-points", set_points),
        TEST("DRV-221 a set-point beyond 607Dh ends there without bit 10", beyond_the_limit),
        TEST("DRV-237 limits that are none", no_limits),
        TEST("DRV-231 DRV-235 DRV-277 polarity, home offset and limits", turned),
        TEST("DRV-239 DRV-113 DRV-250 DRV-418 a torque at its limit is bit 11", torque_held),
        TEST("DRV-240 DRV-245 DRV-261 DRV-113 a speed at its limit is bit 11", speed_held),
        TEST("DRV-240 8400h is 1.2 times 6080h for 10 ms", overspeed),
        TEST("DRV-013 DRV-526 DRV-415 DRV-417 DRV-257 DRV-255 csp: straight lines, and a lost frame", interpolates),
        TEST("DRV-260 csp begins far from the shaft", far_target),
        TEST("DRV-256 offsets", offsets),
        TEST("DRV-262 ip: bit 4", interpolated_position),
        TEST("DRV-281 no run below Operation enabled", no_run_below_operation),
        TEST("DRV-518 DRV-425 DRV-426 DRV-428..430 DRV-267 DRV-274..276 times of reference runs", homing_times),
        TEST("DRV-238 a limit switch stops on 6085h, back is free", limit_switch),
        TEST("DRV-431 DRV-278 the other limit switch ends a run", crosswise),
        TEST("DRV-311 60FDh", digital_inputs),
        TEST("DRV-303 DRV-305 DRV-307 DRV-309 touch probes: levels, arming, sources", probe_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
