/* SPDX-License-Identifier: MIT */
/* The SDO server on the wire: exact requests and replies, Complete Access, segments, refusals (spec E.1 to E.4, L9). */
#define _XOPEN_SOURCE 700
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

#include "devices/eclink/eclink.h"
#include "support/every.h"
#include "support/hex.h"
#include "support/testdev.h"
#include "support/wire.h"

enum {
    HEADER = 6,
    OUT_LENGTH = 128,
    IN_LENGTH = 128,
    SHORTEST_IN = 34,
    LONGEST_IN = 256,
    OCTETS = 1000,
    TEXT_ROOM = 20
};

#define TOGGLE_CODE  0x05030000u
#define COMMAND_CODE 0x05040001u
#define UNSUPPORTED  0x06010000u
#define WRITE_ONLY   0x06010001u
#define READ_ONLY    0x06010002u
#define VARIABLE     0x06010004u
#define NO_OBJECT    0x06020000u
#define TOO_LONG     0x06070012u
#define TOO_SHORT    0x06070013u
#define NO_SUBINDEX  0x06090011u
#define TOO_HIGH     0x06090031u
#define TOO_LOW      0x06090032u
#define WRONG_STATE  0x08000022u

/* --- bytes as text ------------------------------------------------------------------------------------------------ */

static const char *hex(const uint8_t *bytes, int count, char *text)
{
    text[0] = 0;
    if (count < 0)
        return "no mail";
    for (int i = 0; i < count && i < 300; i++)
        sprintf(text + (size_t)3 * (size_t)i, "%02X ", bytes[i]);
    return text;
}

/* --- a session: SM1 of any length --------------------------------------------------------------------------------- */

static void fill(testdev_t *t)
{
    t->u32 = 0x11223344;
    memset(t->text, 0, sizeof t->text);
    memcpy(t->text, "abc", 3);
    for (unsigned int i = 0; i < OCTETS; i++)
        t->octets[i] = (uint8_t)(i * 7 + 3);
    t->write_only = 0x5A5A;
    t->preop_only = 7;
    t->limited = 5;
    t->record_bool = 1;
    t->record_bit3 = 5;
    t->record_bit5 = 0x15;
    t->record_u16 = 0xABCD;
    t->record_ro = 0x77;
    t->record_u32 = 0xDEADBEEF;
    for (unsigned int i = 0; i < 4; i++)
        t->array[i] = (uint16_t)(0x1111 * (i + 1));
    memcpy(t->sparse, "\x11\x33\x55", 3);
    t->u64 = 0x8877665544332211u;
}

static testdev_t *open_session(wire_t *w, const ect_device_t *device, uint16_t in_length)
{
    wire_open_one(w, device);
    wire_set_sm(w, 0, 0, device->sm[0].start, device->sm[0].length, device->sm[0].control);
    wire_set_sm(w, 0, 1, device->sm[1].start, in_length, device->sm[1].control);
    assert_int_equal(wire_al(w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
    testdev_t *t = testdev_of(w, 0);
    fill(t);
    return t;
}

static testdev_t *open_testdev(wire_t *w)
{
    return open_session(w, &testdev, IN_LENGTH);
}

/* @return length of the service data, or -1 when SM1 is empty; *mail has the whole mail */
static int fetch(wire_t *w, uint16_t in_length, uint8_t *mail)
{
    if ((wire_read8(w, 0, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS) & ECT_SM_STATUS_FULL) == 0)
        return -1;
    assert_int_equal(wire_read(w, 0, wire_device(w, 0)->sm[1].start, mail, in_length), 1);
    int length = ect_load_le16(mail);
    assert_true(length <= in_length - HEADER);
    return length;
}

static void put(wire_t *w, uint8_t type, const uint8_t *payload, uint16_t length)
{
    uint8_t mail[1486] = {0};
    w->mail_counter = (uint8_t)(w->mail_counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (w->mail_counter << 4));
    memcpy(mail + HEADER, payload, length);
    assert_int_equal(wire_mail_send(w, 0, mail, (uint16_t)(HEADER + length)), 1);
}

/* Sends a CoE request and receives the reply; `reply` begins at the CoE header. */
static int ask(wire_t *w, uint16_t in_length, const uint8_t *payload, uint16_t length, uint8_t *reply)
{
    uint8_t mail[1486] = {0};
    put(w, 3, payload, length);
    int got = fetch(w, in_length, mail);
    memcpy(reply, mail + HEADER, LONGEST_IN);
    if (got >= 0 && (mail[5] & 0x0F) != 3)
        return -2;
    return got;
}

static int initiate(wire_t *w, uint8_t command, uint16_t index, uint8_t subindex, uint32_t data, uint8_t *reply)
{
    uint8_t request[10] = {0, 0x20, command};
    ect_store_le16(request + 3, index);
    request[5] = subindex;
    ect_store_le32(request + 6, data);
    return ask(w, IN_LENGTH, request, sizeof request, reply);
}

static void expect_abort(const char *what, const uint8_t *r, int length, uint16_t index, uint8_t subindex,
                         uint32_t code)
{
    uint8_t want[10] = {0x00, 0x20, 0x80};
    char text[1000];
    ect_store_le16(want + 3, index);
    want[5] = subindex;
    ect_store_le32(want + 6, code);
    if (length != 10 || memcmp(r, want, 10) != 0)
        fail_msg("%s: expected the abort %08X of %04Xh:%u, got %s", what, code, index, subindex, hex(r, length, text));
}

/* --- dialogues, byte by byte -------------------------------------------------------------------------------------- */

/* A step is a request and its reply, both from the CoE header on. Reply NULL: none. "E nn": mailbox error, detail nn.
 */
typedef struct step {
    const char *request, *reply;
} step_t;

typedef struct dialogue {
    const char *title;
    step_t steps[8];
} dialogue_t;

static void run_step(wire_t *w, const char *title, const step_t *step)
{
    uint8_t request[OUT_LENGTH], want[OUT_LENGTH] = {0}, mail[IN_LENGTH] = {0};
    char text[1000];
    put(w, 3, request, from_hex(step->request, request));
    int got = fetch(w, IN_LENGTH, mail);
    int expected = -1;
    uint8_t type = 3;
    if (step->reply && step->reply[0] == 'E') {
        type = 0;
        want[0] = 1;
        (void)from_hex(step->reply + 1, want + 2);
        expected = 4;
    } else if (step->reply) {
        expected = from_hex(step->reply, want);
    }
    bool good =
        got == expected && (got < 0 || ((mail[5] & 0x0F) == type && memcmp(mail + HEADER, want, (size_t)got) == 0));
    if (!good)
        fail_msg("%s: request %s: expected %s, got %s (type %u)", title, step->request,
                 step->reply ? step->reply : "no mail", hex(mail + HEADER, got, text), mail[5] & 0x0F);
}

static void run_dialogues(const dialogue_t *dialogues, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        wire_t w;
        (void)open_testdev(&w);
        for (const step_t *step = dialogues[i].steps; step->request; step++)
            run_step(&w, dialogues[i].title, step);
        wire_close(&w);
    }
}

#define RUN(table) run_dialogues(table, sizeof(table) / sizeof((table)[0]))

static void expedited_and_normal_upload(void **state)
{
    static const dialogue_t table[] = {
        {"4 bytes", {{"0020 40 0020 00 00000000", "0030 43 0020 00 44332211"}}},
        {"3 bytes", {{"0020 40 0120 00 00000000", "0030 47 0120 00 61626300"}}},
        {"2 bytes", {{"0020 40 0420 00 00000000", "0030 4B 0420 00 07000000"}}},
        {"2 bytes of an array", {{"0020 40 0720 04 00000000", "0030 4B 0720 04 44440000"}}},
        {"2 bytes, negative limit object", {{"0020 40 0520 00 00000000", "0030 4B 0520 00 05000000"}}},
        {"1 byte", {{"0020 40 0820 03 00000000", "0030 4F 0820 03 33000000"}}},
        {"1 bit", {{"0020 40 0620 01 00000000", "0030 4F 0620 01 01000000"}}},
        {"3 bits", {{"0020 40 0620 02 00000000", "0030 4F 0620 02 05000000"}}},
        {"5 bits", {{"0020 40 0620 03 00000000", "0030 4F 0620 03 15000000"}}},
        {"8 bytes", {{"0020 40 0920 00 00000000", "0030 41 0920 00 08000000 1122334455667788"}}},
        {"constant", {{"0020 40 0010 00 00000000", "0030 43 0010 00 78563412"}}},
        {"constant text",
         {{"0020 40 0810 00 00000000", "0030 41 0810 00 12000000 65637477696E2074657374 20646576696365"}}},
        {"sub-index 0 of a record", {{"0020 40 1810 00 00000000", "0030 4F 1810 00 04000000"}}},
        {"identity", {{"0020 40 1810 03 00000000", "0030 43 1810 03 02000100"}}},
        {"data of the request are ignored", {{"0020 40 0020 00 FFFFFFFF", "0030 43 0020 00 44332211"}}},
        {"a request longer than need be", {{"0020 40 0020 00 00000000 0000000000000000", "0030 43 0020 00 44332211"}}},
    };
    (void)state;
    RUN(table);
}

static void expedited_and_normal_download(void **state)
{
    static const dialogue_t table[] = {
        {"4 bytes, 23h",
         {{"0020 23 0020 00 78563412", "0030 60 0020 00 00000000"},
          {"0020 40 0020 00 00000000", "0030 43 0020 00 78563412"}}},
        {"3 bytes, 27h",
         {{"0020 27 0120 00 58595A00", "0030 60 0120 00 00000000"},
          {"0020 40 0120 00 00000000", "0030 47 0120 00 58595A00"}}},
        {"2 bytes, 2Bh",
         {{"0020 2B 0720 02 EFBE0000", "0030 60 0720 02 00000000"},
          {"0020 40 0720 02 00000000", "0030 4B 0720 02 EFBE0000"}}},
        {"1 byte, 2Fh",
         {{"0020 2F 0820 05 A5000000", "0030 60 0820 05 00000000"},
          {"0020 40 0820 05 00000000", "0030 4F 0820 05 A5000000"}}},
        {"size not given, 22h, 4 bytes",
         {{"0020 22 0020 00 01020304", "0030 60 0020 00 00000000"},
          {"0020 40 0020 00 00000000", "0030 43 0020 00 01020304"}}},
        {"size not given, 22h, 2 bytes count",
         {{"0020 22 0720 01 0102FFFF", "0030 60 0720 01 00000000"},
          {"0020 40 0720 01 00000000", "0030 4B 0720 01 01020000"}}},
        {"normal, 4 bytes",
         {{"0020 21 0020 00 04000000 0A0B0C0D", "0030 60 0020 00 00000000"},
          {"0020 40 0020 00 00000000", "0030 43 0020 00 0A0B0C0D"}}},
        {"normal, 8 bytes",
         {{"0020 21 0920 00 08000000 0102030405060708", "0030 60 0920 00 00000000"},
          {"0020 40 0920 00 00000000", "0030 41 0920 00 08000000 0102030405060708"}}},
        {"normal, 1 byte",
         {{"0020 21 0820 01 01000000 7E", "0030 60 0820 01 00000000"},
          {"0020 40 0820 01 00000000", "0030 4F 0820 01 7E000000"}}},
        {"bits alone",
         {{"0020 2F 0620 02 03000000", "0030 60 0620 02 00000000"},
          {"0020 40 0620 02 00000000", "0030 4F 0620 02 03000000"},
          {"0020 40 0620 01 00000000", "0030 4F 0620 01 01000000"},
          {"0020 40 0620 03 00000000", "0030 4F 0620 03 15000000"}}},
        {"a text shorter than its room",
         {{"0020 21 0120 00 05000000 48616C6C6F", "0030 60 0120 00 00000000"},
          {"0020 40 0120 00 00000000", "0030 41 0120 00 05000000 48616C6C6F"}}},
        {"a text as long as its room",
         {{"0020 21 0120 00 14000000 4142434445464748494A4B4C4D4E4F5051525354", "0030 60 0120 00 00000000"},
          {"0020 40 0120 00 00000000", "0030 41 0120 00 14000000 4142434445464748494A4B4C4D4E4F5051525354"}}},
        {"a write-only value is taken", {{"0020 2B 0320 00 34120000", "0030 60 0320 00 00000000"}}},
    };
    (void)state;
    RUN(table);
}

static void complete_access_upload(void **state)
{
    static const dialogue_t table[] = {
        {"array from 0", {{"0020 50 0720 00 00000000", "0030 51 0720 00 0A000000 0400 1111 2222 3333 4444"}}},
        {"array from 1", {{"0020 50 0720 01 00000000", "0030 51 0720 01 08000000 1111 2222 3333 4444"}}},
        {"record with bits from 0",
         {{"0020 50 0620 00 00000000", "0030 51 0620 00 0B000000 0600 5B01 CDAB 77 EFBEADDE"}}},
        {"record with bits from 1", {{"0020 50 0620 01 00000000", "0030 51 0620 01 09000000 5B01 CDAB 77 EFBEADDE"}}},
        {"sparse record from 0", {{"0020 50 0820 00 00000000", "0030 51 0820 00 05000000 0500 11 33 55"}}},
        {"sparse record from 1: 3 bytes, expedited", {{"0020 50 0820 01 00000000", "0030 57 0820 01 11335500"}}},
        {"VAR, no pad", {{"0020 50 0020 00 00000000", "0030 53 0020 00 44332211"}}},
        {"VAR of 8 bytes", {{"0020 50 0920 00 00000000", "0030 51 0920 00 08000000 1122334455667788"}}},
        {"constants", {{"0020 50 001C 00 00000000", "0030 51 001C 00 06000000 0400 01 02 03 04"}}},
        {"assignment", {{"0020 50 121C 00 00000000", "0030 53 121C 00 01000016"}}},
        {"assignment from 1", {{"0020 50 131C 01 00000000", "0030 5B 131C 01 001A0000"}}},
        {"sub-index 2", {{"0020 50 0720 02 00000000", "0020 80 0720 02 00000106"}}},
        {"sub-index 255", {{"0020 50 0720 FF 00000000", "0020 80 0720 FF 00000106"}}},
        {"a text", {{"0020 50 0120 00 00000000", "0020 80 0120 00 04000106"}}},
        {"a constant text", {{"0020 50 0810 00 00000000", "0020 80 0810 00 04000106"}}},
        {"no such object", {{"0020 50 0A20 00 00000000", "0020 80 0A20 00 00000206"}}},
        {"a VAR from 1", {{"0020 50 0020 01 00000000", "0020 80 0020 01 11000906"}}},
        {"a write-only object", {{"0020 50 0320 00 00000000", "0020 80 0320 00 01000106"}}},
    };
    (void)state;
    RUN(table);
}

static void complete_access_download(void **state)
{
    static const dialogue_t table[] = {
        {"array from 0",
         {{"0020 31 0720 00 0A000000 0400 0102 0304 0506 0708", "0030 70 0720 00 00000000"},
          {"0020 50 0720 01 00000000", "0030 51 0720 01 08000000 0102 0304 0506 0708"}}},
        {"array from 1",
         {{"0020 31 0720 01 08000000 A1A2 A3A4 A5A6 A7A8", "0030 70 0720 01 00000000"},
          {"0020 50 0720 00 00000000", "0030 51 0720 00 0A000000 0400 A1A2 A3A4 A5A6 A7A8"}}},
        {"record with bits: the read-only element is skipped",
         {{"0020 31 0620 00 0B000000 0600 A400 3412 99 78563412", "0030 70 0620 00 00000000"},
          {"0020 50 0620 01 00000000", "0030 51 0620 01 09000000 A400 3412 77 78563412"}}},
        {"record with bits from 1",
         {{"0020 31 0620 01 09000000 FF01 FFFF 00 FFFFFFFF", "0030 70 0620 01 00000000"},
          {"0020 50 0620 01 00000000", "0030 51 0620 01 09000000 FF01 FFFF 77 FFFFFFFF"}}},
        {"padding bits are of no interest",
         {{"0020 31 0620 01 02000000 5BFF", "0030 70 0620 01 00000000"},
          {"0020 50 0620 01 00000000", "0030 51 0620 01 09000000 5B01 CDAB 77 EFBEADDE"}}},
        {"sparse record",
         {{"0020 31 0820 00 05000000 0500 A1 A3 A5", "0030 70 0820 00 00000000"},
          {"0020 50 0820 01 00000000", "0030 57 0820 01 A1A3A500"}}},
        {"sparse record from 1, expedited",
         {{"0020 37 0820 01 010305 00", "0030 70 0820 01 00000000"},
          {"0020 50 0820 01 00000000", "0030 57 0820 01 01030500"}}},
        {"VAR, expedited",
         {{"0020 33 0020 00 0D0C0B0A", "0030 70 0020 00 00000000"},
          {"0020 40 0020 00 00000000", "0030 43 0020 00 0D0C0B0A"}}},
        {"shorter by two whole elements",
         {{"0020 31 0720 01 04000000 F1F2 F3F4", "0030 70 0720 01 00000000"},
          {"0020 50 0720 01 00000000", "0030 51 0720 01 08000000 F1F2 F3F4 3333 4444"}}},
        {"sub-index 0 and its pad only",
         {{"0020 31 0720 00 02000000 0400", "0030 70 0720 00 00000000"},
          {"0020 50 0720 01 00000000", "0030 51 0720 01 08000000 1111 2222 3333 4444"}}},
        {"ends inside an element: nothing is changed",
         {{"0020 31 0720 01 05000000 F1F2 F3F4 F5", "0020 80 0720 01 13000706"},
          {"0020 50 0720 01 00000000", "0030 51 0720 01 08000000 1111 2222 3333 4444"}}},
        {"ends inside the last element",
         {{"0020 31 0620 01 08000000 FF01 FFFF 00 FFFFFF", "0020 80 0620 01 13000706"},
          {"0020 50 0620 01 00000000", "0030 51 0620 01 09000000 5B01 CDAB 77 EFBEADDE"}}},
        {"one byte too long: nothing is changed",
         {{"0020 31 0720 01 09000000 0000 0000 0000 0000 00", "0020 80 0720 01 12000706"},
          {"0020 50 0720 01 00000000", "0030 51 0720 01 08000000 1111 2222 3333 4444"}}},
        {"one byte too long from 0",
         {{"0020 31 0720 00 0B000000 0400 0000 0000 0000 0000 00", "0020 80 0720 00 12000706"}}},
        {"sub-index 2", {{"0020 31 0720 02 04000000 0000 0000", "0020 80 0720 02 00000106"}}},
        {"a text", {{"0020 33 0120 00 41424344", "0020 80 0120 00 04000106"}}},
        {"no such object", {{"0020 33 0A20 00 41424344", "0020 80 0A20 00 00000206"}}},
        {"read-only object", {{"0020 33 1810 01 41424344", "0020 80 1810 01 02000106"}}},
        {"read-only VAR", {{"0020 33 0010 00 41424344", "0020 80 0010 00 02000106"}}},
        {"write-only VAR", {{"0020 3B 0320 00 41420000", "0030 70 0320 00 00000000"}}},
    };
    (void)state;
    RUN(table);
}

static void refused_requests(void **state)
{
    static const dialogue_t table[] = {
        {"upload of an unknown index", {{"0020 40 0A20 00 00000000", "0020 80 0A20 00 00000206"}}},
        {"upload of index 0", {{"0020 40 0000 00 00000000", "0020 80 0000 00 00000206"}}},
        {"upload of index FFFFh", {{"0020 40 FFFF 00 00000000", "0020 80 FFFF 00 00000206"}}},
        {"download to an unknown index", {{"0020 23 0A20 00 00000000", "0020 80 0A20 00 00000206"}}},
        {"upload of a missing sub-index", {{"0020 40 0720 05 00000000", "0020 80 0720 05 11000906"}}},
        {"upload of a gap", {{"0020 40 0820 02 00000000", "0020 80 0820 02 11000906"}}},
        {"upload of sub-index 255", {{"0020 40 0820 FF 00000000", "0020 80 0820 FF 11000906"}}},
        {"upload of sub-index 1 of a VAR", {{"0020 40 0020 01 00000000", "0020 80 0020 01 11000906"}}},
        {"download to a gap", {{"0020 2F 0820 04 00000000", "0020 80 0820 04 11000906"}}},
        {"upload of write-only", {{"0020 40 0320 00 00000000", "0020 80 0320 00 01000106"}}},
        {"download to read-only", {{"0020 23 0010 00 00000000", "0020 80 0010 00 02000106"}}},
        {"download to a read-only element", {{"0020 2F 0620 05 00000000", "0020 80 0620 05 02000106"}}},
        {"download to sub-index 0", {{"0020 2F 0720 00 04000000", "0020 80 0720 00 02000106"}}},
        {"download to the fixed mapping", {{"0020 23 0016 01 08000070", "0020 80 0016 01 02000106"}}},
        {"download to the fixed assignment", {{"0020 2F 121C 00 00000000", "0020 80 121C 00 02000106"}}},
        {"one below the lowest value", {{"0020 2B 0520 00 9BFF0000", "0020 80 0520 00 32000906"}}},
        {"the lowest value", {{"0020 2B 0520 00 9CFF0000", "0030 60 0520 00 00000000"}}},
        {"the highest value", {{"0020 2B 0520 00 C8000000", "0030 60 0520 00 00000000"}}},
        {"one above the highest value", {{"0020 2B 0520 00 C9000000", "0020 80 0520 00 31000906"}}},
        {"command A0h", {{"0020 A0 0020 00 00000000", "0020 80 0020 00 01000405"}}},
        {"command C0h", {{"0020 C0 0720 03 00000000", "0020 80 0720 03 01000405"}}},
        {"command FFh", {{"0020 FF 0020 00 00000000", "0020 80 0020 00 01000405"}}},
        {"an upload segment without a transfer", {{"0020 60 0000 00 00000000", "0020 80 0000 00 01000405"}}},
        {"a download segment without a transfer", {{"0020 01 0000 00 00000000", "0020 80 0000 00 01000405"}}},
        {"an abort without a transfer gets no reply",
         {{"0020 80 0020 00 00000008", NULL}, {"0020 40 0020 00 00000000", "0030 43 0020 00 44332211"}}},
    };
    (void)state;
    RUN(table);
}

static void wrong_services_and_lengths(void **state)
{
    static const dialogue_t table[] = {
        {"service 0", {{"0000 40 0020 00 00000000", "E 0400"}}},
        {"service 1", {{"0010 40 0020 00 00000000", "E 0400"}}},
        {"service 3", {{"0030 40 0020 00 00000000", "E 0400"}}},
        {"service 4", {{"0040 40 0020 00 00000000", "E 0400"}}},
        {"service 7", {{"0070 40 0020 00 00000000", "E 0400"}}},
        {"service 9", {{"0090 40 0020 00 00000000", "E 0400"}}},
        {"service 15", {{"00F0 40 0020 00 00000000", "E 0400"}}},
        {"1 byte", {{"00", "E 0600"}}},
        {"CoE header only", {{"0020", "E 0600"}}},
        {"7 bytes of SDO",
         {{"0020 40 0020 00 000000", "E 0600"}, {"0020 40 0020 00 00000000", "0030 43 0020 00 44332211"}}},
        {"a wrong service does not end a transfer, which then continues",
         {{"0020 21 0120 00 09000000", "0030 60 0120 00 00000000"},
          {"0030 00 41424344454647", "E 0400"},
          {"0020 00 41424344454647", "0030 20 00000000000000"}}},
    };
    (void)state;
    RUN(table);
}

static const dialogue_t segments[] = {
    {"download: initiate without data, two segments",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 00 41424344454647", "0030 20 00000000000000"},
      {"0020 19 48494A 00000000", "0030 30 00000000000000"},
      {"0020 40 0120 00 00000000", "0030 41 0120 00 0A000000 4142434445464748494A"},
      {"0020 11 41424344454647", "0020 80 0000 00 01000405"}}},
    {"download: initiate with a part of the data",
     {{"0020 21 0920 00 08000000 010203", "0030 60 0920 00 00000000"},
      {"0020 05 0405060708 0000", "0030 20 00000000000000"},
      {"0020 40 0920 00 00000000", "0030 41 0920 00 08000000 0102030405060708"}}},
    {"download: more than 7 bytes in a segment",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 01 4142434445464748494A", "0030 20 00000000000000"},
      {"0020 40 0120 00 00000000", "0030 41 0120 00 0A000000 4142434445464748494A"}}},
    {"download: an empty last segment",
     {{"0020 21 0120 00 07000000", "0030 60 0120 00 00000000"},
      {"0020 00 41424344454647", "0030 20 00000000000000"},
      {"0020 1F 00000000000000", "0030 30 00000000000000"},
      {"0020 40 0120 00 00000000", "0030 41 0120 00 07000000 41424344454647"}}},
    {"download: a first segment with toggle 1",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 10 41424344454647", "0020 80 0120 00 00000305"},
      {"0020 00 41424344454647", "0020 80 0000 00 01000405"},
      {"0020 40 0120 00 00000000", "0030 47 0120 00 61626300"}}},
    {"download: the toggle does not alternate",
     {{"0020 21 0120 00 12000000", "0030 60 0120 00 00000000"},
      {"0020 00 41424344454647", "0030 20 00000000000000"},
      {"0020 00 41424344454647", "0020 80 0120 00 00000305"},
      {"0020 10 41424344454647", "0020 80 0000 00 01000405"}}},
    {"download: the last segment has too little data",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 00 41424344454647", "0030 20 00000000000000"},
      {"0020 1B 4849 0000000000", "0020 80 0120 00 13000706"},
      {"0020 19 48494A 00000000", "0020 80 0000 00 01000405"}}},
    {"download: a segment has too much data",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 00 41424344454647", "0030 20 00000000000000"},
      {"0020 17 48494A4B 000000", "0020 80 0120 00 12000706"},
      {"0020 19 48494A 00000000", "0020 80 0000 00 01000405"}}},
    {"download: the master aborts, then a clean new one",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 80 0120 00 00000008", NULL},
      {"0020 00 41424344454647", "0020 80 0000 00 01000405"},
      {"0020 27 0120 00 58595A00", "0030 60 0120 00 00000000"},
      {"0020 40 0120 00 00000000", "0030 47 0120 00 58595A00"}}},
    {"download: an upload segment in between ends it",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 60 0000 00 00000000", "0020 80 0120 00 01000405"},
      {"0020 00 41424344454647", "0020 80 0000 00 01000405"}}},
    {"download: an unknown command in between ends it",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 C0 0120 00 00000000", "0020 80 0120 00 01000405"},
      {"0020 00 41424344454647", "0020 80 0000 00 01000405"}}},
    {"download: a refused initiate in between ends it",
     {{"0020 21 0120 00 0A000000", "0030 60 0120 00 00000000"},
      {"0020 40 0A20 00 00000000", "0020 80 0A20 00 00000206"},
      {"0020 00 41424344454647", "0020 80 0000 00 01000405"}}},
    {"download: a new initiate in between replaces it, with a new toggle",
     {{"0020 21 0120 00 12000000", "0030 60 0120 00 00000000"},
      {"0020 00 41424344454647", "0030 20 00000000000000"},
      {"0020 21 0920 00 08000000", "0030 60 0920 00 00000000"},
      {"0020 01 0102030405060708", "0030 20 00000000000000"},
      {"0020 40 0920 00 00000000", "0030 41 0920 00 08000000 0102030405060708"}}},
    {"download: announced longer than the entry",
     {{"0020 21 0120 00 15000000", "0020 80 0120 00 12000706"},
      {"0020 00 41424344454647", "0020 80 0000 00 01000405"}}},
    {"download: announced length near 2^32",
     {{"0020 21 0120 00 FFFFFFFF", "0020 80 0120 00 12000706"},
      {"0020 31 0720 00 FFFFFFFF", "0020 80 0720 00 12000706"}}},
};

static void segment_dialogues(void **state)
{
    (void)state;
    RUN(segments);
}

/* --- uploads of every size in mailboxes of every length ----------------------------------------------------------- */

/* The mails of an upload according to E.2, compared one by one. */
static void expect_upload(wire_t *w, uint16_t in_length, uint16_t index, uint8_t subindex, bool complete,
                          const uint8_t *data, uint32_t size)
{
    uint8_t request[10] = {0, 0x20, (uint8_t)(complete ? 0x50 : 0x40)};
    uint8_t want[1486] = {0, 0x30}, got[1486];
    char text[1000];
    uint32_t room = in_length - 16u;
    uint32_t done = size < room ? size : room;
    ect_store_le16(request + 3, index);
    request[5] = subindex;
    memcpy(want + 3, request + 3, 3);
    if (size > 0 && size <= 4) {
        want[2] = (uint8_t)(0x43 | ((4 - size) << 2) | (complete ? 0x10 : 0));
        memcpy(want + 6, data, size);
        done = 0;
    } else {
        want[2] = complete ? 0x51 : 0x41;
        ect_store_le32(want + 6, size);
        memcpy(want + 10, data, done);
    }
    int length = ask(w, in_length, request, sizeof request, got);
    if (length != (int)(10 + done) || memcmp(want, got, 10 + done) != 0)
        fail_msg("%04Xh:%u of %u bytes, SM1 of %u: initiate is %s", index, subindex, size, in_length,
                 hex(got, length, text));
    uint8_t toggle = 0;
    for (done = size <= 4 ? size : done; done < size; toggle ^= 0x10) {
        uint32_t left = size - done;
        uint32_t piece = left < in_length - 9u ? left : in_length - 9u;
        uint32_t unused = piece < 7 ? 7 - piece : 0;
        uint8_t segment[10] = {0, 0x20, (uint8_t)(0x60 | toggle)};
        memset(want + 2, 0, sizeof want - 2);
        want[2] = (uint8_t)(toggle | (unused << 1) | (piece == left ? 1u : 0u));
        memcpy(want + 3, data + done, piece);
        length = ask(w, in_length, segment, sizeof segment, got);
        if (length != (int)(3 + piece + unused) || memcmp(want, got, 3 + piece + unused) != 0)
            fail_msg("%04Xh:%u of %u bytes, SM1 of %u: after %u bytes the segment is %s", index, subindex, size,
                     in_length, done, hex(got, length, text));
        done += piece;
    }
}

static void text_of_every_size(void **state)
{
    (void)state;
    for (uint16_t in_length = SHORTEST_IN; in_length <= SHORTEST_IN + 3; in_length++) {
        wire_t w;
        testdev_t *t = open_session(&w, &testdev, in_length);
        for (uint32_t size = 0; size <= TEXT_ROOM; size++) {
            memset(t->text, 0, sizeof t->text);
            for (uint32_t i = 0; i < size; i++)
                t->text[i] = (char)('A' + i);
            expect_upload(&w, in_length, 0x2001, 0, false, (const uint8_t *)t->text, size);
        }
        wire_close(&w);
    }
}

static void octets_in_every_mailbox(void **state)
{
    (void)state;
    for (uint16_t in_length = SHORTEST_IN; in_length <= LONGEST_IN; in_length++) {
        wire_t w;
        testdev_t *t = open_session(&w, &testdev, in_length);
        expect_upload(&w, in_length, 0x2002, 0, false, t->octets, OCTETS);
        expect_upload(&w, in_length, 0x2002, 0, true, t->octets, OCTETS);
        wire_close(&w);
    }
}

static void upload_toggle_and_interruptions(void **state)
{
    static const struct {
        const char *title;
        uint8_t before; /* valid segments */
        uint8_t command;
        uint32_t code;
    } table[] = {
        {"first segment with toggle 1", 0, 0x70, TOGGLE_CODE},
        {"second segment with toggle 0", 1, 0x60, TOGGLE_CODE},
        {"third segment with toggle 1", 2, 0x70, TOGGLE_CODE},
        {"a download segment instead", 1, 0x10, COMMAND_CODE},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        wire_t w;
        uint8_t r[1486];
        testdev_t *t = open_testdev(&w);
        assert_int_equal(initiate(&w, 0x40, 0x2002, 0, 0, r), 10 + IN_LENGTH - 16);
        uint8_t toggle = 0;
        for (uint8_t n = 0; n < table[i].before; n++, toggle ^= 0x10)
            assert_int_equal(initiate(&w, (uint8_t)(0x60 | toggle), 0, 0, 0, r), 3 + IN_LENGTH - 9);
        int length = initiate(&w, table[i].command, 0, 0, 0, r);
        expect_abort(table[i].title, r, length, 0x2002, 0, table[i].code);
        length = initiate(&w, (uint8_t)(0x60 | toggle), 0, 0, 0, r);
        expect_abort(table[i].title, r, length, 0, 0, COMMAND_CODE);
        expect_upload(&w, IN_LENGTH, 0x2002, 0, false, t->octets, OCTETS);
        wire_close(&w);
    }
}

static void upload_given_up(void **state)
{
    wire_t w;
    uint8_t r[1486];
    (void)state;
    testdev_t *t = open_testdev(&w);
    assert_int_equal(initiate(&w, 0x40, 0x2002, 0, 0, r), 10 + IN_LENGTH - 16);
    assert_int_equal(initiate(&w, 0x80, 0x2002, 0, 0x08000000, r), -1);
    expect_abort("segment after the master's abort", r, initiate(&w, 0x60, 0, 0, 0, r), 0, 0, COMMAND_CODE);
    assert_int_equal(initiate(&w, 0x40, 0x2002, 0, 0, r), 10 + IN_LENGTH - 16);
    expect_upload(&w, IN_LENGTH, 0x2009, 0, false, (const uint8_t *)"\x11\x22\x33\x44\x55\x66\x77\x88", 8);
    expect_abort("segment after another upload", r, initiate(&w, 0x60, 0, 0, 0, r), 0, 0, COMMAND_CODE);
    expect_upload(&w, IN_LENGTH, 0x2002, 0, false, t->octets, OCTETS);
    expect_abort("segment after the last", r, initiate(&w, 0x60, 0, 0, 0, r), 0, 0, COMMAND_CODE);
    assert_int_equal(initiate(&w, 0x40, 0x2002, 0, 0, r), 10 + IN_LENGTH - 16);
    wire_go(&w, 0, ECT_STATE_INIT);
    wire_go(&w, 0, ECT_STATE_PREOP);
    expect_abort("segment after INIT", r, initiate(&w, 0x60, 0, 0, 0, r), 0, 0, COMMAND_CODE);
    wire_close(&w);
}

/* The device shortens its text between two segments: the announced length is still transferred. */
static void text_changes_under_way(void **state)
{
    (void)state;
    for (uint32_t now = 0; now <= TEXT_ROOM; now++) {
        wire_t w;
        uint8_t request[10] = {0, 0x20, 0x40, 0x01, 0x20}, r[1486];
        testdev_t *t = open_session(&w, &testdev, SHORTEST_IN);
        memcpy(t->text, "ABCDEFGHIJKLMNOPQRST", TEXT_ROOM);
        assert_int_equal(ask(&w, SHORTEST_IN, request, sizeof request, r), 28);
        memset(t->text + now, 0, TEXT_ROOM - now);
        memcpy(request, "\x00\x20\x60\x00\x00", 5);
        int length = ask(&w, SHORTEST_IN, request, sizeof request, r);
        if (length != 10 || r[2] != 0x0B)
            fail_msg("text shortened to %u while 18 of 20 bytes are sent: expected a last segment of 2 bytes, "
                     "got length %d, command %02X",
                     now, length, r[2]);
        wire_close(&w);
    }
}

/* --- downloads ---------------------------------------------------------------------------------------------------- */

static uint32_t download_in_pieces(wire_t *w, uint16_t index, bool complete, uint8_t subindex, const uint8_t *data,
                                   uint32_t size, uint32_t first, uint32_t piece)
{
    uint8_t request[OUT_LENGTH] = {0, 0x20, (uint8_t)(complete ? 0x31 : 0x21)}, r[1486];
    ect_store_le16(request + 3, index);
    request[5] = subindex;
    ect_store_le32(request + 6, size);
    memcpy(request + 10, data, first);
    int length = ask(w, IN_LENGTH, request, (uint16_t)(10 + first), r);
    uint8_t toggle = 0;
    for (uint32_t done = first;; toggle ^= 0x10) {
        if (length != 10)
            fail_msg("reply of length %d after %u bytes", length, done);
        if (r[2] == 0x80)
            return ect_load_le32(r + 6);
        assert_int_equal(r[2], done == first ? (complete ? 0x70 : 0x60) : 0x20 | (toggle ^ 0x10));
        if (done == size)
            return 0;
        uint32_t n = size - done < piece ? size - done : piece;
        uint32_t unused = n < 7 ? 7 - n : 0;
        memset(request + 2, 0xEE, sizeof request - 2);
        request[2] = (uint8_t)(toggle | (unused << 1) | (done + n == size ? 1u : 0u));
        memcpy(request + 3, data + done, n);
        length = ask(w, IN_LENGTH, request, (uint16_t)(3 + n + unused), r);
        done += n;
    }
}

static void octets_in_pieces(void **state)
{
    static const uint32_t firsts[] = {0, 1, 6, 7, 8, 111, 112};
    static const uint32_t pieces[] = {1, 2, 6, 7, 8, 118, 119};
    wire_t w;
    uint8_t data[OCTETS];
    (void)state;
    testdev_t *t = open_testdev(&w);
    for (size_t f = 0; f < sizeof firsts / sizeof firsts[0]; f++) {
        for (size_t p = 0; p < sizeof pieces / sizeof pieces[0]; p++) {
            bool complete = ((f + p) & 1) != 0;
            for (unsigned int i = 0; i < OCTETS; i++)
                data[i] = (uint8_t)(i * 13 + f * 31 + p);
            t->written = 0;
            uint32_t code = download_in_pieces(&w, 0x2002, complete, 0, data, OCTETS, firsts[f], pieces[p]);
            if (code != 0 || memcmp(t->octets, data, OCTETS) != 0)
                fail_msg("first %u, then %u bytes each: code %08X or wrong content", firsts[f], pieces[p], code);
            assert_int_equal(t->written, 1);
            assert_int_equal(t->written_index, 0x2002);
        }
    }
    wire_close(&w);
}

static void numbers_in_pieces(void **state)
{
    wire_t w;
    uint8_t data[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    (void)state;
    testdev_t *t = open_testdev(&w);
    for (uint32_t first = 0; first < 8; first++) {
        for (uint32_t piece = 1; piece <= 8; piece++) {
            t->u64 = 0;
            assert_int_equal(download_in_pieces(&w, 0x2009, false, 0, data, 8, first, piece), 0);
            assert_true(t->u64 == 0x0807060504030201u);
        }
    }
    static const uint8_t low[2] = {0x9B, 0xFF};
    assert_int_equal(download_in_pieces(&w, 0x2005, false, 0, low, 2, 0, 1), TOO_LOW);
    assert_int_equal(t->limited, 5);
    wire_close(&w);
}

static void text_in_pieces(void **state)
{
    wire_t w;
    char text[TEXT_ROOM + 1] = "qwertyuiopasdfghjklz";
    (void)state;
    testdev_t *t = open_testdev(&w);
    for (uint32_t size = 1; size <= TEXT_ROOM; size++) {
        for (uint32_t piece = 1; piece <= 8; piece++) {
            memcpy(t->text, "ZZZZZZZZZZZZZZZZZZZZ", TEXT_ROOM);
            assert_int_equal(download_in_pieces(&w, 0x2001, false, 0, (const uint8_t *)text, size, 0, piece), 0);
            expect_upload(&w, IN_LENGTH, 0x2001, 0, false, (const uint8_t *)text, size);
        }
    }
    wire_close(&w);
}

/* Every size 0..9, expedited where possible, and normal, for entries of every width. */
static void wrong_sizes(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t room;
    } table[] = {{0x2008, 1, 1}, {0x2006, 1, 1}, {0x2006, 3, 1}, {0x2007, 2, 2},     {0x2003, 0, 2},
                 {0x2000, 0, 4}, {0x2006, 6, 4}, {0x2009, 0, 8}, {0x2002, 0, OCTETS}};
    static const uint8_t zeros[16] = {0};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        wire_t w;
        testdev_t *t = open_testdev(&w);
        testdev_t before = *t;
        for (uint32_t n = 0; n <= 13; n++) {
            uint32_t size = n <= 9 ? n : n - 9;
            if (size == table[i].room)
                continue;
            uint32_t want = size > table[i].room ? TOO_LONG : TOO_SHORT;
            uint32_t code =
                n > 9 ? wire_sdo_download(&w, 0, table[i].index, table[i].subindex, false, zeros, size)
                      : download_in_pieces(&w, table[i].index, false, table[i].subindex, zeros, size, size, 1);
            if (code != want)
                fail_msg("%04Xh:%u of %u bytes written with %u: expected %08X, got %08X", table[i].index,
                         table[i].subindex, table[i].room, size, want, code);
        }
        assert_memory_equal(&before.u32, &t->u32, offsetof(testdev_t, host) - offsetof(testdev_t, u32));
        assert_int_equal(t->written, 0);
        wire_close(&w);
    }
}

/* --- rights by state ---------------------------------------------------------------------------------------------- */

static void rights_by_state(void **state)
{
    static const uint8_t states[] = {ECT_STATE_PREOP, ECT_STATE_SAFEOP, ECT_STATE_OP};
    (void)state;
    for (size_t i = 0; i < sizeof states; i++) {
        wire_t w;
        uint8_t r[1486];
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, states[i]);
        bool preop = states[i] == ECT_STATE_PREOP;
        assert_int_equal(initiate(&w, 0x40, 0x2004, 0, 0, r), 10);
        assert_int_equal(r[2], 0x4B);
        int length = initiate(&w, 0x2B, 0x2004, 0, 9, r);
        if (preop)
            assert_int_equal(r[2], 0x60);
        else
            expect_abort("writable in PREOP only", r, length, 0x2004, 0, WRONG_STATE);
        length = initiate(&w, 0x3B, 0x2004, 0, 10, r);
        if (preop)
            assert_int_equal(r[2], 0x70);
        else
            expect_abort("writable in PREOP only, whole", r, length, 0x2004, 0, WRONG_STATE);
        assert_int_equal(testdev_of(&w, 0)->preop_only, preop ? 10 : 7);
        assert_int_equal(initiate(&w, 0x2B, 0x2007, 1, 0x1234, r), 10);
        assert_int_equal(r[2], 0x60);
        wire_close(&w);
    }
}

static void state_changes_during_a_download(void **state)
{
    wire_t w;
    uint8_t r[1486];
    static const uint8_t segment[10] = {0x00, 0x20, 0x0B, 0x39, 0x30};
    (void)state;
    testdev_t *t = open_testdev(&w);
    assert_int_equal(initiate(&w, 0x21, 0x2004, 0, 2, r), 10);
    assert_int_equal(r[2], 0x60);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    int length = ask(&w, IN_LENGTH, segment, sizeof segment, r);
    if (length != 10 || r[2] != 0x80 || ect_load_le32(r + 6) != WRONG_STATE || t->preop_only != 7)
        fail_msg("a value that is writable in PREOP only: started there and finished in SAFEOP: expected abort "
                 "08000022 and 7, got command %02X and %u",
                 r[2], t->preop_only);
    wire_close(&w);
}

static void no_answer_in_init(void **state)
{
    wire_t w;
    uint8_t r[1486], mail[OUT_LENGTH] = {10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0, 0x20};
    (void)state;
    wire_open_one(&w, &testdev);
    wire_configure_mailbox(&w, 0);
    (void)wire_write(&w, 0, 0x1000, mail, sizeof mail);
    wire_poll(&w);
    assert_int_equal(fetch(&w, IN_LENGTH, r), -1);
    wire_close(&w);
}

/* --- results of the device ---------------------------------------------------------------------------------------- */

static const uint32_t codes[] = {0x05030000, 0x05040000, 0x05040001, 0x05040005, 0x06010000, 0x06010001, 0x06010002,
                                 0x06010003, 0x06010004, 0x06010005, 0x06010006, 0x06020000, 0x06040041, 0x06040042,
                                 0x06040043, 0x06040047, 0x06060000, 0x06070010, 0x06070012, 0x06070013, 0x06090011,
                                 0x06090030, 0x06090031, 0x06090032, 0x06090033, 0x06090036, 0x060A0023, 0x08000000,
                                 0x08000020, 0x08000021, 0x08000022, 0x08000023, 0x08000024};

static void device_refuses(void **state)
{
    (void)state;
    assert_int_equal(sizeof codes / sizeof codes[0], ECT_REASON_COUNT - 1);
    for (int reason = 1; reason < ECT_REASON_COUNT; reason++) {
        wire_t w;
        uint8_t r[1486];
        static const uint8_t array[8] = {9, 9, 9, 9, 9, 9, 9, 9};
        testdev_t *t = open_testdev(&w);
        testdev_t before = *t;
        uint32_t code = codes[reason - 1];
        t->write_answer = (ect_reason_t)reason;
        expect_abort("expedited", r, initiate(&w, 0x23, 0x2000, 0, 1, r), 0x2000, 0, code);
        assert_int_equal(wire_sdo_download(&w, 0, 0x2001, 0, false, "Hallo", 5), code);
        assert_int_equal(wire_sdo_download(&w, 0, 0x2007, 1, true, array, 8), code);
        assert_int_equal(download_in_pieces(&w, 0x2009, false, 0, array, 8, 0, 7), code);
        assert_memory_equal(&before.u32, &t->u32, offsetof(testdev_t, host) - offsetof(testdev_t, u32));
        assert_int_equal(t->written, 0);
        wire_close(&w);
    }
}

static void device_refuses_a_segmented_value(void **state)
{
    wire_t w;
    uint8_t data[OCTETS] = {0};
    (void)state;
    testdev_t *t = open_testdev(&w);
    t->write_answer = ECT_REASON_LOCAL_CONTROL;
    uint32_t code = wire_sdo_download(&w, 0, 0x2002, 0, false, data, OCTETS);
    if (code != 0x08000021 || t->written != 0)
        fail_msg("1000 octets in segments, refused by the device: expected abort 08000021 and nothing reported as "
                 "written, got %08X, %u written",
                 code, t->written);
    code = download_in_pieces(&w, 0x2001, false, 0, (const uint8_t *)"Hallo", 5, 0, 5);
    if (code != 0x08000021)
        fail_msg("a text in one segment, refused by the device: expected abort 08000021, got %08X", code);
    wire_close(&w);
}

static ect_reason_t refuse_third(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    (void)instance;
    (void)index;
    (void)size;
    (void)data;
    return subindex == 3 ? ECT_REASON_RANGE : ECT_OK;
}

static void nothing_is_stored_when_one_is_refused(void **state)
{
    wire_t w;
    ect_device_t device = testdev;
    static const uint8_t array[8] = {9, 9, 9, 9, 9, 9, 9, 9};
    (void)state;
    device.sdo_write = refuse_third;
    testdev_t *t = open_session(&w, &device, IN_LENGTH);
    assert_int_equal(wire_sdo_download(&w, 0, 0x2007, 1, true, array, 8), 0x06090030);
    assert_int_equal(t->array[0], 0x1111);
    assert_int_equal(t->array[1], 0x2222);
    assert_int_equal(t->written, 0);
    assert_int_equal(wire_sdo_download(&w, 0, 0x2007, 1, true, array, 4), 0);
    assert_int_equal(t->array[1], 0x0909);
    assert_int_equal(t->written, 2);
    wire_close(&w);
}

static void device_without_hooks(void **state)
{
    wire_t w;
    ect_device_t device = testdev;
    uint8_t data[OCTETS] = {7};
    (void)state;
    device.sdo_write = NULL;
    device.sdo_written = NULL;
    testdev_t *t = open_session(&w, &device, IN_LENGTH);
    assert_int_equal(wire_sdo_download(&w, 0, 0x2000, 0, false, "\1\2\3\4", 4), 0);
    assert_int_equal(t->u32, 0x04030201);
    assert_int_equal(wire_sdo_download(&w, 0, 0x2002, 0, false, data, OCTETS), 0);
    assert_memory_equal(t->octets, data, OCTETS);
    wire_close(&w);
}

static void device_without_complete_access(void **state)
{
    wire_t w;
    uint8_t r[1486];
    ect_device_t device = testdev;
    (void)state;
    device.coe_details = ECT_COE_SDO;
    (void)open_session(&w, &device, IN_LENGTH);
    expect_abort("whole, up", r, initiate(&w, 0x50, 0x2007, 0, 0, r), 0x2007, 0, UNSUPPORTED);
    expect_abort("whole, down", r, initiate(&w, 0x33, 0x2000, 0, 0, r), 0x2000, 0, UNSUPPORTED);
    assert_int_equal(initiate(&w, 0x40, 0x2007, 1, 0, r), 10);
    assert_int_equal(r[2], 0x4B);
    wire_close(&w);
}

static void device_is_notified_of_writes(void **state)
{
    wire_t w;
    uint8_t r[1486];
    static const uint8_t record[9] = {0};
    (void)state;
    testdev_t *t = open_testdev(&w);
    assert_int_equal(initiate(&w, 0x2F, 0x2008, 3, 1, r), 10);
    assert_int_equal(t->written, 1);
    assert_int_equal(t->written_index, 0x2008);
    assert_int_equal(t->written_subindex, 3);
    assert_int_equal(initiate(&w, 0x40, 0x2008, 3, 0, r), 10);
    assert_int_equal(initiate(&w, 0x2F, 0x2008, 4, 1, r), 10);
    assert_int_equal(t->written, 1);
    assert_int_equal(wire_sdo_download(&w, 0, 0x2006, 1, true, record, 9), 0);
    assert_int_equal(t->written, 6); /* five writable elements */
    assert_int_equal(t->written_subindex, 6);
    wire_close(&w);
}

/* The reply is not fetched: no further frame triggers a poll. */
static void device_is_polled_after_a_write(void **state)
{
    static const uint8_t download[10] = {0x00, 0x20, 0x23, 0x00, 0x20, 0x00, 1, 2, 3, 4};
    wire_t w;
    (void)state;
    testdev_t *t = open_testdev(&w);
    t->tick_period_ns = 3600000000000ull;
    ect_chain_wake(w.chain, 0);
    wire_advance(&w, 1000000);
    unsigned int ticks = t->ticks;
    wire_advance(&w, 1000000);
    assert_int_equal(t->ticks, ticks);
    put(&w, 3, download, sizeof download);
    assert_int_equal(t->u32, 0x04030201);
    wire_advance(&w, 1000000);
    if (t->ticks == ticks)
        fail_msg("a value was stored: expected the device's tick within 1 ms, got none");
    wire_close(&w);
}

/* --- a model of the packed form ----------------------------------------------------------------------------------- */

enum { BITS = 1, READ = 2, WRITE = 4, IN_PREOP = 8, TEXT = 16, VAR = 32, LIMITED = 64, RW = READ | WRITE };

typedef struct item {
    uint16_t index;
    uint8_t subindex;
    uint8_t bits;
    uint8_t flags;
    uint64_t value;
} item_t;

static void set_bits(uint8_t *bytes, uint32_t at, uint32_t count, uint64_t value)
{
    for (uint32_t i = 0; i < count; i++) {
        if (((value >> i) & 1u) != 0)
            bytes[(at + i) / 8] = (uint8_t)(bytes[(at + i) / 8] | (1u << ((at + i) % 8)));
    }
}

static uint64_t get_bits(const uint8_t *bytes, uint32_t at, uint32_t count)
{
    uint64_t value = 0;
    for (uint32_t i = 0; i < count; i++)
        value |= (uint64_t)((bytes[(at + i) / 8] >> ((at + i) % 8)) & 1) << i;
    return value;
}

/* Start of an item of a whole object, if `at` is the end of the previous one; its end includes the pad. */
static uint32_t item_start(const item_t *item, uint32_t at)
{
    return (item->flags & BITS) != 0 ? at : (at + 7u) & ~7u;
}

static uint32_t item_end(const item_t *item, uint32_t start)
{
    bool pad = item->subindex == 0 && (item->flags & VAR) == 0;
    return start + item->bits + (pad ? 8u : 0u);
}

/* Packs the items of an object from a sub-index on. @return bytes */
static uint32_t pack(const item_t *items, size_t count, uint16_t index, uint8_t from, uint8_t *bytes)
{
    uint32_t at = 0;
    memset(bytes, 0, 1486);
    for (const item_t *i = items; i < items + count; i++) {
        if (i->index != index || i->subindex < from)
            continue;
        uint32_t start = item_start(i, at);
        set_bits(bytes, start, i->bits, (i->flags & READ) != 0 ? i->value : 0);
        at = item_end(i, start);
    }
    return (at + 7) / 8;
}

/* --- whole objects longer than the mailbox ------------------------------------------------------------------------ */

enum { BIG_COUNT = 120 };

typedef struct big {
    ect_device_t device;
    ect_entry_t entries[BIG_COUNT + 1];
    ect_object_t objects[1];
    item_t items[BIG_COUNT + 1];
} big_t;

/* One record of 120 elements: 1, 5, 16, 3, 64 and 8 bits in turn, the 8 bits read-only, the 3 bits write-only. */
static void make_big(big_t *big)
{
    static const struct {
        uint16_t type;
        uint8_t bits, flags;
        uint16_t access;
    } kinds[6] = {{ECT_TYPE_BOOLEAN, 1, BITS | RW, ECT_ACCESS_RW}, {ECT_TYPE_BIT1 + 4, 5, BITS | RW, ECT_ACCESS_RW},
                  {ECT_TYPE_UNSIGNED16, 16, RW, ECT_ACCESS_RW},    {ECT_TYPE_BIT1 + 2, 3, BITS | WRITE, ECT_ACCESS_WO},
                  {ECT_TYPE_UNSIGNED64, 64, RW, ECT_ACCESS_RW},    {ECT_TYPE_UNSIGNED8, 8, READ, ECT_ACCESS_RO}};
    memset(big, 0, sizeof *big);
    big->entries[0] = (ect_entry_t){0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Count", BIG_COUNT, NULL};
    big->items[0] = (item_t){0x3000, 0, 8, READ, BIG_COUNT};
    for (uint8_t n = 1; n <= BIG_COUNT; n++) {
        size_t k = n % 6u;
        uintptr_t offset = offsetof(testdev_t, octets) + 8u * (n - 1u);
        big->entries[n] = (ect_entry_t){n, kinds[k].type, kinds[k].bits, kinds[k].access, "Element", 0, (void *)offset};
        big->items[n] = (item_t){0x3000, n, kinds[k].bits, kinds[k].flags, 0};
    }
    big->objects[0] = (ect_object_t){0x3000, ECT_OBJECT_RECORD, BIG_COUNT, 0, "Big", big->entries};
    big->device = testdev;
    big->device.objects = big->objects;
    big->device.object_count = 1;
    big->device.detail_count = 0;
}

/* The stored values and the model's, from one seed. */
static void fill_big(big_t *big, testdev_t *t, uint32_t seed)
{
    for (uint8_t n = 1; n <= BIG_COUNT; n++) {
        uint64_t value = (seed + n) * 0x9E3779B97F4A7C15u;
        if (big->items[n].bits < 64)
            value &= (1u << big->items[n].bits) - 1u;
        big->items[n].value = value;
        ect_store_le64(t->octets + 8 * (n - 1), value);
    }
}

static void whole_record_in_segments_up(void **state)
{
    static big_t big;
    uint8_t bytes[1486];
    (void)state;
    make_big(&big);
    for (uint16_t in_length = SHORTEST_IN; in_length <= LONGEST_IN; in_length = (uint16_t)(in_length + 3)) {
        wire_t w;
        testdev_t *t = open_session(&w, &big.device, in_length);
        fill_big(&big, t, in_length);
        for (uint8_t from = 0; from <= 1; from++) {
            uint32_t size = pack(big.items, BIG_COUNT + 1, 0x3000, from, bytes);
            expect_upload(&w, in_length, 0x3000, from, true, bytes, size);
        }
        wire_close(&w);
    }
}

static void whole_record_in_segments_down(void **state)
{
    static big_t big;
    wire_t w;
    uint8_t bytes[1486];
    (void)state;
    make_big(&big);
    testdev_t *t = open_session(&w, &big.device, IN_LENGTH);
    for (uint32_t piece = 1; piece <= 119; piece += 2) {
        uint8_t from = piece % 4 == 1;
        fill_big(&big, t, piece);
        for (unsigned int n = 0; n <= BIG_COUNT; n++)
            big.items[n].flags |= READ;
        uint32_t size = pack(big.items, BIG_COUNT + 1, 0x3000, from, bytes);
        memset(t->octets, 0, OCTETS);
        uint32_t code = download_in_pieces(&w, 0x3000, true, from, bytes, size, piece < 112 ? 112 - piece : 0, piece);
        if (code != 0)
            fail_msg("pieces of %u: abort %08X", piece, code);
        for (uint8_t n = 1; n <= BIG_COUNT; n++) {
            uint64_t want = n % 6 == 5 ? 0 : big.items[n].value;
            if (ect_load_le64(t->octets + 8 * (n - 1)) != want)
                fail_msg("pieces of %u: element %u differs from the sent one", piece, n);
        }
    }
    assert_int_equal(download_in_pieces(&w, 0x3000, true, 1, bytes, 200, 10, 30), TOO_SHORT);
    assert_int_equal(download_in_pieces(&w, 0x3000, true, 0, bytes, 1000, 10, 30), TOO_LONG);
    wire_close(&w);
}

/* Calls of the device, element by element. */
static uint8_t passed[BIG_COUNT + 1];

static ect_reason_t note_value(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    (void)instance;
    (void)index;
    (void)size;
    passed[subindex] = *(const uint8_t *)data;
    return ECT_OK;
}

/* Elements that end at a byte, a bit before, or a bit after it. */
static void bits_of_a_record(void **state)
{
    static const struct {
        uint8_t count, bits[9];
    } rows[] = {{1, {1}},       {1, {7}},          {2, {7, 1}}, {2, {8, 1}},
                {3, {3, 4, 1}}, {4, {7, 7, 2, 1}}, {2, {1, 8}}, {9, {1, 1, 1, 1, 1, 1, 1, 1, 1}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (unsigned int ones = 0; ones < 2; ones++) {
            static big_t big;
            uint8_t bytes[1486], got[1486];
            size_t size = sizeof got;
            wire_t w;
            make_big(&big);
            big.device.sdo_write = note_value;
            big.entries[0].value = rows[i].count;
            big.objects[0].max_subindex = rows[i].count;
            for (uint8_t n = 1; n <= rows[i].count; n++) {
                uint8_t bits = rows[i].bits[n - 1];
                big.entries[n].data_type = (uint16_t)(ECT_TYPE_BIT1 + bits - 1);
                big.entries[n].bit_length = bits;
                big.entries[n].access = ECT_ACCESS_RW;
                big.items[n] = (item_t){0x3000, n, bits, BITS | RW, n % 2 == ones ? (1u << bits) - 1u : 0};
            }
            testdev_t *t = open_session(&w, &big.device, IN_LENGTH);
            uint32_t packed = pack(big.items, rows[i].count + 1u, 0x3000, 1, bytes);
            memset(passed, 0xEE, sizeof passed);
            assert_int_equal(wire_sdo_download(&w, 0, 0x3000, 1, true, bytes, packed), 0);
            for (uint8_t n = 1; n <= rows[i].count; n++) {
                uint8_t stored = t->octets[8 * (n - 1)];
                if (stored != big.items[n].value || passed[n] != big.items[n].value)
                    fail_msg("row %zu, element %u: expected %02X, got %02X, and passed %02X to the device", i, n,
                             (unsigned int)big.items[n].value, stored, passed[n]);
            }
            assert_int_equal(wire_sdo_upload(&w, 0, 0x3000, 1, true, got, &size), 0);
            if (size != packed || memcmp(got, bytes, packed) != 0)
                fail_msg("row %zu: expected %u bytes up as they went down, got %zu, or others", i, packed, size);
            wire_close(&w);
        }
    }
}

static void mapping_of_36_entries(void **state)
{
    const ect_device_t *device = &ect_eclink_map7;
    uint8_t want[2 + 4 * 36] = {36, 0}, got[1486];
    wire_t w;
    (void)state;
    wire_open_one(&w, device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (uint8_t n = 1; n <= 36; n++) {
        uint32_t value = 0;
        size_t size = sizeof value;
        assert_int_equal(wire_sdo_upload(&w, 0, 0x1600, n, false, want + 4 * n - 2, &size), 0);
        assert_int_equal(size, 4);
    }
    for (uint8_t from = 0; from <= 1; from++) {
        size_t size = sizeof got;
        assert_int_equal(wire_sdo_upload(&w, 0, 0x1600, from, true, got, &size), 0);
        assert_int_equal(size, sizeof want - 2u * from);
        assert_memory_equal(got, want + 2 * from, size);
    }
    assert_int_equal(wire_sdo_download(&w, 0, 0x1600, 0, true, want, 100), READ_ONLY);
    wire_close(&w);
}

/* Kinds of objects that the test device lacks: elements without memory or known length, no sub-index 0, long ones. */
static const ect_entry_t odd_3000[] = {{0, ECT_TYPE_OCTET_STRING, 0, ECT_ACCESS_RW, "Unknown length", 0, NULL}};
static const ect_entry_t odd_3001[] = {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "No memory", 0x1234, NULL}};
static const ect_entry_t odd_3002[] = {
    {1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "First", 0, ECT_OFFSET(testdev_t, array[0])},
    {2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW_PREOP, "Second", 0, ECT_OFFSET(testdev_t, array[1])}};
static const ect_entry_t odd_3003[] = {
    {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Count", 3, NULL},
    {1, ECT_TYPE_OCTET_STRING, 160, ECT_ACCESS_RO, "Read-only", 0, ECT_OFFSET(testdev_t, octets[0])},
    {2, ECT_TYPE_OCTET_STRING, 160, ECT_ACCESS_RW, "Read and write", 0, ECT_OFFSET(testdev_t, octets[20])},
    {3, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "Number", 0, ECT_OFFSET(testdev_t, array[3])}};
static const ect_entry_t odd_3004[] = {{0, ECT_TYPE_OCTET_STRING, 160, ECT_ACCESS_RW, "No memory", 0x1234, NULL}};
static const ect_object_t odd_objects[] = {{0x3000, ECT_OBJECT_VAR, 0, 0, "Unknown length", odd_3000},
                                           {0x3001, ECT_OBJECT_VAR, 0, 0, "No memory", odd_3001},
                                           {0x3002, ECT_OBJECT_RECORD, 2, 1, "No sub-index 0", odd_3002},
                                           {0x3003, ECT_OBJECT_RECORD, 3, 0, "Long elements", odd_3003},
                                           {0x3004, ECT_OBJECT_VAR, 0, 0, "Long, no memory", odd_3004}};

static void odd_kinds_of_objects(void **state)
{
    wire_t w;
    uint8_t r[1486], data[44] = {3, 0};
    ect_device_t device = testdev;
    (void)state;
    device.objects = odd_objects;
    device.object_count = 5;
    testdev_t *t = open_session(&w, &device, IN_LENGTH);
    expect_abort("unknown length", r, initiate(&w, 0x50, 0x3000, 0, 0, r), 0x3000, 0, VARIABLE);
    expect_abort("no memory", r, initiate(&w, 0x2B, 0x3001, 0, 1, r), 0x3001, 0, READ_ONLY);
    assert_int_equal(download_in_pieces(&w, 0x3004, false, 0, data, 20, 5, 5), READ_ONLY);
    expect_upload(&w, IN_LENGTH, 0x3002, 1, true, (const uint8_t *)"\x11\x11\x22\x22", 4);
    expect_upload(&w, IN_LENGTH, 0x3002, 0, true, (const uint8_t *)"\x11\x11\x22\x22", 4);
    assert_int_equal(download_in_pieces(&w, 0x2000, true, 0, data, 4, 0, 1), NO_OBJECT);
    assert_int_equal(wire_sdo_download(&w, 0, 0x3003, 1, true, data, 30), TOO_SHORT);
    assert_memory_equal(t->octets, "\x03\x0A\x11", 3);
    memset(data + 2, 0xA5, sizeof data - 2);
    for (uint32_t piece = 1; piece <= 44; piece++) {
        fill(t);
        t->written = 0;
        assert_int_equal(download_in_pieces(&w, 0x3003, true, 0, data, 44, 44 - piece, piece), 0);
        assert_memory_equal(t->octets, "\x03\x0A\x11\x18\x1F", 5);
        assert_memory_equal(t->octets + 20, data + 22, 20);
        assert_int_equal(t->octets[40], 40 * 7 + 3 - 256);
        assert_int_equal(t->array[3], 0xA5A5);
        assert_int_equal(t->written, 2);
    }
    wire_close(&w);
}

/* Sub-index 0 limits the transfer to the elements that it declares. */
static void declared_elements_only(void **state)
{
    static const ect_entry_t e3000[] = {
        {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Count", 0, ECT_OFFSET(testdev_t, record_ro)},
        {1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "A", 0, ECT_OFFSET(testdev_t, array[0])},
        {2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "B", 0, ECT_OFFSET(testdev_t, array[1])},
        {3, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "C", 0, ECT_OFFSET(testdev_t, array[2])}};
    static const ect_object_t objects[] = {{0x3000, ECT_OBJECT_ARRAY, 3, 0, "List", e3000}};
    ect_device_t device = testdev;
    wire_t w;
    (void)state;
    device.objects = objects;
    device.object_count = 1;
    testdev_t *t = open_session(&w, &device, IN_LENGTH);
    for (uint8_t count = 0; count <= 4; count++) {
        uint8_t want[8] = {count, 0, 0x11, 0x11, 0x22, 0x22, 0x33, 0x33};
        uint32_t size = 2u * (count < 3 ? count : 3u);
        t->record_ro = count;
        expect_upload(&w, IN_LENGTH, 0x3000, 0, true, want, 2 + size);
        expect_upload(&w, IN_LENGTH, 0x3000, 1, true, want + 2, size);
    }
    wire_close(&w);
}

/* A list that the device shortens during a segmented upload. */
static void list_changes_under_way(void **state)
{
    static big_t big;
    wire_t w;
    uint8_t request[10] = {0, 0x20, 0x50, 0x00, 0x30}, r[1486];
    (void)state;
    make_big(&big);
    big.entries[0].data = ECT_OFFSET(testdev_t, record_ro);
    testdev_t *t = open_session(&w, &big.device, SHORTEST_IN);
    t->record_ro = BIG_COUNT;
    assert_int_equal(ask(&w, SHORTEST_IN, request, sizeof request, r), 28);
    uint32_t size = ect_load_le32(r + 6);
    t->record_ro = 2;
    uint32_t got = 18;
    for (uint8_t toggle = 0; got < size; toggle ^= 0x10) {
        memcpy(request, "\x00\x20\x60\x00\x00", 5);
        request[2] = 0x60 | toggle;
        int length = ask(&w, SHORTEST_IN, request, sizeof request, r);
        assert_true(length >= 10);
        if (r[2] == 0x80)
            break; /* an abort is a valid reply too */
        got += length == 10 ? 7u - ((r[2] >> 1) & 7u) : (uint32_t)length - 3;
    }
    wire_close(&w);
}

/* --- objects that every device has -------------------------------------------------------------------------------- */

static void upload_number(wire_t *w, const char *name, uint16_t index, uint8_t subindex, size_t bytes, uint32_t want)
{
    uint8_t data[8] = {0};
    size_t size = sizeof data;
    uint32_t code = wire_sdo_upload(w, 0, index, subindex, false, data, &size);
    if (code != 0 || size != bytes || ect_load_le32(data) != want)
        fail_msg("%s %04Xh:%u: expected %u bytes %Xh, got abort %08X, %u bytes %Xh", name, index, subindex,
                 (unsigned int)bytes, want, code, (unsigned int)size, ect_load_le32(data));
}

static void upload_text(wire_t *w, const char *name, uint16_t index, const char *want)
{
    char text[256];
    size_t size = sizeof text;
    uint32_t code = wire_sdo_upload(w, 0, index, 0, false, text, &size);
    if (code != 0 || size != strlen(want) || memcmp(text, want, size) != 0)
        fail_msg("%s %04Xh: expected \"%s\", got abort %08X, %zu characters", name, index, want, code, size);
}

static void identity_of(wire_t *w, const ect_device_t *device)
{
    const ect_identity_t *id = &device->identity;
    const uint32_t identity[] = {id->vendor_id, id->product_code, id->revision, id->serial};
    upload_number(w, device->name, 0x1018, 0, 1, 4);
    for (uint8_t n = 1; n <= 4; n++)
        upload_number(w, device->name, 0x1018, n, 4, identity[n - 1]);
    upload_number(w, device->name, 0x1000, 0, 4, device == &testdev ? 0x12345678 : device->device_type);
}

static void texts_of(wire_t *w, const ect_device_t *device)
{
    const ect_od_t od = ect_device_od(device, NULL);
    const struct {
        uint16_t index;
        const char *text;
    } texts[] = {{0x1008, device->type_name}, {0x1009, device->hardware_version}, {0x100A, device->software_version}};
    for (size_t i = 0; i < 3; i++) {
        if (ect_od_find(&od, texts[i].index))
            upload_text(w, device->name, texts[i].index, texts[i].text);
    }
}

static void sms_of(wire_t *w, const ect_device_t *device)
{
    const ect_od_t od = ect_device_od(device, NULL);
    upload_number(w, device->name, 0x1C00, 0, 1, device->sm_count);
    for (uint8_t n = 0; n < device->sm_count; n++) {
        uint16_t assignment = (uint16_t)(0x1C10 + n);
        upload_number(w, device->name, 0x1C00, (uint8_t)(n + 1), 1, device->sm[n].type);
        if ((process_sms_of(device) >> n & 1) == 0)
            continue;
        uint32_t pdos = ect_od_element(ect_od_find(&od, assignment), 0);
        upload_number(w, device->name, assignment, 0, 1, pdos);
        for (uint8_t k = 1; k <= pdos; k++)
            upload_number(w, device->name, assignment, k, 2, ect_od_element(ect_od_find(&od, assignment), k));
    }
}

static void mandatory_objects_of(const ect_device_t *device)
{
    wire_t w;
    wire_open_one(&w, device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    identity_of(&w, device);
    texts_of(&w, device);
    sms_of(&w, device);
    wire_close(&w);
}

static uint32_t count_of(const ect_device_t *device, const ect_object_t *o)
{
    return o->index == 0x1C00 ? device->sm_count : o->entries->value;
}

static void subindices_of(const ect_device_t *device)
{
    wire_t w;
    wire_open_one(&w, device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *o = &device->objects[i];
        bool fixed = o->index < 0x1600 || o->index >= 0x2000 || !o->entries->data;
        if (o->object_code != ECT_OBJECT_VAR) /* a changeable mapping need not contain all elements */
            upload_number(&w, device->name, o->index, 0, 1, fixed ? o->max_subindex : count_of(device, o));
        for (unsigned int n = o->max_subindex + 1u; n <= 255; n += n < 250 ? 9 : 1) {
            uint8_t data[4];
            size_t size = sizeof data;
            uint32_t code = wire_sdo_upload(&w, 0, o->index, (uint8_t)n, false, data, &size);
            if (code != NO_SUBINDEX)
                fail_msg("%s %04Xh:%u: expected abort 06090011, got %08X", device->name, o->index, n, code);
        }
    }
    wire_close(&w);
}

static void mandatory_objects(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        if (has_coe(every_device(i)))
            mandatory_objects_of(every_device(i));
    }
}

static void subindices(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        if (has_coe(every_device(i)))
            subindices_of(every_device(i));
    }
}

/* --- a random session against a model ----------------------------------------------------------------------------- */

enum { ITEMS = 29 };

typedef struct model {
    item_t items[ITEMS];
    char text[TEXT_ROOM];
    uint32_t text_size;
    uint8_t state;
    uint32_t random;
} model_t;

/* The test device according to its header, with the values of fill(). */
static const item_t start[ITEMS] = {
    {0x1000, 0, 32, READ | VAR, 0x12345678},
    {0x1C00, 0, 8, READ, 4},
    {0x1C00, 1, 8, READ, 1},
    {0x1C00, 2, 8, READ, 2},
    {0x1C00, 3, 8, READ, 3},
    {0x1C00, 4, 8, READ, 4},
    {0x2000, 0, 32, RW | VAR, 0x11223344},
    {0x2001, 0, 160, RW | VAR | TEXT, 0},
    {0x2003, 0, 16, WRITE | VAR, 0x5A5A},
    {0x2004, 0, 16, RW | IN_PREOP | VAR, 7},
    {0x2005, 0, 16, RW | VAR | LIMITED, 5},
    {0x2006, 0, 8, READ, 6},
    {0x2006, 1, 1, RW | BITS, 1},
    {0x2006, 2, 3, RW | BITS, 5},
    {0x2006, 3, 5, RW | BITS, 0x15},
    {0x2006, 4, 16, RW, 0xABCD},
    {0x2006, 5, 8, READ, 0x77},
    {0x2006, 6, 32, RW, 0xDEADBEEF},
    {0x2007, 0, 8, READ, 4},
    {0x2007, 1, 16, RW, 0x1111},
    {0x2007, 2, 16, RW, 0x2222},
    {0x2007, 3, 16, RW, 0x3333},
    {0x2007, 4, 16, RW, 0x4444},
    {0x2008, 0, 8, READ, 5},
    {0x2008, 1, 8, RW, 0x11},
    {0x2008, 3, 8, RW, 0x33},
    {0x2008, 5, 8, RW, 0x55},
    {0x2009, 0, 64, RW | VAR, 0x8877665544332211u},
    {0x6000, 0, 8, READ, 2},
};

static uint32_t dice(model_t *m, uint32_t sides)
{
    m->random = m->random * 1664525u + 1013904223u;
    return (m->random >> 8) % sides;
}

static uint32_t right(const model_t *m, const item_t *item, bool write)
{
    if ((item->flags & (write ? WRITE : READ)) == 0)
        return write ? READ_ONLY : WRITE_ONLY;
    return write && (item->flags & IN_PREOP) != 0 && m->state != ECT_STATE_PREOP ? WRONG_STATE : 0;
}

static item_t *find(model_t *m, uint16_t index, unsigned int subindex, bool *there)
{
    *there = false;
    for (item_t *i = m->items; i < m->items + ITEMS; i++) {
        *there = *there || i->index == index;
        if (i->index == index && i->subindex == subindex)
            return i;
    }
    return NULL;
}

/* Whether the request is refused regardless of its data. */
static uint32_t refused(model_t *m, uint16_t index, uint8_t subindex, bool complete, bool write)
{
    bool there;
    item_t *item = find(m, index, subindex, &there);
    if (!there)
        return NO_OBJECT;
    if (!complete)
        return item ? right(m, item, write) : NO_SUBINDEX;
    if (subindex > 1)
        return UNSUPPORTED;
    item_t *first = find(m, index, 0, &there);
    if ((first->flags & TEXT) != 0)
        return VARIABLE;
    uint32_t code = right(m, first, write);
    for (item_t *i = first; i < m->items + ITEMS && i->index == index; i++)
        code = right(m, i, write) == 0 ? 0 : code;
    return code == 0 && subindex == 1 && (first->flags & VAR) != 0 ? NO_SUBINDEX : code;
}

static uint32_t out_of_limits(const item_t *item, uint64_t value)
{
    int16_t number = (int16_t)(uint16_t)value;
    if ((item->flags & LIMITED) == 0)
        return 0;
    return number > 200 ? TOO_HIGH : number < -100 ? TOO_LOW : 0;
}

static uint32_t model_store_whole(model_t *m, uint16_t index, uint8_t from, const uint8_t *data, uint32_t size)
{
    uint8_t unused[1486];
    if (size > pack(m->items, ITEMS, index, from, unused))
        return TOO_LONG;
    model_t before = *m;
    uint32_t at = 0, code = size == 0 ? TOO_SHORT : 0;
    for (item_t *i = m->items; i < m->items + ITEMS && code == 0; i++) {
        if (i->index != index || i->subindex < from)
            continue;
        uint32_t here = item_start(i, at);
        at = item_end(i, here);
        if (here + i->bits > 8 * size) {
            code = here < 8 * size && (i->flags & BITS) == 0 ? TOO_SHORT : 0;
            break;
        }
        uint64_t value = get_bits(data, here, i->bits);
        if (right(m, i, true) != 0)
            continue;
        code = out_of_limits(i, value);
        i->value = value;
    }
    if (code != 0)
        memcpy(m, &before, sizeof *m);
    return code;
}

static uint32_t model_download(model_t *m, uint16_t index, uint8_t subindex, bool complete, const uint8_t *data,
                               uint32_t size)
{
    bool there;
    uint32_t code = refused(m, index, subindex, complete, true);
    if (code != 0)
        return code;
    if (complete)
        return model_store_whole(m, index, subindex, data, size);
    item_t *item = find(m, index, subindex, &there);
    uint32_t room = (item->bits + 7u) / 8u;
    if (size > room)
        return TOO_LONG;
    if ((item->flags & TEXT) != 0 && size > 0) {
        const uint8_t *end = memchr(data, 0, size);
        m->text_size = end ? (uint32_t)(end - data) : size;
        memcpy(m->text, data, m->text_size);
        return 0;
    }
    if (size < room)
        return TOO_SHORT;
    uint64_t value = get_bits(data, 0, item->bits);
    code = out_of_limits(item, value);
    if (code == 0)
        item->value = value;
    return code;
}

static uint32_t model_upload(model_t *m, uint16_t index, uint8_t subindex, bool complete, uint8_t *data, uint32_t *size)
{
    bool there;
    uint32_t code = refused(m, index, subindex, complete, false);
    if (code != 0)
        return code;
    item_t *item = find(m, index, subindex, &there);
    if (complete) {
        *size = pack(m->items, ITEMS, index, subindex, data);
    } else if ((item->flags & TEXT) != 0) {
        *size = m->text_size;
        memcpy(data, m->text, m->text_size);
    } else {
        *size = (item->bits + 7u) / 8u;
        memset(data, 0, 8);
        set_bits(data, 0, item->bits, item->value);
    }
    return 0;
}

static void random_request(wire_t *w, model_t *m, unsigned int n)
{
    static const uint16_t indices[] = {0x1000, 0x1C00, 0x2000, 0x2001, 0x2003, 0x2004, 0x2005, 0x2006,
                                       0x2006, 0x2007, 0x2007, 0x2008, 0x2008, 0x2009, 0x200A, 0x1FFF};
    uint16_t index = indices[dice(m, sizeof indices / sizeof indices[0])];
    bool complete = dice(m, 2) != 0;
    uint8_t subindex = (uint8_t)(dice(m, 2) != 0 ? dice(m, 2) : dice(m, 8));
    uint8_t data[1486], got[1486];
    uint32_t size = 0, want, code;
    if (dice(m, 2) != 0) {
        uint8_t expected[1486];
        size_t room = sizeof got;
        want = model_upload(m, index, subindex, complete, expected, &size);
        code = wire_sdo_upload(w, 0, index, subindex, complete, got, &room);
        if (code != want || (code == 0 && (room != size || memcmp(got, expected, size) != 0)))
            fail_msg(
                "request %u in state %u: upload %04Xh:%u complete %d: expected %08X with %u bytes, got %08X with %u", n,
                m->state, index, subindex, complete, want, size, code, (unsigned int)room);
        return;
    }
    size = dice(m, 24);
    if (size == 0 || (size == 1 && complete && subindex == 0))
        size = 2;
    for (uint32_t i = 0; i < size; i++)
        data[i] = dice(m, 4) == 0 ? 0 : (uint8_t)dice(m, 256);
    want = model_download(m, index, subindex, complete, data, size);
    code = wire_sdo_download(w, 0, index, subindex, complete, data, size);
    if (code != want)
        fail_msg("request %u in state %u: download %04Xh:%u complete %d of %u bytes: expected %08X, got %08X", n,
                 m->state, index, subindex, complete, size, want, code);
}

/* Starts a transfer and abandons it. */
static void random_beginning(wire_t *w, model_t *m)
{
    uint8_t r[1486];
    switch (dice(m, 4)) {
    case 0:
        assert_int_equal(initiate(w, 0x21, 0x2001, 0, 20, r), 10);
        break;
    case 1:
        assert_int_equal(initiate(w, 0x40, 0x2002, 0, 0, r), 10 + IN_LENGTH - 16);
        assert_int_equal(initiate(w, 0x60, 0, 0, 0, r), 3 + IN_LENGTH - 9);
        break;
    case 2:
        assert_int_equal(initiate(w, 0x21, 0x2009, 0, 8, r), 10);
        assert_int_equal(initiate(w, 0x00, 0, 0, 0, r), 10);
        break;
    default:
        expect_abort("unknown command", r, initiate(w, 0xE0, 0x2000, 0, 0, r), 0x2000, 0, COMMAND_CODE);
        break;
    }
}

static void random_session(void **state)
{
    static const uint8_t states[] = {ECT_STATE_PREOP, ECT_STATE_SAFEOP, ECT_STATE_OP};
    (void)state;
    for (size_t s = 0; s < sizeof states; s++) {
        wire_t w;
        model_t m = {.text = "abc", .text_size = 3, .state = states[s], .random = (uint32_t)(12345 + s)};
        memcpy(m.items, start, sizeof start);
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, states[s]);
        fill(testdev_of(&w, 0));
        for (unsigned int n = 0; n < 6000; n++) {
            if (dice(&m, 10) == 0)
                random_beginning(&w, &m);
            random_request(&w, &m, n);
        }
        wire_close(&w);
    }
}

static const struct CMUnitTest tests[] = {
    {"CF-069: an upload of 1 to 4 bytes is expedited with its size, a longer one normal", expedited_and_normal_upload,
     NULL, NULL, NULL},
    {"CF-070: a download of the right length is stored, expedited or normal", expedited_and_normal_download, NULL, NULL,
     NULL},
    {"CF-073: Complete Access upload: packed bits, pad after sub-index 0, gaps, VAR; refused forms",
     complete_access_upload, NULL, NULL, NULL},
    {"CF-073: Complete Access download: as upload; too long or ending inside an element changes nothing",
     complete_access_download, NULL, NULL, NULL},
    {"CF-070 CF-071 CF-072: the reply to a refused request is command 80h in service 2, index, sub-index and code",
     refused_requests, NULL, NULL, NULL},
    {"CF-072: a wrong CoE service or a mail too short gets a mailbox error", wrong_services_and_lengths, NULL, NULL,
     NULL},
    {"CF-069 CF-072: downloads in segments: toggle, lengths, abort, new initiate", segment_dialogues, NULL, NULL, NULL},
    {"CF-069: texts of 0 to 20 characters around the capacity of the mailbox", text_of_every_size, NULL, NULL, NULL},
    {"CF-069: 1000 octets are uploaded in segments through an SM1 of any length", octets_in_every_mailbox, NULL, NULL,
     NULL},
    {"CF-072: a toggle error or a wrong segment ends an upload with its abort", upload_toggle_and_interruptions, NULL,
     NULL, NULL},
    {"CF-072: an upload ended by abort, initiate or INIT does not continue", upload_given_up, NULL, NULL, NULL},
    {"CF-069: 1000 octets are downloaded in segments of any length", octets_in_pieces, NULL, NULL, NULL},
    {"CF-069: numbers are downloaded in segments of any length", numbers_in_pieces, NULL, NULL, NULL},
    {"CF-069: texts are downloaded in segments of any length", text_in_pieces, NULL, NULL, NULL},
    {"CF-070: a wrong length is refused with 06070012 or 06070013 and nothing is stored", wrong_sizes, NULL, NULL,
     NULL},
    {"CF-078: an entry writable in PREOP only is refused later with 08000022", rights_by_state, NULL, NULL, NULL},
    {"CF-078: a download that began in PREOP does not write in SAFEOP what only PREOP may",
     state_changes_during_a_download, NULL, NULL, NULL},
    {"CF-078: no SDO in INIT", no_answer_in_init, NULL, NULL, NULL},
    {"CF-070: the device's refusal becomes its abort code and nothing is stored", device_refuses, NULL, NULL, NULL},
    {"CF-070: the device checks values in segments too", device_refuses_a_segmented_value, NULL, NULL, NULL},
    {"CF-073: one refused element of a whole object: none is stored", nothing_is_stored_when_one_is_refused, NULL, NULL,
     NULL},
    {"CF-070: a device without hooks accepts every value", device_without_hooks, NULL, NULL, NULL},
    {"CF-073: a device that does not offer Complete Access refuses it with 06010000", device_without_complete_access,
     NULL, NULL, NULL},
    {"CF-070: the device is notified of each stored value once", device_is_notified_of_writes, NULL, NULL, NULL},
    {"CF-070: the device runs after each stored value, whatever time it has requested", device_is_polled_after_a_write,
     NULL, NULL, NULL},
    {"CF-073: a whole record longer than the mailbox is uploaded, with bits across the segments",
     whole_record_in_segments_up, NULL, NULL, NULL},
    {"CF-073: a whole record longer than the mailbox is downloaded, with bits across the segments",
     whole_record_in_segments_down, NULL, NULL, NULL},
    {"CF-073: a record of bits is downloaded and uploaded bit by bit; the device gets each element's bits only",
     bits_of_a_record, NULL, NULL, NULL},
    {"CF-073: the mapping of 36 entries as a whole equals its entries one by one", mapping_of_36_entries, NULL, NULL,
     NULL},
    {"CF-073: Complete Access transfers the elements that sub-index 0 declares", declared_elements_only, NULL, NULL,
     NULL},
    {"CF-073 CF-070: no known length, no memory, no sub-index 0, long elements", odd_kinds_of_objects, NULL, NULL,
     NULL},
    {"CF-067: the mandatory objects of every device", mandatory_objects, NULL, NULL, NULL},
    {"CF-068: sub-index 0 of every object counts its entries; beyond them 06090011", subindices, NULL, NULL, NULL},
    {"CF-070 CF-073 CF-078: a random session gives the replies of a model of the dictionary", random_session, NULL,
     NULL, NULL},
    {"CF-069: a text that the device shortens while it is uploaded: the upload ends", text_changes_under_way, NULL,
     NULL, NULL},
    {"CF-073: a list that the device shortens while it is uploaded: the upload ends", list_changes_under_way, NULL,
     NULL, NULL},
};

int main(int argc, char **argv)
{
    /* A server that loops forever must not block the other tests. */
    (void)setrlimit(RLIMIT_CPU, &(struct rlimit){.rlim_cur = 30, .rlim_max = 30});
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SDO", tests, NULL, NULL);
}
