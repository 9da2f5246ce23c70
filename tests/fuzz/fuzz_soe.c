/* SPDX-License-Identifier: MIT */
/*
 * SoE of one twin with three drives. The input is a sequence of steps: an operation and its bytes. Each request that is
 * complete gets one reply, in one or more mails with the drive and IDN of the request; errors have 6 bytes. A value
 * stays within its limits, and process data fit their SyncManagers, whatever was written.
 */
#include "fuzz/mail.h"
#include "support/soedev.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { HEADER = 4, SOE = 5, MOST_STEPS = 400 };
enum { READ = 1, WRITE = 3, OPERATION = 7, INCOMPLETE = 8, FAILED = 16, MOST_MAILS = 64 };

static soedev_t *device(const fuzz_master_t *s)
{
    return ect_chain_slave(s->chain, 0)->config.instance;
}

/* The reply to a read or a last piece of a write: in mails that count down, and none after them. */
static void expect_reply(const fuzz_master_t *s, const uint8_t *request)
{
    uint8_t mail[FUZZ_MAILBOX];
    const uint8_t *data = mail + FUZZ_MAIL_HEADER;
    unsigned int behind = MOST_MAILS;
    for (bool last = false; !last; behind--) {
        assert(fuzz_read_mail(s, mail) && (mail[5] & 0x0F) == SOE);
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
    assert(!fuzz_read_mail(s, mail));
}

/* A read, or a piece of a write: operation and drive, elements, IDN, then the value. */
static void request(fuzz_master_t *s)
{
    static const uint16_t idns[] = {1,  15,  16,  17,     24,     32,     36,     47,
                                    99, 127, 148, 0x8001, 0x8002, 0x8003, 0x8005, 0x8007};
    uint8_t data[FUZZ_MAIL_ROOM] = {0}, mail[FUZZ_MAILBOX];
    const uint8_t choice = fuzz_next(s), idn = fuzz_next(s), length = fuzz_next(s) % (FUZZ_MAIL_ROOM - HEADER + 1);
    while (fuzz_read_mail(s, mail))
        ;
    data[0] = (uint8_t)((choice & 1) != 0 ? READ : WRITE);
    data[0] |= (uint8_t)(choice & 0xE0);
    data[0] |= data[0] % 4 == WRITE && (choice & 2) != 0 ? INCOMPLETE : 0;
    data[1] = (choice & 4) != 0 ? fuzz_next(s) : 0x40;
    ect_store_le16(data + 2, (choice & 8) != 0 ? (uint16_t)(idn | fuzz_next(s) << 8) : idns[idn % 16]);
    for (unsigned int i = 0; i < length; i++)
        data[HEADER + i] = fuzz_next(s);
    if (length >= 4 && (choice & 16) != 0) /* a list of that length */
        ect_store_le16(data + HEADER, (uint16_t)(length - 4));
    fuzz_write_mail(s, SOE, data, (uint16_t)(HEADER + length));
    if ((data[0] & INCOMPLETE) == 0)
        expect_reply(s, data);
    else
        assert(!fuzz_read_mail(s, mail));
}

/* SAFEOP is reached with the lengths that follow from the lists of process data. */
static void to_safeop_and_back(const fuzz_master_t *s)
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
    fuzz_set_sms(s, 2, (uint16_t)(out / 8), (uint16_t)(in / 8));
    fuzz_request_state(s, ECT_STATE_SAFEOP);
    assert((ect_chain_slave(s->chain, 0)->state == ECT_STATE_SAFEOP) == (out <= 8 * 64 && in <= 8 * 64));
    fuzz_request_state(s, ECT_STATE_PREOP);
}

static void step(fuzz_master_t *s)
{
    static const uint8_t emergency[5] = {0};
    const uint8_t what = fuzz_next(s);
    switch (what % 8) {
    case 4:
        fuzz_any_mail(s, SOE);
        break;
    case 5:
        ect_soe_finish(&soedev_soe, device(s), what / 8 % 2, (what & 0x40) != 0 ? 99 : 148, what >= 0x80);
        break;
    case 6:
        to_safeop_and_back(s);
        break;
    case 7:
        ect_soe_emergency(&soedev_soe, device(s), what / 8 % 3, what, 0, emergency);
        fuzz_request_state(s, ECT_STATE_PREOP);
        break;
    default:
        request(s);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const ect_twin_config_t twin = ect_twin_default(&soedev, NULL);
    fuzz_master_t s = {.device = &soedev, .data = data, .size = size};
    s.chain = ect_chain_new(&twin, 1, 1);
    if (!s.chain)
        return 0;
    fuzz_set_sms(&s, 0, FUZZ_MAILBOX, FUZZ_MAILBOX);
    fuzz_request_state(&s, ECT_STATE_PREOP);
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
