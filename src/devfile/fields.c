/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
/* Names of bits and of values. */
#include "devfile/internal.h"

#include <inttypes.h>
#include <string.h>

#include "esi/number.h"

/* A list of names that is being read. */
typedef struct list list_t;
struct list {
    ect_draft_t *d;
    void (*take)(list_t *list, const char *key, ect_word_t name);
    const ect_draft_entry_t *entry;
    uint16_t index;
    uint64_t taken; /* bits with a name */
    ect_value_name_t *values;
    size_t count;
};

static const char *name_of(ect_draft_t *d, const char *key, ect_word_t word)
{
    size_t length = strlen(word.text);
    bool fine = length > 0 && length <= 60;
    for (size_t i = 0; i < length; i++)
        fine = fine && word.text[i] >= ' ' && word.text[i] <= '~';
    if (!fine)
        ect_mistake(&d->mistake, word.line, "'%.60s' takes a name of 1 to 60 characters of ISO 646 (ASCII)", key);
    return ect_arena_copy(d->arena, word.text, length);
}

static ect_field_t *add_field(const list_t *list)
{
    ect_draft_t *d = list->d;
    d->fields = ect_arena_grow(d->arena, d->fields, d->field_count, sizeof *d->fields);
    ect_field_t *field = &d->fields[d->field_count++];
    *field = (ect_field_t){.index = list->index, .subindex = list->entry->subindex};
    return field;
}

/* Reads "3" or "4-7". @return false: another text, or a bit beyond the entry */
static bool bits_of(const char *key, unsigned int bits, unsigned int *first, unsigned int *last)
{
    char text[8];
    int64_t low, high;
    const char *dash = strchr(key, '-');
    size_t length = dash != NULL ? (size_t)(dash - key) : strlen(key);
    if (length >= sizeof text)
        return false;
    memcpy(text, key, length);
    text[length] = '\0';
    if (!ect_esi_parse_number(text, &low))
        return false;
    high = low;
    if (dash != NULL && !ect_esi_parse_number(dash + 1, &high))
        return false;
    *first = (unsigned int)low;
    *last = (unsigned int)high;
    return low >= 0 && low <= high && high < bits;
}

static void take_bits(list_t *list, const char *key, ect_word_t name)
{
    unsigned int first, last;
    const char *text = name_of(list->d, key, name);
    if (!bits_of(key, list->entry->bits, &first, &last)) {
        ect_mistake(&list->d->mistake, name.line, "'%.60s' is no bit of %u: 0 to %u, several as \"4-7\"", key,
                    (unsigned int)list->entry->bits, list->entry->bits - 1u);
        return;
    }
    uint64_t mask = (last - first == 63 ? UINT64_MAX : (UINT64_C(1) << (last - first + 1)) - 1) << first;
    if ((list->taken & mask) != 0)
        ect_mistake(&list->d->mistake, name.line, "'%.60s' has a bit that has a name already", key);
    list->taken |= mask;
    ect_field_t *field = add_field(list);
    field->bit = (uint8_t)first;
    field->width = (uint8_t)(last - first + 1);
    field->name = text;
}

static void take_value(list_t *list, const char *key, ect_word_t name)
{
    ect_draft_t *d = list->d;
    const ect_word_t word = {.text = key, .line = name.line};
    const char *text = name_of(d, key, name);
    int64_t number = ect_draft_number(d, "values", word, INT64_MIN, INT64_MAX);
    if (list->count > 0 && number <= list->values[list->count - 1].value)
        ect_mistake(&d->mistake, name.line, "'values' must ascend, without duplicates: move %.60s", key);
    list->values = ect_arena_grow(d->arena, list->values, list->count, sizeof *list->values);
    list->values[list->count++] = (ect_value_name_t){.value = number, .name = text};
}

/* Sets the lowest and the highest value as limits of the entry if all values have names. */
static void limit(const list_t *list, size_t line, ect_draft_entry_t *entry)
{
    const int64_t lowest = list->values[0].value, highest = list->values[list->count - 1].value;
    int64_t least, most;
    ect_draft_range(entry, &least, &most);
    if (lowest < least || highest > most)
        ect_mistake(&list->d->mistake, line,
                    "'values' has a value beyond the range of the entry: choose another 'type'");
    if (!entry->limited) {
        entry->minimum = lowest;
        entry->maximum = highest;
    }
    entry->limited = true;
}

static void end_values(list_t *list, size_t line, ect_draft_entry_t *entry)
{
    ect_draft_t *d = list->d;
    if (list->count < 2)
        ect_mistake(&d->mistake, line, "'values' takes at least two: {0: OFF, 1: ON}");
    if (d->mistake.failed)
        return;
    list->values = ect_arena_grow(d->arena, list->values, list->count, sizeof *list->values);
    add_field(list)->values = list->values; /* a zeroed element ends the list */
    limit(list, line, entry);
}

/* --- from YAML ---------------------------------------------------------------------------------------------------- */

static bool begin(list_t *list, const char *key, size_t line)
{
    if (!ect_draft_is_integer(list->entry))
        ect_mistake(&list->d->mistake, line, "'%s' is for integers: leave it out", key);
    if (list->d->moves != 0)
        ect_mistake(&list->d->mistake, line, "'%s' is for objects of the device: leave it out of a module", key);
    return !list->d->mistake.failed;
}

static void take_pair(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    list_t *list = ctx;
    ect_word_t word = ect_draft_word(list->d, value, key);
    word.line = ect_yaml_line(name);
    if (!list->d->mistake.failed)
        list->take(list, key, word);
}

void ect_draft_bits(ect_draft_t *d, const yaml_node_t *bits, const ect_draft_entry_t *entry)
{
    list_t list = {.d = d, .take = take_bits, .entry = entry, .index = d->objects[d->object_count - 1].index};
    if (bits != NULL && begin(&list, "bits", ect_yaml_line(bits)))
        ect_yaml_each(&d->yaml, bits, "bits", false, take_pair, &list);
}

void ect_draft_values(ect_draft_t *d, const yaml_node_t *values, ect_draft_entry_t *entry)
{
    list_t list = {.d = d, .take = take_value, .entry = entry, .index = d->objects[d->object_count - 1].index};
    if (values == NULL || !begin(&list, "values", ect_yaml_line(values)))
        return;
    ect_yaml_each(&d->yaml, values, "values", false, take_pair, &list);
    end_values(&list, ect_yaml_line(values), entry);
}

/* --- from a cell of a table --------------------------------------------------------------------------------------- */

/* "0=READY; 4-7=GEAR" */
static void take_cell(list_t *list, const char *key, ect_word_t cell)
{
    ect_draft_t *d = list->d;
    char *copy = ect_arena_copy(d->arena, cell.text, strlen(cell.text));
    char *rest = NULL;
    for (char *one = strtok_r(copy, ";,", &rest); one != NULL && !d->mistake.failed;
         one = strtok_r(NULL, ";,", &rest)) {
        char *equals = strchr(one, '=');
        one += strspn(one, " ");
        if (equals == NULL) {
            ect_mistake(&d->mistake, cell.line, "'%s' takes NUMBER=NAME, separated by ';', not '%.60s'", key, one);
            return;
        }
        *equals = '\0';
        list->take(list, one, (ect_word_t){.text = equals + 1, .line = cell.line});
    }
}

void ect_draft_cells(ect_draft_t *d, ect_word_t bits, ect_word_t values, ect_draft_entry_t *entry)
{
    list_t list = {.d = d, .entry = entry, .index = d->objects[d->object_count - 1].index};
    if (*values.text != '\0' && begin(&list, "values", values.line)) {
        list.take = take_value;
        take_cell(&list, "values", values);
        end_values(&list, values.line, entry);
    }
    if (*bits.text != '\0' && begin(&list, "bits", bits.line)) {
        list.take = take_bits;
        take_cell(&list, "bits", bits);
    }
}
