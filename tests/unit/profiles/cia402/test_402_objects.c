/* SPDX-License-Identifier: MIT */
/* Objects that few drives have: 60DAh, 60E3h, slippage; the way of the torque in tq. */
#include "drive_rig.h"

enum { TURN = 1 << 20, MODE_ERROR = 0x2000, HALT = 0x010F, ENABLED = 0x0F };

static void sync_functions(void **unused)
{
    (void)unused;
    preop();
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_SYNC_FUNCTIONS, 0), ECT_OK);
    assert_int_equal(ect_402_drive_check(&r.d, ECT_402_V_SYNC_FUNCTIONS, 1), ECT_REASON_RANGE);
}

/* A stuck shaft at a demand of one turn a second. */
static void slippage(void **unused)
{
    static const struct {
        int32_t slippage, mode;
        uint8_t jam;
        bool slips;
    } rows[] = {{TURN / 2, ECT_402_PV, 1, true},
                {TURN / 2, ECT_402_PV, 0, false},
                {2 * TURN, ECT_402_PV, 1, false},
                {0, ECT_402_PV, 1, false},
                {TURN / 2, ECT_402_CSV, 1, false}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        power_on();
        r.value[ECT_402_V_MAX_SLIPPAGE] = rows[i].slippage;
        r.around.machine.jam = rows[i].jam;
        ect_402_drive_touched(&r.d);
        enable();
        r.value[ECT_402_V_MODE] = rows[i].mode;
        r.value[ECT_402_V_TARGET_SPEED] = TURN;
        cycle(200);
        const bool slips = (r.value[ECT_402_V_STATUS] & MODE_ERROR) != 0;
        if (slips != rows[i].slips || r.d.error_code != 0)
            fail_msg("row %u: expected bit 13 %d, got %d, fault %04X", (unsigned int)i, rows[i].slips, slips,
                     r.d.error_code);
    }
}

/* 500 per mille, falling by 1000 per mille per second: half remains after 250 ms. The shaft is not braked. */
static void releases(void **unused)
{
    static const struct {
        int32_t word;
        unsigned int state;
        bool powered;
    } rows[] = {{HALT, 0x27, true}, {0x07, 0x23, false}};
    (void)unused;
    for (size_t i = 0; i < COUNT(rows); i++) {
        prepare();
        r.links[ECT_402_V_TORQUE_SLOPE].given = true;
        power_on();
        r.around.machine.load_inertia = 1000;
        r.value[ECT_402_V_TORQUE_SLOPE] = 1000;
        ect_402_drive_touched(&r.d);
        enable();
        r.value[ECT_402_V_MODE] = ECT_402_TQ;
        r.value[ECT_402_V_TARGET_TORQUE] = 500;
        cycle(600);
        assert_in_range(r.value[ECT_402_V_TORQUE], 499, 501);
        const int32_t speed = r.value[ECT_402_V_SPEED];
        r.value[ECT_402_V_CONTROL] = rows[i].word;
        cycle(250);
        assert_in_range(r.value[ECT_402_V_TORQUE], 240, 260);
        assert_in_range(r.value[ECT_402_V_TORQUE_DEMAND], 240, 260);
        assert_int_equal(state(), 0x27);
        cycle(300);
        assert_int_equal(r.value[ECT_402_V_TORQUE], 0);
        assert_int_equal(state(), rows[i].state);
        assert_int_equal(r.d.powered, rows[i].powered);
        assert_true(r.value[ECT_402_V_SPEED] > speed); /* it turns on, faster than before */
        assert_int_equal(r.d.error_code, 0);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"DRV-070: 60DAh takes 0 alone", sync_functions, NULL, NULL, NULL},
        {"DRV-075: 60F8h bounds the slippage in pv, by bit 13", slippage, NULL, NULL, NULL},
        {"DRV-251: halt and disable take the torque of tq on 6087h, without a brake", releases, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("CiA 402 objects of few drives", tests, NULL, NULL);
}
