/* SPDX-License-Identifier: MIT */
/* Set values by mode of operation, in steps. */
#include "profiles/cia402/axis.h"

static bool is_position(int8_t mode)
{
    return mode == ECT_402_CSP || mode == ECT_402_IP;
}

/* --- new set values ----------------------------------------------------------------------------------------------- */

static uint16_t homing_bit(const ect_402_axis_t *a)
{
    return a->mode == ECT_402_HM ? ECT_402_START : is_position(a->mode) ? a->config->reference_bit : 0;
}

void ect_402_follow_begin(ect_402_axis_t *a)
{
    ect_402_hold_begin(a);
    if (!ect_402_standing(a))
        a->reference.speed = a->plant->speed; /* a motion continues from its present state (DRV-204) */
    ect_402_limits_begin(a);
    if (a->mode != a->mode_running) {
        ect_402_homing_abort(a);
        ect_402_task_drop(a);
    }
    a->mode_running = a->mode;
    a->set_new = true;
}

bool ect_402_take_mode(ect_402_axis_t *a)
{
    if (a->action != ECT_402_FOLLOW || a->mode == a->mode_running)
        return false;
    ect_402_follow_begin(a);
    return true;
}

/* During a halt tasks and reference runs are kept, and new ones accepted. */
bool ect_402_halted(const ect_402_axis_t *a)
{
    return a->state == ECT_402_OPERATION_ENABLED && a->action == ECT_402_RAMP &&
           ect_402_command(a->set.control, a->live) == ECT_402_ENABLE_OPERATION;
}

/* @return whether a run starts: at an edge of the bit; the first run in the mode also at its level (homing_by_level) */
static bool starts_homing(const ect_402_axis_t *a, uint16_t rising)
{
    const ect_402_homing_t *h = &a->homing;
    bool level = a->config->homing_by_level && a->mode == ECT_402_HM && (a->set.control & ECT_402_START) != 0;
    return rising != 0 || (level && !h->active && !h->done && !h->error);
}

void ect_402_set_values(ect_402_axis_t *a, uint16_t rising)
{
    int8_t mode = a->mode;
    uint16_t bit = homing_bit(a);
    a->set_new = true;
    ect_402_task_room(a);
    if (a->action != ECT_402_FOLLOW && !ect_402_halted(a))
        return;
    if (ect_402_take_mode(a))
        rising &= (uint16_t)~(bit | ECT_402_START); /* a bit that is 1 at the entry of its mode is no edge (DRV-145) */
    if (starts_homing(a, rising & bit) && a->action == ECT_402_FOLLOW)
        ect_402_homing_start(a);
    else if ((a->set.control & bit) == 0)
        ect_402_homing_abort(a);
    if (mode == ECT_402_PP && (rising & ECT_402_START) != 0)
        ect_402_task_take(a);
}

/* --- following ---------------------------------------------------------------------------------------------------- */

/* Interpolates to each new position over one cycle; without a new position the reference is constant. */
static void follow_position(ect_402_axis_t *a)
{
    ect_402_reference_t *r = &a->reference;
    if (r->loop != ECT_402_LOOP_POSITION)
        r->position = a->plant->position;
    if (a->set_new) {
        a->set_new = false;
        a->toggle = !a->toggle;
        a->segment_steps = a->cycle_steps;
        a->segment_steps = a->segment_steps > 0 ? a->segment_steps : 1;
        a->segment_target = ect_402_absolute(a, r->position, a->set.position);
    }
    r->loop = ECT_402_LOOP_POSITION;
    r->speed = 0;
    if (a->segment_steps == 0)
        return;
    double way = (a->segment_target - r->position) / a->segment_steps;
    r->speed = way * ECT_402_STEPS_PER_S;
    r->position = --a->segment_steps > 0 ? r->position + way : a->segment_target;
}

static double target_speed(const ect_402_axis_t *a)
{
    return ect_402_within(a->set.speed, ect_402_speed_limit(a));
}

static double limited_speed(ect_402_axis_t *a)
{
    double target = target_speed(a);
    a->held |= target != a->set.speed;
    return target;
}

static void follow_speed_ramp(ect_402_axis_t *a)
{
    ect_402_reference_t *r = &a->reference;
    double target = limited_speed(a);
    if (ect_402_limit_holds_speed(a, target))
        return;
    if (a->at_switch)
        r->speed = ect_402_within(r->speed, ect_402_size(a->switch_speed)); /* the return begins at once */
    bool faster = ect_402_size(target) > ect_402_size(r->speed) && (target > 0) == (r->speed >= 0);
    double most = (faster ? ect_402_acceleration(a) : ect_402_deceleration(a)) * ECT_402_STEP_S;
    r->loop = ECT_402_LOOP_SPEED;
    r->speed = ect_402_towards(r->speed, target, most);
}

static void follow_speed(ect_402_axis_t *a)
{
    double target = limited_speed(a);
    if (!ect_402_limit_holds_speed(a, target))
        a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_SPEED, .speed = target};
}

static double on_slope(const ect_402_axis_t *a, double torque)
{
    double most = a->torque_slope / 1000.0 * a->config->rated_torque * ECT_402_STEP_S;
    return ect_402_towards(a->reference.torque, torque, most);
}

bool ect_402_releases(const ect_402_axis_t *a)
{
    return a->config->torque_releases && a->action == ECT_402_RAMP && a->mode == ECT_402_TQ;
}

void ect_402_release(ect_402_axis_t *a)
{
    a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_TORQUE, .torque = on_slope(a, 0)};
}

/* Mode 4 has a slope, mode 10 has none. */
static void follow_torque(ect_402_axis_t *a)
{
    double torque = a->set.torque / 1000.0 * a->config->rated_torque;
    if (a->mode == ECT_402_TQ)
        torque = on_slope(a, torque);
    if (!ect_402_limit_holds_torque(a, torque))
        a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_TORQUE, .torque = torque};
}

bool ect_402_ip_active(const ect_402_axis_t *a)
{
    return !a->config->ip_waits || (a->set.control & ECT_402_START) != 0;
}

void ect_402_follow(ect_402_axis_t *a)
{
    int8_t mode = a->mode;
    (void)ect_402_take_mode(a);
    if (a->homing.active) {
        ect_402_homing_step(a);
        return;
    }
    if ((a->set.control & homing_bit(a)) != 0 || mode == ECT_402_HM) {
        ect_402_brake(a, a->home_acceleration); /* holds the reference point until the bit falls */
        return;
    }
    switch (mode) {
    case ECT_402_PP:
        if (!ect_402_task_active(a))
            ect_402_brake(a, ect_402_deceleration(a));
        ect_402_task_follow(a);
        break;
    case ECT_402_PV:
        follow_speed_ramp(a);
        break;
    case ECT_402_CSV:
        follow_speed(a);
        break;
    case ECT_402_TQ:
    case ECT_402_CST:
        follow_torque(a);
        break;
    case ECT_402_NO_MODE:
        ect_402_brake(a, ect_402_deceleration(a));
        break;
    case ECT_402_IP:
        if (ect_402_ip_active(a))
            follow_position(a);
        else
            ect_402_brake(a, ect_402_deceleration(a));
        break;
    default:
        follow_position(a);
        break;
    }
}

static bool in_position(const ect_402_axis_t *a, double machine)
{
    return ect_402_size(machine - a->plant->position) <= a->position_window;
}

bool ect_402_target_reached(const ect_402_axis_t *a)
{
    int8_t mode = a->mode;
    if (a->homing.active)
        return false;
    switch (mode) {
    case ECT_402_PP:
        return a->task_reached && !a->next.valid && !ect_402_limit_acts(a) && in_position(a, a->task_target);
    case ECT_402_HM:
        return a->homing.done && in_position(a, a->homing.found);
    case ECT_402_PV:
    case ECT_402_CSV:
        return ect_402_size(target_speed(a) - a->plant->speed) <= a->speed_window;
    case ECT_402_TQ:
        return !a->held && a->reference.torque == a->set.torque / 1000.0 * a->config->rated_torque;
    case ECT_402_CST:
        return true;
    default:
        return (a->set.control & a->config->reference_bit) != 0
                   ? a->homing.done
                   : in_position(a, ect_402_nearest(a, a->plant->position, a->set.position));
    }
}
