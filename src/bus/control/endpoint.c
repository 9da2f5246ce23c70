/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/control/endpoint.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

enum { MOST_NAMES = 100, BACKLOG = 16 };

int ect_endpoint_folder(char *path)
{
    const char *runtime = getenv("XDG_RUNTIME_DIR");
    int length = runtime && *runtime ? snprintf(path, ECT_ENDPOINT_PATH, "%s/ectwin", runtime)
                                     : snprintf(path, ECT_ENDPOINT_PATH, "/tmp/ectwin-%u", geteuid());
    errno = ENAMETOOLONG;
    return length < ECT_ENDPOINT_PATH - 32 ? 0 : -1; /* leaves room for a name */
}

static bool is_socket_name(const char *name)
{
    size_t length = strlen(name);
    return name[0] != '.' && length > 5 && strcmp(name + length - 5, ".sock") == 0;
}

void ect_endpoint_each(const char *folder, bool (*found)(void *ctx, const char *path), void *ctx)
{
    char path[ECT_ENDPOINT_PATH];
    DIR *directory = opendir(folder);
    const struct dirent *entry;
    bool more = true;
    while (directory && more && (entry = readdir(directory)) != NULL) {
        if (is_socket_name(entry->d_name) &&
            snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) < (int)sizeof path)
            more = found(ctx, path);
    }
    if (directory)
        closedir(directory);
}

int ect_endpoint_find(const char *name, char *path)
{
    size_t room = strlen(name) + sizeof "/.sock";
    if (ect_endpoint_folder(path) < 0)
        return -1;
    size_t used = strlen(path);
    if (used + room > ECT_ENDPOINT_PATH)
        return -1;
    snprintf(path + used, room, "/%s.sock", name);
    return 0;
}

int ect_endpoint_trust(const char *folder)
{
    struct stat info;
    if (lstat(folder, &info) < 0)
        return -1;
    if (S_ISDIR(info.st_mode) && info.st_uid == geteuid() && (info.st_mode & (S_IWGRP | S_IWOTH)) == 0)
        return 0;
    errno = EPERM;
    return -1;
}

static int make_folder(const char *path)
{
    struct stat info;
    if (mkdir(path, 0700) < 0 && errno != EEXIST)
        return -1;
    if (lstat(path, &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == geteuid())
        (void)chmod(path, 0700);
    return ect_endpoint_trust(path);
}

/* bind() or connect() with a path of any length, relative to the folder's descriptor in /proc/self/fd. */
static int at_path(int (*call)(int fd, const struct sockaddr *address, socklen_t size), int fd, const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    char folder[ECT_ENDPOINT_PATH];
    const char *name = strrchr(path, '/');
    if (strlen(path) < sizeof address.sun_path) {
        memcpy(address.sun_path, path, strlen(path) + 1);
        return call(fd, (const struct sockaddr *)&address, sizeof address);
    }
    if (!name || snprintf(folder, sizeof folder, "%.*s", (int)(name - path), path) >= (int)sizeof folder) {
        errno = ENAMETOOLONG;
        return -1;
    }
    int at = open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (at < 0)
        return -1;
    int result = -1;
    errno = ENAMETOOLONG;
    if (snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d%s", at, name) <
        (int)sizeof address.sun_path)
        result = call(fd, (const struct sockaddr *)&address, sizeof address);
    int error = errno;
    close(at);
    errno = error;
    return result;
}

static int close_failed(int fd)
{
    int error = errno;
    close(fd);
    errno = error;
    return -1;
}

/* The send timeout also limits a blocking connect() to a socket with a full backlog. */
static int connect_to(const char *path, int flags, uid_t *owner)
{
    const struct timeval patience = {.tv_sec = ECT_ENDPOINT_PATIENCE_S};
    struct ucred peer;
    socklen_t size = sizeof peer;
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0);
    if (fd < 0)
        return -1;
    if (setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience) < 0 || at_path(connect, fd, path) < 0 ||
        getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) < 0)
        return close_failed(fd);
    *owner = peer.uid;
    return fd;
}

int ect_endpoint_connect(const char *path, uid_t *owner)
{
    return connect_to(path, 0, owner);
}

int ect_endpoint_connect_now(const char *path, uid_t *owner)
{
    return connect_to(path, SOCK_NONBLOCK, owner);
}

void ect_endpoint_clear(const char *path)
{
    struct stat info;
    uid_t owner;
    if (lstat(path, &info) < 0 || !S_ISSOCK(info.st_mode) || info.st_uid != geteuid())
        return;
    int fd = connect_to(path, SOCK_NONBLOCK, &owner);
    if (fd >= 0)
        close(fd);
    else if (errno == ECONNREFUSED)
        (void)unlink(path);
}

/* Creates the socket with mode 0600. */
static int bind_new(int fd, const char *path)
{
    mode_t before = umask(0177);
    int bound = at_path(bind, fd, path);
    umask(before);
    return bound;
}

/* Composes the nth candidate for a path. @return false: too long */
static bool compose(char *path, const char *folder, const char *before, const char *name, int n, const char *after)
{
    char number[16] = "";
    if (n > 1)
        snprintf(number, sizeof number, "-%d", n);
    int length = snprintf(path, ECT_ENDPOINT_PATH, "%s/%s%s%s%s", folder, before, name, number, after);
    errno = ENAMETOOLONG;
    return length < ECT_ENDPOINT_PATH;
}

/* Between bind() and listen() a socket appears dead, and another process would remove its file; so the file first gets
 * a hidden name. */
static int bind_aside(int fd, const char *folder, const char *pid, char *path)
{
    for (int n = 1; n <= MOST_NAMES; n++) {
        if (!compose(path, folder, ".", pid, n, ""))
            return -1;
        if (bind_new(fd, path) == 0)
            return 0;
        if (errno != EADDRINUSE)
            return -1;
    }
    return -1;
}

/* Renames a socket to the first free name; names of dead sockets are free. */
static int publish(const char *aside, const char *folder, const char *name, int most, char *path)
{
    for (int n = 1; n <= most; n++) {
        if (!compose(path, folder, "", name, n, ".sock"))
            return -1;
        if (link(aside, path) == 0)
            return 0;
        if (errno != EEXIST)
            return -1;
        ect_endpoint_clear(path);
        if (link(aside, path) == 0)
            return 0;
    }
    errno = EADDRINUSE;
    return -1;
}

static int listen_in(int fd, const char *folder, const char *name, char *path)
{
    char aside[ECT_ENDPOINT_PATH];
    char pid[16];
    snprintf(pid, sizeof pid, "%d", (int)getpid());
    if (bind_aside(fd, folder, pid, aside) < 0)
        return -1;
    int result = listen(fd, BACKLOG);
    if (result == 0)
        result = publish(aside, folder, name ? name : pid, name ? 1 : MOST_NAMES, path);
    int error = errno;
    (void)unlink(aside);
    errno = error;
    return result;
}

static bool clear_one(void *ctx, const char *path)
{
    (void)ctx;
    ect_endpoint_clear(path);
    return true;
}

const char *ect_endpoint_unfit(const char *name)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    static const char all[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    if (strlen(name) >= ECT_ENDPOINT_NAME || strspn(name, letters) == 0 || name[strspn(name, all)] != 0)
        return "a name has 1 to 31 letters, digits, '.', '_' and '-', and begins with a letter";
    return NULL;
}

int ect_endpoint_listen(const char *name, char *path, char *message)
{
    char folder[ECT_ENDPOINT_PATH] = "";
    if (ect_endpoint_folder(folder) < 0 || make_folder(folder) < 0) {
        const char *why = errno == EPERM ? "it is not a folder of your own" : strerror(errno);
        snprintf(message, ECT_ENDPOINT_MESSAGE, "no control socket in '%s': %s; XDG_RUNTIME_DIR can name another place",
                 folder, why);
        return -1;
    }
    ect_endpoint_each(folder, clear_one, NULL); /* sockets left behind by killed processes */
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && listen_in(fd, folder, name, path) == 0)
        return fd;
    int error = errno;
    if (name && error == EADDRINUSE)
        snprintf(
            message, ECT_ENDPOINT_MESSAGE,
            "a twin of yours with the name '%s' is running: end it, or choose another name; 'ectwin ps' lists them",
            name);
    else
        snprintf(message, ECT_ENDPOINT_MESSAGE, "no control socket in '%s': %s", folder, strerror(error));
    if (fd >= 0)
        close(fd);
    errno = error;
    return -1;
}

ino_t ect_endpoint_identity(const char *path)
{
    struct stat info;
    return lstat(path, &info) == 0 && S_ISSOCK(info.st_mode) ? info.st_ino : 0;
}

void ect_endpoint_close(int fd, const char *path, ino_t identity)
{
    if (identity != 0 && ect_endpoint_identity(path) == identity)
        (void)unlink(path);
    close(fd);
}
