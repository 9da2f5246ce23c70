/* SPDX-License-Identifier: MIT */
/* Restart (Q179 §4-3): no response, the signals off, the slave off the bus, then a power cycle. */
#include "devices/fzm1/instance.h"

enum { SHOWN_OFF_NS = 20000000 }; /* time of the signals off before a restart takes the slave off the bus */
enum { STARTING_OFF = 1, STARTING_AWAY = 2 };

void fzm1_all_off(fzm1_t *u)
{
    u->continuous = u->executing = u->switching = u->flg = u->awaits_save = false;
    u->image_count = u->output_count = 0;
    u->next_code = 0;
    u->image_due_ns = u->processing_due_ns = u->command_due_ns = u->flg_due_ns = u->switched_due_ns = ECT_NEVER;
    fzm1_output_reset(u);
}

void fzm1_begin_restart(fzm1_t *u)
{
    fzm1_all_off(u);
    u->starting = STARTING_OFF;
    u->start_due_ns = u->time_ns + SHOWN_OFF_NS;
}

void fzm1_restart_due(fzm1_t *u)
{
    if (u->start_due_ns > u->time_ns)
        return;
    u->start_due_ns = ECT_NEVER;
    if (u->starting == STARTING_OFF) {
        u->starting = STARTING_AWAY;
        u->start_due_ns = u->time_ns + u->plant.start_ms * 1000000ull;
        u->host->off_bus(u->host->ctx, true);
    } else if (fzm1_saving(u)) {
        u->start_due_ns = u->time_ns + 1000000; /* a save under way is completed first */
    } else {
        u->host->restart(u->host->ctx);
    }
}
