/* SPDX-License-Identifier: MIT */
#include "ports/virtual/virtual.h"

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
    return ect_pdi_line_event(ect_esc_line(ctx), ect_esc_pdi_read, ctx, event);
}

ect_pdi_t ect_virtual_line_pdi(ect_esc_t *esc)
{
    return (ect_pdi_t){.ctx = esc, .read = ect_esc_pdi_read, .write = ect_esc_pdi_write, .al_event = line_event};
}
