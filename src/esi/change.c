/* SPDX-License-Identifier: MIT */
/*
 * Modules that change while the twin runs (MDP-009, MDP-020). A user inserts and removes them, a master configures
 * them: the dictionary follows F030h, or without idents there the slots. It changes below SAFEOP only, before the next
 * request of the master that is not one of F030h itself, so that a list written element by element is one change.
 */
#include <string.h>

#include "esi/internal.h"
#include "seams/al_status.h"
#include "seams/standard.h"
#include "wire/bytes.h"

/* Reaction to a change above PREOP, signal modules.on_change. */
enum { FALL_TO_PREOP, FALL_TO_SAFEOP, STAY };

/* Part of the instance behind ect_esi_instance_t. From `known` on it outlasts a power cycle: modules stay in their
 * slots.
 */
typedef struct modules {
    const ect_host_t *host;
    uint8_t al_state;
    uint8_t rewritten; /* the master has written F030h: mappings and assignments return to their defaults */
    uint8_t known;     /* `inserted` is set */
    uint8_t strict;
    uint8_t on_change;
    uint32_t inserted[UINT8_MAX]; /* as many as the device has slots */
} modules_t;

enum { AT = (sizeof(ect_esi_instance_t) + sizeof(uint64_t) - 1) / sizeof(uint64_t) * sizeof(uint64_t) };

static const ect_signal_t slot_signals[] = {
    {"module", "ident of the module in the slot, 0 none: 'ectwin list --modules' lists them", NULL, ECT_SIGNAL_U32,
     ECT_SIGNAL_WRITE, 0, 0, UINT32_MAX, 1}};

static const ect_signal_t device_signals[] = {
    ECT_SIGNAL(modules_t, on_change, "on_change", U8, WRITE, FALL_TO_PREOP, STAY, NULL,
               "a module changes in SAFEOP or OP: 0 PREOP, 1 SAFEOP, each with AL status code 0x0070, 2 nothing"),
    ECT_SIGNAL(modules_t, strict, "strict", BOOL, WRITE, 0, 1, NULL,
               "1: F030h takes only the idents of F050h (abort 06090033h); 0: they are compared at SAFEOP"),
};

size_t ect_esi_change_size(const ect_esi_rack_t *rack)
{
    return AT + offsetof(modules_t, inserted) + rack->slots * sizeof(uint32_t);
}

void ect_esi_change_signals(ect_build_t *build, ect_plant_t *plant)
{
    enum { GROUPS = 2 };
    ect_signal_group_t *groups = NULL;
    for (size_t i = 0; i < GROUPS; i++)
        groups = ect_arena_grow(build->arena, groups, i, sizeof *groups);
    groups[0] = (ect_signal_group_t){.prefix = "slot",
                                     .count = (uint16_t)build->rack->slots,
                                     .signal_count = 1,
                                     .offset = (uint32_t)(AT + offsetof(modules_t, inserted)),
                                     .stride = sizeof(uint32_t),
                                     .signals = slot_signals};
    groups[1] = (ect_signal_group_t){.prefix = "modules",
                                     .signal_count = sizeof device_signals / sizeof device_signals[0],
                                     .offset = AT,
                                     .signals = device_signals};
    plant->signal_groups = groups;
    plant->signal_group_count = GROUPS;
}

static const ect_esi_twin_t *twin_of(const void *instance)
{
    return ((const ect_standard_t *)instance)->device->context;
}

static modules_t *modules_of(void *instance)
{
    return (modules_t *)(void *)((uint8_t *)instance + AT);
}

static void write_list(const ect_od_t *od, uint16_t index, uint8_t subindex, uint32_t value)
{
    const ect_object_t *object;
    const ect_entry_t *entry;
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    if (ect_od_lookup(od, index, subindex, &object, &entry) == ECT_OK && ect_od_bytes(entry) <= sizeof bytes)
        (void)ect_od_write(od, entry, 0, bytes, ect_od_bytes(entry));
}

/* F050h and F040h follow the slots. */
static void show(void *instance)
{
    const modules_t *modules = modules_of(instance);
    const ect_esi_twin_t *twin = twin_of(instance);
    const ect_od_t od = ect_device_od(&twin->device, instance);
    for (unsigned int i = 0; i < twin->build.rack->slots; i++) {
        write_list(&od, ECT_ESI_IDENTS_DETECTED, (uint8_t)(i + 1), modules->inserted[i]);
        write_list(&od, ECT_ESI_ADDRESSES_DETECTED, (uint8_t)(i + 1), modules->inserted[i] != 0 ? i + 1 : 0);
    }
}

/* Determines the modules that the dictionary must have. @return whether the present ones differ */
static bool wanted(void *instance, uint32_t *idents)
{
    const ect_build_t *build = &twin_of(instance)->build;
    const ect_od_t od = ect_device_od(&twin_of(instance)->device, instance);
    const uint32_t count = ect_esi_list_at(&od, ECT_ESI_IDENTS, 0);
    bool configured = false;
    for (uint32_t i = 1; i <= count && i <= UINT8_MAX; i++)
        configured |= ect_esi_list_at(&od, ECT_ESI_IDENTS, (uint8_t)i) != 0;
    ECT_ASSERT(build->ident_count == build->rack->slots && build->rack->slots <= UINT8_MAX);
    for (size_t i = 0; i < build->ident_count; i++)
        idents[i] = configured && i < count ? ect_esi_list_at(&od, ECT_ESI_IDENTS, (uint8_t)(i + 1))
                                            : modules_of(instance)->inserted[i];
    return memcmp(idents, build->idents, build->ident_count * sizeof *idents) != 0;
}

static bool is_of_pdos(uint16_t index)
{
    return (index >= ECT_OD_ASSIGNMENT && index < ECT_OD_ASSIGNMENT + ECT_SMS) || ect_od_is_rxpdo(index) ||
           ect_od_is_txpdo(index);
}

/* @return whether an entry keeps its value: a user or a master can change it, and the previous set had it */
static bool stays(const ect_build_t *old, uint16_t index, const ect_build_entry_t *entry)
{
    const ect_build_object_t *object = ect_build_find(old, index);
    const ect_build_entry_t *before = object != NULL ? ect_build_entry(object, entry->subindex) : NULL;
    const unsigned int variable = ECT_ACCESS_WO | ECT_ACCESS_TXPDO | ECT_ACCESS_RXPDO;
    return before != NULL && before->offset == entry->offset && (entry->access & variable) != 0 && !is_of_pdos(index);
}

static void set_default(const ect_od_t *od, const ect_build_entry_t *entry, const ect_entry_t *described)
{
    uint8_t number[8] = {0};
    const uint16_t size = ect_od_bytes(described);
    memset(ect_od_data(od, described), 0, size);
    if (size <= sizeof number) {
        if (entry->initial.length > 0)
            memcpy(number, entry->initial.bytes, entry->initial.length);
        (void)ect_od_write(od, described, 0, number, size);
    } else if (entry->initial.length > 0) {
        (void)ect_od_write(od, described, 0, entry->initial.bytes, (uint16_t)entry->initial.length);
    }
}

/* Replaces assignments and mappings by the defaults of the new set of modules. */
static void set_defaults(const ect_build_t *old, const ect_esi_twin_t *twin, void *instance)
{
    const ect_build_t *build = &twin->build;
    const ect_od_t od = ect_device_od(&twin->device, instance);
    for (size_t i = 0; i < build->object_count; i++) {
        const ect_build_object_t *object = &build->objects[i];
        for (size_t k = 0; k < object->count; k++) {
            if (!object->entries[k].identity && !stays(old, object->index, &object->entries[k]))
                set_default(&od, &object->entries[k], &twin->device.objects[i].entries[k]);
        }
    }
}

/* Updates the dictionary, if the AL state allows it. */
static void settle(void *instance)
{
    uint32_t idents[UINT8_MAX];
    modules_t *modules = modules_of(instance);
    const ect_esi_twin_t *twin = twin_of(instance);
    const bool others = wanted(instance, idents);
    if (modules->al_state >= ECT_STATE_SAFEOP || (!others && modules->rewritten == 0))
        return;
    const ect_esi_twin_t *next = others ? twin->build.rack->find(twin->build.rack, idents) : twin;
    modules->rewritten = 0;
    if (next == NULL)
        return; /* the change to SAFEOP is refused */
    if (next != twin)
        modules->host->describe(modules->host->ctx, &next->device);
    set_defaults(&twin->build, next, instance);
    show(instance);
}

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    const ect_build_t *build = &twin_of(instance)->build;
    modules_t *modules = modules_of(instance);
    (void)now_ns;
    modules->host = host;
    modules->al_state = ECT_STATE_INIT;
    if (modules->known == 0)
        memcpy(modules->inserted, build->idents, build->ident_count * sizeof *build->idents);
    modules->known = 1;
    show(instance);
    settle(instance);
}

static void requested(void *instance, uint16_t index)
{
    if (index != ECT_ESI_IDENTS)
        settle(instance);
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    uint32_t idents[UINT8_MAX];
    const ect_od_t od = ect_device_od(&twin_of(instance)->device, instance);
    (void)now_ns;
    if (from == ECT_STATE_PREOP && to == ECT_STATE_SAFEOP && (!ect_esi_idents_fit(&od) || wanted(instance, idents)))
        return ECT_AL_MODULE_IDENTS;
    modules_of(instance)->al_state = to;
    settle(instance);
    return ECT_AL_NO_ERROR;
}

static ect_reason_t sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    const modules_t *modules = modules_of(instance);
    uint8_t bytes[4] = {0};
    const ect_reason_t reason = ect_esi_idents_write(instance, index, subindex, data, size);
    if (reason != ECT_OK || modules->strict == 0 || index != ECT_ESI_IDENTS || size > sizeof bytes || subindex == 0 ||
        subindex > twin_of(instance)->build.rack->slots)
        return reason;
    memcpy(bytes, data, size);
    const uint32_t ident = ect_load_le32(bytes);
    return ident == 0 || ident == modules->inserted[subindex - 1] ? ECT_OK : ECT_REASON_MODULES;
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    (void)subindex;
    (void)now_ns;
    if (index == ECT_ESI_IDENTS)
        modules_of(instance)->rewritten = 1;
}

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    uint32_t ident;
    (void)now_ns;
    if (signal != slot_signals)
        return NULL;
    memcpy(&ident, value, sizeof ident);
    if (ident == modules_of(instance)->inserted[number - 1])
        return ""; /* no change */
    if (ident == 0 || ect_esi_place_takes(twin_of(instance)->build.model, number - 1u, ident))
        return NULL;
    return "the slot takes no such module: 'ectwin list --modules esi:FILE.xml#TYPE' lists those that it takes";
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    const modules_t *modules = modules_of(instance);
    (void)number;
    (void)now_ns;
    if (signal != slot_signals)
        return;
    show(instance);
    if (modules->al_state >= ECT_STATE_SAFEOP && modules->on_change != STAY)
        modules->host->drop(modules->host->ctx,
                            modules->on_change == FALL_TO_SAFEOP ? ECT_STATE_SAFEOP : ECT_STATE_PREOP,
                            ECT_AL_MODULE_IDENTS);
    settle(instance);
}

static const ect_plant_t *present(const void *instance)
{
    return &twin_of(instance)->plant;
}

void ect_esi_change_set(const ect_build_t *build, ect_device_t *device, ect_plant_t *plant)
{
    device->growth = build->rack->growth;
    device->init = init;
    device->requested = requested;
    device->state_change = state_change;
    device->sdo_write = sdo_write;
    device->sdo_written = sdo_written;
    plant->outside_offset = AT + offsetof(modules_t, known);
    plant->outside_size = ect_esi_change_size(build->rack) - plant->outside_offset;
    plant->present = present;
    plant->signal_write = signal_write;
    plant->signal_written = signal_written;
}
