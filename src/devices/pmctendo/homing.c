/* SPDX-License-Identifier: MIT */
/* Reference runs, 6098h: a method is one to three legs, and a leg is a motion in one direction until an edge. */
#include "devices/pmctendo/instance.h"

enum { MOST_LEGS = 3, SHORTEST_STEPS = 80 /* 20 ms: bit 12 shows every run */ };
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

/* The methods of CiA 402: 17 to 22 end at a switch, 1 to 6 at the index pulse behind it. */
static const method_t methods[] = {
    {1, {{DOWN, PMC_NSTOP, false}, {UP, PMC_NSTOP, true}, {UP, PMC_INDEX, true}}},
    {2, {{UP, PMC_PSTOP, false}, {DOWN, PMC_PSTOP, true}, {DOWN, PMC_INDEX, true}}},
    {3, {{UP, PMC_HOME, true}, {DOWN, PMC_HOME, false}, {DOWN, PMC_INDEX, true}}},
    {4, {{DOWN, PMC_HOME, false}, {UP, PMC_HOME, true}, {UP, PMC_INDEX, true}}},
    {5, {{DOWN, PMC_HOME, true}, {UP, PMC_HOME, false}, {UP, PMC_INDEX, true}}},
    {6, {{UP, PMC_HOME, false}, {DOWN, PMC_HOME, true}, {DOWN, PMC_INDEX, true}}},
    {17, {{DOWN, PMC_NSTOP, false}, {UP, PMC_NSTOP, true}}},
    {18, {{UP, PMC_PSTOP, false}, {DOWN, PMC_PSTOP, true}}},
    {19, {{UP, PMC_HOME, true}, {DOWN, PMC_HOME, false}}},
    {20, {{DOWN, PMC_HOME, false}, {UP, PMC_HOME, true}}},
    {21, {{DOWN, PMC_HOME, true}, {UP, PMC_HOME, false}}},
    {22, {{UP, PMC_HOME, false}, {DOWN, PMC_HOME, true}}},
    {33, {{DOWN, PMC_INDEX, true}}},
    {34, {{UP, PMC_INDEX, true}}},
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

bool pmc_homing_known(int8_t method)
{
    return find(method) != NULL;
}

static const leg_t *leg_at(const pmctendo_t *u)
{
    const method_t *method = find(u->homing.method);
    unsigned int number = u->homing.searching ? 1 : u->homing.leg;
    const leg_t *leg = method && number < MOST_LEGS ? &method->legs[number] : NULL;
    return leg && leg->direction != NONE ? leg : NULL;
}

/* The point is found, and the shaft has passed it. */
static void turn_back(pmctendo_t *u, double found)
{
    u->homing.returning = true;
    u->homing.found = found;
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_POSITION, .position = u->plant.position, .speed = u->plant.speed};
}

static void next_leg(pmctendo_t *u, double at)
{
    u->homing.leg++;
    if (!leg_at(u))
        turn_back(u, at);
}

/* The shaft is on the far side of the first leg already. When the second leg searches for the switch, the search runs
 * at its speed first, and both legs follow slowly for the edge that counts. */
static void skip_first_leg(pmctendo_t *u)
{
    const leg_t *leg = leg_at(u);
    if (!leg || leg->line == PMC_INDEX || u->level[leg->line] != leg->until)
        return;
    const leg_t *second = leg + 1;
    if (second->line == PMC_HOME && second->until)
        u->homing.searching = u->homing.slow = true;
    else
        next_leg(u, u->plant.position);
}

void pmc_homing_start(pmctendo_t *u)
{
    u->homing = (pmc_homing_t){.active = true, .method = u->home_method};
    u->homed = false;
    pmc_task_drop(u);
    u->reference = (pmc_reference_t){.loop = PMC_LOOP_SPEED, .speed = u->plant.speed};
    if (!leg_at(u))
        turn_back(u, u->plant.position);
}

static void fail(pmctendo_t *u)
{
    u->homing.active = false;
    u->homing.error = true;
}

void pmc_homing_abort(pmctendo_t *u)
{
    u->homing.interrupted |= u->homing.active;
    if (u->homing.active)
        fail(u);
}

/* Only in the direction of the leg: the shaft may still be reversing. */
void pmc_homing_edge(pmctendo_t *u, const pmc_edge_t *edge)
{
    const leg_t *leg = u->homing.active && !u->homing.returning ? leg_at(u) : NULL;
    if (!leg || edge->line != leg->line || edge->rising != leg->until || u->plant.speed * leg->direction <= 0)
        return;
    if (u->homing.searching)
        u->homing.searching = false;
    else
        next_leg(u, edge->position);
}

/* In a limit switch that is not the target of the leg. */
static bool stuck(const pmctendo_t *u, const leg_t *leg)
{
    unsigned int stop = leg->direction == UP ? PMC_PSTOP : PMC_NSTOP;
    return leg->line != stop && !u->level[stop];
}

static void go(pmctendo_t *u)
{
    if (u->homing.leg == 0 && !u->homing.slow)
        skip_first_leg(u);
    const leg_t *leg = leg_at(u);
    bool search = u->homing.searching || (u->homing.leg == 0 && !u->homing.slow && leg->line != PMC_INDEX);
    if (stuck(u, leg)) {
        fail(u);
        return;
    }
    uint32_t speed = u->home_speed[search ? 0 : 1];
    u->reference.loop = PMC_LOOP_SPEED;
    u->reference.speed =
        pmc_towards(u->reference.speed, (double)leg->direction * speed, u->home_acceleration * PMC_STEP_S);
}

static void go_back(pmctendo_t *u)
{
    bool there =
        pmc_profile(&u->reference, u->homing.found, u->home_speed[1], u->home_acceleration, u->home_acceleration);
    double off = pmc_size(u->plant.position - u->homing.found);
    if (!there || !pmc_standing(u) || off > AT_THE_POINT || u->homing.steps < SHORTEST_STEPS)
        return;
    u->zero = u->homing.found - u->home_offset;
    u->homing.active = false;
    u->homing.done = true;
    u->homed = true;
}

void pmc_homing_step(pmctendo_t *u)
{
    u->homing.steps++;
    if (u->homing.returning)
        go_back(u);
    else
        go(u);
}
