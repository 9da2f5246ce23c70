/* SPDX-License-Identifier: MIT */
/* Cases on request: load, malformed requests, measured times. Random numbers start with --seed. */
#include <string.h>

#include "cases/beyond.h"

enum { CONSTANTS_MOST = 8, CONSTANT_BYTES = 128, LIMIT_MS = 3600000 };

static uint64_t end_ns(const cf_t *c)
{
    return cf_now_ns() + c->seconds * UINT64_C(1000000000);
}

/* --- stress ------------------------------------------------------------------------------------------------------- */

/* A constant object; another value would be the reply to another request. */
typedef struct constant {
    uint16_t index;
    uint8_t sub;
    size_t size;
    uint8_t data[CONSTANT_BYTES];
} constant_t;

typedef struct stress {
    constant_t constants[CONSTANTS_MOST];
    size_t count;
    uint8_t state; /* AL state in which process data are judged; 0: during a transition */
    unsigned long cycles, transfers, changes;
} stress_t;

static void cycle(cf_t *c, void *ctx)
{
    stress_t *s = ctx;
    uint16_t wkc = cf_cycle(c, NULL, NULL);
    s->cycles++;
    if (s->state == CF_OP)
        cf_expect_wkc(c, "process data in OP", cf_cycle_wkc(c), wkc);
}

static void read_constants(cf_t *c, stress_t *s)
{
    static const struct {
        uint16_t index;
        uint8_t sub;
    } objects[] = {{0x1000, 0}, {0x1018, 1}, {0x1018, 2}, {0x1018, 3},
                   {0x1018, 4}, {0x1008, 0}, {0x1009, 0}, {0x100A, 0}};
    for (size_t i = 0; i < sizeof objects / sizeof objects[0]; i++) {
        constant_t *k = &s->constants[s->count];
        *k = (constant_t){.index = objects[i].index, .sub = objects[i].sub, .size = sizeof k->data};
        s->count += cf_upload(c, k->index, k->sub, false, k->data, &k->size) == 0;
    }
    if (s->count == 0)
        cf_skip(c, "the slave has none of 1000h, 1008h to 100Ah, 1018h");
}

static const constant_t *any(cf_t *c, const stress_t *s)
{
    return &s->constants[cf_random(c, (uint32_t)s->count)];
}

static void transfer(cf_t *c, stress_t *s)
{
    const constant_t *k = any(c, s);
    uint8_t data[CONSTANT_BYTES] = {0};
    size_t size = sizeof data;
    uint32_t code = cf_upload(c, k->index, k->sub, false, data, &size);
    cf_expect_that(c, code == 0, "upload of %04Xh:%02X: expected data, got abort 0x%08X", k->index, k->sub, code);
    cf_expect_range(c, "bytes of a constant object", k->size, k->size, size);
    cf_expect_bytes(c, "a constant object", k->data, data, size);
    s->transfers++;
}

static void change(cf_t *c, stress_t *s, uint8_t state)
{
    s->state = 0;
    cf_while_waiting(c, NULL, NULL);
    cf_go(c, state);
    s->state = state;
    cf_while_waiting(c, state >= CF_SAFEOP ? cycle : NULL, s);
    s->changes++;
}

/* Requests a transition between a mail and its reply; both must complete. */
static void change_with_a_mail(cf_t *c, stress_t *s)
{
    const constant_t *k = any(c, s);
    cf_mail_t mail;
    cf_send_sdo(c, 0x40, k->index, k->sub, 0);
    change(c, s, s->state == CF_OP ? CF_SAFEOP : CF_OP);
    cf_receive_coe(c, &mail);
    cf_expect(c, "index of the reply", k->index, ect_load_le16(mail.data + 3));
    cf_expect(c, "sub-index of the reply", k->sub, mail.data[5]);
    s->transfers++;
}

static void stress(cf_t *c)
{
    static stress_t s; /* static: too large for the stack */
    s = (stress_t){.count = 0};
    cf_go(c, CF_PREOP);
    read_constants(c, &s);
    change(c, &s, CF_OP);
    for (uint64_t end = end_ns(c); cf_now_ns() < end;) {
        switch (cf_random(c, 24)) {
        case 0:
            change(c, &s, CF_INIT);
            change(c, &s, CF_OP);
            break;
        case 1:
            change(c, &s, CF_PREOP);
            transfer(c, &s);
            change(c, &s, CF_OP);
            break;
        case 2:
        case 3:
            change_with_a_mail(c, &s);
            break;
        case 4:
        case 5:
        case 6:
            cycle(c, &s);
            break;
        default:
            cycle(c, &s);
            transfer(c, &s);
            break;
        }
    }
    cf_note(c, "%lu cycles, %lu SDO transfers, %lu changes of state in %u s", s.cycles, s.transfers, s.changes,
            c->seconds);
}

/* --- fuzz --------------------------------------------------------------------------------------------------------- */

enum { MAIL_HEADER = 6, FOE_WRITE = 2, ROUND = 32, ETHERNET = 14, FRAME_MOST = 300 };

static void fill(cf_t *c, uint8_t *bytes, size_t length)
{
    for (size_t i = 0; i < length; i++)
        bytes[i] = (uint8_t)cf_random(c, 256);
}

/* Makes requests with lasting effects harmless: downloads, files, IP addresses, writes of other protocols. */
static void disarm(const cf_t *c, uint8_t *mail)
{
    switch (mail[5] & 0x0F) {
    case CF_MBX_COE:
        mail[8] |= mail[8] >> 5 == 1 ? 0x40 : 0; /* a download becomes a segment request */
        break;
    case CF_MBX_FOE:
        mail[6] = mail[6] == FOE_WRITE ? 0x7F : mail[6];
        break;
    case CF_MBX_ERROR:
        break;
    default:
        if ((c->facts.protocols & ~(CF_PROTO_COE | CF_PROTO_FOE)) != 0)
            mail[5] = CF_MBX_ERROR;
        break;
    }
}

/* Writes a valid header, so that malformed content reaches the protocol. */
static void likely_header(cf_t *c, uint8_t *mail)
{
    ect_store_le16(mail, (uint16_t)(cf_random(c, 3) == 0 ? cf_random(c, 12) : 10));
    ect_store_le16(mail + 2, 0);
    mail[4] = 0;
    mail[5] = (uint8_t)(cf_random(c, 8) << 4 | (cf_random(c, 3) == 0 ? cf_random(c, 16) : CF_MBX_COE));
    ect_store_le16(mail + 6, (uint16_t)(cf_random(c, 3) == 0 ? cf_random(c, 16) << 12 : CF_COE_REQUEST << 12));
}

/* Sends a mail of random bytes, without a lasting effect. */
static void random_mail(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL] = {0};
    fill(c, mail, cf_random(c, 4) == 0 ? c->mailbox.out_size : 16u);
    if (cf_random(c, 4) != 0)
        likely_header(c, mail);
    disarm(c, mail);
    (void)cf_write(c, c->mailbox.out_start, mail, c->mailbox.out_size);
}

/* Sends reads with any command, address and length, and writes without lasting effect: FMMUs, SyncManagers, RAM. */
static void random_datagrams(cf_t *c)
{
    static const uint8_t reads[] = {CF_NOP, CF_APRD, CF_FPRD, CF_BRD, CF_LRD, 15, 99, 255};
    static const uint8_t writes[] = {CF_APWR, CF_FPWR, CF_FPWR, CF_LWR, CF_LRW};
    static const uint16_t places[] = {ECT_REG_FMMU, ECT_REG_SM, ECT_RAM, ECT_RAM + 0x80, ECT_RAM + 0x100};
    uint8_t data[4][64];
    cf_datagram_t d[4];
    size_t count = 1 + cf_random(c, 4);
    for (size_t i = 0; i < count; i++) {
        bool write = cf_random(c, 3) == 0;
        uint16_t adp = cf_random(c, 2) == 0 ? c->facts.station : c->facts.ring;
        uint16_t ado = write ? (uint16_t)(places[cf_random(c, 5)] + cf_random(c, 32)) : (uint16_t)cf_random(c, 0x10000);
        fill(c, data[i], sizeof data[i]);
        d[i] = (cf_datagram_t){.command = write ? writes[cf_random(c, 5)] : reads[cf_random(c, 8)],
                               .address = CF_AT(adp, ado),
                               .length = (uint16_t)cf_random(c, 65),
                               .data = data[i]};
    }
    cf_exchange(c, d, count);
}

/* Sends a frame of reads with random lengths and flags. However a slave parses it, it contains no write. */
static void random_frame(cf_t *c)
{
    static const uint8_t harmless[] = {0x00, 0x01, 0x04, 0x07, 0x0A, 0x80, 0xFF};
    uint8_t frame[FRAME_MOST] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4};
    size_t length = 60 + cf_random(c, FRAME_MOST - 60);
    for (size_t i = ETHERNET; i < length; i++)
        frame[i] = harmless[cf_random(c, sizeof harmless)];
    frame[ETHERNET + 1] = (uint8_t)(cf_random(c, 4) == 0 ? cf_random(c, 256) : 0x10);
    frame[ETHERNET + 3] = 0xEE; /* an index unused by exchanges */
    (void)cf_raw_frame(c, frame, length, NULL);
}

static void random_request(cf_t *c)
{
    uint8_t value[2] = {(uint8_t)cf_random(c, 64), 0};
    (void)cf_write(c, ECT_REG_AL_CONTROL, value, sizeof value);
}

uint64_t cf_start_up(cf_t *c)
{
    uint64_t vendor = 0;
    cf_step(c, "a standard start-up");
    cf_put8(c, ECT_REG_SII_CONFIG, 0);
    cf_known_state(c);
    cf_go(c, CF_OP);
    if ((c->facts.has & CF_COE) != 0)
        vendor = cf_upload_number(c, 0x1018, 1);
    cf_put8(c, ECT_REG_SII_CONFIG, 1); /* assigned to the slave, the EEPROM cannot be written by a request */
    return vendor;
}

static void send_random_request(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    bool mailbox = (c->facts.has & CF_MAILBOX) != 0;
    switch (cf_random(c, 8)) {
    case 0:
        random_datagrams(c);
        break;
    case 1:
        random_frame(c);
        break;
    case 2:
        random_request(c);
        break;
    default:
        if (mailbox)
            random_mail(c);
        if (mailbox && cf_random(c, 4) == 0)
            (void)cf_read(c, c->mailbox.in_start, mail, c->mailbox.in_size);
        break;
    }
}

unsigned long cf_fuzz_rounds(cf_t *c, unsigned int rounds, unsigned int each)
{
    const uint64_t vendor = cf_start_up(c), end = end_ns(c);
    unsigned long thrown = 0;
    for (unsigned int round = 1; rounds != 0 ? round <= rounds : cf_now_ns() < end; round++) {
        cf_step(c, "round %u", round);
        for (unsigned int i = 0; i < each; i++, thrown++)
            send_random_request(c);
        cf_expect(c, "vendor id, 1018h:01", vendor, cf_start_up(c));
    }
    return thrown;
}

static void fuzz(cf_t *c)
{
    unsigned long thrown = cf_fuzz_rounds(c, 0, ROUND);
    cf_note(c, "%lu mails, frames and requests, with a successful start-up after each %d", thrown, (int)ROUND);
}

/* --- timing ------------------------------------------------------------------------------------------------------- */

enum { FRAMES = 1000, MAILS = 200, CHANGES = 20, EXCHANGES = 200, GIVE_UP = 2000 };

static void measure_frames(cf_t *c)
{
    uint8_t byte;
    for (int i = 0; i < FRAMES; i++) {
        uint64_t start = cf_now_ns();
        (void)cf_read(c, ECT_REG_TYPE, &byte, 1);
        cf_measure(c, "round trip of a frame", cf_now_ns() - start);
    }
}

static void measure_change(cf_t *c, uint8_t state, const char *series)
{
    uint64_t start = cf_now_ns();
    cf_expect_state(c, state, state);
    cf_measure(c, series, cf_now_ns() - start);
}

static void measure_changes(cf_t *c)
{
    for (int i = 0; i < CHANGES; i++) {
        cf_set_mailbox(c, CF_PREOP);
        measure_change(c, CF_PREOP, "INIT to PREOP");
        cf_set_process_data(c);
        measure_change(c, CF_SAFEOP, "PREOP to SAFEOP");
        uint64_t start = cf_now_ns();
        cf_go(c, CF_OP);
        cf_measure(c, "SAFEOP to OP, with process data", cf_now_ns() - start);
        measure_change(c, CF_SAFEOP, "OP to SAFEOP");
        measure_change(c, CF_INIT, "SAFEOP to INIT");
    }
}

static void measure_mails(cf_t *c)
{
    cf_go(c, CF_PREOP);
    for (int i = 0; i < MAILS; i++) {
        uint64_t start = cf_now_ns();
        if ((c->facts.has & CF_COE) != 0) {
            (void)cf_upload_number(c, 0x1000, 0);
        } else {
            cf_mail_t mail;
            cf_send_mail(c, 9, "", 0); /* refused; the time of a refusal is measured too */
            cf_receive(c, CF_MBX_ERROR, &mail);
        }
        cf_measure(c, "a mailbox request and its reply", cf_now_ns() - start);
    }
}

static int input_sm(const cf_t *c)
{
    for (int n = 0; n < c->facts.sm_count; n++) {
        if (c->facts.sm[n].type == ECT_SM_INPUTS && c->facts.sm[n].length >= 2)
            return n;
    }
    return -1;
}

/* Measures the time from a frame with outputs to the next input buffer. */
static void measure_inputs(cf_t *c)
{
    const int in = input_sm(c);
    if (in < 0 || c->facts.output_bytes == 0)
        return;
    const uint16_t status = (uint16_t)(CF_SM(in) + ECT_SM_STATUS);
    cf_go(c, CF_OP);
    for (int i = 0; i < EXCHANGES; i++) {
        uint8_t before = cf_get8(c, status) & ECT_SM_STATUS_BUFFER, now = before;
        uint64_t start = cf_now_ns();
        (void)cf_cycle(c, NULL, NULL);
        for (int tries = 0; now == before && tries < GIVE_UP; tries++)
            now = cf_get8(c, status) & ECT_SM_STATUS_BUFFER;
        if (now != before)
            cf_measure(c, "outputs to the next inputs", cf_now_ns() - start);
    }
}

static void timing(cf_t *c)
{
    measure_frames(c);
    if ((c->facts.has & CF_MAILBOX) != 0)
        measure_mails(c);
    cf_go(c, CF_INIT);
    measure_changes(c);
    measure_inputs(c);
    cf_note(c, "measured by this PC, including its own delays");
}

static const cf_case_t cases[] = {
    {"STRESS", "During concurrent SDO transfers, process data and state changes no reply is lost or confused", 'F',
     CF_STRESS | CF_COE, LIMIT_MS, stress},
    {"FUZZ", "After malformed mails and frames the slave replies as before", 'F', CF_FUZZ, LIMIT_MS, fuzz},
    {"TIMING", "Times of frames, mails, state changes and process data are measured", 'T', CF_TIMING | CF_APPLICATION,
     120000, timing},
};

CF_SECTION(cf_beyond, 'K', "Beyond the checklist", cases);
