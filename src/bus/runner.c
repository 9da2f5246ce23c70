/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/runner.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

enum { NS_PER_S = 1000000000 };

/* The descriptors of the loop: frames at each end, without a VLAN tag and with one, signals, cables, control socket,
 * Modbus server, hosts behind EoE, EtherCAT in UDP, replies in the kernel. */
enum {
    TAGGED_FD = ECT_ENDS,
    TAGGED_OUT_FD,
    SIGNAL_FD,
    LINK_FD,
    CONTROL_FD,
    MODBUS_FD,
    HOSTS_FD,
    UDP_FD,
    KERNEL_FD,
    WAITABLE
};

/* Kinds of clients, in the order of their descriptors. */
enum { CONTROL, MODBUS, HOSTS, CLIENTS };

/* Frames in a row after which a client is served although another one waits. */
enum { FRAMES_FIRST = 8 };

/* Wait for frames only this long before serving clients. */
enum { FRAMES_ALONE_NS = 500000 };

/* Poll for frames only this long before serving clients (--busy-poll). */
enum { SPIN_NS = 100000 };

/* @return -1: there is none of this kind */
static int client_fd(const ect_runner_t *r, unsigned int client)
{
    switch (client) {
    case CONTROL:
        return r->exchange.control ? ect_control_fd(r->exchange.control) : -1;
    case MODBUS:
        return r->modbus ? ect_modbus_server_fd(r->modbus) : -1;
    default:
        return r->hosts ? ect_hosts_fd(r->hosts) : -1;
    }
}

/* When clients of a kind want to be served by themselves. */
static uint64_t client_due(const ect_runner_t *r, unsigned int client)
{
    switch (client) {
    case CONTROL:
        return r->exchange.control ? ect_control_due(r->exchange.control) : ECT_NEVER;
    case MODBUS:
        return r->modbus ? ect_modbus_server_due(r->modbus) : ECT_NEVER;
    default:
        return r->hosts ? ect_hosts_due(r->hosts) : ECT_NEVER;
    }
}

static void count_lost(ect_runner_t *r)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++)
        r->exchange.stats.queue_lost += r->ports[end] ? ect_packet_lost(r->ports[end]) : 0;
}

static void serve_control(ect_runner_t *r, uint64_t now_ns)
{
    count_lost(r); /* the client may ask for the counters */
    ect_control_serve(r->exchange.control, r->exchange.chain, now_ns);
}

static void serve_client(ect_runner_t *r, unsigned int client)
{
    uint64_t now_ns = ect_exchange_touch(&r->exchange);
    if (client == CONTROL)
        serve_control(r, now_ns);
    else if (client == MODBUS)
        ect_modbus_server_serve(r->modbus, r->exchange.chain, now_ns);
    else
        ect_hosts_serve(r->hosts, r->exchange.chain, now_ns);
}

/* After an interruption `fds` has no events. */
static int wait_for(const ect_runner_t *r, struct pollfd fds[WAITABLE], uint64_t deadline_ns)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        const ect_packet_t *port = r->ports[end];
        fds[end] = (struct pollfd){.fd = port ? port->fd : -1, .events = POLLIN};
        fds[TAGGED_FD + end] = (struct pollfd){.fd = port ? port->tagged_fd : -1, .events = POLLIN};
    }
    fds[SIGNAL_FD] = (struct pollfd){.fd = r->signal_fd, .events = POLLIN};
    fds[LINK_FD] = (struct pollfd){.fd = r->link_fd, .events = POLLIN};
    fds[UDP_FD] = (struct pollfd){.fd = r->udp ? r->udp->fd : -1, .events = POLLIN};
    fds[KERNEL_FD] = (struct pollfd){.fd = r->kernel ? ect_kernel_fd(r->kernel) : -1, .events = POLLIN};
    for (unsigned int i = 0; i < CLIENTS; i++)
        fds[CONTROL_FD + i] = (struct pollfd){.fd = r->pausing ? -1 : client_fd(r, i), .events = POLLIN};
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

static uint64_t packet_clock(void *ctx)
{
    (void)ctx;
    return ect_packet_now();
}

static void send_out(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    ect_runner_t *r = ctx;
    ect_endless_sent(&r->endless[end], frame, length);
    if (r->udp && ect_udp_carries(frame, length))
        ect_udp_send(r->udp, frame, length);
    else if (r->ports[end])
        ect_packet_send(r->ports[end], frame, length);
}

/* Whether frames circulate; the first time is reported. */
static bool is_circulating(ect_runner_t *r, ect_end_t end, const uint8_t *frame, size_t length)
{
    if (!ect_endless_received(&r->endless[end], frame, length, r->exchange.polled_ns))
        return false;
    if (r->exchange.stats.circling++ == 0)
        r->on_circulating(r->ctx, ect_udp_carries(frame, length) ? r->udp->address : r->ports[end]->iface);
    return true;
}

static void follow_cables(ect_runner_t *r)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        r->linked[end] =
            (r->udp && end == ECT_END_IN) || (r->ports[end] && (r->link_fd < 0 || ect_packet_has_link(r->ports[end])));
        ect_exchange_link(&r->exchange, end, r->linked[end]);
    }
}

/* @param length  as a port has returned it. @return 1: a frame came; 0: none; -1: the interface is gone */
static int take_frame(ect_runner_t *r, ect_end_t in, uint8_t *frame, ssize_t length, const ect_packet_time_t *time)
{
    if (length == ECT_PACKET_NONE || length == ECT_PACKET_GONE)
        return (int)length;
    if (r->kernel) {
        ect_kernel_got(r->kernel);
        if (length > 0 && (size_t)length <= ECT_EXCHANGE_FRAME)
            ect_kernel_see(r->kernel, frame, (size_t)length);
    }
    if (!r->linked[in])
        follow_cables(r); /* the frame comes before the news that a cable is in again: Linux takes up to a second */
    r->exchange.stats.frames++;
    if (length == ECT_PACKET_STALE)
        r->exchange.stats.stale++;
    else if (length == ECT_UDP_REFUSED)
        r->exchange.stats.unanswered++;
    else if ((size_t)length > ECT_EXCHANGE_FRAME)
        ect_exchange_long_frame(&r->exchange, in, frame, (size_t)length, time->now_ns);
    else if (!is_circulating(r, in, frame, (size_t)length))
        ect_exchange_frame(&r->exchange, in, frame, (size_t)length, time);
    return 1;
}

/* @return as take_frame() */
static int receive_frame(ect_runner_t *r, ect_end_t in, bool wait)
{
    uint8_t frame[ECT_EXCHANGE_FRAME];
    ect_packet_time_t time;
    ssize_t length = ect_packet_receive(r->ports[in], wait, frame, sizeof frame, &time);
    return take_frame(r, in, frame, length, &time);
}

/* @return as take_frame() */
static int receive_datagram(ect_runner_t *r)
{
    uint8_t frame[ECT_EXCHANGE_FRAME];
    ect_packet_time_t time;
    ssize_t length = ect_udp_receive(r->udp, frame, &time);
    return take_frame(r, ECT_END_IN, frame, length, &time);
}

static bool take_signal(const ect_runner_t *r)
{
    struct signalfd_siginfo info;
    if (read(r->signal_fd, &info, sizeof info) != (ssize_t)sizeof info)
        return true;
    return r->on_signal(r->ctx, (int)info.ssi_signo, info.ssi_code == SI_KERNEL);
}

/* When clients want to be served by themselves; while the loop rests from them, when that is over. */
static uint64_t clients_due(const ect_runner_t *r)
{
    uint64_t due_ns = r->pausing ? r->pause_end_ns : ECT_NEVER;
    for (unsigned int i = 0; i < CLIENTS && !r->pausing; i++)
        due_ns = ect_earlier(due_ns, client_due(r, i));
    return due_ns;
}

/* Late replies and the devices, then their clients. @return when to be here again */
static uint64_t run_devices(ect_runner_t *r)
{
    uint64_t next_ns = ect_exchange_run(&r->exchange);
    r->pausing = r->exchange.run_ns < r->pause_end_ns;
    return ect_earlier(next_ns, clients_due(r));
}

/* The kind of clients whose turn it is. @return CLIENTS: no client is due */
static unsigned int next_client(const ect_runner_t *r, const struct pollfd fds[WAITABLE])
{
    uint64_t now_ns = ect_packet_now();
    for (unsigned int i = 1; i <= CLIENTS; i++) {
        unsigned int client = (r->client + i) % CLIENTS;
        if (fds[CONTROL_FD + client].revents != 0 || now_ns >= client_due(r, client))
            return client;
    }
    return CLIENTS;
}

/* Frames first: a client is served when none came, or too many have come one after another. */
static void serve_clients(ect_runner_t *r, bool frame, const struct pollfd fds[WAITABLE])
{
    if (r->pausing || !(r->exchange.control || r->modbus || r->hosts))
        return;
    unsigned int client = next_client(r, fds);
    if (client == CLIENTS || (frame && ++r->frames_first < FRAMES_FIRST))
        return;
    r->frames_first = 0;
    r->client = client;
    serve_client(r, client);
    r->pause_end_ns = ect_packet_now() + r->client_pause_ns;
}

/*
 * While frames come, the next one is waited for in the call that receives it: that is the shortest way to an answer.
 * Clients and signals are checked every half millisecond, and when no frame has come for a while.
 */
static bool may_wait_for_frame(const ect_runner_t *r, uint64_t wake_ns)
{
    const ect_packet_t *port = r->ports[ECT_END_IN];
    if (!port || r->ports[ECT_END_OUT] || r->udp || r->kernel)
        return false;
    return r->busy_poll || (r->frames_come && port->wait_ns != 0 && wake_ns > r->exchange.polled_ns + port->wait_ns);
}

/* @return as receive_frame() */
static int wait_for_frame(ect_runner_t *r, uint64_t wake_ns)
{
    if (!r->busy_poll)
        return receive_frame(r, ECT_END_IN, true);
    const uint64_t end_ns = ect_earlier(wake_ns, ect_packet_now() + SPIN_NS);
    int got = 0;
    while (got == 0 && ect_packet_now() < end_ns)
        got = receive_frame(r, ECT_END_IN, false);
    return got;
}

/* @return 1: go on; 0: stop; -1: an interface is gone */
static int serve(ect_runner_t *r, const struct pollfd fds[WAITABLE])
{
    bool frame = false;
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        bool came = fds[end].revents != 0 || fds[TAGGED_FD + end].revents != 0;
        frame |= came;
        if (came && receive_frame(r, end, false) < 0)
            return -1;
    }
    frame |= fds[UDP_FD].revents != 0;
    if (fds[UDP_FD].revents != 0 && receive_datagram(r) < 0)
        return -1;
    if (fds[LINK_FD].revents != 0) {
        ect_packet_links_seen(r->link_fd);
        follow_cables(r);
    }
    if (fds[SIGNAL_FD].revents != 0 && !take_signal(r))
        return 0;
    serve_clients(r, frame, fds);
    r->exchange.answered_ns = 0; /* meanwhile it has become later */
    return 1;
}

/* The kernel replies to frames while the loop sleeps. */
static void give_turn(ect_runner_t *r)
{
    if (r->kernel && ect_exchange_is_plain(&r->exchange))
        r->exchange.stats.plans = ect_kernel_give(r->kernel, r->exchange.chain, ect_packet_now());
}

/* The frames that the kernel has replied to come before all else. The devices run before the next frame, which may
 * replace the outputs of the last one. */
static void take_turn(ect_runner_t *r)
{
    const ect_held_t *held;
    bool any = false;
    if (!r->kernel)
        return;
    ect_kernel_take(r->kernel);
    while ((held = ect_kernel_next(r->kernel)) != NULL) {
        uint8_t frame[ECT_HELD_ROOM];
        memcpy(frame, held->frame, held->length);
        ect_exchange_replied(&r->exchange, frame, held->length, held->time_ns, held->took_ns);
        any = true;
    }
    if (any)
        (void)ect_exchange_run(&r->exchange);
}

/* Devices, then a frame, or all that there is to wait for. @return as serve() */
static int run_once(ect_runner_t *r)
{
    struct pollfd fds[WAITABLE];
    uint64_t wake_ns = run_devices(r);
    bool waits = may_wait_for_frame(r, wake_ns);
    if (waits && r->exchange.polled_ns - r->waited_ns < FRAMES_ALONE_NS) {
        int came = wait_for_frame(r, wake_ns);
        if (came != 0)
            return came;
        waits = r->busy_poll;
    } else if (waits) {
        r->frames_first = FRAMES_FIRST; /* others have waited long enough */
    }
    give_turn(r);
    int ready = wait_for(r, fds, waits ? 0 : wake_ns);
    take_turn(r);
    r->waited_ns = r->exchange.polled_ns;
    r->frames_come = waits || fds[ECT_END_IN].revents != 0;
    return ready < 0 && errno != EINTR ? -1 : serve(r, fds);
}

/* Finishes a save before the process ends. */
static void finish(const ect_runner_t *r)
{
    const struct timespec pause = {.tv_nsec = 100000};
    uint64_t end_ns = ect_packet_now() + 2ull * NS_PER_S;
    while (ect_chain_unfinished(r->exchange.chain) && ect_packet_now() < end_ns) {
        (void)nanosleep(&pause, NULL);
        (void)ect_chain_poll(r->exchange.chain, ect_packet_now());
    }
}

int ect_runner_run(ect_runner_t *r)
{
    int going = 1;
    r->exchange.send = send_out;
    r->exchange.clock = packet_clock;
    r->exchange.ctx = r;
    ect_exchange_start(&r->exchange);
    follow_cables(r);
    while (going > 0)
        going = run_once(r);
    ect_exchange_end(&r->exchange);
    finish(r);
    return going;
}
