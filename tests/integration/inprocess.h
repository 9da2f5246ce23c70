/* SPDX-License-Identifier: MIT */
/* Frames, sockets and times for the programs that call the functions which `ectwin with --in-process` replaces. */
#ifndef TESTS_INPROCESS_H
#define TESTS_INPROCESS_H

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

/* CMocka needs the headers above. */
#include <cmocka.h>

enum { ETHERCAT = 0x88A4, MS = 1000000, FRAME = 60 };

static const char *interface;
static bool is_virtual;

/* A frame with one datagram BRD 0000h, two bytes. */
static inline void frame_of(uint8_t frame[FRAME], uint8_t index)
{
    static const uint8_t head[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 2, 0, 0, 0, 0, 1, 0x88, 0xA4, 0x0E, 0x10, 0x07};
    memset(frame, 0, FRAME);
    memcpy(frame, head, sizeof head);
    frame[17] = index;
    frame[22] = 2;
}

/* The working counter of its reply: one for each twin. */
static inline unsigned int counter_of(const uint8_t *frame)
{
    return frame[28];
}

static inline int open_socket(int type)
{
    struct sockaddr_ll to = {.sll_family = AF_PACKET, .sll_protocol = htons(ETHERCAT)};
    int fd = socket(AF_PACKET, SOCK_RAW | type, htons(ETHERCAT));
    assert_true(fd >= 0);
    to.sll_ifindex = (int)if_nametoindex(interface);
    assert_int_equal(bind(fd, (struct sockaddr *)&to, sizeof to), 0);
    return fd;
}

static inline void send_one(int fd, uint8_t index)
{
    uint8_t frame[FRAME];
    frame_of(frame, index);
    assert_int_equal(send(fd, frame, sizeof frame, 0), FRAME);
}

static inline void assert_reply(const uint8_t *frame, ssize_t length, uint8_t index)
{
    assert_int_equal(length, FRAME);
    assert_int_equal(frame[17], index);
    assert_int_equal(counter_of(frame), 2);
}

static inline uint64_t now_ns(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec;
}

/* On the virtual clock a wait takes the requested time and the stated cost of the calls; a real one may take longer. */
static inline void assert_took(uint64_t since_ns, uint64_t asked_ns)
{
    uint64_t took_ns = now_ns() - since_ns;
    assert_true(took_ns >= asked_ns);
    if (is_virtual && took_ns >= asked_ns + MS / 10)
        fail_msg("took %llu ns, asked for %llu", (unsigned long long)took_ns, (unsigned long long)asked_ns);
}

/* The arguments of such a program: the interface, the clock, a case. @return false: reported */
static inline bool is_started(int argc, char **argv)
{
    if (argc < 3) {
        print_error("usage: %s INTERFACE real|virtual [CASE]\n", argv[0]);
        return false;
    }
    interface = argv[1];
    is_virtual = strcmp(argv[2], "virtual") == 0;
    if (argc > 3)
        cmocka_set_test_filter(argv[3]);
    return true;
}

#endif
