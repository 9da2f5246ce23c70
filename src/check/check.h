/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Validation of device descriptions.
 *
 * The stack, the SII writer and the twins trust a description: they do not check whether tables are sorted, whether an
 * entry lies inside its instance, or whether a mapping fits its SyncManager. A description is validated once, by
 * ::ect_device_check: by the command before a twin starts, by the tests of a device, or by a program that makes a
 * description at run time. A valid description is safe to run; for an invalid one, a line names the first mistake.
 *
 * Host only: allocates (an SII image, to check its size) and formats text. Otherwise without side effects; any thread.
 *
 * Not checked: whether a pointer is valid, whether a count exceeds its array, and where the entries of an object
 * without a count (::ect_object_t::last) end. Such an object is refused, except in a list of addresses
 * (::ect_device_t::addresses), which may be SOES's.
 */
#ifndef ECT_CHECK_CHECK_H
#define ECT_CHECK_CHECK_H

#include <stdbool.h>
#include <stddef.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for a line, terminator included. */
enum { ECT_CHECK_TEXT = 256 };

/**
 * Checks a description: names and texts; ESC, SyncManagers, FMMUs and mailboxes; objects, entries, limits and defaults;
 * assignments and mappings; protocols and object services with what they need; distributed clocks; the SII's size.
 * @param[out] text  the first mistake, one line without a line end, e.g. `2400h:2: its default 0 is below its minimum
 *                   20`; empty without a mistake; truncated to `room` bytes
 * @return true: no mistake
 */
bool ect_device_check(const ect_device_t *device, char *text, size_t room);

/**
 * Checks a plant against its device: names, types, ranges and offsets of the signals.
 * @param plant  NULL: none, which is valid
 * @param[out] text  as above
 */
bool ect_plant_check(const ect_plant_t *plant, const ect_device_t *device, char *text, size_t room);

ECT_C_END

#endif
