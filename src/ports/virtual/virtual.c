/* SPDX-License-Identifier: MIT */
#include "ports/virtual/virtual.h"

#include "wire/bytes.h"
#include "wire/registers.h"

static int al_event(void *ctx, uint32_t *event)
{
    *event = ect_esc_al_event(ctx);
    return 0;
}

ect_pdi_t ect_virtual_pdi(ect_esc_t *esc)
{
    return (ect_pdi_t){.ctx = esc, .read = ect_esc_pdi_read, .write = ect_esc_pdi_write, .al_event = al_event};
}

static int line_event(void *ctx, uint32_t *event)
{
    uint8_t bytes[4] = {0};
    int result = ect_esc_line(ctx) ? ect_esc_pdi_read(ctx, ECT_REG_AL_EVENT, bytes, sizeof bytes) : 0;
    *event = ect_load_le32(bytes);
    return result;
}

ect_pdi_t ect_virtual_line_pdi(ect_esc_t *esc)
{
    return (ect_pdi_t){.ctx = esc, .read = ect_esc_pdi_read, .write = ect_esc_pdi_write, .al_event = line_event};
}
