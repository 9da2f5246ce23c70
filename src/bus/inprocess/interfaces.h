/* SPDX-License-Identifier: MIT */
/** @file
 * The interfaces of the bus among those of the machine. */
#ifndef ECT_BUS_INPROCESS_INTERFACES_H
#define ECT_BUS_INPROCESS_INTERFACES_H

#include <stdbool.h>

/** Whether a request of ioctl(2) is one that an interface of the bus has an answer to. */
bool ect_interface_has(unsigned long request);

/**
 * A request of ioctl(2) about an interface of the bus, or for the list of all.
 * @param[out] result  of ioctl: 0; -1 (errno)
 * @return false: about something else, nothing has been done
 */
bool ect_interface_request(int fd, unsigned long request, void *argument, int *result);

#endif
