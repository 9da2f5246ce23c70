/* SPDX-License-Identifier: MIT */
/*
 * The description of a PMCtendo DD5. Mailbox, worked example and names are those of the manual (1002906-EN-02);
 * docs/devices/pmctendo-dd5.md names the sources of the PDOs that the manual does not print, and of the object numbers
 * of the product family.
 */
#include "devices/pmctendo/pmctendo.h"

#include "devices/pmctendo/instance.h"

#define PRODUCT_CODE 0x00DD0005 /* our placeholder */
#define REVISION     0x00010000

enum {
    RO = ECT_ACCESS_RO,
    IN = ECT_ACCESS_RO | ECT_ACCESS_TXPDO,
    OUT = ECT_ACCESS_RO | ECT_ACCESS_RXPDO,
    SET = ECT_ACCESS_RW | ECT_ACCESS_RXPDO,
    RW = ECT_ACCESS_RW,
    KEPT = ECT_ACCESS_RW | ECT_ACCESS_BACKUP,
    KEPT_PREOP = ECT_ACCESS_RW_PREOP | ECT_ACCESS_BACKUP,
};

#define I8(sub, access, name, initial, member)  ECT_ENTRY(sub, INTEGER8, 8, access, name, initial, pmctendo_t, member)
#define U8(sub, access, name, initial, member)  ECT_ENTRY(sub, UNSIGNED8, 8, access, name, initial, pmctendo_t, member)
#define I16(sub, access, name, initial, member) ECT_ENTRY(sub, INTEGER16, 16, access, name, initial, pmctendo_t, member)
#define U16(sub, access, name, initial, member)                                                                        \
    ECT_ENTRY(sub, UNSIGNED16, 16, access, name, initial, pmctendo_t, member)
#define I32(sub, access, name, initial, member) ECT_ENTRY(sub, INTEGER32, 32, access, name, initial, pmctendo_t, member)
#define U32(sub, access, name, initial, member)                                                                        \
    ECT_ENTRY(sub, UNSIGNED32, 32, access, name, initial, pmctendo_t, member)
/* An object of one value. */
#define VAR(index, kind, access, name, initial, member)                                                                \
    static const ect_entry_t entry_##index[] = {kind(0, access, name, initial, member)};

/* --- objects ------------------------------------------------------------------------------------------------------ */

static const ect_entry_t store[] = ECT_ENTRIES_STORE("Save all parameters");
static const ect_entry_t restore[] = ECT_ENTRIES_STORE("Restore all default parameters");
static const ect_entry_t sync[] = ECT_ENTRIES_SYNC(pmctendo_t, sync_data);
static const ect_entry_t error_settings[] = ECT_ENTRIES_ERROR_SETTINGS(pmctendo_t, sync_data);

static const ect_entry_t diagnosis[] = {
    ECT_ENTRY_COUNT(2),
    U16(1, RO, "Fault number", 0, fault),
    U32(2, RO, "Warnings", 0, warnings),
};
VAR(2001, U16, OUT, "Digital outputs", 0, outputs)
VAR(2002, I16, IN, "Analogue input", 0, analog)
VAR(2003, I32, IN, "Second feedback position", 0, feedback2)
VAR(20A4, U16, SET, "Latch control word", 0, latch_control)
VAR(20A5, U16, IN, "Latch status word", 0, latch_status)
VAR(20A6, I32, IN, "Latch position 1", 0, latch_position[0])
VAR(20A7, I32, IN, "Latch position 2", 0, latch_position[1])

VAR(603F, U16, RO, "Error code", 0, error_code)
VAR(6040, U16, OUT, "Control word", 0, control)
VAR(6041, U16, IN, "Status word", 0, status)
VAR(605A, I16, KEPT, "Quick stop option code", 2, axis.quick_option)
VAR(605B, I16, KEPT, "Shutdown option code", 1, axis.shutdown_option)
VAR(605C, I16, KEPT, "Disable operation option code", 1, axis.disable_option)
VAR(605D, I16, KEPT, "Halt option code", 1, axis.halt_option)
VAR(605E, I16, KEPT, "Fault reaction option code", 2, axis.fault_option)
VAR(6060, I8, KEPT, "Modes of operation", PMC_MODE_BY_PDO, mode)
VAR(6061, I8, RO, "Modes of operation display", 0, mode_display)
VAR(6062, I32, RO, "Position demand value", 0, demand)
VAR(6063, I32, IN, "Position actual internal value", 0, internal_position)
VAR(6064, I32, IN, "Position actual value", 0, position)
VAR(6065, U32, KEPT, "Following error window", PMC_TURN, axis.error_window)
VAR(6066, U16, KEPT, "Following error timeout", 0, axis.error_time)
VAR(6067, U32, KEPT, "Position window", 1000, axis.position_window)
VAR(6068, U16, KEPT, "Position window time", 0, axis.position_time)
VAR(606C, I32, RO, "Velocity actual value", 0, speed)
VAR(606D, U16, KEPT, "Velocity window", 65535, axis.speed_window)
VAR(606E, U16, KEPT, "Velocity window time", 0, axis.speed_time)
VAR(606F, U16, KEPT, "Velocity threshold", 65535, axis.zero_window)
VAR(6070, U16, KEPT, "Velocity threshold time", 0, axis.zero_time)
VAR(6071, I16, SET, "Target torque", 0, set_torque)
VAR(6072, U16, SET, "Max torque", 3000, axis.max_torque)
VAR(6073, U16, KEPT, "Max current", 3000, axis.max_current)
VAR(6074, I16, RO, "Torque demand", 0, torque_demand)
static const ect_entry_t entry_6075[] = {ECT_ENTRY_CONST(ECT_TYPE_UNSIGNED32, 32, RO, "Motor rated current", 5000)};
static const ect_entry_t entry_6076[] = {ECT_ENTRY_CONST(ECT_TYPE_UNSIGNED32, 32, RO, "Motor rated torque", 3000)};
VAR(6077, I16, IN, "Torque actual value", 0, torque)
VAR(6078, I16, RO, "Current actual value", 0, current)
VAR(607A, I32, RW, "Target position", 0, axis.target)
VAR(607C, I32, KEPT, "Home offset", 0, axis.home_offset)
static const ect_entry_t limits[] = {
    ECT_ENTRY_COUNT(2),
    I32(1, KEPT, "Min position limit", 0, axis.limit[0]),
    I32(2, KEPT, "Max position limit", 0, axis.limit[1]),
};
VAR(607E, U8, RW, "Polarity", 0, polarity)
VAR(607F, U32, KEPT, "Max profile velocity", 100u * PMC_TURN, axis.speed_limit)
VAR(6080, U32, KEPT, "Max motor speed", 6000, axis.motor_speed)
VAR(6081, U32, KEPT, "Profile velocity", 10u * PMC_TURN, axis.task_speed)
VAR(6083, U32, KEPT, "Profile acceleration", 100u * PMC_TURN, axis.acceleration)
VAR(6084, U32, KEPT, "Profile deceleration", 100u * PMC_TURN, axis.deceleration)
VAR(6085, U32, KEPT, "Quick stop deceleration", 500u * PMC_TURN, axis.quick_deceleration)
VAR(6086, I16, RW, "Motion profile type", 0, ramp_type)
#define RATIO(index, what, numerator, of, denominator)                                                                 \
    static const ect_entry_t entry_##index[] = {                                                                       \
        ECT_ENTRY_COUNT(2),                                                                                            \
        {1, ECT_TYPE_UNSIGNED32, 32, RO, what, numerator, NULL},                                                       \
        {2, ECT_TYPE_UNSIGNED32, 32, RO, of, denominator, NULL},                                                       \
    };
RATIO(608F, "Encoder increments", PMC_TURN, "Motor revolutions", 1)
RATIO(6091, "Motor shaft revolutions", 1, "Driving shaft revolutions", 1)
RATIO(6092, "Feed", PMC_TURN, "Shaft revolutions", 1)
VAR(6098, I8, KEPT, "Homing method", 35, axis.home_method)
static const ect_entry_t home_speeds[] = {
    ECT_ENTRY_COUNT(2),
    U32(1, KEPT, "Speed during search for switch", 2u * PMC_TURN, axis.home_speed[0]),
    U32(2, KEPT, "Speed during search for zero", PMC_TURN / 2, axis.home_speed[1]),
};
VAR(609A, U32, KEPT, "Homing acceleration", 50u * PMC_TURN, axis.home_acceleration)
VAR(60B2, I16, OUT, "Torque offset", 0, torque_ahead)
static const ect_entry_t set_position[] = {
    ECT_ENTRY_COUNT(1),
    I32(1, SET, "Interpolated position", 0, set_position),
};
static const ect_entry_t cycle[] = {
    ECT_ENTRY_COUNT(2), U8(1, KEPT_PREOP, "Interpolation time units", 1, cycle_units),
    I8(2, KEPT_PREOP, "Interpolation time index", 0xFD, cycle_power), /* -3 */
};
VAR(60C5, U32, KEPT, "Max acceleration", UINT32_MAX, axis.most_acceleration)
VAR(60C6, U32, KEPT, "Max deceleration", UINT32_MAX, axis.most_deceleration)
VAR(60E0, U16, KEPT, "Positive torque limit value", 3000, axis.torque_limit[0])
VAR(60E1, U16, KEPT, "Negative torque limit value", 3000, axis.torque_limit[1])
VAR(60F4, I32, IN, "Following error actual value", 0, following_error)
VAR(60FD, U32, IN, "Digital inputs", 0, inputs)
static const ect_entry_t physical_outputs[] = {
    ECT_ENTRY_COUNT(2),
    U32(1, RW, "Physical outputs", 0, axis.physical[0]),
    U32(2, RW, "Bit mask", 0, axis.physical[1]),
};
VAR(60FF, I32, SET, "Target velocity", 0, set_speed)
static const ect_entry_t entry_6502[] = {ECT_ENTRY_CONST(ECT_TYPE_UNSIGNED32, 32, RO, "Supported drive modes", 0x3E5)};

/* --- the fixed PDOs ----------------------------------------------------------------------------------------------- */

#define MAP(sub, index, subindex, bits) ECT_ENTRY_MAP(sub, ECT_MAP(index, subindex, bits))

static const ect_entry_t map_1701[] = {ECT_ENTRY_COUNT(2), MAP(1, 0x60C1, 1, 32), MAP(2, 0x6040, 0, 16)};
static const ect_entry_t map_1702[] = {ECT_ENTRY_COUNT(2), MAP(1, 0x60FF, 0, 32), MAP(2, 0x6040, 0, 16)};
static const ect_entry_t map_1704[] = {ECT_ENTRY_COUNT(2), MAP(1, 0x6071, 0, 16), MAP(2, 0x6040, 0, 16)};
static const ect_entry_t map_1720[] = {ECT_ENTRY_COUNT(5),    MAP(1, 0x6040, 0, 16), MAP(2, 0x60C1, 1, 32),
                                       MAP(3, 0x20A4, 0, 16), MAP(4, 0x60B2, 0, 16), MAP(5, 0x2001, 0, 16)};
static const ect_entry_t map_1721[] = {ECT_ENTRY_COUNT(3), MAP(1, 0x60C1, 1, 32), MAP(2, 0x6040, 0, 16),
                                       MAP(3, 0x60B2, 0, 16)};
static const ect_entry_t map_1722[] = {ECT_ENTRY_COUNT(6),    MAP(1, 0x6040, 0, 16), MAP(2, 0x60C1, 1, 32),
                                       MAP(3, 0x20A4, 0, 16), MAP(4, 0x60B2, 0, 16), MAP(5, 0x2001, 0, 16),
                                       MAP(6, 0x6072, 0, 16)};
static const ect_entry_t map_1b01[] = {ECT_ENTRY_COUNT(2), MAP(1, 0x6064, 0, 32), MAP(2, 0x6041, 0, 16)};
static const ect_entry_t map_1b25[] = {
    ECT_ENTRY_COUNT(10),   MAP(1, 0x6063, 0, 32), MAP(2, 0x2003, 0, 32),  MAP(3, 0x20A7, 0, 32),
    MAP(4, 0x60FD, 0, 32), MAP(5, 0x60F4, 0, 32), MAP(6, 0x20A6, 0, 32),  MAP(7, 0x6041, 0, 16),
    MAP(8, 0x6077, 0, 16), MAP(9, 0x20A5, 0, 16), MAP(10, 0x2002, 0, 16),
};
static const ect_entry_t map_1b26[] = {ECT_ENTRY_COUNT(5),    MAP(1, 0x6041, 0, 16), MAP(2, 0x6064, 0, 32),
                                       MAP(3, 0x2002, 0, 16), MAP(4, 0x60FD, 0, 32), MAP(5, 0x60F4, 0, 32)};

#define ASSIGNMENT(count, element, pdo)                                                                                \
    {                                                                                                                  \
        ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RW_PREOP, "Number of entries", 1, pmctendo_t, count),                    \
        ECT_ENTRY(1, UNSIGNED16, 16, ECT_ACCESS_RW_PREOP, "Assigned PDO", pdo, pmctendo_t, element),                   \
    }
static const ect_entry_t assign_out[] = ASSIGNMENT(assigned_outs, assigned_out, PMC_PDO_POSITION);
static const ect_entry_t assign_in[] = ASSIGNMENT(assigned_ins, assigned_in, PMC_PDO_ACTUAL);

static const ect_object_t objects[] = {
    ECT_OBJECT_DEVICE_TYPE,
    ECT_OBJECT_ERROR_REGISTER,
    ECT_OBJECT_DEVICE_NAME,
    ECT_OBJECT_HARDWARE_VERSION,
    ECT_OBJECT_SOFTWARE_VERSION,
    ECT_ARRAY(0x1010, "Store parameters", store),
    ECT_ARRAY(0x1011, "Restore default parameters", restore),
    ECT_OBJECT_IDENTITY,
    ECT_RECORD(0x10F1, "Error settings", error_settings),
    ECT_RECORD(PMC_PDO_POSITION, "Position", map_1701),
    ECT_RECORD(PMC_PDO_SPEED, "Speed", map_1702),
    ECT_RECORD(PMC_PDO_TORQUE, "Torque", map_1704),
    ECT_RECORD(PMC_PDO_POSITION_FULL, "Position, latch, torque, outputs", map_1720),
    ECT_RECORD(PMC_PDO_POSITION_TORQUE, "Position, torque", map_1721),
    ECT_RECORD(PMC_PDO_POSITION_LIMIT, "Position, latch, torque, outputs, limit", map_1722),
    ECT_RECORD(PMC_PDO_ACTUAL, "Actual position", map_1b01),
    ECT_RECORD(PMC_PDO_ACTUAL_FULL, "All actual values", map_1b25),
    ECT_RECORD(PMC_PDO_ACTUAL_STATUS, "Status, actual position, inputs", map_1b26),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", assign_out),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_in),
    ECT_SPARSE(0x1C32, RECORD, 32, "SM2 synchronization", sync),
    ECT_SPARSE(0x1C33, RECORD, 32, "SM3 synchronization", sync),
    ECT_RECORD(0x2000, "Faults and warnings", diagnosis),
    ECT_VAR(0x2001, "Digital outputs", entry_2001),
    ECT_VAR(0x2002, "Analogue input", entry_2002),
    ECT_VAR(0x2003, "Second feedback position", entry_2003),
    ECT_VAR(0x20A4, "Latch control word", entry_20A4),
    ECT_VAR(0x20A5, "Latch status word", entry_20A5),
    ECT_VAR(0x20A6, "Latch position 1", entry_20A6),
    ECT_VAR(0x20A7, "Latch position 2", entry_20A7),
    ECT_VAR(0x603F, "Error code", entry_603F),
    ECT_VAR(0x6040, "Control word", entry_6040),
    ECT_VAR(0x6041, "Status word", entry_6041),
    ECT_VAR(0x605A, "Quick stop option code", entry_605A),
    ECT_VAR(0x605B, "Shutdown option code", entry_605B),
    ECT_VAR(0x605C, "Disable operation option code", entry_605C),
    ECT_VAR(0x605D, "Halt option code", entry_605D),
    ECT_VAR(0x605E, "Fault reaction option code", entry_605E),
    ECT_VAR(0x6060, "Modes of operation", entry_6060),
    ECT_VAR(0x6061, "Modes of operation display", entry_6061),
    ECT_VAR(0x6062, "Position demand value", entry_6062),
    ECT_VAR(0x6063, "Position actual internal value", entry_6063),
    ECT_VAR(0x6064, "Position actual value", entry_6064),
    ECT_VAR(0x6065, "Following error window", entry_6065),
    ECT_VAR(0x6066, "Following error timeout", entry_6066),
    ECT_VAR(0x6067, "Position window", entry_6067),
    ECT_VAR(0x6068, "Position window time", entry_6068),
    ECT_VAR(0x606C, "Velocity actual value", entry_606C),
    ECT_VAR(0x606D, "Velocity window", entry_606D),
    ECT_VAR(0x606E, "Velocity window time", entry_606E),
    ECT_VAR(0x606F, "Velocity threshold", entry_606F),
    ECT_VAR(0x6070, "Velocity threshold time", entry_6070),
    ECT_VAR(0x6071, "Target torque", entry_6071),
    ECT_VAR(0x6072, "Max torque", entry_6072),
    ECT_VAR(0x6073, "Max current", entry_6073),
    ECT_VAR(0x6074, "Torque demand", entry_6074),
    ECT_VAR(0x6075, "Motor rated current", entry_6075),
    ECT_VAR(0x6076, "Motor rated torque", entry_6076),
    ECT_VAR(0x6077, "Torque actual value", entry_6077),
    ECT_VAR(0x6078, "Current actual value", entry_6078),
    ECT_VAR(0x607A, "Target position", entry_607A),
    ECT_VAR(0x607C, "Home offset", entry_607C),
    ECT_ARRAY(0x607D, "Software position limit", limits),
    ECT_VAR(0x607E, "Polarity", entry_607E),
    ECT_VAR(0x607F, "Max profile velocity", entry_607F),
    ECT_VAR(0x6080, "Max motor speed", entry_6080),
    ECT_VAR(0x6081, "Profile velocity", entry_6081),
    ECT_VAR(0x6083, "Profile acceleration", entry_6083),
    ECT_VAR(0x6084, "Profile deceleration", entry_6084),
    ECT_VAR(0x6085, "Quick stop deceleration", entry_6085),
    ECT_VAR(0x6086, "Motion profile type", entry_6086),
    ECT_ARRAY(0x608F, "Position encoder resolution", entry_608F),
    ECT_ARRAY(0x6091, "Gear ratio", entry_6091),
    ECT_ARRAY(0x6092, "Feed constant", entry_6092),
    ECT_VAR(0x6098, "Homing method", entry_6098),
    ECT_ARRAY(0x6099, "Homing speeds", home_speeds),
    ECT_VAR(0x609A, "Homing acceleration", entry_609A),
    ECT_VAR(0x60B2, "Torque offset", entry_60B2),
    ECT_ARRAY(0x60C1, "Interpolation data record", set_position),
    ECT_RECORD(0x60C2, "Interpolation time period", cycle),
    ECT_VAR(0x60C5, "Max acceleration", entry_60C5),
    ECT_VAR(0x60C6, "Max deceleration", entry_60C6),
    ECT_VAR(0x60E0, "Positive torque limit value", entry_60E0),
    ECT_VAR(0x60E1, "Negative torque limit value", entry_60E1),
    ECT_VAR(0x60F4, "Following error actual value", entry_60F4),
    ECT_VAR(0x60FD, "Digital inputs", entry_60FD),
    ECT_ARRAY(0x60FE, "Digital outputs", physical_outputs),
    ECT_VAR(0x60FF, "Target velocity", entry_60FF),
    ECT_VAR(0x6502, "Supported drive modes", entry_6502),
};

/* Units by ETG.1004: prefix and numerator, denominator. */
enum { COUNT = 0x00B5, TURNS = 0x00B4, MILLI_S = 0xFD03, MILLI_A = 0xFD04, MILLI_V = 0xFD26, PER_MILLE = 0xFD00 };
enum { PER_S = 0x03, PER_MIN = 0x47, PER_S2 = 0x57 };
#define COUNTS(index, subindex) ECT_LIMITS(index, subindex, COUNT, 0, 0)
#define SPEED(index)            ECT_LIMITS_PER(index, 0, COUNT, PER_S, 0, 0)
#define RATE(index, subindex)   ECT_LIMITS_PER(index, subindex, COUNT, PER_S, 1, UINT32_MAX)
#define RAMP(index)             ECT_LIMITS_PER(index, 0, COUNT, PER_S2, 1, UINT32_MAX)
#define TIME(index)             ECT_LIMITS(index, 0, MILLI_S, 0, 0)
#define SHARE(index)            ECT_LIMITS(index, 0, PER_MILLE, 0, 0)
#define LIMIT(index)            ECT_LIMITS(index, 0, PER_MILLE, 0, 3000)
static const ect_detail_t details[] = {
    ECT_LIMITS(0x2002, 0, MILLI_V, 0, 0),
    COUNTS(0x2003, 0),
    COUNTS(0x20A6, 0),
    COUNTS(0x20A7, 0),
    COUNTS(0x6062, 0),
    COUNTS(0x6063, 0),
    COUNTS(0x6064, 0),
    COUNTS(0x6065, 0),
    TIME(0x6066),
    COUNTS(0x6067, 0),
    TIME(0x6068),
    SPEED(0x606C),
    SPEED(0x606D),
    TIME(0x606E),
    SPEED(0x606F),
    TIME(0x6070),
    SHARE(0x6071),
    LIMIT(0x6072),
    LIMIT(0x6073),
    SHARE(0x6074),
    ECT_LIMITS(0x6075, 0, MILLI_A, 0, 0),
    SHARE(0x6077),
    SHARE(0x6078),
    COUNTS(0x607A, 0),
    COUNTS(0x607C, 0),
    COUNTS(0x607D, 1),
    COUNTS(0x607D, 2),
    RATE(0x607F, 0),
    ECT_LIMITS_PER(0x6080, 0, TURNS, PER_MIN, 1, UINT32_MAX),
    RATE(0x6081, 0),
    RAMP(0x6083),
    RAMP(0x6084),
    RAMP(0x6085),
    COUNTS(0x608F, 1),
    COUNTS(0x6092, 1),
    RATE(0x6099, 1),
    RATE(0x6099, 2),
    RAMP(0x609A),
    SHARE(0x60B2),
    COUNTS(0x60C1, 1),
    ECT_LIMITS(0x60C2, 1, 0, 1, 255),
    ECT_LIMITS(0x60C2, 2, 0, -6, 0),
    RAMP(0x60C5),
    RAMP(0x60C6),
    LIMIT(0x60E0),
    LIMIT(0x60E1),
    COUNTS(0x60F4, 0),
    SPEED(0x60FF),
};

/* One PDO for each direction: each PDO excludes the others. */
static const uint16_t not_1701[] = {0x1702, 0x1704, 0x1720, 0x1721, 0x1722, 0};
static const uint16_t not_1702[] = {0x1701, 0x1704, 0x1720, 0x1721, 0x1722, 0};
static const uint16_t not_1704[] = {0x1701, 0x1702, 0x1720, 0x1721, 0x1722, 0};
static const uint16_t not_1720[] = {0x1701, 0x1702, 0x1704, 0x1721, 0x1722, 0};
static const uint16_t not_1721[] = {0x1701, 0x1702, 0x1704, 0x1720, 0x1722, 0};
static const uint16_t not_1722[] = {0x1701, 0x1702, 0x1704, 0x1720, 0x1721, 0};
static const uint16_t not_1b01[] = {0x1B25, 0x1B26, 0};
static const uint16_t not_1b25[] = {0x1B01, 0x1B26, 0};
static const uint16_t not_1b26[] = {0x1B01, 0x1B25, 0};
static const ect_pdo_t pdos[] = {
    {0x1701, ECT_PDO_FIXED, not_1701}, {0x1702, ECT_PDO_FIXED, not_1702}, {0x1704, ECT_PDO_FIXED, not_1704},
    {0x1720, ECT_PDO_FIXED, not_1720}, {0x1721, ECT_PDO_FIXED, not_1721}, {0x1722, ECT_PDO_FIXED, not_1722},
    {0x1B01, ECT_PDO_FIXED, not_1b01}, {0x1B25, ECT_PDO_FIXED, not_1b25}, {0x1B26, ECT_PDO_FIXED, not_1b26},
};

static const ect_dc_mode_t dc_modes[] = {
    {.name = "DC", .description = "Synchronised with SYNC0", .assign_activate = 0x0300},
    {.name = "SM", .description = "Synchronised with the process data", .assign_activate = 0x0000},
};
/* 1 ms, or the cycle of the bus where the configuration tool knows it. */
static const uint8_t cycle_units[] = {1}, cycle_power[] = {0xFD};
#define CYCLE(sub, bytes, what)                                                                                        \
    {.transitions = "PS",                                                                                              \
     .index = 0x60C2,                                                                                                  \
     .subindex = sub,                                                                                                  \
     .adapts = true,                                                                                                   \
     .size = sizeof(bytes),                                                                                            \
     .data = bytes,                                                                                                    \
     .comment = what}
static const ect_init_command_t init_commands[] = {CYCLE(1, cycle_units, "Cycle time"),
                                                   CYCLE(2, cycle_power, "Cycle time, power of ten of a second")};
static const ect_service_t *const services[] = {&ect_service_pdo_config, &ect_service_sync, &ect_service_store,
                                                &ect_service_rhythm, NULL};
static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, NULL};

const ect_device_t ect_pmctendo_dd5 = {
    .name = "pmctendo-dd5",
    .summary = "Pilz PMCtendo DD5 servo amplifier with a motor",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "PMCtendo DD5",
    .group_type = "PMCtendo",
    .group_name = "Servo amplifiers",
    .device_type = 0x00020192, /* CiA 402, servo drive */
    .hardware_version = "ectwin",
    .software_version = "0.1",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = PRODUCT_CODE, .revision = REVISION, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x08, 0x0E, 0x00, 0x0C, 0x0A, 0x00}, /* SYNC0 is an output and an event */
    .sii_size = 2048,
    .sm = {{.start = 0x1800, .length = 16, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1C00, .length = 16, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1100, .maximum = 14, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1140, .maximum = 32, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 3,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_PDO_ASSIGN | ECT_COE_PDO_UPLOAD,
    .physics = "YY",
    .dc_modes = dc_modes,
    .dc_mode_count = sizeof dc_modes / sizeof dc_modes[0],
    .init_commands = init_commands,
    .init_command_count = sizeof init_commands / sizeof init_commands[0],
    .sync = {.supported = 0x0006, .minimum_cycle_ns = PMC_STEP_NS},
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 10000, .back_to_init_ms = 5000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .details = details,
    .detail_count = sizeof details / sizeof details[0],
    .pdos = pdos,
    .pdo_count = sizeof pdos / sizeof pdos[0],
    .services = services,
    .instance_size = sizeof(pmctendo_t),
    .init = pmc_init,
    .state_change = pmc_state_change,
    .cyclic = pmc_cyclic,
    .outputs = pmc_outputs,
    .safe_outputs = pmc_safe_outputs,
    .inputs = pmc_inputs,
    .tick = pmc_tick,
    .sdo_write = pmc_sdo_write,
    .sdo_written = pmc_sdo_written,
    .al_error = pmc_al_error,
    .mail = pmc_mail,
};
