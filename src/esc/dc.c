/* SPDX-License-Identifier: MIT */
/*
 * Distributed clocks: receive times, system time, and the control loop that synchronises the local clock to another one
 * (data sheet I §9.1, II §2.15.1, §2.15.2).
 *
 * The control algorithm of the chips is not published; the documented parts are modelled: the filters of 0x0934 and
 * 0x0935, whose depths are powers of two of samples; 0x092C as the mean difference; 0x0932, whose relation to the
 * deviation is given; its range, which depends on 0x0930. Each sample corrects an eighth of its difference until the
 * next sample is due, within that range, and a persistent correction becomes a change of the clock's rate.
 */
#include <string.h>

#include "esc/internal.h"

enum { PDI_CONTROLS_TIME = 0x04, SHARE = 8, LOWEST_SPEED = 0x7F, AHEAD = (int)0x80000000, SCALE = 16 };

/* Beyond this the sign of a difference is unknown. */
enum { LOCK_LIMIT_NS = 1 << 30, GIGA = 1000000000 };

static uint8_t *reg(const ect_esc_t *esc, uint16_t address)
{
    return esc->memory + address;
}

/* A frame reads the time at which it passed the reference clock; the microcontroller reads the present time. */
static uint64_t time_for(const ect_esc_t *esc, ect_side_t side)
{
    if (side == ECT_SIDE_PDI)
        return ect_esc_system_time(esc, esc->now_ns);
    return ect_esc_frame_time(esc) + ect_load_le64(reg(esc, ECT_REG_DC_OFFSET)) -
           ect_load_le32(reg(esc, ECT_REG_DC_DELAY));
}

/* Ports to which a frame does not return keep their value. An ET1200 latches the times at every write, the other chips
 * only at writes that address all slaves or one by its station address; 0x0918 follows every write. */
bool ect_esc_dc_latch(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)length;
    if (!ect_esc_dc_present(esc) || address != ECT_REG_DC_RECEIVE_TIME)
        return true; /* counts as accessed all the same */
    bool ports = access->latches || ect_esc_has(esc, ECT_UNIT_LATCH_MODE);
    for (unsigned int port = 0; ports && port < ECT_ESC_PORTS; port++) {
        uint64_t time_ns = ect_esc_local_at(esc, esc->now_ns + esc->arrival.port_ns[port]);
        if (port == 0 || ect_esc_port_open(esc, port))
            ect_store_le32(reg(esc, ECT_REG_DC_RECEIVE_TIME) + 4 * port, (uint32_t)time_ns);
    }
    ect_store_le64(reg(esc, ECT_REG_DC_RECEIVE_TIME_UNIT), ect_esc_frame_time(esc));
    return true;
}

/* --- the control loop ------------------------------------------------------------------------------------------- */

static uint16_t speed_start(const ect_esc_t *esc)
{
    uint16_t start = ect_load_le16(reg(esc, ECT_REG_DC_SPEED_START)) & 0x7FFF;
    return start > LOWEST_SPEED ? start : LOWEST_SPEED + 1;
}

/* The deviation that a speed counter difference represents, in ppb: difference / (5 (start + d + 2) (start - d + 2)).
 */
static int32_t deviation(uint16_t start, uint16_t difference)
{
    uint64_t product = 5ull * (start + difference + 2u) * (start - difference + 2u);
    return (int32_t)((uint64_t)difference * GIGA / product);
}

static int32_t fastest(const ect_esc_t *esc)
{
    uint16_t start = speed_start(esc);
    return deviation(start, (uint16_t)(start - LOWEST_SPEED));
}

/* The difference for a deviation, by bisection, because it grows monotonically. The loop never exceeds `fastest`, so
 * no greater deviation occurs. */
static uint16_t speed_difference(const ect_esc_t *esc, int32_t ppb)
{
    uint16_t start = speed_start(esc);
    uint16_t low = 0, high = start;
    while (low < high) {
        uint16_t middle = (uint16_t)((low + high + 1) / 2);
        if (deviation(start, middle) <= ppb)
            low = middle;
        else
            high = (uint16_t)(middle - 1);
    }
    return low;
}

static int64_t within(int64_t value, int64_t limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

static void show_difference(const ect_esc_t *esc)
{
    int64_t mean = esc->loop.mean_scaled / (1 << SCALE);
    uint32_t shown = mean < 0 ? (uint32_t)-mean : (uint32_t)mean | (uint32_t)AHEAD;
    ect_store_le32(reg(esc, ECT_REG_DC_DIFFERENCE), shown);
}

static void filter_difference(ect_esc_t *esc, int32_t ahead_ns)
{
    int64_t sample = (int64_t)ahead_ns * (1 << SCALE);
    int64_t depth = 1 << (*reg(esc, ECT_REG_DC_FILTER) & 0x0F);
    if (!esc->loop.sampled)
        esc->loop.mean_scaled = sample;
    else
        esc->loop.mean_scaled += (sample - esc->loop.mean_scaled) / depth;
    show_difference(esc);
}

/* From now on the clock gains `rate_ppb` in addition to its oscillator, and `slew_ppb` on top of that for a while. */
static void trim(ect_esc_t *esc, int32_t rate_ppb, int32_t slew_ppb, uint64_t slew_for_ns)
{
    ect_esc_clock_rebase(esc);
    esc->clock.trim_ppb = rate_ppb;
    esc->clock.slew_ppb = slew_ppb;
    esc->clock.slew_end_ns = esc->now_ns + slew_for_ns;
    ect_esc_sync_moved(esc);
}

/* Slows down while the clock is ahead. The time since the last sample predicts the time until the next one. */
static void regulate(ect_esc_t *esc, int32_t ahead_ns)
{
    uint64_t period_ns = esc->now_ns - esc->loop.last_ns;
    if (period_ns == 0 || period_ns > GIGA)
        return;
    int64_t limit = fastest(esc);
    int64_t slew = within(-(int64_t)ahead_ns * (GIGA / SHARE) / (int64_t)period_ns, limit);
    int64_t depth = 1 << (*reg(esc, ECT_REG_DC_FILTER + 1) & 0x0F);
    esc->loop.rate_scaled = within(esc->loop.rate_scaled + slew * (1 << SCALE) / depth, limit * (1 << SCALE));
    int64_t rate = esc->loop.rate_scaled / (1 << SCALE);
    slew = within(rate + slew, limit) - rate;
    trim(esc, (int32_t)rate, (int32_t)slew, period_ns);
}

static void reset_loop(ect_esc_t *esc)
{
    esc->loop = (ect_esc_loop_t){0};
    ect_store_le32(reg(esc, ECT_REG_DC_DIFFERENCE), 0);
    trim(esc, 0, 0, 0);
}

bool ect_esc_dc_follows(const ect_esc_t *esc, ect_side_t side)
{
    bool pdi = (*reg(esc, ECT_REG_PDI_INFORMATION) & PDI_CONTROLS_TIME) != 0;
    return ect_esc_dc_present(esc) && (side == ECT_SIDE_PDI) == pdi;
}

bool ect_esc_dc_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    return ect_esc_dc_follows(esc, ECT_SIDE_ECAT);
}

static void compare(ect_esc_t *esc, uint32_t own, uint32_t received)
{
    int32_t ahead_ns = (int32_t)(own - received);
    filter_difference(esc, ahead_ns);
    if (esc->loop.sampled && ahead_ns > -LOCK_LIMIT_NS && ahead_ns < LOCK_LIMIT_NS)
        regulate(esc, ahead_ns);
    esc->loop.sampled = true;
    esc->loop.last_ns = esc->now_ns;
}

void ect_esc_dc_take(ect_esc_t *esc, uint32_t time)
{
    ECT_ASSERT(ect_esc_dc_follows(esc, ECT_SIDE_ECAT));
    compare(esc, (uint32_t)time_for(esc, ECT_SIDE_ECAT), time);
}

/* The value of a frame is compared with the frame's time of arrival, that of the PDI with the time of latch 0. */
bool ect_esc_dc_compare(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!ect_esc_dc_follows(esc, access->side))
        return false;
    uint32_t own = access->side == ECT_SIDE_PDI ? ect_load_le32(reg(esc, ECT_REG_DC_LATCH_TIME))
                                                : (uint32_t)time_for(esc, access->side);
    uint8_t received[sizeof own];
    ect_store_le32(received, own);
    ect_esc_copy(access, received + (address - ECT_REG_DC_SYSTEM_TIME), 0, length);
    compare(esc, own, ect_load_le32(received));
    return true;
}

bool ect_esc_dc_write_loop(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!ect_esc_dc_follows(esc, access->side))
        return false;
    ect_esc_sync_settle(esc);
    ect_esc_copy(access, reg(esc, address), 0, length);
    ect_esc_sync_moved(esc); /* the system time may have changed */
    return true;
}

/* Any write restarts the filters. */
bool ect_esc_dc_write_speed(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!ect_esc_dc_write_loop(esc, access, address, length))
        return false;
    reset_loop(esc);
    return true;
}

/* --- the oscillator ---------------------------------------------------------------------------------------------- */

void ect_esc_set_drift(ect_esc_t *esc, int32_t ppb)
{
    ECT_ASSERT(ppb >= -ECT_ESC_MAX_DRIFT_PPB && ppb <= ECT_ESC_MAX_DRIFT_PPB);
    ect_esc_clock_rebase(esc);
    esc->clock.drift_ppb = esc->config.drift_ppb = ppb;
    ect_esc_sync_moved(esc);
}

void ect_esc_clock_jump(ect_esc_t *esc, int64_t by_ns)
{
    ect_esc_sync_settle(esc);
    esc->clock.local_ns += (uint64_t)by_ns;
    ect_esc_sync_moved(esc);
}

void ect_esc_set_arrival(ect_esc_t *esc, const ect_esc_arrival_t *arrival)
{
    esc->arrival = *arrival;
}

/* --- reading ---------------------------------------------------------------------------------------------------- */

/* The bytes of a time must be consistent: it is sampled when its first byte is read. */
void ect_esc_dc_refresh(ect_esc_t *esc, ect_side_t side, uint16_t address, uint16_t end)
{
    if (!ect_esc_dc_present(esc))
        return;
    if (ect_esc_within(address, end, ECT_REG_DC_SYSTEM_TIME))
        ect_store_le64(reg(esc, ECT_REG_DC_SYSTEM_TIME), time_for(esc, side));
    if (ect_esc_within(address, end, ECT_REG_DC_SPEED_DIFFERENCE)) {
        int32_t rate = (int32_t)(esc->loop.rate_scaled / (1 << SCALE));
        uint16_t difference = speed_difference(esc, rate < 0 ? -rate : rate);
        ect_store_le16(reg(esc, ECT_REG_DC_SPEED_DIFFERENCE), rate > 0 ? (uint16_t)-difference : difference);
    }
    if (end > ECT_REG_DC_ACTIVATION)
        ect_esc_sync_refresh(esc, address, end);
}
