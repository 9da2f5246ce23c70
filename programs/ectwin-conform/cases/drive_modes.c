/* SPDX-License-Identifier: MIT */
/* CF-D10 to CF-D13: modes of operation. */
#include "cases/drive_cruise.h"
#include "cases/drive_motion.h"

enum { PATIENCE_MS = 1000, TOLERANCE = 50 /* of the distance of --move */, LAG_MS = 50 };

static void need_mode(drive_t *d, int8_t mode, const char *name)
{
    cruise_need(d);
    if (!drive_supports(d, mode))
        cf_skip(d->c, "axis %u has no mode %s (6502h)", d->axis + 1, name);
}

static uint32_t way_ms(const drive_t *d, int64_t way)
{
    const int64_t cruise = 2 * 1000 * (way < 0 ? -way : way) / d->c->move.speed;
    return (uint32_t)cruise + 4 * cruise_ramp_ms(d) + PATIENCE_MS;
}

static void expect_bit(drive_t *d, uint16_t bit, bool on, uint32_t ms, const char *what)
{
    cf_expect_that(d->c, drive_wait(d, bit, on ? bit : 0, ms),
                   "axis %u, %s: expected bit 0x%04X of 6041h %s within %u ms, got 0x%04X", d->axis + 1, what, bit,
                   on ? "1" : "0", ms, drive_status(d));
}

static void expect_at(drive_t *d, int64_t target, const char *what)
{
    const int64_t actual = drive_get(d, DRIVE_ACTUAL, 0), most = d->c->move.distance / TOLERANCE;
    cf_expect_that(d->c, actual - target <= most && target - actual <= most,
                   "axis %u, %s: expected 6064h within %lld of %lld, got %lld", d->axis + 1, what, (long long)most,
                   (long long)target, (long long)actual);
}

/* --- CF-D10 ------------------------------------------------------------------------------------------------------- */

/* Sets a set-point by bit 4, with the other bits of `how`, and waits until the axis is at `target`. */
static void task(drive_t *d, uint16_t how, int64_t set, int64_t target)
{
    const int64_t way = target - drive_get(d, DRIVE_ACTUAL, 0);
    cf_expect(d->c, "abort of the target (607Ah)", 0, drive_set(d, DRIVE_TARGET, 0, set));
    drive_command(d, DRIVE_ENABLE | how | DRIVE_START);
    expect_bit(d, DRIVE_ATTAINED, true, PATIENCE_MS, "bit 4 = 1, a set-point");
    cf_expect_bits(d->c, "status word (6041h): target reached, with a new set-point", DRIVE_REACHED, 0,
                   drive_status(d));
    drive_command(d, DRIVE_ENABLE | how);
    expect_bit(d, DRIVE_ATTAINED, false, PATIENCE_MS, "bit 4 = 0, room for another set-point");
    expect_bit(d, DRIVE_REACHED, true, way_ms(d, way), "the way to the target");
    expect_at(d, target, "target reached");
}

static void profile_position(drive_t *d)
{
    enum { RELATIVE = 0x40 };
    need_mode(d, DRIVE_PP, "pp");
    if (!drive_has(d, DRIVE_TASK_SPEED, 0))
        cf_skip(d->c, "axis %u has no 6081h: its speed cannot be limited", d->axis + 1);
    cruise_ramps(d);
    drive_choose(d, DRIVE_PP);
    drive_enable(d);
    (void)drive_set(d, DRIVE_TASK_SPEED, 0, d->c->move.speed);
    const int64_t from = drive_get(d, DRIVE_ACTUAL, 0);
    const int64_t half = cruise_direction(d) * d->c->move.distance / 2;
    cf_step(d->c, "axis %u: a target without an edge of bit 4", d->axis + 1);
    (void)drive_set(d, DRIVE_TARGET, 0, from + half);
    drive_cycles(d, 2 * DRIVE_SETTLE_MS);
    expect_at(d, from, "a target without an edge of bit 4");
    cf_step(d->c, "axis %u: an absolute set-point", d->axis + 1);
    task(d, 0, from + half, from + half);
    cf_step(d->c, "axis %u: a relative set-point back", d->axis + 1);
    task(d, RELATIVE, -half / 2, from + half - half / 2);
}

void cf_drive_position(cf_t *c)
{
    drive_each_axis(c, profile_position);
}

/* --- CF-D11 ------------------------------------------------------------------------------------------------------- */

static void turn_at(drive_t *d, int64_t speed)
{
    const uint32_t ms = 3 * cruise_ramp_ms(d) + PATIENCE_MS;
    cf_step(d->c, "axis %u: %lld in 60FFh", d->axis + 1, (long long)speed);
    cf_expect(d->c, "abort of the target velocity (60FFh)", 0, drive_set(d, DRIVE_TARGET_SPEED, 0, speed));
    drive_cycles(d, DRIVE_HISTORY);
    expect_bit(d, DRIVE_REACHED, true, ms, "the target velocity");
    expect_bit(d, DRIVE_ATTAINED, speed == 0, ms, speed == 0 ? "speed is 0" : "a speed other than 0");
    drive_cycles(d, DRIVE_HISTORY + cruise_ramp_ms(d) / 2);
    const double actual = cruise_speed(d);
    cf_expect_that(d->c, speed == 0 || actual * (double)speed > 0,
                   "axis %u, %lld in 60FFh: expected a motion of 6064h of its sign, got %+.3f units a ms", d->axis + 1,
                   (long long)speed, actual);
}

static void profile_velocity(drive_t *d)
{
    need_mode(d, DRIVE_PV, "pv");
    cruise_ramps(d);
    drive_choose(d, DRIVE_PV);
    drive_enable(d);
    const int direction = cruise_direction(d);
    turn_at(d, 0);
    turn_at(d, direction * d->c->move.speed);
    turn_at(d, 0);
    turn_at(d, -direction * d->c->move.speed);
    turn_at(d, 0);
}

void cf_drive_velocity(cf_t *c)
{
    drive_each_axis(c, profile_velocity);
}

/* --- CF-D12 ------------------------------------------------------------------------------------------------------- */

enum { HOMED = DRIVE_REACHED | DRIVE_ATTAINED, HOMING_BITS = HOMED | DRIVE_ERROR };

/* Methods 37 and 35, its older number: the present position becomes home, without a motion. */
static bool homing_here(drive_t *d)
{
    static const int8_t methods[] = {37, 35};
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++) {
        if (drive_set(d, DRIVE_HOMING_METHOD, 0, methods[i]) == 0)
            return true;
    }
    return false;
}

/* The sign of 607Ch differs between vendors. */
static void home(drive_t *d, int64_t offset)
{
    cf_step(d->c, "axis %u: a reference run here, with %lld in 607Ch", d->axis + 1, (long long)offset);
    drive_command(d, DRIVE_ENABLE | DRIVE_START);
    cf_expect_that(d->c, drive_wait(d, HOMING_BITS, HOMED, 2 * PATIENCE_MS),
                   "axis %u, reference run: expected bits 13, 12, 10 of 6041h as 0 1 1, got 0x%04X", d->axis + 1,
                   drive_status(d));
    const int64_t actual = drive_get(d, DRIVE_ACTUAL, 0), at = actual < 0 ? -actual : actual;
    const int64_t size = offset < 0 ? -offset : offset, most = d->c->move.distance / TOLERANCE;
    cf_expect_that(d->c, at - size <= most && size - at <= most,
                   "axis %u, home with %lld in 607Ch: expected 6064h within %lld of -607Ch (or +607Ch), got %lld",
                   d->axis + 1, (long long)offset, (long long)most, (long long)actual);
    drive_command(d, DRIVE_ENABLE);
    drive_cycles(d, DRIVE_SETTLE_MS);
}

static void homing(drive_t *d)
{
    need_mode(d, DRIVE_HM, "hm");
    if (!homing_here(d))
        cf_skip(d->c, "axis %u has neither method 37 nor 35 (6098h), which need no motion", d->axis + 1);
    const bool shifts = drive_has(d, DRIVE_HOME_OFFSET, 0);
    const int64_t before = shifts ? drive_get(d, DRIVE_HOME_OFFSET, 0) : 0;
    drive_choose(d, DRIVE_HM);
    d->guarded = false; /* 6064h jumps */
    drive_enable(d);
    cf_expect_bits(d->c, "status word (6041h): homing error, before the start", DRIVE_ERROR, 0, drive_status(d));
    if (shifts && drive_set(d, DRIVE_HOME_OFFSET, 0, d->c->move.distance) == 0)
        home(d, d->c->move.distance);
    if (shifts)
        cf_expect(d->c, "abort of the former 607Ch", 0, drive_set(d, DRIVE_HOME_OFFSET, 0, before));
    home(d, before);
}

void cf_drive_homing(cf_t *c)
{
    drive_each_axis(c, homing);
}

/* --- CF-D13 ------------------------------------------------------------------------------------------------------- */

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
static void follow(drive_t *d, int direction)
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
        cf_expect_that(d->c, lag <= most, "axis %u, csp: expected 6064h within %.0f of 607Ah, got %.0f", d->axis + 1,
                       most, lag);
    }
    drive_cycles(d, 2 * LAG_MS);
    expect_at(d, from + direction * (int64_t)way_at(&p, ms), "the end of a trapezoid in csp");
    cf_note(d->c, "csp: 6064h at most %.0f units behind 607Ah at %.0f units a ms", worst, p.speed);
}

static void cyclic_position(drive_t *d)
{
    need_mode(d, DRIVE_CSP, "csp");
    drive_choose(d, DRIVE_CSP);
    drive_enable(d);
    expect_bit(d, DRIVE_ATTAINED, true, PATIENCE_MS, "Operation enabled in csp, drive follows");
    const int direction = cruise_direction(d);
    cf_step(d->c, "axis %u: a trapezoid in csp", d->axis + 1);
    follow(d, direction);
    follow(d, -direction);
}

void cf_drive_cyclic(cf_t *c)
{
    drive_each_axis(c, cyclic_position);
}
