/* SPDX-License-Identifier: MIT */
/* EtherCAT in UDP (bus/net/udp.h) and addresses that users type (bus/net/address.h). The sockets are the test's. */
#define _GNU_SOURCE
#include "bus/net/udp.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "calls.h"
#include "wire/bytes.h"

enum { ROOM = ECT_UDP_HEADERS + ECT_UDP_MOST, FRAME = ROOM + 600, SENDER = 0x0A090807, SENDER_PORT = 50123 };

static struct kernel {
    uint8_t payload[2000]; /* of the datagram that is there */
    ssize_t length;        /* -1: none, errno is `error` */
    int error;
    bool stale;
    uint32_t sender; /* its address; 0: SENDER and SENDER_PORT */
    uint16_t sender_port;
} kernel;

/* --- calls -------------------------------------------------------------------------------------------------------- */

int __wrap_socket(int family, int type, int protocol);
int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size);
int __wrap_getsockname(int fd, struct sockaddr *address, socklen_t *size);
int __real_close(int fd);
int __wrap_close(int fd);
ssize_t __wrap_recvfrom(int fd, void *data, size_t size, int flags, struct sockaddr *from, socklen_t *from_size);
ssize_t __wrap_sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *to, socklen_t to_size);
bool __wrap_ect_packet_arrived(int fd, uint64_t *came_ns, ect_packet_time_t *time);

int __wrap_socket(int family, int type, int protocol)
{
    note("socket %d %d %d\n", family == AF_INET, type == (SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK), protocol);
    return fails("socket") ? -1 : fake_open("socket");
}

static void note_address(const char *call, const struct sockaddr *address)
{
    const struct sockaddr_in *in = (const struct sockaddr_in *)(const void *)address;
    assert_int_equal(in->sin_family, AF_INET);
    note("%s %08x:%u\n", call, ntohl(in->sin_addr.s_addr), ntohs(in->sin_port));
}

int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size)
{
    assert_true(is_fake(fd) && size == sizeof(struct sockaddr_in));
    note_address("bind", address);
    return fails("bind") ? -1 : 0;
}

int __wrap_getsockname(int fd, struct sockaddr *address, socklen_t *size)
{
    const struct sockaddr_in in = {
        .sin_family = AF_INET, .sin_port = htons(40000), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    assert_true(is_fake(fd) && *size >= sizeof in);
    memcpy(address, &in, sizeof in);
    *size = sizeof in;
    return fails("getsockname") ? -1 : 0;
}

int __wrap_close(int fd)
{
    if (!is_fake(fd))
        return __real_close(fd);
    fake_close(fd);
    return 0;
}

ssize_t __wrap_recvfrom(int fd, void *data, size_t size, int flags, struct sockaddr *from, socklen_t *from_size)
{
    const struct sockaddr_in in = {.sin_family = AF_INET,
                                   .sin_port = htons(kernel.sender != 0 ? kernel.sender_port : SENDER_PORT),
                                   .sin_addr.s_addr = htonl(kernel.sender != 0 ? kernel.sender : SENDER)};
    assert_true(is_fake(fd));
    assert_int_equal(flags, MSG_DONTWAIT | MSG_TRUNC);
    if (kernel.length < 0) {
        errno = kernel.error;
        return -1;
    }
    memcpy(data, kernel.payload, size < (size_t)kernel.length ? size : (size_t)kernel.length);
    assert_true(*from_size >= sizeof in);
    memcpy(from, &in, sizeof in);
    *from_size = sizeof in;
    return kernel.length;
}

ssize_t __wrap_sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *to, socklen_t to_size)
{
    assert_true(is_fake(fd) && to_size == sizeof(struct sockaddr_in));
    assert_int_equal(flags, MSG_DONTWAIT);
    note_address("sendto", to);
    note("%zu bytes, %s\n", size, memcmp(data, kernel.payload, size) == 0 ? "as received" : "others");
    return (ssize_t)size;
}

bool __wrap_ect_packet_arrived(int fd, uint64_t *came_ns, ect_packet_time_t *time)
{
    assert_true(is_fake(fd));
    *time = (ect_packet_time_t){.now_ns = 77, .waited_ns = came_ns ? 3 : 0};
    return kernel.stale;
}

/* --- addresses ---------------------------------------------------------------------------------------------------- */

static void addresses(void **state)
{
    static const struct {
        const char *text, *want; /* NULL: refused */
    } rows[] = {{"34980", "127.0.0.1:34980"},
                {"0", "127.0.0.1:0"},
                {"0.0.0.0:34980", "0.0.0.0:34980"},
                {"10.9.8.7:0x88A4", NULL},
                {"[::1]:5", "[::1]:5"},
                {"", NULL},
                {"port", NULL},
                {"10.9.8.7", NULL},
                {"10.9.8.7:", NULL},
                {"10.9.8.7:65536", NULL},
                {"10.9.8.256:1", NULL},
                {"::1:5", NULL},
                {"localhost:5", NULL}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_address_t address;
        char host[INET6_ADDRSTRLEN] = "", text[ECT_ADDRESS_TEXT] = "";
        if (ect_address_parse(&address, rows[i].text)) {
            const struct sockaddr_in *in = (const struct sockaddr_in *)&address.at;
            const struct sockaddr_in6 *in6 = (const struct sockaddr_in6 *)&address.at;
            bool six = address.at.ss_family == AF_INET6;
            (void)inet_ntop(address.at.ss_family, six ? (const void *)&in6->sin6_addr : &in->sin_addr, host,
                            sizeof host);
            snprintf(text, sizeof text, six ? "[%s]:%u" : "%s:%u", host, ntohs(six ? in6->sin6_port : in->sin_port));
        }
        if (strcmp(text, rows[i].want ? rows[i].want : "") != 0)
            fail_msg("'%s': expected '%s', got '%s'", rows[i].text, rows[i].want ? rows[i].want : "", text);
    }
}

/* --- opening ------------------------------------------------------------------------------------------------------ */

static void opens(void **state)
{
    static const char wrong[] = "a numeric IPv4 address, the port from 0 to 65535, as in 127.0.0.1:34980";
    static const struct {
        const char *where;
        failing_t failing;
        const char *message; /* part of it; NULL: it opens */
        int error;
    } rows[] = {
        {"10.9.8.7:34980", {0}, NULL, 0},
        {"[::1]:34980", {0}, wrong, EINVAL},
        {"here", {0}, wrong, EINVAL},
        {"34980", {"socket", FIRST, EMFILE}, "cannot receive at '34980': Too many open files", EMFILE},
        {"34980", {"bind", FIRST, EADDRINUSE}, "cannot receive at '34980': the port is in use", EADDRINUSE},
        {"80", {"bind", FIRST, EACCES}, "needs CAP_NET_BIND_SERVICE", EACCES},
        {"34980", {"bind", FIRST, EADDRNOTAVAIL}, "this machine does not have the address", EADDRNOTAVAIL},
        {"34980", {"bind", FIRST, ENOMEM}, "Cannot allocate memory", ENOMEM},
    };
    (void)state;
    for (size_t n = 0; n < 2 * (sizeof rows / sizeof rows[0]); n++) {
        const size_t i = n / 2;
        char message[ECT_PACKET_MESSAGE] = "";
        ect_udp_t port;
        begin_calls(rows[i].failing);
        calls.zero_at = n % 2;
        errno = 0;
        int result = ect_udp_open(&port, rows[i].where, message);
        if (result != (rows[i].message ? -1 : 0) || (rows[i].message && !strstr(message, rows[i].message)))
            fail_msg("%s: %d, '%s'", rows[i].where, result, message);
        if (rows[i].message) {
            assert_int_equal(errno, rows[i].error);
            assert_int_equal(calls.open, 0);
            continue;
        }
        EXPECT_LOG(rows[i].where, "socket 1 1 0\nbind 0a090807:34980\n");
        assert_string_equal(port.address, "127.0.0.1:40000");
        ect_udp_close(&port);
        ect_udp_close(&port); /* again: no effect */
        assert_int_equal(calls.open, 0);
    }
}

static void unknown_address(void **state)
{
    const failing_t failing = {"getsockname", FIRST, ENOTSOCK};
    char text[ECT_ADDRESS_TEXT] = "before";
    (void)state;
    begin_calls(failing);
    ect_address_print(fake_open("socket"), text);
    assert_string_equal(text, "");
}

/* --- datagrams ---------------------------------------------------------------------------------------------------- */

static void open_port(ect_udp_t *port)
{
    char message[ECT_PACKET_MESSAGE];
    memset(&kernel, 0, sizeof kernel);
    begin_calls((failing_t){0});
    assert_int_equal(ect_udp_open(port, "34980", message), 0);
    memset(calls.log, 0, sizeof calls.log);
    calls.used = 0;
}

/* A datagram with the length `bytes` in its EtherCAT header. */
static void put_datagram(ssize_t length, uint16_t bytes)
{
    for (size_t i = 0; i < sizeof kernel.payload; i++)
        kernel.payload[i] = (uint8_t)(i * 7);
    ect_store_le16(kernel.payload, (uint16_t)(0x1000 | bytes));
    kernel.length = length;
}

static void lengths(void **state)
{
    static const struct {
        ssize_t length;
        uint16_t bytes;
        bool stale;
        ssize_t want;
    } rows[] = {
        {14, 12, false, ECT_UDP_HEADERS + 14},
        {46, 12, false, ECT_UDP_HEADERS + 46}, /* padded */
        {1472, 1470, false, ROOM},
        {1472, 1470, true, ECT_PACKET_STALE},
        {0, 12, false, ECT_UDP_REFUSED},
        {1, 0, false, ECT_UDP_REFUSED},
        {13, 11, false, ECT_UDP_REFUSED},
        {14, 13, false, ECT_UDP_REFUSED},
        {14, 0x7FF, false, ECT_UDP_REFUSED},
        {1473, 12, false, ECT_UDP_REFUSED},
        {65507, 12, true, ECT_UDP_REFUSED},
    };
    ect_udp_t port;
    (void)state;
    open_port(&port);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static uint8_t frame[FRAME];
        ect_packet_time_t time = {0};
        put_datagram(rows[i].length, rows[i].bytes);
        kernel.stale = rows[i].stale;
        memset(frame, 0xA5, sizeof frame);
        ssize_t got = ect_udp_receive(&port, frame, &time);
        if (got != rows[i].want)
            fail_msg("%zd bytes, %u in the header: expected %zd, got %zd", rows[i].length, rows[i].bytes, rows[i].want,
                     got);
        assert_int_equal(time.now_ns, rows[i].want == ECT_UDP_REFUSED ? 0 : 77);
        for (size_t k = ROOM; k < FRAME; k++)
            assert_int_equal(frame[k], 0xA5);
    }
    ect_udp_close(&port);
}

static void failures(void **state)
{
    static const struct {
        int error;
        ssize_t want;
    } rows[] = {{EAGAIN, ECT_PACKET_NONE}, {EINTR, ECT_PACKET_NONE}, {ENOTCONN, ECT_PACKET_GONE}};
    uint8_t frame[FRAME];
    ect_packet_time_t time;
    ect_udp_t port;
    (void)state;
    open_port(&port);
    kernel.length = -1;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        kernel.error = rows[i].error;
        assert_int_equal(ect_udp_receive(&port, frame, &time), rows[i].want);
    }
    ect_udp_close(&port);
}

/* The headers in their fields, checked by a sum of this test's own. */
static void headers(void **state)
{
    static const uint8_t want[ECT_UDP_HEADERS] = {
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0,  0,  0, 0, 0x08, 0x00, /* Ethernet */
        0x45, 0,    0,    60,   0xC3, 0xCB, 0,    0, 64, 17, 0, 0,             /* IPv4, without its sum */
        10,   9,    8,    7,    0,    0,    0,    0,                           /* from, to */
        0xC3, 0xCB, 0x88, 0xA4, 0,    40,   0,    0};                          /* UDP */
    uint8_t frame[FRAME];
    ect_packet_time_t time;
    ect_udp_t port;
    uint32_t sum = 0;
    (void)state;
    open_port(&port);
    put_datagram(32, 30);
    assert_int_equal(ect_udp_receive(&port, frame, &time), ECT_UDP_HEADERS + 32);
    for (unsigned int i = 14; i < 34; i += 2)
        sum += ect_load_be16(frame + i);
    assert_int_equal(sum % 0xFFFF, 0);
    assert_int_not_equal(sum, 0);
    ect_store_be16(frame + 24, 0);
    assert_memory_equal(frame, want, sizeof want);
    assert_memory_equal(frame + ECT_UDP_HEADERS, kernel.payload, 32);
    ect_udp_close(&port);
}

/* The sum before its carries is 2475Dh and the port: with ports B8A1h and B8A2h the first carry causes a second one. */
static void carries_of_the_sum(void **state)
{
    static const uint16_t ports[] = {0, 0xB8A0, 0xB8A1, 0xB8A2, 0xB8A3, 0xFFFF};
    ect_udp_t port;
    (void)state;
    open_port(&port);
    put_datagram(32, 30);
    kernel.sender = 0xFA09C807;
    for (size_t i = 0; i < sizeof ports / sizeof ports[0]; i++) {
        uint8_t frame[FRAME];
        ect_packet_time_t time;
        uint32_t sum = 0;
        kernel.sender_port = ports[i];
        const size_t length = (size_t)ect_udp_receive(&port, frame, &time);
        for (unsigned int at = 14; at < 34; at += 2)
            sum += ect_load_be16(frame + at);
        assert_int_equal(sum % 0xFFFF, 0);
        ect_udp_send(&port, frame, length);
    }
    EXPECT_LOG("replies", "sendto fa09c807:0\n32 bytes, as received\n"
                          "sendto fa09c807:47264\n32 bytes, as received\n"
                          "sendto fa09c807:47265\n32 bytes, as received\n"
                          "sendto fa09c807:47266\n32 bytes, as received\n"
                          "sendto fa09c807:47267\n32 bytes, as received\n"
                          "sendto fa09c807:65535\n32 bytes, as received\n");
    kernel.sender = 0;
    ect_udp_close(&port);
}

static void replies(void **state)
{
    uint8_t frame[FRAME];
    ect_packet_time_t time;
    ect_udp_t port;
    (void)state;
    open_port(&port);
    put_datagram(32, 30);
    size_t length = (size_t)ect_udp_receive(&port, frame, &time);
    assert_true(ect_udp_carries(frame, length));
    ect_udp_send(&port, frame, length);
    ect_udp_send(&port, frame, length - 20); /* cut by a fault */
    EXPECT_LOG("replies", "sendto 0a090807:50123\n32 bytes, as received\n"
                          "sendto 0a090807:50123\n12 bytes, as received\n");
    assert_false(ect_udp_carries(frame, ECT_UDP_HEADERS));
    ect_store_be16(frame + 12, 0x88A4);
    assert_false(ect_udp_carries(frame, length));
    ect_udp_close(&port);
}

/* Each bit of the way back. */
static void damaged(void **state)
{
    uint8_t frame[FRAME];
    ect_packet_time_t time;
    ect_udp_t port;
    (void)state;
    open_port(&port);
    put_datagram(32, 30);
    size_t length = (size_t)ect_udp_receive(&port, frame, &time);
    for (size_t bit = 0; bit < 8 * (size_t)22; bit++) { /* the IPv4 header, and the sender's port */
        frame[14 + bit / 8] ^= (uint8_t)(1u << bit % 8);
        ect_udp_send(&port, frame, length);
        frame[14 + bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    EXPECT_LOG("damaged headers", "");
    ect_udp_send(&port, frame, length);
    EXPECT_LOG("an intact one", "sendto 0a090807:50123\n32 bytes, as received\n");
    ect_udp_close(&port);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Addresses that users type: [ADDRESS:]PORT", addresses, NULL, NULL, NULL},
        {"The port opens at its address; each failure has a reason and a cure", opens, NULL, NULL, NULL},
        {"A socket without a name has an empty address", unknown_address, NULL, NULL, NULL},
        {"Attack: datagrams of bad length, or shorter than their header defines, are refused", lengths, NULL, NULL,
         NULL},
        {"No datagram is no failure", failures, NULL, NULL, NULL},
        {"A datagram becomes the frame that would carry it", headers, NULL, NULL, NULL},
        {"The check sum of the IPv4 header is right with each carry, and the reply returns", carries_of_the_sum, NULL,
         NULL, NULL},
        {"A reply goes to the sender of its datagram", replies, NULL, NULL, NULL},
        {"Attack: a frame whose way back was damaged is lost", damaged, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EtherCAT in UDP", tests, NULL, NULL);
}
