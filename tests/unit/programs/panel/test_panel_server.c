/* SPDX-License-Identifier: MIT */
/* The server of the panel on a clock of the test: the functions of libwebsockets that it calls are those of the test,
 * and its control sockets are one end of a socket pair each. A test runs in the loop of the server, as browser and as
 * twin. */
#define _GNU_SOURCE
#include "server.h"

#include <errno.h>
#include <libwebsockets.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

#include "content.h"
#include "finder.h"
#include "page.h"

enum { SOCKETS = 128, HEADERS = 6, CONNECTIONS = 64, POLL = 25, TEXT = 65536 };

#define TICK_US  40000
#define TOKEN    "0123456789abcdef0123456789abcdef"
#define HOST     "127.0.0.1:4711"
#define ORIGIN   "http://" HOST
#define GREETING "{\"token\":\"" TOKEN "\"}"

struct lws_context {
    void *user;
};

struct lws_vhost {
    const struct lws_protocols *protocols;
};

struct lws {
    const struct lws_protocols *protocol;
    void *user;
    int fd, other_end; /* of a control socket */
    bool asked;        /* to be called when it can be written */
    bool killed;
    const char *host, *origin, *uri; /* headers; NULL: none */
    bool binary, more;               /* the frame that it receives is binary, or not the last one */
    size_t remaining;                /* bytes of that frame that follow */
};

static struct {
    struct lws_context context;
    struct lws_vhost vhost;
    struct lws sockets[SOCKETS];
    size_t count;
    struct lws_context_creation_info context_info, vhost_info;
    bool no_context, no_vhost, no_adoption;
    int port;
    unsigned int destroyed, ready;
    lws_usec_t now_us, interval_us;
    lws_sorted_usec_list_t *timer;
    sul_cb_t tick;
    void (*body)(void);
    unsigned int turns;
    bool silent;
    /* replies */
    int head_fails_at; /* number of the call for a head that fails; 0: none */
    unsigned int status;
    const char *type;
    lws_filepos_t length;
    const char *header[HEADERS][2];
    size_t headers, heads;
    bool closes, short_write;
    unsigned int completed;
    unsigned int writes;
    size_t written;
    enum lws_write_protocol kind;
    char text[LWS_PRE + PAGE_MESSAGE];
    /* twins */
    buses_t *buses;
    finder_taker_t take, take_trace;
    void *ctx, *trace_ctx;
    unsigned int searches, connects;
    size_t send_most; /* 0: all */
    int send_error, receive_error;
    unsigned int sends;
} m;

static server_options_t options;

/* --- libwebsockets ------------------------------------------------------------------------------------------------ */

void lws_set_log_level(int level, void (*log)(int level, const char *line))
{
    assert_int_equal(level, 0);
    assert_null(log);
    m.silent = true;
}

struct lws_context *lws_create_context(const struct lws_context_creation_info *info)
{
    m.context_info = *info;
    m.context.user = info->user;
    return m.no_context ? NULL : &m.context;
}

struct lws_vhost *lws_create_vhost(struct lws_context *context, const struct lws_context_creation_info *info)
{
    assert_ptr_equal(context, &m.context);
    m.vhost_info = *info;
    m.vhost.protocols = info->protocols;
    return m.no_vhost ? NULL : &m.vhost;
}

int lws_get_vhost_listen_port(struct lws_vhost *vhost)
{
    assert_ptr_equal(vhost, &m.vhost);
    return m.port;
}

void lws_context_destroy(struct lws_context *context)
{
    assert_ptr_equal(context, &m.context);
    m.destroyed++;
}

void *lws_context_user(struct lws_context *context)
{
    return context->user;
}

struct lws_context *lws_get_context(const struct lws *wsi)
{
    assert_non_null(wsi);
    return &m.context;
}

void lws_sul_schedule(struct lws_context *context, int thread, lws_sorted_usec_list_t *timer, sul_cb_t tick,
                      lws_usec_t interval_us)
{
    assert_ptr_equal(context, &m.context);
    assert_int_equal(thread, 0);
    m.timer = timer;
    m.tick = tick;
    m.interval_us = interval_us;
}

/* The test runs in the second turn of the loop, and ends it. */
int lws_service(struct lws_context *context, int timeout_ms)
{
    assert_ptr_equal(context, &m.context);
    (void)timeout_ms;
    if (++m.turns == 1)
        return 0;
    assert_int_equal(m.turns, 2);
    m.body();
    return -1;
}

lws_usec_t lws_now_usecs(void)
{
    return m.now_us;
}

void *lws_wsi_user(struct lws *wsi)
{
    return wsi->user;
}

lws_sockfd_type lws_get_socket_fd(struct lws *wsi)
{
    return wsi->fd;
}

int lws_callback_on_writable(struct lws *wsi)
{
    wsi->asked = true;
    return 1;
}

void lws_set_timeout(struct lws *wsi, enum pending_timeout reason, int seconds)
{
    assert_int_equal(reason, PENDING_TIMEOUT_USER_OK);
    assert_int_equal(seconds, LWS_TO_KILL_ASYNC);
    wsi->killed = true;
}

static const char *header_of(const struct lws *wsi, enum lws_token_indexes name)
{
    return name == WSI_TOKEN_HOST      ? wsi->host
           : name == WSI_TOKEN_ORIGIN  ? wsi->origin
           : name == WSI_TOKEN_GET_URI ? wsi->uri
                                       : NULL;
}

int lws_hdr_copy(struct lws *wsi, char *to, int room, enum lws_token_indexes name)
{
    const char *text = header_of(wsi, name);
    if (!text) /* the content of the room is any */
        strcpy(to, name == WSI_TOKEN_HOST ? HOST : ORIGIN);
    if (text && (int)strlen(text) >= room)
        return -1;
    if (text)
        strcpy(to, text);
    return text ? (int)strlen(text) : 0;
}

int lws_hdr_total_length(struct lws *wsi, enum lws_token_indexes name)
{
    const char *text = header_of(wsi, name);
    return text ? (int)strlen(text) : 0;
}

static int head_result(void)
{
    return (int)++m.heads == m.head_fails_at ? 1 : 0;
}

int lws_add_http_common_headers(struct lws *wsi, unsigned int status, const char *type, lws_filepos_t length,
                                unsigned char **at, unsigned char *end)
{
    (void)wsi;
    assert_true(end - *at >= 1024);
    m.status = status;
    m.type = type;
    m.length = length;
    return head_result();
}

int lws_add_http_header_by_name(struct lws *wsi, const unsigned char *name, const unsigned char *value, int length,
                                unsigned char **at, unsigned char *end)
{
    (void)wsi;
    assert_true(*at < end);
    assert_true(m.headers < HEADERS);
    assert_int_equal(length, strlen((const char *)value));
    m.header[m.headers][0] = (const char *)name;
    m.header[m.headers++][1] = (const char *)value;
    return head_result();
}

int lws_finalize_write_http_header(struct lws *wsi, unsigned char *start, unsigned char **at, unsigned char *end)
{
    (void)wsi;
    assert_true(start == *at && *at < end);
    memset(start - LWS_PRE, 0xFF, LWS_PRE); /* which belongs to libwebsockets */
    return head_result();
}

int lws_http_transaction_completed(struct lws *wsi)
{
    (void)wsi;
    m.completed++;
    return m.closes ? 1 : 0;
}

int lws_write(struct lws *wsi, unsigned char *bytes, size_t length, enum lws_write_protocol kind)
{
    (void)wsi;
    assert_true(length < sizeof m.text);
    memcpy(m.text, bytes, length);
    m.text[length] = 0;
    memset(bytes - LWS_PRE, 0xFF, LWS_PRE); /* which belongs to libwebsockets */
    m.writes++;
    m.written = length;
    m.kind = kind;
    return (int)length - m.short_write;
}

int lws_frame_is_binary(struct lws *wsi)
{
    return wsi->binary;
}

int lws_is_final_fragment(struct lws *wsi)
{
    return !wsi->more;
}

size_t lws_remaining_packet_payload(struct lws *wsi)
{
    return wsi->remaining;
}

static struct lws *new_socket(const char *name)
{
    const struct lws_protocols *protocol = m.vhost.protocols;
    assert_true(m.count < SOCKETS);
    while (protocol->name && strcmp(protocol->name, name) != 0)
        protocol++;
    assert_non_null(protocol->name);
    struct lws *wsi = &m.sockets[m.count++];
    *wsi = (struct lws){
        .protocol = protocol, .user = calloc(1, protocol->per_session_data_size), .fd = -1, .other_end = -1};
    assert_non_null(wsi->user);
    return wsi;
}

static int call(struct lws *wsi, enum lws_callback_reasons reason, const void *bytes, size_t length)
{
    return wsi->protocol->callback(wsi, reason, wsi->user, (void *)(uintptr_t)bytes, length);
}

struct lws *lws_adopt_descriptor_vhost(struct lws_vhost *vhost, lws_adoption_type type, lws_sock_file_fd_type fd,
                                       const char *protocol, struct lws *parent)
{
    assert_ptr_equal(vhost, &m.vhost);
    assert_int_equal(type, LWS_ADOPT_RAW_FILE_DESC);
    assert_null(parent);
    if (m.no_adoption)
        return NULL;
    struct lws *wsi = new_socket(protocol);
    wsi->fd = fd.filefd;
    assert_int_equal(call(wsi, LWS_CALLBACK_RAW_ADOPT_FILE, NULL, 0), 0); /* it has no bus yet */
    return wsi;
}

/* --- twins -------------------------------------------------------------------------------------------------------- */

void __wrap_finder_search(buses_t *buses, finder_taker_t take, void *ctx);
void __wrap_finder_connect(bus_t *bus, finder_taker_t take, void *ctx);
ssize_t __real_send(int fd, const void *bytes, size_t length, int flags);
ssize_t __wrap_send(int fd, const void *bytes, size_t length, int flags);
ssize_t __real_recv(int fd, void *bytes, size_t room, int flags);
ssize_t __wrap_recv(int fd, void *bytes, size_t room, int flags);

void __wrap_finder_search(buses_t *buses, finder_taker_t take, void *ctx)
{
    m.searches++;
    m.buses = buses;
    m.take = take;
    m.ctx = ctx;
}

void __wrap_finder_connect(bus_t *bus, finder_taker_t take, void *ctx)
{
    (void)bus;
    m.connects++;
    m.take_trace = take;
    m.trace_ctx = ctx;
}

ssize_t __wrap_send(int fd, const void *bytes, size_t length, int flags)
{
    m.sends++;
    if (m.send_error) {
        errno = m.send_error;
        return -1;
    }
    return __real_send(fd, bytes, m.send_most > 0 && m.send_most < length ? m.send_most : length, flags);
}

ssize_t __wrap_recv(int fd, void *bytes, size_t room, int flags)
{
    if (m.receive_error) {
        errno = m.receive_error;
        return -1;
    }
    return __real_recv(fd, bytes, room, flags);
}

/* A new control socket of a bus, as the finder takes it. */
static struct lws *connect_with(finder_taker_t take, void *ctx, bus_t *bus, long process)
{
    int ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends), 0);
    take(ctx, bus, ends[0], process);
    struct lws *wsi = &m.sockets[m.count - 1];
    assert_int_equal(wsi->fd, ends[0]);
    wsi->other_end = ends[1];
    return wsi;
}

static bus_t *add_bus(void)
{
    bus_t *bus = calloc(1, sizeof *bus);
    assert_non_null(bus);
    assert_non_null(m.buses);
    bus->number = ++m.buses->numbers;
    m.buses->all[m.buses->count++] = bus;
    return bus;
}

/* The last bus of the list becomes the first one. */
static void turn_list(void)
{
    bus_t *last = m.buses->all[m.buses->count - 1];
    memmove(m.buses->all + 1, m.buses->all, (m.buses->count - 1) * sizeof(bus_t *));
    m.buses->all[0] = last;
}

/* All that the twin has received, once the server has sent what it wants to send. */
static const char *requests(struct lws *wsi)
{
    static char text[TEXT];
    size_t length = 0;
    for (bool more = true; more;) {
        more = wsi->asked;
        wsi->asked = false;
        if (more)
            assert_int_equal(call(wsi, LWS_CALLBACK_RAW_WRITEABLE_FILE, NULL, 0), 0);
        const ssize_t got = __real_recv(wsi->other_end, text + length, sizeof text - 1 - length, 0);
        length += got > 0 ? (size_t)got : 0;
    }
    text[length] = 0;
    return text;
}

/* @return the result of the callback */
static int from_twin(struct lws *wsi, const char *text)
{
    assert_int_equal(__real_send(wsi->other_end, text, strlen(text), 0), strlen(text));
    return call(wsi, LWS_CALLBACK_RAW_RX_FILE, NULL, 0);
}

#define ABOUT           "{\"op\":\"about\"}\n"
#define LIST            "{\"op\":\"list\",\"slave\":0}\n"
#define OTHERS          "{\"op\":\"stats\"}\n{\"op\":\"fault\"}\n{\"op\":\"events\",\"after\":0}\n"
#define WATCH           "{\"op\":\"watch\",\"slave\":0}\n"
#define OK              "{\"ok\":true}\n"
#define SIGNAL          "{\"slave\":1,\"name\":\"a\",\"value\":1}\n"
#define EVERY           "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\",\"every\":true}\n"
#define SET             "{\"op\":\"set\",\"name\":\"a\",\"value\":1}"
#define REST            "{\"op\":\"set\",\"name\":\"a\",\"value\":0}\n"
#define HOLD            "{\"id\":3,\"bus\":1,\"request\":" SET ",\"rest\":0}"
#define ASK(id)         "{\"id\":" id ",\"bus\":1,\"request\":" SET "}"
#define GONE(id)        REPLY(id, "{\"ok\":false,\"message\":\"the bus has ended, or does not reply\"}")
#define REPLY(id, text) "{\"event\":\"reply\",\"id\":" id ",\"reply\":" text "}"

/* --- pages -------------------------------------------------------------------------------------------------------- */

static void ticks(unsigned int count)
{
    for (unsigned int i = 0; i < count; i++) {
        m.now_us += m.interval_us;
        m.tick(m.timer);
    }
}

static int receive(struct lws *page, const char *text)
{
    return call(page, LWS_CALLBACK_RECEIVE, text, strlen(text));
}

/* The next message that a page is sent; "": none. */
static const char *next(struct lws *page)
{
    m.text[0] = 0;
    while (page->asked && m.text[0] == 0) {
        page->asked = false;
        m.kind = LWS_WRITE_TEXT;
        m.writes = 0;
        assert_int_equal(call(page, LWS_CALLBACK_SERVER_WRITEABLE, NULL, 0), 0);
        assert_int_equal(m.kind, LWS_WRITE_TEXT);
        assert_int_equal(m.writes, m.text[0] != 0);
    }
    return m.text;
}

static void skip_messages(struct lws *page)
{
    while (next(page)[0] != 0) {
    }
}

static struct lws *stranger(void)
{
    struct lws *page = new_socket("ectwin-panel");
    page->host = HOST;
    page->origin = ORIGIN;
    memset(page->user, 0xA5, page->protocol->per_session_data_size); /* of earlier requests */
    assert_int_equal(call(page, LWS_CALLBACK_FILTER_NETWORK_CONNECTION, NULL, 0), 0);
    assert_int_equal(call(page, LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED, NULL, 0), 0);
    assert_int_equal(call(page, LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION, NULL, 0), 0);
    assert_int_equal(call(page, LWS_CALLBACK_ESTABLISHED, NULL, 0), 0);
    return page;
}

/* A page with the token, which has received the list of buses. */
static struct lws *known_page(void)
{
    struct lws *page = stranger();
    assert_int_equal(receive(page, GREETING), 0);
    skip_messages(page);
    ticks(1);
    skip_messages(page);
    return page;
}

static void leave(struct lws *page)
{
    assert_int_equal(call(page, LWS_CALLBACK_CLOSED, NULL, 0), 0);
    assert_int_equal(call(page, LWS_CALLBACK_WSI_DESTROY, NULL, 0), 0);
}

/* A bus with one signal, which a page shows. */
static struct lws *open_bus(struct lws *page)
{
    bus_t *bus = add_bus();
    struct lws *twin = connect_with(m.take, m.ctx, bus, 42);
    assert_string_equal(requests(twin), ABOUT);
    assert_int_equal(from_twin(twin, "{\"slaves\":1}\n" OK), 0);
    assert_int_equal(receive(page, "{\"open\":1}"), 0);
    ticks(POLL);
    assert_string_equal(requests(twin), ABOUT LIST OTHERS);
    assert_int_equal(from_twin(twin, "{\"slaves\":1}\n" OK SIGNAL OK "{\"frames\":1}\n{\"answers\":[]}\n" OK OK OK), 0);
    assert_string_equal(requests(twin), WATCH);
    assert_int_equal(from_twin(twin, OK), 0);
    ticks(1);
    skip_messages(page);
    return twin;
}

/* --- start and end ------------------------------------------------------------------------------------------------ */

static void ready(void *ctx, unsigned int port)
{
    assert_ptr_equal(ctx, &m);
    assert_int_equal(port, m.port);
    m.ready++;
}

static int begin(void **state)
{
    (void)state;
    memset(&m, 0, sizeof m);
    (void)signal(SIGPIPE, SIG_DFL);
    (void)signal(SIGINT, SIG_DFL);
    (void)signal(SIGTERM, SIG_DFL);
    m.port = 4711;
    m.now_us = 1000000000;
    options = (server_options_t){.address = "127.0.0.1", .port = 80, .token = TOKEN};
    return 0;
}

static int finish(void **state)
{
    (void)state;
    for (size_t i = 0; i < m.count; i++) {
        free(m.sockets[i].user);
        if (m.sockets[i].fd >= 0)
            close(m.sockets[i].fd);
        if (m.sockets[i].other_end >= 0)
            close(m.sockets[i].other_end);
    }
    return 0;
}

static void serve(void (*body)(void))
{
    m.body = body;
    assert_true(server_run(&options, "test", ready, &m));
    assert_int_equal(m.turns, 2);
    assert_int_equal(m.ready, 1);
    assert_int_equal(m.destroyed, 1);
}

/* The test of a row runs in the loop of the server. */
static void in_the_loop(void **state)
{
    void (*const *body)(void) = *state;
    serve(*body);
}

static void limits(void)
{
    struct sigaction pipe;
    assert_true(m.silent);
    assert_int_equal(sigaction(SIGPIPE, NULL, &pipe), 0);
    assert_true(pipe.sa_handler == SIG_IGN);
    assert_int_equal(m.context_info.port, CONTEXT_PORT_NO_LISTEN);
    assert_int_equal(m.context_info.options, LWS_SERVER_OPTION_EXPLICIT_VHOSTS);
    assert_int_equal(m.context_info.fd_limit_per_thread, CONNECTIONS + 2 * BUS_MOST + 16);
    assert_int_equal(m.vhost_info.port, 80);
    assert_string_equal(m.vhost_info.iface, "127.0.0.1");
    assert_int_equal(m.vhost_info.options,
                     LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8);
    assert_int_equal(m.vhost_info.timeout_secs, 5);
    assert_int_equal(m.vhost_info.keepalive_timeout, 5);
    assert_int_equal(m.vhost.protocols[0].rx_buffer_size, REQUEST_TEXT);
    assert_int_equal(m.interval_us, TICK_US);
    m.interval_us = 0;
    m.tick(m.timer);
    assert_int_equal(m.interval_us, TICK_US);
    assert_int_equal(m.searches, 0);
}

static void no_start(void **state)
{
    static const struct {
        bool no_context, no_vhost;
        int port;
        unsigned int destroyed;
    } rows[] = {{true, false, 4711, 0}, {false, true, 4711, 1}, {false, false, 0, 1}, {false, false, -1, 1}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char text[512] = "";
        begin(state);
        m.no_context = rows[i].no_context;
        m.no_vhost = rows[i].no_vhost;
        m.port = rows[i].port;
        const int errors = memfd_create("errors", MFD_CLOEXEC), before = dup(STDERR_FILENO);
        (void)dup2(errors, STDERR_FILENO);
        const bool served = server_run(&options, "test", ready, &m);
        (void)dup2(before, STDERR_FILENO);
        assert_true(pread(errors, text, sizeof text - 1, 0) > 0);
        close(errors);
        close(before);
        assert_false(served);
        assert_int_equal(m.ready, 0);
        assert_int_equal(m.destroyed, rows[i].destroyed);
        assert_string_equal(text,
                            "test: cannot listen at 127.0.0.1, port 80: another program has it, or the address is "
                            "not of this machine; --port 0 takes any port\n");
    }
}

static void nothing(void)
{
}

static void ports(void **state)
{
    static const int numbers[] = {1, 65535};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        begin(state);
        m.port = numbers[i];
        serve(nothing);
    }
}

static void signals_arrive(void)
{
    assert_int_equal(raise(SIGINT), 0);
    assert_int_equal(raise(SIGTERM), 0);
}

/* The loop does not begin another turn, whatever the result of the last one. */
static void the_end(void **state)
{
    (void)state;
    serve(signals_arrive);
    m.turns = 0;
    m.body = signals_arrive;
    assert_true(server_run(&options, "test", ready, &m));
    assert_int_equal(m.turns, 0);
}

static void hold_until_the_end(void)
{
    struct lws *page = known_page(), *twin = open_bus(page);
    bus_t *other = add_bus();
    struct lws *idle = connect_with(m.take, m.ctx, other, 43);
    assert_string_equal(requests(idle), ABOUT);
    turn_list();
    (void)add_bus(); /* without a connection */
    turn_list();
    assert_int_equal(receive(page, HOLD), 0);
    assert_string_equal(requests(twin), SET "\n");
    m.sends = 0;
}

static void release_at_the_end(void **state)
{
    char text[256] = "";
    (void)state;
    serve(hold_until_the_end);
    assert_int_equal(m.sends, 1); /* to the one twin that has requests */
    for (size_t i = 0; i < m.count; i++) {
        if (m.sockets[i].other_end >= 0 && text[0] == 0)
            (void)__real_recv(m.sockets[i].other_end, text, sizeof text - 1, 0);
    }
    assert_string_equal(text, REST);
}

/* --- HTTP --------------------------------------------------------------------------------------------------------- */

static void bounded_connections(void)
{
    struct lws *one = new_socket("ectwin-panel");
    for (int times = 0; times < 2; times++) {
        for (int i = 0; i < CONNECTIONS; i++) {
            assert_int_equal(call(one, LWS_CALLBACK_FILTER_NETWORK_CONNECTION, NULL, 0), 0);
            assert_int_equal(call(one, LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED, NULL, 0), 0);
        }
        assert_int_equal(call(one, LWS_CALLBACK_FILTER_NETWORK_CONNECTION, NULL, 0), -1);
        assert_int_equal(call(one, LWS_CALLBACK_WSI_DESTROY, NULL, 0), 0);
        assert_int_equal(call(one, LWS_CALLBACK_FILTER_NETWORK_CONNECTION, NULL, 0), 0);
        for (int i = 0; i < 2 * CONNECTIONS; i++) /* those of libwebsockets itself, too */
            assert_int_equal(call(one, LWS_CALLBACK_WSI_DESTROY, NULL, 0), 0);
    }
}

static struct lws *browser(void)
{
    struct lws *one = new_socket("ectwin-panel");
    one->host = HOST;
    one->uri = "/";
    m.headers = 0;
    m.heads = 0;
    m.completed = 0;
    return one;
}

static void files(void)
{
    static const char *const names[] = {
        "content-security-policy:",    "x-content-type-options:",       "referrer-policy:",
        "cross-origin-opener-policy:", "cross-origin-resource-policy:", "cache-control:"};
    struct lws *one = browser();
    for (const content_t *file = contents; file->path; file++) {
        m.headers = 0;
        one->asked = false;
        m.completed = 0;
        assert_int_equal(call(one, LWS_CALLBACK_HTTP, file->path, strlen(file->path)), 0);
        assert_int_equal(m.status, HTTP_STATUS_OK);
        assert_string_equal(m.type, file->type);
        assert_int_equal(m.length, file->length);
        assert_int_equal(m.headers, HEADERS);
        for (size_t i = 0; i < HEADERS; i++)
            assert_string_equal(m.header[i][0], names[i]);
        assert_non_null(strstr(m.header[0][1], "default-src 'none'"));
        for (size_t sent = 0; sent < file->length; sent += m.written) {
            const size_t left = file->length - sent;
            assert_true(one->asked);
            assert_int_equal(m.completed, 0);
            one->asked = false;
            assert_int_equal(call(one, LWS_CALLBACK_HTTP_WRITEABLE, NULL, 0), 0);
            assert_int_equal(m.written, left < 4096 ? left : 4096);
            assert_int_equal(m.kind, left <= 4096 ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP);
            assert_memory_equal(m.text, file->bytes + sent, m.written);
        }
        assert_false(one->asked);
        assert_int_equal(m.completed, 1);
    }
}

static void refused_requests(void)
{
    static const struct {
        const char *host, *uri, *path;
        unsigned int status;
    } rows[] = {
        {HOST, "/", "/nosuch", HTTP_STATUS_NOT_FOUND},
        {HOST, NULL, "/", HTTP_STATUS_METHOD_NOT_ALLOWED},
        {"evil.example:4711", "/", "/", HTTP_STATUS_FORBIDDEN},
        {"127.0.0.1:4712", "/", "/", HTTP_STATUS_FORBIDDEN},
        {"127.0.0.1", "/", "/", HTTP_STATUS_FORBIDDEN},
        {NULL, "/", "/", HTTP_STATUS_FORBIDDEN},
        {"[0000:0000:0000:0000:0000:0000:0000:0000:0000:0000:0000:0000:0000:0001]:4711", "/", "/",
         HTTP_STATUS_FORBIDDEN},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (int closes = 0; closes < 2; closes++) {
            struct lws *one = browser();
            one->host = rows[i].host;
            one->uri = rows[i].uri;
            m.closes = closes != 0;
            assert_int_equal(call(one, LWS_CALLBACK_HTTP, rows[i].path, strlen(rows[i].path)), -closes);
            assert_int_equal(m.status, rows[i].status);
            assert_int_equal(m.length, 0);
            assert_int_equal(m.headers, HEADERS);
            assert_int_equal(m.completed, 1);
            assert_false(one->asked);
            assert_int_equal(call(one, LWS_CALLBACK_HTTP_WRITEABLE, NULL, 0), -1); /* it has no file */
        }
    }
}

static void broken_requests(void)
{
    for (int n = 1; n <= HEADERS + 2; n++) {
        struct lws *one = browser();
        m.head_fails_at = n;
        assert_int_equal(call(one, LWS_CALLBACK_HTTP, "/", 1), -1);
        assert_int_equal(m.heads, n);
        assert_false(one->asked);
        one = browser();
        assert_int_equal(call(one, LWS_CALLBACK_HTTP, "/nosuch", 7), -1);
        assert_int_equal(m.completed, 0);
    }
    m.head_fails_at = 0;
    struct lws *one = browser();
    assert_int_equal(call(one, LWS_CALLBACK_HTTP, "/", 1), 0);
    m.short_write = true;
    assert_int_equal(call(one, LWS_CALLBACK_HTTP_WRITEABLE, NULL, 0), -1);
    m.short_write = false;
    m.closes = true;
    int result = 0;
    while (m.completed == 0)
        result = call(one, LWS_CALLBACK_HTTP_WRITEABLE, NULL, 0);
    assert_int_equal(result, -1);
    assert_int_equal(call(one, LWS_CALLBACK_HTTP_BODY, "a", 1), -1);
    assert_int_equal(call(one, LWS_CALLBACK_HTTP_BODY_COMPLETION, NULL, 0), -1);
    assert_int_equal(call(one, LWS_CALLBACK_GET_THREAD_ID, NULL, 0), 0); /* one that the server does not need */
}

static void origins(void)
{
    static const struct {
        const char *host, *origin;
        int result;
    } rows[] = {
        {HOST, ORIGIN, 0},
        {"localhost:4711", "http://localhost:4711", 0},
        {HOST, NULL, -1},
        {HOST, "", -1},
        {NULL, ORIGIN, -1},
        {HOST, "https://" HOST, -1},
        {HOST, "http://localhost:4711", -1},
        {"evil.example:4711", "http://evil.example:4711", -1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct lws *one = browser();
        one->host = rows[i].host;
        one->origin = rows[i].origin;
        assert_int_equal(call(one, LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION, NULL, 0), rows[i].result);
    }
}

/* --- pages -------------------------------------------------------------------------------------------------------- */

static void tokens(void)
{
    struct lws *page = stranger();
    assert_int_equal(receive(page, "{\"token\":\"0123\"}"), -1);
    leave(page);
    page = stranger();
    page->asked = true; /* by libwebsockets */
    assert_string_equal(next(page), "");
    ticks(10);
    assert_string_equal(next(page), ""); /* nothing before its token */
    assert_int_equal(m.searches, 0);
    assert_int_equal(receive(page, GREETING), 0);
    assert_string_equal(next(page), "{\"event\":\"hello\",\"version\":\"" ECTWIN_VERSION "\",\"view\":false}");
    assert_string_equal(next(page), "{\"event\":\"buses\",\"buses\":[]}");
    assert_string_equal(next(page), "");
    ticks(1);
    assert_int_equal(m.searches, 1); /* at once */
    ticks(POLL - 1);
    assert_int_equal(m.searches, 1);
    ticks(1);
    assert_int_equal(m.searches, 2);
    assert_int_equal(receive(page, "{\"open\":1}"), 0);
    ticks(POLL - 1);
    assert_int_equal(m.searches, 2); /* no other message hurries a search */
}

static void a_view(void)
{
    struct lws *page = stranger();
    assert_int_equal(receive(page, GREETING), 0);
    assert_non_null(strstr(next(page), "\"view\":true"));
}

static void a_view_is_informed(void **state)
{
    (void)state;
    options.view = true;
    serve(a_view);
}

static void parts(void)
{
    static char spaces[REQUEST_TEXT + 1];
    struct lws *page = stranger();
    page->more = true;
    assert_int_equal(receive(page, "{\"tok"), 0);
    page->more = false;
    page->remaining = 1;
    assert_int_equal(receive(page, "en\":\"" TOKEN "\""), 0);
    assert_string_equal(next(page), "");
    page->remaining = 0;
    assert_int_equal(receive(page, "}"), 0);
    assert_non_null(strstr(next(page), "\"hello\""));
    skip_messages(page);
    assert_int_equal(receive(page, "{\"open\":7}"), 0); /* a message of its own */
    memset(spaces, ' ', sizeof spaces);
    page->more = true;
    assert_int_equal(call(page, LWS_CALLBACK_RECEIVE, spaces, REQUEST_TEXT - 10), 0);
    page->more = false;
    assert_int_equal(receive(page, "{\"open\":8}"), 0); /* fits to its last byte */
    page->more = true;
    assert_int_equal(call(page, LWS_CALLBACK_RECEIVE, spaces, REQUEST_TEXT - 10), 0);
    page->more = false;
    assert_int_equal(receive(page, " {\"open\":8}"), -1);
    page = known_page();
    page->binary = true;
    assert_int_equal(receive(page, "{\"open\":7}"), -1);
}

/* Five seconds: for the token, and for each message. */
static void late_pages(void)
{
    struct lws *silent = stranger();
    ticks(5000000 / TICK_US);
    assert_false(silent->killed);
    ticks(1);
    assert_true(silent->killed);
    leave(silent);
    struct lws *page = stranger();
    ticks(5000000 / TICK_US);
    assert_int_equal(receive(page, GREETING), 0);
    ticks(5000000 / TICK_US);
    assert_false(page->killed); /* since its token */
    ticks(1);
    assert_true(page->killed);
    leave(page);
    page = known_page();
    ticks(10 * 5000000 / TICK_US);
    assert_false(page->killed); /* nothing waits for it */
    m.buses->changes++;
    ticks(1);
    assert_true(page->asked);
    ticks(5000000 / TICK_US);
    assert_false(page->killed);
    assert_non_null(strstr(next(page), "\"buses\""));
    m.buses->changes++;
    ticks(1 + 5000000 / TICK_US);
    assert_false(page->killed); /* since its last message */
    ticks(1);
    assert_true(page->killed);
}

static void a_page_that_breaks(void)
{
    struct lws *page = stranger();
    assert_int_equal(receive(page, GREETING), 0);
    m.short_write = true;
    assert_int_equal(call(page, LWS_CALLBACK_SERVER_WRITEABLE, NULL, 0), -1);
}

static void pages_that_leave(void)
{
    struct lws *pages[3];
    for (size_t i = 0; i < 3; i++)
        pages[i] = known_page();
    leave(pages[1]); /* between two others */
    leave(pages[1]); /* once more, without effect */
    m.buses->changes++;
    pages[1]->asked = false;
    ticks(1);
    assert_true(pages[0]->asked && pages[2]->asked);
    assert_false(pages[1]->asked);
    leave(pages[2]); /* the newest */
    leave(pages[0]);
    const unsigned int before = m.searches;
    ticks(2 * POLL);
    assert_int_equal(m.searches, before);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static void replies_by_page(void)
{
    struct lws *first = known_page(), *second = known_page(), *third = known_page(), *twin = open_bus(first);
    assert_int_equal(receive(second, "{\"open\":1}"), 0);
    skip_messages(second);
    skip_messages(third);
    assert_int_equal(receive(first, ASK("5")), 0);
    assert_int_equal(receive(third, ASK("6")), 0);
    assert_int_equal(receive(second, ASK("7")), 0);
    assert_string_equal(requests(twin), SET "\n" SET "\n" SET "\n");
    leave(third);
    assert_string_equal(next(first), "");
    assert_int_equal(from_twin(twin, OK OK "{\"ok\":false}\n"), 0);
    assert_string_equal(next(first), REPLY("5", "{\"ok\":true}"));
    assert_string_equal(next(first), "");
    assert_string_equal(next(second), REPLY("7", "{\"ok\":false}"));
    assert_string_equal(next(second), "");
    assert_string_equal(next(third), "");
}

static void requests_to_nobody(void)
{
    struct lws *page = known_page();
    assert_int_equal(receive(page, ASK("5")), 0); /* no bus */
    assert_string_equal(next(page), GONE("5"));
    struct lws *twin = open_bus(page);
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_CLOSE_FILE, NULL, 0), 0);
    skip_messages(page);
    assert_int_equal(receive(page, ASK("6")), 0); /* no connection */
    assert_string_equal(next(page), GONE("6"));
}

/* Forty requests of pages wait at most; releases have room all the same. */
static void a_twin_without_replies(void)
{
    struct lws *pages[4];
    pages[0] = known_page();
    struct lws *twin = open_bus(pages[0]);
    assert_int_equal(receive(pages[0], HOLD), 0);
    for (size_t i = 1; i < 4; i++) {
        pages[i] = known_page();
        for (int n = 0; n < 13; n++)
            assert_int_equal(receive(pages[i], ASK("7")), 0);
        assert_string_equal(next(pages[i]), "");
    }
    assert_int_equal(m.buses->all[0]->link.count, 40);
    assert_int_equal(receive(pages[1], ASK("8")), 0);
    assert_string_equal(next(pages[1]), GONE("8"));
    (void)requests(twin);
    assert_int_equal(receive(pages[0], "{\"open\":0}"), 0);
    assert_string_equal(requests(twin), REST);
    assert_int_equal(from_twin(twin, OK), 0);
    assert_int_equal(receive(pages[1], ASK("9")), 0); /* room for none yet: the release waits, too */
    skip_messages(pages[0]);
    assert_string_equal(next(pages[1]), GONE("9"));
    assert_int_equal(from_twin(twin, OK), 0);
    assert_int_equal(receive(pages[1], ASK("10")), 0);
    assert_string_equal(requests(twin), SET "\n");
}

/* More than the connection keeps for a twin that does not read. */
static void a_twin_that_does_not_read(void)
{
    char text[REQUEST_TEXT];
    struct lws *page = known_page(), *twin = open_bus(page);
    m.send_error = EAGAIN;
    snprintf(text, sizeof text,
             "{\"id\":5,\"bus\":1,\"request\":{\"op\":\"set\",\"name\":\"a\",\"value\":\"%03000d\"}}", 0);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(receive(page, text), 0);
        assert_string_equal(next(page), "");
        assert_int_equal(call(twin, LWS_CALLBACK_RAW_WRITEABLE_FILE, NULL, 0), 0);
    }
    assert_int_equal(receive(page, text), 0);
    assert_string_equal(next(page), GONE("5"));
    m.send_error = 0;
    twin->asked = true;
    const char *got = requests(twin);
    assert_int_equal(strlen(got), 5 * strlen("{\"op\":\"set\",\"name\":\"a\",\"value\":\"\"}\n") + 5 * 3000);
}

/* --- held signals ------------------------------------------------------------------------------------------------- */

static struct lws *holder(struct lws **twin)
{
    struct lws *page = known_page();
    *twin = open_bus(page);
    assert_int_equal(receive(page, HOLD), 0);
    assert_string_equal(requests(*twin), SET "\n");
    assert_int_equal(from_twin(*twin, OK), 0);
    skip_messages(page);
    return page;
}

static void expect_ping(struct lws *page)
{
    assert_true(page->asked);
    page->asked = false;
    assert_int_equal(call(page, LWS_CALLBACK_SERVER_WRITEABLE, NULL, 0), 0);
    assert_int_equal(m.kind, LWS_WRITE_PING);
    assert_int_equal(m.written, 1);
    assert_int_equal(m.text[0], 0);
    assert_true(page->asked); /* a message may wait behind it */
    skip_messages(page);
}

/* Each tick, with replies of the twin to the polls. @return whether the twin receives a request to release the signal
 */
static bool released_in(struct lws *page, struct lws *twin, unsigned int count)
{
    bool released = false;
    for (unsigned int i = 0; i < count; i++) {
        ticks(1);
        const char *text = requests(twin);
        released = released || strstr(text, REST) != NULL;
        for (const char *at = text; (at = strchr(at, '\n')) != NULL; at++)
            assert_int_equal(from_twin(twin, OK), 0);
        assert_false(page->killed);
    }
    return released;
}

static void silent_holders(void)
{
    struct lws *twin, *page = holder(&twin);
    for (int pings = 0; pings < 3; pings++) {
        assert_false(released_in(page, twin, 24));
        skip_messages(page);
        assert_false(released_in(page, twin, 1));
        expect_ping(page);
        if (pings == 0)
            continue;
        assert_int_equal(call(page, LWS_CALLBACK_RECEIVE_PONG, NULL, 0), 0);
    }
    assert_false(released_in(page, twin, 75));
    expect_ping(page);
    assert_true(released_in(page, twin, 1));
    skip_messages(page);
    assert_false(released_in(page, twin, 200)); /* once */
}

/* A message is a sign, too. */
static void holders_that_speak(void)
{
    struct lws *twin, *page = holder(&twin);
    assert_false(released_in(page, twin, 74));
    assert_int_equal(receive(page, "{\"trace\":[]}"), 0);
    assert_false(released_in(page, twin, 75));
    m.kind = LWS_WRITE_TEXT;
    assert_true(released_in(page, twin, 1));
}

/* A page that holds nothing gets no ping, and begins to count with what it holds. */
static void pages_that_hold_nothing(void)
{
    struct lws *page = known_page(), *twin = open_bus(page);
    for (int i = 0; i < 100; i++) {
        assert_false(released_in(page, twin, 1));
        skip_messages(page); /* with no ping among the messages */
    }
    assert_int_equal(receive(page, HOLD), 0);
    (void)requests(twin);
    assert_int_equal(from_twin(twin, OK), 0);
    assert_false(released_in(page, twin, 75));
}

static void a_ping_that_fails(void)
{
    struct lws *twin, *page = holder(&twin);
    assert_false(released_in(page, twin, 25));
    m.short_write = true;
    assert_int_equal(call(page, LWS_CALLBACK_SERVER_WRITEABLE, NULL, 0), -1);
}

static void holders_that_leave(void)
{
    struct lws *twin, *page = holder(&twin);
    assert_int_equal(receive(page, "{\"open\":0}"), 0);
    assert_string_equal(requests(twin), REST);
    assert_int_equal(from_twin(twin, OK), 0);
    assert_int_equal(receive(page, HOLD), 0);
    assert_string_equal(requests(twin), SET "\n");
    leave(page);
    assert_string_equal(requests(twin), REST);
    page = known_page();
    assert_int_equal(receive(page, HOLD), 0);
    (void)requests(twin);
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_CLOSE_FILE, NULL, 0), 0);
    twin->asked = false;
    leave(page); /* no connection is left */
    assert_false(twin->asked);
}

/* --- control sockets ---------------------------------------------------------------------------------------------- */

static void pieces(void)
{
    static const int errors[] = {EAGAIN, EINTR};
    struct lws *page = known_page(), *twin = open_bus(page);
    m.send_most = 5;
    ticks(POLL);
    assert_string_equal(requests(twin), ABOUT OTHERS);
    assert_int_equal(from_twin(twin, OK OK OK OK), 0);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(receive(page, ASK("5")), 0);
        twin->asked = false;
        m.send_error = errors[i];
        assert_int_equal(call(twin, LWS_CALLBACK_RAW_WRITEABLE_FILE, NULL, 0), 0);
        assert_true(twin->asked);
        m.send_error = 0;
        assert_string_equal(requests(twin), SET "\n");
    }
    m.send_error = EPIPE;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_WRITEABLE_FILE, NULL, 0), -1);
}

static void ends_of_sockets(void)
{
    struct lws *page = known_page(), *twin = open_bus(page);
    m.receive_error = EAGAIN;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), 0);
    m.receive_error = EINTR;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), 0);
    m.receive_error = ECONNRESET;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), -1);
    m.receive_error = 0;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), 0); /* nothing is there */
    errno = ECONNRESET;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_WRITEABLE_FILE, NULL, 0), 0); /* nothing is to be sent */
    assert_int_equal(from_twin(twin, "{"), 0);
    assert_int_equal(from_twin(twin, "}\n"), -1); /* a reply to no request */
    assert_int_equal(from_twin(twin, "hello\n"), -1);
    close(twin->other_end);
    twin->other_end = -1;
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), -1);
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_CLOSE_FILE, NULL, 0), 0);
    bus_t *bus = m.buses->all[0];
    assert_null(bus->socket);
    assert_int_equal(bus->table.count, 0);
    ticks(POLL);
    struct lws *again = connect_with(m.take, m.ctx, bus, 44);
    assert_ptr_equal(bus->socket, again);
    assert_int_equal(bus->process, 44);
    assert_string_equal(requests(again), ABOUT);
    assert_int_equal(call(again, LWS_CALLBACK_RAW_ADOPT_FILE, NULL, 0), 0); /* one that the server does not need */
}

/* A reply that leads to a request: the list of signals, to their watch. */
static void requests_that_follow(void)
{
    struct lws *page = known_page();
    struct lws *twin = open_bus(page);
    ticks(POLL);
    assert_string_equal(requests(twin), ABOUT OTHERS);
    twin->asked = false;
    assert_int_equal(from_twin(twin, OK OK OK "{\"number\":1}\n"), 0);
    assert_false(twin->asked);
    assert_int_equal(from_twin(twin, OK), 0);
    assert_true(twin->asked);
    assert_string_equal(requests(twin), "{\"op\":\"events\",\"after\":1}\n");
}

static void no_socket(void)
{
    struct lws *page = known_page();
    bus_t *bus = add_bus();
    m.no_adoption = true;
    m.take(m.ctx, bus, -1, 42);
    assert_null(bus->socket);
    assert_int_equal(bus->process, 0);
    assert_int_equal(bus->generation, 0);
    ticks(2 * POLL);
    assert_int_equal(bus->link.count, 0); /* it is not polled */
    assert_false(page->killed);
}

/* Connections to twins exist as long as a page needs them. */
static void needed_connections(void)
{
    struct lws *page = known_page(), *twin = open_bus(page), *second = known_page();
    struct lws *other = connect_with(m.take, m.ctx, add_bus(), 43);
    (void)requests(other);
    assert_int_equal(from_twin(other, "{\"slaves\":2}\n" OK), 0);
    ticks(2 * POLL);
    assert_false(twin->killed);
    assert_false(other->killed); /* the list of buses needs it */
    assert_string_equal(requests(other), ABOUT);
    assert_int_equal(from_twin(other, OK), 0);
    (void)requests(twin);
    assert_int_equal(receive(page, "{\"open\":2}"), 0);
    twin->asked = false;
    ticks(POLL);
    assert_true(twin->killed); /* its watch ends with its connection */
    assert_false(twin->asked);
    assert_false(other->killed);
    assert_string_equal(requests(other), ABOUT LIST OTHERS);
    twin->killed = false;
    leave(second);
    assert_int_equal(receive(page, HOLD), 0);
    leave(page);
    ticks(POLL);
    assert_false(twin->killed); /* a release has to be sent first */
    assert_non_null(strstr(requests(twin), REST));
    assert_true(other->killed);
    ticks(POLL);
    assert_true(twin->killed);
}

/* A page without the token needs none. */
static void strangers_need_no_connection(void)
{
    struct lws *page = known_page(), *twin = open_bus(page);
    (void)stranger();
    leave(page);
    ticks(POLL);
    assert_true(twin->killed);
}

/* --- traces ------------------------------------------------------------------------------------------------------- */

static struct lws *trace_of(bus_t *bus)
{
    return connect_with(m.take_trace, m.trace_ctx, bus, 42);
}

static void traces(void)
{
    struct lws *page = known_page(), *twin = open_bus(page);
    bus_t *bus = m.buses->all[0];
    (void)add_bus(); /* without any */
    turn_list();
    ticks(POLL);
    assert_int_equal(m.connects, 0);
    assert_int_equal(receive(page, "{\"trace\":[0]}"), 0);
    ticks(1);
    assert_int_equal(m.connects, 1);
    struct lws *trace = trace_of(bus);
    assert_ptr_equal(bus->trace.socket, trace);
    ticks(1);
    assert_int_equal(m.connects, 1);
    m.send_most = 7;
    assert_string_equal(requests(trace), EVERY);
    m.send_most = 0;
    ticks(POLL);
    assert_false(trace->asked); /* once */
    assert_int_equal(from_twin(trace, OK "{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":2}\n"), 0);
    skip_messages(page);
    assert_int_equal(from_twin(trace, "{"), 0);
    assert_int_equal(from_twin(trace, "\"slave\":1,\"name\":\"a\",\"value\":0,\"time\":3}\n"), 0);
    ticks(1);
    assert_string_equal(next(page), "{\"event\":\"changes\",\"bus\":1,\"changes\":[[0,3.000000,0]]}");
    m.receive_error = EAGAIN;
    assert_int_equal(call(trace, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), 0);
    m.receive_error = EINTR;
    assert_int_equal(call(trace, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), 0);
    m.receive_error = ECONNRESET;
    assert_int_equal(call(trace, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), -1);
    m.receive_error = 0;
    assert_int_equal(from_twin(trace, "hello\n"), -1);
    assert_false(trace->killed);
    assert_int_equal(receive(page, "{\"trace\":[]}"), 0);
    ticks(1);
    assert_true(trace->killed);
    assert_int_equal(call(trace, LWS_CALLBACK_RAW_CLOSE_FILE, NULL, 0), 0);
    assert_null(bus->trace.socket);
    assert_false(twin->killed);
}

static void traces_tried_again(void)
{
    struct lws *page = known_page(), *twin = open_bus(page);
    bus_t *bus = m.buses->all[0];
    assert_int_equal(receive(page, "{\"trace\":[0]}"), 0);
    ticks(1);
    const unsigned int first = m.connects;
    assert_int_equal(first, 1);
    ticks(2 * POLL); /* one try a second */
    assert_int_equal(m.connects, 3);
    m.no_adoption = true;
    m.take_trace(m.trace_ctx, bus, -1, 42);
    assert_null(bus->trace.socket);
    m.no_adoption = false;
    struct lws *trace = trace_of(bus);
    ticks(1);
    assert_string_equal(requests(trace), EVERY);
    close(trace->other_end);
    trace->other_end = -1;
    assert_int_equal(call(trace, LWS_CALLBACK_RAW_RX_FILE, NULL, 0), -1);
    assert_int_equal(call(trace, LWS_CALLBACK_RAW_CLOSE_FILE, NULL, 0), 0);
    assert_int_equal(bus->trace.watched.count, 0);
    ticks(POLL);
    trace = trace_of(bus);
    ticks(1);
    assert_string_equal(requests(trace), EVERY); /* again, for the new connection */
    assert_int_equal(call(twin, LWS_CALLBACK_RAW_CLOSE_FILE, NULL, 0), 0);
    ticks(1);
    assert_true(trace->killed); /* its signals are no longer known */
}

/* The union of all pages that show the bus, in its present connection. */
static void traces_of_several_pages(void)
{
    struct lws *page = known_page(), *twin = open_bus(page), *second = known_page();
    bus_t *bus = m.buses->all[0];
    (void)twin;
    assert_int_equal(receive(second, "{\"trace\":[0]}"), 0);
    ticks(POLL);
    assert_int_equal(m.connects, 0); /* it shows no bus */
    assert_int_equal(receive(second, "{\"open\":1}"), 0);
    assert_int_equal(receive(second, "{\"trace\":[0]}"), 0);
    ticks(1);
    assert_int_equal(m.connects, 0); /* it has not received the signals yet */
    skip_messages(second);
    assert_int_equal(receive(second, "{\"trace\":[0]}"), 0);
    ticks(1);
    assert_int_equal(m.connects, 1);
    struct lws *trace = trace_of(bus);
    assert_int_equal(receive(page, "{\"trace\":[0]}"), 0);
    leave(second);
    ticks(1);
    assert_false(trace->killed);
    leave(page);
    ticks(1);
    assert_true(trace->killed);
}

#define TEST(title, body)                                                                                              \
    {                                                                                                                  \
        title, in_the_loop, begin, finish, (void *)&(void (*[1])(void))                                                \
        {                                                                                                              \
            body                                                                                                       \
        }                                                                                                              \
    }

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("The server listens with its limits, and searches no twins without a page", limits),
        {"A port that cannot be opened: a line with the cause, and the end", no_start, begin, finish, NULL},
        {"The lowest and the highest port", ports, begin, finish, NULL},
        {"SEC: the server releases held signals at its end", release_at_the_end, begin, finish, NULL},
        TEST("SEC: connections are bounded", bounded_connections),
        TEST("Each file is sent in pieces, with the headers of every reply", files),
        TEST("Requests that are refused get their status", refused_requests),
        TEST("A request that breaks closes its connection", broken_requests),
        TEST("SEC: a page has the Origin of its Host", origins),
        TEST("SEC: a page without its token gets nothing", tokens),
        {"A page of --view is informed", a_view_is_informed, begin, finish, NULL},
        TEST("A message in parts is taken whole, up to its greatest length", parts),
        TEST("SEC: a page has five seconds for its token, and for each message", late_pages),
        TEST("A page that cannot be written is closed", a_page_that_breaks),
        TEST("Pages leave in any order", pages_that_leave),
        TEST("A reply reaches the page that has sent the request", replies_by_page),
        TEST("A request to a bus that has ended is refused", requests_to_nobody),
        TEST("SEC: forty requests wait for a twin at most; releases have room", a_twin_without_replies),
        TEST("A twin that does not read gets no further requests", a_twin_that_does_not_read),
        TEST("SEC: a page that holds signals and does not reply to pings loses them", silent_holders),
        TEST("A message of a page that holds signals is as good as a pong", holders_that_speak),
        TEST("A page that holds nothing gets no ping", pages_that_hold_nothing),
        TEST("A ping that cannot be sent closes the page", a_ping_that_fails),
        TEST("SEC: a page that leaves releases what it holds", holders_that_leave),
        TEST("Requests that a socket takes in pieces arrive whole", pieces),
        TEST("A control socket that ends, or speaks no protocol, is closed", ends_of_sockets),
        TEST("Requests that a reply leads to are sent", requests_that_follow),
        TEST("A socket that libwebsockets does not take is no connection", no_socket),
        TEST("Connections to twins exist as long as a page needs them", needed_connections),
        TEST("SEC: a page without the token keeps no connection to a twin", strangers_need_no_connection),
        TEST("Changes of a plotted signal come over a connection of their own", traces),
        TEST("A connection for changes is tried once a second", traces_tried_again),
        TEST("Several pages share a connection for changes", traces_of_several_pages),
        {"A signal ends the loop", the_end, begin, finish, NULL}, /* the last one: all later loops end, too */
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Panel: server", tests, NULL, NULL);
}
