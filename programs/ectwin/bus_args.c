/* SPDX-License-Identifier: MIT */
#include "bus_args.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus_place.h"
#include "buses/bus_file.h"

/* Words of the command line until the program ends: options point into them. */
static struct {
    ect_bus_file_t file;
    char **words;
} given;

__attribute__((destructor)) static void free_given(void)
{
    ect_bus_file_free(&given.file);
    free(given.words);
}

/* --- options ------------------------------------------------------------------------------------------------------ */

/* Finds an option by its long name, or by the beginning of the name. @return NULL: none */
static const struct argp_option *find_begun(const struct argp *argp, const char *name)
{
    const struct argp_option *begun = NULL;
    for (const struct argp_option *o = argp->options; o && (o->name || o->key); o++) {
        if (!o->name || strncmp(o->name, name, strlen(name)) != 0)
            continue;
        if (strcmp(o->name, name) == 0)
            return o;
        begun = o;
    }
    for (const struct argp_child *child = argp->children; child && child->argp; child++) {
        const struct argp_option *found = find_begun(child->argp, name);
        if (found && strcmp(found->name, name) == 0)
            return found;
        begun = begun ? begun : found;
    }
    return begun;
}

static const struct argp_option *find_letter(const struct argp *argp, int letter)
{
    const struct argp_option *found = NULL;
    for (const struct argp_option *o = argp->options; o && !found && (o->name || o->key); o++)
        found = o->key == letter ? o : NULL;
    for (const struct argp_child *child = argp->children; !found && child && child->argp; child++)
        found = find_letter(child->argp, letter);
    return found;
}

static const char socket_prefix[] = "unix:";

static bool is_socket(const struct argp_option *option)
{
    return option->name && strcmp(option->name, "eoe") == 0;
}

static bool is_path(const struct argp_option *option)
{
    static const char twin[] = "[N:]";
    const char *arg = option->arg ? option->arg : "";
    if (strncmp(arg, twin, strlen(twin)) == 0)
        arg += strlen(twin);
    size_t length = strcspn(arg, "[");
    return (length == 4 && strncmp(arg, "FILE", length) == 0) || (length == 3 && strncmp(arg, "DIR", length) == 0);
}

const char *bus_option_path(const struct argp_option *option, const char *text)
{
    if (is_path(option))
        return text;
    const bool named = is_socket(option) && strncmp(text, socket_prefix, strlen(socket_prefix)) == 0;
    return named ? text + strlen(socket_prefix) : NULL;
}

/* Every path is one of output but these. */
static bool is_input(const struct argp_option *option)
{
    static const char *const names[] = {"faults", "scenario", "play", "esi-dir"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(names[i], option->name) == 0)
            return true;
    }
    return false;
}

bool bus_option_writes(const struct argp_option *option)
{
    return (is_path(option) || is_socket(option)) && !is_input(option);
}

static unsigned int kind_of(void *ctx, const char *name)
{
    const struct argp *argp = ctx;
    const struct argp_option *o = find_begun(argp, name);
    if (!o || strcmp(o->name, name) != 0)
        return ECT_BUS_OPTION_NONE;
    if (!o->arg)
        return ECT_BUS_OPTION_FLAG;
    unsigned int kind = ECT_BUS_OPTION_VALUE;
    if (is_path(o))
        kind |= ECT_BUS_OPTION_PATH;
    if (is_socket(o))
        kind |= ECT_BUS_OPTION_SOCKET;
    if (bus_option_writes(o))
        kind |= ECT_BUS_OPTION_OUTPUT;
    if (strncmp(o->arg, "[N:]", 4) == 0)
        kind |= ECT_BUS_OPTION_OF_TWIN;
    return kind;
}

/* Whether the next word belongs to this option, which may be abbreviated: "--see 7", "--realtime 70". */
static bool takes_next(const struct argp *argp, const char *word, const char *next)
{
    const struct argp_option *o;
    if (word[1] == '-')
        o = strchr(word, '=') ? NULL : find_begun(argp, word + 2);
    else
        o = word[2] == '\0' ? find_letter(argp, word[1]) : NULL;
    return o && o->arg && ((o->flags & OPTION_ARG_OPTIONAL) == 0 || (next && *next >= '0' && *next <= '9'));
}

/* @return index of the first operand in argv; 0: none */
static int first_operand(const struct argp *argp, int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        if (argv[i][0] != '-' || argv[i][1] == '\0')
            return i;
        if (strcmp(argv[i], "--") == 0)
            return 0;
        i += takes_next(argp, argv[i], i + 1 < argc ? argv[i + 1] : NULL);
    }
    return 0;
}

void bus_args_expand(const struct argp *argp, int *argc, char ***argv)
{
    char text[600];
    int operand = first_operand(argp, *argc, *argv);
    const ect_bus_options_t options = {.find = kind_of, .ctx = (void *)(uintptr_t)argp};
    if (operand == 0 || !ect_bus_file_is((*argv)[operand]))
        return;
    bool fine = ect_bus_file_read(&given.file, (*argv)[operand], &options, text, sizeof text);
    given.words = fine ? calloc((size_t)*argc + given.file.count + 1, sizeof *given.words) : NULL;
    if (!given.words || !bus_place_open((*argv)[operand], &given.file)) {
        fprintf(stderr, "%s: %s\n", (*argv)[0], fine ? "no memory left" : text);
        exit(EXIT_OPEN);
    }
    char **word = given.words;
    *word++ = (*argv)[0];
    for (size_t i = 0; i < given.file.count; i++)
        *word++ = given.file.words[i];
    for (int i = 1; i < *argc; i++)
        *word++ = i == operand ? given.file.devices : (*argv)[i];
    *argv = given.words;
    *argc += (int)given.file.count;
}

error_t bus_operand_parse(bus_operand_t *bus, int key, char *text, struct argp_state *state)
{
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &bus->twins;
        return 0;
    case ARGP_KEY_ARG:
        if (bus->devices)
            argp_error(state, "one bus at a time: a bus file, or devices with commas between them");
        bus->devices = text;
        return 0;
    case ARGP_KEY_END:
        if (!bus->devices)
            argp_error(state, "no bus: name a bus file or devices");
        twin_args_devices(&bus->twins, state, bus->devices);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}
