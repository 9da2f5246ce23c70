/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plant: what stands outside a device, and the operator's side of it. A structure of its own beside the description, so
 * that a firmware, whose plant is the real one, links none of it: no names, no texts, no switches.
 *
 * A plant works on the instance of its device. Context: mainline, between two polls of the stack; nothing blocks. Any
 * function pointer may be NULL: the plant then has nothing to do there.
 */
#ifndef ECT_SEAMS_PLANT_H
#define ECT_SEAMS_PLANT_H

#include "seams/device.h"
#include "seams/modbus.h"
#include "seams/signals.h"

/** What a device holds that is too large for a signal, as it stands now. */
typedef struct ect_bulk {
    const uint8_t *data; /**< the device's, until its next call; NULL: it keeps none */
    uint32_t size;
    uint32_t serial; /**< another one whenever the data are others */
} ect_bulk_t;

typedef struct ect_plant {
    const ect_signal_group_t *signal_groups;
    uint16_t signal_group_count;

    /**
     * What outlasts a power cycle of the device, because it stands outside: these bytes of the instance. Whoever drives
     * the slave zeroes all others before a power-on; the first time these are zero too. `outside_size` 0: nothing.
     */
    size_t outside_offset;
    size_t outside_size;

    /**
     * Setting of the device's address switches, 0 none: becomes the configured station alias (0x0012) and the explicit
     * device identification. Asked before each power-on. On a board the firmware reads its own switches.
     */
    uint16_t (*station_alias)(const void *instance);

    /**
     * Whether something is under way that must not be cut off (what a user had saved): who wants to end the device
     * polls on, for a second or two, until it is done.
     */
    bool (*unfinished)(const void *instance);

    /**
     * A user sets a signal to a value within its range; `value` is of the signal's type, `number` counts from 1 (0: the
     * group has no numbers). Asked before it is stored.
     * @return NULL: it is to be stored, `signal_written` follows · "" : done, nothing is to be stored · else why not, a
     * line for the user: nothing has changed
     */
    const char *(*signal_write)(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns);

    /** The value that a user has set is stored: what follows from it. */
    void (*signal_written)(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns);

    /**
     * Says what a value of a SAID signal means: a device keeps numbers, words are its plant's. NULL: none is SAID.
     * @param[out] text  signal->maximum + 1 bytes, zero-terminated by the plant
     */
    void (*signal_say)(const ect_signal_t *signal, uint16_t value, char *text);

    /** What a user may look at as a whole, e.g. the last set of periodic data. NULL: there is no such thing. */
    ect_bulk_t (*bulk)(const void *instance);

    /** How a controller reaches it over Modbus TCP, beside EtherCAT or in its place. NULL: the product has no such
     * side. */
    const ect_modbus_t *modbus;
} ect_plant_t;

/** What can be put on a bus as a twin: a description, and what stands around it. */
typedef struct ect_product {
    const ect_device_t *device;
    const ect_plant_t *plant; /**< NULL: nothing to set or to watch */
} ect_product_t;

#endif
