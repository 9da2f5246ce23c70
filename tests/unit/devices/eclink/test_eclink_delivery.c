/* SPDX-License-Identifier: MIT */
/* EC-Link commands that do not arrive: each one is counted, because CAI acknowledges it nevertheless (TS-0007 §9,
 * §10.2); operators' commands that are kept over an interruption of the bus (§10.1). */
#include <string.h>

#include "support/base_unit.h"

enum { CAI = 3, TO_RU = 4, FROM_RU = 4, QUEUE = 16, FIRST_WITH_COMMANDS = 1 };

static void command(bu_rig_t *r, uint16_t id)
{
    ect_store_be16(r->out + TO_RU, id);
    r->out[CCO]++;
    bu_cycle(r);
}

/* The four causes by which no remote receives a command that CAI has acknowledged. */
static void expect_counts(bu_rig_t *r, const char *when, long unreached, long unknown, long lost, long resyncs)
{
    bu_update(r);
    if (bu_number(r, "bu.commands_unreached") != unreached || bu_number(r, "bu.commands_unknown") != unknown ||
        bu_number(r, "bu.commands_lost") != lost || bu_number(r, "bu.cco_resyncs") != resyncs)
        fail_msg("%s, %s: expected %ld unreached, %ld unknown, %ld lost, %ld resyncs; got %ld, %ld, %ld, %ld",
                 r->node->device->type_name, when, unreached, unknown, lost, resyncs,
                 bu_number(r, "bu.commands_unreached"), bu_number(r, "bu.commands_unknown"),
                 bu_number(r, "bu.commands_lost"), bu_number(r, "bu.cco_resyncs"));
    if (r->in[CAI] != r->out[CCO])
        fail_msg("%s: CCO %u is acknowledged as %u", when, r->out[CCO], r->in[CAI]);
}

static void no_remote_receives(void **state)
{
    (void)state;
    for (unsigned int n = FIRST_WITH_COMMANDS; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        command(&r, 0);
        expect_counts(&r, "id 0 with no remote on", 1, 0, 0, 0);
        command(&r, 2);
        expect_counts(&r, "a remote that is off", 2, 0, 0, 0);
        bu_set_number(&r, "ru2.on", 1);
        command(&r, 2);
        expect_counts(&r, "a remote that is on", 2, 0, 0, 0);
        command(&r, 0);
        expect_counts(&r, "id 0 with one on", 2, 0, 0, 0);
        bu_set_number(&r, "bu.vlaps", 0);
        bu_set_number(&r, "ru2.g_link_lost", 1);
        command(&r, 2);
        expect_counts(&r, "a remote out of reach", 3, 0, 0, 0);
        command(&r, 99);
        expect_counts(&r, "an id that no remote has", 3, 1, 0, 0);
        assert_int_equal(bu_number(&r, "ru2.received_count"), 2);
        wire_close(&r.w);
    }
}

/* The remote is on fallback and busy, so commands wait for it. */
static void wait_for_remote_1(bu_rig_t *r, unsigned int commands)
{
    bu_start(r, &bu_nodes[2]);
    bu_set_number(r, "ru1.on", 1);
    bu_set_number(r, "ru1.g_link_lost", 1);
    for (unsigned int n = 0; n < QUEUE; n++)
        bu_set(r, "ru1.command", "000102030405060708090a0b0c0d0e0f");
    for (unsigned int n = 0; n < commands; n++)
        command(r, 1);
}

static void queued_for_one_that_leaves(void **state)
{
    (void)state;
    bu_rig_t r;
    wait_for_remote_1(&r, 6);
    expect_counts(&r, "six wait", 0, 0, 0, 0);
    assert_int_equal(bu_number(&r, "ru1.commands_dropped"), 0);
    bu_set_number(&r, "ru1.on", 0);
    expect_counts(&r, "the remote has left", 0, 0, 0, 0);
    assert_int_equal(bu_number(&r, "ru1.commands_dropped"), 6);
    assert_int_equal(bu_number(&r, "ru1.received_count"), 0);
    bu_set_number(&r, "ru1.on", 1);
    bu_update(&r);
    bu_update(&r);
    assert_int_equal(bu_number(&r, "ru1.commands_dropped"), 6);
    bu_set(&r, "bu.restart", "1");
    assert_int_equal(bu_number(&r, "ru1.commands_dropped"), 0);
    wire_close(&r.w);
}

static void waiting_for_room_when_it_leaves(void **state)
{
    (void)state;
    bu_rig_t r;
    wait_for_remote_1(&r, QUEUE + 1);
    bu_update(&r);
    assert_int_equal(r.in[CAI], QUEUE);
    bu_set_number(&r, "ru1.on", 0);
    expect_counts(&r, "sixteen queued, one not acknowledged yet", 1, 0, 0, 0);
    assert_int_equal(bu_number(&r, "ru1.commands_dropped"), QUEUE);
    wire_close(&r.w);
}

/* Sixteen commands from the remote still wait for C-Link when it leaves. */
static void back_within_an_update(void **state)
{
    (void)state;
    bu_rig_t r;
    wait_for_remote_1(&r, 0);
    bu_set_number(&r, "ru1.on", 0);
    bu_set_number(&r, "ru1.on", 1);
    command(&r, 1);
    bu_update(&r);
    assert_int_equal(bu_number(&r, "ru1.received_count"), 1);
    wire_close(&r.w);
}

/* The unit's last CCO, the first CCO of a controller that starts or returns, and the result. */
static const struct start {
    const char *what;
    uint8_t last, cco;
    long resyncs, received;
} starts[] = {
    {"the same counter", 5, 5, 0, 0},
    {"the next command", 5, 6, 0, 1},
    {"a PLC that begins at 1 with a command: the unit takes 1 as the start", 5, 1, 1, 0},
    {"a PLC that begins at 0", 5, 0, 1, 0},
    {"two commands ahead", 5, 7, 1, 0},
    {"a PLC that begins at 1 on a fresh unit", 0, 1, 0, 1},
    {"the phantom: a PLC that begins at 0 sends nothing, the unit is at 255", 255, 0, 0, 1},
};

static void first_outputs(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(starts); i++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[1 + i % 3]);
        r.out[CCO] = starts[i].last;
        bu_update(&r);
        bu_set_number(&r, "ru1.on", 1);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
        long unreached = bu_number(&r, "bu.commands_unreached"), lost = bu_number(&r, "bu.commands_lost");
        r.out[CCO] = starts[i].cco;
        bu_to_op(&r);
        bu_update(&r);
        expect_counts(&r, starts[i].what, unreached, 0, lost, starts[i].resyncs);
        if (bu_number(&r, "ru1.received_count") != starts[i].received)
            fail_msg("%s: %ld commands arrived", starts[i].what, bu_number(&r, "ru1.received_count"));
        wire_close(&r.w);
    }
}

/* --- operators' commands ------------------------------------------------------------------------------------------ */

static void send_command(bu_rig_t *r, const char *data)
{
    bu_set(r, "ru1.command", data);
}

static void expect_next(bu_rig_t *r, const char *when, uint8_t cci, uint8_t first_byte)
{
    bu_update(r);
    bu_update(r);
    if (r->in[CCI] != cci || r->in[6] != first_byte)
        fail_msg("%s: expected CCI %u and a command that begins with %02X, got %u and %02X", when, cci, first_byte,
                 r->in[CCI], r->in[6]);
}

static void outlast(void **state)
{
    (void)state;
    for (unsigned int lifetime_ms = 0; lifetime_ms <= 5000; lifetime_ms += 5000) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[2]);
        bu_set_number(&r, "ru1.on", 1);
        bu_set_number(&r, "bu.command_lifetime", lifetime_ms);
        send_command(&r, "01000000000000000000000000000000");
        expect_next(&r, "the first is shown", 1, 1);
        send_command(&r, "02000000000000000000000000000000");
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
        wire_advance(&r.w, 4000 * MS);
        send_command(&r, "03000000000000000000000000000000");
        wire_advance(&r.w, 3000 * MS);
        bu_to_op(&r);
        bu_cycle(&r);
        expect_next(&r, "back in OP: the command in the input data stays", 1, 1);
        r.out[CAO] = 1;
        expect_next(&r, "acknowledged", 2, lifetime_ms == 0 ? 2 : 3);
        assert_int_equal(bu_number(&r, "bu.commands_expired"), lifetime_ms == 0 ? 0 : 1);
        wire_close(&r.w);
    }
}

static void expired_make_room(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[1]);
    bu_set_number(&r, "ru1.on", 1);
    bu_set_number(&r, "bu.command_lifetime", 1000);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    for (unsigned int n = 0; n < QUEUE; n++)
        send_command(&r, "04000000000000000000000000000000");
    wire_advance(&r.w, 1000 * MS - 1);
    assert_false(signal_try_set(&r.w, "ru1.command", "05000000000000000000000000000000", message));
    wire_advance(&r.w, 1);
    send_command(&r, "05000000000000000000000000000000");
    assert_int_equal(bu_number(&r, "bu.commands_expired"), QUEUE);
    assert_int_equal(bu_number(&r, "bu.overflows"), 1);
    bu_to_op(&r);
    bu_cycle(&r);
    expect_next(&r, "the only recent one", 1, 5);
    wire_close(&r.w);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-025 ECL-051: CAI acknowledges a command that no remote receives, and bu.commands_unreached counts it",
             no_remote_receives),
        TEST("ECL-025: acknowledged commands of a remote that leaves are counted in ruN.commands_dropped",
             queued_for_one_that_leaves),
        TEST("ECL-025: a command that waits for space when its remote leaves counts as unreached",
             waiting_for_room_when_it_leaves),
        TEST("ECL-025 ECL-063: a remote that leaves and returns within an update receives a command at once on C-Link",
             back_within_an_update),
        TEST(
            "ECL-050: a CCO in the first outputs that is a start and no command is counted in bu.cco_resyncs; at 255 a "
            "controller that begins at 0 sends a phantom",
            first_outputs),
        TEST("ECL-023: operators' commands are kept over an interruption of the bus, or expire after "
             "bu.command_lifetime",
             outlast),
        TEST("ECL-023: expired commands free their places for new ones", expired_make_room),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link delivery", tests, NULL, NULL);
}
