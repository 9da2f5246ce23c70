/* SPDX-License-Identifier: MIT */
/*
 * The local clock: an oscillator with a frequency error, and its correction by the control loop of the distributed
 * clocks. The clock is a straight line from a point on: at `real_ns` the local time was `local_ns`, and it gains a
 * number of ns a second.
 */
#include "esc/internal.h"

enum { GIGA = 1000000000 };

/* Gain of a clock of `ppb` after `elapsed`, rounded down; *fraction, in 1e-9 ns, is carried over. */
static int64_t gained(uint64_t elapsed_ns, int32_t ppb, int64_t *fraction)
{
    int64_t rest = (int64_t)(elapsed_ns % GIGA) * ppb + *fraction;
    int64_t whole = rest / GIGA;
    if (rest % GIGA < 0)
        whole--;
    *fraction = rest - whole * GIGA;
    return (int64_t)(elapsed_ns / GIGA) * ppb + whole;
}

/* A point of the clock's line, at or after its first one. */
static ect_esc_clock_t at(const ect_esc_clock_t *clock, uint64_t real_ns)
{
    ect_esc_clock_t c = *clock;
    if (c.slew_ppb != 0 && real_ns >= c.slew_end_ns) {
        uint64_t elapsed_ns = c.slew_end_ns - c.real_ns;
        c.local_ns += elapsed_ns + (uint64_t)gained(elapsed_ns, c.drift_ppb + c.trim_ppb + c.slew_ppb, &c.fraction);
        c.real_ns = c.slew_end_ns;
        c.slew_ppb = 0;
    }
    uint64_t elapsed_ns = real_ns - c.real_ns;
    c.local_ns += elapsed_ns + (uint64_t)gained(elapsed_ns, c.drift_ppb + c.trim_ppb + c.slew_ppb, &c.fraction);
    c.real_ns = real_ns;
    return c;
}

uint64_t ect_esc_local_at(const ect_esc_t *esc, uint64_t real_ns)
{
    const ect_esc_clock_t *c = &esc->clock;
    ECT_ASSERT(real_ns >= c->real_ns);
    if ((c->drift_ppb | c->trim_ppb | c->slew_ppb) == 0)
        return c->local_ns + (real_ns - c->real_ns);
    return at(c, real_ns).local_ns;
}

uint64_t ect_esc_system_time(const ect_esc_t *esc, uint64_t now_ns)
{
    return ect_esc_local_at(esc, now_ns) + ect_load_le64(esc->memory + ECT_REG_DC_OFFSET);
}

uint64_t ect_esc_frame_time(const ect_esc_t *esc)
{
    return ect_esc_local_at(esc, esc->now_ns + esc->arrival.unit_ns);
}

/* The gain is small, so each step leaves a thousandth of the previous error. In the end only rounding errors remain,
 * and the result must be exact. */
uint64_t ect_esc_real_after(const ect_esc_t *esc, uint64_t wait_ns)
{
    enum { STEPS = 6 };
    if (wait_ns > UINT64_MAX / 2 - esc->now_ns)
        return UINT64_MAX;
    uint64_t here_ns = ect_esc_local_at(esc, esc->now_ns);
    uint64_t at_ns = esc->now_ns + wait_ns;
    for (unsigned int step = 0; step < STEPS; step++)
        at_ns += wait_ns - (ect_esc_local_at(esc, at_ns) - here_ns);
    return ect_esc_local_at(esc, at_ns) - here_ns < wait_ns ? at_ns + 1 : at_ns;
}

void ect_esc_clock_reset(ect_esc_t *esc)
{
    esc->clock = (ect_esc_clock_t){.real_ns = esc->now_ns, .drift_ppb = esc->config.drift_ppb};
}

void ect_esc_clock_rebase(ect_esc_t *esc)
{
    esc->clock = at(&esc->clock, esc->now_ns);
}
