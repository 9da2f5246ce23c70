/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EtherCAT state machine as a pure decision (ETG.1000.6 §6.4.1): what a request in AL control means in a state.
 */
#ifndef ECT_SLAVE_AL_H
#define ECT_SLAVE_AL_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef enum ect_al_action {
    ECT_AL_IGNORE, /**< error flag set and not acknowledged: nothing happens */
    ECT_AL_REFUSE, /**< stay, set the error flag with `code` */
    ECT_AL_STAY,   /**< the present state was asked for: confirm it */
    ECT_AL_UP,     /**< check, then go up to `target` */
    ECT_AL_DOWN,   /**< go down to `target` */
} ect_al_action_t;

typedef struct ect_al_decision {
    ect_al_action_t action;
    uint8_t target;   /**< the state after this, if the checks allow it */
    uint16_t code;    /**< with ECT_AL_REFUSE */
    bool clear_error; /**< the error flag and the code go away before anything else */
} ect_al_decision_t;

/**
 * Decides. Pure: no side effects, defined for all inputs.
 * @param state     1, 2, 3, 4 or 8
 * @param error     the error flag of AL status
 * @param request   AL control, all 16 bits; only bits 0..4 matter here
 * @param has_boot  the device has a BOOT state
 */
ect_al_decision_t ect_al_decide(uint8_t state, bool error, uint16_t request, bool has_boot);

ECT_C_END

#endif
