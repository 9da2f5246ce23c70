/* SPDX-License-Identifier: MIT */
#include "bus/chain.h"

#include <stdlib.h>
#include <string.h>

#include "bus/deadlines.h"
#include "bus/fast.h"
#include "bus/lamps.h"
#include "bus/wiring.h"
#include "esc/route.h"
#include "ports/virtual/virtual.h"
#include "sii/sii.h"
#include "slave/indicator.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* From one time that an ESC asks for to the next one. Cycles in use go down to 31.25 us. */
enum { REST_NS = 25000 };

enum { WORD = 64 };

typedef struct twin {
    ect_twin_config_t config;
    ect_esc_t esc;
    ect_pdi_t pdi;
    ect_slave_t slave;
    ect_wiring_t *wiring;
    bool link[ECT_ENDS];    /* what is known to its ESC: a link at port 0, at port 1 */
    uint32_t seen;          /* ESC activity that the slave has dealt with */
    uint64_t esc_ns;        /* deadline of the ESC */
    uint32_t sii_seen;      /* writes to its EEPROM that were told */
    uint64_t deadline_ns;   /* of the slave or of the ESC, whichever is first */
    uint64_t last_frame_ns; /* but for frames that the fast way took: see `fast_frame_ns` */
    ect_lamps_t *lamps;
    void *memory[10]; /* everything that was allocated for it */
    size_t blocks;
} twin_t;

struct ect_chain {
    size_t count;
    bool link[ECT_ENDS]; /* a cable is in at this end */
    bool links_due;      /* plugs may have been pulled, or slaves have left */
    ect_fast_t *fast;
    ect_deadlines_t *deadlines; /* of twins; never later than what they and their ESCs want */
    uint64_t *ready;            /* a bit a twin: something has happened to it since it was polled */
    uint64_t now_ns;            /* the latest time that it has seen */
    uint64_t frame_ns;          /* when the last frame came; 0 never */
    uint64_t fast_frame_ns;     /* when the first `fast_reach` twins last had a frame the fast way */
    size_t fast_reach;
    void *kept; /* the instance of a twin, as it was before its signals were set */
    size_t kept_room;
    ect_wiring_t kept_wiring;
    bool kept_off_bus, kept_restart;
    twin_t twins[];
};

static void *allocate(twin_t *twin, size_t size)
{
    void *block = calloc(1, size > 0 ? size : 1);
    if (block)
        twin->memory[twin->blocks++] = block;
    return block;
}

static bool make_esc(twin_t *twin)
{
    const ect_twin_config_t *c = &twin->config;
    const ect_esc_personality_t *personality = ect_esc_personality(c->esc ? c->esc : c->device->esc);
    if (!personality)
        return false;
    uint8_t *memory = allocate(twin, ECT_ESC_MEMORY_SIZE(personality->ram_kb));
    uint8_t *sii = allocate(twin, c->device->sii_size);
    if (!memory || !sii || ect_sii_write(c->device, &c->identity, c->alias, sii, c->device->sii_size) < 0)
        return false;
    if (c->sii)
        memcpy(sii, c->sii, c->device->sii_size);
    twin->esc.config = (ect_esc_config_t){
        .personality = personality,
        .memory = memory,
        .sii = sii,
        .sii_size = c->device->sii_size,
        .keep_source_mac = c->keep_source_mac,
    };
    return true;
}

static bool make_slave(twin_t *twin)
{
    ect_slave_memory_t need = ect_slave_memory(twin->config.device);
    const ect_plant_t *plant = twin->config.plant;
    twin->pdi = ect_virtual_pdi(&twin->esc);
    twin->slave.config = (ect_slave_config_t){
        .device = twin->config.device,
        .pdi = &twin->pdi,
        .identity = &twin->config.identity,
        .storage = twin->config.storage,
        .instance = allocate(twin, need.instance),
        .mailbox = allocate(twin, need.mailbox),
        .process_data = allocate(twin, need.process_data),
        .process_size = (uint16_t)need.process_data,
        .runs = allocate(twin, need.runs * sizeof(ect_pdo_run_t)),
        .run_count = (uint16_t)need.runs,
        .staging = allocate(twin, need.staging),
        .staging_size = (uint16_t)need.staging,
        .buffer = need.buffer > 0 ? allocate(twin, need.buffer) : NULL,
        .outside_offset = plant ? plant->outside_offset : 0,
        .outside_size = plant ? plant->outside_size : 0,
    };
    return true;
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
    slave.switches = plant && plant->station_alias ? plant->station_alias(slave.instance) : 0;
    for (unsigned int port = 0; port < ECT_ENDS; port++)
        ect_esc_set_link(&twin->esc, port, twin->link[port]);
    twin->esc_ns = ECT_NEVER;
    twin->deadline_ns = now_ns;
    return ect_slave_init(&twin->slave, &slave, now_ns) == 0;
}

ect_twin_config_t ect_twin_default(const ect_device_t *device, const ect_plant_t *plant)
{
    return (ect_twin_config_t){.device = device, .plant = plant, .identity = device->identity};
}

static bool make_twin(twin_t *twin, uint64_t now_ns)
{
    twin->lamps = allocate(twin, sizeof *twin->lamps);
    twin->wiring = allocate(twin, sizeof *twin->wiring);
    if (!twin->lamps || !twin->wiring || !make_esc(twin) || !make_slave(twin))
        return false;
    *twin->wiring = (ect_wiring_t){.plug_in = 1, .plug_out = 1};
    return power_on(twin, now_ns);
}

static bool on_bus(const twin_t *twin)
{
    return !twin->slave.off_bus;
}

/* The wire before a twin; twin `count` stands for what is at the far end. */
static bool wire_before(const ect_chain_t *chain, size_t i)
{
    const twin_t *before = i > 0 ? &chain->twins[i - 1] : NULL;
    const twin_t *behind = i < chain->count ? &chain->twins[i] : NULL;
    bool there = before ? on_bus(before) && before->wiring->plug_out != 0 : chain->link[ECT_END_IN];
    return there && (behind ? on_bus(behind) && behind->wiring->plug_in != 0 : chain->link[ECT_END_OUT]);
}

static void follow_link(ect_chain_t *chain, size_t i, unsigned int port, bool link)
{
    twin_t *twin = &chain->twins[i];
    if (twin->link[port] == link)
        return;
    twin->link[port] = link;
    ect_esc_set_link(&twin->esc, port, link);
    ect_fast_look(chain->fast, i);
}

static void follow_links(ect_chain_t *chain)
{
    bool link = wire_before(chain, 0);
    chain->links_due = false;
    for (size_t i = 0; i < chain->count; i++) {
        follow_link(chain, i, 0, link);
        link = wire_before(chain, i + 1);
        follow_link(chain, i, 1, link);
    }
}

static void make_ready(ect_chain_t *chain, size_t i)
{
    chain->ready[i / WORD] |= 1ull << (i % WORD);
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
    chain->ready = calloc((chain->count + WORD - 1) / WORD, sizeof *chain->ready);
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
    bool made = make_lists(chain);
    for (size_t i = 0; i < count && made; i++) {
        twin_t *twin = &chain->twins[i];
        twin->config = twins[i];
        twin->link[0] = true;
        twin->link[1] = i + 1 < count;
        made = make_twin(twin, now_ns);
        if (made)
            powered_on(chain, i);
    }
    if (made)
        return chain;
    ect_chain_free(chain);
    return NULL;
}

void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns)
{
    chain->links_due = true;
    for (size_t i = 0; i < chain->count; i++) {
        (void)power_on(&chain->twins[i], now_ns); /* what was possible once is again */
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
    free(chain->kept);
    free(chain);
}

void ect_chain_set_link(ect_chain_t *chain, ect_end_t end, bool link)
{
    chain->link[end] = link;
    follow_links(chain);
}

static bool may_enter(const ect_chain_t *chain, ect_end_t in)
{
    return in == ECT_END_IN ? chain->twins[0].link[0] : ect_esc_port_open(&chain->twins[chain->count - 1].esc, 1);
}

/* Ends, for a frame that meets a port 0 without a link for the second time is destroyed there. */
static ect_end_t walk(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    size_t i = in == ECT_END_IN ? 0 : chain->count - 1;
    bool forward = in == ECT_END_IN; /* towards the processing unit of twin i, else towards its port 0 */
    if (!may_enter(chain, in))
        return ECT_END_NONE; /* the cable ends in a dead socket */
    for (;;) {
        twin_t *twin = &chain->twins[i];
        twin->last_frame_ns = now_ns;
        if (forward) {
            if (ect_esc_process(&twin->esc, frame, length, now_ns) != ECT_FRAME_FORWARD)
                return ECT_END_NONE;
            forward = ect_esc_port_open(&twin->esc, 1);
            if (forward && ++i == chain->count)
                return ECT_END_OUT;
        } else if (ect_esc_circulates(&twin->esc)) {
            forward = true;
        } else if (i == 0) {
            return twin->link[0] ? ECT_END_IN : ECT_END_NONE;
        } else if (!ect_esc_port_open(&chain->twins[--i].esc, 1)) {
            return ECT_END_NONE;
        }
    }
}

/* Any of them may have been on the way. */
static ect_end_t pass_slowly(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    ect_end_t out = walk(chain, in, frame, length, now_ns);
    for (size_t i = 0; i < chain->count; i++) {
        ect_fast_look(chain->fast, i);
        make_ready(chain, i);
    }
    return out;
}

/* Those whose controllers have something to do by themselves: it may be seen in a frame that does not go to them. */
static void tick_due(ect_chain_t *chain, uint64_t now_ns)
{
    size_t i;
    while (ect_deadlines_first(chain->deadlines, &i) <= now_ns) {
        ect_deadlines_set(chain->deadlines, i, ECT_NEVER);
        (void)ect_esc_tick(&chain->twins[i].esc, now_ns);
        ect_fast_look(chain->fast, i);
        make_ready(chain, i);
    }
}

static uint64_t earlier(uint64_t a_ns, uint64_t b_ns)
{
    return a_ns < b_ns ? a_ns : b_ns;
}

static void note_touched(ect_chain_t *chain)
{
    size_t count;
    const uint32_t *touched = ect_fast_touched(chain->fast, &count);
    for (size_t k = 0; k < count; k++) {
        size_t i = touched[k];
        uint64_t due_ns = ect_esc_due(&chain->twins[i].esc);
        make_ready(chain, i);
        if (due_ns < ect_deadlines_of(chain->deadlines, i))
            ect_deadlines_set(chain->deadlines, i, due_ns);
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
    if (in != ECT_END_IN || !chain->twins[0].link[0] || chain->count == 1)
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
static uint64_t tick_esc(twin_t *twin, uint64_t now_ns)
{
    bool woken = now_ns >= twin->esc_ns;
    uint64_t next_ns = ect_esc_tick(&twin->esc, now_ns);
    return woken && next_ns < now_ns + REST_NS ? now_ns + REST_NS : next_ns;
}

/* @return whether it begins anew */
static bool poll_twin(twin_t *twin, uint64_t now_ns)
{
    twin->esc_ns = tick_esc(twin, now_ns);
    twin->seen = ect_esc_activity(&twin->esc);
    uint64_t slave_ns = ect_slave_poll(&twin->slave, now_ns);
    twin->deadline_ns = twin->esc_ns < slave_ns ? twin->esc_ns : slave_ns;
    bool restarts = twin->slave.restart || ect_esc_resets(&twin->esc) != 0;
    if (restarts)
        (void)power_on(twin, now_ns);
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
    uint64_t due_ns = ECT_NEVER;
    if (twin->seen != ect_esc_activity(&twin->esc) || now_ns >= twin->deadline_ns) {
        bool restarts = poll_twin(twin, now_ns);
        if (restarts)
            ect_fast_put(chain->fast, i, &twin->esc);
    } else if (ect_esc_due(&twin->esc) < twin->deadline_ns) {
        due_ns = ect_esc_due(&twin->esc);
        due_ns = due_ns < now_ns + REST_NS ? now_ns + REST_NS : due_ns;
    }
    tell_sii(twin);
    ect_fast_look(chain->fast, i);
    chain->links_due |= off_bus != twin->slave.off_bus;
    ect_deadlines_set(chain->deadlines, i, earlier(twin->deadline_ns, due_ns));
}

uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns)
{
    size_t i;
    chain->now_ns = now_ns;
    while (ect_deadlines_first(chain->deadlines, &i) <= now_ns) {
        ect_deadlines_set(chain->deadlines, i, ECT_NEVER);
        make_ready(chain, i);
    }
    for (size_t word = 0; word < (chain->count + WORD - 1) / WORD; word++) {
        uint64_t left = chain->ready[word];
        chain->ready[word] = 0;
        for (; left != 0; left &= left - 1)
            attend(chain, word * WORD + (unsigned int)__builtin_ctzll(left), now_ns);
    }
    if (chain->links_due)
        follow_links(chain);
    uint64_t quiet_ns = chain->frame_ns + ECT_INDICATOR_TRAFFIC_NS; /* then lamps change */
    uint64_t next_ns = ect_deadlines_first(chain->deadlines, &i);
    return chain->frame_ns != 0 && now_ns < quiet_ns ? earlier(next_ns, quiet_ns) : next_ns;
}

static void show_lamps(const ect_chain_t *chain, size_t i)
{
    const twin_t *twin = &chain->twins[i];
    ect_lamps_update(twin->lamps, &twin->slave, twin->link[0], twin->link[1], last_frame(chain, i), chain->now_ns);
}

void ect_chain_show_lamps(const ect_chain_t *chain)
{
    for (size_t i = 0; i < chain->count; i++)
        show_lamps(chain, i);
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
    show_lamps(chain, position);
    return ect_signals_next(twin->config.plant, twin->slave.config.instance, &cursor->device, ref) ||
           ect_signals_next(&ect_lamps_plant, twin->lamps, &cursor->lamps, ref) ||
           ect_signals_next(&ect_wiring_plant, twin->wiring, &cursor->wiring, ref);
}

bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref)
{
    const twin_t *twin = &chain->twins[position];
    show_lamps(chain, position);
    return ect_signal_find(twin->config.plant, twin->slave.config.instance, name, ref) ||
           ect_signal_find(&ect_lamps_plant, twin->lamps, name, ref) ||
           ect_signal_find(&ect_wiring_plant, twin->wiring, name, ref);
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
    chain->twins[position].deadline_ns = 0;
    chain->links_due = true;
    make_ready(chain, position);
}

const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position)
{
    return &chain->twins[position].slave;
}

ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position)
{
    make_ready(chain, position);
    return &chain->twins[position].esc;
}
