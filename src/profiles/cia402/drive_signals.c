/* SPDX-License-Identifier: MIT */
/* Signals of a drive: supply, load, switches along the way, faults, and the state of the axis. */
#include <string.h>

#include "profiles/cia402/drive.h"

/* The range of an endless axis: half a year at 60 turns a second. */
#define FARTHEST ((int64_t)1 << 50)
#define R(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(ect_402_drive_t, member, name, kind, READ, minimum, maximum, unit, meaning)
#define W(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(ect_402_surroundings_t, member, name, kind, WRITE, minimum, maximum, unit, meaning)
#define R_COUNTS(member, name, meaning) R(member, name, I32, INT32_MIN, INT32_MAX, "counts", meaning)
#define CHOICE(member, most, meaning)   W(choices.member, #member, U8, 0, most, NULL, meaning)
#define W_COUNTS(member, name, meaning) W(member, name, I32, INT32_MIN, INT32_MAX, "counts", meaning)

const ect_signal_t ect_402_drive_signals[] = {
    R(state_shown, "state", DESCRIBED, 0, 31, NULL, "state of the CiA 402 state machine"),
    R(mode_shown, "mode", I8, INT8_MIN, INT8_MAX, NULL, "mode of operation, 6061h"),
    R(powered, "powered", BOOL, 0, 1, NULL, "the power stage is on"),
    R(homed, "homed", BOOL, 0, 1, NULL, "a reference run has found its point"),
    R(error_code, "error_code", U16, 0, UINT16_MAX, NULL, "603Fh; 0: no fault"),
    R_COUNTS(position, "position", "actual position as the master sees it, 6064h"),
    R_COUNTS(demand, "demand", "present set position, 6062h"),
    R_COUNTS(following_error, "following_error", "difference of demand and position, 60F4h"),
    R(position_turns, "turns", REAL, -FARTHEST, FARTHEST, "turns", "actual position; does not wrap"),
    R(speed_rpm, "speed", REAL, -10000000, 10000000, "1/min", "actual speed of the motor"),
    R(torque_nm, "torque", REAL, -1000000, 1000000, "Nm", "torque of the motor"),
    ECT_SIGNAL(ect_402_drive_t, fault, "fault", U16, WRITE, 0, UINT16_MAX, NULL,
               "write a code of 603Fh: raises the fault; 0: none"),
};
const uint16_t ect_402_drive_signal_count = sizeof ect_402_drive_signals / sizeof ect_402_drive_signals[0];

const ect_signal_t ect_402_around_signals[] = {
    W(power, "power", BOOL, 0, 1, NULL, "DC link; 0: cannot be switched on, fault 3220h when it is on"),
    W(enable, "enable", BOOL, 0, 1, NULL, "enable input; 0: no torque"),
    W(sto, "sto", BOOL, 0, 1, NULL, "safe torque off; 1: no torque, fault 5441h when the power stage is on"),
    W(warning, "warning", BOOL, 0, 1, NULL, "a warning is present: bit 7 of the status word; the state stays"),
    W(machine.load, "load", REAL, -100000, 100000, "Nm",
      "torque of the load, or gravity, against the positive direction"),
    W(machine.load_inertia, "load_inertia", REAL, 0, 1000000, "kg cm2", "inertia of the load at the motor's shaft"),
    W(machine.friction, "friction", REAL, 0, 100000, "Nm", "Coulomb friction"),
    W(machine.jam, "jam", BOOL, 0, 1, NULL, "1: the shaft is stuck"),
    W(machine.brake, "brake", REAL, 0, 1000000, "Nm",
      "torque of the holding brake, closed without motor torque; 0: none"),
    W(machine.brake_delay_ms, "brake_delay", U32, 0, 10000, "ms",
      "time until the brake is closed after a fault, STO or a loss of supply"),
    W(machine.input[ECT_402_HOME], "home", BOOL, 0, 1, NULL,
      "home switch, set manually; also on within the mark at home_at"),
    W(machine.input[ECT_402_PROBE], "probe", BOOL, 0, 1, NULL,
      "probe input, set manually; also on within the mark at probe_at"),
    W(machine.input[ECT_402_POSITIVE], "positive_free", BOOL, 0, 1, NULL,
      "positive limit switch, set manually, normally closed; 0: hit"),
    W(machine.input[ECT_402_NEGATIVE], "negative_free", BOOL, 0, 1, NULL,
      "negative limit switch, set manually, normally closed; 0: hit"),
    W_COUNTS(machine.mark[ECT_402_PROBE].at, "probe_at", "machine position from which the probe input is on"),
    W(machine.mark[ECT_402_PROBE].width, "probe_width", I32, 0, INT32_MAX, "counts",
      "length of the mark at probe_at; 0: no mark"),
    W_COUNTS(machine.mark[ECT_402_HOME].at, "home_at", "machine position from which the home switch is on"),
    W(machine.mark[ECT_402_HOME].width, "home_width", I32, 0, INT32_MAX, "counts",
      "length of the mark at home_at; 0: no mark"),
    W_COUNTS(machine.stop_positive.at, "stop_positive",
             "machine position from which the positive limit switch is hit; 2147483647: none"),
    W_COUNTS(machine.stop_negative.at, "stop_negative",
             "machine position down from which the negative limit switch is hit; -2147483648: none"),
    W_COUNTS(machine.index_at, "index_at", "machine position of an index pulse; one more every turn"),
    W(resolution, "resolution", U32, 0, UINT32_MAX, "counts",
      "increments per turn if the dictionary has no 608Fh; 0: 1048576"),
    W(velocity_unit, "velocity_unit", U8, 0, ECT_402_UNIT_TENTH_RPM, NULL,
      "speeds on the bus: 0 position units per second, 1 turns per minute, 2 tenths of turns per minute"),
    CHOICE(home_offset_added, 1, "607Ch: 0 home is at -607Ch, 1 at 607Ch"),
    CHOICE(following_zero, 1, "6065h of 0: 0 no window, 1 a window of 0"),
    CHOICE(following_warns, 1, "following error: 0 fault 8611h, 1 bit 13 alone"),
    CHOICE(switched_on_holds, 1, "Switched on: 0 no torque, 1 holds the position"),
    CHOICE(csp_bit10, ECT_402_BIT10_TOGGLES, "bit 10 in csp: 0 zero, 1 position in its window, 2 toggles"),
    CHOICE(csp_bit12, ECT_402_BIT12_ZERO, "bit 12 in csp: 0 the drive follows, 1 one, 2 zero"),
    CHOICE(homing_by_level, 1, "start of homing: 0 edge of bit 4, 1 also its level"),
    CHOICE(home_stays, 1, "end of homing: 0 the shaft returns to home, 1 remains at its stop"),
    CHOICE(limits_absolute, 1, "607Dh: 0 minus 607Ch, 1 unchanged"),
    CHOICE(switch_faults, 1, "limit switch: 0 stops the shaft, 1 is fault 8612h"),
    CHOICE(no_buffer, 1, "set-points of pp: 0 one waits, 1 each applies at once"),
    CHOICE(mode_zero, 1, "6060h of 0: 0 keeps the mode, 1 ends it"),
    CHOICE(mode_change, ECT_402_CHANGE_NONE, "mode in Operation enabled: 0 any time, 1 at a standstill, 2 fixed"),
    CHOICE(reset_needs_zero, 1, "fault reset: 0 with any other bits, 1 only with bits 0 to 3 at 0"),
    CHOICE(sync_check, 1, "60C2h different from the cycle: 0 no effect, 1 fault 8700h and SAFEOP"),
    ECT_SIGNAL(ect_402_surroundings_t, machine.position, "machine_position", REAL, READ, -FARTHEST, FARTHEST, "counts",
               "position of the shaft on the machine, independent of the reference; does not wrap"),
};
const uint16_t ect_402_around_signal_count = sizeof ect_402_around_signals / sizeof ect_402_around_signals[0];

const char *ect_402_drive_signal_write(ect_402_drive_t *d, const ect_signal_t *signal, const void *value)
{
    uint16_t code;
    if (signal->offset != offsetof(ect_402_drive_t, fault))
        return NULL;
    memcpy(&code, value, sizeof code);
    ect_402_drive_fault(d, code);
    ect_402_drive_touched(d);
    return "";
}

void ect_402_drive_signal_describe(const ect_signal_t *signal, uint16_t value, char *text)
{
    static const char *const states[ECT_402_STATES] = {
        "not ready to switch on", "switch on disabled", "ready to switch on",    "switched on",
        "operation enabled",      "quick stop active",  "fault reaction active", "fault"};
    (void)signal;
    memcpy(text, states[value], strlen(states[value]) + 1);
}
