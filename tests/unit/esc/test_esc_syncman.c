/* SPDX-License-Identifier: MIT */
/* SyncManagers: access of both sides to the buffers, in any number of accesses, and the effect on the other side (data
 * sheet I section 8). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "support/wire.h"

enum { RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, DATA = 10, START = 0x1000 };
enum { OUT_MAILBOX = 0x36, IN_MAILBOX = 0x32, OUT_BUFFERED = 0x34, IN_BUFFERED = 0x30 };

typedef struct rig {
    ect_esc_personality_t personality;
    uint8_t *memory; /* in its own allocation, so that a sanitizer detects its end */
    uint8_t sii[16];
    ect_esc_t esc;
    wire_t w;
    uint32_t random;
} rig_t;

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->personality = *ect_esc_personality("et1100");
    r->memory = malloc(MEMORY);
    ect_store_le16(r->sii + 14, 0x88A4); /* check value disabled */
    const ect_esc_config_t config = {
        .personality = &r->personality, .memory = r->memory, .sii = r->sii, .sii_size = sizeof r->sii, .open_ports = 1};
    r->w.now_ns = 1000;
    r->random = 0x12345678;
    assert_int_equal(ect_esc_init(&r->esc, &config, r->w.now_ns), 0);
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    free(r->memory);
    free(r);
    return 0;
}

static void process(rig_t *r)
{
    assert_int_equal(ect_esc_process(&r->esc, r->w.frame, r->w.frame_length, r->w.now_ns), ECT_FRAME_FORWARD);
}

static unsigned int send(rig_t *r, uint8_t command, uint16_t ado, void *data, uint16_t length)
{
    wire_build(&r->w, command, 0, ado, data, length);
    process(r);
    memcpy(data, wire_datagram(&r->w, 0) + DATA, length);
    return wire_wkc(&r->w, 0);
}

static unsigned int ecat_write(rig_t *r, uint16_t ado, uint8_t value)
{
    return send(r, APWR, ado, &value, 1);
}

static void pdi_write(rig_t *r, uint16_t address, uint8_t value)
{
    assert_int_equal(ect_esc_pdi_write(&r->esc, address, &value, 1), 0);
}

static uint8_t status_of(const rig_t *r, unsigned int n)
{
    return r->memory[0x0805 + 8 * n];
}

static void set_sm(rig_t *r, unsigned int n, uint16_t start, uint16_t length, uint8_t control)
{
    uint8_t block[8] = {0};
    assert_int_equal(ecat_write(r, (uint16_t)(0x0806 + 8 * n), 0), 1);
    ect_store_le16(block, start);
    ect_store_le16(block + 2, length);
    block[4] = control;
    block[6] = 1;
    assert_int_equal(send(r, APWR, (uint16_t)(0x0800 + 8 * n), block, 8), 1);
}

/* A step of a script: the side (E ECAT, P PDI), read or write, and the expected result. */
typedef struct step {
    char side, access;
    int offset;
    uint16_t length;
    unsigned int wkc; /* for the PDI: data were transferred */
    uint8_t status;   /* of SM0 afterwards */
} step_t;

static void play(rig_t *r, const char *title, const step_t *steps, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const step_t *s = &steps[i];
        uint8_t data[64];
        uint16_t address = (uint16_t)(START + s->offset);
        memset(data, s->access == 'w' ? 0x40 + (int)i : 0xEE, sizeof data);
        unsigned int wkc = s->wkc;
        if (s->side == 'E') {
            wkc = send(r, s->access == 'w' ? APWR : APRD, address, data, s->length);
            if (s->access == 'r' && (data[0] == 0xEE) == (wkc == 1))
                fail_msg("%s, step %zu: data do not go with WKC %u", title, i, wkc);
        } else if (s->access == 'w') {
            ect_esc_pdi_write(&r->esc, address, data, s->length);
        } else {
            ect_esc_pdi_read(&r->esc, address, data, s->length);
            wkc = data[0] != 0;
        }
        if (wkc != s->wkc || status_of(r, 0) != s->status)
            fail_msg("%s, step %zu (%c %c, bytes %d..%d): expected %u, status 0x%02X, got %u, 0x%02X", title, i,
                     s->side, s->access, s->offset, s->offset + s->length - 1, s->wkc, s->status, wkc, status_of(r, 0));
    }
}

#define PLAY(r, title, steps) play(r, title, steps, sizeof(steps) / sizeof((steps)[0]))

static void mailbox_out(void **state)
{
    rig_t *r = *state;
    static const step_t steps[] = {
        {'E', 'r', 0, 8, 0, 0x00}, {'P', 'r', 0, 8, 0, 0x00}, {'P', 'w', 0, 8, 0, 0x00},  {'E', 'w', 1, 7, 0, 0x00},
        {'E', 'w', 7, 1, 0, 0x00}, {'E', 'w', 0, 1, 1, 0x80}, {'P', 'r', 0, 8, 0, 0x80},  {'E', 'w', 2, 3, 1, 0x80},
        {'E', 'w', 1, 6, 1, 0x80}, {'E', 'w', 7, 1, 1, 0x09}, {'E', 'w', 0, 8, 0, 0x09},  {'E', 'w', 3, 2, 0, 0x09},
        {'E', 'w', 7, 1, 0, 0x09}, {'E', 'r', 0, 8, 0, 0x09}, {'P', 'r', 1, 7, 0, 0x09},  {'P', 'r', 7, 1, 0, 0x09},
        {'P', 'r', 0, 1, 1, 0x48}, {'E', 'w', 0, 8, 0, 0x48}, {'P', 'r', 3, 2, 1, 0x48},  {'P', 'r', 0, 7, 1, 0x48},
        {'P', 'r', 7, 1, 1, 0x02}, {'P', 'r', 0, 8, 0, 0x02}, {'P', 'r', 7, 1, 0, 0x02},  {'E', 'w', 0, 8, 1, 0x09},
        {'P', 'r', 0, 8, 1, 0x02}, {'E', 'w', 0, 7, 1, 0x80}, {'E', 'w', 0, 7, 1, 0x80},  {'E', 'w', 6, 2, 1, 0x09},
        {'P', 'r', 0, 7, 1, 0x48}, {'P', 'r', 0, 8, 1, 0x02}, {'E', 'w', 0, 16, 1, 0x09}, {'P', 'r', 0, 16, 1, 0x02},
    };
    set_sm(r, 0, START, 8, OUT_MAILBOX);
    assert_int_equal(status_of(r, 0), 0x00);
    PLAY(r, "mailbox out", steps);
    assert_int_equal(r->memory[START + 8], 0x40 + 30); /* bytes behind the mailbox went to plain memory */
}

static void mailbox_in(void **state)
{
    rig_t *r = *state;
    static const step_t steps[] = {
        {'E', 'w', 0, 8, 0, 0x00}, {'E', 'r', 0, 8, 0, 0x00}, {'P', 'r', 0, 8, 0, 0x00}, {'P', 'w', 1, 7, 0, 0x00},
        {'P', 'w', 0, 1, 1, 0x80}, {'E', 'r', 0, 8, 0, 0x80}, {'P', 'w', 1, 6, 1, 0x80}, {'P', 'w', 7, 1, 1, 0x09},
        {'P', 'w', 0, 8, 0, 0x09}, {'E', 'r', 1, 7, 0, 0x09}, {'E', 'r', 7, 1, 0, 0x09}, {'E', 'r', 0, 2, 1, 0x48},
        {'P', 'w', 0, 8, 0, 0x48}, {'E', 'r', 0, 2, 1, 0x48}, {'E', 'r', 4, 1, 1, 0x48}, {'E', 'r', 7, 1, 1, 0x02},
        {'E', 'r', 7, 1, 0, 0x02}, {'E', 'r', 0, 8, 0, 0x02}, {'P', 'w', 0, 8, 1, 0x09}, {'E', 'r', 0, 8, 1, 0x02},
        {'P', 'w', 0, 8, 1, 0x09}, {'E', 'r', 0, 7, 1, 0x48}, {'E', 'r', 0, 8, 1, 0x02},
    };
    set_sm(r, 0, START, 8, IN_MAILBOX);
    PLAY(r, "mailbox in", steps);
}

static void buffered_out(void **state)
{
    rig_t *r = *state;
    static const step_t before[] = {
        {'P', 'r', 0, 8, 0, 0x30}, {'E', 'r', 0, 8, 0, 0x30}, {'E', 'w', 1, 7, 0, 0x30}, {'E', 'w', 7, 1, 0, 0x30},
        {'P', 'w', 0, 8, 0, 0x30}, {'E', 'w', 0, 7, 1, 0xB0}, {'P', 'r', 0, 8, 0, 0xB0},
    };
    set_sm(r, 0, START, 8, OUT_BUFFERED);
    assert_int_equal(status_of(r, 0), 0x30);
    PLAY(r, "buffered out, nothing complete", before);
    for (unsigned int i = 0; i < 20; i++) {
        uint8_t data[8];
        memset(data, 0x10 + (int)i, sizeof data);
        uint8_t last = status_of(r, 0) & 0x30;
        assert_int_equal(send(r, APWR, START, data, 8), 1);
        uint8_t status = status_of(r, 0);
        if ((status & 0x8F) != 0x01 || (status & 0x30) == 0x30 || (status & 0x30) == last)
            fail_msg("write %u: expected another buffer and bit 0 set, status 0x%02X after buffer 0x%02X", i, status,
                     last);
        if (i % 3 != 0) {
            memset(data, 0, sizeof data);
            ect_esc_pdi_read(&r->esc, START, data, 8);
            assert_int_equal(data[0], 0x10 + i);
            assert_int_equal(data[7], 0x10 + i);
            assert_int_equal(status_of(r, 0) & 0xCF, 0x02);
            assert_int_equal(status_of(r, 0) & 0x30, status & 0x30);
        }
    }
}

static void buffered_in(void **state)
{
    rig_t *r = *state;
    uint8_t data[8] = {0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE};
    set_sm(r, 0, START, 8, IN_BUFFERED);
    assert_int_equal(send(r, APRD, START, data, 8), 0);
    assert_int_equal(data[0], 0xEE);
    ect_esc_pdi_write(&r->esc, START, "ABCDEFGH", 8);
    for (unsigned int i = 0; i < 3; i++) { /* the previous buffer can be read repeatedly */
        memset(data, 0xEE, sizeof data);
        assert_int_equal(send(r, APRD, START, data, 8), 1);
        assert_memory_equal(data, "ABCDEFGH", 8);
    }
    assert_int_equal(send(r, APWR, START, data, 8), 0);
    ect_esc_pdi_write(&r->esc, START, "abcdefgh", 7);
    assert_int_equal(send(r, APRD, START, data, 8), 1);
    assert_memory_equal(data, "ABCDEFGH", 8);
    ect_esc_pdi_write(&r->esc, START + 7, "h", 1);
    assert_int_equal(send(r, APRD, START, data, 4), 1);
    assert_memory_equal(data, "abcd", 4);
    for (unsigned int i = 0; i < 5; i++) /* the reader keeps its buffer during further writes */
        ect_esc_pdi_write(&r->esc, START, "12345678", 8);
    assert_int_equal(send(r, APRD, START + 4, data, 4), 1);
    assert_memory_equal(data, "efgh", 4);
    assert_int_equal(send(r, APRD, START + 4, data, 4), 0);
    assert_int_equal(send(r, APRD, START, data, 8), 1);
    assert_memory_equal(data, "12345678", 8);
}

/* TwinCAT: the mail and its last byte in two datagrams of one frame; 2 bytes as a poll, the rest in a later frame. */
static void twincat_accesses(void **state)
{
    rig_t *r = *state;
    uint8_t mail[10] = {4, 0, 0, 0, 0, 0x13, 1, 2, 3, 4}, got[64] = {0}, zero[2] = {0};
    set_sm(r, 0, START, 64, OUT_MAILBOX);
    set_sm(r, 1, START + 64, 64, IN_MAILBOX);
    wire_build(&r->w, APWR, 0, START, mail, sizeof mail);
    wire_append(&r->w, APWR, 0, START + 63, zero, 1);
    process(r);
    assert_int_equal(wire_wkc(&r->w, 0), 1);
    assert_int_equal(wire_wkc(&r->w, 1), 1);
    assert_int_equal(status_of(r, 0), 0x09);
    ect_esc_pdi_read(&r->esc, START, got, 64);
    assert_memory_equal(got, mail, sizeof mail);
    assert_int_equal(send(r, APRD, START + 64, zero, 2), 0);
    uint8_t answer[64];
    for (unsigned int i = 0; i < 64; i++)
        answer[i] = (uint8_t)(0x80 + i);
    ect_esc_pdi_write(&r->esc, START + 64, answer, 64);
    for (unsigned int i = 0; i < 3; i++) {
        assert_int_equal(send(r, APRD, START + 64, zero, 2), 1);
        assert_memory_equal(zero, answer, 2);
        assert_int_equal(status_of(r, 1) & ECT_SM_STATUS_FULL, ECT_SM_STATUS_FULL);
    }
    memset(got, 0, sizeof got);
    wire_build(&r->w, APRD, 0, START + 64, got, 20);
    wire_append(&r->w, APRD, 0, START + 127, got, 1);
    process(r);
    assert_int_equal(wire_wkc(&r->w, 0), 1);
    assert_int_equal(wire_wkc(&r->w, 1), 1);
    assert_memory_equal(wire_datagram(&r->w, 0) + DATA, answer, 20);
    assert_int_equal(wire_datagram(&r->w, 1)[DATA], answer[63]);
    assert_int_equal(status_of(r, 1), 0x02);
}

static void rewrite_of_the_block(void **state)
{
    rig_t *r = *state;
    static const uint8_t controls[] = {IN_MAILBOX, OUT_MAILBOX, IN_BUFFERED, OUT_BUFFERED};
    for (size_t i = 0; i < sizeof controls; i++) {
        bool in = (controls[i] & 0x04) == 0;
        uint8_t data[8] = {1, 2, 3, 4, 5, 6, 7, 8}, block[8];
        set_sm(r, 0, START, 8, controls[i]);
        if (in)
            ect_esc_pdi_write(&r->esc, START, data, 8);
        else
            send(r, APWR, START, data, 8);
        uint8_t before = status_of(r, 0);
        memcpy(block, r->memory + 0x0800, 8);
        static const uint8_t statuses[] = {0x00, 0x30, 0xFF};
        for (size_t k = 0; k < sizeof statuses; k++) {
            block[5] = statuses[k];
            block[7] = 0xFF;
            assert_int_equal(send(r, APWR, 0x0800, block, 8), 1);
            if (status_of(r, 0) != before || r->memory[0x0807] != 0)
                fail_msg("control 0x%02X: a re-written block with status 0x%02X made 0x%02X of 0x%02X", controls[i],
                         statuses[k], status_of(r, 0), before);
        }
        memset(data, 0, sizeof data);
        if (in)
            assert_int_equal(send(r, APRD, START, data, 8), 1);
        else
            ect_esc_pdi_read(&r->esc, START, data, 8);
        assert_memory_equal(data, "\1\2\3\4\5\6\7\10", 8);
    }
}

static void locked_while_enabled(void **state)
{
    rig_t *r = *state;
    uint8_t want[8], got[8];
    for (unsigned int n = 0; n < 8; n++) {
        uint16_t sm = (uint16_t)(0x0800 + 8 * n);
        set_sm(r, n, (uint16_t)(0x1000 + 64 * n), 8, IN_BUFFERED);
        memcpy(want, r->memory + sm, 8);
        for (uint16_t reg = 0; reg < 8; reg++) {
            unsigned int wkc = ecat_write(r, (uint16_t)(sm + reg), reg == 6 ? 0x01 : (uint8_t)~want[reg]);
            if (wkc != (reg == 6 ? 1 : 0))
                fail_msg("SM%u enabled, write to +%u: got WKC %u", n, reg, wkc);
        }
        assert_int_equal(send(r, APRD, sm, got, 8), 1);
        assert_memory_equal(got, want, 8);
        /* A write that disables and changes at once: locked when it began. */
        uint8_t block[8] = {0x00, 0x18, 0x04, 0x00, 0x26, 0, 0, 0};
        assert_int_equal(send(r, APWR, sm, block, 8), 1);
        assert_int_equal(r->memory[sm + 6], 0);
        assert_memory_equal(r->memory + sm, want, 4);
        assert_int_equal(send(r, APWR, sm, block, 5), 1);
        assert_memory_equal(r->memory + sm, block, 5);
    }
}

static void disabled_by_ecat(void **state)
{
    rig_t *r = *state;
    static const uint8_t controls[] = {IN_MAILBOX, OUT_MAILBOX, IN_BUFFERED, OUT_BUFFERED};
    for (size_t i = 0; i < sizeof controls; i++) {
        bool mailbox = (controls[i] & 2) != 0;
        uint8_t data[8] = {1, 2, 3, 4, 5, 6, 7, 8};
        set_sm(r, 0, START, 8, controls[i]);
        send(r, APWR, START, data, 8);
        ect_esc_pdi_write(&r->esc, START, data, 8);
        assert_int_equal(ecat_write(r, 0x0806, 0), 1);
        assert_int_equal(status_of(r, 0), 0x30);
        /* Plain memory for both sides now. */
        memset(data, 0x70, sizeof data);
        assert_int_equal(send(r, APWR, START + 3, data, 2), 1);
        assert_int_equal(send(r, APRD, START + 3, data, 5), 1);
        pdi_write(r, START + 7, 0x71);
        assert_int_equal(r->memory[START + 7], 0x71);
        /* Enabled again: empty. */
        assert_int_equal(ecat_write(r, 0x0806, 1), 1);
        assert_int_equal(status_of(r, 0), mailbox ? 0x00 : 0x30);
        memset(data, 0, sizeof data);
        bool in = (controls[i] & 4) == 0;
        if (in)
            assert_int_equal(send(r, APRD, START, data, 8), 0);
        ect_esc_pdi_read(&r->esc, START, data, 8);
        assert_int_equal(data[0], 0);
        assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SM0, 0);
    }
}

static void disabled_by_pdi(void **state)
{
    rig_t *r = *state;
    static const uint8_t controls[] = {IN_MAILBOX, OUT_MAILBOX, IN_BUFFERED, OUT_BUFFERED};
    for (size_t i = 0; i < sizeof controls; i++) {
        bool in = (controls[i] & 4) == 0;
        uint8_t data[8] = {1, 2, 3, 4, 5, 6, 7, 8}, got[8] = {0};
        set_sm(r, 0, START, 8, controls[i]);
        send(r, APWR, START, data, 8);
        ect_esc_pdi_write(&r->esc, START, data, 8);
        pdi_write(r, 0x0807, 0x01);
        assert_int_equal(send(r, APRD, 0x0800, got, 8), 1);
        assert_int_equal(got[7] & 1, 1);
        assert_int_equal(got[6] & 1, 1);
        static const uint16_t lengths[] = {1, 8};
        for (size_t k = 0; k < 2; k++) {
            assert_int_equal(send(r, APWR, START, data, lengths[k]), 0);
            assert_int_equal(send(r, APRD, START, data, lengths[k]), 0);
            ect_esc_pdi_write(&r->esc, START, "XXXXXXXX", lengths[k]);
            ect_esc_pdi_read(&r->esc, START, got, 8);
            assert_int_equal(got[0], 0);
        }
        pdi_write(r, 0x0807, 0x00);
        assert_int_equal(status_of(r, 0) & 0xCB, 0);
        if (in)
            assert_int_equal(send(r, APRD, START, data, 8), 0);
        ect_esc_pdi_read(&r->esc, START, got, 8);
        assert_int_equal(got[0], 0);
        if (in)
            ect_esc_pdi_write(&r->esc, START, "ABCDEFGH", 8);
        else
            send(r, APWR, START, data, 8);
        assert_int_equal(status_of(r, 0) & 0x01, 0x01);
    }
}

static void one_byte(void **state)
{
    rig_t *r = *state;
    static const uint8_t controls[] = {OUT_BUFFERED, OUT_MAILBOX};
    for (size_t i = 0; i < sizeof controls; i++) {
        set_sm(r, 0, START, 1, controls[i]);
        for (unsigned int v = 1; v < 5; v++) {
            uint8_t got = 0;
            assert_int_equal(ecat_write(r, START, (uint8_t)v), 1);
            assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SM0, ECT_EVENT_SM0);
            assert_int_equal(r->memory[START], v);
            ect_esc_pdi_read(&r->esc, START, &got, 1);
            assert_int_equal(got, v);
            assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SM0, 0);
        }
    }
    set_sm(r, 0, START, 1, IN_BUFFERED);
    for (unsigned int v = 1; v < 5; v++) {
        uint8_t got = 0;
        pdi_write(r, START, (uint8_t)v);
        assert_int_equal(ect_load_le16(r->memory + ECT_REG_ECAT_EVENT), ECT_ECAT_EVENT_SM0);
        assert_int_equal(send(r, APRD, START, &got, 1), 1);
        assert_int_equal(got, v);
        assert_int_equal(ect_load_le16(r->memory + ECT_REG_ECAT_EVENT), 0);
    }
    set_sm(r, 0, MEMORY, 1, OUT_BUFFERED); /* beyond the RAM */
    assert_int_equal(ecat_write(r, MEMORY, 1), 0);
}

/* The three buffers are contiguous; the memory before and behind does not belong to them. */
static void addresses_of_buffers(void **state)
{
    rig_t *r = *state;
    uint8_t data[8];
    set_sm(r, 2, START + 0x100, sizeof data, OUT_BUFFERED);
    memset(r->memory + START, 0x5A, 0x200);
    for (uint8_t fill = 1; fill <= 3; fill++) {
        memset(data, fill, sizeof data);
        assert_int_equal(send(r, APWR, START + 0x100, data, sizeof data), 1);
        if (fill == 1)
            ect_esc_pdi_read(&r->esc, START + 0x100, data, 1); /* and keeps the first */
    }
    for (unsigned int at = 0; at < 0x200; at++) {
        bool buffer = at >= 0x100 && at < 0x100 + 3 * sizeof data;
        unsigned int want = buffer ? 1 + (at - 0x100) / (unsigned int)sizeof data : 0x5A;
        if (r->memory[START + at] != want)
            fail_msg("0x%04X: expected 0x%02X, got 0x%02X", START + at, want, r->memory[START + at]);
    }
}

/* Over the registers of the digital outputs there are no buffers: each byte is at its own address. */
static void digital_outputs(void **state)
{
    rig_t *r = *state;
    set_sm(r, 2, 0x0F00, 4, OUT_BUFFERED);
    for (unsigned int i = 0; i < 4; i++)
        assert_int_equal(ecat_write(r, (uint16_t)(0x0F00 + i), (uint8_t)(0x11 * (i + 1))), 1);
    assert_memory_equal(r->memory + 0x0F00, "\x11\x22\x33\x44", 4);
    assert_int_equal(ect_esc_al_event(&r->esc) & (ECT_EVENT_SM0 << 2), ECT_EVENT_SM0 << 2);
    uint8_t data[0x100]; /* from there to the process RAM */
    memset(data, 0x5A, sizeof data);
    assert_int_equal(send(r, APWR, 0x0F80, data, sizeof data), 1);
    assert_memory_equal(r->memory + 0x0F80, data, sizeof data);
}

/* Its events are raised with it, and no others. */
static void off_takes_its_events(void **state)
{
    rig_t *r = *state;
    for (unsigned int off = 0; off < 8; off++) {
        for (unsigned int n = 0; n < 8; n++) {
            set_sm(r, n, (uint16_t)(START + 64 * n), 4, OUT_BUFFERED);
            assert_int_equal(send(r, APWR, (uint16_t)(START + 64 * n), (uint8_t[4]){1}, 4), 1);
        }
        assert_int_equal(ecat_write(r, (uint16_t)(0x0806 + 8 * off), 0), 1);
        uint32_t got = ect_esc_al_event(&r->esc) >> 8 & 0xFF;
        if (got != (0xFFu & ~(1u << off)))
            fail_msg("SM%u off: expected AL events of the others, got 0x%02X", off, got);
    }
}

static void one_byte_is_plain_memory(void **state)
{
    rig_t *r = *state;
    uint8_t got = 0;
    set_sm(r, 0, START, 1, OUT_BUFFERED);
    assert_int_equal(ecat_write(r, START, 0x33), 1);
    unsigned int wkc = send(r, APRD, START, &got, 1);
    if (wkc != 1 || got != 0x33)
        fail_msg("ECAT reads back a 1-byte output SM: expected WKC 1, 0x33, got %u, 0x%02X", wkc, got);
}

static void length_zero(void **state)
{
    rig_t *r = *state;
    uint8_t data[4] = {1, 2, 3, 4};
    uint8_t block[8] = {0x00, 0x10, 0, 0, OUT_MAILBOX | 0x40, 0, 1, 0};
    assert_int_equal(send(r, APWR, 0x0800, block, 8), 1);
    assert_int_equal(r->memory[0x0806], 1);
    (void)ect_esc_pdi_read(&r->esc, 0x0806, block, 1);
    assert_int_equal(send(r, APWR, START, data, 4), 1);
    assert_int_equal(send(r, APWR, START, data, 4), 1);
    assert_int_equal(send(r, APRD, START + 1, data, 2), 1);
    assert_int_equal(ect_esc_al_event(&r->esc), 0);
    assert_int_equal(r->memory[ECT_REG_WD_STATUS_PD], 0);
}

/* Control bits 4 and 5: each direction raises its own event or none; the access of the other side clears it. */
static void events(void **state)
{
    rig_t *r = *state;
    for (unsigned int n = 0; n < 8; n++) {
        for (unsigned int bits = 0; bits < 8; bits++) {
            bool in = (bits & 4) != 0;
            uint8_t control = (uint8_t)((in ? 0x02 : 0x06) | ((bits & 3) << 4));
            uint16_t start = (uint16_t)(START + 64 * n);
            uint8_t data[2] = {1, 2};
            uint32_t al = (bits & 2) != 0 ? (uint32_t)ECT_EVENT_SM0 << n : 0;
            uint16_t ecat = (uint16_t)((bits & 1) != 0 ? ECT_ECAT_EVENT_SM0 << n : 0);
            set_sm(r, n, start, 2, control);
            ect_esc_pdi_read(&r->esc, 0x0800, (uint8_t[64]){0}, 64);
            uint32_t activity = ect_esc_activity(&r->esc);
            for (unsigned int round = 0; round < 2; round++) {
                uint32_t before = ect_esc_activity(&r->esc);
                bool by_ecat = (round == 0) != in;
                bool write = round == 0;
                if (by_ecat)
                    assert_int_equal(send(r, write ? APWR : APRD, start, data, 2), 1);
                else if (write)
                    ect_esc_pdi_write(&r->esc, start, data, 2);
                else
                    ect_esc_pdi_read(&r->esc, start, data, 2);
                assert_true(!by_ecat || ect_esc_activity(&r->esc) != before);
                uint32_t got_al = ect_esc_al_event(&r->esc) & ((uint32_t)ECT_EVENT_SM0 << n);
                unsigned int got_ecat = ect_load_le16(r->memory + ECT_REG_ECAT_EVENT) & (0x0010u << n);
                if (got_al != (by_ecat ? al : 0) || got_ecat != (by_ecat ? 0 : ecat))
                    fail_msg("SM%u control 0x%02X after %s %s: AL event 0x%X, ECAT event 0x%X", n, control,
                             by_ecat ? "ECAT" : "PDI", write ? "write" : "read", got_al, got_ecat);
            }
            assert_int_not_equal(ect_esc_activity(&r->esc), activity);
        }
    }
}

static void neighbours(void **state)
{
    rig_t *r = *state;
    uint8_t data[24];
    memset(data, 0x66, sizeof data);
    set_sm(r, 1, START + 4, 4, OUT_MAILBOX);
    set_sm(r, 0, START + 8, 4, OUT_MAILBOX);
    set_sm(r, 2, START + 16, 4, OUT_BUFFERED);
    assert_int_equal(send(r, APWR, START + 4, data, 8), 1); /* SM1 and SM0 */
    assert_int_equal(status_of(r, 1), 0x09);
    assert_int_equal(status_of(r, 0), 0x09);
    assert_int_equal(send(r, APWR, START + 4, data, 8), 0); /* both full */
    assert_int_equal(send(r, APWR, START + 6, data, 4), 0);
    memset(data, 0x67, sizeof data);
    assert_int_equal(send(r, APWR, START, data, 24), 1); /* plain parts and SM2 */
    assert_int_equal(r->memory[START + 3], 0x67);
    assert_int_equal(r->memory[START + 4], 0x66);
    assert_int_equal(r->memory[START + 11], 0x66);
    assert_int_equal(r->memory[START + 12], 0x67);
    assert_int_equal(r->memory[START + 23], 0x67);
    assert_int_equal(status_of(r, 2), 0x01);
    assert_int_equal(send(r, APWR, START + 2, data, 4), 1); /* two plain bytes, then the first two of a full mailbox */
    assert_int_equal(status_of(r, 1), 0x09);
}

static void beyond_memory(void **state)
{
    rig_t *r = *state;
    uint8_t data[64] = {0};
    static const uint8_t controls[] = {IN_MAILBOX, OUT_MAILBOX, IN_BUFFERED, OUT_BUFFERED};
    for (size_t i = 0; i < sizeof controls; i++) {
        for (uint16_t start = MEMORY - 40; start < MEMORY + 4; start++) {
            set_sm(r, 0, start, 16, controls[i]);
            for (unsigned int k = 0; k < 6; k++) {
                unsigned int wkc = send(r, APWR, start, data, 16);
                ect_esc_pdi_write(&r->esc, start, data, 16);
                wkc += send(r, APRD, start, data, 16);
                ect_esc_pdi_read(&r->esc, start, data, 16);
                if (start >= MEMORY)
                    assert_int_equal(wkc, 0);
            }
        }
    }
    set_sm(r, 0, MEMORY - 16, 16, OUT_BUFFERED);
    assert_int_equal(send(r, APWR, MEMORY - 16, data, 16), 1);
    assert_int_equal(send(r, APWR, MEMORY - 16, data, 16), 0); /* the second buffer */
    set_sm(r, 0, 0xFFF0, 0xFFFF, OUT_BUFFERED);
    assert_int_equal(send(r, APWR, 0xFFF0, data, 64), 0);
}

static void repeat_bits(void **state)
{
    rig_t *r = *state;
    uint8_t data[4] = {1, 2, 3, 4}, got[8];
    set_sm(r, 1, START, 4, IN_MAILBOX);
    ect_esc_pdi_write(&r->esc, START, data, 4);
    ect_esc_pdi_read(&r->esc, 0x080E, got, 1);
    for (unsigned int toggle = 0; toggle < 4; toggle++) {
        uint8_t value = toggle % 2 == 0 ? 0x03 : 0x01;
        assert_int_equal(ecat_write(r, 0x080E, value), 1);
        assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SM_CHANGED, ECT_EVENT_SM_CHANGED);
        assert_int_equal(status_of(r, 1), 0x09);
        ect_esc_pdi_read(&r->esc, 0x080E, got, 1);
        assert_int_equal(got[0], value);
        pdi_write(r, 0x080F, value & 2);
        assert_int_equal(send(r, APRD, 0x080F, got, 1), 1);
        assert_int_equal(got[0], value & 2);
        assert_int_equal(status_of(r, 1), 0x09);
    }
    assert_int_equal(send(r, APRD, START, data, 4), 1);
}

/* A model of one SyncManager, byte by byte; -1: content undefined. */
enum { LONGEST = 64 };
typedef struct model {
    bool mailbox, ecat_writes;
    uint16_t size;
    bool producer_open, consumer_open, full, written, read, any;
    bool leaving; /* the present frame has accessed the last byte */
    int writing[LONGEST], latest[LONGEST], reading[LONGEST];
    bool al_event, ecat_event;
} model_t;

static void model_reset(model_t *m)
{
    bool mailbox = m->mailbox, ecat_writes = m->ecat_writes;
    uint16_t size = m->size;
    memset(m, 0, sizeof *m);
    m->mailbox = mailbox;
    m->ecat_writes = ecat_writes;
    m->size = size;
}

static bool model_enter(model_t *m, bool write)
{
    bool *open = write ? &m->producer_open : &m->consumer_open;
    *open = !(m->mailbox && m->leaving);
    if (!*open)
        return false;
    m->leaving = false;
    if (write) {
        m->producer_open = !(m->mailbox && m->full);
        if (!m->producer_open)
            return false;
        for (unsigned int i = 0; i < m->size; i++)
            m->writing[i] = -1;
        m->read = false;
    } else {
        m->consumer_open = m->mailbox ? m->full : m->any;
        if (!m->consumer_open)
            return false;
        memcpy(m->reading, m->latest, sizeof m->reading);
        m->written = false;
    }
    return true;
}

static void model_leave(model_t *m, bool by_ecat, bool write)
{
    if (write) {
        memcpy(m->latest, m->writing, sizeof m->latest);
        m->producer_open = false;
        m->full = m->any = m->written = true;
    } else {
        m->consumer_open = m->full = false;
        m->read = true;
    }
    if (by_ecat)
        m->al_event = true;
    else
        m->ecat_event = true;
}

/* @return whether the access succeeds; reads fill `data` with the expected bytes */
static bool model_access(model_t *m, bool by_ecat, bool write, uint16_t offset, uint16_t length, int *data)
{
    if (write != (by_ecat == m->ecat_writes))
        return false;
    if (offset == 0 && model_enter(m, write)) {
        if (by_ecat)
            m->ecat_event = false;
        else
            m->al_event = false;
    }
    if (!(write ? m->producer_open : m->consumer_open))
        return false;
    for (unsigned int i = 0; i < length; i++) {
        if (write)
            m->writing[offset + i] = data[i];
        else
            data[i] = m->reading[offset + i];
    }
    if (offset + length == m->size && by_ecat) {
        m->leaving = true;
        m->producer_open &= !write;
        m->consumer_open &= write;
    } else if (offset + length == m->size) {
        model_leave(m, by_ecat, write);
    }
    return true;
}

static uint32_t random_below(rig_t *r, uint32_t limit)
{
    r->random ^= r->random << 13;
    r->random ^= r->random >> 17;
    r->random ^= r->random << 5;
    return r->random % limit;
}

typedef struct op {
    bool write;
    uint16_t offset, length;
    uint8_t sent[LONGEST];
} op_t;

/* Mostly an access that the side may do next: start, continue, end; sometimes any other. */
static op_t random_op(rig_t *r, const model_t *m, bool by_ecat)
{
    op_t op = {0};
    op.write = (by_ecat == m->ecat_writes) != (random_below(r, 16) == 0);
    uint32_t kind = random_below(r, 8);
    if (kind < 3) { /* from the first byte on */
        op.length = (uint16_t)(1 + random_below(r, m->size));
    } else if (kind < 5) { /* up to the last byte */
        op.length = (uint16_t)(1 + random_below(r, m->size));
        op.offset = (uint16_t)(m->size - op.length);
    } else if (kind < 6) {
        op.length = m->size;
    } else {
        op.offset = (uint16_t)random_below(r, m->size);
        op.length = (uint16_t)(1 + random_below(r, (uint32_t)m->size - op.offset));
    }
    for (unsigned int i = 0; i < op.length; i++)
        op.sent[i] = (uint8_t)(1 + random_below(r, 255));
    return op;
}

static void check_op(const model_t *before, model_t *m, const op_t *op, bool by_ecat, const uint8_t *got,
                     unsigned int wkc)
{
    int data[LONGEST];
    for (unsigned int i = 0; i < op->length; i++)
        data[i] = op->sent[i];
    bool through = model_access(m, by_ecat, op->write, op->offset, op->length, data);
    if (by_ecat && wkc != (through ? 1 : 0))
        fail_msg("size %u mailbox %d, ECAT %s bytes %u..%u: expected WKC %d, got %u (full %d, open %d %d)", m->size,
                 m->mailbox, op->write ? "writes" : "reads", op->offset, op->offset + op->length - 1, through, wkc,
                 before->full, before->producer_open, before->consumer_open);
    if (op->write)
        return;
    for (unsigned int i = 0; i < op->length; i++) {
        int want = through ? data[i] : by_ecat ? op->sent[i] : 0;
        if (want >= 0 && want != got[i])
            fail_msg("size %u mailbox %d, %s reads byte %u: expected 0x%02X, got 0x%02X", m->size, m->mailbox,
                     by_ecat ? "ECAT" : "PDI", op->offset + i, (unsigned int)want, got[i]);
    }
}

static void check_status(const rig_t *r, const model_t *m)
{
    unsigned int want = (m->written ? 0x01u : 0u) | (m->read ? 0x02u : 0u) | (m->mailbox && m->full ? 0x08u : 0u) |
                        (m->consumer_open ? 0x40u : 0u) | (m->producer_open ? 0x80u : 0u);
    uint8_t status = status_of(r, 0);
    bool nothing = (status & 0x30) == 0x30;
    if ((status & 0xCF) != want || nothing != (!m->mailbox && !m->any))
        fail_msg("size %u, mailbox %d: expected status bits 0x%02X, got 0x%02X", m->size, m->mailbox, want, status);
    if (((ect_esc_al_event(&r->esc) & ECT_EVENT_SM0) != 0) != m->al_event ||
        ((ect_load_le16(r->memory + ECT_REG_ECAT_EVENT) & ECT_ECAT_EVENT_SM0) != 0) != m->ecat_event)
        fail_msg("size %u, mailbox %d: expected AL event %d, ECAT event %d, got 0x%X, 0x%X", m->size, m->mailbox,
                 m->al_event, m->ecat_event, ect_esc_al_event(&r->esc), ect_load_le16(r->memory + ECT_REG_ECAT_EVENT));
}

static void random_frame(rig_t *r, model_t *m)
{
    op_t ops[4];
    unsigned int count = 1 + random_below(r, 4);
    for (unsigned int i = 0; i < count; i++) {
        ops[i] = random_op(r, m, true);
        uint8_t command = ops[i].write ? APWR : APRD;
        uint16_t ado = (uint16_t)(START + ops[i].offset);
        if (i == 0)
            wire_build(&r->w, command, 0, ado, ops[i].sent, ops[i].length);
        else
            wire_append(&r->w, command, 0, ado, ops[i].sent, ops[i].length);
    }
    process(r);
    for (unsigned int i = 0; i < count; i++) {
        model_t before = *m;
        check_op(&before, m, &ops[i], true, wire_datagram(&r->w, i) + DATA, wire_wkc(&r->w, i));
    }
    if (m->leaving)
        model_leave(m, true, m->ecat_writes);
    m->leaving = false;
}

static void random_pdi(rig_t *r, model_t *m)
{
    op_t op = random_op(r, m, false);
    uint8_t got[LONGEST] = {0};
    model_t before = *m;
    if (op.write)
        ect_esc_pdi_write(&r->esc, (uint16_t)(START + op.offset), op.sent, op.length);
    else
        ect_esc_pdi_read(&r->esc, (uint16_t)(START + op.offset), got, op.length);
    check_op(&before, m, &op, false, got, 0);
}

static void random_reset(rig_t *r, model_t *m)
{
    uint16_t address = random_below(r, 2) == 0 ? 0x0806 : 0x0807;
    if (address == 0x0806) {
        ecat_write(r, 0x0806, 0);
        ecat_write(r, 0x0806, 1);
    } else {
        pdi_write(r, 0x0807, 1);
        pdi_write(r, 0x0807, 0);
    }
    model_reset(m);
}

static void interleaving(rig_t *r, bool mailbox)
{
    static const uint16_t sizes[] = {2, 3, 4, 7, 16, 33, 64};
    for (size_t i = 0; i < 2 * sizeof sizes / sizeof sizes[0]; i++) {
        model_t m = {.mailbox = mailbox, .ecat_writes = i % 2 == 0, .size = sizes[i / 2]};
        set_sm(r, 0, START, m.size, (uint8_t)(0x30 | (mailbox ? 2 : 0) | (m.ecat_writes ? 4 : 0)));
        for (unsigned int step = 0; step < 20000; step++) {
            uint32_t kind = random_below(r, 200);
            if (kind == 0)
                random_reset(r, &m);
            else if (kind < 100)
                random_frame(r, &m);
            else
                random_pdi(r, &m);
            check_status(r, &m);
        }
    }
}

static void interleaving_mailbox(void **state)
{
    interleaving(*state, true);
}

static void interleaving_buffered(void **state)
{
    interleaving(*state, false);
}

static void off_empties(void **state)
{
    rig_t *r = *state;
    for (unsigned int pdi = 0; pdi < 2; pdi++) {
        uint8_t data[8] = {1};
        set_sm(r, 0, START, 8, 0x26);
        assert_int_equal(send(r, APWR, START, data, 8), 1);
        assert_int_equal(send(r, APWR, START, data, 8), 0);
        assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SM0, ECT_EVENT_SM0);
        for (uint8_t on = 0; on < 2; on++) {
            if (pdi)
                pdi_write(r, 0x0807, on ^ 1);
            else
                ecat_write(r, 0x0806, on);
            assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SM0, 0);
            assert_int_equal(status_of(r, 0) & ECT_SM_STATUS_FULL, 0);
        }
        assert_int_equal(send(r, APWR, START, data, 8), 1);
    }
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

/* Bytes of two SyncManagers belong to the lower number, whatever their order in memory. */
static void overlapping(void **state)
{
    static const struct {
        const char *what;
        uint16_t first, second; /* start of SM0 and SM1 */
        uint16_t address, length;
        uint8_t full; /* bit n: SyncManager n is full then */
        unsigned int wkc;
    } rows[] = {
        {"the whole lower one, in front", START, START + 8, START, 16, 1, 1},
        {"the upper one: its first bytes are not its own", START, START + 8, START + 8, 16, 0, 0},
        {"the upper one in front, up to the lower one", START + 8, START, START, 16, 0, 1},
        {"both, the upper one in front: it is not closed", START + 8, START, START, 24, 1, 1},
        {"equal: the lower one", START, START, START, 16, 1, 1},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[24] = {0};
        set_sm(r, 0, rows[i].first, 16, 0x26);
        set_sm(r, 1, rows[i].second, 16, 0x26);
        wire_build(&r->w, APWR, 0, rows[i].address, data, rows[i].length);
        process(r);
        unsigned int full = (status_of(r, 0) & 8u) >> 3 | (status_of(r, 1) & 8u) >> 2;
        if (wire_wkc(&r->w, 0) != rows[i].wkc || full != rows[i].full)
            fail_msg("%s: expected WKC %u, full %u, got %u, %u", rows[i].what, rows[i].wkc, rows[i].full,
                     wire_wkc(&r->w, 0), full);
        ecat_write(r, 0x0806, 0);
        ecat_write(r, 0x080E, 0);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-016: the SyncManager with the lower number has the bytes of an overlap", overlapping, setup, teardown,
         NULL},
        TEST("CF-019: the three buffers are adjacent from the start address on", addresses_of_buffers),
        TEST("CF-019: a SyncManager over the digital outputs passes each byte to its place", digital_outputs),
        TEST("CF-021: disabling a SyncManager clears its own event, and no other", off_takes_its_events),
        TEST("CF-009: a mailbox that either side switches off and on again is empty, its event cleared", off_empties),
        TEST("CF-016 CF-017 CF-018 CF-020: a mailbox that the master writes: accepted when empty, full with the last "
             "byte, empty with the last byte read",
             mailbox_out),
        TEST("CF-016 CF-017 CF-018 CF-020: a mailbox that the master reads: readable when full, empty with the last "
             "byte read",
             mailbox_in),
        TEST("CF-019 CF-020: buffered outputs: read only after the first complete write, a new buffer each write",
             buffered_out),
        TEST("CF-019: buffered inputs: always the last complete buffer, kept while it is being read", buffered_in),
        TEST("CF-018: mail and last byte in separate datagrams and frames, 2 bytes as a poll", twincat_accesses),
        TEST("CF-020: rewriting the 8-byte block with any status byte does not change status and content",
             rewrite_of_the_block),
        TEST("CF-021: start, length and control are locked while enabled, status and PDI control always",
             locked_while_enabled),
        TEST("CF-021: disabled it is plain memory, enabled again it is empty", disabled_by_ecat),
        TEST("CF-021: disabled by the PDI, both sides are locked and the master can read this; afterwards it is empty",
             disabled_by_pdi),
        TEST("CF-016 CF-019: a SyncManager of 1 byte passes each byte at once, with events", one_byte),
        TEST("CF-019: a SyncManager of 1 byte is transparent memory: its writer may read it back",
             one_byte_is_plain_memory),
        TEST("CF-021: a SyncManager of length 0 acts as disabled: plain memory, no event, no watchdog", length_zero),
        TEST("CF-020: control bits 4 and 5 select the events that a complete access raises", events),
        TEST("CF-018: an access over several SyncManagers follows the rules of each part", neighbours),
        TEST("CF-008: SyncManagers that extend beyond the RAM access only the RAM", beyond_memory),
        TEST("CF-023: repeat request and acknowledge pass between the sides, the mail is unchanged", repeat_bits),
        TEST("CF-016 CF-017 CF-018: random accesses of both sides to a mailbox follow the model", interleaving_mailbox),
        TEST("CF-019: random accesses of both sides to three buffers follow the model, no torn buffer",
             interleaving_buffered),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC SyncManagers", tests, NULL, NULL);
}
