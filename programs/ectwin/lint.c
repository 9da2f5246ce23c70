/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "esi/lint.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "esi/arena.h"
#include "esi/twin.h"

enum { TEXT = 600, KEY_SCHEMA = 0x300, KEY_NOTES = 0x301 };

typedef struct args {
    const char *file, *schema;
    bool quiet;
} args_t;

static const struct argp_option options[] = {
    {"schema", KEY_SCHEMA, "EtherCATInfo.xsd", 0,
     "Validate the file against the schema as well (of the EtherCAT Technology Group; the included files must be "
     "beside it)",
     0},
    {"no-notes", KEY_NOTES, NULL, 0, "Print only mistakes, no notes on allowed but unusual elements", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    switch (key) {
    case KEY_SCHEMA:
        args->schema = text;
        return 0;
    case KEY_NOTES:
        args->quiet = true;
        return 0;
    case ARGP_KEY_ARG:
        if (args->file != NULL)
            argp_error(state, "one file at a time: '%s' is a second one", text);
        args->file = text;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "name the ESI file: FILE.xml or FILE.xml#TYPE");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Mistakes of vendor and groups are found again with each device; each line is printed once. */
typedef struct findings {
    ect_arena_t arena;
    const char **lines;
    size_t count, mistakes;
    bool quiet;
} findings_t;

static void take(void *ctx, bool wrong, const char *line)
{
    findings_t *f = ctx;
    for (size_t i = 0; i < f->count; i++) {
        if (strcmp(f->lines[i], line) == 0)
            return;
    }
    f->lines = ect_arena_grow(&f->arena, f->lines, f->count, sizeof *f->lines);
    f->lines[f->count++] = ect_arena_copy(&f->arena, line, strlen(line));
    f->mistakes += wrong;
    if (wrong || !f->quiet)
        printf("%s%s\n", line, wrong ? "" : " (note)");
}

/* An unreadable or impossible device is a mistake with a line of its own. */
static void lint_device(ect_esi_t *esi, const char *selector, findings_t *f)
{
    char text[TEXT] = "";
    const ect_esi_device_t *device = ect_esi_select(esi, selector, text, sizeof text);
    ect_esi_twin_t *twin = device != NULL ? ect_esi_twin_of(esi, device, NULL, 0, text, sizeof text) : NULL;
    if (device != NULL)
        ect_esi_lint(esi, device, take, f);
    if (twin == NULL)
        take(f, true, text);
    ect_esi_twin_free(twin);
}

/* @return false: the selector names no device of the file */
static bool lint_devices(ect_esi_t *esi, const char *selector, findings_t *f)
{
    size_t count;
    const ect_esi_head_t *heads = ect_esi_heads(esi, &count);
    if (selector != NULL) {
        char text[TEXT] = "";
        if (ect_esi_select(esi, selector, text, sizeof text) == NULL) {
            fprintf(stderr, "ectwin lint: %s\n", text);
            return false;
        }
        lint_device(esi, selector, f);
        return true;
    }
    for (size_t i = 0; i < count; i++) {
        char name[64];
        (void)snprintf(name, sizeof name, "@0x%X/0x%X", (unsigned int)heads[i].product_code,
                       (unsigned int)heads[i].revision);
        lint_device(esi, name, f);
    }
    return true;
}

static int lint(const args_t *args, ect_esi_t *esi, const char *selector)
{
    char text[TEXT] = "";
    findings_t f = {.quiet = args->quiet};
    ect_esi_schema_t *schema = args->schema != NULL ? ect_esi_schema_open(args->schema, text, sizeof text) : NULL;
    int status = EXIT_OPEN;
    if (args->schema != NULL && schema == NULL) {
        fprintf(stderr, "ectwin lint: %s\n", text);
    } else if (!lint_devices(esi, selector, &f)) {
        status = EXIT_USAGE;
    } else {
        if (schema != NULL)
            ect_esi_validate(esi, schema, take, &f);
        status = f.mistakes > 0 ? EXIT_RUN : EXIT_CLEAN;
    }
    ect_esi_schema_close(schema);
    ect_arena_free(&f.arena);
    return status;
}

int command_lint(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "FILE.xml[#TYPE]",
        .doc = "Reports mistakes of an ESI file that engineering tools accept without a message, or misread: order "
               "of elements, names, groups, numbers written 0x..., pictures, ConfigData, obsolete elements; and "
               "impossible devices. Prints one line for each, FILE:LINE: TEXT. Checks all devices of the "
               "file, or those of #TYPE.\v"
               "Exit codes: 0 no mistake, 1 wrong usage, 2 a file cannot be opened or is not an ESI file, 3 mistakes. "
               "Notes do not count.",
    };
    args_t args = {0};
    char text[TEXT] = "";
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    const char *hash = ect_esi_selector(args.file);
    char *path = hash != NULL ? strndup(args.file, (size_t)(hash - args.file)) : strdup(args.file);
    ect_esi_t *esi = path != NULL ? ect_esi_open(path, text, sizeof text) : NULL;
    int status = EXIT_OPEN;
    if (esi != NULL)
        status = lint(&args, esi, hash != NULL ? hash + 1 : NULL);
    else
        fprintf(stderr, "ectwin lint: %s\n", path != NULL ? text : "no memory");
    ect_esi_close(esi);
    free(path);
    return status;
}
