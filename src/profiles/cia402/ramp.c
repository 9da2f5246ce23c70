/* SPDX-License-Identifier: MIT */
/* Ramps: from one speed to another, and to a standstill at a target. */
#include "profiles/cia402/axis.h"

double ect_402_within(double x, double limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

double ect_402_towards(double from, double to, double most)
{
    if (from > to)
        return from - most > to ? from - most : to;
    return from + most < to ? from + most : to;
}

static double approach(double speed, double goal, double acceleration, double deceleration)
{
    return ect_402_towards(speed, goal, (speed > goal ? deceleration : acceleration) * ECT_402_STEP_S);
}

/* @return the speed one step later, at a distance `left` from the target: higher while a stop at the target is
 * possible, then lower at the rate that ends exactly there */
static double next_speed(double speed, double left, double most, double acceleration, double deceleration)
{
    if (speed < 0)
        return approach(speed, 0, deceleration, 0);
    double after = approach(speed, most, acceleration, deceleration);
    double left_then = left - (speed + after) / 2 * ECT_402_STEP_S;
    if (speed == 0 || after * after <= 2 * deceleration * left_then)
        return after;
    double needed = left > 0 ? speed * speed / (2 * left) : deceleration;
    return speed - (needed < 1.2 * deceleration ? needed : deceleration) * ECT_402_STEP_S;
}

bool ect_402_ramp(ect_402_reference_t *r, double target, double speed, double acceleration, double deceleration)
{
    double direction = target < r->position ? -1 : 1;
    double left = ect_402_size(target - r->position);
    double before = r->speed * direction;
    double after = next_speed(before, left, speed, acceleration, deceleration);
    double way = (before + after) / 2 * ECT_402_STEP_S;
    double slow = 1.5 * ECT_402_STEP_S * (acceleration > deceleration ? acceleration : deceleration);
    bool slow_enough = ect_402_size(before) <= slow && ect_402_size(after) <= slow;
    r->loop = ECT_402_LOOP_POSITION;
    if (slow_enough && (way >= left || after < 0)) {
        r->position = target;
        r->speed = 0;
        return true;
    }
    r->position += direction * way;
    r->speed = direction * after;
    return false;
}
