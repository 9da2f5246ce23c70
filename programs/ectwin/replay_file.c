/* SPDX-License-Identifier: MIT */
/* The file of a replay: items, errors, recorded command lines. */
#define _GNU_SOURCE
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "replay_file.h"
#include "run_options.h"

/* --- the command line of a record --------------------------------------------------------------------------------- */

/* Wrong words make the file invalid: the parser's first line is printed, and the exit status is EXIT_OPEN. */
static bool reading_words;

static ssize_t write_first_line(void *cookie, const char *text, size_t length)
{
    static const char hint[] = "Try `";
    bool *done = cookie;
    const char *end = memchr(text, '\n', length);
    *done |= strncmp(text, hint, sizeof hint - 1) == 0; /* getopt has written the line */
    if (!*done)
        (void)fwrite(text, 1, end ? (size_t)(end - text) + 1 : length, stderr);
    *done |= end != NULL;
    return (ssize_t)length;
}

static void end_as_wrong_file(void)
{
    if (!reading_words)
        return;
    fflush(NULL);
    _exit(EXIT_OPEN);
}

typedef struct record_words {
    with_words_t run;
    FILE *errors;
} record_words_t;

static error_t parse_words(int key, char *text, struct argp_state *state)
{
    record_words_t *words = state->input;
    (void)text;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &words->run;
        state->err_stream = words->errors;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

void replay_words(twin_args_t *twins, int count, char **words)
{
    static const struct argp_child children[] = {{&with_words_argp, 0, NULL, 0}, {&run_words_argp, 0, NULL, 0}, {0}};
    static const struct argp argp = {.parser = parse_words, .children = children};
    static const cookie_io_functions_t io = {.write = write_first_line};
    bool first_line_written = false;
    record_words_t run = {.run.twins = twins, .errors = fopencookie(&first_line_written, "w", io)};
    static bool prepared;
    prepared = prepared || atexit(end_as_wrong_file) == 0;
    reading_words = true;
    (void)argp_parse(&argp, count + 1, words, ARGP_NO_HELP, NULL, &run);
    reading_words = false;
    fclose(run.errors);
}

/* --- the file ----------------------------------------------------------------------------------------------------- */

void replay_wrong(replay_t *r, const char *format, ...)
{
    char text[TWIN_MESSAGE];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    r->status = EXIT_OPEN;
    fprintf(stderr, "ectwin replay: '%s': %s\n", r->path, text);
}

void replay_count_request(replay_t *r)
{
    if (!r->begun)
        r->first_ns = r->last_ns = r->item.time_ns;
    const uint64_t now_ns = ect_later(r->last_ns, r->item.time_ns);
    r->begun = true;
    r->bus_ns += now_ns - r->last_ns;
    r->last_ns = now_ns;
    r->requests++;
}

void replay_next(replay_t *r)
{
    r->item = r->ahead;
    if (r->item.bytes && r->item.captured > 0)
        memcpy(r->bytes, r->item.bytes, r->item.captured);
    r->item.bytes = r->bytes;
    if (ect_reader_next(&r->reader, &r->ahead) == ECT_ITEM_WRONG)
        replay_wrong(r, "%s", r->reader.message);
}
