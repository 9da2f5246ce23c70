/* SPDX-License-Identifier: MIT */
/* Start-up commands of CoE: an SDO transfer through the mailbox of the file. */
#include <stdio.h>
#include <string.h>

#include "eni/player.h"
#include "wire/bytes.h"

enum { COE_HEADER = 2, SDO = ENI_MAIL_HEADER + COE_HEADER, SDO_HEADER = 4, SIZE = 4 };
enum { TYPE_COE = 3, SDO_REQUEST = 2, SDO_RESPONSE = 3, NUMBER = 12 };
/* Command specifiers and their bits. */
enum {
    DOWNLOAD = 0x21,
    EXPEDITED = 0x02,
    COMPLETE = 0x10,
    UPLOAD = 0x40,
    SEGMENT_LAST = 0x01,
    TOGGLE = 0x10,
    SEGMENT_MOST_UNUSED = 7,
    ABORT = 0x80
};
enum { SHORTEST = COE_HEADER + SDO_HEADER + SIZE };

typedef struct transfer {
    eni_talk_t talk;
    const ect_eni_coe_t *command;
} transfer_t;

static bool is_answer(const eni_talk_t *talk, const uint8_t *mail)
{
    (void)talk;
    return ect_load_le16(mail + ENI_MAIL_HEADER) >> NUMBER == SDO_RESPONSE || mail[SDO] == ABORT;
}

/* Sends a request and receives the reply; emergencies before it are skipped. */
static void request(transfer_t *t, size_t length)
{
    char why[64];
    ect_store_le16(t->talk.p->mail + ENI_MAIL_HEADER, SDO_REQUEST << NUMBER);
    eni_talk_send(&t->talk, length);
    const uint8_t *mail = eni_talk_receive(&t->talk, is_answer);
    if (mail == NULL || mail[SDO] != ABORT)
        return;
    (void)snprintf(why, sizeof why, "abort code 0x%08lX", (unsigned long)ect_load_le32(mail + SDO + SDO_HEADER));
    eni_talk_fail(&t->talk, why);
}

/* Starts a request: command specifier, index and sub-index. @return the place of its data */
static uint8_t *begin(transfer_t *t, unsigned int specifier)
{
    uint8_t *sdo = t->talk.p->mail + SDO;
    memset(t->talk.p->mail, 0, sizeof t->talk.p->mail);
    sdo[0] = (uint8_t)(specifier | (t->command->complete ? COMPLETE : 0));
    ect_store_le16(sdo + 1, t->command->index);
    sdo[3] = t->command->subindex;
    return sdo + SDO_HEADER;
}

static void send_segments(transfer_t *t, size_t at)
{
    const ect_esi_bytes_t *data = &t->command->data;
    const size_t room = (size_t)t->talk.slave->mailbox.send.length - SDO - 1;
    unsigned int toggle = 0;
    for (; at < data->length && !t->talk.failed; toggle ^= TOGGLE) {
        const size_t count = data->length - at < room ? data->length - at : room;
        const size_t unused = count < SEGMENT_MOST_UNUSED ? SEGMENT_MOST_UNUSED - count : 0;
        memset(t->talk.p->mail, 0, sizeof t->talk.p->mail);
        t->talk.p->mail[SDO] = (uint8_t)(toggle | unused << 1 | (at + count == data->length ? SEGMENT_LAST : 0));
        memcpy(t->talk.p->mail + SDO + 1, data->bytes + at, count);
        request(t, COE_HEADER + 1 + (count < SEGMENT_MOST_UNUSED ? SEGMENT_MOST_UNUSED : count));
        at += count;
    }
}

static void download(transfer_t *t)
{
    const ect_esi_bytes_t *data = &t->command->data;
    const size_t room = (size_t)t->talk.slave->mailbox.send.length - SDO - SDO_HEADER - SIZE;
    const bool expedited = data->length <= SIZE && !t->command->complete;
    const size_t first = data->length < room ? data->length : room;
    if (expedited) {
        memcpy(begin(t, DOWNLOAD | EXPEDITED | (unsigned int)(SIZE - data->length) << 2), data->bytes, data->length);
        request(t, COE_HEADER + SDO_HEADER + SIZE);
    } else {
        uint8_t *at = begin(t, DOWNLOAD);
        ect_store_le32(at, (uint32_t)data->length);
        memcpy(at + SIZE, data->bytes, first);
        request(t, COE_HEADER + SDO_HEADER + SIZE + first);
    }
    if (!t->talk.failed && !expedited)
        send_segments(t, first);
}

void eni_play_coe(ect_eni_player_t *p, size_t slave, const ect_eni_coe_t *command)
{
    transfer_t t = {.talk = {.line = command->line, .timeout_ms = command->timeout_ms, .protocol = TYPE_COE},
                    .command = command};
    (void)snprintf(t.talk.name, sizeof t.talk.name, "%04X:%u", (unsigned int)command->index,
                   (unsigned int)command->subindex);
    if (!eni_talk_begin(&t.talk, p, slave, SHORTEST))
        return;
    if (command->download) {
        download(&t);
        return;
    }
    (void)begin(&t, UPLOAD);
    request(&t, COE_HEADER + SDO_HEADER + SIZE);
}
