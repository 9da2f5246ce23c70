/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/faults/table.h"

#include <math.h>
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

/* --- rows between rows -------------------------------------------------------------------------------------------- */

/* Limit of rows of an interpolated table. */
enum { REFINED_MOST = 1000000 };

/* Two numbers of a column, before and after the present time. */
typedef struct line {
    size_t to; /* row of the second number; the number of rows: none */
    bool numbers, whole;
    double from_value, to_value;
    uint64_t from_ns, to_ns;
} line_t;

static bool read_number(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*value);
}

/* Advances to the next segment after a row. */
static void follow(const ect_table_t *table, size_t column, size_t row, line_t *line)
{
    const char *from = table->rows[row]->values[column];
    if (!from)
        return;
    line->to = row + 1;
    while (line->to < table->count && !table->rows[line->to]->values[column])
        line->to++;
    line->numbers = false;
    if (line->to == table->count)
        return;
    const char *to = table->rows[line->to]->values[column];
    line->from_ns = table->rows[row]->due_ns;
    line->to_ns = table->rows[line->to]->due_ns;
    line->numbers = read_number(from, &line->from_value) && read_number(to, &line->to_value) &&
                    line->from_value != line->to_value && line->to_ns > line->from_ns;
    line->whole = !strpbrk(from, ".eE") && !strpbrk(to, ".eE");
}

static const char *text_between(const line_t *line, uint64_t now_ns, char *text, size_t room)
{
    if (!line->numbers)
        return "";
    double part = (double)(now_ns - line->from_ns) / (double)(line->to_ns - line->from_ns);
    double value = line->from_value + part * (line->to_value - line->from_value);
    snprintf(text, room, line->whole ? "%.0f" : "%.12g", value);
    return text;
}

/* @param row  whose own values take precedence; NULL: none */
static bool add_row(ect_table_t *refined, const line_t *lines, const ect_table_row_t *row, uint64_t now_ns)
{
    char texts[ECT_TABLE_COLUMNS][32];
    const char *values[ECT_TABLE_COLUMNS];
    for (size_t i = 0; i < refined->columns; i++)
        values[i] = row && row->values[i] ? row->values[i] : text_between(&lines[i], now_ns, texts[i], sizeof texts[i]);
    return ect_table_add(refined, now_ns, values);
}

static bool refine(const ect_table_t *table, ect_table_t *refined, uint64_t every_ns)
{
    line_t lines[ECT_TABLE_COLUMNS] = {0};
    bool done = true;
    for (size_t row = 0; done && row < table->count; row++) {
        uint64_t now_ns = table->rows[row]->due_ns;
        for (size_t i = 0; i < table->columns; i++)
            follow(table, i, row, &lines[i]);
        done = add_row(refined, lines, table->rows[row], now_ns);
        while (done && row + 1 < table->count && table->rows[row + 1]->due_ns - now_ns > every_ns) {
            now_ns += every_ns;
            done = add_row(refined, lines, NULL, now_ns);
        }
    }
    return done;
}

const char *ect_table_refine(ect_table_t *table, uint64_t every_ns)
{
    ECT_ASSERT(every_ns > 0);
    uint64_t last_ns = table->count > 0 ? table->rows[table->count - 1]->due_ns : 0;
    if (last_ns / every_ns > REFINED_MOST)
        return "the table would have more than 1000000 rows: choose a longer 'every'";
    ect_table_t *refined = ect_table_new(table->slave, (const char *const *)table->names, table->columns);
    bool done = refined && refine(table, refined, every_ns);
    if (done) {
        ect_table_t old = *table;
        *table = *refined;
        table->next = old.next;
        *refined = old;
        refined->next = NULL;
    }
    ect_table_free(refined);
    return done ? NULL : "not enough memory";
}

bool ect_table_loop(ect_table_t *table)
{
    table->period_ns = table->count > 0 ? table->rows[table->count - 1]->due_ns : 0;
    return table->period_ns > 0;
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
    if (table->done == table->count && table->period_ns > 0) {
        table->done = 0;
        table->base_ns += table->period_ns;
    }
    return ect_settings_apply(chain, table->slave - 1u, settings, count, now_ns, message);
}
