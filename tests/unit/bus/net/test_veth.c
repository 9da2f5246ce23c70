/* SPDX-License-Identifier: MIT */
/* Pairs of virtual interfaces (bus/net/veth.h) of a kernel that is the test's: each step may fail. The real kernel is
 * in test_network.c. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <limits.h>
#include <net/if.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>

#include <netlink/errno.h>
#include <netlink/netlink.h>
#include <netlink/route/link.h>
#include <netlink/route/link/veth.h>

#include "bus/net/veth.h"
#include "calls.h"

/* --- calls -------------------------------------------------------------------------------------------------------- */

/* States of RFC 2863. */
enum { DOWN = 2, UP = 6 };

static bool states;        /* both ends are up: each further read is one of the state */
static unsigned int reads; /* of the state */
static unsigned int late;  /* reads of the state that precede that of a working end */
static uint64_t waited_ns;

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
ssize_t __real_write(int fd, const void *data, size_t size);
ssize_t __wrap_write(int fd, const void *data, size_t size);
int __real_close(int fd);
int __wrap_close(int fd);
int __wrap_nl_connect(struct nl_sock *socket, int protocol);
int __wrap_rtnl_link_add(struct nl_sock *socket, struct rtnl_link *link, int flags);
int __wrap_rtnl_link_change(struct nl_sock *socket, struct rtnl_link *link, struct rtnl_link *change, int flags);
int __wrap_rtnl_link_get_kernel(struct nl_sock *socket, int index, const char *name, struct rtnl_link **link);
int __wrap_rtnl_link_delete(struct nl_sock *socket, const struct rtnl_link *link);
int __wrap_nanosleep(const struct timespec *duration, struct timespec *left);

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (strncmp(path, "/proc/", 6) != 0)
        return __real_open(path, flags, mode);
    assert_int_equal(flags, O_WRONLY | O_CLOEXEC);
    note("%s", path);
    if (fails("open")) {
        note(" refused\n");
        return -1;
    }
    return fake_open("file");
}

ssize_t __wrap_write(int fd, const void *data, size_t size)
{
    if (!is_fake(fd))
        return __real_write(fd, data, size);
    note(" = %.*s\n", (int)size, (const char *)data);
    return (ssize_t)size;
}

int __wrap_close(int fd)
{
    if (!is_fake(fd))
        return __real_close(fd);
    fake_close(fd);
    return 0;
}

int __wrap_nl_connect(struct nl_sock *socket, int protocol)
{
    assert_non_null(socket);
    assert_int_equal(protocol, NETLINK_ROUTE);
    note("netlink\n");
    return fails("netlink") ? -errno : 0;
}

int __wrap_rtnl_link_add(struct nl_sock *socket, struct rtnl_link *link, int flags)
{
    struct rtnl_link *peer = rtnl_link_veth_get_peer(link);
    assert_non_null(socket);
    assert_int_equal(flags, NLM_F_CREATE | NLM_F_EXCL);
    note("add %s %s\n", rtnl_link_get_name(link), rtnl_link_get_name(peer));
    rtnl_link_put(peer);
    return fails("add") ? -errno : 0;
}

int __wrap_rtnl_link_change(struct nl_sock *socket, struct rtnl_link *link, struct rtnl_link *change, int flags)
{
    assert_non_null(socket);
    assert_int_equal(flags, 0);
    note("%s %s\n", rtnl_link_get_flags(change) == IFF_UP ? "up" : "other", rtnl_link_get_name(link));
    states = strcmp(rtnl_link_get_name(link), "other") == 0;
    return fails("change") ? -errno : 0;
}

int __wrap_rtnl_link_get_kernel(struct nl_sock *socket, int index, const char *name, struct rtnl_link **link)
{
    assert_non_null(socket);
    assert_int_equal(index, 0);
    if (fails("get")) {
        note("no %s\n", name);
        return -errno;
    }
    *link = rtnl_link_alloc();
    rtnl_link_set_name(*link, name);
    rtnl_link_set_operstate(*link, reads < late ? DOWN : UP);
    reads += states;
    return 0;
}

int __wrap_nanosleep(const struct timespec *duration, struct timespec *left)
{
    (void)left;
    waited_ns += (uint64_t)duration->tv_sec * 1000000000u + (uint64_t)duration->tv_nsec;
    return 0;
}

int __wrap_rtnl_link_delete(struct nl_sock *socket, const struct rtnl_link *link)
{
    assert_non_null(socket);
    note("delete %s\n", rtnl_link_get_name((struct rtnl_link *)(uintptr_t)link));
    return fails("delete") ? -errno : 0;
}

/* --- tests -------------------------------------------------------------------------------------------------------- */

#define ADD     "netlink\nadd one other\n"
#define NO_IPV6 "/proc/sys/net/ipv6/conf/one/disable_ipv6 = 1\n/proc/sys/net/ipv6/conf/other/disable_ipv6 = 1\n"
#define REMOVED "netlink\ndelete one\n"

static void creation(void **state)
{
    static const struct {
        const char *title;
        failing_t failing;
        const char *message; /* NULL: made */
        const char *want;
    } rows[] = {
        {"all is well", {0}, NULL, ADD NO_IPV6 "up one\nup other\n"},
        {"no IPv6",
         {"open", FIRST | SECOND, ENOENT},
         NULL,
         ADD "/proc/sys/net/ipv6/conf/one/disable_ipv6 refused\n/proc/sys/net/ipv6/conf/other/disable_ipv6 refused\n"
             "up one\nup other\n"},
        {"no netlink", {"netlink", FIRST, NLE_NOMEM}, "making a pair of interfaces failed: Out of memory", "netlink\n"},
        {"no right",
         {"add", FIRST, NLE_PERM},
         "a pair of interfaces needs CAP_NET_ADMIN: run 'sudo ectwin veth one'",
         ADD},
        {"a name that is taken",
         {"add", FIRST, NLE_EXIST},
         "'one' or 'other' exists already: choose another name, or 'sudo ip link del one'",
         ADD},
        {"no veth",
         {"add", FIRST, NLE_OPNOTSUPP},
         "this kernel has no veth driver: 'sudo modprobe veth' loads it",
         ADD},
        {"one end is gone",
         {"get", FIRST, NLE_NODEV},
         "making a pair of interfaces failed: No such device",
         ADD NO_IPV6 "no one\n" REMOVED},
        {"one end stays down",
         {"change", FIRST, NLE_NODEV},
         "making a pair of interfaces failed: No such device",
         ADD NO_IPV6 "up one\n" REMOVED},
        {"the other end stays down",
         {"change", SECOND, NLE_PERM},
         "a pair of interfaces needs CAP_NET_ADMIN: run 'sudo ectwin veth one'",
         ADD NO_IPV6 "up one\nup other\n" REMOVED},
    };
    (void)state;
    for (size_t n = 0; n < 3 * (sizeof rows / sizeof rows[0]); n++) {
        const size_t i = n / 3;
        char message[ECT_VETH_MESSAGE] = "";
        begin_calls(rows[i].failing);
        calls.zero_at = n % 3;
        int result = ect_veth_create("one", "other", message);
        EXPECT_LOG(rows[i].title, rows[i].want);
        if (result != (rows[i].message ? -1 : 0) || strcmp(message, rows[i].message ? rows[i].message : "") != 0)
            fail_msg("%s: expected '%s', got %d '%s'", rows[i].title, rows[i].message, result, message);
        assert_int_equal(calls.open, 0);
    }
}

static void removal(void **state)
{
    static const struct {
        failing_t failing;
        int result;
        const char *want;
    } rows[] = {
        {{0}, 0, "netlink\ndelete one\n"},
        {{"netlink", FIRST, NLE_NOMEM}, -1, "netlink\n"},
        {{"get", FIRST, NLE_OBJ_NOTFOUND}, -1, "netlink\nno one\n"},
        {{"delete", FIRST, NLE_PERM}, -1, "netlink\ndelete one\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin_calls(rows[i].failing);
        assert_int_equal(ect_veth_destroy("one"), rows[i].result);
        EXPECT_LOG("removal", rows[i].want);
    }
}

/* For a private network: IPv6 is off there already, and the errors are those of the library. */
static void addition(void **state)
{
    static const struct {
        failing_t failing;
        int result;
        const char *want;
    } rows[] = {
        {{0}, 0, "add one other\nup one\nup other\n"},
        {{"add", FIRST, NLE_OPNOTSUPP}, -NLE_OPNOTSUPP, "add one other\n"},
        {{"change", FIRST, NLE_PERM}, -NLE_PERM, "add one other\nup one\n"},
        {{"get", SECOND, NLE_NODEV}, -NLE_NODEV, "add one other\nup one\nno other\n"},
    };
    struct nl_sock *socket = nl_socket_alloc();
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin_calls(rows[i].failing);
        assert_int_equal(ect_veth_add(socket, "one", "other"), rows[i].result);
        EXPECT_LOG("addition", rows[i].want);
    }
    nl_socket_free(socket);
}

/* An end that has no carrier yet drops what it sends. */
static void carrier(void **state)
{
    static const struct {
        const char *title;
        unsigned int late;
        failing_t failing;
        uint64_t waited_ms;
    } rows[] = {
        {"both ends work at once", 0, {0}, 0},
        {"an end works after three reads", 3, {0}, 3},
        {"an end works at the last read", 5000, {0}, 5000},
        {"no end ever works", UINT_MAX, {0}, 2 * 5000},
        {"a read fails", 0, {"get", THIRD, NLE_NOMEM}, 1},
    };
    struct nl_sock *socket = nl_socket_alloc();
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin_calls(rows[i].failing);
        states = false;
        reads = 0;
        waited_ns = 0;
        late = rows[i].late;
        int result = ect_veth_add(socket, "one", "other");
        if (result != 0 || waited_ns != rows[i].waited_ms * 1000000)
            fail_msg("%s: expected result 0 after %llu ms, got %d after %llu us", rows[i].title,
                     (unsigned long long)rows[i].waited_ms, result, (unsigned long long)waited_ns / 1000);
    }
    late = 0;
    nl_socket_free(socket);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a pair is made up and without IPv6, or not at all, with one line: the cause, then the cure", creation, NULL,
         NULL, NULL},
        {"a pair is removed, or the result is -1", removal, NULL, NULL, NULL},
        {"a pair of a private network is made up, or the result is the library's", addition, NULL, NULL, NULL},
        {"a pair is made when both ends can send, or after 5 s for each", carrier, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("pairs of interfaces", tests, NULL, NULL);
}
