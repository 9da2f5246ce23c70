/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/ports.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <pthread.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"
#include "bus/library.h"

enum {
    WAITING_MOST = 256, /* limit of waiting frames: as many small ones as the kernel's default buffer contains */
    HEADER = 14,
    TAG = 4,
    LONGEST = 1518,
};

static const time_t LONGEST_S = INT64_MAX / 1000000000;

typedef struct waiting {
    size_t length;
    uint8_t frame[ECTWIN_FRAME_MAX];
} waiting_t;

enum { FRAMES_SIZE = WAITING_MOST * sizeof(waiting_t) };

struct ect_port {
    ect_eventfd_t event;
    ect_port_t *next;       /* next bound socket */
    unsigned int receivers; /* threads that wait for a frame, also after the last descriptor is closed */
    int end;                /* -1: not bound */
    uint16_t protocol;      /* network order */
    uint64_t timeout_ns;    /* 0: none */
    bool nonblocking;
    waiting_t *frames; /* a ring, mapped: no allocation in a handler that has interrupted malloc() */
    size_t first, count;
    bool fresh; /* a frame has arrived since the last write to the eventfd */
    bool shown; /* the eventfd is readable */
};

static ect_port_t *bound;

static void close_own(int fd)
{
    int before = ect_enter();
    if (fd >= 0)
        REAL(close)(fd);
    ect_leave(before);
}

/* Ends a socket without descriptors and receivers. */
static void end_if_unused(ect_port_t *port)
{
    if (port->event.descriptors > 0 || port->receivers > 0)
        return;
    for (ect_port_t **at = &bound; *at; at = &(*at)->next) {
        if (*at == port) {
            *at = port->next;
            break;
        }
    }
    close_own(port->event.fd);
    (void)munmap(port->frames, FRAMES_SIZE);
    ect_eventfd_keep(&port->event);
}

/* A receiver waits on a descriptor that the program does not know; -1: no descriptor is left. */
static void closed(ect_eventfd_t *its, int fd)
{
    ect_port_t *port = (ect_port_t *)its;
    if (port->receivers > 0)
        its->fd = REAL(fcntl)(fd, F_DUPFD_CLOEXEC, fd);
    end_if_unused(port);
}

static bool inherited(ect_eventfd_t *its)
{
    ect_port_t *port = (ect_port_t *)its;
    port->receivers = 0;
    return port->shown;
}

static ect_eventfd_kind_t ports = {.size = sizeof(ect_port_t), .closed = closed, .inherited = inherited};

ect_port_t *ect_port_of(int fd)
{
    return (ect_port_t *)ect_eventfd_of(fd, &ports);
}

int ect_port_open(int type, int protocol)
{
    void *frames = mmap(NULL, FRAMES_SIZE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (frames == MAP_FAILED)
        return -1;
    ect_port_t *port = (ect_port_t *)ect_eventfd_make(&ports);
    if (port)
        *port = (ect_port_t){.event = port->event,
                             .end = -1,
                             .protocol = (uint16_t)protocol,
                             .nonblocking = (type & SOCK_NONBLOCK) != 0,
                             .frames = frames};
    int flags = EFD_NONBLOCK | ((type & SOCK_CLOEXEC) != 0 ? EFD_CLOEXEC : 0);
    int fd = port ? ect_eventfd_open(&port->event, flags) : -1;
    if (fd < 0)
        (void)munmap(frames, FRAMES_SIZE);
    else if ((type & SOCK_NONBLOCK) == 0)
        (void)REAL(fcntl)(fd, F_SETFL, O_RDWR); /* the master may read its flags */
    return fd;
}

bool ect_port_has_frame(const ect_port_t *port)
{
    return port->count > 0;
}

/* The eventfd is written even if readable, because each frame is a new event for edge-triggered epoll. */
static void show(ect_port_t *port)
{
    eventfd_t value;
    if (!port->fresh && (!port->shown || port->count > 0))
        return;
    int before = ect_enter();
    if (port->fresh)
        (void)eventfd_write(port->event.fd, 1);
    else
        (void)!REAL(read)(port->event.fd, &value, sizeof value);
    port->shown = port->fresh;
    port->fresh = false;
    ect_leave(before);
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

static int unlock_and_fail(int error)
{
    ect_time_unlock();
    return fail(error);
}

/* Removes the VLAN tag, as the kernel does before a packet socket gets the frame. */
static size_t without_tag(const uint8_t *frame, size_t length, size_t *tag)
{
    *tag = length >= HEADER + TAG && frame[12] == 0x81 && frame[13] == 0x00 ? TAG : 0;
    return length - *tag;
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
        waiting_t *one = &port->frames[(port->first + port->count) % WAITING_MOST];
        one->length = left;
        memcpy(one->frame, frame, 12);
        memcpy(one->frame + 12, frame + 12 + tag, left - 12);
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
    if (port->event.descriptors == 0)
        return unlock_and_fail(EBADF);
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

/* As the kernel reads SO_RCVTIMEO: a negative time ends a receive at once, and a very long one is none. */
static uint64_t timeout_of(const struct timeval *time)
{
    if (time->tv_sec < 0)
        return 1;
    return time->tv_sec < LONGEST_S ? (uint64_t)time->tv_sec * 1000000000u + (uint64_t)time->tv_usec * 1000u : 0;
}

int ect_port_set(ect_port_t *port, int level, int name, const void *value, socklen_t length)
{
    int number;
    if (level == SOL_SOCKET && name == SO_RCVTIMEO && length >= sizeof(struct timeval)) {
        struct timeval time;
        if (!ect_user_read(&time, value, sizeof time))
            return fail(EFAULT);
        if (time.tv_usec < 0 || time.tv_usec >= 1000000)
            return fail(EDOM);
        ect_time_lock();
        port->timeout_ns = timeout_of(&time);
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
    pthread_testcancel();
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
    if (port->event.descriptors == 0)
        return unlock_and_fail(EBADF);
    bool running = ect_bus_is_up((unsigned int)end) && start_bus();
    if (running)
        ect_time_bus_next(ect_bus_frame((unsigned int)end, frame, (size_t)length, ect_time_now()));
    ect_time_unlock();
    return running ? length : fail(ENETDOWN);
}

static bool is_waiting(const void *arg)
{
    return ect_port_has_frame(arg);
}

/* An empty ring begins again at its first place, which is in the cache. */
static void take(ect_port_t *port)
{
    port->first = (port->first + 1) % WAITING_MOST;
    if (--port->count == 0) {
        port->first = 0;
        port->fresh = false;
    }
    if (!ect_time_is_virtual)
        show(port);
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

/* A thread that waits for a frame. On the real clock it has a descriptor of its own, because poll(2) resolves the
 * number again at each wake-up, and another thread may close the socket meanwhile. */
typedef struct receiver {
    ect_port_t *port;
    int fd;
} receiver_t;

static void end_receiver(const receiver_t *its)
{
    close_own(its->fd);
    its->port->receivers--;
}

/* Runs in a thread that is cancelled, without the lock. */
static void on_cancel(void *arg)
{
    const receiver_t *its = arg;
    ect_time_lock();
    end_receiver(its);
    end_if_unused(its->port);
    ect_time_unlock();
}

/* Waits for a frame. With the lock. Not instrumented: AddressSanitizer would touch the remains of the cancelled stack.
 * @return the error number if there is none */
__attribute__((no_sanitize("address"))) static int wait_for_frame(ect_port_t *port)
{
    uint64_t until_ns = port->timeout_ns != 0 ? ect_time_now() + port->timeout_ns : ECTWIN_NEVER;
    receiver_t its = {.port = port, .fd = -1};
    port->receivers++;
    if (!ect_time_is_virtual)
        its.fd = REAL(fcntl)(port->event.fd, F_DUPFD_CLOEXEC, port->event.fd);
    pthread_cleanup_push(on_cancel, &its);
    (void)ect_time_wait(its.fd >= 0 ? its.fd : port->event.fd, is_waiting, port, until_ns);
    pthread_cleanup_pop(0);
    int error = errno;
    end_receiver(&its);
    return error;
}

ssize_t ect_port_receive(ect_port_t *port, const struct iovec *pieces, size_t count, int flags, int *result_flags,
                         struct sockaddr *from, socklen_t *from_length)
{
    pthread_testcancel();
    if (!can_read(pieces, count))
        return fail(EFAULT);
    ect_time_charge(ECT_COST_SOCKET_NS);
    ect_time_lock();
    if (port->event.descriptors == 0)
        return unlock_and_fail(EBADF);
    int error = port->count == 0 && waits(port, flags) ? wait_for_frame(port) : EAGAIN;
    if (port->count == 0) {
        end_if_unused(port);
        ect_time_unlock();
        pthread_testcancel();
        return fail(error);
    }
    const waiting_t *one = &port->frames[port->first];
    ssize_t length = (ssize_t)one->length;
    ssize_t done = scatter(one, pieces, count);
    uint16_t protocol;
    memcpy(&protocol, one->frame + 12, sizeof protocol);
    if (done >= 0 && from && !put_address(port, protocol, from, from_length))
        done = -1;
    if ((flags & MSG_PEEK) == 0)
        take(port);
    end_if_unused(port);
    ect_time_unlock();
    if (done < 0)
        return fail(EFAULT); /* the frame is lost, as with a kernel */
    if (result_flags)
        *result_flags = done < length ? MSG_TRUNC : 0;
    return (flags & MSG_TRUNC) != 0 ? length : done;
}
