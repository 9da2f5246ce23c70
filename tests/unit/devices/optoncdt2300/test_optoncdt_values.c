/* SPDX-License-Identifier: MIT */
/*
 * The records of an optoNCDT 2300, their times, and those that a master reads; from public pages of the manual: values
 * (§8.2.2, §9.2), oversampling (A 7.6), distributed clocks (A 7.7).
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "devices/optoncdt2300/optoncdt2300.h"
#include "seams/wave.h"
#include "support/ranger.h"

enum { PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP, ERR = 0x10 };
enum { ALL = (1 << OPTO_VALUES) - 1 };
enum { MM = 1000000 };
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static ranger_t r;

static int setup(void **state)
{
    (void)state;
    ranger_open(&r);
    ranger_expert(&r);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    ranger_close(&r);
    return 0;
}

/* Everything, one record at a time. */
static int setup_all(void **state)
{
    setup(state);
    ranger_select(&r, ALL, 1);
    ranger_go(&r, OP);
    return 0;
}

static void want(const char *when, unsigned int value, int32_t expected)
{
    int32_t got = ranger_value(&r, value);
    if (got != expected)
        fail_msg("%s: value %u: expected %d (%08X), got %d (%08X)", when, value, expected, (uint32_t)expected, got,
                 (uint32_t)got);
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static void first_values(void **state)
{
    (void)state;
    ranger_wait(&r, 10 * MS);
    want("50 us", OPTO_EXPOSURE, 4000);
    want("25 degC", OPTO_TEMPERATURE, 100);
    want("50 %", OPTO_INTENSITY_1, 512);
    want("10 mm", OPTO_DISTANCE_1, 10 * MM);
    want("one surface", OPTO_INTENSITY_2, 0);
    want("one surface", OPTO_DISTANCE_2, 0x7FFFFFFB);
    want("one surface", OPTO_STATE, 0xB0);
    want("one surface", OPTO_DIFFERENCE, 0x7FFFFFF8);
    want("it does not move", OPTO_MINIMUM, 10 * MM);
    want("it does not move", OPTO_MAXIMUM, 10 * MM);
    want("it does not move", OPTO_PEAK_TO_PEAK, 0);
}

static void settings_of_the_plant(void **state)
{
    static const struct {
        const char *name, *value;
        unsigned int which;
        int32_t want;
    } rows[] = {{"surface1.distance", "0", OPTO_DISTANCE_1, 0},
                {"surface1.distance", "12.345678", OPTO_DISTANCE_1, 12345678},
                {"surface1.distance", "20", OPTO_DISTANCE_1, 20 * MM},
                {"surface1.intensity", "100", OPTO_INTENSITY_1, 1023},
                {"surface1.intensity", "0.1", OPTO_INTENSITY_1, 1},
                {"temperature", "-55", OPTO_TEMPERATURE, -220},
                {"temperature", "127", OPTO_TEMPERATURE, 508},
                {"temperature", "-0.25", OPTO_TEMPERATURE, -1},
                {"exposure", "0.0125", OPTO_EXPOSURE, 0},
                {"exposure", "0.1", OPTO_EXPOSURE, 8},
                {"exposure", "1310", OPTO_EXPOSURE, 4000} /* a period of 20 kHz is 50 us */};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        signal_set(&r.w, rows[i].name, rows[i].value);
        ranger_wait(&r, 1 * MS);
        want(rows[i].value, rows[i].which, rows[i].want);
    }
}

/* Each error: its cause, its code, and its end. */
static void errors(void **state)
{
    static const struct {
        const char *name, *wrong, *right;
        int32_t code;
        const char *why;
    } rows[] = {{"surface1.present", "0", "1", 0x7FFFFFFB, "no peak"},
                {"surface1.intensity", "0", "50", 0x7FFFFFFB, "no peak"},
                {"surface1.distance", "-0.001", "10", 0x7FFFFFFA, "before"},
                {"surface1.distance", "20.001", "10", 0x7FFFFFF9, "behind"},
                {"surface1.fault", "8", "0", 0x7FFFFFF8, "calculated"},
                {"surface1.fault", "7", "0", 0x7FFFFFF7, "evaluated"},
                {"surface1.fault", "6", "0", 0x7FFFFFF6, "wide"},
                {"laser", "0", "1", 0x7FFFFFF5, "off"},
                {"laser_power", "2", "0", 0x7FFFFFF5, "off"}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char why[ECT_SIGNAL_TEXT_ROOM];
        signal_set(&r.w, rows[i].name, rows[i].wrong);
        ranger_wait(&r, 1 * MS);
        want(rows[i].name, OPTO_DISTANCE_1, rows[i].code);
        assert_int_equal(ranger_value(&r, OPTO_STATE) & 0xF, rows[i].code & 0xF);
        signal_get(&r.w, "error1", why);
        if (!strstr(why, rows[i].why))
            fail_msg("%s=%s: the reason is '%s'", rows[i].name, rows[i].wrong, why);
        signal_set(&r.w, rows[i].name, rows[i].right);
        ranger_wait(&r, 1 * MS);
        want(rows[i].name, OPTO_DISTANCE_1, 10 * MM);
        assert_int_equal(ranger_value(&r, OPTO_STATE) & 0xF, 0);
    }
    want("errors do not count", OPTO_PEAK_TO_PEAK, 0);
}

static void two_surfaces(void **state)
{
    (void)state;
    signal_set(&r.w, "surface2.present", "1");
    signal_set(&r.w, "surface2.distance", "12.5");
    signal_set(&r.w, "surface2.intensity", "10");
    ranger_wait(&r, 1 * MS);
    want("both", OPTO_DISTANCE_2, 12500000);
    want("both", OPTO_INTENSITY_2, 102);
    want("both", OPTO_DIFFERENCE, 2500000);
    want("both", OPTO_STATE, 0);
    signal_set(&r.w, "surface1.present", "0");
    ranger_wait(&r, 1 * MS);
    want("the second alone", OPTO_DISTANCE_2, 12500000);
    want("the second alone", OPTO_DIFFERENCE, 0x7FFFFFF8);
}

static void laser_power(void **state)
{
    (void)state;
    ranger_write(&r, 0x2131, 1, 1, 1);
    ranger_wait(&r, 1 * MS);
    want("reduced", OPTO_INTENSITY_1, 256);
    want("reduced", OPTO_DISTANCE_1, 10 * MM);
    ranger_write(&r, 0x2131, 1, 2, 1);
    ranger_wait(&r, 1 * MS);
    want("off", OPTO_DISTANCE_1, 0x7FFFFFF5);
    ranger_write(&r, 0x2131, 1, 0, 1);
    ranger_wait(&r, 1 * MS);
    want("full", OPTO_INTENSITY_1, 512);
}

/* SDOs read the last measurement; without process data it is at most 10 ms old. */
static void by_sdo(void **state)
{
    (void)state;
    signal_set(&r.w, "surface1.distance", "7");
    wire_advance(&r.w, 10 * MS);
    assert_int_equal(ranger_number(&r, 0x6065, 5), 7 * MM);
    uint32_t counter = ranger_number(&r, 0x6065, 2);
    wire_advance(&r.w, 10 * MS);
    assert_int_equal(ranger_number(&r, 0x6065, 2), counter + 200);
}

static void statistics(void **state)
{
    (void)state;
    signal_set(&r.w, "surface1.distance", "8");
    ranger_wait(&r, 1 * MS);
    signal_set(&r.w, "surface1.distance", "11");
    ranger_wait(&r, 1 * MS);
    want("from 8 to 11", OPTO_MINIMUM, 8 * MM);
    want("from 8 to 11", OPTO_MAXIMUM, 11 * MM);
    want("from 8 to 11", OPTO_PEAK_TO_PEAK, 3 * MM);
    ranger_write(&r, 0x2181, 1, 0, 1); /* FALSE resets nothing */
    ranger_wait(&r, 1 * MS);
    want("still", OPTO_PEAK_TO_PEAK, 3 * MM);
    ranger_write(&r, 0x2181, 1, 1, 1);
    assert_int_equal(ranger_number(&r, 0x2181, 1), 0);
    ranger_wait(&r, 1 * MS);
    want("reset", OPTO_MINIMUM, 11 * MM);
    want("reset", OPTO_PEAK_TO_PEAK, 0);
    signal_set(&r.w, "surface1.present", "0");
    signal_set(&r.w, "statistic_reset", "1");
    ranger_wait(&r, 1 * MS);
    want("nothing counted", OPTO_MINIMUM, 0x7FFFFFF8);
    want("nothing counted", OPTO_MAXIMUM, 0x7FFFFFF8);
    want("nothing counted", OPTO_PEAK_TO_PEAK, 0x7FFFFFF8);
}

/* --- what moves --------------------------------------------------------------------------------------------------- */

static void sources(void **state)
{
    (void)state;
    signal_set(&r.w, "surface1.amplitude", "4");
    signal_set(&r.w, "surface1.period", "100000");
    signal_set(&r.w, "surface1.source", "1");
    for (unsigned int i = 1; i < 250; i++) {
        ranger_wait(&r, 1 * MS);
        want("ramp", OPTO_DISTANCE_1, (int32_t)(10 * MM + (i % 100) * 4 * MM / 100));
    }
    signal_set(&r.w, "surface1.source", "2");
    for (unsigned int i = 1; i < 250; i++) {
        ranger_wait(&r, 1 * MS);
        double exact = 10e6 + 4e6 * sin(2 * 3.14159265358979 * i / 100.0);
        if (fabs(exact - ranger_value(&r, OPTO_DISTANCE_1)) > 1)
            fail_msg("sine, %u ms: expected %f, got %d", i, exact, ranger_value(&r, OPTO_DISTANCE_1));
    }
    signal_set(&r.w, "surface1.source", "0");
    ranger_wait(&r, 1 * MS);
    want("as it is", OPTO_DISTANCE_1, 10 * MM);
}

static void noise(void **state)
{
    enum { RECORDS = 500 };
    static int32_t seen[2][RECORDS];
    double sum = 0, squares = 0;
    (void)state;
    for (unsigned int round = 0; round < 2; round++) {
        signal_set(&r.w, "surface1.noise", "0");
        ranger_wait(&r, 1 * MS);
        signal_set(&r.w, "surface1.noise", "0.002");
        signal_set(&r.w, "seed", "7");
        for (unsigned int i = 0; i < RECORDS; i++) {
            ranger_wait(&r, 1 * MS);
            seen[round][i] = ranger_value(&r, OPTO_DISTANCE_1);
        }
    }
    assert_memory_equal(seen[0], seen[1], sizeof seen[0]); /* the same for the same seed */
    for (unsigned int i = 0; i < RECORDS; i++) {
        sum += seen[0][i] - 10e6;
        squares += (seen[0][i] - 10e6) * (seen[0][i] - 10e6);
    }
    assert_true(fabs(sum / (double)RECORDS) < 400);
    assert_true(fabs(sqrt(squares / (double)RECORDS) - 2000) < 300);
}

static void table(void **state)
{
    static const struct {
        const char *row1, *row2, *present;
        int32_t want1, want2;
    } rows[] = {{"5", "6", "1", 5 * MM, 6 * MM},
                {"5.5", "7", "1", 5500000, 7 * MM},
                {"1", "2", "0", 0x7FFFFFFB, 0x7FFFFFFB},
                {"30", "1", "1", 0x7FFFFFF9, 1 * MM}};
    const size_t many = COUNT(rows) < OPTO_TABLE ? COUNT(rows) : OPTO_TABLE;
    char message[ECT_SIGNAL_MESSAGE];
    (void)state;
    signal_set(&r.w, "surface2.present", "1");
    signal_set(&r.w, "surface1.source", "3");
    ranger_wait(&r, 1 * MS);
    want("an empty table", OPTO_DISTANCE_1, 10 * MM);
    for (size_t i = 0; i < many; i++) {
        signal_set(&r.w, "row1", rows[i].row1);
        signal_set(&r.w, "row2", rows[i].row2);
        signal_set(&r.w, "row_present", rows[i].present);
        signal_set(&r.w, "row_add", "1");
    }
    signal_set(&r.w, "row_time", "2000");
    signal_set(&r.w, "surface1.source", "3"); /* begins with the first row */
    signal_set(&r.w, "surface2.source", "3");
    for (size_t i = 0; i < 3 * many; i++) {
        ranger_wait(&r, 1 * MS);
        want("table", OPTO_DISTANCE_1, rows[i % many].want1);
        want("table", OPTO_DISTANCE_2, rows[i % many].want2);
        ranger_wait(&r, 1 * MS);
    }
    for (size_t i = many; i < OPTO_TABLE; i++)
        signal_set(&r.w, "row_add", "1");
    assert_false(signal_try_set(&r.w, "row_add", "1", message));
    assert_non_null(strstr(message, "full"));
    signal_set(&r.w, "row_clear", "1");
    assert_int_equal(signal_number(&r.w, "rows"), 0);
}

/* --- when --------------------------------------------------------------------------------------------------------- */

/* Each rate: the number of records per second, and their times. */
static void rates(void **state)
{
    static const struct {
        uint32_t hz, period_ns, in_a_second;
    } rows[] = {{1500, 666667, 1499},  {2500, 400000, 2500},  {5000, 200000, 5000}, {10000, 100000, 10000},
                {20000, 50000, 20000}, {30000, 33333, 30000}, {49140, 20350, 49140}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ranger_write(&r, 0x2250, 1, rows[i].hz, 4);
        ranger_wait(&r, 2 * MS);
        opto_t *u = ranger_instance(&r);
        uint64_t before = u->taken, from_ns = u->next_ns;
        wire_advance(&r.w, 1000 * MS);
        opto_advance(u, r.w.now_ns);
        if (u->taken - before != (u->next_ns - from_ns) / rows[i].period_ns ||
            u->taken - before < rows[i].in_a_second || u->taken - before > rows[i].in_a_second + 1)
            fail_msg("%u Hz: %u records in a second", rows[i].hz, (unsigned int)(u->taken - before));
    }
    ranger_write(&r, 0x2250, 1, 1500, 4);
    ranger_wait(&r, 2 * MS);
    int32_t counter = ranger_value(&r, OPTO_COUNTER), timestamp = ranger_value(&r, OPTO_TIMESTAMP);
    for (unsigned int i = 0; i < 20; i++) {
        ranger_wait(&r, 1 * MS);
        int32_t records = ranger_value(&r, OPTO_COUNTER) - counter;
        assert_in_range((uint32_t)records, 1, 2);
        assert_in_range((uint32_t)(ranger_value(&r, OPTO_TIMESTAMP) - timestamp), (uint32_t)records * 666,
                        (uint32_t)records * 667);
        counter += records;
        timestamp = ranger_value(&r, OPTO_TIMESTAMP);
    }
    signal_set(&r.w, "rate", "10000");
    assert_int_equal(ranger_number(&r, 0x2250, 1), 10000);
}

/* Process data are no older than 250 us, or a period. */
static void fresh(void **state)
{
    (void)state;
    wire_advance(&r.w, 10 * MS); /* until then it has the period of PREOP */
    for (unsigned int i = 0; i < 50; i++) {
        ranger_wait(&r, 1 * MS + i * 7001);
        uint32_t now_us = (uint32_t)((r.w.now_ns - ranger_instance(&r)->start_ns) / 1000);
        uint32_t taken_us = (uint32_t)ranger_value(&r, OPTO_TIMESTAMP);
        if (taken_us > now_us || now_us - taken_us > 300)
            fail_msg("at %u us the record is of %u us", now_us, taken_us);
    }
}

/* After an hour without polls, a sensor has counted all records and measured the last ones. */
static void away(void **state)
{
    (void)state;
    opto_t *u = ranger_instance(&r);
    uint64_t before = u->taken;
    r.w.now_ns += 3600000 * MS;
    ranger_wait(&r, 0);
    wire_poll(&r.w);
    ranger_wait(&r, 1 * MS);
    assert_in_range(u->taken - before, 72000000, 72000100);
    assert_int_equal(ranger_value(&r, OPTO_COUNTER), (int32_t)((u->taken - 1) & 0xFFFFFF));
}

/* --- several records in an exchange ------------------------------------------------------------------------------- */

/* The first exchanges may repeat records, until the master's cycle is determined. */
static void settle(void)
{
    for (unsigned int i = 0; i < 5; i++)
        ranger_wait(&r, 1 * MS);
}

/* 10 kHz and 1 ms: ten records per exchange, each once, the oldest first (the manual's example). */
static void oversampling(void **state)
{
    enum { SAMPLES = 10 };
    (void)state;
    ranger_write(&r, 0x2250, 1, 10000, 4);
    ranger_select(&r, 1 << OPTO_COUNTER | 1 << OPTO_TIMESTAMP | 1 << OPTO_DISTANCE_1, SAMPLES);
    signal_set(&r.w, "surface1.amplitude", "10");
    signal_set(&r.w, "surface1.period", "1000000");
    signal_set(&r.w, "surface1.source", "1");
    ranger_go(&r, OP);
    assert_int_equal(r.bytes, 120);
    settle();
    int32_t next = ranger_value(&r, 0);
    int32_t time = ranger_value(&r, 1);
    int32_t distance = ranger_value(&r, 2);
    for (unsigned int cycle = 0; cycle < 50; cycle++) {
        for (unsigned int n = 0; n < SAMPLES; n++, next++, time += 100, distance += 1000) {
            want("counter", 3 * n, next);
            want("timestamp", 3 * n + 1, time);
            want("distance", 3 * n + 2, distance);
        }
        ranger_wait(&r, 1 * MS);
    }
}

/* A master that comes 0.3 ms early, then as late, still gets each record once; a master that is too slow gets the last
 * one. */
static void irregular(void **state)
{
    enum { SAMPLES = 10 };
    (void)state;
    ranger_write(&r, 0x2250, 1, 10000, 4);
    ranger_select(&r, 1 << OPTO_COUNTER, SAMPLES);
    ranger_go(&r, OP);
    int32_t next = 0;
    for (unsigned int cycle = 0; cycle < 100; cycle++, next += SAMPLES) {
        ranger_wait(&r, cycle % 2 == 0 ? 1300000 : 700000);
        if (cycle < 20) { /* until the rhythm is found */
            next = ranger_value(&r, 0);
            continue;
        }
        want("the first", 0, next);
        want("the last", SAMPLES - 1, next + SAMPLES - 1);
    }
    for (unsigned int cycle = 0; cycle < 10; cycle++)
        ranger_wait(&r, 5 * MS);
    int32_t newest = (int32_t)ranger_instance(&r)->taken - 1;
    assert_in_range((uint32_t)(newest - ranger_value(&r, SAMPLES - 1)), 0, 3);
}

/* A hundred, the maximum; also directly after power-on, with fewer records. */
static void hundred(void **state)
{
    (void)state;
    ranger_write(&r, 0x2250, 1, 49140, 4);
    ranger_select(&r, 1 << OPTO_COUNTER, 100);
    ranger_go(&r, OP);
    assert_int_equal(r.bytes, 400);
    ranger_wait(&r, 10 * MS);
    for (unsigned int n = 1; n < 100; n++)
        want("counter", n, ranger_value(&r, 0) + (int32_t)n);
    opto_t *u = ranger_instance(&r);
    for (uint32_t have = 1; have <= 100; have++) {
        for (int32_t n = 0; n < 100; n++)
            u->kept[n] = n;
        u->oldest = 0;
        u->shown = have;
        opto_inputs_packed(u, 3, r.in, 400);
        for (unsigned int n = 0; n < 100; n++)
            want("few records", n, n + have > 100 ? (int32_t)(n + have - 100) : 0);
    }
}

/* A master that is late by two exchanges, all but a record, gets each record once: of 22 with all, of 100 with few
 * values. */
static void late(void **state)
{
    static const struct {
        uint32_t measurements;
        unsigned int values, samples, counter;
    } rows[] = {{ALL, OPTO_VALUES, 22, OPTO_COUNTER},
                {1 << OPTO_COUNTER, 1, 100, 0},
                {1 << OPTO_COUNTER | 1 << OPTO_STATE, 2, 100, 0}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ranger_select(&r, rows[i].measurements, rows[i].samples);
        ranger_go(&r, SAFEOP);
        opto_t *u = ranger_instance(&r);
        int32_t next = (int32_t)u->taken;
        u->sent = u->taken;
        while (u->taken - u->sent < 3 * rows[i].samples - 1)
            opto_advance(u, u->next_ns);
        for (unsigned int exchange = 0; exchange < 2; exchange++) {
            opto_inputs(u, 0);
            opto_inputs_packed(u, 3, r.in, r.bytes);
            opto_inputs_read(u, 0);
            for (unsigned int n = 0; n < rows[i].samples; n++)
                want("counter", n * rows[i].values + rows[i].counter, next++);
        }
        (void)wire_al(&r.w, 0, PREOP, NULL);
    }
}

/* Records before the selection have another form: the last record replaces them. */
static void new_selection(void **state)
{
    enum { SAMPLES = 20 };
    (void)state;
    ranger_write(&r, 0x2250, 1, 1500, 4);
    wire_advance(&r.w, 100 * MS);
    ranger_select(&r, 1 << OPTO_COUNTER | 1 << OPTO_DISTANCE_1, SAMPLES);
    int32_t last = (int32_t)ranger_instance(&r)->taken - 1;
    ranger_go(&r, SAFEOP);
    for (unsigned int cycle = 0; cycle < 2 * SAMPLES; cycle++) {
        int32_t newest = (int32_t)ranger_instance(&r)->taken - 1;
        assert_int_equal(wire_read(&r.w, 0, RANGER_INPUTS, r.in, r.bytes), 1);
        for (unsigned int n = 0, before = 0; n < SAMPLES; n++) {
            int32_t counter = ranger_value(&r, 2 * n);
            assert_in_range(counter, last, newest);
            assert_true(n == 0 || counter == (int32_t)before + 1 || counter == (int32_t)before);
            want("distance", 2 * n + 1, 10 * MM);
            before = (unsigned int)counter;
        }
        wire_advance(&r.w, 1 * MS);
    }
}

/* Late by more than the time for which records are kept: an exchange of many has the last ones, without a gap. */
static void many_after_away(void **state)
{
    enum { SAMPLES = 100 };
    (void)state;
    ranger_select(&r, 1 << OPTO_COUNTER, SAMPLES);
    ranger_go(&r, OP);
    ranger_wait(&r, 20 * MS);
    r.w.now_ns += 1000 * MS;
    ranger_wait(&r, 0);
    wire_poll(&r.w);
    for (unsigned int cycle = 0; cycle < 10; cycle++) {
        ranger_wait(&r, 1 * MS);
        for (unsigned int n = 1; n < SAMPLES; n++)
            want("counter", n, ranger_value(&r, 0) + (int32_t)n);
    }
}

/* --- distributed clocks ------------------------------------------------------------------------------------------- */

static void cycles(void **state)
{
    static const struct {
        uint32_t ns;
        bool accepted;
    } rows[] = {{666667, true},   {400000, true},  {200000, true},  {100000, true}, {50000, true}, {33333, true},
                {20350, true},    {1333334, true}, {800000, true},  {66666, true},  {40700, true}, {0, false},
                {1000000, false}, {250000, false}, {666666, false}, {20000, false}, {1, false},    {UINT32_MAX, false}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t code;
        wire_set_sm(&r.w, 0, 3, RANGER_INPUTS, 8, 0x20);
        ranger_sync0(&r, rows[i].ns);
        uint8_t status = wire_al(&r.w, 0, SAFEOP, &code);
        if (status != (rows[i].accepted ? SAFEOP : PREOP | ERR) || code != (rows[i].accepted ? 0 : 0x0036))
            fail_msg("SYNC0 every %u ns: got AL status %02X, code %04X", rows[i].ns, status, code);
        (void)wire_al(&r.w, 0, PREOP | ERR, NULL);
    }
    for (unsigned int i = 0; i < ect_optoncdt2300.dc_mode_count; i++) { /* each mode of the ESI is one of these */
        uint32_t ns = ect_optoncdt2300.dc_modes[i].cycle_sync0_ns;
        bool found = ns == 0;
        for (size_t n = 0; n < COUNT(rows); n++)
            found |= rows[n].accepted && rows[n].ns == ns;
        assert_true(found);
    }
}

/* In OP each SYNC0 takes a record, whatever the sensor's own rate; ten of them fill an exchange of 1 ms for ever. */
static void synchronised(void **state)
{
    enum { SAMPLES = 10 };
    (void)state;
    ranger_write(&r, 0x2250, 1, 1500, 4);
    ranger_select(&r, 1 << OPTO_COUNTER | 1 << OPTO_TIMESTAMP, SAMPLES);
    ranger_sync0(&r, 100000);
    ranger_go(&r, OP);
    wire_advance(&r.w, 20 * MS);
    settle();
    assert_int_equal(signal_number(&r.w, "synchronised"), 1);
    int32_t next = ranger_value(&r, 0), time = ranger_value(&r, 1);
    for (unsigned int cycle = 0; cycle < 100; cycle++) {
        for (unsigned int n = 0; n < SAMPLES; n++, next++, time += 100) {
            want("counter", 2 * n, next);
            want("timestamp", 2 * n + 1, time);
        }
        ranger_wait(&r, 1 * MS);
    }
    uint8_t pulse[8];
    assert_int_equal(wire_read(&r.w, 0, ECT_REG_DC_START_TIME, pulse, sizeof pulse), 1);
    uint64_t power_on_ns = ranger_instance(&r)->start_ns;
    assert_int_equal((ranger_instance(&r)->next_ns - power_on_ns - ect_load_le64(pulse)) % 100000, 0); /* on its grid */
    assert_int_equal(ranger_number(&r, 0x1C33, 2), 100000);
    assert_int_equal(wire_al(&r.w, 0, SAFEOP, NULL), SAFEOP); /* its own rate again */
    wire_advance(&r.w, 10 * MS);
    assert_int_equal(signal_number(&r.w, "synchronised"), 0);
    uint64_t before = ranger_instance(&r)->taken;
    wire_advance(&r.w, 1000 * MS);
    assert_in_range(ranger_instance(&r)->taken - before, 1499, 1501);
    assert_int_equal(wire_al(&r.w, 0, OP, NULL), OP); /* and back */
    wire_advance(&r.w, 10 * MS);
    before = ranger_instance(&r)->taken;
    wire_advance(&r.w, 1000 * MS);
    assert_in_range(ranger_instance(&r)->taken - before, 9999, 10001);
}

/* Its own rate is faster than SYNC0: the last record of SAFEOP is younger than the last pulse. */
static void sync0_takes_over(void **state)
{
    enum { PULSE_NS = 1333334 };
    unsigned int younger = 0;
    (void)state;
    ranger_write(&r, 0x2250, 1, 49140, 4);
    ranger_select(&r, 1 << OPTO_COUNTER | 1 << OPTO_TIMESTAMP, 1);
    ranger_sync0(&r, PULSE_NS);
    ranger_go(&r, SAFEOP);
    wire_advance(&r.w, 20 * MS);
    for (unsigned int i = 0; i < 10; i++) {
        ranger_wait(&r, 5 * MS + i * 100000);
        opto_t *u = ranger_instance(&r);
        opto_advance(u, r.w.now_ns);
        uint64_t before = u->taken, last_ns = u->next_ns - 20350;
        younger += last_ns > u->sync.sync0_ns;
        assert_int_equal(wire_al(&r.w, 0, OP, NULL), OP);
        uint64_t first_ns = u->next_ns - (u->taken - before) * PULSE_NS;
        if (first_ns <= last_ns || first_ns > last_ns + PULSE_NS)
            fail_msg("phase %u: a record of %llu ns follows one of %llu ns", i, (unsigned long long)first_ns,
                     (unsigned long long)last_ns);
        assert_int_equal(wire_al(&r.w, 0, SAFEOP, NULL), SAFEOP);
    }
    assert_true(younger > 0);
}

/* It has no outputs that could be missing: only SYNC0 keeps it in OP. Without SYNC0 it leaves OP. */
static void sync0_without_outputs(void **state)
{
    uint16_t code = 0;
    (void)state;
    ranger_sync0(&r, 400000);
    ranger_go(&r, OP);
    wire_advance(&r.w, 60000 * MS);
    assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), OP);
    assert_int_equal(ranger_number(&r, 0x1C33, 11), 0);
    assert_int_equal(ranger_number(&r, 0x1C33, 32), 0);
    assert_int_equal(wire_write16(&r.w, 0, ECT_REG_DC_CYCLIC_CONTROL, 0), 1);
    wire_advance(&r.w, 100 * MS);
    assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), SAFEOP | ERR);
    (void)wire_read(&r.w, 0, ECT_REG_AL_STATUS_CODE, &code, 2);
    assert_int_equal(wire_read16(&r.w, 0, ECT_REG_AL_STATUS_CODE), ECT_AL_FATAL_SYNC);
}

int main(void)
{
#define A(title, function) {title, function, setup_all, teardown, NULL}
#define T(title, function) {title, function, setup, teardown, NULL}
    const struct CMUnitTest tests[] = {
        A("OPT-006: values in their units (public manual, pp. 86, 98)", first_values),
        A("OPT-006: values follow the settings (public manual, pp. 86, 98)", settings_of_the_plant),
        A("OPT-013: each error in place of a distance (public manual, p. 98)", errors),
        A("OPT-006: two surfaces, and their difference (public manual, p. 174)", two_surfaces),
        A("OPT-013: laser power by SDO", laser_power),
        T("OPT-007: 6065h by SDO (public manual, p. 172)", by_sdo),
        A("statistics, and their reset (public manual, p. 140)", statistics),
        A("ramp and sine", sources),
        A("noise is normal, and the same for the same seed", noise),
        A("a table, row by row in a circle", table),
        A("OPT-006: seven measuring rates", rates),
        A("OPT-006: process data are fresh", fresh),
        A("a sensor that was away counts on", away),
        T("OPT-006: oversampling, each record once (public manual, p. 174)", oversampling),
        T("OPT-006: oversampling with an irregular master", irregular),
        T("OPT-006: oversampling up to 100 (public manual, p. 174)", hundred),
        T("OPT-006: oversampling with a master that is late", late),
        T("OPT-006: oversampling, after a choice", new_selection),
        T("OPT-006: oversampling, after a time without polls", many_after_away),
        T("SYNC0 has the period of a measuring rate, or twice that (public manual, p. 182)", cycles),
        T("a record at each SYNC0 (public manual, p. 182)", synchronised),
        T("OPT-006: the first pulse after the last record continues them when SYNC0 replaces the rate (public manual, "
          "p. "
          "182)",
          sync0_takes_over),
        T("SYNC0 without outputs, and without SYNC0", sync0_without_outputs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
