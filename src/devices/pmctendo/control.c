/* SPDX-License-Identifier: MIT */
/* Position and speed controller, and what limits them. Tuned for the motor alone, as after commissioning. */
#include "devices/pmctendo/instance.h"

#define POSITION_GAIN 50.0                                                 /* 1/s */
#define SPEED_TIME    0.002                                                /* s, of the speed controller */
#define INTEGRAL_TIME 0.02                                                 /* s */
#define SPEED_GAIN    (1.0 / (PMC_PER_NM(PMC_MOTOR_INERTIA) * SPEED_TIME)) /* Nm a count/s */
#define OVERSPEED     1.2
#define STANDSTILL    (3.0 / 60 * PMC_TURN) /* 3 turns a minute */

static double within(double x, double limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

/* --- profile ------------------------------------------------------------------------------------------------------ */

double pmc_towards(double from, double to, double most)
{
    if (from > to)
        return from - most > to ? from - most : to;
    return from + most < to ? from + most : to;
}

static double approach(double speed, double goal, double acceleration, double deceleration)
{
    return pmc_towards(speed, goal, (speed > goal ? deceleration : acceleration) * PMC_STEP_S);
}

/* The speed towards a target `left` away, one step later: faster as long as it could still stop there, then slower by
 * what is needed to end there exactly. */
static double next_speed(double speed, double left, double most, double acceleration, double deceleration)
{
    if (speed < 0)
        return approach(speed, 0, deceleration, 0);
    double after = approach(speed, most, acceleration, deceleration);
    double left_then = left - (speed + after) / 2 * PMC_STEP_S;
    if (speed == 0 || after * after <= 2 * deceleration * left_then)
        return after;
    double needed = left > 0 ? speed * speed / (2 * left) : deceleration;
    return speed - (needed < 1.2 * deceleration ? needed : deceleration) * PMC_STEP_S;
}

bool pmc_profile(pmc_reference_t *r, double target, double speed, double acceleration, double deceleration)
{
    double direction = target < r->position ? -1 : 1;
    double left = pmc_size(target - r->position);
    double before = r->speed * direction;
    double after = next_speed(before, left, speed, acceleration, deceleration);
    double way = (before + after) / 2 * PMC_STEP_S;
    double slow = 1.5 * PMC_STEP_S * (acceleration > deceleration ? acceleration : deceleration);
    bool slow_enough = pmc_size(before) <= slow && pmc_size(after) <= slow;
    r->loop = PMC_LOOP_POSITION;
    if (slow_enough && (way >= left || after < 0)) {
        r->position = target;
        r->speed = 0;
        return true;
    }
    r->position += direction * way;
    r->speed = direction * after;
    return false;
}

/* --- controllers -------------------------------------------------------------------------------------------------- */

static bool blocked(const pmctendo_t *u, double speed)
{
    return (speed > 0 && !u->level[PMC_PSTOP]) || (speed < 0 && !u->level[PMC_NSTOP]);
}

static double torque_limit(const pmctendo_t *u)
{
    double set = u->max_torque / 1000.0 * PMC_RATED_TORQUE;
    return set < PMC_PEAK_TORQUE ? set : PMC_PEAK_TORQUE;
}

static double speed_command(const pmctendo_t *u)
{
    const pmc_reference_t *r = &u->reference;
    double speed = r->speed;
    if (r->loop == PMC_LOOP_POSITION)
        speed += POSITION_GAIN * (r->position - u->plant.position);
    speed = within(speed, u->speed_limit);
    return blocked(u, speed) ? 0 : speed;
}

/* The integral part stands still while the torque is at its limit: else it would have to be unwound. */
static double speed_controller(pmctendo_t *u, double command, double ahead)
{
    double limit = torque_limit(u);
    double error = command - u->plant.speed;
    double torque = SPEED_GAIN * error + u->sum + ahead;
    if (pmc_size(torque) < limit)
        u->sum += SPEED_GAIN * error * PMC_STEP_S / INTEGRAL_TIME;
    return within(torque, limit);
}

/* A torque is followed as long as it does not turn the shaft too fast, or into a limit switch. */
static double torque_controller(pmctendo_t *u)
{
    double torque = within(u->reference.torque, torque_limit(u));
    double speed = u->plant.speed;
    bool faster = pmc_size(speed) >= u->speed_limit && (speed > 0) == (torque > 0);
    if (blocked(u, torque))
        return speed_controller(u, 0, 0);
    return faster ? speed_controller(u, within(speed, u->speed_limit), 0) : torque;
}

static void monitor(pmctendo_t *u)
{
    const pmc_reference_t *r = &u->reference;
    double error = r->position - u->plant.position;
    bool watched = r->loop == PMC_LOOP_POSITION && u->error_window != 0 && !blocked(u, error);
    if (watched && pmc_size(error) > u->error_window)
        pmc_fault(u, PMC_F_FOLLOWING);
    if (pmc_size(u->plant.speed) > OVERSPEED * u->speed_limit)
        pmc_fault(u, PMC_F_OVERSPEED);
}

void pmc_control(pmctendo_t *u)
{
    double ahead = u->reference.loop == PMC_LOOP_POSITION ? u->set.ahead / 1000.0 * PMC_RATED_TORQUE : 0;
    u->torque_now =
        u->reference.loop == PMC_LOOP_TORQUE ? torque_controller(u) : speed_controller(u, speed_command(u), ahead);
    monitor(u);
}

void pmc_control_off(pmctendo_t *u)
{
    u->torque_now = 0;
    u->sum = 0;
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_SPEED};
}

bool pmc_standing(const pmctendo_t *u)
{
    return u->reference.speed == 0 && pmc_size(u->plant.speed) < STANDSTILL;
}
