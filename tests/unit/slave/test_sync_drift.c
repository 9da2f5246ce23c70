/* SPDX-License-Identifier: MIT */
/*
 * An FZM1 that is synchronised by SYNC0 while its oscillator has a frequency error: its pulses drift across the
 * master's frames, and 1C32h and 1C33h count as ETG.1020 defines. Frames follow the master's clock, SYNC0 the chip's
 * own one.
 */
#include <stdlib.h>

#include "devices/fzm1/fzm1.h"
#include "support/every.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { CYCLE_NS = 1000000, CYCLES = 4000, REFERENCE = 0, SENSOR = 1 };

/* An exact reference clock, and the sensor behind it. */
static void open_rig(wire_t *w, int32_t drift_ppb)
{
    ect_twin_config_t twins[] = {ect_twin_default(&testdev, NULL), ect_twin_default(&ect_fzm1, plant_of(&ect_fzm1))};
    twins[SENSOR].drift_ppb = drift_ppb;
    wire_open_twins(w, twins, 2);
}

static void write64(wire_t *w, uint16_t address, uint64_t value)
{
    uint8_t bytes[8];
    ect_store_le64(bytes, value);
    assert_int_equal(wire_write(w, SENSOR, address, bytes, sizeof bytes), 1);
}

static uint64_t clock_of(const wire_t *w, size_t position)
{
    return ect_esc_system_time(ect_chain_esc(w->chain, position), w->now_ns);
}

/* Like a master: the offset, and a first pulse half a cycle after the frames. */
static void start_sync0(wire_t *w)
{
    uint8_t cycle[4];
    write64(w, ECT_REG_DC_OFFSET, clock_of(w, REFERENCE) - clock_of(w, SENSOR));
    ect_store_le32(cycle, CYCLE_NS);
    assert_int_equal(wire_write(w, SENSOR, ECT_REG_DC_SYNC0_CYCLE, cycle, sizeof cycle), 1);
    write64(w, ECT_REG_DC_START_TIME, clock_of(w, SENSOR) + CYCLE_NS + CYCLE_NS / 2);
    assert_int_equal(wire_write(w, SENSOR, ECT_REG_DC_CYCLIC_CONTROL, "\x00\x03", 2), 1);
}

/* Writes the reference clock's time to all others. */
static void send_time(wire_t *w)
{
    uint8_t time[8] = {0};
    assert_true(wire_send(w, FRMW, WIRE_STATION + REFERENCE, ECT_REG_DC_SYSTEM_TIME, time, sizeof time) > 0);
}

static void run_cycles(wire_t *w, unsigned int cycles, bool regulated)
{
    for (unsigned int i = 0; i < cycles; i++) {
        wire_advance(w, CYCLE_NS);
        if (regulated)
            send_time(w);
        assert_int_equal(wire_outputs(w, SENSOR, 0), 1);
    }
}

static uint32_t counter(wire_t *w, uint16_t index, uint8_t subindex)
{
    uint8_t value[4] = {0};
    size_t size = sizeof value;
    assert_int_equal(wire_sdo_upload(w, SENSOR, index, subindex, false, value, &size), 0);
    return ect_load_le32(value);
}

static void slides(void **state)
{
    /* In 4000 cycles SYNC0 drifts by 4 cycles at 1000 ppm; it has crossed frames at a half, one and a half ... */
    static const struct {
        int32_t drift_ppm;
        bool regulated;
        unsigned int missed, exceeded;
    } rows[] = {
        {0, false, 0, 0},    {1000, false, 4, 0}, {-1000, false, 0, 4}, {500, false, 2, 0},
        {-500, false, 0, 2}, {100, false, 0, 0},  {600, true, 0, 0},    {-600, true, 0, 0},
        {150, false, 1, 0},  {-150, false, 0, 1}, {100, true, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_t w;
        open_rig(&w, rows[i].drift_ppm * 1000);
        wire_go(&w, SENSOR, ECT_STATE_PREOP);
        start_sync0(&w);
        run_cycles(&w, 2, rows[i].regulated);
        wire_go(&w, SENSOR, ECT_STATE_OP);
        run_cycles(&w, 1, rows[i].regulated); /* the first pulse in OP precedes the first outputs */
        assert_int_equal(counter(&w, 0x1C32, 11), 1);
        run_cycles(&w, CYCLES, rows[i].regulated);
        assert_int_equal(ect_chain_slave(w.chain, SENSOR)->state, ECT_STATE_OP);
        for (uint16_t index = 0x1C32; index <= 0x1C33; index++) {
            unsigned int missed = counter(&w, index, 11) - 1;
            unsigned int exceeded = counter(&w, index, 12);
            if (missed != rows[i].missed || exceeded != rows[i].exceeded)
                fail_msg("%d ppm, %sregulated, %04Xh: expected %u events missed, %u cycles too small, got %u, %u",
                         rows[i].drift_ppm, rows[i].regulated ? "" : "not ", index, rows[i].missed, rows[i].exceeded,
                         missed, exceeded);
        }
        wire_close(&w);
    }
}

static void expect_lamp(const wire_t *w, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(w->chain, SENSOR, "ecat.err", &ref));
    ect_signal_read(&ref, text);
    assert_string_equal(text, want);
}

/* The sensor measures at its own rate: a late master, as on a PC, does not end its OP. */
static void outputs_stop(void **state)
{
    wire_t w;
    (void)state;
    open_rig(&w, 250000);
    assert_int_equal(wire_write16(&w, SENSOR, ECT_REG_WD_TIME_PD, 0), 1);
    wire_go(&w, SENSOR, ECT_STATE_PREOP);
    start_sync0(&w);
    run_cycles(&w, 2, false);
    wire_go(&w, SENSOR, ECT_STATE_OP);
    run_cycles(&w, 100, false);
    assert_int_equal(counter(&w, 0x1C32, 32) & 1u, 0);
    uint32_t before = counter(&w, 0x1C32, 11);
    wire_advance(&w, 201ull * CYCLE_NS); /* the first pulse finds the outputs of the last cycle */
    assert_int_equal(counter(&w, 0x1C32, 11), before + 200);
    assert_int_equal(counter(&w, 0x1C32, 32) & 1u, 1);
    assert_int_equal(ect_chain_slave(w.chain, SENSOR)->state, ECT_STATE_OP);
    run_cycles(&w, 1, false);
    wire_advance(&w, CYCLE_NS);
    assert_int_equal(counter(&w, 0x1C32, 32) & 1u, 0);
    wire_close(&w);
}

static void sync0_stops(void **state)
{
    wire_t w;
    (void)state;
    open_rig(&w, 0);
    wire_go(&w, SENSOR, ECT_STATE_PREOP);
    start_sync0(&w);
    run_cycles(&w, 2, false);
    wire_go(&w, SENSOR, ECT_STATE_OP);
    run_cycles(&w, 100, false);
    assert_int_equal(wire_write(&w, SENSOR, ECT_REG_DC_CYCLIC_CONTROL, "\x00\x00", 2), 1);
    run_cycles(&w, 4, false);
    assert_int_equal(ect_chain_slave(w.chain, SENSOR)->state, ECT_STATE_OP);
    run_cycles(&w, 2, false);
    assert_int_equal(ect_chain_slave(w.chain, SENSOR)->state, ECT_STATE_SAFEOP);
    assert_int_equal(ect_chain_slave(w.chain, SENSOR)->code, ECT_AL_FATAL_SYNC);
    expect_lamp(&w, "single flash");
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-082 CF-090 FZM-016: SYNC0 that drifts across the frames counts in 1C32h and 1C33h; a controlled SYNC0 "
         "does not",
         slides, NULL, NULL, NULL},
        {"CF-082 FZM-016: SYNC0 without outputs is counted, any number in succession, and OP continues", outputs_stop,
         NULL, NULL, NULL},
        {"CF-043 FZM-021: SYNC0 that stops ends OP with 0x002C, ECAT ERR flashes once", sync0_stops, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SYNC0 by a clock that drifts", tests, NULL, NULL);
}
