/* SPDX-License-Identifier: MIT */
/*
 * The process data as Modbus tables (TS-0007 §5.2). Bits are those of the bytes of chapters 8 and 9, the lowest one of
 * byte 0 first. A register has two bytes: a field of 16 bits is a number, of other fields the first byte is the lower
 * half. Sizes are those of the mode; the figures of §5.2 (224 and 64 bytes) predate revision 8.
 */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

enum { MIRROR = 2048 }; /* the input data among the holding registers */

/* Four connections (§5.2). The interface module closes one after a minute without a request, its default. */
enum { CONNECTIONS = 4, IDLE_MS = 60000 };

/* A range in the process data. */
typedef struct area {
    bool inputs;
    uint16_t first;
    uint16_t end; /* of the data, in the units of the table: bits or registers */
} area_t;

static uint16_t input_bytes(const eclink_t *unit)
{
    return eclink_has(unit, ECLINK_FMAP_MULTIARM) ? ECLINK_INPUT_BYTES : ECLINK_IN_RU + ECLINK_IN_RU_STRIDE;
}

static uint16_t output_bytes(const eclink_t *unit)
{
    if (eclink_has(unit, ECLINK_FMAP_PERIODIC))
        return ECLINK_OUTPUT_BYTES;
    return eclink_has(unit, ECLINK_FMAP_COMMANDS) ? ECLINK_OUT_PERIODIC_SIZE : 0;
}

/* @return whether the table contains the entire range */
static bool find(const eclink_t *unit, const ect_modbus_range_t *range, area_t *area)
{
    bool mirror = range->table == ECT_MODBUS_HOLDING_REGISTERS && range->first >= MIRROR;
    area->inputs = mirror || range->table == ECT_MODBUS_DISCRETE_INPUTS || range->table == ECT_MODBUS_INPUT_REGISTERS;
    area->first = (uint16_t)(range->first - (mirror ? MIRROR : 0));
    uint16_t bytes = area->inputs ? input_bytes(unit) : output_bytes(unit);
    area->end = (uint16_t)(ect_modbus_is_bits(range->table) ? 8 * bytes : bytes / 2);
    return area->first + range->count <= area->end;
}

/* Swaps the bytes of registers that are 16-bit fields in 3001h and 3002h: their first byte is the upper half. */
static void turn_numbers(const eclink_t *unit, const area_t *area, uint16_t count, uint16_t *values)
{
    size_t base;
    const ect_object_t *object = eclink_fields(unit, area->inputs, &base);
    for (unsigned int i = 1; i <= object->max_subindex; i++) {
        const ect_entry_t *entry = &object->entries[i];
        size_t at = ((uintptr_t)entry->data - base) / 2;
        if (entry->bit_length == 16 && at >= area->first && at < (size_t)area->first + count)
            values[at - area->first] = (uint16_t)(values[at - area->first] << 8 | values[at - area->first] >> 8);
    }
}

static uint16_t read_bit(const uint8_t *bytes, unsigned int at)
{
    return (bytes[at / 8] & 1u << at % 8) != 0;
}

static ect_modbus_result_t read_range(void *instance, const ect_modbus_range_t *range, uint16_t *values,
                                      uint64_t now_ns)
{
    eclink_t *unit = instance;
    area_t area;
    if (!find(unit, range, &area))
        return ECT_MODBUS_NO_ADDRESS;
    const uint8_t *bytes = area.inputs ? unit->inputs : unit->outputs;
    bool bits = ect_modbus_is_bits(range->table);
    for (unsigned int i = 0; i < range->count; i++) {
        unsigned int at = area.first + i;
        values[i] = bits ? read_bit(bytes, at) : ect_load_le16(bytes + (size_t)2 * at);
    }
    if (!bits)
        turn_numbers(unit, &area, range->count, values);
    if (area.inputs && !eclink_has(unit, ECLINK_FMAP_COMMANDS))
        eclink_modbus_came(unit, now_ns);
    return ECT_MODBUS_DONE;
}

static ect_modbus_result_t may_write(const void *instance, const ect_modbus_range_t *range)
{
    const eclink_t *unit = instance;
    area_t area;
    if (!find(unit, range, &area) || area.inputs)
        return ECT_MODBUS_NO_ADDRESS;
    return unit->in_op || unit->hold_deadline_ns != ECT_NEVER ? ECT_MODBUS_BUSY : ECT_MODBUS_DONE;
}

static void write_bit(uint8_t *bytes, unsigned int at, bool value)
{
    unsigned int mask = 1u << at % 8;
    bytes[at / 8] = (uint8_t)(value ? bytes[at / 8] | mask : bytes[at / 8] & ~mask);
}

static void write_range(void *instance, const ect_modbus_range_t *range, const uint16_t *values, uint64_t now_ns)
{
    eclink_t *unit = instance;
    uint16_t registers[ECT_MODBUS_MOST_REGISTERS];
    area_t area;
    (void)find(unit, range, &area);
    bool bits = ect_modbus_is_bits(range->table);
    for (unsigned int i = 0; bits && i < range->count; i++)
        write_bit(unit->outputs, area.first + i, values[i] != 0);
    if (!bits) {
        memcpy(registers, values, range->count * sizeof *values);
        turn_numbers(unit, &area, range->count, registers);
        for (unsigned int i = 0; i < range->count; i++)
            ect_store_le16(unit->outputs + (size_t)2 * (area.first + i), registers[i]);
    }
    eclink_modbus_came(unit, now_ns);
}

const ect_modbus_t eclink_modbus = {
    .connections = CONNECTIONS,
    .idle_ms = IDLE_MS,
    .read = read_range,
    .may_write = may_write,
    .write = write_range,
};
