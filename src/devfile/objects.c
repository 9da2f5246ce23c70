/* SPDX-License-Identifier: MIT */
/* `objects`: index by index, a value, an array or a record. */
#include "devfile/internal.h"

#include <string.h>

enum { ELEMENTS_MOST = 254 };

/* Keys of an object, or of one of its entries, that are being read. */
typedef struct keys {
    ect_draft_t *d;
    bool inner; /* an entry of a record */
    ect_word_t words[ECT_WORDS];
    const yaml_node_t *subindex, *array, *entries, *bits, *values;
    const yaml_node_t *initial; /* a list of defaults; NULL: one word, or none */
} keys_t;

static bool take_word(keys_t *k, const char *key, const yaml_node_t *value)
{
    for (size_t i = 0; i < ECT_WORDS; i++) {
        if (strcmp(ect_word_names[i], key) != 0)
            continue;
        if (i == ECT_WORD_DEFAULT && value->type == YAML_SEQUENCE_NODE)
            k->initial = value;
        else
            k->words[i] = ect_draft_word(k->d, value, key);
        return true;
    }
    return false;
}

static void take_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    keys_t *k = ctx;
    const struct {
        const char *name;
        const yaml_node_t **node;
        bool inner, outer;
    } nodes[] = {
        {"bits", &k->bits, true, true},          {"values", &k->values, true, true},
        {"subindex", &k->subindex, true, false}, {"array", &k->array, false, true},
        {"entries", &k->entries, false, true},
    };
    if (take_word(k, key, value))
        return;
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; i++) {
        if (strcmp(nodes[i].name, key) != 0 || !(k->inner ? nodes[i].inner : nodes[i].outer))
            continue;
        *nodes[i].node = value;
        return;
    }
    ect_yaml_fail(&k->d->yaml, name,
                  "'%.60s' is no key of an %s: name, type, access, default, min, max, unit, bits, values, write-in, "
                  "backup, setting, %s",
                  key, k->inner ? "entry" : "object", k->inner ? "subindex" : "array, entries");
}

static void read_keys(keys_t *k, const yaml_node_t *node)
{
    ect_yaml_each(&k->d->yaml, node, k->inner ? "an entry" : "an object", true, take_key, k);
}

/* --- kinds of objects --------------------------------------------------------------------------------------------- */

static void add_value(keys_t *k, size_t line)
{
    ect_draft_entry_t entry;
    if (k->initial != NULL)
        ect_yaml_fail(&k->d->yaml, k->initial, "a list in 'default' is for an 'array'");
    ect_draft_words(k->d, &entry, k->words, line);
    if (k->d->mistake.failed)
        return;
    ect_draft_values(k->d, k->values, &entry);
    ect_draft_bits(k->d, k->bits, &entry);
    (void)ect_draft_entry(k->d, 0, &entry);
}

static void add_element(keys_t *k, const ect_draft_entry_t *from, unsigned int n)
{
    ect_draft_t *d = k->d;
    ect_draft_entry_t entry = *from;
    if (k->initial != NULL) {
        const yaml_node_t *item = ect_yaml_node(&d->yaml, k->initial->data.sequence.items.start[n - 1]);
        ect_draft_default(d, &entry, ect_draft_word(d, item, "default"));
    }
    if (k->values != NULL || k->bits != NULL)
        ect_yaml_fail(&d->yaml, k->values != NULL ? k->values : k->bits,
                      "'bits' and 'values' are for single values: write 'entries' in place of 'array'");
    if (!d->mistake.failed)
        (void)ect_draft_entry(d, (uint8_t)n, &entry);
}

static void add_array(keys_t *k, size_t line)
{
    ect_draft_t *d = k->d;
    ect_draft_entry_t entry;
    size_t count = (size_t)ect_draft_number(d, "array", ect_draft_word(d, k->array, "array"), 1, ELEMENTS_MOST);
    size_t given = 0;
    if (k->initial != NULL)
        given = (size_t)(k->initial->data.sequence.items.top - k->initial->data.sequence.items.start);
    if (k->initial != NULL && given != count)
        ect_yaml_fail(&d->yaml, k->initial, "'default' has %zu values, 'array' %zu elements: give each its own", given,
                      count);
    ect_draft_words(d, &entry, k->words, line);
    for (unsigned int n = 1; n <= count && !d->mistake.failed; n++) {
        entry.name = ect_arena_print(d->arena, "%.200s %u", d->objects[d->object_count - 1].name, n);
        add_element(k, &entry, n);
    }
}

static void add_entry(ect_draft_t *d, const yaml_node_t *node, unsigned int next, unsigned int *subindex)
{
    keys_t k = {.d = d, .inner = true};
    ect_draft_entry_t entry;
    read_keys(&k, node);
    *subindex = next;
    if (k.initial != NULL)
        ect_yaml_fail(&d->yaml, k.initial, "a list in 'default' is for an 'array'");
    if (k.words[ECT_WORD_NAME].text == NULL)
        ect_yaml_fail(&d->yaml, node, "'name' is missing");
    if (!d->mistake.failed && k.subindex != NULL)
        *subindex =
            (unsigned int)ect_draft_number(d, "subindex", ect_draft_word(d, k.subindex, "subindex"), 1, ELEMENTS_MOST);
    if (*subindex > ELEMENTS_MOST)
        ect_yaml_fail(&d->yaml, node, "more than %d entries: split the object", (int)ELEMENTS_MOST);
    if (d->mistake.failed)
        return;
    ect_draft_words(d, &entry, k.words, ect_yaml_line(node));
    entry.subindex = (uint8_t)*subindex;
    if (d->mistake.failed)
        return;
    ect_draft_values(d, k.values, &entry);
    ect_draft_bits(d, k.bits, &entry);
    (void)ect_draft_entry(d, (uint8_t)*subindex, &entry);
}

static void add_entries(keys_t *k)
{
    ect_draft_t *d = k->d;
    const yaml_node_t *list = k->entries;
    unsigned int subindex = 0;
    for (size_t i = 0; i < ECT_WORDS; i++) {
        if (k->words[i].text != NULL && i != ECT_WORD_NAME)
            ect_mistake(&d->mistake, k->words[i].line, "'%s' belongs to each of the 'entries'", ect_word_names[i]);
    }
    if (list->type != YAML_SEQUENCE_NODE || list->data.sequence.items.start == list->data.sequence.items.top ||
        k->array != NULL || k->bits != NULL || k->values != NULL)
        ect_yaml_fail(&d->yaml, list, "'entries' takes a list, '- {name: Speed, type: INT}' each, beside 'name' alone");
    if (d->mistake.failed)
        return;
    for (const yaml_node_item_t *i = list->data.sequence.items.start; i < list->data.sequence.items.top; i++) {
        if (!d->mistake.failed)
            add_entry(d, ect_yaml_node(&d->yaml, *i), subindex + 1, &subindex);
    }
}

static void take_object(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    keys_t k = {.d = d};
    read_keys(&k, value);
    const ect_word_t title = k.words[ECT_WORD_NAME];
    const uint8_t code = k.entries != NULL ? ECT_OBJECT_RECORD : k.array != NULL ? ECT_OBJECT_ARRAY : ECT_OBJECT_VAR;
    if (title.text == NULL || *title.text == '\0')
        ect_yaml_fail(&d->yaml, name, "object %.60s has no 'name'", key);
    if (d->mistake.failed ||
        ect_draft_add(d, (ect_word_t){.text = key, .line = ect_yaml_line(name)}, code, title.text) == NULL)
        return;
    if (code == ECT_OBJECT_RECORD)
        add_entries(&k);
    else if (code == ECT_OBJECT_ARRAY)
        add_array(&k, ect_yaml_line(name));
    else
        add_value(&k, ect_yaml_line(name));
}

void ect_draft_objects(ect_draft_t *d, const yaml_node_t *objects)
{
    if (objects->type == YAML_SCALAR_NODE)
        ect_draft_table(d, ect_draft_word(d, objects, "objects"));
    else
        ect_yaml_each(&d->yaml, objects, "objects", false, take_object, d);
}
