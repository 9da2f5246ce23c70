/* SPDX-License-Identifier: MIT */
/*
 * EXE, FLG and the eleven commands (Q179 §4-3, §4-4). A command is taken at the rising edge of EXE, with the parameters
 * of that moment. FLG rises when echo, response code and data are stored, and falls with EXE.
 */
#include "devices/fzm1/instance.h"

#define TENTH_S 100000000ull

/* In the response area a thousandfold, as all unit data. */
static bool get_unit_data(const fzm1_t *u, int32_t *value)
{
    uint32_t unit = (uint32_t)u->arguments[0];
    uint32_t number = (uint32_t)u->arguments[1];
    if (unit >= u->scene.units || (number != FZM1_REF_JUDGEMENT && unit != u->scene.output_unit))
        return false;
    if (number == FZM1_REF_JUDGEMENT)
        *value = u->last.judgement[unit] * 1000; /* 0 before the first measurement */
    else if (number >= FZM1_REF_DATA0 && number <= FZM1_REF_DATA7)
        *value = fzm1_fixed_point(u->last.data[number - FZM1_REF_DATA0]);
    else if (number == FZM1_REF_FORMAT)
        *value = u->scene.format * 1000;
    else
        return false;
    return true;
}

static bool set_unit_data(fzm1_t *u)
{
    int32_t value = u->arguments[2];
    if ((uint32_t)u->arguments[0] != u->scene.output_unit || u->arguments[1] != FZM1_REF_FORMAT ||
        (value != FZM1_FIXED_POINT * 1000 && value != FZM1_FLOATING * 1000))
        return false;
    u->scene.format = (uint8_t)(value / 1000);
    return true;
}

static bool start_continuous(fzm1_t *u)
{
    if (!fzm1_ready(u))
        return false;
    fzm1_start_continuous(u);
    return true;
}

/* @return whether it could be done; *data is the response data of those that have any */
static bool execute(fzm1_t *u, int32_t *data)
{
    switch (u->code) {
    case FZM1_START_CONTINUOUS:
        return start_continuous(u);
    case FZM1_END_CONTINUOUS:
        u->continuous = false;
        return true;
    case FZM1_CLEAR:
        fzm1_clear(u);
        fzm1_output_discard(u);
        fzm1_set_error(u, FZM1_NO_ERROR);
        return true;
    case FZM1_SAVE:
        return fzm1_save(u);
    case FZM1_GET_SCENE:
        *data = u->scene_number;
        return true;
    case FZM1_GET_GROUP:
        *data = u->scene_group;
        return true;
    case FZM1_SWITCH_SCENE:
        return fzm1_switch_scene(u, (uint32_t)u->arguments[0]);
    case FZM1_SWITCH_GROUP:
        return fzm1_switch_group(u, (uint32_t)u->arguments[0]);
    case FZM1_GET_UNIT_DATA:
        return get_unit_data(u, data);
    case FZM1_SET_UNIT_DATA:
        return set_unit_data(u);
    default:
        return false;
    }
}

static void finish(fzm1_t *u)
{
    u->executing = false;
    u->switching = false;
    u->command_due_ns = ECT_NEVER;
    if (u->code == FZM1_RESTART) {
        fzm1_begin_restart(u);
        return;
    }
    int32_t data = 0;
    bool done = execute(u, &data);
    u->response_code = u->code;
    u->result_code = done ? (uint32_t)FZM1_OK : (uint32_t)FZM1_NG;
    u->response_data = data;
    u->flg = !u->exe_fell; /* an EXE that fell early has its answer, and no FLG that would have to fall */
    if (u->flg && u->settings.exe_timeout > 0)
        u->flg_due_ns = u->time_ns + u->settings.exe_timeout * TENTH_S;
}

static bool switches(const fzm1_t *u)
{
    uint32_t number = (uint32_t)u->arguments[0];
    return (u->code == FZM1_SWITCH_SCENE && number < FZM1_SCENES) ||
           (u->code == FZM1_SWITCH_GROUP && number < FZM1_GROUPS);
}

/* While BUSY nothing is accepted, but what ends a continuous measurement. */
static bool acceptable(const fzm1_t *u)
{
    bool ends = u->command_code == FZM1_END_CONTINUOUS || u->command_code == FZM1_RESTART;
    return u->starting == 0 && !u->executing && (!fzm1_busy(u) || (u->continuous && ends));
}

static void start(fzm1_t *u)
{
    u->code = u->command_code;
    for (unsigned int i = 0; i < 3; i++)
        u->arguments[i] = u->parameter[i];
    u->executing = true;
    u->exe_fell = false;
    u->switching = switches(u);
    u->command_due_ns = u->time_ns + (u->switching ? u->plant.switch_us : u->plant.command_us) * 1000ull;
}

void fzm1_exe(fzm1_t *u, bool rising)
{
    if ((u->levels & FZM1_EXE) == 0) {
        if (u->flg && u->error == FZM1_ERROR_EXE)
            fzm1_set_error(u, FZM1_NO_ERROR); /* this one went as it should */
        u->exe_fell = true;
        u->flg = false;
        u->flg_due_ns = ECT_NEVER;
    } else if (rising && acceptable(u)) {
        start(u);
    }
}

void fzm1_command_due(fzm1_t *u)
{
    if (u->command_due_ns <= u->time_ns)
        finish(u);
    if (u->flg_due_ns <= u->time_ns) {
        u->flg_due_ns = ECT_NEVER;
        u->flg = false;
        fzm1_set_error(u, FZM1_ERROR_EXE);
    }
}
