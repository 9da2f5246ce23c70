/* SPDX-License-Identifier: MIT */
/* Checks of details: units, limits and long defaults; and of short defaults against the limits. */
#include <inttypes.h>
#include <string.h>

#include "check/internal.h"
#include "wire/assert.h"

static bool order_good(const report_t *r, unsigned int i)
{
    const ect_detail_t *d = r->device->details;
    uint32_t key = (uint32_t)d[i].index << 8 | d[i].subindex;
    uint32_t before = i > 0 ? (uint32_t)d[i - 1].index << 8 | d[i - 1].subindex : 0;
    if (i > 0 && key <= before)
        return wrong(r, "details: they are in ascending order, each once, but %04Xh:%u comes after %04Xh:%u",
                     d[i].index, d[i].subindex, d[i - 1].index, d[i - 1].subindex);
    return true;
}

static int64_t lowest_of(const ect_entry_t *entry)
{
    ECT_ASSERT(entry->bit_length > 0 && entry->bit_length <= 64); /* check_objects, of an integer */
    return is_signed_type(entry->data_type) ? INT64_MIN >> (64 - entry->bit_length) : 0;
}

static int64_t highest_of(const ect_entry_t *entry)
{
    unsigned int bits = entry->bit_length - (is_signed_type(entry->data_type) ? 1u : 0u);
    return bits >= 63 ? INT64_MAX : ((int64_t)1 << bits) - 1;
}

/* @return the default of an integer, extended to 64 bits */
static int64_t default_of(const ect_entry_t *entry, const ect_detail_t *detail)
{
    unsigned int bits = entry->bit_length;
    uint64_t value = entry->value;
    ECT_ASSERT(bits > 0 && bits <= 64);
    if (detail->initial && bits == 64)
        memcpy(&value, detail->initial, sizeof value);
    bool negative = is_signed_type(entry->data_type) && bits < 64 && (value >> (bits - 1) & 1u) != 0;
    return (int64_t)(negative ? value | UINT64_MAX << bits : value);
}

static bool default_good(const report_t *r, const ect_detail_t *d, const ect_entry_t *e)
{
    int64_t initial = default_of(e, d);
    if ((e->access & ECT_ACCESS_RO) == 0 || (e->access & ECT_ACCESS_COMMAND) != 0)
        return true;
    if (initial < d->minimum)
        return wrong(r, "%04Xh:%u: its default %" PRId64 " is below its minimum %" PRId64, d->index, d->subindex,
                     initial, d->minimum);
    if (initial > d->maximum)
        return wrong(r, "%04Xh:%u: its default %" PRId64 " is above its maximum %" PRId64, d->index, d->subindex,
                     initial, d->maximum);
    return true;
}

static bool limits_good(const report_t *r, const ect_detail_t *d, const ect_entry_t *e)
{
    if (d->minimum == d->maximum)
        return true;
    if (!is_integer_type(e->data_type))
        return wrong(r, "%04Xh:%u: only integers have limits", d->index, d->subindex);
    if (d->minimum > d->maximum)
        return wrong(r, "%04Xh:%u: its minimum %" PRId64 " is above its maximum %" PRId64, d->index, d->subindex,
                     d->minimum, d->maximum);
    if (d->minimum < lowest_of(e) || d->maximum > highest_of(e))
        return wrong(r, "%04Xh:%u: its limits %" PRId64 " to %" PRId64 " are beyond its type", d->index, d->subindex,
                     d->minimum, d->maximum);
    return default_good(r, d, e);
}

static bool initial_good(const report_t *r, const ect_detail_t *d, const ect_entry_t *e)
{
    if (!d->initial)
        return true;
    if (e->bit_length <= 32 && !ect_od_is_string(e) && e->data_type != ECT_TYPE_OCTET_STRING)
        return wrong(r, "%04Xh:%u: a default of up to 32 bits is in its entry", d->index, d->subindex);
    if (e->value != 0)
        return wrong(r, "%04Xh:%u: it has two defaults", d->index, d->subindex);
    return true;
}

bool check_details(const report_t *r)
{
    const ect_device_t *device = r->device;
    if (device->detail_count > 0 && !device->details)
        return wrong(r, "details: they are missing");
    for (unsigned int i = 0; i < device->detail_count; i++) {
        const ect_detail_t *d = &device->details[i];
        const ect_object_t *object = NULL;
        const ect_entry_t *entry = NULL;
        if (!order_good(r, i))
            return false;
        if (ect_od_lookup(&r->od, d->index, d->subindex, &object, &entry) != ECT_OK)
            return wrong(r, "details: there is no %04Xh:%u", d->index, d->subindex);
        if (!limits_good(r, d, entry) || !initial_good(r, d, entry))
            return false;
    }
    return true;
}
