/* SPDX-License-Identifier: MIT */
/* The socket functions of the C library: packet sockets on interfaces of the bus are handled here, other sockets by the
 * real functions. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <net/if.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/interfaces.h"
#include "bus/inprocess/ports.h"
#include "bus/inprocess/raw.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"
#include "bus/inprocess/user.h"

static ect_port_t *ours(int fd)
{
    return ect_inside > 0 ? NULL : ect_port_of(fd);
}

static int fail(int error)
{
    errno = error;
    return -1;
}

/* @return whether a number of pieces is one that readv(2) and writev(2) accept */
static bool is_count(int count)
{
    return count >= 0 && count <= IOV_MAX;
}

/* Copies a message of the program. @return false (errno): the kernel refuses the message */
static bool read_message(struct msghdr *to, const struct msghdr *from)
{
    if (!ect_user_read(to, from, sizeof *to))
        return fail(EFAULT) == 0;
    return to->msg_iovlen <= IOV_MAX || fail(EMSGSIZE) == 0;
}

/* Stores the length of one of several messages. @return false (errno): a bad address */
static bool put_length(struct mmsghdr *message, ssize_t length)
{
    const unsigned int its = (unsigned int)length;
    return ect_user_write(ect_user_at(message, offsetof(struct mmsghdr, msg_len)), &its, sizeof its) ||
           fail(EFAULT) == 0;
}

REPLACES int socket(int domain, int type, int protocol)
{
    if (ect_inside > 0 || domain != AF_PACKET || (type & 0xF) != SOCK_RAW)
        return REAL(socket)(domain, type, protocol);
    ect_raw_scan(); /* all objects of the master are loaded now */
    return ect_port_open(type, protocol);
}

REPLACES int bind(int fd, __CONST_SOCKADDR_ARG address, socklen_t length)
{
    ect_port_t *port = ours(fd);
    return port ? ect_port_bind(port, address.__sockaddr__, length) : REAL(bind)(fd, address, length);
}

REPLACES int setsockopt(int fd, int level, int name, const void *value, socklen_t length)
{
    ect_port_t *port = ours(fd);
    return port ? ect_port_set(port, level, name, value, length) : REAL(setsockopt)(fd, level, name, value, length);
}

REPLACES int getsockopt(int fd, int level, int name, void *restrict value, socklen_t *restrict length)
{
    ect_port_t *port = ours(fd);
    return port ? ect_port_get(port, level, name, value, length) : REAL(getsockopt)(fd, level, name, value, length);
}

REPLACES int getsockname(int fd, __SOCKADDR_ARG address, socklen_t *restrict length)
{
    ect_port_t *port = ours(fd);
    return port ? ect_port_name(port, address.__sockaddr__, length) : REAL(getsockname)(fd, address, length);
}

/* --- requests ------------------------------------------------------------------------------------------------------
 */

static int on_port(int fd, unsigned long request, void *argument)
{
    if (request == FIONBIO) {
        int on;
        if (!ect_user_read(&on, argument, sizeof on))
            return fail(EFAULT);
        int flags = REAL(fcntl)(fd, F_GETFL) & ~O_NONBLOCK;
        ect_port_set_nonblocking(ours(fd), on != 0);
        return REAL(fcntl)(fd, F_SETFL, flags | (on != 0 ? O_NONBLOCK : 0));
    }
    if (request == FIOCLEX || request == FIONCLEX)
        return REAL(ioctl)(fd, request);
    int result;
    if (ect_interface_request(fd, request, argument, &result))
        return result;
    /* Arguments of unknown requests are not read: they may be of any type. */
    errno = ect_interface_has(request) ? ENODEV : request >> 8 == SIOCGIFINDEX >> 8 ? EOPNOTSUPP : ENOTTY;
    return -1;
}

REPLACES int ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    if (ours(fd))
        return on_port(fd, request, argument);
    /* Requests for interfaces are allowed on sockets of any kind. */
    int result;
    bool interface = ect_inside == 0 && ect_interface_request(fd, request, argument, &result);
    return interface ? result : REAL(ioctl)(fd, request, argument);
}

/* --- sending -------------------------------------------------------------------------------------------------------
 */

REPLACES ssize_t send(int fd, const void *data, size_t size, int flags)
{
    ect_port_t *port = ours(fd);
    const struct iovec piece = {.iov_base = (void *)(uintptr_t)data, .iov_len = size};
    return port ? ect_port_send(port, &piece, 1, NULL, 0) : REAL(send)(fd, data, size, flags);
}

REPLACES ssize_t sendto(int fd, const void *data, size_t size, int flags, __CONST_SOCKADDR_ARG to, socklen_t length)
{
    ect_port_t *port = ours(fd);
    const struct iovec piece = {.iov_base = (void *)(uintptr_t)data, .iov_len = size};
    return port ? ect_port_send(port, &piece, 1, to.__sockaddr__, length)
                : REAL(sendto)(fd, data, size, flags, to, length);
}

/* Control data have no effect on a packet socket; a byte of each page is read, because the kernel reads all. */
static bool can_read_control(const struct msghdr *message)
{
    enum { PAGE = 4096 };
    size_t length = message->msg_control ? message->msg_controllen : 0;
    char byte;
    size_t i = 0;
    while (i < length && ect_user_read(&byte, ect_user_at(message->msg_control, i), sizeof byte))
        i += PAGE;
    return i >= length &&
           (length == 0 || ect_user_read(&byte, ect_user_at(message->msg_control, length - 1), sizeof byte));
}

static ssize_t send_message(ect_port_t *port, const struct msghdr *message)
{
    struct msghdr its;
    if (!read_message(&its, message))
        return -1;
    if (!can_read_control(&its))
        return fail(EFAULT);
    return ect_port_send(port, its.msg_iov, its.msg_iovlen, its.msg_name, its.msg_namelen);
}

REPLACES ssize_t sendmsg(int fd, const struct msghdr *message, int flags)
{
    ect_port_t *port = ours(fd);
    return port ? send_message(port, message) : REAL(sendmsg)(fd, message, flags);
}

REPLACES int sendmmsg(int fd, struct mmsghdr *messages, unsigned int count, int flags)
{
    ect_port_t *port = ours(fd);
    if (!port)
        return REAL(sendmmsg)(fd, messages, count, flags);
    for (unsigned int i = 0; i < count; i++) {
        struct mmsghdr *one = ect_user_at(messages, i * sizeof *one);
        ssize_t sent = send_message(port, (const struct msghdr *)one); /* its first member */
        if (sent < 0 || !put_length(one, sent))
            return i > 0 ? (int)i : -1;
    }
    return (int)count;
}

REPLACES ssize_t write(int fd, const void *data, size_t size)
{
    ect_port_t *port = ours(fd);
    const struct iovec piece = {.iov_base = (void *)(uintptr_t)data, .iov_len = size};
    return port ? ect_port_send(port, &piece, 1, NULL, 0) : REAL(write)(fd, data, size);
}

REPLACES ssize_t writev(int fd, const struct iovec *pieces, int count)
{
    ect_port_t *port = ours(fd);
    if (!port)
        return REAL(writev)(fd, pieces, count);
    return is_count(count) ? ect_port_send(port, pieces, (size_t)count, NULL, 0) : fail(EINVAL);
}

/* --- receiving -----------------------------------------------------------------------------------------------------
 */

/* Called for a descriptor that is not of the bus, on which the master may block. @return false (errno): the call ends
 */
static bool before(const char *call, int fd, int flags)
{
    return ect_inside > 0 || ect_time_before_read(call, fd, flags);
}

static ssize_t receive(ect_port_t *port, void *data, size_t size, int flags)
{
    const struct iovec piece = {.iov_base = data, .iov_len = size};
    return ect_port_receive(port, &piece, 1, flags, NULL, NULL, NULL);
}

REPLACES ssize_t recv(int fd, void *data, size_t size, int flags)
{
    ect_port_t *port = ours(fd);
    if (port)
        return receive(port, data, size, flags);
    return before("recv()", fd, flags) ? REAL(recv)(fd, data, size, flags) : -1;
}

REPLACES ssize_t recvfrom(int fd, void *restrict data, size_t size, int flags, __SOCKADDR_ARG from,
                          socklen_t *restrict length)
{
    ect_port_t *port = ours(fd);
    const struct iovec piece = {.iov_base = data, .iov_len = size};
    if (port)
        return ect_port_receive(port, &piece, 1, flags, NULL, from.__sockaddr__, length);
    return before("recvfrom()", fd, flags) ? REAL(recvfrom)(fd, data, size, flags, from, length) : -1;
}

static ssize_t receive_message(ect_port_t *port, struct msghdr *message, int flags)
{
    struct msghdr its;
    if (!read_message(&its, message))
        return -1;
    socklen_t length = its.msg_name ? its.msg_namelen : 0;
    ssize_t got = ect_port_receive(port, its.msg_iov, its.msg_iovlen, flags, &its.msg_flags, its.msg_name,
                                   its.msg_name ? &length : NULL);
    if (got < 0)
        return got;
    its.msg_namelen = length;
    its.msg_controllen = 0;
    return ect_user_write(message, &its, sizeof its) ? got : fail(EFAULT);
}

REPLACES ssize_t recvmsg(int fd, struct msghdr *message, int flags)
{
    ect_port_t *port = ours(fd);
    if (port)
        return receive_message(port, message, flags);
    return before("recvmsg()", fd, flags) ? REAL(recvmsg)(fd, message, flags) : -1;
}

/* The time limit has no effect; the kernel reads it before the first frame and writes it after the last one. */
REPLACES int recvmmsg(int fd, struct mmsghdr *messages, unsigned int count, int flags, struct timespec *timeout)
{
    ect_port_t *port = ours(fd);
    struct timespec limit;
    if (!port)
        return before("recvmmsg()", fd, flags) ? REAL(recvmmsg)(fd, messages, count, flags, timeout) : -1;
    if (timeout && !ect_user_read(&limit, timeout, sizeof limit))
        return fail(EFAULT);
    unsigned int done = 0;
    while (done < count) {
        int how = done > 0 && (flags & MSG_WAITFORONE) != 0 ? flags | MSG_DONTWAIT : flags;
        struct mmsghdr *one = ect_user_at(messages, done * sizeof *one);
        ssize_t got = receive_message(port, (struct msghdr *)one, how); /* its first member */
        if (got < 0 || !put_length(one, got))
            break;
        done++;
    }
    if (done > 0 && timeout && !ect_user_write(timeout, &limit, sizeof limit))
        return fail(EFAULT);
    return done > 0 || count == 0 ? (int)done : -1;
}

REPLACES ssize_t readv(int fd, const struct iovec *pieces, int count)
{
    ect_port_t *port = ours(fd);
    if (!port)
        return before("readv()", fd, 0) ? REAL(readv)(fd, pieces, count) : -1;
    return is_count(count) ? ect_port_receive(port, pieces, (size_t)count, 0, NULL, NULL, NULL) : fail(EINVAL);
}

REPLACES ssize_t read(int fd, void *data, size_t size)
{
    ect_port_t *port = ours(fd);
    if (port)
        return receive(port, data, size, 0);
    return before("read()", fd, 0) ? REAL(read)(fd, data, size) : -1;
}

/* The variants called with _FORTIFY_SOURCE. */
ssize_t __read_chk(int fd, void *data, size_t size, size_t room);
REPLACES ssize_t __read_chk(int fd, void *data, size_t size, size_t room)
{
    return size <= room ? read(fd, data, size) : REAL(__read_chk)(fd, data, size, room);
}

ssize_t __recv_chk(int fd, void *data, size_t size, size_t room, int flags);
REPLACES ssize_t __recv_chk(int fd, void *data, size_t size, size_t room, int flags)
{
    ect_port_t *port = ours(fd);
    if (port)
        return receive(port, data, size < room ? size : room, flags);
    return size <= room ? recv(fd, data, size, flags) : REAL(__recv_chk)(fd, data, size, room, flags);
}

ssize_t __recvfrom_chk(int fd, void *data, size_t size, size_t room, int flags, struct sockaddr *from,
                       socklen_t *length);
REPLACES ssize_t __recvfrom_chk(int fd, void *data, size_t size, size_t room, int flags, struct sockaddr *from,
                                socklen_t *length)
{
    ect_port_t *port = ours(fd);
    const struct iovec piece = {.iov_base = data, .iov_len = size < room ? size : room};
    if (port)
        return ect_port_receive(port, &piece, 1, flags, NULL, from, length);
    return size <= room ? recvfrom(fd, data, size, flags, from, length)
                        : REAL(__recvfrom_chk)(fd, data, size, room, flags, from, length);
}

REPLACES int accept(int fd, __SOCKADDR_ARG address, socklen_t *restrict length)
{
    return before("accept()", fd, 0) ? REAL(accept)(fd, address, length) : -1;
}

REPLACES int accept4(int fd, __SOCKADDR_ARG address, socklen_t *restrict length, int flags)
{
    return before("accept4()", fd, 0) ? REAL(accept4)(fd, address, length, flags) : -1;
}

/* --- descriptors ---------------------------------------------------------------------------------------------------
 */

/* Called before descriptors are closed. */
static void closing(unsigned int from, unsigned int to)
{
    if (ect_inside == 0)
        ect_eventfds_closed(from, to);
}

/* Called after a descriptor has been copied. @return the copy; -1: failed */
static int copied(int fd, int copy)
{
    if (ect_inside == 0 && copy >= 0)
        ect_eventfd_copied(fd, copy);
    return copy;
}

REPLACES int close(int fd)
{
    if (fd >= 0)
        closing((unsigned int)fd, (unsigned int)fd);
    return REAL(close)(fd);
}

/* Missing in older C libraries. */
int close_range(unsigned int from, unsigned int to, int flags);
void closefrom(int from);
enum { OF_THREAD = 2 }; /* CLOSE_RANGE_UNSHARE */

REPLACES int close_range(unsigned int from, unsigned int to, int flags)
{
    if ((flags & ~OF_THREAD) == 0) /* now: not at exec, and not with flags that the kernel refuses */
        closing(from, to);
    return REAL(close_range)(from, to, flags);
}

REPLACES void closefrom(int from)
{
    closing(from > 0 ? (unsigned int)from : 0, UINT_MAX);
    REAL(closefrom)(from);
}

REPLACES int dup(int fd)
{
    return copied(fd, REAL(dup)(fd));
}

/* Called before dup2() and dup3(), which close the descriptor `to` if they do not fail. */
static void replacing(int fd, int to, int flags)
{
    if (ect_inside == 0 && fd != to && to >= 0 && (flags & ~O_CLOEXEC) == 0 && REAL(fcntl)(fd, F_GETFD) >= 0)
        closing((unsigned int)to, (unsigned int)to);
}

REPLACES int dup2(int fd, int to)
{
    replacing(fd, to, 0);
    int copy = REAL(dup2)(fd, to);
    return fd != to ? copied(fd, copy) : copy;
}

REPLACES int dup3(int fd, int to, int flags)
{
    replacing(fd, to, flags);
    return copied(fd, REAL(dup3)(fd, to, flags));
}

static int control(int fd, int command, void *argument)
{
    int result = REAL(fcntl)(fd, command, argument);
    if (command == F_DUPFD || command == F_DUPFD_CLOEXEC)
        return copied(fd, result);
    if (result >= 0 && command == F_SETFL && ours(fd))
        ect_port_set_nonblocking(ours(fd), ((intptr_t)argument & O_NONBLOCK) != 0);
    return result;
}

REPLACES int fcntl(int fd, int command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    return control(fd, command, argument);
}

REPLACES int fcntl64(int fd, int command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    return control(fd, command, argument);
}
