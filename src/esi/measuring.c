/* SPDX-License-Identifier: MIT */
/* Measuring inputs of CiA 404 over the dictionary of a file. In the instance, inputs and sensors follow the entries. */
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"
#include "profiles/measuring/measuring.h"

enum { PROFILE_404 = 404, FIRST_OBJECT = 0x6000, OBJECTS = 0x4000, UNIT = 0x6131 };

typedef struct input {
    unsigned int number; /* from 0, as in ect_measuring_links_find */
    ect_measuring_links_t links;
} input_t;

struct ect_esi_measuring {
    input_t inputs[ECT_MEASURING_INPUTS];
    unsigned int count;
    size_t offset, outside; /* offsets of the inputs and of their sensors in the instance */
    void (*init)(void *instance, const ect_host_t *host, uint64_t now_ns);
    void (*update)(void *instance, uint64_t now_ns);
    ect_reason_t (*sdo_write)(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);
};

/* --- functions called by the stack -------------------------------------------------------------------------------- */

static const ect_esi_measuring_t *measuring_of(const void *instance)
{
    const ect_standard_t *standard = instance;
    return ((const ect_esi_twin_t *)standard->device->context)->measuring;
}

static ect_measuring_t *input_at(void *instance, unsigned int n)
{
    return (ect_measuring_t *)(void *)((uint8_t *)instance + measuring_of(instance)->offset) + n;
}

/* Iterates over the inputs of an instance. */
#define EACH_INPUT(m, instance)                                                                                        \
    for (ect_measuring_t *m = input_at(instance, 0); m < input_at(instance, measuring_of(instance)->count); m++)

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    const ect_esi_measuring_t *measuring = measuring_of(instance);
    const ect_measuring_sensor_t *sensors = (const void *)((uint8_t *)instance + measuring->outside);
    if (measuring->init != NULL)
        measuring->init(instance, host, now_ns);
    for (unsigned int i = 0; i < measuring->count; i++)
        ect_measuring_init(input_at(instance, i), &measuring->inputs[i].links, &sensors[i], instance);
}

static void inputs(void *instance, uint64_t now_ns)
{
    if (measuring_of(instance)->update != NULL)
        measuring_of(instance)->update(instance, now_ns);
    EACH_INPUT(m, instance)
    ect_measuring_update(m);
}

/* @return the input of an entry, NULL: none; *link */
static ect_measuring_t *find(void *instance, uint16_t index, uint8_t subindex, const ect_link_t **link)
{
    for (unsigned int i = 0; i < measuring_of(instance)->count; i++) {
        const input_t *input = &measuring_of(instance)->inputs[i];
        *link = ect_measuring_link(&input->links, input->number, index, subindex);
        if (*link != NULL)
            return input_at(instance, i);
    }
    return NULL;
}

static ect_reason_t sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    const ect_link_t *link;
    const ect_measuring_t *m = find(instance, index, subindex, &link);
    if (m != NULL && !ect_esi_wire_finite(link, data, size))
        return ECT_REASON_RANGE;
    if (m != NULL && size > 0 && size <= sizeof(uint64_t) && !link->is_real)
        return ect_measuring_check(m->links, link, ect_esi_wire_number(link, data, size));
    const ect_esi_measuring_t *measuring = measuring_of(instance);
    return measuring->sdo_write != NULL ? measuring->sdo_write(instance, index, subindex, data, size) : ECT_OK;
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    const ect_link_t *link;
    ect_measuring_t *m = find(instance, index, subindex, &link);
    (void)now_ns;
    if (m != NULL)
        ect_measuring_written(m, link->offset);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

/* Compares offsets only: no entry has an offset within a sensor, because entries follow the standard part of the
 * instance. */
static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    (void)number;
    (void)now_ns;
    EACH_INPUT(m, instance)
    ect_measuring_written(m, signal->offset);
}

static bool writes(const ect_esi_twin_t *twin, uint32_t offset)
{
    for (unsigned int i = 0; i < twin->measuring->count; i++) {
        if (ect_measuring_writes(&twin->measuring->inputs[i].links, offset))
            return true;
    }
    return false;
}

/* @return a copy of the signals whose first one has a unit */
static const ect_signal_t *in_unit(ect_esi_twin_t *twin, const ect_signal_t *signals, size_t count, const char *unit)
{
    ect_signal_t *copy = ect_arena_alloc(&twin->arena, count * sizeof *copy);
    memcpy(copy, signals, count * sizeof *copy);
    copy[0].unit = unit;
    return copy;
}

/* @return the name of the unit that the file has for an input; NULL: none */
static const char *unit_of(ect_esi_twin_t *twin, unsigned int number)
{
    const ect_build_object_t *object = ect_build_find(&twin->build, UNIT);
    const bool is_var = object != NULL && object->code == ECT_OBJECT_VAR;
    const uint32_t unit = ect_build_default(&twin->build, UNIT, is_var ? 0 : (uint8_t)(number + 1));
    return unit != 0 ? ect_build_unit_name(&twin->build, unit) : NULL;
}

/* Two groups for each input, because each has its own unit. */
static void set_signals(ect_esi_twin_t *twin)
{
    const ect_esi_measuring_t *measuring = twin->measuring;
    ect_signal_group_t groups[2 * ECT_MEASURING_INPUTS];
    for (unsigned int i = 0; i < measuring->count; i++) {
        const char *name = unit_of(twin, measuring->inputs[i].number);
        ect_signal_group_t *group = &groups[(size_t)2 * i];
        group[0] = (ect_signal_group_t){
            .prefix = ect_arena_print(&twin->arena, "measure%u", i + 1),
            .signal_count = ECT_MEASURING_SENSOR_SIGNALS,
            .offset = (uint32_t)(measuring->outside + i * sizeof(ect_measuring_sensor_t)),
            .signals = in_unit(twin, ect_measuring_sensor_signals, ECT_MEASURING_SENSOR_SIGNALS, name)};
        group[1] = group[0];
        group[1].signal_count = ECT_MEASURING_SIGNALS;
        group[1].offset = (uint32_t)(measuring->offset + i * sizeof(ect_measuring_t));
        group[1].signals = in_unit(twin, ect_measuring_signals, ECT_MEASURING_SIGNALS, name);
    }
    ect_esi_profile_signals(twin, groups, (uint16_t)(2 * measuring->count), writes);
    twin->plant.signal_written = signal_written;
}

/* --- the twin ----------------------------------------------------------------------------------------------------- */

static void find_inputs(const ect_esi_twin_t *twin, ect_esi_measuring_t *measuring)
{
    ect_od_t od = ect_device_od(&twin->device, NULL);
    for (unsigned int n = 0; n < ECT_MEASURING_INPUTS; n++) {
        input_t *input = &measuring->inputs[measuring->count];
        input->number = n;
        measuring->count += ect_measuring_links_find(&od, n, &input->links);
    }
}

static void set_functions(ect_esi_twin_t *twin)
{
    ect_device_t *device = &twin->device;
    ect_esi_measuring_t *measuring = twin->measuring;
    measuring->init = device->init;
    measuring->update = device->inputs;
    measuring->sdo_write = device->sdo_write;
    device->init = init;
    device->inputs = inputs;
    device->sdo_write = sdo_write;
    device->sdo_written = sdo_written;
}

static void add_note(ect_esi_twin_t *twin)
{
    const char *text = "CiA 404:";
    const char *rest = ect_esi_objects_without(twin, FIRST_OBJECT, OBJECTS, ect_measuring_knows);
    for (unsigned int i = 0; i < twin->measuring->count; i++) {
        const ect_measuring_links_t *links = &twin->measuring->inputs[i].links;
        text =
            ect_arena_print(&twin->arena, "%s%s input %u%s%s%s", text, i > 0 ? ";" : "", i + 1,
                            ect_measuring_scales(links) ? " scaling" : "",
                            links->autozero.bytes != 0 ? " autozero" : "", links->status.bytes != 0 ? " status" : "");
    }
    ect_esi_profile_note(twin, text, rest);
}

bool ect_esi_measuring_wanted(const ect_esi_twin_t *twin, ect_behaviour_t behaviour)
{
    if (behaviour != ECT_BEHAVIOUR_BY_FILE)
        return behaviour == ECT_BEHAVIOUR_CIA404;
    return twin->build.rack == NULL && (twin->build.model->profile & UINT16_MAX) == PROFILE_404;
}

bool ect_esi_measuring_set(ect_esi_twin_t *twin, ect_behaviour_t behaviour, char *text, size_t room)
{
    ect_esi_measuring_t *measuring = ect_arena_alloc(&twin->arena, sizeof *measuring);
    find_inputs(twin, measuring);
    if (measuring->count == 0 && behaviour == ECT_BEHAVIOUR_BY_FILE) {
        ect_build_note(&twin->build, "ProfileNo is 404, but there is no 6130h, 7130h and 9130h: it has no behaviour");
        return true;
    }
    if (measuring->count == 0 || twin->build.rack != NULL) {
        (void)snprintf(text, room, "%s %s: it cannot be a CiA 404 measuring device", twin->device.type_name,
                       measuring->count == 0 ? "has no process value 6130h, 7130h or 9130h"
                                             : "has modules that change");
        return false;
    }
    twin->measuring = measuring;
    ect_esi_profile_place(twin, measuring->count * sizeof(ect_measuring_t),
                          measuring->count * sizeof(ect_measuring_sensor_t), &measuring->offset, &measuring->outside);
    add_note(twin);
    set_functions(twin);
    set_signals(twin);
    return true;
}
