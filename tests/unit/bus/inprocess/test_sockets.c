/* SPDX-License-Identifier: MIT */
/* Calls on sockets: those of the bus go to its ports, all others to the C library, and nothing of a call is lost. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/interfaces.h"
#include "bus/inprocess/ports.h"
#include "bus/inprocess/raw.h"
#include "bus/inprocess/time.h"
#include "fakes.h"

/* A descriptor of the bus is its own port's address; others are below. */
enum { PORT = 700, PORTS_END = 800, OTHER = 5 };

OURS(socket);
OURS(bind);
OURS(setsockopt);
OURS(getsockopt);
OURS(getsockname);
OURS(ioctl);
OURS(send);
OURS(sendto);
OURS(sendmsg);
OURS(sendmmsg);
OURS(write);
OURS(writev);
OURS(recv);
OURS(recvfrom);
OURS(recvmsg);
OURS(recvmmsg);
OURS(readv);
OURS(read);
OURS(accept);
OURS(accept4);
OURS(close);
int ours_close_range(unsigned int from, unsigned int to, int flags);
void ours_closefrom(int from);
OURS(dup);
OURS(dup2);
OURS(dup3);
OURS(fcntl);
OURS(fcntl64);
ssize_t ours___read_chk(int fd, void *data, size_t size, size_t room);
ssize_t ours___recv_chk(int fd, void *data, size_t size, size_t room, int flags);
ssize_t ours___recvfrom_chk(int fd, void *data, size_t size, size_t room, int flags, struct sockaddr *from,
                            socklen_t *length);

/* --- the C library --------------------------------------------------------------------------------------------- */

/* All arguments are passed in registers as words. */
#define FAKE_OF(name, result, given, ...)                                                                              \
    static result fake_##name given                                                                                    \
    {                                                                                                                  \
        return (result)CALLED(name, __VA_ARGS__);                                                                      \
    }

FAKE_OF(socket, int, (int a, int b, int c), a, b, c)
FAKE_OF(bind, int, (int a, const void *b, socklen_t c), a, (long)b, c)
FAKE_OF(setsockopt, int, (int a, int b, int c, const void *d, socklen_t e), a, b, c, (long)d, e)
FAKE_OF(getsockopt, int, (int a, int b, int c, void *d, socklen_t *e), a, b, c, (long)d, (long)e)
FAKE_OF(getsockname, int, (int a, void *b, socklen_t *c), a, (long)b, (long)c)
FAKE_OF(fcntl, int, (int a, int b, long c), a, b, b == F_GETFD ? 0 : c)
FAKE_OF(ioctl, int, (int a, unsigned long b, long c), a, (long)b, b == FIOCLEX || b == FIONCLEX ? 0 : c)
FAKE_OF(send, ssize_t, (int a, const void *b, size_t c, int d), a, (long)b, (long)c, d)
FAKE_OF(sendto, ssize_t, (int a, const void *b, size_t c, int d, const void *e, socklen_t f), a, (long)b, (long)c, d,
        (long)e, f)
FAKE_OF(sendmsg, ssize_t, (int a, const struct msghdr *b, int c), a, (long)b, c)
FAKE_OF(sendmmsg, int, (int a, struct mmsghdr *b, unsigned int c, int d), a, (long)b, c, d)
FAKE_OF(write, ssize_t, (int a, const void *b, size_t c), a, (long)b, (long)c)
FAKE_OF(writev, ssize_t, (int a, const struct iovec *b, int c), a, (long)b, c)
FAKE_OF(recv, ssize_t, (int a, void *b, size_t c, int d), a, (long)b, (long)c, d)
FAKE_OF(recvfrom, ssize_t, (int a, void *b, size_t c, int d, void *e, socklen_t *f), a, (long)b, (long)c, d, (long)e,
        (long)f)
FAKE_OF(recvmsg, ssize_t, (int a, struct msghdr *b, int c), a, (long)b, c)
FAKE_OF(recvmmsg, int, (int a, struct mmsghdr *b, unsigned int c, int d, struct timespec *e), a, (long)b, c, d, (long)e)
FAKE_OF(readv, ssize_t, (int a, const struct iovec *b, int c), a, (long)b, c)
FAKE_OF(read, ssize_t, (int a, void *b, size_t c), a, (long)b, (long)c)
FAKE_OF(__read_chk, ssize_t, (int a, void *b, size_t c, size_t d), a, (long)b, (long)c, (long)d)
FAKE_OF(__recv_chk, ssize_t, (int a, void *b, size_t c, size_t d, int e), a, (long)b, (long)c, (long)d, e)
FAKE_OF(__recvfrom_chk, ssize_t, (int a, void *b, size_t c, size_t d, int e, void *f, socklen_t *g), a, (long)b,
        (long)c, (long)d, e, (long)f, (long)g)
FAKE_OF(accept, int, (int a, void *b, socklen_t *c), a, (long)b, (long)c)
FAKE_OF(accept4, int, (int a, void *b, socklen_t *c, int d), a, (long)b, (long)c, d)
FAKE_OF(close, int, (int a), a)
FAKE_OF(dup, int, (int a), a)
FAKE_OF(dup2, int, (int a, int b), a, b)
FAKE_OF(dup3, int, (int a, int b, int c), a, b, c)

static FAKE_3(close_range)

    static void fake_closefrom(int from)
{
    CALLED(closefrom, from);
}

FAKES(FAKE(socket), FAKE(bind), FAKE(setsockopt), FAKE(getsockopt), FAKE(getsockname), FAKE(fcntl), FAKE(ioctl),
      FAKE(send), FAKE(sendto), FAKE(sendmsg), FAKE(sendmmsg), FAKE(write), FAKE(writev), FAKE(recv), FAKE(recvfrom),
      FAKE(recvmsg), FAKE(recvmmsg), FAKE(readv), FAKE(read), FAKE(__read_chk), FAKE(__recv_chk), FAKE(__recvfrom_chk),
      FAKE(accept), FAKE(accept4), FAKE(close), FAKE(close_range), FAKE(closefrom), FAKE(dup), FAKE(dup2), FAKE(dup3))

/* --- the rest of the room ---------------------------------------------------------------------------------------- */

ect_port_t *ect_port_of(int fd)
{
    return fd >= PORT && fd < PORTS_END ? (ect_port_t *)(long)fd : NULL;
}

int ect_port_open(int type, int protocol)
{
    return (int)CALLED(port_open, type, protocol);
}

void ect_eventfd_copied(int fd, int copy)
{
    CALLED(copied, fd, copy);
}

void ect_eventfds_closed(unsigned int from, unsigned int to)
{
    CALLED(closed, from, to);
}

void ect_port_set_nonblocking(ect_port_t *port, bool on)
{
    CALLED(port_set_nonblocking, (long)port, on);
}

int ect_port_bind(ect_port_t *port, const struct sockaddr *address, socklen_t length)
{
    return (int)CALLED(port_bind, (long)port, (long)address, length);
}

int ect_port_set(ect_port_t *port, int level, int name, const void *value, socklen_t length)
{
    return (int)CALLED(port_set, (long)port, level, name, (long)value, length);
}

int ect_port_get(ect_port_t *port, int level, int name, void *value, socklen_t *length)
{
    return (int)CALLED(port_get, (long)port, level, name, (long)value, (long)length);
}

int ect_port_name(ect_port_t *port, struct sockaddr *address, socklen_t *length)
{
    return (int)CALLED(port_name, (long)port, (long)address, (long)length);
}

ssize_t ect_port_send(ect_port_t *port, const struct iovec *pieces, size_t count, const struct sockaddr *to,
                      socklen_t to_length)
{
    return CALLED(port_send, (long)port, count > 0 ? (long)pieces->iov_base : 0, count > 0 ? (long)pieces->iov_len : 0,
                  (long)count, (long)to, to_length);
}

/* Flags and length of an address are results, too. */
ssize_t ect_port_receive(ect_port_t *port, const struct iovec *pieces, size_t count, int flags, int *result_flags,
                         struct sockaddr *from, socklen_t *from_length)
{
    if (result_flags)
        *result_flags = MSG_TRUNC;
    long room = from_length && (long)from_length > 4096 ? (long)*from_length : (long)from_length;
    if (from_length && (long)from_length > 4096)
        *from_length = 20;
    return CALLED(port_receive, (long)port, (long)pieces->iov_base, (long)pieces->iov_len, (long)count, flags,
                  (long)from, room);
}

bool ect_interface_has(unsigned long request)
{
    return request == SIOCGIFINDEX;
}

bool ect_interface_request(int fd, unsigned long request, void *argument, int *result)
{
    bool has = request == SIOCGIFFLAGS;
    if (has)
        *result = (int)CALLED(interface, fd, (long)argument);
    return has;
}

void ect_raw_scan(void)
{
    CALLED(raw_scan);
}

bool ect_time_before_read(const char *call, int fd, int flags)
{
    char name[32];
    snprintf(name, sizeof name, "before %.*s", (int)strcspn(call, "("), call);
    return fake_call(name, (const long[]){fd, flags}, 2) == 0;
}

/* --- tests -------------------------------------------------------------------------------------------------------- */

static struct iovec pieces = {.iov_base = (void *)60, .iov_len = 61};

#define CALL_OF(name, ...)                                                                                             \
    static long call_##name(int fd)                                                                                    \
    {                                                                                                                  \
        return ours_##name(__VA_ARGS__);                                                                               \
    }

CALL_OF(bind, fd, AT(10), 11)
CALL_OF(setsockopt, fd, 10, 11, AT(12), 13)
CALL_OF(getsockopt, fd, 10, 11, AT(12), AT(13))
CALL_OF(getsockname, fd, AT(10), AT(11))
CALL_OF(send, fd, AT(10), 11, 12)
CALL_OF(sendto, fd, AT(10), 11, 12, AT(13), 14)
CALL_OF(write, fd, AT(10), 11)
CALL_OF(recv, fd, AT(10), 11, 12)
CALL_OF(recvfrom, fd, AT(10), 11, 12, AT(13), AT(14))
CALL_OF(read, fd, AT(10), 11)
CALL_OF(__read_chk, fd, AT(10), 11, 11)
CALL_OF(__recv_chk, fd, AT(10), 13, 12, 14)
CALL_OF(__recvfrom_chk, fd, AT(10), 13, 12, 14, AT(15), AT(16))
CALL_OF(accept, fd, AT(10), AT(11))
CALL_OF(accept4, fd, AT(10), AT(11), 12)
CALL_OF(close, fd)
CALL_OF(dup, fd)

typedef struct row {
    const char *name;
    long (*call)(int fd);
    const char *other; /* calls with the descriptor 5 */
    const char *port;  /* calls with the descriptor 700 */
    const char *result;
} row_t;

#define ROW(name, other, port, result) {#name, call_##name, other, port, result}

static const row_t rows[] = {
    ROW(bind, "bind(5,10,11) ", "port_bind(700,10,11) ", "port_bind"),
    ROW(setsockopt, "setsockopt(5,10,11,12,13) ", "port_set(700,10,11,12,13) ", "port_set"),
    ROW(getsockopt, "getsockopt(5,10,11,12,13) ", "port_get(700,10,11,12,13) ", "port_get"),
    ROW(getsockname, "getsockname(5,10,11) ", "port_name(700,10,11) ", "port_name"),
    ROW(send, "send(5,10,11,12) ", "port_send(700,10,11,1,0,0) ", "port_send"),
    ROW(sendto, "sendto(5,10,11,12,13,14) ", "port_send(700,10,11,1,13,14) ", "port_send"),
    ROW(write, "write(5,10,11) ", "port_send(700,10,11,1,0,0) ", "port_send"),
    ROW(recv, "before recv(5,12) recv(5,10,11,12) ", "port_receive(700,10,11,1,12,0,0) ", "port_receive"),
    ROW(recvfrom, "before recvfrom(5,12) recvfrom(5,10,11,12,13,14) ", "port_receive(700,10,11,1,12,13,14) ",
        "port_receive"),
    ROW(read, "before read(5,0) read(5,10,11) ", "port_receive(700,10,11,1,0,0,0) ", "port_receive"),
    ROW(__recv_chk, "__recv_chk(5,10,13,12,14) ", "port_receive(700,10,12,1,14,0,0) ", "port_receive"),
    ROW(__recvfrom_chk, "__recvfrom_chk(5,10,13,12,14,15,16) ", "port_receive(700,10,12,1,14,15,16) ", "port_receive"),
};

/* Within the library's own calls no descriptor is of the bus, and no read waits. */
static void passes_calls_on(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        plan(rows[i].name, 41, 0);
        assert_int_equal(rows[i].call(OTHER), 41);
        EXPECT_CALLS(rows[i].name, rows[i].other);
        plan(rows[i].result, 42, 0);
        assert_int_equal(rows[i].call(PORT), 42);
        EXPECT_CALLS(rows[i].name, rows[i].port);
        ect_inside = 1;
        plan(rows[i].name, 43, 0);
        assert_int_equal(rows[i].call(PORT), 43);
        assert_null(strstr(fakes.log, "port_"));
        assert_null(strstr(fakes.log, "before"));
        forget_calls();
        ect_inside = 0;
    }
}

/* A fortified call whose size fits is the usual one; another is the C library's, which ends the program. */
static void checks_the_room(void **state)
{
    (void)state;
    plan("port_receive", 42, 0);
    assert_int_equal(call___read_chk(PORT), 42);
    EXPECT_CALLS("fits", "port_receive(700,10,11,1,0,0,0) ");
    plan("__read_chk", 43, 0);
    assert_int_equal(ours___read_chk(PORT, AT(10), 12, 11), 43);
    EXPECT_CALLS("too large", "__read_chk(700,10,12,11) ");
    (void)ours___recv_chk(PORT, AT(10), 11, 12, 0);
    EXPECT_CALLS("recv", "port_receive(700,10,11,1,0,0,0) ");
    (void)ours___recvfrom_chk(PORT, AT(10), 11, 12, 0, NULL, NULL);
    EXPECT_CALLS("recvfrom", "port_receive(700,10,11,1,0,0,0) ");
    plan("recv", 42, 0);
    assert_int_equal(ours___recv_chk(OTHER, AT(10), 11, 11, 14), 42);
    EXPECT_CALLS("recv of another", "before recv(5,14) recv(5,10,11,14) ");
    plan("recvfrom", 43, 0);
    assert_int_equal(ours___recvfrom_chk(OTHER, AT(10), 11, 11, 14, AT(15), AT(16)), 43);
    EXPECT_CALLS("recvfrom of another", "before recvfrom(5,14) recvfrom(5,10,11,14,15,16) ");
}

static long call_recvmsg(int fd)
{
    return ours_recvmsg(fd, AT(8), 9);
}

static long call_recvmmsg(int fd)
{
    return ours_recvmmsg(fd, AT(8), 9, 10, AT(11));
}

static long call_readv(int fd)
{
    return ours_readv(fd, AT(8), 9);
}

/* A handler has ended the wait. */
static void ends_with_the_wait(void **state)
{
    static const struct {
        const char *wait;
        long (*call)(int fd);
        const char *calls;
    } ended[] = {{"before recv", call_recv, "before recv(5,12) "},
                 {"before recvfrom", call_recvfrom, "before recvfrom(5,12) "},
                 {"before read", call_read, "before read(5,0) "},
                 {"before recvmsg", call_recvmsg, "before recvmsg(5,9) "},
                 {"before recvmmsg", call_recvmmsg, "before recvmmsg(5,10) "},
                 {"before readv", call_readv, "before readv(5,0) "},
                 {"before accept", call_accept, "before accept(5,0) "},
                 {"before accept4", call_accept4, "before accept4(5,0) "}};
    (void)state;
    for (size_t i = 0; i < sizeof ended / sizeof *ended; i++) {
        plan(ended[i].wait, 1, EINTR);
        errno = 0;
        assert_int_equal(ended[i].call(OTHER), -1);
        assert_int_equal(errno, EINTR);
        EXPECT_CALLS(ended[i].wait, ended[i].calls);
    }
}

static void opens_raw_packet_sockets(void **state)
{
    (void)state;
    plan("port_open", PORT, 0);
    assert_int_equal(ours_socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 9), PORT);
    char want[64];
    snprintf(want, sizeof want, "raw_scan() port_open(%d,9) ", SOCK_RAW | SOCK_CLOEXEC);
    EXPECT_CALLS("of the bus", want);
    plan("socket", 4, 0);
    assert_int_equal(ours_socket(AF_PACKET, SOCK_DGRAM, 9), 4);
    snprintf(want, sizeof want, "socket(%d,%d,9) ", AF_PACKET, SOCK_DGRAM);
    EXPECT_CALLS("datagrams", want);
    plan("socket", 5, 0);
    assert_int_equal(ours_socket(AF_INET, SOCK_RAW, 9), 5);
    snprintf(want, sizeof want, "socket(%d,%d,9) ", AF_INET, SOCK_RAW);
    EXPECT_CALLS("of IP", want);
    ect_inside = 1;
    plan("socket", 6, 0);
    assert_int_equal(ours_socket(AF_PACKET, SOCK_RAW, 9), 6);
    snprintf(want, sizeof want, "socket(%d,%d,9) ", AF_PACKET, SOCK_RAW);
    EXPECT_CALLS("of the library", want);
}

static void sends_pieces(void **state)
{
    struct msghdr message = {.msg_iov = &pieces, .msg_iovlen = 1, .msg_name = AT(62), .msg_namelen = 8};
    char want[96];
    (void)state;
    plan("port_send", 61, 0);
    assert_int_equal(ours_sendmsg(PORT, &message, 0), 61);
    EXPECT_CALLS("sendmsg", "port_send(700,60,61,1,62,8) ");
    assert_int_equal(ours_sendmsg(PORT, NULL, 0), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("no message", "");
    plan("sendmsg", 7, 0);
    assert_int_equal(ours_sendmsg(OTHER, AT(8), 9), 7);
    EXPECT_CALLS("another", "sendmsg(5,8,9) ");
    plan("port_send", 61, 0);
    assert_int_equal(ours_writev(PORT, &pieces, 1), 61);
    EXPECT_CALLS("writev", "port_send(700,60,61,1,0,0) ");
    plan("writev", 7, 0);
    assert_int_equal(ours_writev(OTHER, &pieces, 1), 7);
    snprintf(want, sizeof want, "writev(5,%ld,1) ", (long)&pieces);
    EXPECT_CALLS("another", want);
}

static void sends_messages(void **state)
{
    struct mmsghdr messages[2] = {
        {.msg_hdr = {.msg_iov = &pieces, .msg_iovlen = 1, .msg_name = AT(62), .msg_namelen = 8}},
        {.msg_hdr = {.msg_iov = &pieces, .msg_iovlen = 1}}};
    (void)state;
    plan("port_send", 61, 0);
    plan("port_send", 59, 0);
    assert_int_equal(ours_sendmmsg(PORT, messages, 2, 0), 2);
    assert_int_equal(messages[0].msg_len, 61);
    assert_int_equal(messages[1].msg_len, 59);
    EXPECT_CALLS("two", "port_send(700,60,61,1,62,8) port_send(700,60,61,1,0,0) ");
    plan("port_send", 0, 0);
    plan("port_send", -1, ENXIO);
    assert_int_equal(ours_sendmmsg(PORT, messages, 2, 0), 1);
    EXPECT_CALLS("the second fails", "port_send(700,60,61,1,62,8) port_send(700,60,61,1,0,0) ");
    plan("port_send", -1, ENXIO);
    assert_int_equal(ours_sendmmsg(PORT, messages, 2, 0), -1);
    assert_int_equal(errno, ENXIO);
    EXPECT_CALLS("the first fails", "port_send(700,60,61,1,62,8) ");
    assert_int_equal(ours_sendmmsg(PORT, NULL, 1, 0), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ours_sendmmsg(PORT, NULL, 0, 0), 0);
    assert_int_equal(ours_sendmmsg(PORT, messages, 0, 0), 0);
    EXPECT_CALLS("none", "");
    plan("sendmmsg", 3, 0);
    assert_int_equal(ours_sendmmsg(OTHER, AT(8), 9, 10), 3);
    EXPECT_CALLS("another", "sendmmsg(5,8,9,10) ");
}

/* Numbers of pieces, of which the kernel takes 1024 at most, and refuses more in two ways. */
static void limits_the_number_of_pieces(void **state)
{
    static const struct {
        int count, of_vector, of_message; /* the errors */
    } cases[] = {{0, 0, 0}, {1024, 0, 0}, {1025, EINVAL, EMSGSIZE}, {-1, EINVAL, EMSGSIZE}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct msghdr message = {.msg_iov = &pieces, .msg_iovlen = (size_t)cases[i].count};
        errno = 0;
        assert_int_equal(ours_writev(PORT, &pieces, cases[i].count), cases[i].of_vector == 0 ? 0 : -1);
        assert_int_equal(errno, cases[i].of_vector);
        errno = 0;
        assert_int_equal(ours_readv(PORT, &pieces, cases[i].count), cases[i].of_vector == 0 ? 0 : -1);
        assert_int_equal(errno, cases[i].of_vector);
        assert_int_equal(ours_sendmsg(PORT, &message, 0), cases[i].of_message == 0 ? 0 : -1);
        assert_int_equal(ours_recvmsg(PORT, &message, 0), cases[i].of_message == 0 ? 0 : -1);
        assert_int_equal(errno, cases[i].of_message);
        forget_calls();
    }
}

static void reads_control_data(void **state)
{
    enum { LENGTH = 10000 };
    static char data[LENGTH];
    static const struct {
        size_t length, bad;
        bool sent;
    } cases[] = {{LENGTH, 0, false},
                 {LENGTH, 4096, false},
                 {LENGTH, 8192, false},
                 {LENGTH, LENGTH - 1, false},
                 {LENGTH - 1, LENGTH - 1, true},
                 {4096, 4096, true},
                 {4096, 4095, false},
                 {0, 0, true}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const struct msghdr message = {.msg_control = data, .msg_controllen = cases[i].length};
        bad_memory.unreadable = &data[cases[i].bad];
        errno = 0;
        assert_int_equal(ours_sendmsg(PORT, &message, 0), cases[i].sent ? 0 : -1);
        assert_int_equal(errno, cases[i].sent ? 0 : EFAULT);
    }
    const struct msghdr none = {.msg_controllen = 5};
    assert_int_equal(ours_sendmsg(PORT, &none, 0), 0);
    forget_calls();
}

static void stores_results_at_good_addresses(void **state)
{
    struct mmsghdr messages[2] = {{.msg_len = 7}, {.msg_len = 7}};
    struct timespec limit = {.tv_sec = 1};
    struct msghdr message = {0};
    (void)state;
    for (size_t i = 0; i < 2; i++)
        messages[i].msg_hdr = (struct msghdr){.msg_iov = &pieces, .msg_iovlen = 1};
    bad_memory.unwritable = &messages[0].msg_len;
    assert_int_equal(ours_sendmmsg(PORT, messages, 2, 0), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, NULL), -1);
    assert_int_equal(errno, EFAULT);
    bad_memory.unwritable = &messages[1].msg_len;
    assert_int_equal(ours_sendmmsg(PORT, messages, 2, 0), 1);
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, &limit), 1);
    bad_memory.unwritable = &limit;
    errno = 0;
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, &limit), -1);
    assert_int_equal(errno, EFAULT);
    forget_calls();
    plan("port_receive", -1, EAGAIN); /* the limit is not written without a frame */
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, &limit), -1);
    assert_int_equal(errno, EAGAIN);
    bad_memory.unreadable = &limit;
    forget_calls();
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, &limit), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("an unreadable limit", "");
    bad_memory.unwritable = &message;
    errno = 0;
    message.msg_iov = &pieces;
    assert_int_equal(ours_recvmsg(PORT, &message, 0), -1);
    assert_int_equal(errno, EFAULT);
    forget_calls();
}

static void receives_a_message(void **state)
{
    struct msghdr message = {
        .msg_iov = &pieces, .msg_iovlen = 1, .msg_name = AT(62), .msg_namelen = 30, .msg_controllen = 5};
    (void)state;
    plan("port_receive", 61, 0);
    assert_int_equal(ours_recvmsg(PORT, &message, 12), 61);
    assert_int_equal(message.msg_flags, MSG_TRUNC);
    assert_int_equal(message.msg_namelen, 20);
    assert_int_equal(message.msg_controllen, 0);
    EXPECT_CALLS("with an address", "port_receive(700,60,61,1,12,62,30) ");
    message = (struct msghdr){.msg_iov = &pieces, .msg_iovlen = 1, .msg_namelen = 30, .msg_controllen = 5};
    plan("port_receive", 0, 0);
    assert_int_equal(ours_recvmsg(PORT, &message, 0), 0);
    assert_int_equal(message.msg_namelen, 0);
    assert_int_equal(message.msg_controllen, 0);
    EXPECT_CALLS("without", "port_receive(700,60,61,1,0,0,0) ");
    message.msg_namelen = 30;
    message.msg_controllen = 5;
    plan("port_receive", -1, EAGAIN);
    assert_int_equal(ours_recvmsg(PORT, &message, 0), -1);
    assert_int_equal(message.msg_namelen, 30);
    assert_int_equal(message.msg_controllen, 5);
    EXPECT_CALLS("nothing", "port_receive(700,60,61,1,0,0,0) ");
    assert_int_equal(ours_recvmsg(PORT, NULL, 0), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("no message", "");
    plan("recvmsg", 7, 0);
    assert_int_equal(ours_recvmsg(OTHER, AT(8), 9), 7);
    EXPECT_CALLS("another", "before recvmsg(5,9) recvmsg(5,8,9) ");
    plan("port_receive", 61, 0);
    assert_int_equal(ours_readv(PORT, &pieces, 1), 61);
    EXPECT_CALLS("readv", "port_receive(700,60,61,1,0,0,0) ");
    plan("readv", 7, 0);
    assert_int_equal(ours_readv(OTHER, AT(8), 9), 7);
    EXPECT_CALLS("another readv", "before readv(5,0) readv(5,8,9) ");
}

static void receives_messages(void **state)
{
    struct mmsghdr messages[2] = {{.msg_hdr = {.msg_iov = &pieces, .msg_iovlen = 1}},
                                  {.msg_hdr = {.msg_iov = &pieces, .msg_iovlen = 1}}};
    char want[128];
    (void)state;
    plan("port_receive", 61, 0);
    plan("port_receive", 59, 0);
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, NULL), 2);
    assert_int_equal(messages[0].msg_len, 61);
    assert_int_equal(messages[1].msg_len, 59);
    EXPECT_CALLS("two", "port_receive(700,60,61,1,0,0,0) port_receive(700,60,61,1,0,0,0) ");
    plan("port_receive", 0, 0);
    plan("port_receive", -1, EAGAIN);
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, MSG_WAITFORONE, NULL), 1);
    snprintf(want, sizeof want, "port_receive(700,60,61,1,%d,0,0) port_receive(700,60,61,1,%d,0,0) ", MSG_WAITFORONE,
             MSG_WAITFORONE | MSG_DONTWAIT);
    EXPECT_CALLS("waits for one", want);
    plan("port_receive", -1, EAGAIN);
    assert_int_equal(ours_recvmmsg(PORT, messages, 2, 0, NULL), -1);
    EXPECT_CALLS("none", "port_receive(700,60,61,1,0,0,0) ");
    assert_int_equal(ours_recvmmsg(PORT, NULL, 1, 0, NULL), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ours_recvmmsg(PORT, NULL, 0, 0, NULL), 0);
    assert_int_equal(ours_recvmmsg(PORT, messages, 0, 0, NULL), 0);
    EXPECT_CALLS("no room", "");
    plan("recvmmsg", 3, 0);
    assert_int_equal(ours_recvmmsg(OTHER, AT(8), 9, 10, AT(11)), 3);
    EXPECT_CALLS("another", "before recvmmsg(5,10) recvmmsg(5,8,9,10,11) ");
}

static void accepts_after_waiting(void **state)
{
    (void)state;
    plan("accept", 6, 0);
    assert_int_equal(call_accept(OTHER), 6);
    EXPECT_CALLS("accept", "before accept(5,0) accept(5,10,11) ");
    plan("accept4", 6, 0);
    assert_int_equal(call_accept4(OTHER), 6);
    EXPECT_CALLS("accept4", "before accept4(5,0) accept4(5,10,11,12) ");
    ect_inside = 1;
    (void)call_accept(OTHER);
    (void)call_accept4(OTHER);
    EXPECT_CALLS("of the library", "accept(5,10,11) accept4(5,10,11,12) ");
}

/* --- requests --- */

static void switches_blocking(void **state)
{
    int on = 1, off = 0;
    char want[128];
    (void)state;
    plan("fcntl", O_RDWR | O_APPEND, 0);
    plan("fcntl", 44, 0);
    assert_int_equal(ours_ioctl(PORT, FIONBIO, &on), 44);
    snprintf(want, sizeof want, "fcntl(700,%d,0) port_set_nonblocking(700,1) fcntl(700,%d,%d) ", F_GETFL, F_SETFL,
             O_RDWR | O_APPEND | O_NONBLOCK);
    /* fcntl with two arguments has no third one. */
    char *third = strchr(fakes.log, ')');
    assert_non_null(third);
    assert_memory_equal(fakes.log, want, 10);
    assert_string_equal(third, strchr(want, ')'));
    forget_calls();
    plan("fcntl", O_RDWR | O_NONBLOCK, 0);
    assert_int_equal(ours_ioctl(PORT, FIONBIO, &off), 0);
    snprintf(want, sizeof want, ") port_set_nonblocking(700,0) fcntl(700,%d,%d) ", F_SETFL, O_RDWR);
    assert_string_equal(strchr(fakes.log, ')'), want);
    forget_calls();
    assert_int_equal(ours_ioctl(PORT, FIONBIO, NULL), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("no argument", "");
}

static void executes_requests(void **state)
{
    char want[64];
    (void)state;
    static const unsigned long of_any[] = {FIOCLEX, FIONCLEX};
    for (size_t i = 0; i < 2; i++) {
        plan("ioctl", 3, 0);
        assert_int_equal(ours_ioctl(PORT, of_any[i], 0L), 3);
        snprintf(want, sizeof want, "ioctl(700,%ld,0) ", (long)of_any[i]);
        EXPECT_CALLS("a request of any descriptor", want);
    }
    plan("interface", 4, 0);
    assert_int_equal(ours_ioctl(PORT, SIOCGIFFLAGS, AT(10)), 4);
    EXPECT_CALLS("an interface of the bus", "interface(700,10) ");
    static const struct {
        unsigned long request;
        int error;
    } refused[] = {{SIOCGIFINDEX, ENODEV}, {SIOCGIFMETRIC, EOPNOTSUPP}, {FIONREAD, ENOTTY}};
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(ours_ioctl(PORT, refused[i].request, AT(10)), -1);
        assert_int_equal(errno, refused[i].error);
    }
    EXPECT_CALLS("refused", "");
    plan("interface", 5, 0);
    assert_int_equal(ours_ioctl(OTHER, SIOCGIFFLAGS, AT(10)), 5);
    EXPECT_CALLS("on another socket", "interface(5,10) ");
    plan("ioctl", 6, 0);
    assert_int_equal(ours_ioctl(OTHER, SIOCGIFINDEX, AT(10)), 6);
    snprintf(want, sizeof want, "ioctl(5,%d,10) ", SIOCGIFINDEX);
    EXPECT_CALLS("another interface", want);
    ect_inside = 1;
    plan("ioctl", 7, 0);
    assert_int_equal(ours_ioctl(PORT, SIOCGIFFLAGS, AT(10)), 7);
    snprintf(want, sizeof want, "ioctl(700,%d,10) ", SIOCGIFFLAGS);
    EXPECT_CALLS("of the library", want);
}

/* --- descriptors --- */

static void closes_and_copies(void **state)
{
    (void)state;
    plan("close", -1, EIO);
    assert_int_equal(call_close(PORT), -1);
    EXPECT_CALLS("close", "closed(700,700) close(700) ");
    (void)call_close(0);
    EXPECT_CALLS("close the first", "closed(0,0) close(0) ");
    (void)call_close(-1);
    EXPECT_CALLS("close none", "close(-1) ");
    plan("dup", 0, 0);
    assert_int_equal(call_dup(PORT), 0);
    EXPECT_CALLS("dup", "dup(700) copied(700,0) ");
    plan("dup", -1, EMFILE);
    assert_int_equal(call_dup(OTHER), -1);
    EXPECT_CALLS("dup that fails", "dup(5) ");
    ect_inside = 1;
    (void)call_close(PORT);
    (void)call_dup(PORT);
    EXPECT_CALLS("of the library", "close(700) dup(700) ");
}

static void closes_ranges(void **state)
{
    enum { UNSHARE = 2, AT_EXEC = 4, UNKNOWN = 8 };
    (void)state;
    plan("close_range", -1, EINVAL);
    assert_int_equal(ours_close_range(5, 9, 0), -1);
    EXPECT_CALLS("a range", "closed(5,9) close_range(5,9,0) ");
    (void)ours_close_range(5, 9, UNSHARE);
    EXPECT_CALLS("of a thread of its own", "closed(5,9) close_range(5,9,2) ");
    (void)ours_close_range(5, 9, AT_EXEC);
    (void)ours_close_range(5, 9, UNKNOWN);
    EXPECT_CALLS("at exec; a flag that there is not", "close_range(5,9,4) close_range(5,9,8) ");
    ours_closefrom(7);
    EXPECT_CALLS("closefrom", "closed(7,4294967295) closefrom(7) ");
    ours_closefrom(-1);
    EXPECT_CALLS("closefrom, all", "closed(0,4294967295) closefrom(-1) ");
    ect_inside = 1;
    (void)ours_close_range(5, 9, 0);
    ours_closefrom(7);
    EXPECT_CALLS("of the library", "close_range(5,9,0) closefrom(7) ");
}

static void copies_to_a_number(void **state)
{
    (void)state;
    plan("dup2", 701, 0);
    assert_int_equal(ours_dup2(PORT, 701), 701);
    EXPECT_CALLS("dup2", "fcntl(700,1,0) closed(701,701) dup2(700,701) copied(700,701) ");
    plan("dup2", 700, 0);
    assert_int_equal(ours_dup2(PORT, PORT), 700);
    EXPECT_CALLS("dup2 to itself", "dup2(700,700) ");
    assert_int_equal(ours_dup3(PORT, 0, O_CLOEXEC), 0);
    EXPECT_CALLS("dup3", "fcntl(700,1,0) closed(0,0) dup3(700,0,524288) copied(700,0) ");
    ect_inside = 1;
    (void)ours_dup2(PORT, 701);
    (void)ours_dup3(PORT, 701, 0);
    EXPECT_CALLS("of the library", "dup2(700,701) dup3(700,701,0) ");
}

static void copies_nothing_over_a_port(void **state)
{
    (void)state;
    plan("fcntl", -1, EBADF);
    plan("dup2", -1, EBADF);
    assert_int_equal(ours_dup2(OTHER, PORT), -1);
    EXPECT_CALLS("dup2 of a closed descriptor", "fcntl(5,1,0) dup2(5,700) ");
    plan("dup2", -1, EBADF);
    assert_int_equal(ours_dup2(PORT, -1), -1);
    EXPECT_CALLS("dup2 to no number", "dup2(700,-1) ");
    plan("fcntl", -1, EBADF);
    plan("dup3", -1, EBADF);
    assert_int_equal(ours_dup3(OTHER, PORT, O_CLOEXEC), -1);
    EXPECT_CALLS("dup3 of a closed descriptor", "fcntl(5,1,0) dup3(5,700,524288) ");
    plan("dup3", -1, EINVAL);
    assert_int_equal(ours_dup3(OTHER, PORT, O_CLOEXEC | 8), -1);
    EXPECT_CALLS("dup3 with an unknown flag", "dup3(5,700,524296) ");
    plan("dup3", -1, EINVAL);
    assert_int_equal(ours_dup3(PORT, PORT, 0), -1);
    EXPECT_CALLS("dup3 to itself", "dup3(700,700,0) ");
}

static void controls_descriptors(void **state)
{
    static const int copies[] = {F_DUPFD, F_DUPFD_CLOEXEC};
    char want[64];
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        plan("fcntl", 0, 0);
        assert_int_equal(ours_fcntl(PORT, copies[i], 10L), 0);
        snprintf(want, sizeof want, "fcntl(700,%d,10) copied(700,0) ", copies[i]);
        EXPECT_CALLS("a copy", want);
        plan("fcntl", 9, 0);
        assert_int_equal(ours_fcntl64(OTHER, copies[i], 10L), 9);
        snprintf(want, sizeof want, "fcntl(5,%d,10) copied(5,9) ", copies[i]);
        EXPECT_CALLS("a copy of another", want);
        plan("fcntl", -1, EMFILE);
        assert_int_equal(ours_fcntl64(PORT, copies[i], 10L), -1);
        snprintf(want, sizeof want, "fcntl(700,%d,10) ", copies[i]);
        EXPECT_CALLS("no copy", want);
    }
    for (long flags = 0; flags <= O_NONBLOCK; flags += O_NONBLOCK) {
        plan("fcntl", 0, 0);
        assert_int_equal(ours_fcntl(PORT, F_SETFL, flags | O_APPEND), 0);
        snprintf(want, sizeof want, "fcntl(700,%d,%ld) port_set_nonblocking(700,%d) ", F_SETFL, flags | O_APPEND,
                 flags != 0);
        EXPECT_CALLS("flags", want);
    }
    plan("fcntl", -1, EPERM);
    assert_int_equal(ours_fcntl(PORT, F_SETFL, (long)O_NONBLOCK), -1);
    snprintf(want, sizeof want, "fcntl(700,%d,%d) ", F_SETFL, O_NONBLOCK);
    EXPECT_CALLS("refused", want);
    plan("fcntl", 3, 0);
    assert_int_equal(ours_fcntl(PORT, F_GETFL, 0L), 3);
    snprintf(want, sizeof want, "fcntl(700,%d,0) ", F_GETFL);
    EXPECT_CALLS("a question", want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("A call on a socket of the bus reaches its port, another the C library", passes_calls_on),
        TEST("A fortified read of more bytes than there is room for reaches the C library's check", checks_the_room),
        TEST("recv(2): a call ends with the wait for another descriptor", ends_with_the_wait),
        TEST("A raw packet socket is one of the bus", opens_raw_packet_sockets),
        TEST("A message is sent in its pieces, to its address", sends_pieces),
        TEST("Messages are sent up to the first that fails", sends_messages),
        TEST("More than 1024 pieces are refused", limits_the_number_of_pieces),
        TEST("Control data must be readable", reads_control_data),
        TEST("A result that cannot be stored is EFAULT, or ends a series of messages",
             stores_results_at_good_addresses),
        TEST("A received message has flags, length of its address, and no control data", receives_a_message),
        TEST("Messages are received up to the first that is missing", receives_messages),
        TEST("accept waits on the virtual clock first", accepts_after_waiting),
        TEST("FIONBIO switches the port and its descriptor", switches_blocking),
        TEST("Requests go to interfaces of the bus, on a socket of any kind", executes_requests),
        TEST("A port and a timer are closed and copied with their descriptors", closes_and_copies),
        TEST("close_range() and closefrom() close the ports of a range, not at exec", closes_ranges),
        TEST("dup2 and dup3 close the number that they take", copies_to_a_number),
        TEST("dup2 and dup3 that fail leave the number open", copies_nothing_over_a_port),
        TEST("fcntl copies ports and sets whether they block", controls_descriptors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
