/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/netns.h"

#include <errno.h>
#include <fcntl.h>
#include <net/if.h>
#include <netlink/netlink.h>
#include <sched.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/net/veth.h"

const char *const ect_netns_twin[ECT_NETNS_WIRES] = {"ectwin0", "ectwin1"};

const char *ect_netns_unfit(const char *name)
{
    if (*name == 0 || strlen(name) >= IFNAMSIZ)
        return "a name has 1 to 15 characters";
    if (strpbrk(name, "/: \t\n\v\f\r") || strcmp(name, ".") == 0 || strcmp(name, "..") == 0)
        return "a name has no blank, '/' or ':' in it, and is not '.' or '..'";
    if (strcmp(name, "lo") == 0 || strcmp(name, ect_netns_twin[0]) == 0 || strcmp(name, ect_netns_twin[1]) == 0)
        return "'lo', 'ectwin0' and 'ectwin1' are reserved";
    return NULL;
}

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

/* Writes the cause and the cure for a user namespace that could not be made, or has no rights. */
static void explain(const char *step, int error, char *message)
{
    char flag = '?';
    const char *advice =
        "run it as root ('sudo ectwin with ...'); in a container, start the container with --privileged or "
        "--cap-add=SYS_ADMIN,NET_ADMIN,NET_RAW";
    if (read_flag("/proc/sys/kernel/apparmor_restrict_unprivileged_userns", &flag) && flag == '1')
        advice = "AppArmor forbids user namespaces (Ubuntu 23.10 and newer): run 'sudo sysctl -w "
                 "kernel.apparmor_restrict_unprivileged_userns=0', or run it as root ('sudo ectwin with ...')";
    else if (read_flag("/proc/sys/kernel/unprivileged_userns_clone", &flag) && flag == '0')
        advice = "this kernel forbids unprivileged user namespaces: run 'sudo sysctl -w "
                 "kernel.unprivileged_userns_clone=1', or run it "
                 "as root ('sudo ectwin with ...')";
    else if (read_flag("/proc/sys/user/max_user_namespaces", &flag) && flag == '0')
        advice = "this system allows no user namespaces: run 'sudo sysctl -w user.max_user_namespaces=1000', or run "
                 "it as root ('sudo ectwin with ...')";
    snprintf(message, ECT_NETNS_MESSAGE,
             "no private network: %s failed (%s); %s; or run the twins inside CMD: --in-process", step, strerror(error),
             advice);
}

enum { NAMESPACES = CLONE_NEWNET | CLONE_NEWNS };

static int enter_user_namespace(char *message)
{
    char map[64];
    unsigned int uid = geteuid();
    unsigned int gid = getegid();
    if (unshare(CLONE_NEWUSER | NAMESPACES) < 0) {
        explain("making a user namespace", errno, message);
        return -1;
    }
    snprintf(map, sizeof map, "0 %u 1", uid);
    (void)prctl(PR_SET_DUMPABLE, 1); /* a binary with file capabilities may not write its own map otherwise */
    bool mapped = write_file("/proc/self/uid_map", map);
    snprintf(map, sizeof map, "0 %u 1", gid);
    if (!mapped || !write_file("/proc/self/setgroups", "deny") || !write_file("/proc/self/gid_map", map)) {
        explain("mapping the user", errno, message);
        return -1;
    }
    return 0;
}

/* Makes a map that keeps the number of each id that exists in the present namespace. @param of id map of this process,
 * with lines "inside outside count" */
static bool same_ids(const char *of, char *map, size_t room)
{
    FILE *ours = fopen(of, "re");
    unsigned int inside, outside, count;
    size_t used = 0;
    /* NOLINTNEXTLINE(cert-err34-c): the kernel wrote these numbers */
    while (ours && used < room && fscanf(ours, "%u %u %u", &inside, &outside, &count) == 3)
        used += (size_t)snprintf(map + used, room - used, "%u %u %u\n", inside, inside, count);
    if (ours)
        fclose(ours);
    return used > 0 && used < room;
}

/* Maps the ids of a process that enters a user namespace, after its entry: only a process outside may map more than one
 * id. */
static int map_from_outside(pid_t inside, int go)
{
    char map[2][1024];
    char path[64];
    char byte;
    if (!same_ids("/proc/self/uid_map", map[0], sizeof map[0]) ||
        !same_ids("/proc/self/gid_map", map[1], sizeof map[1]) || read(go, &byte, 1) != 1)
        return 1;
    snprintf(path, sizeof path, "/proc/%d/uid_map", (int)inside);
    bool mapped = write_file(path, map[0]);
    snprintf(path, sizeof path, "/proc/%d/gid_map", (int)inside);
    return mapped && write_file(path, map[1]) ? 0 : 1;
}

/* Enters the namespaces as root: the access to files remains, the rights end at the namespace. @param[out] entered
 * whether the process is in the namespaces. @return false: nothing has changed, or, with `entered`, the process is in a
 * namespace without mapped ids */
static bool enter_as_root(bool *entered)
{
    int go[2];
    int status = 1;
    pid_t self = getpid();
    if (pipe2(go, O_CLOEXEC) < 0)
        return false;
    pid_t helper = fork();
    if (helper == 0) {
        close(go[1]);
        _exit(map_from_outside(self, go[0]));
    }
    close(go[0]);
    *entered = helper > 0 && unshare(CLONE_NEWUSER | NAMESPACES) == 0;
    bool sent = *entered && write(go[1], "", 1) == 1;
    close(go[1]);
    if (helper > 0)
        (void)waitpid(helper, &status, 0);
    return sent && status == 0;
}

static int enter_namespaces(unsigned int *lacks, char *message)
{
    bool entered = false;
    if (geteuid() != 0)
        return enter_user_namespace(message);
    if (enter_as_root(&entered))
        return 0;
    if (entered) {
        explain("mapping the users", EPERM, message);
        return -1;
    }
    *lacks |= ECT_NETNS_USER_NAMESPACE;
    if (unshare(NAMESPACES) == 0)
        return 0;
    explain("making a network namespace", errno, message);
    return -1;
}

/* /sys shows the network of the process that mounted it. */
static bool own_sysfs(void)
{
    const unsigned long flags = MS_NOSUID | MS_NODEV | MS_NOEXEC;
    return mount("none", "/", NULL, MS_REC | MS_SLAVE, NULL) == 0 &&
           (mount("ectwin", "/sys", "sysfs", flags, NULL) == 0 ||
            mount("ectwin", "/sys", "sysfs", flags | MS_RDONLY, NULL) == 0);
}

/* Keeps the kernel's IPv6 packets off the wires. The files are missing on a kernel without IPv6. */
static void disable_ipv6(void)
{
    (void)write_file("/proc/sys/net/ipv6/conf/default/disable_ipv6", "1");
}

static int build_network(const char *const masters[ECT_NETNS_WIRES], char *message)
{
    struct nl_sock *socket = nl_socket_alloc();
    int error = socket ? nl_connect(socket, NETLINK_ROUTE) : -NLE_NOMEM;
    disable_ipv6();
    if (error >= 0)
        error = ect_veth_up(socket, "lo");
    for (size_t i = 0; i < ECT_NETNS_WIRES && masters[i] && error >= 0; i++)
        error = ect_veth_add(socket, ect_netns_twin[i], masters[i]);
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

int ect_netns_enter(const char *const masters[ECT_NETNS_WIRES], unsigned int *lacks, char *message)
{
    *lacks = 0;
    if (enter_namespaces(lacks, message) < 0)
        return -1;
    if (!own_sysfs())
        *lacks |= ECT_NETNS_OWN_SYSFS;
    return build_network(masters, message);
}
