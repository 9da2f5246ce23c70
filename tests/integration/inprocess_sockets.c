/* SPDX-License-Identifier: MIT */
/*
 * Bounds and errors of packet sockets against twins in this process: the calls that a kernel would refuse, truncate or
 * leave unchanged. usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_sockets {} real|virtual
 * [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <fcntl.h>
#include <net/if_arp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

enum { ALL = 0x0003, HEADER = 14, LONGEST = 1518, WAITING_MOST = 256 };
enum { TX_RING = 13, FANOUT = 18 }; /* PACKET_TX_RING and PACKET_FANOUT of Linux */

static int open_unbound(void)
{
    int fd = socket(AF_PACKET, SOCK_RAW, htons(ETHERCAT));
    assert_true(fd >= 0);
    return fd;
}

static struct sockaddr_ll address_of(unsigned int index)
{
    return (struct sockaddr_ll){.sll_family = AF_PACKET, .sll_protocol = htons(ETHERCAT), .sll_ifindex = (int)index};
}

/* @return whether a frame is there; it is taken */
static bool receives(int fd)
{
    uint8_t frame[FRAME];
    return recv(fd, frame, sizeof frame, MSG_DONTWAIT) == FRAME;
}

/* --- binding ------------------------------------------------------------------------------------------------------ */

static void binding(void **state)
{
    const size_t shortest = offsetof(struct sockaddr_ll, sll_addr);
    const unsigned int index = if_nametoindex(interface);
    struct sockaddr_ll right = address_of(index), family = right;
    family.sll_family = AF_INET;
    struct sockaddr_ll foreign = address_of(index + 1), below = address_of(index - 1), none = address_of(0);
    const struct {
        const struct sockaddr_ll *to;
        size_t length;
        int error;
    } rows[] = {{&right, shortest - 1, EINVAL}, {&family, sizeof family, EINVAL}, {&foreign, sizeof foreign, ENODEV},
                {&below, sizeof below, ENODEV}, {&none, sizeof none, ENODEV},     {&right, shortest, 0},
                {&right, sizeof right, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int fd = open_unbound();
        int result = bind(fd, (const struct sockaddr *)rows[i].to, (socklen_t)rows[i].length);
        if (result != (rows[i].error != 0 ? -1 : 0) || (result < 0 && errno != rows[i].error))
            fail_msg("row %zu: got %d, %s", i, result, strerror(errno));
        if (result == 0) {
            send_one(fd, 1);
            assert_true(receives(fd));
        }
        close(fd);
    }
}

/* A socket receives frames of its type, or all; bind() changes the type, unless it names none. */
static void types_of_frames(void **state)
{
    static const struct {
        uint16_t open, bind;
        bool comes;
    } rows[] = {{ETHERCAT, 0, true},      {ETHERCAT, ETHERCAT, true}, {ETHERCAT, 0x88A5, false},
                {0x0800, ETHERCAT, true}, {0x0800, 0, false},         {ALL, 0, true},
                {0x0800, ALL, true}};
    int sender = open_socket(0);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct sockaddr_ll to = address_of(if_nametoindex(interface)), its;
        socklen_t length = sizeof its;
        int fd = socket(AF_PACKET, SOCK_RAW, htons(rows[i].open));
        to.sll_protocol = htons(rows[i].bind);
        assert_int_equal(bind(fd, (struct sockaddr *)&to, sizeof to), 0);
        send_one(sender, 1);
        assert_true(receives(sender));
        assert_int_equal(receives(fd), rows[i].comes);
        assert_int_equal(getsockname(fd, (struct sockaddr *)&its, &length), 0);
        assert_int_equal(ntohs(its.sll_protocol), rows[i].bind != 0 ? rows[i].bind : rows[i].open);
        close(fd);
    }
    close(sender);
}

/* A second bind() keeps one place in the list of sockets: a frame comes once. */
static void bound_twice(void **state)
{
    const struct sockaddr_ll to = address_of(if_nametoindex(interface));
    int fd = open_socket(0), other = open_socket(0);
    (void)state;
    assert_int_equal(bind(fd, (const struct sockaddr *)&to, sizeof to), 0);
    send_one(fd, 1);
    assert_true(receives(fd) && !receives(fd) && receives(other) && !receives(other));
    close(fd);
    send_one(other, 2);
    assert_true(receives(other));
    close(other);
}

/* --- sending ------------------------------------------------------------------------------------------------------ */

static void lengths_of_frames(void **state)
{
    static const struct {
        size_t length;
        int error;
    } rows[] = {{0, EINVAL}, {HEADER - 1, EINVAL}, {LONGEST, 0}, {LONGEST + 1, EMSGSIZE}, {60, 0}};
    uint8_t frame[LONGEST + 1] = {0};
    int fd = open_socket(0);
    (void)state;
    frame_of(frame, 1);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ssize_t sent = send(fd, frame, rows[i].length, 0);
        if (sent != (rows[i].error != 0 ? -1 : (ssize_t)rows[i].length) || (sent < 0 && errno != rows[i].error))
            fail_msg("%zu bytes: got %zd, %s", rows[i].length, sent, strerror(errno));
        if (sent > 0)
            assert_int_equal(recv(fd, frame, 0, MSG_TRUNC | MSG_DONTWAIT), rows[i].length);
    }
    assert_false(receives(fd));
    close(fd);
}

/* The pieces of a call are one frame; one piece too many is too long. */
static void pieces_that_are_sent(void **state)
{
    uint8_t frame[FRAME], more[LONGEST] = {0};
    struct iovec pieces[] = {{frame, 1}, {frame + 1, 0}, {frame + 1, 30}, {frame + 31, FRAME - 31}, {more, LONGEST}};
    struct msghdr message = {.msg_iov = pieces, .msg_iovlen = 4};
    int fd = open_socket(0);
    (void)state;
    frame_of(frame, 5);
    assert_int_equal(writev(fd, pieces, 4), FRAME);
    assert_reply(more, recv(fd, more, sizeof more, MSG_DONTWAIT), 5);
    assert_int_equal(sendmsg(fd, &message, 0), FRAME);
    assert_reply(more, recv(fd, more, sizeof more, MSG_DONTWAIT), 5);
    pieces[4].iov_len = LONGEST - FRAME;
    assert_int_equal(writev(fd, pieces, 5), LONGEST);
    assert_int_equal(recv(fd, more, sizeof more, MSG_DONTWAIT), LONGEST);
    pieces[4].iov_len++;
    assert_int_equal(writev(fd, pieces, 5), -1);
    assert_int_equal(errno, EMSGSIZE);
    close(fd);
}

/* Calls with a buffer, a list or a value at address 0; the socket has a waiting frame. */
typedef ssize_t bad_call_t(int fd, void *nowhere);

static ssize_t bad_send(int fd, void *nowhere)
{
    return send(fd, nowhere, FRAME, 0);
}

static ssize_t bad_write(int fd, void *nowhere)
{
    return write(fd, nowhere, FRAME);
}

static ssize_t bad_writev(int fd, void *nowhere)
{
    return writev(fd, nowhere, 2);
}

static ssize_t bad_piece(int fd, void *nowhere)
{
    uint8_t frame[FRAME];
    const struct iovec pieces[] = {{frame, 20}, {nowhere, FRAME - 20}};
    frame_of(frame, 1);
    return writev(fd, pieces, 2);
}

static ssize_t bad_sendmsg(int fd, void *nowhere)
{
    return sendmsg(fd, nowhere, 0);
}

static ssize_t bad_sendmmsg(int fd, void *nowhere)
{
    return sendmmsg(fd, nowhere, 1, 0);
}

static ssize_t bad_list_of_message(int fd, void *nowhere)
{
    const struct msghdr message = {.msg_iov = nowhere, .msg_iovlen = 1};
    return sendmsg(fd, &message, 0);
}

static ssize_t bad_recv(int fd, void *nowhere)
{
    return recv(fd, nowhere, FRAME, MSG_DONTWAIT);
}

static ssize_t bad_read(int fd, void *nowhere)
{
    return read(fd, nowhere, FRAME);
}

static ssize_t bad_readv(int fd, void *nowhere)
{
    uint8_t frame[FRAME];
    const struct iovec pieces[] = {{frame, 20}, {nowhere, FRAME - 20}};
    return readv(fd, pieces, 2);
}

static ssize_t bad_recvmsg(int fd, void *nowhere)
{
    return recvmsg(fd, nowhere, MSG_DONTWAIT);
}

static ssize_t bad_recvmmsg(int fd, void *nowhere)
{
    return recvmmsg(fd, nowhere, 1, MSG_DONTWAIT, NULL);
}

static ssize_t bad_bind(int fd, void *nowhere)
{
    return bind(fd, nowhere, sizeof(struct sockaddr_ll));
}

static ssize_t bad_name(int fd, void *nowhere)
{
    socklen_t length = sizeof(struct sockaddr_ll);
    return getsockname(fd, nowhere, &length);
}

static ssize_t bad_setsockopt(int fd, void *nowhere)
{
    return setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, nowhere, sizeof(struct timeval));
}

static ssize_t bad_getsockopt(int fd, void *nowhere)
{
    socklen_t length = sizeof(int);
    return getsockopt(fd, SOL_SOCKET, SO_TYPE, nowhere, &length);
}

static ssize_t bad_length(int fd, void *nowhere)
{
    int type;
    return getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, nowhere);
}

static ssize_t bad_ioctl(int fd, void *nowhere)
{
    return ioctl(fd, FIONBIO, nowhere);
}

static ssize_t bad_poll(int fd, void *nowhere)
{
    (void)fd;
    return poll(nowhere, 1, 0);
}

static void an_address_of_0_is_refused(void **state)
{
    static const struct {
        const char *title;
        bad_call_t *call;
        bool loses; /* the waiting frame is lost, as with a kernel */
    } rows[] = {{"send", bad_send, false},
                {"write", bad_write, false},
                {"writev", bad_writev, false},
                {"a piece of writev", bad_piece, false},
                {"sendmsg", bad_sendmsg, false},
                {"sendmmsg", bad_sendmmsg, false},
                {"the list of sendmsg", bad_list_of_message, false},
                {"recv", bad_recv, true},
                {"read", bad_read, true},
                {"a piece of readv", bad_readv, true},
                {"recvmsg", bad_recvmsg, false},
                {"recvmmsg", bad_recvmmsg, false},
                {"bind", bad_bind, false},
                {"getsockname", bad_name, false},
                {"setsockopt", bad_setsockopt, false},
                {"getsockopt", bad_getsockopt, false},
                {"the length of getsockopt", bad_length, false},
                {"FIONBIO", bad_ioctl, false},
                {"poll", bad_poll, false}};
    void *volatile nowhere = NULL;
    int fd = open_socket(0);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        send_one(fd, 1);
        errno = 0;
        ssize_t result = rows[i].call(fd, nowhere);
        if (result != -1 || errno != EFAULT)
            fail_msg("%s: got %zd, %s", rows[i].title, result, strerror(errno));
        if (receives(fd) == rows[i].loses || receives(fd))
            fail_msg("%s: the waiting frame", rows[i].title);
    }
    close(fd);
}

/* An address names the interface of a socket that is not bound, or another one than its own. */
static void sent_to_an_address(void **state)
{
    const unsigned int index = if_nametoindex(interface);
    uint8_t frame[FRAME];
    struct sockaddr_ll to = address_of(index);
    struct iovec piece = {.iov_base = frame, .iov_len = sizeof frame};
    struct msghdr message = {.msg_name = &to, .msg_namelen = sizeof to, .msg_iov = &piece, .msg_iovlen = 1};
    struct mmsghdr many = {.msg_hdr = message};
    int unbound = open_unbound(), fd = open_socket(0);
    (void)state;
    frame_of(frame, 1);
    assert_int_equal(sendto(unbound, frame, FRAME, 0, (struct sockaddr *)&to, sizeof to), FRAME);
    assert_true(receives(fd) && !receives(unbound));
    assert_int_equal(sendmsg(unbound, &message, 0), FRAME);
    assert_true(receives(fd));
    assert_int_equal(sendmmsg(unbound, &many, 1, 0), 1);
    assert_true(receives(fd));
    to.sll_ifindex = (int)index + 1;
    assert_int_equal(sendto(fd, frame, FRAME, 0, (struct sockaddr *)&to, sizeof to), -1);
    assert_int_equal(errno, ENXIO);
    assert_int_equal(sendmmsg(fd, &many, 1, 0), -1);
    assert_int_equal(errno, ENXIO);
    assert_false(receives(fd));
    close(unbound);
    close(fd);
}

/* sendmmsg() and recvmmsg() return the messages before the first that fails. */
static void many_until_one_fails(void **state)
{
    uint8_t frames[3][FRAME];
    struct iovec pieces[3];
    struct mmsghdr messages[3];
    int fd = open_socket(0);
    (void)state;
    memset(messages, 0, sizeof messages);
    for (uint8_t i = 0; i < 3; i++) {
        frame_of(frames[i], i);
        pieces[i] = (struct iovec){.iov_base = frames[i], .iov_len = i < 2 ? FRAME : 3};
        messages[i].msg_hdr = (struct msghdr){.msg_iov = &pieces[i], .msg_iovlen = 1};
    }
    assert_int_equal(sendmmsg(fd, messages, 3, 0), 2);
    assert_int_equal(sendmmsg(fd, messages + 2, 1, 0), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(sendmmsg(fd, messages + 1, 2, 0), 1);
    assert_int_equal(recvmmsg(fd, messages, 2, MSG_WAITFORONE, NULL), 2);
    assert_int_equal(recvmmsg(fd, messages, 3, MSG_WAITFORONE, NULL), 1);
    frame_of(frames[0], 0);
    frame_of(frames[1], 1);
    assert_int_equal(sendmmsg(fd, messages, 2, 0), 2);
    pieces[2].iov_len = FRAME;
    assert_int_equal(recvmmsg(fd, messages, 3, MSG_DONTWAIT, NULL), 2);
    assert_reply(frames[0], messages[0].msg_len, 0);
    assert_reply(frames[1], messages[1].msg_len, 1);
    assert_int_equal(recvmmsg(fd, messages, 3, MSG_DONTWAIT, NULL), -1);
    assert_int_equal(errno, EAGAIN);
    assert_int_equal(sendmmsg(fd, messages, 3, 0), 3);
    assert_int_equal(recvmmsg(fd, messages, 2, 0, NULL), 2);
    assert_true(receives(fd) && !receives(fd));
    close(fd);
}

/* --- receiving ---------------------------------------------------------------------------------------------------- */

/* A socket that is full loses the next frames, as in the kernel; others do not. */
static void full_sockets(void **state)
{
    int fd = open_socket(0), other = open_socket(0);
    unsigned int came = 0, others = 0;
    (void)state;
    for (unsigned int i = 0; i < WAITING_MOST + 2; i++) {
        send_one(fd, (uint8_t)i);
        others += receives(other);
    }
    for (; receives(fd); came++)
        ;
    assert_int_equal(came, WAITING_MOST);
    assert_int_equal(others, WAITING_MOST + 2);
    send_one(fd, 1); /* there is room again */
    assert_true(receives(fd));
    close(fd);
    close(other);
}

/* Each call truncates a frame to its buffer, and does not change the bytes behind it. */
static void cut_frames(void **state)
{
    int fd = open_socket(0);
    (void)state;
    for (unsigned int call = 0; call < 4; call++) {
        uint8_t room[FRAME + 1];
        struct iovec piece = {.iov_base = room, .iov_len = 20};
        struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1, .msg_flags = 0x77};
        memset(room, 0xEE, sizeof room);
        send_one(fd, 9);
        ssize_t got = call == 0   ? recv(fd, room, 20, 0)
                      : call == 1 ? recvfrom(fd, room, 20, 0, NULL, NULL)
                      : call == 2 ? recvmsg(fd, &message, 0)
                                  : recvmsg(fd, &message, MSG_TRUNC);
        assert_int_equal(got, call == 3 ? FRAME : 20);
        assert_true(room[17] == 9 && room[20] == 0xEE);
        if (call >= 2)
            assert_int_equal(message.msg_flags, MSG_TRUNC);
        assert_int_equal(message.msg_namelen, 0);
        assert_false(receives(fd));
    }
    close(fd);
}

/* An address is cut to the room of the caller, whose length is then the whole one. */
static void cut_addresses(void **state)
{
    int fd = open_socket(0);
    (void)state;
    for (unsigned int call = 0; call < 3; call++) {
        uint8_t its[sizeof(struct sockaddr_ll)], frame[FRAME];
        struct iovec piece = {.iov_base = frame, .iov_len = sizeof frame};
        struct msghdr message = {.msg_name = its, .msg_namelen = 4, .msg_iov = &piece, .msg_iovlen = 1};
        socklen_t length = 4;
        memset(its, 0xEE, sizeof its);
        send_one(fd, 1);
        if (call == 0)
            assert_int_equal(recvfrom(fd, frame, sizeof frame, 0, (struct sockaddr *)its, &length), FRAME);
        else if (call == 1)
            assert_int_equal(recvmsg(fd, &message, 0), FRAME);
        else
            assert_int_equal(getsockname(fd, (struct sockaddr *)its, &length), 0);
        assert_int_equal(call == 1 ? message.msg_namelen : length, sizeof its);
        assert_true(its[0] == AF_PACKET && its[4] == 0xEE);
    }
    close(fd);
    struct sockaddr_ll its;
    socklen_t length = sizeof its;
    fd = open_unbound();
    assert_int_equal(getsockname(fd, (struct sockaddr *)&its, &length), 0);
    assert_int_equal(its.sll_ifindex, 0);
    close(fd);
}

/* O_NONBLOCK shows and ends as it was set, by each call. */
static void modes(void **state)
{
    const struct timeval soon = {.tv_usec = 1000};
    int on = 1, off = 0;
    int fd = open_socket(SOCK_NONBLOCK | SOCK_CLOEXEC);
    (void)state;
    assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, O_NONBLOCK);
    assert_int_equal(fcntl(fd, F_GETFD), FD_CLOEXEC);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &soon, sizeof soon), 0);
    for (unsigned int i = 0; i < 5; i++) {
        uint8_t frame[FRAME];
        const bool waits = i == 1 || i == 3;
        assert_int_equal(i == 1   ? fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) & ~O_NONBLOCK)
                         : i == 2 ? ioctl(fd, FIONBIO, &on)
                         : i == 3 ? ioctl(fd, FIONBIO, &off)
                         : i == 4 ? fcntl(fd, F_SETFL, O_RDWR | O_NONBLOCK)
                                  : 0,
                         0);
        assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, waits ? 0 : O_NONBLOCK);
        uint64_t since_ns = now_ns();
        assert_int_equal(recv(fd, frame, sizeof frame, 0), -1);
        assert_int_equal(errno, EAGAIN);
        assert_took(since_ns, waits ? MS : 0);
    }
    close(fd);
    fd = open_socket(0);
    assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, 0);
    assert_int_equal(fcntl(fd, F_GETFD), 0);
    close(fd);
}

/* Buffers in shared memory are refused, so that the master receives by calls; a short value is cut. */
static void options(void **state)
{
    static const struct {
        int level, name, error;
    } rows[] = {{SOL_PACKET, PACKET_RX_RING, ENOPROTOOPT}, {SOL_PACKET, TX_RING, ENOPROTOOPT},
                {SOL_PACKET, FANOUT, ENOPROTOOPT},         {SOL_PACKET, PACKET_ADD_MEMBERSHIP, 0},
                {SOL_SOCKET, PACKET_RX_RING, 0},           {SOL_SOCKET, SO_PRIORITY, 0}};
    int fd = open_socket(0), value = 7;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int result = setsockopt(fd, rows[i].level, rows[i].name, &value, sizeof value);
        if (result != (rows[i].error != 0 ? -1 : 0) || (result < 0 && errno != rows[i].error))
            fail_msg("row %zu: got %d, %s", i, result, strerror(errno));
    }
    const struct timeval time = {.tv_sec = 3};
    struct timeval got = {0};
    socklen_t length = sizeof got;
    assert_int_equal(setsockopt(fd, SOL_PACKET, SO_RCVTIMEO, &time, sizeof time), 0);     /* another option */
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &time, sizeof time - 1), 0); /* too short */
    assert_int_equal(getsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &got, &length), 0);
    assert_int_equal(got.tv_sec, 0);
    uint8_t bytes[4] = {0xEE, 0xEE, 0xEE, 0xEE};
    length = 2;
    assert_int_equal(getsockopt(fd, SOL_SOCKET, SO_TYPE, bytes, &length), 0);
    assert_true(length == 2 && bytes[0] == SOCK_RAW && bytes[1] == 0 && bytes[2] == 0xEE);
    close(fd);
}

/* --- interfaces --------------------------------------------------------------------------------------------------- */

/* A socket of any kind gets the reply; another name is the machine's. */
static void requests_about_interfaces(void **state)
{
    static const unsigned long requests[] = {SIOCGIFINDEX,  SIOCGIFFLAGS, SIOCGIFMTU,
                                             SIOCGIFHWADDR, SIOCSIFMTU,   SIOCSIFFLAGS};
    (void)state;
    for (unsigned int kind = 0; kind < 2; kind++) {
        int fd = kind == 0 ? open_unbound() : socket(AF_INET, SOCK_DGRAM, 0);
        for (size_t i = 0; i < sizeof requests / sizeof requests[0]; i++) {
            struct ifreq its = {0};
            strncpy(its.ifr_name, interface, IFNAMSIZ - 1);
            its.ifr_flags = IFF_UP;
            assert_int_equal(ioctl(fd, requests[i], &its), 0);
            if (requests[i] == SIOCGIFHWADDR)
                assert_int_equal(its.ifr_hwaddr.sa_family, ARPHRD_ETHER);
            if (requests[i] == SIOCGIFFLAGS)
                assert_int_equal(its.ifr_flags, IFF_BROADCAST | IFF_PROMISC | IFF_MULTICAST | IFF_UP | IFF_RUNNING);
            strcpy(its.ifr_name, "no-such-one");
            assert_int_equal(ioctl(fd, requests[i], &its), -1);
            assert_true(errno == ENODEV || errno == EPERM);
        }
        close(fd);
    }
    int fd = open_unbound();
    assert_int_equal(ioctl(fd, SIOCGIFINDEX, NULL), -1);
    assert_int_equal(errno, EFAULT);
    close(fd);
}

static void names_of_interfaces(void **state)
{
    char name[IF_NAMESIZE] = "unchanged";
    const unsigned int index = if_nametoindex(interface);
    (void)state;
    assert_true(index > 0);
    assert_int_equal(if_nametoindex("no-such-one"), 0);
    assert_ptr_equal(if_indextoname(index, name), name);
    assert_string_equal(name, interface);
    assert_null(if_indextoname(index + 1, name)); /* the other end of the chain has no name here */
    assert_null(if_indextoname(0, name));
    unsigned int loopback = if_nametoindex("lo");
    if (loopback != 0) {
        assert_string_equal(if_indextoname(loopback, name), "lo");
        bool first = false;
        struct if_nameindex *all = if_nameindex();
        for (const struct if_nameindex *one = all; one->if_index != 0; one++)
            first |= one->if_index == loopback && strcmp(one->if_name, "lo") == 0;
        if_freenameindex(all);
        assert_true(first);
    }
    if_freenameindex(NULL);
}

/* --- descriptors -------------------------------------------------------------------------------------------------- */

/* dup2() and dup3() close a socket whose descriptor they take; equal descriptors are left alone. */
static void taken_descriptors(void **state)
{
    int fd = open_socket(0), other = open_socket(0), third = open_socket(0);
    (void)state;
    assert_int_equal(dup2(fd, fd), fd);
    assert_int_equal(dup3(fd, fd, 0), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(dup2(fd, other), other);
    assert_int_equal(dup3(fd, third, O_CLOEXEC), third);
    send_one(other, 3);
    assert_true(receives(third) && !receives(fd) && !receives(other)); /* one socket */
    close(fd);
    close(other);
    send_one(third, 4);
    assert_true(receives(third));
    assert_int_equal(dup2(STDERR_FILENO, third), third); /* no socket any more */
    assert_int_equal(write(third, "", 0), 0);
    assert_int_equal(dup2(77777, third), -1);
    assert_int_equal(dup(77777), -1);
    close(third);
    fd = open_socket(0);
    assert_int_equal(fcntl(fd, F_DUPFD, -1), -1);
    send_one(fd, 5);
    assert_true(receives(fd));
    close(fd);
    assert_int_equal(close(fd), -1);
    assert_int_equal(errno, EBADF);
}

/* The first descriptor of a socket may be closed before its copies: a copy shows frames then. */
static void closed_before_its_copies(void **state)
{
    int fd = open_socket(0);
    int copies[] = {dup(fd), dup(fd)};
    (void)state;
    close(fd);
    for (size_t i = 0; i < 2; i++) {
        struct pollfd one = {.fd = copies[1], .events = POLLIN};
        assert_int_equal(poll(&one, 1, 0), 0);
        send_one(copies[1], (uint8_t)i);
        assert_int_equal(poll(&one, 1, 1000), 1);
        assert_int_equal(one.revents, POLLIN);
        assert_true(receives(copies[1]));
        assert_int_equal(poll(&one, 1, 0), 0);
        if (i == 0)
            close(copies[0]);
    }
    close(copies[1]);
}

/* A copy may have any number, 0 too. */
static void copied_to_descriptor_0(void **state)
{
    int fd = open_socket(0), input = dup(STDIN_FILENO);
    (void)state;
    assert_int_equal(dup2(fd, STDIN_FILENO), STDIN_FILENO);
    close(fd);
    send_one(STDIN_FILENO, 1);
    assert_true(receives(STDIN_FILENO));
    if (input >= 0) {
        assert_int_equal(dup2(input, STDIN_FILENO), STDIN_FILENO);
        close(input);
    } else {
        close(STDIN_FILENO);
    }
}

/* The next file gets the number of a closed socket, and no frames, neither after copies nor after a failed one. */
static void closed_with_its_copies(void **state)
{
    int other = open_socket(0);
    (void)state;
    for (unsigned int i = 0; i < 3; i++) {
        uint64_t count;
        int fd = open_socket(0);
        int copy = i == 0 ? dup(fd) : i == 1 ? dup2(fd, -1) : fcntl(fd, F_DUPFD, -1);
        assert_int_equal(copy >= 0, i == 0);
        if (copy >= 0)
            close(copy);
        close(fd);
        int event = eventfd(0, EFD_NONBLOCK);
        assert_int_equal(event, fd);
        send_one(other, 1);
        assert_true(receives(other));
        assert_int_equal(read(event, &count, sizeof count), -1);
        assert_int_equal(errno, EAGAIN);
        close(event);
    }
    close(other);
}

/* Unread frames end with their socket; a descriptor above all others is refused. */
static void ends_of_sockets(void **state)
{
    int fd = open_socket(0);
    (void)state;
    for (unsigned int i = 0; i < 10; i++)
        send_one(fd, (uint8_t)i);
    close(fd);
    fd = open_socket(0);
    assert_false(receives(fd));
    close(fd);
    for (unsigned int i = 0; i < 100; i++) {
        int one = open_unbound();
        assert_int_equal(one, fd); /* none is left open */
        close(one);
    }
}

/* Other sockets are the machine's: frames of no other kind reach the twins. */
static void other_sockets(void **state)
{
    int pair[2], number = 0;
    socklen_t length = sizeof number;
    char text[8] = "";
    struct sockaddr_storage its;
    struct iovec piece = {.iov_base = text, .iov_len = sizeof text};
    struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1};
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
    assert_int_equal(getsockopt(pair[0], SOL_SOCKET, SO_TYPE, &number, &length), 0);
    assert_int_equal(number, SOCK_STREAM);
    number = 1;
    assert_int_equal(setsockopt(pair[0], SOL_SOCKET, SO_PASSCRED, &number, sizeof number), 0);
    length = sizeof its;
    assert_int_equal(getsockname(pair[0], (struct sockaddr *)&its, &length), 0);
    assert_int_equal(its.ss_family, AF_UNIX);
    assert_int_equal(send(pair[0], "send", 4, 0), 4);
    assert_int_equal(recv(pair[1], text, sizeof text, 0), 4);
    assert_int_equal(sendto(pair[0], "to", 2, 0, NULL, 0), 2);
    assert_int_equal(recvfrom(pair[1], text, sizeof text, 0, NULL, NULL), 2);
    piece.iov_len = 3;
    assert_int_equal(sendmsg(pair[0], &message, 0), 3);
    assert_int_equal(recvmsg(pair[1], &message, 0), 3);
    assert_int_equal(writev(pair[0], &piece, 1), 3);
    assert_int_equal(readv(pair[1], &piece, 1), 3);
    assert_int_equal(recv(pair[1], text, 1, MSG_DONTWAIT), -1);
    assert_int_equal(errno, EAGAIN);
    close(pair[0]);
    assert_int_equal(read(pair[1], text, 1), 0);
    close(pair[1]);
    int fd = socket(AF_PACKET, SOCK_DGRAM, htons(ETHERCAT)); /* of the machine, if that allows it */
    if (fd >= 0) {
        const struct sockaddr_ll to = address_of(if_nametoindex(interface));
        assert_int_equal(bind(fd, (const struct sockaddr *)&to, sizeof to), -1);
        close(fd);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"bind: a short address, another family, a foreign interface: the kernel's errors", binding, NULL, NULL, NULL},
        {"A socket receives frames of the type of socket or bind, or all", types_of_frames, NULL, NULL, NULL},
        {"A socket that is bound twice receives a frame once", bound_twice, NULL, NULL, NULL},
        {"A buffer, a list or a value at address 0 is refused with EFAULT", an_address_of_0_is_refused, NULL, NULL,
         NULL},
        {"A frame has 14 to 1518 bytes", lengths_of_frames, NULL, NULL, NULL},
        {"The pieces of writev and sendmsg are one frame", pieces_that_are_sent, NULL, NULL, NULL},
        {"An address selects the interface, for a socket that is not bound too", sent_to_an_address, NULL, NULL, NULL},
        {"sendmmsg and recvmmsg return the messages before the first that fails", many_until_one_fails, NULL, NULL,
         NULL},
        {"A socket holds 256 frames and loses the next ones", full_sockets, NULL, NULL, NULL},
        {"A frame is cut to the room of the call", cut_frames, NULL, NULL, NULL},
        {"An address is cut to the room of the caller", cut_addresses, NULL, NULL, NULL},
        {"O_NONBLOCK by socket, fcntl and FIONBIO, on and off", modes, NULL, NULL, NULL},
        {"Options: shared buffers are refused, others accepted, values cut", options, NULL, NULL, NULL},
        {"Requests about an interface by a socket of any kind", requests_about_interfaces, NULL, NULL, NULL},
        {"Names and numbers of interfaces, the machine's too", names_of_interfaces, NULL, NULL, NULL},
        {"dup2 and dup3 close the socket whose descriptor they take", taken_descriptors, NULL, NULL, NULL},
        {"A copy of a descriptor shows frames after the first one was closed", closed_before_its_copies, NULL, NULL,
         NULL},
        {"A copy of a socket with descriptor 0 sends and receives", copied_to_descriptor_0, NULL, NULL, NULL},
        {"The descriptor of a closed socket is free, whatever copies it had", closed_with_its_copies, NULL, NULL, NULL},
        {"Unread frames and descriptors end with their socket", ends_of_sockets, NULL, NULL, NULL},
        {"Other sockets are the machine's", other_sockets, NULL, NULL, NULL},
    };
    if (!is_started(argc, argv))
        return 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
