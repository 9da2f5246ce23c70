/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plant: the surroundings of a device, and the operator's access to it. The structure is separate from the description,
 * so that a firmware, whose plant is real, does not link names, texts and switches.
 *
 * A plant works on the instance of its device. Context: mainline, between two polls of the stack; no function blocks.
 * Any function pointer may be NULL: the plant then has nothing to do there.
 */
#ifndef ECT_SEAMS_PLANT_H
#define ECT_SEAMS_PLANT_H

#include "seams/device.h"
#include "seams/fields.h"
#include "seams/modbus.h"
#include "seams/signals.h"

/** Present data of a device that are too large for a signal. */
typedef struct ect_bulk {
    const uint8_t *data; /**< the device's, valid until its next call; NULL: none */
    uint32_t size;
    uint32_t serial; /**< changes whenever the data change */
} ect_bulk_t;

/** The surroundings of a device. Constant. */
typedef struct ect_plant {
    /**
     * Returns the plant with the present signals, for a device whose description can change (ect_host_t::describe);
     * valid as long as this plant. Only the signals of the returned plant are used. NULL: always this plant.
     */
    const struct ect_plant *(*present)(const void *instance);

    const ect_signal_group_t *signal_groups;
    uint16_t signal_group_count;

    /**
     * Bytes of the instance that outlast a power cycle of the device, because they belong to its surroundings. The
     * program that drives the slave zeroes all other bytes before a power-on, and at the first one these too.
     * `outside_size` 0: none.
     */
    size_t outside_offset;
    size_t outside_size;

    /**
     * Reads the address switches of the device, 0 for none: the setting becomes the configured station alias (0x0012)
     * and the explicit device identification. Called before each power-on. A firmware reads the switches of its board.
     */
    uint16_t (*station_alias)(const void *instance);

    /**
     * Reports whether an operation is under way that must not be interrupted (a save by the user). Before it ends the
     * device, a program continues to poll until the operation is complete, for a second or two.
     */
    bool (*unfinished)(const void *instance);

    /**
     * Checks a value that a user sets on a signal, before it is stored. The value is within the signal's range and has
     * its type; `number` counts from 1 (0: the group has no numbers).
     * @return NULL: the caller stores the value, and `signal_written` follows · "": the plant has acted, and no value
     * is stored · any other text: the reason of the refusal, a line for the user; nothing has changed
     */
    const char *(*signal_write)(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns);

    /** Applies a value set by a user, which is already stored. */
    void (*signal_written)(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns);

    /**
     * Describes a value of a DESCRIBED signal as text: the device has numbers, the plant the texts. NULL: no signal is
     * DESCRIBED.
     * @param[out] text  signal->maximum + 1 bytes; the plant terminates the text by zero
     */
    void (*signal_describe)(const ect_signal_t *signal, uint16_t value, char *text);

    /** Returns data that a user may read as a whole, e.g. the last set of periodic data. NULL: none. */
    ect_bulk_t (*bulk)(const void *instance);

    /** Modbus TCP interface of the device, in addition to EtherCAT or instead. NULL: none. */
    const ect_modbus_t *modbus;

    /** Named bits and values of its entries, an element with index 0 at the end. NULL: none. */
    const ect_field_t *fields;
} ect_plant_t;

/** A product that can be put on a bus as a twin: a description, and its surroundings. */
typedef struct ect_product {
    const ect_device_t *device;
    const ect_plant_t *plant; /**< NULL: no signals */
} ect_product_t;

#endif
