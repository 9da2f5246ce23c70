/* SPDX-License-Identifier: MIT */
/* Position and speed controller, their limits. Tuned for the motor alone, as after commissioning. */
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

static uint16_t least(uint16_t a, uint16_t b)
{
    return a < b ? a : b;
}

/* 6072h and 6073h both ways, 60E0h and 60E1h one way each. */
static double limit_torque(const pmctendo_t *u, double torque)
{
    uint16_t one_way = torque > 0 ? u->torque_limit[0] : u->torque_limit[1];
    double set = least(least(u->max_torque, u->max_current), one_way) / 1000.0 * PMC_RATED_TORQUE;
    return pmc_within(torque, set < PMC_PEAK_TORQUE ? set : PMC_PEAK_TORQUE);
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

/* No integration while the torque is at its limit: the integral part would wind up. */
static double speed_controller(pmctendo_t *u, double command, double ahead)
{
    double error = command - u->plant.speed;
    double torque = SPEED_GAIN * error + u->sum + ahead;
    double limited = limit_torque(u, torque);
    if (torque == limited)
        u->sum += SPEED_GAIN * error * PMC_STEP_S / INTEGRAL_TIME;
    return limited;
}

/* A torque is followed unless it turns the shaft too fast, or into a limit switch. */
static double torque_controller(pmctendo_t *u)
{
    double torque = limit_torque(u, u->reference.torque);
    double speed = u->plant.speed;
    bool faster = pmc_size(speed) >= pmc_speed_limit(u) && (speed > 0) == (torque > 0);
    if (blocked(u, torque))
        return speed_controller(u, 0, 0);
    return faster ? speed_controller(u, pmc_within(speed, pmc_speed_limit(u)), 0) : torque;
}

/* Beyond 6065h for longer than 6066h. */
bool pmc_following_late(const pmctendo_t *u)
{
    return u->error_steps > u->error_time * (PMC_STEPS_PER_S / 1000u);
}

static void monitor(pmctendo_t *u)
{
    const pmc_reference_t *r = &u->reference;
    double error = r->position - u->plant.position;
    bool watched = r->loop == PMC_LOOP_POSITION && u->error_window != 0 && !blocked(u, error);
    bool late = watched && pmc_size(error) > u->error_window;
    u->error_steps = late ? u->error_steps + 1 : 0;
    if (pmc_following_late(u))
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
    u->error_steps = 0;
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_SPEED};
}

bool pmc_standing(const pmctendo_t *u)
{
    return u->reference.speed == 0 && pmc_size(u->plant.speed) < STANDSTILL;
}
