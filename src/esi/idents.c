/* SPDX-License-Identifier: MIT */
/* Lists of modules (ETG.5001): F050h has their idents, F030h those that a master has configured; F040h and F020h their
 * addresses likewise, which are the numbers of their slots; F010h their profiles. */
#include <string.h>

#include "esi/internal.h"
#include "seams/al_status.h"
#include "seams/standard.h"
#include "wire/bytes.h"

enum { MODULES = 0xF000, DOWNLOAD_REVISION = 0xF081 };

static void make(ect_build_t *build, uint16_t index, const char *name, const char *element, uint16_t type,
                 uint16_t access, size_t count)
{
    if (ect_build_find(build, index) == NULL)
        (void)ect_build_numbers(build, index, name, element, type, access, NULL, 0, count);
}

static void make_lists(ect_build_t *build, size_t count)
{
    const uint32_t device[] = {build->model->slot_index_increment, (uint32_t)count};
    if (ect_build_find(build, MODULES) == NULL) {
        ect_build_object_t *object = ect_build_numbers(build, MODULES, "Modular device profile", "Index distance",
                                                       ECT_TYPE_UNSIGNED16, ECT_ACCESS_RO, device, 2, 2);
        object->entries[2].name = "Maximum number of modules";
    }
    make(build, ECT_ESI_PROFILES, "Module profile list", "Module profile", ECT_TYPE_UNSIGNED32, ECT_ACCESS_RO, count);
    if (build->model->download_idents) {
        make(build, ECT_ESI_IDENTS, "Configured module ident list", "Module ident", ECT_TYPE_UNSIGNED32,
             ECT_ACCESS_RW_PREOP, count);
        make(build, ECT_ESI_IDENTS_DETECTED, "Detected module ident list", "Module ident", ECT_TYPE_UNSIGNED32,
             ECT_ACCESS_RO, count);
    }
    if (build->model->download_addresses) {
        make(build, ECT_ESI_ADDRESSES, "Configured address list", "Module address", ECT_TYPE_UNSIGNED16,
             ECT_ACCESS_RW_PREOP, count);
        make(build, ECT_ESI_ADDRESSES_DETECTED, "Detected address list", "Module address", ECT_TYPE_UNSIGNED16,
             ECT_ACCESS_RO, count);
    }
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

void ect_build_revision(ect_build_t *build)
{
    const ect_build_object_t *object = ect_build_find(build, DOWNLOAD_REVISION);
    ect_build_entry_t *entry = object != NULL ? ect_build_entry(object, 1) : NULL;
    if (entry != NULL && entry->bits == 32 && entry->initial.length == 0)
        ect_build_initial(build, entry, build->model->revision);
}

void ect_build_idents(ect_build_t *build)
{
    const size_t count = build->ident_count < UINT8_MAX ? build->ident_count : UINT8_MAX;
    if (count == 0 || !build->model->mailbox.coe)
        return;
    uint32_t profiles[UINT8_MAX], addresses[UINT8_MAX];
    for (size_t i = 0; i < count; i++) {
        const ect_esi_module_t *module = ect_esi_module(build->model, build->idents[i]);
        profiles[i] = module != NULL ? module->profile : 0;
        addresses[i] = module != NULL ? (uint32_t)i + 1 : 0;
    }
    if (build->model->download_idents || build->model->download_addresses)
        make_lists(build, count);
    fill(build, ECT_ESI_PROFILES, profiles, count);
    fill(build, ECT_ESI_ADDRESSES, NULL, count);
    fill(build, ECT_ESI_IDENTS, NULL, count);
    fill(build, ECT_ESI_ADDRESSES_DETECTED, addresses, count);
    fill(build, ECT_ESI_IDENTS_DETECTED, build->idents, count);
}

uint32_t ect_esi_list_at(const ect_od_t *od, uint16_t index, uint8_t subindex)
{
    uint32_t value = 0;
    return ect_od_number(od, index, subindex, &value) == ECT_OK ? value : 0;
}

/* An empty list, or a list of zeros, requests no check; another list has an element for each slot. */
static bool fits(const ect_od_t *od, uint16_t configured, uint16_t detected)
{
    const uint32_t count = ect_esi_list_at(od, configured, 0);
    bool any = false, equal = true;
    for (uint32_t i = 1; i <= count && i <= UINT8_MAX; i++) {
        const uint32_t value = ect_esi_list_at(od, configured, (uint8_t)i);
        any |= value != 0;
        equal &= value == ect_esi_list_at(od, detected, (uint8_t)i);
    }
    return !any || equal;
}

bool ect_esi_idents_fit(const ect_od_t *od)
{
    return fits(od, ECT_ESI_IDENTS, ECT_ESI_IDENTS_DETECTED) && fits(od, ECT_ESI_ADDRESSES, ECT_ESI_ADDRESSES_DETECTED);
}

uint16_t ect_esi_idents_state(void *instance, uint8_t from, uint8_t to)
{
    const ect_standard_t *standard = instance;
    const ect_od_t od = ect_device_od(standard->device, instance);
    return from == ECT_STATE_PREOP && to == ECT_STATE_SAFEOP && !ect_esi_idents_fit(&od) ? ECT_AL_MODULE_IDENTS
                                                                                         : ECT_AL_NO_ERROR;
}

ect_reason_t ect_esi_idents_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    const ect_standard_t *standard = instance;
    const ect_build_t *build = &((const ect_esi_twin_t *)standard->device->context)->build;
    uint8_t bytes[4] = {0};
    if (index != ECT_ESI_IDENTS || subindex == 0 || size > sizeof bytes)
        return ECT_OK;
    memcpy(bytes, data, size);
    const uint32_t ident = ect_load_le32(bytes);
    return ident == 0 || build->ident_count == 0 || ect_esi_place_takes(build->model, subindex - 1u, ident)
               ? ECT_OK
               : ECT_REASON_RANGE;
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    (void)now_ns;
    return ect_esi_idents_state(instance, from, to);
}

/* @return whether the dictionary of a file without slots, such as a clone's, has modules in F050h */
static bool has_modules(const ect_build_t *build)
{
    const ect_build_object_t *detected = ect_build_find(build, ECT_ESI_IDENTS_DETECTED);
    for (size_t i = 0; detected != NULL && i < detected->count; i++) {
        if (detected->entries[i].subindex != 0 && ect_build_number(&detected->entries[i]) != 0)
            return true;
    }
    return false;
}

void ect_esi_idents_set(const ect_build_t *build, ect_device_t *device)
{
    if (ect_build_find(build, ECT_ESI_IDENTS) == NULL || (build->ident_count == 0 && !has_modules(build)))
        return;
    device->state_change = state_change;
    device->sdo_write = ect_esi_idents_write;
}
