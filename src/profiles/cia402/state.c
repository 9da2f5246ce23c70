/* SPDX-License-Identifier: MIT */
#include "profiles/cia402/state.h"

#include <stddef.h>

/* Sets of states and of commands. */
#define S(state)   (1u << ECT_402_##state)
#define C(command) (1u << ECT_402_##command)
#define ANY        0xFFu
#define ENABLED    (S(SWITCHED_ON) | S(OPERATION_ENABLED) | S(QUICK_STOP))
#define HEALTHY    (S(NOT_READY) | S(SWITCH_ON_DISABLED) | S(READY) | ENABLED)

enum {
    SUPPLIED = 0x01,
    FAULT = 0x02,
    RESET = 0x04, /* rising, and the fault may be reset */
    CAN_BRAKE = 0x08,
    STANDING = 0x10,
    STAYS = 0x20,
    ENABLE_EDGE = 0x40,
};

typedef struct row {
    uint8_t number; /* of the transition in CiA 402; 0: the supply's */
    uint8_t from, commands;
    uint8_t need, forbid;
    uint8_t to;
} row_t;

/* The first matching row is the transition. */
static const row_t rows[] = {
    {13, HEALTHY, ANY, FAULT, 0, ECT_402_FAULT_REACTION},
    {14, S(FAULT_REACTION), ANY, STANDING, 0, ECT_402_FAULT},
    {14, S(FAULT_REACTION), ANY, 0, CAN_BRAKE, ECT_402_FAULT},
    {15, S(FAULT), ANY, RESET, 0, ECT_402_SWITCH_ON_DISABLED},
    {1, S(NOT_READY), ANY, 0, 0, ECT_402_SWITCH_ON_DISABLED},
    {0, S(READY) | ENABLED, ANY, 0, SUPPLIED, ECT_402_SWITCH_ON_DISABLED},
    {7, S(READY), C(DISABLE_VOLTAGE) | C(QUICK_STOP_NOW), 0, 0, ECT_402_SWITCH_ON_DISABLED},
    {9, S(OPERATION_ENABLED), C(DISABLE_VOLTAGE), 0, 0, ECT_402_SWITCH_ON_DISABLED},
    {10, S(SWITCHED_ON), C(DISABLE_VOLTAGE) | C(QUICK_STOP_NOW), 0, 0, ECT_402_SWITCH_ON_DISABLED},
    {11, S(OPERATION_ENABLED), C(QUICK_STOP_NOW), 0, 0, ECT_402_QUICK_STOP},
    {12, S(QUICK_STOP), C(DISABLE_VOLTAGE), 0, 0, ECT_402_SWITCH_ON_DISABLED},
    {12, S(QUICK_STOP), ANY, STANDING, STAYS, ECT_402_SWITCH_ON_DISABLED},
    {16, S(QUICK_STOP), C(ENABLE_OPERATION), STANDING | STAYS, 0, ECT_402_OPERATION_ENABLED},
    {2, S(SWITCH_ON_DISABLED), C(SHUTDOWN), SUPPLIED, 0, ECT_402_READY},
    {6, S(SWITCHED_ON), C(SHUTDOWN), 0, 0, ECT_402_READY},
    {8, S(OPERATION_ENABLED), C(SHUTDOWN), STANDING, 0, ECT_402_READY},
    {3, S(READY), C(DISABLE_OPERATION) | C(ENABLE_OPERATION), 0, 0, ECT_402_SWITCHED_ON},
    {5, S(OPERATION_ENABLED), C(DISABLE_OPERATION), STANDING, 0, ECT_402_SWITCHED_ON},
    {4, S(SWITCHED_ON), C(ENABLE_OPERATION), ENABLE_EDGE, 0, ECT_402_OPERATION_ENABLED},
};

enum { RESET_OF_A_FAULT = 15 };

ect_402_command_t ect_402_command(uint16_t control, bool live)
{
    if (!live)
        return ECT_402_QUICK_STOP_NOW;
    if ((control & ECT_402_VOLTAGE) == 0)
        return ECT_402_DISABLE_VOLTAGE;
    if ((control & ECT_402_NO_QUICK) == 0)
        return ECT_402_QUICK_STOP_NOW;
    if ((control & ECT_402_SWITCH_ON) == 0)
        return ECT_402_SHUTDOWN;
    return (control & ECT_402_ENABLE) == 0 ? ECT_402_DISABLE_OPERATION : ECT_402_ENABLE_OPERATION;
}

static unsigned int flag(bool on, unsigned int mask)
{
    return on ? mask : 0;
}

static unsigned int flags_of(const ect_402_inputs_t *in)
{
    bool reset = in->live && in->resettable && (in->rising & ECT_402_RESET) != 0;
    bool enable = in->live && (in->by_level || (in->rising & ECT_402_ENABLE) != 0);
    return flag(in->supplied, SUPPLIED) | flag(in->fault, FAULT) | flag(reset, RESET) | flag(in->can_brake, CAN_BRAKE) |
           flag(in->standing, STANDING) | flag(in->stays && in->live, STAYS) | flag(enable, ENABLE_EDGE);
}

ect_402_state_t ect_402_next(ect_402_state_t state, const ect_402_inputs_t *in, bool *reset)
{
    unsigned int flags = flags_of(in);
    unsigned int command = 1u << ect_402_command(in->control, in->live);
    unsigned int from = 1u << state;
    const row_t *row = NULL;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0] && !row; i++) {
        const row_t *r = &rows[i];
        if ((r->from & from) != 0 && (r->commands & command) != 0 && (flags & r->need) == r->need &&
            (flags & r->forbid) == 0)
            row = r;
    }
    if (reset)
        *reset = row && row->number == RESET_OF_A_FAULT;
    return row ? (ect_402_state_t)row->to : state;
}

ect_402_action_t ect_402_action(ect_402_state_t state, const ect_402_inputs_t *in)
{
    bool follow =
        ect_402_command(in->control, in->live) == ECT_402_ENABLE_OPERATION && (in->control & ECT_402_HALT) == 0;
    switch (state) {
    case ECT_402_SWITCHED_ON:
        return in->coasts ? ECT_402_OFF : ECT_402_HOLD;
    case ECT_402_OPERATION_ENABLED:
        return follow ? ECT_402_FOLLOW : ECT_402_RAMP;
    case ECT_402_QUICK_STOP:
        return ECT_402_STOP;
    case ECT_402_FAULT_REACTION:
        return in->can_brake ? ECT_402_STOP : ECT_402_OFF;
    default:
        return ECT_402_OFF;
    }
}

uint16_t ect_402_status(ect_402_state_t state, const ect_402_inputs_t *in)
{
    static const uint8_t bits[ECT_402_STATES] = {
        [ECT_402_SWITCH_ON_DISABLED] = 0x40,
        [ECT_402_READY] = 0x21,
        [ECT_402_SWITCHED_ON] = 0x23,
        [ECT_402_OPERATION_ENABLED] = 0x27,
        [ECT_402_QUICK_STOP] = 0x07,
        [ECT_402_FAULT_REACTION] = 0x0F,
        [ECT_402_FAULT] = 0x08,
    };
    static const unsigned int shows_bit2 = S(SWITCH_ON_DISABLED) | S(FAULT) | S(FAULT_REACTION);
    bool quick = in->live && (shows_bit2 & 1u << state) != 0 && (in->control & ECT_402_NO_QUICK) != 0;
    return (uint16_t)(bits[state] | (quick ? ECT_402_STATUS_NO_QUICK : 0));
}
