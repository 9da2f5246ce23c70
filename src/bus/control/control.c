/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/control/control.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bus/control/change.h"
#include "bus/control/client.h"
#include "bus/control/events.h"
#include "wire/assert.h"

enum { ROUND_NS = 10000000, RETRY_NS = 1000000000, ACCEPT = ECT_CONTROL_CLIENTS, WAITABLE = ECT_CONTROL_CLIENTS + 1 };

struct ect_control {
    int fd, epoll;
    int spare;          /* spare descriptor, closed when no other is free */
    bool accepts;       /* a connection is pending */
    uint64_t retry_ns;  /* next accept() after a lack of descriptors; ECT_NEVER: none */
    uint64_t round_ns;  /* time of the next round; ECT_NEVER: no client watches in rounds */
    size_t turn;        /* next client to serve */
    size_t clients_end; /* first index after the last client in use, so that a frame does not check free ones */
    ect_client_t clients[ECT_CONTROL_CLIENTS];
    const ect_stats_t *stats;
    ect_scenario_t *scenario;
    const ect_about_t *about;
    ect_datagrams_t *datagrams;
    ect_recent_t recent;
    ect_observer_t observer;
    ect_plans_t plans;
    ect_outsides_t outsides;
    ect_events_t *events;  /* NULL: none are recorded */
    ect_chain_t *followed; /* their chain */
    char path[ECT_ENDPOINT_PATH];
    ino_t identity; /* of the socket's file */
};

static int open_spare(void)
{
    return open("/dev/null", O_RDONLY | O_CLOEXEC);
}

static bool wait_for(const ect_control_t *c, int operation, int fd, uint32_t events, uint32_t who)
{
    struct epoll_event event = {.events = events, .data.u32 = who};
    return epoll_ctl(c->epoll, operation, fd, &event) == 0;
}

ect_control_t *ect_control_open(const char *name, char *message)
{
    ect_control_t *c = calloc(1, sizeof *c);
    if (!c) {
        strcpy(message, "no control socket: not enough memory");
        return NULL;
    }
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++)
        c->clients[i].fd = -1;
    c->retry_ns = c->round_ns = ECT_NEVER;
    c->spare = open_spare();
    c->epoll = epoll_create1(EPOLL_CLOEXEC);
    c->fd = c->epoll < 0 ? -1 : ect_endpoint_listen(name, c->path, message);
    c->identity = c->fd < 0 ? 0 : ect_endpoint_identity(c->path);
    if (c->fd >= 0 && wait_for(c, EPOLL_CTL_ADD, c->fd, EPOLLIN, ACCEPT))
        return c;
    int error = errno;
    if (c->epoll < 0)
        strcpy(message, "no control socket: no descriptor is free");
    else if (c->fd >= 0)
        snprintf(message, ECT_ENDPOINT_MESSAGE, "no control socket: %s", strerror(error));
    ect_control_close(c);
    errno = error;
    return NULL;
}

static void drop(ect_control_t *c, ect_client_t *client)
{
    ect_outside_left(&c->outsides, client);
    close(client->fd);
    ect_watch_free(client->watch);
    free(client->answer);
    *client = (ect_client_t){.fd = -1};
}

void ect_control_close(ect_control_t *c)
{
    if (!c)
        return;
    c->outsides.report = NULL; /* plants outlive the bus */
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        if (c->clients[i].fd >= 0)
            drop(c, &c->clients[i]);
    }
    ect_outsides_clear(&c->outsides);
    ect_plans_clear(&c->plans);
    ect_recent_free(&c->recent);
    if (c->followed)
        ect_chain_observe(c->followed, ECT_CHAIN_CLIENTS, NULL, NULL);
    ect_events_free(c->events);
    if (c->fd >= 0)
        ect_endpoint_close(c->fd, c->path, c->identity);
    if (c->epoll >= 0)
        close(c->epoll);
    if (c->spare >= 0)
        close(c->spare);
    free(c);
}

void ect_control_show(ect_control_t *c, const ect_stats_t *stats, ect_scenario_t *scenario)
{
    c->scenario = scenario;
    c->stats = stats;
}

void ect_control_count(ect_control_t *c, ect_datagrams_t *datagrams)
{
    c->datagrams = datagrams;
}

ect_recent_t *ect_control_recent(ect_control_t *c)
{
    return &c->recent;
}

void ect_control_describe(ect_control_t *c, const ect_about_t *about)
{
    c->about = about;
}

void ect_control_observe(ect_control_t *c, void (*changes)(void *ctx, const char *request, size_t length), void *ctx)
{
    c->observer = (ect_observer_t){.changes = changes, .ctx = ctx};
}

void ect_control_report(ect_control_t *c, void (*report)(void *ctx, const char *text), void *ctx)
{
    c->outsides.report = report;
    c->outsides.ctx = ctx;
}

void ect_control_let_wait(ect_control_t *c)
{
    c->outsides.may_wait = true;
}

static void look(void *control, size_t position, uint64_t now_ns)
{
    const ect_control_t *c = control;
    ect_events_look(c->events, c->followed, position, now_ns);
}

void ect_control_follow(ect_control_t *c, ect_chain_t *chain)
{
    ECT_ASSERT(!c->events);
    c->events = ect_events_new(chain);
    if (!c->events)
        return;
    c->followed = chain;
    ect_chain_observe(chain, ECT_CHAIN_CLIENTS, look, c);
}

const char *ect_control_path(const ect_control_t *c)
{
    return c->path;
}

int ect_control_fd(const ect_control_t *c)
{
    return c->epoll;
}

/* --- new connections ---------------------------------------------------------------------------------------------- */

static void turn_away(int fd, const char *message)
{
    ect_line_t line;
    ect_line_begin(&line);
    ect_line_plain(&line, "ok", "false");
    ect_line_string(&line, "message", message);
    ect_line_end(&line);
    (void)send(fd, line.text, line.length, MSG_NOSIGNAL | MSG_DONTWAIT);
    close(fd);
}

/* A pending connection keeps the listening socket readable, so it is accepted with the spare descriptor and closed, or
 * retried later. */
static void no_descriptor(ect_control_t *c, uint64_t now_ns)
{
    if (c->spare >= 0)
        close(c->spare);
    int fd = accept4(c->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    const bool no_client = errno == EAGAIN; /* without a descriptor */
    if (fd >= 0)
        turn_away(fd, "the twin has no descriptor left: 'ulimit -n' is too low for it");
    c->spare = open_spare();
    if (fd < 0 && !no_client && wait_for(c, EPOLL_CTL_MOD, c->fd, 0, ACCEPT))
        c->retry_ns = now_ns + RETRY_NS;
}

static void accept_client(ect_control_t *c, uint64_t now_ns)
{
    int fd = accept4(c->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) {
        if (errno == EMFILE || errno == ENFILE)
            no_descriptor(c, now_ns);
        return;
    }
    for (uint32_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        ect_client_t *client = &c->clients[i];
        if (client->fd >= 0)
            continue;
        client->answer = malloc(ECT_CLIENT_ANSWER);
        if (!client->answer || !wait_for(c, EPOLL_CTL_ADD, fd, EPOLLIN, i)) {
            free(client->answer);
            break;
        }
        client->fd = fd;
        client->events = EPOLLIN;
        client->stats = c->stats;
        client->scenario = c->scenario;
        client->about = c->about;
        client->datagrams = c->datagrams;
        client->recent = &c->recent;
        client->observer = &c->observer;
        client->events_of_chain = c->events;
        client->plans = &c->plans;
        client->outsides = &c->outsides;
        return;
    }
    turn_away(fd, "the twin serves 16 connections, and all are taken: end one of them");
}

/* --- reception and transmission ----------------------------------------------------------------------------------- */

static bool wants_more(const ect_client_t *client)
{
    return client->line == 0 && !client->ended && !client->closing && client->visit.op == ECT_VISIT_NONE &&
           ect_client_room(client);
}

/* At the end of input, an unterminated line is a request too. */
static void end_of_requests(ect_client_t *client)
{
    client->ended = true;
    if (client->received > 0 && client->received < ECT_ENDPOINT_REQUEST)
        client->request[client->received++] = '\n';
}

static void receive(ect_client_t *client)
{
    ssize_t got =
        recv(client->fd, client->request + client->received, ECT_ENDPOINT_REQUEST - client->received, MSG_DONTWAIT);
    client->readable = false;
    if (got > 0)
        client->received += (size_t)got;
    else if (got == 0)
        end_of_requests(client);
    else if (errno != EAGAIN && errno != EINTR) {
        client->ended = true;
        ect_client_end_of_input(client);
    }
    ect_client_received(client);
    if (client->line == 0 && client->received == ECT_ENDPOINT_REQUEST) {
        ect_client_result(client, "a request has at most 4095 characters");
        client->closing = true;
    }
}

static void flush(ect_client_t *client)
{
    ssize_t sent = send(client->fd, client->answer, client->unsent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) {
        ect_client_end_of_input(client);
    } else if (sent > 0) {
        client->unsent -= (size_t)sent;
        memmove(client->answer, client->answer + sent, client->unsent);
    }
    client->blocked = client->unsent > 0;
}

/* A client that has ended sending may still read replies and watched values. */
static bool is_done(const ect_client_t *client)
{
    bool works = client->visit.op != ECT_VISIT_NONE || (client->line > 0 && !client->closing);
    if (client->deaf)
        return (client->ended || client->closing) && !works;
    return client->unsent == 0 && (client->closing || (client->ended && !works && !client->watch));
}

/* Updates the events requested from epoll, or closes the connection. */
static void update_events(ect_control_t *c, ect_client_t *client, uint32_t who)
{
    uint32_t events = (wants_more(client) ? EPOLLIN : 0u) | (client->blocked ? (uint32_t)EPOLLOUT : 0u);
    if (is_done(client))
        drop(c, client);
    else if (events != client->events && wait_for(c, EPOLL_CTL_MOD, client->fd, events, who))
        client->events = events;
}

/* --- functions for the event loop --------------------------------------------------------------------------------- */

static bool can_step(const ect_client_t *client)
{
    return ect_client_busy(client) && !client->closing && ect_client_room(client);
}

static bool ready(const ect_client_t *client)
{
    return client->fd >= 0 && ((client->readable && wants_more(client)) || can_step(client) ||
                               (client->unsent > 0 && !client->blocked) || is_done(client));
}

/* Reads from epoll which clients are readable, writable or closed. */
static void read_events(ect_control_t *c)
{
    struct epoll_event events[WAITABLE];
    int count = epoll_wait(c->epoll, events, WAITABLE, 0);
    for (int i = 0; i < count; i++) {
        if (events[i].data.u32 == ACCEPT) {
            c->accepts = true;
            continue;
        }
        ect_client_t *client = &c->clients[events[i].data.u32];
        client->readable |= (events[i].events & (uint32_t)~EPOLLOUT) != 0;
        client->blocked &= (events[i].events & EPOLLOUT) == 0;
        if ((events[i].events & (EPOLLHUP | EPOLLERR)) != 0) {
            ect_client_end_of_input(client);
            ect_outside_left(&c->outsides, client); /* before its name is given to a new connection */
            client->blocked = false;
        }
    }
}

static size_t every_room(const ect_control_t *c, const ect_client_t *but)
{
    size_t used = 0;
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        const ect_client_t *client = &c->clients[i];
        if (client != but && client->watch && ect_watch_is_every(client->watch))
            used += ect_watch_count(client->watch);
    }
    return used < ECT_CONTROL_EVERY ? ECT_CONTROL_EVERY - used : 0;
}

static void serve_client(ect_control_t *c, ect_client_t *client, uint32_t who, ect_chain_t *chain, uint64_t now_ns)
{
    if (client->readable && wants_more(client))
        receive(client);
    if (can_step(client))
        ect_client_step(client, chain, every_room(c, client), now_ns);
    if (client->unsent > 0 && !client->blocked && (client->visit.op == ECT_VISIT_NONE || !ect_client_room(client)))
        flush(client);
    update_events(c, client, who);
}

/* Begins rounds for all clients at the same time while any client watches in rounds. */
static void begin_rounds(ect_control_t *c, uint64_t now_ns)
{
    bool due = now_ns >= c->round_ns;
    bool wanted = false;
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        ect_watch_t *watch = c->clients[i].watch;
        if (!watch || ect_watch_is_every(watch))
            continue;
        wanted = true;
        if (due)
            ect_watch_round(watch);
    }
    if (!wanted)
        c->round_ns = ECT_NEVER;
    else if (due || c->round_ns == ECT_NEVER)
        c->round_ns = now_ns + ROUND_NS;
}

/* Serves the next client with work. */
static void serve_one(ect_control_t *c, ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t i = 0; i < WAITABLE; i++) {
        uint32_t who = (uint32_t)c->turn;
        c->turn = (c->turn + 1) % WAITABLE;
        if (who == ACCEPT && c->accepts) {
            c->accepts = false;
            accept_client(c, now_ns);
            return;
        }
        if (who != ACCEPT && ready(&c->clients[who])) {
            serve_client(c, &c->clients[who], who, chain, now_ns);
            return;
        }
    }
}

void ect_control_serve(ect_control_t *c, ect_chain_t *chain, uint64_t now_ns)
{
    read_events(c);
    if (now_ns >= c->retry_ns && wait_for(c, EPOLL_CTL_MOD, c->fd, EPOLLIN, ACCEPT))
        c->retry_ns = ECT_NEVER;
    serve_one(c, chain, now_ns);
    begin_rounds(c, now_ns);
    c->clients_end = ECT_CONTROL_CLIENTS;
    while (c->clients_end > 0 && c->clients[c->clients_end - 1].fd < 0)
        c->clients_end--;
}

uint64_t ect_control_due(const ect_control_t *c)
{
    for (size_t i = 0; i < c->clients_end; i++) {
        if (ready(&c->clients[i]))
            return 0;
    }
    return ect_earlier(c->round_ns, c->retry_ns);
}

void ect_control_record(ect_control_t *c, const ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t i = 0; i < c->clients_end; i++) {
        ect_watch_t *watch = c->clients[i].watch;
        if (!watch || !ect_watch_is_every(watch))
            continue;
        ect_client_show_lamps(&c->clients[i], chain);
        ect_watch_record(watch, now_ns);
    }
}

/* --- requests with a time ----------------------------------------------------------------------------------------- */

/* Reports to the scenario, because the client has already got its reply. */
static void report_refusal(const ect_control_t *c, const cJSON *request, const char *why)
{
    char *text = c->scenario && c->scenario->refused ? cJSON_PrintUnformatted(request) : NULL;
    if (text)
        c->scenario->refused(c->scenario->ctx, text, why);
    cJSON_free(text);
}

uint64_t ect_control_planned(const ect_control_t *c)
{
    return ect_plans_due(&c->plans);
}

/* Observers get the request at its execution. */
static void act(ect_control_t *c, ect_chain_t *chain, cJSON *request, uint64_t now_ns)
{
    char message[ECT_SIGNAL_MESSAGE];
    cJSON_DeleteItemFromObjectCaseSensitive(request, "at");
    char *text = c->observer.changes ? cJSON_PrintUnformatted(request) : NULL;
    if (text)
        c->observer.changes(c->observer.ctx, text, strlen(text));
    cJSON_free(text);
    const char *why = ect_change_apply(chain, c->scenario, request, now_ns, message);
    if (why)
        report_refusal(c, request, why);
}

void ect_control_act(ect_control_t *c, ect_chain_t *chain, uint64_t now_ns)
{
    while (ect_plans_due(&c->plans) <= now_ns) {
        cJSON *request = ect_plans_take(&c->plans);
        act(c, chain, request, now_ns);
        cJSON_Delete(request);
    }
}

/* --- plants ------------------------------------------------------------------------------------------------------- */

bool ect_control_wants_step(const ect_control_t *c, uint64_t now_ns)
{
    return ect_outsides_due(&c->outsides) <= now_ns || ect_outsides_triggered(&c->outsides);
}

uint64_t ect_control_step_due(const ect_control_t *c)
{
    return ect_outsides_due(&c->outsides);
}

/* Does one piece of work for any client; waits at most 0.1 s for work. @return whether work was done */
static bool serve_or_wait(ect_control_t *c, ect_chain_t *chain, uint64_t now_ns)
{
    enum { PIECE_MS = 100 };
    struct pollfd fd = {.fd = c->epoll, .events = POLLIN};
    const bool work = ect_control_due(c) == 0 || poll(&fd, 1, PIECE_MS) != 0;
    if (work)
        ect_control_serve(c, chain, now_ns);
    return work;
}

/* Stops the clock until the plant has replied. The timeout is counted in short waits, so that a suspension of the
 * machine does not reduce the plant's time. */
static void await(ect_control_t *c, const ect_client_t *client, ect_chain_t *chain, uint64_t now_ns)
{
    enum { WAITS = 100, WORK = 100000 };
    unsigned int waits = 0;
    ect_outside_t *plant = ect_outside_of(&c->outsides, client);
    for (unsigned int i = 0; i < WORK && waits < WAITS && plant && ect_outside_waits(plant); i++) {
        waits += !serve_or_wait(c, chain, now_ns);
        plant = ect_outside_of(&c->outsides, client);
    }
    if (plant && ect_outside_waits(plant))
        ect_outside_give_up(&c->outsides, plant);
}

bool ect_control_step(ect_control_t *c, ect_chain_t *chain, uint64_t now_ns)
{
    bool waited = false;
    for (uint32_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        ect_client_t *client = &c->clients[i];
        ect_outside_t *plant = client->fd < 0 ? NULL : ect_outside_due(&c->outsides, client, now_ns);
        if (!plant)
            continue;
        if (!ect_client_room(client) || client->deaf) {
            ect_outside_skip(&c->outsides, plant, now_ns);
        } else if (ect_outside_begin(&c->outsides, plant, chain, now_ns)) {
            ect_client_send_step(client, plant, now_ns);
            flush(client);
            update_events(c, client, i);
            waited |= ect_outside_waits(plant);
            await(c, client, chain, now_ns);
        }
    }
    return waited;
}

bool ect_control_await_plant(ect_control_t *c, ect_chain_t *chain, const char *name, uint64_t now_ns)
{
    enum { WAITS = 200, WORK = 100000 };
    unsigned int waits = 0;
    for (unsigned int i = 0; i < WORK && waits < WAITS && !ect_outside_named(&c->outsides, name); i++)
        waits += !serve_or_wait(c, chain, now_ns);
    return ect_outside_named(&c->outsides, name) != NULL;
}
