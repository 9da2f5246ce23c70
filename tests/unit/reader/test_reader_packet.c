/* SPDX-License-Identifier: MIT */
/* The wire of a reader through a network interface (reader/packet.h): a frame, a timeout, an interface that is gone.
 * Time and frames are the test's. */
#define _GNU_SOURCE
#include "reader/packet.h"

#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

enum { UNTIL = 2000 /* ms */, FD = 77 };
#define S_NS UINT64_C(1000000000)

static struct {
    uint64_t now_ns, wakes_ns; /* the time, and when the next wait ends */
    const ssize_t *results;    /* of ect_packet_receive() */
    unsigned int receives, waits;
    size_t sent;
} net;

uint64_t __wrap_ect_packet_now(void);
ssize_t __wrap_ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time);
void __wrap_ect_packet_send(const ect_packet_t *port, const uint8_t *frame, size_t length);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask);
int __wrap_clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left);

uint64_t __wrap_ect_packet_now(void)
{
    return net.now_ns;
}

ssize_t __wrap_ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time)
{
    assert_int_equal(port->fd, FD);
    assert_false(wait);
    assert_non_null(time);
    const ssize_t result = net.results[net.receives++];
    if (result > 0)
        memset(frame, 0x5A, room);
    return result;
}

void __wrap_ect_packet_send(const ect_packet_t *port, const uint8_t *frame, size_t length)
{
    assert_int_equal(port->fd, FD);
    assert_int_equal(frame[0], 0xA5);
    net.sent += length;
}

int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *limit, const sigset_t *mask)
{
    assert_int_equal(count, 1);
    assert_int_equal(fds->fd, FD);
    assert_int_equal(fds->events, POLLIN);
    assert_null(mask);
    const uint64_t end_ns = net.now_ns + (uint64_t)limit->tv_sec * S_NS + (uint64_t)limit->tv_nsec;
    assert_int_equal(end_ns, UNTIL * S_NS / 1000);
    net.waits++;
    net.now_ns = net.wakes_ns < end_ns ? net.wakes_ns : end_ns;
    return net.wakes_ns < end_ns;
}

int __wrap_clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left)
{
    const uint64_t end_ns = (uint64_t)until->tv_sec * S_NS + (uint64_t)until->tv_nsec;
    assert_int_equal(clock, CLOCK_MONOTONIC);
    assert_int_equal(flags, TIMER_ABSTIME);
    assert_null(left);
    net.waits++;
    const bool interrupted = net.wakes_ns < end_ns;
    net.now_ns = interrupted ? net.wakes_ns : end_ns;
    net.wakes_ns = UINT64_MAX;
    return interrupted ? EINTR : 0;
}

/* Waits end 2 s after the start of the clock, or with a frame after 1.5 s. */
static void receives(void **state)
{
    enum { AT_1 = 1000, AT_1_5 = 1500, NEVER = 9999 };
    static const struct {
        const char *title;
        unsigned int now_ms, wakes_ms;
        ssize_t results[3];
        size_t length;
        unsigned int receives, waits, then_ms;
    } rows[] = {
        {"a queued frame", AT_1, NEVER, {60}, 60, 1, 0, AT_1},
        {"a frame of one byte", AT_1, NEVER, {1}, 1, 1, 0, AT_1},
        {"a frame that comes", AT_1, AT_1_5, {ECT_PACKET_NONE, 60}, 60, 2, 1, AT_1_5},
        {"one that is discarded, then a frame", AT_1, AT_1_5, {ECT_PACKET_STALE, 60}, 60, 2, 1, AT_1_5},
        {"none until the timeout", AT_1, NEVER, {ECT_PACKET_NONE, ECT_PACKET_NONE}, 0, 2, 1, UNTIL},
        {"a frame with the timeout", AT_1, NEVER, {ECT_PACKET_NONE, 60}, 60, 2, 1, UNTIL},
        {"a frame while the process was held up", UNTIL + 1, NEVER, {60}, 60, 1, 0, UNTIL + 1},
        {"none while the process was held up", UNTIL + 1, NEVER, {ECT_PACKET_NONE}, 0, 1, 0, UNTIL + 1},
        {"an interface that is gone", AT_1, NEVER, {ECT_PACKET_GONE}, 0, 1, 0, AT_1},
    };
    ect_packet_t port = {.fd = FD};
    const ect_reader_link_t link = ect_reader_packet_link(&port);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[64] = {0};
        memset(&net, 0, sizeof net);
        net.now_ns = rows[i].now_ms * S_NS / 1000;
        net.wakes_ns = rows[i].wakes_ms * S_NS / 1000;
        net.results = rows[i].results;
        const size_t length = link.receive(link.ctx, frame, sizeof frame, UNTIL * S_NS / 1000);
        if (length != rows[i].length || net.receives != rows[i].receives || net.waits != rows[i].waits ||
            link.now(link.ctx) != rows[i].then_ms * S_NS / 1000)
            fail_msg("%s: %zu bytes after %u calls and %u waits, at %" PRIu64 " ns", rows[i].title, length,
                     net.receives, net.waits, net.now_ns);
        assert_int_equal(frame[0], rows[i].length > 0 ? 0x5A : 0);
    }
}

static void waits_to_the_end(void **state)
{
    static const struct {
        const char *title;
        uint64_t wakes_ns;
        unsigned int waits;
    } rows[] = {{"without a signal", UINT64_MAX, 1}, {"over a signal", 4 * S_NS, 2}};
    ect_packet_t port = {.fd = FD};
    const ect_reader_link_t link = ect_reader_packet_link(&port);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        memset(&net, 0, sizeof net);
        net.now_ns = 3 * S_NS;
        net.wakes_ns = rows[i].wakes_ns;
        link.wait(link.ctx, 5 * S_NS + 7);
        if (net.now_ns != 5 * S_NS + 7 || net.waits != rows[i].waits)
            fail_msg("%s: until %" PRIu64 " ns in %u waits", rows[i].title, net.now_ns, net.waits);
    }
}

static void sends(void **state)
{
    ect_packet_t port = {.fd = FD};
    const ect_reader_link_t link = ect_reader_packet_link(&port);
    (void)state;
    memset(&net, 0, sizeof net);
    link.send(link.ctx, (const uint8_t[60]){0xA5}, 60);
    assert_int_equal(net.sent, 60);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a frame is received until the timeout; once more after a wait, and never from an interface that is gone",
         receives, NULL, NULL, NULL},
        {"a wait lasts until its time, whatever interrupts it", waits_to_the_end, NULL, NULL, NULL},
        {"a frame is sent once, whole", sends, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Wire of a reader", tests, NULL, NULL);
}
