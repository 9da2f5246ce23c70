/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The values of a dictionary before the first write: for files that are made from a description.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_VALUES_H
#define ECT_ESI_VALUES_H

#include "esi/arena.h"
#include "seams/device.h"
#include "wire/linkage.h"

/** How a sub-item is called in files: names there must differ, and those of a dictionary need not. */
typedef struct ect_item_name {
    char unique[16];  /**< "SubIndex 007", or "" when `name` is one of its own */
    const char *name; /**< the entry's, never NULL */
} ect_item_name_t;

ECT_C_BEGIN

/**
 * The dictionary over an instance that has its defaults, and the identity of the installation in 1018h. The device's
 * own functions are not called. The data of a list of addresses (::ect_device_t::addresses) are unchanged.
 * @param identity  NULL: the description's
 * @return the list; its instance lives as long as the arena
 */
ect_od_t ect_esi_values(ect_arena_t *arena, const ect_device_t *device, const ect_identity_t *identity);

/**
 * The value of an entry in wire form; of a text its characters.
 * @param[out] size  bytes
 * @return the bytes, as long as the arena
 */
const uint8_t *ect_esi_entry_value(ect_arena_t *arena, const ect_od_t *od, const ect_entry_t *entry, size_t *size);

/** Whether a file should have the value as a default: not process data of zero. */
bool ect_esi_has_default(const ect_entry_t *entry, const uint8_t *value, size_t size);

/** Whether its elements are alike and without gaps, so that one line can describe them all. */
bool ect_esi_is_array(const ect_object_t *object);

/** The name of an entry of a record or array; sub-index 0 is "SubIndex 000" in every file. */
ect_item_name_t ect_esi_item_name(const ect_object_t *object, const ect_entry_t *entry);

/** First bit of an entry when the whole object is read: sub-index 0 has 16 bits, entries of bits have no padding. */
uint32_t ect_esi_item_offset(const ect_object_t *object, const ect_entry_t *entry);

/** Bits of the whole object. */
uint32_t ect_esi_object_bits(const ect_od_t *od, const ect_object_t *object);

/** The ETG.2000 name of a type of that many bits, or NULL: there is none for 12 bits of a number. Memory of the arena.
 */
const char *ect_esi_type_of(ect_arena_t *arena, uint16_t data_type, uint32_t bits);

/** "ro", "rw", "wo"; "" without any right. */
const char *ect_esi_access(uint16_t access);

/** The states of a restriction (ETG.2000): "PreOP", "PreOP_SafeOP" …; "" when all are allowed, or none. */
const char *ect_esi_states(bool preop, bool safeop, bool op);

ECT_C_END

#endif
