/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Faults (bus/chain/fault.h) at work: the faults that are set, and a script of faults to come. The random generator
 * depends on its seed alone, so the same seed, script and frames make the same run.
 *
 * A script has a fault a line; `#` begins a comment. A condition may precede the fault:
 *
 *     drop 5%                              from the beginning
 *     at 2.5s hang slave 2                 2.5 s after the beginning
 *     at frame 1000 off                    when 1000 frames have come
 *     at slave 1 OP counter -1 every 10    when that slave is in that state: INIT, PREOP, BOOT, SAFEOP or OP
 *
 * No clock in here. Context: the thread of the runner. Cost of a frame: a check of each fault that is set and of the
 * next steps; none without any.
 */
#ifndef ECT_BUS_FAULTS_SCENARIO_H
#define ECT_BUS_FAULTS_SCENARIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/chain/fault.h"
#include "bus/faults/wires.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Most faults of frames that are set at a time; most steps of a script. */
enum { ECT_SCENARIO_FAULTS = 8, ECT_SCENARIO_STEPS = 256 };

/** One line of a script. Private. */
typedef struct ect_scenario_step {
    enum { ECT_STEP_AT_TIME, ECT_STEP_AT_FRAME, ECT_STEP_AT_STATE } when;
    uint64_t value; /* ns, frames, state */
    uint16_t slave;
    bool done;
    ect_fault_t fault;
} ect_scenario_step_t;

/** All zero but the seed: no faults. Members but `seed`, `refused`, `ctx`, `done`, `observer` and `wires` are
 * private. */
typedef struct ect_scenario {
    uint32_t seed;
    /** Called when a fault of the script cannot be set at its time; `why` is one line. NULL: not called. */
    void (*refused)(void *ctx, const char *fault, const char *why);
    void *ctx;                                       /**< argument of `refused` */
    void (*done)(void *observer, const char *fault); /**< called with each fault that is set or carried out; NULL */
    void *observer;                                  /**< argument of `done` */
    uint64_t start_ns;                               /* 0: not begun */
    uint64_t frames;
    struct {
        ect_fault_t fault;
        uint64_t frames; /* seen by the fault */
    } set[ECT_SCENARIO_FAULTS];
    size_t set_count;
    ect_scenario_step_t steps[ECT_SCENARIO_STEPS];
    size_t step_count;
    size_t steps_left;
    ect_wires_t wires; /**< frames kept on a wire: the loop releases them */
} ect_scenario_t;

/** The effect of faults on a frame's reply. Changes of the request are already made; those of a wire follow on it. */
typedef struct ect_frame_effects {
    bool lose_request; /**< the frame is lost before the chain */
    bool lose_reply;   /**< the reply is lost */
    bool twice;        /**< the reply leaves twice */
    bool after_next;   /**< the reply leaves after the next one */
    uint32_t delay_us; /**< delay of the reply */
    int32_t counter;   /**< added to the working counter of the first datagram */
} ect_frame_effects_t;

/**
 * Adds a line to the script.
 * @param[out] message  on failure the reason, one line for the user; ECT_FAULT_MESSAGE bytes
 * @return true: added, or an empty line or comment
 */
bool ect_scenario_read(ect_scenario_t *s, const char *line, char *message);

/**
 * Sets a fault of frames, or carries out a fault of a slave, at once.
 * @param[out] message  on failure the reason: no such slave, or too many faults; ECT_FAULT_MESSAGE bytes
 * @return whether it was done
 */
bool ect_scenario_set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message);

/**
 * Handles a frame before the chain: takes due steps, selects faults at random, and changes the request.
 * @param[in,out] length  of the frame; a fault may reduce it
 */
ect_frame_effects_t ect_scenario_frame(ect_scenario_t *s, ect_chain_t *chain, uint8_t *frame, size_t *length,
                                       uint64_t now_ns);

/** Takes due steps. @return the next time at which a step, or a frame on a wire (s->wires), is due; ECT_NEVER */
uint64_t ect_scenario_tick(ect_scenario_t *s, ect_chain_t *chain, uint64_t now_ns);

/**
 * Changes the reply after the chain as its fate demands. Loss, order and delay are the caller's task.
 * @param[in,out] length  less when a wire has cut the frame
 * @return the effect of the wires on the frame
 */
ect_wires_result_t ect_scenario_reply(const ect_scenario_t *s, const ect_frame_effects_t *effects, uint8_t *frame,
                                      size_t *length);

/** The highest slave number in the script; 0: none. */
uint16_t ect_scenario_highest_slave(const ect_scenario_t *s);

/** @return true: no faults, no steps and no kept frames, so ::ect_scenario_frame may be left out */
static inline bool ect_scenario_rests(const ect_scenario_t *scenario)
{
    return scenario->set_count == 0 && scenario->steps_left == 0 && !scenario->wires.kept;
}

/** Writes the i-th fault of frames that is set, from 0, as text (ECT_FAULT_TEXT bytes). @return false: no such fault */
bool ect_scenario_show(const ect_scenario_t *s, size_t i, char *text);

ECT_C_END

#endif
