/* SPDX-License-Identifier: MIT */
/* Position and speed controllers, and their limits. Tuned for the motor alone, as after commissioning. */
#include "profiles/cia402/axis.h"

#define POSITION_GAIN 50.0  /* 1/s */
#define SPEED_TIME    0.002 /* s, of the speed controller */
#define INTEGRAL_TIME 0.02  /* s */
#define OVERSPEED     1.2
enum { OVERSPEED_STEPS = ECT_402_STEPS_PER_S / 100 };
#define STANDSTILL (3.0 / 60) /* turns per second */

/* --- controllers -------------------------------------------------------------------------------------------------- */

static bool blocked(const ect_402_axis_t *a, double speed)
{
    return (speed > 0 && !a->level[ECT_402_POSITIVE]) || (speed < 0 && !a->level[ECT_402_NEGATIVE]);
}

static uint16_t least(uint16_t a, uint16_t b)
{
    return a < b ? a : b;
}

/* Limits the torque: 6072h and 6073h in both directions, 60E0h and 60E1h in one each. */
static double limit_torque(const ect_402_axis_t *a, double torque)
{
    uint16_t one_way = torque > 0 ? a->torque_limit[0] : a->torque_limit[1];
    double set = least(least(a->max_torque, a->max_current), one_way) / 1000.0 * a->config->rated_torque;
    return ect_402_within(torque, set < a->config->peak_torque ? set : a->config->peak_torque);
}

/* Stops the shaft on 6085h at a limit switch (DRV-238). A reference run brakes by itself. */
static double at_switch(ect_402_axis_t *a, double speed)
{
    bool hit = blocked(a, speed) && !a->homing.active;
    if (!hit || !a->at_switch)
        a->switch_speed = speed * a->plant->speed > 0 ? a->plant->speed : 0;
    a->at_switch = hit;
    a->switch_speed = ect_402_towards(a->switch_speed, 0, a->quick_deceleration * ECT_402_STEP_S);
    return hit && ect_402_size(a->switch_speed) < ect_402_size(speed) ? a->switch_speed : speed;
}

static double speed_command(ect_402_axis_t *a)
{
    const ect_402_reference_t *r = &a->reference;
    double speed = r->speed;
    if (r->loop == ECT_402_LOOP_POSITION)
        speed += POSITION_GAIN * (r->position - a->plant->position);
    double limited = ect_402_within(speed, ect_402_speed_limit(a));
    a->held |= limited != speed;
    return at_switch(a, limited);
}

/* Integrates only while the torque is below its limit, to prevent wind-up. */
static double speed_controller(ect_402_axis_t *a, double command, double ahead)
{
    double gain = 1.0 / (ect_402_per_nm(a, a->config->inertia) * SPEED_TIME); /* Nm per count/s */
    double error = command - a->plant->speed;
    double torque = gain * error + a->sum + ahead;
    double limited = limit_torque(a, torque);
    a->held |= torque != limited;
    if (torque == limited)
        a->sum += gain * error * ECT_402_STEP_S / INTEGRAL_TIME;
    return limited;
}

/* Follows a torque unless it turns the shaft too fast, or into a limit switch. */
static double torque_controller(ect_402_axis_t *a)
{
    double torque = limit_torque(a, a->reference.torque);
    double speed = a->plant->speed;
    bool faster = ect_402_size(speed) >= ect_402_speed_limit(a) && (speed > 0) == (torque > 0);
    a->held |= faster || torque != a->reference.torque;
    if (blocked(a, torque))
        return speed_controller(a, 0, 0);
    return faster ? speed_controller(a, ect_402_within(speed, ect_402_speed_limit(a)), 0) : torque;
}

/* @return whether the time beyond 6065h exceeds 6066h */
bool ect_402_following_late(const ect_402_axis_t *a)
{
    return a->error_steps > a->error_time * (ECT_402_STEPS_PER_S / 1000u);
}

static void monitor(ect_402_axis_t *a)
{
    const ect_402_reference_t *r = &a->reference;
    double error = r->position - a->plant->position;
    bool window = a->error_window != 0 || a->config->zero_window;
    bool watched = r->loop == ECT_402_LOOP_POSITION && window && !blocked(a, error);
    bool late = watched && ect_402_size(error) > a->error_window;
    a->error_steps = late ? a->error_steps + 1 : 0;
    if (ect_402_following_late(a))
        a->troubles |= ECT_402_LATE;
    bool at_once = a->config->overspeed_at_once;
    double limit = at_once ? ect_402_speed_limit(a) : a->motor_speed / 60.0 * a->config->turn;
    a->over_steps = ect_402_size(a->plant->speed) > OVERSPEED * limit ? a->over_steps + 1 : 0;
    if (a->over_steps > (at_once ? 0u : OVERSPEED_STEPS))
        a->troubles |= ECT_402_OVERSPEED;
}

void ect_402_control(ect_402_axis_t *a)
{
    double ahead = a->reference.loop == ECT_402_LOOP_POSITION ? a->set.ahead / 1000.0 * a->config->rated_torque : 0;
    a->torque_now =
        a->reference.loop == ECT_402_LOOP_TORQUE ? torque_controller(a) : speed_controller(a, speed_command(a), ahead);
    monitor(a);
}

void ect_402_control_off(ect_402_axis_t *a)
{
    a->torque_now = 0;
    a->sum = 0;
    a->error_steps = a->over_steps = 0;
    a->held = false;
    a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_SPEED};
}

bool ect_402_standing(const ect_402_axis_t *a)
{
    return a->reference.speed == 0 && ect_402_size(a->plant->speed) < STANDSTILL * a->config->turn;
}

/* --- standstill --------------------------------------------------------------------------------------------------- */

void ect_402_hold_begin(ect_402_axis_t *a)
{
    a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_POSITION, .position = a->plant->position};
    a->segment_steps = 0;
}

/* Resets the integral part, because that of an acceleration would act against the ramp. */
void ect_402_brake_begin(ect_402_axis_t *a)
{
    a->reference = (ect_402_reference_t){.loop = ECT_402_LOOP_SPEED, .speed = a->plant->speed};
    if (a->sum * a->plant->speed > 0)
        a->sum = 0;
}

void ect_402_brake(ect_402_axis_t *a, double deceleration)
{
    ect_402_reference_t *r = &a->reference;
    if (r->loop == ECT_402_LOOP_POSITION && r->speed == 0)
        return;
    if (r->loop != ECT_402_LOOP_SPEED)
        *r = (ect_402_reference_t){.loop = ECT_402_LOOP_SPEED, .speed = a->plant->speed};
    r->speed = ect_402_towards(r->speed, 0, deceleration * ECT_402_STEP_S);
    if (r->speed == 0 && ect_402_standing(a))
        ect_402_hold_begin(a);
}
