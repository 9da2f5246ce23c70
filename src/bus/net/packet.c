/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/packet.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/ethtool.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "wire/bytes.h"

enum {
    ETHERTYPE_ECAT = 0x88A4,
    ETHERTYPE_CLAIM = 0x88B5, /* for local experiments (IEEE 802) */
    ETHERTYPE_VLAN = 0x8100,
    NOTHING = 0x10000,
    SLOT = 4096, /* of shared memory: room for any EtherCAT frame and the kernel's header */
    SLOTS = 128,
    BLOCK = 65536,
};

/* After a stop of this process the queue holds frames whose replies the master no longer expects. The master would
 * assign late replies to newer frames (SOEM compares 4 bits only) and stay behind by as many cycles. A wire does not
 * store frames. */
#define STALE_NS 5000000
#define NS_PER_S 1000000000ull

#ifndef PACKET_IGNORE_OUTGOING
#define PACKET_IGNORE_OUTGOING 23
#endif

static void explain_absence(const char *iface, char *message)
{
    snprintf(message, ECT_PACKET_MESSAGE, "there is no network interface '%s': 'ip -br link' lists all interfaces",
             iface);
}

/* Checks the name first: more rights do not cure a wrong name. */
static void explain_socket(const char *iface, int error, char *message)
{
    if (if_nametoindex(iface) == 0)
        explain_absence(iface, message);
    else if (error == EPERM || error == EACCES)
        snprintf(
            message, ECT_PACKET_MESSAGE,
            "opening '%s' needs the capability CAP_NET_RAW: run it with sudo, or give it once and for all with "
            "'sudo setcap cap_net_raw,cap_net_admin+ep $(realpath PATH/TO/ectwin)', or use 'ectwin with', which needs "
            "no rights",
            iface);
    else
        snprintf(message, ECT_PACKET_MESSAGE, "opening a raw socket for '%s' failed: %s", iface, strerror(error));
}

static bool set_flags(int fd, const char *iface, bool up)
{
    struct ifreq request = {0};
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", iface);
    if (ioctl(fd, SIOCGIFFLAGS, &request) < 0)
        return false;
    int flags = request.ifr_flags;
    request.ifr_flags = (short)(up ? flags | IFF_UP : flags & ~IFF_UP);
    return ioctl(fd, SIOCSIFFLAGS, &request) == 0;
}

/* @return 0; -1: `message` has the reason */
static int check_interface(ect_packet_t *port, char *message)
{
    struct ifreq request = {0};
    memcpy(request.ifr_name, port->iface, sizeof request.ifr_name);
    if (ioctl(port->fd, SIOCGIFHWADDR, &request) < 0) {
        explain_absence(port->iface, message);
        return -1;
    }
    if (request.ifr_hwaddr.sa_family != ARPHRD_ETHER) {
        snprintf(message, ECT_PACKET_MESSAGE, "'%s' is no Ethernet interface: name a NIC or one end of a veth pair",
                 port->iface);
        return -1;
    }
    if (ioctl(port->fd, SIOCGIFFLAGS, &request) < 0 || (request.ifr_flags & IFF_UP) != 0)
        return 0;
    if (!set_flags(port->fd, port->iface, true)) {
        snprintf(message, ECT_PACKET_MESSAGE,
                 "'%s' is down and bringing it up needs CAP_NET_ADMIN: run 'sudo ip link set dev %s up' first",
                 port->iface, port->iface);
        return -1;
    }
    port->was_down = true;
    return 0;
}

/* Passes frames of an EtherType (after the removal of a VLAN tag) that had least_tags..most_tags tags, 0 or 1. */
static int filter(int fd, uint32_t type, uint32_t least_tags, uint32_t most_tags)
{
    const uint32_t tags = (uint32_t)(SKF_AD_OFF + SKF_AD_VLAN_TAG_PRESENT);
    struct sock_filter program[] = {BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 12),
                                    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, type, 0, 4),
                                    BPF_STMT(BPF_LD | BPF_B | BPF_ABS, tags),
                                    BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, least_tags, 0, 2),
                                    BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, most_tags, 1, 0),
                                    BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
                                    BPF_STMT(BPF_RET | BPF_K, 0)};
    const struct sock_fprog all = {.len = sizeof program / sizeof program[0], .filter = program};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &all, sizeof all);
}

/* Marks the interface as in use in the kernel's list of packet sockets. The socket has an unused EtherType and receives
 * nothing: the kernel would copy each frame for a second EtherCAT socket. */
static int claim(ect_packet_t *port)
{
    const struct sockaddr_ll address = {
        .sll_family = AF_PACKET, .sll_protocol = htons(ETHERTYPE_CLAIM), .sll_ifindex = (int)port->index};
    port->claim_fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
    return port->claim_fd >= 0 && filter(port->claim_fd, NOTHING, 0, 0) == 0
               ? bind(port->claim_fd, (const struct sockaddr *)&address, sizeof address)
               : -1;
}

/* The kernel counts timeouts in ticks and rounds the shortest timeout up to one tick, which getsockopt() returns. The
 * result has a second tick, because the last one may be late. @return the longest wait, nanoseconds; 0: failed */
static uint64_t set_receive_timeout(int fd)
{
    struct timeval tick = {.tv_usec = 1};
    socklen_t size = sizeof tick;
    bool good = setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &tick, sizeof tick) == 0 &&
                getsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &tick, &size) == 0;
    return good ? 2000ull * (uint64_t)tick.tv_usec : 0;
}

/* Binds to ETH_P_ALL, because a socket bound to EtherCAT alone also receives tagged frames, with their tags removed.
 * Filter and options precede the bind, so no other frame is queued. */
static int bind_to_all(const ect_packet_t *port, int fd, uint32_t tags)
{
    const struct sockaddr_ll address = {
        .sll_family = AF_PACKET, .sll_protocol = htons(ETH_P_ALL), .sll_ifindex = (int)port->index};
    const int on = 1;
    return filter(fd, ETHERTYPE_ECAT, tags, tags) == 0 &&
                   setsockopt(fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on) == 0
               ? bind(fd, (const struct sockaddr *)&address, sizeof address)
               : -1;
}

/* Tagged frames have a socket of their own, because PACKET_AUXDATA adds a cost to each frame. The socket for tagged
 * frames is bound last: the kernel serves sockets in reverse order of their bind, and the last one served gets no copy
 * of the frame. */
static bool bind_both(ect_packet_t *port)
{
    const int on = 1;
    port->tagged_fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
    return port->tagged_fd >= 0 && bind_to_all(port, port->fd, 0) == 0 && bind_to_all(port, port->tagged_fd, 1) == 0 &&
           setsockopt(port->tagged_fd, SOL_PACKET, PACKET_AUXDATA, &on, sizeof on) == 0;
}

/* @return nanoseconds since a time of CLOCK_REALTIME; 0 if the clock has been set back since */
static uint64_t since(const struct timespec *came)
{
    struct timespec now;
    if (clock_gettime(CLOCK_REALTIME, &now) < 0)
        return 0;
    int64_t waited = (now.tv_sec - came->tv_sec) * (int64_t)NS_PER_S + (now.tv_nsec - came->tv_nsec);
    return waited > 0 ? (uint64_t)waited : 0;
}

/* @return the age of the last received frame, nanoseconds. The first call makes the kernel record times of arrival. */
static uint64_t age(int fd)
{
    struct timespec came;
    return ioctl(fd, SIOCGSTAMPNS, &came) == 0 ? since(&came) : 0;
}

static int bind_to(ect_packet_t *port, char *message)
{
    port->index = if_nametoindex(port->iface);
    struct packet_mreq promiscuous = {.mr_ifindex = (int)port->index, .mr_type = PACKET_MR_PROMISC};
    if (claim(port) == 0 && bind_both(port) &&
        setsockopt(port->fd, SOL_PACKET, PACKET_ADD_MEMBERSHIP, &promiscuous, sizeof promiscuous) == 0) {
        port->wait_ns = set_receive_timeout(port->fd);
        (void)age(port->fd);
        (void)age(port->tagged_fd);
        return 0;
    }
    snprintf(message, ECT_PACKET_MESSAGE, "binding to '%s' failed: %s%s", port->iface, strerror(errno),
             errno == ENOPROTOOPT ? "; Linux 4.20 or newer is needed, for PACKET_IGNORE_OUTGOING" : "");
    return -1;
}

/* Two programs that reply on one interface would destroy each other's frames. The check reads the kernel's list of
 * packet sockets, because a lock with the name of the interface could be held by a program without CAP_NET_RAW. */
static int only_one(const ect_packet_t *port, char *message)
{
    char line[160];
    unsigned int type, protocol, index, user, count = 0;
    FILE *list = fopen("/proc/self/net/packet", "re");
    while (list && fgets(line, sizeof line, list)) {
        if (sscanf(line, "%*s %*s %u %x %u %*s %*s %u", &type, &protocol, &index, &user) == 4 && type == SOCK_RAW &&
            (protocol == ETHERTYPE_ECAT || protocol == ETHERTYPE_CLAIM) && index == port->index)
            count++;
    }
    if (list)
        fclose(list);
    if (count <= 1)
        return 0;
    snprintf(message, ECT_PACKET_MESSAGE,
             "another program has '%s' open for EtherCAT already, a twin or a master: end that one first", port->iface);
    return -1;
}

int ect_packet_open(ect_packet_t *port, const char *iface, char *message)
{
    memset(port, 0, sizeof *port);
    port->claim_fd = port->tagged_fd = -1;
    if (strlen(iface) >= sizeof port->iface) {
        snprintf(message, ECT_PACKET_MESSAGE, "'%s' is no interface name: they have at most 15 characters", iface);
        return -1;
    }
    memcpy(port->iface, iface, strlen(iface) + 1);
    port->fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
    if (port->fd < 0) {
        explain_socket(iface, errno, message);
        return -1;
    }
    if (check_interface(port, message) < 0 || bind_to(port, message) < 0 || only_one(port, message) < 0) {
        ect_packet_close(port);
        return -1;
    }
    return 0;
}

void ect_packet_close(ect_packet_t *port)
{
    if (port->was_down)
        (void)set_flags(port->fd, port->iface, false);
    if (port->shared)
        (void)munmap(port->shared, SLOT * SLOTS);
    close(port->fd);
    if (port->claim_fd >= 0)
        close(port->claim_fd);
    if (port->tagged_fd >= 0)
        close(port->tagged_fd);
    port->fd = port->tagged_fd = port->claim_fd = -1;
}

uint64_t ect_packet_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

static bool another_waits(int fd)
{
    uint8_t byte;
    return recv(fd, &byte, sizeof byte, MSG_PEEK | MSG_DONTWAIT) > 0;
}

/* Not if_nametoindex(), which opens a socket: the sandbox of a running twin refuses that. */
static bool is_there(const ect_packet_t *port)
{
    struct ifreq request = {0};
    memcpy(request.ifr_name, port->iface, sizeof request.ifr_name);
    return ioctl(port->fd, SIOCGIFINDEX, &request) == 0 && request.ifr_ifindex == (int)port->index;
}

/* Linux reports ENETDOWN for a link that is down, which may come up again, and for a removed interface. */
static ssize_t why_nothing(const ect_packet_t *port)
{
    if (errno == EAGAIN || errno == EINTR)
        return ECT_PACKET_NONE;
    if (errno != ENETDOWN)
        return ECT_PACKET_GONE;
    if (is_there(port))
        return ECT_PACKET_NONE;
    errno = ENODEV;
    return ECT_PACKET_GONE;
}

/* Reinserts the VLAN tag that the kernel has removed, because the reply must carry it. @return the new length */
static ssize_t put_tag_back(const struct tpacket_auxdata *known, uint8_t *frame, size_t room, ssize_t length)
{
    enum { ADDRESSES = 12, TAG = 4 };
    uint16_t type = (known->tp_status & TP_STATUS_VLAN_TPID_VALID) != 0 ? known->tp_vlan_tpid : ETHERTYPE_VLAN;
    if ((known->tp_status & TP_STATUS_VLAN_VALID) == 0 || length < ADDRESSES || (size_t)length + TAG > room)
        return length;
    memmove(frame + ADDRESSES + TAG, frame + ADDRESSES, (size_t)length - ADDRESSES);
    ect_store_be16(frame + ADDRESSES, type);
    ect_store_be16(frame + ADDRESSES + 2, known->tp_vlan_tci);
    return length + TAG;
}

/* PACKET_STATISTICS resets the kernel's counters. */
static uint64_t lost_by(int fd)
{
    struct tpacket_stats counts = {0};
    socklen_t size = sizeof counts;
    if (fd < 0 || getsockopt(fd, SOL_PACKET, PACKET_STATISTICS, &counts, &size) < 0)
        return 0;
    return counts.tp_drops;
}

uint64_t ect_packet_lost(const ect_packet_t *port)
{
    return lost_by(port->fd) + lost_by(port->tagged_fd);
}

/* --- frames in memory that the kernel shares ---------------------------------------------------------------------- */

/* The interface is checked after this many reads without a frame, which take some milliseconds. */
enum { IDLE_READS = 65536 };

bool ect_packet_share(ect_packet_t *port)
{
    const int version = TPACKET_V2;
    const struct tpacket_req none = {0};
    const struct tpacket_req slots = {
        .tp_block_size = BLOCK, .tp_block_nr = SLOT * SLOTS / BLOCK, .tp_frame_size = SLOT, .tp_frame_nr = SLOTS};
    if (setsockopt(port->fd, SOL_PACKET, PACKET_VERSION, &version, sizeof version) < 0 ||
        setsockopt(port->fd, SOL_PACKET, PACKET_RX_RING, &slots, sizeof slots) < 0)
        return false;
    void *shared = mmap(NULL, SLOT * SLOTS, PROT_READ | PROT_WRITE, MAP_SHARED, port->fd, 0);
    if (shared == MAP_FAILED) {
        (void)setsockopt(port->fd, SOL_PACKET, PACKET_RX_RING, &none, sizeof none);
        return false;
    }
    port->shared = shared; /* each slot contains the tag, at no cost */
    (void)filter(port->fd, ETHERTYPE_ECAT, 0, 1);
    close(port->tagged_fd);
    port->tagged_fd = -1;
    return true;
}

static struct tpacket2_hdr *slot_of(const ect_packet_t *port)
{
    return (struct tpacket2_hdr *)(void *)(port->shared + (size_t)SLOT * port->slot);
}

static bool is_full(const struct tpacket2_hdr *slot)
{
    return (__atomic_load_n(&slot->tp_status, __ATOMIC_ACQUIRE) & TP_STATUS_USER) != 0;
}

static ssize_t nothing_shared(ect_packet_t *port)
{
    if (++port->idle % IDLE_READS != 0)
        return ECT_PACKET_NONE;
    errno = ENETDOWN;
    return why_nothing(port);
}

static ssize_t receive_shared(ect_packet_t *port, uint8_t *frame, size_t room, ect_packet_time_t *time)
{
    struct tpacket2_hdr *slot = slot_of(port);
    if (!is_full(slot))
        return nothing_shared(port);
    const struct tpacket_auxdata known = {
        .tp_status = slot->tp_status, .tp_vlan_tci = slot->tp_vlan_tci, .tp_vlan_tpid = slot->tp_vlan_tpid};
    const struct timespec came = {.tv_sec = slot->tp_sec, .tv_nsec = slot->tp_nsec};
    ssize_t length = slot->tp_len;
    memcpy(frame, (const uint8_t *)slot + slot->tp_mac, slot->tp_snaplen < room ? slot->tp_snaplen : room);
    __atomic_store_n(&slot->tp_status, TP_STATUS_KERNEL, __ATOMIC_RELEASE);
    port->slot = (port->slot + 1) % SLOTS;
    *time = (ect_packet_time_t){.now_ns = ect_packet_now(), .waited_ns = since(&came)};
    length = put_tag_back(&known, frame, room, length);
    return time->waited_ns > STALE_NS && is_full(slot_of(port)) ? ECT_PACKET_STALE : length;
}

/* --- a frame there and back --------------------------------------------------------------------------------------- */

static ssize_t receive_tagged(ect_packet_t *port, uint8_t *frame, size_t room)
{
    _Alignas(struct cmsghdr) char known[256];
    struct tpacket_auxdata tag;
    struct iovec part = {.iov_base = frame, .iov_len = room};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1, .msg_control = known, .msg_controllen = sizeof known};
    ssize_t length = recvmsg(port->tagged_fd, &message, MSG_TRUNC | MSG_DONTWAIT);
    if (length < 0)
        return length;
    port->wait_ns = 0; /* a wait on `fd` does not end at tagged frames */
    for (struct cmsghdr *one = CMSG_FIRSTHDR(&message); one; one = CMSG_NXTHDR(&message, one)) {
        if (one->cmsg_level == SOL_PACKET && one->cmsg_type == PACKET_AUXDATA) {
            memcpy(&tag, CMSG_DATA(one), sizeof tag);
            length = put_tag_back(&tag, frame, room, length);
        }
    }
    return length;
}

bool ect_packet_arrived(int fd, uint64_t *came_ns, ect_packet_time_t *time)
{
    *time = (ect_packet_time_t){.now_ns = ect_packet_now()};
    if (came_ns && time->now_ns - *came_ns <= ECT_PACKET_ASK_NS)
        return false;
    time->waited_ns = age(fd);
    if (came_ns)
        *came_ns = time->now_ns - time->waited_ns;
    return time->waited_ns > STALE_NS && another_waits(fd);
}

ssize_t ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time)
{
    int fd = port->fd;
    if (port->shared)
        return receive_shared(port, frame, room, time);
    ssize_t length = recv(fd, frame, room, MSG_TRUNC | (wait ? 0 : MSG_DONTWAIT));
    if (length < 0 && errno == EAGAIN && !wait && port->tagged_fd >= 0) {
        fd = port->tagged_fd;
        length = receive_tagged(port, frame, room);
    }
    if (length < 0)
        return why_nothing(port);
    bool stale = ect_packet_arrived(fd, fd == port->fd ? &port->came_ns : NULL, time);
    return stale ? ECT_PACKET_STALE : length;
}

void ect_packet_send(const ect_packet_t *port, const uint8_t *frame, size_t length)
{
    (void)send(port->fd, frame, length, MSG_DONTWAIT);
}

bool ect_packet_has_link(const ect_packet_t *port)
{
    struct ethtool_value link = {.cmd = ETHTOOL_GLINK};
    struct ifreq request = {.ifr_data = (char *)&link};
    memcpy(request.ifr_name, port->iface, sizeof request.ifr_name);
    if (ioctl(port->fd, SIOCETHTOOL, &request) == 0)
        return link.data != 0;
    return ioctl(port->fd, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_RUNNING) != 0;
}

int ect_packet_watch_links(void)
{
    const struct sockaddr_nl links = {.nl_family = AF_NETLINK, .nl_groups = RTMGRP_LINK};
    int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE);
    if (fd >= 0 && bind(fd, (const struct sockaddr *)&links, sizeof links) < 0) {
        close(fd);
        return -1;
    }
    return fd;
}

/* The content is ignored, because the state is read from the interface. A message lost for lack of room is a change
 * too. */
void ect_packet_links_seen(int fd)
{
    char message[8192];
    while (recv(fd, message, sizeof message, MSG_TRUNC) > 0 || errno == ENOBUFS)
        ;
}
