/* SPDX-License-Identifier: MIT */
/* /sys/class/net with the interfaces of the bus: its paths are mapped to a folder made by `ectwin with`. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <net/if.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/ports.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/user.h"

static const char system_folder[] = "/sys/class/net";

/* @return whether a path begins with /sys/class/net; false, too, for a bad address, which the real function refuses */
static bool begins_with_folder(const char *path)
{
    size_t length = sizeof system_folder - 1;
    size_t i = 0;
    char one;
    while (i < length && ect_user_read(&one, ect_user_at(path, i), 1) && one == system_folder[i])
        i++;
    return i == length;
}

/* @return the mapped path. Not inlined, because the copy takes a page of the stack. */
static __attribute__((noinline)) const char *mapped(const char *path, char room[PATH_MAX])
{
    char copy[PATH_MAX];
    const char *folder = getenv("ECTWIN_INPROCESS_NET");
    const char *rest = copy + sizeof system_folder - 1;
    if (!folder || !ect_user_string(copy, path, sizeof copy) || (*rest != '/' && *rest != 0))
        return path;
    rest += strspn(rest, "/");
    char name[IF_NAMESIZE];
    size_t length = strcspn(rest, "/");
    snprintf(name, sizeof name, "%.*s", (int)length, rest);
    int end = length < sizeof name ? ect_bus_end_of_name(name) : -1;
    if (length > 0 && end < 0)
        return path;
    const char *state = end >= 0 && !ect_port_is_up((unsigned int)end) ? "down" : "up";
    snprintf(room, PATH_MAX, "%s/%s/%s", folder, state, rest);
    return room;
}

static const char *path_of(const char *path, char room[PATH_MAX])
{
    return ect_inside > 0 || !begins_with_folder(path) ? path : mapped(path, room);
}

/* --- open --------------------------------------------------------------------------------------------------------- */

/* @return the third argument of open(), present if a file may be created */
static mode_t mode_of(int flags, va_list arguments)
{
    return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

REPLACES int open(const char *path, int flags, ...)
{
    char room[PATH_MAX];
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return REAL(open)(path_of(path, room), flags, mode);
}

REPLACES int open64(const char *path, int flags, ...)
{
    char room[PATH_MAX];
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return REAL(open64)(path_of(path, room), flags, mode);
}

REPLACES int openat(int folder, const char *path, int flags, ...)
{
    char room[PATH_MAX];
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return REAL(openat)(folder, path_of(path, room), flags, mode);
}

REPLACES int openat64(int folder, const char *path, int flags, ...)
{
    char room[PATH_MAX];
    va_list arguments;
    va_start(arguments, flags);
    mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return REAL(openat64)(folder, path_of(path, room), flags, mode);
}

/* The variants called with _FORTIFY_SOURCE and without a third argument. */
int __open_2(const char *path, int flags);
REPLACES int __open_2(const char *path, int flags)
{
    char room[PATH_MAX];
    return REAL(__open_2)(path_of(path, room), flags);
}

int __open64_2(const char *path, int flags);
REPLACES int __open64_2(const char *path, int flags)
{
    char room[PATH_MAX];
    return REAL(__open64_2)(path_of(path, room), flags);
}

int __openat_2(int folder, const char *path, int flags);
REPLACES int __openat_2(int folder, const char *path, int flags)
{
    char room[PATH_MAX];
    return REAL(__openat_2)(folder, path_of(path, room), flags);
}

int __openat64_2(int folder, const char *path, int flags);
REPLACES int __openat64_2(int folder, const char *path, int flags)
{
    char room[PATH_MAX];
    return REAL(__openat64_2)(folder, path_of(path, room), flags);
}

REPLACES FILE *fopen(const char *restrict path, const char *restrict mode)
{
    char room[PATH_MAX];
    return REAL(fopen)(path_of(path, room), mode);
}

REPLACES FILE *fopen64(const char *restrict path, const char *restrict mode)
{
    char room[PATH_MAX];
    return REAL(fopen64)(path_of(path, room), mode);
}

REPLACES DIR *opendir(const char *path)
{
    char room[PATH_MAX];
    return REAL(opendir)(path_of(path, room));
}

REPLACES int scandir(const char *restrict path, struct dirent ***restrict list, int (*filter)(const struct dirent *one),
                     int (*compare)(const struct dirent **a, const struct dirent **b))
{
    char room[PATH_MAX];
    return REAL(scandir)(path_of(path, room), list, filter, compare);
}

REPLACES int scandir64(const char *restrict path, struct dirent64 ***restrict list,
                       int (*filter)(const struct dirent64 *one),
                       int (*compare)(const struct dirent64 **a, const struct dirent64 **b))
{
    char room[PATH_MAX];
    return REAL(scandir64)(path_of(path, room), list, filter, compare);
}

/* --- attributes ----------------------------------------------------------------------------------------------------
 */

REPLACES int stat(const char *restrict path, struct stat *restrict its)
{
    char room[PATH_MAX];
    return REAL(stat)(path_of(path, room), its);
}

REPLACES int stat64(const char *restrict path, struct stat64 *restrict its)
{
    char room[PATH_MAX];
    return REAL(stat64)(path_of(path, room), its);
}

REPLACES int lstat(const char *restrict path, struct stat *restrict its)
{
    char room[PATH_MAX];
    return REAL(lstat)(path_of(path, room), its);
}

REPLACES int lstat64(const char *restrict path, struct stat64 *restrict its)
{
    char room[PATH_MAX];
    return REAL(lstat64)(path_of(path, room), its);
}

REPLACES int fstatat(int folder, const char *restrict path, struct stat *restrict its, int flags)
{
    char room[PATH_MAX];
    return REAL(fstatat)(folder, path_of(path, room), its, flags);
}

REPLACES int fstatat64(int folder, const char *restrict path, struct stat64 *restrict its, int flags)
{
    char room[PATH_MAX];
    return REAL(fstatat64)(folder, path_of(path, room), its, flags);
}

REPLACES int statx(int folder, const char *restrict path, int flags, unsigned int mask, struct statx *restrict its)
{
    char room[PATH_MAX];
    return REAL(statx)(folder, path_of(path, room), flags, mask, its);
}

REPLACES int access(const char *path, int how)
{
    char room[PATH_MAX];
    return REAL(access)(path_of(path, room), how);
}

REPLACES int faccessat(int folder, const char *path, int how, int flags)
{
    char room[PATH_MAX];
    return REAL(faccessat)(folder, path_of(path, room), how, flags);
}

REPLACES ssize_t readlink(const char *restrict path, char *restrict target, size_t size)
{
    char room[PATH_MAX];
    return REAL(readlink)(path_of(path, room), target, size);
}

REPLACES ssize_t readlinkat(int folder, const char *restrict path, char *restrict target, size_t size)
{
    char room[PATH_MAX];
    return REAL(readlinkat)(folder, path_of(path, room), target, size);
}

REPLACES char *realpath(const char *restrict path, char *restrict resolved)
{
    char room[PATH_MAX];
    return REAL(realpath)(path_of(path, room), resolved);
}

/* The variants called with _FORTIFY_SOURCE and a buffer of known size. */
ssize_t __readlink_chk(const char *path, char *target, size_t size, size_t room);
REPLACES ssize_t __readlink_chk(const char *path, char *target, size_t size, size_t room)
{
    char other[PATH_MAX];
    return REAL(__readlink_chk)(path_of(path, other), target, size, room);
}

ssize_t __readlinkat_chk(int folder, const char *path, char *target, size_t size, size_t room);
REPLACES ssize_t __readlinkat_chk(int folder, const char *path, char *target, size_t size, size_t room)
{
    char other[PATH_MAX];
    return REAL(__readlinkat_chk)(folder, path_of(path, other), target, size, room);
}

char *__realpath_chk(const char *path, char *resolved, size_t room);
REPLACES char *__realpath_chk(const char *path, char *resolved, size_t room)
{
    char other[PATH_MAX];
    return REAL(__realpath_chk)(path_of(path, other), resolved, room);
}
