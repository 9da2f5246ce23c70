/* SPDX-License-Identifier: MIT */
/* Reference runs of the PMCtendo (6098h), the start bits, and SAVE; on the virtual clock. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/drive.h"
#include "support/sensor.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static drive_t d;

/* The machine: reference switch from 2 to 2.5 turns, limit switches at -3 and 6 turns, an index pulse at .25 of a turn.
 */
static void build_machine(void)
{
    signal_set(&d.w, "home_at", "2097152");
    signal_set(&d.w, "home_width", "524288");
    signal_set(&d.w, "stop_negative", "-3145728");
    signal_set(&d.w, "stop_positive", "6291456");
    signal_set(&d.w, "index_at", "262144");
}

enum { HOME_ON = 2097152, HOME_OFF = HOME_ON + 524288, NEGATIVE = -3145728, POSITIVE = 6291456 };
enum { INDEX = 262144 };
#define TURN PMC_TURN

/* Method, position of the shaft at the start, position of the reference point on the machine. */
static const struct {
    int8_t method;
    double from;
    double found;
} runs[] = {
    {1, 0, NEGATIVE + INDEX},
    {2, 0, POSITIVE - TURN + INDEX},
    {3, 0, HOME_ON - TURN + INDEX},
    {3, HOME_ON + 1000, HOME_ON - TURN + INDEX},
    {4, 0, HOME_ON + INDEX},
    {4, HOME_ON + 1000, HOME_ON + INDEX},
    {5, 4.0 * TURN, HOME_OFF + TURN / 2 + INDEX},
    {6, 4.0 * TURN, HOME_OFF - TURN / 2 + INDEX},
    {17, 0, NEGATIVE},
    {18, 0, POSITIVE},
    {19, 0, HOME_ON},
    {19, HOME_ON + 1000, HOME_ON},
    {20, 0, HOME_ON},
    {20, HOME_ON + 1000, HOME_ON},
    {21, 4.0 * TURN, HOME_OFF},
    {21, HOME_ON + 1000, HOME_OFF},
    {22, 4.0 * TURN, HOME_OFF},
    {22, HOME_ON + 1000, HOME_OFF},
    {33, 0, INDEX - TURN},
    {34, 0, INDEX},
    {35, 12345, 12345},
    {37, 12345, 12345},
};

static void one_run(size_t i, bool mode8)
{
    uint16_t bit = mode8 ? PMC_REFERENCE : ECT_402_START;
    drive_open(&d);
    build_machine();
    drive_instance(&d)->plant.machine.position = runs[i].from;
    assert_int_equal(drive_write(&d, 0x6060, 0, mode8 ? PMC_MODE_POSITION : PMC_MODE_HOMING, 1), 0);
    assert_int_equal(drive_write(&d, 0x6098, 0, (uint8_t)runs[i].method, 1), 0);
    assert_int_equal(drive_write(&d, 0x607C, 0, 5000, 4), 0);
    drive_operational(&d, 0x1701, 0x1B25);
    drive_enable(&d);
    drive_control(&d, 0x0F | bit);
    (void)drive_until(&d, PMC_STATUS_REFERENCING | ECT_402_STATUS_TARGET, PMC_STATUS_REFERENCING, 2);
    (void)drive_until(&d, PMC_STATUS_REFERENCING, 0, 20000);
    (void)drive_until(&d, ECT_402_STATUS_TARGET | PMC_STATUS_REFERENCE_ERROR, ECT_402_STATUS_TARGET, 1000);
    drive_cycles(&d, 500);
    double at = drive_instance(&d)->plant.machine.position;
    if (at < runs[i].found - 2 || at > runs[i].found + 2)
        fail_msg("method %d from %.0f: expected the shaft at %.0f, got %.0f", runs[i].method, runs[i].from,
                 runs[i].found, at);
    if (abs(drive_position(&d) - 5000) > 2)
        fail_msg("method %d: expected position 5000 there, got %d", runs[i].method, drive_position(&d));
    drive_set(&d, 5000);
    drive_control(&d, 0x0F);
    drive_cycles(&d, 100);
    assert_in_range(drive_position(&d), 4998, 5002);
    drive_expect(&d, ECT_402_OPERATION_ENABLED, "after the run");
    drive_close(&d);
}

static void methods(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(runs); i++)
        one_run(i, true);
}

static void mode_6(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(runs); i += 5)
        one_run(i, false);
}

/* Without a switch the limit switch ends the run: bit 13, and no reference. */
static void no_switch(void **state)
{
    (void)state;
    drive_open(&d);
    build_machine();
    signal_set(&d.w, "home_width", "0");
    assert_int_equal(drive_write(&d, 0x6098, 0, 19, 1), 0);
    drive_operational(&d, 0x1701, 0x1B25);
    drive_enable(&d);
    drive_control(&d, 0x80F);
    (void)drive_until(&d, PMC_STATUS_REFERENCE_ERROR | PMC_STATUS_REFERENCING, PMC_STATUS_REFERENCE_ERROR, 10000);
    drive_cycles(&d, 300);
    assert_true(fabs(drive_instance(&d)->plant.machine.speed) < 1000);
    assert_int_equal(signal_number(&d.w, "homed"), 0);
    drive_expect(&d, ECT_402_OPERATION_ENABLED, "no switch");
    drive_close(&d);
}

/* A falling start bit ends the run with bit 13; the next edge starts another one. */
static void aborted(void **state)
{
    (void)state;
    drive_open(&d);
    build_machine();
    assert_int_equal(drive_write(&d, 0x6098, 0, 19, 1), 0);
    assert_int_equal(drive_write(&d, 0x6060, 0, PMC_MODE_HOMING, 1), 0);
    drive_operational(&d, 0x1701, 0x1B25);
    drive_enable(&d);
    drive_control(&d, 0x1F);
    drive_cycles(&d, 200);
    drive_control(&d, 0x0F);
    (void)drive_until(&d, PMC_STATUS_REFERENCE_ERROR | PMC_STATUS_REFERENCING, PMC_STATUS_REFERENCE_ERROR, 2);
    drive_cycles(&d, 300);
    assert_true(fabs(drive_instance(&d)->plant.machine.speed) < 1000);
    drive_control(&d, 0x1F);
    (void)drive_until(&d, PMC_STATUS_REFERENCING, PMC_STATUS_REFERENCING, 2);
    (void)drive_until(&d, PMC_STATUS_REFERENCING | PMC_STATUS_REFERENCE_ERROR, 0, 10000);
    assert_int_equal(signal_number(&d.w, "homed"), 1);
    drive_close(&d);
}

/* 6098h changes during a part of method 17, or during its return: the run ends as method 17. */
static void write_on_leg(unsigned int leg, int8_t other)
{
    drive_open(&d);
    build_machine();
    assert_int_equal(drive_write(&d, 0x6098, 0, 17, 1), 0);
    drive_operational(&d, 0x1701, 0x1B25);
    drive_enable(&d);
    drive_control(&d, 0x0F | PMC_REFERENCE);
    drive_cycles(&d, 100);
    while (drive_instance(&d)->axis.homing.leg < leg)
        drive_cycles(&d, 1);
    assert_int_not_equal(drive_status(&d) & PMC_STATUS_REFERENCING, 0);
    assert_int_equal(drive_write(&d, 0x6098, 0, (uint8_t)other, 1), 0);
    (void)drive_until(&d, PMC_STATUS_REFERENCING, 0, 20000);
    drive_cycles(&d, 500);
    double at = drive_instance(&d)->plant.machine.position;
    if (signal_number(&d.w, "homed") != 1 || at < NEGATIVE - 2 || at > NEGATIVE + 2)
        fail_msg("6098h=%d on leg %u of method 17: expected the shaft at %d, got %.0f", other, leg, NEGATIVE, at);
    drive_close(&d);
}

static void written_under_way(void **state)
{
    static const int8_t others[] = {1, 18, 33, 35};
    (void)state;
    for (unsigned int leg = 0; leg < 3; leg++) {
        for (size_t i = 0; i < COUNT(others); i++)
            write_on_leg(leg, others[i]);
    }
}

/* The bit is on before the drive is enabled: no edge, no run. */
static void no_edge(void **state)
{
    (void)state;
    drive_open(&d);
    drive_operational(&d, 0x1701, 0x1B25);
    drive_control(&d, 0x806);
    drive_cycles(&d, 2);
    drive_control(&d, 0x807);
    drive_cycles(&d, 2);
    drive_control(&d, 0x80F);
    drive_cycles(&d, 100);
    drive_expect(&d, ECT_402_OPERATION_ENABLED, "enabled");
    assert_int_equal(signal_number(&d.w, "homed"), 0);
    assert_int_equal(drive_status(&d) & PMC_STATUS_REFERENCING, 0);
    drive_close(&d);
}

/* --- SAVE --------------------------------------------------------------------------------------------------------- */

static void save(void **state)
{
    sensor_memory_t memory;
    (void)state;
    sensor_memory_open(&memory);
    drive_open_with(&d, &memory.storage);
    assert_int_equal(drive_write(&d, 0x6098, 0, 21, 1), 0);
    drive_operational(&d, 0x1701, 0x1B01);
    drive_control(&d, PMC_SAVE);
    drive_cycles(&d, 3); /* one edge, one SAVE */
    assert_int_equal(signal_number(&d.w, "saves"), 1);
    assert_int_equal(drive_write(&d, 0x6098, 0, 22, 1), 0);
    signal_set(&d.w, "restart", "1");
    wire_advance(&d.w, 10 * MS);
    wire_assign_stations(&d.w);
    wire_go(&d.w, 0, ECT_STATE_PREOP);
    assert_int_equal(drive_read(&d, 0x6098, 0), 21);
    assert_int_equal(drive_write(&d, 0x1011, 1, 0x64616F6C, 4), 0);
    signal_set(&d.w, "restart", "1");
    wire_advance(&d.w, 10 * MS);
    wire_assign_stations(&d.w);
    wire_go(&d.w, 0, ECT_STATE_PREOP);
    assert_int_equal(drive_read(&d, 0x6098, 0), 35);
    drive_close(&d);
    sensor_memory_close(&memory);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-023 PLZ-024: mode 8, bit 11: each method ends exactly at its point", methods, NULL, NULL, NULL},
        {"PLZ-024: mode 6, bit 4: the same", mode_6, NULL, NULL, NULL},
        {"PLZ-024: bit 13: a switch that is not found", no_switch, NULL, NULL, NULL},
        {"PLZ-023 PLZ-024: a falling start bit ends the run, its next edge starts another one", aborted, NULL, NULL,
         NULL},
        {"PLZ-024: 6098h written during a run applies from the next one on", written_under_way, NULL, NULL, NULL},
        {"PLZ-023: the start bit without an edge in Operation Enabled starts nothing", no_edge, NULL, NULL, NULL},
        {"PLZ-023: bit 12 saves the parameters, once for each edge; they exist after a power cycle", save, NULL, NULL,
         NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo reference runs", tests, NULL, NULL);
}
