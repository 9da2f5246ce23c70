/* SPDX-License-Identifier: MIT */
/* The words S-0-0134 and S-0-0135 of SoE drives: the way to enabled and back, set values, halt, faults, AL states. */
#include "servo_of_file.h"

enum { GO = 0x2000, ALLOW = 0x4000, ON = 0x8000, RUN = ON | ALLOW | GO, CLASS_1 = 0x2000, FOLLOWS = 0x0008 };
enum { NOT_READY, READY_FOR_POWER, TO_ENABLE, IS_ENABLED };
enum { TURN_COUNTS = 1048576, RESET_IDN = 99, CLASS_1_IDN = 11, MODE_IDN = 32 };
static const double TURN = TURN_COUNTS;

static uint16_t word(unsigned int drive)
{
    return ect_load_le16(in + 10 * drive);
}

static unsigned int power(unsigned int drive)
{
    return word(drive) >> 14;
}

static void control(unsigned int drive, uint16_t value)
{
    ect_store_le16(out + 6 * drive, value);
}

static void command_value(unsigned int drive, int32_t value)
{
    ect_store_le32(out + 6 * drive + 2, (uint32_t)value);
}

static int32_t actual(unsigned int drive)
{
    return (int32_t)ect_load_le32(in + 10 * drive + 2);
}

static void reach(unsigned int drive, unsigned int expected)
{
    for (unsigned int n = 0; n < 2000 && power(drive) != expected; n++)
        cycles(1);
    if (power(drive) != expected)
        fail_msg("drive %u: expected bits 15 and 14 to be %u, the word is %04X", drive + 1, expected, word(drive));
}

static void open_in_op(const char *type)
{
    open_servo(type, ECT_BEHAVIOUR_BY_FILE);
    operational();
}

/* --- speed -------------------------------------------------------------------------------------------------------- */

static void speed(void **state)
{
    (void)state;
    open_in_op("SPEED");
    assert_int_equal(power(0), TO_ENABLE);
    control(0, RUN);
    reach(0, IS_ENABLED);
    command_value(0, 5 * TURN_COUNTS);
    cycles(2000);
    expect_near("S-0-0040", 5.0 * TURN, 0.01 * TURN, (double)actual(0));
    expect_near("turns a minute", 300, 1, signal_of("axis1.speed"));
    assert_true(signal_of("axis1.turns") > 5);
    control(0, 0);
    reach(0, TO_ENABLE);
    assert_int_equal((int)signal_of("axis1.powered"), 0);
}

static void halt_and_off(void **state)
{
    (void)state;
    open_in_op("SPEED");
    control(0, RUN);
    reach(0, IS_ENABLED);
    command_value(0, 5 * TURN_COUNTS);
    cycles(1000);
    control(0, ON | ALLOW);
    cycles(3000);
    assert_int_equal(power(0), IS_ENABLED);
    expect_near("halt", 0, 0.001 * TURN, (double)actual(0));
    control(0, RUN);
    cycles(1000);
    expect_near("goes on", 5.0 * TURN, 0.01 * TURN, (double)actual(0));
    control(0, ALLOW | GO);
    cycles(3);
    assert_int_equal((int)signal_of("axis1.powered"), 1);
    reach(0, TO_ENABLE);
    expect_near("bit 15 stops it", 0, 0.01 * TURN, (double)actual(0));
}

/* --- position ----------------------------------------------------------------------------------------------------- */

static void position(void **state)
{
    (void)state;
    open_in_op("TWO");
    for (unsigned int drive = 0; drive < 2; drive++) {
        command_value(drive, actual(drive));
        control(drive, RUN);
    }
    reach(0, IS_ENABLED);
    reach(1, IS_ENABLED);
    for (int32_t n = 1; n <= 1000; n++) {
        command_value(0, n * (TURN_COUNTS / 1000));
        command_value(1, -n * (TURN_COUNTS / 500));
        cycles(1);
    }
    assert_int_equal(word(0) & FOLLOWS, FOLLOWS);
    cycles(500);
    expect_near("drive 1", TURN_COUNTS, 0.001 * TURN, actual(0));
    expect_near("drive 2", -2.0 * TURN, 0.002 * TURN, actual(1));
    expect_near("turns of drive 2", -2, 0.01, signal_of("axis2.turns"));
}

/* The mode of S-0-0032 counts: torque and an unknown one have no set value in the telegram. */
static void primary_mode(void **state)
{
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_BY_FILE);
    assert_int_equal(number_of(0, MODE_IDN, VALUE), 11);
    operational();
    control(0, RUN);
    cycles(2);
    assert_int_equal((int)signal_of("axis1.mode"), CSP);
    control(0, RUN | 0x0100);
    cycles(2);
    assert_int_equal(word(0) >> 8 & 7, 1);
}

/* --- faults ------------------------------------------------------------------------------------------------------- */

static void fault(void **state)
{
    static const uint8_t start[] = {3, 0};
    static const uint8_t clear[] = {0, 0};
    (void)state;
    open_in_op("SPEED");
    control(0, RUN);
    reach(0, IS_ENABLED);
    set("axis1.fault", "0x2311");
    cycles(2);
    assert_int_equal(word(0) & CLASS_1, CLASS_1);
    reach(0, NOT_READY);
    assert_int_equal(number_of(0, CLASS_1_IDN, VALUE), 1u << 7);
    control(0, 0);
    assert_int_equal(write_value(0, RESET_IDN, start, sizeof start), 0);
    assert_int_equal(number_of(0, RESET_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_RUNS);
    cycles(3);
    assert_int_equal(number_of(0, RESET_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_DONE);
    assert_int_equal(word(0) & CLASS_1, 0);
    assert_int_equal(number_of(0, CLASS_1_IDN, VALUE), 0);
    assert_int_equal(write_value(0, RESET_IDN, clear, sizeof clear), 0);
    control(0, RUN);
    reach(0, IS_ENABLED);
}

/* Codes of CiA 402: over-temperature 4xxxh, voltages 3xxxh, currents 2xxxh, feedback 7300h, communication 7500h, 8100h.
 */
static void class_1_of_codes(void **state)
{
    static const struct {
        const char *code;
        unsigned int bit;
    } rows[] = {
        {"0x1FFF", 15}, {"0x2000", 7},  {"0x2FFF", 7},  {"0x3000", 15}, {"0x31FF", 15}, {"0x3200", 8},  {"0x3210", 8},
        {"0x3220", 9},  {"0x3221", 8},  {"0x32FF", 8},  {"0x3300", 15}, {"0x42FF", 15}, {"0x4300", 1},  {"0x4310", 1},
        {"0x43FF", 1},  {"0x4400", 15}, {"0x7200", 15}, {"0x7300", 5},  {"0x73FF", 5},  {"0x7400", 15}, {"0x7500", 12},
        {"0x75FF", 12}, {"0x7600", 15}, {"0x8000", 15}, {"0x8100", 12}, {"0x81FF", 12}, {"0x8200", 15}, {"0x8610", 15},
        {"0x8611", 11}, {"0x8612", 15}, {"0xFFFF", 15},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        open_in_op("SPEED");
        set("axis1.fault", rows[i].code);
        cycles(2);
        const uint32_t class_1 = number_of(0, CLASS_1_IDN, VALUE);
        if (class_1 != 1u << rows[i].bit)
            fail_msg("%s: expected bit %u, got 0x%04X", rows[i].code, rows[i].bit, (unsigned int)class_1);
        if (i + 1 < sizeof rows / sizeof rows[0])
            (void)close_drive(NULL);
    }
}

static void cause_remains(void **state)
{
    static const uint8_t start[] = {3, 0};
    (void)state;
    open_in_op("SPEED");
    control(0, RUN);
    reach(0, IS_ENABLED);
    set("axis1.sto", "1");
    reach(0, NOT_READY);
    control(0, 0);
    assert_int_equal(write_value(0, RESET_IDN, start, sizeof start), 0);
    cycles(3);
    assert_int_equal(number_of(0, RESET_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_ERROR);
    assert_int_equal(word(0) & CLASS_1, CLASS_1);
}

static void below_op(void **state)
{
    static const uint8_t start[] = {3, 0};
    (void)state;
    open_in_op("SPEED");
    control(0, RUN);
    reach(0, IS_ENABLED);
    command_value(0, TURN_COUNTS);
    cycles(500);
    wire_go(&wire, 0, SAFEOP);
    wire_advance(&wire, MS);
    assert_int_equal(number_of(0, 134, VALUE), 0);
    assert_int_equal(number_of(0, 135, VALUE) & CLASS_1, CLASS_1);
    wire_advance(&wire, 2000 * MS);
    assert_int_equal((int)signal_of("axis1.powered"), 0);
    assert_int_equal(write_value(0, RESET_IDN, start, sizeof start), 0);
    assert_int_equal(number_of(0, RESET_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_DONE);
    assert_int_equal(number_of(0, 135, VALUE) & CLASS_1, 0);
}

static void supply(void **state)
{
    (void)state;
    open_in_op("SPEED");
    set("axis1.power", "0");
    cycles(2);
    assert_int_equal(power(0), READY_FOR_POWER);
    control(0, RUN);
    cycles(20);
    assert_int_not_equal(power(0), IS_ENABLED);
    set("axis1.power", "1");
    reach(0, IS_ENABLED);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"SOE-043: S-0-0036 turns an enabled drive, S-0-0040 follows; bit 14 takes the torque", speed, NULL,
         close_drive, NULL},
        {"S-0-0134: bit 13 halts, bit 15 stops on a ramp", halt_and_off, NULL, close_drive, NULL},
        {"S-0-0047 moves two drives, S-0-0051 and bit 3 of S-0-0135 follow", position, NULL, close_drive, NULL},
        {"SOE-043: the operation mode is that of S-0-0032, or of the selected number", primary_mode, NULL, close_drive,
         NULL},
        {"SOE-041: S-0-0099 resets a fault, S-0-0011 and bit 13 have it", fault, NULL, close_drive, NULL},
        {"SOE-041: S-0-0011 has a bit for the cause of each error code, else bit 15", class_1_of_codes, NULL,
         close_drive, NULL},
        {"SOE-041: S-0-0099 ends in an error while the cause remains", cause_remains, NULL, close_drive, NULL},
        {"S-0-0134 is 0 when OP ends; a moving drive gets a fault, which S-0-0099 resets in SAFEOP", below_op, NULL,
         close_drive, NULL},
        {"S-0-0135: without supply a drive is ready for power, and not enabled", supply, NULL, close_drive, NULL},
    };
    return cmocka_run_group_tests_name("words of SoE drives", tests, NULL, NULL);
}
