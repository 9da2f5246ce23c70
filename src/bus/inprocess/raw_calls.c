/* SPDX-License-Identifier: MIT */
/* Direct system calls of the program, mapped to the functions that this library replaces. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <limits.h>
#include <stdint.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "bus/inprocess/raw.h"
#include "bus/inprocess/user.h"

static long make_socket(const long *a)
{
    return ect_raw_result(socket((int)a[0], (int)a[1], (int)a[2]));
}

static long make_bind(const long *a)
{
    return ect_raw_result(bind((int)a[0], (const struct sockaddr *)a[1], (socklen_t)a[2]));
}

static long make_setsockopt(const long *a)
{
    return ect_raw_result(setsockopt((int)a[0], (int)a[1], (int)a[2], (const void *)a[3], (socklen_t)a[4]));
}

static long make_getsockopt(const long *a)
{
    return ect_raw_result(getsockopt((int)a[0], (int)a[1], (int)a[2], (void *)a[3], (socklen_t *)a[4]));
}

static long make_getsockname(const long *a)
{
    return ect_raw_result(getsockname((int)a[0], (struct sockaddr *)a[1], (socklen_t *)a[2]));
}

static long make_ioctl(const long *a)
{
    return ect_raw_result(ioctl((int)a[0], (unsigned long)a[1], (void *)a[2]));
}

static long make_sendto(const long *a)
{
    return ect_raw_result(
        sendto((int)a[0], (const void *)a[1], (size_t)a[2], (int)a[3], (const struct sockaddr *)a[4], (socklen_t)a[5]));
}

static long make_sendmsg(const long *a)
{
    return ect_raw_result(sendmsg((int)a[0], (const struct msghdr *)a[1], (int)a[2]));
}

static long make_sendmmsg(const long *a)
{
    return ect_raw_result(sendmmsg((int)a[0], (struct mmsghdr *)a[1], (unsigned int)a[2], (int)a[3]));
}

static long make_write(const long *a)
{
    return ect_raw_result(write((int)a[0], (const void *)a[1], (size_t)a[2]));
}

static long make_writev(const long *a)
{
    return ect_raw_result(writev((int)a[0], (const struct iovec *)a[1], (int)a[2]));
}

static long make_recvfrom(const long *a)
{
    return ect_raw_result(
        recvfrom((int)a[0], (void *)a[1], (size_t)a[2], (int)a[3], (struct sockaddr *)a[4], (socklen_t *)a[5]));
}

static long make_recvmsg(const long *a)
{
    return ect_raw_result(recvmsg((int)a[0], (struct msghdr *)a[1], (int)a[2]));
}

static long make_recvmmsg(const long *a)
{
    return ect_raw_result(
        recvmmsg((int)a[0], (struct mmsghdr *)a[1], (unsigned int)a[2], (int)a[3], (struct timespec *)a[4]));
}

static long make_read(const long *a)
{
    return ect_raw_result(read((int)a[0], (void *)a[1], (size_t)a[2]));
}

static long make_readv(const long *a)
{
    return ect_raw_result(readv((int)a[0], (const struct iovec *)a[1], (int)a[2]));
}

static long make_accept(const long *a)
{
    return ect_raw_result(accept((int)a[0], (struct sockaddr *)a[1], (socklen_t *)a[2]));
}

static long make_accept4(const long *a)
{
    return ect_raw_result(accept4((int)a[0], (struct sockaddr *)a[1], (socklen_t *)a[2], (int)a[3]));
}

static long make_close(const long *a)
{
    return ect_raw_result(close((int)a[0]));
}

static long make_close_range(const long *a)
{
    return ect_raw_result(close_range((unsigned int)a[0], (unsigned int)a[1], (int)a[2]));
}

static long make_dup(const long *a)
{
    return ect_raw_result(dup((int)a[0]));
}

static long make_dup2(const long *a)
{
    return ect_raw_result(dup2((int)a[0], (int)a[1]));
}

static long make_dup3(const long *a)
{
    return ect_raw_result(dup3((int)a[0], (int)a[1], (int)a[2]));
}

static long make_fcntl(const long *a)
{
    return ect_raw_result(fcntl((int)a[0], (int)a[1], a[2]));
}

static long make_open(const long *a)
{
    return ect_raw_result(open((const char *)a[0], (int)a[1], (mode_t)a[2]));
}

static long make_openat(const long *a)
{
    return ect_raw_result(openat((int)a[0], (const char *)a[1], (int)a[2], (mode_t)a[3]));
}

static long make_newfstatat(const long *a)
{
    return ect_raw_result(fstatat((int)a[0], (const char *)a[1], (struct stat *)a[2], (int)a[3]));
}

static long make_readlinkat(const long *a)
{
    return ect_raw_result(readlinkat((int)a[0], (const char *)a[1], (char *)a[2], (size_t)a[3]));
}

static const ect_raw_entry_t table[] = {{SYS_socket, make_socket},
                                        {SYS_bind, make_bind},
                                        {SYS_setsockopt, make_setsockopt},
                                        {SYS_getsockopt, make_getsockopt},
                                        {SYS_getsockname, make_getsockname},
                                        {SYS_ioctl, make_ioctl},
                                        {SYS_sendto, make_sendto},
                                        {SYS_sendmsg, make_sendmsg},
                                        {SYS_sendmmsg, make_sendmmsg},
                                        {SYS_write, make_write},
                                        {SYS_writev, make_writev},
                                        {SYS_recvfrom, make_recvfrom},
                                        {SYS_recvmsg, make_recvmsg},
                                        {SYS_recvmmsg, make_recvmmsg},
                                        {SYS_read, make_read},
                                        {SYS_readv, make_readv},
                                        {SYS_accept, make_accept},
                                        {SYS_accept4, make_accept4},
                                        {SYS_close, make_close},
                                        {SYS_close_range, make_close_range},
                                        {SYS_dup, make_dup},
                                        {SYS_dup2, make_dup2},
                                        {SYS_dup3, make_dup3},
                                        {SYS_fcntl, make_fcntl},
                                        {SYS_open, make_open},
                                        {SYS_openat, make_openat},
                                        {SYS_newfstatat, make_newfstatat},
                                        {SYS_readlinkat, make_readlinkat}};

/* Checks the address of a path, because a sanitizer of the program reads the path before the replaced function. */
static bool has_bad_path(const ect_raw_call_t *call)
{
    static const struct {
        long number;
        size_t at;
    } paths[] = {{SYS_open, 0}, {SYS_openat, 1}, {SYS_newfstatat, 1}, {SYS_readlinkat, 1}};
    char copy[PATH_MAX];
    size_t i = 0;
    while (i < sizeof paths / sizeof *paths && paths[i].number != call->number)
        i++;
    return i < sizeof paths / sizeof *paths && !ect_user_string(copy, (const char *)call->a[paths[i].at], sizeof copy);
}

static long make(const ect_raw_call_t *call)
{
    long result;
    if (has_bad_path(call))
        return ect_raw_pass(call);
    if (ect_raw_on_clock(call, &result) || ect_raw_find(table, sizeof table / sizeof *table, call, &result))
        return result;
    return ect_raw_pass(call);
}

__attribute__((constructor)) static void begin(int argc, char **argv)
{
    ect_raw_begin(make, argc, argv);
}
