/* SPDX-License-Identifier: MIT */
/* The process-data watchdog (data sheet I §13). */
#include "esc/internal.h"

/* One tick is (divider + 2) times 40 ns; the time is counted in ticks. */
void ect_esc_watchdog_trigger(ect_esc_t *esc)
{
    uint64_t tick_ns = (ect_load_le16(esc->memory + ECT_REG_WD_DIVIDER) + 2ull) * 40ull;
    uint64_t ticks = ect_load_le16(esc->memory + ECT_REG_WD_TIME_PD);
    esc->memory[ECT_REG_WD_STATUS_PD] = 1;
    esc->watchdog_ns = ticks == 0 ? UINT64_MAX : esc->now_ns + ticks * tick_ns;
}

/* 0 switches it off, and what is off has not expired. */
void ect_esc_watchdog_time_written(ect_esc_t *esc)
{
    if (ect_load_le16(esc->memory + ECT_REG_WD_TIME_PD) != 0)
        return;
    esc->memory[ECT_REG_WD_STATUS_PD] = 1;
    esc->watchdog_ns = UINT64_MAX;
}

void ect_esc_watchdog_tick(ect_esc_t *esc)
{
    ECT_ASSERT(esc->watchdog_ns != 0);
    if (esc->now_ns < esc->watchdog_ns)
        return;
    esc->watchdog_ns = UINT64_MAX;
    esc->memory[ECT_REG_WD_STATUS_PD] = 0;
    ect_esc_count(esc, ECT_REG_WD_COUNTER_PD);
    ect_esc_raise(esc, ECT_EVENT_WATCHDOG);
}
