/* SPDX-License-Identifier: MIT */
/* The PDI, with one rule for its failures: the first one ends what a poll may try. */
#include "slave/internal.h"

static bool fail(ect_slave_t *s)
{
    s->pdi_errors += s->failed ? 0u : 1u;
    s->failed = true;
    return false;
}

bool ect_slave_read(ect_slave_t *s, uint16_t address, void *buffer, uint16_t length)
{
    const ect_pdi_t *pdi = s->config.pdi;
    ECT_ASSERT(buffer && length > 0);
    return (!s->failed && pdi->read(pdi->ctx, address, buffer, length) >= 0) || fail(s);
}

bool ect_slave_write(ect_slave_t *s, uint16_t address, const void *buffer, uint16_t length)
{
    const ect_pdi_t *pdi = s->config.pdi;
    ECT_ASSERT(buffer && length > 0);
    return (!s->failed && pdi->write(pdi->ctx, address, buffer, length) >= 0) || fail(s);
}

/* With a line that not all events may raise, only the register knows them. */
bool ect_slave_read_event(ect_slave_t *s, uint32_t *event)
{
    const ect_pdi_t *pdi = s->config.pdi;
    uint8_t bytes[4];
    s->failed = false;
    if (pdi->al_event && !s->config.line_for_cycle)
        return pdi->al_event(pdi->ctx, event) >= 0 || fail(s);
    if (!ect_slave_read(s, ECT_REG_AL_EVENT, bytes, sizeof bytes))
        return false;
    *event = ect_load_le32(bytes);
    return true;
}
