/* SPDX-License-Identifier: MIT */
/* The Modbus TCP server (bus/modbus/modbus.h): its replies byte for byte, and the limits of the work of one call.
 * Clients connect by a local socket, and the test sets the time. */
#define _GNU_SOURCE
#include "bus/modbus/modbus.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "bus/modbus/modbus_request.h"
#include "devices/eclink/eclink.h"
#include "support/every.h"
#include "support/hex.h"
#include "support/wire.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { ROOM = 65536, MOST_CALLS = 100000, IDLE_S = 60 };

/* The system calls of one ect_modbus_server_serve(), counted by functions that the linker inserts. */
static struct {
    unsigned int receives, accepts, waits, polls;
    int accept_error; /* of the next calls of accept4(); 0: none */
} work;

ssize_t __real_recv(int fd, void *buffer, size_t size, int flags);
ssize_t __wrap_recv(int fd, void *buffer, size_t size, int flags);
int __real_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags);
int __wrap_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
int __real_epoll_wait(int fd, struct epoll_event *events, int room, int timeout);
int __wrap_epoll_wait(int fd, struct epoll_event *events, int room, int timeout);
int __real_poll(struct pollfd *fds, nfds_t count, int timeout);
int __wrap_poll(struct pollfd *fds, nfds_t count, int timeout);

ssize_t __wrap_recv(int fd, void *buffer, size_t size, int flags)
{
    work.receives++;
    return __real_recv(fd, buffer, size, flags);
}

static bool refuses_memory;
static unsigned int memory_fails_at, allocations; /* number of the allocation that fails, from 1; 0: none */
static bool forms_no_reply;                       /* modbus_reply() fails */

int __real_modbus_reply(void *replies, const uint8_t *request, int length, void *mapping);
int __wrap_modbus_reply(void *replies, const uint8_t *request, int length, void *mapping);

int __wrap_modbus_reply(void *replies, const uint8_t *request, int length, void *mapping)
{
    return forms_no_reply ? -1 : __real_modbus_reply(replies, request, length, mapping);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return refuses_memory || ++allocations == memory_fails_at ? NULL : __real_calloc(count, size);
}

int __real_close(int fd);
int __wrap_close(int fd);

/* An error must be stored before this call, which changes errno. */
int __wrap_close(int fd)
{
    const int result = __real_close(fd);
    errno = EBADF;
    return result;
}

int __wrap_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags)
{
    work.accepts++;
    if (work.accept_error == 0)
        return __real_accept4(fd, address, size, flags);
    errno = work.accept_error;
    return -1;
}

int __wrap_epoll_wait(int fd, struct epoll_event *events, int room, int timeout)
{
    work.waits++;
    assert_int_equal(timeout, 0);
    return __real_epoll_wait(fd, events, room, timeout);
}

int __wrap_poll(struct pollfd *fds, nfds_t count, int timeout)
{
    work.polls++;
    return __real_poll(fds, count, timeout);
}

/* Replaces the C library's function, because libmodbus sleeps after an invalid request. */
int nanosleep(const struct timespec *wanted, struct timespec *left)
{
    (void)wanted;
    (void)left;
    fail_msg("the loop was put to sleep");
    return 0;
}

/* --- a base unit and its server ----------------------------------------------------------------------------------- */

typedef struct bench {
    wire_t wire;
    ect_modbus_server_t *server;
    struct sockaddr_un at;
    socklen_t at_size;
} bench_t;

static void open_bench(bench_t *b)
{
    char message[ECT_MODBUS_MESSAGE];
    memset(b, 0, sizeof *b);
    memset(&work, 0, sizeof work);
    wire_open_one(&b->wire, &ect_eclink_map7);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);
    b->at.sun_family = AF_UNIX; /* no path: the kernel chooses a name */
    assert_int_equal(bind(fd, (struct sockaddr *)&b->at, sizeof b->at.sun_family), 0);
    assert_int_equal(listen(fd, 200), 0);
    b->at_size = sizeof b->at;
    assert_int_equal(getsockname(fd, (struct sockaddr *)&b->at, &b->at_size), 0);
    b->server = ect_modbus_server_at(fd, message);
    if (!b->server)
        fail_msg("%s", message);
}

static void close_bench(bench_t *b)
{
    ect_modbus_server_close(b->server);
    wire_close(&b->wire);
}

static bool wants_to_be_served(const bench_t *b)
{
    struct pollfd fd = {.fd = ect_modbus_server_fd(b->server), .events = POLLIN};
    return ect_modbus_server_due(b->server) <= b->wire.now_ns || __real_poll(&fd, 1, 0) > 0;
}

/* Calls the server once, and checks the limits of its work. */
static void serve_once(bench_t *b)
{
    int accept_error = work.accept_error;
    memset(&work, 0, sizeof work);
    work.accept_error = accept_error;
    ect_modbus_server_serve(b->server, b->wire.chain, b->wire.now_ns);
    wire_poll(&b->wire);
    assert_true(work.receives <= 2);
    assert_true(work.accepts <= 1);
    assert_true(work.polls <= 1);
    assert_int_equal(work.waits, 1);
}

/* Calls the server until no work is pending. @return the number of calls */
static unsigned int serve(bench_t *b)
{
    unsigned int calls = 0;
    while (wants_to_be_served(b)) {
        serve_once(b);
        if (++calls == MOST_CALLS)
            fail_msg("the server never comes to rest");
    }
    return calls;
}

static int connect_client(bench_t *b)
{
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_true(fd >= 0);
    assert_int_equal(connect(fd, (struct sockaddr *)&b->at, b->at_size), 0);
    assert_int_equal(fcntl(fd, F_SETFL, O_NONBLOCK), 0);
    return fd;
}

static void send_request(int fd, const char *hex)
{
    uint8_t bytes[ROOM / 16];
    size_t size = from_hex(hex, bytes);
    assert_int_equal(write(fd, bytes, size), (ssize_t)size);
}

/* @return the received bytes as text; "": none; "end": the connection has ended */
static const char *receive_reply(int fd)
{
    static char text[3 * ECT_MODBUS_ADU * 8];
    uint8_t bytes[ECT_MODBUS_ADU * 8];
    ssize_t got = __real_recv(fd, bytes, sizeof bytes, 0);
    text[0] = 0;
    if (got == 0 || (got < 0 && errno == ECONNRESET))
        return "end";
    for (ssize_t i = 0; i < got; i++)
        sprintf(text + 3 * i, "%02X ", bytes[i]);
    if (got > 0)
        text[3 * got - 1] = 0;
    return text;
}

static void expect(bench_t *b, int fd, const char *what, const char *request, const char *wanted)
{
    send_request(fd, request);
    (void)serve(b);
    const char *got = receive_reply(fd);
    if (strcmp(got, wanted) != 0)
        fail_msg("%s: sent %s\n  expected %s\n  got      %s", what, request, wanted, got);
}

/* --- replies ------------------------------------------------------------------------------------------------------ */

static void answers(void **state)
{
    static const struct {
        const char *what, *request, *answer;
    } rows[] = {
        {"two registers", "00 01 00 00 00 09 FF 10 00 0C 00 01 02 01 2C", "00 01 00 00 00 06 FF 10 00 0C 00 01"},
        {"are read", "00 02 00 00 00 06 FF 03 00 0B 00 02", "00 02 00 00 00 07 FF 03 04 00 00 01 2C"},
        {"one register", "00 03 00 00 00 06 FF 06 00 71 AB CD", "00 03 00 00 00 06 FF 06 00 71 AB CD"},
        {"the coils of this register", "00 04 00 00 00 06 FF 01 07 10 00 10", "00 04 00 00 00 05 FF 01 02 CD AB"},
        {"a coil", "00 05 00 00 00 06 FF 05 07 1F 00 00", "00 05 00 00 00 06 FF 05 07 1F 00 00"},
        {"ten coils", "00 06 00 00 00 09 FF 0F 07 10 00 0A 02 00 00", "00 06 00 00 00 06 FF 0F 07 10 00 0A"},
        {"eleven coils are read", "00 07 00 00 00 06 FF 01 07 0F 00 0B", "00 07 00 00 00 05 FF 01 02 00 00"},
        {"the register of these coils", "00 08 00 00 00 06 FF 03 00 71 00 01", "00 08 00 00 00 05 FF 03 02 28 00"},
        {"written before read", "00 09 00 00 00 0D FF 17 00 71 00 01 00 71 00 01 02 12 34",
         "00 09 00 00 00 05 FF 17 02 12 34"},
        {"written here, read there", "00 0A 00 00 00 0D FF 17 08 02 00 01 00 02 00 01 02 00 05",
         "00 0A 00 00 00 05 FF 17 02 00 00"},
        {"input registers", "00 0B 00 00 00 06 FF 04 00 0B 00 01", "00 0B 00 00 00 05 FF 04 02 03 00"},
        {"discrete inputs", "00 0C 00 00 00 06 FF 02 00 B8 00 02", "00 0C 00 00 00 04 FF 02 01 03"},
        {"no such function", "00 0D 00 00 00 02 FF 07", "00 0D 00 00 00 03 FF 87 01"},
        {"no such address", "00 0E 00 00 00 06 FF 03 00 72 00 01", "00 0E 00 00 00 03 FF 83 02"},
        {"one address too many", "00 0F 00 00 00 06 FF 04 00 20 00 02", "00 0F 00 00 00 03 FF 84 02"},
        {"input data cannot be written", "00 10 00 00 00 06 FF 06 08 00 00 01", "00 10 00 00 00 03 FF 86 02"},
        {"a coil is 0000 or FF00", "00 11 00 00 00 06 FF 05 00 00 00 01", "00 11 00 00 00 03 FF 85 03"},
        {"too many registers", "00 12 00 00 00 06 FF 03 00 00 00 7E", "00 12 00 00 00 03 FF 83 03"},
        {"read at no address, write at an address", "00 13 00 00 00 0D FF 17 00 72 00 01 00 71 00 01 02 FF FF",
         "00 13 00 00 00 03 FF 97 02"},
        {"nothing was written", "00 14 00 00 00 06 FF 03 00 71 00 01", "00 14 00 00 00 05 FF 03 02 12 34"},
        {"unit 0", "FF FE 00 00 00 06 00 03 00 0C 00 01", "FF FE 00 00 00 05 00 03 02 01 2C"},
        {"unit 1", "FF FF 00 00 00 06 01 03 00 0C 00 01", "FF FF 00 00 00 05 01 03 02 01 2C"},
        {"unit 247", "00 00 00 00 00 06 F7 03 00 0C 00 01", "00 00 00 00 00 05 F7 03 02 01 2C"},
    };
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b);
    for (size_t i = 0; i < COUNT(rows); i++)
        expect(&b, fd, rows[i].what, rows[i].request, rows[i].answer);
    close(fd);
    close_bench(&b);
}

static void requests(void **state)
{
    static const struct {
        const char *what, *pdu;
        ect_modbus_result_t result;
        ect_modbus_range_t write, read;
    } rows[] = {
        {"nothing", "", 1, {0}, {0}},
        {"read coils", "01 00 00 07 D0", 0, {0}, {ECT_MODBUS_COILS, 0, 2000}},
        {"2001 coils", "01 00 00 07 D1", 3, {0}, {0}},
        {"none", "01 00 00 00 00", 3, {0}, {0}},
        {"a byte is missing", "01 00 00 00", 3, {0}, {0}},
        {"a byte too many", "01 00 00 00 01 00", 3, {0}, {0}},
        {"read discrete inputs", "02 FF FF 00 01", 0, {0}, {ECT_MODBUS_DISCRETE_INPUTS, 65535, 1}},
        {"read holding registers", "03 08 00 00 7D", 0, {0}, {ECT_MODBUS_HOLDING_REGISTERS, 2048, 125}},
        {"126 registers", "03 08 00 00 7E", 3, {0}, {0}},
        {"65535 registers", "03 00 00 FF FF", 3, {0}, {0}},
        {"read input registers", "04 00 05 00 01", 0, {0}, {ECT_MODBUS_INPUT_REGISTERS, 5, 1}},
        {"no input registers", "04 00 05 00 00", 3, {0}, {0}},
        {"function alone", "04", 3, {0}, {0}},
        {"coil on", "05 01 02 FF 00", 0, {ECT_MODBUS_COILS, 0x102, 1}, {0}},
        {"coil off", "05 01 02 00 00", 0, {ECT_MODBUS_COILS, 0x102, 1}, {0}},
        {"coil half on", "05 01 02 FF 01", 3, {0}, {0}},
        {"coil too short", "05 01 02 FF", 3, {0}, {0}},
        {"one register", "06 01 02 FF 01", 0, {ECT_MODBUS_HOLDING_REGISTERS, 0x102, 1}, {0}},
        {"too long", "06 01 02 FF 01 00", 3, {0}, {0}},
        {"nine coils", "0F 00 13 00 09 02 FF 01", 0, {ECT_MODBUS_COILS, 0x13, 9}, {0}},
        {"nine coils in one byte", "0F 00 13 00 09 01 FF", 3, {0}, {0}},
        {"nine coils, one byte is missing", "0F 00 13 00 09 02 FF", 3, {0}, {0}},
        {"no coils", "0F 00 13 00 00 00", 3, {0}, {0}},
        {"1969 coils", "0F 00 13 07 B1 F7", 3, {0}, {0}},
        {"coils without data", "0F", 3, {0}, {0}},
        {"two registers", "10 00 01 00 02 04 00 0A 01 02", 0, {ECT_MODBUS_HOLDING_REGISTERS, 1, 2}, {0}},
        {"two registers in two bytes", "10 00 01 00 02 02 00 0A", 3, {0}, {0}},
        {"two registers, a byte too many", "10 00 01 00 02 04 00 0A 01 02 03", 3, {0}, {0}},
        {"124 registers", "10 00 01 00 7C F8", 3, {0}, {0}},
        {"write and read",
         "17 00 03 00 06 00 0E 00 01 02 00 FF",
         0,
         {ECT_MODBUS_HOLDING_REGISTERS, 14, 1},
         {ECT_MODBUS_HOLDING_REGISTERS, 3, 6}},
        {"write and read 126", "17 00 03 00 7E 00 0E 00 01 02 00 FF", 3, {0}, {0}},
        {"write none and read", "17 00 03 00 06 00 0E 00 00 00", 3, {0}, {0}},
        {"write 122 and read", "17 00 03 00 06 00 0E 00 7A F4", 3, {0}, {0}},
        {"write and read, cut", "17 00 03 00 06 00 0E 00 01", 3, {0}, {0}},
        {"read alone", "17 00 03 00 06", 3, {0}, {0}},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint8_t pdu[260];
        ect_modbus_request_t got;
        size_t size = from_hex(rows[i].pdu, pdu);
        ect_modbus_result_t result = ect_modbus_request(pdu, size, &got);
        if (result != rows[i].result)
            fail_msg("%s (%s): expected exception %d, got %d", rows[i].what, rows[i].pdu, (int)rows[i].result,
                     (int)result);
        if (result != ECT_MODBUS_DONE)
            continue;
        assert_memory_equal(&got.write, &rows[i].write, sizeof got.write);
        assert_memory_equal(&got.read, &rows[i].read, sizeof got.read);
    }
}

/* The longest write of each function, with all its bytes. */
static void longest_writes(void **state)
{
    static const struct {
        uint8_t head[10];
        size_t head_size, size;
        uint16_t count;
    } rows[] = {{{15, 0, 0, 0x07, 0xB0, 246}, 6, 246, 1968},
                {{16, 0, 0, 0, 123, 246}, 6, 246, 123},
                {{23, 0, 0, 0, 125, 0, 0, 0, 121, 242}, 10, 242, 121}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint8_t pdu[260] = {0};
        ect_modbus_request_t got;
        memcpy(pdu, rows[i].head, rows[i].head_size);
        assert_int_equal(ect_modbus_request(pdu, rows[i].head_size + rows[i].size, &got), ECT_MODBUS_DONE);
        assert_int_equal(got.write.count, rows[i].count);
    }
}

static void no_other_function(void **state)
{
    static const char known[] = {1, 2, 3, 4, 5, 6, 15, 16, 23};
    bench_t b;
    (void)state;
    open_bench(&b);
    int fd = connect_client(&b);
    for (unsigned int code = 0; code < 0x80; code++) {
        char request[64], answer[64];
        if (memchr(known, (int)code, sizeof known))
            continue;
        snprintf(request, sizeof request, "00 %02X 00 00 00 06 01 %02X 00 00 00 01", code, code);
        snprintf(answer, sizeof answer, "00 %02X 00 00 00 03 01 %02X 01", code, code | 0x80);
        expect(&b, fd, "an unsupported function", request, answer);
    }
    close(fd);
    close_bench(&b);
}

/* --- reception ---------------------------------------------------------------------------------------------------- */

#define WRITE  "00 01 00 00 00 0B FF 10 00 0C 00 02 04 01 2C 00 07"
#define WRITES 17 /* bytes */
#define DONE   "00 01 00 00 00 06 FF 10 00 0C 00 02"
#define READ   "12 34 00 00 00 06 01 04 00 0B 00 01"
#define VALUE  "12 34 00 00 00 05 01 04 02 03 00"

static void in_two_pieces(void **state)
{
    uint8_t request[64];
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b), other = connect_client(&b);
    size_t size = from_hex(WRITE, request);
    for (size_t cut = 1; cut < size; cut++) {
        assert_int_equal(write(fd, request, cut), (ssize_t)cut);
        (void)serve(&b);
        assert_string_equal(receive_reply(fd), "");
        expect(&b, other, "another client meanwhile", READ, VALUE);
        assert_int_equal(write(fd, request + cut, size - cut), (ssize_t)(size - cut));
        (void)serve(&b);
        const char *got = receive_reply(fd);
        if (strcmp(got, DONE) != 0)
            fail_msg("cut after %zu bytes: expected %s, got %s", cut, DONE, got);
    }
    for (size_t i = 0; i < size; i++) {
        assert_int_equal(write(fd, request + i, 1), 1);
        assert_true(serve(&b) <= 2);
    }
    assert_string_equal(receive_reply(fd), DONE);
    close(fd);
    close(other);
    close_bench(&b);
}

/* Several pending requests: each call replies to one request, in their order. */
static void many_at_once(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b);
    int fd = connect_client(&b);
    (void)serve(&b);
    for (unsigned int i = 0; i < 5; i++) {
        char request[64];
        snprintf(request, sizeof request, "00 %02X 00 00 00 06 FF 06 00 71 00 %02X", i, i);
        send_request(fd, request);
    }
    for (unsigned int i = 0; i < 5; i++) {
        char answer[64];
        snprintf(answer, sizeof answer, "00 %02X 00 00 00 06 FF 06 00 71 00 %02X", i, i);
        serve_once(&b);
        assert_string_equal(receive_reply(fd), answer);
    }
    assert_false(wants_to_be_served(&b));
    close(fd);
    close_bench(&b);
}

static void no_modbus(void **state)
{
    static const struct {
        const char *what, *bytes;
    } rows[] = {
        {"another protocol", "00 01 00 01 00 06 FF 03 00 00 00 01"},
        {"length 0", "00 01 00 00 00 00"},
        {"length 1: no function", "00 01 00 00 00 01 FF"},
        {"longer than a request can be", "00 01 00 00 00 FF FF 03 00 00 00 01"},
        {"length 65535", "00 01 00 00 FF FF"},
        {"the function code of an exception", "00 01 00 00 00 06 FF 83 00 00 00 01"},
        {"HTTP", "47 45 54 20 2F 20 48 54 54 50 2F 31 2E 31 0D 0A 0D 0A"},
    };
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int other = connect_client(&b);
    for (size_t i = 0; i < COUNT(rows); i++) {
        int fd = connect_client(&b);
        expect(&b, fd, rows[i].what, rows[i].bytes, "end");
        expect(&b, other, "another client continues", READ, VALUE);
        close(fd);
    }
    close(other);
    close_bench(&b);
}

static void longest_request(void **state)
{
    uint8_t request[ECT_MODBUS_ADU] = {0, 1, 0, 0, 0, 254, 255, 100};
    bench_t b;
    (void)state;
    open_bench(&b);
    int fd = connect_client(&b);
    assert_int_equal(write(fd, request, sizeof request), sizeof request);
    (void)serve(&b);
    assert_string_equal(receive_reply(fd), "00 01 00 00 00 03 FF E4 01");
    close(fd);
    close_bench(&b);
}

/* --- clients ------------------------------------------------------------------------------------------------------ */

enum { MANY = 100, SERVED = 4 };

static void a_hundred(void **state)
{
    int fds[MANY];
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    for (unsigned int i = 0; i < MANY; i++)
        fds[i] = connect_client(&b);
    assert_int_equal(serve(&b), MANY);
    for (unsigned int round = 0; round < 3; round++) {
        for (unsigned int i = 0; i < SERVED; i++)
            expect(&b, fds[i], "one of four", READ, VALUE);
    }
    for (unsigned int i = SERVED; i < MANY; i++) {
        assert_string_equal(receive_reply(fds[i]), "end");
        close(fds[i]);
    }
    close(fds[2]);
    (void)serve(&b);
    fds[2] = connect_client(&b);
    expect(&b, fds[2], "in the place of a closed connection", READ, VALUE);
    int fifth = connect_client(&b);
    (void)serve(&b);
    assert_string_equal(receive_reply(fifth), "end");
    close(fifth);
    for (unsigned int i = 0; i < SERVED; i++)
        close(fds[i]);
    (void)serve(&b);
    assert_true(ect_modbus_server_due(b.server) == ECT_NEVER);
    close_bench(&b);
}

static void idle_clients_are_closed(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b);
    int silent = connect_client(&b), half = connect_client(&b), busy = connect_client(&b);
    (void)serve(&b);
    for (unsigned int s = 0; s < IDLE_S - 1; s++) {
        wire_advance(&b.wire, 1000 * MS);
        send_request(half, s == 30 ? "00" : "");
        expect(&b, busy, "a client with a request each second", "00 01 00 00 00 06 FF 06 00 71 00 01",
               "00 01 00 00 00 06 FF 06 00 71 00 01");
    }
    assert_string_equal(receive_reply(silent), "");
    assert_string_equal(receive_reply(half), "");
    assert_true(ect_modbus_server_due(b.server) == b.wire.now_ns + 1000 * MS);
    wire_advance(&b.wire, 1000 * MS);
    (void)serve(&b);
    assert_string_equal(receive_reply(silent), "end");
    assert_string_equal(receive_reply(half), "end");
    assert_string_equal(receive_reply(busy), "");
    close(silent);
    close(half);
    close(busy);
    close_bench(&b);
}

/* No further request of such a client is received, and its requests do not wake the loop. */
static void client_that_does_not_read(void **state)
{
    uint8_t request[16], bytes[4096];
    size_t sent = 0, received = 0;
    const int room = 4096;
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b), other = connect_client(&b);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &room, sizeof room), 0);
    size_t size = from_hex("12 34 00 00 00 06 01 04 00 00 00 21", request);
    while (write(fd, request, size) == (ssize_t)size) {
        sent++;
        (void)serve(&b);
        assert_true(sent < ROOM);
    }
    assert_int_equal(errno, EAGAIN);
    assert_false(wants_to_be_served(&b));
    expect(&b, other, "somebody else", READ, VALUE);
    for (ssize_t got; (got = __real_recv(fd, bytes, sizeof bytes, 0)) > 0; (void)serve(&b))
        received += (size_t)got;
    assert_int_equal(received, sent * (9 + 66)); /* complete replies to all requests */
    expect(&b, fd, "the client after reading", READ, VALUE);
    close(fd);
    close(other);
    close_bench(&b);
}

/* The pending requests of such a client are not received, so its time without a request begins. */
static void place_of_a_client_that_did_not_read(void **state)
{
    uint8_t request[16];
    size_t sent = 0;
    const int room = 4096;
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &room, sizeof room), 0);
    size_t size = from_hex("12 34 00 00 00 06 01 04 00 00 00 21", request);
    while (write(fd, request, size) == (ssize_t)size) {
        (void)serve(&b);
        assert_true(++sent < ROOM);
    }
    wire_advance(&b.wire, IDLE_S * 1000ull * MS);
    (void)serve(&b);
    assert_true(ect_modbus_server_due(b.server) == ECT_NEVER);
    int next = connect_client(&b);
    expect(&b, next, "the next client", READ, VALUE);
    close(next);
    close(fd);
    close_bench(&b);
}

static void no_client_waits_for_long(void **state)
{
    int flood[3];
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    for (unsigned int i = 0; i < 3; i++)
        flood[i] = connect_client(&b);
    int fd = connect_client(&b);
    (void)serve(&b);
    for (unsigned int i = 0; i < 3 * 200; i++)
        send_request(flood[i % 3], READ);
    for (unsigned int round = 0; round < 20; round++) {
        send_request(fd, READ);
        for (unsigned int i = 0; i < 4; i++)
            serve_once(&b);
        assert_string_equal(receive_reply(fd), VALUE);
    }
    for (unsigned int i = 0; i < 3; i++)
        close(flood[i]);
    close(fd);
    close_bench(&b);
}

static void no_descriptor_left(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b);
    work.accept_error = EMFILE;
    serve_once(&b);
    assert_false(wants_to_be_served(&b));
    assert_true(ect_modbus_server_due(b.server) == b.wire.now_ns + 1000 * MS);
    work.accept_error = 0;
    wire_advance(&b.wire, 1000 * MS);
    expect(&b, fd, "a second later", READ, VALUE);
    close(fd);
    close_bench(&b);
}

/* After the end of the pending client, or a signal, the server need not wait. */
static void nobody_to_accept(void **state)
{
    static const int errors[] = {EAGAIN, EINTR, ECONNABORTED};
    (void)state;
    for (size_t i = 0; i < COUNT(errors); i++) {
        bench_t b;
        open_bench(&b);
        int fd = connect_client(&b);
        work.accept_error = errors[i];
        serve_once(&b);
        work.accept_error = 0;
        if (ect_modbus_server_due(b.server) != ECT_NEVER)
            fail_msg("%s: the server waits", strerror(errors[i]));
        (void)serve(&b);
        expect(&b, fd, "accepted", "00 04 00 00 00 02 FF 2B", "00 04 00 00 00 03 FF AB 01");
        close(fd);
        close_bench(&b);
    }
}

static void closed_before_the_reply(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b), other = connect_client(&b);
    (void)serve(&b);
    for (unsigned int i = 0; i < 10; i++)
        send_request(fd, READ);
    close(fd);
    (void)serve(&b);
    expect(&b, other, "somebody else", READ, VALUE);
    close(other);
    close_bench(&b);
}

/* While the microcontroller is stopped, requests are lost; afterwards the unit replies again. */
static void a_unit_that_hangs(void **state)
{
    const ect_fault_t hang = {.kind = ECT_FAULT_HANG, .slave = 1}, resume = {.kind = ECT_FAULT_RESUME, .slave = 1};
    bench_t b;
    (void)state;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b);
    (void)serve(&b);
    ect_chain_fault(b.wire.chain, &hang, b.wire.now_ns);
    expect(&b, fd, "the unit hangs", READ, "");
    int late = connect_client(&b);
    (void)serve(&b);
    assert_string_equal(receive_reply(late), "end");
    close(late);
    ect_chain_fault(b.wire.chain, &resume, b.wire.now_ns);
    expect(&b, fd, "the unit runs again", READ, VALUE);
    close(fd);
    close_bench(&b);
}

/* --- addresses ---------------------------------------------------------------------------------------------------- */

static void no_address(void **state)
{
    static const char *const rows[] = {
        "",        ":",           "x",        "127.0.0.1",      "127.0.0.1:", "127.0.0.1:x",
        "502x",    "65536",       "-1",       "localhost:1502", "::1:1502",   "[::1]1502",
        "[::1:15", "1.2.3.4.5:6", "127.1.2.", "[127.0.0.1:15",  " 1502",      "1502 "};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char message[ECT_MODBUS_MESSAGE] = "";
        ect_modbus_server_t *server = ect_modbus_server_open(rows[i], message);
        if (server || !strstr(message, "is no [ADDRESS:]PORT") || strchr(message, '\n'))
            fail_msg("'%s': expected a line with the reason, got %s", rows[i], server ? "a server" : message);
    }
}

/* Port 0: the system chooses a port, which ect_modbus_server_address() returns. */
static void listens(void **state)
{
    static const struct {
        const char *where, *address;
        int family;
    } rows[] = {
        {"0", "127.0.0.1:", AF_INET},       {"127.0.0.1:0", "127.0.0.1:", AF_INET},
        {"0.0.0.0:0", "0.0.0.0:", AF_INET}, {"[127.0.0.1]:0", "127.0.0.1:", AF_INET},
        {"[::1]:0", "[::1]:", AF_INET6},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char message[ECT_MODBUS_MESSAGE] = "";
        ect_modbus_server_t *server = ect_modbus_server_open(rows[i].where, message);
        if (!server && rows[i].family == AF_INET6 && (errno == EAFNOSUPPORT || errno == EADDRNOTAVAIL))
            continue; /* a machine without IPv6 */
        if (!server)
            fail_msg("'%s': %s", rows[i].where, message);
        const char *address = ect_modbus_server_address(server);
        size_t length = strlen(rows[i].address);
        if (strncmp(address, rows[i].address, length) != 0 || atoi(address + length) <= 0)
            fail_msg("'%s': expected a port at %s, got %s", rows[i].where, rows[i].address, address);
        assert_true(ect_modbus_server_due(server) == ECT_NEVER);
        ect_modbus_server_close(server);
    }
}

static void listens_at_descriptor_0(void **state)
{
    char message[ECT_MODBUS_MESSAGE] = "";
    const int input = dup(STDIN_FILENO);
    (void)state;
    (void)close(STDIN_FILENO);
    ect_modbus_server_t *server = ect_modbus_server_open("127.0.0.1:0", message);
    const bool used = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    ect_modbus_server_close(server);
    const bool left = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    if (!server)
        fail_msg("%s", message);
    assert_true(used);
    assert_false(left);
}

/* A server with a listening socket, and one without. */
static void closes_its_descriptors(void **state)
{
    char message[ECT_MODBUS_MESSAGE] = "";
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        const int before = open("/dev/null", O_RDONLY);
        close(before);
        ect_modbus_server_close(i == 0 ? ect_modbus_server_open("127.0.0.1:0", message)
                                       : ect_modbus_server_new(message));
        const int next = open("/dev/null", O_RDONLY);
        close(next);
        assert_int_equal(next, before);
    }
}

/* The message has cause and cure, errno the number of the cause. */
static void cannot_listen(void **state)
{
    char message[ECT_MODBUS_MESSAGE] = "", where[64], want[ECT_MODBUS_MESSAGE];
    (void)state;
    ect_modbus_server_t *first = ect_modbus_server_open("127.0.0.1:0", message);
    assert_non_null(first);
    snprintf(where, sizeof where, "%s", ect_modbus_server_address(first));
    assert_null(ect_modbus_server_open(where, message));
    assert_int_equal(errno, EADDRINUSE);
    snprintf(want, sizeof want,
             "cannot listen at '%s': the port is in use: choose another port, or 0 for any free port", where);
    assert_string_equal(message, want);
    ect_modbus_server_close(first);
    ect_modbus_server_t *again = ect_modbus_server_open(where, message); /* the port is free again */
    assert_non_null(again);
    ect_modbus_server_close(again);
    assert_null(ect_modbus_server_open("192.0.2.1:0", message));
    assert_int_equal(errno, EADDRNOTAVAIL);
    assert_non_null(strstr(message, "this machine does not have the address"));
    assert_null(ect_modbus_server_open("nowhere", message));
    assert_int_equal(errno, EINVAL);
    ect_modbus_server_close(NULL);
}

/* --- records ------------------------------------------------------------------------------------------------------ */

enum { OBSERVED_MOST = 16 };

typedef struct observed {
    size_t count;
    struct {
        uint8_t request[ECT_MODBUS_ADU], reply[ECT_MODBUS_ADU];
        size_t length, reply_length;
    } one[OBSERVED_MOST];
} observed_t;

static void observe(void *ctx, const uint8_t *request, size_t length, const uint8_t *reply, size_t reply_length)
{
    observed_t *o = ctx;
    assert_true(o->count < OBSERVED_MOST && length <= ECT_MODBUS_ADU && reply_length <= ECT_MODBUS_ADU);
    memcpy(o->one[o->count].request, request, length);
    memcpy(o->one[o->count].reply, reply, reply_length);
    o->one[o->count].length = length;
    o->one[o->count++].reply_length = reply_length;
}

/* The replies to the client are unchanged. */
static void observed_and_repeated(void **state)
{
    static const char *const requests[][2] = {
        {"00 01 00 00 00 09 FF 10 00 0C 00 01 02 01 2C", "00 01 00 00 00 06 FF 10 00 0C 00 01"},
        {"00 02 00 00 00 06 FF 03 00 0B 00 02", "00 02 00 00 00 07 FF 03 04 00 00 01 2C"},
        {"00 03 00 00 00 06 FF 03 FF FF 00 01", "00 03 00 00 00 03 FF 83 02"},
        {"00 04 00 00 00 02 FF 2B", "00 04 00 00 00 03 FF AB 01"},
        {"00 09 00 00 00 0D FF 17 00 71 00 01 00 71 00 01 02 12 34", "00 09 00 00 00 05 FF 17 02 12 34"},
    };
    static observed_t o;
    char message[ECT_MODBUS_MESSAGE];
    uint8_t reply[ECT_MODBUS_ADU];
    bench_t b;
    wire_t other;
    (void)state;
    memset(&o, 0, sizeof o);
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    assert_true(ect_modbus_server_observe(b.server, observe, &o));
    int fd = connect_client(&b);
    (void)serve(&b);
    for (size_t i = 0; i < COUNT(requests); i++)
        expect(&b, fd, "observed", requests[i][0], requests[i][1]);
    assert_int_equal(o.count, COUNT(requests));
    close(fd);
    wire_open_one(&other, &ect_eclink_map7);
    wire_advance(&other, 125 * MS);
    ect_modbus_server_t *again = ect_modbus_server_new(message);
    assert_non_null(again);
    for (size_t i = 0; i < o.count; i++) {
        size_t length =
            ect_modbus_server_request(again, other.chain, other.now_ns, o.one[i].request, o.one[i].length, reply);
        assert_int_equal(length, o.one[i].reply_length);
        assert_memory_equal(reply, o.one[i].reply, length);
    }
    ect_modbus_server_close(again);
    wire_close(&other);
    close_bench(&b);
}

/* modbus_reply() fails, without and with an observer. */
static void closed_without_a_reply(void **state)
{
    static observed_t o;
    (void)state;
    for (unsigned int observed = 0; observed < 2; observed++) {
        bench_t b;
        memset(&o, 0, sizeof o);
        open_bench(&b);
        if (observed != 0)
            assert_true(ect_modbus_server_observe(b.server, observe, &o));
        int fd = connect_client(&b);
        (void)serve(&b);
        forms_no_reply = true;
        send_request(fd, "00 02 00 00 00 06 FF 03 00 0B 00 02");
        (void)serve(&b);
        forms_no_reply = false;
        assert_string_equal(receive_reply(fd), "end");
        assert_int_equal(o.count, observed);
        assert_int_equal(o.one[0].reply_length, 0);
        close(fd);
        close_bench(&b);
    }
}

/* A record may contain any bytes. */
static void no_request_to_repeat(void **state)
{
    static const char *const rows[] = {"",
                                       "00",
                                       "00 01 00 00 00 06 FF",
                                       "00 01 00 00 00 06 FF 03 00 0B 00",
                                       "00 01 00 00 00 06 FF 03 00 0B 00 01 00",
                                       "00 01 00 01 00 06 FF 03 00 0B 00 01",
                                       "00 01 00 00 00 01 FF 03",
                                       "00 01 00 00 00 02 FF 80"};
    char message[ECT_MODBUS_MESSAGE];
    uint8_t request[2 * ECT_MODBUS_ADU] = {0, 1, 0, 0, 1, 250, 255, 3}, reply[ECT_MODBUS_ADU];
    wire_t w;
    (void)state;
    wire_open_one(&w, &ect_eclink_map7);
    ect_modbus_server_t *server = ect_modbus_server_new(message);
    assert_non_null(server);
    assert_int_equal(ect_modbus_server_request(server, w.chain, w.now_ns, request, sizeof request, reply), 0);
    ect_store_be16(request + 4, ECT_MODBUS_ADU + 1 - 6); /* one byte longer than the longest request */
    assert_int_equal(ect_modbus_server_request(server, w.chain, w.now_ns, request, ECT_MODBUS_ADU + 1, reply), 0);
    ect_store_be16(request + 4, ECT_MODBUS_ADU - 6);
    request[7] = 100; /* no such function */
    assert_int_equal(ect_modbus_server_request(server, w.chain, w.now_ns, request, ECT_MODBUS_ADU, reply), 9);
    assert_memory_equal(reply, "\0\1\0\0\0\3\xFF\xE4\1", 9);
    for (size_t i = 0; i < COUNT(rows); i++) {
        size_t length = from_hex(rows[i], request);
        if (ect_modbus_server_request(server, w.chain, w.now_ns, request, length, reply) != 0)
            fail_msg("'%s' has a reply", rows[i]);
    }
    ect_modbus_server_close(server);
    wire_close(&w);
}

/* A daemon's standard input may be closed: a client then gets descriptor 0. */
static void serve_at_descriptor_0(bool idle)
{
    bench_t b;
    open_bench(&b);
    wire_advance(&b.wire, 125 * MS);
    int fd = connect_client(&b);
    const int input = dup(STDIN_FILENO);
    (void)close(STDIN_FILENO);
    (void)serve(&b);
    expect(&b, fd, "descriptor 0", "00 01 00 00 00 06 FF 03 00 0B 00 01", "00 01 00 00 00 05 FF 03 02 00 00");
    int other = connect_client(&b);
    (void)serve(&b);
    expect(&b, other, "another client", "00 02 00 00 00 06 FF 03 00 0B 00 01", "00 02 00 00 00 05 FF 03 02 00 00");
    expect(&b, fd, "descriptor 0", "00 03 00 00 00 06 FF 03 00 0B 00 01", "00 03 00 00 00 05 FF 03 02 00 00");
    close(other);
    (void)serve(&b);
    const bool used = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    const uint64_t due_ns = ect_modbus_server_due(b.server), last_ns = b.wire.now_ns + IDLE_S * 1000ull * MS;
    if (idle) {
        wire_advance(&b.wire, IDLE_S * 1000ull * MS);
        (void)serve(&b);
    } else {
        close_bench(&b);
    }
    const bool left = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    if (idle)
        close_bench(&b);
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    close(fd);
    assert_true(used);
    assert_true(due_ns == last_ns);
    assert_false(left);
}

static void without_memory(void **state)
{
    char message[ECT_MODBUS_MESSAGE] = "";
    int fd = open("/dev/null", O_RDONLY);
    (void)state;
    refuses_memory = true;
    const ect_modbus_server_t *server = ect_modbus_server_at(fd, message);
    refuses_memory = false;
    assert_null(server);
    assert_string_equal(message, "not enough memory");
    assert_int_equal(fcntl(fd, F_GETFD), -1); /* closed by the server */
    refuses_memory = true;
    server = ect_modbus_server_new(message);
    refuses_memory = false;
    assert_null(server);
    for (memory_fails_at = 1; memory_fails_at <= 3; memory_fails_at++) { /* the server and its two tables */
        allocations = 0;
        server = ect_modbus_server_new(message);
        if (server)
            fail_msg("allocation %u fails: a server", memory_fails_at);
    }
    memory_fails_at = 0;
}

/* epoll_ctl() refuses a file. */
static void no_socket(void **state)
{
    char message[ECT_MODBUS_MESSAGE] = "";
    int fd = open("/dev/null", O_RDONLY);
    (void)state;
    const ect_modbus_server_t *server = ect_modbus_server_at(fd, message);
    assert_null(server);
    assert_string_equal(message, "no server: Operation not permitted");
    assert_int_equal(fcntl(fd, F_GETFD), -1);
}

static void descriptor_0(void **state)
{
    (void)state;
    serve_at_descriptor_0(false);
    serve_at_descriptor_0(true);
}

/* Opens descriptor 0, which cases close, so that it belongs to no bench. */
static void hold_descriptor_0(void)
{
    if (fcntl(STDIN_FILENO, F_GETFD) < 0 && open("/dev/null", O_RDONLY) != STDIN_FILENO)
        abort();
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    hold_descriptor_0();
    const struct CMUnitTest tests[] = {
        TEST("ECL-070 ECL-071: requests and replies, byte for byte; transaction and unit identifiers are returned",
             answers),
        TEST("ECL-070: each request addresses its range; malformed requests get exception 3", requests),
        TEST("ECL-070: the longest write of each function is accepted", longest_writes),
        TEST("ECL-070: all other functions get exception 1", no_other_function),
        TEST("Attack: a request in two pieces or byte by byte gets its reply; meanwhile others are served",
             in_two_pieces),
        TEST("Attack: successive requests get their replies in order, one in each call", many_at_once),
        TEST("Attack: bytes that are no Modbus TCP end their connection and no other", no_modbus),
        TEST("Attack: the longest possible request gets a reply", longest_request),
        TEST("ECL-070: four of 100 connections are served, the others closed at once; after an end another is served",
             a_hundred),
        TEST("Attack: a connection without a whole request for 60 s is closed", idle_clients_are_closed),
        TEST("Attack: a client that does not read its replies delays only itself, and loses no reply",
             client_that_does_not_read),
        TEST("Attack: a client that does not read its replies for 60 s is closed, and the next client is served",
             place_of_a_client_that_did_not_read),
        TEST("Attack: three clients that flood do not delay the fourth", no_client_waits_for_long),
        TEST("Attack: without free descriptors the server retries after a second", no_descriptor_left),
        TEST("An accept without a client is repeated at the next connection", nobody_to_accept),
        TEST("Attack: a client that is closed before its replies has no effect on others", closed_before_the_reply),
        TEST("An observer gets each request and its reply; another unit gives the same replies to these requests",
             observed_and_repeated),
        TEST("A client is closed if libmodbus does not reply to its request, with and without an observer",
             closed_without_a_reply),
        TEST("Bytes of a record that are no request get no reply", no_request_to_repeat),
        TEST("A server listens at descriptor 0", listens_at_descriptor_0),
        TEST("The descriptors of a server are closed with the server", closes_its_descriptors),
        TEST("Without memory no server is made, and its socket is closed", without_memory),
        TEST("A descriptor that is no socket is refused with the reason, and closed", no_socket),
        TEST("A client whose descriptor is 0 is served, and closed with the server", descriptor_0),
        TEST("A unit that hangs does not reply, and replies again when it runs", a_unit_that_hangs),
        TEST("--modbus: a wrong address is refused with a line", no_address),
        TEST("A server listens at PORT, ADDRESS:PORT and [ADDRESS]:PORT, and returns the port that the system chooses",
             listens),
        TEST("A port in use and an address of another machine are refused with cause and cure", cannot_listen),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Modbus TCP", tests, NULL, NULL);
}
