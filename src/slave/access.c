/* SPDX-License-Identifier: MIT */
/* The PDI, with one rule for its failures: after the first one, the poll makes no further access. */
#include "slave/internal.h"

static bool done(ect_slave_t *s, int result)
{
    if (result >= 0)
        return true;
    s->pdi_errors++;
    s->failed = true;
    return false;
}

bool ect_slave_read(ect_slave_t *s, unsigned int address, void *buffer, unsigned int length)
{
    const ect_pdi_t *pdi = s->config.pdi;
    ECT_ASSERT(buffer && length > 0);
    return !s->failed && done(s, pdi->read(pdi->ctx, (uint16_t)address, buffer, (uint16_t)length));
}

bool ect_slave_write(ect_slave_t *s, unsigned int address, const void *buffer, unsigned int length)
{
    const ect_pdi_t *pdi = s->config.pdi;
    ECT_ASSERT(buffer && length > 0);
    return !s->failed && done(s, pdi->write(pdi->ctx, (uint16_t)address, buffer, (uint16_t)length));
}

/* When the line does not signal all events, only the register shows them. */
bool ect_slave_read_event(ect_slave_t *s, uint32_t *event)
{
    const ect_pdi_t *pdi = s->config.pdi;
    uint8_t bytes[4];
    s->failed = false;
    if (pdi->al_event && !s->config.line_for_cycle)
        return done(s, pdi->al_event(pdi->ctx, event));
    if (!ect_slave_read(s, ECT_REG_AL_EVENT, bytes, sizeof bytes))
        return false;
    *event = ect_load_le32(bytes);
    return true;
}
