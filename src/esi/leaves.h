/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Leaves: all elements without children and all attributes of an ESI file, as texts, for complete comparisons of files,
 * beyond the members of the model (esi/model.h).
 */
#ifndef ECT_ESI_LEAVES_H
#define ECT_ESI_LEAVES_H

#include "esi/model.h"
#include "wire/linkage.h"

/**
 * Called for a leaf; both texts are valid during the call.
 * @param path  elements separated by '/', each followed by its index or name, or from the second of the same name on by
 * its number; an attribute follows '@': `Device/Mailbox/CoE@SegmentedSdo`
 * @param modelled  the value affects a twin, unless another part of the file overrides it
 * @param value  of the attribute, or the text of the element, trimmed; "" for an empty element
 */
typedef void (*ect_esi_leaf_t)(void *ctx, bool modelled, const char *path, const char *value);

ECT_C_BEGIN

/**
 * Visits vendor, group and device, and the modules of a device with slots, in the order of the file. Cost: a walk over
 * them, about a microsecond for each element.
 */
void ect_esi_leaves(const ect_esi_device_t *device, ect_esi_leaf_t leaf, void *ctx);

ECT_C_END

#endif
