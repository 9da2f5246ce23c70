/* SPDX-License-Identifier: MIT */
/* The variables of SOES's API, and the time. */
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

/* The exchange runs after mainline, and may leave work for mainline. */
uint64_t ect_soes_due(void)
{
    const ect_slave_t *slave = &ect_soes.slave;
    return slave->woken || slave->inputs_due ? ect_soes_now() : ect_soes.due_ns;
}

/* Ignores a step too long for the time between two polls, because the master sets the ESC's time once, by any amount.
 */
void ect_soes_follow_time(uint32_t time)
{
    enum { LONGEST_NS = 1000000000 };
    uint32_t step = time - ect_soes.esc_time;
    ect_soes.esc_time = time;
    ect_soes.now_ns += step < LONGEST_NS ? step : 0;
}
