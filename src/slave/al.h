/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EtherCAT state machine as a pure decision (ETG.1000.6 §6.4.1): the consequence of a request in AL control.
 */
#ifndef ECT_SLAVE_AL_H
#define ECT_SLAVE_AL_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef enum ect_al_action {
    ECT_AL_IGNORE, /**< error flag set and not acknowledged: no effect */
    ECT_AL_REFUSE, /**< stay, set the error flag with `code` */
    ECT_AL_STAY,   /**< the request names the present state: confirm it */
    ECT_AL_UP,     /**< check, then enter the higher state `target` */
    ECT_AL_DOWN,   /**< enter the lower state `target` */
} ect_al_action_t;

typedef struct ect_al_decision {
    ect_al_action_t action;
    uint8_t target;   /**< the resulting state, if the checks allow it */
    uint16_t code;    /**< with ECT_AL_REFUSE */
    bool clear_error; /**< first clear the error flag and the AL status code */
} ect_al_decision_t;

/**
 * Decides about a request. Pure: no side effects, defined for all inputs.
 * @param state     1, 2, 3, 4 or 8
 * @param error     the error flag of AL status
 * @param request   AL control, all 16 bits; only bits 0..4 are used
 * @param has_boot  the device has a BOOT state
 * @return the decision
 */
ect_al_decision_t ect_al_decide(uint8_t state, bool error, uint16_t request, bool has_boot);

ECT_C_END

#endif
