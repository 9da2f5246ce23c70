/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder over a dictionary: CiA 406 for a foreign description, such as an ESI file.
 *
 * A shaft (or the carriage of a linear encoder) moves at a speed set by the user. Position and speed are written to the
 * linked entries of the dictionary, with the measuring units, the range, the direction and the preset that the master
 * has written there. An object without an entry has no effect.
 *
 * No function allocates, blocks or reads a clock. The caller owns encoder, surroundings, links and instance, which must
 * not move. Context: mainline and exchange, one at a time.
 */
#ifndef ECT_PROFILES_ENCODER_ENCODER_H
#define ECT_PROFILES_ENCODER_ENCODER_H

#include "od/link.h"
#include "seams/signals.h"

ECT_C_BEGIN

/** Limit of encoders of a device: elements of 6020h. */
enum { ECT_ENCODERS = 8 };

/**
 * V(name, index, sub-index, kind): kind VAR: one for the entire device · MEMBER: sub-index of a record of the device ·
 * FIRST: a VAR of the first encoder · EACH: an element for each encoder.
 */
#define ECT_ENCODER_VALUES(V)                                                                                          \
    V(OPERATING, 0x6000, 0, VAR)                                                                                       \
    V(UNITS, 0x6001, 0, VAR)                                                                                           \
    V(RANGE, 0x6002, 0, VAR)                                                                                           \
    V(PRESET, 0x6003, 0, FIRST)                                                                                        \
    V(POSITION, 0x6004, 0, FIRST)                                                                                      \
    V(STEP, 0x6005, 1, MEMBER)                                                                                         \
    V(SPEED_STEP, 0x6005, 2, MEMBER)                                                                                   \
    V(WIDE_POSITION, 0x6008, 0, FIRST)                                                                                 \
    V(WIDE_PRESET, 0x6009, 0, FIRST)                                                                                   \
    V(WIDE_RANGE, 0x600A, 0, VAR)                                                                                      \
    V(WIDE_RAW, 0x600B, 0, FIRST)                                                                                      \
    V(RAW, 0x600C, 0, FIRST)                                                                                           \
    V(CHANNEL_PRESET, 0x6010, 0, EACH)                                                                                 \
    V(CHANNEL_POSITION, 0x6020, 0, EACH)                                                                               \
    V(SPEED, 0x6030, 0, EACH)                                                                                          \
    V(MULTIPLIER, 0x6031, 3, MEMBER)                                                                                   \
    V(DIVISOR, 0x6031, 4, MEMBER)                                                                                      \
    V(STATUS, 0x6500, 0, VAR)                                                                                          \
    V(RESOLUTION, 0x6501, 0, VAR)                                                                                      \
    V(TURNS, 0x6502, 0, VAR)                                                                                           \
    V(ALARMS, 0x6503, 0, VAR)                                                                                          \
    V(WARNINGS, 0x6505, 0, VAR)                                                                                        \
    V(OFFSET, 0x6509, 0, FIRST)                                                                                        \
    V(CHANNEL_OFFSET, 0x650C, 0, EACH)

#define ECT_ENCODER_NAME(name, index, subindex, kind) ECT_ENCODER_##name,
typedef enum ect_encoder_value { ECT_ENCODER_VALUES(ECT_ENCODER_NAME) ECT_ENCODER_VALUE_COUNT } ect_encoder_value_t;
#undef ECT_ENCODER_NAME

/** Bits of 6000h. */
enum {
    ECT_ENCODER_COUNTERCLOCKWISE = 0x0001, /**< code sequence: counterclockwise turns count up */
    ECT_ENCODER_SCALING = 0x0004,          /**< 6001h and 6002h apply */
    ECT_ENCODER_REVERSE = 0x0008,          /**< measuring direction of a linear encoder */
};

/** Unit of 6030h on the bus. */
enum { ECT_ENCODER_UNITS_A_SECOND, ECT_ENCODER_RPM, ECT_ENCODER_TENTH_RPM };

/** The shaft, and simulated faults; these outlast a power cycle of the encoder. Zeroed: a shaft at rest at 0. */
typedef struct ect_encoder_shaft {
    double position;       /**< turns, clockwise; of a linear encoder mm */
    double speed;          /**< 1/min, of a linear encoder mm/s */
    uint32_t resolution;   /**< units per turn or mm, if the dictionary has none; 0: 65536, linear 1000 */
    uint16_t alarms;       /**< 6503h */
    uint16_t warnings;     /**< 6505h */
    uint8_t velocity_unit; /**< ECT_ENCODER_UNITS_A_SECOND, ... */
} ect_encoder_shaft_t;

/** One encoder. Zeroed before ::ect_encoder_init. */
typedef struct ect_encoder {
    const ect_link_t *links; /**< ECT_ENCODER_VALUE_COUNT */
    ect_encoder_shaft_t *shaft;
    void *instance;
    double from;      /**< position at `from_ns` */
    uint64_t from_ns; /**< begin of the present speed */
    int64_t offset;   /**< added to the position: by a preset */
    int64_t counts;   /**< signal: the position of the master */
    int64_t velocity; /**< signal: 6030h before it is limited to the width of its entry */
} ect_encoder_t;

/**
 * Links an encoder to a dictionary.
 * @param od          entries with offsets into an instance; its instance is not used
 * @param number      0..ECT_ENCODERS - 1
 * @param[out] links  ECT_ENCODER_VALUE_COUNT of them
 * @return whether the encoder has a position: 6004h or 6008h (number 0), or an element of 6020h
 */
bool ect_encoder_links_find(const ect_od_t *od, unsigned int number, ect_link_t *links);

/** @return whether the encoder measures a length: it has 6005h:1 and no 6001h */
bool ect_encoder_is_linear(const ect_link_t *links);

/** @return whether the profile has a behaviour for an object */
bool ect_encoder_knows(uint16_t index);

/** @return whether the encoder itself writes a value, and a user must not */
bool ect_encoder_is_actual(ect_encoder_value_t value);

/** Power-on. The linked entries have the defaults of the file. */
void ect_encoder_init(ect_encoder_t *e, const ect_link_t *links, ect_encoder_shaft_t *shaft, void *instance,
                      uint64_t now_ns);

/** Advances the time; writes position, speed and diagnosis to the dictionary. */
void ect_encoder_advance(ect_encoder_t *e, uint64_t now_ns);

/** Applies a position or speed of the shaft set by a user; due after ::ect_encoder_advance with the same time. */
void ect_encoder_moved(ect_encoder_t *e, uint64_t now_ns);

/** @return the time of the next call of ::ect_encoder_advance: a millisecond later while the shaft turns, else
 * UINT64_MAX */
uint64_t ect_encoder_next(const ect_encoder_t *e, uint64_t now_ns);

/** Finds the value of an object of encoder `number`. @return whether the object has a value */
bool ect_encoder_value_of(unsigned int number, uint16_t index, uint8_t subindex, ect_encoder_value_t *value);

/** @return ECT_OK, or the reason to refuse `wanted` for `value` */
ect_reason_t ect_encoder_check(const ect_encoder_t *e, ect_encoder_value_t value, int64_t wanted);

/** Handles a write of an entry by SDO: a preset becomes the position. */
void ect_encoder_written(ect_encoder_t *e, ect_encoder_value_t value, uint64_t now_ns);

/** Signals over ::ect_encoder_t. */
extern const ect_signal_t ect_encoder_signals[];
extern const uint16_t ect_encoder_signal_count;
/** Signals over ::ect_encoder_shaft_t, of a rotary and of a linear encoder, in equal number. */
extern const ect_signal_t ect_encoder_rotary_signals[];
extern const ect_signal_t ect_encoder_linear_signals[];
extern const uint16_t ect_encoder_shaft_signal_count;

ECT_C_END

#endif
