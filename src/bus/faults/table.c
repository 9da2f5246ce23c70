/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/faults/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "wire/assert.h"

ect_table_t *ect_table_new(uint16_t slave, const char *const *names, size_t columns)
{
    ECT_ASSERT(columns >= 1 && columns <= ECT_TABLE_COLUMNS);
    ect_table_t *table = calloc(1, sizeof *table);
    if (!table)
        return NULL;
    table->slave = slave;
    table->columns = columns;
    for (size_t i = 0; i < columns; i++) {
        table->names[i] = strdup(names[i]);
        if (table->names[i])
            continue;
        ect_table_free(table);
        return NULL;
    }
    return table;
}

static void free_row(const ect_table_t *table, ect_table_row_t *row)
{
    for (size_t i = 0; row && i < table->columns; i++)
        free(row->values[i]);
    free(row);
}

static bool grow(ect_table_t *table)
{
    enum { FIRST_ROOM = 64 };
    size_t room = table->room > 0 ? 2 * table->room : FIRST_ROOM;
    if (table->count < table->room)
        return true;
    ect_table_row_t **grown = realloc(table->rows, room * sizeof *grown);
    if (!grown)
        return false;
    table->room = room;
    table->rows = grown;
    return true;
}

bool ect_table_add(ect_table_t *table, uint64_t due_ns, const char *const *values)
{
    ECT_ASSERT(table->count == 0 || due_ns >= table->rows[table->count - 1]->due_ns);
    ect_table_row_t *row = calloc(1, sizeof *row + table->columns * sizeof row->values[0]);
    bool done = row && grow(table);
    for (size_t i = 0; done && i < table->columns; i++) {
        row->values[i] = *values[i] != 0 ? strdup(values[i]) : NULL;
        done = *values[i] == 0 || row->values[i];
    }
    if (!done) {
        free_row(table, row);
        return false;
    }
    row->due_ns = due_ns;
    table->rows[table->count++] = row;
    return true;
}

void ect_table_free(ect_table_t *table)
{
    while (table) {
        ect_table_t *next = table->next;
        for (size_t i = 0; i < table->count; i++)
            free_row(table, table->rows[i]);
        for (size_t i = 0; i < table->columns; i++)
            free(table->names[i]);
        free(table->rows);
        free(table);
        table = next;
    }
}

static bool check_column(const ect_table_t *table, size_t column, const ect_chain_t *chain, char *message)
{
    ect_signal_ref_t ref;
    if (!ect_chain_signal(chain, table->slave - 1u, table->names[column], &ref)) {
        snprintf(message, ECT_SIGNAL_MESSAGE,
                 "slave %u has no signal '%.60s': 'ectwin list-signals DEVICE' lists the names", table->slave,
                 table->names[column]);
        return false;
    }
    for (size_t i = 0; i < table->count; i++) {
        const char *value = table->rows[i]->values[column];
        if (value && !ect_signal_check(&ref, value, message))
            return false;
    }
    return true;
}

bool ect_table_check(const ect_table_t *table, const ect_chain_t *chain, char *message)
{
    if (table->slave < 1 || table->slave > ect_chain_count(chain)) {
        snprintf(message, ECT_SIGNAL_MESSAGE, "there is no slave %u: the chain has %zu", table->slave,
                 ect_chain_count(chain));
        return false;
    }
    for (size_t i = 0; i < table->columns; i++) {
        if (!check_column(table, i, chain, message))
            return false;
    }
    return true;
}

bool ect_table_play(ect_table_t *table, ect_chain_t *chain, uint64_t now_ns, char *message)
{
    ECT_ASSERT(table->done < table->count);
    const ect_table_row_t *row = table->rows[table->done++];
    ect_setting_t settings[ECT_TABLE_COLUMNS];
    size_t count = 0;
    for (size_t i = 0; i < table->columns; i++) {
        if (row->values[i])
            settings[count++] = (ect_setting_t){.name = table->names[i], .value = row->values[i]};
    }
    return ect_settings_apply(chain, table->slave - 1u, settings, count, now_ns, message);
}
