/* SPDX-License-Identifier: MIT */
/* Files by FoE, packet by packet. */
#include <stdlib.h>
#include <string.h>

#include "seams/foe.h"
#include "steps/engine.h"

enum { MAIL_HEADER = 6, BUSY_PAUSE_MS = 20 };

uint16_t cf_foe_full(cf_t *c, bool write)
{
    bool boot = (cf_get8(c, ECT_REG_AL_STATUS) & ECT_AL_STATE_MASK) == CF_BOOT;
    const cf_mailbox_t *m = boot ? &c->facts.boot : &c->mailbox;
    return (uint16_t)((write ? m->out_size : m->in_size) - MAIL_HEADER - CF_FOE_HEADER);
}

cf_foe_t cf_foe_open(const cf_t *c, uint8_t operation, uint32_t password)
{
    return (cf_foe_t){operation, password, c->file, (uint16_t)strlen(c->file)};
}

void cf_send_foe(cf_t *c, const cf_foe_t *sent)
{
    uint8_t mail[CF_MAX_MAIL] = {sent->operation};
    ect_store_le32(mail + 2, sent->number);
    if (sent->length > 0)
        memcpy(mail + CF_FOE_HEADER, sent->data, sent->length);
    cf_send_mail(c, CF_MBX_FOE, mail, (uint16_t)(CF_FOE_HEADER + sent->length));
}

static uint8_t receive(cf_t *c, cf_mail_t *mail, uint32_t *number)
{
    uint64_t until = cf_now_ns() + CF_FOE_LATER_MS * UINT64_C(1000000);
    while (!cf_mail_waits(c) && cf_now_ns() < until) /* erasing takes longer than a mail */
        cf_poll_pause(c);
    cf_receive(c, CF_MBX_FOE, mail);
    cf_expect_that(c, mail->length >= CF_FOE_HEADER, "a FoE reply: expected at least 6 bytes, got %u", mail->length);
    *number = ect_load_le32(mail->data + 2);
    return mail->data[0];
}

uint8_t cf_request_foe(cf_t *c, const cf_foe_t *sent, cf_mail_t *mail, uint32_t *number)
{
    uint64_t until = cf_now_ns() + CF_FOE_LATER_MS * UINT64_C(1000000);
    for (;;) {
        cf_send_foe(c, sent);
        uint8_t reply = receive(c, mail, number);
        if (reply != CF_FOE_BUSY)
            return reply;
        cf_expect_that(c, cf_now_ns() < until, "FoE: expected a reply within %d s, got only BUSY",
                       (int)CF_FOE_LATER_MS / 1000);
        cf_sleep_ms(c, BUSY_PAUSE_MS);
    }
}

static uint32_t error_of(cf_t *c, uint32_t number)
{
    cf_expect_bits(c, "error code: one of FoE", 0xFFFFFFE0u, ECT_FOE_UNDEFINED, number);
    return number;
}

uint32_t cf_read_file(cf_t *c, uint32_t password, void *data, size_t *size)
{
    const uint16_t full = cf_foe_full(c, false);
    cf_mail_t mail;
    uint32_t number;
    size_t got = 0;
    const cf_foe_t open = cf_foe_open(c, CF_FOE_READ, password);
    uint8_t reply = cf_request_foe(c, &open, &mail, &number);
    for (uint32_t packet = 1;; packet++) {
        if (reply == CF_FOE_ERROR)
            return error_of(c, number);
        const uint16_t length = (uint16_t)(mail.length - CF_FOE_HEADER);
        cf_expect(c, "FoE operation of a file's packet", CF_FOE_DATA, reply);
        cf_expect_range(c, "number of the packet", packet, packet, number);
        cf_expect_that(c, got + length <= *size, "the file: expected at most %zu bytes, got more", *size);
        memcpy((uint8_t *)data + got, mail.data + CF_FOE_HEADER, length);
        got += length;
        if (length < full)
            break;
        reply = cf_request_foe(c, &(cf_foe_t){CF_FOE_ACK, packet, NULL, 0}, &mail, &number);
    }
    cf_send_foe(c, &(cf_foe_t){CF_FOE_ACK, number, NULL, 0});
    *size = got;
    return 0;
}

uint32_t cf_write_file(cf_t *c, uint32_t password, const void *data, size_t size)
{
    const uint16_t full = cf_foe_full(c, true);
    const uint8_t *from = data;
    cf_mail_t mail;
    uint32_t number, packet = 0;
    const cf_foe_t open = cf_foe_open(c, CF_FOE_WRITE, password);
    uint8_t reply = cf_request_foe(c, &open, &mail, &number);
    for (bool last = false;;) {
        if (reply == CF_FOE_ERROR)
            return error_of(c, number);
        cf_expect(c, "FoE operation after a packet", CF_FOE_ACK, reply);
        cf_expect_range(c, "acknowledged number", packet, packet, number);
        if (last)
            return 0;
        const uint16_t length = (uint16_t)(size < full ? size : full);
        last = length < full;
        reply = cf_request_foe(c, &(cf_foe_t){CF_FOE_DATA, ++packet, from, length}, &mail, &number);
        from += length;
        size -= length;
    }
}

void cf_keep_file(cf_t *c, const void *data, size_t size)
{
    cf_undo_t *u = cf_new_undo(c);
    *u = (cf_undo_t){.what = CF_UNDO_FILE, .size = size, .file = malloc(size + 1)};
    u->state = cf_get8(c, ECT_REG_AL_STATUS) & ECT_AL_STATE_MASK;
    if (!u->file) {
        c->engine->undo_count--;
        cf_fail(c, "out of memory");
    }
    memcpy(u->file, data, size);
}
