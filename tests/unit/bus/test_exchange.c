/* SPDX-License-Identifier: MIT */
/* Frames and time through a chain (src/bus/exchange.h): each fate of a frame, the order of the replies, the times at
 * which the devices run. The clock is the test's. */
#define _GNU_SOURCE
#include "bus/exchange.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/testdev.h"
#include "support/wire.h"

#define US       1000ull
#define START_NS (1000 * MS)

enum { TWINS = 2, LOG = 512, INDEX_AT = 17, MOST_TICKS = 256 };

typedef struct rig {
    wire_t w;
    ect_scenario_t s;
    ect_exchange_t x;
    uint64_t clock_ns, clock_step_ns; /* the second is added by each read of the clock */
    unsigned int clock_reads;
    unsigned int before, after; /* calls of the filter */
    bool filter_changes;
    char log[LOG]; /* replies: "<1" frame 1 at the input of the chain, ">1" at its output */
} rig_t;

/* The times at which the first twin ran, and the time that it asks for next. */
static struct {
    uint64_t period_ns; /* 0: it asks for no time */
    uint64_t at_ns[MOST_TICKS];
    size_t count;
} ticks;

static uint64_t tick(void *instance, uint64_t now_ns)
{
    (void)instance;
    if (ticks.count < MOST_TICKS)
        ticks.at_ns[ticks.count++] = now_ns;
    return ticks.period_ns != 0 ? now_ns + ticks.period_ns : ECT_NEVER;
}

static uint64_t read_clock(void *ctx)
{
    rig_t *r = ctx;
    r->clock_reads++;
    r->clock_ns += r->clock_step_ns;
    return r->clock_ns;
}

static void send(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    rig_t *r = ctx;
    size_t used = strlen(r->log);
    assert_true(length > INDEX_AT);
    snprintf(r->log + used, LOG - used, "%c%u", end == ECT_END_IN ? '<' : '>', frame[INDEX_AT]);
}

static void before(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length)
{
    rig_t *r = ctx;
    (void)length;
    assert_ptr_equal(chain, r->w.chain);
    r->before++;
    if (r->filter_changes)
        frame[INDEX_AT] = (uint8_t)(frame[INDEX_AT] + 10);
}

static void after(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length)
{
    rig_t *r = ctx;
    (void)length;
    assert_ptr_equal(chain, r->w.chain);
    r->after++;
    if (r->filter_changes)
        frame[INDEX_AT] = (uint8_t)(frame[INDEX_AT] + 100);
}

static int setup(void **state)
{
    static ect_device_t clocked;
    rig_t *r = calloc(1, sizeof *r);
    clocked = testdev;
    clocked.tick = tick;
    const ect_device_t *devices[TWINS] = {&clocked, &testdev};
    memset(&ticks, 0, sizeof ticks);
    wire_open(&r->w, devices, TWINS);
    ticks.count = 0;
    r->clock_ns = START_NS;
    r->s.seed = 7;
    r->x = (ect_exchange_t){.chain = r->w.chain, .scenario = &r->s, .send = send, .clock = read_clock, .ctx = r};
    ect_exchange_start(&r->x);
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    ect_exchange_end(&r->x);
    wire_close(&r->w);
    free(r);
    return 0;
}

static void set_fault(rig_t *r, const char *text)
{
    char message[ECT_FAULT_MESSAGE];
    ect_fault_t fault;
    if (!ect_fault_parse(text, &fault, message) || !ect_scenario_set(&r->s, r->w.chain, &fault, r->clock_ns, message))
        fail_msg("'%s': %s", text, message);
}

static void pass(rig_t *r, ect_end_t in, uint8_t index)
{
    const ect_packet_time_t time = {.now_ns = r->clock_ns};
    wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
    r->w.frame[INDEX_AT] = index;
    ect_exchange_frame(&r->x, in, r->w.frame, r->w.frame_length, &time);
}

/* The replies since the last call. */
static void expect_log(rig_t *r, const char *want)
{
    assert_string_equal(r->log, want);
    r->log[0] = 0;
}

static uint64_t run_at(rig_t *r, uint64_t now_ns)
{
    r->clock_ns = now_ns;
    return ect_exchange_run(&r->x);
}

/* Nothing is due but the end of a twin's PDI watchdog, 100 ms after it last ran. */
static void expect_rest(const rig_t *r, uint64_t next_ns)
{
    assert_in_range(next_ns, r->clock_ns + 90 * MS, r->clock_ns + 100 * MS);
}

static uint64_t in_histogram(const rig_t *r)
{
    uint64_t sum = 0;
    for (size_t step = 0; step < ECT_STATS_STEPS; step++)
        sum += r->x.stats.answers[step];
    return sum;
}

/* --- the fate of a frame ------------------------------------------------------------------------------------------ */

static void fates(void **state)
{
    static const struct {
        const char *fault, *log;
        unsigned int answered, unanswered, dropped, delayed;
    } rows[] = {
        {NULL, "<1", 1, 0, 0, 0},
        {"duplicate", "<1<1", 1, 0, 0, 0},
        {"counter -1", "<1", 1, 0, 0, 0},
        {"reorder", "", 0, 0, 0, 0},
        {"delay 1000us", "", 0, 0, 0, 1},
        {"truncate 20", "", 0, 1, 0, 0},
        {"drop wire 1", "", 0, 0, 1, 0},
        {"drop wire 2 back", "", 0, 0, 1, 0},
        {"damage wire 1", "", 0, 1, 0, 0},
        {"delay 1000us wire 1", "", 0, 0, 0, 1},
        {"delay 1000us wire 2 back", "", 0, 0, 0, 1},
        {"reorder wire 2", "", 0, 0, 0, 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        if (rows[i].fault)
            set_fault(r, rows[i].fault);
        pass(r, ECT_END_IN, 1);
        const ect_stats_t *s = &r->x.stats;
        if (strcmp(r->log, rows[i].log) != 0 || s->answered != rows[i].answered ||
            s->unanswered != rows[i].unanswered || s->dropped != rows[i].dropped || s->delayed != rows[i].delayed)
            fail_msg("%s: sent '%s', answered %u unanswered %u dropped %u delayed %u",
                     rows[i].fault ? rows[i].fault : "none", r->log, (unsigned int)s->answered,
                     (unsigned int)s->unanswered, (unsigned int)s->dropped, (unsigned int)s->delayed);
        assert_int_equal(in_histogram(r), rows[i].answered);
        assert_int_equal(s->frames, 0);
        teardown(state);
    }
}

static void without_a_scenario(void **state)
{
    rig_t *r = *state;
    r->x.scenario = NULL;
    pass(r, ECT_END_IN, 1);
    expect_log(r, "<1");
    expect_rest(r, run_at(r, START_NS + 1));
}

/* A request that is lost reaches neither the filter nor the chain; one whose reply is lost does. */
static void lost_on_both_ways(void **state)
{
    enum { FRAMES = 40 };
    static const bool links[] = {true, false};
    for (size_t i = 0; i < sizeof links / sizeof links[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        const ect_filter_t filter = {before, after, r};
        r->x.filter = &filter;
        set_fault(r, "drop");
        ect_chain_set_link(r->w.chain, ECT_END_IN, links[i]);
        for (uint8_t n = 0; n < FRAMES; n++)
            pass(r, ECT_END_IN, n);
        const ect_stats_t *s = &r->x.stats;
        expect_log(r, "");
        assert_in_range(r->before, FRAMES / 4, 3 * FRAMES / 4);
        assert_int_equal(r->after, links[i] ? r->before : 0);
        assert_int_equal(s->dropped, links[i] ? FRAMES : FRAMES - r->before);
        assert_int_equal(s->unanswered, links[i] ? 0 : r->before);
        assert_int_equal(s->answered, 0);
        teardown(state);
    }
}

static void filtered(void **state)
{
    rig_t *r = *state;
    const ect_filter_t filter = {before, after, r};
    r->x.filter = &filter;
    r->filter_changes = true;
    pass(r, ECT_END_IN, 1);
    expect_log(r, "<111");
    ect_chain_set_link(r->w.chain, ECT_END_OUT, true);
    pass(r, ECT_END_IN, 2);
    expect_log(r, ">112");
    set_fault(r, "damage wire 2");
    pass(r, ECT_END_IN, 3);
    expect_log(r, "");
    assert_int_equal(r->before, 3);
    assert_int_equal(r->after, 2);
}

static void too_long(void **state)
{
    static uint8_t frame[2048];
    rig_t *r = *state;
    memset(frame, 0xFF, sizeof frame);
    ticks.period_ns = 10 * MS;
    (void)run_at(r, START_NS);
    ticks.count = 0;
    ect_exchange_long_frame(&r->x, ECT_END_IN, frame, sizeof frame, START_NS + 3 * US);
    expect_log(r, "");
    assert_int_equal(r->x.stats.unanswered, 1);
    assert_int_equal(r->x.stats.answered, 0);
    assert_true(r->x.polled_ns == START_NS + 3 * US);
    assert_true(r->x.touched_ns == START_NS + 3 * US);
    assert_true(wire_read8(&r->w, 0, 0x0300) != 0); /* port 0 has counted it */
}

/* --- order -------------------------------------------------------------------------------------------------------- */

static void orders(void **state)
{
    static const struct {
        const char *faults[2];
        unsigned int frames;
        const char *log;
        unsigned int answered, in_histogram;
    } rows[] = {
        {{"reorder frame 1", NULL}, 2, "<2<1", 2, 1},
        {{"reorder frame 1", "reorder frame 2"}, 3, "<3<1<2", 3, 1},
        {{"reorder frame 1", "duplicate frame 2"}, 2, "<2<2<1", 2, 1},
        {{"reorder frame 1", "duplicate frame 1"}, 2, "<2<1<1", 3, 1},
        {{"reorder frame 1", "drop frame 1 wire 1"}, 2, "<2", 1, 1},
        {{"reorder frame 2", NULL}, 4, "<1<3<2<4", 4, 3},
        {{"reorder frame 1 wire 2", NULL}, 3, "<2<1<3", 3, 2},
        {{"reorder frame 1", "reorder frame 2 wire 1"}, 4, "<3<1<2<4", 4, 2},
        {{"duplicate frame 1 wire 2", NULL}, 2, "<1<1<2", 3, 2},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        for (size_t n = 0; n < 2 && rows[i].faults[n]; n++)
            set_fault(r, rows[i].faults[n]);
        for (uint8_t n = 1; n <= rows[i].frames; n++)
            pass(r, ECT_END_IN, n);
        if (strcmp(r->log, rows[i].log) != 0 || r->x.stats.answered != rows[i].answered ||
            in_histogram(r) != rows[i].in_histogram)
            fail_msg("row %zu: sent '%s', answered %u, %u in the histogram", i, r->log,
                     (unsigned int)r->x.stats.answered, (unsigned int)in_histogram(r));
        teardown(state);
    }
}

/* The last one of a master that waits for it. */
static void behind_none(void **state)
{
    rig_t *r = *state;
    set_fault(r, "reorder");
    pass(r, ECT_END_IN, 1);
    assert_true(ect_exchange_run(&r->x) <= r->clock_ns + 10 * MS);
    (void)run_at(r, r->clock_ns + 10 * MS - 1);
    expect_log(r, "");
    (void)run_at(r, r->clock_ns + 1);
    expect_log(r, "<1");
    assert_int_equal(r->x.stats.answered, 1);
}

static void late_and_twice(void **state)
{
    static const struct {
        const char *faults[2], *log;
    } rows[] = {
        {{"delay 1000us frame 1", "duplicate frame 1"}, "<1<1<2"},
        {{"delay 1000us frame 1", "duplicate frame 2"}, "<1<2<2"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        set_fault(r, rows[i].faults[0]);
        set_fault(r, rows[i].faults[1]);
        pass(r, ECT_END_IN, 1);
        pass(r, ECT_END_IN, 2);
        expect_log(r, "");
        (void)run_at(r, r->clock_ns + 1 * MS);
        expect_log(r, rows[i].log);
        assert_int_equal(r->x.stats.delayed, 3);
        assert_int_equal(r->x.stats.answered, 3);
        teardown(state);
    }
}

static void late_order(void **state)
{
    rig_t *r = *state;
    set_fault(r, "delay 1000us frame 1");
    pass(r, ECT_END_IN, 1);
    r->clock_ns += 100 * US;
    pass(r, ECT_END_IN, 2); /* has no fault, but does not overtake */
    expect_log(r, "");
    assert_int_equal(r->x.stats.delayed, 2);
    assert_true(run_at(r, START_NS + 999 * US) == START_NS + 1 * MS);
    assert_true(run_at(r, START_NS + 1 * MS - 1) == START_NS + 1 * MS);
    expect_log(r, "");
    assert_int_equal(r->x.stats.answered, 0);
    expect_rest(r, run_at(r, START_NS + 1 * MS));
    expect_log(r, "<1<2");
    assert_int_equal(r->x.stats.answered, 2);
    assert_int_equal(in_histogram(r), 0);
    pass(r, ECT_END_IN, 3);
    expect_log(r, "<3");
    assert_int_equal(r->x.stats.delayed, 2);
}

static void late_at_both_ends(void **state)
{
    rig_t *r = *state;
    ect_chain_set_link(r->w.chain, ECT_END_OUT, true);
    set_fault(r, "delay 3000us frame 1");
    set_fault(r, "delay 1000us frame 2");
    pass(r, ECT_END_IN, 1);
    pass(r, ECT_END_OUT, 2);
    pass(r, ECT_END_OUT, 3);
    expect_log(r, "");
    assert_int_equal(r->x.stats.delayed, 3);
    assert_true(run_at(r, START_NS) == START_NS + 1 * MS);
    assert_true(run_at(r, START_NS + 1 * MS) == START_NS + 3 * MS);
    expect_log(r, "<2<3");
    pass(r, ECT_END_OUT, 4); /* nothing waits at this end any more */
    expect_log(r, "<4");
    assert_true(ect_exchange_run(&r->x) == START_NS + 3 * MS); /* at the time of the reply */
    expect_rest(r, run_at(r, START_NS + 3 * MS));
    expect_log(r, ">1");
}

static void most(void **state)
{
    static const struct {
        const char *fault;
        bool late;
        unsigned int delayed, dropped;
        size_t kept;
    } rows[] = {
        {"delay 1000us", true, 1, 0, ECT_LATE_MOST - 1},
        {"delay 1000us", true, 0, 1, ECT_LATE_MOST},
        {"reorder", false, 0, 0, ECT_LATE_MOST - 1},
        {"reorder", false, 0, 1, ECT_LATE_MOST},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        ect_late_t *late = rows[i].late ? r->x.late : r->x.behind;
        for (size_t n = 0; n < rows[i].kept; n++)
            assert_true(ect_late_add(&late[ECT_END_IN], (const uint8_t *)"x", 1, ECT_NEVER));
        set_fault(r, rows[i].fault);
        pass(r, ECT_END_IN, 1);
        assert_int_equal(r->x.stats.delayed, rows[i].delayed);
        assert_int_equal(r->x.stats.dropped, rows[i].dropped);
        assert_int_equal(late[ECT_END_IN].count, ECT_LATE_MOST);
        teardown(state);
    }
}

/* --- frames kept on a wire ---------------------------------------------------------------------------------------- */

static void kept_on_a_wire(void **state)
{
    rig_t *r = *state;
    set_fault(r, "delay 1000us frame 1 wire 2");
    pass(r, ECT_END_IN, 1);
    assert_true(run_at(r, START_NS + 1) == START_NS + 1 * MS);
    assert_true(run_at(r, START_NS + 1 * MS - 1) == START_NS + 1 * MS);
    expect_log(r, "");
    assert_int_equal(r->x.stats.answered, 0);
    expect_rest(r, run_at(r, START_NS + 1 * MS));
    expect_log(r, "<1");
    assert_int_equal(r->x.stats.answered, 1);
    assert_int_equal(r->x.stats.delayed, 1);
    assert_int_equal(in_histogram(r), 0);
}

static void kept_behind_late(void **state)
{
    rig_t *r = *state;
    set_fault(r, "delay 1000us frame 1 wire 1");
    pass(r, ECT_END_IN, 1);
    pass(r, ECT_END_IN, 2); /* waits for frame 1 on the wire, and its delay is without effect there */
    assert_int_equal(r->x.stats.delayed, 2);
    assert_true(ect_late_add(&r->x.late[ECT_END_IN], r->w.frame, r->w.frame_length, START_NS + 5 * MS));
    (void)run_at(r, START_NS + 1 * MS);
    expect_log(r, "");
    assert_int_equal(r->x.stats.delayed, 4);
    assert_int_equal(r->x.stats.answered, 0);
    expect_rest(r, run_at(r, START_NS + 5 * MS));
    expect_log(r, "<2<1<2");
    assert_int_equal(r->x.stats.answered, 3);
}

static void note_first_run(void *ctx, size_t position, uint64_t now_ns)
{
    uint64_t *first_ns = ctx;
    if (position == 0 && *first_ns == 0)
        *first_ns = now_ns;
}

/* The clock goes on between the release and the run. */
static void devices_at_a_release(void **state)
{
    rig_t *r = *state;
    set_fault(r, "delay 1000us frame 1 wire 1");
    pass(r, ECT_END_IN, 1);
    (void)run_at(r, START_NS + 1);
    uint64_t first_ns = 0;
    ect_chain_observe(r->w.chain, ECT_CHAIN_CLIENTS, note_first_run, &first_ns);
    r->clock_step_ns = 10 * US;
    (void)run_at(r, START_NS + 1 * MS - r->clock_step_ns);
    expect_log(r, "<1");
    assert_true(first_ns == START_NS + 1 * MS);
}

static void kept_without_an_end(void **state)
{
    rig_t *r = *state;
    set_fault(r, "delay 1000us frame 1 wire 2");
    pass(r, ECT_END_IN, 1);
    ect_chain_set_link(r->w.chain, ECT_END_IN, false);
    expect_rest(r, run_at(r, START_NS + 1 * MS));
    expect_log(r, "");
    assert_int_equal(r->x.stats.answered, 0);
    assert_int_equal(r->s.wires.kept_count, 0);
}

/* --- time --------------------------------------------------------------------------------------------------------- */

static void response_times(void **state)
{
    static const struct {
        uint64_t waited_ns, clock_step_ns, longest_ns;
        size_t step;
    } rows[] = {
        {0, 0, 0, 0},
        {0, 999, 999, 0},
        {1 * US, 0, 1 * US, 1},
        {3 * US, 4 * US, 7 * US, 3},
        {600 * US, 400 * US, 1 * MS, 10},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        const ect_packet_time_t time = {.now_ns = START_NS, .waited_ns = rows[i].waited_ns};
        r->clock_step_ns = rows[i].clock_step_ns;
        wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
        ect_exchange_frame(&r->x, ECT_END_IN, r->w.frame, r->w.frame_length, &time);
        assert_true(r->x.stats.longest_answer_ns == rows[i].longest_ns);
        assert_int_equal(r->x.stats.answers[rows[i].step], 1);
        teardown(state);
    }
}

/* The clock is read once a reply: the next run uses the time at which the reply left. */
static void clock_reads(void **state)
{
    rig_t *r = *state;
    r->clock_reads = 0;
    pass(r, ECT_END_IN, 1);
    (void)ect_exchange_run(&r->x);
    assert_int_equal(r->clock_reads, 1);
    assert_true(r->x.run_ns == START_NS);
    (void)run_at(r, START_NS + 7 * US);
    assert_int_equal(r->clock_reads, 2);
    assert_true(r->x.run_ns == START_NS + 7 * US);
    set_fault(r, "delay 1us");
    pass(r, ECT_END_IN, 2);
    (void)run_at(r, START_NS + 9 * US); /* no reply has left: the clock is read */
    assert_true(r->x.run_ns == START_NS + 9 * US);
}

/* The frame's own time may be later than the clock's last value; time does not decrease for the devices. */
static void never_back(void **state)
{
    rig_t *r = *state;
    const ect_packet_time_t time = {.now_ns = START_NS + 5 * US};
    r->clock_ns = START_NS + 2 * US;
    wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
    ect_exchange_frame(&r->x, ECT_END_IN, r->w.frame, r->w.frame_length, &time);
    (void)ect_exchange_run(&r->x);
    assert_true(r->x.run_ns == START_NS + 5 * US);
    assert_true(r->x.polled_ns == START_NS + 5 * US);
}

/* A late caller runs the devices at each time that they have requested, at most 64 times in succession, and then at its
 * own time. */
static void catches_up(void **state)
{
    static const struct {
        uint64_t late_ns; /* after the deadline */
        size_t runs;
        uint64_t last_ns, next_ns; /* after the first deadline */
        unsigned int late_polls;
    } rows[] = {
        {0, 1, 0, 1000 * US, 0},
        {1, 1, 0, 1000 * US, 0},
        {999 * US, 1, 0, 1000 * US, 0},
        {1000 * US, 2, 1000 * US, 2000 * US, 0},
        {1001 * US, 2, 1000 * US, 2000 * US, 1},
        {62000 * US, 63, 62000 * US, 63000 * US, 1},
        {63000 * US, 64, 63000 * US, 64000 * US, 1},
        {63001 * US, 64, 63001 * US, 64001 * US, 1},
        {90000 * US, 64, 90000 * US, 91000 * US, 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        ticks.period_ns = 1000 * US;
        pass(r, ECT_END_IN, 1);
        ect_chain_wake(r->w.chain, 0);
        const uint64_t deadline_ns = START_NS + 1 * MS;
        assert_true(run_at(r, START_NS) == deadline_ns);
        ticks.count = 0;
        const uint64_t next_ns = run_at(r, deadline_ns + rows[i].late_ns);
        if (ticks.count != rows[i].runs || ticks.at_ns[ticks.count - 1] != deadline_ns + rows[i].last_ns ||
            next_ns != deadline_ns + rows[i].next_ns || r->x.stats.late_polls != rows[i].late_polls)
            fail_msg("late by %u ns: %zu runs, the last after %lld ns, next after %lld ns, %u late",
                     (unsigned int)rows[i].late_ns, ticks.count,
                     (long long)(ticks.at_ns[ticks.count - 1] - deadline_ns), (long long)(next_ns - deadline_ns),
                     (unsigned int)r->x.stats.late_polls);
        for (size_t n = 0; n + 1 < ticks.count; n++)
            assert_true(ticks.at_ns[n] == deadline_ns + n * MS);
        assert_int_equal(r->x.stats.polls, 2);
        assert_true(r->x.stats.latest_poll_ns == rows[i].late_ns);
        assert_true(r->x.polled_ns == deadline_ns + rows[i].last_ns);
        assert_true(r->x.run_ns == deadline_ns + rows[i].late_ns);
        teardown(state);
    }
}

/* The devices run at the time of a frame or of a client, before any later time. */
static void touched(void **state)
{
    static const bool by_frame[] = {true, false};
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        ticks.period_ns = 10 * MS;
        pass(r, ECT_END_IN, 1);
        ect_chain_wake(r->w.chain, 0);
        (void)run_at(r, START_NS);
        ticks.count = 0;
        r->clock_ns = START_NS + 4 * US;
        if (by_frame[i]) {
            set_fault(r, "drop wire 2 back");
            pass(r, ECT_END_IN, 2);
        } else {
            assert_true(ect_exchange_touch(&r->x) == START_NS + 4 * US);
        }
        assert_true(r->x.polled_ns == START_NS + 4 * US);
        ect_chain_wake(r->w.chain, 0);
        (void)run_at(r, START_NS + 9 * US);
        assert_true(ticks.count > 0);
        assert_true(ticks.at_ns[0] == START_NS + 4 * US);
        assert_true(r->x.touched_ns == ECT_NEVER);
        teardown(state);
    }
}

/* A frame after a deadline: the devices run for both at the time of the frame, not before it. */
static void frame_after_a_deadline(void **state)
{
    rig_t *r = *state;
    ticks.period_ns = 1 * MS;
    pass(r, ECT_END_IN, 1);
    ect_chain_wake(r->w.chain, 0);
    assert_true(run_at(r, START_NS) == START_NS + 1 * MS);
    ticks.count = 0;
    set_fault(r, "drop wire 2 back");
    r->clock_ns = START_NS + 1500 * US;
    pass(r, ECT_END_IN, 2);
    assert_true(run_at(r, START_NS + 1600 * US) == START_NS + 2500 * US);
    assert_int_equal(ticks.count, 1);
    assert_true(ticks.at_ns[0] == START_NS + 1500 * US);
    assert_true(r->x.stats.latest_poll_ns == 600 * US);
}

static void scripted(void **state)
{
    char message[ECT_FAULT_MESSAGE];
    rig_t *r = *state;
    expect_rest(r, run_at(r, START_NS));
    assert_true(ect_scenario_read(&r->s, "at 0.002s delay 1000us", message));
    assert_true(run_at(r, START_NS) == START_NS + 2 * MS);
    pass(r, ECT_END_IN, 1);
    expect_log(r, "<1");
    r->clock_ns = START_NS + 1 * MS;
    assert_true(ect_exchange_run(&r->x) == START_NS + 2 * MS);
    expect_rest(r, run_at(r, START_NS + 2 * MS));
    pass(r, ECT_END_IN, 2);
    expect_log(r, "");
    assert_true(run_at(r, START_NS + 2 * MS) == START_NS + 3 * MS);
    set_fault(r, "off");
    expect_rest(r, run_at(r, START_NS + 3 * MS));
    expect_log(r, "<2");
}

/* A late run plays the rows of eight times, and asks to run again at once. */
static void late_rows(void **state)
{
    enum { ROWS = 20 };
    static const char *const name = "ecat.drift";
    static const char *const value = "5";
    static const uint64_t due_ms[] = {9, 17};
    rig_t *r = *state;
    ect_table_t *table = ect_table_new(1, &name, 1);
    for (unsigned int i = 1; i <= ROWS; i++)
        assert_true(ect_table_add(table, i * MS, &value));
    r->s.tables = table;
    set_fault(r, "drop 0%");
    (void)run_at(r, START_NS);
    assert_true(ect_table_due(table) == MS);
    for (unsigned int i = 0; i < 2; i++) {
        assert_true(run_at(r, START_NS + 50 * MS) <= START_NS + 50 * MS);
        assert_true(ect_table_due(table) == due_ms[i] * MS);
    }
    assert_true(run_at(r, START_NS + 50 * MS) > START_NS + 50 * MS);
    assert_true(ect_table_due(table) == ECT_NEVER);
    r->s.tables = NULL;
    ect_table_free(table);
}

/* A scenario of faults alone has no steps. */
static void progress_of_steps(void **state)
{
    rig_t *r = *state;
    char message[ECT_FAULT_MESSAGE];
    ect_signal_ref_t ref;
    set_fault(r, "drop 0%");
    ect_exchange_start(&r->x);
    assert_false(ect_chain_signal(r->w.chain, 0, "scenario.line", &ref));
    assert_true(ect_scenario_read(&r->s, "at 100ms drop 0%", message));
    ect_exchange_start(&r->x);
    assert_true(ect_chain_signal(r->w.chain, 0, "scenario.line", &ref));
    r->x.scenario = NULL;
}

static void begins_and_ends(void **state)
{
    rig_t *r = *state;
    static const uint8_t kept[20] = {0};
    r->x.stats.frames = 5;
    r->clock_ns = START_NS + 8 * MS;
    ect_exchange_start(&r->x);
    assert_true(r->x.stats.start_ns == START_NS + 8 * MS);
    assert_int_equal(r->x.stats.frames, 5);
    assert_true(r->x.deadline_ns == ECT_NEVER);
    assert_true(r->x.touched_ns == ECT_NEVER);
    set_fault(r, "delay 1us wire 1");
    pass(r, ECT_END_IN, 1);
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        assert_true(ect_late_add(&r->x.late[end], kept, sizeof kept, 0));
        assert_true(ect_late_add(&r->x.behind[end], kept, sizeof kept, 0));
    }
    assert_non_null(r->s.wires.kept);
    ect_exchange_end(&r->x);
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        assert_int_equal(r->x.late[end].count, 0);
        assert_int_equal(r->x.behind[end].count, 0);
    }
    assert_null(r->s.wires.kept);
    expect_log(r, "");
}

#define TEST(title, function)  {title, function, setup, teardown, NULL}
#define TABLE(title, function) {title, function, NULL, NULL, NULL}

/* --- replies in the kernel ---------------------------------------------------------------------------------------- */

static void replied_before(void **state)
{
    rig_t *r = *state;
    run_at(r, r->clock_ns);
    wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
    r->clock_ns += 5 * MS;
    uint64_t came_ns = r->clock_ns - 2 * MS;
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, came_ns, 1500);
    expect_log(r, "");
    assert_int_equal(wire_wkc(&r->w, 0), TWINS);
    assert_int_equal(r->x.stats.frames, 1);
    assert_int_equal(r->x.stats.answered, 1);
    assert_int_equal(r->x.stats.in_kernel, 1);
    assert_int_equal(r->x.stats.kernel_answers[1], 1);
    assert_int_equal(r->x.stats.longest_kernel_ns, 1500);
    assert_int_equal(in_histogram(r), 0);
    assert_int_equal(r->x.touched_ns, came_ns);
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, came_ns - 1, 1500);
    assert_int_equal(r->x.touched_ns, came_ns); /* time does not go back */
}

/* The devices run first only if their time was over when the frame came. */
static void replied_at_a_deadline(void **state)
{
    rig_t *r = *state;
    run_at(r, r->clock_ns);
    wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
    for (unsigned int after_ns = 0; after_ns < 3; after_ns++) {
        r->clock_ns += 5 * MS;
        const uint64_t deadline_ns = r->clock_ns + 1 - after_ns;
        r->x.deadline_ns = deadline_ns;
        r->x.touched_ns = ECT_NEVER;
        ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, r->clock_ns, 1500);
        if ((r->x.deadline_ns != deadline_ns) != (after_ns == 2))
            fail_msg("%d ns after the deadline: expected the devices to %s", (int)after_ns - 1,
                     after_ns == 2 ? "run" : "wait");
    }
}

/* An LRW of the first twin's process data, 3 bytes out and 3 in. */
static void build_cycle(rig_t *r, uint16_t outputs)
{
    uint8_t data[6] = {1};
    ect_store_le16(data + 1, outputs);
    wire_build(&r->w, LRW, 0x100, 0, data, sizeof data);
}

/* Maps the process data of a twin: 3 bytes out from a logical address on, and 3 in behind them. */
static void operate_at(rig_t *r, size_t position, uint16_t logical)
{
    wire_go(&r->w, position, 8);
    wire_set_fmmu(&r->w, position, 0, logical, 3, 0, 7, 0x1200, 0, 2);
    wire_set_fmmu(&r->w, position, 1, logical + 3u, 3, 0, 7, 0x1300, 0, 1);
    (void)wire_outputs(&r->w, position, 0);
    wire_go(&r->w, position, 8);
    assert_int_equal(wire_al(&r->w, position, 8, NULL), 8);
    run_at(r, r->w.now_ns);
}

static void operate(rig_t *r)
{
    operate_at(r, 0, 0x100);
}

static void held_up(void **state)
{
    rig_t *r = *state;
    uint8_t inputs[3];
    operate(r);
    testdev_t *d = testdev_of(&r->w, 0);
    const unsigned int outputs = d->outputs_calls, shown = d->inputs_calls;
    const uint64_t start_ns = r->clock_ns;
    r->clock_ns += 300 * MS; /* the watchdog of the outputs is 100 ms */
    for (unsigned int n = 1; n <= 299; n++) {
        build_cycle(r, (uint16_t)n);
        ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, start_ns + n * MS, 1500);
        assert_int_equal(wire_wkc(&r->w, 0), 3);
        assert_int_equal(d->out_u16, n - 1);
        assert_int_equal(d->inputs_calls, shown); /* the master has read the former image */
        d->in_u16 = (uint16_t)n;
    }
    (void)ect_exchange_run(&r->x);
    assert_int_equal(d->out_u16, 299);
    assert_int_equal(d->outputs_calls, outputs + 299);
    assert_int_equal(d->inputs_calls, shown + 1);
    r->w.now_ns = r->clock_ns;
    assert_int_equal(wire_logical(&r->w, LRD, 0x103, inputs, 3), 1);
    assert_int_equal(ect_load_le16(inputs), 299);
    assert_int_equal(wire_al(&r->w, 0, 8, NULL), 8);
}

/* An LRW of the process data of a twin, whose reply the kernel has sent some nanoseconds after the last one. */
static void replied_cycle(rig_t *r, uint16_t logical, uint16_t outputs)
{
    uint8_t data[6] = {1};
    ect_store_le16(data + 1, outputs);
    wire_build(&r->w, LRW, logical, 0, data, sizeof data);
    r->clock_ns += 100;
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, r->clock_ns, 1500);
}

/* A cycle of several frames: no device misses outputs, and none runs twice. */
static void run_together(void **state)
{
    rig_t *r = *state;
    operate_at(r, 0, 0x100);
    operate_at(r, 1, 0x200);
    const testdev_t *d[TWINS] = {testdev_of(&r->w, 0), testdev_of(&r->w, 1)};
    const unsigned int outputs[TWINS] = {d[0]->outputs_calls, d[1]->outputs_calls};
    const struct {
        uint16_t logical, value;
        unsigned int calls[TWINS]; /* of the devices' outputs since the beginning, before the frame passes */
    } rows[] = {
        {0x100, 1, {0, 0}}, {0x200, 2, {0, 0}}, {0x100, 3, {1, 1}},
        {0x200, 4, {1, 1}}, {0x200, 5, {2, 2}}, {0x100, 6, {2, 2}},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        replied_cycle(r, rows[i].logical, rows[i].value);
        for (size_t n = 0; n < TWINS; n++)
            if (d[n]->outputs_calls - outputs[n] != rows[i].calls[n])
                fail_msg("frame %zu: the device of twin %zu got %u outputs, %u expected", i + 1, n + 1,
                         d[n]->outputs_calls - outputs[n], rows[i].calls[n]);
    }
    (void)ect_exchange_run(&r->x);
    assert_int_equal(d[0]->out_u16, 6);
    assert_int_equal(d[0]->outputs_calls - outputs[0], 3);
    assert_int_equal(d[1]->out_u16, 5);
    assert_int_equal(d[1]->outputs_calls - outputs[1], 3);
}

static void frames_that_wait(void **state)
{
    static const struct {
        const char *title;
        uint8_t command;
        uint16_t adp, ado, length;
        bool pending, polled; /* whether a poll is due: the first twin has yet to run; it has run */
    } rows[] = {
        {"LRW of outputs and inputs", LRW, 0x100, 0, 6, true, false},
        {"LRW of the last byte", LRW, 0x105, 0, 1, true, false},
        {"LRW up to the first byte", LRW, 0x0FB, 0, 6, true, false},
        {"LRW that ends before", LRW, 0x0FA, 0, 6, false, false},
        {"LRW that begins behind", LRW, 0x106, 0, 6, false, false},
        {"LRW of another twin", LRW, 0x200, 0, 6, false, false},
        {"LWR of outputs", LWR, 0x100, 0, 3, true, false},
        {"LWR of inputs alone", LWR, 0x103, 0, 3, false, false},
        {"LRD of inputs", LRD, 0x103, 0, 3, true, false},
        {"LRD of outputs alone", LRD, 0x100, 0, 3, false, false},
        {"BRD of AL status", BRD, 0, 0x0130, 2, false, false},
        {"BRD of another register", BRD, 0, 0x0110, 2, true, true},
        {"FPRD", FPRD, 0x1001, 0x0130, 2, true, true},
        {"FRMW of the system time", FRMW, 0x1001, 0x0910, 4, true, true},
    };
    static const uint8_t zeros[8];
    rig_t *r = *state;
    operate_at(r, 0, 0x100);
    operate_at(r, 1, 0x200);
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        const size_t n = i / 2;
        const bool polled = i % 2 != 0;
        build_cycle(r, 1);
        (void)ect_chain_pass(r->w.chain, ECT_END_IN, r->w.frame, r->w.frame_length, r->w.now_ns);
        if (polled)
            (void)ect_chain_poll(r->w.chain, r->w.now_ns);
        wire_build(&r->w, rows[n].command, rows[n].adp, rows[n].ado, zeros, rows[n].length);
        const bool awaits = ect_chain_awaits_poll(r->w.chain, r->w.frame, r->w.frame_length);
        if (awaits != (polled ? rows[n].polled : rows[n].pending))
            fail_msg("%s, the first twin %s: a poll is %s, the opposite expected", rows[n].title,
                     polled ? "has run" : "has yet to run", awaits ? "due" : "not due");
        (void)ect_chain_poll(r->w.chain, r->w.now_ns);
    }
    r->w.frame[12] = 0; /* not EtherCAT */
    assert_true(ect_chain_awaits_poll(r->w.chain, r->w.frame, r->w.frame_length));
}

/* Inputs that were held leave although the last frame of the past was not for their twin. */
static void held_inputs(void **state)
{
    rig_t *r = *state;
    uint8_t inputs[3];
    operate(r);
    testdev_t *d = testdev_of(&r->w, 0);
    const unsigned int shown = d->inputs_calls;
    r->clock_ns += 3 * MS;
    build_cycle(r, 1);
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, r->clock_ns - 2 * MS, 1500);
    d->in_u16 = 0xABCD;
    wire_build(&r->w, NOP, 0, 0, "\0", 1);
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, r->clock_ns - 1 * MS, 1500);
    assert_int_equal(d->inputs_calls, shown);
    (void)ect_exchange_run(&r->x);
    assert_int_equal(d->inputs_calls, shown + 1);
    r->w.now_ns = r->clock_ns;
    assert_int_equal(wire_logical(&r->w, LRD, 0x103, inputs, 3), 1);
    assert_int_equal(ect_load_le16(inputs), 0xABCD);
}

/* A device that has left the bus meanwhile: its frames of the past have no effect. */
static void left_meanwhile(void **state)
{
    rig_t *r = *state;
    operate(r);
    testdev_t *d = testdev_of(&r->w, 0);
    ect_chain_fault(r->w.chain, &(ect_fault_t){.kind = ECT_FAULT_HANG, .slave = 1}, r->clock_ns);
    ect_exchange_link(&r->x, ECT_END_IN, false);
    r->clock_ns += 3 * MS;
    build_cycle(r, 1);
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, r->clock_ns - 2 * MS, 1500);
    (void)ect_exchange_run(&r->x);
    assert_int_equal(d->out_u16, 0);
    assert_int_equal(r->x.stats.in_kernel, 1);
    assert_int_equal(r->x.stats.kernel_answers[1], 1);
    assert_int_equal(r->x.stats.longest_kernel_ns, 1500);
}

static void plain(void **state)
{
    rig_t *r = *state;
    const ect_filter_t filter = {.before = before, .after = after, .ctx = r};
    assert_true(ect_exchange_is_plain(&r->x));
    r->x.filter = &filter;
    assert_false(ect_exchange_is_plain(&r->x));
    r->x.filter = NULL;
    set_fault(r, "delay 1000us 100%");
    assert_false(ect_exchange_is_plain(&r->x));
    pass(r, ECT_END_IN, 1);
    r->x.scenario = NULL;
    assert_false(ect_exchange_is_plain(&r->x)); /* a reply is late */
    run_at(r, r->clock_ns + 2 * MS);
    expect_log(r, "<1");
    assert_true(ect_exchange_is_plain(&r->x));
}

/* The master gets the frame as changed by a fault. */
static void working_counters(void **state)
{
    rig_t *r = *state;
    pass(r, ECT_END_IN, 1);
    assert_int_equal(r->x.datagrams.count, 0);
    ect_datagrams_want(&r->x.datagrams, r->clock_ns, r->clock_ns + 1000 * MS);
    pass(r, ECT_END_IN, 2);
    set_fault(r, "counter -1");
    pass(r, ECT_END_IN, 3);
    set_fault(r, "off");
    wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
    ect_exchange_replied(&r->x, r->w.frame, r->w.frame_length, r->clock_ns, 1500);
    assert_int_equal(r->x.datagrams.count, 1);
    assert_int_equal(r->x.datagrams.all[0].replies, 3);
    assert_int_equal(r->x.datagrams.all[0].highest, TWINS);
    assert_int_equal(r->x.datagrams.all[0].lower, 1);
    assert_int_equal(r->x.datagrams.all[0].counter, TWINS);
}

/* --- plans of clients --------------------------------------------------------------------------------------------- */

/* A control socket with a plan and with plants that step; the linker leads its calls through here. */
static struct {
    bool on;
    uint64_t planned_ns, step_ns, acted_ns, stepped_ns;
    unsigned int acts, steps;
    bool step_changes; /* the devices must run again */
} plans;

uint64_t __real_ect_control_planned(const ect_control_t *control);
uint64_t __wrap_ect_control_planned(const ect_control_t *control);
void __real_ect_control_act(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);
void __wrap_ect_control_act(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);
bool __real_ect_control_wants_step(const ect_control_t *control, uint64_t now_ns);
bool __wrap_ect_control_wants_step(const ect_control_t *control, uint64_t now_ns);
bool __real_ect_control_step(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);
bool __wrap_ect_control_step(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns);
uint64_t __real_ect_control_step_due(const ect_control_t *control);
uint64_t __wrap_ect_control_step_due(const ect_control_t *control);

uint64_t __wrap_ect_control_planned(const ect_control_t *control)
{
    return plans.on ? plans.planned_ns : __real_ect_control_planned(control);
}

void __wrap_ect_control_act(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns)
{
    if (!plans.on) {
        __real_ect_control_act(control, chain, now_ns);
        return;
    }
    plans.acts++;
    plans.acted_ns = now_ns;
    plans.planned_ns = ECT_NEVER;
}

bool __wrap_ect_control_wants_step(const ect_control_t *control, uint64_t now_ns)
{
    return plans.on ? now_ns >= plans.step_ns : __real_ect_control_wants_step(control, now_ns);
}

bool __wrap_ect_control_step(ect_control_t *control, ect_chain_t *chain, uint64_t now_ns)
{
    if (!plans.on)
        return __real_ect_control_step(control, chain, now_ns);
    plans.steps++;
    plans.stepped_ns = now_ns;
    plans.step_ns = now_ns + 50 * US;
    return plans.step_changes;
}

uint64_t __wrap_ect_control_step_due(const ect_control_t *control)
{
    return plans.on ? plans.step_ns : __real_ect_control_step_due(control);
}

static ect_control_t *open_control(char folder[])
{
    char message[ECT_ENDPOINT_MESSAGE];
    assert_non_null(mkdtemp(folder));
    setenv("XDG_RUNTIME_DIR", folder, 1);
    return ect_control_open(NULL, message);
}

static void close_control(rig_t *r, const char *folder)
{
    char path[64];
    ect_control_close(r->x.control);
    r->x.control = NULL;
    snprintf(path, sizeof path, "%s/ectwin", folder);
    assert_int_equal(rmdir(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

static void planned_actions(void **state)
{
    char folder[] = "/tmp/test-ectwin-XXXXXX";
    rig_t *r = *state;
    r->x.control = open_control(folder);
    assert_non_null(r->x.control);
    memset(&plans, 0, sizeof plans);
    plans.on = true;
    plans.step_ns = ECT_NEVER;
    plans.planned_ns = START_NS + 5 * US;
    assert_true(run_at(r, START_NS + 4 * US) == START_NS + 5 * US);
    assert_int_equal(plans.acts, 0);
    assert_true(run_at(r, START_NS + 5 * US) > START_NS + 5 * US);
    assert_int_equal(plans.acts, 1);
    assert_true(plans.acted_ns == START_NS + 5 * US);
    (void)run_at(r, START_NS + 6 * US);
    assert_int_equal(plans.acts, 1);
    plans.planned_ns = START_NS + 7 * US;
    (void)run_at(r, START_NS + 9 * US); /* late */
    assert_int_equal(plans.acts, 2);
    assert_true(plans.acted_ns == START_NS + 9 * US);
    plans.on = false;
    close_control(r, folder);
}

static void stepped_plants(void **state)
{
    char folder[] = "/tmp/test-ectwin-XXXXXX";
    rig_t *r = *state;
    r->x.control = open_control(folder);
    assert_non_null(r->x.control);
    memset(&plans, 0, sizeof plans);
    plans.on = true;
    plans.planned_ns = ECT_NEVER;
    plans.step_ns = START_NS + 20 * US;
    assert_true(run_at(r, START_NS + 10 * US) == START_NS + 20 * US);
    assert_int_equal(plans.steps, 0);
    const uint64_t before = r->x.stats.polls;
    assert_true(run_at(r, START_NS + 20 * US) == START_NS + 70 * US);
    assert_int_equal(plans.steps, 1);
    assert_true(plans.stepped_ns == START_NS + 20 * US);
    assert_int_equal(r->x.stats.polls, before + 1);
    plans.step_changes = true;
    (void)run_at(r, START_NS + 30 * US); /* for what the step may have changed */
    assert_int_equal(plans.steps, 1);
    assert_true(run_at(r, START_NS + 75 * US) == START_NS + 125 * US);
    assert_int_equal(plans.steps, 2);
    assert_int_equal(r->x.stats.polls, before + 4); /* once more after the step */
    plans.on = false;
    close_control(r, folder);
}

/* Requests as they come, replies as they leave. */
static void captured(void **state)
{
    static const char *const names[2] = {NULL, NULL};
    char folder[] = "/tmp/test-ectwin-XXXXXX";
    rig_t *r = *state;
    r->x.control = open_control(folder);
    assert_non_null(r->x.control);
    ect_recent_t *recent = ect_control_recent(r->x.control);
    pass(r, ECT_END_IN, 1);
    assert_int_equal(ect_recent_size(recent), 0);
    assert_true(ect_exchange_is_plain(&r->x));
    assert_true(ect_recent_start(recent, names, 0));
    assert_false(ect_exchange_is_plain(&r->x));
    pass(r, ECT_END_IN, 2);
    const uint64_t two = recent->end;
    set_fault(r, "drop wire 1");
    pass(r, ECT_END_IN, 3); /* has no reply */
    assert_true(recent->end == two + two / 2);
    close_control(r, folder);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("a frame with a reply from the kernel passes the chain at its time, and nothing is sent", replied_before),
        TEST("the devices run before a frame of the kernel that came after their deadline", replied_at_a_deadline),
        TEST("CF-042: a twin that was delayed by 300 ms gets the outputs of each reply from the kernel, at its time",
             held_up),
        TEST("its inputs leave with the next run of the devices", held_inputs),
        TEST("devices of several frames from the kernel run together, before the next frame for one of them",
             run_together),
        TEST("a poll is due before a frame for a twin that has yet to run", frames_that_wait),
        TEST("a reply from the kernel before the cable was pulled has no effect on the devices", left_meanwhile),
        TEST("with a filter, a fault or a late reply frames do not pass the chain alone", plain),
        TEST("a capture has each request as it came, and each reply that leaves", captured),
        TEST("a planned action of a client is due at its time, and acts once", planned_actions),
        TEST("a plant steps when it is due; the devices run again if it changed them", stepped_plants),
        TEST("working counters are those of the replies that leave, also from the kernel", working_counters),
        TABLE("each fault of a frame: the frames sent at once, and the counter that counts it", fates),
        TEST("without a scenario a frame gets its reply, and its devices alone ask for a run", without_a_scenario),
        TABLE("a lost request reaches neither filter nor chain; a lost reply has passed both", lost_on_both_ways),
        TEST("a filter changes the request before the chain and the reply after it", filtered),
        TEST("a frame that is too long is counted by a controller, and has no reply", too_long),
        TABLE("replies behind the next one and on a wire leave in their order", orders),
        TEST("a reply that waits for the next one leaves after 10 ms", behind_none),
        TEST("a late reply leaves when it is due; later replies do not overtake it", late_order),
        TABLE("a duplicated reply that is delayed, or waits behind a delayed one, leaves twice", late_and_twice),
        TEST("late replies of one end do not delay those of the other", late_at_both_ends),
        TABLE("replies beyond the limit of kept ones are counted as dropped", most),
        TEST("a frame that a wire delays leaves when it is due", kept_on_a_wire),
        TEST("a frame that a wire releases leaves behind the late replies of its end", kept_behind_late),
        TEST("the devices run at the time when a wire releases a frame", devices_at_a_release),
        TEST("a frame that a wire releases is lost when its end has no link", kept_without_an_end),
        TABLE("a response time is the wait before reception and the time until the reply has left", response_times),
        TEST("a run after a reply uses the time of the reply, any other one the clock", clock_reads),
        TEST("time does not decrease when the clock is behind the time of a frame", never_back),
        TABLE("a late run makes up for the missed times, 64 at most", catches_up),
        TABLE("the devices run at the time of a frame or client before any later time", touched),
        TEST("a frame after a deadline: the devices run at its time, not before it", frame_after_a_deadline),
        TEST("a run returns the time of the next step of a script, and takes it when it is due", scripted),
        TEST("a run takes eight steps at most, and asks for another run at once", late_rows),
        TEST("the bus has signals of a scenario with steps, and none of one without", progress_of_steps),
        TEST("a start sets its time and keeps the counters; an end frees all kept frames", begins_and_ends),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Exchange", tests, NULL, NULL);
}
