/* SPDX-License-Identifier: MIT */
#include "bus/chain.h"

#include <stdlib.h>
#include <string.h>

#include "bus/lamps.h"
#include "ports/virtual/virtual.h"
#include "sii/sii.h"
#include "wire/bytes.h"
#include "wire/registers.h"

typedef struct twin {
    ect_twin_config_t config;
    ect_esc_t esc;
    ect_pdi_t pdi;
    ect_slave_t slave;
    bool linked;          /* the one before it has its cable in here */
    uint32_t seen;        /* ESC activity that the slave has dealt with */
    uint64_t deadline_ns; /* of the slave or of the ESC, whichever is first */
    uint64_t last_frame_ns;
    ect_lamps_t *lamps;
    void *memory[7]; /* everything that was allocated for it */
    size_t blocks;
} twin_t;

struct ect_chain {
    size_t count;
    twin_t twins[];
};

static void *allocate(twin_t *twin, size_t size)
{
    void *block = calloc(1, size > 0 ? size : 1);
    if (block)
        twin->memory[twin->blocks++] = block;
    return block;
}

static bool make_esc(twin_t *twin, uint8_t open_ports)
{
    const ect_twin_config_t *c = &twin->config;
    const ect_esc_personality_t *personality = ect_esc_personality(c->device->esc);
    if (!personality)
        return false;
    uint8_t *memory = allocate(twin, ECT_ESC_MEMORY_SIZE(personality->ram_kb));
    uint8_t *sii = allocate(twin, c->device->sii_size);
    if (!memory || !sii || ect_sii_write(c->device, &c->identity, c->alias, sii, c->device->sii_size) < 0)
        return false;
    twin->esc.config = (ect_esc_config_t){
        .personality = personality,
        .memory = memory,
        .sii = sii,
        .sii_size = c->device->sii_size,
        .open_ports = open_ports,
        .keep_source_mac = c->keep_source_mac,
    };
    return true;
}

static bool make_slave(twin_t *twin)
{
    ect_slave_memory_t need = ect_slave_memory(twin->config.device);
    if (!ect_slave_check(twin->config.device))
        return false;
    twin->pdi = ect_virtual_pdi(&twin->esc);
    twin->slave.config = (ect_slave_config_t){
        .device = twin->config.device,
        .pdi = &twin->pdi,
        .identity = &twin->config.identity,
        .storage = twin->config.storage,
        .instance = allocate(twin, need.instance),
        .mailbox = allocate(twin, need.mailbox),
        .process_data = allocate(twin, need.process_data),
        .runs = allocate(twin, need.runs * sizeof(ect_pdo_run_t)),
        .run_count = (uint16_t)need.runs,
    };
    return true;
}

/* What the device remembers goes, what stands outside it stays. */
static void power_off(const twin_t *twin, uint8_t *instance)
{
    const ect_plant_t *plant = twin->config.plant;
    size_t size = twin->config.device->instance_size;
    size_t from = plant && plant->outside_size > 0 ? plant->outside_offset : size;
    size_t to = plant && plant->outside_size > 0 ? from + plant->outside_size : size;
    memset(instance, 0, from);
    memset(instance + to, 0, size - to);
}

/* For the first time or again: what controller, stack and device are made of stays, all else starts anew. */
static bool power_on(twin_t *twin, uint64_t now_ns)
{
    const ect_plant_t *plant = twin->config.plant;
    ect_esc_config_t esc = twin->esc.config;
    ect_slave_config_t slave = twin->slave.config;
    slave.device_id = twin->config.alias;
    if (!slave.instance || ect_esc_init(&twin->esc, &esc, now_ns) != 0)
        return false;
    uint16_t switches = plant && plant->station_alias ? plant->station_alias(slave.instance) : 0;
    if (switches != 0) {
        uint8_t alias[2];
        ect_store_le16(alias, switches);
        (void)twin->pdi.write(twin->pdi.ctx, ECT_REG_STATION_ALIAS, alias, sizeof alias);
        slave.device_id = switches;
    }
    power_off(twin, slave.instance);
    twin->deadline_ns = now_ns;
    return ect_slave_init(&twin->slave, &slave, now_ns) == 0;
}

ect_twin_config_t ect_twin_default(const ect_device_t *device, const ect_plant_t *plant)
{
    return (ect_twin_config_t){.device = device, .plant = plant, .identity = device->identity};
}

ect_chain_t *ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns)
{
    enum { PORT_IN = 1, PORT_OUT = 2 };
    ect_chain_t *chain = calloc(1, sizeof *chain + count * sizeof chain->twins[0]);
    if (!chain)
        return NULL;
    chain->count = count;
    for (size_t i = 0; i < count; i++) {
        uint8_t open_ports = i + 1 < count ? PORT_IN | PORT_OUT : PORT_IN;
        twin_t *twin = &chain->twins[i];
        twin->config = twins[i];
        twin->linked = true;
        twin->lamps = allocate(twin, sizeof *twin->lamps);
        if (!twin->lamps || !make_esc(twin, open_ports) || !make_slave(twin) || !power_on(twin, now_ns)) {
            ect_chain_free(chain);
            return NULL;
        }
    }
    return chain;
}

void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t i = 0; i < chain->count; i++)
        (void)power_on(&chain->twins[i], now_ns); /* what was possible once is again */
}

void ect_chain_free(ect_chain_t *chain)
{
    if (!chain)
        return;
    for (size_t i = 0; i < chain->count; i++) {
        for (size_t b = 0; b < chain->twins[i].blocks; b++)
            free(chain->twins[i].memory[b]);
    }
    free(chain);
}

bool ect_chain_process(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns)
{
    for (size_t i = 0; i < chain->count; i++) {
        ect_esc_t *esc = &chain->twins[i].esc;
        chain->twins[i].last_frame_ns = now_ns;
        if (i == 0 && chain->twins[i].slave.off_bus)
            return false; /* the cable ends in a dead socket */
        if (ect_esc_process(esc, frame, length, now_ns) != ECT_FRAME_FORWARD)
            return false;
        if (i + 1 < chain->count && !ect_esc_port_open(esc, 1))
            break; /* nothing is plugged in there, or the master closed the port: the frame turns back */
    }
    return true;
}

/* A twin that left the bus takes the link of the one before it away. */
static void follow_links(ect_chain_t *chain, size_t i)
{
    bool link = !chain->twins[i].slave.off_bus;
    if (i > 0 && chain->twins[i].linked != link)
        ect_esc_set_link(&chain->twins[i - 1].esc, 1, link);
    chain->twins[i].linked = link;
}

static void poll_twin(twin_t *twin, uint64_t now_ns)
{
    uint64_t esc_ns = ect_esc_tick(&twin->esc, now_ns);
    twin->seen = ect_esc_activity(&twin->esc);
    uint64_t slave_ns = ect_slave_poll(&twin->slave, now_ns);
    twin->deadline_ns = esc_ns < slave_ns ? esc_ns : slave_ns;
    if (twin->slave.restart)
        (void)power_on(twin, now_ns);
}

uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns)
{
    uint64_t next = ECT_NEVER;
    for (size_t i = 0; i < chain->count; i++) {
        twin_t *twin = &chain->twins[i];
        if (twin->seen != ect_esc_activity(&twin->esc) || now_ns >= twin->deadline_ns)
            poll_twin(twin, now_ns);
        follow_links(chain, i);
        bool out_link = i + 1 < chain->count && !chain->twins[i + 1].slave.off_bus;
        uint64_t lamps_ns = ect_lamps_update(twin->lamps, &twin->slave, out_link, twin->last_frame_ns, now_ns);
        next = twin->deadline_ns < next ? twin->deadline_ns : next;
        next = lamps_ns < next ? lamps_ns : next;
    }
    return next;
}

size_t ect_chain_count(const ect_chain_t *chain)
{
    return chain->count;
}

size_t ect_chain_signals(const ect_chain_t *chain, size_t position, const char *pattern,
                         void (*visit)(void *ctx, const ect_signal_ref_t *ref), void *ctx)
{
    const twin_t *twin = &chain->twins[position];
    return ect_signals_visit(twin->config.plant, twin->slave.config.instance, pattern, visit, ctx) +
           ect_signals_visit(&ect_lamps_plant, twin->lamps, pattern, visit, ctx);
}

bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref)
{
    const twin_t *twin = &chain->twins[position];
    return ect_signal_find(twin->config.plant, twin->slave.config.instance, name, ref) ||
           ect_signal_find(&ect_lamps_plant, twin->lamps, name, ref);
}

void ect_chain_wake(ect_chain_t *chain, size_t position)
{
    ect_slave_wake(&chain->twins[position].slave);
    chain->twins[position].deadline_ns = 0;
}

const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position)
{
    return &chain->twins[position].slave;
}

ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position)
{
    return &chain->twins[position].esc;
}
