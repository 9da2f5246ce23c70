/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"

typedef struct run_args {
    twin_args_t twins;
    const char *iface;
    const char *devices;
} run_args_t;

static const struct argp_option options[] = {
    {"interface", 'i', "IFACE", 0, "The network interface to answer on: a spare NIC or one end of a veth pair", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    run_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case 'i':
        args->iface = text;
        return 0;
    case ARGP_KEY_ARG:
        if (args->devices)
            argp_error(state, "one list of devices is enough: separate them by commas");
        args->devices = text;
        return 0;
    case ARGP_KEY_END:
        if (!args->iface)
            argp_error(state, "name the interface with -i IFACE; 'ip -br link' lists those there are");
        if (!args->devices)
            argp_error(state, "name a device; 'ectwin list' lists those there are");
        twin_args_devices(&args->twins, state, args->devices);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static bool on_signal(void *ctx, int signal_number, bool from_terminal)
{
    (void)ctx;
    (void)from_terminal;
    return signal_number == SIGCHLD;
}

int command_run(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "The twins:", 1}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "DEVICE[,DEVICE...]",
        .doc = "Answers EtherCAT frames on an interface as a chain of devices, until SIGINT, SIGTERM or SIGHUP.",
        .children = children,
    };
    run_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);

    int signals = open_signals(); /* first: from here on a signal ends it in good order */
    char message[ECT_PACKET_MESSAGE];
    ect_packet_t port;
    if (ect_packet_open(&port, args.iface, message) < 0) {
        fprintf(stderr, "ectwin run: %s\n", message);
        twin_args_free(&args.twins);
        return EXIT_OPEN;
    }
    ect_control_t *control = open_control("ectwin run");
    ect_chain_t *chain;
    int status = twin_args_power_on(&args.twins, "ectwin run", &chain);
    if (status == EXIT_CLEAN) {
        const ect_runner_t runner = {.port = &port,
                                     .chain = chain,
                                     .control = control,
                                     .faults = &args.twins.faults,
                                     .signal_fd = signals,
                                     .on_signal = on_signal};
        print_ready(stdout, port.iface, args.twins.count);
        if (signals < 0 || ect_runner_run(&runner) != 0) {
            fprintf(stderr, "ectwin run: stopped on '%s': %s\n", port.iface, strerror(errno));
            status = EXIT_RUN;
        }
    }
    ect_control_close(control);
    ect_chain_free(chain);
    ect_packet_close(&port);
    close(signals);
    twin_args_free(&args.twins);
    return status;
}
