/* SPDX-License-Identifier: MIT */
/* The memory that a description needs, for programs that determine it at run time. */
#include "seams/standard.h"
#include "slave/internal.h"

static bool is_constant(const ect_object_t *object)
{
    for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
        if (e->data)
            return false;
    }
    return true;
}

/* Whether no assignment and no mapping of a SyncManager can change. */
static bool mapping_is_constant(const ect_device_t *device, unsigned int sm)
{
    const ect_od_t od = ect_device_od(device, NULL);
    const ect_object_t *assignment = ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
    bool constant = !assignment || is_constant(assignment);
    for (uint32_t n = 1; n <= ect_od_element(assignment, 0) && constant; n++) {
        const ect_object_t *pdo = ect_od_find(&od, (uint16_t)ect_od_element(assignment, n));
        constant = !pdo || is_constant(pdo);
    }
    return constant;
}

/* Bits of the shortest entry that can be mapped in a direction, at least one. */
static size_t shortest(const ect_device_t *device, uint16_t access)
{
    size_t bits = SIZE_MAX;
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
            if ((e->access & access) != 0 && e->bit_length > 0 && e->bit_length < bits)
                bits = e->bit_length;
        }
    }
    return bits;
}

/* A mapping may contain part of an entry: the fewest bits that a default mapping contains of one, or `bits` if less. */
static size_t shortest_mapped(const ect_object_t *pdo, size_t bits)
{
    for (uint32_t n = 1; n <= ect_od_element(pdo, 0); n++) {
        uint32_t mapped = ect_od_element(pdo, n);
        if (mapped >> 16 != 0 && (mapped & 0xFF) != 0 && (mapped & 0xFF) < bits)
            bits = mapped & 0xFF;
    }
    return bits;
}

/* Runs if every PDO of that direction is assigned and each of its entries is a run; at most those that the room
 * allows. */
static size_t most_runs(const ect_device_t *device, unsigned int sm)
{
    bool outputs = device->sm[sm].type == ECT_SM_OUTPUTS;
    size_t bits = shortest(device, outputs ? ECT_ACCESS_RXPDO : ECT_ACCESS_TXPDO);
    size_t runs = 0;
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        if (!(outputs ? ect_od_is_rxpdo(object->index) : ect_od_is_txpdo(object->index)))
            continue;
        runs += (size_t)(ect_od_last(object) - object->entries);
        bits = shortest_mapped(object, bits);
    }
    size_t room = 8u * ect_sm_room(device, sm) / bits;
    return runs < room ? runs : room;
}

/* The longest value that a master may write. */
static size_t longest_value(const ect_device_t *device)
{
    size_t longest = 0;
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
            if ((e->access & ECT_ACCESS_WO) != 0 && ect_od_bytes(e) > longest)
                longest = ect_od_bytes(e);
        }
    }
    return longest;
}

ect_slave_memory_t ect_slave_memory(const ect_device_t *device)
{
    ect_slave_memory_t need = {
        .instance = device->instance_size,
        .staging = device->mailbox_protocols != 0 ? longest_value(device) : 0,
        .buffer = device->buffer_size,
    };
    if (device->mailbox_protocols != 0 && device->sm_count >= 2)
        need.mailbox = ect_mailbox_sm_room(device, 0) + 2u * ect_mailbox_sm_room(device, 1);
    for (unsigned int n = 0; n < device->sm_count; n++) {
        if (!ect_device_sm_is_process(device, n))
            continue;
        size_t bytes = ect_sm_room(device, n);
        need.process_data = bytes > need.process_data ? bytes : need.process_data;
        need.runs += mapping_is_constant(device, n) ? ect_pdo_count_runs(device, n) : most_runs(device, n);
    }
    const ect_growth_t *growth = &device->growth;
    need.process_data = growth->image > need.process_data ? growth->image : need.process_data;
    need.runs = growth->runs > need.runs ? growth->runs : need.runs;
    need.staging = growth->value > need.staging ? growth->value : need.staging;
    return need;
}

/* Every slave has an instance and a process image, even an empty one. */
static size_t some(size_t bytes)
{
    return bytes > 0 ? bytes : 1;
}

/* A member that is not needed is no failure. */
static void *take_one(void *(*take)(void *ctx, size_t bytes), void *ctx, size_t bytes, bool *all)
{
    void *taken = bytes > 0 ? take(ctx, bytes) : NULL;
    *all &= taken || bytes == 0;
    return taken;
}

bool ect_slave_take(ect_slave_config_t *config, void *(*take)(void *ctx, size_t bytes), void *ctx)
{
    ect_slave_memory_t need = ect_slave_memory(config->device);
    bool all = true;
    config->instance = take_one(take, ctx, some(need.instance), &all);
    config->mailbox = take_one(take, ctx, need.mailbox, &all);
    config->process_data = take_one(take, ctx, some(need.process_data), &all);
    config->process_size = (uint16_t)need.process_data;
    config->runs = take_one(take, ctx, need.runs * sizeof(ect_pdo_run_t), &all);
    config->run_count = (uint16_t)need.runs;
    config->staging = take_one(take, ctx, need.staging, &all);
    config->staging_size = (uint16_t)need.staging;
    return all;
}
