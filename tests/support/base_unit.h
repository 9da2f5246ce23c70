/* SPDX-License-Identifier: MIT */
/** @file A base unit in virtual time, and the controller that talks to it (TS-0007). */
#ifndef TESTS_SUPPORT_BASE_UNIT_H
#define TESTS_SUPPORT_BASE_UNIT_H

#include "devices/eclink/eclink.h"
#include "support/signals.h"
#include "support/wire.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { OUTPUTS_AT = 0x1000, INPUTS_AT = 0x2800, MOST_INPUTS = 142, MOST_OUTPUTS = 228, CYCLE_MS = 10 };
enum {
    PCO = 0,
    CCO = 1,
    CAO = 3,
    PCI = 0,
    CCI = 1,
    BU_STATE = 22,
    VLAPS = 23,
    UNARMED = 24,
    EG_LINK = 25,
    EC_LINK = 26
};
enum { REMOTE = 28, STRIDE = 38 };
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
typedef struct bu_node {
    const ect_device_t *device;
    unsigned int duties;
} bu_node_t;

enum { BU_NODES = 4 };
extern const bu_node_t bu_nodes[BU_NODES];

#define FOR_EACH_NODE(node) for (const bu_node_t *node = bu_nodes; node < bu_nodes + BU_NODES; node++)

typedef struct bu_rig {
    wire_t w;
    const bu_node_t *node;
    uint8_t out[MOST_OUTPUTS];
    uint8_t in[MOST_INPUTS];
    bool counting; /* PCO counts with each cycle */
} bu_rig_t;

void bu_power_on(bu_rig_t *r, const bu_node_t *node);
void bu_to_op(bu_rig_t *r);
void bu_write_outputs(bu_rig_t *r);
/* Writes outputs and reads inputs. */
void bu_cycle(bu_rig_t *r);
/* The controller works for a while, one cycle each 10 ms and one at the end. */
void bu_run(bu_rig_t *r, uint64_t ns);

/* Until the next input data have come. */
void bu_update(bu_rig_t *r);

/* Signals, as in support/signals.h. */
void bu_set(bu_rig_t *r, const char *name, const char *value);
void bu_get(bu_rig_t *r, const char *name, char text[ECT_SIGNAL_TEXT_ROOM]);
long bu_number(bu_rig_t *r, const char *name);

bool bu_try_set(bu_rig_t *r, const char *name, long value);
void bu_set_number(bu_rig_t *r, const char *name, long value);
void bu_set_ru(bu_rig_t *r, unsigned int ru, const char *signal, long value);
long bu_ru_number(bu_rig_t *r, unsigned int ru, const char *signal);
/* Switched on, and armed. */
void bu_arm(bu_rig_t *r, unsigned int ru);

/* The operator's immediate view: BU state, EC-Link status, the message that belongs to it, relays; a cause in every
 * state but Armed and Disarmed, and when EC-Link is not used. */
void bu_expect(bu_rig_t *r, const char *when, int state, int link);
/* The same, and after the next update also what the controller reads. */
void bu_expect_reported(bu_rig_t *r, const char *when, int state, int link);

/* After the next update: the armed remotes' ids in the order of their blocks ("" none), and the BU state; the rest of
 * an empty block is 0. */
void bu_expect_blocks(bu_rig_t *r, const char *when, const char *ids, uint8_t bu_state);

/* In OP, the controller at work, the first input data there. */
void bu_start(bu_rig_t *r, const bu_node_t *node);
/* In OP and in order; armed or not. @return the BU state that this is */
int bu_in_order(bu_rig_t *r, const bu_node_t *node, bool armed);
/* Remote 1 sends a command; returns when it has just appeared in the input data (its update). */
void bu_command_shown(bu_rig_t *r);

#endif
