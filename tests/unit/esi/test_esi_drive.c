/* SPDX-License-Identifier: MIT */
/* Drives of ESI files: any shape of dictionary and PDO enables, moves, faults and finds its reference. */
#include "drive_of_file.h"

/* --- what there is ------------------------------------------------------------------------------------------------ */

static void modes_are_noted(void **state)
{
    static const struct {
        const char *type, *note;
    } rows[] = {
        {"SERVO", "CiA 402: axis 1 pp pv tq hm ip csp csv cst; without behaviour: 60D9"},
        {"SMALL", "CiA 402: axis 1 hm csp"},
        {"BARE", "CiA 402: axis 1 csp"},
        {"SPEED", "CiA 402: axis 1 csv"},
        {"DUAL", "CiA 402: axis 1 hm csp; axis 2 hm csp; without behaviour: 60D9 68D9"},
        {"SCREW", "CiA 402: axis 1 pp csp"},
        {"CYCLIC", "CiA 402: axis 1 tq ip csv cst"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        twin = make(rows[i].type, ECT_BEHAVIOUR_BY_FILE);
        assert_string_equal(note(), rows[i].note);
        ect_esi_twin_free(twin);
        twin = NULL;
    }
}

static void a_shell_stays(void **state)
{
    (void)state;
    twin = make("SERVO", ECT_BEHAVIOUR_NONE);
    assert_string_equal(note(), "");
    assert_null(device()->outputs);
}

static void no_drive(void **state)
{
    char text[300] = "";
    (void)state;
    twin = ect_esi_twin_make(ESI_FILES "/digital.xml", "DO16", NULL, 0, text, sizeof text);
    assert_non_null(twin);
    assert_false(ect_esi_twin_behave(twin, ECT_BEHAVIOUR_CIA402, text, sizeof text));
    assert_string_equal(text, "DO16 has no control word 6040h and status word 6041h: it cannot be a CiA 402 drive");
    ect_esi_twin_free(twin);
    twin = NULL;
}

/* --- motion in every shape ---------------------------------------------------------------------------------------- */

static void moves_position(void **state)
{
    static const struct {
        const char *type;
        unsigned int axes;
        double amplitude; /* position units */
    } rows[] = {{"SERVO", 1, 1048576}, {"SMALL", 1, 1048576}, {"BARE", 1, 1048576},
                {"DUAL", 2, 1048576},  {"WIDE", 1, 1048576},  {"SCREW", 1, 5000}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        open_drive(rows[i].type);
        for (unsigned int a = 0; a < rows[i].axes; a++)
            choose_mode(a, CSP);
        operational();
        for (unsigned int a = 0; a < rows[i].axes; a++)
            enable(a);
        double before = 0;
        for (unsigned int ms = 1; ms <= 1000; ms++) {
            double now = rows[i].amplitude * (1 - cos(ms * TWO_PI / 1000));
            for (unsigned int a = 0; a < rows[i].axes; a++)
                put((uint16_t)(TARGET + 0x800 * a), llround(a == 0 ? now : -now / 2));
            cycles(1);
            for (unsigned int a = 0; a < rows[i].axes; a++) {
                double want = a == 0 ? before : -before / 2;
                double way = fabs(now - before) + rows[i].amplitude * 0.005;
                double got = (double)get((uint16_t)(ACTUAL + 0x800 * a));
                if (fabs(got - want) > way)
                    fail_msg("%s axis %u at %u ms: expected %.0f +- %.0f, got %.0f", rows[i].type, a + 1, ms, want, way,
                             got);
                assert_int_equal(state_of(get((uint16_t)(STATUS + 0x800 * a))), ENABLED);
            }
            before = now;
        }
        close_drive(state);
    }
}

static void moves_speed(void **state)
{
    (void)state;
    open_drive("SPEED");
    operational();
    enable(0);
    put(0x60FF, 2097152);
    cycles(500);
    assert_true(llabs(get(0x606C) - 2097152) < 2000);
    assert_true(fabs(signal_of("axis1.speed") - 120) < 1);
    assert_true(signal_of("axis1.turns") > 0.9);
}

static void axes_are_apart(void **state)
{
    (void)state;
    open_drive("DUAL");
    choose_mode(0, CSP);
    choose_mode(1, CSP);
    operational();
    enable(1);
    assert_int_equal(state_of(get(STATUS)), SOD);
    put(TARGET + 0x800, 1000);
    cycles(300);
    assert_true(llabs(get(ACTUAL + 0x800) - 1000) <= 2);
    assert_int_equal(get(ACTUAL), 0);
    set("axis2.fault", "9088"); /* 2380h */
    cycles(1);
    until(1, FAULT);
    enable(0);
    assert_int_equal(state_of(get(STATUS + 0x800)), FAULT);
}

/* --- state machine, faults ---------------------------------------------------------------------------------------- */

static void servo_in(int8_t mode)
{
    open_drive("SERVO");
    put(MODE, mode);
    operational();
}

static void refused_commands(void **state)
{
    static const uint16_t words[] = {0x07, 0x0F, 0x02, 0x00, 0x80, 0x8F};
    (void)state;
    servo_in(CSP);
    for (size_t i = 0; i < COUNT(words); i++)
        command(0, words[i], SOD);
}

static void straight_to_enabled(void **state)
{
    (void)state;
    servo_in(CSP);
    assert_true((get(STATUS) & 0x0210) == 0x0210);
    command(0, SHUTDOWN, READY);
    command(0, ENABLE, ENABLED);
    command(0, 0x00, SOD);
}

static void ways_down(void **state)
{
    static const struct {
        uint16_t word;
        unsigned int state;
    } rows[] = {{SHUTDOWN, READY}, {SWITCH_ON, SWITCHED_ON}, {0x00, SOD}, {0x02, SOD}};
    (void)state;
    servo_in(CSP);
    for (size_t i = 0; i < COUNT(rows); i++) {
        command(0, 0x00, SOD);
        enable(0);
        command(0, rows[i].word, rows[i].state);
    }
}

static void mode_before_enabling(void **state)
{
    (void)state;
    servo_in(HM);
    assert_int_equal(get(SHOWN), HM);
    put(MODE, CSV);
    cycles(1);
    assert_int_equal(get(SHOWN), CSV);
    put(MODE, 0);
    cycles(1);
    assert_int_equal(get(SHOWN), CSV);
    put(MODE, 2);
    cycles(1);
    assert_int_equal(get(SHOWN), CSV);
    assert_int_equal(write_sdo(MODE, 0, 2, 1), 0x06090030);
}

static void fault_and_reset(void **state)
{
    (void)state;
    servo_in(CSP);
    enable(0);
    set("axis1.fault", "16912"); /* 4210h */
    cycles(1);
    assert_int_equal(get(0x603F), 0x4210);
    until(0, FAULT);
    expect_emergency(0x4210, 0x09);
    assert_int_equal(read_sdo(0x1001, 0), 0x09);
    command(0, ENABLE, FAULT);
    command(0, ENABLE | RESET, SOD);
    assert_int_equal(get(0x603F), 0);
    expect_emergency(0, 0);
    assert_int_equal(read_sdo(0x1001, 0), 0);
    command(0, 0x00, SOD);
    enable(0);
}

static void cause_still_there(void **state)
{
    (void)state;
    servo_in(CSP);
    enable(0);
    set("axis1.sto", "1");
    cycles(2);
    until(0, FAULT);
    assert_int_equal(get(0x603F), 0x5441);
    command(0, 0x00, FAULT);
    command(0, RESET, FAULT);
    set("axis1.sto", "0");
    command(0, RESET, FAULT); /* no edge */
    command(0, 0x00, FAULT);
    command(0, RESET, SOD);
}

static void operation_lost(void **state)
{
    static const struct {
        const char *what;
        int64_t option;
        unsigned int state;
        int64_t code;
    } rows[] = {{"DRV-155 fault", 1, FAULT, 0x7500}, {"disable", 2, SOD, 0}, {"quick stop", 3, SOD, 0}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo_in(CSP);
        assert_int_equal(write_sdo(0x6007, 0, rows[i].option, 2), 0);
        enable(0);
        (void)wire_al(&wire, 0, SAFEOP, NULL);
        wire_advance(&wire, 500 * MS);
        if (rows[i].code != 0)
            expect_emergency((uint16_t)rows[i].code, 0x11);
        if (state_of(read_sdo(STATUS, 0)) != rows[i].state || read_sdo(0x603F, 0) != rows[i].code)
            fail_msg("%s: status word %04X, error %04X", rows[i].what, (unsigned int)read_sdo(STATUS, 0),
                     (unsigned int)read_sdo(0x603F, 0));
        close_drive(state);
    }
}

static void shaft_is_stuck(void **state)
{
    (void)state;
    servo_in(CSP);
    enable(0);
    set("axis1.jam", "1");
    for (int32_t ms = 1; ms <= 300; ms++) {
        put(TARGET, ms * 10000);
        cycles(1);
    }
    assert_int_equal(get(0x603F), 0x8611);
    assert_int_equal(state_of(get(STATUS)), FAULT);
    assert_int_equal(get(ACTUAL), 0);
}

/* --- settings ----------------------------------------------------------------------------------------------------- */

static void refused_settings(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        int64_t value;
        size_t size;
        uint32_t abort;
    } rows[] = {
        {0x605A, 0, 9, 2, 0x06090030},
        {0x605D, 0, 0, 2, 0x06090030},
        {0x605E, 0, 5, 2, 0x06090030},
        {0x6007, 0, 4, 2, 0x06090030},
        {0x6098, 0, 15, 1, 0x06090030},
        {0x6086, 0, 3, 2, 0x06090030},
        {0x607D, 2, -1, 4, 0x06090036},
        {0x605A, 0, 8, 2, 0},
        {0x6098, 0, 34, 1, 0},
        {0x607D, 2, 100000, 4, 0},
        {0x607D, 1, 100001, 4, 0x06090036},
    };
    (void)state;
    open_drive("SERVO");
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t abort = write_sdo(rows[i].index, rows[i].subindex, rows[i].value, rows[i].size);
        if (abort != rows[i].abort)
            fail_msg("%04X:%u = %lld: expected %08X, got %08X", rows[i].index, rows[i].subindex,
                     (long long)rows[i].value, (unsigned int)rows[i].abort, (unsigned int)abort);
    }
}

/* SMALL lists methods 35 and 37. */
static void listed_methods(void **state)
{
    (void)state;
    open_drive("SMALL");
    assert_int_equal(write_sdo(0x6098, 0, 37, 1), 0);
    assert_int_equal(write_sdo(0x6098, 0, 34, 1), 0x06090030);
    assert_int_equal(write_sdo(0x6098, 0, 35, 1), 0);
    assert_int_equal(write_sdo(0x6098, 0, 0, 1), 0);
}

static void defaults_of_nothing(void **state)
{
    (void)state;
    open_drive("SMALL");
    assert_int_equal(read_sdo(0x6007, 0), 0);
    assert_int_equal(read_sdo(0x6072, 0), 3000);
    assert_int_equal(read_sdo(0x6502, 0), 0xA0);
    close_drive(state);
    open_drive("SERVO");
    assert_int_equal(read_sdo(0x6007, 0), 1);
    assert_int_equal(write_sdo(0x60C2, 2, -3, 1), 0);
    assert_int_equal(read_sdo(0x6085, 0), 524288000);
    assert_int_equal(read_sdo(0x605B, 0), 0);
    assert_int_equal(read_sdo(0x6502, 0), 0x3ED);
}

static void screw(void **state)
{
    (void)state;
    open_drive("SCREW");
    put(MODE, CSP);
    operational();
    enable(0);
    put(TARGET, 12345);
    cycles(500);
    assert_int_equal(get(ACTUAL), 12345);
    assert_int_equal(read_sdo(0x6063, 0), 323617);
    assert_int_equal(write_sdo(0x6092, 1, 10000, 4), 0x08000022);
    command(0, 0x00, SOD);
    assert_int_equal(write_sdo(0x6092, 1, 0, 4), 0x06090030);
    assert_int_equal(write_sdo(0x6092, 1, 10000, 4), 0);
    assert_int_equal(read_sdo(ACTUAL, 0), 24690);
    assert_int_equal(read_sdo(0x6063, 0), 323617);
}

static void positions_are_inverted(void **state)
{
    (void)state;
    open_drive("SCREW");
    assert_int_equal(write_sdo(0x607E, 0, 0x80, 1), 0);
    put(MODE, CSP);
    operational();
    enable(0);
    put(TARGET, 12345);
    cycles(500);
    assert_int_equal(get(ACTUAL), 12345);
    assert_int_equal(read_sdo(0x6063, 0), -323617);
}

/* --- reference runs ----------------------------------------------------------------------------------------------- */

static void home_here(void **state)
{
    static const int8_t methods[] = {35, 37};
    (void)state;
    servo_in(HM);
    enable(0);
    for (size_t i = 0; i < COUNT(methods); i++) {
        assert_int_equal(home(methods[i], 500), 5);
        assert_int_equal(get(ACTUAL), -500);
        put(CONTROL, ENABLE);
        cycles(1);
    }
    assert_true(signal_of("axis1.homed") == 1);
}

static void home_at_the_index(void **state)
{
    (void)state;
    servo_in(HM);
    set("axis1.index_at", "300000");
    enable(0);
    assert_int_equal(home(34, 0), 5);
    assert_true(fabs(signal_of("axis1.machine_position") - 300000) < 2);
    assert_true(llabs(get(ACTUAL)) <= 1);
}

static void home_without_method(void **state)
{
    (void)state;
    servo_in(HM);
    enable(0);
    assert_int_equal(home(0, 0), 9);
    assert_int_equal(state_of(get(STATUS)), ENABLED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(modes_are_noted, close_drive),
        cmocka_unit_test_teardown(a_shell_stays, close_drive),
        cmocka_unit_test_teardown(no_drive, close_drive),
        {"DRV-255 DRV-233 each shape of file follows a position in csp, one cycle behind", moves_position, NULL,
         close_drive, NULL},
        {"DRV-256 a drive without 607Ah and 6060h follows a speed", moves_speed, NULL, close_drive, NULL},
        {"DRV-090 each axis at 800h has its own state machine, plant and faults", axes_are_apart, NULL, close_drive,
         NULL},
        {"DRV-142 DRV-144 commands that have no effect in Switch on disabled", refused_commands, NULL, close_drive,
         NULL},
        {"DRV-109 DRV-112 DRV-117 0Fh in Ready enables, 00h disables", straight_to_enabled, NULL, close_drive, NULL},
        {"DRV-130 DRV-133 DRV-134 DRV-136 DRV-137 every way out of Operation enabled", ways_down, NULL, close_drive,
         NULL},
        {"DRV-201 DRV-202 DRV-203 the mode in force, without torque too", mode_before_enabling, NULL, close_drive,
         NULL},
        {"DRV-138 DRV-140 DRV-161 DRV-162 DRV-615 a fault, and 8Fh resets it", fault_and_reset, NULL, close_drive,
         NULL},
        {"DRV-143 DRV-151 a fault with its cause is not reset, and bit 7 needs an edge", cause_still_there, NULL,
         close_drive, NULL},
        {"DRV-155 DRV-156 6007h when OP ends", operation_lost, NULL, close_drive, NULL},
        {"DRV-241 DRV-207 a shaft that is stuck ends in a following error", shaft_is_stuck, NULL, close_drive, NULL},
        {"DRV-096 DRV-098 DRV-295 settings out of range are refused", refused_settings, NULL, close_drive, NULL},
        {"DRV-072 DRV-280 6098h takes the methods that 60E3h lists", listed_methods, NULL, close_drive, NULL},
        {"settings have the file's default, 0 too; without one, the twin's", defaults_of_nothing, NULL, close_drive,
         NULL},
        {"DRV-015 DRV-049 DRV-051 DRV-421 DRV-097 DRV-230 units of a screw", screw, NULL, close_drive, NULL},
        {"DRV-422 DRV-231 polarity turns positions round", positions_are_inverted, NULL, close_drive, NULL},
        {"DRV-294 DRV-427 DRV-277 DRV-268 home is here", home_here, NULL, close_drive, NULL},
        {"DRV-293 home is the next index pulse", home_at_the_index, NULL, close_drive, NULL},
        {"DRV-280 DRV-270 a run without a method is an error at a standstill", home_without_method, NULL, close_drive,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
