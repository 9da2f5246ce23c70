/* SPDX-License-Identifier: MIT */
/* The objects of a drive over a dictionary, and their entries in the dictionary. */
#include "profiles/cia402/values.h"

#include "profiles/cia402/axis.h"

enum { PLAIN = false, TURN = true };
#define ROW(name, index, subindex, kind, scale, initial) {index, subindex, ECT_402_##kind, scale, initial},
static const ect_402_object_t objects[ECT_402_VALUE_COUNT] = {ECT_402_VALUES(ROW)};

const ect_402_object_t *ect_402_object(ect_402_value_t value)
{
    return &objects[value];
}

bool ect_402_value_of(uint16_t index, uint8_t subindex, ect_402_value_t *value)
{
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++) {
        if (objects[i].index == index && objects[i].subindex == subindex) {
            *value = (ect_402_value_t)i;
            return true;
        }
    }
    return false;
}

/* --- links -------------------------------------------------------------------------------------------------------- */

bool ect_402_links_find(const ect_od_t *od, unsigned int axis, ect_402_link_t *links)
{
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++)
        links[i] = ect_link_to(od, (uint16_t)(objects[i].index + axis * ECT_402_AXIS_OBJECTS), objects[i].subindex);
    links[ECT_402_V_CYCLE_POWER].is_signed = true; /* never positive, unsigned in twins of ENI */
    return links[ECT_402_V_CONTROL].bytes != 0 && links[ECT_402_V_STATUS].bytes != 0;
}

/* --- modes -------------------------------------------------------------------------------------------------------- */

uint32_t ect_402_modes_of(const ect_402_link_t *links)
{
    static const struct {
        uint8_t mode, first, second;
    } needs[] = {
        {ECT_402_PP, ECT_402_V_TARGET_POSITION, ECT_402_V_TASK_SPEED},
        {ECT_402_PV, ECT_402_V_TARGET_SPEED, ECT_402_V_ACCELERATION},
        {ECT_402_TQ, ECT_402_V_TARGET_TORQUE, ECT_402_V_TORQUE_SLOPE},
        {ECT_402_HM, ECT_402_V_HOME_METHOD, ECT_402_V_HOME_METHOD},
        {ECT_402_IP, ECT_402_V_RECORD, ECT_402_V_RECORD},
        {ECT_402_CSP, ECT_402_V_TARGET_POSITION, ECT_402_V_TARGET_POSITION},
        {ECT_402_CSV, ECT_402_V_TARGET_SPEED, ECT_402_V_TARGET_SPEED},
        {ECT_402_CST, ECT_402_V_TARGET_TORQUE, ECT_402_V_TARGET_TORQUE},
    };
    uint32_t modes = 0;
    for (unsigned int i = 0; i < sizeof needs / sizeof needs[0]; i++) {
        if (links[needs[i].first].bytes != 0 && links[needs[i].second].bytes != 0)
            modes |= 1u << (needs[i].mode - 1);
    }
    return modes;
}
