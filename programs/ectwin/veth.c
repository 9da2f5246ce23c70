/* SPDX-License-Identifier: MIT */
/* `ectwin veth`: a pair of interfaces in this network namespace, for kernel masters, which cannot enter another one. */
#define _GNU_SOURCE
#include "bus/net/veth.h"

#include <argp.h>
#include <errno.h>
#include <net/if.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus/net/netns.h"
#include "commands.h"

typedef struct veth_args {
    const char *master;
    char twin[IFNAMSIZ];
} veth_args_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    static const char suffix[] = "-twin";
    veth_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_ARG:
        if (args->master)
            argp_error(state, "one name is enough: the other end is NAME%s", suffix);
        args->master = text;
        return 0;
    case ARGP_KEY_END:
        args->master = args->master ? args->master : "ecat0";
        if (ect_netns_unfit(args->master) || strlen(args->master) + strlen(suffix) >= sizeof args->twin)
            argp_error(state, "'%s': a name has 1 to 10 characters, and no blank, '/' or ':'", args->master);
        snprintf(args->twin, sizeof args->twin, "%s%s", args->master, suffix);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int wait_for_end(void)
{
    sigset_t ends;
    int number;
    sigemptyset(&ends);
    sigaddset(&ends, SIGINT);
    sigaddset(&ends, SIGTERM);
    sigaddset(&ends, SIGHUP);
    return sigwait(&ends, &number);
}

int command_veth(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "[NAME]",
        .doc = "Creates a pair of interfaces in the network of this process, NAME (default ecat0) for a master and "
               "NAME-twin for 'ectwin run -i NAME-twin', and removes the pair at SIGINT, SIGTERM or SIGHUP. The pair "
               "serves masters in the kernel, such as IgH; for other masters 'ectwin with' creates a private network. "
               "Needs CAP_NET_ADMIN."};
    char message[ECT_VETH_MESSAGE];
    veth_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    int signals = open_signals(); /* before the pair is created, so that a signal cannot leave the pair behind */
    if (ect_veth_create(args.master, args.twin, message) < 0) {
        fprintf(stderr, "%s: %s\n", argv[0], message);
        return EXIT_OPEN;
    }
    printf("{\"event\":\"ready\",\"iface\":\"%s\",\"twin\":\"%s\"}\n", args.master, args.twin);
    fflush(stdout);
    (void)wait_for_end();
    if (signals >= 0)
        close(signals);
    if (ect_veth_destroy(args.master) == 0)
        return EXIT_CLEAN;
    fprintf(stderr, "%s: '%s' could not be removed: was it removed already? Else 'sudo ip link del %s'\n", argv[0],
            args.master, args.master);
    return EXIT_RUN;
}
