/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The state machine of a drive (CiA 402-2), as a pure decision over its inputs.
 *
 * Pure and table-driven: no instance, no time. The caller stores the state, calls ::ect_402_next whenever an input has
 * changed, and executes ::ect_402_action. At most one transition in each call.
 */
#ifndef ECT_PROFILES_CIA402_STATE_H
#define ECT_PROFILES_CIA402_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef enum ect_402_state {
    ECT_402_NOT_READY,
    ECT_402_SWITCH_ON_DISABLED,
    ECT_402_READY,
    ECT_402_SWITCHED_ON,
    ECT_402_OPERATION_ENABLED,
    ECT_402_QUICK_STOP,
    ECT_402_FAULT_REACTION,
    ECT_402_FAULT,
    ECT_402_STATES
} ect_402_state_t;

/** Bits of the control word 6040h. */
enum {
    ECT_402_SWITCH_ON = 0x0001,
    ECT_402_VOLTAGE = 0x0002,  /**< 0: disable voltage */
    ECT_402_NO_QUICK = 0x0004, /**< 0: quick stop */
    ECT_402_ENABLE = 0x0008,   /**< its rising edge enables */
    ECT_402_START = 0x0010,    /**< motion task, mode 1; reference run, mode 6 */
    ECT_402_AT_ONCE = 0x0020,  /**< motion task: replaces the present one */
    ECT_402_RELATIVE = 0x0040, /**< motion task: the target is relative to the last one */
    ECT_402_RESET = 0x0080,    /**< its rising edge resets a fault */
    ECT_402_HALT = 0x0100,     /**< stops on the ramp, stays enabled */
    ECT_402_THROUGH = 0x0200,  /**< motion task: the previous one does not stop at its target */
};

/** Bits of the status word 6041h. */
enum {
    ECT_402_STATUS_VOLTAGE = 0x0010,
    ECT_402_STATUS_NO_QUICK = 0x0020,
    ECT_402_STATUS_WARNING = 0x0080,
    ECT_402_STATUS_REMOTE = 0x0200,
    ECT_402_STATUS_TARGET = 0x0400,
    ECT_402_STATUS_LIMIT = 0x0800,
    ECT_402_STATUS_ATTAINED = 0x1000,   /**< by mode: set-point taken, speed is 0, homing attained, follows */
    ECT_402_STATUS_MODE_ERROR = 0x2000, /**< by mode: following error, homing error */
};

/** The command of a control word; the first matching one applies. */
typedef enum ect_402_command {
    ECT_402_DISABLE_VOLTAGE,
    ECT_402_QUICK_STOP_NOW,
    ECT_402_SHUTDOWN,
    ECT_402_DISABLE_OPERATION, /**< the same bits as "switch on" */
    ECT_402_ENABLE_OPERATION,
} ect_402_command_t;

typedef struct ect_402_inputs {
    uint16_t control; /**< control word */
    uint16_t rising;  /**< bits that were 0 before; each edge is passed once */
    bool by_level;    /**< 0Fh enables by its level, as in CiA 402; else bit 3 must rise */
    bool live;        /**< the control word applies: OP. Else the command is "quick stop" */
    bool supplied;    /**< DC link, enable input, no STO: may be switched on */
    bool fault;       /**< present, and not reset */
    bool resettable;  /**< the fault may be reset */
    bool can_brake;   /**< power stage is on, and can be controlled in spite of the fault */
    bool standing;    /**< the shaft is at a standstill, or the stop does not wait for it */
    bool stays;       /**< after a quick stop the drive stays in that state (605Ah: 5 to 8) */
    bool coasts;      /**< Switched On has no torque (605Ch: 0) */
} ect_402_inputs_t;

/** Power stage and set values in a state. */
typedef enum ect_402_action {
    ECT_402_OFF,    /**< no torque */
    ECT_402_HOLD,   /**< enabled, at a standstill */
    ECT_402_FOLLOW, /**< set values apply */
    ECT_402_RAMP,   /**< to a standstill, on the ordinary ramp; set values are locked */
    ECT_402_STOP,   /**< to a standstill, on the quick stop's ramp */
} ect_402_action_t;

/** The command of a control word, by the priority of its bits: 1, then 2, then 0, then 3. */
ect_402_command_t ect_402_command(uint16_t control, bool live);

/**
 * Takes one transition, or none.
 * @param[out] reset  NULL, or set to whether the transition is the reset of a fault (15): the caller clears the fault
 * @return the next state; `state` without a transition
 */
ect_402_state_t ect_402_next(ect_402_state_t state, const ect_402_inputs_t *inputs, bool *reset);

/** The action of power stage and set values in a state. */
ect_402_action_t ect_402_action(ect_402_state_t state, const ect_402_inputs_t *inputs);

/** Bits 0 to 3, 5 and 6 of the status word. */
uint16_t ect_402_status(ect_402_state_t state, const ect_402_inputs_t *inputs);

ECT_C_END

#endif
