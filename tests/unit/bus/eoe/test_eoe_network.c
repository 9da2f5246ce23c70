/* SPDX-License-Identifier: MIT */
/* The network behind a twin with EoE: cable, queues, signals, and the socket of a host. */
#define _GNU_SOURCE
#include "bus/eoe/network.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "bus/chain/settings.h"
#include "bus/eoe/hosts.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SM0 = 0x1800, SM1 = 0x2000, SIZE = 1024, MAIL_HEADER = 6, HEADER = 4, LAST = 1, FRAME = 60 };

/* A device that returns the frames that it accepts. */
typedef struct netdev {
    testdev_t base;
    ect_eoe_state_t eoe;
    uint8_t frame[ECT_EOE_FRAME];
    uint16_t length;
    unsigned int repeats; /* so often the frame is given once more */
    unsigned int sets, loads, resets;
} netdev_t;

static wire_t w;
static ect_network_t *network;
static char folder[64], path[100];

/* The kernel's side of a TAP, a pair of sockets, and of the host's calls. */
static struct {
    int tap;         /* handed out as the TAP; -1: the place is refused */
    int watch_error; /* of epoll_ctl; 0: it is done */
    int read_error;  /* of the next read; 0: it is done */
    unsigned int reads;
    int epoll_error;             /* of epoll_create1; 0: it is done */
    unsigned int memory_refused; /* the nth allocation from now; 0: none */
    uint8_t *guard;              /* behind the last block that was allocated */
} kernel = {.tap = -1};

enum { GUARD = 64, GUARDED = 0xA5 };

int __wrap_ect_place_tap(const char *text, char *name, char *message);
int __real_epoll_create1(int flags);
int __wrap_epoll_create1(int flags);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
int __real_epoll_ctl(int epoll, int operation, int fd, struct epoll_event *event);
int __wrap_epoll_ctl(int epoll, int operation, int fd, struct epoll_event *event);
ssize_t __real_read(int fd, void *bytes, size_t room);
ssize_t __wrap_read(int fd, void *bytes, size_t room);

int __wrap_ect_place_tap(const char *text, char *name, char *message)
{
    (void)snprintf(name, ECT_PLACE_NAME, "%s", text);
    if (kernel.tap < 0)
        (void)snprintf(message, ECT_PLACE_MESSAGE, "no TAP for a test");
    return kernel.tap;
}

int __wrap_epoll_create1(int flags)
{
    errno = kernel.epoll_error;
    return kernel.epoll_error != 0 ? -1 : __real_epoll_create1(flags);
}

void *__wrap_calloc(size_t count, size_t size)
{
    if (kernel.memory_refused > 0 && --kernel.memory_refused == 0)
        return NULL;
    uint8_t *block = __real_calloc(1, count * size + GUARD);
    assert_non_null(block);
    kernel.guard = memset(block + count * size, GUARDED, GUARD);
    return block;
}

int __wrap_epoll_ctl(int epoll, int operation, int fd, struct epoll_event *event)
{
    errno = kernel.watch_error;
    return kernel.watch_error != 0 ? -1 : __real_epoll_ctl(epoll, operation, fd, event);
}

ssize_t __wrap_read(int fd, void *bytes, size_t room)
{
    kernel.reads++;
    if (kernel.read_error == 0)
        return __real_read(fd, bytes, room);
    errno = kernel.read_error;
    kernel.read_error = 0;
    return -1;
}

static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    netdev_t *d = instance;
    (void)eoe;
    (void)port;
    memcpy(d->frame, frame, length);
    d->length = length;
    return true;
}

static uint16_t fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    netdev_t *d = instance;
    (void)eoe;
    (void)port;
    uint16_t length = d->length;
    memcpy(frame, d->frame, length);
    if (d->repeats > 0)
        d->repeats--;
    else
        d->length = 0;
    return length;
}

static uint16_t set(const ect_eoe_t *eoe, void *instance, uint8_t port, const ect_eoe_address_t *address)
{
    (void)eoe;
    (void)port;
    (void)address;
    ((netdev_t *)instance)->sets++;
    return ECT_EOE_OK;
}

static void load(const ect_eoe_t *eoe, void *instance, uint8_t port)
{
    (void)eoe;
    (void)port;
    ((netdev_t *)instance)->loads++;
}

static void reset(const ect_eoe_t *eoe, void *instance)
{
    (void)eoe;
    ((netdev_t *)instance)->resets++;
}

static const ect_eoe_t entry = {
    ECT_EOE_PROTOCOL, offsetof(netdev_t, eoe), .received = received, .fetch = fetch, .set = set,
    .load = load,     .reset = reset};

static const ect_device_t *netdev(void)
{
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    static ect_device_t device;
    device = testdev_with(&entry.protocol, protocols, ECT_MAILBOX_EOE, sizeof(netdev_t));
    device.sm[0].start = SM0;
    device.sm[1].start = SM1;
    for (unsigned int n = 0; n < 2; n++)
        device.sm[n].length = device.sm[n].minimum = device.sm[n].maximum = SIZE;
    device.boot_out = device.boot_in = (ect_boot_mailbox_t){0};
    return &device;
}

static void open_network(ect_network_kind_t kind)
{
    ect_twin_config_t twin = ect_twin_default(netdev(), NULL);
    network = ect_network_new(twin.device, kind);
    assert_non_null(network);
    ect_network_join(network, &twin);
    wire_open_twins(&w, &twin, 1);
    wire_go(&w, 0, ECT_STATE_PREOP);
}

static netdev_t *net(void)
{
    return (netdev_t *)(void *)testdev_of(&w, 0);
}

static void fill(uint8_t *frame, unsigned int n)
{
    memset(frame, (int)n, FRAME);
    frame[12] = frame[13] = 0;
}

/* A frame of the master, in one mail. */
static void send_frame(const uint8_t *frame, uint16_t length)
{
    static unsigned int number;
    uint8_t data[SIZE] = {0, LAST};
    ect_store_le16(data + 2, (uint16_t)((length + 31u) / 32 << 6 | (number++ & 0x0F) << 12));
    memcpy(data + HEADER, frame, length);
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, data, (uint16_t)(HEADER + length)), 1);
}

/* @return length of the frame in the next mail, -1: there is none */
static int receive_frame(uint8_t *frame)
{
    uint8_t mail[SIZE];
    int length = wire_mail_receive(&w, 0, mail, SIZE);
    if (length < HEADER)
        return -1;
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_EOE);
    memcpy(frame, mail + MAIL_HEADER + HEADER, (size_t)length - HEADER);
    return length - HEADER;
}

static void give(unsigned int n)
{
    uint8_t frame[FRAME];
    fill(frame, n);
    ect_network_push(network, frame, FRAME);
    ect_chain_wake(w.chain, 0);
    wire_poll(&w);
}

static uint32_t value_of(const char *name)
{
    ect_signal_ref_t ref;
    uint32_t value;
    assert_true(ect_chain_signal(w.chain, 0, name, &ref));
    if (ref.signal->type == ECT_SIGNAL_BOOL)
        return *(const uint8_t *)ref.value;
    memcpy(&value, ref.value, sizeof value);
    return value;
}

static void set_link(const char *value)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    const ect_setting_t setting = {.name = "eoe.link", .value = value};
    assert_true(ect_settings_apply(w.chain, 0, &setting, 1, w.now_ns, message));
}

static int setup(void **state)
{
    (void)state;
    (void)snprintf(folder, sizeof folder, "/tmp/test-eoe-XXXXXX");
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/port", folder);
    memset(&w, 0, sizeof w);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    if (w.chain)
        wire_close(&w);
    ect_network_free(network);
    network = NULL;
    return rmdir(folder); /* fails if a socket is left */
}

/* --- the device's own frames, and the responder ------------------------------------------------------------------- */

static void own_frames(void **state)
{
    static const uint8_t set_ip[] = {2, 1, 0, 0, 2, 0, 0, 0, 20, 10, 168, 192}, get_ip[] = {6, 1, 0, 0};
    uint8_t frame[SIZE], back[SIZE], mail[SIZE];
    (void)state;
    open_network(ECT_NETWORK_OWN);
    fill(frame, 7);
    send_frame(frame, FRAME);
    assert_int_equal(receive_frame(back), FRAME);
    assert_memory_equal(back, frame, FRAME);
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, set_ip, sizeof set_ip), 1);
    assert_int_equal(wire_mail_receive(&w, 0, mail, SIZE), 4);
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, get_ip, sizeof get_ip), 1);
    assert_int_equal(wire_mail_receive(&w, 0, mail, SIZE), 12);
    assert_int_equal(net()->sets, 1);
    assert_int_equal(net()->loads, 1);
    assert_int_equal(net()->resets, 1);
    assert_int_equal(value_of("eoe.received"), 1);
    assert_int_equal(value_of("eoe.sent"), 1);
    assert_int_equal(value_of("eoe.dropped"), 0);
}

static void answers_arp(void **state)
{
    static const uint8_t set_ip[] = {2, 1, 0, 0, 2, 0, 0, 0, 20, 10, 168, 192};
    static const uint8_t arp[42] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 2, 0, 0, 0, 0,   1,   8,  6,
                                    0,    1,    8,    0,    6,    4,    0, 1, 2, 0, 0,   0,   0,  1,
                                    9,    9,    9,    9,    0,    0,    0, 0, 0, 0, 192, 168, 10, 20};
    uint8_t back[SIZE], mail[SIZE];
    (void)state;
    open_network(ECT_NETWORK_ECHO);
    send_frame(arp, sizeof arp);
    assert_int_equal(receive_frame(back), -1); /* without an address */
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, set_ip, sizeof set_ip), 1);
    assert_int_equal(wire_mail_receive(&w, 0, mail, SIZE), 4);
    send_frame(arp, sizeof arp);
    assert_int_equal(receive_frame(back), 60);
    assert_memory_equal(back, arp + 6, 6);
    assert_int_equal(back[21], 2);
    assert_int_equal(value_of("eoe.dropped"), 0);
}

/* With a full queue a frame without a reply is taken; one with a reply is dropped. */
static void no_reply_needs_no_room(void **state)
{
    static const uint8_t set_ip[] = {2, 1, 0, 0, 2, 0, 0, 0, 20, 10, 168, 192};
    static const uint8_t arp[60] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 2, 0, 0, 0, 0,   1,   8,  6,
                                    0,    1,    8,    0,    6,    4,    0, 1, 2, 0, 0,   0,   0,  1,
                                    9,    9,    9,    9,    0,    0,    0, 0, 0, 0, 192, 168, 10, 20};
    static const uint8_t unknown[60] = {2, 0, 0, 0, 0, 2, 2, 0, 0, 0, 0, 1, 0x88, 0xB5};
    uint8_t mail[SIZE];
    (void)state;
    open_network(ECT_NETWORK_ECHO);
    const ect_eoe_t *eoe = (const ect_eoe_t *)(const void *)network; /* its first member is the entry of the device */
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, set_ip, sizeof set_ip), 1);
    assert_int_equal(wire_mail_receive(&w, 0, mail, SIZE), 4);
    assert_true(eoe->received(eoe, net(), 0, unknown, sizeof unknown));
    assert_int_equal(ect_network_room(network), ECT_NETWORK_QUEUE);
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE; n++)
        assert_true(eoe->received(eoe, net(), 0, arp, sizeof arp));
    assert_int_equal(ect_network_room(network), 0);
    assert_true(eoe->received(eoe, net(), 0, unknown, sizeof unknown));
    assert_false(eoe->received(eoe, net(), 0, arp, sizeof arp));
}

/* --- cable and queues --------------------------------------------------------------------------------------------- */

static void pulled_cable(void **state)
{
    uint8_t frame[SIZE], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_OWN);
    fill(frame, 7);
    set_link("0");
    send_frame(frame, FRAME);
    assert_int_equal(receive_frame(back), -1);
    assert_int_equal(value_of("eoe.dropped"), 1);
    ect_chain_power_cycle(w.chain, w.now_ns);
    wire_assign_stations(&w);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(value_of("eoe.link"), 0);
    received(&entry, net(), 0, frame, FRAME); /* the device has a frame */
    ect_mailbox_wake(net()->base.host->ctx);
    ect_chain_wake(w.chain, 0);
    wire_poll(&w);
    assert_int_equal(receive_frame(back), -1);
    assert_int_equal(value_of("eoe.dropped"), 1);
    set_link("1");
    send_frame(frame, FRAME);
    assert_int_equal(receive_frame(back), FRAME);
}

/* A device with frames for ever takes no more of one call than a queue of them. */
static void device_never_ends(void **state)
{
    uint8_t frame[SIZE], back[SIZE];
    const ect_eoe_t *eoe;
    uint8_t port = 0;
    (void)state;
    open_network(ECT_NETWORK_OWN);
    set_link("0");
    fill(frame, 7);
    received(&entry, net(), 0, frame, FRAME);
    net()->repeats = 1000;
    eoe = (const ect_eoe_t *)(const void *)network; /* its first member is the entry of the device */
    for (unsigned int call = 1; call <= 3; call++) {
        assert_int_equal(eoe->fetch(eoe, net(), back, &port), 0);
        assert_int_equal(net()->repeats, 1000 - call * (ECT_NETWORK_QUEUE + 1));
    }
    set_link("1");
    assert_int_equal(eoe->fetch(eoe, net(), back, &port), FRAME);
    assert_memory_equal(back, frame, FRAME);
}

static void refused_setting_changes_no_link(void **state)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    const ect_setting_t settings[] = {{.name = "eoe.link", .value = "0"}, {.name = "eoe.link", .value = "2"}};
    (void)state;
    open_network(ECT_NETWORK_OWN);
    assert_false(ect_settings_apply(w.chain, 0, settings, 2, w.now_ns, message));
    assert_int_equal(value_of("eoe.link"), 1);
}

static void frames_for_the_host(void **state)
{
    uint8_t frame[FRAME];
    uint16_t length;
    (void)state;
    open_network(ECT_NETWORK_HOST);
    assert_null(ect_network_peek(network, &length));
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE + 3; n++) {
        fill(frame, n);
        send_frame(frame, FRAME);
    }
    assert_int_equal(value_of("eoe.received"), ECT_NETWORK_QUEUE);
    assert_int_equal(value_of("eoe.dropped"), 3);
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE; n++) {
        fill(frame, n);
        assert_memory_equal(ect_network_peek(network, &length), frame, FRAME);
        assert_int_equal(length, FRAME);
        ect_network_next(network, n != 5);
    }
    assert_null(ect_network_peek(network, &length));
    assert_int_equal(value_of("eoe.dropped"), 4); /* the host has not taken one */
}

static void frames_of_the_host(void **state)
{
    uint8_t back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE + 5;
         n++) /* the first two leave the queue: a mail, a frame under way */
        give(n);
    assert_int_equal(ect_network_room(network), 0);
    assert_int_equal(value_of("eoe.dropped"), 3);
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE + 2; n++) {
        assert_int_equal(receive_frame(back), FRAME);
        assert_int_equal(back[0], n);
    }
    assert_int_equal(receive_frame(back), -1);
    assert_int_equal(ect_network_room(network), ECT_NETWORK_QUEUE);
}

static void too_long_for_a_twin(void **state)
{
    static const uint8_t frame[ECT_EOE_FRAME + 1] = {[12] = 0x81};
    uint8_t back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_network_push(network, frame, sizeof frame);
    assert_int_equal(value_of("eoe.dropped"), 1);
    give(1);
    assert_int_equal(receive_frame(back), FRAME);
}

static void restart(void **state)
{
    uint8_t back[SIZE], frame[FRAME];
    uint16_t length;
    (void)state;
    open_network(ECT_NETWORK_HOST);
    fill(frame, 1);
    send_frame(frame, FRAME);
    for (unsigned int n = 0; n < 4; n++)
        give(n);
    assert_true(ect_network_has_link(network));
    (void)wire_al(&w, 0, ECT_STATE_INIT, NULL);
    assert_false(ect_network_has_link(network));
    give(9);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_true(ect_network_has_link(network));
    assert_null(ect_network_peek(network, &length));
    assert_int_equal(receive_frame(back), -1);
    give(10);
    assert_int_equal(receive_frame(back), FRAME);
    assert_int_equal(back[0], 10);
}

static void signals_are_listed(void **state)
{
    ect_chain_cursor_t cursor;
    ect_signal_ref_t ref;
    unsigned int count = 0;
    (void)state;
    memset(&cursor, 0, sizeof cursor);
    open_network(ECT_NETWORK_OWN);
    while (ect_chain_next_signal(w.chain, 0, &cursor, &ref))
        count += strncmp(ref.name, "eoe.", 4) == 0;
    assert_int_equal(count, 4);
    assert_null(ect_network_entry(&testdev));
}

/* --- a host at a socket ------------------------------------------------------------------------------------------- */

static int connect_host(void)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    memcpy(address.sun_path, path, strlen(path) + 1);
    assert_true(fd >= 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

static bool wants(const ect_hosts_t *hosts)
{
    struct pollfd fd = {.fd = ect_hosts_fd(hosts), .events = POLLIN};
    return poll(&fd, 1, 0) > 0 || ect_hosts_due(hosts) <= w.now_ns;
}

/* As the runner does it. */
static void serve(ect_hosts_t *hosts)
{
    for (unsigned int i = 0; wants(hosts); i++) {
        assert_true(i < 1000);
        ect_hosts_serve(hosts, w.chain, w.now_ns);
        wire_poll(&w);
    }
}

static ect_hosts_t *open_hosts(char *place)
{
    char message[ECT_PLACE_MESSAGE];
    (void)snprintf(place, 110, "unix:%s", path);
    ect_hosts_t *hosts = ect_hosts_new();
    assert_non_null(hosts);
    assert_string_equal(ect_hosts_open(hosts, place, network, 0, message), path);
    return hosts;
}

static void socket_of_a_host(void **state)
{
    char place[110];
    uint8_t frame[FRAME], back[SIZE];
    enum { FRAMES = 3 * ECT_NETWORK_QUEUE };
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_hosts_t *hosts = open_hosts(place);
    serve(hosts);
    int host = connect_host();
    for (unsigned int n = 0; n < FRAMES; n++) {
        fill(frame, n);
        assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    }
    for (unsigned int n = 0; n < FRAMES; n++) { /* a full queue lets the sender wait, and loses nothing */
        serve(hosts);
        assert_int_equal(receive_frame(back), FRAME);
        assert_int_equal(back[0], n == 0 ? 0 : (uint8_t)n);
    }
    for (unsigned int n = 0; n < 3; n++) {
        fill(frame, n);
        send_frame(frame, FRAME);
    }
    serve(hosts);
    for (unsigned int n = 0; n < 3; n++) {
        assert_int_equal(recv(host, back, sizeof back, 0), FRAME);
        assert_int_equal(back[0], n);
    }
    assert_int_equal(value_of("eoe.dropped"), 0);
    close(host);
    ect_hosts_close(hosts);
}

/* The queue, a frame under way and a mail are full. */
static int fill_the_queue(ect_hosts_t *hosts, unsigned int more)
{
    uint8_t frame[FRAME];
    serve(hosts);
    int host = connect_host();
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE + 2 + more; n++) {
        fill(frame, n);
        assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    }
    serve(hosts);
    assert_int_equal(value_of("eoe.dropped"), 0);
    assert_int_equal(ect_network_room(network), 0);
    return host;
}

static void master_fetches_nothing(void **state)
{
    char place[110];
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_hosts_t *hosts = open_hosts(place);
    int host = fill_the_queue(hosts, 10);
    const uint64_t due_ns = ect_hosts_due(hosts);
    assert_int_equal(due_ns, w.now_ns + 1000 * MS);
    w.now_ns = due_ns - 1;
    serve(hosts);
    assert_int_equal(value_of("eoe.dropped"), 0);
    w.now_ns = due_ns;
    serve(hosts);
    assert_int_equal(value_of("eoe.dropped"), 10);
    for (unsigned int n = 0; n < ECT_NETWORK_QUEUE + 2; n++) {
        assert_int_equal(receive_frame(back), FRAME);
        assert_int_equal(back[0], n);
    }
    fill(frame, 99);
    assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    serve(hosts);
    assert_int_equal(receive_frame(back), FRAME);
    assert_int_equal(back[0], 99);
    assert_int_equal(value_of("eoe.dropped"), 10);
    close(host);
    ect_hosts_close(hosts);
}

/* No busy loop: serve() returns. */
static void host_ends_while_it_waits(void **state)
{
    char place[110];
    uint8_t back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_hosts_t *hosts = open_hosts(place);
    close(fill_the_queue(hosts, 2));
    serve(hosts);
    for (unsigned int n = 0; n < 3; n++)
        assert_int_equal(receive_frame(back), FRAME);
    serve(hosts);
    for (unsigned int n = 3; n < ECT_NETWORK_QUEUE + 4; n++) {
        assert_int_equal(receive_frame(back), FRAME);
        assert_int_equal(back[0], n);
    }
    int next = connect_host();
    serve(hosts);
    assert_int_equal(ect_hosts_due(hosts), ECT_NEVER);
    close(next);
    ect_hosts_close(hosts);
}

static void host_never_reads(void **state)
{
    enum { FRAMES = 2000 };
    char place[110];
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_hosts_t *hosts = open_hosts(place);
    int host = connect_host();
    unsigned int taken = 0;
    for (unsigned int n = 0; n < FRAMES; n++) {
        fill(frame, n);
        send_frame(frame, FRAME);
        serve(hosts);
    }
    assert_int_equal(value_of("eoe.received"), FRAMES);
    while (recv(host, back, sizeof back, 0) == FRAME)
        assert_int_equal(back[0], (uint8_t)taken++);
    assert_true(taken > 0 && taken < FRAMES);
    assert_int_equal(value_of("eoe.dropped"), FRAMES - taken);
    close(host);
    ect_hosts_close(hosts);
}

static void host_goes_and_another_comes(void **state)
{
    char place[110];
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_hosts_t *hosts = open_hosts(place);
    fill(frame, 1);
    send_frame(frame, FRAME); /* no host is connected */
    serve(hosts);
    assert_int_equal(value_of("eoe.dropped"), 1);
    int first = connect_host(), second = connect_host();
    serve(hosts);
    assert_int_equal(send(second, frame, FRAME, 0), FRAME);
    serve(hosts);
    assert_int_equal(receive_frame(back), -1); /* one at a time */
    close(first);
    serve(hosts);
    assert_int_equal(receive_frame(back), FRAME);
    close(second);
    serve(hosts);
    ect_hosts_close(hosts);
}

static void host_of_a_twin_in_init(void **state)
{
    char place[110];
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    ect_hosts_t *hosts = open_hosts(place);
    int host = connect_host();
    for (unsigned int n = 0; n < 2 * ECT_NETWORK_QUEUE; n++) {
        fill(frame, n);
        assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    }
    serve(hosts);
    (void)wire_al(&w, 0, ECT_STATE_INIT, NULL);
    serve(hosts); /* what waits is lost, as at a switch without a link */
    wire_go(&w, 0, ECT_STATE_PREOP);
    serve(hosts);
    assert_int_equal(receive_frame(back), -1);
    fill(frame, 99);
    assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    serve(hosts);
    assert_int_equal(receive_frame(back), FRAME);
    assert_int_equal(back[0], 99);
    close(host);
    ect_hosts_close(hosts);
}

/* --- a host at a TAP ---------------------------------------------------------------------------------------------- */

/* @return the kernel's end of a TAP whose other end is handed out next */
static int make_tap(void)
{
    int ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
    kernel.tap = ends[0];
    return ends[1];
}

static ect_hosts_t *open_tap(const char *place)
{
    char message[ECT_PLACE_MESSAGE] = "";
    ect_hosts_t *hosts = ect_hosts_new();
    assert_non_null(hosts);
    assert_string_equal(ect_hosts_open(hosts, place, network, 0, message), place);
    return hosts;
}

static bool is_open(int fd)
{
    return fcntl(fd, F_GETFD) >= 0;
}

static void frames_of_a_tap(void **state)
{
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    int host = make_tap();
    ect_hosts_t *hosts = open_tap("tap7");
    serve(hosts);
    for (unsigned int n = 0; n < 6; n++) {
        fill(frame, n);
        send_frame(frame, FRAME);
        assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    }
    serve(hosts);
    for (unsigned int n = 0; n < 6; n++) {
        assert_int_equal(recv(host, back, sizeof back, 0), FRAME);
        assert_int_equal(back[0], n);
        assert_int_equal(receive_frame(back), FRAME);
        assert_int_equal(back[0], n);
    }
    assert_int_equal(value_of("eoe.dropped"), 0);
    ect_hosts_close(hosts);
    assert_false(is_open(kernel.tap));
    close(host);
}

/* One call moves four frames in each direction, so that no host delays process data. */
static void frames_of_one_call(void **state)
{
    uint8_t frame[FRAME], back[SIZE];
    unsigned int sent = 0;
    (void)state;
    open_network(ECT_NETWORK_HOST);
    int host = make_tap();
    ect_hosts_t *hosts = open_tap("tap");
    for (unsigned int n = 0; n < 6; n++) {
        fill(frame, n);
        send_frame(frame, FRAME);
        assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    }
    for (unsigned int n = 4; n <= 6; n += 2) {
        kernel.reads = 0;
        ect_hosts_serve(hosts, w.chain, w.now_ns);
        while (recv(host, back, sizeof back, 0) == FRAME)
            sent++;
        assert_int_equal(sent, n);
        assert_int_equal(ECT_NETWORK_QUEUE - ect_network_room(network), n);
    }
    ect_hosts_close(hosts);
    close(host);
}

/* Three twins, each with a host: they are served in turn, and an idle host costs the others no call. */
static void hosts_take_turns(void **state)
{
    enum { TWINS = 3, MOST_CALLS = 8 };
    static const struct {
        unsigned int frames[TWINS];
        char order[MOST_CALLS]; /* the host that each call serves; '-': none has a frame */
    } rows[] = {
        {{4, 4, 4}, "012-"}, {{12, 4, 8}, "012020-"}, {{8, 0, 8}, "0202-"}, {{0, 8, 0}, "11-"}, {{0, 0, 4}, "2-"}};
    ect_network_t *networks[TWINS];
    ect_twin_config_t twins[TWINS];
    uint8_t frame[FRAME];
    (void)state;
    fill(frame, 1);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_PLACE_MESSAGE];
        int host[TWINS];
        ect_hosts_t *hosts = ect_hosts_new();
        assert_non_null(hosts);
        for (size_t n = 0; n < TWINS; n++) {
            twins[n] = ect_twin_default(netdev(), NULL);
            networks[n] = ect_network_new(netdev(), ECT_NETWORK_HOST);
            assert_non_null(networks[n]);
            ect_network_join(networks[n], &twins[n]);
            host[n] = make_tap();
            assert_non_null(ect_hosts_open(hosts, "tap", networks[n], n, message));
            for (unsigned int k = 0; k < rows[i].frames[n]; k++)
                assert_int_equal(send(host[n], frame, FRAME, 0), FRAME);
        }
        wire_open_twins(&w, twins, TWINS);
        for (size_t n = 0; n < TWINS; n++)
            wire_go(&w, n, ECT_STATE_PREOP);
        for (const char *served = rows[i].order; *served; served++) {
            size_t room[TWINS];
            for (size_t n = 0; n < TWINS; n++)
                room[n] = ect_network_room(networks[n]);
            ect_hosts_serve(hosts, w.chain, w.now_ns);
            for (size_t n = 0; n < TWINS; n++)
                assert_int_equal(room[n] - ect_network_room(networks[n]), *served == (char)('0' + n) ? 4 : 0);
        }
        ect_hosts_close(hosts);
        wire_close(&w);
        w.chain = NULL;
        for (size_t n = 0; n < TWINS; n++) {
            ect_network_free(networks[n]);
            close(host[n]);
        }
    }
    network = NULL;
}

/* A frame of a host wakes its own twin: the mail is ready when the master reads it for the first time. */
static void host_wakes_its_twin(void **state)
{
    enum { LAST_TWIN = 2 };
    ect_twin_config_t twins[LAST_TWIN + 1];
    char message[ECT_PLACE_MESSAGE];
    uint8_t frame[FRAME], mail[SIZE];
    (void)state;
    network = ect_network_new(netdev(), ECT_NETWORK_HOST);
    for (size_t n = 0; n <= LAST_TWIN; n++)
        twins[n] = ect_twin_default(netdev(), NULL);
    ect_network_join(network, &twins[LAST_TWIN]);
    wire_open_twins(&w, twins, LAST_TWIN + 1);
    wire_go(&w, LAST_TWIN, ECT_STATE_PREOP);
    int host = make_tap();
    ect_hosts_t *hosts = ect_hosts_new();
    assert_non_null(hosts);
    assert_non_null(ect_hosts_open(hosts, "tap", network, LAST_TWIN, message));
    fill(frame, 1);
    assert_int_equal(send(host, frame, FRAME, 0), FRAME);
    ect_hosts_serve(hosts, w.chain, w.now_ns);
    wire_poll(&w);
    assert_int_equal(wire_read(&w, LAST_TWIN, SM1, mail, SIZE), 1);
    assert_int_equal(ect_load_le16(mail), HEADER + FRAME);
    ect_hosts_close(hosts);
    close(host);
}

/* The longest frame passes; a longer one is dropped, not cut. */
static void lengths_of_frames(void **state)
{
    static const struct {
        uint16_t length;
        bool passes;
    } rows[] = {{1, false},
                {ECT_EOE_FRAME_LEAST - 1, false},
                {ECT_EOE_FRAME_LEAST, true},
                {FRAME, true},
                {ECT_EOE_FRAME - 1, true},
                {ECT_EOE_FRAME, true},
                {ECT_EOE_FRAME + 1, false},
                {ECT_EOE_FRAME + 9, false}};
    static uint8_t frame[ECT_EOE_FRAME + 9];
    uint32_t dropped = 0;
    (void)state;
    open_network(ECT_NETWORK_HOST);
    int host = make_tap();
    ect_hosts_t *hosts = open_tap("tap");
    memset(frame, 0x5A, sizeof frame);
    ect_store_be16(frame + 12, 0x8100); /* a VLAN tag, with which a frame is the longest */
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t mail[SIZE];
        unsigned int bytes = 0;
        assert_int_equal(send(host, frame, rows[i].length, 0), rows[i].length);
        serve(hosts);
        for (int length; (length = wire_mail_receive(&w, 0, mail, SIZE)) >= HEADER; serve(hosts))
            bytes += (unsigned int)length - HEADER; /* a long frame comes in fragments */
        dropped += rows[i].passes ? 0 : 1;
        assert_int_equal(bytes, rows[i].passes ? rows[i].length : 0);
        assert_int_equal(value_of("eoe.dropped"), dropped);
    }
    ect_hosts_close(hosts);
    close(host);
}

static void failed_reads_of_a_tap(void **state)
{
    static const struct {
        int error;
        bool ends;
    } rows[] = {{EAGAIN, false}, {EINTR, false}, {EIO, false}, /* it is down */
                {EBADFD, true},  {EFAULT, true}, {ENODEV, true}};
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    fill(frame, 3);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int host = make_tap();
        ect_hosts_t *hosts = open_tap("tap");
        kernel.read_error = rows[i].error;
        ect_hosts_serve(hosts, w.chain, w.now_ns);
        assert_int_equal(kernel.read_error, 0);
        assert_int_equal(is_open(kernel.tap), !rows[i].ends);
        if (!rows[i].ends) {
            assert_int_equal(send(host, frame, FRAME, 0), FRAME);
            serve(hosts);
            assert_int_equal(receive_frame(back), FRAME);
        }
        kernel.reads = 0;
        ect_hosts_serve(hosts, w.chain, w.now_ns);
        assert_int_equal(kernel.reads, rows[i].ends ? 0 : 1);
        ect_hosts_close(hosts);
        assert_false(is_open(kernel.tap));
        close(host);
    }
}

/* --- places ------------------------------------------------------------------------------------------------------- */

/* A place that cannot be opened changes no other one; a set without hosts is served, too. */
static void refused_places(void **state)
{
    static const struct {
        const char *place;
        int watch_error;
        const char *message;
    } rows[] = {{"unix:", 0, "unix:PATH has 1 to 107 characters after the colon"},
                {"tap", 0, "no TAP for a test"},
                {NULL, ENOSPC, "waiting for '%s' failed: No space left on device"}};
    char place[110], wanted[ECT_PLACE_MESSAGE];
    uint8_t frame[FRAME], back[SIZE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    (void)snprintf(place, sizeof place, "unix:%s", path);
    fill(frame, 5);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_PLACE_MESSAGE] = "";
        ect_hosts_t *hosts = ect_hosts_new();
        assert_non_null(hosts);
        ect_hosts_serve(hosts, w.chain, w.now_ns);
        assert_int_equal(ect_hosts_due(hosts), ECT_NEVER);
        int host = make_tap(), tap = kernel.tap;
        assert_string_equal(ect_hosts_open(hosts, "tap7", network, 0, message), "tap7");
        kernel.tap = -1;
        kernel.watch_error = rows[i].watch_error;
        assert_null(ect_hosts_open(hosts, rows[i].place ? rows[i].place : place, network, 0, message));
        kernel.watch_error = 0;
        const char *at = strstr(rows[i].message, "%s");
        (void)snprintf(wanted, sizeof wanted, "%.*s%s%s", at ? (int)(at - rows[i].message) : 0, rows[i].message,
                       at ? place : "", at ? at + 2 : rows[i].message);
        assert_string_equal(message, wanted);
        assert_int_equal(send(host, frame, FRAME, 0), FRAME);
        serve(hosts);
        assert_int_equal(receive_frame(back), FRAME);
        ect_hosts_close(hosts);
        assert_false(is_open(tap));
        close(host);
    }
    ect_hosts_close(NULL);
}

/* The descriptor that is given next. */
static int next_descriptor(void)
{
    const int fd = open("/dev/null", O_RDONLY);
    (void)close(fd);
    return fd;
}

static void refused_memory(void **state)
{
    char message[ECT_PLACE_MESSAGE] = "", place[110];
    const int before = next_descriptor();
    (void)state;
    open_network(ECT_NETWORK_HOST);
    kernel.memory_refused = 1;
    assert_null(ect_hosts_new());
    kernel.epoll_error = EMFILE;
    assert_null(ect_hosts_new());
    assert_int_equal(errno, EMFILE);
    kernel.epoll_error = 0;
    kernel.memory_refused = 1;
    assert_null(ect_network_new(netdev(), ECT_NETWORK_OWN));
    ect_hosts_t *hosts = open_hosts(place);
    kernel.memory_refused = 1;
    assert_null(ect_hosts_open(hosts, "tap", network, 0, message));
    assert_string_equal(message, "not enough memory");
    int host = connect_host();
    serve(hosts);
    ect_hosts_close(hosts);
    close(host);
    assert_int_equal(next_descriptor(), before);
    assert_int_equal(access(path, F_OK), -1);
}

/* A daemon's standard input may be closed: the first descriptor is 0 then. */
static void descriptor_0(void **state)
{
    (void)state;
    const int input = dup(STDIN_FILENO);
    (void)close(STDIN_FILENO);
    ect_hosts_t *hosts = ect_hosts_new();
    const int fd = hosts ? ect_hosts_fd(hosts) : -1;
    ect_hosts_close(hosts);
    const bool left = is_open(STDIN_FILENO);
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    assert_int_equal(fd, STDIN_FILENO);
    assert_false(left);
}

/* The device of a network has the protocols of its own device, EoE in the same place, and an end. */
static void protocols_of_a_network(void **state)
{
    enum { MOST = 6 };
    static const ect_protocol_t other = {.type = ECT_MAILBOX_TYPE_COE};
    (void)state;
    for (size_t count = 1; count <= MOST; count++) {
        for (size_t place = 0; place < count; place++) {
            const ect_protocol_t *protocols[MOST + 1] = {NULL};
            ect_twin_config_t twin = {0};
            ect_device_t device = *netdev();
            for (size_t i = 0; i < count; i++)
                protocols[i] = i == place ? &entry.protocol : &other;
            device.protocols = protocols;
            assert_ptr_equal(ect_network_entry(&device), &entry);
            network = ect_network_new(&device, ECT_NETWORK_OWN);
            assert_non_null(network);
            ect_network_join(network, &twin);
            for (size_t i = 0; i < count; i++) {
                const ect_protocol_t *its = twin.device->protocols[i];
                assert_true(i == place ? its != &entry.protocol && its->type == ECT_MAILBOX_TYPE_EOE : its == &other);
            }
            assert_null(twin.device->protocols[count]);
            for (size_t i = 0; i < GUARD; i++)
                assert_int_equal(kernel.guard[i], GUARDED); /* no protocol is behind the memory of the network */
            ect_network_free(network);
            network = NULL;
        }
    }
}

static void places(void **state)
{
    static const struct {
        const char *text;
        bool tap;
        const char *path;
    } rows[] = {{"tap", true, NULL},
                {"tap0", true, NULL},
                {"taps/0", false, NULL},
                {"tap:0", false, NULL},
                {"tap%d", false, NULL},
                {"eth0", false, NULL},
                {"unix:/x", false, "/x"},
                {"unix:", false, ""},
                {"tap0123456789abc", false, NULL},
                {"tap0123456789ab", true, NULL}};
    char message[ECT_PLACE_MESSAGE];
    (void)state;
    open_network(ECT_NETWORK_HOST);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(ect_place_is_tap(rows[i].text), rows[i].tap);
        const char *found = ect_place_path(rows[i].text);
        assert_int_equal(found != NULL, rows[i].path != NULL);
        if (found)
            assert_string_equal(found, rows[i].path);
    }
    assert_int_equal(ect_place_listen("", message), -1);
    assert_non_null(strstr(message, "1 to 107 characters"));
    int fd = ect_place_listen(path, message);
    assert_true(fd >= 0);
    assert_int_equal(ect_place_listen(path, message), -1);
    assert_non_null(strstr(message, "exists already"));
    close(fd);
    fd = ect_place_listen(path, message); /* left by a dead process */
    assert_true(fd >= 0);
    close(fd);
    assert_int_equal(unlink(path), 0);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"the device takes and gives frames and address through the network", own_frames, setup, teardown, NULL},
        {"EOE-035: the responder replies to ARP at the address that a master sets", answers_arp, setup, teardown, NULL},
        {"With a full queue the responder drops a frame that it would reply to, and no other", no_reply_needs_no_room,
         setup, teardown, NULL},
        {"a pulled cable loses frames of both directions, over a power cycle too", pulled_cable, setup, teardown, NULL},
        {"a pulled cable loses at most a queue of a device's frames in one call", device_never_ends, setup, teardown,
         NULL},
        {"a refused setting does not change the cable", refused_setting_changes_no_link, setup, teardown, NULL},
        {"EOE-016: frames for the host are queued up to a limit, then dropped", frames_for_the_host, setup, teardown,
         NULL},
        {"EOE-054: frames of the host are queued up to a limit, oldest kept", frames_of_the_host, setup, teardown,
         NULL},
        {"EOE-013: a frame of the host that is too long is dropped", too_long_for_a_twin, setup, teardown, NULL},
        {"EOE-051: INIT to PREOP forgets both queues", restart, setup, teardown, NULL},
        {"the signals eoe.NAME are listed", signals_are_listed, setup, teardown, NULL},
        {"EOE-054: a host at a socket waits while the queue is full", socket_of_a_host, setup, teardown, NULL},
        {"EOE-054: frames of a host are dropped once a master has fetched none for a second, oldest kept",
         master_fetches_nothing, setup, teardown, NULL},
        {"EOE-054: a host that ends while it waits loses no frame", host_ends_while_it_waits, setup, teardown, NULL},
        {"EOE-016: frames for a host that never reads are dropped once its socket is full", host_never_reads, setup,
         teardown, NULL},
        {"EOE-016: one host at a time, and none", host_goes_and_another_comes, setup, teardown, NULL},
        {"EOE-050 EOE-051: frames of a host are lost in INIT", host_of_a_twin_in_init, setup, teardown, NULL},
        {"frames pass between a TAP and a master, in their order", frames_of_a_tap, setup, teardown, NULL},
        {"one call moves four frames of a host in each direction", frames_of_one_call, setup, teardown, NULL},
        {"EOE-013: the longest frame of a host passes, a longer one is dropped", lengths_of_frames, setup, teardown,
         NULL},
        {"hosts are served in turn, four frames a call", hosts_take_turns, setup, teardown, NULL},
        {"a frame of a host wakes its own twin", host_wakes_its_twin, setup, teardown, NULL},
        {"a TAP that is down stays open, a TAP that is removed is closed", failed_reads_of_a_tap, setup, teardown,
         NULL},
        {"a place that cannot be opened is refused with a line, and the others work", refused_places, setup, teardown,
         NULL},
        {"without memory nothing is made, and nothing is left open", refused_memory, setup, teardown, NULL},
        {"descriptor 0 is one as any other", descriptor_0, setup, teardown, NULL},
        {"a network has the protocols of its device", protocols_of_a_network, setup, teardown, NULL},
        {"texts of places, and sockets that are in use", places, setup, teardown, NULL},
    };
    return cmocka_run_group_tests_name("networks behind EoE", tests, NULL, NULL);
}
