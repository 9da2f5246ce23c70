/* SPDX-License-Identifier: MIT */
/* A player on a bus of twins, in virtual time. */
#ifndef TESTS_UNIT_ENI_BUS_OF_TWINS_H
#define TESTS_UNIT_ENI_BUS_OF_TWINS_H

#include "from_text.h"

#include "bus/library.h"
#include "eni/play.h"
#include "wire/bytes.h"

enum { LINES_ROOM = 4000 };

typedef struct bus_of_twins {
    ectwin_bus_t *bus;
    uint64_t now_ns;
    ect_eni_wire_t wire;
    char lines[LINES_ROOM]; /* reported, each with its end */
} bus_of_twins_t;

/* A frame of datagrams (ETG.1000.4 clause 5.3): broadcast, of the shortest length, its rest and counters zero. */
static inline void expect_frame(const uint8_t *frame, size_t length)
{
    enum { HEADERS = 16, DATAGRAM = 10, COUNTER = 2, SHORTEST = 60, LENGTH = 0x07FF, MORE = 0x8000 };
    static const uint8_t header[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0, 0, 0, 1, 0x88, 0xA4};
    const size_t end = HEADERS + (ect_load_le16(frame + 14) & LENGTH);
    size_t at = HEADERS;
    assert_memory_equal(frame, header, sizeof header);
    assert_int_equal(ect_load_le16(frame + 14) >> 11, 2); /* type 1 */
    assert_int_equal(length, end > SHORTEST ? end : SHORTEST);
    for (bool more = true; more;) {
        const size_t bytes = ect_load_le16(frame + at + 6) & LENGTH;
        more = (ect_load_le16(frame + at + 6) & MORE) != 0;
        assert_int_equal(ect_load_le16(frame + at + 6) & 0x7800, 0);
        assert_int_equal(ect_load_le16(frame + at + 8), 0);
        at += DATAGRAM + bytes + COUNTER;
        assert_true(at <= end);
        assert_int_equal(ect_load_le16(frame + at - COUNTER), 0);
    }
    assert_int_equal(at, end);
    for (; at < length; at++)
        assert_int_equal(frame[at], 0);
}

static inline bool bus_exchange(void *ctx, uint8_t *frame, size_t length)
{
    bus_of_twins_t *b = ctx;
    unsigned int end = 0;
    expect_frame(frame, length);
    ectwin_bus_frame(b->bus, 0, frame, length, b->now_ns);
    return ectwin_bus_reply(b->bus, &end, frame, length) == length;
}

static inline void bus_wait(void *ctx, uint64_t ns)
{
    bus_of_twins_t *b = ctx;
    const uint64_t until = b->now_ns + ns;
    while (b->now_ns < until) {
        const uint64_t next = ectwin_bus_run(b->bus, b->now_ns);
        b->now_ns = next > b->now_ns && next < until ? next : until;
    }
    (void)ectwin_bus_run(b->bus, b->now_ns);
}

static inline void bus_report(void *ctx, const char *line)
{
    bus_of_twins_t *b = ctx;
    size_t used = strlen(b->lines);
    (void)snprintf(b->lines + used, sizeof b->lines - used, "%s\n", line);
}

static inline void bus_open(bus_of_twins_t *b, int count, const char *const words[])
{
    char why[ECTWIN_MESSAGE] = "";
    memset(b, 0, sizeof *b);
    b->now_ns = 1000000000;
    b->wire = (ect_eni_wire_t){.ctx = b, .exchange = bus_exchange, .wait = bus_wait, .report = bus_report};
    b->bus = ectwin_bus_open(count, words, b->now_ns, why);
    if (b->bus == NULL)
        fail_msg("%s", why);
}

#endif
