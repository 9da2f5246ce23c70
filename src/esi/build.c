/* SPDX-License-Identifier: MIT */
#include "esi/internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Counts of details and signals in a description have 16 bits. */
enum { MOST_ENTRIES = UINT16_MAX };

const ect_build_steps_t ect_build_device = {0};

static uint16_t moved(uint16_t index, uint8_t moves, uint32_t with_slot, uint32_t with_group)
{
    return (uint16_t)(index + ((moves & ECT_ESI_BY_SLOT) != 0 ? with_slot : 0) +
                      ((moves & ECT_ESI_BY_GROUP) != 0 ? with_group : 0));
}

uint16_t ect_build_index(uint16_t index, uint8_t moves, const ect_build_steps_t *steps)
{
    return moved(index, moves, steps->slot_index, steps->group_index);
}

uint16_t ect_build_pdo_index(uint16_t index, uint8_t moves, const ect_build_steps_t *steps)
{
    return moved(index, moves, steps->slot_pdo, steps->group_pdo);
}

static const char *print(ect_build_t *build, const char *format, va_list arguments)
{
    char line[400];
    (void)vsnprintf(line, sizeof line, format, arguments);
    return ect_arena_copy(build->arena, line, strlen(line));
}

void ect_build_note(ect_build_t *build, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const char *line = print(build, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < build->note_count; i++) {
        if (strcmp(build->note_kinds[i].format, format) == 0) {
            build->note_kinds[i].repeated += strcmp(build->notes[i], line) != 0;
            return;
        }
    }
    build->notes = ect_arena_grow(build->arena, build->notes, build->note_count, sizeof *build->notes);
    build->note_kinds = ect_arena_grow(build->arena, build->note_kinds, build->note_count, sizeof *build->note_kinds);
    build->note_kinds[build->note_count] = (ect_build_note_kind_t){.format = format};
    build->notes[build->note_count++] = line;
}

void ect_build_count_notes(ect_build_t *build)
{
    for (size_t i = 0; i < build->note_count; i++) {
        if (build->note_kinds[i].repeated > 0)
            build->notes[i] = ect_arena_print(build->arena, "%s (and %zu more like it)", build->notes[i],
                                              build->note_kinds[i].repeated);
    }
}

void ect_build_fail(ect_build_t *build, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (build->failure == NULL)
        build->failure = print(build, format, arguments);
    va_end(arguments);
}

/* Characters beyond ISO 646 in names, and their replacements. */
static const struct {
    const char *utf8, *plain;
} spellings[] = {
    {"\u00E4", "ae"},  {"\u00F6", "oe"}, {"\u00FC", "ue"},  {"\u00C4", "Ae"}, {"\u00D6", "Oe"},
    {"\u00DC", "Ue"},  {"\u00DF", "ss"}, {"\u00B5", "u"},   {"\u03BC", "u"},  {"\u00B0", "deg"},
    {"\u03A9", "Ohm"}, {"\u2013", "-"},  {"\u00B1", "+/-"}, {"\u00B2", "2"},  {"\u00B3", "3"},
};

/* @param[out] plain  the replacement @return bytes of the character at `text` */
static size_t spell(const char *text, const char **plain)
{
    for (size_t i = 0; i < sizeof spellings / sizeof spellings[0]; i++) {
        size_t length = strlen(spellings[i].utf8);
        if (strncmp(text, spellings[i].utf8, length) == 0) {
            *plain = spellings[i].plain;
            return length;
        }
    }
    size_t length = 1;
    while (((unsigned char)text[length] & 0xC0) == 0x80)
        length++;
    *plain = (unsigned char)*text < 0x80 ? " " : "?"; // a control character, as a line feed, separates words
    return length;
}

char ect_build_plain(char c)
{
    if (c >= 'A' && c <= 'Z')
        return (char)(c - 'A' + 'a');
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '\0';
}

const char *ect_build_text(ect_build_t *build, const char *text, size_t longest)
{
    char *result = ect_arena_alloc(build->arena, longest + 1);
    size_t length = 0;
    while (*text != '\0' && length < longest) {
        const char *plain = NULL;
        if (*text >= ' ' && *text <= '~') {
            result[length++] = *text++;
            continue;
        }
        text += spell(text, &plain);
        for (; *plain != '\0' && length < longest; plain++)
            result[length++] = *plain;
    }
    return result;
}

ect_build_object_t *ect_build_find(const ect_build_t *build, uint16_t index)
{
    uint32_t position = build->positions != NULL ? build->positions[index] : 0;
    ECT_ASSERT(position <= build->object_count);
    return position > 0 ? &build->objects[position - 1] : NULL;
}

ect_build_object_t *ect_build_object(ect_build_t *build, uint16_t index, uint16_t code, const char *name)
{
    ECT_ASSERT(ect_build_find(build, index) == NULL);
    if (build->positions == NULL)
        build->positions = ect_arena_alloc(build->arena, (UINT16_MAX + 1) * sizeof *build->positions);
    build->objects = ect_arena_grow(build->arena, build->objects, build->object_count, sizeof *build->objects);
    ect_build_object_t *object = &build->objects[build->object_count++];
    build->positions[index] = (uint32_t)build->object_count;
    *object = (ect_build_object_t){
        .index = index, .code = code, .name = ect_build_text(build, name, ECT_BUILD_TEXT), .module = build->module};
    return object;
}

void ect_build_drop_last(ect_build_t *build)
{
    ECT_ASSERT(build->object_count > 0);
    build->positions[build->objects[--build->object_count].index] = 0;
}

ect_build_entry_t *ect_build_entry(const ect_build_object_t *object, uint8_t subindex)
{
    for (size_t i = 0; i < object->count; i++) {
        if (object->entries[i].subindex == subindex)
            return &object->entries[i];
    }
    return NULL;
}

ect_build_entry_t *ect_build_add(ect_build_t *build, ect_build_object_t *object, uint8_t subindex, uint16_t data_type,
                                 uint32_t bits, uint16_t access, const char *name)
{
    ECT_ASSERT(ect_build_entry(object, subindex) == NULL);
    if (++build->entry_count > MOST_ENTRIES)
        ect_build_fail(build, "its dictionary has more than the %u entries that a twin can have",
                       (unsigned int)MOST_ENTRIES);
    object->entries = ect_arena_grow(build->arena, object->entries, object->count, sizeof *object->entries);
    ect_build_entry_t *entry = &object->entries[object->count++];
    *entry = (ect_build_entry_t){.subindex = subindex,
                                 .data_type = data_type,
                                 .bits = (uint16_t)(bits <= UINT16_MAX ? bits : UINT16_MAX / 8 * 8),
                                 .access = access,
                                 .name = ect_build_text(build, name, ECT_BUILD_TEXT)};
    if (bits > UINT16_MAX)
        ect_build_note(build, "object %04X:%u has %u bytes; the twin has its first %u", (unsigned int)object->index,
                       (unsigned int)subindex, (unsigned int)(bits / 8), (unsigned int)entry->bits / 8);
    return entry;
}

void ect_build_initial(ect_build_t *build, ect_build_entry_t *entry, uint64_t value)
{
    ECT_ASSERT(entry->bits > 0 && entry->bits <= 64);
    uint8_t *bytes = ect_arena_alloc(build->arena, 8);
    for (unsigned int i = 0; i < 8; i++)
        bytes[i] = (uint8_t)(value >> 8 * i);
    entry->initial = (ect_esi_bytes_t){.bytes = bytes, .length = (entry->bits + 7u) / 8u};
}

bool ect_build_is_signed(uint16_t data_type)
{
    return data_type == ECT_TYPE_INTEGER8 || data_type == ECT_TYPE_INTEGER16 || data_type == ECT_TYPE_INTEGER32 ||
           data_type == ECT_TYPE_INTEGER64;
}

bool ect_build_range(const ect_build_entry_t *entry, int64_t *minimum, int64_t *maximum)
{
    bool bytes = entry->data_type == ECT_TYPE_VISIBLE_STRING || entry->data_type == ECT_TYPE_OCTET_STRING;
    bool real = entry->data_type == ECT_TYPE_REAL32 || entry->data_type == ECT_TYPE_REAL64;
    if (bytes || real)
        return false;
    ECT_ASSERT(entry->bits > 0 && entry->bits <= 64);
    bool is_signed = ect_build_is_signed(entry->data_type);
    unsigned int magnitude = entry->bits - (is_signed ? 1u : 0u);
    *maximum = magnitude < 63 ? (INT64_C(1) << magnitude) - 1 : INT64_MAX;
    *minimum = is_signed ? -*maximum - 1 : 0;
    return true;
}

uint64_t ect_build_number(const ect_build_entry_t *entry)
{
    uint64_t value = 0;
    size_t length = entry->initial.length < 8 ? entry->initial.length : 8;
    for (size_t i = length; i-- > 0;)
        value = value << 8 | entry->initial.bytes[i];
    return value;
}

/* @return the name of an element in the file; NULL: only a placeholder */
static const char *given_name(const ect_build_object_t *object, uint8_t subindex)
{
    const ect_build_entry_t *entry = ect_build_entry(object, subindex);
    return entry != NULL && strncmp(entry->name, "SubIndex ", 9) != 0 ? entry->name : NULL;
}

ect_build_object_t *ect_build_numbers(ect_build_t *build, uint16_t index, const char *name, const char *element,
                                      uint16_t data_type, uint16_t access, const uint32_t *values, size_t count,
                                      size_t capacity)
{
    ECT_ASSERT(count <= capacity && capacity <= UINT8_MAX);
    uint32_t bits = data_type == ECT_TYPE_UNSIGNED8 ? 8 : data_type == ECT_TYPE_UNSIGNED16 ? 16 : 32;
    ect_build_object_t *object = ect_build_find(build, index);
    if (object == NULL)
        object = ect_build_object(build, index, ECT_OBJECT_ARRAY, name);
    if (*name != '\0')
        object->name = ect_build_text(build, name, ECT_BUILD_TEXT);
    ect_build_object_t before = *object;
    object->code = data_type == ECT_TYPE_UNSIGNED32 ? ECT_OBJECT_RECORD : ECT_OBJECT_ARRAY;
    object->entries = NULL;
    object->count = 0;
    object->complete = true;
    ect_build_entry_t *entry = ect_build_add(build, object, 0, ECT_TYPE_UNSIGNED8, 8, access, "Number of entries");
    ect_build_initial(build, entry, count);
    for (size_t i = 0; i < capacity; i++) {
        const char *said = given_name(&before, (uint8_t)(i + 1));
        entry = ect_build_add(build, object, (uint8_t)(i + 1), data_type, bits, access, said != NULL ? said : element);
        ect_build_initial(build, entry, i < count ? values[i] : 0);
    }
    return object;
}

static int compare_objects(const void *a, const void *b)
{
    return (int)((const ect_build_object_t *)a)->index - (int)((const ect_build_object_t *)b)->index;
}

static int compare_entries(const void *a, const void *b)
{
    return (int)((const ect_build_entry_t *)a)->subindex - (int)((const ect_build_entry_t *)b)->subindex;
}

/* Adds sub-index 0 to a record that is incomplete in the dictionary, unless a PDO or a start-up command has added it.
 */
static void count_entries(ect_build_t *build, ect_build_object_t *object)
{
    ect_build_entry_t *zero = ect_build_entry(object, 0);
    uint8_t highest = 0;
    for (size_t k = 0; k < object->count; k++)
        highest = object->entries[k].subindex > highest ? object->entries[k].subindex : highest;
    if (zero == NULL)
        zero = ect_build_add(build, object, 0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Number of entries");
    zero->data_type = ECT_TYPE_UNSIGNED8;
    zero->bits = 8;
    ect_build_initial(build, zero, highest);
}

void ect_build_sort(ect_build_t *build)
{
    for (size_t i = 0; i < build->object_count; i++) {
        ect_build_object_t *object = &build->objects[i];
        if (object->code != ECT_OBJECT_VAR && !object->complete)
            count_entries(build, object);
        qsort(object->entries, object->count, sizeof *object->entries, compare_entries);
    }
    if (build->object_count > 0)
        qsort(build->objects, build->object_count, sizeof *build->objects, compare_objects);
    for (size_t i = 0; i < build->object_count; i++) {
        ECT_ASSERT(i == 0 || build->objects[i - 1].index < build->objects[i].index);
        build->positions[build->objects[i].index] = (uint32_t)i + 1;
    }
}

void ect_build_service(ect_build_t *build, ect_device_t *device, const ect_service_t *service)
{
    size_t count = 0;
    while (device->services != NULL && device->services[count] != NULL)
        count++;
    const ect_service_t **services = ect_arena_alloc(build->arena, (count + 2) * sizeof *services);
    for (size_t i = 0; i < count; i++)
        services[i] = device->services[i];
    services[count] = service;
    device->services = services;
}
