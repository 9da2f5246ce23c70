/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Steps of the cases of CiA 402 drives: objects of an axis by process data or SDO, the state machine, a cruise.
 *
 * An axis is energised and turned in cases of CF_MOVE only. Each cycle of such a case compares 6064h with its first
 * value: beyond the distance of --move the axis gets a quick stop, and the case fails.
 */
#ifndef ECTWIN_CONFORM_DRIVE_STEPS_H
#define ECTWIN_CONFORM_DRIVE_STEPS_H

#include "steps/case.h"

enum { DRIVE_AXES = 8, DRIVE_AXIS = 0x800, DRIVE_ENTRIES = 128, DRIVE_HISTORY = 10 };

/** Objects of an axis, and bits of its control word and status word. */
enum {
    DRIVE_CONTROL = 0x6040,
    DRIVE_STATUS = 0x6041,
    DRIVE_QUICK_OPTION = 0x605A,
    DRIVE_SHUTDOWN_OPTION = 0x605B,
    DRIVE_DISABLE_OPTION = 0x605C,
    DRIVE_HALT_OPTION = 0x605D,
    DRIVE_FAULT_OPTION = 0x605E,
    DRIVE_ABORT_OPTION = 0x6007,
    DRIVE_ERROR_CODE = 0x603F,
    DRIVE_MODE = 0x6060,
    DRIVE_MODE_DISPLAY = 0x6061,
    DRIVE_ACTUAL = 0x6064,
    DRIVE_TARGET_TORQUE = 0x6071,
    DRIVE_TARGET = 0x607A,
    DRIVE_HOME_OFFSET = 0x607C,
    DRIVE_TASK_SPEED = 0x6081,
    DRIVE_ACCELERATION = 0x6083,
    DRIVE_DECELERATION = 0x6084,
    DRIVE_QUICK_DECELERATION = 0x6085,
    DRIVE_TORQUE_SLOPE = 0x6087,
    DRIVE_HOMING_METHOD = 0x6098,
    DRIVE_RECORD = 0x60C1,
    DRIVE_TARGET_SPEED = 0x60FF,
    DRIVE_MODES = 0x6502,
};
enum { DRIVE_SHUTDOWN = 0x06, DRIVE_SWITCH_ON = 0x07, DRIVE_ENABLE = 0x0F, DRIVE_QUICK_STOP = 0x02 };
enum { DRIVE_START = 0x10, DRIVE_RESET = 0x80, DRIVE_HALT = 0x100 };
enum { DRIVE_VOLTAGE = 0x0010, DRIVE_REACHED = 0x0400, DRIVE_ATTAINED = 0x1000, DRIVE_ERROR = 0x2000 };
enum { DRIVE_PP = 1, DRIVE_PV = 3, DRIVE_TQ = 4, DRIVE_HM = 6, DRIVE_IP = 7 };
enum { DRIVE_CSP = 8, DRIVE_CSV = 9, DRIVE_CST = 10 };
enum { DRIVE_WAIT_MS = 5000, DRIVE_SETTLE_MS = 50 };

/** States by the bits of the status word that show them. DRIVE_NO_STATE: bits that no state has. */
typedef enum drive_state {
    DRIVE_NOT_READY = 0x00,
    DRIVE_DISABLED = 0x40,
    DRIVE_READY = 0x21,
    DRIVE_SWITCHED_ON = 0x23,
    DRIVE_ENABLED = 0x27,
    DRIVE_STOPPING = 0x07,
    DRIVE_REACTION = 0x0F,
    DRIVE_FAULT = 0x08,
    DRIVE_NO_STATE = 0xFF,
} drive_state_t;

/** An entry of the process data: `at` is its first bit in the image of its direction. */
typedef struct drive_entry {
    uint16_t index;
    uint8_t sub, bits;
    uint32_t at;
} drive_entry_t;

typedef struct drive_map {
    drive_entry_t entries[DRIVE_ENTRIES];
    unsigned int count;
} drive_map_t;

typedef struct drive {
    cf_t *c;
    unsigned int axis; /**< the axis under test, 0..DRIVE_AXES - 1 */
    unsigned int axes; /**< bit n: axis n */
    drive_map_t outputs, inputs;
    uint8_t out[CF_MAX_DATA], in[CF_MAX_DATA];
    bool in_op;                     /**< process data are exchanged while steps wait */
    bool guarded;                   /**< 6064h is compared with `origin` */
    bool inputs_only;               /**< no outputs are sent: the watchdog expires */
    int64_t origin;                 /**< 6064h of the axis under test at the start */
    int64_t history[DRIVE_HISTORY]; /**< 6064h of the last cycles */
    uint64_t history_ns[DRIVE_HISTORY];
    unsigned int cycles; /**< since the start of the history */
    unsigned int found;  /**< a count of the case over all axes; 0 at the start */
} drive_t;

/**
 * Calls `run` for each axis, in OP with control word 0, in Switch on disabled; a fault is reset before. The mapped
 * outputs have the values of their objects, set values are 0 or the present position. At the end of `run` the axis is
 * taken to Switch on disabled.
 * @return the drive, as drive_open
 */
const drive_t *drive_each_axis(cf_t *c, void (*run)(drive_t *d));
/** Takes the slave to PREOP, and reads its axes and process data. @return the drive, valid until the next call */
drive_t *drive_open(cf_t *c);

/** @return whether the axis has the object, as an entry of the process data or of the dictionary */
bool drive_has(drive_t *d, uint16_t index, uint8_t sub);
/** @return whether the object is in the process data to the master */
bool drive_maps_input(const drive_t *d, uint16_t index);
/** @return whether the object is in the process data from the master */
bool drive_maps_output(const drive_t *d, uint16_t index, uint8_t sub);
/** @return the value of an object, sign-extended from its width; from the last inputs, or by SDO */
int64_t drive_get(drive_t *d, uint16_t index, uint8_t sub);
/**
 * Sets an object of the axis: in the outputs, or by SDO. A value that a master sets for good is restored by the runner.
 * @return 0, or the abort code
 */
uint32_t drive_set(drive_t *d, uint16_t index, uint8_t sub, int64_t value);

/** @return 6041h; 16 bits */
uint16_t drive_status(drive_t *d);
drive_state_t drive_state(uint16_t status);
const char *drive_state_name(drive_state_t state);
/** Exchanges process data once, a millisecond later. */
void drive_cycle(drive_t *d);
void drive_cycles(drive_t *d, unsigned int count);
/** Sets the control word and exchanges process data once. */
void drive_command(drive_t *d, uint16_t control);
/** Cycles until the bits of `mask` of the status word are `wanted`. @return false after `ms` */
bool drive_wait(drive_t *d, uint16_t mask, uint16_t wanted, uint32_t ms);
/** Cycles until the state is reached. A failure names the axis, the state, and `cause`. */
void drive_expect_state(drive_t *d, drive_state_t state, uint32_t ms, const char *cause);
/** Sends a control word; the state must still be `state` after DRIVE_SETTLE_MS. */
void drive_expect_stays(drive_t *d, uint16_t control, drive_state_t state);
/** drive_command and drive_expect_state within DRIVE_WAIT_MS. */
void drive_go(drive_t *d, uint16_t control, drive_state_t state);

/** @return whether 6502h has the mode; without 6502h, whether it is csp with a mapped 607Ah */
bool drive_supports(drive_t *d, int8_t mode);
/** Sets 6060h and waits for 6061h. A mode that is not reached ends the case. */
void drive_choose(drive_t *d, int8_t mode);
/** Sets the set position of csp in the outputs: 607Ah, and 60C1h:1 of drives that take it from there. */
void drive_set_position(drive_t *d, int64_t position);
/** Sets the set values to the present position, no speed and no torque. */
void drive_hold(drive_t *d);
/** 06h, 07h, 0Fh with the present position as set value, step by step. */
void drive_enable(drive_t *d);

#endif
