/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/netns.h"

#include <errno.h>
#include <fcntl.h>
#include <net/if.h>
#include <netlink/netlink.h>
#include <netlink/route/link.h>
#include <netlink/route/link/veth.h>
#include <sched.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

static bool write_file(const char *path, const char *text)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return false;
    ssize_t written = write(fd, text, strlen(text));
    int error = errno;
    close(fd);
    errno = error;
    return written == (ssize_t)strlen(text);
}

static bool read_flag(const char *path, char *flag)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return false;
    bool got = read(fd, flag, 1) == 1;
    close(fd);
    return got;
}

/* Why a user namespace could not be made, or is powerless, and what to do about it. */
static void explain(const char *step, int error, char *message)
{
    char flag = '?';
    const char *advice = "run it as root ('sudo ectwin with ...'); in a container, start that with --privileged or "
                         "--cap-add=SYS_ADMIN,NET_ADMIN,NET_RAW";
    if (read_flag("/proc/sys/kernel/apparmor_restrict_unprivileged_userns", &flag) && flag == '1')
        advice = "AppArmor forbids it here (Ubuntu 23.10 and newer): run 'sudo sysctl -w "
                 "kernel.apparmor_restrict_unprivileged_userns=0', or run it as root ('sudo ectwin with ...')";
    else if (read_flag("/proc/sys/kernel/unprivileged_userns_clone", &flag) && flag == '0')
        advice = "this kernel is set to forbid it: run 'sudo sysctl -w kernel.unprivileged_userns_clone=1', or run it "
                 "as root ('sudo ectwin with ...')";
    else if (read_flag("/proc/sys/user/max_user_namespaces", &flag) && flag == '0')
        advice = "this system allows no user namespaces: run 'sudo sysctl -w user.max_user_namespaces=1000', or run "
                 "it as root ('sudo ectwin with ...')";
    snprintf(message, ECT_NETNS_MESSAGE, "no private network: %s failed (%s); %s", step, strerror(error), advice);
}

static int enter_user_namespace(char *message)
{
    char map[64];
    unsigned int uid = geteuid();
    unsigned int gid = getegid();
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) < 0) {
        explain("making a user namespace", errno, message);
        return -1;
    }
    snprintf(map, sizeof map, "0 %u 1", uid);
    (void)prctl(PR_SET_DUMPABLE, 1); /* a binary with file capabilities may not write its own map otherwise */
    bool mapped = write_file("/proc/self/uid_map", map);
    snprintf(map, sizeof map, "0 %u 1", gid);
    if (!mapped || !write_file("/proc/self/setgroups", "deny") || !write_file("/proc/self/gid_map", map)) {
        explain("mapping the user into it", errno, message);
        return -1;
    }
    return 0;
}

static int set_up(struct nl_sock *socket, const char *name)
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

static int add_veth(struct nl_sock *socket)
{
    struct rtnl_link *link = rtnl_link_veth_alloc();
    if (!link)
        return -NLE_NOMEM;
    struct rtnl_link *peer = rtnl_link_veth_get_peer(link); /* a reference of our own */
    rtnl_link_set_name(link, ECT_NETNS_TWIN);
    rtnl_link_set_name(peer, ECT_NETNS_MASTER);
    rtnl_link_put(peer);
    int error = rtnl_link_add(socket, link, NLM_F_CREATE | NLM_F_EXCL);
    rtnl_link_put(link);
    return error;
}

/* The kernel's own IPv6 chatter has no business on this wire. Without IPv6 there is nothing to switch off. */
static void quieten(void)
{
    (void)write_file("/proc/sys/net/ipv6/conf/default/disable_ipv6", "1");
}

static int build_network(char *message)
{
    struct nl_sock *socket = nl_socket_alloc();
    int error = socket ? nl_connect(socket, NETLINK_ROUTE) : -NLE_NOMEM;
    quieten();
    if (error >= 0)
        error = add_veth(socket);
    if (error >= 0)
        error = set_up(socket, "lo");
    if (error >= 0)
        error = set_up(socket, ECT_NETNS_TWIN);
    if (error >= 0)
        error = set_up(socket, ECT_NETNS_MASTER);
    nl_socket_free(socket);
    if (error >= 0)
        return 0;
    if (error == -NLE_PERM)
        explain("making a veth pair in it", EPERM, message);
    else if (error == -NLE_OPNOTSUPP)
        snprintf(message, ECT_NETNS_MESSAGE,
                 "no private network: this kernel has no veth driver ('sudo modprobe veth' loads it)");
    else
        snprintf(message, ECT_NETNS_MESSAGE, "no private network: making a veth pair failed (%s)", nl_geterror(error));
    return -1;
}

int ect_netns_enter(char *message)
{
    bool entered = geteuid() == 0 && unshare(CLONE_NEWNET) == 0;
    if (!entered && enter_user_namespace(message) < 0)
        return -1;
    return build_network(message);
}
