/* SPDX-License-Identifier: MIT */
/* B. SyncManagers. The mailbox is tested with requests to which every slave replies. */
#include <string.h>

#include "steps/case.h"

enum {
    MAIL_HEADER = 6,
    SHORT_MS = 50,
    DROPPED_MS = 500,
    FILL_MOST = 24,
    NO_COUNTER = 0xFF,
    UNDER_READ = 4,
    UNDER_READ_MS = 5
};
enum { STATUS_0 = ECT_REG_SM + ECT_SM_STATUS, STATUS_1 = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS };
enum { ACTIVATE_1 = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_ACTIVATE, MAP_LOGICAL = 0x20000 };
enum { CODE_MAILBOX = 0x0016, CODE_OUTPUTS = 0x001D, CODE_INPUTS = 0x001E };
enum { ERROR_SYNTAX = 1, ERROR_PROTOCOL = 2, ERROR_CHANNEL = 3, ERROR_HEADER = 5, ERROR_SHORT = 6, ERROR_SIZE = 8 };

/* --- requests to which every slave with a mailbox replies --------------------------------------------------------- */

/* @return a mailbox type that the slave does not support, so that the reply is a mailbox error */
static uint8_t foreign_type(const cf_t *c)
{
    static const struct {
        uint8_t type, protocol;
    } types[] = {{CF_MBX_VOE, CF_PROTO_VOE}, {CF_MBX_SOE, CF_PROTO_SOE}, {CF_MBX_AOE, CF_PROTO_AOE}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if ((c->facts.protocols & types[i].protocol) == 0)
            return types[i].type;
    }
    return 9;
}

/* Builds a whole mail: an SDO upload of 1018h:`sub`, or an unsupported type. @return bytes of the mail */
static uint16_t build(cf_t *c, uint8_t *mail, uint8_t sub)
{
    memset(mail, 0, CF_MAX_MAIL);
    c->mail_counter = (uint8_t)(c->mail_counter % 7 + 1);
    ect_store_le16(mail, 10);
    if ((c->facts.has & CF_COE) != 0) {
        mail[5] = (uint8_t)(CF_MBX_COE | c->mail_counter << 4);
        ect_store_le16(mail + 6, CF_COE_REQUEST << 12);
        mail[8] = 0x40;
        ect_store_le16(mail + 9, 0x1018);
        mail[11] = sub;
    } else {
        mail[5] = (uint8_t)(foreign_type(c) | c->mail_counter << 4);
    }
    return MAIL_HEADER + 10;
}

static void ask(cf_t *c, uint8_t sub)
{
    uint8_t mail[CF_MAX_MAIL];
    cf_send_raw_mail(c, mail, build(c, mail, sub));
}

/* Waits for a mail without reading it. */
static void wait_full(cf_t *c)
{
    if (!cf_wait_bits(c, STATUS_1, ECT_SM_STATUS_FULL, ECT_SM_STATUS_FULL, CF_MAIL_MS, NULL))
        cf_fail(c, "a reply: expected in SM1 within %d ms, got none", (int)CF_MAIL_MS);
}

static void fetch(cf_t *c, cf_mail_t *mail)
{
    if (!cf_receive_mail(c, mail, CF_MAIL_MS))
        cf_fail(c, "a reply: expected in SM1 within %d ms, got none", (int)CF_MAIL_MS);
}

/* @return sub-index of a reply; `asked` without CoE, where all replies are equal */
static uint8_t reply_sub(const cf_t *c, const cf_mail_t *mail, uint8_t asked)
{
    return (c->facts.has & CF_COE) != 0 ? mail->data[5] : asked;
}

/* --- mailbox SyncManagers ----------------------------------------------------------------------------------------- */

static void last_byte_fills(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    cf_mail_t reply;
    const uint16_t start = c->mailbox.out_start, size = c->mailbox.out_size;
    (void)build(c, mail, 1);
    cf_step(c, "a mail except its last byte");
    cf_expect_wkc(c, "the write without the last byte", 1, cf_write(c, start, mail, size - 1u));
    cf_expect_bits(c, "status of SM0 before the last byte", ECT_SM_STATUS_FULL, 0, cf_get8(c, STATUS_0));
    cf_expect_no_mail(c, SHORT_MS);
    cf_step(c, "the last byte");
    cf_expect_wkc(c, "the write of the last byte", 1, cf_write(c, (uint16_t)(start + size - 1), mail + size - 1, 1));
    fetch(c, &reply);
}

/* Sends mails without reading replies until SM0 is full. One frame reads the status and writes the next mail, so the
 * slave cannot act in between. @return number of mails accepted */
static unsigned int fill(cf_t *c, bool *was_full)
{
    uint8_t mail[CF_MAX_MAIL], status = 0;
    unsigned int accepted = 0;
    *was_full = false;
    while (!*was_full && accepted < FILL_MOST) {
        (void)cf_wait_bits(c, STATUS_0, ECT_SM_STATUS_FULL, 0, SHORT_MS, NULL);
        (void)build(c, mail, (uint8_t)(accepted % 4 + 1));
        cf_datagram_t d[2] = {
            {.command = CF_FPRD, .address = CF_AT(c->facts.station, STATUS_0), .length = 1, .data = &status},
            {.command = CF_FPWR,
             .address = CF_AT(c->facts.station, c->mailbox.out_start),
             .length = c->mailbox.out_size,
             .data = mail}};
        cf_exchange(c, d, 2);
        *was_full = (status & ECT_SM_STATUS_FULL) != 0;
        cf_expect_wkc(c, *was_full ? "a mail into the full SM0" : "a mail into the empty SM0", *was_full ? 0 : 1,
                      d[1].wkc);
        accepted += *was_full ? 0 : 1;
    }
    if (*was_full)
        c->mail_counter = (uint8_t)(c->mail_counter == 1 ? 7 : c->mail_counter - 1); /* the mail was not sent */
    return accepted;
}

static void one_mail(cf_t *c)
{
    cf_mail_t reply;
    bool was_full;
    cf_go(c, CF_PREOP);
    last_byte_fills(c);
    cf_step(c, "requests without reading replies, until SM0 is full and refuses one");
    unsigned int accepted = fill(c, &was_full);
    if (!was_full)
        cf_note(c, "the slave accepted %u requests without a read of a reply: SM0 was never full", accepted);
    cf_step(c, "all %u replies: the mail in SM0 is unchanged", accepted);
    for (unsigned int i = 0; i < accepted; i++) {
        fetch(c, &reply);
        cf_expect(c, "sub-index of the reply", i % 4 + 1, reply_sub(c, &reply, (uint8_t)(i % 4 + 1)));
    }
    cf_expect_no_mail(c, SHORT_MS);
}

static void reading(cf_t *c)
{
    uint8_t data[CF_MAX_MAIL];
    const uint16_t start = c->mailbox.in_start, size = c->mailbox.in_size;
    cf_go(c, CF_PREOP);
    cf_expect_wkc(c, "a read of the empty SM1", 0, cf_read(c, start, data, size));
    ask(c, 1);
    wait_full(c);
    cf_step(c, "reads that begin after the first byte");
    cf_expect_wkc(c, "a read from the second byte on", 0, cf_read(c, (uint16_t)(start + 1), data, size - 1u));
    cf_expect_wkc(c, "a read of the last byte", 0, cf_read(c, (uint16_t)(start + size - 1), data, 1));
    cf_expect_bits(c, "status of SM1", ECT_SM_STATUS_FULL, ECT_SM_STATUS_FULL, cf_get8(c, STATUS_1));
    cf_step(c, "the first half, then the rest");
    cf_expect_wkc(c, "a read of the first half", 1, cf_read(c, start, data, size / 2u));
    cf_expect_range(c, "length of the mail", 1, size - MAIL_HEADER, ect_load_le16(data));
    cf_expect_bits(c, "status of SM1 after the first half", ECT_SM_STATUS_FULL, ECT_SM_STATUS_FULL,
                   cf_get8(c, STATUS_1));
    cf_expect_wkc(c, "a read of the rest", 1, cf_read(c, (uint16_t)(start + size / 2), data, size - size / 2u));
    cf_expect_bits(c, "status of SM1 after the last byte", ECT_SM_STATUS_FULL, 0, cf_get8(c, STATUS_1));
    cf_expect_wkc(c, "a read of the empty SM1", 0, cf_read(c, start, data, size));
}

/* Writes header and data in one datagram, the last byte in another, as TwinCAT does. */
static void split(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL], last = 0, head[2] = {0}, reply[CF_MAX_MAIL] = {0};
    const uint16_t station = c->facts.station, in = c->mailbox.in_start, out = c->mailbox.out_start;
    const uint16_t in_last = (uint16_t)(in + c->mailbox.in_size - 1),
                   out_last = (uint16_t)(out + c->mailbox.out_size - 1);
    cf_go(c, CF_PREOP);
    uint16_t length = build(c, mail, 2);
    if (length == c->mailbox.out_size) /* the mail fills SM0, so its last byte is in the other datagram */
        last = mail[--length];
    cf_step(c, "the mail and the last byte of SM0 as two datagrams of a frame");
    cf_datagram_t write[2] = {{.command = CF_FPWR, .address = CF_AT(station, out), .length = length, .data = mail},
                              {.command = CF_FPWR, .address = CF_AT(station, out_last), .length = 1, .data = &last}};
    cf_exchange(c, write, 2);
    cf_expect_wkc(c, "the mail", 1, write[0].wkc);
    cf_expect_wkc(c, "the last byte", 1, write[1].wkc);
    wait_full(c);
    cf_step(c, "two bytes; in a later frame the mail and the last byte of SM1");
    cf_expect_wkc(c, "a read of the first two bytes", 1, cf_read(c, in, head, 2));
    uint16_t size = (uint16_t)(ect_load_le16(head) + MAIL_HEADER);
    cf_expect_range(c, "length of the reply with its header", MAIL_HEADER + 1, c->mailbox.in_size, size);
    cf_datagram_t read[2] = {{.command = CF_FPRD, .address = CF_AT(station, in), .length = size, .data = reply},
                             {.command = CF_FPRD, .address = CF_AT(station, in_last), .length = 1, .data = &last}};
    cf_exchange(c, read, size < c->mailbox.in_size ? 2 : 1);
    cf_expect_wkc(c, "the mail's bytes", 1, read[0].wkc);
    if (size < c->mailbox.in_size)
        cf_expect_wkc(c, "the last byte", 1, read[1].wkc);
    cf_expect(c, "length in both reads", ect_load_le16(head), ect_load_le16(reply));
    cf_expect_bits(c, "status of SM1 after the last byte", ECT_SM_STATUS_FULL, 0, cf_get8(c, STATUS_1));
}

/* --- three buffers ------------------------------------------------------------------------------------------------ */

/* @return the first process data SyncManager of a type with at least two bytes; -1: none */
static int process_sm(const cf_t *c, uint8_t type)
{
    for (int n = 0; n < c->facts.sm_count; n++) {
        if (c->facts.sm[n].type == type && c->facts.sm[n].length >= 2)
            return n;
    }
    return -1;
}

/* From its first byte to its last, a read owns the buffer, however many other buffers the slave writes. */
static void buffer_under_read(cf_t *c, unsigned int n)
{
    uint8_t first[CF_MAX_DATA], later[CF_MAX_DATA];
    const uint16_t start = c->facts.sm[n].start, length = c->facts.sm[n].length;
    const uint16_t inner = (uint16_t)(length - 2);
    if (inner == 0)
        return;
    cf_step(c, "a read in progress: after its first byte the other bytes do not change until the last one is read");
    cf_expect_wkc(c, "a read of the first byte", 1, cf_read(c, start, first, 1));
    cf_expect_wkc(c, "a read of the inner bytes", 1, cf_read(c, (uint16_t)(start + 1), first, inner));
    for (int i = 0; i < UNDER_READ; i++) {
        cf_sleep_ms(c, UNDER_READ_MS);
        cf_expect_wkc(c, "a later read of the inner bytes", 1, cf_read(c, (uint16_t)(start + 1), later, inner));
        cf_expect_bytes(c, "inner bytes of the buffer under read", first, later, inner);
    }
    cf_expect_wkc(c, "a read of the last byte", 1, cf_read(c, (uint16_t)(start + length - 1), later, 1));
}

static void input_buffers(cf_t *c, unsigned int n)
{
    uint8_t data[CF_MAX_DATA];
    const uint16_t start = c->facts.sm[n].start, length = c->facts.sm[n].length;
    cf_step(c, "inputs");
    cf_expect_wkc(c, "a read from the second byte on, which does not open the buffer", 0,
                  cf_read(c, (uint16_t)(start + 1), data, length - 1u));
    cf_expect_wkc(c, "a read of all inputs", 1, cf_read(c, start, data, length));
    cf_expect_wkc(c, "a second read of all inputs", 1, cf_read(c, start, data, length));
    cf_expect_wkc(c, "a read of the first byte", 1, cf_read(c, start, data, 1));
    cf_expect_wkc(c, "a read of the rest", 1, cf_read(c, (uint16_t)(start + 1), data, length - 1u));
    buffer_under_read(c, n);
    uint8_t status = cf_get8(c, (uint16_t)(CF_SM(n) + ECT_SM_STATUS));
    cf_expect_that(c, (status & ECT_SM_STATUS_BUFFER) != ECT_SM_STATUS_BUFFER,
                   "status of the input SM: expected a last written buffer 0..2, got 0x%02X", status);
}

static void output_buffers(cf_t *c, unsigned int n)
{
    uint8_t zeros[CF_MAX_DATA] = {0};
    const uint16_t start = c->facts.sm[n].start, length = c->facts.sm[n].length;
    const uint16_t reg = (uint16_t)(CF_SM(n) + ECT_SM_STATUS);
    cf_step(c, "outputs, in OP");
    cf_go(c, CF_OP);
    uint8_t before = cf_get8(c, reg) & ECT_SM_STATUS_BUFFER;
    cf_expect_wkc(c, "a write from the second byte on, which does not open the buffer", 0,
                  cf_write(c, (uint16_t)(start + 1), zeros, length - 1u));
    cf_expect_wkc(c, "a write without the last byte", 1, cf_write(c, start, zeros, length - 1u));
    cf_expect_bits(c, "last written buffer before the last byte", ECT_SM_STATUS_BUFFER, before, cf_get8(c, reg));
    cf_expect_wkc(c, "a write of the last byte", 1, cf_write(c, (uint16_t)(start + length - 1), zeros, 1));
    uint8_t after = cf_get8(c, reg) & ECT_SM_STATUS_BUFFER;
    cf_expect_that(c, after != before && after != ECT_SM_STATUS_BUFFER,
                   "last written buffer: expected a value other than %u, got %u", before >> 4, after >> 4);
}

static void three_buffers(cf_t *c)
{
    int inputs = process_sm(c, ECT_SM_INPUTS), outputs = process_sm(c, ECT_SM_OUTPUTS);
    if (inputs < 0 && outputs < 0)
        cf_skip(c, "no process data of at least two bytes: one byte is not buffered");
    cf_go(c, CF_SAFEOP);
    if (inputs >= 0)
        input_buffers(c, (unsigned int)inputs);
    if (outputs >= 0)
        output_buffers(c, (unsigned int)outputs);
}

/* A chip changes the status at the end of the frame that has read the mail, so the next frame reads the status.
 * Meanwhile the slave may have written another mail, with another counter. */
static void read_until_empty(cf_t *c)
{
    uint8_t data[CF_MAX_MAIL], status = ECT_SM_STATUS_FULL;
    unsigned int last = NO_COUNTER;
    for (int mails = 0; mails < FILL_MOST && (status & ECT_SM_STATUS_FULL) != 0; mails++) {
        cf_expect_wkc(c, "reading the mail", 1, cf_read(c, c->mailbox.in_start, data, c->mailbox.in_size));
        unsigned int counter = data[5] >> 4 & 7u;
        cf_expect_that(c, counter != last,
                       "status of SM1 after the read: expected not full, got full with the same mail");
        last = counter;
        status = cf_get8(c, STATUS_1);
    }
    cf_expect_bits(c, "status of SM1 after the read: read, not full", ECT_SM_STATUS_FULL | ECT_SM_STATUS_READ,
                   ECT_SM_STATUS_READ, status);
}

static void status_byte(cf_t *c)
{
    uint8_t mapped = 0;
    cf_go(c, CF_PREOP);
    cf_expect_bits(c, "status of the empty SM1", ECT_SM_STATUS_FULL, 0, cf_get8(c, STATUS_1));
    ask(c, 1);
    wait_full(c);
    uint8_t full = cf_get8(c, STATUS_1);
    cf_expect_bits(c, "status of the full SM1: full and written", ECT_SM_STATUS_FULL | ECT_SM_STATUS_WRITTEN,
                   ECT_SM_STATUS_FULL | ECT_SM_STATUS_WRITTEN, full);
    cf_step(c, "the status byte through an FMMU, complete, and bit 3 alone");
    cf_set_fmmu(c, 0, MAP_LOGICAL, 1, 0, 7, STATUS_1, 0, 1);
    cf_expect_wkc(c, "LRD of the mapped status byte", 1, cf_logical(c, CF_LRD, MAP_LOGICAL, &mapped, 1));
    cf_expect(c, "the mapped status byte", full, mapped);
    if ((c->facts.features & 1) == 0) {
        cf_set_fmmu(c, 0, MAP_LOGICAL, 1, 5, 5, STATUS_1, 3, 1);
        mapped = 0;
        cf_expect_wkc(c, "LRD of the mapped bit", 1, cf_logical(c, CF_LRD, MAP_LOGICAL, &mapped, 1));
        cf_expect(c, "the full flag, mapped to bit 5", 0x20, mapped);
    }
    read_until_empty(c);
}

/* --- activation and changes --------------------------------------------------------------------------------------- */

static void deactivated(cf_t *c)
{
    uint8_t data[CF_MAX_MAIL] = {0};
    unsigned int off = 0;
    cf_go(c, CF_PREOP);
    cf_expect_bits(c, "PDI control of SM0 in PREOP", ECT_SM_PDI_DISABLE, 0,
                   cf_get8(c, (uint16_t)(CF_SM(0) + ECT_SM_PDI_CONTROL)));
    cf_go(c, CF_INIT);
    cf_step(c, "SM0 and SM1 in INIT, enabled by the master");
    cf_set_mailbox(c, CF_PREOP);
    for (unsigned int n = 0; n < 2; n++) {
        if ((cf_get8(c, (uint16_t)(CF_SM(n) + ECT_SM_PDI_CONTROL)) & ECT_SM_PDI_DISABLE) == 0)
            continue;
        off++;
        uint16_t wkc = n == 0 ? cf_write(c, c->mailbox.out_start, data, c->mailbox.out_size)
                              : cf_read(c, c->mailbox.in_start, data, c->mailbox.in_size);
        cf_expect_wkc(c, n == 0 ? "a write to SM0, disabled by the slave" : "a read of SM1, disabled by the slave", 0,
                      wkc);
    }
    cf_step(c, "back in PREOP the mailbox works again");
    cf_go(c, CF_PREOP);
    ask(c, 1);
    wait_full(c);
    if (off == 0)
        cf_note(c, "the slave leaves its SyncManagers enabled in INIT: none is deactivated");
}

static void expect_fallback(cf_t *c, const char *what, uint8_t state, uint16_t code)
{
    uint16_t got, got_code;
    cf_wait_status(c, state | ECT_AL_ERROR, 5000, false, &got, &got_code);
    cf_expect_that(c, (got & 0x1F) == (state | ECT_AL_ERROR) && got_code == code,
                   "%s: expected %s with code 0x%04X, got %s with code 0x%04X", what,
                   cf_state_name(state | ECT_AL_ERROR), code, cf_state_name(got), got_code);
}

static void disable_sm(cf_t *c, unsigned int n)
{
    cf_put8(c, (uint16_t)(CF_SM(n) + ECT_SM_ACTIVATE), 0);
}

static void changed_mailbox(cf_t *c, uint8_t state)
{
    for (unsigned int n = 0; n < 2; n++) {
        cf_go(c, state);
        cf_step(c, "SM%u disabled in %s", n, cf_state_name(state));
        disable_sm(c, n);
        expect_fallback(c, n == 0 ? "SM0 switched off" : "SM1 switched off", CF_INIT, CODE_MAILBOX);
    }
}

static void changed_process_data(cf_t *c, uint8_t type, uint8_t state, uint16_t code)
{
    int n = -1;
    for (int i = 0; i < c->facts.sm_count; i++)
        n = n < 0 && c->facts.sm[i].type == type && c->facts.sm[i].length > 0 ? i : n;
    if (n < 0)
        return;
    cf_go(c, state);
    cf_step(c, "SM%d disabled in %s", n, cf_state_name(state));
    disable_sm(c, (unsigned int)n);
    expect_fallback(c, type == ECT_SM_OUTPUTS ? "output SM disabled" : "input SM disabled", CF_PREOP, code);
}

static void changed(cf_t *c)
{
    static const uint8_t states[] = {CF_SAFEOP, CF_OP};
    if ((c->facts.has & CF_MAILBOX) != 0)
        changed_mailbox(c, CF_PREOP);
    for (size_t i = 0; i < sizeof states; i++) {
        changed_process_data(c, ECT_SM_OUTPUTS, states[i], CODE_OUTPUTS);
        changed_process_data(c, ECT_SM_INPUTS, states[i], CODE_INPUTS);
    }
}

/* --- lost and repeated mails -------------------------------------------------------------------------------------- */

/* Reads status, activate and PDI control of SM1 in one datagram. */
static void read_sm1(cf_t *c, uint8_t registers[3])
{
    cf_get(c, STATUS_1, registers, 3);
}

/* Inverts the repeat request and waits for the acknowledge.
 * @param[out] status  of SM1 in the first read with the acknowledge
 * @return whether the slave acknowledges */
static bool try_repeat(cf_t *c, uint8_t *status)
{
    uint8_t registers[3];
    read_sm1(c, registers);
    cf_put8(c, ACTIVATE_1, registers[1] ^ ECT_SM_ACTIVATE_REPEAT);
    uint64_t until = cf_now_ns() + CF_MAIL_MS * UINT64_C(1000000);
    for (;;) {
        bool over = cf_now_ns() >= until;
        read_sm1(c, registers);
        *status = registers[0];
        if (((registers[1] ^ registers[2]) & ECT_SM_ACTIVATE_REPEAT) == 0)
            return true;
        if (over)
            return false;
    }
}

static uint8_t repeat(cf_t *c)
{
    uint8_t status;
    if (!try_repeat(c, &status))
        cf_fail(c, "repeat acknowledge: expected within %d ms, got none", (int)CF_MAIL_MS);
    return status;
}

/* Requests a repeat without a mail to repeat. Some slaves never acknowledge this. */
static void repeat_of_nothing(cf_t *c)
{
    uint8_t status;
    cf_go(c, CF_INIT);
    cf_go(c, CF_PREOP);
    cf_step(c, "a repeat request before any mail of the slave");
    if (!try_repeat(c, &status))
        cf_warn(c, "a repeat request before the slave has sent anything is not acknowledged");
    cf_expect_no_mail(c, SHORT_MS);
}

static void repeated(cf_t *c)
{
    uint8_t first[CF_MAX_MAIL], again[CF_MAX_MAIL];
    const uint16_t start = c->mailbox.in_start, size = c->mailbox.in_size;
    cf_go(c, CF_PREOP);
    ask(c, 1);
    wait_full(c);
    cf_expect_wkc(c, "reading the reply", 1, cf_read(c, start, first, size));
    for (int times = 0; times < 2; times++) {
        cf_step(c, times == 0 ? "a repeat request returns the same reply" : "repeat a second time");
        uint8_t status = repeat(c);
        cf_expect_bits(c, "status of SM1 when the repeat is acknowledged", ECT_SM_STATUS_FULL, ECT_SM_STATUS_FULL,
                       status);
        cf_expect_wkc(c, "reading the repeated reply", 1, cf_read(c, start, again, size));
        cf_expect_bytes(c, "the repeated reply", first, again, (size_t)ect_load_le16(first) + MAIL_HEADER);
    }
    cf_step(c, "the next request gets a reply of its own");
    ask(c, 2);
    cf_mail_t reply;
    fetch(c, &reply);
    cf_expect(c, "counter of the next reply", (first[5] >> 4 & 7u) % 7 + 1, reply.counter);
    repeat_of_nothing(c);
}

/* A mail with the same counter as the previous one counts as its repetition, whatever the content. */
static void duplicate(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    cf_mail_t first, second;
    ask(c, 1);
    fetch(c, &first);
    c->mail_counter =
        (uint8_t)(c->mail_counter == 1 ? 7 : c->mail_counter - 1); /* the next mail gets the same counter */
    cf_step(c, "a request with the counter of the previous one");
    cf_send_raw_mail(c, mail, build(c, mail, 2));
    if (!cf_receive_mail(c, &second, DROPPED_MS)) {
        cf_warn(c, "a request with the counter of the previous one is discarded without a reply");
        return;
    }
    cf_expect(c, "counter of the reply to a repeated request", first.counter, second.counter);
    cf_expect_range(c, "length of the reply to a repeated request", first.length, first.length, second.length);
    cf_expect_bytes(c, "the reply to a repeated request", first.data, second.data, first.length);
}

static void mail_counters(cf_t *c)
{
    cf_mail_t reply;
    unsigned int last = 0;
    cf_go(c, CF_PREOP);
    for (unsigned int i = 0; i < 16; i++) {
        ask(c, (uint8_t)(i % 4 + 1));
        fetch(c, &reply);
        cf_expect_range(c, "counter of a reply", i == 0 ? 1 : last % 7 + 1, i == 0 ? 7 : last % 7 + 1, reply.counter);
        last = reply.counter;
    }
    duplicate(c);
    cf_step(c, "counter 0: not counted, never a repetition");
    for (unsigned int i = 0; i < 2; i++) {
        uint8_t mail[CF_MAX_MAIL];
        uint16_t length = build(c, mail, (uint8_t)(i + 1));
        mail[5] &= 0x0F;
        cf_send_raw_mail(c, mail, length);
        fetch(c, &reply);
        cf_expect(c, "sub-index of the reply to a request with counter 0", i + 1,
                  reply_sub(c, &reply, (uint8_t)(i + 1)));
    }
}

static void busy(cf_t *c)
{
    cf_mail_t reply;
    cf_go(c, CF_PREOP);
    ask(c, 1);
    wait_full(c);
    cf_step(c, "a second request while the reply to the first waits in SM1");
    ask(c, 2);
    cf_sleep_ms(c, SHORT_MS);
    fetch(c, &reply);
    cf_expect(c, "sub-index of the first reply", 1, reply_sub(c, &reply, 1));
    fetch(c, &reply);
    cf_expect(c, "sub-index of the second reply", 2, reply_sub(c, &reply, 2));
    cf_expect_no_mail(c, SHORT_MS);
}

/* --- headers ------------------------------------------------------------------------------------------------------ */

/* Sends an invalid mail, which must give an error, and then a valid one. @param allowed  bit n: detail code n */
static void refused(cf_t *c, const char *what, const uint8_t *mail, uint16_t length, uint32_t allowed)
{
    cf_mail_t reply;
    cf_step(c, "%s", what);
    cf_send_raw_mail(c, mail, length);
    cf_receive(c, CF_MBX_ERROR, &reply);
    cf_expect_that(c, reply.length >= 4, "%s: expected a mailbox error of 4 bytes, got %u", what, reply.length);
    cf_expect(c, "type word of a mailbox error", 1, ect_load_le16(reply.data));
    unsigned int detail = ect_load_le16(reply.data + 2);
    cf_expect_that(c, detail < 32 && (allowed & (1u << detail)) != 0,
                   "%s: expected an allowed error detail, got 0x%04X", what, detail);
    ask(c, 1);
    fetch(c, &reply);
    if ((c->facts.has & CF_COE) != 0)
        cf_expect(c, "mailbox type of the reply to the next request", CF_MBX_COE, reply.type);
}

static void headers(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    const uint32_t lengths = 1u << ERROR_SYNTAX | 1u << ERROR_HEADER | 1u << ERROR_SHORT | 1u << ERROR_SIZE;
    cf_go(c, CF_PREOP);
    uint16_t length = build(c, mail, 1);
    ect_store_le16(mail, (uint16_t)(c->mailbox.out_size - MAIL_HEADER + 1));
    refused(c, "a length greater than SM0", mail, length, lengths);
    length = build(c, mail, 1);
    ect_store_le16(mail, 0);
    refused(c, "a length of 0", mail, length, lengths);
    length = build(c, mail, 1);
    mail[5] = (uint8_t)((mail[5] & 0xF0) | foreign_type(c));
    refused(c, "a protocol unsupported by the slave", mail, length, 1u << ERROR_PROTOCOL);
    length = build(c, mail, 1);
    mail[5] = (uint8_t)((mail[5] & 0xF0) | 9);
    refused(c, "an unknown protocol", mail, length, 1u << ERROR_PROTOCOL | 1u << ERROR_SYNTAX);
}

/* ETG.1000.4, 5.6: a mail of a slave has address 0 or the slave's own, and channel 0. */
static void check_mail_header(cf_t *c, const char *what, const cf_mail_t *reply)
{
    cf_expect_that(c, reply->address == 0 || reply->address == c->facts.station,
                   "address in the header of %s: expected 0x0000 or 0x%04X, got 0x%04X", what, c->facts.station,
                   reply->address);
    cf_expect_that(c, (reply->channel & 0x3F) == 0, "channel in the header of %s: expected 0, got %u", what,
                   reply->channel & 0x3Fu);
}

static void mail_headers(cf_t *c)
{
    cf_mail_t reply;
    cf_go(c, CF_PREOP);
    ask(c, 1);
    fetch(c, &reply);
    check_mail_header(c, "a reply", &reply);
    cf_send_mail(c, foreign_type(c), "", 0);
    fetch(c, &reply);
    check_mail_header(c, "a mailbox error", &reply);
}

static bool overlap(uint16_t a, uint16_t a_size, uint16_t b, uint16_t b_size)
{
    return a < b + b_size && b < a + a_size;
}

static void check_mailbox(cf_t *c, const char *which, const cf_mailbox_t *m)
{
    const uint32_t end = ECT_RAM + c->facts.ram_kb * 1024u;
    cf_expect_that(c, m->out_size >= 16 && m->in_size >= 16, "%s: expected at least 16 bytes each way, got %u and %u",
                   which, m->out_size, m->in_size);
    cf_expect_that(c,
                   m->out_start >= ECT_RAM && m->in_start >= ECT_RAM && (uint32_t)m->out_start + m->out_size <= end &&
                       (uint32_t)m->in_start + m->in_size <= end,
                   "%s: expected in the RAM up to 0x%04X, got 0x%04X+%u and 0x%04X+%u", which, end, m->out_start,
                   m->out_size, m->in_start, m->in_size);
    cf_expect_that(c, !overlap(m->out_start, m->out_size, m->in_start, m->in_size),
                   "%s: expected apart, got 0x%04X+%u and 0x%04X+%u", which, m->out_start, m->out_size, m->in_start,
                   m->in_size);
}

static void sizes(cf_t *c)
{
    size_t length;
    const cf_mailbox_t *m = &c->mailbox;
    const uint8_t *category = cf_sii_category(c, 41, &length);
    check_mailbox(c, "standard mailbox", m);
    if (category && length >= 16) {
        cf_expect(c, "start of SM0 in the SyncManager category", m->out_start, ect_load_le16(category));
        cf_expect(c, "start of SM1 in the SyncManager category", m->in_start, ect_load_le16(category + 8));
        cf_expect(c, "length of SM0 in the SyncManager category", m->out_size, ect_load_le16(category + 2));
        cf_expect(c, "length of SM1 in the SyncManager category", m->in_size, ect_load_le16(category + 10));
        cf_expect_bits(c, "control of SM0: mailbox, written by the master", 0x0F, 0x06, category[4]);
        cf_expect_bits(c, "control of SM1: mailbox, read by the master", 0x0F, 0x02, category[12]);
    }
    cf_step(c, "PREOP with the sizes of the SII");
    cf_go(c, CF_PREOP);
    ask(c, 1);
    wait_full(c);
    if ((c->facts.has & CF_BOOTSTRAP) == 0)
        return;
    check_mailbox(c, "bootstrap mailbox", &c->facts.boot);
    cf_go(c, CF_BOOT);
}

static const cf_case_t cases[] = {
    {"CF-016", "A mailbox takes one mail, is full with its last byte, and refuses a second one", 'R', CF_MAILBOX, 0,
     one_mail},
    {"CF-017", "A mail is read from its first byte on, and SM1 is empty after its last byte", 'R', CF_MAILBOX, 0,
     reading},
    {"CF-018", "Accesses to first and last byte in separate datagrams work like one access", 'R', CF_MAILBOX, 0, split},
    {"CF-019", "An access to three buffers starts with the first byte and ends with the last", 'R', CF_APPLICATION, 0,
     three_buffers},
    {"CF-020", "A SyncManager's status reports full, written, read, also through an FMMU", 'R', CF_MAILBOX, 0,
     status_byte},
    {"CF-021", "Accesses to a SyncManager disabled by the slave have WKC 0, and work again later", 'R', CF_MAILBOX, 0,
     deactivated},
    {"CF-022", "The slave falls back with the right code when the master disables a SyncManager", 'R', CF_APPLICATION,
     0, changed},
    {"CF-023", "The slave returns the same mail before it acknowledges a repeat request", 'R', CF_MAILBOX, 0, repeated},
    {"CF-024", "Replies count 1 to 7; a request with the counter of the previous one is not executed again", 'R',
     CF_MAILBOX, 0, mail_counters},
    {"CF-025", "A request while a reply waits is kept, and neither is lost", 'R', CF_MAILBOX, 0, busy},
    {"CF-026", "Mails with a wrong header get an error reply, and the next request works", 'R', CF_MAILBOX, 0, headers},
    {"CF-027", "The mailboxes of the SII are consistent, and the slave accepts them", 'R', CF_MAILBOX | CF_SII, 0,
     sizes},
    {"CF-098", "Mails of the slave have address 0 or its own, and channel 0", 'R', CF_MAILBOX, 0, mail_headers},
};

CF_SECTION(cf_syncman, 'B', "SyncManagers", cases);
