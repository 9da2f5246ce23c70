/* SPDX-License-Identifier: MIT */
/* The objects of a SOES application that uses each feature of SOES's lists. */
#include "everything.h"

everything_t everything;

void cb_get_inputs(void)
{
    everything.twelfth++;
}

void cb_set_outputs(void)
{
    everything.outputs++;
}

/* Sub-indices 1, 5, 12: `maxsub` is the position of the last entry, 3. */
static const _objd sparse[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 12, NULL},
    {1, DTYPE_UNSIGNED8, 8, ATYPE_RO | ATYPE_TXPDO, "First", 0, &everything.first},
    {5, DTYPE_UNSIGNED16, 16, ATYPE_RO | ATYPE_TXPDO, "Fifth", 0, &everything.fifth},
    {12, DTYPE_UNSIGNED32, 32, ATYPE_RO | ATYPE_TXPDO, "Twelfth", 0, &everything.twelfth},
};
static const _objd device_type[] = {{0, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Device Type", 5001, NULL}};
static const _objd device_name[] = {{0, DTYPE_VISIBLE_STRING, 80, ATYPE_RO, "Device Name", 0, "everything"}};
static const _objd identity[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 4, NULL},
    {1, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Vendor ID", 0x1337, NULL},
    {2, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Product Code", 7, NULL},
    {3, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Revision", 1, NULL},
    {4, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Serial Number", 0, NULL},
};
static const _objd outputs_mapping[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 1, NULL},
    {1, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Mapped", 0x70000908, NULL},
};
static const _objd inputs_mapping[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 2, NULL},
    {1, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Mapped", 0x60000C20, NULL},
    {2, DTYPE_UNSIGNED32, 32, ATYPE_RO, "Mapped", 0x60000510, NULL},
};
static const _objd sm_types[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 4, NULL}, {1, DTYPE_UNSIGNED8, 8, ATYPE_RO, "SM0", 1, NULL},
    {2, DTYPE_UNSIGNED8, 8, ATYPE_RO, "SM1", 2, NULL},          {3, DTYPE_UNSIGNED8, 8, ATYPE_RO, "SM2", 3, NULL},
    {4, DTYPE_UNSIGNED8, 8, ATYPE_RO, "SM3", 4, NULL},
};
static const _objd outputs_assignment[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 1, NULL},
    {1, DTYPE_UNSIGNED16, 16, ATYPE_RO, "PDO", 0x1600, NULL},
};
static const _objd inputs_assignment[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 1, NULL},
    {1, DTYPE_UNSIGNED16, 16, ATYPE_RO, "PDO", 0x1A00, NULL},
};
static const _objd sparse_outputs[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 9, NULL},
    {9, DTYPE_UNSIGNED8, 8, ATYPE_RW | ATYPE_RXPDO, "Ninth", 0, &everything.ninth},
};
static const _objd settings[] = {
    {0, DTYPE_UNSIGNED8, 8, ATYPE_RO, "Max SubIndex", 20, NULL},
    {3, DTYPE_UNSIGNED16, 16, ATYPE_RW, "Third", 0x0303, &everything.third},
    {20, DTYPE_UNSIGNED32, 32, ATYPE_RW, "Twentieth", 0x20202020, &everything.twentieth},
};
static const _objd octets[] = {{0, DTYPE_OCTET_STRING, 64, ATYPE_RW, "Octets", 0, everything.octets}};
static const _objd text[] = {{0, DTYPE_VISIBLE_STRING, 64, ATYPE_RW, "Text", 0, everything.text}};
static const _objd measured[] = {{0, DTYPE_OCTET_STRING, 128, ATYPE_RO, "Measured", 0, everything.measured}};

const _objectlist SDOobjects[] = {
    {0x1000, OTYPE_VAR, 0, 0, "Device Type", device_type},
    {0x1008, OTYPE_VAR, 0, 0, "Device Name", device_name},
    {0x1018, OTYPE_RECORD, 4, 0, "Identity", identity},
    {0x1600, OTYPE_RECORD, 1, 0, "Outputs", outputs_mapping},
    {0x1A00, OTYPE_RECORD, 2, 0, "Inputs", inputs_mapping},
    {0x1C00, OTYPE_ARRAY, 4, 0, "SM types", sm_types},
    {0x1C12, OTYPE_ARRAY, 1, 0, "SM2 PDOs", outputs_assignment},
    {0x1C13, OTYPE_ARRAY, 1, 0, "SM3 PDOs", inputs_assignment},
    {0x6000, OTYPE_RECORD, 3, 0, "Sparse", sparse},
    {0x7000, OTYPE_RECORD, 1, 0, "Sparse outputs", sparse_outputs},
    {0x8000, OTYPE_RECORD, 2, 0, "Settings", settings},
    {0x8001, OTYPE_VAR, 0, 0, "Octets", octets},
    {0x8002, OTYPE_VAR, 0, 0, "Text", text},
    {0x8003, OTYPE_VAR, 0, 0, "Measured", measured},
    {0xffff, 0xff, 0xff, 0xff, NULL, NULL},
};
