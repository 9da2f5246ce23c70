/* SPDX-License-Identifier: MIT */
#include "wiring_args.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check/check.h"
#include "commands.h"
#include "esc/personality.h"

enum { KEY_ESC = 0x200 };

static const struct argp_option options[] = {
    {"esc", KEY_ESC, "[N:]NAME", 0,
     "Controller chip of twin N, without N of all (default: the device's own); 'help' lists them", 2},
    {0},
};

static void list_chips(void)
{
    for (size_t i = 0; ect_esc_personality_at(i); i++) {
        const ect_esc_personality_t *p = ect_esc_personality_at(i);
        printf("%-13s %u FMMUs, %u SyncManagers, %2u KB\n", p->name, p->fmmu_count, p->sm_count, p->ram_kb);
    }
    exit(EXIT_CLEAN);
}

/* A number and a colon in front name a twin. @return what follows */
static const char *twin_of(const struct argp_state *state, const char *text, size_t *twin)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    *twin = 0;
    if (end == text || *end != ':' || text[0] == '-' || text[0] == '+')
        return text;
    if (number == 0 || number > UINT16_MAX)
        argp_error(state, "%s: twins are counted from 1", text);
    *twin = number;
    return end + 1;
}

static void add(wiring_args_t *args, const struct argp_state *state, int key, const char *text)
{
    wiring_wish_t *grown = realloc(args->wishes, (args->count + 1) * sizeof *grown);
    if (!grown)
        argp_failure(state, EXIT_RUN, ENOMEM, "too many options");
    args->wishes = grown;
    wiring_wish_t *wish = &args->wishes[args->count++];
    wish->key = key;
    wish->text = twin_of(state, text, &wish->twin);
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    if (key != KEY_ESC)
        return ARGP_ERR_UNKNOWN;
    if (strcmp(text, "help") == 0)
        list_chips();
    add(state->input, state, key, text);
    return 0;
}

const struct argp wiring_argp = {.options = options, .parser = parse};

/* The device has to fit into the chip that it did not ask for. */
static void set_esc(const struct argp_state *state, ect_twin_config_t *twin, size_t position, const char *name)
{
    char why[ECT_CHECK_TEXT];
    ect_device_t other = *twin->device;
    other.esc = name;
    if (!ect_esc_personality(name))
        argp_error(state, "there is no chip '%s'; '--esc help' lists those there are", name);
    if (!ect_device_check(&other, why, sizeof why))
        argp_failure(state, EXIT_USAGE, 0, "twin %zu, %s, cannot have the chip %s: %s", position, twin->device->name,
                     name, why);
    twin->esc = name;
}

void wiring_args_apply(const wiring_args_t *args, const struct argp_state *state, ect_twin_config_t *twins,
                       size_t count)
{
    for (size_t w = 0; w < args->count; w++) {
        const wiring_wish_t *wish = &args->wishes[w];
        if (wish->twin > count)
            argp_error(state, "--esc %zu:%s: there are %zu twins", wish->twin, wish->text, count);
        for (size_t i = 0; i < count; i++) {
            if (wish->twin == 0 || wish->twin == i + 1)
                set_esc(state, &twins[i], i + 1, wish->text);
        }
    }
}

void wiring_args_free(wiring_args_t *args)
{
    free(args->wishes);
}
