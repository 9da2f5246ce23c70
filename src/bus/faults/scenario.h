/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A scenario: the faults that are set (bus/chain/fault.h), and a script of future steps (bus/faults/script.h): faults,
 * signals to set, expectations. The random generator depends only on its seed, so the same seed, script and frames
 * result in the same run.
 *
 * A script has one step in each line; `#` begins a comment, `name TEXT` names the scenario.
 *
 * This file uses no clock. Context: the thread of the runner. Cost of a frame: a check of each fault that is set and of
 * the next steps; none without faults and steps.
 */
#ifndef ECT_BUS_FAULTS_SCENARIO_H
#define ECT_BUS_FAULTS_SCENARIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/chain/fault.h"
#include "bus/faults/progress.h"
#include "bus/faults/script.h"
#include "bus/faults/table.h"
#include "bus/faults/waves.h"
#include "bus/faults/wires.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Limits: faults of frames that are set at a time, steps of a script, and the room for the scenario's name. */
enum { ECT_SCENARIO_FAULTS = 8, ECT_SCENARIO_STEPS = 256, ECT_SCENARIO_NAME = 80 };

/** One line of a script, and its progress. Private, except `text`, `line`, `met` and `why`. */
typedef struct ect_scenario_step {
    ect_step_t plan;
    char text[ECT_STEP_LINE]; /* as written, without comment */
    unsigned int line;        /* in its file, from 1; 0: none */
    enum { ECT_STEP_WAITS, ECT_STEP_ACTS, ECT_STEP_OVER } progress;
    uint8_t reached;                   /* milestones */
    bool current;                      /* the present milestone, or the end, is prepared */
    bool left;                         /* of AGAIN: the slave has left the state */
    uint64_t base_ns;                  /* time of the previous milestone ... */
    uint64_t base_cycles;              /* ... and frames with process data until then */
    char before[ECT_SIGNAL_TEXT_ROOM]; /* value to restore at the end of SET */
    bool met;
    char why[ECT_STEP_MESSAGE]; /* reason of a failed expectation */
} ect_scenario_step_t;

/** The expectations of a script; all are met if `met` equals `all`. */
typedef struct ect_verdict {
    unsigned int all, met, failed;
} ect_verdict_t;

/**
 * Zeroed, except the seed and the names: no faults. Members from `start_ns` on are private, except `verdict`, `name`,
 * `tables`, `waves` and `wires`.
 */
typedef struct ect_scenario {
    uint32_t seed;
    const ect_names_t *names; /**< of twins, for the lines of the script; outlive the scenario. NULL: none */
    /** Called when a step of the script cannot be executed at its time; `why` is one line. NULL: not called. */
    void (*refused)(void *ctx, const char *fault, const char *why);
    /** Called when an expectation is met or has failed. NULL: not called. */
    void (*judged)(void *ctx, const ect_scenario_step_t *step);
    void *ctx;                                      /**< argument of both */
    void (*done)(void *observer, const char *what); /**< called with each fault, signal and verdict; NULL: not called */
    void *observer;                                 /**< argument of `done` */
    unsigned int line;                              /**< number of the line of ::ect_scenario_read; 0: none */
    char name[ECT_SCENARIO_NAME];
    ect_verdict_t verdict;
    ect_progress_t progress; /**< for ::ect_progress_plant, from the first ::ect_scenario_tick on */
    uint64_t start_ns;       /* 0: not begun */
    uint64_t frames, cycles;
    bool acted; /* a step has changed the chain or is over: the devices must run, and clients receive the signals */
    struct {
        ect_fault_t fault;
        uint64_t frames; /* that the fault has checked */
    } set[ECT_SCENARIO_FAULTS];
    size_t set_count;
    ect_scenario_step_t steps[ECT_SCENARIO_STEPS];
    size_t step_count;
    size_t steps_left;
    bool tables_over;    /* end of all tables */
    ect_table_t *tables; /**< signals played in time; the caller's. NULL: none */
    ect_waves_t waves;   /**< signals that follow a function of the time */
    ect_wires_t wires;   /**< frames kept on a wire: the loop releases them */
} ect_scenario_t;

/** The effect of faults on a frame's reply. The request has already been changed; faults of a wire act later. */
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
 * Checks that the chain has the slaves and signals of the script, and that these take the values to be set.
 * @param[out] message  on failure the reason, one line for the user; ECT_STEP_MESSAGE bytes
 * @return the step that is wrong; NULL: none
 */
const ect_scenario_step_t *ect_scenario_check(const ect_scenario_t *s, const ect_chain_t *chain, char *message);

/**
 * Sets a lasting fault, or executes a fault of a slave at once.
 * @param[out] message  on failure the reason: no such slave, too many faults, or that of ::ect_chain_fault;
 * ECT_FAULT_MESSAGE bytes
 * @return whether the fault is set or executed
 */
bool ect_scenario_set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message);

/**
 * Handles a frame before the chain: executes due steps, selects faults at random, and changes the request.
 * @param[in,out] length  of the frame; a fault may reduce it
 */
ect_frame_effects_t ect_scenario_frame(ect_scenario_t *s, ect_chain_t *chain, uint8_t *frame, size_t *length,
                                       uint64_t now_ns);

/**
 * Ends the run: expectations that are not met have failed, and are reported.
 * @return the verdict
 */
ect_verdict_t ect_scenario_end(ect_scenario_t *s);

/** Writes a decided expectation as one line. @return as snprintf() */
int ect_scenario_print(const ect_scenario_step_t *step, char *text, size_t room);

/** Writes the verdict as one line: "'NAME': 3 of 4 expectations are met". @return as snprintf() */
int ect_scenario_print_verdict(const ect_scenario_t *s, char *text, size_t room);

/** Executes due steps. @return the next time at which a step, or a frame on a wire (s->wires), is due; ECT_NEVER */
uint64_t ect_scenario_tick(ect_scenario_t *s, ect_chain_t *chain, uint64_t now_ns);

/**
 * Changes the reply after the chain according to its effects. Loss, order and delay are the caller's task.
 * @param[in,out] length  reduced if a wire has truncated the frame
 * @return the effect of the wires on the frame
 */
ect_wires_result_t ect_scenario_reply(const ect_scenario_t *s, const ect_frame_effects_t *effects, uint8_t *frame,
                                      size_t *length);

/** @return the highest slave number in the script; 0: none. */
uint16_t ect_scenario_highest_slave(const ect_scenario_t *s);

/** @return true: no faults, steps, tables, waves and kept frames, so ::ect_scenario_frame may be omitted */
static inline bool ect_scenario_rests(const ect_scenario_t *scenario)
{
    return scenario->set_count == 0 && scenario->steps_left == 0 && !scenario->wires.kept &&
           scenario->waves.count == 0 && (!scenario->tables || scenario->tables_over);
}

/**
 * Writes the i-th fault that is set, from 0, faults of frames first, as text (ECT_FAULT_TEXT bytes). @return false: no
 * such fault
 */
bool ect_scenario_show(const ect_scenario_t *s, const ect_chain_t *chain, size_t i, char *text);

/**
 * Writes the i-th line, from 0, of a script that restores the present faults and continues with the remaining steps:
 * lasting faults, except those that a step will end, and steps that are not over.
 * @param[out] text  ECT_STEP_LINE bytes. @return false: no such line
 */
bool ect_scenario_left(const ect_scenario_t *s, const ect_chain_t *chain, size_t i, char *text);

ECT_C_END

#endif
