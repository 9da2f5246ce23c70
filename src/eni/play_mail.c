/* SPDX-License-Identifier: MIT */
/* Start-up commands of CoE: an SDO transfer through the mailbox that the file names. */
#include <stdio.h>
#include <string.h>

#include "eni/player.h"
#include "esc/route.h"
#include "wire/bytes.h"

enum { MAIL_HEADER = 6, COE_HEADER = 2, SDO = MAIL_HEADER + COE_HEADER, SDO_HEADER = 4, SIZE = 4 };
enum { TYPE_ERROR = 0, TYPE_COE = 3, SDO_REQUEST = 2, SDO_RESPONSE = 3, COUNTERS = 7, NUMBER = 12 };
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
enum { TIMEOUT_MS = 1000, SHORTEST = SDO + SDO_HEADER + SIZE, SKIPS = 64 };

typedef struct transfer {
    ect_eni_player_t *p;
    const ect_eni_slave_t *slave;
    const ect_eni_coe_t *command;
    size_t number; /* of the slave, from 1 */
    bool failed;
} transfer_t;

static void fail(transfer_t *t, const char *why)
{
    if (!t->failed)
        eni_report(t->p, t->command->line, "slave %zu, %04X:%u: %s", t->number, t->command->index, t->command->subindex,
                   why);
    t->failed = true;
}

/* Sends a mail of `length` bytes behind the mailbox header. */
static void send_mail(transfer_t *t, size_t length)
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
    ect_store_le32(p->mail + 2, 0);
    p->mail[5] = (uint8_t)(TYPE_COE | *counter << 4);
    ect_store_le16(p->mail + MAIL_HEADER, SDO_REQUEST << NUMBER);
    for (unsigned int i = 0; i < TIMEOUT_MS; i++) {
        if (eni_exchange(p, &write, &reply) == 1)
            return;
        eni_wait(p);
    }
    fail(t, "its mailbox takes no mail");
}

/* @return the next mail; NULL: none came */
static const uint8_t *receive_mail(transfer_t *t)
{
    static const uint8_t zeros[ECT_ENI_DATA];
    const ect_eni_box_t *box = &t->slave->mailbox.receive;
    const eni_datagram_t read = {.command = ECT_FPRD,
                                 .address = eni_station(t->slave, t->number - 1) | (uint32_t)box->start << 16,
                                 .length = box->length,
                                 .data = zeros};
    const uint32_t most = t->command->timeout_ms > 0 ? eni_bounded_timeout(t->command->timeout_ms) : TIMEOUT_MS;
    const uint8_t *reply;
    for (uint32_t i = 0; i <= most; i++) {
        if (eni_exchange(t->p, &read, &reply) == 1)
            return reply;
        eni_wait(t->p);
    }
    return NULL;
}

static bool is_answer(const uint8_t *mail)
{
    const unsigned int type = mail[5] & 0x0F, service = ect_load_le16(mail + MAIL_HEADER) >> NUMBER;
    return type == TYPE_ERROR || (type == TYPE_COE && (service == SDO_RESPONSE || mail[SDO] == ABORT));
}

/* Receives the reply to a request; emergencies before it are skipped. */
static void expect(transfer_t *t)
{
    char why[64];
    const uint8_t *mail = receive_mail(t);
    for (unsigned int i = 0; mail != NULL && !is_answer(mail) && i < SKIPS; i++)
        mail = receive_mail(t);
    if (mail == NULL)
        fail(t, "no reply comes");
    else if ((mail[5] & 0x0F) == TYPE_ERROR)
        fail(t, "a mailbox error comes");
    else if (mail[SDO] == ABORT) {
        (void)snprintf(why, sizeof why, "abort code 0x%08lX", (unsigned long)ect_load_le32(mail + SDO + SDO_HEADER));
        fail(t, why);
    }
}

/* Starts a request: command specifier, index and sub-index. @return the place of its data */
static uint8_t *begin(transfer_t *t, unsigned int specifier)
{
    uint8_t *sdo = t->p->mail + SDO;
    memset(t->p->mail, 0, sizeof t->p->mail);
    sdo[0] = (uint8_t)(specifier | (t->command->complete ? COMPLETE : 0));
    ect_store_le16(sdo + 1, t->command->index);
    sdo[3] = t->command->subindex;
    return sdo + SDO_HEADER;
}

static void send_segments(transfer_t *t, size_t at)
{
    const ect_esi_bytes_t *data = &t->command->data;
    const size_t room = (size_t)t->slave->mailbox.send.length - SDO - 1;
    unsigned int toggle = 0;
    for (; at < data->length && !t->failed; toggle ^= TOGGLE) {
        const size_t count = data->length - at < room ? data->length - at : room;
        const size_t unused = count < SEGMENT_MOST_UNUSED ? SEGMENT_MOST_UNUSED - count : 0;
        memset(t->p->mail, 0, sizeof t->p->mail);
        t->p->mail[SDO] = (uint8_t)(toggle | unused << 1 | (at + count == data->length ? SEGMENT_LAST : 0));
        memcpy(t->p->mail + SDO + 1, data->bytes + at, count);
        send_mail(t, COE_HEADER + 1 + (count < SEGMENT_MOST_UNUSED ? SEGMENT_MOST_UNUSED : count));
        if (!t->failed)
            expect(t);
        at += count;
    }
}

static void download(transfer_t *t)
{
    const ect_esi_bytes_t *data = &t->command->data;
    const size_t room = (size_t)t->slave->mailbox.send.length - SDO - SDO_HEADER - SIZE;
    const bool expedited = data->length <= SIZE && !t->command->complete;
    const size_t first = data->length < room ? data->length : room;
    if (expedited) {
        memcpy(begin(t, DOWNLOAD | EXPEDITED | (unsigned int)(SIZE - data->length) << 2), data->bytes, data->length);
        send_mail(t, COE_HEADER + SDO_HEADER + SIZE);
    } else {
        uint8_t *at = begin(t, DOWNLOAD);
        ect_store_le32(at, (uint32_t)data->length);
        memcpy(at + SIZE, data->bytes, first);
        send_mail(t, COE_HEADER + SDO_HEADER + SIZE + first);
    }
    if (!t->failed)
        expect(t);
    if (!t->failed && !expedited)
        send_segments(t, first);
}

void eni_play_coe(ect_eni_player_t *p, size_t slave, const ect_eni_coe_t *command)
{
    transfer_t t = {.p = p, .slave = &ect_eni_network(p->eni)->slaves[slave], .command = command, .number = slave + 1};
    const ect_eni_mailbox_t *mailbox = &t.slave->mailbox;
    if (mailbox->send.length < SHORTEST || mailbox->receive.length < SHORTEST || mailbox->send.length > ECT_ENI_DATA ||
        mailbox->receive.length > ECT_ENI_DATA) {
        fail(&t, "the file has a start-up command of CoE and no mailbox of 16 to 1486 bytes for it");
        return;
    }
    if (command->download) {
        download(&t);
        return;
    }
    (void)begin(&t, UPLOAD);
    send_mail(&t, COE_HEADER + SDO_HEADER + SIZE);
    if (!t.failed)
        expect(&t);
}
