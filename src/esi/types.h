/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Data types of an ESI file and what they are in a dictionary.
 *
 * Clauses: ETG.1020 (codes), IEC 61131-3 names as ETG.2000 uses them.
 */
#ifndef ECT_ESI_TYPES_H
#define ECT_ESI_TYPES_H

#include "esi/model.h"
#include "wire/linkage.h"

/** A type resolved to what an entry can be. */
typedef struct ect_esi_basic {
    uint16_t code; /**< ECT_TYPE_... */
    uint32_t bits;
    ect_esi_number_t minimum, maximum; /**< of an enumeration */
} ect_esi_basic_t;

ECT_C_BEGIN

/** @return the type of that name in a dictionary, or NULL */
const ect_esi_type_t *ect_esi_find_type(const ect_esi_dictionary_t *dictionary, const char *name);

/**
 * Resolves a name to a basic type: IEC names (`UINT`, `STRING(20)`, `ARRAY [0..7] OF BYTE`), types of the dictionary
 * that rest on one, and enumerations. A type that is not known becomes the number of that many bits, or bytes.
 * @param dictionary  may be NULL
 * @param bits        length at the place that uses it, 0 when it has none: then that of the type
 * @return true; false when it is a record, or when neither name nor place has a length
 */
bool ect_esi_resolve(const ect_esi_dictionary_t *dictionary, const char *name, uint32_t bits, ect_esi_basic_t *basic);

/** @return the name that ETG.2000 has for a code with that many bits; static, or made in `room` bytes of `text` */
const char *ect_esi_type_name(uint16_t code, uint32_t bits, char *text, size_t room);

ECT_C_END

#endif
