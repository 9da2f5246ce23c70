/* SPDX-License-Identifier: MIT */
#include "bus/chain/names.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "wire/assert.h"

struct ect_names {
    size_t count, slots;
    uint32_t *table; /* open addressing: number of the twin, 0 free; `slots` is a power of 2, at least twice `count` */
    char (*name)[ECT_NAME_ROOM];
};

ect_names_t *ect_names_new(size_t count)
{
    ect_names_t *names = calloc(1, sizeof *names);
    if (!names)
        return NULL;
    names->count = count;
    for (names->slots = 2; names->slots < 2 * count; names->slots *= 2)
        ;
    names->table = calloc(names->slots, sizeof *names->table);
    names->name = calloc(count > 0 ? count : 1, sizeof *names->name);
    if (names->table && names->name)
        return names;
    ect_names_free(names);
    return NULL;
}

void ect_names_free(ect_names_t *names)
{
    if (!names)
        return;
    free(names->table);
    free(names->name);
    free(names);
}

size_t ect_name_begins(const char *text)
{
    size_t length = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_-");
    return *text >= 'a' && *text <= 'z' && length < ECT_NAME_ROOM ? length : 0;
}

static bool is_name(const ect_names_t *names, uint32_t number, const char *name, size_t length)
{
    const char *own = names->name[number - 1];
    return strncmp(own, name, length) == 0 && own[length] == 0;
}

/* @return the slot of a name, or a free slot */
static uint32_t *slot_of(const ect_names_t *names, const char *name, size_t length)
{
    uint32_t hash = 2166136261u; /* FNV-1a */
    for (size_t i = 0; i < length; i++)
        hash = (hash ^ (uint8_t)name[i]) * 16777619u;
    size_t at = hash & (names->slots - 1);
    while (names->table[at] != 0 && !is_name(names, names->table[at], name, length))
        at = (at + 1) & (names->slots - 1);
    return &names->table[at];
}

bool ect_names_add(ect_names_t *names, size_t position, const char *name)
{
    size_t length = strlen(name);
    ECT_ASSERT(position < names->count && length > 0 && ect_name_begins(name) == length);
    ECT_ASSERT(names->name[position][0] == 0);
    uint32_t *slot = slot_of(names, name, length);
    if (*slot != 0)
        return false;
    memcpy(names->name[position], name, length + 1);
    *slot = (uint32_t)position + 1;
    return true;
}

size_t ect_names_find(const ect_names_t *names, const char *name, size_t length)
{
    return names && length > 0 && length < ECT_NAME_ROOM ? *slot_of(names, name, length) : 0;
}

const char *ect_names_at(const ect_names_t *names, size_t position)
{
    return names && position < names->count && names->name[position][0] != 0 ? names->name[position] : NULL;
}
