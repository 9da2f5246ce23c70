/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The initial values of a dictionary, for files made from a description.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_VALUES_H
#define ECT_ESI_VALUES_H

#include "esi/arena.h"
#include "seams/device.h"
#include "wire/linkage.h"

/** The name of a sub-item in files, where names must be unique; in a dictionary they need not be. */
typedef struct ect_item_name {
    char unique[16];  /**< "SubIndex 007"; "": `name` is unique */
    const char *name; /**< the entry's, never NULL */
} ect_item_name_t;

ECT_C_BEGIN

/**
 * Makes a dictionary over an instance with the defaults, and with the identity of the installation in 1018h. The
 * device's functions are not called. The data of a list of addresses (::ect_device_t::addresses) are unchanged.
 * @param identity  NULL: the description's
 * @return the dictionary; the arena owns its instance
 */
ect_od_t ect_esi_values(ect_arena_t *arena, const ect_device_t *device, const ect_identity_t *identity);

/**
 * Encodes the value of an entry, little-endian; of a text its characters.
 * @param[out] size  bytes
 * @return the bytes, owned by the arena
 */
const uint8_t *ect_esi_entry_value(ect_arena_t *arena, const ect_od_t *od, const ect_entry_t *entry, size_t *size);

/** @return whether a file contains the value as a default; false: process data of zero */
bool ect_esi_has_default(const ect_entry_t *entry, const uint8_t *value, size_t size);

/** @return whether the elements are equal and without gaps, so that one type can describe all */
bool ect_esi_is_array(const ect_object_t *object);

/** @return the name of an entry of a record or array; that of sub-index 0 is always "SubIndex 000" */
ect_item_name_t ect_esi_item_name(const ect_object_t *object, const ect_entry_t *entry);

/** @return bit offset of an entry in the whole object: sub-index 0 has 16 bits, bit entries are not padded */
uint32_t ect_esi_item_offset(const ect_object_t *object, const ect_entry_t *entry);

/** @return bits of the whole object */
uint32_t ect_esi_object_bits(const ect_od_t *od, const ect_object_t *object);

/** @return the ETG.2000 name of a type with this number of bits, owned by the arena; NULL: none, as for 12-bit integers
 **/
const char *ect_esi_type_of(ect_arena_t *arena, uint16_t data_type, uint32_t bits);

/** @return "ro", "rw" or "wo"; "": no access right */
const char *ect_esi_access(uint16_t access);

/** @return the states of a restriction (ETG.2000): "PreOP", "PreOP_SafeOP" …; "": all states, or none */
const char *ect_esi_states(bool preop, bool safeop, bool op);

ECT_C_END

#endif
