/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/netns.h"
#include "commands.h"

typedef struct with_args {
    twin_args_t twins;
    const char *devices;
    char **command;
} with_args_t;

typedef struct child {
    pid_t pid;
    int status; /* of the command, as a shell would give it; -1: still running */
} child_t;

enum { STATUS_NOT_FOUND = 127, STATUS_NOT_EXECUTABLE = 126, STATUS_SIGNALLED = 128 };

static error_t parse(int key, char *text, struct argp_state *state)
{
    with_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case ARGP_KEY_ARG:
        if (!args->devices) {
            args->devices = text;
            return 0;
        }
        args->command = &state->argv[state->next - 1];
        state->next = state->argc; /* the rest is the command's */
        return 0;
    case ARGP_KEY_END:
        if (!args->devices)
            argp_error(state, "name a device; 'ectwin list' lists those there are");
        if (!args->command)
            argp_error(state, "name the command to run: ectwin with %s -- CMD ARG...", args->devices);
        twin_args_devices(&args->twins, state, args->devices);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* `text` with each {} replaced by the name of the master's interface. */
static char *with_interface(const char *text)
{
    static const char mark[] = "{}";
    size_t marks = 0;
    for (const char *at = strstr(text, mark); at; at = strstr(at + 2, mark))
        marks++;
    char *result = malloc(strlen(text) + marks * strlen(ECT_NETNS_MASTER) + 1);
    if (!result)
        return NULL;
    char *out = result;
    const char *from = text;
    for (const char *at = strstr(from, mark); at; at = strstr(from, mark)) {
        out = mempcpy(out, from, (size_t)(at - from));
        out = stpcpy(out, ECT_NETNS_MASTER);
        from = at + 2;
    }
    stpcpy(out, from);
    return result;
}

static void run_command(char **command, pid_t parent, const ect_control_t *control)
{
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    signal(SIGPIPE, SIG_DFL);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) /* it died before that took effect */
        _exit(EXIT_RUN);
    setenv("ECTWIN_IFACE", ECT_NETNS_MASTER, 1);
    if (control)
        setenv("ECTWIN_SOCKET", ect_control_path(control), 1);
    for (char **argument = command + 1; *argument; argument++) {
        char *replaced = with_interface(*argument);
        *argument = replaced ? replaced : *argument;
    }
    execvp(command[0], command);
    int error = errno;
    fprintf(stderr, "ectwin with: cannot run '%s': %s\n", command[0], strerror(error));
    _exit(error == ENOENT ? STATUS_NOT_FOUND : STATUS_NOT_EXECUTABLE);
}

static bool reap(child_t *child)
{
    int status;
    if (waitpid(child->pid, &status, WNOHANG) != child->pid)
        return false;
    child->status = WIFEXITED(status) ? WEXITSTATUS(status) : STATUS_SIGNALLED + WTERMSIG(status);
    return true;
}

/* The command decides when it is over; a wish to end is passed on to it, unless the terminal has told it already. */
static bool on_signal(void *ctx, int signal_number, bool from_terminal)
{
    child_t *child = ctx;
    if (signal_number == SIGCHLD)
        return !reap(child);
    if (!from_terminal)
        kill(child->pid, signal_number);
    return true;
}

static int serve(with_args_t *args, ect_packet_t *port, ect_chain_t *chain, ect_control_t *control, int signals)
{
    child_t child = {.status = -1};
    pid_t self = getpid();
    print_ready(stderr, ECT_NETNS_MASTER, args->twins.count);
    fflush(NULL);
    child.pid = fork();
    if (child.pid == 0)
        run_command(args->command, self, control);
    const ect_runner_t runner = {.port = port,
                                 .chain = chain,
                                 .control = control,
                                 .faults = &args->twins.faults,
                                 .signal_fd = signals,
                                 .on_signal = on_signal,
                                 .ctx = &child};
    if (child.pid > 0 && ect_runner_run(&runner) == 0)
        return child.status;
    fprintf(stderr, "ectwin with: stopped: %s\n", strerror(errno));
    if (child.pid > 0) {
        kill(child.pid, SIGTERM);
        (void)waitpid(child.pid, NULL, 0);
    }
    return EXIT_RUN;
}

int command_with(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "The twins:", 1}, {0}};
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "DEVICE[,DEVICE...] -- CMD ARG...",
        .doc = "Runs CMD on a private network with these devices at the other end of its wire. The interface's name "
               "is in $ECTWIN_IFACE and replaces {} in each ARG. Needs no root. Exits with CMD's status.",
        .children = children,
    };
    with_args_t args = {0};
    argp_parse(&argp, argc, argv, ARGP_IN_ORDER, NULL, &args);

    char message[ECT_NETNS_MESSAGE];
    ect_packet_t port;
    ect_control_t *control = open_control("ectwin with"); /* outside: where its user will look for it */
    if (ect_netns_enter(message) < 0 || ect_packet_open(&port, ECT_NETNS_TWIN, message) < 0) {
        fprintf(stderr, "ectwin with: %s\n", message);
        ect_control_close(control);
        twin_args_free(&args.twins);
        return EXIT_OPEN;
    }
    int signals = open_signals();
    ect_chain_t *chain;
    int status = twin_args_power_on(&args.twins, "ectwin with", &chain);
    if (status == EXIT_CLEAN)
        status = serve(&args, &port, chain, control, signals);
    ect_control_close(control);
    ect_chain_free(chain);
    ect_packet_close(&port);
    close(signals);
    twin_args_free(&args.twins);
    return status;
}
