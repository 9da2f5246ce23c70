/* SPDX-License-Identifier: MIT */
/*
 * Distributed clocks: SYNC0 and SYNC1, and the latch inputs (data sheet I §9.2, II §2.15.3 to §2.15.6). Times in this
 * file are system times, except `sync_ns`, the time of the next pulse on the caller's clock.
 */
#include <string.h>

#include "esc/internal.h"

/* 0x0981. */
enum {
    CYCLIC = 0x01,
    SYNC0 = 0x02,
    SYNC1 = 0x04,
    AUTO_ACTIVATION = 0x08,
    EXTENDED = 0x10,
    PLAUSIBLE = 0x20,
    NEAR_2_SECONDS = 0x40,
    DEBUG_PULSE = 0x80,
};

/* 0x0980, 0x0984, 0x09A8, 0x09AE. */
enum { CYCLIC_BY_PDI = 0x01, SYNC1_OTHERWISE = 0x02, LATCH_BY_PDI = 0x10 };
enum { PENDING = 0x01, OUT_OF_NEAR_FUTURE = 0x04 };
enum { POSITIVE = 0x01, NEGATIVE = 0x02, PIN = 0x04 };

static uint8_t *reg(const ect_esc_t *esc, unsigned int address)
{
    return esc->memory + address;
}

static uint64_t system_now(const ect_esc_t *esc)
{
    return ect_esc_system_time(esc, esc->now_ns);
}

static uint32_t cycle_of(const ect_esc_t *esc, unsigned int n)
{
    return ect_load_le32(reg(esc, n == 0 ? ECT_REG_DC_SYNC0_CYCLE : ECT_REG_DC_SYNC1_CYCLE));
}

/* Time from one pulse to the next. SYNC1 follows a SYNC0, and then the first SYNC0 after itself. 0: no next pulse. */
static uint64_t period_of(const ect_esc_t *esc, unsigned int n)
{
    uint64_t base = cycle_of(esc, 0);
    return n == 0 || base == 0 ? base : (cycle_of(esc, 1) / base + 1) * base;
}

/* Bit 3 of 0x0151 enables SYNC0, bit 7 SYNC1. */
static bool is_event(const ect_esc_t *esc, unsigned int n)
{
    return (*reg(esc, ECT_REG_SYNC_CONFIG) & (0x08u << (4 * n))) != 0;
}

static bool acknowledged_by_hand(const ect_esc_t *esc)
{
    return ect_load_le16(reg(esc, ECT_REG_DC_PULSE_LENGTH)) == 0;
}

/* The status bit remains set until it is acknowledged, even if pulses have a length, because a microcontroller that
 * runs in the same process may read it late. */
static void pulse(ect_esc_t *esc, unsigned int n, uint64_t at)
{
    *reg(esc, ECT_REG_DC_SYNC0_STATUS + n) = 1;
    esc->sync[n].end = at + 10ull * ect_load_le16(reg(esc, ECT_REG_DC_PULSE_LENGTH));
    if (is_event(esc, n))
        ect_esc_raise(esc, n == 0 ? ECT_EVENT_SYNC0 : ECT_EVENT_SYNC1);
}

/* Regardless of the number of pulses since the last call, the next one is a multiple of the cycle after the start
 * time. */
static void pass(ect_esc_t *esc, unsigned int n, uint64_t now)
{
    ect_esc_sync_t *sync = &esc->sync[n];
    uint64_t period = period_of(esc, n);
    if (now < sync->next)
        return;
    uint64_t last = period == 0 ? sync->next : sync->next + (now - sync->next) / period * period;
    sync->next = period == 0 ? UINT64_MAX : last + period;
    *reg(esc, ECT_REG_DC_ACTIVATION_STATUS) &= (uint8_t)~(PENDING << n);
    pulse(esc, n, last);
}

void ect_esc_sync_settle(ect_esc_t *esc)
{
    uint64_t now = system_now(esc);
    for (unsigned int n = 0; n < 2; n++)
        pass(esc, n, now);
}

void ect_esc_sync_tick(ect_esc_t *esc)
{
    if (esc->now_ns < esc->sync_ns) {
        ect_esc_expect(esc, esc->sync_ns);
        return;
    }
    uint64_t now = system_now(esc);
    uint64_t next = UINT64_MAX;
    ect_esc_sync_settle(esc);
    for (unsigned int n = 0; n < 2; n++) {
        if (is_event(esc, n) && esc->sync[n].next < next)
            next = esc->sync[n].next;
    }
    esc->sync_ns = next == UINT64_MAX ? UINT64_MAX : ect_esc_real_after(esc, next - now);
    ect_esc_expect(esc, esc->sync_ns);
}

/* Computes the time of the next pulse after a change of clock or cycle. */
void ect_esc_sync_moved(ect_esc_t *esc)
{
    if (esc->sync[0].next == UINT64_MAX && esc->sync[1].next == UINT64_MAX)
        return;
    esc->sync_ns = esc->now_ns;
    ect_esc_expect(esc, esc->now_ns);
}

/* --- activation ------------------------------------------------------------------------------------------------- */

static bool enhanced(const ect_esc_t *esc)
{
    return (esc->config.personality->features & ECT_FEATURE_SYNC) != 0;
}

/* A start time in the past is almost 2^64 ns away. An implausible one may mean "now". */
static void start_cyclic(ect_esc_t *esc)
{
    uint8_t activation = *reg(esc, ECT_REG_DC_ACTIVATION);
    uint64_t now = system_now(esc);
    uint64_t first = ect_load_le64(reg(esc, ECT_REG_DC_START_TIME));
    uint64_t near = (activation & NEAR_2_SECONDS) != 0 ? 1ull << 31 : 1ull << 63;
    bool plausible = first > now && first - now < near;
    uint8_t status = 0;
    if ((activation & PLAUSIBLE) != 0 && !plausible) {
        status = OUT_OF_NEAR_FUTURE;
        first = now;
    } else if (first <= now) {
        first = UINT64_MAX;
    }
    esc->sync[0].next = (activation & SYNC0) != 0 ? first : UINT64_MAX;
    esc->sync[1].next = (activation & SYNC1) == 0 || first == UINT64_MAX ? UINT64_MAX : first + cycle_of(esc, 1);
    *reg(esc, ECT_REG_DC_ACTIVATION_STATUS) =
        (uint8_t)(status | ((activation & SYNC0) != 0 ? PENDING : 0) | ((activation & SYNC1) != 0 ? PENDING << 1 : 0));
    esc->sync_ns = esc->now_ns;
    ect_esc_expect(esc, esc->now_ns);
}

static void stop_cyclic(ect_esc_t *esc)
{
    esc->sync[0] = esc->sync[1] = (ect_esc_sync_t){.next = UINT64_MAX};
    esc->sync_ns = UINT64_MAX;
    *reg(esc, ECT_REG_DC_ACTIVATION_STATUS) = 0;
    *reg(esc, ECT_REG_DC_SYNC0_STATUS) = *reg(esc, ECT_REG_DC_SYNC1_STATUS) = 0;
    ect_esc_clear(esc, ECT_EVENT_SYNC0 | ECT_EVENT_SYNC1);
}

void ect_esc_sync_reset(ect_esc_t *esc)
{
    stop_cyclic(esc);
}

/* Compares the register with its previous value `before`: the unit starts, stops, or continues. */
static void follow_activation(ect_esc_t *esc, uint8_t before)
{
    uint8_t after = *reg(esc, ECT_REG_DC_ACTIVATION);
    bool runs = (after & CYCLIC) != 0 && (after & (SYNC0 | SYNC1)) != 0;
    ect_esc_sync_settle(esc);
    if (!runs)
        stop_cyclic(esc);
    else if (((before ^ after) & (CYCLIC | SYNC0 | SYNC1)) != 0)
        start_cyclic(esc);
    esc->activity++; /* callers that wait for the next pulse must recompute its time */
}

static bool is_of(const ect_esc_t *esc, ect_side_t side, bool pdi_controls)
{
    return ect_esc_dc_present(esc) && (side == ECT_SIDE_PDI) == pdi_controls;
}

static bool cyclic_is_of(const ect_esc_t *esc, ect_side_t side)
{
    return is_of(esc, side, (*reg(esc, ECT_REG_DC_CYCLIC_CONTROL) & CYCLIC_BY_PDI) != 0);
}

bool ect_esc_sync_control_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    return ect_esc_dc_present(esc);
}

bool ect_esc_sync_start_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    return cyclic_is_of(esc, ECT_SIDE_ECAT);
}

bool ect_esc_sync_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)length;
    if (!ect_esc_dc_present(esc))
        return false;
    *reg(esc, address) = access->data[0] & (CYCLIC_BY_PDI | SYNC1_OTHERWISE | LATCH_BY_PDI | LATCH_BY_PDI << 1);
    return true;
}

bool ect_esc_sync_activate(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint8_t before = *reg(esc, address);
    uint8_t value = access->data[0];
    (void)length;
    if (!cyclic_is_of(esc, access->side))
        return false;
    if (!enhanced(esc))
        value &= CYCLIC | SYNC0 | SYNC1;
    *reg(esc, address) = value & (uint8_t)~DEBUG_PULSE;
    follow_activation(esc, before);
    for (unsigned int n = 0; n < 2 && (value & DEBUG_PULSE) != 0; n++) {
        if ((value & (SYNC0 << n)) != 0)
            pulse(esc, n, system_now(esc));
    }
    return true;
}

/* The written 32 bits are extended to the nearest future time that they match. */
static void extend_start(const ect_esc_t *esc)
{
    uint64_t now = system_now(esc);
    uint64_t start = (now & ~0xFFFFFFFFull) | ect_load_le32(reg(esc, ECT_REG_DC_START_TIME));
    ect_store_le64(reg(esc, ECT_REG_DC_START_TIME), start > now ? start : start + 0x100000000ull);
}

bool ect_esc_sync_start(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint8_t activation = *reg(esc, ECT_REG_DC_ACTIVATION);
    if (!cyclic_is_of(esc, access->side))
        return false;
    ect_esc_copy(access, reg(esc, address), 0, length);
    uint16_t end = (uint16_t)(address + length - ECT_REG_DC_START_TIME);
    bool extended = (activation & EXTENDED) != 0 && address <= ECT_REG_DC_START_TIME + 3 && end >= 4;
    if (extended)
        extend_start(esc);
    if ((activation & AUTO_ACTIVATION) != 0 && (extended || end == 8)) {
        *reg(esc, ECT_REG_DC_ACTIVATION) = activation | CYCLIC;
        follow_activation(esc, activation & (uint8_t)~CYCLIC);
    }
    return true;
}

static bool cycle_is_of(const ect_esc_t *esc, ect_side_t side, uint16_t address)
{
    uint8_t control = *reg(esc, ECT_REG_DC_CYCLIC_CONTROL);
    bool first = address < ECT_REG_DC_SYNC1_CYCLE;
    bool by_pdi = ((control & CYCLIC_BY_PDI) != 0) != (!first && (control & SYNC1_OTHERWISE) != 0);
    return is_of(esc, side, by_pdi);
}

bool ect_esc_sync_cycle_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    (void)length;
    return cycle_is_of(esc, ECT_SIDE_ECAT, address);
}

bool ect_esc_sync_cycle(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!cycle_is_of(esc, access->side, address))
        return false;
    ect_esc_sync_settle(esc);
    ect_esc_copy(access, reg(esc, address), 0, length);
    ect_esc_sync_moved(esc);
    return true;
}

void ect_esc_sync_acknowledge(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (access->side != ECT_SIDE_PDI)
        return;
    for (uint16_t i = 0; i < length; i++) {
        unsigned int n = (unsigned int)address + i - ECT_REG_DC_SYNC0_STATUS;
        *reg(esc, (unsigned int)address + i) = 0;
        ect_esc_clear(esc, n == 0 ? ECT_EVENT_SYNC0 : ECT_EVENT_SYNC1);
    }
}

bool ect_esc_sync_pin(ect_esc_t *esc, unsigned int n)
{
    ECT_ASSERT(n < 2);
    pass(esc, n, system_now(esc));
    if (acknowledged_by_hand(esc))
        return *reg(esc, ECT_REG_DC_SYNC0_STATUS + n) != 0;
    return system_now(esc) < esc->sync[n].end;
}

void ect_esc_sync_refresh(ect_esc_t *esc, uint16_t address, uint16_t end)
{
    ect_esc_sync_settle(esc);
    for (unsigned int n = 0; n < 2; n++) {
        uint16_t next = n == 0 ? ECT_REG_DC_START_TIME : ECT_REG_DC_NEXT_SYNC1;
        if (esc->sync[n].next != UINT64_MAX && ect_esc_within(address, end, next))
            ect_store_le64(reg(esc, next), esc->sync[n].next);
    }
}

/* --- latch inputs ----------------------------------------------------------------------------------------------- */

static bool latch_by_pdi(const ect_esc_t *esc, unsigned int n)
{
    return (*reg(esc, ECT_REG_DC_CYCLIC_CONTROL) & (LATCH_BY_PDI << n)) != 0;
}

/* An event remains set as long as one of the edges that caused it is unread. */
static void follow_events(ect_esc_t *esc)
{
    bool pdi = false, ecat = false;
    for (unsigned int n = 0; n < 2; n++) {
        bool waits = (*reg(esc, ECT_REG_DC_LATCH_STATUS + n) & (POSITIVE | NEGATIVE)) != 0;
        pdi |= waits && latch_by_pdi(esc, n);
        ecat |= waits && !latch_by_pdi(esc, n);
    }
    if (pdi)
        ect_esc_raise(esc, ECT_EVENT_LATCH);
    else
        ect_esc_clear(esc, ECT_EVENT_LATCH);
    if (ecat)
        ect_esc_raise_ecat(esc, ECT_ECAT_EVENT_LATCH);
    else
        ect_esc_clear_ecat(esc, ECT_ECAT_EVENT_LATCH);
}

void ect_esc_latch_edge(ect_esc_t *esc, unsigned int n, bool level)
{
    ECT_ASSERT(n < 2);
    if (!ect_esc_dc_present(esc))
        return;
    uint8_t *status = reg(esc, ECT_REG_DC_LATCH_STATUS + n);
    esc->latch_level[n] = level;
    uint8_t edge = level ? POSITIVE : NEGATIVE;
    bool single = (*reg(esc, ECT_REG_DC_LATCH_CONTROL + n) & edge) != 0;
    if (!single || (*status & edge) == 0)
        ect_store_le64(reg(esc, ECT_REG_DC_LATCH_TIME) + 16 * n + (level ? 0 : 8), system_now(esc));
    if (single)
        *status |= edge;
    if (ect_esc_has(esc, ECT_UNIT_LATCH_PIN))
        *status = (uint8_t)((*status & ~PIN) | (level ? PIN : 0));
    follow_events(esc);
}

bool ect_esc_latch_control_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    bool any = false;
    for (unsigned int i = 0; i < length; i++)
        any |= is_of(esc, ECT_SIDE_ECAT, latch_by_pdi(esc, address + i - ECT_REG_DC_LATCH_CONTROL));
    return any;
}

bool ect_esc_latch_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool any = false;
    for (uint16_t i = 0; i < length; i++) {
        unsigned int n = (unsigned int)address + i - ECT_REG_DC_LATCH_CONTROL;
        if (!is_of(esc, access->side, latch_by_pdi(esc, n)))
            continue;
        *reg(esc, (unsigned int)address + i) = access->data[i] & (POSITIVE | NEGATIVE);
        *reg(esc, ECT_REG_DC_LATCH_STATUS + n) &= (uint8_t)~(POSITIVE | NEGATIVE);
        follow_events(esc);
        any = true;
    }
    return any;
}

/* Reading the time of an edge enables the next one, for the side that owns the unit. */
void ect_esc_latch_read(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!ect_esc_dc_present(esc))
        return;
    for (unsigned int edge = 0; edge < 4; edge++) {
        unsigned int first = ECT_REG_DC_LATCH_TIME + 8 * edge;
        unsigned int n = edge / 2;
        bool touched = first < (unsigned int)address + length && address < first + 8;
        if (touched && is_of(esc, access->side, latch_by_pdi(esc, n)))
            *reg(esc, ECT_REG_DC_LATCH_STATUS + n) &= (uint8_t)~(edge % 2 == 0 ? POSITIVE : NEGATIVE);
    }
    follow_events(esc);
}
