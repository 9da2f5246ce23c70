/* SPDX-License-Identifier: MIT */
/* The lists of module idents (ETG.5001): F050h contains the modules in the slots, F030h those configured by a master.
 **/
#include <string.h>

#include "esi/internal.h"
#include "seams/al_status.h"
#include "seams/standard.h"
#include "wire/bytes.h"

enum { MODULES = 0xF000, CONFIGURED = 0xF030, DETECTED = 0xF050 };

static void make_lists(ect_build_t *build, size_t count)
{
    const uint32_t device[] = {build->model->slot_index_increment, (uint32_t)count};
    if (ect_build_find(build, MODULES) == NULL) {
        ect_build_object_t *object = ect_build_numbers(build, MODULES, "Modular device profile", "Index distance",
                                                       ECT_TYPE_UNSIGNED16, ECT_ACCESS_RO, device, 2, 2);
        object->entries[2].name = "Maximum number of modules";
    }
    if (ect_build_find(build, CONFIGURED) == NULL)
        (void)ect_build_numbers(build, CONFIGURED, "Configured module ident list", "Module ident", ECT_TYPE_UNSIGNED32,
                                ECT_ACCESS_RW_PREOP, NULL, 0, count);
    if (ect_build_find(build, DETECTED) == NULL)
        (void)ect_build_numbers(build, DETECTED, "Detected module ident list", "Module ident", ECT_TYPE_UNSIGNED32,
                                ECT_ACCESS_RO, NULL, 0, count);
}

/* Sets the values of the existing elements of a list. */
static void fill(ect_build_t *build, uint16_t index, const uint32_t *idents, size_t count)
{
    const ect_build_object_t *object = ect_build_find(build, index);
    size_t filled = 0;
    for (size_t i = 0; object != NULL && i < object->count; i++) {
        ect_build_entry_t *entry = &object->entries[i];
        const bool in_list = entry->subindex > 0 && entry->subindex <= count;
        if (in_list && (entry->bits == 16 || entry->bits == 32)) {
            ect_build_initial(build, entry, idents != NULL ? idents[entry->subindex - 1u] : 0);
            filled++;
        }
    }
    if (filled > 0 && ect_build_entry(object, 0) != NULL)
        ect_build_initial(build, ect_build_entry(object, 0), filled);
}

void ect_build_idents(ect_build_t *build)
{
    const size_t count = build->ident_count < UINT8_MAX ? build->ident_count : UINT8_MAX;
    if (count == 0 || !build->model->mailbox.coe)
        return;
    if (build->model->download_idents)
        make_lists(build, count);
    fill(build, CONFIGURED, NULL, count);
    fill(build, DETECTED, build->idents, count);
}

/* @return element `subindex` of a list; 0: none */
static uint32_t ident_at(const ect_od_t *od, uint16_t index, uint8_t subindex)
{
    uint32_t ident = 0;
    return ect_od_number(od, index, subindex, &ident) == ECT_OK ? ident : 0;
}

/* @return whether F030h has no idents, or the ident of each slot */
static bool fits(const ect_od_t *od)
{
    const uint32_t count = ident_at(od, CONFIGURED, 0);
    bool any = false, equal = true;
    for (uint32_t i = 1; i <= count && i <= UINT8_MAX; i++) {
        const uint32_t configured = ident_at(od, CONFIGURED, (uint8_t)i);
        any |= configured != 0;
        equal &= configured == ident_at(od, DETECTED, (uint8_t)i);
    }
    return !any || equal;
}

uint16_t ect_esi_idents_state(void *instance, uint8_t from, uint8_t to)
{
    const ect_standard_t *standard = instance;
    const ect_od_t od = ect_device_od(standard->device, instance);
    return from == ECT_STATE_PREOP && to == ECT_STATE_SAFEOP && !fits(&od) ? ECT_AL_MODULE_IDENTS : ECT_AL_NO_ERROR;
}

ect_reason_t ect_esi_idents_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    const ect_standard_t *standard = instance;
    const ect_build_t *build = &((const ect_esi_twin_t *)standard->device->context)->build;
    uint8_t bytes[4] = {0};
    if (index != CONFIGURED || subindex == 0 || size > sizeof bytes)
        return ECT_OK;
    memcpy(bytes, data, size);
    const uint32_t ident = ect_load_le32(bytes);
    return ident == 0 || ect_esi_place_takes(build->model, subindex - 1u, ident) ? ECT_OK : ECT_REASON_RANGE;
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    (void)now_ns;
    return ect_esi_idents_state(instance, from, to);
}

void ect_esi_idents_set(const ect_build_t *build, ect_device_t *device)
{
    if (build->ident_count == 0 || ect_build_find(build, CONFIGURED) == NULL)
        return;
    device->state_change = state_change;
    device->sdo_write = ect_esi_idents_write;
}
