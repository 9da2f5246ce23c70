/* SPDX-License-Identifier: MIT */
#include "bus/chain/chain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/bits.h"
#include "bus/chain/cabling.h"
#include "bus/chain/deadlines.h"
#include "bus/chain/delays.h"
#include "bus/chain/fast.h"
#include "bus/chain/passage.h"
#include "bus/chain/twin.h"
#include "esc/route.h"
#include "slave/indicator.h"
#include "wire/assert.h"

/* Shortest time between two wake-ups for an ESC. Cycles in use go down to 31.25 us. */
enum { REST_NS = 25000 };

struct ect_chain {
    ect_cabling_t cabling;
    ect_twin_t *twins; /* as in the cabling */
    void *block;       /* memory of the twins, the first of which begins at a line of the cache */
    bool links_due;    /* a plug may have been pulled, or a twin switched off, since the links were updated */
    bool delays_due;   /* a link or a loop may have changed since the delays were computed */
    ect_guard_t guard; /* of the next frame; NULL: none */
    void *guard_ctx;
    ect_fast_t *fast;
    ect_deadlines_t *deadlines; /* of twins, not later than the deadline of the twin or of its ESC */
    uint64_t *ready;            /* one bit for each twin: to be served by the next poll */
    uint64_t *owing;            /* one bit for each twin: its inputs are held since ect_chain_catch_up() */
    bool owes, catching_up;     /* a bit is set in `owing`; the present poll is that of ect_chain_catch_up() */
    uint64_t now_ns;            /* time of the last call with a time */
    uint64_t rests_ns;          /* no wake-up before */
    uint64_t frame_ns;          /* time of the last frame; 0: none yet */
    uint64_t fast_frame_ns;     /* time of the last frame on the fast path, through the first `fast_reach` twins */
    size_t fast_reach;
    uint8_t *ram; /* memory of all ESCs */
    size_t ram_size;
    uint8_t *buffers; /* of all devices in one block, because the system allocates its pages at the first write */
    ect_twin_snapshot_t *kept; /* one for each twin; NULL: none yet */
    const ect_names_t *names;  /* NULL: none */
    const ect_plant_t *shown;  /* signals of the bus; NULL: none */
    void *shown_instance;
    ect_connections_t *connections; /* NULL: none */
    size_t connection_count;
    struct {
        void (*ran)(void *ctx, size_t position, uint64_t now_ns); /* NULL: none */
        void *ctx;
    } observers[ECT_CHAIN_OBSERVERS];
};

static bool make_memory(ect_chain_t *chain, const ect_twin_config_t *twins)
{
    size_t buffers = 1;
    for (size_t i = 0; i < chain->cabling.count; i++) {
        chain->ram_size += ect_twin_ram_size(&twins[i]);
        buffers += ect_twin_buffer_size(&twins[i]);
    }
    chain->ram = calloc(1, chain->ram_size);
    chain->buffers = calloc(1, buffers);
    return chain->ram && chain->buffers;
}

static void make_ready(ect_chain_t *chain, size_t i)
{
    ect_bits_add(chain->ready, i);
}

/* Records a frame of the twin, which may change the deadline of its ESC. */
static inline void mark_frame(ect_chain_t *chain, size_t i)
{
    uint64_t due_ns = ect_esc_due(&chain->twins[i].esc);
    make_ready(chain, i);
    if (due_ns < ect_deadlines_of(chain->deadlines, i))
        ect_deadlines_set(chain->deadlines, i, due_ns);
}

static void mark_touched(ect_chain_t *chain)
{
    size_t count;
    const uint32_t *touched = ect_fast_touched(chain->fast, &count);
    for (size_t k = 0; k < count; k++)
        mark_frame(chain, touched[k]);
}

/* Does work postponed by the fast path. Due before a controller is accessed in any other way. */
static void settle(ect_chain_t *chain)
{
    ect_fast_settle(chain->fast);
    mark_touched(chain);
}

static void powered_on(ect_chain_t *chain, size_t i)
{
    ect_fast_put(chain->fast, i, &chain->twins[i].esc);
    make_ready(chain, i);
}

static bool make_lists(ect_chain_t *chain, size_t count)
{
    chain->fast = ect_fast_new(count);
    chain->deadlines = ect_deadlines_new(count);
    chain->ready = calloc(ect_bits_words(count), sizeof *chain->ready);
    chain->owing = calloc(ect_bits_words(count), sizeof *chain->owing);
    chain->block = calloc(count + 1, sizeof *chain->twins);
    chain->cabling.count = count;
    if (!chain->fast || !chain->deadlines || !chain->ready || !chain->owing || !chain->block)
        return false;
    void *line = (uint8_t *)chain->block + ECT_TWIN_LINE - (uintptr_t)chain->block % ECT_TWIN_LINE;
    chain->twins = chain->cabling.twins = line;
    return true;
}

static bool make_twins(ect_chain_t *chain, const ect_twin_config_t *twins, uint64_t now_ns)
{
    uint8_t *ram = chain->ram;
    uint8_t *buffer = chain->buffers;
    for (size_t i = 0; i < chain->cabling.count; i++) {
        if (!ect_twin_make(&chain->twins[i], &twins[i], ram, buffer, now_ns))
            return false;
        ram += ect_twin_ram_size(&twins[i]);
        buffer += ect_twin_buffer_size(&twins[i]);
        powered_on(chain, i);
    }
    return true;
}

static void slow_delays(const ect_chain_t *chain, bool before)
{
    for (size_t i = 0; i < chain->cabling.count; i++) {
        if (chain->twins[i].slow)
            ect_slow_delays(chain->twins[i].slow, before);
    }
}

static void update_delays(ect_chain_t *chain)
{
    chain->delays_due = false;
    slow_delays(chain, true);
    ect_delays_update(&chain->cabling);
    slow_delays(chain, false);
}

size_t ect_chain_check_wires(const ect_twin_config_t *twins, size_t count)
{
    return ect_cabling_check(twins, count);
}

size_t ect_chain_wire(const ect_chain_t *chain, size_t position, unsigned int *port)
{
    ECT_ASSERT(position < chain->cabling.count);
    const ect_topology_node_t *node = &chain->cabling.nodes[position];
    *port = position == 0 ? 0 : node->up_port;
    return position == 0 ? 0 : node->up + 1;
}

ect_chain_t *ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns)
{
    ECT_ASSERT(count >= 1 && count <= UINT16_MAX);
    ect_chain_t *chain = calloc(1, sizeof *chain);
    if (!chain)
        return NULL;
    chain->links_due = true;
    chain->now_ns = now_ns;
    if (make_lists(chain, count) && make_memory(chain, twins) && ect_cabling_lay(&chain->cabling, twins) &&
        make_twins(chain, twins, now_ns)) {
        update_delays(chain);
        return chain;
    }
    ect_chain_free(chain);
    return NULL;
}

void ect_chain_free(ect_chain_t *chain)
{
    if (!chain)
        return;
    for (size_t i = 0; chain->twins && i < chain->cabling.count; i++)
        ect_twin_free(&chain->twins[i]);
    ect_fast_free(chain->fast);
    ect_deadlines_free(chain->deadlines);
    for (size_t i = 0; chain->kept && i < chain->cabling.count; i++)
        ect_twin_snapshot_free(&chain->kept[i]);
    free(chain->kept);
    ect_cabling_free(&chain->cabling);
    ect_connections_free(chain->connections);
    free(chain->ready);
    free(chain->owing);
    free(chain->ram);
    free(chain->buffers);
    free(chain->block);
    free(chain);
}

void ect_chain_memory(const ect_chain_t *chain, void (*block)(void *ctx, void *at, size_t size), void *ctx)
{
    block(ctx, chain->twins, chain->cabling.count * sizeof *chain->twins);
    block(ctx, chain->ram, chain->ram_size);
}

static void restarted(ect_chain_t *chain, size_t i)
{
    powered_on(chain, i);
    chain->links_due = chain->delays_due = true;
}

void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t i = 0; i < chain->cabling.count; i++) {
        ect_twin_restart(&chain->twins[i], now_ns);
        restarted(chain, i);
    }
}

static void update_links(ect_chain_t *chain)
{
    chain->links_due = false;
    for (size_t i = 0; i < chain->cabling.count; i++) {
        if (!ect_cabling_update(&chain->cabling, i))
            continue;
        ect_fast_refresh(chain->fast, i);
        chain->delays_due = true;
    }
}

void ect_chain_set_link(ect_chain_t *chain, ect_end_t end, bool link)
{
    ECT_ASSERT(end < ECT_END_NONE);
    settle(chain);
    chain->cabling.link[end] = link;
    update_links(chain);
    if (chain->delays_due)
        update_delays(chain);
}

const char *ect_chain_fault(ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns)
{
    const char *why;
    ECT_ASSERT(fault->slave >= 1 && fault->slave <= chain->cabling.count);
    size_t i = fault->slave - 1u;
    settle(chain);
    (void)ect_esc_tick(&chain->twins[i].esc, now_ns);
    if (ect_twin_fault(&chain->twins[i], fault, now_ns, &why))
        restarted(chain, i);
    ect_fast_refresh(chain->fast, i); /* frames may come before the next poll */
    ect_deadlines_set(chain->deadlines, i, now_ns);
    ect_chain_wake(chain, i);
    return why;
}

void ect_chain_fault_end(ect_chain_t *chain, uint32_t tag)
{
    for (size_t i = 0; i < chain->cabling.count; i++) {
        if (chain->twins[i].above)
            ect_above_end(chain->twins[i].above, tag);
    }
}

const ect_fault_t *ect_chain_fault_at(const ect_chain_t *chain, size_t i)
{
    for (size_t n = 0; n < chain->cabling.count; n++) {
        const ect_above_t *above = chain->twins[n].above;
        for (size_t k = 0; above && ect_above_at(above, k); k++) {
            if (i-- == 0)
                return ect_above_at(above, k);
        }
    }
    return NULL;
}

uint64_t ect_chain_fault_seen(const ect_chain_t *chain, uint32_t tag)
{
    uint64_t seen = 0;
    for (size_t i = 0; i < chain->cabling.count; i++)
        seen += chain->twins[i].above ? ect_above_seen(chain->twins[i].above, tag) : 0;
    return seen;
}

void ect_chain_guard(ect_chain_t *chain, ect_guard_t guard, void *ctx)
{
    chain->guard = guard;
    chain->guard_ctx = ctx;
}

/* Handles a frame that may have reached any twin. */
static void mark_all(ect_chain_t *chain)
{
    for (size_t i = 0; i < chain->cabling.count; i++) {
        ect_fast_refresh(chain->fast, i);
        mark_frame(chain, i);
    }
}

static ect_end_t pass_slowly(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    ect_passage_t passage = {.c = {.frame = frame, .length = length},
                             .now_ns = now_ns,
                             .guard = chain->guard,
                             .guard_ctx = chain->guard_ctx};
    chain->guard = NULL;
    settle(chain);
    ect_end_t out = ect_passage_enter(&chain->cabling, in, &passage);
    mark_all(chain);
    return out;
}

ect_end_t ect_chain_resume(ect_chain_t *chain, const ect_crossing_t *from, uint64_t now_ns)
{
    ect_passage_t passage = {.c = *from, .now_ns = now_ns};
    ect_topology_place_t at;
    ect_end_t out;
    chain->now_ns = chain->frame_ns = now_ns;
    if (!ect_passage_arrival(&chain->cabling, from, &at, &out))
        return out;
    settle(chain);
    out = ect_passage_walk(&chain->cabling, at, &passage);
    mark_all(chain);
    return out;
}

/* Runs the ESCs whose deadline has passed: the effect may be visible in frames of other twins. The twins run at the
 * next poll, not in this call, because a frame may be waiting. */
static void tick_due(ect_chain_t *chain, uint64_t now_ns)
{
    size_t i;
    if (ect_deadlines_first(chain->deadlines, &i) <= now_ns)
        settle(chain);
    while (ect_deadlines_first(chain->deadlines, &i) <= now_ns) {
        make_ready(chain, i);
        ect_deadlines_set(chain->deadlines, i, ect_esc_tick(&chain->twins[i].esc, now_ns));
        ect_fast_refresh(chain->fast, i);
    }
}

static uint64_t last_frame(const ect_chain_t *chain, size_t i)
{
    uint64_t slow_ns = chain->twins[i].last_frame_ns;
    return i < chain->fast_reach && chain->fast_frame_ns > slow_ns ? chain->fast_frame_ns : slow_ns;
}

/* Records the last frame in each twin within the reach, before the reach changes. */
static void mark_reach(ect_chain_t *chain, size_t reach)
{
    if (reach == chain->fast_reach)
        return;
    ECT_ASSERT(reach <= chain->cabling.count);
    for (size_t i = 0; i < chain->fast_reach; i++)
        chain->twins[i].last_frame_ns = last_frame(chain, i);
    chain->fast_reach = reach;
}

ect_end_t ect_chain_pass(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    chain->now_ns = chain->frame_ns = now_ns;
    bool plain = chain->cabling.line && in == ECT_END_IN && chain->twins[0].link[0];
    if (!plain || chain->guard)
        return pass_slowly(chain, in, frame, length, now_ns);
    tick_due(chain, now_ns);
    mark_reach(chain, ect_fast_reach(chain->fast));
    ect_fast_result_t result = ect_fast_pass(chain->fast, frame, length, now_ns);
    if (result == ECT_FAST_NOT_TAKEN)
        return pass_slowly(chain, in, frame, length, now_ns);
    chain->fast_frame_ns = now_ns;
    mark_touched(chain);
    return result == ECT_FAST_OUT ? ECT_END_OUT : ECT_END_IN;
}

void ect_chain_pass_replied(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns)
{
    ect_fast_set_unread(chain->fast, true);
    (void)ect_chain_pass(chain, ECT_END_IN, frame, length, now_ns);
    ect_fast_set_unread(chain->fast, false);
}

bool ect_chain_awaits_poll(ect_chain_t *chain, const uint8_t *frame, size_t length)
{
    return ect_fast_meets(chain->fast, frame, length, chain->ready);
}

bool ect_chain_process(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns)
{
    return ect_chain_pass(chain, ECT_END_IN, frame, length, now_ns) == ECT_END_IN;
}

bool ect_chain_steady(ect_chain_t *chain, ect_chain_steady_t *steady)
{
    bool plain = chain->cabling.line && chain->twins[0].link[0] && !chain->guard;
    settle(chain);
    return plain && !chain->links_due && !chain->delays_due && ect_fast_steady(chain->fast, steady);
}

bool ect_chain_visit_mapped(ect_chain_t *chain, uint32_t first, uint16_t length, unsigned int direction,
                            ect_chain_visit_t visit, void *ctx)
{
    return ect_fast_visit_mapped(chain->fast, first, length, direction, visit, ctx);
}

const ect_esc_t *ect_chain_time_source(ect_chain_t *chain, const uint8_t *datagram, bool *takes)
{
    return ect_fast_time_source(chain->fast, datagram, takes);
}

/* A master may configure a pulse every nanosecond. The ESC counts each pulse; the chain limits the rate of wake-ups. */
static void tick_esc(ect_chain_t *chain, ect_twin_t *twin, uint64_t now_ns)
{
    bool woken = now_ns >= twin->esc_ns;
    twin->esc_ns = ect_esc_tick(&twin->esc, now_ns);
    if (woken && twin->esc_ns < now_ns + REST_NS)
        chain->rests_ns = now_ns + REST_NS;
}

/* Runs the slave stack, which keeps its inputs while the chain catches up. @return whether the twin has restarted */
static bool poll_slave(ect_chain_t *chain, size_t i, uint64_t now_ns)
{
    ect_twin_t *twin = &chain->twins[i];
    ect_slave_hold_inputs(&twin->slave, chain->catching_up);
    bool restarted = ect_twin_poll(twin, now_ns);
    if (chain->catching_up && ect_slave_owes_inputs(&twin->slave)) {
        ect_bits_add(chain->owing, i);
        chain->owes = true;
    }
    return restarted;
}

/* Brings a twin up to date and sets its next deadline. */
static void poll_twin(ect_chain_t *chain, size_t i, uint64_t now_ns)
{
    ect_twin_t *twin = &chain->twins[i];
    bool on_bus = ect_twin_on_bus(twin);
    bool polled = twin->seen != ect_esc_activity(&twin->esc) || now_ns >= twin->slave_ns;
    if (polled || now_ns >= ect_esc_due(&twin->esc) || twin->slow)
        tick_esc(chain, twin, now_ns);
    if (twin->slow)
        ect_slow_run(twin->slow, now_ns);
    polled |= twin->seen != ect_esc_activity(&twin->esc);
    if (polled && ect_twin_begins(twin, now_ns) && poll_slave(chain, i, now_ns))
        ect_fast_put(chain->fast, i, &twin->esc);
    ect_twin_report_sii(twin);
    ect_fast_refresh(chain->fast, i);
    chain->links_due |= on_bus != ect_twin_on_bus(twin);
    chain->delays_due |= twin->ports_seen != ect_esc_port_changes(&twin->esc);
    twin->ports_seen = ect_esc_port_changes(&twin->esc);
    ect_deadlines_set(chain->deadlines, i, ect_earlier(ect_twin_next(twin), ect_esc_due(&twin->esc)));
    for (unsigned int n = 0; n < ECT_CHAIN_OBSERVERS; n++) {
        if (chain->observers[n].ran)
            chain->observers[n].ran(chain->observers[n].ctx, i, now_ns);
    }
}

static void poll_ready(ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t word = 0; word < ect_bits_words(chain->cabling.count); word++) {
        uint64_t left = chain->ready[word];
        chain->ready[word] = 0;
        while (left != 0)
            poll_twin(chain, ect_bits_take(word, &left), now_ns);
    }
}

static void wake(void *chain, size_t position)
{
    ect_chain_wake(chain, position);
}

/* Runs the connections repeatedly, because a value may pass through as many twins as there are connections. */
static void run_connections(ect_chain_t *chain, uint64_t now_ns)
{
    for (size_t round = 0; round < chain->connection_count; round++) {
        if (!ect_connections_run(chain->connections, now_ns, wake, chain))
            return;
        poll_ready(chain, now_ns);
    }
}

bool ect_chain_connect(ect_chain_t *chain, const ect_connection_t *list, size_t count)
{
    ect_connections_t *connections = ect_connections_new(list, count);
    if (!connections)
        return false;
    ect_connections_free(chain->connections);
    chain->connections = connections;
    chain->connection_count = count;
    return true;
}

/* Makes held inputs due. */
static void release_inputs(ect_chain_t *chain)
{
    chain->owes = false;
    for (size_t word = 0; word < ect_bits_words(chain->cabling.count); word++) {
        uint64_t left = chain->owing[word];
        chain->owing[word] = 0;
        while (left != 0) {
            size_t i = ect_bits_take(word, &left);
            chain->twins[i].slave_ns = 0;
            make_ready(chain, i);
        }
    }
}

uint64_t ect_chain_catch_up(ect_chain_t *chain, uint64_t now_ns)
{
    chain->catching_up = true;
    uint64_t next_ns = ect_chain_poll(chain, now_ns);
    chain->catching_up = false;
    return next_ns;
}

uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns)
{
    size_t i;
    chain->now_ns = now_ns;
    settle(chain);
    if (chain->owes && !chain->catching_up)
        release_inputs(chain);
    while (ect_deadlines_first(chain->deadlines, &i) <= now_ns) {
        ect_deadlines_set(chain->deadlines, i, ECT_NEVER);
        make_ready(chain, i);
    }
    poll_ready(chain, now_ns);
    run_connections(chain, now_ns);
    if (chain->links_due)
        update_links(chain);
    if (chain->delays_due)
        update_delays(chain);
    uint64_t quiet_ns = chain->frame_ns + ECT_INDICATOR_TRAFFIC_NS; /* the lamps change at that time */
    uint64_t next_ns = ect_later(ect_deadlines_first(chain->deadlines, &i), chain->rests_ns);
    if (chain->connections)
        next_ns = ect_earlier(next_ns, ect_connections_next(chain->connections));
    return chain->frame_ns != 0 && now_ns < quiet_ns ? ect_earlier(next_ns, quiet_ns) : next_ns;
}

void ect_chain_observe(ect_chain_t *chain, ect_chain_observer_t observer,
                       void (*ran)(void *ctx, size_t position, uint64_t now_ns), void *ctx)
{
    ECT_ASSERT(observer < ECT_CHAIN_OBSERVERS);
    chain->observers[observer].ran = ran;
    chain->observers[observer].ctx = ctx;
}

static const ect_twin_t *twin_at(const ect_chain_t *chain, size_t position)
{
    ECT_ASSERT(position < chain->cabling.count);
    return &chain->twins[position];
}

void ect_chain_show_lamps(const ect_chain_t *chain, size_t position)
{
    const ect_twin_t *twin = twin_at(chain, position);
    ect_lamps_update(twin->lamps, &twin->slave, twin->link[0], twin->link[1], last_frame(chain, position),
                     chain->now_ns);
}

bool ect_chain_unfinished(const ect_chain_t *chain)
{
    for (size_t i = 0; i < chain->cabling.count; i++) {
        const ect_plant_t *plant = chain->twins[i].config.plant;
        if (plant && plant->unfinished && plant->unfinished(chain->twins[i].slave.config.instance))
            return true;
    }
    return false;
}

size_t ect_chain_count(const ect_chain_t *chain)
{
    return chain->cabling.count;
}

bool ect_chain_next_signal(const ect_chain_t *chain, size_t position, ect_chain_cursor_t *cursor, ect_signal_ref_t *ref)
{
    const ect_twin_t *twin = twin_at(chain, position);
    ect_chain_show_lamps(chain, position);
    bool found = ect_signals_next(ect_twin_plant(twin), twin->slave.config.instance, &cursor->device, ref) ||
                 ect_signals_next(twin->config.beside.plant, twin->config.beside.instance, &cursor->beside, ref) ||
                 ect_signals_next(&ect_lamps_plant, twin->lamps, &cursor->lamps, ref) ||
                 ect_signals_next(&ect_wiring_plant, (void *)&twin->wiring, &cursor->wiring, ref) ||
                 (position == 0 && ect_signals_next(chain->shown, chain->shown_instance, &cursor->shown, ref));
    if (found)
        ref->twin = ect_names_at(chain->names, position);
    return found;
}

/* Finds a signal whose name begins with the name of a twin. */
static bool is_hidden(const ect_chain_t *chain, const ect_names_t *names, size_t position, char *message)
{
    ect_chain_cursor_t cursor = {0};
    ect_signal_ref_t ref;
    while (ect_chain_next_signal(chain, position, &cursor, &ref)) {
        size_t length = strcspn(ref.name, ".");
        size_t number = ref.name[length] == '.' ? ect_names_find(names, ref.name, length) : 0;
        if (number == 0)
            continue;
        (void)snprintf(message, ECT_SIGNAL_MESSAGE,
                       "the name '%.*s' of twin %zu hides the signal '%s' of twin %zu: choose another name",
                       (int)length, ref.name, number, ref.name, position + 1);
        return true;
    }
    return false;
}

static bool same_signals(const ect_twin_config_t *a, const ect_twin_config_t *b)
{
    return !(a->plant && a->plant->present) && a->plant == b->plant && a->beside.plant == b->beside.plant;
}

bool ect_chain_set_names(ect_chain_t *chain, const ect_names_t *names, char *message)
{
    const char scenario[] = "scenario"; /* signals added later (ect_chain_show) */
    if (ect_names_find(names, scenario, strlen(scenario)) != 0) {
        (void)snprintf(message, ECT_SIGNAL_MESSAGE,
                       "the name 'scenario' hides the signals of a scenario: choose another name");
        return false;
    }
    for (size_t i = 0; names && i < chain->cabling.count; i++) {
        bool known = i > 0 && same_signals(&chain->twins[i].config, &chain->twins[i - 1].config);
        if (!known && is_hidden(chain, names, i, message))
            return false;
    }
    chain->names = names;
    return true;
}

const ect_names_t *ect_chain_names(const ect_chain_t *chain)
{
    return chain->names;
}

bool ect_chain_resolve(const ect_chain_t *chain, size_t *position, const char **name)
{
    size_t length = strcspn(*name, ".");
    size_t number = (*name)[length] == '.' ? ect_names_find(chain->names, *name, length) : 0;
    if (number == 0)
        return false;
    *position = number - 1;
    *name += length + 1;
    return true;
}

bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref)
{
    (void)ect_chain_resolve(chain, &position, &name);
    ect_chain_show_lamps(chain, position);
    bool found = ect_twin_signal(twin_at(chain, position), name, ref) ||
                 (position == 0 && ect_signal_find(chain->shown, chain->shown_instance, name, ref));
    if (found)
        ref->twin = ect_names_at(chain->names, position);
    return found;
}

void ect_chain_show(ect_chain_t *chain, const ect_plant_t *plant, void *instance)
{
    chain->shown = plant;
    chain->shown_instance = instance;
}

const ect_modbus_t *ect_chain_modbus(const ect_chain_t *chain, size_t position, void **instance)
{
    const ect_twin_t *twin = twin_at(chain, position);
    *instance = twin->slave.config.instance;
    return twin->config.plant && !ect_twin_hangs(twin) && ect_twin_on_bus(twin) ? twin->config.plant->modbus : NULL;
}

ect_slave_t *ect_chain_sdo(ect_chain_t *chain, size_t position, const char **why)
{
    ect_twin_t *twin = &chain->twins[position];
    ECT_ASSERT(position < chain->cabling.count);
    const ect_protocol_t *const *protocol = twin->config.device->protocols;
    while (protocol && *protocol && *protocol != &ect_protocol_sdo)
        protocol++;
    *why = !protocol || !*protocol  ? "its device has no object dictionary"
           : !ect_twin_on_bus(twin) ? "it is switched off"
           : ect_twin_hangs(twin)   ? "its microcontroller hangs: 'resume' continues it"
                                    : NULL;
    return *why ? NULL : &twin->slave;
}

ect_bulk_t ect_chain_bulk(const ect_chain_t *chain, size_t position)
{
    const ect_twin_t *twin = twin_at(chain, position);
    const ect_plant_t *plant = twin->config.plant;
    return plant && plant->bulk ? plant->bulk(twin->slave.config.instance) : (ect_bulk_t){0};
}

bool ect_chain_keep(ect_chain_t *chain, size_t position)
{
    if (!chain->kept)
        chain->kept = calloc(chain->cabling.count, sizeof *chain->kept);
    return chain->kept && ect_twin_save(twin_at(chain, position), &chain->kept[position]);
}

void ect_chain_put_back(ect_chain_t *chain, size_t position)
{
    ECT_ASSERT(position < chain->cabling.count && chain->kept);
    ect_twin_restore(&chain->twins[position], &chain->kept[position]);
}

void ect_chain_wake(ect_chain_t *chain, size_t position)
{
    ECT_ASSERT(position < chain->cabling.count);
    ect_slave_wake(&chain->twins[position].slave);
    chain->twins[position].slave_ns = 0;
    chain->links_due |= ect_cabling_changed(&chain->cabling, position);
    make_ready(chain, position);
}

const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position)
{
    return &twin_at(chain, position)->slave;
}

size_t ect_chain_find_alias(const ect_chain_t *chain, uint16_t alias)
{
    for (size_t i = 0; i < chain->cabling.count; i++) {
        const ect_twin_t *twin = &chain->twins[i];
        const ect_slave_config_t *config = &twin->slave.config;
        const uint16_t id = config->switches != 0 ? config->switches : config->device_id;
        if (id == alias || ect_load_le16(twin->esc.memory + ECT_REG_STATION_ALIAS) == alias)
            return i + 1;
    }
    return 0;
}

ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position)
{
    ECT_ASSERT(position < chain->cabling.count);
    settle(chain);
    make_ready(chain, position);
    return &chain->twins[position].esc;
}
