/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/runner.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
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

/* What the loop waits for: a frame, a signal, users at the control socket. */
typedef struct wait {
    struct pollfd fds[2 + ECT_CONTROL_FDS];
    size_t control_count;
} wait_t;

static int wait_for(const ect_runner_t *r, wait_t *w, uint64_t deadline_ns)
{
    w->fds[0] = (struct pollfd){.fd = r->port->fd, .events = POLLIN};
    w->fds[1] = (struct pollfd){.fd = r->signal_fd, .events = POLLIN};
    w->control_count = r->control ? ect_control_fds(r->control, w->fds + 2) : 0;
    struct timespec timeout = {0};
    struct timespec *limit = NULL;
    if (deadline_ns != ECT_NEVER) {
        uint64_t now = ect_runner_now();
        uint64_t left = deadline_ns > now ? deadline_ns - now : 0;
        timeout.tv_sec = (time_t)(left / NS_PER_S);
        timeout.tv_nsec = (long)(left % NS_PER_S);
        limit = &timeout;
    }
    return ppoll(w->fds, 2 + w->control_count, limit, NULL);
}

/* A late answer holds up those behind it, as a slow wire would. */
static void delay(const ect_faults_t *faults)
{
    const struct timespec pause = {.tv_sec = faults->delay_us / 1000000u,
                                   .tv_nsec = faults->delay_us % 1000000u * 1000};
    (void)nanosleep(&pause, NULL);
}

static int answer(const ect_runner_t *r)
{
    uint8_t frame[FRAME_ROOM];
    ssize_t length = ect_packet_receive(r->port, frame, sizeof frame);
    if (length <= 0)
        return length < 0 ? -1 : 0;
    ect_verdict_t verdict = r->faults ? ect_faults_draw(r->faults) : ECT_VERDICT_PASS;
    if (verdict == ECT_VERDICT_LOSE_REQUEST || !ect_chain_process(r->chain, frame, (size_t)length, ect_runner_now()))
        return 0;
    if (verdict == ECT_VERDICT_DELAY)
        delay(r->faults);
    if (verdict != ECT_VERDICT_LOSE_ANSWER)
        ect_packet_send(r->port, frame, (size_t)length);
    return 0;
}

static bool take_signal(const ect_runner_t *r)
{
    struct signalfd_siginfo info;
    if (read(r->signal_fd, &info, sizeof info) != (ssize_t)sizeof info)
        return true;
    return r->on_signal(r->ctx, (int)info.ssi_signo, info.ssi_code == SI_KERNEL);
}

/* The devices, then those who watch them. */
static uint64_t run_devices(const ect_runner_t *r)
{
    uint64_t now_ns = ect_runner_now();
    uint64_t deadline_ns = ect_chain_poll(r->chain, now_ns);
    uint64_t report_ns = r->control ? ect_control_report(r->control, now_ns) : ECT_NEVER;
    return report_ns < deadline_ns ? report_ns : deadline_ns;
}

int ect_runner_run(const ect_runner_t *r)
{
    uint64_t deadline_ns = run_devices(r);
    for (;;) {
        wait_t w;
        int ready = wait_for(r, &w, deadline_ns);
        if (ready < 0 && errno != EINTR)
            return -1;
        if (ready > 0 && w.fds[0].revents != 0 && answer(r) < 0)
            return -1;
        if (ready > 0 && w.fds[1].revents != 0 && !take_signal(r))
            return 0;
        if (ready > 0 && r->control)
            ect_control_serve(r->control, r->chain, w.fds + 2, w.control_count, ect_runner_now());
        deadline_ns = run_devices(r);
    }
}
