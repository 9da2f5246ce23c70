/* SPDX-License-Identifier: MIT */
/* The EC-Link base unit watches its controller: BU state, EC-Link status, message and relays (TS-0007 §6.1, §10, §11).
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "support/signals.h"
#include "support/wire.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { OUTPUTS_AT = 0x1000, INPUTS_AT = 0x2800, MOST_INPUTS = 142, MOST_OUTPUTS = 228, CYCLE_MS = 10 };
enum { PCO = 0, CCO = 1, CAO = 3, PCI = 0, CCI = 1, BU_STATE = 22, EG_LINK = 25, EC_LINK = 26 };
enum {
    INITIAL = 0x00,
    STOPPED = 0x01,
    LINK_ERROR = 0x02,
    BLOCKED = 0x03,
    FAILED = 0x04,
    DISARMED = 0x10,
    ARMED = 0x11
};
enum { UNUSED = 0, OPERATIONAL = 1, NO_LINK = 2, CFG_ERROR = 3, MODULE_ERROR = 4, DATA_ERROR = 5 };
enum { COMMANDS = 1, PERIODIC = 2 };

/* Which supervision a mode has (TS-0007 §6.1: steps 3 and 4 of the guide that Input Only and Input + Commands skip). */
typedef struct node {
    const ect_device_t *device;
    unsigned int duties;
} node_t;

static const node_t nodes[] = {{&ect_eclink_map1, 0},
                               {&ect_eclink_map3, COMMANDS},
                               {&ect_eclink_map7, COMMANDS | PERIODIC},
                               {&ect_eclink_multiarm, COMMANDS | PERIODIC}};

#define FOR_EACH_NODE(node) for (const node_t *node = nodes; node < nodes + COUNT(nodes); node++)

/* A base unit and the controller that talks to it. */
typedef struct rig {
    wire_t w;
    const node_t *node;
    uint8_t out[MOST_OUTPUTS];
    uint8_t in[MOST_INPUTS];
    bool counting; /* PCO counts with each cycle */
} rig_t;

static void power_on(rig_t *r, const node_t *node)
{
    memset(r, 0, sizeof *r);
    r->node = node;
    wire_open_one(&r->w, node->device);
}

static void write_outputs(rig_t *r)
{
    uint16_t length = ect_device_sm_bytes(r->node->device, 2);
    if (length > 0)
        assert_int_equal(wire_write(&r->w, 0, OUTPUTS_AT, r->out, length), 1);
}

static void cycle(rig_t *r)
{
    r->out[PCO] = (uint8_t)(r->out[PCO] + (r->counting ? 1 : 0));
    write_outputs(r);
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, ect_device_sm_bytes(r->node->device, 3)), 1);
}

/* The controller works for a while, one cycle each 10 ms and one at the end. */
static void run(rig_t *r, uint64_t ns)
{
    uint64_t end = r->w.now_ns + ns;
    while (r->w.now_ns < end) {
        uint64_t left = end - r->w.now_ns;
        wire_advance(&r->w, left < CYCLE_MS * MS ? left : CYCLE_MS * MS);
        cycle(r);
    }
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

static long number(rig_t *r, const char *name)
{
    return (long)signal_number(&r->w, name);
}

static const char *message_of(int link)
{
    static const char *const messages[] = {"", "", "EC: No Data", "EC: Cfg. Error", "EC: Module Error", "EC: Bad data"};
    return messages[link];
}

/* What the operator sees at once: BU state, EC-Link status, the message that belongs to it, relays. */
static void expect(rig_t *r, const char *when, int state, int link)
{
    char message[ECT_SIGNAL_TEXT_ROOM], cause[ECT_SIGNAL_TEXT_ROOM];
    get(r, "bu.message", message);
    get(r, "bu.cause", cause);
    long relays = number(r, "bu.es_link");
    if (number(r, "bu.state") != state || number(r, "bu.ec_link") != link || relays != (state >= DISARMED) ||
        strcmp(message, message_of(link)) != 0 || (*cause != 0) != (link >= NO_LINK || link == 0))
        fail_msg("%s, %s: expected BU state 0x%02X, EC-Link %d, relays %d, \"%s\"; got 0x%02lX, %ld, %ld, \"%s\" (%s)",
                 r->node->device->type_name, when, (unsigned int)state, link, state >= DISARMED, message_of(link),
                 (unsigned long)number(r, "bu.state"), number(r, "bu.ec_link"), relays, message, cause);
}

/* The same, and after the next update also what the controller reads. */
static void expect_told(rig_t *r, const char *when, int state, int link)
{
    expect(r, when, state, link);
    run(r, 125 * MS);
    expect(r, when, state, link);
    if (r->in[BU_STATE] != state || r->in[EC_LINK] != link)
        fail_msg("%s, %s: expected BU state 0x%02X and EC-Link %d in the input data, got 0x%02X and %u",
                 r->node->device->type_name, when, (unsigned int)state, link, r->in[BU_STATE], r->in[EC_LINK]);
}

/* In OP and in order; armed or not. @return the BU state that this is */
static int in_order(rig_t *r, const node_t *node, bool armed)
{
    power_on(r, node);
    to_op(r);
    r->counting = (node->duties & PERIODIC) != 0;
    if (armed) {
        set(r, "ru1.on", "1");
        set(r, "ru1.armed", "1");
    }
    run(r, 30 * MS);
    expect_told(r, "in order", armed ? ARMED : DISARMED, OPERATIONAL);
    return armed ? ARMED : DISARMED;
}

/* --- the way to normal operation ---------------------------------------------------------------------------------- */

static void initial_until_data(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        power_on(&r, node);
        expect(&r, "INIT", INITIAL, NO_LINK);
        wire_go(&r.w, 0, ECT_STATE_PREOP);
        expect(&r, "PREOP", INITIAL, NO_LINK);
        wire_advance(&r.w, 10000 * MS);
        expect(&r, "10 s in PREOP", INITIAL, NO_LINK);
        wire_go(&r.w, 0, ECT_STATE_SAFEOP);
        run(&r, 1000 * MS);
        expect_told(&r, "SAFEOP", INITIAL, NO_LINK);
        set(&r, "ru1.on", "1");
        set(&r, "ru1.armed", "1");
        expect_told(&r, "SAFEOP, armed", INITIAL, NO_LINK);
        wire_close(&r.w);
    }
}

static void normal_with_the_duties_of_the_mode(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        power_on(&r, node);
        to_op(&r);
        if ((node->duties & PERIODIC) != 0) {
            expect(&r, "OP, PCO has not moved", INITIAL, DATA_ERROR);
            run(&r, 5000 * MS);
            expect_told(&r, "OP for 5 s, PCO has not moved", INITIAL, DATA_ERROR);
            r.out[PCO]++;
            cycle(&r);
        }
        expect_told(&r, "in order", DISARMED, OPERATIONAL);
        set(&r, "ru1.on", "1");
        expect_told(&r, "a remote is on", DISARMED, OPERATIONAL);
        set(&r, "ru1.armed", "1");
        expect_told(&r, "armed", ARMED, OPERATIONAL);
        set(&r, "ru1.armed", "0");
        expect_told(&r, "disarmed", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void pco_unsupervised(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        if ((node->duties & PERIODIC) != 0)
            continue;
        int good = in_order(&r, node, true);
        for (unsigned int s = 0; s < 10; s++) {
            run(&r, 1000 * MS);
            expect(&r, "PCO never moves", good, OPERATIONAL);
        }
        wire_close(&r.w);
    }
}

/* --- PCO ---------------------------------------------------------------------------------------------------------- */

static void pco_limit(void **state)
{
    (void)state;
    for (unsigned int row = 0; row < 4; row++) {
        const node_t *node = &nodes[2 + row / 2];
        rig_t r;
        int good = in_order(&r, node, row % 2 == 1);
        r.counting = false;
        r.out[PCO]++;
        cycle(&r);
        run(&r, 1999 * MS);
        expect(&r, "1999 ms after PCO", good, OPERATIONAL);
        run(&r, 1 * MS - 1);
        expect(&r, "1 ns before 2000 ms after PCO", good, OPERATIONAL);
        run(&r, 1);
        expect(&r, "2000 ms after PCO", LINK_ERROR, DATA_ERROR);
        expect_told(&r, "2000 ms after PCO", LINK_ERROR, DATA_ERROR);
        run(&r, 3000 * MS);
        expect(&r, "5 s after PCO", LINK_ERROR, DATA_ERROR);
        r.out[PCO]++;
        cycle(&r);
        expect_told(&r, "PCO again", good, OPERATIONAL);
        run(&r, 1874 * MS);
        expect(&r, "1999 ms after PCO again", good, OPERATIONAL);
        run(&r, 1 * MS);
        expect(&r, "2000 ms after PCO again", LINK_ERROR, DATA_ERROR);
        wire_close(&r.w);
    }
}

static void pco_slow_but_in_time(void **state)
{
    (void)state;
    rig_t r;
    int good = in_order(&r, &nodes[2], true);
    r.counting = false;
    r.out[PCO] = 250;
    cycle(&r);
    for (unsigned int n = 0; n < 12; n++) { /* through 255 -> 0 */
        run(&r, 1990 * MS);
        wire_advance(&r.w, 9 * MS);
        expect(&r, "1999 ms after PCO", good, OPERATIONAL);
        r.out[PCO]++;
        cycle(&r);
        expect(&r, "PCO in time", good, OPERATIONAL);
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
        rig_t r;
        int good = in_order(&r, &nodes[3], true);
        r.counting = false;
        r.out[PCO] = rows[i].stuck;
        run(&r, 2010 * MS);
        expect(&r, "stuck", LINK_ERROR, DATA_ERROR);
        r.out[PCO] = rows[i].next;
        cycle(&r);
        expect_told(&r, "one more", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* --- CAO ---------------------------------------------------------------------------------------------------------- */

/* A remote sends a command; returns when it has just come to stand in the input data (its update). */
static void command_shown(rig_t *r)
{
    uint8_t before = r->in[CCI];
    set(r, "ru1.on", "1");
    set(r, "ru1.command", "000102030405060708090a0b0c0d0e0f");
    for (unsigned int ms = 0; ms < 125 && r->in[CCI] == before; ms++)
        run(r, 1 * MS);
    assert_int_equal(r->in[CCI], (uint8_t)(before + 1));
}

static void cao_limit(void **state)
{
    (void)state;
    for (unsigned int row = 0; row < 6; row++) {
        rig_t r;
        int good = in_order(&r, &nodes[1 + row / 2], row % 2 == 1);
        command_shown(&r);
        run(&r, 1998 * MS);
        expect(&r, "1998 ms without acknowledge", good, OPERATIONAL);
        run(&r, 1 * MS);
        expect(&r, "1999 ms without acknowledge", good, OPERATIONAL);
        run(&r, 1 * MS);
        expect_told(&r, "2000 ms without acknowledge", LINK_ERROR, DATA_ERROR);
        run(&r, 3000 * MS);
        expect(&r, "5 s without acknowledge", LINK_ERROR, DATA_ERROR);
        r.out[CAO] = r.in[CCI];
        cycle(&r);
        expect_told(&r, "acknowledged late", good, OPERATIONAL);
        run(&r, 5000 * MS);
        expect(&r, "nothing more to acknowledge", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void cao_in_time(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < COUNT(nodes); n++) {
        rig_t r;
        int good = in_order(&r, &nodes[n], true);
        for (unsigned int turn = 0; turn < 3; turn++) {
            command_shown(&r);
            run(&r, 1990 * MS);
            wire_advance(&r.w, 9 * MS);
            r.out[CAO] = r.in[CCI];
            cycle(&r);
            run(&r, 4000 * MS);
            expect(&r, "acknowledged after 1999 ms", good, OPERATIONAL);
        }
        wire_close(&r.w);
    }
}

static void cao_of_something_else(void **state)
{
    static const int wrong[] = {-1, 1, 2, 128};
    (void)state;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        rig_t r;
        int good = in_order(&r, &nodes[1], false);
        for (unsigned int n = 0; n < 3; n++) {
            command_shown(&r);
            r.out[CAO] = r.in[CCI];
            cycle(&r);
        }
        command_shown(&r);
        run(&r, 1000 * MS);
        r.out[CAO] = (uint8_t)(r.in[CCI] + wrong[i]);
        run(&r, 990 * MS);
        expect(&r, "not acknowledged for 1990 ms", good, OPERATIONAL);
        run(&r, 10 * MS);
        expect_told(&r, "another number is no acknowledge", LINK_ERROR, DATA_ERROR);
        r.out[CAO] = r.in[CCI];
        cycle(&r);
        expect(&r, "acknowledged", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

/* The limit counts from the outputs that withdraw the acknowledge, wherever that is between two updates. */
static void acknowledge_withdrawn(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < COUNT(nodes); n++) {
        rig_t r;
        int good = in_order(&r, &nodes[n], true);
        command_shown(&r);
        r.out[CAO] = r.in[CCI];
        run(&r, 3000 * MS + 33);
        r.out[CAO]--;
        cycle(&r);
        run(&r, 2000 * MS - 1);
        expect(&r, "1 ns before 2000 ms", good, OPERATIONAL);
        wire_advance(&r.w, 1);
        expect(&r, "2000 ms", LINK_ERROR, DATA_ERROR);
        r.out[CAO]++;
        cycle(&r);
        expect(&r, "acknowledged again", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void cao_wraps(void **state)
{
    (void)state;
    rig_t r;
    int good = in_order(&r, &nodes[1], true);
    for (unsigned int n = 1; n <= 256; n++) {
        command_shown(&r);
        assert_int_equal(r.in[CCI], (uint8_t)n);
        if (n < 256)
            r.out[CAO] = r.in[CCI];
        cycle(&r);
        expect(&r, "all acknowledged", good, OPERATIONAL);
    }
    run(&r, 2000 * MS);
    expect(&r, "CCI is 0 and CAO still 255", LINK_ERROR, DATA_ERROR);
    r.out[CAO] = 0;
    cycle(&r);
    expect(&r, "CAO is 0 too", good, OPERATIONAL);
    wire_close(&r.w);
}

static void both_late(void **state)
{
    (void)state;
    rig_t r;
    int good = in_order(&r, &nodes[2], true);
    command_shown(&r);
    r.counting = false;
    run(&r, 3000 * MS);
    expect(&r, "PCO and CAO late", LINK_ERROR, DATA_ERROR);
    r.counting = true;
    run(&r, 20 * MS);
    expect(&r, "CAO late", LINK_ERROR, DATA_ERROR);
    r.out[CAO] = r.in[CCI];
    run(&r, 20 * MS);
    expect(&r, "neither", good, OPERATIONAL);
    wire_close(&r.w);
}

static void no_commands_in_input_only(void **state)
{
    (void)state;
    rig_t r;
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE] = "";
    int good = in_order(&r, &nodes[0], true);
    signal_find(&r.w, "ru1.command", &ref);
    assert_false(ect_signal_write(&ref, "000102030405060708090a0b0c0d0e0f", r.w.now_ns, message));
    assert_true(strlen(message) > 0);
    run(&r, 5000 * MS);
    expect_told(&r, "no command went out", good, OPERATIONAL);
    assert_int_equal(r.in[CCI], 0);
    wire_close(&r.w);
}

/* --- loss of data ------------------------------------------------------------------------------------------------- */

static void watchdog_after_good(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < COUNT(nodes); n++) {
        rig_t r;
        int good = in_order(&r, &nodes[n], n % 2 == 0);
        uint8_t status[6];
        wire_advance(&r.w, 90 * MS);
        expect(&r, "90 ms without outputs", good, OPERATIONAL);
        wire_advance(&r.w, 20 * MS);
        expect(&r, "110 ms without outputs", LINK_ERROR, NO_LINK);
        assert_int_equal(wire_read(&r.w, 0, ECT_REG_AL_STATUS, status, 6), 1);
        assert_int_equal(status[0], ECT_STATE_SAFEOP | ECT_AL_ERROR);
        assert_int_equal(ect_load_le16(status + 4), ECT_AL_WATCHDOG);
        assert_int_equal(ect_chain_slave(r.w.chain, 0)->cause, ECT_CAUSE_WATCHDOG);
        run(&r, 500 * MS);
        expect_told(&r, "outputs in SAFEOP are not used", LINK_ERROR, NO_LINK);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP | ECT_AL_ACKNOWLEDGE, NULL), ECT_STATE_SAFEOP);
        expect(&r, "acknowledged", LINK_ERROR, NO_LINK);
        cycle(&r);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
        if ((nodes[n].duties & PERIODIC) != 0)
            expect(&r, "OP again, PCO has not moved yet", LINK_ERROR, DATA_ERROR);
        cycle(&r);
        expect_told(&r, "OP again", good, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void watchdog_before_good(void **state)
{
    (void)state;
    rig_t r;
    power_on(&r, &nodes[2]);
    to_op(&r);
    run(&r, 500 * MS);
    wire_advance(&r.w, 150 * MS);
    expect_told(&r, "watchdog before the first good exchange", INITIAL, NO_LINK);
    wire_close(&r.w);
}

static void controller_leaves_op(void **state)
{
    static const uint8_t targets[] = {ECT_STATE_SAFEOP, ECT_STATE_PREOP, ECT_STATE_INIT};
    (void)state;
    FOR_EACH_NODE(node)
    {
        for (size_t i = 0; i < COUNT(targets); i++) {
            rig_t r;
            int good = in_order(&r, node, true);
            assert_int_equal(wire_al(&r.w, 0, targets[i], NULL), targets[i]);
            expect(&r, "controller left OP", LINK_ERROR, NO_LINK);
            wire_advance(&r.w, 5000 * MS);
            expect(&r, "controller left OP 5 s ago", LINK_ERROR, NO_LINK);
            to_op(&r);
            cycle(&r);
            expect_told(&r, "controller is back", good, OPERATIONAL);
            wire_close(&r.w);
        }
    }
}

static void deadlines_end_with_op(void **state)
{
    (void)state;
    rig_t r;
    int good = in_order(&r, &nodes[2], true);
    command_shown(&r);
    run(&r, 1500 * MS);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    wire_advance(&r.w, 3000 * MS);
    expect(&r, "SAFEOP", LINK_ERROR, NO_LINK);
    cycle(&r);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
    run(&r, 1500 * MS);
    expect(&r, "a new 2000 ms for the acknowledge", good, OPERATIONAL);
    run(&r, 600 * MS);
    expect(&r, "not acknowledged", LINK_ERROR, DATA_ERROR);
    wire_close(&r.w);
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
static void refuse(rig_t *r, const struct mismatch *m)
{
    const ect_sm_t *sm = &r->node->device->sm[m->sm];
    uint16_t code = 0;
    wire_go(&r->w, 0, m->refused == ECT_STATE_PREOP ? ECT_STATE_INIT : ECT_STATE_PREOP);
    if (m->refused == ECT_STATE_PREOP)
        wire_configure_mailbox(&r->w, 0);
    else
        wire_configure_process_data(&r->w, 0);
    wire_set_sm(&r->w, 0, m->sm, (uint16_t)(sm->start + m->start), (uint16_t)(sm->length + m->longer), sm->control);
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
            rig_t r;
            if (node->device->sm[m->sm].length == 0)
                continue;
            power_on(&r, node);
            refuse(&r, m);
            expect(&r, m->what, INITIAL, CFG_ERROR);
            assert_int_equal(ect_chain_slave(r.w.chain, 0)->cause, ECT_CAUSE_REQUEST);
            wire_advance(&r.w, 3000 * MS);
            expect(&r, m->what, INITIAL, CFG_ERROR);
            to_op(&r);
            r.counting = true;
            run(&r, 20 * MS);
            expect_told(&r, "configured as it should be", DISARMED, OPERATIONAL);
            refuse(&r, m);
            expect(&r, m->what, LINK_ERROR, CFG_ERROR);
            wire_close(&r.w);
        }
    }
}

static void configuration_changes_in_op(void **state)
{
    (void)state;
    rig_t r;
    in_order(&r, &nodes[2], true);
    wire_set_sm(&r.w, 0, 3, INPUTS_AT, 142, 0x20);
    expect(&r, "SM3 of another node", LINK_ERROR, CFG_ERROR);
    wire_close(&r.w);
}

static void acknowledged_but_no_further(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(mismatches); i++) {
        const struct mismatch *m = &mismatches[i];
        uint8_t stays = m->refused == ECT_STATE_PREOP ? ECT_STATE_INIT : ECT_STATE_PREOP;
        rig_t r;
        power_on(&r, &nodes[2]);
        refuse(&r, m);
        assert_int_equal(wire_al(&r.w, 0, stays | ECT_AL_ACKNOWLEDGE, NULL), stays);
        expect(&r, "the error flag is acknowledged, the controller is no further", INITIAL, CFG_ERROR);
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
        rig_t r;
        uint8_t status[6];
        power_on(&r, &nodes[2]);
        wire_go(&r.w, 0, rows[i].from);
        (void)wire_al(&r.w, 0, rows[i].request, NULL);
        wire_advance(&r.w, 5100 * MS);
        assert_int_equal(wire_read(&r.w, 0, ECT_REG_AL_STATUS, status, 6), 1);
        assert_int_equal(ect_load_le16(status + 4), rows[i].code);
        expect(&r, rows[i].what, INITIAL, NO_LINK);
        wire_close(&r.w);
    }
}

/* --- the unit's own errors ---------------------------------------------------------------------------------------- */

static void module_error(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        power_on(&r, node);
        set(&r, "bu.module_error", "1");
        expect(&r, "module error at power-on", INITIAL, MODULE_ERROR);
        to_op(&r);
        r.counting = true;
        run(&r, 20 * MS);
        expect_told(&r, "module error since power-on", INITIAL, MODULE_ERROR);
        set(&r, "bu.module_error", "0");
        expect_told(&r, "no module error", DISARMED, OPERATIONAL);
        set(&r, "ru1.on", "1");
        set(&r, "ru1.armed", "1");
        set(&r, "bu.module_error", "1");
        expect_told(&r, "module error after the first good exchange", LINK_ERROR, MODULE_ERROR);
        set(&r, "bu.module_error", "0");
        expect_told(&r, "no module error any more", ARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void module_error_hides_the_rest(void **state)
{
    (void)state;
    rig_t r;
    in_order(&r, &nodes[2], true);
    r.counting = false;
    run(&r, 2000 * MS);
    expect(&r, "PCO is late", LINK_ERROR, DATA_ERROR);
    set(&r, "bu.module_error", "1");
    expect(&r, "module error and PCO late", LINK_ERROR, MODULE_ERROR);
    refuse(&r, &mismatches[0]);
    expect(&r, "module error and refused configuration", LINK_ERROR, MODULE_ERROR);
    set(&r, "bu.module_error", "0");
    expect(&r, "refused configuration", LINK_ERROR, CFG_ERROR);
    wire_close(&r.w);
}

static void failed(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        power_on(&r, node);
        set(&r, "bu.failed", "1");
        expect(&r, "failed before the first exchange", FAILED, NO_LINK);
        set(&r, "bu.failed", "0");
        wire_close(&r.w);
        int good = in_order(&r, node, true);
        set(&r, "bu.failed", "1");
        expect_told(&r, "failed", FAILED, OPERATIONAL);
        set(&r, "bu.module_error", "1");
        expect_told(&r, "failed, and a module error", FAILED, MODULE_ERROR);
        set(&r, "bu.module_error", "0");
        set(&r, "bu.failed", "0");
        expect_told(&r, "repaired", good, OPERATIONAL);
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
            rig_t r;
            char text[2] = {(char)('0' + value), 0};
            int good = in_order(&r, node, true);
            set(&r, "bu.eg_link", text);
            expect_told(&r, text, value >= 2 && value <= 5 ? LINK_ERROR : good, OPERATIONAL);
            assert_int_equal(r.in[EG_LINK], value);
            set(&r, "bu.eg_link", "0");
            expect_told(&r, "EG-Link unused", good, OPERATIONAL);
            wire_close(&r.w);
        }
    }
}

static void worse_state_wins(void **state)
{
    (void)state;
    rig_t r;
    int good = in_order(&r, &nodes[3], true);
    set(&r, "ru2.on", "1");
    set(&r, "ru2.armed", "1");
    set(&r, "ru1.stop", "1");
    expect_told(&r, "an armed remote stops", STOPPED, OPERATIONAL);
    set(&r, "ru2.on", "0");
    expect_told(&r, "another is lost", BLOCKED, OPERATIONAL);
    r.counting = false;
    run(&r, 2000 * MS);
    expect_told(&r, "PCO is late", LINK_ERROR, DATA_ERROR);
    r.counting = true;
    run(&r, 10 * MS);
    expect_told(&r, "PCO again", BLOCKED, OPERATIONAL);
    set(&r, "ru2.on", "1");
    set(&r, "ru2.armed", "1");
    expect_told(&r, "rearmed", STOPPED, OPERATIONAL);
    set(&r, "ru1.stop", "0");
    expect_told(&r, "released", good, OPERATIONAL);
    wire_close(&r.w);
}

/* --- mode Disabled ------------------------------------------------------------------------------------------------ */

static void disabled_alone(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        uint8_t byte = 0;
        power_on(&r, node);
        assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), 1);
        set(&r, "bu.enabled", "0");
        assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), NO_REPLY);
        expect(&r, "Disabled", DISARMED, UNUSED);
        wire_advance(&r.w, 10000 * MS);
        expect(&r, "Disabled for 10 s", DISARMED, UNUSED);
        set(&r, "ru1.on", "1");
        set(&r, "ru1.armed", "1");
        expect(&r, "Disabled, armed", ARMED, UNUSED);
        set(&r, "bu.module_error", "1");
        expect(&r, "a module that is not used", ARMED, UNUSED);
        set(&r, "bu.module_error", "0");
        set(&r, "bu.enabled", "1");
        expect(&r, "enabled again", INITIAL, NO_LINK);
        assert_int_equal(wire_send(&r.w, BRD, 0, 0x0000, &byte, 1), 1);
        to_op(&r);
        r.counting = true;
        run(&r, 20 * MS);
        expect_told(&r, "in order", ARMED, OPERATIONAL);
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
        fail_msg("behind it nothing answers: expected port 1 without link and closed (0x%04X), got 0x%04X", CLOSED,
                 status);
    enable(&w, 1, "1");
    assert_int_equal(wire_read16(&w, 0, 0x0110) & PORT1, LINK);
    wire_close(&w);
}

/* --- PCI ---------------------------------------------------------------------------------------------------------- */

static void expect_pci(rig_t *r, const char *when, uint8_t want)
{
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, 1), 1);
    if (r->in[PCI] != want || number(r, "bu.pci") != want)
        fail_msg("%s, %s: expected PCI %u, got %u on the wire and bu.pci %ld", r->node->device->type_name, when, want,
                 r->in[PCI], number(r, "bu.pci"));
}

static void pci_rhythm(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        rig_t r;
        power_on(&r, node);
        to_op(&r);
        r.counting = true;
        for (unsigned int n = 0; n < 300; n++) { /* through 255 -> 0 */
            run(&r, 124 * MS);
            expect_pci(&r, "124 ms after an update", (uint8_t)n);
            run(&r, 1 * MS);
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
    rig_t r;
    in_order(&r, &nodes[2], true);
    for (size_t i = 0; i < COUNT(errors); i++) {
        uint8_t pci = r.in[PCI];
        set(&r, errors[i].name, errors[i].value);
        run(&r, 500 * MS);
        expect_pci(&r, errors[i].name, (uint8_t)(pci + 4));
    }
    r.counting = false;
    uint8_t pci = r.in[PCI];
    run(&r, 4000 * MS);
    expect_pci(&r, "PCO late", (uint8_t)(pci + 32));
    wire_close(&r.w);
}

/* Between two updates the input data do not change, whatever happens. */
static void inputs_hold_between_updates(void **state)
{
    (void)state;
    rig_t r;
    uint8_t before[MOST_INPUTS];
    in_order(&r, &nodes[2], true);
    memcpy(before, r.in, sizeof before);
    set(&r, "ru1.stop", "1");
    set(&r, "ru1.joystick1", "-1000");
    set(&r, "bu.vlaps", "1");
    expect(&r, "at once", STOPPED, OPERATIONAL);
    for (unsigned int n = 0; r.in[PCI] == before[PCI] && n < 20; n++) {
        assert_memory_equal(r.in, before, 66);
        run(&r, 10 * MS);
    }
    assert_int_equal(r.in[PCI], before[PCI] + 1);
    assert_int_equal(r.in[BU_STATE], STOPPED);
    assert_int_equal(r.in[23], 1);
    assert_int_equal(ect_load_be16(r.in + 38), 0x10000 - 1000);
    wire_close(&r.w);
}

static void late_polls(void **state)
{
    (void)state;
    rig_t r;
    power_on(&r, &nodes[0]);
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

#define TEST(title, function)                                                                                          \
    {                                                                                                                  \
        title, function, NULL, NULL, NULL                                                                              \
    }

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-018 ECL-066 ECL-068 EC-C6: until data flow the BU is Initial, EC-Link No Link, relays open, "
             "\"EC: No Data\"",
             initial_until_data),
        TEST("ECL-018 ECL-019 ECL-058 EC-C6: the BU is in order as soon as the duties of its mode are done, not before",
             normal_with_the_duties_of_the_mode),
        TEST("ECL-058: Input Only and Input + Commands do not watch PCO", pco_unsupervised),
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
        TEST("ECL-056: 2000 ms after CAO has left CCI it is Bad data", acknowledge_withdrawn),
        TEST("ECL-056 ECL-023: CCI goes from 255 to 0, and so must CAO", cao_wraps),
        TEST("ECL-056 ECL-057: with PCO and CAO late, both must come back", both_late),
        TEST("ECL-058: Input Only sends no commands, so none is ever late", no_commands_in_input_only),
        TEST("ECL-073 ECL-066: without outputs the watchdog ends OP: External link error, No Data, until OP and duties "
             "again",
             watchdog_after_good),
        TEST("ECL-073 ECL-068 EC-C6: a watchdog before the first good exchange leaves the BU Initial",
             watchdog_before_good),
        TEST("ECL-066 EC-C6: when the controller leaves OP after a good exchange it is External link error, No Data",
             controller_leaves_op),
        TEST("ECL-056: leaving OP ends the supervision, entering it begins a new 2000 ms", deadlines_end_with_op),
        TEST("ECL-072 ECL-066 EC-C6: a refused SyncManager configuration is Cfg. Error: Initial before, External link "
             "error after the first good exchange",
             configuration_error),
        TEST("ECL-072: a SyncManager that changes to another size in OP is Cfg. Error", configuration_changes_in_op),
        TEST("ECL-072: acknowledging the error flag without getting further leaves Cfg. Error standing",
             acknowledged_but_no_further),
        TEST("ECL-066 ECL-072: refusals that are no configuration mismatch are No Data, not Cfg. Error",
             refusals_without_mismatch),
        TEST("ECL-066 EC-C6: an error of the module is Module Error: Initial before, External link error after the "
             "first good exchange",
             module_error),
        TEST("ECL-066: Module Error goes before Cfg. Error and Bad data", module_error_hides_the_rest),
        TEST("ECL-028 ECL-029: a fatal internal error is Failed whatever else there is", failed),
        TEST("ECL-028 ECL-033: EG-Link status 2 to 5 is External link error, the other values are not", eg_link),
        TEST("ECL-028 ECL-029: External link error goes before Blocked, Blocked before Stopped", worse_state_wins),
        TEST("ECL-002 ECL-069: Disabled: no reply, EC-Link Unused, no message, nothing supervised; enabled it starts "
             "Initial",
             disabled_alone),
        TEST("ECL-002: a disabled unit in a chain is gone with all behind it", disabled_in_a_chain),
        TEST("ECL-002: the unit before a disabled one shows no link at that port", neighbour_sees_no_link),
        TEST("ECL-020 ECL-021: PCI counts exactly every 125 ms, from 255 to 0", pci_rhythm),
        TEST("ECL-022: PCI counts on in every error", pci_counts_in_error),
        TEST("ECL-020: input data change only together with PCI", inputs_hold_between_updates),
        TEST("ECL-020: late polls neither shift the rhythm nor make up for updates", late_polls),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link supervision", tests, NULL, NULL);
}
