/* SPDX-License-Identifier: MIT */
/**
 * @file
 * PDOs of an object list: what its assignments (1C1xh) and mappings (16xxh, 1Axxh) say by default, that is in the
 * `value` of their entries, before a master has changed anything. For those who describe a device: its SII, its ESI,
 * the memory it needs. The list's instance, if it has one, is not looked at.
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

/** Whether an index is that of a mapping object, of data from (Rx) or to (Tx) the master. */
static inline bool ect_od_is_rxpdo(uint16_t index)
{
    return index >= 0x1600 && index < 0x1800;
}
static inline bool ect_od_is_txpdo(uint16_t index)
{
    return index >= 0x1A00 && index < 0x1C00;
}

/** Default of element n of an assignment or mapping object, n = 0 their number; 0 where there is none, or no object. */
uint32_t ect_od_element(const ect_object_t *object, uint32_t n);

/** The entry that a mapping value names; NULL for a gap, and for one that there is not. */
const ect_entry_t *ect_od_mapped(const ect_od_t *od, uint32_t mapping);

/** Bits of a mapping object's entries together. */
uint32_t ect_od_pdo_bits(const ect_object_t *pdo);

/** Bits of the PDOs that are assigned to SyncManager `sm`; 0 without an assignment object. Walks over all of them. */
uint32_t ect_od_sm_bits(const ect_od_t *od, unsigned int sm);

ECT_C_END

#endif
