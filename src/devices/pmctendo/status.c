/* SPDX-License-Identifier: MIT */
/* The status word 6041h: bits 10, 12 and 13 of the manual, or of CiA 402-2 (`status_bits=402`). */
#include "devices/pmctendo/instance.h"

enum { STEPS_A_MS = PMC_STEPS_PER_S / 1000 };

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
    return mode == PMC_MODE_SPEED_RAMP || mode == PMC_MODE_SPEED;
}

static bool reached(const pmctendo_t *u)
{
    return u->action == ECT_402_FOLLOW ? pmc_target_reached(u) : pmc_standing(u);
}

void pmc_status_step(pmctendo_t *u)
{
    bool slow = pmc_size(u->plant.speed) <= u->zero_window;
    u->reached_steps = count(u->reached_steps, reached(u));
    u->slow_steps = count(u->slow_steps, slow);
    u->fast_steps = count(u->fast_steps, !slow);
    if (for_ms(u->slow_steps, u->zero_time))
        u->speed_is_zero = true;
    else if (for_ms(u->fast_steps, u->zero_time))
        u->speed_is_zero = false;
}

static bool target_reached(const pmctendo_t *u)
{
    uint32_t ms = is_speed_mode(pmc_mode(u)) ? u->speed_time : u->position_time;
    if (!reached(u))
        return false;
    return u->action != ECT_402_FOLLOW || ms == 0 || for_ms(u->reached_steps, ms);
}

/* --- bits 10, 12, 13 ---------------------------------------------------------------------------------------------- */

static uint16_t bit(bool on, uint16_t mask)
{
    return on ? mask : 0;
}

static uint16_t manual_bits(const pmctendo_t *u)
{
    return (uint16_t)(bit(target_reached(u), ECT_402_STATUS_TARGET) | bit(u->homing.active, PMC_STATUS_REFERENCING) |
                      bit(u->homing.error, PMC_STATUS_REFERENCE_ERROR));
}

/* In homing mode bit 10 is a standstill. */
static uint16_t homing_bits(const pmctendo_t *u)
{
    bool failed = u->homing.error && !u->homing.interrupted;
    return (uint16_t)(bit(!u->homing.active && pmc_standing(u), ECT_402_STATUS_TARGET) |
                      bit(u->homing.done, ECT_402_STATUS_ATTAINED) | bit(failed, ECT_402_STATUS_MODE_ERROR));
}

static bool follows(const pmctendo_t *u)
{
    return u->action == ECT_402_FOLLOW && !u->homing.active && !pmc_limit_acts(u);
}

static uint16_t profile_bits(const pmctendo_t *u)
{
    uint16_t target = bit(target_reached(u), ECT_402_STATUS_TARGET);
    uint16_t error = bit(pmc_following_late(u), ECT_402_STATUS_MODE_ERROR);
    switch (pmc_mode(u)) {
    case PMC_MODE_TASK:
        return (uint16_t)(target | bit(u->task_taken, ECT_402_STATUS_ATTAINED) | error);
    case PMC_MODE_SPEED_RAMP:
        return (uint16_t)(target | bit(u->speed_is_zero, ECT_402_STATUS_ATTAINED));
    case PMC_MODE_HOMING:
        return homing_bits(u);
    case PMC_MODE_INTERPOLATED:
        return (uint16_t)(target | bit(follows(u), ECT_402_STATUS_ATTAINED) | error);
    case PMC_MODE_POSITION:
        return (uint16_t)(bit(follows(u), ECT_402_STATUS_ATTAINED) | error);
    default: /* cyclic speed and torque */
        return bit(follows(u), ECT_402_STATUS_ATTAINED);
    }
}

uint16_t pmc_status(const pmctendo_t *u)
{
    bool stop = !u->level[PMC_PSTOP] || !u->level[PMC_NSTOP];
    uint16_t mode = u->plant.status_bits == PMC_STATUS_402 ? profile_bits(u) : manual_bits(u);
    return (uint16_t)(ect_402_status(u->state, &u->ds) | bit(u->plant.power, ECT_402_STATUS_VOLTAGE) |
                      bit(u->warnings != 0, ECT_402_STATUS_WARNING) | bit(u->live, ECT_402_STATUS_REMOTE) |
                      bit(pmc_limit_acts(u) || stop, ECT_402_STATUS_LIMIT) | bit(pmc_task_active(u), PMC_STATUS_TASK) |
                      mode);
}
