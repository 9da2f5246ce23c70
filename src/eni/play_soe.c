/* SPDX-License-Identifier: MIT */
/* Start-up commands of SoE: a read or write of the elements of an IDN, in as many mails as the mailboxes require. */
#include <stdio.h>
#include <string.h>

#include "eni/player.h"
#include "wire/bytes.h"

enum { HEADER = 4, ELEMENTS = 1, IDN = 2, ERROR_CODE = 2, MAILS_MOST = 1 << 14 };
/* Byte 0 of a mail. */
enum { OPERATION = 0x07, INCOMPLETE = 0x08, ERROR = 0x10, DRIVE = 5 };

static bool is_reply(const eni_talk_t *t, const uint8_t *mail)
{
    const unsigned int sent = t->p->mail[ENI_MAIL_HEADER], received = mail[ENI_MAIL_HEADER];
    const size_t length = ect_load_le16(mail);
    return length >= HEADER && length + ENI_MAIL_HEADER <= t->slave->mailbox.receive.length &&
           (received & OPERATION) == (sent & OPERATION) + 1 && received >> DRIVE == sent >> DRIVE;
}

/* Sends the request. Each mail except the last has the number of further mails in place of the IDN. */
static void request(eni_talk_t *t, const ect_eni_mail_t *mail)
{
    uint8_t *soe = t->p->mail + ENI_MAIL_HEADER;
    const size_t room = (size_t)t->slave->mailbox.send.length - ENI_MAIL_HEADER - HEADER, length = mail->data.length;
    size_t left = length > 0 ? (length + room - 1) / room : 1;
    for (size_t at = 0; left > 0 && !t->failed; at += room) {
        const size_t count = length - at < room ? length - at : room;
        left--;
        memset(t->p->mail, 0, sizeof t->p->mail);
        soe[0] =
            (uint8_t)((unsigned int)mail->type | (unsigned int)mail->drive << DRIVE | (left > 0 ? INCOMPLETE : 0u));
        soe[ELEMENTS] = mail->elements;
        ect_store_le16(soe + IDN, left > 0 ? (uint16_t)left : mail->idn);
        if (count > 0)
            memcpy(soe + HEADER, mail->data.bytes + at, count);
        eni_talk_send(t, HEADER + count);
    }
}

/* Receives all mails of the reply. An error code is at the end of its mail. */
static void receive(eni_talk_t *t)
{
    char why[40];
    for (unsigned int i = 0; i < MAILS_MOST && !t->failed; i++) {
        const uint8_t *reply = eni_talk_receive(t, is_reply);
        if (reply == NULL)
            return;
        const uint8_t *soe = reply + ENI_MAIL_HEADER;
        const size_t length = ect_load_le16(reply);
        const unsigned int code = length >= HEADER + ERROR_CODE ? ect_load_le16(soe + length - ERROR_CODE) : 0;
        (void)snprintf(why, sizeof why, "SoE error 0x%04X", code);
        if ((soe[0] & ERROR) != 0)
            eni_talk_fail(t, why);
        else if ((soe[0] & INCOMPLETE) == 0)
            return;
    }
    eni_talk_fail(t, "the reply does not end");
}

void eni_play_soe(ect_eni_player_t *p, size_t slave, const ect_eni_mail_t *mail)
{
    enum { PARAMETER_SET = 12, SETS = 7, NUMBER = 0x0FFF };
    eni_talk_t t = {.line = mail->line, .timeout_ms = mail->timeout_ms, .protocol = mail->protocol};
    (void)snprintf(t.name, sizeof t.name, "SoE drive %u, %c-%u-%04u", mail->drive & 7u,
                   mail->idn >> 15 != 0 ? 'P' : 'S', mail->idn >> PARAMETER_SET & SETS,
                   (unsigned int)mail->idn & NUMBER);
    if (!eni_talk_begin(&t, p, slave, HEADER + ERROR_CODE))
        return;
    request(&t, mail);
    if (!t.failed)
        receive(&t);
}
