/* SPDX-License-Identifier: MIT */
/* Checks of signals: names, ranges and offsets. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "check/internal.h"
#include "seams/modbus.h"
#include "seams/standard.h"
#include "wire/assert.h"

enum { LONGEST_NAME = 40, LONGEST_TEXT = 255 };

typedef struct signal_place {
    const report_t *r;
    const ect_plant_t *plant;
    const ect_signal_group_t *group;
    const ect_signal_t *signal;
    bool ascending; /* the names of the group are in ascending order, hence unique */
} signal_place_t;

static bool wrong_signal(const signal_place_t *p, const char *why)
{
    return wrong(p->r, "signal %s%s%.40s: %s", p->group->prefix ? p->group->prefix : "", p->group->prefix ? "." : "",
                 p->signal->name ? p->signal->name : "?", why);
}

static size_t size_of(const ect_signal_t *signal)
{
    static const uint8_t sizes[] = {
        [ECT_SIGNAL_BOOL] = 1, [ECT_SIGNAL_U8] = 1,     [ECT_SIGNAL_I16] = 2,  [ECT_SIGNAL_U16] = 2,
        [ECT_SIGNAL_I32] = 4,  [ECT_SIGNAL_U32] = 4,    [ECT_SIGNAL_I8] = 1,   [ECT_SIGNAL_I64] = 8,
        [ECT_SIGNAL_U64] = 8,  [ECT_SIGNAL_REAL32] = 4, [ECT_SIGNAL_REAL] = 8, [ECT_SIGNAL_DESCRIBED] = 2};
    ECT_ASSERT((unsigned int)signal->type <= ECT_SIGNAL_DESCRIBED); /* range_good */
    ECT_ASSERT(signal->maximum >= 0 || signal->type != ECT_SIGNAL_TEXT);
    if (signal->type == ECT_SIGNAL_TEXT)
        return (size_t)signal->maximum + 1;
    return signal->type == ECT_SIGNAL_BYTES ? (size_t)signal->maximum : sizes[signal->type];
}

static bool name_good(const char *name)
{
    return name && *name != 0 && strlen(name) <= LONGEST_NAME &&
           strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_") == strlen(name);
}

static bool range_good(const signal_place_t *p)
{
    static const struct {
        int64_t lowest, highest;
    } ranges[] = {[ECT_SIGNAL_BOOL] = {0, 1},
                  [ECT_SIGNAL_U8] = {0, UINT8_MAX},
                  [ECT_SIGNAL_I16] = {INT16_MIN, INT16_MAX},
                  [ECT_SIGNAL_U16] = {0, UINT16_MAX},
                  [ECT_SIGNAL_I32] = {INT32_MIN, INT32_MAX},
                  [ECT_SIGNAL_U32] = {0, UINT32_MAX},
                  [ECT_SIGNAL_I8] = {INT8_MIN, INT8_MAX},
                  [ECT_SIGNAL_I64] = {INT64_MIN, INT64_MAX},
                  [ECT_SIGNAL_U64] = {0, INT64_MAX},
                  [ECT_SIGNAL_REAL32] = {INT64_MIN, INT64_MAX},
                  [ECT_SIGNAL_REAL] = {INT64_MIN, INT64_MAX},
                  [ECT_SIGNAL_TEXT] = {0, ECT_SIGNAL_LONGEST_TEXT},
                  [ECT_SIGNAL_BYTES] = {0, ECT_SIGNAL_LONGEST_BYTES},
                  [ECT_SIGNAL_DESCRIBED] = {0, ECT_SIGNAL_LONGEST_TEXT}};
    const ect_signal_t *s = p->signal;
    bool room = s->type == ECT_SIGNAL_TEXT || s->type == ECT_SIGNAL_BYTES || s->type == ECT_SIGNAL_DESCRIBED;
    if ((unsigned int)s->type > ECT_SIGNAL_DESCRIBED)
        return wrong_signal(p, "there is no such type");
    if (s->minimum > s->maximum || s->minimum < ranges[s->type].lowest || s->maximum > ranges[s->type].highest)
        return wrong_signal(p, "its range is empty, or beyond its type");
    return !room || (s->minimum == 0 && s->maximum > 0) ? true
                                                        : wrong_signal(p, "its maximum is its room, its minimum 0");
}

static bool signal_good(const signal_place_t *p)
{
    const ect_signal_group_t *g = p->group;
    const ect_signal_t *s = p->signal;
    if (!name_good(s->name))
        return wrong_signal(p, "a name has lower case, digits and '_', at most 40");
    if (!text_good(p->r, "a signal's meaning", s->meaning, LONGEST_TEXT) || !range_good(p))
        return false;
    if (s->type == ECT_SIGNAL_DESCRIBED && (s->access != ECT_SIGNAL_READ || !p->plant->signal_describe))
        return wrong_signal(p, "a described signal is read only and needs signal_describe");
    ECT_ASSERT(g->offset <= p->r->device->instance_size); /* group_place_good */
    size_t room = g->count > 1 ? g->stride : p->r->device->instance_size - g->offset;
    if (s->offset > room || size_of(s) > room - s->offset)
        return wrong_signal(p, "it is not inside its structure");
    for (const ect_signal_t *other = p->ascending ? s : g->signals; other < s; other++) {
        if (strcmp(other->name, s->name) == 0)
            return wrong_signal(p, "there are two of that name");
    }
    return true;
}

/* @return whether the names ascend, as in the large group of an ESI file's dictionary */
static bool ascends(const ect_signal_group_t *g)
{
    for (unsigned int n = 1; n < g->signal_count; n++) {
        const char *before = g->signals[n - 1].name;
        const char *name = g->signals[n].name;
        if (!before || !name || strcmp(before, name) >= 0)
            return false;
    }
    return true;
}

static const char *prefix_of(const ect_signal_group_t *g)
{
    return g->prefix ? g->prefix : "";
}

/* @return whether all structures of a group are inside the instance */
static bool is_inside(const report_t *r, const ect_signal_group_t *g)
{
    size_t whole = r->device->instance_size;
    size_t more = g->count > 1 ? (size_t)g->count * g->stride : 0;
    return g->offset <= whole && more <= whole - g->offset;
}

static bool group_place_good(const report_t *r, const ect_signal_group_t *g)
{
    if (g->prefix && !name_good(g->prefix))
        return wrong(r, "signals: a prefix has lower case, digits and '_', at most 40");
    if (g->count > 0 && !g->prefix)
        return wrong(r, "signals: numbered ones need a prefix");
    if (!g->signals && g->signal_count > 0)
        return wrong(r, "signals: those of '%.40s' are missing", prefix_of(g));
    if (!is_inside(r, g))
        return wrong(r, "signals: the structures of '%.40s' are not inside the instance", prefix_of(g));
    return true;
}

static bool outside_good(const ect_plant_t *plant, const report_t *r)
{
    size_t whole = r->device->instance_size;
    if (plant->outside_size == 0)
        return true;
    if (plant->outside_offset < sizeof(ect_standard_t) || plant->outside_offset > whole ||
        plant->outside_size > whole - plant->outside_offset)
        return wrong(r, "plant: its outside part is not inside the instance, behind ect_standard_t");
    return true;
}

static bool modbus_good(const ect_modbus_t *m)
{
    return !m || (m->read && m->may_write && m->write && m->connections > 0 && m->idle_ms > 0);
}

bool ect_plant_check(const ect_plant_t *plant, const ect_device_t *device, char *text, size_t room)
{
    const report_t r = {.device = device, .text = text, .room = room};
    (void)wrong(&r, "%s", "");
    if (!plant)
        return true;
    if (!outside_good(plant, &r))
        return false;
    if (!modbus_good(plant->modbus))
        return wrong(&r, "Modbus: a function, its connections or its idle time is missing");
    if (plant->signal_group_count > 0 && !plant->signal_groups)
        return wrong(&r, "signals: their groups are missing");
    for (unsigned int i = 0; i < plant->signal_group_count; i++) {
        const ect_signal_group_t *g = &plant->signal_groups[i];
        if (!group_place_good(&r, g))
            return false;
        bool ascending = ascends(g);
        for (unsigned int n = 0; n < g->signal_count; n++) {
            if (!signal_good(&(signal_place_t){&r, plant, g, &g->signals[n], ascending}))
                return false;
        }
    }
    return true;
}
