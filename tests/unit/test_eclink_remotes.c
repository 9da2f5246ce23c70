/* SPDX-License-Identifier: MIT */
/* EC-Link remote units: arming, states, fields, switches, links and fallback (TS-0007 §8, §10.5, §10.6). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "support/signals.h"
#include "support/wire.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { OUTPUTS_AT = 0x1000, INPUTS_AT = 0x2800, MOST_INPUTS = 142, MOST_OUTPUTS = 228, CYCLE_MS = 5 };
enum { PCO = 0, CCO = 1, CAO = 3, CCI = 1, BU_STATE = 22, VLAPS = 23, UNARMED = 24, REMOTE = 28, STRIDE = 38 };
enum { STOPPED = 0x01, BLOCKED = 0x03, DISARMED = 0x10, ARMED = 0x11 };
enum { NOTHING, PUSHBUTTON, TWO_POSITION, THREE_POSITION, POTENTIOMETER, BUTTON_LED, DUAL_LED };

static const ect_device_t *const nodes[] = {&ect_eclink_map1, &ect_eclink_map3, &ect_eclink_map7, &ect_eclink_multiarm};

typedef struct rig {
    wire_t w;
    const ect_device_t *device;
    uint8_t out[MOST_OUTPUTS];
    uint8_t in[MOST_INPUTS];
} rig_t;

static void write_outputs(rig_t *r)
{
    if (ect_device_sm_bytes(r->device, 2) > 0)
        assert_int_equal(wire_write(&r->w, 0, OUTPUTS_AT, r->out, ect_device_sm_bytes(r->device, 2)), 1);
}

static void cycle(rig_t *r)
{
    r->out[PCO]++;
    write_outputs(r);
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, ect_device_sm_bytes(r->device, 3)), 1);
}

/* Until the next input data have come. */
static void update(rig_t *r)
{
    uint8_t before = r->in[0];
    for (unsigned int ms = 0; r->in[0] == before && ms <= 125; ms += CYCLE_MS) {
        wire_advance(&r->w, CYCLE_MS * MS);
        cycle(r);
    }
    assert_int_equal(r->in[0], (uint8_t)(before + 1));
}

static void start(rig_t *r, const ect_device_t *device)
{
    memset(r, 0, sizeof *r);
    r->device = device;
    wire_open_one(&r->w, device);
    wire_go(&r->w, 0, ECT_STATE_SAFEOP);
    write_outputs(r);
    assert_int_equal(wire_al(&r->w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    cycle(r);
    update(r);
}

static bool try_set(rig_t *r, const char *name, long value)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    char text[24];
    snprintf(text, sizeof text, "%ld", value);
    bool done = signal_try_set(&r->w, name, text, message);
    if (done != (*message == 0))
        fail_msg("%s := %ld %s, message \"%s\"", name, value, done ? "done" : "refused", message);
    return done;
}

static void set(rig_t *r, const char *name, long value)
{
    if (!try_set(r, name, value))
        fail_msg("%s := %ld was refused", name, value);
}

static long number(rig_t *r, const char *name)
{
    return (long)signal_number(&r->w, name);
}

static void set_ru(rig_t *r, unsigned int ru, const char *signal, long value)
{
    set(r, signal_of_ru(ru, signal), value);
}

static long ru_number(rig_t *r, unsigned int ru, const char *signal)
{
    return number(r, signal_of_ru(ru, signal));
}

static void send_command(rig_t *r, unsigned int ru)
{
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE] = "";
    signal_find(&r->w, signal_of_ru(ru, "command"), &ref);
    if (!ect_signal_write(&ref, "000102030405060708090a0b0c0d0e0f", r->w.now_ns, message))
        fail_msg("%s", message);
}

static void arm(rig_t *r, unsigned int ru)
{
    set_ru(r, ru, "on", 1);
    set_ru(r, ru, "armed", 1);
}

/* The armed remotes' ids in the order of their blocks ("" none), and the BU state; the rest of an empty block is 0. */
static void expect_blocks(rig_t *r, const char *when, const char *ids, uint8_t bu_state)
{
    char got[8] = "";
    update(r);
    unsigned int blocks = (ect_device_sm_bytes(r->device, 3) - REMOTE) / (unsigned int)STRIDE;
    for (unsigned int i = 0; i < blocks; i++) {
        const uint8_t *block = r->in + REMOTE + (size_t)STRIDE * i;
        uint16_t id = ect_load_be16(block);
        for (unsigned int n = 0; id == 0 && n < STRIDE; n++) {
            if (block[n] != 0)
                fail_msg("%s: no remote in block %u, yet its byte %u is %u", when, i + 1, n, block[n]);
        }
        if (id != 0)
            snprintf(got + strlen(got), sizeof got - strlen(got), "%u", id);
    }
    if (strcmp(got, ids) != 0 || r->in[BU_STATE] != bu_state || number(r, "bu.armed") != (long)strlen(ids))
        fail_msg("%s, %s: expected remotes \"%s\", BU state 0x%02X; got \"%s\", 0x%02X, bu.armed %ld",
                 r->device->type_name, when, ids, bu_state, got, r->in[BU_STATE], number(r, "bu.armed"));
    assert_int_equal(number(r, "bu.es_link"), bu_state >= DISARMED);
}

/* --- arming ------------------------------------------------------------------------------------------------------- */

static void only_one(void **state)
{
    (void)state;
    for (size_t n = 0; n < 3; n++) {
        rig_t r;
        start(&r, nodes[n]);
        expect_blocks(&r, "none", "", DISARMED);
        assert_false(try_set(&r, "ru1.armed", 1)); /* is off */
        expect_blocks(&r, "off", "", DISARMED);
        arm(&r, 3);
        expect_blocks(&r, "3 armed", "3", ARMED);
        set(&r, "ru5.on", 1);
        assert_false(try_set(&r, "ru5.armed", 1));
        assert_int_equal(number(&r, "ru5.armed"), 0);
        expect_blocks(&r, "a second one is refused", "3", ARMED);
        set(&r, "ru3.armed", 1);
        expect_blocks(&r, "armed twice", "3", ARMED);
        set(&r, "ru5.armed", 0);
        expect_blocks(&r, "disarming another", "3", ARMED);
        set(&r, "ru3.armed", 0);
        expect_blocks(&r, "disarmed", "", DISARMED);
        set(&r, "ru5.armed", 1);
        expect_blocks(&r, "now the other", "5", ARMED);
        wire_close(&r.w);
    }
}

static void up_to_three(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[3]);
    arm(&r, 8);
    expect_blocks(&r, "first", "8", ARMED);
    arm(&r, 2);
    expect_blocks(&r, "second", "82", ARMED);
    arm(&r, 5);
    expect_blocks(&r, "third", "825", ARMED);
    set(&r, "ru1.on", 1);
    assert_false(try_set(&r, "ru1.armed", 1));
    expect_blocks(&r, "a fourth is refused", "825", ARMED);
    set(&r, "ru2.armed", 0);
    expect_blocks(&r, "the second disarmed", "85", ARMED);
    set(&r, "ru1.armed", 1);
    expect_blocks(&r, "another comes last", "851", ARMED);
    set(&r, "ru8.armed", 0);
    set(&r, "ru8.armed", 1);
    expect_blocks(&r, "disarmed and armed again comes last", "518", ARMED);
    set(&r, "ru5.armed", 0);
    set(&r, "ru1.armed", 0);
    expect_blocks(&r, "one is left", "8", ARMED);
    set(&r, "ru8.armed", 0);
    expect_blocks(&r, "none", "", DISARMED);
    wire_close(&r.w);
}

static void unarmed_are_counted(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        start(&r, nodes[n]);
        for (unsigned int ru = 1; ru <= 8; ru++) {
            assert_int_equal(r.in[UNARMED], ru - 1);
            set_ru(&r, ru, "on", 1);
            update(&r);
        }
        assert_int_equal(r.in[UNARMED], 8);
        set(&r, "ru4.armed", 1);
        update(&r);
        assert_int_equal(r.in[UNARMED], 7);
        set(&r, "ru1.on", 0);
        update(&r);
        assert_int_equal(r.in[UNARMED], 6);
        assert_int_equal(number(&r, "bu.unarmed"), 6);
        wire_close(&r.w);
    }
}

static void blocked_until_rearmed(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        start(&r, nodes[n]);
        set(&r, "ru2.on", 1);
        set(&r, "ru2.on", 0);
        expect_blocks(&r, "an unarmed remote goes", "", DISARMED);
        arm(&r, 1);
        set(&r, "ru1.on", 0);
        assert_int_equal(number(&r, "ru1.armed"), 0);
        expect_blocks(&r, "the armed remote is lost", "", BLOCKED);
        assert_false(try_set(&r, "ru1.armed", 1));
        expect_blocks(&r, "it must be turned on first", "", BLOCKED);
        set(&r, "ru1.on", 1);
        expect_blocks(&r, "turned on, not rearmed", "", BLOCKED);
        set(&r, "ru1.armed", 0);
        expect_blocks(&r, "disarmed is not rearmed", "", BLOCKED);
        set(&r, "ru1.armed", 1);
        expect_blocks(&r, "rearmed", "1", ARMED);
        set(&r, "ru1.armed", 0);
        set(&r, "ru1.on", 0);
        expect_blocks(&r, "disarmed first, then turned off", "", DISARMED);
        wire_close(&r.w);
    }
}

static void blocked_with_three(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[3]);
    arm(&r, 1);
    arm(&r, 2);
    arm(&r, 3);
    set(&r, "ru1.on", 0);
    set(&r, "ru3.on", 0);
    expect_blocks(&r, "two of three lost", "2", BLOCKED);
    arm(&r, 3);
    expect_blocks(&r, "one of them rearmed", "23", BLOCKED);
    arm(&r, 1);
    expect_blocks(&r, "both rearmed", "231", ARMED);
    wire_close(&r.w);
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static const struct ru_case {
    long stop, shock, failed, disabled;
    uint8_t ru_state, bu_state;
} ru_cases[] = {
    {0, 0, 0, 0, 3, ARMED},   {0, 0, 0, 1, 2, ARMED},   {0, 0, 0, 2, 2, ARMED},   {0, 0, 0, 3, 2, ARMED},
    {1, 0, 0, 0, 4, STOPPED}, {0, 1, 0, 0, 4, STOPPED}, {1, 1, 0, 0, 4, STOPPED}, {1, 0, 0, 2, 4, STOPPED},
    {0, 0, 1, 0, 5, STOPPED}, {1, 1, 1, 3, 5, STOPPED}, {0, 0, 1, 1, 5, STOPPED}, {0, 1, 0, 1, 4, STOPPED},
};

static void set_case(rig_t *r, unsigned int ru, const struct ru_case *c)
{
    set_ru(r, ru, "stop", c->stop);
    set_ru(r, ru, "shock", c->shock);
    set_ru(r, ru, "failed", c->failed);
    set_ru(r, ru, "disabled", c->disabled);
}

static void ru_states(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(nodes) * COUNT(ru_cases); i++) {
        const struct ru_case *c = &ru_cases[i % COUNT(ru_cases)];
        rig_t r;
        start(&r, nodes[i / COUNT(ru_cases)]);
        set(&r, "ru1.on", 1);
        set_case(&r, 1, c);
        expect_blocks(&r, "unarmed", "", DISARMED);
        assert_int_equal(number(&r, "ru1.state"), 0);
        set(&r, "ru1.armed", 1);
        expect_blocks(&r, "armed", "1", c->bu_state);
        if (r.in[REMOTE + 2] != c->ru_state || r.in[REMOTE + 7] != c->disabled)
            fail_msg("stop %ld, shock %ld, failed %ld, disabled %ld: expected RU state %u, got %u, disabled %u",
                     c->stop, c->shock, c->failed, c->disabled, c->ru_state, r.in[REMOTE + 2], r.in[REMOTE + 7]);
        set_case(&r, 1, &ru_cases[0]);
        expect_blocks(&r, "at rest again", "1", ARMED);
        assert_int_equal(r.in[REMOTE + 2], 3);
        wire_close(&r.w);
    }
}

static void one_of_three_stops(void **state)
{
    (void)state;
    for (unsigned int which = 1; which <= 3; which++) {
        rig_t r;
        start(&r, nodes[3]);
        for (unsigned int ru = 1; ru <= 3; ru++)
            arm(&r, ru);
        set(&r, "ru4.on", 1);
        set(&r, "ru4.stop", 1);
        expect_blocks(&r, "an unarmed remote's stop switch", "123", ARMED);
        set_ru(&r, which, "stop", 1);
        expect_blocks(&r, "one of three stops", "123", STOPPED);
        for (unsigned int ru = 1; ru <= 3; ru++)
            assert_int_equal(r.in[REMOTE + STRIDE * (ru - 1) + 2], ru == which ? 4 : 3);
        set_ru(&r, which, "stop", 0);
        expect_blocks(&r, "released", "123", ARMED);
        wire_close(&r.w);
    }
}

/* --- fields ------------------------------------------------------------------------------------------------------- */

/* Offsets from byte 28, sizes, and the values to try (TS-0007 §8). */
static const struct field {
    const char *signal;
    uint8_t offset, size;
    long values[5];
} fields[] = {
    {"id", 0, 2, {1, 255, 256, 0x1234, 65535}},
    {"battery", 3, 1, {0, 1, 50, 99, 100}},
    {"rssi", 4, 1, {0, 1, 50, 99, 100}},
    {"cable", 5, 1, {0, 1, 0, 1, 0}},
    {"docked", 6, 1, {0, 1, 0, 1, 0}},
    {"disabled", 7, 1, {1, 2, 3, 0, 1}},
    {"joystick1", 10, 2, {-1000, -1, 0, 1, 1000}},
    {"joystick2", 12, 2, {-1000, -256, 255, 256, 1000}},
    {"joystick3", 14, 2, {-1000, -1, 0, 1, 1000}},
    {"joystick4", 16, 2, {-999, -1, 0, 1, 999}},
    {"switch1", 18, 2, {0, 1, 255, 256, 1000}},
    {"switch2", 20, 2, {0, 1, 255, 256, 1000}},
    {"switch3", 22, 2, {0, 1, 255, 256, 1000}},
    {"switch4", 24, 2, {0, 1, 255, 256, 1000}},
    {"switch5", 26, 2, {0, 1, 255, 256, 1000}},
    {"switch6", 28, 2, {0, 1, 255, 256, 1000}},
    {"switch7", 30, 2, {0, 1, 255, 256, 1000}},
    {"switch8", 32, 2, {0, 1, 255, 256, 1000}},
    {"encoder", 34, 1, {0, 1, 128, 255, 0}},
    {"encoder_switch", 35, 1, {1, 0, 1, 0, 1}},
};

static void check_field(rig_t *r, unsigned int ru, unsigned int block, const struct field *f, long value)
{
    uint8_t want[MOST_INPUTS];
    unsigned int at = REMOTE + STRIDE * block + f->offset;
    memcpy(want, r->in, sizeof want);
    set_ru(r, ru, f->signal, value);
    update(r);
    if (f->size == 2)
        ect_store_be16(want + at, (uint16_t)value);
    else
        want[at] = (uint8_t)value;
    want[0] = r->in[0];                                   /* PCI */
    want[2] = r->in[2];                                   /* PAI */
    want[at - f->offset + 2] = r->in[at - f->offset + 2]; /* RU state follows "disabled" */
    for (unsigned int i = 0; i < ect_device_sm_bytes(r->device, 3); i++) {
        if (r->in[i] != want[i])
            fail_msg("%s, ru%u.%s := %ld: expected byte %u to be 0x%02X, got 0x%02X", r->device->type_name, ru,
                     f->signal, value, i, want[i], r->in[i]);
    }
}

static void fields_at_their_offsets(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        unsigned int blocks = n == 3 ? 3 : 1;
        start(&r, nodes[n]);
        for (unsigned int block = 0; block < blocks; block++) {
            arm(&r, 8 - block);
            for (unsigned int s = 1; s <= 8; s++) {
                char name[12];
                snprintf(name, sizeof name, "fitted%u", s);
                set_ru(&r, 8 - block, name, POTENTIOMETER);
            }
        }
        update(&r);
        for (size_t i = 0; i < COUNT(fields) * blocks * 5; i++) {
            unsigned int block = (unsigned int)(i / 5 % blocks);
            const struct field *f = &fields[i / 5 / blocks];
            check_field(&r, 8 - block, block, f, f->values[i % 5]);
        }
        for (unsigned int block = 0; block < blocks; block++) {
            assert_int_equal(r.in[REMOTE + STRIDE * block + 36], 0);
            assert_int_equal(r.in[REMOTE + STRIDE * block + 37], 0);
        }
        wire_close(&r.w);
    }
}

static void ranges(void **state)
{
    static const struct {
        const char *signal;
        long low, high;
    } rows[] = {{"ru1.id", 1, 65535},
                {"ru1.on", 0, 1},
                {"ru1.armed", 0, 1},
                {"ru1.stop", 0, 1},
                {"ru1.shock", 0, 1},
                {"ru1.failed", 0, 1},
                {"ru1.disabled", 0, 3},
                {"ru1.battery", 0, 100},
                {"ru1.rssi", 0, 100},
                {"ru1.cable", 0, 1},
                {"ru1.docked", 0, 1},
                {"ru1.g_link_lost", 0, 1},
                {"ru1.joystick1", -1000, 1000},
                {"ru1.joystick4", -1000, 1000},
                {"ru1.encoder", 0, 255},
                {"ru1.encoder_switch", 0, 1},
                {"ru1.fitted1", 0, 6},
                {"ru1.fitted8", 0, 6},
                {"bu.vlaps", 0, 3},
                {"bu.eg_link", 0, 7},
                {"bu.report_passive", 0, 1}};
    (void)state;
    rig_t r;
    start(&r, nodes[3]);
    set(&r, "ru1.on", 1);
    for (size_t i = 0; i < COUNT(rows); i++) {
        set(&r, rows[i].signal, rows[i].low);
        assert_int_equal(number(&r, rows[i].signal), rows[i].low);
        assert_false(try_set(&r, rows[i].signal, rows[i].low - 1));
        set(&r, "ru1.on", 1);
        set(&r, rows[i].signal, rows[i].high);
        assert_false(try_set(&r, rows[i].signal, rows[i].high + 1));
        if (number(&r, rows[i].signal) != rows[i].high)
            fail_msg("%s: expected %ld after a refused value, got %ld", rows[i].signal, rows[i].high,
                     number(&r, rows[i].signal));
    }
    wire_close(&r.w);
}

static void switch_kinds(void **state)
{
    static const struct {
        long kind, low, high;
    } kinds[] = {{PUSHBUTTON, 0, 1},       {TWO_POSITION, 0, 1}, {THREE_POSITION, -1, 1},
                 {POTENTIOMETER, 0, 1000}, {BUTTON_LED, 0, 3},   {DUAL_LED, 0, 3}};
    (void)state;
    rig_t r;
    start(&r, nodes[2]);
    arm(&r, 1);
    for (unsigned int i = 0; i < COUNT(kinds) * 8; i++) {
        char fitted[16], name[16];
        unsigned int at = REMOTE + 18 + 2 * (i % 8);
        long low = kinds[i / 8].low, high = kinds[i / 8].high;
        snprintf(fitted, sizeof fitted, "ru1.fitted%u", i % 8 + 1);
        snprintf(name, sizeof name, "ru1.switch%u", i % 8 + 1);
        set(&r, fitted, kinds[i / 8].kind);
        assert_int_equal(number(&r, name), 0); /* starts at rest */
        for (long value = low - 2; value <= high + 2; value++) {
            bool allowed = value >= low && value <= high;
            long before = number(&r, name);
            if (try_set(&r, name, value) != allowed || number(&r, name) != (allowed ? value : before))
                fail_msg("%s, kind %ld: %ld must be %s", name, kinds[i / 8].kind, value, allowed ? "taken" : "refused");
        }
        set(&r, name, low);
        update(&r);
        assert_int_equal(ect_load_be16(r.in + at), (uint16_t)low);
        set(&r, name, high);
        update(&r);
        assert_int_equal(ect_load_be16(r.in + at), (uint16_t)high);
        set(&r, fitted, NOTHING);
        assert_false(try_set(&r, name, 1));
        update(&r);
        assert_int_equal(ect_load_be16(r.in + at), 0);
    }
    wire_close(&r.w);
}

/* --- nothing armed ------------------------------------------------------------------------------------------------ */

static void nothing_armed(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        start(&r, nodes[n]);
        set(&r, "ru1.on", 1);
        set(&r, "ru1.joystick1", -1);
        set(&r, "ru1.switch1", 1);
        set(&r, "ru1.encoder", 255);
        expect_blocks(&r, "on, not armed", "", DISARMED);
        set(&r, "ru1.armed", 1);
        expect_blocks(&r, "armed", "1", ARMED);
        set(&r, "ru1.armed", 0);
        expect_blocks(&r, "disarmed", "", DISARMED);
        set(&r, "bu.report_passive", 1);
        update(&r);
        for (unsigned int i = REMOTE; i < ect_device_sm_bytes(r.device, 3); i++) {
            if (r.in[i] != (i == 36 ? 6 : 0))
                fail_msg("passive is reported: expected byte %u to be %u, got %u", i, i == 36 ? 6 : 0, r.in[i]);
        }
        set(&r, "ru1.armed", 1);
        update(&r);
        assert_int_equal(r.in[36], 1); /* never passive while a remote is armed */
        for (unsigned int i = 66; i < ect_device_sm_bytes(r.device, 3); i++)
            assert_int_equal(r.in[i], 0);
        set(&r, "ru1.on", 0);
        update(&r);
        assert_int_equal(r.in[36], 6);
        set(&r, "bu.report_passive", 0);
        update(&r);
        assert_int_equal(r.in[36], 0);
        wire_close(&r.w);
    }
}

/* --- links -------------------------------------------------------------------------------------------------------- */

static void vlaps_are_told(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[0]);
    for (uint8_t vlaps = 0; vlaps <= 3; vlaps++) {
        set(&r, "bu.vlaps", vlaps);
        update(&r);
        assert_int_equal(r.in[VLAPS], vlaps);
    }
    wire_close(&r.w);
}

static void armed_falls_back(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        start(&r, nodes[n]);
        set(&r, "bu.vlaps", 1);
        arm(&r, 1);
        expect_blocks(&r, "G-Link", "1", ARMED);
        assert_int_equal(r.in[36], 1);
        assert_int_equal(r.in[37], 1);
        set(&r, "ru1.g_link_lost", 1);
        expect_blocks(&r, "fallback", "1", ARMED);
        assert_int_equal(r.in[36], 1);
        assert_int_equal(r.in[37], 7);
        set(&r, "ru1.joystick2", 321);
        update(&r);
        assert_int_equal(ect_load_be16(r.in + 40), 321);
        set(&r, "ru1.cable", 1);
        expect_blocks(&r, "on cable", "1", ARMED);
        assert_int_equal(r.in[37], 1);
        set(&r, "ru1.cable", 0);
        set(&r, "ru1.g_link_lost", 0);
        expect_blocks(&r, "G-Link again", "1", ARMED);
        assert_int_equal(r.in[37], 1);
        set(&r, "ru1.g_link_lost", 1);
        set(&r, "bu.vlaps", 0);
        expect_blocks(&r, "without VLAP communication is lost", "", BLOCKED);
        assert_int_equal(r.in[UNARMED], 0);
        set(&r, "ru1.g_link_lost", 0);
        expect_blocks(&r, "not rearmed", "", BLOCKED);
        assert_int_equal(r.in[UNARMED], 1);
        set(&r, "ru1.armed", 1);
        expect_blocks(&r, "rearmed", "1", ARMED);
        wire_close(&r.w);
    }
}

/* Remotes 1 to 5 are on; which of them are armed, on cable, have lost G-Link, and what becomes of them. */
static const struct reservation {
    const char *what;
    long vlaps;
    const char *armed, *cable, *lost;
    const char *g_link; /* of remotes 1 to 5 */
} reservations[] = {
    {"all on G-Link", 3, "1", "", "", "11111"},
    {"armed, one VLAP", 1, "1", "", "1", "71111"},
    {"unarmed, one VLAP", 1, "", "", "2", "17111"},
    {"unarmed, no VLAP", 0, "", "", "2", "12111"},
    {"unarmed, the only VLAP is reserved", 1, "1", "", "2", "12111"},
    {"unarmed, the armed one is on cable and reserves none", 1, "1", "1", "2", "17111"},
    {"unarmed on cable", 0, "", "2", "2", "11111"},
    {"one VLAP is left", 2, "1", "", "234", "17221"},
    {"two VLAPs are left", 3, "1", "", "2345", "17722"},
    {"no VLAP is left", 3, "123", "", "45", "11122"},
    {"each armed one has its own", 3, "123", "", "123", "77711"},
    {"each armed one has its own, the others nothing", 3, "123", "", "12345", "77722"},
    {"armed ones with a higher number", 2, "45", "", "1245", "22177"},
    {"armed on cable, with a higher number", 2, "45", "5", "124", "72171"},
};

static void reservations_hold(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(reservations); i++) {
        const struct reservation *c = &reservations[i];
        rig_t r;
        char got[6] = "";
        start(&r, nodes[3]);
        set(&r, "bu.vlaps", c->vlaps);
        for (unsigned int ru = 1; ru <= 5; ru++) {
            set_ru(&r, ru, "on", 1);
            set_ru(&r, ru, "cable", strchr(c->cable, (char)('0' + ru)) != NULL);
            set_ru(&r, ru, "armed", strchr(c->armed, (char)('0' + ru)) != NULL);
        }
        for (unsigned int ru = 1; ru <= 5; ru++)
            set_ru(&r, ru, "g_link_lost", strchr(c->lost, (char)('0' + ru)) != NULL);
        for (unsigned int ru = 1; ru <= 5; ru++)
            got[ru - 1] = (char)('0' + ru_number(&r, ru, "g_link"));
        expect_blocks(&r, c->what, c->armed, c->armed[0] ? ARMED : DISARMED);
        long unarmed = 0;
        for (unsigned int ru = 0; ru < 5; ru++)
            unarmed += c->g_link[ru] != '2' && !strchr(c->armed, (char)('1' + ru));
        if (strcmp(got, c->g_link) != 0 || r.in[UNARMED] != unarmed)
            fail_msg("%s: expected G-Link %s, %ld unarmed; got %s, %u", c->what, c->g_link, unarmed, got,
                     r.in[UNARMED]);
        wire_close(&r.w);
    }
}

/* With fewer VLAPs than armed remotes the first to be armed has reserved, whatever its number. */
static void reserved_in_the_order_of_arming(void **state)
{
    static const unsigned int orders[][2] = {{1, 2}, {2, 1}, {3, 8}, {8, 3}};
    (void)state;
    for (size_t i = 0; i < COUNT(orders); i++) {
        rig_t r;
        char first[2] = {(char)('0' + orders[i][0]), 0};
        start(&r, nodes[3]);
        set(&r, "bu.vlaps", 1);
        arm(&r, orders[i][0]);
        arm(&r, orders[i][1]);
        set_ru(&r, orders[i][0], "g_link_lost", 1);
        update(&r);
        assert_int_equal(r.in[37], 7);
        set_ru(&r, orders[i][1], "g_link_lost", 1);
        expect_blocks(&r, "the second finds no VLAP, the first stays on fallback", first, BLOCKED);
        assert_int_equal(r.in[37], 7);
        wire_close(&r.w);
    }
}

/* Neither G-Link nor a VLAP nor a cable: such a remote is out of communication. */
static void unreachable(rig_t *r)
{
    start(r, nodes[3]);
    set(r, "bu.vlaps", 0);
    set(r, "ru1.on", 1);
    set(r, "ru1.g_link_lost", 1);
    update(r);
    assert_int_equal(number(r, "ru1.g_link"), 2);
    assert_int_equal(r->in[UNARMED], 0);
}

static void periodic_set(rig_t *r)
{
    ect_store_be16(r->out + 24, 10);
    cycle(r);
    ect_store_be16(r->out + 24, 0);
}

static void nothing_reaches_the_unreachable(void **state)
{
    (void)state;
    rig_t r;
    unreachable(&r);
    r.out[CCO]++;
    periodic_set(&r);
    for (unsigned int n = 0; n < 4; n++)
        update(&r);
    if (ru_number(&r, 1, "received_count") != 0 || ru_number(&r, 1, "periodic_count") != 0)
        fail_msg("a remote without any link got %ld commands and %ld sets of periodic data",
                 ru_number(&r, 1, "received_count"), ru_number(&r, 1, "periodic_count"));
    wire_close(&r.w);
}

static void the_unreachable_cannot_be_armed(void **state)
{
    (void)state;
    rig_t r;
    unreachable(&r);
    assert_false(try_set(&r, "ru1.armed", 1));
    expect_blocks(&r, "not armed, so not lost either", "", DISARMED);
    wire_close(&r.w);
}

static void the_unreachable_cannot_send(void **state)
{
    (void)state;
    rig_t r;
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE] = "";
    unreachable(&r);
    signal_find(&r.w, "ru1.command", &ref);
    assert_false(ect_signal_write(&ref, "000102030405060708090a0b0c0d0e0f", r.w.now_ns, message));
    update(&r);
    update(&r);
    assert_int_equal(r.in[CCI], 0);
    wire_close(&r.w);
}

/* --- priorities --------------------------------------------------------------------------------------------------- */

/* At which update, counted from the moment when all wait at once, each thing has come through; 0 never. */
typedef struct passed {
    unsigned int from, to, periodic, joystick;
} passed_t;

static passed_t watch(rig_t *r, unsigned int ru, unsigned int updates)
{
    passed_t at = {0};
    for (unsigned int n = 1; n <= updates; n++) {
        uint8_t cci = r->in[CCI];
        set_ru(r, ru, "joystick1", n);
        update(r);
        at.from = at.from == 0 && r->in[CCI] != cci ? n : at.from;
        at.to = at.to == 0 && ru_number(r, ru, "received_count") > 0 ? n : at.to;
        at.periodic = at.periodic == 0 && ru_number(r, ru, "periodic_count") > 0 ? n : at.periodic;
        at.joystick += ect_load_be16(r->in + REMOTE + 10) == n;
        r->out[CAO] = r->in[CCI];
    }
    return at;
}

static void fallback_priorities(void **state)
{
    (void)state;
    for (unsigned int lost = 0; lost <= 1; lost++) {
        rig_t r;
        start(&r, nodes[2]);
        arm(&r, 1);
        set(&r, "ru1.g_link_lost", lost);
        update(&r);
        send_command(&r, 1);
        r.out[CCO]++;
        periodic_set(&r);
        passed_t at = watch(&r, 1, 6);
        bool good =
            lost == 0 ? at.from == 1 && at.to == 1 && at.periodic == 1 : at.from == 1 && at.to == 2 && at.periodic == 3;
        if (!good || at.joystick != 6)
            fail_msg(
                "%s: command from the remote in update %u, to it in %u, periodic data in %u, %u of 6 joystick values",
                lost ? "fallback" : "G-Link", at.from, at.to, at.periodic, at.joystick);
        wire_close(&r.w);
    }
}

/* Two commands from the remote: both go before one to it, and that before periodic data. */
static void fallback_order(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[2]);
    arm(&r, 1);
    set(&r, "ru1.g_link_lost", 1);
    update(&r);
    send_command(&r, 1);
    send_command(&r, 1);
    r.out[CCO]++;
    periodic_set(&r);
    passed_t at = watch(&r, 1, 8);
    if (r.in[CCI] != 2 || at.to < 2 || at.periodic <= at.to || at.joystick != 8)
        fail_msg("commands from the remote %u, to it in update %u, periodic data in %u", r.in[CCI], at.to, at.periodic);
    wire_close(&r.w);
}

static void fallback_is_a_matter_of_each_remote(void **state)
{
    (void)state;
    rig_t r;
    start(&r, nodes[2]);
    set(&r, "ru1.on", 1);
    set(&r, "ru2.on", 1);
    set(&r, "ru2.g_link_lost", 1);
    update(&r);
    send_command(&r, 1);
    send_command(&r, 1);
    send_command(&r, 1);
    r.out[CCO]++;
    periodic_set(&r);
    update(&r);
    assert_int_equal(number(&r, "ru1.received_count"), 1);
    assert_int_equal(number(&r, "ru1.periodic_count"), 1);
    assert_int_equal(number(&r, "ru2.received_count"), 1);
    assert_int_equal(number(&r, "ru2.periodic_count"), 0);
    update(&r);
    assert_int_equal(number(&r, "ru2.periodic_count"), 1);
    wire_close(&r.w);
}

#define TEST(title, function)                                                                                          \
    {                                                                                                                  \
        title, function, NULL, NULL, NULL                                                                              \
    }

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-048 ECL-028 ECL-029: without MultiArm one remote that is on can be armed, a second is refused",
             only_one),
        TEST("ECL-048 ECL-047: with MultiArm three, in blocks in the order of arming; a fourth is refused",
             up_to_three),
        TEST("ECL-030 ECL-032: remotes that are on and not armed are counted", unarmed_are_counted),
        TEST("ECL-028: an armed remote that is lost blocks the BU until it is on and rearmed", blocked_until_rearmed),
        TEST("ECL-028 ECL-047: with MultiArm each lost remote must be rearmed", blocked_with_three),
        TEST(
            "ECL-037 ECL-038 ECL-039 ECL-040 ECL-041 EC-C10: RU state and BU state follow stop, shock, failure and the "
            "reason for being disabled",
            ru_states),
        TEST("ECL-039 ECL-047: one of three armed remotes stops the BU, an unarmed one does not", one_of_three_stops),
        TEST("ECL-003 ECL-035 ECL-042 ECL-043 ECL-045 ECL-046 ECL-047: each field at its offset, big-endian, and no "
             "other "
             "byte moves",
             fields_at_their_offsets),
        TEST("ECL-031 ECL-041 ECL-042 ECL-043 ECL-046: values outside the ranges are refused and change nothing",
             ranges),
        TEST("ECL-044 EC-C11: the six kinds of switches at all eight positions take their values and no others",
             switch_kinds),
        TEST("ECL-034 ECL-036 ECL-061 EC-C9: nothing armed: all its bytes are 0, or byte 36 is 6 when that is set",
             nothing_armed),
        TEST("ECL-031: the number of VLAPs is told", vlaps_are_told),
        TEST("ECL-033 ECL-064 ECL-065: an armed remote without G-Link is on fallback, without VLAP it is lost",
             armed_falls_back),
        TEST("ECL-064 ECL-065 ECL-032: armed remotes have a VLAP of their own, the others share what is left",
             reservations_hold),
        TEST("ECL-064: an armed remote on fallback keeps its VLAP when one that was armed later wants one too",
             reserved_in_the_order_of_arming),
        TEST("ECL-064: a remote without G-Link and VLAP receives neither commands nor periodic data",
             nothing_reaches_the_unreachable),
        TEST("ECL-064 ECL-028: a remote without G-Link and VLAP cannot be armed", the_unreachable_cannot_be_armed),
        TEST("ECL-064: a remote without G-Link and VLAP cannot send", the_unreachable_cannot_send),
        TEST("ECL-063: on fallback one thing an update: command from the remote, command to it, periodic data; on "
             "G-Link "
             "all at once; joysticks always",
             fallback_priorities),
        TEST("ECL-063: on fallback all commands from the remote go before commands to it, those before periodic data",
             fallback_order),
        TEST("ECL-063: a remote on fallback is not held up by another's commands", fallback_is_a_matter_of_each_remote),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link remotes", tests, NULL, NULL);
}
