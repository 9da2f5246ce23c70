/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The objects of CiA 402-2 of a drive over a dictionary, one row for each object, and the links of an axis to the
 * entries of a vendor's dictionary.
 *
 * An axis uses the objects of its dictionary, in their widths, integer or floating point. A link of 0 bytes stands for
 * a missing object.
 *
 * Context: any. The functions access only the memory passed to them.
 */
#ifndef ECT_PROFILES_CIA402_VALUES_H
#define ECT_PROFILES_CIA402_VALUES_H

#include "od/link.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Indices of axis n are those of axis 0 + n times this. */
enum { ECT_402_AXIS_OBJECTS = 0x800, ECT_402_AXES = 8 };

/**
 * V(name, index, sub-index, kind, scale, default).
 * kind: COMMAND, read with each control word · SETTING · ACTUAL, which the axis writes.
 * scale of the default: PLAIN · TURN, turns of the motor.
 * A setting without a default in the file has this default; LIMIT: also if the file has 0, which would stop the axis.
 */
#define ECT_402_VALUES(V)                                                                                              \
    V(ABORT_OPTION, 0x6007, 0, SETTING, PLAIN, 1)                                                                      \
    V(ERROR_CODE, 0x603F, 0, ACTUAL, PLAIN, 0)                                                                         \
    V(CONTROL, 0x6040, 0, COMMAND, PLAIN, 0)                                                                           \
    V(STATUS, 0x6041, 0, ACTUAL, PLAIN, 0)                                                                             \
    V(QUICK_OPTION, 0x605A, 0, SETTING, PLAIN, 2)                                                                      \
    V(SHUTDOWN_OPTION, 0x605B, 0, SETTING, PLAIN, 0)                                                                   \
    V(DISABLE_OPTION, 0x605C, 0, SETTING, PLAIN, 1)                                                                    \
    V(HALT_OPTION, 0x605D, 0, LIMIT, PLAIN, 1)                                                                         \
    V(FAULT_OPTION, 0x605E, 0, SETTING, PLAIN, 2)                                                                      \
    V(MODE, 0x6060, 0, COMMAND, PLAIN, 0)                                                                              \
    V(MODE_DISPLAY, 0x6061, 0, ACTUAL, PLAIN, 0)                                                                       \
    V(DEMAND, 0x6062, 0, ACTUAL, PLAIN, 0)                                                                             \
    V(INTERNAL, 0x6063, 0, ACTUAL, PLAIN, 0)                                                                           \
    V(POSITION, 0x6064, 0, ACTUAL, PLAIN, 0)                                                                           \
    V(ERROR_WINDOW, 0x6065, 0, SETTING, TURN, 1)                                                                       \
    V(ERROR_TIME, 0x6066, 0, SETTING, PLAIN, 10)                                                                       \
    V(POSITION_WINDOW, 0x6067, 0, SETTING, TURN, 0.001)                                                                \
    V(POSITION_TIME, 0x6068, 0, SETTING, PLAIN, 10)                                                                    \
    V(SENSOR_SPEED, 0x6069, 0, ACTUAL, PLAIN, 0)                                                                       \
    V(SPEED_DEMAND, 0x606B, 0, ACTUAL, PLAIN, 0)                                                                       \
    V(SPEED, 0x606C, 0, ACTUAL, PLAIN, 0)                                                                              \
    V(SPEED_WINDOW, 0x606D, 0, SETTING, TURN, 0.0625)                                                                  \
    V(SPEED_TIME, 0x606E, 0, SETTING, PLAIN, 10)                                                                       \
    V(ZERO_WINDOW, 0x606F, 0, SETTING, TURN, 0.0625)                                                                   \
    V(ZERO_TIME, 0x6070, 0, SETTING, PLAIN, 10)                                                                        \
    V(TARGET_TORQUE, 0x6071, 0, COMMAND, PLAIN, 0)                                                                     \
    V(MAX_TORQUE, 0x6072, 0, LIMIT, PLAIN, 3000)                                                                       \
    V(MAX_CURRENT, 0x6073, 0, LIMIT, PLAIN, 3000)                                                                      \
    V(TORQUE_DEMAND, 0x6074, 0, ACTUAL, PLAIN, 0)                                                                      \
    V(RATED_CURRENT, 0x6075, 0, LIMIT, PLAIN, 5000)                                                                    \
    V(RATED_TORQUE, 0x6076, 0, LIMIT, PLAIN, 3000)                                                                     \
    V(TORQUE, 0x6077, 0, ACTUAL, PLAIN, 0)                                                                             \
    V(CURRENT, 0x6078, 0, ACTUAL, PLAIN, 0)                                                                            \
    V(DC_LINK, 0x6079, 0, ACTUAL, PLAIN, 0)                                                                            \
    V(TARGET_POSITION, 0x607A, 0, COMMAND, PLAIN, 0)                                                                   \
    V(RANGE_MIN, 0x607B, 1, SETTING, PLAIN, 0)                                                                         \
    V(RANGE_MAX, 0x607B, 2, SETTING, PLAIN, 0)                                                                         \
    V(HOME_OFFSET, 0x607C, 0, SETTING, PLAIN, 0)                                                                       \
    V(LIMIT_MIN, 0x607D, 1, SETTING, PLAIN, 0)                                                                         \
    V(LIMIT_MAX, 0x607D, 2, SETTING, PLAIN, 0)                                                                         \
    V(POLARITY, 0x607E, 0, SETTING, PLAIN, 0)                                                                          \
    V(SPEED_LIMIT, 0x607F, 0, LIMIT, TURN, 100)                                                                        \
    V(MOTOR_SPEED, 0x6080, 0, LIMIT, PLAIN, 6000)                                                                      \
    V(TASK_SPEED, 0x6081, 0, LIMIT, TURN, 10)                                                                          \
    V(END_SPEED, 0x6082, 0, SETTING, PLAIN, 0)                                                                         \
    V(ACCELERATION, 0x6083, 0, LIMIT, TURN, 100)                                                                       \
    V(DECELERATION, 0x6084, 0, LIMIT, TURN, 100)                                                                       \
    V(QUICK_DECELERATION, 0x6085, 0, LIMIT, TURN, 500)                                                                 \
    V(PROFILE_TYPE, 0x6086, 0, SETTING, PLAIN, 0)                                                                      \
    V(TORQUE_SLOPE, 0x6087, 0, LIMIT, PLAIN, 10000)                                                                    \
    V(TORQUE_PROFILE, 0x6088, 0, SETTING, PLAIN, 0)                                                                    \
    V(INCREMENTS, 0x608F, 1, SETTING, PLAIN, 0)                                                                        \
    V(INCREMENT_TURNS, 0x608F, 2, SETTING, PLAIN, 0)                                                                   \
    V(GEAR_MOTOR, 0x6091, 1, SETTING, PLAIN, 0)                                                                        \
    V(GEAR_SHAFT, 0x6091, 2, SETTING, PLAIN, 0)                                                                        \
    V(FEED, 0x6092, 1, SETTING, PLAIN, 0)                                                                              \
    V(FEED_TURNS, 0x6092, 2, SETTING, PLAIN, 0)                                                                        \
    V(HOME_METHOD, 0x6098, 0, SETTING, PLAIN, 0)                                                                       \
    V(HOME_SEARCH, 0x6099, 1, LIMIT, TURN, 2)                                                                          \
    V(HOME_ZERO, 0x6099, 2, LIMIT, TURN, 0.5)                                                                          \
    V(HOME_ACCELERATION, 0x609A, 0, LIMIT, TURN, 10)                                                                   \
    V(POSITION_OFFSET, 0x60B0, 0, COMMAND, PLAIN, 0)                                                                   \
    V(SPEED_OFFSET, 0x60B1, 0, COMMAND, PLAIN, 0)                                                                      \
    V(TORQUE_OFFSET, 0x60B2, 0, COMMAND, PLAIN, 0)                                                                     \
    V(PROBE, 0x60B8, 0, SETTING, PLAIN, 0)                                                                             \
    V(PROBE_STATUS, 0x60B9, 0, ACTUAL, PLAIN, 0)                                                                       \
    V(PROBE_1_POSITIVE, 0x60BA, 0, ACTUAL, PLAIN, 0)                                                                   \
    V(PROBE_1_NEGATIVE, 0x60BB, 0, ACTUAL, PLAIN, 0)                                                                   \
    V(PROBE_2_POSITIVE, 0x60BC, 0, ACTUAL, PLAIN, 0)                                                                   \
    V(PROBE_2_NEGATIVE, 0x60BD, 0, ACTUAL, PLAIN, 0)                                                                   \
    V(SUB_MODE, 0x60C0, 0, SETTING, PLAIN, 0)                                                                          \
    V(RECORD, 0x60C1, 1, COMMAND, PLAIN, 0)                                                                            \
    V(CYCLE_UNITS, 0x60C2, 1, SETTING, PLAIN, 0)                                                                       \
    V(CYCLE_POWER, 0x60C2, 2, SETTING, PLAIN, -3)                                                                      \
    V(MOST_ACCELERATION, 0x60C5, 0, LIMIT, PLAIN, 4294967295.0)                                                        \
    V(MOST_DECELERATION, 0x60C6, 0, LIMIT, PLAIN, 4294967295.0)                                                        \
    V(PROBE_SOURCE_1, 0x60D0, 1, SETTING, PLAIN, 1)                                                                    \
    V(PROBE_SOURCE_2, 0x60D0, 2, SETTING, PLAIN, 2)                                                                    \
    V(PROBE_1_POSITIVES, 0x60D5, 0, ACTUAL, PLAIN, 0)                                                                  \
    V(PROBE_1_NEGATIVES, 0x60D6, 0, ACTUAL, PLAIN, 0)                                                                  \
    V(PROBE_2_POSITIVES, 0x60D7, 0, ACTUAL, PLAIN, 0)                                                                  \
    V(PROBE_2_NEGATIVES, 0x60D8, 0, ACTUAL, PLAIN, 0)                                                                  \
    V(SYNC_FUNCTIONS, 0x60DA, 0, SETTING, PLAIN, 0)                                                                    \
    V(TORQUE_POSITIVE, 0x60E0, 0, LIMIT, PLAIN, 3000)                                                                  \
    V(TORQUE_NEGATIVE, 0x60E1, 0, LIMIT, PLAIN, 3000)                                                                  \
    V(POSITIONING, 0x60F2, 0, SETTING, PLAIN, 0)                                                                       \
    V(FOLLOWING_ERROR, 0x60F4, 0, ACTUAL, PLAIN, 0)                                                                    \
    V(MAX_SLIPPAGE, 0x60F8, 0, SETTING, PLAIN, 0)                                                                      \
    V(EFFORT, 0x60FA, 0, ACTUAL, PLAIN, 0)                                                                             \
    V(INTERNAL_DEMAND, 0x60FC, 0, ACTUAL, PLAIN, 0)                                                                    \
    V(INPUTS, 0x60FD, 0, ACTUAL, PLAIN, 0)                                                                             \
    V(OUTPUTS, 0x60FE, 1, SETTING, PLAIN, 0)                                                                           \
    V(OUTPUT_MASK, 0x60FE, 2, SETTING, PLAIN, 0)                                                                       \
    V(TARGET_SPEED, 0x60FF, 0, COMMAND, PLAIN, 0)                                                                      \
    V(MODES, 0x6502, 0, ACTUAL, PLAIN, 0)

#define ECT_402_VALUE_NAME(name, index, subindex, kind, scale, initial) ECT_402_V_##name,
typedef enum ect_402_value { ECT_402_VALUES(ECT_402_VALUE_NAME) ECT_402_VALUE_COUNT } ect_402_value_t;
#undef ECT_402_VALUE_NAME

typedef enum ect_402_kind { ECT_402_COMMAND, ECT_402_SETTING, ECT_402_LIMIT, ECT_402_ACTUAL } ect_402_kind_t;

/** A row of the list. */
typedef struct ect_402_object {
    uint16_t index; /**< of axis 0 */
    uint8_t subindex;
    uint8_t kind; /**< ECT_402_COMMAND, ... */
    bool turns;   /**< the default counts turns of the motor */
    double initial;
} ect_402_object_t;

/** The entry of a dictionary with a value of an axis. */
typedef ect_link_t ect_402_link_t;

/** @return the row of a value. */
const ect_402_object_t *ect_402_object(ect_402_value_t value);

/** Finds the value of an object of axis 0. @return whether the object has a value */
bool ect_402_value_of(uint16_t index, uint8_t subindex, ect_402_value_t *value);

/**
 * Links an axis to a dictionary.
 * @param od          entries with offsets into an instance; its instance is not used
 * @param axis        0..ECT_402_AXES - 1
 * @param[out] links  ECT_402_VALUE_COUNT of them
 * @return whether the axis has a control word and a status word
 */
bool ect_402_links_find(const ect_od_t *od, unsigned int axis, ect_402_link_t *links);

/** As ::ect_link_load. */
static inline int64_t ect_402_load(const void *instance, const ect_402_link_t *link)
{
    return ect_link_load(instance, link);
}

/** As ::ect_link_store. */
static inline void ect_402_store(void *instance, const ect_402_link_t *link, int64_t value)
{
    ect_link_store(instance, link, value);
}

/** @return the modes for which the objects exist: bit n - 1 for mode n, as in 6502h. */
uint32_t ect_402_modes_of(const ect_402_link_t *links);

ECT_C_END

#endif
