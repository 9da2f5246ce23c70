/* SPDX-License-Identifier: MIT */
/* Ramps: from one speed to another, and to a standstill at a target. */
#include "devices/pmctendo/instance.h"

double pmc_within(double x, double limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

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

/* The speed one step later towards a target `left` away: faster as long as a stop there is possible, then slower at the
 * rate that ends there exactly. */
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
