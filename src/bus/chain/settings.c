/* SPDX-License-Identifier: MIT */
#include "bus/chain/settings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct step {
    ect_setting_place_t place;
    const char *value;
    bool waits; /* refused so far; another setting may be a condition */
} step_t;

/* @return the number of characters to change, insert or delete between two names (Levenshtein distance) */
static size_t distance(const char *a, const char *b)
{
    size_t row[ECT_SIGNAL_NAME + 1];
    size_t length = strlen(b);
    for (size_t i = 0; i <= length; i++)
        row[i] = i;
    for (size_t n = 1; *a != 0; a++, n++) {
        size_t corner = row[0];
        row[0] = n;
        for (size_t i = 1; i <= length; i++) {
            size_t best = corner + (*a != b[i - 1]);
            corner = row[i];
            best = row[i] + 1 < best ? row[i] + 1 : best;
            row[i] = row[i - 1] + 1 < best ? row[i - 1] + 1 : best;
        }
    }
    return row[length];
}

/* Finds the signal whose name is nearest to a wrong name. @return whether a name differs by few characters */
static bool find_nearest(const ect_chain_t *chain, size_t position, const char *wrong, char name[ECT_SIGNAL_NAME])
{
    enum { MOST = 2 };
    ect_chain_cursor_t cursor = {0};
    ect_signal_ref_t ref;
    size_t best = MOST + 1;
    size_t length = strlen(wrong);
    while (length < ECT_SIGNAL_NAME && ect_chain_next_signal(chain, position, &cursor, &ref)) {
        size_t other = strlen(ref.name);
        if (other + MOST < length || length + MOST < other || other >= ECT_SIGNAL_NAME)
            continue;
        size_t now = distance(wrong, ref.name);
        if (now < best && now < length) {
            best = now;
            strcpy(name, ref.name);
        }
    }
    return best <= MOST;
}

/* Checks whether a name begins with an unknown twin, a part before a dot or colon that is neither a twin nor the group
 * of a signal: "crane.low", "crane:low". @return the length of that part; 0: none */
static size_t unknown_twin(const ect_chain_t *chain, size_t position, const char *wrong)
{
    ect_chain_cursor_t cursor = {0};
    ect_signal_ref_t ref;
    size_t length = strcspn(wrong, ".:");
    if (!ect_chain_names(chain) || wrong[length] == 0 || length >= ECT_NAME_ROOM)
        return 0;
    while (ect_chain_next_signal(chain, position, &cursor, &ref)) {
        if (strncmp(ref.name, wrong, length) == 0 && ref.name[length] == '.')
            return 0;
    }
    return length;
}

static void report_unknown(const ect_chain_t *chain, size_t position, const char *wrong, char *message)
{
    char name[ECT_SIGNAL_NAME];
    size_t twin = ect_chain_resolve(chain, &position, &wrong) ? 0 : unknown_twin(chain, position, wrong);
    int used = snprintf(message, ECT_SIGNAL_MESSAGE, "slave %zu has no signal '%.60s'", position + 1, wrong);
    size_t at = used > 0 ? (size_t)used : 0;
    if (find_nearest(chain, position, wrong, name))
        snprintf(message + at, ECT_SIGNAL_MESSAGE - at, "; did you mean '%s'?", name);
    else if (twin > 0)
        snprintf(message + at, ECT_SIGNAL_MESSAGE - at,
                 ", and no twin has the name '%.*s': 'ectwin get -n 0 ecat.state' lists the names of running twins",
                 (int)twin, wrong);
    else
        snprintf(message + at, ECT_SIGNAL_MESSAGE - at, ": 'ectwin list-signals DEVICE' lists those of a device%s",
                 ect_chain_count(chain) > 1 ? "; -n chooses the slave" : "");
}

bool ect_settings_find(const ect_chain_t *chain, size_t position, const char *name, ect_setting_place_t *place,
                       char *message)
{
    if (!ect_chain_signal(chain, position, name, &place->ref)) {
        report_unknown(chain, position, name, message);
        return false;
    }
    place->position = position;
    (void)ect_chain_resolve(chain, &place->position, &name);
    return true;
}

/* Checks names, access and ranges before any change. */
static bool prepare(const ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                    step_t *steps, char *message)
{
    for (size_t i = 0; i < count; i++) {
        if (!ect_settings_find(chain, position, settings[i].name, &steps[i].place, message) ||
            !ect_signal_check(&steps[i].place.ref, settings[i].value, message))
            return false;
        steps[i].value = settings[i].value;
    }
    return true;
}

/* Repeats refused settings before `end` until no further one is accepted. @return the number of refused settings */
static size_t try_again(step_t *steps, size_t end, uint64_t now_ns)
{
    char message[ECT_SIGNAL_MESSAGE];
    size_t waiting = 0;
    for (size_t i = 0; i < end; i++) {
        if (!steps[i].waits)
            continue;
        steps[i].waits = !ect_signal_write(&steps[i].place.ref, steps[i].value, now_ns, message);
        waiting += steps[i].waits;
        if (!steps[i].waits && waiting > 0)
            return try_again(steps, end, now_ns); /* an earlier refused setting may depend on this one */
    }
    return waiting;
}

/* @return 0 for settings that come first */
static unsigned int turn_of(const step_t *step)
{
    unsigned int turn = step->place.ref.signal->turn;
    return turn > 0 ? turn - 1 : UINT8_MAX;
}

/* Sorts the settings with a turn first; the others keep the given order. */
static void sort(step_t *steps, size_t count)
{
    for (size_t end = 1; end < count; end++) {
        step_t step = steps[end];
        size_t at = end;
        for (; at > 0 && turn_of(&steps[at - 1]) > turn_of(&step); at--)
            steps[at] = steps[at - 1];
        steps[at] = step;
    }
}

static bool write_all(step_t *steps, size_t count, uint64_t now_ns, char *message)
{
    char other[ECT_SIGNAL_MESSAGE];
    size_t waiting = 0;
    for (size_t i = 0; i < count; i++) {
        steps[i].waits = !ect_signal_write(&steps[i].place.ref, steps[i].value, now_ns, waiting == 0 ? message : other);
        if (steps[i].waits)
            waiting++;
        else if (waiting > 0)
            waiting = try_again(steps, i, now_ns);
    }
    return waiting == 0;
}

/* Calls `act` once for each twin of the steps. @return false: `act` has returned false, which ends the calls */
static bool each_twin(ect_chain_t *chain, const step_t *steps, size_t count,
                      bool (*act)(ect_chain_t *chain, size_t position))
{
    for (size_t i = 0; i < count; i++) {
        size_t first = 0;
        while (steps[first].place.position != steps[i].place.position)
            first++;
        if (first == i && !act(chain, steps[i].place.position))
            return false;
    }
    return true;
}

static bool wake(ect_chain_t *chain, size_t position)
{
    ect_chain_wake(chain, position);
    return true;
}

static bool put_back(ect_chain_t *chain, size_t position)
{
    ect_chain_put_back(chain, position);
    return true;
}

/* Saves the twins, then sets all signals and wakes the twins; restores the twins after a refusal. */
static bool change(ect_chain_t *chain, step_t *steps, size_t count, uint64_t now_ns, char *message)
{
    if (count > 1 && !each_twin(chain, steps, count, ect_chain_keep))
        return false;
    sort(steps, count);
    const bool done = write_all(steps, count, now_ns, message);
    if (done)
        (void)each_twin(chain, steps, count, wake);
    else if (count > 1)
        (void)each_twin(chain, steps, count, put_back);
    return done;
}

bool ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                        uint64_t now_ns, char *message)
{
    step_t *steps = calloc(count > 0 ? count : 1, sizeof *steps);
    snprintf(message, ECT_SIGNAL_MESSAGE, "not enough memory");
    const bool done = steps && prepare(chain, position, settings, count, steps, message) &&
                      change(chain, steps, count, now_ns, message);
    free(steps);
    return done;
}

bool ect_settings_write(ect_chain_t *chain, const ect_setting_place_t *places, const char *const *values, size_t count,
                        uint64_t now_ns, char *message)
{
    step_t *steps = calloc(count > 0 ? count : 1, sizeof *steps);
    size_t used = 0;
    bool done = steps != NULL;
    snprintf(message, ECT_SIGNAL_MESSAGE, "not enough memory");
    for (size_t i = 0; done && i < count; i++) {
        if (!values[i])
            continue;
        done = ect_signal_check(&places[i].ref, values[i], message);
        steps[used++] = (step_t){.place = places[i], .value = values[i]};
    }
    done = done && change(chain, steps, used, now_ns, message);
    free(steps);
    return done;
}
