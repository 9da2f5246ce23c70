/* SPDX-License-Identifier: MIT */
/* Garbage on the wire: the twin neither replies nor fails.  usage: test_garbage IFACE [TEST] */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "soem.h"

static const char *iface;
static int fd;

static const uint8 header[14] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4};

static int open_socket(void **state)
{
    (void)state;
    struct timeval wait = {.tv_usec = 100000};
    struct sockaddr_ll address = {
        .sll_family = AF_PACKET, .sll_protocol = htons(0x88A4), .sll_ifindex = (int)if_nametoindex(iface)};
    fd = socket(AF_PACKET, SOCK_RAW, htons(0x88A4));
    assert_true(fd >= 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait), 0);
    return 0;
}

static int close_socket(void **state)
{
    (void)state;
    return close(fd);
}

/* Sends a frame and waits for what comes back; @return its length, -1 nothing */
static ssize_t exchange(const uint8 *frame, size_t length, uint8 *reply)
{
    struct sockaddr_ll from;
    socklen_t size = sizeof from;
    assert_int_equal(send(fd, frame, length, 0), (ssize_t)length);
    for (;;) {
        ssize_t got = recvfrom(fd, reply, 2048, 0, (struct sockaddr *)&from, &size);
        if (got < 0 || from.sll_pkttype != PACKET_OUTGOING)
            return got;
    }
}

static size_t build(uint8 *frame, uint16 length)
{
    memset(frame, 0, 2048);
    memcpy(frame, header, sizeof header);
    frame[14] = (uint8)(length + 12);
    frame[15] = (uint8)(0x10 | ((length + 12) >> 8));
    frame[16] = 7; /* BRD of 0x0000 */
    frame[22] = (uint8)length;
    frame[23] = (uint8)(length >> 8);
    return 16u + 10u + length + 2u;
}

static void shortest_frame(void **state)
{
    (void)state;
    uint8 frame[2048], reply[2048];
    size_t length = build(frame, 1);
    assert_int_equal(length, 29);
    assert_int_equal(exchange(frame, length, reply), 29);
    assert_int_equal(reply[27], 1); /* working counter */
    assert_int_equal(reply[6], frame[6] | 0x02);
}

static void longest_frame(void **state)
{
    (void)state;
    uint8 frame[2048], reply[2048];
    size_t length = build(frame, 1486);
    assert_int_equal(length, 1514);
    assert_int_equal(exchange(frame, length, reply), 1514);
    assert_int_equal(reply[1512], 1);
}

static void no_answer(const uint8 *frame, size_t length)
{
    uint8 reply[2048];
    ssize_t got = exchange(frame, length, reply);
    if (got >= 0)
        fail_msg("a frame of %zu bytes was answered with %zd bytes", length, got);
}

static void false_lengths(void **state)
{
    (void)state;
    uint8 frame[2048];
    size_t length = build(frame, 4);
    no_answer(frame, 16); /* nothing after the EtherCAT header */
    no_answer(frame, 20);
    no_answer(frame, length - 1);
    frame[22] = 0xFF; /* datagram longer than the frame */
    frame[23] = 0x07;
    no_answer(frame, length);
    build(frame, 4);
    frame[23] |= 0x80; /* "more", and nothing follows */
    no_answer(frame, length);
}

static void random_garbage(void **state)
{
    (void)state;
    uint8 frame[2048];
    srand(1);
    for (int i = 0; i < 5000; i++) {
        size_t length = 14u + (size_t)rand() % 1500u;
        for (size_t b = 0; b < length; b++)
            frame[b] = (uint8)rand();
        memcpy(frame, header, sizeof header);
        assert_int_equal(send(fd, frame, length, 0), (ssize_t)length);
    }
    /* Whatever came back is of no interest; the twin must be as good as new for the next master. */
    static soem_t master;
    soem_open(&master, iface, 1);
    soem_map(&master);
    soem_operational(&master);
    soem_close(&master);
}

int main(int argc, char **argv)
{
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    const struct CMUnitTest tests[] = {
        {"CF-013: the reply to a frame of 29 bytes has 29 bytes, source MAC bit set", shortest_frame, open_socket,
         close_socket, NULL},
        {"CF-013: the reply to a frame of 1514 bytes has 1514 bytes", longest_frame, open_socket, close_socket, NULL},
        {"CF-013: truncated frames and false lengths get no reply", false_lengths, open_socket, close_socket, NULL},
        {"CF-094: 5000 frames of garbage, then an ordinary start", random_garbage, open_socket, close_socket, NULL},
    };
    return cmocka_run_group_tests_name("garbage", tests, NULL, NULL);
}
