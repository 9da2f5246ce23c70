/* SPDX-License-Identifier: MIT */
/* An FZM1 before it measures: states, objects, mapping, settings, abort codes, clocks (Q179 §1,
 * §2). */
#include <stdio.h>
#include <string.h>

#include "devices/fzm1/fzm1.h"
#include "sii/sii.h"
#include "support/sensor.h"

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP, ERR = 0x10 };
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static wire_t w;

static int setup(void **state)
{
    (void)state;
    wire_open_one(&w, &ect_fzm1);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static uint32_t upload(uint16_t index, uint8_t subindex, uint32_t *value)
{
    uint8_t data[64] = {0};
    size_t size = sizeof data;
    uint32_t code = wire_sdo_upload(&w, 0, index, subindex, false, data, &size);
    *value = ect_load_le32(data);
    return code;
}

static uint32_t download(uint16_t index, uint8_t subindex, uint32_t value, size_t size)
{
    uint8_t data[8];
    ect_store_le64(data, value);
    return wire_sdo_download(&w, 0, index, subindex, false, data, size);
}

static void states(void **state)
{
    static const uint8_t climb[] = {PREOP, SAFEOP, OP};
    static const struct {
        bool sdo, inputs, outputs;
    } want[] = {{true, false, false}, {true, true, false}, {true, true, true}};
    (void)state;
    wire_advance(&w, 10000 * MS);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), INIT); /* no request to leave INIT */
    for (size_t i = 0; i < COUNT(climb); i++) {
        uint32_t value = 0;
        uint8_t data[48] = {0};
        uint8_t command[20] = {FZM1_STEP};
        wire_go(&w, 0, climb[i]);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), climb[i]);
        assert_int_equal(upload(0x1018, 1, &value) == 0, want[i].sdo);
        bool inputs = wire_read(&w, 0, 0x1200, data, sizeof data) == 1 && ect_load_le32(data) != 0;
        assert_int_equal(inputs, want[i].inputs);
        if (climb[i] >= SAFEOP) {
            uint8_t off[20] = {0};
            (void)wire_write(&w, 0, 0x1100, off, sizeof off);
            (void)wire_write(&w, 0, 0x1100, command, sizeof command);
            (void)wire_read(&w, 0, 0x1200, data, sizeof data);
            assert_int_equal((ect_load_le32(data) & FZM1_BUSY) != 0, want[i].outputs);
        }
    }
}

static void mapping(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t count;
        uint16_t target;
    } rows[] = {{0x1600, 5, 0x2100}, {0x1A00, 4, 0x2200}, {0x1A01, 8, 0x2300}};
    uint32_t value = 0;
    (void)state;
    wire_go(&w, 0, PREOP);
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(upload(rows[i].index, 0, &value), 0);
        assert_int_equal(value, rows[i].count);
        for (uint8_t n = 1; n <= rows[i].count; n++) {
            assert_int_equal(upload(rows[i].index, n, &value), 0);
            assert_int_equal(value, (uint32_t)rows[i].target << 16 | (uint32_t)n << 8 | 32);
            assert_int_equal(download(rows[i].index, n, value, 4), 0x06010002);
        }
        assert_int_equal(download(rows[i].index, 0, 0, 1), 0x06010002);
    }
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t value;
    } assignments[] = {{0x1C12, 0, 1}, {0x1C12, 1, 0x1600}, {0x1C13, 0, 2}, {0x1C13, 1, 0x1A00}, {0x1C13, 2, 0x1A01}};
    for (size_t i = 0; i < COUNT(assignments); i++) {
        assert_int_equal(upload(assignments[i].index, assignments[i].subindex, &value), 0);
        assert_int_equal(value, assignments[i].value);
        assert_int_equal(download(assignments[i].index, assignments[i].subindex, 0, assignments[i].subindex ? 2 : 1),
                         0x06010002);
    }
}

static void sizes(void **state)
{
    (void)state;
    wire_go(&w, 0, PREOP);
    wire_configure_process_data(&w, 0);
    static const struct {
        unsigned int sm;
        uint16_t start, length;
        uint8_t control;
        uint16_t code;
    } rows[] = {{2, 0x1100, 19, 0x64, 0x001D}, {2, 0x1100, 21, 0x64, 0x001D}, {2, 0x1100, 20, 0x64, 0},
                {3, 0x1200, 47, 0x20, 0x001E}, {3, 0x1200, 64, 0x20, 0x001E}, {3, 0x1200, 48, 0x20, 0}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t code;
        wire_set_sm(&w, 0, rows[i].sm, rows[i].start, rows[i].length, rows[i].control);
        uint8_t status = wire_al(&w, 0, SAFEOP | 0x10, &code);
        assert_int_equal(status, rows[i].code ? PREOP | ERR : SAFEOP);
        assert_int_equal(code, rows[i].code);
        (void)wire_al(&w, 0, PREOP | 0x10, NULL);
    }
}

/* Each written value, and the value read. */
static void settings(void **state)
{
    static const struct {
        uint8_t subindex, size;
        uint32_t value, code;
    } rows[] = {
        {1, 1, 1, 0},
        {1, 1, 0, 0},
        {1, 1, 2, 0x06090030},
        {5, 1, 1, 0},
        {5, 1, 0, 0},
        {5, 1, 255, 0x06090030},
        {2, 2, 19, 0x06090032},
        {2, 2, 50001, 0x06090031},
        {2, 2, 50000, 0},
        {3, 2, 9, 0x06090032},
        {3, 2, 10001, 0x06090031},
        {3, 2, 10000, 0},
        {2, 2, 10000, 0x06040043},
        {2, 2, 10001, 0},
        {3, 2, 10, 0},
        {2, 2, 20, 0},
        {3, 2, 20, 0x06040043},
        {3, 2, 19, 0},
        {4, 2, 4, 0x06090032},
        {4, 2, 1201, 0x06090031},
        {4, 2, 5, 0},
        {4, 2, 1200, 0},
        {4, 4, 1200, 0x06070012},
        {4, 1, 5, 0x06070013},
        {6, 2, 1, 0x06090011},
        {0, 1, 5, 0x06010002},
    };
    static const uint8_t in_states[] = {PREOP, SAFEOP, OP};
    (void)state;
    for (size_t i = 0; i < COUNT(rows) * COUNT(in_states); i++) {
        const size_t r = i % COUNT(rows);
        if (r == 0)
            wire_go(&w, 0, in_states[i / COUNT(rows)]);
        uint32_t code = download(0x2400, rows[r].subindex, rows[r].value, rows[r].size);
        if (code != rows[r].code)
            fail_msg("state %u, 2400h:%u := %u: expected %08X, got %08X", in_states[i / COUNT(rows)], rows[r].subindex,
                     rows[r].value, rows[r].code, code);
        uint32_t value = 0;
        if (code == 0) {
            assert_int_equal(upload(0x2400, rows[r].subindex, &value), 0);
            assert_int_equal(value, rows[r].value);
        }
    }
}

static void defaults(void **state)
{
    static const uint32_t want[] = {5, 0, 100, 50, 100, 0}; /* None, 10.0 ms, 5.0 ms, 10.0 s, fixed point */
    (void)state;
    wire_go(&w, 0, PREOP);
    for (uint8_t n = 0; n < COUNT(want); n++) {
        uint32_t value = 0;
        assert_int_equal(upload(0x2400, n, &value), 0);
        assert_int_equal(value, want[n]);
    }
}

static void comments(void **state)
{
    static const char text[] = "x of the first hole, in mm";
    uint8_t data[64];
    size_t size = sizeof data;
    (void)state;
    wire_go(&w, 0, PREOP);
    assert_int_equal(wire_sdo_download(&w, 0, 0x2500, 3, false, text, sizeof text - 1), 0);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x2500, 3, false, data, &size), 0);
    assert_int_equal(size, sizeof text - 1);
    assert_memory_equal(data, text, size);
}

static void natural_aborts(void **state)
{
    uint32_t value = 0;
    uint8_t data[64];
    size_t size = sizeof data;
    (void)state;
    wire_go(&w, 0, PREOP);
    assert_int_equal(upload(0x2401, 0, &value), 0x06010001);
    assert_int_equal(download(0x2100, 1, 0, 4), 0x06010002);
    assert_int_equal(download(0x2300, 1, 0, 4), 0x06010002);
    assert_int_equal(upload(0x6040, 0, &value), 0x06020000); /* OM-C9: no drive */
    assert_int_equal(upload(0x2200, 5, &value), 0x06090011);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x1018, 0, true, data, &size), 0x06010000); /* no Complete Access */
    assert_int_equal(wire_sdo_download(&w, 0, 0x2400, 0, true, data, 8), 0x06010000);
}

/* SDO information of each sub-index of 1C32h, up to the last: gaps have no type. */
static void gaps(void **state)
{
    (void)state;
    wire_go(&w, 0, PREOP);
    for (uint16_t index = 0x1C32; index <= 0x1C33; index++) {
        for (uint8_t sub = 0; sub <= 33; sub++) {
            uint8_t request[] = {0, 0x80, 5, 0, 0, 0, (uint8_t)index, (uint8_t)(index >> 8), sub, 0};
            uint8_t reply[64] = {0};
            uint32_t value;
            int length = wire_coe(&w, 0, request, sizeof request, reply, sizeof reply);
            bool exists = upload(index, sub, &value) == 0;
            if (sub == 33) {
                assert_int_equal(reply[2], 7); /* none exists beyond the last one */
                assert_int_equal(ect_load_le32(reply + 6), 0x06090011);
                continue;
            }
            assert_int_equal(reply[2], 6);
            assert_int_equal(reply[8], sub);
            bool described = ect_load_le16(reply + 10) != 0 && ect_load_le16(reply + 12) != 0;
            if (described != exists || (!described && (length != 16 || ect_load_le32(reply + 10) != 0)))
                fail_msg("%04Xh:%u: readable %d, described %d", index, sub, exists, described);
        }
    }
}

static void all_aborts(void **state)
{
    static const uint32_t codes[] = {0x05030000, 0x05040000, 0x05040001, 0x05040005, 0x06010000, 0x06010001, 0x06010002,
                                     0x06020000, 0x06040041, 0x06040042, 0x06040043, 0x06040047, 0x06060000, 0x06070010,
                                     0x06070012, 0x06070013, 0x06090011, 0x06090030, 0x06090031, 0x06090032, 0x06090036,
                                     0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000023};
    static const uint32_t foreign[] = {0x06010003, 0x06010004, 0x06010006, 0x06090033, 0x060A0023, 0x08000024, 1};
    (void)state;
    assert_int_equal(COUNT(codes), 26);
    wire_go(&w, 0, PREOP);
    char text[16], message[ECT_SIGNAL_MESSAGE];
    for (size_t i = 0; i < COUNT(codes); i++) {
        snprintf(text, sizeof text, "0x%08X", codes[i]);
        signal_set(&w, "sdo_abort", text);
        uint32_t got = download(0x2400, 4, 50, 2);
        if (got != codes[i])
            fail_msg("expected abort %08X, got %08X", codes[i], got);
        assert_int_equal(download(0x2400, 4, 50, 2), 0); /* once */
    }
    static const struct {
        uint16_t index;
        uint8_t subindex;
        bool write;
        size_t size;
        uint32_t otherwise;
    } requests[] = {{0x2400, 4, false, 0, 0},          {0x6040, 0, false, 0, 0x06020000},
                    {0x2400, 9, false, 0, 0x06090011}, {0x2401, 0, false, 0, 0x06010001},
                    {0x6040, 0, true, 2, 0x06020000},  {0x2100, 1, true, 4, 0x06010002},
                    {0x2400, 4, true, 4, 0x06070012},  {0x2400, 1, true, 1, 0x06090030}};
    for (size_t i = 0; i < COUNT(requests); i++) { /* whatever the other errors of the request */
        for (unsigned int with = 0; with < 2; with++) {
            uint32_t value;
            signal_set(&w, "sdo_abort", with ? "0x08000021" : "0");
            uint32_t got = requests[i].write ? download(requests[i].index, requests[i].subindex, 9, requests[i].size)
                                             : upload(requests[i].index, requests[i].subindex, &value);
            uint32_t want = with ? 0x08000021 : requests[i].otherwise;
            if (got != want)
                fail_msg("%04Xh:%u, sdo_abort %u: expected %08X, got %08X", requests[i].index, requests[i].subindex,
                         with, want, got);
        }
    }
    for (size_t i = 0; i < COUNT(foreign); i++) {
        snprintf(text, sizeof text, "0x%08X", foreign[i]);
        assert_false(signal_try_set(&w, "sdo_abort", text, message));
    }
}

/* Refusals and their texts; buttons do nothing at 0. */
static void signals(void **state)
{
    static const struct {
        const char *name, *value, *why;
    } refused[] = {{"units", "3", "output_unit"},
                   {"output_unit", "4", "units"},
                   {"units", "9", "1..8"},
                   {"judgement0", "0", "1 (OK)"},
                   {"judgement0", "2", "-1..1"},
                   {"camera", "3", "0..2"},
                   {"scene", "128", "0..127"},
                   {"scene_group", "32", "0..31"},
                   {"ready", "1", "twin's own"},
                   {"period1", "0", "1.."},
                   {"image_input", "99", "100.."},
                   {"sdo_abort", "5", "26"},
                   {"comment1", "123456789012345678901234567890123", "32"}};
    static const char *const buttons[] = {"trigger", "save", "restart", "row_add", "row_clear"};
    (void)state;
    for (size_t i = 0; i < COUNT(refused); i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        if (signal_try_set(&w, refused[i].name, refused[i].value, message) || !strstr(message, refused[i].why))
            fail_msg("%s=%s: expected a refusal with '%s', got '%s'", refused[i].name, refused[i].value, refused[i].why,
                     message);
    }
    for (size_t i = 0; i < COUNT(buttons); i++)
        signal_set(&w, buttons[i], "0");
    wire_advance(&w, 10000 * MS);
    assert_int_equal(signal_number(&w, "measurements"), 0);
    assert_int_equal(signal_number(&w, "rows"), 0);
    assert_int_equal(signal_number(&w, "run"), 1);
    signal_set(&w, "err", "1");
    assert_int_equal(signal_number(&w, "err"), 1);
    signal_set(&w, "restart", "1");
    signal_set(&w, "restart", "1"); /* once is enough */
    wire_advance(&w, 4000 * MS);
    assert_int_equal(signal_number(&w, "err"), 0);
}

static void start_sync0(uint32_t cycle)
{
    uint8_t number[8];
    assert_int_equal(wire_read(&w, 0, ECT_REG_DC_SYSTEM_TIME, number, 8), 1);
    ect_store_le64(number, ect_load_le64(number) + 10 * MS);
    assert_int_equal(wire_write16(&w, 0, 0x0980, 0), 1);
    assert_int_equal(wire_write(&w, 0, ECT_REG_DC_START_TIME, number, 8), 1);
    ect_store_le32(number, cycle);
    assert_int_equal(wire_write(&w, 0, ECT_REG_DC_SYNC0_CYCLE, number, 4), 1);
    assert_int_equal(wire_write16(&w, 0, 0x0980, 0x0300), 1);
}

static void cycles(void **state)
{
    static const struct {
        uint32_t ns;
        bool accepted;
    } rows[] = {{250000, true},   {500000, true},   {1000000, true},    {2000000, true}, {4000000, true},
                {0, false},       {125000, false},  {249999, false},    {250001, false}, {750000, false},
                {3000000, false}, {8000000, false}, {UINT32_MAX, false}};
    (void)state;
    wire_go(&w, 0, PREOP);
    wire_configure_process_data(&w, 0);
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t code;
        start_sync0(rows[i].ns);
        uint8_t status = wire_al(&w, 0, SAFEOP, &code);
        if (status != (rows[i].accepted ? SAFEOP : PREOP | ERR) || code != (rows[i].accepted ? 0 : 0x0036))
            fail_msg("SYNC0 every %u ns: got AL status %02X, code %04X", rows[i].ns, status, code);
        (void)wire_al(&w, 0, PREOP | 0x10, NULL);
    }
}

/* Some masters start SYNC0 when the slave is in SAFEOP already. */
static void cycles_before_op(void **state)
{
    uint8_t off[20] = {0};
    uint16_t code;
    (void)state;
    wire_go(&w, 0, SAFEOP);
    (void)wire_write(&w, 0, 0x1100, off, sizeof off);
    start_sync0(3000000);
    assert_int_equal(wire_al(&w, 0, OP, &code), SAFEOP | ERR);
    assert_int_equal(code, 0x0036);
    start_sync0(2000000);
    (void)wire_al(&w, 0, SAFEOP | 0x10, NULL);
    assert_int_equal(wire_al(&w, 0, OP, &code), OP);
}

/* With SYNC0 running, and no outputs at all, a measurement takes its usual time. */
static void asynchronous(void **state)
{
    (void)state;
    wire_go(&w, 0, PREOP);
    start_sync0(250000);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_WD_TIME_PD, 0), 1);
    wire_go(&w, 0, OP);
    wire_advance(&w, 60000 * MS);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), OP);
    signal_set(&w, "trigger", "1");
    wire_advance(&w, 25 * MS - 1);
    assert_int_equal(signal_number(&w, "measurements"), 0);
    wire_advance(&w, 1);
    assert_int_equal(signal_number(&w, "measurements"), 1);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS), OP);
}

static void node_address(void **state)
{
    static const struct {
        const char *address;
        uint16_t alias;
    } rows[] = {{"3", 3}, {"9", 9}, {"0", 0}, {"1", 1}};
    char message[ECT_SIGNAL_MESSAGE];
    (void)state;
    assert_false(signal_try_set(&w, "node_address", "10", message));
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t before = wire_read16(&w, 0, ECT_REG_STATION_ALIAS), code;
        signal_set(&w, "node_address", rows[i].address);
        assert_int_equal(wire_read16(&w, 0, ECT_REG_STATION_ALIAS), before); /* read at power-on only */
        signal_set(&w, "restart", "1");
        wire_advance(&w, 4000 * MS);
        wire_assign_stations(&w);
        assert_int_equal(wire_read16(&w, 0, ECT_REG_STATION_ALIAS), rows[i].alias);
        wire_go(&w, 0, PREOP);
        (void)wire_al(&w, 0, PREOP | 0x20, &code);
        assert_int_equal(code, rows[i].alias);
        (void)wire_al(&w, 0, INIT, NULL);
    }
}

static void sii(void **state)
{
    uint8_t image[2048];
    const ect_identity_t *id = &ect_fzm1.identity;
    (void)state;
    assert_true(ect_sii_write(&ect_fzm1, id, 5, image, sizeof image) > 0);
    assert_int_equal(ect_load_le32(image + 16), id->vendor_id);
    assert_int_equal(ect_load_le32(image + 20), id->product_code);
    assert_int_equal(ect_load_le16(image + 8), 5);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-001 FZM-002 FZM-003 FZM-004 FZM-005: each state permits its services; the slave never goes to a "
             "higher state by itself",
             states),
        TEST("FZM-006 FZM-007 FZM-008 FZM-036 FZM-037 FZM-039 OM-C1: mapping and assignment are fixed", mapping),
        TEST("FZM-018: 20 bytes of outputs, 48 of inputs, and no others", sizes),
        TEST("FZM-012 FZM-013 FZM-014 FZM-026 FZM-027 FZM-028 FZM-029 OM-C13: settings in PreOp, SafeOp and Op, their "
             "ranges and "
             "refusals",
             settings),
        TEST("FZM-026 FZM-027 FZM-028 FZM-029 FZM-031 OM-C12: factory settings", defaults),
        TEST("FZM-010 FZM-030: a comment on each output, by SDO", comments),
        TEST("FZM-009 FZM-010 FZM-012 OM-C9: each wrong request gets its abort code", natural_aborts),
        TEST("FZM-009 FZM-010: gaps of 1C32h and 1C33h have data type 0 and 0 bits in SDO information", gaps),
        TEST("FZM-011 FZM-012 FZM-013 FZM-014: each of the 26 abort codes can be selected, and no other, for any SDO "
             "request",
             all_aborts),
        TEST("FZM-015 OM-C10 CF-092: DC cycles of 250, 500 us, 1, 2, 4 ms and no others", cycles),
        TEST("FZM-015 CF-092: a cycle time written in SAFEOP is checked at the transition to OP", cycles_before_op),
        TEST("FZM-016 OM-C10: the measurement does not depend on SYNC0", asynchronous),
        TEST("FZM-019 OM-C18: node address 1 to 9 is alias and device id from the next restart, 0 keeps the alias",
             node_address),
        TEST("FZM-030 FZM-048 FZM-067: signals that a user must not set are refused with the reason", signals),
        TEST("CF-057: SII", sii),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 tables", tests, NULL, NULL);
}
