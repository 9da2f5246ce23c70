/* SPDX-License-Identifier: MIT */
/* A port (bus/net/packet.h) on an interface of a kernel that is the test's: each call may fail, and time is the test's.
 * The real kernel, with its filters, is in test_network.c. */
#define _GNU_SOURCE
#include "bus/net/packet.h"

#include <arpa/inet.h>
#include <linux/ethtool.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "calls.h"
#include "wire/bytes.h"

#ifndef PACKET_IGNORE_OUTGOING
#define PACKET_IGNORE_OUTGOING 23
#endif

enum { INDEX = 7, ROOM = 1600, SLOT = 4096, SLOTS = 128, MAIN = FAKE_FD, TAGGED = FAKE_FD + 2 };

#define US 1000ull
#define MS 1000000ull

static struct kernel {
    short flags;
    unsigned int family;
    int index;           /* of the interface now */
    const char *list;    /* of the packet sockets */
    uint64_t now_ns;     /* of both clocks; the real-time clock is 1000 s ahead */
    uint64_t age_ns;     /* of the frame that was received last */
    unsigned int asked;  /* how often its age was read */
    ssize_t length;      /* of the frame that is there; 0: none */
    size_t waiting;      /* frames behind it */
    uint32_t tag_status; /* of a tagged frame */
    bool tagged;         /* the frame has a tag */
    int glink;           /* -1: unknown to the driver */
    uint8_t *ring;
    int flags_of_recv;
    unsigned int lost[2]; /* frames that the queues have lost, without a tag and with one, since the last question */
} kernel;

/* --- calls -------------------------------------------------------------------------------------------------------- */

int __wrap_socket(int family, int type, int protocol);
int __wrap_setsockopt(int fd, int level, int option, const void *value, socklen_t size);
int __wrap_getsockopt(int fd, int level, int option, void *value, socklen_t *size);
int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size);
int __wrap_ioctl(int fd, unsigned long request, ...);
unsigned int __wrap_if_nametoindex(const char *name);
FILE *__real_fopen(const char *path, const char *mode);
FILE *__wrap_fopen(const char *path, const char *mode);
int __real_close(int fd);
int __wrap_close(int fd);
void *__real_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
int __real_munmap(void *at, size_t size);
int __wrap_munmap(void *at, size_t size);
ssize_t __wrap_recv(int fd, void *data, size_t size, int flags);
ssize_t __wrap_recvmsg(int fd, struct msghdr *message, int flags);
ssize_t __wrap_send(int fd, const void *data, size_t size, int flags);
int __wrap_clock_gettime(clockid_t clock, struct timespec *time);

/* A socket without a protocol receives nothing before it is bound. */
int __wrap_socket(int family, int type, int protocol)
{
    assert_int_equal(family, AF_PACKET);
    assert_int_equal(type, SOCK_RAW | SOCK_CLOEXEC);
    assert_int_equal(protocol, 0);
    return fails("socket") ? -1 : fake_open("socket");
}

int __wrap_setsockopt(int fd, int level, int option, const void *value, socklen_t size)
{
    const char *name = level == SOL_SOCKET && option == SO_ATTACH_FILTER         ? "filter"
                       : level == SOL_SOCKET && option == SO_RCVTIMEO            ? "timeout"
                       : level == SOL_PACKET && option == PACKET_IGNORE_OUTGOING ? "incoming"
                       : level == SOL_PACKET && option == PACKET_AUXDATA         ? "tags"
                       : level == SOL_PACKET && option == PACKET_ADD_MEMBERSHIP  ? "promiscuous"
                       : level == SOL_PACKET && option == PACKET_VERSION         ? "version"
                       : level == SOL_PACKET && option == PACKET_RX_RING         ? "ring"
                                                                                 : "?";
    note("%s %d", name, place_of(fd));
    if (strcmp(name, "promiscuous") == 0) {
        const struct packet_mreq *request = value;
        note(" %d %d", request->mr_ifindex, request->mr_type);
    }
    if (strcmp(name, "incoming") == 0 || strcmp(name, "tags") == 0)
        note(" %d", *(const int *)value);
    if (strcmp(name, "ring") == 0)
        note(" %u", ((const struct tpacket_req *)value)->tp_frame_nr);
    note("\n");
    assert_true(size > 0);
    return fails("setsockopt") ? -1 : 0;
}

int __wrap_getsockopt(int fd, int level, int option, void *value, socklen_t *size)
{
    if (level == SOL_PACKET && option == PACKET_STATISTICS) {
        struct tpacket_stats *counts = value;
        assert_int_equal(*size, sizeof *counts);
        if (fails("getsockopt"))
            return -1;
        *counts = (struct tpacket_stats){.tp_packets = 1000, .tp_drops = kernel.lost[fd == TAGGED]};
        kernel.lost[fd == TAGGED] = 0;
        return 0;
    }
    assert_int_equal(place_of(fd), 0);
    assert_true(level == SOL_SOCKET && option == SO_RCVTIMEO && *size == sizeof(struct timeval));
    *(struct timeval *)value = (struct timeval){.tv_usec = 4000};
    return fails("getsockopt") ? -1 : 0;
}

int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size)
{
    const struct sockaddr_ll *link = (const struct sockaddr_ll *)(const void *)address;
    assert_int_equal(size, sizeof *link);
    assert_int_equal(link->sll_family, AF_PACKET);
    note("bind %d %04x %d\n", place_of(fd), ntohs(link->sll_protocol), link->sll_ifindex);
    return fails("bind") ? -1 : 0;
}

static int interface_of(unsigned long request, struct ifreq *r)
{
    assert_string_equal(r->ifr_name, "ectwin0");
    switch (request) {
    case SIOCGIFHWADDR:
        r->ifr_hwaddr.sa_family = (sa_family_t)kernel.family;
        return fails("address") ? -1 : 0;
    case SIOCGIFFLAGS:
        r->ifr_flags = kernel.flags;
        return fails("flags") ? -1 : 0;
    case SIOCSIFFLAGS:
        if (fails("set flags"))
            return -1;
        kernel.flags = r->ifr_flags;
        return 0;
    case SIOCGIFINDEX:
        r->ifr_ifindex = kernel.index;
        return fails("index") ? -1 : 0;
    default:
        assert_int_equal(request, SIOCETHTOOL);
        assert_int_equal(((struct ethtool_value *)(void *)r->ifr_data)->cmd, ETHTOOL_GLINK);
        ((struct ethtool_value *)(void *)r->ifr_data)->data = (uint32_t)kernel.glink;
        return kernel.glink < 0 ? -1 : 0;
    }
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    void *value = va_arg(arguments, void *);
    va_end(arguments);
    assert_true(is_fake(fd));
    if (request != SIOCGSTAMPNS)
        return interface_of(request, value);
    kernel.asked++;
    const uint64_t came_ns = 1000 * 1000 * MS + kernel.now_ns - kernel.age_ns;
    *(struct timespec *)value =
        (struct timespec){.tv_sec = (time_t)(came_ns / 1000000000), .tv_nsec = (long)(came_ns % 1000000000)};
    return fails("stamp") ? -1 : 0;
}

unsigned int __wrap_if_nametoindex(const char *name)
{
    return strcmp(name, "ectwin0") == 0 ? INDEX : 0;
}

FILE *__wrap_fopen(const char *path, const char *mode)
{
    if (strcmp(path, "/proc/self/net/packet") != 0)
        return __real_fopen(path, mode);
    return kernel.list ? fmemopen((void *)(uintptr_t)kernel.list, strlen(kernel.list), "r") : NULL;
}

int __wrap_close(int fd)
{
    if (!is_fake(fd))
        return __real_close(fd);
    fake_close(fd);
    return 0;
}

void *__wrap_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset)
{
    if (!is_fake(fd))
        return __real_mmap(at, size, protection, flags, fd, offset);
    assert_int_equal(size, SLOT * SLOTS);
    assert_true(fd == MAIN && offset == 0 && protection == (PROT_READ | PROT_WRITE) && flags == MAP_SHARED);
    return fails("mmap") ? MAP_FAILED : kernel.ring;
}

int __wrap_munmap(void *at, size_t size)
{
    if (at != kernel.ring)
        return __real_munmap(at, size);
    assert_int_equal(size, SLOT * SLOTS);
    note("unmapped\n");
    return 0;
}

static ssize_t frame_or_none(bool there)
{
    if (fails("recv"))
        return -1;
    errno = EAGAIN;
    return there ? kernel.length : -1;
}

ssize_t __wrap_recv(int fd, void *data, size_t size, int flags)
{
    if ((flags & MSG_PEEK) != 0) {
        assert_int_equal(flags, MSG_PEEK | MSG_DONTWAIT);
        errno = EAGAIN;
        return kernel.waiting > 0 ? 1 : -1;
    }
    assert_int_equal(fd, MAIN);
    kernel.flags_of_recv = flags;
    memset(data, 0x33, kernel.length > 0 && (size_t)kernel.length < size ? (size_t)kernel.length : size);
    return frame_or_none(kernel.length > 0 && !kernel.tagged);
}

ssize_t __wrap_recvmsg(int fd, struct msghdr *message, int flags)
{
    const struct tpacket_auxdata tag = {.tp_status = kernel.tag_status, .tp_vlan_tci = 0xA007, .tp_vlan_tpid = 0x88A8};
    uint8_t *frame = message->msg_iov->iov_base;
    struct cmsghdr *one = CMSG_FIRSTHDR(message);
    assert_int_equal(fd, TAGGED);
    assert_int_equal(flags, MSG_TRUNC | MSG_DONTWAIT);
    for (size_t i = 0; i < message->msg_iov->iov_len; i++)
        frame[i] = (uint8_t)i;
    *one = (struct cmsghdr){.cmsg_level = SOL_PACKET, .cmsg_type = PACKET_AUXDATA, .cmsg_len = CMSG_LEN(sizeof tag)};
    memcpy(CMSG_DATA(one), &tag, sizeof tag);
    message->msg_controllen = CMSG_SPACE(sizeof tag);
    return frame_or_none(kernel.length > 0 && kernel.tagged);
}

ssize_t __wrap_send(int fd, const void *data, size_t size, int flags)
{
    assert_int_equal(place_of(fd), 0);
    assert_int_equal(flags, MSG_DONTWAIT);
    note("send %zu %02x\n", size, *(const uint8_t *)data);
    return (ssize_t)size;
}

int __wrap_clock_gettime(clockid_t clock, struct timespec *time)
{
    const uint64_t ns = kernel.now_ns + (clock == CLOCK_REALTIME ? 1000 * 1000 * MS : 0);
    *time = (struct timespec){.tv_sec = (time_t)(ns / 1000000000), .tv_nsec = (long)(ns % 1000000000)};
    return clock == CLOCK_REALTIME && fails("clock") ? -1 : 0;
}

/* --- opening ------------------------------------------------------------------------------------------------------ */

static void begin(failing_t failing)
{
    begin_calls(failing);
    kernel = (struct kernel){.flags = IFF_UP | IFF_BROADCAST,
                             .family = ARPHRD_ETHER,
                             .index = INDEX,
                             .glink = 1,
                             .now_ns = 5000 * MS,
                             .list = ""};
}

static int open_port(ect_packet_t *port, char *message)
{
    *message = 0;
    memset(port, 0xA5, sizeof *port);
    return ect_packet_open(port, "ectwin0", message);
}

static void must_open(ect_packet_t *port)
{
    char message[ECT_PACKET_MESSAGE];
    if (open_port(port, message) != 0)
        fail_msg("%s", message);
}

static void opened(void **state)
{
    static const struct {
        const char *title;
        failing_t failing;
        uint64_t wait_ns;
    } rows[] = {
        {"a tick of 4 ms", {0}, 8 * MS},
        {"no timeout", {"setsockopt", 128, EINVAL}, 0},
        {"no tick", {"getsockopt", FIRST, EINVAL}, 0},
    };
    (void)state;
    for (size_t n = 0; n < 4 * (sizeof rows / sizeof rows[0]); n++) {
        const size_t i = n / 4;
        ect_packet_t port;
        begin(rows[i].failing);
        calls.zero_at = n % 4;
        must_open(&port);
        EXPECT_LOG(rows[i].title, "filter 1\nbind 1 88b5 7\n"
                                  "filter 0\nincoming 0 1\nbind 0 0003 7\n"
                                  "filter 2\nincoming 2 1\nbind 2 0003 7\ntags 2 1\n"
                                  "promiscuous 0 7 1\ntimeout 0\n");
        assert_true(place_of(port.fd) == 0 && place_of(port.claim_fd) == 1 && place_of(port.tagged_fd) == 2);
        assert_true(port.index == INDEX && strcmp(port.iface, "ectwin0") == 0 && !port.was_down && !port.shared);
        if (port.wait_ns != rows[i].wait_ns)
            fail_msg("%s: it waits %llu ns", rows[i].title, (unsigned long long)port.wait_ns);
        assert_int_equal(kernel.asked, 2); /* the kernel keeps times from now on */
        ect_packet_send(&port, (const uint8_t *)"\x77", 60);
        assert_non_null(strstr(calls.log, "send 60 77\n"));
        ect_packet_close(&port);
        assert_int_equal(calls.open, 0);
        assert_int_equal(kernel.flags, IFF_UP | IFF_BROADCAST);
    }
}

#define RIGHT                                                                                                          \
    "opening 'ectwin0' needs the capability CAP_NET_RAW: run it with sudo, or give it once and for all with 'sudo "    \
    "setcap cap_net_raw,cap_net_admin+ep $(realpath PATH/TO/ectwin)', or use 'ectwin with', which needs no rights"
#define ABSENT "there is no network interface 'ectwin0': 'ip -br link' lists all interfaces"
#define FULL   "binding to 'ectwin0' failed: Too many open files"

/* One line, no descriptor left open, and the interface restored. */
static void refused(void **state)
{
    static const struct {
        const char *title;
        short flags;
        failing_t failing;
        const char *message;
    } rows[] = {
        {"no right", IFF_UP, {"socket", FIRST, EPERM}, RIGHT},
        {"no access", IFF_UP, {"socket", FIRST, EACCES}, RIGHT},
        {"no descriptor",
         IFF_UP,
         {"socket", FIRST, EMFILE},
         "opening a raw socket for 'ectwin0' failed: Too many open files"},
        {"an interface that has gone", IFF_UP, {"address", FIRST, ENODEV}, ABSENT},
        {"down, without the right to bring it up",
         0,
         {"set flags", FIRST, EPERM},
         "'ectwin0' is down and bringing it up needs CAP_NET_ADMIN: run 'sudo ip link set dev ectwin0 up' first"},
        {"down, and gone meanwhile",
         0,
         {"flags", SECOND, ENODEV},
         "'ectwin0' is down and bringing it up needs CAP_NET_ADMIN: run 'sudo ip link set dev ectwin0 up' first"},
        {"no second descriptor", 0, {"socket", SECOND, EMFILE}, FULL},
        {"no third descriptor", 0, {"socket", THIRD, EMFILE}, FULL},
        {"a claim that is refused", 0, {"bind", FIRST, EMFILE}, FULL},
        {"the first bind refused", 0, {"bind", SECOND, EMFILE}, FULL},
        {"the second bind refused", 0, {"bind", THIRD, EMFILE}, FULL},
        {"the first filter refused", 0, {"setsockopt", FIRST, EMFILE}, FULL},
        {"the second filter refused", 0, {"setsockopt", SECOND, EMFILE}, FULL},
        {"the third filter refused", 0, {"setsockopt", FOURTH, EMFILE}, FULL},
        {"no tags", 0, {"setsockopt", 32, EMFILE}, FULL},
        {"not promiscuous", 0, {"setsockopt", 64, EMFILE}, FULL},
        {"a kernel that is too old",
         0,
         {"setsockopt", THIRD, ENOPROTOOPT},
         "binding to 'ectwin0' failed: Protocol not available; Linux 4.20 or newer is needed, for "
         "PACKET_IGNORE_OUTGOING"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_PACKET_MESSAGE];
        ect_packet_t port;
        begin(rows[i].failing);
        kernel.flags = rows[i].flags;
        assert_int_equal(open_port(&port, message), -1);
        if (strcmp(message, rows[i].message) != 0)
            fail_msg("%s: expected '%s', got '%s'", rows[i].title, rows[i].message, message);
        assert_int_equal(calls.open, 0);
        assert_int_equal(kernel.flags, rows[i].flags);
    }
}

/* An interface of unknown state is not changed; one that is down is up while the port is open. */
static void states_of_the_interface(void **state)
{
    ect_packet_t port;
    (void)state;
    begin((failing_t){"flags", FIRST, EINVAL});
    kernel.flags = IFF_BROADCAST;
    must_open(&port);
    assert_false(port.was_down);
    ect_packet_close(&port);
    assert_int_equal(kernel.flags, IFF_BROADCAST);
    begin((failing_t){0});
    kernel.flags = IFF_BROADCAST;
    must_open(&port);
    assert_true(port.was_down);
    assert_int_equal(kernel.flags, IFF_BROADCAST | IFF_UP);
    ect_packet_close(&port);
    assert_int_equal(kernel.flags, IFF_BROADCAST);
    begin((failing_t){0});
    kernel.family = ARPHRD_LOOPBACK;
    char message[ECT_PACKET_MESSAGE];
    assert_int_equal(open_port(&port, message), -1);
    assert_string_equal(message, "'ectwin0' is no Ethernet interface: name a NIC or one end of a veth pair");
}

#define HEAD "sk       RefCnt Type Proto  Iface R Rmem   User   Inode\n"
#define OURS "0000 3      3    88b5   7     1 0      0      11\n"

/* The list of the kernel has this port's own claim, and the sockets of others. */
static void other_programs(void **state)
{
    static const struct {
        const char *title, *list;
        bool taken;
    } rows[] = {
        {"none", HEAD OURS, false},
        {"a list that cannot be read", NULL, false},
        {"another port", HEAD OURS "0000 3      3    88b5   7     1 0      0      12\n", true},
        {"a master", HEAD "0000 3      3    88a4   7     1 0      1000      12\n" OURS, true},
        {"a master at another interface", HEAD OURS "0000 3      3    88a4   8     1 0      0      12\n", false},
        {"a master at all interfaces", HEAD OURS "0000 3      3    88a4   0     1 0      0      12\n", false},
        {"a recorder", HEAD OURS "0000 3      3    0003   7     1 0      0      12\n", false},
        {"datagrams", HEAD OURS "0000 3      2    88a4   7     1 0      0      12\n", false},
        {"a line that is cut", HEAD OURS "0000 3      3    88a4   7     1 0\n", false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_PACKET_MESSAGE];
        ect_packet_t port;
        begin((failing_t){0});
        kernel.list = rows[i].list;
        int result = open_port(&port, message);
        if (result != (rows[i].taken ? -1 : 0))
            fail_msg("%s: got %d '%s'", rows[i].title, result, message);
        if (result == 0)
            ect_packet_close(&port);
        else
            assert_string_equal(
                message,
                "another program has 'ectwin0' open for EtherCAT already, a twin or a master: end that one first");
        assert_int_equal(calls.open, 0);
    }
}

/* --- receiving ---------------------------------------------------------------------------------------------------- */

static void causes_of_nothing(void **state)
{
    static const struct {
        const char *title;
        int error, index;
        bool no_index;
        ssize_t want;
        int want_error;
    } rows[] = {
        {"no frame", EAGAIN, INDEX, false, ECT_PACKET_NONE, 0},
        {"a signal", EINTR, INDEX, false, ECT_PACKET_NONE, 0},
        {"down", ENETDOWN, INDEX, false, ECT_PACKET_NONE, 0},
        {"gone", ENETDOWN, 0, true, ECT_PACKET_GONE, ENODEV},
        {"gone, and another one has its name", ENETDOWN, INDEX + 1, false, ECT_PACKET_GONE, ENODEV},
        {"another error", ENXIO, INDEX, false, ECT_PACKET_GONE, ENXIO},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_time_t time = {.now_ns = 1, .waited_ns = 2};
        uint8_t frame[ROOM];
        ect_packet_t port;
        begin((failing_t){0});
        must_open(&port);
        calls.failing = (failing_t){"recv", (unsigned int)ALL, rows[i].error};
        kernel.index = rows[i].no_index ? -1 : rows[i].index;
        ssize_t got = ect_packet_receive(&port, true, frame, sizeof frame, &time);
        if (got != rows[i].want || (rows[i].want_error != 0 && errno != rows[i].want_error))
            fail_msg("%s: got %zd, %s", rows[i].title, got, strerror(errno));
        assert_int_equal(kernel.flags_of_recv, MSG_TRUNC);
        assert_true(time.now_ns == 1 && time.waited_ns == 2);
        ect_packet_close(&port);
    }
}

/* The age of a frame is read where it may matter; an old one is stale when another one waits. */
static void ages(void **state)
{
    static const struct {
        const char *title;
        uint64_t since_ns, age_ns; /* since the arrival of the frame before */
        size_t waiting;
        unsigned int asked;
        uint64_t waited_ns;
        ssize_t want;
    } rows[] = {
        {"the first", 0, 10 * US, 0, 1, 10 * US, 60},
        {"soon after it", 199 * US, 150 * US, 1, 0, 0, 60},
        {"at the bound", 1 * US, 150 * US, 1, 0, 0, 60},
        {"behind the bound", 1, 100 * US, 1, 1, 100 * US, 60},
        {"5 ms", 6 * MS, 5 * MS, 1, 1, 5 * MS, 60},
        {"more than 5 ms, alone", 6 * MS, 5 * MS + 1, 0, 1, 5 * MS + 1, 60},
        {"more than 5 ms", 6 * MS, 5 * MS + 1, 1, 1, 5 * MS + 1, ECT_PACKET_STALE},
        {"7 s", 7000 * MS, 7000 * MS, 1, 1, 7000 * MS, ECT_PACKET_STALE},
    };
    ect_packet_t port;
    uint64_t arrival_ns = 0;
    (void)state;
    begin((failing_t){0});
    must_open(&port);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_time_t time = {0};
        uint8_t frame[ROOM];
        kernel.now_ns += rows[i].since_ns;
        kernel.age_ns = rows[i].age_ns;
        kernel.length = 60;
        kernel.waiting = rows[i].waiting;
        kernel.asked = 0;
        ssize_t got = ect_packet_receive(&port, false, frame, sizeof frame, &time);
        if (got != rows[i].want || time.waited_ns != rows[i].waited_ns || kernel.asked != rows[i].asked)
            fail_msg("%s: got %zd, waited %llu ns, asked %u times", rows[i].title, got,
                     (unsigned long long)time.waited_ns, kernel.asked);
        assert_int_equal(kernel.flags_of_recv, MSG_TRUNC | MSG_DONTWAIT);
        assert_true(time.now_ns == kernel.now_ns);
        arrival_ns = rows[i].asked > 0 ? kernel.now_ns - rows[i].age_ns : arrival_ns;
        assert_true(port.came_ns == arrival_ns);
        if (i == 0)
            kernel.now_ns -= rows[i].age_ns; /* the next rows count from the arrival */
    }
    ect_packet_close(&port);
}

/* No clock, a clock that was set back, a frame without a time: it is new. */
static void unknown_ages(void **state)
{
    static const struct {
        failing_t failing;
        uint64_t age_ns;
    } rows[] = {{{"clock", FIRST, EINVAL}, 9 * MS}, {{"stamp", FIRST, ENOENT}, 9 * MS}, {{0}, 0 - 9 * MS}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_time_t time = {0};
        uint8_t frame[ROOM];
        ect_packet_t port;
        begin((failing_t){0});
        must_open(&port);
        calls.failing = rows[i].failing;
        kernel.age_ns = rows[i].age_ns;
        kernel.length = 60;
        kernel.waiting = 1;
        assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), 60);
        assert_true(time.waited_ns == 0 && time.now_ns == kernel.now_ns);
        ect_packet_close(&port);
    }
}

/* The kernel has taken the tag out of the frame: the tag is restored in its place, if there is room. */
static void tags(void **state)
{
    static const struct {
        const char *title;
        uint32_t status;
        ssize_t length;
        size_t room;
        ssize_t want;
        uint16_t type; /* 0: the frame has no tag */
    } rows[] = {
        {"a tag", TP_STATUS_VLAN_VALID, 60, ROOM, 64, 0x8100},
        {"a tag of another type", TP_STATUS_VLAN_VALID | TP_STATUS_VLAN_TPID_VALID, 60, ROOM, 64, 0x88A8},
        {"a tag that just fits", TP_STATUS_VLAN_VALID, 60, 64, 64, 0x8100},
        {"a tag without room", TP_STATUS_VLAN_VALID, 60, 63, 60, 0},
        {"no tag", TP_STATUS_VLAN_TPID_VALID, 60, ROOM, 60, 0},
        {"two addresses", TP_STATUS_VLAN_VALID, 12, ROOM, 16, 0x8100},
        {"less than two addresses", TP_STATUS_VLAN_VALID, 11, ROOM, 11, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_time_t time = {0};
        uint8_t frame[ROOM + 4];
        ect_packet_t port;
        begin((failing_t){0});
        must_open(&port);
        kernel.tagged = true;
        kernel.tag_status = rows[i].status;
        kernel.length = rows[i].length;
        kernel.age_ns = 3 * MS;
        memset(frame, 0xEE, sizeof frame);
        ssize_t got = ect_packet_receive(&port, false, frame, rows[i].room, &time);
        for (size_t n = (size_t)rows[i].want; n < sizeof frame; n++)
            assert_int_equal(frame[n], n < rows[i].room ? (uint8_t)n : 0xEE); /* as the kernel left them */
        const size_t shift = rows[i].type != 0 ? 4 : 0;
        if (got != rows[i].want)
            fail_msg("%s: got %zd", rows[i].title, got);
        for (size_t n = 0; n < (size_t)rows[i].length; n++)
            assert_int_equal(frame[n < 12 ? n : n + shift], n);
        if (shift > 0 && (ect_load_be16(frame + 12) != rows[i].type || ect_load_be16(frame + 14) != 0xA007))
            fail_msg("%s: got the tag %04x", rows[i].title, ect_load_be16(frame + 12));
        assert_true(time.waited_ns == 3 * MS && port.came_ns == 0); /* that is of the other socket */
        assert_int_equal(port.wait_ns, 0);                          /* a wait would not detect the next one */
        kernel.tagged = false;
        assert_int_equal(ect_packet_receive(&port, true, frame, rows[i].room, &time), rows[i].length);
        kernel.length = 0;
        assert_int_equal(ect_packet_receive(&port, false, frame, rows[i].room, &time), ECT_PACKET_NONE);
        ect_packet_close(&port);
    }
}

/* The kernel counts from one question to the next. */
static void lost_frames(void **state)
{
    ect_packet_t port;
    (void)state;
    begin((failing_t){0});
    must_open(&port);
    assert_int_equal(ect_packet_lost(&port), 0);
    kernel.lost[0] = 5;
    kernel.lost[1] = 2;
    assert_int_equal(ect_packet_lost(&port), 7);
    assert_int_equal(ect_packet_lost(&port), 0);
    kernel.lost[0] = 5;
    calls.failing = (failing_t){"getsockopt", FIRST, ENOPROTOOPT};
    calls.made = 0;
    assert_int_equal(ect_packet_lost(&port), 0);
    calls.failing = (failing_t){0};
    ect_packet_close(&port);
    memset(kernel.lost, 0, sizeof kernel.lost);
}

static void link_of_the_interface(void **state)
{
    static const struct {
        int glink;
        short flags;
        failing_t failing;
        bool want;
    } rows[] = {
        {1, 0, {0}, true},
        {0, IFF_RUNNING, {0}, false},
        {-1, IFF_UP | IFF_RUNNING, {0}, true},
        {-1, IFF_UP, {0}, false},
        {-1, IFF_UP | IFF_RUNNING, {"flags", FIRST, ENODEV}, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_t port;
        begin((failing_t){0});
        must_open(&port);
        calls.failing = rows[i].failing;
        kernel.glink = rows[i].glink;
        kernel.flags = rows[i].flags;
        assert_int_equal(ect_packet_has_link(&port), rows[i].want);
        ect_packet_close(&port);
    }
}

/* --- shared memory ------------------------------------------------------------------------------------------------ */

static void sharing_refused(void **state)
{
    static const struct {
        failing_t failing;
        const char *want;
    } rows[] = {
        {{"setsockopt", FIRST, EINVAL}, "version 0\n"},
        {{"setsockopt", SECOND, ENOMEM}, "version 0\nring 0 128\n"},
        {{"mmap", FIRST, ENOMEM}, "version 0\nring 0 128\nring 0 0\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_packet_time_t time;
        uint8_t frame[ROOM];
        ect_packet_t port;
        begin((failing_t){0});
        must_open(&port);
        calls.failing = rows[i].failing;
        calls.used = 0;
        assert_false(ect_packet_share(&port));
        EXPECT_LOG("sharing", rows[i].want);
        kernel.length = 60; /* it receives as before */
        assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), 60);
        assert_int_equal(port.tagged_fd, TAGGED);
        ect_packet_close(&port);
        assert_int_equal(calls.open, 0);
    }
}

static struct tpacket2_hdr *slot(size_t number)
{
    return (struct tpacket2_hdr *)(void *)(kernel.ring + number * SLOT);
}

static void put_frame(size_t number, uint32_t length, uint64_t age_ns, uint32_t status)
{
    const uint64_t came_ns = 1000 * 1000 * MS + kernel.now_ns - age_ns;
    *slot(number) = (struct tpacket2_hdr){.tp_status = TP_STATUS_USER | status,
                                          .tp_len = length,
                                          .tp_snaplen = length,
                                          .tp_mac = 96,
                                          .tp_vlan_tci = 0xA007,
                                          .tp_vlan_tpid = 0x88A8,
                                          .tp_sec = (uint32_t)(came_ns / 1000000000),
                                          .tp_nsec = (uint32_t)(came_ns % 1000000000)};
    for (size_t i = 0; i < length; i++)
        kernel.ring[number * SLOT + 96 + i] = (uint8_t)(number + i);
}

static void open_shared(ect_packet_t *port)
{
    static _Alignas(64) uint8_t ring[SLOT * SLOTS];
    begin((failing_t){0});
    memset(ring, 0, sizeof ring);
    kernel.ring = ring;
    must_open(port);
    calls.used = 0;
    assert_true(ect_packet_share(port));
    EXPECT_LOG("sharing", "version 0\nring 0 128\nfilter 0\n");
    assert_true(port->tagged_fd == -1 && calls.open == 2);
}

/* Frames in their order, around the end of the memory; each slot is given back to the kernel. */
static void shared_frames(void **state)
{
    ect_packet_time_t time;
    uint8_t frame[ROOM];
    ect_packet_t port;
    (void)state;
    open_shared(&port);
    for (size_t n = 0; n < 2 * SLOTS + 3; n++) {
        const size_t at = n % SLOTS;
        const uint32_t status = n % 2 == 0 ? 0 : TP_STATUS_VLAN_VALID;
        put_frame(at, 60, n * US, status);
        memset(frame, 0xEE, sizeof frame);
        assert_int_equal(ect_packet_receive(&port, true, frame, sizeof frame, &time), status == 0 ? 60 : 64);
        assert_true(time.now_ns == kernel.now_ns && time.waited_ns == n * US);
        assert_int_equal(frame[0], (uint8_t)at);
        assert_int_equal(frame[status == 0 ? 59 : 63], (uint8_t)(at + 59));
        assert_int_equal(frame[64], 0xEE);
        assert_int_equal(slot(at)->tp_status, TP_STATUS_KERNEL);
    }
    put_frame(3, 60, 0, 0); /* longer than the room */
    memset(frame, 0xEE, sizeof frame);
    assert_int_equal(ect_packet_receive(&port, false, frame, 40, &time), 60);
    assert_true(frame[39] == 42 && frame[40] == 0xEE);
    ect_packet_close(&port);
    assert_non_null(strstr(calls.log, "unmapped\n"));
    assert_int_equal(calls.open, 0);
}

static void shared_stale_frames(void **state)
{
    ect_packet_time_t time;
    uint8_t frame[ROOM];
    ect_packet_t port;
    (void)state;
    open_shared(&port);
    put_frame(0, 60, 5 * MS, 0);
    put_frame(1, 61, 5 * MS + 1, 0);
    put_frame(2, 62, 5 * MS + 1, 0);
    assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), 60);
    assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), ECT_PACKET_STALE);
    assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), 62); /* the last one */
    assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), ECT_PACKET_NONE);
    ect_packet_close(&port);
}

/* An empty memory does not show that the interface has gone: it is looked for every 65536 reads. */
static void shared_and_gone(void **state)
{
    static const unsigned int checks[] = {65536, 65536};
    ect_packet_time_t time;
    uint8_t frame[ROOM];
    ect_packet_t port;
    (void)state;
    open_shared(&port);
    for (size_t check = 0; check < 2; check++) {
        kernel.index = check == 0 ? INDEX : INDEX + 1;
        for (unsigned int n = 1; n <= checks[check]; n++) {
            ssize_t want = check == 1 && n == checks[check] ? ECT_PACKET_GONE : ECT_PACKET_NONE;
            assert_int_equal(ect_packet_receive(&port, false, frame, sizeof frame, &time), want);
        }
    }
    assert_int_equal(errno, ENODEV);
    ect_packet_close(&port);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a port has three sockets, each bound to its interface, and closes them", opened, NULL, NULL, NULL},
        {"a step that fails: one line with the cause, no open descriptor, the interface restored", refused, NULL, NULL,
         NULL},
        {"an interface that is down is up while its port is open", states_of_the_interface, NULL, NULL, NULL},
        {"an interface with an EtherCAT socket of another program is refused", other_programs, NULL, NULL, NULL},
        {"no frame, or no interface, by the cause", causes_of_nothing, NULL, NULL, NULL},
        {"a frame older than 5 ms is stale when another one waits; its age is read when it may matter", ages, NULL,
         NULL, NULL},
        {"a frame of unknown age is new", unknown_ages, NULL, NULL, NULL},
        {"A tag is restored in its place, if the frame has room for it", tags, NULL, NULL, NULL},
        {"frames that the queues of a port have lost are counted once", lost_frames, NULL, NULL, NULL},
        {"the link by the driver, or by the flags of the interface", link_of_the_interface, NULL, NULL, NULL},
        {"a kernel that shares no memory: frames are received as before", sharing_refused, NULL, NULL, NULL},
        {"shared memory: frames in their order, cut to the room, with their tags", shared_frames, NULL, NULL, NULL},
        {"shared memory: a frame older than 5 ms is stale when another one waits", shared_stale_frames, NULL, NULL,
         NULL},
        {"shared memory: an interface that has gone is noticed within 65536 reads", shared_and_gone, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ports", tests, NULL, NULL);
}
