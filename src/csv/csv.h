/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Tables from a text file: the first line contains names, each other line the same number of cells.
 *
 * The separator is the first comma, semicolon or tab of the first line. Blanks around a cell are ignored. A cell in
 * double quotes may contain any character except the end of a line; "" is a quote. A byte order mark and CR LF are
 * accepted; empty lines are skipped. A line that exceeds a limit is refused, not cut.
 */
#ifndef ECT_CSV_CSV_H
#define ECT_CSV_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "wire/linkage.h"

enum { ECT_CSV_CELLS = 128, ECT_CSV_LINE = 16384 };

typedef struct ect_csv {
    FILE *file;
    char separator;
    unsigned int line; /**< number of the line read last, from 1 */
    size_t columns;
    size_t count; /**< cells of the line read last */
    char *names[ECT_CSV_CELLS];
    char *cells[ECT_CSV_CELLS];
    char header[ECT_CSV_LINE];
    char text[ECT_CSV_LINE];
    const char *why; /**< reason of a failure; NULL: none */
} ect_csv_t;

ECT_C_BEGIN

/** Opens a file ("-": standard input) and reads its first line. @return false: csv->why has the reason */
bool ect_csv_open(ect_csv_t *csv, const char *path);

/** Begins with an open file, which ::ect_csv_close closes. @return as ::ect_csv_open */
bool ect_csv_begin(ect_csv_t *csv, FILE *file);

/** Reads the next line with cells. @return false: the end of the file, or csv->why is set */
bool ect_csv_next(ect_csv_t *csv);

/** @return the column with this name; csv->columns: none */
size_t ect_csv_column(const ect_csv_t *csv, const char *name);

/**
 * Reads the cell of a time, in seconds, from the line read last.
 * @param before_ns  time of the previous line
 * @return false: no number, or a time before that of the previous line; csv->why has the reason
 */
bool ect_csv_time(ect_csv_t *csv, size_t column, uint64_t before_ns, uint64_t *ns);

/** Writes a cell, in quotes if necessary. */
void ect_csv_write(FILE *file, const char *text);

void ect_csv_close(ect_csv_t *csv);

ECT_C_END

#endif
