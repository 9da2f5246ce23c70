/* SPDX-License-Identifier: MIT */
/* A command in the private network of running twins. */
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "connection.h"
#include "launch.h"

typedef struct enter_args {
    connection_choice_t twin;
    char **command;
} enter_args_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    enter_args_t *args = state->input;
    (void)text;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twin;
        return 0;
    case ARGP_KEY_ARG:
        args->command = &state->argv[state->next - 1];
        state->next = state->argc; /* the rest belongs to the command */
        return 0;
    case ARGP_KEY_END:
        if (!args->command)
            argp_error(state, "no command: ectwin enter -s NAME -- CMD ARG...");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static bool same_namespace(const char *theirs, const char *name)
{
    char own[64];
    char texts[2][64] = {"", ""};
    snprintf(own, sizeof own, "/proc/self/ns/%s", name);
    return readlink(theirs, texts[0], sizeof texts[0] - 1) > 0 && readlink(own, texts[1], sizeof texts[1] - 1) > 0 &&
           strcmp(texts[0], texts[1]) == 0;
}

/* Opens a namespace of a process. @param[out] fd  -1: the namespace of this process @return false (errno) */
static bool open_namespace(pid_t pid, const char *name, int *fd)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/ns/%s", (int)pid, name);
    *fd = -1;
    if (same_namespace(path, name))
        return true;
    *fd = open(path, O_RDONLY | O_CLOEXEC);
    return *fd >= 0;
}

/* The user namespace comes first, for it grants the rights for the others. All are opened before, through this
 * process's /proc. @return NULL, or the name of the namespace that failed (errno) */
static const char *enter_namespaces(pid_t pid)
{
    static const char *const names[] = {"user", "net", "mnt"};
    enum { COUNT = sizeof names / sizeof *names };
    int fds[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        if (!open_namespace(pid, names[i], &fds[i]))
            return names[i];
    }
    for (size_t i = 0; i < COUNT; i++) {
        if (fds[i] >= 0 && setns(fds[i], 0) < 0)
            return names[i];
        if (fds[i] >= 0)
            close(fds[i]);
    }
    return NULL;
}

/* Entering a mount namespace changes the working directory to its root. */
static bool enter_from_here(pid_t pid, const char *who)
{
    char here[PATH_MAX];
    bool known = getcwd(here, sizeof here) != NULL;
    const char *failed = enter_namespaces(pid);
    if (!failed)
        return !known || chdir(here) == 0 || chdir("/") == 0;
    fprintf(stderr, "%s: cannot enter the %s namespace of process %d: %s; run it as the user that started the twin\n",
            who, failed, (int)pid, strerror(errno));
    return false;
}

int command_enter(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "-- CMD ARG...",
        .doc = "Runs CMD in the network of a running twin, beside the command of its 'ectwin with'. The interface's "
               "name is in $ECTWIN_IFACE and replaces {} in each ARG, as for 'with'. Exits with CMD's status.",
        .children = connection_children};
    char path[PATH_MAX];
    char room[2][32];
    enter_args_t args = {0};
    argp_parse(&argp, argc, argv, ARGP_IN_ORDER, NULL, &args);
    connection_t *connection = connection_open(&args.twin, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    cJSON *about = connection_about(connection);
    pid_t pid = connection_process(connection);
    connection_path(connection, path, sizeof path);
    connection_close(connection);
    if (pid == 0)
        fprintf(stderr, "%s: the twin runs outside this PID namespace: run it there\n", argv[0]);
    if (!about)
        fprintf(stderr, "%s: the twin does not answer, or is of another version\n", argv[0]);
    if (!about || pid == 0 || !enter_from_here(pid, argv[0]))
        return EXIT_OPEN;
    const char *second = connection_text(about, "iface2", room[1]);
    const char *const masters[ECT_ENDS] = {connection_text(about, "iface", room[0]), *second ? second : NULL};
    launch(argv[0], args.command, masters, *path ? path : NULL);
}
