/* SPDX-License-Identifier: MIT */
/* Ends of the networks behind twins (bus/eoe/place.h): a TAP of a kernel that is the test, and sockets with a path. */
#define _GNU_SOURCE
#include "bus/eoe/place.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

/* The kernel's side of a TAP. */
static struct {
    int open_error, take_error, flags_error; /* 0: the call succeeds */
    char asked[IFNAMSIZ];                    /* the name that TUNSETIFF has */
    short taken, flags, set;                 /* its flags; those of the interface; those that were set, 0: none */
} kernel;

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __real_ioctl(int fd, unsigned long request, ...);
int __wrap_ioctl(int fd, unsigned long request, ...);

static int result(int error)
{
    errno = error;
    return error == 0 ? 0 : -1;
}

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (strcmp(path, "/dev/net/tun") != 0)
        return __real_open(path, flags, mode);
    assert_int_equal(flags, O_RDWR | O_CLOEXEC | O_NONBLOCK);
    return kernel.open_error != 0 ? result(kernel.open_error) : __real_open("/dev/null", O_RDWR);
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    struct ifreq *asked = va_arg(arguments, struct ifreq *);
    va_end(arguments);
    assert_true(fcntl(fd, F_GETFD) >= 0);
    switch (request) {
    case TUNSETIFF:
        memcpy(kernel.asked, asked->ifr_name, IFNAMSIZ);
        kernel.taken = asked->ifr_flags;
        if (kernel.take_error == 0 && strcmp(asked->ifr_name, "tap%d") == 0)
            strcpy(asked->ifr_name, "tap3");
        return result(kernel.take_error);
    case SIOCGIFFLAGS:
        asked->ifr_flags = kernel.flags;
        return result(kernel.flags_error);
    case SIOCSIFFLAGS:
        kernel.set = asked->ifr_flags;
        return 0;
    default:
        return __real_ioctl(fd, request, asked);
    }
}

/* The descriptor that is given next. */
static int next_descriptor(void)
{
    const int fd = __real_open("/dev/null", O_RDONLY);
    (void)close(fd);
    return fd;
}

static void a_tap_has_a_name_and_is_brought_up(void **state)
{
    static const struct {
        const char *text, *asked, *name;
        int flags_error;
        short set;
    } rows[] = {
        {"tap", "tap%d", "tap3", 0, IFF_UP | IFF_MULTICAST},
        {"tap7", "tap7", "tap7", 0, IFF_UP | IFF_MULTICAST},
        {"tapfourteenchar", "tapfourteenchar", "tapfourteenchar", 0, IFF_UP | IFF_MULTICAST},
        {"tap7", "tap7", "tap7", EPERM, 0},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char name[ECT_PLACE_NAME] = "", message[ECT_PLACE_MESSAGE] = "";
        const int before = next_descriptor();
        memset(&kernel, 0, sizeof kernel);
        kernel.flags = IFF_MULTICAST;
        kernel.flags_error = rows[i].flags_error;
        const int fd = ect_place_tap(rows[i].text, name, message);
        assert_int_equal(fd, before);
        assert_string_equal(name, rows[i].name);
        assert_string_equal(kernel.asked, rows[i].asked);
        assert_int_equal(kernel.taken, IFF_TAP | IFF_NO_PI);
        assert_int_equal(kernel.set, rows[i].set);
        (void)close(fd);
        assert_int_equal(next_descriptor(), before);
    }
}

/* A daemon's standard input may be closed: each end gets descriptor 0 then, and the socket that searches a listener at
 * the path gets it before. */
static void descriptor_0_is_one_as_any_other(void **state)
{
    char folder[] = "/tmp/ectwin-place-XXXXXX", path[100];
    char name[ECT_PLACE_NAME] = "", message[ECT_PLACE_MESSAGE] = "";
    const int input = dup(STDIN_FILENO);
    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/port", folder);
    memset(&kernel, 0, sizeof kernel);
    (void)close(STDIN_FILENO);
    const int tap = ect_place_tap("tap", name, message);
    (void)close(tap);
    const int first = ect_place_listen(path, message);
    const int refused = ect_place_listen(path, message);
    (void)close(first);
    const int second = ect_place_listen(path, message);
    (void)close(second);
    const int next = next_descriptor();
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        (void)close(input);
    }
    assert_int_equal(tap, STDIN_FILENO);
    assert_string_equal(name, "tap3");
    assert_int_equal(first, STDIN_FILENO);
    assert_int_equal(refused, -1);
    assert_int_equal(second, STDIN_FILENO);
    assert_int_equal(next, STDIN_FILENO);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

static void a_refused_tap_has_cause_and_cure(void **state)
{
    static const struct {
        const char *text;
        int error;
        const char *message;
    } rows[] = {
        {"tap", ENOENT, "there is no /dev/net/tun: 'sudo modprobe tun' loads its driver"},
        {"tap", ENODEV, "there is no /dev/net/tun: 'sudo modprobe tun' loads its driver"},
        {"tap", EACCES, "/dev/net/tun is not open to this user: 'sudo chmod a+rw /dev/net/tun' opens it"},
        {"tap", EPERM,
         "'tap' needs CAP_NET_ADMIN: 'sudo ip tuntap add dev tap0 mode tap user %u' makes it for you, or "
         "'ectwin with' in a network of its own"},
        {"tapx", EPERM,
         "'tapx' needs CAP_NET_ADMIN: 'sudo ip tuntap add dev tapx mode tap user %u' makes it for you, "
         "or 'ectwin with' in a network of its own"},
        {"tapx", EBUSY, "another program has 'tapx' open: end it, or choose another name"},
        {"tapx", EINVAL, "'tapx' exists already and is no TAP: choose another name"},
        {"tapx", ENOMEM, "opening the TAP 'tapx' failed: Cannot allocate memory"},
    };
    (void)state;
    for (size_t i = 0; i < 2 * COUNT(rows); i++) {
        char name[ECT_PLACE_NAME] = "", message[ECT_PLACE_MESSAGE] = "", user[20], wanted[ECT_PLACE_MESSAGE];
        const int before = next_descriptor();
        memset(&kernel, 0, sizeof kernel);
        *(i % 2 == 0 ? &kernel.open_error : &kernel.take_error) = rows[i / 2].error;
        assert_int_equal(ect_place_tap(rows[i / 2].text, name, message), -1);
        (void)snprintf(user, sizeof user, "%u", (unsigned int)geteuid());
        const char *at = strstr(rows[i / 2].message, "%u");
        (void)snprintf(wanted, sizeof wanted, "%.*s%s%s", at ? (int)(at - rows[i / 2].message) : 0, rows[i / 2].message,
                       at ? user : "", at ? at + 2 : rows[i / 2].message);
        assert_string_equal(message, wanted);
        assert_int_equal(next_descriptor(), before);
    }
}

static void a_text_names_a_tap_or_a_path(void **state)
{
    static const struct {
        const char *text;
        bool tap;
        const char *path;
    } rows[] = {
        {"tap", true, NULL},
        {"tap0", true, NULL},
        {"tap123456789012", true, NULL},
        {"tap1234567890123", false, NULL},
        {"ta", false, NULL},
        {"tap/x", false, NULL},
        {"tap x", false, NULL},
        {"tap%d", false, NULL},
        {"tap:1", false, NULL},
        {"unix:/a/b", false, "/a/b"},
        {"unix:", false, ""},
        {"unix", false, NULL},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const char *path = ect_place_path(rows[i].text);
        assert_int_equal(ect_place_is_tap(rows[i].text), rows[i].tap);
        assert_int_equal(path != NULL, rows[i].path != NULL);
        if (path != NULL)
            assert_string_equal(path, rows[i].path);
    }
}

static void a_path_has_1_to_107_characters(void **state)
{
    enum { MOST = sizeof(((struct sockaddr_un *)NULL)->sun_path) - 1 };
    char folder[] = "/tmp/ectwin-place-XXXXXX", path[MOST + 2] = "", message[ECT_PLACE_MESSAGE] = "";
    (void)state;
    assert_non_null(mkdtemp(folder));
    assert_int_equal(ect_place_listen("", message), -1);
    assert_string_equal(message, "unix:PATH has 1 to 107 characters after the colon");
    (void)snprintf(path, sizeof path, "%s/%0*d", folder, (int)(MOST - sizeof folder), 0);
    assert_int_equal(strlen(path), MOST);
    const mode_t mask = umask(0027);
    const int fd = ect_place_listen(path, message);
    assert_int_equal(umask(mask), 0027);
    assert_true(fd >= 0);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0600);
    (void)close(fd);
    assert_int_equal(unlink(path), 0);
    path[MOST] = '0';
    *message = '\0';
    assert_int_equal(ect_place_listen(path, message), -1);
    assert_string_equal(message, "unix:PATH has 1 to 107 characters after the colon");
    assert_int_equal(rmdir(folder), 0);
}

/* A socket without a listener is replaced; one with a listener, and a file, stay. */
static void only_the_socket_of_a_dead_process_is_replaced(void **state)
{
    char folder[] = "/tmp/ectwin-place-XXXXXX", path[100], message[ECT_PLACE_MESSAGE] = "", wanted[200];
    (void)state;
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/port", folder);
    (void)snprintf(wanted, sizeof wanted, "'%s' exists already: remove it, or choose another path", path);
    const int before = next_descriptor();
    int fd = ect_place_listen(path, message);
    assert_int_equal(fd, before);
    assert_int_equal(ect_place_listen(path, message), -1);
    assert_string_equal(message, wanted);
    (void)close(fd);
    fd = ect_place_listen(path, message);
    assert_int_equal(fd, before);
    (void)close(fd);
    assert_int_equal(unlink(path), 0);
    const int file = __real_open(path, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    (void)close(file);
    *message = '\0';
    assert_int_equal(ect_place_listen(path, message), -1);
    assert_string_equal(message, wanted);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
    assert_int_equal(ect_place_listen(path, message), -1);
    (void)snprintf(wanted, sizeof wanted, "no socket at '%s': No such file or directory", path);
    assert_string_equal(message, wanted);
    assert_int_equal(next_descriptor(), before);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tap_has_a_name_and_is_brought_up),
        cmocka_unit_test(descriptor_0_is_one_as_any_other),
        cmocka_unit_test(a_refused_tap_has_cause_and_cure),
        cmocka_unit_test(a_text_names_a_tap_or_a_path),
        cmocka_unit_test(a_path_has_1_to_107_characters),
        cmocka_unit_test(only_the_socket_of_a_dead_process_is_replaced),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("places of networks", tests, NULL, NULL);
}
