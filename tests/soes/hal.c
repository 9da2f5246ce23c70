/* SPDX-License-Identifier: MIT */
#include "hal.h"

#include <string.h>

hal_t hal;

static uint8_t *emulated(uint16_t address)
{
    if (!hal.emulated || address < ESCREG_EECONTSTAT || address >= ESCREG_EEDATA + sizeof hal.data)
        return NULL;
    return address < ESCREG_EEDATA ? hal.control + (address - ESCREG_EECONTSTAT) : hal.data + (address - ESCREG_EEDATA);
}

/* Each access leaves the events, as the chips do that send them in front of it. */
static void leave_event(uint16_t address, uint16_t length, bool written)
{
    hal.address = address;
    hal.length = length;
    hal.written = written;
    ESCvar.ALevent = ect_esc_al_event(hal.esc) | (hal.emulated ? ESCREG_ALEVENT_EEP : 0u);
}

void ESC_read(uint16_t address, void *buf, uint16_t len)
{
    const uint8_t *own = emulated(address);
    if (own)
        memcpy(buf, own, len);
    else
        (void)ect_esc_pdi_read(hal.esc, address, buf, len);
    if (address == ESCREG_ALEVENT && hal.emulated)
        *(uint8_t *)buf |= ESCREG_ALEVENT_EEP;
    if (address == ESCREG_DLSTATUS && hal.loading > 0) {
        hal.loading--;
        memset(buf, 0, len);
    }
    leave_event(address, len, false);
}

void ESC_write(uint16_t address, void *buf, uint16_t len)
{
    uint8_t *own = emulated(address);
    if (own) {
        memcpy(own, buf, len);
        if (address == ESCREG_EECONTSTAT) { /* acknowledged: no longer busy, the next command is none */
            own[1] &= 0x7F;
            hal.acknowledged++;
        }
    } else {
        (void)ect_esc_pdi_write(hal.esc, address, buf, len);
    }
    leave_event(address, len, true);
}

void ESC_init(const esc_cfg_t *cfg)
{
    hal.user_arg = cfg->user_arg;
}

void ESC_reset(void)
{
    hal.resets++;
}
