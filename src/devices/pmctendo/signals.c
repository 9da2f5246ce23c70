/* SPDX-License-Identifier: MIT */
/* Signals: supply, inputs, load, switches along the way, faults, and the state of the drive. */
#include <string.h>

#include "devices/pmctendo/instance.h"
#include "devices/pmctendo/pmctendo.h"

#define R(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(pmctendo_t, member, name, kind, READ, minimum, maximum, unit, meaning)
#define W(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(pmctendo_t, member, name, kind, WRITE, minimum, maximum, unit, meaning)
#define R_COUNTS(member, name, meaning) R(member, name, I32, INT32_MIN, INT32_MAX, "counts", meaning)
/* The range of an endless axis: half a year at 60 turns a second. */
#define FARTHEST                        ((int64_t)1 << 50)
#define W_COUNTS(member, name, meaning) W(member, name, I32, INT32_MIN, INT32_MAX, "counts", meaning)

static const ect_signal_t signals[] = {
    W(plant.power, "power", BOOL, 0, 1, NULL, "DC link; 0: the drive cannot be switched on, F05 when it is on"),
    W(plant.enable, "enable", BOOL, 0, 1, NULL, "enable input; 0: no torque"),
    W(plant.sto, "sto", BOOL, 0, 1, NULL, "safe torque off; 1: no torque, F27 when the drive is enabled"),
    W(plant.machine.input[PMC_DI1], "di1", BOOL, 0, 1, NULL,
      "digital input 1, external latch 1; also on within the mark at probe_at"),
    W(plant.machine.input[PMC_DI2], "di2", BOOL, 0, 1, NULL,
      "digital input 2, external latch 2 and reference switch; also on within the mark at home_at"),
    W(plant.machine.input[PMC_DI3], "di3", BOOL, 0, 1, NULL,
      "digital input 3, PSTOP; 0: the positive limit switch is hit"),
    W(plant.machine.input[PMC_DI4], "di4", BOOL, 0, 1, NULL,
      "digital input 4, NSTOP; 0: the negative limit switch is hit"),
    W(provoke, "provoke", U8, 0, PMC_FAULTS, NULL, "write n: raises fault Fn"),
    W(restart, "restart", BOOL, 0, 1, NULL, "write 1: power cycle of the amplifier"),

    W(plant.machine.load, "load", REAL, -100, 100, "Nm", "torque of the load against the positive direction"),
    W(plant.machine.load_inertia, "load_inertia", REAL, 0, 1000, "kg cm2", "in addition to the 3 of the motor"),
    W(plant.machine.friction, "friction", REAL, 0, 100, "Nm", "Coulomb friction"),
    W(plant.machine.brake, "brake", REAL, 0, 1000, "Nm",
      "torque of the holding brake, closed without motor torque; 0: none"),
    W(plant.machine.brake_delay_ms, "brake_delay", U32, 0, 10000, "ms",
      "time until the brake is closed after a fault, STO or a loss of supply"),
    W(plant.analog, "analog", I16, INT16_MIN, INT16_MAX, "mV", "analogue input"),
    W_COUNTS(plant.feedback2, "feedback2", "position of a second feedback"),

    W_COUNTS(plant.machine.mark[0].at, "probe_at", "machine position from which the switch at DI1 is on"),
    W(plant.machine.mark[0].width, "probe_width", I32, 0, INT32_MAX, "counts",
      "length of the mark at probe_at; 0: no mark"),
    W_COUNTS(plant.machine.mark[1].at, "home_at", "machine position from which the switch at DI2 is on"),
    W(plant.machine.mark[1].width, "home_width", I32, 0, INT32_MAX, "counts",
      "length of the mark at home_at; 0: no mark"),
    W_COUNTS(plant.machine.stop_positive.at, "stop_positive",
             "machine position from which the positive limit switch is hit; 2147483647: none"),
    W_COUNTS(plant.machine.stop_negative.at, "stop_negative",
             "machine position down from which the negative limit switch is hit; -2147483648: none"),
    W(plant.machine.stop_positive.fitted, "stop_positive_fitted", BOOL, 0, 1, NULL,
      "a positive limit switch exists (set by a write of stop_positive); 0: endless in this direction"),
    W(plant.machine.stop_negative.fitted, "stop_negative_fitted", BOOL, 0, 1, NULL,
      "a negative limit switch exists (set by a write of stop_negative); 0: endless in this direction"),
    W_COUNTS(plant.machine.index_at, "index_at", "machine position of an index pulse; one more every turn"),

    W(plant.sync_patience_ms, "sync_patience", U32, 0, 10000, "ms",
      "longest time without a cyclic event; 0: only the watchdog applies"),
    W(plant.sync_timeout_ms, "sync_timeout", U32, 1, 9000, "ms",
      "longest time that SAFEOP to OP waits for synchronisation"),
    W(plant.sync_tolerance_ppm, "sync_tolerance", U32, 0, 1000000, "ppm",
      "without SYNC0: largest mean deviation of the frames from 60C2h; 0: any; manual: 1000"),
    W(plant.status_bits, "status_bits", U16, 0, PMC_STATUS_402, NULL,
      "402: bits 10, 12, 13 of the status word and 0Fh after 06h as in CiA 402; 0: as in the manual"),
    W(plant.quirk_reply, "quirk_pilz_reply", BOOL, 0, 1, NULL, "1: replies as in the example of the manual"),
    W(plant.quirk_al_codes, "quirk_pilz_codes", BOOL, 0, 1, NULL, "1: only AL status codes 0011, 0017 and 001A"),

    R(state_shown, "state", DESCRIBED, 0, 31, NULL, "state of the CiA 402 state machine"),
    R(display, "display", DESCRIBED, 0, 3, NULL, "display on the front: the fault, or the first warning"),
    R(fault, "fault", U16, 0, PMC_FAULTS, NULL, "n of Fn, 0: none"),
    R(warnings, "warnings", U32, 0, INT32_MAX, NULL, "bit n-1: warning nn"),
    R(powered, "powered", BOOL, 0, 1, NULL, "the power stage is on"),
    R(mode_display, "mode", I8, INT8_MIN, INT8_MAX, NULL, "mode of operation, 6061h"),
    R(synchronised, "synchronised", BOOL, 0, 1, NULL, "synchronised with SYNC0, or the frames of the master"),
    R(homed_level, "homed", BOOL, 0, 1, NULL, "a reference run has found its point"),
    R_COUNTS(position, "position", "actual position as the master sees it, 6064h"),
    R_COUNTS(demand, "demand", "present set position, 6062h"),
    R_COUNTS(following_error, "following_error", "difference of demand and position, 60F4h"),
    R(plant.machine.position, "machine_position", REAL, -FARTHEST, FARTHEST, "counts",
      "position of the shaft on the machine, independent of the reference; does not wrap"),
    R(position_turns, "turns", REAL, -FARTHEST / PMC_TURN, FARTHEST / PMC_TURN, "turns",
      "actual position; does not wrap"),
    R(speed_rpm, "speed", REAL, -100000, 100000, "1/min", "actual speed"),
    R(torque_nm, "torque", REAL, -100, 100, "Nm", "torque of the motor"),
    R(latch_status, "latch_status", U16, 0, UINT16_MAX, NULL, "20A5h"),
    R_COUNTS(latch_position[0], "latch1", "latch position 1, 20A6h"),
    R_COUNTS(latch_position[1], "latch2", "latch position 2, 20A7h"),
    R(do1, "do1", BOOL, 0, 1, NULL, "digital output 1"),
    R(do2, "do2", BOOL, 0, 1, NULL, "digital output 2"),
    R(saves, "saves", U32, 0, INT32_MAX, NULL, "SAVE commands"),
};

static const ect_signal_group_t groups[] = {
    {.signal_count = sizeof signals / sizeof signals[0], .signals = signals},
};

/* --- writes ------------------------------------------------------------------------------------------------ */

#define IS(signal, member) ((signal)->offset == offsetof(pmctendo_t, member))

static const char *provoke(pmctendo_t *u, uint8_t number)
{
    if (!pmc_fault_known(number))
        return "there is no such fault: use 1 to 6, 8, 9, 14 to 16, 27, 28, 30 or 32";
    pmc_fault(u, number);
    pmc_read_levels(u);
    pmc_publish(u);
    return "";
}

static const char *restart(pmctendo_t *u, uint8_t wanted)
{
    if (wanted)
        u->host->restart(u->host->ctx);
    return "";
}

static const char *status_bits(uint16_t wanted)
{
    return wanted == 0 || wanted == PMC_STATUS_402 ? NULL : "status_bits is 0, the manual's, or 402";
}

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    pmctendo_t *u = instance;
    (void)number;
    pmc_advance(u, now_ns);
    if (IS(signal, provoke))
        return provoke(u, *(const uint8_t *)value);
    if (IS(signal, restart))
        return restart(u, *(const uint8_t *)value);
    if (IS(signal, plant.status_bits))
        return status_bits(*(const uint16_t *)value);
    return NULL;
}

/* Applies a change of the surroundings at the present time: edges occur at the present position of the shaft. */
static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    (void)number;
    (void)now_ns;
    if (IS(signal, plant.machine.stop_positive.at))
        u->plant.machine.stop_positive.fitted = u->plant.machine.stop_positive.at != INT32_MAX;
    if (IS(signal, plant.machine.stop_negative.at))
        u->plant.machine.stop_negative.fitted = u->plant.machine.stop_negative.at != INT32_MIN;
    pmc_read_levels(u);
    pmc_publish(u);
}

static void signal_describe(const ect_signal_t *signal, uint16_t value, char *text)
{
    static const char *const states[ECT_402_STATES] = {
        "not ready to switch on", "switch on disabled", "ready to switch on",    "switched on",
        "operation enabled",      "quick stop active",  "fault reaction active", "fault"};
    unsigned int number = value & ~(unsigned int)PMC_DISPLAYS_FAULT;
    if (!IS(signal, display)) {
        memcpy(text, states[value], strlen(states[value]) + 1);
        return;
    }
    text[0] = (value & PMC_DISPLAYS_FAULT) != 0 ? 'F' : 'n';
    text[1] = (char)('0' + number / 10);
    text[2] = (char)('0' + number % 10);
    text[number != 0 ? 3 : 0] = 0;
}

const ect_plant_t ect_pmctendo_dd5_plant = {
    .signal_groups = groups,
    .signal_group_count = sizeof groups / sizeof groups[0],
    .outside_offset = offsetof(pmctendo_t, plant),
    .outside_size = sizeof(pmc_plant_t),
    .signal_write = signal_write,
    .signal_written = signal_written,
    .signal_describe = signal_describe,
};
