/* SPDX-License-Identifier: MIT */
/* The description. Sizes and order follow Q179 §4-1; object indices are ectwin's, because none are public. */
#include "devices/fzm1/fzm1.h"

#include "devices/fzm1/instance.h"

#define PRODUCT_CODE 0x00F20001 /* a placeholder of this project */
#define REVISION     0x00010000

enum {
    IN = ECT_ACCESS_RO | ECT_ACCESS_TXPDO,
    OUT = ECT_ACCESS_RO | ECT_ACCESS_RXPDO,
    SETTING = ECT_ACCESS_RW,
};

#define S8(sub, name, initial, member)  ECT_ENTRY(sub, UNSIGNED8, 8, SETTING, name, initial, fzm1_t, member)
#define S16(sub, name, initial, member) ECT_ENTRY(sub, UNSIGNED16, 16, SETTING, name, initial, fzm1_t, member)
#define U32(sub, access, name, member)  ECT_ENTRY(sub, UNSIGNED32, 32, access, name, 0, fzm1_t, member)
#define I32(sub, access, name, member)  ECT_ENTRY(sub, INTEGER32, 32, access, name, 0, fzm1_t, member)
#define COMMENT(sub, name, member)      ECT_ENTRY(sub, VISIBLE_STRING, 8 * FZM1_TEXT, SETTING, name, 0, fzm1_t, member)
#define MAP(sub, index)                 ECT_ENTRY_MAP(sub, ECT_MAP(index, sub, 32))

static const ect_entry_t sync[] = ECT_ENTRIES_SYNC(fzm1_t, sync);

static const ect_entry_t command_area[] = {
    ECT_ENTRY_COUNT(5),
    U32(1, OUT, "Control signals", control_in),
    U32(2, OUT, "Command code", command_code),
    I32(3, OUT, "Parameter 1", parameter[0]),
    I32(4, OUT, "Parameter 2", parameter[1]),
    I32(5, OUT, "Parameter 3", parameter[2]),
};
static const ect_entry_t response_area[] = {
    ECT_ENTRY_COUNT(4),
    U32(1, IN, "Control signals", control_out),
    U32(2, IN, "Command code", response_code),
    U32(3, IN, "Response code", result_code),
    I32(4, IN, "Response data", response_data),
};
static const ect_entry_t output_area[] = {
    ECT_ENTRY_COUNT(8),
    I32(1, IN, "Data 1", output[0]),
    I32(2, IN, "Data 2", output[1]),
    I32(3, IN, "Data 3", output[2]),
    I32(4, IN, "Data 4", output[3]),
    I32(5, IN, "Data 5", output[4]),
    I32(6, IN, "Data 6", output[5]),
    I32(7, IN, "Data 7", output[6]),
    I32(8, IN, "Data 8", output[7]),
};
static const ect_entry_t settings[] = {
    ECT_ENTRY_COUNT(5),
    S8(1, "Output control", FZM1_NONE, settings.output_control),
    S16(2, "Output period", 100, settings.output_period),
    S16(3, "Output time", 50, settings.output_time),
    S16(4, "Timeout", 100, settings.timeout),
    S8(5, "Output format", FZM1_FIXED_POINT, scene.format),
};
static const ect_entry_t clear_error[] = {
    {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_WO | ECT_ACCESS_COMMAND, "Clear error", 0, NULL}};
static const ect_entry_t comments[] = {
    ECT_ENTRY_COUNT(8),
    COMMENT(1, "Comment 1", scene.comment[0]),
    COMMENT(2, "Comment 2", scene.comment[1]),
    COMMENT(3, "Comment 3", scene.comment[2]),
    COMMENT(4, "Comment 4", scene.comment[3]),
    COMMENT(5, "Comment 5", scene.comment[4]),
    COMMENT(6, "Comment 6", scene.comment[5]),
    COMMENT(7, "Comment 7", scene.comment[6]),
    COMMENT(8, "Comment 8", scene.comment[7]),
};

static const ect_entry_t map_command[] = {ECT_ENTRY_COUNT(5), MAP(1, 0x2100), MAP(2, 0x2100),
                                          MAP(3, 0x2100),     MAP(4, 0x2100), MAP(5, 0x2100)};
static const ect_entry_t map_response[] = {ECT_ENTRY_COUNT(4), MAP(1, 0x2200), MAP(2, 0x2200), MAP(3, 0x2200),
                                           MAP(4, 0x2200)};
static const ect_entry_t map_output[] = {ECT_ENTRY_COUNT(8), MAP(1, 0x2300), MAP(2, 0x2300),
                                         MAP(3, 0x2300),     MAP(4, 0x2300), MAP(5, 0x2300),
                                         MAP(6, 0x2300),     MAP(7, 0x2300), MAP(8, 0x2300)};
static const ect_entry_t assign_outputs[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t assign_inputs[] = {ECT_ENTRY_COUNT(2), ECT_ENTRY_ASSIGN(1, 0x1A00),
                                            ECT_ENTRY_ASSIGN(2, 0x1A01)};

static const ect_object_t objects[] = {
    ECT_OBJECT_DEVICE_TYPE,
    ECT_OBJECT_DEVICE_NAME,
    ECT_OBJECT_HARDWARE_VERSION,
    ECT_OBJECT_SOFTWARE_VERSION,
    ECT_OBJECT_IDENTITY,
    ECT_RECORD(0x1600, "Command area mapping", map_command),
    ECT_RECORD(0x1A00, "Response area mapping", map_response),
    ECT_RECORD(0x1A01, "Output area mapping", map_output),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", assign_outputs),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_inputs),
    ECT_SPARSE(0x1C32, RECORD, 32, "SM2 synchronization", sync),
    ECT_SPARSE(0x1C33, RECORD, 32, "SM3 synchronization", sync),
    ECT_RECORD(0x2100, "Command area", command_area),
    ECT_RECORD(0x2200, "Response area", response_area),
    ECT_ARRAY(0x2300, "Output area", output_area),
    ECT_RECORD(0x2400, "Communication settings", settings),
    ECT_VAR(0x2401, "Clear error", clear_error),
    ECT_ARRAY(0x2500, "Output data comments", comments),
};

/* Unit codes: 1e-4 s, 1e-1 s (ETG.1004). */
static const ect_detail_t details[] = {
    ECT_LIMITS(0x2400, 2, 0xFC03, 20, 50000),
    ECT_LIMITS(0x2400, 3, 0xFC03, 10, 10000),
    ECT_LIMITS(0x2400, 4, 0xFF03, 5, 1200),
};

static const uint32_t dc_cycles_ns[] = {250000, 500000, 1000000, 2000000, 4000000};
static const ect_dc_mode_t dc_modes[] = {
    {.name = "FreeRun", .description = "No distributed clocks", .assign_activate = 0x0000},
    {.name = "DC", .description = "Asynchronous DC mode 1", .assign_activate = 0x0300, .factor_sync0 = 1},
};
static const ect_service_t *const services[] = {&ect_service_sync, NULL};

static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  NULL};

const ect_device_t ect_fzm1 = {
    .name = "fzm1",
    .summary = "OMRON FZM1 vision sensor",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "FZM1",
    .group_type = "FZM1",
    .group_name = "Vision sensors",
    .hardware_version = "ectwin",
    .software_version = "0.1",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = PRODUCT_CODE, .revision = REVISION, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x08, 0x0E, 0x00, 0x0C, 0x0A, 0x00}, /* SYNC0 is an output and an event */
    .sii_size = 2048,
    .sm = {{.start = 0x1000, .length = 128, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 128, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1100, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1200, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 3,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_UPLOAD,
    .physics = "YY",
    .dc_modes = dc_modes,
    .dc_mode_count = sizeof dc_modes / sizeof dc_modes[0],
    .sync = {.supported = 0x0005,
             .minimum_cycle_ns = 250000,
             .dc_cycles_ns = dc_cycles_ns,
             .dc_cycle_count = sizeof dc_cycles_ns / sizeof dc_cycles_ns[0],
             .asynchronous = true}, /* Q179 §1-1: "DC mode 1" */
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 10000, .back_to_init_ms = 5000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .details = details,
    .detail_count = sizeof details / sizeof details[0],
    .services = services,
    .instance_size = sizeof(fzm1_t),
    .init = fzm1_init,
    .state_change = fzm1_state_change,
    .outputs = fzm1_outputs,
    .tick = fzm1_tick,
    .sdo_request = fzm1_sdo_request,
    .sdo_write = fzm1_sdo_write,
    .sdo_written = fzm1_sdo_written,
};
