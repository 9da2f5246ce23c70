/* SPDX-License-Identifier: MIT */
#include "esi/values.h"

#include <stdio.h>
#include <string.h>

#include "esi/types.h"
#include "seams/standard.h"
#include "wire/assert.h"

enum { FIRST_ITEM = 16 /* bits of sub-index 0 and its padding */ };

ect_od_t ect_esi_values(ect_arena_t *arena, const ect_device_t *device, const ect_identity_t *identity)
{
    if (device->addresses)
        return ect_device_od(device, NULL);
    size_t size = device->instance_size > sizeof(ect_standard_t) ? device->instance_size : sizeof(ect_standard_t);
    ect_standard_t *standard = ect_arena_alloc(arena, size);
    ect_od_t od = ect_device_od(device, standard);
    ect_od_set_defaults(&od);
    standard->device = device;
    standard->identity = identity != NULL ? *identity : device->identity;
    return od;
}

const uint8_t *ect_esi_entry_value(ect_arena_t *arena, const ect_od_t *od, const ect_entry_t *entry, size_t *size)
{
    uint8_t *bytes = ect_arena_alloc(arena, (size_t)ect_od_bytes(entry) + 1);
    *size = ect_od_is_string(entry) ? ect_od_upload_size(od, entry) : ect_od_bytes(entry);
    ECT_ASSERT(*size <= ect_od_bytes(entry));
    ect_od_read(od, entry, 0, bytes, (uint16_t)*size);
    return bytes;
}

bool ect_esi_has_default(const ect_entry_t *entry, const uint8_t *value, size_t size)
{
    if (size > 0 && (entry->access & (ECT_ACCESS_TXPDO | ECT_ACCESS_RXPDO)) == 0)
        return true;
    for (size_t i = 0; i < size; i++) {
        if (value[i] != 0)
            return true;
    }
    return false;
}

bool ect_esi_is_array(const ect_object_t *object)
{
    const ect_entry_t *first = ect_od_entry(object, 1);
    unsigned int expected = 1;
    if (object->object_code != ECT_OBJECT_ARRAY || first == NULL)
        return false;
    for (const ect_entry_t *e = first; e != NULL; e = ect_od_next(object, e)) {
        if (e->subindex != expected++ || e->data_type != first->data_type || e->bit_length != first->bit_length ||
            (e->access & ECT_ACCESS_WIRE) != (first->access & ECT_ACCESS_WIRE))
            return false;
    }
    return true;
}

static bool is_unique(const ect_object_t *object, const ect_entry_t *entry)
{
    if (strncmp(entry->name, "SubIndex ", 9) == 0) // reserved for generated names
        return false;
    for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e)) {
        if (e != entry && e->name != NULL && strcmp(e->name, entry->name) == 0)
            return false;
    }
    return true;
}

ect_item_name_t ect_esi_item_name(const ect_object_t *object, const ect_entry_t *entry)
{
    ect_item_name_t result = {.name = entry->name != NULL ? entry->name : ""};
    if (entry->subindex == 0 || *result.name == '\0' || ect_esi_is_array(object) || !is_unique(object, entry))
        (void)snprintf(result.unique, sizeof result.unique, "SubIndex %03u", (unsigned int)(uint8_t)entry->subindex);
    return result;
}

uint32_t ect_esi_item_offset(const ect_object_t *object, const ect_entry_t *entry)
{
    uint32_t at = 0;
    for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e)) {
        if (!ect_od_is_bits(e))
            at = (at + 7) / 8 * 8;
        if (e == entry)
            break;
        at += e->subindex == 0 ? (uint32_t)FIRST_ITEM : e->bit_length;
    }
    return at;
}

uint32_t ect_esi_object_bits(const ect_od_t *od, const ect_object_t *object)
{
    const ect_entry_t *last = object->entries;
    ECT_ASSERT(last != NULL);
    for (const ect_entry_t *e = last; e != NULL; e = ect_od_next(object, e))
        last = e;
    return last->subindex == 0 && object->object_code != ECT_OBJECT_VAR
               ? (uint32_t)FIRST_ITEM
               : ect_esi_item_offset(object, last) + ect_od_bits(od, last);
}

const char *ect_esi_type_of(ect_arena_t *arena, uint16_t data_type, uint32_t bits)
{
    char text[sizeof "ARRAY [0..536870911] OF BYTE"];
    if (bits == 0 || (bits > 8 && bits % 8 != 0))
        return bits == 0 ? "OCTET_STRING(0)" : NULL;
    const char *name = ect_esi_type_name(data_type, bits, text, sizeof text);
    return ect_arena_copy(arena, name, strlen(name));
}

const char *ect_esi_access(uint16_t access)
{
    bool readable = (access & ECT_ACCESS_RO) != 0;
    bool writable = (access & ECT_ACCESS_WO) != 0;
    if (!readable)
        return writable ? "wo" : "";
    return writable ? "rw" : "ro";
}

const char *ect_esi_states(bool preop, bool safeop, bool op)
{
    static const char *const names[] = {"", "PreOP", "SafeOP", "PreOP_SafeOP", "OP", "PreOP_OP", "SafeOP_OP", ""};
    return names[(preop ? 1 : 0) | (safeop ? 2 : 0) | (op ? 4 : 0)];
}
