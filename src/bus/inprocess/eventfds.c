/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/eventfds.h"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "bus/inprocess/real.h"

void ect_eventfd_replace(int fd, int other)
{
    int flags = REAL(fcntl)(fd, F_GETFD);
    (void)REAL(dup3)(other, fd, (flags & FD_CLOEXEC) != 0 ? O_CLOEXEC : 0);
}

void ect_eventfd_renew(int fd, bool readable)
{
    int fresh = eventfd(readable ? 1 : 0, EFD_NONBLOCK);
    if (fresh < 0)
        return;
    (void)REAL(fcntl)(fresh, F_SETFL, REAL(fcntl)(fd, F_GETFL));
    ect_eventfd_replace(fd, fresh);
    REAL(close)(fresh);
}
