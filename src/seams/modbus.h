/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Modbus: the data of a device as the tables of the Modbus data model, for a product with a Modbus interface.
 *
 * A device defines tables and addresses. Function codes, bytes on the wire, connections and their timeouts belong to
 * the host (bus/modbus/modbus.h), which never exceeds the limits of a Modbus request. Addresses are those on the wire:
 * they count from 0.
 *
 * Clauses are those of the MODBUS Application Protocol Specification V1.1b3.
 */
#ifndef ECT_SEAMS_MODBUS_H
#define ECT_SEAMS_MODBUS_H

#include <stdbool.h>
#include <stdint.h>

/** The four tables (§4.3). The first two consist of bits, the others of 16-bit registers. */
typedef enum ect_modbus_table {
    ECT_MODBUS_COILS,
    ECT_MODBUS_DISCRETE_INPUTS,
    ECT_MODBUS_INPUT_REGISTERS,
    ECT_MODBUS_HOLDING_REGISTERS,
} ect_modbus_table_t;

/** Result of a request: the exception codes (§7). */
typedef enum ect_modbus_result {
    ECT_MODBUS_DONE = 0x00,
    ECT_MODBUS_NO_FUNCTION = 0x01,
    ECT_MODBUS_NO_ADDRESS = 0x02, /**< part of the range is outside the table, or not writable */
    ECT_MODBUS_BAD_VALUE = 0x03,  /**< the request is malformed */
    ECT_MODBUS_BUSY = 0x06,       /**< not now: the sender may try again */
} ect_modbus_result_t;

/** Limits of bits and of registers in a request (§6.1, §6.3). */
enum { ECT_MODBUS_MOST_BITS = 2000, ECT_MODBUS_MOST_REGISTERS = 125 };

/** Successive elements of a table. `first` + `count` may exceed its end. */
typedef struct ect_modbus_range {
    ect_modbus_table_t table;
    uint16_t first;
    uint16_t count; /**< 1..ECT_MODBUS_MOST_BITS or ECT_MODBUS_MOST_REGISTERS */
} ect_modbus_range_t;

/**
 * The Modbus interface of a device, constant. Its functions work on the instance. Context: mainline, between two polls
 * of the stack; they do not block, and a call of ::ect_device_t::tick follows. No member is NULL.
 */
typedef struct ect_modbus {
    uint8_t connections; /**< number of simultaneous connections */
    uint32_t idle_ms;    /**< time without a request after which a connection is closed */

    /**
     * Reads a range.
     * @param[out] values  range->count values; bits are 0 or 1; only written with ECT_MODBUS_DONE
     * @return ECT_MODBUS_DONE · ECT_MODBUS_NO_ADDRESS
     */
    ect_modbus_result_t (*read)(void *instance, const ect_modbus_range_t *range, uint16_t *values, uint64_t now_ns);

    /**
     * Checks whether `write` may follow. The instance is unchanged.
     * @return ECT_MODBUS_DONE · ECT_MODBUS_NO_ADDRESS · ECT_MODBUS_BUSY
     */
    ect_modbus_result_t (*may_write)(const void *instance, const ect_modbus_range_t *range);

    /**
     * Writes a range that `may_write` has permitted immediately before.
     * @param values  range->count values; bits are 0 or 1
     */
    void (*write)(void *instance, const ect_modbus_range_t *range, const uint16_t *values, uint64_t now_ns);
} ect_modbus_t;

/** @return whether a table consists of bits. */
static inline bool ect_modbus_is_bits(ect_modbus_table_t table)
{
    return table == ECT_MODBUS_COILS || table == ECT_MODBUS_DISCRETE_INPUTS;
}

#endif
