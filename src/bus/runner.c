/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/runner.h"

#include <errno.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

enum { NS_PER_S = 1000000000, FRAME_ROOM = ECT_ESC_MAX_FRAME + 48 };

uint64_t ect_runner_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

/* Waits for a frame, a signal or the deadline. */
static int wait_for(const ect_runner_t *r, struct pollfd fds[2], uint64_t deadline_ns)
{
    fds[0] = (struct pollfd){.fd = r->port->fd, .events = POLLIN};
    fds[1] = (struct pollfd){.fd = r->signal_fd, .events = POLLIN};
    struct timespec timeout = {0};
    struct timespec *limit = NULL;
    if (deadline_ns != ECT_NEVER) {
        uint64_t now = ect_runner_now();
        uint64_t left = deadline_ns > now ? deadline_ns - now : 0;
        timeout.tv_sec = (time_t)(left / NS_PER_S);
        timeout.tv_nsec = (long)(left % NS_PER_S);
        limit = &timeout;
    }
    return ppoll(fds, 2, limit, NULL);
}

static int answer(const ect_runner_t *r)
{
    uint8_t frame[FRAME_ROOM];
    ssize_t length = ect_packet_receive(r->port, frame, sizeof frame);
    if (length > 0 && ect_chain_process(r->chain, frame, (size_t)length, ect_runner_now()))
        ect_packet_send(r->port, frame, (size_t)length);
    return length < 0 ? -1 : 0;
}

static bool take_signal(const ect_runner_t *r)
{
    struct signalfd_siginfo info;
    if (read(r->signal_fd, &info, sizeof info) != (ssize_t)sizeof info)
        return true;
    return r->on_signal(r->ctx, (int)info.ssi_signo);
}

int ect_runner_run(const ect_runner_t *r)
{
    uint64_t deadline_ns = ect_chain_poll(r->chain, ect_runner_now());
    for (;;) {
        struct pollfd fds[2];
        if (wait_for(r, fds, deadline_ns) < 0 && errno != EINTR)
            return -1;
        if (fds[0].revents != 0 && answer(r) < 0)
            return -1;
        if (fds[1].revents != 0 && !take_signal(r))
            return 0;
        deadline_ns = ect_chain_poll(r->chain, ect_runner_now());
    }
}
