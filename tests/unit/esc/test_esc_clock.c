/* SPDX-License-Identifier: MIT */
/* Clocks with drift and control loop, receive times with delays of frames, SYNC1, pulses, latch inputs (data sheet I
 * section 9, II section 2.15). Tests that need no second clock are in test_esc_dc.c. */
#include <stdlib.h>
#include <string.h>

#include "support/chip.h"

#define PPM    1000
#define SECOND (1000 * MS)

static uint64_t local_time(chip_t *c)
{
    return ect_esc_system_time(&c->esc, c->w.now_ns);
}

static void drift(void **state)
{
    static const struct {
        int32_t ppb;
        uint64_t after_ns, want_ns;
    } rows[] = {{0, SECOND, SECOND},
                {100 * PPM, SECOND, SECOND + 100000},
                {-100 * PPM, SECOND, SECOND - 100000},
                {1, SECOND, SECOND + 1},
                {-1, SECOND - 1, SECOND - 2},
                {ECT_ESC_MAX_DRIFT_PPB, 3600 * SECOND, 3600 * SECOND + 3600 * MS},
                {-ECT_ESC_MAX_DRIFT_PPB, 100ull * 365 * 86400 * SECOND, 100ull * 365 * 86400 * 999 * MS}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        c->config.drift_ppb = rows[i].ppb;
        chip_power_on(c);
        uint64_t got = ect_esc_system_time(&c->esc, c->w.now_ns + rows[i].after_ns);
        if (got != rows[i].want_ns)
            fail_msg("drift %d ppb, after %llu ns: expected %llu, got %llu", rows[i].ppb,
                     (unsigned long long)rows[i].after_ns, (unsigned long long)rows[i].want_ns,
                     (unsigned long long)got);
    }
}

/* No fraction is lost, regardless of the number of reads and of changes of the drift. */
static void drift_in_steps(void **state)
{
    chip_t *c = *state;
    uint64_t before = local_time(c);
    for (unsigned int i = 0; i < 100000; i++) {
        c->w.now_ns += 10007;
        (void)ect_esc_tick(&c->esc, c->w.now_ns);
        ect_esc_set_drift(&c->esc, i % 2 == 0 ? 50 * PPM : -50 * PPM);
        uint64_t now = local_time(c);
        assert_true(now >= before);
        before = now;
    }
    assert_in_range(before, 100000ull * 10007 - 1, 100000ull * 10007 + 1);
    ect_esc_clock_jump(&c->esc, -5000);
    assert_int_equal(local_time(c), before - 5000);
}

/* --- the control loop ------------------------------------------------------------------------------------------- */

/* With an exact reference clock. @return the greatest true difference in the last tenth of the samples */
static uint64_t follow(chip_t *c, unsigned int samples, uint64_t period_ns)
{
    uint64_t worst = 0;
    for (unsigned int i = 0; i < samples; i++) {
        c->w.now_ns += period_ns;
        (void)ect_esc_tick(&c->esc, c->w.now_ns);
        uint64_t true_ns = c->w.now_ns - 5000 * MS;
        int64_t ahead = (int64_t)(local_time(c) - true_ns);
        uint64_t size = (uint64_t)(ahead < 0 ? -ahead : ahead);
        assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, true_ns, 4), 1);
        if (i >= samples - samples / 10 && size > worst)
            worst = size;
    }
    return worst;
}

static void loop_settles(void **state)
{
    static const struct {
        int32_t ppb;
        uint64_t period_ns;
        unsigned int samples;
        uint64_t within_ns;
    } rows[] = {
        {0, MS, 1000, 1},
        {100 * PPM, MS, 3000, 1000},
        {-100 * PPM, MS, 3000, 1000},
        {200 * PPM, MS, 15000, 100},
        {-200 * PPM, MS, 15000, 100},
        {200 * PPM, MS / 4, 15000, 30},
        {200 * PPM, 31250, 15000, 10},
        {-200 * PPM, 10 * MS, 30000, 100},
        {700 * PPM, MS, 30000, 100},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_t *c = chip_new("et1100");
        ect_esc_set_drift(&c->esc, rows[i].ppb);
        uint64_t worst = follow(c, rows[i].samples, rows[i].period_ns);
        uint32_t shown = (uint32_t)chip_read(c, ECT_REG_DC_DIFFERENCE, 4) & 0x7FFFFFFF;
        if (worst > rows[i].within_ns || shown > rows[i].within_ns)
            fail_msg("%d ppb, a sample each %llu ns: after %u expected at most %llu ns, got %llu, 0x092C shows %u",
                     rows[i].ppb, (unsigned long long)rows[i].period_ns, rows[i].samples,
                     (unsigned long long)rows[i].within_ns, (unsigned long long)worst, shown);
        free(c);
    }
}

/* deviation = difference / (5 (start + difference + 2) (start - difference + 2)), data sheet II §2.15.2.6. */
static void speed_difference(void **state)
{
    static const int32_t rates[] = {20, -20, 100, -100, 200};
    (void)state;
    for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++) {
        chip_t *c = chip_new("et1100");
        ect_esc_set_drift(&c->esc, rates[i] * PPM);
        (void)follow(c, 30000, MS);
        int16_t difference = (int16_t)chip_read(c, ECT_REG_DC_SPEED_DIFFERENCE, 2);
        double start = 4096;
        double ppm = 1e6 * difference / (5.0 * (start + difference + 2) * (start - difference + 2));
        if (ppm < rates[i] - 1 || ppm > rates[i] + 1)
            fail_msg("%d ppm: 0x0932 shows %d, which is %f ppm", rates[i], difference, ppm);
        assert_int_equal(chip_write(c, ECT_REG_DC_SPEED_START, 0x1000, 2), 1);
        assert_int_equal(chip_read(c, ECT_REG_DC_SPEED_DIFFERENCE, 2), 0);
        assert_int_equal(chip_read(c, ECT_REG_DC_DIFFERENCE, 4), 0);
        free(c);
    }
}

/* The greatest difference whose deviation does not exceed the rate, for every rate. */
static void speed_difference_exactly(void **state)
{
    static const uint16_t starts[] = {0x1000, 0x0100, 0x3FFF};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof starts / sizeof starts[0]; i++) {
        assert_int_equal(chip_write(c, ECT_REG_DC_SPEED_START, starts[i], 2), 1);
        for (int64_t ppb = 1; ppb < 500000; ppb += 997) {
            c->esc.loop.rate_scaled = -ppb * 65536;
            uint64_t got = chip_read(c, ECT_REG_DC_SPEED_DIFFERENCE, 2);
            uint64_t low = got * 1000000000 / (5 * (starts[i] + got + 2) * (starts[i] - got + 2));
            uint64_t high = (got + 1) * 1000000000 / (5 * (starts[i] + got + 3) * (starts[i] - got + 1));
            if (low > (uint64_t)ppb || high <= (uint64_t)ppb)
                fail_msg("start 0x%04X, %d ppb: 0x0932 shows %u, which is %u to %u ppb", starts[i], (int)ppb,
                         (unsigned int)got, (unsigned int)low, (unsigned int)high);
        }
    }
}

/* A sample that is 80 ns ahead: an eighth is corrected until the next one; the filter depth determines the permanent
 * part. */
static void one_sample(void **state)
{
    static const struct {
        uint8_t depth;
        int64_t after_ms[3]; /* nanoseconds ahead 1, 2, 3 ms later, without another sample */
    } rows[] = {{15, {70, 70, 70}}, {0, {60, 50, 40}}, {2, {67, 65, 62}}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_power_on(c);
        uint64_t on_ns = c->w.now_ns;
        assert_int_equal(chip_write(c, ECT_REG_DC_FILTER + 1, rows[i].depth, 1), 1);
        assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, 0, 4), 1);
        ect_esc_clock_jump(&c->esc, 80);
        c->w.now_ns += MS;
        assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, MS, 4), 1);
        for (unsigned int ms = 0; ms < 3; ms++) {
            c->w.now_ns += MS;
            int64_t ahead = (int64_t)(local_time(c) - (c->w.now_ns - on_ns));
            if (ahead != rows[i].after_ms[ms])
                fail_msg("depth of the rate's filter %u: %u ms after the sample expected %lld ns ahead, got %lld",
                         rows[i].depth, ms + 1, (long long)rows[i].after_ms[ms], (long long)ahead);
        }
    }
}

/* A write of part of the time: the other bytes keep their value. */
static void compared_in_part(void **state)
{
    chip_t *c = *state;
    c->w.now_ns += 0x01020304;
    assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME + 1, 0x04, 1), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_DIFFERENCE, 4), 0x100);
    assert_int_equal(chip_write(c, ECT_REG_DC_SPEED_START, 0x1000, 2), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME + 2, 0x0101, 2), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_DIFFERENCE, 4), 0x80010000);
}

/* A write to 0x0930 resets the loop: the clock keeps only the rate of its oscillator. */
static void unregulated_again(void **state)
{
    chip_t *c = *state;
    ect_esc_set_drift(&c->esc, 100 * PPM);
    (void)follow(c, 1000, MS);
    assert_int_equal(chip_write(c, ECT_REG_DC_SPEED_START, 0x1000, 2), 1);
    uint64_t before = local_time(c);
    c->w.now_ns += SECOND;
    assert_in_range(local_time(c) - before, SECOND + 100000, SECOND + 100001);
    c->w.now_ns += 9 * SECOND;
    assert_in_range(local_time(c) - before, 10 * SECOND + 1000000, 10 * SECOND + 1000001);
}

/* A difference is corrected no faster than the range of the speed counter allows: 763 ppm at the reset value. */
static void fastest(void **state)
{
    static const struct {
        uint16_t start;
        int64_t jump_ns, most_ns, least_ns; /* remaining difference after 100 ms */
    } rows[] = {{0x1000, 1000000, 932000, 922000},
                {0x1000, -1000000, 932000, 922000},
                {0x0100, 1000000, 955000, 950000},
                {0x0000, 1000000, 999000, 998500},
                {0x3FFF, 1000000, 932000, 922000}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_t *c = chip_new("et1100");
        assert_int_equal(chip_write(c, ECT_REG_DC_SPEED_START, rows[i].start, 2), 1);
        (void)follow(c, 2, MS);
        ect_esc_clock_jump(&c->esc, rows[i].jump_ns);
        int64_t left = (int64_t)follow(c, 100, MS);
        if (left < rows[i].least_ns || left > rows[i].most_ns)
            fail_msg("speed counter start 0x%04X, jump %lld: expected %lld to %lld left, got %lld", rows[i].start,
                     (long long)rows[i].jump_ns, (long long)rows[i].least_ns, (long long)rows[i].most_ns,
                     (long long)left);
        free(c);
    }
}

static void lock_limit(void **state)
{
    static const struct {
        int64_t jump_ns;
        bool regulated;
    } rows[] = {{1 << 30, false}, {-(1 << 30), false}, {(1 << 30) - 1, true}, {-(1 << 30) + 1, true}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_t *c = chip_new("et1100");
        (void)follow(c, 2, MS);
        ect_esc_clock_jump(&c->esc, rows[i].jump_ns);
        (void)follow(c, 100, MS);
        bool regulated = (int64_t)(local_time(c) - (c->w.now_ns - 5000 * MS)) != rows[i].jump_ns;
        if (regulated != rows[i].regulated)
            fail_msg("difference of %lld ns: expected regulated %d, got %d", (long long)rows[i].jump_ns,
                     rows[i].regulated, regulated);
        free(c);
    }
}

static void filter(void **state)
{
    chip_t *c = *state;
    static const struct {
        uint8_t depth;
        uint32_t want; /* 1600 ns ahead after a sample without a difference */
    } rows[] = {{0, 1600}, {1, 800}, {4, 100}, {15, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_power_on(c);
        assert_int_equal(chip_write(c, ECT_REG_DC_FILTER, rows[i].depth, 1), 1);
        assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, local_time(c), 4), 1);
        assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, local_time(c) - 1600, 4), 1);
        uint32_t got = (uint32_t)chip_read(c, ECT_REG_DC_DIFFERENCE, 4);
        if (got != (rows[i].want | 0x80000000))
            fail_msg("filter depth %u: expected %u ns ahead, got 0x%08X", rows[i].depth, rows[i].want, got);
    }
}

/* With 0x0142 bit 2 the microcontroller controls the clock, by the time of latch 0; the master cannot. */
static void loop_of_the_pdi(void **state)
{
    chip_t *c = *state;
    c->sii[10] = 0x04;
    chip_power_on(c);
    c->w.now_ns += 5000;
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, 0, 4), 0);
    assert_int_equal(chip_write(c, ECT_REG_DC_OFFSET, 0, 8), 0);
    assert_int_equal(chip_write(c, ECT_REG_DC_SPEED_START, 0, 2), 0);
    ect_esc_latch_input(&c->esc, 0, true);
    c->w.now_ns += 9999;
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    chip_pdi_write(c, ECT_REG_DC_SYSTEM_TIME, 4900, 4);
    assert_int_equal(chip_read(c, ECT_REG_DC_DIFFERENCE, 4), 0x80000000 + 100);
    chip_pdi_write(c, ECT_REG_DC_OFFSET, 100000, 8);
    assert_int_equal(chip_pdi_read(c, ECT_REG_DC_SYSTEM_TIME, 8), 114999);
}

/* --- delays of frames --------------------------------------------------------------------------------------------- */

static void receive_and_system_times(void **state)
{
    chip_t *c = *state;
    const ect_esc_arrival_t arrival = {.unit_ns = 1000, .port_ns = {1000, 5000, 6000, 7000}};
    ect_esc_set_arrival(&c->esc, &arrival);
    c->w.now_ns += 100;
    uint8_t any[4] = {0};
    assert_int_equal(chip_send(c, BWR, 0x0900, any, 1), 1);
    c->w.now_ns += 100;
    assert_int_equal(chip_read(c, 0x0900, 8), 1100 | 5100ull << 32);
    assert_int_equal(chip_read(c, 0x0908, 8), 0); /* closed */
    assert_int_equal(chip_read(c, 0x0918, 8), 1100);
    assert_int_equal(chip_read(c, 0x0910, 8), 1200);
    assert_int_equal(chip_write(c, ECT_REG_DC_DELAY, 1000, 4), 1);
    assert_int_equal(chip_read(c, 0x0910, 8), 200); /* the time at which this frame passed the reference clock */
    assert_int_equal(chip_pdi_read(c, 0x0910, 8), 200);
    assert_int_equal(chip_write(c, 0x0910, 200, 4), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_DIFFERENCE, 4), 0x80000000);
}

static void commands_that_latch(void **state)
{
    static const struct {
        uint8_t command;
        uint16_t ado;
        bool ports, unit;
    } rows[] = {{BWR, 0x0900, true, true},   {FPWR, 0x0900, true, true},   {APWR, 0x0900, false, true},
                {APRW, 0x0900, false, true}, {FPRW, 0x0900, false, true},  {BRW, 0x0900, false, true},
                {BRD, 0x0900, false, false}, {BWR, 0x0901, false, false},  {ARMW, 0x0900, false, false},
                {BWR, 0x0904, false, false}, {FPRD, 0x0900, false, false}, {NOP, 0x0900, false, false}};
    (void)state;
    for (unsigned int chip = 0; chip < 2; chip++) {
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            chip_t *c = chip_new(chip == 0 ? "et1100" : "et1200");
            uint8_t any[4] = {0};
            c->w.now_ns += 4000;
            (void)chip_send(c, rows[i].command, rows[i].ado, any, 1);
            bool want = rows[i].ports || (chip == 1 && rows[i].unit);
            if ((chip_read(c, 0x0900, 4) != 0) != want || (chip_read(c, 0x0918, 4) != 0) != rows[i].unit)
                fail_msg("%s, command %u at 0x%04X: expected receive times %d, of the unit %d", c->personality.name,
                         rows[i].command, rows[i].ado, want, rows[i].unit);
            free(c);
        }
    }
}

/* The bytes of a time are consistent, in whatever pieces they are read. */
static void in_pieces(void **state)
{
    chip_t *c = *state;
    c->w.now_ns += 0x123456789Aull;
    assert_int_equal(chip_read(c, 0x0910, 1), 0x9A);
    c->w.now_ns += 1000 * SECOND;
    assert_int_equal(chip_read(c, 0x0911, 7), 0x12345678);
}

/* --- SYNC0 and SYNC1 -------------------------------------------------------------------------------------------- */

static void start(chip_t *c, uint8_t activation, uint64_t first, uint32_t cycle0, uint32_t cycle1)
{
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0, 1), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, first, 8), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_SYNC0_CYCLE, cycle0 | (uint64_t)cycle1 << 32, 8), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, activation, 1), 1);
}

static bool take(chip_t *c, unsigned int n)
{
    uint32_t event = n == 0 ? ECT_EVENT_SYNC0 : ECT_EVENT_SYNC1;
    bool occurred = (ect_esc_al_event(&c->esc) & event) != 0;
    if (occurred)
        assert_int_equal(chip_pdi_read(c, (uint16_t)(ECT_REG_DC_SYNC0_STATUS + n), 1), 1);
    assert_int_equal(ect_esc_al_event(&c->esc) & event, 0);
    return occurred;
}

/* Lets the clock run in steps of 10 us and writes each pulse as a digit: the number of its step, from the start time
 * on. */
static void record(chip_t *c, char pulses[2][32], unsigned int steps)
{
    memset(pulses, 0, 64);
    for (unsigned int step = 0; step < steps; step++) {
        for (unsigned int n = 0; n < 2; n++)
            pulses[n][step] = take(c, n) ? '|' : '.';
        chip_advance(c, 10000);
    }
}

static void sync1(void **state)
{
    static const struct {
        uint32_t cycle0, cycle1; /* us */
        const char *sync0, *sync1;
    } rows[] = {
        {40, 0, "|...|...|...|...", "|...|...|...|..."},  {40, 10, "|...|...|...|...", ".|...|...|...|.."},
        {40, 30, "|...|...|...|...", "...|...|...|...|"}, {40, 40, "|...|...|...|...", "....|.......|..."},
        {40, 50, "|...|...|...|...", ".....|.......|.."}, {20, 60, "|.|.|.|.|.|.|.|.", "......|.......|."},
        {0, 20, "|...............", "..|............."},  {0, 0, "|...............", "|..............."},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_t *c = chip_new("et1100");
        char pulses[2][32];
        c->sii[3] = 0x88; /* both are AL events */
        chip_power_on(c);
        start(c, 0x07, 100000, 1000 * rows[i].cycle0, 1000 * rows[i].cycle1);
        assert_int_equal(chip_read(c, 0x0984, 1), 3);
        chip_advance(c, 100000);
        record(c, pulses, 16);
        if (strcmp(pulses[0], rows[i].sync0) != 0 || strcmp(pulses[1], rows[i].sync1) != 0)
            fail_msg("cycles %u and %u us: expected\n%s\n%s, got\n%s\n%s", rows[i].cycle0, rows[i].cycle1,
                     rows[i].sync0, rows[i].sync1, pulses[0], pulses[1]);
        assert_int_equal(chip_read(c, 0x0984, 1), 0);
        free(c);
    }
}

/* SYNC1 alone: no SYNC0 occurs, and none is reported as pending. */
static void sync1_alone(void **state)
{
    chip_t *c = *state;
    char pulses[2][32];
    c->sii[3] = 0x88;
    chip_power_on(c);
    start(c, 0x05, 100000, 40000, 10000);
    assert_int_equal(chip_read(c, 0x0984, 1), 2);
    chip_advance(c, 100000);
    record(c, pulses, 8);
    assert_string_equal(pulses[0], "........");
    assert_string_equal(pulses[1], ".|...|..");
    start(c, 0x06, local_time(c) + 10000, 10000, 0); /* both, and not activated */
    assert_int_equal(chip_read(c, 0x0984, 1), 0);
    record(c, pulses, 4);
    assert_string_equal(pulses[0], "....");
}

/* Bits 3 and 7 of 0x0151 enable the events of SYNC0 and SYNC1, and no other bits do. */
static void selected_events(void **state)
{
    static const struct {
        uint8_t config;
        bool sync0, sync1;
    } rows[] = {
        {0x00, false, false}, {0x77, false, false}, {0x08, true, false}, {0x80, false, true}, {0xFF, true, true}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        c->sii[3] = rows[i].config;
        chip_power_on(c);
        start(c, 0x07, 1000, 5000, 1000);
        chip_advance(c, 4000);
        bool sync0 = take(c, 0), sync1 = take(c, 1);
        if (sync0 != rows[i].sync0 || sync1 != rows[i].sync1)
            fail_msg("0x0151 = 0x%02X: expected events %d %d, got %d %d", rows[i].config, rows[i].sync0, rows[i].sync1,
                     sync0, sync1);
    }
}

/* A write that leaves SYNC0 and SYNC1 unchanged does not move their pulses either. */
static void written_again(void **state)
{
    chip_t *c = *state;
    c->sii[3] = 0x08;
    chip_power_on(c);
    start(c, 0x03, 100000, 40000, 0);
    chip_advance(c, 150000);
    assert_true(take(c, 0));
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x03, 1), 1);
    assert_int_equal(chip_read(c, 0x0984, 1), 0);
    chip_advance(c, 30000);
    assert_true(take(c, 0));
    assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), 220000);
}

/* The status shows the pulses that wait for the start time: none of a unit that continues or stops. */
static void each_activation(void **state)
{
    enum { SETTINGS = 8, CYCLIC = 1, BOTH = 6 };
    chip_t *c = *state;
    for (uint8_t before = 0; before < SETTINGS; before++) {
        for (uint8_t after = 0; after < SETTINGS; after++) {
            const bool runs = (after & CYCLIC) != 0 && (after & BOTH) != 0;
            const uint64_t expected = runs && after != before ? after >> 1 : 0;
            start(c, before, local_time(c) + 100000, 40000, 10000);
            chip_advance(c, 150000);
            assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, after, 1), 1);
            const uint64_t got = chip_read(c, 0x0984, 1);
            if (got != expected)
                fail_msg("0x0981 from %u to %u: expected the status %u, got %u", before, after, (unsigned int)expected,
                         (unsigned int)got);
        }
    }
}

/* The chip reports its next time without being read, and its work is done before the next frame. */
static void due_by_itself(void **state)
{
    chip_t *c = *state;
    c->sii[3] = 0x08;
    chip_power_on(c);
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    start(c, 0x03, 100000, 0, 0);
    assert_in_range(ect_esc_due(&c->esc), 0, c->w.now_ns + 100000);
    c->w.now_ns += 100000;
    (void)chip_read(c, 0x0000, 1);
    assert_int_equal(ect_esc_al_event(&c->esc) & ECT_EVENT_SYNC0, ECT_EVENT_SYNC0);
}

/* The start time remains as written until the unit runs. */
static void start_time_kept(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, 0x123456789A, 8), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), 0x123456789A);
    assert_int_equal(chip_read(c, ECT_REG_DC_ACTIVATION, 1), 0);
}

/* The bytes of a next time are consistent: it is sampled when its first byte is read, and by no other access. */
static void next_time_in_pieces(void **state)
{
    static const struct {
        uint16_t address, length;
    } between[] = {{0x098E, 2}, {0x0991, 3}, {0x0998, 8}, {0x0900, 4}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof between / sizeof between[0]; i++) {
        start(c, 0x03, local_time(c) + 1000, 1000, 0);
        uint64_t next = local_time(c) + 1000;
        assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 1), next & 0xFF);
        chip_advance(c, 100000);
        (void)chip_read(c, between[i].address, between[i].length);
        if (chip_read(c, ECT_REG_DC_START_TIME + 1, 7) != next >> 8)
            fail_msg("0x%04X was read between the bytes of the next time: expected the rest of 0x%llX",
                     between[i].address, (unsigned long long)next);
    }
}

static void next_times(void **state)
{
    chip_t *c = *state;
    start(c, 0x07, 100000, 40000, 10000);
    assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), 100000);
    assert_int_equal(chip_read(c, ECT_REG_DC_NEXT_SYNC1, 8), 110000);
    chip_advance(c, 150000);
    assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), 180000);
    assert_int_equal(chip_read(c, ECT_REG_DC_NEXT_SYNC1, 8), 190000);
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x03, 1), 1); /* SYNC1 off: the unit restarts */
    assert_int_equal(chip_read(c, 0x0984, 1), 1);
}

static void pins(void **state)
{
    chip_t *c = *state;
    static const struct {
        uint16_t pulse_length; /* 10 ns */
        const char *levels;
    } rows[] = {{1000, "-____-____-___"}, {2000, "--___--___--__"}, {0, "--------------"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char levels[32] = "";
        ect_store_le16(c->sii + 4, rows[i].pulse_length);
        chip_power_on(c);
        start(c, 0x03, 100000, 50000, 0);
        chip_advance(c, 95000);
        assert_false(ect_esc_sync_pin(&c->esc, 0));
        chip_advance(c, 5000);
        for (unsigned int step = 0; step < strlen(rows[i].levels); step++) {
            levels[step] = ect_esc_sync_pin(&c->esc, 0) ? '-' : '_';
            chip_advance(c, 9999);
            assert_int_equal(ect_esc_sync_pin(&c->esc, 0), levels[step] == '-'); /* to the nanosecond */
            chip_advance(c, 1);
        }
        if (strcmp(levels, rows[i].levels) != 0)
            fail_msg("pulse length %u: expected %s, got %s", rows[i].pulse_length, rows[i].levels, levels);
        (void)chip_pdi_read(c, ECT_REG_DC_SYNC0_STATUS, 1);
        if (rows[i].pulse_length == 0)
            assert_false(ect_esc_sync_pin(&c->esc, 0));
        assert_false(ect_esc_sync_pin(&c->esc, 1));
    }
}

/* A pulse occurs at its time on the chip's clock, however wrong that clock is. */
static void sync_with_drift(void **state)
{
    chip_t *c = *state;
    c->sii[3] = 0x08;
    c->config.drift_ppb = 500 * PPM;
    chip_power_on(c);
    start(c, 0x03, SECOND, 1000000, 0);
    for (unsigned int n = 0; n < 1000; n++) {
        if (n % 100 == 50)
            ect_esc_set_drift(&c->esc, n % 200 == 50 ? -500 * PPM : 500 * PPM);
        uint64_t at = ect_esc_tick(&c->esc, c->w.now_ns);
        c->w.now_ns = at;
        (void)ect_esc_tick(&c->esc, at);
        if (!take(c, 0))
            fail_msg("pulse %u: not there at the reported time", n);
        uint64_t want = SECOND + n * 1000000ull;
        assert_in_range(local_time(c), want, want + 1);
    }
    ect_esc_clock_jump(&c->esc, 10 * (int64_t)MS); /* beyond ten of them */
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    assert_true(take(c, 0));
    assert_int_equal(chip_write(c, ECT_REG_DC_OFFSET, 500000, 8), 1); /* half a cycle later */
    uint64_t at = ect_esc_tick(&c->esc, c->w.now_ns) - c->w.now_ns;
    assert_in_range(at, 499000, 501000);
}

/* The least time at which the clock has the pulse's time, for rates and cycles without a common measure. */
static void sync_at_any_rate(void **state)
{
    static const uint32_t cycles[] = {62501, 999983, 3600001, 500000003};
    chip_t *c = *state;
    c->sii[3] = 0x08;
    for (int32_t ppb = -ECT_ESC_MAX_DRIFT_PPB; ppb <= ECT_ESC_MAX_DRIFT_PPB; ppb += 66683) {
        for (size_t i = 0; i < sizeof cycles / sizeof cycles[0]; i++) {
            c->config.drift_ppb = ppb;
            chip_power_on(c);
            start(c, 0x03, SECOND, cycles[i], 0);
            for (unsigned int n = 0; n < 20; n++) {
                const uint64_t want = SECOND + n * (uint64_t)cycles[i];
                const uint64_t at = ect_esc_tick(&c->esc, c->w.now_ns);
                if (ect_esc_system_time(&c->esc, at - 1) >= want || ect_esc_system_time(&c->esc, at) < want)
                    fail_msg("%d ppb, cycle %u, pulse %u: expected %llu, reported for %llu", ppb, cycles[i], n,
                             (unsigned long long)want, (unsigned long long)ect_esc_system_time(&c->esc, at));
                c->w.now_ns = at;
                (void)ect_esc_tick(&c->esc, at);
                assert_true(take(c, 0));
            }
        }
    }
}

/* Actions of a master or a user while SYNC0 runs, at 150 us, with a cycle of 40 us from 100 us on: the last pulse was
 * at 140 us, whether or not the chip has been read since. */
typedef struct sync_change {
    const char *what;
    uint16_t address, length; /* 0: the clock steps by `value` */
    uint64_t value;
    uint64_t after_ns, next_ns; /* delay and system time of the next pulse */
} sync_change_t;

static void sync_unwatched(void **state)
{
    static const sync_change_t rows[] = {
        {"a longer cycle", ECT_REG_DC_SYNC0_CYCLE, 4, 100000, 40000, 280000},
        {"the system time, back", ECT_REG_DC_OFFSET, 8, 0 - 100000ull, 40000, 180000},
        {"the system time, on", ECT_REG_DC_OFFSET, 8, 1000, 30000, 220000},
        {"the clock, back", 0, 0, 0 - 100000ull, 40000, 180000},
    };
    chip_t *c = *state;
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        const sync_change_t *row = &rows[i / 2];
        const bool reads = i % 2 != 0;
        chip_power_on(c);
        start(c, 0x03, 100000, 40000, 0);
        chip_advance(c, 150000);
        if (reads)
            assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), 180000);
        if (row->length > 0)
            assert_int_equal(chip_write(c, row->address, row->value, row->length), 1);
        else
            ect_esc_clock_jump(&c->esc, (int64_t)row->value);
        assert_int_equal(c->esc.memory[ECT_REG_DC_SYNC0_STATUS], 1);
        chip_advance(c, row->after_ns);
        (void)chip_read(c, ECT_REG_DC_START_TIME, 8);
        if (c->esc.sync[0].next != row->next_ns)
            fail_msg("%s%s: expected the next pulse at %llu, got %llu", row->what, reads ? ", read before" : "",
                     (unsigned long long)row->next_ns, (unsigned long long)c->esc.sync[0].next);
    }
}

/* The same while the control loop changes the rate. */
static void sync_while_regulated(void **state)
{
    chip_t *c = *state;
    c->sii[3] = 0x08;
    c->config.drift_ppb = 300 * PPM;
    chip_power_on(c);
    start(c, 0x03, 10000500, 1000000, 0);
    for (unsigned int n = 0; n < 200; n++) {
        uint64_t end_ns = c->w.now_ns + MS;
        uint64_t at_ns;
        assert_int_equal(chip_write(c, ECT_REG_DC_SYSTEM_TIME, c->w.now_ns - 5000 * MS, 4), 1);
        while ((at_ns = ect_esc_tick(&c->esc, c->w.now_ns)) <= end_ns) {
            c->w.now_ns = at_ns;
            (void)ect_esc_tick(&c->esc, at_ns);
            assert_true(take(c, 0));
            assert_in_range(local_time(c) % 1000000, 500, 501);
        }
        c->w.now_ns = end_ns;
    }
}

/* A master computes the offset from two clocks: the clock of the chip may have started long before the other clock. */
static void sync_with_offset(void **state)
{
    static const int64_t offsets[] = {0, 1, 1000000000000000000, -1, -1000000, -999999999};
    chip_t *c = *state;
    c->sii[3] = 0x08;
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; i++) {
        chip_power_on(c);
        c->w.now_ns += SECOND;
        assert_int_equal(chip_write(c, ECT_REG_DC_OFFSET, (uint64_t)offsets[i], 8), 1);
        start(c, 0x03, local_time(c) + 5000, 1000, 0);
        for (uint64_t pulse = 0; pulse < 3; pulse++) {
            uint64_t got = ect_esc_tick(&c->esc, c->w.now_ns) - c->w.now_ns;
            uint64_t want = pulse == 0 ? 5000 : 1000;
            if (got != want)
                fail_msg("offset %lld: expected pulse %u after %u ns, got %lld", (long long)offsets[i],
                         (unsigned int)pulse, (unsigned int)want, (long long)got);
            chip_advance(c, want);
            assert_true(take(c, 0));
        }
    }
}

/* For any distance: the clock reaches its value at the reported time, and not a nanosecond before. */
static void far_away(void **state)
{
    static const struct {
        int32_t drift_ppb;
        uint64_t wait_ns;
        bool ever;
    } rows[] = {{ECT_ESC_MAX_DRIFT_PPB, 1ull << 62, true},
                {-ECT_ESC_MAX_DRIFT_PPB, 1ull << 62, true},
                {ECT_ESC_MAX_DRIFT_PPB, 1000000007, true},
                {-ECT_ESC_MAX_DRIFT_PPB, 1000000007, true},
                {333333, 123456789, true},
                {-333333, 1, true},
                {0, INT64_MAX - 5000 * MS, true},
                {0, INT64_MAX - 5000 * MS + 1, false}};
    chip_t *c = *state;
    c->sii[3] = 0x08;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        c->config.drift_ppb = rows[i].drift_ppb;
        chip_power_on(c);
        start(c, 0x03, rows[i].wait_ns, 0, 0);
        uint64_t at = ect_esc_tick(&c->esc, c->w.now_ns);
        bool right = rows[i].ever ? at != UINT64_MAX && ect_esc_system_time(&c->esc, at) >= rows[i].wait_ns &&
                                        ect_esc_system_time(&c->esc, at - 1) < rows[i].wait_ns
                                  : at == UINT64_MAX;
        if (!right)
            fail_msg("%d ppb, a pulse in %llu ns: reported for %llu", rows[i].drift_ppb,
                     (unsigned long long)rows[i].wait_ns, (unsigned long long)at);
    }
}

/* --- activation of newer chips ---------------------------------------------------------------------------------- */

static int modern(void **state)
{
    chip_t *c = chip_new("ipcore");
    c->sii[3] = 0x88;
    chip_power_on(c);
    *state = c;
    return 0;
}

static void auto_activation(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, ECT_REG_DC_SYNC0_CYCLE, 1000, 4), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x02, 1), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, 50000, 8), 1); /* not enabled */
    assert_int_equal(chip_read(c, ECT_REG_DC_ACTIVATION, 1), 0x02);
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x0A, 1), 1);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, 50000, 4), 1); /* half of it */
    assert_int_equal(chip_read(c, ECT_REG_DC_ACTIVATION, 1), 0x0A);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, 50000, 8), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_ACTIVATION, 1), 0x0B);
    chip_advance(c, 50000);
    assert_true(take(c, 0));
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0, 1), 1);
    chip_advance(c, 5 * SECOND); /* the lower 32 bits of the time have wrapped */
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x1A, 1), 1);
    uint64_t soon = local_time(c) + 100000;
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, soon, 4), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), soon);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, soon - 200000, 4),
                     1); /* in the past: the next matching time */
    assert_int_equal(c->esc.sync[0].next, soon - 200000 + 0x100000000ull);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, soon, 3), 1); /* incomplete */
    assert_int_equal(c->esc.sync[0].next, soon - 200000 + 0x100000000ull);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME + 3, soon >> 24, 1), 1); /* the last byte */
    assert_int_equal(c->esc.sync[0].next & 0xFFFFFFFF, soon & 0xFFFFFFFF);
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, local_time(c), 4), 1); /* the present nanosecond has passed */
    assert_int_equal(c->esc.sync[0].next, local_time(c) + 0x100000000ull);
}

/* A start time that is written while the unit runs takes effect. */
static void restarted_by_its_start_time(void **state)
{
    chip_t *c = *state;
    start(c, 0x0F, 100000, 40000, 0);
    chip_advance(c, 110000);
    assert_true(take(c, 0));
    assert_int_equal(chip_write(c, ECT_REG_DC_START_TIME, 500000, 8), 1);
    chip_advance(c, 380000);
    assert_false(take(c, 0));
    chip_advance(c, 10000);
    assert_true(take(c, 0));
}

static void plausibility(void **state)
{
    chip_t *c = *state;
    static const struct {
        uint8_t activation;
        uint64_t ahead_ns; /* 2^63 and more: in the past */
        bool at_once;
    } rows[] = {{0x03, 3000000000, false},
                {0x23, 3000000000, false},
                {0x63, 3000000000, true},
                {0x63, 2000000000, false},
                {0x63, 0x80000000, true},
                {0x63, 0x7FFFFFFF, false},
                {0x23, (uint64_t)-1000, true},
                {0x03, (uint64_t)-1000, false},
                {0x23, 0, true},
                {0x63, 0, true},
                {0x03, 0, false},
                {0x23, 1, false},
                {0x63, 1, false},
                {0x03, 1, false},
                {0x23, INT64_MAX, false},
                {0x23, 1ull << 63, true}};
    chip_advance(c, 10000);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        start(c, rows[i].activation, local_time(c) + rows[i].ahead_ns, 0, 0);
        (void)ect_esc_tick(&c->esc, c->w.now_ns);
        bool occurred = take(c, 0);
        bool reported = (chip_read(c, 0x0984, 1) & 4) != 0;
        if (occurred != rows[i].at_once || reported != rows[i].at_once)
            fail_msg("0x0981 = 0x%02X, start in %lld ns: expected a pulse at once %d, got %d, reported %d",
                     rows[i].activation, (long long)rows[i].ahead_ns, rows[i].at_once, occurred, reported);
    }
}

static void debug_pulse(void **state)
{
    chip_t *c = *state;
    uint32_t activity = ect_esc_activity(&c->esc);
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x84, 1), 1);
    assert_int_not_equal(ect_esc_activity(&c->esc), activity);
    assert_int_equal(chip_read(c, ECT_REG_DC_ACTIVATION, 1), 0x04);
    assert_true(take(c, 1));
    assert_false(take(c, 0));
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0x88, 1), 1); /* of neither */
    assert_int_equal(chip_read(c, ECT_REG_DC_SYNC0_STATUS, 8), 0);
    assert_int_equal(chip_read(c, ECT_REG_DC_START_TIME, 8), 0);
    c->personality = *ect_esc_personality("et1100"); /* a chip without this feature */
    chip_power_on(c);
    assert_int_equal(chip_write(c, ECT_REG_DC_ACTIVATION, 0xFC, 1), 1);
    assert_int_equal(chip_read(c, ECT_REG_DC_ACTIVATION, 1), 0x04);
    assert_false(take(c, 1));
}

static void assigned_control(void **state)
{
    chip_t *c = *state;
    static const struct {
        uint8_t control;
        uint16_t address;
        bool pdi;
    } rows[] = {{0x00, 0x0981, false}, {0x01, 0x0981, true}, {0x01, 0x0990, true},  {0x01, 0x09A0, true},
                {0x00, 0x09A4, false}, {0x01, 0x09A4, true}, {0x02, 0x09A4, true},  {0x03, 0x09A4, false},
                {0x00, 0x09A8, false}, {0x10, 0x09A8, true}, {0x10, 0x09A9, false}, {0x20, 0x09A9, true}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_power_on(c);
        assert_int_equal(chip_write(c, ECT_REG_DC_CYCLIC_CONTROL, rows[i].control, 1), 1);
        unsigned int wkc = chip_write(c, rows[i].address, 0x02, 1);
        c->memory[rows[i].address] = 0;
        chip_pdi_write(c, rows[i].address, 0x02, 1);
        bool pdi = c->memory[rows[i].address] != 0;
        if (wkc != (rows[i].pdi ? 0 : 1) || pdi != rows[i].pdi)
            fail_msg("0x0980 = 0x%02X: 0x%04X: expected the PDI's %d, got WKC %u, PDI %d", rows[i].control,
                     rows[i].address, rows[i].pdi, wkc, pdi);
    }
}

/* A write to the controls of both latches counts if one of them belongs to the side, and changes only that one. */
static void assigned_latches(void **state)
{
    enum { CONTROL = 0x09A8, BOTH = 0x0303 };
    chip_t *c = *state;
    for (unsigned int pdi = 0; pdi < 4; pdi++) {
        const uint16_t of_pdi = (uint16_t)((pdi & 1) * 0x03 | (pdi >> 1) * 0x0300);
        chip_power_on(c);
        assert_int_equal(chip_write(c, ECT_REG_DC_CYCLIC_CONTROL, pdi << 4, 1), 1);
        const unsigned int wkc = chip_write(c, CONTROL, BOTH, 2);
        const uint16_t by_master = ect_load_le16(c->memory + CONTROL);
        chip_pdi_write(c, CONTROL, 0, 2);
        const uint16_t by_pdi = ect_load_le16(c->memory + CONTROL);
        chip_pdi_write(c, CONTROL, BOTH, 2);
        if (wkc != (pdi < 3 ? 1 : 0) || by_master != (BOTH & ~of_pdi) || by_pdi != by_master ||
            ect_load_le16(c->memory + CONTROL) != BOTH)
            fail_msg("0x0980 = 0x%02X: got WKC %u, 0x%04X by the master, 0x%04X after the PDI", pdi << 4, wkc,
                     by_master, by_pdi);
    }
}

/* --- latch inputs ----------------------------------------------------------------------------------------------- */

static void edge(chip_t *c, unsigned int n, bool level, uint64_t at_ns)
{
    c->w.now_ns = 5000 * MS + at_ns;
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    ect_esc_latch_input(&c->esc, n, level);
}

static void continuous(void **state)
{
    chip_t *c = *state;
    for (unsigned int n = 0; n < 2; n++) {
        uint16_t times = (uint16_t)(ECT_REG_DC_LATCH_TIME + 16 * n);
        uint64_t base = 10000 * n;
        edge(c, n, true, base + 1003);
        edge(c, n, true, base + 1100); /* no edge */
        edge(c, n, false, base + 2003);
        assert_int_equal(chip_read(c, 0x0210, 2) & 1, 0);
        (void)chip_read(c, ECT_REG_DC_LATCH_TIME + 32, 8); /* there are no further ones */
        assert_int_equal(chip_read(c, times, 8), base + 1003);
        assert_int_equal(chip_read(c, (uint16_t)(times + 8), 8), base + 2003);
        edge(c, n, true, base + 3003);
        assert_int_equal(chip_read(c, times, 8), base + 3003);
        assert_int_equal(chip_read(c, (uint16_t)(ECT_REG_DC_LATCH_STATUS + n), 1) & 3, 0);
        assert_int_equal(chip_read(c, 0x0210, 2) & 1, 0);
    }
}

static void single_event(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, ECT_REG_DC_LATCH_CONTROL, 0x03, 1), 1);
    edge(c, 0, true, 1000);
    edge(c, 0, false, 2000);
    edge(c, 0, true, 3000);
    edge(c, 0, false, 4000);
    assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 1), 3);
    assert_int_equal(chip_read(c, 0x0210, 2) & 1, 1);
    assert_int_equal(chip_read(c, 0x09B0, 8), 1000);
    assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 1), 2);
    assert_int_equal(chip_read(c, 0x0210, 2) & 1, 1);
    assert_int_equal(chip_read(c, 0x09B8, 8), 2000);
    assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 1), 0);
    assert_int_equal(chip_read(c, 0x0210, 2) & 1, 0);
    edge(c, 0, true, 5000);
    assert_int_equal(chip_pdi_read(c, 0x09B0, 8), 5000); /* the PDI cannot take it */
    assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 1), 1);
}

/* From power-on: both latches for single events, with both edges of each. */
static void all_edges(chip_t *c)
{
    c->w.now_ns = 5000 * MS;
    chip_power_on(c);
    assert_int_equal(chip_write(c, ECT_REG_DC_LATCH_CONTROL, 0x0303, 2), 1);
    for (unsigned int n = 0; n < 2; n++) {
        edge(c, n, true, 1000 + 2000 * n);
        edge(c, n, false, 2000 + 2000 * n);
    }
}

/* Each byte of a time belongs to its edge only. */
static void latch_read_in_part(void **state)
{
    chip_t *c = *state;
    for (unsigned int edges = 0; edges < 4; edges++) {
        unsigned int n = edges / 2;
        for (unsigned int byte = 0; byte < 8; byte++) {
            all_edges(c);
            (void)chip_read(c, (uint16_t)(ECT_REG_DC_LATCH_TIME + 8 * edges + byte), 1);
            unsigned int want = 0x0303u & ~(1u << (edges % 2 + 8 * n));
            unsigned int got = (unsigned int)chip_read(c, ECT_REG_DC_LATCH_STATUS, 2);
            if (got != want)
                fail_msg("byte %u of 0x%04X was read: expected 0x09AE = 0x%04X, got 0x%04X", byte,
                         ECT_REG_DC_LATCH_TIME + 8 * edges, want, got);
        }
    }
}

/* A write to the control of a latch makes that latch wait again, and does not affect the other. */
static void latch_waits_again(void **state)
{
    chip_t *c = *state;
    for (unsigned int n = 0; n < 2; n++) {
        all_edges(c);
        assert_int_equal(chip_write(c, (uint16_t)(ECT_REG_DC_LATCH_CONTROL + n), 0x03, 1), 1);
        assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 2), n == 0 ? 0x0300 : 0x0003);
        assert_int_equal(chip_read(c, 0x0210, 2) & 1, 1);
        assert_int_equal(chip_write(c, (uint16_t)(ECT_REG_DC_LATCH_CONTROL + 1 - n), 0x03, 1), 1);
        assert_int_equal(chip_read(c, 0x0210, 2) & 1, 0); /* nothing is left to read */
        assert_int_equal(chip_write(c, (uint16_t)(ECT_REG_DC_LATCH_CONTROL + n), 0xFD, 1), 1);
        assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_CONTROL, 2), n == 0 ? 0x0301 : 0x0103);
    }
}

static void latch_of_the_pdi(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, ECT_REG_DC_CYCLIC_CONTROL, 0x20, 1), 1);
    chip_pdi_write(c, ECT_REG_DC_LATCH_CONTROL + 1, 0x01, 1);
    edge(c, 1, true, 1000);
    assert_int_equal(ect_esc_al_event(&c->esc) & ECT_EVENT_LATCH, ECT_EVENT_LATCH);
    assert_int_equal(chip_read(c, 0x0210, 2) & 1, 0);
    assert_int_equal(chip_read(c, 0x09C0, 8), 1000);
    assert_int_equal(ect_esc_al_event(&c->esc) & ECT_EVENT_LATCH, ECT_EVENT_LATCH);
    assert_int_equal(chip_pdi_read(c, 0x09C0, 8), 1000);
    assert_int_equal(ect_esc_al_event(&c->esc) & ECT_EVENT_LATCH, 0);
}

static void pin_state(void **state)
{
    chip_t *c = *state;
    edge(c, 0, true, 1000);
    assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 1), 4);
    edge(c, 0, false, 2000);
    assert_int_equal(chip_read(c, ECT_REG_DC_LATCH_STATUS, 1), 0);
    c->personality.features = 0;
    chip_power_on(c);
    edge(c, 0, true, 3000); /* a chip without clocks has no such input */
    assert_int_equal(c->memory[ECT_REG_DC_LATCH_STATUS], 0);
}

#define TEST(title, function)   {title, function, chip_setup, chip_teardown, NULL}
#define MODERN(title, function) {title, function, modern, chip_teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-087: a clock with a drift gains or loses a constant rate, over a hundred years too", drift),
        TEST("CF-087: a changing drift loses no fraction, and the clock never decreases", drift_in_steps),
        TEST("CF-088: the control loop follows a clock that differs by up to 700 ppm, at any cycle", loop_settles),
        TEST("CF-088: the speed counter difference shows the deviation by the data sheet's formula", speed_difference),
        TEST("CF-088: a difference is corrected no faster than the range of the speed counter allows", fastest),
        TEST("CF-088: the speed counter difference is the greatest value that the rate permits",
             speed_difference_exactly),
        TEST("CF-088: a sample corrects an eighth of its difference, in part permanently", one_sample),
        TEST("CF-088: a write to the speed counter's start resets the control loop", unregulated_again),
        TEST("CF-088: a system time that is written in part is compared in that part", compared_in_part),
        TEST("CF-088: a difference of 2^30 ns, ahead or behind, is shown and not corrected; a smaller one is",
             lock_limit),
        TEST("CF-088: 0x092C is a mean over the filter's depth", filter),
        TEST("CF-088: a loop that belongs to the PDI compares with latch 0, and refuses the master", loop_of_the_pdi),
        TEST("CF-087: receive and system times are those of the frame at this chip, minus the delay",
             receive_and_system_times),
        TEST("CF-087: the commands that latch receive times, on an ET1100 and on an ET1200", commands_that_latch),
        TEST("CF-087: a system time that is read in pieces is one time", in_pieces),
        TEST("CF-089: SYNC1 follows SYNC0 by its cycle time, and then the first SYNC0 after itself", sync1),
        TEST("CF-089: SYNC1 occurs without SYNC0", sync1_alone),
        TEST("CF-089: 0x0151 selects which of SYNC0 and SYNC1 are events", selected_events),
        TEST("CF-089: a repeated write of the activation does not move the pulses", written_again),
        TEST("CF-089: the unit starts with any change of its activation, SYNC0 or SYNC1 that leaves it running",
             each_activation),
        TEST("CF-089: a pulse is due from its activation on, without any access", due_by_itself),
        TEST("CF-089: a start time is kept until the unit runs", start_time_kept),
        TEST("CF-089: a next time that is read in pieces is one time", next_time_in_pieces),
        TEST("CF-089: the times of the next pulses are read", next_times),
        TEST("CF-089: a pin is active for the length of the pulse, or until it is acknowledged", pins),
        TEST("CF-089 CF-090: SYNC0 follows the chip's own clock, to the nanosecond", sync_with_drift),
        TEST("CF-089 CF-090: the reported time of a pulse is the first of its system time, at any rate",
             sync_at_any_rate),
        TEST("CF-089: a change while SYNC0 runs takes effect at once", sync_unwatched),
        TEST("CF-089 CF-090: SYNC0 follows the chip's own clock while the control loop changes its rate",
             sync_while_regulated),
        TEST("CF-087 CF-089: SYNC0 is on time with an offset of either sign", sync_with_offset),
        TEST("CF-089: the reported time of a pulse is exact at any distance; beyond 2^63 ns none is reported",
             far_away),
        MODERN("CF-089: a start time that is written while the unit runs restarts it", restarted_by_its_start_time),
        MODERN("CF-089: a start time that is written activates by itself, and 32 bits of it are enough",
               auto_activation),
        MODERN("CF-089: a start time outside the near future may mean now", plausibility),
        MODERN("CF-089: a debug pulse starts at once, on chips that support it", debug_pulse),
        TEST("CF-089 CF-091: the master assigns the control of SYNC0, SYNC1 and the latches", assigned_control),
        TEST("CF-091: a write to both latch controls changes those of its side", assigned_latches),
        TEST("CF-091: continuous: each edge of a latch input is latched", continuous),
        TEST("CF-091: single event: the first edge is kept until it is read", single_event),
        TEST("CF-091: an edge is acknowledged by any byte of its time, and by no other's", latch_read_in_part),
        TEST("CF-091: a latch whose control is written waits again, the other one continues", latch_waits_again),
        TEST("CF-091: the event of a latch goes to the side that controls it, which acknowledges it by reading",
             latch_of_the_pdi),
        MODERN("CF-091: newer chips show the level of the latch inputs", pin_state),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC clocks", tests, NULL, NULL);
}
