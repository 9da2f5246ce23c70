/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/veth.h"

#include <fcntl.h>
#include <net/if.h>
#include <netlink/netlink.h>
#include <netlink/route/link.h>
#include <netlink/route/link/veth.h>
#include <stdbool.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

enum {
    OPERATIONAL = 6, /* IF_OPER_UP of linux/if.h, which excludes net/if.h */
    LONGEST_MS = 5000,
    NS_PER_MS = 1000000
};

int ect_veth_up(struct nl_sock *socket, const char *name)
{
    struct rtnl_link *link = NULL;
    struct rtnl_link *change = rtnl_link_alloc();
    int error = change ? rtnl_link_get_kernel(socket, 0, name, &link) : -NLE_NOMEM;
    if (error >= 0) {
        rtnl_link_set_flags(change, IFF_UP);
        error = rtnl_link_change(socket, link, change, 0);
        rtnl_link_put(link);
    }
    if (change)
        rtnl_link_put(change);
    return error;
}

static int add(struct nl_sock *socket, const char *one, const char *other)
{
    struct rtnl_link *link = rtnl_link_veth_alloc();
    if (!link)
        return -NLE_NOMEM;
    struct rtnl_link *peer = rtnl_link_veth_get_peer(link); /* the caller's own reference */
    rtnl_link_set_name(link, one);
    rtnl_link_set_name(peer, other);
    rtnl_link_put(peer);
    int error = rtnl_link_add(socket, link, NLM_F_CREATE | NLM_F_EXCL);
    rtnl_link_put(link);
    return error;
}

static bool is_operational(struct nl_sock *socket, const char *name)
{
    struct rtnl_link *link = NULL;
    if (rtnl_link_get_kernel(socket, 0, name, &link) < 0)
        return false;
    bool operational = rtnl_link_get_operstate(link) == OPERATIONAL;
    rtnl_link_put(link);
    return operational;
}

/* The end that is up before its peer drops all frames that it sends, until a worker of the kernel has handled its
 * carrier: on a busy machine that is after the first frame of a master. */
static void wait_until_operational(struct nl_sock *socket, const char *name)
{
    const struct timespec pause = {.tv_nsec = NS_PER_MS};
    for (unsigned int waited_ms = 0; !is_operational(socket, name) && waited_ms < LONGEST_MS; waited_ms++)
        (void)nanosleep(&pause, NULL);
}

static int bring_up(struct nl_sock *socket, const char *one, const char *other)
{
    int error = ect_veth_up(socket, one);
    if (error >= 0)
        error = ect_veth_up(socket, other);
    if (error >= 0) {
        wait_until_operational(socket, one);
        wait_until_operational(socket, other);
    }
    return error;
}

int ect_veth_add(struct nl_sock *socket, const char *one, const char *other)
{
    int error = add(socket, one, other);
    return error >= 0 ? bring_up(socket, one, other) : error;
}

/* Keeps the kernel's IPv6 packets off the pair, because they would delay frames. The file is missing on a kernel
 * without IPv6. */
static void disable_ipv6(const char *name)
{
    char path[96];
    snprintf(path, sizeof path, "/proc/sys/net/ipv6/conf/%s/disable_ipv6", name);
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return;
    (void)!write(fd, "1", 1);
    close(fd);
}

static void explain(int error, const char *one, const char *other, char *message)
{
    if (error == -NLE_PERM)
        snprintf(message, ECT_VETH_MESSAGE, "a pair of interfaces needs CAP_NET_ADMIN: run 'sudo ectwin veth %s'", one);
    else if (error == -NLE_EXIST)
        snprintf(message, ECT_VETH_MESSAGE,
                 "'%s' or '%s' exists already: choose another name, or 'sudo ip link del %s'", one, other, one);
    else if (error == -NLE_OPNOTSUPP)
        snprintf(message, ECT_VETH_MESSAGE, "this kernel has no veth driver: 'sudo modprobe veth' loads it");
    else
        snprintf(message, ECT_VETH_MESSAGE, "making a pair of interfaces failed: %s", nl_geterror(error));
}

static int connect_socket(struct nl_sock **socket)
{
    *socket = nl_socket_alloc();
    return *socket ? nl_connect(*socket, NETLINK_ROUTE) : -NLE_NOMEM;
}

int ect_veth_create(const char *one, const char *other, char *message)
{
    struct nl_sock *socket;
    int error = connect_socket(&socket);
    if (error >= 0)
        error = add(socket, one, other);
    if (error >= 0) {
        disable_ipv6(one);
        disable_ipv6(other);
        error = bring_up(socket, one, other);
        if (error < 0)
            (void)ect_veth_destroy(one);
    }
    nl_socket_free(socket);
    if (error < 0)
        explain(error, one, other, message);
    return error < 0 ? -1 : 0;
}

int ect_veth_destroy(const char *one)
{
    struct nl_sock *socket;
    struct rtnl_link *link = NULL;
    int error = connect_socket(&socket);
    if (error >= 0)
        error = rtnl_link_get_kernel(socket, 0, one, &link);
    if (error >= 0)
        error = rtnl_link_delete(socket, link);
    if (link)
        rtnl_link_put(link);
    nl_socket_free(socket);
    return error < 0 ? -1 : 0;
}
