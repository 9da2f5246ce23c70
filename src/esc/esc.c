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

static int check(const ect_esc_config_t *config)
{
    const ect_esc_personality_t *p = config->personality;
    if (!p || p->fmmu_count > ECT_ESC_MAX_FMMU || p->sm_count > ECT_ESC_MAX_SM || p->ram_kb == 0 || p->ram_kb > 60 ||
        p->sii_read > 8)
        return -1;
    if (!config->memory)
        return -2;
    if (config->sii_size % 2 != 0 || (config->sii_size > 0) != (config->sii != NULL) ||
        (config->sii_emulated && (config->sii || (p->units & ECT_UNIT_SII_EMULATION) == 0)))
        return -3;
    return 0;
}

/* Writes only bytes that are not zero already, so that untouched pages of a thousand controllers stay unallocated. */
static void wipe(uint8_t *bytes, size_t count)
{
    static const uint8_t zeros[64] = {0};
    for (size_t i = 0; i < count; i += sizeof zeros) {
        if (memcmp(bytes + i, zeros, sizeof zeros) != 0)
            memset(bytes + i, 0, sizeof zeros);
    }
}

/* Resets all state except the configuration and the counters that outlast a reset. */
static void reset(ect_esc_t *esc, uint64_t now_ns)
{
    esc->now_ns = now_ns;
    esc->next_ns = UINT64_MAX;
    esc->watchdog_ns = UINT64_MAX;
    esc->pdi_ns = UINT64_MAX;
    esc->mii_done_ns = UINT64_MAX;
    esc->loops_revert_ns = UINT64_MAX;
    wipe(esc->memory, esc->memory_size); /* a multiple of 1 KB */
    ect_esc_clock_reset(esc);
    ect_esc_sync_reset(esc);
    write_identity(esc);
    ect_esc_registers_reset(esc);
    for (unsigned int n = 0; n < esc->config.personality->sm_count; n++)
        ect_esc_sm_reset(esc, n);
    ect_esc_sii_load(esc, true);
    ect_esc_clear_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
}

static void clear(ect_esc_t *esc, const ect_esc_config_t *config)
{
    memset(esc, 0, sizeof *esc);
    esc->config = *config;
    esc->config.open_ports |= 1u;
    esc->memory = config->memory;
    esc->memory_size = (uint32_t)ECT_ESC_MEMORY_SIZE(config->personality->ram_kb);
}

int ect_esc_init(ect_esc_t *esc, const ect_esc_config_t *config, uint64_t now_ns)
{
    ECT_ASSERT(esc && config);
    int error = check(config);
    if (error != 0)
        return error;
    const ect_esc_config_t own = *config; /* `config` may point into this instance */
    clear(esc, &own);
    reset(esc, now_ns);
    return 0;
}

void ect_esc_access_ends(ect_esc_t *esc)
{
    if (!ect_esc_reset_due(esc))
        return;
    const ect_esc_config_t config = esc->config;
    uint64_t now_ns = esc->now_ns;
    uint32_t sii_writes = esc->sii_writes;
    uint32_t resets = esc->resets;
    uint32_t activity = esc->activity;
    uint32_t routing = esc->routing;
    const ect_esc_arrival_t arrival = esc->arrival;
    clear(esc, &config);
    esc->arrival = arrival;
    reset(esc, now_ns);
    esc->sii_writes = sii_writes;
    esc->resets = resets + 1;
    esc->activity = activity + 1;
    esc->routing = routing + 1;
}

/* Only a few instructions, because it runs at every access, at least twice a cycle. */
static void pdi_begins(ect_esc_t *esc)
{
    if (esc->config.pdi_watched)
        ect_esc_watchdog_pdi(esc);
    if (esc->reset_step[ECT_SIDE_PDI] != 0)
        ect_esc_protect_begins(esc, ECT_SIDE_PDI);
}

int ect_esc_pdi_read(void *esc, uint16_t address, void *buffer, uint16_t length)
{
    ECT_ASSERT(esc && buffer);
    ect_access_t access = {.side = ECT_SIDE_PDI, .write = false, .data = buffer};
    memset(buffer, 0, length);
    pdi_begins(esc);
    (void)ect_esc_access(esc, &access, address, length);
    return 0;
}

int ect_esc_pdi_write(void *esc, uint16_t address, const void *buffer, uint16_t length)
{
    ECT_ASSERT(esc && buffer);
    /* A write only reads through `data` (internal.h). */
    ect_access_t access = {.side = ECT_SIDE_PDI, .write = true, .data = (uint8_t *)(uintptr_t)buffer};
    pdi_begins(esc);
    (void)ect_esc_access(esc, &access, address, length);
    if (((const ect_esc_t *)esc)->reset_step[ECT_SIDE_PDI] != 0)
        ect_esc_access_ends(esc);
    return 0;
}

/* Each of these schedules its own next time. The end of a reload may move the pulses, so it comes first. */
static void tick_units(ect_esc_t *esc)
{
    ect_esc_sii_tick(esc);
    esc->next_ns = UINT64_MAX;
    ect_esc_watchdog_tick(esc);
    ect_esc_sii_tick(esc);
    ect_esc_mii_tick(esc);
    ect_esc_port_tick(esc);
    ect_esc_sync_tick(esc);
    ECT_ASSERT(esc->next_ns > esc->now_ns);
}

void ect_esc_advance(ect_esc_t *esc, uint64_t now_ns)
{
    esc->now_ns = now_ns;
    if (now_ns >= esc->next_ns)
        tick_units(esc);
}

uint64_t ect_esc_tick(ect_esc_t *esc, uint64_t now_ns)
{
    ECT_ASSERT(now_ns >= esc->now_ns);
    ect_esc_advance(esc, now_ns);
    return esc->next_ns;
}

uint32_t ect_esc_al_event(const ect_esc_t *esc)
{
    return ect_load_le32(esc->memory + ECT_REG_AL_EVENT);
}

bool ect_esc_line(const ect_esc_t *esc)
{
    return (ect_esc_al_event(esc) & ect_load_le32(esc->memory + ECT_REG_AL_EVENT_MASK)) != 0;
}
