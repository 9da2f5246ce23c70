/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Configuration of a slave: its description, its port, and the memory that the caller provides.
 *
 * The size of the memory follows from the description. A program for any device lets ::ect_slave_take allocate it; a
 * firmware for one device determines the sizes once, on a PC, and declares arrays. All memory remains the caller's,
 * must outlive the slave, and belongs to one slave alone. Only `buffer` needs to be zeroed.
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

/** A piece that is contiguous both in a process image and in the instance. Private. */
typedef struct ect_pdo_run {
    const ect_entry_t *entry; /**< copied through the dictionary; NULL: plain bytes at `data` */
    uint8_t *data;
    uint16_t first_bit;
    uint16_t bits;
} ect_pdo_run_t;

/** Memory that a device needs, for the members of ::ect_slave_config_t with the same names. */
typedef struct ect_slave_memory {
    size_t instance;     /**< bytes, aligned as by malloc */
    size_t mailbox;      /**< bytes; 0: no mailbox */
    size_t process_data; /**< bytes: the longest image of a SyncManager; one buffer serves all; 0: none */
    size_t runs;         /**< elements of ect_pdo_run_t */
    size_t staging;      /**< bytes: the longest value that a master may write */
    size_t buffer;       /**< bytes; 0: none */
} ect_slave_memory_t;

/**
 * Computes the memory from the description, for the largest mapping that a master may configure. Pure. Visits the whole
 * dictionary. Only linked by a firmware that calls it.
 * @param device  one that `ect_device_check` (check/check.h) accepts
 * @return the sizes
 */
ect_slave_memory_t ect_slave_memory(const ect_device_t *device);

/** Configuration of a slave. ::ect_slave_init copies it and reports missing members. 0 or NULL is a good default unless
 * the line of a member states otherwise. */
typedef struct ect_slave_config {
    const ect_device_t *device; /**< the description; required */
    const ect_pdi_t *pdi;       /**< the port to the ESC; required, with `read` and `write` */

    /** Identity of this slave (1018h, and the instance's ::ect_standard_t). NULL: that of the description. */
    const ect_identity_t *identity;

    /** Non-volatile memory for 1010h and for the device. NULL: none; a store is refused then. */
    const ect_storage_t *storage;

    /** ect_slave_memory_t::instance bytes; required. Each ::ect_slave_init zeroes them, except those that belong to the
     * outside. */
    void *instance;
    size_t outside_offset; /**< offset of the bytes of the instance that outlast a power-on (plant.h) */
    size_t outside_size;   /**< their number; 0: none */

    /** ect_slave_memory_t::mailbox bytes: one request and two replies. Required with a mailbox. */
    uint8_t *mailbox;

    /** ect_slave_memory_t::process_data bytes: one process image. Required with process data. */
    uint8_t *process_data;
    uint16_t process_size; /**< bytes of `process_data`: a longer mapping is refused on the way to SAFEOP */

    /** ect_slave_memory_t::runs elements: the layout of the mapped entries. Required with process data. */
    ect_pdo_run_t *runs;
    uint16_t run_count; /**< elements of `runs`: a mapping in more pieces is refused on the way to SAFEOP */

    /** ect_slave_memory_t::staging bytes: an SDO value that arrives in pieces is collected here. */
    uint8_t *staging;
    uint16_t staging_size; /**< bytes of `staging`; a longer value is refused as out of memory */

    /** ect_slave_memory_t::buffer bytes, passed to the device as ect_host_t::buffer. The caller zeroes them before each
     * ::ect_slave_init; the stack does not, because most of a large buffer may never have been used. */
    void *buffer;

    /** Explicit device identification, requested by AL control bit 5; 0: not offered. */
    uint16_t device_id;

    /** Setting of the address switches, read by the firmware: becomes the configured station alias (0x0012) and
     * replaces `device_id`. 0: no switches; the alias is that of the SII. */
    uint16_t switches;

    /**
     * Use of the ESC's interrupt line. false: the line is active for every event that the stack has to handle. true: it
     * is active for process data and SYNC0 only, and its interrupt calls ::ect_slave_cycle; mainline then reads the
     * register for the other events, regardless of ect_pdi_t::al_event.
     */
    bool line_for_cycle;

    /**
     * The caller moves values and process data. Entries keep the content of their memory at ::ect_slave_init; the stack
     * checks and switches the SyncManagers of process data, but transfers none of their bytes; ::ect_slave_cycle does
     * nothing. A mapping may then contain entries that the dictionary does not declare mappable, OP is entered without
     * waiting for outputs, and `process_data` and `runs` are not accessed (their sizes still limit the mapping).
     */
    bool exchange_is_callers;
} ect_slave_config_t;

/**
 * Allocates the memory of ::ect_slave_memory except `buffer`, which is optional: `instance`, `mailbox`, `process_data`,
 * `runs`, `staging`, and their sizes. Other members are unchanged.
 * @param config  its `device` determines the sizes
 * @param take    returns that many bytes, 1 or more, aligned for any type, for the life of the slave; NULL: no memory
 * is left. Called once for each member that is not empty; empty members become NULL, but `instance` and `process_data`
 * always get at least one byte
 * @param ctx     passed to `take`
 * @return whether there was memory for all
 */
bool ect_slave_take(ect_slave_config_t *config, void *(*take)(void *ctx, size_t bytes), void *ctx);

ECT_C_END

#endif
