/* SPDX-License-Identifier: MIT */
/* The controller's time and its process data. */
#include <string.h>

#include "devices/fzm1/instance.h"

enum { SHOWN_OFF_NS = 20000000 }; /* how long the signals show off before a restart takes the slave off the bus */
enum { STARTING_OFF = 1, STARTING_AWAY = 2 };

void fzm1_set_error(fzm1_t *u, fzm1_error_t error)
{
    static const char *const causes[] = {"", "time-out of the data output: no DSA",
                                         "time-out of a command: EXE stayed on", "set by hand"};
    u->error = (uint8_t)error;
    u->err = error != FZM1_NO_ERROR;
    memset(u->error_cause, 0, sizeof u->error_cause);
    memcpy(u->error_cause, causes[error], strlen(causes[error]));
}

/* --- restart ------------------------------------------------------------------------------------------------------ */

static void all_off(fzm1_t *u)
{
    u->continuous = u->executing = u->switching = u->flg = u->stalled = false;
    u->image_count = u->output_count = 0;
    u->image_due_ns = u->processing_due_ns = u->command_due_ns = u->flg_due_ns = ECT_NEVER;
    fzm1_output_reset(u);
}

/* No answer to the command: signals off, then off the bus, at last a power cycle. */
void fzm1_begin_restart(fzm1_t *u)
{
    all_off(u);
    u->starting = STARTING_OFF;
    u->start_due_ns = u->time_ns + SHOWN_OFF_NS;
}

static void start_due(fzm1_t *u)
{
    if (u->start_due_ns > u->time_ns)
        return;
    u->start_due_ns = ECT_NEVER;
    if (u->starting == STARTING_OFF) {
        u->starting = STARTING_AWAY;
        u->start_due_ns = u->time_ns + u->plant.start_ms * 1000000ull;
        u->host->off_bus(u->host->ctx, true);
    } else {
        u->host->restart(u->host->ctx);
    }
}

/* --- time --------------------------------------------------------------------------------------------------------- */

static uint64_t earlier(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t next_due(const fzm1_t *u)
{
    uint64_t next = earlier(u->image_due_ns, u->processing_due_ns);
    next = earlier(next, earlier(u->command_due_ns, u->flg_due_ns));
    return earlier(next, earlier(u->start_due_ns, fzm1_output_next(u)));
}

static void settle(fzm1_t *u)
{
    while (fzm1_output_step(u))
        ;
}

/* However late the call: what is due happens one after the other, each at its own time. */
static void advance(fzm1_t *u, uint64_t now_ns)
{
    u->poll_ns = now_ns;
    u->gate_changed = false;
    for (uint64_t due = next_due(u); due <= now_ns; due = next_due(u)) {
        u->time_ns = due > u->time_ns ? due : u->time_ns;
        fzm1_measure_due(u);
        fzm1_command_due(u);
        fzm1_output_due(u);
        start_due(u);
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
    u->ready = fzm1_ready(u);
    u->busy = fzm1_busy(u);
    u->exe_level = (u->levels & FZM1_EXE) != 0;
    u->step_level = (u->levels & FZM1_STEP) != 0;
    u->dsa_level = (u->levels & FZM1_DSA) != 0;
    u->gate_level = u->gate;
    u->flg_level = u->flg;
    u->continuous_level = u->continuous;
    u->control_out = bit(u->flg, FZM1_FLG) | bit(u->busy, FZM1_BUSY) | bit(u->ready, FZM1_READY) |
                     bit(up && u->overall_ng, FZM1_OR) | bit(up && u->run, FZM1_RUN) | bit(up && u->err, FZM1_ERR) |
                     bit(u->gate, FZM1_GATE);
}

/* The first levels after OP was entered are where edges are counted from: none of them starts anything. */
static void take_levels(fzm1_t *u, uint32_t levels)
{
    uint32_t rising = u->levels_known ? levels & ~u->levels : 0;
    u->levels = levels;
    u->levels_known = true;
    fzm1_exe(u, (rising & FZM1_EXE) != 0);
    if ((rising & FZM1_STEP) != 0)
        fzm1_step(u);
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

static void plant_defaults(fzm1_plant_t *p)
{
    *p = (fzm1_plant_t){.known = true,
                        .node_address = p->node_address,
                        .image_input_us = 5000,
                        .processing_us = 20000,
                        .command_us = 1000,
                        .switch_us = 100000,
                        .start_ms = 3000,
                        .seed = 1,
                        .random = 1};
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        p->amplitude[n] = 1;
        p->period[n] = 100;
    }
}

void fzm1_init(void *instance, const ect_identity_t *identity, const ect_host_t *host, uint64_t now_ns)
{
    fzm1_t *u = instance;
    u->standard.identity = *identity;
    u->host = host;
    u->time_ns = now_ns;
    if (!u->plant.known)
        plant_defaults(&u->plant);
    u->settings = (fzm1_settings_t){.fieldbus = 1, .output_period = 100, .output_time = 50, .timeout = 100};
    u->run = 1;
    u->start_due_ns = ECT_NEVER;
    all_off(u);
    fzm1_load(u);
    u->scene = u->scenes[u->scene_number];
    if (u->settings.fieldbus == 0)
        host->off_bus(host->ctx, true);
    publish(u);
}

uint16_t fzm1_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    fzm1_t *u = instance;
    advance(u, now_ns);
    if (from == ECT_STATE_OP || to == ECT_STATE_OP) { /* without process data all signals of the master are off */
        take_levels(u, 0);
        u->levels_known = false;
        settle(u);
    }
    publish(u);
    return 0;
}

void fzm1_outputs(void *instance, uint64_t now_ns)
{
    fzm1_t *u = instance;
    advance(u, now_ns);
    take_levels(u, u->control_in);
    settle(u);
    advance(u, now_ns); /* what takes no time */
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
