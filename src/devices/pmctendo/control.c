/* SPDX-License-Identifier: MIT */
/* Position and speed controller, and what limits them. Tuned for the motor alone, as after commissioning. */
#include "devices/pmctendo/instance.h"

#define POSITION_GAIN 50.0                                                 /* 1/s */
#define SPEED_TIME    0.002                                                /* s, of the speed controller */
#define INTEGRAL_TIME 0.02                                                 /* s */
#define SPEED_GAIN    (1.0 / (PMC_PER_NM(PMC_MOTOR_INERTIA) * SPEED_TIME)) /* Nm a count/s */
#define OVERSPEED     1.2
#define STANDSTILL    (3.0 / 60 * PMC_TURN) /* 3 turns a minute */

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
    speed = pmc_within(speed, pmc_speed_limit(u));
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
    return pmc_within(torque, limit);
}

/* A torque is followed as long as it does not turn the shaft too fast, or into a limit switch. */
static double torque_controller(pmctendo_t *u)
{
    double torque = pmc_within(u->reference.torque, torque_limit(u));
    double speed = u->plant.speed;
    bool faster = pmc_size(speed) >= pmc_speed_limit(u) && (speed > 0) == (torque > 0);
    if (blocked(u, torque))
        return speed_controller(u, 0, 0);
    return faster ? speed_controller(u, pmc_within(speed, pmc_speed_limit(u)), 0) : torque;
}

static void monitor(pmctendo_t *u)
{
    const pmc_reference_t *r = &u->reference;
    double error = r->position - u->plant.position;
    bool watched = r->loop == PMC_LOOP_POSITION && u->error_window != 0 && !blocked(u, error);
    if (watched && pmc_size(error) > u->error_window)
        pmc_fault(u, PMC_F_FOLLOWING);
    if (pmc_size(u->plant.speed) > OVERSPEED * pmc_speed_limit(u))
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
