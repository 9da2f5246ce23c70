/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A measuring input over a dictionary: CiA 404 for a foreign description, such as an ESI file.
 *
 * A user sets the physical value at the sensor. The sensor converts it to the field value, by the two points of the
 * linear scaling in the dictionary at power-on; the input converts the field value to the process value, by the points
 * and the offset that the master has written. Entries of a quantity in several formats agree: 6xxxh is floating point,
 * 7xxxh has 16 bits and 9xxxh 32 bits, both with the decimal digits of 6132h for process values. An object without an
 * entry has no effect.
 *
 * No function allocates, blocks or reads a clock. The caller owns input, sensor, links and instance, which must not
 * move. Context: mainline and exchange, one at a time.
 */
#ifndef ECT_PROFILES_MEASURING_MEASURING_H
#define ECT_PROFILES_MEASURING_MEASURING_H

#include "od/link.h"
#include "seams/signals.h"

ECT_C_BEGIN

/** Limit of inputs of a device: elements of 6130h. */
enum { ECT_MEASURING_INPUTS = 32 };

/** Q(NAME, last three digits of the index, kind): an array in up to three formats. kind FIELD: of the field value. */
#define ECT_MEASURING_QUANTITIES(Q)                                                                                    \
    Q(FIELD, 0x100, FIELD)                                                                                             \
    Q(FIELD_1, 0x120, FIELD)                                                                                           \
    Q(PROCESS_1, 0x121, PROCESS)                                                                                       \
    Q(FIELD_2, 0x122, FIELD)                                                                                           \
    Q(PROCESS_2, 0x123, PROCESS)                                                                                       \
    Q(OFFSET, 0x124, PROCESS)                                                                                          \
    Q(PROCESS, 0x130, PROCESS)                                                                                         \
    Q(SPAN_START, 0x148, PROCESS)                                                                                      \
    Q(SPAN_END, 0x149, PROCESS)

#define ECT_MEASURING_NAME(name, index, kind) ECT_MEASURING_##name,
typedef enum ect_measuring_quantity {
    ECT_MEASURING_QUANTITIES(ECT_MEASURING_NAME) ECT_MEASURING_QUANTITY_COUNT
} ect_measuring_quantity_t;
#undef ECT_MEASURING_NAME

/** Formats of a quantity: objects at 6000h, 9000h and 7000h. */
enum { ECT_MEASURING_REAL, ECT_MEASURING_INT32, ECT_MEASURING_INT16, ECT_MEASURING_FORMATS };

/** Bits of 6150h. */
enum { ECT_MEASURING_INVALID = 0x01, ECT_MEASURING_ABOVE = 0x02, ECT_MEASURING_BELOW = 0x04 };

/** Value of 6125h that makes the process value 0: "zero". */
#define ECT_MEASURING_ZERO UINT32_C(0x6F72657A)

/** Entries of an input. */
typedef struct ect_measuring_links {
    ect_link_t quantity[ECT_MEASURING_QUANTITY_COUNT][ECT_MEASURING_FORMATS];
    ect_link_t autozero; /**< 6125h */
    ect_link_t digits;   /**< 6132h */
    ect_link_t status;   /**< 6150h */
} ect_measuring_links_t;

/** The sensor, which outlasts a power cycle of the input. Zeroed: a working sensor at 0. */
typedef struct ect_measuring_sensor {
    double value;    /**< physical value, in the unit of the process value at power-on */
    uint8_t invalid; /**< the input reports an invalid value, and keeps the last one */
} ect_measuring_sensor_t;

/** Two points of a line. */
typedef struct ect_measuring_line {
    double field[2];
    double process[2];
} ect_measuring_line_t;

/** One input. Zeroed before ::ect_measuring_init. */
typedef struct ect_measuring {
    const ect_measuring_links_t *links;
    const ect_measuring_sensor_t *sensor;
    void *instance;
    ect_measuring_line_t line; /**< of the sensor: the scaling at power-on */
    double field;              /**< signal: the field value */
    double process;            /**< signal: the process value */
} ect_measuring_t;

/**
 * Links an input to a dictionary.
 * @param od          entries with offsets into an instance; its instance is not used
 * @param number      0..ECT_MEASURING_INPUTS - 1
 * @param[out] links  of the input
 * @return whether the input has a process value: 6130h, 7130h or 9130h
 */
bool ect_measuring_links_find(const ect_od_t *od, unsigned int number, ect_measuring_links_t *links);

/** @return whether the profile has a behaviour for an object */
bool ect_measuring_knows(uint16_t index);

/** @return whether the input has both points of the scaling */
bool ect_measuring_scales(const ect_measuring_links_t *links);

/** @return whether the input itself writes the value at an offset of the instance, and a user must not */
bool ect_measuring_writes(const ect_measuring_links_t *links, uint32_t offset);

/** Power-on. The linked entries have the defaults of the file. */
void ect_measuring_init(ect_measuring_t *m, const ect_measuring_links_t *links, const ect_measuring_sensor_t *sensor,
                        void *instance);

/** Writes field value, process value and status to the dictionary. */
void ect_measuring_update(ect_measuring_t *m);

/** @return the entry of input `number` at an address of an SDO; NULL: not an entry of this input */
const ect_link_t *ect_measuring_link(const ect_measuring_links_t *links, unsigned int number, uint16_t index,
                                     uint8_t subindex);

/** @return ECT_OK, or the reason to refuse `wanted` for an entry of ::ect_measuring_link */
ect_reason_t ect_measuring_check(const ect_measuring_links_t *links, const ect_link_t *link, int64_t wanted);

/** Handles a write of an entry by SDO or by a user; the entries of its quantity in other formats follow. */
void ect_measuring_written(ect_measuring_t *m, uint32_t offset);

/** Signals over ::ect_measuring_t, without a unit; the first one has the unit of the process value. */
enum { ECT_MEASURING_SIGNALS = 2 };
extern const ect_signal_t ect_measuring_signals[ECT_MEASURING_SIGNALS];
/** Signals over ::ect_measuring_sensor_t, likewise. */
enum { ECT_MEASURING_SENSOR_SIGNALS = 2 };
extern const ect_signal_t ect_measuring_sensor_signals[ECT_MEASURING_SENSOR_SIGNALS];

ECT_C_END

#endif
