/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/net/netns.h"
#include "bus_args.h"
#include "commands.h"
#include "contain.h"
#include "inprocess.h"
#include "launch.h"
#include "run_options.h"

typedef struct with_args {
    twin_args_t twins;
    const char *devices;
    char *masters[ECT_NETNS_WIRES]; /* names of the master's interfaces */
    char *external;                 /* command of the external slave; NULL: twins */
    bool leave_children;
    bool in_process, virtual_time;
    bool plant; /* --plant */
    bool require_private;
    char **command;
} with_args_t;

/* Processes of the command and of the slave of --external: each the program itself, or process 1 of its namespace. */
typedef struct child {
    pid_t pid;
    int status;       /* exit status as in a shell; -1: still running */
    pid_t slave;      /* 0: none */
    int slave_status; /* as `status` */
} child_t;

/* Arguments of a child process. */
typedef struct start {
    const with_args_t *args;
    const ect_control_t *control; /* NULL: none */
    int ready;                    /* descriptor for the ready line of the slave */
} start_t;

static void take_names(with_args_t *args, const struct argp_state *state, char *names)
{
    args->masters[0] = strsep(&names, ",");
    args->masters[1] = strsep(&names, ",");
    for (size_t i = 0; i < ECT_NETNS_WIRES && args->masters[i]; i++) {
        const char *why = ect_netns_unfit(args->masters[i]);
        if (why)
            argp_error(state, "--iface '%s': %s", args->masters[i], why);
    }
    if (names || (args->masters[1] && strcmp(args->masters[0], args->masters[1]) == 0))
        argp_error(state, "--iface takes one name, or two that differ");
}

static void check_in_process(const with_args_t *args, const struct argp_state *state)
{
    if (args->virtual_time && !args->in_process)
        argp_error(state, "--virtual-time needs --in-process: the clock of a network cannot be virtual");
    if (args->plant && !args->virtual_time)
        argp_error(state, "--plant needs --virtual-time: on the real clock start the plant beside the twins");
    if (args->in_process && args->external)
        argp_error(state, "--external is a process of its own, and --in-process has none: leave one of them out");
    if (args->in_process && (args->twins.modbus || args->twins.udp || args->twins.realtime != 0 ||
                             args->twins.busy_poll || args->twins.in_kernel))
        argp_error(
            state,
            "--modbus, --udp, --realtime, --busy-poll and --in-kernel need a process of the twins' own: leave out "
            "--in-process");
}

static void check_arguments(with_args_t *args, const struct argp_state *state)
{
    if (!args->devices && !args->external)
        argp_error(state, "no device: name one; 'ectwin list' lists the devices");
    if (args->devices && args->external)
        argp_error(state, "a device and --external: leave one of them out");
    if (args->external && args->masters[1])
        argp_error(state, "--external has one wire: give --iface one name");
    check_in_process(args, state);
    if (args->external && twin_args_given(&args->twins))
        argp_error(state,
                   "--external is a slave of your own: the options of twins have no effect on it: leave them out");
    if (!args->command)
        argp_error(state, "no command: ectwin with %s -- CMD ARG...",
                   args->devices ? args->devices : "--external PROGRAM");
    if (args->devices)
        twin_args_devices(&args->twins, state, args->devices);
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    with_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case KEY_IFACE:
        take_names(args, state, text);
        return 0;
    case KEY_LEAVE_CHILDREN:
        args->leave_children = true;
        return 0;
    case KEY_IN_PROCESS:
        args->in_process = true;
        return 0;
    case KEY_VIRTUAL_TIME:
        args->virtual_time = true;
        return 0;
    case KEY_PLANT:
        args->plant = true;
        return 0;
    case KEY_REQUIRE_PRIVATE:
        args->require_private = true;
        return 0;
    case KEY_EXTERNAL:
        args->external = text;
        return 0;
    case ARGP_KEY_ARG:
        if (!args->devices && !args->external) {
            args->devices = text;
            args->twins.words = state->argv + 1;
            args->twins.word_count = state->next - 1;
            return 0;
        }
        args->command = &state->argv[state->next - 1];
        state->next = state->argc; /* the rest belongs to the command */
        return 0;
    case ARGP_KEY_END:
        check_arguments(args, state);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void unblock_signals(void)
{
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
}

static void run_command(const void *ctx)
{
    const start_t *start = ctx;
    const with_args_t *args = start->args;
    unblock_signals();
    const char *const masters[ECT_ENDS] = {args->masters[0], args->masters[1]};
    launch("ectwin with", args->command, masters, start->control ? ect_control_path(start->control) : NULL);
}

/* @return whether the command has ended */
static bool reap(child_t *child)
{
    int status;
    pid_t pid;
    while ((pid = waitpid(-1, &status, WNOHANG)) > 0) {
        if (pid == child->pid)
            child->status = contain_status(status);
        if (pid == child->slave)
            child->slave_status = contain_status(status);
    }
    return child->status >= 0;
}

/* Forwards a signal to the command, which decides when to end. The terminal sends its signals to both. */
static bool on_signal(void *ctx, int signal_number, bool from_terminal)
{
    child_t *child = ctx;
    if (signal_number == SIGCHLD)
        return !reap(child);
    if (!from_terminal)
        kill(child->pid, signal_number);
    return true;
}

/* --leave-children: no PID namespace, whose end would kill the children. */
static pid_t start_freely(const start_t *start)
{
    pid_t self = getpid();
    pid_t pid = fork();
    if (pid != 0)
        return pid;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != self) /* the parent ended before PR_SET_PDEATHSIG took effect */
        _exit(EXIT_RUN);
    run_command(start);
    _exit(EXIT_RUN);
}

/* @return false: the command does not run; the reason is printed */
static bool start_command(const with_args_t *args, child_t *child, const ect_control_t *control)
{
    const start_t start = {.args = args, .control = control};
    fflush(NULL);
    child->pid = args->leave_children ? start_freely(&start) : contain_start(run_command, &start);
    if (child->pid < 0)
        fprintf(stderr, "ectwin with: cannot start another process: %s\n", strerror(errno));
    return child->pid > 0;
}

/* Ends a running child and all processes of its namespace. */
static void end_child(pid_t pid, int status)
{
    int unused;
    if (pid <= 0 || status >= 0)
        return;
    kill(pid, SIGTERM);
    for (unsigned int i = 0; i < 40 && waitpid(pid, &unused, WNOHANG) == 0; i++)
        usleep(50000);
    kill(pid, SIGKILL);
}

static int serve(with_args_t *args, session_t *session)
{
    child_t child = {.status = -1};
    const char *modbus = session_modbus(session);
    (void)print_ready(stderr, args->masters, args->twins.count, modbus, session_udp(session));
    if (modbus)
        setenv("ECTWIN_MODBUS", modbus, 1);
    if (session_udp(session))
        setenv("ECTWIN_UDP", session_udp(session), 1);
    bool started = start_command(args, &child, session->runner.exchange.control);
    session_drop_rights(session, true);
    int status = started ? session_run(session, on_signal, &child) : EXIT_RUN;
    if (started)
        end_child(child.pid, child.status);
    return session_verdict(session, status == EXIT_CLEAN ? child.status : status);
}

static void report_lacks(unsigned int lacks)
{
    if ((lacks & ECT_NETNS_USER_NAMESPACE) != 0)
        fputs("ectwin with: no user namespace can be made on this system, so CMD is root on the whole machine\n",
              stderr);
    if ((lacks & ECT_NETNS_OWN_SYSFS) != 0)
        fputs("ectwin with: /sys cannot be mounted again on this system, so /sys/class/net shows CMD the interfaces "
              "outside\n",
              stderr);
}

static int enter_network(const with_args_t *args)
{
    char message[ECT_NETNS_MESSAGE];
    unsigned int lacks;
    const char *const masters[ECT_NETNS_WIRES] = {args->masters[0], args->masters[1]};
    if (ect_netns_enter(masters, &lacks, message) < 0) {
        fprintf(stderr, "ectwin with: %s\n", message);
        return EXIT_OPEN;
    }
    if (!args->twins.quiet)
        report_lacks(lacks);
    if (lacks == 0 || !args->require_private)
        return EXIT_CLEAN;
    fputs("ectwin with: CMD is not run, because of --require-private: allow user namespaces, or leave the option out\n",
          stderr);
    return EXIT_OPEN;
}

/* --- an external slave ------------------------------------------------------------------------------------------- */

/* Standard output is for CMD: the slave's output goes to standard error, its ready line to a descriptor of its own. */
static void run_slave(const void *ctx)
{
    const start_t *start = ctx;
    char descriptor[12];
    unblock_signals();
    signal(SIGPIPE, SIG_DFL); /* as for CMD */
    snprintf(descriptor, sizeof descriptor, "%d", start->ready);
    setenv("ECTWIN_READY_FD", descriptor, 1);
    (void)dup2(STDERR_FILENO, STDOUT_FILENO);
    execl("/bin/sh", "sh", "-c", "eval \"exec $1 -i $2\"", "ectwin with", start->args->external, ect_netns_twin[0],
          (char *)NULL);
    fprintf(stderr, "ectwin with: cannot run '/bin/sh': %s\n", strerror(errno));
    _exit(EXIT_RUN);
}

/* Without a ready line, waits as long as a firmware takes to start. A slave that ends closes the descriptor a moment
 * before its end is reported. */
static void wait_until_ready(child_t *child, int ready)
{
    enum { PATIENCE_MS = 5000, END_MS = 1000 };
    char line[512];
    struct pollfd fd = {.fd = ready, .events = POLLIN};
    ssize_t length = poll(&fd, 1, PATIENCE_MS) > 0 ? read(ready, line, sizeof line) : -1;
    if (length > 0)
        (void)fwrite(line, 1, (size_t)length, stderr);
    for (int ms = 0; length == 0 && child->slave_status < 0 && ms < END_MS; ms++) {
        (void)poll(NULL, 0, 1);
        (void)reap(child);
    }
}

/* @return false: the slave does not run; the reason is printed */
static bool start_slave(const with_args_t *args, child_t *child)
{
    int ready[2] = {-1, -1};
    child->slave = -1;
    if (pipe(ready) == 0) {
        const start_t start = {.args = args, .ready = ready[1]};
        (void)fcntl(ready[0], F_SETFD, FD_CLOEXEC);
        child->slave = contain_start(run_slave, &start);
    }
    if (child->slave < 0)
        fprintf(stderr, "ectwin with: cannot start '%s': %s\n", args->external, strerror(errno));
    close(ready[1]);
    if (child->slave > 0)
        wait_until_ready(child, ready[0]);
    close(ready[0]);
    (void)reap(child);
    return child->slave > 0 && child->slave_status < 0;
}

/* Waits until the command or the slave ends. */
static void wait_for_end(child_t *child, int signal_fd)
{
    struct signalfd_siginfo info;
    struct pollfd fd = {.fd = signal_fd, .events = POLLIN};
    while (child->status < 0 && child->slave_status < 0 && poll(&fd, 1, -1) >= 0) {
        if (read(signal_fd, &info, sizeof info) == (ssize_t)sizeof info)
            (void)on_signal(child, (int)info.ssi_signo, info.ssi_code == SI_KERNEL);
    }
}

static int serve_external(const with_args_t *args)
{
    child_t child = {.status = -1, .slave_status = -1};
    int signal_fd = open_signals();
    if (signal_fd < 0) {
        fprintf(stderr, "ectwin with: cannot wait for signals: %s\n", strerror(errno));
        return EXIT_RUN;
    }
    if (enter_network(args) != EXIT_CLEAN)
        return EXIT_OPEN;
    fflush(NULL);
    if (start_slave(args, &child) && start_command(args, &child, NULL))
        wait_for_end(&child, signal_fd);
    if (child.slave_status >= 0 && child.status < 0)
        fprintf(stderr, "ectwin with: '%s' has ended with status %d\n", args->external, child.slave_status);
    end_child(child.pid, child.status);
    end_child(child.slave, child.slave_status);
    close(signal_fd);
    return child.status >= 0 ? child.status : EXIT_RUN;
}

/* --- twins inside CMD ----------------------------------------------------------------------------------------------
 */

/* Signals the processes left behind by CMD, which become children of this process, a subreaper, when their parents end.
 * @return whether there are any */
static bool signal_orphans(int signal_number)
{
    char path[64];
    bool any = false;
    int pid;
    snprintf(path, sizeof path, "/proc/self/task/%d/children", (int)getpid());
    FILE *children = fopen(path, "re");
    while (children && fscanf(children, "%d", &pid) == 1) {
        any = true;
        kill(pid, signal_number);
    }
    if (children)
        fclose(children);
    return any;
}

static void end_orphans(void)
{
    enum { ROUNDS = 40, GENTLE_ROUNDS = 20, PAUSE_US = 50000 };
    for (unsigned int round = 0; round < ROUNDS; round++) {
        while (waitpid(-1, NULL, WNOHANG) > 0)
            ;
        if (!signal_orphans(round < GENTLE_ROUNDS ? SIGTERM : SIGKILL))
            return;
        usleep(PAUSE_US);
    }
}

/* Powers the twins on once, to report errors before CMD starts. */
static int try_power_on(with_args_t *args)
{
    ect_chain_t *chain = NULL;
    ect_trace_t *trace = NULL;
    int status = twin_args_power_on(&args->twins, "ectwin with", 0, &chain);
    if (status == EXIT_CLEAN)
        status = twin_args_trace(&args->twins, "ectwin with", &trace);
    (void)twin_args_end_trace(&args->twins, "ectwin with", trace, 0);
    if (trace && args->twins.pcap)
        (void)!truncate(args->twins.pcap, 0); /* each bus appends a section */
    if (trace && args->twins.record)
        (void)!truncate(args->twins.record, 0);
    ect_chain_free(chain);
    return status;
}

static int wait_in_process(const with_args_t *args, int signal_fd)
{
    child_t child = {.status = -1, .slave_status = -1};
    const start_t start = {.args = args};
    fflush(NULL);
    child.pid = start_freely(&start);
    if (child.pid < 0) {
        fprintf(stderr, "ectwin with: cannot start another process: %s\n", strerror(errno));
        return EXIT_RUN;
    }
    wait_for_end(&child, signal_fd);
    if (!args->leave_children)
        end_orphans();
    return child.status;
}

static int serve_in_process(with_args_t *args)
{
    char message[INPROCESS_MESSAGE];
    const char *const interfaces[] = {args->masters[0], args->masters[1]};
    in_process_t twins = {.virtual_time = args->virtual_time,
                          .words = args->twins.words,
                          .word_count = args->twins.word_count,
                          .command = args->command[0],
                          .interfaces = interfaces,
                          .interface_count = args->masters[1] ? 2 : 1};
    int signal_fd = open_signals();
    (void)prctl(PR_SET_CHILD_SUBREAPER, 1);
    int status = try_power_on(args);
    size_t count = args->twins.count;
    bool expects = args->twins.scenario.verdict.all > 0;
    twin_args_free(&args->twins);
    if (status == EXIT_CLEAN && !in_process_prepare(&twins, message)) {
        fprintf(stderr, "ectwin with: %s\n", message);
        status = EXIT_OPEN;
    }
    if (status != EXIT_CLEAN)
        return status;
    (void)print_ready(stderr, args->masters, count, NULL, NULL);
    status = wait_in_process(args, signal_fd);
    bool met = !expects;
    bool used = in_process_finish(&twins, &met);
    if (!used && status != LAUNCH_NOT_FOUND && status != LAUNCH_NOT_EXECUTABLE)
        fprintf(
            stderr,
            "ectwin with: '%s' has not opened %s through the C library (a static or setuid program, Go, system calls "
            "of its own that this kernel or C library does not report): run it without --in-process\n",
            args->command[0], args->masters[0]);
    return status == EXIT_CLEAN && !met ? EXIT_RUN : status;
}

int command_with(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "The twins:", 1}, {0}};
    static const struct argp argp = {
        .options = with_options,
        .parser = parse,
        .args_doc = "DEVICE[,DEVICE...] -- CMD ARG...\nBUS.yaml -- CMD ARG...\neni:FILE.xml -- CMD ARG...\n--external "
                    "PROGRAM -- CMD ARG...",
        .doc = "Runs CMD on a private network whose other end is a chain of these devices. The interface's name "
               "is in $ECTWIN_IFACE and replaces {} in each ARG. Needs no root. Exits with CMD's status.",
        .children = children,
    };
    static char master[] = "ecat0";
    with_args_t args = {.masters = {master}};
    bus_args_expand(&argp, &argc, &argv);
    argp_parse(&argp, argc, argv, ARGP_IN_ORDER, NULL, &args);

    if (args.external)
        return serve_external(&args);
    if (args.in_process)
        return serve_in_process(&args);
    session_t session;
    session_init(&session, "ectwin with", &args.twins);
    session.runner.signal_fd = open_signals(); /* first: with SIGCHLD ignored, waiting for a child is impossible */
    int status = session_open_control(&session, args.masters); /* outside the namespace, for the user's clients */
    if (status == EXIT_CLEAN)
        status = session_power_on(&session); /* outside too: with the user's files and rights */
    if (status == EXIT_CLEAN)
        status = enter_network(&args);
    const char *const ends[ECT_ENDS] = {ect_netns_twin[0], args.masters[1] ? ect_netns_twin[1] : NULL};
    if (status == EXIT_CLEAN)
        status = session_open(&session, ends);
    if (status == EXIT_CLEAN)
        status = session_open_udp(&session); /* inside the namespace, for CMD */
    if (status == EXIT_CLEAN)
        status = session_open_modbus(&session); /* inside too */
    if (status == EXIT_CLEAN)
        status = session_open_hosts(&session);
    if (status == EXIT_CLEAN)
        status = session_attach(&session);
    if (status == EXIT_CLEAN)
        status = serve(&args, &session);
    session_close(&session);
    return status;
}
