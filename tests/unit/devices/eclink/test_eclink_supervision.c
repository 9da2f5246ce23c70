/* SPDX-License-Identifier: MIT */
/* The EC-Link base unit supervises its controller: BU state, EC-Link status, message and relays (TS-0007 §6.1, §10,
 * §11). */
#include <stdio.h>
#include <string.h>

#include "support/base_unit.h"

/* --- the way to normal operation ---------------------------------------------------------------------------------- */

static void initial_until_data(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        bu_expect(&r, "INIT", INITIAL, NO_LINK);
        wire_go(&r.w, 0, ECT_STATE_PREOP);
        bu_expect(&r, "PREOP", INITIAL, NO_LINK);
        wire_advance(&r.w, 10000 * MS);
        bu_expect(&r, "10 s in PREOP", INITIAL, NO_LINK);
        wire_go(&r.w, 0, ECT_STATE_SAFEOP);
        bu_run(&r, 1000 * MS);
        bu_expect_reported(&r, "SAFEOP", INITIAL, NO_LINK);
        wire_close(&r.w);
    }
}

static void normal_with_the_duties_of_the_mode(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        bu_to_op(&r);
        if ((node->duties & PERIODIC) != 0) {
            bu_expect(&r, "OP, PCO has not moved", INITIAL, DATA_ERROR);
            bu_run(&r, 5000 * MS);
            bu_expect_reported(&r, "OP for 5 s, PCO has not moved", INITIAL, DATA_ERROR);
            r.out[PCO]++;
            bu_cycle(&r);
        }
        bu_expect_reported(&r, "in order", DISARMED, OPERATIONAL);
        bu_set(&r, "ru1.on", "1");
        bu_expect_reported(&r, "a remote is on", DISARMED, OPERATIONAL);
        bu_set(&r, "ru1.armed", "1");
        bu_expect_reported(&r, "armed", ARMED, OPERATIONAL);
        bu_set(&r, "ru1.armed", "0");
        bu_expect_reported(&r, "disarmed", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void pco_unsupervised(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        if ((node->duties & PERIODIC) != 0)
            continue;
        int good = bu_in_order(&r, node, true);
        for (unsigned int s = 0; s < 10; s++) {
            bu_run(&r, 1000 * MS);
            bu_expect(&r, "PCO never moves", good, OPERATIONAL);
        }
        wire_close(&r.w);
    }
}

/* --- PCO ---------------------------------------------------------------------------------------------------------- */

static void pco_limit(void **state)
{
    (void)state;
    for (unsigned int row = 0; row < 4; row++) {
        const bu_node_t *node = &bu_nodes[2 + row / 2];
        bu_rig_t r;
        int good = bu_in_order(&r, node, row % 2 == 1);
        r.counting = false;
        r.out[PCO]++;
        bu_cycle(&r);
        bu_run(&r, 1999 * MS);
        bu_expect(&r, "1999 ms after PCO", good, OPERATIONAL);
        bu_run(&r, 1 * MS - 1);
        bu_expect(&r, "1 ns before 2000 ms after PCO", good, OPERATIONAL);
        bu_run(&r, 1);
        bu_expect(&r, "2000 ms after PCO", LINK_ERROR, DATA_ERROR);
        bu_expect_reported(&r, "2000 ms after PCO", LINK_ERROR, DATA_ERROR);
        bu_run(&r, 3000 * MS);
        bu_expect(&r, "5 s after PCO", LINK_ERROR, DATA_ERROR);
        r.out[PCO]++;
        bu_cycle(&r);
        bu_expect_reported(&r, "PCO again", good, OPERATIONAL);
        bu_run(&r, 1874 * MS);
        bu_expect(&r, "1999 ms after PCO again", good, OPERATIONAL);
        bu_run(&r, 1 * MS);
        bu_expect(&r, "2000 ms after PCO again", LINK_ERROR, DATA_ERROR);
        wire_close(&r.w);
    }
}

static void pco_slow_but_in_time(void **state)
{
    (void)state;
    bu_rig_t r;
    int good = bu_in_order(&r, &bu_nodes[2], true);
    r.counting = false;
    r.out[PCO] = 250;
    bu_cycle(&r);
    for (unsigned int n = 0; n < 12; n++) { /* through 255 -> 0 */
        bu_run(&r, 1990 * MS);
        wire_advance(&r.w, 9 * MS);
        bu_expect(&r, "1999 ms after PCO", good, OPERATIONAL);
        r.out[PCO]++;
        bu_cycle(&r);
        bu_expect(&r, "PCO in time", good, OPERATIONAL);
    }
    assert_int_equal(r.out[PCO], 6);
    wire_close(&r.w);
}

static void pco_wraps_back_to_order(void **state)
{
    static const struct {
        uint8_t stuck, next;
    } rows[] = {{0, 1}, {127, 128}, {254, 255}, {255, 0}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[3], true);
        r.counting = false;
        r.out[PCO] = rows[i].stuck;
        bu_run(&r, 2010 * MS);
        bu_expect(&r, "stuck", LINK_ERROR, DATA_ERROR);
        r.out[PCO] = rows[i].next;
        bu_cycle(&r);
        bu_expect_reported(&r, "one more", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* --- CAO ---------------------------------------------------------------------------------------------------------- */

static void cao_limit(void **state)
{
    (void)state;
    for (unsigned int row = 0; row < 6; row++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[1 + row / 2], row % 2 == 1);
        bu_command_shown(&r);
        bu_run(&r, 1998 * MS);
        bu_expect(&r, "1998 ms without acknowledge", good, OPERATIONAL);
        bu_run(&r, 1 * MS);
        bu_expect(&r, "1999 ms without acknowledge", good, OPERATIONAL);
        bu_run(&r, 1 * MS);
        bu_expect_reported(&r, "2000 ms without acknowledge", LINK_ERROR, DATA_ERROR);
        bu_run(&r, 3000 * MS);
        bu_expect(&r, "5 s without acknowledge", LINK_ERROR, DATA_ERROR);
        r.out[CAO] = r.in[CCI];
        bu_cycle(&r);
        bu_expect_reported(&r, "acknowledged late", good, OPERATIONAL);
        bu_run(&r, 5000 * MS);
        bu_expect(&r, "nothing more to acknowledge", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void cao_in_time(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[n], true);
        for (unsigned int turn = 0; turn < 3; turn++) {
            bu_command_shown(&r);
            bu_run(&r, 1990 * MS);
            wire_advance(&r.w, 9 * MS);
            r.out[CAO] = r.in[CCI];
            bu_cycle(&r);
            bu_run(&r, 4000 * MS);
            bu_expect(&r, "acknowledged after 1999 ms", good, OPERATIONAL);
        }
        wire_close(&r.w);
    }
}

static void cao_of_something_else(void **state)
{
    static const int wrong[] = {-1, 1, 2, 128};
    (void)state;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[1], false);
        for (unsigned int n = 0; n < 3; n++) {
            bu_command_shown(&r);
            r.out[CAO] = r.in[CCI];
            bu_cycle(&r);
        }
        bu_command_shown(&r);
        bu_run(&r, 1000 * MS);
        r.out[CAO] = (uint8_t)(r.in[CCI] + wrong[i]);
        bu_run(&r, 990 * MS);
        bu_expect(&r, "not acknowledged for 1990 ms", good, OPERATIONAL);
        bu_run(&r, 10 * MS);
        bu_expect_reported(&r, "another number is no acknowledge", LINK_ERROR, DATA_ERROR);
        r.out[CAO] = r.in[CCI];
        bu_cycle(&r);
        bu_expect(&r, "acknowledged", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* A controller that has kept its CAO, or changes it arbitrarily: nothing waits for it. */
static void cao_without_a_command(void **state)
{
    static const uint8_t caos[] = {7, 1, 255, 0, 128};
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_power_on(&r, &bu_nodes[n]);
        r.out[CAO] = 7;
        bu_to_op(&r);
        r.counting = true;
        bu_run(&r, 3000 * MS);
        bu_expect_reported(&r, "a retained CAO of 7", DISARMED, OPERATIONAL);
        bu_command_shown(&r);
        bu_run(&r, 2000 * MS);
        bu_expect(&r, "now a command waits for it", LINK_ERROR, DATA_ERROR);
        r.out[CAO] = r.in[CCI];
        bu_cycle(&r);
        bu_expect(&r, "acknowledged", DISARMED, OPERATIONAL);
        for (size_t i = 0; i < COUNT(caos); i++) {
            r.out[CAO] = caos[i];
            bu_run(&r, 2100 * MS);
            bu_expect(&r, "CAO of an acknowledged command has moved on", DISARMED, OPERATIONAL);
        }
        assert_int_equal(r.in[CCI], 1);
        wire_close(&r.w);
    }
}

static void cao_wraps(void **state)
{
    (void)state;
    bu_rig_t r;
    int good = bu_in_order(&r, &bu_nodes[1], true);
    for (unsigned int n = 1; n <= 256; n++) {
        bu_command_shown(&r);
        assert_int_equal(r.in[CCI], (uint8_t)n);
        if (n < 256)
            r.out[CAO] = r.in[CCI];
        bu_cycle(&r);
        bu_expect(&r, "all acknowledged", good, OPERATIONAL);
    }
    bu_run(&r, 2000 * MS);
    bu_expect(&r, "CCI is 0 and CAO still 255", LINK_ERROR, DATA_ERROR);
    r.out[CAO] = 0;
    bu_cycle(&r);
    bu_expect(&r, "CAO is 0 too", good, OPERATIONAL);
    wire_close(&r.w);
}

static void both_late(void **state)
{
    (void)state;
    bu_rig_t r;
    int good = bu_in_order(&r, &bu_nodes[2], true);
    bu_command_shown(&r);
    r.counting = false;
    bu_run(&r, 3000 * MS);
    bu_expect(&r, "PCO and CAO late", LINK_ERROR, DATA_ERROR);
    r.counting = true;
    bu_run(&r, 20 * MS);
    bu_expect(&r, "CAO late", LINK_ERROR, DATA_ERROR);
    r.out[CAO] = r.in[CCI];
    bu_run(&r, 20 * MS);
    bu_expect(&r, "neither", good, OPERATIONAL);
    wire_close(&r.w);
}

static void no_commands_in_input_only(void **state)
{
    (void)state;
    bu_rig_t r;
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE] = "";
    int good = bu_in_order(&r, &bu_nodes[0], true);
    signal_find(&r.w, "ru1.command", &ref);
    assert_false(ect_signal_write(&ref, "000102030405060708090a0b0c0d0e0f", r.w.now_ns, message));
    assert_true(strlen(message) > 0);
    bu_run(&r, 5000 * MS);
    bu_expect_reported(&r, "no command went out", good, OPERATIONAL);
    assert_int_equal(r.in[CCI], 0);
    wire_close(&r.w);
}

/* --- loss of data ------------------------------------------------------------------------------------------------- */

static void watchdog_after_good(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[n], n % 2 == 0);
        uint8_t status[6];
        wire_advance(&r.w, 90 * MS);
        bu_expect(&r, "90 ms without outputs", good, OPERATIONAL);
        wire_advance(&r.w, 20 * MS);
        bu_expect(&r, "110 ms without outputs", LINK_ERROR, NO_LINK);
        assert_int_equal(wire_read(&r.w, 0, ECT_REG_AL_STATUS, status, 6), 1);
        assert_int_equal(status[0], ECT_STATE_SAFEOP | ECT_AL_ERROR);
        assert_int_equal(ect_load_le16(status + 4), ECT_AL_WATCHDOG);
        assert_int_equal(ect_chain_slave(r.w.chain, 0)->cause, ECT_CAUSE_WATCHDOG);
        bu_run(&r, 500 * MS);
        bu_expect_reported(&r, "outputs in SAFEOP are not used", LINK_ERROR, NO_LINK);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP | ECT_AL_ACKNOWLEDGE, NULL), ECT_STATE_SAFEOP);
        bu_expect(&r, "acknowledged", LINK_ERROR, NO_LINK);
        bu_cycle(&r);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
        if ((bu_nodes[n].duties & PERIODIC) != 0)
            bu_expect(&r, "OP again, PCO has not moved yet", LINK_ERROR, DATA_ERROR);
        bu_cycle(&r);
        bu_expect_reported(&r, "OP again", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void watchdog_before_good(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_power_on(&r, &bu_nodes[2]);
    bu_to_op(&r);
    bu_run(&r, 500 * MS);
    wire_advance(&r.w, 150 * MS);
    bu_expect_reported(&r, "watchdog before the first good exchange", INITIAL, NO_LINK);
    wire_close(&r.w);
}

static void controller_leaves_op(void **state)
{
    static const uint8_t targets[] = {ECT_STATE_SAFEOP, ECT_STATE_PREOP, ECT_STATE_INIT};
    (void)state;
    FOR_EACH_NODE(node)
    {
        for (size_t i = 0; i < COUNT(targets); i++) {
            bu_rig_t r;
            int good = bu_in_order(&r, node, true);
            assert_int_equal(wire_al(&r.w, 0, targets[i], NULL), targets[i]);
            bu_expect(&r, "controller left OP", LINK_ERROR, NO_LINK);
            wire_advance(&r.w, 5000 * MS);
            bu_expect(&r, "controller left OP 5 s ago", LINK_ERROR, NO_LINK);
            bu_to_op(&r);
            bu_cycle(&r);
            bu_expect_reported(&r, "controller is back", good, OPERATIONAL);
            wire_close(&r.w);
        }
    }
}

static void deadlines_end_with_op(void **state)
{
    (void)state;
    bu_rig_t r;
    int good = bu_in_order(&r, &bu_nodes[2], true);
    bu_command_shown(&r);
    bu_run(&r, 1500 * MS);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    wire_advance(&r.w, 3000 * MS);
    bu_expect(&r, "SAFEOP", LINK_ERROR, NO_LINK);
    bu_cycle(&r);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    bu_run(&r, 1500 * MS);
    bu_expect(&r, "a new 2000 ms for the acknowledge", good, OPERATIONAL);
    bu_run(&r, 600 * MS);
    bu_expect(&r, "not acknowledged", LINK_ERROR, DATA_ERROR);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    bu_cycle(&r);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    bu_run(&r, 1900 * MS);
    bu_expect(&r, "late before, and a new 2000 ms again", good, OPERATIONAL);
    bu_run(&r, 100 * MS);
    bu_expect(&r, "still not acknowledged", LINK_ERROR, DATA_ERROR);
    wire_close(&r.w);
}

/* --- Input Only: are the inputs read? ----------------------------------------------------------------------------- */

static void inputs_not_read(void **state)
{
    (void)state;
    for (unsigned int armed = 0; armed <= 1; armed++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[0], armed == 1);
        char cause[ECT_SIGNAL_TEXT_ROOM];
        wire_advance(&r.w, 2000 * MS - 1);
        bu_expect(&r, "1 ns before 2000 ms without reading", good, OPERATIONAL);
        wire_advance(&r.w, 1);
        bu_expect(&r, "2000 ms without reading", LINK_ERROR, NO_LINK);
        bu_get(&r, "bu.cause", cause);
        assert_string_equal(cause, "the controller does not read the input data");
        wire_advance(&r.w, 60000 * MS);
        bu_expect(&r, "a minute without reading", LINK_ERROR, NO_LINK);
        bu_cycle(&r);
        bu_expect_reported(&r, "read again", good, OPERATIONAL);
        wire_advance(&r.w, 1990 * MS);
        bu_cycle(&r);
        wire_advance(&r.w, 1990 * MS);
        bu_expect(&r, "slow, but in time", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* OP begins and nothing follows. In SAFEOP reading is not required. */
static void inputs_never_read(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_power_on(&r, &bu_nodes[0]);
    wire_go(&r.w, 0, ECT_STATE_SAFEOP);
    wire_advance(&r.w, 5000 * MS);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    bu_expect(&r, "OP", DISARMED, OPERATIONAL);
    wire_advance(&r.w, 1999 * MS);
    bu_expect(&r, "OP for 1999 ms", DISARMED, OPERATIONAL);
    wire_advance(&r.w, 1 * MS);
    bu_expect(&r, "OP for 2000 ms, nothing read", LINK_ERROR, NO_LINK);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    bu_cycle(&r);
    bu_expect(&r, "read in SAFEOP", LINK_ERROR, NO_LINK);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    bu_expect(&r, "OP again", DISARMED, OPERATIONAL);
    wire_close(&r.w);
}

/* With outputs the watchdog supervises the controller; a controller that writes and never reads is in order. */
static void reading_is_no_duty_with_outputs(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[n], true);
        for (unsigned int i = 0; i < 500; i++) {
            wire_advance(&r.w, 10 * MS);
            r.out[PCO]++;
            bu_write_outputs(&r);
        }
        bu_expect(&r, "5 s without reading", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* --- configuration ------------------------------------------------------------------------------------------------ */

static const struct mismatch {
    const char *what;
    uint8_t sm;
    int longer, start;
    uint8_t refused; /* state that cannot be reached */
    uint16_t code;
} mismatches[] = {
    {"outputs one byte longer", 2, 1, 0, ECT_STATE_SAFEOP, ECT_AL_OUTPUT_SM},
    {"outputs one byte shorter", 2, -1, 0, ECT_STATE_SAFEOP, ECT_AL_OUTPUT_SM},
    {"outputs elsewhere", 2, 0, 2, ECT_STATE_SAFEOP, ECT_AL_OUTPUT_SM},
    {"inputs one byte longer", 3, 1, 0, ECT_STATE_SAFEOP, ECT_AL_INPUT_SM},
    {"inputs one byte shorter", 3, -1, 0, ECT_STATE_SAFEOP, ECT_AL_INPUT_SM},
    {"inputs elsewhere", 3, 0, -2, ECT_STATE_SAFEOP, ECT_AL_INPUT_SM},
    {"mailbox out shorter", 0, -1, 0, ECT_STATE_PREOP, ECT_AL_MAILBOX},
    {"mailbox in longer", 1, 1, 0, ECT_STATE_PREOP, ECT_AL_MAILBOX},
};

/* From INIT to the state that the wrong SyncManager makes impossible. */
static void refuse(bu_rig_t *r, const struct mismatch *m)
{
    const ect_sm_t *sm = &r->node->device->sm[m->sm];
    uint16_t code = 0;
    wire_go(&r->w, 0, m->refused == ECT_STATE_PREOP ? ECT_STATE_INIT : ECT_STATE_PREOP);
    if (m->refused == ECT_STATE_PREOP)
        wire_configure_mailbox(&r->w, 0);
    else
        wire_configure_process_data(&r->w, 0);
    wire_set_sm(&r->w, 0, m->sm, (uint16_t)(sm->start + m->start),
                (uint16_t)(ect_device_sm_bytes(r->node->device, m->sm) + m->longer), sm->control);
    uint8_t status = wire_al(&r->w, 0, m->refused, &code);
    if ((status & ECT_AL_ERROR) == 0 || code != m->code)
        fail_msg("%s: expected code 0x%04X, got AL status 0x%02X, code 0x%04X", m->what, m->code, status, code);
}

static void configuration_error(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        for (size_t i = 0; i < COUNT(mismatches); i++) {
            const struct mismatch *m = &mismatches[i];
            bu_rig_t r;
            if (ect_device_sm_bytes(node->device, m->sm) == 0)
                continue;
            bu_power_on(&r, node);
            refuse(&r, m);
            bu_expect(&r, m->what, INITIAL, CFG_ERROR);
            assert_int_equal(ect_chain_slave(r.w.chain, 0)->cause, ECT_CAUSE_REQUEST);
            wire_advance(&r.w, 3000 * MS);
            bu_expect(&r, m->what, INITIAL, CFG_ERROR);
            bu_to_op(&r);
            r.counting = true;
            bu_run(&r, 20 * MS);
            bu_expect_reported(&r, "configured as it should be", DISARMED, OPERATIONAL);
            refuse(&r, m);
            bu_expect(&r, m->what, LINK_ERROR, CFG_ERROR);
            wire_close(&r.w);
        }
    }
}

static void configuration_changes_in_op(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_in_order(&r, &bu_nodes[2], true);
    wire_set_sm(&r.w, 0, 3, INPUTS_AT, 142, 0x20);
    bu_expect(&r, "SM3 of another node", LINK_ERROR, CFG_ERROR);
    wire_close(&r.w);
}

static void acknowledged_but_no_further(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(mismatches); i++) {
        const struct mismatch *m = &mismatches[i];
        uint8_t stays = m->refused == ECT_STATE_PREOP ? ECT_STATE_INIT : ECT_STATE_PREOP;
        bu_rig_t r;
        bu_power_on(&r, &bu_nodes[2]);
        refuse(&r, m);
        assert_int_equal(wire_al(&r.w, 0, stays | ECT_AL_ACKNOWLEDGE, NULL), stays);
        bu_expect(&r, "the error flag is acknowledged, the state is unchanged", INITIAL, CFG_ERROR);
        wire_close(&r.w);
    }
}

static void refusals_without_mismatch(void **state)
{
    static const struct {
        uint8_t from;
        uint16_t request, code;
        const char *what;
    } rows[] = {
        {ECT_STATE_INIT, ECT_STATE_OP, 0x0011, "INIT to OP"},
        {ECT_STATE_PREOP, ECT_STATE_OP, 0x0011, "PREOP to OP"},
        {ECT_STATE_PREOP, 5, 0x0012, "to no state"},
        {ECT_STATE_INIT, ECT_STATE_BOOT, 0x0013, "to BOOT"},
        {ECT_STATE_SAFEOP, ECT_STATE_OP, 0x0019, "to OP without outputs"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        bu_rig_t r;
        uint8_t status[6];
        bu_power_on(&r, &bu_nodes[2]);
        wire_go(&r.w, 0, rows[i].from);
        (void)wire_al(&r.w, 0, rows[i].request, NULL);
        wire_advance(&r.w, 5100 * MS);
        assert_int_equal(wire_read(&r.w, 0, ECT_REG_AL_STATUS, status, 6), 1);
        assert_int_equal(ect_load_le16(status + 4), rows[i].code);
        bu_expect(&r, rows[i].what, INITIAL, NO_LINK);
        wire_close(&r.w);
    }
}

/* ETG.1000.6 Table 11: the codes of mailboxes, SyncManagers, their watchdogs, mappings and modes of synchronisation. */
static void codes_of_mismatches(void **state)
{
    bu_rig_t r;
    char what[20];
    (void)state;
    bu_power_on(&r, &bu_nodes[2]);
    wire_go(&r.w, 0, ECT_STATE_PREOP);
    for (uint16_t code = 0x0001; code <= 0x0070; code++) {
        bool is_mismatch = (code >= 0x0015 && code <= 0x0017) || (code >= 0x001C && code <= 0x001F) ||
                           (code >= 0x0024 && code <= 0x0028);
        snprintf(what, sizeof what, "code 0x%04X", code);
        assert_int_equal(r.node->device->al_error(ect_chain_slave(r.w.chain, 0)->config.instance, ECT_STATE_SAFEOP,
                                                  code, r.w.now_ns),
                         code);
        bu_expect(&r, what, INITIAL, is_mismatch ? CFG_ERROR : NO_LINK);
    }
    wire_close(&r.w);
}

static void module_error_hides_the_rest(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_in_order(&r, &bu_nodes[2], true);
    r.counting = false;
    bu_run(&r, 2000 * MS);
    bu_expect(&r, "PCO is late", LINK_ERROR, DATA_ERROR);
    bu_set(&r, "bu.module_error", "1");
    bu_expect(&r, "module error and PCO late", LINK_ERROR, MODULE_ERROR);
    refuse(&r, &mismatches[0]);
    bu_expect(&r, "module error and refused configuration", LINK_ERROR, MODULE_ERROR);
    bu_set(&r, "bu.module_error", "0");
    bu_expect(&r, "refused configuration", LINK_ERROR, CFG_ERROR);
    wire_close(&r.w);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-018 ECL-066 ECL-068 EC-C6: until data are exchanged the BU is Initial, EC-Link No Link, relays open, "
             "\"EC: No Data\"",
             initial_until_data),
        TEST("ECL-018 ECL-019 ECL-058 EC-C6: the BU is in order as soon as the duties of its mode are fulfilled, not "
             "before",
             normal_with_the_duties_of_the_mode),
        TEST("ECL-058: Input Only and Input + Commands do not supervise PCO", pco_unsupervised),
        TEST("ECL-049 ECL-057 ECL-067 ECL-069 EC-C6: PCO unchanged for 1999 ms is in order, for 2000 ms is Bad data; "
             "counting again is in order",
             pco_limit),
        TEST("ECL-057: PCO counting every 1999 ms, also from 255 to 0, is in order", pco_slow_but_in_time),
        TEST("ECL-057: one more PCO ends the error, also 255 to 0", pco_wraps_back_to_order),
        TEST("ECL-056 ECL-067 EC-C6: a command unacknowledged for 1999 ms is in order, for 2000 ms is Bad data; a late "
             "acknowledge ends it",
             cao_limit),
        TEST("ECL-056: acknowledges after 1999 ms are in order, and nothing is late afterwards", cao_in_time),
        TEST("ECL-056: CAO with another number than CCI does not acknowledge", cao_of_something_else),
        TEST("ECL-056: CAO is supervised only while a command waits for it", cao_without_a_command),
        TEST("ECL-056 ECL-023: CCI changes from 255 to 0, and so must CAO", cao_wraps),
        TEST("ECL-056 ECL-057: with PCO and CAO late, both must return", both_late),
        TEST("ECL-058: Input Only sends no commands, so none is ever late", no_commands_in_input_only),
        TEST("ECL-073 ECL-066: without outputs the watchdog ends OP: External link error, No Data, until OP and duties "
             "again",
             watchdog_after_good),
        TEST("ECL-073 ECL-068 EC-C6: a watchdog before the first good exchange leaves the BU Initial",
             watchdog_before_good),
        TEST("ECL-066 EC-C6: when the controller leaves OP after a good exchange it is External link error, No Data",
             controller_leaves_op),
        TEST("ECL-056: the end of OP ends the supervision, its start begins a new 2000 ms", deadlines_end_with_op),
        TEST("ECL-018 ECL-066 ECL-029: Input Only, inputs not read for 2000 ms in OP: No Data, relays open, until they "
             "are "
             "read",
             inputs_not_read),
        TEST("ECL-018 ECL-066: Input Only, inputs never read in OP: No Data after 2000 ms; SAFEOP does not count",
             inputs_never_read),
        TEST("ECL-058: with outputs reading is not supervised", reading_is_no_duty_with_outputs),
        TEST("ECL-072 ECL-066 EC-C6: a refused SyncManager configuration is Cfg. Error: Initial before, External link "
             "error after the first good exchange",
             configuration_error),
        TEST("ECL-072: a SyncManager that changes to another size in OP is Cfg. Error", configuration_changes_in_op),
        TEST("ECL-072: an acknowledge of the error flag without a change of state leaves Cfg. Error",
             acknowledged_but_no_further),
        TEST("ECL-066 ECL-072: Cfg. Error for each AL status code of a configuration mismatch", codes_of_mismatches),
        TEST("ECL-066 ECL-072: refusals that are no configuration mismatch are No Data, not Cfg. Error",
             refusals_without_mismatch),
        TEST("ECL-066: Module Error has priority over Cfg. Error and Bad data", module_error_hides_the_rest),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link supervision", tests, NULL, NULL);
}
