/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The state machine of a drive (CiA 402, manual 1002906 §4.4), as a decision over its inputs and nothing else.
 *
 * Pure and table-driven: no instance, no time. The caller keeps the state, calls ::ds402_next whenever an input has
 * changed, and carries out ::ds402_action. At most one transition a call.
 */
#ifndef ECT_DEVICES_PMCTENDO_DS402_H
#define ECT_DEVICES_PMCTENDO_DS402_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef enum ds402_state {
    DS402_NOT_READY,
    DS402_SWITCH_ON_DISABLED,
    DS402_READY,
    DS402_SWITCHED_ON,
    DS402_OPERATION_ENABLED,
    DS402_QUICK_STOP,
    DS402_FAULT_REACTION,
    DS402_FAULT,
    DS402_STATES
} ds402_state_t;

/** Bits of the control word 6040h. */
enum {
    DS402_SWITCH_ON = 0x0001,
    DS402_VOLTAGE = 0x0002,   /**< 0: disable voltage */
    DS402_NO_QUICK = 0x0004,  /**< 0: quick stop */
    DS402_ENABLE = 0x0008,    /**< its rising edge enables */
    DS402_START = 0x0010,     /**< motion task, mode 1; reference run, mode 6 */
    DS402_AT_ONCE = 0x0020,   /**< motion task: replaces the one under way */
    DS402_RELATIVE = 0x0040,  /**< motion task: the target counts from the last one */
    DS402_RESET = 0x0080,     /**< its rising edge resets a fault */
    DS402_HALT = 0x0100,      /**< stops on the ramp, stays enabled */
    DS402_THROUGH = 0x0200,   /**< motion task: the one before it does not stop at its target */
    DS402_REFERENCE = 0x0800, /**< reference run, mode 8 */
    DS402_SAVE = 0x1000,      /**< its rising edge stores the parameters */
};

/** Bits of the status word 6041h. */
enum {
    DS402_STATUS_VOLTAGE = 0x0010,
    DS402_STATUS_NO_QUICK = 0x0020,
    DS402_STATUS_WARNING = 0x0080,
    DS402_STATUS_REMOTE = 0x0200,
    DS402_STATUS_TARGET = 0x0400,
    DS402_STATUS_LIMIT = 0x0800,
    DS402_STATUS_REFERENCING = 0x1000,     /**< the manual's bit 12 */
    DS402_STATUS_ATTAINED = 0x1000,        /**< CiA 402's: set-point taken, speed is 0, homing attained, follows */
    DS402_STATUS_REFERENCE_ERROR = 0x2000, /**< the manual's bit 13 */
    DS402_STATUS_MODE_ERROR = 0x2000,      /**< CiA 402's: following error, homing error */
    DS402_STATUS_TASK = 0x8000,
};

/** The command of a control word; the first one that fits counts. */
typedef enum ds402_command {
    DS402_DISABLE_VOLTAGE,
    DS402_QUICK_STOP_NOW,
    DS402_SHUTDOWN,
    DS402_DISABLE_OPERATION, /**< the same bits as "switch on" */
    DS402_ENABLE_OPERATION,
} ds402_command_t;

typedef struct ds402_inputs {
    uint16_t control; /**< control word */
    uint16_t rising;  /**< bits of it that were 0 before; an edge is handed over once */
    bool by_level;    /**< 0Fh enables by its level, as in CiA 402; else bit 3 must rise */
    bool live;        /**< the control word counts: OP. Else the command is "quick stop" */
    bool supplied;    /**< DC link, enable input, no STO: may be switched on */
    bool fault;       /**< present, and not reset */
    bool resettable;  /**< the fault may be reset */
    bool can_brake;   /**< power stage is on and the fault leaves it under control */
    bool standing;    /**< the shaft is at a standstill, or the stop does not wait for it */
    bool stays;       /**< after a quick stop the drive stays in that state (605Ah: 5 to 8) */
    bool coasts;      /**< Switched On has no torque (605Ch: 0) */
} ds402_inputs_t;

/** Power stage and set values in a state. */
typedef enum ds402_action {
    DS402_OFF,    /**< no torque */
    DS402_HOLD,   /**< enabled, at a standstill */
    DS402_FOLLOW, /**< set values count */
    DS402_RAMP,   /**< to a standstill, on the ordinary ramp; set values are locked */
    DS402_STOP,   /**< to a standstill, on the quick stop's ramp */
} ds402_action_t;

/** The command of a control word, by the priority of its bits: 1, then 2, then 0, then 3. */
ds402_command_t ds402_command(uint16_t control, bool live);

/**
 * Takes one transition, or none.
 * @param[out] reset  NULL, or set to whether the transition is the reset of a fault (15): the caller forgets the fault
 * @return the next state; `state` itself when no transition leads out of it
 */
ds402_state_t ds402_next(ds402_state_t state, const ds402_inputs_t *inputs, bool *reset);

/** The action of power stage and set values in a state. */
ds402_action_t ds402_action(ds402_state_t state, const ds402_inputs_t *inputs);

/** Bits 0 to 3, 5 and 6 of the status word. */
uint16_t ds402_status(ds402_state_t state, const ds402_inputs_t *inputs);

ECT_C_END

#endif
