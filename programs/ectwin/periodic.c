/* SPDX-License-Identifier: MIT */
/* The last complete set of a base unit's periodic data (TS-0007 §10.4), as displayed by the remotes. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "connection.h"
#include "output.h"

enum { MOST_BYTES = 51200, MOST_TRIES = 100 };

typedef struct periodic_args {
    connection_choice_t twin;
    const char *slave;
    const char *output;
} periodic_args_t;

static const struct argp_option options[] = {
    {"slave", 'n', "N", 0, "Slave of the chain, by number from 1 or by name (default 1)", 0},
    {"output", 'o', "FILE", 0, "Write the bytes to FILE, -: standard output (default: print a hexadecimal dump)", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    periodic_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twin;
        return 0;
    case 'n':
        args->slave = connection_slave(state, text, 1);
        return 0;
    case 'o':
        args->output = text;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

/* The set, received in pieces; restarted if the twin has a newer set. */
static struct {
    uint8_t bytes[MOST_BYTES];
    size_t have, size;
    double serial;
    bool known; /* `size` and `serial` are valid */
} set;

static double number_of(const cJSON *line, const char *member)
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(line, member);
    return cJSON_IsNumber(value) ? value->valuedouble : -1;
}

static void take_hex(const char *text)
{
    for (; text[0] && text[1] && set.have < set.size; text += 2) {
        char digits[3] = {text[0], text[1], 0};
        set.bytes[set.have++] = (uint8_t)strtoul(digits, NULL, 16);
    }
}

static void take_piece(const cJSON *line)
{
    char room[32];
    double serial = number_of(line, "serial"), size = number_of(line, "size");
    if (!set.known || serial != set.serial) {
        set.known = size >= 0 && size <= (double)MOST_BYTES;
        set.serial = serial;
        set.size = set.known ? (size_t)size : 0;
        set.have = 0;
    }
    if (set.known && number_of(line, "offset") == (double)set.have)
        take_hex(connection_text(line, "data", room));
}

static int fetch(connection_t *connection, const char *slave, const char *who)
{
    int status = EXIT_CLEAN;
    double serial = -1;
    bool newer = false; /* the last reply is of another set than the one before */
    for (unsigned int tries = 0; status == EXIT_CLEAN && tries < MOST_TRIES;) {
        const size_t had = set.have;
        cJSON *request = cJSON_CreateObject();
        cJSON_AddStringToObject(request, "op", "data");
        connection_add_slave(request, slave);
        cJSON_AddNumberToObject(request, "offset", (double)set.have);
        status = connection_request(connection, request, who, take_piece);
        if (status != EXIT_CLEAN || (set.known && set.have == set.size))
            return status;
        newer = set.serial != serial;
        tries += newer || set.have <= had;
        serial = set.serial;
    }
    fprintf(stderr, "%s: %s\n", who,
            newer ? "sets follow each other faster than they can be fetched"
                  : "the replies of the twin have no data: run ectwin and the twin in one version");
    return EXIT_RUN;
}

/* --- output ------------------------------------------------------------------------------------------------------- */

/* Prints offset, sixteen bytes, and these bytes as text. */
static void print_row(size_t at)
{
    printf("%05zx ", at);
    for (size_t i = at; i < at + 16; i++) {
        if (i < set.have)
            printf(" %02x", set.bytes[i]);
        else
            fputs("   ", stdout);
    }
    fputs("  ", stdout);
    for (size_t i = at; i < at + 16 && i < set.have; i++)
        putchar(set.bytes[i] >= ' ' && set.bytes[i] <= '~' ? set.bytes[i] : '.');
    putchar('\n');
}

int command_periodic(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .children = connection_children,
        .doc = "Prints the last complete set of periodic data that the controller has sent to a base unit."};
    periodic_args_t args = {.slave = "1"};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    connection_t *connection = connection_open(&args.twin, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    int status = fetch(connection, args.slave, argv[0]);
    connection_close(connection);
    if (status != EXIT_CLEAN)
        return status;
    if (set.size == 0)
        fprintf(stderr, "%s: no set has come yet\n", argv[0]);
    if (args.output)
        return output_save(argv[0], strcmp(args.output, "-") == 0 ? NULL : args.output, set.bytes, set.have);
    for (size_t at = 0; at < set.have; at += 16)
        print_row(at);
    return EXIT_CLEAN;
}
