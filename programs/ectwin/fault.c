/* SPDX-License-Identifier: MIT */
/* `ectwin fault`: sets or lists faults of running twins. */
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "connection.h"

typedef struct fault_args {
    connection_choice_t twin;
    char text[ECT_FAULT_TEXT];
} fault_args_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    fault_args_t *args = state->input;
    size_t used = strlen(args->text);
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twin;
        return 0;
    case ARGP_KEY_ARG:
        if (snprintf(args->text + used, sizeof args->text - used, "%s%s", used > 0 ? " " : "", text) >=
            (int)(sizeof args->text - used))
            argp_error(state, "a fault is at most %d characters long", ECT_FAULT_TEXT - 1);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void print_fault(const cJSON *line)
{
    char room[32];
    print_text(stdout, connection_text(line, "fault", room));
    putchar('\n');
}

int command_fault(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .children = connection_children,
        .args_doc = "[FAULT]",
        .doc = "Injects a fault into a running chain, as 'drop 5%' or 'hang slave 2' (docs/FAULTS.md); "
               "'off' ends all faults of frames, mails, SDO transfers and states. "
               "Without FAULT: lists the active faults."};
    fault_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    connection_t *connection = connection_open(&args.twin, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", "fault");
    if (args.text[0] != 0)
        cJSON_AddStringToObject(request, "fault", args.text);
    int status = connection_request(connection, request, argv[0], print_fault);
    connection_close(connection);
    return status;
}
