/* SPDX-License-Identifier: MIT */
/* Motor, load, friction, brake; marks, limit switches and the index pulse on the machine. */
#include "profiles/cia402/axis.h"

static double inertia(const ect_402_axis_t *a)
{
    return a->config->inertia + a->plant->load_inertia * 1e-4;
}

/* @return the torque of friction and of the closed brake, which opposes any motion and never starts one */
static double holding_torque(const ect_402_axis_t *a, bool powered)
{
    bool by_master = a->live && (a->physical[0] & a->physical[1] & 1u) != 0; /* 60FEh */
    bool closed = by_master || (!powered && a->time_ns >= a->brake_ns);
    return a->plant->friction + (closed ? a->plant->brake : 0);
}

static double next_speed(const ect_402_axis_t *a, double torque, double holding)
{
    if (a->plant->jam != 0)
        return 0;
    double per_nm = ect_402_per_nm(a, inertia(a)) * ECT_402_STEP_S;
    double free = a->plant->speed + torque * per_nm;
    double hold = holding * per_nm;
    if (free > hold)
        return free - hold;
    return free < -hold ? free + hold : 0;
}

bool ect_402_motor_rests(const ect_402_axis_t *a)
{
    return a->plant->speed == 0 && (a->plant->jam != 0 || ect_402_size(a->plant->load) <= holding_torque(a, false));
}

static int64_t whole(double x)
{
    int64_t n = (int64_t)x;
    return (double)n > x ? n - 1 : n;
}

int32_t ect_402_counts(double counts)
{
    return (int32_t)(uint32_t)whole(counts + 0.5);
}

int32_t ect_402_saturated(double counts)
{
    if (counts >= INT32_MAX)
        return INT32_MAX;
    return counts <= INT32_MIN ? INT32_MIN : (int32_t)whole(counts + 0.5);
}

double ect_402_beyond(const ect_402_axis_t *a, double from, double way)
{
    return (double)whole(ect_402_user(a, from) + 0.5) + way + a->zero;
}

double ect_402_nearest(const ect_402_axis_t *a, double from, int32_t position)
{
    int32_t here = ect_402_counts(ect_402_user(a, from));
    return ect_402_beyond(a, from, (int32_t)((uint32_t)position - (uint32_t)here));
}

static void add_edge(ect_402_axis_t *a, unsigned int line, bool rising, double position)
{
    if (a->edges < ECT_402_EDGES)
        a->edge[a->edges++] = (ect_402_edge_t){.line = (uint8_t)line, .rising = rising, .position = position};
}

/* --- levels ------------------------------------------------------------------------------------------------------- */

static bool on_mark(const ect_402_mark_t *m, double x)
{
    return x >= m->at && x < (double)m->at + m->width;
}

static bool level(const ect_402_axis_t *a, unsigned int line)
{
    const ect_402_plant_t *p = a->plant;
    bool by_hand = p->input[line] != 0;
    switch (line) {
    case ECT_402_POSITIVE: /* normally closed: a broken wire reads as hit */
        return by_hand && !(p->stop_positive.fitted && p->position >= p->stop_positive.at);
    case ECT_402_NEGATIVE:
        return by_hand && !(p->stop_negative.fitted && p->position <= p->stop_negative.at);
    default:
        return by_hand || on_mark(&p->mark[line], p->position);
    }
}

void ect_402_motor_levels(ect_402_axis_t *a)
{
    for (unsigned int line = 0; line < ECT_402_INPUTS; line++) {
        bool now = level(a, line);
        if (now != a->level[line])
            add_edge(a, line, now, a->plant->position);
        a->level[line] = now;
    }
}

/* --- edges during a step ------------------------------------------------------------------------------------------ */

static bool crossed(double from, double to, double boundary)
{
    return (from < boundary) != (to < boundary);
}

/* Checks a boundary at which the level changes in positive direction, to on or off. The position of the edge is the
 * boundary, not the end of the step. */
static void pass(ect_402_axis_t *a, unsigned int line, double from, double boundary, bool on_upwards)
{
    double to = a->plant->position;
    if (crossed(from, to, boundary))
        add_edge(a, line, (to > from) == on_upwards, boundary);
}

static void pass_switches(ect_402_axis_t *a, double from)
{
    const ect_402_plant_t *p = a->plant;
    for (unsigned int line = ECT_402_PROBE; line <= ECT_402_HOME; line++) {
        const ect_402_mark_t *m = &p->mark[line];
        if (p->input[line] || m->width == 0)
            continue;
        double end = (double)m->at + m->width;
        bool upwards = p->position > from;
        pass(a, line, from, upwards ? m->at : end, upwards);
        pass(a, line, from, upwards ? end : m->at, !upwards);
    }
    if (p->input[ECT_402_POSITIVE] && p->stop_positive.fitted)
        pass(a, ECT_402_POSITIVE, from, p->stop_positive.at, false);
    if (p->input[ECT_402_NEGATIVE] && p->stop_negative.fitted)
        pass(a, ECT_402_NEGATIVE, from, p->stop_negative.at, true);
}

static void pass_index(ect_402_axis_t *a, double from)
{
    double to = a->plant->position;
    int64_t before = whole((from - a->plant->index_at) / a->config->turn);
    int64_t after = whole((to - a->plant->index_at) / a->config->turn);
    if (before != after)
        add_edge(a, ECT_402_INDEX, true,
                 (double)(after > before ? after : before) * a->config->turn + a->plant->index_at);
}

void ect_402_motor_step(ect_402_axis_t *a, bool powered)
{
    ect_402_plant_t *p = a->plant;
    double from = p->position;
    double torque = (powered ? a->torque_now : 0) - p->load;
    double speed = next_speed(a, torque, holding_torque(a, powered));
    p->position += (p->speed + speed) / 2 * ECT_402_STEP_S;
    p->speed = speed;
    a->edges = 0;
    pass_switches(a, from);
    pass_index(a, from);
    for (unsigned int line = 0; line < ECT_402_INPUTS; line++)
        a->level[line] = level(a, line);
}
