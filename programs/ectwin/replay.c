/* SPDX-License-Identifier: MIT */
#include "replay.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "products.h"

static bool starts_record(const ect_item_t *item)
{
    ect_logged_t logged;
    return item->kind == ECT_ITEM_LOCAL && ect_logged_read(item->bytes, item->captured, &logged) &&
           logged.kind == ECT_LOGGED_START;
}

static void replay_section(replay_t *r)
{
    if (r->ahead.kind == ECT_ITEM_SECTION || r->ahead.kind == ECT_ITEM_END || r->ahead.kind == ECT_ITEM_WRONG)
        return; /* it is empty */
    if (starts_record(&r->ahead)) {
        replay_next(r);
        replay_record(r);
    } else {
        replay_wrong(r, "it was not written by --record");
    }
}

static void replay_file(replay_t *r)
{
    r->bytes = malloc(ECT_READER_BLOCK);
    if (!r->bytes) {
        replay_wrong(r, "not enough memory");
        return;
    }
    replay_next(r); /* the first section */
    while (r->status == EXIT_CLEAN && r->ahead.kind != ECT_ITEM_END) {
        replay_next(r);
        if (r->status == EXIT_CLEAN)
            replay_section(r);
    }
    if (r->status == EXIT_CLEAN && r->requests == 0)
        replay_wrong(r, "there are no frames in it");
    free(r->bytes);
}

/* --- the command -------------------------------------------------------------------------------------------------- */

static error_t parse(int key, char *text, struct argp_state *state)
{
    const char **path = state->input;
    switch (key) {
    case ARGP_KEY_ARG:
        if (*path)
            argp_error(state, "one file at a time: '%s' is a second one", text);
        *path = text;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "name the file of a --record");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void print_result(const replay_t *r)
{
    if (r->status == EXIT_CLEAN)
        printf("%s: %" PRIu64 " frames and %" PRIu64 " replies in %.3f s of the bus: all equal\n", r->path, r->requests,
               r->replies, (double)(r->last_ns - r->first_ns) / 1e9);
}

int command_replay(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "FILE",
        .doc = "Gives the twins of a run the frames of FILE again, which --record has written, at the same times of a "
               "virtual clock. Every reply must be equal, byte for byte. Exits with 0 when all are equal, 1 after the "
               "first difference, 2 for a wrong file (docs/REPLAY.md).",
    };
    replay_t replay = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &replay.path);
    product_quiet();
    replay.reader.file = fopen(replay.path, "re");
    if (!replay.reader.file) {
        replay_wrong(&replay, "%s", strerror(errno));
        return replay.status;
    }
    replay_file(&replay);
    print_result(&replay);
    ect_reader_free(&replay.reader);
    fclose(replay.reader.file);
    return replay.status;
}
