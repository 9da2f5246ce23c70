/* SPDX-License-Identifier: MIT */
/* Modes, reference runs, touch probes, limits and units of a drive over a dictionary. A turn has 10 000 counts. */
#include "drive_of_file.h"

enum { TOLERANCE = 2 };

/* --- reference runs ----------------------------------------------------------------------------------------------- */

enum { CAM = 20000, CAM_END = 23000, FAR = 40000, INDEX = 1234 };

static void machine(int64_t start, int8_t method)
{
    unsigned int kind = (unsigned int)(method > 16 ? method - 16 : method);
    int64_t at = kind == 5 || kind == 6 ? -100000 : CAM;
    int64_t end = kind == 3 || kind == 4 ? 100000 : kind == 5 || kind == 6 ? CAM : CAM_END;
    signals("axis1.home_at", at - start);
    signals("axis1.home_width", end - at);
    signals("axis1.stop_positive", FAR - start);
    signals("axis1.stop_negative", -FAR - start);
    signals("axis1.index_at", INDEX - start);
}

static void each_method(void **state)
{
    static const int64_t starts[] = {0, 21500, 30000};
    static const struct {
        int8_t method;
        int64_t home;
    } rows[] = {{1, -38766}, {2, 31234},    {3, 11234},    {4, 21234},    {5, 21234},    {6, 11234},  {7, 11234},
                {8, 21234},  {9, 21234},    {10, 31234},   {11, 31234},   {12, 21234},   {13, 21234}, {14, 11234},
                {17, -FAR},  {18, FAR},     {19, CAM},     {20, CAM},     {21, CAM},     {22, CAM},   {23, CAM},
                {24, CAM},   {25, CAM_END}, {26, CAM_END}, {27, CAM_END}, {28, CAM_END}, {29, CAM},   {30, CAM}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (size_t k = 0; k < COUNT(starts); k++) {
            char what[40];
            (void)snprintf(what, sizeof what, "method %d from %lld", rows[i].method, (long long)starts[k]);
            servo(HM, 10000);
            machine(starts[k], rows[i].method);
            enable(0);
            unsigned int bits = home(rows[i].method, 0);
            if (bits != 5)
                fail_msg("%s: ends with bits 13, 12, 10 = %X", what, bits);
            expect_near(what, (double)(rows[i].home - starts[k]), TOLERANCE, signal_of("axis1.machine_position"));
            expect_near(what, 0, 1, (double)get(ACTUAL));
            close_drive(state);
        }
    }
}

static void wrong_limit(void **state)
{
    (void)state;
    servo(HM, 10000);
    signals("axis1.stop_negative", -5000);
    enable(0);
    assert_int_equal(home(21, 0), 8); /* still moving */
    cycles(200);
    assert_int_equal(get(STATUS) & 0x3400, 0x2400);
    assert_int_equal(state_of(get(STATUS)), ENABLED);
    assert_true(signal_of("axis1.homed") == 0);
}

/* --- touch probes ------------------------------------------------------------------------------------------------- */

static void sweep(int32_t from, int32_t to)
{
    for (int32_t n = 1; n <= 100; n++) {
        put(TARGET, from + (to - from) * n / 100);
        cycles(1);
    }
    cycles(300);
}

static void probes(void **state)
{
    (void)state;
    servo(CSP, 10000);
    signals("axis1.probe_at", 3000);
    signals("axis1.probe_width", 200);
    signals("axis1.index_at", 1500);
    enable(0);
    sweep(0, 1000);
    assert_int_equal(write_sdo(0x60B8, 0, 0x1531, 2), 0); /* 1: input, both edges, once; 2: index, positive */
    assert_int_equal(read_sdo(0x60B9, 0), 0x0101);
    sweep(1000, 5000);
    assert_int_equal(read_sdo(0x60B9, 0), 0x0307);
    assert_int_equal(read_sdo(0x60BA, 0), 3000);
    assert_int_equal(read_sdo(0x60BB, 0), 3200);
    assert_int_equal(read_sdo(0x60BC, 0), 1500);
    assert_int_equal(read_sdo(0x60D5, 0), 1);
    sweep(5000, 1000); /* nothing more: the edges come the other way round, at 3200 and 3000 */
    assert_int_equal(read_sdo(0x60BA, 0), 3000);
    assert_int_equal(write_sdo(0x60B8, 0, 0, 2), 0);
    assert_int_equal(read_sdo(0x60B9, 0), 0);
    assert_int_equal(write_sdo(0x60B8, 0, 0x0013, 2), 0); /* each positive edge */
    sweep(1000, 5000);
    assert_int_equal(read_sdo(0x60B9, 0), 0x0043);
    sweep(5000, 1000);
    assert_int_equal(read_sdo(0x60B9, 0), 0x0003);
    assert_int_equal(read_sdo(0x60BA, 0), 3200);
    assert_int_equal(read_sdo(0x60D5, 0), 3);
}

static void probe_source(void **state)
{
    (void)state;
    servo(CSP, 10000);
    signals("axis1.index_at", 1500);
    assert_int_equal(write_sdo(0x60D0, 1, 5, 2), 0);
    enable(0);
    assert_int_equal(write_sdo(0x60B8, 0, 0x0019, 2), 0);
    sweep(0, 3000);
    assert_int_equal(read_sdo(0x60BA, 0), 1500);
}

/* --- positions ---------------------------------------------------------------------------------------------------- */

static void go(int32_t target, uint16_t bits)
{
    put(TARGET, target);
    put(CONTROL, ENABLE);
    cycles(2);
    put(CONTROL, START | bits);
    cycles(2);
    for (unsigned int n = 0; n < 20000 && (get(STATUS) & 0x0400) == 0; n++)
        cycles(1);
    assert_true((get(STATUS) & 0x0400) != 0);
}

static void rotary(void **state)
{
    static const struct {
        uint16_t option;
        double way;
    } rows[] = {{0x00, -340000}, {0x40, -340000}, {0x80, 20000}, {0xC0, 20000}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(PP, 360000);
        settings(3600000, 36000000);
        assert_int_equal(write_sdo(0x607B, 2, 359999, 4), 0);
        enable(0);
        go(350000, 0);
        double before = signal_of("axis1.machine_position");
        assert_int_equal(write_sdo(0x60F2, 0, rows[i].option, 2), 0);
        go(10000, 0);
        cycles(200);
        expect_near("way", rows[i].way, 30, signal_of("axis1.machine_position") - before);
        expect_near("position", 10000, 20, (double)get(ACTUAL));
        close_drive(state);
    }
}

static void rotary_cyclic(void **state)
{
    (void)state;
    servo(CSP, 360000);
    assert_int_equal(write_sdo(0x607B, 2, 359999, 4), 0);
    enable(0);
    for (int32_t n = 1; n <= 2000; n++) {
        put(TARGET, n * 400 % 360000);
        cycles(1);
    }
    cycles(300);
    expect_near("on the machine", 800000, 5, signal_of("axis1.machine_position"));
    expect_near("folded", 80000, 5, (double)get(ACTUAL));
}

static void past_the_end(void **state)
{
    (void)state;
    servo(HM, 10000);
    enable(0);
    assert_int_equal(home(37, -2147483600), 5);
    assert_int_equal(get(ACTUAL), 2147483600);
    put(CONTROL, ENABLE);
    put(TARGET, get(ACTUAL));
    put(MODE, CSP);
    cycles(2);
    put(TARGET, -2147483600);
    cycles(300);
    assert_int_equal(get(ACTUAL), -2147483600);
    assert_int_equal(state_of(get(STATUS)), ENABLED);
}

static void soft_limits(void **state)
{
    (void)state;
    servo(HM, 10000);
    assert_int_equal(write_sdo(0x607D, 1, -100000, 4), 0);
    assert_int_equal(write_sdo(0x607D, 2, 100000, 4), 0);
    enable(0);
    assert_int_equal(home(37, 5000), 5);
    put(CONTROL, ENABLE);
    put(TARGET, get(ACTUAL));
    put(MODE, CSP);
    cycles(2);
    for (int32_t n = 0; n <= 2000; n++) {
        put(TARGET, n * 100);
        cycles(1);
    }
    expect_near("upper limit", 95000, 5, (double)get(ACTUAL));
    assert_true((get(STATUS) & 0x0800) != 0);
    sweep(95000, 90000);
    expect_near("back", 90000, 5, (double)get(ACTUAL));
    assert_true((get(STATUS) & 0x0800) == 0);
}

static void relative_targets(void **state)
{
    (void)state;
    servo(PP, 10000);
    enable(0);
    for (unsigned int n = 0; n < 3; n++)
        go(1000, 0x40);
    cycles(200);
    expect_near("three times", 3000, 1, (double)get(ACTUAL));
    assert_int_equal(write_sdo(0x60F2, 0, 3, 2), 0x06090030);
    assert_int_equal(write_sdo(0x60F2, 0, 0x10, 2), 0x06090030);
}

static void fine_units(void **state)
{
    (void)state;
    open_drive("SCREW");
    assert_int_equal(write_sdo(0x608F, 1, 1048576, 4), 0);
    assert_int_equal(write_sdo(0x6091, 1, 10, 4), 0);
    assert_int_equal(write_sdo(0x6092, 1, 360000, 4), 0);
    put(MODE, CSP);
    operational();
    enable(0);
    put(TARGET, 1);
    cycles(2000); /* friction */
    assert_int_equal(read_sdo(0x6063, 0), 29);
    put(TARGET, 90000);
    cycles(2000);
    assert_int_equal(get(ACTUAL), 90000);
    assert_int_equal(read_sdo(0x6063, 0), 2621440);
}

/* --- speeds and torques ------------------------------------------------------------------------------------------- */

static void profile_velocity(void **state)
{
    (void)state;
    servo(PV, 10000);
    enable(0);
    put(0x60FF, 50000);
    cycles(250);
    expect_near("half way up", 25000, 500, (double)get(0x606C));
    cycles(300);
    expect_near("there", 50000, 500, (double)get(0x606C));
    put(0x60FF, -50000);
    cycles(500);
    expect_near("turning", 0, 500, (double)get(0x606C));
    cycles(550);
    expect_near("back", -50000, 500, (double)get(0x606C));
    put(CONTROL, ENABLE | 0x100);
    cycles(600);
    expect_near("halted", 0, 50, (double)get(0x606C));
    assert_true((get(STATUS) & 0x1400) == 0x1400);
}

static void profile_torque(void **state)
{
    (void)state;
    servo(TQ, 10000);
    assert_int_equal(write_sdo(0x6087, 0, 1000, 4), 0);
    set("axis1.jam", "1");
    enable(0);
    put(0x6071, 500);
    cycles(250);
    expect_near("half way", 250, 3, (double)get(0x6077));
    assert_true((get(STATUS) & 0x0400) == 0);
    cycles(255);
    expect_near("there", 500, 1, (double)get(0x6077));
    assert_true((get(STATUS) & 0x0400) != 0);
}

static void cyclic_torque(void **state)
{
    (void)state;
    servo(CST, 10000);
    set("axis1.jam", "1");
    assert_int_equal(write_sdo(0x60B2, 0, -100, 2), 0);
    enable(0);
    put(0x6071, 500);
    cycles(5);
    assert_int_equal(get(0x6077), 400);
    expect_near("Nm", 1.2, 0.01, signal_of("axis1.torque"));
    assert_int_equal(write_sdo(0x60E0, 0, 300, 2), 0);
    cycles(5);
    assert_int_equal(get(0x6077), 300);
}

static void quick_stop_stays(void **state)
{
    (void)state;
    servo(PV, 10000);
    assert_int_equal(write_sdo(0x605A, 0, 6, 2), 0);
    enable(0);
    put(0x60FF, 50000);
    cycles(700);
    put(CONTROL, 0x0B);
    cycles(80);
    assert_true((get(STATUS) & 0x0400) == 0);
    cycles(100);
    assert_int_equal(state_of(get(STATUS)), STOPPING);
    assert_true((get(STATUS) & 0x0400) != 0);
    command(0, ENABLE, ENABLED);
    cycles(600);
    expect_near("again", 50000, 500, (double)get(0x606C));
}

static void gravity_and_brake(void **state)
{
    (void)state;
    servo(CSP, 10000);
    set("axis1.load", "1");
    cycles(500);
    assert_true(signal_of("axis1.turns") < -1);
    set("axis1.brake", "9");
    cycles(1000);
    double held = signal_of("axis1.turns");
    cycles(500);
    expect_near("held", held, 1e-9, signal_of("axis1.turns"));
    enable(0);
    put(TARGET, get(ACTUAL));
    cycles(500);
    expect_near("against gravity", 1, 0.1, signal_of("axis1.torque"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"DRV-279 DRV-282..292 DRV-274..276 each method from each side ends at its point", each_method, NULL,
         close_drive, NULL},
        {"DRV-278 a limit switch that the method does not seek ends a run", wrong_limit, NULL, close_drive, NULL},
        {"DRV-062 DRV-301..304 DRV-306..308 touch probes store positions at the edge", probes, NULL, close_drive, NULL},
        {"DRV-067 the source of a probe by 60D0h", probe_source, NULL, close_drive, NULL},
        {"DRV-036 DRV-423 DRV-224 DRV-234 targets of a rotary axis", rotary, NULL, close_drive, NULL},
        {"DRV-234 a rotary axis in csp turns on over its end", rotary_cyclic, NULL, close_drive, NULL},
        {"DRV-416 DRV-232 DRV-233 an endless axis passes 2^31", past_the_end, NULL, close_drive, NULL},
        {"DRV-038 DRV-424 DRV-235 DRV-236 software limits in csp", soft_limits, NULL, close_drive, NULL},
        {"DRV-411 DRV-222 DRV-223 relative targets", relative_targets, NULL, close_drive, NULL},
        {"DRV-420 units of a tenth of a degree behind a gear", fine_units, NULL, close_drive, NULL},
        {"DRV-414 DRV-245 DRV-205 DRV-247 profile velocity, and halt", profile_velocity, NULL, close_drive, NULL},
        {"DRV-419 DRV-250 profile torque", profile_torque, NULL, close_drive, NULL},
        {"DRV-418 DRV-239 DRV-256 cyclic torque, its offset and its limit", cyclic_torque, NULL, close_drive, NULL},
        {"DRV-206 DRV-141 DRV-146 a quick stop that stays, and on", quick_stop_stays, NULL, close_drive, NULL},
        {"DRV-152 gravity, and a brake that holds", gravity_and_brake, NULL, close_drive, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
