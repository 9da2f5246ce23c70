/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "server.h"

#include <errno.h>
#include <libwebsockets.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "content.h"
#include "finder.h"
#include "page.h"

enum {
    TICK_US = 40 * LWS_US_PER_MS,     /* pages get values at most this often */
    POLL_TICKS = 25,                  /* buses are searched and queried once a second */
    PATIENCE_US = 5 * LWS_US_PER_SEC, /* time for the token, and for reading a message */
    CONNECTIONS = 64,                 /* of browsers */
    DESCRIPTORS = CONNECTIONS + 2 * BUS_MOST + 16,
    PIECE = 4096, /* of a file, written at a time */
    PING_TICKS = 25,
    SILENT_TICKS = 75,            /* a page that holds signals and does not reply to pings loses them */
    HOST_ROOM = REQUEST_HOST + 8, /* for a name, brackets and a port */
    RESERVE = 24, /* requests without a reply that are left to the panel itself: it may have to release signals */
};

static const char security_policy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

/* Headers of every reply. */
static const char *const headers[][2] = {
    {"content-security-policy:", security_policy},
    {"x-content-type-options:", "nosniff"},
    {"referrer-policy:", "no-referrer"},
    {"cross-origin-opener-policy:", "same-origin"},
    {"cross-origin-resource-policy:", "same-origin"},
    {"cache-control:", "no-store"},
};

/* A connection of a browser: a file that is being sent, or a page. */
typedef struct browser {
    struct browser *next;
    struct lws *wsi;
    const content_t *content;
    size_t sent;
    lws_usec_t since; /* its token, or its next read, has been due since; 0: none */
    size_t received;
    unsigned int silence; /* ticks without a sign of a page that holds signals */
    bool ping;            /* a ping is to be sent */
    char text[REQUEST_TEXT];
    page_t page;
} browser_t;

typedef struct server {
    const server_options_t *options;
    struct lws_context *context;
    struct lws_vhost *vhost;
    unsigned int port;
    size_t connections;
    unsigned long pages;
    browser_t *browsers; /* pages */
    unsigned int ticks;
    lws_sorted_usec_list_t timer;
    buses_t buses;
} server_t;

static volatile sig_atomic_t stopped;

static server_t *server_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* --- HTTP --------------------------------------------------------------------------------------------------------- */

static bool host_is_ours(struct lws *wsi, char host[HOST_ROOM])
{
    return lws_hdr_copy(wsi, host, HOST_ROOM, WSI_TOKEN_HOST) > 0 && request_host_is_ours(host, server_of(wsi)->port);
}

static bool add_headers(struct lws *wsi, unsigned char **at, unsigned char *end)
{
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
        if (lws_add_http_header_by_name(wsi, (const unsigned char *)headers[i][0], (const unsigned char *)headers[i][1],
                                        (int)strlen(headers[i][1]), at, end) != 0)
            return false;
    }
    return true;
}

/* @return false: close the connection */
static bool begin_reply(struct lws *wsi, unsigned int status, const char *type, size_t length)
{
    unsigned char room[LWS_PRE + 1536];
    unsigned char *start = room + LWS_PRE, *at = start, *end = room + sizeof room - 1;
    return lws_add_http_common_headers(wsi, status, type, length, &at, end) == 0 && add_headers(wsi, &at, end) &&
           lws_finalize_write_http_header(wsi, start, &at, end) == 0;
}

/* @return as a callback: 0, or -1 closes the connection */
static int refuse(struct lws *wsi, unsigned int status)
{
    return begin_reply(wsi, status, "text/plain", 0) && lws_http_transaction_completed(wsi) == 0 ? 0 : -1;
}

static int serve_file(struct lws *wsi, browser_t *browser, const char *path)
{
    char host[HOST_ROOM];
    if (!host_is_ours(wsi, host))
        return refuse(wsi, HTTP_STATUS_FORBIDDEN);
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0)
        return refuse(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED);
    browser->content = content_find(path);
    browser->sent = 0;
    if (!browser->content)
        return refuse(wsi, HTTP_STATUS_NOT_FOUND);
    if (!begin_reply(wsi, HTTP_STATUS_OK, browser->content->type, browser->content->length))
        return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int continue_file(struct lws *wsi, browser_t *browser)
{
    unsigned char room[LWS_PRE + PIECE];
    if (!browser->content)
        return -1;
    size_t left = browser->content->length - browser->sent;
    size_t length = left < PIECE ? left : PIECE;
    bool last = length == left;
    memcpy(room + LWS_PRE, browser->content->bytes + browser->sent, length);
    if (lws_write(wsi, room + LWS_PRE, length, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < (int)length)
        return -1;
    browser->sent += length;
    if (last)
        return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
    lws_callback_on_writable(wsi);
    return 0;
}

/* --- pages -------------------------------------------------------------------------------------------------------- */

static void ask_to_write(browser_t *browser)
{
    if (browser->since == 0)
        browser->since = lws_now_usecs();
    lws_callback_on_writable(browser->wsi);
}

static void take_reply(void *ctx, const bus_t *bus, const link_request_t *request, const char *text)
{
    server_t *server = ctx;
    browser_t *browser = server->browsers;
    (void)bus;
    while (browser && browser->page.number != request->page)
        browser = browser->next;
    if (!browser)
        return;
    page_reply(&browser->page, request->id, text);
    ask_to_write(browser);
}

static void pass_on(server_t *server, browser_t *browser, const page_passed_t *passed)
{
    static const char gone[] = "{\"ok\":false,\"message\":\"the bus has ended, or does not reply\"}";
    const link_request_t request = {.kind = LINK_PAGE, .page = browser->page.number, .id = passed->id};
    bus_t *bus = bus_find(&server->buses, passed->bus);
    bool room = bus && bus->socket && bus->link.count < LINK_WAITING - RESERVE;
    if (room && link_ask(&bus->link, passed->line, &request))
        lws_callback_on_writable(bus->socket);
    else
        page_reply(&browser->page, passed->id, gone);
}

/* Returns the signals that a page holds to their rest, a joystick to its centre. */
static void release_held(server_t *server, browser_t *browser)
{
    static const link_request_t request = {.kind = LINK_RELEASE};
    page_passed_t passed;
    while (page_release(&browser->page, &passed)) {
        bus_t *bus = bus_find(&server->buses, passed.bus);
        if (bus && bus->socket && link_ask(&bus->link, passed.line, &request))
            lws_callback_on_writable(bus->socket);
    }
}

/* Takes the bytes that a page has sent so far. @return as a callback */
static int take_message(struct lws *wsi, browser_t *browser, const void *bytes, size_t length)
{
    server_t *server = server_of(wsi);
    page_passed_t passed;
    if (browser->received + length > sizeof browser->text || lws_frame_is_binary(wsi))
        return -1;
    memcpy(browser->text + browser->received, bytes, length);
    browser->received += length;
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi) > 0)
        return 0;
    length = browser->received;
    browser->received = 0;
    browser->silence = 0;
    bool stranger = !browser->page.known;
    switch (page_take(&browser->page, browser->text, length, server->options->token, &passed)) {
    case PAGE_CLOSE:
        return -1;
    case PAGE_PASS_ON:
        pass_on(server, browser, &passed);
        break;
    case PAGE_LEAVE:
        release_held(server, browser);
        break;
    case PAGE_DONE:
        break;
    }
    if (stranger) {
        browser->since = 0;
        server->ticks = 0; /* search at once */
    }
    ask_to_write(browser);
    return 0;
}

static int write_message(struct lws *wsi, browser_t *browser)
{
    unsigned char room[LWS_PRE + PAGE_MESSAGE];
    const server_t *server = server_of(wsi);
    if (!browser->page.known)
        return 0;
    if (browser->ping) {
        browser->ping = false;
        lws_callback_on_writable(wsi);
        room[LWS_PRE] = 0; /* libwebsockets does not report a pong without content */
        return lws_write(wsi, room + LWS_PRE, 1, LWS_WRITE_PING) < 1 ? -1 : 0;
    }
    size_t length = page_next(&browser->page, &server->buses, (char *)room + LWS_PRE);
    browser->since = 0;
    if (length > 0 && lws_write(wsi, room + LWS_PRE, length, LWS_WRITE_TEXT) < (int)length)
        return -1;
    if (page_has_news(&browser->page, &server->buses))
        ask_to_write(browser);
    return 0;
}

/* A browser sends the Origin of the page that connects; the token comes in its first message. */
static int admit(struct lws *wsi)
{
    char host[HOST_ROOM];
    char origin[REQUEST_ORIGIN];
    bool ours = host_is_ours(wsi, host) && lws_hdr_copy(wsi, origin, sizeof origin, WSI_TOKEN_ORIGIN) > 0 &&
                request_origin_is_ours(origin, host);
    return ours ? 0 : -1;
}

static void begin_page(struct lws *wsi, browser_t *browser)
{
    server_t *server = server_of(wsi);
    memset(browser, 0, sizeof *browser);
    browser->wsi = wsi;
    browser->since = lws_now_usecs();
    browser->page.number = ++server->pages;
    browser->page.view = server->options->view;
    browser->next = server->browsers;
    server->browsers = browser;
}

static void end_page(struct lws *wsi, browser_t *browser)
{
    browser_t **at = &server_of(wsi)->browsers;
    release_held(server_of(wsi), browser);
    while (*at && *at != browser)
        at = &(*at)->next;
    if (*at)
        *at = browser->next;
}

static int on_page(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *bytes, size_t length)
{
    switch (reason) {
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        return server_of(wsi)->connections >= CONNECTIONS ? -1 : 0;
    case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED:
        server_of(wsi)->connections++;
        break;
    case LWS_CALLBACK_WSI_DESTROY:
        server_of(wsi)->connections -= server_of(wsi)->connections > 0;
        break;
    case LWS_CALLBACK_HTTP:
        return serve_file(wsi, user, bytes);
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return continue_file(wsi, user);
    case LWS_CALLBACK_HTTP_BODY:
    case LWS_CALLBACK_HTTP_BODY_COMPLETION:
        return -1;
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return admit(wsi);
    case LWS_CALLBACK_ESTABLISHED:
        begin_page(wsi, user);
        break;
    case LWS_CALLBACK_RECEIVE:
        return take_message(wsi, user, bytes, length);
    case LWS_CALLBACK_RECEIVE_PONG:
        ((browser_t *)user)->silence = 0;
        break;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return write_message(wsi, user);
    case LWS_CALLBACK_CLOSED:
        end_page(wsi, user);
        break;
    default:
        break;
    }
    return 0;
}

/* --- buses -------------------------------------------------------------------------------------------------------- */

static int receive(struct lws *wsi, bus_t *bus)
{
    char bytes[16384];
    ssize_t got = recv(lws_get_socket_fd(wsi), bytes, sizeof bytes, MSG_DONTWAIT);
    if (got < 0)
        return errno == EAGAIN || errno == EINTR ? 0 : -1;
    if (got == 0 || !bus_take(&server_of(wsi)->buses, bus, bytes, (size_t)got))
        return -1;
    if (bus->link.unsent > 0)
        lws_callback_on_writable(wsi);
    return 0;
}

static int send_requests(struct lws *wsi, link_t *link)
{
    ssize_t sent = send(lws_get_socket_fd(wsi), link->out, link->unsent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EAGAIN && errno != EINTR)
        return -1;
    link_sent(link, sent > 0 ? (size_t)sent : 0);
    if (link->unsent > 0)
        lws_callback_on_writable(wsi);
    return 0;
}

static int on_bus(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *bytes, size_t length)
{
    bus_t *bus = user ? *(bus_t **)user : NULL;
    (void)bytes;
    (void)length;
    if (!bus)
        return 0;
    switch (reason) {
    case LWS_CALLBACK_RAW_RX_FILE:
        return receive(wsi, bus);
    case LWS_CALLBACK_RAW_WRITEABLE_FILE:
        return send_requests(wsi, &bus->link);
    case LWS_CALLBACK_RAW_CLOSE_FILE:
        bus->socket = NULL;
        bus_disconnected(&server_of(wsi)->buses, bus);
        break;
    default:
        break;
    }
    return 0;
}

/* @return NULL: libwebsockets has closed the descriptor */
static struct lws *adopt(const server_t *server, bus_t *bus, int fd, const char *protocol)
{
    const lws_sock_file_fd_type descriptor = {.filefd = fd};
    struct lws *wsi = lws_adopt_descriptor_vhost(server->vhost, LWS_ADOPT_RAW_FILE_DESC, descriptor, protocol, NULL);
    if (wsi)
        *(bus_t **)lws_wsi_user(wsi) = bus;
    return wsi;
}

/* Takes a new connection of the finder. */
static void take_socket(void *ctx, bus_t *bus, int fd, long process)
{
    server_t *server = ctx;
    bus->socket = adopt(server, bus, fd, "bus");
    if (!bus->socket)
        return;
    bus_connected(&server->buses, bus, process);
    lws_callback_on_writable(bus->socket);
}

/* --- traces ------------------------------------------------------------------------------------------------------- */

static int receive_trace(struct lws *wsi, bus_t *bus)
{
    char bytes[16384];
    ssize_t got = recv(lws_get_socket_fd(wsi), bytes, sizeof bytes, MSG_DONTWAIT);
    if (got < 0)
        return errno == EAGAIN || errno == EINTR ? 0 : -1;
    return got > 0 && trace_take(&bus->trace, &bus->table, bytes, (size_t)got) ? 0 : -1;
}

static int on_trace(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *bytes, size_t length)
{
    bus_t *bus = user ? *(bus_t **)user : NULL;
    (void)bytes;
    (void)length;
    if (!bus)
        return 0;
    switch (reason) {
    case LWS_CALLBACK_RAW_RX_FILE:
        return receive_trace(wsi, bus);
    case LWS_CALLBACK_RAW_WRITEABLE_FILE:
        return send_requests(wsi, &bus->trace.link);
    case LWS_CALLBACK_RAW_CLOSE_FILE:
        bus->trace.socket = NULL;
        trace_restart(&bus->trace);
        break;
    default:
        break;
    }
    return 0;
}

static void take_trace_socket(void *ctx, bus_t *bus, int fd, long process)
{
    (void)process;
    bus->trace.socket = adopt(ctx, bus, fd, "trace");
}

/* A twin reports every change only while a page plots a signal. */
static void poll_trace(server_t *server, bus_t *bus)
{
    trace_set_t wanted = {0};
    for (const browser_t *browser = server->browsers; browser; browser = browser->next) {
        if (browser->page.bus == bus->number && browser->page.generation == bus->generation)
            trace_set_unite(&wanted, &browser->page.traced);
    }
    bus->trace.tried = bus->trace.tried && server->ticks % POLL_TICKS != 0;
    if (wanted.count > 0 && bus->listed && !bus->trace.socket && !bus->trace.tried) {
        bus->trace.tried = true;
        finder_connect(bus, take_trace_socket, server);
    }
    if (!bus->trace.socket)
        return;
    if (wanted.count == 0 || !bus->listed) {
        lws_set_timeout(bus->trace.socket, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
        return;
    }
    trace_want(&bus->trace, &bus->table, &wanted);
    if (bus->trace.link.unsent > 0)
        lws_callback_on_writable(bus->trace.socket);
}

static bool is_open(const server_t *server, const bus_t *bus)
{
    const browser_t *browser = server->browsers;
    while (browser && browser->page.bus != bus->number)
        browser = browser->next;
    return browser != NULL;
}

static bool has_known_page(const server_t *server)
{
    const browser_t *browser = server->browsers;
    while (browser && !browser->page.known)
        browser = browser->next;
    return browser != NULL;
}

/* Without a page there is no connection to a twin. A watch ends with its connection. */
static void poll_buses(server_t *server)
{
    bool wanted = has_known_page(server);
    if (wanted)
        finder_search(&server->buses, take_socket, server);
    for (size_t i = 0; i < server->buses.count; i++) {
        bus_t *bus = server->buses.all[i];
        bool open = is_open(server, bus);
        if (!bus->socket)
            continue;
        bool needed = bus->link.unsent > 0 || (wanted && (open || !bus->watched));
        if (!needed) {
            lws_set_timeout(bus->socket, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
            server->ticks = 0; /* a page may open the bus again soon: connect at the next tick */
            continue;
        }
        bus_poll(bus, open);
        lws_callback_on_writable(bus->socket);
    }
}

/* A page whose network is gone keeps its connection for minutes. Ticks are counted, no time: a machine that stands
 * still is no silent page. */
static void watch_holder(server_t *server, browser_t *browser)
{
    if (browser->page.holds == 0)
        return;
    if (++browser->silence > SILENT_TICKS)
        release_held(server, browser);
    browser->ping = browser->ping || browser->silence % PING_TICKS == 0;
    if (browser->ping)
        lws_callback_on_writable(browser->wsi);
}

static void serve_page(server_t *server, browser_t *browser)
{
    watch_holder(server, browser);
    if (browser->since != 0 && lws_now_usecs() - browser->since > PATIENCE_US) {
        lws_set_timeout(browser->wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
        return;
    }
    browser->page.due = true;
    if (page_has_news(&browser->page, &server->buses))
        ask_to_write(browser);
}

static void tick(lws_sorted_usec_list_t *timer)
{
    server_t *server = lws_container_of(timer, server_t, timer);
    if (server->ticks++ % POLL_TICKS == 0)
        poll_buses(server);
    for (size_t i = 0; i < server->buses.count; i++)
        poll_trace(server, server->buses.all[i]);
    for (browser_t *browser = server->browsers; browser; browser = browser->next)
        serve_page(server, browser);
    lws_sul_schedule(server->context, 0, &server->timer, tick, TICK_US);
}

/* --- start and end ------------------------------------------------------------------------------------------------ */

/* The loop ends at the next tick at the latest. */
static void stop(int number)
{
    (void)number;
    stopped = 1;
}

static const struct lws_protocols protocols[] = {
    {.name = "ectwin-panel",
     .callback = on_page,
     .per_session_data_size = sizeof(browser_t),
     .rx_buffer_size = REQUEST_TEXT},
    {.name = "bus", .callback = on_bus, .per_session_data_size = sizeof(bus_t *)},
    {.name = "trace", .callback = on_trace, .per_session_data_size = sizeof(bus_t *)},
    {0},
};

static bool listen_at(server_t *server, const char *who)
{
    const struct lws_context_creation_info context = {
        .port = CONTEXT_PORT_NO_LISTEN,
        .options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS,
        .fd_limit_per_thread = DESCRIPTORS,
        .user = server,
    };
    const struct lws_context_creation_info vhost = {
        .port = (int)server->options->port,
        .iface = server->options->address,
        .protocols = protocols,
        .vhost_name = "panel",
        .options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8,
        .timeout_secs = PATIENCE_US / LWS_US_PER_SEC,
        .keepalive_timeout = PATIENCE_US / LWS_US_PER_SEC,
    };
    lws_set_log_level(0, NULL);
    server->context = lws_create_context(&context);
    server->vhost = server->context ? lws_create_vhost(server->context, &vhost) : NULL;
    int port = server->vhost ? lws_get_vhost_listen_port(server->vhost) : -1;
    if (port > 0) {
        server->port = (unsigned int)port;
        return true;
    }
    fprintf(stderr,
            "%s: cannot listen at %s, port %u: another program has it, or the address is not of this machine; "
            "--port 0 takes any port\n",
            who, server->options->address, server->options->port);
    if (server->context)
        lws_context_destroy(server->context);
    return false;
}

/* The last requests to the twins; the loop that sends them otherwise has ended. */
static void release_all(server_t *server)
{
    for (browser_t *browser = server->browsers; browser; browser = browser->next)
        release_held(server, browser);
    for (size_t i = 0; i < server->buses.count; i++) {
        bus_t *bus = server->buses.all[i];
        if (bus->socket && bus->link.unsent > 0)
            (void)send_requests(bus->socket, &bus->link);
    }
}

bool server_run(const server_options_t *options, const char *who, void (*ready)(void *ctx, unsigned int port),
                void *ctx)
{
    static server_t server;
    const struct sigaction action = {.sa_handler = stop};
    server = (server_t){.options = options, .buses = {.changes = 1, .reply = take_reply, .ctx = &server}};
    signal(SIGPIPE, SIG_IGN);
    if (!listen_at(&server, who))
        return false;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    lws_sul_schedule(server.context, 0, &server.timer, tick, TICK_US);
    ready(ctx, server.port);
    while (!stopped && lws_service(server.context, 0) >= 0) {
    }
    release_all(&server);
    lws_context_destroy(server.context);
    for (size_t i = 0; i < server.buses.count; i++) {
        table_clear(&server.buses.all[i]->table);
        free(server.buses.all[i]);
    }
    return true;
}
