/* SPDX-License-Identifier: MIT */
/* The event loop (runner.h): the order of its actions, the events that it waits for. No interface, no wall clock: a
 * socket pair is the wire, and the linker leads the loop's waiting and serving through here (tests/CMakeLists.txt). */
#define _GNU_SOURCE
#include "bus/runner.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "support/wire.h"

enum { ROOM = 65536, LOG = 4096 };

typedef struct bench bench_t;

/* The action of a test before the loop waits for the n-th time. */
typedef void script_t(bench_t *b, unsigned int n, const struct timespec *limit);

struct bench {
    wire_t wire;
    ect_runner_t runner;
    ect_packet_t port;
    int master; /* the other end of the wire */
    char folder[64];
    script_t *script;
    unsigned int waits;
    char order[LOG]; /* F: a frame was answered, C: the control socket was served, M: a Modbus client, H: a host */
    size_t logged;
    unsigned int serve_late_ns;
    uint64_t clock_ns;      /* the time that the loop reads, once it is not zero, */
    uint64_t clock_step_ns; /* added to the clock by each read */
    bool result_set;        /* the next frame comes with this result, */
    bool beyond_room;       /* added to the room for it */
    ssize_t result;
    size_t room;
    unsigned int waited; /* calls that wait for a frame */
};

static bench_t *running;

int __real_clock_gettime(clockid_t clock, struct timespec *time);
int __wrap_clock_gettime(clockid_t clock, struct timespec *time);
ssize_t __real_send(int fd, const void *data, size_t size, int flags);
int __wrap_clock_gettime(clockid_t clock, struct timespec *time)
{
    if (!running || running->clock_ns == 0)
        return __real_clock_gettime(clock, time);
    running->clock_ns += running->clock_step_ns;
    *time = (struct timespec){.tv_sec = (time_t)(running->clock_ns / 1000000000u),
                              .tv_nsec = (long)(running->clock_ns % 1000000000u)};
    return 0;
}

ssize_t __wrap_send(int fd, const void *data, size_t size, int flags);
int __real_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask);
void __real_ect_control_serve(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_control_serve(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);

void __real_ect_modbus_server_serve(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_modbus_server_serve(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns);

static void note(char what)
{
    assert_true(running->logged + 1 < LOG);
    running->order[running->logged++] = what;
}

ssize_t __real_ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time);
ssize_t __wrap_ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time);

/* The frame with another result, once, when the test sets one. */
ssize_t __wrap_ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time)
{
    ssize_t length = __real_ect_packet_receive(port, wait, frame, room, time);
    if (running)
        running->waited += wait;
    if (!running || !running->result_set)
        return length;
    running->result_set = false;
    running->room = room;
    return running->beyond_room ? (ssize_t)room + running->result : running->result;
}

ssize_t __wrap_send(int fd, const void *data, size_t size, int flags)
{
    if (running && fd == running->port.fd)
        note('F');
    return __real_send(fd, data, size, flags);
}

int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask)
{
    static const struct timespec at_once = {0}, too_long = {.tv_sec = 10};
    running->script(running, running->waits++, limit);
    int ready = __real_ppoll(fds, count, limit ? &at_once : &too_long, mask);
    if (ready == 0 && !limit)
        fail_msg("nothing wakes the loop");
    return ready;
}

void __wrap_ect_control_serve(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns)
{
    const struct timespec late = {.tv_nsec = running->serve_late_ns};
    note('C');
    __real_ect_control_serve(control, chain, now_ns);
    (void)nanosleep(&late, NULL);
}

void __wrap_ect_modbus_server_serve(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns)
{
    note('M');
    __real_ect_modbus_server_serve(server, chain, now_ns);
}

void __real_ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns)
{
    note('H');
    __real_ect_hosts_serve(hosts, chain, now_ns);
}

static bool stop(void *ctx, int signal_number, bool from_terminal)
{
    (void)ctx;
    (void)signal_number;
    (void)from_terminal;
    return false;
}

static void circling(void *ctx, const char *iface)
{
    (void)ctx;
    fail_msg("%s: circling", iface);
}

static void open_bench(bench_t *b, const char *device, size_t count)
{
    ect_twin_config_t twins[16];
    char message[ECT_ENDPOINT_MESSAGE];
    int wire[2];
    sigset_t signals;
    const ect_product_t *product = ect_catalogue_find(device);
    memset(b, 0, sizeof *b);
    for (size_t i = 0; i < count; i++)
        twins[i] = ect_twin_default(product->device, product->plant);
    b->wire.now_ns = ect_packet_now();
    b->wire.chain = ect_chain_new(twins, count, b->wire.now_ns);
    strcpy(b->folder, "/tmp/test-ectwin-XXXXXX");
    assert_non_null(mkdtemp(b->folder));
    setenv("XDG_RUNTIME_DIR", b->folder, 1);
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, wire), 0);
    b->port.fd = wire[0];
    b->port.tagged_fd = -1;
    b->master = wire[1];
    sigemptyset(&signals);
    sigaddset(&signals, SIGUSR1);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    b->runner = (ect_runner_t){.ports = {&b->port},
                               .exchange = {.chain = b->wire.chain, .control = ect_control_open(NULL, message)},
                               .signal_fd = signalfd(-1, &signals, SFD_NONBLOCK),
                               .link_fd = -1,
                               .on_signal = stop,
                               .on_circulating = circling};
    assert_non_null(b->runner.exchange.control);
    assert_true(b->runner.signal_fd >= 0);
}

static void run(bench_t *b, script_t *script)
{
    b->script = script;
    running = b;
    assert_int_equal(ect_runner_run(&b->runner), 0);
    running = NULL;
}

static void close_bench(bench_t *b)
{
    char command[96];
    ect_control_close(b->runner.exchange.control);
    ect_modbus_server_close(b->runner.modbus);
    ect_chain_free(b->wire.chain);
    close(b->runner.signal_fd);
    close(b->port.fd);
    close(b->master);
    snprintf(command, sizeof command, "rm -rf '%s'", b->folder);
    assert_int_equal(system(command), 0);
}

static int connect_client(const bench_t *b)
{
    uid_t owner;
    int fd = ect_endpoint_connect(ect_control_path(b->runner.exchange.control), &owner);
    assert_true(fd >= 0);
    assert_int_equal(fcntl(fd, F_SETFL, O_NONBLOCK), 0);
    return fd;
}

static void send_text(int fd, const char *text)
{
    assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
}

static void send_frame(bench_t *b)
{
    wire_build(&b->wire, BRD, 0, 0x0130, "\0", 1);
    assert_int_equal(__real_send(b->master, b->wire.frame, b->wire.frame_length, 0), (ssize_t)b->wire.frame_length);
}

/* --- frames first ------------------------------------------------------------------------------------------------- */

enum { FRAMES = 100, IN_A_ROW = 8 };

static void until_all_answered(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (b->runner.exchange.stats.frames == FRAMES || n > 100 * FRAMES)
        (void)raise(SIGUSR1);
}

/* All frames and all requests are waiting from the start. */
static void frames_first(void **state)
{
    int fds[ECT_CONTROL_CLIENTS];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 12);
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        fds[i] = connect_client(&b);
        for (unsigned int n = 0; n < 40; n++)
            send_text(fds[i], "{\"op\":\"list\",\"slave\":0}\n");
    }
    for (unsigned int i = 0; i < FRAMES; i++)
        send_frame(&b);
    run(&b, until_all_answered);
    assert_int_equal(b.runner.exchange.stats.frames, FRAMES);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    unsigned int since = 0, frames = 0, served = 0;
    for (size_t i = 0; i < b.logged && frames < FRAMES; i++) {
        if (b.order[i] == 'C' && since < IN_A_ROW)
            fail_msg("served after %u frames, %u to come: %s", frames, FRAMES - frames, b.order);
        served += b.order[i] == 'C';
        since = b.order[i] == 'C' ? 0 : since + 1;
        frames += b.order[i] == 'F';
    }
    assert_int_equal(served, FRAMES / IN_A_ROW); /* and every client is served */
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++)
        close(fds[i]);
    close_bench(&b);
}

/* Frame after frame with a client at work: between two of them it is served once, whatever it asked for. */
static void one_frame_at_a_time(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n % 2 == 0)
        send_frame(b);
    if (b->runner.exchange.stats.frames == FRAMES)
        (void)raise(SIGUSR1);
}

static void once_between_frames(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 12);
    int fd = connect_client(&b);
    for (unsigned int n = 0; n < 40; n++)
        send_text(fd, "{\"op\":\"list\",\"slave\":0}\n");
    run(&b, one_frame_at_a_time);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    if (strstr(b.order, "CC"))
        fail_msg("served twice while a frame waited: %s", b.order);
    assert_non_null(strstr(b.order, "FCFC"));
    close(fd);
    close_bench(&b);
}

/* Between two pieces of work the loop rests: clients alone never keep the processor busy. */
static void until_frames_are_over(bench_t *b, unsigned int n, const struct timespec *limit)
{
    if (n > 0 && strchr(b->order, 'C'))
        assert_non_null(limit); /* it will serve the clients again */
    one_frame_at_a_time(b, n, limit);
}

static void rests(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    b.runner.client_pause_ns = 4000000000; /* longer than this test takes */
    int fd = connect_client(&b);
    send_text(fd, "{\"op\":\"list\"}\n");
    run(&b, until_frames_are_over);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    const char *once = strchr(b.order, 'C');
    assert_non_null(once);
    assert_null(strchr(once + 1, 'C'));
    close(fd);
    close_bench(&b);
}

/* --- Modbus ------------------------------------------------------------------------------------------------------- */

enum { REQUESTS = 60 };

/* A client with so many requests. */
static int request_over_modbus(bench_t *b)
{
    static const uint8_t request[] = {0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 33};
    char message[ECT_MODBUS_MESSAGE];
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    socklen_t size = sizeof at;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0), client = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&at, sizeof at.sun_family), 0);
    assert_int_equal(listen(fd, 8), 0);
    assert_int_equal(getsockname(fd, (struct sockaddr *)&at, &size), 0);
    assert_int_equal(connect(client, (struct sockaddr *)&at, size), 0);
    b->runner.modbus = ect_modbus_server_at(fd, message);
    if (!b->runner.modbus)
        fail_msg("%s", message);
    for (unsigned int i = 0; i < REQUESTS; i++)
        assert_int_equal(write(client, request, sizeof request), sizeof request);
    return client;
}

static unsigned int count_of(const bench_t *b, char what)
{
    unsigned int count = 0;
    for (size_t i = 0; i < b->logged; i++)
        count += b->order[i] == what;
    return count;
}

static void frames_before_modbus(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int client = request_over_modbus(&b);
    for (unsigned int i = 0; i < FRAMES; i++)
        send_frame(&b);
    run(&b, until_all_answered);
    unsigned int since = 0, frames = 0;
    for (size_t i = 0; i < b.logged && frames < FRAMES; i++) {
        if (b.order[i] == 'M' && since < IN_A_ROW)
            fail_msg("served after %u frames, %u to come: %s", frames, FRAMES - frames, b.order);
        since = b.order[i] == 'M' ? 0 : since + 1;
        frames += b.order[i] == 'F';
    }
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    assert_true(count_of(&b, 'M') >= FRAMES / IN_A_ROW); /* and it does not starve */
    close(client);
    close_bench(&b);
}

/* --- hosts behind EoE --------------------------------------------------------------------------------------------- */

/* A host with 40 frames, for a network of no twin, which loses them. */
static int open_host(bench_t *b, ect_network_t **network, char *place, size_t room)
{
    static const ect_eoe_t entry = {.protocol = {.request = ect_eoe_request}};
    static const ect_protocol_t *const protocols[] = {&entry.protocol, NULL};
    static const ect_device_t device = {.protocols = protocols};
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    static const uint8_t frame[60];
    char message[ECT_PLACE_MESSAGE];
    snprintf(place, room, "unix:%s/host", b->folder);
    snprintf(address.sun_path, sizeof address.sun_path, "%s/host", b->folder);
    *network = ect_network_new(&device, ECT_NETWORK_HOST);
    b->runner.hosts = ect_hosts_new();
    assert_non_null(ect_hosts_open(b->runner.hosts, place, *network, 0, message));
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    for (unsigned int i = 0; i < 40; i++)
        assert_int_equal(__real_send(fd, frame, sizeof frame, 0), (ssize_t)sizeof frame);
    return fd;
}

static void frames_before_hosts(void **state)
{
    ect_network_t *network;
    char place[100];
    bench_t b;
    unsigned int since = 0, frames = 0, served = 0;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int host = open_host(&b, &network, place, sizeof place);
    for (unsigned int i = 0; i < FRAMES; i++)
        send_frame(&b);
    run(&b, until_all_answered);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    for (size_t i = 0; i < b.logged && frames < FRAMES; i++) {
        if (b.order[i] == 'H' && since < IN_A_ROW)
            fail_msg("served after %u frames, %u to come: %s", frames, FRAMES - frames, b.order);
        served += b.order[i] == 'H';
        since = b.order[i] == 'H' ? 0 : since + 1;
        frames += b.order[i] == 'F';
    }
    assert_in_range(served, 40 / 4, FRAMES / IN_A_ROW);
    close(host);
    ect_hosts_close(b.runner.hosts);
    ect_network_free(network);
    close_bench(&b);
}

static void until_both_were_served(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (count_of(b, 'M') >= 20 || n > 1000)
        (void)raise(SIGUSR1);
}

static void both_kinds_of_clients(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int client = request_over_modbus(&b), user = connect_client(&b);
    for (unsigned int n = 0; n < 40; n++)
        send_text(user, "{\"op\":\"list\",\"slave\":0}\n");
    run(&b, until_both_were_served);
    if (strstr(b.order, "MM") || strstr(b.order, "CC"))
        fail_msg("not in turn: %s", b.order);
    close(client);
    close(user);
    close_bench(&b);
}

static void until_modbus_was_served(bench_t *b, unsigned int n, const struct timespec *limit)
{
    if (n > 0 && strchr(b->order, 'M'))
        assert_non_null(limit);
    one_frame_at_a_time(b, n, limit);
}

static void rests_from_modbus(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    b.runner.client_pause_ns = 4000000000; /* longer than this test takes */
    int client = request_over_modbus(&b);
    run(&b, until_modbus_was_served);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    assert_int_equal(count_of(&b, 'M'), 1);
    close(client);
    close_bench(&b);
}

/* --- frames in a row ---------------------------------------------------------------------------------------------- */

enum { MOST_POLLS = 16, ALONE_US = 500 };

static int watcher;
static struct poll_time {
    size_t frames;
    uint64_t at_ns;
} poll_times[MOST_POLLS];
static unsigned int poll_count;

/* Frames are waiting from the start. Checks the replies when the loop serves clients for the n-th time. */
static void flood(bench_t *b, unsigned int n, const struct timespec *limit)
{
    for (unsigned int i = 0; n == 0 && i < FRAMES; i++)
        send_frame(b);
    assert_true(n < MOST_POLLS);
    poll_times[n] = (struct poll_time){b->runner.exchange.stats.frames, b->clock_ns};
    poll_count = n + 1;
    if (b->runner.exchange.stats.frames < FRAMES && n > 0)
        assert_true(limit && limit->tv_sec == 0 && limit->tv_nsec == 0); /* a look, no rest */
    if (b->runner.exchange.stats.frames == FRAMES)
        (void)raise(SIGUSR1);
}

static void open_patient_bench(bench_t *b)
{
    const struct timeval patience = {.tv_usec = 1000};
    open_bench(b, "fzm1", 1); /* an FZM1 that does nothing asks for no time */
    assert_int_equal(fcntl(b->port.fd, F_SETFL, 0), 0);
    assert_int_equal(setsockopt(b->port.fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    b->port.wait_ns = 20 * MS;
}

static void waits_where_it_receives(void **state)
{
    bench_t b;
    (void)state;
    open_patient_bench(&b);
    b.clock_ns = ect_packet_now();
    b.clock_step_ns = 15000;
    run(&b, flood);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    assert_int_equal(poll_times[0].frames, 0);
    assert_true(poll_count > 4);
    for (unsigned int n = 2; n + 1 < poll_count; n++) { /* the last one: none came for a while */
        uint64_t us = (poll_times[n].at_ns - poll_times[n - 1].at_ns) / 1000;
        if (poll_times[n].frames < poll_times[n - 1].frames + IN_A_ROW || us > ALONE_US + 100)
            fail_msg("look %u: expected more than %u frames and %u us since the last one, got %zu and %u", n, IN_A_ROW,
                     ALONE_US, poll_times[n].frames - poll_times[n - 1].frames, (unsigned int)us);
    }
    close_bench(&b);
}

/* Frames are waiting from the start, and none follows: after the last one the loop polls for clients at most once, then
 * it rests. */
static void flood_then_rest(bench_t *b, unsigned int n, const struct timespec *limit)
{
    for (unsigned int i = 0; n == 0 && i < FRAMES; i++)
        send_frame(b);
    if (b->runner.exchange.stats.frames < FRAMES)
        return;
    const bool polls = limit && limit->tv_sec == 0 && limit->tv_nsec == 0;
    poll_count += polls;
    assert_true(poll_count <= 1);
    if (!polls)
        (void)raise(SIGUSR1);
}

static void rests_when_no_frame_comes(void **state)
{
    bench_t b;
    (void)state;
    open_patient_bench(&b);
    b.clock_ns = ect_packet_now();
    b.clock_step_ns = 15000;
    poll_count = 0;
    run(&b, flood_then_rest);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    close_bench(&b);
}

static void flood_and_end(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    for (unsigned int i = 0; n == 0 && i < FRAMES; i++)
        send_frame(b);
    if (b->runner.exchange.stats.frames == FRAMES)
        (void)raise(SIGUSR1);
}

/* A frame could come from another place while the loop waits in the receiving call. */
static void waits_for_all_places_of_frames(void **state)
{
    static const struct {
        const char *title;
        bool udp, second;
        bool waits_in_call;
    } rows[] = {{"an interface alone", false, false, true},
                {"EtherCAT in UDP too", true, false, false},
                {"a second interface", false, true, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_udp_t udp = {.fd = -1};
        ect_packet_t second = {.fd = -1, .tagged_fd = -1};
        bench_t b;
        open_patient_bench(&b);
        b.clock_ns = ect_packet_now();
        b.clock_step_ns = 15000;
        b.runner.udp = rows[i].udp ? &udp : NULL;
        b.runner.ports[ECT_END_OUT] = rows[i].second ? &second : NULL;
        run(&b, flood_and_end);
        if ((b.waits < FRAMES) != rows[i].waits_in_call || (b.waited > 0) != rows[i].waits_in_call)
            fail_msg("%s: %u waits for all places, %u for one, and %d frames", rows[i].title, b.waits, b.waited,
                     (int)FRAMES);
        if (!rows[i].second) /* with it the replies leave there */
            assert_int_equal(count_of(&b, 'F'), FRAMES);
        close_bench(&b);
    }
}

/* With a client at work the loop never waits for frames alone. */
static void flood_with_client(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n == 0) {
        watcher = connect_client(b);
        for (unsigned int i = 0; i < 40; i++)
            send_text(watcher, "{\"op\":\"list\",\"slave\":0}\n");
    }
    if (b->runner.exchange.stats.frames < FRAMES && n % 2 == 0)
        send_frame(b);
    if (b->runner.exchange.stats.frames == FRAMES || n > 100 * FRAMES)
        (void)raise(SIGUSR1);
}

static void clients_between_frames_in_a_row(void **state)
{
    bench_t b;
    (void)state;
    open_patient_bench(&b);
    run(&b, flood_with_client);
    assert_int_equal(b.runner.exchange.stats.answered, FRAMES);
    assert_non_null(strstr(b.order, "FCF"));
    close(watcher);
    close_bench(&b);
}

/* Nothing rests, but the devices run and a signal ends it. */
static void spin(bench_t *b, unsigned int n, const struct timespec *limit)
{
    assert_true(limit && limit->tv_sec == 0 && limit->tv_nsec == 0);
    if (n == 0 || n == 3)
        send_frame(b);
    if (b->runner.exchange.stats.frames == 2)
        (void)raise(SIGUSR1);
}

static void never_rests(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    b.runner.busy_poll = true;
    run(&b, spin);
    assert_int_equal(b.runner.exchange.stats.answered, 2);
    close_bench(&b);
}

/* --- replies in the kernel ---------------------------------------------------------------------------------------- */

/* The kernel of the test: K: the turn is given, T: it is taken, G: a frame of the socket is counted, S: shown. */
static struct {
    bool given;
    int fd;            /* an eventfd: readable when it holds frames */
    unsigned int held; /* frames that it holds */
    ect_held_t frame;
    uint64_t runs_asleep, runs_got; /* of the devices, when the loop slept, and when it got a frame of the socket */
} kernel;

int __wrap_ect_kernel_fd(const ect_kernel_t *k);
unsigned int __wrap_ect_kernel_give(ect_kernel_t *k, ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_kernel_take(ect_kernel_t *k);
ect_held_t *__wrap_ect_kernel_next(ect_kernel_t *k);
void __wrap_ect_kernel_got(ect_kernel_t *k);
void __wrap_ect_kernel_see(ect_kernel_t *k, const uint8_t *frame, size_t length);

int __wrap_ect_kernel_fd(const ect_kernel_t *k)
{
    (void)k;
    return kernel.fd;
}

unsigned int __wrap_ect_kernel_give(ect_kernel_t *k, ect_chain_t *chain, uint64_t now_ns)
{
    (void)k;
    (void)now_ns;
    assert_ptr_equal(chain, running->wire.chain);
    kernel.given = true;
    note('K');
    return 3;
}

void __wrap_ect_kernel_take(ect_kernel_t *k)
{
    uint64_t rung;
    (void)k;
    (void)!read(kernel.fd, &rung, sizeof rung);
    kernel.given = false;
    note('T');
}

ect_held_t *__wrap_ect_kernel_next(ect_kernel_t *k)
{
    (void)k;
    assert_false(kernel.given);
    if (kernel.held == 0)
        return NULL;
    kernel.held--;
    kernel.frame.time_ns = ect_packet_now();
    return &kernel.frame;
}

void __wrap_ect_kernel_got(ect_kernel_t *k)
{
    (void)k;
    assert_false(kernel.given);
    kernel.runs_got = running->runner.exchange.stats.polls;
    note('G');
}

void __wrap_ect_kernel_see(ect_kernel_t *k, const uint8_t *frame, size_t length)
{
    (void)k;
    assert_true(frame && length > 0);
    note('S');
}

/* Two frames by the kernel and one by the loop, then the end. */
static void take_turns(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    assert_true(kernel.given);
    const uint64_t one = 1;
    if (n == 0) {
        kernel.held = 2;
        assert_int_equal(write(kernel.fd, &one, sizeof one), sizeof one);
    }
    if (n == 1)
        send_frame(b);
    if (n == 2)
        (void)raise(SIGUSR1);
}

/* A loop with the kernel of the test, which has BRD of AL status as its frame. */
static void run_with_kernel(bench_t *b, script_t *script)
{
    static int any;
    open_bench(b, "fzm1", 1);
    wire_build(&b->wire, BRD, 0, ECT_REG_AL_STATUS, "\0", 1);
    memcpy(kernel.frame.frame, b->wire.frame, b->wire.frame_length);
    kernel.frame.length = (uint32_t)b->wire.frame_length;
    b->runner.kernel = (ect_kernel_t *)(void *)&any;
    kernel.fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    assert_true(kernel.fd >= 0);
    run(b, script);
    b->runner.kernel = NULL;
    close(kernel.fd);
}

static void turns(void **state)
{
    bench_t b;
    (void)state;
    run_with_kernel(&b, take_turns);
    assert_string_equal(b.order, "KTKTGSFKT");
    assert_int_equal(b.runner.exchange.stats.in_kernel, 2);
    assert_int_equal(b.runner.exchange.stats.plans, 3);
    assert_int_equal(b.runner.exchange.stats.answered, 3);
    close_bench(&b);
}

/* A frame of the kernel with one of the socket behind it, then the end. */
static void one_of_each(bench_t *b, unsigned int n, const struct timespec *limit)
{
    const uint64_t one = 1;
    (void)limit;
    if (n > 0) {
        (void)raise(SIGUSR1);
        return;
    }
    kernel.held = 1;
    kernel.runs_asleep = b->runner.exchange.stats.polls;
    assert_int_equal(write(kernel.fd, &one, sizeof one), sizeof one);
    send_frame(b);
}

static void devices_between(void **state)
{
    bench_t b;
    (void)state;
    run_with_kernel(&b, one_of_each);
    assert_string_equal(b.order, "KTGSFKT");
    assert_int_equal(b.runner.exchange.stats.in_kernel, 1);
    assert_true(kernel.runs_got > kernel.runs_asleep);
    close_bench(&b);
}

/* --- cables ------------------------------------------------------------------------------------------------------- */

static struct {
    bool is_in;
    unsigned int seen; /* news that the loop has taken */
} cable;

bool __wrap_ect_packet_has_link(const ect_packet_t *port);
void __wrap_ect_packet_links_seen(int fd);

bool __wrap_ect_packet_has_link(const ect_packet_t *port)
{
    assert_ptr_equal(port, &running->port);
    return cable.is_in;
}

void __wrap_ect_packet_links_seen(int fd)
{
    eventfd_t news;
    assert_int_equal(fd, running->runner.link_fd);
    assert_int_equal(eventfd_read(fd, &news), 0);
    cable.seen++;
}

/* The cable is pulled, with news; plugged in, with a frame before the news; pulled, with a frame before the news. */
static void cables(bench_t *b, unsigned int n, const struct timespec *limit)
{
    static const struct {
        bool linked;
        unsigned int seen, answered;
    } rows[] = {{true, 0, 0}, {false, 1, 0}, {true, 1, 1}, {true, 1, 2}, {false, 2, 2}};
    (void)limit;
    assert_true(n < sizeof rows / sizeof rows[0]);
    assert_int_equal(b->runner.linked[ECT_END_IN], rows[n].linked);
    assert_int_equal(b->runner.exchange.linked[ECT_END_IN], rows[n].linked);
    assert_int_equal(cable.seen, rows[n].seen);
    assert_int_equal(b->runner.exchange.stats.answered, rows[n].answered);
    cable.is_in = n == 1;
    if (n == 1 || n == 2)
        send_frame(b);
    else
        assert_int_equal(eventfd_write(b->runner.link_fd, 1), 0);
    if (n == 4)
        (void)raise(SIGUSR1);
}

static void cables_are_followed(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    b.runner.link_fd = eventfd(0, EFD_NONBLOCK);
    assert_true(b.runner.link_fd > 0);
    cable.is_in = true;
    cable.seen = 0;
    run(&b, cables);
    assert_int_equal(close(b.runner.link_fd), 0);
    close_bench(&b);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static struct {
    int write_fd;
    unsigned int calls;
    int number;
    bool from_terminal;
} signals;

static bool note_signal(void *ctx, int signal_number, bool from_terminal)
{
    (void)ctx;
    signals.calls++;
    signals.number = signal_number;
    signals.from_terminal = from_terminal;
    return signal_number == SIGHUP;
}

static void give_signal(const struct signalfd_siginfo *info, size_t size)
{
    assert_int_equal(write(signals.write_fd, info, size), size);
}

/* Half a signal, one after which the loop goes on, and one that ends it. */
static void three_signals(bench_t *b, unsigned int n, const struct timespec *limit)
{
    const struct signalfd_siginfo on = {.ssi_signo = SIGHUP, .ssi_code = SI_USER};
    const struct signalfd_siginfo end = {.ssi_signo = SIGINT, .ssi_code = SI_KERNEL};
    (void)b, (void)limit;
    assert_int_equal(signals.calls, n < 2 ? 0 : n - 1);
    assert_true(n < 3);
    if (n == 0)
        give_signal(&on, sizeof on / 2);
    else
        give_signal(n == 1 ? &on : &end, sizeof on);
}

static void ends_at_a_signal(void **state)
{
    bench_t b;
    int ends[2];
    (void)state;
    open_bench(&b, "fzm1", 1);
    assert_int_equal(pipe2(ends, O_NONBLOCK | O_CLOEXEC), 0);
    assert_int_equal(close(b.runner.signal_fd), 0);
    memset(&signals, 0, sizeof signals);
    signals.write_fd = ends[1];
    b.runner.signal_fd = ends[0];
    b.runner.on_signal = note_signal;
    run(&b, three_signals);
    assert_int_equal(signals.calls, 2);
    assert_int_equal(signals.number, SIGINT);
    assert_true(signals.from_terminal);
    assert_int_equal(close(ends[1]), 0);
    close_bench(&b);
}

/* --- results of the wire ------------------------------------------------------------------------------------------ */

static void one_result(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n == 0)
        send_frame(b);
    else
        (void)raise(SIGUSR1);
}

static void results_of_the_wire(void **state)
{
    static const struct {
        const char *title;
        bool beyond_room;
        ssize_t result;
        int ends; /* the loop's result */
        uint64_t frames, stale, unanswered, answered, faulty;
    } cases[] = {
        {"a frame", false, 60, 0, 1, 0, 0, 1, 1},
        {"no frame", false, ECT_PACKET_NONE, 0, 0, 0, 0, 0, 0},
        {"the interface is gone", false, ECT_PACKET_GONE, -1, 0, 0, 0, 0, 0},
        {"a frame too old to reply to", false, ECT_PACKET_STALE, 0, 1, 1, 0, 0, 0},
        {"a frame that fills the room: faults concern it", true, 0, 0, 1, 0, 1, 0, 1},
        {"a truncated frame: only the controllers process it", true, 1, 0, 1, 0, 1, 0, 0},
    };
    static ect_scenario_t scenario;
    char message[ECT_FAULT_MESSAGE];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        bench_t b;
        scenario = (ect_scenario_t){.seed = 1};
        assert_true(ect_scenario_read(&scenario, "drop frame 1000", message));
        open_bench(&b, "fzm1", 1);
        b.runner.exchange.scenario = &scenario;
        b.result_set = true;
        b.beyond_room = cases[i].beyond_room;
        b.result = cases[i].result;
        b.script = one_result;
        running = &b;
        const int ended = ect_runner_run(&b.runner);
        running = NULL;
        const ect_stats_t *s = &b.runner.exchange.stats;
        if (ended != cases[i].ends || s->frames != cases[i].frames || s->stale != cases[i].stale ||
            s->unanswered != cases[i].unanswered || s->answered != cases[i].answered ||
            scenario.frames != cases[i].faulty)
            fail_msg("%s: got %d, %u frames, %u stale, %u without and %u with reply, %u in the script", cases[i].title,
                     ended, (unsigned int)s->frames, (unsigned int)s->stale, (unsigned int)s->unanswered,
                     (unsigned int)s->answered, (unsigned int)scenario.frames);
        assert_true(b.room >= ECT_ESC_MAX_FRAME + 4);
        close_bench(&b);
    }
}

/* --- the pause of clients ----------------------------------------------------------------------------------------- */

enum { PAUSE_NS = 1000 };
static unsigned int after_service;

/* Sets the clock to the last nanosecond of the pause, then to its end. */
static void until_the_pause_ends(bench_t *b, unsigned int n, const struct timespec *limit)
{
    if (count_of(b, 'C') == 0) {
        assert_true(n < 100);
        return;
    }
    switch (after_service++) {
    case 0:
        assert_int_equal(limit->tv_nsec, PAUSE_NS);
        b->clock_ns += PAUSE_NS - 1;
        return;
    case 1:
        assert_int_equal(limit->tv_nsec, 1);
        b->clock_ns += 1;
        return;
    case 2:
        assert_int_equal(count_of(b, 'C'), 1);
        return;
    default:
        assert_int_equal(count_of(b, 'C'), 2);
        (void)raise(SIGUSR1);
    }
}

static void a_pause_ends_at_its_last_nanosecond(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    b.clock_ns = b.wire.now_ns;
    b.runner.client_pause_ns = PAUSE_NS;
    after_service = 0;
    int fd = connect_client(&b);
    for (unsigned int n = 0; n < 40; n++)
        send_text(fd, "{\"op\":\"list\"}\n");
    run(&b, until_the_pause_ends);
    close(fd);
    close_bench(&b);
}

/* --- frames that are too long ------------------------------------------------------------------------------------- */

enum { LONG = 9000 }; /* jumbo frames: an interface may be set to take them */
static size_t long_length = LONG;

static void send_long_frame(bench_t *b)
{
    static uint8_t frame[LONG];
    memset(frame, 0xFF, sizeof frame);
    wire_build(&b->wire, BRD, 0, 0, "\0", 1);
    memcpy(frame, b->wire.frame, 16);
    assert_int_equal(__real_send(b->master, frame, long_length, 0), long_length);
}

static void from_end(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n == 0)
        send_long_frame(b);
    if (b->runner.exchange.stats.frames == 1 || n > 100)
        (void)raise(SIGUSR1);
}

/* With a fault that touches bytes of each frame; from the far end, from where no slave processes it on its way; with a
 * trace, which keeps a frame as it came. */
static void too_long(void **state)
{
    static const size_t lengths[] = {ECT_ESC_MAX_FRAME + 1, ECT_ESC_MAX_FRAME + 48, LONG};
    static ect_scenario_t scenario;
    char message[ECT_FAULT_MESSAGE];
    uint8_t answer[64];
    (void)state;
    for (unsigned int i = 0; i < ECT_ENDS * sizeof lengths / sizeof lengths[0]; i++) {
        const unsigned int end = i % ECT_ENDS;
        bench_t b;
        long_length = lengths[i / ECT_ENDS];
        scenario = (ect_scenario_t){.seed = 1};
        assert_true(ect_scenario_read(&scenario, "corrupt", message));
        open_bench(&b, "fzm1", 2);
        if (end == ECT_END_OUT)
            b.runner.ports[ECT_END_IN] = NULL;
        b.runner.ports[end] = &b.port;
        b.runner.exchange.scenario = &scenario;
        b.runner.exchange.trace = ect_trace_new(NULL, NULL, 2);
        run(&b, from_end);
        assert_int_equal(b.runner.exchange.stats.frames, 1);
        assert_int_equal(b.runner.exchange.stats.unanswered, 1);
        assert_int_equal(b.runner.exchange.stats.answered, 0);
        assert_int_equal(recv(b.master, answer, sizeof answer, MSG_DONTWAIT), -1);
        if (end == ECT_END_IN)
            assert_int_equal(ect_chain_esc(b.wire.chain, 0)->memory[0x0300], 1);
        (void)ect_trace_close(b.runner.exchange.trace, 0);
        close_bench(&b);
    }
}

static void behind_another(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n == 0) {
        send_frame(b);
        send_long_frame(b);
    }
    if (b->runner.exchange.stats.frames == 2 || n > 100)
        (void)raise(SIGUSR1);
}

/* A frame that is lost before it reaches the wire of its next fault. */
static void nothing_is_left_over(void **state)
{
    static ect_scenario_t scenario;
    char message[ECT_FAULT_MESSAGE];
    (void)state;
    for (uint32_t seed = 1; seed <= 16; seed++) {
        bench_t b;
        scenario = (ect_scenario_t){.seed = seed};
        assert_true(ect_scenario_read(&scenario, "drop frame 1", message));
        assert_true(ect_scenario_read(&scenario, "drop frame 1 wire 1", message));
        open_bench(&b, "fzm1", 2);
        b.runner.exchange.scenario = &scenario;
        run(&b, behind_another);
        assert_int_equal(b.runner.exchange.stats.dropped, 1);
        assert_int_equal(b.runner.exchange.stats.unanswered, 1);
        assert_int_equal(ect_chain_esc(b.wire.chain, 0)->memory[0x0300], 1); /* the long one has arrived */
        close_bench(&b);
    }
}

/* --- times at which clients are due ------------------------------------------------------------------------------- */

enum { DUE_NS = 7000000, LOST_IN = 3, LOST_OUT = 5 };

/* With `set`, the time of each kind of clients. */
static struct {
    bool set;
    uint64_t control, modbus, hosts;
} due;

uint64_t __real_ect_control_due(const ect_control_t *c);
uint64_t __wrap_ect_control_due(const ect_control_t *c);
uint64_t __real_ect_modbus_server_due(const ect_modbus_server_t *s);
uint64_t __wrap_ect_modbus_server_due(const ect_modbus_server_t *s);
uint64_t __real_ect_hosts_due(const ect_hosts_t *h);
uint64_t __wrap_ect_hosts_due(const ect_hosts_t *h);
unsigned int __real_ect_packet_lost(ect_packet_t *port);
unsigned int __wrap_ect_packet_lost(ect_packet_t *port);

uint64_t __wrap_ect_control_due(const ect_control_t *c)
{
    return due.set ? due.control : __real_ect_control_due(c);
}

uint64_t __wrap_ect_modbus_server_due(const ect_modbus_server_t *s)
{
    return due.set ? due.modbus : __real_ect_modbus_server_due(s);
}

uint64_t __wrap_ect_hosts_due(const ect_hosts_t *h)
{
    return due.set ? due.hosts : __real_ect_hosts_due(h);
}

unsigned int __wrap_ect_packet_lost(ect_packet_t *port)
{
    return !due.set ? __real_ect_packet_lost(port) : port == &running->port ? LOST_IN : LOST_OUT;
}

/* Time passes to the nanosecond at which a client is due. */
static void until_a_client_is_due(bench_t *b, unsigned int n, const struct timespec *limit)
{
    if (n == 0) {
        assert_true(limit && limit->tv_sec == 0);
        assert_int_equal(limit->tv_nsec, DUE_NS);
        b->clock_ns += DUE_NS;
        return;
    }
    (void)raise(SIGUSR1);
}

static void open_server(bench_t *b)
{
    char message[ECT_MODBUS_MESSAGE];
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&at, sizeof at.sun_family), 0);
    assert_int_equal(listen(fd, 1), 0);
    b->runner.modbus = ect_modbus_server_at(fd, message);
    assert_non_null(b->runner.modbus);
}

static void clients_are_due(void **state)
{
    static const struct {
        uint64_t *at_ns;
        char kind;
        unsigned int lost; /* frames that the counters have then */
    } rows[] = {{&due.control, 'C', LOST_IN + LOST_OUT}, {&due.modbus, 'M', 0}, {&due.hosts, 'H', 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_t second = {.fd = -1, .tagged_fd = -1};
        bench_t b;
        open_bench(&b, "fzm1", 1);
        open_server(&b);
        b.runner.hosts = ect_hosts_new();
        b.runner.ports[ECT_END_OUT] = &second;
        b.clock_ns = b.wire.now_ns;
        due.control = due.modbus = due.hosts = ECT_NEVER;
        *rows[i].at_ns = b.clock_ns + DUE_NS;
        due.set = true;
        run(&b, until_a_client_is_due);
        due.set = false;
        assert_int_equal(b.order[0], rows[i].kind);
        assert_int_equal(count_of(&b, b.order[0]), b.logged);
        assert_int_equal(b.runner.exchange.stats.queue_lost, b.logged * rows[i].lost);
        ect_hosts_close(b.runner.hosts);
        close_bench(&b);
    }
}

/* --- EtherCAT in UDP at an interface ------------------------------------------------------------------------------ */

static void send_udp_frame(bench_t *b, unsigned int n, const struct timespec *limit)
{
    enum { HEADERS = 42, ETHERNET = 14 };
    static const uint8_t headers[HEADERS] = {
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0, 0,  0, 1, 0x08, 0x00, 0x45, 0,    0,    60, 0,  0, 0,
        0,    64,   17,   0,    0,    10,   0,    0, 1, 10, 0, 0, 2,    0x88, 0xA4, 0x88, 0xA4, 0,  40, 0, 0};
    uint8_t frame[200];
    (void)limit;
    if (n > 0) {
        (void)raise(SIGUSR1);
        return;
    }
    wire_build(&b->wire, BRD, 0, 0x0130, "\0", 1);
    const size_t payload = b->wire.frame_length - ETHERNET;
    memcpy(frame, headers, HEADERS);
    memcpy(frame + HEADERS, b->wire.frame + ETHERNET, payload);
    assert_int_equal(__real_send(b->master, frame, HEADERS + payload, 0), (ssize_t)(HEADERS + payload));
}

static void udp_at_an_interface(void **state)
{
    uint8_t reply[200];
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    run(&b, send_udp_frame);
    assert_int_equal(b.runner.exchange.stats.answered, 1);
    assert_true(recv(b.master, reply, sizeof reply, MSG_DONTWAIT) > 0);
    assert_int_equal(ect_load_be16(reply + 12), 0x0800);
    close_bench(&b);
}

/* --- watching ----------------------------------------------------------------------------------------------------- */

static uint64_t limit_of(const struct timespec *limit)
{
    return limit ? (uint64_t)limit->tv_sec * 1000000000u + (uint64_t)limit->tv_nsec : ECT_NEVER;
}

/* Whether the clients have nothing to be done for them at this moment. */
static bool at_rest(const bench_t *b)
{
    struct pollfd fd = {.fd = ect_control_fd(b->runner.exchange.control), .events = POLLIN};
    return poll(&fd, 1, 0) == 0 && ect_control_due(b->runner.exchange.control) > ect_packet_now();
}

/* A client asks for everything that the loop shows to its control socket. */
static void ask(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n == 0) {
        send_frame(b);
        watcher = connect_client(b);
        send_text(watcher, "{\"op\":\"stats\"}\n{\"op\":\"counters\"}\n{\"op\":\"events\"}\n");
    } else if (at_rest(b)) {
        (void)raise(SIGUSR1);
    }
}

static void clients_read_the_loop(void **state)
{
    char answer[ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    run(&b, ask);
    const ssize_t got = read(watcher, answer, sizeof answer - 1);
    assert_true(got > 0);
    answer[got] = 0;
    close(watcher);
    assert_non_null(strstr(answer, "{\"frames\":1,\"answered\":1,"));
    if (strstr(answer, "\"ok\":false"))
        fail_msg("%s", answer);
    close_bench(&b);
}

/* --- the shortest wait for frames alone ----------------------------------------------------------------------------
 */

static uint64_t more_ns; /* time of the client beyond the wait of the port */

static void frames_before_a_client(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)limit;
    if (n == 0) {
        send_frame(b);
        send_frame(b);
        due.control = b->clock_ns + b->port.wait_ns + more_ns;
    }
    if (b->runner.exchange.stats.frames == 2)
        (void)raise(SIGUSR1);
}

static void waits_if_time_is_left(void **state)
{
    (void)state;
    for (more_ns = 0; more_ns < 2; more_ns++) {
        bench_t b;
        open_patient_bench(&b);
        b.clock_ns = b.wire.now_ns;
        due.control = due.modbus = due.hosts = ECT_NEVER;
        due.set = true;
        run(&b, frames_before_a_client);
        due.set = false;
        assert_int_equal(b.waited > 0, more_ns > 0);
        close_bench(&b);
    }
}

static unsigned int step;

/* Nothing but the watcher makes the loop wake up: an FZM1 that does nothing asks for no time. */
static void expect_rounds(bench_t *b, unsigned int n, const struct timespec *limit)
{
    char answer[1024];
    (void)n;
    if (!at_rest(b))
        return;
    switch (step++) {
    case 0:
        assert_true(limit_of(limit) == ECT_NEVER);
        watcher = connect_client(b);
        send_text(watcher, "{\"op\":\"watch\",\"pattern\":\"busy\"}\n");
        return;
    case 1:
    case 2:
        assert_true(limit_of(limit) <= 10 * MS);
        return;
    case 3:
        assert_true(read(watcher, answer, sizeof answer) > 0);
        close(watcher);
        return;
    default:
        assert_true(limit_of(limit) == ECT_NEVER);
        (void)raise(SIGUSR1);
    }
}

static void report_deadline(void **state)
{
    bench_t b;
    (void)state;
    step = 0;
    open_bench(&b, "fzm1", 1);
    run(&b, expect_rounds);
    assert_int_equal(step, 5);
    close_bench(&b);
}

static void a_short_measurement(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)n;
    (void)limit;
    if (!at_rest(b) || b->runner.exchange.deadline_ns <= ect_packet_now())
        return;
    switch (step++) {
    case 0:
        watcher = connect_client(b);
        send_text(watcher, "{\"op\":\"watch\",\"pattern\":\"busy\",\"every\":true}\n");
        return;
    case 1:
        send_text(watcher, "{\"op\":\"set\",\"values\":{\"image_input\":100,\"processing\":150,\"trigger\":1}}\n");
        return;
    default:
        (void)raise(SIGUSR1);
    }
}

/* The loop continues 5 ms after a trigger that begins and ends a measurement within 250 us. */
static void late_loop(void **state)
{
    char answer[ROOM];
    double on, off;
    bench_t b;
    (void)state;
    step = 0;
    open_bench(&b, "fzm1", 1);
    b.serve_late_ns = 5 * MS;
    run(&b, a_short_measurement);
    ssize_t got = read(watcher, answer, sizeof answer - 1);
    assert_true(got > 0);
    answer[got] = 0;
    const char *rise = strstr(answer, "\"value\":1,\"time\":");
    const char *fall = rise ? strstr(rise, "\"value\":0,\"time\":") : NULL;
    if (!fall)
        fail_msg("BUSY was not reported: %s", answer);
    assert_int_equal(sscanf(rise, "\"value\":1,\"time\":%lf", &on), 1);
    assert_int_equal(sscanf(fall, "\"value\":0,\"time\":%lf", &off), 1);
    assert_true(off - on > 248e-6 && off - on < 252e-6);
    close(watcher);
    close_bench(&b);
}

/* --- frames that circulate ---------------------------------------------------------------------------------------- */

static unsigned int reported;

static void count_report(void *ctx, const char *iface)
{
    (void)ctx;
    (void)iface;
    assert_int_equal(running->runner.exchange.stats.circling, 1); /* the first of them */
    reported++;
}

/* Each reply is received again, until three frames have been destroyed. */
static void echo(bench_t *b, unsigned int n, const struct timespec *limit)
{
    uint8_t frame[2048];
    (void)limit;
    ssize_t length = recv(b->master, frame, sizeof frame, MSG_DONTWAIT);
    if (length > 0)
        assert_int_equal(__real_send(b->master, frame, (size_t)length, 0), length);
    else if (b->runner.exchange.stats.circling >= 3 || n > 5000)
        (void)raise(SIGUSR1);
    else
        send_frame(b);
}

static void circulating_frames(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    b.clock_ns = b.wire.now_ns; /* so that no pause of this process ends the window of time */
    b.clock_step_ns = 100;
    b.runner.on_circulating = count_report;
    reported = 0;
    run(&b, echo);
    assert_true(b.runner.exchange.stats.circling >= 3);
    assert_int_equal(reported, 1);
    close_bench(&b);
}

/* --- the end ------------------------------------------------------------------------------------------------------ */

enum { POLLS_OF_A_SAVE = 5 };
static unsigned int flushes;

static bool saves(const void *instance)
{
    (void)instance;
    return ++flushes < POLLS_OF_A_SAVE;
}

/* Never ends; each poll takes 0.1 s. */
static bool saves_for_ever(const void *instance)
{
    (void)instance;
    flushes++;
    running->clock_ns += 100 * MS;
    return true;
}

static void at_once(bench_t *b, unsigned int n, const struct timespec *limit)
{
    (void)b;
    (void)n;
    (void)limit;
    (void)raise(SIGUSR1);
}

static void finishes_a_save(void **state)
{
    static const ect_plant_t plants[] = {{.unfinished = saves}, {.unfinished = saves_for_ever}};
    static const unsigned int polls[] = {POLLS_OF_A_SAVE, 20};
    (void)state;
    for (size_t i = 0; i < sizeof plants / sizeof plants[0]; i++) {
        bench_t b;
        open_bench(&b, "fzm1", 1);
        const ect_twin_config_t twin = ect_twin_default(ect_catalogue_find("fzm1")->device, &plants[i]);
        ect_chain_free(b.wire.chain);
        b.runner.exchange.chain = b.wire.chain = ect_chain_new(&twin, 1, b.wire.now_ns);
        assert_non_null(b.wire.chain);
        b.clock_ns = b.wire.now_ns;
        flushes = 0;
        run(&b, at_once);
        assert_int_equal(flushes, polls[i]);
        close_bench(&b);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Attack: 100 frames and 640 requests wait: 8 frames are answered before a client is served", frames_first,
         NULL, NULL, NULL},
        {"half a signal has no effect; the loop ends when a signal is to end it", ends_at_a_signal, NULL, NULL, NULL},
        {"a cable counts as plugged in or pulled from the news of it on, or from a frame on", cables_are_followed, NULL,
         NULL, NULL},
        {"Attack: a client is served once between two frames", once_between_frames, NULL, NULL, NULL},
        {"Attack: clients do not keep the processor busy: there is a rest after each piece of work", rests, NULL, NULL,
         NULL},
        {"Attack: 100 frames and 60 Modbus requests wait: 8 frames are answered before a client is served",
         frames_before_modbus, NULL, NULL, NULL},
        {"Attack: 100 frames and 40 frames of EoE wait: 8 frames are answered before a host is served",
         frames_before_hosts, NULL, NULL, NULL},
        {"Modbus clients and users of the control socket are served in turn", both_kinds_of_clients, NULL, NULL, NULL},
        {"Attack: Modbus clients do not keep the processor busy: there is a rest after each request", rests_from_modbus,
         NULL, NULL, NULL},
        {"Frames in succession are awaited in the call that receives them; clients and signals are checked every half "
         "millisecond",
         waits_where_it_receives, NULL, NULL, NULL},
        {"Frames in succession: without a further frame the loop rests", rests_when_no_frame_comes, NULL, NULL, NULL},
        {"Frames in succession: the loop waits for one at a single place of frames alone",
         waits_for_all_places_of_frames, NULL, NULL, NULL},
        {"Frames in succession: clients are served between them", clients_between_frames_in_a_row, NULL, NULL, NULL},
        {"--busy-poll: nothing rests, and all is served", never_rests, NULL, NULL, NULL},
        {"--in-kernel: the kernel has the turn while the loop sleeps, and its frames come first", turns, NULL, NULL,
         NULL},
        {"--in-kernel: the devices get the outputs of a frame of the kernel before a frame of the socket replaces them",
         devices_between, NULL, NULL, NULL},
        {"Each result of the wire has its counter", results_of_the_wire, NULL, NULL, NULL},
        {"A pause of the clients ends at its last nanosecond", a_pause_ends_at_its_last_nanosecond, NULL, NULL, NULL},
        {"Attack: a frame longer than any of EtherCAT is counted by the controller, gets no reply and changes "
         "nothing",
         too_long, NULL, NULL, NULL},
        {"A fault for a frame on a wire concerns no other frame, however the frame is lost before",
         nothing_is_left_over, NULL, NULL, NULL},
        {"The loop sleeps until the nanosecond at which a kind of clients is due, and serves that kind",
         clients_are_due, NULL, NULL, NULL},
        {"A frame of EtherCAT in UDP at an interface has its reply there", udp_at_an_interface, NULL, NULL, NULL},
        {"The control socket has the counters, working counters and events of the loop", clients_read_the_loop, NULL,
         NULL, NULL},
        {"The loop waits for frames alone if more time is left than the wait may take", waits_if_time_is_left, NULL,
         NULL, NULL},
        {"Only a watch wakes the loop, every 10 ms", report_deadline, NULL, NULL, NULL},
        {"Frames that circulate are destroyed, and reported once", circulating_frames, NULL, NULL, NULL},
        {"The loop ends only when a save is over, or 2 s later", finishes_a_save, NULL, NULL, NULL},
        {"A late loop runs the devices at their deadlines: every change is reported", late_loop, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Event loop", tests, NULL, NULL);
}
