/* SPDX-License-Identifier: MIT */
#include "cases/drive_cruise.h"

#define STILL 0.05 /* share of the speed of the cruise */
enum { SHORTEST_RAMP_MS = 10, LEAST_CRUISE_MS = 50, NS_A_MS = 1000000 };
enum { TOLERANCE = 50 /* of the distance of --move */, LAG_MS = 50 };

void cruise_need(drive_t *d)
{
    if (!drive_maps_input(d, DRIVE_ACTUAL))
        cf_skip(d->c, "axis %u has no 6064h in the process data: its travel cannot be limited", d->axis + 1);
}

void cruise_need_mode(drive_t *d, int8_t mode, const char *name)
{
    cruise_need(d);
    if (!drive_supports(d, mode))
        cf_skip(d->c, "axis %u has no mode %s (6502h)", d->axis + 1, name);
}

void cruise_ramps(drive_t *d)
{
    static const struct {
        uint16_t index;
        int factor;
    } rows[] = {{DRIVE_ACCELERATION, 1}, {DRIVE_DECELERATION, 1}, {DRIVE_QUICK_DECELERATION, 2}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (!drive_has(d, rows[i].index, 0))
            continue;
        const uint32_t code = drive_set(d, rows[i].index, 0, rows[i].factor * d->c->move.acceleration);
        cf_expect_that(d->c, code == 0, "axis %u: acceleration of --move in %04Xh: abort 0x%08X", d->axis + 1,
                       rows[i].index, code);
    }
}

uint32_t cruise_ramp_ms(const drive_t *d)
{
    const uint32_t ms = (uint32_t)(1000 * d->c->move.speed / d->c->move.acceleration);
    return ms > SHORTEST_RAMP_MS ? ms : SHORTEST_RAMP_MS;
}

double cruise_speed(const drive_t *d)
{
    if (d->cycles < DRIVE_HISTORY)
        return 0;
    const unsigned int newest = (d->cycles - 1) % DRIVE_HISTORY, oldest = d->cycles % DRIVE_HISTORY;
    const uint64_t ns = d->history_ns[newest] - d->history_ns[oldest];
    const uint32_t way = (uint32_t)d->history[newest] - (uint32_t)d->history[oldest];
    return ns > 0 ? (double)(int32_t)way * (double)NS_A_MS / (double)ns : 0;
}

int cruise_direction(drive_t *d)
{
    return drive_get(d, DRIVE_ACTUAL, 0) > d->origin ? -1 : 1;
}

int8_t cruise_mode(drive_t *d)
{
    static const int8_t modes[] = {DRIVE_PV, DRIVE_PP, DRIVE_CSP};
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        if (drive_supports(d, modes[i]) && (modes[i] != DRIVE_PP || drive_has(d, DRIVE_TASK_SPEED, 0)))
            return modes[i];
    }
    return 0;
}

/* Set positions along a straight line: csp. The acceleration is that of the axis. */
static void stream(drive_t *d, int direction, uint32_t ms)
{
    const int64_t from = drive_get(d, DRIVE_ACTUAL, 0);
    const uint64_t start = cf_now_ns();
    const double ramp = cruise_ramp_ms(d);
    for (double t = 0; t < ms;) {
        t = (double)(cf_now_ns() - start) / (double)NS_A_MS;
        const double whole = t < ramp ? t * t / (2 * ramp) : t - ramp / 2;
        const int64_t way = (int64_t)(whole * (double)d->c->move.speed / 1000);
        drive_set_position(d, from + direction * way);
        drive_cycle(d);
    }
}

/* A set-point near the limit of the travel, which the motion does not reach. */
static void set_point(drive_t *d, int direction)
{
    (void)drive_set(d, DRIVE_TASK_SPEED, 0, d->c->move.speed);
    (void)drive_set(d, DRIVE_TARGET, 0, d->origin + direction * d->c->move.distance * 9 / 10);
    drive_command(d, DRIVE_ENABLE);
    drive_command(d, DRIVE_ENABLE | DRIVE_START);
}

double cruise_begin(drive_t *d)
{
    const int8_t mode = cruise_mode(d);
    const int direction = cruise_direction(d);
    const uint32_t ms = cruise_ramp_ms(d) * 3 / 2 + LEAST_CRUISE_MS;
    if (mode == 0)
        cf_skip(d->c, "axis %u has none of the modes pv, pp and csp", d->axis + 1);
    drive_choose(d, mode);
    if (drive_state(drive_status(d)) != DRIVE_ENABLED)
        drive_enable(d);
    cf_step(d->c, "axis %u: a motion in mode %d", d->axis + 1, mode);
    if (mode == DRIVE_PV)
        (void)drive_set(d, DRIVE_TARGET_SPEED, 0, direction * d->c->move.speed);
    else if (mode == DRIVE_PP)
        set_point(d, direction);
    if (mode == DRIVE_CSP)
        stream(d, direction, ms);
    else
        for (const uint64_t until = cf_now_ns() + (uint64_t)ms * NS_A_MS; cf_now_ns() < until;)
            drive_cycle(d);
    const double speed = cruise_speed(d);
    cf_expect_that(d->c, speed * direction > 0, "axis %u, mode %d: expected a motion of 6064h, got %+.3f units a ms",
                   d->axis + 1, mode, speed);
    return speed;
}

static bool has_left(drive_state_t state)
{
    return state != DRIVE_ENABLED && state != DRIVE_STOPPING && state != DRIVE_REACTION;
}

cruise_end_t cruise_watch(drive_t *d, double speed, uint32_t ms)
{
    cruise_end_t end = {UINT32_MAX, UINT32_MAX, 0};
    const uint64_t start = cf_now_ns();
    uint32_t now = 0;
    while (now < ms && (end.standstill_ms == UINT32_MAX)) {
        drive_cycle(d);
        now = (uint32_t)((cf_now_ns() - start) / NS_A_MS);
        const double share = cruise_speed(d) / speed;
        if (end.left_ms == UINT32_MAX && has_left(drive_state(drive_status(d)))) {
            end.left_ms = now;
            end.left_speed = share;
        }
        if (share < STILL)
            end.standstill_ms = now;
    }
    return end;
}

void cruise_expect_at(drive_t *d, int64_t target, const char *what)
{
    const int64_t actual = drive_get(d, DRIVE_ACTUAL, 0), most = d->c->move.distance / TOLERANCE;
    cf_expect_that(d->c, actual - target <= most && target - actual <= most,
                   "axis %u, %s: expected 6064h within %lld of %lld, got %lld", d->axis + 1, what, (long long)most,
                   (long long)target, (long long)actual);
}

/* --- set positions along a trapezoid ------------------------------------------------------------------------------ */

/* A trapezoid, slower than --move when the way is short. */
typedef struct trapezoid {
    double ramp_ms, cruise_ms, speed; /* units a ms */
} trapezoid_t;

static trapezoid_t plan(const cf_move_t *move, double way)
{
    const double acceleration = (double)move->acceleration / 1e6;
    double speed = (double)move->speed / 1e3;
    while (speed * speed > way * acceleration)
        speed /= 2;
    return (trapezoid_t){speed / acceleration, way / speed - speed / acceleration, speed};
}

static double way_at(const trapezoid_t *p, double ms)
{
    const double brake = p->ramp_ms + p->cruise_ms, whole = p->speed * brake;
    if (ms < p->ramp_ms)
        return p->speed * ms * ms / (2 * p->ramp_ms);
    if (ms < brake)
        return p->speed * (ms - p->ramp_ms / 2);
    const double left = brake + p->ramp_ms - ms;
    return left > 0 ? whole - p->speed * left * left / (2 * p->ramp_ms) : whole;
}

/* The greatest distance behind the set position that is allowed: the way of LAG_MS, and a tolerance. */
void cruise_trapezoid(drive_t *d, int direction, bool follows)
{
    const trapezoid_t p = plan(&d->c->move, (double)d->c->move.distance / 2);
    const int64_t from = drive_get(d, DRIVE_ACTUAL, 0);
    const double most = p.speed * (double)LAG_MS + (double)d->c->move.distance / (double)TOLERANCE;
    const uint64_t start = cf_now_ns();
    double ms = 0, worst = 0;
    while (ms < 2 * p.ramp_ms + p.cruise_ms) {
        ms = (double)(cf_now_ns() - start) / 1e6;
        const int64_t set = from + direction * (int64_t)way_at(&p, ms);
        drive_set_position(d, set);
        drive_cycle(d);
        const double behind = (double)(set - drive_get(d, DRIVE_ACTUAL, 0)), lag = behind < 0 ? -behind : behind;
        worst = lag > worst ? lag : worst;
        cf_expect_that(d->c, !follows || lag <= most,
                       "axis %u: expected 6064h within %.0f of the set position, got %.0f", d->axis + 1, most, lag);
    }
    drive_cycles(d, 2 * LAG_MS);
    if (!follows)
        return;
    cruise_expect_at(d, from + direction * (int64_t)way_at(&p, ms), "the end of a trapezoid");
    cf_note(d->c, "6064h at most %.0f units behind the set position at %.0f units a ms", worst, p.speed);
}
