/* SPDX-License-Identifier: MIT */
/* ADS over EtherCAT: commands, index groups, refusals, and the order with other mail. */
#include <string.h>

#include "seams/aoe.h"
#include "support/hex.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SM0 = 0x1800, SM1 = 0x1C00, SIZE = 128, MAIL_HEADER = 6, AMS = 32, ROOM = 512 };
enum { COMMAND = 16, FLAGS = 18, LENGTH = 20, ERROR = 24, INVOKE = 28 };
enum { INFO = 1, READ, WRITE, STATE, CONTROL, ADD, DELETE, NOTIFY, READ_WRITE };
enum { NOTHING = -1, MAILBOX_ERROR = -2 };
enum { OWN_GROUP = 0x00112233, OWN_OFFSET = 0x44556677 };

typedef struct adsdev {
    testdev_t base;
    ect_aoe_state_t aoe;
    uint8_t own[8]; /* the value of OWN_GROUP */
    uint32_t own_length;
    bool instead; /* octets come from `bytes` */
    uint8_t bytes[300];
} adsdev_t;

static wire_t w;
static uint16_t mailbox_size = SIZE; /* of the devices that a test opens */

static uint32_t own_read(const ect_aoe_t *aoe, void *instance, uint32_t group, uint32_t offset, uint8_t *data,
                         uint32_t *length)
{
    const adsdev_t *d = instance;
    (void)aoe;
    if (group != OWN_GROUP)
        return ECT_ADS_NO_GROUP;
    if (offset != OWN_OFFSET)
        return ECT_ADS_NO_OFFSET;
    if (*length < d->own_length)
        return ECT_ADS_SIZE;
    memcpy(data, d->own, d->own_length);
    *length = d->own_length;
    return ECT_ADS_OK;
}

static uint32_t own_write(const ect_aoe_t *aoe, void *instance, uint32_t group, uint32_t offset, const uint8_t *data,
                          uint32_t length)
{
    adsdev_t *d = instance;
    (void)aoe;
    if (group != OWN_GROUP || offset != OWN_OFFSET)
        return ECT_ADS_NO_GROUP;
    if (length > sizeof d->own)
        return ECT_ADS_SIZE;
    memcpy(d->own, data, length);
    d->own_length = length;
    return ECT_ADS_OK;
}

static ect_reason_t sdo_read(void *instance, uint16_t index, uint16_t subindex, ect_span_t *instead)
{
    const adsdev_t *d = instance;
    (void)subindex;
    if (d->instead && index == 0x2002)
        *instead = (ect_span_t){d->bytes, sizeof d->bytes};
    return ECT_OK;
}

static const ect_aoe_t plain = {ECT_AOE_PROTOCOL, offsetof(adsdev_t, aoe), .version = 3, .revision = 2, .build = 0x102};
static const ect_aoe_t with_own = {ECT_AOE_PROTOCOL, offsetof(adsdev_t, aoe), .read = own_read, .write = own_write};

static adsdev_t *ads(void)
{
    return (adsdev_t *)(void *)testdev_of(&w, 0);
}

static void open_ads(const ect_aoe_t *entry, uint8_t state, bool coe)
{
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    static ect_device_t device;
    device = testdev_with(&entry->protocol, protocols, ECT_MAILBOX_AOE, sizeof(adsdev_t));
    device.sm[0].start = SM0;
    device.sm[1].start = SM1;
    for (unsigned int n = 0; n < 2; n++)
        device.sm[n].length = device.sm[n].minimum = device.sm[n].maximum = mailbox_size;
    device.boot_out = (ect_boot_mailbox_t){SM0, mailbox_size};
    device.boot_in = (ect_boot_mailbox_t){SM1, mailbox_size};
    device.sdo_read = sdo_read;
    if (!coe)
        device.mailbox_protocols = ECT_MAILBOX_AOE;
    wire_open_one(&w, &device);
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
    open_ads(&plain, ECT_STATE_PREOP, true);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    mailbox_size = SIZE;
    return 0;
}

static void reopen(const ect_aoe_t *entry, uint8_t state, bool coe)
{
    wire_close(&w);
    open_ads(entry, state, coe);
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

/* Target, source and invoke id of each request. */
static const uint8_t target[8] = {10, 20, 30, 40, 2, 1, 0x34, 0x12};
static const uint8_t source[8] = {10, 20, 30, 40, 1, 1, 0xE9, 0x80};
static const uint8_t invoke[4] = {0xEF, 0xBE, 0xAD, 0xDE};

static uint16_t build(uint8_t *mail, uint16_t command, uint16_t flags, const char *parameters)
{
    memset(mail, 0, AMS);
    memcpy(mail, target, sizeof target);
    memcpy(mail + 8, source, sizeof source);
    ect_store_le16(mail + COMMAND, command);
    ect_store_le16(mail + FLAGS, flags);
    memcpy(mail + INVOKE, invoke, sizeof invoke);
    const uint16_t length = from_hex(parameters, mail + AMS);
    ect_store_le32(mail + LENGTH, length);
    return (uint16_t)(AMS + length);
}

static void send_mail(const uint8_t *mail, uint16_t length)
{
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_AOE, mail, length), 1);
}

/* @return bytes behind the AMS header, NOTHING, or MAILBOX_ERROR with its detail in ams[0] */
static int receive(uint8_t ams[ROOM])
{
    uint8_t mail[ROOM];
    const int length = wire_mail_receive(&w, 0, mail, sizeof mail);
    if (length < 0)
        return NOTHING;
    if ((mail[5] & 0x0F) == ECT_MAILBOX_TYPE_ERROR) {
        ams[0] = mail[8];
        return MAILBOX_ERROR;
    }
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_AOE);
    assert_in_range(length, AMS, SIZE - MAIL_HEADER);
    for (int i = MAIL_HEADER + length; i < SIZE; i++)
        assert_int_equal(mail[i], 0); /* no byte of a refused value */
    memcpy(ams, mail + MAIL_HEADER, (size_t)length);
    return length - AMS;
}

/* One command; its reply has error code and bytes as given, and header fields that repeat those of the request. */
static void expect(const char *what, uint16_t command, const char *parameters, uint32_t error, const char *reply)
{
    uint8_t mail[ROOM], want[ROOM], got[ROOM];
    send_mail(mail, build(mail, command, 0x0004, parameters));
    const int length = receive(got);
    const int wanted = from_hex(reply, want);
    if (length != wanted)
        fail_msg("%s: expected %d bytes, got %d", what, wanted, length);
    if (ect_load_le32(got + ERROR) != error)
        fail_msg("%s: expected error %04X, got %04X", what, error, ect_load_le32(got + ERROR));
    for (int i = 0; i < length; i++) {
        if (got[AMS + i] != want[i])
            fail_msg("%s: byte %d: expected %02X, got %02X", what, i, want[i], got[AMS + i]);
    }
    assert_memory_equal(got, source, sizeof source);
    assert_memory_equal(got + 8, target, sizeof target);
    assert_int_equal(ect_load_le16(got + COMMAND), command);
    assert_int_equal(ect_load_le16(got + FLAGS), 0x0005);
    assert_int_equal(ect_load_le32(got + LENGTH), length);
    assert_memory_equal(got + INVOKE, invoke, sizeof invoke);
}

typedef struct row {
    const char *what;
    uint16_t command;
    const char *parameters;
    uint32_t error;
    const char *reply;
} row_t;

static void expect_each(const row_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        expect(rows[i].what, rows[i].command, rows[i].parameters, rows[i].error, rows[i].reply);
}

#define EACH(rows) expect_each(rows, sizeof(rows) / sizeof(rows)[0])

/* --- commands ----------------------------------------------------------------------------------------------------- */

/* Index groups in the order of the mail; the offset of an object follows. */
#define COE   "02F30000 "
#define SETUP "01000000 "

static void dictionary(void **state)
{
    static const row_t rows[] = {
        {"a number", READ, COE "00000020 04000000", 0, "00000000 04000000 44332211"},
        {"more room than the value", READ, COE "00000020 50000000", 0, "00000000 04000000 44332211"},
        {"a sub-index", READ, COE "01001810 04000000", 0, "00000000 04000000 570E0000"},
        {"a text", READ, COE "00000810 28000000", 0, "00000000 12000000 65637477696E 2074657374 20646576696365"},
        {"an empty text", READ, COE "00000120 14000000", 0, "00000000 00000000"},
        {"a text is written", WRITE, COE "00000120 02000000 4142", 0, "00000000"},
        {"and read", READ, COE "00000120 14000000", 0, "00000000 02000000 4142"},
        {"a write", WRITE, COE "00000020 04000000 01020304", 0, "00000000"},
        {"a write, then a read", READ_WRITE, COE "00000020 04000000 04000000 AABBCCDD", 0,
         "00000000 04000000 AABBCCDD"},
        {"the whole array", WRITE, COE "00010720 0A000000 0400 0100 0200 0300 0400", 0, "00000000"},
        {"the whole array again", READ, COE "00010720 0A000000", 0, "00000000 0A000000 0400 0100 0200 0300 0400"},
        {"from sub-index 1", READ, COE "01010720 0A000000", 0, "00000000 08000000 0100 0200 0300 0400"},
        {"one element", READ, COE "03000720 02000000", 0, "00000000 02000000 0300"},
        {"a record with bits", WRITE, COE "00010620 0B000000 0600 45 01 3412 00 78563412", 0, "00000000"},
        {"a record with bits again", READ, COE "00010620 20000000", 0, "00000000 0B000000 0600 45 01 3412 00 78563412"},
    };
    (void)state;
    EACH(rows);
    assert_int_equal(ads()->base.u32, 0xDDCCBBAA);
    assert_int_equal(ads()->base.array[3], 4);
    assert_int_equal(ads()->base.written_index, 0x2006);
}

static void refused_by_the_dictionary(void **state)
{
    static const row_t rows[] = {
        {"no object", READ, COE "00000030 04000000", 0, "03070000 00000000"},
        {"no object to write", WRITE, COE "00000030 01000000 00", 0, "03070000"},
        {"no sub-index", READ, COE "09001810 04000000", 0, "03070000 00000000"},
        {"write only", READ, COE "00000320 02000000", 0, "04070000 00000000"},
        {"read only", WRITE, COE "00000010 04000000 00000000", 0, "04070000"},
        {"a whole text", READ, COE "00010120 20000000", 0, "04070000 00000000"},
        {"the request has no room for the value", READ, COE "00000020 03000000", 0, "05070000 00000000"},
        {"the mailbox has none", READ, COE "00000220 E8030000", 0, "05070000 00000000"},
        {"too short", WRITE, COE "00000020 03000000 000000", 0, "05070000"},
        {"too long", WRITE, COE "00000020 05000000 0000000000", 0, "05070000"},
        {"nothing", WRITE, COE "00000020 00000000", 0, "05070000"},
        {"half an element", WRITE, COE "00010720 03000000 0400 01", 0, "05070000"},
        {"above the maximum", WRITE, COE "00000520 02000000 C900", 0, "06070000"},
        {"below the minimum", WRITE, COE "00000520 02000000 9BFF", 0, "06070000"},
        {"a refused write reads nothing", READ_WRITE, COE "00000520 02000000 02000000 C900", 0, "06070000 00000000"},
        {"written, and unreadable", READ_WRITE, COE "00000320 02000000 02000000 0700", 0, "04070000 00000000"},
    };
    (void)state;
    memset(ads()->base.octets, 0x5A, sizeof ads()->base.octets);
    EACH(rows);
    assert_int_equal(ads()->base.u32, 0x11223344);
    assert_int_equal(ads()->base.limited, 5);
    assert_int_equal(ads()->base.write_only, 7);
}

/* The reasons of a device, as SDO abort codes, and their results. */
static void abort_codes(void **state)
{
    static const struct {
        uint32_t code;
        const char *result;
    } rows[] = {{0x05040001, "00070000"}, {0x05040005, "0A070000"}, {0x06010000, "04070000"}, {0x06010005, "05070000"},
                {0x06010006, "04070000"}, {0x06020000, "03070000"}, {0x06040043, "06070000"}, {0x06060000, "00070000"},
                {0x06070012, "05070000"}, {0x06090011, "03070000"}, {0x06090030, "06070000"}, {0x060A0023, "0A070000"},
                {0x08000000, "00070000"}, {0x08000021, "12070000"}, {0x08000022, "12070000"}, {0x08000024, "00070000"},
                {0xFFFFFFFF, "00070000"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ads()->base.write_answer = rows[i].code;
        expect("a code of the device", WRITE, COE "00000020 04000000 01020304", 0, rows[i].result);
    }
    assert_int_equal(ads()->base.u32, 0x11223344);
}

static void state_rights(void **state)
{
    (void)state;
    expect("PREOP only", WRITE, COE "00000420 02000000 0900", 0, "00000000");
    reopen(&plain, ECT_STATE_SAFEOP, true);
    expect("PREOP only, in SAFEOP", WRITE, COE "00000420 02000000 0900", 0, "12070000");
}

static void information(void **state)
{
    static const struct {
        uint8_t state;
        const char *reply;
    } rows[] = {{ECT_STATE_PREOP, "00000000 0600 0200"},
                {ECT_STATE_SAFEOP, "00000000 0600 0400"},
                {ECT_STATE_OP, "00000000 0500 0800"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        reopen(&plain, rows[i].state, true);
        expect("ReadState", STATE, "", 0, rows[i].reply);
        expect("ReadDeviceInfo", INFO, "", 0, "00000000 03 02 0201 65637477696E 2074657374 2064657669");
    }
}

/* The name is cut to 16 characters, which end with the mailbox: the previous mail, kept behind it, can be repeated. */
static void information_fills_the_mailbox(void **state)
{
    enum { ACTIVATE = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_ACTIVATE };
    uint8_t mail[ROOM], before[ROOM], again[ROOM], got[ROOM];
    (void)state;
    mailbox_size = ECT_AOE_MAILBOX_LEAST;
    reopen(&plain, ECT_STATE_PREOP, true);
    send_mail(mail, build(mail, STATE, 0x0004, ""));
    const int length = wire_mail_receive(&w, 0, before, sizeof before);
    assert_int_equal(length, AMS + 8);
    send_mail(mail, build(mail, INFO, 0x0004, ""));
    wire_write8(&w, 0, ACTIVATE, wire_read8(&w, 0, ACTIVATE) ^ ECT_SM_ACTIVATE_REPEAT);
    assert_int_equal(wire_mail_receive(&w, 0, again, sizeof again), length);
    assert_memory_equal(again, before, (size_t)(MAIL_HEADER + length));
    assert_int_equal(wire_mail_receive(&w, 0, got, sizeof got), AMS + 24);
    assert_memory_equal(got + MAIL_HEADER + AMS + 8, "ectwin test devi", 16);
}

static void unserved(void **state)
{
    static const row_t rows[] = {
        {"WriteControl", CONTROL, "0500 0000 00000000", 0, "01070000"},
        {"AddDeviceNotification", ADD,
         COE "00000020 04000000 04000000 00000000 00000000 00000000 00000000 00000000 00000000", 0,
         "01070000 00000000"},
        {"DelDeviceNotification", DELETE, "01000000", 0, "01070000"},
        {"command 0", 0, "", ECT_AMS_UNKNOWN_COMMAND, ""},
        {"command 10", 10, "", ECT_AMS_UNKNOWN_COMMAND, ""},
        {"command FFFFh", 0xFFFF, "", ECT_AMS_UNKNOWN_COMMAND, ""},
        {"Read of 11 bytes", READ, COE "00000020 040000", ECT_AMS_LENGTH, ""},
        {"Write of 11 bytes", WRITE, COE "00000020 040000", ECT_AMS_LENGTH, ""},
        {"ReadWrite of 15 bytes", READ_WRITE, COE "00000020 04000000 040000", ECT_AMS_LENGTH, ""},
        {"less data than announced", WRITE, COE "00000020 04000000 010203", 0, "05070000"},
        {"more data than announced", WRITE, COE "00000020 04000000 0102030405", 0, "05070000"},
        {"4 GB announced", WRITE, COE "00000020 FFFFFFFF 01020304", 0, "05070000"},
        {"less data to write and read", READ_WRITE, COE "00000020 04000000 04000000 010203", 0, "05070000 00000000"},
        {"another group", READ, "0340F000 00000000 04000000", 0, "02070000 00000000"},
        {"another group to write", WRITE, "0340F000 00000000 01000000 00", 0, "02070000"},
        {"the NetId is not read", READ, SETUP "03000000 06000000", 0, "02070000 00000000"},
        {"another offset of the set-up", WRITE, SETUP "04000000 06000000 010203040506", 0, "02070000"},
    };
    (void)state;
    EACH(rows);
    assert_int_equal(ads()->base.u32, 0x11223344);
    reopen(&plain, ECT_STATE_PREOP, false);
    expect("a device without CoE", READ, COE "00000020 04000000", 0, "02070000 00000000");
    expect("a device without CoE, written", WRITE, COE "00000020 04000000 00000000", 0, "02070000");
}

static void malformed(void **state)
{
    static const struct {
        const char *what;
        uint16_t command, flags, cut, length;
        int detail; /* 0: no reply */
    } rows[] = {
        {"31 bytes", STATE, 0x0004, 31, 0, ECT_MAILBOX_ERROR_TOO_SHORT},
        {"1 byte", STATE, 0x0004, 1, 0, ECT_MAILBOX_ERROR_TOO_SHORT},
        {"AMS length beyond the mail", STATE, 0x0004, AMS, 1, ECT_MAILBOX_ERROR_SIZE},
        {"a response", STATE, 0x0005, AMS, 0, 0},
        {"a notification", NOTIFY, 0x0004, AMS, 0, 0},
    };
    uint8_t mail[ROOM], got[ROOM];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        (void)build(mail, rows[i].command, rows[i].flags, "");
        ect_store_le32(mail + LENGTH, rows[i].length);
        send_mail(mail, rows[i].cut);
        const int length = receive(got);
        if (rows[i].detail == 0 ? length != NOTHING : length != MAILBOX_ERROR || got[0] != rows[i].detail)
            fail_msg("%s: expected mailbox error %d, got %d with %u", rows[i].what, rows[i].detail, length, got[0]);
        expect("and the next request is served", STATE, "", 0, "00000000 0600 0200");
    }
    (void)build(mail, STATE, 0x0000, "");
    send_mail(mail, AMS);
    assert_int_equal(receive(got), 0);
    assert_int_equal(ect_load_le32(got + ERROR), ECT_AMS_UNKNOWN_COMMAND);
    send_mail(mail, build(mail, STATE, 0x0004, "0102030405"));
    assert_int_equal(receive(got), 8); /* bytes behind the parameters have no effect */
}

/* --- NetId -------------------------------------------------------------------------------------------------------- */

static void net_id(void **state)
{
    static const uint8_t own[] = {10, 20, 30, 40, 2, 1}, other[] = {10, 20, 30, 40, 9, 1};
    uint8_t mail[ROOM], got[ROOM];
    (void)state;
    expect("5 bytes", WRITE, SETUP "03000000 05000000 0A141E2802", 0, "05070000");
    expect("7 bytes", WRITE, SETUP "03000000 07000000 0A141E28020100", 0, "05070000");
    assert_int_equal(ads()->aoe.net_id[0], 0);
    expect("set", WRITE, SETUP "03000000 06000000 0A141E280201", 0, "00000000");
    assert_memory_equal(ads()->aoe.net_id, own, sizeof own);
    expect("addressed with it", STATE, "", 0, "00000000 0600 0200");
    /* The NetId outlasts INIT. */
    assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
    wire_configure_mailbox(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
    assert_memory_equal(ads()->aoe.net_id, own, sizeof own);
    /* Another one: requests for the old one are refused, except one that sets it. */
    expect("set to another", WRITE, SETUP "03000000 06000000 0A141E280901", 0, "00000000");
    assert_memory_equal(ads()->aoe.net_id, other, sizeof other);
    expect("not for this device", STATE, "", ECT_AMS_NO_TARGET, "");
    expect("not for this device either", WRITE, COE "00000020 04000000 01020304", ECT_AMS_NO_TARGET, "");
    expect("another offset", WRITE, SETUP "04000000 06000000 0A141E280201", ECT_AMS_NO_TARGET, "");
    expect("a read of the set-up", READ, SETUP "03000000 06000000", ECT_AMS_NO_TARGET, "");
    assert_int_equal(ads()->base.u32, 0x11223344);
    (void)build(mail, STATE, 0x0004, "");
    memset(mail, 0, ECT_AOE_NET_ID);
    send_mail(mail, AMS);
    assert_int_equal(receive(got), 8); /* NetId 0: whichever device it is */
    expect("set again", WRITE, SETUP "03000000 06000000 0A141E280201", 0, "00000000");
    expect("for this device", STATE, "", 0, "00000000 0600 0200");
    assert_int_equal(receive(got), NOTHING);
}

/* --- groups of the device ----------------------------------------------------------------------------------------- */

static void own_groups(void **state)
{
    static const row_t rows[] = {
        {"written", WRITE, "33221100 77665544 03000000 010203", 0, "00000000"},
        {"read", READ, "33221100 77665544 08000000", 0, "00000000 03000000 010203"},
        {"both", READ_WRITE, "33221100 77665544 08000000 02000000 0908", 0, "00000000 02000000 0908"},
        {"no room", READ, "33221100 77665544 01000000", 0, "05070000 00000000"},
        {"another offset", READ, "33221100 00000000 01000000", 0, "03070000 00000000"},
        {"another group", WRITE, "33221101 77665544 01000000 00", 0, "02070000"},
        {"and the dictionary", READ, COE "00000020 04000000", 0, "00000000 04000000 44332211"},
    };
    (void)state;
    reopen(&with_own, ECT_STATE_PREOP, true);
    EACH(rows);
}

/* --- beside CoE --------------------------------------------------------------------------------------------------- */

/* An upload of 2002h in segments (1000 bytes, or 300 of the device) with AoE accesses between them. */
static void upload_continues(bool instead, const char *read_reply)
{
    uint8_t request[10] = {0, 0x20, 0x40, 0x02, 0x20}, reply[ROOM];
    const unsigned int whole = instead ? sizeof ads()->bytes : sizeof ads()->base.octets;
    uint8_t *bytes = instead ? ads()->bytes : ads()->base.octets;
    ads()->instead = instead;
    for (unsigned int i = 0; i < whole; i++)
        bytes[i] = (uint8_t)(i * 3 + i / 256);
    int length = wire_coe(&w, 0, request, sizeof request, reply, sizeof reply);
    assert_int_equal(ect_load_le32(reply + 6), whole);
    unsigned int done = (unsigned int)length - 10;
    assert_memory_equal(reply + 10, bytes, done);
    for (uint8_t toggle = 0; done < whole; toggle ^= 0x10) {
        expect("a read between segments", READ, COE "01001810 04000000", 0, read_reply);
        expect("a write between segments", WRITE, COE "00000020 04000000 05060708", 0, "00000000");
        request[2] = 0x60 | toggle;
        length = wire_coe(&w, 0, request, sizeof request, reply, sizeof reply);
        assert_int_equal(reply[2] & 0xF0, toggle);
        assert_memory_equal(reply + 3, bytes + done, (size_t)length - 3);
        done += (unsigned int)length - 3;
    }
    assert_int_equal(done, whole);
}

static void beside_an_upload(void **state)
{
    (void)state;
    upload_continues(false, "00000000 04000000 570E0000");
}

static void beside_an_upload_of_the_device(void **state)
{
    (void)state;
    upload_continues(true, "08070000 00000000");
    expect("after it", READ, COE "01001810 04000000", 0, "00000000 04000000 570E0000");
}

static void beside_a_download(void **state)
{
    uint8_t request[SIZE - MAIL_HEADER] = {0, 0x20, 0x21, 0x01, 0x20, 0, 20}, reply[ROOM];
    (void)state;
    memcpy(request + 10, "0123456789", 10);
    assert_int_equal(wire_coe(&w, 0, request, 20, reply, sizeof reply), 10);
    assert_int_equal(reply[2], 0x60);
    expect("a read between segments", READ, COE "01001810 04000000", 0, "00000000 04000000 570E0000");
    expect("a write between segments", WRITE, COE "00010720 03000000 040001", 0, "08070000");
    memset(request, 0, sizeof request);
    request[1] = 0x20;
    request[2] = 0x01;
    memcpy(request + 3, "abcdefghij", 10);
    assert_int_equal(wire_coe(&w, 0, request, 13, reply, sizeof reply), 10);
    assert_int_equal(reply[2], 0x20);
    assert_memory_equal(ads()->base.text, "0123456789abcdefghij", 20);
    expect("a write after them", WRITE, COE "00000020 04000000 05060708", 0, "00000000");
}

static void not_in_boot(void **state)
{
    uint8_t mail[ROOM], got[ROOM];
    (void)state;
    reopen(&plain, ECT_STATE_BOOT, true);
    send_mail(mail, build(mail, STATE, 0x0004, ""));
    assert_int_equal(receive(got), MAILBOX_ERROR);
    assert_int_equal(got[0], ECT_MAILBOX_ERROR_PROTOCOL);
}

/* A mailbox of the least length takes each reply of fixed length. */
static void least_mailbox(void **state)
{
    ect_device_t device = testdev;
    (void)state;
    for (unsigned int n = 0; n < 2; n++)
        device.sm[n].length = device.sm[n].minimum = device.sm[n].maximum = ECT_AOE_MAILBOX_LEAST;
    assert_true(ect_aoe_fits(&device));
    for (unsigned int n = 0; n < 2; n++) {
        device.sm[n].minimum = ECT_AOE_MAILBOX_LEAST - 1;
        assert_false(ect_aoe_fits(&device));
        device.sm[n].minimum = 0;
    }
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("AoE: index group F302h reads and writes entries and whole objects", dictionary),
        TEST("AoE: refusals of the dictionary get ADS results, change nothing and show nothing",
             refused_by_the_dictionary),
        TEST("AoE: each SDO abort code has an ADS result", abort_codes),
        TEST("AoE: the rights of the AL state hold", state_rights),
        TEST("AoE: ReadDeviceInfo and ReadState report device and AL state", information),
        TEST("AoE: ReadDeviceInfo in the least mailbox leaves the previous mail for a repeat",
             information_fills_the_mailbox),
        TEST("AoE: other commands, groups and lengths are refused with the codes of ADS", unserved),
        TEST("AoE: malformed mails get a mailbox error, responses and notifications no reply", malformed),
        TEST("AoE: a master sets the NetId; requests for another NetId are refused", net_id),
        TEST("AoE: a device has index groups of its own", own_groups),
        TEST("AoE: an SDO upload in segments continues between accesses", beside_an_upload),
        TEST("AoE: a read is busy while an upload in segments sends bytes of the device",
             beside_an_upload_of_the_device),
        TEST("AoE: a write is busy while an SDO download in segments is under way", beside_a_download),
        TEST("AoE: BOOT refuses it", not_in_boot),
        TEST("AoE: mailboxes have at least 62 bytes", least_mailbox),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
