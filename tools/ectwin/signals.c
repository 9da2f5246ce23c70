/* SPDX-License-Identifier: MIT */
/* The commands that talk to a running twin over its control socket. */
#define _GNU_SOURCE
#include <cjson/cJSON.h>
#include <errno.h>
#include <glob.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "commands.h"

enum { MOST_ARGUMENTS = 64, LINE_ROOM = 1024 };

typedef struct client_args {
    const char *socket;
    double slave;
    const char *csv;
    bool every;
    const char *arguments[MOST_ARGUMENTS];
    size_t count;
} client_args_t;

#define COMMON_OPTIONS                                                                                                 \
    {"socket", 's', "PATH", 0, "Control socket (default: $ECTWIN_SOCKET, or the only one running)", 0},                \
    {                                                                                                                  \
        "slave", 'n', "N", 0, "Slave of the chain, from 1; 0: all (default 1)", 0                                      \
    }

static const struct argp_option options[] = {COMMON_OPTIONS, {0}};
static const struct argp_option set_options[] = {
    COMMON_OPTIONS,
    {"csv", 'c', "FILE", 0,
     "The first line names signals, each other one holds their values; an empty cell sets nothing", 0},
    {0}};
static const struct argp_option watch_options[] = {
    COMMON_OPTIONS,
    {"every", 'e', NULL, 0, "Every change at its time (default: what has changed, every 10 ms)", 0},
    {0}};

static error_t parse(int key, char *text, struct argp_state *state)
{
    client_args_t *args = state->input;
    char *end;
    switch (key) {
    case 's':
        args->socket = text;
        return 0;
    case 'n':
        args->slave = (double)strtoul(text, &end, 10);
        if (end == text || *end != 0)
            argp_error(state, "--slave takes a number, not '%s'", text);
        return 0;
    case 'c':
        args->csv = text;
        return 0;
    case 'e':
        args->every = true;
        return 0;
    case ARGP_KEY_ARG:
        if (args->count == MOST_ARGUMENTS)
            argp_error(state, "too many arguments: at most %d", MOST_ARGUMENTS);
        args->arguments[args->count++] = text;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* --- the connection ----------------------------------------------------------------------------------------------- */

static int connect_to(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (strlen(path) >= sizeof address.sun_path) {
        close(fd);
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(address.sun_path, path, strlen(path) + 1);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) == 0)
        return fd;
    close(fd);
    return -1;
}

/* The only one that answers; those whose process has died are cleared away. */
static int connect_to_only_one(const char *who)
{
    char pattern[ECT_CONTROL_PATH + 16];
    char directory[ECT_CONTROL_PATH];
    glob_t found = {0};
    int fd = -1;
    size_t alive = 0;
    if (ect_control_directory(directory) < 0)
        return -1;
    snprintf(pattern, sizeof pattern, "%s/*.sock", directory);
    (void)glob(pattern, 0, NULL, &found);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        int candidate = connect_to(found.gl_pathv[i]);
        if (candidate < 0) {
            if (errno == ECONNREFUSED)
                (void)unlink(found.gl_pathv[i]);
            continue;
        }
        if (alive++ > 0) {
            fprintf(stderr, "%s: several twins are running: choose one with -s, e.g. -s %s\n", who, found.gl_pathv[i]);
            close(candidate);
            close(fd);
            fd = -1;
            break;
        }
        fd = candidate;
    }
    if (alive == 0)
        fprintf(stderr, "%s: no twin is running: start one with 'ectwin run' or 'ectwin with'\n", who);
    globfree(&found);
    return fd;
}

static FILE *open_connection(const client_args_t *args, const char *who)
{
    const char *path = args->socket ? args->socket : getenv("ECTWIN_SOCKET");
    signal(SIGPIPE, SIG_IGN); /* a twin that closes the connection may have said why */
    int fd = path ? connect_to(path) : connect_to_only_one(who);
    if (fd < 0 && path)
        fprintf(stderr, "%s: no twin answers at '%s': %s\n", who, path, strerror(errno));
    return fd < 0 ? NULL : fdopen(fd, "r+");
}

static void send_request(FILE *connection, const client_args_t *args, const char *op, const char *key1,
                         const char *value1, const char *key2, const char *value2)
{
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", op);
    cJSON_AddNumberToObject(request, "slave", args->slave);
    cJSON_AddBoolToObject(request, "every", args->every);
    cJSON_AddStringToObject(request, key1, value1);
    if (key2)
        cJSON_AddStringToObject(request, key2, value2);
    char *text = cJSON_PrintUnformatted(request);
    fprintf(connection, "%s\n", text ? text : "");
    fflush(connection);
    cJSON_free(text);
    cJSON_Delete(request);
}

static const char *text_of(const cJSON *line, const char *member)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, member));
    return text ? text : "";
}

/* --- answers ------------------------------------------------------------------------------------------------------ */

static void print_value(const cJSON *line, const char *raw)
{
    (void)raw;
    printf("%s=%s\n", text_of(line, "name"), text_of(line, "value"));
}

/* Of several slaves: which one, as --set takes it. */
static void print_value_of_slave(const cJSON *line, const char *raw)
{
    (void)raw;
    printf("%.0f:%s=%s\n", cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(line, "slave")), text_of(line, "name"),
           text_of(line, "value"));
}

static void print_description(const cJSON *line, const char *raw)
{
    (void)raw;
    printf("%-22s %-2s %-34s %s\n", text_of(line, "name"), text_of(line, "access"), text_of(line, "range"),
           text_of(line, "meaning"));
}

static void print_raw(const cJSON *line, const char *raw)
{
    (void)line;
    fputs(raw, stdout);
    fflush(stdout);
}

/* Hands lines to `print` until the one that says how it went. */
static int read_answer(FILE *connection, const char *who, void (*print)(const cJSON *line, const char *raw))
{
    char raw[LINE_ROOM];
    while (fgets(raw, sizeof raw, connection)) {
        cJSON *line = cJSON_Parse(raw);
        const cJSON *ok = cJSON_GetObjectItemCaseSensitive(line, "ok");
        int status = -1;
        if (cJSON_IsBool(ok)) {
            status = cJSON_IsTrue(ok) ? EXIT_CLEAN : EXIT_USAGE;
            if (status != EXIT_CLEAN)
                fprintf(stderr, "%s: %s\n", who, text_of(line, "message"));
        } else if (print) {
            print(line, raw);
        }
        cJSON_Delete(line);
        if (status >= 0)
            return status;
        if (ferror(stdout))
            return EXIT_RUN; /* nobody reads it any more */
    }
    fprintf(stderr, "%s: the twin has ended, or has closed this connection\n", who);
    return EXIT_RUN;
}

static int ask(int argc, char **argv, const char *op, const struct argp_option *known, const char *doc,
               void (*print)(const cJSON *line, const char *raw))
{
    const struct argp argp = {.options = known, .parser = parse, .args_doc = "[PATTERN]", .doc = doc};
    client_args_t args = {.slave = 1};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    FILE *connection = open_connection(&args, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    if (args.count > 1) {
        fprintf(stderr, "%s: one pattern is enough; '*' stands for anything, '[ab]' for a or b\n", argv[0]);
        fclose(connection);
        return EXIT_USAGE;
    }
    send_request(connection, &args, op, "pattern", args.count > 0 ? args.arguments[0] : "*", NULL, NULL);
    int status =
        read_answer(connection, argv[0], print == print_value && args.slave == 0 ? print_value_of_slave : print);
    fclose(connection);
    return status;
}

int command_get(int argc, char **argv)
{
    return ask(argc, argv, "get", options, "Prints the signals of a running twin whose names match a shell pattern.",
               print_value);
}

int command_list_signals(int argc, char **argv)
{
    return ask(argc, argv, "list", options, "Lists the signals of a running twin: name, r or rw, range, meaning.",
               print_description);
}

int command_watch(int argc, char **argv)
{
    return ask(argc, argv, "watch", watch_options,
               "Prints one line of JSON for each value, then for each change, until Ctrl-C.", print_raw);
}

static int set_one(FILE *connection, const client_args_t *args, const char *who, const char *name, const char *value)
{
    send_request(connection, args, "set", "name", name, "value", value);
    return read_answer(connection, who, NULL);
}

static int set_argument(FILE *connection, const client_args_t *args, const char *who, const char *argument)
{
    char *name = strdup(argument);
    char *value = name ? strchr(name, '=') : NULL;
    int status = EXIT_USAGE;
    if (value) {
        *value = 0;
        status = set_one(connection, args, who, name, value + 1);
    } else {
        fprintf(stderr, "%s: '%s' is not NAME=VALUE\n", who, argument);
    }
    free(name);
    return status;
}

/* Splits a line at its commas, in place. @return how many cells there are */
static size_t split(char *line, char *cells[MOST_ARGUMENTS])
{
    size_t count = 0;
    for (char *cell = strsep(&line, ","); cell && count < MOST_ARGUMENTS; cell = strsep(&line, ",")) {
        cell += strspn(cell, " ");
        cell[strcspn(cell, " ")] = 0;
        cells[count++] = cell;
    }
    return count;
}

/* The next line without its end. @return false at the end of the file, or with `why` set */
static bool read_line(FILE *file, char line[LINE_ROOM], const char **why)
{
    if (!fgets(line, LINE_ROOM, file)) {
        *why = ferror(file) ? strerror(errno) : NULL;
        return false;
    }
    if (strlen(line) == LINE_ROOM - 1) {
        *why = "the line is too long";
        return false;
    }
    line[strcspn(line, "\r\n")] = 0;
    return true;
}

static int set_row(FILE *connection, const client_args_t *args, const char *who, char **names, size_t columns,
                   char *line, const char **why)
{
    char *values[MOST_ARGUMENTS];
    if (split(line, values) != columns) {
        *why = "it has not as many cells as the first line has names";
        return EXIT_USAGE;
    }
    int status = EXIT_CLEAN;
    for (size_t i = 0; i < columns && status == EXIT_CLEAN; i++)
        status = *values[i] ? set_one(connection, args, who, names[i], values[i]) : EXIT_CLEAN;
    if (status != EXIT_CLEAN)
        *why = "a value in it was refused";
    return status;
}

/* The first line names signals; each other one holds their values, set from left to right. An empty cell sets nothing.
 */
static int set_from_csv(FILE *connection, const client_args_t *args, const char *who)
{
    char header[LINE_ROOM], line[LINE_ROOM];
    char *names[MOST_ARGUMENTS];
    const char *why = NULL;
    FILE *file = fopen(args->csv, "r");
    if (!file || !read_line(file, header, &why)) {
        fprintf(stderr, "%s: cannot read '%s': %s\n", who, args->csv,
                !file ? strerror(errno)
                : why ? why
                      : "it is empty");
        if (file)
            fclose(file);
        return EXIT_OPEN;
    }
    size_t columns = split(header + (memcmp(header, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0), names);
    int status = EXIT_CLEAN;
    unsigned int number = 1;
    while (status == EXIT_CLEAN && read_line(file, line, &why)) {
        number++;
        if (*line)
            status = set_row(connection, args, who, names, columns, line, &why);
    }
    if (number == 1 && !why)
        why = "no line with values follows";
    if (why) {
        fprintf(stderr, "%s: line %u of '%s': %s\n", who, number, args->csv, why);
        status = EXIT_USAGE;
    }
    fclose(file);
    return status;
}

int command_set(int argc, char **argv)
{
    static const struct argp argp = {
        .options = set_options,
        .parser = parse,
        .args_doc = "NAME=VALUE...",
        .doc = "Sets signals of a running twin, in the order given; stops at the first refusal."};
    client_args_t args = {.slave = 1};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (args.slave == 0) {
        fprintf(stderr, "%s: one slave at a time: -n 1, -n 2, ...\n", argv[0]);
        return EXIT_USAGE;
    }
    if (args.count == 0 && !args.csv) {
        fprintf(stderr, "%s: name at least one signal: ectwin set NAME=VALUE; 'ectwin list-signals' lists them\n",
                argv[0]);
        return EXIT_USAGE;
    }
    FILE *connection = open_connection(&args, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    int status = EXIT_CLEAN;
    for (size_t i = 0; i < args.count && status == EXIT_CLEAN; i++)
        status = set_argument(connection, &args, argv[0], args.arguments[i]);
    if (args.csv && status == EXIT_CLEAN)
        status = set_from_csv(connection, &args, argv[0]);
    if (status == EXIT_USAGE && args.count > 1)
        fprintf(stderr, "%s: signals before this one were set\n", argv[0]);
    fclose(connection);
    return status;
}

int command_command(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "ruN HEX16",
        .doc = "Sends an operator's command of 16 bytes, 32 hexadecimal digits, from a remote unit."};
    client_args_t args = {.slave = 1};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (args.count != 2) {
        fprintf(stderr,
                "%s: name the remote unit and the command: ectwin command ru1 000102030405060708090a0b0c0d0e0f\n",
                argv[0]);
        return EXIT_USAGE;
    }
    char name[64];
    snprintf(name, sizeof name, "%.40s.command", args.arguments[0]);
    FILE *connection = open_connection(&args, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    send_request(connection, &args, "set", "name", name, "value", args.arguments[1]);
    int status = read_answer(connection, argv[0], NULL);
    fclose(connection);
    return status;
}
