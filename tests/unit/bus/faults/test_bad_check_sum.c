/* SPDX-License-Identifier: MIT */
/*
 * Frames with a bad check sum (fault "damage wire N"): the chip counts them and nothing else changes, whatever they
 * contain (data sheet I §3, §14.1). Each case first shows that the same frame undamaged has an effect.
 */
#include <stdlib.h>
#include <string.h>

#include "bus/faults/scenario.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { TWINS = 2, MOST_MEMORY = 64 * 1024, SM0 = 0x1000, SM1 = 0x1080, SM2 = 0x1200, SM3 = 0x1300, MAIL = 128 };

typedef struct rig {
    wire_t w;
    ect_scenario_t s;
    uint8_t before[MOST_MEMORY];
} rig_t;

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    const ect_device_t *devices[TWINS] = {&testdev, &testdev};
    assert_non_null(r);
    wire_open(&r->w, devices, TWINS);
    r->s.seed = 7;
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    ect_wires_clear(&r->s.wires);
    wire_close(&r->w);
    free(r);
    return 0;
}

static void set(rig_t *r, const char *text)
{
    char message[ECT_FAULT_MESSAGE] = "";
    ect_fault_t fault;
    if (!ect_fault_parse(text, &fault, message) || !ect_scenario_set(&r->s, r->w.chain, &fault, r->w.now_ns, message))
        fail_msg("'%s': %s", text, message);
}

/* @return whether the frame in w.frame returns */
static bool pass(rig_t *r)
{
    size_t length = r->w.frame_length;
    ect_frame_effects_t fate = ect_scenario_frame(&r->s, r->w.chain, r->w.frame, &length, r->w.now_ns);
    bool back = ect_chain_process(r->w.chain, r->w.frame, length, r->w.now_ns);
    (void)ect_scenario_reply(&r->s, &fate, r->w.frame, &length);
    wire_poll(&r->w);
    return back;
}

/* The state in which every kind of frame has an effect: OP, a mail in SM1, 1 ms since the last outputs. */
static void prepare(rig_t *r)
{
    static const uint8_t upload[] = {0, 0x20, 0x40, 0x18, 0x10, 1};
    wire_go(&r->w, 0, ECT_STATE_OP);
    wire_set_fmmu(&r->w, 0, 0, 0x10000, 3, 0, 7, SM2, 0, 2);
    assert_int_equal(wire_mail_request(&r->w, 0, ECT_MAILBOX_TYPE_COE, upload, sizeof upload), 1);
    assert_int_equal(wire_outputs(&r->w, 0, 0x11), 1);
    assert_int_equal(wire_write8(&r->w, 0, 0x0040, 'R'), 1);
    wire_advance(&r->w, 1 * MS);
}

static const ect_esc_t *chip(const rig_t *r, size_t position)
{
    return ect_chain_esc(r->w.chain, position);
}

/* Address of the first byte that has changed since `before`, beside those of the error counters; -1: none. */
static int changed(const rig_t *r)
{
    const ect_esc_t *esc = chip(r, 0);
    for (uint32_t at = 0; at < esc->memory_size; at++) {
        bool counter = at == 0x0300 || at == 0x0309 || at == 0x030C; /* 0x0309: port 1, on the way back */
        if (!counter && esc->memory[at] != r->before[at])
            return (int)at;
    }
    return -1;
}

static const struct {
    const char *what;
    uint8_t command;
    uint16_t ado;
    const char *data;
    uint16_t length;
} rows[] = {
    {"station address", APWR, 0x0010, "\x34\x12", 2},
    {"DL control", APWR, 0x0100, "\0\0\0\0", 4},
    {"write protection", APWR, 0x0021, "\1", 1},
    {"AL control", APWR, 0x0120, "\2\0", 2},
    {"ECAT event mask", APWR, 0x0200, "\xFF\xFF", 2},
    {"watchdog time", APWR, 0x0420, "\1\0", 2},
    {"EEPROM command", APWR, 0x0502, "\0\1\0\0\0\0", 6},
    {"FMMU", APWR, 0x0610, "\0\0\1\0\1\0\0\7\0\x0F\0\1\1\0\0\0", 16},
    {"SyncManager", APWR, 0x0816, "\0", 1},
    {"receive times", BWR, 0x0900, "\0\0\0\0", 4},
    {"system time offset", APWR, 0x0920, "\1\0\0\0\0\0\0\0", 8},
    {"user RAM", APWR, 0x0F80, "\x5A", 1},
    {"mailbox", APWR, SM0, NULL, MAIL},
    {"read of a mail", APRD, SM1, NULL, MAIL},
    {"outputs", APWR, SM2, "\xFF\xFF\xFF", 3},
    {"logical outputs", LRW, 1, "\xFF\xFF\xFF", 3},
    {"read of inputs", APRD, SM3, NULL, 3},
    {"reset of the error counters", APWR, 0x0300, "\0", 1},
};

static void build(rig_t *r, size_t row)
{
    uint8_t data[MAIL] = {6, 0, 0, 0, 0, 0x73, 0, 0x20, 0x40, 0x18, 0x10, 1};
    if (rows[row].data)
        memcpy(data, rows[row].data, rows[row].length);
    wire_build(&r->w, rows[row].command, 0, rows[row].ado, data, rows[row].length);
}

static void changes_nothing(void **state)
{
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        prepare(r);
        const ect_esc_t *esc = chip(r, 0);
        assert_true(esc->memory_size <= MOST_MEMORY);
        memcpy(r->before, esc->memory, esc->memory_size);
        unsigned int outputs = testdev_of(&r->w, 0)->outputs_calls;
        uint32_t activity = ect_esc_activity(esc);
        set(r, "damage frame 1 wire 1");
        build(r, i);
        if (pass(r) || changed(r) >= 0 || ect_esc_activity(esc) != activity)
            fail_msg("%s: damaged, it changes 0x%04X", rows[i].what, (unsigned int)changed(r));
        assert_int_equal(testdev_of(&r->w, 0)->outputs_calls, outputs);
        assert_int_equal(esc->memory[0x0300], r->before[0x0300] + 1);
        assert_int_equal(esc->memory[0x0309], r->before[0x0309] + 1);
        assert_int_equal(esc->memory[0x030C], r->before[0x030C] + 1);
        build(r, i);
        if (!pass(r) || (changed(r) < 0 && esc->memory[0x0300] != 0))
            fail_msg("%s: undamaged, it changes nothing", rows[i].what);
        ect_chain_power_cycle(r->w.chain, r->w.now_ns);
        wire_assign_stations(&r->w);
    }
}

/* Outputs every 10 ms, in damaged frames, from the second on. @return AL status after 300 ms */
static uint8_t run(rig_t *r, bool damaged)
{
    wire_go(&r->w, 0, ECT_STATE_OP);
    if (damaged)
        set(r, "damage wire 1");
    for (unsigned int cycle = 0; cycle < 30; cycle++) {
        wire_build(&r->w, APWR, 0, SM2, "\1\2\3", 3);
        assert_int_equal(pass(r), !damaged);
        wire_advance(&r->w, 10 * MS);
    }
    if (damaged)
        set(r, "off");
    return wire_read8(&r->w, 0, ECT_REG_AL_STATUS);
}

static void feeds_no_watchdog(void **state)
{
    rig_t *r = *state;
    assert_int_equal(run(r, false), ECT_STATE_OP);
    assert_int_equal(wire_read8(&r->w, 0, 0x0442), 0);
    assert_int_equal(run(r, true), ECT_STATE_SAFEOP | 0x10);
    assert_int_equal(wire_read16(&r->w, 0, ECT_REG_AL_STATUS_CODE), 0x001B);
    assert_int_equal(wire_read8(&r->w, 0, 0x0442), 1);
}

/* The chip next to the wire counts an error of its own port, the next chip a forwarded error. */
static void counters(void **state)
{
    rig_t *r = *state;
    set(r, "damage wire 1");
    for (unsigned int n = 1; n <= 300; n++) {
        unsigned int want = n < 255 ? n : 255;
        wire_build(&r->w, BRD, 0, 0, "\0", 1);
        assert_false(pass(r));
        for (size_t i = 0; i < TWINS; i++) {
            const uint8_t *memory = chip(r, i)->memory;
            assert_int_equal(memory[0x0300], i == 0 ? want : 0);
            assert_int_equal(memory[0x0308], i == 0 ? 0 : want);
            assert_int_equal(memory[0x030C], want);
        }
    }
    set(r, "off");
    assert_int_equal(wire_write8(&r->w, 0, 0x0300, 0), 1);
    assert_int_equal(wire_read8(&r->w, 0, 0x0300), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-011: a frame with a bad check sum changes no register, no SyncManager and no output", changes_nothing,
         setup, teardown, NULL},
        {"CF-011 CF-052: outputs in frames with a bad check sum do not feed the watchdog", feeds_no_watchdog, setup,
         teardown, NULL},
        {"CF-011: 0x0300, 0x0308 and 0x030C count frames with a bad check sum, up to 255", counters, setup, teardown,
         NULL},
    };
    return cmocka_run_group_tests_name("bad check sum", tests, NULL, NULL);
}
