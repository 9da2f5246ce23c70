/* SPDX-License-Identifier: MIT */
/*
 * Motion tasks, mode 1 (CiA 402-2, profile position). An edge of bit 4 takes target and rates as one set-point: the
 * present one is completed first, and one may wait. Bit 5 replaces the present one at once; bit 9 continues without a
 * stop at the first target. A halt keeps both.
 */
#include "profiles/cia402/axis.h"

static double least(uint32_t a, double b)
{
    return a < b ? a : b;
}

/* "Taken" remains set while bit 4 is set, and until another set-point is accepted. */
void ect_402_task_room(ect_402_axis_t *a)
{
    if ((a->set.control & ECT_402_START) == 0 && !a->next.valid)
        a->task_taken = false;
}

void ect_402_task_drop(ect_402_axis_t *a)
{
    a->task = a->next.valid = a->task_reached = a->task_taken = false;
}

bool ect_402_task_active(const ect_402_axis_t *a)
{
    return a->task || a->next.valid;
}

/* @return the base of a relative target: the last target, or the present position after a stop that dropped it; or by
 * 60F2h the demand or actual position */
static double base_of(const ect_402_axis_t *a)
{
    enum { DEMAND = 1, ACTUAL = 2 };
    switch (a->options & 3u) {
    case DEMAND:
        return a->reference.position;
    case ACTUAL:
        return a->plant->position;
    default:
        return a->task || a->task_known ? a->task_target : a->reference.position;
    }
}

static double target_of(ect_402_axis_t *a, const ect_402_set_point_t *p)
{
    double from = base_of(a);
    return p->relative ? ect_402_relative(a, from, p->target) : ect_402_absolute(a, a->reference.position, p->target);
}

static void begin(ect_402_axis_t *a)
{
    if (a->reference.loop != ECT_402_LOOP_POSITION)
        a->reference.position = a->plant->position; /* braking without a set-point */
    a->task_target = target_of(a, &a->next);
    a->running = a->next;
    a->next.valid = false;
    a->task = a->task_known = true;
    a->task_reached = false;
    ect_402_task_room(a);
}

void ect_402_task_take(ect_402_axis_t *a)
{
    ect_402_set_point_t *next = &a->next;
    bool at_once = (a->set.control & ECT_402_AT_ONCE) != 0 || a->config->no_buffer;
    if (next->valid && !at_once)
        return;
    *next = (ect_402_set_point_t){
        .valid = true,
        .at_once = at_once,
        .relative = (a->set.control & ECT_402_RELATIVE) != 0,
        .through = (a->set.control & ECT_402_THROUGH) != 0,
        .target = a->target,
        .speed = least(a->task_speed, ect_402_speed_limit(a)),
        .end_speed = least(a->end_speed, least(a->task_speed, ect_402_speed_limit(a))),
        .acceleration = ect_402_acceleration(a),
        .deceleration = ect_402_deceleration(a),
    };
    a->task_taken = true;
    a->task_reached = false;
    if (!a->task && a->action == ECT_402_FOLLOW)
        begin(a); /* the place is free again without a step */
}

/* @return whether the next set-point lies beyond the target, and its motion follows without a stop */
static bool passes(ect_402_axis_t *a, double *beyond)
{
    if (!a->next.valid || !a->next.through)
        return false;
    *beyond = target_of(a, &a->next);
    return (a->task_target - a->reference.position) * (*beyond - a->task_target) > 0;
}

/* @return the end of the ramp that passes the target at 6082h */
static double past(const ect_402_axis_t *a, double left)
{
    double way = a->running.end_speed * a->running.end_speed / (2 * a->running.deceleration);
    return a->task_target + (left < 0 ? -way : way);
}

/* Executes one step. @return whether the present set-point is completed */
static bool step(ect_402_axis_t *a)
{
    double beyond = 0;
    const ect_402_set_point_t *p = &a->running;
    bool through = passes(a, &beyond);
    double before = a->task_target - a->reference.position;
    double target = through ? beyond : past(a, before);
    bool there = ect_402_ramp(&a->reference, target, p->speed, p->acceleration, p->deceleration);
    if (through || target != a->task_target)
        there = before * (a->task_target - a->reference.position) <= 0;
    if (through)
        return there;
    a->task_reached = there;
    return there;
}

void ect_402_task_follow(ect_402_axis_t *a)
{
    if (a->next.valid && (!a->task || a->next.at_once))
        begin(a);
    if (!a->task || !step(a))
        return;
    a->task = false;
    if (a->next.valid)
        begin(a);
}
