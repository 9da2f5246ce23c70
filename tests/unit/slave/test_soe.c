/* SPDX-License-Identifier: MIT */
/* Servo drive profile over EtherCAT: elements, fragments, protection, commands, process data, transitions. */
#include <string.h>

#include "check/check.h"
#include "support/hex.h"
#include "support/soedev.h"
#include "support/wire.h"

enum { MAIL_HEADER = 6, HEADER = 4, ROOM = 512 };

static wire_t w;

static soedev_t *device(void)
{
    return ect_chain_slave(w.chain, 0)->config.instance;
}

static void open_with(const ect_device_t *description, uint8_t state)
{
    wire_open_one(&w, description);
    if (state == ECT_STATE_BOOT) {
        wire_configure_mailbox(&w, 0);
        assert_int_equal(wire_al(&w, 0, ECT_STATE_BOOT, NULL), ECT_STATE_BOOT);
    } else {
        wire_go(&w, 0, state);
    }
}

static int setup(void **state)
{
    (void)state;
    open_with(&soedev, ECT_STATE_PREOP);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static void reopen(uint8_t state)
{
    wire_close(&w);
    open_with(&soedev, state);
}

/* The device with another SoE, or other mailboxes. */
static void reopen_with(const ect_soe_t *soe, uint16_t mailbox)
{
    static const ect_protocol_t *protocols[2];
    static ect_device_t description;
    description = soedev;
    protocols[0] = &soe->protocol;
    description.protocols = protocols;
    description.soe_channels = soe->drive_count;
    for (unsigned int n = 0; n < 2; n++)
        description.sm[n].length = description.sm[n].minimum = mailbox;
    wire_close(&w);
    open_with(&description, ECT_STATE_PREOP);
}

static void send_bytes(const uint8_t *data, uint16_t length)
{
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_SOE, data, length), 1);
}

static void send(const char *request)
{
    uint8_t data[ROOM];
    const uint16_t length = from_hex(request, data);
    send_bytes(data, length);
}

/* The next mail of SoE is `want`; "": there is none; "!n": it is mailbox error n. */
static void expect_mail(const char *what, const char *want)
{
    uint8_t mail[ROOM], bytes[ROOM];
    const int length = wire_mail_receive(&w, 0, mail, sizeof mail);
    const bool error = want[0] == '!';
    const int wanted = from_hex(want + error, bytes);
    if (wanted == 0 ? length >= 0 : length < 0)
        fail_msg("%s: expected '%s', got %d bytes", what, want, length);
    if (wanted == 0)
        return;
    assert_int_equal(mail[5] & 0x0F, error ? ECT_MAILBOX_TYPE_ERROR : ECT_MAILBOX_TYPE_SOE);
    if (error) {
        if (mail[8] != bytes[0])
            fail_msg("%s: expected mailbox error %u, got %u", what, bytes[0], mail[8]);
        return;
    }
    for (int i = 0; i < length && i < wanted; i++) {
        if (mail[MAIL_HEADER + i] != bytes[i])
            fail_msg("%s: byte %d: expected %02X, got %02X", what, i, bytes[i], mail[MAIL_HEADER + i]);
    }
    if (length != wanted)
        fail_msg("%s: expected %d bytes, got %d", what, wanted, length);
}

static void expect(const char *what, const char *request, const char *reply)
{
    send(request);
    expect_mail(what, reply);
}

typedef struct row {
    const char *what, *request, *reply;
} row_t;

static void expect_each(const row_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        expect(rows[i].what, rows[i].request, rows[i].reply);
}

#define EACH(rows) expect_each(rows, sizeof(rows) / sizeof(rows)[0])

/* --- requests ----------------------------------------------------------------------------------------------------- */

static void vectors(void **state)
{
    static const row_t rows[] = {
        {"SOE-V1", "21 44 2400", "22 44 2400 01002260 00000100"},
        {"SOE-V2", "01 40 1800", "02 40 1800 0400 1800 2400 2F00"},
        {"SOE-V3", "01 40 E703", "12 40 E703 0110"},
        {"SOE-V4", "03 40 2000 0200", "04 40 2000"},
        {"SOE-V5", "03 40 0100 0100", "14 40 0100 0670"},
        {"SOE-V6, started", "03 40 6300 0300", "04 40 6300"},
        {"SOE-V6, it runs", "01 01 6300", "02 01 6300 0700"},
    };
    (void)state;
    EACH(rows);
    assert_int_equal(device()->drive[0].mode, 2);
    ect_soe_finish(&soedev_soe, device(), 0, 99, true);
    expect("SOE-V6, it has ended", "01 01 6300", "02 01 6300 0300");
    expect("SOE-V6, cleared", "03 40 6300 0000", "04 40 6300");
    expect("cleared", "01 01 6300", "02 01 6300 0000");
}

static void malformed(void **state)
{
    static const row_t rows[] = {
        {"1 byte", "01", "!06"},
        {"3 bytes", "01 40 18", "!06"},
        {"operation 0", "00 40 1800", "!04"},
        {"a read response", "02 40 1800 0000", "!04"},
        {"a write response", "04 40 1800", "!04"},
        {"a notification", "05 01 6300 0300", "!04"},
        {"an emergency", "06 00 0000 0000000000000000", "!04"},
        {"operation 7", "07 40 1800", "!04"},
        {"a read in pieces", "09 40 0100", "12 40 0100 0B80"},
        {"bytes behind a read", "01 40 0100 FFFF", "02 40 0100 D007"},
        {"the error flag of a read", "11 40 0100", "02 40 0100 D007"},
    };
    (void)state;
    EACH(rows);
}

static void drives_and_elements(void **state)
{
    static const row_t rows[] = {
        {"drive 2", "41 40 3300", "42 40 3300 00000000"},
        {"drive 3", "61 40 1800", "72 40 1800 0A80"},
        {"drive 7", "E1 40 1000", "F2 40 1000 0A80"},
        {"a write to drive 3", "63 40 1800 00000000", "74 40 1800 0A80"},
        {"an IDN of another drive", "41 40 1800", "52 40 1800 0110"},
        {"S-0-0000", "01 40 0000", "12 40 0000 0110"},
        {"an IDN above all", "01 40 FFFF", "12 40 FFFF 0110"},
        {"no element", "01 00 1800", "12 00 1800 0C80"},
        {"no element of no IDN", "01 00 E703", "12 00 E703 0110"},
        {"no element to write", "03 00 1800 0000", "14 00 1800 0C80"},
    };
    (void)state;
    EACH(rows);
}

static void elements(void **state)
{
    static const row_t rows[] = {
        {"name", "01 02 0180", "12 02 0180 0120"},
        {"name of another", "01 02 0280", "02 02 0280 0600 0600 5369676E6564"},
        {"attribute", "01 04 0180", "02 04 0180 01001100"},
        {"no unit", "01 08 0180", "12 08 0180 0140"},
        {"an empty unit", "01 08 0280", "02 08 0280 0000 0000"},
        {"minimum", "01 10 0180", "02 10 0180 0A00"},
        {"maximum", "01 20 0180", "02 20 0180 60EA"},
        {"default", "01 80 0180", "02 80 0180 6400"},
        {"no minimum", "01 10 2000", "12 10 2000 0150"},
        {"maximum alone", "01 20 2000", "02 20 2000 0B00"},
        {"no maximum", "01 20 2400", "12 20 2400 0160"},
        {"no default", "01 80 2400", "12 80 2400 0180"},
        {"no data state", "01 01 2400", "12 01 2400 1470"},
        {"data state", "01 01 6300", "02 01 6300 0000"},
        {"1 byte", "01 70 0280", "02 70 0280 F6 0A FD"},
        {"8 bytes", "01 F0 0380", "02 F0 0380 0100000000000000 0000000000000080 0000000000010000 0000000000010000"},
        {"a float", "01 40 0480", "02 40 0480 0000803F"},
        {"a text", "01 40 0580", "02 40 0580 0400 1400 74657874"},
        {"a constant text", "01 40 0880", "02 40 0880 0300 0300 312E30"},
        {"a constant number", "01 40 0B00", "02 40 0B00 0180"},
        {"all of a number", "01 FF 0100",
         "02 FE 0100 0D00 0D00 4E43206379636C652074696D65 01001160 0200 0200 7573 FA00 "
         "401F D007 D007"},
        {"all of a command", "41 FF 6300", "42 45 6300 0000 01000900 0000"},
        {"none of several", "41 8A 3300", "42 02 3300 0800 0800 506F736974696F6E"},
        {"all of several are missing", "41 8A 6300", "52 8A 6300 0120"},
    };
    (void)state;
    EACH(rows);
    device()->read_code = ECT_SOE_LOCKED;
    expect("the device refuses", "01 40 0180", "12 40 0180 0C70");
    expect("and is not asked for other elements", "01 20 0180", "02 20 0180 60EA");
    assert_int_equal(device()->last_idn, 0x8001);
}

static void lists_of_idns(void **state)
{
    uint8_t mail[ROOM];
    (void)state;
    send("01 40 1100");
    const int length = wire_mail_receive(&w, 0, mail, sizeof mail);
    const uint16_t bytes = ect_load_le16(mail + MAIL_HEADER + HEADER);
    assert_int_equal(length, HEADER + 4 + bytes);
    assert_int_equal(bytes / 2, soedev_soe.drives[0].count);
    assert_int_equal(ect_load_le16(mail + MAIL_HEADER + HEADER + 2), bytes);
    uint16_t last = 0;
    for (unsigned int at = 0; at < bytes; at += 2) {
        uint8_t request[] = {0x01, 0x40, mail[MAIL_HEADER + 8 + at], mail[MAIL_HEADER + 9 + at]}, reply[ROOM];
        assert_true(ect_load_le16(request + 2) > last);
        last = ect_load_le16(request + 2);
        send_bytes(request, sizeof request);
        do {
            assert_true(wire_mail_receive(&w, 0, reply, sizeof reply) > HEADER);
            assert_int_equal(reply[MAIL_HEADER] & ~0x08, 0x02);
        } while ((reply[MAIL_HEADER] & 0x08) != 0);
    }
    expect("S-0-0187", "01 40 BB00", "02 40 BB00 0600 0600 2800 3300 5400");
    expect("S-0-0188", "01 40 BC00", "02 40 BC00 0600 0600 2400 2F00 0180");
    expect("they cannot be written", "03 40 BC00 0000 0000", "14 40 BC00 0470");
}

/* --- writes ------------------------------------------------------------------------------------------------------- */

static void limits(void **state)
{
    static const row_t rows[] = {
        {"below", "03 40 0180 0900", "14 40 0180 0670"},
        {"the minimum", "03 40 0180 0A00", "04 40 0180"},
        {"the maximum", "03 40 0180 60EA", "04 40 0180"},
        {"above", "03 40 0180 61EA", "14 40 0180 0770"},
        {"short", "03 40 0180 64", "14 40 0180 0270"},
        {"nothing", "03 40 0180", "14 40 0180 0270"},
        {"long", "03 40 0180 640000", "14 40 0180 0370"},
        {"-11", "03 40 0280 F5", "14 40 0280 0670"},
        {"-10", "03 40 0280 F6", "04 40 0280"},
        {"10", "03 40 0280 0A", "04 40 0280"},
        {"11", "03 40 0280 0B", "14 40 0280 0770"},
        {"64 bits: 0", "03 40 0380 0000000000000000", "14 40 0380 0670"},
        {"2^63", "03 40 0380 0000000000000080", "04 40 0380"},
        {"2^63 + 1", "03 40 0380 0100000000000080", "14 40 0380 0770"},
        {"float -1.5", "03 40 0480 0000C0BF", "04 40 0480"},
        {"float -1.6", "03 40 0480 CDCCCCBF", "14 40 0480 0670"},
        {"float -1.4", "03 40 0480 3333B3BF", "04 40 0480"},
        {"float 2.5", "03 40 0480 00002040", "04 40 0480"},
        {"float 2.6", "03 40 0480 66662640", "14 40 0480 0770"},
        {"not a number", "03 40 0480 0000C07F", "14 40 0480 0770"},
        {"maximum alone: 0", "03 40 2000 0000", "04 40 2000"},
        {"maximum alone: 12", "03 40 2000 0C00", "14 40 2000 0770"},
    };
    (void)state;
    EACH(rows);
    assert_int_equal(device()->drive[0].limit, 60000);
    assert_int_equal(device()->drive[0].signed8, 10);
    assert_true(device()->drive[0].number64 == 1ull << 63);
    assert_int_equal(device()->drive[0].gain, 0x40200000);
    assert_int_equal(device()->drive[0].mode, 0);
    assert_int_equal(device()->drive[1].limit, 100);
}

static void lists(void **state)
{
    static const row_t rows[] = {
        {"a text", "03 40 0580 0300 1400 414243", "04 40 0580"},
        {"read again", "01 40 0580", "02 40 0580 0300 1400 414243"},
        {"the maximum does not matter", "03 40 0580 0200 0000 4445", "04 40 0580"},
        {"no lengths", "03 40 0580 020014", "14 40 0580 0270"},
        {"less than announced", "03 40 0580 0300 1400 4142", "14 40 0580 0270"},
        {"more than announced", "03 40 0580 0300 1400 41424344", "14 40 0580 0370"},
        {"more than there is room", "03 40 0580 1500 1500 414141414141414141414141414141414141414141",
         "14 40 0580 0370"},
        {"refused writes change nothing", "01 40 0580", "02 40 0580 0200 1400 4445"},
        {"as much as there is room", "03 40 0580 1400 1400 4141414141414141414141414141414141414141", "04 40 0580"},
        {"one byte", "03 40 0580 0100 1400 42", "04 40 0580"},
        {"read one byte", "01 40 0580", "02 40 0580 0100 1400 42"},
        {"empty", "03 40 0580 0000 0000", "04 40 0580"},
        {"read empty", "01 40 0580", "02 40 0580 0000 1400"},
        {"elements of 4 bytes", "03 40 0780 0800 1000 0102030405060708", "04 40 0780"},
        {"half an element", "03 40 0780 0600 1000 010203040506", "14 40 0780 0270"},
        {"read", "01 40 0780", "02 40 0780 0800 1000 0102030405060708"},
        {"a constant", "03 40 0880 0000 0000", "14 40 0880 0470"},
    };
    (void)state;
    EACH(rows);
}

static void other_elements(void **state)
{
    static const row_t rows[] = {
        {"data state", "03 01 6300 0300", "14 01 6300 0910"},
        {"name", "03 02 0180 0000 0000", "14 02 0180 0420"},
        {"attribute", "03 04 0180 00000000", "14 04 0180 0430"},
        {"unit", "03 08 0180 0000 0000", "14 08 0180 0440"},
        {"minimum", "03 10 0180 0000", "14 10 0180 0450"},
        {"maximum", "03 20 0180 0000", "14 20 0180 0460"},
        {"default", "03 80 0180 0000", "14 80 0180 0480"},
        {"attribute and value", "03 44 0180 00000000 0000", "14 44 0180 0B80"},
        {"a read-only number", "03 40 2800 00000000", "14 40 2800 0470"},
        {"a constant number", "03 40 0B00 0000", "14 40 0B00 0470"},
    };
    (void)state;
    EACH(rows);
}

/* Rights by state, and their order. */
static void protection(void **state)
{
    static const struct {
        uint8_t state;
        row_t rows[6];
    } each[] = {
        {ECT_STATE_PREOP,
         {{"in SAFEOP and OP locked", "03 40 0100 E803", "04 40 0100"},
          {"in OP locked", "03 40 0680 0100", "04 40 0680"},
          {"in PREOP locked", "03 40 0980 0100", "14 40 0980 0570"},
          {"locked, and too short", "03 40 0980 01", "14 40 0980 0570"},
          {"in the MDT", "03 40 2F00 01000000", "04 40 2F00"},
          {"control word", "03 40 8600 0000", "04 40 8600"}}},
        {ECT_STATE_SAFEOP,
         {{"in SAFEOP and OP locked", "03 40 0100 E803", "14 40 0100 0570"},
          {"in OP locked", "03 40 0680 0100", "04 40 0680"},
          {"in PREOP locked", "03 40 0980 0100", "04 40 0980"},
          {"in the MDT and locked", "03 40 2400 01000000", "14 40 2400 0570"},
          {"in the MDT, and too short", "03 40 2F00 01", "14 40 2F00 0A70"},
          {"control word", "03 40 8600 0000", "14 40 8600 0A70"}}},
        {ECT_STATE_OP,
         {{"in SAFEOP and OP locked", "03 40 0100 E803", "14 40 0100 0570"},
          {"in OP locked", "03 40 0680 0100", "14 40 0680 0570"},
          {"in PREOP locked", "03 40 0980 0100", "04 40 0980"},
          {"in the MDT", "03 40 2F00 01000000", "14 40 2F00 0A70"},
          {"not in the MDT", "03 40 0180 0F00", "04 40 0180"},
          {"a read-only value", "03 40 2800 01000000", "14 40 2800 0470"}}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof each / sizeof each[0]; i++) {
        reopen(each[i].state);
        EACH(each[i].rows);
    }
}

static void refused_by_the_device(void **state)
{
    (void)state;
    device()->write_code = ECT_SOE_PASSWORD;
    expect("a number", "03 40 0180 0F00", "14 40 0180 0970");
    expect("a list", "03 40 0580 0000 0000", "14 40 0580 0970");
    expect("the limit is checked first", "03 40 0180 0900", "14 40 0180 0670");
    assert_int_equal(device()->written, 0);
    assert_int_equal(device()->drive[0].limit, 100);
    device()->write_code = ECT_SOE_OK;
    expect("a number", "23 40 0180 0F00", "24 40 0180");
    assert_int_equal(device()->written, 1);
    assert_int_equal(device()->last_idn, 0x8001);
    assert_int_equal(device()->last_drive, 1);
    assert_true(device()->last_ns == w.now_ns);
    assert_int_equal(device()->drive[1].limit, 15);
}

/* --- fragments ---------------------------------------------------------------------------------------------------- */

/* A write to S-0-0016 of drive `head >> 5`, in pieces of `piece` bytes: `total` bytes of S-0-0051, its length first.
 * The counter of pieces is `wrong` too large. */
static void write_pieces(uint8_t head, uint16_t total, uint16_t piece, uint16_t wrong)
{
    uint8_t value[ROOM] = {0}, mail[ROOM];
    ect_store_le16(value, (uint16_t)(total - 4));
    for (unsigned int at = 4; at < total; at += 2)
        value[at] = 51;
    for (uint16_t at = 0; at < total; at = (uint16_t)(at + piece)) {
        const uint16_t rest = (uint16_t)(total - at);
        const bool last = rest <= piece;
        const uint16_t bytes = last ? rest : piece;
        mail[0] = (uint8_t)(head | (last ? 0 : 0x08));
        mail[1] = 0x40;
        ect_store_le16(mail + 2, (uint16_t)(last ? 16 : (rest - 1) / piece + wrong));
        memcpy(mail + HEADER, value + at, bytes);
        send_bytes(mail, (uint16_t)(HEADER + bytes));
        if (!last)
            expect_mail("a piece gets no reply", "");
    }
}

static void write_fragments(void **state)
{
    (void)state;
    write_pieces(0x43, 300, 118, 0); /* SOE-V7, for drive 2 */
    expect_mail("SOE-V7", "44 40 1000");
    assert_int_equal(device()->long_list.used, 296);
    assert_int_equal(device()->long_list.data[294], 51);
    for (uint16_t total = 116; total <= 120; total = (uint16_t)(total + 2)) {
        write_pieces(0x43, total, 118, 0);
        expect_mail("one or two pieces", "44 40 1000");
        assert_int_equal(device()->long_list.used, total - 4);
    }
    write_pieces(0x43, 300, 10, 1); /* as SOEM and LEC may count */
    expect_mail("one too many counted", "44 40 1000");
    assert_int_equal(device()->long_list.used, 296);
    write_pieces(0x43, 302, 118, 0);
    expect_mail("one IDN too many", "54 40 1000 0370");
    assert_int_equal(device()->long_list.used, 296);
}

/* A buffer of exactly the size of a value accepts the value, and no further byte. */
static void write_fills_the_buffer(void **state)
{
    ect_soe_t soe = soedev_soe;
    (void)state;
    for (uint16_t room = 299; room <= 300; room++) {
        soe.buffer_size = room;
        reopen_with(&soe, SOEDEV_MAILBOX);
        write_pieces(0x43, 300, 118, 0);
        expect_mail("300 bytes", room == 300 ? "44 40 1000" : "54 40 1000 0370");
        assert_int_equal(device()->long_list.used, room == 300 ? 296 : 0);
    }
}

/* More data than the device can keep are discarded; the last piece gets the error, after those of drive and IDN. */
static void write_too_much(void **state)
{
    static const char *const refusals[][2] = {{"43 40 1000", "54 40 1000 0370"},
                                              {"43 40 E703", "54 40 E703 0110"},
                                              {"63 40 1000", "74 40 1000 0A80"},
                                              {"43 40 3300", "54 40 3300 0470"}};
    uint8_t mail[122] = {0};
    (void)state;
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++) {
        (void)from_hex(refusals[i][0], mail);
        mail[0] |= 0x08;
        for (unsigned int n = 0; n < 600; n++) {
            send_bytes(mail, sizeof mail);
            expect_mail("a piece", "");
        }
        expect("the last one", refusals[i][0], refusals[i][1]);
    }
    write_pieces(0x43, 44, 20, 0);
    expect_mail("the next write", "44 40 1000");
}

static void write_interrupted(void **state)
{
    (void)state;
    send("0B 40 0100 9999");
    expect("another drive in between", "23 40 0180 0F00", "24 40 0180");
    send("0B 40 0100 E8");
    send("0B 02 0100 03");
    expect("other elements in between", "03 02 0100 03", "14 02 0100 0420");
    send("0B 40 0100 9999");
    expect("a read in between", "01 40 0180", "02 40 0180 6400");
    expect("the piece before it is dropped", "03 40 0180 1000", "04 40 0180");
    send("0B 40 0100 11");
    expect("two pieces of a number", "03 40 0180 00", "04 40 0180");
    assert_int_equal(device()->drive[0].limit, 17);
    send("0B 40 0100 9999");
    assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
    wire_go(&w, 0, ECT_STATE_PREOP);
    expect("INIT in between", "03 40 0180 1200", "04 40 0180");
}

/* Fetches a reply in pieces. @return bytes of its elements */
static uint16_t fetch(uint8_t head, uint16_t idn, uint16_t room, uint8_t *to)
{
    uint8_t mail[ROOM];
    uint16_t length = 0, behind = 0;
    for (bool first = true;; first = false) {
        const int bytes = wire_mail_receive(&w, 0, mail, sizeof mail) - HEADER;
        assert_true(bytes > 0 && bytes <= room);
        memcpy(to + length, mail + MAIL_HEADER + HEADER, (size_t)bytes);
        length = (uint16_t)(length + bytes);
        const uint16_t count = ect_load_le16(mail + MAIL_HEADER + 2);
        assert_int_equal(mail[MAIL_HEADER] & ~0x08, head);
        if ((mail[MAIL_HEADER] & 0x08) == 0) {
            assert_int_equal(count, idn);
            assert_true(first || behind == 1);
            return length;
        }
        assert_int_equal(bytes, room);
        assert_true(count > 0 && (first || count == behind - 1));
        behind = count;
    }
}

static void read_fragments(void **state)
{
    static const uint16_t mailboxes[] = {24, 32, 33, 64, 128};
    uint8_t got[ROOM];
    (void)state;
    for (size_t i = 0; i < sizeof mailboxes / sizeof mailboxes[0]; i++) {
        reopen_with(&soedev_soe, mailboxes[i]);
        for (unsigned int used = 0; used <= SOEDEV_LONG; used += 2) {
            device()->long_list.used = (uint16_t)used;
            for (unsigned int at = 0; at < used; at++)
                device()->long_list.data[at] = (uint8_t)(at * 5 + i);
            send("41 40 1000");
            assert_int_equal(fetch(0x42, 16, (uint16_t)(mailboxes[i] - 10), got), used + 4);
            assert_int_equal(ect_load_le16(got), used);
            assert_int_equal(ect_load_le16(got + 2), SOEDEV_LONG);
            assert_memory_equal(got + 4, device()->long_list.data, used);
            expect_mail("no mail more", "");
        }
    }
}

static void read_interrupted(void **state)
{
    uint8_t mail[ROOM];
    (void)state;
    device()->long_list.used = SOEDEV_LONG;
    send("41 40 1000");
    device()->long_list.used = 0; /* the reply has the value of the request */
    send("01 40 0180");
    assert_true(wire_mail_receive(&w, 0, mail, sizeof mail) == SOEDEV_MAILBOX - MAIL_HEADER);
    assert_int_equal(mail[MAIL_HEADER], 0x4A);
    assert_int_equal(mail[MAIL_HEADER + 2], 2);
    expect_mail("the new read ends the old reply", "02 40 0180 6400");
    expect_mail("nothing of it follows", "");
    device()->long_list.used = SOEDEV_LONG;
    send("41 40 1000");
    send("03 40 0180 1500");
    (void)wire_mail_receive(&w, 0, mail, sizeof mail);
    expect_mail("a write ends it", "04 40 0180");
    expect_mail("nothing of it follows", "");
    send("41 40 1000");
    (void)wire_mail_receive(&w, 0, mail, sizeof mail);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
    wire_go(&w, 0, ECT_STATE_PREOP);
    expect_mail("INIT ends it", "");
}

/* --- commands ----------------------------------------------------------------------------------------------------- */

static void commands(void **state)
{
    static const row_t running[] = {
        {"started again", "03 40 9400 0300", "14 40 9400 1070"},
        {"set", "03 40 9400 0100", "14 40 9400 1070"},
        {"it runs", "01 41 9400", "02 41 9400 0700 0300"},
    };
    (void)state;
    expect("start", "03 40 9400 0300", "04 40 9400");
    assert_int_equal(device()->commands, 1);
    assert_int_equal(device()->last_idn, 148);
    assert_true(device()->last_ns == w.now_ns);
    EACH(running);
    device()->command_code = ECT_SOE_COMMAND_GOES_ON;
    expect("it cannot be cancelled", "03 40 9400 0000", "14 40 9400 1170");
    device()->command_code = ECT_SOE_OK;
    expect("cancel", "03 40 9400 0000", "04 40 9400");
    assert_int_equal(device()->cancels, 2);
    ect_soe_finish(&soedev_soe, device(), 0, 148, true);
    expect("it has not ended, but been cancelled", "01 41 9400", "02 41 9400 0000 0000");
    expect("set", "03 40 9400 0100", "04 40 9400");
    expect("it is set", "01 41 9400", "02 41 9400 0100 0100");
    expect("start", "03 40 9400 0300", "04 40 9400");
    ect_soe_finish(&soedev_soe, device(), 0, 148, false);
    expect("an error", "01 01 9400", "02 01 9400 0F00");
    expect("start again", "03 40 9400 0300", "04 40 9400");
    expect("it runs", "01 01 9400", "02 01 9400 0700");
    ect_soe_finish(&soedev_soe, device(), 0, 148, true);
    expect("clear", "03 40 9400 0000", "04 40 9400");
    assert_int_equal(device()->cancels, 2); /* an ended command is not cancelled */
    expect("2", "03 40 9400 0200", "14 40 9400 0870");
    expect("1 byte", "03 40 9400 03", "14 40 9400 0270");
    device()->ends_at_once = true;
    expect("one that ends at once", "03 40 9400 0300", "04 40 9400");
    expect("ended", "01 01 9400", "02 01 9400 0300");
    device()->command_code = ECT_SOE_COMMAND_NOT_NOW;
    expect("not now", "03 40 9400 0300", "14 40 9400 1270");
    expect("as before", "01 41 9400", "02 41 9400 0300 0300");
    device()->command_code = ECT_SOE_COMMAND_NEVER;
    expect("never", "23 40 9400 0300", "34 40 9400 1370");
    expect("untouched", "21 41 9400", "22 41 9400 0000 0000");
}

static void command_change(void **state)
{
    (void)state;
    device()->ends_at_once = true;
    device()->drive[0].status = 0xC000;
    expect("first", "03 40 6300 0300", "04 40 6300");
    expect("bit 5", "01 40 8700", "02 40 8700 20C0");
    expect("second", "03 40 9400 0300", "04 40 9400");
    expect("clear the first", "03 40 6300 0000", "04 40 6300");
    expect("bit 5 for the second", "01 40 8700", "02 40 8700 20C0");
    expect("clear the second", "03 40 9400 0000", "04 40 9400");
    expect("no bit 5", "01 40 8700", "02 40 8700 00C0");
    expect("a drive that leaves bit 5 alone", "23 40 6300 0300", "24 40 6300");
    expect("no bit 5", "21 40 8700", "22 40 8700 0000");
}

static void notifications(void **state)
{
    (void)state;
    device()->ends_at_once = true;
    expect("off by default", "03 40 6300 0300", "04 40 6300");
    expect_mail("off by default", "");
    reopen_with(&soedev_quiet, SOEDEV_MAILBOX);
    expect("start", "03 40 6300 0300", "04 40 6300");
    expect_mail("its end, without a function of the device", "05 01 6300 0300");
    expect_mail("once", "");
    expect("clear", "03 40 6300 0000", "04 40 6300");
    expect_mail("no notification", "");
}

static void emergencies(void **state)
{
    static const uint8_t data[5] = {1, 2, 3, 4, 5};
    (void)state;
    ect_soe_emergency(&soedev_soe, device(), 1, 0xFF01, 0x81, data);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
    expect_mail("an emergency", "26 00 0000 01FF 81 0102030405");
    expect_mail("once", "");
    device()->long_list.used = SOEDEV_LONG;
    send("41 40 1000");
    for (unsigned int i = 0; i < ECT_SOE_EMERGENCIES + 2; i++)
        ect_soe_emergency(&soedev_soe, device(), 0, (uint16_t)(i + 1), 0, data);
    uint8_t got[ROOM];
    assert_int_equal(fetch(0x42, 16, SOEDEV_MAILBOX - 10, got), SOEDEV_LONG + 4);
    expect_mail("behind the reply", "06 00 0000 0100 00 0102030405");
    expect_mail("in order", "06 00 0000 0200 00 0102030405");
    expect_mail("in order", "06 00 0000 0300 00 0102030405");
    expect_mail("in order", "06 00 0000 0400 00 0102030405");
    expect_mail("no more", "");
    assert_int_equal(device()->soe.emergencies_lost, 2);
}

/* Before the mailbox has started, nothing is lost. */
static void emergency_at_power_on(void **state)
{
    static const uint8_t data[5] = {0};
    (void)state;
    wire_close(&w);
    wire_open_one(&w, &soedev);
    ect_soe_emergency(&soedev_soe, device(), 2, 0x1000, 0, data);
    wire_go(&w, 0, ECT_STATE_PREOP);
    expect_mail("sent in PREOP", "46 00 0000 0010 00 0000000000");
}

/* --- process data ------------------------------------------------------------------------------------------------- */

static void telegrams(void **state)
{
    static const row_t rows[] = {
        {"S-0-0015 = 6", "03 40 0F00 0600", "14 40 0F00 0870"},
        {"S-0-0015 = 7", "03 40 0F00 0700", "04 40 0F00"},
        {"an IDN of the MDT in the AT", "03 40 1000 0200 0000 2400", "14 40 1000 0870"},
        {"an IDN of the AT in the MDT", "03 40 1800 0400 0000 2400 2800", "14 40 1800 0870"},
        {"no IDN", "03 40 1000 0400 0000 2800 E703", "14 40 1000 0870"},
        {"13 IDNs", "03 40 1000 1A00 1A00 2800 2800 2800 2800 2800 2800 2800 2800 2800 2800 2800 2800 2800",
         "14 40 1000 0370"},
        {"unchanged", "01 40 1000", "02 40 1000 0400 1800 2800 3300"},
        {"AT of drive 0", "03 40 1000 0600 0000 5400 3300 2800", "04 40 1000"},
        {"MDT of drive 0", "03 40 1800 0000 0000", "04 40 1800"},
        {"MDT of drive 1", "23 40 1800 0600 0000 2F00 0180 2400", "24 40 1800"},
    };
    uint16_t code = 0;
    uint8_t in[22], out[14];
    (void)state;
    EACH(rows);
    /* MDT 2 + 0, 2 + 4 + 2 + 4; AT 2 + 2 + 4 + 4, 2 + 4 + 4 */
    wire_set_sm(&w, 0, 2, 0x1000, 20, 0x24);
    wire_set_sm(&w, 0, 3, 0x1100, 22, 0x20);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, &code), ECT_STATE_PREOP | 0x10);
    assert_int_equal(code, ECT_AL_OUTPUT_SM);
    wire_set_sm(&w, 0, 2, 0x1000, 14, 0x24);
    wire_set_sm(&w, 0, 3, 0x1100, 20, 0x20);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP | 0x10, &code), ECT_STATE_PREOP | 0x10);
    assert_int_equal(code, ECT_AL_INPUT_SM);
    wire_set_sm(&w, 0, 3, 0x1100, 22, 0x20);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP | 0x10, &code), ECT_STATE_SAFEOP);
    for (unsigned int i = 0; i < sizeof out; i++)
        out[i] = (uint8_t)(i + 1);
    assert_int_equal(wire_write(&w, 0, 0x1000, out, sizeof out), 1);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_OP, &code), ECT_STATE_OP);
    assert_int_equal(wire_write(&w, 0, 0x1000, out, sizeof out), 1);
    assert_int_equal(device()->drive[0].control, 0x0201);
    assert_int_equal(device()->drive[0].position_set, 0);
    assert_int_equal(device()->drive[1].control, 0x0403);
    assert_int_equal(device()->drive[1].position_set, 0x08070605);
    assert_int_equal(device()->drive[1].limit, 0x0A09);
    assert_int_equal(device()->drive[1].velocity_set, 0x0E0D0C0B);
    device()->drive[0].torque = 0x1234;
    device()->drive[0].status = 0xC008;
    wire_advance(&w, 10 * MS);
    assert_int_equal(wire_write(&w, 0, 0x1000, out, sizeof out), 1);
    assert_int_equal(wire_read(&w, 0, 0x1100, in, sizeof in), 1);
    assert_int_equal(wire_read(&w, 0, 0x1100, in, sizeof in), 1);
    assert_int_equal(ect_load_le16(in), 0xC008);
    assert_int_equal(ect_load_le16(in + 2), 0x1234);
    assert_int_equal(ect_load_le32(in + 12 + 2), 0x0E0D0C0B); /* velocity of drive 1 */
    assert_int_equal(ect_load_le32(in + 12 + 6), 0x08070605);
}

/* An IDN that the MDT no longer has is written by the service channel again. */
static void shorter_list(void **state)
{
    (void)state;
    expect("one IDN less", "03 40 1800 0200 0000 2400", "04 40 1800");
    wire_set_sm(&w, 0, 2, 0x1000, 16, 0x24);
    wire_set_sm(&w, 0, 3, 0x1100, 20, 0x20);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    expect("S-0-0047 of drive 0", "03 40 2F00 05000000", "04 40 2F00");
    expect("S-0-0047 of drive 1", "23 40 2F00 05000000", "34 40 2F00 0A70");
}

static void defaults(void **state)
{
    (void)state;
    assert_int_equal(device()->drive[1].cycle_us, 2000);
    assert_int_equal(device()->drive[1].signed8, -3);
    assert_int_equal(device()->drive[0].text.used, 4);
    assert_int_equal(device()->drive[0].mdt_count, 3);
    assert_int_equal(device()->drive[1].at_map[1], ECT_MAP(0x6010, 3, 32));
    expect("changed", "03 40 0100 E803", "04 40 0100");
    wire_go(&w, 0, ECT_STATE_OP);
}

/* --- transitions -------------------------------------------------------------------------------------------------- */

static void transition_checks(void **state)
{
    uint16_t code = 0;
    (void)state;
    device()->drive[0].cycle_us = 0;
    device()->drive[1].cycle_us = 9000;
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, &code), ECT_STATE_PREOP | 0x10);
    assert_int_equal(code, ECT_AL_SETTINGS);
    expect("S-0-0021", "01 40 1500", "02 40 1500 0200 0600 0100");
    expect("S-0-0021 of drive 1", "21 40 1500", "22 40 1500 0200 0600 0100");
    expect("written", "03 40 0100 D007", "04 40 0100");
    expect("written", "23 40 0100 D007", "24 40 0100");
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP | 0x10, &code), ECT_STATE_SAFEOP);
    expect("S-0-0021 is empty", "01 40 1500", "02 40 1500 0000 0600");
    device()->drive[0].mode = 12;
    assert_int_equal(wire_outputs(&w, 0, 0), 1);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_OP, &code), ECT_STATE_SAFEOP | 0x10);
    assert_int_equal(code, ECT_AL_SETTINGS);
    expect("S-0-0022", "01 40 1600", "02 40 1600 0200 0400 2000");
    device()->drive[0].mode = 11;
    device()->refuses_state = true; /* of drive 1, whose limits are met */
    assert_int_equal(wire_al(&w, 0, ECT_STATE_OP | 0x10, &code), ECT_STATE_SAFEOP | 0x10);
    expect("S-0-0022", "01 40 1600", "02 40 1600 0000 0400");
    expect("S-0-0022 of drive 1", "21 40 1600", "22 40 1600 0200 0400 2000");
    device()->refuses_state = false;
    assert_int_equal(wire_al(&w, 0, ECT_STATE_OP | 0x10, &code), ECT_STATE_OP);
}

static void check_commands(void **state)
{
    (void)state;
    expect("S-0-0128 in PREOP", "03 40 8000 0300", "14 40 8000 1270");
    expect("S-0-0127", "03 40 7F00 0300", "04 40 7F00");
    expect("it is good", "01 01 7F00", "02 01 7F00 0300");
    device()->drive[0].cycle_us = 1;
    expect("S-0-0127", "03 40 7F00 0300", "04 40 7F00");
    expect("an error", "01 01 7F00", "02 01 7F00 0F00");
    expect("S-0-0021", "01 40 1500", "02 40 1500 0200 0600 0100");
    expect("drive 1 is good", "23 40 7F00 0300", "24 40 7F00");
    expect("drive 1 is good", "21 01 7F00", "22 01 7F00 0300");
    assert_int_equal(device()->commands, 0); /* the stack executes them */
    reopen(ECT_STATE_SAFEOP);
    expect("S-0-0127 in SAFEOP", "03 40 7F00 0300", "14 40 7F00 1270");
    expect("S-0-0128", "03 40 8000 0300", "04 40 8000");
    expect("it is good", "01 01 8000", "02 01 8000 0300");
    device()->drive[0].mode = 99;
    expect("S-0-0128", "03 40 8000 0300", "04 40 8000");
    expect("an error", "01 01 8000", "02 01 8000 0F00");
}

/* A device without functions: limits alone decide, and a command ends at once. */
static void no_functions(void **state)
{
    uint16_t code = 0;
    (void)state;
    reopen_with(&soedev_quiet, SOEDEV_MAILBOX);
    expect("a read", "01 40 2000", "02 40 2000 0000");
    expect("a write", "03 40 2000 0500", "04 40 2000");
    assert_int_equal(device()->mode, 5);
    wire_configure_process_data(&w, 0);
    device()->mode = 12;
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, &code), ECT_STATE_PREOP | 0x10);
    assert_int_equal(code, ECT_AL_SETTINGS);
    expect("a constant S-0-0021", "01 40 1500", "02 40 1500 0000 0000");
    device()->plain.state = ECT_SOE_COMMAND_RUNS;
    expect("a cancel", "03 40 6300 0000", "04 40 6300");
    expect("cancelled", "01 01 6300", "02 01 6300 0000");
    device()->mode = 11;
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP | 0x10, &code), ECT_STATE_SAFEOP);
    expect("a drive without MDT", "03 40 1000 0200 0000 3300", "04 40 1000");
    wire_close(&w);
    wire_open_one(&w, &soedev);
    device()->plain.state = ECT_SOE_COMMAND_RUNS;
    ect_soe_finish(&soedev_quiet, device(), 0, 99, false);
    assert_int_equal(device()->plain.state, ECT_SOE_COMMAND_ERROR);
}

/* More IDNs that a state needs than S-0-0021 has room for. */
static void full_list(void **state)
{
    static const ect_soe_idn_t idns[] = {
        {.idn = ECT_SOE_S(1), .flags = ECT_SOE_CHECK_OP | ECT_SOE_MINIMUM, .attribute = ECT_SOE_16, .minimum = 1},
        {.idn = ECT_SOE_S(2), .flags = ECT_SOE_CHECK_OP | ECT_SOE_MAXIMUM, .attribute = ECT_SOE_16, .initial = 1},
        {.idn = ECT_SOE_S(3), .flags = ECT_SOE_CHECK_OP | ECT_SOE_MINIMUM, .attribute = ECT_SOE_16, .minimum = 1},
        {.idn = ECT_SOE_S(4), .flags = ECT_SOE_CHECK_OP, .attribute = ECT_SOE_16 | ECT_SOE_LIST},
        {.idn = ECT_SOE_S(22),
         .attribute = ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_IDNS,
         .size = 4,
         .offset = offsetof(soedev_t, drive[0].not_op)},
        {.idn = ECT_SOE_S(128), .attribute = ECT_SOE_16 | ECT_SOE_COMMAND, .offset = offsetof(soedev_t, plain)},
    };
    static const ect_soe_drive_t drive = {.idns = idns, .count = sizeof idns / sizeof idns[0]};
    ect_soe_t soe = soedev_quiet;
    (void)state;
    soe.drives = &drive;
    soe.notifies = false;
    reopen_with(&soe, SOEDEV_MAILBOX);
    wire_go(&w, 0, ECT_STATE_SAFEOP);
    expect("S-0-0128", "03 40 8000 0300", "04 40 8000");
    expect("an error", "01 01 8000", "02 01 8000 0F00");
    expect("the first two", "01 40 1600", "02 40 1600 0400 0400 0100 0200");
}

static void not_in_boot(void **state)
{
    ect_device_t description = soedev;
    (void)state;
    description.boot_out = (ect_boot_mailbox_t){soedev.sm[0].start, SOEDEV_MAILBOX};
    description.boot_in = (ect_boot_mailbox_t){soedev.sm[1].start, SOEDEV_MAILBOX};
    wire_close(&w);
    open_with(&description, ECT_STATE_BOOT);
    expect("BOOT", "01 40 0100", "!02");
    wire_close(&w);
    open_with(&soedev, ECT_STATE_INIT);
}

/* --- sizes -------------------------------------------------------------------------------------------------------- */

static void sizes(void **state)
{
    static const ect_soe_idn_t named = {.idn = 1, .attribute = ECT_SOE_16, .name = "name", .unit = "us"};
    static const ect_soe_drive_t drive = {.idns = &named, .count = 1};
    const ect_soe_t one = {.drive_count = 1, .drives = &drive};
    ect_device_t description = soedev;
    (void)state;
    assert_int_equal(ect_soe_longest(&soedev_soe), 38 + 13 + 4 + SOEDEV_TEXT); /* P-0-0010 */
    assert_int_equal(ect_soe_longest(&soedev_quiet), 38 + 11 + 4 + SOEDEV_LONG);
    assert_int_equal(ect_soe_longest(&one), 38 + 4 + 4 + 4 + 2);
    assert_true(ect_soe_fits(&description));
    for (unsigned int n = 0; n < 2; n++) {
        description.sm[n].minimum = ECT_SOE_MAILBOX_LEAST - 1;
        assert_false(ect_soe_fits(&description));
        description.sm[n].minimum = 0;
    }
    assert_null(ect_soe_find(&soedev_soe.drives[0], 2));
    assert_int_equal(ect_soe_find(&soedev_soe.drives[0], ECT_SOE_P(9))->idn, 0x8009);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("SOE-V1 SOE-V2 SOE-V3 SOE-V4 SOE-V5 SOE-V6 the vectors, byte for byte", vectors),
        TEST("SOE-001 malformed mails and other operations get a mailbox error", malformed),
        TEST("SOE-002 SOE-003 SOE-004 SOE-005 SOE-044 drives, IDNs and elements that are missing", drives_and_elements),
        TEST("SOE-006 SOE-007 SOE-008 SOE-043 elements alone and together, in order", elements),
        TEST("SOE-033 SOE-034 S-0-0017 lists all IDNs, S-0-0187 and S-0-0188 the choice", lists_of_idns),
        TEST("SOE-011 SOE-012 lengths and limits of numbers", limits),
        TEST("SOE-008 SOE-009 SOE-012 lengths of lists", lists),
        TEST("SOE-010 SOE-011 elements other than the value, and constants, are read only", other_elements),
        TEST("SOE-011 protection by AL state and by process data", protection),
        TEST("SOE-011 SOE-012 the device can refuse a value", refused_by_the_device),
        TEST("SOE-014 SOE-015 SOE-016 SOE-V7 a write in pieces", write_fragments),
        TEST("SOE-014 SOE-017 a write in pieces may fill the buffer", write_fills_the_buffer),
        TEST("SOE-017 too much data are discarded, the last fragment gets the error", write_too_much),
        TEST("SOE-017 a write in pieces ends at another request", write_interrupted),
        TEST("SOE-013 replies in pieces, of each length, through mailboxes of 24 to 128 bytes", read_fragments),
        TEST("SOE-018 a reply in pieces ends at another request", read_interrupted),
        TEST("SOE-030 SOE-031 commands start, run, end, fail, are cancelled and refused", commands),
        TEST("SOE-032 bit 5 of S-0-0135 reports ended commands", command_change),
        TEST("SOE-019 SOE-020 the end of a command is notified if the device enables it", notifications),
        TEST("SOE-019 SOE-020 emergencies follow the active reply, at most four wait", emergencies),
        TEST("SOE-020 an emergency raised before PREOP is sent in PREOP", emergency_at_power_on),
        TEST("SOE-035 SOE-036 SOE-037 SOE-038 process data follow S-0-0016 and S-0-0024", telegrams),
        TEST("SOE-011 SOE-036 an IDN outside S-0-0024 is no process data", shorter_list),
        TEST("SOE-046 defaults are set, and written values permit OP", defaults),
        TEST("SOE-040 SOE-046 transitions check the written values; S-0-0021 and S-0-0022", transition_checks),
        TEST("SOE-040 S-0-0127 and S-0-0128 check a transition as commands", check_commands),
        TEST("SOE-030 SOE-046 a device without functions has values, commands and checks", no_functions),
        TEST("SOE-040 S-0-0022 lists as many IDNs as fit", full_list),
        TEST("SOE-021 BOOT refuses SoE", not_in_boot),
        TEST("SoE: sizes of buffer and mailboxes", sizes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
