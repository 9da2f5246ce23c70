/* SPDX-License-Identifier: MIT */
/** @file
 * The interfaces of the bus, listed after those of the machine. */
#ifndef ECT_BUS_INPROCESS_INTERFACES_H
#define ECT_BUS_INPROCESS_INTERFACES_H

#include <stdbool.h>

/** @return whether the interface of the bus supports a request of ioctl(2) */
bool ect_interface_has(unsigned long request);

/**
 * Executes a request of ioctl(2) for an interface of the bus, or for the list of all interfaces.
 * @param[out] result  of ioctl: 0; -1 (errno)
 * @return false: the request concerns no interface of the bus; no effect
 */
bool ect_interface_request(int fd, unsigned long request, void *argument, int *result);

#endif
