/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/signals.h"

#include <errno.h>
#include <fnmatch.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A value in its own type. The room is that of the longest text or byte string that a signal may have. */
typedef union value {
    uint8_t u8;
    int16_t i16;
    uint16_t u16;
    int32_t i32;
    uint32_t u32;
    double real;
    char text[ECT_SIGNAL_TEXT_ROOM];
    uint8_t bytes[ECT_SIGNAL_TEXT_ROOM / 2];
} value_t;

static size_t size_of(const ect_signal_t *signal)
{
    switch (signal->type) {
    case ECT_SIGNAL_BOOL:
    case ECT_SIGNAL_U8:
        return 1;
    case ECT_SIGNAL_I16:
    case ECT_SIGNAL_U16:
        return 2;
    case ECT_SIGNAL_I32:
    case ECT_SIGNAL_U32:
        return 4;
    case ECT_SIGNAL_REAL:
        return sizeof(double);
    case ECT_SIGNAL_TEXT:
        return (size_t)signal->maximum + 1;
    case ECT_SIGNAL_BYTES:
        return (size_t)signal->maximum;
    }
    return 0;
}

/* What a VISIBLE_STRING may hold (ISO 646). */
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

size_t ect_signals_visit(const ect_plant_t *plant, void *instance, const char *pattern,
                         void (*visit)(void *ctx, const ect_signal_ref_t *ref), void *ctx)
{
    size_t count = 0;
    for (unsigned int g = 0; plant && g < plant->signal_group_count; g++) {
        const ect_signal_group_t *group = &plant->signal_groups[g];
        uint16_t first = group->count > 0 ? 1 : 0;
        for (uint16_t number = first; number <= group->count; number++) {
            for (unsigned int i = 0; i < group->signal_count; i++) {
                ect_signal_ref_t ref = make_ref(plant, instance, group, &group->signals[i], number);
                if (fnmatch(pattern, ref.name, 0) != 0)
                    continue;
                visit(ctx, &ref);
                count++;
            }
        }
    }
    return count;
}

typedef struct search {
    const char *name;
    ect_signal_ref_t *ref;
    bool found;
} search_t;

static void compare(void *ctx, const ect_signal_ref_t *ref)
{
    search_t *search = ctx;
    if (strcmp(ref->name, search->name) != 0)
        return;
    *search->ref = *ref;
    search->found = true;
}

bool ect_signal_find(const ect_plant_t *plant, void *instance, const char *name, ect_signal_ref_t *ref)
{
    search_t search = {.name = name, .ref = ref};
    (void)ect_signals_visit(plant, instance, "*", compare, &search);
    return search.found;
}

void ect_signal_read(const ect_signal_ref_t *ref, char *text)
{
    value_t v = {0};
    size_t size = size_of(ref->signal);
    memcpy(&v, ref->value, size < sizeof v ? size : sizeof v);
    switch (ref->signal->type) {
    case ECT_SIGNAL_BOOL:
    case ECT_SIGNAL_U8:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%u", v.u8);
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
    case ECT_SIGNAL_REAL:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%.15g", v.real);
        return;
    case ECT_SIGNAL_TEXT:
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%s", v.text);
        for (char *c = text; *c != 0; c++)
            *c = visible(*c) ? *c : '?'; /* a master may have written anything */
        return;
    case ECT_SIGNAL_BYTES:
        for (size_t i = 0; i < size && 2 * i + 2 < ECT_SIGNAL_TEXT_ROOM; i++)
            snprintf(text + 2 * i, 3, "%02x", v.bytes[i]);
        return;
    }
}

void ect_signal_range(const ect_signal_t *signal, char *text)
{
    const char *unit = signal->unit ? signal->unit : "";
    const char *space = signal->unit ? " " : "";
    if (signal->type == ECT_SIGNAL_TEXT)
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "up to %d characters from space to ~", signal->maximum);
    else if (signal->type == ECT_SIGNAL_BYTES)
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%d bytes, %d hexadecimal digits", signal->maximum, 2 * signal->maximum);
    else
        snprintf(text, ECT_SIGNAL_TEXT_ROOM, "%d..%d%s%s", signal->minimum, signal->maximum, space, unit);
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
    errno = 0;
    long long number = strtoll(text, &end, 0);
    if (errno != 0 || end == text || *end != 0 || number < signal->minimum || number > signal->maximum)
        return false;
    switch (size_of(signal)) {
    case 1:
        v->u8 = (uint8_t)number;
        break;
    case 2:
        v->u16 = (uint16_t)number;
        break;
    default:
        v->u32 = (uint32_t)number;
        break;
    }
    return true;
}

static bool parse(const ect_signal_t *signal, const char *text, value_t *v)
{
    char *end;
    switch (signal->type) {
    case ECT_SIGNAL_BYTES:
        return size_of(signal) <= sizeof v->bytes && parse_bytes(text, size_of(signal), v->bytes);
    case ECT_SIGNAL_TEXT:
        if (strlen(text) >= size_of(signal) || strlen(text) >= sizeof v->text || !all_visible(text))
            return false;
        strcpy(v->text, text);
        return true;
    case ECT_SIGNAL_REAL:
        v->real = strtod(text, &end);
        return end != text && *end == 0 && v->real >= signal->minimum && v->real <= signal->maximum;
    default:
        return parse_integer(signal, text, v);
    }
}

bool ect_signal_write(const ect_signal_ref_t *ref, const char *text, uint64_t now_ns, char *message)
{
    const ect_signal_t *signal = ref->signal;
    value_t v = {0};
    if (signal->access != ECT_SIGNAL_WRITE) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "%s is the twin's own: it can be read and watched, not set", ref->name);
        return false;
    }
    if (!parse(signal, text, &v)) {
        char range[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_range(signal, range);
        snprintf(message, ECT_SIGNAL_MESSAGE, "%s takes %s, not '%.40s'", ref->name, range, text);
        return false;
    }
    const char *refusal = NULL;
    if (ref->plant->signal_write)
        refusal = ref->plant->signal_write(ref->instance, signal, ref->number, &v, now_ns);
    if (refusal && *refusal) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "%s: %s", ref->name, refusal);
        return false;
    }
    if (!refusal)
        memcpy(ref->value, &v, size_of(signal));
    return true;
}
