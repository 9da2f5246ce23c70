/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/ports.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"
#include "bus/library.h"

enum {
    DESCRIPTORS = 65536,
    WAITING_MOST = 1024, /* limit of waiting frames; as in the kernel, a full socket drops further ones */
    HEADER = 14,
    TAG = 4,
    LONGEST = 1518,
};

typedef struct waiting {
    struct waiting *next;
    size_t length;
    uint8_t frame[ECTWIN_FRAME_MAX];
} waiting_t;

struct ect_port {
    ect_port_t *next; /* next bound socket */
    int fd;           /* the original eventfd */
    unsigned int descriptors;
    int end;           /* -1: not bound */
    uint16_t protocol; /* network order */
    uint64_t timeout_ns;
    bool nonblocking;
    waiting_t *first, **last;
    waiting_t *spare; /* memory of received frames for the next ones: a master exchanges millions */
    size_t count;
    bool fresh; /* a frame has arrived since the last write to the eventfd */
    bool shown; /* the eventfd is readable */
};

static ect_port_t *by_descriptor[DESCRIPTORS];
static ect_port_t *bound;

ect_port_t *ect_port_of(int fd)
{
    return fd >= 0 && fd < DESCRIPTORS ? by_descriptor[fd] : NULL;
}

int ect_port_open(int type, int protocol)
{
    int flags = EFD_NONBLOCK | ((type & SOCK_CLOEXEC) != 0 ? EFD_CLOEXEC : 0);
    ect_port_t *port = calloc(1, sizeof *port);
    int fd = port ? eventfd(0, flags) : -1;
    if (fd < 0 || fd >= DESCRIPTORS) {
        if (fd >= 0)
            REAL(close)(fd);
        free(port);
        errno = fd >= 0 ? EMFILE : errno;
        return -1;
    }
    *port = (ect_port_t){.fd = fd, .descriptors = 1, .end = -1, .protocol = (uint16_t)protocol};
    port->last = &port->first;
    port->nonblocking = (type & SOCK_NONBLOCK) != 0;
    /* The eventfd gets O_NONBLOCK too, because the master may read its flags. */
    if (!port->nonblocking)
        (void)REAL(fcntl)(fd, F_SETFL, O_RDWR);
    ect_time_lock();
    by_descriptor[fd] = port;
    ect_time_unlock();
    return fd;
}

void ect_port_copied(int fd, int copy)
{
    ect_port_t *port = ect_port_of(fd);
    if (!port || copy < 0 || copy >= DESCRIPTORS)
        return;
    ect_time_lock();
    port->descriptors++;
    by_descriptor[copy] = port;
    ect_time_unlock();
}

static void free_list(waiting_t *first)
{
    while (first) {
        waiting_t *next = first->next;
        free(first);
        first = next;
    }
}

static void forget(ect_port_t *port)
{
    for (ect_port_t **at = &bound; *at; at = &(*at)->next) {
        if (*at == port) {
            *at = port->next;
            break;
        }
    }
    free_list(port->first);
    free_list(port->spare);
    free(port);
}

void ect_port_closed(int fd)
{
    ect_port_t *port = ect_port_of(fd);
    if (!port)
        return;
    ect_time_lock();
    by_descriptor[fd] = NULL;
    if (--port->descriptors == 0)
        forget(port);
    else if (port->fd == fd) {
        for (int other = 0; other < DESCRIPTORS; other++) {
            if (by_descriptor[other] == port)
                port->fd = other;
        }
    }
    ect_time_unlock();
}

bool ect_port_has_frame(const ect_port_t *port)
{
    return port->first != NULL;
}

/* The eventfd is written even if readable, because each frame is a new event for edge-triggered epoll. */
static void show(ect_port_t *port)
{
    eventfd_t value;
    if (port->fresh) {
        (void)eventfd_write(port->fd, 1);
        port->shown = true;
    } else if (port->shown && !port->first) {
        (void)!REAL(read)(port->fd, &value, sizeof value);
        port->shown = false;
    }
    port->fresh = false;
}

void ect_ports_show(void)
{
    for (ect_port_t *port = bound; port; port = port->next)
        show(port);
}

static int fail(int error)
{
    errno = error;
    return -1;
}

/* Removes the VLAN tag, as the kernel does before a packet socket gets the frame. */
static size_t without_tag(const uint8_t *frame, size_t length, size_t *tag)
{
    *tag = length >= HEADER + TAG && frame[12] == 0x81 && frame[13] == 0x00 ? TAG : 0;
    return length - *tag;
}

/* @return memory for a frame; NULL: none is left */
static waiting_t *make_waiting(ect_port_t *port)
{
    waiting_t *one = port->spare;
    if (!one)
        return malloc(sizeof *one);
    port->spare = one->next;
    return one;
}

static void deliver(unsigned int end, const uint8_t *frame, size_t length)
{
    size_t tag;
    size_t left = without_tag(frame, length, &tag);
    uint16_t protocol;
    memcpy(&protocol, frame + 12 + tag, sizeof protocol);
    for (ect_port_t *port = bound; port; port = port->next) {
        if (port->end != (int)end || (port->protocol != protocol && port->protocol != htons(ETH_P_ALL)) ||
            port->count >= WAITING_MOST)
            continue;
        waiting_t *one = make_waiting(port);
        if (!one)
            continue;
        one->next = NULL;
        one->length = left;
        memcpy(one->frame, frame, 12);
        memcpy(one->frame + 12, frame + 12 + tag, left - 12);
        *port->last = one;
        port->last = &one->next;
        port->count++;
        port->fresh = true;
        if (!ect_time_is_virtual)
            show(port);
    }
}

/* @return false: the bus cannot be powered on, which is reported */
static bool start_bus(void)
{
    int started = ect_bus_start(ect_time_now(), deliver);
    if (started > 0)
        ect_time_bus_started();
    return started >= 0;
}

bool ect_port_is_up(unsigned int end)
{
    ect_time_lock();
    bool up = ect_bus_is_up(end);
    ect_time_unlock();
    return up;
}

void ect_port_take(unsigned int end, bool up)
{
    ect_time_lock();
    ect_bus_plug(end, up, ect_time_now());
    ect_time_bus_next(ect_time_now());
    ect_time_unlock();
}

static bool read_address(struct sockaddr_ll *to, const struct sockaddr *address, socklen_t length)
{
    return ect_user_read(to, address, length < sizeof *to ? length : sizeof *to);
}

int ect_port_bind(ect_port_t *port, const struct sockaddr *address, socklen_t length)
{
    struct sockaddr_ll to = {0};
    if (!read_address(&to, address, length))
        return fail(EFAULT);
    if (length < offsetof(struct sockaddr_ll, sll_addr) || to.sll_family != AF_PACKET)
        return fail(EINVAL);
    int end = ect_bus_end_of_index(to.sll_ifindex);
    if (end < 0)
        return fail(ENODEV);
    ect_time_lock();
    bool started = start_bus();
    if (started) {
        if (to.sll_protocol != 0)
            port->protocol = to.sll_protocol;
        if (port->end < 0) {
            port->next = bound;
            bound = port;
        }
        port->end = end;
        ect_bus_plug((unsigned int)end, ect_bus_is_up((unsigned int)end), ect_time_now());
        ect_time_bus_next(ect_time_now());
    }
    ect_time_unlock();
    return started ? 0 : fail(ENETDOWN);
}

int ect_port_set(ect_port_t *port, int level, int name, const void *value, socklen_t length)
{
    int number;
    if (level == SOL_SOCKET && name == SO_RCVTIMEO && length >= sizeof(struct timeval)) {
        struct timeval time;
        if (!ect_user_read(&time, value, sizeof time))
            return fail(EFAULT);
        ect_time_lock();
        port->timeout_ns = (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_usec * 1000u;
        ect_time_unlock();
        return 0;
    }
    /* Refused, so that the master uses system calls, as with a kernel without these options. */
    if (level == SOL_PACKET && (name == PACKET_RX_RING || name == PACKET_TX_RING || name == PACKET_FANOUT))
        return fail(ENOPROTOOPT);
    return ect_user_read(&number, value, length < sizeof number ? length : sizeof number) ? 0 : fail(EFAULT);
}

int ect_port_get(ect_port_t *port, int level, int name, void *value, socklen_t *length)
{
    struct timeval time = {.tv_sec = (time_t)(port->timeout_ns / 1000000000u),
                           .tv_usec = (suseconds_t)(port->timeout_ns % 1000000000u / 1000u)};
    int number = 0;
    socklen_t room;
    if (!ect_user_read(&room, length, sizeof room))
        return fail(EFAULT);
    const void *from = &number;
    size_t size = sizeof number;
    if (level == SOL_SOCKET && name == SO_RCVTIMEO) {
        from = &time;
        size = sizeof time;
    } else if (level == SOL_SOCKET && name == SO_TYPE) {
        number = SOCK_RAW;
    } else if (level == SOL_SOCKET && name == SO_DOMAIN) {
        number = AF_PACKET;
    } else if (level == SOL_SOCKET && (name == SO_RCVBUF || name == SO_SNDBUF)) {
        number = 212992;
    }
    room = (socklen_t)(room < size ? room : size);
    return ect_user_write(value, from, room) && ect_user_write(length, &room, sizeof room) ? 0 : fail(EFAULT);
}

/* @return false: a bad address */
static bool put_address(const ect_port_t *port, uint16_t protocol, struct sockaddr *address, socklen_t *length)
{
    struct sockaddr_ll its = {.sll_family = AF_PACKET,
                              .sll_protocol = protocol,
                              .sll_ifindex = port->end >= 0 ? ECT_BUS_INDEX + port->end : 0,
                              .sll_hatype = 1,
                              .sll_pkttype = PACKET_HOST,
                              .sll_halen = 6,
                              .sll_addr = {2, 0, 0, 0, 0, 1}};
    const socklen_t size = sizeof its;
    socklen_t room;
    return ect_user_read(&room, length, sizeof room) && ect_user_write(address, &its, room < size ? room : size) &&
           ect_user_write(length, &size, sizeof size);
}

int ect_port_name(ect_port_t *port, struct sockaddr *address, socklen_t *length)
{
    return put_address(port, port->protocol, address, length) ? 0 : fail(EFAULT);
}

/* AddressSanitizer of the program checks the buffers of frames, as in the functions of the C library. */
void __asan_loadN(const void *address, size_t length) __attribute__((weak));
void __asan_storeN(void *address, size_t length) __attribute__((weak));

/* @return the length, at most `room` + 1; -1: a bad address */
static ssize_t gather(const struct iovec *pieces, size_t count, uint8_t *frame, size_t room)
{
    size_t length = 0;
    for (size_t i = 0; i < count; i++) {
        struct iovec piece;
        if (!ect_user_read(&piece, ect_user_at(pieces, i * sizeof piece), sizeof piece))
            return -1;
        size_t part = piece.iov_len < room - length ? piece.iov_len : room - length;
        if (!ect_user_read(frame + length, piece.iov_base, part))
            return -1;
        if (__asan_loadN && part > 0)
            __asan_loadN(piece.iov_base, part);
        length += part;
        if (part < piece.iov_len)
            return (ssize_t)room + 1;
    }
    return (ssize_t)length;
}

ssize_t ect_port_send(ect_port_t *port, const struct iovec *pieces, size_t count, const struct sockaddr *to,
                      socklen_t to_length)
{
    uint8_t frame[LONGEST];
    struct sockaddr_ll address = {0};
    if (to && !read_address(&address, to, to_length))
        return fail(EFAULT);
    ssize_t length = gather(pieces, count, frame, sizeof frame);
    if (length < 0)
        return fail(EFAULT);
    int end = address.sll_family == AF_PACKET ? ect_bus_end_of_index(address.sll_ifindex) : port->end;
    if (end < 0)
        return fail(ENXIO);
    if (length < HEADER)
        return fail(EINVAL);
    if ((size_t)length > sizeof frame)
        return fail(EMSGSIZE);
    ect_time_charge(ECT_COST_SOCKET_NS);
    ect_time_lock();
    bool running = ect_bus_is_up((unsigned int)end) && start_bus();
    if (running)
        ect_time_bus_next(ect_bus_frame((unsigned int)end, frame, (size_t)length, ect_time_now()));
    ect_time_unlock();
    return running ? length : fail(ENETDOWN);
}

static bool is_waiting(const void *arg)
{
    const ect_port_t *port = arg;
    return port->first != NULL;
}

static void take(ect_port_t *port)
{
    waiting_t *one = port->first;
    port->first = one->next;
    if (!port->first) {
        port->last = &port->first;
        port->fresh = false;
    }
    port->count--;
    if (!ect_time_is_virtual)
        show(port);
    one->next = port->spare;
    port->spare = one;
}

/* @return the length; -1: a bad address */
static ssize_t scatter(const waiting_t *one, const struct iovec *pieces, size_t count)
{
    size_t done = 0;
    for (size_t i = 0; i < count && done < one->length; i++) {
        struct iovec piece;
        if (!ect_user_read(&piece, ect_user_at(pieces, i * sizeof piece), sizeof piece))
            return -1;
        size_t part = piece.iov_len < one->length - done ? piece.iov_len : one->length - done;
        if (!ect_user_write(piece.iov_base, one->frame + done, part))
            return -1;
        if (__asan_storeN && part > 0)
            __asan_storeN(piece.iov_base, part);
        done += part;
    }
    return (ssize_t)done;
}

/* The kernel reads the list before it waits: a bad list loses no frame. */
static bool can_read(const struct iovec *pieces, size_t count)
{
    struct iovec piece;
    size_t i = 0;
    while (i < count && ect_user_read(&piece, ect_user_at(pieces, i * sizeof piece), sizeof piece))
        i++;
    return i == count;
}

void ect_port_set_nonblocking(ect_port_t *port, bool on)
{
    port->nonblocking = on;
}

static bool waits(const ect_port_t *port, int flags)
{
    return (flags & MSG_DONTWAIT) == 0 && !port->nonblocking;
}

ssize_t ect_port_receive(ect_port_t *port, const struct iovec *pieces, size_t count, int flags, int *result_flags,
                         struct sockaddr *from, socklen_t *from_length)
{
    if (!can_read(pieces, count))
        return fail(EFAULT);
    ect_time_charge(ECT_COST_SOCKET_NS);
    ect_time_lock();
    int error = EAGAIN;
    if (!port->first && waits(port, flags)) {
        uint64_t until_ns = port->timeout_ns != 0 ? ect_time_now() + port->timeout_ns : ECTWIN_NEVER;
        if (!ect_time_wait(port->fd, is_waiting, port, until_ns))
            error = errno;
    }
    if (!port->first) {
        ect_time_unlock();
        return fail(error);
    }
    const waiting_t *one = port->first;
    ssize_t length = (ssize_t)one->length;
    ssize_t done = scatter(one, pieces, count);
    uint16_t protocol;
    memcpy(&protocol, one->frame + 12, sizeof protocol);
    if (done >= 0 && from && !put_address(port, protocol, from, from_length))
        done = -1;
    if ((flags & MSG_PEEK) == 0)
        take(port);
    ect_time_unlock();
    if (done < 0)
        return fail(EFAULT); /* the frame is lost, as with a kernel */
    if (result_flags)
        *result_flags = done < length ? MSG_TRUNC : 0;
    return (flags & MSG_TRUNC) != 0 ? length : done;
}
