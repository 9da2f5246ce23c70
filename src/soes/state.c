/* SPDX-License-Identifier: MIT */
/* The variables that SOES's API has by definition, and the time. */
#include "soes/ect_soes.h"
#include "soes/internal.h"

_ESCvar ESCvar;
ect_soes_t ect_soes;

void ect_soes_clock(uint64_t (*now_ns)(void))
{
    ect_soes.clock = now_ns;
}

uint64_t ect_soes_now(void)
{
    return ect_soes.clock ? ect_soes.clock() : ect_soes.now_ns;
}

/* The exchange comes after mainline, and may leave it something to do. */
uint64_t ect_soes_due(void)
{
    const ect_slave_t *slave = &ect_soes.slave;
    return slave->woken || slave->inputs_due ? ect_soes_now() : ect_soes.due_ns;
}

/* The master sets the ESC's time once, by any amount: what cannot be the time between two polls is not counted. */
void ect_soes_follow_time(uint32_t time)
{
    enum { LONGEST_NS = 1000000000 };
    uint32_t step = time - ect_soes.esc_time;
    ect_soes.esc_time = time;
    ect_soes.now_ns += step < LONGEST_NS ? step : 0;
}
