/* SPDX-License-Identifier: MIT */
/*
 * Limits of set values: the speed limit, and the software limit switches 607Dh once the reference is known. Set
 * positions end at a switch; a speed or a torque towards a switch ends in a ramp to a standstill there; the opposite
 * direction is free.
 */
#include "profiles/cia402/axis.h"

#define REACTION_S 0.002 /* lag of the speed controller: the ramp begins earlier by the distance of this lag */
#define CLOSE      10.0  /* counts from the switch that count as at the switch */

static double least(double a, double b)
{
    return a < b ? a : b;
}

double ect_402_speed_limit(const ect_402_axis_t *a)
{
    double motor = a->motor_speed / 60.0 * a->config->turn;
    bool cyclic = a->mode == ECT_402_CSP || a->mode == ECT_402_CSV || a->mode == ECT_402_CST;
    return cyclic && a->config->cyclic_is_free ? motor : least(a->speed_limit, motor);
}

double ect_402_acceleration(const ect_402_axis_t *a)
{
    return least(a->acceleration, a->most_acceleration);
}

double ect_402_deceleration(const ect_402_axis_t *a)
{
    return least(a->deceleration, a->most_deceleration);
}

static bool limits_on(const ect_402_axis_t *a)
{
    return a->homed && a->limit[0] < a->limit[1];
}

static void warn(ect_402_axis_t *a, bool negative, bool positive)
{
    a->limit_negative = negative;
    a->limit_positive = positive;
}

/* --- positions ---------------------------------------------------------------------------------------------------- */

static double clamp(ect_402_axis_t *a, double user)
{
    bool on = limits_on(a);
    warn(a, on && user < a->limit[0], on && user > a->limit[1]);
    if (on && user < a->limit[0])
        return a->limit[0];
    return on && user > a->limit[1] ? a->limit[1] : user;
}

/* --- rotary axes -------------------------------------------------------------------------------------------------- */

static double span(const ect_402_axis_t *a)
{
    return a->range[0] < a->range[1] ? (double)a->range[1] - a->range[0] + 1 : 0;
}

double ect_402_folded(const ect_402_axis_t *a, double user)
{
    double whole = span(a);
    if (whole == 0)
        return user;
    double turns = (user - a->range[0]) / whole;
    double full = (double)(int64_t)turns;
    return user - (turns < full ? full - 1 : full) * whole;
}

/* @return the distance to a position within 607Bh: in mode 1 by 60F2h, in other modes the shorter one */
static double rotary_way(const ect_402_axis_t *a, double from, int32_t position)
{
    enum { LINEAR, NEGATIVE, POSITIVE };
    double whole = span(a);
    double way = ect_402_folded(a, position) - ect_402_folded(a, ect_402_counts(ect_402_user(a, from)));
    unsigned int option = a->mode == ECT_402_PP ? a->options >> 6 & 3u : 3u;
    switch (option) {
    case LINEAR:
        return way;
    case NEGATIVE:
        return way > 0 ? way - whole : way;
    case POSITIVE:
        return way < 0 ? way + whole : way;
    default:
        return way > whole / 2 ? way - whole : way <= -whole / 2 ? way + whole : way;
    }
}

/* Between software limit switches the axis is linear; without these a set value is a difference of 32 bits. */
double ect_402_absolute(ect_402_axis_t *a, double from, int32_t position)
{
    double target = clamp(a, position);
    if (!limits_on(a) && span(a) > 0)
        return ect_402_beyond(a, from, rotary_way(a, from, position));
    return limits_on(a) ? ect_402_beyond(a, from, target - ect_402_counts(ect_402_user(a, from)))
                        : ect_402_nearest(a, from, position);
}

double ect_402_relative(ect_402_axis_t *a, double from, int32_t way)
{
    double here = ect_402_counts(ect_402_user(a, from));
    return ect_402_beyond(a, from, clamp(a, here + way) - here);
}

bool ect_402_limit_acts(const ect_402_axis_t *a)
{
    return a->limit_negative || a->limit_positive;
}

/* --- speeds and torques ------------------------------------------------------------------------------------------- */

static int sign(double x)
{
    return (x > 0) - (x < 0);
}

static double left_to_limit(const ect_402_axis_t *a, int direction)
{
    double here = ect_402_counts(ect_402_user(a, a->plant->position));
    return direction > 0 ? a->limit[1] - here : here - a->limit[0];
}

static bool must_brake(const ect_402_axis_t *a, int direction, double deceleration)
{
    double speed = a->plant->speed * direction;
    speed = speed > 0 ? speed : 0;
    return speed * speed / (2 * deceleration) + speed * REACTION_S + CLOSE >= left_to_limit(a, direction);
}

static void guard(ect_402_axis_t *a, int direction)
{
    double left = left_to_limit(a, direction);
    a->guarded = (int8_t)direction;
    a->guard_target = ect_402_beyond(a, a->plant->position, left > 0 ? direction * left : 0);
    a->reference =
        (ect_402_reference_t){.loop = ECT_402_LOOP_POSITION, .position = a->plant->position, .speed = a->plant->speed};
}

void ect_402_limits_begin(ect_402_axis_t *a)
{
    a->guarded = 0;
    warn(a, false, false);
}

static bool guarded(ect_402_axis_t *a, int direction, double speed, double deceleration)
{
    if (!limits_on(a) || direction == 0)
        a->guarded = 0;
    else if (a->guarded == 0 && must_brake(a, direction, deceleration))
        guard(a, direction);
    warn(a, a->guarded < 0, a->guarded > 0);
    if (a->guarded != 0)
        (void)ect_402_ramp(&a->reference, a->guard_target, speed, ect_402_acceleration(a), deceleration);
    return a->guarded != 0;
}

bool ect_402_limit_holds_speed(ect_402_axis_t *a, double speed)
{
    int direction = sign(speed);
    if (a->guarded != direction)
        a->guarded = 0;
    return guarded(a, direction, ect_402_size(speed), ect_402_deceleration(a));
}

/* Releases the shaft at the switch if the torque towards the switch is less than the holding torque, the integral part
 * of the speed controller. */
bool ect_402_limit_holds_torque(ect_402_axis_t *a, double torque)
{
    if (a->reference.speed == 0 && (torque - a->sum) * a->guarded < 0) {
        ect_402_limits_begin(a);
        return false;
    }
    int direction = a->guarded != 0 ? a->guarded : sign(a->plant->speed);
    return guarded(a, direction, ect_402_speed_limit(a), a->quick_deceleration);
}
