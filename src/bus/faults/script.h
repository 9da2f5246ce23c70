/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One line of a scenario: milestones, and an action that begins when they are reached. The order of the parts is free.
 *
 *     drop 5%                               from the beginning
 *     at 2.5s hang slave 2                  a time since the beginning
 *     at frame 1000 off                     after 1000 frames
 *     at slave 1 OP counter -1 every 10     when slave 1 is in OP; "at OP": the slave of the action, or 1
 *     at OP after 10 cycles init slave 1    successive milestones: 10 frames with process data later
 *     at the 3rd upload of 0x1018 off       at the third request for an SDO transfer of the object
 *     drop 50% while in PREOP               whenever the slave is in that state
 *     hang slave 2 until 5s                 ends at a milestone; "for 100ms": this long after its beginning
 *     set ru1.on=0 until OP again           ends when the slave has left OP and reached OP again
 *     at 2.5s set 2:ru1.on=0 scene=5        signals, of slave 2
 *     hang slave gripper, set gripper.data1=5  twins by name
 *     expect ecat.state=4 within 200ms      a condition on a signal: at once, within a time, for a time
 *
 * This file uses no clock. Context: any.
 */
#ifndef ECT_BUS_FAULTS_SCRIPT_H
#define ECT_BUS_FAULTS_SCRIPT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/fault.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_STEP_MILESTONES = 4, /**< most milestones before the action */
    ECT_STEP_ACTION = 128,   /**< room for an action as text */
    ECT_STEP_LINE = 256,     /**< room for a line */
    ECT_STEP_MESSAGE = ECT_FAULT_MESSAGE,
};

typedef enum ect_milestone_kind {
    ECT_MILESTONE_NONE,
    ECT_MILESTONE_TIME,   /**< `value` ns since the beginning */
    ECT_MILESTONE_DELAY,  /**< `value` ns since the previous milestone */
    ECT_MILESTONE_FRAME,  /**< `value` frames have arrived */
    ECT_MILESTONE_CYCLES, /**< `value` frames with process data since the previous milestone */
    ECT_MILESTONE_STATE,  /**< the slave is in state `value` */
    ECT_MILESTONE_AGAIN,  /**< ... after another one */
    ECT_MILESTONE_LEFT,   /**< the slave is not in state `value` */
    ECT_MILESTONE_SDO,    /**< `value` SDO transfers of `object` have been requested since the previous milestone */
} ect_milestone_kind_t;

typedef struct ect_milestone {
    ect_milestone_kind_t kind;
    uint64_t value;
    uint16_t slave;            /**< from 1; 0: any (of SDO) */
    ect_fault_object_t object; /**< of SDO */
} ect_milestone_t;

typedef enum ect_action { ECT_ACTION_FAULT, ECT_ACTION_SET, ECT_ACTION_EXPECT } ect_action_t;

typedef struct ect_step {
    ect_milestone_t when[ECT_STEP_MILESTONES];
    uint8_t when_count;
    bool repeats;          /**< the last milestone is that of "while": repeated */
    ect_milestone_t until; /**< end of the action, or the last time of an expectation; NONE: none */
    bool holds;            /**< of EXPECT: the condition must be true throughout, else at least once */
    ect_action_t action;
    uint16_t slave; /**< of SET and EXPECT, from 1 */
    ect_fault_t fault;
    char text[ECT_STEP_ACTION]; /**< of SET "NAME=VALUE ...", of EXPECT "NAME=VALUE"; of FAULT empty */
} ect_step_t;

/**
 * Reads a line without comment.
 * @param names         of twins, usable in place of their numbers: "slave gripper", "set gripper.data1=1"; NULL: none
 * @param[out] step     set on success, else undefined
 * @param[out] message  on failure the reason, one line for the user; ECT_STEP_MESSAGE bytes
 */
bool ect_step_read(const char *line, const ect_names_t *names, ect_step_t *step, char *message);

/** @return the highest slave named by the step; 0: none. */
uint16_t ect_step_highest_slave(const ect_step_t *step);

/** The parts of a condition "NAME=VALUE", with = != < or >. */
typedef struct ect_condition {
    char name[ECT_STEP_ACTION];
    char relation;     /**< '=', '!', '<', '>' */
    const char *value; /**< in the text of the condition */
} ect_condition_t;

/** @return whether the text is a condition */
bool ect_condition_read(const char *text, ect_condition_t *condition);

/** @return whether a value fulfils the condition: compared as numbers if both are numbers, else as texts */
bool ect_condition_met(const ect_condition_t *condition, const char *value);

ECT_C_END

#endif
