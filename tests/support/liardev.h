/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Devices made for tests that lie by CoE: testdev in all but its mailbox protocol. For programs that read a slave over
 * a real wire; tests/unit/reader has more kinds, in virtual time.
 */
#ifndef TESTS_SUPPORT_LIARDEV_H
#define TESTS_SUPPORT_LIARDEV_H

#include <stddef.h>

#include "seams/device.h"

/* The device with that number, from 0; its name begins with "liar-". NULL: there are no more. */
const ect_device_t *liardev(size_t number);

#endif
