/* SPDX-License-Identifier: MIT */
/*
 * Motion tasks, mode 1 (CiA 402-2, profile position). An edge of bit 4 takes target and rates as one set-point: the
 * running one is finished first, and one may wait. Bit 5 changes over at once, bit 9 without a stop at the first
 * target. A halt keeps both.
 */
#include "devices/pmctendo/instance.h"

static double least(uint32_t a, double b)
{
    return a < b ? a : b;
}

void pmc_task_take(pmctendo_t *u)
{
    pmc_set_point_t *next = &u->next;
    bool at_once = (u->set.control & ECT_402_AT_ONCE) != 0;
    if (next->valid && !at_once)
        return;
    *next = (pmc_set_point_t){
        .valid = true,
        .at_once = at_once,
        .relative = (u->set.control & ECT_402_RELATIVE) != 0,
        .through = (u->set.control & ECT_402_THROUGH) != 0,
        .target = u->target,
        .speed = least(u->task_speed, pmc_speed_limit(u)),
        .acceleration = pmc_acceleration(u),
        .deceleration = pmc_deceleration(u),
    };
    u->task_taken = true;
    u->task_reached = false;
}

/* "Taken" holds as long as bit 4, and until there is room for another. */
void pmc_task_room(pmctendo_t *u)
{
    if ((u->set.control & ECT_402_START) == 0 && !u->next.valid)
        u->task_taken = false;
}

void pmc_task_drop(pmctendo_t *u)
{
    u->task = u->next.valid = u->task_reached = u->task_taken = false;
}

bool pmc_task_active(const pmctendo_t *u)
{
    return u->task || u->next.valid;
}

/* A relative target counts from the last target; after a stop that dropped it, from the present position. */
static double target_of(pmctendo_t *u, const pmc_set_point_t *p)
{
    double from = u->task || u->task_known ? u->task_target : u->reference.position;
    return p->relative ? pmc_relative(u, from, p->target) : pmc_absolute(u, u->reference.position, p->target);
}

static void begin(pmctendo_t *u)
{
    u->task_target = target_of(u, &u->next);
    u->running = u->next;
    u->next.valid = false;
    u->task = u->task_known = true;
    u->task_reached = false;
    pmc_task_room(u);
}

/* Whether the next set-point lies beyond the target and its motion follows without a stop. */
static bool passes(pmctendo_t *u, double *beyond)
{
    if (!u->next.valid || !u->next.through)
        return false;
    *beyond = target_of(u, &u->next);
    return (u->task_target - u->reference.position) * (*beyond - u->task_target) > 0;
}

void pmc_task_follow(pmctendo_t *u)
{
    double target = u->task_target;
    const pmc_set_point_t *p = &u->running;
    if (u->next.valid && (!u->task || u->next.at_once))
        begin(u);
    if (!u->task)
        return;
    bool through = passes(u, &target);
    double before = u->task_target - u->reference.position;
    target = through ? target : u->task_target;
    bool there = pmc_profile(&u->reference, target, p->speed, p->acceleration, p->deceleration);
    bool passed = through && before * (u->task_target - u->reference.position) <= 0;
    u->task_reached = there && !through;
    u->task = !u->task_reached;
    if (passed || (u->task_reached && u->next.valid))
        begin(u);
}
