/* SPDX-License-Identifier: MIT */
/* A hardware file of SOES over the PDI of a board, for SOES's stack, and for the calls of its API.
 */
#include <string.h>

#include "board.h"
#include "esc.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* SOES's API has no failed accesses: a failed read returns 0; a failed write is repeated by its caller, because the
 * event remains pending. */
static void take_event(const ect_pdi_t *pdi)
{
    uint8_t bytes[4] = {0};
    uint32_t event = 0;
    if (pdi->al_event) {
        if (pdi->al_event(pdi->ctx, &event) < 0)
            event = 0;
    } else if (pdi->read(pdi->ctx, ECT_REG_AL_EVENT, bytes, sizeof bytes) >= 0) {
        event = ect_load_le32(bytes);
    }
    ESCvar.ALevent = event;
}

void ESC_read(uint16_t address, void *buf, uint16_t len)
{
    const ect_pdi_t *pdi = board_pdi();
    if (pdi->read(pdi->ctx, address, buf, len) < 0)
        memset(buf, 0, len);
    take_event(pdi);
}

void ESC_write(uint16_t address, void *buf, uint16_t len)
{
    const ect_pdi_t *pdi = board_pdi();
    (void)pdi->write(pdi->ctx, address, buf, len);
    take_event(pdi);
}

void ESC_init(const esc_cfg_t *cfg)
{
    (void)cfg; /* board_init has done it */
}

void ESC_reset(void)
{
}
