/* SPDX-License-Identifier: MIT */
/* `ectwin save-bus`: command line, present signals and faults of a running bus as a bus file. */
#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus/chain/settings.h"
#include "bus_args.h"
#include "buses/bus_file.h"
#include "commands.h"
#include "connection.h"
#include "grow.h"
#include "network.h"
#include "output.h"
#include "products.h"
#include "run_options.h"
#include "twin_names.h"

/* An option of the running bus. */
typedef struct saved_option {
    const struct argp_option *option;
    char *text; /* NULL: it has no argument */
    bool has_path;
    size_t path; /* offset of the path, after N: or NAME: */
} saved_option_t;

/* A signal with another value than in the same bus without settings. */
typedef struct saved_signal {
    size_t slave; /* from 1 */
    char name[ECT_SIGNAL_NAME];
    char value[ECT_SIGNAL_TEXT_ROOM];
    char why[ECT_SIGNAL_MESSAGE]; /* reason why the value cannot be set at the start; "": it can */
} saved_signal_t;

typedef struct save {
    connection_choice_t twin;
    const char *output;
    const char *who;
    const struct argp_state *state; /* of the present parser */
    connection_t *connection;
    char *words; /* working directory and command line of the bus */
    size_t length;
    saved_option_t *options;
    size_t option_count;
    char *devices;
    char **script; /* lines of --fault */
    size_t script_count;
    saved_signal_t *signals;
    size_t signal_count;
    ect_chain_t *chain; /* the same bus without settings; its options point into `fresh` */
    char **fresh;
    int fresh_count;
} save_t;

/* For take_signal and its like, which get no context. */
static save_t *current;

/* --- words of the running bus --------------------------------------------------------------------------------------
 */

static unsigned int digit_of(char c)
{
    return c <= '9' ? (unsigned int)(c - '0') : (unsigned int)(c - 'a') + 10;
}

static void take_piece(const cJSON *line)
{
    save_t *s = current;
    const char *hex = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "data"));
    size_t count = hex ? strlen(hex) / 2 : 0;
    char *grown = realloc(s->words, s->length + count + 1);
    if (!grown)
        return;
    for (size_t i = 0; i < count; i++)
        grown[s->length + i] = (char)(digit_of(hex[2 * i]) << 4 | digit_of(hex[2 * i + 1]));
    s->words = grown;
    s->length += count;
    s->words[s->length] = 0;
}

static int read_words(save_t *s)
{
    int status = EXIT_CLEAN;
    for (size_t before = SIZE_MAX; status == EXIT_CLEAN && s->length != before;) {
        cJSON *request = cJSON_CreateObject();
        cJSON_AddStringToObject(request, "op", "words");
        cJSON_AddNumberToObject(request, "offset", (double)s->length);
        before = s->length;
        status = connection_request(s->connection, request, s->who, take_piece);
    }
    return status;
}

/* --- options -------------------------------------------------------------------------------------------------------
 */

static char *copy_text(const save_t *s, const char *text)
{
    char *copy = strdup(text);
    if (!copy)
        argp_failure(s->state, EXIT_RUN, ENOMEM, "the bus");
    return copy;
}

/* A path of the bus is relative to its working directory, the first of `words`. */
static char *absolute(const save_t *s, const char *prefix, const char *path)
{
    char *text = NULL;
    if (asprintf(&text, "%s%s%s%s", prefix, *path == '/' ? "" : s->words, *path == '/' ? "" : "/", path) < 0)
        argp_failure(s->state, EXIT_RUN, ENOMEM, "the bus");
    return text;
}

static void add_option(save_t *s, const struct argp_option *option, const char *text)
{
    s->options = grow(s->state, s->options, s->option_count, sizeof *s->options);
    saved_option_t *one = &s->options[s->option_count++];
    *one = (saved_option_t){.option = option};
    if (text)
        one->text = copy_text(s, text);
}

static void take_operand(save_t *s, const char *text)
{
    free(s->devices);
    s->devices = copy_text(s, text);
}

/* The input of the parser of a table of options. */
typedef struct table {
    save_t *save;
    const struct argp_option *options;
} table_t;

static error_t take_option(int key, char *text, struct argp_state *state)
{
    const table_t *table = state->input;
    for (const struct argp_option *o = table ? table->options : NULL; o && (o->name || o->key); o++) {
        if (o->key != key)
            continue;
        const char *next = state->next < state->argc ? state->argv[state->next] : "";
        if (!text && (o->flags & OPTION_ARG_OPTIONAL) != 0 && *next >= '0' && *next <= '9') /* "--realtime 70" */
            text = state->argv[state->next++];
        table->save->state = state;
        add_option(table->save, o, text);
        return 0;
    }
    return ARGP_ERR_UNKNOWN;
}

enum { TABLES = 5 };

typedef struct tables {
    save_t *save;
    table_t table[TABLES];
} tables_t;

static error_t take_words(int key, char *text, struct argp_state *state)
{
    tables_t *tables = state->input;
    tables->save->state = state;
    if (key == ARGP_KEY_INIT) {
        for (size_t i = 0; i < TABLES; i++)
            state->child_inputs[i] = &tables->table[i];
        return 0;
    }
    if (key != ARGP_KEY_ARG)
        return ARGP_ERR_UNKNOWN;
    take_operand(tables->save, text);
    return 0;
}

/* Splits the words into options of `run` and `with`. */
static void cut_words(save_t *s, int count, char **words)
{
    const struct argp parsers[TABLES] = {{.options = twin_argp.options, .parser = take_option},
                                         {.options = wiring_argp.options, .parser = take_option},
                                         {.options = eoe_argp.options, .parser = take_option},
                                         {.options = with_options, .parser = take_option},
                                         {.options = run_options, .parser = take_option}};
    const struct argp_child children[TABLES + 1] = {{&parsers[0], 0, NULL, 0}, {&parsers[1], 0, NULL, 0},
                                                    {&parsers[2], 0, NULL, 0}, {&parsers[3], 0, NULL, 0},
                                                    {&parsers[4], 0, NULL, 0}, {0}};
    const struct argp argp = {.parser = take_words, .children = children};
    tables_t tables = {.save = s};
    for (size_t i = 0; i < TABLES; i++)
        tables.table[i] = (table_t){s, parsers[i].options};
    (void)argp_parse(&argp, count, words, ARGP_NO_HELP, NULL, &tables);
    s->state = NULL; /* the parser has ended */
}

/* --- the same bus without settings ---------------------------------------------------------------------------------
 */

/* Options without effect on the initial signals of a bus, and options replaced by the present state. */
static bool is_of_run(const char *name)
{
    static const char *const names[] = {"set",      "fault",          "faults",    "scenario", "drop",     "delay",
                                        "delay-us", "play",           "store",     "files",    "pcap",     "pcap-size",
                                        "record",   "modbus",         "udp",       "break",    "quiet",    "name",
                                        "realtime", "files-password", "busy-poll", "panel",    "in-kernel"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(names[i], name) == 0)
            return true;
    }
    return false;
}

static bool is_in(const struct argp_option *table, const struct argp_option *option)
{
    while ((table->name || table->key) && table != option)
        table++;
    return table == option;
}

static bool shapes_twins(const struct argp_option *option)
{
    return is_in(wiring_argp.options, option) || (is_in(twin_argp.options, option) && !is_of_run(option->name));
}

static error_t parse_twins(int key, char *text, struct argp_state *state)
{
    twin_args_t *twins = state->input;
    if (key == ARGP_KEY_INIT)
        state->child_inputs[0] = twins;
    else if (key == ARGP_KEY_ARG)
        twin_args_devices(twins, state, text);
    else
        return ARGP_ERR_UNKNOWN;
    return 0;
}

static int power_on(save_t *s, twin_args_t *twins)
{
    static const struct argp_child children[] = {{&twin_argp, 0, NULL, 0}, {0}};
    static const struct argp argp = {.parser = parse_twins, .children = children};
    char **words = calloc(s->option_count + 4, sizeof *words);
    int count = 0, status = EXIT_RUN;
    if (words)
        words[count++] = copy_text(s, s->who);
    for (size_t i = 0; words && i < s->option_count; i++) {
        const saved_option_t *o = &s->options[i];
        if (shapes_twins(o->option) &&
            asprintf(&words[count], "--%s%s%s", o->option->name, o->text ? "=" : "", o->text ? o->text : "") > 0)
            count++;
    }
    if (words) {
        words[count++] = copy_text(s, s->devices);
        (void)argp_parse(&argp, count, words, ARGP_IN_ORDER | ARGP_NO_HELP, NULL, twins);
        status = twin_args_power_on(twins, s->who, 0, &s->chain);
    }
    s->fresh = words;
    s->fresh_count = count;
    return status;
}

/* --- signals and faults --------------------------------------------------------------------------------------------
 */

/* Keeps a writable signal if its value differs from that of the fresh bus. */
static void take_signal(const cJSON *line)
{
    save_t *s = current;
    char room[32], fresh[ECT_SIGNAL_TEXT_ROOM];
    const cJSON *slave = cJSON_GetObjectItemCaseSensitive(line, "slave");
    const char *value = connection_text(line, "value", room);
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "name"));
    const char *access = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "access"));
    ect_signal_ref_t ref;
    if (!cJSON_IsNumber(slave) || !name || !access || strcmp(access, "rw") != 0 ||
        cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(line, "value")))
        return;
    size_t number = slave->valueint > 0 ? (size_t)slave->valueint : 0;
    if (number < 1 || number > ect_chain_count(s->chain) || !ect_chain_signal(s->chain, number - 1, name, &ref))
        return;
    ect_signal_read(&ref, fresh);
    if (strcmp(fresh, value) == 0)
        return;
    s->signals = grow(s->state, s->signals, s->signal_count, sizeof *s->signals);
    saved_signal_t *one = &s->signals[s->signal_count++];
    *one = (saved_signal_t){.slave = number};
    snprintf(one->name, sizeof one->name, "%s", name);
    snprintf(one->value, sizeof one->value, "%s", value);
}

static int list_signals(save_t *s)
{
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", "list");
    cJSON_AddNumberToObject(request, "slave", 0);
    return connection_request(s->connection, request, s->who, take_signal);
}

static bool is_module(const char *name)
{
    unsigned int slot;
    int end = 0;
    return sscanf(name, "slot%u.module%n", &slot, &end) == 1 && end > 0 && name[end] == 0;
}

/* Inserts the modules of the running bus into the fresh one. @return their number; if not 0, others are removed */
static size_t insert_modules(save_t *s)
{
    char why[ECT_SIGNAL_MESSAGE];
    size_t count = 0;
    for (size_t i = 0; i < s->signal_count; i++) {
        const ect_setting_t setting = {.name = s->signals[i].name, .value = s->signals[i].value};
        if (is_module(setting.name) && ect_settings_apply(s->chain, s->signals[i].slave - 1, &setting, 1, 0, why))
            s->signals[count++] = s->signals[i];
    }
    return count;
}

/* A module that was inserted since the start has signals which the fresh bus has with the module only. */
static int read_signals(save_t *s)
{
    const int status = list_signals(s);
    const size_t modules = status == EXIT_CLEAN ? insert_modules(s) : 0;
    if (modules == 0)
        return status;
    s->signal_count = modules;
    return list_signals(s);
}

/* Signals may depend on others, in any order; so refused values are tried again. */
static void try_signals(save_t *s)
{
    enum { ROUNDS = 3 };
    for (unsigned int round = 0; round < ROUNDS; round++) {
        for (size_t i = 0; i < s->signal_count; i++) {
            saved_signal_t *one = &s->signals[i];
            const ect_setting_t setting = {.name = one->name, .value = one->value};
            if (round > 0 && one->why[0] == 0)
                continue;
            if (ect_settings_apply(s->chain, one->slave - 1, &setting, 1, 0, one->why))
                one->why[0] = 0;
        }
    }
}

static void take_line(const cJSON *line)
{
    save_t *s = current;
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "line"));
    if (!text)
        return;
    s->script = grow(s->state, s->script, s->script_count, sizeof *s->script);
    s->script[s->script_count++] = copy_text(s, text);
}

static int read_script(save_t *s)
{
    int status = EXIT_CLEAN;
    for (size_t before = SIZE_MAX; status == EXIT_CLEAN && s->script_count != before;) {
        cJSON *request = cJSON_CreateObject();
        cJSON_AddStringToObject(request, "op", "script");
        cJSON_AddNumberToObject(request, "offset", (double)s->script_count);
        before = s->script_count;
        status = connection_request(s->connection, request, s->who, take_line);
    }
    return status;
}

/* --- the file ------------------------------------------------------------------------------------------------------
 */

/* Writes a scalar, in single quotes if necessary. */
static void put_scalar(FILE *file, const char *text)
{
    size_t length = strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./+:#=-");
    bool begins = (*text >= '0' && *text <= '9') || (*text >= 'a' && *text <= 'z') || (*text >= 'A' && *text <= 'Z') ||
                  *text == '/';
    if (begins && text[length] == 0 && text[length - 1] != ':') {
        fputs(text, file);
        return;
    }
    fputc('\'', file);
    for (; *text; text++) {
        if (*text == '\'')
            fputc('\'', file);
        fputc(*text, file);
    }
    fputc('\'', file);
}

/* @return the path relative to the folder of the file; the whole path if outside of the folder or without a file */
static const char *relative(const save_t *s, const char *path)
{
    char folder[PATH_MAX], copy[PATH_MAX];
    if (!s->output || snprintf(copy, sizeof copy, "%s", s->output) >= (int)sizeof copy)
        return path;
    char *slash = strrchr(copy, '/');
    if (slash)
        slash[slash == copy ? 1 : 0] = 0;
    if (!realpath(slash ? copy : ".", folder))
        return path;
    size_t length = strlen(folder);
    return strncmp(path, folder, length) == 0 && path[length] == '/' ? path + length + 1 : path;
}

static void put_path(const save_t *s, FILE *file, const saved_option_t *o)
{
    char *text = NULL;
    const char *path = o->has_path ? relative(s, o->text + o->path) : o->text + o->path;
    if (asprintf(&text, "%.*s%s", (int)o->path, o->text, path) < 0)
        argp_failure(NULL, EXIT_RUN, ENOMEM, "the bus");
    put_scalar(file, text);
    free(text);
}

static void put_value(const save_t *s, FILE *file, const saved_option_t *o)
{
    if (!o->text)
        fputs((o->option->flags & OPTION_ARG_OPTIONAL) != 0 ? "50" : "true", file);
    else
        put_path(s, file, o);
}

/* @return whether an option is written to the file: neither an option of the command, nor replaced by present state */
static bool is_kept(const struct argp_option *option)
{
    static const char *const replaced[] = {"set", "fault", "faults", "scenario", "drop", "delay", "delay-us"};
    for (size_t i = 0; i < sizeof replaced / sizeof replaced[0]; i++) {
        if (strcmp(replaced[i], option->name) == 0)
            return false;
    }
    return !is_in(with_options, option) && !is_in(run_options, option);
}

/* @return whether a bus file may have the option: what a run writes lies below the folder of the file */
static bool is_below(const save_t *s, const saved_option_t *o)
{
    return !o->has_path || !bus_option_writes(o->option) || ect_bus_file_below(relative(s, o->text + o->path));
}

/* The next value of an option that the file has, from n on. @return the number of options: none */
static size_t next_value(const save_t *s, size_t n, const struct argp_option *option)
{
    while (n < s->option_count && (s->options[n].option != option || !is_below(s, &s->options[n])))
        n++;
    return n;
}

/* Writes a key with all values; a flag that is given again is one. */
static void put_option(const save_t *s, FILE *file, size_t first)
{
    const struct argp_option *option = s->options[first].option;
    const bool list = s->options[first].text && next_value(s, first + 1, option) < s->option_count;
    fprintf(file, "%s:%s", option->name, list ? "\n" : " ");
    for (size_t n = first; n < s->option_count; n = next_value(s, n + 1, option)) {
        if (!list && n > first)
            return;
        fputs(list ? "  - " : "", file);
        put_value(s, file, &s->options[n]);
        fputc('\n', file);
    }
}

/* Writes each key once. */
static void put_options(const save_t *s, FILE *file)
{
    for (size_t i = 0; i < s->option_count; i++) {
        const struct argp_option *option = s->options[i].option;
        if (is_kept(option) && next_value(s, 0, option) == i)
            put_option(s, file, i);
    }
}

static void put_list(FILE *file, const char *key, char *const *texts, size_t count)
{
    if (count > 0)
        fprintf(file, "%s:\n", key);
    for (size_t i = 0; i < count; i++) {
        fputs("  - ", file);
        put_scalar(file, texts[i]);
        fputc('\n', file);
    }
}

static void put_device(const save_t *s, FILE *file, const char *device)
{
    const char *name = product_file(device);
    char *path = name ? absolute(s, "", name) : NULL;
    fputs("  - device: ", file);
    if (path) {
        char *text = NULL;
        if (asprintf(&text, "%.*s%s", (int)(name - device), device, relative(s, path)) > 0)
            put_scalar(file, text);
        free(text);
    } else {
        put_scalar(file, device);
    }
    fputc('\n', file);
    free(path);
}

/* Writes the signals of one twin below the twin. */
static void put_signals(const save_t *s, FILE *file, size_t slave)
{
    bool any = false;
    for (size_t i = 0; i < s->signal_count; i++) {
        const saved_signal_t *one = &s->signals[i];
        if (one->slave != slave || one->why[0])
            continue;
        fputs(any ? "" : "    set:\n", file);
        any = true;
        fprintf(file, "      %s: ", one->name);
        put_scalar(file, one->value);
        fputc('\n', file);
    }
}

/* Twins with a count share one element of the file: their signals become options of the bus. */
static void put_signals_of_counts(const save_t *s, FILE *file, const size_t *counts)
{
    bool any = false;
    for (size_t i = 0; i < s->signal_count; i++) {
        const saved_signal_t *one = &s->signals[i];
        char text[ECT_SIGNAL_NAME + ECT_SIGNAL_TEXT_ROOM + 24];
        if (counts[one->slave - 1] == 1 || one->why[0])
            continue;
        fputs(any ? "" : "set:\n", file);
        any = true;
        (void)snprintf(text, sizeof text, "%zu:%s=%s", one->slave, one->name, one->value);
        fputs("  - ", file);
        put_scalar(file, text);
        fputc('\n', file);
    }
}

/* @return for each twin the count of its list element. The bus of a network file is the rest of the chain. */
static size_t *counts_of(const save_t *s)
{
    listed_device_t one;
    const size_t all = ect_chain_count(s->chain);
    size_t *counts = calloc(all, sizeof *counts), at = 0;
    char *copy = copy_text(s, s->devices), *rest = copy;
    while (counts && listed_device_next(s->state, &rest, &one)) {
        const size_t count = network_path(one.device) ? all - at : one.count;
        for (size_t i = 0; i < count; i++)
            counts[at++] = count;
    }
    free(copy);
    return counts;
}

static void put_twins(const save_t *s, FILE *file, const size_t *counts)
{
    listed_device_t one;
    size_t slave = 1;
    char *copy = copy_text(s, s->devices), *rest = copy;
    fputs("twins:\n", file);
    for (; listed_device_next(s->state, &rest, &one); slave += one.count) {
        put_device(s, file, one.device);
        if (one.name)
            fprintf(file, "    name: %s\n", one.name);
        if (one.count > 1)
            fprintf(file, "    count: %zu\n", one.count);
        if (counts[slave - 1] == 1)
            put_signals(s, file, slave);
    }
    free(copy);
}

static int write_file(const save_t *s)
{
    output_text_t out;
    FILE *file = output_open(s->who, &out);
    size_t *counts = counts_of(s);
    if (!file || !counts) {
        free(counts);
        return EXIT_RUN;
    }
    fputs("ectwin: 1\n", file);
    put_options(s, file);
    put_list(file, "fault", s->script, s->script_count);
    put_signals_of_counts(s, file, counts);
    put_twins(s, file, counts);
    free(counts);
    return output_close(s->who, &out, s->output);
}

/* --- the command ---------------------------------------------------------------------------------------------------
 */

static int split_words(save_t *s)
{
    size_t room = 2; /* the last word may lack its end, and NULL follows */
    for (size_t i = 0; i < s->length; i++)
        room += s->words[i] == 0;
    char **words = calloc(room, sizeof *words);
    char name[] = "ectwin save-bus";
    int count = 0;
    if (!words || s->length == 0) {
        fprintf(stderr, "%s: the bus has no command line, or there is not enough memory for it\n", s->who);
        free(words);
        return EXIT_RUN;
    }
    words[count++] = name;
    for (char *word = s->words + strlen(s->words) + 1; word < s->words + s->length; word += strlen(word) + 1)
        words[count++] = word;
    cut_words(s, count, words);
    free(words);
    return EXIT_CLEAN;
}

/* Makes the paths of devices absolute: the working directory of the bus is another one. */
static void find_devices(save_t *s)
{
    listed_device_t one;
    char *list = NULL, *copy = copy_text(s, s->devices), *rest = copy;
    while (listed_device_next(s->state, &rest, &one)) {
        const char *path = product_file(one.device);
        char prefix[8] = "", *device, *longer = NULL;
        (void)snprintf(prefix, sizeof prefix, "%.*s", path ? (int)(path - one.device) : 0, one.device);
        device = path ? absolute(s, prefix, path) : copy_text(s, one.device);
        if (asprintf(&longer, "%s%s%s%s%s*%zu", list ? list : "", list ? "," : "", one.name ? one.name : "",
                     one.name ? "=" : "", device, one.count) < 0)
            argp_failure(s->state, EXIT_RUN, ENOMEM, "the bus");
        free(device);
        free(list);
        list = longer;
    }
    free(copy);
    free(s->devices);
    s->devices = list;
}

/* Makes the paths of options absolute. */
static void find_paths(save_t *s)
{
    ect_names_t *names = names_of_devices(s->state, s->devices);
    for (size_t i = 0; i < s->option_count; i++) {
        saved_option_t *o = &s->options[i];
        const char *text = o->text;
        if (!text)
            continue;
        const char *path = bus_option_path(o->option, text);
        if (o->option->arg[0] == '[' && (!path || path == text)) { /* unix:PATH is without N: */
            (void)twin_of(names, &text, 0);
            path = bus_option_path(o->option, text);
        }
        if (!path)
            continue;
        o->has_path = true;
        o->path = (size_t)(path - o->text);
        char *prefix = copy_text(s, o->text);
        prefix[o->path] = 0;
        char *whole = absolute(s, prefix, path);
        free(prefix);
        free(o->text);
        o->text = whole;
    }
    ect_names_free(names);
}

static int report_refused(const save_t *s)
{
    int status = EXIT_CLEAN;
    for (size_t i = 0; i < s->option_count; i++) {
        const saved_option_t *o = &s->options[i];
        if (!is_kept(o->option) || is_below(s, o))
            continue;
        fprintf(stderr,
                "%s: '--%s=%s' is left out, a bus file writes only below its own folder: give it on the command line, "
                "or the file a place above it by -o FILE\n",
                s->who, o->option->name, o->text);
        status = EXIT_RUN;
    }
    for (size_t i = 0; i < s->signal_count; i++) {
        const saved_signal_t *one = &s->signals[i];
        if (one->why[0] == 0)
            continue;
        fprintf(stderr, "%s: slave %zu: '%s=%s' is left out, a bus refuses it at its start: %s\n", s->who, one->slave,
                one->name, one->value, one->why);
        status = EXIT_RUN;
    }
    return status;
}

static int save(save_t *s)
{
    twin_args_t twins = {0};
    product_quiet(); /* the running bus has printed the notes */
    int status = read_words(s);
    if (status == EXIT_CLEAN)
        status = split_words(s);
    if (status != EXIT_CLEAN)
        return status;
    if (!s->devices) {
        fprintf(stderr, "%s: the bus has no devices\n", s->who);
        return EXIT_RUN;
    }
    find_devices(s);
    find_paths(s);
    status = power_on(s, &twins);
    if (status == EXIT_CLEAN)
        status = read_signals(s);
    if (status == EXIT_CLEAN)
        status = read_script(s);
    if (status == EXIT_CLEAN) {
        try_signals(s);
        status = write_file(s);
    }
    if (status == EXIT_CLEAN)
        status = report_refused(s);
    ect_chain_free(s->chain);
    twin_args_free(&twins);
    return status;
}

static void free_save(save_t *s)
{
    for (size_t i = 0; i < s->option_count; i++)
        free(s->options[i].text);
    for (size_t i = 0; i < s->script_count; i++)
        free(s->script[i]);
    for (int i = 0; i < s->fresh_count; i++)
        free(s->fresh[i]);
    free(s->fresh);
    free(s->options);
    free(s->script);
    free(s->signals);
    free(s->devices);
    free(s->words);
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    save_t *s = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &s->twin;
        return 0;
    case 'o':
        s->output = text;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "'%s': the file is -o FILE", text);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

int command_save_bus(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"output", 'o', "FILE", 0, "File to write (default: standard output); paths below its folder become relative",
         0},
        {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .children = connection_children,
        .doc =
            "Writes the running bus as a bus file (docs/BUS-FILES.md): its devices and options, and the signals, plugs "
            "and faults as they are now. A bus that is started from the file and saved again gives the same file."};
    save_t s = {.who = argv[0]};
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    current = &s;
    s.connection = connection_open(&s.twin, argv[0]);
    if (!s.connection)
        return EXIT_OPEN;
    int status = save(&s);
    connection_close(s.connection);
    free_save(&s);
    return status;
}
