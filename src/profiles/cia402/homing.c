/* SPDX-License-Identifier: MIT */
/* Reference runs, 6098h: a method is one to three legs, and a leg is a motion in one direction until an edge. */
#include <stddef.h>

#include "profiles/cia402/axis.h"

enum { MOST_LEGS = 4, SHORTEST_STEPS = 80 /* 20 ms, so that bit 12 indicates every run */ };
#define AT_THE_POINT 1.0 /* counts */
enum { UP = 1, DOWN = -1, NONE = 0 };

typedef struct leg {
    int8_t direction; /* 0: no leg */
    uint8_t line;
    bool until; /* level; a limit switch reads 0 when hit */
} leg_t;

typedef struct method {
    int8_t number;
    leg_t legs[MOST_LEGS];
} method_t;

/* The methods of CiA 402: 17 to 30 end at a switch, 1 to 14 at the index pulse behind the switch. The cam of 7 to 14
 * and 23 to 30 may lie on either side: a limit switch reverses the search. */
static const method_t methods[] = {
    {1, {{DOWN, ECT_402_NEGATIVE, false}, {UP, ECT_402_NEGATIVE, true}, {UP, ECT_402_INDEX, true}}},
    {2, {{UP, ECT_402_POSITIVE, false}, {DOWN, ECT_402_POSITIVE, true}, {DOWN, ECT_402_INDEX, true}}},
    {3, {{UP, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {DOWN, ECT_402_INDEX, true}}},
    {4, {{DOWN, ECT_402_HOME, false}, {UP, ECT_402_HOME, true}, {UP, ECT_402_INDEX, true}}},
    {5, {{DOWN, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {UP, ECT_402_INDEX, true}}},
    {6, {{UP, ECT_402_HOME, false}, {DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_INDEX, true}}},
    {7, {{UP, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {DOWN, ECT_402_INDEX, true}}},
    {8, {{UP, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {UP, ECT_402_HOME, true}, {UP, ECT_402_INDEX, true}}},
    {9, {{UP, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_INDEX, true}}},
    {10, {{UP, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {UP, ECT_402_INDEX, true}}},
    {11, {{DOWN, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {UP, ECT_402_INDEX, true}}},
    {12,
     {{DOWN, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_INDEX, true}}},
    {13,
     {{DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {UP, ECT_402_HOME, true}, {UP, ECT_402_INDEX, true}}},
    {14, {{DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {DOWN, ECT_402_INDEX, true}}},
    {17, {{DOWN, ECT_402_NEGATIVE, false}, {UP, ECT_402_NEGATIVE, true}}},
    {18, {{UP, ECT_402_POSITIVE, false}, {DOWN, ECT_402_POSITIVE, true}}},
    {19, {{UP, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}}},
    {20, {{DOWN, ECT_402_HOME, false}, {UP, ECT_402_HOME, true}}},
    {21, {{DOWN, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}}},
    {22, {{UP, ECT_402_HOME, false}, {DOWN, ECT_402_HOME, true}}},
    {23, {{UP, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}}},
    {24, {{UP, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {UP, ECT_402_HOME, true}}},
    {25, {{UP, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {DOWN, ECT_402_HOME, true}}},
    {26, {{UP, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}}},
    {27, {{DOWN, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}}},
    {28, {{DOWN, ECT_402_HOME, true}, {UP, ECT_402_HOME, false}, {DOWN, ECT_402_HOME, true}}},
    {29, {{DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}, {UP, ECT_402_HOME, true}}},
    {30, {{DOWN, ECT_402_HOME, true}, {DOWN, ECT_402_HOME, false}}},
    {33, {{DOWN, ECT_402_INDEX, true}}},
    {34, {{UP, ECT_402_INDEX, true}}},
    {35, {{NONE, 0, false}}},
    {37, {{NONE, 0, false}}},
};

static const method_t *find(int8_t number)
{
    for (unsigned int i = 0; i < sizeof methods / sizeof methods[0]; i++) {
        if (methods[i].number == number)
            return &methods[i];
    }
    return NULL;
}

bool ect_402_homing_known(int8_t method)
{
    return find(method) != NULL;
}

static const leg_t *leg_at(const ect_402_axis_t *a)
{
    const method_t *method = find(a->homing.method);
    unsigned int number = a->homing.searching ? 1 : a->homing.leg;
    const leg_t *leg = method && number < MOST_LEGS ? &method->legs[number] : NULL;
    return leg && leg->direction != NONE ? leg : NULL;
}

static bool turns_at_limit(int8_t method)
{
    return (method >= 7 && method <= 14) || (method >= 23 && method <= 30);
}

static int direction_of(const ect_402_axis_t *a, const leg_t *leg)
{
    return a->homing.turned && a->homing.leg == 0 ? -leg->direction : leg->direction;
}

/* Returns to the point found, which the shaft has passed. */
static void turn_back(ect_402_axis_t *a, double found)
{
    a->homing.returning = true;
    a->homing.found = found;
    a->reference =
        (ect_402_reference_t){.loop = ECT_402_LOOP_POSITION, .position = a->plant->position, .speed = a->plant->speed};
}

static void next_leg(ect_402_axis_t *a, double at)
{
    a->homing.leg++;
    if (!leg_at(a))
        turn_back(a, at);
}

/* Handles a shaft that is already behind the first leg. If the second leg searches for the switch, the search runs
 * first, at its speed, and both legs follow slowly for the relevant edge. */
static void skip_first_leg(ect_402_axis_t *a)
{
    const leg_t *leg = leg_at(a);
    if (!leg || leg->line == ECT_402_INDEX || a->level[leg->line] != leg->until)
        return;
    const leg_t *second = leg + 1;
    if (second->line == ECT_402_HOME && second->until)
        a->homing.searching = a->homing.slow = true;
    else
        next_leg(a, a->plant->position);
}

static void fail(ect_402_axis_t *a)
{
    a->homing.active = false;
    a->homing.error = true;
}

void ect_402_homing_start(ect_402_axis_t *a)
{
    a->homing = (ect_402_homing_t){.active = true, .method = a->home_method};
    a->homed = false;
    ect_402_task_drop(a);
    a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_SPEED, .speed = a->plant->speed};
    if (!find(a->homing.method))
        fail(a);
    else if (!leg_at(a))
        turn_back(a, a->plant->position);
}

void ect_402_homing_abort(ect_402_axis_t *a)
{
    a->homing.interrupted |= a->homing.active;
    if (a->homing.active)
        fail(a);
}

/* Accepts edges only in the direction of the leg, because the shaft may still be reversing. */
void ect_402_homing_edge(ect_402_axis_t *a, const ect_402_edge_t *edge)
{
    const leg_t *leg = a->homing.active && !a->homing.returning ? leg_at(a) : NULL;
    if (!leg || edge->line != leg->line || edge->rising != leg->until || a->plant->speed * direction_of(a, leg) <= 0)
        return;
    if (a->homing.searching)
        a->homing.searching = false;
    else
        next_leg(a, edge->position);
}

/* @return whether the shaft is in a limit switch that is not the target of the leg */
static bool stuck(const ect_402_axis_t *a, const leg_t *leg)
{
    unsigned int stop = direction_of(a, leg) == UP ? ECT_402_POSITIVE : ECT_402_NEGATIVE;
    return leg->line != stop && !a->level[stop];
}

static void go(ect_402_axis_t *a)
{
    if (a->homing.leg == 0 && !a->homing.slow)
        skip_first_leg(a);
    const leg_t *leg = leg_at(a);
    bool search = a->homing.searching || (a->homing.leg == 0 && !a->homing.slow && leg->line != ECT_402_INDEX);
    if (search && !a->homing.turned && turns_at_limit(a->homing.method) && stuck(a, leg))
        a->homing.turned = true;
    if (stuck(a, leg)) {
        fail(a);
        return;
    }
    uint32_t speed = a->home_speed[search ? 0 : 1];
    a->reference.loop = ECT_402_LOOP_SPEED;
    a->reference.speed = ect_402_towards(a->reference.speed, (double)direction_of(a, leg) * speed,
                                         a->home_acceleration * ECT_402_STEP_S);
}

static bool returns(ect_402_axis_t *a)
{
    bool there =
        ect_402_ramp(&a->reference, a->homing.found, a->home_speed[1], a->home_acceleration, a->home_acceleration);
    return there && ect_402_size(a->plant->position - a->homing.found) <= AT_THE_POINT;
}

static bool stops(ect_402_axis_t *a)
{
    ect_402_brake(a, a->home_acceleration);
    return a->reference.loop == ECT_402_LOOP_POSITION;
}

static void go_back(ect_402_axis_t *a)
{
    bool there = a->config->home_stays ? stops(a) : returns(a);
    if (!there || !ect_402_standing(a) || a->homing.steps < SHORTEST_STEPS)
        return;
    a->zero = a->homing.found - a->home_offset;
    a->homing.active = false;
    a->homing.done = true;
    a->homed = true;
}

void ect_402_homing_step(ect_402_axis_t *a)
{
    a->homing.steps++;
    if (a->homing.returning)
        go_back(a);
    else
        go(a);
}
