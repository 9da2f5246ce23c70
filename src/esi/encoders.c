/* SPDX-License-Identifier: MIT */
/* Encoders of CiA 406 over the dictionary of a file. In the instance, encoders and their shafts follow the entries. */
#include <stdio.h>

#include "esi/internal.h"
#include "profiles/encoder/encoder.h"

enum { PROFILE_406 = 406, FIRST_OBJECT = 0x6000, CONTROL_WORD = 0x6040 };

typedef struct sensor {
    unsigned int number; /* from 0, as in ect_encoder_links_find */
    ect_link_t links[ECT_ENCODER_VALUE_COUNT];
} sensor_t;

struct ect_esi_encoders {
    sensor_t sensors[ECT_ENCODERS];
    unsigned int count;
    size_t offset, outside; /* offsets of the encoders and of their shafts in the instance */
    void (*init)(void *instance, const ect_host_t *host, uint64_t now_ns);
    void (*inputs)(void *instance, uint64_t now_ns);
    ect_reason_t (*sdo_write)(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);
};

/* --- functions called by the stack -------------------------------------------------------------------------------- */

static const ect_esi_encoders_t *encoders_of(const void *instance)
{
    const ect_standard_t *standard = instance;
    return ((const ect_esi_twin_t *)standard->device->context)->encoders;
}

static ect_encoder_t *encoder_at(void *instance, unsigned int n)
{
    return (ect_encoder_t *)(void *)((uint8_t *)instance + encoders_of(instance)->offset) + n;
}

/* Iterates over the encoders of an instance. */
#define EACH_ENCODER(e, instance)                                                                                      \
    for (ect_encoder_t *e = encoder_at(instance, 0); e < encoder_at(instance, encoders_of(instance)->count); e++)

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    const ect_esi_encoders_t *encoders = encoders_of(instance);
    ect_encoder_shaft_t *shafts = (void *)((uint8_t *)instance + encoders->outside);
    if (encoders->init != NULL)
        encoders->init(instance, host, now_ns);
    for (unsigned int i = 0; i < encoders->count; i++)
        ect_encoder_init(encoder_at(instance, i), encoders->sensors[i].links, &shafts[i], instance, now_ns);
}

static void advance(void *instance, uint64_t now_ns)
{
    EACH_ENCODER(e, instance)
    ect_encoder_advance(e, now_ns);
}

static void inputs(void *instance, uint64_t now_ns)
{
    if (encoders_of(instance)->inputs != NULL)
        encoders_of(instance)->inputs(instance, now_ns);
    advance(instance, now_ns);
}

static uint64_t tick(void *instance, uint64_t now_ns)
{
    uint64_t next = ECT_NEVER;
    advance(instance, now_ns);
    EACH_ENCODER(e, instance)
    next = ect_earlier(next, ect_encoder_next(e, now_ns));
    return next;
}

/* @return the encoder of an entry, NULL: none; *value */
static ect_encoder_t *find(void *instance, uint16_t index, uint8_t subindex, ect_encoder_value_t *value)
{
    for (unsigned int i = 0; i < encoders_of(instance)->count; i++) {
        if (ect_encoder_value_of(encoders_of(instance)->sensors[i].number, index, subindex, value))
            return encoder_at(instance, i);
    }
    return NULL;
}

static ect_reason_t sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    ect_encoder_value_t value;
    const ect_encoder_t *e = find(instance, index, subindex, &value);
    if (e != NULL && !ect_esi_wire_finite(&e->links[value], data, size))
        return ECT_REASON_RANGE;
    if (e != NULL && size > 0 && size <= sizeof(uint64_t) && !e->links[value].is_real)
        return ect_encoder_check(e, value, ect_esi_wire_number(&e->links[value], data, size));
    const ect_esi_encoders_t *encoders = encoders_of(instance);
    return encoders->sdo_write != NULL ? encoders->sdo_write(instance, index, subindex, data, size) : ECT_OK;
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    ect_encoder_value_t value;
    ect_encoder_t *e = find(instance, index, subindex, &value);
    if (e != NULL)
        ect_encoder_written(e, value, now_ns);
    advance(instance, now_ns);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    (void)signal;
    (void)number;
    (void)value;
    advance(instance, now_ns);
    return NULL;
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    (void)signal;
    (void)number;
    EACH_ENCODER(e, instance)
    ect_encoder_moved(e, now_ns);
}

static bool writes(const ect_esi_twin_t *twin, uint32_t offset)
{
    const ect_esi_encoders_t *encoders = twin->encoders;
    for (unsigned int a = 0; a < encoders->count; a++) {
        for (unsigned int i = 0; i < ECT_ENCODER_VALUE_COUNT; i++) {
            const ect_link_t *link = &encoders->sensors[a].links[i];
            if (ect_encoder_is_actual((ect_encoder_value_t)i) && link->bytes != 0 && link->offset == offset)
                return true;
        }
    }
    return false;
}

static void set_signals(ect_esi_twin_t *twin)
{
    const ect_esi_encoders_t *encoders = twin->encoders;
    const bool linear = ect_encoder_is_linear(encoders->sensors[0].links);
    ect_signal_group_t groups[2];
    groups[0] = (ect_signal_group_t){.prefix = "encoder",
                                     .count = (uint16_t)encoders->count,
                                     .signal_count = ect_encoder_signal_count,
                                     .offset = (uint32_t)encoders->offset,
                                     .stride = sizeof(ect_encoder_t),
                                     .signals = ect_encoder_signals};
    groups[1] = groups[0];
    groups[1].signal_count = ect_encoder_shaft_signal_count;
    groups[1].offset = (uint32_t)encoders->outside;
    groups[1].stride = sizeof(ect_encoder_shaft_t);
    groups[1].signals = linear ? ect_encoder_linear_signals : ect_encoder_rotary_signals;
    ect_esi_profile_signals(twin, groups, 2, writes);
    twin->plant.signal_write = signal_write;
    twin->plant.signal_written = signal_written;
}

/* --- the twin ----------------------------------------------------------------------------------------------------- */

static void find_sensors(const ect_esi_twin_t *twin, ect_esi_encoders_t *encoders)
{
    ect_od_t od = ect_device_od(&twin->device, NULL);
    for (unsigned int n = 0; n < ECT_ENCODERS; n++) {
        sensor_t *sensor = &encoders->sensors[encoders->count];
        sensor->number = n;
        encoders->count += ect_encoder_links_find(&od, n, sensor->links);
    }
}

static void set_functions(ect_esi_twin_t *twin, ect_esi_encoders_t *encoders)
{
    ect_device_t *device = &twin->device;
    encoders->init = device->init;
    encoders->inputs = device->inputs;
    encoders->sdo_write = device->sdo_write;
    device->init = init;
    device->inputs = inputs;
    device->tick = tick;
    device->sdo_write = sdo_write;
    device->sdo_written = sdo_written;
}

static const char *abilities(ect_esi_twin_t *twin, const ect_link_t *links)
{
    static const struct {
        ect_encoder_value_t value[3];
        const char *name;
    } rows[] = {
        {{ECT_ENCODER_POSITION, ECT_ENCODER_WIDE_POSITION, ECT_ENCODER_CHANNEL_POSITION}, "position"},
        {{ECT_ENCODER_PRESET, ECT_ENCODER_WIDE_PRESET, ECT_ENCODER_CHANNEL_PRESET}, "preset"},
        {{ECT_ENCODER_SPEED, ECT_ENCODER_SPEED, ECT_ENCODER_SPEED}, "speed"},
    };
    const char *text = "";
    for (unsigned int i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_encoder_value_t *v = rows[i].value;
        if (links[v[0]].bytes + links[v[1]].bytes + links[v[2]].bytes != 0)
            text = ect_arena_print(&twin->arena, "%s %s", text, rows[i].name);
    }
    return text;
}

static void add_note(ect_esi_twin_t *twin, const ect_esi_encoders_t *encoders)
{
    const char *text = "CiA 406:";
    const char *rest = ect_esi_objects_without(twin, FIRST_OBJECT, ECT_402_AXIS_OBJECTS, ect_encoder_knows);
    for (unsigned int i = 0; i < encoders->count; i++) {
        const ect_link_t *links = encoders->sensors[i].links;
        text =
            ect_arena_print(&twin->arena, "%s%s %s %u%s", text, i > 0 ? ";" : "",
                            ect_encoder_is_linear(links) ? "linear encoder" : "encoder", i + 1, abilities(twin, links));
    }
    ect_esi_profile_note(twin, text, rest);
}

/* A file without ProfileNo is an encoder with a position and the resolution of the position, unless it is a drive. */
static bool has_objects(const ect_esi_twin_t *twin)
{
    ect_od_t od = ect_device_od(&twin->device, NULL);
    ect_link_t links[ECT_ENCODER_VALUE_COUNT];
    return ect_encoder_links_find(&od, 0, links) && ect_od_find(&od, CONTROL_WORD) == NULL &&
           links[ECT_ENCODER_UNITS].bytes + links[ECT_ENCODER_STEP].bytes + links[ECT_ENCODER_RESOLUTION].bytes != 0;
}

bool ect_esi_encoders_wanted(const ect_esi_twin_t *twin, ect_behaviour_t behaviour)
{
    const uint32_t number = twin->build.model->profile & UINT16_MAX;
    if (behaviour != ECT_BEHAVIOUR_BY_FILE)
        return behaviour == ECT_BEHAVIOUR_CIA406;
    return twin->build.rack == NULL && (number == PROFILE_406 || (number == 0 && has_objects(twin)));
}

bool ect_esi_encoders_set(ect_esi_twin_t *twin, ect_behaviour_t behaviour, char *text, size_t room)
{
    ect_esi_encoders_t *encoders = ect_arena_alloc(&twin->arena, sizeof *encoders);
    find_sensors(twin, encoders);
    if (encoders->count == 0 && behaviour == ECT_BEHAVIOUR_BY_FILE) {
        ect_build_note(&twin->build, "ProfileNo is 406, but there is no 6004h, 6008h and 6020h: it has no behaviour");
        return true;
    }
    if (encoders->count == 0 || twin->build.rack != NULL) {
        (void)snprintf(text, room, "%s %s: it cannot be a CiA 406 encoder", twin->device.type_name,
                       encoders->count == 0 ? "has no position 6004h, 6008h or 6020h" : "has modules that change");
        return false;
    }
    ect_esi_profile_place(twin, encoders->count * sizeof(ect_encoder_t), encoders->count * sizeof(ect_encoder_shaft_t),
                          &encoders->offset, &encoders->outside);
    add_note(twin, encoders);
    set_functions(twin, encoders);
    twin->encoders = encoders;
    set_signals(twin);
    return true;
}
