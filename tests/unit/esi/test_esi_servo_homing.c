/* SPDX-License-Identifier: MIT */
/* S-0-0148 of SoE drives of tests/esi/soe.xml: the run that S-0-0147 selects, its end, its failures. A turn has 10 000
 * increments. */
#include "servo_of_file.h"

enum { GO = 0x2000, ALLOW = 0x4000, ON = 0x8000, RUN = ON | ALLOW | GO, IS_ENABLED = 3, CLASS_1 = 0x2000 };
enum { SPEED_IDN = 41, ACCELERATION_IDN = 42, POSITION_COMMAND = 47, DISTANCE = 52, PARAMETER = 147, HOMING = 148 };
enum { SWITCH_IDN = 400, HOMED_IDN = 403, STATE_ELEMENT = ECT_SOE_ELEMENT_STATE };
enum { CAM = 20000, CAM_END = 23000, INDEX = 1234, REFERENCE = 700 };
enum { DOWN = 1, FALLING = 2, AT_DRIVE = 4, NO_SWITCH = 0x20, NO_MARKER = 0x40 };

static int32_t actual(unsigned int drive)
{
    return (int32_t)ect_load_le32(in + 10 * drive + 2);
}

static void control(unsigned int drive, uint16_t value)
{
    ect_store_le16(out + 6 * drive, value);
}

static void command_value(unsigned int drive, int32_t value)
{
    ect_store_le32(out + 6 * drive + 2, (uint32_t)value);
}

static int write_word(unsigned int drive, uint16_t idn, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    return write_value(drive, idn, bytes, sizeof bytes);
}

static void write_number(unsigned int drive, uint16_t idn, int32_t value)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, (uint32_t)value);
    assert_int_equal(write_value(drive, idn, bytes, sizeof bytes), 0);
}

static uint32_t homing_state(unsigned int drive)
{
    return number_of(drive, HOMING, STATE_ELEMENT);
}

/* Machine positions are those of the axis, which starts at 0. */
static void machine(unsigned int drive, int64_t start)
{
    static const struct {
        const char *name;
        int64_t at;
    } places[] = {{"home_at", CAM}, {"stop_positive", 40000}, {"stop_negative", -40000}, {"index_at", INDEX}};
    char name[40];
    (void)snprintf(name, sizeof name, "axis%u.resolution", drive + 1);
    signals(name, 10000);
    for (size_t i = 0; i < COUNT(places); i++) {
        (void)snprintf(name, sizeof name, "axis%u.%s", drive + 1, places[i].name);
        signals(name, places[i].at - start);
    }
    (void)snprintf(name, sizeof name, "axis%u.home_width", drive + 1);
    signals(name, CAM_END - CAM);
}

static void prepare(unsigned int drive, uint16_t parameter, int64_t start)
{
    machine(drive, start);
    write_number(drive, SPEED_IDN, 20000);
    write_number(drive, ACCELERATION_IDN, 500000);
    write_number(drive, DISTANCE, REFERENCE);
    assert_int_equal(write_word(drive, PARAMETER, parameter), 0);
}

static void power_on(unsigned int drive)
{
    control(drive, RUN);
    for (unsigned int n = 0; n < 2000 && ect_load_le16(in + 10 * drive) >> 14 != IS_ENABLED; n++)
        cycles(1);
    assert_int_equal(ect_load_le16(in + 10 * drive) >> 14, IS_ENABLED);
}

static void open_enabled(uint16_t parameter, int64_t start)
{
    open_servo("TWO", ECT_BEHAVIOUR_BY_FILE);
    prepare(0, parameter, start);
    operational();
    power_on(0);
}

static void run_out(unsigned int drive, uint32_t expected)
{
    unsigned int ms = 0;
    while (homing_state(drive) == ECT_SOE_COMMAND_RUNS && ms++ < 20000)
        cycles(1);
    if (homing_state(drive) != expected)
        fail_msg("drive %u: expected that S-0-0148 ends in %X, it is %X", drive, expected, homing_state(drive));
}

/* --- runs --------------------------------------------------------------------------------------------------------- */

static void each_setting(void **state)
{
    static const struct {
        uint16_t parameter;
        int64_t home, starts[3];
    } rows[] = {
        {AT_DRIVE | NO_MARKER, CAM, {0, 21500, 30000}},
        {AT_DRIVE | NO_MARKER | FALLING, CAM_END, {0, 21500, 30000}},
        {AT_DRIVE | NO_MARKER | DOWN, CAM_END, {0, 21500, 30000}},
        {AT_DRIVE | NO_MARKER | DOWN | FALLING, CAM, {0, 21500, 30000}},
        {AT_DRIVE, 21234, {0, 21500, 30000}},
        {AT_DRIVE | FALLING, 31234, {0, 21500, 30000}},
        {AT_DRIVE | DOWN, 21234, {0, 21500, 30000}},
        {AT_DRIVE | DOWN | FALLING, 11234, {0, 21500, 30000}},
        {NO_SWITCH, 11234, {1300, 5000, 11000}},
        {NO_SWITCH | DOWN, 1234, {1300, 5000, 11000}},
        {NO_SWITCH | NO_MARKER, 5000, {5000, 5000, 5000}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (size_t k = 0; k < COUNT(rows[i].starts); k++) {
            char what[60];
            const int64_t start = rows[i].starts[k];
            (void)snprintf(what, sizeof what, "S-0-0147 = %04X from %lld", rows[i].parameter, (long long)start);
            open_enabled(rows[i].parameter, start);
            assert_int_equal(number_of(0, HOMED_IDN, VALUE), 0);
            assert_int_equal(number_of(0, SWITCH_IDN, VALUE), start >= CAM && start < CAM_END);
            assert_int_equal(write_word(0, HOMING, 3), 0);
            assert_int_equal(homing_state(0), ECT_SOE_COMMAND_RUNS);
            run_out(0, ECT_SOE_COMMAND_DONE);
            cycles(200);
            expect_near(what, (double)(rows[i].home - start), 2, signal_of("axis1.machine_position"));
            expect_near(what, REFERENCE, 2, actual(0));
            assert_int_equal(number_of(0, HOMED_IDN, VALUE), 3);
            assert_int_equal((int)signal_of("axis1.homed"), 1);
            close_drive(state);
        }
    }
}

/* The set value counts again after the command is cleared, and the drive homes again. */
static void until_cleared(void **state)
{
    (void)state;
    open_enabled(AT_DRIVE | NO_MARKER, 0);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    run_out(0, ECT_SOE_COMMAND_DONE);
    command_value(0, REFERENCE + 2000);
    cycles(500);
    expect_near("holds its place", REFERENCE, 2, actual(0));
    command_value(0, REFERENCE);
    cycles(2);
    assert_int_equal(write_word(0, HOMING, 0), 0);
    assert_int_equal(homing_state(0), ECT_SOE_COMMAND_CLEARED);
    for (int32_t n = 0; n <= 200; n++) {
        command_value(0, REFERENCE + 10 * n);
        cycles(1);
    }
    cycles(200);
    expect_near("follows", REFERENCE + 2000, 20, actual(0));
    assert_int_equal(number_of(0, HOMED_IDN, VALUE), 3);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    cycles(20);
    assert_int_equal(number_of(0, HOMED_IDN, VALUE), 0);
    run_out(0, ECT_SOE_COMMAND_DONE);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    run_out(0, ECT_SOE_COMMAND_DONE);
    expect_near("the same point", CAM, 2, signal_of("axis1.machine_position"));
}

static void apart(void **state)
{
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_BY_FILE);
    prepare(0, AT_DRIVE | NO_MARKER, 0);
    prepare(1, NO_SWITCH | NO_MARKER, 0);
    operational();
    power_on(0);
    power_on(1);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    assert_int_equal(write_word(1, HOMING, 3), 0);
    cycles(100);
    assert_int_equal(homing_state(0), ECT_SOE_COMMAND_RUNS);
    assert_int_equal(homing_state(1), ECT_SOE_COMMAND_DONE);
    expect_near("drive 2", REFERENCE, 1, actual(1));
    run_out(0, ECT_SOE_COMMAND_DONE);
    cycles(1);
    expect_near("drive 1", REFERENCE, 2, actual(0));
}

/* S-0-0041 and S-0-0042 of each drive: 2 turns a second within 1 s, 1 turn a second at once. */
static void speed_and_acceleration(void **state)
{
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_BY_FILE);
    prepare(0, AT_DRIVE, 0);
    prepare(1, AT_DRIVE, 0);
    write_number(0, ACCELERATION_IDN, 20000);
    write_number(1, SPEED_IDN, 10000);
    operational();
    power_on(0);
    power_on(1);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    assert_int_equal(write_word(1, HOMING, 3), 0);
    cycles(500);
    expect_near("drive 1 after 0.5 s", 60, 3, signal_of("axis1.speed"));
    expect_near("drive 2 after 0.5 s", 60, 3, signal_of("axis2.speed"));
    cycles(700);
    expect_near("drive 1 after 1.2 s", 120, 3, signal_of("axis1.speed"));
    expect_near("drive 2 after 1.2 s", 60, 3, signal_of("axis2.speed"));
}

/* --- failures ----------------------------------------------------------------------------------------------------- */

static void not_now(void **state)
{
    (void)state;
    open_servo("TWO", ECT_BEHAVIOUR_BY_FILE);
    prepare(0, AT_DRIVE, 0);
    assert_int_equal(write_word(0, HOMING, 3), -1 - ECT_SOE_COMMAND_NOT_NOW);
    operational();
    assert_int_equal(write_word(0, HOMING, 3), -1 - ECT_SOE_COMMAND_NOT_NOW);
    power_on(0);
    control(0, ON | ALLOW);
    cycles(2);
    assert_int_equal(write_word(0, HOMING, 3), -1 - ECT_SOE_COMMAND_NOT_NOW);
    assert_int_equal(homing_state(0), ECT_SOE_COMMAND_CLEARED);
    control(0, RUN);
    cycles(2);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    assert_int_equal(write_word(0, HOMING, 3), -1 - ECT_SOE_COMMAND_ACTIVE);
}

static void switch_elsewhere(void **state)
{
    (void)state;
    open_enabled(NO_MARKER, 0);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    assert_int_equal(homing_state(0), ECT_SOE_COMMAND_ERROR);
    for (int32_t n = 0; n <= 200; n++) {
        command_value(0, 10 * n);
        cycles(1);
    }
    cycles(200);
    expect_near("follows its set value", 2000, 20, actual(0));
}

static void ends_without_success(void **state)
{
    static const struct {
        const char *what, *signal, *value;
        uint16_t word;
    } rows[] = {
        {"bit 13 is 0", NULL, NULL, ON | ALLOW},
        {"bit 14 is 0", NULL, NULL, ON | GO},
        {"bit 15 is 0", NULL, NULL, ALLOW | GO},
        {"a fault", "axis1.fault", "0x2311", RUN},
        {"both limit switches are hit", "axis1.positive_free", "0", RUN},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        open_enabled(AT_DRIVE, 0);
        assert_int_equal(write_word(0, HOMING, 3), 0);
        cycles(100);
        assert_int_equal(homing_state(0), ECT_SOE_COMMAND_RUNS);
        if (rows[i].signal != NULL)
            set(rows[i].signal, rows[i].value);
        if (rows[i].signal != NULL && strcmp(rows[i].signal, "axis1.positive_free") == 0)
            set("axis1.negative_free", rows[i].value);
        control(0, rows[i].word);
        cycles(3);
        if (homing_state(0) != ECT_SOE_COMMAND_ERROR)
            fail_msg("%s: expected that S-0-0148 ends in an error, it is %X", rows[i].what, homing_state(0));
        cycles(2000);
        assert_int_equal((int)signal_of("axis1.homed"), 0);
        expect_near(rows[i].what, 0, 1, signal_of("axis1.speed"));
        close_drive(state);
    }
}

static void leaves_op(void **state)
{
    (void)state;
    open_enabled(AT_DRIVE, 0);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    cycles(100);
    wire_go(&wire, 0, SAFEOP);
    wire_advance(&wire, 2000 * MS);
    assert_int_equal(homing_state(0), ECT_SOE_COMMAND_ERROR);
    assert_int_equal(number_of(0, 135, VALUE) & CLASS_1, CLASS_1);
    assert_int_equal(number_of(0, SPEED_IDN, VALUE), 20000);
}

static void cancelled(void **state)
{
    (void)state;
    open_enabled(AT_DRIVE, 0);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    cycles(100);
    command_value(0, actual(0));
    assert_int_equal(write_word(0, HOMING, 0), 0);
    assert_int_equal(homing_state(0), ECT_SOE_COMMAND_CLEARED);
    cycles(1000);
    assert_int_equal((int)signal_of("axis1.mode"), CSP);
    expect_near("stands", 0, 1, signal_of("axis1.speed"));
    assert_int_equal(number_of(0, HOMED_IDN, VALUE), 0);
    command_value(0, actual(0));
    assert_int_equal(write_word(0, HOMING, 3), 0);
    cycles(1);
    assert_int_equal(write_word(0, HOMING, 0), 0);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    run_out(0, ECT_SOE_COMMAND_DONE);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"SOE-030: S-0-0148 finds the point of each S-0-0147; S-0-0052 is the position there, S-0-0400 the switch, "
         "S-0-0403 the result",
         each_setting, NULL, close_drive, NULL},
        {"S-0-0148: the set value counts again after the command is cleared", until_cleared, NULL, close_drive, NULL},
        {"S-0-0148: two drives home, each by its own settings", apart, NULL, close_drive, NULL},
        {"S-0-0148: speed and acceleration are S-0-0041 and S-0-0042", speed_and_acceleration, NULL, close_drive, NULL},
        {"SOE-031: S-0-0148 of a drive that is not enabled or halts is refused", not_now, NULL, close_drive, NULL},
        {"S-0-0148 ends in an error when the control unit has the home switch", switch_elsewhere, NULL, close_drive,
         NULL},
        {"S-0-0148 ends in an error with the enable, by a halt, a fault, a limit switch", ends_without_success, NULL,
         close_drive, NULL},
        {"S-0-0148 ends in an error with OP; the settings stay", leaves_op, NULL, close_drive, NULL},
        {"SOE-030: a cancelled run, and the next one", cancelled, NULL, close_drive, NULL},
    };
    return cmocka_run_group_tests_name("homing of SoE drives", tests, NULL, NULL);
}
