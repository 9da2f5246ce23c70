/* SPDX-License-Identifier: MIT */
/* The PMCtendo with status_bits=402 for a program written from CiA 402-2 alone; option codes, windows, limits and the
 * other objects that such a program reads; on the virtual clock. */
#include <math.h>
#include <stdlib.h>

#include "profile_bench.h"

enum { B10 = 0x0400, B12 = 0x1000, B13 = 0x2000, ALL = B10 | B12 | B13 };

static int setup(void **state)
{
    (void)state;
    drive_open(&d);
    signal_set(&d.w, "status_bits", "402");
    return 0;
}

static void expect_bits(const char *what, unsigned int want)
{
    unsigned int got = drive_status(&d) & ALL;
    if (got != want)
        fail_msg("%s: expected bits 13, 12, 10 = %u %u %u, got %u %u %u", what, (want & B13) != 0, (want & B12) != 0,
                 (want & B10) != 0, (got & B13) != 0, (got & B12) != 0, (got & B10) != 0);
}

/* --- the status word by mode -------------------------------------------------------------------------------------- */

static void straight_to_enabled(void **state)
{
    (void)state;
    drive_operational(&d, 0x1701, 0x1B25);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 3);
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "0Fh alone");
    drive_control(&d, 0x06);
    drive_cycles(&d, 2);
    drive_expect(&d, ECT_402_READY, "06h");
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    drive_expect(&d, ECT_402_OPERATION_ENABLED, "06h, then 0Fh");
    drive_control(&d, 0x07);
    drive_cycles(&d, 2);
    drive_expect(&d, ECT_402_SWITCHED_ON, "07h");
    signal_set(&d.w, "provoke", "3");
    drive_control(&d, 0x8F); /* the level of bits 0 to 3 enables from Ready on, never out of a fault */
    drive_cycles(&d, 5);
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "reset");
}

/* Without the setting the manual's edge of bit 3 is required. */
static void manual_needs_the_edge(void **state)
{
    (void)state;
    signal_set(&d.w, "status_bits", "0");
    drive_operational(&d, 0x1701, 0x1B25);
    drive_control(&d, 0x06);
    drive_cycles(&d, 2);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 5);
    drive_expect(&d, ECT_402_SWITCHED_ON, "06h, then 0Fh");
    char message[ECT_SIGNAL_MESSAGE];
    assert_false(signal_try_set(&d.w, "status_bits", "401", message));
}

static void handshake(void **state)
{
    (void)state;
    start(PMC_MODE_TASK, 0x1701);
    expect_bits("no task yet", 0);
    put(0x607A, 0, TURN, 4);
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    expect_bits("taken", B12);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    expect_bits("room for another", 0);
    put(0x607A, 0, 3 * TURN, 4);
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    expect_bits("a second one is taken", B12);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 5);
    expect_bits("both places are taken", B12);
    (void)drive_until(&d, B12, 0, 400); /* the first one is done: 200 ms */
    expect_bits("the second one runs", 0);
    (void)drive_until(&d, B10, B10, 500);
    expect_bits("there", B10);
    drive_control(&d, 0x1F); /* the same target again */
    drive_cycle(&d);
    assert_int_equal(drive_status(&d) & B12, B12);
}

static void task_bits(void **state)
{
    (void)state;
    start(PMC_MODE_TASK, 0x1701);
    put(0x607A, 0, 10 * TURN, 4);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 300);
    drive_control(&d, 0x11F);
    drive_cycle(&d);
    expect_bits("braking", B12);
    drive_cycles(&d, 200);
    expect_bits("halted: it stands", B12 | B10);
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    expect_bits("on its way again", B12);
}

/* Bits 13, 12, 10: 000 running, 001 not started or interrupted, 011 done, 100 and 101 failed. */
static void homing_bits(void **state)
{
    (void)state;
    signal_set(&d.w, "home_at", "2097152");
    signal_set(&d.w, "home_width", "524288");
    put(0x6098, 0, 19, 1);
    start(PMC_MODE_HOMING, 0x1701);
    drive_cycles(&d, 5);
    expect_bits("not started", B10);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 100);
    expect_bits("running", 0);
    drive_control(&d, 0x0F);
    drive_cycle(&d);
    expect_bits("interrupted, braking", 0);
    drive_cycles(&d, 200);
    expect_bits("interrupted, standing", B10);
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    (void)drive_until(&d, B12, B12, 20000);
    expect_bits("found, on the way back", B12);
    (void)drive_until(&d, B10, B10, 20000);
    expect_bits("done", B12 | B10);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 100);
    expect_bits("done, bit 4 taken back", B12 | B10);
    signal_set(&d.w, "home_width", "0");
    signal_set(&d.w, "stop_positive", "5000000");
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    (void)drive_until(&d, B13, B13, 20000);
    expect_bits("failed, moving", B13);
    drive_cycles(&d, 300);
    expect_bits("failed, standing", B13 | B10);
    drive_expect(&d, ECT_402_OPERATION_ENABLED, "failed");
}

static void speed_bits(void **state)
{
    (void)state;
    put(0x606E, 0, 50, 2);
    put(0x6070, 0, 20, 2);
    start(PMC_MODE_SPEED_RAMP, 0x1702);
    drive_cycles(&d, 60);
    expect_bits("standing", B12 | B10);
    drive_set(&d, 10 * TURN);
    drive_cycles(&d, 15);
    expect_bits("above the threshold for less than 6070h", B12);
    drive_cycles(&d, 10);
    expect_bits("turning", 0);
    unsigned int ms = 0, outside = 0;
    while ((drive_status(&d) & B10) == 0) {
        drive_cycle(&d);
        ms++;
        outside = fabs(speed() - 10.0 * TURN) > 65535 ? ms : outside;
    }
    expect_near("bit 10 after 606Eh", 50, 2, ms - outside);
    expect_bits("at its speed", B10);
}

static void cyclic_bits(void **state)
{
    static const struct {
        int8_t mode;
        uint16_t pdo;
    } rows[] = {{PMC_MODE_POSITION, 0x1701}, {PMC_MODE_SPEED, 0x1702}, {PMC_MODE_TORQUE, 0x1704}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        drive_open(&d);
        signal_set(&d.w, "status_bits", "402");
        put(0x6060, 0, rows[i].mode, 1);
        drive_operational(&d, rows[i].pdo, 0x1B25);
        expect_bits("not enabled", 0);
        drive_enable(&d);
        drive_cycle(&d);
        expect_bits("follows", B12);
        drive_control(&d, 0x10F);
        drive_cycle(&d);
        expect_bits("halted", 0);
        drive_control(&d, 0x0B);
        drive_cycle(&d);
        expect_bits("quick stop", 0);
        drive_close(&d);
    }
}

/* Mode 7: bit 10 is the position window, bit 12 follows. */
static void interpolated_bits(void **state)
{
    (void)state;
    start(PMC_MODE_INTERPOLATED, 0x1701);
    drive_cycles(&d, 10);
    expect_bits("at the set position", B12 | B10);
    drive_set(&d, 200000);
    drive_cycle(&d);
    expect_bits("on the way", B12);
    drive_cycles(&d, 300);
    expect_bits("there", B12 | B10);
    drive_control(&d, 0x10F);
    drive_cycles(&d, 20);
    expect_bits("halted", B10);
}

/* A set position beyond 607Dh is not followed: bit 12 falls, bit 11 rises. */
static void position_at_a_limit(void **state)
{
    (void)state;
    put(0x607D, 2, 100000, 4);
    put(0x607D, 1, -100000, 4);
    drive_instance(&d)->axis.homed = true;
    start(PMC_MODE_POSITION, 0x1701);
    drive_set(&d, 100000);
    drive_cycles(&d, 300);
    expect_bits("at the limit", B12);
    drive_set(&d, 110000);
    drive_cycles(&d, 300);
    expect_bits("beyond", 0);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_LIMIT, ECT_402_STATUS_LIMIT);
    assert_in_range(drive_position(&d), 99998, 100002);
    for (int32_t x = 100000; x >= -110000; x -= 10000) {
        drive_set(&d, x);
        drive_cycle(&d);
    }
    drive_cycles(&d, 300);
    expect_bits("beyond the other one", 0);
    assert_in_range(drive_position(&d) + 100000, 0, 2);
    assert_int_equal(drive_instance(&d)->warnings, 1u << (PMC_N_SOFT_NEGATIVE - 1));
}

/* --- following error, windows ------------------------------------------------------------------------------------- */

/* The shaft is held fast, 1500 counts off, with a window of 1000: F03 after 6066h. */
static void following_error_time(void **state)
{
    (void)state;
    put(0x6065, 0, 1000, 4);
    put(0x6066, 0, 100, 2);
    start(PMC_MODE_POSITION, 0x1701);
    signal_set(&d.w, "friction", "50");
    drive_set(&d, 1500);
    drive_cycles(&d, 99);
    drive_set(&d, 0);
    drive_cycles(&d, 10);
    assert_int_equal(drive_instance(&d)->fault, 0);
    drive_set(&d, 1500);
    drive_cycles(&d, 99);
    assert_int_equal(drive_instance(&d)->fault, 0);
    assert_int_equal(drive_status(&d) & B13, 0);
    drive_cycles(&d, 3);
    assert_int_equal(drive_instance(&d)->fault, PMC_F_FOLLOWING);
    assert_int_equal(drive_instance(&d)->error_code, 0x8611);
}

static void position_window_time(void **state)
{
    (void)state;
    put(0x6067, 0, 10, 4);
    put(0x6068, 0, 50, 2);
    start(PMC_MODE_TASK, 0x1701);
    put(0x607A, 0, TURN, 4);
    drive_control(&d, 0x1F);
    drive_cycle(&d);
    unsigned int outside = 0, ms = 1;
    while ((drive_status(&d) & B10) == 0) {
        drive_cycle(&d);
        ms++;
        outside = abs(drive_position(&d) - TURN) > 10 ? ms : outside;
    }
    expect_near("bit 10 after 6068h", 50, 2, ms - outside);
}

/* --- option codes ------------------------------------------------------------------------------------------------- */

/* From 20 turns a second: 200 ms on 6084h, 40 ms on 6085h, 5 ms with all the torque; else it coasts. */
static const struct {
    const char *what;
    uint16_t index;
    int16_t option;
    uint16_t control; /* 0: a fault */
    unsigned int from_ms, to_ms;
    ect_402_state_t end;
} stops[] = {
    {"605Bh 0: coasts", 0x605B, 0, 0x0E, 0, 1, ECT_402_READY},
    {"605Bh 1: 6084h", 0x605B, 1, 0x0E, 195, 215, ECT_402_READY},
    {"605Ch 0: coasts", 0x605C, 0, 0x07, 0, 1, ECT_402_SWITCHED_ON},
    {"605Ch 1: 6084h", 0x605C, 1, 0x07, 195, 215, ECT_402_SWITCHED_ON},
    {"605Eh 0: coasts", 0x605E, 0, 0, 0, 1, ECT_402_FAULT},
    {"605Eh 1: 6084h", 0x605E, 1, 0, 195, 215, ECT_402_FAULT},
    {"605Eh 2: 6085h", 0x605E, 2, 0, 38, 60, ECT_402_FAULT},
    {"605Eh 3: torque limit", 0x605E, 3, 0, 3, 20, ECT_402_FAULT},
    {"605Eh 4: torque limit", 0x605E, 4, 0, 3, 20, ECT_402_FAULT},
};

static void fast(void)
{
    signal_set(&d.w, "brake", "0");
    signal_set(&d.w, "friction", "0");
    start(PMC_MODE_SPEED, 0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 500);
}

static void one_stop(size_t i)
{
    static const uint16_t masks[ECT_402_STATES] = {0x4F, 0x4F, 0x6F, 0x6F, 0x6F, 0x6F, 0x4F, 0x4F};
    static const uint16_t values[ECT_402_STATES] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};
    drive_open(&d);
    put(stops[i].index, 0, stops[i].option, 2);
    fast();
    if (stops[i].control != 0)
        drive_control(&d, stops[i].control);
    else
        signal_set(&d.w, "provoke", "3");
    unsigned int ms = drive_until(&d, masks[stops[i].end], values[stops[i].end], 1000);
    if (ms < stops[i].from_ms || ms > stops[i].to_ms)
        fail_msg("%s: expected %u to %u ms, got %u", stops[i].what, stops[i].from_ms, stops[i].to_ms, ms);
    drive_cycles(&d, 100);
    expect_near(stops[i].what, stops[i].option == 0 ? 20.0 * TURN : 0, 60000, speed());
    drive_expect(&d, stops[i].end, stops[i].what);
    drive_close(&d);
}

static void stopping(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(stops); i++)
        one_stop(i);
}

static void halts(void **state)
{
    static const unsigned int until_ms[] = {0, 215, 60, 30, 30};
    static const unsigned int from_ms[] = {0, 190, 35, 2, 2};
    (void)state;
    for (int16_t option = 1; option <= 4; option++) {
        drive_open(&d);
        put(0x605D, 0, option, 2);
        fast();
        drive_control(&d, 0x10F);
        unsigned int ms = drive_until(&d, B10, B10, 1000);
        if (ms < from_ms[option] || ms > until_ms[option])
            fail_msg("605Dh %d: expected %u to %u ms, got %u", option, from_ms[option], until_ms[option], ms);
        drive_expect(&d, ECT_402_OPERATION_ENABLED, "halt");
        drive_close(&d);
    }
}

/* 605Ch 0: Switched On has no torque, so a load needs the brake there, too. */
static void switched_on_without_torque(void **state)
{
    (void)state;
    put(0x605C, 0, 0, 2);
    signal_set(&d.w, "load", "1");
    drive_operational(&d, 0x1702, 0x1B25);
    drive_control(&d, 0x06);
    drive_cycles(&d, 2);
    drive_control(&d, 0x07);
    drive_cycles(&d, 500);
    drive_expect(&d, ECT_402_SWITCHED_ON, "605Ch 0");
    assert_int_equal(signal_number(&d.w, "powered"), 0);
    assert_int_equal(drive_position(&d), 0);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 500);
    assert_int_equal(signal_number(&d.w, "powered"), 1);
    expect_near("speed", 0, 1000, speed());
}

static void unknown_options(void **state)
{
    static const struct {
        uint16_t index;
        int32_t values[6];
    } rows[] = {{0x605A, {-1, 3, 4, 7, 8, 9}}, {0x605B, {-1, 2, 3, 4, 5, 6}}, {0x605C, {-1, 2, 3, 4, 5, 6}},
                {0x605D, {-1, 0, 5, 6, 7, 8}}, {0x605E, {-1, 5, 6, 7, 8, 9}}, {0x6086, {-1, 1, 2, 3, 4, 5}}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t before = drive_read(&d, rows[i].index, 0);
        for (size_t n = 0; n < COUNT(rows[i].values); n++) {
            uint32_t abort = drive_write(&d, rows[i].index, 0, (uint32_t)rows[i].values[n], 2);
            if (abort != 0x06090030)
                fail_msg("%04Xh = %d: abort %08X", rows[i].index, rows[i].values[n], abort);
        }
        assert_int_equal(drive_read(&d, rows[i].index, 0), before);
    }
    assert_int_equal(drive_write(&d, 0x607E, 0, 0x80, 1), 0x06090030);
    put(0x607E, 0, 0, 1);
    put(0x6086, 0, 0, 2);
}

/* --- limits ------------------------------------------------------------------------------------------------------- */

static void torque_limits(void **state)
{
    static const struct {
        uint16_t index;
        bool positive, negative;
    } rows[] = {{0x6072, true, true}, {0x6073, true, true}, {0x60E0, true, false}, {0x60E1, false, true}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        drive_open(&d);
        signal_set(&d.w, "load_inertia", "100");
        put(rows[i].index, 0, 100, 2);
        start(PMC_MODE_TORQUE, 0x1704);
        drive_set(&d, 300);
        drive_cycles(&d, 2);
        assert_int_equal((int16_t)drive_read(&d, 0x6077, 0), rows[i].positive ? 100 : 300);
        assert_int_equal((int16_t)drive_read(&d, 0x6078, 0), rows[i].positive ? 100 : 300);
        drive_set(&d, -300);
        drive_cycles(&d, 2);
        assert_int_equal((int16_t)drive_read(&d, 0x6077, 0), rows[i].negative ? -100 : -300);
        assert_int_equal((int16_t)drive_read(&d, 0x6074, 0), rows[i].negative ? -100 : -300);
        drive_close(&d);
    }
}

static void motor_speed(void **state)
{
    (void)state;
    put(0x6080, 0, 300, 4); /* turns a minute */
    start(PMC_MODE_SPEED, 0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 300);
    expect_near("speed", 5.0 * TURN, 1000, speed());
    assert_int_equal(drive_instance(&d)->fault, 0);
}

/* 60C5h and 60C6h halve the ramps of 6083h and 6084h: 20 turns a second after 400 ms. */
static void acceleration_limits(void **state)
{
    (void)state;
    put(0x60C5, 0, 50 * TURN, 4);
    put(0x60C6, 0, 50 * TURN, 4);
    start(PMC_MODE_SPEED_RAMP, 0x1702);
    drive_set(&d, 20 * TURN);
    drive_cycles(&d, 201);
    expect_near("up", 10.0 * TURN, TURN / 3.0, speed());
    drive_cycles(&d, 300);
    drive_set(&d, 0);
    drive_cycles(&d, 201);
    expect_near("down", 10.0 * TURN, TURN / 3.0, speed());
}

/* 60FEh sets the outputs that its mask names; the others are 2001h's. Bit 0 closes the brake. */
static void digital_outputs(void **state)
{
    (void)state;
    drive_operational(&d, 0x1720, 0x1B25);
    ect_store_le16(d.out + d.to.outputs, 2);
    drive_enable(&d);
    put(0x60FE, 1, 0x00010000, 4);
    drive_cycle(&d);
    assert_int_equal(signal_number(&d.w, "do1"), 0); /* no mask */
    assert_int_equal(signal_number(&d.w, "do2"), 1);
    put(0x60FE, 2, 0x00030000, 4);
    drive_cycle(&d);
    assert_int_equal(signal_number(&d.w, "do1"), 1);
    assert_int_equal(signal_number(&d.w, "do2"), 0);
    put(0x60FE, 2, 0x00010001, 4);
    put(0x60FE, 1, 0x00010001, 4);
    for (int32_t i = 1; i <= 20; i++) {
        drive_set(&d, i * 1000);
        drive_cycle(&d);
    }
    assert_int_equal(drive_position(&d), 0); /* the brake holds it */
    put(0x60FE, 1, 0x00010000, 4);
    drive_cycles(&d, 300);
    expect_near("position", 20000, 2, drive_position(&d));
    assert_int_equal(wire_al(&d.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    wire_advance(&d.w, 10 * MS);
    assert_int_equal(signal_number(&d.w, "do1"), 0); /* outside OP */
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

static const struct {
    uint16_t index;
    uint8_t subindex, bytes;
    uint32_t value;
    bool writable;
} objects[] = {
    {0x605B, 0, 2, 1, true},     {0x605C, 0, 2, 1, true},          {0x605D, 0, 2, 1, true},
    {0x605E, 0, 2, 2, true},     {0x6066, 0, 2, 0, true},          {0x6068, 0, 2, 0, true},
    {0x606D, 0, 2, 65535, true}, {0x606E, 0, 2, 0, true},          {0x606F, 0, 2, 65535, true},
    {0x6070, 0, 2, 0, true},     {0x6073, 0, 2, 3000, true},       {0x6074, 0, 2, 0, false},
    {0x6075, 0, 4, 5000, false}, {0x6076, 0, 4, 3000, false},      {0x6077, 0, 2, 0, false},
    {0x6078, 0, 2, 0, false},    {0x607E, 0, 1, 0, true},          {0x6080, 0, 4, 6000, true},
    {0x6086, 0, 2, 0, true},     {0x608F, 1, 4, PMC_TURN, false},  {0x608F, 2, 4, 1, false},
    {0x6091, 1, 4, 1, false},    {0x6091, 2, 4, 1, false},         {0x6092, 1, 4, PMC_TURN, false},
    {0x6092, 2, 4, 1, false},    {0x60C5, 0, 4, UINT32_MAX, true}, {0x60C6, 0, 4, UINT32_MAX, true},
    {0x60E0, 0, 2, 3000, true},  {0x60E1, 0, 2, 3000, true},       {0x60FE, 1, 4, 0, true},
    {0x60FE, 2, 4, 0, true},
};

static void standard_objects(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(objects); i++) {
        uint8_t data[4] = {0};
        size_t size = sizeof data;
        uint32_t abort = wire_sdo_upload(&d.w, 0, objects[i].index, objects[i].subindex, false, data, &size);
        if (abort != 0 || size != objects[i].bytes || ect_load_le32(data) != objects[i].value)
            fail_msg("%04Xh:%u: abort %08X, %zu bytes, %u", objects[i].index, objects[i].subindex, abort, size,
                     ect_load_le32(data));
        abort = drive_write(&d, objects[i].index, objects[i].subindex, objects[i].value, objects[i].bytes);
        if (abort != (objects[i].writable ? 0 : 0x06010002))
            fail_msg("%04Xh:%u is written: abort %08X", objects[i].index, objects[i].subindex, abort);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"DRV-117 DRV-123 DRV-503: 0Fh after 06h enables; 0Fh alone does not", straight_to_enabled, setup, teardown,
         NULL},
        {"PLZ-021 DRV-503: without status_bits=402 bit 3 must rise", manual_needs_the_edge, setup, teardown, NULL},
        {"DRV-216 DRV-217: PP: bit 12 is the handshake of set-points", handshake, setup, teardown, NULL},
        {"DRV-205 DRV-218: PP: bit 10 while halted, and on the way", task_bits, setup, teardown, NULL},
        {"DRV-265..270 DRV-271 DRV-272 DRV-278: HM: bits 13, 12, 10", homing_bits, setup, teardown, NULL},
        {"DRV-246 DRV-247 DRV-414: PV: bit 10 after 606Eh in the window, bit 12 speed is 0", speed_bits, setup,
         teardown, NULL},
        {"DRV-258 DRV-259 DRV-502: CSP, CSV, CST: bit 12 follows, bit 10 is 0", cyclic_bits, NULL, NULL, NULL},
        {"DRV-262: IP: bit 10 in position, bit 12 follows", interpolated_bits, setup, teardown, NULL},
        {"DRV-258 DRV-113: CSP: bit 12 is 0 and bit 11 is 1 beyond 607Dh", position_at_a_limit, setup, teardown, NULL},
        {"DRV-241 DRV-413: 8611h after 6066h beyond 6065h, not before", following_error_time, setup, teardown, NULL},
        {"DRV-218 DRV-412: PP: bit 10 after 6068h within 6067h", position_window_time, setup, teardown, NULL},
        {"DRV-147 DRV-149: 605Bh, 605Ch, 605Eh: which ramp, how long", stopping, NULL, NULL, NULL},
        {"DRV-148: 605Dh: which ramp a halt takes", halts, NULL, NULL, NULL},
        {"DRV-147 DRV-104: 605Ch 0: no torque in Switched On", switched_on_without_torque, setup, teardown, NULL},
        {"DRV-098: option codes outside their list: 06090030, the old value stays", unknown_options, setup, teardown,
         NULL},
        {"DRV-239: 6072h, 6073h, 60E0h, 60E1h limit the torque", torque_limits, NULL, NULL, NULL},
        {"DRV-240: 6080h limits the speed", motor_speed, setup, teardown, NULL},
        {"DRV-220: 60C5h and 60C6h limit the ramps", acceleration_limits, setup, teardown, NULL},
        {"DRV-312: 60FEh sets outputs and closes the brake", digital_outputs, setup, teardown, NULL},
        {"DRV-623: the standard's objects: width, value, access", standard_objects, setup, teardown, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo as CiA 402-2 has it", tests, NULL, NULL);
}
