/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Check: whether a description is one that everything else may rely on.
 *
 * The stack, the SII writer and the twins trust a description: they look things up without asking whether the tables
 * are sorted, whether an entry lies inside its instance, whether a mapping comes to what its SyncManager holds. This
 * is where it is asked, once: by the command before it starts a twin, by the tests of a device, by whoever makes a
 * description at run time. What passes is safe to run; what does not is told in one line.
 *
 * Host only: it allocates (the SII image, to see whether it fits) and formats text. Pure otherwise; any thread.
 *
 * What cannot be seen: whether a pointer leads anywhere, whether a count is larger than its array, and where the
 * entries of an object end that nobody has counted (::ect_object_t::last). The last is refused, but in a list of
 * addresses (::ect_device_t::addresses), which may be SOES's.
 */
#ifndef ECT_CHECK_CHECK_H
#define ECT_CHECK_CHECK_H

#include <stdbool.h>
#include <stddef.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for any of the lines below, terminator included. */
enum { ECT_CHECK_TEXT = 256 };

/**
 * Checks a description: names and texts; ESC, SyncManagers, FMMUs and mailboxes; objects, entries, limits and defaults;
 * assignments and mappings; protocols and object services with what they need; distributed clocks; the SII's size.
 * @param[out] text  what is wrong first, one line without a line end, e.g. `2400h:2: its default 0 is below its minimum
 *                   20`; empty when nothing is. `room` bytes, cut off where they end.
 * @return whether nothing is wrong
 */
bool ect_device_check(const ect_device_t *device, char *text, size_t room);

/**
 * Checks a plant against the device that it stands around: names, types, ranges, and where the signals lie.
 * @param plant  NULL: there is none, and nothing is wrong with that
 * @param[out] text  as above
 */
bool ect_plant_check(const ect_plant_t *plant, const ect_device_t *device, char *text, size_t room);

ECT_C_END

#endif
