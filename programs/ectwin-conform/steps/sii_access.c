/* SPDX-License-Identifier: MIT */
/* Single EEPROM accesses through the registers. Cases judge the error bits after each command, which reader/ would
 * repeat; reader/ reads only the image in the facts. */

#include "sii/sii.h"
#include "steps/engine.h"

enum { BUSY = 0x8000, NO_ACK = 0x2000, WRITE_REFUSED = 0x4000, READS_8 = 0x0040, READ = 0x0100, WRITE = 0x0201 };
enum { BUSY_MS = 1000, TRIES = 100 };

uint16_t cf_sii_wait(cf_t *c)
{
    uint64_t until = cf_now_ns() + BUSY_MS * UINT64_C(1000000);
    for (;;) {
        bool over = cf_now_ns() >= until;
        uint16_t control = cf_get16(c, ECT_REG_SII_CONTROL);
        if ((control & BUSY) == 0)
            return control;
        if (over)
            cf_fail(c, "EEPROM busy: expected the end of a command within %d ms, got 0x%04X", (int)BUSY_MS, control);
        cf_poll_pause(c);
    }
}

/* Writes control and address in one datagram, as masters do. */
static void command(cf_t *c, uint16_t control, uint16_t word)
{
    uint8_t bytes[6] = {0};
    ect_store_le16(bytes, control);
    ect_store_le16(bytes + 2, word);
    cf_put(c, ECT_REG_SII_CONTROL, bytes, sizeof bytes);
}

unsigned int cf_sii_read(cf_t *c, uint16_t word, uint8_t data[8])
{
    uint16_t control = 0;
    for (int tries = 0; tries < TRIES; tries++) { /* during a write the EEPROM does not acknowledge */
        if ((cf_sii_wait(c) & (NO_ACK | WRITE_REFUSED)) != 0)
            cf_put16(c, ECT_REG_SII_CONTROL, 0);
        command(c, READ, word);
        control = cf_sii_wait(c);
        if ((control & NO_ACK) == 0)
            break;
        cf_sleep_ms(c, 1);
    }
    cf_expect_bits(c, "EEPROM error bits after a read", NO_ACK | WRITE_REFUSED, 0, control);
    unsigned int bytes = (control & READS_8) != 0 ? 8 : 4;
    cf_get(c, ECT_REG_SII_DATA, data, bytes);
    return bytes;
}

/* The write enable bit is valid for one frame, so data and command share a frame. */
void cf_sii_write_word(cf_t *c, uint16_t word, uint16_t value)
{
    uint16_t control = 0;
    for (int tries = 0; tries < TRIES; tries++) {
        uint8_t order[6] = {0}, data[2];
        (void)cf_sii_wait(c);
        ect_store_le16(order, WRITE);
        ect_store_le16(order + 2, word);
        ect_store_le16(data, value);
        cf_datagram_t d[2] = {
            {.command = CF_FPWR, .address = CF_AT(c->facts.station, ECT_REG_SII_DATA), .length = 2, .data = data},
            {.command = CF_FPWR, .address = CF_AT(c->facts.station, ECT_REG_SII_CONTROL), .length = 6, .data = order}};
        cf_exchange(c, d, 2);
        control = cf_sii_wait(c);
        if ((control & NO_ACK) == 0)
            break;
        cf_put16(c, ECT_REG_SII_CONTROL, 0);
        cf_sleep_ms(c, 2);
    }
    cf_expect_bits(c, "EEPROM error bits after a write", NO_ACK | WRITE_REFUSED, 0, control);
}

void cf_sii_write(cf_t *c, uint16_t word, uint16_t value)
{
    uint8_t data[8];
    if (!c->destructive)
        cf_fail(c, "this case writes the EEPROM without CF_WRITES_SII in its needs");
    (void)cf_sii_read(c, word, data);
    *cf_new_undo(c) = (cf_undo_t){.what = CF_UNDO_SII, .index = word, .size = 2, .data = {data[0], data[1]}};
    cf_sii_write_word(c, word, value);
}

const uint8_t *cf_sii_block(const cf_t *c, uint16_t category, unsigned int nth, size_t *length)
{
    const cf_facts_t *f = &c->facts;
    size_t at = ECT_SII_CATEGORIES;
    while (f->sii && at + 4 <= f->sii_size && ect_load_le16(f->sii + at) != ECT_SII_END) {
        size_t bytes = 2 * (size_t)ect_load_le16(f->sii + at + 2);
        if (bytes > f->sii_size - at - 4)
            return NULL; /* truncated */
        if (ect_load_le16(f->sii + at) == category && nth-- == 0) {
            *length = bytes;
            return f->sii + at + 4;
        }
        at += 4 + bytes;
    }
    return NULL;
}

const uint8_t *cf_sii_category(const cf_t *c, uint16_t category, size_t *length)
{
    return cf_sii_block(c, category, 0, length);
}
