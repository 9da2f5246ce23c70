/* SPDX-License-Identifier: MIT */
#include "support/copy.h"

#include <stdlib.h>
#include <string.h>

static void *duplicate(const void *from, size_t size, size_t more)
{
    void *block = calloc(1, size + more > 0 ? size + more : 1);
    if (!block)
        abort();
    if (size > 0)
        memcpy(block, from, size);
    return block;
}

static void copy_entries(copy_t *c, const ect_device_t *device)
{
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        for (uint16_t k = 0; k < i && !c->entries[i]; k++)
            c->entries[i] = device->objects[k].entries == object->entries ? c->entries[k] : NULL;
        if (!c->entries[i])
            c->entries[i] = duplicate(object->entries, (object->last + (size_t)1) * sizeof(ect_entry_t), 0);
        c->objects[i].entries = c->entries[i];
    }
}

copy_t *copy_device(const ect_device_t *device)
{
    copy_t *c = duplicate(NULL, 0, sizeof *c);
    c->device = *device;
    c->objects = duplicate(device->objects, device->object_count * sizeof *c->objects, 0);
    c->entries = duplicate(NULL, 0, device->object_count * sizeof *c->entries);
    c->details = duplicate(device->details, device->detail_count * sizeof *c->details, sizeof *c->details);
    c->pdos = duplicate(device->pdos, device->pdo_count * sizeof *c->pdos, sizeof *c->pdos);
    c->dc_modes = duplicate(device->dc_modes, device->dc_mode_count * sizeof *c->dc_modes, 0);
    c->device.objects = c->objects;
    c->device.details = c->details;
    c->device.pdos = device->pdo_count > 0 ? c->pdos : NULL;
    c->device.dc_modes = device->dc_mode_count > 0 ? c->dc_modes : NULL;
    copy_entries(c, device);
    return c;
}

void copy_free(copy_t *c)
{
    for (uint16_t i = 0; i < c->device.object_count; i++) {
        bool first = true;
        for (uint16_t k = 0; k < i; k++)
            first &= c->entries[k] != c->entries[i];
        if (first)
            free(c->entries[i]);
    }
    free(c->objects);
    free(c->entries);
    free(c->details);
    free(c->pdos);
    free(c->dc_modes);
    free(c);
}

ect_object_t *copy_object(copy_t *c, uint16_t index)
{
    for (uint16_t i = 0; i < c->device.object_count; i++) {
        if (c->objects[i].index == index)
            return &c->objects[i];
    }
    abort();
}

ect_entry_t *copy_entry(copy_t *c, uint16_t index, uint8_t subindex)
{
    const ect_object_t *object = copy_object(c, index);
    ect_entry_t *entries = c->entries[object - c->objects];
    for (unsigned int i = 0; i <= object->last; i++) {
        if (entries[i].subindex == subindex)
            return &entries[i];
    }
    abort();
}

int copy_detail(copy_t *c, uint16_t index, uint8_t subindex)
{
    c->details[c->device.detail_count++] = (ect_detail_t){.index = index, .subindex = subindex};
    return 0;
}

int copy_pdo(copy_t *c, uint16_t index, uint16_t flags, uint16_t exclude)
{
    c->excludes[0] = exclude;
    c->device.pdos = c->pdos;
    c->pdos[c->device.pdo_count++] = (ect_pdo_t){.index = index, .flags = flags, .excludes = c->excludes};
    return 0;
}
