/* SPDX-License-Identifier: MIT */
#define FUZZ_MASTER_WIRE
#include "wire.h"

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/library.h"
#include "calls.h"

enum {
    RECORD = 8,
    RECORDS_MOST = 128,
    BUSES = 8,
    QUEUE = 16,
    FRAME = ECTWIN_FRAME_MAX,
    SOCKET = 1000,
    FRAMES_MOST = 800,   /* limit, after which the wire is dead, and the clock runs fast, so that every timeout ends */
    READING_NS = 1000,   /* cost of reading a clock */
    WAITING_NS = 200000, /* a receive without a frame */
    STRETCH = 100,       /* factor of the length of a sleep, for few polls until a timeout */
    HEADER_AT = 14,      /* of EtherCAT, in a frame */
    DATAGRAM = 10,       /* header of a datagram */
    EEPROM_CONTROL = 0x502, /* registers */
    EEPROM_DATA = 0x508,
    MEMORY = 0x1000, /* mailboxes and process data begin */
};
#define FLYING_NS 20000000000ull

enum { APRD = 1, APWR = 2, FPRD = 4, FPWR = 5, BRD = 7, BWR = 8 };
enum { KIND_EEPROM, KIND_REGISTER, KIND_MAIL, KIND_MAIL_DATA, KIND_FRAME, KINDS };
enum { FRAME_LOST, FRAME_TWICE, FRAME_CUT, FRAME_BYTE, FRAME_LATER, FRAME_COUNTER, FRAME_OPTIONS };

typedef struct record {
    uint8_t kind, option;
    uint16_t which, offset, value;
    const uint8_t *data; /* of mail data */
    size_t data_length;
    unsigned int reads; /* of the register */
} record_t;

typedef struct frame {
    size_t length;
    uint8_t bytes[FRAME];
} frame_t;

static struct {
    const char *devices[BUSES];
    ectwin_bus_t *buses[BUSES], *bus;
    uint64_t now_ns;
    record_t records[RECORDS_MOST];
    size_t record_count;
    frame_t queue[QUEUE];
    size_t first, count;
    bool swap; /* the first reply of the queue waits for the next one */
    unsigned int sent, mails;
    uint16_t eeprom_address;
    bool verbose;
} wire;

static unsigned int load(const uint8_t *p)
{
    return p[0] | (unsigned int)p[1] << 8;
}

static void store(uint8_t *p, unsigned int value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
}

static void note(const record_t *r, const char *place, unsigned int number)
{
    static const char *const kinds[KINDS] = {"EEPROM", "register", "mail", "mail data", "frame"};
    if (wire.verbose)
        fprintf(stderr, "frame %u, %s %u: %s option %u which %u (0x%04X) offset %u value 0x%04X\n", wire.sent, place,
                number, kinds[r->kind], r->option, r->which, r->which, r->offset, r->value);
}

/* --- a run -------------------------------------------------------------------------------------------------------- */

static ectwin_bus_t *bus_of(const char *devices)
{
    for (size_t i = 0; i < BUSES; i++) {
        if (wire.devices[i] == devices)
            return wire.buses[i];
        if (wire.devices[i])
            continue;
        char why[ECTWIN_MESSAGE];
        wire.buses[i] = ectwin_bus_open(1, &devices, wire.now_ns, why);
        if (!wire.buses[i]) {
            fprintf(stderr, "fuzz-master: %s\n", why);
            exit(1);
        }
        wire.devices[i] = devices;
        return wire.buses[i];
    }
    abort();
}

static void read_records(const uint8_t *data, size_t size)
{
    wire.record_count = 0;
    while (size >= RECORD && wire.record_count < RECORDS_MOST) {
        record_t *r = &wire.records[wire.record_count++];
        *r = (record_t){.kind = data[0] % KINDS,
                        .option = data[1],
                        .which = (uint16_t)load(data + 2),
                        .offset = (uint16_t)load(data + 4),
                        .value = (uint16_t)load(data + 6)};
        data += RECORD;
        size -= RECORD;
        if (r->kind != KIND_MAIL_DATA)
            continue;
        size_t length = (size_t)(r->value & 31) * RECORD;
        r->data = data;
        r->data_length = length < size ? length : size;
        data += r->data_length;
        size -= r->data_length;
    }
}

void wire_begin(const char *devices, const uint8_t *records, size_t size)
{
    wire.verbose = getenv("FUZZ_MASTER_VERBOSE") != NULL;
    wire.bus = bus_of(devices);
    ectwin_bus_power_cycle(wire.bus, wire.now_ns);
    read_records(records, size);
    wire.first = wire.count = 0;
    wire.swap = false;
    wire.sent = wire.mails = 0;
    wire.eeprom_address = 0;
}

unsigned int wire_end(void)
{
    wire.bus = NULL;
    return wire.sent;
}

/* --- changes of replies ------------------------------------------------------------------------------------------- */

static void change_eeprom(uint8_t *data, unsigned int ado, unsigned int length)
{
    for (unsigned int at = ado < EEPROM_DATA ? EEPROM_DATA - ado : 0; at + 2 <= length && ado + at < EEPROM_DATA + 8;
         at += 2) {
        unsigned int word = wire.eeprom_address + (ado + at - EEPROM_DATA) / 2;
        for (size_t i = 0; i < wire.record_count; i++) {
            const record_t *r = &wire.records[i];
            if (r->kind != KIND_EEPROM || word - r->which > r->option)
                continue;
            note(r, "word", word);
            store(data + at, r->value);
        }
    }
}

static void change_registers(uint8_t *data, unsigned int ado, unsigned int length)
{
    for (size_t i = 0; i < wire.record_count; i++) {
        record_t *r = &wire.records[i];
        if (r->kind != KIND_REGISTER || r->which < ado || r->which >= ado + length || r->reads++ < r->offset)
            continue;
        note(r, "register", ado);
        data[r->which - ado] = (uint8_t)r->value;
        if ((r->option & 1) && r->which + 1u < ado + length)
            data[r->which - ado + 1] = (uint8_t)(r->value >> 8);
    }
}

static void change_bytes(const record_t *r, uint8_t *data, unsigned int length)
{
    unsigned int width = 1u << (r->option & 3), carry = 0;
    for (unsigned int i = 0; i < width && r->offset + i < length; i++) {
        uint8_t *byte = &data[r->offset + i];
        uint8_t value = (uint8_t)(r->value >> (8 * (i & 1)));
        if (r->option & 4) {
            carry += *byte + value;
            value = (uint8_t)carry;
            carry >>= 8;
        } else if (r->option & 8) {
            value ^= *byte;
        }
        *byte = value;
    }
}

static void change_mail(uint8_t *data, unsigned int length)
{
    for (size_t i = 0; i < wire.record_count; i++) {
        const record_t *r = &wire.records[i];
        if ((r->kind != KIND_MAIL && r->kind != KIND_MAIL_DATA) || (r->which != wire.mails && r->which != UINT16_MAX))
            continue;
        note(r, "mail", wire.mails);
        if (r->kind == KIND_MAIL)
            change_bytes(r, data, length);
        else if (r->offset < length)
            memcpy(data + r->offset, r->data,
                   r->data_length < length - r->offset ? r->data_length : length - r->offset);
    }
    wire.mails++;
}

static void change_datagram(uint8_t *datagram, unsigned int length)
{
    unsigned int command = datagram[0], ado = load(datagram + 4);
    uint8_t *data = datagram + DATAGRAM;
    bool is_read = command == APRD || command == FPRD || command == BRD;
    bool is_write = command == APWR || command == FPWR || command == BWR;
    if (is_write && ado == EEPROM_CONTROL && length >= 4)
        wire.eeprom_address = (uint16_t)load(data + 2);
    if (!is_read)
        return;
    change_eeprom(data, ado, length);
    change_registers(data, ado, length);
    if (command == FPRD && ado >= MEMORY && load(data + length) > 0)
        change_mail(data, length);
}

static void change_datagrams(frame_t *frame)
{
    size_t at = HEADER_AT + 2;
    bool more = true;
    while (more && at + DATAGRAM + 2 <= frame->length) {
        unsigned int word = load(frame->bytes + at + 6), length = word & 0x7FF;
        if (at + DATAGRAM + length + 2 > frame->length)
            return;
        change_datagram(frame->bytes + at, length);
        more = (word & 0x8000) != 0;
        at += DATAGRAM + length + 2;
    }
}

static frame_t *last(void)
{
    return &wire.queue[(wire.first + wire.count - 1) % QUEUE];
}

static void enqueue(const frame_t *frame)
{
    if (wire.count == QUEUE)
        return;
    wire.count++;
    last()->length = frame->length;
    memcpy(last()->bytes, frame->bytes, frame->length);
}

static void queue_reply(frame_t *frame)
{
    bool lost = false, twice = false, later = false;
    for (size_t i = 0; i < wire.record_count; i++) {
        const record_t *r = &wire.records[i];
        if (r->kind != KIND_FRAME || r->which != wire.sent)
            continue;
        note(r, "reply", wire.sent);
        unsigned int option = r->option % FRAME_OPTIONS;
        lost |= option == FRAME_LOST;
        twice |= option == FRAME_TWICE;
        later |= option == FRAME_LATER;
        if (option == FRAME_CUT && r->offset > 0 && r->offset < frame->length)
            frame->length = r->offset;
        if (option == FRAME_BYTE && r->offset < frame->length)
            frame->bytes[r->offset] = (uint8_t)r->value;
        size_t counter = HEADER_AT + 2 + DATAGRAM + (load(frame->bytes + HEADER_AT + 2 + 6) & 0x7FF);
        if (option == FRAME_COUNTER && counter + 2 <= frame->length)
            store(frame->bytes + counter, r->value);
    }
    if (lost)
        return;
    enqueue(frame);
    if (twice)
        enqueue(frame);
    if (wire.swap && wire.count >= 2) {
        frame_t *before = &wire.queue[(wire.first + wire.count - 2) % QUEUE], *behind = last();
        frame_t moved = *before;
        *before = *behind;
        *behind = moved;
    }
    wire.swap = later;
}

/* --- calls of the master ------------------------------------------------------------------------------------------ */

int wire_socket(int domain, int type, int protocol)
{
    (void)domain;
    (void)type;
    (void)protocol;
    return SOCKET;
}

int wire_setsockopt(int fd, int level, int option, const void *value, socklen_t length)
{
    (void)fd;
    (void)level;
    (void)option;
    (void)value;
    (void)length;
    return 0;
}

int wire_ioctl(int fd, unsigned long request, ...)
{
    (void)fd;
    (void)request;
    return 0;
}

int wire_bind(int fd, const struct sockaddr *address, socklen_t length)
{
    (void)fd;
    (void)address;
    (void)length;
    return 0;
}

int wire_close(int fd)
{
    (void)fd;
    return 0;
}

ssize_t wire_send(int fd, const void *data, size_t length, int flags)
{
    static frame_t reply;
    unsigned int end;
    (void)fd;
    (void)flags;
    if (length == 0 || length > FRAME || wire.sent++ >= FRAMES_MOST)
        return (ssize_t)length;
    ectwin_bus_frame(wire.bus, 0, data, length, wire.now_ns);
    while ((reply.length = ectwin_bus_reply(wire.bus, &end, reply.bytes, sizeof reply.bytes)) > 0) {
        change_datagrams(&reply);
        queue_reply(&reply);
    }
    return (ssize_t)length;
}

ssize_t wire_recv(int fd, void *data, size_t room, int flags)
{
    (void)fd;
    (void)flags;
    if (wire.count == 0 || (wire.swap && wire.count == 1)) {
        wire.now_ns += WAITING_NS;
        errno = EAGAIN;
        return -1;
    }
    const frame_t *frame = &wire.queue[wire.first];
    size_t length = frame->length < room ? frame->length : room;
    memcpy(data, frame->bytes, length);
    wire.first = (wire.first + 1) % QUEUE;
    wire.count--;
    return (ssize_t)length;
}

static uint64_t read_clock(void)
{
    wire.now_ns += wire.sent < FRAMES_MOST ? READING_NS : FLYING_NS;
    return wire.now_ns;
}

int wire_clock_gettime(clockid_t clock, struct timespec *time)
{
    uint64_t now_ns = read_clock();
    (void)clock;
    *time = (struct timespec){.tv_sec = (time_t)(now_ns / 1000000000u), .tv_nsec = (long)(now_ns % 1000000000u)};
    return 0;
}

int wire_gettimeofday(struct timeval *time, void *zone)
{
    uint64_t now_ns = read_clock();
    (void)zone;
    *time = (struct timeval){.tv_sec = (time_t)(now_ns / 1000000000u),
                             .tv_usec = (suseconds_t)(now_ns % 1000000000u / 1000)};
    return 0;
}

int wire_nanosleep(const struct timespec *time, struct timespec *left)
{
    (void)left;
    wire.now_ns += STRETCH * ((uint64_t)time->tv_sec * 1000000000u + (uint64_t)time->tv_nsec);
    return 0;
}

int wire_usleep(useconds_t time)
{
    wire.now_ns += STRETCH * (uint64_t)time * 1000;
    return 0;
}
