/* SPDX-License-Identifier: MIT */
/* Checks of objects and entries, on which the functions of the dictionary rely. */
#include <stdarg.h>
#include <stdio.h>

#include "check/internal.h"
#include "seams/standard.h"

enum { KNOWN_ACCESS = ECT_ACCESS_WIRE | ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION | ECT_ACCESS_COMMAND };

/* Bit lengths of types; 0: any number of whole bytes. */
static const struct {
    uint16_t type;
    uint8_t bits;
    bool is_integer, is_signed;
} types[] = {
    {ECT_TYPE_BOOLEAN, 1, true, false},
    {ECT_TYPE_INTEGER8, 8, true, true},
    {ECT_TYPE_INTEGER16, 16, true, true},
    {ECT_TYPE_INTEGER32, 32, true, true},
    {ECT_TYPE_INTEGER64, 64, true, true},
    {ECT_TYPE_UNSIGNED8, 8, true, false},
    {ECT_TYPE_UNSIGNED16, 16, true, false},
    {ECT_TYPE_UNSIGNED32, 32, true, false},
    {ECT_TYPE_UNSIGNED64, 64, true, false},
    {ECT_TYPE_REAL32, 32, false, false},
    {ECT_TYPE_REAL64, 64, false, false},
    {ECT_TYPE_BITARR8, 8, true, false},
    {ECT_TYPE_BITARR16, 16, true, false},
    {ECT_TYPE_BITARR32, 32, true, false},
    {ECT_TYPE_BIT1, 1, true, false},
    {ECT_TYPE_BIT1 + 1, 2, true, false},
    {ECT_TYPE_BIT1 + 2, 3, true, false},
    {ECT_TYPE_BIT1 + 3, 4, true, false},
    {ECT_TYPE_BIT1 + 4, 5, true, false},
    {ECT_TYPE_BIT1 + 5, 6, true, false},
    {ECT_TYPE_BIT1 + 6, 7, true, false},
    {ECT_TYPE_BIT8, 8, true, false},
    {ECT_TYPE_VISIBLE_STRING, 0, false, false},
    {ECT_TYPE_OCTET_STRING, 0, false, false},
};
enum { TYPES = sizeof types / sizeof types[0] };

static size_t find_type(uint16_t type)
{
    size_t i = 0;
    while (i < TYPES && types[i].type != type)
        i++;
    return i;
}

bool is_integer_type(uint16_t type)
{
    size_t i = find_type(type);
    return i < TYPES && types[i].is_integer;
}

bool is_signed_type(uint16_t type)
{
    size_t i = find_type(type);
    return i < TYPES && types[i].is_signed;
}

size_t storage_of(const ect_entry_t *entry)
{
    return ect_od_is_bits(entry) ? 1 : ect_od_bytes(entry);
}

typedef struct place {
    const report_t *r;
    const ect_object_t *object;
    const ect_entry_t *entry;
} place_t;

__attribute__((format(printf, 2, 3))) static bool wrong_at(const place_t *p, const char *format, ...)
{
    char line[ECT_CHECK_TEXT];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    return wrong(p->r, "%04Xh:%u: %s", p->object->index, p->entry->subindex, line);
}

static bool length_good(const place_t *p, unsigned int bits)
{
    const ect_entry_t *e = p->entry;
    if (bits != 0)
        return bits == e->bit_length
                   ? true
                   : wrong_at(p, "its data type %04Xh has %u bits, not %u", e->data_type, bits, e->bit_length);
    if (e->bit_length % 8 != 0)
        return wrong_at(p, "%u bits are not whole bytes", e->bit_length);
    if (e->bit_length == 0 && (e->data || !p->r->device->sdo_read))
        return wrong_at(p, "only an entry without memory whose data sdo_read supplies has no length");
    return true;
}

static bool type_good(const place_t *p)
{
    size_t i = find_type(p->entry->data_type);
    if (p->entry->data_type == ECT_TYPE_NONE && !p->entry->data)
        return true; /* a gap in a record */
    if (i == TYPES)
        return wrong_at(p, "its data type %04Xh is none that an entry can have", p->entry->data_type);
    return length_good(p, types[i].bits);
}

/* @return whether the offset is that of a text in the description */
static bool is_text_member(size_t offset)
{
    static const uint16_t members[] = {offsetof(ect_device_t, name),
                                       offsetof(ect_device_t, summary),
                                       offsetof(ect_device_t, vendor_name),
                                       offsetof(ect_device_t, type_name),
                                       offsetof(ect_device_t, full_name),
                                       offsetof(ect_device_t, group_type),
                                       offsetof(ect_device_t, group_name),
                                       offsetof(ect_device_t, hardware_version),
                                       offsetof(ect_device_t, software_version)};
    for (size_t i = 0; i < sizeof members / sizeof members[0]; i++) {
        if (members[i] == offset)
            return true;
    }
    return false;
}

static bool described_good(const place_t *p)
{
    const ect_entry_t *e = p->entry;
    size_t offset = (uintptr_t)e->data;
    if (!e->data ||
        (ect_od_is_string(e) ? !is_text_member(offset)
                             : offset + storage_of(e) > sizeof(ect_device_t) || offset > sizeof(ect_device_t)))
        return wrong_at(p, "it is no member of the description");
    const void *text = ect_od_is_string(e) ? ect_od_data(&p->r->od, e) : "";
    return text ? true : wrong_at(p, "the description has no such text");
}

/* Checks that an entry is inside the instance, and not in the stack's part at the beginning. */
static bool offset_good(const place_t *p)
{
    const ect_entry_t *e = p->entry;
    size_t offset = (uintptr_t)e->data;
    bool writable = (e->access & (ECT_ACCESS_WO | ECT_ACCESS_RXPDO)) != 0;
    size_t first = writable ? sizeof(ect_standard_t) : offsetof(ect_standard_t, identity);
    if (offset < first)
        return wrong_at(p, "it lies in what belongs to the stack, ect_standard_t");
    if (offset > p->r->device->instance_size || storage_of(e) > p->r->device->instance_size - offset)
        return wrong_at(p, "it ends at byte %zu, beyond the instance of %zu", offset + storage_of(e),
                        p->r->device->instance_size);
    return true;
}

static bool place_good(const place_t *p)
{
    const ect_entry_t *e = p->entry;
    bool constant = (e->access & (ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION)) != 0;
    if ((e->access & ECT_ACCESS_DESCRIPTION) != 0)
        return described_good(p);
    if (!e->data || constant || p->r->device->addresses)
        return true;
    return offset_good(p);
}

/* Checks that a writable value has memory. */
static bool memory_good(const place_t *p)
{
    const ect_entry_t *e = p->entry;
    bool constant = !e->data || (e->access & (ECT_ACCESS_SHARED | ECT_ACCESS_DESCRIPTION)) != 0;
    bool writable = (e->access & ECT_ACCESS_WO) != 0;
    bool command = (e->access & ECT_ACCESS_COMMAND) != 0;
    if (writable && constant && !command)
        return wrong_at(p, "it can be written, but has no memory and is no command");
    if (command && !writable)
        return wrong_at(p, "a command has to be writable");
    return (e->access & ECT_ACCESS_BACKUP) == 0 || !constant ? true : wrong_at(p, "a stored value has to be in memory");
}

static bool access_good(const place_t *p)
{
    unsigned int access = p->entry->access;
    if ((access & ~(unsigned int)KNOWN_ACCESS) != 0)
        return wrong_at(p, "there is no access %04Xh", access & ~(unsigned int)KNOWN_ACCESS);
    if ((access & ECT_ACCESS_SHARED) != 0 && (access & ECT_ACCESS_DESCRIPTION) != 0)
        return wrong_at(p, "it is either shared or of the description");
    return memory_good(p);
}

/* Checks the value of an entry: constant without memory, initial with memory. */
static bool value_good(const place_t *p)
{
    const ect_entry_t *e = p->entry;
    unsigned int bits = e->bit_length;
    if (bits >= 32)
        return true;
    bool fits = e->value >> bits == 0;
    bool negative = is_signed_type(e->data_type) && e->value >> (bits - 1) == UINT32_MAX >> (bits - 1);
    return fits || negative ? true : wrong_at(p, "its default %Xh does not fit into %u bits", e->value, bits);
}

static bool entry_good(const place_t *p)
{
    if (!p->entry->name)
        return wrong_at(p, "it has no name");
    return type_good(p) && access_good(p) && place_good(p) && value_good(p);
}

/* @return the sub-index of the last entry; in a list of SOES, that of the entry at this position */
static unsigned int highest(const ect_object_t *o)
{
    return o->last != 0 ? o->max_subindex : ect_od_last(o)->subindex;
}

/* Checks sub-index 0: the number of elements, or, if writable, at most this number. A sparse record of SOES may have
 * either the highest sub-index or the number of elements. */
static bool count_good(const place_t *p)
{
    const ect_entry_t *e = p->entry;
    uint32_t count = (e->access & ECT_ACCESS_DESCRIPTION) != 0 ? p->object->max_subindex : e->value;
    bool list = p->object->index >= 0x1600 && p->object->index < 0x1C40;
    if (e->subindex != 0 || e->data_type != ECT_TYPE_UNSIGNED8)
        return wrong(p->r, "%04Xh: a record or array begins with sub-index 0, UNSIGNED8", p->object->index);
    if (count > highest(p->object) || (count < p->object->max_subindex && !list && !e->data))
        return wrong_at(p, "it has %u elements, but the last is %u", count, highest(p->object));
    return true;
}

static bool is_object_code(uint16_t code)
{
    return code == ECT_OBJECT_VAR || code == ECT_OBJECT_ARRAY || code == ECT_OBJECT_RECORD || code == ECT_OBJECT_DOMAIN;
}

static bool is_list(const ect_object_t *o)
{
    return o->object_code == ECT_OBJECT_ARRAY || o->object_code == ECT_OBJECT_RECORD;
}

/* Checks that a variable is a single value, and that the entries of a list are counted. */
static bool shape_good(const report_t *r, const ect_object_t *o)
{
    bool several = o->max_subindex != 0 || o->last != 0;
    if (!is_list(o) && (several || o->entries->subindex != 0))
        return wrong(r, "%04Xh: a %s has one entry, sub-index 0", o->index,
                     o->object_code == ECT_OBJECT_VAR ? "VAR" : "DOMAIN");
    if (several && o->last == 0 && !r->device->addresses)
        return wrong(r, "%04Xh: its entries are not counted; ECT_RECORD, ECT_ARRAY and ECT_SPARSE do", o->index);
    return true;
}

static bool object_head_good(const report_t *r, const ect_object_t *o)
{
    if (!is_object_code(o->object_code))
        return wrong(r, "%04Xh: there is no object code %u", o->index, o->object_code);
    if (!o->name)
        return wrong(r, "%04Xh: it has no name", o->index);
    if (!o->entries)
        return wrong(r, "%04Xh: it has no entries", o->index);
    return shape_good(r, o);
}

/* Checks each entry, and the ascending order. `p` is at the last entry afterwards. */
static bool entries_good(place_t *p)
{
    const ect_object_t *o = p->object;
    for (;;) {
        const ect_entry_t *next = p->entry->subindex < highest(o) ? ect_od_next(o, p->entry) : NULL;
        if (!entry_good(p))
            return false;
        if (!next)
            return true;
        if (next->subindex <= p->entry->subindex || next->subindex > highest(o))
            return wrong(p->r, "%04Xh: its entries are not in ascending order, or not up to %u: %u comes after %u",
                         o->index, highest(o), next->subindex, p->entry->subindex);
        p->entry = next;
    }
}

static bool object_good(const report_t *r, const ect_object_t *o)
{
    place_t p = {.r = r, .object = o, .entry = o->entries};
    if (!object_head_good(r, o))
        return false;
    if ((is_list(o) && !count_good(&p)) || !entries_good(&p))
        return false;
    if (p.entry->subindex != highest(o) || p.entry != ect_od_last(o))
        return wrong(r, "%04Xh: its last sub-index is %u, max_subindex is %u", o->index, p.entry->subindex, highest(o));
    return true;
}

bool check_objects(const report_t *r)
{
    const ect_device_t *d = r->device;
    if (d->instance_size < sizeof(ect_standard_t))
        return wrong(r, "instance_size: an instance begins with ect_standard_t, %zu bytes", sizeof(ect_standard_t));
    if (d->object_count > 0 && !d->objects)
        return wrong(r, "objects: they are missing");
    for (unsigned int i = 0; i < d->object_count; i++) {
        if (i > 0 && d->objects[i].index <= d->objects[i - 1].index)
            return wrong(r, "%04Xh: objects are in ascending order, each once, but it comes after %04Xh",
                         d->objects[i].index, d->objects[i - 1].index);
        if (!object_good(r, &d->objects[i]))
            return false;
    }
    return true;
}
