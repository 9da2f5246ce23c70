/* SPDX-License-Identifier: MIT */
/* I. Distributed clocks, within the accuracy of a master without a synchronised clock. */
#include <string.h>

#include "steps/case.h"

enum {
    DELAY_NS = 200000000,
    CYCLE_NS = 1000000,
    SHORT_CYCLE_NS = 1000,
    ACTIVE_SYNC0 = 3,
    SII_DC = 60,
    GIGA = 1000000000
};
enum { SPEED_START = 0x1000, HELD_UP_NS = 100000000 };
enum { STATUS_READS = 20, SHIFT_NS = 300000, SOON_NS = 50000000, SLACK_NS = 1000000, ACTIVE_SYNC1 = 4 };

static uint64_t system_time(cf_t *c)
{
    return cf_get64(c, ECT_REG_DC_SYSTEM_TIME);
}

/* --- times -------------------------------------------------------------------------------------------------------- */

static uint32_t latch(cf_t *c, uint64_t *unit)
{
    cf_put32(c, ECT_REG_DC_RECEIVE_TIME, 0);
    uint32_t port = cf_get32(c, ECT_REG_DC_RECEIVE_TIME);
    *unit = cf_get64(c, ECT_REG_DC_RECEIVE_TIME_UNIT);
    return port;
}

/* Latches by a broadcast write, as masters do for measuring delays. */
static void latch_by_all(cf_t *c, uint32_t before)
{
    uint8_t zeros[4] = {0};
    cf_step(c, "BWR latches as well");
    cf_sleep_ms(c, 5);
    (void)cf_command(c, CF_BWR, 0, ECT_REG_DC_RECEIVE_TIME, zeros, sizeof zeros);
    uint32_t passed = cf_get32(c, ECT_REG_DC_RECEIVE_TIME) - before;
    cf_expect_that(c, passed >= 4500000, "receive time of BWR, 5 ms later: expected at least 4.5 ms later, got %u us",
                   passed / 1000);
}

/* The 64-bit receive time counts from the start of the chip; after 4.3 s the upper half is not 0. */
static void wide_receive_time(cf_t *c)
{
    uint64_t unit;
    if ((c->facts.features & 0x0008) == 0)
        return;
    cf_step(c, "all 64 bits of the processing unit's receive time");
    cf_put64(c, ECT_REG_DC_OFFSET, 0);
    cf_put32(c, ECT_REG_DC_DELAY, 0);
    while (system_time(c) >> 32 == 0)
        cf_sleep_ms(c, 10);
    uint64_t before = system_time(c);
    (void)latch(c, &unit);
    uint64_t after = system_time(c);
    cf_expect_that(c, unit + SLACK_NS >= before && unit <= after + SLACK_NS,
                   "receive time of the processing unit (0x0918): expected 0x%016llX to 0x%016llX, got 0x%016llX",
                   (unsigned long long)before, (unsigned long long)after, (unsigned long long)unit);
}

static void receive_times(cf_t *c)
{
    uint64_t first_unit, second_unit;
    uint64_t begun = cf_now_ns();
    uint32_t first = latch(c, &first_unit);
    cf_expect(c, "receive time of port 0, read again", first, cf_get32(c, ECT_REG_DC_RECEIVE_TIME));
    cf_sleep_ms(c, 5);
    uint32_t second = latch(c, &second_unit);
    uint64_t most = cf_now_ns() - begun + (cf_now_ns() - begun) / 10 + 1000000;
    uint32_t passed = second - first;
    cf_expect_that(c, passed >= 4500000 && passed <= most,
                   "receive times of two writes 5 ms apart: expected 4.5 ms to %llu us between them, got %u us",
                   (unsigned long long)(most / 1000), passed / 1000);
    bool wide = (c->facts.features & 0x0008) != 0;
    cf_expect_that(c, !wide || second_unit - first_unit == passed || second_unit - first_unit <= most,
                   "receive times of the processing unit: expected as of port 0, %u us, got %llu us", passed / 1000,
                   (unsigned long long)((second_unit - first_unit) / 1000));
    latch_by_all(c, second);
    cf_step(c, "a read does not latch");
    second = cf_get32(c, ECT_REG_DC_RECEIVE_TIME);
    (void)cf_get32(c, ECT_REG_DC_RECEIVE_TIME);
    cf_expect(c, "receive time of port 0 after reads", second, cf_get32(c, ECT_REG_DC_RECEIVE_TIME));
    wide_receive_time(c);
}

static void compare(cf_t *c, int64_t ahead_ns, bool local_later)
{
    uint8_t received[4];
    uint32_t difference;
    uint64_t begun;
    do { /* repeated after a delay of the PC */
        begun = cf_now_ns();
        cf_put16(c, ECT_REG_DC_SPEED_START, SPEED_START); /* resets the filter */
        ect_store_le32(received, (uint32_t)(system_time(c) + (uint64_t)ahead_ns));
        cf_put(c, ECT_REG_DC_SYSTEM_TIME, received, sizeof received);
        difference = cf_get32(c, ECT_REG_DC_DIFFERENCE);
        cf_put16(c, ECT_REG_DC_SPEED_START, SPEED_START);
    } while (cf_now_ns() - begun > HELD_UP_NS);
    cf_expect_bits(c,
                   local_later ? "sign of the difference (0x092C) with the slave ahead"
                               : "sign of the difference (0x092C) with the slave behind",
                   0x80000000u, local_later ? 0x80000000u : 0, difference);
    cf_expect_range(c, "magnitude of the difference, ns", 1, 0x3FFFFFFF, difference & 0x7FFFFFFF);
}

/* With a delay set, the system time read by a frame is the local time minus the delay. */
static void delay(cf_t *c)
{
    cf_step(c, "a propagation delay of 1 s");
    cf_put32(c, ECT_REG_DC_DELAY, 0);
    uint64_t begun = cf_now_ns();
    uint32_t before = cf_get32(c, ECT_REG_DC_SYSTEM_TIME);
    cf_put32(c, ECT_REG_DC_DELAY, GIGA);
    uint32_t after = cf_get32(c, ECT_REG_DC_SYSTEM_TIME);
    uint64_t took = cf_now_ns() - begun;
    cf_put32(c, ECT_REG_DC_DELAY, 0);
    uint32_t passed = after + GIGA - before;
    cf_expect_that(c, passed <= took + took / 10 + 1000000,
                   "system time with a delay (0x0928) of 1 s: expected 1 s earlier, got %d us later than before",
                   (int32_t)(after - before) / 1000);
}

static void offset_and_loop(cf_t *c)
{
    const uint64_t offset = UINT64_C(3000000000);
    cf_put64(c, ECT_REG_DC_OFFSET, 0);
    uint64_t begun = cf_now_ns(); /* first, to include delays of the PC between two frames */
    uint64_t before = system_time(c);
    cf_put64(c, ECT_REG_DC_OFFSET, offset);
    uint64_t after = system_time(c), took = cf_now_ns() - begun;
    cf_put64(c, ECT_REG_DC_OFFSET, 0);
    uint64_t most = offset + took + took / 10 + 1000000;
    cf_expect_that(c, after - before >= offset && after - before <= most,
                   "system time after an offset of 3 s: expected 3 s later, got %llu us",
                   (unsigned long long)((after - before) / 1000));
    delay(c);
    cf_step(c, "a reference time half a second ahead, then half a second behind");
    compare(c, 500000000, false);
    compare(c, -500000000, true);
    cf_step(c, "FRMW of the slave's own time: read, and not compared");
    uint8_t time[4] = {0};
    cf_expect_range(c, "WKC of FRMW of the system time: this slave, and others with clocks", 1, c->facts.slaves,
                    cf_command(c, CF_FRMW, c->facts.station, ECT_REG_DC_SYSTEM_TIME, time, sizeof time));
}

/* --- SYNC0 -------------------------------------------------------------------------------------------------------- */

static void start(cf_t *c, uint64_t start_ns, uint32_t cycle_ns, uint8_t active)
{
    cf_put8(c, ECT_REG_DC_ACTIVATION, 0);
    cf_put32(c, ECT_REG_DC_SYNC0_CYCLE, cycle_ns);
    cf_put64(c, ECT_REG_DC_START_TIME, start_ns);
    cf_put8(c, ECT_REG_DC_ACTIVATION, active);
}

/* Reads system time and next SYNC0 by one frame. */
static void read_times(cf_t *c, uint64_t *now, uint64_t *next)
{
    uint8_t time[8] = {0}, pulse[8] = {0};
    cf_datagram_t d[2] = {{.command = CF_FPRD,
                           .address = CF_AT(c->facts.station, ECT_REG_DC_SYSTEM_TIME),
                           .length = sizeof time,
                           .data = time},
                          {.command = CF_FPRD,
                           .address = CF_AT(c->facts.station, ECT_REG_DC_START_TIME),
                           .length = sizeof pulse,
                           .data = pulse}};
    cf_exchange(c, d, 2);
    *now = ect_load_le64(time);
    *next = ect_load_le64(pulse);
}

static void check_grid(cf_t *c, uint64_t start_ns)
{
    uint64_t now, next;
    for (int i = 0; i < 10; i++) {
        read_times(c, &now, &next);
        cf_expect_that(c, next + CYCLE_NS > now && next <= now + 2 * CYCLE_NS,
                       "next SYNC0 (0x0990): expected within a cycle of 1 ms, got %lld us from now",
                       (long long)(int64_t)(next - now) / 1000);
        cf_expect_that(c, (next - start_ns) % CYCLE_NS == 0,
                       "next SYNC0: expected a multiple of the cycle after the start, got %llu ns more",
                       (unsigned long long)((next - start_ns) % CYCLE_NS));
        cf_sleep_ms(c, 1);
    }
}

/* Bit 0 of 0x098E is the state of SYNC0; with pulse length 0 it stays set until the slave's software acknowledges. */
static void sync0_status(cf_t *c, bool runs)
{
    uint8_t status = 0, length[2];
    if (!runs) {
        cf_expect(c, "SYNC0 status (0x098E) with SYNC0 off", 0, cf_get8(c, ECT_REG_DC_SYNC0_STATUS));
        return;
    }
    cf_get(c, ECT_REG_DC_PULSE_LENGTH, length, sizeof length);
    for (int i = 0; i < STATUS_READS; i++) {
        cf_sleep_ms(c, 1);
        status |= cf_get8(c, ECT_REG_DC_SYNC0_STATUS);
    }
    cf_expect_bits(c, "reserved bits of SYNC0 status (0x098E)", 0xFE, 0, status);
    cf_expect_that(c, (status & 1) != 0 || ect_load_le16(length) != 0,
                   "SYNC0 status (0x098E) of unacknowledged pulses: expected 0x01, got 0x%02X", status);
}

/* SYNC1 follows SYNC0 by the SYNC1 cycle time if this is shorter than the SYNC0 cycle time. */
static void sync1_shift(cf_t *c)
{
    uint8_t first[8] = {0}, second[8] = {0};
    cf_datagram_t d[2] = {{.command = CF_FPRD,
                           .address = CF_AT(c->facts.station, ECT_REG_DC_START_TIME),
                           .length = sizeof first,
                           .data = first},
                          {.command = CF_FPRD,
                           .address = CF_AT(c->facts.station, ECT_REG_DC_NEXT_SYNC1),
                           .length = sizeof second,
                           .data = second}};
    cf_step(c, "SYNC1 %d us after SYNC0", SHIFT_NS / 1000);
    uint64_t start_ns = system_time(c) + SOON_NS;
    cf_put32(c, ECT_REG_DC_SYNC1_CYCLE, SHIFT_NS);
    start(c, start_ns, CYCLE_NS, ACTIVE_SYNC0 | ACTIVE_SYNC1);
    while (system_time(c) <= start_ns + 2 * CYCLE_NS)
        cf_sleep_ms(c, 1);
    cf_exchange(c, d, 2);
    cf_put8(c, ECT_REG_DC_ACTIVATION, 0);
    uint64_t apart = (ect_load_le64(second) + 2 * CYCLE_NS - ect_load_le64(first)) % CYCLE_NS;
    cf_expect_that(c, apart == SHIFT_NS, "next SYNC1 (0x0998) after SYNC0: expected %d ns, got %llu", SHIFT_NS,
                   (unsigned long long)apart);
}

static void sync0(cf_t *c)
{
    uint64_t now, next, start_ns = system_time(c) + DELAY_NS;
    if ((c->facts.features & 0x0008) == 0)
        cf_skip(c, "the clocks have 32 bits: this case reads 64");
    sync0_status(c, false);
    cf_step(c, "SYNC0 every ms, from 200 ms ahead");
    start(c, start_ns, CYCLE_NS, ACTIVE_SYNC0);
    read_times(c, &now, &next);
    cf_expect_that(c, now >= start_ns || next == start_ns,
                   "next SYNC0 before the start: expected the start time, got %lld us later",
                   (long long)(int64_t)(next - start_ns) / 1000);
    while (system_time(c) <= start_ns + CYCLE_NS)
        cf_sleep_ms(c, 1);
    check_grid(c, start_ns);
    sync0_status(c, true);
    cf_step(c, "off, and on with a start time in the past: no SYNC0");
    start_ns = system_time(c) - DELAY_NS;
    start(c, start_ns, CYCLE_NS, ACTIVE_SYNC0);
    cf_sleep_ms(c, 5);
    read_times(c, &now, &next);
    cf_expect_that(c, next == start_ns || next < now || next > now + DELAY_NS,
                   "SYNC0 with a start in the past: expected not to run, got the next pulse %lld us from now",
                   (long long)(int64_t)(next - now) / 1000);
    cf_put8(c, ECT_REG_DC_ACTIVATION, 0);
    sync1_shift(c);
}

static void jitter(cf_t *c)
{
    cf_skip(c, "jitter cannot be measured by a PC's clock; CF-043 covers the loss of SYNC0");
}

static void latches(cf_t *c)
{
    cf_skip(c, "needs an edge at the latch pins of the board");
}

/* @return the first DC mode of the SII with SYNC0; skips the case when there is none */
static uint16_t sync_mode(cf_t *c)
{
    size_t length;
    const uint8_t *data = cf_sii_category(c, SII_DC, &length);
    for (size_t at = 0; data && at + 24 <= length; at += 24) {
        uint16_t activate = ect_load_le16(data + at + 14);
        if ((activate & 0x0200) != 0)
            return activate;
    }
    cf_skip(c, "the SII contains no mode with SYNC0");
}

static void cycle_refused(cf_t *c)
{
    static const uint16_t codes[] = {0x002E, 0x0030, 0x0035, 0x0036, 0x0037};
    const uint16_t activate = sync_mode(c);
    uint16_t code = 0, got;
    bool known = false;
    cf_go(c, CF_PREOP);
    cf_set_process_data(c);
    cf_step(c, "SYNC0 every microsecond, too fast for any application");
    cf_put8(c, ECT_REG_DC_ACTIVATION - 1, (uint8_t)activate);
    cf_put32(c, ECT_REG_DC_SYNC0_CYCLE, SHORT_CYCLE_NS);
    cf_put64(c, ECT_REG_DC_START_TIME, system_time(c) + DELAY_NS);
    cf_put8(c, ECT_REG_DC_ACTIVATION, (uint8_t)(activate >> 8));
    got = cf_request(c, CF_SAFEOP, &code);
    if ((got & 0x1F) == CF_SAFEOP) /* some slaves check it only in the transition to OP */
        got = cf_request(c, CF_OP, &code);
    cf_put8(c, ECT_REG_DC_ACTIVATION, 0);
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++)
        known |= code == codes[i];
    cf_expect_that(c, (got & ECT_AL_ERROR) != 0 && known,
                   "a cycle of 1 us: expected a refusal with code 0x0035 or a similar one, got %s with code 0x%04X",
                   cf_state_name(got), code);
}

static const cf_case_t cases[] = {
    {"CF-087", "A write to 0x0900 latches the receive times, a read does not", 'R', CF_DC | CF_REAL_TIME, 0,
     receive_times},
    {"CF-088", "The offset moves the system time; the difference has the right sign", 'R', CF_DC | CF_REAL_TIME, 0,
     offset_and_loop},
    {"CF-089", "SYNC0 starts at its start time and keeps its cycle; a start time in the past starts no SYNC0", 'R',
     CF_DC | CF_REAL_TIME, 0, sync0},
    {"CF-090", "SYNC0 and SYNC1 keep their time difference to the frames", 'T', CF_DC, 0, jitter},
    {"CF-091", "Latch registers contain the time of an edge", 'R', CF_DC, 0, latches},
    {"CF-092", "An unsupported cycle is refused", 'F', CF_DC | CF_APPLICATION | CF_SII, 0, cycle_refused},
};

CF_SECTION(cf_dc, 'I', "Distributed clocks", cases);
