/* SPDX-License-Identifier: MIT */
/*
 * Commands in both directions, each executed exactly once (TS-0007 §10.1, §10.2).
 *
 * From a remote: the next command enters the input data, and CCI counts, after the controller has acknowledged the
 * previous one (CAO = CCI). To the remotes: a change of CCO is a command; CAI acknowledges the command when all its
 * receivers have room.
 */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

static bool put(eclink_queue_t *queue, const eclink_command_t *command)
{
    if (queue->count == ECLINK_QUEUE)
        return false;
    queue->commands[(queue->first + queue->count) % ECLINK_QUEUE] = *command;
    queue->count++;
    return true;
}

static bool take(eclink_queue_t *queue, eclink_command_t *command)
{
    if (queue->count == 0)
        return false;
    *command = queue->commands[queue->first];
    queue->first = (uint8_t)((queue->first + 1) % ECLINK_QUEUE);
    queue->count--;
    return true;
}

/* --- from the remotes --------------------------------------------------------------------------------------------- */

/* Evaluates CAO, only while a command waits for it. The timeout runs while data flow. */
static void watch_cao(eclink_t *unit, uint64_t now_ns)
{
    if (unit->cci_waits && unit->outputs[ECLINK_OUT_CAO] == unit->bu.cci)
        unit->cci_waits = false;
    if (!unit->cci_waits) {
        unit->cao_late = false;
        unit->cao_deadline_ns = ECT_NEVER;
    } else if (unit->cao_deadline_ns == ECT_NEVER) {
        unit->cao_deadline_ns = now_ns + ECLINK_SUPERVISION_NS;
    }
}

/* Drops commands that have waited longer than bu.command_lifetime, because an operator's command of an hour ago must
 * not start a machine when its controller returns. The command in the input data remains, because CCI has already
 * counted it. */
static void expire(eclink_t *unit, uint64_t now_ns)
{
    eclink_queue_t *queue = &unit->from_ru;
    uint64_t lifetime_ns = unit->bu.command_lifetime_ms * 1000000ull;
    eclink_command_t command;
    while (lifetime_ns > 0 && queue->count > 0 && now_ns - unit->sent_ns[queue->first] >= lifetime_ns) {
        (void)take(queue, &command);
        unit->bu.commands_expired++;
    }
}

bool eclink_command_from_ru(eclink_t *unit, const eclink_command_t *command, uint64_t now_ns)
{
    expire(unit, now_ns);
    unsigned int at = (unit->from_ru.first + unit->from_ru.count) % ECLINK_QUEUE;
    if (!put(&unit->from_ru, command))
        return false;
    unit->sent_ns[at] = now_ns;
    return true;
}

void eclink_show_command(eclink_t *unit, uint64_t now_ns)
{
    eclink_command_t command;
    expire(unit, now_ns);
    if (unit->cci_waits || !take(&unit->from_ru, &command))
        return;
    unit->bu.cci++;
    ect_store_be16(unit->inputs + ECLINK_IN_COMMAND_RU, command.ru);
    memcpy(unit->inputs + ECLINK_IN_COMMAND, command.data, sizeof command.data);
    unit->cci_waits = true;
    unit->cao_deadline_ns = now_ns + ECLINK_SUPERVISION_NS;
}

/* --- to the remotes ----------------------------------------------------------------------------------------------- */

static bool is_for(const eclink_command_t *command, const eclink_ru_t *ru)
{
    return eclink_reachable(ru) && (command->ru == 0 || command->ru == ru->id);
}

static bool id_is_known(const eclink_t *unit, uint16_t id)
{
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        if (unit->ru[i].id == id)
            return true;
    }
    return id == 0;
}

/* Acknowledges a command without a receiver too, because TS-0007 defines no other reply. */
static void count_undelivered(eclink_t *unit)
{
    if (id_is_known(unit, unit->waiting.ru))
        unit->bu.commands_unreached++;
    else
        unit->bu.commands_unknown++;
}

void eclink_pass_command(eclink_t *unit)
{
    bool delivered = false;
    if (!unit->cco_waits)
        return;
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        if (is_for(&unit->waiting, &unit->ru[i]) && unit->ru[i].to_ru.count == ECLINK_QUEUE)
            return;
    }
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        if (is_for(&unit->waiting, &unit->ru[i]))
            delivered |= put(&unit->ru[i].to_ru, &unit->waiting);
    }
    if (!delivered)
        count_undelivered(unit);
    unit->cco_waits = false;
    unit->bu.cai = unit->last_cco;
}

static void take_command(eclink_t *unit)
{
    unit->waiting.ru = ect_load_be16(unit->outputs + ECLINK_OUT_COMMAND_RU);
    memcpy(unit->waiting.data, unit->outputs + ECLINK_OUT_COMMAND, sizeof unit->waiting.data);
    unit->cco_waits = true;
}

/*
 * Evaluates CCO. In the first outputs of a controller, the last value plus one is a command, and any other value is a
 * start value. Later each change is a command; commands skipped by CCO are lost.
 */
static void watch_cco(eclink_t *unit, bool first)
{
    enum { BACKWARDS = 128 };
    uint8_t cco = unit->outputs[ECLINK_OUT_CCO];
    uint8_t step = (uint8_t)(cco - unit->last_cco);
    if (step == 0)
        return;
    unit->last_cco = cco;
    unit->bu.commands_lost += unit->cco_waits;
    unit->cco_waits = false;
    if (first && step != 1) {
        unit->bu.cco_resyncs++;
        unit->bu.cai = cco;
        return;
    }
    unit->bu.commands_lost += step < BACKWARDS ? step - 1u : 0;
    take_command(unit);
}

void eclink_command_outputs(eclink_t *unit, bool first, uint64_t now_ns)
{
    watch_cco(unit, first);
    eclink_pass_command(unit);
    watch_cao(unit, now_ns);
}

static bool give_command(eclink_ru_t *ru)
{
    eclink_command_t command;
    if (!take(&ru->to_ru, &command))
        return false;
    memcpy(ru->received, command.data, sizeof ru->received);
    ru->received_count++;
    return true;
}

/*
 * Called once in each update. On G-Link each remote gets a command and the periodic data; on fallback, C-Link transfers
 * one item: a command from the remote precedes a command to the remote, and periodic data come last (§10.6).
 */
void eclink_command_to_rus(eclink_t *unit)
{
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        eclink_ru_t *ru = &unit->ru[i];
        bool fallback = ru->path == ECLINK_PATH_C_LINK;
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
