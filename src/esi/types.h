/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Data types of ESI files, and the corresponding types of a dictionary.
 *
 * Clauses: ETG.1020 (codes), IEC 61131-3 names as ETG.2000 uses them.
 */
#ifndef ECT_ESI_TYPES_H
#define ECT_ESI_TYPES_H

#include "esi/model.h"
#include "wire/linkage.h"

/** A type, resolved to a basic type of an entry. */
typedef struct ect_esi_basic {
    uint16_t code; /**< ECT_TYPE_... */
    uint32_t bits;
    ect_esi_number_t minimum, maximum; /**< of an enumeration */
} ect_esi_basic_t;

ECT_C_BEGIN

/** @return the type with a name in a dictionary; NULL: none */
const ect_esi_type_t *ect_esi_find_type(const ect_esi_dictionary_t *dictionary, const char *name);

/**
 * Resolves a name to a basic type: IEC names (`UINT`, `STRING(20)`, `ARRAY [0..7] OF BYTE`), types of the dictionary
 * with such a base, and enumerations. An unknown type becomes an integer of the same number of bits, or bytes.
 * @param dictionary  may be NULL
 * @param bits        length of the entry; 0: that of the type
 * @return false: a record, or the length is unknown
 */
bool ect_esi_resolve(const ect_esi_dictionary_t *dictionary, const char *name, uint32_t bits, ect_esi_basic_t *basic);

/** @return the ETG.2000 name of a code with this number of bits; static, or in `room` bytes of `text` */
const char *ect_esi_type_name(uint16_t code, uint32_t bits, char *text, size_t room);

ECT_C_END

#endif
