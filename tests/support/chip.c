/* SPDX-License-Identifier: MIT */
#include "support/chip.h"

#include <stdlib.h>
#include <string.h>

enum { DATA = 10 };

chip_t *chip_new(const char *name)
{
    chip_t *c = calloc(1, sizeof *c);
    const ect_esc_personality_t *personality = ect_esc_personality(name);
    assert_non_null(c);
    assert_non_null(personality);
    c->personality = *personality;
    ect_store_le16(c->sii + 14, 0x88A4);
    c->config = (ect_esc_config_t){
        .personality = &c->personality, .memory = c->memory, .sii = c->sii, .sii_size = sizeof c->sii, .open_ports = 3};
    c->w.now_ns = 5000 * MS;
    chip_power_on(c);
    return c;
}

void chip_power_on(chip_t *c)
{
    assert_int_equal(ect_esc_init(&c->esc, &c->config, c->w.now_ns), 0);
}

int chip_setup(void **state)
{
    *state = chip_new("et1100");
    return 0;
}

int chip_teardown(void **state)
{
    free(*state);
    return 0;
}

void chip_transmit(chip_t *c)
{
    assert_int_equal(ect_esc_process(&c->esc, c->w.frame, c->w.frame_length, c->w.now_ns), ECT_FRAME_FORWARD);
}

unsigned int chip_send(chip_t *c, uint8_t command, uint16_t ado, void *data, uint16_t length)
{
    wire_build(&c->w, command, 0, ado, data, length);
    chip_transmit(c);
    memcpy(data, wire_datagram(&c->w, 0) + DATA, length);
    return wire_wkc(&c->w, 0);
}

unsigned int chip_write(chip_t *c, uint16_t ado, uint64_t value, uint16_t length)
{
    uint8_t bytes[8];
    ect_store_le64(bytes, value);
    return chip_send(c, APWR, ado, bytes, length);
}

uint64_t chip_read(chip_t *c, uint16_t ado, uint16_t length)
{
    uint8_t bytes[8] = {0};
    assert_int_equal(chip_send(c, APRD, ado, bytes, length), 1);
    return ect_load_le64(bytes);
}

void chip_pdi_write(chip_t *c, uint16_t address, uint64_t value, uint16_t length)
{
    uint8_t bytes[8];
    ect_store_le64(bytes, value);
    assert_int_equal(ect_esc_pdi_write(&c->esc, address, bytes, length), 0);
}

uint64_t chip_pdi_read(chip_t *c, uint16_t address, uint16_t length)
{
    uint8_t bytes[8] = {0};
    assert_int_equal(ect_esc_pdi_read(&c->esc, address, bytes, length), 0);
    return ect_load_le64(bytes);
}

void chip_advance(chip_t *c, uint64_t ns)
{
    uint64_t end_ns = c->w.now_ns + ns;
    uint64_t next_ns = ect_esc_tick(&c->esc, c->w.now_ns);
    while (next_ns <= end_ns) {
        c->w.now_ns = next_ns > c->w.now_ns ? next_ns : c->w.now_ns + 1;
        next_ns = ect_esc_tick(&c->esc, c->w.now_ns);
    }
    c->w.now_ns = end_ns;
    (void)ect_esc_tick(&c->esc, end_ns);
}

void chip_set_sm(chip_t *c, unsigned int n, uint16_t start, uint16_t length, uint8_t control, uint8_t activate)
{
    uint8_t block[8] = {0};
    assert_int_equal(chip_write(c, (uint16_t)(0x0806 + 8 * n), 0, 1), 1);
    ect_store_le16(block, start);
    ect_store_le16(block + 2, length);
    block[4] = control;
    block[6] = activate;
    assert_int_equal(chip_send(c, APWR, (uint16_t)(0x0800 + 8 * n), block, 8), 1);
}
