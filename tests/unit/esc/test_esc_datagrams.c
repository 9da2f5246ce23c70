/* SPDX-License-Identifier: MIT */
/* Frames and datagrams: which slave acts, the effect on data, address, IRQ field and working counter, and which frames
 * pass (data sheet I sections 2, 3 and 14; ETG.1000.4 section 5). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "esc/route.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SLAVES = 3, RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, STATION = 0x2001, ALIAS = 0x3001, USER = 0x0F80 };
enum { DATA = 10 };

typedef struct rig {
    ect_esc_personality_t personality;
    uint8_t memory[SLAVES][MEMORY];
    uint8_t sii[SLAVES][64];
    ect_esc_t esc[SLAVES];
    wire_t w;
} rig_t;

static uint8_t crc8(const uint8_t *bytes, unsigned int count)
{
    unsigned int crc = 0xFF;
    for (unsigned int bit = 0; bit < count * 8; bit++) {
        unsigned int in = ((unsigned int)bytes[bit / 8] >> (7 - bit % 8)) & 1u;
        crc = ((crc << 1) & 0xFF) ^ (((crc >> 7) ^ in) != 0 ? 0x07u : 0u);
    }
    return (uint8_t)crc;
}

static void init_slave(rig_t *r, unsigned int i, uint8_t open_ports, bool keep_source_mac)
{
    const ect_esc_config_t config = {.personality = &r->personality,
                                     .memory = r->memory[i],
                                     .sii = r->sii[i],
                                     .sii_size = sizeof r->sii[i],
                                     .open_ports = open_ports,
                                     .keep_source_mac = keep_source_mac};
    memset(r->sii[i], 0, sizeof r->sii[i]);
    r->sii[i][0] = 0x05;
    ect_store_le16(r->sii[i] + 8, (uint16_t)(ALIAS + i));
    r->sii[i][14] = crc8(r->sii[i], 14);
    assert_int_equal(ect_esc_init(&r->esc[i], &config, 1000), 0);
    ect_store_le16(r->memory[i] + ECT_REG_STATION_ADDRESS, (uint16_t)(STATION + i));
}

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->personality = *ect_esc_personality("et1100");
    for (unsigned int i = 0; i < SLAVES; i++)
        init_slave(r, i, i + 1 < SLAVES ? 3 : 1, false);
    r->w.now_ns = 1000;
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    free(*state);
    return 0;
}

/* Through the first `count` slaves. */
static bool send_through(rig_t *r, unsigned int count)
{
    for (unsigned int i = 0; i < count; i++) {
        if (ect_esc_process(&r->esc[i], r->w.frame, r->w.frame_length, r->w.now_ns) != ECT_FRAME_FORWARD)
            return false;
    }
    return true;
}

/* To slave 0 in a buffer that ends with the frame, so that a sanitizer detects every access beyond it. */
static ect_frame_result_t send_exact(rig_t *r, size_t length)
{
    uint8_t *copy = malloc(length + 1);
    uint8_t *frame = copy + 1; /* odd alignment on purpose */
    memcpy(frame, r->w.frame, length);
    ect_frame_result_t result = ect_esc_process(&r->esc[0], frame, length, r->w.now_ns);
    memcpy(r->w.frame, frame, length);
    free(copy);
    return result;
}

/* The table of commands, transcribed from data sheet I tables 5 to 7. */
typedef struct command {
    uint8_t code;
    char addressing; /* P position, F station address, B all, - none */
    const char *hit; /* effect in the addressed slave: r, w or both */
    const char *miss;
    uint8_t adp_step;
} command_t;

static const command_t commands[] = {
    {NOP, '-', "", "", 0},   {APRD, 'P', "r", "", 1},  {APWR, 'P', "w", "", 1},  {APRW, 'P', "rw", "", 1},
    {FPRD, 'F', "r", "", 0}, {FPWR, 'F', "w", "", 0},  {FPRW, 'F', "rw", "", 0}, {BRD, 'B', "r", "", 1},
    {BWR, 'B', "w", "", 1},  {BRW, 'B', "rw", "", 1},  {LRD, '-', "", "", 0},    {LWR, '-', "", "", 0},
    {LRW, '-', "", "", 0},   {ARMW, 'P', "r", "w", 1}, {FRMW, 'F', "r", "w", 0},
};

typedef struct image {
    uint16_t adp;
    uint8_t data[3];
    uint16_t wkc;
    uint8_t memory[SLAVES][3];
} image_t;

static bool hits(const command_t *c, uint16_t adp, unsigned int slave, bool alias)
{
    if (c->addressing == 'P')
        return adp == 0;
    if (c->addressing == 'F')
        return adp == STATION + slave || (alias && adp == ALIAS + slave);
    return c->addressing == 'B';
}

/* The effect of the slaves on a datagram, according to the table. */
static void model(const command_t *c, bool alias, image_t *m)
{
    for (unsigned int s = 0; s < SLAVES; s++) {
        const char *action = hits(c, m->adp, s, alias) ? c->hit : c->miss;
        bool reads = strchr(action, 'r') != NULL;
        bool writes = strchr(action, 'w') != NULL;
        for (unsigned int i = 0; i < sizeof m->data; i++) {
            uint8_t before = m->data[i];
            if (reads)
                m->data[i] = c->addressing == 'B' ? m->data[i] | m->memory[s][i] : m->memory[s][i];
            if (writes)
                m->memory[s][i] = before;
        }
        m->wkc = (uint16_t)(m->wkc + (reads ? 1 : 0) + (writes ? (reads ? 2 : 1) : 0));
        m->adp = (uint16_t)(m->adp + c->adp_step);
    }
}

static void expect_image(rig_t *r, const char *what, uint8_t code, const image_t *want, uint16_t sent_adp)
{
    const uint8_t *d = wire_datagram(&r->w, 0);
    uint16_t adp = ect_load_le16(d + 2);
    uint16_t wkc = wire_wkc(&r->w, 0);
    if (adp != want->adp || wkc != want->wkc || memcmp(d + DATA, want->data, 3) != 0)
        fail_msg("%s: command %u, ADP 0x%04X: expected ADP 0x%04X, WKC 0x%04X, data %02X %02X %02X, "
                 "got ADP 0x%04X, WKC 0x%04X, data %02X %02X %02X",
                 what, code, sent_adp, want->adp, want->wkc, want->data[0], want->data[1], want->data[2], adp, wkc,
                 d[DATA], d[DATA + 1], d[DATA + 2]);
    if (d[0] != code || d[1] != 0x5A || ect_load_le16(d + 4) != USER || ect_load_le16(d + 6) != 3)
        fail_msg("%s: command %u: command, index, ADO or length were changed", what, code);
    for (unsigned int s = 0; s < SLAVES; s++) {
        if (memcmp(r->memory[s] + USER, want->memory[s], 3) != 0)
            fail_msg("%s: command %u, ADP 0x%04X: memory of slave %u differs from the table", what, code, sent_adp, s);
    }
}

static void one_command(rig_t *r, const char *what, const command_t *c, uint16_t adp, uint16_t wkc, bool alias)
{
    static const uint8_t sent[3] = {0x11, 0x80, 0xC3};
    static const uint8_t held[SLAVES][3] = {{0x21, 0x02, 0x00}, {0x44, 0x12, 0xFF}, {0x08, 0x61, 0x3C}};
    image_t m = {.adp = adp, .wkc = wkc};
    memcpy(m.data, sent, sizeof sent);
    memcpy(m.memory, held, sizeof held);
    for (unsigned int s = 0; s < SLAVES; s++) {
        memcpy(r->memory[s] + USER, held[s], 3);
        r->memory[s][ECT_REG_DL_CONTROL + 3] = alias ? 1 : 0;
    }
    wire_build(&r->w, c->code, adp, USER, sent, 3);
    wire_datagram(&r->w, 0)[1] = 0x5A;
    ect_store_le16(wire_datagram(&r->w, 0) + DATA + 3, wkc);
    assert_true(send_through(r, SLAVES));
    model(c, alias, &m);
    expect_image(r, what, c->code, &m, adp);
}

static const uint16_t adps[] = {0,           0xFFFF,      0xFFFE,      0xFFFD, 1,         STATION,   STATION + 1,
                                STATION + 2, STATION + 3, STATION - 1, ALIAS,  ALIAS + 1, ALIAS + 2, ALIAS + 3};

static void every_command_in_a_chain(void **state)
{
    rig_t *r = *state;
    for (size_t c = 0; c < sizeof commands / sizeof commands[0]; c++) {
        for (size_t a = 0; a < sizeof adps / sizeof adps[0]; a++) {
            one_command(r, "alias off", &commands[c], adps[a], 0, false);
            one_command(r, "alias on", &commands[c], adps[a], 5, true);
            one_command(r, "counter wraps", &commands[c], adps[a], 0xFFFF, true);
        }
    }
}

static void reserved_commands(void **state)
{
    rig_t *r = *state;
    for (unsigned int code = 15; code <= 255; code++) {
        const command_t c = {(uint8_t)code, '-', "", "", 0};
        for (size_t a = 0; a < sizeof adps / sizeof adps[0]; a++)
            one_command(r, "reserved", &c, adps[a], 3, true);
    }
}

static void address_zero(void **state)
{
    rig_t *r = *state;
    uint8_t data[1] = {0};
    for (unsigned int s = 0; s < SLAVES; s++) {
        ect_store_le16(r->memory[s] + ECT_REG_STATION_ADDRESS, s == 1 ? 0 : (uint16_t)(STATION + s));
        r->memory[s][USER] = (uint8_t)(0x10 + s);
    }
    wire_build(&r->w, FPRD, 0, USER, data, 1);
    assert_true(send_through(r, SLAVES));
    assert_int_equal(wire_wkc(&r->w, 0), 1);
    assert_int_equal(wire_datagram(&r->w, 0)[DATA], 0x11);
}

/* A read-write to an address where one half is not permitted. SM0 is a mailbox written by the master, SM1 one read by
 * it. */
static void halves(void **state)
{
    rig_t *r = *state;
    static const uint8_t sm[16] = {0, 0x10, 2, 0, 0x06, 0, 1, 0, 0x10, 0x10, 2, 0, 0x02, 0, 1, 0};
    static const uint8_t mail[2] = {0x77, 0x88};
    static const struct {
        const char *what;
        uint8_t command;
        uint16_t adp, ado;
        unsigned int wkc;
    } rows[] = {
        {"APRW of a read-only register reads", APRW, 0, ECT_REG_TYPE, 1},
        {"FPRW of a read-only register reads", FPRW, STATION, ECT_REG_TYPE, 1},
        {"BRW of a read-only register reads", BRW, 0, ECT_REG_TYPE, 1},
        {"APWR of a read-only register", APWR, 0, ECT_REG_TYPE, 0},
        {"FPWR of a read-only register", FPWR, STATION, ECT_REG_TYPE, 0},
        {"BWR of a read-only register", BWR, 0, ECT_REG_TYPE, 0},
        {"ARMW miss on a read-only register", ARMW, 1, ECT_REG_TYPE, 0},
        {"FRMW miss on a read-only register", FRMW, 1, ECT_REG_TYPE, 0},
        {"FPRW of an input mailbox that is full reads", FPRW, STATION, 0x1010, 1},
        {"FPRW of an input mailbox that is empty", FPRW, STATION, 0x1010, 0},
        {"FPRW of an output mailbox that is empty writes", FPRW, STATION, 0x1000, 2},
        {"FPRW of an output mailbox that is full", FPRW, STATION, 0x1000, 0},
        {"APRW of RAM beyond the end", APRW, 0, 0x3000, 0},
        {"BRW of the last byte of RAM and one more", BRW, 0, 0x2FFF, 3},
        {"FPRW of plain RAM", FPRW, STATION, 0x1100, 3},
    };
    wire_build(&r->w, FPWR, STATION, ECT_REG_SM, sm, sizeof sm);
    assert_true(send_through(r, 1));
    ect_esc_pdi_write(&r->esc[0], 0x1010, mail, sizeof mail);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_build(&r->w, rows[i].command, rows[i].adp, rows[i].ado, mail, sizeof mail);
        assert_true(send_through(r, 1));
        if (wire_wkc(&r->w, 0) != rows[i].wkc)
            fail_msg("%s: expected WKC %u, got %u", rows[i].what, rows[i].wkc, wire_wkc(&r->w, 0));
    }
}

static void read_write_offset(void **state)
{
    rig_t *r = *state;
    static const uint8_t codes[] = {APRW, FPRW, BRW, APWR, FPWR, BWR};
    for (size_t i = 0; i < sizeof codes; i++) {
        uint16_t adp = codes[i] == FPRW || codes[i] == FPWR ? STATION : 0;
        bool both = codes[i] == APRW || codes[i] == FPRW || codes[i] == BRW;
        uint8_t data[1] = {0xE0};
        r->memory[0][0x1100] = 0x07;
        r->memory[0][0x1110] = 0x55;
        ect_store_le16(r->memory[0] + ECT_REG_RW_OFFSET, 0x0010);
        wire_build(&r->w, codes[i], adp, 0x1100, data, 1);
        assert_true(send_through(r, 1));
        uint8_t read = codes[i] == BRW ? 0xE7 : 0x07;
        uint8_t here = both ? 0x07 : 0xE0;
        uint8_t there = both ? 0xE0 : 0x55;
        if (r->memory[0][0x1100] != here || r->memory[0][0x1110] != there ||
            (both && wire_datagram(&r->w, 0)[DATA] != read) || wire_wkc(&r->w, 0) != (both ? 3 : 1))
            fail_msg("command %u: the offset register 0x0108 moves the write of read-write commands only", codes[i]);
    }
}

static void features_without(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint16_t feature;
        uint8_t command;
        unsigned int wkc;
    } rows[] = {
        {0, APRW, 3},      {0, FPRW, 3},      {0, BRW, 3},       {0x0400, APRW, 0}, {0x0400, FPRW, 0}, {0x0400, BRW, 0},
        {0x0400, APRD, 1}, {0x0400, FPWR, 1}, {0x0400, BRD, 1},  {0x0400, ARMW, 1}, {0x0400, LRW, 3},  {0x0200, LRW, 0},
        {0x0200, LRD, 1},  {0x0200, LWR, 1},  {0x0200, APRW, 3}, {0, LRW, 3},
    };
    static const uint8_t fmmu[16] = {0, 0, 0, 0, 4, 0, 0, 7, 0x00, 0x11, 0, 3, 1, 0, 0, 0};
    wire_build(&r->w, APWR, 0, ECT_REG_FMMU, fmmu, sizeof fmmu);
    assert_true(send_through(r, 1));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[4] = {1, 2, 3, 4};
        uint8_t c = rows[i].command;
        bool logical = c >= LRD && c <= LRW;
        r->personality.features = rows[i].feature;
        memset(r->memory[0] + 0x1100, 0x99, 4);
        wire_build(&r->w, c, c == FPRW || c == FPWR ? STATION : 0, logical ? 0 : 0x1100, data, 4);
        assert_true(send_through(r, 1));
        bool untouched = memcmp(wire_datagram(&r->w, 0) + DATA, data, 4) == 0 && r->memory[0][0x1100] == 0x99;
        if (wire_wkc(&r->w, 0) != rows[i].wkc || untouched != (rows[i].wkc == 0))
            fail_msg("features 0x%04X, command %u: expected WKC %u, got %u", rows[i].feature, c, rows[i].wkc,
                     wire_wkc(&r->w, 0));
    }
}

/* Read, write, read again in one frame, for all numbers of datagrams that fit: each has its own result. */
static void many_datagrams(void **state)
{
    rig_t *r = *state;
    enum { MOST = 107 }; /* of 2 bytes: 14 + 2 + 107 * 14 = 1514 */
    for (unsigned int count = 1; count <= MOST; count++) {
        uint8_t zero[2] = {0};
        memset(r->memory[0] + 0x1100, 0, 2 * MOST);
        for (unsigned int i = 0; i < count; i++) {
            uint8_t data[2] = {(uint8_t)(i + 1), (uint8_t)(~i)};
            bool write = i % 2 == 0;
            uint16_t ado = (uint16_t)(0x1100 + i / 2 * 2);
            if (i == 0)
                wire_build(&r->w, APWR, 0, ado, data, 2);
            else
                wire_append(&r->w, write ? APWR : APRD, 0, ado, write ? data : zero, 2);
        }
        assert_true(r->w.frame_length <= 1514);
        assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
        for (unsigned int i = 0; i < count; i++) {
            const uint8_t *d = wire_datagram(&r->w, i) + DATA;
            unsigned int writer = i / 2 * 2;
            if (wire_wkc(&r->w, i) != 1 || d[0] != (uint8_t)(writer + 1) || d[1] != (uint8_t)(~writer))
                fail_msg("datagram %u of %u: expected WKC 1 and the data written before, got WKC %u, %02X %02X", i,
                         count, wire_wkc(&r->w, i), d[0], d[1]);
        }
    }
}

static void data_lengths(void **state)
{
    rig_t *r = *state;
    static const uint16_t lengths[] = {0, 1, 2, 3, 5, 7, 31, 32, 33, 255, 257, 1485, 1486, 1487, 1972};
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        uint16_t n = lengths[i];
        uint8_t data[2048];
        for (unsigned int k = 0; k < n; k++)
            data[k] = (uint8_t)(k * 7 + i);
        memset(r->memory[0] + 0x1000, 0xEE, 0x1000);
        wire_build(&r->w, FPWR, STATION, 0x1100, data, n);
        assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
        unsigned int want = n > 0 ? 1 : 0;
        bool stored = memcmp(r->memory[0] + 0x1100, data, n) == 0 && r->memory[0][0x10FF] == 0xEE &&
                      r->memory[0][0x1100 + n] == 0xEE;
        if (wire_wkc(&r->w, 0) != want || !stored)
            fail_msg("FPWR of %u bytes: WKC %u, stored exactly: %d", n, wire_wkc(&r->w, 0), stored);
        uint8_t zero[2048] = {0};
        wire_build(&r->w, BRD, 0, 0x1100, zero, n);
        assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
        if (wire_wkc(&r->w, 0) != want || memcmp(wire_datagram(&r->w, 0) + DATA, data, n) != 0)
            fail_msg("BRD of %u bytes: WKC %u", n, wire_wkc(&r->w, 0));
    }
}

/* Missing bytes do not change the frame's data. */
static void broadcast_beyond_the_end(void **state)
{
    static const uint8_t codes[] = {BRD, BRW};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof codes; i++) {
        memset(r->memory[0] + 0x1100, 0xFF, 4); /* the buffer holds previous data */
        wire_build(&r->w, BRD, 0, 0x1100, (uint8_t[4]){0}, 4);
        assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
        wire_build(&r->w, codes[i], 0, MEMORY - 2, (uint8_t[4]){0}, 4);
        assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
        assert_int_equal(wire_wkc(&r->w, 0), codes[i] == BRD ? 1 : 3);
        assert_memory_equal(wire_datagram(&r->w, 0) + DATA, "\0\0\0\0", 4);
    }
}

static void zero_length_commands(void **state)
{
    rig_t *r = *state;
    for (size_t c = 0; c < sizeof commands / sizeof commands[0]; c++) {
        wire_build(&r->w, commands[c].code, commands[c].addressing == 'F' ? STATION : 0, ECT_REG_AL_CONTROL, NULL, 0);
        assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
        assert_int_equal(wire_wkc(&r->w, 0), 0);
        if (ect_load_le16(wire_datagram(&r->w, 0) + 2) !=
            (commands[c].addressing == 'F' ? STATION : 0) + commands[c].adp_step)
            fail_msg("command %u of length 0: the address still counts its slaves", commands[c].code);
    }
}

/* APWR user RAM, BRD, APWR AL control: 3, 7 and 2 bytes. */
static void build_three(rig_t *r)
{
    static const uint8_t data[8] = {0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8};
    static const uint8_t request[2] = {0x02, 0};
    wire_build(&r->w, APWR, 0, USER, data, 3);
    wire_append(&r->w, BRD, 0, ECT_REG_TYPE, data, 7);
    wire_append(&r->w, APWR, 0, ECT_REG_AL_CONTROL, request, 2);
}

/* Only the two counters may have changed. */
static void expect_refused(rig_t *r, const char *what, unsigned int number, ect_frame_result_t got, unsigned int rx,
                           const uint8_t *before)
{
    uint8_t want[MEMORY];
    memcpy(want, before, MEMORY);
    want[ECT_REG_RX_ERROR] = (uint8_t)(want[ECT_REG_RX_ERROR] + rx);
    want[ECT_REG_PROCESSING_ERROR]++;
    if (got != ECT_FRAME_DESTROYED)
        fail_msg("%s %u: was answered", what, number);
    for (unsigned int i = 0; i < MEMORY; i++) {
        if (want[i] != r->memory[0][i])
            fail_msg("%s %u: address 0x%04X expected 0x%02X, got 0x%02X", what, number, i, want[i], r->memory[0][i]);
    }
    memcpy(r->memory[0], before, MEMORY);
}

static void truncated(void **state)
{
    rig_t *r = *state;
    uint8_t before[MEMORY];
    memcpy(before, r->memory[0], MEMORY);
    build_three(r);
    size_t whole = r->w.frame_length;
    for (size_t length = 0; length < whole; length++) {
        build_three(r);
        uint8_t sent[64];
        memcpy(sent, r->w.frame, sizeof sent);
        ect_frame_result_t result = send_exact(r, length);
        expect_refused(r, "frame cut to length", (unsigned int)length, result, 1, before);
        if (memcmp(sent, r->w.frame, length < sizeof sent ? length : sizeof sent) != 0)
            fail_msg("frame cut to %zu: was changed", length);
    }
    build_three(r);
    assert_int_equal(send_exact(r, whole), ECT_FRAME_FORWARD);
    assert_int_equal(wire_wkc(&r->w, 0) + wire_wkc(&r->w, 1) + wire_wkc(&r->w, 2), 3);
}

/* Bytes behind the end of a frame are never read. */
static void nothing_behind_the_end(void **state)
{
    static const struct {
        size_t length;
        uint8_t ethertype[2];
        unsigned int rx; /* counts in 0x0300: truncated EtherCAT */
        uint8_t type;    /* EtherCAT type */
    } rows[] = {{14, {0x88, 0xA4}, 1, 0},    {15, {0x88, 0xA4}, 1, 0}, {16, {0x88, 0xA4}, 1, 0x10},
                {16, {0x88, 0xA4}, 0, 0x40}, {13, {0x08, 0x06}, 1, 0}, {14, {0x08, 0x06}, 0, 0},
                {15, {0x08, 0x06}, 0, 0},    {60, {0x08, 0x06}, 0, 0}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[64] = {0};
        memcpy(frame + 12, rows[i].ethertype, 2);
        frame[1] = 0x10; /* address type: no header */
        frame[15] = rows[i].type;
        r->memory[0][0x0300] = r->memory[0][0x030C] = 0;
        assert_int_equal(ect_esc_process(&r->esc[0], frame, rows[i].length, r->w.now_ns), ECT_FRAME_DESTROYED);
        if (r->memory[0][0x0300] != rows[i].rx || r->memory[0][0x030C] != 1)
            fail_msg("%zu bytes, EtherType 0x%02X%02X: expected 0x0300 %u, 0x030C 1, got %u, %u", rows[i].length,
                     rows[i].ethertype[0], rows[i].ethertype[1], rows[i].rx, r->memory[0][0x0300],
                     r->memory[0][0x030C]);
    }
}

static void insert(rig_t *r, const uint8_t *bytes, size_t count)
{
    memmove(r->w.frame + 12 + count, r->w.frame + 12, r->w.frame_length - 12);
    memcpy(r->w.frame + 12, bytes, count);
    r->w.frame_length += count;
}

static void build_udp(rig_t *r)
{
    static const uint8_t headers[30] = {0x08, 0x00, 0x45, 0x00, 0x00, 0x40, 0x12, 0x34, 0x00, 0x00,
                                        0x40, 0x11, 0xBE, 0xEF, 10,   0,    0,    1,    10,   0,
                                        0,    2,    0x12, 0x34, 0x88, 0xA4, 0x00, 0x2C, 0xCA, 0xFE};
    build_three(r);
    r->w.frame_length -= 2;
    memmove(r->w.frame + 12, r->w.frame + 14, r->w.frame_length - 12);
    insert(r, headers, sizeof headers);
}

/* Properties of a frame for code that parses it once (esc/route.h). */
static void starts_of_datagrams(void **state)
{
    static const struct {
        const char *what;
        size_t length; /* 0: as built */
        unsigned int at, value;
        size_t want;
    } rows[] = {{"a frame", 0, 0, 0xFF, 16},
                {"no EtherCAT", 0, 13, 0xA5, 0},
                {"another type", 0, 15, 0x40, 0},
                {"no room for it", 15, 0, 0, 0},
                {"cut", 40, 0, 0, 0},
                {"no header", 13, 0, 0, 0},
                {"the longest", 2000, 0, 0, 16},
                {"too long", 2001, 0, 0, 0},
                {"in UDP", 0, 13, 0, 0},
                {"in UDP without a check sum", 0, 41, 0, 44}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static uint8_t around[4096];
        uint8_t *frame = around + 1024;
        memset(around, 0, sizeof around);
        build_three(r);
        if (strncmp(rows[i].what, "in UDP", 6) == 0)
            build_udp(r);
        memcpy(frame, r->w.frame, r->w.frame_length);
        frame[1] = 0x10; /* address type: no header */
        if (rows[i].want == 44)
            frame[40] = 0;
        frame[rows[i].at] = (uint8_t)rows[i].value;
        size_t got = ect_frame_datagrams(frame, rows[i].length != 0 ? rows[i].length : r->w.frame_length);
        if (got != rows[i].want)
            fail_msg("%s: expected the datagrams at %zu, got %zu", rows[i].what, rows[i].want, got);
    }
}

static void false_lengths(void **state)
{
    rig_t *r = *state;
    uint8_t before[MEMORY];
    memcpy(before, r->memory[0], MEMORY);
    static const struct {
        unsigned int datagram;
        uint16_t length; /* with the M bit */
    } rows[] = {{2, 3}, {2, 0x7FF}, {2, 0x8002}, {1, 0x87FF}, {0, 0x8000 + 0x7FF}, {1, 0x8000 + 200}, {0, 0x0400}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        build_three(r);
        ect_store_le16(wire_datagram(&r->w, rows[i].datagram) + 6, rows[i].length);
        ect_frame_result_t result = send_exact(r, r->w.frame_length);
        expect_refused(r, "row", (unsigned int)i, result, 1, before);
    }
    /* The length in the EtherCAT header is ignored. */
    for (unsigned int length = 0; length <= 0x7FF; length += 0x7F) {
        build_three(r);
        ect_store_le16(r->w.frame + 14, (uint16_t)(0x1000 | length));
        r->memory[0][USER] = 0;
        ect_frame_result_t result = send_exact(r, r->w.frame_length);
        if (result != ECT_FRAME_FORWARD || r->memory[0][USER] != 0xA1)
            fail_msg("header length %u: the datagrams count, not the header", length);
    }
}

static void longest_frame(void **state)
{
    rig_t *r = *state;
    uint8_t before[MEMORY];
    for (size_t length = 1999; length <= 2002; length++) {
        build_three(r);
        memset(r->w.frame + r->w.frame_length, 0x5C, sizeof r->w.frame - r->w.frame_length);
        memcpy(before, r->memory[0], MEMORY);
        ect_frame_result_t result = send_exact(r, length);
        if (length > 2000)
            expect_refused(r, "length", (unsigned int)length, result, 1, before);
        else
            assert_int_equal(result, ECT_FRAME_FORWARD);
    }
}

static void padding(void **state)
{
    rig_t *r = *state;
    for (size_t pad = 0; pad < 64; pad++) {
        build_three(r);
        memset(r->w.frame + r->w.frame_length, 0x5C, pad);
        assert_int_equal(send_exact(r, r->w.frame_length + pad), ECT_FRAME_FORWARD);
        for (size_t i = 0; i < pad; i++)
            assert_int_equal(r->w.frame[r->w.frame_length + i], 0x5C);
        assert_int_equal(wire_wkc(&r->w, 1), 1);
    }
}

static void not_ethercat(void **state)
{
    rig_t *r = *state;
    uint8_t before[MEMORY];
    static const struct {
        size_t at;
        uint8_t value;
    } rows[] = {{12, 0x08}, {12, 0x89}, {13, 0xA5}, {13, 0xA3}, {12, 0x00}, {15, 0x00},
                {15, 0x20}, {15, 0x40}, {15, 0x50}, {15, 0x80}, {15, 0xF0}, {15, 0x30}};
    for (unsigned int keep = 0; keep < 2; keep++) {
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            r->memory[0][ECT_REG_DL_CONTROL] = keep == 0 ? 1 : 0;
            memcpy(before, r->memory[0], MEMORY);
            build_three(r);
            r->w.frame[rows[i].at] = rows[i].value;
            uint8_t sent[128];
            memcpy(sent, r->w.frame, r->w.frame_length);
            ect_frame_result_t result = send_exact(r, r->w.frame_length);
            if (keep == 0)
                expect_refused(r, "row", (unsigned int)i, result, 0, before);
            else if (result != ECT_FRAME_FORWARD || memcmp(sent, r->w.frame, r->w.frame_length) != 0 ||
                     memcmp(before, r->memory[0], MEMORY) != 0)
                fail_msg("row %zu: with DL control bit 0 clear it is forwarded untouched and not counted", i);
        }
    }
}

static const uint8_t vlan[4] = {0x81, 0x00, 0x60, 0x05};

static void vlan_tag(void **state)
{
    rig_t *r = *state;
    build_three(r);
    insert(r, vlan, 4);
    assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
    assert_memory_equal(r->w.frame + 12, vlan, 4);
    assert_memory_equal(r->memory[0] + USER, "\xA1\xA2\xA3", 3);
    size_t whole = r->w.frame_length;
    for (size_t length = 14; length < whole; length++) {
        init_slave(r, 0, 1, false);
        build_three(r);
        insert(r, vlan, 4);
        if (send_exact(r, length) != ECT_FRAME_DESTROYED || r->memory[0][ECT_REG_PROCESSING_ERROR] != 1)
            fail_msg("tagged frame cut to %zu: expected no reply and the counter 0x030C at 1", length);
        assert_int_equal(r->memory[0][USER], 0);
    }
}

/* With IPv4 and UDP headers in front: the EtherType of the frame becomes 0x0800. */
static void udp(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        size_t at;
        uint8_t value;
        bool accepted;
    } rows[] = {
        {"as it should be", 14, 0x45, true},
        {"IP version 6", 14, 0x65, false},
        {"IHL 6", 14, 0x46, false},
        {"IHL 4", 14, 0x44, false},
        {"TCP", 23, 0x06, false},
        {"destination port high", 36, 0x89, false},
        {"destination port low", 37, 0xA5, false},
        {"EtherType low", 13, 0x06, false},
        {"source port", 34, 0x77, true},
        {"TTL 1", 22, 1, true},
        {"IP checksum", 24, 0, true},
        {"IP length", 16, 0xFF, true},
        {"type of service", 15, 0x10, true},
        {"destination address", 30, 224, true},
        {"UDP length", 38, 0xFF, true},
        {"header type 4", 43, 0x40, false},
    };
    for (unsigned int tagged = 0; tagged < 2; tagged++) {
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            init_slave(r, 0, 1, false);
            build_udp(r);
            r->w.frame[rows[i].at] = rows[i].value;
            if (tagged != 0)
                insert(r, vlan, 4);
            size_t at = tagged != 0 ? 4 : 0;
            bool answered = send_exact(r, r->w.frame_length) == ECT_FRAME_FORWARD;
            bool stored = r->memory[0][USER] == 0xA1;
            if (answered != rows[i].accepted || stored != rows[i].accepted)
                fail_msg("UDP, %s, tagged %u: answered %d, executed %d", rows[i].what, tagged, answered, stored);
            if (answered && (r->w.frame[40 + at] != 0 || r->w.frame[41 + at] != 0))
                fail_msg("UDP, %s: the check sum is to be cleared", rows[i].what);
            assert_int_equal(r->memory[0][ECT_REG_PROCESSING_ERROR], answered ? 0 : 1);
        }
    }
}

static void udp_truncated(void **state)
{
    rig_t *r = *state;
    build_udp(r);
    size_t whole = r->w.frame_length;
    for (size_t length = 14; length < whole; length++) {
        init_slave(r, 0, 1, false);
        build_udp(r);
        bool answered = send_exact(r, length) == ECT_FRAME_FORWARD;
        if (answered || r->memory[0][USER] != 0 || r->memory[0][ECT_REG_PROCESSING_ERROR] != 1)
            fail_msg("UDP frame cut to %zu: expected no reply and the counter 0x030C at 1", length);
    }
}

static void udp_forwarded(void **state)
{
    rig_t *r = *state;
    r->memory[0][ECT_REG_DL_CONTROL] = 0;
    build_udp(r);
    r->w.frame[43] = 0x40; /* network variables: not EtherCAT for an ESC */
    uint8_t sent[160];
    memcpy(sent, r->w.frame, r->w.frame_length);
    assert_int_equal(send_exact(r, r->w.frame_length), ECT_FRAME_FORWARD);
    if (memcmp(sent, r->w.frame, r->w.frame_length) != 0)
        fail_msg("UDP frame of header type 4, DL control bit 0 clear: expected untouched, check sum sent %02X%02X, "
                 "came %02X%02X",
                 sent[40], sent[41], r->w.frame[40], r->w.frame[41]);
}

static void source_mac(void **state)
{
    rig_t *r = *state;
    for (unsigned int variant = 0; variant < 4; variant++) {
        bool keep = (variant & 1) != 0;
        bool rule = (variant & 2) != 0;
        init_slave(r, 0, 1, keep);
        r->memory[0][ECT_REG_DL_CONTROL] = rule ? 1 : 0;
        for (unsigned int octet = 0; octet < 256; octet++) {
            build_three(r);
            r->w.frame[6] = (uint8_t)octet;
            uint8_t mac[12];
            memcpy(mac, r->w.frame, sizeof mac);
            if (rule && !keep)
                mac[6] |= 0x02;
            assert_true(send_through(r, 1));
            if (memcmp(mac, r->w.frame, sizeof mac) != 0)
                fail_msg("first octet 0x%02X, keep %d, DL control bit 0 %d: expected 0x%02X, got 0x%02X", octet, keep,
                         rule, mac[6], r->w.frame[6]);
        }
    }
}

/* Slave 0 has events 0x000C with mask 0x0004, slave 1 0x0030 with 0xFFFF, slave 2 0x0FFF with 0. */
static void irq_field(void **state)
{
    rig_t *r = *state;
    static const uint16_t masks[SLAVES] = {0x0004, 0xFFFF, 0x0000};
    static const uint16_t events[SLAVES] = {0x000C, 0x0030, 0x0FFF};
    for (unsigned int s = 0; s < SLAVES; s++) {
        ect_store_le16(r->memory[s] + ECT_REG_ECAT_EVENT_MASK, masks[s]);
        ect_store_le16(r->memory[s] + ECT_REG_ECAT_EVENT, events[s]);
    }
    for (size_t c = 0; c < sizeof commands / sizeof commands[0]; c++) {
        uint8_t data[2] = {0};
        wire_build(&r->w, NOP, 0, 0, data, 0);
        wire_append(&r->w, commands[c].code, 0x7000, USER, data, 2);
        ect_store_le16(wire_datagram(&r->w, 0) + 8, 0x8000);
        assert_true(send_through(r, SLAVES));
        uint16_t first = ect_load_le16(wire_datagram(&r->w, 0) + 8);
        uint16_t second = ect_load_le16(wire_datagram(&r->w, 1) + 8);
        if (first != 0x8034 || second != 0x0034)
            fail_msg("command %u: expected IRQ fields 0x8034 0x0034, got 0x%04X 0x%04X", commands[c].code, first,
                     second);
        for (unsigned int s = 0; s < SLAVES; s++)
            assert_int_equal(ect_load_le16(r->memory[s] + ECT_REG_ECAT_EVENT), events[s]);
    }
}

static void counters_saturate(void **state)
{
    rig_t *r = *state;
    for (unsigned int i = 1; i <= 300; i++) {
        build_three(r);
        assert_int_equal(send_exact(r, 40), ECT_FRAME_DESTROYED);
        unsigned int want = i < 255 ? i : 255;
        if (r->memory[0][ECT_REG_RX_ERROR] != want || r->memory[0][ECT_REG_PROCESSING_ERROR] != want)
            fail_msg("after %u broken frames: expected %u, got 0x0300 %u, 0x030C %u", i, want,
                     r->memory[0][ECT_REG_RX_ERROR], r->memory[0][ECT_REG_PROCESSING_ERROR]);
    }
}

static void chain_positions(void **state)
{
    (void)state;
    const ect_device_t *devices[] = {&testdev, &testdev, &testdev};
    wire_t w;
    wire_open(&w, devices, 3);
    uint8_t data[2] = {0};
    assert_int_equal(wire_send(&w, BRD, 0, ECT_REG_TYPE, data, 2), 3);
    assert_int_equal(ect_load_le16(wire_datagram(&w, 0) + 2), 3);
    for (unsigned int i = 0; i < 5; i++) {
        uint8_t station[2] = {0};
        int want = i < 3 ? 1 : 0;
        int wkc = wire_send(&w, APRD, (uint16_t)(0 - i), ECT_REG_STATION_ADDRESS, station, 2);
        unsigned int address = i < 3 ? WIRE_STATION + i : 0;
        uint16_t adp = ect_load_le16(wire_datagram(&w, 0) + 2);
        if (wkc != want || ect_load_le16(station) != address || adp != (uint16_t)(3 - i))
            fail_msg("APRD to -%u: expected WKC %d, station 0x%04X, got %d, 0x%04X", i, want, address, wkc,
                     ect_load_le16(station));
    }
    w.frame_length = 20;
    assert_false(wire_transmit(&w));
    wire_close(&w);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-002 CF-003 CF-004 CF-005 CF-006 CF-007: every command on three slaves, addressed or not: ADP, data, "
             "memory and WKC follow the table of commands, the WKC wraps",
             every_command_in_a_chain),
        TEST("CF-007: reserved commands 15..255 change nothing", reserved_commands),
        TEST("CF-004: a slave whose station address is 0 replies to FPRD to address 0", address_zero),
        TEST("CF-005: a forbidden half of a read-write adds nothing", halves),
        TEST("CF-005: register 0x0108 offsets the write of read-write commands only", read_write_offset),
        TEST("CF-005: feature bits 9 and 10 disable LRW and the read-write commands", features_without),
        TEST("CF-013: 1..107 datagrams in a frame are each processed, in order", many_datagrams),
        TEST("CF-013: data of 0, 1, odd and the greatest length are read and written exactly", data_lengths),
        TEST("CF-006 CF-008: a broadcast read does not change missing bytes", broadcast_beyond_the_end),
        TEST("CF-013: a datagram of length 0 does nothing, WKC 0, the ADP still counts slaves", zero_length_commands),
        TEST("CF-013: a frame truncated anywhere gets no reply, has no effect, counts in 0x0300 and 0x030C", truncated),
        TEST("CF-013: a frame ends at its end, whatever follows it", nothing_behind_the_end),
        TEST("CF-013: the first datagram of a frame is found; some frames have none", starts_of_datagrams),
        TEST("CF-013: datagram lengths that do not fit are refused; the header's length is ignored", false_lengths),
        TEST("CF-013: a frame of 2000 bytes is accepted, a longer one is invalid", longest_frame),
        TEST("CF-013: padding behind the last datagram is not changed", padding),
        TEST("CF-013: wrong EtherType or header type: destroyed and counted in 0x030C, or forwarded untouched when DL "
             "control bit 0 is clear",
             not_ethercat),
        TEST("CF-013: a VLAN tag is passed unmodified; a truncated tagged frame is refused", vlan_tag),
        TEST("CF-013: EtherCAT in UDP is detected only by version, IHL, protocol and port; its check sum is cleared",
             udp),
        TEST("CF-013: a truncated UDP frame is refused", udp_truncated),
        TEST("CF-013: a UDP frame that is not for an ESC is forwarded with its check sum when DL control bit 0 is "
             "clear",
             udp_forwarded),
        TEST("CF-013: bit 1 of the source address is set, all other bits are kept; not with keep_source_mac or DL "
             "control bit 0 "
             "clear",
             source_mac),
        TEST("CF-013: the IRQ field of every datagram gathers the masked events of all slaves", irq_field),
        TEST("CF-011: the counters of broken frames stop at 255", counters_saturate),
        TEST("CF-002 CF-003: positions 0, -1, -2 reach the three twins, -3 none; BRD counts all", chain_positions),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC datagrams", tests, NULL, NULL);
}
