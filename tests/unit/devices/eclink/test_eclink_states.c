/* SPDX-License-Identifier: MIT */
/* The EC-Link base unit itself: its errors, causes, arming, mode Disabled, power and period (TS-0007 §2.1, §8, §10.3,
 * §11).
 */
#include <string.h>

#include "support/base_unit.h"

/* --- the unit's own errors ---------------------------------------------------------------------------------------- */

static void module_error(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        bu_set(&r, "bu.module_error", "1");
        bu_expect(&r, "module error at power-on", INITIAL, MODULE_ERROR);
        bu_to_op(&r);
        r.counting = true;
        bu_run(&r, 20 * MS);
        bu_expect_reported(&r, "module error since power-on", INITIAL, MODULE_ERROR);
        bu_set(&r, "bu.module_error", "0");
        bu_expect_reported(&r, "no module error", DISARMED, OPERATIONAL);
        bu_set(&r, "ru1.on", "1");
        bu_set(&r, "ru1.armed", "1");
        bu_set(&r, "bu.module_error", "1");
        bu_expect_reported(&r, "module error after the first good exchange", LINK_ERROR, MODULE_ERROR);
        bu_set(&r, "bu.module_error", "0");
        bu_expect_reported(&r, "no module error any more", ARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void failed(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        bu_set(&r, "bu.failed", "1");
        bu_expect(&r, "failed before the first exchange", FAILED, NO_LINK);
        bu_set(&r, "bu.failed", "0");
        wire_close(&r.w);
        int good = bu_in_order(&r, node, true);
        bu_set(&r, "bu.failed", "1");
        bu_expect_reported(&r, "failed", FAILED, OPERATIONAL);
        bu_set(&r, "bu.module_error", "1");
        bu_expect_reported(&r, "failed, and a module error", FAILED, MODULE_ERROR);
        bu_set(&r, "bu.module_error", "0");
        bu_set(&r, "bu.failed", "0");
        bu_expect_reported(&r, "repaired", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* §8.2: 2 no link, 3 link error, 4 interface error, 5 data error; §8.1: an error in EC-Link or EG-Link is state 02. */
static void eg_link(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        for (uint8_t value = 0; value <= 7; value++) {
            bu_rig_t r;
            char text[2] = {(char)('0' + value), 0};
            int good = bu_in_order(&r, node, true);
            bu_set(&r, "bu.eg_link", text);
            bu_expect_reported(&r, text, value >= 2 && value <= 5 ? LINK_ERROR : good, OPERATIONAL);
            assert_int_equal(r.in[EG_LINK], value);
            bu_set(&r, "bu.eg_link", "0");
            bu_expect_reported(&r, "EG-Link unused", good, OPERATIONAL);
            wire_close(&r.w);
        }
    }
}

/* --- causes, arming, errors that stay ----------------------------------------------------------------------------- */

static void expect_cause(bu_rig_t *r, const char *what, uint8_t state, const char *want)
{
    char cause[ECT_SIGNAL_TEXT_ROOM];
    bu_get(r, "bu.cause", cause);
    if (bu_number(r, "bu.state") != state || strcmp(cause, want) != 0)
        fail_msg("%s: expected BU state 0x%02X because '%s', got 0x%02lX because '%s'", what, state, want,
                 (unsigned long)bu_number(r, "bu.state"), cause);
}

static void causes(void **state)
{
    static const struct {
        const char *set[3], *value[3];
        uint8_t state;
        const char *cause;
    } rows[] = {
        {{"ru2.stop"}, {"1"}, STOPPED, "ru2: the stop switch is pressed"},
        {{"ru1.shock"}, {"1"}, STOPPED, "ru1: free fall or shock was detected"},
        {{"ru1.failed", "ru1.stop"}, {"1", "1"}, STOPPED, "ru1: it has an internal error"},
        {{"ru1.stop", "ru2.stop"}, {"1", "1"}, STOPPED, "ru2: the stop switch is pressed"}, /* was armed first */
        {{"ru1.disabled"}, {"1"}, ARMED, ""},
        {{"ru1.on"}, {"0"}, BLOCKED, "ru1: communication is lost; turn it on and rearm it"},
        {{"ru1.on", "ru2.stop"}, {"0", "1"}, BLOCKED, "ru1: communication is lost; turn it on and rearm it"},
        {{"ru2.on", "ru1.on"}, {"0", "0"}, BLOCKED, "ru2: communication is lost; turn it on and rearm it"},
        {{"bu.eg_link", "ru1.on"}, {"2", "0"}, LINK_ERROR, "EG-Link: no link"},
        {{"bu.eg_link"}, {"3"}, LINK_ERROR, "EG-Link: link error"},
        {{"bu.eg_link"}, {"4"}, LINK_ERROR, "EG-Link: interface error"},
        {{"bu.eg_link"}, {"5"}, LINK_ERROR, "EG-Link: data error"},
        {{"bu.eg_link"}, {"7"}, ARMED, ""},
        {{"bu.module_error", "bu.eg_link"}, {"1", "5"}, LINK_ERROR, "the fieldbus module reports an error"},
        {{"bu.failed", "bu.module_error"}, {"1", "1"}, FAILED, "self-diagnostics has found a fatal internal error"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        bu_rig_t r;
        bu_in_order(&r, &bu_nodes[3], false);
        bu_set(&r, "ru2.on", "1");
        bu_set(&r, "ru2.armed", "1");
        bu_set(&r, "ru1.on", "1");
        bu_set(&r, "ru1.armed", "1");
        for (size_t n = 0; n < 3 && rows[i].set[n]; n++)
            bu_set(&r, rows[i].set[n], rows[i].value[n]);
        expect_cause(&r, rows[i].set[0], rows[i].state, rows[i].cause);
        wire_close(&r.w);
    }
}

static void expect_arming(bu_rig_t *r, const char *when, bool possible, const char *why)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    bool done = signal_try_set(&r->w, "ru1.armed", "1", message);
    if (done != possible || (!possible && !strstr(message, why)))
        fail_msg("%s, %s: expected arming to be %s (%s); it was %s: %s", r->node->device->type_name, when,
                 possible ? "possible" : "refused", why, done ? "done" : "refused", message);
    bu_set(r, "ru1.armed", "0");
}

static void arming_needs_an_operative_unit(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        bu_set(&r, "ru1.on", "1");
        expect_arming(&r, "INIT", false, "Initial");
        wire_go(&r.w, 0, ECT_STATE_SAFEOP);
        expect_arming(&r, "SAFEOP", false, "Initial");
        bu_to_op(&r);
        r.counting = true;
        if ((node->duties & PERIODIC) != 0)
            expect_arming(&r, "OP, PCO has not moved", false, "Initial");
        bu_run(&r, 30 * MS);
        expect_arming(&r, "in order", true, "");
        bu_set(&r, "bu.module_error", "1");
        expect_arming(&r, "module error", false, "External link error");
        bu_set(&r, "bu.module_error", "0");
        bu_set(&r, "bu.eg_link", "5");
        expect_arming(&r, "EG-Link error", false, "External link error");
        bu_set(&r, "bu.eg_link", "0");
        bu_set(&r, "bu.failed", "1");
        expect_arming(&r, "failed", false, "failed");
        bu_set(&r, "bu.failed", "0");
        expect_arming(&r, "in order again", true, "");
        wire_close(&r.w);
    }
}

/* Read strictly, §11 locks the unit in its error; the other reading is the default. */
static void errors_that_stay(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_power_on(&r, &bu_nodes[2]);
    bu_set(&r, "bu.lock_errors", "1");
    bu_to_op(&r);
    bu_expect(&r, "before the first good exchange", INITIAL, DATA_ERROR);
    r.counting = true;
    bu_run(&r, 30 * MS);
    bu_expect_reported(&r, "an error at the start is not permanent", DISARMED, OPERATIONAL);
    r.counting = false;
    bu_run(&r, 2000 * MS);
    r.counting = true;
    bu_run(&r, 200 * MS);
    bu_expect_reported(&r, "PCO counts again", INITIAL, DATA_ERROR);
    expect_cause(&r, "PCO counts again", INITIAL, "PCO does not increment");
    bu_set(&r, "bu.module_error", "1");
    bu_set(&r, "bu.module_error", "0");
    bu_expect(&r, "another error takes its place", INITIAL, MODULE_ERROR);
    bu_set(&r, "bu.enabled", "0");
    bu_expect(&r, "unused features have no errors", DISARMED, UNUSED);
    bu_set(&r, "bu.enabled", "1");
    bu_expect(&r, "used again", DISARMED, OPERATIONAL);
    bu_set(&r, "bu.module_error", "1");
    bu_set(&r, "bu.module_error", "0");
    bu_expect(&r, "and locked again", INITIAL, MODULE_ERROR);
    bu_set(&r, "bu.restart", "1");
    bu_expect(&r, "power was off", INITIAL, NO_LINK);
    assert_int_equal(bu_number(&r, "bu.lock_errors"), 1);
    wire_assign_stations(&r.w);
    bu_to_op(&r);
    bu_run(&r, 30 * MS);
    bu_expect_reported(&r, "after the restart", DISARMED, OPERATIONAL);
    r.counting = false;
    bu_run(&r, 2000 * MS);
    r.counting = true;
    bu_run(&r, 200 * MS);
    bu_expect(&r, "locked", INITIAL, DATA_ERROR);
    bu_set(&r, "bu.lock_errors", "0");
    bu_expect(&r, "no longer locked", DISARMED, OPERATIONAL);
    wire_close(&r.w);
}

static void worse_state_wins(void **state)
{
    (void)state;
    bu_rig_t r;
    int good = bu_in_order(&r, &bu_nodes[3], true);
    bu_set(&r, "ru2.on", "1");
    bu_set(&r, "ru2.armed", "1");
    bu_set(&r, "ru1.stop", "1");
    bu_expect_reported(&r, "an armed remote stops", STOPPED, OPERATIONAL);
    bu_set(&r, "ru2.on", "0");
    bu_expect_reported(&r, "another is lost", BLOCKED, OPERATIONAL);
    r.counting = false;
    bu_run(&r, 2000 * MS);
    bu_expect_reported(&r, "PCO is late", LINK_ERROR, DATA_ERROR);
    r.counting = true;
    bu_run(&r, 10 * MS);
    bu_expect_reported(&r, "PCO again", BLOCKED, OPERATIONAL);
    bu_set(&r, "ru2.on", "1");
    bu_set(&r, "ru2.armed", "1");
    bu_expect_reported(&r, "rearmed", STOPPED, OPERATIONAL);
    bu_set(&r, "ru1.stop", "0");
    bu_expect_reported(&r, "released", good, OPERATIONAL);
    wire_close(&r.w);
}

/* --- mode Disabled ------------------------------------------------------------------------------------------------ */

static void disabled_alone(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        uint8_t byte = 0;
        bu_power_on(&r, node);
        assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), 1);
        bu_set(&r, "bu.enabled", "0");
        assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), NO_REPLY);
        bu_expect(&r, "Disabled", DISARMED, UNUSED);
        wire_advance(&r.w, 10000 * MS);
        bu_expect(&r, "Disabled for 10 s", DISARMED, UNUSED);
        bu_set(&r, "ru1.on", "1");
        bu_set(&r, "ru1.armed", "1");
        bu_expect(&r, "Disabled, armed", ARMED, UNUSED);
        bu_set(&r, "bu.module_error", "1");
        bu_expect(&r, "a module that is not used", ARMED, UNUSED);
        bu_set(&r, "bu.module_error", "0");
        bu_set(&r, "bu.enabled", "1");
        bu_expect(&r, "enabled again", INITIAL, NO_LINK);
        assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), 1);
        bu_to_op(&r);
        r.counting = true;
        bu_run(&r, 20 * MS);
        bu_expect_reported(&r, "in order", ARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void enable(wire_t *w, size_t position, const char *value)
{
    const ect_slave_t *slave = ect_chain_slave(w->chain, position);
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE];
    assert_true(ect_signal_find(&ect_eclink_plant, slave->config.instance, "bu.enabled", &ref));
    assert_true(ect_signal_write(&ref, value, w->now_ns, message));
    ect_chain_wake(w->chain, position);
    wire_poll(w);
}

static void disabled_in_a_chain(void **state)
{
    static const ect_device_t *const three[] = {&ect_eclink_map1, &ect_eclink_map7, &ect_eclink_multiarm};
    static const int answers[] = {NO_REPLY, 1, 2};
    (void)state;
    for (size_t off = 0; off < 3; off++) {
        wire_t w;
        uint8_t byte = 0;
        wire_open(&w, three, 3);
        assert_int_equal(wire_send(&w, BRD, 0, 0x0000, &byte, 1), 3);
        enable(&w, off, "0");
        int count = wire_send(&w, BRD, 0, 0x0000, &byte, 1);
        if (count != answers[off])
            fail_msg("unit %zu of 3 is disabled: expected %d answers, got %d", off, answers[off], count);
        enable(&w, off, "1");
        assert_int_equal(wire_send(&w, BRD, 0, 0x0000, &byte, 1), 3);
        wire_close(&w);
    }
}

/* ESC register DL status 0x0110: bits 5 link, 10 loop closed, 11 communication of port 1. */
static void neighbour_sees_no_link(void **state)
{
    static const ect_device_t *const two[] = {&ect_eclink_map1, &ect_eclink_map7};
    enum { PORT1 = 0x0C20, LINK = 0x0820, CLOSED = 0x0400 };
    (void)state;
    wire_t w;
    wire_open(&w, two, 2);
    assert_int_equal(wire_read16(&w, 0, 0x0110) & PORT1, LINK);
    enable(&w, 1, "0");
    unsigned int status = wire_read16(&w, 0, 0x0110) & PORT1;
    if (status != CLOSED)
        fail_msg("nothing replies behind it: expected port 1 without link and closed (0x%04X), got 0x%04X", CLOSED,
                 status);
    enable(&w, 1, "1");
    assert_int_equal(wire_read16(&w, 0, 0x0110) & PORT1, LINK);
    wire_close(&w);
}

/* --- power -------------------------------------------------------------------------------------------------------- */

static void power_is_cycled(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        char text[ECT_SIGNAL_TEXT_ROOM];
        bu_in_order(&r, node, true);
        if (node->duties != 0) {
            bu_command_shown(&r);
            r.out[CCO]++;
            bu_run(&r, 200 * MS);
            assert_int_equal(bu_number(&r, "ru1.received_count"), 1);
        }
        bu_set(&r, "ru1.id", "777");
        bu_set(&r, "ru1.joystick1", "-5");
        bu_set(&r, "bu.vlaps", "2");
        bu_set(&r, "bu.frozen", "1");
        bu_set(&r, "ru1.g_link", "3");
        bu_set(&r, "bu.restart", "1");
        bu_expect(&r, "power is back", INITIAL, NO_LINK);
        assert_int_equal(wire_read(&r.w, 0, ECT_REG_AL_STATUS, text, 1), 0); /* no station address */
        static const struct {
            const char *signal;
            long value;
        } rows[] = {
            {"bu.pci", 0},         {"bu.cci", 0},   {"bu.cai", 0},     {"bu.frozen", 0},          {"bu.armed", 0},
            {"ru1.armed", 0},      {"ru1.on", 1},   {"ru1.id", 777},   {"ru1.received_count", 0}, {"bu.restart", 0},
            {"ru1.joystick1", -5}, {"bu.vlaps", 2}, {"ru1.g_link", 3}, {"bu.unarmed", 1},
        };
        for (size_t i = 0; i < COUNT(rows); i++) {
            if (bu_number(&r, rows[i].signal) != rows[i].value)
                fail_msg("%s: expected %s to be %ld after the restart, got %ld", node->device->type_name,
                         rows[i].signal, rows[i].value, bu_number(&r, rows[i].signal));
        }
        wire_assign_stations(&r.w);
        memset(r.out, 0, sizeof r.out);
        bu_to_op(&r);
        bu_run(&r, 200 * MS);
        bu_expect_reported(&r, "in order again", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void restart_of_a_disabled_unit(void **state)
{
    (void)state;
    bu_rig_t r;
    uint8_t byte = 0;
    bu_power_on(&r, &bu_nodes[0]);
    bu_set(&r, "bu.enabled", "0");
    bu_set(&r, "bu.restart", "0"); /* nothing */
    bu_set(&r, "bu.restart", "1");
    assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), NO_REPLY);
    bu_expect(&r, "Disabled is a setting, not a state", DISARMED, UNUSED);
    bu_set(&r, "bu.enabled", "1");
    assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), 1);
    wire_close(&r.w);
}

/* --- PCI ---------------------------------------------------------------------------------------------------------- */

static void expect_pci(bu_rig_t *r, const char *when, uint8_t want)
{
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, 1), 1);
    if (r->in[PCI] != want || bu_number(r, "bu.pci") != want)
        fail_msg("%s, %s: expected PCI %u, got %u on the wire and bu.pci %ld", r->node->device->type_name, when, want,
                 r->in[PCI], bu_number(r, "bu.pci"));
}

static void pci_rhythm(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        bu_to_op(&r);
        r.counting = true;
        for (unsigned int n = 0; n < 300; n++) { /* through 255 -> 0 */
            bu_run(&r, 124 * MS);
            expect_pci(&r, "124 ms after an update", (uint8_t)n);
            bu_run(&r, 1 * MS);
            expect_pci(&r, "125 ms after an update", (uint8_t)(n + 1));
        }
        wire_close(&r.w);
    }
}

static void pci_counts_in_error(void **state)
{
    static const struct {
        const char *name, *value;
    } errors[] = {{"bu.module_error", "1"}, {"bu.failed", "1"}, {"bu.eg_link", "3"}, {"ru1.on", "0"}};
    (void)state;
    bu_rig_t r;
    bu_in_order(&r, &bu_nodes[2], true);
    for (size_t i = 0; i < COUNT(errors); i++) {
        uint8_t pci = r.in[PCI];
        bu_set(&r, errors[i].name, errors[i].value);
        bu_run(&r, 500 * MS);
        expect_pci(&r, errors[i].name, (uint8_t)(pci + 4));
    }
    r.counting = false;
    uint8_t pci = r.in[PCI];
    bu_run(&r, 4000 * MS);
    expect_pci(&r, "PCO late", (uint8_t)(pci + 32));
    wire_close(&r.w);
}

/* Between two updates the input data never change. */
static void inputs_hold_between_updates(void **state)
{
    (void)state;
    bu_rig_t r;
    uint8_t before[MOST_INPUTS];
    bu_in_order(&r, &bu_nodes[2], true);
    memcpy(before, r.in, sizeof before);
    bu_set(&r, "ru1.stop", "1");
    bu_set(&r, "ru1.switch1", "1");
    bu_set(&r, "bu.vlaps", "1");
    bu_expect(&r, "at once", STOPPED, OPERATIONAL);
    for (unsigned int n = 0; r.in[PCI] == before[PCI] && n < 20; n++) {
        assert_memory_equal(r.in, before, 66);
        bu_run(&r, 10 * MS);
    }
    assert_int_equal(r.in[PCI], before[PCI] + 1);
    assert_int_equal(r.in[BU_STATE], STOPPED);
    assert_int_equal(r.in[23], 1);
    assert_int_equal(ect_load_be16(r.in + 46), 1);
    wire_close(&r.w);
}

/* §10.3: the controller must detect that PCI stops while the bus stays in OP. */
static void frozen_inputs(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        uint8_t before[MOST_INPUTS];
        int good = bu_in_order(&r, node, true);
        memcpy(before, r.in, sizeof before);
        bu_set(&r, "bu.frozen", "1");
        bu_set(&r, "ru1.joystick1", "12");
        if (node->duties != 0)
            bu_set(&r, "ru1.command", "000102030405060708090a0b0c0d0e0f");
        r.out[CCO]++;
        bu_run(&r, 5000 * MS);
        assert_memory_equal(r.in, before, sizeof before);
        assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), ECT_STATE_OP);
        bu_expect(&r, "the unit goes on supervising", good, OPERATIONAL);
        bu_set(&r, "bu.frozen", "0");
        bu_run(&r, 125 * MS);
        assert_int_equal(r.in[PCI], (uint8_t)(before[PCI] + 1));
        assert_int_equal(r.in[CCI], node->duties != 0 ? 1 : 0);
        assert_int_equal(ect_load_be16(r.in + 38), 12);
        wire_close(&r.w);
    }
}

static void late_polls(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_power_on(&r, &bu_nodes[0]);
    wire_go(&r.w, 0, ECT_STATE_SAFEOP);
    r.w.now_ns += 170 * MS; /* 45 ms late */
    wire_poll(&r.w);
    expect_pci(&r, "called late", 1);
    wire_advance(&r.w, 79 * MS);
    expect_pci(&r, "the rhythm did not shift: not yet", 1);
    wire_advance(&r.w, 1 * MS);
    expect_pci(&r, "the rhythm did not shift", 2);
    r.w.now_ns += 1000 * MS;
    wire_poll(&r.w);
    expect_pci(&r, "missed updates are not made up for", 3);
    wire_advance(&r.w, 125 * MS);
    expect_pci(&r, "and on it goes", 4);
    wire_close(&r.w);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-066 EC-C6: an error of the module is Module Error: Initial before, External link error after the "
             "first good exchange",
             module_error),
        TEST("ECL-028 ECL-029: a fatal internal error is Failed, whatever the other errors", failed),
        TEST("ECL-028 ECL-033: EG-Link status 2 to 5 is External link error, the other values are not", eg_link),
        TEST("ECL-028: every state except Armed and Disarmed has its cause", causes),
        TEST("ECL-028 ECL-068: nothing is armed while the BU is Initial, Failed or has a link error",
             arming_needs_an_operative_unit),
        TEST("ECL-068 EC-C6: errors end with their cause; with lock_errors the unit is locked in Initial until power "
             "is cycled",
             errors_that_stay),
        TEST("ECL-028 ECL-029: External link error has priority over Blocked, Blocked over Stopped", worse_state_wins),
        TEST("ECL-002 ECL-069: Disabled: no reply, EC-Link Unused, no message, nothing supervised; enabled it starts "
             "Initial",
             disabled_alone),
        TEST("ECL-002: a disabled unit in a chain is absent, with all slaves behind it", disabled_in_a_chain),
        TEST("ECL-002: the unit in front of a disabled unit shows no link at that port", neighbour_sees_no_link),
        TEST("ECL-028 ECL-068: power is cycled: Initial, counters 0, nothing armed; the surroundings are kept",
             power_is_cycled),
        TEST("ECL-002: a disabled unit is disabled after a restart too", restart_of_a_disabled_unit),
        TEST("ECL-020 ECL-021: PCI counts exactly every 125 ms, from 255 to 0", pci_rhythm),
        TEST("ECL-022: PCI continues to count in every error", pci_counts_in_error),
        TEST("ECL-020: input data change only together with PCI", inputs_hold_between_updates),
        TEST("ECL-020 ECL-022: frozen, PCI and all input data stop, and the bus stays in OP", frozen_inputs),
        TEST("ECL-020: late polls neither shift the period nor cause additional updates", late_polls),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link states", tests, NULL, NULL);
}
