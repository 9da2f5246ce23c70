/* SPDX-License-Identifier: MIT */
#include "support/base_unit.h"

#include <stdio.h>
#include <string.h>

const bu_node_t bu_nodes[BU_NODES] = {{&ect_eclink_map1, 0},
                                      {&ect_eclink_map3, COMMANDS},
                                      {&ect_eclink_map7, COMMANDS | PERIODIC},
                                      {&ect_eclink_multiarm, COMMANDS | PERIODIC}};

void bu_power_on(bu_rig_t *r, const bu_node_t *node)
{
    memset(r, 0, sizeof *r);
    r->node = node;
    wire_open_one(&r->w, node->device);
}

void bu_write_outputs(bu_rig_t *r)
{
    uint16_t length = ect_device_sm_bytes(r->node->device, 2);
    if (length > 0)
        assert_int_equal(wire_write(&r->w, 0, OUTPUTS_AT, r->out, length), 1);
}

void bu_cycle(bu_rig_t *r)
{
    r->out[PCO] = (uint8_t)(r->out[PCO] + (r->counting ? 1 : 0));
    bu_write_outputs(r);
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, ect_device_sm_bytes(r->node->device, 3)), 1);
}

void bu_run(bu_rig_t *r, uint64_t ns)
{
    uint64_t end = r->w.now_ns + ns;
    while (r->w.now_ns < end) {
        uint64_t left = end - r->w.now_ns;
        wire_advance(&r->w, left < CYCLE_MS * MS ? left : CYCLE_MS * MS);
        bu_cycle(r);
    }
}

void bu_to_op(bu_rig_t *r)
{
    wire_go(&r->w, 0, ECT_STATE_SAFEOP);
    bu_write_outputs(r);
    assert_int_equal(wire_al(&r->w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
}

void bu_set(bu_rig_t *r, const char *name, const char *value)
{
    signal_set(&r->w, name, value);
}

void bu_get(bu_rig_t *r, const char *name, char text[ECT_SIGNAL_TEXT_ROOM])
{
    signal_get(&r->w, name, text);
}

long bu_number(bu_rig_t *r, const char *name)
{
    return (long)signal_number(&r->w, name);
}

static const char *message_of(int link)
{
    static const char *const messages[] = {"", "", "EC: No Data", "EC: Cfg. Error", "EC: Module Error", "EC: Bad data"};
    return messages[link];
}

void bu_expect(bu_rig_t *r, const char *when, int state, int link)
{
    char message[ECT_SIGNAL_TEXT_ROOM], cause[ECT_SIGNAL_TEXT_ROOM];
    bu_get(r, "bu.message", message);
    bu_get(r, "bu.cause", cause);
    long relays = bu_number(r, "bu.es_link");
    if (bu_number(r, "bu.state") != state || bu_number(r, "bu.ec_link") != link || relays != (state >= DISARMED) ||
        strcmp(message, message_of(link)) != 0 || (*cause != 0) != (state < DISARMED || link == UNUSED))
        fail_msg("%s, %s: expected BU state 0x%02X, EC-Link %d, relays %d, \"%s\"; got 0x%02lX, %ld, %ld, \"%s\" (%s)",
                 r->node->device->type_name, when, (unsigned int)state, link, state >= DISARMED, message_of(link),
                 (unsigned long)bu_number(r, "bu.state"), bu_number(r, "bu.ec_link"), relays, message, cause);
}

void bu_expect_reported(bu_rig_t *r, const char *when, int state, int link)
{
    bu_expect(r, when, state, link);
    bu_run(r, 125 * MS);
    bu_expect(r, when, state, link);
    if (r->in[BU_STATE] != state || r->in[EC_LINK] != link)
        fail_msg("%s, %s: expected BU state 0x%02X and EC-Link %d in the input data, got 0x%02X and %u",
                 r->node->device->type_name, when, (unsigned int)state, link, r->in[BU_STATE], r->in[EC_LINK]);
}

int bu_in_order(bu_rig_t *r, const bu_node_t *node, bool armed)
{
    bu_power_on(r, node);
    bu_to_op(r);
    r->counting = (node->duties & PERIODIC) != 0;
    bu_run(r, 30 * MS);
    if (armed) {
        bu_set(r, "ru1.on", "1");
        bu_set(r, "ru1.armed", "1");
    }
    bu_expect_reported(r, "in order", armed ? ARMED : DISARMED, OPERATIONAL);
    return armed ? ARMED : DISARMED;
}

void bu_command_shown(bu_rig_t *r)
{
    uint8_t before = r->in[CCI];
    bu_set(r, "ru1.on", "1");
    bu_set(r, "ru1.command", "000102030405060708090a0b0c0d0e0f");
    for (unsigned int ms = 0; ms < 125 && r->in[CCI] == before; ms++)
        bu_run(r, 1 * MS);
    assert_int_equal(r->in[CCI], (uint8_t)(before + 1));
}

void bu_start(bu_rig_t *r, const bu_node_t *node)
{
    bu_power_on(r, node);
    bu_to_op(r);
    r->counting = true;
    bu_cycle(r);
    bu_update(r);
}

void bu_update(bu_rig_t *r)
{
    uint8_t before = r->in[0];
    for (unsigned int ms = 0; r->in[0] == before && ms <= 125; ms += CYCLE_MS) {
        wire_advance(&r->w, CYCLE_MS * MS);
        bu_cycle(r);
    }
    assert_int_equal(r->in[0], (uint8_t)(before + 1));
}

bool bu_try_set(bu_rig_t *r, const char *name, long value)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    char text[24];
    snprintf(text, sizeof text, "%ld", value);
    bool done = signal_try_set(&r->w, name, text, message);
    if (done != (*message == 0))
        fail_msg("%s := %ld %s, message \"%s\"", name, value, done ? "done" : "refused", message);
    return done;
}

void bu_set_number(bu_rig_t *r, const char *name, long value)
{
    if (!bu_try_set(r, name, value))
        fail_msg("%s := %ld was refused", name, value);
}

void bu_set_ru(bu_rig_t *r, unsigned int ru, const char *signal, long value)
{
    bu_set_number(r, signal_of_ru(ru, signal), value);
}

long bu_ru_number(bu_rig_t *r, unsigned int ru, const char *signal)
{
    return bu_number(r, signal_of_ru(ru, signal));
}

void bu_arm(bu_rig_t *r, unsigned int ru)
{
    bu_set_ru(r, ru, "on", 1);
    bu_set_ru(r, ru, "armed", 1);
}

void bu_expect_blocks(bu_rig_t *r, const char *when, const char *ids, uint8_t bu_state)
{
    char got[8] = "";
    bu_update(r);
    unsigned int blocks = (ect_device_sm_bytes(r->node->device, 3) - REMOTE) / (unsigned int)STRIDE;
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
    if (strcmp(got, ids) != 0 || r->in[BU_STATE] != bu_state || bu_number(r, "bu.armed") != (long)strlen(ids))
        fail_msg("%s, %s: expected remotes \"%s\", BU state 0x%02X; got \"%s\", 0x%02X, bu.armed %ld",
                 r->node->device->type_name, when, ids, bu_state, got, r->in[BU_STATE], bu_number(r, "bu.armed"));
    assert_int_equal(bu_number(r, "bu.es_link"), bu_state >= DISARMED);
}
