/* SPDX-License-Identifier: MIT */
/* L. Drives of CiA 402, without torque: states, transitions 2 and 7, modes, option codes. */
#include "cases/drive_motion.h"
#include "cases/drive_steps.h"

enum { DEVICE_TYPE = 0x1000, PROFILE = 402, MODE_BITS = 16, LAST_MODE = 11, RESERVED_OPTION = 100, LIMIT_MS = 180000 };

/* --- CF-D01 ------------------------------------------------------------------------------------------------------- */

static void expect_no_power(drive_t *d)
{
    const uint16_t status = drive_status(d);
    const drive_state_t state = drive_state(status);
    cf_expect_that(
        d->c, state == DRIVE_NOT_READY || state == DRIVE_DISABLED || state == DRIVE_FAULT || state == DRIVE_REACTION,
        "axis %u, control word 0: expected a state without torque, got %s (6041h 0x%04X)", d->axis + 1,
        drive_state_name(state), status);
}

/* The object that a mode of 6502h needs. */
static uint16_t object_of_mode(unsigned int mode)
{
    switch (mode) {
    case 1:
    case 8:
        return DRIVE_TARGET;
    case 3:
    case 9:
        return DRIVE_TARGET_SPEED;
    case 4:
    case 10:
        return DRIVE_TARGET_TORQUE;
    case 6:
        return DRIVE_HOMING_METHOD;
    default:
        return 0;
    }
}

static void expect_objects(drive_t *d)
{
    if (!drive_has(d, DRIVE_MODES, 0))
        return;
    const uint64_t modes = (uint64_t)drive_get(d, DRIVE_MODES, 0);
    for (unsigned int mode = 1; mode <= MODE_BITS; mode++) {
        const uint16_t index = object_of_mode(mode);
        if ((modes >> (mode - 1) & 1u) != 0 && index != 0)
            cf_expect_that(d->c, drive_has(d, index, 0) || drive_has(d, index, 1),
                           "axis %u: mode %u of 6502h needs %04Xh: expected the object, got none", d->axis + 1, mode,
                           index);
    }
}

static void check_axis(drive_t *d)
{
    expect_no_power(d);
    expect_objects(d);
}

static void described(cf_t *c)
{
    drive_t *d = drive_open(c);
    const uint32_t type = (uint32_t)cf_upload_number(c, DEVICE_TYPE, 0);
    if ((type & 0xFFFF) != PROFILE)
        cf_warn(c, "device type (1000h): expected profile %d in the lower word, got %u", PROFILE, type & 0xFFFF);
    cf_step(c, "PREOP");
    for (d->axis = 0; d->axis < DRIVE_AXES; d->axis++) {
        if ((d->axes & 1u << d->axis) != 0)
            check_axis(d);
    }
    cf_step(c, "OP");
    drive_each_axis(c, check_axis);
}

/* --- CF-D02 ------------------------------------------------------------------------------------------------------- */

static void without_power(drive_t *d)
{
    drive_expect_stays(d, DRIVE_QUICK_STOP, DRIVE_DISABLED);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_expect_stays(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_go(d, 0, DRIVE_DISABLED);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_go(d, DRIVE_QUICK_STOP, DRIVE_DISABLED);
}

static void ready_and_back(cf_t *c)
{
    drive_each_axis(c, without_power);
}

/* --- CF-D03 ------------------------------------------------------------------------------------------------------- */

/* A mode that 6502h lacks is refused, or has no effect on 6061h. */
static void expect_refused(drive_t *d, int8_t mode)
{
    cf_step(d->c, "axis %u: mode %d, which 6502h lacks", d->axis + 1, mode);
    (void)drive_set(d, DRIVE_MODE, 0, mode);
    drive_cycles(d, DRIVE_SETTLE_MS);
    const int64_t shown = drive_get(d, DRIVE_MODE_DISPLAY, 0);
    cf_expect_that(d->c, shown != mode, "axis %u: mode %d, which 6502h lacks: expected another one in 6061h, got %lld",
                   d->axis + 1, mode, (long long)shown);
}

static void choose_each(drive_t *d)
{
    int8_t last = 0;
    if (!drive_has(d, DRIVE_MODE, 0) || !drive_has(d, DRIVE_MODE_DISPLAY, 0) || !drive_has(d, DRIVE_MODES, 0))
        cf_skip(d->c, "axis %u has not all of 6060h, 6061h and 6502h", d->axis + 1);
    for (int mode = 1; mode <= LAST_MODE; mode++) {
        if (!drive_supports(d, (int8_t)mode))
            continue;
        cf_step(d->c, "axis %u: mode %d of 6502h", d->axis + 1, mode);
        drive_choose(d, (int8_t)mode);
        last = (int8_t)mode;
    }
    for (int mode = 1; mode <= LAST_MODE; mode++) {
        if (!drive_supports(d, (int8_t)mode))
            expect_refused(d, (int8_t)mode);
    }
    if (last != 0)
        drive_choose(d, last);
}

static void modes(cf_t *c)
{
    drive_each_axis(c, choose_each);
}

/* --- CF-D04 ------------------------------------------------------------------------------------------------------- */

static void refuse_reserved(drive_t *d)
{
    static const uint16_t options[] = {DRIVE_ABORT_OPTION,   DRIVE_QUICK_OPTION, DRIVE_SHUTDOWN_OPTION,
                                       DRIVE_DISABLE_OPTION, DRIVE_HALT_OPTION,  DRIVE_FAULT_OPTION};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (!drive_has(d, options[i], 0))
            continue;
        d->found++;
        cf_step(d->c, "axis %u: %d in %04Xh, which the profile reserves", d->axis + 1, (int)RESERVED_OPTION,
                options[i]);
        const int64_t before = drive_get(d, options[i], 0);
        const uint32_t code = drive_set(d, options[i], 0, RESERVED_OPTION);
        const int64_t after = drive_get(d, options[i], 0);
        cf_expect_that(d->c, code != 0, "axis %u: %d in %04Xh: expected an abort, got none", d->axis + 1,
                       (int)RESERVED_OPTION, options[i]);
        cf_expect_that(d->c, after == before, "axis %u: %04Xh after a refused write: expected %lld, got %lld",
                       d->axis + 1, options[i], (long long)before, (long long)after);
    }
}

static void options(cf_t *c)
{
    const drive_t *d = drive_each_axis(c, refuse_reserved);
    if (d->found == 0)
        cf_skip(c, "the drive has no option code (6007h, 605Ah to 605Eh)");
    cf_note(c, "%u option codes", d->found);
}

static const cf_case_t cases[] = {
    {"CF-D01", "With control word 0 no axis has torque; each mode of 6502h has its set value", 'F', CF_COE | CF_DRIVE,
     LIMIT_MS, described},
    {"CF-D02", "Shutdown leads to Ready to switch on; Disable voltage and Quick stop lead back", 'F', CF_COE | CF_DRIVE,
     LIMIT_MS, ready_and_back},
    {"CF-D03", "6061h shows each mode of 6502h that 6060h requests, and no other", 'F', CF_COE | CF_DRIVE, LIMIT_MS,
     modes},
    {"CF-D04", "Option codes that the profile reserves are refused", 'F', CF_COE | CF_DRIVE, LIMIT_MS, options},
    {"CF-D05", "Each transition from Switch on disabled to Operation enabled and back; other commands are ignored", 'F',
     CF_COE | CF_DRIVE | CF_MOVE, LIMIT_MS, cf_drive_transitions},
    {"CF-D06", "Quick stop brakes, leaves or keeps Quick stop active by 605Ah", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_quick_stop},
    {"CF-D07", "Shutdown and Disable operation brake or not, by 605Bh and 605Ch", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_stops},
    {"CF-D08", "Halt brakes by 605Dh in Operation enabled; the motion continues afterwards", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_halt},
    {"CF-D09", "The loss of OP leads to Fault, by 605Eh; only the edge of bit 7 resets it", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_fault},
    {"CF-D10", "Profile position: bit 12 acknowledges a set-point; the target is reached", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_position},
    {"CF-D11", "Profile velocity: both directions, speed reached and speed is 0", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_velocity},
    {"CF-D12", "Homing at the present position: bits 10, 12 and 13, and the home offset", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_homing},
    {"CF-D13", "Cyclic synchronous position: the axis follows a trapezoid", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_cyclic},
    {"CF-D14", "Interpolated position: bit 12 shows the interpolation that bit 4 starts; the axis follows", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_interpolated},
    {"CF-D15", "Cyclic synchronous velocity: both directions, half the value is half the speed", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_cyclic_speed},
    {"CF-D16", "Profile torque: bit 10 is 0 on the slope; the torque moves the axis in both directions", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_torque},
    {"CF-D17", "Cyclic synchronous torque: bit 12; the torque moves the axis in both directions", 'F',
     CF_COE | CF_DRIVE | CF_MOVE | CF_REAL_TIME, LIMIT_MS, cf_drive_cyclic_torque},
};

CF_SECTION(cf_drive, 'L', "Drives of CiA 402", cases);
