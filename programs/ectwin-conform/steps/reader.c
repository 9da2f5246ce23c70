/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "steps/reader.h"

#include <string.h>
#include <time.h>

#include "steps/engine.h"

enum { AT_DATAGRAM = 16, AT_DATA = AT_DATAGRAM + 10, LENGTH = 0x07FF, FRAME_MS = 500 };

/* Keeps a frame of the reader from send to receive: the port does both in one exchange. */
static struct link {
    cf_t *c;
    ect_reader_link_t functions;
    ect_reader_t reader;
    uint8_t frame[ECT_READER_FRAME];
    size_t length; /* 0: no frame */
} wire;

static void send_frame(void *ctx, const uint8_t *frame, size_t length)
{
    struct link *w = ctx;
    memcpy(w->frame, frame, length);
    w->length = length;
}

static size_t receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    struct link *w = ctx;
    uint8_t *at = w->frame + AT_DATAGRAM;
    const uint64_t now = cf_now_ns();
    const size_t length = w->length < room ? w->length : room;
    w->length = 0;
    if (length == 0 || now >= until_ns)
        return 0;
    cf_datagram_t d = {.command = at[0],
                       .address = ect_load_le32(at + 2),
                       .length = ect_load_le16(at + 6) & LENGTH,
                       .data = w->frame + AT_DATA};
    if (!cf_port_exchange(w->c->engine->port, &d, 1, (uint32_t)((until_ns - now) / 1000000) + 1))
        return 0;
    ect_store_le32(at + 2, d.address);
    ect_store_le16(w->frame + AT_DATA + d.length, d.wkc);
    memcpy(frame, w->frame, length);
    return length;
}

static uint64_t now_ns(void *ctx)
{
    (void)ctx;
    return cf_now_ns();
}

static void wait_until(void *ctx, uint64_t until_ns)
{
    const struct timespec until = {.tv_sec = (time_t)(until_ns / 1000000000), .tv_nsec = (long)(until_ns % 1000000000)};
    (void)ctx;
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
}

static bool goes_on(void *ctx, const char *what, unsigned int done, unsigned int all)
{
    const struct link *w = ctx;
    (void)what;
    (void)done;
    (void)all;
    return cf_interrupted == 0 || !w->c->engine->running;
}

ect_reader_t *cf_reader_open(cf_t *c)
{
    cf_check_time(c);
    wire.c = c;
    wire.functions =
        (ect_reader_link_t){.ctx = &wire, .send = send_frame, .receive = receive, .now = now_ns, .wait = wait_until};
    const ect_reader_config_t config = {.position = c->facts.position,
                                        .station = c->facts.station,
                                        .frame_ms = FRAME_MS,
                                        .limit_ms = (uint32_t)((c->engine->deadline_ns - cf_now_ns()) / 1000000) + 1,
                                        .counter = c->mail_counter,
                                        .progress_ctx = &wire,
                                        .progress = goes_on};
    const ect_reader_result_t result = ect_reader_open(&wire.reader, &wire.functions, &config);
    if (result != ECT_READER_OK)
        cf_reader_close(c, result);
    return &wire.reader;
}

void cf_reader_close(cf_t *c, ect_reader_result_t result)
{
    ect_reader_close(&wire.reader);
    c->mail_counter = wire.reader.counter;
    if (result == ECT_READER_OK)
        return;
    cf_check_time(c);
    cf_fail(c, "%s", wire.reader.text);
}
