/* SPDX-License-Identifier: MIT */
/* Mails through the mailbox of the file: start-up commands of AoE and EoE, and functions for those of other protocols.
 */
#include <stdio.h>
#include <string.h>

#include "eni/player.h"
#include "esc/route.h"
#include "wire/bytes.h"

enum { TYPE_ERROR = 0, COUNTERS = 7, TIMEOUT_MS = 1000, SKIPS = 64 };
/* Sizes of the AMS header, of the header of EoE, and of the result in a reply of EoE. */
enum { AMS_COMMAND = 16, AMS_FLAGS = 18, AMS_LENGTH = 20, AMS_ERROR = 24, AMS_INVOKE = 28, AMS_HEADER = 32 };
enum { IS_RESPONSE = 1, EOE_HEADER = 4, EOE_LAST = 1, EOE_RESULT = 2, EOE_TYPE = 0x0F, EOE_FRAGMENT = 0 };

/* --- the way ------------------------------------------------------------------------------------------------------ */

void eni_talk_fail(eni_talk_t *t, const char *why)
{
    if (!t->failed)
        eni_report(t->p, t->line, "slave %zu, %s: %s", t->number, t->name, why);
    t->failed = true;
}

bool eni_talk_begin(eni_talk_t *t, ect_eni_player_t *p, size_t slave, size_t bytes)
{
    char why[120];
    t->p = p;
    t->slave = &ect_eni_network(p->eni)->slaves[slave];
    t->number = slave + 1;
    const ect_eni_box_t *send = &t->slave->mailbox.send, *receive = &t->slave->mailbox.receive;
    const size_t least = bytes + ENI_MAIL_HEADER;
    const size_t shortest = send->length < receive->length ? send->length : receive->length;
    const bool fits = shortest >= least && send->length <= ECT_ENI_DATA && receive->length <= ECT_ENI_DATA;
    if (!fits) {
        (void)snprintf(why, sizeof why, "the file has no mailbox of %zu to %d bytes for this start-up command", least,
                       (int)ECT_ENI_DATA);
        eni_talk_fail(t, why);
    }
    return fits;
}

void eni_talk_send(eni_talk_t *t, size_t length)
{
    ect_eni_player_t *p = t->p;
    const ect_eni_box_t *box = &t->slave->mailbox.send;
    const eni_datagram_t write = {.command = ECT_FPWR,
                                  .address = eni_station(t->slave, t->number - 1) | (uint32_t)box->start << 16,
                                  .length = box->length,
                                  .data = p->mail};
    const uint8_t *reply;
    uint8_t *counter = &p->mail_counters[t->number - 1]; /* a slave drops a mail with the counter of the previous one */
    *counter = (uint8_t)(*counter % COUNTERS + 1);
    ect_store_le16(p->mail, (uint16_t)length);
    p->mail[5] = (uint8_t)(t->protocol | *counter << 4);
    for (unsigned int i = 0; i < TIMEOUT_MS; i++) {
        if (eni_exchange(p, &write, &reply) == 1)
            return;
        eni_wait(p);
    }
    eni_talk_fail(t, "its mailbox accepts no mail");
}

/* @return the next mail; NULL: none */
static const uint8_t *receive_mail(const eni_talk_t *t)
{
    static const uint8_t zeros[ECT_ENI_DATA];
    const ect_eni_box_t *box = &t->slave->mailbox.receive;
    const eni_datagram_t read = {.command = ECT_FPRD,
                                 .address = eni_station(t->slave, t->number - 1) | (uint32_t)box->start << 16,
                                 .length = box->length,
                                 .data = zeros};
    const uint32_t most = t->timeout_ms > 0 ? eni_bounded_timeout(t->timeout_ms) : TIMEOUT_MS;
    const uint8_t *reply;
    for (uint32_t i = 0; i <= most; i++) {
        if (eni_exchange(t->p, &read, &reply) == 1)
            return reply;
        eni_wait(t->p);
    }
    return NULL;
}

const uint8_t *eni_talk_receive(eni_talk_t *t, bool (*is_reply)(const eni_talk_t *t, const uint8_t *mail))
{
    for (unsigned int i = 0; i <= SKIPS && !t->failed; i++) {
        const uint8_t *mail = receive_mail(t);
        const unsigned int type = mail != NULL ? mail[5] & 0x0Fu : TYPE_ERROR;
        if (mail != NULL && type == t->protocol && is_reply(t, mail))
            return mail;
        if (type == TYPE_ERROR)
            eni_talk_fail(t, mail == NULL ? "no reply" : "mailbox error");
    }
    eni_talk_fail(t, "no reply");
    return NULL;
}

/* --- AoE and EoE -------------------------------------------------------------------------------------------------- */

/* @return whether a mail has the command and the number of the request */
static bool is_ads_reply(const eni_talk_t *t, const uint8_t *mail)
{
    const uint8_t *ams = mail + ENI_MAIL_HEADER, *sent = t->p->mail + ENI_MAIL_HEADER;
    return ect_load_le16(mail) >= AMS_HEADER && (ams[AMS_FLAGS] & IS_RESPONSE) != 0 &&
           memcmp(ams + AMS_COMMAND, sent + AMS_COMMAND, 2) == 0 && memcmp(ams + AMS_INVOKE, sent + AMS_INVOKE, 4) == 0;
}

static bool is_eoe_reply(const eni_talk_t *t, const uint8_t *mail)
{
    const unsigned int type = t->p->mail[ENI_MAIL_HEADER] & EOE_TYPE;
    return (mail[ENI_MAIL_HEADER] & EOE_TYPE) == type + 1u;
}

static void play_aoe(eni_talk_t *t, const ect_eni_mail_t *mail)
{
    char why[64];
    eni_talk_send(t, mail->data.length);
    const uint8_t *reply = eni_talk_receive(t, is_ads_reply);
    if (reply == NULL)
        return;
    const uint8_t *ams = reply + ENI_MAIL_HEADER;
    const uint32_t error = ect_load_le32(ams + AMS_ERROR);
    const uint32_t result = ect_load_le16(reply) >= AMS_HEADER + 4 ? ect_load_le32(ams + AMS_HEADER) : 0;
    if (error == 0 && result == 0)
        return;
    (void)snprintf(why, sizeof why, "ADS error 0x%04lX", (unsigned long)(error != 0 ? error : result));
    eni_talk_fail(t, why);
}

static void play_eoe(eni_talk_t *t, const ect_eni_mail_t *mail)
{
    char why[64];
    eni_talk_send(t, EOE_HEADER + mail->data.length);
    if (mail->type == EOE_FRAGMENT)
        return;
    const uint8_t *reply = eni_talk_receive(t, is_eoe_reply);
    const uint16_t result = reply != NULL ? ect_load_le16(reply + ENI_MAIL_HEADER + EOE_RESULT) : 0;
    if (result == 0)
        return;
    (void)snprintf(why, sizeof why, "EoE result 0x%04X", (unsigned int)result);
    eni_talk_fail(t, why);
}

void eni_play_mail(ect_eni_player_t *p, size_t slave, const ect_eni_mail_t *mail)
{
    const bool ads = mail->protocol == ECT_MAILBOX_TYPE_AOE;
    const size_t header = ads ? 0 : EOE_HEADER;
    eni_talk_t t = {.line = mail->line, .timeout_ms = mail->timeout_ms, .protocol = mail->protocol};
    (void)snprintf(t.name, sizeof t.name, ads ? "AoE" : "EoE type %u", (unsigned int)mail->type);
    if (!eni_talk_begin(&t, p, slave, header + mail->data.length))
        return;
    memset(p->mail, 0, sizeof p->mail);
    if (mail->data.length > 0)
        memcpy(p->mail + ENI_MAIL_HEADER + header, mail->data.bytes, mail->data.length);
    if (ads) {
        play_aoe(&t, mail);
        return;
    }
    p->mail[ENI_MAIL_HEADER] = mail->type;
    p->mail[ENI_MAIL_HEADER + 1] = EOE_LAST;
    play_eoe(&t, mail);
}
