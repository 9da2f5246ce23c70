/* SPDX-License-Identifier: MIT */
#include "bus/control/outside.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/lamps.h"
#include "bus/chain/settings.h"
#include "bus/chain/signals.h"
#include "bus/chain/stats.h"
#include "wire/assert.h"

struct ect_outside {
    char name[ECT_OUTSIDE_NAME];
    const void *owner;      /* NULL: the plant has ended */
    bool runs;              /* has a period */
    bool waits;             /* the clock is stopped during its steps */
    bool fits;              /* values are rounded and limited */
    bool pending;           /* no reply to the present step yet */
    bool was_late;          /* reported */
    uint64_t period_ns;     /* period of the steps; with `on`: longest time to a reply */
    uint64_t due_ns;        /* next step; with `on`: end of the present one, ECT_NEVER: none */
    ect_setting_place_t on; /* a change of this signal begins a step; signal NULL: steps are periodic */
    uint8_t seen[8];        /* its value at the last step */
    uint64_t begun_ns;      /* time of the present step */
    uint64_t steps, late, refused;
    ect_stats_t took; /* replies by reply time */
    size_t read_count, write_count;
    ect_setting_place_t reads[ECT_OUTSIDE_VALUES];
    ect_setting_place_t writes[ECT_OUTSIDE_VALUES];
};

void ect_outsides_clear(ect_outsides_t *all)
{
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        free(all->plant[i]);
        all->plant[i] = NULL;
    }
}

static void report(const ect_outsides_t *all, const ect_outside_t *plant, const char *what)
{
    char text[ECT_OUTSIDE_MESSAGE];
    if (!all->report)
        return;
    (void)snprintf(text, sizeof text, "plant '%s' %s: its signals keep their last values", plant->name, what);
    all->report(all->ctx, text);
}

/* --- registration ------------------------------------------------------------------------------------------------- */

static ect_outside_t *owned(const ect_outsides_t *all, const void *owner)
{
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        if (all->plant[i] && all->plant[i]->owner == owner)
            return all->plant[i];
    }
    return NULL;
}

ect_outside_t *ect_outside_of(const ect_outsides_t *all, const void *owner)
{
    ect_outside_t *plant = owned(all, owner);
    return plant && plant->runs ? plant : NULL;
}

static ect_outside_t *named(const ect_outsides_t *all, const char *name)
{
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        if (all->plant[i] && strcmp(all->plant[i]->name, name) == 0)
            return all->plant[i];
    }
    return NULL;
}

ect_outside_t *ect_outside_named(const ect_outsides_t *all, const char *name)
{
    ect_outside_t *plant = named(all, name);
    return plant && plant->owner && plant->runs ? plant : NULL;
}

/* @return a place for a new plant: a free place, or that of an ended plant */
static ect_outside_t **free_place(ect_outsides_t *all)
{
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        if (!all->plant[i])
            return &all->plant[i];
    }
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        if (!all->plant[i]->owner)
            return &all->plant[i];
    }
    return NULL;
}

/* Starts a plant; a name of an ended plant continues its counters. @return NULL: *why is the reason */
static ect_outside_t *enter(ect_outsides_t *all, const void *owner, const char *name, const char **why)
{
    ect_outside_t *plant = named(all, name);
    if (plant && plant->owner) {
        *why = "a plant with this name is connected: give this one another name";
        return NULL;
    }
    if (!plant) {
        ect_outside_t **place = free_place(all);
        *why = "four plants are connected, which is the limit: end one of them";
        if (!place)
            return NULL;
        free(*place);
        *place = plant = calloc(1, sizeof *plant);
        *why = "not enough memory";
        if (!plant)
            return NULL;
        (void)snprintf(plant->name, sizeof plant->name, "%s", name);
    }
    plant->owner = owner;
    plant->runs = plant->waits = plant->pending = false;
    plant->read_count = plant->write_count = 0;
    plant->on.ref.signal = NULL;
    return plant;
}

/* @return whether the signal that begins the steps has changed */
static bool is_triggered(const ect_outside_t *plant)
{
    const ect_signal_ref_t *on = &plant->on.ref;
    return on->signal && memcmp(plant->seen, on->value, ect_signal_size(on->signal)) != 0;
}

static void see(ect_outside_t *plant)
{
    if (plant->on.ref.signal)
        memcpy(plant->seen, plant->on.ref.value, ect_signal_size(plant->on.ref.signal));
}

static bool is_number(const ect_signal_ref_t *ref, char *message)
{
    if (ect_signal_is_number(ref->signal))
        return true;
    (void)snprintf(message, ECT_SIGNAL_MESSAGE, "%s is a text: a plant reads and sets numbers", ref->name);
    return false;
}

static bool add(ect_outside_t *plant, const ect_chain_t *chain, size_t slave, const char *name, bool writes,
                char *message)
{
    size_t *count = writes ? &plant->write_count : &plant->read_count;
    ect_setting_place_t place;
    if (*count == ECT_OUTSIDE_VALUES) {
        (void)snprintf(message, ECT_SIGNAL_MESSAGE, "a plant %s at most 128 signals", writes ? "sets" : "reads");
        return false;
    }
    if (!ect_settings_find(chain, slave - 1, name, &place, message) || !is_number(&place.ref, message))
        return false;
    if (writes && place.ref.signal->access != ECT_SIGNAL_WRITE) {
        (void)snprintf(message, ECT_SIGNAL_MESSAGE, "%s is the twin's own: a plant can read it, not set it", name);
        return false;
    }
    (writes ? plant->writes : plant->reads)[(*count)++] = place;
    return true;
}

static bool add_all(ect_outside_t *plant, const ect_chain_t *chain, size_t slave, const cJSON *names, bool writes,
                    char *message)
{
    const cJSON *one;
    cJSON_ArrayForEach(one, names)
    {
        if (!cJSON_IsString(one)) {
            (void)snprintf(message, ECT_SIGNAL_MESSAGE, "\"reads\" and \"writes\" are lists of names of signals");
            return false;
        }
        if (!add(plant, chain, slave, one->valuestring, writes, message))
            return false;
    }
    return true;
}

/* @return the reason of a refusal; NULL: started, or not to be started yet */
static const char *start(const ect_outsides_t *all, ect_outside_t *plant, const cJSON *request, uint64_t now_ns)
{
    const char *key = plant->on.ref.signal ? "timeout_us" : "period_us";
    const cJSON *period = cJSON_GetObjectItemCaseSensitive(request, key);
    const bool wait = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(request, "wait"));
    if (!period)
        return NULL;
    if (!cJSON_IsNumber(period) || !(period->valuedouble >= (double)ECT_OUTSIDE_PERIOD_LEAST_US) ||
        !(period->valuedouble <= (double)ECT_OUTSIDE_PERIOD_MOST_US))
        return "\"period_us\" and \"timeout_us\" are numbers of microseconds from 100 to 2000000000";
    if (wait && !all->may_wait)
        return "\"wait\" needs a virtual clock (ectwin with --in-process --virtual-time): a bus does not wait";
    if (plant->read_count + plant->write_count == 0)
        return "a plant reads or sets a signal: name some in \"reads\" and \"writes\"";
    plant->period_ns = (uint64_t)(period->valuedouble * 1000 + 0.5);
    plant->due_ns = plant->on.ref.signal ? ECT_NEVER : now_ns;
    see(plant);
    plant->runs = true;
    plant->waits = wait;
    plant->fits = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(request, "fit"));
    return NULL;
}

static const char *find_or_enter(ect_outsides_t *all, const void *owner, const cJSON *request, ect_outside_t **plant)
{
    const cJSON *member = cJSON_GetObjectItemCaseSensitive(request, "name");
    const char *name = cJSON_GetStringValue(member);
    const char *why = NULL;
    *plant = owned(all, owner);
    if (*plant)
        return (*plant)->runs ? "this plant runs: its signals are fixed" : NULL;
    if (!name || *name == 0 || strlen(name) >= ECT_OUTSIDE_NAME)
        return "\"name\" of a plant is a text of 1 to 31 characters";
    *plant = enter(all, owner, name, &why);
    return *plant ? NULL : why;
}

/* Takes the signal whose changes begin the steps. */
static bool take_on(ect_outside_t *plant, const ect_chain_t *chain, size_t slave, const cJSON *request, char *message)
{
    const cJSON *on = cJSON_GetObjectItemCaseSensitive(request, "on");
    ect_setting_place_t place;
    if (!on)
        return true;
    if (!cJSON_IsString(on)) {
        (void)snprintf(message, ECT_SIGNAL_MESSAGE, "\"on\" is the name of a signal");
        return false;
    }
    if (!ect_settings_find(chain, slave - 1, on->valuestring, &place, message) || !is_number(&place.ref, message))
        return false;
    plant->on = place;
    return true;
}

const char *ect_outside_request(ect_outsides_t *all, const void *owner, const ect_chain_t *chain, size_t slave,
                                const cJSON *request, uint64_t now_ns, char *message)
{
    ect_outside_t *plant;
    const cJSON *reads = cJSON_GetObjectItemCaseSensitive(request, "reads");
    const cJSON *writes = cJSON_GetObjectItemCaseSensitive(request, "writes");
    const char *why = find_or_enter(all, owner, request, &plant);
    if (why)
        return why;
    const size_t read_count = plant->read_count;
    const size_t write_count = plant->write_count;
    const bool added = add_all(plant, chain, slave, reads, false, message) &&
                       add_all(plant, chain, slave, writes, true, message) &&
                       take_on(plant, chain, slave, request, message);
    why = added ? start(all, plant, request, now_ns) : message;
    if (why) {
        plant->read_count = read_count;
        plant->write_count = write_count;
    }
    return why;
}

/* --- steps -------------------------------------------------------------------------------------------------------- */

uint64_t ect_outsides_due(const ect_outsides_t *all)
{
    uint64_t due_ns = ECT_NEVER;
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        const ect_outside_t *plant = all->plant[i];
        if (plant && plant->owner && plant->runs)
            due_ns = ect_earlier(due_ns, plant->due_ns);
    }
    return due_ns;
}

ect_outside_t *ect_outside_due(const ect_outsides_t *all, const void *owner, uint64_t now_ns)
{
    ect_outside_t *plant = ect_outside_of(all, owner);
    return plant && (plant->due_ns <= now_ns || is_triggered(plant)) ? plant : NULL;
}

bool ect_outsides_triggered(const ect_outsides_t *all)
{
    for (size_t i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        const ect_outside_t *plant = all->plant[i];
        if (plant && plant->owner && plant->runs && is_triggered(plant))
            return true;
    }
    return false;
}

/* Advances to the next period after a time. @return the number of skipped periods, which have no step */
static uint64_t plan(ect_outside_t *plant, uint64_t now_ns)
{
    const uint64_t over = now_ns > plant->due_ns ? (now_ns - plant->due_ns) / plant->period_ns : 0;
    plant->due_ns += (over + 1) * plant->period_ns;
    return over;
}

static void count_late(ect_outsides_t *all, ect_outside_t *plant, uint64_t periods)
{
    plant->late += periods;
    if (periods > 0 && !plant->was_late) {
        plant->was_late = true;
        report(all, plant, "is late");
    }
}

void ect_outside_skip(ect_outsides_t *all, ect_outside_t *plant, uint64_t now_ns)
{
    if (plant->on.ref.signal) {
        see(plant);
        plant->due_ns = ECT_NEVER;
        plant->pending = false;
        count_late(all, plant, 1);
        return;
    }
    count_late(all, plant, plan(plant, now_ns) + 1);
}

static void show_lamps(const ect_outside_t *plant, const ect_chain_t *chain)
{
    for (size_t i = 0; i < plant->read_count; i++) {
        if (plant->reads[i].ref.plant == &ect_lamps_plant)
            ect_chain_show_lamps(chain, plant->reads[i].position);
    }
}

bool ect_outside_begin(ect_outsides_t *all, ect_outside_t *plant, const ect_chain_t *chain, uint64_t now_ns)
{
    const bool triggered = is_triggered(plant);
    if (plant->pending)
        ect_outside_skip(all, plant, now_ns);
    if (plant->pending || (plant->on.ref.signal && !triggered))
        return false;
    if (triggered)
        plant->due_ns = now_ns + plant->period_ns;
    else
        (void)plan(plant, now_ns); /* periods missed by the twins do not count for the plant */
    see(plant);
    plant->pending = true;
    plant->begun_ns = now_ns;
    plant->steps++;
    show_lamps(plant, chain);
    return true;
}

static void put_values(const ect_outside_t *plant, size_t from, ect_line_t *line)
{
    enum { LONGEST = 28 };
    char list[ECT_OUTSIDE_VALUES_IN_LINE * LONGEST + 3] = "[";
    size_t used = 1;
    for (size_t i = from; i < plant->read_count && i < from + ECT_OUTSIDE_VALUES_IN_LINE; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_read(&plant->reads[i].ref, text);
        const size_t length = strlen(text);
        ECT_ASSERT(length < LONGEST);
        if (i > from)
            list[used++] = ',';
        memcpy(list + used, text, length);
        used += length;
    }
    list[used++] = ']';
    list[used] = 0;
    ect_line_plain(line, "values", list);
}

bool ect_outside_line(const ect_outside_t *plant, unsigned int number, uint64_t elapsed_ns, ect_line_t *line)
{
    const size_t from = (size_t)number * ECT_OUTSIDE_VALUES_IN_LINE;
    if (number > 0 && from >= plant->read_count)
        return false;
    ect_line_begin(line);
    if (number == 0) {
        ect_line_number(line, "step", plant->steps);
        ect_line_time(line, elapsed_ns);
    }
    put_values(plant, from, line);
    ect_line_end(line);
    return true;
}

bool ect_outside_waits(const ect_outside_t *plant)
{
    return plant->waits && plant->pending;
}

void ect_outside_give_up(ect_outsides_t *all, ect_outside_t *plant)
{
    plant->waits = false;
    if (plant->on.ref.signal)
        ect_outside_skip(all, plant, plant->begun_ns);
    else
        count_late(all, plant, 1);
}

/* Converts a finite number of a reply to the value of its signal. */
static double fitted(const ect_outside_t *plant, size_t index, double value)
{
    return plant->fits ? ect_signal_fit(plant->writes[index].ref.signal, value) : value;
}

/* Converts the values to texts; NULL for null. @return the reason of a refusal; NULL: done */
static const char *read_values(const ect_outside_t *plant, const cJSON *request, char texts[][32],
                               const char *values[ECT_OUTSIDE_VALUES])
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(request, "values");
    const cJSON *one;
    size_t count = 0;
    if (!cJSON_IsArray(list) || (size_t)cJSON_GetArraySize(list) != plant->write_count)
        return "\"values\" is a list with a value for each signal that the plant sets";
    cJSON_ArrayForEach(one, list)
    {
        const bool number = cJSON_IsNumber(one) && isfinite(one->valuedouble);
        if (!number && !cJSON_IsNull(one) && !cJSON_IsBool(one))
            return "a value of a plant is a number, true, false or null";
        const double value = number ? one->valuedouble : cJSON_IsTrue(one) ? 1 : 0;
        (void)snprintf(texts[count], sizeof texts[count], "%.15g", fitted(plant, count, value));
        values[count] = cJSON_IsNull(one) ? NULL : texts[count];
        count++;
    }
    return NULL;
}

/* @return whether a reply names a step that was given up, and has been counted */
static bool is_over(const ect_outside_t *plant, const cJSON *request)
{
    const cJSON *step = cJSON_GetObjectItemCaseSensitive(request, "step");
    return cJSON_IsNumber(step) && (!plant->pending || step->valuedouble < (double)plant->steps);
}

const char *ect_outside_reply(ect_outside_t *plant, ect_chain_t *chain, const cJSON *request, uint64_t now_ns,
                              char *message)
{
    char texts[ECT_OUTSIDE_VALUES][32];
    const char *values[ECT_OUTSIDE_VALUES];
    if (plant->on.ref.signal && is_over(plant, request))
        return NULL;
    if (!plant->pending)
        return "no step of this plant is pending";
    plant->pending = false;
    if (plant->on.ref.signal)
        plant->due_ns = ECT_NEVER;
    ect_stats_answer(&plant->took, now_ns - plant->begun_ns);
    const char *why = read_values(plant, request, texts, values);
    if (!why && !ect_settings_write(chain, plant->writes, values, plant->write_count, now_ns, message))
        why = message;
    plant->refused += why != NULL;
    return why;
}

/* @return the position of the first signal at or after a position; SIZE_MAX: none */
static size_t next_position(const ect_outside_t *plant, size_t position)
{
    size_t next = SIZE_MAX;
    for (size_t i = 0; i < plant->write_count; i++) {
        const size_t at = plant->writes[i].position;
        if (at >= position && at < next)
            next = at;
    }
    return next;
}

cJSON *ect_outside_as_set(const ect_outside_t *plant, const cJSON *request, size_t *position)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(request, "values");
    const size_t here = next_position(plant, *position);
    if (here == SIZE_MAX)
        return NULL;
    *position = here + 1;
    cJSON *set = cJSON_CreateObject();
    cJSON_AddStringToObject(set, "op", "set");
    cJSON_AddNumberToObject(set, "slave", (double)here + 1);
    cJSON *values = cJSON_AddObjectToObject(set, "values");
    size_t i = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, list)
    {
        if (i < plant->write_count && plant->writes[i].position == here && !cJSON_IsNull(one)) {
            cJSON *value = cJSON_IsNumber(one) ? cJSON_CreateNumber(fitted(plant, i, one->valuedouble))
                                               : cJSON_Duplicate(one, false);
            cJSON_AddItemToObject(values, plant->writes[i].ref.name, value);
        }
        i++;
    }
    return set;
}

void ect_outside_left(ect_outsides_t *all, const void *owner)
{
    ect_outside_t *plant = owned(all, owner);
    if (!plant)
        return;
    plant->owner = NULL;
    plant->pending = false;
    if (plant->runs)
        report(all, plant, "has ended");
}

bool ect_outside_count(const ect_outsides_t *all, size_t number, ect_line_t *line)
{
    if (number >= ECT_OUTSIDE_PLANTS || !all->plant[number])
        return false;
    const ect_outside_t *plant = all->plant[number];
    ect_line_begin(line);
    ect_line_string(line, "plant", plant->name);
    ect_line_plain(line, "connected", plant->owner ? "true" : "false");
    ect_line_number(line, "period_us", plant->period_ns / 1000);
    ect_line_number(line, "steps", plant->steps);
    ect_line_number(line, "late", plant->late);
    ect_line_number(line, "refused", plant->refused);
    ect_line_number(line, "p50_us", ect_stats_quantile_us(plant->took.answers, 500));
    ect_line_number(line, "p99_us", ect_stats_quantile_us(plant->took.answers, 990));
    ect_line_number(line, "longest_us", plant->took.longest_answer_ns / 1000);
    ect_line_end(line);
    return true;
}
