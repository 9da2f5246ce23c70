/* SPDX-License-Identifier: MIT */
/* Parts that the behaviour of every profile needs. */
#include <string.h>

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

const char *ect_esi_objects_without(ect_esi_twin_t *twin, unsigned int first, unsigned int count,
                                    bool (*simulated)(uint16_t index))
{
    const char *text = "";
    size_t found = 0;
    for (unsigned int i = 0; i < twin->device.object_count; i++) {
        uint16_t index = twin->device.objects[i].index;
        if (index < first || index - first >= count || simulated((uint16_t)(index - first + FIRST_OBJECT)))
            continue;
        if (++found <= MOST_LISTED)
            text = ect_arena_print(&twin->arena, "%s %04X", text, (unsigned int)index);
    }
    if (found > MOST_LISTED)
        text = ect_arena_print(&twin->arena, "%s and %zu more", text, found - MOST_LISTED);
    return text;
}

void ect_esi_profile_note(ect_esi_twin_t *twin, const char *text, const char *rest)
{
    ect_build_note(&twin->build, "%s%s%s", text, *rest != '\0' ? "; without behaviour:" : "", rest);
}

void ect_esi_profile_place(ect_esi_twin_t *twin, size_t size, size_t outside_size, size_t *offset, size_t *outside)
{
    *offset = ect_esi_aligned(twin->device.instance_size);
    *outside = ect_esi_aligned(*offset + size);
    twin->plant.outside_offset = *outside;
    twin->plant.outside_size = outside_size;
    twin->device.instance_size = *outside + outside_size;
}

void ect_esi_profile_signals(ect_esi_twin_t *twin, const ect_signal_group_t *groups, uint16_t count,
                             bool (*writes)(const ect_esi_twin_t *twin, uint32_t offset))
{
    ect_plant_t *plant = &twin->plant;
    const uint16_t of_file = plant->signal_group_count;
    ect_signal_group_t *all = ect_arena_alloc(&twin->arena, (size_t)(count + of_file) * sizeof *all);
    memcpy(all, groups, count * sizeof *all);
    for (uint16_t g = 0; g < of_file; g++) {
        all[count + g] = plant->signal_groups[g];
        for (uint16_t i = 0; i < all[count + g].signal_count; i++) {
            ect_signal_t *signal = (ect_signal_t *)(uintptr_t)&all[count + g].signals[i]; /* made by build_signals.c */
            if (writes(twin, signal->offset))
                signal->access = ECT_SIGNAL_READ;
        }
    }
    plant->signal_groups = all;
    plant->signal_group_count = (uint16_t)(count + of_file);
}
