/* SPDX-License-Identifier: MIT */
#include "od/od.h"

#include <string.h>

#include "wire/assert.h"
#include "wire/bytes.h"

/* An abort code is 0x0h0l00cc: three numbers that fit 16 bits. */
#define PACK(code)      ((uint16_t)(((code) >> 12 & 0xF000u) | ((code) >> 8 & 0x0F00u) | ((code) & 0xFFu)))
#define ROW(name, code) [ECT_REASON_##name] = PACK(code),

static const uint16_t abort_codes[ECT_REASON_COUNT] = {ECT_REASONS(ROW)};

uint32_t ect_abort_code(ect_reason_t reason)
{
    if (reason > UINT16_MAX)
        return reason;
    uint32_t code = abort_codes[reason - 1u < ECT_REASON_COUNT - 1u ? reason : ECT_REASON_GENERAL];
    return ((code & 0xF000u) << 12) | ((code & 0x0F00u) << 8) | (code & 0xFFu);
}

const ect_object_t *ect_od_find(const ect_od_t *od, uint16_t index)
{
    ECT_ASSERT(od->objects || od->count == 0);
    uint16_t low = 0;
    uint16_t high = od->count;
    while (low < high) {
        uint16_t middle = (uint16_t)(low + (high - low) / 2);
        const ect_object_t *object = &od->objects[middle];
        if (object->index == index)
            return object;
        if (object->index < index)
            low = (uint16_t)(middle + 1);
        else
            high = middle;
    }
    return NULL;
}

const ect_entry_t *ect_od_entry(const ect_object_t *object, uint8_t subindex)
{
    const ect_entry_t *entry = object->entries;
    ECT_ASSERT(entry != NULL);
    while (entry && entry->subindex < subindex)
        entry = ect_od_next(object, entry);
    return entry && entry->subindex == subindex ? entry : NULL;
}

ect_reason_t ect_od_lookup(const ect_od_t *od, uint16_t index, uint8_t subindex, const ect_object_t **object,
                           const ect_entry_t **entry)
{
    *object = ect_od_find(od, index);
    *entry = *object ? ect_od_entry(*object, subindex) : NULL;
    if (*entry)
        return ECT_OK;
    return *object ? ECT_REASON_NO_SUBINDEX : ECT_REASON_NO_OBJECT;
}

ect_reason_t ect_od_check_access(const ect_entry_t *entry, ect_direction_t direction, uint8_t al_state)
{
    enum { WITH_DICTIONARY = 1 << 2 | 1 << 4 | 1 << 8 }; /* PREOP, SAFEOP, OP; each has the next right */
    unsigned int in_state = (WITH_DICTIONARY >> al_state & 1) != 0 ? al_state / 2u * ECT_ACCESS_R_PREOP : 0u;
    unsigned int granted = entry->access & ECT_ACCESS_RO;
    ect_reason_t never = ECT_REASON_WRITE_ONLY;
    if (direction == ECT_DOWNLOAD) {
        granted = (unsigned int)(entry->access & ECT_ACCESS_WO) >> 3;
        never = ECT_REASON_READ_ONLY;
    }
    if (granted == 0)
        return never;
    return (granted & in_state) != 0 ? ECT_OK : ECT_REASON_STATE;
}

bool ect_od_is_bits(const ect_entry_t *entry)
{
    return entry->data_type == ECT_TYPE_BOOLEAN ||
           (entry->data_type >= ECT_TYPE_BIT1 && entry->data_type <= ECT_TYPE_BIT8);
}

/* Sets of data types below 32, one bit each. */
#define TYPE(name) (UINT32_C(1) << ECT_TYPE_##name)
#define SIGNED     (TYPE(INTEGER8) | TYPE(INTEGER16) | TYPE(INTEGER32) | TYPE(INTEGER64))
#define UNSIGNED   (TYPE(BOOLEAN) | TYPE(UNSIGNED8) | TYPE(UNSIGNED16) | TYPE(UNSIGNED32) | TYPE(UNSIGNED64))
#define NUMBERS    ((SIGNED | UNSIGNED | TYPE(REAL32) | TYPE(REAL64)) & ~TYPE(BOOLEAN))

/* Bytes of a number that the host stores in its own byte order; 0 for every other type, which is stored as bytes. */
static uint16_t number_width(const ect_entry_t *entry)
{
    uint16_t type = entry->data_type;
    bool number = type < 32 ? (NUMBERS >> type & 1) != 0 : type >= ECT_TYPE_BITARR8 && type <= ECT_TYPE_BITARR32;
    return number ? ect_od_bytes(entry) : 0;
}

static bool is_constant(const ect_entry_t *entry)
{
    return (entry->access & (ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION)) != 0;
}

void *ect_od_data(const ect_od_t *od, const ect_entry_t *entry)
{
    if (!entry->data)
        return NULL;
    if ((entry->access & ECT_ACCESS_DESCRIPTION) != 0) {
        const uint8_t *member = (const uint8_t *)od->description + (uintptr_t)entry->data;
        return ect_od_is_string(entry) ? *(void *const *)(const void *)member : (void *)(uintptr_t)member;
    }
    if (!od->base || (entry->access & ECT_ACCESS_SHARED) != 0)
        return entry->data;
    return (uint8_t *)od->base + (uintptr_t)entry->data;
}

uint16_t ect_od_upload_size(const ect_od_t *od, const ect_entry_t *entry)
{
    uint16_t room = ect_od_bytes(entry);
    const char *text = ect_od_data(od, entry);
    if (!ect_od_is_string(entry) || !text)
        return room;
    const char *end = memchr(text, 0, room);
    return end ? (uint16_t)(end - text) : room;
}

uint16_t ect_od_bits(const ect_od_t *od, const ect_entry_t *entry)
{
    bool described = ect_od_is_string(entry) && (entry->access & ECT_ACCESS_DESCRIPTION) != 0;
    return described ? (uint16_t)(8u * ect_od_upload_size(od, entry)) : entry->bit_length;
}

/* Converts a number between the byte orders of host and wire, in either direction. */
static void copy_number(uint8_t *to, const uint8_t *from, uint16_t width)
{
    bool as_it_is = ect_host_is_little_endian();
    for (uint16_t i = 0; i < width; i++)
        to[i] = from[as_it_is ? i : width - 1 - i];
}

void ect_od_read(const ect_od_t *od, const ect_entry_t *entry, uint16_t offset, void *buffer, uint16_t length)
{
    ECT_ASSERT((uint32_t)offset + length <= ect_od_bytes(entry));
    const uint8_t *data = ect_od_data(od, entry);
    uint16_t width = number_width(entry);
    uint8_t wire[8] = {0};
    const uint8_t *source = data;
    if (!data) {
        /* The bytes beyond `value` read as zero. */
        memset(buffer, 0, length);
        ect_store_le32(wire, entry->value);
        if (offset >= sizeof wire)
            return;
        length = (uint16_t)(length > sizeof wire - offset ? sizeof wire - offset : length);
        source = wire;
    } else if (width > 0) {
        copy_number(wire, data, width);
        source = wire;
    }
    memcpy(buffer, source + offset, length);
    if (ect_od_is_bits(entry) && length > 0)
        *(uint8_t *)buffer &= (uint8_t)((1u << entry->bit_length) - 1u);
}

ect_reason_t ect_od_write(const ect_od_t *od, const ect_entry_t *entry, uint16_t offset, const void *buffer,
                          uint16_t length)
{
    uint16_t room = ect_od_bytes(entry);
    ECT_ASSERT((uint32_t)offset + length <= room);
    uint8_t *data = ect_od_data(od, entry);
    if (!data || is_constant(entry))
        return ECT_REASON_READ_ONLY;
    uint16_t width = number_width(entry);
    if (width > 0) {
        ECT_ASSERT(offset == 0 && length == width);
        copy_number(data, buffer, width);
        return ECT_OK;
    }
    memcpy(data + offset, buffer, length);
    if (ect_od_is_bits(entry) && length > 0)
        data[0] &= (uint8_t)((1u << entry->bit_length) - 1u);
    if (ect_od_is_string(entry) && offset + length < room)
        data[offset + length] = 0;
    return ECT_OK;
}

static void set_default(const ect_od_t *od, uint16_t index, const ect_entry_t *entry)
{
    const ect_detail_t *detail = ect_od_detail(od, index, (uint8_t)entry->subindex);
    uint16_t size = ect_od_bytes(entry);
    uint8_t wire[8] = {0};
    const void *initial = detail ? detail->initial : NULL;
    if (initial && ect_od_is_string(entry)) {
        const void *end = memchr(initial, 0, size);
        size = end ? (uint16_t)((const char *)end - (const char *)initial) : size;
    } else if (!initial) {
        if (entry->value == 0 || size > sizeof wire)
            return;
        ect_store_le32(wire, entry->value);
        initial = wire;
    }
    (void)ect_od_write(od, entry, 0, initial, size);
}

void ect_od_set_defaults(const ect_od_t *od)
{
    for (uint16_t i = 0; i < od->count; i++) {
        const ect_object_t *object = &od->objects[i];
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
            if (e->data && !is_constant(e))
                set_default(od, object->index, e);
        }
    }
}

const ect_detail_t *ect_od_detail(const ect_od_t *od, uint16_t index, uint8_t subindex)
{
    uint32_t key = ((uint32_t)index << 8) | subindex;
    uint16_t low = 0;
    uint16_t high = od->details ? od->detail_count : 0;
    while (low < high) {
        uint16_t middle = (uint16_t)(low + (high - low) / 2);
        const ect_detail_t *detail = &od->details[middle];
        uint32_t here = ((uint32_t)detail->index << 8) | detail->subindex;
        if (here == key)
            return detail;
        if (here < key)
            low = (uint16_t)(middle + 1);
        else
            high = middle;
    }
    return NULL;
}

static bool is_signed(uint16_t data_type)
{
    return data_type < 32 && (SIGNED >> data_type & 1) != 0;
}

static bool is_integer(uint16_t data_type)
{
    return data_type < 32 ? ((SIGNED | UNSIGNED) >> data_type & 1) != 0
                          : data_type >= ECT_TYPE_BITARR8 && data_type <= ECT_TYPE_BIT8;
}

ect_reason_t ect_od_check_limit(const ect_od_t *od, uint16_t index, const ect_entry_t *entry, const void *bytes)
{
    const ect_detail_t *limit = ect_od_detail(od, index, (uint8_t)entry->subindex);
    uint16_t size = ect_od_bytes(entry);
    bool with_sign = is_signed(entry->data_type);
    if (!limit || limit->minimum == limit->maximum || !is_integer(entry->data_type))
        return ECT_OK;
    uint8_t wire[8] = {0};
    memcpy(wire, bytes, size);
    if (with_sign && (wire[size - 1] & 0x80) != 0)
        memset(wire + size, 0xFF, sizeof wire - size);
    int64_t value = (int64_t)ect_load_le64(wire);
    if (value > limit->maximum || (value < 0 && !with_sign)) /* an unsigned value above INT64_MAX */
        return ECT_REASON_TOO_HIGH;
    return value < limit->minimum ? ECT_REASON_TOO_LOW : ECT_OK;
}

ect_reason_t ect_od_number(const ect_od_t *od, uint16_t index, uint8_t subindex, uint32_t *value)
{
    const ect_object_t *object;
    const ect_entry_t *entry;
    ect_reason_t reason = ect_od_lookup(od, index, subindex, &object, &entry);
    if (reason != ECT_OK)
        return reason;
    uint8_t wire[4] = {0};
    uint16_t size = ect_od_bytes(entry);
    ect_od_read(od, entry, 0, wire, size < sizeof wire ? size : (uint16_t)sizeof wire);
    *value = ect_load_le32(wire);
    return ECT_OK;
}
