/* SPDX-License-Identifier: MIT */
#include "support/ranger.h"

#include <string.h>

#include "devices/optoncdt2300/optoncdt2300.h"

enum { CONTROL = 0x20, VALUE_BYTES = 4, ASSIGNMENT = 0x1C13, MAPPING = 0x1A00, CHOICE = 0x21B0 };

void ranger_open(ranger_t *r)
{
    ect_twin_config_t twin = ect_twin_default(&ect_optoncdt2300, &ect_optoncdt2300_plant);
    memset(r, 0, sizeof *r);
    wire_open_twins(&r->w, &twin, 1);
}

void ranger_close(ranger_t *r)
{
    wire_close(&r->w);
}

opto_t *ranger_instance(ranger_t *r)
{
    return ect_chain_slave(r->w.chain, 0)->config.instance;
}

uint32_t ranger_upload(ranger_t *r, uint16_t index, uint8_t subindex, uint32_t *value)
{
    uint8_t data[64] = {0};
    size_t size = sizeof data;
    uint32_t code = wire_sdo_upload(&r->w, 0, index, subindex, false, data, &size);
    *value = ect_load_le32(data);
    return code;
}

uint32_t ranger_download(ranger_t *r, uint16_t index, uint8_t subindex, uint32_t value, size_t size)
{
    uint8_t data[8];
    ect_store_le64(data, value);
    return wire_sdo_download(&r->w, 0, index, subindex, false, data, size);
}

uint32_t ranger_number(ranger_t *r, uint16_t index, uint8_t subindex)
{
    uint32_t value = 0;
    uint32_t code = ranger_upload(r, index, subindex, &value);
    if (code != 0)
        fail_msg("%04Xh:%u cannot be read: %08X", index, subindex, code);
    return value;
}

void ranger_write(ranger_t *r, uint16_t index, uint8_t subindex, uint32_t value, size_t size)
{
    uint32_t code = ranger_download(r, index, subindex, value, size);
    if (code != 0)
        fail_msg("%04Xh:%u := %u: %08X", index, subindex, value, code);
}

uint32_t ranger_text(ranger_t *r, uint16_t index, uint8_t subindex, const char *text)
{
    return wire_sdo_download(&r->w, 0, index, subindex, false, text, strlen(text));
}

void ranger_expert(ranger_t *r)
{
    wire_go(&r->w, 0, ECT_STATE_PREOP);
    assert_int_equal(ranger_text(r, 0x2001, 2, "000"), 0);
}

void ranger_select(ranger_t *r, uint32_t measurements, unsigned int samples)
{
    ranger_write(r, ASSIGNMENT, 0, 0, 1);
    for (uint8_t n = 0; n < OPTO_VALUES; n++)
        ranger_write(r, CHOICE, (uint8_t)(OPTO_FIRST_CHOICE + n), measurements >> n & 1, 1);
    for (uint8_t n = 0; n < samples; n++)
        ranger_write(r, ASSIGNMENT, (uint8_t)(n + 1), MAPPING + n, 2);
    ranger_write(r, ASSIGNMENT, 0, samples, 1);
}

void ranger_go(ranger_t *r, uint8_t state)
{
    uint16_t code = 0;
    r->bytes = (uint16_t)(ranger_number(r, MAPPING, 0) * VALUE_BYTES * ranger_number(r, ASSIGNMENT, 0));
    wire_set_sm(&r->w, 0, 3, RANGER_INPUTS, r->bytes, CONTROL);
    for (uint8_t to = ECT_STATE_SAFEOP; to <= state; to = (uint8_t)(to << 1)) {
        uint8_t status = wire_al(&r->w, 0, to, &code);
        if (status != to)
            fail_msg("with %u bytes: expected AL status %02X, got %02X with code %04X", r->bytes, to, status, code);
    }
}

void ranger_sync0(ranger_t *r, uint32_t cycle_ns)
{
    uint8_t number[8];
    assert_int_equal(wire_read(&r->w, 0, ECT_REG_DC_SYSTEM_TIME, number, 8), 1);
    ect_store_le64(number, ect_load_le64(number) + 10 * MS);
    assert_int_equal(wire_write16(&r->w, 0, ECT_REG_DC_CYCLIC_CONTROL, 0), 1);
    assert_int_equal(wire_write(&r->w, 0, ECT_REG_DC_START_TIME, number, 8), 1);
    ect_store_le32(number, cycle_ns);
    assert_int_equal(wire_write(&r->w, 0, ECT_REG_DC_SYNC0_CYCLE, number, 4), 1);
    assert_int_equal(wire_write16(&r->w, 0, ECT_REG_DC_CYCLIC_CONTROL, 0x0300), 1);
}

void ranger_wait(ranger_t *r, uint64_t ns)
{
    wire_advance(&r->w, ns);
    assert_int_equal(wire_read(&r->w, 0, RANGER_INPUTS, r->in, r->bytes), 1);
}

int32_t ranger_value(const ranger_t *r, unsigned int n)
{
    assert_true((n + 1) * VALUE_BYTES <= r->bytes);
    return (int32_t)ect_load_le32(r->in + (size_t)n * VALUE_BYTES);
}
