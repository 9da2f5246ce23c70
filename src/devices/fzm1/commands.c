/* SPDX-License-Identifier: MIT */
/*
 * EXE, FLG and the eleven commands (Q179 §4-3, §4-4). A command is taken at the rising edge of EXE, with the parameters
 * of that moment. FLG rises when echo, response code and data are stored, and falls with EXE.
 */
#include "devices/fzm1/instance.h"

#define TENTH_S 100000000ull
#define AGAIN   1000000ull /* interval for a command that waits for a manual save */

/* Unit data in the response area are multiplied by 1000. The functions below return FZM1_DONE, or the reason of a
 * refusal. */
static fzm1_why_t get_unit_data(const fzm1_t *u, int32_t *value)
{
    uint32_t unit = (uint32_t)u->arguments[0];
    uint32_t number = (uint32_t)u->arguments[1];
    bool data = number >= FZM1_REF_DATA0 && number <= FZM1_REF_DATA7;
    if (unit >= u->scene.units)
        return FZM1_WHY_NO_UNIT;
    if (!data && number != FZM1_REF_JUDGEMENT && number != FZM1_REF_FORMAT)
        return FZM1_WHY_NO_DATA;
    if (number != FZM1_REF_JUDGEMENT && unit != u->scene.output_unit)
        return FZM1_WHY_JUDGEMENT_ONLY;
    if (data)
        *value = fzm1_fixed_point(u->last.data[number - FZM1_REF_DATA0]);
    else
        *value = 1000 * (number == FZM1_REF_FORMAT ? u->scene.format : u->last.judgement[unit]);
    return FZM1_DONE;
}

static fzm1_why_t set_unit_data(fzm1_t *u)
{
    int32_t value = u->arguments[2];
    if ((uint32_t)u->arguments[0] != u->scene.output_unit)
        return FZM1_WHY_NOT_OUTPUT;
    if (u->arguments[1] != FZM1_REF_FORMAT)
        return FZM1_WHY_FORMAT_ONLY;
    if (value != FZM1_FIXED_POINT * 1000 && value != FZM1_FLOATING * 1000)
        return FZM1_WHY_FORMAT_DATA;
    u->scene.format = (uint8_t)(value / 1000);
    return FZM1_DONE;
}

static fzm1_why_t start_continuous(fzm1_t *u)
{
    fzm1_why_t why = fzm1_not_ready(u);
    if (why == FZM1_DONE)
        fzm1_start_continuous(u);
    return why;
}

/* @param[out] data  response data, of commands with response data */
static fzm1_why_t execute(fzm1_t *u, int32_t *data)
{
    switch (u->code) {
    case FZM1_START_CONTINUOUS:
        return start_continuous(u);
    case FZM1_END_CONTINUOUS:
        u->continuous = false;
        return FZM1_DONE;
    case FZM1_CLEAR:
        fzm1_clear(u);
        fzm1_output_discard(u);
        fzm1_end_errors(u, FZM1_ERROR_ALL);
        return FZM1_DONE;
    case FZM1_SAVE:
        return u->saving.failure; /* the save has ended, see finish() */
    case FZM1_GET_SCENE:
        *data = u->scene_number;
        return FZM1_DONE;
    case FZM1_GET_GROUP:
        *data = u->scene_group;
        return FZM1_DONE;
    case FZM1_SWITCH_SCENE:
        return fzm1_switch_scene(u, (uint32_t)u->arguments[0]);
    case FZM1_SWITCH_GROUP:
        return fzm1_switch_group(u, (uint32_t)u->arguments[0]);
    case FZM1_GET_UNIT_DATA:
        return get_unit_data(u, data);
    case FZM1_SET_UNIT_DATA:
        return set_unit_data(u);
    default:
        return FZM1_WHY_NO_COMMAND;
    }
}

/* @return whether a command is taken at any time: Clear, End continuous, Restart */
static bool always_taken(uint32_t code)
{
    return code == FZM1_CLEAR || code == FZM1_END_CONTINUOUS || code == FZM1_RESTART;
}

static bool switches(const fzm1_t *u)
{
    uint32_t number = (uint32_t)u->arguments[0];
    return (u->code == FZM1_SWITCH_SCENE && number < FZM1_SCENES) ||
           (u->code == FZM1_SWITCH_GROUP && number < FZM1_GROUPS);
}

static void start(fzm1_t *u, uint32_t code, bool exe_fell)
{
    u->code = code;
    u->executing = true;
    u->exe_fell = exe_fell;
    u->switching = switches(u);
    u->command_due_ns = u->time_ns + (u->switching ? u->plant.switch_us : u->plant.command_us) * 1000ull;
}

static void answer(fzm1_t *u, fzm1_why_t why, int32_t data)
{
    u->executing = false;
    u->switching = false;
    if (why != FZM1_DONE)
        fzm1_refuse(&u->refused, why);
    u->response_code = u->code;
    u->result_code = (uint32_t)(why != FZM1_DONE ? FZM1_NG : FZM1_OK);
    u->response_data = why != FZM1_DONE ? 0 : data;
    u->flg = !u->exe_fell; /* after an early fall of EXE the response has no FLG, because no later edge would end it */
    if (u->flg && u->settings.exe_timeout > 0)
        u->flg_due_ns = u->time_ns + u->settings.exe_timeout * TENTH_S;
    if (u->next_code != 0)
        start(u, u->next_code, u->next_exe_fell);
    u->next_code = 0;
}

static void finish(fzm1_t *u)
{
    int32_t data = 0;
    bool touches_scenes = u->code == FZM1_SAVE || u->code == FZM1_SWITCH_SCENE || u->code == FZM1_SWITCH_GROUP;
    u->command_due_ns = touches_scenes && fzm1_saving(u) ? u->time_ns + AGAIN : ECT_NEVER;
    if (u->command_due_ns != ECT_NEVER)
        return;
    u->awaits_save = u->code == FZM1_SAVE && fzm1_save(u) == FZM1_DONE;
    if (u->code == FZM1_RESTART) {
        fzm1_begin_restart(u);
    } else if (!u->awaits_save) {
        fzm1_why_t why = execute(u, &data);
        answer(u, why, data);
    }
}

/* @return FZM1_DONE: a command with this code may be taken; else the reason of the refusal */
static fzm1_why_t not_taken(const fzm1_t *u, uint32_t code)
{
    if (u->starting != 0)
        return FZM1_WHY_RESTARTING;
    if (always_taken(code))
        return u->next_code != 0 && code != FZM1_RESTART ? FZM1_WHY_TWO_COMMANDS : FZM1_DONE;
    if (u->executing)
        return FZM1_WHY_EXECUTING;
    if (u->continuous)
        return FZM1_WHY_BUSY_CONTINUOUS;
    return fzm1_busy(u) ? FZM1_WHY_BUSY_MEASURING : FZM1_DONE;
}

/* Clear and End continuous wait for the end of the present command; Restart does not. */
static void take(fzm1_t *u)
{
    if (u->executing && u->command_code != FZM1_RESTART) {
        u->next_code = u->command_code;
        u->next_exe_fell = false;
        return;
    }
    for (unsigned int i = 0; i < 3; i++)
        u->arguments[i] = u->parameter[i];
    u->next_code = 0;
    start(u, u->command_code, false);
}

void fzm1_exe(fzm1_t *u, bool rising)
{
    if ((u->levels & FZM1_EXE) == 0) {
        if (u->flg)
            fzm1_end_errors(u, FZM1_ERROR_EXE); /* other commands do not have this error */
        u->exe_fell = u->next_exe_fell = true;
        u->flg = false;
        u->flg_due_ns = ECT_NEVER;
    } else if (rising) {
        fzm1_why_t why = not_taken(u, u->command_code);
        if (why != FZM1_DONE)
            fzm1_refuse(&u->exe_ignored, why);
        else
            take(u);
    }
}

void fzm1_command_due(fzm1_t *u)
{
    if (u->command_due_ns <= u->time_ns)
        finish(u);
    if (u->awaits_save && !fzm1_saving(u)) {
        u->awaits_save = false;
        answer(u, u->saving.failure, 0);
    }
    if (u->flg_due_ns <= u->time_ns) {
        u->flg_due_ns = ECT_NEVER;
        u->flg = false;
        fzm1_set_error(u, FZM1_ERROR_EXE);
    }
}
