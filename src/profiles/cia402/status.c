/* SPDX-License-Identifier: MIT */
/* Bits 10, 12 and 13 of the status word 6041h, by mode. */
#include "profiles/cia402/axis.h"

enum { STEPS_A_MS = ECT_402_STEPS_PER_S / 1000 };

/* --- windows and their times -------------------------------------------------------------------------------------- */

static uint32_t count(uint32_t steps, bool on)
{
    return !on ? 0 : steps < UINT32_MAX ? steps + 1 : steps;
}

static bool for_ms(uint32_t steps, uint32_t ms)
{
    return steps > 0 && steps >= ms * STEPS_A_MS;
}

static bool is_speed_mode(int8_t mode)
{
    return mode == ECT_402_PV || mode == ECT_402_CSV;
}

static bool reached(const ect_402_axis_t *a)
{
    return a->action == ECT_402_FOLLOW ? ect_402_target_reached(a) : ect_402_standing(a);
}

void ect_402_status_step(ect_402_axis_t *a)
{
    bool slow = ect_402_size(a->plant->speed) <= a->zero_window;
    a->reached_steps = count(a->reached_steps, reached(a));
    a->slow_steps = count(a->slow_steps, slow);
    a->fast_steps = count(a->fast_steps, !slow);
    if (for_ms(a->slow_steps, a->zero_time))
        a->speed_is_zero = true;
    else if (for_ms(a->fast_steps, a->zero_time))
        a->speed_is_zero = false;
}

bool ect_402_reached(const ect_402_axis_t *a)
{
    uint32_t ms = is_speed_mode(a->mode) ? a->speed_time : a->mode == ECT_402_TQ ? 0 : a->position_time;
    if (!reached(a))
        return false;
    return a->action != ECT_402_FOLLOW || ms == 0 || for_ms(a->reached_steps, ms);
}

/* --- bits 10, 12, 13 ---------------------------------------------------------------------------------------------- */

static uint16_t bit(bool on, uint16_t mask)
{
    return on ? mask : 0;
}

/* @return bit 10 in homing mode, a standstill */
static uint16_t homing_bits(const ect_402_axis_t *a)
{
    bool failed = a->homing.error && !a->homing.interrupted;
    bool found = a->homing.done || (a->homing.active && a->homing.returning && a->homing.leg > 0);
    return (uint16_t)(bit(!a->homing.active && ect_402_standing(a), ECT_402_STATUS_TARGET) |
                      bit(found, ECT_402_STATUS_ATTAINED) | bit(failed, ECT_402_STATUS_MODE_ERROR));
}

static bool follows(const ect_402_axis_t *a)
{
    return a->action == ECT_402_FOLLOW && !a->homing.active && !ect_402_limit_acts(a);
}

uint16_t ect_402_mode_bits(const ect_402_axis_t *a)
{
    uint16_t target = bit(ect_402_reached(a), ECT_402_STATUS_TARGET);
    uint16_t error = bit(ect_402_following_late(a), ECT_402_STATUS_MODE_ERROR);
    switch (a->mode) {
    case ECT_402_PP:
        return (uint16_t)(target | bit(a->task_taken, ECT_402_STATUS_ATTAINED) | error);
    case ECT_402_PV:
        return (uint16_t)(target | bit(a->speed_is_zero, ECT_402_STATUS_ATTAINED));
    case ECT_402_NO_MODE:
    case ECT_402_TQ:
        return target;
    case ECT_402_HM:
        return homing_bits(a);
    case ECT_402_IP:
        return (uint16_t)(target | bit(follows(a) && ect_402_ip_active(a), ECT_402_STATUS_ATTAINED) | error);
    case ECT_402_CSP:
        return (uint16_t)(bit(follows(a), ECT_402_STATUS_ATTAINED) | error);
    default: /* cyclic speed and torque */
        return bit(follows(a), ECT_402_STATUS_ATTAINED);
    }
}
