/* SPDX-License-Identifier: MIT */
#include "slave/al.h"

#include "seams/device.h"
#include "wire/registers.h"

static bool known(uint8_t state)
{
    enum {
        STATES =
            1 << ECT_STATE_INIT | 1 << ECT_STATE_PREOP | 1 << ECT_STATE_BOOT | 1 << ECT_STATE_SAFEOP | 1 << ECT_STATE_OP
    };
    return ((STATES >> state) & 1) != 0;
}

/* One step up, or to BOOT and back, both only from and to INIT; down to any state except BOOT. */
static bool legal(uint8_t from, uint8_t to)
{
    if (to == ECT_STATE_BOOT)
        return from == ECT_STATE_INIT;
    if (from == ECT_STATE_BOOT)
        return to == ECT_STATE_INIT;
    if (to < from)
        return true;
    return to == from * 2;
}

/* The AL status code that refuses a request for another state, or 0. */
static uint16_t refusal(uint8_t state, uint8_t target, bool has_boot)
{
    if (!known(target))
        return ECT_AL_UNKNOWN_STATE;
    if (target == ECT_STATE_BOOT && state == ECT_STATE_INIT && !has_boot)
        return ECT_AL_NO_BOOT;
    return target == state || legal(state, target) ? ECT_AL_NO_ERROR : ECT_AL_INVALID_CHANGE;
}

ect_al_decision_t ect_al_decide(uint8_t state, bool error, uint16_t request, bool has_boot)
{
    uint8_t target = request & ECT_AL_STATE_MASK;
    bool acknowledge = (request & ECT_AL_ACKNOWLEDGE) != 0;
    if (error && !acknowledge && target != ECT_STATE_INIT)
        return (ect_al_decision_t){.action = ECT_AL_IGNORE, .target = state};
    ect_al_decision_t d = {.action = ECT_AL_REFUSE, .target = state, .clear_error = error};
    d.code = refusal(state, target, has_boot);
    if (d.code != ECT_AL_NO_ERROR)
        return d;
    d.action = target == state ? ECT_AL_STAY : target > state ? ECT_AL_UP : ECT_AL_DOWN;
    d.target = target;
    return d;
}
