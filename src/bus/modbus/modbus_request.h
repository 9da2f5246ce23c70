/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Parser of Modbus requests: bytes in, ranges of tables out (MODBUS Application Protocol V1.1b3 §6).
 *
 * Supported are functions 1 to 6, 15, 16 and 23, those of an Anybus CompactCom 40 for process data. Context: any.
 */
#ifndef ECT_BUS_MODBUS_MODBUS_REQUEST_H
#define ECT_BUS_MODBUS_MODBUS_REQUEST_H

#include <stddef.h>
#include <stdint.h>

#include "seams/modbus.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The ranges to write, and then to read. A range with count 0: none. */
typedef struct ect_modbus_request {
    ect_modbus_range_t write;
    ect_modbus_range_t read;
} ect_modbus_request_t;

/**
 * Parses a request and checks its length, the number of items, and the value of a coil. The device checks addresses.
 * @param pdu           `length` bytes: function code and data
 * @param[out] request  set with ECT_MODBUS_DONE
 * @return ECT_MODBUS_DONE · ECT_MODBUS_NO_FUNCTION · ECT_MODBUS_BAD_VALUE
 */
ect_modbus_result_t ect_modbus_request(const uint8_t *pdu, size_t length, ect_modbus_request_t *request);

ECT_C_END

#endif
