/* SPDX-License-Identifier: MIT */
#include "csv/csv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* Reads a line without its end. @return false: the end of the file, or csv->why is set */
static bool read_line(ect_csv_t *csv, char text[ECT_CSV_LINE])
{
    size_t length = 0;
    int c = getc(csv->file);
    csv->line++;
    if (c == EOF) {
        csv->why = ferror(csv->file) ? strerror(errno) : NULL;
        return false;
    }
    for (; c != EOF && c != '\n'; c = getc(csv->file)) {
        if (c == 0 || length == ECT_CSV_LINE - 1) {
            csv->why = c == 0 ? "it contains a zero byte: this is no text file" : "it is longer than 16383 characters";
            return false;
        }
        text[length++] = (char)c;
    }
    if (length > 0 && text[length - 1] == '\r')
        length--;
    text[length] = 0;
    return true;
}

static char *trim(char *from, char *end)
{
    while (from < end && (*from == ' ' || *from == '\t'))
        from++;
    while (end > from && (end[-1] == ' ' || end[-1] == '\t'))
        end--;
    *end = 0;
    return from;
}

/* Removes the quotes of a cell in place. Moves `at` to the next cell; NULL: none. */
static bool split_quoted(ect_csv_t *csv, char **at, char **cell)
{
    char *from = *at + 1;
    char *to = from;
    *cell = to;
    while (from[0] != '"' || from[1] == '"') {
        if (*from == 0) {
            csv->why = "a quote is not closed";
            return false;
        }
        from += *from == '"';
        *to++ = *from++;
    }
    const char *after = from + 1 + strspn(from + 1, " ");
    if (*after != 0 && *after != csv->separator) {
        csv->why = "something follows a closing quote";
        return false;
    }
    *at = *after != 0 ? from + (after - from) + 1 : NULL;
    *to = 0;
    return true;
}

static bool split(ect_csv_t *csv, char *line, char *cells[ECT_CSV_CELLS], size_t *count)
{
    *count = 0;
    for (char *at = line; at;) {
        if (*count == ECT_CSV_CELLS) {
            csv->why = "it has more than 128 cells";
            return false;
        }
        char **cell = &cells[(*count)++];
        at += strspn(at, " ");
        if (*at == '"') {
            if (!split_quoted(csv, &at, cell))
                return false;
            continue;
        }
        char *end = at + strcspn(at, (const char[]){csv->separator, 0});
        char *next = *end != 0 ? end + 1 : NULL;
        *cell = trim(at, end);
        at = next;
    }
    return true;
}

bool ect_csv_begin(ect_csv_t *csv, FILE *file)
{
    static const char mark[] = "\xEF\xBB\xBF";
    memset(csv, 0, sizeof *csv);
    csv->file = file;
    if (!csv->file) {
        csv->why = strerror(errno);
        return false;
    }
    if (!read_line(csv, csv->header)) {
        csv->why = csv->why ? csv->why : "it is empty";
        return false;
    }
    char *line = csv->header + (strncmp(csv->header, mark, 3) == 0 ? 3 : 0);
    const char *separator = strpbrk(line, ",;\t");
    csv->separator = separator ? *separator : ',';
    return split(csv, line, csv->names, &csv->columns);
}

bool ect_csv_open(ect_csv_t *csv, const char *path)
{
    return ect_csv_begin(csv, strcmp(path, "-") == 0 ? stdin : fopen(path, "r"));
}

bool ect_csv_next(ect_csv_t *csv)
{
    do {
        if (!read_line(csv, csv->text))
            return false;
    } while (csv->text[strspn(csv->text, " ")] == 0);
    if (!split(csv, csv->text, csv->cells, &csv->count))
        return false;
    if (csv->count != csv->columns)
        csv->why = "its number of cells differs from the number of names in the first line";
    return csv->count == csv->columns;
}

size_t ect_csv_column(const ect_csv_t *csv, const char *name)
{
    size_t column = 0;
    while (column < csv->columns && strcmp(csv->names[column], name) != 0)
        column++;
    return column;
}

bool ect_csv_time(ect_csv_t *csv, size_t column, uint64_t before_ns, uint64_t *ns)
{
    const char *text = csv->cells[column];
    char *end;
    double seconds = strtod(text, &end);
    if (end == text || *end != 0 || !(seconds >= 0 && seconds < 1e9)) {
        csv->why = "its time is not a number of seconds, 0 or more";
        return false;
    }
    *ns = (uint64_t)(seconds * 1e9 + 0.5);
    if (*ns < before_ns)
        csv->why = "its time is before that of the line above";
    return *ns >= before_ns;
}

void ect_csv_write(FILE *file, const char *text)
{
    if (text[strcspn(text, ",;\t \"")] == 0) {
        fputs(text, file);
        return;
    }
    putc('"', file);
    for (; *text != 0; text++) {
        if (*text == '"')
            putc('"', file);
        putc(*text, file);
    }
    putc('"', file);
}

void ect_csv_close(ect_csv_t *csv)
{
    if (csv->file && csv->file != stdin)
        fclose(csv->file);
    csv->file = NULL;
}
