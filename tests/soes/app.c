/* SPDX-License-Identifier: MIT */
/* An application as a generator of SOES's world would write it, and its surroundings. */
#include "app.h"

app_t app;
unsigned int app_outputs, app_inputs;

#ifdef APP_RAW
uint8_t rxpdo[3];
uint8_t txpdo[3];
#endif

void cb_get_inputs(void)
{
    app_inputs++;
    app.position++;
#ifdef APP_RAW
    txpdo[0] = (uint8_t)(app.buttons[0] | app.buttons[1] << 1);
    txpdo[1] = (uint8_t)app.position;
    txpdo[2] = (uint8_t)(app.position >> 8);
#endif
}

void cb_set_outputs(void)
{
    app_outputs++;
#ifdef APP_RAW
    app.lamps[0] = rxpdo[0] & 1;
    app.lamps[1] = rxpdo[0] >> 1 & 1;
    app.speed = (uint16_t)(rxpdo[1] | rxpdo[2] << 8);
#endif
}

static const char acName1000[] = "Device Type";
static const char acName1008[] = "Device Name";
static const char acName1009[] = "Hardware Version";
static const char acName1018[] = "Identity Object";
static const char acNameCount[] = "Max SubIndex";
static const char acNameEntry[] = "Entry";

const _objd SDO1000[] = {
    {0x0, DTYPE_UNSIGNED32, 32, ATYPE_RO, acName1000, 0x01901389, NULL},
};
const _objd SDO1008[] = {
    {0x0, DTYPE_VISIBLE_STRING, 88, ATYPE_RO, acName1008, 0, "test device"},
};
const _objd SDO1009[] = {
    {0x0, DTYPE_VISIBLE_STRING, 0, ATYPE_RO, acName1009, 0, "1.0"},
};
const _objd SDO1018[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 4, NULL},
    {0x01, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x1337, NULL},
    {0x02, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 1234, NULL},
    {0x03, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 2, NULL},
    {0x04, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x00000000, NULL},
};
const _objd SDO1600[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 4, NULL},
    {0x01, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x70000101, NULL},
    {0x02, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x70000201, NULL},
    {0x03, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x00000006, NULL},
    {0x04, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x70010010, NULL},
};
const _objd SDO1601[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RWpre, acNameCount, 1, &app.count_1601},
    {0x01, DTYPE_UNSIGNED32, 32, ATYPE_RWpre, acNameEntry, 0x80000220, &app.mapped_1601[0]},
    {0x02, DTYPE_UNSIGNED32, 32, ATYPE_RWpre, acNameEntry, 0, &app.mapped_1601[1]},
    {0x03, DTYPE_UNSIGNED32, 32, ATYPE_RWpre, acNameEntry, 0, &app.mapped_1601[2]},
};
const _objd SDO1A00[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 4, NULL},
    {0x01, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x60000101, NULL},
    {0x02, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x60000201, NULL},
    {0x03, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x00000006, NULL},
    {0x04, DTYPE_UNSIGNED32, 32, ATYPE_RO, acNameEntry, 0x60010010, NULL},
};
const _objd SDO1C00[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 4, NULL},
    {0x01, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameEntry, 1, NULL},
    {0x02, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameEntry, 2, NULL},
    {0x03, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameEntry, 3, NULL},
    {0x04, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameEntry, 4, NULL},
};
const _objd SDO1C12[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RWpre, acNameCount, 1, &app.count_1c12},
    {0x01, DTYPE_UNSIGNED16, 16, ATYPE_RWpre, acNameEntry, 0x1600, &app.assigned_1c12[0]},
    {0x02, DTYPE_UNSIGNED16, 16, ATYPE_RWpre, acNameEntry, 0, &app.assigned_1c12[1]},
};
const _objd SDO1C13[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 1, NULL},
    {0x01, DTYPE_UNSIGNED16, 16, ATYPE_RO, acNameEntry, 0x1A00, NULL},
};
const _objd SDO6000[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 2, NULL},
    {0x01, DTYPE_BOOLEAN, 1, ATYPE_RO | ATYPE_TXPDO, acNameEntry, 0, &app.buttons[0]},
    {0x02, DTYPE_BOOLEAN, 1, ATYPE_RO | ATYPE_TXPDO, acNameEntry, 0, &app.buttons[1]},
};
const _objd SDO6001[] = {
    {0x0, DTYPE_UNSIGNED16, 16, ATYPE_RO | ATYPE_TXPDO, acNameEntry, 0, &app.position},
};
const _objd SDO7000[] = {
    /* mapped, and not called mappable: as the lists of SOES's demos */
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 2, NULL},
    {0x01, DTYPE_BOOLEAN, 1, ATYPE_RO, acNameEntry, 0, &app.lamps[0]},
    {0x02, DTYPE_BOOLEAN, 1, ATYPE_RO, acNameEntry, 0, &app.lamps[1]},
};
const _objd SDO7001[] = {
    {0x0, DTYPE_UNSIGNED16, 16, ATYPE_RO, acNameEntry, 0, &app.speed},
};
const _objd SDO8000[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 5, NULL},
    {0x02, DTYPE_UNSIGNED32, 32, ATYPE_RW, acNameEntry, 1000, &app.gain},
    {0x05, DTYPE_INTEGER16, 16, ATYPE_RW, acNameEntry, 0, &app.offset},
};
const _objd SDO8001[] = {
    {0x0, DTYPE_VISIBLE_STRING, 1600, ATYPE_RW, acNameEntry, 0, &app.label},
};
const _objd SDO8002[] = {
    {0x00, DTYPE_UNSIGNED8, 8, ATYPE_RO, acNameCount, 2, NULL},
    {0x01, DTYPE_UNSIGNED8, 8, ATYPE_RW, acNameEntry, 7, &app.bits[0]},
    {0x02, DTYPE_UNSIGNED8, 8, ATYPE_RW, acNameEntry, 0, &app.bits[1]},
};

const _objectlist SDOobjects[] = {
    {0x1000, OTYPE_VAR, 0, 0, acName1000, SDO1000},      {0x1008, OTYPE_VAR, 0, 0, acName1008, SDO1008},
    {0x1009, OTYPE_VAR, 0, 0, acName1009, SDO1009},      {0x1018, OTYPE_RECORD, 4, 0, acName1018, SDO1018},
    {0x1600, OTYPE_RECORD, 4, 0, "Outputs", SDO1600},    {0x1601, OTYPE_RECORD, 3, 0, "More outputs", SDO1601},
    {0x1A00, OTYPE_RECORD, 4, 0, "Inputs", SDO1A00},     {0x1C00, OTYPE_ARRAY, 4, 0, "SM types", SDO1C00},
    {0x1C12, OTYPE_ARRAY, 2, 0, "SM2 PDOs", SDO1C12},    {0x1C13, OTYPE_ARRAY, 1, 0, "SM3 PDOs", SDO1C13},
    {0x6000, OTYPE_RECORD, 2, 0, "Buttons", SDO6000},    {0x6001, OTYPE_VAR, 0, 0, "Position", SDO6001},
    {0x7000, OTYPE_RECORD, 2, 0, "Lamps", SDO7000},      {0x7001, OTYPE_VAR, 0, 0, "Speed", SDO7001},
    {0x8000, OTYPE_RECORD, 2, 0, "Parameters", SDO8000}, {0x8001, OTYPE_VAR, 0, 0, "Label", SDO8001},
    {0x8002, OTYPE_RECORD, 2, 0, "Bits", SDO8002},       {0xffff, 0xff, 0xff, 0xff, NULL, NULL}};
