/* SPDX-License-Identifier: MIT */
/*
 * EoE of one twin from both sides: fragments and other mails of a master, frames of a host. The input is a sequence of
 * steps. A reassembly of its own, after EOE-003 to EOE-013, decides which frames must arrive at the host; those of the
 * host must arrive at the master whole, in order and without a gap.
 */
#include <assert.h>
#include <string.h>

#include "bus/eoe/network.h"
#include "fuzz/datagram.h"
#include "support/testdev.h"
#include "wire/bytes.h"
#include "wire/registers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAILBOX = 128, MAIL_HEADER = 6, HEADER = 4, UNIT = 32 };
enum { LAST = 1, STAMPED = 2, SIX_BITS = 0x3F, LONGEST = 1514, TAGGED = 1518, SHORTEST = 14, STAMP = 4, ROOM = 2048 };
enum { EOE = 2, FULL = 96, FIFO = 256, MOST_MAILS = 4096, MOST_STEPS = 400 };

/* A frame in fragments. */
typedef struct assembly {
    bool open;
    unsigned int length, limit, fragment, number;
    uint8_t bytes[ROOM];
} assembly_t;

typedef struct given {
    uint16_t length;
    uint8_t seed;
} given_t;

typedef struct session {
    ect_chain_t *chain;
    ect_network_t *network;
    ect_network_kind_t kind;
    const uint8_t *data;
    size_t size;
    uint8_t counter; /* of the last mail to the twin */
    assembly_t to_twin, to_master;
    given_t given[FIFO]; /* by the host, not yet at the master */
    size_t first, count;
} session_t;

typedef struct netdev {
    testdev_t base;
    ect_eoe_state_t eoe;
} netdev_t;

static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    (void)eoe, (void)instance, (void)port, (void)frame, (void)length;
    return true;
}

static uint16_t fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    (void)eoe, (void)instance, (void)frame, (void)port;
    return 0;
}

static const ect_device_t *netdev(void)
{
    static const ect_eoe_t entry = {ECT_EOE_PROTOCOL, offsetof(netdev_t, eoe), .received = received, .fetch = fetch};
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    static ect_device_t device;
    device = testdev_with(&entry.protocol, protocols, ECT_MAILBOX_EOE, sizeof(netdev_t));
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

static uint16_t next_length(session_t *s)
{
    const uint16_t high = next(s);
    return (uint16_t)((high << 8 | next(s)) % FUZZ_FRAME);
}

static unsigned int send(const session_t *s, uint8_t command, uint16_t address, uint8_t *data, uint16_t length)
{
    return fuzz_send(s->chain, 1, command, address, data, length);
}

static void request_state(const session_t *s, uint8_t request)
{
    uint8_t bytes[2] = {request, 0};
    (void)send(s, FPWR, ECT_REG_AL_CONTROL, bytes, 2);
}

/* INIT and PREOP: half frames of both directions and the queues are forgotten (EOE-051). */
static void restart(session_t *s)
{
    uint8_t block[16] = {0};
    request_state(s, 0x11);
    for (unsigned int n = 0; n < 2; n++) {
        const ect_sm_t *sm = &testdev.sm[n];
        ect_store_le16(block + 8 * n, sm->start);
        ect_store_le16(block + 8 * n + 2, sm->length);
        block[8 * n + 4] = sm->control;
        block[8 * n + 6] = 1;
    }
    (void)send(s, FPWR, ECT_REG_SM, block, sizeof block);
    request_state(s, 0x12);
    assert(ect_chain_slave(s->chain, 0)->state == 2);
    s->to_twin.open = s->to_master.open = false;
    s->count = 0;
    s->counter = 0;
}

static bool is_good_length(const uint8_t *frame, unsigned int length)
{
    return length >= SHORTEST && (length <= LONGEST || (length <= TAGGED && frame[12] == 0x81 && frame[13] == 0));
}

/* --- to the master ------------------------------------------------------------------------------------------------ */

static void fill(uint8_t *frame, const given_t *given)
{
    for (unsigned int i = 0; i < given->length; i++)
        frame[i] = (uint8_t)(given->seed + i * 7 + i / 256);
    frame[12] = given->seed & 1 ? 0x81 : 0x08;
    frame[13] = 0;
}

static void check_given(session_t *s, const assembly_t *a)
{
    uint8_t frame[ROOM];
    if (s->kind != ECT_NETWORK_HOST)
        return;
    assert(s->count > 0);
    const given_t *given = &s->given[s->first];
    fill(frame, given);
    assert(a->length == given->length && memcmp(a->bytes, frame, a->length) == 0);
    s->first = (s->first + 1) % FIFO;
    s->count--;
}

static void take_fragment(session_t *s, const uint8_t *data, unsigned int length)
{
    assembly_t *a = &s->to_master;
    const unsigned int word = ect_load_le16(data + 2), bytes = length - HEADER;
    const bool last = (data[1] & LAST) != 0;
    assert(((word & SIX_BITS) == 0) == !a->open); /* frames are never mixed, and each one ends */
    if (!a->open)
        *a = (assembly_t){.open = true, .limit = (word >> 6 & SIX_BITS) * UNIT, .number = word >> 12};
    assert((word & SIX_BITS) == a->fragment++ && word >> 12 == a->number && data[0] >> 4 <= 1);
    assert(a->length == 0 || (word >> 6 & SIX_BITS) * UNIT == a->length);
    assert(bytes > 0 && (last || bytes % UNIT == 0) && a->length + bytes <= a->limit);
    memcpy(a->bytes + a->length, data + HEADER, bytes);
    a->length += bytes;
    if (!last)
        return;
    a->open = false;
    assert(is_good_length(a->bytes, a->length));
    check_given(s, a);
}

/* @return whether there was one */
static bool read_mail(session_t *s)
{
    uint8_t mail[MAILBOX] = {0};
    if (send(s, FPRD, testdev.sm[1].start, mail, MAILBOX) != 1)
        return false;
    const unsigned int length = ect_load_le16(mail), counter = mail[5] >> 4;
    assert(length >= HEADER && length <= MAILBOX - MAIL_HEADER && counter >= 1 && counter <= 7);
    if ((mail[5] & 0x0F) == EOE && (mail[MAIL_HEADER] & 0x0F) == 0)
        take_fragment(s, mail + MAIL_HEADER, length);
    return true;
}

static void give(session_t *s)
{
    uint8_t frame[ROOM] = {0};
    const uint16_t length = next_length(s);
    const given_t given = {length, next(s)};
    if (s->kind != ECT_NETWORK_HOST)
        return;
    fill(frame, &given);
    if (is_good_length(frame, length) && ect_network_room(s->network) > 0) {
        assert(s->count < FIFO);
        s->given[(s->first + s->count++) % FIFO] = given;
    }
    ect_network_push(s->network, frame, length);
    ect_chain_wake(s->chain, 0);
    (void)ect_chain_poll(s->chain, 1);
}

/* --- to the twin -------------------------------------------------------------------------------------------------- */

/* @return whether a fragment completes a frame that the twin must take */
static bool assemble(assembly_t *a, const uint8_t *data, unsigned int length)
{
    const unsigned int word = ect_load_le16(data + 2), bytes = length - HEADER, units = word >> 6 & SIX_BITS;
    const bool last = (data[1] & LAST) != 0;
    const unsigned int stamp = last && (data[1] & STAMPED) != 0 ? STAMP : 0;
    if ((word & SIX_BITS) == 0)
        *a = (assembly_t){.open = true, .limit = units * UNIT, .number = word >> 12};
    else if ((word & SIX_BITS) != a->fragment || word >> 12 != a->number || units * UNIT != a->length)
        a->open = false; /* EOE-004 */
    if (a->length + bytes > a->limit || a->length + bytes > TAGGED + STAMP || bytes < stamp)
        a->open = false; /* EOE-007, EOE-010 */
    if (!last && (bytes == 0 || bytes % UNIT != 0))
        a->open = false; /* EOE-008 */
    if (!a->open)
        return false;
    memcpy(a->bytes + a->length, data + HEADER, bytes);
    a->length += bytes;
    a->fragment++;
    a->open = !last;
    a->length -= stamp;
    return last && data[0] >> 4 <= 1 && is_good_length(a->bytes, a->length);
}

static void check_host(session_t *s, bool arrives)
{
    uint16_t length = 0;
    const uint8_t *frame = ect_network_peek(s->network, &length);
    if (s->kind != ECT_NETWORK_HOST)
        return;
    assert((frame != NULL) == arrives);
    if (!frame)
        return;
    assert(length == s->to_twin.length && memcmp(frame, s->to_twin.bytes, length) == 0);
    ect_network_next(s->network, true);
    assert(!ect_network_peek(s->network, &length));
}

static bool write_once(session_t *s, uint8_t type, const uint8_t *data, uint16_t length)
{
    uint8_t mail[MAILBOX] = {0};
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | s->counter << 4);
    memcpy(mail + MAIL_HEADER, data, length);
    return send(s, FPWR, testdev.sm[0].start, mail, MAILBOX) == 1;
}

static void read_all(session_t *s)
{
    for (unsigned int n = 0; read_mail(s); n++)
        assert(n < MOST_MAILS);
}

/* A mail with a good header. The twin takes it when its own ones have been read. */
static void write_mail(session_t *s, uint8_t type, const uint8_t *data, uint16_t length)
{
    bool arrives = false;
    s->counter = (uint8_t)(s->counter % 7 + 1);
    while (!write_once(s, type, data, length)) {
        const bool read = read_mail(s);
        assert(read);
    }
    if (type == EOE && length >= HEADER && (data[0] & 0x0F) == 0)
        arrives = assemble(&s->to_twin, data, length);
    read_all(s);
    check_host(s, arrives);
}

static void write_any(session_t *s, uint8_t type)
{
    uint8_t data[MAILBOX];
    const uint8_t length = next(s) % (MAILBOX - MAIL_HEADER + 1);
    for (unsigned int i = 0; i < length; i++)
        data[i] = next(s);
    write_mail(s, type, data, length);
}

/* Number, size or offset, frame number, flags and length of a fragment; its content is one byte and the place. */
static void write_fragment(session_t *s, unsigned int word, uint8_t flags, unsigned int bytes)
{
    uint8_t data[MAILBOX] = {0, flags};
    const uint8_t seed = next(s);
    ect_store_le16(data + 2, (uint16_t)word);
    for (unsigned int i = 0; i < bytes; i++)
        data[HEADER + i] = (uint8_t)(seed + i);
    write_mail(s, EOE, data, (uint16_t)(HEADER + bytes));
}

static void write_one(session_t *s)
{
    const unsigned int fragment = next(s) & SIX_BITS, units = next(s) & SIX_BITS, number = next(s) & 0x0F;
    const uint8_t flags = next(s);
    write_fragment(s, fragment | units << 6 | number << 12, flags, next(s) % (MAILBOX - MAIL_HEADER - HEADER + 1));
}

/* A whole frame, but one fragment is omitted or has one bit of its header changed. */
static void write_frame(session_t *s)
{
    const unsigned int length = next_length(s), number = next(s) & 0x0F, wrong = next(s), bit = next(s) % 32;
    for (unsigned int from = 0, fragment = 0; from < length; from += FULL, fragment++) {
        const unsigned int bytes = length - from < FULL ? length - from : FULL;
        const unsigned int units = fragment == 0 ? (length + UNIT - 1) / UNIT : from / UNIT;
        unsigned int word = fragment | (units & SIX_BITS) << 6 | number << 12;
        if (fragment == wrong && bit >= 16)
            continue;
        if (fragment == wrong)
            word ^= 1u << bit;
        write_fragment(s, word, from + bytes == length ? LAST : 0, bytes);
    }
}

static void step(session_t *s)
{
    switch (next(s) % 8) {
    case 0:
        write_any(s, EOE);
        break;
    case 1:
        write_any(s, next(s) & 0x0F);
        break;
    case 2:
    case 3:
        write_one(s);
        break;
    case 4:
        write_frame(s);
        break;
    case 5:
        give(s);
        break;
    case 6:
        (void)read_mail(s);
        break;
    default:
        restart(s);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    session_t s = {.data = data, .size = size};
    ect_twin_config_t twin = ect_twin_default(netdev(), NULL);
    s.kind = next(&s) % 2 == 0 ? ECT_NETWORK_HOST : ECT_NETWORK_ECHO;
    s.network = ect_network_new(twin.device, s.kind);
    assert(s.network);
    ect_network_join(s.network, &twin);
    s.chain = ect_chain_new(&twin, 1, 1);
    assert(s.chain);
    restart(&s);
    for (unsigned int n = 0; n < MOST_STEPS && s.size > 0; n++)
        step(&s);
    read_all(&s);
    assert(s.count == 0 && !s.to_master.open);
    ect_chain_free(s.chain);
    ect_network_free(s.network);
    return 0;
}
