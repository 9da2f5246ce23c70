/* SPDX-License-Identifier: MIT */
/* Frames in words: addresses, commands, mails; and any bytes that a broken slave sends. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "conform_support.h"
#include "support/hex.h"

enum { FIRST = 16, HEADER = 10 };

static uint8_t frame[1514];
static size_t length;
static cf_t slave;
static char text[2000];

static void start(void)
{
    static const uint8_t ethernet[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0, 1, 2, 3, 4, 5, 0x88, 0xA4, 0, 0x10};
    memset(frame, 0, sizeof frame);
    memcpy(frame, ethernet, sizeof ethernet);
    length = sizeof ethernet;
    slave = (cf_t){.mailbox = {0x1000, 128, 0x1080, 128}};
}

/* Adds a datagram with data of hexadecimal digits. */
static void add(uint8_t command, uint32_t address, const char *hex, uint16_t wkc, bool more)
{
    uint8_t *at = frame + length;
    uint16_t bytes = from_hex(hex, at + HEADER);
    at[0] = command;
    ect_store_le32(at + 2, address);
    ect_store_le16(at + 6, (uint16_t)(bytes | (more ? 0x8000 : 0)));
    ect_store_le16(at + HEADER + bytes, wkc);
    length += (size_t)HEADER + bytes + 2;
}

static const char *decoded(cf_item_kind_t kind)
{
    const cf_item_t item = {.kind = kind, .length = (uint32_t)length, .bytes = frame};
    cf_decode(&slave, &item, text, sizeof text);
    return text;
}

static const char *one(cf_item_kind_t kind, uint8_t command, uint32_t address, const char *hex, uint16_t wkc)
{
    start();
    add(command, address, hex, wkc, false);
    return decoded(kind);
}

static void registers(void **state)
{
    (void)state;
    assert_string_equal(one(CF_ITEM_SENT, CF_FPRD, CF_AT(0x1001, 0x0130), "000000000000", 0),
                        "FPRD 1001:0130 AL status, 6 bytes");
    assert_string_equal(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(0x1001, 0x0130), "140000001B00", 1),
                        "FPRD 1001:0130 AL status, 6 bytes, WKC 1: 14 00 00 00 1B 00 | SAFEOP + error, code 0x001B");
    assert_string_equal(one(CF_ITEM_SENT, CF_FPWR, CF_AT(0x1001, 0x0120), "1200", 0),
                        "FPWR 1001:0120 AL control, 2 bytes: 12 00 | PREOP, acknowledge");
    assert_string_equal(one(CF_ITEM_RECEIVED, CF_FPWR, CF_AT(0x1001, 0x0120), "1200", 1),
                        "FPWR 1001:0120 AL control, 2 bytes, WKC 1");
    assert_string_equal(one(CF_ITEM_SENT, CF_APWR, CF_AT(0xFFFF, 0x080E), "00", 0), "APWR FFFF:080E SM1, 1 byte: 00");
    assert_string_equal(one(CF_ITEM_SENT, CF_BRD, CF_AT(0, 0x0620), "00", 0), "BRD 0000:0620 FMMU2, 1 byte");
    /* data without a reply are not shown */
    assert_string_equal(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(0x1002, 0x0F00), "AA", 0),
                        "FPRD 1002:0F00, 1 byte, WKC 0");
}

static void logical(void **state)
{
    (void)state;
    assert_string_equal(one(CF_ITEM_SENT, CF_LRW, 0x00010000, "0102", 0), "LRW logical 0x00010000, 2 bytes: 01 02");
    assert_string_equal(one(CF_ITEM_RECEIVED, CF_LRW, 0x00010000, "0304", 3),
                        "LRW logical 0x00010000, 2 bytes, WKC 3: 03 04");
    assert_string_equal(one(CF_ITEM_SENT, CF_LRD, 0x01300000, "00", 0), "LRD logical 0x01300000, 1 byte");
    assert_string_equal(one(CF_ITEM_RECEIVED, CF_LWR, 1, "05", 1), "LWR logical 0x00000001, 1 byte, WKC 1");
    assert_string_equal(one(CF_ITEM_SENT, 99, CF_AT(1, 2), "05", 0),
                        "command 99 0001:0002 chip information, 1 byte: 05");
}

static void mails(void **state)
{
    (void)state;
    assert_string_equal(
        one(CF_ITEM_SENT, CF_FPWR, CF_AT(0x1001, 0x1000), "0A0000000013002040181001", 0),
        "FPWR 1001:1000 mailbox out, 12 bytes | mail of 10 bytes, counter 1: CoE SDO request  | 0A 00 00 00 "
        "00 13 00 20 40 18 10 01");
    assert_string_equal(
        one(CF_ITEM_SENT, CF_FPWR, CF_AT(0x1001, 0x1000), "0A000000001300204018100100000000", 0),
        "FPWR 1001:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 1: CoE SDO request upload 1018h:01 "
        "| 0A 00 00 00 00 13 00 20 40 18 10 01 00 00 00 00");
    assert_string_equal(one(CF_ITEM_SENT, CF_FPRD, CF_AT(0x1001, 0x1080), "000000000000", 0),
                        "FPRD 1001:1080 mailbox in, 6 bytes");
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(0x1001, 0x1080), "0A000000002300208018100102000106", 1),
                           "counter 2: CoE SDO request abort 1018h:01 code 0x06010002 |"));
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(0x1001, 0x1080), "040000000070010002000000", 1),
                           "mail of 4 bytes, counter 7: error, detail 0x0002 |"));
    assert_non_null(
        strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(0x1001, 0x1080), "0A00000000130010505200000000000000", 1),
               "CoE emergency code 0x5250"));
    assert_non_null(
        strstr(one(CF_ITEM_SENT, CF_FPWR, CF_AT(0x1001, 0x1000), "0800000000140100000000003F3F", 0), "FoE type 4"));
}

static void sdo_words(void **state)
{
    static const struct {
        const char *coe, *words; /* a CoE mail behind the mailbox header */
    } rows[] = {
        {"00205018100100000000", "SDO request upload 1018h:01 complete"},
        {"00202F10100065766173", "SDO request download 1010h:00"},
        {"00203F10100065766173", "SDO request download 1010h:00 complete |"},
        {"00202F10100065766173", "SDO request download 1010h:00 |"},
        {"00206000000000000000", "SDO request next segment"},
        {"00200100000000000000", "SDO request segment, toggle 0, last"},
        {"00201000000000000000", "SDO request segment, toggle 1"},
        {"00306010100000000000", "SDO response downloaded 1010h:00"},
        {"00302000000000000000", "SDO response segment taken"},
        {"00808200070000000000", "information opcode 2, 7 fragments left"},
        {"0080820007", "CoE information  |"}, /* too short for its header */
        {"002040181001000000", "CoE SDO request  |"},
        {"0010", "CoE emergency  |"},
        {"00900000000000000000", "of an unknown service"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char hex[80];
        snprintf(hex, sizeof hex, "0A0000000013%s", rows[i].coe);
        assert_non_null(strstr(one(CF_ITEM_SENT, CF_FPWR, CF_AT(0x1001, 0x1000), hex, 0), rows[i].words));
    }
}

/* First and last address of each block of registers, and the adjacent addresses. */
static void places(void **state)
{
    static const struct {
        uint16_t first, last;
        const char *name;
    } blocks[] = {{0x0000, 0x0009, " chip information"},
                  {0x0130, 0x0135, " AL status"},
                  {0x0210, 0x0211, " ECAT event"},
                  {0x0300, 0x0313, " error counters"},
                  {0x0500, 0x050F, " SII"},
                  {0x0600, 0x06FF, " FMMU"},
                  {0x0800, 0x087F, " SM"},
                  {0x0900, 0x09FF, " distributed clocks"}};
    (void)state;
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) {
        assert_non_null(strstr(one(CF_ITEM_SENT, CF_FPRD, CF_AT(1, blocks[i].first), "00", 0), blocks[i].name));
        assert_non_null(strstr(one(CF_ITEM_SENT, CF_FPRD, CF_AT(1, blocks[i].last), "00", 0), blocks[i].name));
        assert_null(strstr(one(CF_ITEM_SENT, CF_FPRD, CF_AT(1, blocks[i].last + 1), "00", 0), blocks[i].name));
        if (blocks[i].first > 0)
            assert_null(strstr(one(CF_ITEM_SENT, CF_FPRD, CF_AT(1, blocks[i].first - 1), "00", 0), blocks[i].name));
    }
    assert_string_equal(one(CF_ITEM_SENT, CF_FPRD, CF_AT(1, 0x06FF), "00", 0), "FPRD 0001:06FF FMMU15, 1 byte");
    assert_string_equal(one(CF_ITEM_SENT, CF_FPRD, CF_AT(1, 0x087F), "00", 0), "FPRD 0001:087F SM15, 1 byte");
    assert_string_equal(one(CF_ITEM_SENT, CF_ARMW, CF_AT(1, 0x0F00), "01", 0), "ARMW 0001:0F00, 1 byte: 01");
    assert_string_equal(one(CF_ITEM_SENT, CF_FRMW, CF_AT(1, 0x0F00), "01", 0), "FRMW 0001:0F00, 1 byte: 01");
    assert_string_equal(one(CF_ITEM_SENT, 15, CF_AT(1, 0x0F00), "01", 0), "command 15 0001:0F00, 1 byte: 01");
}

/* A logical address has no mailbox and no AL status, other RAM no mailbox. */
static void lookalikes(void **state)
{
    static const uint8_t commands[] = {CF_LRD, CF_LWR, CF_LRW};
    (void)state;
    for (size_t i = 0; i < sizeof commands; i++) {
        const cf_item_kind_t kind = commands[i] == CF_LRD ? CF_ITEM_RECEIVED : CF_ITEM_SENT;
        assert_null(strstr(one(kind, commands[i], 0x10000000, "040000000010010002000000", 1), "mail"));
        assert_null(strstr(one(kind, commands[i], 0x01300000, "010000000000", 1), "INIT"));
    }
    assert_null(strstr(one(CF_ITEM_SENT, CF_FPWR, CF_AT(1, 0x1100), "040000000010010002000000", 0), "mail"));
    assert_null(strstr(one(CF_ITEM_SENT, CF_FPWR, CF_AT(1, 0x1000), "0400000000", 0), " | mail")); /* no whole header */
    slave.mailbox = (cf_mailbox_t){0};
    start();
    slave.mailbox = (cf_mailbox_t){0x0F00, 128, 0x0F80, 128}; /* below the RAM there is no mailbox */
    add(CF_FPWR, CF_AT(1, 0x0F00), "040000000010010002000000", 0, false);
    assert_null(strstr(decoded(CF_ITEM_SENT), "mail"));
}

static void lengths(void **state)
{
    (void)state;
    assert_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(1, 0x0130), "0100000000", 1), "code"));
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(1, 0x0130), "01", 1), "| INIT"));
    assert_string_equal(one(CF_ITEM_SENT, CF_FPWR, CF_AT(1, 0x0120), "04", 0),
                        "FPWR 0001:0120 AL control, 1 byte: 04 | SAFEOP");
    assert_non_null(
        strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(1, 0x1080), "04000000001300103054", 1), "emergency code 0x5430"));
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(1, 0x1080), "030000000013001030", 1), "emergency  |"));
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(1, 0x1080), "0600000000130080820003000000", 1),
                           "information opcode 2, 3 fragments left"));
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(1, 0x1080), "030000000010010002", 1), "type 0"));
}

/* Each command shows the data that it sends, and those that it brings back. */
static void directions(void **state)
{
    static const struct {
        uint8_t command;
        bool writes, reads;
    } rows[] = {{CF_APRD, false, true}, {CF_APWR, true, false}, {CF_APRW, true, true}, {CF_FPRD, false, true},
                {CF_FPWR, true, false}, {CF_FPRW, true, true},  {CF_BRD, false, true}, {CF_BWR, true, false},
                {CF_BRW, true, true},   {CF_LRD, false, true},  {CF_LWR, true, false}, {CF_LRW, true, true}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const char *sent = one(CF_ITEM_SENT, rows[i].command, CF_AT(1, 0x0F00), "5A", 0);
        assert_int_equal(strstr(sent, ": 5A") != NULL, rows[i].writes);
        const char *received = one(CF_ITEM_RECEIVED, rows[i].command, CF_AT(1, 0x0F00), "5A", 1);
        assert_int_equal(strstr(received, ": 5A") != NULL, rows[i].reads);
    }
}

/* Data beyond 48 bytes are cut off. */
static void long_data(void **state)
{
    char hex[2 * 49 + 1] = "";
    (void)state;
    for (int i = 0; i < 48; i++)
        snprintf(hex + 2 * i, 3, "AB");
    assert_null(strstr(one(CF_ITEM_SENT, CF_FPWR, CF_AT(1, 0x0F00), hex, 0), "..."));
    snprintf(hex + 96, 3, "CD");
    assert_non_null(strstr(one(CF_ITEM_SENT, CF_FPWR, CF_AT(1, 0x0F00), hex, 0), "AB AB ... (49 bytes)"));
    assert_null(strstr(text, "CD"));
}

/* A mail that claims more bytes than came shows those that came. */
static void mail_too_long(void **state)
{
    (void)state;
    assert_non_null(strstr(one(CF_ITEM_RECEIVED, CF_FPRD, CF_AT(0x1001, 0x1080), "FFFF00000013AABB", 1),
                           "mail of 65535 bytes, counter 1: CoE of an unknown service  | FF FF 00 00 00 13 AA BB"));
}

static void several(void **state)
{
    (void)state;
    start();
    add(CF_FPRD, CF_AT(0x1001, 0), "00", 0, true);
    add(CF_NOP, 0, "", 0, false);
    assert_string_equal(decoded(CF_ITEM_SENT),
                        "FPRD 1001:0000 chip information, 1 byte\nNOP 0000:0000 chip information, 0 bytes:");
}

static void damaged(void **state)
{
    (void)state;
    start();
    add(CF_FPRD, CF_AT(0x1001, 0), "00", 0, true); /* more follows, but nothing does */
    assert_non_null(strstr(decoded(CF_ITEM_SENT), "\ncut off:"));
    for (size_t cut = 0; cut <= length; cut++) { /* no length reads beyond the frame */
        uint8_t *copy = malloc(cut + 1);
        const cf_item_t item = {.kind = CF_ITEM_RECEIVED, .length = (uint32_t)cut, .bytes = copy};
        memcpy(copy, frame, cut);
        cf_decode(&slave, &item, text, sizeof text);
        free(copy);
    }
    start();
    add(CF_FPRD, CF_AT(0x1001, 0), "00", 0, false);
    length -= 1; /* the first datagram itself is cut off */
    assert_string_equal(decoded(CF_ITEM_SENT), "cut off: 04 00 01 10 00 00 01 00 00 00 00 00");
    start();
    frame[13] = 0xA5;
    add(CF_FPRD, CF_AT(0x1001, 0), "00", 0, false);
    assert_memory_equal(decoded(CF_ITEM_SENT), "frame of 29 bytes:", 18);
    start();
    frame[15] = 0x20; /* another type of EtherCAT header */
    add(CF_FPRD, CF_AT(0x1001, 0), "00", 0, false);
    assert_memory_equal(decoded(CF_ITEM_SENT), "frame of 29 bytes:", 18);
}

/* Any room: the text ends with its zero, and nothing is written behind the room. */
static void small_room(void **state)
{
    static const struct {
        uint32_t folded;
        const char *words;
    } rows[] = {{0, "FPRD 1001:0130 AL status, 6 bytes"},
                {1, "FPRD 1001:0130 AL status, 6 bytes (and once before)"},
                {12, "FPRD 1001:0130 AL status, 6 bytes (and 12 times before)"}};
    (void)state;
    start();
    add(CF_FPRD, CF_AT(0x1001, 0x0130), "000000000000", 0, false);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const size_t whole = strlen(rows[i].words);
        for (size_t room = 1; room < whole + 5; room++) {
            const cf_item_t item = {
                .kind = CF_ITEM_SENT, .folded = rows[i].folded, .length = (uint32_t)length, .bytes = frame};
            char place[100];
            memset(place, 'x', sizeof place);
            cf_decode(&slave, &item, place, room);
            const size_t shown = room - 1 < whole ? room - 1 : whole;
            assert_int_equal(strlen(place), shown);
            assert_memory_equal(place, rows[i].words, shown);
            for (size_t at = room; at < sizeof place; at++)
                assert_int_equal(place[at], 'x');
        }
    }
}

static void sentences(void **state)
{
    const cf_item_t item = {.kind = CF_ITEM_STEP, .bytes = (uint8_t *)(uintptr_t)"a sentence"};
    cf_item_t folded = {.kind = CF_ITEM_SENT, .folded = 7, .bytes = frame};
    (void)state;
    cf_decode(&slave, &item, text, sizeof text);
    assert_string_equal(text, "a sentence");
    start();
    add(CF_FPRD, CF_AT(0x1001, 0x080D), "00", 0, false);
    folded.length = (uint32_t)length;
    cf_decode(&slave, &folded, text, sizeof text);
    assert_string_equal(text, "FPRD 1001:080D SM1, 1 byte (and 7 times before)");
    folded.folded = 2;
    cf_decode(&slave, &folded, text, sizeof text);
    assert_string_equal(text, "FPRD 1001:080D SM1, 1 byte (and 2 times before)");
    folded.folded = 1;
    cf_decode(&slave, &folded, text, sizeof text);
    assert_string_equal(text, "FPRD 1001:080D SM1, 1 byte (and once before)");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(registers),  cmocka_unit_test(logical),       cmocka_unit_test(mails),
        cmocka_unit_test(sdo_words),  cmocka_unit_test(mail_too_long), cmocka_unit_test(several),
        cmocka_unit_test(places),     cmocka_unit_test(lookalikes),    cmocka_unit_test(lengths),
        cmocka_unit_test(directions), cmocka_unit_test(long_data),     cmocka_unit_test(damaged),
        cmocka_unit_test(small_room), cmocka_unit_test(sentences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
