/* SPDX-License-Identifier: MIT */
/* A drive over a dictionary: entries of each width, cycle times, losses of supply and of OP, refused values. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/cia402/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define MS           1000000ull
enum { VALUES = ECT_402_VALUE_COUNT, STATE_MASK = 0x6F };

/* A drive whose entries are all there, 32 bits with a sign. */
typedef struct rig {
    ect_402_drive_t d;
    ect_402_surroundings_t around;
    ect_402_link_t links[VALUES];
    int32_t value[VALUES];
    ect_host_t host;
    uint64_t now_ns;
    unsigned int emergencies;
    uint16_t code;
    uint8_t error_register;
} rig_t;

static rig_t r;

static void emergency(void *ctx, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    rig_t *rig = ctx;
    (void)data;
    rig->emergencies++;
    rig->code = code;
    rig->error_register = error_register;
}

static void prepare(void)
{
    memset(&r, 0, sizeof r);
    r.host = (ect_host_t){.ctx = &r, .emergency = emergency};
    r.now_ns = 1000 * MS;
    for (unsigned int i = 0; i < VALUES; i++)
        r.links[i] = (ect_402_link_t){.offset = (uint32_t)(i * sizeof r.value[0]),
                                      .bytes = 4,
                                      .is_signed = true,
                                      .output = ect_402_object((ect_402_value_t)i)->kind == ECT_402_COMMAND};
}

static void power_on(void)
{
    ect_402_drive_init(&r.d, r.links, &r.around, r.value, &r.host, r.now_ns);
    ect_402_drive_enter_op(&r.d, r.now_ns);
}

static void cycle(unsigned int ms)
{
    for (unsigned int i = 0; i < ms; i++) {
        r.now_ns += MS;
        ect_402_drive_outputs(&r.d, r.now_ns);
        ect_402_drive_advance(&r.d, r.now_ns);
        ect_402_drive_publish(&r.d);
    }
}

static unsigned int state(void)
{
    return (unsigned int)r.value[ECT_402_V_STATUS] & STATE_MASK;
}

static void control(int32_t word)
{
    r.value[ECT_402_V_CONTROL] = word;
    cycle(2);
}

static void enable(void)
{
    r.value[ECT_402_V_MODE] = ECT_402_CSV;
    control(0x06);
    control(0x07);
    control(0x0F);
    assert_int_equal(state(), 0x27);
}

/* --- entries ------------------------------------------------------------------------------------------------------ */

static void widths(void **unused)
{
    static const struct {
        const char *what;
        uint8_t bytes;
        bool is_signed, is_real;
        int64_t number, loaded;
    } rows[] = {
        {"no entry", 0, false, false, 5, 0},
        {"8 bits", 1, false, false, 200, 200},
        {"8 bits, too large", 1, false, false, 256, 255},
        {"8 bits, negative", 1, false, false, -1, 0},
        {"8 bits with a sign", 1, true, false, -100, -100},
        {"8 bits with a sign, too small", 1, true, false, -129, -128},
        {"16 bits", 2, false, false, 60000, 60000},
        {"16 bits with a sign", 2, true, false, -30000, -30000},
        {"16 bits with a sign, too large", 2, true, false, 32768, 32767},
        {"32 bits", 4, false, false, 4000000000, 4000000000},
        {"32 bits with a sign", 4, true, false, -2000000000, -2000000000},
        {"64 bits", 8, true, false, -5000000000, -5000000000},
        {"64 bits, bounded above", 8, true, false, INT64_MAX, 9007199254740992},
        {"64 bits, bounded below", 8, false, false, INT64_MIN, -9007199254740992},
        {"REAL32", 4, true, true, -1024, -1024},
        {"REAL64", 8, true, true, 123456789012, 123456789012},
        {"REAL64 beyond 2^53", 8, true, true, INT64_MAX, 0},
        {"REAL64 below -2^53", 8, true, true, INT64_MIN, 0},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint8_t memory[8] = {0};
        ect_402_link_t link = {.bytes = rows[i].bytes, .is_signed = rows[i].is_signed, .is_real = rows[i].is_real};
        ect_402_store(memory, &link, rows[i].number);
        int64_t got = ect_402_load(memory, &link);
        if (got != rows[i].loaded)
            fail_msg("%s: expected %lld, got %lld", rows[i].what, (long long)rows[i].loaded, (long long)got);
    }
}

static void fractions(void **unused)
{
    static const struct {
        double number;
        int64_t loaded;
    } rows[] = {{0.4, 0}, {0.5, 1}, {-0.4, 0}, {-0.5, -1}, {1e300, 0}, {-1e300, 0}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ect_402_link_t link = {.bytes = 8, .is_real = true};
        double memory = rows[i].number;
        assert_int_equal(ect_402_load(&memory, &link), rows[i].loaded);
    }
}

/* Entries that hold no number of 1, 2, 4 or 8 bytes are not used; control and status word make an axis. */
static void links(void **unused)
{
    static const ect_entry_t status[] = {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "Status", 0, (void *)2}};
    static const ect_entry_t constant[] = {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "Status", 7, NULL}};
    static const ect_entry_t word[] = {
        {0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW | ECT_ACCESS_RXPDO, "Control", 0, (void *)2}};
    static const ect_entry_t text[] = {{0, ECT_TYPE_VISIBLE_STRING, 64, ECT_ACCESS_RW, "Text", 0, (void *)8}};
    static const ect_entry_t octets[] = {{0, ECT_TYPE_OCTET_STRING, 32, ECT_ACCESS_RW, "Octets", 0, (void *)16}};
    static const ect_entry_t three[] = {{0, ECT_TYPE_UNSIGNED32, 24, ECT_ACCESS_RW, "Three bytes", 0, (void *)20}};
    static const ect_entry_t real[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "Real", 0, (void *)24}};
    static const ect_entry_t small[] = {{0, ECT_TYPE_INTEGER8, 8, ECT_ACCESS_RW, "Small", 3, (void *)28}};
    static const ect_entry_t large[] = {{0, ECT_TYPE_INTEGER64, 64, ECT_ACCESS_RW, "Large", 0, (void *)32}};
#define VAR(index, entries) {index, ECT_OBJECT_VAR, 0, 0, "", entries}
    static const ect_object_t all[] = {VAR(0x6040, word),  VAR(0x6041, status), VAR(0x6060, small),  VAR(0x607A, large),
                                       VAR(0x607C, three), VAR(0x6081, text),   VAR(0x6083, octets), VAR(0x60FF, real)};
    static const ect_object_t no_status[] = {VAR(0x6040, word), VAR(0x6041, constant)};
    const ect_device_t device = {.objects = all, .object_count = COUNT(all)};
    const ect_device_t other = {.objects = no_status, .object_count = COUNT(no_status)};
    ect_402_link_t found[VALUES];
    ect_od_t od = ect_device_od(&device, NULL);
    (void)unused;
    assert_true(ect_402_links_find(&od, 0, found));
    assert_int_equal(found[ECT_402_V_CONTROL].bytes, 2);
    assert_true(found[ECT_402_V_CONTROL].output);
    assert_true(found[ECT_402_V_MODE].is_signed && found[ECT_402_V_MODE].given);
    assert_int_equal(found[ECT_402_V_TARGET_POSITION].bytes, 8);
    assert_int_equal(found[ECT_402_V_HOME_OFFSET].bytes, 0);
    assert_int_equal(found[ECT_402_V_TASK_SPEED].bytes, 0);
    assert_int_equal(found[ECT_402_V_ACCELERATION].bytes, 0);
    assert_true(found[ECT_402_V_TARGET_SPEED].is_real);
    assert_false(ect_402_links_find(&od, 1, found));
    od = ect_device_od(&other, NULL);
    assert_false(ect_402_links_find(&od, 0, found));
}

/* --- the drive ---------------------------------------------------------------------------------------------------- */

static void loses_op(void **unused)
{
    static const struct {
        const char *what;
        int32_t option;
        bool entry, enabled;
        unsigned int state;
        int32_t code;
    } rows[] = {
        {"0: nothing is a loss of supply", 0, true, true, 0x40, 0},
        {"1: a fault", 1, true, true, 0x08, 0x7500},
        {"2: off", 2, true, true, 0x40, 0},
        {"3: quick stop leaves the axis as it is", 3, true, true, 0x27, 0},
        {"without 6007h: a fault", 0, false, true, 0x08, 0x7500},
        {"an axis without torque", 1, true, false, 0x40, 0},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        if (!rows[i].entry)
            r.links[ECT_402_V_ABORT_OPTION].bytes = 0;
        power_on();
        r.value[ECT_402_V_ABORT_OPTION] = rows[i].option;
        ect_402_drive_written(&r.d, ECT_402_V_ABORT_OPTION, r.now_ns);
        if (rows[i].enabled)
            enable();
        else
            control(0);
        ect_402_drive_leave_op(&r.d, r.now_ns);
        ect_402_drive_advance(&r.d, r.now_ns + 2 * MS);
        ect_402_drive_publish(&r.d);
        if (r.d.error_code != rows[i].code || (rows[i].code != 0) != ((state() & 0x08) != 0))
            fail_msg("DRV-155, %s: expected code %04X, got %04X in state %02X", rows[i].what,
                     (unsigned int)rows[i].code, r.d.error_code, state());
    }
}

static void loses_supply(void **unused)
{
    static const struct {
        const char *what;
        bool sto;
        uint16_t code;
        uint8_t error_register;
    } rows[] = {{"STO", true, 0x5441, 0x01}, {"power", false, 0x3220, 0x05}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        enable();
        r.around.sto = rows[i].sto;
        r.around.power = rows[i].sto;
        cycle(3);
        if (r.code != rows[i].code || r.error_register != rows[i].error_register || (state() & 0x08) == 0)
            fail_msg("%s: expected code %04X with register %02X, got %04X with %02X, state %02X", rows[i].what,
                     rows[i].code, rows[i].error_register, r.code, r.error_register, state());
        control(0);
        control(0x80);
        assert_int_equal(state(), 0x08); /* the cause is there: it cannot be reset */
        r.around.sto = 0;
        r.around.power = 1;
        control(0);
        control(0x80);
        assert_int_equal(state(), 0x40);
        assert_int_equal(r.code, 0);
    }
}

static void error_registers(void **unused)
{
    static const struct {
        uint16_t code;
        uint8_t error_register;
    } rows[] = {{0x2310, 0x03}, {0x3210, 0x05}, {0x4210, 0x09}, {0x7500, 0x11}, {0x8130, 0x11},
                {0x8611, 0x21}, {0xFF01, 0x21}, {0x7300, 0x01}, {0x5441, 0x01}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        ect_402_drive_fault(&r.d, 0);
        assert_int_equal(r.emergencies, 0);
        ect_402_drive_fault(&r.d, rows[i].code);
        ect_402_drive_fault(&r.d, rows[i].code);
        assert_int_equal(r.emergencies, 1);
        if (r.error_register != rows[i].error_register)
            fail_msg("%04X: expected register %02X, got %02X", rows[i].code, rows[i].error_register, r.error_register);
        ect_402_drive_fault_reset(&r.d);
        ect_402_drive_fault_reset(&r.d);
        assert_int_equal(r.emergencies, 2);
    }
}

/* 60C2h of the master, else the time between the last two outputs, 3 ms here. */
static void cycle_times(void **unused)
{
    static const struct {
        int32_t units, power;
        uint32_t steps; /* of 250 us */
    } rows[] = {{1, -3, 4}, {2, -3, 8}, {250, -6, 1}, {25, -5, 1},  {1, 0, 4000},
                {2, 0, 1},  {1, 1, 12}, {0, -3, 12},  {1, -12, 12}, {100, -6, 1}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.value[ECT_402_V_CYCLE_UNITS] = rows[i].units;
        r.value[ECT_402_V_CYCLE_POWER] = rows[i].power;
        ect_402_drive_written(&r.d, ECT_402_V_CYCLE_UNITS, r.now_ns);
        for (int n = 0; n < 3; n++) {
            r.now_ns += 3 * MS;
            ect_402_drive_outputs(&r.d, r.now_ns);
        }
        if (r.d.axis.cycle_steps != rows[i].steps)
            fail_msg("60C2h %d, %d: expected %u steps, got %u", rows[i].units, rows[i].power, rows[i].steps,
                     r.d.axis.cycle_steps);
    }
}

static void sync0(void **unused)
{
    (void)unused;
    prepare();
    power_on();
    r.value[ECT_402_V_MODE] = ECT_402_CSV;
    ect_402_drive_sync0(&r.d, r.now_ns); /* no outputs yet */
    assert_int_equal(r.d.axis.set.control, 0);
    r.value[ECT_402_V_CONTROL] = 6;
    ect_402_drive_outputs(&r.d, r.now_ns);
    assert_int_equal(r.d.axis.set.control, 0); /* it waits for SYNC0 */
    r.now_ns += MS;
    ect_402_drive_sync0(&r.d, r.now_ns);
    assert_int_equal(r.d.axis.set.control, 6);
    r.now_ns += 100 * MS; /* SYNC0 has ended: outputs count at once */
    r.value[ECT_402_V_CONTROL] = 7;
    ect_402_drive_outputs(&r.d, r.now_ns);
    assert_int_equal(r.d.axis.set.control, 7);
}

static void by_mailbox(void **unused)
{
    (void)unused;
    prepare();
    power_on();
    r.value[ECT_402_V_CONTROL] = 6;
    ect_402_drive_written(&r.d, ECT_402_V_CONTROL, r.now_ns);
    assert_int_equal(r.d.axis.set.control, 6);
    ect_402_drive_leave_op(&r.d, r.now_ns);
    r.value[ECT_402_V_TARGET_SPEED] = 77;
    ect_402_drive_written(&r.d, ECT_402_V_TARGET_SPEED, r.now_ns);
    assert_false(r.d.axis.live);
    r.value[ECT_402_V_HOME_OFFSET] = 5;
    ect_402_drive_written(&r.d, ECT_402_V_HOME_OFFSET, r.now_ns);
    assert_int_equal(r.d.value[ECT_402_V_HOME_OFFSET], 5);
}

static void rests(void **unused)
{
    (void)unused;
    prepare();
    power_on();
    assert_true(ect_402_drive_next(&r.d) == ECT_NEVER);
    r.now_ns += 1000 * MS;
    ect_402_drive_advance(&r.d, r.now_ns);
    enable();
    assert_true(ect_402_drive_next(&r.d) <= r.now_ns + MS);
}

/* 6502h of the file counts, as far as the objects allow its modes. */
static void modes(void **unused)
{
    static const struct {
        const char *what;
        ect_402_value_t missing;
        int32_t supported;
        uint32_t modes;
    } rows[] = {{"all", ECT_402_V_MODES, 0, 0x3ED},
                {"6502h: csp alone", ECT_402_VALUE_COUNT, 0x80, 0x80},
                {"6502h: a mode that cannot be", ECT_402_VALUE_COUNT, 0x02, 0x3ED},
                {"no torque", ECT_402_V_TARGET_TORQUE, 0, 0x1E5},
                {"no speed", ECT_402_V_TARGET_SPEED, 0, 0x2E9},
                {"no position", ECT_402_V_TARGET_POSITION, 0, 0x36C},
                {"no 6081h", ECT_402_V_TASK_SPEED, 0, 0x3EC}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        if (rows[i].missing != ECT_402_VALUE_COUNT)
            r.links[rows[i].missing].bytes = 0;
        r.value[ECT_402_V_MODES] = rows[i].supported;
        power_on();
        if (r.d.modes != rows[i].modes)
            fail_msg("%s: expected modes %03X, got %03X", rows[i].what, rows[i].modes, r.d.modes);
    }
}

static void speed_units(void **unused)
{
    static const struct {
        uint8_t unit;
        double turns_a_second; /* that 600 is */
    } rows[] = {{ECT_402_UNIT_RPM, 10}, {ECT_402_UNIT_TENTH_RPM, 1}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.around.velocity_unit = rows[i].unit;
        ect_402_drive_touched(&r.d);
        enable();
        r.value[ECT_402_V_TARGET_SPEED] = 600;
        cycle(500);
        double got = r.d.speed_rpm / 60;
        if (got < rows[i].turns_a_second * 0.98 || got > rows[i].turns_a_second * 1.02)
            fail_msg("DRV-519, unit %u: expected %f turns a second, got %f", rows[i].unit, rows[i].turns_a_second, got);
        assert_true(r.value[ECT_402_V_SPEED] > 580 && r.value[ECT_402_V_SPEED] < 620);
    }
}

static void refused_values(void **unused)
{
    static const struct {
        const char *what;
        ect_402_value_t value;
        int64_t number;
        bool good;
    } rows[] = {
        {"6007h: 3", ECT_402_V_ABORT_OPTION, 3, true},     {"6007h: 4", ECT_402_V_ABORT_OPTION, 4, false},
        {"6007h: -1", ECT_402_V_ABORT_OPTION, -1, false},  {"605Ah: 2", ECT_402_V_QUICK_OPTION, 2, true},
        {"605Ah: 9", ECT_402_V_QUICK_OPTION, 9, false},    {"605Ah: of the vendor", ECT_402_V_QUICK_OPTION, -5, true},
        {"605Dh: 1", ECT_402_V_HALT_OPTION, 1, true},      {"605Dh: 99", ECT_402_V_HALT_OPTION, 99, false},
        {"6060h: csp", ECT_402_V_MODE, ECT_402_CSP, true}, {"6060h: 2, not supported", ECT_402_V_MODE, 2, false},
        {"6060h: 33", ECT_402_V_MODE, 33, false},          {"6060h: of the vendor", ECT_402_V_MODE, -1, true},
        {"6098h: 35", ECT_402_V_HOME_METHOD, 35, true},    {"6098h: 15", ECT_402_V_HOME_METHOD, 15, false},
        {"6098h: 200", ECT_402_V_HOME_METHOD, 200, false}, {"6098h: of the vendor", ECT_402_V_HOME_METHOD, -3, true},
        {"607Ah", ECT_402_V_TARGET_POSITION, 12345, true},
    };
    (void)unused;
    prepare();
    power_on();
    for (size_t i = 0; i < COUNT(rows); i++) {
        bool good = ect_402_drive_check(&r.d, rows[i].value, rows[i].number) == ECT_OK;
        if (good != rows[i].good)
            fail_msg("%s: expected that it is %s", rows[i].what, rows[i].good ? "accepted" : "refused");
    }
}

/* A file without defaults. A turn has 2^20 increments; windows of speed are as wide as their 16 bits allow. */
static void defaults(void **unused)
{
    static const struct {
        const char *what;
        ect_402_value_t value;
        int32_t number;
    } rows[] = {
        {"DRV-002 6007h", ECT_402_V_ABORT_OPTION, 1},
        {"DRV-003 603Fh", ECT_402_V_ERROR_CODE, 0},
        {"DRV-006 605Ah", ECT_402_V_QUICK_OPTION, 2},
        {"DRV-007 605Bh", ECT_402_V_SHUTDOWN_OPTION, 0},
        {"DRV-007 605Ch", ECT_402_V_DISABLE_OPTION, 1},
        {"DRV-009 605Dh", ECT_402_V_HALT_OPTION, 1},
        {"DRV-010 605Eh", ECT_402_V_FAULT_OPTION, 2},
        {"DRV-011 6060h", ECT_402_V_MODE, 0},
        {"DRV-012 6061h", ECT_402_V_MODE_DISPLAY, 0},
        {"DRV-016 6065h", ECT_402_V_ERROR_WINDOW, 1048576},
        {"DRV-016 6066h", ECT_402_V_ERROR_TIME, 10},
        {"DRV-018 6068h", ECT_402_V_POSITION_TIME, 10},
        {"DRV-024 606Eh", ECT_402_V_SPEED_TIME, 10},
        {"DRV-025 6070h", ECT_402_V_ZERO_TIME, 10},
        {"DRV-027 6072h", ECT_402_V_MAX_TORQUE, 3000},
        {"DRV-027 6073h", ECT_402_V_MAX_CURRENT, 3000},
        {"DRV-030 6075h", ECT_402_V_RATED_CURRENT, 5000},
        {"DRV-030 6076h", ECT_402_V_RATED_TORQUE, 3000},
        {"DRV-034 6079h", ECT_402_V_DC_LINK, 325000},
        {"DRV-039 607Eh", ECT_402_V_POLARITY, 0},
        {"DRV-040 607Fh", ECT_402_V_SPEED_LIMIT, 104857600},
        {"DRV-041 6080h", ECT_402_V_MOTOR_SPEED, 6000},
        {"DRV-042 6081h", ECT_402_V_TASK_SPEED, 10485760},
        {"DRV-042 6082h", ECT_402_V_END_SPEED, 0},
        {"DRV-044 6083h", ECT_402_V_ACCELERATION, 104857600},
        {"DRV-044 6084h", ECT_402_V_DECELERATION, 104857600},
        {"DRV-046 6085h", ECT_402_V_QUICK_DECELERATION, 524288000},
        {"DRV-047 6086h", ECT_402_V_PROFILE_TYPE, 0},
        {"DRV-048 6087h", ECT_402_V_TORQUE_SLOPE, 10000},
        {"DRV-055 6098h", ECT_402_V_HOME_METHOD, 0},
        {"DRV-056 6099h:1", ECT_402_V_HOME_SEARCH, 2097152},
        {"DRV-056 6099h:2", ECT_402_V_HOME_ZERO, 524288},
        {"DRV-057 609Ah", ECT_402_V_HOME_ACCELERATION, 10485760},
        {"DRV-060 60B9h", ECT_402_V_PROBE_STATUS, 0},
        {"DRV-064 60C0h", ECT_402_V_SUB_MODE, 0},
        {"DRV-066 60C5h", ECT_402_V_MOST_ACCELERATION, INT32_MAX},
        {"DRV-067 60D0h:1", ECT_402_V_PROBE_SOURCE_1, 1},
        {"DRV-067 60D0h:2", ECT_402_V_PROBE_SOURCE_2, 2},
        {"DRV-071 60E0h", ECT_402_V_TORQUE_POSITIVE, 3000},
        {"DRV-071 60E1h", ECT_402_V_TORQUE_NEGATIVE, 3000},
        {"DRV-073 60F2h", ECT_402_V_POSITIONING, 0},
        {"DRV-078 60FDh", ECT_402_V_INPUTS, 0},
        {"DRV-079 60FEh:1", ECT_402_V_OUTPUTS, 0},
        {"DRV-082 6502h", ECT_402_V_MODES, 0x3ED},
    };
    (void)unused;
    prepare();
    power_on();
    cycle(1);
    for (size_t i = 0; i < COUNT(rows); i++) {
        if (r.value[rows[i].value] != rows[i].number)
            fail_msg("%s: expected %d, got %d", rows[i].what, rows[i].number, r.value[rows[i].value]);
    }
}

/* Actual values of a motion in csv: 120 turns a minute against 1 Nm, a third of the rated torque. */
static void actual_values(void **unused)
{
    static const struct {
        const char *what;
        ect_402_value_t value;
        int32_t number, off;
    } rows[] = {
        {"DRV-005 6041h", ECT_402_V_STATUS, 0x1237, 0},
        {"DRV-012 6061h", ECT_402_V_MODE_DISPLAY, ECT_402_CSV, 0},
        {"DRV-020 6069h", ECT_402_V_SENSOR_SPEED, 2097152, 2000},
        {"DRV-022 606Bh", ECT_402_V_SPEED_DEMAND, 2097152, 0},
        {"DRV-023 606Ch", ECT_402_V_SPEED, 2097152, 2000},
        {"DRV-032 6074h", ECT_402_V_TORQUE_DEMAND, 350, 2}, /* friction is a sixtieth */
        {"DRV-032 6077h", ECT_402_V_TORQUE, 350, 2},
        {"DRV-032 6078h", ECT_402_V_CURRENT, 350, 2},
        {"DRV-074 60F4h", ECT_402_V_FOLLOWING_ERROR, 0, 0},
        {"DRV-076 60FAh", ECT_402_V_EFFORT, 2097152, 0},
    };
    (void)unused;
    prepare();
    power_on();
    enable();
    r.around.machine.load = 1;
    r.value[ECT_402_V_TARGET_SPEED] = 2097152;
    cycle(500);
    for (size_t i = 0; i < COUNT(rows); i++) {
        int32_t got = r.value[rows[i].value];
        if (got < rows[i].number - rows[i].off || got > rows[i].number + rows[i].off)
            fail_msg("%s: expected %d, got %d", rows[i].what, rows[i].number, got);
    }
    assert_int_equal(r.value[ECT_402_V_POSITION], r.value[ECT_402_V_INTERNAL]);
    assert_int_equal(r.value[ECT_402_V_DEMAND], r.value[ECT_402_V_INTERNAL_DEMAND]);
    assert_true(r.value[ECT_402_V_POSITION] > 900000);
}

/* Profiles other than the linear ones. */
static void refused_profiles(void **unused)
{
    static const ect_402_value_t values[] = {ECT_402_V_PROFILE_TYPE, ECT_402_V_TORQUE_PROFILE, ECT_402_V_SUB_MODE};
    (void)unused;
    prepare();
    power_on();
    for (size_t i = 0; i < COUNT(values); i++) {
        assert_int_equal(ect_402_drive_check(&r.d, values[i], 1), ECT_REASON_RANGE);
        assert_int_equal(ect_402_drive_check(&r.d, values[i], 0), ECT_OK);
    }
}

/* Bits 10 and 12 of an acceleration in pv, at each millisecond. */
static void speed_windows(void **unused)
{
    enum { TARGET = 524288, SPEED_WINDOW = 51000, ZERO_WINDOW = 62000 };
    unsigned int near = 0, zero = 0;
    (void)unused;
    prepare();
    power_on();
    enable();
    r.value[ECT_402_V_MODE] = ECT_402_PV;
    r.value[ECT_402_V_ACCELERATION] = 1048576;
    r.value[ECT_402_V_SPEED_WINDOW] = SPEED_WINDOW;
    r.value[ECT_402_V_ZERO_WINDOW] = ZERO_WINDOW;
    r.value[ECT_402_V_SPEED_TIME] = r.value[ECT_402_V_ZERO_TIME] = 0;
    ect_402_drive_touched(&r.d);
    cycle(20);
    r.value[ECT_402_V_TARGET_SPEED] = TARGET;
    for (unsigned int ms = 0; ms < 700; ms++) {
        cycle(1);
        int32_t speed = r.value[ECT_402_V_SPEED];
        unsigned int status = (unsigned int)r.value[ECT_402_V_STATUS];
        bool is_near = TARGET - speed <= SPEED_WINDOW && speed - TARGET <= SPEED_WINDOW;
        bool is_zero = speed <= ZERO_WINDOW && speed >= -ZERO_WINDOW;
        near += is_near;
        zero += is_zero;
        if ((status >> 10 & 1) != is_near || (status >> 12 & 1) != is_zero)
            fail_msg("%u ms, 606Ch %d: expected bit 10 %d and bit 12 %d, got status 0x%04X", ms, speed, is_near,
                     is_zero, status);
    }
    assert_in_range(near, 200, 300); /* from 473288 increments a second on */
    assert_in_range(zero, 40, 100);  /* up to 62000 */
}

/* An acceleration that no torque reaches: the drive gives 6072h, in thousandths of the rated torque. */
static void most_torque(void **unused)
{
    static const int32_t limits[] = {500, 1500, 3000};
    (void)unused;
    for (size_t i = 0; i < COUNT(limits); i++) {
        int32_t most = 0;
        prepare();
        power_on();
        r.value[ECT_402_V_MAX_TORQUE] = limits[i];
        ect_402_drive_touched(&r.d);
        enable();
        r.around.machine.load = 1;
        r.value[ECT_402_V_TARGET_SPEED] = 20 << 20;
        for (unsigned int ms = 0; ms < 100; ms++) {
            cycle(1);
            most = r.value[ECT_402_V_TORQUE] > most ? r.value[ECT_402_V_TORQUE] : most;
        }
        if (most < limits[i] - 1 || most > limits[i])
            fail_msg("6072h %d: expected this as the greatest 6077h, got %d", limits[i], most);
    }
}

static void jammed(void **unused)
{
    (void)unused;
    prepare();
    power_on();
    enable();
    r.around.machine.jam = 1;
    r.value[ECT_402_V_TARGET_SPEED] = 1 << 20;
    for (unsigned int ms = 0; ms < 200; ms++) {
        cycle(1);
        assert_int_equal(r.value[ECT_402_V_SPEED], 0);
        assert_int_equal(r.value[ECT_402_V_POSITION], 0);
    }
    assert_true(r.value[ECT_402_V_TORQUE] > 0);
    r.around.machine.jam = 0;
    cycle(200);
    assert_true(r.value[ECT_402_V_POSITION] > 0);
}

static void motor_speeds(void **unused)
{
    static const int32_t turns_a_minute[] = {1, 2, 60, 600};
    (void)unused;
    for (size_t i = 0; i < COUNT(turns_a_minute); i++) {
        prepare();
        power_on();
        r.value[ECT_402_V_MOTOR_SPEED] = turns_a_minute[i];
        ect_402_drive_touched(&r.d);
        enable();
        r.value[ECT_402_V_TARGET_SPEED] = 100 << 20;
        cycle(500);
        const int32_t want = (int32_t)(turns_a_minute[i] * 1048576.0 / 60);
        if (r.value[ECT_402_V_SPEED] < want - want / 100 - 2 || r.value[ECT_402_V_SPEED] > want + want / 100 + 2)
            fail_msg("6080h %d: expected a speed of %d, got %d", turns_a_minute[i], want, r.value[ECT_402_V_SPEED]);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"Numbers in entries of each width, with the nearest for one that does not fit", widths, NULL, NULL, NULL},
        {"Numbers in floating point are rounded", fractions, NULL, NULL, NULL},
        {"Entries without a number are not used", links, NULL, NULL, NULL},
        {"DRV-155 DRV-156: the end of OP, by 6007h", loses_op, NULL, NULL, NULL},
        {"A loss of supply is a fault that is reset when the supply is back", loses_supply, NULL, NULL, NULL},
        {"Bits of the error register, by the code of the fault", error_registers, NULL, NULL, NULL},
        {"The cycle is that of 60C2h, or that of the outputs", cycle_times, NULL, NULL, NULL},
        {"With SYNC0 outputs come into force at the next one", sync0, NULL, NULL, NULL},
        {"Commands by SDO count in OP", by_mailbox, NULL, NULL, NULL},
        {"A drive at rest has no deadline", rests, NULL, NULL, NULL},
        {"Modes are those for which the objects exist", modes, NULL, NULL, NULL},
        {"DRV-002 DRV-006 DRV-007 DRV-009 DRV-010 defaults where the file has none", defaults, NULL, NULL, NULL},
        {"DRV-005 DRV-014 DRV-022 DRV-023 DRV-032 actual values of a motion", actual_values, NULL, NULL, NULL},
        {"DRV-047 DRV-048 DRV-064 profiles other than the linear ones are refused", refused_profiles, NULL, NULL, NULL},
        {"DRV-246 DRV-247: bit 10 within 606Dh of the target, bit 12 up to 606Fh", speed_windows, NULL, NULL, NULL},
        {"DRV-027 DRV-032: 6077h rises to 6072h and not beyond", most_torque, NULL, NULL, NULL},
        {"A jammed shaft does not move", jammed, NULL, NULL, NULL},
        {"DRV-041: 6080h limits the speed, from one turn a minute on", motor_speeds, NULL, NULL, NULL},
        {"DRV-519: speeds in turns a minute, and in tenths", speed_units, NULL, NULL, NULL},
        {"Options, modes and methods that do not exist are refused", refused_values, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("CiA 402 over a dictionary", tests, NULL, NULL);
}
