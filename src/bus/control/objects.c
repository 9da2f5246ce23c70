/* SPDX-License-Identifier: MIT */
#include "bus/control/objects.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/abort.h"
#include "text/number.h"
#include "wire/bytes.h"

enum { ROOM = ECT_OBJECT_BYTES };

/* Types of numbers. `bytes` 0: no number. */
typedef struct type {
    uint16_t type;
    const char *name;
    uint8_t bytes;
    enum { UNSIGNED, SIGNED, REAL } kind;
} type_t;

static const type_t types[] = {
    {ECT_TYPE_BOOLEAN, "BOOLEAN", 1, UNSIGNED},
    {ECT_TYPE_INTEGER8, "INTEGER8", 1, SIGNED},
    {ECT_TYPE_INTEGER16, "INTEGER16", 2, SIGNED},
    {ECT_TYPE_INTEGER32, "INTEGER32", 4, SIGNED},
    {ECT_TYPE_INTEGER64, "INTEGER64", 8, SIGNED},
    {ECT_TYPE_UNSIGNED8, "UNSIGNED8", 1, UNSIGNED},
    {ECT_TYPE_UNSIGNED16, "UNSIGNED16", 2, UNSIGNED},
    {ECT_TYPE_UNSIGNED32, "UNSIGNED32", 4, UNSIGNED},
    {ECT_TYPE_UNSIGNED64, "UNSIGNED64", 8, UNSIGNED},
    {ECT_TYPE_REAL32, "REAL32", 4, REAL},
    {ECT_TYPE_REAL64, "REAL64", 8, REAL},
    {ECT_TYPE_BITARR8, "BITARR8", 1, UNSIGNED},
    {ECT_TYPE_BITARR16, "BITARR16", 2, UNSIGNED},
    {ECT_TYPE_BITARR32, "BITARR32", 4, UNSIGNED},
    {ECT_TYPE_VISIBLE_STRING, "VISIBLE_STRING", 0, UNSIGNED},
    {ECT_TYPE_OCTET_STRING, "OCTET_STRING", 0, UNSIGNED},
};

static const type_t *find_type(uint16_t type)
{
    static const type_t bits = {ECT_TYPE_BIT1, "BIT", 1, UNSIGNED}, other = {ECT_TYPE_NONE, "OTHER", 0, UNSIGNED};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (types[i].type == type)
            return &types[i];
    }
    return type >= ECT_TYPE_BIT1 && type <= ECT_TYPE_BIT8 ? &bits : &other;
}

const char *ect_object_type(uint16_t type)
{
    return find_type(type)->name;
}

bool ect_object_number(const cJSON *request, const char *member, uint32_t maximum, uint32_t *value)
{
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(request, member);
    double number = json ? json->valuedouble : 0;
    bool good = (!json || cJSON_IsNumber(json)) && number >= 0 && number <= maximum && (uint32_t)number == number;
    *value = good ? (uint32_t)number : 0;
    return good;
}

const char *ect_object_place(const cJSON *request, ect_object_place_t *place)
{
    if (!ect_object_number(request, "index", UINT16_MAX, &place->index))
        return "\"index\" is a number from 0 to 65535";
    return ect_object_number(request, "sub", UINT8_MAX, &place->subindex) ? NULL : "\"sub\" is a number from 0 to 255";
}

/* --- the list ----------------------------------------------------------------------------------------------------- */

/* @return the position of the first object with this index or a higher one */
static size_t first_from(const ect_od_t *od, uint32_t index)
{
    size_t low = 0, high = od->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (od->objects[middle].index < index)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static const ect_entry_t *entry_from(const ect_object_t *object, uint32_t subindex)
{
    const ect_entry_t *entry = object->entries;
    while (entry && entry->subindex < subindex)
        entry = ect_od_next(object, entry);
    return entry;
}

static const char *access_of(const ect_entry_t *entry)
{
    static const char *const names[] = {"", "ro", "wo", "rw"};
    return names[((entry->access & ECT_ACCESS_RO) != 0 ? 1 : 0) + ((entry->access & ECT_ACCESS_WO) != 0 ? 2 : 0)];
}

static void put_place(ect_line_t *line, size_t slave, const ect_object_place_t *place)
{
    ect_line_begin(line);
    ect_line_number(line, "slave", slave);
    ect_line_number(line, "index", place->index);
    ect_line_number(line, "sub", place->subindex);
}

bool ect_objects_next(const ect_od_t *od, size_t slave, ect_object_place_t *place, ect_line_t *line)
{
    const ect_entry_t *entry = NULL;
    size_t at = first_from(od, place->index);
    for (; at < od->count && !entry; at++)
        entry = entry_from(&od->objects[at], od->objects[at].index == place->index ? place->subindex : 0);
    if (!entry)
        return false;
    const ect_object_t *object = &od->objects[at - 1];
    *place = (ect_object_place_t){.index = object->index, .subindex = entry->subindex};
    put_place(line, slave, place);
    place->subindex++;
    ect_line_string(line, "object", object->name ? object->name : "");
    ect_line_string(line, "name", entry->name ? entry->name : "");
    ect_line_string(line, "type", find_type(entry->data_type)->name);
    ect_line_number(line, "bits", ect_od_bits(od, entry));
    ect_line_string(line, "access", access_of(entry));
    ect_line_end(line);
    return true;
}

/* --- read and write ----------------------------------------------------------------------------------------------- */

/* @return the entry of a request; NULL: none, and the stack returns the reason */
static const ect_entry_t *find_entry(const ect_slave_t *slave, const ect_object_place_t *place)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    (void)ect_od_lookup(ect_slave_dictionary(slave), (uint16_t)place->index, (uint8_t)place->subindex, &object, &entry);
    return entry;
}

static const char *aborted(const ect_object_place_t *place, ect_reason_t reason, char *message)
{
    uint32_t code = ect_abort_code(reason);
    const char *text = ect_abort_text(code);
    snprintf(message, ECT_SIGNAL_MESSAGE, "%04" PRIX32 "h:%" PRIu32 ": SDO abort 0x%08" PRIX32 "%s%s", place->index,
             place->subindex, code, text ? ": " : "", text ? text : "");
    return message;
}

/* Sets *slave and *place. @return the reason of a refusal; NULL: set */
static const char *open(ect_chain_t *chain, size_t number, const cJSON *request, ect_slave_t **slave,
                        ect_object_place_t *place, char *message)
{
    const char *why = ect_object_place(request, place);
    if (why)
        return why;
    if (!cJSON_HasObjectItem(request, "index"))
        return "a request to an object has {\"index\":...,\"sub\":...}";
    *slave = ect_chain_sdo(chain, number - 1, &why);
    if (*slave && ect_slave_in_transfer(*slave))
        why = "a master transfers an object: try again";
    if (!why)
        return NULL;
    snprintf(message, ECT_SIGNAL_MESSAGE, "slave %zu: %s", number, why);
    return message;
}

static uint64_t load(const uint8_t *bytes, size_t count)
{
    uint64_t value = 0;
    while (count > 0)
        value = value << 8 | bytes[--count];
    return value;
}

static double real_of(uint64_t bits, size_t bytes)
{
    float single;
    double number;
    const uint32_t low = (uint32_t)bits;
    memcpy(&single, &low, sizeof single);
    memcpy(&number, &bits, sizeof number);
    return bytes == sizeof single ? (double)single : number;
}

static void put_number(ect_line_t *line, const type_t *type, const uint8_t *bytes)
{
    char text[40];
    uint64_t value = load(bytes, type->bytes);
    unsigned int unused = 64u - 8u * type->bytes;
    double real = real_of(value, type->bytes);
    if (type->kind == UNSIGNED)
        snprintf(text, sizeof text, "%" PRIu64, value);
    else if (type->kind == SIGNED)
        snprintf(text, sizeof text, "%" PRId64, (int64_t)(value << unused) / ((int64_t)1 << unused));
    else
        snprintf(text, sizeof text, "%.*g", type->bytes == 4 ? 9 : 17, real);
    ect_line_plain(line, "value", type->kind == REAL && !isfinite(real) ? "null" : text);
}

void ect_object_put_value(ect_line_t *line, uint16_t data_type, const uint8_t *bytes, size_t size)
{
    char digits[2 * ECT_OBJECT_BYTES + 1] = "";
    const type_t *type = find_type(data_type);
    for (size_t i = 0; i < size && i < ECT_OBJECT_BYTES; i++)
        snprintf(digits + 2 * i, 3, "%02x", bytes[i]);
    ect_line_string(line, "data", digits);
    if (type->bytes > 0 && type->bytes == size)
        put_number(line, type, bytes);
    else if (type->type == ECT_TYPE_VISIBLE_STRING)
        ect_line_string(line, "value", (const char *)bytes);
}

const char *ect_object_read(ect_chain_t *chain, size_t number, const cJSON *request, ect_line_t *line, char *message)
{
    uint8_t bytes[ROOM + 1] = {0};
    ect_object_place_t place;
    ect_slave_t *slave;
    uint16_t size = 0;
    const char *why = open(chain, number, request, &slave, &place, message);
    if (why)
        return why;
    ect_reason_t reason = ect_slave_upload(slave, (uint16_t)place.index, (uint8_t)place.subindex, bytes, ROOM, &size);
    ect_chain_wake(chain, number - 1);
    if (reason != ECT_OK)
        return aborted(&place, reason, message);
    const ect_entry_t *entry = find_entry(slave, &place);
    put_place(line, number, &place);
    ect_line_number(line, "size", size);
    ect_object_put_value(line, entry ? entry->data_type : (uint16_t)ECT_TYPE_NONE, bytes, size);
    ect_line_end(line);
    return NULL;
}

static bool read_hex(const char *text, uint8_t *bytes, uint16_t *size)
{
    size_t length = strlen(text);
    if (length % 2 != 0 || length > 2 * ROOM)
        return false;
    for (size_t i = 0; i < length; i += 2) {
        unsigned int high = ect_number_digit(text[i]), low = ect_number_digit(text[i + 1]);
        if (high > 15 || low > 15)
            return false;
        bytes[i / 2] = (uint8_t)(high << 4 | low);
    }
    *size = (uint16_t)(length / 2);
    return true;
}

static bool read_real(const char *text, size_t bytes, uint64_t *bits)
{
    char *end;
    const double number = strtod(text, &end);
    const float single = (float)number;
    uint32_t low;
    memcpy(&low, &single, sizeof low);
    memcpy(bits, &number, sizeof *bits);
    *bits = bytes == sizeof single ? low : *bits;
    return end != text && *end == 0;
}

static bool read_integer(const char *text, const type_t *type, uint64_t *value)
{
    bool negative = type->kind == SIGNED && text[0] == '-';
    unsigned int bits = 8u * type->bytes;
    uint64_t highest = UINT64_MAX >> (64u - bits);
    uint64_t most = type->kind == SIGNED ? (highest >> 1) + negative : highest;
    if (!ect_number(text + negative, 0, most, value))
        return false;
    *value = negative ? 0 - *value : *value;
    return true;
}

/* Converts a number, as text or JSON, to wire form. */
static bool read_value(const char *text, const type_t *type, uint8_t *bytes, uint16_t *size)
{
    uint64_t value;
    if (type->bytes == 0) {
        *size = (uint16_t)strlen(text);
        memcpy(bytes, text, *size);
        return type->type == ECT_TYPE_VISIBLE_STRING;
    }
    if (!(type->kind == REAL ? read_real(text, type->bytes, &value) : read_integer(text, type, &value)))
        return false;
    for (size_t i = 0; i < type->bytes; i++)
        bytes[i] = (uint8_t)(value >> (8 * i));
    *size = type->bytes;
    return true;
}

/* Reads the bytes of "data" or "value". @return the reason of a refusal; NULL: done */
static const char *read_bytes(const cJSON *request, const type_t *type, uint8_t *bytes, uint16_t *size, char *message)
{
    char number[40];
    const char *data = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(request, "data"));
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(request, "value");
    const char *text = cJSON_GetStringValue(json);
    if (data)
        return read_hex(data, bytes, size) ? NULL : "\"data\" is at most 200 bytes, each of two hexadecimal digits";
    if (cJSON_IsNumber(json)) {
        snprintf(number, sizeof number, "%.17g", json->valuedouble);
        text = number;
    }
    if (!text || strlen(text) > ROOM)
        return "\"write\" takes \"value\", a number or a text of at most 200 characters, or \"data\"";
    if (read_value(text, type, bytes, size))
        return NULL;
    snprintf(message, ECT_SIGNAL_MESSAGE, "'%.60s' is no value of type %s: \"data\" takes its bytes", text, type->name);
    return message;
}

const char *ect_object_write(ect_chain_t *chain, size_t number, const cJSON *request, char *message)
{
    uint8_t bytes[ROOM + 1] = {0};
    ect_object_place_t place;
    ect_slave_t *slave;
    uint16_t size = 0;
    const char *why = open(chain, number, request, &slave, &place, message);
    if (why)
        return why;
    const ect_entry_t *entry = find_entry(slave, &place);
    const type_t *type = find_type(entry ? entry->data_type : (uint16_t)ECT_TYPE_UNSIGNED32);
    why = read_bytes(request, type, bytes, &size, message);
    if (why)
        return why;
    ect_reason_t reason = ect_slave_download(slave, (uint16_t)place.index, (uint8_t)place.subindex, bytes, size);
    ect_chain_wake(chain, number - 1);
    return reason == ECT_OK ? NULL : aborted(&place, reason, message);
}
