/* SPDX-License-Identifier: MIT */
/* The controller's time and its process data. */
#include "devices/fzm1/instance.h"

/* Longest time processed by one call: in a longer pause of the host a continuous measurement waits. */
enum { MOST_EVENTS = 4096 };

/* --- time --------------------------------------------------------------------------------------------------------- */

static uint64_t next_due(const fzm1_t *u)
{
    uint64_t next = ect_earlier(u->image_due_ns, u->processing_due_ns);
    next = ect_earlier(next, ect_earlier(u->command_due_ns, u->flg_due_ns));
    next = ect_earlier(next, ect_earlier(u->switched_due_ns, u->saving.due_ns));
    return ect_earlier(next, ect_earlier(u->start_due_ns, fzm1_output_next(u)));
}

static void settle(fzm1_t *u)
{
    while (fzm1_output_step(u))
        ;
}

/* A late call runs all due events in order, each at its own time. */
static void advance(fzm1_t *u, uint64_t now_ns)
{
    u->poll_ns = now_ns;
    u->gate_changed = false;
    unsigned int events = 0;
    for (uint64_t due = next_due(u); due <= now_ns; due = next_due(u)) {
        u->time_ns = due > u->time_ns ? due : u->time_ns;
        if (++events == MOST_EVENTS)
            fzm1_measure_put_off(u, now_ns - u->time_ns);
        fzm1_measure_due(u);
        fzm1_switch_due(u);
        fzm1_save_due(u);
        fzm1_command_due(u);
        fzm1_output_due(u);
        fzm1_restart_due(u);
        settle(u);
    }
    u->time_ns = now_ns;
}

static uint32_t bit(bool on, uint32_t mask)
{
    return on ? mask : 0;
}

static void publish(fzm1_t *u)
{
    bool up = u->starting == 0;
    u->ready = !fzm1_not_ready(u);
    u->busy = fzm1_busy(u);
    u->exe_level = (u->levels & FZM1_EXE) != 0;
    u->step_level = (u->levels & FZM1_STEP) != 0;
    u->dsa_level = (u->levels & FZM1_DSA) != 0;
    u->gate_level = u->gate;
    u->flg_level = u->flg;
    u->continuous_level = u->continuous;
    u->saving_level = fzm1_saving(u);
    u->control_out = bit(u->flg, FZM1_FLG) | bit(u->busy, FZM1_BUSY) | bit(u->ready, FZM1_READY) |
                     bit(up && u->overall_ng, FZM1_OR) | bit(up && u->run, FZM1_RUN) | bit(up && u->err, FZM1_ERR) |
                     bit(u->gate, FZM1_GATE);
}

static void take_step(fzm1_t *u)
{
    fzm1_why_t why = fzm1_not_ready(u);
    if (why != FZM1_DONE)
        fzm1_refuse(&u->step_ignored, why);
    else
        fzm1_step(u);
}

static void take_levels(fzm1_t *u, uint32_t levels)
{
    uint32_t rising = levels & ~u->levels;
    u->levels = levels;
    fzm1_exe(u, (rising & FZM1_EXE) != 0);
    if ((rising & FZM1_STEP) != 0)
        take_step(u);
}

/* The first levels in OP are no edges. */
static void begin_levels(fzm1_t *u)
{
    const fzm1_why_t why = FZM1_WHY_NO_EDGE;
    u->levels = u->control_in;
    u->levels_known = true;
    fzm1_output_begin(u);
    if ((u->levels & FZM1_EXE) != 0)
        fzm1_refuse(&u->exe_ignored, why);
    if ((u->levels & FZM1_STEP) != 0)
        fzm1_refuse(&u->step_ignored, why);
}

/* Switches off all signals of the master, because process data have stopped. */
static void end_levels(fzm1_t *u)
{
    take_levels(u, 0);
    u->levels_known = false;
    fzm1_output_end(u);
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

/* Writes only defaults other than 0, because the memory is already zero, except the switches, and most of it stays
 * unused. */
static void plant_defaults(fzm1_plant_t *p)
{
    p->known = true;
    p->image_input_us = 5000;
    p->processing_us = 20000;
    p->command_us = 1000;
    p->switch_us = 100000;
    p->start_ms = 3000;
    p->seed = p->random = p->time_random = 1;
    p->row.scene = -1;
    fzm1_default_scene(&p->edit.content);
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        p->amplitude[n] = 1;
        p->period[n] = 100;
    }
}

void fzm1_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    fzm1_t *u = instance;
    u->host = host;
    u->time_ns = now_ns;
    if (!u->plant.known)
        plant_defaults(&u->plant);
    u->settings.fieldbus = 1;
    u->run = 1;
    u->start_due_ns = ECT_NEVER;
    fzm1_all_off(u);
    fzm1_save_reset(u);
    fzm1_load(u);
    if (u->settings.fieldbus == 0)
        host->off_bus(host->ctx, true);
    publish(u);
}

uint16_t fzm1_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    fzm1_t *u = instance;
    advance(u, now_ns);
    if (from == ECT_STATE_OP || to == ECT_STATE_OP)
        end_levels(u);
    publish(u);
    return 0;
}

void fzm1_outputs(void *instance, uint64_t now_ns)
{
    fzm1_t *u = instance;
    advance(u, now_ns);
    if (u->levels_known)
        take_levels(u, u->control_in);
    else
        begin_levels(u);
    settle(u);
    advance(u, now_ns); /* events without duration */
    publish(u);
}

uint64_t fzm1_tick(void *instance, uint64_t now_ns)
{
    fzm1_t *u = instance;
    advance(u, now_ns);
    settle(u);
    publish(u);
    return next_due(u);
}
