/* SPDX-License-Identifier: MIT */
/*
 * SDO information of a clone whose slave describes entries in another way than their use requires: a mapped entry not
 * marked as mappable, a text without a length. The stack then describes a second table of objects.
 */
#include <string.h>

#include "esi/internal.h"
#include "seams/mailbox.h"
#include "slave/slave.h"

typedef struct reported {
    ect_protocol_t protocol;
    const ect_object_t *objects; /* as described */
} reported_t;

/* Replaces the dictionary during a call, because SDO information only reads it. */
static uint16_t request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    const ect_object_t *own = slave->od.objects;
    slave->od.objects = ((const reported_t *)(const void *)self)->objects;
    const uint16_t error = ect_protocol_sdo_info.request(&ect_protocol_sdo_info, slave, data, length);
    slave->od.objects = own;
    return error;
}

static bool next(const ect_protocol_t *self, ect_slave_t *slave, bool send)
{
    const ect_object_t *own = slave->od.objects;
    slave->od.objects = ((const reported_t *)(const void *)self)->objects;
    const bool more = ect_protocol_sdo_info.next(&ect_protocol_sdo_info, slave, send);
    slave->od.objects = own;
    return more;
}

static void reset(const ect_protocol_t *self, ect_slave_t *slave)
{
    (void)self;
    ect_protocol_sdo_info.reset(&ect_protocol_sdo_info, slave);
}

const ect_object_t *ect_esi_reported(const ect_device_t *device)
{
    for (const ect_protocol_t *const *p = device->protocols; p != NULL && *p != NULL; p++) {
        if ((*p)->request == request)
            return ((const reported_t *)(const void *)*p)->objects;
    }
    return device->objects;
}

/* --- the table ---------------------------------------------------------------------------------------------------- */

static uint16_t access_of(const ect_build_entry_t *entry)
{
    return entry->reported_access.given ? (uint16_t)entry->reported_access.value : entry->access & ECT_ACCESS_WIRE;
}

static uint16_t bits_of(const ect_build_entry_t *entry)
{
    return entry->reported_bits.given ? (uint16_t)entry->reported_bits.value : entry->bits;
}

static bool differs(const ect_build_object_t *object)
{
    for (size_t k = 0; k < object->count; k++) {
        const ect_build_entry_t *entry = &object->entries[k];
        if (access_of(entry) != (entry->access & ECT_ACCESS_WIRE) || bits_of(entry) != entry->bits)
            return true;
    }
    return false;
}

static const ect_entry_t *describe(const ect_build_t *build, const ect_build_object_t *from, const ect_object_t *own)
{
    ect_entry_t *entries = ect_arena_alloc(build->arena, from->count * sizeof *entries);
    memcpy(entries, own->entries, from->count * sizeof *entries);
    for (size_t k = 0; k < from->count; k++) {
        const uint16_t internal = (uint16_t)(entries[k].access & ~(unsigned int)ECT_ACCESS_WIRE);
        entries[k].access = internal | access_of(&from->entries[k]);
        entries[k].bit_length = bits_of(&from->entries[k]);
    }
    return entries;
}

/* @return the place of SDO information among the protocols; NULL: the twin has none */
static const ect_protocol_t **place_of(const ect_device_t *device)
{
    const ect_protocol_t **p = (const ect_protocol_t **)(uintptr_t)device->protocols; /* ours */
    while (p != NULL && *p != NULL && *p != &ect_protocol_sdo_info)
        p++;
    return p != NULL && *p != NULL ? p : NULL;
}

/* Adds an entry before the stack's own: the first entry of a type gets the requests, and the stack's own indicates SDO
 * information. */
static void insert(const ect_protocol_t **place, const ect_protocol_t *protocol)
{
    while (protocol != NULL) {
        const ect_protocol_t *moved = *place;
        *place++ = protocol;
        protocol = moved;
    }
}

void ect_esi_reported_set(const ect_build_t *build, ect_device_t *device)
{
    ect_object_t *objects = NULL;
    const ect_protocol_t **place = place_of(device);
    if (place == NULL || build->rack != NULL) /* clones have no slots */
        return;
    ECT_ASSERT(build->object_count == device->object_count);
    for (size_t i = 0; i < build->object_count; i++) {
        if (!differs(&build->objects[i]))
            continue;
        if (objects == NULL) {
            objects = ect_arena_alloc(build->arena, build->object_count * sizeof *objects);
            memcpy(objects, device->objects, build->object_count * sizeof *objects);
        }
        objects[i].entries = describe(build, &build->objects[i], &device->objects[i]);
    }
    if (objects == NULL)
        return;
    reported_t *reported = ect_arena_alloc(build->arena, sizeof *reported);
    *reported = (reported_t){.protocol = ect_protocol_sdo_info, .objects = objects};
    reported->protocol.request = request;
    reported->protocol.next = next;
    reported->protocol.reset = reset;
    insert(place, &reported->protocol);
}
