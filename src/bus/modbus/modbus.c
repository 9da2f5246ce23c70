/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/modbus/modbus.h"

#include <errno.h>
#include <limits.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bus/modbus/modbus_request.h"
#include "bus/net/address.h"
#include "wire/assert.h"
#include "wire/bytes.h"

/* MBAP header: transaction, protocol (0), length, unit identifier; then the request. */
enum { PROTOCOL_AT = 2, LENGTH_AT = 4, UNIT_AT = 6, PDU_AT = 7, SHORTEST = 2, LONGEST = ECT_MODBUS_ADU - UNIT_AT };
enum { EXCEPTIONS = 0x80 }; /* function codes from here on are those of exceptions */

enum { ACCEPT = ECT_MODBUS_CLIENTS, WAITABLE = ECT_MODBUS_CLIENTS + 1 };
enum { ITEMS = 65536 }; /* of a table: all addresses */
#define RETRY_NS  1000000000ull
#define NS_PER_MS 1000000ull

typedef struct client {
    int fd;       /* -1: none */
    bool blocked; /* the client does not read its replies, so no request is received */
    size_t got;
    uint64_t idle_ns; /* end of the timeout for requests */
    uint8_t adu[ECT_MODBUS_ADU];
} client_t;

struct ect_modbus_server {
    int fd, epoll;
    uint32_t ready;    /* bit n: client n; a further bit for ACCEPT */
    uint32_t turn;     /* next client to serve */
    uint64_t retry_ns; /* next accept() after a lack of descriptors; ECT_NEVER: none */
    uint64_t due_ns;   /* cached ect_modbus_server_due, which is called for each frame */
    client_t clients[ECT_MODBUS_CLIENTS];
    modbus_t *replies;
    modbus_mapping_t mapping;
    int replied[2]; /* for observers: libmodbus writes to the first, the server reads the reply from the second; -1:
                       replies go to clients */
    ect_modbus_observer_t *observer; /* NULL: none */
    void *observer_ctx;
    char address[ECT_ADDRESS_TEXT];
};

/* --- open --------------------------------------------------------------------------------------------------------- */

static bool wait_for(const ect_modbus_server_t *s, int operation, int fd, uint32_t events, uint32_t who)
{
    struct epoll_event event = {.events = events, .data.u32 = who};
    return epoll_ctl(s->epoll, operation, fd, &event) == 0;
}

/* The tables have all addresses, because the device checks the addresses of each request. Unused memory is not
 * committed. */
static bool make_replies(ect_modbus_server_t *s)
{
    uint8_t *bits = calloc(ITEMS, sizeof *bits);
    uint16_t *registers = calloc(ITEMS, sizeof *registers);
    s->mapping = (modbus_mapping_t){.nb_bits = ITEMS,
                                    .nb_input_bits = ITEMS,
                                    .nb_registers = ITEMS,
                                    .nb_input_registers = ITEMS,
                                    .tab_bits = bits,
                                    .tab_input_bits = bits,
                                    .tab_registers = registers,
                                    .tab_input_registers = registers};
    s->replies = modbus_new_tcp("127.0.0.1", 0); /* never connects: each reply sets its socket */
    return bits && registers && s->replies && modbus_set_response_timeout(s->replies, 0, 1) == 0;
}

/* @param fd  as in ::ect_modbus_server_at; -1: none */
static ect_modbus_server_t *make_server(int fd, char *message)
{
    ect_modbus_server_t *s = calloc(1, sizeof *s);
    if (!s) {
        if (fd >= 0)
            close(fd);
        snprintf(message, ECT_MODBUS_MESSAGE, "not enough memory");
        return NULL;
    }
    for (size_t i = 0; i < ECT_MODBUS_CLIENTS; i++)
        s->clients[i].fd = -1;
    s->fd = fd;
    s->replied[0] = s->replied[1] = -1;
    s->retry_ns = s->due_ns = ECT_NEVER;
    s->epoll = epoll_create1(EPOLL_CLOEXEC);
    if (s->epoll >= 0 && (fd < 0 || wait_for(s, EPOLL_CTL_ADD, fd, EPOLLIN, ACCEPT)) && make_replies(s))
        return s;
    snprintf(message, ECT_MODBUS_MESSAGE, "no server: %s", strerror(errno));
    ect_modbus_server_close(s);
    return NULL;
}

ect_modbus_server_t *ect_modbus_server_at(int fd, char *message)
{
    ect_modbus_server_t *s = make_server(fd, message);
    if (s)
        ect_address_print(s->fd, s->address);
    return s;
}

/* Creates the pair through which replies are read back before they are sent. */
static bool open_replied(ect_modbus_server_t *s)
{
    return socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, s->replied) == 0;
}

ect_modbus_server_t *ect_modbus_server_new(char *message)
{
    ect_modbus_server_t *s = make_server(-1, message);
    if (!s || open_replied(s))
        return s;
    snprintf(message, ECT_MODBUS_MESSAGE, "no server: %s", strerror(errno));
    ect_modbus_server_close(s);
    return NULL;
}

bool ect_modbus_server_observe(ect_modbus_server_t *s, ect_modbus_observer_t *observer, void *ctx)
{
    s->observer = observer;
    s->observer_ctx = ctx;
    return open_replied(s);
}

static int listen_at(const ect_address_t *address)
{
    const int on = 1;
    int fd = socket(address->at.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -1;
    (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on); /* in spite of connections of a previous process */
    if (bind(fd, (const struct sockaddr *)&address->at, address->size) == 0 && listen(fd, SOMAXCONN) == 0)
        return fd;
    int error = errno;
    close(fd);
    errno = error;
    return -1;
}

ect_modbus_server_t *ect_modbus_server_open(const char *where, char *message)
{
    ect_address_t address;
    if (!ect_address_parse(&address, where)) {
        snprintf(message, ECT_MODBUS_MESSAGE,
                 "'%s' is no [ADDRESS:]PORT: a numeric address, the port from 0 to 65535, as in 127.0.0.1:502", where);
        errno = EINVAL;
        return NULL;
    }
    int fd = listen_at(&address);
    int error = errno;
    if (fd >= 0)
        return ect_modbus_server_at(fd, message);
    snprintf(message, ECT_MODBUS_MESSAGE, "cannot listen at '%s': %s", where, ect_address_why(error));
    errno = error;
    return NULL;
}

static void drop(client_t *client)
{
    close(client->fd);
    client->fd = -1;
}

void ect_modbus_server_close(ect_modbus_server_t *s)
{
    if (!s)
        return;
    for (size_t i = 0; i < ECT_MODBUS_CLIENTS; i++) {
        if (s->clients[i].fd >= 0)
            drop(&s->clients[i]);
    }
    if (s->fd >= 0)
        close(s->fd);
    for (unsigned int i = 0; i < 2; i++) {
        if (s->replied[i] >= 0)
            close(s->replied[i]);
    }
    if (s->epoll >= 0)
        close(s->epoll);
    modbus_free(s->replies);
    free(s->mapping.tab_bits);
    free(s->mapping.tab_registers);
    free(s);
}

const char *ect_modbus_server_address(const ect_modbus_server_t *s)
{
    return s->address;
}

int ect_modbus_server_fd(const ect_modbus_server_t *s)
{
    return s->epoll;
}

/* --- one request -------------------------------------------------------------------------------------------------- */

static void *at(const ect_modbus_server_t *s, const ect_modbus_range_t *range)
{
    return ect_modbus_is_bits(range->table) ? (void *)(s->mapping.tab_bits + range->first)
                                            : (void *)(s->mapping.tab_registers + range->first);
}

/* Copies a range from the device to the tables, from which libmodbus makes replies. */
static ect_modbus_result_t read_range(ect_modbus_server_t *s, const ect_modbus_t *modbus, void *instance,
                                      const ect_modbus_range_t *range, uint64_t now_ns)
{
    uint16_t values[ECT_MODBUS_MOST_BITS];
    ect_modbus_result_t result = modbus->read(instance, range, values, now_ns);
    if (result != ECT_MODBUS_DONE)
        return result;
    bool bits = ect_modbus_is_bits(range->table);
    uint8_t *bit = at(s, range);
    for (unsigned int i = 0; bits && i < range->count; i++)
        bit[i] = (uint8_t)values[i];
    if (!bits)
        memcpy(at(s, range), values, range->count * sizeof *values);
    return result;
}

/* Copies a range written by a request from the tables to the device. */
static void write_range(const ect_modbus_server_t *s, const ect_modbus_t *modbus, void *instance,
                        const ect_modbus_range_t *range, uint64_t now_ns)
{
    uint16_t values[ECT_MODBUS_MOST_BITS];
    bool bits = ect_modbus_is_bits(range->table);
    const uint8_t *bit = at(s, range);
    for (unsigned int i = 0; bits && i < range->count; i++)
        values[i] = bit[i];
    if (!bits)
        memcpy(values, at(s, range), range->count * sizeof *values);
    modbus->write(instance, range, values, now_ns);
}

/* libmodbus gets only valid requests, because it reacts to an invalid one by a sleep and discards input. */
static bool reply_to(ect_modbus_server_t *s, int fd, const uint8_t *adu, size_t length, const ect_modbus_t *modbus,
                     void *instance, uint64_t now_ns)
{
    ect_modbus_request_t request;
    ect_modbus_result_t result = ect_modbus_request(adu + PDU_AT, length - PDU_AT, &request);
    if (result == ECT_MODBUS_DONE && request.write.count > 0)
        result = modbus->may_write(instance, &request.write);
    if (result == ECT_MODBUS_DONE && request.read.count > 0)
        result = read_range(s, modbus, instance, &request.read, now_ns);
    (void)modbus_set_socket(s->replies, fd);
    if (result != ECT_MODBUS_DONE)
        return modbus_reply_exception(s->replies, adu, result) > 0;
    bool sent = modbus_reply(s->replies, adu, (int)length, &s->mapping) > 0;
    if (request.write.count > 0)
        write_range(s, modbus, instance, &request.write, now_ns);
    return sent;
}

/* @return bytes of the reply; 0: none */
static size_t read_reply(ect_modbus_server_t *s, const uint8_t *adu, size_t length, const ect_modbus_t *modbus,
                         void *instance, uint64_t now_ns, uint8_t reply[ECT_MODBUS_ADU])
{
    if (!reply_to(s, s->replied[0], adu, length, modbus, instance, now_ns))
        return 0;
    ssize_t got = read(s->replied[1], reply, ECT_MODBUS_ADU);
    return got > 0 ? (size_t)got : 0;
}

static bool reply_observed(ect_modbus_server_t *s, const client_t *client, const ect_modbus_t *modbus, void *instance,
                           uint64_t now_ns)
{
    uint8_t reply[ECT_MODBUS_ADU];
    size_t length = read_reply(s, client->adu, client->got, modbus, instance, now_ns, reply);
    s->observer(s->observer_ctx, client->adu, client->got, reply, length);
    return length > 0 && send(client->fd, reply, length, MSG_NOSIGNAL | MSG_DONTWAIT) == (ssize_t)length;
}

static bool reply_to_client(ect_modbus_server_t *s, const client_t *client, const ect_modbus_t *modbus, void *instance,
                            uint64_t now_ns)
{
    return s->observer ? reply_observed(s, client, modbus, instance, now_ns)
                       : reply_to(s, client->fd, client->adu, client->got, modbus, instance, now_ns);
}

/* --- a client ----------------------------------------------------------------------------------------------------- */

/* @return length of the request in the buffer; of the header while the header is incomplete */
static size_t size_of(const client_t *client)
{
    return client->got < UNIT_AT ? UNIT_AT : UNIT_AT + (size_t)ect_load_be16(client->adu + LENGTH_AT);
}

/* @return whether the bytes are no request; the start of the next request is then unknown */
static bool is_broken(const client_t *client)
{
    uint16_t length = ect_load_be16(client->adu + LENGTH_AT);
    if (client->got < UNIT_AT)
        return false;
    return ect_load_be16(client->adu + PROTOCOL_AT) != 0 || length < SHORTEST || length > LONGEST ||
           (client->got > PDU_AT && client->adu[PDU_AT] >= EXCEPTIONS);
}

/* Receives available bytes, first of the header, then of the request. @return false: the connection has ended */
static bool receive(client_t *client)
{
    for (unsigned int part = 0; part < 2 && client->got < size_of(client); part++) {
        ssize_t got = recv(client->fd, client->adu + client->got, size_of(client) - client->got, MSG_DONTWAIT);
        if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR))
            return false;
        if (got < 0)
            return true;
        client->got += (size_t)got;
        ECT_ASSERT(client->got <= ECT_MODBUS_ADU);
        if (is_broken(client))
            return false;
    }
    return true;
}

/* @return whether the longest reply fits into the socket; until then the request waits */
static bool has_room(const client_t *client)
{
    struct pollfd fd = {.fd = client->fd, .events = POLLOUT};
    return poll(&fd, 1, 0) > 0;
}

static void set_blocked(const ect_modbus_server_t *s, client_t *client, uint32_t who, bool blocked)
{
    if (client->blocked != blocked && wait_for(s, EPOLL_CTL_MOD, client->fd, blocked ? EPOLLOUT : EPOLLIN, who))
        client->blocked = blocked;
}

/* The request is dropped if no twin replies. */
static bool execute(ect_modbus_server_t *s, client_t *client, ect_chain_t *chain, uint64_t now_ns)
{
    void *instance;
    const ect_modbus_t *modbus = ect_chain_modbus(chain, 0, &instance);
    bool alive = !modbus || reply_to_client(s, client, modbus, instance, now_ns);
    if (modbus) {
        client->idle_ns = now_ns + modbus->idle_ms * NS_PER_MS;
        ect_chain_wake(chain, 0);
    }
    client->got = 0;
    return alive;
}

size_t ect_modbus_server_request(ect_modbus_server_t *s, ect_chain_t *chain, uint64_t now_ns, const uint8_t *request,
                                 size_t length, uint8_t *reply)
{
    void *instance;
    const ect_modbus_t *modbus = ect_chain_modbus(chain, 0, &instance);
    client_t client = {.got = length};
    if (!modbus || length > sizeof client.adu || length < PDU_AT)
        return 0;
    memcpy(client.adu, request, length);
    if (is_broken(&client) || length != size_of(&client))
        return 0;
    size_t replied = read_reply(s, client.adu, length, modbus, instance, now_ns, reply);
    ect_chain_wake(chain, 0);
    return replied;
}

static void serve_client(ect_modbus_server_t *s, uint32_t who, ect_chain_t *chain, uint64_t now_ns)
{
    client_t *client = &s->clients[who];
    bool alive = client->blocked || receive(client);
    if (alive && client->got == size_of(client)) {
        bool room = has_room(client);
        set_blocked(s, client, who, !room);
        alive = !room || execute(s, client, chain, now_ns);
    }
    if (!alive)
        drop(client);
}

/* --- new connections ---------------------------------------------------------------------------------------------- */

static uint32_t free_place(const ect_modbus_server_t *s, const ect_modbus_t *modbus)
{
    for (uint32_t i = 0; i < modbus->connections && i < ECT_MODBUS_CLIENTS; i++) {
        if (s->clients[i].fd < 0)
            return i;
    }
    return ECT_MODBUS_CLIENTS;
}

static void accept_client(ect_modbus_server_t *s, const ect_chain_t *chain, uint64_t now_ns)
{
    const int on = 1;
    void *instance;
    const ect_modbus_t *modbus = ect_chain_modbus(chain, 0, &instance);
    int fd = accept4(s->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) {
        bool lasts = errno != EAGAIN && errno != EINTR && errno != ECONNABORTED; /* no descriptor is free */
        if (lasts && wait_for(s, EPOLL_CTL_MOD, s->fd, 0, ACCEPT))
            s->retry_ns = now_ns + RETRY_NS;
        return;
    }
    uint32_t who = modbus ? free_place(s, modbus) : ECT_MODBUS_CLIENTS;
    if (who == ECT_MODBUS_CLIENTS || !wait_for(s, EPOLL_CTL_ADD, fd, EPOLLIN, who)) {
        close(fd);
        return;
    }
    (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    client_t *client = &s->clients[who];
    client->fd = fd;
    client->blocked = false;
    client->got = 0;
    client->idle_ns = now_ns + modbus->idle_ms * NS_PER_MS;
}

/* --- functions for the event loop --------------------------------------------------------------------------------- */

uint64_t ect_modbus_server_due(const ect_modbus_server_t *s)
{
    return s->due_ns;
}

static uint64_t find_due(const ect_modbus_server_t *s)
{
    uint64_t due_ns = s->retry_ns;
    for (size_t i = 0; i < ECT_MODBUS_CLIENTS; i++) {
        if (s->clients[i].fd >= 0)
            due_ns = ect_earlier(due_ns, s->clients[i].idle_ns);
    }
    return due_ns;
}

static void read_events(ect_modbus_server_t *s, uint64_t now_ns)
{
    struct epoll_event events[WAITABLE];
    for (size_t i = 0; i < ECT_MODBUS_CLIENTS; i++) {
        if (s->clients[i].fd >= 0 && now_ns >= s->clients[i].idle_ns)
            drop(&s->clients[i]);
    }
    if (now_ns >= s->retry_ns && wait_for(s, EPOLL_CTL_MOD, s->fd, EPOLLIN, ACCEPT))
        s->retry_ns = ECT_NEVER;
    int count = epoll_wait(s->epoll, events, WAITABLE, 0);
    s->ready = 0;
    for (int i = 0; i < count; i++)
        s->ready |= 1u << events[i].data.u32;
}

static void serve_next(ect_modbus_server_t *s, ect_chain_t *chain, uint64_t now_ns)
{
    for (uint32_t i = 0; i < WAITABLE && s->ready != 0; i++) {
        uint32_t who = s->turn;
        s->turn = (s->turn + 1) % WAITABLE;
        if ((s->ready & 1u << who) == 0)
            continue;
        if (who == ACCEPT)
            accept_client(s, chain, now_ns);
        else
            serve_client(s, who, chain, now_ns);
        return;
    }
}

void ect_modbus_server_serve(ect_modbus_server_t *s, ect_chain_t *chain, uint64_t now_ns)
{
    read_events(s, now_ns);
    serve_next(s, chain, now_ns);
    s->due_ns = find_due(s);
}
