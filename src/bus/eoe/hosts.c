/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/eoe/hosts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "wire/assert.h"

enum { NONE = -1, READS = 4, WRITES = 4, PATIENCE_NS = 1000000000 };

typedef struct host {
    ect_network_t *network;
    size_t position;
    const char *path; /* of the socket; NULL: a TAP */
    int listener;     /* NONE: a TAP */
    int fd;           /* each read and write is a frame; NONE: no client */
    bool paused;      /* the host's frames wait until the queue has room; its descriptor is not watched */
    uint64_t full_ns; /* last time at which the queue had room; it has been full since */
    char name[ECT_PLACE_NAME];
} host_t;

struct ect_hosts {
    int epoll;
    size_t count, turn;
    host_t **list;
};

ect_hosts_t *ect_hosts_new(void)
{
    ect_hosts_t *h = calloc(1, sizeof *h);
    if (!h)
        return NULL;
    h->epoll = epoll_create1(EPOLL_CLOEXEC);
    if (h->epoll >= 0)
        return h;
    free(h);
    return NULL;
}

/* Removes a descriptor that is not watched from the list, because epoll would report its end even without EPOLLIN. */
static int watch(const ect_hosts_t *h, int fd, bool on)
{
    struct epoll_event event = {.events = EPOLLIN};
    return epoll_ctl(h->epoll, on ? EPOLL_CTL_ADD : EPOLL_CTL_DEL, fd, &event);
}

/* @return whether the place is open; the host owns its descriptors */
static bool open_place(host_t *host, const char *place, char *message)
{
    host->path = ect_place_path(place);
    host->fd = host->listener = NONE;
    if (host->path)
        host->listener = ect_place_listen(host->path, message);
    else
        host->fd = ect_place_tap(place, host->name, message);
    return host->fd != NONE || host->listener != NONE;
}

const char *ect_hosts_open(ect_hosts_t *h, const char *place, ect_network_t *network, size_t position, char *message)
{
    host_t **list = realloc(h->list, (h->count + 1) * sizeof(host_t *));
    host_t *host = calloc(1, sizeof *host);
    h->list = list ? list : h->list;
    snprintf(message, ECT_PLACE_MESSAGE, "not enough memory");
    if (!list || !host || !open_place(host, place, message)) {
        free(host);
        return NULL;
    }
    host->network = network;
    host->position = position;
    h->list[h->count++] = host;
    if (watch(h, host->path ? host->listener : host->fd, true) == 0)
        return host->path ? host->path : host->name;
    snprintf(message, ECT_PLACE_MESSAGE, "waiting for '%s' failed: %s", place, strerror(errno));
    return NULL;
}

static bool is_full(const host_t *host)
{
    return ect_network_has_link(host->network) && ect_network_room(host->network) == 0;
}

/* @return whether the host's frames wait for the master. Without a link, and if the master has fetched no frame for a
 * second, frames are read and lost. */
static bool waits(host_t *host, uint64_t now_ns)
{
    if (is_full(host))
        return now_ns - host->full_ns < PATIENCE_NS;
    host->full_ns = now_ns;
    return false;
}

int ect_hosts_fd(const ect_hosts_t *h)
{
    return h->epoll;
}

uint64_t ect_hosts_due(const ect_hosts_t *h)
{
    uint64_t due_ns = ECT_NEVER;
    uint16_t length;
    for (size_t i = 0; i < h->count; i++) {
        const host_t *host = h->list[i];
        if (ect_network_peek(host->network, &length) || (host->paused && !is_full(host)))
            return 0;
        if (host->paused)
            due_ns = ect_earlier(due_ns, host->full_ns + PATIENCE_NS);
    }
    return due_ns;
}

/* Accepts one client at a time: the next one waits for the end of the present one. */
static void accept_client(const ect_hosts_t *h, host_t *host)
{
    if (host->fd != NONE || host->listener == NONE)
        return;
    host->fd = accept4(host->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (host->fd == NONE)
        return;
    (void)watch(h, host->listener, false);
    (void)watch(h, host->fd, true);
}

/* Handles the end of a client, or a removed TAP. */
static void end_client(const ect_hosts_t *h, host_t *host)
{
    close(host->fd);
    host->fd = NONE;
    host->paused = false;
    if (host->listener != NONE)
        (void)watch(h, host->listener, true);
}

/* @return whether there was a frame for the host */
static bool send_frame(const host_t *host)
{
    uint16_t length = 0;
    const uint8_t *frame = ect_network_peek(host->network, &length);
    if (!frame)
        return false;
    ssize_t sent = NONE;
    if (host->fd != NONE)
        sent = host->path ? send(host->fd, frame, length, MSG_NOSIGNAL) : write(host->fd, frame, length);
    ect_network_next(host->network, sent == length);
    return true;
}

/* @return whether there was a frame of the host */
static bool receive_frame(const ect_hosts_t *h, host_t *host)
{
    uint8_t frame[ECT_EOE_FRAME + 1]; /* one byte more, to detect a frame that is too long */
    ssize_t length = read(host->fd, frame, sizeof frame);
    if (length > 0) {
        ect_network_push(host->network, frame, (size_t)length);
        return true;
    }
    if (length == 0 || (errno != EAGAIN && errno != EINTR && errno != EIO)) /* EIO: the TAP is down */
        end_client(h, host);
    return false;
}

static bool send_frames(const host_t *host)
{
    unsigned int count = 0;
    while (count < WRITES && send_frame(host))
        count++;
    return count > 0;
}

static bool receive_frames(const ect_hosts_t *h, host_t *host, uint64_t now_ns)
{
    unsigned int count = 0;
    while (count < READS && host->fd != NONE && !waits(host, now_ns) && receive_frame(h, host))
        count++;
    return count > 0;
}

static void follow_room(const ect_hosts_t *h, host_t *host, uint64_t now_ns)
{
    bool pause = waits(host, now_ns);
    if (host->fd == NONE || pause == host->paused)
        return;
    host->paused = pause;
    (void)watch(h, host->fd, !pause);
}

void ect_hosts_serve(ect_hosts_t *h, ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t i = 0; i < h->count; i++) {
        host_t *host = h->list[(h->turn + i) % h->count];
        accept_client(h, host);
        bool sent = send_frames(host);
        bool received = receive_frames(h, host, now_ns);
        follow_room(h, host, now_ns);
        if (received)
            ect_chain_wake(chain, host->position);
        if (!sent && !received)
            continue;
        h->turn = (h->turn + i + 1) % h->count;
        return;
    }
}

void ect_hosts_close(ect_hosts_t *h)
{
    for (size_t i = 0; h && i < h->count; i++) {
        host_t *host = h->list[i];
        if (host->fd != NONE)
            close(host->fd);
        if (host->listener != NONE)
            close(host->listener);
        if (host->path)
            (void)unlink(host->path);
        free(host);
    }
    if (!h)
        return;
    close(h->epoll);
    free(h->list);
    free(h);
}
