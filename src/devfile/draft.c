/* SPDX-License-Identifier: MIT */
/* Objects of a file, kept until their rights are known, and the model made of them. */
#include "devfile/internal.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "esi/image.h"
#include "esi/number.h"
#include "esi/single.h"
#include "esi/types.h"
#include "od/pdo.h"
#include "wire/bytes.h"

enum { INDICES = 0x10000, LOWEST_INDEX = 0x1000, GAP_MOST = 255 /* bits of an entry of a mapping */ };

ect_word_t ect_draft_word(ect_draft_t *d, const yaml_node_t *node, const char *key)
{
    return (ect_word_t){.text = ect_yaml_scalar(&d->yaml, node, key), .line = ect_yaml_line(node)};
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

const char *ect_draft_reserved(uint16_t index)
{
    if (index == 0x1000)
        return "the key 'profile' has the device type";
    if (index == 0x1001)
        return "the twin itself keeps the error register";
    if (index == 0x1018)
        return "the keys 'vendor', 'product' and 'revision' have the identity";
    if (ect_od_is_rxpdo(index) || ect_od_is_txpdo(index) || (index >= 0x1C00 && index < 0x1C30))
        return "the keys 'inputs', 'outputs' and 'syncmanagers' make it";
    return NULL;
}

ect_draft_object_t *ect_draft_find(const ect_draft_t *d, uint16_t index)
{
    uint32_t position = d->positions != NULL ? d->positions[index] : 0;
    return position > 0 ? &d->objects[position - 1] : NULL;
}

ect_draft_object_t *ect_draft_add(ect_draft_t *d, ect_word_t word, uint8_t code, const char *name)
{
    int64_t number;
    if (!ect_esi_parse_number(word.text, &number) || number < LOWEST_INDEX || number >= INDICES) {
        ect_mistake(&d->mistake, word.line, "'%.60s' is no index of an object: 0x1000 to 0xFFFF, as 0x6000", word.text);
        return NULL;
    }
    uint16_t index = (uint16_t)number;
    const ect_draft_object_t *first = ect_draft_find(d, index);
    if (ect_draft_reserved(index) != NULL)
        ect_mistake(&d->mistake, word.line, "object %04X is left out here: %s", (unsigned int)index,
                    ect_draft_reserved(index));
    if (first != NULL)
        ect_mistake(&d->mistake, word.line, "object %04X occurs twice, first in line %zu: give one another index",
                    (unsigned int)index, first->line);
    if (d->mistake.failed)
        return NULL;
    if (d->positions == NULL)
        d->positions = ect_arena_alloc(d->arena, INDICES * sizeof *d->positions);
    d->objects = ect_arena_grow(d->arena, d->objects, d->object_count, sizeof *d->objects);
    ect_draft_object_t *object = &d->objects[d->object_count++];
    d->positions[index] = (uint32_t)d->object_count;
    *object = (ect_draft_object_t){
        .index = index, .code = code, .name = ect_arena_copy(d->arena, name, strlen(name)), .line = word.line};
    return object;
}

static void check_default(ect_draft_t *d, const ect_draft_object_t *object, uint8_t subindex,
                          const ect_draft_entry_t *entry)
{
    if (!entry->limited)
        return;
    int64_t value = ect_draft_initial(entry);
    if (value < entry->minimum || value > entry->maximum)
        ect_mistake(&d->mistake, entry->line,
                    "the default %" PRId64 " of %04X:%u is not within its limits %" PRId64 " to %" PRId64
                    ": write 'default'",
                    value, (unsigned int)object->index, (unsigned int)subindex, entry->minimum, entry->maximum);
}

ect_draft_entry_t *ect_draft_entry(ect_draft_t *d, uint8_t subindex, const ect_draft_entry_t *entry)
{
    ECT_ASSERT(d->object_count > 0);
    ect_draft_object_t *object = &d->objects[d->object_count - 1];
    for (size_t i = 0; i < object->count; i++) {
        if (object->entries[i].subindex == subindex)
            ect_mistake(&d->mistake, entry->line, "object %04X has sub-index %u twice: give one another 'subindex'",
                        (unsigned int)object->index, (unsigned int)subindex);
    }
    check_default(d, object, subindex, entry);
    if (++d->entry_count > ECT_DEVFILE_ENTRIES)
        ect_mistake(&d->mistake, entry->line, "more than %d entries of all objects", (int)ECT_DEVFILE_ENTRIES);
    if (d->mistake.failed)
        return NULL;
    object->entries = ect_arena_grow(d->arena, object->entries, object->count, sizeof *object->entries);
    ect_draft_entry_t *added = &object->entries[object->count++];
    *added = *entry;
    added->subindex = subindex;
    return added;
}

/* --- PDOs --------------------------------------------------------------------------------------------------------- */

ect_esi_pdo_t *ect_draft_add_pdo(ect_draft_t *d, uint16_t index, bool tx, size_t line)
{
    for (size_t i = 0; i < d->device->pdo_count; i++) {
        if (d->device->pdos[i].index == index) {
            ect_mistake(&d->mistake, line, "PDO %04X occurs twice: give one another 'pdo'", (unsigned int)index);
            return NULL;
        }
    }
    ect_esi_pdo_t *pdo = ect_esi_append_pdo(d->arena, d->device);
    *pdo = (ect_esi_pdo_t){.index = index,
                           .name = tx ? "Inputs" : "Outputs",
                           .tx = tx,
                           .fixed = true,
                           .samples = 1,
                           .moves = d->moves,
                           .line = (int)line};
    return pdo;
}

static ect_esi_entry_t *add_mapped(ect_draft_t *d, ect_esi_pdo_t *pdo, size_t line)
{
    ect_esi_entry_t *entries = (ect_esi_entry_t *)(uintptr_t)pdo->entries; /* not constant yet */
    if (pdo->entry_count == ECT_DEVFILE_PDO_ENTRIES) {
        ect_mistake(&d->mistake, line, "PDO %04X has more than %d entries: split it into several PDOs",
                    (unsigned int)pdo->index, (int)ECT_DEVFILE_PDO_ENTRIES);
        return NULL;
    }
    entries = ect_arena_grow(d->arena, entries, pdo->entry_count, sizeof *entries);
    pdo->entries = entries;
    entries[pdo->entry_count] = (ect_esi_entry_t){.name = "", .type = "", .line = (int)line};
    return &entries[pdo->entry_count++];
}

static void map_entry(ect_draft_t *d, ect_esi_pdo_t *pdo, const ect_draft_object_t *object, ect_draft_entry_t *from,
                      size_t line)
{
    char type[40];
    if (from->bits > GAP_MOST) {
        ect_mistake(&d->mistake, line, "%04X:%u has %u bits; a PDO maps at most %d of an entry: access it by SDO",
                    (unsigned int)object->index, (unsigned int)from->subindex, (unsigned int)from->bits, (int)GAP_MOST);
        return;
    }
    if (pdo->tx && from->access == ECT_ACCESS_WO)
        ect_mistake(&d->mistake, line, "%04X:%u is an input and cannot be read: change its 'access: wo'",
                    (unsigned int)object->index, (unsigned int)from->subindex);
    ect_esi_entry_t *entry = add_mapped(d, pdo, line);
    if (entry == NULL)
        return;
    from->tx |= pdo->tx;
    from->rx |= !pdo->tx;
    const char *name = ect_esi_type_name(from->type, from->bits, type, sizeof type);
    entry->index = object->index;
    entry->moves = d->moves;
    entry->subindex = from->subindex;
    entry->bits = from->bits;
    entry->name = *from->name != '\0' ? from->name : object->name;
    entry->type = ect_arena_copy(d->arena, name, strlen(name));
}

/* @return the bits of a text such as "gap 4"; 0: another text */
static uint16_t gap_of(const char *text)
{
    int64_t bits;
    bool gap = strncmp(text, "gap ", 4) == 0 && ect_esi_parse_number(text + 4, &bits) && bits > 0 && bits <= GAP_MOST;
    return gap ? (uint16_t)bits : 0;
}

/* Reads "0x6000" or "0x6000:1". @return the sub-index, -1: none; *index is -1 for another text */
static int subindex_of(const char *text, int64_t *index)
{
    char number[24];
    int64_t subindex = -1;
    const char *colon = strchr(text, ':');
    size_t length = colon != NULL ? (size_t)(colon - text) : strlen(text);
    *index = -1;
    if (length >= sizeof number)
        return -1;
    memcpy(number, text, length);
    number[length] = '\0';
    if (colon != NULL && (!ect_esi_parse_number(colon + 1, &subindex) || subindex < 0 || subindex > UINT8_MAX))
        return -1;
    if (!ect_esi_parse_number(number, index) || *index < LOWEST_INDEX || *index >= INDICES)
        *index = -1;
    return (int)subindex;
}

void ect_draft_map(ect_draft_t *d, ect_esi_pdo_t *pdo, ect_word_t word)
{
    int64_t index;
    uint16_t gap = gap_of(word.text);
    int subindex = subindex_of(word.text, &index);
    const ect_draft_object_t *object = index >= 0 ? ect_draft_find(d, (uint16_t)index) : NULL;
    bool found = false;
    if (gap > 0) {
        ect_esi_entry_t *entry = add_mapped(d, pdo, word.line);
        if (entry != NULL)
            entry->bits = gap;
        return;
    }
    if (index < 0)
        ect_mistake(&d->mistake, word.line,
                    "'%.60s' is no entry of a PDO: 0x6000, all of an object; 0x6000:1, an entry; gap 4, unused bits",
                    word.text);
    for (size_t i = 0; object != NULL && i < object->count && !d->mistake.failed; i++) {
        if (subindex >= 0 && object->entries[i].subindex != subindex)
            continue;
        map_entry(d, pdo, object, &object->entries[i], word.line);
        found = true;
    }
    if (!found)
        ect_mistake(&d->mistake, word.line, "there is no %.60s among the 'objects': add it, or correct the index",
                    word.text);
}

/* --- the model ---------------------------------------------------------------------------------------------------- */

static ect_esi_bytes_t limit_of(ect_draft_t *d, const ect_draft_entry_t *entry, int64_t limit)
{
    size_t length = (entry->bits + 7u) / 8u;
    uint8_t *bytes = ect_arena_alloc(d->arena, 8);
    if (!entry->limited)
        return (ect_esi_bytes_t){0};
    ect_store_le64(bytes, (uint64_t)limit);
    return (ect_esi_bytes_t){.bytes = bytes, .length = length};
}

static void end_entry(ect_draft_t *d, const ect_draft_object_t *object, const ect_draft_entry_t *entry)
{
    uint8_t unit[4];
    unsigned int access = entry->access != 0 ? entry->access : entry->rx ? ECT_ACCESS_RW : ECT_ACCESS_RO;
    access |= (entry->rx ? ECT_ACCESS_RXPDO : 0u) | (entry->tx ? ECT_ACCESS_TXPDO : 0u);
    ect_store_le32(unit, entry->unit);
    const ect_esi_found_entry_t found = {
        .subindex = entry->subindex,
        .type = entry->type,
        .bits = entry->bits,
        .access = (uint16_t)access,
        .name = *entry->name != '\0' ? entry->name : object->name,
        .unit = {.bytes = entry->unit != 0 ? unit : NULL, .length = sizeof unit},
        .minimum = limit_of(d, entry, entry->minimum),
        .maximum = limit_of(d, entry, entry->maximum),
        .value = entry->initial,
    };
    ect_esi_found_entry((ect_esi_t *)(uintptr_t)d->device->esi, &found);
}

static int compare_entries(const void *a, const void *b)
{
    return (int)((const ect_draft_entry_t *)a)->subindex - (int)((const ect_draft_entry_t *)b)->subindex;
}

static void end_object(ect_draft_t *d, const ect_draft_object_t *object)
{
    ect_esi_t *esi = (ect_esi_t *)(uintptr_t)d->device->esi;
    ECT_ASSERT(object->count > 0);
    qsort(object->entries, object->count, sizeof *object->entries, compare_entries);
    const uint8_t last = object->entries[object->count - 1].subindex;
    ect_esi_found_object(esi,
                         &(ect_esi_found_object_t){
                             .index = object->index, .described = true, .code = object->code, .name = object->name});
    if (object->code != ECT_OBJECT_VAR)
        ect_esi_found_entry(esi, &(ect_esi_found_entry_t){.subindex = 0,
                                                          .type = ECT_TYPE_UNSIGNED8,
                                                          .bits = 8,
                                                          .access = ECT_ACCESS_RO,
                                                          .name = "Number of entries",
                                                          .value = {.bytes = &last, .length = 1}});
    for (size_t i = 0; i < object->count; i++)
        end_entry(d, object, &object->entries[i]);
}

void ect_draft_end(ect_draft_t *d)
{
    for (size_t i = 0; i < d->object_count && !d->mistake.failed; i++)
        end_object(d, &d->objects[i]);
    if (d->mistake.failed)
        return;
    ect_esi_found_end((ect_esi_t *)(uintptr_t)d->device->esi);
    if (d->field_count == 0)
        return;
    d->fields = ect_arena_grow(d->arena, d->fields, d->field_count, sizeof *d->fields);
    d->device->fields = d->fields; /* a zeroed element ends the list */
}
