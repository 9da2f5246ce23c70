/* SPDX-License-Identifier: MIT */
/* Set values, by mode of operation, step by step. */
#include "devices/pmctendo/instance.h"

int8_t pmc_mode(const pmctendo_t *u)
{
    if (u->mode != PMC_MODE_BY_PDO)
        return u->mode;
    switch (u->assigned_out) {
    case PMC_PDO_SPEED:
        return PMC_MODE_SPEED;
    case PMC_PDO_TORQUE:
        return PMC_MODE_TORQUE;
    default:
        return PMC_MODE_POSITION;
    }
}

static bool is_position(int8_t mode)
{
    return mode == PMC_MODE_POSITION || mode == PMC_MODE_INTERPOLATED;
}

/* --- standing still ----------------------------------------------------------------------------------------------- */

void pmc_hold_begin(pmctendo_t *u)
{
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_POSITION, .position = u->plant.position};
    u->segment_steps = 0;
}

/* The integral part of an acceleration must not act against the ramp. */
void pmc_brake_begin(pmctendo_t *u)
{
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_SPEED, .speed = u->plant.speed};
    if (u->sum * u->plant.speed > 0)
        u->sum = 0;
}

void pmc_brake(pmctendo_t *u, double deceleration)
{
    pmc_reference_t *r = &u->reference;
    if (r->loop == PMC_LOOP_POSITION && r->speed == 0)
        return;
    if (r->loop != PMC_LOOP_SPEED)
        *r = (pmc_reference_t){.loop = PMC_LOOP_SPEED, .speed = u->plant.speed};
    r->speed = pmc_towards(r->speed, 0, deceleration * PMC_STEP_S);
    if (r->speed == 0 && pmc_standing(u))
        pmc_hold_begin(u);
}

/* --- new set values ----------------------------------------------------------------------------------------------- */

static uint16_t homing_bit(int8_t mode)
{
    return mode == PMC_MODE_HOMING ? ECT_402_START : is_position(mode) ? PMC_REFERENCE : 0;
}

void pmc_follow_begin(pmctendo_t *u)
{
    pmc_hold_begin(u);
    pmc_limits_begin(u);
    if (pmc_mode(u) != u->mode_running) {
        pmc_homing_abort(u);
        pmc_task_drop(u);
    }
    u->mode_running = pmc_mode(u);
    u->set_new = true;
}

static void take_mode(pmctendo_t *u, int8_t mode)
{
    if (mode != u->mode_running)
        pmc_follow_begin(u);
}

/* A halt keeps tasks and reference runs, and takes new ones. */
bool pmc_halted(const pmctendo_t *u)
{
    return u->state == ECT_402_OPERATION_ENABLED && u->action == ECT_402_RAMP &&
           ect_402_command(u->set.control, u->live) == ECT_402_ENABLE_OPERATION;
}

void pmc_set_values(pmctendo_t *u, uint16_t rising)
{
    int8_t mode = pmc_mode(u);
    uint16_t bit = homing_bit(mode);
    u->set_new = true;
    pmc_task_room(u);
    if (u->action != ECT_402_FOLLOW && !pmc_halted(u))
        return;
    if (u->action == ECT_402_FOLLOW)
        take_mode(u, mode);
    if ((rising & bit) != 0 && u->action == ECT_402_FOLLOW)
        pmc_homing_start(u);
    else if ((u->set.control & bit) == 0)
        pmc_homing_abort(u);
    if (mode == PMC_MODE_TASK && (rising & ECT_402_START) != 0)
        pmc_task_take(u);
}

/* --- following ---------------------------------------------------------------------------------------------------- */

/* Interpolates to each new position over one cycle; without a new one the reference holds. */
static void follow_position(pmctendo_t *u)
{
    pmc_reference_t *r = &u->reference;
    if (u->set_new) {
        u->set_new = false;
        u->segment_steps = pmc_cycle_steps(u);
        u->segment_steps = u->segment_steps > 0 ? u->segment_steps : 1;
        u->segment_target = pmc_absolute(u, r->position, u->set.position);
    }
    r->loop = PMC_LOOP_POSITION;
    r->speed = 0;
    if (u->segment_steps == 0)
        return;
    double way = (u->segment_target - r->position) / u->segment_steps;
    r->speed = way * PMC_STEPS_PER_S;
    r->position = --u->segment_steps > 0 ? r->position + way : u->segment_target;
}

static double target_speed(const pmctendo_t *u)
{
    return pmc_within(u->set.speed, pmc_speed_limit(u));
}

static void follow_speed_ramp(pmctendo_t *u)
{
    pmc_reference_t *r = &u->reference;
    double target = target_speed(u);
    if (pmc_limit_holds_speed(u, target))
        return;
    bool faster = pmc_size(target) > pmc_size(r->speed) && (target > 0) == (r->speed >= 0);
    double most = (faster ? pmc_acceleration(u) : pmc_deceleration(u)) * PMC_STEP_S;
    r->loop = PMC_LOOP_SPEED;
    r->speed = pmc_towards(r->speed, target, most);
}

static void follow_speed(pmctendo_t *u)
{
    double target = target_speed(u);
    if (!pmc_limit_holds_speed(u, target))
        u->reference = (pmc_reference_t){.loop = PMC_LOOP_SPEED, .speed = target};
}

static void follow_torque(pmctendo_t *u)
{
    double torque = u->set.torque / 1000.0 * PMC_RATED_TORQUE;
    if (!pmc_limit_holds_torque(u, torque))
        u->reference = (pmc_reference_t){.loop = PMC_LOOP_TORQUE, .torque = torque};
}

void pmc_follow(pmctendo_t *u)
{
    int8_t mode = pmc_mode(u);
    take_mode(u, mode);
    if (u->homing.active) {
        pmc_homing_step(u);
        return;
    }
    if ((u->set.control & homing_bit(mode)) != 0 || mode == PMC_MODE_HOMING) {
        pmc_brake(u, u->home_acceleration); /* holds the reference point until the bit falls */
        return;
    }
    switch (mode) {
    case PMC_MODE_TASK:
        pmc_task_follow(u);
        break;
    case PMC_MODE_SPEED_RAMP:
        follow_speed_ramp(u);
        break;
    case PMC_MODE_SPEED:
        follow_speed(u);
        break;
    case PMC_MODE_TORQUE:
        follow_torque(u);
        break;
    default:
        follow_position(u);
        break;
    }
}

static bool in_position(const pmctendo_t *u, double machine)
{
    return pmc_size(machine - u->plant.position) <= u->position_window;
}

bool pmc_target_reached(const pmctendo_t *u)
{
    int8_t mode = pmc_mode(u);
    if (u->homing.active)
        return false;
    switch (mode) {
    case PMC_MODE_TASK:
        return u->task_reached && !u->next.valid && in_position(u, u->task_target);
    case PMC_MODE_HOMING:
        return u->homing.done && in_position(u, u->homing.found);
    case PMC_MODE_SPEED_RAMP:
    case PMC_MODE_SPEED:
        return pmc_size(target_speed(u) - u->plant.speed) <= u->speed_window;
    case PMC_MODE_TORQUE:
        return true;
    default:
        return (u->set.control & PMC_REFERENCE) != 0
                   ? u->homing.done
                   : in_position(u, pmc_nearest(u, u->plant.position, u->set.position));
    }
}
