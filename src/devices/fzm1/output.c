/* SPDX-License-Identifier: MIT */
/*
 * DSA, GATE and the output area (Q179 §4-4). Results wait in the order of their measurements. Data are written before
 * GATE rises, and are unchanged until GATE has fallen.
 */
#include <string.h>

#include "devices/fzm1/instance.h"

#define TENTH_MS 100000ull
#define TENTH_S  100000000ull

/* @return the integer part of a value multiplied by 1000, limited to 32 bits; NaN is 0 */
int32_t fzm1_fixed_point(double value)
{
    double scaled = value * 1000.0;
    scaled += scaled < 0 ? -1e-6 : 1e-6; /* 12.345 has no exact double: multiplied by 1000 it is just below 12345 */
    if (scaled != scaled)
        return 0;
    if (scaled >= 2147483647.0)
        return INT32_MAX;
    return scaled <= -2147483648.0 ? INT32_MIN : (int32_t)scaled;
}

static int32_t format(const fzm1_t *u, double value)
{
    if (u->scene.format == FZM1_FIXED_POINT)
        return fzm1_fixed_point(value);
    float single = (float)value;
    int32_t bits;
    memcpy(&bits, &single, sizeof bits);
    return bits;
}

static bool handshaking(const fzm1_t *u)
{
    return u->settings.output_control == FZM1_HANDSHAKING;
}

/* Adds a result. Output and measuring are independent: a result without room is lost, and no measurement waits. */
void fzm1_output_put(fzm1_t *u, const double *data)
{
    if (u->output_count == FZM1_OUTPUTS) {
        u->lost++;
        fzm1_set_error(u, FZM1_ERROR_LOST);
        return;
    }
    int32_t *to = u->waiting[(u->first_output + u->output_count) % FZM1_OUTPUTS];
    for (unsigned int i = 0; i < FZM1_DATA; i++)
        to[i] = format(u, data[i]);
    u->output_count++;
}

/* Removes the oldest results from the queue; the loss ends with the last one. */
static void drop(fzm1_t *u, uint8_t count)
{
    u->first_output = (uint8_t)((u->first_output + count) % FZM1_OUTPUTS);
    u->output_count = (uint8_t)(u->output_count - count);
    if (u->output_count == 0)
        fzm1_end_errors(u, FZM1_ERROR_LOST);
}

void fzm1_output_discard(fzm1_t *u)
{
    u->discarded += u->output_count;
    u->to_repeat = false;
    if (!u->gate)
        u->dsa_due_ns = ECT_NEVER;
    drop(u, u->output_count);
}

static void show(fzm1_t *u)
{
    if (u->output_count > 0) {
        memcpy(u->output, u->waiting[u->first_output], sizeof u->output);
        drop(u, 1);
    }
    u->to_repeat = true;
    u->gate = true;
    u->outputs++;
}

/* --- with handshaking --------------------------------------------------------------------------------------------- */

static void expect_dsa(fzm1_t *u)
{
    u->dsa_due_ns = u->time_ns + u->settings.timeout * TENTH_S;
}

static bool step_handshake(fzm1_t *u)
{
    bool dsa = (u->levels & FZM1_DSA) != 0;
    if (!u->levels_known)
        return false; /* no external device takes part in the handshake */
    u->dsa_was_off |= !dsa;
    if (u->gate && !dsa) {
        u->gate = false;
        u->dsa_due_ns = ECT_NEVER;
        fzm1_end_errors(u, FZM1_ERROR_NO_DSA | FZM1_ERROR_DSA_STAYED); /* the external device replies again */
        return true;
    }
    if (u->gate || u->output_count == 0)
        return false;
    if (dsa && u->dsa_was_off) {
        u->dsa_was_off = false;
        show(u);
        expect_dsa(u);
        return true;
    }
    if (u->dsa_due_ns == ECT_NEVER)
        expect_dsa(u);
    return false;
}

void fzm1_output_begin(fzm1_t *u)
{
    u->dsa_was_off = false;
}

void fzm1_output_end(fzm1_t *u)
{
    if (!handshaking(u))
        return;
    u->gate = false;
    u->dsa_due_ns = ECT_NEVER;
}

/* Handles timeouts: a missing DSA drops the result; a DSA that stays on ends GATE. */
static void dsa_timeout(fzm1_t *u)
{
    u->dsa_due_ns = ECT_NEVER;
    fzm1_set_error(u, u->gate ? FZM1_ERROR_DSA_STAYED : FZM1_ERROR_NO_DSA);
    if (u->gate) {
        u->gate = false;
        return;
    }
    u->discarded++;
    drop(u, 1);
}

/* --- without handshaking ------------------------------------------------------------------------------------------ */

static bool to_show(const fzm1_t *u)
{
    return u->output_count > 0 || (u->settings.output_repeat && u->to_repeat);
}

static uint64_t off_time(const fzm1_t *u)
{
    return (uint64_t)u->settings.output_period * TENTH_MS - (uint64_t)u->settings.output_time * TENTH_MS;
}

/* The times of GATE start at the poll that changes it, however late, and each poll makes one change, so that a master
 * with the same rhythm reads every pulse. */
static bool step_period(fzm1_t *u)
{
    if (u->gate || u->gate_changed || !to_show(u) || u->next_output_ns > u->time_ns)
        return false;
    show(u);
    u->gate_changed = true;
    u->gate_due_ns = u->poll_ns + u->settings.output_time * TENTH_MS;
    u->next_output_ns = u->poll_ns + u->settings.output_period * TENTH_MS;
    return true;
}

static void gate_due(fzm1_t *u)
{
    u->gate_due_ns = ECT_NEVER;
    u->gate = false;
    u->gate_changed = true;
    uint64_t earliest = u->poll_ns + off_time(u);
    u->next_output_ns = u->next_output_ns < earliest ? earliest : u->next_output_ns;
}

/* ------------------------------------------------------------------------------------------------------------------ */

bool fzm1_output_step(fzm1_t *u)
{
    if (u->starting != 0)
        return false;
    return handshaking(u) ? step_handshake(u) : step_period(u);
}

void fzm1_output_due(fzm1_t *u)
{
    if (u->gate_due_ns <= u->time_ns)
        gate_due(u);
    if (u->dsa_due_ns <= u->time_ns)
        dsa_timeout(u);
}

uint64_t fzm1_output_next(const fzm1_t *u)
{
    uint64_t next = ect_earlier(u->gate_due_ns, u->dsa_due_ns);
    bool waits = !handshaking(u) && !u->gate && u->starting == 0 && to_show(u);
    return waits && u->next_output_ns < next ? u->next_output_ns : next;
}

void fzm1_output_new_period(fzm1_t *u, uint16_t period)
{
    uint64_t latest = u->time_ns + period * TENTH_MS;
    u->next_output_ns = u->next_output_ns < latest ? u->next_output_ns : latest;
}

/* Keeps GATE off, after a change of output control and at the start, for the time between two outputs. */
void fzm1_output_reset(fzm1_t *u)
{
    u->gate = false;
    u->dsa_was_off = (u->levels & FZM1_DSA) == 0;
    u->gate_due_ns = ECT_NEVER;
    u->dsa_due_ns = ECT_NEVER;
    u->next_output_ns = u->time_ns + off_time(u);
}
