/* SPDX-License-Identifier: MIT */
/* The watchdogs of the ESC in virtual time: the accesses that trigger them, their expiry, and its effects (data sheet
 * I section 13, II section 2.9). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "support/wire.h"

enum { RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, DATA = 10, OUTPUTS = 0x1000, LENGTH = 4 };

typedef struct rig {
    ect_esc_personality_t personality;
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

static unsigned int write16(rig_t *r, uint16_t ado, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    return send(r, APWR, ado, bytes, 2);
}

static void set_sm(rig_t *r, unsigned int n, uint16_t start, uint16_t length, uint8_t control)
{
    uint8_t block[8] = {0};
    assert_int_equal(send(r, APWR, (uint16_t)(0x0806 + 8 * n), block, 1), 1);
    ect_store_le16(block, start);
    ect_store_le16(block + 2, length);
    block[4] = control;
    block[6] = 1;
    assert_int_equal(send(r, APWR, (uint16_t)(0x0800 + 8 * n), block, 8), 1);
}

static void power_on(rig_t *r)
{
    const ect_esc_config_t config = {
        .personality = &r->personality, .memory = r->memory, .sii = r->sii, .sii_size = sizeof r->sii, .open_ports = 1};
    assert_int_equal(ect_esc_init(&r->esc, &config, r->w.now_ns), 0);
    set_sm(r, 2, OUTPUTS, LENGTH, 0x64);
}

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->personality = *ect_esc_personality("et1100");
    ect_store_le16(r->sii + 14, 0x88A4); /* check value disabled */
    r->w.now_ns = 1000 * MS;
    power_on(r);
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    free(*state);
    return 0;
}

static void feed(rig_t *r)
{
    uint8_t outputs[LENGTH] = {0};
    assert_int_equal(send(r, APWR, OUTPUTS, outputs, LENGTH), 1);
}

static void tick_to(rig_t *r, uint64_t now_ns)
{
    r->w.now_ns = now_ns;
    (void)ect_esc_tick(&r->esc, now_ns);
}

static void expect(rig_t *r, const char *what, bool running, unsigned int count)
{
    uint8_t status = r->memory[ECT_REG_WD_STATUS_PD] & 1;
    uint8_t counter = r->memory[ECT_REG_WD_COUNTER_PD];
    if (status != (running ? 1 : 0) || counter != count)
        fail_msg("%s: expected status %d, counter %u, got %u, %u", what, running, count, status, counter);
}

static void times(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint16_t divider, time;
    } rows[] = {{0x09C2, 1000}, {0x09C2, 1}, {0, 1}, {0, 0xFFFF}, {0xFFFF, 1}, {0xFFFF, 0xFFFF}, {2498, 500}, {23, 10}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint64_t tick = (rows[i].divider + 2ull) * 40;
        power_on(r);
        assert_int_equal(write16(r, ECT_REG_WD_DIVIDER, rows[i].divider), 1);
        assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, rows[i].time), 1);
        feed(r);
        uint64_t from = r->w.now_ns;
        uint64_t next = ect_esc_tick(&r->esc, from);
        if (next < from + rows[i].time * tick || next > from + (rows[i].time + 1) * tick)
            fail_msg("divider %u, time %u: expires after %llu ns, expected %llu to %llu", rows[i].divider, rows[i].time,
                     (unsigned long long)(next - from), (unsigned long long)(rows[i].time * tick),
                     (unsigned long long)((rows[i].time + 1) * tick));
        tick_to(r, from + rows[i].time * tick - 1);
        expect(r, "one nanosecond before N ticks", true, 0);
        tick_to(r, next);
        expect(r, "at its reported time", false, 1);
        tick_to(r, from + (rows[i].time + 1) * tick);
        expect(r, "after N + 1 ticks", false, 1);
    }
}

static void default_time(void **state)
{
    rig_t *r = *state;
    expect(r, "after reset, not fed yet", false, 0);
    tick_to(r, r->w.now_ns + 500 * MS);
    expect(r, "not fed for 500 ms", false, 0);
    feed(r);
    expect(r, "fed", true, 0);
    tick_to(r, r->w.now_ns + 100 * MS - 1);
    expect(r, "just under 100 ms", true, 0);
    tick_to(r, r->w.now_ns + 1 + 100000);
    expect(r, "100.1 ms", false, 1);
}

static void fed_in_time(void **state)
{
    rig_t *r = *state;
    for (unsigned int i = 0; i < 1000; i++) {
        feed(r);
        r->w.now_ns += 99 * MS;
        expect(r, "fed each 99 ms", true, 0);
    }
    assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_WATCHDOG, 0);
}

static void once_per_expiry(void **state)
{
    rig_t *r = *state;
    for (unsigned int i = 1; i <= 300; i++) {
        feed(r);
        uint32_t activity = ect_esc_activity(&r->esc);
        for (unsigned int k = 0; k < 10; k++)
            tick_to(r, r->w.now_ns + 50 * MS);
        expect(r, "expired, read ten times", false, i < 255 ? i : 255);
        assert_int_not_equal(ect_esc_activity(&r->esc), activity);
        assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), UINT64_MAX);
    }
}

/* An hour, a day, a year without the master: one expiry, and everything works when the master returns. */
static void silence(void **state)
{
    rig_t *r = *state;
    static const uint64_t hours[] = {1, 24, 24 * 365};
    for (size_t i = 0; i < sizeof hours / sizeof hours[0]; i++) {
        feed(r);
        tick_to(r, r->w.now_ns + hours[i] * 3600 * 1000 * MS);
        expect(r, "after the silence", false, (unsigned int)i + 1);
        feed(r);
        expect(r, "back again", true, (unsigned int)i + 1);
        tick_to(r, r->w.now_ns + 99 * MS);
        expect(r, "99 ms later", true, (unsigned int)i + 1);
    }
}

/* The frame after an expiry notices it, before its datagrams are executed. */
static void noticed_by_a_frame(void **state)
{
    rig_t *r = *state;
    feed(r);
    r->w.now_ns += 200 * MS;
    feed(r);
    expect(r, "fed after the expiry", true, 1);
    r->w.now_ns += 200 * MS;
    uint8_t status[4] = {0xFF, 0xFF, 0xFF, 0xFF};
    assert_int_equal(send(r, APRD, ECT_REG_WD_STATUS_PD, status, 4), 1);
    assert_int_equal(status[0], 0);
    assert_int_equal(status[2], 2);
}

static void event(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint16_t address;
        bool clears;
    } rows[] = {{0x0440, true}, {0x0441, true}, {0x0442, false}, {0x043F, false}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[2];
        feed(r);
        tick_to(r, r->w.now_ns + 200 * MS);
        assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_WATCHDOG, ECT_EVENT_WATCHDOG);
        (void)send(r, APRD, 0x0440, data, 2);
        assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_WATCHDOG, ECT_EVENT_WATCHDOG);
        ect_esc_pdi_read(&r->esc, rows[i].address, data, 1);
        if (((ect_esc_al_event(&r->esc) & ECT_EVENT_WATCHDOG) == 0) != rows[i].clears)
            fail_msg("PDI reads 0x%04X: expected the event cleared %d", rows[i].address, rows[i].clears);
        ect_esc_pdi_read(&r->esc, 0x0440, data, 2);
    }
    assert_int_equal(r->memory[0x0130], 1); /* no state change by itself */
}

/* The accesses that trigger it: SM2 (4 bytes, written by ECAT) and others. */
static void accesses_that_feed(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        uint8_t command, control;
        uint16_t length, offset, count;
        bool feeds;
    } rows[] = {
        {"complete write", APWR, 0x64, 4, 0, 4, true},
        {"all but the last byte", APWR, 0x64, 4, 0, 3, false},
        {"first byte", APWR, 0x64, 4, 0, 1, false},
        {"last byte alone", APWR, 0x64, 4, 3, 1, false},
        {"all but the first byte", APWR, 0x64, 4, 1, 3, false},
        {"write beyond the end", APWR, 0x64, 4, 0, 8, true},
        {"no trigger bit", APWR, 0x24, 4, 0, 4, false},
        {"a read of outputs", APRD, 0x64, 4, 0, 4, false},
        {"a write to inputs", APWR, 0x60, 4, 0, 4, false},
        {"empty mailbox", APWR, 0x66, 4, 0, 4, true},
        {"1 byte", APWR, 0x44, 1, 0, 1, true},
        {"1 byte without the trigger bit", APWR, 0x04, 1, 0, 1, false},
        {"read of 1 byte", APRD, 0x44, 1, 0, 1, false},
        {"read-write", APRW, 0x64, 4, 0, 4, true},
        {"broadcast", BWR, 0x64, 4, 0, 4, true},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[8] = {0};
        power_on(r);
        set_sm(r, 2, OUTPUTS, rows[i].length, rows[i].control);
        (void)send(r, rows[i].command, (uint16_t)(OUTPUTS + rows[i].offset), data, rows[i].count);
        expect(r, rows[i].what, rows[i].feeds, 0);
    }
}

static void fed_by_parts(void **state)
{
    rig_t *r = *state;
    uint8_t data[4] = {0};
    assert_int_equal(send(r, APWR, OUTPUTS, data, 2), 1);
    r->w.now_ns += 300 * MS;
    expect(r, "opened only", false, 0);
    assert_int_equal(send(r, APWR, OUTPUTS + 2, data, 2), 1);
    expect(r, "complete in a second frame", true, 0);
    r->w.now_ns += 60 * MS;
    for (unsigned int i = 0; i < 10; i++) { /* partial writes, again and again */
        assert_int_equal(send(r, APWR, OUTPUTS, data, 3), 1);
        r->w.now_ns += 10 * MS;
    }
    (void)ect_esc_tick(&r->esc, r->w.now_ns);
    expect(r, "then only partly", false, 1);
}

/* A full mailbox refuses the write, which therefore does not trigger it. The PDI's own writes never do. */
static void refused_writes(void **state)
{
    rig_t *r = *state;
    uint8_t data[4] = {0};
    set_sm(r, 2, OUTPUTS, 4, 0x66);
    feed(r);
    tick_to(r, r->w.now_ns + 200 * MS);
    assert_int_equal(send(r, APWR, OUTPUTS, data, 4), 0);
    expect(r, "write to a full mailbox", false, 1);
    set_sm(r, 3, 0x1100, 4, 0x60);
    ect_esc_pdi_write(&r->esc, 0x1100, data, 4);
    expect(r, "inputs written by the PDI", false, 1);
    ect_esc_pdi_read(&r->esc, OUTPUTS, data, 4);
    expect(r, "outputs read by the PDI", false, 1);
}

static void one_for_all(void **state)
{
    rig_t *r = *state;
    uint8_t data[4] = {0};
    set_sm(r, 4, 0x1200, 4, 0x64);
    for (unsigned int i = 0; i < 10; i++) {
        assert_int_equal(send(r, APWR, i % 2 == 0 ? OUTPUTS : 0x1200, data, 4), 1);
        r->w.now_ns += 80 * MS;
    }
    expect(r, "fed by two SyncManagers in turn", true, 0);
}

static void by_lwr(void **state)
{
    rig_t *r = *state;
    uint8_t fmmu[16] = {0, 0, 1, 0, 4, 0, 0, 7, 0x00, 0x10, 0, 2, 1, 0, 0, 0}, data[4] = {0};
    assert_int_equal(send(r, APWR, 0x0600, fmmu, 16), 1);
    wire_build(&r->w, LWR, 0, 1, data, 4);
    assert_int_equal(ect_esc_process(&r->esc, r->w.frame, r->w.frame_length, r->w.now_ns), ECT_FRAME_FORWARD);
    assert_int_equal(wire_wkc(&r->w, 0), 1);
    expect(r, "fed through an FMMU", true, 0);
}

static void switched_off(void **state)
{
    rig_t *r = *state;
    assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, 0), 1);
    feed(r);
    expect(r, "time 0, fed", true, 0);
    assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), UINT64_MAX);
    tick_to(r, r->w.now_ns + 3600 * 1000 * MS);
    expect(r, "time 0, an hour later", true, 0);
    /* Disabled while it runs. */
    assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, 1000), 1);
    feed(r);
    assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, 0), 1);
    tick_to(r, r->w.now_ns + 3600 * 1000 * MS);
    expect(r, "switched off while running", true, 0);
    assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_WATCHDOG, 0);
    assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, 100), 1);
    feed(r);
    tick_to(r, r->w.now_ns + 11 * MS);
    expect(r, "on again, 10 ms", false, 1);
    feed(r);
    assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, 1000), 1);
    tick_to(r, r->w.now_ns + 11 * MS);
    expect(r, "another time while it runs: from the next feeding on", false, 2);
}

static void off_shows_no_expiry(void **state)
{
    rig_t *r = *state;
    feed(r);
    tick_to(r, r->w.now_ns + 200 * MS);
    expect(r, "expired", false, 1);
    assert_int_equal(write16(r, ECT_REG_WD_TIME_PD, 0), 1);
    expect(r, "expired, then switched off: status bit 0 is 1 while disabled", true, 1);
}

static void counter_clear(void **state)
{
    rig_t *r = *state;
    for (uint16_t at = ECT_REG_WD_COUNTER_PD; at <= ECT_REG_WD_COUNTER_PD + 1; at++) {
        uint8_t value = 0x77;
        feed(r);
        tick_to(r, r->w.now_ns + 200 * MS);
        expect(r, "expired", false, 1);
        assert_int_equal(send(r, APWR, at, &value, 1), 1);
        expect(r, "cleared", false, 0);
    }
    assert_int_equal(write16(r, ECT_REG_WD_STATUS_PD, 1), 0);
    expect(r, "status is read-only", false, 0);
}

static void pdi_watchdog_alive(void **state)
{
    rig_t *r = *state;
    uint8_t data[2];
    ect_esc_pdi_read(&r->esc, 0x0120, data, 2);
    if ((r->memory[ECT_REG_DL_STATUS] & 2) == 0)
        fail_msg("after a PDI access: expected DL status bit 1 (PDI watchdog ok), DL status is 0x%02X",
                 r->memory[ECT_REG_DL_STATUS]);
}

/* The PDI is in the same process: its watchdog is never late (docs/FEATURES.md). */
static void pdi_watchdog_expires(void **state)
{
    rig_t *r = *state;
    tick_to(r, r->w.now_ns + 3600000 * MS);
    if (r->memory[0x0443] != 0 || (r->memory[ECT_REG_DL_STATUS] & 2) == 0)
        fail_msg("an hour without a PDI access: expected 0x0443 = 0, DL status bit 1 = 1, got %u, 0x%02X",
                 r->memory[0x0443], r->memory[ECT_REG_DL_STATUS]);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-050: N ticks of (divider + 2) * 40 ns: expires between N and N + 1 ticks, for extreme values too",
             times),
        TEST("CF-050: reset values give 100 ms; not fed yet it shows expired and counts nothing", default_time),
        TEST("CF-051: fed in time it never expires", fed_in_time),
        TEST("CF-051: one count for each expiry, for any number of reads; the counter stops at 255", once_per_expiry),
        TEST("CF-049: after an hour, a day, a year without the master: one expiry, then it works again", silence),
        TEST("CF-051: an expiry is noticed by the next frame before that feeds again", noticed_by_a_frame),
        TEST("CF-051: an expiry sets AL event bit 6 until the PDI reads 0x0440, AL status does not change", event),
        TEST("CF-052: only a complete write to a SyncManager with the trigger bit feeds", accesses_that_feed),
        TEST("CF-052: parts feed when the last byte has come, parts without it never", fed_by_parts),
        TEST("CF-052: refused writes and the PDI feed nothing", refused_writes),
        TEST("CF-052: there is one watchdog for all SyncManagers", one_for_all),
        TEST("CF-052: outputs through an FMMU feed", by_lwr),
        TEST("CF-050 CF-051: time 0 switches it off: no expiry, no count, before and while it runs", switched_off),
        TEST("CF-050: while it is switched off the status shows no expiry", off_shows_no_expiry),
        TEST("CF-051: the counter is cleared by a write of any value, the status cannot be written", counter_clear),
        TEST("CF-053: an access of the PDI feeds the PDI watchdog: DL status bit 1", pdi_watchdog_alive),
        TEST("CF-053: the PDI watchdog, whose PDI is in the same process, never expires", pdi_watchdog_expires),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC watchdogs", tests, NULL, NULL);
}
