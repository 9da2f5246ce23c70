/* SPDX-License-Identifier: MIT */
/**
 * @file
 * PDOs of an object list by default: the assignments (1C1xh) and mappings (16xxh, 1Axxh) as the `value` of their
 * entries defines them, before a master changes anything. Used to write the SII and the ESI of a device and to compute
 * its memory. The instance of the list, if there is one, is not used.
 *
 * All functions are pure. Clauses: ETG.1000.6 §5.6.7.4, ETG.1020.
 */
#ifndef ECT_OD_PDO_H
#define ECT_OD_PDO_H

#include "od/od.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Index of the assignment object of SyncManager n: 1C10h + n. */
enum { ECT_OD_ASSIGNMENT = 0x1C10 };

/** Whether an index is that of a mapping object of outputs (RxPDO). */
static inline bool ect_od_is_rxpdo(uint16_t index)
{
    return index >= 0x1600 && index < 0x1800;
}
static inline bool ect_od_is_txpdo(uint16_t index)
{
    return index >= 0x1A00 && index < 0x1C00;
}

/** Default of element n of an assignment or mapping object, or for n = 0 the number of elements; 0 when the element
 * does not exist, or `object` is NULL. */
uint32_t ect_od_element(const ect_object_t *object, uint32_t n);

/** The entry that a mapping value refers to; NULL for a gap and for an unknown entry. */
const ect_entry_t *ect_od_mapped(const ect_od_t *od, uint32_t mapping);

/** Sum of the lengths of all entries of a mapping object, bits. */
uint32_t ect_od_pdo_bits(const ect_object_t *pdo);

/** Bits of all PDOs that are assigned to SyncManager `sm`; 0 without an assignment object. Cost: visits each of them.
 */
uint32_t ect_od_sm_bits(const ect_od_t *od, unsigned int sm);

ECT_C_END

#endif
