/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Eventfds in the place of the program's sockets and timers, with the descriptors that refer to each: dup(2), close(2),
 * vfork(2) and fork(2) have the effect that they have on files.
 *
 * The memory of an object is kept for the next one of its kind and never freed: a call finds its object before it has
 * the lock, and another thread may close it meanwhile; close(2) may be called by a handler that has interrupted
 * malloc().
 *
 * Context: any thread of the master. Without the lock, unless stated otherwise.
 */
#ifndef ECT_BUS_INPROCESS_EVENTFDS_H
#define ECT_BUS_INPROCESS_EVENTFDS_H

#include <stdbool.h>
#include <stddef.h>

/** The first member of an object. */
typedef struct ect_eventfd {
    struct ect_eventfd_kind *kind; /**< private */
    struct ect_eventfd *next;      /**< private: next unused one */
    int fd;                        /**< one of the descriptors; -1: none */
    unsigned int descriptors;      /**< 0: closed, also by another thread just before a call has the lock */
} ect_eventfd_t;

typedef struct ect_eventfd_kind {
    size_t size; /**< bytes of an object */
    /** Ends an object: its last descriptor, `fd`, is about to be closed. ::ect_eventfd_keep follows, at once or later.
     * With the lock. */
    void (*closed)(ect_eventfd_t *its, int fd);
    /** @return whether an object has an event in a child of fork(). Context: the child, before fork() returns. */
    bool (*inherited)(ect_eventfd_t *its);
    ect_eventfd_t *unused; /**< private */
} ect_eventfd_kind_t;

/** @return an object without descriptors: zeroed, or with the members that a kept one had; NULL: no memory (errno) */
ect_eventfd_t *ect_eventfd_make(ect_eventfd_kind_t *kind);

/** Keeps an object without descriptors for the next one of its kind. With the lock. */
void ect_eventfd_keep(ect_eventfd_t *its);

/** Opens the eventfd of an object, which is kept on failure. @param flags  EFD_ @return the descriptor; -1 (errno) */
int ect_eventfd_open(ect_eventfd_t *its, int flags);

/** @return the object of a descriptor; NULL: not one of this kind. Cost: one access to a table. */
ect_eventfd_t *ect_eventfd_of(int fd, const ect_eventfd_kind_t *kind);

/** Called after a descriptor of any file has been copied. @param copy  -1: failed */
void ect_eventfd_copied(int fd, int copy);

/** Called before the descriptors of a range, both ends inclusive, are closed. No effect in a child of vfork(). Takes no
 * lock if none of them is of an object. */
void ect_eventfds_closed(unsigned int from, unsigned int to);

#endif
