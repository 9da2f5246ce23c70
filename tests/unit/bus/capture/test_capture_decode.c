/* SPDX-License-Identifier: MIT */
/* Frames as text (src/bus/capture/decode.h): commands, places, states, mails, and frames that end too early. */
#include "bus/capture/decode.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "support/hex.h"

enum { ROOM = 1500, TEXT = 4000 };

static const ect_mailboxes_t mailboxes = {.out_start = 0x1000, .in_start = 0x1400};

/* A datagram: command, address, data and working counter; more follow or not. */
static size_t datagram(uint8_t *at, unsigned int command, uint32_t address, const char *data, unsigned int counter,
                       bool more)
{
    const size_t length = from_hex(data, at + 10);
    const uint8_t head[10] = {(uint8_t)command,
                              0,
                              (uint8_t)address,
                              (uint8_t)(address >> 8),
                              (uint8_t)(address >> 16),
                              (uint8_t)(address >> 24),
                              (uint8_t)length,
                              (uint8_t)(length >> 8 | (more ? 0x80u : 0u)),
                              0,
                              0};
    memcpy(at, head, sizeof head);
    at[10 + length] = (uint8_t)counter;
    at[11 + length] = (uint8_t)(counter >> 8);
    return 12 + length;
}

typedef struct row {
    unsigned int command;
    uint32_t address; /* ADP in the lower half, ADO in the upper one */
    const char *data;
    int counter; /* -1: as the master sends it */
    const char *text;
} row_t;

static void expect(const row_t *row)
{
    uint8_t bytes[ROOM];
    char text[TEXT];
    const bool sent = row->counter < 0;
    const size_t size =
        datagram(bytes, row->command, row->address, row->data, sent ? 0 : (unsigned int)row->counter, false);
    ect_decode_datagram(&mailboxes, bytes, size - 12, sent, text, sizeof text);
    if (strcmp(text, row->text) != 0)
        fail_msg("expected %s\n  got      %s", row->text, text);
}

#define AT(adp, ado) ((uint32_t)(ado) << 16 | (adp))

static void a_command_has_its_place_and_the_data_that_travel(void **state)
{
    static const row_t rows[] = {
        {0, 0, "00", -1, "NOP 0000:0000 chip information, 1 byte: 00"},
        {1, AT(0xFFFF, 0x0000), "00 00", -1, "APRD FFFF:0000 chip information, 2 bytes"},
        {1, AT(0x0001, 0x0009), "11", 1, "APRD 0001:0009 chip information, 1 byte, WKC 1: 11"},
        {1, AT(0x0001, 0x000A), "11", 1, "APRD 0001:000A, 1 byte, WKC 1: 11"},
        {2, AT(0xFFFF, 0x0010), "E9 03", -1, "APWR FFFF:0010 station address, 2 bytes: E9 03"},
        {2, AT(0xFFFF, 0x0010), "E9 03", 1, "APWR FFFF:0010 station address, 2 bytes, WKC 1"},
        {3, AT(0, 0x0012), "01 02", -1, "APRW 0000:0012 station alias, 2 bytes: 01 02"},
        {3, AT(0, 0x0012), "01 02", 3, "APRW 0000:0012 station alias, 2 bytes, WKC 3: 01 02"},
        {4, AT(1001, 0x0502), "01", -1, "FPRD 03E9:0502 SII, 1 byte"},
        {4, AT(1001, 0x0502), "01", 0, "FPRD 03E9:0502 SII, 1 byte, WKC 0"},
        {5, AT(1001, 0x0600), "01", -1, "FPWR 03E9:0600 FMMU0, 1 byte: 01"},
        {5, AT(1001, 0x06F0), "01", -1, "FPWR 03E9:06F0 FMMU15, 1 byte: 01"},
        {5, AT(1001, 0x0700), "01", -1, "FPWR 03E9:0700, 1 byte: 01"},
        {6, AT(1001, 0x0800), "01", -1, "FPRW 03E9:0800 SM0, 1 byte: 01"},
        {6, AT(1001, 0x087F), "01", -1, "FPRW 03E9:087F SM15, 1 byte: 01"},
        {6, AT(1001, 0x0880), "01", -1, "FPRW 03E9:0880, 1 byte: 01"},
        {7, AT(0, 0x0110), "00 00", 0x0102, "BRD 0000:0110 DL status, 2 bytes, WKC 258: 00 00"},
        {8, AT(0, 0x0900), "00", -1, "BWR 0000:0900 distributed clocks, 1 byte: 00"},
        {8, AT(0, 0x0900), "00", 2, "BWR 0000:0900 distributed clocks, 1 byte, WKC 2"},
        {9, AT(0, 0x0F80), "AA", -1, "BRW 0000:0F80 user RAM, 1 byte: AA"},
        {10, 0x01020304, "AA", -1, "LRD logical 0x01020304, 1 byte"},
        {10, 0x01020304, "AA", 1, "LRD logical 0x01020304, 1 byte, WKC 1: AA"},
        {11, 0x01020304, "AA", -1, "LWR logical 0x01020304, 1 byte: AA"},
        {11, 0x01020304, "AA", 1, "LWR logical 0x01020304, 1 byte, WKC 1"},
        {12, 0x01200304, "AA", -1, "LRW logical 0x01200304, 1 byte: AA"},
        {12, 0x10001000, "AA BB CC DD EE FF", 3, "LRW logical 0x10001000, 6 bytes, WKC 3: AA BB CC DD EE FF"},
        {10, 0x10000000, "AA BB CC DD EE FF", 3, "LRD logical 0x10000000, 6 bytes, WKC 3: AA BB CC DD EE FF"},
        {11, 0x14000000, "AA BB CC DD EE FF", -1, "LWR logical 0x14000000, 6 bytes: AA BB CC DD EE FF"},
        {13, AT(0, 0x0910), "AA", -1, "ARMW 0000:0910 distributed clocks, 1 byte: AA"},
        {14, AT(1001, 0x0910), "AA", 1, "FRMW 03E9:0910 distributed clocks, 1 byte, WKC 1: AA"},
        {15, AT(0, 0x1000), "AA", -1, "command 15 0000:1000 mailbox out, 1 byte: AA"},
        {5, AT(1001, 0x1400), "AA", -1, "FPWR 03E9:1400 mailbox in, 1 byte: AA"},
        {5, AT(1001, 0x1100),
         "00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 00 01 02 03 "
         "04 05 06 07 08 09 0A 0B 0C 0D 0E 0F",
         -1,
         "FPWR 03E9:1100, 48 bytes: 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 00 01 02 03 04 05 06 07 08 09 0A "
         "0B 0C 0D 0E 0F 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F"},
        {5, AT(1001, 0x1100),
         "00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 00 01 02 03 "
         "04 05 06 07 08 09 0A 0B 0C 0D 0E 0F FF",
         -1,
         "FPWR 03E9:1100, 49 bytes: 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 00 01 02 03 04 05 06 07 08 09 0A "
         "0B 0C 0D 0E 0F 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F ... (49 bytes)"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect(&rows[i]);
}

static void AL_control_and_AL_status_are_states_in_words(void **state)
{
    static const row_t rows[] = {
        {5, AT(1001, 0x0120), "02 00", -1, "FPWR 03E9:0120 AL control, 2 bytes: 02 00 | PREOP"},
        {5, AT(1001, 0x0120), "11", -1, "FPWR 03E9:0120 AL control, 1 byte: 11 | INIT, acknowledge"},
        {4, AT(1001, 0x0120), "08 00", 1, "FPRD 03E9:0120 AL control, 2 bytes, WKC 1: 08 00 | OP"},
        {4, AT(1001, 0x0130), "08 00", 1, "FPRD 03E9:0130 AL status, 2 bytes, WKC 1: 08 00 | OP"},
        {4, AT(1001, 0x0130), "14 00 00 00 1B", 1,
         "FPRD 03E9:0130 AL status, 5 bytes, WKC 1: 14 00 00 00 1B | SAFEOP + error"},
        {4, AT(1001, 0x0130), "14 00 00 00 1B 00", 1,
         "FPRD 03E9:0130 AL status, 6 bytes, WKC 1: 14 00 00 00 1B 00 | SAFEOP + error, code 0x001B"},
        {4, AT(1001, 0x0131), "08 00", 1, "FPRD 03E9:0131 AL status, 2 bytes, WKC 1: 08 00"},
        {10, 0x01300000, "08 00 00 00 1B 00", 1, "LRD logical 0x01300000, 6 bytes, WKC 1: 08 00 00 00 1B 00"},
        {12, 0x01300000, "08 00 00 00 1B 00", 1, "LRW logical 0x01300000, 6 bytes, WKC 1: 08 00 00 00 1B 00"},
        {5, AT(1001, 0x0120), "", -1, "FPWR 03E9:0120 AL control, 0 bytes:"},
        {4, AT(1001, 0x0130), "", 1, "FPRD 03E9:0130 AL status, 0 bytes, WKC 1:"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect(&rows[i]);
}

static void a_mail_has_its_service_in_words(void **state)
{
    static const row_t rows[] = {
        {5, AT(1001, 0x1000), "0A 00 00 00 00 13 00 20 40 18 10 01 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 1: CoE SDO request upload 1018h:01 | 0A 00 "
         "00 00 00 13 00 20 40 18 10 01 00 00 00 00"},
        {5, AT(1001, 0x1000), "0A 00 00 00 00 13 00 20 50 18 10 01 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 1: CoE SDO request upload 1018h:01 complete "
         "| 0A 00 00 00 00 13 00 20 50 18 10 01 00 00 00 00"},
        {4, AT(1001, 0x1400), "0A 00 00 00 00 23 00 30 4F 18 10 01 00 00 00 00", 1,
         "FPRD 03E9:1400 mailbox in, 16 bytes, WKC 1 | mail of 10 bytes, counter 2: CoE SDO response upload 1018h:01 | "
         "0A 00 00 00 00 23 00 30 4F 18 10 01 00 00 00 00"},
        {4, AT(1001, 0x1400), "0A 00 00 00 00 23 00 30 80 18 10 01 02 00 01 06", 1,
         "FPRD 03E9:1400 mailbox in, 16 bytes, WKC 1 | mail of 10 bytes, counter 2: CoE SDO response abort 1018h:01 "
         "code 0x06010002 | 0A 00 00 00 00 23 00 30 80 18 10 01 02 00 01 06"},
        {5, AT(1001, 0x1000), "0A 00 00 00 00 73 00 20 2F 12 1C 00 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 7: CoE SDO request download 1C12h:00 | 0A "
         "00 00 00 00 73 00 20 2F 12 1C 00 00 00 00 00"},
        {5, AT(1001, 0x1000), "0A 00 00 00 00 73 00 20 31 12 1C 00 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 7: CoE SDO request download 1C12h:00 "
         "complete | 0A 00 00 00 00 73 00 20 31 12 1C 00 00 00 00 00"},
        {4, AT(1001, 0x1400), "0A 00 00 00 00 73 00 30 60 12 1C 02 00 00 00 00", 1,
         "FPRD 03E9:1400 mailbox in, 16 bytes, WKC 1 | mail of 10 bytes, counter 7: CoE SDO response downloaded "
         "1C12h:02 | 0A 00 00 00 00 73 00 30 60 12 1C 02 00 00 00 00"},
        {5, AT(1001, 0x1000), "0A 00 00 00 00 73 00 20 60 00 00 00 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 7: CoE SDO request next segment | 0A 00 00 "
         "00 00 73 00 20 60 00 00 00 00 00 00 00"},
        {5, AT(1001, 0x1000), "0A 00 00 00 00 73 00 20 11 00 00 00 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 7: CoE SDO request segment, toggle 1, last "
         "| 0A 00 00 00 00 73 00 20 11 00 00 00 00 00 00 00"},
        {5, AT(1001, 0x1000), "0A 00 00 00 00 73 00 20 00 00 00 00 00 00 00 00", -1,
         "FPWR 03E9:1000 mailbox out, 16 bytes | mail of 10 bytes, counter 7: CoE SDO request segment, toggle 0 | 0A "
         "00 00 00 00 73 00 20 00 00 00 00 00 00 00 00"},
        {4, AT(1001, 0x1400), "0A 00 00 00 00 73 00 30 20 00 00 00 00 00 00 00", 1,
         "FPRD 03E9:1400 mailbox in, 16 bytes, WKC 1 | mail of 10 bytes, counter 7: CoE SDO response segment taken | "
         "0A 00 00 00 00 73 00 30 20 00 00 00 00 00 00 00"},
        {4, AT(1001, 0x1400), "09 00 00 00 00 73 00 30 20 00 00 00 00 00 00 00", 1,
         "FPRD 03E9:1400 mailbox in, 16 bytes, WKC 1 | mail of 9 bytes, counter 7: CoE SDO response  | 09 00 00 00 00 "
         "73 00 30 20 00 00 00 00 00 00"},
        {4, AT(1001, 0x1400), "0A 00 00 00 00 73 00 10 00 82 00 00 00 00 00 00", 1,
         "FPRD 03E9:1400 mailbox in, 16 bytes, WKC 1 | mail of 10 bytes, counter 7: CoE emergency code 0x8200 | 0A 00 "
         "00 00 00 73 00 10 00 82 00 00 00 00 00 00"},
        {4, AT(1001, 0x1400), "04 00 00 00 00 73 00 10 00 82", 1,
         "FPRD 03E9:1400 mailbox in, 10 bytes, WKC 1 | mail of 4 bytes, counter 7: CoE emergency code 0x8200 | 04 00 "
         "00 "
         "00 00 73 00 10 00 82"},
        {4, AT(1001, 0x1400), "03 00 00 00 00 73 00 10 00 82", 1,
         "FPRD 03E9:1400 mailbox in, 10 bytes, WKC 1 | mail of 3 bytes, counter 7: CoE emergency  | 03 00 00 00 00 73 "
         "00 10 00"},
        {4, AT(1001, 0x1400), "06 00 00 00 00 73 00 80 82 00 01 02", 1,
         "FPRD 03E9:1400 mailbox in, 12 bytes, WKC 1 | mail of 6 bytes, counter 7: CoE information opcode 2, 513 "
         "fragments left | 06 00 00 00 00 73 00 80 82 00 01 02"},
        {4, AT(1001, 0x1400), "06 00 00 00 00 73 00 80 FF 00 01 02", 1,
         "FPRD 03E9:1400 mailbox in, 12 bytes, WKC 1 | mail of 6 bytes, counter 7: CoE information opcode 127, 513 "
         "fragments left | 06 00 00 00 00 73 00 80 FF 00 01 02"},
        {4, AT(1001, 0x1400), "05 00 00 00 00 73 00 80 82 00 01 02", 1,
         "FPRD 03E9:1400 mailbox in, 12 bytes, WKC 1 | mail of 5 bytes, counter 7: CoE information  | 05 00 00 00 00 "
         "73 00 80 82 00 01"},
        {4, AT(1001, 0x1400), "02 00 00 00 00 73 00 90", 1,
         "FPRD 03E9:1400 mailbox in, 8 bytes, WKC 1 | mail of 2 bytes, counter 7: CoE of an unknown service  | 02 00 "
         "00 00 00 73 00 90"},
        {4, AT(1001, 0x1400), "01 00 00 00 00 73 00 90", 1,
         "FPRD 03E9:1400 mailbox in, 8 bytes, WKC 1 | mail of 1 bytes, counter 7:  type 3 | 01 00 00 00 00 73 00"},
        {4, AT(1001, 0x1400), "04 00 00 00 00 00 01 00 02 00", 1,
         "FPRD 03E9:1400 mailbox in, 10 bytes, WKC 1 | mail of 4 bytes, counter 0: error, detail 0x0002 | 04 00 00 00 "
         "00 00 01 00 02 00"},
        {4, AT(1001, 0x1400), "03 00 00 00 00 00 01 00 02 00", 1,
         "FPRD 03E9:1400 mailbox in, 10 bytes, WKC 1 | mail of 3 bytes, counter 0: error type 0 | 03 00 00 00 00 00 01 "
         "00 02"},
        {4, AT(1001, 0x1400), "02 00 00 00 00 02 01 00", 1,
         "FPRD 03E9:1400 mailbox in, 8 bytes, WKC 1 | mail of 2 bytes, counter 0: EoE type 2 | 02 00 00 00 00 02 01 "
         "00"},
        {4, AT(1001, 0x1400), "02 00 00 00 00 04 01 00", 1,
         "FPRD 03E9:1400 mailbox in, 8 bytes, WKC 1 | mail of 2 bytes, counter 0: FoE type 4 | 02 00 00 00 00 04 01 "
         "00"},
        {4, AT(1001, 0x1400), "02 00 00 00 00 0F 01 00", 1,
         "FPRD 03E9:1400 mailbox in, 8 bytes, WKC 1 | mail of 2 bytes, counter 0:  type 15 | 02 00 00 00 00 0F 01 00"},
        {4, AT(1001, 0x1400), "FF 00 00 00 00 0F 01 00", 1,
         "FPRD 03E9:1400 mailbox in, 8 bytes, WKC 1 | mail of 255 bytes, counter 0:  type 15 | FF 00 00 00 00 0F 01 "
         "00"},
        {4, AT(1001, 0x1400), "00 00 00 00 00 0F", 1,
         "FPRD 03E9:1400 mailbox in, 6 bytes, WKC 1 | mail of 0 bytes, counter 0:  type 15 | 00 00 00 00 00 0F"},
        {9, AT(0, 0x1000), "02 00 00 00 00 04 01 00", -1,
         "BRW 0000:1000 mailbox out, 8 bytes | mail of 2 bytes, counter 0: FoE type 4 | 02 00 00 00 00 04 01 00"},
        {13, AT(1, 0x1400), "02 00 00 00 00 04 01 00", 1,
         "ARMW 0001:1400 mailbox in, 8 bytes, WKC 1 | mail of 2 bytes, counter 0: FoE type 4 | 02 00 00 00 00 04 01 "
         "00"},
        {4, AT(1001, 0x1400), "00 00 00 00 00", 1, "FPRD 03E9:1400 mailbox in, 5 bytes, WKC 1: 00 00 00 00 00"},
        {5, AT(1001, 0x1400), "00 00 00 00 00 00", 1, "FPWR 03E9:1400 mailbox in, 6 bytes, WKC 1"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect(&rows[i]);
}

static void expect_frame(const uint8_t *frame, size_t size, bool sent, const char *wanted)
{
    char text[TEXT];
    ect_decode_frame(&mailboxes, frame, size, sent, text, sizeof text);
    if (strcmp(text, wanted) != 0)
        fail_msg("expected %s\n  got      %s", wanted, text);
}

static void a_frame_has_a_line_for_each_datagram_and_ends_where_its_bytes_do(void **state)
{
    uint8_t frame[ROOM] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0x88, 0xA4, 0x19, 0x10};
    size_t size = 16;
    (void)state;
    size += datagram(frame + size, 4, AT(1001, 0x0130), "00 00", 1, true);
    const size_t first = size;
    size += datagram(frame + size, 11, 0x00010000, "AA", 1, false);
    expect_frame(frame, size, true,
                 "FPRD 03E9:0130 AL status, 2 bytes\n"
                 "LWR logical 0x00010000, 1 byte: AA");
    expect_frame(frame, size, false,
                 "FPRD 03E9:0130 AL status, 2 bytes, WKC 1: 00 00 | state 0\n"
                 "LWR logical 0x00010000, 1 byte, WKC 1");
    expect_frame(frame, size + 40, true,
                 "FPRD 03E9:0130 AL status, 2 bytes\n"
                 "LWR logical 0x00010000, 1 byte: AA");
    expect_frame(frame, size - 1, true,
                 "FPRD 03E9:0130 AL status, 2 bytes\n"
                 "cut off: 0B 00 00 00 01 00 01 00 00 00 AA 01");
    expect_frame(frame, first + 11, true,
                 "FPRD 03E9:0130 AL status, 2 bytes\n"
                 "cut off: 0B 00 00 00 01 00 01 00 00 00 AA");
    expect_frame(frame, first, true,
                 "FPRD 03E9:0130 AL status, 2 bytes\n"
                 "cut off:");
    expect_frame(frame, 16, true, "cut off:");
    expect_frame(frame, 15, true, "frame of 15 bytes: 01 02 03 04 05 06 07 08 09 0A 0B 0C 88 A4 19");
    frame[15] = 0x40;
    expect_frame(frame, 16, true, "frame of 16 bytes: 01 02 03 04 05 06 07 08 09 0A 0B 0C 88 A4 19 40");
    frame[15] = 0x10;
    frame[13] = 0xA5;
    expect_frame(frame, 17, true, "frame of 17 bytes: 01 02 03 04 05 06 07 08 09 0A 0B 0C 88 A5 19 10 04");
}

/* The bits of a length are no mark of a further datagram. */
static void a_long_datagram_is_the_last_one_without_its_mark(void **state)
{
    static const size_t lengths[] = {255, 256, 511, 512, 1023, 1024, 1400};
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        uint8_t frame[ROOM] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0x88, 0xA4, 0, 0x10, 10};
        char wanted[100];
        frame[16 + 6] = (uint8_t)lengths[i];
        frame[16 + 7] = (uint8_t)(lengths[i] >> 8);
        (void)snprintf(wanted, sizeof wanted, "LRD logical 0x00000000, %zu bytes", lengths[i]);
        expect_frame(frame, 16 + 10 + lengths[i] + 2, true, wanted);
    }
}

/* A text that is full ends with its last whole character. */
static void a_text_ends_in_its_room(void **state)
{
    static const char whole[] = "BRD 0000:0130 AL status, 2 bytes";
    uint8_t bytes[ROOM] = {0};
    (void)state;
    char none[2] = "##";
    ect_decode_frame(&mailboxes, bytes, 0, true, none, 1);
    assert_memory_equal(none, "\0#", 2);
    (void)datagram(bytes, 7, AT(0, 0x0130), "00 00", 0, false);
    for (size_t room = 1; room <= sizeof whole + 1; room++) {
        char text[sizeof whole + 2];
        memset(text, '#', sizeof text);
        ect_decode_datagram(&mailboxes, bytes, 2, true, text, room);
        assert_int_equal(strlen(text), room < sizeof whole ? room - 1 : sizeof whole - 1);
        assert_memory_equal(text, whole, strlen(text));
        assert_int_equal(text[sizeof whole + 1], '#');
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_command_has_its_place_and_the_data_that_travel),
        cmocka_unit_test(AL_control_and_AL_status_are_states_in_words),
        cmocka_unit_test(a_mail_has_its_service_in_words),
        cmocka_unit_test(a_frame_has_a_line_for_each_datagram_and_ends_where_its_bytes_do),
        cmocka_unit_test(a_long_datagram_is_the_last_one_without_its_mark),
        cmocka_unit_test(a_text_ends_in_its_room),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("frames as text", tests, NULL, NULL);
}
