/* SPDX-License-Identifier: MIT */
/* Control signals, command codes and settings by name (Q179 §3-2, §4-1, §4-3). */
#include "devices/fzm1/instance.h"

static const ect_value_name_t codes[] = {
    {0, "None"},
    {FZM1_START_CONTINUOUS, "Start continuous measurement"},
    {FZM1_END_CONTINUOUS, "End continuous measurement"},
    {FZM1_CLEAR, "Clear measurement value"},
    {FZM1_SAVE, "Save to unit"},
    {FZM1_RESTART, "Restart"},
    {FZM1_GET_SCENE, "Get scene number"},
    {FZM1_GET_GROUP, "Get scene group number"},
    {FZM1_SWITCH_SCENE, "Switch scene"},
    {FZM1_SWITCH_GROUP, "Switch scene group"},
    {FZM1_GET_UNIT_DATA, "Get unit data"},
    {FZM1_SET_UNIT_DATA, "Set unit data"},
    {0, NULL},
};
static const ect_value_name_t results[] = {{0, "OK"}, {UINT32_MAX, "NG"}, {0, NULL}};
static const ect_value_name_t controls[] = {{FZM1_NONE, "None"}, {FZM1_HANDSHAKING, "Handshaking"}, {0, NULL}};
static const ect_value_name_t formats[] = {
    {FZM1_FIXED_POINT, "Fixed point"}, {FZM1_FLOATING, "Floating point"}, {0, NULL}};

const ect_field_t fzm1_fields[] = {
    ECT_FIELD_BIT(0x2100, 1, 0, "EXE", "execute the command", "exe"),
    ECT_FIELD_BIT(0x2100, 1, 1, "STEP", "rising edge: measure once", "step"),
    ECT_FIELD_BIT(0x2100, 1, 16, "DSA", "output the next data", "dsa"),
    ECT_FIELD_VALUES(0x2100, 2, codes, NULL),
    ECT_FIELD_BIT(0x2200, 1, 0, "FLG", "the command is done, its response is valid", "flg"),
    ECT_FIELD_BIT(0x2200, 1, 1, "BUSY", "measuring, or switching a scene", "busy"),
    ECT_FIELD_BIT(0x2200, 1, 2, "READY", "STEP can be accepted", "ready"),
    ECT_FIELD_BIT(0x2200, 1, 3, "OR", "overall judgement: on when NG", "or"),
    ECT_FIELD_BIT(0x2200, 1, 4, "RUN", "the RUN window is shown", "run"),
    ECT_FIELD_BIT(0x2200, 1, 15, "ERR", "controller error", "err"),
    ECT_FIELD_BIT(0x2200, 1, 16, "GATE", "the output data are valid", "gate"),
    ECT_FIELD_VALUES(0x2200, 2, codes, NULL),
    ECT_FIELD_VALUES(0x2200, 3, results, NULL),
    ECT_FIELD_VALUES(0x2400, 1, controls, "output_control"),
    ECT_FIELD_VALUES(0x2400, 5, formats, "output_format"),
    {0},
};
