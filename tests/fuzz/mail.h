/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A master's mails to one twin whose SyncManagers 0 and 1 are its mailboxes of FUZZ_MAILBOX bytes, for fuzz targets.
 */
#ifndef TESTS_FUZZ_MAIL_H
#define TESTS_FUZZ_MAIL_H

#include <assert.h>
#include <string.h>

#include "fuzz/datagram.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { FUZZ_MAILBOX = 128, FUZZ_MAIL_HEADER = 6, FUZZ_MAIL_ROOM = FUZZ_MAILBOX - FUZZ_MAIL_HEADER };

typedef struct fuzz_master {
    ect_chain_t *chain;
    const ect_device_t *device;
    const uint8_t *data; /* the rest of the input */
    size_t size;
    uint8_t counter; /* of the last mail */
} fuzz_master_t;

/* @return the next byte of the input, 0 behind its end */
static inline uint8_t fuzz_next(fuzz_master_t *m)
{
    if (m->size == 0)
        return 0;
    m->size--;
    return *m->data++;
}

static inline unsigned int fuzz_access(const fuzz_master_t *m, uint8_t command, uint16_t address, uint8_t *data,
                                       uint16_t length)
{
    return fuzz_send(m->chain, 1, command, address, data, length);
}

static inline void fuzz_request_state(const fuzz_master_t *m, uint8_t state)
{
    uint8_t control[2] = {(uint8_t)(state | 0x10), 0};
    (void)fuzz_access(m, FPWR, ECT_REG_AL_CONTROL, control, sizeof control);
}

/* Switches two SyncManagers off, for only then they change, and on with these lengths. */
static inline void fuzz_set_sms(const fuzz_master_t *m, unsigned int first, uint16_t out, uint16_t in)
{
    uint8_t block[16] = {0};
    const uint16_t length[] = {out, in};
    (void)fuzz_access(m, FPWR, (uint16_t)(ECT_REG_SM + 8 * first), block, sizeof block);
    for (unsigned int n = 0; n < 2; n++) {
        ect_store_le16(block + 8 * n, m->device->sm[first + n].start);
        ect_store_le16(block + 8 * n + 2, length[n]);
        block[8 * n + 4] = m->device->sm[first + n].control;
        block[8 * n + 6] = 1;
    }
    (void)fuzz_access(m, FPWR, (uint16_t)(ECT_REG_SM + 8 * first), block, sizeof block);
}

static inline void fuzz_write_mail(fuzz_master_t *m, uint8_t type, const uint8_t *data, uint16_t length)
{
    uint8_t mail[FUZZ_MAILBOX] = {0};
    m->counter = (uint8_t)(m->counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | m->counter << 4);
    memcpy(mail + FUZZ_MAIL_HEADER, data, length);
    (void)fuzz_access(m, FPWR, m->device->sm[0].start, mail, sizeof mail);
}

/* Reads a mail, which must have at least 4 bytes, and zeros behind them. @return whether SyncManager 1 had one */
static inline bool fuzz_read_mail(const fuzz_master_t *m, uint8_t mail[FUZZ_MAILBOX])
{
    enum { FULL = 8 };
    uint8_t status = 0;
    (void)fuzz_access(m, FPRD, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS, &status, 1);
    if ((status & FULL) == 0)
        return false;
    memset(mail, 0, FUZZ_MAILBOX);
    assert(fuzz_access(m, FPRD, m->device->sm[1].start, mail, FUZZ_MAILBOX) == 1);
    const uint16_t length = ect_load_le16(mail);
    assert(length >= 4 && length <= FUZZ_MAIL_ROOM);
    for (unsigned int i = FUZZ_MAIL_HEADER + length; i < FUZZ_MAILBOX; i++)
        assert(mail[i] == 0);
    return true;
}

/* Writes a mail of any bytes, and reads a reply if there is one. */
static inline void fuzz_any_mail(fuzz_master_t *m, uint8_t type)
{
    uint8_t data[FUZZ_MAIL_ROOM], mail[FUZZ_MAILBOX];
    const uint8_t length = (uint8_t)(1 + fuzz_next(m) % FUZZ_MAIL_ROOM);
    for (unsigned int i = 0; i < length; i++)
        data[i] = fuzz_next(m);
    fuzz_write_mail(m, type, data, length);
    (void)fuzz_read_mail(m, mail);
}

#endif
