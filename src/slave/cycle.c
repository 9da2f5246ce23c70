/* SPDX-License-Identifier: MIT */
/*
 * The cyclic exchange: outputs in, inputs out. Only this may run in an interrupt (docs/CONCURRENCY.md). Mainline works
 * in steps and holds the exchange during each; a held exchange is executed at the end of the step.
 */
#include <stdatomic.h>

#include "slave/internal.h"

void ect_cycle_outputs(ect_slave_t *s, uint32_t event)
{
    if (s->state < ECT_STATE_SAFEOP)
        return;
    ect_services_event(s, event);
    unsigned int sms = ((event / ECT_EVENT_SM0) & 0xFF) | ect_pdo_written(s);
    ECT_ASSERT((s->outputs & s->inputs) == 0);
    if ((sms & s->outputs) != 0)
        ect_pdo_outputs(s, sms & s->outputs, s->outputs_live);
    if ((sms & s->inputs) != 0 && s->config.device->inputs_read)
        s->config.device->inputs_read(s->config.instance, s->now_ns);
    if ((sms & (s->outputs | s->inputs)) != 0)
        s->inputs_due = true;
}

void ect_cycle_inputs(ect_slave_t *s)
{
    if (s->state >= ECT_STATE_SAFEOP && s->inputs_due && !s->inputs_held && ect_pdo_inputs(s))
        s->inputs_due = false;
}

/* Preserves the state of mainline, above all whether its accesses failed. */
static void exchange(ect_slave_t *s)
{
    ECT_ASSERT(s->state != 0);
    bool failed = s->failed;
    uint32_t event = 0;
    s->missed = false;
    if (s->state >= ECT_STATE_SAFEOP && ect_slave_read_event(s, &event)) {
        ect_cycle_outputs(s, event);
        ect_cycle_inputs(s);
    }
    s->failed = failed;
}

void ect_slave_cycle(ect_slave_t *s, uint64_t now_ns)
{
    if (s->held) {
        s->missed = true;
        return;
    }
    s->now_ns = now_ns;
    exchange(s);
}

/*
 * The exchange interrupts mainline and runs to its end; never the other way round, and never on another processor. One
 * flag therefore holds it, and the fences only need to bind the compiler.
 */
void ect_cycle_hold(ect_slave_t *s)
{
    s->held = true;
    atomic_signal_fence(memory_order_seq_cst);
}

void ect_cycle_yield(ect_slave_t *s)
{
    ECT_ASSERT(s->held);
    if (s->missed)
        exchange(s);
}

void ect_cycle_release(ect_slave_t *s)
{
    do {
        ect_cycle_hold(s);
        ect_cycle_yield(s);
        atomic_signal_fence(memory_order_seq_cst);
        s->held = false;
    } while (s->missed);
}
