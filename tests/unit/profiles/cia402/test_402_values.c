/* SPDX-License-Identifier: MIT */
/* A drive over a dictionary: entries of each width, cycle times, losses of supply and of OP, refused values. */
#include "drive_rig.h"

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
        {"REAL64 beyond 2^53", 8, true, true, INT64_MAX, 9007199254740992},
        {"REAL64 below -2^53", 8, true, true, INT64_MIN, -9007199254740992},
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
    } rows[] = {{0.4, 0},
                {0.5, 1},
                {-0.4, 0},
                {-0.5, -1},
                {4503599627370495.0, 4503599627370495},
                {1e300, 9007199254740992},
                {-1e300, -9007199254740992},
                {(double)INFINITY, 9007199254740992},
                {(double)-INFINITY, -9007199254740992},
                {(double)NAN, 0}};
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

/* Not ready lasts until the first decision. */
static void power_up(void **unused)
{
    (void)unused;
    prepare();
    assert_int_equal(r.d.axis.state, ECT_402_NOT_READY);
    r.value[ECT_402_V_STATUS] = -1;
    ect_402_drive_init(&r.d, r.links, &r.around, r.value, &r.host, r.now_ns);
    ect_402_drive_publish(&r.d);
    assert_int_equal(state() & 0x4F, 0x40);
    ect_402_drive_enter_op(&r.d, r.now_ns);
    cycle(100);
    assert_int_equal(state() & 0x4F, 0x40); /* 06h alone leads on */
    control(0x06);
    assert_int_equal(state(), 0x21);
}

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
        {"3: quick stop does not affect the axis", 3, true, true, 0x27, 0},
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
        assert_int_equal(state(), 0x08); /* the cause still exists: no reset */
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
        int32_t shown; /* 6502h */
    } rows[] = {{"all", ECT_402_V_MODES, 0, 0x3ED, 0},
                {"6502h: csp alone", ECT_402_VALUE_COUNT, 0x80, 0x80, 0x80},
                {"6502h: a mode that cannot be", ECT_402_VALUE_COUNT, 0x02, 0x3ED, 0x3ED},
                {"6502h: modes that can be and cannot", ECT_402_V_TARGET_TORQUE, 0xF028A, 0x80, 0xF0080},
                {"no torque", ECT_402_V_TARGET_TORQUE, 0, 0x1E5, 0x1E5},
                {"no speed", ECT_402_V_TARGET_SPEED, 0, 0x2E9, 0x2E9},
                {"no position", ECT_402_V_TARGET_POSITION, 0, 0x36C, 0x36C},
                {"no 6081h", ECT_402_V_TASK_SPEED, 0, 0x3EC, 0x3EC}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        if (rows[i].missing != ECT_402_VALUE_COUNT)
            r.links[rows[i].missing].bytes = 0;
        r.value[ECT_402_V_MODES] = rows[i].supported;
        power_on();
        if (r.d.modes != rows[i].modes)
            fail_msg("%s: expected modes %03X, got %03X", rows[i].what, rows[i].modes, r.d.modes);
        if (r.value[ECT_402_V_MODES] != rows[i].shown)
            fail_msg("%s: expected %05X in 6502h, got %05X", rows[i].what, (unsigned int)rows[i].shown,
                     (unsigned int)r.value[ECT_402_V_MODES]);
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
        {"DRV-004 6040h", ECT_402_V_CONTROL, 0},
        {"DRV-006 DRV-507 605Ah", ECT_402_V_QUICK_OPTION, 2},
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
        {"DRV-026 6071h", ECT_402_V_TARGET_TORQUE, 0},
        {"DRV-027 6072h", ECT_402_V_MAX_TORQUE, 3000},
        {"DRV-027 6073h", ECT_402_V_MAX_CURRENT, 3000},
        {"DRV-030 6075h", ECT_402_V_RATED_CURRENT, 5000},
        {"DRV-030 6076h", ECT_402_V_RATED_TORQUE, 3000},
        {"DRV-034 6079h", ECT_402_V_DC_LINK, 325000},
        {"DRV-035 607Ah", ECT_402_V_TARGET_POSITION, 0},
        {"DRV-037 607Ch", ECT_402_V_HOME_OFFSET, 0},
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
        {"DRV-058 60B0h", ECT_402_V_POSITION_OFFSET, 0},
        {"DRV-058 60B1h", ECT_402_V_SPEED_OFFSET, 0},
        {"DRV-058 60B2h", ECT_402_V_TORQUE_OFFSET, 0},
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
        {"DRV-080 60FFh", ECT_402_V_TARGET_SPEED, 0},
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

/* The default of 6081h, 10 485 760, in entries of each width. */
static void default_widths(void **unused)
{
    static const struct {
        const char *what;
        uint8_t bytes;
        bool is_signed, is_real;
        int64_t number;
    } rows[] = {
        {"8 bits with a sign", 1, true, false, 127},
        {"8 bits", 1, false, false, 255},
        {"16 bits with a sign", 2, true, false, 32767},
        {"16 bits", 2, false, false, 65535},
        {"32 bits", 4, false, false, 10485760},
        {"64 bits with a sign", 8, true, false, 10485760},
        {"64 bits", 8, false, false, 10485760},
        {"REAL32", 4, true, true, 10485760},
        {"REAL64", 8, true, true, 10485760},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        ect_402_link_t *link = &r.links[ECT_402_V_TASK_SPEED];
        r.links[ECT_402_V_END_SPEED].bytes = 0; /* in its place */
        link->bytes = rows[i].bytes;
        link->is_signed = rows[i].is_signed;
        link->is_real = rows[i].is_real;
        power_on();
        int64_t got = ect_402_load(r.value, link);
        if (got != rows[i].number)
            fail_msg("DRV-042, %s: expected %lld, got %lld", rows[i].what, (long long)rows[i].number, (long long)got);
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

/* --- settings ----------------------------------------------------------------------------------------------------- */

static int64_t member(size_t offset, size_t size)
{
    const uint8_t *at = (const uint8_t *)&r.d.axis + offset;
    ect_402_link_t link = {.bytes = (uint8_t)size, .is_signed = size < 4};
    return ect_402_load(at, &link);
}

#define MEMBER(name) offsetof(ect_402_axis_t, name), sizeof r.d.axis.name

static void settings(void **unused)
{
    static const struct {
        const char *what;
        ect_402_value_t value;
        uint8_t unit;
        int32_t number;
        size_t offset, size;
        int64_t taken;
    } rows[] = {
        {"605Ah", ECT_402_V_QUICK_OPTION, 0, 5, MEMBER(quick_option), 5},
        {"605Ah, too large", ECT_402_V_QUICK_OPTION, 0, 40000, MEMBER(quick_option), INT16_MAX},
        {"605Ah, too small", ECT_402_V_QUICK_OPTION, 0, -40000, MEMBER(quick_option), -INT16_MAX},
        {"605Bh", ECT_402_V_SHUTDOWN_OPTION, 0, 1, MEMBER(shutdown_option), 1},
        {"605Ch", ECT_402_V_DISABLE_OPTION, 0, 0, MEMBER(disable_option), 0},
        {"605Dh", ECT_402_V_HALT_OPTION, 0, 3, MEMBER(halt_option), 3},
        {"605Eh", ECT_402_V_FAULT_OPTION, 0, 4, MEMBER(fault_option), 4},
        {"6065h", ECT_402_V_ERROR_WINDOW, 0, 333, MEMBER(error_window), 333},
        {"6066h", ECT_402_V_ERROR_TIME, 0, 33, MEMBER(error_time), 33},
        {"6067h", ECT_402_V_POSITION_WINDOW, 0, 34, MEMBER(position_window), 34},
        {"6068h", ECT_402_V_POSITION_TIME, 0, 35, MEMBER(position_time), 35},
        {"606Dh", ECT_402_V_SPEED_WINDOW, 0, 36, MEMBER(speed_window), 36},
        {"606Eh", ECT_402_V_SPEED_TIME, 0, 37, MEMBER(speed_time), 37},
        {"606Fh", ECT_402_V_ZERO_WINDOW, 0, 38, MEMBER(zero_window), 38},
        {"6070h", ECT_402_V_ZERO_TIME, 0, 39, MEMBER(zero_time), 39},
        {"6072h", ECT_402_V_MAX_TORQUE, 0, 40, MEMBER(max_torque), 40},
        {"6073h", ECT_402_V_MAX_CURRENT, 0, 41, MEMBER(max_current), 41},
        {"607Fh", ECT_402_V_SPEED_LIMIT, 0, 42, MEMBER(speed_limit), 42},
        {"607Fh in turns a minute", ECT_402_V_SPEED_LIMIT, ECT_402_UNIT_RPM, 3, MEMBER(speed_limit), 52429},
        {"607Fh in tenths of them", ECT_402_V_SPEED_LIMIT, ECT_402_UNIT_TENTH_RPM, 3, MEMBER(speed_limit), 5243},
        {"607Fh below 0", ECT_402_V_SPEED_LIMIT, 0, -3, MEMBER(speed_limit), 0},
        {"6080h", ECT_402_V_MOTOR_SPEED, ECT_402_UNIT_RPM, 43, MEMBER(motor_speed), 43},
        {"6081h", ECT_402_V_TASK_SPEED, 0, 44, MEMBER(task_speed), 44},
        {"6082h", ECT_402_V_END_SPEED, 0, 45, MEMBER(end_speed), 45},
        {"6083h", ECT_402_V_ACCELERATION, 0, 46, MEMBER(acceleration), 46},
        {"6084h", ECT_402_V_DECELERATION, 0, 47, MEMBER(deceleration), 47},
        {"6085h", ECT_402_V_QUICK_DECELERATION, 0, 48, MEMBER(quick_deceleration), 48},
        {"6087h", ECT_402_V_TORQUE_SLOPE, 0, 49, MEMBER(torque_slope), 49},
        {"6098h", ECT_402_V_HOME_METHOD, 0, 35, MEMBER(home_method), 35},
        {"6099h:1", ECT_402_V_HOME_SEARCH, 0, 50, MEMBER(home_speed[0]), 50},
        {"6099h:2", ECT_402_V_HOME_ZERO, 0, 51, MEMBER(home_speed[1]), 51},
        {"609Ah", ECT_402_V_HOME_ACCELERATION, 0, 52, MEMBER(home_acceleration), 52},
        {"60C5h", ECT_402_V_MOST_ACCELERATION, 0, 53, MEMBER(most_acceleration), 53},
        {"60C6h", ECT_402_V_MOST_DECELERATION, 0, 54, MEMBER(most_deceleration), 54},
        {"60E0h", ECT_402_V_TORQUE_POSITIVE, 0, 55, MEMBER(torque_limit[0]), 55},
        {"60E1h", ECT_402_V_TORQUE_NEGATIVE, 0, 56, MEMBER(torque_limit[1]), 56},
        {"60F2h", ECT_402_V_POSITIONING, 0, 0x81, MEMBER(options), 0x81},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        preop();
        r.around.velocity_unit = rows[i].unit;
        r.value[rows[i].value] = rows[i].number;
        ect_402_drive_touched(&r.d);
        int64_t got = member(rows[i].offset, rows[i].size);
        if (got != rows[i].taken)
            fail_msg("%s = %d: expected %lld, got %lld", rows[i].what, rows[i].number, (long long)rows[i].taken,
                     (long long)got);
    }
}

/* 607Ch, 607Dh, 607Bh, by 607Eh. */
static void ranges(void **unused)
{
    static const struct {
        const char *what;
        int32_t polarity, offset, lower, upper, home, limit[2];
    } rows[] = {
        {"as they are", 0, 10, -100, 200, -10, {-110, 190}},
        {"turned round", 0x80, 10, -100, 200, 10, {-190, 110}},
        {"another bit", 0x7F, 10, -100, 200, -10, {-110, 190}},
        {"equal limits", 0, 10, 50, 50, -10, {0, 0}},
        {"crossed limits", 0, 10, 51, 50, -10, {0, 0}},
        {"both outermost", 0, 10, INT32_MIN, INT32_MAX, -10, {0, 0}},
        {"the lower one outermost", 0, 10, INT32_MIN, 200, -10, {INT32_MIN, 190}},
        {"the upper one outermost", 0, -10, -100, INT32_MAX, 10, {-90, INT32_MAX}},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        preop();
        r.value[ECT_402_V_POLARITY] = rows[i].polarity;
        r.value[ECT_402_V_HOME_OFFSET] = rows[i].offset;
        r.value[ECT_402_V_RANGE_MIN] = r.value[ECT_402_V_LIMIT_MIN] = rows[i].lower;
        r.value[ECT_402_V_RANGE_MAX] = r.value[ECT_402_V_LIMIT_MAX] = rows[i].upper;
        ect_402_drive_touched(&r.d);
        const ect_402_axis_t *a = &r.d.axis;
        bool on = rows[i].limit[0] < rows[i].limit[1];
        if (a->home_offset != rows[i].home || a->limit[0] != rows[i].limit[0] || a->limit[1] != rows[i].limit[1])
            fail_msg("%s: expected offset %d and limits %d, %d, got %d and %d, %d", rows[i].what, rows[i].home,
                     rows[i].limit[0], rows[i].limit[1], a->home_offset, a->limit[0], a->limit[1]);
        assert_int_equal(a->range[0], on ? rows[i].lower : 0);
        assert_int_equal(a->range[1], on ? rows[i].upper : 0);
    }
}

static void refused_pairs(void **unused)
{
    static const struct {
        const char *what;
        ect_402_value_t first;
        int32_t as;
        ect_402_value_t value;
        int64_t number;
        ect_reason_t reason;
    } rows[] = {
        {"607Dh:1 up to 607Dh:2", ECT_402_V_LIMIT_MAX, 100, ECT_402_V_LIMIT_MIN, 100, ECT_OK},
        {"607Dh:1 above 607Dh:2", ECT_402_V_LIMIT_MAX, 100, ECT_402_V_LIMIT_MIN, 101, ECT_REASON_MIN_MAX},
        {"607Dh:1 above 1", ECT_402_V_LIMIT_MAX, 1, ECT_402_V_LIMIT_MIN, 2, ECT_REASON_MIN_MAX},
        {"607Dh:2 was not written yet", ECT_402_V_LIMIT_MAX, 0, ECT_402_V_LIMIT_MIN, 101, ECT_OK},
        {"607Dh:2 down to 607Dh:1", ECT_402_V_LIMIT_MIN, 50, ECT_402_V_LIMIT_MAX, 50, ECT_OK},
        {"607Dh:2 below 607Dh:1", ECT_402_V_LIMIT_MIN, 50, ECT_402_V_LIMIT_MAX, 49, ECT_REASON_MIN_MAX},
        {"607Bh:1 above 607Bh:2", ECT_402_V_RANGE_MAX, 100, ECT_402_V_RANGE_MIN, 101, ECT_REASON_MIN_MAX},
        {"607Bh:2 below 607Bh:1", ECT_402_V_RANGE_MIN, 50, ECT_402_V_RANGE_MAX, 49, ECT_REASON_MIN_MAX},
        {"608Fh:1 is 0", ECT_402_V_POLARITY, 0, ECT_402_V_INCREMENTS, 0, ECT_REASON_RANGE},
        {"608Fh:1 is 1", ECT_402_V_POLARITY, 0, ECT_402_V_INCREMENTS, 1, ECT_OK},
        {"6091h:2 is below 0", ECT_402_V_POLARITY, 0, ECT_402_V_GEAR_SHAFT, -1, ECT_REASON_RANGE},
        {"6092h:2 is 0", ECT_402_V_POLARITY, 0, ECT_402_V_FEED_TURNS, 0, ECT_REASON_RANGE},
        {"60F2h", ECT_402_V_POLARITY, 0, ECT_402_V_POSITIONING, 0xC2, ECT_OK},
        {"60F2h, base 3", ECT_402_V_POLARITY, 0, ECT_402_V_POSITIONING, 3, ECT_REASON_RANGE},
        {"60F2h, bit 2", ECT_402_V_POLARITY, 0, ECT_402_V_POSITIONING, 4, ECT_REASON_RANGE},
        {"60F2h, bit 5", ECT_402_V_POLARITY, 0, ECT_402_V_POSITIONING, 0x20, ECT_REASON_RANGE},
        {"60F2h, bit 8", ECT_402_V_POLARITY, 0, ECT_402_V_POSITIONING, 0x100, ECT_REASON_RANGE},
        {"60C2h:1 is 0", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_UNITS, 0, ECT_REASON_RANGE},
        {"60C2h:1 is 1", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_UNITS, 1, ECT_OK},
        {"60C2h:1 is 255", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_UNITS, 255, ECT_OK},
        {"60C2h:1 is 256", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_UNITS, 256, ECT_REASON_RANGE},
        {"60C2h:2 is -6", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_POWER, -6, ECT_OK},
        {"60C2h:2 is -7", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_POWER, -7, ECT_REASON_RANGE},
        {"60C2h:2 is 0", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_POWER, 0, ECT_OK},
        {"60C2h:2 is 1", ECT_402_V_POLARITY, 0, ECT_402_V_CYCLE_POWER, 1, ECT_REASON_RANGE},
        {"1 us", ECT_402_V_CYCLE_UNITS, 1, ECT_402_V_CYCLE_POWER, -6, ECT_REASON_RANGE},
        {"1 ms", ECT_402_V_CYCLE_UNITS, 1, ECT_402_V_CYCLE_POWER, -3, ECT_OK},
        {"750 us, in units of 50", ECT_402_V_CYCLE_UNITS, 75, ECT_402_V_CYCLE_POWER, -5, ECT_OK},
        {"760 us", ECT_402_V_CYCLE_UNITS, 76, ECT_402_V_CYCLE_POWER, -5, ECT_REASON_RANGE},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        preop();
        r.value[rows[i].first] = rows[i].as;
        ect_402_drive_written(&r.d, rows[i].first, r.now_ns);
        ect_reason_t reason = ect_402_drive_check(&r.d, rows[i].value, rows[i].number);
        if (reason != rows[i].reason)
            fail_msg("%s: expected reason %d, got %d", rows[i].what, (int)rows[i].reason, (int)reason);
    }
}

static void refused_states(void **unused)
{
    (void)unused;
    preop();
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_CYCLE_UNITS, 1), ECT_OK);
    ect_402_drive_below_op(&r.d, ECT_STATE_SAFEOP);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_CYCLE_UNITS, 1), ECT_REASON_STATE);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_CYCLE_POWER, -3), ECT_REASON_STATE);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_HOME_METHOD, 35), ECT_OK);
    ect_402_drive_enter_op(&r.d, r.now_ns);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_CYCLE_UNITS, 1), ECT_REASON_STATE);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_FEED, 5), ECT_OK);
    enable();
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_FEED, 5), ECT_REASON_STATE);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_HOME_METHOD, 35), ECT_OK);
}

/* --- set values --------------------------------------------------------------------------------------------------- */

static void set_values(void **unused)
{
    enum { TURNED = 0x80, BACKWARDS = 0x40 };
    static const struct {
        const char *what;
        int32_t mode, polarity;
        int32_t position, speed;
        int16_t torque;
    } rows[] = {
        {"csp", ECT_402_CSP, 0, 1020, 50, 30},
        {"csp, 607Eh bit 7", ECT_402_CSP, TURNED, -1020, 50, 30},
        {"csv", ECT_402_CSV, 0, 1000, 57, 30},
        {"csv, 607Eh bit 6", ECT_402_CSV, BACKWARDS, 1000, -57, 30},
        {"cst", ECT_402_CST, 0, 1000, 50, 34},
        {"pv, 607Eh bit 6", ECT_402_PV, BACKWARDS, 1000, -50, 30},
        {"tq, 607Eh both", ECT_402_TQ, 0xC0, -1000, -50, 30},
        {"pp, 607Eh bit 7", ECT_402_PP, TURNED, -1000, 50, 30},
        {"ip", ECT_402_IP, 0, 900, 50, 30},
        {"ip, 607Eh bit 7", ECT_402_IP, TURNED, -900, 50, 30},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.value[ECT_402_V_MODE] = rows[i].mode;
        r.value[ECT_402_V_POLARITY] = rows[i].polarity;
        r.value[ECT_402_V_TARGET_POSITION] = 1000;
        r.value[ECT_402_V_POSITION_OFFSET] = 20;
        r.value[ECT_402_V_RECORD] = 900;
        r.value[ECT_402_V_TARGET_SPEED] = 50;
        r.value[ECT_402_V_SPEED_OFFSET] = 7;
        r.value[ECT_402_V_TARGET_TORQUE] = 30;
        r.value[ECT_402_V_TORQUE_OFFSET] = 4;
        ect_402_drive_touched(&r.d);
        ect_402_drive_outputs(&r.d, r.now_ns);
        const ect_402_set_t *set = &r.d.axis.set;
        if (set->position != rows[i].position || set->speed != rows[i].speed || set->torque != rows[i].torque)
            fail_msg("%s: expected %d, %d, %d, got %d, %d, %d", rows[i].what, rows[i].position, rows[i].speed,
                     rows[i].torque, set->position, set->speed, set->torque);
        assert_int_equal(set->ahead, 4);
        assert_int_equal(r.d.axis.target, (rows[i].polarity & TURNED) != 0 ? -1000 : 1000);
        r.value[ECT_402_V_TARGET_TORQUE] = -70000;
        r.value[ECT_402_V_TORQUE_OFFSET] = 70000;
        ect_402_drive_outputs(&r.d, r.now_ns);
        assert_int_equal(set->ahead, INT16_MAX);
        assert_int_equal(set->torque, rows[i].mode == ECT_402_CST ? 0 : -INT16_MAX);
    }
}

/* --- inputs, bits ------------------------------------------------------------------------------------------------- */

static void inputs_and_bits(void **unused)
{
    enum { VOLTAGE = 0x0010, WARNING = 0x0080, LIMIT = 0x0800, BITS = VOLTAGE | WARNING | LIMIT };
    static const struct {
        const char *what;
        uint8_t input[ECT_402_INPUTS]; /* probe, home, positive, negative */
        uint8_t power, enable, sto, warning;
        int32_t inputs;
        unsigned int bits;
    } rows[] = {
        {"none", {0, 0, 1, 1}, 1, 1, 0, 0, 0, VOLTAGE},
        {"probe", {1, 0, 1, 1}, 1, 1, 0, 0, 0x10000, VOLTAGE},
        {"home", {0, 1, 1, 1}, 1, 1, 0, 0, 0x20004, VOLTAGE},
        {"positive switch", {0, 0, 0, 1}, 1, 1, 0, 0, 2, VOLTAGE | LIMIT},
        {"negative switch", {0, 0, 1, 0}, 1, 1, 0, 0, 1, VOLTAGE | LIMIT},
        {"STO", {0, 0, 1, 1}, 1, 1, 1, 0, 8, VOLTAGE},
        {"no enable", {0, 0, 1, 1}, 1, 0, 0, 0, 8, VOLTAGE},
        {"no power", {0, 0, 1, 1}, 0, 1, 0, 0, 0, 0},
        {"a warning", {0, 0, 1, 1}, 1, 1, 0, 1, 0, VOLTAGE | WARNING},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        memcpy(r.around.machine.input, rows[i].input, sizeof rows[i].input);
        r.around.power = rows[i].power;
        r.around.enable = rows[i].enable;
        r.around.sto = rows[i].sto;
        r.around.warning = rows[i].warning;
        ect_402_drive_touched(&r.d);
        unsigned int bits = (unsigned int)r.value[ECT_402_V_STATUS] & BITS;
        if (r.value[ECT_402_V_INPUTS] != rows[i].inputs || bits != rows[i].bits)
            fail_msg("%s: expected 60FDh %X and bits %X, got %X and %X", rows[i].what, (unsigned int)rows[i].inputs,
                     rows[i].bits, (unsigned int)r.value[ECT_402_V_INPUTS], bits);
        assert_int_equal(r.value[ECT_402_V_DC_LINK], rows[i].power ? 325000 : 0);
    }
}

/* 608Fh twice as fine: the machine has the same shape, in twice the units. */
static void finer_units(void **unused)
{
    (void)unused;
    preop();
    ect_402_plant_t *m = &r.around.machine;
    m->position = 1000.5;
    m->mark[ECT_402_PROBE] = (ect_402_mark_t){100, 10};
    m->mark[ECT_402_HOME] = (ect_402_mark_t){-200, 20};
    m->stop_positive.at = 5000;
    m->index_at = 70;
    r.d.axis.zero = 30;
    r.value[ECT_402_V_INCREMENTS] = 2097152;
    r.value[ECT_402_V_INCREMENT_TURNS] = 1;
    ect_402_drive_touched(&r.d);
    assert_true(m->position > 2000.99 && m->position < 2001.01);
    assert_int_equal(m->mark[ECT_402_PROBE].at, 200);
    assert_int_equal(m->mark[ECT_402_PROBE].width, 20);
    assert_int_equal(m->mark[ECT_402_HOME].at, -400);
    assert_int_equal(m->mark[ECT_402_HOME].width, 40);
    assert_int_equal(m->stop_positive.at, 10000);
    assert_int_equal(m->stop_negative.at, INT32_MIN); /* none */
    assert_int_equal(m->index_at, 140);
    assert_int_equal((int)r.d.axis.zero, 60);
    assert_int_equal(r.value[ECT_402_V_POSITION], 1941);
    assert_int_equal(r.value[ECT_402_V_INTERNAL], 1941);
}

static void by_mailbox_below_op(void **unused)
{
    static const struct {
        int32_t word;
        unsigned int state;
        bool fault;
    } rows[] = {
        {0x80, 0x08, true}, /* the first word has no edge */
        {0x00, 0x08, false}, {0x80, 0x40, false}, {0x06, 0x21, false}, {0x0F, 0x21, false},
        {0x00, 0x40, false}, {0x80, 0x40, false}, {0x80, 0x08, true}, /* bit 7 without an edge */
        {0x00, 0x08, false}, {0x8F, 0x40, false},                     /* its other bits do not count */
    };
    (void)unused;
    preop();
    for (size_t i = 0; i < COUNT(rows); i++) {
        if (rows[i].fault)
            ect_402_drive_fault(&r.d, 0x7300);
        r.value[ECT_402_V_CONTROL] = rows[i].word;
        ect_402_drive_written(&r.d, ECT_402_V_CONTROL, r.now_ns);
        r.now_ns += 2 * MS;
        ect_402_drive_advance(&r.d, r.now_ns);
        ect_402_drive_publish(&r.d);
        if (state() != rows[i].state)
            fail_msg("DRV-154, word %zu, %02X: expected state %02X, got %02X", i, (unsigned int)rows[i].word,
                     rows[i].state, state());
    }
}

/* --- touch probes ------------------------------------------------------------------------------------------------- */

static void probes(void **unused)
{
    static const ect_402_value_t counts[][2] = {{ECT_402_V_PROBE_1_POSITIVES, ECT_402_V_PROBE_1_NEGATIVES},
                                                {ECT_402_V_PROBE_2_POSITIVES, ECT_402_V_PROBE_2_NEGATIVES}};
    static const uint8_t lines[] = {ECT_402_PROBE, ECT_402_HOME};
    static const struct {
        const char *what;
        uint8_t function, input, status;
        int32_t positives, negatives;
    } rows[] = {
        {"both edges, once", 0x31, 0, 0x01, 0, 0},
        {"the positive one", 0x31, 1, 0x03, 1, 0},
        {"the negative one", 0x31, 0, 0x07, 1, 1},
        {"no second positive one", 0x31, 1, 0x07, 1, 1},
        {"no second negative one", 0x31, 0, 0x07, 1, 1},
        {"bit 4 falls", 0x21, 0, 0x07, 1, 1},
        {"bit 4 is 0", 0x21, 1, 0x07, 1, 1},
        {"bit 4 is 0, the input falls", 0x21, 0, 0x07, 1, 1},
        {"bit 4 rises", 0x31, 0, 0x07, 1, 1},
        {"another positive one", 0x31, 1, 0x07, 2, 1},
        {"no negative one", 0x31, 0, 0x07, 2, 1},
        {"off", 0x30, 0, 0x00, 2, 1},
        {"off, the input rises", 0x30, 1, 0x00, 2, 1},
        {"off, the input falls", 0x30, 0, 0x00, 2, 1},
        {"all edges", 0x33, 0, 0x01, 2, 1},
        {"bit 6 toggles", 0x33, 1, 0x43, 3, 1},
        {"bit 7 toggles", 0x33, 0, 0xC7, 3, 2},
        {"bit 6 toggles again", 0x33, 1, 0x87, 4, 2},
        {"bit 7 toggles again", 0x33, 0, 0x07, 4, 3},
        {"no edge is wanted", 0x03, 0, 0x07, 4, 3},
        {"no edge is wanted, the input rises", 0x03, 1, 0x07, 4, 3},
        {"off again", 0x00, 1, 0x00, 4, 3},
        {"source 3 is none", 0x3F, 0, 0x01, 4, 3},
        {"source 3 is none, the input rises", 0x3F, 1, 0x01, 4, 3},
    };
    (void)unused;
    for (unsigned int n = 0; n < ECT_402_PROBES; n++) {
        prepare();
        power_on();
        for (size_t i = 0; i < COUNT(rows); i++) {
            r.value[ECT_402_V_PROBE] = rows[i].function << (8 * n);
            r.around.machine.input[lines[n]] = rows[i].input;
            ect_402_drive_touched(&r.d);
            int32_t status = r.value[ECT_402_V_PROBE_STATUS];
            int32_t up = r.value[counts[n][0]];
            int32_t down = r.value[counts[n][1]];
            if (status != rows[i].status << (8 * n) || up != rows[i].positives || down != rows[i].negatives)
                fail_msg("probe %u, %s: expected 60B9h %02X, %d and %d edges, got %04X, %d and %d", n + 1, rows[i].what,
                         rows[i].status, rows[i].positives, rows[i].negatives, (unsigned int)status, up, down);
        }
    }
}

/* --- faults ------------------------------------------------------------------------------------------------------- */

static void fault_by_hand(void **unused)
{
    static const char *const states[] = {
        "not ready to switch on", "switch on disabled", "ready to switch on",    "switched on",
        "operation enabled",      "quick stop active",  "fault reaction active", "fault"};
    const uint16_t code = 0x7300;
    unsigned int written = 0;
    char text[64];
    (void)unused;
    prepare();
    power_on();
    for (uint16_t i = 0; i < ect_402_drive_signal_count; i++) {
        const ect_signal_t *signal = &ect_402_drive_signals[i];
        const char *reply = ect_402_drive_signal_write(&r.d, signal, &code);
        assert_int_equal(reply != NULL, strcmp(signal->name, "fault") == 0);
        written += reply != NULL;
    }
    assert_int_equal(written, 1);
    assert_int_equal(r.code, code);
    assert_int_equal(r.value[ECT_402_V_ERROR_CODE], code);
    assert_int_equal(state(), 0x08);
    for (size_t i = 0; i < COUNT(states); i++) {
        memset(text, 'x', sizeof text);
        ect_402_drive_signal_describe(&ect_402_drive_signals[0], (uint16_t)i, text);
        assert_string_equal(text, states[i]);
    }
}

/* A shaft that is stuck: 6065h and 6066h give 8611h; FFFFFFFFh is off. */
static void following_error(void **unused)
{
    (void)unused;
    for (unsigned int off = 0; off < 2; off++) {
        prepare();
        r.links[ECT_402_V_ERROR_WINDOW].is_signed = false;
        power_on();
        r.value[ECT_402_V_ERROR_WINDOW] = off ? -1 : 1000;
        ect_402_drive_touched(&r.d);
        enable();
        r.value[ECT_402_V_MODE] = ECT_402_CSP;
        cycle(5);
        r.around.machine.jam = 1;
        r.value[ECT_402_V_TARGET_POSITION] = 2000;
        cycle(100);
        assert_int_equal(r.value[ECT_402_V_FOLLOWING_ERROR], off ? 2000 : 0);
        assert_int_equal(r.code, off ? 0 : 0x8611);
        assert_int_equal(r.d.axis.error_window, off ? 0 : 1000);
    }
}

/* Edges of the control word count from the first one in OP. */
static void first_word_in_op(void **unused)
{
    (void)unused;
    preop();
    r.value[ECT_402_V_CONTROL] = 0;
    ect_402_drive_written(&r.d, ECT_402_V_CONTROL, r.now_ns);
    ect_402_drive_fault(&r.d, 0x7300);
    ect_402_drive_enter_op(&r.d, r.now_ns);
    control(0x80);
    assert_int_equal(state(), 0x08);
    control(0x00);
    control(0x80);
    assert_int_equal(state(), 0x40);
}

/* A rated torque of 0 is none: the default is 3 Nm. */
static void rated_torques(void **unused)
{
    static const struct {
        int32_t thousandths;
        double nm;
    } rows[] = {{5000, 5}, {0, 3}, {-1, 3}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        preop();
        r.value[ECT_402_V_RATED_TORQUE] = rows[i].thousandths;
        ect_402_drive_touched(&r.d);
        const ect_402_config_t *c = &r.d.config;
        if (fabs(c->rated_torque - rows[i].nm) > 1e-9 || fabs(c->peak_torque - 3 * rows[i].nm) > 1e-9 ||
            fabs(c->inertia - 1e-4 * rows[i].nm) > 1e-12)
            fail_msg("6076h %d: expected %f Nm, got %f Nm, %f Nm, %f kg m2", rows[i].thousandths, rows[i].nm,
                     c->rated_torque, c->peak_torque, c->inertia);
    }
}

/* Without a description by the user: 6076h of 6 Nm has a friction of 0.1 Nm. Known surroundings outlast a power cycle.
 */
static void first_surroundings(void **unused)
{
    (void)unused;
    prepare();
    r.value[ECT_402_V_RATED_TORQUE] = 6000;
    power_on();
    const ect_402_plant_t *m = &r.around.machine;
    assert_true(fabs(m->friction - 0.1) < 1e-12);
    assert_int_equal(m->brake_delay_ms, 30);
    assert_true(r.around.known && r.around.power == 1 && r.around.enable == 1 && r.around.sto == 0);
    assert_true(m->input[ECT_402_POSITIVE] == 1 && m->input[ECT_402_NEGATIVE] == 1);
    assert_true(m->input[ECT_402_PROBE] == 0 && m->input[ECT_402_HOME] == 0);
    assert_true(m->stop_negative.at == INT32_MIN && m->stop_positive.at == INT32_MAX);
    assert_true(m->stop_negative.fitted == 0 && m->stop_positive.fitted == 0);
    r.around.machine.friction = 2;
    r.around.machine.stop_negative.at = -70;
    r.around.power = 0;
    memset(&r.d, 0, sizeof r.d);
    power_on();
    assert_true(fabs(m->friction - 2) < 1e-12);
    assert_int_equal(r.around.power, 0);
    assert_true(m->stop_negative.fitted == 1 && m->stop_positive.fitted == 0);
}

static void by_write(void)
{
    ect_402_drive_written(&r.d, ECT_402_V_HOME_OFFSET, r.now_ns);
}

static void by_end_of_op(void)
{
    ect_402_drive_leave_op(&r.d, r.now_ns);
}

static void by_time(void)
{
    ect_402_drive_advance(&r.d, r.now_ns);
}

/* Each call with a time takes the steps up to it: 10 ms are 40, and a rest of a step waits. */
static void steps_before(void **unused)
{
    static void (*const calls[])(void) = {by_write, by_end_of_op, by_time};
    (void)unused;
    for (size_t i = 0; i < COUNT(calls); i++) {
        prepare();
        power_on();
        enable();
        uint64_t before = r.d.axis.time_ns;
        r.now_ns = before + 10 * MS + ECT_402_STEP_NS - 1;
        calls[i]();
        assert_true(r.d.axis.time_ns == before + 10 * MS);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"Numbers in entries of each width, with the nearest for one that does not fit", widths, NULL, NULL, NULL},
        {"Numbers in floating point are rounded", fractions, NULL, NULL, NULL},
        {"Entries without a number are not used", links, NULL, NULL, NULL},
        {"DRV-125 DRV-126 DRV-504: power-on leads to Switch on disabled, 06h alone leads on", power_up, NULL, NULL,
         NULL},
        {"DRV-155 DRV-156 DRV-175 DRV-515: the end of OP, by 6007h", loses_op, NULL, NULL, NULL},
        {"A loss of supply is a fault that is reset when the supply is back", loses_supply, NULL, NULL, NULL},
        {"Bits of the error register, by the code of the fault", error_registers, NULL, NULL, NULL},
        {"The cycle is that of 60C2h, or that of the outputs", cycle_times, NULL, NULL, NULL},
        {"With SYNC0 outputs come into force at the next one", sync0, NULL, NULL, NULL},
        {"Commands by SDO count in OP", by_mailbox, NULL, NULL, NULL},
        {"A drive at rest has no deadline", rests, NULL, NULL, NULL},
        {"Modes are those for which the objects exist", modes, NULL, NULL, NULL},
        {"DRV-002 DRV-006 DRV-007 DRV-009 DRV-010 defaults where the file has none", defaults, NULL, NULL, NULL},
        {"DRV-005 DRV-014 DRV-015 DRV-022 DRV-023 DRV-032 actual values of a motion", actual_values, NULL, NULL, NULL},
        {"DRV-047 DRV-048 DRV-064 profiles other than the linear ones are refused", refused_profiles, NULL, NULL, NULL},
        {"DRV-246 DRV-247: bit 10 within 606Dh of the target, bit 12 up to 606Fh", speed_windows, NULL, NULL, NULL},
        {"DRV-027 DRV-032: 6077h rises to 6072h and not beyond", most_torque, NULL, NULL, NULL},
        {"A jammed shaft does not move", jammed, NULL, NULL, NULL},
        {"DRV-041: 6080h limits the speed, from one turn a minute on", motor_speeds, NULL, NULL, NULL},
        {"DRV-519: speeds in turns a minute, and in tenths", speed_units, NULL, NULL, NULL},
        {"DRV-097 DRV-519: each setting has its effect in the axis", settings, NULL, NULL, NULL},
        {"DRV-036 DRV-037 DRV-038 DRV-231 DRV-235 DRV-237: limits and ranges by offset and polarity", ranges, NULL,
         NULL, NULL},
        {"DRV-096 DRV-223 DRV-263: pairs that cross, and values out of range", refused_pairs, NULL, NULL, NULL},
        {"DRV-263: units with torque, cycle times from SAFEOP on are refused", refused_states, NULL, NULL, NULL},
        {"DRV-026 DRV-035 DRV-058 DRV-080 DRV-231 DRV-256: set values by mode, offset and polarity", set_values, NULL,
         NULL, NULL},
        {"DRV-311: 60FDh and bits 4, 7 and 11, by input", inputs_and_bits, NULL, NULL, NULL},
        {"DRV-230: a finer unit does not change the machine", finer_units, NULL, NULL, NULL},
        {"DRV-004 DRV-154 DRV-151: control words by SDO below OP", by_mailbox_below_op, NULL, NULL, NULL},
        {"DRV-301 DRV-302 DRV-304 DRV-306 DRV-307: edges of probes, once and all", probes, NULL, NULL, NULL},
        {"A manual fault; the names of states", fault_by_hand, NULL, NULL, NULL},
        {"DRV-241: 8611h beyond 6065h, FFFFFFFFh is off", following_error, NULL, NULL, NULL},
        {"DRV-151: edges count from the first control word in OP", first_word_in_op, NULL, NULL, NULL},
        {"The machine at first power-on, and at the next", first_surroundings, NULL, NULL, NULL},
        {"Writes and the end of OP come after the steps up to them", steps_before, NULL, NULL, NULL},
        {"DRV-042: a default is at most what its entry holds", default_widths, NULL, NULL, NULL},
        {"DRV-030: the motor by its rated torque", rated_torques, NULL, NULL, NULL},
        {"Options, modes and methods that do not exist are refused", refused_values, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("CiA 402 over a dictionary", tests, NULL, NULL);
}
