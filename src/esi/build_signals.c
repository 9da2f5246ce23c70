/* SPDX-License-Identifier: MIT */
/*
 * Signals: the entries of each assigned PDO as `pdo_name.entry_name`, and all other values of the dictionary as
 * `od.8000_01`. Inputs are writable, outputs read-only.
 */
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"
#include "esi/units.h"

/* Maximum characters of parts of a name, with room left for prefix, dot and the number that makes the name unique. */
enum { LONGEST_PART = 28, LONGEST_VALUE = 60 };

/* Converts a text to lower-case letters, digits and `_`, beginning with a letter. */
static const char *plain_name(ect_build_t *build, const char *text, const char *otherwise)
{
    char name[LONGEST_PART + 1];
    size_t length = 0;
    for (; *text != '\0' && length < LONGEST_PART; text++) {
        char plain = ect_build_plain(*text);
        if (plain != '\0')
            name[length++] = plain;
        else if (length > 0 && name[length - 1] != '_')
            name[length++] = '_';
    }
    while (length > 0 && name[length - 1] == '_')
        length--;
    if (length == 0)
        return otherwise;
    name[length] = '\0';
    return ect_arena_print(build->arena, "%s%s", name[0] <= '9' ? "n" : "", name);
}

static ect_signal_type_t type_of(const ect_build_entry_t *entry)
{
    switch (entry->data_type) {
    case ECT_TYPE_INTEGER8:
        return ECT_SIGNAL_I8;
    case ECT_TYPE_INTEGER16:
        return ECT_SIGNAL_I16;
    case ECT_TYPE_INTEGER32:
        return ECT_SIGNAL_I32;
    case ECT_TYPE_INTEGER64:
        return ECT_SIGNAL_I64;
    case ECT_TYPE_UNSIGNED16:
    case ECT_TYPE_BITARR16:
        return ECT_SIGNAL_U16;
    case ECT_TYPE_UNSIGNED32:
    case ECT_TYPE_BITARR32:
        return ECT_SIGNAL_U32;
    case ECT_TYPE_UNSIGNED64:
        return ECT_SIGNAL_U64;
    case ECT_TYPE_REAL32:
        return ECT_SIGNAL_REAL32;
    case ECT_TYPE_REAL64:
        return ECT_SIGNAL_REAL;
    case ECT_TYPE_VISIBLE_STRING:
        return ECT_SIGNAL_TEXT;
    case ECT_TYPE_OCTET_STRING:
        return ECT_SIGNAL_BYTES;
    case ECT_TYPE_BOOLEAN:
        return ECT_SIGNAL_BOOL;
    default:
        return ECT_SIGNAL_U8;
    }
}

static void set_range(const ect_build_entry_t *entry, ect_signal_t *signal)
{
    signal->minimum = INT64_MIN;
    signal->maximum = INT64_MAX;
    if (signal->type == ECT_SIGNAL_TEXT || signal->type == ECT_SIGNAL_BYTES) {
        signal->minimum = 0;
        signal->maximum = (entry->bits + 7) / 8;
    } else if (ect_build_range(entry, &signal->minimum, &signal->maximum)) {
        if (entry->minimum.given && entry->minimum.value > signal->minimum && entry->minimum.value <= signal->maximum)
            signal->minimum = entry->minimum.value;
        if (entry->maximum.given && entry->maximum.value < signal->maximum && entry->maximum.value >= signal->minimum)
            signal->maximum = entry->maximum.value;
    }
    ECT_ASSERT(signal->minimum <= signal->maximum);
}

/* Objects of CiA 401 and CiA 404 whose units are in another object, at the same sub-index. */
static const struct {
    uint16_t profile, value, unit, digits; /* digits 0: none, else the object with the decimal digits of the value */
} unit_objects[] = {
    {401, 0x6401, 0x6430, 0},      {401, 0x6402, 0x6430, 0},      {401, 0x6403, 0x6430, 0},
    {404, 0x6130, 0x6131, 0},      {404, 0x6148, 0x6131, 0},      {404, 0x6149, 0x6131, 0},
    {404, 0x7130, 0x6131, 0x6132}, {404, 0x7148, 0x6131, 0x6132}, {404, 0x7149, 0x6131, 0x6132},
    {404, 0x9130, 0x6131, 0x6132}, {404, 0x9148, 0x6131, 0x6132}, {404, 0x9149, 0x6131, 0x6132},
};

uint32_t ect_build_default(const ect_build_t *build, uint16_t index, uint8_t subindex)
{
    const ect_build_object_t *object = ect_build_find(build, index);
    const ect_build_entry_t *entry = object != NULL ? ect_build_entry(object, subindex) : NULL;
    return entry != NULL ? (uint32_t)ect_build_number(entry) : 0;
}

/* @return a unit of ETG.1004: that of the entry, else that of the profile; 0: none */
static uint32_t unit_of(const ect_build_t *build, uint16_t index, const ect_build_entry_t *entry)
{
    uint32_t unit = (uint32_t)entry->unit << 16 | (uint32_t)entry->per << 8;
    for (size_t i = 0; unit == 0 && i < sizeof unit_objects / sizeof unit_objects[0]; i++) {
        if (unit_objects[i].value != index || unit_objects[i].profile != (build->model->profile & UINT16_MAX))
            continue;
        unit = ect_build_default(build, unit_objects[i].unit, entry->subindex);
        if (unit != 0 && unit_objects[i].digits != 0)
            unit -= ect_build_default(build, unit_objects[i].digits, entry->subindex) << 24; /* of the power of ten */
    }
    return unit;
}

const char *ect_build_unit_name(ect_build_t *build, uint32_t unit)
{
    char text[ECT_BUILD_TEXT];
    return ect_esi_unit_text(unit, text, sizeof text) != NULL ? ect_arena_print(build->arena, "%s", text) : NULL;
}

/* A group under construction. */
typedef struct list {
    ect_build_t *build;
    ect_signal_t *signals;
    uint16_t count;
} list_t;

static bool is_taken(const list_t *list, const char *name)
{
    for (uint16_t i = 0; i < list->count; i++) {
        if (strcmp(list->signals[i].name, name) == 0)
            return true;
    }
    return false;
}

/* @return a unique name for a list */
static const char *unique_name(const list_t *list, const char *name)
{
    const char *unique = name;
    for (unsigned int n = 2; is_taken(list, unique); n++)
        unique = ect_arena_print(list->build->arena, "%s_%u", name, n);
    return unique;
}

/* @param name  not in the list */
static void add_signal(list_t *list, uint16_t index, const ect_build_entry_t *entry, const char *name,
                       const char *meaning)
{
    ect_build_t *build = list->build;
    bool bytes = entry->data_type == ECT_TYPE_VISIBLE_STRING || entry->data_type == ECT_TYPE_OCTET_STRING;
    if (bytes && (entry->bits + 7u) / 8u > LONGEST_VALUE)
        return; // too long for a line of the control socket; accessible by SDO
    ECT_ASSERT(list->count < UINT16_MAX);
    list->signals = ect_arena_grow(build->arena, list->signals, list->count, sizeof *list->signals);
    ect_signal_t *signal = &list->signals[list->count++];
    signal->name = name;
    signal->meaning = ect_build_text(build, meaning, ECT_BUILD_TEXT);
    signal->unit = ect_build_unit_name(build, unit_of(build, index, entry));
    signal->type = type_of(entry);
    const bool own = (entry->access & ECT_ACCESS_RXPDO) != 0 || ect_build_is_toggle(build, entry);
    signal->access = own ? ECT_SIGNAL_READ : ECT_SIGNAL_WRITE;
    signal->offset = (uint32_t)entry->offset;
    set_range(entry, signal);
}

static void add_group(ect_build_t *build, ect_plant_t *plant, const char *prefix, const list_t *list)
{
    ect_signal_group_t *groups = (ect_signal_group_t *)(uintptr_t)plant->signal_groups; // ours, growing
    if (list->count == 0)
        return;
    const char *unique = prefix;
    for (unsigned int n = 2, i = 0; i < plant->signal_group_count; i++) {
        if (strcmp(groups[i].prefix, unique) == 0) {
            unique = ect_arena_print(build->arena, "%s_%u", prefix, n++);
            i = (unsigned int)-1;
        }
    }
    groups = ect_arena_grow(build->arena, groups, plant->signal_group_count, sizeof *groups);
    groups[plant->signal_group_count++] =
        (ect_signal_group_t){.prefix = unique, .signal_count = list->count, .signals = list->signals};
    plant->signal_groups = groups;
}

/* @return the flag of an entry that already has a signal */
static bool *seen_flag(const ect_build_t *build, bool *seen, uint16_t index, uint8_t subindex)
{
    const ect_build_object_t *object = ect_build_find(build, index);
    const ect_build_entry_t *entry = object != NULL ? ect_build_entry(object, subindex) : NULL;
    return entry != NULL ? &seen[object->first + (size_t)(entry - object->entries)] : NULL;
}

static const char *meaning_of(ect_build_t *build, const ect_build_pdo_t *pdo, const ect_esi_entry_t *model,
                              uint16_t index)
{
    if (pdo->is_telegram)
        return ect_arena_print(build->arena, "%s %s", ect_build_idn_text(build, model->index), model->name);
    return ect_arena_print(build->arena, "%04X:%02X %s", (unsigned int)index, (unsigned int)model->subindex,
                           model->name);
}

static void add_pdo(ect_build_t *build, ect_plant_t *plant, const ect_build_pdo_t *pdo, bool *seen)
{
    list_t list = {.build = build};
    for (size_t i = 0; i < pdo->model->entry_count; i++) {
        const ect_esi_entry_t *model = &pdo->model->entries[i];
        uint16_t index = ect_build_mapped(build, pdo, model);
        bool *flag = index != 0 ? seen_flag(build, seen, index, model->subindex) : NULL;
        if (flag == NULL || *flag)
            continue;
        *flag = true;
        const ect_build_entry_t *entry = ect_build_entry(ect_build_find(build, index), model->subindex);
        const char *otherwise =
            ect_arena_print(build->arena, "n%04x_%02x", (unsigned int)index, (unsigned int)model->subindex);
        add_signal(&list, index, entry, unique_name(&list, plain_name(build, model->name, otherwise)),
                   meaning_of(build, pdo, model, index));
    }
    const char *otherwise = ect_arena_print(build->arena, "pdo_%04x", (unsigned int)pdo->index);
    add_group(build, plant, plain_name(build, pdo->model->name, otherwise), &list);
}

/* Gives entries of a virtual PDO no signals: a master reads registers instead. */
static void skip_pdo(const ect_build_t *build, const ect_build_pdo_t *pdo, bool *seen)
{
    for (size_t i = 0; i < pdo->model->entry_count; i++) {
        const ect_esi_entry_t *model = &pdo->model->entries[i];
        uint16_t index = ect_build_mapped(build, pdo, model);
        bool *flag = index != 0 ? seen_flag(build, seen, index, model->subindex) : NULL;
        if (flag != NULL)
            *flag = true;
    }
}

static bool is_of_the_stack(uint16_t index)
{
    return index >= 0x1000 && index < 0x2000;
}

/* The lists of modules that change follow the slots, which have signals of their own, and the master. */
static bool is_of_slots(const ect_build_t *build, uint16_t index)
{
    return build->rack != NULL && index >= ECT_ESI_PROFILES && index <= ECT_ESI_IDENTS_DETECTED;
}

static void add_objects(ect_build_t *build, ect_plant_t *plant, const bool *seen)
{
    list_t list = {.build = build};
    size_t at = 0;
    for (size_t o = 0; o < build->object_count; o++) {
        const ect_build_object_t *object = &build->objects[o];
        for (size_t i = 0; i < object->count; i++, at++) {
            const ect_build_entry_t *entry = &object->entries[i];
            bool count = object->code != ECT_OBJECT_VAR && entry->subindex == 0;
            if (seen[at] || count || is_of_the_stack(object->index) || is_of_slots(build, object->index))
                continue;
            const char *name =
                ect_arena_print(build->arena, "%04x_%02x", (unsigned int)object->index, (unsigned int)entry->subindex);
            add_signal(
                &list, object->index, entry, name,
                ect_arena_print(build->arena, "%s%s%s", object->name, *entry->name != '\0' ? ", " : "", entry->name));
        }
    }
    add_group(build, plant, "od", &list);
}

void ect_build_signals(ect_build_t *build, ect_plant_t *plant)
{
    size_t entries = 0;
    for (size_t i = 0; i < build->object_count; i++) {
        build->objects[i].first = entries;
        entries += build->objects[i].count;
    }
    bool *seen = ect_arena_alloc(build->arena, entries + 1);
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (build->pdos[i].assigned)
            add_pdo(build, plant, &build->pdos[i], seen);
    }
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (!build->pdos[i].assigned && build->pdos[i].usable && !build->pdos[i].on_virtual)
            add_pdo(build, plant, &build->pdos[i], seen);
    }
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (build->pdos[i].on_virtual)
            skip_pdo(build, &build->pdos[i], seen);
    }
    add_objects(build, plant, seen);
    const list_t toggle = {.signals = (ect_signal_t *)(uintptr_t)ect_build_toggle_signals, .count = 1};
    if (build->toggle_count > 0)
        add_group(build, plant, "toggle", &toggle);
}
