/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "play_args.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "csv/csv.h"
#include "text/number.h"
#include "twin_names.h"

/* Copies the columns except that of the time. */
static size_t other_cells(const ect_csv_t *csv, char *const cells[ECT_CSV_CELLS], size_t time,
                          const char *others[ECT_CSV_CELLS])
{
    size_t count = 0;
    for (size_t i = 0; i < csv->columns; i++) {
        if (i != time)
            others[count++] = cells[i];
    }
    return count;
}

/* @return the table, NULL with csv->why set */
static ect_table_t *read_table(ect_csv_t *csv, uint16_t slave)
{
    const char *cells[ECT_CSV_CELLS];
    uint64_t before_ns = 0, due_ns;
    size_t time = ect_csv_column(csv, "time");
    if (time == csv->columns || csv->columns == 1) {
        csv->why = "expected a column 'time' and at least one signal";
        return NULL;
    }
    size_t columns = other_cells(csv, csv->names, time, cells);
    ect_table_t *table = ect_table_new(slave, cells, columns);
    while (table && ect_csv_next(csv)) {
        if (!ect_csv_time(csv, time, before_ns, &due_ns))
            break;
        (void)other_cells(csv, csv->cells, time, cells);
        if (!ect_table_add(table, due_ns, cells))
            csv->why = "not enough memory";
        before_ns = due_ns;
    }
    if (!csv->why)
        return table;
    ect_table_free(table);
    return NULL;
}

/* Parses "FILE[,loop][,every=TIME]" and truncates `file` to FILE. @return NULL, or the invalid word */
static const char *cut_words(char *file, bool *loop, uint64_t *every_ns)
{
    for (char *comma = strrchr(file, ','); comma && access(file, F_OK) != 0; comma = strrchr(file, ',')) {
        bool known = strncmp(comma + 1, "every=", 6) == 0 && ect_number_time(comma + 7, every_ns);
        if (!known && strcmp(comma + 1, "loop") != 0)
            return comma + 1;
        *loop = *loop || !known;
        *comma = 0;
    }
    return NULL;
}

/* @return the table; NULL with csv->why set */
static ect_table_t *open_table(ect_csv_t *csv, uint16_t slave, bool loop, uint64_t every_ns)
{
    ect_table_t *table = read_table(csv, slave);
    if (!table)
        csv->why = csv->why ? csv->why : "not enough memory";
    else if (every_ns > 0)
        csv->why = ect_table_refine(table, every_ns);
    if (table && !csv->why && loop && !ect_table_loop(table))
        csv->why = "a loop has the time of its last line, which must not be 0";
    if (!csv->why)
        return table;
    ect_table_free(table);
    return NULL;
}

void play_args_add(twin_args_t *args, const struct argp_state *state, const char *text)
{
    const char *rest = text;
    size_t slave = twin_of(args->names, &rest, 1);
    char *path = strdup(rest);
    ect_csv_t *csv = calloc(1, sizeof *csv);
    ect_table_t **last = &args->scenario.tables;
    bool loop = false;
    uint64_t every_ns = 0;
    const char *wrong = path ? cut_words(path, &loop, &every_ns) : NULL;
    if (wrong)
        argp_error(state, "--play %s: '%s' is neither loop nor every=TIME, as in every=5ms, and there is no such file",
                   text, wrong);
    if (!path || !csv || slave == 0 || !ect_csv_open(csv, path))
        argp_failure(state, EXIT_OPEN, 0, "--play %s: %s", text, csv && csv->why ? csv->why : "N is 1 to 65535");
    while (*last)
        last = &(*last)->next;
    *last = open_table(csv, (uint16_t)slave, loop, every_ns);
    if (!*last)
        argp_failure(state, EXIT_USAGE, 0, "--play %s line %u: %s", path, csv->line, csv->why);
    ect_csv_close(csv);
    free(csv);
    free(path);
}
