/* SPDX-License-Identifier: MIT */
#include "replay_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "products.h"

enum { KEY_DATA = 0x400 };

static bool starts_record(const ect_item_t *item)
{
    ect_logged_t logged;
    return item->kind == ECT_ITEM_LOCAL && ect_logged_read(item->bytes, item->captured, &logged) &&
           logged.kind == ECT_LOGGED_START;
}

static void replay_section(replay_t *r, twin_args_t *twins)
{
    if (r->ahead.kind == ECT_ITEM_SECTION || r->ahead.kind == ECT_ITEM_END || r->ahead.kind == ECT_ITEM_WRONG)
        return; /* the file is empty */
    if (twins->count > 0) {
        replay_bus(r, twins);
    } else if (starts_record(&r->ahead)) {
        replay_next(r);
        replay_record(r);
    } else {
        replay_wrong(r, "it was not written by --record; to compare a capture with twins name the devices: FILE "
                        "DEVICE[,DEVICE...]");
    }
}

static void replay_file(replay_t *r, twin_args_t *twins)
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
            replay_section(r, twins);
    }
    if (r->status == EXIT_CLEAN && r->requests == 0 && twins->count == 0)
        replay_wrong(r, "there are no frames in it");
    free(r->bytes);
}

/* --- the command -------------------------------------------------------------------------------------------------- */

typedef struct replay_args {
    twin_args_t twins;
    const char *path, *devices;
    bool data;
} replay_args_t;

static const struct argp_option options[] = {
    {"data", KEY_DATA, NULL, 0, "With DEVICE: compare process data, too (default: counters, AL states, mails)", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    replay_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case KEY_DATA:
        args->data = true;
        return 0;
    case ARGP_KEY_ARG:
        if (args->devices)
            argp_error(state, "two lists of devices: separate the devices by commas");
        if (args->path)
            args->devices = text;
        else
            args->path = text;
        return 0;
    case ARGP_KEY_END:
        if (!args->path)
            argp_error(state, "name the file of a --record, or a capture and the devices to compare it with");
        if (!args->devices && (args->data || twin_args_given(&args->twins)))
            argp_error(state, "options of twins without a DEVICE: a record has its own");
        if (args->devices)
            twin_args_devices(&args->twins, state, args->devices);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void print_result(const replay_t *r)
{
    if (r->status == EXIT_CLEAN)
        printf("%s: %" PRIu64 " frames and %" PRIu64 " replies in %.3f s of the bus: all equal\n", r->path, r->requests,
               r->replies, (double)r->bus_ns / 1e9);
}

int command_replay(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "With DEVICE, the twins:", 1}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "FILE\nFILE DEVICE[,DEVICE...]",
        .doc = "Replays the frames of FILE to twins, on a virtual clock. With a FILE of --record every reply must "
               "be equal, byte for byte. With any other capture (pcapng, pcap) and the devices of its bus, the report "
               "names the differences between the bus and the twins. Exits with 0 when all is equal, 1 after a "
               "difference, 2 for a wrong file (docs/REPLAY.md).",
        .children = children,
    };
    replay_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    replay_t replay = {.path = args.path, .data = args.data};
    product_quiet();
    replay.reader.file = fopen(args.path, "re");
    if (!replay.reader.file) {
        replay_wrong(&replay, "%s", strerror(errno));
        return replay.status;
    }
    replay_file(&replay, &args.twins);
    if (!args.devices)
        print_result(&replay);
    ect_reader_free(&replay.reader);
    fclose(replay.reader.file);
    twin_args_free(&args.twins);
    return replay.status;
}
