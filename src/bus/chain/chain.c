/* SPDX-License-Identifier: MIT */
#include "bus/chain/chain.h"

#include <stdlib.h>
#include <string.h>

#include "bus/chain/bits.h"
#include "bus/chain/deadlines.h"
#include "bus/chain/fast.h"
#include "bus/chain/lamps.h"
#include "bus/chain/topology.h"
#include "bus/chain/wiring.h"
#include "esc/route.h"
#include "ports/virtual/virtual.h"
#include "sii/sii.h"
#include "slave/indicator.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* From one time that an ESC asks for to the next one. Cycles in use go down to 31.25 us. */
enum { REST_NS = 25000 };

/* Two PHYs, and a metre of cable. */
enum { PHYS_NS = 400, METRE_NS = 5 };

typedef struct twin {
    ect_twin_config_t config;
    ect_esc_t esc;
    ect_pdi_t pdi;
    ect_slave_t slave;
    ect_wiring_t *wiring;
    bool link[ECT_TOPOLOGY_PORTS]; /* what is known to its ESC */
    bool hung;                     /* its microcontroller stands still */
    uint32_t ports_seen;           /* changes of its loops that ways of frames have followed */
    uint32_t seen;                 /* ESC activity that the slave has dealt with */
    uint64_t esc_ns;               /* what its ESC asked for when it was last ticked */
    uint32_t sii_seen;             /* writes to its EEPROM that were told */
    uint64_t slave_ns;             /* when its slave wants to run */
    uint64_t last_frame_ns;        /* but for frames that the fast way took: see `fast_frame_ns` */
    ect_lamps_t *lamps;
    uint8_t *esc_memory; /* of the chain's `pool` */
    uint8_t *buffer;     /* likewise; NULL: its device wants none */
    void *memory[10];    /* everything that was allocated for it */
    size_t blocks;
} twin_t;

struct ect_chain {
    size_t count;
    bool link[ECT_ENDS]; /* a cable is in at this end */
    bool links_due;      /* plugs may have been pulled, or slaves have left */
    bool ways_due;       /* loops may be others */
    ect_guard_t guard;   /* at the wires of the next frame */
    void *guard_ctx;
    ect_topology_node_t *nodes;
    bool line; /* each twin is at port 1 of the one before it */
    ect_fast_t *fast;
    ect_deadlines_t *deadlines; /* of twins: when they or their ESCs want to run, or before */
    uint64_t *ready;            /* a bit a twin: something has happened to it since it was polled */
    uint64_t now_ns;            /* the latest time that it has seen */
    uint64_t rests_ns;          /* nobody is woken before that */
    uint64_t frame_ns;          /* when the last frame came; 0 never */
    uint64_t fast_frame_ns;     /* when the first `fast_reach` twins last had a frame the fast way */
    size_t fast_reach;
    uint8_t *pool; /* what twins have much of and mostly leave alone: memory is taken when it is written to */
    void *kept;    /* the instance of a twin, as it was before its signals were set */
    size_t kept_room;
    ect_wiring_t kept_wiring;
    bool kept_off_bus, kept_restart;
    twin_t twins[];
};

static void *allocate(void *of, size_t size)
{
    twin_t *twin = of;
    void *block = calloc(1, size > 0 ? size : 1);
    if (block)
        twin->memory[twin->blocks++] = block;
    return block;
}

static const ect_esc_personality_t *personality_of(const ect_twin_config_t *c)
{
    return ect_esc_personality(c->esc ? c->esc : c->device->esc);
}

static size_t esc_size(const ect_twin_config_t *c)
{
    const ect_esc_personality_t *personality = personality_of(c);
    return personality ? ECT_ESC_MEMORY_SIZE(personality->ram_kb) : 0;
}

/* One block for all is so large that the system gives it as zeros, page by page when they are written to. */
static bool make_pool(ect_chain_t *chain, const ect_twin_config_t *twins)
{
    size_t size = 1;
    for (size_t i = 0; i < chain->count; i++)
        size += esc_size(&twins[i]) + twins[i].device->buffer_size;
    uint8_t *next = chain->pool = calloc(1, size);
    for (size_t i = 0; i < chain->count && next; i++) {
        chain->twins[i].esc_memory = next;
        next += esc_size(&twins[i]);
        chain->twins[i].buffer = twins[i].device->buffer_size > 0 ? next : NULL;
        next += twins[i].device->buffer_size;
    }
    return chain->pool != NULL;
}

static bool make_esc(twin_t *twin)
{
    const ect_twin_config_t *c = &twin->config;
    const ect_esc_personality_t *personality = personality_of(c);
    if (!personality)
        return false;
    uint8_t *sii = allocate(twin, c->device->sii_size);
    if (!sii || ect_sii_write(c->device, &c->identity, c->alias, sii, c->device->sii_size) < 0)
        return false;
    if (c->sii)
        memcpy(sii, c->sii, c->device->sii_size);
    twin->esc.config = (ect_esc_config_t){
        .personality = personality,
        .memory = twin->esc_memory,
        .sii = sii,
        .sii_size = c->device->sii_size,
        .keep_source_mac = c->keep_source_mac,
        .drift_ppb = c->drift_ppb,
    };
    return true;
}

static bool make_slave(twin_t *twin)
{
    const ect_plant_t *plant = twin->config.plant;
    twin->pdi = ect_virtual_pdi(&twin->esc);
    twin->slave.config = (ect_slave_config_t){
        .device = twin->config.device,
        .pdi = &twin->pdi,
        .identity = &twin->config.identity,
        .storage = twin->config.storage,
        .buffer = twin->buffer,
        .outside_offset = plant ? plant->outside_offset : 0,
        .outside_size = plant ? plant->outside_size : 0,
    };
    return ect_slave_take(&twin->slave.config, allocate, twin);
}

/* What controller, stack and device are made of stays, all else starts anew. */
static bool power_on(twin_t *twin, uint64_t now_ns)
{
    const ect_plant_t *plant = twin->config.plant;
    ect_esc_config_t esc = twin->esc.config;
    ect_slave_config_t slave = twin->slave.config;
    const ect_esc_arrival_t arrival = twin->esc.arrival;
    twin->hung = esc.pdi_watched = false;
    slave.device_id = twin->config.alias;
    if (!slave.instance || ect_esc_init(&twin->esc, &esc, now_ns) != 0)
        return false;
    ect_esc_set_arrival(&twin->esc, &arrival);
    slave.switches = plant && plant->station_alias ? plant->station_alias(slave.instance) : 0;
    for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++)
        ect_esc_set_link(&twin->esc, port, twin->link[port]);
    twin->esc_ns = ECT_NEVER;
    twin->slave_ns = now_ns;
    return ect_slave_init(&twin->slave, &slave, now_ns) == 0;
}

/* Unlike the first time, its device may have used the buffer. */
static void power_on_again(twin_t *twin, uint64_t now_ns)
{
    if (twin->buffer)
        memset(twin->buffer, 0, twin->config.device->buffer_size);
    (void)power_on(twin, now_ns); /* what was possible once is again */
}

ect_twin_config_t ect_twin_default(const ect_device_t *device, const ect_plant_t *plant)
{
    return (ect_twin_config_t){.device = device, .plant = plant, .identity = device->identity, .cable_m = 1};
}

static bool make_twin(twin_t *twin, uint64_t now_ns)
{
    twin->lamps = allocate(twin, sizeof *twin->lamps);
    twin->wiring = allocate(twin, sizeof *twin->wiring);
    if (!twin->lamps || !twin->wiring || !make_esc(twin) || !make_slave(twin))
        return false;
    *twin->wiring = (ect_wiring_t){.plug = {1, 1, 1, 1}, .drift_ppb = twin->config.drift_ppb};
    return power_on(twin, now_ns);
}

/* Somebody has put another one of its kind in its place, with the next product code. */
static void change_identity(twin_t *twin)
{
    ect_esc_config_t *esc = &twin->esc.config;
    twin->config.identity.product_code++;
    (void)ect_sii_write(twin->config.device, &twin->config.identity, twin->config.alias, esc->sii, esc->sii_size);
}

static bool on_bus(const twin_t *twin)
{
    return !twin->slave.off_bus;
}

static bool plugged(const ect_chain_t *chain, ect_topology_place_t at)
{
    const twin_t *twin = &chain->twins[at.slave];
    return on_bus(twin) && twin->wiring->plug[at.port] != 0;
}

/* Whether a wire is in at both its ends. */
static bool has_link(const ect_chain_t *chain, ect_topology_place_t at)
{
    ect_topology_place_t far;
    switch (ect_topology_across(chain->nodes, chain->count, at, &far)) {
    case ECT_TOPOLOGY_SLAVE:
        return plugged(chain, at) && plugged(chain, far);
    case ECT_TOPOLOGY_MASTER:
        return plugged(chain, at) && chain->link[ECT_END_IN];
    case ECT_TOPOLOGY_FAR:
        return plugged(chain, at) && chain->link[ECT_END_OUT];
    default:
        return false;
    }
}

/* Whoever is at the other end sees the same change. */
static bool links_moved(const ect_chain_t *chain, size_t i)
{
    bool moved = false;
    for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++)
        moved |= chain->twins[i].link[port] != has_link(chain, (ect_topology_place_t){i, port});
    return moved;
}

static void follow_links(ect_chain_t *chain)
{
    chain->links_due = false;
    for (size_t i = 0; i < chain->count; i++) {
        twin_t *twin = &chain->twins[i];
        for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++) {
            bool link = has_link(chain, (ect_topology_place_t){i, port});
            if (twin->link[port] == link)
                continue;
            twin->link[port] = link;
            ect_esc_set_link(&twin->esc, port, link);
            ect_fast_look(chain->fast, i);
            chain->ways_due = true;
        }
    }
}

/* The wire over which a frame leaves, or has come: that of the slave whose input is at one of its ends. */
static size_t wire_of(const ect_chain_t *chain, ect_topology_place_t at)
{
    if (at.port == 0)
        return at.slave;
    size_t down = chain->nodes[at.slave].down[at.port];
    return down == ECT_TOPOLOGY_NONE ? chain->count : down;
}

static uint32_t wire_ns(const ect_chain_t *chain, size_t wire)
{
    uint32_t metres = wire < chain->count ? chain->twins[wire].config.cable_m : 0;
    return PHYS_NS + METRE_NS * metres;
}

/* How far a way has been followed. */
typedef struct way {
    ect_topology_place_t at;
    uint32_t ns;
    uint8_t *seen; /* by twin: bit n port n, bit 4 the processing unit */
} way_t;

enum { UNIT = 4 };

static void note_time(uint8_t *seen, unsigned int bit, uint32_t *time_ns, uint32_t now_ns)
{
    if ((*seen & (1u << bit)) == 0)
        *time_ns = now_ns;
    *seen = (uint8_t)(*seen | (1u << bit));
}

/* Through one controller. @return whether the frame leaves it; then at way->at */
static bool through_one(ect_chain_t *chain, way_t *way)
{
    const ect_esc_t *esc = &chain->twins[way->at.slave].esc;
    const ect_esc_personality_t *chip = esc->config.personality;
    ect_esc_arrival_t arrival = esc->arrival;
    uint8_t *seen = &way->seen[way->at.slave];
    unsigned int port = way->at.port;
    bool unit_seen = (*seen & (1u << UNIT)) != 0;
    note_time(seen, port, &arrival.port_ns[port], way->ns);
    unsigned int out = ect_esc_next_port(esc, port);
    bool circulates = out == 0 && ect_esc_circulates(esc);
    if (port != 0)
        way->ns += chip->forwarding_ns;
    if (port == 0 || circulates) {
        note_time(seen, UNIT, &arrival.unit_ns, way->ns);
        way->ns += chip->processing_ns;
    }
    ect_esc_set_arrival(&chain->twins[way->at.slave].esc, &arrival);
    way->at.port = circulates ? ect_esc_next_port(esc, 0) : out;
    return !(circulates && (unit_seen || way->at.port == 0)) && chain->twins[way->at.slave].link[way->at.port];
}

static void follow_way(ect_chain_t *chain, way_t way)
{
    ect_topology_place_t far;
    while ((way.at.port == 0 || ect_esc_port_open(&chain->twins[way.at.slave].esc, way.at.port)) &&
           through_one(chain, &way)) {
        way.ns += wire_ns(chain, wire_of(chain, way.at));
        if (ect_topology_across(chain->nodes, chain->count, way.at, &far) != ECT_TOPOLOGY_SLAVE)
            return;
        way.at = far;
    }
}

/* When frames are where, from either end. Without memory for it the times stay as they were. */
static void find_ways(ect_chain_t *chain)
{
    uint8_t *seen = calloc(chain->count, 1);
    chain->ways_due = false;
    if (!seen)
        return;
    if (chain->twins[0].link[0])
        follow_way(chain, (way_t){.at = {0, 0}, .seen = seen});
    if (chain->link[ECT_END_OUT])
        follow_way(chain, (way_t){.at = {chain->count - 1, 1}, .seen = seen});
    free(seen);
}

static bool chip_has_port(const void *ctx, size_t slave, unsigned int port)
{
    const ect_twin_config_t *twins = ctx;
    const ect_esc_personality_t *chip = personality_of(&twins[slave]);
    return chip && (chip->ports & (1u << port)) != 0;
}

/* To be freed; NULL: no memory. */
static ect_topology_node_t *nodes_of(const ect_twin_config_t *twins, size_t count)
{
    ect_topology_node_t *nodes = calloc(count, sizeof *nodes);
    for (size_t i = 0; nodes && i < count; i++)
        nodes[i] = (ect_topology_node_t){.up = twins[i].up, .up_port = twins[i].up_port};
    return nodes;
}

size_t ect_chain_check_wires(const ect_twin_config_t *twins, size_t count)
{
    ect_topology_node_t *nodes = nodes_of(twins, count);
    size_t wrong = nodes ? ect_topology_lay(nodes, count, chip_has_port, twins) : count;
    free(nodes);
    return wrong;
}

static bool lay_wires(ect_chain_t *chain, const ect_twin_config_t *twins)
{
    chain->nodes = nodes_of(twins, chain->count);
    if (!chain->nodes || ect_topology_lay(chain->nodes, chain->count, chip_has_port, twins) != chain->count)
        return false;
    chain->line = true;
    for (size_t i = 1; i < chain->count; i++)
        chain->line &= chain->nodes[i - 1].down[1] == i;
    return true;
}

/* Before anything is powered on: who is connected to whom from the beginning on. */
static void plug_all_in(ect_chain_t *chain)
{
    for (size_t i = 0; i < chain->count; i++) {
        for (unsigned int port = 0; port < ECT_TOPOLOGY_PORTS; port++) {
            ect_topology_place_t far;
            ect_topology_end_t end =
                ect_topology_across(chain->nodes, chain->count, (ect_topology_place_t){i, port}, &far);
            chain->twins[i].link[port] = end == ECT_TOPOLOGY_SLAVE || end == ECT_TOPOLOGY_MASTER;
        }
    }
}

static void make_ready(ect_chain_t *chain, size_t i)
{
    ect_bits_add(chain->ready, i);
}

/* It has seen a frame, which may be the cause of something to come. */
static void note_frame(ect_chain_t *chain, size_t i)
{
    uint64_t due_ns = ect_esc_due(&chain->twins[i].esc);
    make_ready(chain, i);
    if (due_ns < ect_deadlines_of(chain->deadlines, i))
        ect_deadlines_set(chain->deadlines, i, due_ns);
}

static void note_touched(ect_chain_t *chain)
{
    size_t count;
    const uint32_t *touched = ect_fast_touched(chain->fast, &count);
    for (size_t k = 0; k < count; k++)
        note_frame(chain, touched[k]);
}

/* Frames may have left something undone; due before a controller is touched in any other way. */
static void settle(ect_chain_t *chain)
{
    ect_fast_settle(chain->fast);
    note_touched(chain);
}

static void powered_on(ect_chain_t *chain, size_t i)
{
    ect_fast_put(chain->fast, i, &chain->twins[i].esc);
    make_ready(chain, i);
}

static bool make_lists(ect_chain_t *chain)
{
    chain->fast = ect_fast_new(chain->count);
    chain->deadlines = ect_deadlines_new(chain->count);
    chain->ready = calloc(ect_bits_words(chain->count), sizeof *chain->ready);
    return chain->fast && chain->deadlines && chain->ready;
}

ect_chain_t *ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns)
{
    ect_chain_t *chain = calloc(1, sizeof *chain + count * sizeof chain->twins[0]);
    if (!chain)
        return NULL;
    chain->count = count;
    chain->link[ECT_END_IN] = true;
    chain->links_due = true;
    chain->now_ns = now_ns;
    bool made = make_lists(chain) && make_pool(chain, twins) && lay_wires(chain, twins);
    if (made)
        plug_all_in(chain);
    for (size_t i = 0; i < count && made; i++) {
        chain->twins[i].config = twins[i];
        made = make_twin(&chain->twins[i], now_ns);
        if (made)
            powered_on(chain, i);
    }
    if (made) {
        find_ways(chain);
        return chain;
    }
    ect_chain_free(chain);
    return NULL;
}

void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns)
{
    chain->links_due = chain->ways_due = true;
    for (size_t i = 0; i < chain->count; i++) {
        power_on_again(&chain->twins[i], now_ns);
        powered_on(chain, i);
    }
}

void ect_chain_free(ect_chain_t *chain)
{
    if (!chain)
        return;
    for (size_t i = 0; i < chain->count; i++) {
        for (size_t b = 0; b < chain->twins[i].blocks; b++)
            free(chain->twins[i].memory[b]);
    }
    ect_fast_free(chain->fast);
    ect_deadlines_free(chain->deadlines);
    free(chain->ready);
    free(chain->nodes);
    free(chain->pool);
    free(chain->kept);
    free(chain);
}

void ect_chain_set_link(ect_chain_t *chain, ect_end_t end, bool link)
{
    settle(chain);
    chain->link[end] = link;
    follow_links(chain);
    if (chain->ways_due)
        find_ways(chain);
}

static void begin_anew(ect_chain_t *chain, size_t i, uint64_t now_ns)
{
    power_on_again(&chain->twins[i], now_ns);
    powered_on(chain, i);
    chain->links_due = chain->ways_due = true;
}

static void hang(twin_t *twin, bool hung)
{
    twin->hung = hung;
    ect_esc_watch_pdi(&twin->esc, hung);
}

static ect_sii_fault_t sii_fault_of(ect_fault_kind_t kind)
{
    switch (kind) {
    case ECT_FAULT_EEPROM_BUSY:
        return ECT_SII_BUSY;
    case ECT_FAULT_EEPROM_NACK:
        return ECT_SII_NO_ANSWER;
    case ECT_FAULT_EEPROM_FLIP:
        return ECT_SII_BIT_ERROR;
    default:
        return ECT_SII_GOOD;
    }
}

static void do_fault(ect_chain_t *chain, size_t i, const ect_fault_t *fault, uint64_t now_ns)
{
    twin_t *twin = &chain->twins[i];
    switch (fault->kind) {
    case ECT_FAULT_HANG:
    case ECT_FAULT_RESUME:
        hang(twin, fault->kind == ECT_FAULT_HANG);
        return;
    case ECT_FAULT_IDENTITY:
        change_identity(twin);
        begin_anew(chain, i, now_ns);
        return;
    case ECT_FAULT_RESET:
        begin_anew(chain, i, now_ns);
        return;
    case ECT_FAULT_LOSE_EVENT:
        ect_esc_lose_al_event(&twin->esc);
        return;
    case ECT_FAULT_CLOCK:
        ect_esc_clock_jump(&twin->esc, fault->amount);
        return;
    default:
        ect_esc_sii_fault(&twin->esc, sii_fault_of(fault->kind), (unsigned int)fault->amount);
    }
}

void ect_chain_fault(ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns)
{
    size_t i = fault->slave - 1u;
    settle(chain);
    (void)ect_esc_tick(&chain->twins[i].esc, now_ns);
    do_fault(chain, i, fault, now_ns);
    ect_chain_wake(chain, i);
}

void ect_chain_guard(ect_chain_t *chain, ect_guard_t guard, void *ctx)
{
    chain->guard = guard;
    chain->guard_ctx = ctx;
}

/* A frame on its way. */
typedef struct passage {
    ect_crossing_t c;
    uint64_t now_ns;
    ect_guard_t guard; /* NULL: none */
    void *guard_ctx;
} passage_t;

/* @return false: it ends here */
static bool arrive(twin_t *twin, unsigned int port, passage_t *p)
{
    twin->last_frame_ns = p->now_ns;
    if (port != 0 && !ect_esc_port_open(&twin->esc, port)) {
        (void)ect_esc_frame_at(&twin->esc, port); /* the next one may pass */
        return false;
    }
    if (p->c.damaged) {
        ect_esc_damaged(&twin->esc, port, p->c.noticed);
        p->c.noticed = true;
        return !ect_esc_circulates(&twin->esc);
    }
    return port != 0 || ect_esc_process(&twin->esc, p->c.frame, p->c.length, p->now_ns) == ECT_FRAME_FORWARD;
}

/* Ends, for a frame that meets a port 0 without a link for the second time is destroyed there. */
static bool depart(twin_t *twin, unsigned int *port, const passage_t *p)
{
    *port = ect_esc_next_port(&twin->esc, *port);
    while (*port == 0 && ect_esc_circulates(&twin->esc)) {
        if (ect_esc_process(&twin->esc, p->c.frame, p->c.length, p->now_ns) != ECT_FRAME_FORWARD)
            return false;
        *port = ect_esc_next_port(&twin->esc, 0);
    }
    return twin->link[*port]; /* a loop may be forced open where no wire is */
}

/* What happens to it on a wire. @return false: it ends there */
static bool over_wire(passage_t *p, size_t wire, bool back)
{
    p->c.wire = wire;
    p->c.back = back;
    return !p->guard || p->guard(p->guard_ctx, &p->c);
}

/* Through one controller and onto the wire behind it. @return false: it ends here */
static bool through(ect_chain_t *chain, ect_topology_place_t *at, passage_t *p)
{
    twin_t *twin = &chain->twins[at->slave];
    return arrive(twin, at->port, p) && depart(twin, &at->port, p) && over_wire(p, wire_of(chain, *at), at->port == 0);
}

/* From where it arrives. */
static ect_end_t walk(ect_chain_t *chain, ect_topology_place_t at, passage_t *p)
{
    while (through(chain, &at, p)) {
        ect_topology_place_t far;
        ect_topology_end_t end = ect_topology_across(chain->nodes, chain->count, at, &far);
        if (end == ECT_TOPOLOGY_SLAVE)
            at = far;
        else if (p->c.damaged || end == ECT_TOPOLOGY_OPEN)
            return ECT_END_NONE;
        else
            return end == ECT_TOPOLOGY_MASTER ? ECT_END_IN : ECT_END_OUT;
    }
    return ECT_END_NONE;
}

static ect_end_t enter(ect_chain_t *chain, ect_end_t in, passage_t *p)
{
    ect_topology_place_t at = {in == ECT_END_IN ? 0 : chain->count - 1, in == ECT_END_IN ? 0 : 1};
    bool arrives = chain->twins[at.slave].link[at.port] && over_wire(p, wire_of(chain, at), in == ECT_END_OUT);
    return arrives ? walk(chain, at, p) : ECT_END_NONE; /* else the cable ends in a dead socket */
}

/* Any of them may have been on the way. */
static void note_all(ect_chain_t *chain)
{
    for (size_t i = 0; i < chain->count; i++) {
        ect_fast_look(chain->fast, i);
        note_frame(chain, i);
    }
}

static ect_end_t pass_slowly(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    passage_t passage = {.c = {.frame = frame, .length = length},
                         .now_ns = now_ns,
                         .guard = chain->guard,
                         .guard_ctx = chain->guard_ctx};
    chain->guard = NULL;
    settle(chain);
    ect_end_t out = enter(chain, in, &passage);
    note_all(chain);
    return out;
}

/* The other end of the wire on which a frame is. @return whether it is at a slave; else it leaves the chain there */
static bool arrives_at(const ect_chain_t *chain, const ect_crossing_t *c, ect_topology_place_t *to)
{
    if (c->wire == chain->count)
        *to = (ect_topology_place_t){chain->count - 1, 1};
    else if (c->wire == 0 || !c->back)
        *to = (ect_topology_place_t){c->wire, 0};
    else
        *to = (ect_topology_place_t){chain->nodes[c->wire].up, chain->nodes[c->wire].up_port};
    return c->wire != (c->back ? 0 : chain->count);
}

ect_end_t ect_chain_go_on(ect_chain_t *chain, const ect_crossing_t *from, uint64_t now_ns)
{
    passage_t passage = {.c = *from, .now_ns = now_ns};
    ect_topology_place_t at;
    chain->now_ns = chain->frame_ns = now_ns;
    bool inside = arrives_at(chain, from, &at);
    if (!chain->twins[at.slave].link[at.port])
        return ECT_END_NONE;
    if (!inside)
        return from->damaged ? ECT_END_NONE : from->back ? ECT_END_IN : ECT_END_OUT;
    settle(chain);
    ect_end_t out = walk(chain, at, &passage);
    note_all(chain);
    return out;
}

/* Those whose controllers have something to do by themselves: it may be seen in a frame that does not go to them. Their
 * slaves are polled, too, but not before the next frame, which may come first. */
static void tick_due(ect_chain_t *chain, uint64_t now_ns)
{
    size_t i;
    if (ect_deadlines_first(chain->deadlines, &i) <= now_ns)
        settle(chain);
    while (ect_deadlines_first(chain->deadlines, &i) <= now_ns) {
        make_ready(chain, i);
        ect_deadlines_set(chain->deadlines, i, ect_esc_tick(&chain->twins[i].esc, now_ns));
        ect_fast_look(chain->fast, i);
    }
}

static uint64_t last_frame(const ect_chain_t *chain, size_t i)
{
    uint64_t slow_ns = chain->twins[i].last_frame_ns;
    return i < chain->fast_reach && chain->fast_frame_ns > slow_ns ? chain->fast_frame_ns : slow_ns;
}

/* Who is within reach from now on has its last frame at the same time as the others. */
static void note_reach(ect_chain_t *chain, size_t reach)
{
    if (reach == chain->fast_reach)
        return;
    for (size_t i = 0; i < chain->fast_reach; i++)
        chain->twins[i].last_frame_ns = last_frame(chain, i);
    chain->fast_reach = reach;
}

ect_end_t ect_chain_pass(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    chain->now_ns = chain->frame_ns = now_ns;
    bool plain = chain->line && in == ECT_END_IN && chain->twins[0].link[0];
    if (!plain || chain->guard)
        return pass_slowly(chain, in, frame, length, now_ns);
    tick_due(chain, now_ns);
    note_reach(chain, ect_fast_reach(chain->fast));
    ect_fast_result_t result = ect_fast_pass(chain->fast, frame, length, now_ns);
    if (result == ECT_FAST_NOT_TAKEN)
        return pass_slowly(chain, in, frame, length, now_ns);
    chain->fast_frame_ns = now_ns;
    note_touched(chain);
    return result == ECT_FAST_OUT ? ECT_END_OUT : ECT_END_IN;
}

bool ect_chain_process(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns)
{
    return ect_chain_pass(chain, ECT_END_IN, frame, length, now_ns) == ECT_END_IN;
}

/* A master may ask its slave for a pulse every nanosecond. The chip gives them, but nobody can be woken by each. */
static void tick_esc(ect_chain_t *chain, twin_t *twin, uint64_t now_ns)
{
    bool woken = now_ns >= twin->esc_ns;
    twin->esc_ns = ect_esc_tick(&twin->esc, now_ns);
    if (woken && twin->esc_ns < now_ns + REST_NS)
        chain->rests_ns = now_ns + REST_NS;
}

/* What a user has done to its surroundings. */
static void follow_wiring(twin_t *twin)
{
    const ect_wiring_t *wiring = twin->wiring;
    for (unsigned int n = 0; n < 2; n++)
        ect_esc_latch_input(&twin->esc, n, wiring->latch[n] != 0);
    if (twin->esc.config.drift_ppb != wiring->drift_ppb)
        ect_esc_set_drift(&twin->esc, wiring->drift_ppb);
}

/* @return whether it begins anew */
static bool poll_twin(twin_t *twin, uint64_t now_ns)
{
    follow_wiring(twin);
    twin->seen = ect_esc_activity(&twin->esc);
    twin->slave_ns = twin->hung ? ECT_NEVER : ect_slave_poll(&twin->slave, now_ns);
    bool restarts = twin->slave.restart || ect_esc_resets(&twin->esc) != 0;
    if (restarts)
        power_on_again(twin, now_ns);
    return restarts;
}

static void tell_sii(twin_t *twin)
{
    if (twin->sii_seen == ect_esc_sii_writes(&twin->esc))
        return;
    twin->sii_seen = ect_esc_sii_writes(&twin->esc);
    if (twin->config.sii_written)
        twin->config.sii_written(twin->config.sii_ctx, twin->esc.config.sii, twin->esc.config.sii_size);
}

/* Brings a twin up to date, and the time at which it has to be looked at again. */
static void attend(ect_chain_t *chain, size_t i, uint64_t now_ns)
{
    twin_t *twin = &chain->twins[i];
    bool off_bus = twin->slave.off_bus;
    bool polled = twin->seen != ect_esc_activity(&twin->esc) || now_ns >= twin->slave_ns;
    if (polled || now_ns >= ect_esc_due(&twin->esc))
        tick_esc(chain, twin, now_ns);
    polled |= twin->seen != ect_esc_activity(&twin->esc);
    if (polled && poll_twin(twin, now_ns))
        ect_fast_put(chain->fast, i, &twin->esc);
    tell_sii(twin);
    ect_fast_look(chain->fast, i);
    chain->links_due |= off_bus != twin->slave.off_bus;
    chain->ways_due |= twin->ports_seen != ect_esc_port_changes(&twin->esc);
    twin->ports_seen = ect_esc_port_changes(&twin->esc);
    ect_deadlines_set(chain->deadlines, i, ect_earlier(twin->slave_ns, ect_esc_due(&twin->esc)));
}

uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns)
{
    size_t i;
    chain->now_ns = now_ns;
    settle(chain);
    while (ect_deadlines_first(chain->deadlines, &i) <= now_ns) {
        ect_deadlines_set(chain->deadlines, i, ECT_NEVER);
        make_ready(chain, i);
    }
    for (size_t word = 0; word < ect_bits_words(chain->count); word++) {
        uint64_t left = chain->ready[word];
        chain->ready[word] = 0;
        while (left != 0)
            attend(chain, ect_bits_take(word, &left), now_ns);
    }
    if (chain->links_due)
        follow_links(chain);
    if (chain->ways_due)
        find_ways(chain);
    uint64_t quiet_ns = chain->frame_ns + ECT_INDICATOR_TRAFFIC_NS; /* then lamps change */
    uint64_t next_ns = ect_later(ect_deadlines_first(chain->deadlines, &i), chain->rests_ns);
    return chain->frame_ns != 0 && now_ns < quiet_ns ? ect_earlier(next_ns, quiet_ns) : next_ns;
}

void ect_chain_show_lamps(const ect_chain_t *chain, size_t position)
{
    const twin_t *twin = &chain->twins[position];
    ect_lamps_update(twin->lamps, &twin->slave, twin->link[0], twin->link[1], last_frame(chain, position),
                     chain->now_ns);
}

bool ect_chain_unfinished(const ect_chain_t *chain)
{
    for (size_t i = 0; i < chain->count; i++) {
        const ect_plant_t *plant = chain->twins[i].config.plant;
        if (plant && plant->unfinished && plant->unfinished(chain->twins[i].slave.config.instance))
            return true;
    }
    return false;
}

size_t ect_chain_count(const ect_chain_t *chain)
{
    return chain->count;
}

bool ect_chain_next_signal(const ect_chain_t *chain, size_t position, ect_chain_cursor_t *cursor, ect_signal_ref_t *ref)
{
    const twin_t *twin = &chain->twins[position];
    ect_chain_show_lamps(chain, position);
    return ect_signals_next(twin->config.plant, twin->slave.config.instance, &cursor->device, ref) ||
           ect_signals_next(&ect_lamps_plant, twin->lamps, &cursor->lamps, ref) ||
           ect_signals_next(&ect_wiring_plant, twin->wiring, &cursor->wiring, ref);
}

bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref)
{
    const twin_t *twin = &chain->twins[position];
    ect_chain_show_lamps(chain, position);
    return ect_signal_find(twin->config.plant, twin->slave.config.instance, name, ref) ||
           ect_signal_find(&ect_lamps_plant, twin->lamps, name, ref) ||
           ect_signal_find(&ect_wiring_plant, twin->wiring, name, ref);
}

const ect_modbus_t *ect_chain_modbus(const ect_chain_t *chain, size_t position, void **instance)
{
    const twin_t *twin = &chain->twins[position];
    *instance = twin->slave.config.instance;
    return twin->config.plant && !twin->hung && on_bus(twin) ? twin->config.plant->modbus : NULL;
}

ect_bulk_t ect_chain_bulk(const ect_chain_t *chain, size_t position)
{
    const twin_t *twin = &chain->twins[position];
    const ect_plant_t *plant = twin->config.plant;
    return plant && plant->bulk ? plant->bulk(twin->slave.config.instance) : (ect_bulk_t){0};
}

bool ect_chain_keep(ect_chain_t *chain, size_t position)
{
    const twin_t *twin = &chain->twins[position];
    size_t size = twin->config.device->instance_size;
    if (size > chain->kept_room) {
        void *grown = realloc(chain->kept, size);
        if (!grown)
            return false;
        chain->kept = grown;
        chain->kept_room = size;
    }
    memcpy(chain->kept, twin->slave.config.instance, size);
    chain->kept_wiring = *twin->wiring;
    chain->kept_off_bus = twin->slave.off_bus;
    chain->kept_restart = twin->slave.restart;
    return true;
}

void ect_chain_put_back(ect_chain_t *chain, size_t position)
{
    twin_t *twin = &chain->twins[position];
    memcpy(twin->slave.config.instance, chain->kept, twin->config.device->instance_size);
    *twin->wiring = chain->kept_wiring;
    twin->slave.off_bus = chain->kept_off_bus;
    twin->slave.restart = chain->kept_restart;
}

void ect_chain_wake(ect_chain_t *chain, size_t position)
{
    ect_slave_wake(&chain->twins[position].slave);
    chain->twins[position].slave_ns = 0;
    chain->links_due |= links_moved(chain, position);
    make_ready(chain, position);
}

const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position)
{
    return &chain->twins[position].slave;
}

ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position)
{
    settle(chain);
    make_ready(chain, position);
    return &chain->twins[position].esc;
}
