/* SPDX-License-Identifier: MIT */
#include "esi/modules.h"

#include <string.h>

#include "wire/assert.h"

unsigned int ect_esi_places(const ect_esi_device_t *device)
{
    unsigned int count = 0;
    for (size_t i = 0; i < device->slot_count; i++)
        count += device->slots[i].instances_max;
    return count;
}

const ect_esi_slot_t *ect_esi_slot_at(const ect_esi_device_t *device, unsigned int number, unsigned int *instance)
{
    for (size_t i = 0; i < device->slot_count; i++) {
        const ect_esi_slot_t *slot = &device->slots[i];
        if (number < slot->instances_max) {
            if (instance != NULL)
                *instance = number;
            return slot;
        }
        number -= slot->instances_max;
    }
    return NULL;
}

const ect_esi_module_t *ect_esi_module(const ect_esi_device_t *device, uint32_t ident)
{
    for (size_t i = 0; i < device->module_count; i++) {
        if (device->modules[i].ident == ident)
            return &device->modules[i];
    }
    return NULL;
}

bool ect_esi_slot_takes(const ect_esi_slot_t *slot, const ect_esi_module_t *module)
{
    for (size_t i = 0; i < slot->ident_count; i++) {
        if (slot->idents[i] == module->ident)
            return true;
    }
    for (size_t i = 0; i < slot->class_count; i++) {
        if (strcmp(slot->classes[i], module->module_class) == 0)
            return true;
    }
    return false;
}

bool ect_esi_place_takes(const ect_esi_device_t *device, unsigned int number, uint32_t ident)
{
    const ect_esi_slot_t *slot = ect_esi_slot_at(device, number, NULL);
    const ect_esi_module_t *module = ect_esi_module(device, ident);
    return slot != NULL && module != NULL && ect_esi_slot_takes(slot, module);
}

uint32_t ect_esi_preset(const ect_esi_device_t *device, unsigned int number)
{
    unsigned int instance = 0;
    const ect_esi_slot_t *slot = ect_esi_slot_at(device, number, &instance);
    ECT_ASSERT(slot != NULL);
    return instance < (slot->instances_min > 0 ? slot->instances_min : 1) ? slot->preset : 0;
}
