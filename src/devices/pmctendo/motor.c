/* SPDX-License-Identifier: MIT */
/* Motor, load, friction, brake; marks, limit switches and the index pulse along the way. */
#include "devices/pmctendo/instance.h"

static double inertia(const pmctendo_t *u)
{
    return PMC_MOTOR_INERTIA + u->plant.load_inertia * 1e-4;
}

/* Friction, and the brake while it is closed: a torque against any motion that never starts one. */
static double holding_torque(const pmctendo_t *u, bool powered)
{
    bool by_master = u->live && (u->physical[0] & u->physical[1] & 1u) != 0; /* 60FEh */
    bool closed = by_master || (!powered && u->time_ns >= u->brake_ns);
    return u->plant.friction + (closed ? u->plant.brake : 0);
}

static double next_speed(const pmctendo_t *u, double torque, double holding)
{
    double per_nm = PMC_PER_NM(inertia(u)) * PMC_STEP_S;
    double free = u->plant.speed + torque * per_nm;
    double hold = holding * per_nm;
    if (free > hold)
        return free - hold;
    return free < -hold ? free + hold : 0;
}

bool pmc_motor_rests(const pmctendo_t *u)
{
    return u->plant.speed == 0 && pmc_size(u->plant.load) <= holding_torque(u, false);
}

static int64_t whole(double x)
{
    int64_t n = (int64_t)x;
    return (double)n > x ? n - 1 : n;
}

int32_t pmc_counts(double counts)
{
    return (int32_t)(uint32_t)whole(counts + 0.5);
}

int32_t pmc_saturated(double counts)
{
    if (counts >= INT32_MAX)
        return INT32_MAX;
    return counts <= INT32_MIN ? INT32_MIN : (int32_t)whole(counts + 0.5);
}

double pmc_beyond(const pmctendo_t *u, double from, double way)
{
    return (double)whole(pmc_user(u, from) + 0.5) + way + u->zero;
}

double pmc_nearest(const pmctendo_t *u, double from, int32_t position)
{
    int32_t here = pmc_counts(pmc_user(u, from));
    return pmc_beyond(u, from, (int32_t)((uint32_t)position - (uint32_t)here));
}

static void add_edge(pmctendo_t *u, unsigned int line, bool rising, double position)
{
    if (u->edges < PMC_EDGES)
        u->edge[u->edges++] = (pmc_edge_t){.line = (uint8_t)line, .rising = rising, .position = position};
}

/* --- levels ------------------------------------------------------------------------------------------------------- */

static bool on_mark(const pmc_mark_t *m, double x)
{
    return x >= m->at && x < (double)m->at + m->width;
}

static bool level(const pmctendo_t *u, unsigned int line)
{
    const pmc_plant_t *p = &u->plant;
    bool by_hand = p->input[line] != 0;
    switch (line) {
    case PMC_PSTOP: /* closed unless the switch is hit: a broken wire reads as hit */
        return by_hand && !(p->stop_positive.fitted && p->position >= p->stop_positive.at);
    case PMC_NSTOP:
        return by_hand && !(p->stop_negative.fitted && p->position <= p->stop_negative.at);
    default:
        return by_hand || on_mark(&p->mark[line], p->position);
    }
}

void pmc_motor_levels(pmctendo_t *u)
{
    for (unsigned int line = 0; line < PMC_INPUTS; line++) {
        bool now = level(u, line);
        if (now != u->level[line])
            add_edge(u, line, now, u->plant.position);
        u->level[line] = now;
    }
}

/* --- on the way --------------------------------------------------------------------------------------------------- */

static bool crossed(double from, double to, double boundary)
{
    return (from < boundary) != (to < boundary);
}

/* A boundary at which the level changes upwards: on, or off. The edge lies at the boundary, wherever the step ends. */
static void pass(pmctendo_t *u, unsigned int line, double from, double boundary, bool on_upwards)
{
    double to = u->plant.position;
    if (crossed(from, to, boundary))
        add_edge(u, line, (to > from) == on_upwards, boundary);
}

static void pass_switches(pmctendo_t *u, double from)
{
    const pmc_plant_t *p = &u->plant;
    for (unsigned int line = PMC_DI1; line <= PMC_DI2; line++) {
        const pmc_mark_t *m = &p->mark[line];
        if (p->input[line] || m->width == 0)
            continue;
        double end = (double)m->at + m->width;
        bool upwards = p->position > from;
        pass(u, line, from, upwards ? m->at : end, upwards);
        pass(u, line, from, upwards ? end : m->at, !upwards);
    }
    if (p->input[PMC_PSTOP] && p->stop_positive.fitted)
        pass(u, PMC_PSTOP, from, p->stop_positive.at, false);
    if (p->input[PMC_NSTOP] && p->stop_negative.fitted)
        pass(u, PMC_NSTOP, from, p->stop_negative.at, true);
}

static void pass_index(pmctendo_t *u, double from)
{
    double to = u->plant.position;
    int64_t before = whole((from - u->plant.index_at) / PMC_TURN);
    int64_t after = whole((to - u->plant.index_at) / PMC_TURN);
    if (before != after)
        add_edge(u, PMC_INDEX, true, (double)(after > before ? after : before) * PMC_TURN + u->plant.index_at);
}

void pmc_motor_step(pmctendo_t *u, bool powered)
{
    pmc_plant_t *p = &u->plant;
    double from = p->position;
    double torque = (powered ? u->torque_now : 0) - p->load;
    double speed = next_speed(u, torque, holding_torque(u, powered));
    p->position += (p->speed + speed) / 2 * PMC_STEP_S;
    p->speed = speed;
    u->edges = 0;
    pass_switches(u, from);
    pass_index(u, from);
    for (unsigned int line = 0; line < PMC_INPUTS; line++)
        u->level[line] = level(u, line);
}
