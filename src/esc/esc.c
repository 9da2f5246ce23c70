/* SPDX-License-Identifier: MIT */
#include "esc/esc.h"

#include <assert.h>
#include <string.h>

#include "esc/internal.h"

/* A word of events that is not zero: the datagrams carry it on. */
void ect_esc_raise(ect_esc_t *esc, uint32_t al_event)
{
    uint8_t *event = esc->memory + ECT_REG_AL_EVENT;
    ect_store_le32(event, ect_load_le32(event) | al_event);
    esc->activity++;
}

void ect_esc_clear(ect_esc_t *esc, uint32_t al_event)
{
    uint8_t *event = esc->memory + ECT_REG_AL_EVENT;
    ect_store_le32(event, ect_load_le32(event) & ~al_event);
}

void ect_esc_raise_ecat(ect_esc_t *esc, uint16_t ecat_event)
{
    uint8_t *event = esc->memory + ECT_REG_ECAT_EVENT;
    ect_store_le16(event, (uint16_t)(ect_load_le16(event) | ecat_event));
}

void ect_esc_clear_ecat(ect_esc_t *esc, uint16_t ecat_event)
{
    uint8_t *event = esc->memory + ECT_REG_ECAT_EVENT;
    ect_store_le16(event, (uint16_t)(ect_load_le16(event) & ~ecat_event));
}

void ect_esc_count(ect_esc_t *esc, uint16_t counter_register)
{
    uint8_t *counter = esc->memory + counter_register;
    if (*counter < 0xFF)
        (*counter)++;
}

/* One tick is (divider + 2) times 40 ns; the time is counted in ticks (data sheet I §13). */
void ect_esc_watchdog_trigger(ect_esc_t *esc)
{
    uint64_t tick_ns = (ect_load_le16(esc->memory + ECT_REG_WD_DIVIDER) + 2ull) * 40ull;
    uint64_t ticks = ect_load_le16(esc->memory + ECT_REG_WD_TIME_PD);
    esc->memory[ECT_REG_WD_STATUS_PD] = 1;
    esc->watchdog_ns = ticks == 0 ? UINT64_MAX : esc->now_ns + ticks * tick_ns;
}

static void watchdog_tick(ect_esc_t *esc)
{
    if (esc->now_ns < esc->watchdog_ns)
        return;
    esc->watchdog_ns = UINT64_MAX;
    esc->memory[ECT_REG_WD_STATUS_PD] = 0;
    ect_esc_count(esc, ECT_REG_WD_COUNTER_PD);
    ect_esc_raise(esc, ECT_EVENT_WATCHDOG);
}

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

/* Two bits a port, DL status bit 8 on: 01 closed, 10 open and communicating, 11 closed in spite of a link. */
static unsigned int loop_state(const ect_esc_t *esc, unsigned int port)
{
    enum { FORCED_OPEN = 2, FORCED_CLOSED = 3 };
    bool link = port == 0 || (esc->config.open_ports & (1u << port)) != 0;
    unsigned int control = ((unsigned int)esc->memory[ECT_REG_DL_CONTROL + 1] >> (2 * port)) & 3u;
    if (control == FORCED_CLOSED && port != 0) /* port 0 is the way back to the master */
        return link ? 3 : 1;
    return link ? 2 : control == FORCED_OPEN ? 0 : 1;
}

void ect_esc_update_dl_status(ect_esc_t *esc)
{
    uint8_t *status = esc->memory + ECT_REG_DL_STATUS;
    unsigned int value = (esc->sii_valid ? 1u : 0u) | 2u; /* the PDI watchdog is never late: same process */
    for (unsigned int port = 0; port < 4; port++) {
        bool link = port == 0 || (esc->config.open_ports & (1u << port)) != 0;
        value |= link ? 0x10u << port : 0u;
        value |= loop_state(esc, port) << (8 + 2 * port);
    }
    if (value != ect_load_le16(status))
        ect_esc_raise_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
    ect_store_le16(status, (uint16_t)value);
}

void ect_esc_set_link(ect_esc_t *esc, unsigned int port, bool link)
{
    unsigned int mask = 1u << port;
    esc->config.open_ports = (uint8_t)(link ? esc->config.open_ports | mask : esc->config.open_ports & ~mask);
    ect_esc_update_dl_status(esc);
}

bool ect_esc_port_open(const ect_esc_t *esc, unsigned int port)
{
    return loop_state(esc, port) == 2;
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
    int error = check(config);
    if (error != 0)
        return error;
    *esc = (ect_esc_t){.config = *config,
                       .memory = config->memory,
                       .memory_size = (uint32_t)ECT_ESC_MEMORY_SIZE(config->personality->ram_kb),
                       .now_ns = now_ns,
                       .power_on_ns = now_ns,
                       .sync0_ns = UINT64_MAX,
                       .watchdog_ns = UINT64_MAX};
    memset(esc->memory, 0, esc->memory_size);
    write_identity(esc);
    reset_registers(esc);
    ect_esc_sii_load(esc, true);
    ect_esc_clear_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
    return 0;
}

int ect_esc_pdi_read(void *esc, uint16_t address, void *buffer, uint16_t length)
{
    ect_access_t access = {.side = ECT_SIDE_PDI, .write = false, .data = buffer};
    memset(buffer, 0, length);
    (void)ect_esc_access(esc, &access, address, length);
    return 0;
}

int ect_esc_pdi_write(void *esc, uint16_t address, const void *buffer, uint16_t length)
{
    /* A write only reads through `data` (internal.h). */
    ect_access_t access = {.side = ECT_SIDE_PDI, .write = true, .data = (uint8_t *)(uintptr_t)buffer};
    (void)ect_esc_access(esc, &access, address, length);
    return 0;
}

uint64_t ect_esc_tick(ect_esc_t *esc, uint64_t now_ns)
{
    assert(now_ns >= esc->now_ns);
    esc->now_ns = now_ns;
    watchdog_tick(esc);
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
