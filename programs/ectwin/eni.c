/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "bus_args.h"
#include "eni/write.h"
#include "grow.h"
#include "network.h"
#include "output.h"
#include "products.h"
#include "text/argument.h"

enum { KEY_CYCLE = 0x300, KEY_DC, KEY_GROUP };
enum { CYCLE_US = 1000, CYCLE_MOST_US = 1000000 };

/* An argument of --hot-connect, "2:Tool*3". */
typedef struct group {
    uint64_t first; /* number of the first twin, from 1 */
    char *name;
    uint64_t members;
} group_t;

typedef struct eni_args {
    bus_operand_t bus;
    const char *output;
    uint32_t cycle_us;
    bool clocks;
    group_t *groups;
    size_t group_count;
} eni_args_t;

static const struct argp_option options[] = {
    {"output", 'o', "FILE", 0, "Write to FILE (default: standard output)", 0},
    {"cycle", KEY_CYCLE, "US", 0, "Cycle of the process data, microseconds, 1..1000000 (default 1000)", 0},
    {"dc", KEY_DC, NULL, 0,
     "Synchronise by distributed clocks: each device in its first mode with SYNC signals (default: none)", 0},
    {"hot-connect", KEY_GROUP, "N:NAME[*N]", 0,
     "Hot-connect group NAME: twin N, whose alias the master looks for, and the twins behind it, in all as many as "
     "behind the * (default 1). May be repeated",
     0},
    {0},
};

static void add_group(eni_args_t *args, const struct argp_state *state, const char *text)
{
    group_t group = {.members = 1};
    const char *name = ect_number_begins(text, 1, UINT16_MAX, &group.first);
    const char *star = strrchr(text, '*');
    if (!name || *name != ':' || name[1] == '\0' || star == name + 1 ||
        (star && !ect_number(star + 1, 1, UINT16_MAX, &group.members)))
        argp_error(state, "--hot-connect takes the number of a twin and a name, as 2:Tool or 2:Tool*3, not '%s'", text);
    group.name = strndup(name + 1, star ? (size_t)(star - name - 1) : strlen(name + 1));
    args->groups = grow(state, args->groups, args->group_count, sizeof *args->groups);
    args->groups[args->group_count++] = group;
}

static void free_args(eni_args_t *args)
{
    for (size_t i = 0; i < args->group_count; i++)
        free(args->groups[i].name);
    free(args->groups);
    twin_args_free(&args->bus.twins);
}

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
    case KEY_DC:
        args->clocks = true;
        return 0;
    case KEY_GROUP:
        add_group(args, state, text);
        return 0;
    default:
        return bus_operand_parse(&args->bus, key, text, state);
    }
}

static const ect_dc_mode_t *clock_of(const ect_device_t *device)
{
    for (unsigned int i = 0; i < device->dc_mode_count; i++) {
        if (device->dc_modes[i].assign_activate != 0)
            return &device->dc_modes[i];
    }
    return NULL;
}

/* Adopts the groups of a network file, the last operand. */
static void take_groups(const eni_args_t *args, ect_eni_part_t *parts)
{
    char why[PRODUCT_MESSAGE];
    const char *last = strrchr(args->bus.devices, ',') ? strrchr(args->bus.devices, ',') + 1 : args->bus.devices;
    const char *equals = strstr(last, "=eni:");
    const char *path = network_path(equals ? equals + 1 : last);
    const ect_eni_t *eni = path ? product_network(path, why) : NULL;
    const ect_eni_network_t *network = eni ? ect_eni_network(eni) : NULL;
    for (size_t i = 0; network && i < network->slave_count; i++) {
        ect_eni_part_t *part = &parts[args->bus.twins.count - network->slave_count + i];
        part->group = network->slaves[i].group;
        part->members = network->slaves[i].members;
    }
}

/* Sets the groups of the command line. @return false: an impossible group, which is printed */
static bool set_groups(const eni_args_t *args, const char *who, ect_eni_part_t *parts)
{
    const size_t count = args->bus.twins.count;
    for (size_t i = 0; i < args->group_count; i++) {
        const group_t *group = &args->groups[i];
        if (group->first > count || group->members > count - group->first + 1) {
            fprintf(stderr, "%s: --hot-connect %s: the chain has %zu twin%s\n", who, group->name, count,
                    count == 1 ? "" : "s");
            return false;
        }
        ect_eni_part_t *part = &parts[group->first - 1];
        if (part->alias == 0) {
            fprintf(stderr, "%s: --hot-connect %s: twin %zu has no alias, by which a master finds it: --alias %zu:7\n",
                    who, group->name, (size_t)group->first, (size_t)group->first);
            return false;
        }
        part->group = group->name;
        part->members = (unsigned int)group->members;
    }
    return true;
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
                                    .clock = args->clocks ? clock_of(twin->device) : NULL,
                                    .up = twin->up,
                                    .up_port = twin->up_port};
    }
    if (parts)
        take_groups(args, parts);
    if (parts && !set_groups(args, who, parts)) {
        free(parts);
        return EXIT_USAGE;
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
               "default PDOs, start-up commands, mailbox states, cyclic frames with LRD and LWR, and the hot-connect "
               "groups of a network file.",
        .children = children,
    };
    eni_args_t args = {.cycle_us = CYCLE_US};
    bus_args_expand(&argp, &argc, &argv);
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    int status = write_bus(&args, argv[0]);
    free_args(&args);
    return status;
}
