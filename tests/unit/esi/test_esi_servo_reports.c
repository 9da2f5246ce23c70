/* SPDX-License-Identifier: MIT */
/* Mails that SoE drives of tests/esi/soe.xml send unasked: notifications when commands end, emergencies. */
#include "bus/chain/chain.h"
#include "servo_of_file.h"

enum { RESET_IDN = 99, HOMING = 148, PARAMETER = 147, AT_PLACE = 0x60, RUN = 0xE000, IS_ENABLED = 3 };
enum { NOTIFICATION = 5, EMERGENCY = 6, CURRENT = 0x03 /* error register: generic, current */ };

static void open_enabled(void)
{
    open_servo("TWO", ECT_BEHAVIOUR_BY_FILE);
    operational();
    ect_store_le16(out, RUN);
    ect_store_le16(out + 6, RUN);
    for (unsigned int n = 0; n < 2000 && ect_load_le16(in + 10) >> 14 != IS_ENABLED; n++)
        cycles(1);
    assert_int_equal(ect_load_le16(in) >> 14, IS_ENABLED);
    assert_int_equal(ect_load_le16(in + 10) >> 14, IS_ENABLED);
}

static int write_word(unsigned int drive, uint16_t idn, uint8_t value)
{
    const uint8_t bytes[] = {value, 0};
    return write_value(drive, idn, bytes, sizeof bytes);
}

static void expect_none(void)
{
    uint8_t mail[ROOM];
    assert_int_equal(wire_mail_receive(&wire, 0, mail, sizeof mail), -1);
}

static void expect_mail(const uint8_t *expected, int length)
{
    uint8_t mail[ROOM];
    assert_int_equal(wire_mail_receive(&wire, 0, mail, sizeof mail), length);
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_SOE);
    assert_memory_equal(mail + MAIL, expected, (size_t)length);
}

static void expect_notification(unsigned int drive, uint16_t idn, uint8_t state)
{
    const uint8_t mail[] = {(uint8_t)(NOTIFICATION | drive << 5), 1, (uint8_t)idn, 0, state, 0};
    expect_mail(mail, sizeof mail);
}

static void expect_fault(unsigned int drive, uint16_t code, uint8_t error_register)
{
    const uint8_t mail[] = {
        (uint8_t)(EMERGENCY | drive << 5), 0, 0, 0, (uint8_t)code, (uint8_t)(code >> 8), error_register, 0, 0, 0, 0, 0};
    expect_mail(mail, sizeof mail);
}

static void silent(void **state)
{
    static const uint8_t at_place[] = {AT_PLACE, 0};
    (void)state;
    open_enabled();
    assert_int_equal(write_value(0, PARAMETER, at_place, sizeof at_place), 0);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    cycles(200);
    assert_int_equal(number_of(0, HOMING, ECT_SOE_ELEMENT_STATE), ECT_SOE_COMMAND_DONE);
    expect_none();
    set("axis2.fault", "0x2311");
    cycles(10);
    expect_none();
}

static void reports(void **state)
{
    static const uint8_t at_place[] = {AT_PLACE, 0};
    (void)state;
    open_enabled();
    set("soe.reports", "1");
    assert_int_equal(write_value(1, PARAMETER, at_place, sizeof at_place), 0);
    assert_int_equal(write_word(1, HOMING, 3), 0);
    cycles(200);
    expect_notification(1, HOMING, ECT_SOE_COMMAND_DONE);
    set("axis2.fault", "0x2311");
    cycles(10);
    expect_fault(1, 0x2311, CURRENT);
    ect_store_le16(out + 6, 0);
    assert_int_equal(write_word(1, RESET_IDN, 3), 0);
    cycles(10);
    expect_fault(1, 0, 0);
    expect_notification(1, RESET_IDN, ECT_SOE_COMMAND_DONE);
    assert_int_equal(write_word(0, HOMING, 3), 0);
    ect_store_le16(out, 0);
    cycles(10);
    expect_notification(0, HOMING, ECT_SOE_COMMAND_ERROR);
    set("soe.reports", "0");
    set("axis1.fault", "0x2311");
    cycles(10);
    expect_none();
}

static void outlast(void **state)
{
    static const char *const types[] = {"TWO", "SPEED"};
    for (size_t i = 0; i < COUNT(types); i++) {
        open_servo(types[i], ECT_BEHAVIOUR_BY_FILE);
        set("soe.reports", "1");
        ect_chain_power_cycle(wire.chain, wire.now_ns);
        wire_poll(&wire);
        wire_assign_stations(&wire);
        wire_configure_mailbox(&wire, 0);
        wire_go(&wire, 0, PREOP);
        assert_int_equal((int)signal_of("soe.reports"), 1);
        set("axis1.fault", "0x2311");
        wire_advance(&wire, MS);
        expect_fault(0, 0x2311, CURRENT);
        (void)close_drive(state);
    }
}

static void one_drive(void **state)
{
    (void)state;
    open_servo("SPEED", ECT_BEHAVIOUR_BY_FILE);
    assert_int_equal((int)signal_of("soe.reports"), 0);
    set("soe.reports", "1");
    assert_int_equal((int)signal_of("soe.reports"), 1);
    set("axis1.fault", "0x2311");
    wire_advance(&wire, MS);
    expect_fault(0, 0x2311, CURRENT);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"SOE-019: a SoE drive sends no mail unasked", silent, NULL, close_drive, NULL},
        {"SOE-020: with soe.reports=1 the end of a command is a notification, a fault an emergency", reports, NULL,
         close_drive, NULL},
        {"SOE-020: a twin of a single drive has soe.reports, too", one_drive, NULL, close_drive, NULL},
        {"SOE-020: soe.reports outlasts a power cycle, of two drives and of one", outlast, NULL, close_drive, NULL},
    };
    return cmocka_run_group_tests_name("reports of SoE drives", tests, NULL, NULL);
}
