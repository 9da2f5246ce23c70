/* SPDX-License-Identifier: MIT */
/* Power-on reset, time, and the side of the slave's microcontroller. */
#include <string.h>

#include "esc/internal.h"

static void write_identity(ect_esc_t *esc)
{
    const ect_esc_personality_t *p = esc->config.personality;
    uint8_t *m = esc->memory;
    m[ECT_REG_TYPE] = p->type;
    m[ECT_REG_TYPE + 1] = p->revision;
    ect_store_le16(m + ECT_REG_BUILD, p->build);
    m[ECT_REG_FMMU_COUNT] = p->fmmu_count;
    m[ECT_REG_SM_COUNT] = p->sm_count;
    m[ECT_REG_RAM_SIZE] = p->ram_kb;
    m[ECT_REG_PORTS] = p->port_types;
    ect_store_le16(m + ECT_REG_FEATURES, p->features);
}

static void reset_registers(ect_esc_t *esc)
{
    uint8_t *m = esc->memory;
    ect_store_le32(m + ECT_REG_DL_CONTROL, 0x00070001);
    ect_store_le16(m + ECT_REG_AL_CONTROL, 0x0001);
    ect_store_le16(m + ECT_REG_AL_STATUS, 0x0001);
    ect_store_le32(m + ECT_REG_AL_EVENT_MASK, 0x00FFFF0F);
    ect_store_le16(m + ECT_REG_WD_DIVIDER, 0x09C2);
    ect_store_le16(m + ECT_REG_WD_TIME_PDI, 0x03E8);
    ect_store_le16(m + ECT_REG_WD_TIME_PD, 0x03E8);
    if (ect_esc_dc_present(esc)) {
        ect_store_le16(m + ECT_REG_DC_SPEED_START, 0x1000);
        ect_store_le16(m + ECT_REG_DC_FILTER, 0x0C04);
    }
    for (unsigned int n = 0; n < esc->config.personality->sm_count; n++)
        ect_esc_sm_reset(esc, n);
}

static int check(const ect_esc_config_t *config)
{
    const ect_esc_personality_t *p = config->personality;
    if (!p || p->fmmu_count > ECT_ESC_MAX_FMMU || p->sm_count > ECT_ESC_MAX_SM || p->ram_kb == 0 || p->ram_kb > 60 ||
        p->sii_read > 8)
        return -1;
    if (!config->memory)
        return -2;
    if (config->sii_size % 2 != 0 || (config->sii_size > 0) != (config->sii != NULL))
        return -3;
    return 0;
}

int ect_esc_init(ect_esc_t *esc, const ect_esc_config_t *config, uint64_t now_ns)
{
    ECT_ASSERT(esc && config);
    int error = check(config);
    if (error != 0)
        return error;
    const ect_esc_config_t own = *config; /* it may be the one that lies in here */
    memset(esc, 0, sizeof *esc);
    esc->config = own;
    esc->config.open_ports |= 1u;
    esc->memory = own.memory;
    esc->memory_size = (uint32_t)ECT_ESC_MEMORY_SIZE(own.personality->ram_kb);
    esc->now_ns = now_ns;
    esc->power_on_ns = now_ns;
    esc->sync0_ns = UINT64_MAX;
    esc->watchdog_ns = UINT64_MAX;
    memset(esc->memory, 0, esc->memory_size);
    write_identity(esc);
    reset_registers(esc);
    ect_esc_sii_load(esc, true);
    ect_esc_clear_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
    return 0;
}

int ect_esc_pdi_read(void *esc, uint16_t address, void *buffer, uint16_t length)
{
    ECT_ASSERT(esc && buffer);
    ect_access_t access = {.side = ECT_SIDE_PDI, .write = false, .data = buffer};
    memset(buffer, 0, length);
    (void)ect_esc_access(esc, &access, address, length);
    return 0;
}

int ect_esc_pdi_write(void *esc, uint16_t address, const void *buffer, uint16_t length)
{
    ECT_ASSERT(esc && buffer);
    /* A write only reads through `data` (internal.h). */
    ect_access_t access = {.side = ECT_SIDE_PDI, .write = true, .data = (uint8_t *)(uintptr_t)buffer};
    (void)ect_esc_access(esc, &access, address, length);
    return 0;
}

uint64_t ect_esc_tick(ect_esc_t *esc, uint64_t now_ns)
{
    ECT_ASSERT(now_ns >= esc->now_ns);
    esc->now_ns = now_ns;
    ect_esc_watchdog_tick(esc);
    ect_esc_sii_tick(esc);
    uint64_t next = esc->watchdog_ns;
    if (esc->sii_command != 0 && esc->sii_done_ns < next)
        next = esc->sii_done_ns;
    uint64_t sync0_ns = ect_esc_dc_tick(esc);
    return sync0_ns < next ? sync0_ns : next;
}

uint32_t ect_esc_al_event(const ect_esc_t *esc)
{
    return ect_load_le32(esc->memory + ECT_REG_AL_EVENT);
}

bool ect_esc_line(const ect_esc_t *esc)
{
    return (ect_esc_al_event(esc) & ect_load_le32(esc->memory + ECT_REG_AL_EVENT_MASK)) != 0;
}
