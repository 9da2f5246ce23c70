/* SPDX-License-Identifier: MIT */
/*
 * The description. States and CoE follow A 7.2.5 and A 7.2.6; the manual prints 1A00h, 2001h, 2005h, 603Fh, 6065h and
 * names 21B0h; all other indices and sub-indices are ectwin's.
 */
#include "devices/optoncdt2300/optoncdt2300.h"

#include "devices/optoncdt2300/instance.h"

#define PRODUCT_CODE 0x0D230001 /* placeholders of this project; the manual has the article number here */
#define REVISION     0x00010000

enum {
    IN = ECT_ACCESS_RO | ECT_ACCESS_TXPDO,
    SETTING = ECT_ACCESS_RW,
};

#define U32(sub, access, name, initial, member) ECT_ENTRY(sub, UNSIGNED32, 32, access, name, initial, opto_t, member)
#define I32(sub, name, which)                   ECT_ENTRY(sub, INTEGER32, 32, IN, name, 0, opto_t, record.value[OPTO_##which])
#define V32(sub, name, which)                   U32(sub, IN, name, 0, record.value[OPTO_##which])
#define SECRET(sub, name, member)                                                                                      \
    ECT_ENTRY(sub, VISIBLE_STRING, 8 * OPTO_PASSWORD, ECT_ACCESS_WO, name, 0, opto_t, member)
#define TEXT(sub, name, text)                                                                                          \
    {sub, ECT_TYPE_VISIBLE_STRING,  8 * (sizeof(text) - 1), ECT_ACCESS_RO | ECT_ACCESS_SHARED, name,                   \
     0,   (void *)(uintptr_t)(text)}
#define MAPPED(sub, initial) U32(sub, ECT_ACCESS_RO, "Mapped object", initial, mapping[sub - 1])
#define CHOICE(n, name, initial)                                                                                       \
    ECT_ENTRY(OPTO_FIRST_CHOICE - 1 + n, BOOLEAN, 1, ECT_ACCESS_RW_PREOP, name, initial, opto_t, chosen[n - 1])

static const ect_entry_t mapping[] = {
    ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RO, "Number of entries", 2, opto_t, mapped),
    MAPPED(1, ECT_MAP(0x6065, 0x05, 32)),
    MAPPED(2, ECT_MAP(0x6065, 0x07, 32)),
    MAPPED(3, 0),
    MAPPED(4, 0),
    MAPPED(5, 0),
    MAPPED(6, 0),
    MAPPED(7, 0),
    MAPPED(8, 0),
    MAPPED(9, 0),
    MAPPED(10, 0),
    MAPPED(11, 0),
    MAPPED(12, 0),
    MAPPED(13, 0),
};

/* One mapping object for each sample, all with the same mapping. */
#define SAMPLE(n) ECT_RECORD(0x1A00 + (n), "TxPDO mapping", mapping)
#define TEN(F, n)                                                                                                      \
    F(n), F((n) + 1), F((n) + 2), F((n) + 3), F((n) + 4), F((n) + 5), F((n) + 6), F((n) + 7), F((n) + 8), F((n) + 9)
#define HUNDRED(F, n)                                                                                                  \
    TEN(F, n), TEN(F, (n) + 10), TEN(F, (n) + 20), TEN(F, (n) + 30), TEN(F, (n) + 40), TEN(F, (n) + 50),               \
        TEN(F, (n) + 60), TEN(F, (n) + 70), TEN(F, (n) + 80), TEN(F, (n) + 90)

#define ASSIGNED(n)                                                                                                    \
    ECT_ENTRY(n, UNSIGNED16, 16, ECT_ACCESS_RW_PREOP, "Assigned PDO", (n) == 1 ? 0x1A00 : 0, opto_t,                   \
              assignment[(n) - 1])
static const ect_entry_t assignment[] = {
    ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RW_PREOP, "Number of entries", 1, opto_t, assigned),
    HUNDRED(ASSIGNED, 1),
};

static const ect_entry_t no_outputs[] = {ECT_ENTRY_COUNT(0)};

static const ect_entry_t sync[] = ECT_ENTRIES_SYNC(opto_t, sync);

static const ect_entry_t user_level[] = {
    ECT_ENTRY_COUNT(7),
    ECT_ENTRY(1, UNSIGNED8, 8, ECT_ACCESS_RO, "Actual user", OPTO_USER, opto_t, user),
    SECRET(2, "Login", login),
    ECT_ENTRY(3, BOOLEAN, 1, SETTING, "Logout", 0, opto_t, logout),
    ECT_ENTRY(4, UNSIGNED8, 8, SETTING, "Default user", OPTO_USER, opto_t, plant.default_user),
    SECRET(5, "Password old", password_old),
    SECRET(6, "Password new", password_new),
    SECRET(7, "Password repeat", password_repeat),
};

static const ect_entry_t sensor_info[] = {
    ECT_ENTRY_COUNT(9),
    ECT_ENTRY(2, REAL32, 32, ECT_ACCESS_RO, "Sensor range", 0, opto_t, range),
    TEXT(6, "Sensor option no.", "000"),
    TEXT(7, "Date of correction table", "2026/01/01"),
    TEXT(9, "Name of correction table", "DIFFUSE"),
};

static const ect_entry_t laser[] = {
    ECT_ENTRY_COUNT(1),
    ECT_ENTRY(1, UNSIGNED8, 8, SETTING, "Laser power", OPTO_FULL_POWER, opto_t, laser_power),
};
static const ect_entry_t statistic[] = {
    ECT_ENTRY_COUNT(1),
    ECT_ENTRY(1, BOOLEAN, 1, SETTING, "Reset statistic", 0, opto_t, statistic_reset),
};
static const ect_entry_t interfaces[] = {
    ECT_ENTRY_COUNT(OPTO_FIRST_CHOICE - 1 + OPTO_VALUES),
    CHOICE(1, "Shutter time", 0),
    CHOICE(2, "Value counter", 0),
    CHOICE(3, "Timestamp", 0),
    CHOICE(4, "Temperature", 0),
    CHOICE(5, "Intensity 1", 0),
    CHOICE(6, "Distance 1", 1),
    CHOICE(7, "Intensity 2", 0),
    CHOICE(8, "Distance 2", 1),
    CHOICE(9, "Sensor state", 0),
    CHOICE(10, "Difference 1-2", 0),
    CHOICE(11, "Statistic minimum", 0),
    CHOICE(12, "Statistic maximum", 0),
    CHOICE(13, "Statistic peak-to-peak", 0),
};
static const ect_entry_t rate[] = {
    ECT_ENTRY_COUNT(1),
    U32(1, SETTING, "Measuring rate", 20000, rate_hz),
};
static const ect_entry_t sensor_error[] = {
    ECT_ENTRY_COUNT(2),
    ECT_ENTRY(1, UNSIGNED16, 16, ECT_ACCESS_RO, "Sensor error number", 0, opto_t, error_number),
    ECT_ENTRY(2, VISIBLE_STRING, 8 * OPTO_ERROR_TEXT, ECT_ACCESS_RO, "Sensor error description", 0, opto_t, error_text),
};
static const ect_entry_t values[] = {
    ECT_ENTRY_COUNT(0x11),
    V32(0x01, "Shutter time", EXPOSURE),
    V32(0x02, "Value counter", COUNTER),
    V32(0x03, "Timestamp", TIMESTAMP),
    V32(0x04, "Intensity 1", INTENSITY_1),
    I32(0x05, "Distance 1", DISTANCE_1),
    V32(0x06, "Intensity 2", INTENSITY_2),
    I32(0x07, "Distance 2", DISTANCE_2),
    V32(0x0C, "Sensor state", STATE),
    I32(0x0D, "Difference 1-2", DIFFERENCE),
    I32(0x0E, "Statistic minimum", MINIMUM),
    I32(0x0F, "Statistic maximum", MAXIMUM),
    I32(0x10, "Statistic peak-to-peak", PEAK_TO_PEAK),
    I32(0x11, "Temperature", TEMPERATURE),
};

static const ect_object_t objects[] = {
    ECT_OBJECT_DEVICE_TYPE,
    ECT_OBJECT_DEVICE_NAME,
    ECT_OBJECT_HARDWARE_VERSION,
    ECT_OBJECT_SOFTWARE_VERSION,
    ECT_OBJECT_IDENTITY,
    HUNDRED(SAMPLE, 0),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "RxPDO assign", no_outputs), /* SOEM regards an SM2 without a type as outputs */
    ECT_ARRAY(0x1C13, "TxPDO assign", assignment),
    ECT_SPARSE(0x1C33, RECORD, 32, "SM3 synchronization", sync),
    ECT_RECORD(0x2001, "User level", user_level),
    ECT_SPARSE(0x2005, RECORD, 9, "Sensor info", sensor_info),
    ECT_RECORD(0x2131, "Laser", laser),
    ECT_RECORD(0x2181, "Statistic", statistic),
    ECT_SPARSE(0x21B0, RECORD, OPTO_FIRST_CHOICE - 1 + OPTO_VALUES, "Digital interfaces", interfaces),
    ECT_RECORD(0x2250, "Measuring rate", rate),
    ECT_RECORD(0x603F, "Sensor error", sensor_error),
    ECT_SPARSE(0x6065, RECORD, 0x11, "Measuring values", values),
};

/* Unit codes of ETG.1004. Shutter time (12.5 ns) and temperature (0.25 degC) have none: their factor is no power of
 * ten. */
enum { UNIT_MM = 0xFD01, UNIT_NM = 0xF701, UNIT_US = 0xFA03, UNIT_HZ = 0x0020 };
#define UNIT(index, sub, unit) ECT_LIMITS(index, sub, unit, 0, 0)
static const ect_detail_t details[] = {
    ECT_LIMITS(0x2001, 4, 0, OPTO_USER, OPTO_EXPERT),
    UNIT(0x2005, 2, UNIT_MM),
    ECT_LIMITS(0x2131, 1, 0, OPTO_FULL_POWER, OPTO_NO_POWER),
    UNIT(0x2250, 1, UNIT_HZ),
    UNIT(0x6065, 0x03, UNIT_US),
    UNIT(0x6065, 0x05, UNIT_NM),
    UNIT(0x6065, 0x07, UNIT_NM),
    UNIT(0x6065, 0x0D, UNIT_NM),
    UNIT(0x6065, 0x0E, UNIT_NM),
    UNIT(0x6065, 0x0F, UNIT_NM),
    UNIT(0x6065, 0x10, UNIT_NM),
};

/* SYNC0 has the measuring rate, or half of it for two alternating sensors, the second one a period later. */
#define SYNC0(mode_name, what, cycle_ns, shift_ns)                                                                     \
    {.name = mode_name,                                                                                                \
     .description = what,                                                                                              \
     .assign_activate = 0x0300,                                                                                        \
     .cycle_sync0_ns = cycle_ns,                                                                                       \
     .shift_sync0_ns = shift_ns}
#define SYNCHRONISED(rate, ns)                                                                                         \
    SYNC0("Slave " rate, "A record at each SYNC0", ns, 0),                                                             \
        SYNC0("First " rate, "Slave alternating, first sensor", 2 * (ns), 0),                                          \
        SYNC0("Second " rate, "Slave alternating, second sensor", 2 * (ns), ns)
static const ect_dc_mode_t dc_modes[] = {
    {.name = "FreeRun", .description = "The sensor's own measuring rate", .assign_activate = 0x0000},
    SYNCHRONISED("1.5 kHz", 666667),
    SYNCHRONISED("2.5 kHz", 400000),
    SYNCHRONISED("5 kHz", 200000),
    SYNCHRONISED("10 kHz", 100000),
    SYNCHRONISED("20 kHz", 50000),
    SYNCHRONISED("30 kHz", 33333),
    SYNCHRONISED("49.14 kHz", 20350),
};
static const uint32_t dc_cycles_ns[] = {20350,  33333,  40700,  50000,  66666,  100000,
                                        200000, 400000, 666667, 800000, 1333334};

static const ect_service_t *const services[] = {&ect_service_pdo_config, &ect_service_sync, NULL};
static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  NULL};

const ect_device_t ect_optoncdt2300 = {
    .name = "optoncdt2300",
    .summary = "MICRO-EPSILON optoNCDT 2300 laser distance sensor",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "ILD2300",
    .full_name = "optoNCDT ILD2300",
    .group_type = "optoNCDT2300",
    .group_name = "Laser distance sensors",
    .hardware_version = "ectwin",
    .software_version = "V 0.100",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = PRODUCT_CODE, .revision = REVISION, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x08, 0x0E, 0x00, 0x0C, 0x0A, 0x00},
    .sii_size = 4096,
    .sm = {{.start = 0x1000, .length = 256, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1100, .length = 256, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.type = ECT_SM_UNUSED},
           {.start = 0x1400, .maximum = OPTO_LONGEST, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 2,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_ASSIGN | ECT_COE_PDO_UPLOAD,
    .physics = "YY",
    .dc_modes = dc_modes,
    .dc_mode_count = sizeof dc_modes / sizeof dc_modes[0],
    .sync = {.supported = 0x0005,
             .minimum_cycle_ns = 20350,
             .dc_cycles_ns = dc_cycles_ns,
             .dc_cycle_count = sizeof dc_cycles_ns / sizeof dc_cycles_ns[0]},
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 10000, .back_to_init_ms = 5000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .details = details,
    .detail_count = sizeof details / sizeof details[0],
    .services = services,
    .instance_size = sizeof(opto_t),
    .init = opto_init,
    .state_change = opto_state_change,
    .inputs = opto_inputs,
    .inputs_packed = opto_inputs_packed,
    .inputs_read = opto_inputs_read,
    .tick = opto_tick,
    .sdo_write = opto_sdo_write,
    .sdo_written = opto_sdo_written,
};
