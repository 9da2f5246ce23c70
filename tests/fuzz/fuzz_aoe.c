/* SPDX-License-Identifier: MIT */
/*
 * AoE of one twin beside CoE. The input is a sequence of steps: an operation and its bytes. Each ADS request gets one
 * reply in one mail, whose AMS header repeats the fields of the request; every other mail is well-formed.
 */
#include <assert.h>
#include <string.h>

#include "fuzz/datagram.h"
#include "seams/aoe.h"
#include "support/testdev.h"
#include "wire/bytes.h"
#include "wire/registers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAILBOX = 128, MAIL_HEADER = 6, AMS = 32, ROOM = MAILBOX - MAIL_HEADER, FULL = 8, AOE = 1, COE = 3 };
enum { COMMAND = 16, FLAGS = 18, LENGTH = 20, ERROR = 24, INVOKE = 28, NOTIFICATION = 8, MOST_STEPS = 400 };

typedef struct adsdev {
    testdev_t base;
    ect_aoe_state_t aoe;
} adsdev_t;

typedef struct session {
    ect_chain_t *chain;
    const uint8_t *data;
    size_t size;
    uint8_t counter;
} session_t;

static const ect_device_t *adsdev(void)
{
    static const ect_aoe_t entry = {.protocol = ECT_AOE_PROTOCOL, .offset = offsetof(adsdev_t, aoe)};
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    static ect_device_t device;
    device = testdev_with(&entry.protocol, protocols, ECT_MAILBOX_AOE, sizeof(adsdev_t));
    device.sm[1].minimum = device.sm[1].maximum = 0;
    device.boot_out = device.boot_in = (ect_boot_mailbox_t){0};
    return &device;
}

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

static void start(const session_t *s)
{
    uint8_t block[16] = {0}, preop[2] = {0x12, 0};
    for (unsigned int n = 0; n < 2; n++) {
        ect_store_le16(block + 8 * n, testdev.sm[n].start);
        ect_store_le16(block + 8 * n + 2, testdev.sm[n].length);
        block[8 * n + 4] = testdev.sm[n].control;
        block[8 * n + 6] = 1;
    }
    (void)send(s, FPWR, ECT_REG_SM, block, sizeof block);
    (void)send(s, FPWR, ECT_REG_AL_CONTROL, preop, sizeof preop);
}

static void write_mail(session_t *s, uint8_t type, const uint8_t *data, uint16_t length)
{
    uint8_t mail[MAILBOX] = {0};
    s->counter = (uint8_t)(s->counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | s->counter << 4);
    memcpy(mail + MAIL_HEADER, data, length);
    (void)send(s, FPWR, testdev.sm[0].start, mail, MAILBOX);
}

/* @return whether SM1 had a mail */
static bool read_mail(const session_t *s, uint8_t mail[MAILBOX])
{
    uint8_t status = 0;
    (void)send(s, FPRD, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS, &status, 1);
    if ((status & FULL) == 0)
        return false;
    memset(mail, 0, MAILBOX);
    assert(send(s, FPRD, testdev.sm[1].start, mail, MAILBOX) == 1);
    const uint16_t length = ect_load_le16(mail);
    assert(length >= 4 && length <= ROOM);
    for (unsigned int i = MAIL_HEADER + length; i < MAILBOX; i++)
        assert(mail[i] == 0);
    return true;
}

static void expect_reply(const session_t *s, const uint8_t *request)
{
    uint8_t mail[MAILBOX];
    const uint8_t *ams = mail + MAIL_HEADER;
    const bool silent = (request[FLAGS] & 1) != 0 || ect_load_le16(request + COMMAND) == NOTIFICATION;
    assert(read_mail(s, mail) == !silent);
    if (silent)
        return;
    const uint16_t length = ect_load_le16(mail);
    assert((mail[5] & 0x0F) == AOE && length >= AMS);
    assert(memcmp(ams, request + 8, 8) == 0 && memcmp(ams + 8, request, 8) == 0);
    assert(memcmp(ams + COMMAND, request + COMMAND, 2) == 0 && memcmp(ams + INVOKE, request + INVOKE, 4) == 0);
    assert(ect_load_le16(ams + FLAGS) == 5 && ect_load_le32(ams + LENGTH) == (uint32_t)length - AMS);
    assert((ect_load_le32(ams + ERROR) != 0) == (length == AMS));
}

/* A request with a valid header: command, target, then its parameters. */
static void request(session_t *s)
{
    static const uint32_t groups[] = {ECT_AOE_GROUP_COE, ECT_AOE_GROUP_COE, ECT_AOE_GROUP_COE, ECT_AOE_GROUP_SETUP};
    uint8_t data[ROOM] = {0}, mail[MAILBOX];
    const uint8_t command = next(s), choice = next(s), length = next(s) % (ROOM - AMS + 1);
    while (read_mail(s, mail))
        ;
    data[5] = choice >> 6;
    data[COMMAND] = command % 12;
    data[COMMAND + 1] = command > 250;
    data[FLAGS] = (choice & 0x20) != 0 ? 5 : 4;
    ect_store_le32(data + LENGTH, length);
    data[INVOKE] = choice;
    for (unsigned int i = AMS; i < AMS + (unsigned int)length; i++)
        data[i] = next(s);
    if ((choice & 0x10) == 0 && length >= 4)
        ect_store_le32(data + AMS, groups[choice & 3]);
    write_mail(s, AOE, data, (uint16_t)(AMS + length));
    expect_reply(s, data);
}

static void any_mail(session_t *s, uint8_t type)
{
    uint8_t data[ROOM], mail[MAILBOX];
    const uint8_t length = (uint8_t)(1 + next(s) % ROOM);
    for (unsigned int i = 0; i < length; i++)
        data[i] = next(s);
    write_mail(s, type, data, length);
    (void)read_mail(s, mail);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const ect_twin_config_t twin = ect_twin_default(adsdev(), NULL);
    session_t s = {.data = data, .size = size};
    s.chain = ect_chain_new(&twin, 1, 1);
    if (!s.chain)
        return 0;
    start(&s);
    for (unsigned int n = 0; s.size > 0 && n < MOST_STEPS; n++) {
        const uint8_t step = next(&s);
        if (step % 4 == 3)
            any_mail(&s, step >= 128 ? AOE : COE);
        else
            request(&s);
    }
    assert(ect_chain_slave(s.chain, 0)->state == ECT_STATE_PREOP);
    ect_chain_free(s.chain);
    return 0;
}
