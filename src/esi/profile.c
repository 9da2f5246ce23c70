/* SPDX-License-Identifier: MIT */
/* Parts that the behaviour of every profile needs. */
#include "esi/internal.h"

enum { FIRST_OBJECT = 0x6000, ALIGNMENT = 16, MOST_LISTED = 12 };

int64_t ect_esi_wire_number(const ect_link_t *link, const uint8_t *data, uint16_t size)
{
    uint64_t bits = 0;
    for (unsigned int i = size; i-- > 0;)
        bits = bits << 8 | data[i];
    uint64_t sign = size < 8 ? UINT64_C(1) << (8 * size - 1) : 0;
    return link->is_signed && (bits & sign) != 0 ? (int64_t)(bits | ~(2 * sign - 1)) : (int64_t)bits;
}

bool ect_esi_wire_finite(const ect_link_t *link, const uint8_t *data, uint16_t size)
{
    if (!link->is_real || size != link->bytes)
        return true;
    const uint64_t bits = (uint64_t)ect_esi_wire_number(link, data, size);
    const uint64_t infinite = size == sizeof(float) ? UINT32_C(0x7F800000) : UINT64_C(0x7FF0000000000000);
    return (bits & infinite) != infinite;
}

size_t ect_esi_aligned(size_t at)
{
    return (at + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

const char *ect_esi_objects_without(ect_esi_twin_t *twin, unsigned int distance, bool (*simulated)(uint16_t index))
{
    const char *text = "";
    size_t count = 0;
    for (unsigned int i = 0; i < twin->device.object_count; i++) {
        unsigned int first = FIRST_OBJECT + distance;
        uint16_t index = twin->device.objects[i].index;
        if (index < first || index >= first + ECT_402_AXIS_OBJECTS || simulated((uint16_t)(index - distance)))
            continue;
        if (++count <= MOST_LISTED)
            text = ect_arena_print(&twin->arena, "%s %04X", text, (unsigned int)index);
    }
    if (count > MOST_LISTED)
        text = ect_arena_print(&twin->arena, "%s and %zu more", text, count - MOST_LISTED);
    return text;
}
