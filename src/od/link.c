/* SPDX-License-Identifier: MIT */
#include "od/link.h"

#include <float.h>
#include <string.h>

static bool is_signed(uint16_t type)
{
    return type == ECT_TYPE_INTEGER8 || type == ECT_TYPE_INTEGER16 || type == ECT_TYPE_INTEGER32 ||
           type == ECT_TYPE_INTEGER64;
}

static ect_link_t link_to(const ect_entry_t *entry)
{
    bool real = entry->data_type == ECT_TYPE_REAL32 || entry->data_type == ECT_TYPE_REAL64;
    bool number = !ect_od_is_string(entry) && entry->data_type != ECT_TYPE_OCTET_STRING;
    uint16_t bytes = ect_od_bytes(entry);
    if (!number || entry->data == NULL || (bytes != 1 && bytes != 2 && bytes != 4 && bytes != 8))
        return (ect_link_t){0};
    return (ect_link_t){.offset = (uint32_t)(uintptr_t)entry->data,
                        .bytes = (uint8_t)bytes,
                        .is_signed = is_signed(entry->data_type),
                        .is_real = real,
                        .output = (entry->access & ECT_ACCESS_RXPDO) != 0,
                        .given = entry->value != 0};
}

ect_link_t ect_link_to(const ect_od_t *od, uint16_t index, uint8_t subindex)
{
    const ect_object_t *object;
    const ect_entry_t *entry = NULL;
    (void)ect_od_lookup(od, index, subindex, &object, &entry);
    return entry != NULL ? link_to(entry) : (ect_link_t){0};
}

ect_link_t ect_link_to_element(const ect_od_t *od, uint16_t index, unsigned int number)
{
    const ect_object_t *object = ect_od_find(od, index);
    const bool is_var = object != NULL && object->object_code == ECT_OBJECT_VAR;
    if ((is_var && number > 0) || number >= UINT8_MAX)
        return (ect_link_t){0};
    return ect_link_to(od, index, is_var ? 0 : (uint8_t)(number + 1));
}

static int64_t load_signed(const uint8_t *at, unsigned int bytes)
{
    int8_t i8;
    int16_t i16;
    int32_t i32;
    int64_t i64;
    switch (bytes) {
    case 1:
        memcpy(&i8, at, sizeof i8);
        return i8;
    case 2:
        memcpy(&i16, at, sizeof i16);
        return i16;
    case 4:
        memcpy(&i32, at, sizeof i32);
        return i32;
    default:
        memcpy(&i64, at, sizeof i64);
        return i64;
    }
}

/* Limits a number, because a master may write any value, so that sums stay within 64 bits. */
#define MOST 9007199254740992 /* 2^53 */

static int64_t bounded(int64_t x)
{
    return x > MOST ? MOST : x < -MOST ? -MOST : x;
}

/* Excludes infinities and NaN, whose conversion is undefined. */
static int64_t whole(double x)
{
    if (x >= (double)MOST)
        return MOST;
    if (x <= -(double)MOST)
        return -MOST;
    return x < 0 ? (int64_t)(x - 0.5) : x >= 0 ? (int64_t)(x + 0.5) : 0;
}

static double load_real(const uint8_t *at, unsigned int bytes)
{
    float f;
    double d;
    if (bytes == sizeof f) {
        memcpy(&f, at, sizeof f);
        return (double)f;
    }
    memcpy(&d, at, sizeof d);
    return d;
}

int64_t ect_link_load(const void *instance, const ect_link_t *link)
{
    if (link->bytes == 0)
        return 0;
    const uint8_t *at = (const uint8_t *)instance + link->offset;
    if (link->is_real)
        return whole(load_real(at, link->bytes));
    int64_t value = load_signed(at, link->bytes);
    if (link->is_signed || link->bytes == 8)
        return bounded(value);
    return value & ((INT64_C(1) << 8 * link->bytes) - 1);
}

static int64_t within(const ect_link_t *link, int64_t value)
{
    if (link->bytes == 8)
        return value;
    unsigned int magnitude = 8u * link->bytes - (link->is_signed ? 1u : 0u);
    int64_t highest = (INT64_C(1) << magnitude) - 1;
    int64_t lowest = link->is_signed ? -highest - 1 : 0;
    return value > highest ? highest : value < lowest ? lowest : value;
}

static void store_real(uint8_t *at, unsigned int bytes, double value)
{
    float f;
    if (bytes != sizeof f) {
        memcpy(at, &value, sizeof value);
        return;
    }
    f = value > (double)FLT_MAX ? FLT_MAX : value < -(double)FLT_MAX ? -FLT_MAX : (float)value;
    memcpy(at, &f, sizeof f);
}

void ect_link_store(void *instance, const ect_link_t *link, int64_t value)
{
    if (link->bytes == 0)
        return;
    uint8_t *at = (uint8_t *)instance + link->offset;
    if (link->is_real) {
        store_real(at, link->bytes, (double)value);
        return;
    }
    uint64_t bits = (uint64_t)within(link, value);
    uint8_t u8 = (uint8_t)bits;
    uint16_t u16 = (uint16_t)bits;
    uint32_t u32 = (uint32_t)bits;
    switch (link->bytes) {
    case 1:
        memcpy(at, &u8, sizeof u8);
        break;
    case 2:
        memcpy(at, &u16, sizeof u16);
        break;
    case 4:
        memcpy(at, &u32, sizeof u32);
        break;
    default:
        memcpy(at, &bits, sizeof bits);
        break;
    }
}

double ect_link_load_real(const void *instance, const ect_link_t *link)
{
    if (link->bytes != 0 && link->is_real)
        return load_real((const uint8_t *)instance + link->offset, link->bytes);
    return (double)ect_link_load(instance, link);
}

void ect_link_store_real(void *instance, const ect_link_t *link, double value)
{
    if (link->bytes != 0 && link->is_real)
        store_real((uint8_t *)instance + link->offset, link->bytes, value);
    else
        ect_link_store(instance, link, whole(value));
}
