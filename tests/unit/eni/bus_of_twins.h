/* SPDX-License-Identifier: MIT */
/* A player on a bus of twins, in virtual time. */
#ifndef TESTS_UNIT_ENI_BUS_OF_TWINS_H
#define TESTS_UNIT_ENI_BUS_OF_TWINS_H

#include "from_text.h"

#include "bus/library.h"
#include "eni/play.h"

enum { LINES_ROOM = 4000 };

typedef struct bus_of_twins {
    ectwin_bus_t *bus;
    uint64_t now_ns;
    ect_eni_wire_t wire;
    char lines[LINES_ROOM]; /* reported, each with its end */
} bus_of_twins_t;

static inline bool bus_exchange(void *ctx, uint8_t *frame, size_t length)
{
    bus_of_twins_t *b = ctx;
    unsigned int end = 0;
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
