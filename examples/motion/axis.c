/* SPDX-License-Identifier: MIT */
#include "axis.h"

#include <math.h>
#include <string.h>

/* PDO 1720h. */
enum { OUT_CONTROL = 0, OUT_POSITION = 2, OUT_LATCH = 6 };
/* PDO 1B25h. */
enum { IN_POSITION = 0, IN_FOLLOWING = 16, IN_LATCH_POSITION = 20, IN_STATUS = 24, IN_TORQUE = 26, IN_LATCH = 28 };

enum { SHUTDOWN = 0x06, SWITCH_ON = 0x07, ENABLE = 0x0F, RESET = 0x80, REFERENCE = 0x800 };
enum { TARGET = 0x0400, REFERENCING = 0x1000, REFERENCE_ERROR = 0x2000 };
enum { STATE_MASK = 0x6F, FAULT_MASK = 0x4F, DISABLED = 0x40, READY = 0x21, ON = 0x23, OPERATION = 0x27, FAULT = 0x08 };
enum { ARM_PROBE = 0x0001, READ_PROBE = 0x0101, PROBE_VALID = 0x0001, PROBE_READ = 0x0100 };
enum { PATIENCE_S = 30 };

static uint16_t get16(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] | bytes[1] << 8);
}

static int32_t get32(const uint8_t *bytes)
{
    return (int32_t)(get16(bytes) | (uint32_t)get16(bytes + 2) << 16);
}

static void put16(uint8_t *bytes, unsigned int value)
{
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t *bytes, int32_t value)
{
    put16(bytes, (uint32_t)value & 0xFFFF);
    put16(bytes + 2, (uint32_t)value >> 16);
}

/* --- trapezoid ---------------------------------------------------------------------------------------------------- */

/* A distance too short for both ramps results in a triangle. */
static double top_speed(const axis_t *a)
{
    double most = sqrt(fabs(a->way) * a->acceleration);
    return most < a->speed ? most : a->speed;
}

double axis_duration(const axis_t *a)
{
    double speed = top_speed(a);
    return speed > 0 ? fabs(a->way) / speed + speed / a->acceleration : 0;
}

double axis_trapezoid(const axis_t *a, double t)
{
    double speed = top_speed(a), ramp = speed / a->acceleration, whole = axis_duration(a), way = fabs(a->way);
    double at;
    if (t >= whole)
        at = way;
    else if (t <= ramp)
        at = a->acceleration * t * t / 2;
    else if (t <= whole - ramp)
        at = speed * (t - ramp / 2);
    else
        at = way - a->acceleration * (whole - t) * (whole - t) / 2;
    return a->way < 0 ? -at : at;
}

/* --- phases ------------------------------------------------------------------------------------------------------- */

static void enter_phase(axis_t *a, axis_phase_t phase)
{
    a->phase = phase;
    a->cycles = 0;
}

static void fail(axis_t *a, const char *why)
{
    a->failure = why;
    enter_phase(a, AXIS_FAILED);
}

/* Executes the next step of the sequence, by the state of the drive. @return the control word */
static uint16_t enabling(axis_t *a)
{
    a->set = a->position;
    if ((a->status & FAULT_MASK) == FAULT)
        return a->cycles % 2 != 0 ? RESET : 0; /* an edge */
    if ((a->status & FAULT_MASK) == DISABLED)
        return SHUTDOWN;
    if ((a->status & STATE_MASK) == READY)
        return SWITCH_ON;
    if ((a->status & STATE_MASK) == OPERATION)
        enter_phase(a, AXIS_HOMING);
    return (a->status & STATE_MASK) == ON || a->phase == AXIS_HOMING ? ENABLE : SHUTDOWN;
}

/* @return whether the run has ended: the drive reports "target reached", after the first cycles, which precede the
 * start */
static uint16_t homing(axis_t *a)
{
    a->set = a->position;
    if ((a->status & REFERENCE_ERROR) != 0)
        fail(a, "the reference run has failed (status bit 13)");
    else if (a->cycles > 3 && (a->status & (REFERENCING | TARGET)) == TARGET)
        enter_phase(a, AXIS_RELEASING);
    return ENABLE | REFERENCE;
}

static uint16_t releasing(axis_t *a)
{
    a->set = 0;
    if (a->cycles > 50)
        enter_phase(a, AXIS_MOVING);
    a->start = a->set;
    return ENABLE;
}

static uint16_t moving(axis_t *a)
{
    double t = a->cycles * a->cycle_s;
    a->set = (int32_t)lround(a->start + axis_trapezoid(a, t));
    if (t >= axis_duration(a))
        enter_phase(a, AXIS_SETTLING);
    return ENABLE;
}

static uint16_t settling(axis_t *a)
{
    if (a->cycles * a->cycle_s > 0.2 && (a->status & TARGET) != 0)
        enter_phase(a, AXIS_READING);
    return ENABLE;
}

static uint16_t reading(axis_t *a, const uint8_t *in, uint16_t *latch)
{
    uint16_t status = get16(in + IN_LATCH);
    *latch = READ_PROBE;
    a->probed = (status & (PROBE_VALID | 0x0F00)) == (PROBE_VALID | PROBE_READ);
    if (a->probed)
        a->probe = get32(in + IN_LATCH_POSITION);
    if (a->probed || (status & PROBE_VALID) == 0)
        enter_phase(a, AXIS_DISABLING);
    return ENABLE;
}

static uint16_t disabling(axis_t *a)
{
    if ((a->status & STATE_MASK) == READY)
        enter_phase(a, AXIS_DONE);
    return SHUTDOWN;
}

/* Detects a fault, or a phase that does not end. */
static void watch(axis_t *a)
{
    bool enabled = a->phase > AXIS_ENABLING && a->phase < AXIS_DISABLING;
    if (enabled && (a->status & STATE_MASK) != OPERATION)
        fail(a, "the drive has left Operation Enabled");
    else if (a->phase < AXIS_DONE && a->cycles * a->cycle_s > (double)PATIENCE_S)
        fail(a, "no progress for 30 s");
}

static uint16_t control(axis_t *a, const uint8_t *in, uint16_t *latch)
{
    *latch = a->phase >= AXIS_MOVING && a->phase <= AXIS_SETTLING ? ARM_PROBE : 0;
    switch (a->phase) {
    case AXIS_ENABLING:
        return enabling(a);
    case AXIS_HOMING:
        return homing(a);
    case AXIS_RELEASING:
        return releasing(a);
    case AXIS_MOVING:
        return moving(a);
    case AXIS_SETTLING:
        return settling(a);
    case AXIS_READING:
        return reading(a, in, latch);
    case AXIS_DISABLING:
        return disabling(a);
    default:
        return 0;
    }
}

void axis_cycle(axis_t *a, const uint8_t *in, uint8_t *out)
{
    uint16_t latch;
    a->status = get16(in + IN_STATUS);
    a->position = get32(in + IN_POSITION);
    a->following_error = get32(in + IN_FOLLOWING);
    a->torque = (int16_t)get16(in + IN_TORQUE);
    a->cycles++;
    watch(a);
    uint16_t word = control(a, in, &latch);
    memset(out, 0, AXIS_OUT);
    put16(out + OUT_CONTROL, word);
    put32(out + OUT_POSITION, a->set);
    put16(out + OUT_LATCH, latch);
}

const char *axis_phase_name(axis_phase_t phase)
{
    static const char *const names[] = {"enabling", "homing",    "releasing", "moving", "settling",
                                        "reading",  "disabling", "done",      "failed"};
    return names[phase];
}
