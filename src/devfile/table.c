/* SPDX-License-Identifier: MIT */
/* Objects as a table, with a line for each entry. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "csv/csv.h"
#include "devfile/internal.h"
#include "esi/number.h"

enum { FIRST_RXPDO = 0x1600, FIRST_TXPDO = 0x1A00, ELEMENTS_MOST = 254 };

/* Columns other than those of the words (value.c). */
typedef enum extra { INDEX, SUBINDEX, OBJECT, PDO, BITS, VALUES, EXTRAS } extra_t;

static const char *const extras[EXTRAS] = {"index", "subindex", "object", "pdo", "bits", "values"};

typedef struct table {
    ect_draft_t *d;
    ect_csv_t csv;
    int64_t index; /* of the present record; -1: none */
} table_t;

/* @return the cell of a column in the present line; "": the table has no such column */
static ect_word_t cell(const table_t *t, const char *name)
{
    size_t column = ect_csv_column(&t->csv, name);
    return (ect_word_t){.text = column < t->csv.columns ? t->csv.cells[column] : "", .line = t->csv.line};
}

static ect_word_t extra(const table_t *t, extra_t column)
{
    return cell(t, extras[column]);
}

static bool is_column(const char *name)
{
    bool found = false;
    for (size_t i = 0; i < ECT_WORDS; i++)
        found = found || strcmp(ect_word_names[i], name) == 0;
    for (size_t i = 0; i < EXTRAS; i++)
        found = found || strcmp(extras[i], name) == 0;
    return found;
}

static void check_header(table_t *t)
{
    static const char *const needed[] = {"index", "name", "type"};
    for (size_t i = 0; i < t->csv.columns; i++) {
        if (!is_column(t->csv.names[i]) || ect_csv_column(&t->csv, t->csv.names[i]) != i)
            ect_mistake(&t->d->mistake, 1,
                        "'%.60s' is no column, or occurs twice: index, subindex, object, name, type, access, default, "
                        "min, max, unit, write-in, backup, setting, pdo, bits, values",
                        t->csv.names[i]);
    }
    for (size_t i = 0; i < sizeof needed / sizeof needed[0]; i++) {
        if (ect_csv_column(&t->csv, needed[i]) == t->csv.columns)
            ect_mistake(&t->d->mistake, 1, "the column '%s' is missing: the first line has the names of the columns",
                        needed[i]);
    }
}

/* --- a line ------------------------------------------------------------------------------------------------------- */

static void map(table_t *t, uint8_t subindex)
{
    ect_draft_t *d = t->d;
    const ect_word_t pdo = extra(t, PDO);
    if (*pdo.text == '\0' || d->mistake.failed)
        return;
    const bool tx = strcmp(pdo.text, "in") == 0;
    const uint16_t index = tx ? FIRST_TXPDO : FIRST_RXPDO;
    if (!tx && strcmp(pdo.text, "out") != 0) {
        ect_mistake(&d->mistake, pdo.line, "'pdo' takes in, out or nothing, not '%.60s'", pdo.text);
        return;
    }
    ect_esi_pdo_t *pdos = (ect_esi_pdo_t *)(uintptr_t)d->device->pdos, *found = NULL; /* ours */
    for (size_t i = 0; i < d->device->pdo_count; i++)
        found = pdos[i].index == index ? &pdos[i] : found;
    if (found == NULL)
        found = ect_draft_add_pdo(d, index, tx, pdo.line);
    ECT_ASSERT(found != NULL);
    const uint16_t object = d->objects[d->object_count - 1].index;
    char *text = ect_arena_print(d->arena, "0x%04X:%u", (unsigned int)object, (unsigned int)subindex);
    ect_draft_map(d, found, (ect_word_t){.text = text, .line = pdo.line});
}

/* Starts the object of the present line, or continues it. @return false: a mistake */
static bool take_object(table_t *t, int64_t subindex)
{
    ect_draft_t *d = t->d;
    const ect_word_t index = extra(t, INDEX), object = extra(t, OBJECT);
    const bool record = subindex > 0;
    int64_t number = 0;
    bool same = record && t->index >= 0 && ect_esi_parse_number(index.text, &number) && number == t->index;
    const char *name = record ? object.text : cell(t, "name").text;
    if (same)
        return true;
    t->index = -1;
    if (*name == '\0')
        ect_mistake(&d->mistake, index.line,
                    record ? "object %.60s has no name: write it to 'object' in its first line"
                           : "object %.60s has no 'name'",
                    index.text);
    if (d->mistake.failed || ect_draft_add(d, index, record ? ECT_OBJECT_RECORD : ECT_OBJECT_VAR, name) == NULL)
        return false;
    t->index = record ? d->objects[d->object_count - 1].index : -1;
    return true;
}

static void take_line(table_t *t)
{
    ect_draft_t *d = t->d;
    ect_word_t words[ECT_WORDS];
    ect_draft_entry_t entry;
    const ect_word_t subindex = extra(t, SUBINDEX);
    int64_t number = 0;
    if (*subindex.text != '\0')
        number = ect_draft_number(d, "subindex", subindex, 0, ELEMENTS_MOST);
    for (size_t i = 0; i < ECT_WORDS; i++) {
        words[i] = cell(t, ect_word_names[i]);
        words[i].text = *words[i].text != '\0' ? words[i].text : NULL;
    }
    if (d->mistake.failed || !take_object(t, number))
        return;
    ect_draft_words(d, &entry, words, t->csv.line);
    if (*entry.name == '\0')
        ect_mistake(&d->mistake, t->csv.line, "'name' is missing");
    if (d->mistake.failed)
        return;
    entry.subindex = (uint8_t)number;
    ect_draft_cells(d, extra(t, BITS), extra(t, VALUES), &entry);
    (void)ect_draft_entry(d, (uint8_t)number, &entry);
    map(t, (uint8_t)number);
}

/* --- the file ----------------------------------------------------------------------------------------------------- */

static char *path_of(const ect_draft_t *d, const char *file)
{
    const char *slash = strrchr(d->mistake.path, '/');
    if (*file == '/' || slash == NULL)
        return ect_arena_copy(d->arena, file, strlen(file));
    return ect_arena_print(d->arena, "%.*s/%s", (int)(slash - d->mistake.path), d->mistake.path, file);
}

/* Refuses characters that other readers of the model may not accept. */
static void check_text(table_t *t)
{
    for (size_t i = 0; i < t->csv.count; i++) {
        for (const char *letter = t->csv.cells[i]; *letter != '\0'; letter++) {
            if (*letter < ' ' || *letter > '~')
                ect_mistake(&t->d->mistake, t->csv.line, "a character outside ISO 646 (ASCII) in '%s'",
                            t->csv.names[i]);
        }
    }
}

static void read_lines(table_t *t)
{
    check_header(t);
    while (!t->d->mistake.failed && ect_csv_next(&t->csv)) {
        check_text(t);
        if (!t->d->mistake.failed)
            take_line(t);
    }
}

void ect_draft_table(ect_draft_t *d, ect_word_t word)
{
    const char *device_file = d->mistake.path;
    char why[300];
    size_t length = 0;
    if (d->mistake.failed)
        return;
    char *path = path_of(d, word.text);
    char *data = ect_yaml_load(path, ECT_DEVFILE_BYTES, &length, why, sizeof why);
    table_t *t = calloc(1, sizeof *t);
    if (data == NULL || t == NULL) {
        ect_mistake(&d->mistake, word.line, "'objects' takes objects, or the name of a table: %s",
                    data == NULL ? why : "no memory left");
    } else {
        t->d = d;
        t->index = -1;
        d->mistake.path = path; /* lines are those of the table */
        if (ect_csv_begin(&t->csv, length > 0 ? fmemopen(data, length, "r") : NULL))
            read_lines(t);
        if (t->csv.why != NULL)
            ect_mistake(&d->mistake, length > 0 ? t->csv.line : 1, "%s", length > 0 ? t->csv.why : "it is empty");
        ect_csv_close(&t->csv);
        d->mistake.path = device_file;
    }
    free(t);
    free(data);
}
