/* SPDX-License-Identifier: MIT */
#include "slave/indicator.h"

#define MS 1000000ull

const char *ect_pattern_name(ect_pattern_t pattern)
{
    static const char *const names[] = {"off", "on", "flickering", "blinking", "single flash", "double flash"};
    return names[pattern];
}

bool ect_pattern_lit(ect_pattern_t pattern, uint64_t now_ns)
{
    uint64_t ms = now_ns / MS;
    switch (pattern) {
    case ECT_PATTERN_ON:
        return true;
    case ECT_PATTERN_FLICKERING:
        return ms % 100 < 50;
    case ECT_PATTERN_BLINKING:
        return ms % 400 < 200;
    case ECT_PATTERN_SINGLE_FLASH:
        return ms % 1200 < 200;
    case ECT_PATTERN_DOUBLE_FLASH:
        return ms % 1600 < 200 || (ms % 1600 >= 400 && ms % 1600 < 600);
    default:
        return false;
    }
}

ect_pattern_t ect_indicator_run(const ect_slave_t *slave)
{
    switch (slave->state) {
    case ECT_STATE_PREOP:
        return ECT_PATTERN_BLINKING;
    case ECT_STATE_BOOT:
        return ECT_PATTERN_FLICKERING;
    case ECT_STATE_SAFEOP:
        return ECT_PATTERN_SINGLE_FLASH;
    case ECT_STATE_OP:
        return ECT_PATTERN_ON;
    default:
        return ECT_PATTERN_OFF;
    }
}

/* The most severe first: critical, watchdog, local, configuration. */
ect_pattern_t ect_indicator_err(const ect_slave_t *slave, bool pdi_failing)
{
    if (pdi_failing)
        return ECT_PATTERN_ON;
    switch (slave->cause) {
    case ECT_CAUSE_WATCHDOG:
        return ECT_PATTERN_DOUBLE_FLASH;
    case ECT_CAUSE_LOCAL:
        return ECT_PATTERN_SINGLE_FLASH;
    case ECT_CAUSE_REQUEST:
        return ECT_PATTERN_BLINKING;
    default:
        return ECT_PATTERN_OFF;
    }
}

ect_pattern_t ect_indicator_link(bool link, uint64_t last_traffic_ns, uint64_t now_ns)
{
    if (!link)
        return ECT_PATTERN_OFF;
    return last_traffic_ns != 0 && now_ns - last_traffic_ns < ECT_INDICATOR_TRAFFIC_NS ? ECT_PATTERN_FLICKERING
                                                                                       : ECT_PATTERN_ON;
}

/* The unit of all flash patterns. */
static uint64_t next_change(ect_pattern_t pattern, uint64_t now_ns)
{
    uint64_t step_ns = (pattern == ECT_PATTERN_FLICKERING ? 50 : 200) * MS;
    bool steady = pattern == ECT_PATTERN_OFF || pattern == ECT_PATTERN_ON;
    return steady ? ECT_NEVER : (now_ns / step_ns + 1) * step_ns;
}

uint64_t ect_indicator_drive(const ect_slave_t *slave, const ect_leds_t *leds, bool pdi_failing, uint64_t now_ns)
{
    ect_pattern_t run = ect_indicator_run(slave);
    ect_pattern_t err = ect_indicator_err(slave, pdi_failing);
    uint64_t run_ns = leds->run ? next_change(run, now_ns) : ECT_NEVER;
    uint64_t err_ns = leds->err ? next_change(err, now_ns) : ECT_NEVER;
    if (leds->run)
        leds->run(leds->ctx, ect_pattern_lit(run, now_ns));
    if (leds->err)
        leds->err(leds->ctx, ect_pattern_lit(err, now_ns));
    return ect_earlier(run_ns, err_ns);
}
