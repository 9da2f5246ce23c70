/* SPDX-License-Identifier: MIT */
/* The watchdogs of the process data and of the PDI (data sheet I §13). */
#include "esc/internal.h"

/* One tick is (divider + 2) times 40 ns; the times are counted in ticks. */
static uint64_t time_of(const ect_esc_t *esc, uint16_t time_register)
{
    uint64_t tick_ns = (ect_load_le16(esc->memory + ECT_REG_WD_DIVIDER) + 2ull) * 40ull;
    return ect_load_le16(esc->memory + time_register) * tick_ns;
}

void ect_esc_watchdog_trigger(ect_esc_t *esc)
{
    uint64_t time_ns = time_of(esc, ECT_REG_WD_TIME_PD);
    esc->memory[ECT_REG_WD_STATUS_PD] = 1;
    esc->watchdog_ns = time_ns == 0 ? UINT64_MAX : esc->now_ns + time_ns;
    ect_esc_expect(esc, esc->watchdog_ns);
}

static void set_late(ect_esc_t *esc, bool late)
{
    if (esc->pdi_late == late)
        return;
    esc->pdi_late = late;
    ect_esc_update_dl_status(esc);
    ect_esc_led_errors(esc);
}

/* A time of 0 disables the watchdog, and a disabled watchdog has not expired. */
void ect_esc_watchdog_time_written(ect_esc_t *esc)
{
    if (ect_load_le16(esc->memory + ECT_REG_WD_TIME_PD) == 0) {
        esc->memory[ECT_REG_WD_STATUS_PD] = 1;
        esc->watchdog_ns = UINT64_MAX;
    }
    if (ect_load_le16(esc->memory + ECT_REG_WD_TIME_PDI) == 0)
        set_late(esc, false);
    if (esc->pdi_ns != UINT64_MAX)
        ect_esc_expect(esc, esc->now_ns);
    esc->activity++; /* callers that wait for the expiry must recompute its time */
}

void ect_esc_watchdog_pdi(ect_esc_t *esc)
{
    uint64_t time_ns = time_of(esc, ECT_REG_WD_TIME_PDI);
    esc->pdi_ns = esc->config.pdi_watched ? esc->now_ns : UINT64_MAX;
    if (esc->config.pdi_watched && time_ns != 0)
        ect_esc_expect(esc, esc->now_ns + time_ns);
    set_late(esc, false);
}

void ect_esc_watch_pdi(ect_esc_t *esc, bool watched)
{
    esc->config.pdi_watched = watched;
    ect_esc_watchdog_pdi(esc);
}

static void tick_pdi(ect_esc_t *esc)
{
    uint64_t time_ns = esc->pdi_ns == UINT64_MAX ? 0 : time_of(esc, ECT_REG_WD_TIME_PDI);
    if (time_ns == 0)
        return;
    if (esc->now_ns < esc->pdi_ns + time_ns) {
        ect_esc_expect(esc, esc->pdi_ns + time_ns);
        return;
    }
    esc->pdi_ns = UINT64_MAX;
    ect_esc_count(esc, ECT_REG_WD_COUNTER_PDI);
    set_late(esc, true);
}

static void tick_process_data(ect_esc_t *esc)
{
    ECT_ASSERT(esc->watchdog_ns != 0);
    if (esc->now_ns < esc->watchdog_ns) {
        ect_esc_expect(esc, esc->watchdog_ns);
        return;
    }
    esc->watchdog_ns = UINT64_MAX;
    esc->memory[ECT_REG_WD_STATUS_PD] = 0;
    ect_esc_count(esc, ECT_REG_WD_COUNTER_PD);
    ect_esc_raise(esc, ECT_EVENT_WATCHDOG);
    ect_esc_led_errors(esc);
}

void ect_esc_watchdog_tick(ect_esc_t *esc)
{
    tick_process_data(esc);
    tick_pdi(esc);
}
