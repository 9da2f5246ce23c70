/* SPDX-License-Identifier: MIT */
#include "sii/fit.h"

#include "seams/layout.h"
#include "seams/services.h"

/* Byte 3 of the EEPROM, 0x0151: the pin is SYNC0, and SYNC0 is an AL event, by which the stack notices it. */
enum { SYNC0_EVENT = 0x04 | 0x08 };

const ect_fit_t ect_fit_lan9252 = {
    .esc = "lan9252", .ram_bytes = 4096, .sm_count = 4, .fmmu_count = 3, .pdi_control = 0x80, .pdi_config = 0x00};

const ect_fit_t ect_fit_et1100 = {
    .esc = "et1100", .ram_bytes = 8192, .sm_count = 8, .fmmu_count = 8, .pdi_control = 0x08, .pdi_config = 0x00};

/* Process RAM of a SyncManager, also in BOOT, in bytes: whole words, because most buses access words. */
static uint32_t taken(const ect_device_t *device, unsigned int n)
{
    uint32_t boot = n == 0 ? device->boot_out.length : n == 1 ? device->boot_in.length : 0;
    uint32_t bytes = ect_layout_memory(device, n);
    return ((bytes > boot ? bytes : boot) + 3u) & ~3u;
}

bool ect_fit(const ect_device_t *device, const ect_fit_t *controller, ect_device_t *on)
{
    uint32_t end = 0;
    *on = *device;
    on->esc = controller->esc;
    on->esc_config[0] = controller->pdi_control;
    on->esc_config[2] = controller->pdi_config;
    if ((device->sync.supported & (1u << ECT_SYNC_DC_SYNC0)) != 0)
        on->esc_config[3] |= SYNC0_EVENT;
    on->sii = NULL; /* it is an image for the other controller */
    for (unsigned int n = 0; n < device->sm_count; n++) {
        if (ect_layout_in_registers(device, n) || device->sm[n].type == ECT_SM_UNUSED)
            continue;
        on->sm[n].start = (uint16_t)(ECT_RAM + end);
        end += taken(device, n);
    }
    on->boot_out.start = on->sm[0].start;
    on->boot_in.start = on->sm[1].start;
    return device->sm_count <= controller->sm_count && device->fmmu_count <= controller->fmmu_count &&
           end <= controller->ram_bytes;
}
