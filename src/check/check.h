/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Check: whether a description is one that everything else may rely on.
 *
 * The stack, the SII writer and the twins trust a description: they do not check whether tables are sorted, whether an
 * entry lies inside its instance, or whether a mapping fits its SyncManager. A description is validated once, by
 * ::ect_device_check: by the command before it starts a twin, by the tests of a device, by a program that makes a
 * description at run time. A description that passes is safe to run; for any other one line names the first mistake.
 *
 * Host only: it allocates (the SII image, to see whether it fits) and formats text. Pure otherwise; any thread.
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
 *                   20`; empty without a mistake. `room` bytes, cut off
 * where they end.
 * @return whether there is no mistake
 */
bool ect_device_check(const ect_device_t *device, char *text, size_t room);

/**
 * Checks a plant against its device: names, types, ranges, and where the signals lie.
 * @param plant  NULL: none, which is no mistake
 * @param[out] text  as above
 */
bool ect_plant_check(const ect_plant_t *plant, const ect_device_t *device, char *text, size_t room);

ECT_C_END

#endif
