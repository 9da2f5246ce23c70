/* SPDX-License-Identifier: MIT */
#include "esi/types.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "od/od.h"
#include "wire/assert.h"

/* Maximum depth of base types: a deeper nesting is a loop. */
enum { DEPTH = 8 };

typedef struct named {
    const char *name;
    uint16_t code;
    uint16_t bits;
} named_t;

/* The first name of a code and length is used in written files. */
static const named_t names[] = {
    {"BOOL", ECT_TYPE_BOOLEAN, 1},       {"SINT", ECT_TYPE_INTEGER8, 8},      {"INT", ECT_TYPE_INTEGER16, 16},
    {"DINT", ECT_TYPE_INTEGER32, 32},    {"LINT", ECT_TYPE_INTEGER64, 64},    {"USINT", ECT_TYPE_UNSIGNED8, 8},
    {"UINT", ECT_TYPE_UNSIGNED16, 16},   {"UDINT", ECT_TYPE_UNSIGNED32, 32},  {"ULINT", ECT_TYPE_UNSIGNED64, 64},
    {"REAL", ECT_TYPE_REAL32, 32},       {"LREAL", ECT_TYPE_REAL64, 64},      {"BITARR8", ECT_TYPE_BITARR8, 8},
    {"BITARR16", ECT_TYPE_BITARR16, 16}, {"BITARR32", ECT_TYPE_BITARR32, 32}, {"BYTE", ECT_TYPE_UNSIGNED8, 8},
    {"WORD", ECT_TYPE_UNSIGNED16, 16},   {"DWORD", ECT_TYPE_UNSIGNED32, 32},  {"LWORD", ECT_TYPE_UNSIGNED64, 64},
    {"BIT", ECT_TYPE_BIT1, 1},           {"UINT8", ECT_TYPE_UNSIGNED8, 8},    {"UINT16", ECT_TYPE_UNSIGNED16, 16},
    {"UINT32", ECT_TYPE_UNSIGNED32, 32}, {"UINT64", ECT_TYPE_UNSIGNED64, 64}, {"INT8", ECT_TYPE_INTEGER8, 8},
    {"INT16", ECT_TYPE_INTEGER16, 16},   {"INT32", ECT_TYPE_INTEGER32, 32},   {"INT64", ECT_TYPE_INTEGER64, 64},
    {"TIME", ECT_TYPE_UNSIGNED32, 32},
};

const ect_esi_type_t *ect_esi_find_type(const ect_esi_dictionary_t *dictionary, const char *name)
{
    size_t low = 0;
    size_t high = dictionary != NULL ? dictionary->type_count : 0;
    size_t count = high;
    while (low < high) { /* the first that is not before the name */
        size_t middle = low + (high - low) / 2;
        if (strcmp(dictionary->types_by_name[middle]->name, name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low < count && strcmp(dictionary->types_by_name[low]->name, name) == 0 ? dictionary->types_by_name[low]
                                                                                  : NULL;
}

/* "STRING(20)", "ARRAY [0..7] OF BYTE", "BIT3": the name has the length. */
static bool resolve_sized(const char *name, ect_esi_basic_t *basic)
{
    unsigned int first;
    unsigned int last;
    unsigned int size;
    char element[24];
    ect_esi_basic_t one;
    if (sscanf(name, "STRING(%u)", &size) == 1 && size <= UINT16_MAX) {
        *basic = (ect_esi_basic_t){.code = ECT_TYPE_VISIBLE_STRING, .bits = 8 * size};
        return true;
    }
    if (sscanf(name, "BIT%u", &size) == 1 && size >= 1 && size <= 8) {
        *basic = (ect_esi_basic_t){.code = (uint16_t)(ECT_TYPE_BIT1 + size - 1), .bits = size};
        return true;
    }
    if (sscanf(name, "ARRAY [%u..%u] OF %23s", &first, &last, element) == 3 && last >= first &&
        last - first < UINT16_MAX && ect_esi_resolve(NULL, element, 0, &one)) {
        *basic = (ect_esi_basic_t){.code = ECT_TYPE_OCTET_STRING, .bits = (last - first + 1) * one.bits};
        return true;
    }
    return false;
}

static bool resolve_named(const char *name, ect_esi_basic_t *basic)
{
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(names[i].name, name) == 0) {
            *basic = (ect_esi_basic_t){.code = names[i].code, .bits = names[i].bits};
            return true;
        }
    }
    return resolve_sized(name, basic);
}

/* @return the integer type, or the byte string, of a length */
static uint16_t code_of_length(uint32_t bits)
{
    if (bits <= 8)
        return bits == 8 ? ECT_TYPE_UNSIGNED8 : (uint16_t)(ECT_TYPE_BIT1 + bits - 1);
    return bits == 16   ? ECT_TYPE_UNSIGNED16
           : bits == 32 ? ECT_TYPE_UNSIGNED32
           : bits == 64 ? ECT_TYPE_UNSIGNED64
                        : ECT_TYPE_OCTET_STRING;
}

/* @return whether an entry of a type can have a length */
static bool fits(uint16_t code, uint32_t bits)
{
    if (code == ECT_TYPE_VISIBLE_STRING || code == ECT_TYPE_OCTET_STRING)
        return true;
    if (code >= ECT_TYPE_BIT1 && code <= ECT_TYPE_BIT8)
        return bits == code - ECT_TYPE_BIT1 + 1u;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (names[i].code == code)
            return names[i].bits == bits;
    }
    return false;
}

/* Resolves a type of the dictionary: its base, or an array of bytes. */
static bool resolve_type(const ect_esi_dictionary_t *dictionary, const char *name, unsigned int depth,
                         ect_esi_basic_t *basic)
{
    const ect_esi_type_t *type = ect_esi_find_type(dictionary, name);
    if (type == NULL || depth == 0 || type->item_count > 0)
        return resolve_named(name, basic);
    bool based =
        *type->base != '\0' && strcmp(type->base, name) != 0 && resolve_type(dictionary, type->base, depth - 1, basic);
    if (!based && !resolve_named(name, basic))
        *basic = (ect_esi_basic_t){.code = code_of_length(type->bits), .bits = type->bits};
    if (type->elements.given)
        *basic = (ect_esi_basic_t){.code = ECT_TYPE_OCTET_STRING, .bits = type->bits};
    if (type->bits > 0)
        basic->bits = type->bits;
    if (type->is_enum) {
        basic->minimum = (ect_esi_number_t){.given = true, .value = type->lowest};
        basic->maximum = (ect_esi_number_t){.given = true, .value = type->highest};
    }
    return basic->bits > 0;
}

bool ect_esi_resolve(const ect_esi_dictionary_t *dictionary, const char *name, uint32_t bits, ect_esi_basic_t *basic)
{
    const ect_esi_type_t *type = ect_esi_find_type(dictionary, name);
    *basic = (ect_esi_basic_t){.code = ECT_TYPE_NONE};
    if (type != NULL && type->item_count > 0)
        return false;
    (void)resolve_type(dictionary, name, DEPTH, basic);
    if (bits > 0)
        basic->bits = bits;
    if (!fits(basic->code, basic->bits))
        basic->code = code_of_length(basic->bits);
    if (basic->code == ECT_TYPE_OCTET_STRING) // whole bytes; a PDO may map fewer bits
        basic->bits = (basic->bits + 7) / 8 * 8;
    return basic->bits > 0;
}

const char *ect_esi_type_name(uint16_t code, uint32_t bits, char *text, size_t room)
{
    ECT_ASSERT(bits > 0 && room > 0);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (names[i].code == code && names[i].bits == bits)
            return names[i].name;
    }
    if (code == ECT_TYPE_VISIBLE_STRING)
        (void)snprintf(text, room, "STRING(%u)", (unsigned int)(bits / 8));
    else if (bits < 8 || (bits == 8 && code != ECT_TYPE_OCTET_STRING))
        (void)snprintf(text, room, "BIT%u", (unsigned int)bits);
    else
        (void)snprintf(text, room, "ARRAY [0..%u] OF BYTE", (unsigned int)(bits / 8 - 1));
    return text;
}
