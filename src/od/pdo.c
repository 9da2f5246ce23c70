/* SPDX-License-Identifier: MIT */
#include "od/pdo.h"

uint32_t ect_od_element(const ect_object_t *object, uint32_t n)
{
    const ect_entry_t *entry = object && n <= 255 ? ect_od_entry(object, (uint8_t)n) : NULL;
    return entry ? entry->value : 0;
}

const ect_entry_t *ect_od_mapped(const ect_od_t *od, uint32_t mapping)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    ect_reason_t found = ect_od_lookup(od, (uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), &object, &entry);
    return found == ECT_OK ? entry : NULL; /* index 0 means a gap, and is no object */
}

uint32_t ect_od_pdo_bits(const ect_object_t *pdo)
{
    uint32_t bits = 0;
    uint32_t count = ect_od_element(pdo, 0);
    for (uint32_t n = 1; n <= count && n <= 255; n++)
        bits += ect_od_element(pdo, n) & 0xFF;
    return bits;
}

uint32_t ect_od_sm_bits(const ect_od_t *od, unsigned int sm)
{
    const ect_object_t *assignment = ect_od_find(od, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
    uint32_t bits = 0;
    uint32_t count = ect_od_element(assignment, 0);
    for (uint32_t n = 1; n <= count && n <= 255; n++)
        bits += ect_od_pdo_bits(ect_od_find(od, (uint16_t)ect_od_element(assignment, n)));
    return bits;
}
