/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/packet.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/ethtool.h>
#include <linux/if_packet.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum { ETHERTYPE_ECAT = 0x88A4 };

/* A process that was held up finds frames that its master has long given up. Answered, they would be taken for answers
 * to newer ones (SOEM tells them apart by 4 bits), and the master would stay that far behind. A wire does not store
 * frames. */
#define STALE_NS 5000000

#ifndef PACKET_IGNORE_OUTGOING
#define PACKET_IGNORE_OUTGOING 23
#endif

static void explain_socket(const char *iface, char *message)
{
    if (errno == EPERM || errno == EACCES)
        snprintf(
            message, ECT_PACKET_MESSAGE,
            "opening '%s' needs the capability CAP_NET_RAW: run it with sudo, or give it once and for all with "
            "'sudo setcap cap_net_raw,cap_net_admin+ep $(realpath PATH/TO/ectwin)', or use 'ectwin with', which needs "
            "no rights",
            iface);
    else
        snprintf(message, ECT_PACKET_MESSAGE, "opening a raw socket for '%s' failed: %s", iface, strerror(errno));
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

/* Two twins on one interface would both answer. Abstract socket names belong to the network namespace, as interfaces
 * do. */
static int claim(ect_packet_t *port, char *message)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX}; /* abstract: the name begins with 0 */
    int length = snprintf(address.sun_path + 1, sizeof address.sun_path - 1, "ectwin-%s", port->iface);
    socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)length);
    port->claim_fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (port->claim_fd >= 0 && bind(port->claim_fd, (const struct sockaddr *)&address, size) == 0)
        return 0;
    if (errno == EADDRINUSE)
        snprintf(message, ECT_PACKET_MESSAGE, "another ectwin answers on '%s' already: end that one first",
                 port->iface);
    else
        snprintf(message, ECT_PACKET_MESSAGE, "claiming '%s' failed: %s", port->iface, strerror(errno));
    return -1;
}

/* 0, or -1 with the message written. */
static int check_interface(ect_packet_t *port, char *message)
{
    struct ifreq request = {0};
    memcpy(request.ifr_name, port->iface, sizeof request.ifr_name);
    if (ioctl(port->fd, SIOCGIFHWADDR, &request) < 0) {
        snprintf(message, ECT_PACKET_MESSAGE, "there is no network interface '%s': 'ip -br link' lists those there are",
                 port->iface);
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

static int bind_to(ect_packet_t *port, char *message)
{
    port->index = if_nametoindex(port->iface);
    int index = (int)port->index;
    struct sockaddr_ll address = {.sll_family = AF_PACKET, .sll_protocol = htons(ETHERTYPE_ECAT), .sll_ifindex = index};
    struct packet_mreq promiscuous = {.mr_ifindex = index, .mr_type = PACKET_MR_PROMISC};
    int on = 1;
    if (bind(port->fd, (const struct sockaddr *)&address, sizeof address) < 0 ||
        setsockopt(port->fd, SOL_PACKET, PACKET_ADD_MEMBERSHIP, &promiscuous, sizeof promiscuous) < 0) {
        snprintf(message, ECT_PACKET_MESSAGE, "binding to '%s' failed: %s", port->iface, strerror(errno));
        return -1;
    }
    if (setsockopt(port->fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on) < 0) {
        snprintf(message, ECT_PACKET_MESSAGE,
                 "this kernel lacks PACKET_IGNORE_OUTGOING: Linux 4.20 or newer is needed");
        return -1;
    }
    return 0;
}

int ect_packet_open(ect_packet_t *port, const char *iface, char *message)
{
    memset(port, 0, sizeof *port);
    if (strlen(iface) >= sizeof port->iface) {
        snprintf(message, ECT_PACKET_MESSAGE, "'%s' is no interface name: they have at most 15 characters", iface);
        return -1;
    }
    memcpy(port->iface, iface, strlen(iface) + 1);
    port->fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); /* nothing arrives before the bind */
    if (port->fd < 0) {
        explain_socket(iface, message);
        return -1;
    }
    if (claim(port, message) < 0 || check_interface(port, message) < 0 || bind_to(port, message) < 0) {
        ect_packet_close(port);
        return -1;
    }
    return 0;
}

void ect_packet_close(ect_packet_t *port)
{
    if (port->was_down)
        (void)set_flags(port->fd, port->iface, false);
    close(port->fd);
    close(port->claim_fd);
    port->fd = port->claim_fd = -1;
}

/* Nanoseconds that the frame received last has waited for us; 0 when the clock was set meanwhile. */
static uint64_t age(int fd)
{
    long long came[2]; /* seconds, nanoseconds */
    struct timespec now;
    if (ioctl(fd, SIOCGSTAMPNS_NEW, came) < 0 || clock_gettime(CLOCK_REALTIME, &now) < 0)
        return 0;
    int64_t waited = (now.tv_sec - came[0]) * 1000000000 + (now.tv_nsec - came[1]);
    return waited > 0 ? (uint64_t)waited : 0;
}

static bool another_waits(int fd)
{
    uint8_t byte;
    return recv(fd, &byte, sizeof byte, MSG_PEEK | MSG_DONTWAIT) > 0;
}

/* A link that went down may come back; an interface that is gone may not, and Linux says the same of both. */
static ssize_t why_nothing(const ect_packet_t *port)
{
    if (errno == EAGAIN || errno == EINTR)
        return ECT_PACKET_NONE;
    if (errno != ENETDOWN)
        return ECT_PACKET_GONE;
    if (if_nametoindex(port->iface) == port->index)
        return ECT_PACKET_NONE;
    errno = ENODEV;
    return ECT_PACKET_GONE;
}

ssize_t ect_packet_receive(const ect_packet_t *port, uint8_t *frame, size_t room, uint64_t *waited_ns)
{
    ssize_t length = recv(port->fd, frame, room, MSG_TRUNC);
    if (length < 0)
        return why_nothing(port);
    *waited_ns = age(port->fd);
    return *waited_ns > STALE_NS && another_waits(port->fd) ? ECT_PACKET_STALE : length;
}

void ect_packet_send(const ect_packet_t *port, const uint8_t *frame, size_t length)
{
    (void)send(port->fd, frame, length, 0);
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

/* What they say is asked of the interface itself; one that was lost for want of room counts as a change, too. */
void ect_packet_links_seen(int fd)
{
    char message[8192];
    while (recv(fd, message, sizeof message, MSG_TRUNC) > 0 || errno == ENOBUFS)
        ;
}
