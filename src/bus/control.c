/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/control.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "bus/signals.h"

enum { REQUEST_ROOM = 1024, WATCH_PERIOD_NS = 10000000, MOST_WAITING = 4 * 1024 * 1024 };

/* A watched signal and what the client was told of it last. */
typedef struct watched {
    ect_signal_ref_t ref;
    size_t slave;
    char told[ECT_SIGNAL_TEXT_ROOM];
} watched_t;

typedef struct client {
    int fd; /* -1: free */
    size_t used;
    char request[REQUEST_ROOM];
    char *waiting; /* what it has not read yet and its socket did not take */
    size_t waiting_length, waiting_room;
    bool every; /* change, not one a period */
    watched_t *watched;
    size_t watched_count;
} client_t;

struct ect_control {
    int fd;
    char path[ECT_CONTROL_PATH];
    client_t clients[ECT_CONTROL_CLIENTS];
    uint64_t next_report_ns;
};

int ect_control_directory(char *path)
{
    const char *runtime = getenv("XDG_RUNTIME_DIR");
    int length = runtime && *runtime ? snprintf(path, ECT_CONTROL_PATH, "%s/ectwin", runtime)
                                     : snprintf(path, ECT_CONTROL_PATH, "/tmp/ectwin-%u", geteuid());
    return length < ECT_CONTROL_PATH - 20 ? 0 : -1;
}

static int make_directory(const char *path)
{
    struct stat info;
    if (mkdir(path, 0700) < 0 && errno != EEXIST)
        return -1;
    if (lstat(path, &info) < 0)
        return -1;
    if (!S_ISDIR(info.st_mode) || info.st_uid != geteuid()) { /* somebody else's: not to be trusted */
        errno = EPERM;
        return -1;
    }
    return chmod(path, 0700);
}

static int listen_at(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -1;
    memcpy(address.sun_path, path, strlen(path) + 1);
    (void)unlink(path);
    mode_t before = umask(0177); /* mode 0600 from its first moment */
    int bound = bind(fd, (const struct sockaddr *)&address, sizeof address);
    umask(before);
    if (bound < 0 || listen(fd, ECT_CONTROL_CLIENTS) < 0) {
        int error = errno;
        close(fd);
        errno = error;
        return -1;
    }
    return fd;
}

ect_control_t *ect_control_open(char *message)
{
    char directory[ECT_CONTROL_PATH] = "";
    ect_control_t *c = calloc(1, sizeof *c);
    if (!c || ect_control_directory(directory) < 0 || make_directory(directory) < 0) {
        snprintf(message, ECT_CONTROL_MESSAGE,
                 "no control socket in '%.80s': %s; XDG_RUNTIME_DIR can name another place", directory,
                 strerror(errno));
        free(c);
        return NULL;
    }
    snprintf(c->path, sizeof c->path, "%.80s/%d.sock", directory, (int)getpid());
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++)
        c->clients[i].fd = -1;
    c->fd = listen_at(c->path);
    if (c->fd < 0) {
        snprintf(message, ECT_CONTROL_MESSAGE, "no control socket at '%s': %s", c->path, strerror(errno));
        free(c);
        return NULL;
    }
    return c;
}

static void drop(client_t *client)
{
    close(client->fd);
    free(client->watched);
    free(client->waiting);
    *client = (client_t){.fd = -1};
}

void ect_control_close(ect_control_t *c)
{
    if (!c)
        return;
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        if (c->clients[i].fd >= 0)
            drop(&c->clients[i]);
    }
    close(c->fd);
    (void)unlink(c->path);
    free(c);
}

const char *ect_control_path(const ect_control_t *c)
{
    return c->path;
}

size_t ect_control_fds(const ect_control_t *c, struct pollfd *fds)
{
    size_t count = 0;
    fds[count++] = (struct pollfd){.fd = c->fd, .events = POLLIN};
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        const client_t *client = &c->clients[i];
        short events = client->waiting_length > 0 ? POLLIN | POLLOUT : POLLIN;
        if (client->fd >= 0)
            fds[count++] = (struct pollfd){.fd = client->fd, .events = events};
    }
    return count;
}

/* --- answers ------------------------------------------------------------------------------------------------------ */

/* As much as its socket takes now; the rest when it takes more. */
static void flush(client_t *client)
{
    ssize_t sent = send(client->fd, client->waiting, client->waiting_length, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) {
        drop(client);
    } else if (sent > 0) {
        client->waiting_length -= (size_t)sent;
        memmove(client->waiting, client->waiting + sent, client->waiting_length);
    }
}

/* @return false: no memory, or the client has not read for so long that it goes */
static bool append(client_t *client, const char *text, size_t length)
{
    if (client->waiting_length + length > client->waiting_room) {
        size_t room = 2 * (client->waiting_length + length);
        char *grown = room > MOST_WAITING ? NULL : realloc(client->waiting, room);
        if (!grown)
            return false;
        client->waiting = grown;
        client->waiting_room = room;
    }
    memcpy(client->waiting + client->waiting_length, text, length);
    client->waiting_length += length;
    return true;
}

static void send_line(client_t *client, cJSON *line)
{
    char *text = cJSON_PrintUnformatted(line);
    cJSON_Delete(line);
    if (text && client->fd >= 0) {
        size_t length = strlen(text);
        text[length] = '\n'; /* in the place of the terminator */
        if (append(client, text, length + 1))
            flush(client);
        else
            drop(client);
    }
    cJSON_free(text);
}

static void send_result(client_t *client, const char *message)
{
    cJSON *line = cJSON_CreateObject();
    cJSON_AddBoolToObject(line, "ok", message == NULL);
    if (message)
        cJSON_AddStringToObject(line, "message", message);
    send_line(client, line);
}

static cJSON *describe(const ect_signal_ref_t *ref, size_t slave)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    cJSON *line = cJSON_CreateObject();
    ect_signal_read(ref, text);
    cJSON_AddNumberToObject(line, "slave", (double)slave + 1);
    cJSON_AddStringToObject(line, "name", ref->name);
    cJSON_AddStringToObject(line, "value", text);
    return line;
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static void add_time(cJSON *line, uint64_t now_ns)
{
    cJSON_AddNumberToObject(line, "time", (double)(now_ns / 1000) / 1e6);
}

typedef struct request {
    client_t *client;
    size_t slave; /* that is being visited */
    uint64_t now_ns;
    bool with_range;
    bool watch;
} request_t;

static void remember(request_t *r, const ect_signal_ref_t *ref)
{
    client_t *client = r->client;
    watched_t *grown = realloc(client->watched, (client->watched_count + 1) * sizeof *grown);
    if (!grown)
        return;
    client->watched = grown;
    watched_t *w = &client->watched[client->watched_count++];
    w->ref = *ref;
    w->slave = r->slave;
    ect_signal_read(ref, w->told);
}

static void answer_one(void *ctx, const ect_signal_ref_t *ref)
{
    request_t *r = ctx;
    if (r->client->fd < 0)
        return;
    cJSON *line = describe(ref, r->slave);
    if (r->with_range) {
        char range[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_range(ref->signal, range);
        cJSON_AddStringToObject(line, "range", range);
        cJSON_AddStringToObject(line, "access", ref->signal->access == ECT_SIGNAL_WRITE ? "rw" : "r");
        cJSON_AddStringToObject(line, "meaning", ref->signal->meaning);
    }
    if (r->watch) {
        remember(r, ref);
        add_time(line, r->now_ns);
    }
    send_line(r->client, line);
}

static void visit(request_t *r, ect_chain_t *chain, const char *pattern, size_t slave)
{
    size_t matched = 0;
    for (size_t i = 0; i < ect_chain_count(chain); i++) {
        if (slave != 0 && slave != i + 1)
            continue;
        r->slave = i;
        matched += ect_chain_signals(chain, i, pattern, answer_one, r);
    }
    if (r->client->fd >= 0 && matched == 0)
        send_result(r->client, "no signal matches: 'ectwin list-signals' names them all");
    else if (r->client->fd >= 0 && !r->watch)
        send_result(r->client, NULL);
}

static void set(client_t *client, ect_chain_t *chain, size_t slave, const char *name, const char *value,
                uint64_t now_ns)
{
    char message[ECT_SIGNAL_MESSAGE];
    ect_signal_ref_t ref;
    if (!ect_chain_signal(chain, slave - 1, name, &ref)) {
        snprintf(message, sizeof message,
                 "slave %zu has no signal '%.60s': 'ectwin list-signals -n %zu' names them all; -n chooses the slave",
                 slave, name, slave);
        send_result(client, message);
        return;
    }
    bool done = ect_signal_write(&ref, value, now_ns, message);
    if (done)
        ect_chain_wake(chain, slave - 1);
    send_result(client, done ? NULL : message);
}

static const char *text_of(const cJSON *request, const char *member, const char *otherwise)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, member));
    return text ? text : otherwise;
}

static void serve_request(client_t *client, ect_chain_t *chain, const char *line, uint64_t now_ns)
{
    cJSON *json = cJSON_Parse(line);
    const char *op = text_of(json, "op", "");
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(json, "slave");
    double slave = cJSON_IsNumber(number) ? number->valuedouble : 1;
    bool is_set = strcmp(op, "set") == 0;
    request_t r = {
        .client = client, .now_ns = now_ns, .with_range = strcmp(op, "list") == 0, .watch = strcmp(op, "watch") == 0};
    client->every |= r.watch && cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(json, "every"));
    if (!(slave >= (is_set ? 1 : 0) && slave <= (double)ect_chain_count(chain)))
        send_result(client, "there is no such slave in this chain");
    else if (is_set)
        set(client, chain, (size_t)slave, text_of(json, "name", ""), text_of(json, "value", ""), now_ns);
    else if (r.with_range || r.watch || strcmp(op, "get") == 0)
        visit(&r, chain, text_of(json, "pattern", "*"), (size_t)slave);
    else
        send_result(client, "a request is {\"op\":\"get|list|set|watch\",...}");
    cJSON_Delete(json);
}

static void receive(client_t *client, ect_chain_t *chain, uint64_t now_ns)
{
    ssize_t got = recv(client->fd, client->request + client->used, sizeof client->request - 1 - client->used, 0);
    if (got <= 0) {
        if (got == 0 || (errno != EAGAIN && errno != EINTR))
            drop(client);
        return;
    }
    client->used += (size_t)got;
    client->request[client->used] = 0;
    char *end = strchr(client->request, '\n');
    while (end) {
        size_t length = (size_t)(end - client->request) + 1;
        *end = 0;
        serve_request(client, chain, client->request, now_ns);
        if (client->fd < 0)
            return;
        memmove(client->request, client->request + length, client->used - length + 1);
        client->used -= length;
        end = strchr(client->request, '\n');
    }
    if (client->used == sizeof client->request - 1) {
        send_result(client, "a request has at most 1000 characters");
        drop(client);
    }
}

static void accept_client(ect_control_t *c)
{
    int fd = accept4(c->fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0)
        return;
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        if (c->clients[i].fd < 0) {
            c->clients[i].fd = fd;
            return;
        }
    }
    close(fd);
}

void ect_control_serve(ect_control_t *c, ect_chain_t *chain, const struct pollfd *fds, size_t count, uint64_t now_ns)
{
    for (size_t n = 1; n < count; n++) {
        if (fds[n].revents == 0)
            continue;
        for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
            client_t *client = &c->clients[i];
            if (client->fd != fds[n].fd)
                continue;
            if ((fds[n].revents & POLLOUT) != 0)
                flush(client);
            if (client->fd >= 0 && (fds[n].revents & ~POLLOUT) != 0)
                receive(client, chain, now_ns);
            break;
        }
    }
    if (count > 0 && fds[0].revents != 0)
        accept_client(c);
}

static void report_changes(client_t *client, uint64_t now_ns)
{
    for (size_t i = 0; i < client->watched_count && client->fd >= 0; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        watched_t *w = &client->watched[i];
        ect_signal_read(&w->ref, text);
        if (strcmp(text, w->told) == 0)
            continue;
        memcpy(w->told, text, sizeof w->told);
        cJSON *line = describe(&w->ref, w->slave);
        add_time(line, now_ns);
        send_line(client, line);
    }
}

/* Those who want every change are told after each poll, the others once a period. */
uint64_t ect_control_report(ect_control_t *c, uint64_t now_ns)
{
    bool due = now_ns >= c->next_report_ns || c->next_report_ns == ECT_NEVER;
    bool periodic = false;
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        client_t *client = &c->clients[i];
        if (client->watched_count > 0 && (due || client->every))
            report_changes(client, now_ns);
        periodic |= client->fd >= 0 && client->watched_count > 0 && !client->every;
    }
    if (!periodic)
        c->next_report_ns = ECT_NEVER;
    else if (due)
        c->next_report_ns = now_ns + WATCH_PERIOD_NS;
    return c->next_report_ns;
}
