/* SPDX-License-Identifier: MIT */
/* CF-D14 to CF-D17: interpolated position, profile torque, cyclic velocity and torque. */
#include "cases/drive_cruise.h"
#include "cases/drive_motion.h"

#define HALF_SLACK 0.25 /* of the speed that half the set value gives */
enum { PATIENCE_MS = 1000, TOLERANCE = 50 /* of the distance of --move */, HELD_MS = 30 };
enum { TORQUE_STEP = 5, MOST_TORQUE = 300, STEP_MS = 10, SLOPE = 50, FIRST_TORQUE = 10 }; /* per mille of 6076h */

static void follows(drive_t *d, const char *mode)
{
    cf_expect_that(d->c, drive_wait(d, DRIVE_ATTAINED, DRIVE_ATTAINED, PATIENCE_MS),
                   "axis %u, Operation enabled in %s: expected bit 12 of 6041h, got 0x%04X", d->axis + 1, mode,
                   drive_status(d));
}

/* --- CF-D14 ------------------------------------------------------------------------------------------------------- */

static void expect_bit_4(drive_t *d, bool on)
{
    drive_command(d, on ? DRIVE_ENABLE | DRIVE_START : DRIVE_ENABLE);
    cf_expect_that(d->c, drive_wait(d, DRIVE_ATTAINED, on ? DRIVE_ATTAINED : 0, PATIENCE_MS),
                   "axis %u, bit 4 = %d in ip: expected bit 12 of 6041h %d, got 0x%04X", d->axis + 1, on, on,
                   drive_status(d));
}

/* An axis that needs no bit 4 follows at once: common, and no fault of its motion. */
static void expect_held(drive_t *d, int direction)
{
    const int64_t before = drive_get(d, DRIVE_ACTUAL, 0), most = d->c->move.distance / TOLERANCE;
    cf_step(d->c, "axis %u: a trapezoid in ip with bit 4 = 0", d->axis + 1);
    cruise_trapezoid(d, direction, false);
    const int64_t way = drive_get(d, DRIVE_ACTUAL, 0) - before;
    if (way > most || way < -most)
        cf_warn(d->c, "axis %u, ip with bit 4 = 0: expected no motion of 6064h, got %lld units", d->axis + 1,
                (long long)way);
    drive_hold(d);
    drive_cycles(d, DRIVE_SETTLE_MS);
}

static void interpolated(drive_t *d)
{
    cruise_need_mode(d, DRIVE_IP, "ip");
    if (!drive_maps_output(d, DRIVE_RECORD, 1))
        cf_skip(d->c, "axis %u has no 60C1h:1 in the process data", d->axis + 1);
    drive_choose(d, DRIVE_IP);
    drive_enable(d);
    const int direction = cruise_direction(d);
    expect_held(d, direction);
    cf_step(d->c, "axis %u: a trapezoid in ip", d->axis + 1);
    const int way = cruise_direction(d);
    expect_bit_4(d, true);
    cruise_trapezoid(d, way, true);
    cruise_trapezoid(d, -way, true);
    drive_hold(d);
    drive_command(d, DRIVE_ENABLE);
}

void cf_drive_interpolated(cf_t *c)
{
    drive_each_axis(c, interpolated);
}

/* --- CF-D15 ------------------------------------------------------------------------------------------------------- */

/* A ramp of 60FFh at the acceleration of --move, then the last value for HELD_MS. */
static void ramp(drive_t *d, int64_t from, int64_t to)
{
    const uint32_t ms = cruise_ramp_ms(d);
    const uint64_t start = cf_now_ns();
    for (double t = 0; t < ms;) {
        t = (double)(cf_now_ns() - start) / 1e6;
        const double share = t < ms ? t / ms : 1;
        (void)drive_set(d, DRIVE_TARGET_SPEED, 0, from + (int64_t)((double)(to - from) * share));
        drive_cycle(d);
    }
    (void)drive_set(d, DRIVE_TARGET_SPEED, 0, to);
    drive_cycles(d, HELD_MS);
}

/* @return 6064h at the set speed, units a ms */
static double held_at(drive_t *d, int64_t speed)
{
    cf_step(d->c, "axis %u: a ramp to %lld in 60FFh", d->axis + 1, (long long)speed);
    ramp(d, 0, speed);
    const double actual = cruise_speed(d);
    cf_expect_that(d->c, actual * (double)speed > 0,
                   "axis %u, %lld in 60FFh: expected a motion of 6064h of its sign, got %+.3f units a ms", d->axis + 1,
                   (long long)speed, actual);
    ramp(d, speed, 0);
    const double rest = cruise_speed(d) / actual;
    cf_expect_that(d->c, rest < HALF_SLACK,
                   "axis %u, 0 in 60FFh: expected a standstill of 6064h, got %.0f %% of the speed", d->axis + 1,
                   100 * rest);
    return actual;
}

/* The unit of 60FFh is the drive's own: half of a value is half of its speed in any. */
static void cyclic_speed(drive_t *d)
{
    cruise_need_mode(d, DRIVE_CSV, "csv");
    if (!drive_has(d, DRIVE_TARGET_SPEED, 0))
        cf_skip(d->c, "axis %u has no 60FFh", d->axis + 1);
    drive_choose(d, DRIVE_CSV);
    drive_enable(d);
    follows(d, "csv");
    const int direction = cruise_direction(d);
    const double whole = held_at(d, direction * d->c->move.speed), back = held_at(d, -direction * d->c->move.speed);
    const double half = held_at(d, direction * d->c->move.speed / 2) / whole;
    cf_expect_that(d->c, half > 0.5 - HALF_SLACK && half < 0.5 + HALF_SLACK,
                   "axis %u, half the value in 60FFh: expected half the speed of 6064h, got %.2f of it", d->axis + 1,
                   half);
    cf_note(d->c, "csv: 6064h moves %.0f and %.0f units a ms", whole, back);
}

void cf_drive_cyclic_speed(cf_t *c)
{
    drive_each_axis(c, cyclic_speed);
}

/* --- torque ------------------------------------------------------------------------------------------------------- */

static bool has_moved(drive_t *d, int64_t from)
{
    const int64_t way = drive_get(d, DRIVE_ACTUAL, 0) - from, least = d->c->move.distance / TOLERANCE;
    return way > least || way < -least;
}

/* Quick stop: an axis in a torque mode has no other brake. */
static void stop(drive_t *d)
{
    const uint64_t until = cf_now_ns() + DRIVE_WAIT_MS * UINT64_C(1000000);
    (void)drive_set(d, DRIVE_TARGET_TORQUE, 0, 0);
    drive_command(d, DRIVE_QUICK_STOP);
    drive_cycles(d, DRIVE_SETTLE_MS);
    while ((drive_state(drive_status(d)) == DRIVE_STOPPING && cruise_speed(d) * cruise_speed(d) > 1) &&
           cf_now_ns() < until)
        drive_cycle(d);
    drive_go(d, 0, DRIVE_DISABLED);
}

/* A torque that grows until the axis moves, or to MOST_TORQUE. The load of the axis is unknown. */
static void push(drive_t *d, int direction)
{
    const int64_t from = drive_get(d, DRIVE_ACTUAL, 0);
    int torque = 0;
    cf_step(d->c, "axis %u: a growing torque, direction %+d", d->axis + 1, direction);
    while (!has_moved(d, from) && torque < MOST_TORQUE) {
        torque += TORQUE_STEP;
        (void)drive_set(d, DRIVE_TARGET_TORQUE, 0, direction * torque);
        for (unsigned int i = 0; i < STEP_MS && !has_moved(d, from); i++)
            drive_cycle(d);
    }
    const int64_t way = drive_get(d, DRIVE_ACTUAL, 0) - from;
    if (!has_moved(d, from))
        cf_warn(d->c, "axis %u, %d in 6071h: expected a motion of 6064h, got none", d->axis + 1, direction * torque);
    else
        cf_expect_that(d->c, way * direction > 0,
                       "axis %u, %d in 6071h: expected a motion of 6064h of its sign, got %+lld units", d->axis + 1,
                       direction * torque, (long long)way);
    stop(d);
}

static void need_torque(drive_t *d, int8_t mode, const char *name)
{
    cruise_need_mode(d, mode, name);
    if (!drive_has(d, DRIVE_TARGET_TORQUE, 0))
        cf_skip(d->c, "axis %u has no 6071h", d->axis + 1);
    cruise_ramps(d);
    drive_choose(d, mode);
}

static void push_both(drive_t *d, void (*first)(drive_t *d))
{
    const int direction = cruise_direction(d);
    drive_enable(d);
    first(d);
    push(d, direction);
    drive_enable(d);
    push(d, -direction);
}

/* --- CF-D16 ------------------------------------------------------------------------------------------------------- */

static void slope_is_set(drive_t *d, int slope)
{
    const uint32_t code = drive_set(d, DRIVE_TORQUE_SLOPE, 0, slope);
    cf_expect_that(d->c, code == 0, "axis %u: %d in 6087h: abort 0x%08X", d->axis + 1, slope, code);
}

/* Bit 10 is 0 while the torque is on its slope. */
static void slope(drive_t *d)
{
    cf_step(d->c, "axis %u: %d in 6071h, at %d per mille a second", d->axis + 1, (int)FIRST_TORQUE, (int)SLOPE);
    slope_is_set(d, SLOPE);
    cf_expect_that(d->c, drive_wait(d, DRIVE_REACHED, DRIVE_REACHED, PATIENCE_MS),
                   "axis %u, 0 in 6071h: expected bit 10 of 6041h, got 0x%04X", d->axis + 1, drive_status(d));
    (void)drive_set(d, DRIVE_TARGET_TORQUE, 0, FIRST_TORQUE);
    cf_expect_that(d->c, drive_wait(d, DRIVE_REACHED, 0, PATIENCE_MS * FIRST_TORQUE / SLOPE),
                   "axis %u, torque on its slope: expected bit 10 of 6041h 0, got 0x%04X", d->axis + 1,
                   drive_status(d));
    cf_expect_that(d->c, drive_wait(d, DRIVE_REACHED, DRIVE_REACHED, 2 * PATIENCE_MS),
                   "axis %u, the torque of 6071h: expected bit 10 of 6041h, got 0x%04X", d->axis + 1, drive_status(d));
    slope_is_set(d, 1000 * TORQUE_STEP / STEP_MS);
}

static void profile_torque(drive_t *d)
{
    need_torque(d, DRIVE_TQ, "tq");
    if (!drive_has(d, DRIVE_TORQUE_SLOPE, 0))
        cf_skip(d->c, "axis %u has no 6087h: its torque cannot rise slowly", d->axis + 1);
    push_both(d, slope);
}

void cf_drive_torque(cf_t *c)
{
    drive_each_axis(c, profile_torque);
}

/* --- CF-D17 ------------------------------------------------------------------------------------------------------- */

static void follows_torque(drive_t *d)
{
    follows(d, "cst");
}

static void cyclic_torque(drive_t *d)
{
    need_torque(d, DRIVE_CST, "cst");
    push_both(d, follows_torque);
}

void cf_drive_cyclic_torque(cf_t *c)
{
    drive_each_axis(c, cyclic_torque);
}
