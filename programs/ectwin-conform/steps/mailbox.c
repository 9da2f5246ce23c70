/* SPDX-License-Identifier: MIT */
/* Mails through SyncManagers 0 and 1. */
#include <string.h>

#include "steps/engine.h"

enum { HEADER = 6, COE_HEADER = 2 };

/* The mailbox of the present state: BOOT has one of its own. */
static const cf_mailbox_t *mailbox(cf_t *c)
{
    return (cf_get8(c, ECT_REG_AL_STATUS) & ECT_AL_STATE_MASK) == CF_BOOT ? &c->facts.boot : &c->mailbox;
}

static void write_mail(cf_t *c, const cf_mailbox_t *m, const uint8_t *mail)
{
    uint64_t until = cf_now_ns() + CF_MAIL_MS * UINT64_C(1000000);
    while (cf_write(c, m->out_start, mail, m->out_size) != 1) {
        if (cf_now_ns() >= until)
            cf_fail(c, "writing a mail: WKC expected 1, got 0 for %d ms: the slave does not read SM0", (int)CF_MAIL_MS);
        cf_poll_pause(c);
    }
}

void cf_send_raw_mail(cf_t *c, const void *mail, uint16_t length)
{
    uint8_t bytes[CF_MAX_MAIL] = {0};
    const cf_mailbox_t *m = mailbox(c);
    cf_expect_that(c, length <= m->out_size, "a mail of %u bytes does not fit SM0 of %u", length, m->out_size);
    memcpy(bytes, mail, length);
    write_mail(c, m, bytes);
}

void cf_send_mail(cf_t *c, uint8_t type, const void *data, uint16_t length)
{
    uint8_t bytes[CF_MAX_MAIL] = {0};
    cf_expect_that(c, length + HEADER <= CF_MAX_MAIL, "a mail of %u bytes is too long", length);
    c->mail_counter = (uint8_t)(c->mail_counter % 7 + 1);
    ect_store_le16(bytes, length);
    bytes[5] = (uint8_t)(type | c->mail_counter << 4);
    memcpy(bytes + HEADER, data, length);
    cf_send_raw_mail(c, bytes, (uint16_t)(length + HEADER));
}

bool cf_mail_waits(cf_t *c)
{
    return (cf_get8(c, (uint16_t)(CF_SM(1) + ECT_SM_STATUS)) & ECT_SM_STATUS_FULL) != 0;
}

bool cf_receive_mail(cf_t *c, cf_mail_t *mail, uint32_t ms)
{
    uint8_t bytes[CF_MAX_MAIL];
    if (!cf_wait_bits(c, (uint16_t)(CF_SM(1) + ECT_SM_STATUS), ECT_SM_STATUS_FULL, ECT_SM_STATUS_FULL, ms, NULL))
        return false;
    const cf_mailbox_t *m = mailbox(c);
    uint16_t wkc = cf_read(c, m->in_start, bytes, m->in_size);
    cf_expect_wkc(c, "reading the full SM1", 1, wkc);
    mail->length = ect_load_le16(bytes);
    mail->address = ect_load_le16(bytes + 2);
    mail->channel = bytes[4];
    mail->type = bytes[5] & 0x0F;
    mail->counter = bytes[5] >> 4 & 7;
    cf_expect_that(c, mail->length + HEADER <= m->in_size, "length of a mail: expected at most %d (SM1 less 6), got %u",
                   m->in_size - HEADER, mail->length);
    memcpy(mail->data, bytes + HEADER, mail->length);
    return true;
}

static bool is_emergency(const cf_mail_t *mail)
{
    return mail->type == CF_MBX_COE && mail->length >= COE_HEADER &&
           ect_load_le16(mail->data) >> 12 == CF_COE_EMERGENCY;
}

void cf_receive(cf_t *c, uint8_t type, cf_mail_t *mail)
{
    do {
        if (!cf_receive_mail(c, mail, CF_MAIL_MS))
            cf_fail(c, "a reply of mailbox type %u: expected within %d ms, got none", type, (int)CF_MAIL_MS);
    } while (is_emergency(mail));
    if (mail->type == CF_MBX_ERROR && type != CF_MBX_ERROR && mail->length >= 4)
        cf_fail(c, "a reply of mailbox type %u: expected, got a mailbox error with detail 0x%04X", type,
                ect_load_le16(mail->data + 2));
    if (mail->type != type)
        cf_fail(c, "type of the reply: expected %u, got %u", type, mail->type);
}

void cf_expect_mail_error(cf_t *c, uint16_t detail)
{
    cf_mail_t mail;
    cf_receive(c, CF_MBX_ERROR, &mail);
    cf_expect_range(c, "length of a mailbox error", 4, 4, mail.length);
    cf_expect(c, "type word of a mailbox error", 0x0001, ect_load_le16(mail.data));
    cf_expect(c, "detail of the mailbox error", detail, ect_load_le16(mail.data + 2));
}

void cf_expect_no_mail(cf_t *c, uint32_t ms)
{
    cf_mail_t mail;
    if (cf_receive_mail(c, &mail, ms))
        cf_fail(c, "expected no mail, got one of type %u, counter %u, %u bytes", mail.type, mail.counter, mail.length);
}
