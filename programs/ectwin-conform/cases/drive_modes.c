/* SPDX-License-Identifier: MIT */
/* CF-D10 to CF-D13: profile position and velocity, homing, cyclic position. */
#include "cases/drive_cruise.h"
#include "cases/drive_motion.h"

enum { PATIENCE_MS = 1000, TOLERANCE = 50 /* of the distance of --move */ };

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
    cruise_expect_at(d, target, "target reached");
}

static void profile_position(drive_t *d)
{
    enum { RELATIVE = 0x40 };
    cruise_need_mode(d, DRIVE_PP, "pp");
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
    cruise_expect_at(d, from, "a target without an edge of bit 4");
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
    cruise_need_mode(d, DRIVE_PV, "pv");
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
    cruise_need_mode(d, DRIVE_HM, "hm");
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

static void cyclic_position(drive_t *d)
{
    cruise_need_mode(d, DRIVE_CSP, "csp");
    drive_choose(d, DRIVE_CSP);
    drive_enable(d);
    expect_bit(d, DRIVE_ATTAINED, true, PATIENCE_MS, "Operation enabled in csp, drive follows");
    const int direction = cruise_direction(d);
    cf_step(d->c, "axis %u: a trapezoid in csp", d->axis + 1);
    cruise_trapezoid(d, direction, true);
    cruise_trapezoid(d, -direction, true);
}

void cf_drive_cyclic(cf_t *c)
{
    drive_each_axis(c, cyclic_position);
}
