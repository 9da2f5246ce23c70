/* SPDX-License-Identifier: MIT */
/* Trees: connections of twins, the order in which a master finds them, cut and restored wires, times of frames, faults
 * on a wire (bus/chain/topology.h, bus/chain/chain.h). Lines and rings are in test_ring.c. */
#include <stdlib.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "bus/chain/topology.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { MOST = 8, DL_PORTS = 0x0111, DL_LOOPS = 0x0101, ALIAS = 0x0012 };

/* "up.port" of each twin but the first; 0: as in a line. */
typedef struct plan {
    const char *what;
    size_t count;
    struct {
        size_t up;
        uint8_t port;
    } at[MOST];
    const char *order;   /* digits: twins from 1, as a master counts them */
    uint8_t ports[MOST]; /* 0x0111 of each */
} plan_t;

static const plan_t plans[] = {
    {"a line", 3, {{0}, {0}, {0}}, "123", {0x5A, 0x5A, 0x56}},
    {"a junction of 3 ports", 4, {{0}, {0, 3}, {1, 1}, {0, 1}}, "1234", {0x9A, 0x5A, 0x56, 0x56}},
    {"a junction of 4 ports", 4, {{0}, {0, 3}, {0, 1}, {0, 2}}, "1234", {0xAA, 0x56, 0x56, 0x56}},
    {"port 2 comes last", 3, {{0}, {0, 2}, {0, 1}}, "132", {0x6A, 0x56, 0x56}},
    {"junction behind junction",
     7,
     {{0}, {0, 3}, {1, 3}, {1, 1}, {1, 2}, {0, 1}, {5, 1}},
     "1234567",
     {0x9A, 0xAA, 0x56, 0x56, 0x56, 0x5A, 0x56}},
    {"no slave at port 1", 3, {{0}, {0, 3}, {1, 2}}, "123", {0x96, 0x66, 0x56}},
    {"a line behind port 3", 3, {{0}, {0, 3}, {1, 1}}, "123", {0x96, 0x5A, 0x56}},
    {"a line with its last slave at port 2", 3, {{0}, {0, 1}, {1, 2}}, "123", {0x5A, 0x66, 0x56}},
};

enum { PLANS = sizeof plans / sizeof plans[0] };

static void make(ect_twin_config_t *twins, const plan_t *plan)
{
    for (size_t i = 0; i < plan->count; i++) {
        twins[i] = ect_twin_default(&testdev, NULL);
        twins[i].up = plan->at[i].up;
        twins[i].up_port = plan->at[i].port;
        twins[i].alias = (uint16_t)(i + 1);
    }
}

static void open_plan(wire_t *w, const plan_t *plan)
{
    ect_twin_config_t twins[MOST];
    make(twins, plan);
    assert_int_equal(ect_chain_check_wires(twins, plan->count), plan->count);
    wire_open_twins(w, twins, plan->count);
}

static void set(wire_t *w, size_t position, const char *name, int32_t value)
{
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(w->chain, position, name, &ref));
    memcpy(ref.value, &value, ect_signal_size(ref.signal));
    ect_chain_wake(w->chain, position);
    wire_poll(w);
}

/* The twins as digits, in the order in which a master counts them. */
static void found(wire_t *w, char *order)
{
    for (uint16_t position = 0;; position++) {
        uint8_t alias[2] = {0};
        if (wire_send(w, APRD, (uint16_t)-position, ALIAS, alias, 2) != 1) {
            order[position] = 0;
            return;
        }
        order[position] = (char)('0' + alias[0]);
    }
}

static void orders(void **state)
{
    (void)state;
    for (size_t i = 0; i < PLANS; i++) {
        wire_t w;
        char order[16];
        open_plan(&w, &plans[i]);
        found(&w, order);
        if (strcmp(order, plans[i].order) != 0)
            fail_msg("%s: expected the order %s, got %s", plans[i].what, plans[i].order, order);
        for (size_t k = 0; k < plans[i].count; k++) {
            uint8_t ports = ect_chain_esc(w.chain, k)->memory[DL_PORTS];
            if (ports != plans[i].ports[k])
                fail_msg("%s: twin %zu: expected DL status 0x%02X, got 0x%02X", plans[i].what, k + 1, plans[i].ports[k],
                         ports);
        }
        wire_close(&w);
    }
}

static void refused(void **state)
{
    static const struct {
        const char *what;
        size_t up;
        uint8_t port;
        const char *chip;
    } rows[] = {{"at itself", 2, 1, NULL},
                {"at one behind it", 5, 1, NULL},
                {"at an input", 0, 4, NULL},
                {"the place of another one", 0, 1, NULL},
                {"at a port that the chip lacks", 1, 2, "np40"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_twin_config_t twins[MOST];
        make(twins, &plans[0]);
        twins[1].esc = rows[i].chip;
        twins[2].up = rows[i].up;
        twins[2].up_port = rows[i].port;
        if (ect_chain_check_wires(twins, 3) != 2 || ect_chain_new(twins, 3, 0))
            fail_msg("plugged in %s: expected twin 2 refused, got %zu", rows[i].what, ect_chain_check_wires(twins, 3));
    }
}

static bool has_any_port(const void *ctx, size_t slave, unsigned int port)
{
    if (slave >= *(const size_t *)ctx || port == 0 || port >= ECT_TOPOLOGY_PORTS)
        fail_msg("asked for port %u of slave %zu", port, slave);
    return true;
}

/* A chip may have every port: only slaves before the present one, and ports 1 to 3, are places of a wire. */
static void places_of_a_wire(void **state)
{
    static const struct {
        const char *what;
        size_t up;
        uint8_t port;
        size_t laid;
    } rows[] = {
        {"behind the previous slave", 9, 0, 3},
        {"at port 1 of the previous slave", 1, 1, 3},
        {"at port 3, the last one", 1, 3, 3},
        {"at port 4", 1, 4, 2},
        {"at port 255", 1, 255, 2},
        {"at port 2 of the first slave", 0, 2, 3},
        {"at the place of another slave", 0, 1, 2},
        {"at itself", 2, 1, 2},
        {"at a slave behind it", 3, 1, 2},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_topology_node_t nodes[3] = {{.up_port = 1}, {.up_port = 0}, {.up = rows[i].up, .up_port = rows[i].port}};
        const size_t before = 2;
        const size_t laid = ect_topology_lay(nodes, 3, has_any_port, &before);
        if (laid != rows[i].laid)
            fail_msg("%s: expected %zu slaves connected, got %zu", rows[i].what, rows[i].laid, laid);
    }
}

static void expect_order(wire_t *w, const char *what, const char *want)
{
    char order[16];
    found(w, order);
    if (strcmp(order, want) != 0)
        fail_msg("%s: expected the master to find %s, got %s", what, want, order);
}

static void cut_and_mended(void **state)
{
    static const struct {
        size_t twin;
        const char *plug, *left;
    } rows[] = {{0, "ecat.plug_3", "167"},     {1, "ecat.plug_in", "167"},    {1, "ecat.plug_3", "124567"},
                {1, "ecat.plug_2", "123467"},  {0, "ecat.plug_out", "12345"}, {5, "ecat.plug_in", "12345"},
                {6, "ecat.plug_in", "123456"}, {6, "ecat.plug_2", "1234567"}};
    wire_t w;
    (void)state;
    open_plan(&w, &plans[4]);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        set(&w, rows[i].twin, rows[i].plug, 0);
        expect_order(&w, rows[i].plug, rows[i].left);
        set(&w, rows[i].twin, rows[i].plug, 1);
        expect_order(&w, "plugged in again", "1234567");
    }
    assert_int_equal(ect_chain_esc(w.chain, 0)->memory[0x0313], 2); /* both ends of its wire have been pulled once */
    assert_int_equal(ect_chain_esc(w.chain, 1)->memory[0x0310], 2);
    wire_close(&w);
}

/* A cut by the master: the neighbour still has link, as both DL status show. With two open ports left, the first twin
 * equals a twin of a line, but the next twin in the list is not behind it. */
static void loop_control(void **state)
{
    static const struct {
        const plan_t *plan;
        uint8_t loops;
        const char *left;
        uint8_t ports[2]; /* 0x0111 of the first two */
    } rows[] = {{&plans[1], 0xC0, "14", {0xDA, 0x5A}},
                {&plans[3], 0x30, "13", {0x7A, 0x56}},
                {&plans[4], 0xC0, "167", {0xDA, 0xAA}}};
    wire_t w;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        open_plan(&w, rows[i].plan);
        assert_int_equal(wire_write8(&w, 0, DL_LOOPS, rows[i].loops), 1);
        wire_poll(&w);
        expect_order(&w, rows[i].plan->what, rows[i].left);
        for (size_t k = 0; k < 2; k++)
            assert_int_equal(ect_chain_esc(w.chain, k)->memory[DL_PORTS], rows[i].ports[k]);
        assert_int_equal(wire_write8(&w, 0, DL_LOOPS, 0x00), 1);
        expect_order(&w, "open again", rows[i].plan->order);
        wire_close(&w);
    }
    open_plan(&w, &plans[4]);
    (void)wire_write8(&w, 6, DL_LOOPS, 0x08); /* forced open without a wire: frames are lost, this one too */
    assert_int_equal(wire_read(&w, 0, 0, (uint8_t[1]){0}, 1), NO_REPLY);
    wire_close(&w);
}

/* Without a poll in between, the next frame must find the port open. */
static void temporary_cut(void **state)
{
    wire_t w;
    (void)state;
    open_plan(&w, &plans[0]);
    w.manual_poll = true;
    assert_int_equal(wire_write16(&w, 0, 0x0100, 0x0C03), 1);
    assert_int_equal(wire_send(&w, BRD, 0, 0, (uint8_t[1]){0}, 1), 1);
    w.now_ns += 1100 * MS;
    assert_int_equal(wire_send(&w, BRD, 0, 0, (uint8_t[1]){0}, 1), 3);
    wire_close(&w);
}

/* --- times ------------------------------------------------------------------------------------------------------ */

static uint32_t receive_time(wire_t *w, size_t twin, unsigned int port)
{
    return ect_load_le32(ect_chain_esc(w->chain, twin)->memory + ECT_REG_DC_RECEIVE_TIME + 4 * port);
}

/* t = ((tA1 - tA0) - (tB1 - tB0) + tDiff) / 2 where A is before B in a line (data sheet I §9.1.2). */
static void delays_of_a_line(void **state)
{
    const ect_esc_personality_t *chip = ect_esc_personality("et1100");
    ect_twin_config_t twins[MOST];
    wire_t w;
    uint8_t any[4] = {0};
    (void)state;
    for (size_t i = 0; i < MOST; i++) {
        twins[i] = ect_twin_default(&testdev, NULL);
        twins[i].cable_m = (uint16_t)(10 * i);
    }
    wire_open_twins(&w, twins, MOST);
    assert_int_equal(wire_send(&w, BWR, 0, ECT_REG_DC_RECEIVE_TIME, any, 4), MOST);
    uint32_t behind = 0; /* time of the frame behind B */
    for (size_t i = MOST - 1; i > 0; i--) {
        uint32_t away = receive_time(&w, i - 1, 1) - receive_time(&w, i - 1, 0);
        uint32_t difference = i == MOST - 1 ? 0 : chip->processing_ns - chip->forwarding_ns; /* the last one turns it */
        uint32_t delay = (away - behind + difference) / 2;
        uint32_t want = chip->processing_ns + 400u + 5u * 10u * (uint32_t)i;
        if (delay != want)
            fail_msg("from twin %zu to %zu: expected %u ns, got %u", i, i + 1, want, delay);
        assert_int_equal(receive_time(&w, i, 0) - receive_time(&w, i - 1, 0), want);
        behind = away;
    }
    wire_close(&w);
}

static void times_of_a_junction(void **state)
{
    wire_t w;
    uint8_t any[4] = {0};
    (void)state;
    open_plan(&w, &plans[2]);
    assert_int_equal(wire_send(&w, BWR, 0, ECT_REG_DC_RECEIVE_TIME, any, 4), 4);
    uint32_t there = receive_time(&w, 0, 3) - receive_time(&w, 0, 0);
    uint32_t next = receive_time(&w, 0, 1) - receive_time(&w, 0, 3);
    uint32_t last = receive_time(&w, 0, 2) - receive_time(&w, 0, 1);
    assert_int_equal(there, 320 + 320 + 2 * 405);
    assert_int_equal(next, 300 + 320 + 2 * 405);
    assert_int_equal(last, next);
    assert_int_equal(receive_time(&w, 2, 0) - receive_time(&w, 0, 0), there + 300 + 405);
    set(&w, 1, "ecat.plug_in", 0); /* the way is shorter now */
    assert_int_equal(wire_send(&w, BWR, 0, ECT_REG_DC_RECEIVE_TIME, any, 4), 3);
    assert_int_equal(receive_time(&w, 2, 0) - receive_time(&w, 0, 0), 320 + 405);
    assert_int_equal(wire_write8(&w, 0, DL_LOOPS, 0x0C), 1); /* and port 1 closed by the master */
    assert_int_equal(wire_send(&w, BWR, 0, ECT_REG_DC_RECEIVE_TIME, any, 4), 2);
    assert_int_equal(receive_time(&w, 3, 0) - receive_time(&w, 0, 0), 320 + 405);
    wire_close(&w);
}

/* --- surroundings of the chip ----------------------------------------------------------------------------------- */

static void latch_and_drift(void **state)
{
    wire_t w;
    (void)state;
    open_plan(&w, &plans[0]);
    for (uint16_t n = 0; n < 2; n++) {
        uint8_t time[8] = {0};
        w.now_ns += 1000;
        set(&w, 1, n == 0 ? "ecat.latch0" : "ecat.latch1", 1);
        assert_int_equal(wire_read(&w, 1, (uint16_t)(ECT_REG_DC_LATCH_TIME + 16 * n), time, 8), 1);
        assert_int_equal(ect_load_le64(time), ect_esc_system_time(ect_chain_esc(w.chain, 1), w.now_ns));
    }
    set(&w, 2, "ecat.drift", 100000);
    uint64_t first = ect_esc_system_time(ect_chain_esc(w.chain, 2), w.now_ns);
    assert_int_equal(ect_esc_system_time(ect_chain_esc(w.chain, 2), w.now_ns + 1000 * MS) - first, 1000100000);
    ect_chain_power_cycle(w.chain, w.now_ns);
    assert_int_equal(ect_esc_system_time(ect_chain_esc(w.chain, 2), w.now_ns + 1000 * MS), 1000100000);
    wire_close(&w);
}

/* A master that resets the chip resets the slave with it: the microcontroller hangs on the same line. */
static void reset_by_the_master(void **state)
{
    wire_t w;
    (void)state;
    open_plan(&w, &plans[0]);
    wire_go(&w, 1, 2);
    for (const char *letter = "RES"; *letter != 0; letter++)
        assert_int_equal(wire_send(&w, APWR, (uint16_t)-1, 0x0040, (uint8_t[1]){(uint8_t)*letter}, 1), 1);
    assert_int_equal(ect_chain_slave(w.chain, 1)->state, 1);
    assert_int_equal(ect_chain_slave(w.chain, 0)->state, 1);
    assert_int_equal(wire_read(&w, 1, 0x0010, (uint8_t[2]){0}, 2), 0); /* no slave has that address any more */
    wire_assign_stations(&w);
    wire_go(&w, 1, 2);
    assert_int_equal(ect_chain_esc(w.chain, 1)->memory[DL_PORTS], 0x5A);
    wire_close(&w);
}

/* --- mishaps ---------------------------------------------------------------------------------------------------- */

/* A fault on one wire, in one direction. */
typedef struct mishap {
    bool damaged; /* else it is lost */
    size_t wire;
    bool back;
} mishap_t;

static bool fail_link(void *ctx, ect_crossing_t *c)
{
    const mishap_t *mishap = ctx;
    if (c->wire != mishap->wire || c->back != mishap->back)
        return true;
    c->damaged = mishap->damaged;
    return mishap->damaged;
}

static void failures(void **state)
{
    /* Which of four in a line have processed the frame; which counters of which count. */
    static struct {
        mishap_t mishap;
        const char *processed, *invalid, *forwarded;
        unsigned int port;
    } rows[] = {
        {{false, 0, false}, "....", "....", "....", 0}, {{false, 2, false}, "##..", "....", "....", 0},
        {{false, 2, true}, "####", "....", "....", 0},  {{false, 0, true}, "####", "....", "....", 0},
        {{true, 0, false}, "....", "#...", ".###", 0},  {{true, 2, false}, "##..", "..#.", "...#", 0},
        {{true, 2, true}, "####", ".#..", "#...", 1},   {{true, 0, true}, "####", "....", "....", 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_device_t *devices[] = {&testdev, &testdev, &testdev, &testdev};
        wire_t w;
        wire_open(&w, devices, 4);
        ect_chain_guard(w.chain, fail_link, &rows[i].mishap);
        assert_int_equal(wire_send(&w, BWR, 0, 0x0F80, (uint8_t[1]){0x77}, 1), NO_REPLY);
        for (size_t k = 0; k < 4; k++) {
            const uint8_t *memory = ect_chain_esc(w.chain, k)->memory;
            bool processed = memory[0x0F80] == 0x77;
            bool invalid = memory[0x0300 + 2 * rows[i].port] != 0;
            bool forwarded = memory[0x0308 + rows[i].port] != 0;
            if (processed != (rows[i].processed[k] == '#') || invalid != (rows[i].invalid[k] == '#') ||
                forwarded != (rows[i].forwarded[k] == '#'))
                fail_msg("damaged %d on wire %zu, back %d: twin %zu: processed %d, counted %d, forwarded %d",
                         rows[i].mishap.damaged, rows[i].mishap.wire, rows[i].mishap.back, k + 1, processed, invalid,
                         forwarded);
        }
        assert_int_equal(wire_send(&w, BRD, 0, 0, (uint8_t[1]){0}, 1), 4); /* it was one frame's */
        wire_close(&w);
    }
}

/* Delays the frame that arrives by a wire. */
typedef struct keeper {
    size_t wire;
    bool back;
    ect_crossing_t kept;
} keeper_t;

static bool keep(void *ctx, ect_crossing_t *c)
{
    keeper_t *k = ctx;
    if (c->wire != k->wire || c->back != k->back)
        return true;
    k->kept = *c;
    return false;
}

/* From a junction with three branches: 1 behind its port 3, 2 behind 1, 3 and 4 at its ports 1 and 2. */
static void frame_continues(void **state)
{
    static const uint8_t ports[] = {0, 3, 1, 1, 2};
    static const uint8_t ups[] = {0, 0, 1, 0, 0};
    (void)state;
    for (size_t wire = 0; wire < 5; wire++) {
        for (unsigned int back = 0; back < 2; back++) {
            ect_twin_config_t twins[5];
            keeper_t keeper = {.wire = wire, .back = back == 1};
            wire_t w;
            for (size_t i = 0; i < 5; i++) {
                twins[i] = ect_twin_default(&testdev, NULL);
                twins[i].up = ups[i];
                twins[i].up_port = ports[i];
            }
            wire_open_twins(&w, twins, 5);
            wire_build(&w, BRD, 0, 0, (uint8_t[1]){0}, 1);
            ect_chain_guard(w.chain, keep, &keeper);
            assert_false(wire_transmit(&w));
            w.now_ns += MS;
            if (ect_chain_resume(w.chain, &keeper.kept, w.now_ns) != ECT_END_IN || wire_wkc(&w, 0) != 5)
                fail_msg("kept on wire %zu, back %u: expected it at the master with 5, got %u", wire, back,
                         wire_wkc(&w, 0));
            const ect_setting_t pulled = {.name = "ecat.plug_in", .value = "0"};
            char message[ECT_SIGNAL_MESSAGE];
            assert_true(ect_settings_apply(w.chain, wire, &pulled, 1, w.now_ns, message));
            wire_poll(&w);
            assert_int_equal(ect_chain_resume(w.chain, &keeper.kept, w.now_ns), ECT_END_NONE);
            wire_close(&w);
        }
    }
}

static void wires(void **state)
{
    (void)state;
    for (size_t p = 0; p < PLANS; p++) {
        wire_t w;
        open_plan(&w, &plans[p]);
        for (size_t i = 0; i < plans[p].count; i++) {
            const bool line = plans[p].at[i].port == 0;
            const size_t want = i == 0 ? 0 : line ? i : plans[p].at[i].up + 1;
            const unsigned int want_port = i == 0 ? 0 : line ? 1 : plans[p].at[i].port;
            unsigned int port = 9;
            const size_t up = ect_chain_wire(w.chain, i, &port);
            if (up != want || port != want_port)
                fail_msg("%s: twin %zu: expected port %u of %zu, got port %u of %zu", plans[p].what, i + 1, want_port,
                         want, port, up);
        }
        wire_close(&w);
    }
}

/* Behind the last slave, at the chain's other end. */
static void goes_on_behind_the_last(void **state)
{
    const ect_device_t *devices[] = {&testdev, &testdev};
    keeper_t keeper = {.wire = 2};
    wire_t w;
    (void)state;
    wire_open(&w, devices, 2);
    ect_chain_set_link(w.chain, ECT_END_OUT, true);
    wire_build(&w, BRD, 0, 0, (uint8_t[1]){0}, 1);
    ect_chain_guard(w.chain, keep, &keeper);
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_IN, w.frame, w.frame_length, w.now_ns), ECT_END_NONE);
    assert_int_equal(ect_chain_resume(w.chain, &keeper.kept, w.now_ns), ECT_END_OUT);
    assert_int_equal(wire_wkc(&w, 0), 2);
    keeper.kept.damaged = true;
    assert_int_equal(ect_chain_resume(w.chain, &keeper.kept, w.now_ns), ECT_END_NONE);
    keeper.back = true;
    ect_chain_guard(w.chain, keep, &keeper);
    wire_build(&w, BRD, 0, 0, (uint8_t[1]){0}, 1);
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_OUT, w.frame, w.frame_length, w.now_ns), ECT_END_NONE);
    assert_int_equal(ect_chain_resume(w.chain, &keeper.kept, w.now_ns), ECT_END_IN);
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-003 CF-010: a master finds the slaves of a tree in the order of the ports, DL status shows which are open",
         orders, NULL, NULL, NULL},
        {"a tree that cannot be wired is refused, with the twin that cannot", refused, NULL, NULL, NULL},
        {"a wire ends at port 1, 2 or 3 of a slave before its own", places_of_a_wire, NULL, NULL, NULL},
        {"the wire at the input of a twin comes from a port of another twin, or from the master", wires, NULL, NULL,
         NULL},
        {"CF-010 CF-096: a cut of each wire of a tree removes the twins behind it until the wire is restored",
         cut_and_mended, NULL, NULL, NULL},
        {"CF-010: loop control cuts and restores; with a loop forced open without a wire, frames are lost",
         loop_control, NULL, NULL, NULL},
        {"CF-010: a loop that is closed for a second opens by itself, between two frames", temporary_cut, NULL, NULL,
         NULL},
        {"CF-087: receive times of a line give its delays by the data sheet's formula", delays_of_a_line, NULL, NULL,
         NULL},
        {"CF-087: receive times of a junction, also after a cut", times_of_a_junction, NULL, NULL, NULL},
        {"CF-091: latch inputs and the drift of an oscillator are signals", latch_and_drift, NULL, NULL, NULL},
        {"CF-012: a reset by the master restarts the slave", reset_by_the_master, NULL, NULL, NULL},
        {"CF-011: a frame that is lost or damaged on a wire: the ESCs that have processed it, the ESCs that count it",
         failures, NULL, NULL, NULL},
        {"a frame that is delayed on a wire of a tree continues from there, if the wire still exists", frame_continues,
         NULL, NULL, NULL},
        {"the same for a frame delayed behind the last slave", goes_on_behind_the_last, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Topology", tests, NULL, NULL);
}
