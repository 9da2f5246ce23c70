/* SPDX-License-Identifier: MIT */
/*
 * SoE of one twin with three drives. The input is a sequence of steps: an operation and its bytes. Each request that is
 * complete gets one reply, in one or more mails with the drive and IDN of the request; errors have 6 bytes. A value
 * stays within its limits, and process data fit their SyncManagers, whatever was written.
 */
#include <assert.h>
#include <string.h>

#include "fuzz/datagram.h"
#include "support/soedev.h"
#include "wire/bytes.h"
#include "wire/registers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAIL_HEADER = 6, HEADER = 4, ROOM = SOEDEV_MAILBOX - MAIL_HEADER, FULL = 8, SOE = 5, MOST_STEPS = 400 };
enum { READ = 1, WRITE = 3, OPERATION = 7, INCOMPLETE = 8, FAILED = 16, MOST_MAILS = 64 };

typedef struct session {
    ect_chain_t *chain;
    const uint8_t *data;
    size_t size;
    uint8_t counter;
} session_t;

static uint8_t next(session_t *s)
{
    if (s->size == 0)
        return 0;
    s->size--;
    return *s->data++;
}

static unsigned int send(const session_t *s, uint8_t command, uint16_t address, uint8_t *data, uint16_t length)
{
    return fuzz_send(s->chain, 1, command, address, data, length);
}

static soedev_t *device(const session_t *s)
{
    return ect_chain_slave(s->chain, 0)->config.instance;
}

static void request_state(const session_t *s, uint8_t state)
{
    uint8_t control[2] = {(uint8_t)(state | 0x10), 0};
    (void)send(s, FPWR, ECT_REG_AL_CONTROL, control, sizeof control);
}

static void set_sms(const session_t *s, unsigned int first, uint16_t out, uint16_t in)
{
    uint8_t block[16] = {0};
    const uint16_t length[] = {out, in};
    (void)send(s, FPWR, (uint16_t)(ECT_REG_SM + 8 * first), block, sizeof block); /* off: only then they change */
    for (unsigned int n = 0; n < 2; n++) {
        ect_store_le16(block + 8 * n, soedev.sm[first + n].start);
        ect_store_le16(block + 8 * n + 2, length[n]);
        block[8 * n + 4] = soedev.sm[first + n].control;
        block[8 * n + 6] = 1;
    }
    (void)send(s, FPWR, (uint16_t)(ECT_REG_SM + 8 * first), block, sizeof block);
}

static void write_mail(session_t *s, const uint8_t *data, uint16_t length)
{
    uint8_t mail[SOEDEV_MAILBOX] = {0};
    s->counter = (uint8_t)(s->counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(SOE | s->counter << 4);
    memcpy(mail + MAIL_HEADER, data, length);
    (void)send(s, FPWR, soedev.sm[0].start, mail, sizeof mail);
}

/* @return whether SM1 had a mail */
static bool read_mail(const session_t *s, uint8_t mail[SOEDEV_MAILBOX])
{
    uint8_t status = 0;
    (void)send(s, FPRD, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS, &status, 1);
    if ((status & FULL) == 0)
        return false;
    memset(mail, 0, SOEDEV_MAILBOX);
    assert(send(s, FPRD, soedev.sm[1].start, mail, SOEDEV_MAILBOX) == 1);
    const uint16_t length = ect_load_le16(mail);
    assert(length >= HEADER && length <= ROOM);
    for (unsigned int i = MAIL_HEADER + length; i < SOEDEV_MAILBOX; i++)
        assert(mail[i] == 0);
    return true;
}

/* The reply to a read or a last piece of a write: in mails that count down, and none after them. */
static void expect_reply(const session_t *s, const uint8_t *request)
{
    uint8_t mail[SOEDEV_MAILBOX];
    const uint8_t *data = mail + MAIL_HEADER;
    unsigned int behind = MOST_MAILS;
    for (bool last = false; !last; behind--) {
        assert(read_mail(s, mail) && (mail[5] & 0x0F) == SOE);
        assert((data[0] & OPERATION) == (request[0] & OPERATION) + 1 && data[0] >> 5 == request[0] >> 5);
        last = (data[0] & INCOMPLETE) == 0;
        const unsigned int count = ect_load_le16(data + 2);
        if (behind == MOST_MAILS && !last)
            behind = count;
        assert(last ? memcmp(data + 2, request + 2, 2) == 0 && (behind == 0 || behind == MOST_MAILS) : count == behind);
        if ((data[0] & FAILED) != 0)
            assert(last && ect_load_le16(mail) == HEADER + 2 && ect_load_le16(data + HEADER) != 0 &&
                   data[1] == request[1]);
        else if ((data[0] & OPERATION) == WRITE + 1)
            assert(last && ect_load_le16(mail) == HEADER && data[1] == request[1]);
        else
            assert((data[1] & ~request[1]) == 0 && data[1] != 0);
    }
    assert(!read_mail(s, mail));
}

/* A read, or a piece of a write: operation and drive, elements, IDN, then the value. */
static void request(session_t *s)
{
    static const uint16_t idns[] = {1,  15,  16,  17,     24,     32,     36,     47,
                                    99, 127, 148, 0x8001, 0x8002, 0x8003, 0x8005, 0x8007};
    uint8_t data[ROOM] = {0}, mail[SOEDEV_MAILBOX];
    const uint8_t choice = next(s), idn = next(s), length = next(s) % (ROOM - HEADER + 1);
    while (read_mail(s, mail))
        ;
    data[0] = (uint8_t)((choice & 1) != 0 ? READ : WRITE);
    data[0] |= (uint8_t)(choice & 0xE0);
    data[0] |= data[0] % 4 == WRITE && (choice & 2) != 0 ? INCOMPLETE : 0;
    data[1] = (choice & 4) != 0 ? next(s) : 0x40;
    ect_store_le16(data + 2, (choice & 8) != 0 ? (uint16_t)(idn | next(s) << 8) : idns[idn % 16]);
    for (unsigned int i = 0; i < length; i++)
        data[HEADER + i] = next(s);
    if (length >= 4 && (choice & 16) != 0) /* a list of that length */
        ect_store_le16(data + HEADER, (uint16_t)(length - 4));
    write_mail(s, data, (uint16_t)(HEADER + length));
    if ((data[0] & INCOMPLETE) == 0)
        expect_reply(s, data);
    else
        assert(!read_mail(s, mail));
}

static void any_mail(session_t *s)
{
    uint8_t data[ROOM], mail[SOEDEV_MAILBOX];
    const uint8_t length = (uint8_t)(1 + next(s) % ROOM);
    for (unsigned int i = 0; i < length; i++)
        data[i] = next(s);
    write_mail(s, data, length);
    (void)read_mail(s, mail);
}

/* SAFEOP is reached with the lengths that follow from the lists of process data. */
static void to_safeop_and_back(const session_t *s)
{
    const soedev_t *d = device(s);
    unsigned int out = 0, in = 0;
    for (unsigned int n = 0; n < 2; n++) {
        assert(d->drive[n].mdt_count == d->drive[n].mdt.used / 2 + 1 &&
               d->drive[n].at_count == d->drive[n].at.used / 2 + 1);
        out += 16;
        in += 16;
        for (unsigned int i = 0; i + 1 < d->drive[n].mdt_count; i++)
            out += d->drive[n].mdt_map[i] & 0xFF;
        for (unsigned int i = 0; i + 1 < d->drive[n].at_count; i++)
            in += d->drive[n].at_map[i] & 0xFF;
    }
    set_sms(s, 2, (uint16_t)(out / 8), (uint16_t)(in / 8));
    request_state(s, ECT_STATE_SAFEOP);
    assert((ect_chain_slave(s->chain, 0)->state == ECT_STATE_SAFEOP) == (out <= 8 * 64 && in <= 8 * 64));
    request_state(s, ECT_STATE_PREOP);
}

static void step(session_t *s)
{
    static const uint8_t emergency[5] = {0};
    const uint8_t what = next(s);
    switch (what % 8) {
    case 4:
        any_mail(s);
        break;
    case 5:
        ect_soe_finish(&soedev_soe, device(s), what / 8 % 2, (what & 0x40) != 0 ? 99 : 148, what >= 0x80);
        break;
    case 6:
        to_safeop_and_back(s);
        break;
    case 7:
        ect_soe_emergency(&soedev_soe, device(s), what / 8 % 3, what, 0, emergency);
        request_state(s, ECT_STATE_PREOP);
        break;
    default:
        request(s);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const ect_twin_config_t twin = ect_twin_default(&soedev, NULL);
    session_t s = {.data = data, .size = size};
    s.chain = ect_chain_new(&twin, 1, 1);
    if (!s.chain)
        return 0;
    set_sms(&s, 0, SOEDEV_MAILBOX, SOEDEV_MAILBOX);
    request_state(&s, ECT_STATE_PREOP);
    for (unsigned int n = 0; s.size > 0 && n < MOST_STEPS; n++) {
        step(&s);
        for (unsigned int drive = 0; drive < 2; drive++) {
            const soedev_drive_t *d = &device(&s)->drive[drive];
            assert(d->limit >= 10 && d->limit <= 60000 && d->signed8 >= -10 && d->signed8 <= 10 && d->telegram == 7);
        }
    }
    assert(ect_chain_slave(s.chain, 0)->state == ECT_STATE_PREOP);
    ect_chain_free(s.chain);
    return 0;
}
