/* SPDX-License-Identifier: MIT */
/* EC-Link remote units: arming, states, fields, switches (TS-0007 §8, §10.5). */
#include <stdio.h>
#include <string.h>

#include "support/base_unit.h"

enum { NOTHING, PUSHBUTTON, TWO_POSITION, THREE_POSITION, POTENTIOMETER, BUTTON_LED, DUAL_LED };

/* --- arming ------------------------------------------------------------------------------------------------------- */

static void only_one(void **state)
{
    (void)state;
    for (size_t n = 0; n < 3; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_expect_blocks(&r, "none", "", DISARMED);
        assert_false(bu_try_set(&r, "ru1.armed", 1)); /* is off */
        bu_expect_blocks(&r, "off", "", DISARMED);
        bu_arm(&r, 3);
        bu_expect_blocks(&r, "3 armed", "3", ARMED);
        bu_set_number(&r, "ru5.on", 1);
        assert_false(bu_try_set(&r, "ru5.armed", 1));
        assert_int_equal(bu_number(&r, "ru5.armed"), 0);
        bu_expect_blocks(&r, "a second one is refused", "3", ARMED);
        bu_set_number(&r, "ru3.armed", 1);
        bu_expect_blocks(&r, "armed twice", "3", ARMED);
        bu_set_number(&r, "ru5.armed", 0);
        bu_expect_blocks(&r, "disarming another", "3", ARMED);
        bu_set_number(&r, "ru3.armed", 0);
        bu_expect_blocks(&r, "disarmed", "", DISARMED);
        bu_set_number(&r, "ru5.armed", 1);
        bu_expect_blocks(&r, "now the other", "5", ARMED);
        wire_close(&r.w);
    }
}

static void up_to_three(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[3]);
    bu_arm(&r, 8);
    bu_expect_blocks(&r, "first", "8", ARMED);
    bu_arm(&r, 2);
    bu_expect_blocks(&r, "second", "82", ARMED);
    bu_arm(&r, 5);
    bu_expect_blocks(&r, "third", "825", ARMED);
    bu_set_number(&r, "ru1.on", 1);
    assert_false(bu_try_set(&r, "ru1.armed", 1));
    bu_expect_blocks(&r, "a fourth is refused", "825", ARMED);
    bu_set_number(&r, "ru2.armed", 0);
    bu_expect_blocks(&r, "the second disarmed", "85", ARMED);
    bu_set_number(&r, "ru1.armed", 1);
    bu_expect_blocks(&r, "another comes last", "851", ARMED);
    bu_set_number(&r, "ru8.armed", 0);
    bu_set_number(&r, "ru8.armed", 1);
    bu_expect_blocks(&r, "disarmed and armed again, it is the last", "518", ARMED);
    bu_set_number(&r, "ru5.armed", 0);
    bu_set_number(&r, "ru1.armed", 0);
    bu_expect_blocks(&r, "one is left", "8", ARMED);
    bu_set_number(&r, "ru8.armed", 0);
    bu_expect_blocks(&r, "none", "", DISARMED);
    wire_close(&r.w);
}

static void unarmed_are_counted(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        for (unsigned int ru = 1; ru <= 8; ru++) {
            assert_int_equal(r.in[UNARMED], ru - 1);
            bu_set_ru(&r, ru, "on", 1);
            bu_update(&r);
        }
        assert_int_equal(r.in[UNARMED], 8);
        bu_set_number(&r, "ru4.armed", 1);
        bu_update(&r);
        assert_int_equal(r.in[UNARMED], 7);
        bu_set_number(&r, "ru1.on", 0);
        bu_update(&r);
        assert_int_equal(r.in[UNARMED], 6);
        assert_int_equal(bu_number(&r, "bu.unarmed"), 6);
        wire_close(&r.w);
    }
}

static void blocked_until_rearmed(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_set_number(&r, "ru2.on", 1);
        bu_set_number(&r, "ru2.on", 0);
        bu_expect_blocks(&r, "an unarmed remote goes", "", DISARMED);
        bu_arm(&r, 1);
        bu_set_number(&r, "ru1.on", 0);
        assert_int_equal(bu_number(&r, "ru1.armed"), 0);
        bu_expect_blocks(&r, "the armed remote is lost", "", BLOCKED);
        assert_false(bu_try_set(&r, "ru1.armed", 1));
        bu_expect_blocks(&r, "it must be turned on first", "", BLOCKED);
        bu_set_number(&r, "ru1.on", 1);
        bu_expect_blocks(&r, "turned on, not rearmed", "", BLOCKED);
        bu_set_number(&r, "ru1.armed", 0);
        bu_expect_blocks(&r, "disarmed is not rearmed", "", BLOCKED);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "rearmed", "1", ARMED);
        bu_set_number(&r, "ru1.armed", 0);
        bu_set_number(&r, "ru1.on", 0);
        bu_expect_blocks(&r, "disarmed first, then turned off", "", DISARMED);
        wire_close(&r.w);
    }
}

static void blocked_with_three(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[3]);
    bu_arm(&r, 1);
    bu_arm(&r, 2);
    bu_arm(&r, 3);
    bu_set_number(&r, "ru1.on", 0);
    bu_set_number(&r, "ru3.on", 0);
    bu_expect_blocks(&r, "two of three lost", "2", BLOCKED);
    bu_arm(&r, 3);
    bu_expect_blocks(&r, "one of them rearmed", "23", BLOCKED);
    bu_arm(&r, 1);
    bu_expect_blocks(&r, "both rearmed", "231", ARMED);
    wire_close(&r.w);
}

/* A lost remote that never returns: another one takes its place if no other place is free. */
static void replaced(void **state)
{
    (void)state;
    for (size_t n = 0; n < 3; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_arm(&r, 1);
        bu_set_number(&r, "ru1.on", 0);
        bu_expect_blocks(&r, "lost", "", BLOCKED);
        bu_arm(&r, 2);
        bu_expect_blocks(&r, "another is armed: without MultiArm, in its place", "2", ARMED);
        bu_set_number(&r, "ru2.armed", 0);
        bu_expect_blocks(&r, "and disarmed", "", DISARMED);
        wire_close(&r.w);
    }
    bu_rig_t r;
    bu_start(&r, &bu_nodes[3]);
    for (unsigned int ru = 1; ru <= 3; ru++)
        bu_arm(&r, ru);
    bu_set_number(&r, "ru2.on", 0);
    bu_set_number(&r, "ru1.on", 0);
    bu_arm(&r, 4);
    bu_expect_blocks(&r, "two of three lost, the first replaced", "34", BLOCKED);
    char cause[ECT_SIGNAL_TEXT_ROOM];
    bu_get(&r, "bu.cause", cause);
    assert_string_equal(cause, "ru1: communication is lost; turn it on and rearm it");
    bu_arm(&r, 2);
    bu_expect_blocks(&r, "the other is replaced by the remote that was replaced before", "342", ARMED);
    wire_close(&r.w);
    bu_start(&r, &bu_nodes[3]);
    bu_arm(&r, 1);
    bu_arm(&r, 2);
    bu_set_number(&r, "ru1.on", 0);
    bu_arm(&r, 3);
    bu_expect_blocks(&r, "another place was free", "23", BLOCKED);
    bu_arm(&r, 1);
    bu_expect_blocks(&r, "rearmed", "231", ARMED);
    wire_close(&r.w);
}

/* Several signals of one request: the twin is not polled in between. */
static void on_and_armed_at_once(void **state)
{
    static const char *const settings[][2] = {
        {"ru1.on", "1"}, {"ru1.armed", "1"}, {"ru1.command", "00112233445566778899aabbccddeeff"}};
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[2]);
    for (size_t i = 0; i < COUNT(settings); i++) {
        ect_signal_ref_t ref;
        char message[ECT_SIGNAL_MESSAGE] = "";
        signal_find(&r.w, settings[i][0], &ref);
        if (!ect_signal_write(&ref, settings[i][1], r.w.now_ns, message))
            fail_msg("%s", message);
    }
    bu_expect_blocks(&r, "armed", "1", ARMED);
    wire_close(&r.w);
}

static void ids_are_unique(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[3]);
    assert_false(bu_try_set(&r, "ru1.id", 8));
    assert_int_equal(bu_number(&r, "ru1.id"), 1);
    bu_set_number(&r, "ru1.id", 1);
    bu_set_number(&r, "ru8.id", 300);
    bu_set_number(&r, "ru1.id", 8);
    assert_false(bu_try_set(&r, "ru8.id", 8));
    assert_int_equal(bu_number(&r, "ru8.id"), 300);
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

static void set_case(bu_rig_t *r, unsigned int ru, const struct ru_case *c)
{
    bu_set_ru(r, ru, "stop", c->stop);
    bu_set_ru(r, ru, "shock", c->shock);
    bu_set_ru(r, ru, "failed", c->failed);
    bu_set_ru(r, ru, "disabled", c->disabled);
}

static void ru_states(void **state)
{
    (void)state;
    for (size_t i = 0; i < BU_NODES * COUNT(ru_cases); i++) {
        const struct ru_case *c = &ru_cases[i % COUNT(ru_cases)];
        bu_rig_t r;
        bu_start(&r, &bu_nodes[i / COUNT(ru_cases)]);
        bu_set_number(&r, "ru1.on", 1);
        set_case(&r, 1, c);
        bu_set_number(&r, "ru1.joystick2", -77);
        bu_set_number(&r, "ru1.switch1", 1);
        bu_set_number(&r, "ru1.encoder", 99);
        bu_expect_blocks(&r, "unarmed", "", DISARMED);
        assert_int_equal(bu_number(&r, "ru1.state"), 0);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "armed", "1", c->bu_state);
        if (r.in[REMOTE + 2] != c->ru_state || r.in[REMOTE + 7] != c->disabled)
            fail_msg("stop %ld, shock %ld, failed %ld, disabled %ld: expected RU state %u, got %u, disabled %u",
                     c->stop, c->shock, c->failed, c->disabled, c->ru_state, r.in[REMOTE + 2], r.in[REMOTE + 7]);
        if (ect_load_be16(r.in + 40) != (uint16_t)(c->ru_state == 3 ? -77 : 0) || r.in[47] != 1 || r.in[62] != 99)
            fail_msg("RU state %u: expected the joysticks to be %s and nothing else; got 0x%04X, switch %u, encoder %u",
                     c->ru_state, c->ru_state == 3 ? "as they are" : "passive", ect_load_be16(r.in + 40), r.in[47],
                     r.in[62]);
        set_case(&r, 1, &ru_cases[0]);
        bu_expect_blocks(&r, "at rest again", "1", ARMED);
        assert_int_equal(r.in[REMOTE + 2], 3);
        wire_close(&r.w);
    }
}

static void one_of_three_stops(void **state)
{
    (void)state;
    for (unsigned int which = 1; which <= 3; which++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[3]);
        for (unsigned int ru = 1; ru <= 3; ru++)
            bu_arm(&r, ru);
        bu_set_number(&r, "ru4.on", 1);
        bu_set_number(&r, "ru4.stop", 1);
        bu_expect_blocks(&r, "an unarmed remote's stop switch", "123", ARMED);
        bu_set_ru(&r, which, "stop", 1);
        bu_expect_blocks(&r, "one of three stops", "123", STOPPED);
        for (unsigned int ru = 1; ru <= 3; ru++)
            assert_int_equal(r.in[REMOTE + STRIDE * (ru - 1) + 2], ru == which ? 4 : 3);
        bu_set_ru(&r, which, "stop", 0);
        bu_expect_blocks(&r, "released", "123", ARMED);
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
    {"id", 0, 2, {9, 255, 256, 0x1234, 65535}},
    {"battery", 3, 1, {0, 1, 50, 99, 100}},
    {"rssi", 4, 1, {0, 1, 50, 99, 100}},
    {"cable", 5, 1, {0, 1, 0, 1, 0}},
    {"docked", 6, 1, {0, 1, 0, 1, 0}},
    {"disabled", 7, 1, {1, 2, 3, 1, 0}},
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

static void check_field(bu_rig_t *r, unsigned int ru, unsigned int block, const struct field *f, long value)
{
    uint8_t want[MOST_INPUTS];
    unsigned int at = REMOTE + STRIDE * block + f->offset;
    memcpy(want, r->in, sizeof want);
    bu_set_ru(r, ru, f->signal, value);
    bu_update(r);
    if (f->size == 2)
        ect_store_be16(want + at, (uint16_t)value);
    else
        want[at] = (uint8_t)value;
    want[0] = r->in[0];                                   /* PCI */
    want[2] = r->in[2];                                   /* PAI */
    want[at - f->offset + 2] = r->in[at - f->offset + 2]; /* RU state follows "disabled" */
    want[at - f->offset + 8] = r->in[at - f->offset + 8]; /* C-Link status follows "rssi" */
    for (unsigned int i = 0; i < ect_device_sm_bytes(r->node->device, 3); i++) {
        if (r->in[i] != want[i])
            fail_msg("%s, ru%u.%s := %ld: expected byte %u to be 0x%02X, got 0x%02X", r->node->device->type_name, ru,
                     f->signal, value, i, want[i], r->in[i]);
    }
}

static void fields_at_their_offsets(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        unsigned int blocks = n == 3 ? 3 : 1;
        bu_start(&r, &bu_nodes[n]);
        for (unsigned int block = 0; block < blocks; block++) {
            bu_arm(&r, 8 - block);
            for (unsigned int s = 1; s <= 8; s++) {
                char name[12];
                snprintf(name, sizeof name, "fitted%u", s);
                bu_set_ru(&r, 8 - block, name, POTENTIOMETER);
            }
        }
        bu_update(&r);
        for (size_t i = 0; i < COUNT(fields) * blocks * 5; i++) {
            unsigned int block = (unsigned int)(i / 5 % blocks);
            const struct field *f = &fields[i / 5 / blocks];
            check_field(&r, 8 - block, block, f, f->values[i % 5] - (f == fields ? block : 0)); /* ids are unique */
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
    bu_rig_t r;
    bu_start(&r, &bu_nodes[3]);
    bu_set_number(&r, "ru1.on", 1);
    for (size_t i = 0; i < COUNT(rows); i++) {
        bu_set_number(&r, rows[i].signal, rows[i].low);
        assert_int_equal(bu_number(&r, rows[i].signal), rows[i].low);
        assert_false(bu_try_set(&r, rows[i].signal, rows[i].low - 1));
        bu_set_number(&r, "ru1.on", 1);
        bu_set_number(&r, rows[i].signal, rows[i].high);
        assert_false(bu_try_set(&r, rows[i].signal, rows[i].high + 1));
        if (bu_number(&r, rows[i].signal) != rows[i].high)
            fail_msg("%s: expected %ld after a refused value, got %ld", rows[i].signal, rows[i].high,
                     bu_number(&r, rows[i].signal));
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
    bu_rig_t r;
    bu_start(&r, &bu_nodes[2]);
    bu_arm(&r, 1);
    for (unsigned int i = 0; i < COUNT(kinds) * 8; i++) {
        char fitted[16], name[16];
        unsigned int at = REMOTE + 18 + 2 * (i % 8);
        long low = kinds[i / 8].low, high = kinds[i / 8].high;
        snprintf(fitted, sizeof fitted, "ru1.fitted%u", i % 8 + 1);
        snprintf(name, sizeof name, "ru1.switch%u", i % 8 + 1);
        bu_set_number(&r, fitted, kinds[i / 8].kind);
        assert_int_equal(bu_number(&r, name), 0); /* starts at rest */
        for (long value = low - 2; value <= high + 2; value++) {
            bool allowed = value >= low && value <= high;
            long before = bu_number(&r, name);
            if (bu_try_set(&r, name, value) != allowed || bu_number(&r, name) != (allowed ? value : before))
                fail_msg("%s, kind %ld: %ld must be %s", name, kinds[i / 8].kind, value, allowed ? "taken" : "refused");
        }
        bu_set_number(&r, name, low);
        bu_update(&r);
        assert_int_equal(ect_load_be16(r.in + at), (uint16_t)low);
        bu_set_number(&r, name, high);
        bu_update(&r);
        assert_int_equal(ect_load_be16(r.in + at), (uint16_t)high);
        bu_set_number(&r, fitted, NOTHING);
        assert_false(bu_try_set(&r, name, 1));
        bu_update(&r);
        assert_int_equal(ect_load_be16(r.in + at), 0);
    }
    wire_close(&r.w);
}

/* --- nothing armed ------------------------------------------------------------------------------------------------ */

static void nothing_armed(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_set_number(&r, "ru1.on", 1);
        bu_set_number(&r, "ru1.joystick1", -1);
        bu_set_number(&r, "ru1.switch1", 1);
        bu_set_number(&r, "ru1.encoder", 255);
        bu_expect_blocks(&r, "on, not armed", "", DISARMED);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "armed", "1", ARMED);
        bu_set_number(&r, "ru1.armed", 0);
        bu_expect_blocks(&r, "disarmed", "", DISARMED);
        bu_set_number(&r, "bu.report_passive", 1);
        bu_update(&r);
        for (unsigned int i = REMOTE; i < ect_device_sm_bytes(r.node->device, 3); i++) {
            if (r.in[i] != (i == 36 ? 6 : 0))
                fail_msg("passive is reported: expected byte %u to be %u, got %u", i, i == 36 ? 6 : 0, r.in[i]);
        }
        bu_set_number(&r, "ru1.armed", 1);
        bu_update(&r);
        assert_int_equal(r.in[36], 1); /* never passive while a remote is armed */
        for (unsigned int i = 66; i < ect_device_sm_bytes(r.node->device, 3); i++)
            assert_int_equal(r.in[i], 0);
        bu_set_number(&r, "ru1.on", 0);
        bu_update(&r);
        assert_int_equal(r.in[36], 6);
        bu_set_number(&r, "bu.report_passive", 0);
        bu_update(&r);
        assert_int_equal(r.in[36], 0);
        wire_close(&r.w);
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

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
        TEST("ECL-028 ECL-048: a lost remote that never returns is replaced by another one", replaced),
        TEST("ECL-048: switched on, armed and at work in one go", on_and_armed_at_once),
        TEST("ECL-036 ECL-051: ids are unique", ids_are_unique),
        TEST(
            "ECL-037 ECL-038 ECL-039 ECL-040 ECL-041 ECL-043 EC-C10: RU state and BU state follow stop, shock, failure "
            "and the reason for being disabled; joysticks are passive in all but Enabled",
            ru_states),
        TEST("ECL-039 ECL-047: one of three armed remotes stops the BU, an unarmed one does not", one_of_three_stops),
        TEST("ECL-003 ECL-035 ECL-042 ECL-043 ECL-045 ECL-046 ECL-047: each field at its offset, big-endian, and no "
             "other byte changes",
             fields_at_their_offsets),
        TEST("ECL-031 ECL-041 ECL-042 ECL-043 ECL-046: values outside the ranges are refused and change nothing",
             ranges),
        TEST("ECL-044 EC-C11: the six kinds of switches at all eight positions take their values and no others",
             switch_kinds),
        TEST("ECL-034 ECL-036 ECL-061 EC-C9: nothing armed: all its bytes are 0, or byte 36 is 6 when that is set",
             nothing_armed),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link remotes", tests, NULL, NULL);
}
