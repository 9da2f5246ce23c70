/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/runner.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

enum { NS_PER_S = 1000000000, FRAME_ROOM = ECT_ESC_MAX_FRAME + 48 };

/* What the loop waits for: a frame at each end, without a VLAN tag or with one, a signal, a cable, users at the control
 * socket, Modbus clients. */
enum { TAGGED_FD = ECT_ENDS, TAGGED_OUT_FD, SIGNAL_FD, LINK_FD, CONTROL_FD, MODBUS_FD, WAITABLE };

/* Frames in a row after which a client is served although another one waits. */
enum { FRAMES_FIRST = 8 };

/* How long frames alone are waited for, until others are looked at. */
enum { FRAMES_ALONE_NS = 500000 };

/* How long frames are looked for in a row, without waiting, until others are looked at (--busy-poll). */
enum { SPIN_NS = 100000 };

/* Times that the devices have asked for and that have passed: how many of them are made up for in a row. */
enum { CATCH_UP = 64 };

/* Also where it is interrupted, `fds` says what has come: nothing. */
static int wait_for(const ect_runner_t *r, struct pollfd fds[WAITABLE], uint64_t deadline_ns)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        const ect_packet_t *port = r->ports[end];
        fds[end] = (struct pollfd){.fd = port ? port->fd : -1, .events = POLLIN};
        fds[TAGGED_FD + end] = (struct pollfd){.fd = port ? port->tagged_fd : -1, .events = POLLIN};
    }
    fds[SIGNAL_FD] = (struct pollfd){.fd = r->signal_fd, .events = POLLIN};
    fds[LINK_FD] = (struct pollfd){.fd = r->link_fd, .events = POLLIN};
    fds[CONTROL_FD] =
        (struct pollfd){.fd = r->control && !r->resting ? ect_control_fd(r->control) : -1, .events = POLLIN};
    fds[MODBUS_FD] =
        (struct pollfd){.fd = r->modbus && !r->resting ? ect_modbus_server_fd(r->modbus) : -1, .events = POLLIN};
    struct timespec timeout = {0};
    struct timespec *limit = NULL;
    if (deadline_ns != ECT_NEVER) {
        uint64_t now = ect_packet_now();
        uint64_t left = deadline_ns > now ? deadline_ns - now : 0;
        timeout.tv_sec = (time_t)(left / NS_PER_S);
        timeout.tv_nsec = (long)(left % NS_PER_S);
        limit = &timeout;
    }
    return ppoll(fds, WAITABLE, limit, NULL);
}

static void send_out(ect_runner_t *r, ect_end_t end, const uint8_t *frame, size_t length)
{
    ect_endless_sent(&r->circles[end], frame, length);
    ect_packet_send(r->ports[end], frame, length);
}

/* An answer that is late on purpose, and those behind it. */
static void keep(ect_runner_t *r, ect_end_t end, const uint8_t *frame, size_t length, uint64_t due_ns)
{
    if (ect_late_add(&r->late[end], frame, length, due_ns))
        r->stats.delayed++;
    else
        r->stats.dropped++;
}

static void send_late(ect_runner_t *r, uint64_t now_ns)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        ect_late_frame_t *late;
        while ((late = ect_late_take(&r->late[end], now_ns))) {
            send_out(r, end, late->frame, late->length);
            r->stats.answered++;
            free(late);
        }
    }
}

/* Whether somebody at the other end answers our answers; told once. */
static bool circles(ect_runner_t *r, ect_end_t end, const uint8_t *frame, size_t length, uint64_t now_ns)
{
    if (!ect_endless_received(&r->circles[end], frame, length, now_ns))
        return false;
    if (r->stats.circling++ == 0)
        r->on_circling(r->ctx, r->ports[end]->iface);
    return true;
}

/* The chain is touched at that time: the devices run at it first. */
static void touch(ect_runner_t *r, uint64_t now_ns)
{
    r->polled_ns = r->touched_ns = now_ns;
}

static uint64_t touch_now(ect_runner_t *r)
{
    touch(r, ect_packet_now());
    return r->touched_ns;
}

static ect_end_t through(ect_runner_t *r, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    const ect_filter_t *filter = r->filter;
    if (filter)
        filter->before(filter->ctx, r->chain, frame, length);
    ect_end_t out = ect_chain_pass(r->chain, in, frame, length, now_ns);
    if (filter && out != ECT_END_NONE)
        filter->after(filter->ctx, r->chain, frame, length);
    return out;
}

/* Those that had to wait for it leave behind it. */
static void send_with_others(ect_runner_t *r, ect_end_t end, const uint8_t *frame, size_t length, bool twice)
{
    ect_late_frame_t *behind;
    send_out(r, end, frame, length);
    if (twice)
        send_out(r, end, frame, length);
    while ((behind = ect_late_take(&r->behind[end], UINT64_MAX))) {
        send_out(r, end, behind->frame, behind->length);
        r->stats.answered++;
        free(behind);
    }
}

/* An answer, on its way out: at once, late, or behind the next one. */
static void answer_with(ect_runner_t *r, ect_end_t out, const uint8_t *frame, size_t length, const ect_fate_t *fate,
                        const ect_packet_time_t *time)
{
    if (fate->behind_next) {
        if (!ect_late_add(&r->behind[out], frame, length, 0))
            r->stats.dropped++;
    } else if (fate->delay_us > 0 || r->late[out].first) {
        keep(r, out, frame, length, time->now_ns + 1000ull * fate->delay_us);
    } else {
        send_with_others(r, out, frame, length, fate->twice);
        r->answered_ns = ect_packet_now();
        ect_stats_answer(&r->stats, time->waited_ns + (r->answered_ns - time->now_ns));
    }
}

/* Those that are set or to come, and the frames that they keep; NULL: there are none. */
static ect_scenario_t *faults_of(const ect_runner_t *r)
{
    return r->scenario && !ect_scenario_rests(r->scenario) ? r->scenario : NULL;
}

/* Frames that were kept on a wire and go on now. */
static void release_kept(ect_runner_t *r)
{
    ect_kept_t *kept;
    ect_scenario_t *faults = faults_of(r);
    uint64_t due_ns = faults ? ect_wires_due(&faults->wires) : ECT_NEVER;
    if (due_ns == ECT_NEVER || due_ns > ect_packet_now())
        return;
    uint64_t now_ns = touch_now(r);
    while ((kept = ect_wires_release(&faults->wires, r->chain, now_ns))) {
        if (kept->end != ECT_END_NONE && r->late[kept->end].first) {
            keep(r, kept->end, kept->frame, kept->at.length, now_ns);
        } else if (kept->end != ECT_END_NONE) {
            send_with_others(r, kept->end, kept->frame, kept->at.length, false);
            r->stats.answered++;
        }
        free(kept);
    }
}

static void pass(ect_runner_t *r, ect_end_t in, uint8_t *frame, size_t length, const ect_packet_time_t *time)
{
    touch(r, time->now_ns);
    ect_scenario_t *faults = faults_of(r);
    ect_fate_t fate = {0};
    if (faults)
        fate = ect_scenario_frame(faults, r->chain, frame, &length, time->now_ns);
    ect_end_t out = fate.lose_request ? ECT_END_NONE : through(r, in, frame, length, time->now_ns);
    ect_wires_result_t on_wires = faults ? ect_scenario_answer(faults, &fate, frame, &length) : ECT_WIRES_PASSED;
    if (fate.lose_request || (fate.lose_answer && out != ECT_END_NONE) || on_wires == ECT_WIRES_LOST)
        r->stats.dropped++;
    else if (out != ECT_END_NONE)
        answer_with(r, out, frame, length, &fate, time);
    else if (on_wires == ECT_WIRES_KEEP)
        r->stats.delayed++;
    else
        r->stats.unanswered++;
    release_kept(r);
}

/* Longer than any frame of EtherCAT, and its end was not even kept: the controllers count it, and nobody answers. */
static void refuse_long(ect_runner_t *r, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    touch(r, now_ns);
    (void)ect_chain_pass(r->chain, in, frame, length, now_ns);
    r->stats.unanswered++;
}

static void follow_cables(ect_runner_t *r)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        r->linked[end] = r->ports[end] && (r->link_fd < 0 || ect_packet_has_link(r->ports[end]));
        ect_chain_set_link(r->chain, end, r->linked[end]);
    }
}

/* @return 1: a frame came; 0: none; -1: the interface is gone */
static int answer(ect_runner_t *r, ect_end_t in, bool wait)
{
    uint8_t frame[FRAME_ROOM];
    ect_packet_time_t time;
    ssize_t length = ect_packet_receive(r->ports[in], wait, frame, sizeof frame, &time);
    if (length == ECT_PACKET_NONE || length == ECT_PACKET_GONE)
        return (int)length;
    if (!r->linked[in])
        follow_cables(r); /* the frame comes before the news that a cable is in again: Linux takes up to a second */
    r->stats.frames++;
    if (length == ECT_PACKET_STALE)
        r->stats.stale++;
    else if ((size_t)length > sizeof frame)
        refuse_long(r, in, frame, (size_t)length, time.now_ns);
    else if (!circles(r, in, frame, (size_t)length, r->polled_ns))
        pass(r, in, frame, (size_t)length, &time);
    return 1;
}

static bool take_signal(const ect_runner_t *r)
{
    struct signalfd_siginfo info;
    if (read(r->signal_fd, &info, sizeof info) != (ssize_t)sizeof info)
        return true;
    return r->on_signal(r->ctx, (int)info.ssi_signo, info.ssi_code == SI_KERNEL);
}

/* At the times they have asked for, also when the loop is late: what is on for a moment only is seen by those who want
 * every change. Time never goes back. */
static void poll_devices(ect_runner_t *r, uint64_t now_ns)
{
    uint64_t next_ns = ect_earlier(r->deadline_ns, r->touched_ns);
    r->touched_ns = ECT_NEVER;
    for (unsigned int i = 1; i <= CATCH_UP; i++) {
        bool late = next_ns < now_ns && i < CATCH_UP;
        r->polled_ns = late ? ect_later(next_ns, r->polled_ns) : now_ns;
        next_ns = ect_chain_poll(r->chain, r->polled_ns);
        if (r->control)
            ect_control_note(r->control, r->chain, r->polled_ns);
        if (next_ns > now_ns)
            break;
    }
    r->deadline_ns = next_ns;
}

/* When clients want to be served by themselves; while the loop rests from them, when that is over. */
static uint64_t clients_due(const ect_runner_t *r)
{
    uint64_t control_ns = r->control ? ect_control_due(r->control) : ECT_NEVER;
    uint64_t modbus_ns = r->modbus ? ect_modbus_server_due(r->modbus) : ECT_NEVER;
    return r->resting ? r->rested_ns : ect_earlier(control_ns, modbus_ns);
}

/* Late answers, the devices, then those who watch them. @return when to be here again */
static uint64_t run_devices(ect_runner_t *r)
{
    release_kept(r);
    uint64_t now_ns = r->answered_ns != 0 ? ect_later(r->answered_ns, r->polled_ns) : ect_packet_now();
    r->answered_ns = 0;
    send_late(r, now_ns);
    ect_stats_poll(&r->stats, now_ns > r->deadline_ns ? now_ns - r->deadline_ns : 0);
    poll_devices(r, now_ns);
    r->resting = now_ns < r->rested_ns;
    uint64_t late_ns = ect_earlier(ect_late_due(&r->late[ECT_END_IN]), ect_late_due(&r->late[ECT_END_OUT]));
    ect_scenario_t *faults = faults_of(r);
    uint64_t fault_ns = faults ? ect_scenario_tick(faults, r->chain, r->polled_ns) : ECT_NEVER;
    return ect_earlier(ect_earlier(r->deadline_ns, fault_ns), ect_earlier(clients_due(r), late_ns));
}

/* Frames first: a client is served when none came, or too many have come one after another. */
static void serve_clients(ect_runner_t *r, bool frame, const struct pollfd fds[WAITABLE])
{
    if (r->resting || !(r->control || r->modbus))
        return;
    uint64_t now_ns = ect_packet_now();
    bool control = r->control && (fds[CONTROL_FD].revents != 0 || now_ns >= ect_control_due(r->control));
    bool modbus = r->modbus && (fds[MODBUS_FD].revents != 0 || now_ns >= ect_modbus_server_due(r->modbus));
    if (!(control || modbus))
        return;
    if (frame && ++r->frames_first < FRAMES_FIRST)
        return;
    r->frames_first = 0;
    r->modbus_next = control && !(modbus && r->modbus_next); /* they take turns */
    if (r->modbus_next)
        ect_control_serve(r->control, r->chain, touch_now(r));
    else
        ect_modbus_server_serve(r->modbus, r->chain, touch_now(r));
    r->rested_ns = ect_packet_now() + r->control_rest_ns;
}

/*
 * While frames come, the next one is waited for in the call that receives it: that is the shortest way to an answer.
 * All others, users and signals, are looked at every half millisecond, and when none has come for a while.
 */
static bool may_linger(const ect_runner_t *r, uint64_t wake_ns)
{
    const ect_packet_t *port = r->ports[ECT_END_IN];
    if (!port || r->ports[ECT_END_OUT])
        return false;
    return r->busy_poll || (r->frames_come && port->patience_ns != 0 && wake_ns > r->polled_ns + port->patience_ns);
}

/* @return as answer() */
static int linger(ect_runner_t *r, uint64_t wake_ns)
{
    if (!r->busy_poll)
        return answer(r, ECT_END_IN, true);
    const uint64_t end_ns = ect_earlier(wake_ns, ect_packet_now() + SPIN_NS);
    int got = 0;
    while (got == 0 && ect_packet_now() < end_ns)
        got = answer(r, ECT_END_IN, false);
    return got;
}

/* @return 1: go on; 0: stop; -1: an interface is gone */
static int serve(ect_runner_t *r, const struct pollfd fds[WAITABLE])
{
    bool frame = false;
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        bool came = fds[end].revents != 0 || fds[TAGGED_FD + end].revents != 0;
        frame |= came;
        if (came && answer(r, end, false) < 0)
            return -1;
    }
    if (fds[LINK_FD].revents != 0) {
        ect_packet_links_seen(r->link_fd);
        follow_cables(r);
    }
    if (fds[SIGNAL_FD].revents != 0 && !take_signal(r))
        return 0;
    serve_clients(r, frame, fds);
    r->answered_ns = 0; /* meanwhile it has become later */
    return 1;
}

/* Devices, then a frame, or all that there is to wait for. @return as serve() */
static int go_round(ect_runner_t *r)
{
    struct pollfd fds[WAITABLE];
    uint64_t wake_ns = run_devices(r);
    bool lingers = may_linger(r, wake_ns);
    if (lingers && r->polled_ns - r->looked_ns < FRAMES_ALONE_NS) {
        int came = linger(r, wake_ns);
        if (came != 0)
            return came;
        lingers = r->busy_poll;
    } else if (lingers) {
        r->frames_first = FRAMES_FIRST; /* others have waited long enough */
    }
    int ready = wait_for(r, fds, lingers ? 0 : wake_ns);
    r->looked_ns = r->polled_ns;
    r->frames_come = lingers || fds[ECT_END_IN].revents != 0;
    return ready < 0 && errno != EINTR ? -1 : serve(r, fds);
}

/* What a user had saved is safe before the process ends. */
static void finish(const ect_runner_t *r)
{
    const struct timespec pause = {.tv_nsec = 100000};
    uint64_t end_ns = ect_packet_now() + 2ull * NS_PER_S;
    while (ect_chain_unfinished(r->chain) && ect_packet_now() < end_ns) {
        (void)nanosleep(&pause, NULL);
        (void)ect_chain_poll(r->chain, ect_packet_now());
    }
}

int ect_runner_run(ect_runner_t *r)
{
    int going = 1;
    r->deadline_ns = r->touched_ns = ECT_NEVER;
    r->stats.start_ns = ect_packet_now();
    if (r->control)
        ect_control_show(r->control, &r->stats, r->scenario);
    follow_cables(r);
    while (going > 0)
        going = go_round(r);
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        ect_late_clear(&r->late[end]);
        ect_late_clear(&r->behind[end]);
    }
    if (r->scenario)
        ect_wires_clear(&r->scenario->wires);
    finish(r);
    return going;
}
