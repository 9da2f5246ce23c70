/* SPDX-License-Identifier: MIT */
/*
 * Distributed clocks (data sheet I §9). All clocks of a process are the same one, so nothing drifts and no cable takes
 * time: the control loop has nothing to do but to show the difference, and the receive times of all ports are equal.
 * SYNC0 wakes nobody unless the PDI configuration (0x0151 bit 3) makes it an AL event.
 */
#include <string.h>

#include "esc/internal.h"

enum { CYCLIC = 0x01, SYNC0 = 0x02, TO_AL_EVENT = 0x08, PENDING = 0x01 };

static uint8_t *reg(const ect_esc_t *esc, uint16_t address)
{
    return esc->memory + address;
}

static uint64_t local_time(const ect_esc_t *esc)
{
    ECT_ASSERT(esc->now_ns >= esc->power_on_ns);
    return esc->now_ns - esc->power_on_ns;
}

static uint64_t system_time(const ect_esc_t *esc)
{
    return local_time(esc) + ect_load_le64(reg(esc, ECT_REG_DC_OFFSET));
}

bool ect_esc_dc_present(const ect_esc_t *esc)
{
    return (esc->config.personality->features & ECT_FEATURE_DC) != 0;
}

/* The frame's arrival, at every port that has a link: it has come back from the others in no time. */
bool ect_esc_dc_latch(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)access;
    (void)address;
    (void)length;
    if (!ect_esc_dc_present(esc))
        return true; /* a chip without them still counts the write */
    for (unsigned int port = 0; port < ECT_ESC_PORTS; port++) {
        if (port == 0 || ect_esc_port_open(esc, port))
            ect_store_le32(reg(esc, ECT_REG_DC_RECEIVE_TIME) + 4 * port, (uint32_t)local_time(esc));
    }
    ect_store_le64(reg(esc, ECT_REG_DC_RECEIVE_TIME_UNIT), local_time(esc));
    return true;
}

bool ect_esc_dc_write_plain(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!ect_esc_dc_present(esc))
        return false;
    ect_esc_copy(access, reg(esc, address), 0, length);
    return true;
}

/* The reference clock's time: what remains of the difference once the propagation delay is taken off (bit 31: ahead).
 */
bool ect_esc_dc_compare(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint8_t received[4];
    if (!ect_esc_dc_present(esc))
        return false;
    ect_store_le32(received, (uint32_t)system_time(esc));
    ect_esc_copy(access, received + (address - ECT_REG_DC_SYSTEM_TIME), 0, length);
    uint32_t ahead = (uint32_t)system_time(esc) - ect_load_le32(reg(esc, ECT_REG_DC_DELAY)) - ect_load_le32(received);
    bool behind = (int32_t)ahead < 0;
    ect_store_le32(reg(esc, ECT_REG_DC_DIFFERENCE), behind ? 0u - ahead : ahead | 0x80000000u);
    return true;
}

/* Any write to it starts the filters anew. */
bool ect_esc_dc_write_speed(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!ect_esc_dc_write_plain(esc, access, address, length))
        return false;
    memset(reg(esc, ECT_REG_DC_DIFFERENCE), 0, 4);
    return true;
}

/* A start time that has passed is 2^64 ns away. */
static void start_cyclic(ect_esc_t *esc)
{
    ECT_ASSERT(ect_esc_dc_present(esc));
    uint64_t start = ect_load_le64(reg(esc, ECT_REG_DC_START_TIME));
    uint64_t now = system_time(esc);
    esc->sync0_ns = start > now && start - now < UINT64_MAX - esc->now_ns ? esc->now_ns + (start - now) : UINT64_MAX;
    *reg(esc, ECT_REG_DC_ACTIVATION_STATUS) = PENDING;
}

static void stop_cyclic(ect_esc_t *esc)
{
    esc->sync0_ns = UINT64_MAX;
    *reg(esc, ECT_REG_DC_ACTIVATION_STATUS) = 0;
    *reg(esc, ECT_REG_DC_SYNC0_STATUS) = 0;
    ect_esc_clear(esc, ECT_EVENT_SYNC0);
}

bool ect_esc_dc_activate(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint8_t before = *reg(esc, ECT_REG_DC_ACTIVATION);
    if (!ect_esc_dc_write_plain(esc, access, address, length))
        return false;
    uint8_t after = *reg(esc, ECT_REG_DC_ACTIVATION);
    bool runs = (after & (CYCLIC | SYNC0)) == (CYCLIC | SYNC0);
    if (!runs)
        stop_cyclic(esc);
    else if ((before & (CYCLIC | SYNC0)) != (CYCLIC | SYNC0))
        start_cyclic(esc);
    esc->activity++; /* whoever waits for the time of the next pulse asks again */
    return true;
}

void ect_esc_dc_acknowledge(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    if (access->side != ECT_SIDE_PDI)
        return;
    *reg(esc, ECT_REG_DC_SYNC0_STATUS) = 0;
    ect_esc_clear(esc, ECT_EVENT_SYNC0);
}

/* However many pulses there were since the last look, the next one is on the grid. */
static void pass_sync0(ect_esc_t *esc)
{
    uint32_t cycle = ect_load_le32(reg(esc, ECT_REG_DC_SYNC0_CYCLE));
    if (esc->now_ns < esc->sync0_ns)
        return;
    esc->sync0_ns = cycle == 0 ? UINT64_MAX : esc->sync0_ns + ((esc->now_ns - esc->sync0_ns) / cycle + 1) * cycle;
    *reg(esc, ECT_REG_DC_ACTIVATION_STATUS) = 0;
    *reg(esc, ECT_REG_DC_SYNC0_STATUS) = 1;
    if ((*reg(esc, ECT_REG_SYNC_CONFIG) & TO_AL_EVENT) != 0)
        ect_esc_raise(esc, ECT_EVENT_SYNC0);
}

uint64_t ect_esc_dc_tick(ect_esc_t *esc)
{
    pass_sync0(esc);
    return (*reg(esc, ECT_REG_SYNC_CONFIG) & TO_AL_EVENT) != 0 ? esc->sync0_ns : UINT64_MAX;
}

/* Brings the registers that follow the time up to date: somebody reads them. */
void ect_esc_dc_refresh(ect_esc_t *esc)
{
    if (!ect_esc_dc_present(esc))
        return;
    pass_sync0(esc);
    ect_store_le64(reg(esc, ECT_REG_DC_SYSTEM_TIME), system_time(esc));
    if (esc->sync0_ns != UINT64_MAX)
        ect_store_le64(reg(esc, ECT_REG_DC_START_TIME), system_time(esc) + (esc->sync0_ns - esc->now_ns));
}
