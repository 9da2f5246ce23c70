/* SPDX-License-Identifier: MIT */
#include "table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXACT = 15 }; /* digits of a whole number that every double has */

static size_t slot_of(long slave, const char *name)
{
    uint32_t hash = 2166136261U ^ (uint32_t)slave;
    for (; *name; name++)
        hash = (hash ^ (unsigned char)*name) * 16777619U;
    return hash % TABLE_SLOTS;
}

/* The slot of a signal, or the free one for it: half of them are free. */
static uint16_t *find(table_t *table, long slave, const char *name)
{
    for (size_t slot = slot_of(slave, name);; slot = (slot + 1) % TABLE_SLOTS) {
        const table_signal_t *signal = &table->signals[table->slots[slot] - (table->slots[slot] > 0)];
        if (table->slots[slot] == 0 || (signal->slave == slave && strcmp(signal->name, name) == 0))
            return &table->slots[slot];
    }
}

static const char *key_of(const cJSON *line, long *slave)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(line, "slave");
    *slave = cJSON_IsNumber(number) ? number->valueint : 0;
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "name"));
}

bool table_add(table_t *table, const char *text, const cJSON *line)
{
    long slave;
    const char *name = key_of(line, &slave);
    if (!name || slave <= 0 || table->count == TABLE_SIGNALS)
        return false;
    uint16_t *slot = find(table, slave, name);
    if (*slot != 0)
        return true;
    size_t length = strlen(text) + 1;
    char *memory = malloc(length + strlen(name) + 1);
    if (!memory)
        return false;
    memcpy(memory, text, length);
    strcpy(memory + length, name);
    table->signals[table->count] = (table_signal_t){.text = memory, .name = memory + length, .slave = slave};
    *slot = (uint16_t)++table->count;
    return true;
}

/* A whole number with more digits than a browser keeps becomes a text. @return NULL: no memory */
static char *value_of(const char *text, const cJSON *value)
{
    static const char member[] = "\"value\":";
    const char *digits = strstr(text, member);
    digits = digits ? digits + strlen(member) : "";
    size_t length = strspn(digits, "-0123456789");
    if (!cJSON_IsNumber(value) || length <= EXACT || !strchr(",}", digits[length]))
        return cJSON_PrintUnformatted(value);
    const size_t room = length + 3;
    char *quoted = cJSON_malloc(room);
    if (quoted)
        snprintf(quoted, room, "\"%.*s\"", (int)length, digits);
    return quoted;
}

bool table_change(table_t *table, const char *text, const cJSON *line)
{
    long slave;
    const char *name = key_of(line, &slave);
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(line, "value");
    if (!name || !value)
        return false;
    uint16_t slot = *find(table, slave, name);
    if (slot == 0)
        return false;
    table_signal_t *signal = &table->signals[slot - 1];
    char *printed = value_of(text, value);
    if (!printed)
        return false;
    cJSON_free(signal->value);
    signal->value = printed;
    table->changes = table->changes == UINT32_MAX ? 1 : table->changes + 1; /* 0 is a signal without a value */
    signal->changed = table->changes;
    return true;
}

size_t table_find(table_t *table, const cJSON *line)
{
    long slave;
    const char *name = key_of(line, &slave);
    uint16_t slot = name ? *find(table, slave, name) : 0;
    return slot > 0 ? slot - 1U : TABLE_SIGNALS;
}

void table_clear(table_t *table)
{
    for (size_t i = 0; i < table->count; i++) {
        free(table->signals[i].text);
        cJSON_free(table->signals[i].value);
    }
    memset(table, 0, sizeof *table);
}
