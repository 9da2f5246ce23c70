/* SPDX-License-Identifier: MIT */
/* Adds the dictionary read from a slave to the model of its EEPROM image. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "esi/image.h"
#include "esi/internal.h"
#include "od/pdo.h"
#include "wire/bytes.h"

enum { ASSIGNMENTS = 32, NONE = -1 };

/* The model may be changed until it is selected. */
#define OURS(pointer) ((void *)(uintptr_t)(pointer))

static const char *copy_text(ect_esi_t *esi, const char *text)
{
    return ect_arena_copy(&esi->arena, text, strlen(text));
}

static ect_esi_bytes_t copy_bytes(ect_esi_t *esi, ect_esi_bytes_t from)
{
    if (from.bytes == NULL || from.length == 0)
        return (ect_esi_bytes_t){0};
    uint8_t *bytes = ect_arena_alloc(&esi->arena, from.length);
    memcpy(bytes, from.bytes, from.length);
    return (ect_esi_bytes_t){.bytes = bytes, .length = from.length};
}

/* --- objects and entries ------------------------------------------------------------------------------------------ */

void ect_esi_found_object(ect_esi_t *esi, const ect_esi_found_object_t *object)
{
    ect_esi_dictionary_t *dictionary = &esi->device->dictionary;
    ect_esi_object_t *objects = OURS(dictionary->objects);
    ect_esi_type_t *types = OURS(dictionary->types);
    esi->found = ect_arena_grow(&esi->arena, esi->found, dictionary->object_count, sizeof *esi->found);
    esi->found[dictionary->object_count] = (ect_esi_found_t){.described = object->described, .code = object->code};
    objects = ect_arena_grow(&esi->arena, objects, dictionary->object_count, sizeof *objects);
    types = ect_arena_grow(&esi->arena, types, dictionary->type_count, sizeof *types);
    objects[dictionary->object_count++] = (ect_esi_object_t){
        .index = object->index,
        .name = copy_text(esi, object->name),
        .type = "",
        .flags = {.access = "", .read_in = "", .write_in = "", .mapping = "", .category = ""},
        .info = {.name = "", .display = ""},
    };
    types[dictionary->type_count++] = (ect_esi_type_t){
        .name = ect_arena_print(&esi->arena, "DT%04X", object->index),
        .base = "",
    };
    dictionary->objects = objects;
    dictionary->types = types;
}

/* Bits 0 to 2: PREOP, SAFEOP, OP. */
static const char *restriction_of(unsigned int states)
{
    static const char *const names[8] = {"", "PreOP", "SafeOP", "PreOP_SafeOP", "OP", "PreOP_OP", "SafeOP_OP", ""};
    return names[states & 7u];
}

static ect_esi_flags_t flags_of(const ect_esi_found_entry_t *entry)
{
    const uint16_t access = entry->access;
    const bool readable = (access & ECT_ACCESS_RO) != 0, writable = (access & ECT_ACCESS_WO) != 0;
    const bool rx = (access & ECT_ACCESS_RXPDO) != 0, tx = (access & ECT_ACCESS_TXPDO) != 0;
    return (ect_esi_flags_t){
        .access = writable && readable ? "rw"
                  : writable           ? "wo"
                                       : "ro",
        .read_in = restriction_of(access),
        .write_in = restriction_of(access >> 3),
        .mapping = rx && tx ? "TR"
                   : rx     ? "R"
                   : tx     ? "T"
                            : "",
        .category = "",
        .backup = (access & ECT_ACCESS_BACKUP) != 0,
        .setting = (access & ECT_ACCESS_SETTING) != 0,
        .reported_access = {.given = true, .value = access & ECT_ACCESS_WIRE},
        .reported_bits = {.given = true, .value = entry->bits},
    };
}

/* SOES describes a text without a length: then the length is that of its value, at least one character. */
static uint32_t bits_of(const ect_esi_found_entry_t *entry)
{
    if (entry->bits > 0 || entry->type != ECT_TYPE_VISIBLE_STRING)
        return entry->bits;
    return entry->value.length > 1 ? 8 * (uint32_t)entry->value.length : 8;
}

static ect_esi_number_t number_of(ect_esi_bytes_t bytes)
{
    uint8_t wire[8] = {0};
    if (bytes.bytes == NULL || bytes.length == 0 || bytes.length > sizeof wire)
        return (ect_esi_number_t){.given = false};
    memcpy(wire, bytes.bytes, bytes.length);
    return (ect_esi_number_t){.given = true, .bytes = (uint8_t)bytes.length, .value = (int64_t)ect_load_le64(wire)};
}

void ect_esi_found_entry(ect_esi_t *esi, const ect_esi_found_entry_t *entry)
{
    char text[40] = "";
    ect_esi_dictionary_t *dictionary = &esi->device->dictionary;
    ECT_ASSERT(dictionary->type_count > 0);
    ect_esi_type_t *type = &((ect_esi_type_t *)OURS(dictionary->types))[dictionary->type_count - 1];
    ect_esi_item_t *items = ect_arena_grow(&esi->arena, OURS(type->items), type->item_count, sizeof *items);
    const uint32_t bits = bits_of(entry);
    const char *name = bits > 0 ? ect_esi_type_name(entry->type, bits, text, sizeof text) : "";
    const ect_esi_number_t unit = number_of(entry->unit);
    items[type->item_count++] = (ect_esi_item_t){
        .subindex = entry->subindex,
        .name = copy_text(esi, entry->name),
        .display = "",
        .type = copy_text(esi, name),
        .bits = bits,
        .flags = flags_of(entry),
        .info = {.initial = copy_bytes(esi, entry->value),
                 .minimum = number_of(entry->minimum),
                 .maximum = number_of(entry->maximum),
                 .unit = entry->unit.length == 2 ? (uint32_t)unit.value << 16 : (uint32_t)unit.value,
                 .name = "",
                 .display = ""},
    };
    type->items = items;
}

/* --- PDOs --------------------------------------------------------------------------------------------------------- */

static const ect_esi_type_t *type_at(const ect_esi_t *esi, uint16_t index)
{
    const ect_esi_dictionary_t *dictionary = &esi->device->dictionary;
    for (size_t i = 0; i < dictionary->object_count; i++) {
        if (dictionary->objects[i].index == index)
            return &dictionary->types[i];
    }
    return NULL;
}

static const ect_esi_item_t *item_at(const ect_esi_type_t *type, unsigned int subindex)
{
    for (size_t i = 0; type != NULL && i < type->item_count; i++) {
        if (type->items[i].subindex == (int)subindex)
            return &type->items[i];
    }
    return NULL;
}

/* @return the value of an element; 0: unknown */
static uint32_t element(const ect_esi_type_t *type, unsigned int subindex)
{
    uint8_t wire[4] = {0};
    const ect_esi_item_t *item = item_at(type, subindex);
    if (item == NULL || item->info.initial.bytes == NULL)
        return 0;
    memcpy(wire, item->info.initial.bytes, item->info.initial.length < 4 ? item->info.initial.length : 4);
    return ect_load_le32(wire);
}

/* @return the SyncManager to which a PDO is assigned; -1: none */
static int assigned_to(const ect_esi_t *esi, uint16_t pdo)
{
    for (int sm = 0; sm < ASSIGNMENTS; sm++) {
        const ect_esi_type_t *assignment = type_at(esi, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
        const uint32_t count = element(assignment, 0) & 0xFF;
        for (unsigned int i = 1; i <= count; i++) {
            if (element(assignment, i) == pdo)
                return sm;
        }
    }
    return NONE;
}

static const ect_esi_pdo_t *pdo_of_image(const ect_esi_pdo_t *pdos, size_t count, uint16_t index)
{
    for (size_t i = 0; i < count; i++) {
        if (pdos[i].index == index)
            return &pdos[i];
    }
    return NULL;
}

/* Sets name and type of an entry from the image, or else from the dictionary. */
static void describe_entry(const ect_esi_t *esi, const ect_esi_pdo_t *old, ect_esi_entry_t *entry)
{
    const ect_esi_item_t *item = item_at(type_at(esi, entry->index), entry->subindex);
    entry->name = item != NULL ? item->name : "";
    entry->type = item != NULL && item->bits == entry->bits ? item->type : "";
    for (size_t i = 0; old != NULL && i < old->entry_count; i++) {
        const ect_esi_entry_t *e = &old->entries[i];
        if (e->index != entry->index || e->subindex != entry->subindex || e->bits != entry->bits)
            continue;
        entry->name = *e->name != '\0' ? e->name : entry->name;
        entry->type = *entry->type == '\0' ? e->type : entry->type;
    }
}

static void make_pdo(ect_esi_t *esi, const ect_esi_object_t *object, const ect_esi_type_t *mapping,
                     const ect_esi_pdo_t *old, ect_esi_pdo_t *pdo)
{
    const size_t count = element(mapping, 0) & 0xFF;
    const ect_esi_item_t *zero = item_at(mapping, 0);
    ect_esi_entry_t *entries = ect_arena_alloc(&esi->arena, (count + 1) * sizeof *entries);
    for (size_t i = 0; i < count; i++) {
        const uint32_t value = element(mapping, (unsigned int)i + 1);
        entries[i] = (ect_esi_entry_t){
            .index = (uint16_t)(value >> 16), .subindex = (uint8_t)(value >> 8), .bits = value & 0xFF};
        describe_entry(esi, old, &entries[i]);
    }
    *pdo = (ect_esi_pdo_t){
        .index = object->index,
        .name = old != NULL && *old->name != '\0' ? old->name : object->name,
        .tx = ect_od_is_txpdo(object->index),
        .fixed = old != NULL ? old->fixed : strcmp(zero->flags.access, "ro") == 0,
        .mandatory = old != NULL && old->mandatory,
        .sm = assigned_to(esi, object->index),
        .samples = 1,
        .entries = entries,
        .entry_count = count,
    };
}

/* @return the PDO with an index, or else a new one after the others of its direction; outputs precede inputs */
static ect_esi_pdo_t *place_for(ect_esi_t *esi, uint16_t index)
{
    ect_esi_device_t *device = esi->device;
    ect_esi_pdo_t *pdos = OURS(device->pdos);
    size_t at = 0;
    for (size_t i = 0; i < device->pdo_count; i++) {
        if (pdos[i].index == index)
            return &pdos[i];
        at += ect_od_is_txpdo(index) || !pdos[i].tx;
    }
    pdos = ect_arena_grow(&esi->arena, pdos, device->pdo_count, sizeof *pdos);
    memmove(&pdos[at + 1], &pdos[at], (device->pdo_count - at) * sizeof *pdos);
    device->pdos = pdos;
    device->pdo_count++;
    return &pdos[at];
}

/* Removes the PDOs of the image from SyncManagers whose assignment was read. */
static void release(ect_esi_t *esi)
{
    ect_esi_pdo_t *pdos = OURS(esi->device->pdos);
    for (size_t i = 0; i < esi->device->pdo_count; i++) {
        const ect_esi_type_t *assignment =
            pdos[i].sm >= 0 ? type_at(esi, (uint16_t)(ECT_OD_ASSIGNMENT + pdos[i].sm)) : NULL;
        const ect_esi_item_t *count = item_at(assignment, 0);
        if (count != NULL && count->info.initial.bytes != NULL)
            pdos[i].sm = assigned_to(esi, pdos[i].index);
    }
}

static void replace_pdos(ect_esi_t *esi)
{
    const ect_esi_dictionary_t *dictionary = &esi->device->dictionary;
    release(esi);
    for (size_t i = 0; i < dictionary->object_count; i++) {
        const ect_esi_object_t *object = &dictionary->objects[i];
        const ect_esi_item_t *zero = item_at(&dictionary->types[i], 0);
        if ((!ect_od_is_txpdo(object->index) && !ect_od_is_rxpdo(object->index)) || zero == NULL ||
            zero->info.initial.bytes == NULL)
            continue;
        const ect_esi_pdo_t *old = pdo_of_image(esi->device->pdos, esi->device->pdo_count, object->index);
        ect_esi_pdo_t pdo;
        make_pdo(esi, object, &dictionary->types[i], old, &pdo);
        *place_for(esi, object->index) = pdo;
    }
}

/* --- the dictionary ----------------------------------------------------------------------------------------------- */

static int compare_names(const void *a, const void *b)
{
    return strcmp((*(const ect_esi_type_t *const *)a)->name, (*(const ect_esi_type_t *const *)b)->name);
}

static bool same_flags(const ect_esi_flags_t *a, const ect_esi_flags_t *b)
{
    return strcmp(a->access, b->access) == 0 && strcmp(a->read_in, b->read_in) == 0 &&
           strcmp(a->write_in, b->write_in) == 0 && strcmp(a->mapping, b->mapping) == 0 && a->backup == b->backup &&
           a->setting == b->setting && a->reported_access.value == b->reported_access.value &&
           a->reported_bits.value == b->reported_bits.value;
}

/* @return whether elements 1 to the last have the same type and access rights, as in an array of an ESI file */
static bool is_array(const ect_esi_type_t *type)
{
    if (type->item_count < 2 || type->items[0].subindex != 0)
        return false;
    const ect_esi_item_t *first = &type->items[1];
    for (size_t i = 1; i < type->item_count; i++) {
        const ect_esi_item_t *item = &type->items[i];
        if (item->subindex != (int)i || item->bits != first->bits || strcmp(item->type, first->type) != 0 ||
            !same_flags(&item->flags, &first->flags))
            return false;
    }
    return true;
}

/* Makes an array. Names of elements become display names; their values are part of the object. */
static void make_array(ect_esi_t *esi, ect_esi_object_t *object, ect_esi_type_t *type, ect_esi_type_t *elements)
{
    const size_t count = type->item_count;
    ect_esi_info_t *infos = ect_arena_alloc(&esi->arena, count * sizeof *infos);
    ect_esi_item_t *items = ect_arena_alloc(&esi->arena, 2 * sizeof *items);
    for (size_t i = 0; i < count; i++) {
        infos[i] = type->items[i].info;
        infos[i].name = ect_arena_print(&esi->arena, "SubIndex %03zu", i);
        infos[i].display = type->items[i].name;
    }
    *elements = (ect_esi_type_t){
        .name = ect_arena_print(&esi->arena, "%sARR", type->name),
        .base = type->items[1].type,
        .bits = (uint32_t)(count - 1) * type->items[1].bits,
        .first = {.given = true, .value = 1},
        .elements = {.given = true, .value = (int64_t)count - 1},
    };
    items[0] = type->items[0];
    items[1] = type->items[1];
    items[1].subindex = -1;
    items[1].name = "Elements";
    items[1].type = elements->name;
    items[1].bits = elements->bits;
    items[1].info = (ect_esi_info_t){.name = "", .display = ""};
    type->items = items;
    type->item_count = 2;
    object->items = infos;
    object->item_count = count;
}

/* Sets the type: of a single value that of its entry, else a type of its own. An entry of another name than its object
 * has it as display name. */
static void finish_object(uint8_t code, ect_esi_object_t *object, ect_esi_type_t *type)
{
    if (code == ECT_OBJECT_VAR && type->item_count == 1 && type->items[0].subindex == 0) {
        const ect_esi_item_t *item = &type->items[0];
        object->type = item->type;
        object->bits = item->bits;
        object->flags = item->flags;
        object->info = item->info;
        if (*item->name != '\0' && strcmp(item->name, object->name) != 0)
            object->info.display = item->name;
        type->item_count = 0;
    } else {
        object->type = type->name;
    }
}

void ect_esi_found_end(ect_esi_t *esi)
{
    ect_esi_dictionary_t *dictionary = &esi->device->dictionary;
    ect_esi_object_t *objects = OURS(dictionary->objects);
    const ect_esi_type_t *read = dictionary->types;
    const size_t count = dictionary->object_count;
    ect_esi_type_t *types = ect_arena_alloc(&esi->arena, (2 * count + 1) * sizeof *types);
    const ect_esi_type_t **by_name = ect_arena_alloc(&esi->arena, (2 * count + 1) * sizeof *by_name);
    size_t used = 0, kept = 0;
    replace_pdos(esi);
    for (size_t i = 0; i < count; i++) {
        if (!esi->found[i].described || read[i].item_count == 0)
            continue; /* without types and rights */
        ect_esi_object_t *object = &objects[kept++];
        ect_esi_type_t *type = &types[used++];
        *object = objects[i];
        *type = read[i];
        if (esi->found[i].code == ECT_OBJECT_ARRAY && is_array(type))
            make_array(esi, object, type, &types[used++]);
        finish_object(esi->found[i].code, object, type);
    }
    for (size_t i = 0; i < used; i++)
        by_name[i] = &types[i];
    if (used > 0)
        qsort(by_name, used, sizeof *by_name, compare_names);
    dictionary->types = types;
    dictionary->types_by_name = by_name;
    dictionary->type_count = used;
    dictionary->object_count = kept;
}
