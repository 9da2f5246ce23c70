/* SPDX-License-Identifier: MIT */
/* The steps to a private network (bus/net/netns.h), with a kernel that is the test's: each step may fail. The real
 * kernel is in test_network.c. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sched.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <netlink/errno.h>
#include <netlink/netlink.h>

#include "bus/net/netns.h"
#include "bus/net/veth.h"
#include "calls.h"

enum { SELF = 4711, HELPER = 4712, UID = 1000, GID = 100 };

static struct kernel {
    bool root;
    bool child;        /* fork() returns as in the child */
    int helper_status; /* of waitpid() */
    const char *flag;  /* a file of /proc/sys that exists */
    char value;        /* its content; 0: it is empty */
    const char *map;   /* of the ids, /proc/self/uid_map and gid_map */
    jmp_buf exit;
} kernel = {.value = 'x'};

/* --- calls -------------------------------------------------------------------------------------------------------- */

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
ssize_t __real_write(int fd, const void *data, size_t size);
ssize_t __wrap_write(int fd, const void *data, size_t size);
ssize_t __real_read(int fd, void *data, size_t size);
ssize_t __wrap_read(int fd, void *data, size_t size);
int __real_close(int fd);
int __wrap_close(int fd);
FILE *__real_fopen(const char *path, const char *mode);
FILE *__wrap_fopen(const char *path, const char *mode);
int __wrap_prctl(int option, ...);
uid_t __wrap_geteuid(void);
gid_t __wrap_getegid(void);
pid_t __wrap_getpid(void);
int __wrap_unshare(int flags);
int __wrap_pipe2(int fds[2], int flags);
pid_t __wrap_fork(void);
pid_t __wrap_waitpid(pid_t pid, int *status, int options);
void __wrap__exit(int status);
int __wrap_mount(const char *source, const char *target, const char *type, unsigned long flags, const void *data);
int __wrap_nl_connect(struct nl_sock *socket, int protocol);
int __wrap_ect_veth_up(struct nl_sock *socket, const char *name);
int __wrap_ect_veth_add(struct nl_sock *socket, const char *one, const char *other);

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (strncmp(path, "/proc/", 6) != 0)
        return __real_open(path, flags, mode);
    if ((flags & O_ACCMODE) == O_RDONLY) {
        errno = ENOENT;
        return kernel.flag && strcmp(path, kernel.flag) == 0 ? fake_open("flag") : -1;
    }
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
    bool go = strcmp(calls.opened[place_of(fd)], "go") == 0;
    note(go ? "go" : " = %.*s\n", (int)size, (const char *)data);
    if (go)
        note(" %zu\n", size);
    return fails(go ? "go" : "write") ? -1 : (ssize_t)size;
}

ssize_t __wrap_read(int fd, void *data, size_t size)
{
    if (!is_fake(fd))
        return __real_read(fd, data, size);
    assert_int_equal(size, 1);
    if (fails("read") || kernel.value == 0)
        return 0;
    *(char *)data = kernel.value;
    return 1;
}

int __wrap_close(int fd)
{
    if (!is_fake(fd))
        return __real_close(fd);
    fake_close(fd);
    errno = EBADF; /* a cause that was noted before must survive this */
    return 0;
}

FILE *__wrap_fopen(const char *path, const char *mode)
{
    if (strcmp(path, "/proc/self/uid_map") != 0 && strcmp(path, "/proc/self/gid_map") != 0)
        return __real_fopen(path, mode);
    return fails(path) ? NULL : fmemopen((void *)(uintptr_t)kernel.map, strlen(kernel.map), "r");
}

int __wrap_prctl(int option, ...)
{
    va_list arguments;
    va_start(arguments, option);
    assert_int_equal(option, PR_SET_DUMPABLE);
    note("dumpable %d\n", va_arg(arguments, int));
    va_end(arguments);
    return 0;
}

uid_t __wrap_geteuid(void)
{
    return kernel.root ? 0 : UID;
}

gid_t __wrap_getegid(void)
{
    return GID;
}

pid_t __wrap_getpid(void)
{
    return SELF;
}

int __wrap_unshare(int flags)
{
    note("unshare%s%s%s\n", (flags & CLONE_NEWUSER) != 0 ? " user" : "", (flags & CLONE_NEWNET) != 0 ? " net" : "",
         (flags & CLONE_NEWNS) != 0 ? " mounts" : "");
    return fails("unshare") ? -1 : 0;
}

int __wrap_pipe2(int fds[2], int flags)
{
    note("pipe\n");
    assert_int_equal(flags, O_CLOEXEC);
    if (fails("pipe"))
        return -1;
    fds[0] = fake_open("come");
    fds[1] = fake_open("go");
    return 0;
}

pid_t __wrap_fork(void)
{
    note("fork\n");
    return fails("fork") ? -1 : kernel.child ? 0 : HELPER;
}

pid_t __wrap_waitpid(pid_t pid, int *status, int options)
{
    note("wait %d %d\n", (int)pid, options);
    *status = kernel.helper_status;
    return pid;
}

void __wrap__exit(int status)
{
    note("exit %d\n", status);
    longjmp(kernel.exit, 1);
}

int __wrap_mount(const char *source, const char *target, const char *type, unsigned long flags, const void *data)
{
    const unsigned long plain = MS_NOSUID | MS_NODEV | MS_NOEXEC;
    (void)source;
    (void)data;
    note("mount %s%s%s\n", target, type ? " " : "", type ? type : "");
    assert_true(flags == (type ? plain | (flags & MS_RDONLY) : MS_REC | MS_SLAVE));
    if ((flags & MS_RDONLY) != 0)
        note("read-only\n");
    return fails("mount") ? -1 : 0;
}

int __wrap_nl_connect(struct nl_sock *socket, int protocol)
{
    assert_non_null(socket);
    assert_int_equal(protocol, NETLINK_ROUTE);
    note("netlink\n");
    return fails("netlink") ? -errno : 0;
}

int __wrap_ect_veth_up(struct nl_sock *socket, const char *name)
{
    assert_non_null(socket);
    note("up %s\n", name);
    return fails("up") ? -errno : 0;
}

int __wrap_ect_veth_add(struct nl_sock *socket, const char *one, const char *other)
{
    assert_non_null(socket);
    note("pair %s %s\n", one, other);
    return fails("pair") ? -errno : 0;
}

/* --- tests -------------------------------------------------------------------------------------------------------- */

#define NAMESPACES "unshare user net mounts\n"
#define MAPS       "/proc/self/uid_map = 0 1000 1\n/proc/self/setgroups = deny\n/proc/self/gid_map = 0 100 1\n"
#define AS_USER    NAMESPACES "dumpable 1\n" MAPS
#define AS_ROOT    "pipe\nfork\n" NAMESPACES "go 1\nwait 4712 0\n"
#define ALL_RIGHTS "unshare net mounts\n"
#define SYSFS      "mount /\nmount /sys sysfs\n"
#define NETLINK    "netlink\n/proc/sys/net/ipv6/conf/default/disable_ipv6 = 1\n"
#define WIRES      NETLINK "up lo\npair ectwin0 ecat0\npair ectwin1 ecat1\n"
#define WHY        "no private network: "
#define AS_ROOT_ADVICE                                                                                                 \
    "run it as root ('sudo ectwin with ...'); in a container, start the container with --privileged or "               \
    "--cap-add=SYS_ADMIN,NET_ADMIN,NET_RAW"
#define END "; or run the twins inside CMD: --in-process"

static int enter(unsigned int *lacks, const char *second, char *message)
{
    const char *const masters[ECT_NETNS_WIRES] = {"ecat0", second};
    *message = 0;
    *lacks = 99;
    return ect_netns_enter(masters, lacks, message);
}

/* Each way in, and the missing parts of a network that is still usable. */
static void steps(void **state)
{
    static const struct {
        const char *title;
        bool root, one_wire;
        failing_t failing;
        unsigned int lacks;
        const char *want;
    } rows[] = {
        {"a user", false, false, {0}, 0, AS_USER SYSFS WIRES},
        {"one wire", false, true, {0}, 0, AS_USER SYSFS NETLINK "up lo\npair ectwin0 ecat0\n"},
        {"root", true, false, {0}, 0, AS_ROOT SYSFS WIRES},
        {"root without user namespaces",
         true,
         false,
         {"unshare", FIRST, EPERM},
         ECT_NETNS_USER_NAMESPACE,
         "pipe\nfork\n" NAMESPACES "wait 4712 0\n" ALL_RIGHTS SYSFS WIRES},
        {"root without a pipe",
         true,
         false,
         {"pipe", FIRST, EMFILE},
         ECT_NETNS_USER_NAMESPACE,
         "pipe\n" ALL_RIGHTS SYSFS WIRES},
        {"root without a helper",
         true,
         false,
         {"fork", FIRST, EAGAIN},
         ECT_NETNS_USER_NAMESPACE,
         "pipe\nfork\n" ALL_RIGHTS SYSFS WIRES},
        {"mounts that are shared",
         false,
         false,
         {"mount", FIRST, EPERM},
         ECT_NETNS_OWN_SYSFS,
         AS_USER "mount /\n" WIRES},
        {"/sys for reading only",
         false,
         false,
         {"mount", SECOND, EPERM},
         0,
         AS_USER SYSFS "mount /sys sysfs\nread-only\n" WIRES},
        {"no /sys of its own",
         true,
         false,
         {"mount", SECOND | THIRD, EPERM},
         ECT_NETNS_OWN_SYSFS,
         AS_ROOT SYSFS "mount /sys sysfs\nread-only\n" WIRES},
        {"no IPv6",
         false,
         false,
         {"open", FOURTH, ENOENT},
         0,
         AS_USER SYSFS "netlink\n/proc/sys/net/ipv6/conf/default/disable_ipv6 refused\nup lo\npair ectwin0 ecat0\n"
                       "pair ectwin1 ecat1\n"},
    };
    (void)state;
    for (size_t n = 0; n < 4 * (sizeof rows / sizeof rows[0]); n++) {
        const size_t i = n / 4;
        char message[ECT_NETNS_MESSAGE];
        unsigned int lacks;
        begin_calls(rows[i].failing);
        calls.zero_at = n % 4;
        kernel.root = rows[i].root;
        if (enter(&lacks, rows[i].one_wire ? NULL : "ecat1", message) != 0)
            fail_msg("%s: refused: %s", rows[i].title, message);
        EXPECT_LOG(rows[i].title, rows[i].want);
        assert_int_equal(lacks, rows[i].lacks);
        assert_int_equal(calls.open, 0);
    }
}

/* One line: the step, its cause, the cure. */
static void refusals(void **state)
{
    static const struct {
        const char *title;
        bool root;
        int helper_status;
        failing_t failing;
        const char *message, *want;
    } rows[] = {
        {"no user namespace",
         false,
         0,
         {"unshare", FIRST, ENOSPC},
         WHY "making a user namespace failed (No space left on device); " AS_ROOT_ADVICE END,
         NAMESPACES},
        {"no map of users",
         false,
         0,
         {"open", FIRST, EACCES},
         WHY "mapping the user failed (Permission denied); " AS_ROOT_ADVICE END,
         NAMESPACES "dumpable 1\n/proc/self/uid_map refused\n"},
        {"a map of users that is not taken",
         false,
         0,
         {"write", FIRST, EPERM},
         WHY "mapping the user failed (Operation not permitted); " AS_ROOT_ADVICE END,
         NAMESPACES "dumpable 1\n/proc/self/uid_map = 0 1000 1\n"},
        {"supplementary groups",
         false,
         0,
         {"write", SECOND, EPERM},
         WHY "mapping the user failed (Operation not permitted); " AS_ROOT_ADVICE END,
         NAMESPACES "dumpable 1\n/proc/self/uid_map = 0 1000 1\n/proc/self/setgroups = deny\n"},
        {"no map of groups",
         false,
         0,
         {"open", THIRD, EACCES},
         WHY "mapping the user failed (Permission denied); " AS_ROOT_ADVICE END,
         NAMESPACES
         "dumpable 1\n/proc/self/uid_map = 0 1000 1\n/proc/self/setgroups = deny\n/proc/self/gid_map refused\n"},
        {"root whose users cannot be mapped",
         true,
         256,
         {0},
         WHY "mapping the users failed (Operation not permitted); " AS_ROOT_ADVICE END,
         AS_ROOT},
        {"root whose helper is gone",
         true,
         0,
         {"go", FIRST, EPIPE},
         WHY "mapping the users failed (Operation not permitted); " AS_ROOT_ADVICE END,
         AS_ROOT},
        {"root without the right",
         true,
         0,
         {"unshare", FIRST | SECOND, EPERM},
         WHY "making a network namespace failed (Operation not permitted); " AS_ROOT_ADVICE END,
         "pipe\nfork\n" NAMESPACES "wait 4712 0\n" ALL_RIGHTS},
        {"no netlink",
         false,
         0,
         {"netlink", FIRST, NLE_NOMEM},
         WHY "making a veth pair failed (Out of memory)",
         AS_USER SYSFS NETLINK},
        {"no loopback",
         false,
         0,
         {"up", FIRST, NLE_NODEV},
         WHY "making a veth pair failed (No such device)",
         AS_USER SYSFS NETLINK "up lo\n"},
        {"a namespace without rights",
         false,
         0,
         {"pair", FIRST, NLE_PERM},
         WHY "making a veth pair in it failed (Operation not permitted); " AS_ROOT_ADVICE END,
         AS_USER SYSFS NETLINK "up lo\npair ectwin0 ecat0\n"},
        {"a kernel without veth",
         false,
         0,
         {"pair", SECOND, NLE_OPNOTSUPP},
         WHY "this kernel has no veth driver ('sudo modprobe veth' loads it)",
         AS_USER SYSFS WIRES},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_NETNS_MESSAGE];
        unsigned int lacks;
        begin_calls(rows[i].failing);
        kernel.root = rows[i].root;
        kernel.helper_status = rows[i].helper_status;
        assert_int_equal(enter(&lacks, "ecat1", message), -1);
        kernel.helper_status = 0;
        EXPECT_LOG(rows[i].title, rows[i].want);
        if (strcmp(message, rows[i].message) != 0)
            fail_msg("%s: expected '%s', got '%s'", rows[i].title, rows[i].message, message);
        assert_int_equal(calls.open, 0);
    }
}

/* The setting of the system that forbids user namespaces is named, if it is one. */
static void settings_that_forbid(void **state)
{
    static const char apparmor[] = "/proc/sys/kernel/apparmor_restrict_unprivileged_userns";
    static const char clone[] = "/proc/sys/kernel/unprivileged_userns_clone";
    static const char most[] = "/proc/sys/user/max_user_namespaces";
    static const struct {
        const char *flag;
        char value;
        failing_t failing;
        const char *advice;
    } rows[] = {
        {apparmor, '1', {"unshare", FIRST, EPERM}, "sysctl -w kernel.apparmor_restrict_unprivileged_userns=0'"},
        {apparmor, '0', {"unshare", FIRST, EPERM}, AS_ROOT_ADVICE},
        {clone, '0', {"unshare", FIRST, EPERM}, "'sudo sysctl -w kernel.unprivileged_userns_clone=1'"},
        {clone, '1', {"unshare", FIRST, EPERM}, AS_ROOT_ADVICE},
        {most, '0', {"unshare", FIRST, EPERM}, "'sudo sysctl -w user.max_user_namespaces=1000'"},
        {most, '6', {"unshare", FIRST, EPERM}, AS_ROOT_ADVICE},
        {most, 0, {"unshare", FIRST, EPERM}, AS_ROOT_ADVICE},
        {most, '0', {"pair", FIRST, NLE_PERM}, "'sudo sysctl -w user.max_user_namespaces=1000'"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_NETNS_MESSAGE];
        unsigned int lacks;
        begin_calls(rows[i].failing);
        kernel.root = false;
        kernel.flag = rows[i].flag;
        kernel.value = rows[i].value;
        assert_int_equal(enter(&lacks, NULL, message), -1);
        kernel.flag = NULL;
        kernel.value = 'x';
        if (!strstr(message, rows[i].advice) || !strstr(message, "(Operation not permitted); "))
            fail_msg("%s = %d: expected '%s' in '%s'", rows[i].flag, rows[i].value, rows[i].advice, message);
        assert_int_equal(calls.open, 0);
    }
}

/* The process outside, up to its end. */
static void as_helper(const char *map, failing_t failing)
{
    char message[ECT_NETNS_MESSAGE];
    unsigned int lacks;
    begin_calls(failing);
    kernel.root = kernel.child = true;
    kernel.map = map;
    if (setjmp(kernel.exit) == 0)
        (void)enter(&lacks, NULL, message);
    kernel.child = false;
}

/* The outer process maps every id of this namespace, with the same number, for the inner one. */
static void maps_from_outside(void **state)
{
#define LINE     "1000000000 7 1\n"
#define LINES_6  LINE LINE LINE LINE LINE LINE
#define LINES_42 LINES_6 LINES_6 LINES_6 LINES_6 LINES_6 LINES_6 LINES_6
    static const struct {
        const char *title, *map;
        failing_t failing;
        const char *want; /* in each of the two maps; NULL: refused */
        const char *log;  /* if it is not both maps */
    } rows[] = {
        {"all ids", "         0          0 4294967295\n", {0}, "0 0 4294967295\n", NULL},
        {"a container's", "0 1000 1\n1 100000 65536\n", {0}, "0 0 1\n1 1 65536\n", NULL},
        {"none", "\n", {0}, NULL, ""},
        {"no list of users", "0 0 1\n", {"/proc/self/uid_map", FIRST, EMFILE}, NULL, ""},
        {"no list of groups", "0 0 1\n", {"/proc/self/gid_map", FIRST, EMFILE}, NULL, ""},
        {"the other process has not entered", "0 0 1\n", {"read", FIRST, 0}, NULL, ""},
        {"users that are not taken", "0 0 1\n", {"write", FIRST, EPERM}, NULL, "/proc/4711/uid_map = 0 0 1\n\n"},
        {"groups that are not taken",
         "0 0 1\n",
         {"write", SECOND, EPERM},
         NULL,
         "/proc/4711/uid_map = 0 0 1\n\n/proc/4711/gid_map = 0 0 1\n\n"},
        {"one byte too many", LINES_42 "10000 0 123\n", {0}, NULL, ""}, /* 42 x 24 and 16 bytes */
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char want[1024];
        as_helper(rows[i].map, rows[i].failing);
        if (rows[i].want)
            snprintf(want, sizeof want, "pipe\nfork\n/proc/4711/uid_map = %s\n/proc/4711/gid_map = %s\nexit 0\n",
                     rows[i].want, rows[i].want);
        else
            snprintf(want, sizeof want, "pipe\nfork\n%sexit 1\n", rows[i].log);
        EXPECT_LOG(rows[i].title, want);
        assert_int_equal(calls.open, 1); /* the end of the pipe that was read */
    }
    as_helper(LINES_42 "10000 0 12\n", (failing_t){0}); /* the longest map that has room */
    assert_non_null(strstr(calls.log, "10000 10000 12\n\nexit 0\n"));
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a private network of root or a user, with its lacks: each step in its order", steps, NULL, NULL, NULL},
        {"a step that fails ends it with one line: the cause, then the cure", refusals, NULL, NULL, NULL},
        {"a setting that forbids user namespaces is named with its cure", settings_that_forbid, NULL, NULL, NULL},
        {"root keeps all ids of its namespace, which a process outside maps", maps_from_outside, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("steps to a private network", tests, NULL, NULL);
}
