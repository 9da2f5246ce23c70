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

/* After this many successive frames a client is served although a further frame waits. */
enum { FRAMES_FIRST = 8 };

/* Longest wait for frames alone before clients are served. */
enum { FRAMES_ALONE_NS = 500000 };

/* Longest poll for frames alone before clients are served (--busy-poll). */
enum { SPIN_NS = 100000 };

/* @return the descriptor of a kind of clients; -1: none */
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

/* @return the time at which a kind of clients is due without a request */
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
    count_lost(r); /* the client may read the counters */
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

/* @return as ppoll(); `fds` has no events after an interruption by a signal */
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

/* @return whether a frame circulates; the first one is reported */
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

/* @param length  result of the port. @return 1: a frame has arrived; 0: no frame; -1: the interface is gone */
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
        follow_cables(r); /* Linux reports a plugged cable up to a second after the first frame */
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

/* @return the time at which a client is due without a request, or the end of a pause */
static uint64_t clients_due(const ect_runner_t *r)
{
    uint64_t due_ns = r->pausing ? r->pause_end_ns : ECT_NEVER;
    for (unsigned int i = 0; i < CLIENTS && !r->pausing; i++)
        due_ns = ect_earlier(due_ns, client_due(r, i));
    return due_ns;
}

/* Sends late replies and runs the devices. @return the time of the next call */
static uint64_t run_devices(ect_runner_t *r)
{
    uint64_t next_ns = ect_exchange_run(&r->exchange);
    r->pausing = r->exchange.run_ns < r->pause_end_ns;
    return ect_earlier(next_ns, clients_due(r));
}

/* @return the next kind of clients to serve, in rotation; CLIENTS: no client is due */
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

/* Serves a client if no frame has arrived, or after FRAMES_FIRST successive frames. */
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
 * While frames arrive, the loop waits in the receiving call, which gives the shortest reply time. Clients and signals
 * are checked every FRAMES_ALONE_NS, and after a wait without a frame.
 */
static bool may_wait_for_frame(const ect_runner_t *r, uint64_t wake_ns)
{
    const ect_packet_t *port = r->ports[ECT_END_IN];
    if (!port || r->ports[ECT_END_OUT] || r->udp || r->kernel)
        return false;
    return r->busy_poll || (r->frames_come && port->wait_ns != 0 && wake_ns > r->exchange.polled_ns + port->wait_ns);
}

/* Waits, or polls, for a frame until `wake_ns`. @return as receive_frame() */
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

/* Handles all descriptors with events. @return 1: continue; 0: stop; -1: an interface is gone */
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
    r->exchange.answered_ns = 0; /* the time of the last reply is out of date after this work */
    return 1;
}

/* Lets the kernel reply to frames while the loop sleeps. */
static void give_turn(ect_runner_t *r)
{
    if (r->kernel && ect_exchange_is_plain(&r->exchange))
        r->exchange.stats.plans = ect_kernel_give(r->kernel, r->exchange.chain, ect_packet_now());
}

/* Passes the frames that the kernel has replied to before any other work, because they have arrived first. The devices
 * run before the next frame, which may replace the outputs of the last one. */
static void take_turn(ect_runner_t *r)
{
    ect_held_t *held;
    bool any = false;
    if (!r->kernel)
        return;
    ect_kernel_take(r->kernel);
    while ((held = ect_kernel_next(r->kernel)) != NULL) {
        ect_exchange_replied(&r->exchange, held->frame, held->length, held->time_ns, held->took_ns);
        any = true;
    }
    if (any)
        (void)ect_exchange_run(&r->exchange);
}

/* Runs the devices, then handles a frame, or the events of all descriptors. @return as serve() */
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
        r->frames_first = FRAMES_FIRST; /* clients have waited long enough */
    }
    give_turn(r);
    int ready = wait_for(r, fds, waits ? 0 : wake_ns);
    take_turn(r);
    r->waited_ns = r->exchange.polled_ns;
    r->frames_come = waits || fds[ECT_END_IN].revents != 0;
    return ready < 0 && errno != EINTR ? -1 : serve(r, fds);
}

/* Completes a save before the process ends, within 2 s. */
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
