/* SPDX-License-Identifier: MIT */
/*
 * Commands, both ways, each exactly once (TS-0007 §10.1, §10.2).
 *
 * From a remote: CCI counts when the next command stands in the input data, and that is when the controller has
 * acknowledged the one before (CAO = CCI). To the remotes: a change of CCO is a command; CAI acknowledges it.
 */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

bool eclink_queue_put(eclink_queue_t *queue, const eclink_command_t *command)
{
    if (queue->count == ECLINK_QUEUE)
        return false;
    queue->commands[(queue->first + queue->count) % ECLINK_QUEUE] = *command;
    queue->count++;
    return true;
}

bool eclink_queue_take(eclink_queue_t *queue, eclink_command_t *command)
{
    if (queue->count == 0)
        return false;
    *command = queue->commands[queue->first];
    queue->first = (uint8_t)((queue->first + 1) % ECLINK_QUEUE);
    queue->count--;
    return true;
}

/* The time-out runs from the moment on which a command is there and unacknowledged. */
static void supervise_cao(eclink_t *unit, uint64_t now_ns)
{
    if (unit->outputs[ECLINK_OUT_CAO] == unit->bu.cci)
        unit->cao_deadline_ns = ECT_NEVER;
    else if (unit->cao_deadline_ns == ECT_NEVER)
        unit->cao_deadline_ns = now_ns + ECLINK_SUPERVISION_NS;
}

void eclink_show_command(eclink_t *unit, uint64_t now_ns)
{
    eclink_command_t command;
    if (unit->outputs[ECLINK_OUT_CAO] != unit->bu.cci || !eclink_queue_take(&unit->from_ru, &command))
        return;
    unit->bu.cci++;
    ect_store_be16(unit->inputs + ECLINK_IN_COMMAND_RU, command.ru);
    memcpy(unit->inputs + ECLINK_IN_COMMAND, command.data, sizeof command.data);
    supervise_cao(unit, now_ns);
}

static void take_command(eclink_t *unit)
{
    eclink_command_t command = {.ru = ect_load_be16(unit->outputs + ECLINK_OUT_COMMAND_RU)};
    memcpy(command.data, unit->outputs + ECLINK_OUT_COMMAND, sizeof command.data);
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        eclink_ru_t *ru = &unit->ru[i];
        bool addressed = command.ru == 0 || command.ru == ru->id;
        if (eclink_reachable(ru) && addressed && !eclink_queue_put(&ru->to_ru, &command))
            unit->bu.overflows++;
    }
}

/* A controller that has just come (back) brings some value of CCO: only one more than the last is a command of its. */
void eclink_command_outputs(eclink_t *unit, bool first, uint64_t now_ns)
{
    uint8_t cco = unit->outputs[ECLINK_OUT_CCO];
    bool is_new = first ? cco == (uint8_t)(unit->last_cco + 1) && unit->good_once : cco != unit->last_cco;
    if (is_new)
        take_command(unit);
    unit->last_cco = cco;
    unit->bu.cai = cco;
    supervise_cao(unit, now_ns);
}

/* --- to the remotes ----------------------------------------------------------------------------------------------- */

static bool give_command(eclink_ru_t *ru)
{
    eclink_command_t command;
    if (!eclink_queue_take(&ru->to_ru, &command))
        return false;
    memcpy(ru->received, command.data, sizeof ru->received);
    ru->received_count++;
    return true;
}

/*
 * Once an update. On G-Link each remote takes a command and the periodic data; on fallback C-Link has room for one
 * thing: a command from the remote goes before a command to it, and periodic data come last (§10.6).
 */
void eclink_command_to_rus(eclink_t *unit)
{
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        eclink_ru_t *ru = &unit->ru[i];
        bool fallback = ru->g_link == ECLINK_LINK_FALLBACK;
        if (fallback && ru->sent > 0) {
            ru->sent--;
            continue;
        }
        ru->sent = 0;
        bool gave = give_command(ru);
        if (ru->periodic_waits && !(fallback && gave)) {
            ru->periodic_waits = false;
            ru->periodic_count++;
        }
    }
}
