/* SPDX-License-Identifier: MIT */
/*
 * Axes of CiA 402 over the dictionary of a file, or over the IDNs of its SoE drives. In the instance, drives and their
 * surroundings follow the entries; all other parts of the twin remain those of the file.
 */
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"
#include "wire/bytes.h"

enum { PROFILE_402 = 402, FIRST_OBJECT = 0x6000, RESET = 99 };

typedef struct axis {
    unsigned int number; /* the objects of the axis begin at 6000h + 800h * number */
    ect_402_link_t links[ECT_402_VALUE_COUNT];
    bool is_soe; /* without objects */
    ect_esi_dialect_t dialect;
} axis_t;

struct ect_esi_drives {
    axis_t axes[ECT_402_AXES];
    unsigned int count;
    size_t offset, outside;    /* offsets of the drives and of their surroundings in the instance */
    size_t reporters, reports; /* of SoE drives */
    void (*init)(void *instance, const ect_host_t *host, uint64_t now_ns);
    void (*safe_outputs)(void *instance, uint64_t now_ns);
    void (*inputs)(void *instance, uint64_t now_ns);
};

/* --- functions called by the stack -------------------------------------------------------------------------------- */

static const ect_esi_drives_t *drives_of(const void *instance)
{
    const ect_standard_t *standard = instance;
    return ((const ect_esi_twin_t *)standard->device->context)->drives;
}

static ect_402_drive_t *drive_at(void *instance, unsigned int n)
{
    return (ect_402_drive_t *)(void *)((uint8_t *)instance + drives_of(instance)->offset) + n;
}

/* Iterates over the drives of an instance. */
#define EACH_DRIVE(d, instance)                                                                                        \
    for (ect_402_drive_t *d = drive_at(instance, 0); d < drive_at(instance, drives_of(instance)->count); d++)

static const axis_t *axis_of(void *instance, const ect_402_drive_t *d)
{
    return &drives_of(instance)->axes[d - drive_at(instance, 0)];
}

static const ect_soe_t *servo_of(const void *instance)
{
    const ect_standard_t *standard = instance;
    return &((const ect_esi_twin_t *)standard->device->context)->build.soe->servo;
}

static void words_in(void *instance, const axis_t *axis, const ect_402_drive_t *d)
{
    ect_esi_dialect_in(&axis->dialect, instance, d);
    ect_esi_homing_in(&axis->dialect, instance);
}

static void words_out(void *instance, const axis_t *axis, const ect_402_drive_t *d)
{
    ect_esi_dialect_out(&axis->dialect, instance, d);
    ect_esi_homing_out(&axis->dialect, instance, d);
}

static void end_homing(void *instance, const axis_t *axis, const ect_402_drive_t *d)
{
    bool success;
    if (axis->dialect.homes && ect_esi_homing_ends(&axis->dialect, instance, d, &success))
        ect_soe_finish(servo_of(instance), instance, axis->dialect.drive, ECT_ESI_HOMING, success);
}

static void publish(void *instance, ect_402_drive_t *d)
{
    const axis_t *axis = axis_of(instance, d);
    ect_402_drive_publish(d);
    if (!axis->is_soe)
        return;
    end_homing(instance, axis, d);
    words_out(instance, axis, d);
}

/* Ends S-0-0099 after a control word has transferred the reset. */
static void end_reset(void *instance, const axis_t *axis, const ect_402_drive_t *d)
{
    if (ect_esi_dialect_ends(&axis->dialect, instance))
        ect_soe_finish(servo_of(instance), instance, axis->dialect.drive, RESET, d->error_code == 0);
}

/* Applies two control words, without and with the reset, because the reset needs an edge. */
static void reset_below_op(void *instance, const axis_t *axis, ect_402_drive_t *d, uint64_t now_ns)
{
    for (unsigned int edge = 0; edge < 2; edge++) {
        ect_esi_dialect_reset(&axis->dialect, instance, edge != 0);
        words_in(instance, axis, d);
        ect_402_drive_written(d, ECT_402_V_CONTROL, now_ns);
    }
    ect_esi_dialect_reset(&axis->dialect, instance, false);
    publish(instance, d);
}

static uint16_t command_reset(void *instance, const axis_t *axis, ect_402_drive_t *d, bool start, uint64_t now_ns)
{
    ect_esi_dialect_reset(&axis->dialect, instance, start);
    if (!start || d->al == ECT_STATE_OP)
        return ECT_SOE_OK;
    reset_below_op(instance, axis, d, now_ns);
    ect_soe_finish(servo_of(instance), instance, axis->dialect.drive, RESET, d->error_code == 0);
    return ECT_SOE_OK;
}

static uint16_t command_homing(void *instance, const axis_t *axis, ect_402_drive_t *d, bool start, uint64_t now_ns)
{
    bool runs = false;
    ect_402_drive_advance(d, now_ns);
    if (!start) {
        ect_esi_homing_cancel(&axis->dialect, instance);
        return ECT_SOE_OK;
    }
    const uint16_t code = ect_esi_homing_start(&axis->dialect, instance, d, &runs);
    if (code == ECT_SOE_OK && !runs)
        ect_soe_finish(servo_of(instance), instance, axis->dialect.drive, ECT_ESI_HOMING, false);
    return code;
}

static uint16_t soe_command(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn, bool start,
                            uint64_t now_ns)
{
    EACH_DRIVE(d, instance)
    {
        const axis_t *axis = axis_of(instance, d);
        if (!axis->is_soe || axis->dialect.drive != drive)
            continue;
        if (idn->idn == RESET)
            return command_reset(instance, axis, d, start, now_ns);
        if (idn->idn == ECT_ESI_HOMING)
            return command_homing(instance, axis, d, start, now_ns);
    }
    ect_soe_finish(soe, instance, drive, idn->idn, true);
    return ECT_SOE_OK;
}

static const ect_esi_reports_t *reports_of(const void *instance)
{
    return (const void *)((const uint8_t *)instance + drives_of(instance)->reports);
}

static const ect_host_t *host_of(void *instance, unsigned int n, const ect_host_t *host)
{
    const axis_t *axis = &drives_of(instance)->axes[n];
    ect_esi_reporter_t *reporters = (void *)((uint8_t *)instance + drives_of(instance)->reporters);
    return axis->is_soe ? ect_esi_reporter(&reporters[n], servo_of(instance), instance, axis->dialect.drive, host)
                        : host;
}

/* Without 608Fh and 6092h the increments of a turn are unknown; a file's window of following errors is of their size.
 */
static void guess_resolution(const ect_402_link_t *links, const void *instance, ect_402_surroundings_t *around)
{
    enum { WINDOWS = 100, USUAL = 1 << 20 };
    const ect_402_link_t *window = &links[ECT_402_V_ERROR_WINDOW];
    const int64_t counts = window->given ? ect_402_load(instance, window) : 0;
    const bool known = links[ECT_402_V_INCREMENTS].bytes != 0 || links[ECT_402_V_FEED].bytes != 0;
    if (!around->known && !known && counts > 0 && counts <= USUAL / WINDOWS)
        around->resolution = (uint32_t)counts * WINDOWS;
}

enum { METHODS = 0x60E3 };

/* Adds the methods of 60E3h. */
static uint64_t methods_of(void *instance, const axis_t *axis)
{
    enum { MOST = 64 };
    ect_od_t od = ect_device_od(((const ect_standard_t *)instance)->device, NULL);
    uint64_t methods = 0;
    for (unsigned int n = 1; n < MOST && !axis->is_soe; n++) {
        const ect_link_t link = ect_link_to(&od, (uint16_t)(METHODS + axis->number * ECT_402_AXIS_OBJECTS), (uint8_t)n);
        const int64_t method = ect_link_load(instance, &link);
        if (method > 0 && method < MOST)
            methods |= UINT64_C(1) << method;
    }
    return methods;
}

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    const ect_esi_drives_t *drives = drives_of(instance);
    ect_402_surroundings_t *around = (void *)((uint8_t *)instance + drives->outside);
    if (drives->init != NULL)
        drives->init(instance, host, now_ns);
    if (drives->axes[0].is_soe)
        ect_esi_report(servo_of(instance), instance, reports_of(instance));
    for (unsigned int i = 0; i < drives->count; i++) {
        guess_resolution(drives->axes[i].links, instance, &around[i]);
        ect_402_drive_init(drive_at(instance, i), drives->axes[i].links, &around[i], instance,
                           host_of(instance, i, host), now_ns);
    }
    EACH_DRIVE(d, instance)
    {
        const axis_t *axis = axis_of(instance, d);
        d->config.cyclic_halts = axis->is_soe;
        d->methods = methods_of(instance, axis);
        if (axis->is_soe)
            words_out(instance, axis, d);
    }
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    const uint16_t refused = ect_esi_idents_state(instance, from, to);
    if (refused != ECT_AL_NO_ERROR)
        return refused;
    EACH_DRIVE(d, instance)
    {
        ect_402_drive_advance(d, now_ns);
        if (to == ECT_STATE_OP)
            ect_402_drive_enter_op(d, now_ns);
        else if (from == ECT_STATE_OP)
            ect_402_drive_leave_op(d, now_ns);
        if (to != ECT_STATE_OP)
            ect_402_drive_below_op(d, to);
        publish(instance, d);
    }
    return ECT_AL_NO_ERROR;
}

static void cyclic(void *instance, uint8_t events, uint64_t now_ns)
{
    if ((events & ECT_CYCLIC_SYNC0) == 0)
        return;
    EACH_DRIVE(d, instance)
    {
        ect_402_drive_advance(d, now_ns);
        ect_402_drive_sync0(d, now_ns);
        publish(instance, d);
    }
}

static void outputs(void *instance, uint64_t now_ns)
{
    EACH_DRIVE(d, instance)
    {
        ect_402_drive_advance(d, now_ns);
        const axis_t *axis = axis_of(instance, d);
        if (axis->is_soe)
            words_in(instance, axis, d);
        ect_402_drive_outputs(d, now_ns);
        if (axis->is_soe)
            end_reset(instance, axis, d);
        publish(instance, d);
    }
}

static void safe_outputs(void *instance, uint64_t now_ns)
{
    EACH_DRIVE(d, instance)
    ect_402_drive_advance(d, now_ns);
    drives_of(instance)->safe_outputs(instance, now_ns);
    EACH_DRIVE(d, instance)
    {
        const axis_t *axis = axis_of(instance, d);
        if (axis->is_soe)
            words_in(instance, axis, d);
        ect_402_drive_leave_op(d, now_ns);
    }
}

static void inputs(void *instance, uint64_t now_ns)
{
    if (drives_of(instance)->inputs != NULL)
        drives_of(instance)->inputs(instance, now_ns);
    EACH_DRIVE(d, instance)
    {
        ect_402_drive_advance(d, now_ns);
        publish(instance, d);
    }
}

static uint64_t tick(void *instance, uint64_t now_ns)
{
    uint64_t next = ECT_NEVER;
    EACH_DRIVE(d, instance)
    {
        ect_402_drive_advance(d, now_ns);
        publish(instance, d);
        next = ect_earlier(next, ect_402_drive_next(d));
    }
    return next;
}

/* @return the drive of an entry, NULL: none; *value */
static ect_402_drive_t *find(void *instance, uint16_t index, uint8_t subindex, ect_402_value_t *value)
{
    const ect_esi_drives_t *drives = drives_of(instance);
    unsigned int number = (unsigned int)(index - FIRST_OBJECT) / ECT_402_AXIS_OBJECTS;
    for (unsigned int i = 0; index >= FIRST_OBJECT && i < drives->count; i++) {
        uint16_t first = (uint16_t)(index - number * ECT_402_AXIS_OBJECTS);
        if (!drives->axes[i].is_soe && drives->axes[i].number == number && ect_402_value_of(first, subindex, value))
            return drive_at(instance, i);
    }
    return NULL;
}

static ect_reason_t sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    ect_402_value_t value;
    const ect_402_drive_t *d = find(instance, index, subindex, &value);
    if (d == NULL)
        return ect_esi_idents_write(instance, index, subindex, data, size);
    if (size == 0 || size > 8)
        return ECT_OK;
    if (d->links[value].is_real)
        return ect_esi_wire_finite(&d->links[value], data, size) ? ECT_OK : ECT_REASON_RANGE;
    return ect_402_drive_check(d, value, ect_esi_wire_number(&d->links[value], data, size));
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    ect_402_value_t value;
    ect_402_drive_t *d = find(instance, index, subindex, &value);
    if (d != NULL)
        ect_402_drive_written(d, value, now_ns);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static bool is_over_drive(const ect_signal_t *signal)
{
    return signal >= ect_402_drive_signals && signal < ect_402_drive_signals + ect_402_drive_signal_count;
}

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    EACH_DRIVE(d, instance)
    ect_402_drive_advance(d, now_ns);
    return is_over_drive(signal) ? ect_402_drive_signal_write(drive_at(instance, number - 1u), signal, value) : NULL;
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    (void)signal;
    (void)number;
    (void)now_ns;
    if (drives_of(instance)->axes[0].is_soe)
        ect_esi_report(servo_of(instance), instance, reports_of(instance));
    EACH_DRIVE(d, instance)
    ect_402_drive_touched(d);
}

/* --- the twin ----------------------------------------------------------------------------------------------------- */

static void find_soe_axes(const ect_esi_twin_t *twin, ect_esi_drives_t *drives)
{
    const ect_build_soe_t *soe = twin->build.soe;
    for (uint8_t n = 0; soe != NULL && soe->served && n < soe->drives && drives->count < ECT_402_AXES; n++) {
        axis_t *axis = &drives->axes[drives->count];
        axis->is_soe = ect_esi_dialect_find(&twin->build, n, &axis->dialect);
        axis->dialect.homes = ect_esi_homing_find(&twin->build, &axis->dialect);
        drives->count += axis->is_soe;
    }
}

static void find_axes(const ect_esi_twin_t *twin, ect_esi_drives_t *drives)
{
    ect_od_t od = ect_device_od(&twin->device, NULL);
    for (unsigned int n = 0; n < ECT_402_AXES; n++) {
        axis_t *axis = &drives->axes[drives->count];
        axis->number = n;
        if (ect_402_links_find(&od, n, axis->links))
            drives->count++;
    }
    if (drives->count == 0)
        find_soe_axes(twin, drives);
}

/* Distinguishes a default of 0 in the file from a missing one. */
static void find_defaults(const ect_build_t *build, axis_t *axis)
{
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++) {
        const ect_402_object_t *object = ect_402_object((ect_402_value_t)i);
        const ect_build_object_t *found =
            ect_build_find(build, (uint16_t)(object->index + axis->number * ECT_402_AXIS_OBJECTS));
        const ect_build_entry_t *entry = found != NULL ? ect_build_entry(found, object->subindex) : NULL;
        axis->links[i].given = entry != NULL && entry->initial.bytes != NULL;
    }
}

/* Places the words of SoE drives, to which their links lead. @return the end */
static size_t place_words(const ect_esi_twin_t *twin, ect_esi_drives_t *drives, size_t at)
{
    for (unsigned int i = 0; i < drives->count; i++) {
        axis_t *axis = &drives->axes[i];
        if (!axis->is_soe)
            continue;
        at = ect_esi_aligned(at);
        ect_esi_dialect_links(&twin->build, &axis->dialect, at, axis->links);
        ect_esi_homing_links(&twin->build, &axis->dialect, axis->links);
        at += sizeof(ect_esi_words_t);
    }
    return at;
}

static void lay_out(ect_esi_twin_t *twin, ect_esi_drives_t *drives)
{
    drives->offset = ect_esi_aligned(place_words(twin, drives, twin->device.instance_size));
    const bool is_soe = drives->axes[0].is_soe;
    drives->reporters = ect_esi_aligned(drives->offset + drives->count * sizeof(ect_402_drive_t));
    drives->outside = ect_esi_aligned(drives->reporters + (is_soe ? drives->count * sizeof(ect_esi_reporter_t) : 0));
    drives->reports = drives->outside + drives->count * sizeof(ect_402_surroundings_t);
    twin->plant.outside_offset = drives->outside;
    twin->plant.outside_size = drives->reports - drives->outside + (is_soe ? sizeof(ect_esi_reports_t) : 0);
    twin->device.instance_size = drives->outside + twin->plant.outside_size;
}

static bool writes(const ect_esi_twin_t *twin, uint32_t offset)
{
    const ect_esi_drives_t *drives = twin->drives;
    for (unsigned int a = 0; a < drives->count; a++) {
        for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++) {
            const ect_402_link_t *link = &drives->axes[a].links[i];
            bool actual = ect_402_object((ect_402_value_t)i)->kind == ECT_402_ACTUAL;
            if (actual && link->bytes != 0 && link->offset == offset)
                return true;
        }
        if (drives->axes[a].is_soe && ect_esi_dialect_writes(&drives->axes[a].dialect, offset))
            return true;
    }
    return false;
}

static void set_signals(ect_esi_twin_t *twin)
{
    ect_plant_t *plant = &twin->plant;
    const ect_esi_drives_t *drives = twin->drives;
    ect_signal_group_t groups[3];
    groups[0] = (ect_signal_group_t){.prefix = "axis",
                                     .count = (uint16_t)drives->count,
                                     .signal_count = ect_402_drive_signal_count,
                                     .offset = (uint32_t)drives->offset,
                                     .stride = sizeof(ect_402_drive_t),
                                     .signals = ect_402_drive_signals};
    groups[1] = groups[0];
    groups[1].signal_count = ect_402_around_signal_count;
    groups[1].offset = (uint32_t)drives->outside;
    groups[1].stride = sizeof(ect_402_surroundings_t);
    groups[1].signals = ect_402_around_signals;
    if (drives->axes[0].is_soe)
        groups[2] = (ect_signal_group_t){.prefix = "soe",
                                         .signal_count = ect_esi_report_signal_count,
                                         .offset = (uint32_t)drives->reports,
                                         .signals = ect_esi_report_signals};
    ect_esi_profile_signals(twin, groups, drives->axes[0].is_soe ? 3 : 2, writes);
    plant->signal_write = signal_write;
    plant->signal_written = signal_written;
    plant->signal_describe = ect_402_drive_signal_describe;
}

static void set_functions(ect_esi_twin_t *twin, ect_esi_drives_t *drives)
{
    ect_device_t *device = &twin->device;
    drives->safe_outputs = device->safe_outputs;
    drives->inputs = device->inputs;
    drives->init = device->init;
    if (twin->build.soe != NULL)
        twin->build.soe->servo.command = soe_command;
    ect_build_service(&twin->build, device, &ect_service_rhythm);
    device->init = init;
    device->state_change = state_change;
    device->cyclic = cyclic;
    device->outputs = outputs;
    device->safe_outputs = safe_outputs;
    device->inputs = inputs;
    device->tick = tick;
    device->sdo_write = sdo_write;
    device->sdo_written = sdo_written;
}

/* --- the note ----------------------------------------------------------------------------------------------------- */

static const char *modes_of(ect_esi_twin_t *twin, const axis_t *axis)
{
    static const char *const names[] = {"pp", NULL, "pv", "tq", NULL, "hm", "ip", "csp", "csv", "cst"};
    ect_od_t od = ect_device_od(&twin->device, NULL);
    const ect_object_t *object;
    const ect_entry_t *entry = NULL;
    uint32_t modes = ect_402_modes_of(axis->links);
    (void)ect_od_lookup(&od, (uint16_t)(0x6502 + axis->number * ECT_402_AXIS_OBJECTS), 0, &object, &entry);
    if (entry != NULL && (entry->value & modes) != 0)
        modes &= entry->value;
    const char *text = "";
    for (unsigned int i = 0; i < sizeof names / sizeof names[0]; i++) {
        if ((modes >> i & 1u) != 0 && names[i] != NULL)
            text = ect_arena_print(&twin->arena, "%s %s", text, names[i]);
    }
    return *text != '\0' ? text : " no mode";
}

static bool is_simulated(uint16_t index)
{
    ect_402_value_t value;
    for (unsigned int subindex = 0; subindex < 3; subindex++) {
        if (ect_402_value_of(index, (uint8_t)subindex, &value))
            return true;
    }
    return index == METHODS;
}

/* Lists the objects in the profile's range without a behaviour. */
static const char *rest_of(ect_esi_twin_t *twin, const axis_t *axis)
{
    return axis->is_soe ? ""
                        : ect_esi_objects_without(twin, FIRST_OBJECT + axis->number * ECT_402_AXIS_OBJECTS,
                                                  ECT_402_AXIS_OBJECTS, is_simulated);
}

static void add_note(ect_esi_twin_t *twin, const ect_esi_drives_t *drives)
{
    const char *text = drives->axes[0].is_soe ? "S-0-0134, S-0-0135:" : "CiA 402:";
    const char *rest = "";
    for (unsigned int i = 0; i < drives->count; i++) {
        text = ect_arena_print(&twin->arena, "%s%s axis %u%s", text, i > 0 ? ";" : "", i + 1,
                               modes_of(twin, &drives->axes[i]));
        rest = ect_arena_print(&twin->arena, "%s%s", rest, rest_of(twin, &drives->axes[i]));
    }
    ect_esi_profile_note(twin, text, rest);
}

bool ect_esi_twin_behave(ect_esi_twin_t *twin, ect_behaviour_t behaviour, char *text, size_t room)
{
    ECT_ASSERT(twin->drives == NULL && twin->encoders == NULL && twin->measuring == NULL);
    if (behaviour == ECT_BEHAVIOUR_NONE)
        return true;
    if (ect_esi_encoders_wanted(twin, behaviour))
        return ect_esi_encoders_set(twin, behaviour, text, room);
    if (ect_esi_measuring_wanted(twin, behaviour))
        return ect_esi_measuring_set(twin, behaviour, text, room);
    ect_esi_drives_t *drives = ect_arena_alloc(&twin->arena, sizeof *drives);
    find_axes(twin, drives);
    if (drives->count == 0 && behaviour == ECT_BEHAVIOUR_CIA402) {
        (void)snprintf(text, room, "%s has no control word 6040h and status word 6041h: it cannot be a CiA 402 drive",
                       twin->device.type_name);
        return false;
    }
    if (drives->count == 0 && (twin->build.model->profile & UINT16_MAX) == PROFILE_402)
        ect_build_note(&twin->build, "ProfileNo is 402, but there is no 6040h and 6041h: it has no behaviour");
    if (drives->count == 0)
        return true;
    for (unsigned int i = 0; i < drives->count; i++) {
        if (!drives->axes[i].is_soe)
            find_defaults(&twin->build, &drives->axes[i]);
    }
    lay_out(twin, drives);
    add_note(twin, drives);
    set_functions(twin, drives);
    twin->drives = drives;
    set_signals(twin);
    return true;
}
