/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/tasks.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "bus/inprocess/real.h"

/* Reads a file about a thread of this process. @return whether it could be read */
static bool read_about(pid_t id, const char *file, char *text, size_t room)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/self/task/%d/%s", (int)id, file);
    int fd = REAL(open)(path, O_RDONLY | O_CLOEXEC);
    ssize_t length = fd >= 0 ? REAL(read)(fd, text, room - 1) : -1;
    if (fd >= 0)
        REAL(close)(fd);
    text[length > 0 ? length : 0] = 0;
    return length > 0;
}

bool ect_task_sleeps(pid_t id)
{
    char text[256];
    if (!read_about(id, "stat", text, sizeof text))
        return false;
    const char *name_end = strrchr(text, ')');
    return name_end && name_end[1] == ' ' && name_end[2] == 'S';
}

const char *ect_task_call(pid_t id, char *name)
{
    static const struct {
        long number;
        const char *name;
    } names[] = {{SYS_wait4, "wait4()"},       {SYS_waitid, "waitid()"},   {SYS_read, "read()"},
                 {SYS_write, "write()"},       {SYS_futex, "futex()"},     {SYS_connect, "connect()"},
                 {SYS_recvfrom, "recvfrom()"}, {SYS_recvmsg, "recvmsg()"}, {SYS_sendto, "sendto()"},
                 {SYS_sendmsg, "sendmsg()"},   {SYS_flock, "flock()"},     {SYS_fcntl, "fcntl()"}};
    char text[256];
    char *end = text;
    long number = read_about(id, "syscall", text, sizeof text) ? strtol(text, &end, 10) : -1;
    if (end == text)
        return "a system call";
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (names[i].number == number)
            return names[i].name;
    }
    snprintf(name, ECT_TASK_CALL, "system call %ld", number);
    return name;
}

bool ect_task_blocks(pid_t id, int number)
{
    char text[4096];
    const char *line = read_about(id, "status", text, sizeof text) ? strstr(text, "\nSigBlk:") : NULL;
    return !line || (strtoull(line + 8, NULL, 16) >> (number - 1) & 1u) != 0;
}
