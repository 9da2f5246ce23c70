/* SPDX-License-Identifier: MIT */
/* The EC-Link remote units' links: VLAPs, fallback and its priorities (TS-0007 §8.2, §10.6). */
#include <stdio.h>
#include <string.h>

#include "support/base_unit.h"

static void send_command(bu_rig_t *r, unsigned int ru)
{
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE] = "";
    signal_find(&r->w, signal_of_ru(ru, "command"), &ref);
    if (!ect_signal_write(&ref, "000102030405060708090a0b0c0d0e0f", r->w.now_ns, message))
        fail_msg("%s", message);
}

/* --- links -------------------------------------------------------------------------------------------------------- */

static void vlaps_are_reported(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[0]);
    for (uint8_t vlaps = 0; vlaps <= 3; vlaps++) {
        bu_set_number(&r, "bu.vlaps", vlaps);
        bu_update(&r);
        assert_int_equal(r.in[VLAPS], vlaps);
    }
    wire_close(&r.w);
}

static void armed_falls_back(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_set_number(&r, "bu.vlaps", 1);
        bu_arm(&r, 1);
        bu_expect_blocks(&r, "G-Link", "1", ARMED);
        assert_int_equal(r.in[36], 1);
        assert_int_equal(r.in[37], 1);
        bu_set_number(&r, "ru1.g_link_lost", 1);
        bu_expect_blocks(&r, "fallback", "1", ARMED);
        assert_int_equal(r.in[36], 1);
        assert_int_equal(r.in[37], 7);
        bu_set_number(&r, "ru1.joystick2", 321);
        bu_update(&r);
        assert_int_equal(ect_load_be16(r.in + 40), 321);
        bu_set_number(&r, "ru1.cable", 1);
        bu_expect_blocks(&r, "on cable", "1", ARMED);
        assert_int_equal(r.in[37], 1);
        bu_set_number(&r, "ru1.cable", 0);
        bu_set_number(&r, "ru1.g_link_lost", 0);
        bu_expect_blocks(&r, "G-Link again", "1", ARMED);
        assert_int_equal(r.in[37], 1);
        bu_set_number(&r, "ru1.g_link_lost", 1);
        bu_set_number(&r, "bu.vlaps", 0);
        bu_expect_blocks(&r, "without VLAP communication is lost", "", BLOCKED);
        assert_int_equal(r.in[UNARMED], 0);
        bu_set_number(&r, "ru1.g_link_lost", 0);
        bu_expect_blocks(&r, "not rearmed", "", BLOCKED);
        assert_int_equal(r.in[UNARMED], 1);
        bu_set_number(&r, "bu.vlaps", 1);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "rearmed", "1", ARMED);
        wire_close(&r.w);
    }
}

/* Remotes 1 to 5 are on; some are armed, on cable, or without G-Link; their resulting states. */
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
        bu_rig_t r;
        char got[6] = "";
        bu_start(&r, &bu_nodes[3]);
        bu_set_number(&r, "bu.vlaps", c->vlaps);
        for (unsigned int ru = 1; ru <= 5; ru++) {
            bu_set_ru(&r, ru, "on", 1);
            bu_set_ru(&r, ru, "cable", strchr(c->cable, (char)('0' + ru)) != NULL);
            bu_set_ru(&r, ru, "armed", strchr(c->armed, (char)('0' + ru)) != NULL);
        }
        for (unsigned int ru = 1; ru <= 5; ru++)
            bu_set_ru(&r, ru, "g_link_lost", strchr(c->lost, (char)('0' + ru)) != NULL);
        for (unsigned int ru = 1; ru <= 5; ru++)
            got[ru - 1] = (char)('0' + bu_ru_number(&r, ru, "g_link"));
        bu_expect_blocks(&r, c->what, c->armed, c->armed[0] ? ARMED : DISARMED);
        long unarmed = 0;
        for (unsigned int ru = 0; ru < 5; ru++)
            unarmed += c->g_link[ru] != '2' && !strchr(c->armed, (char)('1' + ru));
        if (strcmp(got, c->g_link) != 0 || r.in[UNARMED] != unarmed)
            fail_msg("%s: expected G-Link %s, %ld unarmed; got %s, %u", c->what, c->g_link, unarmed, got,
                     r.in[UNARMED]);
        wire_close(&r.w);
    }
}

/* With fewer VLAPs than armed remotes, the first to be armed has a reservation, whatever its number. */
static void reserved_in_the_order_of_arming(void **state)
{
    static const unsigned int orders[][2] = {{1, 2}, {2, 1}, {3, 8}, {8, 3}};
    (void)state;
    for (size_t i = 0; i < COUNT(orders); i++) {
        bu_rig_t r;
        char first[2] = {(char)('0' + orders[i][0]), 0};
        bu_start(&r, &bu_nodes[3]);
        bu_arm(&r, orders[i][0]);
        bu_arm(&r, orders[i][1]);
        bu_set_number(&r, "bu.vlaps", 1); /* the others are gone */
        bu_set_ru(&r, orders[i][0], "g_link_lost", 1);
        bu_update(&r);
        assert_int_equal(r.in[37], 7);
        bu_set_ru(&r, orders[i][1], "g_link_lost", 1);
        bu_expect_blocks(&r, "the second finds no VLAP, the first stays on fallback", first, BLOCKED);
        assert_int_equal(r.in[37], 7);
        wire_close(&r.w);
    }
}

/* The armed remote is lost with its VLAP because of a bad C-Link: a remote that waits for a VLAP gets it at once. */
static void vlap_of_the_lost(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_set_number(&r, "bu.vlaps", 1);
        bu_set_number(&r, "ru1.on", 1);
        bu_arm(&r, 2);
        bu_set_number(&r, "ru1.g_link_lost", 1);
        bu_set_number(&r, "ru2.c_link", 5);
        assert_int_equal(bu_number(&r, "ru1.g_link"), 2);
        bu_set_number(&r, "ru2.g_link_lost", 1);
        assert_int_equal(bu_number(&r, "ru1.g_link"), 7);
        bu_expect_blocks(&r, "the armed one is lost", "", BLOCKED);
        assert_int_equal(r.in[UNARMED], 1);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "the other one takes over", "1", n < 3 ? ARMED : BLOCKED);
        wire_close(&r.w);
    }
}

static void expect_refused(bu_rig_t *r, unsigned int ru, const char *why)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    if (signal_try_set(&r->w, signal_of_ru(ru, "armed"), "1", message) || !strstr(message, why))
        fail_msg("arming ru%u: expected a refusal with '%s', got '%s'", ru, why, message);
}

/* An armed remote on radio reserves a VLAP: without a free VLAP it cannot be armed. */
static void arming_reserves_a_vlap(void **state)
{
    (void)state;
    for (size_t n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[n]);
        bu_set_number(&r, "bu.vlaps", 0);
        bu_set_number(&r, "ru1.on", 1);
        expect_refused(&r, 1, "VLAP");
        bu_set_number(&r, "ru1.cable", 1);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "on cable it needs none", "1", ARMED);
        bu_set_number(&r, "ru1.armed", 0);
        bu_set_number(&r, "ru1.cable", 0);
        bu_set_number(&r, "bu.vlaps", 1);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "there is one", "1", ARMED);
        wire_close(&r.w);
    }
    bu_rig_t r;
    bu_start(&r, &bu_nodes[3]);
    bu_set_number(&r, "bu.vlaps", 2);
    bu_set_number(&r, "ru1.cable", 1);
    bu_arm(&r, 1);
    bu_arm(&r, 2);
    bu_arm(&r, 3);
    bu_expect_blocks(&r, "two on radio, one on cable", "123", ARMED);
    bu_set_number(&r, "ru1.armed", 0);
    bu_set_number(&r, "ru4.on", 1);
    expect_refused(&r, 4, "VLAP");
    wire_close(&r.w);
}

/* Each status of §8.2, forced on an armed remote with one VLAP, and the resulting state of the radio. */
static void forced_links(void **state)
{
    static const struct {
        const char *signal;
        unsigned int at; /* in the input data */
        long value;
        bool fallback; /* data to the remote are sent over C-Link */
        bool lost;     /* once there is no VLAP */
    } rows[] = {
        {"ru1.g_link", 37, 0, false, false}, {"ru1.g_link", 37, 1, false, false}, {"ru1.g_link", 37, 2, true, true},
        {"ru1.g_link", 37, 3, true, true},   {"ru1.g_link", 37, 4, true, true},   {"ru1.g_link", 37, 5, true, true},
        {"ru1.g_link", 37, 6, false, false}, {"ru1.g_link", 37, 7, true, true},   {"ru1.c_link", 36, 0, false, false},
        {"ru1.c_link", 36, 1, false, false}, {"ru1.c_link", 36, 2, false, false}, {"ru1.c_link", 36, 3, false, false},
        {"ru1.c_link", 36, 4, false, false}, {"ru1.c_link", 36, 5, false, false}, {"ru1.c_link", 36, 6, false, false},
        {"ru1.c_link", 36, 7, false, false},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[2]);
        bu_set_number(&r, "bu.vlaps", 1);
        bu_arm(&r, 1);
        bu_set_number(&r, rows[i].signal, rows[i].value);
        bu_expect_blocks(&r, rows[i].signal, "1", ARMED);
        if (r.in[rows[i].at] != rows[i].value || bu_number(&r, rows[i].signal) != rows[i].value)
            fail_msg("%s forced to %ld: got %u in the input data, %ld", rows[i].signal, rows[i].value, r.in[rows[i].at],
                     bu_number(&r, rows[i].signal));
        for (unsigned int n = 0; n < 3; n++)
            send_command(&r, 1);
        r.out[CCO]++;
        bu_update(&r);
        if ((bu_number(&r, "ru1.received_count") == 0) != rows[i].fallback)
            fail_msg("%s forced to %ld: expected %s", rows[i].signal, rows[i].value,
                     rows[i].fallback ? "fallback" : "G-Link to carry the command");
        bu_set_number(&r, "bu.vlaps", 0);
        bu_expect_blocks(&r, "without VLAP", rows[i].lost ? "" : "1", rows[i].lost ? BLOCKED : ARMED);
        bu_set_number(&r, rows[i].signal, -1);
        bu_update(&r);
        assert_int_equal(bu_number(&r, "ru1.g_link"), 1);
        assert_int_equal(bu_number(&r, "ru1.c_link"), rows[i].lost ? 6 : 2); /* there is no VLAP */
        wire_close(&r.w);
    }
}

/* The needs of the C-Link, and its report in byte 36 by an armed remote on radio or cable. */
static void c_link_has_one_truth(void **state)
{
    static const struct {
        const char *what, *signal;
        long bad, good;
        uint8_t reported;
    } rows[] = {
        {"no VLAP", "bu.vlaps", 0, 1, 2},
        {"no signal", "ru1.rssi", 0, 1, 2},
        {"an error", "ru1.c_link", 4, -1, 4},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows) * BU_NODES; i++) {
        bu_rig_t r;
        size_t row = i % COUNT(rows);
        bu_start(&r, &bu_nodes[i / COUNT(rows)]);
        bu_arm(&r, 1);
        bu_update(&r);
        assert_int_equal(r.in[36], 1);
        bu_set_number(&r, rows[row].signal, rows[row].bad);
        bu_expect_blocks(&r, rows[row].what, "1", ARMED); /* G-Link works */
        if (r.in[36] != rows[row].reported || bu_number(&r, "ru1.c_link") != rows[row].reported)
            fail_msg("%s: expected C-Link %u, got %u", rows[row].what, rows[row].reported, r.in[36]);
        bu_set_number(&r, "ru1.armed", 0);
        if (bu_try_set(&r, "ru1.armed", 1))
            fail_msg("%s: C-Link is %u, and the remote was armed", rows[row].what, rows[row].reported);
        bu_set_number(&r, rows[row].signal, rows[row].good);
        bu_set_number(&r, "ru1.armed", 1);
        bu_expect_blocks(&r, "in order again", "1", ARMED);
        assert_int_equal(r.in[36], 1);
        bu_set_number(&r, rows[row].signal, rows[row].bad);
        bu_set_number(&r, "ru1.g_link_lost", 1);
        bu_expect_blocks(&r, "there is no fallback", "", BLOCKED);
        wire_close(&r.w);
    }
}

static void cable_needs_no_c_link(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[0]);
    bu_set_number(&r, "bu.vlaps", 0);
    bu_set_number(&r, "ru1.rssi", 0);
    bu_set_number(&r, "ru1.cable", 1);
    bu_arm(&r, 1);
    bu_expect_blocks(&r, "on cable", "1", ARMED);
    assert_int_equal(r.in[36], 1);
    wire_close(&r.w);
}

/* A C-Link that does not work allows no fallback. */
static void no_fallback_without_c_link(void **state)
{
    (void)state;
    for (long value = 0; value <= 7; value++) {
        bool error = value >= 2 && value <= 5;
        bu_rig_t r;
        bu_start(&r, &bu_nodes[0]);
        bu_arm(&r, 1);
        bu_set_number(&r, "ru1.c_link", value);
        bu_set_number(&r, "ru1.g_link_lost", 1);
        bu_expect_blocks(&r, "G-Link is lost", error ? "" : "1", error ? BLOCKED : ARMED);
        wire_close(&r.w);
    }
}

/* Without G-Link, VLAP and cable a remote is out of communication. */
static void unreachable(bu_rig_t *r)
{
    bu_start(r, &bu_nodes[3]);
    bu_set_number(r, "bu.vlaps", 0);
    bu_set_number(r, "ru1.on", 1);
    bu_set_number(r, "ru1.g_link_lost", 1);
    bu_update(r);
    assert_int_equal(bu_number(r, "ru1.g_link"), 2);
    assert_int_equal(r->in[UNARMED], 0);
}

static void periodic_set(bu_rig_t *r)
{
    ect_store_be16(r->out + 24, 10);
    bu_cycle(r);
    ect_store_be16(r->out + 24, 0);
}

static void nothing_reaches_the_unreachable(void **state)
{
    (void)state;
    bu_rig_t r;
    unreachable(&r);
    r.out[CCO]++;
    periodic_set(&r);
    for (unsigned int n = 0; n < 4; n++)
        bu_update(&r);
    if (bu_ru_number(&r, 1, "received_count") != 0 || bu_ru_number(&r, 1, "periodic_count") != 0)
        fail_msg("a remote without any link got %ld commands and %ld sets of periodic data",
                 bu_ru_number(&r, 1, "received_count"), bu_ru_number(&r, 1, "periodic_count"));
    wire_close(&r.w);
}

static void the_unreachable_cannot_be_armed(void **state)
{
    (void)state;
    bu_rig_t r;
    unreachable(&r);
    assert_false(bu_try_set(&r, "ru1.armed", 1));
    bu_expect_blocks(&r, "not armed, so not lost either", "", DISARMED);
    wire_close(&r.w);
}

static void the_unreachable_cannot_send(void **state)
{
    (void)state;
    bu_rig_t r;
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE] = "";
    unreachable(&r);
    signal_find(&r.w, "ru1.command", &ref);
    assert_false(ect_signal_write(&ref, "000102030405060708090a0b0c0d0e0f", r.w.now_ns, message));
    bu_update(&r);
    bu_update(&r);
    assert_int_equal(r.in[CCI], 0);
    wire_close(&r.w);
}

/* --- priorities --------------------------------------------------------------------------------------------------- */

/* The update at which each item is transferred, counted from the moment when all wait at once; 0 never. */
typedef struct passed {
    unsigned int from, to, periodic, joystick;
} passed_t;

static passed_t watch(bu_rig_t *r, unsigned int ru, unsigned int updates)
{
    passed_t at = {0};
    for (unsigned int n = 1; n <= updates; n++) {
        uint8_t cci = r->in[CCI];
        bu_set_ru(r, ru, "joystick1", n);
        bu_update(r);
        at.from = at.from == 0 && r->in[CCI] != cci ? n : at.from;
        at.to = at.to == 0 && bu_ru_number(r, ru, "received_count") > 0 ? n : at.to;
        at.periodic = at.periodic == 0 && bu_ru_number(r, ru, "periodic_count") > 0 ? n : at.periodic;
        at.joystick += ect_load_be16(r->in + REMOTE + 10) == n;
        r->out[CAO] = r->in[CCI];
    }
    return at;
}

static void fallback_priorities(void **state)
{
    (void)state;
    for (unsigned int lost = 0; lost <= 1; lost++) {
        bu_rig_t r;
        bu_start(&r, &bu_nodes[2]);
        bu_arm(&r, 1);
        bu_set_number(&r, "ru1.g_link_lost", lost);
        bu_update(&r);
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

/* Two commands from the remote: both are sent before a command to it, and this before periodic data. */
static void fallback_order(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[2]);
    bu_arm(&r, 1);
    bu_set_number(&r, "ru1.g_link_lost", 1);
    bu_update(&r);
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
    bu_rig_t r;
    bu_start(&r, &bu_nodes[2]);
    bu_set_number(&r, "ru1.on", 1);
    bu_set_number(&r, "ru2.on", 1);
    bu_set_number(&r, "ru2.g_link_lost", 1);
    bu_update(&r);
    send_command(&r, 1);
    send_command(&r, 1);
    send_command(&r, 1);
    r.out[CCO]++;
    periodic_set(&r);
    bu_update(&r);
    assert_int_equal(bu_number(&r, "ru1.received_count"), 1);
    assert_int_equal(bu_number(&r, "ru1.periodic_count"), 1);
    assert_int_equal(bu_number(&r, "ru2.received_count"), 1);
    assert_int_equal(bu_number(&r, "ru2.periodic_count"), 0);
    bu_update(&r);
    assert_int_equal(bu_number(&r, "ru2.periodic_count"), 1);
    wire_close(&r.w);
}

/* A lost remote on fallback loses its waiting commands and its set of periodic data. */
static void nothing_waits_for_the_lost(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[2]);
    bu_set_number(&r, "ru1.on", 1);
    bu_set_number(&r, "ru1.g_link_lost", 1);
    send_command(&r, 1);
    send_command(&r, 1);
    r.out[CCO]++;
    periodic_set(&r);
    bu_update(&r);
    bu_set_number(&r, "ru1.on", 0);
    bu_set_number(&r, "ru1.on", 1);
    bu_set_number(&r, "ru1.g_link_lost", 0);
    for (unsigned int n = 0; n < 5; n++)
        bu_update(&r);
    if (bu_number(&r, "ru1.received_count") != 0 || bu_number(&r, "ru1.periodic_count") != 0)
        fail_msg("a remote that was off meanwhile got %ld commands and %ld sets from before",
                 bu_number(&r, "ru1.received_count"), bu_number(&r, "ru1.periodic_count"));
    wire_close(&r.w);
}

/* Commands that a remote sent on fallback before it was lost do not delay others after its return. */
static void lost_on_fallback(void **state)
{
    (void)state;
    bu_rig_t r;
    bu_start(&r, &bu_nodes[2]);
    bu_set_number(&r, "ru1.on", 1);
    bu_set_number(&r, "ru1.g_link_lost", 1);
    for (unsigned int n = 0; n < 5; n++)
        send_command(&r, 1);
    bu_set_number(&r, "ru1.on", 0);
    bu_set_number(&r, "ru1.on", 1);
    r.out[CCO]++;
    bu_update(&r);
    bu_update(&r);
    if (bu_number(&r, "ru1.received_count") != 1)
        fail_msg("expected the command to come through at once, got %ld", bu_number(&r, "ru1.received_count"));
    wire_close(&r.w);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-033 ECL-064: without VLAP or signal an armed remote's C-Link is No Link, arming is refused and there "
             "is no "
             "fallback",
             c_link_has_one_truth),
        TEST("ECL-033: on cable C-Link is operational without VLAP and signal", cable_needs_no_c_link),
        TEST("ECL-031: the input data have the number of VLAPs", vlaps_are_reported),
        TEST("ECL-033 ECL-064 ECL-065: an armed remote without G-Link is on fallback, without VLAP it is lost",
             armed_falls_back),
        TEST("ECL-064 ECL-065 ECL-032: armed remotes have a VLAP of their own, the others share the rest",
             reservations_hold),
        TEST("ECL-064: an armed remote on fallback keeps its VLAP when a remote that was armed later needs one too",
             reserved_in_the_order_of_arming),
        TEST("ECL-064 ECL-065: the VLAP of a lost armed remote is given to a remote that waits for one",
             vlap_of_the_lost),
        TEST("ECL-064: arming a remote on radio needs a VLAP that no other has reserved", arming_reserves_a_vlap),
        TEST("ECL-033 ECL-065: C-Link and G-Link status can be forced to each value, and a link in error transfers "
             "nothing",
             forced_links),
        TEST("ECL-033 ECL-063: no fallback over a C-Link in error", no_fallback_without_c_link),
        TEST("ECL-064: a remote without G-Link and VLAP receives neither commands nor periodic data",
             nothing_reaches_the_unreachable),
        TEST("ECL-064 ECL-028: a remote without G-Link and VLAP cannot be armed", the_unreachable_cannot_be_armed),
        TEST("ECL-064: a remote without G-Link and VLAP cannot send", the_unreachable_cannot_send),
        TEST("ECL-063: on fallback one item for each update: command from the remote, command to it, periodic data; on "
             "G-Link "
             "all at once; joysticks always",
             fallback_priorities),
        TEST("ECL-063: on fallback all commands from the remote are sent before commands to it, and these before "
             "periodic data",
             fallback_order),
        TEST("ECL-060 ECL-062 ECL-063: data that wait for a remote are dropped when the remote is lost",
             nothing_waits_for_the_lost),
        TEST("ECL-063: commands that a remote could not send before it was lost do not delay commands to it",
             lost_on_fallback),
        TEST("ECL-063: a remote on fallback is not delayed by another's commands", fallback_is_a_matter_of_each_remote),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link links", tests, NULL, NULL);
}
