/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/eoe/place.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

_Static_assert((int)ECT_PLACE_NAME == (int)IFNAMSIZ, "the name of an interface fits");

bool ect_place_is_tap(const char *text)
{
    return strncmp(text, "tap", 3) == 0 && strlen(text) < IFNAMSIZ && strcspn(text, "/ %:") == strlen(text);
}

const char *ect_place_path(const char *text)
{
    static const char prefix[] = "unix:";
    return strncmp(text, prefix, sizeof prefix - 1) == 0 ? text + sizeof prefix - 1 : NULL;
}

static int close_failed(int fd)
{
    int error = errno;
    close(fd);
    errno = error;
    return -1;
}

static void explain_tap(const char *name, char *message)
{
    if (errno == ENOENT || errno == ENODEV)
        snprintf(message, ECT_PLACE_MESSAGE, "there is no /dev/net/tun: 'sudo modprobe tun' loads its driver");
    else if (errno == EACCES)
        snprintf(message, ECT_PLACE_MESSAGE,
                 "/dev/net/tun is not open to this user: 'sudo chmod a+rw /dev/net/tun' opens it");
    else if (errno == EPERM)
        snprintf(message, ECT_PLACE_MESSAGE,
                 "'%s' needs CAP_NET_ADMIN: 'sudo ip tuntap add dev %s mode tap user %u' makes it for you, or 'ectwin "
                 "with' in a network of its own",
                 name, strcmp(name, "tap") == 0 ? "tap0" : name, (unsigned int)geteuid());
    else if (errno == EBUSY)
        snprintf(message, ECT_PLACE_MESSAGE, "another program has '%s' open: end it, or choose another name", name);
    else if (errno == EINVAL)
        snprintf(message, ECT_PLACE_MESSAGE, "'%s' exists already and is no TAP: choose another name", name);
    else
        snprintf(message, ECT_PLACE_MESSAGE, "opening the TAP '%s' failed: %s", name, strerror(errno));
}

/* Brings the interface up. Without CAP_NET_ADMIN this is the task of the interface's creator. */
static void bring_up(struct ifreq *request)
{
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return;
    if (ioctl(fd, SIOCGIFFLAGS, request) == 0) {
        request->ifr_flags |= IFF_UP;
        (void)ioctl(fd, SIOCSIFFLAGS, request);
    }
    close(fd);
}

int ect_place_tap(const char *text, char *name, char *message)
{
    struct ifreq request = {.ifr_flags = IFF_TAP | IFF_NO_PI};
    int fd = open("/dev/net/tun", O_RDWR | O_CLOEXEC | O_NONBLOCK);
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", strcmp(text, "tap") == 0 ? "tap%d" : text);
    if (fd >= 0 && ioctl(fd, TUNSETIFF, &request) < 0)
        fd = close_failed(fd);
    if (fd < 0) {
        explain_tap(text, message);
        return -1;
    }
    memcpy(name, request.ifr_name, ECT_PLACE_NAME);
    bring_up(&request);
    return fd;
}

/* A socket file without a listener is the remains of a dead process. */
static void clear(const char *path, const struct sockaddr_un *address)
{
    struct stat info;
    if (lstat(path, &info) < 0 || !S_ISSOCK(info.st_mode) || info.st_uid != geteuid())
        return;
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)address, sizeof *address) < 0 && errno == ECONNREFUSED)
        (void)unlink(path);
    if (fd >= 0)
        close(fd);
}

/* Creates the file with mode 0600, so that no other user can connect in between. */
static int bind_new(int fd, const struct sockaddr_un *address)
{
    mode_t before = umask(0177);
    int bound = bind(fd, (const struct sockaddr *)address, sizeof *address);
    umask(before);
    return bound;
}

int ect_place_listen(const char *path, char *message)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (*path == '\0' || strlen(path) >= sizeof address.sun_path) {
        snprintf(message, ECT_PLACE_MESSAGE, "unix:PATH has 1 to %zu characters after the colon",
                 sizeof address.sun_path - 1);
        return -1;
    }
    memcpy(address.sun_path, path, strlen(path) + 1);
    clear(path, &address);
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && (bind_new(fd, &address) < 0 || listen(fd, 1) < 0))
        fd = close_failed(fd);
    if (fd >= 0)
        return fd;
    if (errno == EADDRINUSE)
        snprintf(message, ECT_PLACE_MESSAGE, "'%s' exists already: remove it, or choose another path", path);
    else
        snprintf(message, ECT_PLACE_MESSAGE, "no socket at '%s': %s", path, strerror(errno));
    return -1;
}
