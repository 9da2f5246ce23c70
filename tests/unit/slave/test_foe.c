/* SPDX-License-Identifier: MIT */
/* File access (FoE): packets, their numbers, delays, losses, and the resulting files. CF-084. */
#include <string.h>

#include "support/filedev.h"
#include "support/wire.h"

enum { SM0 = 0x1000, SM1 = 0x1080, SIZE = 128, MAIL_HEADER = 6, HEADER = 6, FULL = SIZE - MAIL_HEADER - HEADER };
enum { READ = 1, WRITE, DATA, ACK, ERROR, BUSY, NOTHING = -1, MAILBOX_ERROR = 0x100 };

/* An FoE mail that was received, or the reply in its place. */
typedef struct mail {
    int operation;
    uint32_t number;
    uint16_t length; /* of the data */
    uint8_t data[SIZE];
} mail_t;

static wire_t w;

static void open_device(const ect_device_t *device, uint8_t state)
{
    wire_open_one(&w, device);
    if (state != ECT_STATE_BOOT) {
        wire_go(&w, 0, state);
        return;
    }
    wire_configure_mailbox(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_BOOT, NULL), ECT_STATE_BOOT);
}

static filedev_t *device(void)
{
    return (filedev_t *)(void *)testdev_of(&w, 0);
}

static void send_mail(int operation, uint32_t number, const void *data, uint16_t length)
{
    uint8_t mail[SIZE] = {0};
    w.mail_counter = (uint8_t)(w.mail_counter % 7 + 1);
    ect_store_le16(mail, (uint16_t)(HEADER + length));
    mail[5] = (uint8_t)(ECT_MAILBOX_TYPE_FOE | w.mail_counter << 4);
    mail[MAIL_HEADER] = (uint8_t)operation;
    ect_store_le32(mail + MAIL_HEADER + 2, number);
    memcpy(mail + MAIL_HEADER + HEADER, data, length);
    assert_int_equal(wire_write(&w, 0, SM0, mail, SIZE), 1);
}

static mail_t receive(void)
{
    uint8_t mail[SIZE] = {0};
    mail_t m = {.operation = NOTHING};
    if (wire_read(&w, 0, SM1, mail, SIZE) != 1)
        return m;
    if ((mail[5] & 0x0F) == ECT_MAILBOX_TYPE_ERROR)
        return (mail_t){.operation = MAILBOX_ERROR, .number = ect_load_le16(mail + 8)};
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_FOE);
    m.operation = mail[MAIL_HEADER];
    m.number = ect_load_le32(mail + MAIL_HEADER + 2);
    m.length = (uint16_t)(ect_load_le16(mail) - HEADER);
    memcpy(m.data, mail + MAIL_HEADER + HEADER, m.length);
    return m;
}

static void expect(const char *what, int operation, uint32_t number)
{
    mail_t m = receive();
    if (m.operation != operation || m.number != number)
        fail_msg("%s: expected operation %d with 0x%X, got %d with 0x%X", what, operation, number, m.operation,
                 m.number);
}

static void expect_error(const char *what, uint32_t code, const char *text)
{
    mail_t m = receive();
    if (m.operation != ERROR || m.number != code || m.length != strlen(text) || memcmp(m.data, text, m.length) != 0)
        fail_msg("%s: expected error 0x%X \"%s\", got operation %d with 0x%X \"%.*s\"", what, code, text, m.operation,
                 m.number, (int)m.length, (const char *)m.data);
}

static void begin(int operation, const char *name, uint32_t password)
{
    send_mail(operation, password, name, (uint16_t)strlen(name));
}

/* --- whole files -------------------------------------------------------------------------------------------------- */

static const uint16_t sizes[] = {0, 1, FULL - 1, FULL, FULL + 1, 3 * FULL, 3 * FULL + 7, FILEDEV_ROOM};

static uint8_t byte_at(uint32_t n)
{
    return (uint8_t)(7 * n + n / 256);
}

/* Sends the file's packets; the packet after the last full packet is shorter. */
static void write_packets(uint16_t size)
{
    uint8_t data[FULL];
    uint32_t offset = 0, packet = 0;
    uint16_t length;
    do {
        length = (uint16_t)(size - offset < FULL ? size - offset : FULL);
        for (uint16_t i = 0; i < length; i++)
            data[i] = byte_at(offset + i);
        send_mail(DATA, ++packet, data, length);
        expect("a packet that was written", ACK, packet);
        offset += length;
    } while (length == FULL);
}

static void written_files(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        open_device(filedev(), ECT_STATE_PREOP);
        begin(WRITE, "data", 0);
        expect("the name", ACK, 0);
        write_packets(sizes[i]);
        assert_int_equal(device()->closed_whole, 1);
        assert_int_equal(device()->closed_broken, 0);
        assert_int_equal(device()->length[FILEDEV_DATA], sizes[i]);
        assert_int_equal(device()->written, sizes[i] / FULL + 1);
        for (uint16_t n = 0; n < sizes[i]; n++)
            assert_int_equal(device()->content[FILEDEV_DATA][n], byte_at(n));
        wire_close(&w);
    }
}

static void fill(unsigned int file, uint16_t size)
{
    device()->length[file] = size;
    for (uint16_t n = 0; n < size; n++)
        device()->content[file][n] = byte_at(n);
}

static void read_files(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        uint32_t offset = 0;
        open_device(filedev(), ECT_STATE_OP);
        fill(FILEDEV_DATA, sizes[i]);
        begin(READ, "data", 0);
        for (uint32_t packet = 1; packet <= sizes[i] / FULL + 1u; packet++) {
            mail_t m = receive();
            uint16_t length = (uint16_t)(sizes[i] - offset < FULL ? sizes[i] - offset : FULL);
            assert_int_equal(m.operation, DATA);
            assert_int_equal(m.number, packet);
            assert_int_equal(m.length, length);
            assert_memory_equal(m.data, device()->content[FILEDEV_DATA] + offset, length);
            offset += length;
            assert_int_equal(device()->closed_whole, 0);
            send_mail(ACK, packet, "", 0);
        }
        assert_int_equal(device()->closed_whole, 1);
        expect("behind the last acknowledge", NOTHING, 0);
        wire_close(&w);
    }
}

/* --- refusals ----------------------------------------------------------------------------------------------------- */

static void refused(void **state)
{
    static const struct {
        const char *what, *name;
        int operation;
        uint32_t password, code;
        const char *text;
    } table[] = {
        {"a missing file", "dat", READ, 0, ECT_FOE_NOT_FOUND, "no such file"},
        {"a name that is too long", "data2", WRITE, 0, ECT_FOE_NOT_FOUND, "no such file"},
        {"no name", "", READ, 0, ECT_FOE_NOT_FOUND, ""},
        {"no password", "secret", READ, 0, ECT_FOE_ACCESS, ""},
        {"a wrong password", "secret", WRITE, 0x1235, ECT_FOE_ACCESS, ""},
        {"an unnecessary password", "data", READ, 1, ECT_FOE_ACCESS, ""},
        {"a constant file written", "constant", WRITE, 0, ECT_FOE_NO_RIGHTS, ""},
        {"a packet without a transfer", "", DATA, 1, ECT_FOE_ILLEGAL, ""},
        {"an acknowledge without a transfer", "", ACK, 1, ECT_FOE_ILLEGAL, ""},
        {"a busy master", "", BUSY, 0, ECT_FOE_ILLEGAL, ""},
        {"an unknown operation", "", 7, 0, ECT_FOE_ILLEGAL, ""},
        {"operation 0", "", 0, 0, ECT_FOE_ILLEGAL, ""},
    };
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        begin(table[i].operation, table[i].name, table[i].password);
        expect_error(table[i].what, table[i].code, table[i].text);
        assert_int_equal(device()->opened, 0);
        assert_int_equal(device()->closed_broken, 0);
    }
    begin(ERROR, "", 0);
    expect("an error of the master's", NOTHING, 0);
    begin(READ, "secret", FILEDEV_PASSWORD);
    expect("the right password", DATA, 1);
    wire_close(&w);
}

static void states(void **state)
{
    static const struct {
        uint16_t reads, writes;
        uint8_t in;
        int operation;
        uint32_t answer; /* an error code; 0: success */
    } table[] = {
        {ECT_IN(2), ECT_IN(3), ECT_STATE_PREOP, READ, 0},
        {ECT_IN(2), ECT_IN(3), ECT_STATE_PREOP, WRITE, ECT_FOE_BOOT_ONLY},
        {ECT_IN(2), ECT_IN(3), ECT_STATE_BOOT, WRITE, 0},
        {ECT_IN(2), ECT_IN(3), ECT_STATE_BOOT, READ, ECT_FOE_NOT_IN_BOOT},
        {ECT_IN(2), ECT_IN(3), ECT_STATE_SAFEOP, READ, ECT_FOE_ILLEGAL},
        {ECT_IN(4) | ECT_IN(8), 0, ECT_STATE_SAFEOP, READ, 0},
        {ECT_IN(4) | ECT_IN(8), 0, ECT_STATE_OP, READ, 0},
        {ECT_IN(4) | ECT_IN(8), 0, ECT_STATE_OP, WRITE, ECT_FOE_ACCESS},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        open_device(filedev_in(table[i].reads, table[i].writes, 0), table[i].in);
        begin(table[i].operation, "data", 0);
        if (table[i].answer != 0)
            expect_error("not at home", table[i].answer, "");
        else
            expect("at home", table[i].operation == READ ? DATA : ACK, table[i].operation == READ ? 1 : 0);
        wire_close(&w);
    }
}

static void too_short(void **state)
{
    uint8_t mail[SIZE] = {5, 0, 0, 0, 0, 0x14, READ};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    assert_int_equal(wire_write(&w, 0, SM0, mail, SIZE), 1);
    expect("less than a header", MAILBOX_ERROR, ECT_MAILBOX_ERROR_TOO_SHORT);
    wire_close(&w);
}

static void of_the_device(void **state)
{
    uint8_t data[FULL] = {0xFF};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    begin(WRITE, "checked", 0);
    expect("the name", ACK, 0);
    send_mail(DATA, 1, data, 3);
    expect_error("a wrong check value", ECT_FOE_CHECKSUM, "check value");
    assert_int_equal(device()->closed_whole + device()->closed_broken, 0); /* the device has closed it */
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    uint32_t packet = 1;
    for (; packet * FULL <= FILEDEV_ROOM; packet++) {
        send_mail(DATA, packet, data, FULL);
        expect("a packet", ACK, packet);
    }
    send_mail(DATA, packet, data, FULL);
    expect_error("more than there is room for", ECT_FOE_DISK_FULL, "");
    assert_int_equal(device()->length[FILEDEV_DATA], 0);
    send_mail(DATA, packet + 1, data, FULL);
    expect_error("behind that", ECT_FOE_ILLEGAL, "");
    wire_close(&w);
}

/* --- lost and repeated -------------------------------------------------------------------------------------------- */

static void packet_numbers(void **state)
{
    uint8_t data[FULL] = {1};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    static const uint32_t wrong[] = {0, 1, 4, UINT32_MAX}; /* number 3 is expected, and 2 may be repeated */
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        begin(WRITE, "data", 0);
        expect("the name", ACK, 0);
        for (uint32_t packet = 1; packet <= 2; packet++) {
            send_mail(DATA, packet, data, FULL);
            expect("a packet", ACK, packet);
        }
        send_mail(DATA, wrong[i], data, FULL);
        expect_error("a packet out of order", ECT_FOE_PACKET_NUMBER, "");
        assert_int_equal(device()->closed_broken, i + 1);
    }
    fill(FILEDEV_DATA, 3 * FULL);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        begin(READ, "data", 0);
        expect("the file", DATA, 1);
        send_mail(ACK, wrong[i] == 1 ? 3 : wrong[i], "", 0);
        expect_error("an acknowledge of a packet that was not sent", ECT_FOE_PACKET_NUMBER, "");
    }
    wire_close(&w);
}

static void sent_again(void **state)
{
    uint8_t data[FULL] = {1};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    for (int times = 0; times < 3; times++) {
        send_mail(DATA, 1, data, FULL);
        expect("a packet whose acknowledge was lost", ACK, 1);
    }
    assert_int_equal(device()->written, 1);
    for (int times = 0; times < 3; times++) {
        send_mail(DATA, 2, data, 5);
        expect("the last packet, whose acknowledge was lost", ACK, 2);
    }
    assert_int_equal(device()->written, 2);
    assert_int_equal(device()->closed_whole, 1);
    assert_int_equal(device()->length[FILEDEV_DATA], FULL + 5);
    begin(READ, "data", 0);
    mail_t first = receive();
    send_mail(ACK, 1, "", 0);
    mail_t second = receive();
    for (int times = 0; times < 2; times++) {
        send_mail(ACK, 1, "", 0);
        mail_t again = receive();
        assert_int_equal(again.number, 2);
        assert_int_equal(again.length, second.length);
        assert_memory_equal(again.data, second.data, second.length);
    }
    assert_int_equal(first.length, FULL);
    assert_int_equal(second.length, 5);
    send_mail(ACK, 2, "", 0);
    expect("the end", NOTHING, 0);
    assert_int_equal(device()->closed_whole, 2);
    wire_close(&w);
}

/* --- delayed ------------------------------------------------------------------------------------------------------ */

static void late_answers(void **state)
{
    uint8_t data[4] = {1, 2, 3, 4};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    device()->late = 5;
    begin(WRITE, "data", 0);
    expect("opening takes long", NOTHING, 0);
    wire_advance(&w, 10 * MS);
    expect("opened", ACK, 0);
    assert_int_equal(device()->requests, 5);
    device()->late = 50;
    send_mail(DATA, 1, data, sizeof data);
    wire_advance(&w, 40 * MS);
    expect("programming takes long", NOTHING, 0);
    assert_int_equal(device()->closed_whole, 0);
    wire_advance(&w, 20 * MS);
    expect("programmed", ACK, 1);
    assert_int_equal(device()->closed_whole, 1);
    device()->late = 3;
    begin(READ, "data", 0);
    expect("reading takes long", NOTHING, 0);
    wire_advance(&w, 10 * MS);
    mail_t m = receive();
    assert_int_equal(m.operation, DATA);
    assert_memory_equal(m.data, data, sizeof data);
    wire_close(&w);
}

/* In the middle of a file, with a delayed read. */
static void late_pieces(void **state)
{
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    fill(FILEDEV_DATA, 2 * FULL + 1);
    begin(READ, "data", 0);
    expect("the file", DATA, 1);
    device()->late = 20;
    send_mail(ACK, 1, "", 0);
    expect("not yet", NOTHING, 0);
    send_mail(ACK, 1, "", 0);
    expect_error("an impatient master", ECT_FOE_PACKET_NUMBER, "");
    device()->late = 0;
    begin(READ, "data", 0);
    expect("the file", DATA, 1);
    device()->late = 20;
    send_mail(ACK, 1, "", 0);
    wire_advance(&w, 30 * MS);
    expect("the next piece", DATA, 2);
    device()->read_error = ECT_FOE_PROGRAM_ERROR;
    send_mail(ACK, 2, "", 0);
    expect_error("a file that cannot be read to its end", ECT_FOE_PROGRAM_ERROR, "torn");
    send_mail(ACK, 2, "", 0);
    expect_error("behind that", ECT_FOE_ILLEGAL, "");
    wire_close(&w);
}

static void data_out_of_place(void **state)
{
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    fill(FILEDEV_DATA, 2 * FULL);
    begin(READ, "data", 0);
    expect("the file", DATA, 1);
    send_mail(DATA, 1, "abc", 3);
    expect_error("a packet of the number that is read", ECT_FOE_ILLEGAL, "");
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    send_mail(DATA, 1, "abc", 3);
    expect("the last packet", ACK, 1);
    send_mail(DATA, 2, "def", 3);
    expect_error("one behind the last", ECT_FOE_ILLEGAL, "");
    assert_int_equal(device()->length[FILEDEV_DATA], 3);
    wire_close(&w);
}

static char reason[400]; /* of a refusal */

static uint32_t refuses(const ect_foe_t *self, void *instance, const ect_foe_file_t *file, const char **text)
{
    (void)self;
    (void)instance;
    (void)file;
    *text = reason;
    return ECT_FOE_ACCESS;
}

/* The text of an error ends where the mailbox ends. */
static void long_texts(void **state)
{
    static const size_t lengths[] = {0, 1, FULL - 1, FULL, FULL + 1, FULL + 12, sizeof reason - 1};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    filedev_entry()->open = refuses;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        char shown[FULL + 1] = "";
        memset(reason, 'r', sizeof reason);
        reason[lengths[i]] = '\0';
        memcpy(shown, reason, lengths[i] < FULL ? lengths[i] : FULL);
        begin(READ, "data", 0);
        expect_error("a refusal", ECT_FOE_ACCESS, shown);
    }
    wire_close(&w);
}

static uint32_t nothing_left(const ect_foe_t *self, void *instance, uint32_t offset, void *data, uint16_t *length,
                             const char **text)
{
    (void)self;
    (void)instance;
    (void)data;
    (void)text;
    assert_int_equal(offset, UINT32_MAX);
    *length = 0;
    return ECT_FOE_OK;
}

static void up_to_four_gigabytes(void **state)
{
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    fill(FILEDEV_DATA, 3 * FULL);
    begin(READ, "data", 0);
    expect("the file", DATA, 1);
    device()->transfer.offset = UINT32_MAX - FULL;
    filedev_entry()->read = nothing_left;
    send_mail(ACK, 1, "", 0);
    mail_t m = receive();
    if (m.operation != DATA || m.number != 2 || m.length != 0)
        fail_msg("the end, at the last offset of all: expected packet 2 without data, got operation %d, number 0x%X, "
                 "%u bytes",
                 m.operation, m.number, (unsigned int)m.length);
    wire_close(&w);
}

/* Offsets have 32 bits: a longer file is refused, the offset does not wrap. */
static void four_gigabytes(void **state)
{
    uint8_t data[FULL] = {1};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    device()->transfer.offset = UINT32_MAX - FULL + 1;
    send_mail(DATA, 1, data, FULL);
    expect_error("the byte too many", ECT_FOE_DISK_FULL, "");
    assert_int_equal(device()->written, 0);
    assert_int_equal(device()->closed_broken, 1); /* the device is not called for data, only to end its file */
    fill(FILEDEV_DATA, 3 * FULL);
    begin(READ, "data", 0);
    expect("the file", DATA, 1);
    device()->transfer.offset = UINT32_MAX - FULL + 1;
    send_mail(ACK, 1, "", 0);
    expect_error("the byte too many", ECT_FOE_PROGRAM_ERROR, "");
    wire_close(&w);
}

/* A device that only reads, with delays, and ignores the end: ten seconds. */
static void open_and_read_only(void **state)
{
    (void)state;
    const ect_device_t *least = filedev();
    filedev_entry()->write = NULL;
    filedev_entry()->close = NULL;
    filedev_entry()->timeout_ms = 0;
    open_device(least, ECT_STATE_PREOP);
    fill(FILEDEV_DATA, FULL + 3);
    begin(WRITE, "data", 0);
    expect_error("nothing can be written", ECT_FOE_ACCESS, "");
    begin(READ, "data", 0);
    expect("the file", DATA, 1);
    wire_advance(&w, 9990 * MS);
    send_mail(ACK, 1, "", 0);
    expect("the rest", DATA, 2);
    wire_advance(&w, 10010 * MS);
    send_mail(ACK, 2, "", 0);
    expect_error("ten seconds later", ECT_FOE_ILLEGAL, "");
    wire_close(&w);
}

static void late_errors(void **state)
{
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    device()->late = 2;
    device()->ready_error = ECT_FOE_PROGRAM_ERROR;
    begin(WRITE, "data", 0);
    wire_advance(&w, 5 * MS);
    expect_error("the transfer under way failed", ECT_FOE_PROGRAM_ERROR, "late error");
    wire_advance(&w, 5 * MS);
    expect("and nothing more", NOTHING, 0);
    wire_close(&w);
}

/* After BUSY, a master repeats the packet: it is not taken twice, and its acknowledge follows later. */
static void busy(void **state)
{
    uint8_t data[4] = {1, 2, 3, 4};
    (void)state;
    const uint16_t everywhere = ECT_IN_PREOP_AND_ABOVE;
    open_device(filedev_in(everywhere, everywhere, 100), ECT_STATE_PREOP);
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    device()->late = 350;
    for (int times = 0; times < 3; times++) {
        send_mail(DATA, 1, data, sizeof data);
        wire_advance(&w, 90 * MS);
        expect("not yet", NOTHING, 0);
        wire_advance(&w, 20 * MS);
        expect("after 100 ms", BUSY, 0);
        wire_advance(&w, 5 * MS);
        expect("said once", NOTHING, 0);
    }
    send_mail(DATA, 2, data, sizeof data);
    expect_error("the next packet meanwhile", ECT_FOE_PACKET_NUMBER, "");
    begin(WRITE, "data", 0);
    wire_advance(&w, 50 * MS);
    expect("the name", ACK, 0);
    device()->late = 120;
    send_mail(DATA, 1, data, sizeof data);
    wire_advance(&w, 110 * MS);
    expect("after 100 ms", BUSY, 0);
    send_mail(DATA, 1, data, sizeof data);
    wire_advance(&w, 20 * MS);
    expect("ready", ACK, 1);
    assert_int_equal(device()->written, 2);
    assert_int_equal(device()->closed_whole, 1);
    wire_close(&w);
}

static void timeouts(void **state)
{
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    fill(FILEDEV_DATA, 3 * FULL);
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    wire_advance(&w, 1990 * MS);
    assert_int_equal(device()->closed_broken, 0);
    wire_advance(&w, 20 * MS);
    assert_int_equal(device()->closed_broken, 1); /* no error reply: the master was silent */
    expect("a master that is gone", NOTHING, 0);
    begin(READ, "data", 0);
    wire_advance(&w, 2010 * MS); /* although the mail is still there */
    assert_int_equal(device()->closed_broken, 2);
    expect("the sent packet", DATA, 1);
    device()->late = 100000;
    begin(READ, "data", 0);
    wire_advance(&w, 2010 * MS);
    expect_error("a device that never ends", ECT_FOE_UNDEFINED, "time-out");
    assert_int_equal(device()->closed_broken, 3);
    assert_true(wire_sdo_download(&w, 0, 0x2000, 0, false, "abcd", 4) == 0);
    wire_close(&w);
}

/* --- given up ----------------------------------------------------------------------------------------------------- */

static void given_up(void **state)
{
    uint8_t data[FULL] = {9};
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    for (unsigned int way = 0; way < 4; way++) {
        begin(WRITE, "data", 0);
        expect("the name", ACK, 0);
        send_mail(DATA, 1, data, FULL);
        expect("a packet", ACK, 1);
        if (way == 0) {
            send_mail(ERROR, ECT_FOE_UNDEFINED, "enough", 6);
            expect("an error of the master's", NOTHING, 0);
        } else if (way == 1) {
            begin(READ, "constant", 0);
            expect("another file", DATA, 1);
        } else if (way == 2) {
            send_mail(ACK, 1, "", 0);
            expect_error("an acknowledge of the master's", ECT_FOE_ILLEGAL, "");
        } else {
            assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
            wire_configure_mailbox(&w, 0);
            assert_int_equal(wire_al(&w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
        }
        assert_int_equal(device()->closed_broken, way == 0 ? 1 : way == 1 ? 2 : way + 2);
        if (way == 1) {
            send_mail(ERROR, ECT_FOE_UNDEFINED, "", 0);
            assert_int_equal(device()->closed_broken, 3);
        }
    }
    assert_int_equal(device()->closed_whole, 0);
    assert_int_equal(device()->length[FILEDEV_DATA], 0);
    wire_close(&w);
}

/* A transfer continues during other mails, and over a change of state. */
static void beside_others(void **state)
{
    uint8_t data[FULL] = {9};
    uint32_t value = 0;
    size_t size = sizeof value;
    (void)state;
    open_device(filedev(), ECT_STATE_PREOP);
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x2000, 0, false, &value, &size), 0);
    send_mail(DATA, 1, data, FULL);
    expect("a packet", ACK, 1);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    device()->late = 100;
    send_mail(DATA, 2, data, 1);
    size = sizeof value;
    assert_int_equal(wire_sdo_upload(&w, 0, 0x2000, 0, false, &value, &size), 0);
    wire_advance(&w, 200 * MS);
    expect("the last packet", ACK, 2);
    assert_int_equal(device()->length[FILEDEV_DATA], FULL + 1);
    wire_close(&w);
}

static unsigned int turns; /* of a protocol behind FoE */

static uint16_t take_nothing(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    (void)self;
    (void)s;
    (void)data;
    (void)length;
    return ECT_MAILBOX_ERROR_SERVICE;
}

static bool count_turn(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    (void)self;
    (void)s;
    turns += send;
    return false;
}

/* FoE has no mail as long as the device is late. */
static void turns_of_others(void **state)
{
    static const ect_protocol_t behind = {
        .type = ECT_MAILBOX_TYPE_VOE, .states = ECT_IN_PREOP_AND_ABOVE, .request = take_nothing, .next = count_turn};
    const ect_protocol_t *protocols[8] = {NULL};
    uint8_t data[4] = {0};
    unsigned int count = 0;
    (void)state;
    ect_device_t with = *filedev();
    for (; with.protocols[count]; count++)
        protocols[count] = with.protocols[count];
    assert_true(count + 1 < sizeof protocols / sizeof protocols[0]);
    protocols[count] = &behind;
    with.protocols = protocols;
    open_device(&with, ECT_STATE_PREOP);
    begin(WRITE, "data", 0);
    expect("the name", ACK, 0);
    device()->late = 100;
    send_mail(DATA, 1, data, sizeof data);
    turns = 0;
    wire_advance(&w, 50 * MS);
    assert_int_not_equal(turns, 0);
    expect("not yet", NOTHING, 0);
    wire_advance(&w, 100 * MS);
    expect("the packet", ACK, 1);
    wire_close(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"FoE: files of any size are written; a packet shorter than the mailbox ends them", written_files, NULL, NULL,
         NULL},
        {"FoE: files of any size are read; an empty packet ends one of full packets", read_files, NULL, NULL, NULL},
        {"FoE: the text of an error is cut off at the end of the mailbox", long_texts, NULL, NULL, NULL},
        {"FoE: wrong names, passwords, rights and operations are refused with their codes and texts (CF-084)", refused,
         NULL, NULL, NULL},
        {"FoE: files are accessible in the states that the device names; elsewhere 8008h or 8009h (CF-084)", states,
         NULL, NULL, NULL},
        {"FoE: a mail without a complete header gets a mailbox error (CF-026)", too_short, NULL, NULL, NULL},
        {"FoE: errors of the device end the transfer: check value, no space (CF-084)", of_the_device, NULL, NULL, NULL},
        {"FoE: a packet out of order is refused with 8005h and the file abandoned (CF-084)", packet_numbers, NULL, NULL,
         NULL},
        {"FoE: repeated packets and acknowledges get a reply again and are not processed again", sent_again, NULL, NULL,
         NULL},
        {"FoE: the transfer waits for a slow device", late_answers, NULL, NULL, NULL},
        {"FoE: the same in the middle of a file, and if the rest cannot be read", late_pieces, NULL, NULL, NULL},
        {"FoE: a delayed failure is reported", late_errors, NULL, NULL, NULL},
        {"FoE: a packet while a file is read, or behind the last one, is refused", data_out_of_place, NULL, NULL, NULL},
        {"FoE: a file of 4 GiB less a byte is read to its end", up_to_four_gigabytes, NULL, NULL, NULL},
        {"FoE: a file of more than 4 GiB is refused", four_gigabytes, NULL, NULL, NULL},
        {"FoE: a device needs only open and read", open_and_read_only, NULL, NULL, NULL},
        {"FoE: a master gets BUSY once, and again at a repeated request (CF-084)", busy, NULL, NULL, NULL},
        {"FoE: without a mail from master or device a transfer ends", timeouts, NULL, NULL, NULL},
        {"FoE: an abandoned file does not count", given_up, NULL, NULL, NULL},
        {"FoE: a transfer continues during SDOs and over a change of state", beside_others, NULL, NULL, NULL},
        {"FoE: while the device is late, other protocols have their turns", turns_of_others, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("foe", tests, NULL, NULL);
}
