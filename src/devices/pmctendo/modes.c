/* SPDX-License-Identifier: MIT */
/* Set values: what each mode of operation makes of them, step by step. */
#include "devices/pmctendo/instance.h"

#define SPEED_WINDOW (10.0 / 60 * PMC_TURN) /* 10 turns a minute */

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

/* --- limits ------------------------------------------------------------------------------------------------------- */

/* Software limit switches count once the reference is known. */
static bool limits_on(const pmctendo_t *u)
{
    return u->homed && u->limit[0] < u->limit[1];
}

static double clamp(pmctendo_t *u, double user)
{
    bool on = limits_on(u);
    pmc_warn(u, PMC_N_SOFT_NEGATIVE, on && user < u->limit[0]);
    pmc_warn(u, PMC_N_SOFT_POSITIVE, on && user > u->limit[1]);
    if (on && user < u->limit[0])
        return u->limit[0];
    return on && user > u->limit[1] ? u->limit[1] : user;
}

/* The machine position of a set value, seen from `from`. Between software limit switches the axis is a line; without
 * them a set value is a difference of 32 bits, whatever was counted before. */
static double absolute(pmctendo_t *u, double from, int32_t position)
{
    double target = clamp(u, position);
    return limits_on(u) ? pmc_beyond(u, from, target - pmc_counts(pmc_user(u, from))) : pmc_nearest(u, from, position);
}

static double relative(pmctendo_t *u, double from, int32_t way)
{
    double here = pmc_counts(pmc_user(u, from));
    return pmc_beyond(u, from, clamp(u, here + way) - here);
}

/* --- standing still ----------------------------------------------------------------------------------------------- */

void pmc_hold_begin(pmctendo_t *u)
{
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_POSITION, .position = u->plant.position};
    u->segment_steps = 0;
    u->task = false;
}

/* What is left of an acceleration must not go on. */
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
    return mode == PMC_MODE_HOMING ? DS402_START : is_position(mode) ? DS402_REFERENCE : 0;
}

static void start_task(pmctendo_t *u)
{
    double from = u->reference.position;
    bool is_relative = (u->set.control & DS402_RELATIVE) != 0;
    u->task_target = is_relative ? relative(u, from, u->target) : absolute(u, from, u->target);
    u->task = true;
    u->task_reached = false;
}

void pmc_follow_begin(pmctendo_t *u)
{
    pmc_hold_begin(u);
    u->mode_running = pmc_mode(u);
    u->task_reached = false;
    u->set_new = true;
}

static void take_mode(pmctendo_t *u, int8_t mode)
{
    if (mode == u->mode_running)
        return;
    pmc_homing_abort(u);
    pmc_follow_begin(u);
}

void pmc_set_values(pmctendo_t *u, uint16_t rising)
{
    int8_t mode = pmc_mode(u);
    uint16_t bit = homing_bit(mode);
    u->set_new = true;
    if (u->action != DS402_FOLLOW)
        return;
    take_mode(u, mode);
    if ((rising & bit) != 0)
        pmc_homing_start(u);
    else if ((u->set.control & bit) == 0)
        pmc_homing_abort(u);
    if (mode == PMC_MODE_TASK && (rising & DS402_START) != 0)
        start_task(u);
}

/* --- following ---------------------------------------------------------------------------------------------------- */

/* To each new position in the time of a cycle; without a new one it stays. */
static void follow_position(pmctendo_t *u)
{
    pmc_reference_t *r = &u->reference;
    if (u->set_new) {
        u->set_new = false;
        u->segment_steps = pmc_cycle_steps(u);
        u->segment_steps = u->segment_steps > 0 ? u->segment_steps : 1;
        u->segment_target = absolute(u, r->position, u->set.position);
    }
    r->loop = PMC_LOOP_POSITION;
    r->speed = 0;
    if (u->segment_steps == 0)
        return;
    double way = (u->segment_target - r->position) / u->segment_steps;
    r->speed = way * PMC_STEPS_PER_S;
    r->position = --u->segment_steps > 0 ? r->position + way : u->segment_target;
}

static void follow_task(pmctendo_t *u)
{
    if (!u->task)
        return;
    u->task_reached = pmc_profile(&u->reference, u->task_target, u->task_speed, u->acceleration, u->deceleration);
    u->task = !u->task_reached;
}

static void follow_speed_ramp(pmctendo_t *u)
{
    pmc_reference_t *r = &u->reference;
    bool faster = pmc_size(u->set.speed) > pmc_size(r->speed) && (u->set.speed > 0) == (r->speed >= 0);
    double most = (faster ? u->acceleration : u->deceleration) * PMC_STEP_S;
    r->loop = PMC_LOOP_SPEED;
    r->speed = pmc_towards(r->speed, u->set.speed, most);
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
        pmc_brake(u, u->home_acceleration); /* at the reference point, until the bit is taken back */
        return;
    }
    switch (mode) {
    case PMC_MODE_TASK:
        follow_task(u);
        break;
    case PMC_MODE_SPEED_RAMP:
        follow_speed_ramp(u);
        break;
    case PMC_MODE_SPEED:
        u->reference = (pmc_reference_t){.loop = PMC_LOOP_SPEED, .speed = u->set.speed};
        break;
    case PMC_MODE_TORQUE:
        u->reference = (pmc_reference_t){.loop = PMC_LOOP_TORQUE, .torque = u->set.torque / 1000.0 * PMC_RATED_TORQUE};
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
    if (u->action != DS402_FOLLOW)
        return pmc_standing(u);
    if (u->homing.active)
        return false;
    switch (mode) {
    case PMC_MODE_TASK:
        return u->task_reached && in_position(u, u->task_target);
    case PMC_MODE_HOMING:
        return u->homing.done && in_position(u, u->homing.found);
    case PMC_MODE_SPEED_RAMP:
    case PMC_MODE_SPEED:
        return pmc_size(u->set.speed - u->plant.speed) <= SPEED_WINDOW;
    case PMC_MODE_TORQUE:
        return true;
    default:
        return (u->set.control & DS402_REFERENCE) != 0
                   ? u->homing.done
                   : in_position(u, pmc_nearest(u, u->plant.position, u->set.position));
    }
}
