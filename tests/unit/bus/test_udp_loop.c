/* SPDX-License-Identifier: MIT */
/* Masters over EtherCAT in UDP, through the event loop (bus/runner.h) on a virtual clock: the socket, the wait and the
 * clock are the test's. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "bus/runner.h"
#include "support/wire.h"

enum { UDP_FD = 900, PAYLOAD = 100, QUEUE = 8, ORDER = 100, FIRST = 40001, SECOND = 40002 };

typedef struct datagram {
    uint16_t port; /* of the master */
    size_t length;
    uint8_t bytes[PAYLOAD];
} datagram_t;

/* The actions of a test before the loop waits for the n-th time. @return false: the loop is to end */
typedef bool script_t(unsigned int n);

static struct bench {
    bool runs;
    wire_t wire;
    ect_runner_t runner;
    ect_udp_t udp;
    script_t *script;
    unsigned int waits;
    uint64_t clock_ns;
    datagram_t sent[QUEUE]; /* to the twins, in their order */
    size_t sent_count, taken;
    int error; /* of the next reception; 0: none */
    datagram_t replies[QUEUE];
    size_t reply_count;
    char order[ORDER]; /* with hosts: F: a reply, H: the hosts were served */
    size_t ordered;
} bench;

/* --- calls -------------------------------------------------------------------------------------------------------- */

int __real_clock_gettime(clockid_t clock, struct timespec *time);
int __wrap_clock_gettime(clockid_t clock, struct timespec *time);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask);
ssize_t __wrap_recvfrom(int fd, void *data, size_t size, int flags, struct sockaddr *from, socklen_t *from_size);
ssize_t __wrap_sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *to, socklen_t to_size);
void __wrap_ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns);

static void note(char what)
{
    if (!bench.runner.hosts)
        return;
    assert_true(bench.ordered + 1 < ORDER);
    bench.order[bench.ordered++] = what;
}

void __wrap_ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns)
{
    (void)now_ns;
    assert_ptr_equal(hosts, bench.runner.hosts);
    assert_ptr_equal(chain, bench.wire.chain);
    note('H');
}

int __wrap_clock_gettime(clockid_t clock, struct timespec *time)
{
    if (!bench.runs)
        return __real_clock_gettime(clock, time);
    *time = (struct timespec){.tv_sec = (time_t)(bench.clock_ns / 1000000000u),
                              .tv_nsec = (long)(bench.clock_ns % 1000000000u)};
    return 0;
}

/* Time passes only here, and only while no datagram waits. */
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask)
{
    (void)mask;
    const bool ends = !bench.script(bench.waits++);
    const bool waiting = bench.taken < bench.sent_count || bench.error != 0;
    if (ends)
        (void)raise(SIGUSR1);
    else if (!waiting && limit)
        bench.clock_ns += (uint64_t)limit->tv_sec * 1000000000u + (uint64_t)limit->tv_nsec;
    else if (!waiting)
        fail_msg("nothing wakes the loop");
    for (nfds_t i = 0; i < count; i++) {
        bool ready = (ends && fds[i].fd == bench.runner.signal_fd) || (waiting && fds[i].fd == UDP_FD) ||
                     (bench.runner.hosts && fds[i].fd == ect_hosts_fd(bench.runner.hosts));
        fds[i].revents = ready ? POLLIN : 0;
    }
    return ends || waiting;
}

ssize_t __wrap_recvfrom(int fd, void *data, size_t size, int flags, struct sockaddr *from, socklen_t *from_size)
{
    (void)flags;
    assert_int_equal(fd, UDP_FD);
    if (bench.error != 0) {
        errno = bench.error;
        bench.error = 0;
        return -1;
    }
    const datagram_t *d = &bench.sent[bench.taken++];
    const struct sockaddr_in in = {
        .sin_family = AF_INET, .sin_port = htons(d->port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    assert_true(d->length <= size && *from_size >= sizeof in);
    memcpy(data, d->bytes, d->length);
    memcpy(from, &in, sizeof in);
    return (ssize_t)d->length;
}

ssize_t __wrap_sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *to, socklen_t to_size)
{
    (void)flags;
    assert_true(fd == UDP_FD && to_size == sizeof(struct sockaddr_in) && bench.reply_count < QUEUE && size <= PAYLOAD);
    const struct sockaddr_in *in = (const struct sockaddr_in *)(const void *)to;
    datagram_t *d = &bench.replies[bench.reply_count++];
    note('F');
    assert_int_equal(in->sin_addr.s_addr, htonl(INADDR_LOOPBACK));
    d->port = ntohs(in->sin_port);
    d->length = size;
    memcpy(d->bytes, data, size);
    return (ssize_t)size;
}

/* --- the bench ---------------------------------------------------------------------------------------------------- */

static bool stop(void *ctx, int signal_number, bool from_terminal)
{
    (void)ctx;
    (void)signal_number;
    (void)from_terminal;
    return false;
}

static unsigned int circled;

static void circling(void *ctx, const char *where)
{
    (void)ctx;
    assert_string_equal(where, "127.0.0.1:34980");
    circled++;
}

static void open_bench(void)
{
    sigset_t signals;
    const ect_product_t *product = ect_catalogue_find("fzm1");
    const ect_twin_config_t twin = ect_twin_default(product->device, product->plant);
    memset(&bench, 0, sizeof bench);
    circled = 0;
    wire_open_twins(&bench.wire, &twin, 1);
    bench.udp = (ect_udp_t){.fd = UDP_FD, .address = "127.0.0.1:34980"};
    bench.clock_ns = bench.wire.now_ns;
    sigemptyset(&signals);
    sigaddset(&signals, SIGUSR1);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    bench.runner = (ect_runner_t){.udp = &bench.udp,
                                  .exchange = {.chain = bench.wire.chain},
                                  .signal_fd = signalfd(-1, &signals, SFD_NONBLOCK),
                                  .link_fd = -1,
                                  .on_signal = stop,
                                  .on_circulating = circling};
    assert_true(bench.runner.signal_fd >= 0);
}

static void run(script_t *script)
{
    bench.script = script;
    bench.runs = true;
    assert_int_equal(ect_runner_run(&bench.runner), 0);
    bench.runs = false;
}

static void close_bench(void)
{
    close(bench.runner.signal_fd);
    wire_close(&bench.wire);
}

static void send_payload(uint16_t port, const uint8_t *payload, size_t length)
{
    assert_true(bench.sent_count < QUEUE && length <= PAYLOAD);
    datagram_t *d = &bench.sent[bench.sent_count++];
    d->port = port;
    d->length = length;
    memcpy(d->bytes, payload, length);
}

static void send_command(uint16_t port, uint8_t command, uint16_t adp, uint16_t ado, uint16_t value)
{
    uint8_t data[2];
    ect_store_le16(data, value);
    wire_build(&bench.wire, command, adp, ado, data, sizeof data);
    send_payload(port, bench.wire.frame + 14, 2 + 12 + sizeof data);
}

/* --- a master ----------------------------------------------------------------------------------------------------- */

static bool up_to_preop(unsigned int n)
{
    if (n == 0)
        send_command(FIRST, FPWR, WIRE_STATION, 0x0120, 0x0002);
    if (bench.reply_count == 1 && bench.sent_count == 1 && bench.clock_ns > 1001 * MS)
        send_command(FIRST, FPRD, WIRE_STATION, 0x0130, 0);
    return bench.reply_count < 2 && n < 10000;
}

static void a_master(void **state)
{
    (void)state;
    open_bench();
    wire_configure_mailbox(&bench.wire, 0);
    bench.clock_ns = bench.wire.now_ns;
    run(up_to_preop);
    assert_int_equal(bench.reply_count, 2);
    const uint8_t *reply = bench.replies[1].bytes;
    assert_int_equal(ect_load_le16(reply + 2 + 10), 0x0002); /* AL status */
    assert_int_equal(ect_load_le16(reply + 2 + 12), 1);      /* working counter */
    assert_int_equal(bench.runner.exchange.stats.answered, 2);
    close_bench();
}

/* --- two senders, replies delayed by a fault ---------------------------------------------------------------------- */

static bool both_send(unsigned int n)
{
    if (n == 0) {
        send_command(FIRST, APRD, 0, 0x0000, 0);
        send_command(SECOND, BRD, 0, 0x0130, 0);
    }
    return bench.reply_count < 2 && n < 10000;
}

static void own_senders(void **state)
{
    static ect_scenario_t scenario;
    char message[ECT_FAULT_MESSAGE];
    (void)state;
    for (unsigned int late = 0; late < 2; late++) {
        open_bench();
        scenario = (ect_scenario_t){.seed = 1};
        assert_true(!late || ect_scenario_read(&scenario, "delay 5000us frame 1", message));
        bench.runner.exchange.scenario = &scenario;
        run(both_send);
        assert_int_equal(bench.reply_count, 2);
        assert_int_equal(bench.runner.exchange.stats.delayed, late ? 2 : 0);
        for (size_t i = 0; i < 2; i++) {
            const uint8_t command = bench.replies[i].bytes[2];
            assert_int_equal(command, bench.replies[i].port == FIRST ? APRD : BRD);
        }
        assert_int_not_equal(bench.replies[0].port, bench.replies[1].port);
        close_bench();
    }
}

/* --- bad datagrams ------------------------------------------------------------------------------------------------ */

static bool bad_and_good(unsigned int n)
{
    static const uint8_t bad[][16] = {{0}, {0xFF, 0x17}, {0x0E, 0x40}, {0x0E, 0x10, 7, 0, 0, 0, 0, 0, 0xFF, 0x87}};
    for (size_t i = 0; n == 0 && i < sizeof bad / sizeof bad[0]; i++)
        send_payload(FIRST, bad[i], i == 0 ? 3 : sizeof bad[i]);
    if (n == 0)
        send_command(FIRST, BRD, 0, 0x0130, 0);
    return bench.reply_count < 1 && n < 10000;
}

static void bad_datagrams(void **state)
{
    (void)state;
    open_bench();
    run(bad_and_good);
    assert_int_equal(bench.runner.exchange.stats.frames, 5);
    assert_int_equal(bench.runner.exchange.stats.unanswered, 4);
    assert_int_equal(bench.runner.exchange.stats.answered, 1);
    close_bench();
}

/* --- no datagram -------------------------------------------------------------------------------------------------- */

static bool one_after_an_error(unsigned int n)
{
    if (n == 1)
        send_command(FIRST, BRD, 0, 0x0130, 0);
    return bench.reply_count < 1 && n < 10000;
}

static void errors(void **state)
{
    static const struct {
        int error, result;
        unsigned int replies;
    } rows[] = {{EAGAIN, 0, 1}, {EINTR, 0, 1}, {ENOTCONN, -1, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        open_bench();
        bench.error = rows[i].error;
        bench.script = one_after_an_error;
        bench.runs = true;
        assert_int_equal(ect_runner_run(&bench.runner), rows[i].result);
        bench.runs = false;
        assert_int_equal(bench.reply_count, rows[i].replies);
        close_bench();
    }
}

/* --- a second program that replies -------------------------------------------------------------------------------- */

static bool echo(unsigned int n)
{
    bench.sent_count = bench.taken = 0;
    if (n == 0)
        send_command(FIRST, BRD, 0, 0x0130, 0);
    else if (bench.reply_count > 0)
        send_payload(FIRST, bench.replies[0].bytes, bench.replies[0].length);
    bench.reply_count = 0;
    return bench.runner.exchange.stats.circling == 0 && n < 5000;
}

static void circulating(void **state)
{
    (void)state;
    open_bench();
    run(echo);
    assert_int_equal(bench.runner.exchange.stats.circling, 1);
    assert_int_equal(circled, 1);
    close_bench();
}

/* --- hosts behind EoE --------------------------------------------------------------------------------------------- */

enum { IN_A_ROW = 8, ROUNDS = 3 };

static bool one_after_another(unsigned int n)
{
    bench.sent_count = bench.taken = bench.reply_count = 0;
    if (n < ROUNDS * IN_A_ROW)
        send_command(FIRST, BRD, 0, 0x0130, 0);
    return n < ROUNDS * IN_A_ROW;
}

/* The hosts have something to serve all the time. */
static void datagrams_first(void **state)
{
    (void)state;
    open_bench();
    bench.runner.hosts = ect_hosts_new();
    assert_non_null(bench.runner.hosts);
    run(one_after_another);
    ect_hosts_close(bench.runner.hosts);
    assert_string_equal(bench.order, "FFFFFFFFHFFFFFFFFHFFFFFFFFH");
    close_bench();
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A master over EtherCAT in UDP brings a twin to PREOP", a_master, NULL, NULL, NULL},
        {"Each reply goes to its own sender, also a late one", own_senders, NULL, NULL, NULL},
        {"Attack: datagrams that are no EtherCAT are counted, and get no reply", bad_datagrams, NULL, NULL, NULL},
        {"Attack: replies sent back by another program are destroyed, and reported once", circulating, NULL, NULL,
         NULL},
        {"The loop goes on without a datagram, and ends without a socket", errors, NULL, NULL, NULL},
        {"Datagrams are frames: after 8 in succession the hosts behind EoE are served", datagrams_first, NULL, NULL,
         NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EtherCAT in UDP, the loop", tests, NULL, NULL);
}
