/* SPDX-License-Identifier: MIT */
/* The states of TS-0007 chapter 8, as values of the input data: 2001h on the wire, 3001h for SDO browsers. */
#include "devices/eclink/instance.h"

static const ect_value_name_t bu_states[] = {
    {ECLINK_BU_INITIAL, "Initial"},
    {ECLINK_BU_STOPPED, "Stopped"},
    {ECLINK_BU_LINK_ERROR, "External link error"},
    {ECLINK_BU_BLOCKED, "Blocked"},
    {ECLINK_BU_FAILED, "Failed"},
    {ECLINK_BU_DISARMED, "Disarmed"},
    {ECLINK_BU_ARMED, "Armed"},
    {0, NULL},
};
static const ect_value_name_t links[] = {
    {ECLINK_LINK_UNUSED, "Unused"},
    {ECLINK_LINK_OPERATIONAL, "Operational"},
    {ECLINK_LINK_NONE, "No Link"},
    {ECLINK_LINK_ERROR, "Link error"},
    {ECLINK_LINK_INTERFACE_ERROR, "Interface Error"},
    {ECLINK_LINK_DATA_ERROR, "Data error"},
    {ECLINK_LINK_PASSIVE, "Passive"},
    {ECLINK_LINK_FALLBACK, "Fallback"},
    {0, NULL},
};
static const ect_value_name_t ru_states[] = {
    {ECLINK_RU_INITIAL, "Initial"},
    {1, "Disarmed"},
    {ECLINK_RU_ARMED, "Armed"},
    {ECLINK_RU_ENABLED, "Enabled"},
    {ECLINK_RU_STOPPED, "Stopped"},
    {ECLINK_RU_FAILED, "Failed"},
    {0, NULL},
};
static const ect_value_name_t disabled[] = {
    {0, "Enabled"}, {1, "Tilting"}, {2, "Inactivity"}, {3, "Warning popup not acknowledged"}, {0, NULL}};
static const ect_value_name_t cable[] = {{0, "Wireless"}, {1, "Cable"}, {0, NULL}};
static const ect_value_name_t docked[] = {{0, "Not docked"}, {1, "In docking station"}, {0, NULL}};
static const ect_value_name_t pushed[] = {{0, "Released"}, {1, "Pushed"}, {0, NULL}};

/* Sub-indices as in eclink.c: the base unit's fields are 1 to 13, a remote's begin at `first`. */
#define BASE_UNIT(index)                                                                                               \
    ECT_FIELD_VALUES(index, 8, bu_states, "bu.state"), ECT_FIELD_VALUES(index, 11, links, "bu.eg_link"),               \
        ECT_FIELD_VALUES(index, 12, links, "bu.ec_link")
#define REMOTE(index, first)                                                                                           \
    ECT_FIELD_VALUES(index, (first) + 1, ru_states, "ru.state"),                                                       \
        ECT_FIELD_VALUES(index, (first) + 4, cable, "ru.cable"),                                                       \
        ECT_FIELD_VALUES(index, (first) + 5, docked, "ru.docked"),                                                     \
        ECT_FIELD_VALUES(index, (first) + 6, disabled, "ru.disabled"),                                                 \
        ECT_FIELD_VALUES(index, (first) + 7, links, "ru.c_link"),                                                      \
        ECT_FIELD_VALUES(index, (first) + 8, links, "ru.g_link"),                                                      \
        ECT_FIELD_VALUES(index, (first) + 22, pushed, "ru.encoder_switch")
#define INPUTS(index) BASE_UNIT(index), REMOTE(index, 14), REMOTE(index, 38), REMOTE(index, 62)

const ect_field_t eclink_states[] = {INPUTS(0x2001), INPUTS(0x3001), {0}};
