/* SPDX-License-Identifier: MIT */
/*
 * The mailbox of one twin under a master, CoE and FoE, from PREOP on. The input is a sequence of steps: an operation
 * and its bytes. Every reply must be well-formed.
 */
#include <assert.h>
#include <string.h>

#include "fuzz/datagram.h"
#include "support/filedev.h"
#include "wire/bytes.h"
#include "wire/registers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAILBOX = 128 };

typedef struct session {
    ect_chain_t *chain;
    uint64_t now_ns;
    const uint8_t *data;
    size_t size;
} session_t;

static uint8_t next(session_t *s)
{
    if (s->size == 0)
        return 0;
    s->size--;
    return *s->data++;
}

static unsigned int send(session_t *s, uint8_t command, uint16_t address, uint8_t *data, uint16_t length)
{
    return fuzz_send(s->chain, s->now_ns, command, address, data, length);
}

static void set_sms(session_t *s)
{
    uint8_t block[32] = {0};
    for (unsigned int n = 0; n < 4; n++) {
        const ect_sm_t *sm = &testdev.sm[n];
        ect_store_le16(block + 8 * n, sm->start);
        ect_store_le16(block + 8 * n + 2, sm->length);
        block[8 * n + 4] = sm->control;
        block[8 * n + 6] = 1;
    }
    (void)send(s, FPWR, ECT_REG_SM, block, sizeof block);
}

static void request_state(session_t *s, uint8_t request)
{
    uint8_t bytes[2] = {request, 0};
    (void)send(s, FPWR, ECT_REG_AL_CONTROL, bytes, 2);
}

static void write_mail(session_t *s)
{
    uint8_t mail[MAILBOX] = {0};
    uint8_t length = next(s) % (MAILBOX + 1);
    for (unsigned int i = 0; i < length; i++)
        mail[i] = next(s);
    (void)send(s, FPWR, testdev.sm[0].start, mail, MAILBOX);
}

/* A request with a valid header, so that the fuzzer reaches the code behind the header check. */
static void write_sdo(session_t *s, uint8_t service)
{
    uint8_t mail[MAILBOX] = {0};
    uint8_t length = next(s) % (MAILBOX - 5);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(3 | (next(s) & 0x70));
    mail[7] = (uint8_t)(service << 4);
    for (unsigned int i = 8; i < 6u + length && i < MAILBOX; i++)
        mail[i] = next(s);
    (void)send(s, FPWR, testdev.sm[0].start, mail, MAILBOX);
}

/* Existing names, packets in order, and anything else. */
static void write_foe(session_t *s)
{
    static const char *const names[] = {"data", "secret", "constant", "checked"};
    uint8_t mail[MAILBOX] = {0};
    uint8_t operation = next(s), length = next(s) % (MAILBOX - 11);
    mail[5] = (uint8_t)(4 | (next(s) & 0x70));
    mail[6] = operation & 7;
    mail[8] = next(s);
    if ((operation & 0x80) != 0) {
        const char *name = names[operation >> 5 & 3];
        length = (uint8_t)strlen(name);
        memcpy(mail + 12, name, length);
    } else {
        memset(mail + 12, next(s), length);
    }
    ect_store_le16(mail, (uint16_t)(6 + length));
    (void)send(s, FPWR, testdev.sm[0].start, mail, MAILBOX);
}

static void read_mail(session_t *s)
{
    uint8_t mail[MAILBOX] = {0};
    uint8_t activate = 0;
    (void)send(s, FPRD, ECT_REG_SM + 8 + ECT_SM_ACTIVATE, &activate, 1);
    bool memory_only = (activate & ECT_SM_ACTIVATE_ENABLE) == 0; /* no mailbox: any content is valid */
    if (send(s, FPRD, testdev.sm[1].start, mail, MAILBOX) != 1 || memory_only)
        return;
    uint16_t length = ect_load_le16(mail);
    uint8_t counter = mail[5] >> 4;
    uint8_t type = mail[5] & 0x0F;
    assert(length >= 4 && length <= MAILBOX - 6);
    assert(counter >= 1 && counter <= 7);
    assert(type == 0 || type == 3 || type == 4);
    for (unsigned int i = 6u + length; i < MAILBOX; i++)
        assert(mail[i] == 0);
}

static void step(session_t *s)
{
    uint8_t byte;
    switch (next(s) % 12) {
    case 0:
        write_mail(s);
        break;
    case 1:
    case 2:
        write_sdo(s, 2);
        break;
    case 3:
        write_sdo(s, 8);
        break;
    case 4:
    case 5:
        read_mail(s);
        break;
    case 6: /* SM1 activate: repeat toggle, or off */
        byte = next(s);
        (void)send(s, FPWR, ECT_REG_SM + 8 + ECT_SM_ACTIVATE, &byte, 1);
        break;
    case 7:
        request_state(s, next(s));
        break;
    case 8:
        set_sms(s);
        break;
    case 10:
    case 11:
        write_foe(s);
        break;
    default:
        s->now_ns += next(s) * 1000000ull;
        (void)ect_chain_poll(s->chain, s->now_ns);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const ect_twin_config_t twin = ect_twin_default(filedev(), NULL);
    session_t s = {.now_ns = 1, .data = data, .size = size};
    s.chain = ect_chain_new(&twin, 1, s.now_ns);
    if (!s.chain)
        return 0;
    set_sms(&s);
    request_state(&s, 0x12);
    while (s.size > 0)
        step(&s);
    const ect_slave_t *slave = ect_chain_slave(s.chain, 0);
    assert(slave->state == 1 || slave->state == 2 || slave->state == 3 || slave->state == 4 || slave->state == 8);
    ect_chain_free(s.chain);
    return 0;
}
