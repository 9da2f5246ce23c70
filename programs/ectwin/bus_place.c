/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus_place.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct line_of_word {
    const char *word;
    size_t line;
};

/* The bus file of the command line until the program ends. */
static struct {
    const char *path; /* NULL: none */
    const ect_bus_file_t *file;
    struct line_of_word *lines; /* by address */
    FILE *errors;               /* standard error, for one line */
    bool printed;               /* this line */
} given;

__attribute__((destructor)) static void free_given(void)
{
    if (given.errors)
        (void)fclose(given.errors);
    free(given.lines);
}

static int by_address(const void *a, const void *b)
{
    const uintptr_t one = (uintptr_t)((const struct line_of_word *)a)->word;
    const uintptr_t other = (uintptr_t)((const struct line_of_word *)b)->word;
    return one < other ? -1 : one > other;
}

/* argp_error adds a line about --help, which is no help with a file. */
static ssize_t write_first_line(void *cookie, const char *data, size_t length)
{
    (void)cookie;
    const char *end = memchr(data, '\n', length);
    const size_t count = end ? (size_t)(end - data) + 1 : length;
    if (!given.printed)
        (void)fwrite(data, 1, count, stderr);
    given.printed = given.printed || end;
    return (ssize_t)length;
}

bool bus_place_open(const char *path, const ect_bus_file_t *file)
{
    given.path = path;
    given.file = file;
    given.lines = calloc(given.file->count + 1, sizeof *given.lines);
    given.errors = fopencookie(NULL, "w", (cookie_io_functions_t){.write = write_first_line});
    if (!given.lines || !given.errors)
        return false;
    (void)setvbuf(given.errors, NULL, _IONBF, 0);
    for (size_t i = 0; i < given.file->count; i++)
        given.lines[i] = (struct line_of_word){given.file->words[i], given.file->lines[i]};
    qsort(given.lines, given.file->count, sizeof *given.lines, by_address);
    return true;
}

/* @return line of the word in which a text lies; 0: in none */
static size_t line_of(const char *text)
{
    size_t low = 0, high = given.lines ? given.file->count : 0;
    while (low < high) { /* the last word that begins before the text, or with it */
        const size_t middle = low + (high - low) / 2;
        if ((uintptr_t)given.lines[middle].word <= (uintptr_t)text)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0 || !text)
        return 0;
    const struct line_of_word *one = &given.lines[low - 1];
    return (uintptr_t)text - (uintptr_t)one->word <= strlen(one->word) ? one->line : 0;
}

static size_t line_of_twin(size_t twin)
{
    const size_t count = given.lines ? given.file->twins : 0;
    if (count == 0 || twin == 0)
        return 0;
    return given.file
        ->twin_lines[twin < count ? twin - 1 : count - 1]; /* a network file, the last one, has any number */
}

static const char *print_place(char room[BUS_PLACE], size_t line)
{
    room[0] = '\0';
    if (line > 0)
        (void)snprintf(room, BUS_PLACE, "%.250s:%zu: ", given.path, line);
    return room;
}

const char *bus_place_of(char room[BUS_PLACE], const char *text)
{
    return print_place(room, line_of(text));
}

const char *bus_place_of_twin(char room[BUS_PLACE], size_t twin)
{
    return print_place(room, line_of_twin(twin));
}

static struct argp_state *at_line(bus_place_t *place, const struct argp_state *state, size_t line)
{
    place->state = *state;
    if (line > 0) {
        (void)snprintf(place->name, sizeof place->name, "%.40s: %.250s:%zu", state->name, given.path, line);
        place->state.name = place->name;
        place->state.err_stream = given.errors;
    }
    return &place->state;
}

struct argp_state *bus_place_at(bus_place_t *place, const struct argp_state *state, const char *text)
{
    return at_line(place, state, line_of(text));
}

struct argp_state *bus_place_at_twin(bus_place_t *place, const struct argp_state *state, size_t twin)
{
    return at_line(place, state, line_of_twin(twin));
}
