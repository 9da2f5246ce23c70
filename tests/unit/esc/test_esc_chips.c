/* SPDX-License-Identifier: MIT */
/* The personalities: the values that each chip reports about itself, its registers, and their write access. */
#include <stdlib.h>
#include <string.h>

#include "support/chip.h"

/* Transcribed from the manufacturers' data sheets, and from chips that were read over the bus (0x0000 to 0x0009). */
static const struct {
    const char *name;
    uint8_t information[10];
    bool led, reset_pdi, latch_mode, clock, sequential;
    unsigned int sii_bytes;
} chips[] = {
    {"et1100", {0x11, 0, 3, 0, 8, 8, 8, 0x0F, 0xFC, 0x00}, false, false, false, true, false, 8},
    {"et1200", {0x12, 1, 1, 0, 3, 4, 1, 0x0F, 0xFC, 0x01}, false, false, true, true, false, 8},
    {"lan9252", {0xC0, 2, 0, 0, 3, 4, 4, 0x1F, 0xCC, 0x01}, true, true, false, true, false, 4},
    {"lan9253", {0xC0, 3, 0, 0, 8, 8, 8, 0x1F, 0xCC, 0x01}, true, true, false, true, false, 8},
    {"xmc4800", {0x98, 1, 0, 0, 8, 8, 8, 0x0F, 0xCC, 0x01}, true, true, false, true, false, 4},
    {"np40", {0x05, 0, 1, 0, 4, 4, 16, 0x0F, 0xCC, 0x01}, true, true, false, true, false, 8},
    {"ax58100", {0xC8, 0, 0, 0, 8, 8, 9, 0x1F, 0xCC, 0x01}, true, true, false, true, false, 8},
    {"ipcore", {0x04, 4, 0, 0, 8, 8, 60, 0x0F, 0xCC, 0x11}, true, true, false, true, true, 8},
    {"ipcore-small", {0x04, 2, 0x43, 0, 3, 4, 4, 0x0F, 0x80, 0x01}, true, true, false, false, false, 4},
};

enum { CHIPS = sizeof chips / sizeof chips[0] };

static void every_name(void **state)
{
    (void)state;
    for (size_t i = 0; i < CHIPS; i++)
        assert_non_null(ect_esc_personality(chips[i].name));
    assert_non_null(ect_esc_personality_at(CHIPS - 1));
    assert_null(ect_esc_personality_at(CHIPS)); /* a chip without a row here would be untested */
    assert_null(ect_esc_personality("et1300"));
}

static void information(void **state)
{
    (void)state;
    for (size_t i = 0; i < CHIPS; i++) {
        chip_t *c = chip_new(chips[i].name);
        for (unsigned int k = 0; k < 10; k++) {
            uint8_t got = (uint8_t)chip_read(c, (uint16_t)k, 1);
            if (got != chips[i].information[k])
                fail_msg("%s: 0x%04X: expected 0x%02X, got 0x%02X", chips[i].name, k, chips[i].information[k], got);
            assert_int_equal(chip_write(c, (uint16_t)k, ~got & 0xFFu, 1), 0);
        }
        free(c);
    }
}

/* Registers that only some chips have: e the master may write it, p the microcontroller, b both. */
static const struct {
    uint16_t address;
    char writer;
    enum { ANY, LED, RESET_PDI, LATCH_MODE, CLOCK } of;
} registers[] = {
    {0x0021, 'e', ANY},        {0x0031, 'e', ANY},   {0x0040, 'e', ANY},   {0x0041, 'p', RESET_PDI},
    {0x0138, 'b', LED},        {0x0139, 'b', LED},   {0x0910, 'e', CLOCK}, {0x0920, 'e', CLOCK},
    {0x0927, 'e', CLOCK},      {0x0928, 'e', CLOCK}, {0x0930, 'e', CLOCK}, {0x0934, 'e', CLOCK},
    {0x0936, 'e', LATCH_MODE}, {0x0980, 'e', CLOCK}, {0x0981, 'e', CLOCK}, {0x0990, 'e', CLOCK},
    {0x0997, 'e', CLOCK},      {0x09A0, 'e', CLOCK}, {0x09A7, 'e', CLOCK}, {0x09A8, 'e', CLOCK},
    {0x09A9, 'e', CLOCK},
};

static bool has(size_t chip, unsigned int of)
{
    switch (of) {
    case LED:
        return chips[chip].led;
    case RESET_PDI:
        return chips[chip].reset_pdi;
    case LATCH_MODE:
        return chips[chip].latch_mode;
    case CLOCK:
        return chips[chip].clock;
    default:
        return true;
    }
}

static void expect_right(chip_t *c, size_t chip, size_t row)
{
    static uint8_t before[0x1000];
    uint16_t address = registers[row].address;
    bool there = has(chip, registers[row].of);
    bool master = there && registers[row].writer != 'p';
    bool pdi = there && registers[row].writer != 'e';
    chip_power_on(c);
    unsigned int wkc = chip_write(c, address, 0x13, 1);
    if (wkc != (master ? 1 : 0))
        fail_msg("%s: the master writes 0x%04X: expected WKC %d, got %u", chips[chip].name, address, master, wkc);
    chip_power_on(c);
    memcpy(before, c->memory, sizeof before);
    chip_pdi_write(c, address, address == 0x0041 ? 'R' : 0x13, 1);
    if ((memcmp(before, c->memory, sizeof before) != 0) != pdi)
        fail_msg("%s: the PDI writes 0x%04X: expected a change %d", chips[chip].name, address, pdi);
}

static void rights(void **state)
{
    (void)state;
    for (size_t i = 0; i < CHIPS; i++) {
        chip_t *c = chip_new(chips[i].name);
        for (size_t row = 0; row < sizeof registers / sizeof registers[0]; row++)
            expect_right(c, i, row);
        free(c);
    }
}

/* An address without a row in the data sheet cannot be written, in any chip. */
static void reserved_registers(void **state)
{
    static const uint16_t ranges[][2] = {{0x000A, 0x000F}, {0x0014, 0x001F}, {0x0032, 0x003F}, {0x0042, 0x00FF},
                                         {0x0140, 0x01FF}, {0x0914, 0x091F}, {0x092C, 0x092F}, {0x0932, 0x0933},
                                         {0x0937, 0x097F}, {0x0982, 0x098F}, {0x0998, 0x099F}, {0x09AA, 0x0EFF}};
    (void)state;
    for (size_t i = 0; i < CHIPS; i++) {
        chip_t *c = chip_new(chips[i].name);
        for (size_t k = 0; k < sizeof ranges / sizeof ranges[0]; k++) {
            for (uint16_t a = ranges[k][0]; a <= ranges[k][1]; a++) {
                uint8_t before = c->memory[a];
                if (chip_write(c, a, 0xA5, 1) != 0)
                    fail_msg("%s: the master could write 0x%04X", chips[i].name, a);
                chip_pdi_write(c, a, 0xA5, 1);
                if (c->memory[a] != before)
                    fail_msg("%s: the PDI could write 0x%04X", chips[i].name, a);
            }
        }
        free(c);
    }
}

static void absent_is_zero(void **state)
{
    (void)state;
    for (size_t i = 0; i < CHIPS; i++) {
        chip_t *c = chip_new(chips[i].name);
        for (size_t row = 0; row < sizeof registers / sizeof registers[0]; row++) {
            uint8_t byte[1] = {0x5A};
            unsigned int of = registers[row].of;
            if (has(i, of))
                continue;
            unsigned int wkc = chip_send(c, APRD, registers[row].address, byte, 1);
            bool silent = of == CLOCK || (of == LATCH_MODE && !chips[i].clock);
            if (wkc != (silent ? 0 : 1) || byte[0] != (silent ? 0x5A : 0))
                fail_msg("%s lacks 0x%04X: expected WKC %d, got %u, 0x%02X", chips[i].name, registers[row].address,
                         !silent, wkc, byte[0]);
        }
        free(c);
    }
}

static void sii_width(void **state)
{
    (void)state;
    for (size_t i = 0; i < CHIPS; i++) {
        chip_t *c = chip_new(chips[i].name);
        unsigned int got = (chip_read(c, 0x0502, 2) & 0x40) != 0 ? 8 : 4;
        if (got != chips[i].sii_bytes)
            fail_msg("%s: expected SII reads of %u bytes, got %u", chips[i].name, chips[i].sii_bytes, got);
        free(c);
    }
}

/* The effect of sequential mode: a buffer that was written out of order is not released. */
static void sequential(void **state)
{
    (void)state;
    for (size_t i = 0; i < CHIPS; i++) {
        chip_t *c = chip_new(chips[i].name);
        uint8_t data[4] = {1, 2, 3, 4};
        chip_set_sm(c, 2, 0x1000, 4, 0xA4, 1);
        assert_int_equal(chip_send(c, APWR, 0x1000, data, 1), 1);
        assert_int_equal(chip_send(c, APWR, 0x1003, data, 1), 1);
        bool violated = (c->memory[0x0815] & 0x04) != 0;
        bool taken = (ect_esc_al_event(&c->esc) & 0x0400) != 0;
        if (violated != chips[i].sequential || taken == chips[i].sequential)
            fail_msg("%s: expected a violation %d, got %d, event %d", chips[i].name, chips[i].sequential, violated,
                     taken);
        assert_int_equal(chip_send(c, APWR, 0x1000, data, 4), 1);
        assert_int_equal(c->memory[0x0815] & 0x05, 1);
        chip_set_sm(c, 2, 0x1000, 4, 0x24, 1); /* sequential mode is off */
        assert_int_equal(chip_send(c, APWR, 0x1000, data, 1), 1);
        assert_int_equal(chip_send(c, APWR, 0x1003, data, 1), 1);
        assert_int_equal(c->memory[0x0815] & 0x05, 1);
        free(c);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-001: there is a row here for every chip", every_name, NULL, NULL, NULL},
        {"CF-001: each chip reports the values of its data sheet, and neither side can write them", information, NULL,
         NULL, NULL},
        {"CF-009: registers of some chips can be written by the permitted side where they exist", rights, NULL, NULL,
         NULL},
        {"CF-009: neither side can write reserved registers, on any chip", reserved_registers, NULL, NULL, NULL},
        {"CF-008: a missing register reads 0, a register of an absent clock does not respond", absent_is_zero, NULL,
         NULL, NULL},
        {"CF-055: each chip advertises how many bytes an SII read delivers", sii_width, NULL, NULL, NULL},
        {"CF-019: in sequential mode a buffer that was not written from start to end is not released", sequential, NULL,
         NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC personalities", tests, NULL, NULL);
}
