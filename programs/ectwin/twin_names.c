/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "twin_names.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus_place.h"
#include "commands.h"
#include "text/number.h"

/* Removes "*N" from the end of a device. @return N; 1: no "*N"; 0: N is not a number of twins */
static size_t take_count(char *device)
{
    uint64_t count = 0;
    char *star = strrchr(device, '*');
    if (!star)
        return 1;
    *star = 0;
    return ect_number(star + 1, 1, UINT16_MAX, &count) ? (size_t)count : 0;
}

/* Removes "NAME=" from the beginning of a device; a path may contain '=' after its ':'. */
static const char *take_name(const struct argp_state *state, char **device)
{
    char *name = *device;
    size_t length = strcspn(name, "=:");
    if (name[length] != '=')
        return NULL;
    if (length == 0 || ect_name_begins(name) != length)
        argp_error(state,
                   "'%.80s': a name is a letter a to z, then letters, digits, _ and -, at most %d characters, as in "
                   "gripper=fzm1",
                   name, ECT_NAME_ROOM - 1);
    name[length] = 0;
    *device = name + length + 1;
    return name;
}

bool listed_device_next(const struct argp_state *state, char **rest, listed_device_t *one)
{
    char *word = strsep(rest, ",");
    if (!word)
        return false;
    one->name = take_name(state, &word);
    one->count = take_count(word);
    one->device = word;
    if (one->count == 0)
        argp_error(state, "'%s*...': a count is 1 to %d twins in all, as in fzm1*3", word, UINT16_MAX);
    return true;
}

/* A single twin is gripper; several twins are gripper1, gripper2, ... */
static void add_names(ect_names_t *names, const struct argp_state *state, size_t first, const listed_device_t *one)
{
    bus_place_t place;
    for (size_t i = 0; one->name && i < one->count; i++) {
        char name[ECT_NAME_ROOM + 24];
        int length = one->count == 1 ? snprintf(name, sizeof name, "%s", one->name)
                                     : snprintf(name, sizeof name, "%s%zu", one->name, i + 1);
        if (length >= ECT_NAME_ROOM)
            argp_error(bus_place_at_twin(&place, state, first + i + 1), "the name '%s' is longer than %d characters",
                       name, ECT_NAME_ROOM - 1);
        if (!ect_names_add(names, first + i, name))
            argp_error(state, "two twins have the name '%s'", name);
    }
}

static size_t count_twins(const struct argp_state *state, char *rest)
{
    listed_device_t one;
    size_t count = 0;
    while (listed_device_next(state, &rest, &one)) {
        count += one.count;
        if (count > UINT16_MAX)
            argp_error(state, "'%s*...': a count is 1 to %d twins in all, as in fzm1*3", one.device, UINT16_MAX);
    }
    return count;
}

ect_names_t *names_of_devices(const struct argp_state *state, const char *list)
{
    listed_device_t one;
    char *counted = strdup(list), *named = strdup(list);
    char *rest = named;
    size_t first = 0;
    ect_names_t *names = counted && named ? ect_names_new(count_twins(state, counted)) : NULL;
    if (!names)
        argp_failure(state, EXIT_RUN, ENOMEM, "the names of the twins");
    for (; names && listed_device_next(state, &rest, &one); first += one.count)
        add_names(names, state, first, &one);
    free(counted);
    free(named);
    return names;
}

size_t twin_of(const ect_names_t *names, const char **text, size_t none)
{
    uint64_t number = 0;
    const char *end = ect_number_begins(*text, 0, UINT64_MAX, &number);
    size_t length = strcspn(*text, ":");
    if (!end && (*text)[length] == ':') {
        number = ect_names_find(names, *text, length);
        end = number != 0 ? *text + length : NULL;
    }
    if (!end || *end != ':')
        return none;
    *text = end + 1;
    return number <= UINT16_MAX ? (size_t)number : 0;
}
