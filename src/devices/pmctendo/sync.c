/* SPDX-License-Identifier: MIT */
/*
 * The cyclic rhythm (manual §4.3.4, §4.8): SYNC0 if the clocks run, else the outputs of the master. Without a rhythm,
 * warning n17 is on and OP is refused; a loss of the rhythm in OP is fault F28.
 */
#include "devices/pmctendo/instance.h"

enum { ENOUGH = 4, MEASURED = 16, MS_NS = 1000000 };

/* @return whether the rate of the rhythm is checked: always for SYNC0, which is a clock; for frames only with
 * sync_tolerance */
bool pmc_sync_is_clocked(const pmctendo_t *u)
{
    return u->sync_data.dc != 0 || u->plant.sync_tolerance_ppm != 0;
}

/* @return whether the last event is older than sync_patience */
static bool overdue(const pmctendo_t *u, uint64_t now_ns)
{
    uint64_t patience_ns = (uint64_t)u->plant.sync_patience_ms * MS_NS;
    return patience_ns != 0 && now_ns - u->sync.last_ns > patience_ns;
}

/* @return the cycle time of 60C2h */
static uint64_t cycle_ns(const pmctendo_t *u)
{
    uint64_t ns = u->cycle_units;
    for (int power = u->cycle_power; power > -9; power--)
        ns *= 10;
    return ns;
}

uint32_t pmc_cycle_steps(const pmctendo_t *u)
{
    uint64_t ns = cycle_ns(u);
    return ns % PMC_STEP_NS == 0 && ns <= 1000ull * MS_NS ? (uint32_t)(ns / PMC_STEP_NS) : 0;
}

static void lose(pmctendo_t *u)
{
    u->sync.synchronised = false;
    u->sync.good = u->sync.measured = 0;
    pmc_warn(u, PMC_N_SYNC, true);
}

void pmc_sync_lose(pmctendo_t *u)
{
    lose(u);
    u->sync.last_ns = 0;
}

/* @return whether this event follows the last one in time */
static bool in_order(const pmctendo_t *u, uint64_t now_ns)
{
    if (!pmc_sync_is_clocked(u))
        return true;
    if (u->sync.last_ns == 0 || overdue(u, now_ns) || pmc_cycle_steps(u) == 0)
        return false;
    return u->sync_data.dc == 0 || u->sync_data.cycle_ns == cycle_ns(u);
}

/* Compares the mean of several cycles with 60C2h. */
static bool in_tolerance(const pmctendo_t *u, uint64_t now_ns)
{
    uint64_t want = MEASURED * cycle_ns(u);
    uint64_t is = now_ns - u->sync.first_ns;
    uint64_t off = is > want ? is - want : want - is;
    return off * 1000000 <= want * u->plant.sync_tolerance_ppm;
}

static bool rate_is_right(pmctendo_t *u, uint64_t now_ns)
{
    pmc_sync_t *s = &u->sync;
    if (u->plant.sync_tolerance_ppm == 0 || u->sync_data.dc != 0 || ++s->measured < MEASURED)
        return true;
    bool right = in_tolerance(u, now_ns);
    s->measured = 0;
    s->first_ns = now_ns;
    return right;
}

void pmc_sync_event(pmctendo_t *u, uint8_t events, uint64_t now_ns)
{
    pmc_sync_t *s = &u->sync;
    uint8_t counts = u->sync_data.dc != 0 ? ECT_CYCLIC_SYNC0 : ECT_CYCLIC_OUTPUTS;
    unsigned int enough = !pmc_sync_is_clocked(u) ? 1 : u->sync_data.dc != 0 ? ENOUGH : MEASURED;
    if ((events & counts) == 0)
        return;
    if (!in_order(u, now_ns)) {
        lose(u);
        s->first_ns = now_ns;
    } else if (!rate_is_right(u, now_ns)) {
        lose(u);
    } else if (s->good < enough) {
        s->good++;
        if (s->good == enough) {
            s->synchronised = true;
            pmc_warn(u, PMC_N_SYNC, false);
        }
    }
    s->last_ns = now_ns;
}

void pmc_sync_wait(pmctendo_t *u, uint64_t now_ns)
{
    if (u->sync.op_until_ns == ECT_NEVER)
        u->sync.op_until_ns = now_ns + (uint64_t)u->plant.sync_timeout_ms * MS_NS;
}

static void end_waiting(pmctendo_t *u, uint16_t code)
{
    u->sync.op_until_ns = ECT_NEVER;
    if (code != ECT_AL_NO_ERROR)
        pmc_fault(u, PMC_F_SYNC);
    u->host->transition_done(u->host->ctx, code);
}

void pmc_sync_due(pmctendo_t *u, uint64_t now_ns)
{
    pmc_sync_t *s = &u->sync;
    if (s->synchronised && overdue(u, now_ns))
        pmc_sync_lose(u);
    if (s->op_until_ns != ECT_NEVER && s->synchronised)
        end_waiting(u, ECT_AL_NO_ERROR);
    else if (now_ns >= s->op_until_ns)
        end_waiting(u, ECT_AL_SYNC);
    if (!s->synchronised && u->axis.live) {
        pmc_fault(u, PMC_F_SYNC);
        u->host->drop(u->host->ctx, ECT_STATE_SAFEOP, ECT_AL_SYNC);
    }
}

uint64_t pmc_sync_next(const pmctendo_t *u)
{
    const pmc_sync_t *s = &u->sync;
    uint64_t patience_ns = (uint64_t)u->plant.sync_patience_ms * MS_NS;
    uint64_t lost = s->synchronised && patience_ns != 0 ? s->last_ns + patience_ns + 1 : ECT_NEVER;
    return lost < s->op_until_ns ? lost : s->op_until_ns;
}
