/* SPDX-License-Identifier: MIT */
#include <stdlib.h>

#include "bus_args.h"
#include "eni/write.h"
#include "output.h"
#include "text/argument.h"

enum { KEY_CYCLE = 0x300, CYCLE_US = 1000, CYCLE_MOST_US = 1000000 };

typedef struct eni_args {
    bus_operand_t bus;
    const char *output;
    uint32_t cycle_us;
} eni_args_t;

static const struct argp_option options[] = {
    {"output", 'o', "FILE", 0, "Write to FILE (default: standard output)", 0},
    {"cycle", KEY_CYCLE, "US", 0, "Cycle of the process data, microseconds, 1..1000000 (default 1000)", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    eni_args_t *args = state->input;
    switch (key) {
    case 'o':
        args->output = text;
        return 0;
    case KEY_CYCLE:
        args->cycle_us = (uint32_t)ect_argument_number(state, "--cycle", text, 1, CYCLE_MOST_US);
        return 0;
    default:
        return bus_operand_parse(&args->bus, key, text, state);
    }
}

static int write_bus(const eni_args_t *args, const char *who)
{
    char why[200] = "no memory left";
    ect_arena_t arena = {0};
    size_t length = 0;
    int status = EXIT_RUN;
    ect_eni_part_t *parts = calloc(args->bus.twins.count, sizeof *parts);
    for (size_t i = 0; parts && i < args->bus.twins.count; i++) {
        const ect_twin_config_t *twin = &args->bus.twins.twins[i];
        parts[i] = (ect_eni_part_t){.device = twin->device,
                                    .identity = twin->identity,
                                    .alias = twin->alias,
                                    .up = twin->up,
                                    .up_port = twin->up_port};
    }
    const char *file =
        parts ? ect_eni_write(&arena, parts, args->bus.twins.count, args->cycle_us, &length, why, sizeof why) : NULL;
    if (file)
        status = output_save(who, args->output, file, length);
    else
        fprintf(stderr, "%s: %s\n", who, why);
    free(parts);
    ect_arena_free(&arena);
    return status;
}

int command_eni(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "The twins:", 1}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "BUS.yaml|DEVICE[,DEVICE...]",
        .doc = "Writes the network file (ENI) of a bus file or of a chain of devices, for masters that need one: "
               "default PDOs, start-up commands, cyclic frames with LRD and LWR, no synchronisation by clocks.",
        .children = children,
    };
    eni_args_t args = {.cycle_us = CYCLE_US};
    bus_args_expand(&argp, &argc, &argv);
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    int status = write_bus(&args, argv[0]);
    twin_args_free(&args.bus.twins);
    return status;
}
