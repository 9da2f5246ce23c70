/* SPDX-License-Identifier: MIT */
/*
 * The descriptions of the four base units. The lists below are the only definition of TS-0007's fields: the records
 * 2001h and 2002h, the mapping objects, the SII and the ESI follow from them.
 */
#include "devices/eclink/eclink.h"

#include "devices/eclink/instance.h"

/* Placeholders: Vision Remote's codes are not public. An installation overrides them. */
enum { PRODUCT_MAP1 = 0x0EC10001, PRODUCT_MAP3, PRODUCT_MAP7, PRODUCT_MULTIARM };
#define REVISION 0x00020000 /* Visionlinkserver 2.0 */

/* --- fields: F(sub-index, offset as in instance.h, kind, name)
 * ------------------------------------------------------------------- */

#define COMMON_INPUT_FIELDS(F)                                                                                         \
    F(1, ECLINK_IN_PCI, U8, "PCI")                                                                                     \
    F(2, ECLINK_IN_CCI, U8, "CCI")                                                                                     \
    F(3, ECLINK_IN_PAI, U8, "PAI")                                                                                     \
    F(4, ECLINK_IN_CAI, U8, "CAI")                                                                                     \
    F(5, ECLINK_IN_COMMAND_RU, U16, "Command RU ID")                                                                   \
    F(6, ECLINK_IN_COMMAND, HALF, "Command from RU 0..7")                                                              \
    F(7, ECLINK_IN_COMMAND + 8, HALF, "Command from RU 8..15")                                                         \
    F(8, ECLINK_IN_BU_STATE, U8, "BU state")                                                                           \
    F(9, ECLINK_IN_VLAPS, U8, "VLAPs")                                                                                 \
    F(10, ECLINK_IN_UNARMED, U8, "Unarmed RUs")                                                                        \
    F(11, ECLINK_IN_EG_LINK, U8, "EG-Link status")                                                                     \
    F(12, ECLINK_IN_EC_LINK, U8, "EC-Link status")                                                                     \
    F(13, ECLINK_IN_SPARE, U8, "Spare")

/* One remote unit: first sub-index s, first byte o, name R. */
#define RU_FIELDS(F, s, o, R)                                                                                          \
    F((s) + 0, (o) + ECLINK_RU_ID, U16, "Armed " R)                                                                    \
    F((s) + 1, (o) + ECLINK_RU_STATE, U8, R " state")                                                                  \
    F((s) + 2, (o) + ECLINK_RU_BATTERY, U8, R " battery")                                                              \
    F((s) + 3, (o) + ECLINK_RU_RSSI, U8, R " C-Link RSSI")                                                             \
    F((s) + 4, (o) + ECLINK_RU_CABLE, U8, R " cable")                                                                  \
    F((s) + 5, (o) + ECLINK_RU_DOCKED, U8, R " docked")                                                                \
    F((s) + 6, (o) + ECLINK_RU_DISABLED, U8, R " disabled")                                                            \
    F((s) + 7, (o) + ECLINK_RU_C_LINK, U8, R " C-Link status")                                                         \
    F((s) + 8, (o) + ECLINK_RU_G_LINK, U8, R " G-Link status")                                                         \
    F((s) + 9, (o) + ECLINK_RU_JOYSTICK, I16, R " joystick 1")                                                         \
    F((s) + 10, (o) + ECLINK_RU_JOYSTICK + 2, I16, R " joystick 2")                                                    \
    F((s) + 11, (o) + ECLINK_RU_JOYSTICK + 4, I16, R " joystick 3")                                                    \
    F((s) + 12, (o) + ECLINK_RU_JOYSTICK + 6, I16, R " joystick 4")                                                    \
    F((s) + 13, (o) + ECLINK_RU_SWITCH, I16, R " switch 1")                                                            \
    F((s) + 14, (o) + ECLINK_RU_SWITCH + 2, I16, R " switch 2")                                                        \
    F((s) + 15, (o) + ECLINK_RU_SWITCH + 4, I16, R " switch 3")                                                        \
    F((s) + 16, (o) + ECLINK_RU_SWITCH + 6, I16, R " switch 4")                                                        \
    F((s) + 17, (o) + ECLINK_RU_SWITCH + 8, I16, R " switch 5")                                                        \
    F((s) + 18, (o) + ECLINK_RU_SWITCH + 10, I16, R " switch 6")                                                       \
    F((s) + 19, (o) + ECLINK_RU_SWITCH + 12, I16, R " switch 7")                                                       \
    F((s) + 20, (o) + ECLINK_RU_SWITCH + 14, I16, R " switch 8")                                                       \
    F((s) + 21, (o) + ECLINK_RU_ENCODER, U8, R " encoder value")                                                       \
    F((s) + 22, (o) + ECLINK_RU_ENCODER_SWITCH, U8, R " encoder switch")                                               \
    F((s) + 23, (o) + ECLINK_RU_SPARE, U16, R " spare")

#define INPUT_FIELDS(F)                                                                                                \
    COMMON_INPUT_FIELDS(F)                                                                                             \
    RU_FIELDS(F, 14, ECLINK_IN_RU, "RU")
#define RU2_FIELDS(F) RU_FIELDS(F, 38, ECLINK_IN_RU + ECLINK_IN_RU_STRIDE, "RU2")
#define RU3_FIELDS(F) RU_FIELDS(F, 62, ECLINK_IN_RU + 2 * ECLINK_IN_RU_STRIDE, "RU3")
#define MULTIARM_INPUT_FIELDS(F)                                                                                       \
    INPUT_FIELDS(F)                                                                                                    \
    RU2_FIELDS(F)                                                                                                      \
    RU3_FIELDS(F)

#define COMMAND_FIELDS(F)                                                                                              \
    F(1, ECLINK_OUT_PCO, U8, "PCO")                                                                                    \
    F(2, ECLINK_OUT_CCO, U8, "CCO")                                                                                    \
    F(3, ECLINK_OUT_PAO, U8, "PAO")                                                                                    \
    F(4, ECLINK_OUT_CAO, U8, "CAO")                                                                                    \
    F(5, ECLINK_OUT_COMMAND_RU, U16, "Command RU ID")                                                                  \
    F(6, ECLINK_OUT_COMMAND, HALF, "Command to RU 0..7")                                                               \
    F(7, ECLINK_OUT_COMMAND + 8, HALF, "Command to RU 8..15")                                                          \
    F(8, ECLINK_OUT_SPARE, U16, "Spare 22..23")
#define PERIODIC_FIELDS(F)                                                                                             \
    F(9, ECLINK_OUT_PERIODIC_SIZE, U16, "Periodic data size")                                                          \
    F(10, ECLINK_OUT_PERIODIC_BLOCK, U8, "Periodic data block")                                                        \
    F(11, ECLINK_OUT_PERIODIC_SPARE, U8, "Spare 27")

/* The 200 periodic bytes in groups of eight: F(sub-index, first byte, last byte). */
#define PERIODIC_EIGHTS(F)                                                                                             \
    F(1, 0, 7)                                                                                                         \
    F(2, 8, 15)                                                                                                        \
    F(3, 16, 23)                                                                                                       \
    F(4, 24, 31)                                                                                                       \
    F(5, 32, 39)                                                                                                       \
    F(6, 40, 47)                                                                                                       \
    F(7, 48, 55)                                                                                                       \
    F(8, 56, 63)                                                                                                       \
    F(9, 64, 71)                                                                                                       \
    F(10, 72, 79)                                                                                                      \
    F(11, 80, 87)                                                                                                      \
    F(12, 88, 95)                                                                                                      \
    F(13, 96, 103)                                                                                                     \
    F(14, 104, 111)                                                                                                    \
    F(15, 112, 119)                                                                                                    \
    F(16, 120, 127)                                                                                                    \
    F(17, 128, 135)                                                                                                    \
    F(18, 136, 143)                                                                                                    \
    F(19, 144, 151)                                                                                                    \
    F(20, 152, 159)                                                                                                    \
    F(21, 160, 167)                                                                                                    \
    F(22, 168, 175)                                                                                                    \
    F(23, 176, 183)                                                                                                    \
    F(24, 184, 191)                                                                                                    \
    F(25, 192, 199)

/* Kinds of field. On the wire two bytes are an array, not a number: CoE numbers are little-endian, these are big-endian
 * (TS-0007 §2.2). 3001h and 3002h contain the same fields as numbers. */
enum { BYTES_U8 = 1, BYTES_U16 = 2, BYTES_I16 = 2, BYTES_HALF = 8 };
enum {
    WIRE_U8 = ECT_TYPE_UNSIGNED8,
    WIRE_U16 = ECT_TYPE_OCTET_STRING,
    WIRE_I16 = ECT_TYPE_OCTET_STRING,
    WIRE_HALF = ECT_TYPE_OCTET_STRING
};
enum {
    NUMBER_U8 = ECT_TYPE_UNSIGNED8,
    NUMBER_U16 = ECT_TYPE_UNSIGNED16,
    NUMBER_I16 = ECT_TYPE_INTEGER16,
    NUMBER_HALF = ECT_TYPE_OCTET_STRING
};

#define ENTRY(sub, type, kind, access, name, member)                                                                   \
    {sub, type##kind, 8 * BYTES_##kind, access, name, 0, ECT_OFFSET(eclink_t, member)},
#define INPUT_ENTRY(sub, offset, kind, name)                                                                           \
    ENTRY(sub, WIRE_, kind, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, name, inputs[offset])
#define OUTPUT_ENTRY(sub, offset, kind, name)                                                                          \
    ENTRY(sub, WIRE_, kind, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, name, outputs[offset])
#define INPUT_NUMBER(sub, offset, kind, name)  ENTRY(sub, NUMBER_, kind, ECT_ACCESS_RO, name, input_numbers[offset])
#define OUTPUT_NUMBER(sub, offset, kind, name) ENTRY(sub, NUMBER_, kind, ECT_ACCESS_RO, name, output_numbers[offset])
#define PERIODIC_ENTRY(sub, first, last)                                                                               \
    ENTRY(sub, WIRE_, HALF, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Periodic data " #first ".." #last,                      \
          outputs[ECLINK_OUT_PERIODIC + (first)])

#define INPUT_MAP(sub, offset, kind, name)  ECT_ENTRY_MAP(sub, ECT_MAP(0x2001, sub, 8 * BYTES_##kind)),
#define RU2_MAP(sub, offset, kind, name)    ECT_ENTRY_MAP((sub) - 37, ECT_MAP(0x2001, sub, 8 * BYTES_##kind)),
#define RU3_MAP(sub, offset, kind, name)    ECT_ENTRY_MAP((sub) - 61, ECT_MAP(0x2001, sub, 8 * BYTES_##kind)),
#define OUTPUT_MAP(sub, offset, kind, name) ECT_ENTRY_MAP(sub, ECT_MAP(0x2002, sub, 8 * BYTES_##kind)),
#define PERIODIC_MAP(sub, first, last)      ECT_ENTRY_MAP(11 + (sub), ECT_MAP(0x2003, sub, 8 * BYTES_HALF)),

static const ect_entry_t inputs_2001[] = {ECT_ENTRY_COUNT(37), INPUT_FIELDS(INPUT_ENTRY)};
static const ect_entry_t multiarm_2001[] = {ECT_ENTRY_COUNT(85), MULTIARM_INPUT_FIELDS(INPUT_ENTRY)};
static const ect_entry_t commands_2002[] = {ECT_ENTRY_COUNT(8), COMMAND_FIELDS(OUTPUT_ENTRY)};
static const ect_entry_t standard_2002[] = {ECT_ENTRY_COUNT(11),
                                            COMMAND_FIELDS(OUTPUT_ENTRY) PERIODIC_FIELDS(OUTPUT_ENTRY)};
static const ect_entry_t periodic_2003[] = {ECT_ENTRY_COUNT(25), PERIODIC_EIGHTS(PERIODIC_ENTRY)};

static const ect_entry_t inputs_3001[] = {ECT_ENTRY_COUNT(37), INPUT_FIELDS(INPUT_NUMBER)};
static const ect_entry_t multiarm_3001[] = {ECT_ENTRY_COUNT(85), MULTIARM_INPUT_FIELDS(INPUT_NUMBER)};
static const ect_entry_t commands_3002[] = {ECT_ENTRY_COUNT(8), COMMAND_FIELDS(OUTPUT_NUMBER)};
static const ect_entry_t standard_3002[] = {ECT_ENTRY_COUNT(11),
                                            COMMAND_FIELDS(OUTPUT_NUMBER) PERIODIC_FIELDS(OUTPUT_NUMBER)};

static const ect_entry_t inputs_1a00[] = {ECT_ENTRY_COUNT(37), INPUT_FIELDS(INPUT_MAP)};
static const ect_entry_t ru2_1a01[] = {ECT_ENTRY_COUNT(24), RU2_FIELDS(RU2_MAP)};
static const ect_entry_t ru3_1a02[] = {ECT_ENTRY_COUNT(24), RU3_FIELDS(RU3_MAP)};
static const ect_entry_t commands_1600[] = {ECT_ENTRY_COUNT(8), COMMAND_FIELDS(OUTPUT_MAP)};
static const ect_entry_t standard_1600[] = {ECT_ENTRY_COUNT(36), COMMAND_FIELDS(OUTPUT_MAP) PERIODIC_FIELDS(OUTPUT_MAP)
                                                                     PERIODIC_EIGHTS(PERIODIC_MAP)};

static const ect_entry_t assign_none[] = {ECT_ENTRY_COUNT(0)};
static const ect_entry_t assign_outputs[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t assign_inputs[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
static const ect_entry_t assign_three[] = {ECT_ENTRY_COUNT(3), ECT_ENTRY_ASSIGN(1, 0x1A00), ECT_ENTRY_ASSIGN(2, 0x1A01),
                                           ECT_ENTRY_ASSIGN(3, 0x1A02)};

/* --- object lists ------------------------------------------------------------------------------------------------ */

#define COMMUNICATION_OBJECTS                                                                                          \
    ECT_OBJECT_DEVICE_TYPE, ECT_OBJECT_ERROR_REGISTER, ECT_OBJECT_DEVICE_NAME, ECT_OBJECT_HARDWARE_VERSION,            \
        ECT_OBJECT_SOFTWARE_VERSION, ECT_OBJECT_IDENTITY

static const ect_object_t objects_map1[] = {
    COMMUNICATION_OBJECTS,
    ECT_RECORD(0x1A00, "Input data mapping", inputs_1a00),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", assign_none),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_inputs),
    ECT_RECORD(0x2001, "Input data", inputs_2001),
    ECT_RECORD(0x3001, "Input data as numbers", inputs_3001),
};

static const ect_object_t objects_map3[] = {
    COMMUNICATION_OBJECTS,
    ECT_RECORD(0x1600, "Output data mapping", commands_1600),
    ECT_RECORD(0x1A00, "Input data mapping", inputs_1a00),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", assign_outputs),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_inputs),
    ECT_RECORD(0x2001, "Input data", inputs_2001),
    ECT_RECORD(0x2002, "Output data", commands_2002),
    ECT_RECORD(0x3001, "Input data as numbers", inputs_3001),
    ECT_RECORD(0x3002, "Output data as numbers", commands_3002),
};

static const ect_object_t objects_map7[] = {
    COMMUNICATION_OBJECTS,
    ECT_RECORD(0x1600, "Output data mapping", standard_1600),
    ECT_RECORD(0x1A00, "Input data mapping", inputs_1a00),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", assign_outputs),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_inputs),
    ECT_RECORD(0x2001, "Input data", inputs_2001),
    ECT_RECORD(0x2002, "Output data", standard_2002),
    ECT_ARRAY(0x2003, "Periodic data", periodic_2003),
    ECT_RECORD(0x3001, "Input data as numbers", inputs_3001),
    ECT_RECORD(0x3002, "Output data as numbers", standard_3002),
};

static const ect_object_t objects_multiarm[] = {
    COMMUNICATION_OBJECTS,
    ECT_RECORD(0x1600, "Output data mapping", standard_1600),
    ECT_RECORD(0x1A00, "Input data mapping", inputs_1a00),
    ECT_RECORD(0x1A01, "Second RU mapping", ru2_1a01),
    ECT_RECORD(0x1A02, "Third RU mapping", ru3_1a02),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", assign_outputs),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_three),
    ECT_RECORD(0x2001, "Input data", multiarm_2001),
    ECT_RECORD(0x2002, "Output data", standard_2002),
    ECT_ARRAY(0x2003, "Periodic data", periodic_2003),
    ECT_RECORD(0x3001, "Input data as numbers", multiarm_3001),
    ECT_RECORD(0x3002, "Output data as numbers", standard_3002),
};

/* --- descriptions ------------------------------------------------------------------------------------------------ */

static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  NULL};

/* The Anybus CompactCom 40 inside the base unit: controller, mailboxes and timeouts. */
#define BASE_UNIT(cli_name, what, node_name, product, object_list, buffer_bytes)                                       \
    {                                                                                                                  \
        .name = cli_name,                                                                                              \
        .summary = what,                                                                                               \
        .vendor_name = ECTWIN_VENDOR_NAME,                                                                             \
        .type_name = node_name,                                                                                        \
        .group_type = "VR-BU",                                                                                         \
        .group_name = "Vision Remote base units",                                                                      \
        .hardware_version = "1.00",                                                                                    \
        .software_version = "2.0.0",                                                                                   \
        .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = product, .revision = REVISION, .serial = 1},       \
        .esc = "np40",                                                                                                 \
        .esc_config = {0x80, 0x36, 0x00, 0x46, 0xF4, 0x01},                                                            \
        .sii_size = 4096,                                                                                              \
        .sm = {{.start = 0x4000, .length = 276, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},                          \
               {.start = 0x4800, .length = 276, .control = 0x22, .type = ECT_SM_MAILBOX_IN},                           \
               {.start = 0x1000, .control = 0x64, .type = ECT_SM_OUTPUTS},                                             \
               {.start = 0x2800, .control = 0x20, .type = ECT_SM_INPUTS}},                                             \
        .sm_count = 4,                                                                                                 \
        .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},                                           \
        .fmmu_count = 3,                                                                                               \
        .mailbox_protocols = ECT_MAILBOX_COE,                                                                          \
        .protocols = protocols,                                                                                        \
        .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_UPLOAD | ECT_COE_COMPLETE_ACCESS,                  \
        .physics = "YY",                                                                                               \
        .sync = {.supported = 0x0001, .minimum_cycle_ns = 100000},                                                     \
        .timeouts = {.preop_ms = 1000, .safeop_op_ms = 5000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},       \
        .objects = object_list,                                                                                        \
        .object_count = sizeof(object_list) / sizeof((object_list)[0]),                                                \
        .instance_size = sizeof(eclink_t),                                                                             \
        .buffer_size = buffer_bytes,                                                                                   \
        .init = eclink_init,                                                                                           \
        .state_change = eclink_state_change,                                                                           \
        .outputs = eclink_outputs,                                                                                     \
        .inputs_read = eclink_inputs_read,                                                                             \
        .tick = eclink_tick,                                                                                           \
        .sdo_read = eclink_sdo_read,                                                                                   \
        .al_error = eclink_al_error,                                                                                   \
    }

const ect_device_t ect_eclink_map1 =
    BASE_UNIT("vr-bu-ect-map1", "Vision Remote base unit, Input Only", "VR-BU-ECT-Map1", PRODUCT_MAP1, objects_map1, 0);
const ect_device_t ect_eclink_map3 = BASE_UNIT("vr-bu-ect-map3", "Vision Remote base unit, Input + Commands",
                                               "VR-BU-ECT-Map3", PRODUCT_MAP3, objects_map3, 0);
const ect_device_t ect_eclink_map7 = BASE_UNIT("vr-bu-ect-map7", "Vision Remote base unit, Standard", "VR-BU-ECT-Map7",
                                               PRODUCT_MAP7, objects_map7, ECLINK_BUFFER);
const ect_device_t ect_eclink_multiarm =
    BASE_UNIT("vr-bu-ect-multiarm", "Vision Remote base unit, MultiArm", "VR-BU-ECT-MultiArm", PRODUCT_MULTIARM,
              objects_multiarm, ECLINK_BUFFER);
