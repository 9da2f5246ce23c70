/* SPDX-License-Identifier: MIT */
/* The choices that CiA 402-2 leaves to vendors: the twin's own, and the others by signals. A turn has 2^20 increments.
 */
#include "drive_rig.h"

enum { TURN = 1 << 20 };
enum { TARGET = 0x0400, ATTAINED = 0x1000, MODE_ERROR = 0x2000 };
enum { ENABLED = 0x0F, START = 0x1F };

static unsigned int bits(unsigned int mask)
{
    return (unsigned int)r.value[ECT_402_V_STATUS] & mask;
}

/* Choices are made before the drive is enabled. */
static void enable_in(int32_t mode)
{
    ect_402_drive_touched(&r.d);
    enable();
    r.value[ECT_402_V_TARGET_POSITION] = r.value[ECT_402_V_POSITION];
    r.value[ECT_402_V_MODE] = mode;
    cycle(2);
}

static double shaft(void)
{
    return r.around.machine.position;
}

/* --- reference runs ----------------------------------------------------------------------------------------------- */

static void home_offsets(void **unused)
{
    static const struct {
        uint8_t added, absolute;
        int32_t position, limit[2];
    } rows[] = {{0, 0, -500, {-1500, 500}}, {1, 0, 500, {-500, 1500}}, {0, 1, -500, {-1000, 1000}}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.around.choices.home_offset_added = rows[i].added;
        r.around.choices.limits_absolute = rows[i].absolute;
        r.value[ECT_402_V_HOME_OFFSET] = 500;
        r.value[ECT_402_V_HOME_METHOD] = 37;
        r.value[ECT_402_V_LIMIT_MIN] = -1000;
        r.value[ECT_402_V_LIMIT_MAX] = 1000;
        enable_in(ECT_402_HM);
        control(START);
        cycle(50);
        assert_int_equal(r.value[ECT_402_V_POSITION], rows[i].position);
        assert_int_equal(r.d.axis.limit[0], rows[i].limit[0]);
        assert_int_equal(r.d.axis.limit[1], rows[i].limit[1]);
    }
}

/* Bit 4 is 1 at the entry of homing mode, falls and rises. */
static void start_of_homing(void **unused)
{
    static const struct {
        uint8_t by_level;
        bool at_entry;
    } rows[] = {{0, false}, {1, true}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.around.choices.homing_by_level = rows[i].by_level;
        r.value[ECT_402_V_HOME_METHOD] = 37;
        enable_in(ECT_402_CSP);
        control(START);
        r.value[ECT_402_V_MODE] = ECT_402_HM;
        cycle(50);
        assert_int_equal(r.d.axis.homed, rows[i].at_entry);
        uint32_t steps = r.d.axis.homing.steps;
        cycle(50);
        assert_int_equal(r.d.axis.homing.steps, steps); /* no second run */
        control(ENABLED);
        control(START);
        cycle(50);
        assert_true(r.d.axis.homed);
    }
}

/* Method 34: the index pulse is half a turn away, and is passed at 524 288 increments a second. */
static void end_of_homing(void **unused)
{
    (void)unused;
    for (uint8_t stays = 0; stays < 2; stays++) {
        prepare();
        power_on();
        r.around.choices.home_stays = stays;
        r.around.machine.index_at = TURN / 2;
        r.value[ECT_402_V_HOME_METHOD] = 34;
        enable_in(ECT_402_HM);
        control(START);
        for (unsigned int ms = 0; ms < 20000 && bits(TARGET) == 0; ms++) /* friction: the last counts take seconds */
            cycle(1);
        assert_int_equal(bits(TARGET | ATTAINED | MODE_ERROR), TARGET | ATTAINED);
        double beyond = shaft() - TURN / 2;
        if (stays ? beyond < 1000 : fabs(beyond) > 2)
            fail_msg("DRV-517, home_stays %u: the shaft lies %f behind home", stays, beyond);
        assert_true(fabs(r.value[ECT_402_V_POSITION] - beyond) <= 2);
    }
}

/* --- following error ---------------------------------------------------------------------------------------------- */

/* A shaft that is stuck 2000 increments short. */
static void following_errors(void **unused)
{
    static const struct {
        const char *what;
        uint8_t zero, warns;
        int32_t window;
        uint16_t code;
        bool bit13;
    } rows[] = {
        {"DRV-506 a fault", 0, 0, 1000, 0x8611, true},
        {"DRV-506 a warning", 0, 1, 1000, 0, true},
        {"DRV-505 6065h 0 is none", 0, 0, 0, 0, false},
        {"DRV-505 6065h 0 is a window", 1, 0, 0, 0x8611, true},
        {"DRV-505 FFFFFFFFh is none", 1, 0, -1, 0, false},
        {"DRV-505 a window that is wide enough", 1, 0, 3000, 0, false},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        r.links[ECT_402_V_ERROR_WINDOW].is_signed = false;
        r.links[ECT_402_V_ERROR_WINDOW].given = true;
        power_on();
        r.around.choices.following_zero = rows[i].zero;
        r.around.choices.following_warns = rows[i].warns;
        r.value[ECT_402_V_ERROR_WINDOW] = rows[i].window;
        enable_in(ECT_402_CSP);
        r.around.machine.jam = 1;
        r.value[ECT_402_V_TARGET_POSITION] = 2000;
        bool bit13 = false;
        for (unsigned int ms = 0; ms < 100; ms++) {
            cycle(1);
            bit13 = bit13 || bits(MODE_ERROR) != 0;
        }
        if (r.d.error_code != rows[i].code || (rows[i].code == 0 && bit13 != rows[i].bit13))
            fail_msg("%s: expected code %04X and bit 13 %d, got %04X and %d", rows[i].what, rows[i].code, rows[i].bit13,
                     r.d.error_code, bit13);
    }
}

/* --- Switched on -------------------------------------------------------------------------------------------------- */

/* A load of 1 Nm turns a shaft without torque. */
static void switched_on(void **unused)
{
    (void)unused;
    for (uint8_t holds = 0; holds < 2; holds++) {
        prepare();
        power_on();
        r.around.choices.switched_on_holds = holds;
        ect_402_drive_touched(&r.d);
        control(0x06);
        control(0x07);
        assert_int_equal(state(), 0x23);
        r.around.machine.load = 1;
        cycle(100);
        assert_int_equal(r.d.powered, holds);
        assert_int_equal(fabs(shaft()) < 1000, holds);
        assert_int_equal(state(), 0x23);
    }
}

/* --- bits 10 and 12 of csp ---------------------------------------------------------------------------------------- */

static void cyclic_bits(void **unused)
{
    static const struct {
        const char *what;
        uint8_t bit10, bit12;
        unsigned int standing, moving, ready; /* in its window, outside, without torque */
        bool toggles;
    } rows[] = {
        {"DRV-510 DRV-511 the twin's own", 0, 0, ATTAINED, ATTAINED, 0, false},
        {"DRV-510 in the window", 1, 0, TARGET | ATTAINED, ATTAINED, TARGET, false},
        {"DRV-510 toggles", 2, 0, ATTAINED, ATTAINED, 0, true},
        {"DRV-511 one", 0, 1, ATTAINED, ATTAINED, ATTAINED, false},
        {"DRV-511 zero", 0, 2, 0, 0, 0, false},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.around.choices.csp_bit10 = rows[i].bit10;
        r.around.choices.csp_bit12 = rows[i].bit12;
        enable_in(ECT_402_CSP);
        cycle(50);
        unsigned int mask = TARGET | ATTAINED;
        unsigned int changes = 0;
        for (unsigned int n = 0; n < 10; n++) {
            unsigned int before = bits(TARGET);
            cycle(1);
            changes += bits(TARGET) != before;
        }
        assert_int_equal(changes, rows[i].toggles ? 10 : 0);
        if (rows[i].toggles)
            mask = ATTAINED;
        unsigned int standing = bits(mask);
        r.value[ECT_402_V_TARGET_POSITION] += TURN / 4;
        cycle(3);
        unsigned int moving = bits(mask);
        cycle(500);
        control(0x06);
        cycle(50);
        if (standing != rows[i].standing || moving != rows[i].moving || bits(mask) != rows[i].ready)
            fail_msg("%s: expected %04X, %04X, %04X, got %04X, %04X, %04X", rows[i].what, rows[i].standing,
                     rows[i].moving, rows[i].ready, standing, moving, bits(mask));
    }
}

/* --- limit switches ----------------------------------------------------------------------------------------------- */

static void limit_switches(void **unused)
{
    (void)unused;
    for (uint8_t faults = 0; faults < 2; faults++) {
        prepare();
        power_on();
        r.around.choices.switch_faults = faults;
        r.around.machine.stop_positive.at = TURN;
        enable_in(ECT_402_CSV);
        r.value[ECT_402_V_TARGET_SPEED] = 4 * TURN;
        cycle(1000);
        assert_int_equal(r.d.error_code, faults ? 0x8612 : 0);
        assert_int_equal(state() & 0x08, faults ? 0x08 : 0);
        double stopped = shaft();
        assert_true(stopped >= TURN && stopped < 1.2 * TURN);
        r.value[ECT_402_V_TARGET_SPEED] = 0;
        control(0x00);
        control(0x80);
        enable(); /* in the switch */
        r.value[ECT_402_V_TARGET_SPEED] = -TURN;
        cycle(500);
        assert_int_equal(r.d.error_code, 0);
        assert_true(shaft() < stopped - TURN / 4);
    }
}

/* --- set-points --------------------------------------------------------------------------------------------------- */

/* Two set-points, the second one back to the start. */
static void buffers(void **unused)
{
    (void)unused;
    for (uint8_t none = 0; none < 2; none++) {
        prepare();
        power_on();
        r.around.choices.no_buffer = none;
        enable_in(ECT_402_PP);
        r.value[ECT_402_V_TARGET_POSITION] = 10 * TURN;
        control(START);
        cycle(300);
        control(ENABLED);
        r.value[ECT_402_V_TARGET_POSITION] = 0;
        control(START);
        control(ENABLED);
        assert_int_equal(bits(ATTAINED), none ? 0 : ATTAINED); /* room for another */
        double farthest = 0;
        for (unsigned int ms = 0; ms < 4000; ms++) {
            cycle(1);
            farthest = shaft() > farthest ? shaft() : farthest;
        }
        if (none ? farthest > 5 * TURN : farthest < 9.9 * TURN)
            fail_msg("DRV-524, no_buffer %u: the shaft went to %f turns", none, farthest / TURN);
        assert_true(fabs(shaft()) < 10);
    }
}

/* --- modes -------------------------------------------------------------------------------------------------------- */

static void mode_zero(void **unused)
{
    (void)unused;
    for (uint8_t ends = 0; ends < 2; ends++) {
        prepare();
        power_on();
        r.around.choices.mode_zero = ends;
        enable_in(ECT_402_CSV);
        r.value[ECT_402_V_TARGET_SPEED] = TURN;
        cycle(100);
        r.value[ECT_402_V_MODE] = 0;
        cycle(500);
        assert_int_equal(r.value[ECT_402_V_MODE_DISPLAY], ends ? 0 : ECT_402_CSV);
        assert_int_equal(r.value[ECT_402_V_SPEED] > TURN / 2, !ends);
        assert_int_equal(state(), 0x27);
    }
}

/* From csv to csp: at speed, at a standstill, below Operation enabled. */
static void mode_changes(void **unused)
{
    static const struct {
        uint8_t change;
        int32_t moving, standing, off;
    } rows[] = {{ECT_402_CHANGE_ANY, ECT_402_CSP, ECT_402_CSP, ECT_402_CSP},
                {ECT_402_CHANGE_STANDING, ECT_402_CSV, ECT_402_CSP, ECT_402_CSP},
                {ECT_402_CHANGE_NONE, ECT_402_CSV, ECT_402_CSV, ECT_402_CSP}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        r.links[ECT_402_V_ERROR_WINDOW].bytes = 0;
        power_on();
        r.around.choices.mode_change = rows[i].change;
        enable_in(ECT_402_CSV);
        r.value[ECT_402_V_TARGET_SPEED] = TURN;
        cycle(100);
        r.value[ECT_402_V_MODE] = ECT_402_CSP;
        r.value[ECT_402_V_TARGET_POSITION] = r.value[ECT_402_V_POSITION];
        cycle(2);
        assert_int_equal(r.value[ECT_402_V_MODE_DISPLAY], rows[i].moving);
        r.value[ECT_402_V_TARGET_SPEED] = 0;
        cycle(200);
        assert_int_equal(r.value[ECT_402_V_MODE_DISPLAY], rows[i].standing);
        control(0x06);
        cycle(2);
        assert_int_equal(r.value[ECT_402_V_MODE_DISPLAY], rows[i].off);
    }
}

/* --- fault reset -------------------------------------------------------------------------------------------------- */

static void resets(void **unused)
{
    static const struct {
        uint8_t needs_zero;
        int32_t word;
        unsigned int state;
    } rows[] = {{0, 0x8F, 0x40}, {0, 0x80, 0x40}, {1, 0x8F, 0x08}, {1, 0x81, 0x08}, {1, 0x80, 0x40}, {1, 0xF0, 0x40}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.around.choices.reset_needs_zero = rows[i].needs_zero;
        control(0x00);
        ect_402_drive_fault(&r.d, 0x7300);
        control(0x0F);
        assert_int_equal(state() & 0x4F, 0x08);
        control(rows[i].word);
        if ((state() & 0x4F) != rows[i].state)
            fail_msg("DRV-530, reset_needs_zero %u, %02X: expected state %02X, got %02X", rows[i].needs_zero,
                     (unsigned int)rows[i].word, rows[i].state, state());
    }
}

/* --- 60C2h -------------------------------------------------------------------------------------------------------- */

static struct {
    unsigned int count;
    uint8_t state;
    uint16_t code;
} dropped;

static void drop(void *ctx, uint8_t to, uint16_t code)
{
    (void)ctx;
    dropped.count++;
    dropped.state = to;
    dropped.code = code;
    ect_402_drive_leave_op(&r.d, r.now_ns);
}

/* 100 cycles. @return the error code at their end */
static uint16_t run_at(uint64_t cycle_ns, bool sync0, unsigned int lost)
{
    for (unsigned int n = 0; n < 100 && dropped.count == 0; n++) {
        r.now_ns += cycle_ns;
        bool frame = lost == 0 || n % lost != 0;
        if (frame)
            ect_402_drive_outputs(&r.d, r.now_ns);
        if (sync0)
            ect_402_drive_sync0(&r.d, r.now_ns);
        ect_402_drive_advance(&r.d, r.now_ns);
        ect_402_drive_publish(&r.d);
    }
    return r.d.error_code;
}

static void wrong_cycles(void **unused)
{
    static const struct {
        const char *what;
        uint8_t check;
        bool written, sync0;
        int32_t mode;
        unsigned int lost; /* each nth frame */
        uint64_t cycle_us;
        uint16_t code;
    } rows[] = {
        {"as 60C2h", 1, true, true, ECT_402_CSP, 0, 2000, 0},
        {"as 60C2h, without SYNC0", 1, true, false, ECT_402_CSP, 0, 2000, 0},
        {"a little off", 1, true, false, ECT_402_CSP, 0, 2250, 0},
        {"lost frames", 1, true, false, ECT_402_CSP, 5, 2000, 0},
        {"another SYNC0", 1, true, true, ECT_402_CSP, 0, 1000, 0x8700},
        {"frames of another cycle", 1, true, false, ECT_402_CSP, 0, 4000, 0x8700},
        {"60C2h of the file", 1, false, false, ECT_402_CSP, 0, 4000, 0},
        {"a mode without 60C2h", 1, true, false, ECT_402_PV, 0, 4000, 0},
        {"without the check", 0, true, true, ECT_402_CSP, 0, 1000, 0},
    };
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        memset(&dropped, 0, sizeof dropped);
        r.host.drop = drop;
        ect_402_drive_init(&r.d, r.links, &r.around, r.value, &r.host, r.now_ns);
        r.value[ECT_402_V_CYCLE_UNITS] = 2;
        r.value[ECT_402_V_CYCLE_POWER] = -3;
        if (rows[i].written)
            ect_402_drive_written(&r.d, ECT_402_V_CYCLE_UNITS, r.now_ns);
        r.around.choices.sync_check = rows[i].check;
        ect_402_drive_enter_op(&r.d, r.now_ns);
        r.value[ECT_402_V_MODE] = rows[i].mode;
        const uint16_t code = run_at(rows[i].cycle_us * 1000, rows[i].sync0, rows[i].lost);
        if (code != rows[i].code || dropped.count != (rows[i].code != 0))
            fail_msg("%s: expected %04X, got %04X and %u ends of OP", rows[i].what, rows[i].code, code, dropped.count);
        if (code != 0)
            assert_true(dropped.state == ECT_STATE_SAFEOP && dropped.code == 0x001A);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"DRV-501 DRV-521: the sign of 607Ch, with 607Dh and without", home_offsets, NULL, NULL, NULL},
        {"DRV-516: a run starts by the edge of bit 4, or by its level", start_of_homing, NULL, NULL, NULL},
        {"DRV-517: the shaft returns to home, or stays", end_of_homing, NULL, NULL, NULL},
        {"DRV-505 DRV-506: 6065h of 0, and a following error that warns", following_errors, NULL, NULL, NULL},
        {"DRV-509: Switched on has no torque, or holds", switched_on, NULL, NULL, NULL},
        {"DRV-510 DRV-511: bits 10 and 12 in csp", cyclic_bits, NULL, NULL, NULL},
        {"DRV-523: a limit switch stops the shaft, or is fault 8612h", limit_switches, NULL, NULL, NULL},
        {"DRV-524: a second set-point waits, or counts at once", buffers, NULL, NULL, NULL},
        {"DRV-528: 6060h of 0 keeps the mode, or ends it", mode_zero, NULL, NULL, NULL},
        {"DRV-529: a mode changes at any time, at a standstill, or below Operation enabled", mode_changes, NULL, NULL,
         NULL},
        {"DRV-530: bits 0 to 3 during the reset of a fault", resets, NULL, NULL, NULL},
        {"DRV-159: 60C2h unequal to the cycle causes fault 8700h and the end of OP", wrong_cycles, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("CiA 402 choices of vendors", tests, NULL, NULL);
}
