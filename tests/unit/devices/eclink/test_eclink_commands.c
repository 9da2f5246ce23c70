/* SPDX-License-Identifier: MIT */
/* EC-Link commands: exactly once and in order, from and to the remote units (TS-0007 §8, §9, §10.1, §10.2, §10.5). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "support/signals.h"
#include "support/wire.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { OUTPUTS_AT = 0x1000, INPUTS_AT = 0x2800, MOST_INPUTS = 142, MOST_OUTPUTS = 228, CYCLE_MS = 10, UPDATE_MS = 125 };
enum { PCO = 0, CCO = 1, CAO = 3, TO_RU = 4, DATA_TO_RU = 6, PCI = 0, CCI = 1, CAI = 3, FROM_RU = 4, DATA_FROM_RU = 6 };
enum { BYTES = 16, RUS = 8, QUEUE = 16 };

static const ect_device_t *const nodes[] = {&ect_eclink_map3, &ect_eclink_map7, &ect_eclink_multiarm};

/* A base unit and its controller; PCO counts with each cycle. */
typedef struct rig {
    wire_t w;
    const ect_device_t *device;
    uint8_t out[MOST_OUTPUTS];
    uint8_t in[MOST_INPUTS];
} rig_t;

static void write_outputs(rig_t *r)
{
    assert_int_equal(wire_write(&r->w, 0, OUTPUTS_AT, r->out, ect_device_sm_bytes(r->device, 2)), 1);
}

static void read_inputs(rig_t *r)
{
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, ect_device_sm_bytes(r->device, 3)), 1);
}

static void cycle(rig_t *r)
{
    r->out[PCO]++;
    write_outputs(r);
    read_inputs(r);
}

static void run(rig_t *r, uint64_t ns)
{
    uint64_t end = r->w.now_ns + ns;
    while (r->w.now_ns < end) {
        uint64_t left = end - r->w.now_ns;
        wire_advance(&r->w, left < CYCLE_MS * MS ? left : CYCLE_MS * MS);
        cycle(r);
    }
}

static void run_updates(rig_t *r, unsigned int count)
{
    run(r, (uint64_t)count * UPDATE_MS * MS);
}

static void to_op(rig_t *r)
{
    wire_go(&r->w, 0, ECT_STATE_SAFEOP);
    write_outputs(r);
    assert_int_equal(wire_al(&r->w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
}

static void set(rig_t *r, const char *name, const char *value)
{
    signal_set(&r->w, name, value);
}

static void get(rig_t *r, const char *name, char text[ECT_SIGNAL_TEXT_ROOM])
{
    signal_get(&r->w, name, text);
}

static unsigned long number(rig_t *r, const char *name)
{
    return (unsigned long)signal_number(&r->w, name);
}

static void set_ru(rig_t *r, unsigned int ru, const char *signal, const char *value)
{
    set(r, signal_of_ru(ru, signal), value);
}

static unsigned long ru_number(rig_t *r, unsigned int ru, const char *signal)
{
    return number(r, signal_of_ru(ru, signal));
}

/* In OP and in order, remotes 1..`on` switched on; their ids are 1..8. */
static void start(rig_t *r, const ect_device_t *device, unsigned int on)
{
    memset(r, 0, sizeof *r);
    r->device = device;
    wire_open_one(&r->w, device);
    to_op(r);
    for (unsigned int i = 1; i <= on; i++)
        set_ru(r, i, "on", "1");
    run(r, 20 * MS);
}

/* Sixteen bytes that identify the command. */
static void content(unsigned int serial, uint8_t data[BYTES])
{
    for (unsigned int i = 0; i < BYTES; i++)
        data[i] = (uint8_t)(serial * 31u + (serial >> 8) + i * 7u + 1u);
    data[0] = (uint8_t)(serial >> 8);
    data[1] = (uint8_t)serial;
}

static const char *hex(unsigned int serial)
{
    static char text[2 * BYTES + 1];
    uint8_t data[BYTES];
    content(serial, data);
    for (unsigned int i = 0; i < BYTES; i++)
        snprintf(text + 2 * (size_t)i, 3, "%02x", data[i]);
    return text;
}

static bool send_from(rig_t *r, unsigned int ru, unsigned int serial)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    bool done = signal_try_set(&r->w, signal_of_ru(ru, "command"), hex(serial), message);
    assert_true(done == (*message == 0));
    return done;
}

static void put_command(rig_t *r, uint16_t id, unsigned int serial)
{
    ect_store_be16(r->out + TO_RU, id);
    content(serial, r->out + DATA_TO_RU);
}

static void expect_shown(rig_t *r, uint8_t cci, uint16_t id, unsigned int serial)
{
    uint8_t data[BYTES];
    content(serial, data);
    if (r->in[CCI] != cci || ect_load_be16(r->in + FROM_RU) != id || memcmp(r->in + DATA_FROM_RU, data, BYTES) != 0)
        fail_msg("%s: expected CCI %u, command %u from RU %u; got CCI %u, command %u from RU %u", r->device->type_name,
                 cci, serial, id, r->in[CCI], ect_load_be16(r->in + DATA_FROM_RU), ect_load_be16(r->in + FROM_RU));
}

static void expect_received(rig_t *r, const char *when, unsigned int ru, unsigned long count, unsigned int serial)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    get(r, signal_of_ru(ru, "received"), text);
    if (ru_number(r, ru, "received_count") != count || (count > 0 && strcmp(text, hex(serial)) != 0))
        fail_msg("%s, %s: expected RU %u to have %lu commands, the last %s; it has %lu, the last %s",
                 r->device->type_name, when, ru, count, hex(serial), ru_number(r, ru, "received_count"), text);
}

/* --- from the remotes --------------------------------------------------------------------------------------------- */

static void from_a_remote(void **state)
{
    static const char *const ids[] = {"1", "255", "256", "4660", "65535"};
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        start(&r, nodes[n], 1);
        assert_int_equal(r.in[CCI], 0);
        for (size_t i = 0; i < COUNT(ids); i++) {
            set(&r, "ru1.id", ids[i]);
            assert_true(send_from(&r, 1, (unsigned int)(0x100 + i)));
            run_updates(&r, 1);
            expect_shown(&r, (uint8_t)(i + 1), (uint16_t)strtoul(ids[i], NULL, 10), (unsigned int)(0x100 + i));
            assert_int_equal(number(&r, "bu.cci"), i + 1);
            run_updates(&r, 3);
            expect_shown(&r, (uint8_t)(i + 1), (uint16_t)strtoul(ids[i], NULL, 10), (unsigned int)(0x100 + i));
            r.out[CAO] = r.in[CCI];
            run_updates(&r, 3);
            expect_shown(&r, (uint8_t)(i + 1), (uint16_t)strtoul(ids[i], NULL, 10), (unsigned int)(0x100 + i));
        }
        wire_close(&r.w);
    }
}

/* Armed, disarmed, and disarmed while another is armed. */
static void regardless_of_arming(void **state)
{
    static const struct {
        const char *what;
        unsigned int armed;
    } rows[] = {{"none armed", 0}, {"the sender is armed", 1}, {"another is armed", 2}};
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        for (size_t i = 0; i < COUNT(rows); i++) {
            rig_t r;
            start(&r, nodes[n], 2);
            if (rows[i].armed > 0)
                set_ru(&r, rows[i].armed, "armed", "1");
            assert_true(send_from(&r, 1, 77));
            put_command(&r, 1, 78);
            r.out[CCO]++;
            run_updates(&r, 2);
            expect_shown(&r, 1, 1, 77);
            expect_received(&r, rows[i].what, 1, 1, 78);
            expect_received(&r, rows[i].what, 2, 0, 0);
            wire_close(&r.w);
        }
    }
}

static void one_at_a_time(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[1], 3);
    for (unsigned int i = 0; i < 6; i++)
        assert_true(send_from(&r, i % 3 + 1, i));
    for (unsigned int i = 0; i < 6; i++) {
        run_updates(&r, 1);
        expect_shown(&r, (uint8_t)(i + 1), (uint16_t)(i % 3 + 1), i);
        run_updates(&r, 4);
        expect_shown(&r, (uint8_t)(i + 1), (uint16_t)(i % 3 + 1), i);
        r.out[CAO] = r.in[CCI];
        cycle(&r);
        assert_int_equal(r.in[CCI], i + 1); /* the next one follows with the next update */
    }
    run_updates(&r, 10);
    expect_shown(&r, 6, 3, 5);
    wire_close(&r.w);
}

static void queue_keeps_the_oldest(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        for (unsigned int shown = 0; shown <= 1; shown++) {
            rig_t r;
            unsigned int total = QUEUE + shown;
            start(&r, nodes[n], 2);
            for (unsigned int i = 0; i < total; i++) {
                assert_true(send_from(&r, i % 2 + 1, i));
                if (i == 0 && shown == 1)
                    run_updates(&r, 1);
            }
            assert_int_equal(number(&r, "bu.overflows"), 0);
            for (unsigned int i = 1; i <= 5; i++) {
                assert_false(send_from(&r, 1, 1000 + i));
                assert_int_equal(number(&r, "bu.overflows"), i);
            }
            for (unsigned int i = 0; i < total; i++) {
                if (r.in[CCI] == i)
                    run_updates(&r, 1);
                expect_shown(&r, (uint8_t)(i + 1), (uint16_t)(i % 2 + 1), i);
                r.out[CAO] = r.in[CCI];
                run_updates(&r, 1);
            }
            assert_true(send_from(&r, 1, 2000));
            run_updates(&r, 2);
            expect_shown(&r, (uint8_t)(total + 1), 1, 2000);
            wire_close(&r.w);
        }
    }
}

static void refused_senders(void **state)
{
    static const char *const bad[] = {"", "00", "000102030405060708090a0b0c0d0e", "000102030405060708090a0b0c0d0e0f10",
                                      "000102030405060708090a0b0c0d0e0g"};
    (void)state;
    rig_t r;
    char message[ECT_SIGNAL_MESSAGE];
    start(&r, nodes[0], 1);
    assert_false(send_from(&r, 2, 1)); /* is off */
    set(&r, "ru1.on", "0");
    assert_false(send_from(&r, 1, 1));
    set(&r, "ru1.on", "1");
    for (size_t i = 0; i < COUNT(bad); i++)
        assert_false(signal_try_set(&r.w, "ru1.command", bad[i], message));
    run_updates(&r, 3);
    assert_int_equal(r.in[CCI], 0);
    assert_int_equal(number(&r, "bu.overflows"), 0);
    wire_close(&r.w);
}

static void waits_for_the_controller(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[0], 1);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    assert_true(send_from(&r, 1, 1));
    assert_true(send_from(&r, 1, 2));
    wire_advance(&r.w, 3000 * MS);
    read_inputs(&r);
    assert_int_equal(r.in[CCI], 0);
    cycle(&r);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    run_updates(&r, 2);
    expect_shown(&r, 1, 1, 1);
    r.out[CAO] = 1;
    run_updates(&r, 2);
    expect_shown(&r, 2, 1, 2);
    wire_close(&r.w);
}

/* A command is not acknowledged when the controller stops and returns, with its old CAO or a new one. */
static void controller_back_with_cao(void **state)
{
    static const struct {
        const char *what;
        uint8_t cao;
    } rows[] = {{"old counter", 4}, {"fresh counter", 0}, {"some counter", 200}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        rig_t r;
        start(&r, nodes[i % COUNT(nodes)], 1);
        for (unsigned int n = 1; n <= 5; n++) {
            assert_true(send_from(&r, 1, n));
            run_updates(&r, 1);
            r.out[CAO] = (uint8_t)(n < 5 ? n : 4);
            cycle(&r);
        }
        assert_true(send_from(&r, 1, 6));
        wire_advance(&r.w, 300 * MS); /* watchdog */
        expect_shown(&r, 5, 1, 5);
        memset(r.out, 0, sizeof r.out);
        r.out[CAO] = rows[i].cao;
        to_op(&r);
        run_updates(&r, 4);
        expect_shown(&r, 5, 1, 5);
        r.out[CAO] = 5;
        run_updates(&r, 1);
        expect_shown(&r, 6, 1, 6);
        r.out[CAO] = 6;
        run_updates(&r, 4);
        expect_shown(&r, 6, 1, 6);
        wire_close(&r.w);
    }
}

/* --- to the remotes ----------------------------------------------------------------------------------------------- */

static void to_the_addressed(void **state)
{
    static const struct {
        uint16_t id;
        bool gets[4]; /* remotes 1 to 4, ids 1, 513, 3 and 65535; the third is off */
    } rows[] = {
        {0, {true, true, false, true}},         {1, {true, false, false, false}},
        {513, {false, true, false, false}},     {3, {false, false, false, false}},
        {65535, {false, false, false, true}},   {2, {false, false, false, false}},
        {0x0102, {false, false, false, false}},
    };
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        unsigned long counts[4] = {0};
        unsigned int last[4] = {0};
        start(&r, nodes[n], 4);
        set(&r, "ru2.id", "513");
        set(&r, "ru3.on", "0");
        set(&r, "ru4.id", "65535");
        for (unsigned int i = 0; i < COUNT(rows); i++) {
            put_command(&r, rows[i].id, 500 + i);
            r.out[CCO]++;
            cycle(&r);
            assert_int_equal(number(&r, "bu.cai"), r.out[CCO]);
            run_updates(&r, 1);
            if (r.in[CAI] != r.out[CCO])
                fail_msg("command to RU %u: expected CAI %u, got %u", rows[i].id, r.out[CCO], r.in[CAI]);
            for (unsigned int ru = 0; ru < 4; ru++) {
                counts[ru] += rows[i].gets[ru] ? 1 : 0;
                last[ru] = rows[i].gets[ru] ? 500 + i : last[ru];
                expect_received(&r, "addressed", ru + 1, counts[ru], last[ru]);
            }
        }
        set(&r, "ru3.on", "1");
        run_updates(&r, 2);
        expect_received(&r, "was off when the commands came", 3, 0, 0);
        wire_close(&r.w);
    }
}

static void repeated_cycles(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[1], 2);
    put_command(&r, 0, 1);
    r.out[CCO] = 1;
    run_updates(&r, 8);
    expect_received(&r, "the same outputs for a second", 1, 1, 1);
    put_command(&r, 1, 2); /* not announced by CCO */
    run_updates(&r, 8);
    expect_received(&r, "other bytes, same CCO", 1, 1, 1);
    expect_received(&r, "other bytes, same CCO", 2, 1, 1);
    assert_int_equal(r.in[CAI], 1);
    wire_close(&r.w);
}

static void counter_steps(void **state)
{
    static const struct {
        uint8_t from, to;
        unsigned int lost;
    } rows[] = {{0, 1, 0}, {254, 255, 0}, {255, 0, 0}, {10, 12, 1}, {250, 3, 8}, {7, 6, 0}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        rig_t r;
        start(&r, nodes[2], 1);
        r.out[CCO] = rows[i].from;
        run_updates(&r, 2);
        unsigned long before = ru_number(&r, 1, "received_count"), lost = number(&r, "bu.commands_lost");
        put_command(&r, 1, 9);
        r.out[CCO] = rows[i].to;
        run_updates(&r, 2);
        expect_received(&r, "CCO has changed", 1, before + 1, 9);
        assert_int_equal(number(&r, "bu.commands_lost") - lost, rows[i].lost);
        assert_int_equal(r.in[CAI], rows[i].to);
        wire_close(&r.w);
    }
}

static void all_values_of_cco(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[0], 1);
    for (unsigned int n = 1; n <= 600; n++) {
        put_command(&r, (uint16_t)(n % 2), n);
        r.out[CCO] = (uint8_t)n;
        run_updates(&r, 1);
        expect_received(&r, "one after the other", 1, n, n);
        assert_int_equal(r.in[CAI], (uint8_t)n);
    }
    wire_close(&r.w);
}

/* A controller that does not wait for CAI, within one update: the queue accepts sixteen, one more waits, and each
 * further one replaces it. */
static void faster_than_the_link(void **state)
{
    (void)state;
    for (unsigned int too_many = 0; too_many <= 3; too_many++) {
        rig_t r;
        unsigned int last = QUEUE + too_many, lost = too_many > 1 ? too_many - 1 : 0;
        start(&r, nodes[0], 2);
        uint8_t pci = r.in[PCI];
        while (r.in[PCI] == pci)
            run(&r, 1 * MS);
        for (unsigned int n = 1; n <= last; n++) {
            put_command(&r, 0, n);
            r.out[CCO] = (uint8_t)n;
            cycle(&r);
        }
        assert_int_equal(number(&r, "bu.commands_lost"), lost);
        assert_int_equal(number(&r, "bu.cai"), QUEUE);
        for (unsigned int n = 1; n <= QUEUE; n++) {
            run_updates(&r, 1);
            expect_received(&r, "in order", 1, n, n);
            expect_received(&r, "in order", 2, n, n);
            assert_int_equal(r.in[CAI], last); /* room was made */
        }
        run_updates(&r, 3);
        expect_received(&r, "the one that waited, and nothing more", 1, last - lost, last);
        wire_close(&r.w);
    }
}

/* On fallback a remote sends its own commands first: 49 are sent as fast as CAI allows, and 49 arrive. */
static void cai_waits_for_room(void **state)
{
    enum { COMMANDS = 49 };
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        unsigned int waited = 0;
        start(&r, nodes[n], 2);
        set(&r, "ru1.g_link_lost", "1");
        for (unsigned int i = 0; i < QUEUE; i++)
            assert_true(send_from(&r, 1, 100 + i)); /* they keep its C-Link busy for 16 updates */
        for (unsigned int i = 1; i <= COMMANDS; i++) {
            put_command(&r, 0, i);
            r.out[CCO]++;
            cycle(&r);
            waited += number(&r, "bu.cai") != r.out[CCO];
            for (unsigned int ms = 0; number(&r, "bu.cai") != r.out[CCO]; ms++) {
                assert_in_range(ms, 0, 20000);
                run(&r, 1 * MS);
            }
        }
        run_updates(&r, 20);
        expect_received(&r, "on fallback", 1, COMMANDS, COMMANDS);
        expect_received(&r, "on G-Link", 2, COMMANDS, COMMANDS);
        assert_int_equal(r.in[CAI], COMMANDS);
        assert_int_equal(number(&r, "bu.commands_lost"), 0);
        assert_true(waited > 0);
        wire_close(&r.w);
    }
}

/* Seventeen commands wait for a remote whose link transfers none meanwhile; what then ends the waiting. */
static void room_for_the_waiting(void **state)
{
    static const struct {
        const char *what, *signal, *value;
    } rows[] = {
        {"the remote takes one", "ru1.g_link_lost", "0"},
        {"the remote is switched off", "ru1.on", "0"},
        {"no VLAP reaches it", "bu.vlaps", "0"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        rig_t r;
        start(&r, nodes[1], 1);
        set(&r, "ru1.g_link_lost", "1");
        for (unsigned int n = 0; n < QUEUE; n++)
            assert_true(send_from(&r, 1, n));
        for (unsigned int n = 1; n <= QUEUE + 1; n++) {
            put_command(&r, 1, n);
            r.out[CCO] = (uint8_t)n;
            cycle(&r);
        }
        run_updates(&r, 2);
        assert_int_equal(r.in[CAI], QUEUE);
        set(&r, rows[i].signal, rows[i].value);
        run_updates(&r, 2);
        if (r.in[CAI] != QUEUE + 1)
            fail_msg("%s: expected CAI %u, got %u", rows[i].what, QUEUE + 1, r.in[CAI]);
        assert_int_equal(number(&r, "bu.commands_lost"), 0);
        wire_close(&r.w);
    }
}

/* The controller stops while its command waits, and returns. */
static void waiting_over_an_interruption(void **state)
{
    static const struct {
        const char *what;
        uint8_t cco, cai;
        unsigned int lost, received;
    } rows[] = {
        {"with the same counter", QUEUE + 1, QUEUE + 1, 0, QUEUE + 1},
        {"with the next command", QUEUE + 2, QUEUE + 2, 1, QUEUE + 1},
        {"with CAI as its counter: it has lost its own", QUEUE, QUEUE, 1, QUEUE},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        rig_t r;
        start(&r, nodes[1], 1);
        set(&r, "ru1.g_link_lost", "1");
        for (unsigned int n = 0; n < QUEUE; n++)
            assert_true(send_from(&r, 1, n));
        for (unsigned int n = 1; n <= QUEUE + 1; n++) {
            put_command(&r, 1, n);
            r.out[CCO] = (uint8_t)n;
            cycle(&r);
        }
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
        r.out[CCO] = rows[i].cco;
        to_op(&r);
        run_updates(&r, 50);
        if (r.in[CAI] != rows[i].cai || number(&r, "bu.commands_lost") != rows[i].lost ||
            ru_number(&r, 1, "received_count") != rows[i].received)
            fail_msg("%s: expected CAI %u, %u lost, %u received; got %u, %lu, %lu", rows[i].what, rows[i].cai,
                     rows[i].lost, rows[i].received, r.in[CAI], number(&r, "bu.commands_lost"),
                     ru_number(&r, 1, "received_count"));
        wire_close(&r.w);
    }
}

/* Id 1 with its bytes in the wrong order is 256. */
static void unknown_ids(void **state)
{
    static const struct {
        uint16_t id;
        unsigned long unknown;
    } rows[] = {{0, 0}, {1, 0}, {8, 0}, {256, 1}, {9, 2}, {65535, 3}, {3, 3}};
    (void)state;
    rig_t r;
    start(&r, nodes[2], 1);
    for (size_t i = 0; i < COUNT(rows); i++) {
        put_command(&r, rows[i].id, 1);
        r.out[CCO]++;
        run_updates(&r, 1);
        if (number(&r, "bu.commands_unknown") != rows[i].unknown || r.in[CAI] != r.out[CCO])
            fail_msg("id %u: expected %lu in bu.commands_unknown and CAI %u, got %lu and %u", rows[i].id,
                     rows[i].unknown, r.out[CCO], number(&r, "bu.commands_unknown"), r.in[CAI]);
    }
    wire_close(&r.w);
}

/* CCO of the controller when it returns; the last CCO of the base unit is `last`. */
static const struct back {
    const char *what;
    uint8_t last, cco;
    unsigned int commands;
} backs[] = {
    {"old counter, nothing new", 5, 5, 0},
    {"old counter, one command meanwhile", 5, 6, 1},
    {"fresh counter", 5, 0, 0},
    {"some other counter", 5, 100, 0},
    {"old counter at the wrap", 255, 0, 1},
    {"old counter, nothing new, at the wrap", 255, 255, 0},
    {"old counter never used", 0, 0, 0},
    {"first command while away", 0, 1, 1},
};

static void controller_back_with_cco(void **state)
{
    static const uint8_t down[] = {ECT_STATE_INIT, ECT_STATE_PREOP, ECT_STATE_SAFEOP, 0 /* watchdog */};
    (void)state;
    for (size_t i = 0; i < COUNT(backs) * COUNT(down); i++) {
        const struct back *b = &backs[i / COUNT(down)];
        uint8_t to = down[i % COUNT(down)];
        rig_t r;
        start(&r, nodes[i % COUNT(nodes)], 1);
        r.out[CCO] = b->last;
        run_updates(&r, 2);
        unsigned long before = ru_number(&r, 1, "received_count");
        if (to != 0)
            assert_int_equal(wire_al(&r.w, 0, to, NULL), to);
        wire_advance(&r.w, 500 * MS);
        put_command(&r, 1, 42);
        r.out[CCO] = b->cco;
        to_op(&r);
        run_updates(&r, 4);
        if (ru_number(&r, 1, "received_count") != before + b->commands)
            fail_msg("%s, after %s: expected %u commands, got %lu", b->what, to == 0 ? "a watchdog" : "a lower state",
                     b->commands, ru_number(&r, 1, "received_count") - before);
        assert_int_equal(r.in[CAI], b->cco);
        put_command(&r, 1, 43);
        r.out[CCO]++;
        run_updates(&r, 2);
        expect_received(&r, b->what, 1, before + b->commands + 1, 43);
        wire_close(&r.w);
    }
}

static void first_counter_after_power_on(void **state)
{
    static const uint8_t ccos[] = {0, 1, 2, 128, 255};
    (void)state;
    for (size_t i = 0; i < COUNT(ccos) * COUNT(nodes); i++) {
        rig_t r = {.device = nodes[i / COUNT(ccos)]};
        unsigned int first = ccos[i % COUNT(ccos)] == 1 ? 1 : 0;
        wire_open_one(&r.w, r.device);
        set(&r, "ru1.on", "1");
        put_command(&r, 0, 1);
        r.out[CCO] = ccos[i % COUNT(ccos)];
        to_op(&r);
        run_updates(&r, 3);
        expect_received(&r, "with the first outputs", 1, first, 1);
        assert_int_equal(r.in[CAI], r.out[CCO]);
        put_command(&r, 0, 2);
        r.out[CCO]++;
        run_updates(&r, 2);
        expect_received(&r, "one more", 1, first + 1, 2);
        assert_int_equal(number(&r, "bu.commands_lost"), 0);
        wire_close(&r.w);
    }
}

/* --- both ways, at random, against a model ------------------------------------------------------------------------ */

enum { MOST = 4096 };

typedef struct list {
    unsigned int serials[MOST];
    unsigned int count, done;
} list_t;

typedef struct soak {
    rig_t r;
    uint32_t random;
    unsigned int serial;
    uint16_t sender[MOST * 2]; /* of a command to the controller, by serial */
    list_t to_controller;
    list_t to_ru[RUS];
    bool on[RUS];
    ect_signal_ref_t received[RUS]; /* found once: this is read often */
    uint8_t cco_arrived, cci_seen;
    unsigned long refused;
} soak_t;

static unsigned int roll(soak_t *s, unsigned int sides)
{
    s->random = s->random * 1664525u + 1013904223u;
    return (s->random >> 16) % sides;
}

static void remotes_act(soak_t *s)
{
    unsigned int ru = roll(s, RUS);
    if (roll(s, 12) == 0 && s->on[ru] && s->serial < MOST) {
        s->sender[s->serial] = (uint16_t)(ru + 1);
        if (send_from(&s->r, ru + 1, s->serial))
            s->to_controller.serials[s->to_controller.count++] = s->serial;
        else
            s->refused++;
        s->serial++;
    }
    if (roll(s, 40) == 0 && s->to_ru[ru].done == s->to_ru[ru].count) {
        s->on[ru] = !s->on[ru];
        set_ru(&s->r, ru + 1, "on", s->on[ru] ? "1" : "0");
    }
    if (roll(s, 40) == 0 && s->on[ru])
        (void)signal_try_set(&s->r.w, signal_of_ru(ru + 1, "armed"), roll(s, 2) == 0 ? "1" : "0",
                             (char[ECT_SIGNAL_MESSAGE]){0});
}

/* The controller's logic: acknowledge each new command, send when the last one was acknowledged. */
static void controller_acts(soak_t *s)
{
    rig_t *r = &s->r;
    if (r->in[CCI] != s->cci_seen) {
        list_t *list = &s->to_controller;
        assert_true(list->done < list->count);
        unsigned int serial = list->serials[list->done++];
        s->cci_seen++;
        expect_shown(r, s->cci_seen, s->sender[serial], serial);
    }
    if (roll(s, 3) == 0)
        r->out[CAO] = s->cci_seen;
    if (r->in[CAI] == r->out[CCO] && roll(s, 10) == 0 && s->serial < MOST) {
        put_command(r, (uint16_t)roll(s, RUS + 2), s->serial++);
        r->out[CCO]++;
    }
}

/* Updates the model with outputs that have arrived. */
static void outputs_arrived(soak_t *s)
{
    uint16_t id = ect_load_be16(s->r.out + TO_RU);
    if (s->r.out[CCO] == s->cco_arrived)
        return;
    s->cco_arrived = s->r.out[CCO];
    for (unsigned int ru = 0; ru < RUS; ru++) {
        list_t *list = &s->to_ru[ru];
        if (s->on[ru] && (id == 0 || id == ru + 1))
            list->serials[list->count++] = ect_load_be16(s->r.out + DATA_TO_RU);
    }
}

static void check_remotes(soak_t *s)
{
    for (unsigned int ru = 0; ru < RUS; ru++) {
        list_t *list = &s->to_ru[ru];
        char text[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_read(&s->received[ru], text);
        if (strtoul(text, NULL, 10) == list->done)
            continue;
        assert_true(list->done < list->count);
        list->done++;
        expect_received(&s->r, "soak", ru + 1, list->done, list->serials[list->done - 1]);
    }
}

/* A cycle in which frames may be lost or doubled, with a pause in OP now and then. */
static void soak_cycle(soak_t *s)
{
    rig_t *r = &s->r;
    unsigned int fate = roll(s, 20);
    r->out[PCO]++;
    if (roll(s, 150) == 0) {
        wire_advance(&r->w, 200 * MS); /* the watchdog ends OP; two updates may fall into it */
        check_remotes(s);
        to_op(r);
        outputs_arrived(s);
    }
    if (fate != 0) {
        write_outputs(r);
        outputs_arrived(s);
    }
    if (fate == 1)
        write_outputs(r);
    if (fate != 2)
        read_inputs(r);
    controller_acts(s);
}

static void soak(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 6; seed++) {
        soak_t *s = calloc(1, sizeof *s);
        s->random = seed;
        start(&s->r, nodes[seed % COUNT(nodes)], 0);
        for (unsigned int ru = 0; ru < RUS; ru++)
            signal_find(&s->r.w, signal_of_ru(ru + 1, "received_count"), &s->received[ru]);
        for (unsigned int n = 0; n < 12000; n++) {
            remotes_act(s);
            wire_advance(&s->r.w, CYCLE_MS * MS);
            check_remotes(s);
            soak_cycle(s);
            check_remotes(s);
        }
        for (unsigned int n = 0; n < 3000; n++) { /* to the end of all queues */
            s->serial = MOST;
            wire_advance(&s->r.w, CYCLE_MS * MS);
            cycle(&s->r);
            outputs_arrived(s);
            controller_acts(s);
            check_remotes(s);
        }
        if (s->to_controller.done != s->to_controller.count || number(&s->r, "bu.overflows") != s->refused)
            fail_msg("seed %u: %u of %u commands came, %lu overflows for %lu refused", seed, s->to_controller.done,
                     s->to_controller.count, number(&s->r, "bu.overflows"), s->refused);
        for (unsigned int ru = 0; ru < RUS; ru++)
            assert_int_equal(s->to_ru[ru].done, s->to_ru[ru].count);
        assert_true(s->to_controller.count > 200);
        wire_close(&s->r.w);
        free(s);
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-023 ECL-026 ECL-027 ECL-003: a command is in the input data with CCI + 1, id big-endian, 16 bytes",
             from_a_remote),
        TEST("ECL-060 EC-C7 EC-C8: commands are transferred in both directions whether the remote is armed, disarmed, "
             "or another is armed",
             regardless_of_arming),
        TEST("ECL-023: the next command follows only after CAO has acknowledged, in the order of sending, with its own "
             "id",
             one_at_a_time),
        TEST("ECL-023: sixteen commands wait; more are refused and counted, the oldest are kept",
             queue_keeps_the_oldest),
        TEST("ECL-023 ECL-027: a remote that is off sends nothing, and a command has exactly 16 bytes",
             refused_senders),
        TEST("ECL-023: commands wait while the controller is not in OP", waits_for_the_controller),
        TEST("ECL-023 ECL-056: a controller that returns with an old or new CAO finds the same command, once",
             controller_back_with_cao),
        TEST("ECL-025 ECL-050 ECL-051 EC-C8: id 0 addresses all remotes that are on, another id only that one; CAI "
             "follows CCO in any case",
             to_the_addressed),
        TEST("ECL-050: repeated cycles are no command, nor are other bytes with the same CCO", repeated_cycles),
        TEST("ECL-050: each change of CCO is one command, over 255 to 0 and after lost cycles too", counter_steps),
        TEST("ECL-025 ECL-050: 600 commands one after the other are each received once and acknowledged",
             all_values_of_cco),
        TEST("ECL-025 ECL-050: a remote gets the 16 oldest of more than 16 commands in one update in order and the "
             "last; those that CCO skipped are counted",
             faster_than_the_link),
        TEST("ECL-025 ECL-063: on fallback CAI waits for space in the queue, and all 49 commands arrive",
             cai_waits_for_room),
        TEST("ECL-025: CAI follows as soon as a remote receives a command, or can no longer be reached",
             room_for_the_waiting),
        TEST("ECL-025 ECL-050: a command that waits is neither lost nor repeated when the controller returns",
             waiting_over_an_interruption),
        TEST("ECL-003 ECL-051: commands to an id that no remote has are counted", unknown_ids),
        TEST("ECL-050: a controller that returns sends a command only with the old CCO plus one",
             controller_back_with_cco),
        TEST("ECL-050: after power-on CCO is 0: 1 in the first outputs is a command, another value only the start",
             first_counter_after_power_on),
        TEST("ECL-023 ECL-025 ECL-050 ECL-051 ECL-060: random commands in both directions, with lost and repeated "
             "cycles and watchdogs: exactly once, in order",
             soak),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link commands", tests, NULL, NULL);
}
