/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a slave is made of: the description and the port that it drives, and the memory that the caller gives it.
 *
 * How much memory follows from the description. A program that runs any device lets ::ect_slave_take allocate; a
 * firmware for one device asks once, on a PC, and declares arrays of that size. All of it stays the caller's, must live
 * as long as the slave, and belongs to one slave alone. Nothing but `buffer` needs to be zeroed.
 */
#ifndef ECT_SLAVE_CONFIG_H
#define ECT_SLAVE_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "od/od.h"
#include "seams/device.h"
#include "seams/pdi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** A piece of a process image that is contiguous in it and in the instance. Private. */
typedef struct ect_pdo_run {
    const ect_entry_t *entry; /**< copied through the dictionary, or NULL: plain bytes at `data` */
    uint8_t *data;
    uint16_t first_bit;
    uint16_t bits;
} ect_pdo_run_t;

/** How much memory a device needs; the members of ::ect_slave_config_t with the same names say what for. */
typedef struct ect_slave_memory {
    size_t instance;     /**< bytes, aligned as by malloc */
    size_t mailbox;      /**< bytes; 0: it has no mailbox */
    size_t process_data; /**< bytes: the longest image of a SyncManager, one buffer serves all; 0: none */
    size_t runs;         /**< elements of ect_pdo_run_t */
    size_t staging;      /**< bytes: its longest value that a master may write */
    size_t buffer;       /**< bytes; 0: it wants none */
} ect_slave_memory_t;

/**
 * Computes it from the description; where a master may change the mapping, for whatever it may come to. Pure. Walks
 * over the whole dictionary. Not linked by a firmware that does not call it.
 * @param device  one that `ect_device_check` (check/check.h) accepts
 */
ect_slave_memory_t ect_slave_memory(const ect_device_t *device);

/** What a slave is made of. Copied by ::ect_slave_init, which says what is missing. 0 or NULL is a good default
 * wherever the line says nothing else. */
typedef struct ect_slave_config {
    const ect_device_t *device; /**< the description; required */
    const ect_pdi_t *pdi;       /**< the way to the ESC; required, `read` and `write` too */

    /** Who this slave says it is (1018h, and what init copies to the device). NULL: the description's. */
    const ect_identity_t *identity;

    /** Non-volatile memory for 1010h and for the device. NULL: none; a store is then refused. */
    const ect_storage_t *storage;

    /** ect_slave_memory_t::instance bytes; required. Zeroed at each ::ect_slave_init, but for what stands outside. */
    void *instance;
    size_t outside_offset; /**< where in the instance that begins which outlasts a power-on (plant.h) ... */
    size_t outside_size;   /**< ... and how many bytes it has; 0: nothing does */

    /** ect_slave_memory_t::mailbox bytes: one request and two replies. Required with a mailbox. */
    uint8_t *mailbox;

    /** ect_slave_memory_t::process_data bytes: an image on its way. Required with process data. */
    uint8_t *process_data;
    uint16_t
        process_size; /**< how many bytes there are: a mapping that comes to more is refused on the way to SAFEOP */

    /** ect_slave_memory_t::runs elements: how the mapped entries lie. Required with process data. */
    ect_pdo_run_t *runs;
    uint16_t run_count; /**< how many there are: a mapping in more pieces is refused on the way to SAFEOP */

    /** ect_slave_memory_t::staging bytes: where an SDO value that comes in pieces is collected until it is whole. */
    uint8_t *staging;
    uint16_t staging_size; /**< how many there are; a longer value is refused as out of memory */

    /** ect_slave_memory_t::buffer bytes: what ect_host_t::buffer gives the device. The caller zeroes them before each
     * ::ect_slave_init: of so many, most may never have been used. */
    void *buffer;

    /** Explicit device identification, which AL control bit 5 asks for; 0: not offered. */
    uint16_t device_id;

    /** Setting of the address switches, read by the firmware: becomes the configured station alias (0x0012) and takes
     * the place of `device_id`. 0: no switches; the alias is that of the SII. */
    uint16_t switches;

    /**
     * What the interrupt line of the ESC is for. false: for everything that the stack deals with, each event while
     * there is something to do about it. true: for process data and SYNC0 alone, and drives ::ect_slave_cycle; mainline
     * then learns of the others by reading the register, whatever ect_pdi_t::al_event says.
     */
    bool line_for_cycle;

    /**
     * Values and process data are the caller's work. Entries keep what stands in their memory at ::ect_slave_init; the
     * SyncManagers of process data are checked and switched, and no byte of theirs is moved; ::ect_slave_cycle does
     * nothing. Mapped may then also be what the dictionary does not call mappable, OP is entered without waiting for
     * outputs, and `process_data` and `runs` are not touched (their sizes still are the most that a mapping may come
     * to).
     */
    bool exchange_is_callers;
} ect_slave_config_t;

/**
 * Fills in what ::ect_slave_memory asks for, but for `buffer`, which a slave can do without: `instance`, `mailbox`,
 * `process_data`, `runs`, `staging`, and how large they are. The others are left as they are.
 * @param config  its `device` says what is needed
 * @param take    gives so many bytes, 1 or more, aligned for anything, for as long as the slave is used; NULL: there
 *                are none. Called once for each that is not empty; those that are become NULL, but `instance` and
 *                `process_data` have a byte at least
 * @return whether there was memory for all
 */
bool ect_slave_take(ect_slave_config_t *config, void *(*take)(void *ctx, size_t bytes), void *ctx);

ECT_C_END

#endif
