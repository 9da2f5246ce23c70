/* SPDX-License-Identifier: MIT */
/* Pulls and restores plugs of a slave or of one wire, which are signals of a running twin (`ecat.plug_*`). */
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "connection.h"
#include "text/number.h"

enum { PORTS = 4 };

static const char *const plugs[PORTS] = {"ecat.plug_in", "ecat.plug_out", "ecat.plug_2", "ecat.plug_3"};

typedef struct plug_args {
    connection_choice_t twin;
    const char *what;
    bool wire;      /* the operand is N.PORT, not N */
    char slave[64]; /* number, name or alias:N */
    unsigned int port;
} plug_args_t;

/* @return behind the number, name or alias:N with which a text begins; NULL: with none of them */
static const char *behind_slave(const char *text)
{
    static const char prefix[] = "alias:";
    uint64_t number = 0;
    if (strncmp(text, prefix, sizeof prefix - 1) == 0)
        return ect_number_begins(text + sizeof prefix - 1, 1, UINT16_MAX, &number);
    const size_t length = ect_name_begins(text);
    return length > 0 ? text + length : ect_number_begins(text, 1, UINT16_MAX, &number);
}

static void take_what(plug_args_t *args, const struct argp_state *state, const char *text)
{
    if (args->what)
        argp_error(state, "one is enough: '%s'", args->what);
    args->what = text;
    const char *rest = behind_slave(text);
    if (!args->wire && (!rest || *rest != 0))
        argp_error(state, "name the slave, from 1, by its name or as alias:17, not '%s'", text);
    if (args->wire && (!rest || rest[0] != '.' || rest[1] < '0' || rest[1] >= '0' + PORTS || rest[2] != 0))
        argp_error(state, "name the slave, from 1, by its name or as alias:17, and its port, as in 2.1, not '%s'",
                   text);
    snprintf(args->slave, sizeof args->slave, "%.*s", (int)(rest - text), text);
    args->port = args->wire ? (unsigned int)(rest[1] - '0') : 0;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    plug_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twin;
        return 0;
    case ARGP_KEY_ARG:
        take_what(args, state, text);
        return 0;
    case ARGP_KEY_END:
        if (!args->what)
            argp_error(state,
                       args->wire
                           ? "name the slave, from 1 or by its name, and its port: 2.1 is the output of the second"
                           : "name the slave, from 1 or by its name");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int set_plugs(const plug_args_t *args, const char *who, bool in)
{
    connection_t *connection = connection_open(&args->twin, who);
    if (!connection)
        return EXIT_OPEN;
    cJSON *request = cJSON_CreateObject();
    cJSON *values = cJSON_AddObjectToObject(request, "values");
    cJSON_AddStringToObject(request, "op", "set");
    connection_add_slave(request, args->slave);
    for (unsigned int port = 0; port < PORTS; port++) {
        if (!args->wire || port == args->port)
            cJSON_AddNumberToObject(values, plugs[port], in ? 1 : 0);
    }
    int status = connection_request(connection, request, who, NULL);
    connection_close(connection);
    return status;
}

static int command(int argc, char **argv, const char *doc, bool wire, bool in)
{
    const struct argp argp = {.parser = parse,
                              .children = connection_children,
                              .args_doc = wire ? "N.PORT\nNAME.PORT\nalias:N.PORT" : "N\nNAME\nalias:N",
                              .doc = doc};
    plug_args_t args = {.wire = wire};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    return set_plugs(&args, argv[0], in);
}

int command_unplug(int argc, char **argv)
{
    return command(argc, argv,
                   "Pulls all plugs of slave N: the slave and all slaves behind it leave the bus. alias:N is the slave "
                   "with station "
                   "alias or device id N: the head of a hot-connect group.",
                   false, false);
}

int command_plug(int argc, char **argv)
{
    return command(argc, argv, "Plugs slave N in again, at all its ports.", false, true);
}

int command_cut(int argc, char **argv)
{
    return command(argc, argv, "Cuts the wire at a port of slave N: 0 input, 1 output, 2 and 3 ports of a junction.",
                   true, false);
}

int command_mend(int argc, char **argv)
{
    return command(argc, argv,
                   "Mends the wire at a port of slave N that 'ectwin cut' has cut: 0 input, 1 output, 2 and 3 ports of "
                   "a junction.",
                   true, true);
}
