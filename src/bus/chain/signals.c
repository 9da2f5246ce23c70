/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/chain/signals.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* A value in its own type, with room for the longest text or byte string of a signal. */
typedef union value {
    uint8_t u8;
    int8_t i8;
    int16_t i16;
    uint16_t u16;
    int32_t i32;
    uint32_t u32;
    int64_t i64;
    uint64_t u64;
    float real32;
    double real;
    char text[ECT_SIGNAL_TEXT_ROOM];
    uint8_t bytes[ECT_SIGNAL_TEXT_ROOM / 2];
} value_t;

size_t ect_signal_size(const ect_signal_t *signal)
{
    switch (signal->type) {
    case ECT_SIGNAL_BOOL:
    case ECT_SIGNAL_U8:
    case ECT_SIGNAL_I8:
        return 1;
    case ECT_SIGNAL_I16:
    case ECT_SIGNAL_U16:
    case ECT_SIGNAL_DESCRIBED:
        return 2;
    case ECT_SIGNAL_I32:
    case ECT_SIGNAL_U32:
    case ECT_SIGNAL_REAL32:
        return 4;
    case ECT_SIGNAL_I64:
    case ECT_SIGNAL_U64:
    case ECT_SIGNAL_REAL:
        return 8;
    case ECT_SIGNAL_TEXT:
        return (size_t)signal->maximum + 1;
    case ECT_SIGNAL_BYTES:
        return (size_t)signal->maximum;
    }
    return 0;
}

/* The characters of a VISIBLE_STRING (ISO 646). */
static bool visible(char c)
{
    return c >= ' ' && c <= '~';
}

static bool all_visible(const char *text)
{
    while (visible(*text))
        text++;
    return *text == 0;
}

static ect_signal_ref_t make_ref(const ect_plant_t *plant, void *instance, const ect_signal_group_t *group,
                                 const ect_signal_t *signal, uint16_t number)
{
    ect_signal_ref_t ref = {.plant = plant, .instance = instance, .signal = signal, .number = number};
    size_t structure = group->offset + (number > 0 ? (size_t)(number - 1) * group->stride : 0);
    ref.value = (uint8_t *)instance + structure + signal->offset;
    if (!group->prefix)
        snprintf(ref.name, sizeof ref.name, "%s", signal->name);
    else if (number == 0)
        snprintf(ref.name, sizeof ref.name, "%s.%s", group->prefix, signal->name);
    else
        snprintf(ref.name, sizeof ref.name, "%s%u.%s", group->prefix, number, signal->name);
    return ref;
}

bool ect_signals_next(const ect_plant_t *plant, void *instance, ect_signal_cursor_t *cursor, ect_signal_ref_t *ref)
{
    while (plant && cursor->group < plant->signal_group_count) {
        const ect_signal_group_t *group = &plant->signal_groups[cursor->group];
        if (group->count > 0 && cursor->number == 0)
            cursor->number = 1;
        if (cursor->number <= group->count && cursor->index < group->signal_count) {
            *ref = make_ref(plant, instance, group, &group->signals[cursor->index++], cursor->number);
            return true;
        }
        cursor->index = 0;
        if (cursor->number < group->count) {
            cursor->number++;
        } else {
            cursor->group++;
            cursor->number = 0;
        }
    }
    return false;
}

/* @return the part of a name after the group's prefix, number and dot; NULL: a name of another group */
static const char *inside(const ect_signal_group_t *group, const char *name, uint16_t *number)
{
    size_t length = group->prefix ? strlen(group->prefix) : 0;
    *number = 0;
    if (!group->prefix)
        return name;
    if (strncmp(name, group->prefix, length) != 0)
        return NULL;
    name += length;
    if (group->count > 0) {
        char *end;
        if (*name < '1' || *name > '9')
            return NULL;
        unsigned long value = strtoul(name, &end, 10);
        if (value > group->count)
            return NULL;
        *number = (uint16_t)value;
        name = end;
    }
    return *name == '.' ? name + 1 : NULL;
}

bool ect_signal_find(const ect_plant_t *plant, void *instance, const char *name, ect_signal_ref_t *ref)
{
    for (unsigned int g = 0; plant && g < plant->signal_group_count; g++) {
        const ect_signal_group_t *group = &plant->signal_groups[g];
        uint16_t number;
        const char *rest = inside(group, name, &number);
        for (unsigned int i = 0; rest && i < group->signal_count; i++) {
            if (strcmp(group->signals[i].name, rest) == 0) {
                *ref = make_ref(plant, instance, group, &group->signals[i], number);
                return true;
            }
        }
    }
    return false;
}

bool ect_signal_is_number(const ect_signal_t *signal)
{
    return signal->type != ECT_SIGNAL_TEXT && signal->type != ECT_SIGNAL_BYTES && signal->type != ECT_SIGNAL_DESCRIBED;
}

void ect_signal_read(const ect_signal_ref_t *ref, char *text)
{
    ect_signal_text(ref, ref->value, text);
}

void ect_signal_text(const ect_signal_ref_t *ref, const void *value, char *text)
{
    const ect_signal_t *signal = ref->signal;
    value_t v = {0};
    size_t size = ect_signal_size(signal);
    memcpy(&v, value, size < sizeof v ? size : sizeof v);
    switch (signal->type) {
    case ECT_SIGNAL_BOOL:
    case ECT_SIGNAL_U8:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%u", v.u8);
        return;
    case ECT_SIGNAL_I8:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%d", v.i8);
        return;
    case ECT_SIGNAL_I16:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%d", v.i16);
        return;
    case ECT_SIGNAL_U16:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%u", v.u16);
        return;
    case ECT_SIGNAL_I32:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%" PRId32, v.i32);
        return;
    case ECT_SIGNAL_U32:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%" PRIu32, v.u32);
        return;
    case ECT_SIGNAL_I64:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%" PRId64, v.i64);
        return;
    case ECT_SIGNAL_U64:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%" PRIu64, v.u64);
        return;
    case ECT_SIGNAL_REAL32:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%.7g", (double)v.real32);
        return;
    case ECT_SIGNAL_REAL:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%.15g", v.real);
        return;
    case ECT_SIGNAL_TEXT:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%s", v.text);
        for (char *c = text; *c != 0; c++)
            *c = visible(*c) ? *c : '?'; /* a master may have written any bytes */
        return;
    case ECT_SIGNAL_BYTES:
        for (size_t i = 0; i < size && 2 * i + 2 < ECT_SIGNAL_TEXT_ROOM; i++)
            snprintf(text + 2 * i, 3, "%02x", v.bytes[i]);
        return;
    case ECT_SIGNAL_DESCRIBED:
        ref->plant->signal_describe(signal, v.u16, text);
        return;
    }
}

void ect_signal_range(const ect_signal_t *signal, char *text)
{
    const char *unit = signal->unit ? signal->unit : "";
    const char *space = signal->unit ? " " : "";
    if (signal->type == ECT_SIGNAL_TEXT || signal->type == ECT_SIGNAL_DESCRIBED)
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "up to %" PRId64 " characters from space to ~", signal->maximum);
    else if (signal->type == ECT_SIGNAL_BYTES)
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%" PRId64 " bytes, %" PRId64 " hexadecimal digits", signal->maximum,
                 2 * signal->maximum);
    else if (signal->minimum == INT64_MIN && signal->maximum == INT64_MAX)
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "any number%s%s", space, unit);
    else
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%" PRId64 "..%" PRId64 "%s%s", signal->minimum, signal->maximum, space,
                 unit);
}

double ect_signal_fit(const ect_signal_t *signal, double value)
{
    const double integer = 9007199254740992.0; /* from 2^53 on a number has no fraction */
    const bool real = signal->type == ECT_SIGNAL_REAL || signal->type == ECT_SIGNAL_REAL32;
    if (!(value >= (double)signal->minimum))
        return (double)signal->minimum;
    if (value > (double)signal->maximum)
        return (double)signal->maximum;
    if (real || value >= integer || value <= -integer)
        return value;
    return (double)(int64_t)(value < 0 ? value - 0.5 : value + 0.5);
}

static bool parse_bytes(const char *text, size_t size, uint8_t *bytes)
{
    if (strlen(text) != 2 * size || strspn(text, "0123456789abcdefABCDEF") != 2 * size)
        return false;
    for (size_t i = 0; i < size; i++) {
        char digits[3] = {text[2 * i], text[2 * i + 1], 0};
        bytes[i] = (uint8_t)strtoul(digits, NULL, 16);
    }
    return true;
}

static bool parse_integer(const ect_signal_t *signal, const char *text, value_t *v)
{
    char *end;
    bool negative = *text == '-';
    int base = strncasecmp(text + negative, "0x", 2) == 0 ? 16 : 10;
    errno = 0;
    long long number = strtoll(text, &end, base);
    if (errno != 0 || end == text || *end != 0 || number < signal->minimum || number > signal->maximum)
        return false;
    switch (ect_signal_size(signal)) {
    case 1:
        v->u8 = (uint8_t)number;
        break;
    case 2:
        v->u16 = (uint16_t)number;
        break;
    case 4:
        v->u32 = (uint32_t)number;
        break;
    default:
        v->i64 = number;
        break;
    }
    return true;
}

static bool in_range(const ect_signal_t *signal, double value)
{
    return value >= (double)signal->minimum && value <= (double)signal->maximum;
}

static bool parse(const ect_signal_t *signal, const char *text, value_t *v)
{
    char *end;
    switch (signal->type) {
    case ECT_SIGNAL_BYTES:
        return ect_signal_size(signal) <= sizeof v->bytes && parse_bytes(text, ect_signal_size(signal), v->bytes);
    case ECT_SIGNAL_TEXT:
        if (strlen(text) >= ect_signal_size(signal) || strlen(text) >= sizeof v->text || !all_visible(text))
            return false;
        strcpy(v->text, text);
        return true;
    case ECT_SIGNAL_REAL32:
        v->real32 = strtof(text, &end);
        return end != text && *end == 0 && in_range(signal, (double)v->real32);
    case ECT_SIGNAL_REAL:
        v->real = strtod(text, &end);
        return end != text && *end == 0 && in_range(signal, v->real);
    default:
        return parse_integer(signal, text, v);
    }
}

/* @return whether the text is a value that the user may set. @param[out] v  the value, set on true */
static bool accept(const ect_signal_ref_t *ref, const char *text, value_t *v, char *message)
{
    char range[ECT_SIGNAL_TEXT_ROOM];
    if (ref->signal->access != ECT_SIGNAL_WRITE) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "%s is the twin's own: it can be read and watched, not set", ref->name);
        return false;
    }
    if (parse(ref->signal, text, v))
        return true;
    ect_signal_range(ref->signal, range);
    snprintf(message, ECT_SIGNAL_MESSAGE, "%s takes %s, not '%.40s'", ref->name, range, text);
    return false;
}

bool ect_signal_check(const ect_signal_ref_t *ref, const char *text, char *message)
{
    value_t v = {0};
    return accept(ref, text, &v, message);
}

bool ect_signal_write(const ect_signal_ref_t *ref, const char *text, uint64_t now_ns, char *message)
{
    const ect_plant_t *plant = ref->plant;
    value_t v = {0};
    if (!accept(ref, text, &v, message))
        return false;
    const char *answer =
        plant->signal_write ? plant->signal_write(ref->instance, ref->signal, ref->number, &v, now_ns) : NULL;
    if (answer && *answer) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "%s: %s", ref->name, answer);
        return false;
    }
    if (answer)
        return true;
    memcpy(ref->value, &v, ect_signal_size(ref->signal));
    if (plant->signal_written)
        plant->signal_written(ref->instance, ref->signal, ref->number, now_ns);
    return true;
}
