/* SPDX-License-Identifier: MIT */
#include "eoe_args.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus_place.h"
#include "grow.h"
#include "text/number.h"
#include "twin_names.h"

enum { KEY_EOE = 0x300 };

static const struct argp_option options[] = {
    {"eoe", KEY_EOE, "[N:]NETWORK", 0,
     "Network behind twin N (default: the first twin with EoE): tap[NAME], a TAP interface; unix:PATH, a "
     "SOCK_SEQPACKET "
     "socket with one frame in each message; or echo, a responder for ARP, ping and UDP echo (docs/EOE.md). May be "
     "repeated",
     2},
    {0},
};

static bool is_place(const char *text)
{
    return strcmp(text, "echo") == 0 || ect_place_is_tap(text) || ect_place_path(text);
}

static void add(eoe_args_t *args, const struct argp_state *state, const char *text)
{
    uint64_t number = 0;
    const char *colon = strchr(text, ':');
    const char *place = colon && !is_place(text) ? colon + 1 : text;
    bool numbered = place != text && ect_number_begins(text, 0, UINT64_MAX, &number) == colon;
    if ((numbered && (number == 0 || number > UINT16_MAX)) || !is_place(place))
        argp_error(state, "--eoe takes tap, tapNAME, unix:PATH or echo, or one of them for a twin, as 2:tap0, not '%s'",
                   text);
    args->settings = grow(state, args->settings, args->count, sizeof *args->settings);
    args->settings[args->count++] = (eoe_setting_t){0, text, place};
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    bus_place_t place;
    if (key != KEY_EOE)
        return ARGP_ERR_UNKNOWN;
    add(state->input, bus_place_at(&place, state, text), text);
    return 0;
}

const struct argp eoe_argp = {.options = options, .parser = parse};

static bool is_host(const eoe_setting_t *setting)
{
    return strcmp(setting->place, "echo") != 0;
}

const char *eoe_args_host(const eoe_args_t *args)
{
    for (size_t i = 0; i < args->count; i++) {
        if (is_host(&args->settings[i]))
            return args->settings[i].text;
    }
    return NULL;
}

/* @return index of a setting's twin; `count`: no such twin, or without EoE; see message */
static size_t find_twin(const eoe_setting_t *setting, const ect_twin_config_t *twins, size_t count, char *message)
{
    size_t i = setting->twin;
    if (i > 0 && i <= count && ect_network_entry(twins[i - 1].device))
        return i - 1;
    if (i > count)
        snprintf(message, EOE_MESSAGE, "--eoe %.80s: the chain has %zu twin%s", setting->text, count,
                 count == 1 ? "" : "s");
    else if (i > 0)
        snprintf(message, EOE_MESSAGE,
                 "--eoe %.80s: twin %zu, %.80s, has no EoE: take a device whose ESI file has Mailbox/EoE",
                 setting->text, i, twins[i - 1].device->name);
    if (i > 0)
        return count;
    while (i < count && !ect_network_entry(twins[i].device))
        i++;
    if (i == count)
        snprintf(message, EOE_MESSAGE, "--eoe %.80s: no twin has EoE: take a device whose ESI file has Mailbox/EoE",
                 setting->text);
    return i;
}

/* Reads an optional "N:" or "NAME:". @return false: no such twin; see message */
static bool take_twin(const ect_names_t *names, eoe_setting_t *setting, char *message)
{
    const char *rest = setting->text;
    setting->twin = setting->place != rest ? twin_of(names, &rest, 0) : 0;
    if (setting->place == setting->text || setting->twin != 0)
        return true;
    snprintf(message, EOE_MESSAGE, "--eoe %.80s: no twin is named '%.*s': name it in the list, as %.*s=DEVICE",
             setting->text, (int)strcspn(rest, ":"), rest, (int)strcspn(rest, ":"), rest);
    return false;
}

/* @return false: see message, which remains for lack of memory */
static bool join_one(eoe_args_t *args, eoe_setting_t *setting, const ect_twin_config_t *twins, char *message)
{
    size_t i = find_twin(setting, twins, args->network_count, message);
    if (i == args->network_count)
        return false;
    setting->twin = i + 1;
    if (args->networks[i]) {
        snprintf(message, EOE_MESSAGE, "--eoe %.80s: twin %zu has a network already: leave one of the two out",
                 setting->text, i + 1);
        return false;
    }
    args->networks[i] = ect_network_new(twins[i].device, is_host(setting) ? ECT_NETWORK_HOST : ECT_NETWORK_ECHO);
    return args->networks[i] != NULL;
}

/* A twin with EoE and without --eoe keeps its behaviour, and gets the signals. */
static bool join_rest(eoe_args_t *args, ect_twin_config_t *twins)
{
    for (size_t i = 0; i < args->network_count; i++) {
        if (!ect_network_entry(twins[i].device))
            continue;
        if (!args->networks[i])
            args->networks[i] = ect_network_new(twins[i].device, ECT_NETWORK_OWN);
        if (!args->networks[i])
            return false;
        ect_network_join(args->networks[i], &twins[i]);
    }
    return true;
}

bool eoe_args_join(eoe_args_t *args, const ect_names_t *names, ect_twin_config_t *twins, size_t count, char *message)
{
    const char *host = eoe_args_host(args);
    if (host && !args->has_hosts) {
        args->wrong = host;
        snprintf(message, EOE_MESSAGE,
                 "--eoe %.80s needs a process of the twins' own: 'ectwin run', or 'ectwin with' without --in-process",
                 host);
        return false;
    }
    snprintf(message, EOE_MESSAGE, "not enough memory");
    args->networks = calloc(count, sizeof(ect_network_t *));
    args->network_count = args->networks ? count : 0;
    bool done = args->networks != NULL;
    for (size_t i = 0; done && i < args->count; i++) {
        args->wrong = args->settings[i].text;
        done = take_twin(names, &args->settings[i], message) && join_one(args, &args->settings[i], twins, message);
    }
    return done && join_rest(args, twins);
}

/* @return NULL: see message; else the name of the interface, or the path */
static const char *open_one(const eoe_args_t *args, const eoe_setting_t *setting, ect_hosts_t *hosts, char *message)
{
    char why[ECT_PLACE_MESSAGE];
    const char *name = ect_hosts_open(hosts, setting->place, args->networks[setting->twin - 1], setting->twin - 1, why);
    if (!name)
        snprintf(message, EOE_MESSAGE, "--eoe %.80s: %s", setting->text, why);
    return name;
}

bool eoe_args_open(const eoe_args_t *args, const char *who, bool quiet, ect_hosts_t **hosts, char *message)
{
    *hosts = NULL;
    if (!eoe_args_host(args))
        return true;
    *hosts = ect_hosts_new();
    if (!*hosts)
        snprintf(message, EOE_MESSAGE, "--eoe: %s", strerror(errno));
    for (size_t i = 0; *hosts && i < args->count; i++) {
        const eoe_setting_t *setting = &args->settings[i];
        const char *name = is_host(setting) ? open_one(args, setting, *hosts, message) : "";
        if (name && *name && !quiet)
            fprintf(stderr, "%s: the network of twin %zu is at '%s'\n", who, setting->twin, name);
        if (name)
            continue;
        ect_hosts_close(*hosts);
        *hosts = NULL;
    }
    return *hosts != NULL;
}

void eoe_args_free(eoe_args_t *args)
{
    for (size_t i = 0; i < args->network_count; i++)
        ect_network_free(args->networks[i]);
    free(args->networks);
    free(args->settings);
    *args = (eoe_args_t){0};
}
