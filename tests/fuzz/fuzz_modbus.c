/* SPDX-License-Identifier: MIT */
/*
 * Modbus requests with any content to each of the base units, with time between them. A read must return the value
 * written before, bits must be 0 or 1, and only time may change input data.
 *
 * The input: a byte that chooses the unit, then requests: a length and so many bytes, function code first; a length of
 * 0 is half a second.
 */
#include <assert.h>
#include <string.h>

#include "bus/chain/chain.h"
#include "bus/modbus/modbus_request.h"
#include "devices/eclink/eclink.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MOST_REQUESTS = 64 };

typedef struct unit {
    ect_chain_t *chain;
    uint64_t now_ns;
} unit_t;

static void let_time_pass(unit_t *u, uint64_t ns)
{
    uint64_t end_ns = u->now_ns + ns;
    for (uint64_t due_ns = 0; u->now_ns < end_ns; u->now_ns = due_ns < end_ns ? due_ns : end_ns)
        due_ns = ect_chain_poll(u->chain, u->now_ns);
    (void)ect_chain_poll(u->chain, u->now_ns);
}

static void check_items(const ect_modbus_range_t *range, const uint16_t *values)
{
    for (unsigned int i = 0; ect_modbus_is_bits(range->table) && i < range->count; i++)
        assert(values[i] <= 1);
}

static void write_and_look(const ect_modbus_t *modbus, void *instance, const ect_modbus_range_t *range,
                           const uint8_t *pdu, size_t length, uint64_t now_ns)
{
    const ect_modbus_range_t inputs = {ECT_MODBUS_INPUT_REGISTERS, 0, 33};
    uint16_t values[ECT_MODBUS_MOST_BITS], back[ECT_MODBUS_MOST_BITS], before[33], after[33];
    bool bits = ect_modbus_is_bits(range->table);
    for (unsigned int i = 0; i < range->count; i++)
        values[i] = bits ? pdu[i % length] & 1u : (uint16_t)(pdu[i % length] * 256u + i);
    assert(modbus->read(instance, &inputs, before, now_ns) == ECT_MODBUS_DONE);
    modbus->write(instance, range, values, now_ns);
    assert(modbus->read(instance, range, back, now_ns) == ECT_MODBUS_DONE);
    assert(memcmp(values, back, range->count * sizeof values[0]) == 0);
    assert(modbus->read(instance, &inputs, after, now_ns) == ECT_MODBUS_DONE);
    assert(memcmp(before, after, sizeof before) == 0);
}

static void serve(unit_t *u, const uint8_t *pdu, size_t length)
{
    ect_modbus_request_t request;
    uint16_t values[ECT_MODBUS_MOST_BITS];
    void *instance;
    const ect_modbus_t *modbus = ect_chain_modbus(u->chain, 0, &instance);
    if (ect_modbus_request(pdu, length, &request) != ECT_MODBUS_DONE)
        return;
    assert(request.read.count > 0 || request.write.count > 0);
    if (request.write.count > 0 && modbus->may_write(instance, &request.write) == ECT_MODBUS_DONE)
        write_and_look(modbus, instance, &request.write, pdu, length, u->now_ns);
    if (request.read.count > 0 && modbus->read(instance, &request.read, values, u->now_ns) == ECT_MODBUS_DONE)
        check_items(&request.read, values);
    ect_chain_wake(u->chain, 0);
    (void)ect_chain_poll(u->chain, u->now_ns);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const ect_device_t *const devices[] = {&ect_eclink_map1, &ect_eclink_map3, &ect_eclink_map7,
                                                  &ect_eclink_multiarm};
    unit_t u = {.now_ns = 1000000000};
    if (size == 0)
        return 0;
    const ect_twin_config_t twin = ect_twin_default(devices[data[0] % 4], &ect_eclink_plant);
    u.chain = ect_chain_new(&twin, 1, u.now_ns);
    assert(u.chain);
    size_t at = 1;
    for (unsigned int n = 0; at < size && n < MOST_REQUESTS; n++) {
        size_t length = data[at] < size - at ? data[at] : size - at - 1;
        if (length == 0)
            let_time_pass(&u, 500000000);
        else
            serve(&u, data + at + 1, length);
        at += 1 + length;
    }
    ect_chain_free(u.chain);
    return 0;
}
