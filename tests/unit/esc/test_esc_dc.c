/* SPDX-License-Identifier: MIT */
/* Distributed clocks of the ESC in virtual time (data sheet I section 9, II section 2.11). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "support/wire.h"

enum { RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, DATA = 10 };
#define START_NS 5000000000ull

typedef struct rig {
    uint8_t memory[MEMORY];
    uint8_t sii[16];
    ect_esc_t esc;
    wire_t w;
} rig_t;

static unsigned int send(rig_t *r, uint8_t command, uint16_t ado, void *data, uint16_t length)
{
    wire_build(&r->w, command, 0, ado, data, length);
    assert_int_equal(ect_esc_process(&r->esc, r->w.frame, r->w.frame_length, r->w.now_ns), ECT_FRAME_FORWARD);
    memcpy(data, wire_datagram(&r->w, 0) + DATA, length);
    return wire_wkc(&r->w, 0);
}

static void write_number(rig_t *r, uint16_t ado, uint64_t value, uint16_t length)
{
    uint8_t bytes[8];
    ect_store_le64(bytes, value);
    assert_int_equal(send(r, APWR, ado, bytes, length), 1);
}

static uint64_t read_number(rig_t *r, uint16_t ado, uint16_t length)
{
    uint8_t bytes[8] = {0};
    assert_int_equal(send(r, APRD, ado, bytes, length), 1);
    return ect_load_le64(bytes);
}

static void power_on(rig_t *r, uint8_t sync_config)
{
    ect_store_le16(r->sii + 14, 0x88A4); /* check value disabled */
    r->sii[3] = sync_config;
    const ect_esc_config_t config = {.personality = ect_esc_personality("et1100"),
                                     .memory = r->memory,
                                     .sii = r->sii,
                                     .sii_size = sizeof r->sii,
                                     .open_ports = 3};
    assert_int_equal(ect_esc_init(&r->esc, &config, r->w.now_ns), 0);
}

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->w.now_ns = START_NS;
    power_on(r, 0x08);
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    free(*state);
    return 0;
}

static void system_time(void **state)
{
    rig_t *r = *state;
    assert_int_equal(read_number(r, ECT_REG_DC_SYSTEM_TIME, 8), 0);
    r->w.now_ns += 1234567890123;
    assert_int_equal(read_number(r, ECT_REG_DC_SYSTEM_TIME, 8), 1234567890123);
    write_number(r, ECT_REG_DC_OFFSET, 0xFFFFFFFF00000000, 8);
    assert_int_equal(read_number(r, ECT_REG_DC_SYSTEM_TIME, 8), 1234567890123 - 0x100000000);
    assert_int_equal(read_number(r, ECT_REG_DC_SYSTEM_TIME, 4), (uint32_t)1234567890123);
}

static void receive_times(void **state)
{
    rig_t *r = *state;
    r->w.now_ns += 777;
    write_number(r, ECT_REG_DC_OFFSET, 100000, 8); /* receive times are local times */
    uint8_t any[4] = {0};
    assert_int_equal(send(r, BWR, ECT_REG_DC_RECEIVE_TIME, any, 4), 1);
    r->w.now_ns += 1000;
    assert_int_equal(read_number(r, 0x0900, 4), 777);
    assert_int_equal(read_number(r, 0x0904, 4), 777);
    assert_int_equal(read_number(r, 0x0908, 4), 0); /* closed */
    assert_int_equal(read_number(r, 0x0918, 8), 777);
}

static void difference(void **state)
{
    static const struct {
        int32_t received_minus_own;
        uint32_t delay, want;
    } rows[] = {{0, 0, 0x80000000}, {500, 0, 500}, {-500, 0, 0x80000000 + 500}, {0, 300, 0x80000000}, {40, 300, 40}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        r->w.now_ns += 1000000;
        write_number(r, ECT_REG_DC_DELAY, rows[i].delay, 4);
        write_number(r, ECT_REG_DC_SPEED_START, 0x1000, 2);
        uint64_t own = read_number(r, ECT_REG_DC_SYSTEM_TIME, 4);
        write_number(r, ECT_REG_DC_SYSTEM_TIME, own + (uint64_t)rows[i].received_minus_own, 4);
        assert_int_equal(read_number(r, ECT_REG_DC_DIFFERENCE, 4), rows[i].want);
        assert_int_equal(read_number(r, ECT_REG_DC_SYSTEM_TIME, 4),
                         own); /* one sample gives no information about the rate */
    }
    write_number(r, ECT_REG_DC_SPEED_START, 0x1000, 2);
    assert_int_equal(read_number(r, ECT_REG_DC_DIFFERENCE, 4), 0);
}

static void reset_values(void **state)
{
    rig_t *r = *state;
    assert_int_equal(read_number(r, 0x0008, 2) & 0x000C, 0x000C);
    assert_int_equal(read_number(r, 0x0930, 2), 0x1000);
    assert_int_equal(read_number(r, 0x0934, 2), 0x0C04);
    uint8_t read_only[4] = {0xFF, 0xFF, 0xFF, 0xFF};
    static const uint16_t addresses[] = {0x0914, 0x0918, 0x092C, 0x0932, 0x0982, 0x0984, 0x098E, 0x0998};
    for (size_t i = 0; i < sizeof addresses / sizeof addresses[0]; i++)
        assert_int_equal(send(r, APWR, addresses[i], read_only, 1), 0);
}

static void start(rig_t *r, uint64_t first, uint32_t cycle)
{
    write_number(r, 0x0980, 0, 2);
    write_number(r, ECT_REG_DC_START_TIME, first, 8);
    write_number(r, ECT_REG_DC_SYNC0_CYCLE, cycle, 4);
    write_number(r, 0x0980, 0x0300, 2);
}

static uint64_t tick_at(rig_t *r, uint64_t after_start_ns)
{
    r->w.now_ns = START_NS + after_start_ns;
    return ect_esc_tick(&r->esc, r->w.now_ns);
}

static void expect_event(rig_t *r, const char *what, bool want)
{
    if (((ect_esc_al_event(&r->esc) & ECT_EVENT_SYNC0) != 0) != want || (r->memory[0x098E] != 0) != want)
        fail_msg("%s: expected SYNC0 event %d, got %d, status %u", what, want, !want, r->memory[0x098E]);
}

static void acknowledge(rig_t *r)
{
    uint8_t status;
    (void)ect_esc_pdi_read(&r->esc, ECT_REG_DC_SYNC0_STATUS, &status, 1);
}

static void sync0(void **state)
{
    rig_t *r = *state;
    r->w.now_ns += 1000;
    start(r, 1000000, 250000);
    assert_int_equal(read_number(r, 0x0984, 1), 1);
    assert_int_equal(read_number(r, ECT_REG_DC_START_TIME, 8), 1000000);
    assert_int_equal(tick_at(r, 999999), START_NS + 1000000);
    expect_event(r, "before", false);
    for (unsigned int n = 0; n < 5; n++) {
        uint64_t at = 1000000 + n * 250000ull;
        assert_int_equal(tick_at(r, at), START_NS + at + 250000);
        expect_event(r, "pulse", true);
        acknowledge(r);
        expect_event(r, "acknowledged", false);
    }
    r->w.now_ns = START_NS + 10000001; /* missed: the cycle continues */
    assert_int_equal(read_number(r, ECT_REG_DC_START_TIME, 8), 10250000);
    expect_event(r, "after a long time", true);
    write_number(r, 0x0981, 0, 1);
    expect_event(r, "switched off", false);
    assert_int_equal(tick_at(r, 20000000), UINT64_MAX);
}

static void single_shot(void **state)
{
    rig_t *r = *state;
    start(r, 500, 0);
    assert_int_equal(tick_at(r, 500), UINT64_MAX);
    expect_event(r, "single shot", true);
    acknowledge(r);
    (void)tick_at(r, 100000000);
    expect_event(r, "no second one", false);
}

static void start_in_the_past(void **state)
{
    rig_t *r = *state;
    r->w.now_ns += 5000;
    start(r, 4999, 1000);
    assert_int_equal(tick_at(r, 3600000000000), UINT64_MAX);
    expect_event(r, "never", false);
    assert_int_equal(read_number(r, 0x0984, 1), 1);
    start(r, 3600000000000, 1000); /* the present nanosecond */
    assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), UINT64_MAX);
    expect_event(r, "now is past", false);
    start(r, UINT64_MAX, 1000); /* 584 years */
    assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), UINT64_MAX);
    assert_int_equal(read_number(r, 0x0984, 1), 1);
}

static void not_an_event(void **state)
{
    rig_t *r = *state;
    power_on(r, 0);
    start(r, 500, 1000);
    assert_int_equal(tick_at(r, 5000), UINT64_MAX);
    assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_SYNC0, 0);
    assert_int_equal(read_number(r, ECT_REG_DC_START_TIME, 8), 5500);
}

static void event_by_reload(void **state)
{
    rig_t *r = *state;
    power_on(r, 0);
    start(r, 500, 1000);
    r->sii[3] = 0x08;
    write_number(r, ECT_REG_SII_CONTROL, 0x0400, 2);
    uint64_t done_ns = ect_esc_tick(&r->esc, r->w.now_ns);
    uint64_t pulse_ns = ect_esc_tick(&r->esc, done_ns);
    assert_in_range(pulse_ns, done_ns + 1, done_ns + 1000);
    assert_int_equal((pulse_ns - START_NS) % 1000, 500);
    acknowledge(r); /* those without an event */
    expect_event(r, "before the pulse", false);
    (void)ect_esc_tick(&r->esc, pulse_ns);
    expect_event(r, "after the reload", true);
}

static void reference_clock(void **state)
{
    (void)state;
    rig_t *r = *state;
    uint8_t bytes[4] = {0};
    r->w.now_ns += 4242;
    assert_int_equal(send(r, ARMW, ECT_REG_DC_SYSTEM_TIME, bytes, 4), 1); /* position 0: reads */
    assert_int_equal(ect_load_le32(bytes), 4242);
    wire_build(&r->w, ARMW, 1, ECT_REG_DC_SYSTEM_TIME, bytes, 4);
    assert_int_equal(ect_esc_process(&r->esc, r->w.frame, r->w.frame_length, r->w.now_ns), ECT_FRAME_FORWARD);
    assert_int_equal(wire_wkc(&r->w, 0), 1); /* another position: writes */
    assert_int_equal(read_number(r, ECT_REG_DC_DIFFERENCE, 4), 0x80000000);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-087: the system time is local time plus offset, 64 bits", system_time),
        TEST("CF-087: a write to 0x0900 latches the local time at every port with a link", receive_times),
        TEST("CF-088: a write to 0x0910 shows the difference at the reference clock, sign in bit 31", difference),
        TEST("CF-087: reset values, and read-only registers", reset_values),
        TEST("CF-088: ARMW reads the reference clock and writes all others", reference_clock),
        TEST("CF-089: SYNC0 starts at the start time, follows its cycle, and stays until it is acknowledged", sync0),
        TEST("CF-089: cycle 0 is a single shot", single_shot),
        TEST("CF-089: a start time that has passed is never reached", start_in_the_past),
        TEST("CF-056 CF-089: a reload that makes SYNC0 an event determines its next pulse", event_by_reload),
        TEST("CF-089: without 0x0151 bit 3 SYNC0 raises no event, and its next time is still shown", not_an_event),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC distributed clocks", tests, NULL, NULL);
}
