/* SPDX-License-Identifier: MIT */
/* SOES's headers declare the list as constant, so this file defines it without these headers. */
#include "on_soes/objects.h"

enum { OBJECTS = 128, ENTRIES = 1024 };

ect_object_t SDOobjects[OBJECTS + 1];
static ect_entry_t entries[ENTRIES];
static uint32_t commands; /* memory for values written to commands */

/* Declares byte strings of up to 64 bits as numbers, because SOES transfers process data of this length as numbers, and
 * asserts their types. */
static uint16_t mappable_type(const ect_entry_t *entry)
{
    bool mapped = (entry->access & (ECT_ACCESS_RXPDO | ECT_ACCESS_TXPDO)) != 0;
    if (!mapped || (entry->data_type != ECT_TYPE_OCTET_STRING && entry->data_type != ECT_TYPE_VISIBLE_STRING))
        return entry->data_type;
    switch (entry->bit_length) {
    case 8:
        return ECT_TYPE_UNSIGNED8;
    case 16:
        return ECT_TYPE_UNSIGNED16;
    case 32:
        return ECT_TYPE_UNSIGNED32;
    case 64:
        return ECT_TYPE_UNSIGNED64;
    default:
        return entry->data_type;
    }
}

static ect_entry_t converted(const ect_od_t *od, const ect_entry_t *from)
{
    ect_entry_t entry = *from;
    entry.data_type = mappable_type(from);
    entry.bit_length = ect_od_bits(od, from);
    entry.access = from->access & ECT_ACCESS_WIRE;
    entry.data = (from->access & ECT_ACCESS_COMMAND) != 0 ? &commands : ect_od_data(od, from);
    return entry;
}

/* @return the number of entries; 0: no room */
static size_t convert_entries(const ect_od_t *od, const ect_object_t *object, size_t used)
{
    size_t count = 0;
    for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
        if (used + count == ENTRIES)
            return 0;
        entries[used + count++] = converted(od, e);
    }
    return count;
}

bool objects_make(const ect_device_t *device, void *instance)
{
    const ect_od_t od = ect_device_od(device, instance);
    size_t used = 0;
    if (od.count > OBJECTS)
        return false;
    for (uint16_t i = 0; i < od.count; i++) {
        const ect_object_t *object = &od.objects[i];
        bool alike = i > 0 && object->entries == object[-1].entries; /* as the mappings of many samples */
        SDOobjects[i] = *object;
        SDOobjects[i].last = 0;
        SDOobjects[i].entries = alike ? SDOobjects[i - 1].entries : &entries[used];
        size_t count = alike ? 0 : convert_entries(&od, object, used);
        if (!alike && count == 0)
            return false;
        used += count;
    }
    SDOobjects[od.count].index = 0xFFFF;
    return true;
}
