/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Eventfds in the place of the program's sockets and timers, after fork().
 *
 * Context: the child of fork(), before it returns.
 */
#ifndef ECT_BUS_INPROCESS_EVENTFDS_H
#define ECT_BUS_INPROCESS_EVENTFDS_H

#include <stdbool.h>

/**
 * Opens a descriptor again, as one of a new eventfd with the same flags: events of the parent are not those of its
 * child. Unchanged if no descriptor is left.
 * @param readable  whether the new eventfd has an event
 */
void ect_eventfd_renew(int fd, bool readable);

/** Opens a descriptor again, as a copy of another one, with its own FD_CLOEXEC. */
void ect_eventfd_replace(int fd, int other);

#endif
