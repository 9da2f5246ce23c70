/* SPDX-License-Identifier: MIT */
/* Execution of the state machine of an axis, and a control step. */
#include "profiles/cia402/axis.h"

enum { MS_NS = 1000000 };

bool ect_402_powered(const ect_402_axis_t *a)
{
    return a->action != ECT_402_OFF;
}

bool ect_402_rests(const ect_402_axis_t *a)
{
    return !ect_402_powered(a) && ect_402_motor_rests(a);
}

/* --- the state machine -------------------------------------------------------------------------------------------- */

/* Closes the brake before the torque of a shaft at a standstill is removed; otherwise the brake closes with its delay.
 */
static void close_brake(ect_402_axis_t *a)
{
    bool late = !a->inputs.supplied || !ect_402_standing(a);
    a->brake_ns = a->time_ns + (late ? (uint64_t)a->plant->brake_delay_ms * MS_NS : 0);
}

static void begin(ect_402_axis_t *a)
{
    if (a->action != ECT_402_FOLLOW && !ect_402_halted(a)) {
        ect_402_homing_abort(a);
        ect_402_task_drop(a);
        a->task_known = a->homing.done = false;
    }
    switch (a->action) {
    case ECT_402_OFF:
        close_brake(a);
        ect_402_control_off(a);
        break;
    case ECT_402_HOLD:
        ect_402_hold_begin(a);
        break;
    case ECT_402_FOLLOW:
        ect_402_follow_begin(a);
        break;
    case ECT_402_STOP:
        ect_402_stop_begin(a);
        ect_402_brake_begin(a);
        break;
    case ECT_402_RAMP:
        if (!ect_402_releases(a))
            ect_402_brake_begin(a);
        break;
    }
}

static bool can_brake(const ect_402_axis_t *a)
{
    const ect_402_conditions_t *c = &a->conditions;
    return ect_402_powered(a) && c->supplied && c->fault_brakes && a->fault_option != 0 && ect_402_stop_in_time(a);
}

/* @return whether a halt acts: in profiled motion (DRV-205) */
static uint16_t control_word(const ect_402_axis_t *a)
{
    bool cyclic = a->mode == ECT_402_CSP || a->mode == ECT_402_CSV || a->mode == ECT_402_CST;
    uint16_t word = a->live ? a->set.control : 0;
    return cyclic && !a->config->cyclic_halts ? word & (uint16_t)~ECT_402_HALT : word;
}

/* Ends a stop in mode 4 without torque, at any speed (DRV-251). */
static bool has_stopped(const ect_402_axis_t *a)
{
    bool releases = a->config->torque_releases && a->mode == ECT_402_TQ && a->action != ECT_402_STOP;
    if (!releases || a->reference.loop != ECT_402_LOOP_TORQUE)
        return ect_402_standing(a);
    return a->reference.torque == 0;
}

static void read_inputs(ect_402_axis_t *a, uint16_t rising)
{
    a->inputs = (ect_402_inputs_t){
        .control = control_word(a),
        .rising = rising,
        .live = a->live,
        .by_level = a->conditions.by_level,
        .supplied = a->conditions.supplied,
        .fault = a->conditions.fault,
        .resettable = a->conditions.resettable,
        .can_brake = can_brake(a),
        .standing = has_stopped(a) || !ect_402_stop_waits(a),
        .stays = ect_402_stop_stays(a),
        .coasts = a->config->coasts || a->disable_option == 0,
    };
}

static bool equal(const ect_402_inputs_t *x, const ect_402_inputs_t *y)
{
    return x->control == y->control && x->rising == y->rising && x->by_level == y->by_level && x->live == y->live &&
           x->supplied == y->supplied && x->fault == y->fault && x->resettable == y->resettable &&
           x->can_brake == y->can_brake && x->standing == y->standing && x->stays == y->stays && x->coasts == y->coasts;
}

/* Reuses the last decision if state and inputs are unchanged, as in nearly all steps. */
static bool decide(ect_402_axis_t *a, uint16_t rising)
{
    bool reset = false;
    ect_402_action_t before = a->action;
    ect_402_inputs_t last = a->inputs;
    read_inputs(a, rising);
    if (a->state == a->decided && equal(&last, &a->inputs))
        return false;
    ect_402_state_t next = ect_402_next(a->state, &a->inputs, &reset);
    bool changed = next != a->state;
    a->decided = a->state; /* a new state needs a new decision */
    a->state = next;
    if (reset) {
        a->was_reset = true;
        a->conditions.fault = a->inputs.fault = false;
    }
    a->action = ect_402_action(next, &a->inputs);
    if (a->action != before)
        begin(a);
    return changed;
}

void ect_402_settle(ect_402_axis_t *a, uint16_t rising)
{
    while (decide(a, rising))
        rising = 0;
}

/* --- a step ------------------------------------------------------------------------------------------------------- */

static void hand_out_edges(ect_402_axis_t *a)
{
    for (unsigned int i = 0; i < a->edges; i++)
        ect_402_homing_edge(a, &a->edge[i]);
}

void ect_402_step(ect_402_axis_t *a)
{
    a->held = false;
    if (a->action == ECT_402_FOLLOW)
        ect_402_follow(a);
    else if (ect_402_releases(a))
        ect_402_release(a);
    else if (a->action == ECT_402_RAMP || a->action == ECT_402_STOP)
        ect_402_brake(a, ect_402_stop_deceleration(a));
    if (ect_402_powered(a))
        ect_402_control(a);
    ect_402_motor_step(a, ect_402_powered(a));
    hand_out_edges(a);
    ect_402_status_step(a);
}

void ect_402_read_levels(ect_402_axis_t *a)
{
    a->edges = 0;
    ect_402_motor_levels(a);
    hand_out_edges(a);
}
