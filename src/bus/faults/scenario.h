/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Faults (bus/chain/fault.h) at work: those that are set now, and a script of those to come. Chance comes from a seed
 * alone, so the same seed, script and frames make the same run.
 *
 * A script has a fault a line; `#` begins a comment. What stands in front says when:
 *
 *     drop 5%                              from the beginning
 *     at 2.5s hang slave 2                 so long after the beginning
 *     at frame 1000 off                    when so many frames have come
 *     at slave 1 OP counter -1 every 10    when that slave is in that state: INIT, PREOP, BOOT, SAFEOP or OP
 *
 * No clock in here. Context: the thread of the runner. Cost of a frame: a look at each fault that is set and at the
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

/** Faults of frames that are set at a time; steps of a script. */
enum { ECT_SCENARIO_FAULTS = 8, ECT_SCENARIO_STEPS = 256 };

/** One line of a script. Private. */
typedef struct ect_scenario_step {
    enum { ECT_STEP_AT_TIME, ECT_STEP_AT_FRAME, ECT_STEP_AT_STATE } when;
    uint64_t value; /* ns, frames, state */
    uint16_t slave;
    bool done;
    ect_fault_t fault;
} ect_scenario_step_t;

/** All zero but the seed: nothing is set. The members but `seed`, `refused`, `ctx` and `wires` are private. */
typedef struct ect_scenario {
    uint32_t seed;
    /** A fault of the script could not be set when its time had come; `why` says so in a line. NULL: nobody is told. */
    void (*refused)(void *ctx, const char *fault, const char *why);
    void *ctx;         /**< handed to it */
    uint64_t start_ns; /* 0: not begun */
    uint64_t frames;
    struct {
        ect_fault_t fault;
        uint64_t frames; /* that it has seen */
    } set[ECT_SCENARIO_FAULTS];
    size_t set_count;
    ect_scenario_step_t steps[ECT_SCENARIO_STEPS];
    size_t step_count;
    size_t steps_left;
    ect_wires_t wires; /**< frames that are kept on one: the loop lets them go on */
} ect_scenario_t;

/** What becomes of a frame. What changes the request is done already; what happens on a wire will be on its way. */
typedef struct ect_fate {
    bool lose_request, lose_answer;
    bool twice;        /**< its answer leaves twice */
    bool behind_next;  /**< its answer leaves behind the next one */
    uint32_t delay_us; /**< its answer is late */
    int32_t counter;   /**< is added to the working counter of its first datagram */
} ect_fate_t;

/**
 * Takes a line of a script.
 * @param[out] message  on failure what is wrong, one line for the user; ECT_FAULT_MESSAGE bytes
 * @return whether it was taken; an empty line and a comment are
 */
bool ect_scenario_read(ect_scenario_t *s, const char *line, char *message);

/**
 * Sets a fault now, or does it.
 * @param[out] message  as above: there is no such slave, or too many faults are set
 */
bool ect_scenario_set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message);

/**
 * A frame has come at ECT_END_IN or ECT_END_OUT: steps that are due are done, and the lot is drawn.
 * @param[in,out] length  of the frame; never becomes more
 */
ect_fate_t ect_scenario_frame(ect_scenario_t *s, ect_chain_t *chain, uint8_t *frame, size_t *length, uint64_t now_ns);

/** Time passes. @return when a step, or a frame on a wire (s->wires), is due without another frame; ECT_NEVER */
uint64_t ect_scenario_tick(ect_scenario_t *s, ect_chain_t *chain, uint64_t now_ns);

/**
 * The frame has been through the chain: what its fate says of an answer is done to it, but for its ways.
 * @param[in,out] length  less when a wire has cut it
 * @return what the wires have done to it
 */
ect_wires_result_t ect_scenario_answer(const ect_scenario_t *s, const ect_fate_t *fate, uint8_t *frame, size_t *length);

/** The highest number of a slave in the script; 0: none is named. */
uint16_t ect_scenario_highest_slave(const ect_scenario_t *s);

/** Whether nothing is set, nothing is to come and no frame is kept: frames need not be shown to it. */
static inline bool ect_scenario_rests(const ect_scenario_t *scenario)
{
    return scenario->set_count == 0 && scenario->steps_left == 0 && !scenario->wires.kept;
}

/** The i-th fault of frames that is set, from 0, as text. @return whether there is one */
bool ect_scenario_show(const ect_scenario_t *s, size_t i, char *text);

ECT_C_END

#endif
