/* SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "bus_args.h"

static error_t parse(int key, char *text, struct argp_state *state)
{
    return bus_operand_parse(state->input, key, text, state);
}

int command_check(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "The twins:", 1}, {0}};
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "BUS.yaml|eni:FILE.xml|DEVICE[,DEVICE...]",
        .doc = "Checks a bus file, or a chain of devices with its options, without running it: its devices exist, its "
               "signals, connections and faults fit. Opens neither an interface nor a store.",
        .children = children,
    };
    bus_operand_t args = {0};
    ect_chain_t *chain;
    bus_args_expand(&argp, &argc, &argv);
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    args.twins.store = args.twins.files = NULL;
    args.twins.eoe.has_hosts = true; /* as the commands that run the bus */
    int status = twin_args_power_on(&args.twins, argv[0], 0, &chain);
    if (status == EXIT_CLEAN)
        printf("%zu twin%s: %s\n", args.twins.count, args.twins.count == 1 ? "" : "s", args.devices);
    ect_chain_free(chain);
    twin_args_free(&args.twins);
    return status;
}
