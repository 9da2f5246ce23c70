/* SPDX-License-Identifier: MIT */
/* The running twins of this user. */
#define _GNU_SOURCE
#include <argp.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "connection.h"

typedef struct ps_args {
    bool json;
    bool header; /* already printed */
} ps_args_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    ps_args_t *args = state->input;
    (void)text;
    switch (key) {
    case 'j':
        args->json = true;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "it takes no argument");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Reads the network namespace of a process from /proc; "": unreadable. */
static void read_namespace(const char *process, char name[64])
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%s/ns/net", process);
    ssize_t length = readlink(path, name, 63);
    name[length > 0 ? length : 0] = 0;
}

/* "here": the namespace of this command; else the number, as in lsns; "?": unreadable. */
static void name_namespace(pid_t pid, char name[64])
{
    char process[16];
    char own[64];
    snprintf(process, sizeof process, "%d", (int)pid);
    read_namespace(process, name);
    read_namespace("self", own);
    if (*name == 0) /* as of process 0, one of another process namespace */
        strcpy(name, "?");
    else if (strcmp(name, own) == 0)
        strcpy(name, "here");
    else
        sscanf(name, "net:[%63[0-9]", name);
}

static const char *state_name(int state)
{
    static const char *const names[] = {"off", "INIT", "PREOP", "BOOT", "SAFEOP", "5", "6", "7", "OP"};
    return state >= 0 && state < (int)(sizeof names / sizeof *names) ? names[state] : "?";
}

static int number(const cJSON *line, const char *member)
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(line, member);
    return cJSON_IsNumber(value) ? value->valueint : 0;
}

/* "OP"; "PREOP..OP": the slaves differ; "SAFEOP+ERROR": a slave reports an AL status code. */
static void describe_state(const cJSON *about, char state[32])
{
    if (!cJSON_HasObjectItem(about, "lowest")) {
        strcpy(state, "?");
        return;
    }
    int lowest = number(about, "lowest");
    int highest = number(about, "highest");
    snprintf(state, 32, "%s%s%s%s", state_name(lowest), highest != lowest ? ".." : "",
             highest != lowest ? state_name(highest) : "", number(about, "errors") > 0 ? "+ERROR" : "");
}

static void print_as_json(cJSON *about, pid_t pid, const char *namespace, const char *state, const char *path)
{
    cJSON_AddNumberToObject(about, "pid", (double)pid);
    cJSON_AddStringToObject(about, "namespace", namespace);
    cJSON_AddStringToObject(about, "state", state);
    cJSON_AddStringToObject(about, "socket", path);
    print_line(about);
}

static void print_cell(const char *text, int width)
{
    print_text(stdout, text);
    printf("%*s ", width > (int)strlen(text) ? width - (int)strlen(text) : 0, "");
}

static void print_row(const cJSON *about, pid_t pid, const char *namespace, const char *state)
{
    char room[32];
    char process[16] = "?";
    if (pid > 0)
        snprintf(process, sizeof process, "%d", (int)pid);
    print_cell(process, 8);
    print_cell(connection_text(about, "name", room), 12);
    print_cell(connection_text(about, "iface", room), 15);
    print_cell(namespace, 10);
    print_cell(state, 12);
    print_text(stdout, connection_text(about, "devices", room));
    putchar('\n');
}

static bool print_one(void *ctx, connection_t *connection, const char *path)
{
    ps_args_t *args = ctx;
    char namespace[64];
    char state[32];
    pid_t pid = connection_process(connection);
    cJSON *about = connection_about(connection);
    connection_close(connection);
    about = about ? about : cJSON_CreateObject(); /* no reply, or an older version */
    name_namespace(pid, namespace);
    describe_state(about, state);
    if (!args->json && !args->header)
        puts("PID      NAME         INTERFACE       NAMESPACE  STATE        DEVICES");
    args->header = true;
    if (args->json)
        print_as_json(about, pid, namespace, state, path);
    else
        print_row(about, pid, namespace, state);
    cJSON_Delete(about);
    return true;
}

int command_ps(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"json", 'j', NULL, 0,
         "Print a line of JSON for each process: devices, iface, slaves, AL states, pid, namespace, socket, name", 0},
        {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc = "Lists your running twins: process id, name, interface of the master, network namespace (here: that "
               "of this command), AL state (of all slaves, or from the lowest to the highest; +ERROR: an AL status "
               "code is set), devices. Removes the sockets of ended twins. Twins of other users are not listed."};
    ps_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    return connection_each(argv[0], print_one, &args) ? EXIT_CLEAN : EXIT_OPEN;
}
