/* SPDX-License-Identifier: MIT */
/* Tables in text files: cells, separators, quotes, the lines that are refused, times, and cells written. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "csv/csv.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

static ect_csv_t csv;

/* A file with these bytes. */
static FILE *file_of(const char *bytes, size_t length)
{
    FILE *file = tmpfile();
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, length, file), length);
    rewind(file);
    return file;
}

static void begin(const char *text)
{
    if (!ect_csv_begin(&csv, file_of(text, strlen(text))))
        fail_msg("'%s': %s", text, csv.why);
}

/* The cells of the line read last, each in brackets. */
static const char *cells(void)
{
    static char text[512];
    size_t used = 0;
    text[0] = 0;
    for (size_t i = 0; i < csv.count; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "[%s]", csv.cells[i]);
    return text;
}

static void a_line_has_a_cell_for_each_name(void **state)
{
    static const struct {
        const char *text, *cells;
        char separator;
    } rows[] = {
        {"a,b\n1,2\n", "[1][2]", ','},
        {"a;b\n1,5;2\n", "[1,5][2]", ';'},
        {"a\tb\n1 2\t3\n", "[1 2][3]", '\t'},
        {"a\tb\n\t2\n", "[][2]", '\t'},
        {"a\tb\n \t 2\n", "[][2]", '\t'},
        {"a,b;c\n1;x,2\n", "[1;x][2]", ','},
        {"a\n1\n", "[1]", ','},
        {"a,b\n1,2", "[1][2]", ','},
        {"a,b\r\n1,2\r\n", "[1][2]", ','},
        {"a,b\n,\n", "[][]", ','},
        {" a , b \n  1\t ,\t2 \n", "[1][2]", ','},
        {"\xEF\xBB\xBF"
         "a,b\n1,2\n",
         "[1][2]", ','},
        {"a,b\n\n   \n1,2\n", "[1][2]", ','},
        {"a,b\n\"1,2\",3\n", "[1,2][3]", ','},
        {"a,b\n\"a \"\"b\"\"\",\"\"\n", "[a \"b\"][]", ','},
        {"a,b\n  \" 1 \"  ,2\n", "[ 1 ][2]", ','},
        {"a,b\n1,\"2\"  \n", "[1][2]", ','},
        {"a,b\n1\"2,3\n", "[1\"2][3]", ','},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        begin(rows[i].text);
        assert_int_equal(csv.separator, rows[i].separator);
        assert_string_equal(csv.names[0], "a");
        assert_int_equal(ect_csv_column(&csv, "a"), 0);
        if (!ect_csv_next(&csv))
            fail_msg("'%s': %s", rows[i].text, csv.why);
        assert_string_equal(cells(), rows[i].cells);
        assert_false(ect_csv_next(&csv));
        assert_null(csv.why);
        ect_csv_close(&csv);
    }
}

static void a_column_is_found_by_its_name(void **state)
{
    (void)state;
    begin("time,\"two words\",last\n");
    assert_int_equal(csv.columns, 3);
    assert_int_equal(ect_csv_column(&csv, "time"), 0);
    assert_int_equal(ect_csv_column(&csv, "two words"), 1);
    assert_int_equal(ect_csv_column(&csv, "last"), 2);
    assert_int_equal(ect_csv_column(&csv, "las"), 3);
    assert_int_equal(ect_csv_column(&csv, "Time"), 3);
    ect_csv_close(&csv);
}

static void a_line_is_refused_with_its_number_and_the_reason(void **state)
{
    static const struct {
        const char *text;
        unsigned int line;
        const char *why;
    } rows[] = {
        {"a,b\n1\n", 2, "its number of cells differs from the number of names in the first line"},
        {"a,b\n1,2\n\n1,2,3\n", 4, "its number of cells differs from the number of names in the first line"},
        {"a,b\n\"1,2\n", 2, "a quote is not closed"},
        {"a,b\n\"1\"\",2\n", 2, "a quote is not closed"},
        {"a,b\n\"1\" 2,3\n", 2, "something follows a closing quote"},
        {"a,b\n1,2\n\"1\";3\n", 3, "something follows a closing quote"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        begin(rows[i].text);
        while (ect_csv_next(&csv))
            continue;
        if (csv.why == NULL || strcmp(csv.why, rows[i].why) != 0)
            fail_msg("'%s': expected '%s', got '%s'", rows[i].text, rows[i].why, csv.why ? csv.why : "no refusal");
        assert_int_equal(csv.line, rows[i].line);
        ect_csv_close(&csv);
    }
}

static void a_first_line_is_refused_with_the_reason(void **state)
{
    static const struct {
        const char *text;
        size_t length;
        const char *why;
    } rows[] = {
        {"", 0, "it is empty"},
        {"a\0b\n", 4, "it contains a zero byte: this is no text file"},
        {"\"a,b\n", 5, "a quote is not closed"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_false(ect_csv_begin(&csv, file_of(rows[i].text, rows[i].length)));
        assert_string_equal(csv.why, rows[i].why);
        assert_int_equal(csv.line, 1);
        ect_csv_close(&csv);
    }
}

/* A line of one cell with `length` characters. */
static bool takes_line(size_t length)
{
    char *text = malloc(length + 3);
    assert_non_null(text);
    memset(text, 'x', length + 2);
    memcpy(text, "a\n", 2);
    text[length + 2] = '\n';
    FILE *file = file_of(text, length + 3);
    free(text);
    assert_true(ect_csv_begin(&csv, file));
    const bool taken = ect_csv_next(&csv);
    assert_int_equal(taken ? strlen(csv.cells[0]) : 0, taken ? length : 0);
    ect_csv_close(&csv);
    return taken;
}

/* A first line with `count` names. */
static bool takes_names(size_t count)
{
    char *text = malloc(2 * count);
    assert_non_null(text);
    for (size_t i = 0; i < count; i++)
        memcpy(text + 2 * i, i + 1 < count ? "a," : "a\n", 2);
    FILE *file = file_of(text, 2 * count);
    free(text);
    const bool taken = ect_csv_begin(&csv, file);
    assert_int_equal(csv.columns, taken ? count : (size_t)ECT_CSV_CELLS);
    ect_csv_close(&csv);
    return taken;
}

static void the_longest_line_and_the_most_cells_are_taken(void **state)
{
    (void)state;
    assert_true(takes_line(ECT_CSV_LINE - 1));
    assert_false(takes_line(ECT_CSV_LINE));
    assert_string_equal(csv.why, "it is longer than 16383 characters");
    assert_true(takes_names(ECT_CSV_CELLS));
    assert_false(takes_names(ECT_CSV_CELLS + 1));
    assert_string_equal(csv.why, "it has more than 128 cells");
}

static void a_file_that_cannot_be_read_has_the_reason_of_the_system(void **state)
{
    (void)state;
    assert_false(ect_csv_open(&csv, "/nowhere/table.csv"));
    assert_string_equal(csv.why, strerror(ENOENT));
    ect_csv_close(&csv);
    assert_false(ect_csv_open(&csv, "/")); /* a directory opens, and cannot be read */
    assert_string_equal(csv.why, strerror(EISDIR));
    ect_csv_close(&csv);
}

static void a_close_closes_the_file_once(void **state)
{
    FILE *file = file_of("a\n", 2);
    const int fd = fileno(file);
    (void)state;
    assert_true(ect_csv_begin(&csv, file));
    assert_int_not_equal(fcntl(fd, F_GETFD), -1);
    ect_csv_close(&csv);
    assert_int_equal(fcntl(fd, F_GETFD), -1);
    assert_null(csv.file);
    ect_csv_close(&csv);
}

/* "-" is standard input, which remains open. */
static void a_dash_is_standard_input(void **state)
{
    FILE *input = stdin;
    FILE *file = file_of("a\n7\n", 4);
    (void)state;
    stdin = file;
    const bool opened = ect_csv_open(&csv, "-") && ect_csv_next(&csv);
    ect_csv_close(&csv);
    stdin = input;
    assert_true(opened);
    assert_string_equal(cells(), "[7]");
    assert_null(csv.file);
    rewind(file);
    assert_int_equal(getc(file), 'a');
    assert_int_equal(fclose(file), 0);
}

static void a_time_is_seconds_in_ascending_order(void **state)
{
    static const char not_number[] = "its time is not a number of seconds, 0 or more";
    static const char earlier[] = "its time is before that of the line above";
    static const struct {
        const char *cell;
        uint64_t before_ns, ns;
        const char *why;
    } rows[] = {
        {"0", 0, 0, NULL},
        {"0.25", 0, 250000000, NULL},
        {"1e-9", 0, 1, NULL},
        {"0.0000000015", 0, 2, NULL},
        {"2", 2000000000, 2000000000, NULL},
        {"1.999999999", 2000000000, 1999999999, earlier},
        {"999999999", 0, 999999999000000000, NULL},
        {"1e9", 0, 0, not_number},
        {"-0.1", 0, 0, not_number},
        {"", 0, 0, not_number},
        {"1 s", 0, 0, not_number},
        {"nan", 0, 0, not_number},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[64];
        uint64_t ns = 0;
        snprintf(text, sizeof text, "name,time\nx,%s\n", rows[i].cell);
        begin(text);
        assert_true(ect_csv_next(&csv));
        if (ect_csv_time(&csv, 1, rows[i].before_ns, &ns) != (rows[i].why == NULL))
            fail_msg("'%s': %s", rows[i].cell, csv.why ? csv.why : "is taken");
        assert_true(ns == rows[i].ns);
        if (rows[i].why != NULL)
            assert_string_equal(csv.why, rows[i].why);
        ect_csv_close(&csv);
    }
}

static void a_cell_is_written_as_it_is_read_back(void **state)
{
    static const char *const rows[][2] = {
        {"", ""},
        {"plain", "plain"},
        {"a,b", "\"a,b\""},
        {"a;b", "\"a;b\""},
        {"a\tb", "\"a\tb\""},
        {" a", "\" a\""},
        {"say \"x\"", "\"say \"\"x\"\"\""},
        {"\"", "\"\"\"\""},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char *text = NULL;
        size_t length;
        FILE *file = open_memstream(&text, &length);
        fputs("a,b\n", file);
        ect_csv_write(file, rows[i][0]);
        fputs(",x\n", file);
        assert_int_equal(fclose(file), 0);
        assert_int_equal(length, strlen("a,b\n") + strlen(rows[i][1]) + strlen(",x\n"));
        assert_memory_equal(text + 4, rows[i][1], strlen(rows[i][1]));
        begin(text);
        free(text);
        assert_true(ect_csv_next(&csv));
        assert_string_equal(csv.cells[0], rows[i][0]);
        assert_string_equal(csv.cells[1], "x");
        ect_csv_close(&csv);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_has_a_cell_for_each_name),
        cmocka_unit_test(a_column_is_found_by_its_name),
        cmocka_unit_test(a_line_is_refused_with_its_number_and_the_reason),
        cmocka_unit_test(a_first_line_is_refused_with_the_reason),
        cmocka_unit_test(the_longest_line_and_the_most_cells_are_taken),
        cmocka_unit_test(a_file_that_cannot_be_read_has_the_reason_of_the_system),
        cmocka_unit_test(a_close_closes_the_file_once),
        cmocka_unit_test(a_dash_is_standard_input),
        cmocka_unit_test(a_time_is_seconds_in_ascending_order),
        cmocka_unit_test(a_cell_is_written_as_it_is_read_back),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("CSV", tests, NULL, NULL);
}
