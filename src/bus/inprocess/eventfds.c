/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/eventfds.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"

enum { DESCRIPTORS = 65536 };

static ect_eventfd_t *by_descriptor[DESCRIPTORS];
static unsigned int end; /* the descriptors of all objects, also of former ones, are below */
static pid_t owner;      /* the process with these descriptors: a child of vfork() has its own, but this memory */

ect_eventfd_t *ect_eventfd_make(ect_eventfd_kind_t *kind)
{
    ect_time_lock();
    ect_eventfd_t *its = kind->unused;
    kind->unused = its ? its->next : NULL;
    ect_time_unlock();
    if (!its)
        its = calloc(1, kind->size);
    if (its)
        *its = (ect_eventfd_t){.kind = kind, .fd = -1};
    return its;
}

void ect_eventfd_keep(ect_eventfd_t *its)
{
    *its = (ect_eventfd_t){.kind = its->kind, .next = its->kind->unused, .fd = -1};
    its->kind->unused = its;
}

/* With the lock. */
static void add(int fd, ect_eventfd_t *its)
{
    its->descriptors++;
    by_descriptor[fd] = its;
    end = (unsigned int)fd >= end ? (unsigned int)fd + 1 : end;
}

int ect_eventfd_open(ect_eventfd_t *its, int flags)
{
    int fd = eventfd(0, flags);
    if (fd >= DESCRIPTORS) {
        REAL(close)(fd);
        errno = EMFILE;
        fd = -1;
    }
    ect_time_lock();
    if (fd >= 0) {
        its->fd = fd;
        add(fd, its);
    } else {
        ect_eventfd_keep(its);
    }
    ect_time_unlock();
    return fd;
}

ect_eventfd_t *ect_eventfd_of(int fd, const ect_eventfd_kind_t *kind)
{
    ect_eventfd_t *its = fd >= 0 && fd < DESCRIPTORS ? by_descriptor[fd] : NULL;
    return its && its->kind == kind ? its : NULL;
}

void ect_eventfd_copied(int fd, int copy)
{
    if (fd < 0 || fd >= DESCRIPTORS || !by_descriptor[fd] || copy < 0 || copy >= DESCRIPTORS || getpid() != owner)
        return;
    ect_time_lock();
    if (by_descriptor[fd])
        add(copy, by_descriptor[fd]);
    ect_time_unlock();
}

static int descriptor_of(const ect_eventfd_t *its)
{
    int fd = 0;
    while (by_descriptor[fd] != its)
        fd++;
    return fd;
}

static void remove_descriptor(int fd, ect_eventfd_t *its)
{
    by_descriptor[fd] = NULL;
    its->descriptors--;
    if (its->fd == fd)
        its->fd = its->descriptors > 0 ? descriptor_of(its) : -1;
    if (its->descriptors == 0)
        its->kind->closed(its, fd);
}

void ect_eventfds_closed(unsigned int from, unsigned int to)
{
    for (unsigned int fd = from; fd <= to && fd < end; fd++) {
        if (!by_descriptor[fd] || getpid() != owner)
            continue;
        ect_time_lock();
        if (by_descriptor[fd])
            remove_descriptor((int)fd, by_descriptor[fd]);
        ect_time_unlock();
    }
}

/* --- children of fork() --------------------------------------------------------------------------------------------
 */

/* Opens a descriptor again, as a copy of another one, with its own FD_CLOEXEC. */
static void replace(int fd, int other)
{
    int flags = REAL(fcntl)(fd, F_GETFD);
    (void)REAL(dup3)(other, fd, (flags & FD_CLOEXEC) != 0 ? O_CLOEXEC : 0);
}

/* Opens a descriptor again, as one of a new eventfd with the same flags. */
static void renew(int fd, bool readable)
{
    int fresh = eventfd(readable ? 1 : 0, EFD_NONBLOCK);
    if (fresh < 0)
        return;
    (void)REAL(fcntl)(fresh, F_SETFL, REAL(fcntl)(fd, F_GETFL));
    replace(fd, fresh);
    REAL(close)(fresh);
}

/* A child has a bus and a virtual clock of its own, so its events are not those of its parent. */
static void in_child(void)
{
    owner = getpid();
    for (int fd = 0; fd < (int)end; fd++) {
        ect_eventfd_t *its = by_descriptor[fd];
        if (its && its->fd == fd)
            renew(fd, its->kind->inherited(its));
    }
    for (int fd = 0; fd < (int)end; fd++) {
        const ect_eventfd_t *its = by_descriptor[fd];
        if (its && its->fd != fd)
            replace(fd, its->fd);
    }
}

__attribute__((constructor)) static void begin(void)
{
    owner = getpid();
    (void)pthread_atfork(NULL, NULL, in_child);
}
