/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "reader/packet.h"

#include <poll.h>
#include <time.h>

#define NS_PER_S UINT64_C(1000000000)

static struct timespec timespec_of(uint64_t ns)
{
    return (struct timespec){.tv_sec = (time_t)(ns / NS_PER_S), .tv_nsec = (long)(ns % NS_PER_S)};
}

static uint64_t now(void *ctx)
{
    (void)ctx;
    return ect_packet_now();
}

static void wait_until(void *ctx, uint64_t until_ns)
{
    const struct timespec until = timespec_of(until_ns);
    (void)ctx;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL) != 0 && ect_packet_now() < until_ns)
        continue;
}

static void send_frame(void *ctx, const uint8_t *frame, size_t length)
{
    ect_packet_send(ctx, frame, length);
}

static size_t receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    ect_packet_t *port = ctx;
    ect_packet_time_t time;
    for (;;) {
        const uint64_t at = ect_packet_now();
        const ssize_t length = ect_packet_receive(port, false, frame, room, &time);
        if (length > 0)
            return (size_t)length;
        if (length == ECT_PACKET_GONE || at >= until_ns)
            return 0;
        struct pollfd one = {.fd = port->fd, .events = POLLIN};
        const struct timespec left = timespec_of(until_ns - at);
        (void)ppoll(&one, 1, &left, NULL);
    }
}

ect_reader_link_t ect_reader_packet_link(ect_packet_t *port)
{
    return (ect_reader_link_t){.ctx = port, .send = send_frame, .receive = receive, .now = now, .wait = wait_until};
}
