/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <signal.h>
#include <string.h>

#include "bus_args.h"
#include "commands.h"
#include "run_options.h"

typedef struct run_args {
    twin_args_t twins;
    char *ifaces[ECT_ENDS];
    const char *devices;
} run_args_t;

static void take_interface(run_args_t *args, ect_end_t end, char *name, const struct argp_state *state)
{
    static const char *const options_of[] = {"-i", "-o"};
    if (args->ifaces[end])
        argp_error(state, "%s is given twice; the output of the last device is -o IFACE", options_of[end]);
    args->ifaces[end] = name;
    if (args->ifaces[ECT_END_IN] && args->ifaces[ECT_END_OUT] &&
        strcmp(args->ifaces[ECT_END_IN], args->ifaces[ECT_END_OUT]) == 0)
        argp_error(state, "-i and -o name the same interface: the chain's two ends need one each");
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    run_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case 'i':
        take_interface(args, ECT_END_IN, text, state);
        return 0;
    case 'o':
        take_interface(args, ECT_END_OUT, text, state);
        return 0;
    case ARGP_KEY_ARG:
        if (args->devices)
            argp_error(state, "two lists of devices: separate the devices by commas");
        args->devices = text;
        return 0;
    case ARGP_KEY_END:
        if (!args->ifaces[ECT_END_IN] && !args->twins.udp && (args->ifaces[ECT_END_OUT] || !args->twins.modbus))
            argp_error(state, "no interface: name it with -i IFACE; 'ip -br link' lists the interfaces");
        if (!args->devices)
            argp_error(state, "no device: name one; 'ectwin list' lists the devices");
        twin_args_devices(&args->twins, state, args->devices);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Finds an IP address of an interface, as a sign of its use by other programs; link-local IPv6 does not count. */
static bool find_address(const char *iface, char address[INET6_ADDRSTRLEN])
{
    struct ifaddrs *all = NULL;
    bool found = false;
    if (getifaddrs(&all) < 0)
        return false;
    for (const struct ifaddrs *one = all; one && !found; one = one->ifa_next) {
        if (!one->ifa_addr || strcmp(one->ifa_name, iface) != 0)
            continue;
        const void *sockaddr = one->ifa_addr;
        const struct sockaddr_in *in = sockaddr;
        const struct sockaddr_in6 *in6 = sockaddr;
        if (one->ifa_addr->sa_family == AF_INET)
            found = inet_ntop(AF_INET, &in->sin_addr, address, INET6_ADDRSTRLEN) != NULL;
        else if (one->ifa_addr->sa_family == AF_INET6 && !IN6_IS_ADDR_LINKLOCAL(&in6->sin6_addr))
            found = inet_ntop(AF_INET6, &in6->sin6_addr, address, INET6_ADDRSTRLEN) != NULL;
    }
    freeifaddrs(all);
    return found;
}

/* No hint if this program has just set the interface up: the link may still be negotiating. */
static void print_hints(const ect_packet_t *port)
{
    char address[INET6_ADDRSTRLEN];
    if (!port->was_down && !ect_packet_has_link(port))
        fprintf(stderr, "ectwin run: '%s' has no link: plug the cable in, or bring the other end up\n", port->iface);
    if (find_address(port->iface, address))
        fprintf(stderr,
                "ectwin run: '%s' has the address %s: other traffic shares this wire and delays frames; 'ip addr flush "
                "dev %s' removes it\n",
                port->iface, address, port->iface);
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
        .options = run_options,
        .parser = parse,
        .args_doc = "DEVICE[,DEVICE...]\nBUS.yaml\neni:FILE.xml",
        .doc = "Runs a chain of devices on a network interface until SIGINT, SIGTERM or SIGHUP. Without an "
               "interface: over EtherCAT in UDP (--udp), or one base unit over Modbus TCP (--modbus).",
        .children = children,
    };
    run_args_t args = {0};
    bus_args_expand(&argp, &argc, &argv);
    args.twins.words = argv + 1;
    args.twins.word_count = argc - 1;
    argp_parse(&argp, argc, argv, 0, NULL, &args);

    session_t session;
    session_init(&session, "ectwin run", &args.twins);
    session.runner.signal_fd = open_signals(); /* first, so that a signal ends the command in an orderly way */
    const char *const ends[ECT_ENDS] = {args.ifaces[ECT_END_IN], args.ifaces[ECT_END_OUT]};
    int status = session_open(&session, ends);
    for (unsigned int end = 0; end < ECT_ENDS && status == EXIT_CLEAN; end++) {
        if (ends[end] && !args.twins.quiet)
            print_hints(&session.ports[end]);
    }
    if (status == EXIT_CLEAN)
        status = session_open_udp(&session);
    if (status == EXIT_CLEAN)
        status = session_open_modbus(&session);
    if (status == EXIT_CLEAN)
        status = session_open_control(&session, args.ifaces);
    if (status == EXIT_CLEAN)
        status = session_power_on(&session);
    if (status == EXIT_CLEAN)
        status = session_open_hosts(&session);
    if (status == EXIT_CLEAN)
        status = session_attach(&session);
    if (status == EXIT_CLEAN) {
        session_drop_rights(&session, false);
        bool printed =
            print_ready(stdout, args.ifaces, args.twins.count, session_modbus(&session), session_udp(&session));
        status = printed ? session_verdict(&session, session_run(&session, on_signal, NULL)) : EXIT_OPEN;
    }
    session_close(&session);
    return status;
}
