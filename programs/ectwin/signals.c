/* SPDX-License-Identifier: MIT */
/* Commands that read and set signals over the control socket of a running twin. */
#define _GNU_SOURCE
#include <cjson/cJSON.h>
#include <errno.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bus/chain/catalogue.h"
#include "bus/chain/fields.h"
#include "bus/chain/lamps.h"
#include "bus/chain/wiring.h"
#include "bus/eoe/network.h"
#include "commands.h"
#include "connection.h"
#include "csv/csv.h"
#include "products.h"
#include "text/number.h"
#include "until.h"

typedef struct client_args {
    connection_choice_t twin;
    const char *slave; /* number or name */
    const char *csv;
    bool every;
    const char *until;  /* watch */
    int64_t timeout_ms; /* wait */
    double at_s;        /* set; negative: at once */
    const char *arguments[ECT_ENDPOINT_VALUES];
    size_t count;
} client_args_t;

#define SLAVE_OPTION                                                                                                   \
    {"slave",                                                                                                          \
     'n',                                                                                                              \
     "N",                                                                                                              \
     0,                                                                                                                \
     "Slave of the chain, by number from 1 or by name; 0: all slaves, except for set (default 1). A signal may also "  \
     "contain the name of its twin: gripper.data1",                                                                    \
     0}

static const struct argp_option options[] = {SLAVE_OPTION, {0}};
static const struct argp_option set_options[] = {
    SLAVE_OPTION,
    {"csv", 'c', "FILE", 0,
     "Set signals from a table: the first line contains names, each further line values; an empty cell sets nothing. "
     "With a column 'time', each line is set at its time, seconds from now. -: standard input",
     0},
    {"at", 'a', "TIME", 0,
     "Set the signals at a time of the bus, such as 2.5s since its start; on a virtual clock at exactly this time in "
     "each run (default: at once)",
     0},
    {0}};
static const struct argp_option watch_options[] = {
    SLAVE_OPTION,
    {"every", 'e', NULL, 0, "Report every change with its time (default: compare the values every 10 ms)", 0},
    {"csv", 'c', "FILE", 0,
     "Write a table for 'set --csv' and --play: a line with the present values, then a line for each change, with "
     "the seconds since the first line. -: standard output. The signal of --until must be one of those recorded",
     0},
    {"until", 'u', "CONDITION", 0,
     "End when a signal fulfils CONDITION: NAME=VALUE, NAME!=VALUE, NAME<VALUE, NAME>VALUE (default: at Ctrl-C)", 0},
    {0}};
static const struct argp_option wait_options[] = {
    {"slave", 'n', "N", 0, "Slave of the chain, by number from 1 or by name (default 1)", 0},
    {"timeout", 't', "SECONDS", 0, "Give up after this time, with status 3 (default 10; 0: never)", 0},
    {0}};

static int64_t take_seconds(const struct argp_state *state, const char *text)
{
    char *end;
    double seconds = strtod(text, &end);
    if (end == text || *end != 0 || !(seconds >= 0 && seconds <= 1e9))
        argp_error(state, "--timeout takes seconds, from 0, not '%s'", text);
    return seconds > 0 ? (int64_t)(seconds * 1000 + 0.5) : -1;
}

static double take_time(const struct argp_state *state, const char *text)
{
    char *end;
    double seconds = strtod(text, &end);
    if (end == text || strcmp(end, "s") != 0 || !(seconds >= 0 && seconds <= 1e9))
        argp_error(state, "--at takes a time in seconds, as in 2.5s, not '%s'", text);
    return seconds;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    client_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twin;
        return 0;
    case 'n':
        args->slave = connection_slave(state, text, 0);
        return 0;
    case 'c':
        args->csv = text;
        return 0;
    case 'a':
        args->at_s = take_time(state, text);
        return 0;
    case 'e':
        args->every = true;
        return 0;
    case 'u':
        args->until = text;
        return 0;
    case 't':
        args->timeout_ms = take_seconds(state, text);
        return 0;
    case ARGP_KEY_ARG:
        if (args->count == ECT_ENDPOINT_VALUES)
            argp_error(state, "too many arguments: at most %d", ECT_ENDPOINT_VALUES);
        args->arguments[args->count++] = text;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static bool is_all(const client_args_t *args)
{
    uint64_t number = 1;
    return ect_number(args->slave, 0, UINT16_MAX, &number) && number == 0;
}

/* --- get, list-signals, watch ------------------------------------------------------------------------------------- */

/* The pattern of the present request. */
static const char *requested = "";

/* @return whether the request names the twin of a line */
static bool is_named(const cJSON *line)
{
    char room[32];
    const char *twin = connection_text(line, "twin", room);
    size_t length = strlen(twin);
    return length > 0 && strncmp(requested, twin, length) == 0 && requested[length] == '.';
}

static void print_equation(const char *name, const cJSON *line)
{
    char room[32];
    print_text(stdout, name);
    putchar('=');
    print_text(stdout, connection_text(line, "value", room));
    putchar('\n');
}

static void print_value(const cJSON *line)
{
    char name[CONNECTION_NAME], room[32];
    connection_full_name(line, name);
    print_equation(is_named(line) ? name : connection_text(line, "name", room), line);
}

/* Prints name or number of the slave too, in the format of --set. */
static void print_value_of_slave(const cJSON *line)
{
    char name[CONNECTION_NAME], room[32];
    connection_full_name(line, name);
    if (*connection_text(line, "twin", room) == 0)
        printf("%s:", connection_text(line, "slave", room));
    print_equation(name, line);
}

static void print_column(const char *text, int width)
{
    print_text(stdout, text);
    printf("%*s ", width > (int)strlen(text) ? width - (int)strlen(text) : 0, "");
}

/* @param field  field of an entry that the signal shows; "": none */
static void print_signal(const char *name, const char *access, const char *range, const char *meaning,
                         const char *field)
{
    print_column(name, 22);
    print_column(access, 2);
    print_column(range, 34);
    print_text(stdout, meaning);
    if (*field) {
        fputs("  (", stdout);
        print_text(stdout, field);
        putchar(')');
    }
    putchar('\n');
}

static void print_description(const cJSON *line)
{
    char room[5][32];
    print_signal(connection_text(line, "name", room[0]), connection_text(line, "access", room[1]),
                 connection_text(line, "range", room[2]), connection_text(line, "meaning", room[3]),
                 connection_text(line, "field", room[4]));
}

static cJSON *make_request(const client_args_t *args, const char *op)
{
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", op);
    connection_add_slave(request, args->slave);
    return request;
}

static int request_one(connection_t *connection, const client_args_t *args, const char *who, const char *op,
                       const char *pattern, void (*print)(const cJSON *line))
{
    cJSON *request = make_request(args, op);
    requested = pattern;
    cJSON_AddStringToObject(request, "pattern", pattern);
    if (args->every)
        cJSON_AddTrueToObject(request, "every");
    return connection_request(connection, request, who, print);
}

/* Requests each pattern of the command line from `first` on; without patterns, all signals. @return the worst status */
static int request_each(connection_t *connection, const client_args_t *args, size_t first, const char *who,
                        const char *op, void (*print)(const cJSON *line))
{
    int status = args->count > first ? EXIT_CLEAN : request_one(connection, args, who, op, "*", print);
    for (size_t i = first; i < args->count && status <= EXIT_USAGE; i++) {
        int one = request_one(connection, args, who, op, args->arguments[i], print);
        status = one > status ? one : status;
    }
    return status;
}

static int request_all(const client_args_t *args, size_t first, const char *who, const char *op,
                       void (*print)(const cJSON *line))
{
    connection_t *connection = connection_open(&args->twin, who);
    if (!connection)
        return EXIT_OPEN;
    int status = request_each(connection, args, first, who, op, print);
    fflush(stdout);
    connection_close(connection);
    return status;
}

int command_get(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .children = connection_children,
        .args_doc = "[PATTERN...]",
        .doc = "Prints the signals of a running twin whose names match a shell pattern, by default all."};
    client_args_t args = {.slave = "1"};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    return request_all(&args, 0, argv[0], "get", is_all(&args) ? print_value_of_slave : print_value);
}

/* The condition of this process, and whether a first value has fulfilled it. */
static until_t condition;
static bool is_fulfilled;

static void check_line(const cJSON *line)
{
    is_fulfilled |= until_met(&condition, line);
}

static void print_and_check_line(const cJSON *line)
{
    print_line(line);
    check_line(line);
}

/* --- watch --csv -------------------------------------------------------------------------------------------------- */

static struct {
    FILE *file;
    size_t columns;
    char headings[ECT_CSV_CELLS][CONNECTION_NAME], names[ECT_CSV_CELLS][CONNECTION_NAME];
    char *values[ECT_CSV_CELLS]; /* initial values */
    double start;
    const follow_t *follow;
} record;

static double time_of(const cJSON *line)
{
    const cJSON *time = cJSON_GetObjectItemCaseSensitive(line, "time");
    return cJSON_IsNumber(time) ? time->valuedouble : 0;
}

static void add_column(const cJSON *line)
{
    char room[32], name[CONNECTION_NAME];
    connection_full_name(line, name);
    if (record.columns == 0)
        record.start = time_of(line);
    if (record.columns < ECT_CSV_CELLS - 1) {
        memcpy(record.names[record.columns], name, sizeof name);
        snprintf(record.headings[record.columns], CONNECTION_NAME, "%s",
                 is_named(line) ? name : connection_text(line, "name", room));
        record.values[record.columns] = strdup(connection_text(line, "value", room));
    }
    record.columns++;
    if (record.follow->met)
        check_line(line);
}

static void write_header(void)
{
    fputs("time", record.file);
    for (size_t i = 0; i < record.columns; i++)
        fprintf(record.file, ",%s", record.headings[i]);
    fputs("\n0.000000", record.file);
    for (size_t i = 0; i < record.columns; i++) {
        putc(',', record.file);
        ect_csv_write(record.file, record.values[i] ? record.values[i] : "");
        free(record.values[i]);
    }
    putc('\n', record.file);
    fflush(record.file);
}

/* Writes and flushes a line for each change: the command may end at any time. */
static bool write_change(void *ctx, const cJSON *line)
{
    char room[32], name[CONNECTION_NAME];
    connection_full_name(line, name);
    (void)ctx;
    for (size_t column = 0; column < record.columns; column++) {
        if (strcmp(record.names[column], name) != 0)
            continue;
        fprintf(record.file, "%.6f", time_of(line) - record.start);
        for (size_t i = 0; i < record.columns; i++) {
            putc(',', record.file);
            if (i == column)
                ect_csv_write(record.file, connection_text(line, "value", room));
        }
        putc('\n', record.file);
        fflush(record.file);
        break;
    }
    return record.follow->met && record.follow->met(record.follow->ctx, line);
}

static int record_changes(connection_t *connection, const client_args_t *args, const char *who, const follow_t *follow)
{
    const follow_t quiet = {.quiet = true, .met = write_change, .timeout_ms = -1};
    record.follow = follow;
    record.file = strcmp(args->csv, "-") == 0 ? stdout : fopen(args->csv, "we");
    if (!record.file) {
        fprintf(stderr, "%s: cannot write '%s': %s\n", who, args->csv, strerror(errno));
        return EXIT_OPEN;
    }
    int status = request_each(connection, args, 0, who, "watch", add_column);
    if (status == EXIT_CLEAN && record.columns >= ECT_CSV_CELLS) {
        fprintf(stderr, "%s: --csv takes at most %d signals, and %zu match: name fewer\n", who, ECT_CSV_CELLS - 1,
                record.columns);
        status = EXIT_USAGE;
    }
    if (status == EXIT_CLEAN) {
        write_header();
        status = is_fulfilled ? FOLLOW_MET : connection_follow(connection, who, &quiet);
    }
    if (record.file != stdout)
        fclose(record.file);
    return status;
}

static int watch(const client_args_t *args, const char *who)
{
    const follow_t follow = {.met = args->until ? until_met : NULL, .ctx = &condition, .timeout_ms = -1};
    connection_t *connection = connection_open(&args->twin, who);
    if (!connection)
        return EXIT_OPEN;
    if (args->csv) {
        int recorded = record_changes(connection, args, who, &follow);
        connection_close(connection);
        return recorded < EXIT_CLEAN ? EXIT_CLEAN : recorded;
    }
    int status =
        args->until ? request_one(connection, args, who, "watch", condition.name, print_and_check_line) : EXIT_CLEAN;
    if (status == EXIT_CLEAN && !is_fulfilled && (args->count > 0 || !args->until))
        status = request_each(connection, args, 0, who, "watch", print_line);
    fflush(stdout);
    if (status == EXIT_CLEAN && !is_fulfilled)
        status = connection_follow(connection, who, &follow);
    connection_close(connection);
    return status < EXIT_CLEAN ? EXIT_CLEAN : status;
}

/* @return EXIT_CLEAN, or EXIT_USAGE with the reason printed */
static int read_condition(const char *text, const char *slave, const char *who)
{
    const char *why = until_read(&condition, text);
    condition.slave = slave;
    if (why)
        fprintf(stderr, "%s: '%s': %s\n", who, text, why);
    return why ? EXIT_USAGE : EXIT_CLEAN;
}

static int wait_for_condition(const client_args_t *args, const char *who)
{
    const follow_t follow = {.quiet = true, .met = until_met, .ctx = &condition, .timeout_ms = args->timeout_ms};
    connection_t *connection = connection_open(&args->twin, who);
    if (!connection)
        return EXIT_OPEN;
    int status = request_one(connection, args, who, "watch", condition.name, check_line);
    if (status == EXIT_CLEAN && !is_fulfilled)
        status = connection_follow(connection, who, &follow);
    connection_close(connection);
    if (status != FOLLOW_TIMEOUT)
        return status;
    fprintf(stderr, "%s: %s is still ", who, condition.name);
    print_text(stderr, condition.current);
    fprintf(stderr, " after %g s, not %s\n", (double)args->timeout_ms / 1000, args->arguments[0]);
    return EXIT_RUN;
}

int command_wait(int argc, char **argv)
{
    static const struct argp argp = {
        .options = wait_options,
        .parser = parse,
        .children = connection_children,
        .args_doc = "CONDITION",
        .doc = "Waits until a signal of a running twin fulfils CONDITION: NAME=VALUE, NAME!=VALUE, NAME<VALUE or "
               "NAME>VALUE, in a shell in quotes. It is enough that the signal fulfils CONDITION for a moment."};
    client_args_t args = {.slave = "1", .every = true, .timeout_ms = 10000};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (args.count != 1 || is_all(&args)) {
        fprintf(stderr, "%s: name one condition, of one slave: ectwin wait ecat.state=8\n", argv[0]);
        return EXIT_USAGE;
    }
    int status = read_condition(args.arguments[0], args.slave, argv[0]);
    return status == EXIT_CLEAN ? wait_for_condition(&args, argv[0]) : status;
}

int command_watch(int argc, char **argv)
{
    static const struct argp argp = {
        .options = watch_options,
        .parser = parse,
        .children = connection_children,
        .args_doc = "[PATTERN...]",
        .doc = "Prints a line of JSON for each value, then a line for each change, until Ctrl-C or until the reader "
               "of the output ends."};
    client_args_t args = {.slave = "1"};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (args.csv && is_all(&args)) {
        fprintf(stderr, "%s: --csv records one slave, or signals with the names of their twins: -n 1, -n 2, ...\n",
                argv[0]);
        return EXIT_USAGE;
    }
    int status = args.until ? read_condition(args.until, args.slave, argv[0]) : EXIT_CLEAN;
    return status == EXIT_CLEAN ? watch(&args, argv[0]) : status;
}

/* Prints the matching signals of a plant. @return their number */
static size_t print_signals(const ect_plant_t *plant, void *instance, const char *pattern)
{
    ect_signal_cursor_t cursor = {0};
    ect_signal_ref_t ref;
    size_t count = 0;
    while (ect_signals_next(plant, instance, &cursor, &ref)) {
        char range[ECT_SIGNAL_TEXT_ROOM];
        if (fnmatch(pattern, ref.name, 0) != 0)
            continue;
        ect_signal_range(ref.signal, range);
        const ect_field_t *field = ect_signal_field(&ref);
        char text[ECT_FIELD_TEXT] = "";
        if (field)
            ect_field_text(field, text);
        print_signal(ref.name, ref.signal->access == ECT_SIGNAL_WRITE ? "rw" : "r", range, ref.signal->meaning, text);
        count++;
    }
    return count;
}

/* @return EXIT_CLEAN; EXIT_USAGE with a line: no signal of a device matches a pattern */
static int list_pattern(const ect_product_t *product, void *instance, const char *who, const char *pattern)
{
    ect_lamps_t lamps;
    ect_wiring_t wiring;
    uint32_t network[ECT_NETWORK_SIGNALS / sizeof(uint32_t)];
    size_t count = print_signals(product->plant, instance, pattern);
    if (ect_network_entry(product->device))
        count += print_signals(&ect_network_plant, network, pattern);
    count += print_signals(&ect_lamps_plant, &lamps, pattern);
    count += print_signals(&ect_wiring_plant, &wiring, pattern);
    if (count > 0)
        return EXIT_CLEAN;
    fprintf(stderr, "%s: no signal of %s matches '%s'\n", who, product->device->name, pattern);
    return EXIT_USAGE;
}

/* Lists the signals of a device by its description, without a running twin. */
static int list_device(const ect_product_t *product, const client_args_t *args, const char *who)
{
    void *instance = calloc(1, product->device->instance_size);
    int status = instance ? EXIT_CLEAN : EXIT_RUN;
    if (!instance)
        fprintf(stderr, "%s: not enough memory\n", who);
    else if (args->count < 2)
        status = list_pattern(product, instance, who, "*");
    for (size_t i = 1; instance && i < args->count; i++) {
        int one = list_pattern(product, instance, who, args->arguments[i]);
        status = one > status ? one : status;
    }
    free(instance);
    return status;
}

int command_list_signals(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .children = connection_children,
        .args_doc = "[DEVICE] [PATTERN...]",
        .doc = "Lists the signals of a running twin, or of a device that need not run: name, r or rw, range, meaning."};
    client_args_t args = {.slave = "1"};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    char message[PRODUCT_MESSAGE];
    bool from_file = args.count > 0 && product_file(args.arguments[0]);
    const ect_product_t *product =
        args.count > 0 ? product_find(args.arguments[0], NULL, 0, ECT_BEHAVIOUR_BY_FILE, message) : NULL;
    if (from_file && !product) {
        fprintf(stderr, "%s: %s\n", argv[0], message);
        return EXIT_OPEN;
    }
    return product ? list_device(product, &args, argv[0]) : request_all(&args, 0, argv[0], "list", print_description);
}

/* --- set, command ------------------------------------------------------------------------------------------------- */

static int set_values(connection_t *connection, const client_args_t *args, const char *who, cJSON *values)
{
    cJSON *request = make_request(args, "set");
    cJSON_AddItemToObject(request, "values", values);
    if (args->at_s >= 0)
        cJSON_AddNumberToObject(request, "at", args->at_s);
    return connection_request(connection, request, who, NULL);
}

static int set_arguments(connection_t *connection, const client_args_t *args, const char *who)
{
    cJSON *values = cJSON_CreateObject();
    for (size_t i = 0; i < args->count; i++) {
        char name[256];
        const char *value = strchr(args->arguments[i], '=');
        if (!value || (size_t)(value - args->arguments[i]) >= sizeof name) {
            fprintf(stderr, "%s: '%s' is not NAME=VALUE\n", who, args->arguments[i]);
            cJSON_Delete(values);
            return EXIT_USAGE;
        }
        snprintf(name, sizeof name, "%.*s", (int)(value - args->arguments[i]), args->arguments[i]);
        cJSON_AddStringToObject(values, name, value + 1);
    }
    return set_values(connection, args, who, values);
}

/* Waits for the time of a row, relative to the first row. */
static bool wait_for_row(ect_csv_t *csv, size_t time, uint64_t *before_ns)
{
    static struct timespec start;
    uint64_t due_ns;
    if (time == csv->columns)
        return true;
    if (start.tv_sec == 0)
        (void)clock_gettime(CLOCK_MONOTONIC, &start);
    if (!ect_csv_time(csv, time, *before_ns, &due_ns))
        return false;
    *before_ns = due_ns;
    uint64_t at_ns = due_ns + (uint64_t)start.tv_nsec;
    const struct timespec at = {.tv_sec = start.tv_sec + (time_t)(at_ns / 1000000000),
                                .tv_nsec = (long)(at_ns % 1000000000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
    return true;
}

static int set_row(connection_t *connection, const client_args_t *args, const char *who, ect_csv_t *csv, size_t time)
{
    cJSON *values = cJSON_CreateObject();
    for (size_t i = 0; i < csv->columns; i++) {
        if (i != time && *csv->cells[i] != 0)
            cJSON_AddStringToObject(values, csv->names[i], csv->cells[i]);
    }
    if (!values->child) {
        cJSON_Delete(values);
        return EXIT_CLEAN;
    }
    int status = set_values(connection, args, who, values);
    if (status != EXIT_CLEAN)
        csv->why = "refused; the lines before it are set";
    return status;
}

static int set_rows(connection_t *connection, const client_args_t *args, const char *who, ect_csv_t *csv)
{
    int status = EXIT_CLEAN;
    size_t rows = 0, time = ect_csv_column(csv, "time");
    uint64_t before_ns = 0;
    for (; status == EXIT_CLEAN && ect_csv_next(csv) && wait_for_row(csv, time, &before_ns); rows++)
        status = set_row(connection, args, who, csv, time);
    if (rows == 0 && !csv->why)
        csv->why = "no line with values follows";
    if (!csv->why)
        return status;
    fprintf(stderr, "%s: line %u of '%s': %s\n", who, csv->line, args->csv, csv->why);
    return status != EXIT_CLEAN ? status : EXIT_USAGE;
}

static int set_from_csv(connection_t *connection, const client_args_t *args, const char *who)
{
    ect_csv_t *csv = calloc(1, sizeof *csv);
    int status = EXIT_OPEN;
    if (csv && ect_csv_open(csv, args->csv)) {
        status = set_rows(connection, args, who, csv);
    } else {
        fprintf(stderr, "%s: cannot read '%s': %s\n", who, args->csv, csv ? csv->why : strerror(errno));
        status = csv && csv->file ? EXIT_USAGE : EXIT_OPEN;
    }
    if (csv)
        ect_csv_close(csv);
    free(csv);
    return status;
}

int command_set(int argc, char **argv)
{
    static const struct argp argp = {
        .options = set_options,
        .parser = parse,
        .children = connection_children,
        .args_doc = "NAME=VALUE...",
        .doc = "Sets signals of a running twin: all of them or none, in any order. With --csv each line is set "
               "separately."};
    client_args_t args = {.slave = "1", .at_s = -1};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (is_all(&args)) {
        fprintf(stderr, "%s: set works on one slave: -n 1, -n 2, ...\n", argv[0]);
        return EXIT_USAGE;
    }
    if (args.at_s >= 0 && args.csv) {
        fprintf(stderr, "%s: --csv sets each line at a time of its own: leave out --at\n", argv[0]);
        return EXIT_USAGE;
    }
    if (args.count == 0 && !args.csv) {
        fprintf(stderr, "%s: no signal: ectwin set NAME=VALUE; 'ectwin list-signals' lists the names\n", argv[0]);
        return EXIT_USAGE;
    }
    connection_t *connection = connection_open(&args.twin, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    int status = args.count > 0 ? set_arguments(connection, &args, argv[0]) : EXIT_CLEAN;
    if (args.csv && status == EXIT_CLEAN)
        status = set_from_csv(connection, &args, argv[0]);
    connection_close(connection);
    return status;
}

int command_command(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .children = connection_children,
        .args_doc = "ruN HEX16",
        .doc = "Sends an operator's command of 16 bytes, 32 hexadecimal digits, from a remote unit."};
    client_args_t args = {.slave = "1", .at_s = -1};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (args.count != 2) {
        fprintf(stderr,
                "%s: name the remote unit and the command: ectwin command ru1 000102030405060708090a0b0c0d0e0f\n",
                argv[0]);
        return EXIT_USAGE;
    }
    char name[64];
    snprintf(name, sizeof name, "%.40s.command", args.arguments[0]);
    connection_t *connection = connection_open(&args.twin, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    cJSON *values = cJSON_CreateObject();
    cJSON_AddStringToObject(values, name, args.arguments[1]);
    int status = set_values(connection, &args, argv[0], values);
    connection_close(connection);
    return status;
}
