/* SPDX-License-Identifier: MIT */
/* Devices whose SyncManagers are not the usual four: a terminal without a mailbox, a sensor without outputs. */
#include <string.h>

#include "check/check.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/wire.h"

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };
enum { SM0 = 0x1000, SM1 = 0x1100, SM2 = 0x1200, GAUGE_SM2 = 0x1100, GAUGE_SM3 = 0x1200 };

static void *instance_of(wire_t *w)
{
    return ect_chain_slave(w->chain, 0)->config.instance;
}

static void ask(wire_t *w, const char *what, uint8_t state, uint8_t want, uint16_t want_code)
{
    uint16_t code;
    uint8_t got = wire_al(w, 0, state, &code);
    if (got != want || code != want_code)
        fail_msg("%s: expected AL status %02X code %04X, got %02X code %04X", what, want, want_code, got, code);
}

/* A wrong layout of one SyncManager is refused. */
static void refused(wire_t *w, unsigned int sm, uint16_t start, uint16_t length, uint8_t control, const char *what)
{
    wire_set_sm(w, 0, sm, start, length, control);
    ask(w, what, SAFEOP, PREOP | ECT_AL_ERROR, control == 0x64 ? ECT_AL_OUTPUT_SM : ECT_AL_INPUT_SM);
    ask(w, "acknowledge", PREOP | ECT_AL_ERROR, PREOP, 0);
}

static void terminal_runs(void **state)
{
    static const uint8_t out = 0xA5;
    uint8_t in = 0, count[2] = {0};
    wire_t w;
    (void)state;
    wire_open_one(&w, &terminal);
    ask(&w, "without any SyncManager", PREOP, PREOP, 0);
    wire_configure_process_data(&w, 0);
    ask(&w, "with all three", SAFEOP, SAFEOP, 0);
    assert_int_equal(wire_write(&w, 0, SM0, &out, 1), 1);
    ask(&w, "with outputs", OP, OP, 0);
    assert_int_equal(wire_write(&w, 0, SM0, &out, 1), 1);
    assert_int_equal(wire_read(&w, 0, SM1, &in, 1), 1);
    assert_int_equal(wire_read(&w, 0, SM2, count, 2), 1);
    assert_int_equal(in, out);
    assert_int_equal(ect_load_le16(count), 2);
    terminal_t *t = instance_of(&w);
    for (unsigned int n = 0; n < 8; n++)
        assert_int_equal(t->out[n], out >> n & 1);
    ask(&w, "back", SAFEOP, SAFEOP, 0);
    assert_true(t->safe);
    wire_close(&w);
}

static void terminal_checked(void **state)
{
    wire_t w;
    (void)state;
    wire_open_one(&w, &terminal);
    wire_go(&w, 0, PREOP);
    refused(&w, 0, SM0, 0, 0x64, "no outputs");
    refused(&w, 0, SM0, 2, 0x64, "outputs too long");
    wire_set_sm(&w, 0, 0, SM0, 1, 0x64);
    refused(&w, 1, SM1, 2, 0x20, "first inputs too long");
    wire_set_sm(&w, 0, 1, SM1, 1, 0x20);
    refused(&w, 2, SM2, 1, 0x20, "second inputs too short");
    refused(&w, 2, SM1, 2, 0x20, "second inputs elsewhere");
    wire_set_sm(&w, 0, 2, SM2, 2, 0x20);
    ask(&w, "all right", SAFEOP, SAFEOP, 0);
    wire_write8(&w, 0, ECT_REG_SM + 2 * ECT_SM_SIZE + ECT_SM_ACTIVATE, 0);
    uint16_t code = wire_read16(&w, 0, ECT_REG_AL_STATUS_CODE);
    if (wire_read8(&w, 0, ECT_REG_AL_STATUS) != (PREOP | ECT_AL_ERROR) || code != ECT_AL_INPUT_SM)
        fail_msg("second inputs switched off: expected PREOP with code 001E, got %04X", code);
    wire_close(&w);
}

static void terminal_waits(void **state)
{
    uint8_t out = 1;
    wire_t w;
    (void)state;
    wire_open_one(&w, &terminal);
    wire_go(&w, 0, SAFEOP);
    ask(&w, "no outputs yet", OP, SAFEOP, 0);
    assert_int_equal(wire_write(&w, 0, SM0, &out, 1), 1);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), OP);
    wire_advance(&w, 200 * MS);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), SAFEOP | ECT_AL_ERROR);
    assert_int_equal(wire_read16(&w, 0, ECT_REG_AL_STATUS_CODE), ECT_AL_WATCHDOG);
    wire_close(&w);
}

static void gauge_runs(void **state)
{
    uint8_t in[8];
    wire_t w;
    (void)state;
    wire_open_one(&w, &gauge);
    wire_go(&w, 0, PREOP);
    wire_configure_process_data(&w, 0);
    ask(&w, "SM2 unused", SAFEOP, SAFEOP, 0);
    ask(&w, "no outputs to wait for", OP, OP, 0);
    assert_int_equal(wire_read(&w, 0, GAUGE_SM3, in, sizeof in), 1);
    uint32_t first = ect_load_le32(in);
    assert_int_equal(wire_read(&w, 0, GAUGE_SM3, in, sizeof in), 1);
    assert_true(ect_load_le32(in) > first);
    assert_int_equal(ect_load_le32(in + 4), 2 * ect_load_le32(in));
    wire_advance(&w, 1000 * MS); /* no watchdog without outputs */
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), OP);
    wire_close(&w);
}

/* OPT-010: the mapping follows the selection, and the next transition to SAFEOP uses it. */
static void gauge_chooses(void **state)
{
    static const struct {
        uint8_t chosen[GAUGE_VALUES];
        uint8_t count;
        uint8_t order[GAUGE_VALUES];
    } rows[] = {{{1, 1, 0, 0}, 2, {1, 2}},
                {{0, 0, 1, 0}, 1, {3}},
                {{1, 1, 1, 1}, 4, {1, 2, 3, 4}},
                {{0, 1, 0, 1}, 2, {2, 4}},
                {{0, 0, 0, 0}, 0, {0}}};
    wire_t w;
    (void)state;
    wire_open_one(&w, &gauge);
    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        wire_go(&w, 0, PREOP);
        for (uint8_t n = 0; n < GAUGE_VALUES; n++)
            assert_int_equal(wire_sdo_download(&w, 0, 0x21B0, (uint8_t)(n + 1), false, &rows[r].chosen[n], 1), 0);
        for (uint8_t n = 0; n <= rows[r].count; n++) {
            uint8_t data[4] = {0};
            size_t size = sizeof data;
            assert_int_equal(wire_sdo_upload(&w, 0, 0x1A00, n, false, data, &size), 0);
            uint32_t want = n == 0 ? rows[r].count : ECT_MAP(0x6000, rows[r].order[n - 1], 32);
            if (ect_load_le32(data) != want)
                fail_msg("choice %zu: 1A00h:%u: expected %08X, got %08X", r, n, want, ect_load_le32(data));
        }
        wire_set_sm(&w, 0, 3, GAUGE_SM3, (uint16_t)(4u * rows[r].count), 0x20);
        ask(&w, "as chosen", SAFEOP, SAFEOP, 0);
        ask(&w, "as chosen", OP, OP, 0);
        uint8_t in[4 * GAUGE_VALUES] = {0};
        if (rows[r].count > 0)
            assert_int_equal(wire_read(&w, 0, GAUGE_SM3, in, (uint16_t)(4u * rows[r].count)), 1);
        gauge_t *g = instance_of(&w);
        for (uint8_t n = 0; n < rows[r].count; n++)
            assert_int_equal(ect_load_le32(in + (size_t)4 * n) % rows[r].order[n], 0);
        assert_int_equal(g->mapped_count, rows[r].count);
        ask(&w, "down", INIT, INIT, 0);
        wire_set_sm(&w, 0, 3, GAUGE_SM3, 0, 0x20);
    }
    wire_close(&w);
}

/* The shortest mailbox with room for an SDO, as found in a real drive: longer data are segmented. */
static void shortest_mailbox(void **state)
{
    static const ect_protocol_t *const sdo_only[] = {&ect_protocol_sdo, NULL};
    char text[ECT_CHECK_TEXT];
    ect_device_t small = gauge;
    wire_t w;
    (void)state;
    small.sm[0].length = small.sm[1].length = 16;
    small.protocols = sdo_only;
    small.coe_details = ECT_COE_SDO | ECT_COE_COMPLETE_ACCESS;
    small.type_name = "A name of two dozen chars";
    if (!ect_device_check(&small, text, sizeof text))
        fail_msg("%s", text);
    wire_open_one(&w, &small);
    wire_go(&w, 0, PREOP);
    char name[64] = "";
    size_t size = sizeof name;
    assert_int_equal(wire_sdo_upload(&w, 0, 0x1008, 0, false, name, &size), 0);
    assert_int_equal(size, strlen(small.type_name));
    assert_memory_equal(name, small.type_name, size);
    uint8_t identity[32];
    size = sizeof identity;
    assert_int_equal(wire_sdo_upload(&w, 0, 0x1018, 0, true, identity, &size), 0);
    assert_int_equal(size, 18);
    assert_int_equal(wire_sdo_download(&w, 0, 0x21B0, 3, false, "\1", 1), 0);
    assert_int_equal(((gauge_t *)instance_of(&w))->chosen[2], 1);
    wire_close(&w);
}

/* Neither SyncManagers nor objects: a coupler. */
static void coupler_runs(void **state)
{
    char text[ECT_CHECK_TEXT];
    ect_device_t coupler = terminal;
    wire_t w;
    (void)state;
    coupler.sm_count = coupler.fmmu_count = 0;
    coupler.object_count = 0;
    coupler.objects = NULL;
    if (!ect_device_check(&coupler, text, sizeof text))
        fail_msg("%s", text);
    wire_open_one(&w, &coupler);
    ask(&w, "to PREOP", PREOP, PREOP, 0);
    ask(&w, "to SAFEOP", SAFEOP, SAFEOP, 0);
    ask(&w, "to OP", OP, OP, 0);
    wire_set_sm(&w, 0, 0, SM0, 1, 0x64); /* not checked */
    wire_advance(&w, 1000 * MS);
    ask(&w, "back", INIT, INIT, 0);
    wire_close(&w);
}

static void memory(void **state)
{
    (void)state;
    ect_slave_memory_t need = ect_slave_memory(&terminal);
    assert_int_equal(need.mailbox, 0);
    assert_int_equal(need.process_data, 2);
    assert_int_equal(need.runs, 8 + 8 + 1);
    need = ect_slave_memory(&gauge);
    assert_int_equal(need.mailbox, 3 * 64);
    assert_int_equal(need.process_data, 16);
    assert_int_equal(need.runs, 4);
}

/* One of four values is mapped by its first byte alone: an image of four bytes has room for four runs of a byte,
 * although no entry is shorter than four. */
static void memory_of_parts(void **state)
{
#define PART(n)                                                                                                        \
    ECT_ENTRY(n, UNSIGNED32, 32, ECT_ACCESS_RW, "Mapped object", ECT_MAP(0x6000, n, 32), gauge_t, mapped[n - 1])
    static const ect_entry_t wholes[] = {ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RW, "Number", 4, gauge_t, mapped_count),
                                         PART(1), PART(2), PART(3), PART(4)};
    ect_entry_t entries[sizeof wholes / sizeof wholes[0]];
    const ect_object_t mapping = ECT_RECORD(0x1A00, "Values mapping", entries);
    ect_object_t objects[32];
    ect_device_t device = gauge;
    (void)state;
    assert_true(gauge.object_count <= sizeof objects / sizeof objects[0]);
    for (uint16_t i = 0; i < gauge.object_count; i++)
        objects[i] = gauge.objects[i].index == mapping.index ? mapping : gauge.objects[i];
    device.objects = objects;
    device.sm[3].maximum = 4;
    for (unsigned int part = 0; part <= 4; part++) {
        memcpy(entries, wholes, sizeof entries);
        if (part > 0)
            entries[part].value = ECT_MAP(0x6000, part, 8);
        const size_t runs = ect_slave_memory(&device).runs;
        if (runs != (part > 0 ? 4 : 1))
            fail_msg("element %u maps a byte: %zu runs", part, runs);
    }
}

int main(void)
{
#define T(title, test) {title, test, NULL, NULL, NULL}
    const struct CMUnitTest tests[] = {
        T("CF-033 CF-037: a terminal without a mailbox, outputs in SM0, inputs in SM1 and SM2, runs from INIT to OP",
          terminal_runs),
        T("CF-037: each of its SyncManagers is checked by its role", terminal_checked),
        T("CF-033 CF-042: it waits for its outputs, and its watchdog leaves OP", terminal_waits),
        T("OPT-006 OPT-009: a sensor without outputs, SM2 unused, runs from INIT to OP", gauge_runs),
        T("OPT-010: the selected process data are sent in their order", gauge_chooses),
        T("PLZ-027 CF-069: a mailbox of 16 bytes serves SDOs", shortest_mailbox),
        T("CF-033: a coupler, without any SyncManager or object, runs from INIT to OP", coupler_runs),
        T("the memory that they need", memory),
        T("the memory of a mapping with parts of entries: a run for each part", memory_of_parts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
