/* SPDX-License-Identifier: MIT */
/* The 16-byte mailbox of the PMCtendo (manual §4.10), byte for byte. */
#include <string.h>

#include "support/drive.h"

enum { OUT = 0x1800, IN = 0x1C00, TELEGRAM = 16, SM0_FULL = 0x0805, SM1_FULL = 0x080D, FULL = 0x08 };
enum { EVENT = 0x0220, MAIL_OUT = 0x01, MAIL_IN = 0x02 };
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

typedef uint8_t telegram_t[TELEGRAM];

static drive_t d;

static int setup(void **state)
{
    (void)state;
    drive_open(&d);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    drive_close(&d);
    return 0;
}

static void exchange(const telegram_t request, telegram_t reply)
{
    assert_int_equal(wire_write(&d.w, 0, OUT, request, TELEGRAM), 1);
    if (wire_read(&d.w, 0, IN, reply, TELEGRAM) != 1)
        fail_msg("no reply to a telegram: type %02X, service %02X, command %02X", request[5], request[7], request[8]);
}

/* The mail counter, bits 4 to 6 of byte 5, is defined by the standard and not in the manual: it is not compared. */
static void expect(const char *what, const telegram_t request, const telegram_t want)
{
    telegram_t reply;
    exchange(request, reply);
    reply[5] &= 0x0F;
    for (unsigned int i = 0; i < TELEGRAM; i++) {
        if (reply[i] != want[i])
            fail_msg("%s: reply byte %u: expected %02X, got %02X", what, i, want[i], reply[i]);
    }
}

static const telegram_t no_pdo = {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2F, 0x12, 0x1C, 0, 0, 0, 0, 0};
static const telegram_t example = {0x0A, 0, 0, 0, 0, 3, 0, 0x20, 0x2B, 0x12, 0x1C, 0x01, 0x04, 0x17, 0, 0};

static void worked_example(void **state)
{
    static const telegram_t first = {10, 0, 0, 0, 0, 3, 0, 0x30, 0x60, 0x12, 0x1C, 0, 0, 0, 0, 0};
    static const telegram_t reply = {10, 0, 0, 0, 0, 3, 0, 0x30, 0x60, 0x12, 0x1C, 1, 0, 0, 0, 0};
    (void)state;
    expect("1C12:0 = 0", no_pdo, first);
    expect("1C12:1 = 1704h", example, reply);
    assert_int_equal(drive_read(&d, 0x1C12, 1), 0x1704);
}

static void as_printed(void **state)
{
    static const telegram_t first = {0x0E, 0, 0, 0, 0, 3, 0, 0x20, 0x60, 0x12, 0x1C, 0, 0, 0, 0, 0};
    static const telegram_t reply = {0x0E, 0, 0, 0, 0, 3, 0, 0x20, 0x60, 0x12, 0x1C, 1, 0, 0, 0, 0};
    (void)state;
    signal_set(&d.w, "quirk_pilz_reply", "1");
    expect("1C12:0 = 0", no_pdo, first);
    expect("1C12:1 = 1704h", example, reply);
    signal_set(&d.w, "quirk_pilz_reply", "0");
    assert_int_equal(drive_read(&d, 0x1C12, 1), 0x1704);
}

/* Command bytes of requests and replies, 4 to 1 bytes; abort codes; index, sub-index and data at their positions. */
static void commands(void **state)
{
    static const struct {
        const char *what;
        telegram_t request, reply;
    } rows[] = {
        {"read 4 bytes",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x83, 0x60},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x43, 0x83, 0x60, 0, 0, 0, 0x40, 6}},
        {"read 2 bytes",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x5A, 0x60},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x4B, 0x5A, 0x60, 0, 2}},
        {"read 1 byte",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x98, 0x60},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x4F, 0x98, 0x60, 0, 35}},
        {"write 4 bytes",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x23, 0x7A, 0x60, 0, 0x78, 0x56, 0x34, 0x12},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x60, 0x7A, 0x60}},
        {"... low byte first",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x7A, 0x60},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x43, 0x7A, 0x60, 0, 0x78, 0x56, 0x34, 0x12}},
        {"write 2 bytes",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2B, 0x5A, 0x60, 0, 6},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x60, 0x5A, 0x60}},
        {"write 1 byte",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2F, 0x98, 0x60, 0, 19},
         {10, 0, 0, 0, 0, 3, 0, 0x30, 0x60, 0x98, 0x60}},
        {"no such object",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x99, 0x99, 1},
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x80, 0x99, 0x99, 1, 0, 0, 0x02, 0x06}},
        {"no such sub-index",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0xC2, 0x60, 3},
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x80, 0xC2, 0x60, 3, 0x11, 0, 0x09, 0x06}},
        {"read only",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2B, 0x41, 0x60},
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x80, 0x41, 0x60, 0, 2, 0, 0x01, 0x06}},
        {"no such mode",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2F, 0x60, 0x60, 0, 2},
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x80, 0x60, 0x60, 0, 0x30, 0, 0x09, 0x06}},
        {"no such homing method",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2F, 0x98, 0x60, 0, 7},
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x80, 0x98, 0x60, 0, 0x30, 0, 0x09, 0x06}},
        {"no such quick stop",
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2B, 0x5A, 0x60, 0, 3},
         {10, 0, 0, 0, 0, 3, 0, 0x20, 0x80, 0x5A, 0x60, 0, 0x30, 0, 0x09, 0x06}},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++)
        expect(rows[i].what, rows[i].request, rows[i].reply);
}

/* Step by step: the event, the drive has read, Mail Out is free again, Mail In is full; one transaction at a time. */
static void handling(void **state)
{
    uint8_t event[4];
    telegram_t reply;
    (void)state;
    d.w.manual_poll = true;
    assert_int_equal(wire_write(&d.w, 0, OUT, example, TELEGRAM), 1);
    assert_int_equal(wire_read(&d.w, 0, EVENT, event, sizeof event), 1);
    assert_int_equal(event[1] & (MAIL_OUT | MAIL_IN), MAIL_OUT);
    assert_int_equal(wire_read8(&d.w, 0, SM0_FULL) & FULL, FULL);
    assert_int_equal(wire_write(&d.w, 0, OUT, example, TELEGRAM), 0); /* it has not been read yet */
    assert_int_equal(wire_read(&d.w, 0, IN, reply, TELEGRAM), 0);
    wire_poll(&d.w);
    assert_int_equal(wire_read(&d.w, 0, EVENT, event, sizeof event), 1);
    assert_int_equal(event[1] & MAIL_OUT, 0);
    assert_int_equal(wire_read8(&d.w, 0, SM0_FULL) & FULL, 0);
    assert_int_equal(wire_read8(&d.w, 0, SM1_FULL) & FULL, FULL);
    assert_int_equal(wire_read(&d.w, 0, IN, reply, TELEGRAM), 1);
    assert_int_equal(wire_read8(&d.w, 0, SM1_FULL) & FULL, 0);
    assert_int_equal(ect_load_le16(reply), 10);
}

/* Any telegram: other types, services, commands, lengths. */
static void every_telegram(void **state)
{
    static const telegram_t read = {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x41, 0x60};
    (void)state;
    for (unsigned int type = 0; type < 16; type++) {
        for (unsigned int service = 0; service < 16; service++) {
            telegram_t request, reply;
            memcpy(request, read, TELEGRAM);
            request[5] = (uint8_t)type;
            request[7] = (uint8_t)(service << 4);
            exchange(request, reply);
            bool right = type == 3 && service == 2;
            assert_int_equal((reply[5] & 0x0F) == 3, right);
            if (!right)
                assert_int_equal(ect_load_le16(reply + 6), 1); /* a mailbox error */
        }
    }
    for (unsigned int command = 0; command < 256; command++) {
        telegram_t request, reply;
        if (command >> 5 == 4)
            continue; /* an abort by the master ends a transfer, and has no reply */
        memcpy(request, read, TELEGRAM);
        request[8] = (uint8_t)command;
        exchange(request, reply);
    }
    for (unsigned int length = 0; length < 32; length++) {
        telegram_t request, reply;
        memcpy(request, read, TELEGRAM);
        request[0] = (uint8_t)length;
        exchange(request, reply);
    }
    assert_int_equal(drive_read(&d, 0x1000, 0), 0x00020192);
}

/* A name is longer than a telegram: it is sent in segments. */
static void names(void **state)
{
    char text[40] = {0};
    size_t size = sizeof text;
    (void)state;
    assert_int_equal(wire_sdo_upload(&d.w, 0, 0x1008, 0, false, text, &size), 0);
    assert_int_equal(size, strlen("PMCtendo DD5"));
    assert_string_equal(text, "PMCtendo DD5");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-029 PLZ-028 PLZ-027: the worked example, 1C12:1 = 1704h, byte for byte", worked_example, setup, teardown,
         NULL},
        {"PLZ-029: quirk_pilz_reply: the reply as the manual prints it, 0Eh and 20h", as_printed, setup, teardown,
         NULL},
        {"PLZ-027 PLZ-028: commands for 1 to 4 bytes, their replies, abort codes", commands, setup, teardown, NULL},
        {"PLZ-007 PLZ-008 PLZ-009 PLZ-010 PLZ-011 PLZ-012 PLZ-014: Mail Out raises its event, is read and freed, the "
         "reply is in Mail In",
         handling, setup, teardown, NULL},
        {"PLZ-030: every telegram gets a reply, an abort or a mailbox error", every_telegram, setup, teardown, NULL},
        {"PLZ-027: values longer than a telegram are sent in segments", names, setup, teardown, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo mailbox", tests, NULL, NULL);
}
