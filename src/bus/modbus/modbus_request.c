/* SPDX-License-Identifier: MIT */
#include "bus/modbus/modbus_request.h"

#include <stdbool.h>

#include "wire/bytes.h"

/* Most bits, most registers, and most registers of a request that also reads (§6.11, §6.12, §6.17). */
enum { WRITE_BITS = 1968, WRITE_REGISTERS = 123, WRITE_REGISTERS_AND_READ = 121 };

static bool take_range(ect_modbus_range_t *range, ect_modbus_table_t table, const uint8_t *bytes, uint16_t most)
{
    *range = (ect_modbus_range_t){table, ect_load_be16(bytes), ect_load_be16(bytes + 2)};
    return range->count >= 1 && range->count <= most;
}

static bool take_read(const uint8_t *pdu, size_t length, ect_modbus_table_t table, ect_modbus_request_t *request)
{
    uint16_t most = ect_modbus_is_bits(table) ? ECT_MODBUS_MOST_BITS : ECT_MODBUS_MOST_REGISTERS;
    return length == 5 && take_range(&request->read, table, pdu + 1, most);
}

static bool take_one(const uint8_t *pdu, size_t length, ect_modbus_table_t table, ect_modbus_request_t *request)
{
    if (length != 5)
        return false;
    uint16_t value = ect_load_be16(pdu + 3);
    request->write = (ect_modbus_range_t){table, ect_load_be16(pdu + 1), 1};
    return table != ECT_MODBUS_COILS || value == 0x0000 || value == 0xFF00;
}

/* Parses a range, the number of bytes, and the bytes. */
static bool take_write(const uint8_t *bytes, size_t length, ect_modbus_table_t table, uint16_t most,
                       ect_modbus_request_t *request)
{
    if (length < 5 || !take_range(&request->write, table, bytes, most))
        return false;
    unsigned int count = request->write.count;
    unsigned int size = ect_modbus_is_bits(table) ? (count + 7) / 8 : 2 * count;
    return bytes[4] == size && length == 5 + (size_t)size;
}

static bool take_both(const uint8_t *pdu, size_t length, ect_modbus_request_t *request)
{
    return length >= 5 &&
           take_range(&request->read, ECT_MODBUS_HOLDING_REGISTERS, pdu + 1, ECT_MODBUS_MOST_REGISTERS) &&
           take_write(pdu + 5, length - 5, ECT_MODBUS_HOLDING_REGISTERS, WRITE_REGISTERS_AND_READ, request);
}

ect_modbus_result_t ect_modbus_request(const uint8_t *pdu, size_t length, ect_modbus_request_t *request)
{
    bool good;
    *request = (ect_modbus_request_t){0};
    switch (length > 0 ? pdu[0] : 0) {
    case 1:
        good = take_read(pdu, length, ECT_MODBUS_COILS, request);
        break;
    case 2:
        good = take_read(pdu, length, ECT_MODBUS_DISCRETE_INPUTS, request);
        break;
    case 3:
        good = take_read(pdu, length, ECT_MODBUS_HOLDING_REGISTERS, request);
        break;
    case 4:
        good = take_read(pdu, length, ECT_MODBUS_INPUT_REGISTERS, request);
        break;
    case 5:
        good = take_one(pdu, length, ECT_MODBUS_COILS, request);
        break;
    case 6:
        good = take_one(pdu, length, ECT_MODBUS_HOLDING_REGISTERS, request);
        break;
    case 15:
        good = take_write(pdu + 1, length - 1, ECT_MODBUS_COILS, WRITE_BITS, request);
        break;
    case 16:
        good = take_write(pdu + 1, length - 1, ECT_MODBUS_HOLDING_REGISTERS, WRITE_REGISTERS, request);
        break;
    case 23:
        good = take_both(pdu, length, request);
        break;
    default:
        return ECT_MODBUS_NO_FUNCTION;
    }
    return good ? ECT_MODBUS_DONE : ECT_MODBUS_BAD_VALUE;
}
