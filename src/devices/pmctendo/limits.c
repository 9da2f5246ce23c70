/* SPDX-License-Identifier: MIT */
/*
 * Limits of set values: the speed limit, and the software limit switches 607Dh once the reference is known. Set
 * positions end at a switch; a speed or a torque towards one ends in a ramp to a standstill there, and back is free.
 */
#include "devices/pmctendo/instance.h"

#define REACTION_S 0.002 /* of the speed controller: the way of this lag precedes the ramp */
#define CLOSE      10.0  /* counts: at the switch */

static double least(double a, double b)
{
    return a < b ? a : b;
}

double pmc_speed_limit(const pmctendo_t *u)
{
    return least(u->speed_limit, u->motor_speed / 60.0 * PMC_TURN);
}

double pmc_acceleration(const pmctendo_t *u)
{
    return least(u->acceleration, u->most_acceleration);
}

double pmc_deceleration(const pmctendo_t *u)
{
    return least(u->deceleration, u->most_deceleration);
}

static bool limits_on(const pmctendo_t *u)
{
    return u->homed && u->limit[0] < u->limit[1];
}

static void warn(pmctendo_t *u, bool negative, bool positive)
{
    pmc_warn(u, PMC_N_SOFT_NEGATIVE, negative);
    pmc_warn(u, PMC_N_SOFT_POSITIVE, positive);
}

/* --- positions ---------------------------------------------------------------------------------------------------- */

static double clamp(pmctendo_t *u, double user)
{
    bool on = limits_on(u);
    warn(u, on && user < u->limit[0], on && user > u->limit[1]);
    if (on && user < u->limit[0])
        return u->limit[0];
    return on && user > u->limit[1] ? u->limit[1] : user;
}

/* Between software limit switches the axis is a line; without them a set value is a difference of 32 bits. */
double pmc_absolute(pmctendo_t *u, double from, int32_t position)
{
    double target = clamp(u, position);
    return limits_on(u) ? pmc_beyond(u, from, target - pmc_counts(pmc_user(u, from))) : pmc_nearest(u, from, position);
}

double pmc_relative(pmctendo_t *u, double from, int32_t way)
{
    double here = pmc_counts(pmc_user(u, from));
    return pmc_beyond(u, from, clamp(u, here + way) - here);
}

bool pmc_limit_acts(const pmctendo_t *u)
{
    return (u->warnings & (1u << (PMC_N_SOFT_NEGATIVE - 1) | 1u << (PMC_N_SOFT_POSITIVE - 1))) != 0;
}

/* --- speeds and torques ------------------------------------------------------------------------------------------- */

static int sign(double x)
{
    return (x > 0) - (x < 0);
}

static double left_to_limit(const pmctendo_t *u, int direction)
{
    double here = pmc_counts(pmc_user(u, u->plant.position));
    return direction > 0 ? u->limit[1] - here : here - u->limit[0];
}

static bool must_brake(const pmctendo_t *u, int direction, double deceleration)
{
    double speed = u->plant.speed * direction;
    speed = speed > 0 ? speed : 0;
    return speed * speed / (2 * deceleration) + speed * REACTION_S + CLOSE >= left_to_limit(u, direction);
}

static void guard(pmctendo_t *u, int direction)
{
    double left = left_to_limit(u, direction);
    u->guarded = (int8_t)direction;
    u->guard_target = pmc_beyond(u, u->plant.position, left > 0 ? direction * left : 0);
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_POSITION, .position = u->plant.position, .speed = u->plant.speed};
}

void pmc_limits_begin(pmctendo_t *u)
{
    u->guarded = 0;
    warn(u, false, false);
}

static bool guarded(pmctendo_t *u, int direction, double speed, double deceleration)
{
    if (!limits_on(u) || direction == 0)
        u->guarded = 0;
    else if (u->guarded == 0 && must_brake(u, direction, deceleration))
        guard(u, direction);
    warn(u, u->guarded < 0, u->guarded > 0);
    if (u->guarded != 0)
        (void)pmc_profile(&u->reference, u->guard_target, speed, pmc_acceleration(u), deceleration);
    return u->guarded != 0;
}

bool pmc_limit_holds_speed(pmctendo_t *u, double speed)
{
    int direction = sign(speed);
    if (u->guarded != direction)
        u->guarded = 0;
    return guarded(u, direction, pmc_size(speed), pmc_deceleration(u));
}

/* A torque that turns the shaft back releases it at the switch: less towards the switch than the holding torque, which
 * is the integral part of the speed controller. */
bool pmc_limit_holds_torque(pmctendo_t *u, double torque)
{
    if (u->reference.speed == 0 && (torque - u->sum) * u->guarded < 0) {
        pmc_limits_begin(u);
        return false;
    }
    int direction = u->guarded != 0 ? u->guarded : sign(u->plant.speed);
    return guarded(u, direction, pmc_speed_limit(u), u->quick_deceleration);
}
