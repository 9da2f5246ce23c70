/* SPDX-License-Identifier: MIT */
/* CF-D05 to CF-D09: the state machine with torque, stops, the loss of OP. */
#include "cases/drive_motion.h"

#include "cases/drive_cruise.h"

#define BRAKED 0.25 /* share of the speed that a ramp leaves at its end, measured over 10 ms */
#define FASTER 0.85 /* time of a stop with twice the deceleration, as a share, measured over 10 ms */
enum { SLACK_MS = 30, JUDGED_RAMP_MS = 100, PATIENCE_MS = 1000, NO_OPTION = -1, CODES = 7 };
enum { WATCHDOG_TICKS = 100, LONG_WATCHDOG_TICKS = 60000, EXPIRY_MS = 2000 };

static uint32_t longest_ms(const drive_t *d)
{
    return 4 * cruise_ramp_ms(d) + PATIENCE_MS;
}

/* Sets an option code. @return false: the axis refuses it */
static bool choose_option(drive_t *d, uint16_t index, int code)
{
    if (code == NO_OPTION)
        return true;
    const uint32_t abort = drive_set(d, index, 0, code);
    if (abort != 0)
        cf_remark(d->c, "axis %u refuses %d in %04Xh with abort 0x%08X", d->axis + 1, code, index, abort);
    return abort == 0;
}

/* --- CF-D05 ------------------------------------------------------------------------------------------------------- */

static void transitions(drive_t *d)
{
    const int8_t mode = cruise_mode(d);
    if (mode != 0)
        drive_choose(d, mode);
    drive_hold(d);
    drive_expect_stays(d, DRIVE_SWITCH_ON, DRIVE_DISABLED);
    drive_expect_stays(d, DRIVE_ENABLE, DRIVE_DISABLED);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_go(d, DRIVE_SWITCH_ON, DRIVE_SWITCHED_ON);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_go(d, DRIVE_SWITCH_ON, DRIVE_SWITCHED_ON);
    drive_go(d, 0, DRIVE_DISABLED);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_go(d, DRIVE_SWITCH_ON, DRIVE_SWITCHED_ON);
    drive_go(d, DRIVE_QUICK_STOP, DRIVE_DISABLED);
    drive_enable(d);
    cf_expect_bits(d->c, "status word (6041h): voltage enabled", DRIVE_VOLTAGE, DRIVE_VOLTAGE, drive_status(d));
    drive_go(d, DRIVE_SWITCH_ON, DRIVE_SWITCHED_ON);
    drive_hold(d);
    drive_go(d, DRIVE_ENABLE, DRIVE_ENABLED);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_enable(d);
    drive_go(d, 0, DRIVE_DISABLED);
}

void cf_drive_transitions(cf_t *c)
{
    drive_each_axis(c, transitions);
}

/* --- stops -------------------------------------------------------------------------------------------------------- */

static bool has_ramps(drive_t *d)
{
    return drive_has(d, DRIVE_DECELERATION, 0) && drive_has(d, DRIVE_QUICK_DECELERATION, 0);
}

/* The end of a ramp: a standstill, and torque up to it. Only a ramp of --move is long enough to be seen. */
static void expect_ramp(drive_t *d, const cruise_end_t *end, uint16_t index, int code)
{
    cf_expect_that(d->c, end->standstill_ms != UINT32_MAX,
                   "axis %u, stop by %04Xh: expected a standstill within %u ms, got a motion", d->axis + 1, index,
                   longest_ms(d));
    if (code == NO_OPTION || !has_ramps(d) || cruise_ramp_ms(d) < JUDGED_RAMP_MS)
        return;
    cf_expect_that(d->c, end->left_ms == UINT32_MAX || end->left_speed < BRAKED,
                   "axis %u, %d in %04Xh: expected torque until the standstill, got none at %.0f %% of the speed",
                   d->axis + 1, code, index, 100 * end->left_speed);
}

static void expect_at_once(const drive_t *d, const cruise_end_t *end, uint16_t index)
{
    const uint32_t most = cruise_ramp_ms(d) / 2 + SLACK_MS;
    cf_expect_that(d->c, end->left_ms <= most,
                   "axis %u, 0 in %04Xh: expected no torque within %u ms, got it for %u ms or longer", d->axis + 1,
                   index, most, end->left_ms == UINT32_MAX ? longest_ms(d) : end->left_ms);
}

/* A deceleration of twice the other one: only long ramps are compared, because a standstill is noticed after 10 ms. */
static void expect_faster(const drive_t *d, uint16_t index, uint32_t slow_ms, uint32_t fast_ms)
{
    if (slow_ms == 0 || fast_ms == 0 || cruise_ramp_ms(d) < JUDGED_RAMP_MS)
        return;
    cf_expect_that(d->c, fast_ms < FASTER * slow_ms,
                   "axis %u, 2 in %04Xh with 6085h twice 6084h: expected a stop in less than %.0f ms, got %u ms",
                   d->axis + 1, index, FASTER * slow_ms, fast_ms);
}

/* --- CF-D06 ------------------------------------------------------------------------------------------------------- */

static void expect_kept(drive_t *d)
{
    drive_cycles(d, DRIVE_SETTLE_MS);
    drive_expect_stays(d, DRIVE_QUICK_STOP, DRIVE_STOPPING);
    drive_expect_stays(d, DRIVE_SHUTDOWN, DRIVE_STOPPING);
    drive_hold(d);
    drive_command(d, DRIVE_ENABLE);
    if (!drive_wait(d, 0x6F, DRIVE_ENABLED, DRIVE_WAIT_MS))
        cf_warn(d->c, "axis %u lacks the optional transition 16, from Quick stop active to Operation enabled",
                d->axis + 1);
    drive_go(d, 0, DRIVE_DISABLED);
}

/* @return milliseconds to the standstill, 0: not measured */
static uint32_t quick_stop(drive_t *d, int code)
{
    const double speed = cruise_begin(d);
    cf_step(d->c, "axis %u: Quick stop (02h) in motion, 605Ah %d", d->axis + 1, code);
    drive_command(d, DRIVE_QUICK_STOP);
    const cruise_end_t end = cruise_watch(d, speed, longest_ms(d));
    if (code == 0)
        expect_at_once(d, &end, DRIVE_QUICK_OPTION);
    else
        expect_ramp(d, &end, DRIVE_QUICK_OPTION, code);
    if (code > 4)
        expect_kept(d);
    else if (code != NO_OPTION)
        drive_expect_state(d, DRIVE_DISABLED, DRIVE_WAIT_MS, "a finished quick stop");
    else if (drive_state(drive_status(d)) != DRIVE_STOPPING)
        drive_expect_state(d, DRIVE_DISABLED, DRIVE_WAIT_MS, "a finished quick stop without 605Ah");
    drive_go(d, 0, DRIVE_DISABLED);
    return end.standstill_ms;
}

/* Codes 3, 4, 7 and 8 brake with all of the torque, which can damage a machine. */
static void quick_stops(drive_t *d)
{
    static const int codes[] = {0, 1, 2, 5, 6};
    uint32_t ms[CODES] = {0};
    cruise_need(d);
    cruise_ramps(d);
    if (!drive_has(d, DRIVE_QUICK_OPTION, 0)) {
        (void)quick_stop(d, NO_OPTION);
        return;
    }
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++) {
        if (choose_option(d, DRIVE_QUICK_OPTION, codes[i]))
            ms[codes[i]] = quick_stop(d, codes[i]);
    }
    if (has_ramps(d)) {
        expect_faster(d, DRIVE_QUICK_OPTION, ms[1], ms[2]);
        expect_faster(d, DRIVE_QUICK_OPTION, ms[5], ms[6]);
    }
}

void cf_drive_quick_stop(cf_t *c)
{
    drive_each_axis(c, quick_stops);
}

/* --- CF-D07 ------------------------------------------------------------------------------------------------------- */

static void stop_by(drive_t *d, uint16_t index, int code)
{
    const bool shutdown = index == DRIVE_SHUTDOWN_OPTION;
    const double speed = cruise_begin(d);
    cf_step(d->c, "axis %u: %s in motion, %04Xh %d", d->axis + 1, shutdown ? "Shutdown" : "Disable operation", index,
            code);
    drive_command(d, shutdown ? DRIVE_SHUTDOWN : DRIVE_SWITCH_ON);
    const cruise_end_t end = cruise_watch(d, speed, longest_ms(d));
    if (code == 0)
        expect_at_once(d, &end, index);
    else if (code == 1)
        expect_ramp(d, &end, index, code);
    drive_expect_state(d, shutdown ? DRIVE_READY : DRIVE_SWITCHED_ON, DRIVE_WAIT_MS,
                       shutdown ? "Shutdown in motion" : "Disable operation in motion");
    drive_go(d, 0, DRIVE_DISABLED);
}

static void stops(drive_t *d)
{
    static const uint16_t indices[] = {DRIVE_SHUTDOWN_OPTION, DRIVE_DISABLE_OPTION};
    cruise_need(d);
    cruise_ramps(d);
    for (size_t i = 0; i < sizeof indices / sizeof indices[0]; i++) {
        if (!drive_has(d, indices[i], 0)) {
            stop_by(d, indices[i], NO_OPTION);
            continue;
        }
        for (int code = 0; code <= 1; code++) {
            if (choose_option(d, indices[i], code))
                stop_by(d, indices[i], code);
        }
    }
}

void cf_drive_stops(cf_t *c)
{
    drive_each_axis(c, stops);
}

/* --- CF-D08 ------------------------------------------------------------------------------------------------------- */

static void expect_motion(drive_t *d, double speed)
{
    const uint64_t until = cf_now_ns() + longest_ms(d) * UINT64_C(1000000);
    while (cruise_speed(d) / speed < 0.5 && cf_now_ns() < until)
        drive_cycle(d);
    cf_expect_that(d->c, cruise_speed(d) / speed >= 0.5,
                   "axis %u, halt taken back: expected the motion to continue, got %.0f %% of its speed", d->axis + 1,
                   100 * cruise_speed(d) / speed);
}

static uint32_t halt(drive_t *d, int code)
{
    const double speed = cruise_begin(d);
    const uint16_t control = cruise_mode(d) == DRIVE_PP ? DRIVE_ENABLE | DRIVE_START : DRIVE_ENABLE;
    cf_step(d->c, "axis %u: halt in motion, 605Dh %d", d->axis + 1, code);
    drive_command(d, control | DRIVE_HALT);
    const cruise_end_t end = cruise_watch(d, speed, longest_ms(d));
    expect_ramp(d, &end, DRIVE_HALT_OPTION, code);
    drive_expect_state(d, DRIVE_ENABLED, 0, "halt");
    cf_expect_that(d->c, drive_wait(d, DRIVE_REACHED, DRIVE_REACHED, PATIENCE_MS),
                   "axis %u, standstill by halt: expected bit 10 of 6041h within %d ms, got 0x%04X", d->axis + 1,
                   (int)PATIENCE_MS, drive_status(d));
    cf_step(d->c, "axis %u: halt taken back", d->axis + 1);
    drive_command(d, control);
    expect_motion(d, speed);
    drive_command(d, control | DRIVE_HALT);
    (void)cruise_watch(d, speed, longest_ms(d));
    drive_go(d, 0, DRIVE_DISABLED);
    return end.standstill_ms;
}

static void halts(drive_t *d)
{
    uint32_t ms[3] = {0};
    cruise_need(d);
    if (cruise_mode(d) == DRIVE_CSP || cruise_mode(d) == 0)
        cf_skip(d->c, "axis %u has neither pv nor pp, in which halt acts", d->axis + 1);
    cruise_ramps(d);
    if (!drive_has(d, DRIVE_HALT_OPTION, 0)) {
        (void)halt(d, NO_OPTION);
        return;
    }
    for (int code = 1; code <= 2; code++) {
        if (choose_option(d, DRIVE_HALT_OPTION, code))
            ms[code] = halt(d, code);
    }
    if (has_ramps(d))
        expect_faster(d, DRIVE_HALT_OPTION, ms[1], ms[2]);
}

void cf_drive_halt(cf_t *c)
{
    drive_each_axis(c, halts);
}

/* --- CF-D09 ------------------------------------------------------------------------------------------------------- */

/* The outputs stop until the watchdog has expired. @return false: the slave stays in OP */
static bool lose_op(drive_t *d)
{
    cf_t *c = d->c;
    cf_put16(c, ECT_REG_WD_TIME_PD, WATCHDOG_TICKS);
    drive_cycle(d);
    d->inputs_only = true;
    const uint64_t until = cf_now_ns() + EXPIRY_MS * UINT64_C(1000000);
    uint16_t status = CF_OP;
    while ((status & ECT_AL_STATE_MASK) == CF_OP && cf_now_ns() < until) {
        drive_cycle(d);
        status = cf_get16(c, ECT_REG_AL_STATUS);
    }
    return (status & ECT_AL_STATE_MASK) != CF_OP;
}

/* The fault reaction ends in SAFEOP, where the inputs go on. OP then begins with control word 0. */
static void back_to_op(drive_t *d)
{
    cf_t *c = d->c;
    d->inputs_only = false;
    cf_put16(c, ECT_REG_WD_TIME_PD, LONG_WATCHDOG_TICKS);
    (void)drive_set(d, DRIVE_CONTROL, 0, 0);
    cf_go(c, CF_OP);
    drive_cycles(d, DRIVE_SETTLE_MS);
}

/* @return whether the axis is in Fault, its reaction ended */
static bool wait_fault(drive_t *d)
{
    const uint64_t until = cf_now_ns() + longest_ms(d) * UINT64_C(1000000);
    drive_state_t state = drive_state(drive_status(d));
    while (state != DRIVE_FAULT && cf_now_ns() < until) {
        drive_cycle(d);
        state = drive_state(drive_status(d));
    }
    return state == DRIVE_FAULT;
}

/* An axis that raises no fault without process data has a reaction of its own, which CiA 402 allows by 6007h. */
static void provoke(drive_t *d)
{
    cf_step(d->c, "axis %u: no outputs until the watchdog ends OP", d->axis + 1);
    if (!lose_op(d))
        cf_skip(d->c, "the slave stays in OP without outputs: a master cannot cause a fault");
}

static void expect_reset(drive_t *d)
{
    const bool coded = drive_has(d, DRIVE_ERROR_CODE, 0);
    if (coded)
        cf_expect_that(d->c, (drive_get(d, DRIVE_ERROR_CODE, 0) & 0xFFFF) != 0,
                       "axis %u, error code (603Fh) in Fault: expected a code, got 0x0000", d->axis + 1);
    drive_expect_stays(d, 0, DRIVE_FAULT);
    drive_expect_stays(d, DRIVE_SHUTDOWN, DRIVE_FAULT);
    drive_expect_stays(d, DRIVE_SWITCH_ON, DRIVE_FAULT);
    drive_expect_stays(d, DRIVE_ENABLE, DRIVE_FAULT);
    drive_command(d, 0);
    drive_go(d, DRIVE_RESET, DRIVE_DISABLED);
    if (coded && (drive_get(d, DRIVE_ERROR_CODE, 0) & 0xFFFF) != 0)
        cf_warn(d->c, "axis %u, error code (603Fh) after the reset: 0 as a rule, got 0x%04X", d->axis + 1,
                (unsigned int)drive_get(d, DRIVE_ERROR_CODE, 0) & 0xFFFFu);
    drive_expect_stays(d, DRIVE_RESET, DRIVE_DISABLED);
    drive_go(d, 0, DRIVE_DISABLED);
}

/* The watchdog in a motion. @return false: the axis raises no fault */
static bool fault_in_motion(drive_t *d, int code)
{
    const double speed = cruise_begin(d);
    cf_remark(d->c, "axis %u: 605Eh %d", d->axis + 1, code);
    provoke(d);
    const cruise_end_t end = cruise_watch(d, speed, longest_ms(d));
    const bool fault = wait_fault(d);
    if (fault && code > 0)
        expect_ramp(d, &end, DRIVE_FAULT_OPTION, code);
    back_to_op(d);
    if (fault)
        expect_reset(d);
    else
        drive_go(d, 0, DRIVE_DISABLED);
    return fault;
}

/* At a standstill, for an axis whose travel cannot be limited. */
static bool fault_at_standstill(drive_t *d)
{
    drive_enable(d);
    provoke(d);
    const bool fault = wait_fault(d);
    back_to_op(d);
    if (fault)
        expect_reset(d);
    return fault;
}

static void faults(drive_t *d)
{
    const bool moves = d->guarded && cruise_mode(d) != 0;
    bool fault = true;
    cruise_ramps(d);
    if (drive_has(d, DRIVE_ABORT_OPTION, 0))
        (void)choose_option(d, DRIVE_ABORT_OPTION, 1);
    if (!moves) {
        fault = fault_at_standstill(d);
    } else if (!drive_has(d, DRIVE_FAULT_OPTION, 0)) {
        fault = fault_in_motion(d, NO_OPTION);
    } else {
        for (int code = 0; code <= 2 && fault; code++) {
            if (choose_option(d, DRIVE_FAULT_OPTION, code))
                fault = fault_in_motion(d, code);
        }
    }
    if (!fault)
        cf_skip(d->c, "axis %u raises no fault at the end of OP: a master cannot cause one", d->axis + 1);
}

void cf_drive_fault(cf_t *c)
{
    drive_each_axis(c, faults);
}
