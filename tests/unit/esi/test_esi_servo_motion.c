/* SPDX-License-Identifier: MIT */
/* The words S-0-0134 and S-0-0135 of SoE drives: the way to enabled and back, set values, halt, faults, AL states. */
#include "from_text.h"
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
    assert_int_equal(word(0) & FOLLOWS, 0); /* the file does not announce bit 3 */
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
    assert_int_equal(word(0) & FOLLOWS, 0);
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
    assert_true(ect_chain_poll(wire.chain, wire.now_ns) <= wire.now_ns + MS); /* it turns */
    assert_int_equal(number_of(0, 134, VALUE), 0);
    assert_int_equal(number_of(0, 135, VALUE) & CLASS_1, CLASS_1);
    wire_advance(&wire, 2000 * MS);
    assert_int_equal((int)signal_of("axis1.powered"), 0);
    assert_int_equal(write_value(0, RESET_IDN, start, sizeof start), 0);
    assert_int_equal(number_of(0, RESET_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_DONE);
    assert_int_equal(number_of(0, 135, VALUE) & CLASS_1, 0);
    set("axis1.fault", "0x2311"); /* the reset does not last until OP */
    wire_go(&wire, 0, OP);
    cycles(5);
    assert_int_equal(word(0) & CLASS_1, CLASS_1);
    assert_int_equal(number_of(0, RESET_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_DONE);
}

static void supply(void **state)
{
    static const struct {
        const char *signal, *off, *on;
    } rows[] = {{"axis1.power", "0", "1"}, {"axis1.enable", "0", "1"}, {"axis1.sto", "1", "0"}};
    (void)state;
    open_in_op("SPEED");
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(power(0), TO_ENABLE);
        set(rows[i].signal, rows[i].off);
        cycles(2);
        if (power(0) != READY_FOR_POWER)
            fail_msg("%s=%s: the word is %04X", rows[i].signal, rows[i].off, word(0));
        control(0, RUN);
        cycles(20);
        assert_int_not_equal(power(0), IS_ENABLED);
        set(rows[i].signal, rows[i].on);
        reach(0, IS_ENABLED);
        control(0, 0);
        reach(0, TO_ENABLE);
    }
}

/* --- drives in few lines ------------------------------------------------------------------------------------------ */

#define NUMBER(index, value, flags)                                                                                    \
    "<Object><Index>#x" index "</Index><Name>N</Name><Type>UINT</Type><BitSize>16</BitSize><Info><DefaultValue>" value \
    "</DefaultValue></Info>" flags "</Object>"
#define PART(index, bits, name, type)                                                                                  \
    "<Entry><Index>#x" index "</Index><BitLen>" bits "</BitLen><Name>" name "</Name><DataType>" type                   \
    "</DataType></Entry>"
#define DRIVE_WITH(mailbox, objects, at)                                                                               \
    ESI_DEVICE(                                                                                                        \
        "<Profile><Dictionary><DataTypes><DataType><Name>UINT</Name><BitSize>16</BitSize></DataType>"                  \
        "</DataTypes><Objects>" objects "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS            \
        "<RxPdo Sm='2'><Index>#x0018</Index><Name>MDT</Name>" PART("86", "16", "Control", "UINT")                      \
            PART("24", "32", "Speed", "DINT") PART("2F", "32", "Position", "DINT")                                     \
                PART("50", "16", "Torque", "INT") "</RxPdo><TxPdo Sm='3'><Index>#x0010</Index><Name>AT</Name>" PART(   \
                    "87", "16", "Status", "UINT") at "</TxPdo><Mailbox>" mailbox "</Mailbox>" ESI_EEPROM)
#define DRIVE(objects, at) DRIVE_WITH("<SoE/>", objects, at)
#define HOMING_COMMAND     NUMBER("0094", "0", "<Flags><Attribute>#x00090001</Attribute></Flags>")

static ect_esi_t *file;

static void open_text(const char *what, const char *text)
{
    char why[200] = "";
    made_t m = make_text(what, text);
    assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why));
    file = m.esi;
    twin = m.twin;
    open_twin();
}

static int close_text(void **state)
{
    (void)close_drive(state);
    ect_esi_close(file);
    file = NULL;
    return 0;
}

/* Bits 0 to 2 of S-0-0032 to S-0-0035 are the kind of the mode; bits 8, 9 and 11 of S-0-0134 select the number. A
 * number without a mode leaves the present one. */
static void selected_modes(void **state)
{
    static const struct {
        unsigned int values[4];
        int modes[4]; /* 0: none */
    } rows[] = {
        {{2, 11, 1, 7}, {CSV, CSP, CST, 0}},
        {{2, 6, 3, 4}, {CSV, 0, CSP, CSP}},
        {{0, 10, 5, 9}, {0, CSV, CSP, CST}},
        {{1, 8, 2, 0}, {CST, 0, CSV, 0}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[6000];
        const unsigned int *v = rows[i].values;
        (void)snprintf(text, sizeof text,
                       DRIVE(NUMBER("0020", "%u", "") NUMBER("0021", "%u", "") NUMBER("0022", "%u", "")
                                 NUMBER("0023", "%u", ""),
                             PART("33", "32", "Position", "DINT")),
                       v[0], v[1], v[2], v[3]);
        open_text("modes", text);
        operational();
        int mode = 0;
        for (unsigned int number = 0; number < 8; number++) {
            mode = number < 4 && rows[i].modes[number] != 0 ? rows[i].modes[number] : mode;
            control(0, (uint16_t)(RUN | (number & 3) << 8 | (number >= 4 ? 0x0800 : 0)));
            cycles(2);
            if ((word(0) >> 8 & 7u) != number || (int)signal_of("axis1.mode") != mode)
                fail_msg("row %zu, mode number %u: expected mode %d, got %d, status word %04X", i, number, mode,
                         (int)signal_of("axis1.mode"), word(0));
        }
        (void)close_text(state);
    }
}

/* Values that the drive writes are read-only for users; S-0-0400 and S-0-0403 belong to S-0-0148. */
static void written_values(void **state)
{
#define ALL_VALUES                                                                                                     \
    PART("0B", "16", "Class 1", "UINT")                                                                                \
    PART("190", "16", "Switch", "UINT")                                                                                \
    PART("193", "16", "Homed", "UINT") PART("33", "32", "Position", "DINT") PART("8001", "16", "Own", "UINT")
    static const struct {
        const char *name;
        bool with_homing, without;
    } rows[] = {{"at.status", true, true}, {"at.class_1", true, true},  {"at.switch", true, false},
                {"at.homed", true, false}, {"at.position", true, true}, {"at.own", false, false}};
    static const char *const texts[] = {DRIVE(HOMING_COMMAND, ALL_VALUES), DRIVE("", ALL_VALUES)};
    for (size_t k = 0; k < COUNT(texts); k++) {
        open_text("values of a drive", texts[k]);
        for (size_t i = 0; i < COUNT(rows); i++) {
            ect_signal_ref_t ref;
            if (!ect_chain_signal(wire.chain, 0, rows[i].name, &ref))
                fail_msg("there is no signal %s", rows[i].name);
            if ((ref.signal->access == ECT_SIGNAL_READ) != (k == 0 ? rows[i].with_homing : rows[i].without))
                fail_msg("%s, file %zu: read-only or not", rows[i].name, k);
        }
        (void)close_text(state);
    }
}

/* Without S-0-0147 the home switch is at the drive: a run starts. */
static void homing_without_a_parameter(void **state)
{
    static const uint8_t start[] = {3, 0};
    enum { HOMING_IDN = 148 };
    (void)state;
    open_text("homing", DRIVE(NUMBER("0020", "11", "") HOMING_COMMAND, PART("33", "32", "Position", "DINT")));
    operational();
    control(0, RUN);
    reach(0, IS_ENABLED);
    assert_int_equal(write_value(0, HOMING_IDN, start, sizeof start), 0);
    cycles(2);
    assert_int_equal(number_of(0, HOMING_IDN, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_RUNS);
}

static void word_at_power_on(void **state)
{
    (void)state;
    open_text("power-on", DRIVE("", PART("33", "32", "Position", "DINT")));
    ect_chain_power_cycle(wire.chain, wire.now_ns);
    assert_int_equal((int)signal_of("at.status") >> 14, TO_ENABLE);
}

/* Without reports of SoE the emergencies are those of CoE. */
static void emergencies_of_coe(void **state)
{
    (void)state;
    open_text("CoE and SoE", DRIVE_WITH("<CoE/><SoE/>", HOMING_COMMAND, PART("33", "32", "Position", "DINT")));
    operational();
    set("axis1.fault", "0x2311");
    cycles(10);
    expect_emergency(0x2311, 0x03);
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
        {"S-0-0135: without supply or enable input a drive is ready for power, and not enabled", supply, NULL,
         close_drive, NULL},
        {"SOE-043: bits of S-0-0134 select one of four operation modes, each with its kind", selected_modes, NULL,
         close_text, NULL},
        {"values that a drive writes are read-only signals", written_values, NULL, close_text, NULL},
        {"S-0-0135 has the state of the drive at once at power-on", word_at_power_on, NULL, close_text, NULL},
        {"a fault of a drive that has CoE, too, is an emergency of CoE", emergencies_of_coe, NULL, close_text, NULL},
        {"S-0-0148 without S-0-0147 seeks the switch at the drive", homing_without_a_parameter, NULL, close_text, NULL},
    };
    return cmocka_run_group_tests_name("words of SoE drives", tests, NULL, NULL);
}
